#include <airlight/area_ltc.h>
#include <airlight/area_table.h>
#include <airlight/impulse.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host.h"
#include "table_impulse.h"

typedef struct table_options {
    const char *output;
    cli_count loss;
    cli_real g;
    cli_impulse_options impulse;
} table_options;

static const char *const loss_names[] = {"kl", "l2", "l3", "cdf-l2", NULL};
/* air_area_source, and one more. */
enum { KIND_LTC = AIR_AREA_SOURCES, KIND_IMPULSE };
static const char *const kind_names[] = {"ltsd", "mix",     "cosine", "uniform",
                                         "ltc",  "impulse", NULL};

static const cli_option table_table[] = {
    {.name = "output",
     .letter = 'o',
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(table_options, output),
     .help = "build: where the table goes; it appears whole or not at all."},
    {.name = "loss",
     .kind = CLI_CHOICE,
     .value = "LOSS",
     .choices = loss_names,
     .offset = offsetof(table_options, loss),
     .help =
         "What the fit makes small: kl, l2, l3 or cdf-l2; default kl. mix always takes cdf-l2."},
    {.name = "g",
     .kind = CLI_REAL,
     .value = "G",
     .min = -0.99,
     .max = 0.99,
     .offset = offsetof(table_options, g),
     .help = "plot: the phase function's mean cosine; default 0.4, of impulse 0."},
};

static const cli_usage table_usage = {
    .command = "table",
    .arguments = "build KIND | info FILE | plot KIND",
    .summary =
        "Fits transformed spherical distributions: ltsd and mix to Henyey and Greenstein's phase "
        "function, for `render --method arealight:ltsd|mix --area-table FILE`; ltc to GGX, for "
        "engines and the library (docs/table-format.md). To be plotted also the paper's failing "
        "sources cosine and uniform. impulse: how light that fog scatters reaches surfaces.",
    .examples = "  airlight table build ltsd --loss l3 -o ltsd-l3.json\n"
                "  airlight table build ltc -o ggx.json   # some seconds\n"
                "  airlight table build impulse --knots=-0.3,0,0.3,0.6 -o fog.impulse\n"
                "  airlight table info ltsd-l3.json\n"
                "  airlight table plot ltsd --g 0.9 > fit.csv   # cosine, phase function, fit\n",
    .argument_min = 2,
    .argument_max = 2,
};

static const cli_option impulse_table[] = {
    {.name = "bins",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 8,
     .max = 1024,
     .offset = offsetof(cli_impulse_options, bins),
     .help = "Bins of the optical distance from 0.001 to 20; default 256."},
    {.name = "angles",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 2,
     .max = 31,
     .offset = offsetof(cli_impulse_options, angles),
     .help = "Angles of a patch over 90 degrees; default 16."},
    {.name = "knots",
     .kind = CLI_TEXT,
     .value = "G,...",
     .offset = offsetof(cli_impulse_options, knots),
     .help = "Mean cosines, rising, up to 32; default 14 from -0.9 to 0.9. Those of one's media "
             "make no error."},
    {.name = "bounces",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = AIR_IMPULSE_BOUNCES_MAX,
     .offset = offsetof(cli_impulse_options, bounces),
     .help = "Scattering events that are kept, each by itself; default 10."},
    {.name = "form",
     .kind = CLI_CHOICE,
     .value = "FORM",
     .choices = cli_impulse_forms,
     .offset = offsetof(cli_impulse_options, form),
     .help = "What is kept of a patch's light: sh5 (default), sh3, zh11-energy, zh11-irradiance."},
    {.name = "paper",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_impulse_options, paper),
     .help = "Begin with the paper's layout: 8 angles, 3 knots, zh11-energy."},
};

/* ---- the three actions ---- */

static cli_exit build_ltc(cli_host *host, const char *path)
{
    static air_area_ltc_table table;
    air_area_ltc_table_fit(host->context, &table);
    return cli_host_exit(host, air_area_ltc_table_save(host->context, &table, path), path);
}

static cli_exit build(cli_host *host, const table_options *options, size_t kind)
{
    air_area_table table;
    const air_area_source source = (air_area_source)kind;
    if (options->output == NULL || (kind > AIR_AREA_SOURCE_MIX && kind < KIND_LTC)) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "table build: expected ltsd, mix, ltc or impulse, and -o FILE");
        return CLI_USAGE;
    }
    if (kind == KIND_IMPULSE) {
        return cli_impulse_build(host, &options->impulse, options->output);
    }
    if (kind == KIND_LTC) {
        return build_ltc(host, options->output);
    }
    air_area_table_fit(source, (air_area_loss)options->loss.value, &table);
    return cli_host_exit(host, air_area_table_save(host->context, &table, options->output),
                         options->output);
}

static cli_exit info_lobes(cli_host *host, const char *path)
{
    static const double shown[] = {0.0, 0.1, 0.4, 0.6, 0.9, 0.99};
    air_area_table table;
    const cli_exit result =
        cli_host_exit(host, air_area_table_load(host->context, path, &table), path);
    if (result != CLI_OK) {
        return result;
    }
    printf("kind: %s\nloss: %s\nknots: %d, |g| up to 0.99\n", kind_names[table.source],
           loss_names[table.loss], (int)AIR_AREA_KNOTS);
    for (size_t i = 0; i < sizeof shown / sizeof shown[0]; i++) {
        const air_area_lobe lobe = air_area_table_lobe(&table, shown[i]);
        printf("g %.2f: near s %.6g w %.6g, far s %.6g w %.6g\n", shown[i], lobe.s_near,
               lobe.w_near, lobe.s_far, lobe.w_far);
    }
    return CLI_OK;
}

static void info_ltc(const air_area_ltc_table *table)
{
    static const double alphas[] = {0.01, 0.1, 0.3, 0.6, 1.0}, cosines[] = {1.0, 0.7, 0.2};
    printf("kind: ltc\nknots: %d x %d, alpha from 0.001 to 1, cos_o from 1 to 0\n",
           (int)AIR_LTC_SIDE, (int)AIR_LTC_SIDE);
    for (size_t i = 0; i < sizeof alphas / sizeof alphas[0]; i++) {
        for (size_t j = 0; j < sizeof cosines / sizeof cosines[0]; j++) {
            const air_area_ltc fit = air_area_ltc_at(table, alphas[i], cosines[j]);
            printf("alpha %.2f, cos_o %.1f: xx %.5f xz %.5f zx %.5f zz %.5f, albedo %.5f\n",
                   alphas[i], cosines[j], fit.xx, fit.xz, fit.zx, fit.zz, fit.albedo);
        }
    }
}

static cli_exit info(cli_host *host, const char *path)
{
    static air_area_ltc_table ltc;
    bool is_ltc, is_impulse;
    air_status status = air_impulse_is_tables(host->context, path, &is_impulse);
    if (status != AIR_OK || is_impulse) {
        return is_impulse ? cli_impulse_info(host, path) : cli_host_exit(host, status, path);
    }
    status = air_area_table_is_ltc(host->context, path, &is_ltc);
    if (status == AIR_OK && !is_ltc) {
        return info_lobes(host, path);
    }
    if (status == AIR_OK) {
        status = air_area_ltc_table_load(host->context, path, &ltc);
    }
    if (status == AIR_OK) {
        info_ltc(&ltc);
    }
    return cli_host_exit(host, status, path);
}

/* Rows from the far pole to the peak, closer together near it. */
static cli_exit plot(const table_options *options, air_area_source source)
{
    enum { ROWS = 400 };
    const double g = options->g.set ? options->g.value : 0.4;
    const air_area_lobe lobe = air_area_fit(source, (air_area_loss)options->loss.value, g);
    printf("cosine_to_peak,phase,fit,difference\n");
    for (int i = 0; i <= ROWS; i++) {
        const double angle = acos(-1.0) * (1.0 - (double)i / ROWS), c = cos(angle);
        const double p = air_area_phase_density(g, c), d = air_area_lobe_density(source, &lobe, c);
        printf("%.9g,%.9g,%.9g,%.9g\n", c, p, d, d - p);
    }
    return CLI_OK;
}

/* ---- choosing one ---- */

static size_t find(const char *text, const char *const *names)
{
    size_t i = 0;
    while (names[i] != NULL && strcmp(names[i], text) != 0) {
        i++;
    }
    return i;
}

static cli_exit run(cli_host *host, const table_options *options, const char *action,
                    const char *subject)
{
    if (strcmp(action, "info") == 0) {
        return info(host, subject);
    }
    const size_t kind = find(subject, kind_names);
    if (kind_names[kind] == NULL) {
        cli_say(
            NULL, AIR_MESSAGE_ERROR,
            "table: kind \"%s\" is not known: expected ltsd, mix, ltc, impulse, cosine or uniform",
            subject);
        return CLI_USAGE;
    }
    if (strcmp(action, "build") == 0) {
        return build(host, options, kind);
    }
    if (strcmp(action, "plot") == 0 && kind == KIND_LTC) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "table plot: expected ltsd, mix, cosine, uniform or impulse");
        return CLI_USAGE;
    }
    if (strcmp(action, "plot") == 0 && kind == KIND_IMPULSE) {
        return cli_impulse_plot(host, &options->impulse, options->g.set ? options->g.value : 0.0);
    }
    if (strcmp(action, "plot") == 0) {
        return plot(options, (air_area_source)kind);
    }
    cli_say(NULL, AIR_MESSAGE_ERROR, "table: \"%s\" is not known: expected build, info or plot",
            action);
    return CLI_USAGE;
}

cli_exit cli_table(int argc, char **argv)
{
    table_options options = {.output = NULL};
    cli_host_options host_options = {.quiet = false};
    cli_host host = {.context = NULL};
    const cli_option_group groups[] = {
        {"Options", table_table, sizeof table_table / sizeof table_table[0], &options},
        {"Options of impulse", impulse_table, sizeof impulse_table / sizeof impulse_table[0],
         &options.impulse},
        cli_host_group(&host_options)};
    const cli_parsed parsed =
        cli_parse(&table_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed != CLI_PARSED) {
        return parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    cli_exit result = cli_host_open(&host, &host_options);
    if (result == CLI_OK) {
        result = run(&host, &options, argv[0], argv[1]);
    }
    cli_host_close(&host);
    return result;
}

#include "table_impulse.h"

#include <airlight/impulse.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const char *const cli_impulse_forms[] = {"sh5", "sh3", "zh11-energy", "zh11-irradiance", NULL};

/* Numbers between commas. */
static bool read_knots(const char *text, air_impulse_params *params)
{
    for (params->g_count = 0; params->g_count < AIR_IMPULSE_G_MAX; text++) {
        char *end;
        params->g[params->g_count++] = strtod(text, &end);
        if (end == text) {
            break;
        }
        text = end;
        if (*text == '\0') {
            return true;
        }
        if (*text != ',') {
            break;
        }
    }
    cli_say(NULL, AIR_MESSAGE_ERROR,
            "table: --knots: expected up to 32 numbers with commas between");
    return false;
}

static bool read_params(const cli_impulse_options *options, air_impulse_params *params)
{
    if (options->paper) {
        air_impulse_params_paper(params);
    } else {
        air_impulse_params_default(params);
    }
    if (options->bins.set) {
        params->bins = (size_t)options->bins.value;
    }
    if (options->angles.set) {
        params->angles = (size_t)options->angles.value;
    }
    if (options->bounces.set) {
        params->bounces = (int)options->bounces.value;
    }
    if (options->form.set) {
        params->form = (air_impulse_form)options->form.value;
    }
    return options->knots == NULL || read_knots(options->knots, params);
}

cli_exit cli_impulse_build(cli_host *host, const cli_impulse_options *options, const char *path)
{
    air_impulse_params params;
    air_impulse_tables *tables = NULL;
    if (!read_params(options, &params)) {
        return CLI_USAGE;
    }
    air_status status = air_impulse_tables_create(host->context, &params, &tables);
    if (status == AIR_ERROR_ARGUMENT) {
        return CLI_USAGE;
    }
    if (status == AIR_OK) {
        status = air_impulse_tables_save(host->context, tables, path);
    }
    air_impulse_tables_destroy(tables);
    return cli_host_exit(host, status, path);
}

/* ---- what is in a table ---- */

/* Irradiance by events first..last of a receiver that faces the emitter, which faces it. */
static double facing(const air_impulse_tables *tables, air_impulse_emitter emitter, double g,
                     int bounces, double tau)
{
    const air_impulse_medium medium = {.sigma_s = 1.0, .sigma_t = 1.0, .g = g, .bounces = bounces};
    const air_impulse_place place = {.distance = tau, .n_l = 1.0, .cos_s = 1.0};
    return air_impulse_irradiance(tables, emitter, &medium, &place);
}

cli_exit cli_impulse_info(cli_host *host, const char *path)
{
    static const double shown[] = {0.01, 0.1, 1.0, 4.0};
    air_impulse_tables *tables = NULL;
    const cli_exit result =
        cli_host_exit(host, air_impulse_tables_load(host->context, path, &tables), path);
    if (result != CLI_OK) {
        return result;
    }
    const air_impulse_params *const p = air_impulse_tables_params(tables);
    printf("kind: impulse\nform: %s\nbins: %zu, optical distance from 0.001 to 20\n"
           "angles: %zu over 90 degrees\nbounces: %d\nsize: %.1f MB\ng:",
           cli_impulse_forms[p->form], p->bins, p->angles, p->bounces,
           1e-6 * (double)air_impulse_tables_bytes(tables));
    for (size_t i = 0; i < p->g_count; i++) {
        printf(" %g", p->g[i]);
    }
    printf("\n");
    for (size_t i = 0; i < sizeof shown / sizeof shown[0]; i++) {
        printf("optical distance %g, g 0, first event and all: point %.6g %.6g, directional %.6g "
               "%.6g, area %.6g %.6g\n",
               shown[i], facing(tables, AIR_IMPULSE_POINT, 0.0, 1, shown[i]),
               facing(tables, AIR_IMPULSE_POINT, 0.0, p->bounces, shown[i]),
               facing(tables, AIR_IMPULSE_DIRECTIONAL, 0.0, 1, shown[i]),
               facing(tables, AIR_IMPULSE_DIRECTIONAL, 0.0, p->bounces, shown[i]),
               facing(tables, AIR_IMPULSE_AREA, 0.0, 1, shown[i]),
               facing(tables, AIR_IMPULSE_AREA, 0.0, p->bounces, shown[i]));
    }
    air_impulse_tables_destroy(tables);
    return CLI_OK;
}

cli_exit cli_impulse_plot(cli_host *host, const cli_impulse_options *options, double g)
{
    enum { ROWS = 200 };
    air_impulse_params params;
    air_impulse_tables *tables = NULL;
    if (!read_params(options, &params)) {
        return CLI_USAGE;
    }
    if (options->knots == NULL) {
        params.g_count = 1;
        params.g[0] = g;
    }
    const air_status status = air_impulse_tables_create(host->context, &params, &tables);
    if (status != AIR_OK) {
        return status == AIR_ERROR_ARGUMENT ? CLI_USAGE : cli_host_exit(host, status, "impulse");
    }
    printf("tau,point_1,point_all,directional_1,directional_all,area_1,area_all\n");
    for (int i = 0; i <= ROWS; i++) {
        const double tau = 1e-3 * pow(20e3, (double)i / ROWS);
        printf("%.9g", tau);
        for (int emitter = 0; emitter < AIR_IMPULSE_EMITTERS; emitter++) {
            printf(",%.9g,%.9g", facing(tables, (air_impulse_emitter)emitter, g, 1, tau),
                   facing(tables, (air_impulse_emitter)emitter, g, params.bounces, tau));
        }
        printf("\n");
    }
    air_impulse_tables_destroy(tables);
    return CLI_OK;
}

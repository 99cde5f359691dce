#include <airlight/denoise.h>
#include <stdio.h>
#include <string.h>

#include "host.h"
#include "output.h"

static const char *const image_extensions[] = {".exr", ".png", ".pfm", NULL};

typedef struct denoise_options {
    cli_count levels;
    cli_real scale;
    bool no_albedo;
    cli_count terms;
} denoise_options;

/* in the order of air_term */
static const char *const term_names[] = {"S0", "S+", "M1", "M2", NULL};

static const cli_option denoise_table[] = {
    {.name = "levels",
     .kind = CLI_COUNT,
     .value = "N",
     .max = AIR_DENOISE_MAX_LEVELS,
     .offset = offsetof(denoise_options, levels),
     .help = "Passes with pixels 1, 2, 4, ... apart; default 3."},
    {.name = "scale",
     .kind = CLI_REAL,
     .value = "S",
     .min = 1e-6,
     .max = 1.0,
     .offset = offsetof(denoise_options, scale),
     .help = "Shrinks the filter: 1 is all of it, towards 0 nothing is left; default 1."},
    {.name = "no-albedo",
     .kind = CLI_FLAG,
     .offset = offsetof(denoise_options, no_albedo),
     .help = "Filter what surfaces reflect, not what they receive."},
    {.name = "terms",
     .kind = CLI_SET,
     .value = "LIST",
     .choices = term_names,
     .offset = offsetof(denoise_options, terms),
     .help = "Filter only these parts of the light, with commas between: S0, S+, M1, M2; default "
             "all. Sunbeams by method collimated have no noise in M1: leave it out. Needs "
             "--layers."},
};

static const cli_usage denoise_usage = {
    .command = "denoise",
    .arguments = "IN.exr OUT",
    .summary = "Smooths a picture by what its guides see: depth, normal and albedo of the first "
               "surface, as `airlight render --guides` writes them. With --layers, "
               "too, light on surfaces, light in the air and what is seen directly are kept apart, "
               "which looks better.",
    .examples = "  airlight render room.glb --spp 16 --guides --layers -o room.exr\n"
                "  airlight denoise room.exr smooth.exr\n"
                "  airlight denoise room.exr smooth.png --levels 5\n"
                "  airlight denoise beams.exr smooth.exr --terms S+,M2 --scale 0.5\n",
    .argument_min = 2,
    .argument_max = 2,
};

typedef struct denoise_run {
    denoise_options options;
    cli_output_options output;
    cli_host_options host_options;
    cli_host host;
} denoise_run;

static cli_exit run_denoise(denoise_run *run, const char *in, const char *out)
{
    cli_host *const host = &run->host;
    const cli_list paths = {.count = 1, .items = {out}};
    air_denoise_params params;
    air_image *image = NULL, *smooth = NULL;
    air_denoise_params_default(&params);
    params.levels = run->options.levels.set ? (uint32_t)run->options.levels.value : params.levels;
    params.scale = run->options.scale.set ? (float)run->options.scale.value : params.scale;
    params.albedo = !run->options.no_albedo;
    params.terms = run->options.terms.set ? (uint32_t)run->options.terms.value : params.terms;
    cli_exit result = cli_host_open(host, &run->host_options);
    if (result == CLI_OK) {
        result = cli_output_check(host, &paths, image_extensions);
    }
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_image_load(host->context, in, &image), in);
    }
    if (result == CLI_OK) {
        host->about = in;
        result = cli_host_exit(host, air_image_denoise(host->context, image, &params, &smooth), in);
        host->about = NULL;
    }
    if (result == CLI_OK) {
        const float exposure_ev = cli_output_exposure(&run->output, smooth);
        result = cli_output_image(host, &run->output, out, smooth, exposure_ev);
    }
    if (result == CLI_OK) {
        cli_report(&host->progress, "wrote %s", out);
    }
    air_image_destroy(smooth);
    air_image_destroy(image);
    return result;
}

cli_exit cli_denoise(int argc, char **argv)
{
    denoise_run run = {.options = {.no_albedo = false}};
    const cli_option_group groups[] = {
        {"Filter", denoise_table, sizeof denoise_table / sizeof denoise_table[0], &run.options},
        cli_picture_group(&run.output),
        cli_host_group(&run.host_options)};
    const cli_parsed parsed =
        cli_parse(&denoise_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed != CLI_PARSED) {
        return parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    const cli_exit result = run_denoise(&run, argv[0], argv[1]);
    cli_host_close(&run.host);
    return result;
}

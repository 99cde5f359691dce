/* bake_options.h: the options of `airlight bake`, and the parameters they make. */
#ifndef AIR_CLI_BAKE_OPTIONS_H
#define AIR_CLI_BAKE_OPTIONS_H

#include <airlight/bake.h>

#include "host.h"

typedef struct cli_bake_options {
    const char *output;
    cli_count media, spp, seed, bounces, quality;
    cli_count cache_resolution, cache_samples, impulse_bounces;
    bool impulse_literal;
    cli_count targets, uv, mesh_size, page_size, padding, dilate;
    cli_real texels_per_metre, chart_angle;
    bool directional, no_final_gather, no_denoise, no_stitch, full, no_resume;
    cli_list probes;
    const char *gltf, *godot, *bevy, *rgbm, *impulse_tables;
    cli_count gltf_show;
    cli_real rgbm_range;
} cli_bake_options;

enum { CLI_BAKE_GROUPS = 4 };
/* Fills groups[0..CLI_BAKE_GROUPS). */
void cli_bake_groups(cli_bake_options *options, cli_option_group *groups);

/* What --probes ask for. */
typedef struct cli_probes {
    size_t count;
    air_probe_request requests[CLI_LIST_MAX];
    float *positions[CLI_LIST_MAX]; /* owned */
} cli_probes;

/* Fills params from the options; probes belong to *probes. What is wrong has been printed. */
cli_exit cli_bake_params(cli_host *host, const cli_bake_options *options, cli_probes *probes,
                         air_bake_params *params);
void cli_probes_finish(cli_probes *probes);

#endif

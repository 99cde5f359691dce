/* render_options.h: the options of `airlight render` and what they mean for air_render. */
#ifndef AIR_CLI_RENDER_OPTIONS_H
#define AIR_CLI_RENDER_OPTIONS_H

#include <airlight/render.h>

#include "frames.h"
#include "host.h"
#include "ordinates_options.h"
#include "scene_options.h"

typedef struct cli_render_options {
    cli_count quality, spp, seed, max_depth, filter, pattern, variance, tile_size;
    cli_count rule, nodes, shadow_samples, candidates; /* of arealight */
    const char *area_table, *lightmap;
    cli_ordinates_options ordinates;
    cli_counts samples;
    cli_real time, write_partial;
    cli_count terms;
    const char *method, *camera;
    cli_count width, height;
    cli_counts crop;
    bool layers, guides, json, stats;
    const char *frames;
    cli_real orbit;
    bool no_warm_start;
    cli_frames sequence; /* what frames says, once cli_render_check has read it */
} cli_render_options;

enum { CLI_RENDER_GROUPS = 6 };

void cli_render_groups(cli_render_options *options, cli_option_group out_groups[CLI_RENDER_GROUPS]);

/* What can be said against the options before a scene is loaded; prints it. */
cli_exit cli_render_check(cli_render_options *options);

/* Fills *params (the callbacks stay at their defaults) for this camera. Prints what does not fit:
 * exit code 2. */
cli_exit cli_render_params(cli_host *host, const cli_render_options *options,
                           const cli_camera *camera, air_render_params *params);

/* "S0,S+,M1" for a mask of terms. */
void cli_render_term_list(uint32_t terms, char *out, size_t size);
const char *cli_render_filter_name(air_filter filter);

#endif

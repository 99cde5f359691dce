/* ordinates_options.h: the options of method ordinates in `airlight render`. */
#ifndef AIR_CLI_ORDINATES_OPTIONS_H
#define AIR_CLI_ORDINATES_OPTIONS_H

#include <airlight/render.h>

#include "host.h"
#include "options.h"

typedef struct cli_ordinates_options {
    cli_count cells, directions, patches, bands, sweeps, steps, march;
    cli_counts angles;
    bool no_prefilter, importance, no_residuum, no_bilateral;
} cli_ordinates_options;

cli_option_group cli_ordinates_group(cli_ordinates_options *options);

/* What can be said against the options before a scene is loaded; prints it. quality_bands: those
 * of the quality asked for, where there are no --bands. */
cli_exit cli_ordinates_check(const cli_ordinates_options *options, int quality_bands);

/* Puts what the options say in place of what *settings has. */
void cli_ordinates_set(const cli_ordinates_options *options, air_ordinates_settings *settings);

#endif

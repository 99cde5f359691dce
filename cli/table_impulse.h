/* table_impulse.h: `airlight table` for tables of impulse responses. */
#ifndef AIR_CLI_TABLE_IMPULSE_H
#define AIR_CLI_TABLE_IMPULSE_H

#include "host.h"

typedef struct cli_impulse_options {
    cli_count bins, angles, bounces, form;
    const char *knots;
    bool paper;
} cli_impulse_options;

extern const char *const cli_impulse_forms[]; /* by air_impulse_form; NULL at the end */

cli_exit cli_impulse_build(cli_host *host, const cli_impulse_options *options, const char *path);
cli_exit cli_impulse_info(cli_host *host, const char *path);
/* Irradiance towards the emitter against the optical distance. */
cli_exit cli_impulse_plot(cli_host *host, const cli_impulse_options *options, double g);

#endif

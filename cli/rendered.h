/* rendered.h: what `airlight render` says of a picture that is done. */
#ifndef AIR_CLI_RENDERED_H
#define AIR_CLI_RENDERED_H

#include <airlight/render.h>

#include "host.h"
#include "output.h"

typedef struct cli_rendered {
    const char *scene_path;
    const cli_list *outputs;
    int64_t frame;      /* or AIR_FRAME_NONE */
    const char *prefix; /* "frame 7: ", or "" */
    const air_render_params *params;
    const air_film *film;
    cli_written written;
    bool interrupted;
    double load_s, render_s, write_s;
} cli_rendered;

/* On stderr; stats: at length. */
void cli_rendered_report(cli_host *host, const cli_rendered *rendered, bool stats);
/* An object on stdout, on one line if it is one of several frames. */
void cli_rendered_json(const cli_host *host, const cli_rendered *rendered);

#endif

/* render_state.h: what lives from picture to picture. */
#ifndef AIR_RENDER_RENDER_STATE_H
#define AIR_RENDER_RENDER_STATE_H

#include <stdatomic.h>

#include "airlight/render.h"
#include "render/ordinates/past.h"

struct air_render_state {
    air_context *context;
    atomic_bool in_use;
    ord_past ordinates;
};

/* For the time of a render; NULL: nothing to do. AIR_ERROR_ARGUMENT: it is another context's, or in
 * use. */
air_status air_render_state_enter(air_context *context, air_render_state *state);
void air_render_state_leave(air_render_state *state);

#endif

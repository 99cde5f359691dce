/* render_state.c: see render_state.h. */
#include "render/render_state.h"

#include "core/host.h"

air_status air_render_state_create(air_context *context, air_render_state **out_state)
{
    *out_state = air_allocate(context, 1, sizeof **out_state);
    if (*out_state == NULL) {
        return air_fail_memory(context, "render state");
    }
    (*out_state)->context = context;
    atomic_init(&(*out_state)->in_use, false);
    ord_past_init(context, &(*out_state)->ordinates);
    return AIR_OK;
}

void air_render_state_destroy(air_render_state *state)
{
    if (state != NULL) {
        ord_past_finish(&state->ordinates);
        air_free(state->context, state);
    }
}

air_status air_render_state_enter(air_context *context, air_render_state *state)
{
    if (state == NULL) {
        return AIR_OK;
    }
    if (state->context != context) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "the render state was made with another context: expected one for each");
    }
    if (atomic_exchange(&state->in_use, true)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "the render state is in use: expected one render with it at a time");
    }
    return AIR_OK;
}

void air_render_state_leave(air_render_state *state)
{
    if (state != NULL) {
        atomic_store(&state->in_use, false);
    }
}

/* respond.h: the paper's model of media in a bake: responses of infinite homogeneous media along
 * the segments of surface paths [Dubouchet2019].
 *
 * A segment through several media, or through varying density, is taken for one through as much of
 * the medium with the most optical depth on it as makes the same optical depth. */
#ifndef AIR_BAKE_RESPOND_H
#define AIR_BAKE_RESPOND_H

#include "airlight/impulse.h"
#include "path/path.h"

typedef struct air_responder air_responder;

typedef struct air_responder_params {
    bool literal; /* tables, forms and rules as the paper has them */
    int bounces;
    const air_impulse_tables *tables; /* borrowed; NULL: built */
} air_responder_params;

air_status air_responder_create(air_context *context, const air_snapshot *snapshot,
                                const air_responder_params *params, air_responder **out_responder);
void air_responder_destroy(air_responder *responder); /* NULL is legal */

/* For air_path_settings.respond. */
air_path_respond air_responder_hooks(const air_responder *responder);

#endif

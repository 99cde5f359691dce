/* probes.h: probes of a request: where they are, and what they become. */
#ifndef AIR_BAKE_PROBES_H
#define AIR_BAKE_PROBES_H

#include "airlight/bake.h"
#include "bake/sites.h"

/* Places the probes of a request; the set's name and positions are allocated, its layers and
 * validity too. AIR_ERROR_ARGUMENT names the request and what is wrong. */
air_status air_probes_place(air_context *context, const air_snapshot *snapshot,
                            const air_probe_request *request, air_probe_set *out);

/* air_site_list.draw, with an air_probe_set as user. */
bool air_probe_draw(const void *user, size_t site, const float u[2], air_path_receiver *out);

/* Copies the records of a list of 9 coefficients, layer by layer, into the set. */
void air_probes_take(const air_site_list *list, air_probe_set *set);

#endif

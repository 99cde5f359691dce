/* medium_record.h: a medium's description as a scene keeps it. */
#ifndef AIR_SCENE_MEDIUM_RECORD_H
#define AIR_SCENE_MEDIUM_RECORD_H

#include "scene/record.h"

typedef struct air_medium_record {
    air_record base;
    air_medium_desc desc; /* name is the record's; arrays are owned */
} air_medium_record;

/* Checks and copies a description; grid handles are not looked at. */
air_status air_medium_record_create(air_context *context, const air_medium_desc *desc,
                                    air_record **out_record);

/* The grids it refers to, AIR_NONE among them; returns how many links were written. */
size_t air_medium_links(const air_medium_desc *desc, air_link out_links[AIR_MAX_LINKS]);

/* Are two descriptions the same but for the name, as far as their kinds of density and boundary
 * look? */
bool air_medium_equal(const air_medium_desc *a, const air_medium_desc *b);

#endif

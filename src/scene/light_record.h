/* light_record.h: a light's description as a scene keeps it. */
#ifndef AIR_SCENE_LIGHT_RECORD_H
#define AIR_SCENE_LIGHT_RECORD_H

#include "airlight/light.h"
#include "scene/record.h"

typedef struct air_light_record {
    air_record base;
    air_light_desc desc; /* name is the record's; windows is the array below; vertices are owned */
    air_gobo_window *windows; /* owned, with their vertices */
} air_light_record;

/* What files and reports call the kinds of lights, in the order of air_light_kind. */
enum { AIR_LIGHT_KINDS = AIR_LIGHT_PROJECTOR + 1 };
extern const char *const air_light_kind_names[AIR_LIGHT_KINDS];

/* Checks and copies a description; the image handle is not looked at. */
air_status air_light_record_create(air_context *context, const air_light_desc *desc,
                                   air_record **out_record);

/* The image it refers to, perhaps AIR_NONE; returns how many links were written. */
size_t air_light_links(const air_light_desc *desc, air_link out_links[AIR_MAX_LINKS]);

/* Are two descriptions the same but for the name, as far as their kind looks? */
bool air_light_equal(const air_light_desc *a, const air_light_desc *b);

#endif

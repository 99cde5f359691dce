/* scene.h: the state of an editable scene. */
#ifndef AIR_SCENE_SCENE_H
#define AIR_SCENE_SCENE_H

#include "airlight/scene.h"
#include "scene/record.h"

/* An object. */
typedef struct air_slot {
    air_handle handle;
    size_t users; /* how many other objects refer to it */
    air_record *record;
} air_slot;

/* The objects of one kind in the order they were added, which is that of their handles: numbers are
 * not used twice. */
typedef struct air_slot_list {
    air_slot *slots;
    size_t count, capacity;
    uint32_t last_number;
} air_slot_list;

struct air_scene {
    air_context *context;
    air_slot_list lists[AIR_OBJECT_KIND_COUNT];
    air_snapshot *last; /* what the last commit made, retained; NULL before the first */
    char *source;
    air_units light_units, emissive_units;
    int64_t frame; /* AIR_FRAME_NONE: none */
    char **warnings;
    size_t warning_count;
};

/* The index of the slot of a handle of that kind, SIZE_MAX if there is none. */
static inline size_t air_slot_find(const air_slot_list *list, air_handle handle)
{
    return air_handle_find(list->slots, list->count, sizeof(air_slot), handle);
}

#endif

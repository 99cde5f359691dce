/* shared.h: what a snapshot holds on to and may share with other snapshots: the records of the
 * scene's objects, and the parts that are costly to make. */
#ifndef AIR_SCENE_SHARED_H
#define AIR_SCENE_SHARED_H

#include "scene/camera.h"
#include "scene/light_record.h"
#include "scene/material.h"
#include "scene/medium_record.h"
#include "scene/mesh.h"
#include "scene/snapshot.h"

/* The accelerator, and the meshes it was built from. */
typedef struct air_accelerator_part {
    air_record base;
    void (*destroy)(void *accelerator);
    void *accelerator;
    air_ray_mesh *meshes;
    air_world_mesh **worlds; /* retained: they own the arrays of meshes */
    size_t count;
} air_accelerator_part;

/* The media, and the records they were built from. Their grids are held by every snapshot that
 * shares the part. */
typedef struct air_media_part {
    air_record base;
    air_media media;
    air_medium_record **sources; /* retained */
    size_t count;
} air_media_part;

/* An emissive mesh in a light table. */
typedef struct air_emitter {
    air_mesh_record *mesh;         /* retained */
    air_material_record *material; /* retained */
    uint32_t mask;
    uint32_t first_entry;
} air_emitter;

/* The light table, and what it was built from. */
typedef struct air_lights_part {
    air_record base;
    air_light_table table;
    air_light_record **sources; /* retained */
    size_t count;
    air_emitter *emitters;
    size_t emitter_count;
    float bounds_min[3], bounds_max[3];
} air_lights_part;

/* An object as a snapshot holds it. */
typedef struct air_held {
    air_handle handle;
    air_record *record; /* retained */
} air_held;

struct air_shared {
    air_held *held[AIR_OBJECT_KIND_COUNT]; /* in the order of handles */
    size_t held_count[AIR_OBJECT_KIND_COUNT];
    air_record *framed;                /* the camera that commit made, or NULL; retained */
    air_mesh *meshes;                  /* what the snapshot's mesh pointers point to */
    air_accelerator_part *accelerator; /* retained like the next two; NULL without meshes */
    air_media_part *media;
    air_lights_part *lights;
    _Atomic(air_record *) *shadows; /* per explicit light: its shadow tree once asked for
                                       (shadows.h), else NULL; retained */
    size_t shadow_count;
};

/* The index of a held object, SIZE_MAX if there is none of that handle. */
size_t air_shared_find(const struct air_shared *shared, air_object_kind kind, air_handle handle);

/* Releases everything held and frees the structure; NULL and half-filled ones are legal. */
void air_shared_destroy(air_context *context, struct air_shared *shared);

/* Have two records of one kind the same content, names aside? */
bool air_record_equal(air_object_kind kind, const air_record *a, const air_record *b);

/* Is an emissive mesh the same light in both? */
bool air_emitter_equal(const air_emitter *a, const air_emitter *b);

/* Each sets one part of a snapshot whose records, materials and meshes are filled in: makes it, or
 * retains that of `previous` (may be NULL) if it was made from the same. Lights also need the
 * bounds. */
air_status air_snapshot_set_accelerator(air_snapshot *snapshot, const air_snapshot *previous);
air_status air_snapshot_set_media(air_snapshot *snapshot, const air_snapshot *previous);
air_status air_snapshot_set_lights(air_snapshot *snapshot, const air_snapshot *previous);
/* Needs all the others. */
air_status air_snapshot_set_shadows(air_snapshot *snapshot, const air_snapshot *previous);

/* What changed from one snapshot to the next: the or of air_dirty. previous NULL: everything. */
uint32_t air_snapshot_dirty(const air_snapshot *previous, const air_snapshot *next);

#endif

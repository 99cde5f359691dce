#include "scene/shared.h"

size_t air_shared_find(const struct air_shared *shared, air_object_kind kind, air_handle handle)
{
    return air_handle_find(shared->held[kind], shared->held_count[kind], sizeof(air_held), handle);
}

void air_shared_destroy(air_context *context, struct air_shared *shared)
{
    if (shared == NULL)
        return;
    /* parts first: they borrow from the records */
    for (size_t i = 0; shared->shadows != NULL && i < shared->shadow_count; ++i)
        air_record_release(atomic_load(&shared->shadows[i]));
    air_free(context, shared->shadows);
    air_record_release((air_record *)shared->lights);
    air_record_release((air_record *)shared->media);
    air_record_release((air_record *)shared->accelerator);
    air_free(context, shared->meshes);
    air_record_release(shared->framed);
    for (size_t kind = 0; kind < AIR_OBJECT_KIND_COUNT; ++kind) {
        for (size_t i = 0; shared->held[kind] != NULL && i < shared->held_count[kind]; ++i)
            air_record_release(shared->held[kind][i].record);
        air_free(context, shared->held[kind]);
    }
    air_free(context, shared);
}

static bool mesh_equal(const air_mesh_record *a, const air_mesh_record *b)
{
    return a->material == b->material && a->camera_visible == b->camera_visible &&
           a->casts_shadow == b->casts_shadow && a->flip_normals == b->flip_normals &&
           air_mesh_place_equal(a, b) && air_geometry_equal(a->geometry, b->geometry);
}

bool air_record_equal(air_object_kind kind, const air_record *a, const air_record *b)
{
    if (a == b)
        return true;
    switch (kind) {
    case AIR_OBJECT_MATERIAL:
        return air_material_equal(&((const air_material_record *)a)->desc,
                                  &((const air_material_record *)b)->desc);
    case AIR_OBJECT_MESH:
        return mesh_equal((const air_mesh_record *)a, (const air_mesh_record *)b);
    case AIR_OBJECT_MEDIUM:
        return air_medium_equal(&((const air_medium_record *)a)->desc,
                                &((const air_medium_record *)b)->desc);
    case AIR_OBJECT_LIGHT:
        return air_light_equal(&((const air_light_record *)a)->desc,
                               &((const air_light_record *)b)->desc);
    case AIR_OBJECT_CAMERA:
        return air_camera_equal(&((const air_camera_record *)a)->desc,
                                &((const air_camera_record *)b)->desc);
    case AIR_OBJECT_TEXTURE: /* never replaced */
    case AIR_OBJECT_GRID:    /* too large to be looked through: a new one is another one */
    case AIR_OBJECT_KIND_COUNT:
        break;
    }
    return false;
}

bool air_emitter_equal(const air_emitter *a, const air_emitter *b)
{
    return a->mask == b->mask && a->mesh->flip_normals == b->mesh->flip_normals &&
           (a->mesh->world == b->mesh->world ||
            (air_mesh_place_equal(a->mesh, b->mesh) &&
             air_geometry_equal(a->mesh->geometry, b->mesh->geometry))) &&
           (a->material == b->material ||
            air_material_emission_equal(&a->material->desc, &b->material->desc));
}

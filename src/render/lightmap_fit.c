#include "render/lightmap_fit.h"

#include <string.h>

#include "lightmap/check.h"

static const char *text_of(const char *text) { return text != NULL ? text : ""; }

static const char *scene_of(const char *path)
{
    return path != NULL && path[0] != '\0' ? path : "a scene without a file";
}

/* "lightmap of A: mesh 3 "floor" WHAT in B" */
static air_status differs(const air_lightmap *lightmap, const air_snapshot *snapshot, size_t index,
                          const char *what)
{
    const air_lightmap_mesh *mesh = &lightmap->meshes[index];
    return air_fail(snapshot->context, AIR_ERROR_ARGUMENT,
                    "lightmap of %s: mesh %zu \"%s\" %s in %s: bake that scene anew",
                    scene_of(lightmap->scene), index, text_of(mesh->name), what,
                    scene_of(snapshot->source));
}

/* Is the cut the mesh's: the same corners in the same places? */
static bool is_cut_of(const air_lightmap_mesh *cut, const air_mesh *mesh)
{
    for (size_t i = 0; i < 3 * cut->triangle_count; i++) {
        const uint32_t source = cut->sources[cut->indices[i]];
        if (source >= mesh->vertex_count) {
            return false;
        }
        const float *there = mesh->positions + 3 * (size_t)mesh->indices[i];
        const float *here = mesh->positions + 3 * (size_t)source;
        if (here[0] != there[0] || here[1] != there[1] || here[2] != there[2]) {
            return false;
        }
    }
    return true;
}

static air_status fit_mesh(const air_lightmap *lightmap, const air_snapshot *snapshot, size_t index)
{
    const air_lightmap_mesh *mesh = &lightmap->meshes[index];
    const air_mesh *own = snapshot->meshes[index];
    if (mesh->mesh != index || strcmp(text_of(mesh->name), text_of(own->name)) != 0) {
        return air_fail(snapshot->context, AIR_ERROR_ARGUMENT,
                        "lightmap of %s: mesh %zu is \"%s\", in %s it is \"%s\": bake that scene "
                        "anew",
                        scene_of(lightmap->scene), (size_t)mesh->mesh, text_of(mesh->name),
                        scene_of(snapshot->source), text_of(own->name));
    }
    if (mesh->page < 0) {
        return AIR_OK;
    }
    if (mesh->sources == NULL) {
        return own->uv[1] != NULL ? AIR_OK
                                  : differs(lightmap, snapshot, index, "has no TEXCOORD_1");
    }
    if (mesh->triangle_count != own->triangle_count) {
        return air_fail(snapshot->context, AIR_ERROR_ARGUMENT,
                        "lightmap of %s: mesh %zu \"%s\" has %zu triangles, in %s it has %zu: bake "
                        "that scene anew",
                        scene_of(lightmap->scene), index, text_of(mesh->name), mesh->triangle_count,
                        scene_of(snapshot->source), own->triangle_count);
    }
    return is_cut_of(mesh, own) ? AIR_OK
                                : differs(lightmap, snapshot, index, "has other triangles");
}

air_status air_lightmap_fit(const air_lightmap *lightmap, const air_snapshot *snapshot)
{
    air_context *context = snapshot->context;
    air_status status = air_lightmap_check(context, lightmap, "lightmap", AIR_ERROR_ARGUMENT);
    if (status != AIR_OK) {
        return status;
    }
    if (lightmap->page_count == 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "lightmap of %s: it has no pages, so there is nothing to show on surfaces",
                        scene_of(lightmap->scene));
    }
    if (lightmap->mesh_count != snapshot->mesh_count) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "lightmap of %s: it is of %zu meshes, %s has %zu: bake that scene anew",
                        scene_of(lightmap->scene), lightmap->mesh_count, scene_of(snapshot->source),
                        snapshot->mesh_count);
    }
    for (size_t i = 0; i < lightmap->mesh_count && status == AIR_OK; i++) {
        status = fit_mesh(lightmap, snapshot, i);
    }
    return status;
}

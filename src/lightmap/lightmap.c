/* lightmap.c: a lightmap's life, and the names of its layers. */
#include "airlight/lightmap.h"

#include "core/host.h"

const char *air_light_layer_name(air_light_layer layer)
{
    static const char *const names[AIR_LAYER_COUNT] = {"direct", "indirect", "media"};
    return (unsigned)layer < AIR_LAYER_COUNT ? names[layer] : "";
}

air_status air_lightmap_create(air_context *context, air_lightmap **out_lightmap)
{
    *out_lightmap = NULL;
    air_lightmap *lightmap = air_allocate(context, 1, sizeof *lightmap);
    if (lightmap == NULL) {
        return air_fail_memory(context, "lightmap");
    }
    lightmap->context = context;
    lightmap->scene = air_string_copy(context, "");
    lightmap->media = air_string_copy(context, "none");
    if (lightmap->scene == NULL || lightmap->media == NULL) {
        air_lightmap_destroy(lightmap);
        return air_fail_memory(context, "lightmap");
    }
    *out_lightmap = lightmap;
    return AIR_OK;
}

static void free_layers(air_context *context, float *layers[AIR_LAYER_COUNT])
{
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        air_free(context, layers[k]);
    }
}

void air_lightmap_destroy(air_lightmap *lightmap)
{
    if (lightmap == NULL) {
        return;
    }
    air_context *context = lightmap->context;
    for (size_t i = 0; lightmap->pages != NULL && i < lightmap->page_count; i++) {
        air_image_destroy(lightmap->pages[i]);
    }
    for (size_t i = 0; lightmap->meshes != NULL && i < lightmap->mesh_count; i++) {
        air_lightmap_mesh *mesh = &lightmap->meshes[i];
        air_free(context, mesh->name);
        air_free(context, mesh->sources);
        air_free(context, mesh->uv);
        air_free(context, mesh->indices);
    }
    for (size_t i = 0; lightmap->vertex_lights != NULL && i < lightmap->vertex_light_count; i++) {
        air_vertex_light *light = &lightmap->vertex_lights[i];
        air_free(context, light->name);
        free_layers(context, light->layers);
    }
    for (size_t i = 0; lightmap->probe_sets != NULL && i < lightmap->probe_set_count; i++) {
        air_probe_set *set = &lightmap->probe_sets[i];
        air_free(context, set->name);
        air_free(context, set->positions);
        air_free(context, set->validity);
        free_layers(context, set->layers);
    }
    air_free(context, lightmap->pages);
    air_free(context, lightmap->meshes);
    air_free(context, lightmap->vertex_lights);
    air_free(context, lightmap->probe_sets);
    air_free(context, lightmap->scene);
    air_free(context, lightmap->media);
    air_free(context, lightmap);
}

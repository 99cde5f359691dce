/* bevy.c: lightmaps for Bevy: KTX 2 and the rectangles of its `Lightmap` component
 * (docs/lightmap-engines.md). */
#include <math.h>
#include <stdio.h>

#include "image/staging.h"
#include "lightmap/check.h"
#include "lightmap/engine.h"
#include "lightmap/place.h"

enum { VERSION = 1, NAME = 64 };

/* Lumens per watt: what takes W/(m^2 sr) to the nits that Bevy's light is counted in. */
static const double exposure = 683.0;

/* Bevy packs the rectangle into 16 bits per number. */
static air_status check_rectangle(air_context *context, const air_lightmap_mesh *mesh, size_t index)
{
    for (size_t k = 0; k < 2; k++) {
        const float low = mesh->offset[k], high = mesh->offset[k] + mesh->scale[k];
        if (!(low >= 0.0f && high >= 0.0f && low <= 1.0f && high <= 1.0f)) {
            return air_fail(context, AIR_ERROR_UNSUPPORTED,
                            "mesh %zu (%s) covers %g to %g of its page, Bevy keeps [0, 1] only",
                            index, mesh->name != NULL ? mesh->name : "", (double)low, (double)high);
        }
    }
    return AIR_OK;
}

static void image_name(char name[NAME], size_t page)
{
    (void)snprintf(name, NAME, "lightmap-%zu.ktx2", page);
}

static air_status add_meshes(air_context *context, const air_lightmap *lightmap, json_t *list)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < lightmap->mesh_count && status == AIR_OK; i++) {
        const air_lightmap_mesh *mesh = &lightmap->meshes[i];
        char name[NAME];
        if (mesh->page < 0) {
            continue;
        }
        json_t *object = json_object();
        image_name(name, (size_t)mesh->page);
        air_lightmap_name_mesh(object, mesh);
        json_object_set_new(object, "image", json_string(name));
        if (mesh->sources == NULL) {
            json_object_set_new(object, "uv_rect", air_lightmap_rectangle(mesh));
            status = check_rectangle(context, mesh, i);
        } else {
            json_object_set_new(object, "uv_rect", json_null());
        }
        json_array_append_new(list, object);
    }
    return status;
}

static air_status add_pages(air_staging *staging, const air_lightmap *lightmap)
{
    air_status status = AIR_OK;
    air_image_save_params params;
    air_image_save_params_default(&params);
    params.half = true;
    for (size_t i = 0; i < lightmap->page_count && status == AIR_OK; i++) {
        air_image *image = NULL;
        char name[NAME];
        image_name(name, i);
        status = air_lightmap_page_radiance(staging->context, lightmap->pages[i], &image);
        if (status == AIR_OK) {
            status = air_staging_add_image(staging, name, image, &params);
        }
        air_image_destroy(image);
    }
    return status;
}

air_status air_lightmap_save_bevy(air_context *context, const air_lightmap *lightmap,
                                  const char *folder)
{
    air_status status = air_lightmap_check(context, lightmap, folder, AIR_ERROR_ARGUMENT);
    if (status != AIR_OK) {
        return status;
    }
    json_t *root = json_object(), *meshes = json_array();
    air_staging staging;
    json_object_set_new(root, "airlight_bevy", json_integer(VERSION));
    json_object_set_new(root, "units", json_string("irradiance / pi, W/(m^2 sr)"));
    json_object_set_new(root, "lightmap_exposure", json_real(exposure));
    json_object_set_new(root, "photometric", json_boolean(lightmap->photometric));
    json_object_set_new(root, "meshes", meshes);
    status = add_meshes(context, lightmap, meshes);
    if (status != AIR_OK) {
        json_decref(root);
        return status;
    }
    status = air_staging_begin(context, folder, &staging);
    if (status == AIR_OK) {
        status = add_pages(&staging, lightmap);
    }
    if (status == AIR_OK) {
        status = air_staging_add_json(&staging, "bevy.json", json_incref(root));
    }
    if (status == AIR_OK) {
        status = air_staging_commit(&staging);
    }
    json_decref(root);
    air_staging_finish(&staging);
    return status;
}

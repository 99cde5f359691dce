/* engine.c: what the writers for engines share. */
#include "lightmap/engine.h"

#include "lightmap/check.h"
#include "lightmap/place.h"

static const float one_over_pi = 0.318309886183790672f;

air_status air_lightmap_page_radiance(air_context *context, const air_image *page,
                                      air_image **out_image)
{
    const size_t width = air_image_width(page), height = air_image_height(page);
    const float *planes[3];
    *out_image = NULL;
    if (!air_lightmap_planes(page, "", planes)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "lightmap: a page has no channels R, G, B");
    }
    const air_status status =
        air_image_create(context, width, height, 3, air_lightmap_colours, out_image);
    for (size_t c = 0; c < 3 && status == AIR_OK; c++) {
        float *out = air_image_plane(*out_image, c);
        for (size_t i = 0; i < width * height; i++) {
            out[i] = planes[c][i] * one_over_pi;
        }
    }
    return status;
}

float air_lightmap_peak(const air_lightmap *lightmap)
{
    float peak = 0.0f;
    for (size_t p = 0; p < lightmap->page_count; p++) {
        const air_image *page = lightmap->pages[p];
        const float *planes[3];
        const bool whole = air_lightmap_planes(page, "", planes);
        const size_t count = whole ? air_image_width(page) * air_image_height(page) : 0;
        for (size_t i = 0; i < 3 * count; i++) {
            const float value = planes[i % 3][i / 3];
            peak = value > peak ? value : peak;
        }
    }
    return peak * one_over_pi;
}

void air_lightmap_name_mesh(json_t *object, const air_lightmap_mesh *mesh)
{
    json_object_set_new(object, "name", air_place_text(mesh->name != NULL ? mesh->name : ""));
    json_object_set_new(object, "node", json_integer(mesh->node));
    json_object_set_new(object, "primitive", json_integer(mesh->primitive));
}

json_t *air_lightmap_rectangle(const air_lightmap_mesh *mesh)
{
    json_t *rectangle = json_object();
    const float largest[2] = {mesh->offset[0] + mesh->scale[0], mesh->offset[1] + mesh->scale[1]};
    json_object_set_new(rectangle, "min", air_place_numbers(mesh->offset, 2));
    json_object_set_new(rectangle, "max", air_place_numbers(largest, 2));
    return rectangle;
}

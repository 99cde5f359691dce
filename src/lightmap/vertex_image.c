/* vertex_image.c: light of vertices as an image. */
#include <stdio.h>

#include "lightmap/check.h"
#include "lightmap/files.h"

enum { CHANNELS = 3 * (AIR_LAYER_COUNT + 1) };

static void image_size(size_t vertex_count, size_t *out_width, size_t *out_height)
{
    const size_t most = AIR_VERTEX_IMAGE_WIDTH;
    *out_width = vertex_count < most ? vertex_count : most;
    *out_height = (vertex_count + most - 1) / most;
}

air_status air_vertex_light_to_image(air_context *context, const air_vertex_light *light,
                                     air_image **out_image)
{
    char names[CHANNELS][16];
    const char *pointers[CHANNELS];
    size_t width, height;
    for (size_t i = 0; i < CHANNELS; i++) {
        const char *layer = i < 3 ? "" : air_light_layer_name((air_light_layer)(i / 3 - 1));
        (void)snprintf(names[i], sizeof names[i], "%s%s%s", layer, i < 3 ? "" : ".",
                       air_lightmap_colours[i % 3]);
        pointers[i] = names[i];
    }
    image_size(light->vertex_count, &width, &height);
    const air_status status =
        air_image_create(context, width, height, CHANNELS, pointers, out_image);
    for (size_t i = 0; i < CHANNELS && status == AIR_OK; i++) {
        float *plane = air_image_plane(*out_image, i);
        for (size_t v = 0; v < light->vertex_count; v++) {
            for (size_t k = i < 3 ? 0 : i / 3 - 1; k < (i < 3 ? AIR_LAYER_COUNT : i / 3); k++) {
                plane[v] += light->layers[k][3 * v + i % 3];
            }
        }
    }
    return status;
}

air_status air_vertex_light_from_image(air_context *context, const char *what,
                                       const air_image *image, air_vertex_light *light)
{
    size_t width, height;
    image_size(light->vertex_count, &width, &height);
    if (air_image_width(image) != width || air_image_height(image) != height) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: the image is %zu x %zu, %zu vertices need %zu x %zu", what,
                        air_image_width(image), air_image_height(image), light->vertex_count, width,
                        height);
    }
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        const char *name = air_light_layer_name((air_light_layer)k);
        const float *planes[3];
        if (!air_lightmap_planes(image, name, planes)) {
            return air_fail(context, AIR_ERROR_FORMAT, "%s: expected the channels %s.R, .G and .B",
                            what, name);
        }
        light->layers[k] = air_allocate(context, light->vertex_count, 3 * sizeof *light->layers[k]);
        if (light->layers[k] == NULL) {
            return air_fail_memory(context, what);
        }
        for (size_t v = 0; v < light->vertex_count; v++) {
            for (size_t c = 0; c < 3; c++) {
                light->layers[k][3 * v + c] = planes[c][v];
            }
        }
    }
    return AIR_OK;
}

/* sidecar_node.c: what the airlight object of a node adds to its mesh and its camera. */
#include "scene/camera.h"
#include "scene/import/import.h"
#include "scene/mesh.h"

static air_status read_shape(const air_json *at, air_import_object *object)
{
    const air_json shape_at = air_json_get(at, "shape");
    const air_json flip_at = air_json_get(at, "flip_normals");
    size_t shape = AIR_SHAPE_TRIANGLES;
    if (shape_at.value != NULL && object->mesh == SIZE_MAX)
        return air_json_fail(&shape_at, AIR_ERROR_FORMAT,
                             "expected a mesh at the node, which has the shape's material");
    air_status status = air_json_choice(&shape_at, air_shape_names, AIR_SHAPES, &shape);
    object->shape = (air_shape)shape;
    if (status == AIR_OK && flip_at.value != NULL && object->shape == AIR_SHAPE_TRIANGLES)
        status =
            air_json_fail(&flip_at, AIR_ERROR_FORMAT,
                          "expected a shape beside it: fronts of triangles are by their order");
    return status == AIR_OK ? air_json_bool(&flip_at, &object->flip_normals) : status;
}

static air_status read_size(const air_json *film, const char *key, size_t *out)
{
    const air_json at = air_json_get(film, key);
    air_status status = air_json_require(&at, "a number of pixels");
    if (status == AIR_OK)
        status = air_json_size(&at, out);
    if (status == AIR_OK && (*out < 1 || *out > 65535))
        status = air_json_expected(&at, "a whole number from 1 to 65535");
    return status;
}

/* [x0, y0, x1, y1], all of the picture if it is absent. */
static air_status read_crop(const air_json *at, air_film_hint *film)
{
    size_t crop[4] = {0, 0, film->width, film->height};
    air_status status = AIR_OK;
    if (at->value != NULL && air_json_count(at) != 4)
        status = air_json_expected(at, "an array of four whole numbers");
    for (size_t i = 0; i < air_json_count(at) && status == AIR_OK; ++i) {
        const air_json one = air_json_at(at, i);
        status = air_json_size(&one, &crop[i]);
    }
    if (status == AIR_OK && !(crop[0] < crop[2] && crop[2] <= film->width && crop[1] < crop[3] &&
                              crop[3] <= film->height))
        status = air_json_expected(at, "a part of %zu x %zu pixels as x0, y0, x1, y1", film->width,
                                   film->height);
    for (size_t i = 0; i < 4; ++i)
        film->crop[i] = crop[i];
    return status;
}

static air_status read_film(const air_json *at, air_film_hint *film)
{
    static const char *const keys[] = {"width",   "height", "crop",
                                       "samples", "filter", "filter_radius"};
    const air_json crop_at = air_json_get(at, "crop"), samples_at = air_json_get(at, "samples");
    const air_json filter_at = air_json_get(at, "filter");
    const air_json radius_at = air_json_get(at, "filter_radius");
    size_t samples = 1, filter = AIR_FILTER_BOX;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, sizeof keys / sizeof keys[0]);
    if (status == AIR_OK)
        status = read_size(at, "width", &film->width);
    if (status == AIR_OK)
        status = read_size(at, "height", &film->height);
    if (status == AIR_OK)
        status = read_crop(&crop_at, film);
    if (status == AIR_OK)
        status = air_json_size(&samples_at, &samples);
    if (status == AIR_OK && (samples < 1 || samples > UINT32_MAX))
        status = air_json_expected(&samples_at, "a whole number from 1 to 2^32 - 1");
    if (status == AIR_OK)
        status = air_json_choice(&filter_at, air_filter_names, AIR_FILTERS, &filter);
    film->samples = (uint32_t)samples;
    film->filter = (air_filter)filter;
    film->filter_radius = air_filter_radius_default(film->filter);
    if (status == AIR_OK)
        status = air_json_float(&radius_at, AIR_JSON_POSITIVE, &film->filter_radius);
    film->known = status == AIR_OK;
    return status;
}

air_status air_sidecar_read_node(const air_json *at, air_import_object *object)
{
    static const char *const camera_keys[] = {"lens_radius", "focus_distance", "near_distance",
                                              "mirrored", "film"};
    const air_json film_at = air_json_get(at, "film");
    air_status status = read_shape(at, object);
    for (size_t i = 0; i < sizeof camera_keys / sizeof *camera_keys && status == AIR_OK; ++i) {
        const air_json said = air_json_get(at, camera_keys[i]);
        if (said.value != NULL && object->camera == SIZE_MAX)
            status = air_json_fail(&said, AIR_ERROR_FORMAT, "expected a camera at the node");
    }
    if (status == AIR_OK)
        status = air_sidecar_read_camera(at, &object->camera_rest);
    return status == AIR_OK && film_at.value != NULL
               ? read_film(&film_at, &object->camera_rest.film)
               : status;
}

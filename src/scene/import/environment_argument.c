#include <math.h>
#include <string.h>

#include "airlight/image.h"
#include "scene/import/import.h"
#include "scene/import/number.h"

/* R, G, B of an image side by side; a picture without them is grey. Returns how many values were
 * not usable. */
static size_t interleave(const air_image *image, float *out)
{
    static const char *const names[] = {"R", "G", "B"};
    const size_t count = air_image_width(image) * air_image_height(image);
    size_t unusable = 0;
    for (size_t c = 0; c < 3; ++c) {
        const ptrdiff_t found = air_image_find_channel(image, names[c]);
        const float *plane = air_image_plane_const(image, found >= 0 ? (size_t)found : 0);
        for (size_t i = 0; i < count; ++i) {
            const bool usable = isfinite(plane[i]) && plane[i] >= 0.0f;
            out[3 * i + c] = usable ? plane[i] : 0.0f;
            unusable += !usable;
        }
    }
    return unusable;
}

air_status air_import_environment_texture(air_import *import, const char *path,
                                          air_handle *out_texture)
{
    air_image *image = NULL;
    float *floats = NULL;
    air_status status = air_image_load(import->context, path, &image);
    if (status != AIR_OK)
        return status;
    air_texture_desc desc = {.name = path,
                             .width = air_image_width(image),
                             .height = air_image_height(image),
                             .channels = 3,
                             .wrap_u = AIR_WRAP_REPEAT,
                             .wrap_v = AIR_WRAP_CLAMP,
                             .filter = AIR_TEXTURE_LINEAR};
    floats = air_allocate(import->context, desc.width * desc.height, 3 * sizeof *floats);
    if (floats == NULL) {
        status = air_fail_memory(import->context, path);
        goto cleanup;
    }
    const size_t unusable = interleave(image, floats);
    desc.floats = floats;
    if (unusable > 0)
        status = air_import_warn(import, "%s: %zu values are negative or not finite and taken as 0",
                                 path, unusable);
    if (status == AIR_OK)
        status = air_scene_add_texture(import->scene, &desc, out_texture);
cleanup:
    air_free(import->context, floats);
    air_image_destroy(image);
    return status;
}

/* "0.1" or "0.1,0.2,0.3" */
static bool parse_color(const char *text, float out[3])
{
    size_t count = 0, offset = 0;
    const size_t size = strlen(text);
    for (; count < 3 && offset <= size; ++count) {
        const size_t length = strcspn(text + offset, ",");
        double value = 0.0;
        if (!air_number_parse(text + offset, length, &value) || !(value >= 0.0) || value > 1e30)
            return false;
        out[count] = (float)value;
        offset += length + 1;
    }
    if (count == 1)
        out[1] = out[2] = out[0];
    return count != 2 && offset > size;
}

air_status air_environment_argument_add(air_import *import, const char *argument)
{
    static const char constant[] = "constant=";
    const size_t length = sizeof constant - 1;
    air_light_desc desc;
    air_handle handle = AIR_NONE;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_ENVIRONMENT;
    desc.name = "environment";
    desc.color[0] = desc.color[1] = desc.color[2] = 1.0f;
    air_status status = AIR_OK;
    if (strncmp(argument, constant, length) != 0)
        status = air_import_environment_texture(import, argument, &desc.image);
    else if (!parse_color(argument + length, desc.color))
        status = air_fail(
            import->context, AIR_ERROR_ARGUMENT,
            "--environment \"%s\": column %zu: expected a radiance >= 0, or three as R,G,B",
            argument, length + 1);
    return status == AIR_OK ? air_scene_add_light(import->scene, &desc, &handle) : status;
}

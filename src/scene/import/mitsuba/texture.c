#include <math.h>
#include <string.h>

#include "airlight/image.h"
#include "image/decode.h"
#include "scene/import/mitsuba/mitsuba.h"

static const air_texture_ref no_texture = {.uv_transform = {1, 0, 0, 0, 1, 0}};

/* uv' = (m0 u + m1 v + m3, ...) of a map of three dimensions, and version 0.x's scale and offset:
 * [Mitsuba3], Transform::extract; [Mitsuba06], Texture2D. */
static air_status read_uv_map(const air_mitsuba *mitsuba, const air_xml *at, air_texture_ref *ref)
{
    float m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    float uniform = 1.0f, offset[2] = {0.0f, 0.0f};
    air_status status = air_mitsuba_transform(mitsuba, at, "to_uv", m);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "uvscale", &uniform);
    float scale[2] = {uniform, uniform};
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "uscale", &scale[0]);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "vscale", &scale[1]);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "uoffset", &offset[0]);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "voffset", &offset[1]);
    for (size_t row = 0; row < 2; ++row) {
        ref->uv_transform[3 * row] = scale[row] * m[4 * row];
        ref->uv_transform[3 * row + 1] = scale[row] * m[4 * row + 1];
        ref->uv_transform[3 * row + 2] = scale[row] * m[4 * row + 3] + offset[row];
    }
    return status;
}

/* ---- bitmaps ---- */

static air_status read_sampling(const air_mitsuba *mitsuba, const air_xml *at,
                                air_texture_desc *desc)
{
    static const char *const wraps[] = {"repeat", "clamp", "mirror"};
    static const char *const filters[] = {"bilinear", "nearest", "trilinear", "ewa"};
    static const char *const ignored[] = {"max_anisotropy", "cache", "format", "accel",
                                          "coordinates"};
    size_t wrap = 0, filter = 0;
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = air_mitsuba_choice(mitsuba, at, "wrap_mode", wraps, 3, &wrap);
    size_t wrap_u = wrap, wrap_v = wrap;
    if (status == AIR_OK)
        status = air_mitsuba_choice(mitsuba, at, "wrap_mode_u", wraps, 3, &wrap_u);
    if (status == AIR_OK)
        status = air_mitsuba_choice(mitsuba, at, "wrap_mode_v", wraps, 3, &wrap_v);
    if (status == AIR_OK)
        status = air_mitsuba_choice(mitsuba, at, "filter_type", filters, 4, &filter);
    desc->wrap_u = (air_wrap)wrap_u;
    desc->wrap_v = (air_wrap)wrap_v;
    desc->filter = filter == 1 ? AIR_TEXTURE_NEAREST : AIR_TEXTURE_LINEAR;
    return status;
}

/* Are the bytes of a picture as they are the values? raw (3) and gamma 1 (0.x) say so. */
static air_status read_encoding(const air_mitsuba *mitsuba, const air_xml *at, bool *linear)
{
    bool raw = *linear;
    float gamma = -1.0f; /* sRGB */
    air_status status = air_mitsuba_boolean(mitsuba, at, "raw", &raw);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "gamma", &gamma);
    *linear = raw || gamma == 1.0f;
    if (status == AIR_OK && gamma != 1.0f && gamma > 0.0f)
        status = air_mitsuba_warn(
            mitsuba, at, "gamma %g is taken as that of sRGB, which is close to 2.2", (double)gamma);
    return status;
}

/* One channel out of several, of bytes or of floats. */
static void keep_channel(air_texture_desc *desc, void *values, size_t size, size_t channel)
{
    unsigned char *bytes = values;
    const size_t count = desc->width * desc->height;
    for (size_t i = 0; i < count; ++i)
        memmove(bytes + i * size, bytes + (i * desc->channels + channel) * size, size);
    desc->channels = 1;
}

static air_status choose_channel(const air_mitsuba *mitsuba, const air_xml *at,
                                 air_texture_desc *desc, void *values, size_t size)
{
    static const char *const channels[] = {"r", "g", "b", "a", "x", "y", "z"};
    size_t channel = 0;
    const air_status status = air_mitsuba_choice(mitsuba, at, "channel", channels, 7, &channel);
    if (status != AIR_OK || !air_mitsuba_has(at, "channel"))
        return status;
    channel = channel > 3 ? channel - 4 : channel;
    if (channel == 3 && desc->channels == 2)
        channel = 1;
    if (channel >= desc->channels)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "the picture has %zu channels, expected the one that channel names",
                                desc->channels);
    keep_channel(desc, values, size, channel);
    return AIR_OK;
}

/* A picture of 8 bits; linear says what its bytes are. */
static air_status add_bytes(const air_mitsuba *mitsuba, const air_xml *at, const char *path,
                            bool linear, air_texture_desc *desc, air_handle *out_handle)
{
    void *data = NULL;
    size_t size = 0;
    uint8_t *pixels = NULL;
    air_status status = air_file_read(mitsuba->context, path, &data, &size);
    if (status == AIR_OK)
        status = air_decode_bytes(mitsuba->context, data, size, path, &desc->width, &desc->height,
                                  &desc->channels, &pixels);
    if (status == AIR_OK)
        status = choose_channel(mitsuba, at, desc, pixels, 1);
    desc->bytes = pixels;
    desc->srgb = !linear;
    if (status == AIR_OK)
        status = air_scene_add_texture(mitsuba->import->scene, desc, out_handle);
    air_free(mitsuba->context, pixels);
    air_free(mitsuba->context, data);
    return status;
}

/* R, G and B of an image of floats, or its only channel; what is not finite becomes 0. */
static void interleave(const air_image *image, size_t channels, float *out)
{
    static const char *const names[] = {"R", "G", "B"};
    const size_t count = air_image_width(image) * air_image_height(image);
    for (size_t c = 0; c < channels; ++c) {
        const ptrdiff_t found = air_image_find_channel(image, names[c]);
        const float *plane = air_image_plane_const(image, found >= 0 ? (size_t)found : 0);
        for (size_t i = 0; i < count; ++i)
            out[channels * i + c] = isfinite(plane[i]) ? plane[i] : 0.0f;
    }
}

static air_status add_floats(const air_mitsuba *mitsuba, const air_xml *at, const char *path,
                             air_texture_desc *desc, air_handle *out_handle)
{
    air_image *image = NULL;
    float *floats = NULL;
    air_status status = air_image_load(mitsuba->context, path, &image);
    if (status != AIR_OK)
        return status;
    desc->width = air_image_width(image);
    desc->height = air_image_height(image);
    desc->channels = air_image_find_channel(image, "R") >= 0 ? 3 : 1;
    floats =
        air_allocate(mitsuba->context, desc->width * desc->height, desc->channels * sizeof *floats);
    if (floats == NULL) {
        status = air_fail_memory(mitsuba->context, path);
    } else {
        interleave(image, desc->channels, floats);
        status = choose_channel(mitsuba, at, desc, floats, sizeof *floats);
    }
    desc->floats = floats;
    if (status == AIR_OK)
        status = air_scene_add_texture(mitsuba->import->scene, desc, out_handle);
    air_free(mitsuba->context, floats);
    air_image_destroy(image);
    return status;
}

static bool holds_floats(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL && (strcmp(dot, ".exr") == 0 || strcmp(dot, ".hdr") == 0 ||
                           strcmp(dot, ".pfm") == 0 || strcmp(dot, ".rgbe") == 0);
}

static air_status add_bitmap(air_mitsuba *mitsuba, const air_xml *at, bool linear,
                             air_handle *out_handle)
{
    const char *name = NULL;
    char *path = NULL;
    air_texture_desc desc = {.name = air_mitsuba_name(at)};
    air_status status = air_mitsuba_filename(mitsuba, at, &name);
    if (status == AIR_OK)
        status = read_sampling(mitsuba, at, &desc);
    if (status == AIR_OK)
        status = read_encoding(mitsuba, at, &linear);
    if (status == AIR_OK)
        status = air_mitsuba_file(mitsuba, at, name, &path);
    if (status == AIR_OK)
        status = air_xml_place_error(&mitsuba->document, at,
                                     holds_floats(path)
                                         ? add_floats(mitsuba, at, path, &desc, out_handle)
                                         : add_bytes(mitsuba, at, path, linear, &desc, out_handle));
    air_free(mitsuba->context, path);
    return status;
}

/* ---- others ---- */

/* Two by two texels without a filter: their edges are exact. */
static air_status add_checkerboard(air_mitsuba *mitsuba, const air_xml *at, air_handle *out_handle)
{
    float colors[2][3] = {{0.4f, 0.4f, 0.4f}, {0.2f, 0.2f, 0.2f}}, texels[12];
    air_status status =
        air_mitsuba_color(mitsuba, at, "color0", AIR_MITSUBA_REFLECTANCE, colors[0]);
    if (status == AIR_OK)
        status = air_mitsuba_color(mitsuba, at, "color1", AIR_MITSUBA_REFLECTANCE, colors[1]);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; i < 4; ++i)
        memcpy(texels + 3 * i, colors[i % 3 == 0 ? 0 : 1], sizeof colors[0]);
    const air_texture_desc desc = {.name = air_mitsuba_name(at),
                                   .width = 2,
                                   .height = 2,
                                   .channels = 3,
                                   .floats = texels,
                                   .filter = AIR_TEXTURE_NEAREST};
    return air_scene_add_texture(mitsuba->import->scene, &desc, out_handle);
}

/* A texture times a number or a colour, of version 0.x. */
static air_status read_scaled(air_mitsuba *mitsuba, air_xml *at, bool linear, float out_scale[3],
                              air_texture_ref *ref)
{
    float scale[3] = {1.0f, 1.0f, 1.0f};
    air_xml *inner = NULL;
    air_status status = air_mitsuba_color(mitsuba, at, "scale", AIR_MITSUBA_REFLECTANCE, scale);
    if (status == AIR_OK)
        status = air_mitsuba_child(mitsuba, at, "texture", NULL, &inner);
    if (status == AIR_OK && inner == NULL) {
        out_scale[0] = out_scale[1] = out_scale[2] = 1.0f;
        status = air_mitsuba_color(mitsuba, at, "value", AIR_MITSUBA_REFLECTANCE, out_scale);
    } else if (status == AIR_OK) {
        status = air_mitsuba_texture(mitsuba, inner, linear, out_scale, ref);
    }
    for (size_t i = 0; i < 3; ++i)
        out_scale[i] *= scale[i];
    return status;
}

static air_status read_texture(air_mitsuba *mitsuba, air_xml *at, bool linear, float out_scale[3],
                               air_texture_ref *ref)
{
    static const char *const types[] = {"bitmap", "checkerboard", "scale"};
    const air_xml *with = linear ? at : NULL;
    const air_mitsuba_made *made = air_mitsuba_find_made(at, with);
    air_handle handle = made != NULL ? made->handle : AIR_NONE;
    air_status status = AIR_OK;
    out_scale[0] = out_scale[1] = out_scale[2] = 1.0f;
    if (air_mitsuba_is(at, "scale"))
        return read_scaled(mitsuba, at, linear, out_scale, ref);
    if (!air_mitsuba_is(at, "bitmap") && !air_mitsuba_is(at, "checkerboard")) {
        out_scale[0] = out_scale[1] = out_scale[2] = 0.5f;
        return air_mitsuba_unknown_type(mitsuba, at, types, 3, "a grey of 0.5 is taken");
    }
    if (made == NULL) {
        status = air_mitsuba_is(at, "bitmap") ? add_bitmap(mitsuba, at, linear, &handle)
                                              : add_checkerboard(mitsuba, at, &handle);
        if (status == AIR_OK && air_mitsuba_note_made(mitsuba, at, with, handle) == NULL)
            status = AIR_ERROR_MEMORY;
    }
    ref->texture = handle;
    return status == AIR_OK ? read_uv_map(mitsuba, at, ref) : status;
}

air_status air_mitsuba_texture(air_mitsuba *mitsuba, air_xml *at, bool linear, float out_scale[3],
                               air_texture_ref *ref)
{
    air_status status = air_mitsuba_enter(mitsuba, at);
    *ref = no_texture;
    if (status != AIR_OK)
        return status;
    status = read_texture(mitsuba, at, linear, out_scale, ref);
    air_mitsuba_leave(mitsuba);
    return status;
}

air_status air_mitsuba_textured(air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                air_mitsuba_quantity quantity, float value[3], air_texture_ref *ref)
{
    air_xml *found = air_mitsuba_parameter(at, name), *target = NULL;
    *ref = no_texture;
    if (found == NULL)
        return AIR_OK;
    const air_status status = air_mitsuba_resolve(mitsuba, found, &target);
    if (status != AIR_OK)
        return status;
    target->used = true;
    return strcmp(target->tag, "texture") == 0
               ? air_mitsuba_texture(mitsuba, target, false, value, ref)
               : air_mitsuba_read_color(mitsuba, target, quantity, value);
}

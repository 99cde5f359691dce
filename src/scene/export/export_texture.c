/* export_texture.c: textures, images and samplers. Images are PNG with 8 bits. */
#include <math.h>
#include <string.h>

#include "image/srgb.h"
#include "image/stb_image.h"
#include "scene/export/export.h"

static const air_texture *texture_of(const air_export *self, air_handle handle)
{
    return &((const air_texture_record *)air_export_record(self, AIR_OBJECT_TEXTURE, handle))
                ->texture;
}

float air_export_texture_peak(const air_export *self, air_handle handle)
{
    float peak = 1.0f;
    if (handle == AIR_NONE || texture_of(self, handle)->floats == NULL)
        return peak;
    const air_texture *texture = texture_of(self, handle);
    const size_t colours = texture->channels < 3 ? 1 : 3;
    for (size_t i = 0; i < texture->width * texture->height; ++i)
        for (size_t c = 0; c < colours; ++c)
            peak = fmaxf(peak, texture->floats[i * texture->channels + c]);
    return peak;
}

/* ---- pixels ---- */

/* A value of [0, 1] as a byte; what is outside is cut off and counted. */
static uint8_t to_byte(float value, bool srgb, size_t *clipped)
{
    const float inside = value > 0.0f ? fminf(value, 1.0f) : 0.0f;
    *clipped += !(value >= 0.0f && value <= 1.0f);
    return (uint8_t)lrintf(255.0f * (srgb ? srgb_encode(inside) : inside));
}

/* All texels as bytes, with as many channels as the texture has. */
static void convert_texels(const air_texture *texture, bool srgb, float scale, uint8_t *out,
                           size_t *clipped)
{
    const size_t channels = texture->channels;
    const bool alpha = channels % 2 == 0;
    for (size_t i = 0; i < texture->width * texture->height; ++i) {
        float rgba[4];
        air_texture_texel(texture, i % texture->width, i / texture->width, rgba);
        for (size_t c = 0; c < channels - alpha; ++c)
            out[i * channels + c] = to_byte(rgba[c] / scale, srgb, clipped);
        if (alpha)
            out[i * channels + channels - 1] = to_byte(rgba[3], false, clipped);
    }
}

static void warn_of_rounding(const air_export *self, const air_texture *texture, size_t clipped)
{
    air_warn(self->context, "%s: texture \"%s\": rounded to 8 bits", self->path, texture->name);
    if (clipped > 0)
        air_warn(self->context, "%s: texture \"%s\": %zu values outside [0, 1] cut off", self->path,
                 texture->name, clipped);
}

/* Texels that are as the file wants them are written as they are. */
static air_status encode_texture(air_export *self, const air_texture *texture, bool srgb,
                                 float scale, air_sink *png)
{
    const uint8_t *bytes = texture->bytes;
    uint8_t *converted = NULL;
    if (bytes == NULL || texture->srgb != srgb) {
        size_t clipped = 0;
        converted =
            air_allocate(self->context, texture->width * texture->height, texture->channels);
        if (converted == NULL)
            return air_fail_memory(self->context, self->path);
        convert_texels(texture, srgb, scale, converted, &clipped);
        warn_of_rounding(self, texture, clipped);
        bytes = converted;
    }
    const bool encoded =
        air_stb_encode_png(png, texture->width, texture->height, texture->channels, bytes);
    air_free(self->context, converted);
    return encoded ? AIR_OK : air_fail_memory(self->context, self->path);
}

/* Colours of one texture, or white, with the red of another in their alpha, at the finer of the two
 * resolutions. */
static air_status encode_opacity(air_export *self, const air_texture *color,
                                 const air_texture *opacity, bool srgb, air_sink *png)
{
    size_t width = opacity->width, height = opacity->height, clipped = 0;
    if (color != NULL) {
        width = color->width > width ? color->width : width;
        height = color->height > height ? color->height : height;
    }
    uint8_t *bytes = air_allocate(self->context, width * height, 4);
    if (bytes == NULL)
        return air_fail_memory(self->context, self->path);
    for (size_t i = 0; i < width * height; ++i) {
        const float u = ((float)(i % width) + 0.5f) / (float)width;
        const float v = ((float)(i / width) + 0.5f) / (float)height;
        float rgba[4] = {1.0f, 1.0f, 1.0f, 1.0f}, covered[4];
        if (color != NULL)
            air_texture_lookup(color, u, v, rgba);
        air_texture_lookup(opacity, u, v, covered);
        for (size_t c = 0; c < 3; ++c)
            bytes[4 * i + c] = to_byte(rgba[c], srgb, &clipped);
        bytes[4 * i + 3] = to_byte(rgba[3] * covered[0], false, &clipped);
    }
    const bool encoded = air_stb_encode_png(png, width, height, 4, bytes);
    air_free(self->context, bytes);
    return encoded ? AIR_OK : air_fail_memory(self->context, self->path);
}

static air_status encode(air_export *self, const air_export_texture *added, air_sink *png)
{
    const air_texture *texture = texture_of(self, added->handle);
    if (added->opacity == AIR_NONE)
        return encode_texture(self, texture, added->srgb, added->scale, png);
    return encode_opacity(self, added->opacity != added->handle ? texture : NULL,
                          texture_of(self, added->opacity), added->srgb, png);
}

/* ---- glTF ---- */

/* [glTF2, section 5.26]: the numbers are OpenGL's. Returns the index; equal samplers are one. */
static size_t add_sampler(air_export *self, const air_texture *texture)
{
    static const int wraps[] = {10497, 33071, 33648};
    const int filter = texture->filter == AIR_TEXTURE_NEAREST ? 9728 : 9729;
    json_t *sampler = json_object();
    air_export_put(self, sampler, "magFilter", json_integer(filter));
    air_export_put(self, sampler, "wrapS", json_integer(wraps[texture->wrap_u]));
    air_export_put(self, sampler, "wrapT", json_integer(wraps[texture->wrap_v]));
    json_t *samplers = air_export_list(self, self->root, "samplers");
    for (size_t i = 0; i < json_array_size(samplers); ++i) {
        if (json_equal(json_array_get(samplers, i), sampler)) {
            json_decref(sampler);
            return i;
        }
    }
    return air_export_append(self, "samplers", sampler);
}

static air_status add_texture(air_export *self, air_export_texture *added)
{
    const air_texture *texture = texture_of(self, added->handle);
    air_sink png = {.context = self->context};
    size_t view = 0;
    air_status status = encode(self, added, &png);
    if (status == AIR_OK)
        status = air_export_view(self, png.data, png.size, 0, &view);
    air_free(self->context, png.data);
    if (status != AIR_OK)
        return status;
    json_t *image = json_object(), *entry = json_object();
    air_export_put(self, image, "bufferView", json_integer((json_int_t)view));
    air_export_put(self, image, "mimeType", json_string("image/png"));
    air_export_name(self, image, texture->name);
    air_export_name(self, entry, texture->name);
    air_export_put(self, entry, "source",
                   json_integer((json_int_t)air_export_append(self, "images", image)));
    air_export_put(self, entry, "sampler", json_integer((json_int_t)add_sampler(self, texture)));
    added->index = air_export_append(self, "textures", entry);
    return AIR_OK;
}

/* The index of the texture in the file, added on its first use. */
static air_status find_texture(air_export *self, const air_export_texture *wanted,
                               size_t *out_index)
{
    for (size_t i = 0; i < self->texture_count; ++i) {
        const air_export_texture *known = &self->textures[i];
        if (known->handle == wanted->handle && known->opacity == wanted->opacity &&
            known->srgb == wanted->srgb && known->scale == wanted->scale) {
            *out_index = known->index;
            return AIR_OK;
        }
    }
    if (self->texture_count == self->texture_capacity) {
        const size_t capacity = 2 * self->texture_capacity + 8;
        air_export_texture *grown =
            air_reallocate(self->context, self->textures, capacity, sizeof *grown);
        if (grown == NULL)
            return air_fail_memory(self->context, self->path);
        self->textures = grown;
        self->texture_capacity = capacity;
    }
    air_export_texture added = *wanted;
    const air_status status = add_texture(self, &added);
    if (status == AIR_OK)
        self->textures[self->texture_count++] = added;
    *out_index = added.index;
    return status;
}

/* KHR_texture_transform has an offset, a rotation and a scale: (u, v) becomes (c sx u + s sy v, -s
 * sx u + c sy v) and the offset. False: the map m shears as well. */
static bool split_transform(const float m[6], float offset[2], float scale[2], float *rotation)
{
    const double along = hypot((double)m[0], (double)m[3]);
    const double across = hypot((double)m[1], (double)m[4]);
    const double product = (double)m[0] * (double)m[1] + (double)m[3] * (double)m[4];
    const double turn = (double)m[0] * (double)m[4] - (double)m[1] * (double)m[3];
    offset[0] = m[2];
    offset[1] = m[5];
    scale[0] = (float)along;
    scale[1] = (float)(turn < 0.0 ? -across : across);
    *rotation = along > 0.0 ? (float)atan2(-(double)m[3], (double)m[0])
                            : (float)atan2((double)m[1], (double)m[4]);
    if (m[1] == 0.0f && m[3] == 0.0f) { /* signs rather than half a turn */
        scale[0] = m[0];
        scale[1] = m[4];
        *rotation = 0.0f;
    }
    return fabs(product) <= 1e-5 * along * across;
}

static void put_transform(air_export *self, json_t *info, const air_texture_ref *reference)
{
    static const float plain[6] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    float offset[2], scale[2], rotation = 0.0f;
    bool same = true;
    for (size_t i = 0; i < 6; ++i)
        same &= reference->uv_transform[i] == plain[i];
    if (same)
        return;
    if (!split_transform(reference->uv_transform, offset, scale, &rotation))
        air_warn(self->context, "%s: texture \"%s\": its map of coordinates shears, taken without",
                 self->path, texture_of(self, reference->texture)->name);
    json_t *transform = air_export_extension(self, info, "KHR_texture_transform");
    air_export_put(self, transform, "offset", air_export_floats(self, offset, 2));
    if (rotation != 0.0f)
        air_export_put(self, transform, "rotation", json_real((double)rotation));
    air_export_put(self, transform, "scale", air_export_floats(self, scale, 2));
}

air_status air_export_texture_info(air_export *self, const air_texture_ref *reference,
                                   const air_export_texture *way, json_t **out_info)
{
    size_t index = 0;
    *out_info = NULL;
    if (reference->texture == AIR_NONE)
        return AIR_OK;
    air_export_texture wanted = *way;
    wanted.handle = reference->texture;
    const air_status status = find_texture(self, &wanted, &index);
    if (status != AIR_OK)
        return status;
    json_t *info = json_object();
    air_export_put(self, info, "index", json_integer((json_int_t)index));
    if (reference->uv_set > 0)
        air_export_put(self, info, "texCoord", json_integer(reference->uv_set));
    put_transform(self, info, reference);
    *out_info = info;
    return AIR_OK;
}

#include <math.h>

#include "image/decode.h"
#include "scene/import/gltf.h"
#include "scene/import/resource.h"

/* [glTF2, section 3.8.4]: the numbers are OpenGL's. */
static air_status read_wrap(const air_json *at, air_wrap *out)
{
    size_t number = 10497;
    const air_status status = air_json_size(at, &number);
    if (status != AIR_OK)
        return status;
    switch (number) {
    case 10497:
        *out = AIR_WRAP_REPEAT;
        return AIR_OK;
    case 33071:
        *out = AIR_WRAP_CLAMP;
        return AIR_OK;
    case 33648:
        *out = AIR_WRAP_MIRROR;
        return AIR_OK;
    default:
        return air_json_expected(at, "one of 10497, 33071, 33648");
    }
}

static air_status read_sampler(air_gltf *gltf, const air_json *texture, air_gltf_texture *out)
{
    const air_json index_at = air_json_get(texture, "sampler");
    size_t index = 0;
    if (index_at.value == NULL)
        return AIR_OK;
    air_status status =
        air_json_index(&index_at, air_json_count(&gltf->samplers), "a sampler", &index);
    if (status != AIR_OK)
        return status;
    const air_json sampler = air_json_at(&gltf->samplers, index);
    const air_json wrap_u = air_json_get(&sampler, "wrapS");
    const air_json wrap_v = air_json_get(&sampler, "wrapT");
    const air_json filter = air_json_get(&sampler, "magFilter");
    size_t filter_number = 9729;
    status = air_json_check_object(&sampler, true);
    if (status == AIR_OK)
        status = read_wrap(&wrap_u, &out->wrap_u);
    if (status == AIR_OK)
        status = read_wrap(&wrap_v, &out->wrap_v);
    if (status == AIR_OK)
        status = air_json_size(&filter, &filter_number);
    if (status == AIR_OK && filter_number != 9728 && filter_number != 9729)
        status = air_json_expected(&filter, "one of 9728, 9729");
    out->filter = filter_number == 9728 ? AIR_TEXTURE_NEAREST : AIR_TEXTURE_LINEAR;
    return status;
}

/* The compressed bytes of an image. *out_owned is set if they are to be freed; *out_what always. */
static air_status read_image_bytes(air_gltf *gltf, const air_json *image, const void **out_data,
                                   size_t *out_size, void **out_owned, char **out_what)
{
    const air_json view_at = air_json_get(image, "bufferView");
    const air_json uri_at = air_json_get(image, "uri");
    air_status status = air_json_check_object(image, true);
    if (status != AIR_OK)
        return status;
    if (view_at.value == NULL) {
        status = air_resource_read(&uri_at, out_owned, out_size, out_what);
        *out_data = *out_owned;
        return status;
    }
    size_t view = 0, stride = 0;
    const uint8_t *bytes = NULL;
    status = air_json_index(&view_at, air_json_count(&gltf->buffer_views), "a buffer view", &view);
    if (status == AIR_OK)
        status = air_gltf_view(gltf, view, &bytes, out_size, &stride);
    if (status != AIR_OK)
        return status;
    char place[64];
    air_json_describe(image, place, sizeof place);
    *out_data = bytes;
    *out_what = air_string_format(gltf->context, "%s: %s", gltf->path, place);
    return *out_what != NULL ? AIR_OK : air_fail_memory(gltf->context, gltf->path);
}

static air_status add_texture(air_gltf *gltf, const char *name, air_gltf_texture *texture)
{
    const air_json image = air_json_at(&gltf->images, texture->image);
    const void *data = NULL;
    size_t size = 0;
    void *owned = NULL;
    char *what = NULL;
    uint8_t *pixels = NULL;
    air_texture_desc desc = {.name = name,
                             .srgb = texture->srgb,
                             .wrap_u = texture->wrap_u,
                             .wrap_v = texture->wrap_v,
                             .filter = texture->filter};
    air_status status = read_image_bytes(gltf, &image, &data, &size, &owned, &what);
    if (status == AIR_OK)
        status = air_decode_bytes(gltf->context, data, size, what, &desc.width, &desc.height,
                                  &desc.channels, &pixels);
    desc.bytes = pixels;
    if (status == AIR_OK)
        status = air_scene_add_texture(gltf->import->scene, &desc, &texture->handle);
    air_free(gltf->context, pixels);
    air_free(gltf->context, what);
    air_free(gltf->context, owned);
    return status;
}

/* The handle of an image with this sampler and colour space, decoded on the first use. */
static air_status shared_texture(air_gltf *gltf, const char *name, const air_gltf_texture *wanted,
                                 air_handle *out_handle)
{
    for (size_t i = 0; i < gltf->texture_count; ++i) {
        const air_gltf_texture *known = &gltf->texture_store[i];
        if (known->image == wanted->image && known->wrap_u == wanted->wrap_u &&
            known->wrap_v == wanted->wrap_v && known->filter == wanted->filter &&
            known->srgb == wanted->srgb) {
            *out_handle = known->handle;
            return AIR_OK;
        }
    }
    if (gltf->texture_count == gltf->texture_capacity) {
        const size_t capacity = 2 * gltf->texture_capacity + 8;
        air_gltf_texture *store = air_reallocate(gltf->context, gltf->texture_store, capacity,
                                                 sizeof *gltf->texture_store);
        if (store == NULL)
            return air_fail_memory(gltf->context, gltf->path);
        gltf->texture_store = store;
        gltf->texture_capacity = capacity;
    }
    air_gltf_texture added = *wanted;
    const air_status status = add_texture(gltf, name, &added);
    if (status != AIR_OK)
        return status;
    gltf->texture_store[gltf->texture_count++] = added;
    *out_handle = added.handle;
    return AIR_OK;
}

/* KHR_texture_transform: translation after rotation after scale; the rotation takes (u, v) to (u
 * cos + v sin, -u sin + v cos), as the extension's own example of a quadrant rotated by a right
 * angle needs, v running downwards. */
static air_status read_transform(const air_json *transform, air_texture_ref *slot)
{
    const air_json offset_at = air_json_get(transform, "offset");
    const air_json rotation_at = air_json_get(transform, "rotation");
    const air_json scale_at = air_json_get(transform, "scale");
    float offset[2] = {0.0f, 0.0f}, scale[2] = {1.0f, 1.0f};
    double rotation = 0.0;
    air_status status = air_json_check_object(transform, false);
    if (status == AIR_OK)
        status = air_json_floats(&offset_at, AIR_JSON_ANY, 2, offset);
    if (status == AIR_OK)
        status = air_json_number(&rotation_at, AIR_JSON_ANY, &rotation);
    if (status == AIR_OK)
        status = air_json_floats(&scale_at, AIR_JSON_ANY, 2, scale);
    const float c = (float)cos(rotation), s = (float)sin(rotation);
    const float map[6] = {c * scale[0],  s * scale[1], offset[0],
                          -s * scale[0], c * scale[1], offset[1]};
    for (size_t i = 0; i < 6; ++i)
        slot->uv_transform[i] = map[i];
    return status;
}

air_status air_gltf_read_texture(air_gltf *gltf, const air_json *info, bool srgb,
                                 air_texture_ref *out_slot)
{
    const air_json index_at = air_json_get(info, "index");
    const air_json set_at = air_json_get(info, "texCoord");
    const air_json extensions = air_json_get(info, "extensions");
    const air_json transform = air_json_get(&extensions, "KHR_texture_transform");
    const air_json override_at = air_json_get(&transform, "texCoord");
    if (info->value == NULL)
        return AIR_OK;
    size_t index = 0, set = 0;
    air_texture_ref slot = *out_slot;
    air_status status = air_json_check_object(info, true);
    if (status == AIR_OK)
        status = air_json_require(&index_at, "the index of a texture");
    if (status == AIR_OK)
        status = air_json_index(&index_at, air_json_count(&gltf->textures), "a texture", &index);
    if (status == AIR_OK)
        status = air_json_size(&set_at, &set);
    if (status == AIR_OK)
        status = read_transform(&transform, &slot);
    if (status == AIR_OK)
        status = air_json_size(&override_at, &set);
    if (status != AIR_OK)
        return status;
    if (set > 1) {
        gltf->tally.texture_sets++;
        return AIR_OK;
    }
    const air_json texture = air_json_at(&gltf->textures, index);
    const air_json source_at = air_json_get(&texture, "source");
    const air_json name_at = air_json_get(&texture, "name");
    air_gltf_texture wanted = {.srgb = srgb};
    status = air_json_check_object(&texture, true);
    if (status == AIR_OK && source_at.value == NULL) {
        gltf->tally.missing_sources++;
        return AIR_OK;
    }
    if (status == AIR_OK)
        status =
            air_json_index(&source_at, air_json_count(&gltf->images), "an image", &wanted.image);
    if (status == AIR_OK)
        status = read_sampler(gltf, &texture, &wanted);
    slot.uv_set = (uint32_t)set;
    if (status == AIR_OK)
        status = shared_texture(gltf, json_string_value(name_at.value), &wanted, &slot.texture);
    if (status == AIR_OK)
        *out_slot = slot;
    return status;
}

#include "scene/import/gltf.h"
#include "scene/import/resource.h"

static air_status load_buffer(air_gltf *gltf, size_t index, const air_json *at,
                              air_gltf_buffer *out)
{
    const air_json uri = air_json_get(at, "uri");
    const air_json length = air_json_get(at, "byteLength");
    size_t stated = 0;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_require(&length, "the number of bytes");
    if (status == AIR_OK)
        status = air_json_size(&length, &stated);
    if (status != AIR_OK)
        return status;
    air_gltf_buffer buffer = {0};
    char *what = NULL;
    if (uri.value != NULL) {
        status = air_resource_read(&uri, &buffer.data, &buffer.size, &what);
        buffer.owned = true;
    } else if (index == 0 && gltf->chunk != NULL) {
        buffer.data = (void *)(uintptr_t)gltf->chunk;
        buffer.size = gltf->chunk_size;
    } else {
        status = air_json_fail(&uri, AIR_ERROR_FORMAT,
                               "expected a URI: the file has no binary chunk for this buffer");
    }
    if (status == AIR_OK && stated > buffer.size) {
        status = air_json_fail(&length, AIR_ERROR_FORMAT, "%zu bytes are stated, %s has %zu",
                               stated, what != NULL ? what : "the binary chunk", buffer.size);
        if (buffer.owned)
            air_free(gltf->context, buffer.data);
    }
    air_free(gltf->context, what);
    if (status == AIR_OK)
        *out = buffer;
    return status;
}

air_status air_gltf_view(air_gltf *gltf, size_t view, const uint8_t **out_data, size_t *out_size,
                         size_t *out_stride)
{
    const air_json at = air_json_at(&gltf->buffer_views, view);
    const air_json buffer_at = air_json_get(&at, "buffer");
    const air_json offset_at = air_json_get(&at, "byteOffset");
    const air_json length_at = air_json_get(&at, "byteLength");
    const air_json stride_at = air_json_get(&at, "byteStride");
    size_t index = 0, offset = 0, length = 0, stride = 0;
    air_status status = air_json_check_object(&at, true);
    if (status == AIR_OK)
        status = air_json_require(&buffer_at, "the index of a buffer");
    if (status == AIR_OK)
        status = air_json_index(&buffer_at, air_json_count(&gltf->buffers), "a buffer", &index);
    if (status == AIR_OK)
        status = air_json_size(&offset_at, &offset);
    if (status == AIR_OK)
        status = air_json_require(&length_at, "the number of bytes");
    if (status == AIR_OK)
        status = air_json_size(&length_at, &length);
    if (status == AIR_OK)
        status = air_json_size(&stride_at, &stride);
    if (status != AIR_OK)
        return status;
    air_gltf_buffer *buffer = &gltf->buffer_store[index];
    if (buffer->data == NULL) {
        const air_json loaded = air_json_at(&gltf->buffers, index);
        status = load_buffer(gltf, index, &loaded, buffer);
        if (status != AIR_OK)
            return status;
    }
    if (offset > buffer->size || length > buffer->size - offset)
        return air_json_fail(&at, AIR_ERROR_FORMAT,
                             "bytes %zu to %zu are past the end of buffer %zu (%zu bytes)", offset,
                             offset + length, index, buffer->size);
    *out_data = (const uint8_t *)buffer->data + offset;
    *out_size = length;
    *out_stride = stride;
    return AIR_OK;
}

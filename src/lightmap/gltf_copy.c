/* gltf_copy.c: a glTF file to be changed in places. */
#include "lightmap/gltf_copy.h"

#include <string.h>

#include "lightmap/files.h"
#include "lightmap/uri.h"

enum { ALIGNMENT = 8 };

/* ---- lists ---- */

air_place air_gltf_copy_root(const air_gltf_copy *self)
{
    return air_place_root(self->context, self->path, self->json);
}

json_t *air_gltf_copy_list(air_gltf_copy *self, const char *name)
{
    json_t *list = json_object_get(self->json, name);
    if (list == NULL && json_object_set_new(self->json, name, json_array()) == 0) {
        list = json_object_get(self->json, name);
    }
    return json_is_array(list) ? list : NULL;
}

air_status air_gltf_copy_append(air_gltf_copy *self, const char *name, json_t *item,
                                size_t *out_index)
{
    json_t *list = air_gltf_copy_list(self, name);
    if (list == NULL || json_array_append_new(list, item) != 0) {
        const air_place root = air_gltf_copy_root(self);
        const air_place at = air_place_get(&root, name);
        if (list == NULL) {
            json_decref(item);
        }
        return list == NULL && at.value != NULL ? air_place_wrong(&at, "an array")
                                                : air_fail_memory(self->context, self->path);
    }
    *out_index = json_array_size(list) - 1;
    return AIR_OK;
}

air_status air_gltf_copy_use_extension(air_gltf_copy *self, const char *name)
{
    json_t *list = air_gltf_copy_list(self, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *used = json_string_value(json_array_get(list, i));
        if (used != NULL && strcmp(used, name) == 0) {
            return AIR_OK;
        }
    }
    size_t index;
    return air_gltf_copy_append(self, "extensionsUsed", json_string(name), &index);
}

/* ---- the binary part ---- */

/* Appends bytes at a multiple of ALIGNMENT. */
static air_status append_bytes(air_gltf_copy *self, const void *data, size_t size,
                               size_t *out_offset)
{
    const size_t offset = (self->binary.size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (!air_sink_write(&self->binary, offset, data, size)) {
        return air_fail_memory(self->context, self->path);
    }
    *out_offset = offset;
    return AIR_OK;
}

air_status air_gltf_copy_add_view(air_gltf_copy *self, const void *data, size_t size, size_t stride,
                                  int target, size_t *out_view)
{
    size_t offset = 0;
    const air_status status = append_bytes(self, data, size, &offset);
    if (status != AIR_OK) {
        return status;
    }
    json_t *view = json_object();
    json_object_set_new(view, "buffer", json_integer(0));
    json_object_set_new(view, "byteOffset", json_integer((json_int_t)offset));
    json_object_set_new(view, "byteLength", json_integer((json_int_t)size));
    if (stride > 0) {
        json_object_set_new(view, "byteStride", json_integer((json_int_t)stride));
    }
    if (target > 0) {
        json_object_set_new(view, "target", json_integer(target));
    }
    return air_gltf_copy_append(self, "bufferViews", view, out_view);
}

/* ---- reading ---- */

enum { GLB_MAGIC = 0x46546c67, GLB_JSON = 0x4e4f534a, GLB_BIN = 0x004e4942 };

/* The JSON text and the binary chunk of a file [section 4.4]. */
static air_status split(const air_gltf_copy *self, const uint8_t *data, size_t size,
                        const char **out_text, size_t *out_text_size, const uint8_t **out_chunk,
                        size_t *out_chunk_size)
{
    if (size < 12 || air_get_u32(data) != GLB_MAGIC) {
        const bool mark = size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0;
        *out_text = (const char *)data + (mark ? 3 : 0);
        *out_text_size = size - (mark ? 3 : 0);
        return AIR_OK;
    }
    const size_t length = air_get_u32(data + 8);
    if (air_get_u32(data + 4) != 2 || length > size || length < 12) {
        return air_fail(self->context, AIR_ERROR_FORMAT,
                        "%s: byte 4: expected a GLB header of version 2 and no more than %zu bytes",
                        self->path, size);
    }
    for (size_t at = 12; length - at >= 8;) {
        const size_t chunk = air_get_u32(data + at);
        const uint32_t kind = air_get_u32(data + at + 4);
        if (chunk > length - at - 8) {
            return air_fail(self->context, AIR_ERROR_FORMAT,
                            "%s: byte %zu: the GLB chunk ends beyond the file", self->path, at);
        }
        if (kind == GLB_JSON && *out_text == NULL) {
            *out_text = (const char *)data + at + 8;
            *out_text_size = chunk;
        } else if (kind == GLB_BIN && *out_chunk == NULL) {
            *out_chunk = data + at + 8;
            *out_chunk_size = chunk;
        }
        at += 8 + chunk;
    }
    while (*out_text_size > 0 && (*out_text)[*out_text_size - 1] == '\0') {
        --*out_text_size;
    }
    return AIR_OK;
}

/* Appends buffer `index`; its place in the one buffer goes to *out_offset, its size to *out_size.
 */
static air_status append_buffer(air_gltf_copy *self, const air_place *at, size_t index,
                                const uint8_t *chunk, size_t chunk_size, size_t *out_offset,
                                size_t *out_size)
{
    const air_place uri = air_place_get(at, "uri");
    const air_place length_at = air_place_get(at, "byteLength");
    void *data = NULL;
    char *kind = NULL;
    size_t size = 0;
    air_status status = air_place_size(&length_at, (size_t)1 << 40, out_size);
    if (status == AIR_OK && uri.value != NULL) {
        status = air_uri_read(&uri, self->folder, &data, &size, &kind);
    } else if (status == AIR_OK && index == 0 && chunk != NULL) {
        size = chunk_size;
    } else if (status == AIR_OK) {
        status = air_place_wrong(&uri, "a URI: the file has no binary chunk for this buffer");
    }
    if (status == AIR_OK && size < *out_size) {
        status = air_place_wrong(&length_at, "at most the %zu bytes that are there", size);
    }
    if (status == AIR_OK) {
        status = append_bytes(self, data != NULL ? data : chunk, *out_size, out_offset);
    }
    air_free(self->context, data);
    air_free(self->context, kind);
    return status;
}

/* Makes a buffer view point into the one buffer. */
static air_status move_view(const air_place *at, const size_t *offsets, const size_t *sizes,
                            size_t buffer_count)
{
    const air_place buffer_at = air_place_get(at, "buffer");
    const air_place offset_at = air_place_get(at, "byteOffset");
    const air_place length_at = air_place_get(at, "byteLength");
    const air_place extensions = air_place_get(at, "extensions");
    size_t buffer = 0, offset = 0, length = 0;
    if (json_object_get(extensions.value, "EXT_meshopt_compression") != NULL) {
        return air_fail(at->context, AIR_ERROR_UNSUPPORTED,
                        "%s: %s: buffers compressed by EXT_meshopt_compression cannot be copied",
                        at->file, at->text);
    }
    if (buffer_count == 0) {
        return air_place_wrong(&buffer_at, "no buffer view, as there is no buffer");
    }
    air_status status = air_place_size(&buffer_at, buffer_count - 1, &buffer);
    if (status == AIR_OK && offset_at.value != NULL) {
        status = air_place_size(&offset_at, sizes[buffer], &offset);
    }
    if (status == AIR_OK) {
        status = air_place_size(&length_at, sizes[buffer] - offset, &length);
    }
    if (status == AIR_OK) {
        json_object_set_new(at->value, "buffer", json_integer(0));
        json_object_set_new(at->value, "byteOffset",
                            json_integer((json_int_t)(offsets[buffer] + offset)));
    }
    return status;
}

/* All buffers into one. */
static air_status join_buffers(air_gltf_copy *self, const uint8_t *chunk, size_t chunk_size)
{
    const air_place root = air_gltf_copy_root(self);
    const air_place buffers = air_place_get(&root, "buffers");
    const air_place views = air_place_get(&root, "bufferViews");
    const size_t count = air_place_count(&buffers);
    size_t *offsets = air_allocate(self->context, count, sizeof *offsets);
    size_t *sizes = air_allocate(self->context, count, sizeof *sizes);
    air_status status = AIR_OK;
    if (offsets == NULL || sizes == NULL) {
        status = air_fail_memory(self->context, self->path);
    }
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        const air_place at = air_place_at(&buffers, i);
        status = append_buffer(self, &at, i, chunk, chunk_size, &offsets[i], &sizes[i]);
    }
    for (size_t i = 0; i < air_place_count(&views) && status == AIR_OK; i++) {
        const air_place at = air_place_at(&views, i);
        status = move_view(&at, offsets, sizes, count);
    }
    air_free(self->context, offsets);
    air_free(self->context, sizes);
    if (status == AIR_OK && json_is_array(buffers.value)) {
        /* What else the first buffer says stays; the others have nothing left to say. */
        while (json_array_size(buffers.value) > 1) {
            json_array_remove(buffers.value, json_array_size(buffers.value) - 1);
        }
        json_object_del(json_array_get(buffers.value, 0), "uri");
    }
    return status;
}

/* The media type of a picture, by its URI's kind: a type already, or a file's ending. */
static const char *media_type(const char *kind)
{
    static const char *const types[][2] = {{".png", "image/png"},   {".jpg", "image/jpeg"},
                                           {".jpeg", "image/jpeg"}, {".ktx2", "image/ktx2"},
                                           {".webp", "image/webp"}, {".avif", "image/avif"},
                                           {".PNG", "image/png"},   {".JPG", "image/jpeg"},
                                           {".JPEG", "image/jpeg"}, {".dds", "image/vnd-ms.dds"}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(kind, types[i][0]) == 0) {
            return types[i][1];
        }
    }
    return strchr(kind, '/') != NULL ? kind : "image/png";
}

/* Pictures in files or data URIs into buffer views. */
static air_status embed_images(air_gltf_copy *self)
{
    const air_place root = air_gltf_copy_root(self);
    const air_place images = air_place_get(&root, "images");
    air_status status = AIR_OK;
    for (size_t i = 0; i < air_place_count(&images) && status == AIR_OK; i++) {
        const air_place at = air_place_at(&images, i);
        const air_place uri = air_place_get(&at, "uri");
        void *data = NULL;
        char *kind = NULL;
        size_t size = 0, view = 0;
        if (uri.value == NULL) {
            continue;
        }
        status = air_uri_read(&uri, self->folder, &data, &size, &kind);
        if (status == AIR_OK) {
            status = air_gltf_copy_add_view(self, data, size, 0, 0, &view);
        }
        if (status == AIR_OK) {
            json_object_del(at.value, "uri");
            json_object_set_new(at.value, "bufferView", json_integer((json_int_t)view));
            if (json_object_get(at.value, "mimeType") == NULL) {
                json_object_set_new(at.value, "mimeType", json_string(media_type(kind)));
            }
        }
        air_free(self->context, data);
        air_free(self->context, kind);
    }
    return status;
}

static air_status read_copy(air_context *context, const char *path, bool json_only,
                            air_gltf_copy *out)
{
    void *data = NULL;
    size_t size = 0, text_size = 0, chunk_size = 0;
    const char *text = NULL;
    const uint8_t *chunk = NULL;
    *out = (air_gltf_copy){.context = context, .path = path, .binary = {.context = context}};
    out->folder = air_uri_folder(context, path);
    if (out->folder == NULL) {
        return AIR_ERROR_MEMORY;
    }
    air_status status = air_file_read(context, path, &data, &size);
    if (status == AIR_OK) {
        status = split(out, data, size, &text, &text_size, &chunk, &chunk_size);
    }
    if (status == AIR_OK) {
        status = air_place_parse(context, path, text != NULL ? text : "", text_size, &out->json);
    }
    if (status == AIR_OK && !json_is_object(out->json)) {
        const air_place root = air_gltf_copy_root(out);
        status = air_place_wrong(&root, "an object");
    }
    if (status == AIR_OK && !json_only) {
        status = join_buffers(out, chunk, chunk_size);
    }
    if (status == AIR_OK && !json_only) {
        status = embed_images(out);
    }
    air_free(context, data);
    return status;
}

air_status air_gltf_copy_read(air_context *context, const char *path, air_gltf_copy *out)
{
    return read_copy(context, path, false, out);
}

air_status air_gltf_copy_read_json(air_context *context, const char *path, air_gltf_copy *out)
{
    return read_copy(context, path, true, out);
}

void air_gltf_copy_finish(air_gltf_copy *self)
{
    json_decref(self->json);
    air_free(self->context, self->folder);
    air_free(self->context, self->binary.data);
    self->json = NULL;
    self->folder = NULL;
    self->binary.data = NULL;
}

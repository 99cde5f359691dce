/* export_buffer.c: the binary chunk: buffer views and accessors [glTF2, section 3.6]. */
#include <string.h>

#include "scene/export/export.h"

enum { ALIGNMENT = 4, UNSIGNED_INT = 5125, FLOAT = 5126 };
enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER = 34963 };

static air_status append_bytes(air_export *self, const void *data, size_t size, size_t *out_offset)
{
    const size_t offset = (self->binary.size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (!air_sink_write(&self->binary, offset, data, size))
        return air_fail_memory(self->context, self->path);
    *out_offset = offset;
    return AIR_OK;
}

static size_t add_view(air_export *self, size_t offset, size_t size, int target)
{
    json_t *view = json_object();
    air_export_put(self, view, "buffer", json_integer(0));
    air_export_put(self, view, "byteOffset", json_integer((json_int_t)offset));
    air_export_put(self, view, "byteLength", json_integer((json_int_t)size));
    if (target > 0)
        air_export_put(self, view, "target", json_integer(target));
    return air_export_append(self, "bufferViews", view);
}

air_status air_export_view(air_export *self, const void *data, size_t size, int target,
                           size_t *out_index)
{
    size_t offset = 0;
    const air_status status = append_bytes(self, data, size, &offset);
    if (status == AIR_OK)
        *out_index = add_view(self, offset, size, target);
    return status;
}

/* ---- accessors ---- */

static void put_bounds(air_export *self, const air_export_array *array, json_t *accessor)
{
    const float *values = array->data;
    float low[4], high[4];
    memcpy(low, values, array->components * sizeof *low);
    memcpy(high, values, array->components * sizeof *high);
    for (size_t i = array->components; i < array->count * array->components; ++i) {
        const size_t c = i % array->components;
        low[c] = values[i] < low[c] ? values[i] : low[c];
        high[c] = values[i] > high[c] ? values[i] : high[c];
    }
    air_export_put(self, accessor, "min", air_export_floats(self, low, array->components));
    air_export_put(self, accessor, "max", air_export_floats(self, high, array->components));
}

static size_t add_accessor(air_export *self, const air_export_array *array, size_t view)
{
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    json_t *accessor = json_object();
    air_export_put(self, accessor, "bufferView", json_integer((json_int_t)view));
    air_export_put(self, accessor, "componentType",
                   json_integer(array->indices ? UNSIGNED_INT : FLOAT));
    air_export_put(self, accessor, "count", json_integer((json_int_t)array->count));
    air_export_put(self, accessor, "type", json_string(types[array->components - 1]));
    if (array->bounds)
        put_bounds(self, array, accessor);
    return air_export_append(self, "accessors", accessor);
}

/* ---- equal arrays ---- */

/* FNV-1a over words. */
static uint64_t hash_words(const void *data, size_t size)
{
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i + 4 <= size; i += 4) {
        uint32_t word;
        memcpy(&word, (const uint8_t *)data + i, sizeof word);
        hash = (hash ^ word) * 1099511628211u;
    }
    return hash ^ hash >> 32;
}

/* The block that equals `wanted`, or the free one where it belongs. */
static air_export_block *find_block(const air_export *self, const air_export_block *wanted,
                                    const void *data)
{
    size_t i = wanted->hash & (self->block_capacity - 1);
    for (;; i = (i + 1) & (self->block_capacity - 1)) {
        air_export_block *block = &self->blocks[i];
        if (block->accessor == SIZE_MAX)
            return block;
        if (block->hash == wanted->hash && block->size == wanted->size &&
            block->components == wanted->components && block->indices == wanted->indices &&
            block->bounds == wanted->bounds &&
            memcmp(self->binary.data + block->offset, data, wanted->size) == 0)
            return block;
    }
}

/* Keeps the table at most half full. */
static air_status make_room(air_export *self)
{
    if (2 * self->block_count < self->block_capacity)
        return AIR_OK;
    air_export grown = *self;
    grown.block_capacity = self->block_capacity == 0 ? 64 : 2 * self->block_capacity;
    grown.blocks = air_allocate(self->context, grown.block_capacity, sizeof *grown.blocks);
    if (grown.blocks == NULL)
        return air_fail_memory(self->context, self->path);
    for (size_t i = 0; i < grown.block_capacity; ++i)
        grown.blocks[i].accessor = SIZE_MAX;
    for (size_t i = 0; i < self->block_capacity; ++i) {
        const air_export_block *block = &self->blocks[i];
        if (block->accessor != SIZE_MAX)
            *find_block(&grown, block, self->binary.data + block->offset) = *block;
    }
    air_free(self->context, self->blocks);
    self->blocks = grown.blocks;
    self->block_capacity = grown.block_capacity;
    return AIR_OK;
}

air_status air_export_accessor(air_export *self, const air_export_array *array, size_t *out_index)
{
    const size_t size = array->count * array->components * sizeof(float);
    air_export_block wanted = {.hash = hash_words(array->data, size),
                               .size = size,
                               .components = array->components,
                               .indices = array->indices,
                               .bounds = array->bounds};
    air_status status = make_room(self);
    if (status != AIR_OK)
        return status;
    air_export_block *block = find_block(self, &wanted, array->data);
    if (block->accessor == SIZE_MAX) {
        status = append_bytes(self, array->data, size, &wanted.offset);
        if (status != AIR_OK)
            return status;
        const size_t view = add_view(self, wanted.offset, size,
                                     array->indices ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER);
        wanted.accessor = add_accessor(self, array, view);
        *block = wanted;
        self->block_count++;
    }
    *out_index = block->accessor;
    return AIR_OK;
}

/* gltf_array.c: accessors, read and made [section 3.6.2]. */
#include <math.h>
#include <string.h>

#include "lightmap/files.h"
#include "lightmap/gltf_copy.h"

enum {
    BYTE = 5120,
    UNSIGNED_BYTE = 5121,
    SHORT = 5122,
    UNSIGNED_SHORT = 5123,
    UNSIGNED_INT = 5125,
    FLOAT = 5126,
    ARRAY_BUFFER = 34962,
    ELEMENT_ARRAY_BUFFER = 34963
};

/* An accessor without a buffer view is all zeros; nothing in the file bounds its size. */
static const size_t most_zeros = (size_t)1 << 24;

static const char *const type_names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};

static size_t component_size(int64_t component)
{
    switch (component) {
    case BYTE:
    case UNSIGNED_BYTE:
        return 1;
    case SHORT:
    case UNSIGNED_SHORT:
        return 2;
    case UNSIGNED_INT:
    case FLOAT:
        return 4;
    default:
        return 0;
    }
}

static air_status read_component(const air_place *at, int64_t *out)
{
    air_status status = air_place_integer(at, BYTE, FLOAT, out);
    if (status == AIR_OK && component_size(*out) == 0) {
        status = air_place_wrong(at, "5120, 5121, 5122, 5123, 5125 or 5126");
    }
    return status;
}

/* The elements that the view and offset at a place hold: count of size bytes, *out_stride apart. */
static air_status find_elements(const air_gltf_copy *self, const air_place *at, size_t count,
                                size_t size, const uint8_t **out_data, size_t *out_stride)
{
    const air_place root = air_gltf_copy_root(self);
    const air_place views = air_place_get(&root, "bufferViews");
    const air_place view_at = air_place_get(at, "bufferView");
    const air_place offset_at = air_place_get(at, "byteOffset");
    size_t view = 0, start = 0, length = 0, offset = 0, stride = size;
    if (air_place_count(&views) == 0) {
        return air_place_wrong(&view_at, "a file with buffer views");
    }
    air_status status = air_place_size(&view_at, air_place_count(&views) - 1, &view);
    const air_place place = air_place_at(&views, view);
    const air_place start_at = air_place_get(&place, "byteOffset");
    const air_place length_at = air_place_get(&place, "byteLength");
    const air_place stride_at = air_place_get(&place, "byteStride");
    if (status == AIR_OK) {
        status = air_place_size(&start_at, self->binary.size, &start);
    }
    if (status == AIR_OK) {
        status = air_place_size(&length_at, self->binary.size - start, &length);
    }
    if (status == AIR_OK && stride_at.value != NULL) {
        status = air_place_size(&stride_at, 252, &stride);
    }
    if (status == AIR_OK && offset_at.value != NULL) {
        status = air_place_size(&offset_at, length, &offset);
    }
    if (status == AIR_OK &&
        (stride < size || (count > 0 && (length - offset < size ||
                                         (length - offset - size) / stride < count - 1)))) {
        status = air_place_wrong(at, "%zu elements of %zu bytes within buffer view %zu", count,
                                 size, view);
    }
    if (status == AIR_OK) {
        *out_data = self->binary.data + start + offset;
        *out_stride = stride;
    }
    return status;
}

static uint32_t read_unsigned(const uint8_t *bytes, size_t size)
{
    uint32_t value = 0;
    for (size_t i = size; i-- > 0;) {
        value = value << 8 | bytes[i];
    }
    return value;
}

/* Puts the elements that are stated apart over the others. */
static air_status read_sparse(const air_gltf_copy *self, const air_place *sparse,
                              air_gltf_array *array)
{
    const air_place count_at = air_place_get(sparse, "count");
    const air_place indices = air_place_get(sparse, "indices");
    const air_place values = air_place_get(sparse, "values");
    const air_place component_at = air_place_get(&indices, "componentType");
    const size_t size = array->components * array->component_size;
    const uint8_t *index_data = NULL, *value_data = NULL;
    size_t count = 0, index_stride = 0, value_stride = 0;
    int64_t component = 0;
    air_status status = air_place_size(&count_at, array->count, &count);
    if (status == AIR_OK) {
        status = read_component(&component_at, &component);
    }
    if (status == AIR_OK) {
        status = find_elements(self, &indices, count, component_size(component), &index_data,
                               &index_stride);
    }
    if (status == AIR_OK) {
        status = find_elements(self, &values, count, size, &value_data, &value_stride);
    }
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        const size_t element =
            read_unsigned(index_data + i * index_stride, component_size(component));
        if (element >= array->count) {
            return air_place_wrong(&indices, "indices below %zu, number %zu is %zu", array->count,
                                   i, element);
        }
        memcpy(array->bytes + element * size, value_data + i * value_stride, size);
    }
    return status;
}

/* Type and size of an accessor. */
static air_status read_kind(const air_place *at, air_gltf_array *out)
{
    const air_place component_at = air_place_get(at, "componentType");
    const air_place type_at = air_place_get(at, "type");
    const air_place count_at = air_place_get(at, "count");
    const air_place view_at = air_place_get(at, "bufferView");
    const char *type = json_string_value(type_at.value);
    air_status status =
        air_place_size(&count_at, view_at.value != NULL ? UINT32_MAX : most_zeros, &out->count);
    if (status == AIR_OK) {
        status = read_component(&component_at, &out->component);
    }
    for (size_t i = 0; i < 4 && status == AIR_OK && type != NULL; i++) {
        out->components = strcmp(type, type_names[i]) == 0 ? i + 1 : out->components;
    }
    if (status == AIR_OK && out->components == 0) {
        status = air_place_wrong(&type_at, "\"SCALAR\", \"VEC2\", \"VEC3\" or \"VEC4\"");
    }
    out->component_size = component_size(out->component);
    out->normalized = json_is_true(json_object_get(at->value, "normalized"));
    out->accessor = at->value;
    return status;
}

air_status air_gltf_array_read(const air_gltf_copy *self, const air_place *index,
                               air_gltf_array *out)
{
    const air_place root = air_gltf_copy_root(self);
    const air_place accessors = air_place_get(&root, "accessors");
    air_gltf_array array = {0};
    const uint8_t *data = NULL;
    size_t number = 0, stride = 0;
    if (air_place_count(&accessors) == 0) {
        return air_place_wrong(index, "a file with accessors");
    }
    air_status status = air_place_size(index, air_place_count(&accessors) - 1, &number);
    const air_place at = air_place_at(&accessors, number);
    const air_place view = air_place_get(&at, "bufferView");
    const air_place sparse = air_place_get(&at, "sparse");
    if (status == AIR_OK) {
        status = read_kind(&at, &array);
    }
    const size_t size = array.components * array.component_size;
    if (status == AIR_OK && view.value != NULL) {
        status = find_elements(self, &at, array.count, size, &data, &stride);
    }
    if (status != AIR_OK) {
        return status;
    }
    array.bytes = air_allocate(self->context, array.count, size);
    if (array.bytes == NULL) {
        return air_fail_memory(self->context, self->path);
    }
    for (size_t i = 0; data != NULL && i < array.count; i++) {
        memcpy(array.bytes + i * size, data + i * stride, size);
    }
    if (sparse.value != NULL) {
        status = read_sparse(self, &sparse, &array);
    }
    if (status != AIR_OK) {
        air_free(self->context, array.bytes);
        return status;
    }
    *out = array;
    return AIR_OK;
}

/* [section 3.11.1] */
double air_gltf_array_number(const air_gltf_array *array, size_t element, size_t component)
{
    const size_t size = array->component_size;
    const uint32_t bits =
        read_unsigned(array->bytes + (element * array->components + component) * size, size);
    if (array->component == FLOAT) {
        float value;
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
    const bool is_signed = array->component == BYTE || array->component == SHORT;
    const double whole = size == 4 ? 4294967296.0 : (double)(1u << 8 * size);
    const double largest = is_signed ? whole / 2.0 - 1.0 : whole - 1.0;
    double value = (double)bits;
    if (is_signed && value > largest) {
        value -= whole;
    }
    return array->normalized ? fmax(value / largest, -1.0) : value;
}

air_status air_gltf_array_gather(const air_gltf_copy *self, const air_gltf_array *array,
                                 const uint32_t *sources, size_t count, air_gltf_array *out)
{
    const size_t size = array->components * array->component_size;
    uint8_t *bytes = air_allocate(self->context, count, size);
    if (bytes == NULL) {
        return air_fail_memory(self->context, self->path);
    }
    for (size_t i = 0; i < count; i++) {
        memcpy(bytes + i * size, array->bytes + sources[i] * size, size);
    }
    *out = *array;
    out->bytes = bytes;
    out->count = count;
    return AIR_OK;
}

/* min and max as the accessor stores its numbers, not normalised. */
static void add_bounds(json_t *accessor, const air_gltf_array *array)
{
    air_gltf_array plain = *array;
    json_t *low = json_array(), *high = json_array();
    plain.normalized = false;
    for (size_t c = 0; c < plain.components; c++) {
        double least = INFINITY, largest = -INFINITY;
        for (size_t i = 0; i < plain.count; i++) {
            const double value = air_gltf_array_number(&plain, i, c);
            least = fmin(least, value);
            largest = fmax(largest, value);
        }
        json_array_append_new(low, plain.component == FLOAT ? json_real(least)
                                                            : json_integer((json_int_t)least));
        json_array_append_new(high, plain.component == FLOAT ? json_real(largest)
                                                             : json_integer((json_int_t)largest));
    }
    json_object_set_new(accessor, "min", low);
    json_object_set_new(accessor, "max", high);
}

air_status air_gltf_array_add(air_gltf_copy *self, const air_gltf_array *array, bool indices,
                              bool bounds, size_t *out_accessor)
{
    const size_t size = array->components * array->component_size;
    /* Vertices lie at multiples of four bytes [section 3.6.2.4]. */
    const size_t stride = indices ? size : (size + 3) / 4 * 4;
    uint8_t *padded = NULL;
    size_t view = 0;
    if (stride != size) {
        padded = air_allocate(self->context, array->count, stride);
        if (padded == NULL) {
            return air_fail_memory(self->context, self->path);
        }
        for (size_t i = 0; i < array->count; i++) {
            memcpy(padded + i * stride, array->bytes + i * size, size);
        }
    }
    const air_status status = air_gltf_copy_add_view(
        self, padded != NULL ? padded : array->bytes, array->count * stride,
        padded != NULL ? stride : 0, indices ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER, &view);
    air_free(self->context, padded);
    if (status != AIR_OK) {
        return status;
    }
    /* Names, extras and what else there was stay. */
    json_t *accessor = array->accessor != NULL ? json_deep_copy(array->accessor) : json_object();
    static const char *const gone[] = {"byteOffset", "sparse", "min", "max"};
    for (size_t i = 0; i < 4; i++) {
        json_object_del(accessor, gone[i]);
    }
    json_object_set_new(accessor, "bufferView", json_integer((json_int_t)view));
    json_object_set_new(accessor, "componentType", json_integer((json_int_t)array->component));
    json_object_set_new(accessor, "count", json_integer((json_int_t)array->count));
    json_object_set_new(accessor, "type", json_string(type_names[array->components - 1]));
    if (array->normalized) {
        json_object_set_new(accessor, "normalized", json_true());
    } else {
        json_object_del(accessor, "normalized");
    }
    if (bounds) {
        add_bounds(accessor, array);
    }
    return air_gltf_copy_append(self, "accessors", accessor, out_accessor);
}

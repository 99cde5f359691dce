#include <math.h>
#include <string.h>

#include "scene/import/gltf.h"

/* [glTF2, section 3.6.2.2] */
typedef enum air_component {
    AIR_COMPONENT_BYTE = 5120,
    AIR_COMPONENT_UNSIGNED_BYTE = 5121,
    AIR_COMPONENT_SHORT = 5122,
    AIR_COMPONENT_UNSIGNED_SHORT = 5123,
    AIR_COMPONENT_UNSIGNED_INT = 5125,
    AIR_COMPONENT_FLOAT = 5126
} air_component;

/* An accessor without a buffer view is all zeros, and its size is bounded by nothing in the file.
 */
static const size_t most_zero_elements = (size_t)1 << 22;

/* A checked accessor: elements at data + i * stride, then replacements. */
typedef struct air_accessor {
    size_t count, components, component_size;
    air_component component;
    bool normalized;
    const uint8_t *data; /* NULL: zeros */
    size_t stride;
    size_t sparse_count;
    const uint8_t *sparse_indices, *sparse_values;
    air_component sparse_component;
} air_accessor;

static size_t component_size(air_component component)
{
    switch (component) {
    case AIR_COMPONENT_BYTE:
    case AIR_COMPONENT_UNSIGNED_BYTE:
        return 1;
    case AIR_COMPONENT_SHORT:
    case AIR_COMPONENT_UNSIGNED_SHORT:
        return 2;
    case AIR_COMPONENT_UNSIGNED_INT:
    case AIR_COMPONENT_FLOAT:
        return 4;
    }
    return 0;
}

static uint32_t read_unsigned(const uint8_t *bytes, air_component component)
{
    switch (component_size(component)) {
    case 1:
        return bytes[0];
    case 2:
        return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8;
    default:
        return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
               (uint32_t)bytes[3] << 24;
    }
}

/* Signed numbers are two's complement of their width. */
static float read_signed(uint32_t bits, uint32_t sign)
{
    return (float)((int64_t)bits - (bits & sign ? 2 * (int64_t)sign : 0));
}

/* [glTF2, section 3.11.1]: normalised integers. */
static float read_float(const uint8_t *bytes, air_component component, bool normalized)
{
    const uint32_t bits = read_unsigned(bytes, component);
    float value = 0.0f, scale = 1.0f;
    switch (component) {
    case AIR_COMPONENT_FLOAT:
        memcpy(&value, &bits, sizeof value);
        return value;
    case AIR_COMPONENT_BYTE:
        value = read_signed(bits, 0x80u);
        scale = 127.0f;
        break;
    case AIR_COMPONENT_SHORT:
        value = read_signed(bits, 0x8000u);
        scale = 32767.0f;
        break;
    case AIR_COMPONENT_UNSIGNED_BYTE:
        value = (float)bits;
        scale = 255.0f;
        break;
    case AIR_COMPONENT_UNSIGNED_SHORT:
        value = (float)bits;
        scale = 65535.0f;
        break;
    case AIR_COMPONENT_UNSIGNED_INT:
        value = (float)bits;
        scale = 4294967295.0f;
        break;
    }
    return normalized ? fmaxf(value / scale, -1.0f) : value;
}

static air_status read_component(const air_json *at, air_component *out)
{
    size_t number = 0;
    air_status status = air_json_require(at, "a component type");
    if (status == AIR_OK)
        status = air_json_size(at, &number);
    if (status != AIR_OK)
        return status;
    if (number > 65535 || component_size((air_component)number) == 0)
        return air_json_expected(at, "one of 5120, 5121, 5122, 5123, 5125, 5126");
    *out = (air_component)number;
    return AIR_OK;
}

/* The bytes of `count` elements of `size` bytes from the view and offset that `at` names; *out_data
 * stays as it is if there is no view. */
static air_status locate(air_gltf *gltf, const air_json *at, size_t count, size_t size,
                         const uint8_t **out_data, size_t *out_stride)
{
    const air_json view_at = air_json_get(at, "bufferView");
    const air_json offset_at = air_json_get(at, "byteOffset");
    size_t view = 0, offset = 0, view_size = 0, stride = 0;
    const uint8_t *data = NULL;
    if (view_at.value == NULL)
        return AIR_OK;
    air_status status =
        air_json_index(&view_at, air_json_count(&gltf->buffer_views), "a buffer view", &view);
    if (status == AIR_OK)
        status = air_json_size(&offset_at, &offset);
    if (status == AIR_OK)
        status = air_gltf_view(gltf, view, &data, &view_size, &stride);
    if (status != AIR_OK)
        return status;
    if (stride == 0)
        stride = size;
    if (stride < size)
        return air_json_fail(at, AIR_ERROR_FORMAT,
                             "elements of %zu bytes do not fit the byteStride %zu of view %zu",
                             size, stride, view);
    if (count > 0 && (offset > view_size || size > view_size - offset ||
                      count - 1 > (view_size - offset - size) / stride))
        return air_json_fail(
            at, AIR_ERROR_FORMAT,
            "%zu elements of %zu bytes from byte %zu do not fit buffer view %zu (%zu bytes)", count,
            size, offset, view, view_size);
    *out_data = data + (count > 0 ? offset : 0);
    *out_stride = stride;
    return AIR_OK;
}

static air_status read_sparse(air_gltf *gltf, const air_json *sparse, air_accessor *accessor)
{
    const air_json count_at = air_json_get(sparse, "count");
    const air_json indices_at = air_json_get(sparse, "indices");
    const air_json values_at = air_json_get(sparse, "values");
    const air_json component_at = air_json_get(&indices_at, "componentType");
    const air_json index_view = air_json_get(&indices_at, "bufferView");
    const air_json value_view = air_json_get(&values_at, "bufferView");
    if (sparse->value == NULL)
        return AIR_OK;
    air_status status = air_json_require(&count_at, "the number of elements");
    if (status == AIR_OK)
        status = air_json_size(&count_at, &accessor->sparse_count);
    if (status == AIR_OK && accessor->sparse_count > accessor->count)
        status =
            air_json_expected(&count_at, "at most the accessor's count of %zu", accessor->count);
    if (status == AIR_OK)
        status = read_component(&component_at, &accessor->sparse_component);
    if (status == AIR_OK)
        status = air_json_require(&index_view, "the index of a buffer view");
    if (status == AIR_OK)
        status = air_json_require(&value_view, "the index of a buffer view");
    size_t stride = 0; /* sparse views are packed */
    const size_t index_size = component_size(accessor->sparse_component);
    if (status == AIR_OK)
        status = locate(gltf, &indices_at, accessor->sparse_count, index_size,
                        &accessor->sparse_indices, &stride);
    if (status == AIR_OK && stride != index_size)
        status = air_json_fail(&indices_at, AIR_ERROR_FORMAT,
                               "expected a buffer view without byteStride");
    const size_t value_size = accessor->components * accessor->component_size;
    if (status == AIR_OK)
        status = locate(gltf, &values_at, accessor->sparse_count, value_size,
                        &accessor->sparse_values, &stride);
    if (status == AIR_OK && stride != value_size)
        status = air_json_fail(&values_at, AIR_ERROR_FORMAT,
                               "expected a buffer view without byteStride");
    return status;
}

static air_status open_accessor(air_gltf *gltf, const air_json *at, air_accessor *out)
{
    static const char *const type_names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const air_json count_at = air_json_get(at, "count");
    const air_json type_at = air_json_get(at, "type");
    const air_json component_at = air_json_get(at, "componentType");
    const air_json normalized_at = air_json_get(at, "normalized");
    const air_json sparse_at = air_json_get(at, "sparse");
    size_t type = 0;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_require(&count_at, "the number of elements");
    if (status == AIR_OK)
        status = air_json_size(&count_at, &out->count);
    if (status == AIR_OK)
        status = air_json_require(&type_at, "an element type");
    if (status == AIR_OK)
        status = air_json_choice(&type_at, type_names, 4, &type);
    if (status == AIR_OK)
        status = read_component(&component_at, &out->component);
    if (status == AIR_OK)
        status = air_json_bool(&normalized_at, &out->normalized);
    if (status != AIR_OK)
        return status;
    out->components = type + 1;
    out->component_size = component_size(out->component);
    status = locate(gltf, at, out->count, out->components * out->component_size, &out->data,
                    &out->stride);
    if (status == AIR_OK && out->data == NULL && out->count > most_zero_elements)
        status = air_json_expected(&count_at, "at most %zu elements without a buffer view",
                                   most_zero_elements);
    return status == AIR_OK ? read_sparse(gltf, &sparse_at, out) : status;
}

/* Which element of the accessor replacement i is for. */
static air_status sparse_target(const air_json *at, const air_accessor *accessor, size_t i,
                                size_t *out_element)
{
    const uint8_t *bytes =
        accessor->sparse_indices + i * component_size(accessor->sparse_component);
    *out_element = read_unsigned(bytes, accessor->sparse_component);
    if (*out_element < accessor->count)
        return AIR_OK;
    return air_json_fail(at, AIR_ERROR_FORMAT,
                         "sparse index %zu is %zu, but there are %zu elements", i, *out_element,
                         accessor->count);
}

static air_status store_element(const air_json *at, const air_accessor *accessor,
                                const uint8_t *bytes, size_t element, size_t width, float *values)
{
    float *out = values + element * width;
    for (size_t c = 0; c < width; ++c) {
        out[c] = 1.0f;
        if (c < accessor->components)
            out[c] = read_float(bytes + c * accessor->component_size, accessor->component,
                                accessor->normalized);
        if (!isfinite(out[c]))
            return air_json_fail(at, AIR_ERROR_FORMAT, "element %zu: component %zu is not finite",
                                 element, c);
    }
    return AIR_OK;
}

static air_status store_floats(const air_json *at, const air_accessor *accessor, size_t width,
                               float *values)
{
    const size_t value_size = accessor->components * accessor->component_size;
    air_status status = AIR_OK;
    for (size_t i = 0; i < accessor->count && accessor->data != NULL && status == AIR_OK; ++i)
        status =
            store_element(at, accessor, accessor->data + i * accessor->stride, i, width, values);
    for (size_t i = 0; i < accessor->sparse_count && status == AIR_OK; ++i) {
        size_t element = 0;
        status = sparse_target(at, accessor, i, &element);
        if (status == AIR_OK)
            status = store_element(at, accessor, accessor->sparse_values + i * value_size, element,
                                   width, values);
    }
    return status;
}

/* The accessor that `at` (an index) names. */
static air_status find_accessor(air_gltf *gltf, const air_json *at, air_json *out)
{
    size_t index = 0;
    const air_status status =
        air_json_index(at, air_json_count(&gltf->accessors), "an accessor", &index);
    *out = air_json_at(&gltf->accessors, index);
    return status;
}

air_status air_gltf_read_floats(air_gltf *gltf, const air_json *at, size_t width, size_t narrow,
                                float **out_values, size_t *out_count)
{
    air_json place;
    air_accessor accessor = {0};
    *out_values = NULL;
    *out_count = 0;
    if (at->value == NULL)
        return AIR_OK;
    air_status status = find_accessor(gltf, at, &place);
    if (status == AIR_OK)
        status = open_accessor(gltf, &place, &accessor);
    if (status != AIR_OK)
        return status;
    if (accessor.components != width && accessor.components != narrow) {
        const air_json type_at = air_json_get(&place, "type");
        return air_json_expected(&type_at, "\"VEC%zu\" for %s", width, at->key);
    }
    float *values = air_allocate(gltf->context, accessor.count, width * sizeof *values);
    if (values == NULL)
        return air_fail_memory(gltf->context, gltf->path);
    status = store_floats(&place, &accessor, width, values);
    if (status != AIR_OK) {
        air_free(gltf->context, values);
        return status;
    }
    *out_values = values;
    *out_count = accessor.count;
    return AIR_OK;
}

static air_status store_index(const air_json *at, const air_accessor *accessor,
                              const uint8_t *bytes, size_t element, size_t vertex_count,
                              uint32_t *values)
{
    values[element] = read_unsigned(bytes, accessor->component);
    if (values[element] < vertex_count)
        return AIR_OK;
    return air_json_fail(at, AIR_ERROR_FORMAT,
                         "element %zu: vertex %u is out of range, there are %zu vertices", element,
                         values[element], vertex_count);
}

static air_status store_indices(const air_json *at, const air_accessor *accessor,
                                size_t vertex_count, uint32_t *values)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < accessor->count && accessor->data != NULL && status == AIR_OK; ++i)
        status = store_index(at, accessor, accessor->data + i * accessor->stride, i, vertex_count,
                             values);
    if (accessor->data == NULL && accessor->count > 0 && vertex_count == 0)
        status = air_json_fail(at, AIR_ERROR_FORMAT,
                               "element 0: vertex 0 is out of range, there are no vertices");
    for (size_t i = 0; i < accessor->sparse_count && status == AIR_OK; ++i) {
        size_t element = 0;
        status = sparse_target(at, accessor, i, &element);
        if (status == AIR_OK)
            status =
                store_index(at, accessor, accessor->sparse_values + i * accessor->component_size,
                            element, vertex_count, values);
    }
    return status;
}

air_status air_gltf_read_indices(air_gltf *gltf, const air_json *at, size_t vertex_count,
                                 uint32_t **out_values, size_t *out_count)
{
    air_json place;
    air_accessor accessor = {0};
    air_status status = find_accessor(gltf, at, &place);
    if (status == AIR_OK)
        status = open_accessor(gltf, &place, &accessor);
    if (status != AIR_OK)
        return status;
    const bool whole = accessor.component == AIR_COMPONENT_UNSIGNED_BYTE ||
                       accessor.component == AIR_COMPONENT_UNSIGNED_SHORT ||
                       accessor.component == AIR_COMPONENT_UNSIGNED_INT;
    if (accessor.components != 1 || !whole)
        return air_json_fail(
            &place, AIR_ERROR_FORMAT,
            "expected \"SCALAR\" of component type 5121, 5123 or 5125 for indices");
    uint32_t *values = air_allocate(gltf->context, accessor.count, sizeof *values);
    if (values == NULL)
        return air_fail_memory(gltf->context, gltf->path);
    status = store_indices(&place, &accessor, vertex_count, values);
    if (status != AIR_OK) {
        air_free(gltf->context, values);
        return status;
    }
    *out_values = values;
    *out_count = accessor.count;
    return AIR_OK;
}

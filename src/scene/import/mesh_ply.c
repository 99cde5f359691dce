/* mesh_ply.c: PLY, ascii and binary [Turk1994]: the elements "vertex" and "face", in this order;
 * others, and properties without a meaning here, are passed by. */
#include <math.h>
#include <string.h>

#include "image/srgb.h"
#include "scene/import/mesh_decode.h"
#include "scene/import/mesh_polygon.h"
#include "scene/import/number.h"

enum { PLY_MOST_ELEMENTS = 32, PLY_MOST_PROPERTIES = 256 };

typedef enum ply_type {
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT32,
    PLY_FLOAT64,
    PLY_NONE
} ply_type;

/* What a property of a vertex is; the first SLOT_COUNT are kept. */
typedef enum ply_slot {
    SLOT_X,
    SLOT_Y,
    SLOT_Z,
    SLOT_NX,
    SLOT_NY,
    SLOT_NZ,
    SLOT_U,
    SLOT_V,
    SLOT_RED,
    SLOT_GREEN,
    SLOT_BLUE,
    SLOT_ALPHA,
    SLOT_COUNT
} ply_slot;

typedef enum ply_encoding { PLY_ASCII, PLY_LITTLE, PLY_BIG } ply_encoding;

/* A word of the header, not ended by a NUL. */
typedef struct ply_word {
    const char *text;
    size_t length;
} ply_word;

typedef struct ply_property {
    ply_word name;
    ply_type type;
    ply_type count_type; /* of lists; PLY_NONE: one value */
} ply_property;

typedef struct ply_element {
    ply_word name;
    size_t count;
    size_t first, property_count;
} ply_element;

typedef struct ply_reader {
    air_context *context;
    const char *path;
    const char *data, *at, *end;
    ply_encoding encoding;
    ply_element elements[PLY_MOST_ELEMENTS];
    size_t element_count;
    ply_property properties[PLY_MOST_PROPERTIES];
    size_t property_count;
    size_t index_capacity;    /* of the triangles' array */
    size_t polygon_capacity;  /* corners */
    air_mesh_polygon polygon; /* the face at hand */
    uint32_t *corners;        /* its vertices */
} ply_reader;

/* Names the line of text, or the byte of data. */
static air_status fail_at(const ply_reader *reader, const char *at, const char *expected)
{
    if (reader->encoding != PLY_ASCII)
        return air_fail(reader->context, AIR_ERROR_FORMAT, "%s: byte %zu: expected %s",
                        reader->path, (size_t)(at - reader->data), expected);
    size_t line = 1;
    for (const char *c = reader->data; c < at; ++c)
        line += *c == '\n';
    return air_fail(reader->context, AIR_ERROR_FORMAT, "%s: line %zu: expected %s", reader->path,
                    line, expected);
}

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/* ---- header ---- */

static bool is_word(ply_word word, const char *text)
{
    return strlen(text) == word.length && memcmp(word.text, text, word.length) == 0;
}

/* The next word of [*at, end); of no length behind the last. */
static ply_word next_word(const char **at, const char *end)
{
    while (*at < end && is_blank(**at))
        ++*at;
    const char *const begin = *at;
    while (*at < end && !is_blank(**at))
        ++*at;
    return (ply_word){begin, (size_t)(*at - begin)};
}

static ply_type find_type(ply_word word)
{
    static const char *const names[PLY_NONE][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    for (int i = 0; i < PLY_NONE; ++i) {
        if (is_word(word, names[i][0]) || is_word(word, names[i][1]))
            return (ply_type)i;
    }
    return PLY_NONE;
}

static air_status read_format(ply_reader *reader, const char *at, const char *end)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const ply_word name = next_word(&at, end), version = next_word(&at, end);
    for (int i = 0; i < 3; ++i) {
        if (is_word(name, names[i]) && is_word(version, "1.0")) {
            reader->encoding = (ply_encoding)i;
            return AIR_OK;
        }
    }
    return fail_at(reader, name.text,
                   "ascii, binary_little_endian or binary_big_endian, and version 1.0");
}

static air_status read_element(ply_reader *reader, const char *at, const char *end)
{
    double count = -1.0;
    const ply_word name = next_word(&at, end), number = next_word(&at, end);
    if (number.length == 0 ||
        air_number_scan(number.text, number.text + number.length, &count) !=
            number.text + number.length ||
        !(count >= 0.0 && count < 4294967295.0 && count == floor(count)))
        return fail_at(reader, name.text, "an element's name and its count, below 2^32 - 1");
    if (reader->element_count == PLY_MOST_ELEMENTS)
        return fail_at(reader, name.text, "no more than 32 elements");
    reader->elements[reader->element_count++] =
        (ply_element){.name = name, .count = (size_t)count, .first = reader->property_count};
    return AIR_OK;
}

static air_status read_property(ply_reader *reader, const char *at, const char *end)
{
    ply_property property = {.count_type = PLY_NONE};
    ply_word word = next_word(&at, end);
    const char *const begin = word.text;
    const bool list = is_word(word, "list");
    if (list) {
        property.count_type = find_type(next_word(&at, end));
        word = next_word(&at, end);
    }
    property.type = find_type(word);
    property.name = next_word(&at, end);
    if (property.type == PLY_NONE || property.name.length == 0 ||
        (list && property.count_type >= PLY_FLOAT32))
        return fail_at(reader, begin, "a property's type, char to double or a list, and its name");
    if (reader->element_count == 0 || reader->property_count == PLY_MOST_PROPERTIES)
        return fail_at(reader, begin, "an element before, and no more than 256 properties");
    reader->properties[reader->property_count++] = property;
    ++reader->elements[reader->element_count - 1].property_count;
    return AIR_OK;
}

static air_status read_header(ply_reader *reader)
{
    bool format = false;
    for (size_t number = 0;; ++number) {
        const char *const begin = reader->at;
        const char *newline = memchr(begin, '\n', (size_t)(reader->end - begin));
        if (newline == NULL)
            return fail_at(reader, begin, "a PLY header, from \"ply\" to \"end_header\"");
        reader->at = newline + 1;
        const char *at = begin;
        const ply_word word = next_word(&at, newline);
        air_status status = AIR_OK;
        if (number == 0 ? !is_word(word, "ply") : !format && is_word(word, "element"))
            return fail_at(reader, begin, "\"ply\" and a format first");
        if (is_word(word, "end_header"))
            return format ? AIR_OK : fail_at(reader, begin, "a format before");
        if (is_word(word, "format")) {
            status = read_format(reader, at, newline);
            format = true;
        } else if (is_word(word, "element")) {
            status = read_element(reader, at, newline);
        } else if (is_word(word, "property")) {
            status = read_property(reader, at, newline);
        } else if (number > 0 && word.length > 0 && !is_word(word, "comment") &&
                   !is_word(word, "obj_info")) {
            return fail_at(reader, begin, "format, comment, element, property or end_header");
        }
        if (status != AIR_OK)
            return status;
    }
}

/* ---- values ---- */

static size_t type_size(ply_type type)
{
    static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8, 0};
    return sizes[type];
}

static double decode_value(const uint8_t bytes[8], ply_type type)
{
    union {
        int8_t i8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } value;
    memcpy(&value, bytes, type_size(type));
    switch (type) {
    case PLY_INT8:
        return value.i8;
    case PLY_INT16:
        return value.i16;
    case PLY_UINT16:
        return value.u16;
    case PLY_INT32:
        return value.i32;
    case PLY_UINT32:
        return value.u32;
    case PLY_FLOAT32:
        return (double)value.f32;
    case PLY_FLOAT64:
        return value.f64;
    case PLY_UINT8:
    case PLY_NONE:
        break;
    }
    return bytes[0];
}

/* One value; false where none is. */
static bool read_value(ply_reader *reader, ply_type type, double *out)
{
    if (reader->encoding == PLY_ASCII) {
        while (reader->at < reader->end && is_blank(*reader->at))
            ++reader->at;
        const char *behind = air_number_scan(reader->at, reader->end, out);
        if (behind == NULL || (behind < reader->end && !is_blank(*behind)))
            return false;
        reader->at = behind;
        return true;
    }
    const size_t size = type_size(type);
    uint8_t bytes[8];
    if ((size_t)(reader->end - reader->at) < size)
        return false;
    memcpy(bytes, reader->at, size);
    if (reader->encoding == PLY_BIG) {
        for (size_t i = 0; i < size / 2; ++i) {
            const uint8_t byte = bytes[i];
            bytes[i] = bytes[size - 1 - i];
            bytes[size - 1 - i] = byte;
        }
    }
    reader->at += size;
    *out = decode_value(bytes, type);
    return true;
}

/* Bytes that a value takes at least: in text a digit and a blank, which the last can lack. */
static size_t least_size(const ply_reader *reader, ply_type type)
{
    return reader->encoding == PLY_ASCII ? 2 : type_size(type);
}

/* How many values a property has: 1, or the length of a list that the rest of the file can hold. */
static air_status read_length(ply_reader *reader, const ply_property *property, size_t *out)
{
    double count = 1.0;
    const char *const begin = reader->at;
    if (property->count_type != PLY_NONE) {
        const bool ok = read_value(reader, property->count_type, &count);
        const size_t most =
            ((size_t)(reader->end - reader->at) + 1) / least_size(reader, property->type);
        if (!ok || !(count >= 0.0 && count <= (double)most && count == floor(count)))
            return fail_at(reader, begin, "the length of a list that the file has room for");
    }
    *out = (size_t)count;
    return AIR_OK;
}

static air_status skip_property(ply_reader *reader, const ply_property *property)
{
    size_t count = 0;
    const air_status status = read_length(reader, property, &count);
    for (size_t i = 0; status == AIR_OK && i < count; ++i) {
        double value = 0.0;
        if (!read_value(reader, property->type, &value))
            return fail_at(reader, reader->at, "a number");
    }
    return status;
}

/* Can the rest of the file hold all rows? So memory is in proportion to it. */
static air_status check_rows(const ply_reader *reader, const ply_element *element)
{
    size_t row = 0;
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = &reader->properties[element->first + i];
        row += least_size(reader,
                          property->count_type != PLY_NONE ? property->count_type : property->type);
    }
    if (row > 0 && element->count > ((size_t)(reader->end - reader->at) + 1) / row)
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: expected %zu rows of the element %.*s, the file ends before",
                        reader->path, element->count, (int)element->name.length,
                        element->name.text);
    return AIR_OK;
}

static air_status skip_element(ply_reader *reader, const ply_element *element)
{
    air_status status = AIR_OK;
    const size_t rows = element->property_count > 0 ? element->count : 0;
    for (size_t row = 0; row < rows; ++row) {
        for (size_t i = 0; status == AIR_OK && i < element->property_count; ++i)
            status = skip_property(reader, &reader->properties[element->first + i]);
        if (status != AIR_OK)
            return status;
    }
    return AIR_OK;
}

/* ---- vertices ---- */

static ply_slot find_slot(const ply_property *property)
{
    static const char *const names[SLOT_COUNT][4] = {{"x"},
                                                     {"y"},
                                                     {"z"},
                                                     {"nx"},
                                                     {"ny"},
                                                     {"nz"},
                                                     {"u", "s", "texture_u", "texture_s"},
                                                     {"v", "t", "texture_v", "texture_t"},
                                                     {"red", "r", "diffuse_red"},
                                                     {"green", "g", "diffuse_green"},
                                                     {"blue", "b", "diffuse_blue"},
                                                     {"alpha", "a", "diffuse_alpha"}};
    for (int slot = 0; slot < SLOT_COUNT && property->count_type == PLY_NONE; ++slot) {
        for (int i = 0; i < 4 && names[slot][i] != NULL; ++i) {
            if (is_word(property->name, names[slot][i]))
                return (ply_slot)slot;
        }
    }
    return SLOT_COUNT;
}

/* Bytes and words are sRGB over their whole range, as scanners write them; floats are linear.
 * Alpha is linear always. */
static float decode_color(ply_type type, ply_slot slot, double value)
{
    if (type == PLY_FLOAT32 || type == PLY_FLOAT64)
        return (float)value;
    const double most = type == PLY_UINT8 ? 255.0 : type == PLY_UINT16 ? 65535.0 : 127.0;
    const float share = (float)fmin(fmax(value / most, 0.0), 1.0);
    return slot == SLOT_ALPHA ? share : srgb_decode(share);
}

static air_status allocate_vertices(const ply_reader *reader, const ply_element *element,
                                    const bool has[SLOT_COUNT], air_mesh_file *out)
{
    const struct {
        ply_slot first;
        size_t needed, width;
        float **array;
    } attributes[] = {{SLOT_X, 3, 3, &out->positions},
                      {SLOT_NX, 3, 3, &out->normals},
                      {SLOT_U, 2, 2, &out->uv},
                      {SLOT_RED, 3, 4, &out->colors}};
    if (element->count == 0)
        return air_fail(reader->context, AIR_ERROR_FORMAT, "%s: expected at least one vertex",
                        reader->path);
    if (!has[SLOT_X] || !has[SLOT_Y] || !has[SLOT_Z])
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: expected vertices with the properties x, y and z", reader->path);
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes; ++i) {
        size_t found = 0;
        for (size_t k = 0; k < attributes[i].needed; ++k)
            found += has[attributes[i].first + k];
        if (found < attributes[i].needed)
            continue;
        *attributes[i].array =
            air_allocate(reader->context, element->count * attributes[i].width, sizeof(float));
        if (*attributes[i].array == NULL)
            return air_fail_memory(reader->context, reader->path);
    }
    out->vertex_count = element->count;
    return AIR_OK;
}

static void store_vertex(air_mesh_file *out, size_t i, const float values[SLOT_COUNT])
{
    memcpy(out->positions + 3 * i, values + SLOT_X, 3 * sizeof(float));
    if (out->normals != NULL)
        memcpy(out->normals + 3 * i, values + SLOT_NX, 3 * sizeof(float));
    if (out->uv != NULL)
        memcpy(out->uv + 2 * i, values + SLOT_U, 2 * sizeof(float));
    if (out->colors != NULL)
        memcpy(out->colors + 4 * i, values + SLOT_RED, 4 * sizeof(float));
}

static air_status read_vertex(ply_reader *reader, const ply_element *element, const ply_slot *slots,
                              float values[SLOT_COUNT])
{
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = &reader->properties[element->first + i];
        const char *const begin = reader->at;
        if (slots[i] == SLOT_COUNT) {
            const air_status status = skip_property(reader, property);
            if (status != AIR_OK)
                return status;
            continue;
        }
        double value = 0.0;
        if (!read_value(reader, property->type, &value) || !isfinite((float)value))
            return fail_at(reader, begin, "a finite number");
        values[slots[i]] =
            slots[i] >= SLOT_RED ? decode_color(property->type, slots[i], value) : (float)value;
    }
    return AIR_OK;
}

static air_status read_vertices(ply_reader *reader, const ply_element *element, air_mesh_file *out)
{
    ply_slot slots[PLY_MOST_PROPERTIES];
    bool has[SLOT_COUNT + 1] = {false};
    for (size_t i = 0; i < element->property_count; ++i) {
        slots[i] = find_slot(&reader->properties[element->first + i]);
        has[slots[i]] = true;
    }
    air_status status = allocate_vertices(reader, element, has, out);
    float values[SLOT_COUNT] = {[SLOT_ALPHA] = 1.0f};
    for (size_t i = 0; status == AIR_OK && i < element->count; ++i) {
        status = read_vertex(reader, element, slots, values);
        store_vertex(out, i, values);
    }
    return status;
}

/* ---- faces ---- */

static air_status reserve_corners(ply_reader *reader, size_t count)
{
    if (count <= reader->polygon_capacity)
        return AIR_OK;
    air_context *context = reader->context;
    air_mesh_polygon_finish(context, &reader->polygon);
    air_free(context, reader->corners);
    reader->corners = air_allocate(context, 2 * count, sizeof *reader->corners);
    reader->polygon_capacity = 2 * count;
    if (!air_mesh_polygon_init(context, 2 * count, &reader->polygon) || reader->corners == NULL)
        return air_fail_memory(context, reader->path);
    return AIR_OK;
}

static air_status reserve_triangles(ply_reader *reader, size_t count, air_mesh_file *out)
{
    const size_t needed = out->triangle_count + count;
    if (needed <= reader->index_capacity)
        return AIR_OK;
    const size_t capacity = needed + needed / 2;
    uint32_t *indices =
        air_reallocate(reader->context, out->indices, capacity, 3 * sizeof *indices);
    if (indices == NULL)
        return air_fail_memory(reader->context, reader->path);
    out->indices = indices;
    reader->index_capacity = capacity;
    return AIR_OK;
}

static air_status read_corners(ply_reader *reader, const ply_property *property, size_t count,
                               const air_mesh_file *out)
{
    air_mesh_polygon_begin(&reader->polygon);
    for (size_t i = 0; i < count; ++i) {
        const char *const begin = reader->at;
        double value = -1.0;
        if (!read_value(reader, property->type, &value) ||
            !(value >= 0.0 && value < (double)out->vertex_count && value == floor(value)))
            return fail_at(reader, begin, "the index of a vertex");
        reader->corners[i] = (uint32_t)value;
        air_mesh_polygon_add(&reader->polygon, out->positions + 3 * (size_t)value);
    }
    return AIR_OK;
}

static air_status read_face(ply_reader *reader, const ply_property *property, air_mesh_file *out)
{
    const char *const begin = reader->at;
    size_t count = 0;
    air_status status = read_length(reader, property, &count);
    if (status == AIR_OK && count < 3)
        status = fail_at(reader, begin, "a face of 3 corners or more");
    if (status == AIR_OK)
        status = reserve_corners(reader, count);
    if (status == AIR_OK)
        status = read_corners(reader, property, count, out);
    if (status == AIR_OK)
        status = reserve_triangles(reader, count - 2, out);
    if (status != AIR_OK)
        return status;
    const size_t triangles = air_mesh_polygon_triangulate(&reader->polygon);
    uint32_t *indices = out->indices + 3 * out->triangle_count;
    for (size_t i = 0; i < 3 * triangles; ++i)
        indices[i] = reader->corners[reader->polygon.triangles[i / 3][i % 3]];
    out->triangle_count += triangles;
    return AIR_OK;
}

static bool is_corners(const ply_property *property)
{
    return property->count_type != PLY_NONE &&
           (is_word(property->name, "vertex_indices") || is_word(property->name, "vertex_index"));
}

static air_status read_faces(ply_reader *reader, const ply_element *element, air_mesh_file *out)
{
    const ply_property *properties = &reader->properties[element->first];
    size_t lists = 0;
    for (size_t i = 0; i < element->property_count; ++i)
        lists += is_corners(&properties[i]);
    if (lists != 1 || out->positions == NULL)
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: expected faces behind vertices, with one list vertex_indices or "
                        "vertex_index",
                        reader->path);
    air_status status = reserve_triangles(reader, element->count, out);
    for (size_t row = 0; status == AIR_OK && row < element->count; ++row) {
        for (size_t i = 0; status == AIR_OK && i < element->property_count; ++i)
            status = is_corners(&properties[i]) ? read_face(reader, &properties[i], out)
                                                : skip_property(reader, &properties[i]);
    }
    return status;
}

/* ---- the file ---- */

static air_status read_elements(ply_reader *reader, air_mesh_file *out)
{
    air_status status = AIR_OK;
    for (size_t i = 0; status == AIR_OK && i < reader->element_count; ++i) {
        const ply_element *element = &reader->elements[i];
        status = check_rows(reader, element);
        if (status != AIR_OK)
            return status;
        if (is_word(element->name, "vertex") && out->positions == NULL)
            status = read_vertices(reader, element, out);
        else if (is_word(element->name, "face"))
            status = read_faces(reader, element, out);
        else
            status = skip_element(reader, element);
    }
    return status;
}

air_status air_mesh_ply_decode(air_context *context, const char *path, const uint8_t *data,
                               size_t size, air_mesh_file *out)
{
    const char *text = (const char *)data;
    ply_reader reader = {
        .context = context, .path = path, .data = text, .at = text, .end = text + size};
    air_status status = read_header(&reader);
    if (status == AIR_OK)
        status = read_elements(&reader, out);
    air_free(context, reader.corners);
    air_mesh_polygon_finish(context, &reader.polygon);
    return status;
}

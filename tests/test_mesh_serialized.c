#include <stdio.h>
#include <zlib.h>

#include "mesh_fixture.h"

enum { NORMALS = 1, UV = 2, COLORS = 8, FACE_NORMALS = 16, SINGLE = 0x1000, DOUBLE = 0x2000 };
enum { MOST_BYTES = 8192 };

typedef struct byte_row {
    uint8_t bytes[MOST_BYTES];
    size_t size;
} byte_row;

static void put(byte_row *row, const void *data, size_t size)
{
    assert_true(row->size + size <= sizeof row->bytes);
    memcpy(row->bytes + row->size, data, size);
    row->size += size;
}

static void put_unsigned(byte_row *row, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; ++i) {
        const uint8_t byte = (uint8_t)(value >> 8 * i);
        put(row, &byte, 1);
    }
}

static void put_number(byte_row *row, uint32_t flags, double value)
{
    const float single = (float)value;
    if ((flags & DOUBLE) != 0)
        put(row, &value, sizeof value);
    else
        put(row, &single, sizeof single);
}

/* A shape of three vertices at (base + i, i, -1), i = 0 to 2, before compression. */
static byte_row shape_content(uint64_t version, uint32_t flags, double base)
{
    byte_row row = {.size = 0};
    put_unsigned(&row, flags, 4);
    if (version == 4)
        put(&row, "a name", 7);
    put_unsigned(&row, 3, 8);
    put_unsigned(&row, 1, 8);
    for (int i = 0; i < 3; ++i) {
        put_number(&row, flags, base + i);
        put_number(&row, flags, i);
        put_number(&row, flags, -1.0);
    }
    for (int i = 0; (flags & NORMALS) != 0 && i < 9; ++i)
        put_number(&row, flags, i % 3 == 2 ? 1.0 : 0.0);
    for (int i = 0; (flags & UV) != 0 && i < 6; ++i)
        put_number(&row, flags, 0.125 * i);
    for (int i = 0; (flags & COLORS) != 0 && i < 9; ++i)
        put_number(&row, flags, 0.25 * (i % 3));
    for (uint32_t i = 0; i < 3; ++i)
        put_unsigned(&row, 2 - i, 4);
    return row;
}

static void put_shape(byte_row *file, uint64_t version, const byte_row *content)
{
    uint8_t packed[MOST_BYTES];
    uLongf size = sizeof packed;
    assert_int_equal(compress(packed, &size, content->bytes, content->size), Z_OK);
    put_unsigned(file, 0x041c, 2);
    put_unsigned(file, version, 2);
    put(file, packed, size);
}

static void put_dictionary(byte_row *file, uint64_t version, const uint64_t *offsets, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        put_unsigned(file, offsets[i], version == 3 ? 4 : 8);
    put_unsigned(file, count, 4);
}

static byte_row single_shape(uint64_t version, const byte_row *content)
{
    byte_row file = {.size = 0};
    put_shape(&file, version, content);
    put_dictionary(&file, version, &(uint64_t){0}, 1);
    return file;
}

static void refuse(const byte_row *file, const char *part)
{
    mesh_expect_refusal(AIR_MESH_SERIALIZED, file->bytes, file->size, part);
}

static void expect_array(const float *array, size_t count, float (*expected)(size_t i))
{
    assert_non_null(array);
    for (size_t i = 0; i < count; ++i)
        assert_true(array[i] == expected(i));
}

static float up(size_t i) { return i % 3 == 2 ? 1.0f : 0.0f; }
static float eighths(size_t i) { return 0.125f * (float)i; }
static float grey(size_t i) { return i % 4 == 3 ? 1.0f : 0.25f * (float)(i % 4); }

/* Every combination of version, precision and arrays. */
static void all_variants_are_read(void **state)
{
    (void)state;
    for (uint32_t variant = 0; variant < 64; ++variant) {
        const uint64_t version = 3 + variant % 2;
        const uint32_t flags = ((variant & 2) != 0 ? DOUBLE : SINGLE) |
                               ((variant & 4) != 0 ? NORMALS : 0) | ((variant & 8) != 0 ? UV : 0) |
                               ((variant & 16) != 0 ? COLORS : 0) |
                               ((variant & 32) != 0 ? FACE_NORMALS : 0);
        const byte_row content = shape_content(version, flags, 5.0);
        const byte_row file = single_shape(version, &content);
        memory_file host;
        air_mesh_file mesh;
        memory_file_init(&host);
        assert_int_equal(mesh_read(&host, AIR_MESH_SERIALIZED, file.bytes, file.size, &mesh),
                         AIR_OK);
        assert_int_equal(mesh.vertex_count, 3);
        assert_int_equal(mesh.triangle_count, 1);
        assert_true(mesh.positions[3] == 6.0f && mesh.positions[5] == -1.0f);
        assert_true(mesh.indices[0] == 2 && mesh.indices[2] == 0);
        assert_int_equal(mesh.normals != NULL, (flags & (NORMALS | FACE_NORMALS)) == NORMALS);
        assert_int_equal(mesh.uv != NULL, (flags & UV) != 0);
        assert_int_equal(mesh.colors != NULL, (flags & COLORS) != 0);
        if (mesh.normals != NULL)
            expect_array(mesh.normals, 9, up);
        if (mesh.uv != NULL)
            expect_array(mesh.uv, 6, eighths);
        if (mesh.colors != NULL)
            expect_array(mesh.colors, 12, grey);
        air_mesh_file_finish(host.context, &mesh);
        memory_file_finish(&host);
    }
}

static void shapes_are_found_by_their_number(void **state)
{
    (void)state;
    for (uint64_t version = 3; version <= 4; ++version) {
        byte_row file = {.size = 0};
        uint64_t offsets[3];
        for (int i = 0; i < 3; ++i) {
            const byte_row content = shape_content(version, SINGLE, 10.0 * i);
            offsets[i] = file.size;
            put_shape(&file, version, &content);
        }
        put_dictionary(&file, version, offsets, 3);
        memory_file host;
        memory_file_init(&host);
        memory_file_serve(&host, file.bytes, file.size);
        for (size_t i = 0; i < 3; ++i) {
            air_mesh_file mesh;
            assert_int_equal(
                air_mesh_file_read(host.context, "file", AIR_MESH_SERIALIZED, i, &mesh), AIR_OK);
            assert_true(mesh.positions[0] == 10.0f * (float)i);
            air_mesh_file_finish(host.context, &mesh);
        }
        air_mesh_file none;
        assert_int_equal(air_mesh_file_read(host.context, "file", AIR_MESH_SERIALIZED, 3, &none),
                         AIR_ERROR_ARGUMENT);
        memory_file_expect(&host, "shape 3 is asked for, but the file has 3");
        memory_file_finish(&host);
    }
}

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    const byte_row content = shape_content(4, SINGLE | NORMALS, 0.0);
    byte_row file = {.size = 0};
    refuse(&file, "byte 0: expected a shape");
    file = single_shape(4, &content);
    file.bytes[0] = 0;
    refuse(&file, "byte 0: expected a shape, which begins with 1c 04");
    file = single_shape(4, &content);
    file.bytes[2] = 5;
    refuse(&file, "byte 2: version 5, expected 3 or 4");
    file = single_shape(4, &content);
    file.bytes[file.size - 2] = 1;
    refuse(&file, "65537 shapes, expected 1 to");
    file = single_shape(4, &content);
    file.bytes[file.size - 12] = 200;
    refuse(&file, "expected a shape");
    file = single_shape(4, &content);
    file.bytes[12] ^= 0x55;
    refuse(&file, "expected");
    /* the stream ends before all is there; its counts are as they should be */
    byte_row part = content;
    part.size -= 4;
    file = single_shape(4, &part);
    refuse(&file, "shape 0: expected indices, its zlib stream ends before");
}

static void contents_are_checked(void **state)
{
    (void)state;
    const size_t counts = 4, positions = counts + 16;
    byte_row content = shape_content(3, SINGLE, 0.0);
    content.bytes[content.size - 4] = 3;
    byte_row file = single_shape(3, &content);
    refuse(&file, "shape 0: triangle 0: index 3, expected one below the 3 vertices");
    content = shape_content(3, SINGLE, 0.0);
    memcpy(content.bytes + positions + 16, &(float){NAN}, 4);
    file = single_shape(3, &content);
    refuse(&file, "shape 0: vertex 1: expected finite positions");
    content = shape_content(3, DOUBLE, 1e39); /* above the range of floats */
    file = single_shape(3, &content);
    refuse(&file, "vertex 0: expected finite positions");
    /* 2^32 and 2^40 vertices: no memory is asked for */
    for (size_t byte = 4; byte < 6; ++byte) {
        content = shape_content(3, SINGLE, 0.0);
        content.bytes[counts + byte] = 1;
        file = single_shape(3, &content);
        refuse(&file, "numbers of vertices and triangles that the file has room for");
        content = shape_content(3, SINGLE, 0.0);
        content.bytes[counts + 8 + byte] = 1;
        file = single_shape(3, &content);
        refuse(&file, "numbers of vertices and triangles that the file has room for");
    }
}

static void failing_allocations_are_survived(void **state)
{
    (void)state;
    const byte_row content = shape_content(4, SINGLE | NORMALS | UV | COLORS, 0.0);
    const byte_row file = single_shape(4, &content);
    mesh_expect_survival(AIR_MESH_SERIALIZED, file.bytes, file.size);
}

static void a_scene_of_others_is_read(void **state)
{
    (void)state;
    air_context *context = NULL;
    size_t triangles = 0;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    const char *path = AIR_SHARED_DIR "/scenes/lajolla_sponza/sponza.serialized";
    air_status status = AIR_OK;
    for (size_t shape = 0; status == AIR_OK && shape < 37; ++shape) {
        air_mesh_file mesh;
        status = air_mesh_file_read(context, path, AIR_MESH_SERIALIZED, shape, &mesh);
        if (status == AIR_OK) {
            triangles += mesh.triangle_count;
            air_mesh_file_finish(context, &mesh);
        }
    }
    air_context_destroy(context);
    if (status == AIR_ERROR_IO) {
        print_message("%s is absent\n", path);
        skip();
    }
    assert_int_equal(status, AIR_OK);
    assert_int_equal(triangles, 66445); /* as its authors say */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_variants_are_read),
        cmocka_unit_test(shapes_are_found_by_their_number),
        cmocka_unit_test(what_is_wrong_is_named),
        cmocka_unit_test(contents_are_checked),
        cmocka_unit_test(failing_allocations_are_survived),
        cmocka_unit_test(a_scene_of_others_is_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

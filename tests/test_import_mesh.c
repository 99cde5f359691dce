/* Accessors and primitives: component types, sparse, strides, topologies, and what is refused. */
#include <math.h>

#include "import_fixture.h"

/* A scene of one primitive whose data are in data.bin, from the parts that differ. */
#define PRIMITIVE(primitive, accessors, views, length)                                             \
    "{" GLTF_SCENE ",'nodes':[{'mesh':0}],'meshes':[{'primitives':[{" primitive                    \
    "}]}],'accessors':[" accessors "],'bufferViews':[" views                                       \
    "],'buffers':[{'uri':'data.bin','byteLength':" length "}]}"

#define POSITION_ACCESSOR "{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'}"
#define POSITION_VIEW     "{'buffer':0,'byteLength':48}"

/* The unit square, counter-clockwise from the origin. */
static const float square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

typedef struct data_file {
    uint8_t bytes[256];
    size_t size;
} data_file;

static void add_bytes(data_file *file, const void *bytes, size_t size)
{
    assert_true(file->size + size <= sizeof file->bytes);
    memcpy(file->bytes + file->size, bytes, size);
    file->size += size;
}

/* data.bin starts with the square's positions. */
static void start(import_fixture *f, data_file *file)
{
    import_init(f);
    *file = (data_file){0};
    add_bytes(file, square, sizeof square);
}

static void serve(import_fixture *f, const data_file *file)
{
    import_serve(f, "data.bin", file->bytes, file->size);
}

static const air_mesh *only_mesh(const import_fixture *f)
{
    assert_int_equal(f->snapshot->mesh_count, 1);
    return f->snapshot->meshes[0];
}

static void expect_indices(const import_fixture *f, const uint32_t *indices, size_t triangle_count)
{
    const air_mesh *mesh = only_mesh(f);
    assert_int_equal(mesh->triangle_count, triangle_count);
    assert_memory_equal(mesh->indices, indices, 3 * triangle_count * sizeof *indices);
}

static void indices_of_every_type_mean_the_same(void **state)
{
    (void)state;
    static const uint8_t as_8[6] = {0, 1, 2, 0, 2, 3};
    static const uint16_t as_16[6] = {0, 1, 2, 0, 2, 3};
    static const uint32_t as_32[6] = {0, 1, 2, 0, 2, 3};
    const struct {
        const void *data;
        size_t size;
        int type;
    } cases[] = {
        {as_8, sizeof as_8, 5121}, {as_16, sizeof as_16, 5123}, {as_32, sizeof as_32, 5125}};
    for (size_t i = 0; i < 3; ++i) {
        import_fixture f;
        data_file file;
        start(&f, &file);
        add_bytes(&file, cases[i].data, cases[i].size);
        serve(&f, &file);
        assert_int_equal(
            import_format(
                &f,
                PRIMITIVE("'attributes':{'POSITION':0},'indices':1",
                          POSITION_ACCESSOR
                          ",{'bufferView':1,'componentType':%d,'count':6,'type':'SCALAR'}",
                          POSITION_VIEW ",{'buffer':0,'byteOffset':48,'byteLength':%zu}", "%zu"),
                cases[i].type, cases[i].size, file.size),
            AIR_OK);
        expect_indices(&f, as_32, 2);
        import_finish(&f);
    }
}

/* ---- topologies ---- */

static void strips_and_fans_become_triangles_of_one_orientation(void **state)
{
    (void)state;
    import_fixture f;
    data_file file;
    start(&f, &file);
    serve(&f, &file);
    /* the second of a strip is turned: v1 v3 v2 (section 3.7.2.1) */
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0},'mode':5", POSITION_ACCESSOR,
                               POSITION_VIEW, "48"));
    expect_indices(&f, (const uint32_t[]){0, 1, 2, 1, 3, 2}, 2);
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0},'mode':6", POSITION_ACCESSOR,
                               POSITION_VIEW, "48"));
    expect_indices(&f, (const uint32_t[]){1, 2, 0, 2, 3, 0}, 2);
    import_finish(&f);
}

static void a_list_that_does_not_divide_by_three_is_cut_with_a_warning(void **state)
{
    (void)state;
    import_fixture f;
    data_file file;
    start(&f, &file);
    serve(&f, &file);
    import_loads(&f,
                 PRIMITIVE("'attributes':{'POSITION':0}", POSITION_ACCESSOR, POSITION_VIEW, "48"));
    expect_indices(&f, (const uint32_t[]){0, 1, 2}, 1);
    import_expect(&f, AIR_MESSAGE_WARNING,
                  "triangle lists that do not divide by three, cut short: 1");
    import_finish(&f);
}

static void points_and_lines_are_left_out_with_a_warning(void **state)
{
    (void)state;
    import_fixture f;
    data_file file;
    start(&f, &file);
    serve(&f, &file);
    import_loads(
        &f,
        PRIMITIVE("'attributes':{'POSITION':0},'mode':0},{'attributes':{'POSITION':0},'mode':3},"
                  "{'attributes':{'POSITION':0},'mode':6",
                  POSITION_ACCESSOR, POSITION_VIEW, "48"));
    assert_int_equal(f.snapshot->triangle_count, 2);
    import_expect(&f, AIR_MESSAGE_WARNING, "primitives of points or lines left out: 2");
    import_refuses(
        &f,
        PRIMITIVE("'attributes':{'POSITION':0},'mode':7", POSITION_ACCESSOR, POSITION_VIEW, "48"),
        AIR_ERROR_FORMAT,
        "room.gltf: $.meshes[0].primitives[0].mode: expected the index of a primitive mode, of "
        "which there "
        "are 7, found 7");
    import_finish(&f);
}

static void triangles_without_area_are_left_out_and_counted(void **state)
{
    (void)state;
    static const uint8_t indices[9] = {0, 1, 1, 0, 1, 2, 3, 3, 3};
    import_fixture f;
    data_file file;
    start(&f, &file);
    add_bytes(&file, indices, sizeof indices);
    serve(&f, &file);
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0},'indices':1",
                               POSITION_ACCESSOR
                               ",{'bufferView':1,'componentType':5121,'count':9,'type':'SCALAR'}",
                               POSITION_VIEW ",{'buffer':0,'byteOffset':48,'byteLength':9}", "57"));
    expect_indices(&f, (const uint32_t[]){0, 1, 2}, 1);
    import_expect(&f, AIR_MESSAGE_INFO, "triangles without area left out: 2");
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_finish(&f);
}

/* ---- numbers ---- */

static void expect_positions(const import_fixture *f, const float *expected, size_t count)
{
    const air_mesh *mesh = only_mesh(f);
    for (size_t i = 0; i < count; ++i)
        if (fabsf(mesh->positions[i] - expected[i]) >
            1e-6f) /* one rounding of a division below 1 */
            fail_msg("position %zu is %g, not %g", i, (double)mesh->positions[i],
                     (double)expected[i]);
}

#define THREE(component, extra)                                                                    \
    "{'bufferView':0,'componentType':" component ",'count':3,'type':'VEC3'" extra "}"

static void quantised_positions_are_scaled_as_they_say(void **state)
{
    (void)state;
    static const int16_t shorts[9] = {0, 0, 0, 32767, 0, 0, 0, -32768, 0};
    static const int8_t bytes[12] = {0, 0, 0, 99, 100, 0, 0, 99, 0, -100, 7, 99};
    import_fixture f;
    import_init(&f);
    import_serve(&f, "data.bin", shorts, sizeof shorts);
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0}", THREE("5122", ",'normalized':true"),
                               "{'buffer':0,'byteLength':18}", "18"));
    expect_positions(&f, (const float[]){0, 0, 0, 1, 0, 0, 0, -1, 0},
                     9); /* -32768 is clamped to -1 */
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0}", THREE("5123", ""),
                               "{'buffer':0,'byteLength':18}", "18"));
    expect_positions(&f, (const float[]){0, 0, 0, 32767, 0, 0, 0, 32768, 0}, 9);
    /* three bytes of every four */
    import_serve(&f, "data.bin", bytes, sizeof bytes);
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0}", THREE("5120", ""),
                               "{'buffer':0,'byteLength':12,'byteStride':4}", "12"));
    expect_positions(&f, (const float[]){0, 0, 0, 100, 0, 0, 0, -100, 7}, 9);
    import_finish(&f);
}

static void interleaved_attributes_are_taken_apart(void **state)
{
    (void)state;
    static const float mixed[15] = {0, 0, 0, .25f, .5f, 1, 0, 0, .75f, .5f, 0, 1, 0, 0, 1};
    import_fixture f;
    import_init(&f);
    import_serve(&f, "data.bin", mixed, sizeof mixed);
    import_loads(
        &f,
        PRIMITIVE("'attributes':{'POSITION':0,'TEXCOORD_1':1}",
                  "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                  "{'bufferView':0,'byteOffset':12,'componentType':5126,'count':3,'type':'VEC2'}",
                  "{'buffer':0,'byteLength':60,'byteStride':20}", "60"));
    expect_positions(&f, (const float[]){0, 0, 0, 1, 0, 0, 0, 1, 0}, 9);
    const air_mesh *mesh = only_mesh(&f);
    assert_null(mesh->uv[0]);
    assert_memory_equal(mesh->uv[1], ((const float[]){.25f, .5f, .75f, .5f, 0, 1}),
                        6 * sizeof(float));
    import_finish(&f);
}

static void sparse_elements_replace_those_of_the_view_or_zeros(void **state)
{
    (void)state;
    static const uint16_t which[2] = {1, 2};
    static const float values[6] = {5, 0, 0, 0, 6, 0};
    import_fixture f;
    data_file file;
    start(&f, &file);
    add_bytes(&file, which, sizeof which);
    add_bytes(&file, values, sizeof values);
    serve(&f, &file);
#define SPARSE                                                                                     \
    "'sparse':{'count':2,'indices':{'bufferView':1,'componentType':5123},'values':{'bufferView':"  \
    "2}}"
#define SPARSE_VIEWS                                                                               \
    POSITION_VIEW ",{'buffer':0,'byteOffset':48,'byteLength':4},{'buffer':0,'byteOffset':52,'"     \
                  "byteLength':24}"
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0},'mode':5", THREE("5126", "," SPARSE),
                               SPARSE_VIEWS, "76"));
    expect_positions(&f, (const float[]){0, 0, 0, 5, 0, 0, 0, 6, 0}, 9);
    import_loads(&f, PRIMITIVE("'attributes':{'POSITION':0}",
                               "{'componentType':5126,'count':3,'type':'VEC3'," SPARSE "}",
                               SPARSE_VIEWS, "76"));
    expect_positions(&f, (const float[]){0, 0, 0, 5, 0, 0, 0, 6, 0}, 9);
    file.bytes[50] = 3;
    import_refuses(
        &f, PRIMITIVE("'attributes':{'POSITION':0}", THREE("5126", "," SPARSE), SPARSE_VIEWS, "76"),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0]: sparse index 1 is 3, but there are 3 elements");
    import_finish(&f);
}

static void colours_of_bytes_without_alpha_become_opaque_floats(void **state)
{
    (void)state;
    static const uint8_t colours[12] = {255, 0, 51, 0, 0, 255, 0, 0, 0, 0, 255, 0};
    import_fixture f;
    data_file file;
    start(&f, &file);
    add_bytes(&file, colours, sizeof colours);
    serve(&f, &file);
    import_loads(
        &f, PRIMITIVE(
                "'attributes':{'POSITION':0,'COLOR_0':1},'mode':6",
                POSITION_ACCESSOR
                ",{'bufferView':1,'componentType':5121,'normalized':true,'count':4,'type':'VEC3'}",
                POSITION_VIEW ",{'buffer':0,'byteOffset':48,'byteLength':12}", "60"));
    const float *c = only_mesh(&f)->colors;
    assert_non_null(c);
    const float expected[8] = {1, 0, 0.2f, 1, 0, 0, 1, 1};
    for (size_t i = 0; i < 8; ++i)
        assert_true(fabsf(c[i] - expected[i]) < 1e-7f); /* 51/255 rounds once */
    import_finish(&f);
}

static void normals_of_length_zero_are_replaced_by_the_triangles(void **state)
{
    (void)state;
    static const float normals[12] = {0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0};
    import_fixture f;
    data_file file;
    start(&f, &file);
    add_bytes(&file, normals, sizeof normals);
    serve(&f, &file);
    import_loads(&f,
                 PRIMITIVE("'attributes':{'POSITION':0,'NORMAL':1},'mode':6",
                           POSITION_ACCESSOR
                           ",{'bufferView':1,'componentType':5126,'count':4,'type':'VEC3'}",
                           POSITION_VIEW ",{'buffer':0,'byteOffset':48,'byteLength':48}", "96"));
    for (size_t i = 0; i < 4; ++i) {
        const float *n = only_mesh(&f)->normals + 3 * i;
        assert_true(n[0] == 0.0f && n[1] == 0.0f && n[2] == 1.0f);
    }
    import_expect(&f, AIR_MESSAGE_INFO, "vertex normals of length 0 replaced: 2");
    import_finish(&f);
}

/* ---- refusals ---- */

static void bad_numbers_name_accessor_and_element(void **state)
{
    (void)state;
    static const uint8_t indices[3] = {0, 1, 4};
    import_fixture f;
    data_file file;
    start(&f, &file);
    add_bytes(&file, indices, sizeof indices);
    serve(&f, &file);
    import_refuses(
        &f,
        PRIMITIVE("'attributes':{'POSITION':0},'indices':1",
                  POSITION_ACCESSOR
                  ",{'bufferView':1,'componentType':5121,'count':3,'type':'SCALAR'}",
                  POSITION_VIEW ",{'buffer':0,'byteOffset':48,'byteLength':3}", "51"),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[1]: element 2: vertex 4 is out of range, there are 4 vertices");
    const float nan = NAN;
    memcpy(file.bytes + 28, &nan, sizeof nan);
    import_refuses(
        &f, PRIMITIVE("'attributes':{'POSITION':0}", POSITION_ACCESSOR, POSITION_VIEW, "48"),
        AIR_ERROR_FORMAT, "room.gltf: $.accessors[0]: element 2: component 1 is not finite");
    const float far = 1e19f;
    memcpy(file.bytes + 28, &far, sizeof far);
    import_refuses(&f,
                   PRIMITIVE("'attributes':{'POSITION':0}", POSITION_ACCESSOR, POSITION_VIEW, "48"),
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.meshes[0].primitives[0]: vertex 2 lies at (1, 1e+19, 0), farther "
                   "out than 1e+18 m");
    import_finish(&f);
}

static void accessors_that_leave_their_view_are_refused(void **state)
{
    (void)state;
    import_fixture f;
    data_file file;
    start(&f, &file);
    serve(&f, &file);
#define ONE(accessor, view) PRIMITIVE("'attributes':{'POSITION':0}", accessor, view, "48")
    import_refuses(
        &f, ONE("{'bufferView':0,'componentType':5126,'count':5,'type':'VEC3'}", POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0]: 5 elements of 12 bytes from byte 0 do not fit buffer view 0 "
        "(48 bytes)");
    import_refuses(
        &f,
        ONE("{'bufferView':0,'byteOffset':4,'componentType':5126,'count':4,'type':'VEC3'}",
            POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0]: 4 elements of 12 bytes from byte 4 do not fit buffer view 0 "
        "(48 bytes)");
    /* a count whose product with the stride passes 2^64 */
    import_refuses(
        &f,
        ONE("{'bufferView':0,'componentType':5126,'count':9007199254740992,'type':'VEC3'}",
            POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0]: 9007199254740992 elements of 12 bytes from byte 0 do not fit "
        "buffer view 0 (48 "
        "bytes)");
    import_refuses(
        &f, ONE("{'componentType':5126,'count':9007199254740992,'type':'VEC3'}", POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0].count: expected at most 4194304 elements without a buffer view, "
        "found "
        "9007199254740992");
    import_refuses(
        &f, ONE(POSITION_ACCESSOR, "{'buffer':0,'byteOffset':8,'byteLength':48}"), AIR_ERROR_FORMAT,
        "room.gltf: $.bufferViews[0]: bytes 8 to 56 are past the end of buffer 0 (48 bytes)");
    import_refuses(
        &f, ONE(POSITION_ACCESSOR, "{'buffer':0,'byteLength':48,'byteStride':8}"), AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0]: elements of 12 bytes do not fit the byteStride 8 of view 0");
    import_finish(&f);
}

static void accessors_of_the_wrong_kind_are_refused(void **state)
{
    (void)state;
    import_fixture f;
    data_file file;
    start(&f, &file);
    serve(&f, &file);
    import_refuses(
        &f, ONE("{'bufferView':0,'componentType':5126,'count':4,'type':'VEC2'}", POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0].type: expected \"VEC3\" for POSITION, found \"VEC2\"");
    import_refuses(
        &f, ONE("{'bufferView':0,'componentType':5126,'count':4,'type':'MAT4'}", POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0].type: expected one of SCALAR, VEC2, VEC3, VEC4, found \"MAT4\"");
    import_refuses(
        &f, ONE("{'bufferView':0,'componentType':5124,'count':4,'type':'VEC3'}", POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0].componentType: expected one of 5120, 5121, 5122, 5123, 5125, "
        "5126, found 5124");
    import_refuses(
        &f, ONE("{'bufferView':3,'componentType':5126,'count':4,'type':'VEC3'}", POSITION_VIEW),
        AIR_ERROR_FORMAT,
        "room.gltf: $.accessors[0].bufferView: expected the index of a buffer view, of which there "
        "are 1, found 3");
    import_refuses(&f,
                   PRIMITIVE("'attributes':{'POSITION':0},'indices':0", POSITION_ACCESSOR,
                             POSITION_VIEW, "48"),
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.accessors[0]: expected \"SCALAR\" of component type 5121, 5123 or "
                   "5125 for indices");
    import_refuses(&f,
                   PRIMITIVE("'attributes':{'NORMAL':0}", POSITION_ACCESSOR, POSITION_VIEW, "48"),
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.meshes[0].primitives[0].attributes.POSITION: expected the index "
                   "of an accessor, found nothing");
    import_refuses(&f,
                   PRIMITIVE("'attributes':{'POSITION':0,'NORMAL':1}",
                             POSITION_ACCESSOR
                             ",{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}",
                             POSITION_VIEW, "48"),
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.meshes[0].primitives[0].attributes.NORMAL: expected an accessor "
                   "of 4 elements like POSITION, "
                   "found 3");
    import_finish(&f);
}

static void a_mesh_shown_twice_is_two_meshes_of_one_material(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, "{" GLTF_ASSET ",'nodes':[{'mesh':0},{'mesh':0,'translation':[0,0,5]}],'"
                     "materials':[{'name':'red'}]," GLTF_PAINTED_TRIANGLE "}");
    assert_int_equal(f.snapshot->mesh_count, 2);
    assert_int_equal(f.snapshot->material_count, 2); /* and the default one */
    assert_int_equal(f.snapshot->meshes[0]->material, f.snapshot->meshes[1]->material);
    assert_true(f.snapshot->meshes[1]->positions[2] == 5.0f);
    import_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(indices_of_every_type_mean_the_same),
        cmocka_unit_test(strips_and_fans_become_triangles_of_one_orientation),
        cmocka_unit_test(a_list_that_does_not_divide_by_three_is_cut_with_a_warning),
        cmocka_unit_test(points_and_lines_are_left_out_with_a_warning),
        cmocka_unit_test(triangles_without_area_are_left_out_and_counted),
        cmocka_unit_test(quantised_positions_are_scaled_as_they_say),
        cmocka_unit_test(interleaved_attributes_are_taken_apart),
        cmocka_unit_test(sparse_elements_replace_those_of_the_view_or_zeros),
        cmocka_unit_test(colours_of_bytes_without_alpha_become_opaque_floats),
        cmocka_unit_test(normals_of_length_zero_are_replaced_by_the_triangles),
        cmocka_unit_test(bad_numbers_name_accessor_and_element),
        cmocka_unit_test(accessors_that_leave_their_view_are_refused),
        cmocka_unit_test(accessors_of_the_wrong_kind_are_refused),
        cmocka_unit_test(a_mesh_shown_twice_is_two_meshes_of_one_material),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

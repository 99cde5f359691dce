#include <stdio.h>

#include "image/srgb.h"
#include "mesh_fixture.h"

typedef struct ply_text {
    uint8_t bytes[2048];
    size_t size;
} ply_text;

static void put_text(ply_text *file, const char *text)
{
    const size_t length = strlen(text);
    assert_true(file->size + length <= sizeof file->bytes);
    memcpy(file->bytes + file->size, text, length);
    file->size += length;
}

static void put_value(ply_text *file, const void *value, size_t size, bool big)
{
    assert_true(file->size + size <= sizeof file->bytes);
    for (size_t i = 0; i < size; ++i)
        file->bytes[file->size + i] = ((const uint8_t *)value)[big ? size - 1 - i : i];
    file->size += size;
}

static void put_f32(ply_text *file, float value, bool big) { put_value(file, &value, 4, big); }
static void put_f64(ply_text *file, double value, bool big) { put_value(file, &value, 8, big); }
static void put_i16(ply_text *file, int16_t value, bool big) { put_value(file, &value, 2, big); }
static void put_u32(ply_text *file, uint32_t value, bool big) { put_value(file, &value, 4, big); }
static void put_u8(ply_text *file, uint8_t value) { put_value(file, &value, 1, false); }

static air_mesh_file read_ply(memory_file *host, const void *data, size_t size)
{
    air_mesh_file mesh;
    memory_file_init(host);
    if (mesh_read(host, AIR_MESH_PLY, data, size, &mesh) != AIR_OK)
        fail_msg("%s", air_context_last_error(host->context));
    return mesh;
}

static void close_ply(memory_file *host, air_mesh_file *mesh)
{
    air_mesh_file_finish(host->context, mesh);
    memory_file_finish(host);
}

static void refuse(const char *text, const char *part)
{
    mesh_expect_refusal(AIR_MESH_PLY, text, strlen(text), part);
}

#define HEAD     "ply\nformat ascii 1.0\n"
#define VERTICES "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACES    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"

static void text_is_read(void **state)
{
    (void)state;
    static const char text[] =
        "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info none\r\n"
        "element vertex 4\nproperty double x\nproperty float32 y\nproperty float z\n"
        "property list uint8 short weights\nproperty float nx\nproperty float ny\n"
        "property float nz\nproperty float s\nproperty float t\nproperty uchar red\n"
        "property uchar green\nproperty uchar blue\nproperty uchar alpha\n"
        "element edge 2\nproperty int a\nproperty int b\n"
        "element face 2\nproperty uchar flags\nproperty list uchar uint vertex_index\n"
        "end_header\n"
        "0 0 0 0 0 0 1 0 0 255 0 128 255\n1 0 0 2 7 8 0 0 1 1 0 255 255 255 51\n"
        "1 1 0 0 0 0 1 1 .5 0 0 0 0\n0 1 0 0 0 0 1 0 1e0 0 0 0 0\n"
        "0 1 1 2\n0 4 0 1 2 3\n9 3 2 1 0";
    memory_file host;
    air_mesh_file mesh = read_ply(&host, text, sizeof text - 1);
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 2, 1, 0};
    static const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const float uv[] = {0, 0, 1, 0, 1, .5f, 0, 1};
    assert_int_equal(mesh.vertex_count, 4);
    assert_memory_equal(mesh.positions, positions, sizeof positions);
    assert_memory_equal(mesh.uv, uv, sizeof uv);
    assert_true(mesh.normals[3] == 0.0f && mesh.normals[5] == 1.0f);
    assert_int_equal(mesh.triangle_count, 3);
    assert_memory_equal(mesh.indices, indices, sizeof indices);
    /* bytes of colour are sRGB, of alpha linear */
    assert_true(mesh.colors[0] == 1.0f && mesh.colors[1] == 0.0f && mesh.colors[3] == 1.0f);
    assert_true(mesh.colors[2] == srgb_decode((float)(128.0 / 255.0)));
    assert_true(mesh.colors[7] == 0.2f);
    close_ply(&host, &mesh);
}

/* The same mesh in both orders of bytes, with properties of every size. */
static void binary_is_read_in_both_orders(void **state)
{
    (void)state;
    for (int big = 0; big < 2; ++big) {
        ply_text file = {.size = 0};
        put_text(&file, "ply\nformat binary_");
        put_text(&file, big ? "big" : "little");
        put_text(&file, "_endian 1.0\nelement vertex 3\nproperty double x\nproperty short y\n"
                        "property float z\nproperty float r\nproperty float g\n"
                        "property float b\nelement face 1\n"
                        "property list uint uint vertex_indices\nproperty char pad\nend_header\n");
        for (int i = 0; i < 3; ++i) {
            put_f64(&file, i == 1 ? 0.5 : -0.25, big);
            put_i16(&file, i == 2 ? -300 : 2, big);
            put_f32(&file, 3.5f, big);
            for (int k = 0; k < 3; ++k)
                put_f32(&file, 0.5f * (float)k, big);
        }
        put_u32(&file, 3, big);
        for (uint32_t i = 0; i < 3; ++i)
            put_u32(&file, 2 - i, big);
        put_u8(&file, 0);
        memory_file host;
        air_mesh_file mesh = read_ply(&host, file.bytes, file.size);
        static const float positions[] = {-0.25f, 2, 3.5f, 0.5f, 2, 3.5f, -0.25f, -300, 3.5f};
        static const float color[] = {0, 0.5f, 1, 1};
        static const uint32_t indices[] = {2, 1, 0};
        assert_memory_equal(mesh.positions, positions, sizeof positions);
        assert_memory_equal(mesh.colors, color, sizeof color); /* floats are linear */
        assert_memory_equal(mesh.indices, indices, sizeof indices);
        assert_null(mesh.normals);
        assert_null(mesh.uv);
        close_ply(&host, &mesh);
        /* what is cut off is missed, wherever the cut */
        for (size_t size = 0; size < file.size; ++size)
            mesh_expect_refusal(AIR_MESH_PLY, file.bytes, size, "expected");
    }
}

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    refuse("", "line 1: expected a PLY header");
    refuse("obj\nend_header\n", "line 1: expected \"ply\" and a format first");
    refuse("ply\nelement vertex 3\nend_header\n", "line 2: expected \"ply\" and a format first");
    refuse("ply\nformat ascii 2.0\n", "line 2: expected ascii, binary");
    refuse(HEAD "element vertex -3\n", "line 3: expected an element's name and its count");
    refuse(HEAD "element vertex 5000000000\n", "line 3: expected an element's name");
    refuse(HEAD "property float x\n", "line 3: expected an element before");
    refuse(HEAD "element vertex 1\nproperty half x\n", "line 4: expected a property's type");
    refuse(HEAD "element face 1\nproperty list float int i\n", "line 4: expected a property's");
    refuse(HEAD "nonsense\n", "line 3: expected format, comment, element");
    refuse(HEAD VERTICES FACES "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", "line 12: expected a finite");
    refuse(HEAD VERTICES FACES "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
           "line 13: expected the index of a vertex");
    refuse(HEAD VERTICES FACES "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "line 13: expected the index");
    refuse(HEAD VERTICES FACES "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n", "line 13: expected the index");
    refuse(HEAD VERTICES FACES "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "a face of 3 corners or more");
    refuse(HEAD VERTICES FACES "0 0 0\n1 0 0\n0 1 0\n200 0 1\n", "the length of a list");
    refuse(HEAD "element vertex 4000000000\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n0 0 0\n",
           "expected 4000000000 rows of the element vertex");
    refuse(HEAD "element vertex 1\nproperty float x\nend_header\n0\n", "properties x, y and z");
    refuse(HEAD FACES "3 0 1 2\n", "faces behind vertices");
    refuse(HEAD VERTICES "end_header\n0 0 0\n1 0 0\n0 1 0\n", "at least one triangle");
    refuse(HEAD VERTICES "element nothing 4000000000\nend_header\n0 0 0 1 0 0 0 1 0\n",
           "at least one triangle");
}

static void failing_allocations_are_survived(void **state)
{
    (void)state;
    static const char text[] = HEAD VERTICES FACES "0 0 0\n1 0 0\n0 1 0\n5 0 1 2 0 1\n";
    mesh_expect_survival(AIR_MESH_PLY, text, sizeof text - 1);
}

static void a_scene_of_others_is_read(void **state)
{
    (void)state;
    air_context *context = NULL;
    air_mesh_file mesh;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    const char *path = AIR_SHARED_DIR "/scenes/pbrt4_houdini_tests/resources/grid.ply";
    const air_status status = air_mesh_file_read(context, path, AIR_MESH_PLY, 0, &mesh);
    if (status == AIR_OK)
        air_mesh_file_finish(context, &mesh);
    air_context_destroy(context);
    if (status == AIR_ERROR_IO) {
        print_message("%s is absent\n", path);
        skip();
    }
    assert_int_equal(status, AIR_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(text_is_read),
        cmocka_unit_test(binary_is_read_in_both_orders),
        cmocka_unit_test(what_is_wrong_is_named),
        cmocka_unit_test(failing_allocations_are_survived),
        cmocka_unit_test(a_scene_of_others_is_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

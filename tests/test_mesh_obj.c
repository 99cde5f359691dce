#include <dirent.h>
#include <stdio.h>

#include "mesh_fixture.h"
#include "scene/import/number.h"

typedef struct obj_fixture {
    memory_file host;
    air_mesh_file mesh;
} obj_fixture;

static void open_obj(obj_fixture *f, const char *text)
{
    memory_file_init(&f->host);
    const air_status status = mesh_read(&f->host, AIR_MESH_OBJ, text, strlen(text), &f->mesh);
    if (status != AIR_OK)
        fail_msg("%s", air_context_last_error(f->host.context));
}

static void close_obj(obj_fixture *f)
{
    air_mesh_file_finish(f->host.context, &f->mesh);
    memory_file_finish(&f->host);
}

static void refuse(const char *text, const char *part)
{
    mesh_expect_refusal(AIR_MESH_OBJ, text, strlen(text), part);
}

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void vertices_are_shared_by_equal_triples(void **state)
{
    (void)state;
    obj_fixture f;
    open_obj(&f, SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvt 0.25 0.75\nvn 0 0 1\n"
                        "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\nf 1/2/1 2/2/1 3/3/1\n");
    /* corner 1/2 is another vertex than 1/1 */
    static const uint32_t expected[] = {0, 1, 2, 0, 2, 3, 4, 1, 2};
    assert_int_equal(f.mesh.vertex_count, 5);
    assert_int_equal(f.mesh.triangle_count, 3);
    assert_memory_equal(f.mesh.indices, expected, sizeof expected);
    assert_true(f.mesh.uv[2 * 3] == 0.25f && f.mesh.uv[2 * 3 + 1] == 0.75f);
    assert_true(f.mesh.uv[2 * 4] == 1.0f && f.mesh.positions[3 * 4] == 0.0f);
    assert_true(f.mesh.normals[3 * 4 + 2] == 1.0f);
    assert_null(f.mesh.colors);
    close_obj(&f);
}

static void lines_may_be_written_in_many_ways(void **state)
{
    (void)state;
    static const char *const same[] = {
        SQUARE "f 1 2 3 4\n",
        SQUARE "f -4 -3 -2 -1",
        "f 1 2 3 4\n" SQUARE,
        "# C:\\\r\n\r\nmtllib none.mtl\r\nv 0 0 0 1.0\r\nv 1. 0 0\r\n  v\t1 1e0 -0\r\nv 0 +1 0 \r\n"
        "usemtl x\r\ns off\r\nf 1 2 3 4 # square\r\n",
        "v 0 0 \\\n0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2\\\n 3 \\\r\n4\n",
        SQUARE "o a\ng b c\nl 1 2\nvp 1 2\nf 1/ 2/ 3// 4//\n",
    };
    for (size_t i = 0; i < sizeof same / sizeof *same; ++i) {
        static const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
        static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
        obj_fixture f;
        open_obj(&f, same[i]);
        assert_int_equal(f.mesh.vertex_count, 4);
        for (int k = 0; k < 12; ++k)
            assert_true(f.mesh.positions[k] == positions[k]);
        assert_int_equal(f.mesh.triangle_count, 2);
        assert_memory_equal(f.mesh.indices, indices, sizeof indices);
        assert_null(f.mesh.normals);
        assert_null(f.mesh.uv);
        close_obj(&f);
    }
}

static void faces_without_normals_take_their_own_among_others(void **state)
{
    (void)state;
    obj_fixture f;
    open_obj(&f, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0.6 0.8\n"
                 "f 1//1 2//1 3//1\nf 1 3 4\nf 1 4 2//1\n");
    assert_int_equal(f.mesh.vertex_count, 3 + 3 + 2);
    static const float expected[][3] = {{0, 0.6f, 0.8f}, {1, 0, 0}, {0, 1, 0}};
    const uint32_t first[] = {f.mesh.indices[0], f.mesh.indices[3], f.mesh.indices[6]};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            assert_true(f.mesh.normals[3 * first[i] + (uint32_t)k] == expected[i][k]);
    }
    assert_int_equal(f.mesh.indices[8], f.mesh.indices[1]);
    close_obj(&f);
}

static void colors_follow_positions_and_default_to_white(void **state)
{
    (void)state;
    obj_fixture f;
    open_obj(&f, "v 0 0 0\nv 1 0 0 0.25 0.5 0.75\nv 0 1 0\nf 1 2 3\n");
    static const float expected[] = {1, 1, 1, 1, 0.25f, 0.5f, 0.75f, 1, 1, 1, 1, 1};
    assert_memory_equal(f.mesh.colors, expected, sizeof expected);
    close_obj(&f);
}

/* An L and a square with a notch, in space: the triangles of a polygon have its vector area, and
 * all turn the same way. A fan from the first corner would turn both ways in these. */
static void concave_polygons_keep_their_area(void **state)
{
    (void)state;
    static const double doubled[] = {6.0, 5.0, 2.0};
    static const char *const shapes[] = {
        "v 1 0 1\nv 1 2 2\nv 1 2 3\nv 1 1 2.5\nv 1 1 3.5\nv 1 0 3\nf 1 2 3 4 5 6\n",
        "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 5 1 2 3 4\n",
        "v 0 0 0\nv 1 3 0\nv 0 1 0\nv -1 3 0\nf 1 2 3 4\n",
    };
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
        obj_fixture f;
        open_obj(&f, shapes[i]);
        double whole[3], sum = 0.0;
        mesh_vector_area(&f.mesh, whole);
        for (size_t t = 0; t < f.mesh.triangle_count; ++t) {
            air_mesh_file one = f.mesh;
            double area[3];
            one.indices += 3 * t;
            one.triangle_count = 1;
            mesh_vector_area(&one, area);
            sum += air_length3(area);
        }
        /* coordinates are exact in floats, so are their products in doubles */
        assert_true(fabs(sum - air_length3(whole)) < 1e-12);
        assert_true(fabs(sum - doubled[i]) < 1e-12);
        close_obj(&f);
    }
}

static void what_is_wrong_is_named_with_its_line(void **state)
{
    (void)state;
    refuse("", "at least one face");
    refuse(SQUARE, "at least one face");
    refuse("v 0 0\nf 1 1 1\n", "line 1: expected 3 or more finite numbers");
    refuse("\nv 0 nan 0\nf 1 1 1\n", "line 2: expected 3 or more finite numbers");
    refuse("v 0 1e39 0\nf 1 1 1\n", "line 1: expected 3 or more finite numbers");
    refuse("v 0 0 0,5\nf 1 1 1\n", "line 1: expected 3 or more finite numbers");
    refuse(SQUARE "f 1 2\n", "line 5: a face of 2 corners");
    refuse(SQUARE "f\n", "at least one face");
    refuse(SQUARE "f \n", "line 5: a face of 0 corners");
    refuse(SQUARE "\\\n\nf 1 2 5\n", "line 7: corner 3: expected v, v/vt");
    refuse(SQUARE "f 0 1 2\n", "line 5: corner 1: expected");
    refuse(SQUARE "f 1 2 -5\n", "line 5: corner 3: expected");
    refuse(SQUARE "f 1/1 2 3\n", "indices of the 4 v, 0 vt and 0 vn");
    refuse(SQUARE "f 1 2 99999999999999999999999\n", "line 5: corner 3: expected");
    refuse(SQUARE "f 1 2 3x\n", "line 5: corner 3: expected");
    refuse(SQUARE "f 1\\2 3 4\n", "line 5: corner 1: expected");
    refuse(SQUARE "f 1 2 3/1/1/1\n", "line 5: corner 3: expected");
}

static void failing_allocations_are_survived(void **state)
{
    (void)state;
    static const char text[] = "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2 3\n";
    mesh_expect_survival(AIR_MESH_OBJ, text, sizeof text - 1);
}

/* Two triangles that meet at a right angle, of 90 and 45 degrees at their common corner. */
static void smooth_normals_are_weighted_by_angle(void **state)
{
    (void)state;
    obj_fixture f;
    open_obj(&f, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 1\nf 1 2 3\nf 1 4 2\n");
    assert_null(f.mesh.normals);
    assert_int_equal(air_mesh_file_smooth(f.host.context, &f.mesh), AIR_OK);
    /* normals (0,0,1) times pi/2 and (0,1,0) times pi/4; (1,0,1) x (1,0,0) is (0,1,0) */
    const double length = sqrt(1.0 + 0.25);
    assert_true(fabs((double)f.mesh.normals[0]) < 1e-6); /* a few roundings */
    assert_true(fabs((double)f.mesh.normals[1] - 0.5 / length) < 1e-6);
    assert_true(fabs((double)f.mesh.normals[2] - 1.0 / length) < 1e-6);
    close_obj(&f);
}

/* Against strtod, which rounds correctly: one rounding of the result up to 15 digits and powers of
 * 22, and at most one for each of 14 factors of 1e22 beyond. */
static void numbers_are_as_the_c_library_reads_them(void **state)
{
    (void)state;
    static const char *const exact[] = {
        "0",       "-0.0",  "1",       "123456789012345", "0.1",
        "-3.25e2", "1e22",  "1.5E-22", "0000001",         ".5",
        "5.",      "+7e+0", "1e-400",  "1e400",           "0e99999999999999999999"};
    static const char *const near[] = {"1e-300", "1.7976931348623157e308", "2.5e-45",
                                       "123456789012345678901234567890",
                                       "0.00000000000000000000000000000001234567890123456789012"};
    for (size_t i = 0; i < sizeof exact / sizeof *exact; ++i) {
        double value = 7.0;
        const char *end = exact[i] + strlen(exact[i]);
        assert_ptr_equal(air_number_scan(exact[i], end, &value), end);
        assert_true(value == strtod(exact[i], NULL));
    }
    for (size_t i = 0; i < sizeof near / sizeof *near; ++i) {
        double value = 7.0;
        const char *end = near[i] + strlen(near[i]);
        const double expected = strtod(near[i], NULL);
        assert_ptr_equal(air_number_scan(near[i], end, &value), end);
        assert_true(fabs(value / expected - 1.0) <= 15.0 * 0x1p-53);
    }
    double value = 7.0;
    const char *text = "1e";
    assert_ptr_equal(air_number_scan(text, text + 2, &value), text + 1);
    assert_null(air_number_scan(text + 1, text + 2, &value));
    assert_null(air_number_scan(text, text, &value));
}

/* Every OBJ of a folder of ../shared/scenes. Returns its triangles, 0 if it is absent. */
static size_t read_folder(const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/scenes/%s", AIR_SHARED_DIR, name);
    DIR *folder = opendir(path);
    if (folder == NULL)
        return 0;
    air_context *context = NULL;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    size_t triangles = 0;
    for (struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        if (strstr(entry->d_name, ".obj") == NULL)
            continue;
        air_mesh_file mesh;
        snprintf(path, sizeof path, "%s/scenes/%s/%s", AIR_SHARED_DIR, name, entry->d_name);
        if (air_mesh_file_read(context, path, AIR_MESH_OBJ, 0, &mesh) != AIR_OK)
            fail_msg("%s", air_context_last_error(context));
        triangles += mesh.triangle_count;
        air_mesh_file_finish(context, &mesh);
    }
    air_context_destroy(context);
    closedir(folder);
    return triangles;
}

static void scenes_of_others_are_read(void **state)
{
    (void)state;
    /* numbers of triangles as their authors state them, or counted by hand */
    static const struct {
        const char *folder;
        size_t triangles;
    } folders[] = {
        {"bitterli_classroom/models", 103832}, {"obj_cornell", 0},     {"lajolla_cbox/meshes", 0},
        {"lajolla_volpath/meshes", 0},         {"lajolla_volpath", 0}, {"mitsuba_cbox/meshes", 0}};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; ++i) {
        const size_t triangles = read_folder(folders[i].folder);
        if (triangles == 0) {
            print_message("%s is absent\n", folders[i].folder);
            skip();
        }
        if (folders[i].triangles > 0)
            assert_int_equal(triangles, folders[i].triangles);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_are_shared_by_equal_triples),
        cmocka_unit_test(lines_may_be_written_in_many_ways),
        cmocka_unit_test(faces_without_normals_take_their_own_among_others),
        cmocka_unit_test(colors_follow_positions_and_default_to_white),
        cmocka_unit_test(concave_polygons_keep_their_area),
        cmocka_unit_test(what_is_wrong_is_named_with_its_line),
        cmocka_unit_test(failing_allocations_are_survived),
        cmocka_unit_test(smooth_normals_are_weighted_by_angle),
        cmocka_unit_test(numbers_are_as_the_c_library_reads_them),
        cmocka_unit_test(scenes_of_others_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

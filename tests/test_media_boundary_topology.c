/* Meshes as boundaries: closed or refused, oriented outwards whatever came in, convex ones
 * recognised. */
#include <stdlib.h>

#include "boundary_meshes.h"
#include "core/random.h"
#include "memory_files.h"
#include "scene/media/boundary_topology.h"
#include "scene/media/convex.h"

static int set_up(void **state)
{
    memory_file *files = calloc(1, sizeof *files);
    memory_file_init(files);
    *state = files;
    return 0;
}

static int tear_down(void **state)
{
    memory_file_finish(*state);
    free(*state);
    return 0;
}

static air_status analyse(memory_file *files, const test_mesh *mesh, air_topology *out)
{
    const air_subject subject = {files->context, "medium", "fog"};
    return air_topology_make(&subject, mesh->positions, mesh->vertex_count, mesh->indices,
                             mesh->triangle_count, out);
}

/* The planes found, 0 for a mesh that is not convex. */
static size_t find_planes(memory_file *files, const test_mesh *mesh,
                          air_plane planes[AIR_MAX_PLANES])
{
    air_topology topology;
    size_t count = 0;
    assert_int_equal(analyse(files, mesh, &topology), AIR_OK);
    assert_int_equal(air_topology_convex_planes(files->context, &topology, planes, &count), AIR_OK);
    air_topology_finish(files->context, &topology);
    return count;
}

/* A rotation with a shift, and scales along the axes. */
static void random_map(air_rng *rng, const float scale[3], float shift, float out[12])
{
    const air_vec3 n =
        vec3_normalize(vec3(air_rng_float(rng) - 0.5f, air_rng_float(rng) - 0.5f, 0.3f));
    const air_frame f = frame_from_normal(n);
    const float rows[12] = {f.s.x, f.t.x,  f.n.x, shift, f.s.y, f.t.y,
                            f.n.y, -shift, f.s.z, f.t.z, f.n.z, 0.5f * shift};
    for (int i = 0; i < 12; i++) {
        out[i] = i % 4 < 3 ? rows[i] * scale[i % 4] : rows[i];
    }
}

static void test_a_box_in_any_position_is_recognised(void **state)
{
    air_rng rng = air_rng_from_keys(1, 1);
    static const float scales[4][3] = {{1, 1, 1}, {2, 0.01f, 3}, {100, 100, 50}, {1, 1, -2}};
    for (int n = 0; n < 40; n++) {
        test_mesh mesh = {.vertex_count = 0};
        air_plane planes[AIR_MAX_PLANES];
        float map[12];
        mesh_add_cube(&mesh);
        random_map(&rng, scales[n % 4], n % 3 == 0 ? 0.0f : 20.0f, map);
        mesh_transform(&mesh, 0, map);
        assert_int_equal(find_planes(*state, &mesh, planes), 6);
        assert_true(air_convex_is_box(planes, 6));
        /* every corner is on three planes and behind the others, to a few 2^-24 of the largest
         * coordinate */
        for (size_t v = 0; v < mesh.vertex_count; v++) {
            int on = 0;
            for (int i = 0; i < 6; i++) {
                const float d =
                    vec3_dot(planes[i].n, vec3_load(mesh.positions + 3 * v)) - planes[i].h;
                assert_true(d < 1e-4f);
                on += fabsf(d) < 1e-4f;
            }
            assert_int_equal(on, 3);
        }
    }
}

static void test_convex_meshes_give_their_faces(void **state)
{
    test_mesh mesh = {.vertex_count = 0};
    air_plane planes[AIR_MAX_PLANES];
    mesh_add_icosphere(&mesh, 0);
    assert_int_equal(find_planes(*state, &mesh, planes), 20);
    assert_false(air_convex_is_box(planes, 20));
    for (int i = 0; i < 20; i++) {
        /* the inscribed radius of an icosahedron of circumradius 1 */
        assert_float_equal(planes[i].h, 0.7946545f, 1e-5f);
    }
}

static void test_meshes_that_are_not_convex_or_have_many_faces_stay_meshes(void **state)
{
    air_plane planes[AIR_MAX_PLANES];
    test_mesh torus = {.vertex_count = 0}, sphere = {.vertex_count = 0}, two = {.vertex_count = 0};
    static const float shifted[12] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0};
    mesh_add_torus(&torus, 2.0f, 0.5f, 24, 12);
    assert_int_equal(find_planes(*state, &torus, planes), 0);
    mesh_add_icosphere(&sphere, 1);
    assert_int_equal(find_planes(*state, &sphere, planes), 0);
    mesh_add_cube(&two);
    mesh_transform(&two, 0, shifted);
    mesh_add_cube(&two);
    assert_int_equal(find_planes(*state, &two, planes), 0);
}

static void test_volumes_are_exact(void **state)
{
    memory_file *files = *state;
    air_topology topology;
    test_mesh mesh = {.vertex_count = 0};
    mesh_add_cube(&mesh);
    assert_int_equal(analyse(files, &mesh, &topology), AIR_OK);
    assert_int_equal(topology.vertex_count, 8);
    assert_int_equal(topology.triangle_count, 12);
    assert_int_equal(topology.component_count, 1);
    assert_true(fabs(topology.volume - 8.0) < 1e-12);
    air_topology_finish(files->context, &topology);
}

/* The volume by the divergence theorem, from the orientation as it came out. */
static double oriented_volume(const air_topology *topology)
{
    double sum = 0.0;
    for (size_t t = 0; t < topology->triangle_count; t++) {
        const air_vec3 a = vec3_load(topology->positions + 3 * topology->indices[3 * t]);
        const air_vec3 b = vec3_load(topology->positions + 3 * topology->indices[3 * t + 1]);
        const air_vec3 c = vec3_load(topology->positions + 3 * topology->indices[3 * t + 2]);
        sum += (double)vec3_dot(a, vec3_cross(b, c)) / 6.0;
    }
    return sum;
}

static void expect_volume(memory_file *files, const test_mesh *mesh, size_t components,
                          double volume)
{
    air_topology topology;
    assert_int_equal(analyse(files, mesh, &topology), AIR_OK);
    assert_int_equal(topology.component_count, components);
    assert_true(fabs(topology.volume - volume) < 1e-5 * volume);
    assert_true(fabs(oriented_volume(&topology) - volume) < 1e-5 * volume);
    air_topology_finish(files->context, &topology);
}

static void test_inverted_and_mixed_orientation_is_turned_outwards(void **state)
{
    test_mesh mesh = {.vertex_count = 0};
    mesh_add_cube(&mesh);
    mesh_flip(&mesh, 0, 12);
    expect_volume(*state, &mesh, 1, 8.0);
    for (size_t t = 0; t < 12; t += 3) {
        mesh_flip(&mesh, t, t + 1);
    }
    expect_volume(*state, &mesh, 1, 8.0);
}

static void test_components_beside_each_other_add_and_nested_ones_are_cavities(void **state)
{
    static const float beside[12] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0};
    static const float inside[12] = {0.5f, 0, 0, 0.1f, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0};
    static const float core[12] = {0.25f, 0, 0, 0.1f, 0, 0.25f, 0, 0, 0, 0, 0.25f, 0};
    for (int flips = 0; flips < 8; flips++) {
        test_mesh two = {.vertex_count = 0}, nested = {.vertex_count = 0};
        mesh_add_cube(&two);
        mesh_transform(&two, 0, beside);
        mesh_add_cube(&two);
        mesh_add_cube(&nested);
        mesh_add_cube(&nested);
        mesh_transform(&nested, 24, inside);
        mesh_add_cube(&nested);
        mesh_transform(&nested, 48, core);
        for (size_t part = 0; part < 3; part++) {
            if (flips >> part & 1) {
                mesh_flip(&nested, 12 * part, 12 * part + 12);
                mesh_flip(&two, 12 * part, part < 2 ? 12 * part + 12 : 0);
            }
        }
        expect_volume(*state, &two, 2, 16.0);
        expect_volume(*state, &nested, 3, 8.0 - 1.0 + 0.125);
    }
}

static void test_degenerate_triangles_are_left_out(void **state)
{
    test_mesh mesh = {.vertex_count = 0};
    mesh_add_cube(&mesh);
    mesh_triangle(&mesh, 0, 0, 1);
    mesh_triangle(&mesh, 3, 2, 3);
    expect_volume(*state, &mesh, 1, 8.0);
}

static void expect_refused(memory_file *files, const test_mesh *mesh, const char *part)
{
    air_topology topology;
    assert_int_equal(analyse(files, mesh, &topology), AIR_ERROR_ARGUMENT);
    memory_file_expect(files, "medium \"fog\": ");
    memory_file_expect(files, part);
}

static void test_what_has_no_inside_is_refused_with_the_place(void **state)
{
    memory_file *files = *state;
    test_mesh mesh = {.vertex_count = 0};
    mesh_add_cube(&mesh);
    mesh.triangle_count = 11;
    expect_refused(files, &mesh,
                   "not closed: 3 open edges and 0 edges of more than two triangles, one from (");
    mesh.triangle_count = 12;
    mesh.indices[5] = 24;
    expect_refused(files, &mesh,
                   "triangle 1 of the boundary mesh has index 24, there are 24 vertices");
    mesh.triangle_count = 3;
    mesh.indices[5] = 2;
    expect_refused(files, &mesh, "3 triangles of three different corners");
    mesh.triangle_count = 0;
    expect_refused(files, &mesh, "0 triangles");
    mesh.triangle_count = 12;
    mesh.positions[7] = NAN;
    expect_refused(files, &mesh, "vertex 2 of the boundary mesh is not finite");
    test_mesh edge = {.vertex_count = 0};
    static const float beside[12] = {1, 0, 0, 2, 0, 1, 0, 2, 0, 0, 1, 0};
    mesh_add_cube(&edge);
    mesh_transform(&edge, 0, beside);
    mesh_add_cube(&edge);
    expect_refused(files, &edge,
                   "0 open edges and 1 edges of more than two triangles, one from (1, 1, -1)");
    test_mesh flat = {.vertex_count = 0};
    static const float flatten[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-9f, 0};
    mesh_add_cube(&flat);
    mesh_transform(&flat, 0, flatten);
    expect_refused(files, &flat, "encloses no volume");
}

/* A torus whose tube is closed the wrong way round is Klein's bottle: closed, without an inside. */
static void test_one_sided_surfaces_are_refused(void **state)
{
    enum { NU = 12, NV = 8 };
    test_mesh mesh = {.vertex_count = 0};
    for (uint32_t n = 0; n < NU * NV; n++) {
        const float u = 2.0f * AIR_PI_F * (float)(n / NV) / NU,
                    v = 2.0f * AIR_PI_F * (float)(n % NV) / NV;
        const float r = 3.0f + cosf(v);
        mesh_vertex(&mesh, r * cosf(u), r * sinf(u), sinf(v) * cosf(0.5f * u));
    }
    for (uint32_t i = 0; i < NU; i++) {
        for (uint32_t j = 0; j < NV; j++) {
            const bool seam = i + 1 == NU;
            const uint32_t next = (i + 1) % NU * NV, j1 = (j + 1) % NV;
            const uint32_t a = i * NV + j, d = i * NV + j1;
            const uint32_t b = next + (seam ? (NV - j) % NV : j),
                           c = next + (seam ? (NV - j1) % NV : j1);
            mesh_triangle(&mesh, a, b, c);
            mesh_triangle(&mesh, a, c, d);
        }
    }
    expect_refused(*state, &mesh, "one-sided");
}

static void test_allocation_failure_leaves_nothing_behind(void **state)
{
    memory_file *files = *state;
    test_mesh mesh = {.vertex_count = 0};
    mesh_add_torus(&mesh, 2.0f, 0.5f, 8, 6);
    const long live = atomic_load(&files->allocator.live);
    long allowed = 0;
    for (air_status status = AIR_ERROR_MEMORY; status != AIR_OK; allowed++) {
        air_topology topology;
        atomic_store(&files->allocator.remaining, allowed);
        status = analyse(files, &mesh, &topology);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        if (status == AIR_OK) {
            air_topology_finish(files->context, &topology);
        }
        assert_true(atomic_load(&files->allocator.live) <= live + 1); /* the message may be kept */
    }
    assert_true(allowed > 8);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_a_box_in_any_position_is_recognised),
        TEST(test_convex_meshes_give_their_faces),
        TEST(test_meshes_that_are_not_convex_or_have_many_faces_stay_meshes),
        TEST(test_volumes_are_exact),
        TEST(test_inverted_and_mixed_orientation_is_turned_outwards),
        TEST(test_components_beside_each_other_add_and_nested_ones_are_cavities),
        TEST(test_degenerate_triangles_are_left_out),
        TEST(test_what_has_no_inside_is_refused_with_the_place),
        TEST(test_one_sided_surfaces_are_refused),
        TEST(test_allocation_failure_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Media from descriptions: what is refused, and that regions hold exactly the points they should.
 */
#include <stdlib.h>

#include "boundary_meshes.h"
#include "core/random.h"
#include "memory_files.h"
#include "scene/media/convex.h"
#include "scene/media/media_build.h"

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

static air_medium_desc haze(void)
{
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.name = "haze";
    desc.sigma_s[0] = desc.sigma_s[1] = desc.sigma_s[2] = 0.25f;
    desc.sigma_a[0] = 0.05f;
    return desc;
}

static air_media build(memory_file *files, const air_medium_desc *descs, size_t count)
{
    air_medium_source sources[AIR_MAX_MEDIA];
    air_media media;
    for (size_t i = 0; i < count; i++) {
        sources[i] = (air_medium_source){.desc = &descs[i]};
        if (air_medium_check(files->context, &descs[i]) != AIR_OK) {
            fail_msg("%s", air_context_last_error(files->context));
        }
    }
    if (air_media_build(files->context, sources, count, &media) != AIR_OK) {
        fail_msg("%s", air_context_last_error(files->context));
    }
    return media;
}

static void expect_refused(memory_file *files, const air_medium_desc *desc, const char *part)
{
    assert_int_equal(air_medium_check(files->context, desc), AIR_ERROR_ARGUMENT);
    memory_file_expect(files, "medium \"haze\": ");
    memory_file_expect(files, part);
}

static void test_coefficients_out_of_range_are_refused(void **state)
{
    static const float bad[] = {-0.1f, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        air_medium_desc desc = haze();
        desc.sigma_s[1] = bad[i];
        expect_refused(*state, &desc, "sigma_s[1] is ");
        desc = haze();
        desc.sigma_a[2] = bad[i];
        expect_refused(*state, &desc, "sigma_a[2] is ");
        desc = haze();
        desc.emission[0] = bad[i];
        expect_refused(*state, &desc, "emission[0] is ");
    }
    static const float g[] = {1.0f, -1.0f, 2.0f, NAN};
    for (int i = 0; i < 4; i++) {
        air_medium_desc desc = haze();
        desc.phase = (air_phase){.kind = AIR_PHASE_HG, .g = g[i]};
        expect_refused(*state, &desc, "phase.g is ");
        desc.phase.kind = AIR_PHASE_ISOTROPIC; /* which does not look at g */
        assert_int_equal(air_medium_check(((memory_file *)*state)->context, &desc), AIR_OK);
    }
    air_medium_desc desc = haze();
    desc.phase.kind = (air_phase_kind)7;
    expect_refused(*state, &desc, "phase.kind is 7");
    desc = haze();
    desc.combine = (air_combine)2;
    expect_refused(*state, &desc, "combine is 2");
}

/* A description with a mixture in *mixture that is in order but for what the caller spoils. */
static air_medium_desc mixed_haze(air_phase_mixture *mixture)
{
    air_medium_desc desc = haze();
    *mixture =
        (air_phase_mixture){2, {{AIR_PHASE_HG, 0.8f, 3.0f}, {AIR_PHASE_ISOTROPIC, 0.0f, 1.0f}}};
    desc.phase = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = mixture};
    return desc;
}

static void test_mixtures_out_of_range_are_refused(void **state)
{
    air_phase_mixture mixture;
    air_medium_desc desc = mixed_haze(&mixture);
    mixture.lobe_count = 0;
    expect_refused(*state, &desc, "phase mixture: lobe_count is 0, but must be in 1..8");
    mixture.lobe_count = 9;
    expect_refused(*state, &desc, "phase mixture: lobe_count is 9");
    desc = mixed_haze(&mixture);
    mixture.lobes[1].kind = AIR_PHASE_MIXTURE;
    expect_refused(*state, &desc, "phase mixture: lobes[1].kind must be in 0..2");
    desc = mixed_haze(&mixture);
    mixture.lobes[0].g = -1.0f;
    expect_refused(*state, &desc, "phase mixture: lobes[0].g must be between -1 and 1");
    static const float bad[] = {-0.1f, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        desc = mixed_haze(&mixture);
        mixture.lobes[1].weight = bad[i];
        expect_refused(*state, &desc, "phase mixture: lobes[1].weight must be finite");
    }
    mixture.lobes[0].weight = mixture.lobes[1].weight = 0.0f;
    expect_refused(*state, &desc, "phase mixture: the weights of the lobes sum to 0");
    desc.phase.mixture = NULL;
    expect_refused(*state, &desc, "phase mixture: mixture must not be NULL");
}

static void test_media_own_their_mixtures(void **state)
{
    memory_file *files = *state;
    air_phase_mixture mixture;
    const air_medium_desc desc = mixed_haze(&mixture);
    air_media media = build(files, &desc, 1);
    mixture.lobe_count = 0;
    const air_medium *medium = &media.media[0];
    assert_ptr_equal(medium->phase.mixture, &medium->mixture);
    assert_int_equal(medium->mixture.lobe_count, 2);
    assert_true(medium->mixture.lobes[0].weight == 0.75f);
    air_media_finish(files->context, &media);
}

static void test_densities_out_of_range_are_refused(void **state)
{
    air_medium_desc desc = haze();
    desc.density.kind = AIR_DENSITY_LAYERED;
    expect_refused(*state, &desc, "density has 0 layers, but must have 1 to 32");
    desc.density.layer_count = 33;
    expect_refused(*state, &desc, "density has 33 layers");
    desc.density.layer_count = 2;
    desc.density.layer_bottom[1] = -1.0f;
    expect_refused(*state, &desc, "layer 0 of density reaches from 0 to -1");
    desc.density.layer_bottom[1] = 1.0f;
    desc.density.layer_top = 1.0f;
    expect_refused(*state, &desc, "layer 1 of density reaches from 1 to 1");
    desc.density.layer_top = NAN;
    expect_refused(*state, &desc, "layer 1 of density reaches from 1 to ");
    desc.density.layer_top = 2.0f;
    desc.density.layer_density[1] = -0.5f;
    expect_refused(*state, &desc, "density.layer_density[1] is -0.5");
    desc.density.layer_density[1] = 0.5f;
    desc.density.up[0] = 1.0f;
    expect_refused(*state, &desc, "density.up is (1, 1, 0), but must have length 1");
    desc = haze();
    desc.density.kind = AIR_DENSITY_EXPONENTIAL;
    static const float heights[] = {0.0f, -1.0f, NAN, INFINITY, 1e-45f};
    for (int i = 0; i < 5; i++) {
        desc.density.scale_height = heights[i];
        expect_refused(*state, &desc, "density.scale_height is ");
    }
    desc.density.scale_height = 1.0f;
    desc.density.base_height = INFINITY;
    expect_refused(*state, &desc, "density.base_height is inf");
    desc = haze();
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid_to_world[0] = 0.0f;
    expect_refused(*state, &desc, "density.grid_to_world is singular");
}

static void test_boundaries_without_an_inside_are_refused(void **state)
{
    air_medium_desc desc = haze();
    desc.boundary.kind = AIR_BOUNDARY_BOX;
    desc.boundary.box_to_world[5] = 0.0f;
    expect_refused(*state, &desc, "the box of boundary has no volume");
    desc.boundary.box_to_world[5] = NAN;
    expect_refused(*state, &desc, "the box of boundary has no volume");
    float planes[] = {1, 0, 0, 1, -1, 0, 0, -2, 0, 0, 0, 1};
    desc = haze();
    desc.boundary.kind = AIR_BOUNDARY_CONVEX;
    desc.boundary.planes = planes;
    expect_refused(*state, &desc, "boundary has 0 planes, but must have 1 to 32");
    desc.boundary.plane_count = 2;
    expect_refused(*state, &desc, "the planes of boundary enclose nothing"); /* x <= 1, x >= 2 */
    planes[7] = -1.0f;
    expect_refused(*state, &desc, "the planes of boundary enclose nothing"); /* x <= 1, x >= 1 */
    planes[7] = 1.0f;
    desc.boundary.plane_count = 3;
    expect_refused(*state, &desc, "plane 2 of boundary must be finite with a normal that is not 0");
    desc = haze();
    desc.boundary.kind = AIR_BOUNDARY_MESH;
    expect_refused(*state, &desc, "the boundary mesh has no positions or no indices");
    test_mesh mesh = {.vertex_count = 0};
    mesh_add_cube(&mesh);
    desc.boundary.positions = mesh.positions;
    desc.boundary.vertex_count = mesh.vertex_count;
    desc.boundary.indices = mesh.indices;
    desc.boundary.triangle_count = 10;
    expect_refused(*state, &desc, "not closed: 4 open edges");
    desc.boundary.kind = (air_boundary_kind)9;
    expect_refused(*state, &desc, "boundary.kind is 9");
}

static bool region_has(const air_region *region, air_vec3 p)
{
    for (size_t i = 0; i < region->plane_count; i++) {
        if (vec3_dot(region->planes[i].n, p) > region->planes[i].h) {
            return false;
        }
    }
    return true;
}

static void test_a_box_region_is_the_image_of_the_cube(void **state)
{
    air_rng rng = air_rng_from_keys(1, 9);
    for (int n = 0; n < 200; n++) {
        air_medium_desc desc = haze();
        desc.boundary.kind = AIR_BOUNDARY_BOX;
        for (int i = 0; i < 12; i++) {
            desc.boundary.box_to_world[i] =
                4.0f * air_rng_float(&rng) - 2.0f; /* skewed and mirrored too */
        }
        if (fabs(affine_determinant(desc.boundary.box_to_world)) < 0.05) {
            continue;
        }
        air_media media = build(*state, &desc, 1);
        assert_int_equal(media.region_count, 1);
        assert_int_equal(media.media[0].boundary, AIR_BOUNDARY_BOX);
        for (int i = 0; i < 100; i++) {
            const air_vec3 u =
                vec3(3.0f * air_rng_float(&rng) - 1.5f, 3.0f * air_rng_float(&rng) - 1.5f,
                     3.0f * air_rng_float(&rng) - 1.5f);
            const float reach = fmaxf(fabsf(u.x), fmaxf(fabsf(u.y), fabsf(u.z)));
            const air_vec3 p = affine_point(desc.boundary.box_to_world, u);
            if (fabsf(reach - 1.0f) >
                1e-4f) { /* determinants above 0.05 keep roundings below that */
                assert_true(region_has(&media.regions[0], p) == (reach < 1.0f));
            }
            if (reach < 1.0f) {
                const float q[3] = {p.x, p.y, p.z};
                for (int k = 0; k < 3; k++) {
                    assert_true(q[k] >= media.media[0].bounds_min[k] &&
                                q[k] <= media.media[0].bounds_max[k]);
                }
            }
        }
        air_media_finish(((memory_file *)*state)->context, &media);
    }
}

static void test_planes_are_normalised_and_bounded(void **state)
{
    memory_file *files = *state;
    /* the tetrahedron x, y, z >= 1, x + y + z <= 6; then without its last face */
    const float planes[] = {-2, 0, 0, -2, 0, -3, 0, -3, 0, 0, -0.5f, -0.5f, 5, 5, 5, 30};
    air_medium_desc desc = haze();
    desc.boundary.kind = AIR_BOUNDARY_CONVEX;
    desc.boundary.planes = planes;
    desc.boundary.plane_count = 4;
    air_media media = build(files, &desc, 1);
    for (int k = 0; k < 3; k++) {
        assert_float_equal(media.media[0].bounds_min[k], 1.0f, 1e-5f);
        assert_float_equal(media.media[0].bounds_max[k], 4.0f, 1e-5f);
    }
    for (size_t i = 0; i < 4; i++) {
        assert_float_equal(vec3_length(media.regions[0].planes[i].n), 1.0f, 1e-6f);
    }
    assert_true(region_has(&media.regions[0], vec3(1.1f, 1.1f, 3.7f)));
    assert_false(region_has(&media.regions[0], vec3(1.1f, 1.1f, 3.9f)));
    air_media_finish(files->context, &media);
    desc.boundary.plane_count = 3;
    media = build(files, &desc, 1);
    for (int k = 0; k < 3; k++) {
        assert_float_equal(media.media[0].bounds_min[k], 1.0f, 1e-4f);
        assert_true(isinf(media.media[0].bounds_max[k]));
    }
    air_media_finish(files->context, &media);
}

static void test_layers_become_regions_between_their_heights(void **state)
{
    memory_file *files = *state;
    air_medium_desc desc = haze();
    desc.density.kind = AIR_DENSITY_LAYERED;
    desc.density.layer_count = 3;
    desc.density.layer_bottom[0] = -1.0f;
    desc.density.layer_bottom[1] = 0.5f;
    desc.density.layer_bottom[2] = 2.0f;
    desc.density.layer_density[0] = 3.0f;
    desc.density.layer_density[2] = 1.0f; /* the middle one is empty */
    air_media media = build(files, &desc, 1);
    assert_int_equal(media.region_count, 2);
    assert_true(media.all_constant);
    assert_int_equal(media.media[0].kind, AIR_DENSITY_CONSTANT);
    assert_int_equal(media.media[0].declared_kind, AIR_DENSITY_LAYERED);
    assert_true(media.regions[0].density == 3.0f && media.regions[1].density == 1.0f);
    assert_true(region_has(&media.regions[0], vec3(7, 0.4f, 7)) &&
                !region_has(&media.regions[0], vec3(7, 0.6f, 7)));
    assert_false(region_has(&media.regions[0], vec3(7, -1.1f, 7)));
    assert_true(region_has(&media.regions[1], vec3(7, 1e9f, 7)) &&
                !region_has(&media.regions[1], vec3(7, 1.9f, 7)));
    air_media_finish(files->context, &media);
    /* an empty layer of a replacing medium still replaces */
    desc.combine = AIR_COMBINE_REPLACE;
    desc.boundary.kind = AIR_BOUNDARY_BOX;
    media = build(files, &desc, 1);
    assert_int_equal(media.region_count, 3);
    assert_true(media.any_replace);
    assert_int_equal(media.regions[1].plane_count, 8);
    air_media_finish(files->context, &media);
}

static void set_mesh(air_medium_desc *desc, const test_mesh *mesh)
{
    desc->boundary.kind = AIR_BOUNDARY_MESH;
    desc->boundary.positions = mesh->positions;
    desc->boundary.vertex_count = mesh->vertex_count;
    desc->boundary.indices = mesh->indices;
    desc->boundary.triangle_count = mesh->triangle_count;
}

static void test_meshes_become_planes_where_they_can(void **state)
{
    memory_file *files = *state;
    test_mesh cube = {.vertex_count = 0}, ico = {.vertex_count = 0}, torus = {.vertex_count = 0};
    mesh_add_cube(&cube);
    mesh_flip(&cube, 0, 12);
    mesh_add_icosphere(&ico, 0);
    mesh_add_torus(&torus, 2.0f, 0.5f, 48, 24);
    air_medium_desc descs[3] = {haze(), haze(), haze()};
    set_mesh(&descs[0], &cube);
    set_mesh(&descs[1], &ico);
    set_mesh(&descs[2], &torus);
    air_media media = build(files, descs, 3);
    assert_int_equal(media.media[0].boundary, AIR_BOUNDARY_BOX);
    assert_int_equal(media.media[1].boundary, AIR_BOUNDARY_CONVEX);
    assert_int_equal(media.media[2].boundary, AIR_BOUNDARY_MESH);
    assert_int_equal(media.regions[0].plane_count, 6);
    assert_int_equal(media.regions[1].plane_count, 20);
    assert_int_equal(media.regions[2].kind, AIR_REGION_MESH);
    assert_int_equal(media.boundary_mesh_count, 1);
    assert_non_null(media.boundary_accelerator);
    assert_true(media.media[2].bounds_max[0] == 2.5f && media.media[2].bounds_min[0] == -2.5f);
    /* along x through the torus' middle: cube and icosahedron in the middle, the tube on either
     * side */
    air_segment segments[AIR_MAX_SEGMENTS];
    const size_t count =
        air_media_segments(&media, vec3(-10, 0.01f, 0.01f), vec3(1, 0, 0), INFINITY, segments);
    float inside[3] = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        for (int m = 0; m < 3; m++) {
            inside[m] += segments[i].regions >> m & 1 ? segments[i].t1 - segments[i].t0 : 0.0f;
        }
    }
    assert_float_equal(inside[0], 2.0f, 1e-4f);
    assert_float_equal(inside[2], 2.0f, 0.01f); /* two chords of a 24-gon, and off its middle */
    assert_true(inside[1] > 1.6f && inside[1] < 2.0f);
    air_media_finish(files->context, &media);
}

static void test_grid_media_are_bounded_by_their_grid(void **state)
{
    memory_file *files = *state;
    const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    const air_grid_desc grid_desc = {.size = {2, 2, 2},
                                     .channels = 1,
                                     .values = values,
                                     .index_to_local = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    air_grid *grid = NULL;
    assert_int_equal(air_grid_create(files->context, &grid_desc, &grid), AIR_OK);
    air_medium_desc desc = haze();
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid_to_world[3] = 10.0f;
    air_medium_source source = {&desc, grid, NULL, NULL};
    air_media media;
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_OK);
    assert_false(media.all_constant);
    assert_int_equal(media.media[0].boundary, AIR_BOUNDARY_UNBOUNDED);
    assert_float_equal(media.media[0].bounds_min[0], 9.5f, 1e-5f);
    assert_float_equal(media.media[0].bounds_max[1], 1.5f, 1e-5f);
    assert_true(region_has(&media.regions[0], vec3(11.4f, 1.4f, -0.4f)));
    assert_false(region_has(&media.regions[0], vec3(11.6f, 1.4f, -0.4f)));
    air_media_finish(files->context, &media);
    /* a replacing medium clears all of its box */
    desc.combine = AIR_COMBINE_REPLACE;
    desc.boundary.kind = AIR_BOUNDARY_BOX;
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_OK);
    assert_true(region_has(&media.regions[0], vec3(-0.9f, 0, 0)));
    air_media_finish(files->context, &media);
    source.density_grid = NULL;
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_ERROR_ARGUMENT);
    memory_file_expect(files, "medium \"haze\": density.grid names no grid");
    air_grid_destroy(grid);
}

static void test_more_regions_than_a_segment_can_name_are_refused(void **state)
{
    memory_file *files = *state;
    air_medium_desc desc = haze();
    air_medium_source sources[4];
    air_media media;
    desc.density.kind = AIR_DENSITY_LAYERED;
    desc.density.layer_count = 17;
    for (int i = 0; i < 17; i++) {
        desc.density.layer_bottom[i] = (float)i;
        desc.density.layer_density[i] = 1.0f;
    }
    for (int i = 0; i < 4; i++) {
        sources[i].desc = &desc;
    }
    assert_int_equal(air_media_build(files->context, sources, 3, &media), AIR_OK);
    air_media_finish(files->context, &media);
    assert_int_equal(air_media_build(files->context, sources, 4, &media), AIR_ERROR_ARGUMENT);
    memory_file_expect(files, "medium \"haze\": with it the scene has more than 64 regions");
}

static void test_no_media_are_media_too(void **state)
{
    memory_file *files = *state;
    air_segment segments[AIR_MAX_SEGMENTS];
    air_media media;
    assert_int_equal(air_media_build(files->context, NULL, 0, &media), AIR_OK);
    assert_true(media.all_constant && media.region_count == 0);
    assert_int_equal(air_media_segments(&media, vec3_set1(0), vec3(1, 0, 0), INFINITY, segments),
                     0);
    air_media_finish(files->context, &media);
    air_media_finish(files->context, &media); /* all zero is legal */
}

static void test_allocation_failure_leaves_nothing_behind(void **state)
{
    memory_file *files = *state;
    test_mesh torus = {.vertex_count = 0};
    mesh_add_torus(&torus, 2.0f, 0.5f, 8, 6);
    air_medium_desc descs[2] = {haze(), haze()};
    set_mesh(&descs[1], &torus);
    const air_medium_source sources[2] = {{.desc = &descs[0]}, {.desc = &descs[1]}};
    const long live = atomic_load(&files->allocator.live);
    long allowed = 0;
    for (air_status status = AIR_ERROR_MEMORY; status != AIR_OK; allowed++) {
        air_media media;
        atomic_store(&files->allocator.remaining, allowed);
        status = air_media_build(files->context, sources, 2, &media);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        if (status == AIR_OK) {
            air_media_finish(files->context, &media);
        }
        assert_true(atomic_load(&files->allocator.live) <= live + 1); /* the message may be kept */
    }
    assert_true(allowed > 10);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_coefficients_out_of_range_are_refused),
        TEST(test_mixtures_out_of_range_are_refused),
        TEST(test_media_own_their_mixtures),
        TEST(test_densities_out_of_range_are_refused),
        TEST(test_boundaries_without_an_inside_are_refused),
        TEST(test_a_box_region_is_the_image_of_the_cube),
        TEST(test_planes_are_normalised_and_bounded),
        TEST(test_layers_become_regions_between_their_heights),
        TEST(test_meshes_become_planes_where_they_can),
        TEST(test_grid_media_are_bounded_by_their_grid),
        TEST(test_more_regions_than_a_segment_can_name_are_refused),
        TEST(test_no_media_are_media_too),
        TEST(test_allocation_failure_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Light through glass: against closed forms, and what has to be invisible. */
#include <stdio.h>

#include "airlight/image.h"
#include "boundary_meshes.h"
#include "path_scene.h"

static air_material_desc glass_of(float ior, float alpha)
{
    air_material_desc glass;
    air_material_desc_default(&glass);
    glass.model = AIR_MATERIAL_DIELECTRIC;
    glass.ior = ior;
    glass.alpha_u = glass.alpha_v = alpha;
    return glass;
}

static air_handle add_material(air_scene *scene, const air_material_desc *material)
{
    air_handle handle;
    assert_int_equal(air_scene_add_material(scene, material, &handle), AIR_OK);
    return handle;
}

static test_mesh shape;

/* The shape, scaled, at the origin. */
static void add_shape(air_scene *scene, float scale, air_handle material)
{
    air_mesh_desc mesh;
    air_handle handle;
    air_mesh_desc_default(&mesh);
    mesh.positions = shape.positions;
    mesh.vertex_count = shape.vertex_count;
    mesh.indices = shape.indices;
    mesh.triangle_count = shape.triangle_count;
    mesh.material = material;
    mesh.to_world[0] = mesh.to_world[5] = mesh.to_world[10] = scale;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
}

static void add_ball(air_scene *scene, float scale, air_handle material)
{
    memset(&shape, 0, sizeof shape);
    mesh_add_icosphere(&shape, 3);
    add_shape(scene, scale, material);
}

static void add_cube(air_scene *scene, float scale, air_handle material)
{
    memset(&shape, 0, sizeof shape);
    mesh_add_cube(&shape);
    add_shape(scene, scale, material);
}

static air_scene *furnace(void **state)
{
    air_scene *scene = path_scene(state);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    return scene;
}

static const float RAYS[3][6] = {{-3, 0.1f, 0.2f, 1, 0, 0},
                                 {2, 2.5f, -3, -0.5f, -0.6f, 0.62f},
                                 {-3, 0.7f, 0.3f, 1, -0.02f, 0.01f}};

/* ---- furnaces ---- */

/* Radiance `least` to 1 along the rays, with at most 0.2 % standard error. */
static void assert_radiance_between(air_scene *scene, double least, uint32_t samples)
{
    air_snapshot *snapshot = path_freeze(scene);
    for (int i = 0; i < 3; i++) {
        const air_vec3 dir = vec3_normalize(vec3_load(RAYS[i] + 3));
        const probe_result got =
            measure_radiance(snapshot, vec3_load(RAYS[i]), dir, UINT32_MAX, samples);
        for (int c = 0; c < 3; c++) {
            const double slack = 3.0 * got.error[c] + 1e-4; /* twenty events in float */
            if (got.error[c] > 0.002 || got.mean[c] > 1.0 + slack || got.mean[c] < least - slack) {
                fail_msg("ray %d: radiance %g +- %g", i, got.mean[c], got.error[c]);
            }
        }
    }
    air_snapshot_release(snapshot);
}

static void a_ball_of_glass_is_invisible_in_an_even_sky(void **state)
{
    static const float iors[] = {1.33f, 1.5f, 2.4f, 0.75f};
    for (int i = 0; i < 4; i++) {
        air_scene *scene = furnace(state);
        const air_material_desc glass = glass_of(iors[i], 0.0f);
        add_ball(scene, 1.0f, add_material(scene, &glass));
        assert_radiance_between(scene, 1.0, 128);
    }
}

/* What facets scatter a second time is lost: of the order of alpha^2 at each surface seen from
 * above, of alpha at grazing angles, which the third ray has at two surfaces. */
static void a_rough_ball_is_all_but_invisible(void **state)
{
    air_scene *scene = furnace(state);
    const air_material_desc glass = glass_of(1.5f, 0.1f);
    add_ball(scene, 1.0f, add_material(scene, &glass));
    assert_radiance_between(scene, 0.93, 512);
}

static void white_fog_in_glass_is_invisible(void **state)
{
    air_scene *scene = furnace(state);
    const air_material_desc glass = glass_of(1.5f, 0.0f);
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(0.9f));
    set3(medium.sigma_s, 1.0f, 1.0f, 1.0f);
    add_medium(scene, &medium);
    add_cube(scene, 1.0f, add_material(scene, &glass));
    assert_radiance_between(scene, 1.0, 256);
}

static void nested_dielectrics_are_invisible(void **state)
{
    air_scene *scene = furnace(state);
    const air_material_desc glass = glass_of(1.5f, 0.0f), water = glass_of(1.33f / 1.5f, 0.0f);
    add_ball(scene, 1.0f, add_material(scene, &glass));
    add_ball(scene, 0.8f, add_material(scene, &water));
    assert_radiance_between(scene, 1.0, 64);
}

/* ---- slabs and panes ---- */

/* Straight on through a cube that absorbs: with R = 0.04 at each face and A on the way across, R +
 * (1 - R)^2 A / (1 - R A) of an even sky. */
static void absorbing_glass_follows_the_series(void **state)
{
    const float sigma[3] = {0.1f, 0.7f, 2.0f};
    air_scene *scene = furnace(state);
    const air_material_desc glass = glass_of(1.5f, 0.0f);
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(1.0f));
    set3(medium.sigma_a, sigma[0], sigma[1], sigma[2]);
    add_medium(scene, &medium);
    add_cube(scene, 1.0f, add_material(scene, &glass));
    air_snapshot *snapshot = path_freeze(scene);
    const probe_result got =
        measure_radiance(snapshot, vec3(0.2f, 0.1f, 3.0f), vec3(0, 0, -1), UINT32_MAX, 4096);
    double expected[3];
    for (int c = 0; c < 3; c++) {
        const double a = exp(-2.0 * (double)sigma[c]), r = 0.04;
        expected[c] = r + (1.0 - r) * (1.0 - r) * a / (1.0 - r * a);
    }
    assert_measured("absorbing glass", &got, expected, 0.02);
    air_snapshot_release(snapshot);
}

/* A glowing wall behind a pane, seen at 60 degrees: T = (1 - R) / (1 + R). */
static void panes_pass_what_both_faces_leave(void **state)
{
    air_scene *scene = path_scene(state);
    air_material_desc pane = glass_of(1.5f, 0.0f);
    pane.model = AIR_MATERIAL_THIN_DIELECTRIC;
    add_floor(scene, 0.0f, 5.0f, add_material(scene, &pane));
    add_floor(scene, -1.0f, 50.0f, add_lambert(scene, 0.0f, 2.0f));
    air_snapshot *snapshot = path_freeze(scene);
    const double s = 0.8660254037844386, c = 0.5, t = sqrt(1.0 - s * s / 2.25);
    const double across = (c - 1.5 * t) / (c + 1.5 * t), along = (1.5 * c - t) / (1.5 * c + t);
    const double r = 0.5 * (across * across + along * along);
    const double expected[3] = {2.0 * (1.0 - r) / (1.0 + r), 2.0 * (1.0 - r) / (1.0 + r),
                                2.0 * (1.0 - r) / (1.0 + r)};
    const probe_result got =
        measure_radiance(snapshot, vec3(0, 1, 0), vec3((float)s, -(float)c, 0), UINT32_MAX, 4096);
    assert_measured("pane", &got, expected, 0.01);
    air_snapshot_release(snapshot);
}

/* Lamps seen in a mirror count fully, though surfaces ask for their light as well. */
static void mirrors_show_lamps(void **state)
{
    air_scene *scene = path_scene(state);
    air_material_desc mirror;
    air_material_desc_default(&mirror);
    mirror.model = AIR_MATERIAL_CONDUCTOR;
    set3(mirror.reflectance, 0.9f, 0.5f, 0.25f);
    add_floor(scene, 0.0f, 5.0f, add_material(scene, &mirror));
    add_quad(scene, vec3(-9, 3, -9), vec3(18, 0, 0), vec3(0, 0, 18),
             add_lambert(scene, 0.0f, 2.0f)); /* looks down */
    air_snapshot *snapshot = path_freeze(scene);
    const double expected[3] = {1.8, 1.0, 0.5};
    const probe_result got =
        measure_radiance(snapshot, vec3(0, 1, 0), vec3_normalize(vec3(1, -1, 0.3f)), 1, 16);
    assert_measured("mirror", &got, expected, 1e-6);
    air_snapshot_release(snapshot);
}

/* The mean of the picture of a lamp in a mirror. */
static double mirror_picture(void **state, const air_snapshot *snapshot, const char *methods)
{
    air_render_params params;
    air_film *film;
    air_image *image;
    double sum = 0.0;
    air_render_params_default(&params);
    params.width = params.height = 4;
    params.sample_end = 16;
    params.methods = methods;
    assert_int_equal(air_render(*state, snapshot, &params, &film), AIR_OK);
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
    for (int i = 0; i < 16; i++) {
        sum += (double)air_image_plane(image, 0)[i] / 16.0;
    }
    air_image_destroy(image);
    air_film_destroy(film);
    return sum;
}

/* Another method owns the lamp's light on surfaces, but cannot ask a mirror for it. */
static void mirrors_show_lamps_of_other_methods(void **state)
{
    air_scene *scene = path_scene(state);
    air_material_desc mirror;
    air_camera_desc camera;
    air_handle handle;
    air_material_desc_default(&mirror);
    mirror.model = AIR_MATERIAL_CONDUCTOR;
    air_camera_desc_default(&camera); /* looks down from between */
    const float to_world[12] = {1, 0, 0, 0, 0, 0, 1, 1, 0, -1, 0, 0};
    memcpy(camera.to_world, to_world, sizeof to_world);
    assert_int_equal(air_scene_add_camera(scene, &camera, &handle), AIR_OK);
    add_floor(scene, 0.0f, 5.0f, add_material(scene, &mirror));
    add_quad(scene, vec3(-9, 3, -9), vec3(18, 0, 0), vec3(0, 0, 18),
             add_lambert(scene, 0.0f, 2.0f));
    air_snapshot *snapshot = path_freeze(scene);
    assert_true(fabs(mirror_picture(state, snapshot, "path") - 2.0) < 1e-5);
    assert_true(fabs(mirror_picture(state, snapshot, "arealight") - 2.0) < 1e-5);
    air_snapshot_release(snapshot);
}

/* ---- no boundary at all ---- */

/* A floor under a lamp and a sky, with a box of fog whose boundary is a mesh of some material, or
 * none. */
static probe_result through_box(void **state, const air_material_desc *material)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(1.0f));
    set3(medium.sigma_a, 0.1f, 0.2f, 0.4f);
    set3(medium.sigma_s, 0.3f, 0.2f, 0.1f);
    add_medium(scene, &medium);
    add_environment(scene, 0.5f, 0.5f, 0.5f);
    add_point_light(scene, vec3(0.5f, 2.0f, 0.0f), 3.0f);
    add_floor(scene, -1.5f, 4.0f, add_lambert(scene, 0.5f, 0.0f));
    if (material != NULL) {
        add_cube(scene, 1.0f, add_material(scene, material));
    }
    air_snapshot *snapshot = path_freeze(scene);
    const probe_result got =
        measure_radiance(snapshot, vec3(0.2f, 1.8f, 2.0f), vec3_normalize(vec3(0, -1, -1)), 4, 256);
    air_snapshot_release(snapshot);
    return got;
}

static void boundaries_of_nothing_change_nothing(void **state)
{
    air_material_desc nothing;
    air_material_desc_default(&nothing);
    nothing.model = AIR_MATERIAL_NULL;
    const air_material_desc matched = glass_of(1.0f, 0.3f);
    const probe_result plain = through_box(state, NULL), passed = through_box(state, &nothing),
                       same = through_box(state, &matched);
    for (int c = 0; c < 3; c++) { /* the same numbers, to the last digit */
        assert_true(plain.mean[c] > 0.01);
        assert_true(plain.mean[c] == passed.mean[c] && plain.mean[c] == same.mean[c]);
    }
}

/* An index that differs by less than facets resolve: all goes straight on, as an event. */
static void an_index_of_nearly_one_bends_nothing(void **state)
{
    air_scene *scene = furnace(state);
    const air_material_desc glass = glass_of(1.00005f, 0.3f);
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(1.0f));
    set3(medium.sigma_a, 0.1f, 0.7f, 2.0f);
    add_medium(scene, &medium);
    add_cube(scene, 1.0f, add_material(scene, &glass));
    air_snapshot *snapshot = path_freeze(scene);
    const double expected[3] = {exp(-0.2), exp(-1.4), exp(-4.0)};
    const probe_result got =
        measure_radiance(snapshot, vec3(0.2f, 0.1f, 3.0f), vec3(0, 0, -1), UINT32_MAX, 16);
    /* the square of the index changes radiance by 1e-4 on the way in, and back on the way out */
    assert_measured_within("nearly one", &got, expected, 0.05, 2e-4);
    air_snapshot_release(snapshot);
}

/* ---- scenes that are refused ---- */

static void blends_of_blends_are_refused(void **state)
{
    air_scene *scene = path_scene(state);
    air_material_desc blend;
    air_snapshot *snapshot = NULL;
    air_material_desc_default(&blend);
    blend.model = AIR_MATERIAL_BLEND;
    blend.blend[0] = add_lambert(scene, 0.5f, 0.0f);
    blend.blend[1] = add_lambert(scene, 0.2f, 0.0f);
    blend.blend[1] = add_material(scene, &blend);
    (void)add_material(scene, &blend);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_ERROR_ARGUMENT);
    assert_null(snapshot);
    air_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_of_glass_is_invisible_in_an_even_sky),
        cmocka_unit_test(a_rough_ball_is_all_but_invisible),
        cmocka_unit_test(white_fog_in_glass_is_invisible),
        cmocka_unit_test(nested_dielectrics_are_invisible),
        cmocka_unit_test(absorbing_glass_follows_the_series),
        cmocka_unit_test(panes_pass_what_both_faces_leave),
        cmocka_unit_test(mirrors_show_lamps),
        cmocka_unit_test(mirrors_show_lamps_of_other_methods),
        cmocka_unit_test(boundaries_of_nothing_change_nothing),
        cmocka_unit_test(an_index_of_nearly_one_bends_nothing),
        cmocka_unit_test(blends_of_blends_are_refused),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

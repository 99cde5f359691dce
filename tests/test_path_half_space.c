/* A dense medium behind a plane, against Chandrasekhar's H function: mean free paths of a few
 * thousandths of the body, so that rays which start some way behind the surface that they leave
 * would be seen at once; in any unit of length. */
#include "half_space.h"
#include "path_scene.h"

/* Single-scattering albedos of the channels: a body of 300 mean free paths each way is a half
 * space to all of them, exp(-300 sqrt(3 (1 - 0.9))) being 0. */
static const double albedos[3] = {1.0 / 3.0, 0.7, 0.9};
static const double UNITS[3] = {0.01, 1.0, 100.0};

/* The body below y = 0, half a side of it 1 in this unit. */
static air_scene *dense_body(void **state, double unit)
{
    const float side = (float)unit;
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(vec3(0.0f, -side, 0.0f), vec3_set1(side));
    for (int c = 0; c < 3; c++) {
        medium.sigma_s[c] = (float)(300.0 * albedos[c] / unit);
        medium.sigma_a[c] = (float)(300.0 * (1.0 - albedos[c]) / unit);
    }
    add_medium(scene, &medium);
    return scene;
}

/* Seen from above at 60 degrees. */
static probe_result look_at_body(air_scene *scene, double unit, uint32_t samples)
{
    const air_vec3 dir = vec3(0.8660254f, -0.5f, 0.0f);
    air_snapshot *snapshot = path_freeze(scene);
    const probe_result got =
        measure_radiance(snapshot, vec3_scale(dir, (float)(-2.0 * unit)), dir, UINT32_MAX, samples);
    air_snapshot_release(snapshot);
    return got;
}

static void beams_come_back_as_the_h_function_says(void **state)
{
    double expected[3];
    for (int c = 0; c < 3; c++) {
        expected[c] = half_space_of_beam(albedos[c], 0.8, 0.5);
    }
    for (int i = 0; i < 3; i++) {
        air_scene *scene = dense_body(state, UNITS[i]);
        add_sun(scene, vec3(1.0f, 1.0f, 1.0f), vec3(0.0f, -0.8f, 0.6f));
        const probe_result got = look_at_body(scene, UNITS[i], 4096);
        assert_measured("beam", &got, expected, 0.003);
    }
}

/* Light of an even sky, through nothing, and through a surface of an index of 1, which walks leave
 * as they leave any glass. With u = 2^-24 they start at most 10 u D away from it (scene/surface.c),
 * D = 2.9 sides across its triangles: 5e-4 mean free paths, over a cosine of 0.5, once on the way
 * in and once on the way out. */
static void skies_come_back_through_a_surface_as_through_none(void **state)
{
    double expected[3];
    for (int c = 0; c < 3; c++) {
        expected[c] = half_space_of_sky(albedos[c], 0.5);
    }
    for (int i = 0; i < 6; i++) {
        const double unit = UNITS[i / 2];
        air_scene *scene = dense_body(state, unit);
        add_environment(scene, 1.0f, 1.0f, 1.0f);
        if (i % 2 != 0) {
            air_material_desc nothing;
            air_handle material;
            air_material_desc_default(&nothing);
            nothing.model = AIR_MATERIAL_DIELECTRIC;
            nothing.ior = 1.0f;
            assert_int_equal(air_scene_add_material(scene, &nothing, &material), AIR_OK);
            add_floor(scene, 0.0f, (float)unit, material);
        }
        const probe_result got = look_at_body(scene, unit, 8192);
        assert_measured_within(i % 2 != 0 ? "surface" : "none", &got, expected, 0.002, 2e-3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beams_come_back_as_the_h_function_says),
        cmocka_unit_test(skies_come_back_through_a_surface_as_through_none),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

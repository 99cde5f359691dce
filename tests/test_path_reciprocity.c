/* Reciprocity: exchanging an isotropic point source and a point of measurement leaves the fluence
 * as it is, whatever media and reciprocal surfaces are around them. */
#include "core/random.h"
#include "path_scene.h"

/* Each replicate; see test_path_fluence.c. */
enum { SAMPLES = 32768 };

/* Two Lambertian squares: a floor and a wall that hides part of everything. */
static void add_surfaces(air_scene *scene)
{
    add_floor(scene, -1.0f, 2.0f, add_lambert(scene, 0.7f, 0.0f));
    add_quad(scene, vec3(-0.2f, -1.0f, -0.5f), vec3(0.0f, 0.9f, 0.0f), vec3(0.0f, 0.0f, 1.5f),
             add_lambert(scene, 0.4f, 0.0f));
}

static void add_haze(air_scene *scene, float half_width)
{
    air_medium_desc haze = medium_in_box(vec3(0.0f, 0.0f, 0.0f), vec3(half_width, 1.5f, 1.5f));
    set3(haze.sigma_s, 0.3f, 0.4f, 0.5f);
    set3(haze.sigma_a, 0.05f, 0.02f, 0.1f);
    haze.phase.kind = AIR_PHASE_HG;
    haze.phase.g = 0.5f;
    add_medium(scene, &haze);
}

static void add_fog(air_scene *scene, float half_width)
{
    air_medium_desc fog = medium_in_box(vec3(0.0f, 0.2f, 0.0f), vec3(half_width, 1.4f, 1.0f));
    set3(fog.sigma_s, 0.8f, 0.6f, 0.4f);
    set3(fog.sigma_a, 0.1f, 0.1f, 0.1f);
    fog.phase.kind = AIR_PHASE_RAYLEIGH;
    fog.density.kind = AIR_DENSITY_EXPONENTIAL;
    fog.density.base_height = -0.7f;
    fog.density.scale_height = 0.5f;
    add_medium(scene, &fog);
}

static void add_smoke(air_scene *scene)
{
    enum { SIDE = 8 };
    float values[SIDE * SIDE * SIDE];
    air_rng rng = air_rng_from_keys(21, 22);
    const air_vec3 center = vec3(0.1f, 0.3f, 0.2f), half = vec3(0.6f, 0.6f, 0.6f);
    air_medium_desc smoke = medium_in_box(center, half);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        values[i] = fmaxf(0.0f, 3.0f * air_rng_float(&rng) - 1.0f);
    }
    set3(smoke.sigma_s, 1.0f, 1.2f, 0.8f);
    set3(smoke.sigma_a, 0.3f, 0.1f, 0.2f);
    smoke.phase.kind = AIR_PHASE_HG;
    smoke.phase.g = -0.3f;
    smoke.density.kind = AIR_DENSITY_GRID;
    smoke.density.grid = add_box_grid(scene, SIDE, 1, values, center, half);
    add_medium(scene, &smoke);
}

/* Fluence of light scattered at least once. */
static probe_result fluence(void **state, bool with_smoke, air_vec3 from, air_vec3 at,
                            uint32_t samples)
{
    air_scene *scene = path_scene(state);
    const float half_width = with_smoke ? 1.0f : 2.0f;
    add_surfaces(scene);
    add_haze(scene, half_width);
    add_fog(scene, half_width);
    if (with_smoke) {
        add_smoke(scene);
    }
    add_point_light(scene, from, 1.0f);
    air_snapshot *snapshot = path_freeze(scene);
    const probe_result got = measure_fluence(snapshot, at, from, UINT32_MAX, samples);
    air_snapshot_release(snapshot);
    return got;
}

static void source_and_detector_in_fog_may_change_places(void **state)
{
    const air_vec3 a = vec3(-1.2f, -0.3f, 0.3f), b = vec3(0.9f, 0.4f, 0.5f);
    const probe_result there = fluence(state, false, a, b, SAMPLES);
    const probe_result back = fluence(state, false, b, a, SAMPLES);
    assert_same_measured("in fog", &there, &back, 0.02);
}

/* The two points are in clear air: rays past a grid find no distance by equi-angular sampling, so
 * that the variance in the medium around a point light would be infinite. */
static void source_and_detector_beside_smoke_may_change_places(void **state)
{
    const air_vec3 a = vec3(-1.4f, -0.3f, 0.3f), b = vec3(1.3f, 0.6f, 0.5f);
    const probe_result there = fluence(state, true, a, b, SAMPLES);
    const probe_result back = fluence(state, true, b, a, SAMPLES);
    assert_same_measured("beside smoke", &there, &back, 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(source_and_detector_in_fog_may_change_places),
        cmocka_unit_test(source_and_detector_beside_smoke_may_change_places),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

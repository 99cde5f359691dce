/* A homogeneous medium told as a grid is the same medium: closed forms and tracking must agree, for
 * single and for multiple scattering. */
#include <stdio.h>

#include "path_scene.h"

enum { SIDE = 4 };

typedef void add_lights(air_scene *scene);

static void a_point_light(air_scene *scene)
{
    add_point_light(scene, vec3(0.3f, 1.6f, 0.2f), 1.0f);
}

static void a_polygon_light(air_scene *scene)
{
    static const float panel[12] = {-0.4f, 1.5f, -0.3f, 0.4f,  1.5f, -0.3f,
                                    0.4f,  1.5f, 0.3f,  -0.4f, 1.5f, 0.3f};
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_POLYGON;
    set3(light.color, 1.0f, 1.0f, 1.0f);
    light.vertices = panel;
    light.vertex_count = 4;
    add_light(scene, &light);
}

static void an_environment(air_scene *scene) { add_environment(scene, 0.5f, 1.0f, 0.7f); }

/* A chromatic box of fog over (and, with a floor, on) y = -1, as it is or as a grid of ones. */
static air_snapshot *fog_box(void **state, add_lights *lights, bool with_floor, bool as_grid)
{
    float ones[SIDE * SIDE * SIDE];
    const air_vec3 center = vec3(0.0f, 0.0f, 0.0f), half = vec3(1.0f, 1.0f, 1.0f);
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(center, half);
    set3(medium.sigma_s, 0.5f, 0.8f, 1.2f);
    set3(medium.sigma_a, 0.1f, 0.2f, 0.1f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = 0.4f;
    if (as_grid) {
        for (size_t i = 0; i < SIDE * SIDE * SIDE; i++) {
            ones[i] = 1.0f;
        }
        medium.density.kind = AIR_DENSITY_GRID;
        medium.density.grid = add_box_grid(scene, SIDE, 1, ones, center, half);
    }
    add_medium(scene, &medium);
    if (with_floor) {
        add_floor(scene, -0.999f, 3.0f, add_lambert(scene, 0.8f, 0.0f));
    }
    lights(scene);
    return path_freeze(scene);
}

/* Single scattering to 1 %, all of it to 2 %: the grid's standard error dominates, 8192 samples in
 * each of 32 replicates. */
static void compare(void **state, add_lights *lights, bool with_floor)
{
    static const float rays[3][6] = {{-3, 0.3f, 0.2f, 1, -0.1f, 0},
                                     {0.2f, 0.4f, 2.5f, 0, -0.4f, -1},
                                     {0, 0, 0, 0.3f, -0.8f, 0.2f}};
    static const uint32_t depths[2] = {1, 8};
    air_snapshot *plain = fog_box(state, lights, with_floor, false);
    air_snapshot *grid = fog_box(state, lights, with_floor, true);
    for (int i = 0; i < 3; i++) {
        const air_vec3 origin = vec3_load(rays[i]), dir = vec3_normalize(vec3_load(rays[i] + 3));
        for (int d = 0; d < 2; d++) {
            char what[64];
            snprintf(what, sizeof what, "ray %d, depth %u", i, (unsigned)depths[d]);
            const probe_result a = measure_radiance(plain, origin, dir, depths[d], 1024);
            const probe_result b = measure_radiance(grid, origin, dir, depths[d], 8192);
            assert_same_measured(what, &a, &b, d == 0 ? 0.01 : 0.02);
        }
    }
    air_snapshot_release(plain);
    air_snapshot_release(grid);
}

static void a_point_light_lights_both_alike(void **state) { compare(state, a_point_light, false); }

static void a_polygon_light_lights_both_alike(void **state)
{
    compare(state, a_polygon_light, false);
}

static void an_environment_lights_both_alike(void **state)
{
    compare(state, an_environment, false);
}

/* Paths on which several rays are tracked one after the other, surfaces between them: each must
 * have chances of its own. */
static void a_floor_in_both_looks_alike(void **state)
{
    compare(state, an_environment, true);
    compare(state, a_point_light, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_light_lights_both_alike),
        cmocka_unit_test(a_polygon_light_lights_both_alike),
        cmocka_unit_test(an_environment_lights_both_alike),
        cmocka_unit_test(a_floor_in_both_looks_alike),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

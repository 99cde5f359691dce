/* Tracking through media with detail against quadrature along the ray, and against the same density
 * said in another way. */
#include <stdio.h>

#include "core/quadrature.h"
#include "path/tracking.h"
#include "path_scene.h"
#include "scene/fingerprint.h"

/* A medium per kind of density, and all of them on top of each other. */
typedef enum fog { FOG_EVEN, FOG_LAYERS, FOG_EXPONENTIAL, FOG_GRID, FOG_ALL, FOG_COUNT } fog;

static const char *const fog_names[FOG_COUNT] = {"even", "layers", "exponential", "grid", "all"};

static void set_layers(air_density *density)
{
    density->kind = AIR_DENSITY_LAYERED;
    density->layer_count = 2;
    density->layer_bottom[0] = -INFINITY;
    density->layer_density[0] = 1.5f;
    density->layer_bottom[1] = 0.1f;
    density->layer_density[1] = 0.4f;
}

static void set_exponential(air_density *density)
{
    density->kind = AIR_DENSITY_EXPONENTIAL;
    density->base_height = -0.5f;
    density->scale_height = 0.7f;
}

static void set_grid(air_scene *scene, air_density *density, air_vec3 center, air_vec3 half)
{
    enum { SIDE = 5 };
    float values[SIDE * SIDE * SIDE];
    air_rng rng = air_rng_from_keys(17, 3);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        values[i] = fmaxf(2.0f * air_rng_float(&rng) - 0.4f, 0.0f);
    }
    density->kind = AIR_DENSITY_GRID;
    density->grid = add_box_grid(scene, SIDE, 1, values, center, half);
}

/* Of density `kind`, with detail; without coefficients yet. */
static air_medium_desc make_fog(air_scene *scene, fog kind)
{
    const air_vec3 center = vec3(0.1f, 0.0f, -0.1f), half = vec3(1.0f, 0.9f, 1.1f);
    air_medium_desc medium = medium_in_box(center, half);
    medium.density.detail.strength = 0.9f;
    medium.density.detail.scale = 0.4f;
    medium.density.detail.octaves = 3;
    medium.density.detail.seed = (uint32_t)kind;
    if (kind == FOG_LAYERS) {
        set_layers(&medium.density);
    } else if (kind == FOG_EXPONENTIAL) {
        set_exponential(&medium.density);
    } else if (kind == FOG_GRID) {
        set_grid(scene, &medium.density, center, half);
    }
    return medium;
}

static air_snapshot *foggy(void **state, fog kind)
{
    air_scene *scene = path_scene(state);
    for (int k = FOG_EVEN; k < FOG_ALL; k++) {
        if (kind == FOG_ALL || k == (int)kind) {
            const float sigma_a = kind == FOG_ALL ? 0.15f : 0.6f;
            air_medium_desc medium = make_fog(scene, (fog)k);
            set3(medium.sigma_a, 0.5f * sigma_a, sigma_a, 1.2f * sigma_a);
            add_medium(scene, &medium);
        }
    }
    if (kind == FOG_ALL) { /* even fog without detail, too */
        air_medium_desc plain = medium_in_box(vec3(-0.5f, 0, 0), vec3(1, 1, 1));
        set3(plain.sigma_a, 0.3f, 0.2f, 0.1f);
        add_medium(scene, &plain);
    }
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    return path_freeze(scene);
}

/* Optical depths by the midpoints of 16384 steps per segment: of noise whose second derivatives are
 * below 20 / 0.1^2 times sigma_t, and of grids with kinks at voxels; off by less than 1e-5. */
static void quadrature(const air_snapshot *snapshot, air_vec3 origin, air_vec3 dir, double depth[3])
{
    enum { STEPS = 16384 };
    air_segment segments[AIR_MAX_SEGMENTS];
    const air_media *media = &snapshot->media;
    const size_t count = air_media_segments(media, origin, dir, 1e3f, segments);
    depth[0] = depth[1] = depth[2] = 0.0;
    for (size_t s = 0; s < count; s++) {
        const double step = ((double)segments[s].t1 - (double)segments[s].t0) / STEPS;
        for (int i = 0; i < STEPS; i++) {
            const float t = (float)((double)segments[s].t0 + (i + 0.5) * step);
            for (uint64_t rest = segments[s].regions; rest != 0; rest &= rest - 1) {
                const air_region *region = &media->regions[__builtin_ctzll(rest)];
                const air_vec3 sigma_t = air_medium_coefficients(&media->media[region->medium],
                                                                 region, vec3_madd(origin, t, dir))
                                             .sigma_t;
                depth[0] += step * (double)sigma_t.x;
                depth[1] += step * (double)sigma_t.y;
                depth[2] += step * (double)sigma_t.z;
            }
        }
    }
}

enum { RAYS = 6 };

static air_vec3 ray_origin(int i) { return vec3(-2.5f, 0.15f * (float)i - 0.4f, 0.1f); }

static air_vec3 ray_dir(int i)
{
    return vec3_normalize(vec3(1.0f, 0.07f * (float)(i - 3), 0.05f * (float)(2 - i)));
}

/* Independent estimates: the mean within five standard errors, once in 2e6 times beyond. 90
 * comparisons, seeds fixed. */
static void assert_tracked(const air_snapshot *snapshot, fog kind, int i, const double expected[3])
{
    enum { ESTIMATES = 20000 };
    air_ray_media *ray = malloc(sizeof *ray);
    air_rng rng = air_rng_from_keys((uint32_t)kind, (uint32_t)i);
    double sum[3] = {0.0}, squares[3] = {0.0};
    assert_non_null(ray);
    air_ray_media_make(ray, &snapshot->media, ray_origin(i), ray_dir(i), INFINITY);
    assert_false(ray->closed);
    for (int n = 0; n < ESTIMATES; n++) {
        const air_vec3 found = air_track_transmittance(ray, 1e3f, &rng);
        const double values[3] = {(double)found.x, (double)found.y, (double)found.z};
        for (int c = 0; c < 3; c++) {
            sum[c] += values[c] / ESTIMATES;
            squares[c] += values[c] * values[c] / ESTIMATES;
        }
    }
    for (int c = 0; c < 3; c++) {
        const double error = sqrt((squares[c] - sum[c] * sum[c]) / ESTIMATES);
        if (!(fabs(sum[c] - expected[c]) < 5.0 * error + 1e-5) || !(error < 0.03 * sum[c])) {
            fail_msg("%s, ray %d, channel %d: %g +- %g, expected %g", fog_names[kind], i, c, sum[c],
                     error, expected[c]);
        }
    }
    free(ray);
}

/* By ratio tracking, and as the sky is seen by whole paths: both with majorants that must hold. */
static void transmittance_is_that_of_quadrature(void **state)
{
    for (int kind = 0; kind < FOG_COUNT; kind++) {
        air_snapshot *snapshot = foggy(state, (fog)kind);
        for (int i = 0; i < RAYS; i++) {
            double depth[3], expected[3];
            quadrature(snapshot, ray_origin(i), ray_dir(i), depth);
            for (int c = 0; c < 3; c++) {
                expected[c] = exp(-depth[c]);
            }
            assert_tracked(snapshot, (fog)kind, i, expected);
            const probe_result seen =
                measure_radiance(snapshot, ray_origin(i), ray_dir(i), 1, 1024);
            assert_measured_within(fog_names[kind], &seen, expected, 0.02, 3e-5);
        }
        air_snapshot_release(snapshot);
    }
}

/* The factor is not 1: what would be let through without it is another share. */
static void detail_changes_what_is_let_through(void **state)
{
    air_snapshot *snapshot = foggy(state, FOG_EVEN);
    double most = 0.0;
    for (int i = 0; i < RAYS; i++) {
        double depth[3];
        quadrature(snapshot, ray_origin(i), ray_dir(i), depth);
        most = fmax(most, fabs(depth[1] / 1.2 - 1.0)); /* of 2 m, nearly */
    }
    assert_true(most > 0.1);
    air_snapshot_release(snapshot);
}

/* In a furnace whose medium glows as it absorbs, with radiance 1 everywhere, light is 1 whatever
 * the density: emission has the factor, too, and majorants hold, without which collisions would be
 * too few. */
static void a_furnace_stays_even(void **state)
{
    const double one[3] = {1.0, 1.0, 1.0};
    for (int kind = 0; kind < FOG_ALL; kind++) {
        air_scene *scene = path_scene(state);
        air_medium_desc medium = make_fog(scene, (fog)kind);
        set3(medium.sigma_s, 1.0f, 1.0f, 1.0f);
        set3(medium.sigma_a, 0.5f, 0.5f, 0.5f);
        set3(medium.emission, 0.5f, 0.5f, 0.5f);
        add_medium(scene, &medium);
        add_environment(scene, 1.0f, 1.0f, 1.0f);
        air_snapshot *snapshot = path_freeze(scene);
        for (int i = 0; i < RAYS; i += 2) {
            const probe_result seen =
                measure_radiance(snapshot, ray_origin(i), ray_dir(i), 64, 2048);
            assert_measured(fog_names[kind], &seen, one, 0.005);
        }
        air_snapshot_release(snapshot);
    }
}

static air_snapshot *lit_fog(void **state, bool as_grid)
{
    enum { SIDE = 4 };
    float ones[SIDE * SIDE * SIDE];
    const air_vec3 center = vec3(0, 0, 0), half = vec3(1, 1, 1);
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(center, half);
    set3(medium.sigma_s, 0.5f, 0.8f, 1.2f);
    set3(medium.sigma_a, 0.1f, 0.2f, 0.1f);
    medium.density.detail.strength = 0.7f;
    medium.density.detail.scale = 0.3f;
    if (as_grid) {
        for (size_t i = 0; i < SIDE * SIDE * SIDE; i++) {
            ones[i] = 1.0f;
        }
        medium.density.kind = AIR_DENSITY_GRID;
        medium.density.grid = add_box_grid(scene, SIDE, 1, ones, center, half);
    }
    add_medium(scene, &medium);
    add_environment(scene, 0.5f, 1.0f, 0.7f);
    add_point_light(scene, vec3(0.3f, 1.6f, 0.2f), 1.0f);
    return path_freeze(scene);
}

/* Even fog and a grid of ones with the same detail are the same: to 2 % of 8 events. */
static void kinds_of_density_have_the_same_detail(void **state)
{
    air_snapshot *even = lit_fog(state, false), *grid = lit_fog(state, true);
    for (int i = 0; i < 3; i++) {
        const probe_result a = measure_radiance(even, ray_origin(i), ray_dir(i), 8, 4096);
        const probe_result b = measure_radiance(grid, ray_origin(i), ray_dir(i), 8, 4096);
        assert_same_measured("even fog and grid", &a, &b, 0.02);
    }
    air_snapshot_release(even);
    air_snapshot_release(grid);
}

static uint64_t fingerprint(void **state, float strength, uint32_t seed)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(vec3(0, 0, 0), vec3(1, 1, 1));
    set3(medium.sigma_s, 1, 1, 1);
    medium.density.detail.strength = strength;
    medium.density.detail.seed = seed;
    add_medium(scene, &medium);
    air_snapshot *snapshot = path_freeze(scene);
    const uint64_t out = air_fingerprint_snapshot(snapshot);
    air_snapshot_release(snapshot);
    return out;
}

/* Films say which scene they are of; without detail its seed is nothing. */
static void fingerprints_know_detail_where_there_is_some(void **state)
{
    assert_true(fingerprint(state, 0.0f, 1) == fingerprint(state, 0.0f, 2));
    assert_true(fingerprint(state, 0.5f, 1) == fingerprint(state, 0.5f, 1));
    assert_true(fingerprint(state, 0.5f, 1) != fingerprint(state, 0.5f, 2));
    assert_true(fingerprint(state, 0.5f, 1) != fingerprint(state, 0.0f, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transmittance_is_that_of_quadrature),
        cmocka_unit_test(detail_changes_what_is_let_through),
        cmocka_unit_test(a_furnace_stays_even),
        cmocka_unit_test(fingerprints_know_detail_where_there_is_some),
        cmocka_unit_test(kinds_of_density_have_the_same_detail),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

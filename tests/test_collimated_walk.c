/* Multiple scattering: limits in closed form, agreement of all ways to draw distances, and the
 * published means of six pixels. */
#include "chi_square.h"
#include "cmocka_test.h"
#include "collimated_scene_a.h"
#include "half_space.h"

/* Numbers from a list. */
typedef struct number_list {
    const double *numbers;
    size_t used;
} number_list;

static double listed_number(void *user)
{
    number_list *self = user;
    return self->numbers[self->used++];
}

static bool agree(mean_error a, mean_error b, double errors)
{
    return fabs(a.mean - b.mean) <= errors * hypot(a.error, b.error);
}

/* ---- limits ---- */

static void one_event_is_the_single_scattering_estimator(void **state)
{
    air_rng rng = air_rng_from_keys(1, 8);
    roomy_profile room;
    (void)state;
    for (int n = 0; n < 3000; n++) {
        const lit_ray r = random_lit_ray(&rng);
        make_profile(&r, roomy(&room));
        sphere_scene scene = {.medium = r.medium, .sigma_t = r.sigma_t};
        memcpy(scene.to_light, r.to_light, sizeof scene.to_light);
        air_collimated_walk_params params = walk_in(&scene, 0.5);
        params.surroundings = (air_collimated_surroundings){NULL, NULL, NULL};
        params.max_events = 1;
        params.phase = (air_phase){.kind = AIR_PHASE_HG, .g = 0.6f};
        params.distance = (air_collimated_distance)(n % 3);
        const double u = random_unit(&rng);
        number_list list = {&u, 0};
        if (r.t_max < INFINITY) {
            continue;
        }
        const air_collimated_sums sums =
            air_collimated_walk(&params, r.origin, r.dir, listed_number, &list);
        const air_collimated_draw draw =
            air_collimated_estimate((air_collimated_estimator)(n % 3), &room.profile, u);
        const double cos_theta = dot(r.dir, r.to_light);
        const double phase = (1.0 - 0.36) / (4.0 * AIR_PI * pow(1.36 - 1.2 * cos_theta, 1.5));
        const double light = params.sigma_s * params.irradiance * phase;
        /* g and the phase function are floats. */
        assert_true(fabs(sums.analytic - light * draw.analytic) <= 3e-6 * light * draw.analytic);
        assert_true(fabs(sums.unoccluded - light * draw.unoccluded) <=
                    3e-6 * light * draw.unoccluded);
        assert_true(sums.occluded == sums.unoccluded);
        assert_int_equal(list.used, room.profile.count > 0 ? 1 : 0);
    }
}

static void without_albedo_single_scattering_is_left(void **state)
{
    sphere_scene scene = scene_a(64);
    const double albedo = 1e-9;
    (void)state;
    for (int k = 0; k < AIR_COLLIMATED_DISTANCE_COUNT; k++) {
        air_collimated_walk_params params = walk_in(&scene, albedo);
        params.distance = (air_collimated_distance)k;
        for (int pixel = 64 * 20; pixel < 64 * 64; pixel += 577) {
            scene_ray ray;
            if (!scene_ray_make(&scene, pixel, &ray)) {
                continue;
            }
            const moments m = walk_moments(&params, scene.eye, ray.dir, 2000, (uint32_t)pixel);
            /* Of further events, each by the albedo smaller, the sum is below 1e-8. */
            assert_true(fabs(m.sum[0] / albedo - ray.unoccluded) < 1e-7 * ray.unoccluded);
            const mean_error plain = plain_of(&m), ratio = ratio_of(&m);
            const double exact = albedo * ray.exact;
            assert_true(fabs(plain.mean - exact) <= 4.5 * plain.error + 1e-7 * exact);
            assert_true(fabs(ratio.mean - exact) <= 4.5 * ratio.error + 1e-7 * exact);
        }
    }
}

static void without_scattering_there_is_nothing(void **state)
{
    sphere_scene scene = scene_a(64);
    air_rng rng = air_rng_from_keys(2, 8);
    double dir[3];
    (void)state;
    scene_direction(&scene, 64 * 32 + 32, dir);
    air_collimated_walk_params params = walk_in(&scene, 0.0);
    air_collimated_sums sums = air_collimated_walk(&params, scene.eye, dir, next_number, &rng);
    assert_true(sums.analytic == 0.0 && sums.unoccluded == 0.0 && sums.occluded == 0.0);
    params = walk_in(&scene, 0.9);
    const double away[3] = {-dir[0], -dir[1], -dir[2]};
    sums = air_collimated_walk(&params, scene.eye, away, next_number, &rng);
    assert_true(sums.analytic == 0.0 && sums.unoccluded == 0.0 && sums.occluded == 0.0);
}

/* A half space below z = 0 under light from straight above, which comes straight back. */
static void a_half_space_reflects_what_the_h_function_says(void **state)
{
    const double planes[1][4] = {{0.0, 0.0, 1.0, 0.0}};
    const double origin[3] = {0.0, 0.0, 1.0}, down[3] = {0.0, 0.0, -1.0};
    const double albedo = 0.9, expected = half_space_of_beam(albedo, 1.0, 1.0);
    air_collimated_medium medium;
    air_collimated_walk_params params;
    (void)state;
    assert_int_equal(air_collimated_medium_from_planes(NULL, planes, 1, &medium), AIR_OK);
    air_collimated_walk_params_default(&params);
    params.medium = &medium;
    params.to_light[1] = 0.0;
    params.to_light[2] = 1.0;
    params.sigma_t = 2.0;
    params.sigma_s = albedo * params.sigma_t;
    params.max_events = 1000; /* 0.9^1000: nothing is cut off */
    for (int k = 0; k < 2; k++) {
        params.distance =
            k == 0 ? AIR_COLLIMATED_DISTANCE_EXTINCTION : AIR_COLLIMATED_DISTANCE_MIXTURE;
        const moments m = walk_moments(&params, origin, down, 80000, 3);
        const mean_error plain = plain_of(&m);
        assert_true(plain.error < 0.005 * expected);
        assert_true(fabs(plain.mean - expected) <= 4.0 * plain.error);
        /* Nothing is hidden: the ratio estimator is the analytic sum. */
        assert_true(fabs(m.sum[0] - expected) <=
                    4.0 * propagated(&m, (const double[3]){1.0, 0.0, 0.0}));
    }
}

/* ---- agreement ---- */

static const int oracle_pixels[6][2] = {{128, 128}, {180, 150}, {40, 60},
                                        {110, 90},  {128, 200}, {200, 50}};

static void pixels_have_the_published_means(void **state)
{
    static const mean_error figures[6] = {{0.24198, 0.00012}, {0.28428, 0.0002},
                                          {0.78572, 0.00017}, {0.38914, 0.0001},
                                          {0.24057, 0.00013}, {0.91265, 0.00016}};
    sphere_scene scene = scene_a(256);
    air_collimated_walk_params params = walk_in(&scene, 0.9);
    (void)state;
    for (int i = 0; i < 6; i++) {
        double dir[3];
        mean_error found[2 * AIR_COLLIMATED_DISTANCE_COUNT];
        size_t count = 0;
        scene_direction(&scene, oracle_pixels[i][1] * 256 + oracle_pixels[i][0], dir);
        for (int k = 0; k < AIR_COLLIMATED_DISTANCE_COUNT; k++) {
            params.distance = (air_collimated_distance)k;
            const moments m = walk_moments(&params, scene.eye, dir, 60000, (uint32_t)i);
            found[count++] = plain_of(&m);
            found[count++] = ratio_of(&m);
        }
        /* 48 comparisons with the figures, 168 with each other (of which few are independent): 4
         * and 4.5 standard errors leave 3e-3 and 1e-3 to chance. */
        for (size_t a = 0; a < count; a++) {
            assert_true(agree(found[a], figures[i], 4.0));
            assert_true(found[a].error < 0.01 * found[a].mean);
            for (size_t b = 0; b < a; b++) {
                assert_true(agree(found[a], found[b], 4.5));
            }
        }
    }
}

static void chance_endings_change_no_mean(void **state)
{
    sphere_scene scene = scene_a(256);
    double dir[3];
    (void)state;
    scene_direction(&scene, 60 * 256 + 40, dir);
    for (int k = 0; k < AIR_COLLIMATED_DISTANCE_COUNT; k++) {
        air_collimated_walk_params params = walk_in(&scene, 0.9);
        params.distance = (air_collimated_distance)k;
        params.max_events = 30;
        const moments all = walk_moments(&params, scene.eye, dir, 40000, 1);
        params.roulette = 0.5;
        const moments some = walk_moments(&params, scene.eye, dir, 40000, 2);
        assert_true(agree(plain_of(&all), plain_of(&some), 4.0));
        assert_true(agree(ratio_of(&all), ratio_of(&some), 4.0));
    }
}

/* Thick fog: weights of whole-volume distances alone spread over exp(8) per event. */
static void dense_media_agree_by_extinction_and_mixture(void **state)
{
    sphere_scene scene = scene_a(256);
    (void)state;
    scene.sigma_t = 4.0;
    for (int i = 0; i < 6; i++) {
        double dir[3];
        mean_error found[2][2];
        air_collimated_walk_params params = walk_in(&scene, 0.9);
        scene_direction(&scene, oracle_pixels[i][1] * 256 + oracle_pixels[i][0], dir);
        for (int k = 0; k < 2; k++) {
            params.distance =
                k == 0 ? AIR_COLLIMATED_DISTANCE_EXTINCTION : AIR_COLLIMATED_DISTANCE_MIXTURE;
            const moments m = walk_moments(&params, scene.eye, dir, 60000, 10u + (uint32_t)i);
            found[k][0] = plain_of(&m);
            found[k][1] = ratio_of(&m);
        }
        assert_true(agree(found[0][0], found[1][0], 4.0));
        assert_true(agree(found[0][1], found[1][1], 4.0));
        assert_true(agree(found[0][0], found[0][1], 4.0));
    }
}

/* ---- phase functions ---- */

static double hg_value(void *user, double cos_theta)
{
    const double g = *(const double *)user;
    return (1.0 - g * g) / (4.0 * AIR_PI * pow(1.0 + g * g - 2.0 * g * cos_theta, 1.5));
}

static double hg_sample(void *user, double u)
{
    const double g = *(const double *)user, s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
    return (1.0 + g * g - s * s) / (2.0 * g);
}

static void own_phase_functions_do_as_built_in_ones(void **state)
{
    enum { WALKS = 2000 };
    sphere_scene scene = scene_a(256);
    double dir[3], g = 0.75;
    const air_collimated_phase own = {hg_value, hg_sample, &g};
    int equal = 0;
    (void)state;
    scene_direction(&scene, 60 * 256 + 40, dir);
    air_collimated_walk_params params = walk_in(&scene, 0.9);
    params.phase = (air_phase){.kind = AIR_PHASE_HG, .g = (float)g};
    for (uint32_t seed = 0; seed < WALKS; seed++) {
        air_rng one = air_rng_from_keys(seed, 9), two = one;
        params.own_phase = NULL;
        const double built_in =
            air_collimated_walk(&params, scene.eye, dir, next_number, &one).occluded;
        params.own_phase = &own;
        const double mine =
            air_collimated_walk(&params, scene.eye, dir, next_number, &two).occluded;
        equal += fabs(built_in - mine) <= 1e-4 * mine;
    }
    /* Directions part by 1e-7, the rounding to float, grown over 8 events: a walk in ten thousand
     * passes an edge of the sphere or of its shadow on the other side. */
    assert_true(equal >= 0.995 * WALKS);
}

/* Direction of the second segment, seen by the surface callback. */
typedef struct direction_watch {
    int calls;
    double dir[3];
} direction_watch;

static double watch_direction(void *user, const double origin[3], const double dir[3])
{
    direction_watch *self = user;
    (void)origin;
    if (self->calls++ == 1) {
        memcpy(self->dir, dir, sizeof self->dir);
    }
    return INFINITY;
}

static void directions_follow_the_phase_function(void **state)
{
    enum { COSINES = 10, AZIMUTHS = 6, BINS = COSINES * AZIMUTHS, COUNT = 30000 };
    static const float mean_cosines[3] = {-0.4f, 0.0f, 0.8f};
    sphere_scene scene = scene_a(16);
    air_rng rng = air_rng_from_keys(5, 8);
    (void)state;
    for (int k = 0; k < 3; k++) {
        const double g = mean_cosines[k];
        double observed[BINS] = {0.0}, expected[BINS];
        direction_watch watch;
        air_collimated_walk_params params = walk_in(&scene, 1.0);
        params.phase = (air_phase){.kind = AIR_PHASE_HG, .g = mean_cosines[k]};
        params.max_events = 2;
        params.surroundings = (air_collimated_surroundings){watch_direction, NULL, &watch};
        double dir[3], side[3], up[3];
        const double *l = scene.to_light;
        scene_direction(&scene, 100, dir);
        cross(dir, l, side);
        normalise(side);
        cross(dir, side, up);
        for (int n = 0; n < COUNT; n++) {
            watch.calls = 0;
            (void)air_collimated_walk(&params, scene.eye, dir, next_number, &rng);
            assert_true(fabs(dot(watch.dir, watch.dir) - 1.0) < 1e-14);
            const double cos_theta = dot(watch.dir, dir);
            /* Distribution function of HG, and the azimuth about the old direction. */
            const double share =
                g == 0.0 ? 0.5 * (1.0 + cos_theta)
                         : (1.0 - g * g) / (2.0 * g) *
                               (1.0 / sqrt(1.0 + g * g - 2.0 * g * cos_theta) - 1.0 / (1.0 + g));
            const double azimuth =
                0.5 + atan2(dot(watch.dir, up), dot(watch.dir, side)) / (2.0 * AIR_PI);
            const int i = (int)fmin(COSINES - 1, fmax(0.0, share * COSINES));
            const int j = (int)fmin(AZIMUTHS - 1, azimuth * AZIMUTHS);
            observed[i * AZIMUTHS + j] += 1.0;
        }
        for (int i = 0; i < BINS; i++) {
            expected[i] = COUNT / (double)BINS;
        }
        assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-3);
    }
}

static void parameters_out_of_range_are_named(void **state)
{
    sphere_scene scene = scene_a(16);
    air_context *context = NULL;
    (void)state;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    const air_collimated_walk_params good = walk_in(&scene, 1.0);
    assert_int_equal(air_collimated_walk_check(context, &good), AIR_OK);
    air_collimated_walk_params bad[9];
    for (int i = 0; i < 9; i++) {
        bad[i] = good;
    }
    bad[0].medium = NULL;
    bad[1].to_light[0] = 2.0;
    bad[2].sigma_t = INFINITY;
    bad[3].sigma_s = 1.5 * good.sigma_t;
    bad[4].irradiance = -1.0;
    bad[5].distance = AIR_COLLIMATED_DISTANCE_COUNT;
    bad[6].roulette = NAN;
    bad[7].phase = (air_phase){.kind = AIR_PHASE_HG, .g = 1.0f};
    const air_phase_mixture half = {1, {{AIR_PHASE_ISOTROPIC, 0.0f, 0.5f}}};
    bad[8].phase = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = &half};
    static const char *const named[9] = {"medium",   "to_light", "sigma_t", "sigma_s", "irradiance",
                                         "distance", "roulette", "g must",  "sum to 1"};
    for (int i = 0; i < 9; i++) {
        assert_int_equal(air_collimated_walk_check(context, &bad[i]), AIR_ERROR_ARGUMENT);
        assert_non_null(strstr(air_context_last_error(context), named[i]));
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_event_is_the_single_scattering_estimator),
        cmocka_unit_test(without_albedo_single_scattering_is_left),
        cmocka_unit_test(without_scattering_there_is_nothing),
        cmocka_unit_test(a_half_space_reflects_what_the_h_function_says),
        cmocka_unit_test(pixels_have_the_published_means),
        cmocka_unit_test(chance_endings_change_no_mean),
        cmocka_unit_test(dense_media_agree_by_extinction_and_mixture),
        cmocka_unit_test(own_phase_functions_do_as_built_in_ones),
        cmocka_unit_test(directions_follow_the_phase_function),
        cmocka_unit_test(parameters_out_of_range_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

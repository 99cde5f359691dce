/* Scene A: its exact picture, and how close every estimator comes to it. */
#include "cmocka_test.h"
#include "collimated_scene_a.h"

/* Largest relative difference to figures of 12 digits: 1e-9 as asked for; they round at 1e-12. */
static bool near_figure(double value, double figure)
{
    return fabs(value - figure) <= 1e-9 * fabs(figure);
}

static void pixels_are_those_of_the_oracle(void **state)
{
    static const struct {
        int x, y;
        double begin, end, unoccluded, shadow_begin, shadow_end, exact;
    } pixels[6] = {{128, 128, 2.62496011965, 3.27969431227, 0.181171081814, 3.07558658287,
                    3.27969431227, 0.140540390403},
                   {180, 150, 2.64807382769, 4.76653288984, 0.266416906656, 2.92491431385,
                    3.91941037685, 0.141533921419},
                   {110, 90, 2.58372314474, 3.21176538684, 0.258461129085, 0, 0, 0.258461129085},
                   {40, 60, 2.70406475736, 4.03387954677, 0.548961662825, 0, 0, 0.548961662825},
                   {200, 50, 2.50823879472, 4.51482983049, 0.693721124032, 0, 0, 0.693721124032},
                   {128, 200, 2.844930943, 4.33983744001, 0.119128203081, 0, 0, 0.119128203081}};
    const sphere_scene scene = scene_a(256);
    (void)state;
    for (int i = 0; i < 6; i++) {
        scene_ray ray;
        assert_true(scene_ray_make(&scene, pixels[i].y * 256 + pixels[i].x, &ray));
        const air_collimated_profile *profile = &ray.room.profile;
        assert_true(near_figure(profile->pieces[0].t0, pixels[i].begin));
        assert_true(near_figure(profile->pieces[profile->count - 1].t1, pixels[i].end));
        assert_true(near_figure(ray.unoccluded, pixels[i].unoccluded));
        assert_true(near_figure(ray.exact, pixels[i].exact));
        if (pixels[i].shadow_end > 0.0) {
            assert_true(near_figure(ray.shadow.begin, pixels[i].shadow_begin));
            assert_true(near_figure(ray.shadow.end, pixels[i].shadow_end));
        } else {
            assert_false(ray.shadow.begin < ray.shadow.end);
        }
    }
}

static void the_exact_picture_has_the_published_statistics(void **state)
{
    const sphere_scene scene = scene_a(256);
    int missed = 0, shadowed = 0;
    double sum = 0.0, most = 0.0;
    (void)state;
    for (int pixel = 0; pixel < 256 * 256; pixel++) {
        scene_ray ray;
        missed += !scene_ray_make(&scene, pixel, &ray);
        shadowed += ray.shadow.begin < ray.shadow.end;
        sum += ray.exact;
        most = fmax(most, ray.exact);
    }
    assert_int_equal(missed, 9689);
    assert_int_equal(shadowed, 18572);
    assert_true(fabs(most - 0.869356573) < 6e-10); /* figures of 9 digits */
    assert_true(fabs(sum / (256 * 256) - 0.237177991) < 6e-10);
}

static void the_shadow_is_where_the_sphere_hides_the_light(void **state)
{
    air_rng rng = air_rng_from_keys(1, 6);
    int dark = 0, lit = 0;
    (void)state;
    for (int n = 0; n < 200; n++) {
        sphere_scene scene = random_sphere_scene(&rng, 16);
        for (int pixel = 0; pixel < 256; pixel++) {
            scene_ray ray;
            if (!scene_ray_make(&scene, pixel, &ray)) {
                continue;
            }
            const air_collimated_profile *profile = &ray.room.profile;
            const double t =
                random_between(&rng, profile->pieces[0].t0, profile->pieces[profile->count - 1].t1);
            double x[3];
            move_along(scene.eye, ray.dir, t, x);
            const bool hidden = sphere_occludes(&scene, x);
            assert_true(hidden == !scene_ray_sees(&ray, t));
            dark += hidden;
            lit += !hidden;
        }
    }
    assert_true(dark > 1000 && lit > 1000);
}

static void estimators_reach_the_published_psnr(void **state)
{
    /* Stratified, 4 and 16 samples per pixel, mean of 3 seeds; seeds differ by 0.1 dB. */
    static const double figures[2][AIR_COLLIMATED_ESTIMATOR_COUNT] = {
        {[AIR_COLLIMATED_RM] = 28.76,
         [AIR_COLLIMATED_DS] = 31.70,
         [AIR_COLLIMATED_REES] = 33.47,
         [AIR_COLLIMATED_REDS] = 36.00,
         [AIR_COLLIMATED_WVDS] = 36.46},
        {[AIR_COLLIMATED_RM] = 44.30,
         [AIR_COLLIMATED_DS] = 44.55,
         [AIR_COLLIMATED_REES] = 46.34,
         [AIR_COLLIMATED_REDS] = 48.16,
         [AIR_COLLIMATED_WVDS] = 47.83}};
    enum { SEEDS = 3, PLANS = 2 * SEEDS * AIR_COLLIMATED_ESTIMATOR_COUNT };
    const sphere_scene scene = scene_a(256);
    picture_plan plans[PLANS];
    double psnr[PLANS];
    size_t count = 0;
    for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
        for (int i = 0; i < 2 * SEEDS; i++) {
            plans[count++] = (picture_plan){&scene, k, PATTERN_STRATIFIED, i < SEEDS ? 4 : 16,
                                            1u + (uint32_t)(i % SEEDS)};
        }
    }
    assert_true(picture_compare(*state, plans, PLANS, psnr));
    for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
        for (int column = 0; column < 2; column++) {
            const double *seeds = psnr + (2 * k + column) * SEEDS;
            const double mean = (seeds[0] + seeds[1] + seeds[2]) / SEEDS;
            assert_true(fabs(mean - figures[column][k]) < 0.4);
        }
    }
}

/* ---- pairwise claims ---- */

static void estimators_beat_each_other_in_random_scenes(void **state)
{
    static const air_collimated_estimator pairs[4][2] = {{AIR_COLLIMATED_WVDS, AIR_COLLIMATED_DS},
                                                         {AIR_COLLIMATED_WVDS, AIR_COLLIMATED_RM},
                                                         {AIR_COLLIMATED_REES, AIR_COLLIMATED_RM},
                                                         {AIR_COLLIMATED_REDS, AIR_COLLIMATED_DS}};
    enum { SCENES = 300 };
    air_rng rng = air_rng_from_keys(2, 6);
    int wins[4] = {0};
    for (int n = 0; n < SCENES; n++) {
        const sphere_scene scene = random_sphere_scene(&rng, 64);
        picture_plan plans[AIR_COLLIMATED_ESTIMATOR_COUNT];
        double psnr[AIR_COLLIMATED_ESTIMATOR_COUNT];
        for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
            plans[k] = (picture_plan){&scene, k, PATTERN_STRATIFIED, 4, 100u + (uint32_t)n};
        }
        assert_true(picture_compare(*state, plans, AIR_COLLIMATED_ESTIMATOR_COUNT, psnr));
        for (int i = 0; i < 4; i++) {
            wins[i] += psnr[pairs[i][0]] > psnr[pairs[i][1]];
        }
    }
    for (int i = 0; i < 4; i++) {
        assert_true(wins[i] >= 0.96 * SCENES);
    }
}

/* ---- progressive sums, several lights ---- */

static void three_sums_beat_averaged_ratios(void **state)
{
    enum { FRAMES = 256, SIZE = 64 };
    const sphere_scene scene = scene_a(SIZE);
    (void)state;
    for (int k = 0; k < 2; k++) {
        const air_collimated_estimator estimator =
            k == 0 ? AIR_COLLIMATED_REES : AIR_COLLIMATED_REDS;
        picture_error sums_error = {0.0, 0.0}, ratios_error = {0.0, 0.0};
        double bias = 0.0, total = 0.0;
        for (int pixel = 0; pixel < SIZE * SIZE; pixel++) {
            scene_ray ray;
            air_collimated_sums all = {0.0, 0.0, 0.0};
            double ratios = 0.0;
            if (!scene_ray_make(&scene, pixel, &ray)) {
                continue;
            }
            for (int frame = 0; frame < FRAMES; frame++) {
                const pattern_place place = {pixel, SIZE, 1000u + (uint32_t)frame};
                double u;
                pattern_independent(&place, 1, &u);
                const air_collimated_sums one = scene_sums(&scene, &ray, (int)estimator, &u, 1);
                sums_add(&all, one);
                ratios += sums_value(estimator, one, 1.0) / FRAMES;
            }
            const double e = sums_value(estimator, all, FRAMES) - ray.exact;
            sums_error.sum += e * e;
            ratios_error.sum += (ratios - ray.exact) * (ratios - ray.exact);
            sums_error.peak = ratios_error.peak = fmax(sums_error.peak, ray.exact);
            bias += ratios - ray.exact;
            total += ray.exact;
        }
        /* 7.7 and 8.7 dB at 512 frames; the noise falls by 3 dB with every doubling while the bias
         * stays, so about 5 dB are left at 256. */
        assert_true(picture_psnr(sums_error, SIZE) > picture_psnr(ratios_error, SIZE) + 3.0);
        assert_true(k == 1 || bias < -1e-3 * total);
    }
}

static void lights_chosen_by_their_integrals_add_up(void **state)
{
    enum { LIGHTS = 3, SAMPLES = 20000 };
    static const double power[LIGHTS] = {1.0, 0.3, 4.0};
    air_rng rng = air_rng_from_keys(3, 6);
    (void)state;
    for (int n = 0; n < 20; n++) {
        sphere_scene scene = random_sphere_scene(&rng, 8);
        scene_ray rays[LIGHTS];
        double give[LIGHTS], exact = 0.0, sum = 0.0;
        const int pixel = 27 + (int)(air_rng_next(&rng) % 2u);
        for (int i = 0; i < LIGHTS; i++) {
            random_direction(&rng, scene.to_light);
            (void)scene_ray_make(&scene, pixel, &rays[i]);
            give[i] = power[i] * rays[i].unoccluded;
            exact += power[i] * rays[i].exact;
            sum += give[i];
        }
        int visible = 0, chosen[LIGHTS] = {0};
        for (int k = 0; k < SAMPLES; k++) {
            double rest;
            const size_t i = air_collimated_choose(give, LIGHTS, (k + 0.5) / SAMPLES, &rest);
            assert_true(rest >= 0.0 && rest < 1.0);
            const double t = air_collimated_sample(&rays[i].room.profile, rest);
            visible += scene_ray_sees(&rays[i], t);
            chosen[i]++;
        }
        /* One stratified number over all (light, distance): each boundary of a light or a shadow
         * misplaces one sample at most, 3 of them per light. */
        assert_true(fabs(sum * visible / SAMPLES - exact) <= 3.0 * LIGHTS * sum / SAMPLES);
        for (int i = 0; i < LIGHTS; i++) {
            assert_true(fabs(chosen[i] - SAMPLES * give[i] / sum) <= 1.0 + 1e-9);
        }
    }
}

static void a_light_that_gives_nothing_is_not_chosen(void **state)
{
    static const double give[4] = {0.0, 2.0, 0.0, 0.0}, none[2] = {0.0, 0.0};
    double rest;
    (void)state;
    assert_int_equal(air_collimated_choose(give, 4, 0.0, &rest), 1);
    assert_int_equal(air_collimated_choose(give, 4, 1.0 - 0x1p-53, &rest), 1);
    assert_true(rest == 1.0 - 0x1p-53);
    assert_int_equal(air_collimated_choose(none, 2, 0.75, &rest), 0);
    assert_true(rest == 0.75);
}

static int setup(void **state)
{
    air_context *context = NULL;
    const air_status status = air_context_create(NULL, &context);
    *state = context;
    return (int)status;
}

static int teardown(void **state)
{
    air_context_destroy(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_are_those_of_the_oracle),
        cmocka_unit_test(the_exact_picture_has_the_published_statistics),
        cmocka_unit_test(the_shadow_is_where_the_sphere_hides_the_light),
        cmocka_unit_test(estimators_reach_the_published_psnr),
        cmocka_unit_test(estimators_beat_each_other_in_random_scenes),
        cmocka_unit_test(three_sums_beat_averaged_ratios),
        cmocka_unit_test(lights_chosen_by_their_integrals_add_up),
        cmocka_unit_test(a_light_that_gives_nothing_is_not_chosen),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}

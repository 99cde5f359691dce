/* Many draws at once: against one at a time, at every instruction set. */
#include <float.h>

#include "cmocka_test.h"
#include "collimated/exponentials.h"
#include "collimated_scene_a.h"

enum { NUMBERS = 600 };

/* Contexts of every instruction set this machine has, and none. */
typedef struct contexts {
    air_context *of[4];
    size_t count;
} contexts;

static int setup(void **state)
{
    contexts *self = calloc(1, sizeof *self);
    air_context_params params;
    air_context_params_default(&params);
    self->count = 1; /* of[0] stays NULL */
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= AIR_CPU_AVX512; cpu++) {
        params.cpu = cpu;
        self->count += air_context_create(&params, &self->of[self->count]) == AIR_OK;
    }
    *state = self;
    return 0;
}

static int teardown(void **state)
{
    contexts *self = *state;
    for (size_t i = 0; i < self->count; i++) {
        air_context_destroy(self->of[i]);
    }
    free(self);
    return 0;
}

static void exponentials_keep_their_bounds(void **state)
{
    static const double far[6] = {700.0, 700.5, 1e3, 1e10, DBL_MAX, INFINITY};
    air_rng rng = air_rng_from_keys(1, 7);
    (void)state;
    for (int n = 0; n < 1000000; n++) {
        /* Of all sizes, and at the ends. */
        const double x = n == 0 ? 0.0 : exp(random_between(&rng, -40.0, log(700.0)));
        const double y = n == 0       ? 0.0
                         : n == 1     ? 1.0 - 0x1p-53
                         : n % 2 == 0 ? exp(random_between(&rng, -700.0, 0.0))
                                      : 1.0 - exp(random_between(&rng, -36.7, -1e-3));
        assert_true(fabs(air_decay(x) - exp(-x)) <= 1e-12 * exp(-x));
        assert_true(fabs(air_neg_log1m_double(y) + log1p(-y)) <= -1e-12 * log1p(-y));
    }
    for (int i = 0; i < 6; i++) {
        assert_true(air_decay(far[i]) == 0.0);
    }
}

/* One medium, one with windows, or overlapping cells. */
static const air_collimated_profile *any_profile(air_rng *rng, int kind, roomy_profile *room,
                                                 roomy_profile *other)
{
    const air_interval windows[3] = {{0.0, 0.3}, {0.7, 1.5}, {1.6, 9.0}};
    const lit_ray r = random_lit_ray(rng), behind = random_lit_ray(rng);
    make_profile(&r, roomy(room));
    if (kind == 1) {
        air_collimated_profile_restrict(&room->profile, windows, 3, roomy(other));
        return &other->profile;
    }
    if (kind == 2) {
        const air_collimated_cell cells[2] = {{behind.medium, behind.sigma_t, 0.0},
                                              {r.medium, r.sigma_t, 1.5}};
        air_collimated_profile_make_cells(cells, 2, r.to_light, r.origin, r.dir, r.t_max,
                                          &room->profile);
    }
    return &room->profile;
}

static void many_draws_are_those_of_one_at_a_time(void **state)
{
    const contexts *self = *state;
    air_rng rng = air_rng_from_keys(2, 7);
    double u[NUMBERS], t[NUMBERS], unoccluded[NUMBERS];
    for (int n = 0; n < 600; n++) {
        roomy_profile room, other;
        const air_collimated_profile *profile = any_profile(&rng, n % 3, &room, &other);
        const air_collimated_estimator estimator =
            (air_collimated_estimator)(n / 3 % AIR_COLLIMATED_ESTIMATOR_COUNT);
        const size_t count = n % 7 == 0 ? NUMBERS : 1u + air_rng_next(&rng) % 40u;
        for (size_t i = 0; i < count; i++) {
            u[i] = ((double)i + random_unit(&rng)) / (double)count;
        }
        air_collimated_draw_many(self->of[(size_t)n % self->count], estimator, profile, u, count, t,
                                 unoccluded);
        const double end = profile->count > 0 ? profile->pieces[profile->count - 1].t1 : 0.0;
        for (size_t i = 0; i < count; i++) {
            const air_collimated_draw one = air_collimated_estimate(estimator, profile, u[i]);
            assert_true(fabs(t[i] - one.t) <= 1e-12 * end);
            /* Exponentials within 3e-13, and the rounding of depths up to 700: the documented
             * 1e-12; beyond depths of 700 it is 0. */
            assert_true(fabs(unoccluded[i] - one.unoccluded) <= 1e-12 * one.unoccluded ||
                        one.unoccluded < 1e-300);
        }
    }
}

typedef struct shaded_ray {
    const sphere_scene *scene;
    size_t points, most;
} shaded_ray;

static void hide_points(void *user, const double *const points[3], size_t count, uint8_t *occluded)
{
    shaded_ray *self = user;
    sphere_scene scene = *self->scene;
    for (size_t i = 0; i < count; i++) {
        const double point[3] = {points[0][i], points[1][i], points[2][i]};
        occluded[i] = sphere_occludes(&scene, point);
    }
    self->points += count;
    self->most = self->most < count ? count : self->most;
}

static void gathered_sums_are_those_of_single_draws(void **state)
{
    const contexts *self = *state;
    enum { MANY = 1000 };
    const sphere_scene scene = scene_a(16);
    double u[MANY];
    for (int n = 0; n < 256; n++) {
        scene_ray ray;
        (void)scene_ray_make(&scene, n, &ray);
        const size_t count = n % 16 == 0 ? MANY : 13;
        for (size_t i = 0; i < count; i++) {
            u[i] = ((double)i + 0.37) / (double)count;
        }
        for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
            const air_collimated_estimator estimator = (air_collimated_estimator)k;
            shaded_ray shaded = {&scene, 0, 0};
            const air_collimated_sums sums = air_collimated_gather(
                self->of[(size_t)n % self->count], estimator, &ray.room.profile, scene.eye, ray.dir,
                u, count, hide_points, &shaded);
            const air_collimated_sums one = scene_sums(&scene, &ray, k, u, (int)count);
            const double bound = 1e-10 * one.analytic;
            assert_true(fabs(sums.analytic - one.analytic) <= bound);
            assert_true(fabs(sums.unoccluded - one.unoccluded) <= bound);
            assert_true(fabs(sums.occluded - one.occluded) <= bound);
            assert_int_equal(shaded.points, ray.room.profile.count > 0 ? count : 0);
            assert_true(shaded.most <= 256);
        }
    }
}

static void an_empty_profile_draws_zeros(void **state)
{
    const contexts *self = *state;
    roomy_profile room;
    const double u[3] = {0.1, 0.5, 0.9};
    for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
        double t[3] = {1.0, 1.0, 1.0}, unoccluded[3] = {1.0, 1.0, 1.0};
        air_collimated_draw_many(self->of[0], (air_collimated_estimator)k, roomy(&room), u, 3, t,
                                 unoccluded);
        for (int i = 0; i < 3; i++) {
            assert_true(t[i] == 0.0 && unoccluded[i] == 0.0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exponentials_keep_their_bounds),
        cmocka_unit_test(many_draws_are_those_of_one_at_a_time),
        cmocka_unit_test(gathered_sums_are_those_of_single_draws),
        cmocka_unit_test(an_empty_profile_draws_zeros),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}

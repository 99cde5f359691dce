/* T of many rays: every instruction set that the machine has against the plain version. */
#include <float.h>
#include <stdio.h>

#include "airlight/collimated.h"
#include "cmocka_test.h"
#include "collimated_fixture.h"
#include "core/cpu.h"

enum { MOST_RAYS = 64, LEVELS = AIR_CPU_AVX512 + 1 };

static air_context *contexts[LEVELS];

static int set_up(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = cpu;
        if (air_context_create(&params, &contexts[cpu]) != AIR_OK) {
            return -1;
        }
    }
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    for (int cpu = AIR_CPU_C; cpu < LEVELS; cpu++) {
        air_context_destroy(contexts[cpu]);
    }
    return 0;
}

typedef struct batch {
    air_collimated_medium medium;
    double to_light[3], sigma_t;
    size_t count;
    double origin[3][MOST_RAYS], dir[3][MOST_RAYS], t_max[MOST_RAYS];
} batch;

static void evaluate(const batch *b, air_cpu cpu, bool bounded, double *out_t, double *out_log)
{
    const air_collimated_rays rays = {{b->origin[0], b->origin[1], b->origin[2]},
                                      {b->dir[0], b->dir[1], b->dir[2]},
                                      bounded ? b->t_max : NULL};
    air_collimated_eval(contexts[cpu], &b->medium, b->to_light, b->sigma_t, &rays, b->count, out_t,
                        out_log);
}

static void add_ray(batch *b, const double origin[3], const double dir[3], double t_max)
{
    for (int k = 0; k < 3; k++) {
        b->origin[k][b->count] = origin[k];
        b->dir[k][b->count] = dir[k];
    }
    b->t_max[b->count++] = t_max;
}

static void get_ray(const batch *b, size_t i, double origin[3], double dir[3])
{
    for (int k = 0; k < 3; k++) {
        origin[k] = b->origin[k][i];
        dir[k] = b->dir[k][i];
    }
}

/* How far two versions may differ, relatively, for one ray. Both form h - n.o, n.v and n.l by the
 * same operations; then t of a face, d at t and sums each round a few times. A rounding of t
 * changes the depth by sigma_t t (1 + slope) epsilon and the length of the stretch b - a by t
 * epsilon; the depth itself, of size sigma_t (b - a + d), carries roundings too. 16 roundings of
 * each are allowed. */
static double agreement(const batch *b, size_t i)
{
    double origin[3], dir[3], slope = 0.0, reach = 0.0;
    air_interval s;
    get_ray(b, i, origin, dir);
    if (!air_collimated_interval(&b->medium, origin, dir, b->t_max[i], &s)) {
        return 0.0;
    }
    if (s.end == INFINITY) {
        s.end = b->sigma_t > 0.0 ? s.begin + 800.0 / b->sigma_t : 1.0; /* cut, or T = 0 */
    }
    for (size_t k = 0; k < b->medium.plane_count; k++) {
        const double *n = b->medium.planes[k], nl = dot(n, b->to_light);
        if (nl > 1e-15 * sqrt(dot(n, n))) {
            slope = fmax(slope, fabs(dot(n, dir)) / nl);
            reach = fmax(reach, fabs(n[3] - dot(n, origin)) / nl);
        }
    }
    const double depth = b->sigma_t * (s.end * (1.0 + slope) + reach);
    return 16.0 * DBL_EPSILON * (1.0 + depth + s.end / (s.end - s.begin));
}

/* Stretches shorter than the rounding of their ends, which lie within 10 m, may be there for one
 * version and not for another. */
static const double vanishing = 16.0 * DBL_EPSILON * 10.0;

static bool may_vanish(const batch *b, size_t i, const double t[2])
{
    double origin[3], dir[3];
    air_interval s;
    get_ray(b, i, origin, dir);
    return !air_collimated_interval(&b->medium, origin, dir, b->t_max[i], &s)
               ? t[1] <= vanishing
               : s.end - s.begin <= vanishing;
}

/* [0]: plain, [1]: another version. */
static void assert_agrees(const batch *b, size_t i, air_cpu cpu, const double t[2],
                          const double log_t[2])
{
    const double tolerance = agreement(b, i);
    const bool same_t = fabs(t[1] - t[0]) <= tolerance * t[0] + 1e-307; /* subnormal T */
    const bool same_log = fabs(log_t[1] - log_t[0]) <= tolerance;
    const bool both_empty =
        t[0] == 0.0 && t[1] == 0.0 && log_t[0] == -INFINITY && log_t[1] == -INFINITY;
    if (!both_empty && !(same_t && same_log) && !may_vanish(b, i, t)) {
        print_error("level %d, ray %zu of %zu: T %.17g instead of %.17g, log T %.17g instead of "
                    "%.17g, tolerance %g\n",
                    (int)cpu, i, b->count, t[1], t[0], log_t[1], log_t[0], tolerance);
        fail();
    }
}

/* Holds every level against the plain version; gives how many rays had light. */
static size_t compare(const batch *b)
{
    double t[LEVELS][MOST_RAYS], log_t[LEVELS][MOST_RAYS];
    size_t lit = 0;
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        evaluate(b, cpu, true, t[cpu], log_t[cpu]);
        for (size_t i = 0; i < b->count; i++) {
            const double pair[2] = {t[AIR_CPU_C][i], t[cpu][i]};
            const double logs[2] = {log_t[AIR_CPU_C][i], log_t[cpu][i]};
            assert_agrees(b, i, cpu, pair, logs);
            lit += cpu == AIR_CPU_C && log_t[cpu][i] > -INFINITY;
        }
    }
    return lit;
}

/* A medium of the kind asked for and rays towards it, from inside and outside. */
static batch random_batch(air_rng *rng, size_t plane_count, size_t ray_count)
{
    batch b = {.sigma_t = exp(random_between(rng, log(0.01), log(50.0)))};
    double centre[3], from[3], target[3], dir[3];
    for (int k = 0; k < 3; k++) {
        centre[k] = random_between(rng, -2.0, 2.0);
    }
    b.medium = random_polyhedron(rng, plane_count, centre);
    random_direction(rng, b.to_light);
    for (size_t i = 0; i < ray_count; i++) {
        for (int k = 0; k < 3; k++) {
            target[k] = centre[k] + random_between(rng, -0.8, 0.8);
        }
        random_direction(rng, dir);
        move_along(target, dir, i % 2 == 0 ? 0.0 : -random_between(rng, 0.0, 6.0), from);
        add_ray(&b, from, dir, i % 3 == 0 ? random_between(rng, 0.1, 8.0) : INFINITY);
    }
    return b;
}

static void boxes_agree(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 1);
    size_t lit = 0;
    for (int i = 0; i < 4000; i++) {
        const batch b = random_batch(&rng, 6, 1 + (size_t)i % 19);
        lit += compare(&b);
    }
    assert_true(lit > 30000); /* of 40,000 */
}

static void polyhedra_agree(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 2);
    size_t lit = 0;
    for (int i = 0; i < 4000; i++) {
        const batch b = random_batch(&rng, 7 + (size_t)i % 34, 1 + (size_t)i % 19);
        lit += compare(&b);
    }
    assert_true(lit > 30000);
}

/* Rays with the light, against it and almost so; light along faces and grazing them at 1e-9; from
 * faces, edges and corners; with a surface before, at and inside the medium. */
static void limits_agree(void **state)
{
    (void)state;
    static const double nudges[] = {0.0, 1e-16, 1e-12, 1e-9, 1e-6};
    static const double sigmas[] = {1e-12, 1e-3, 1.0, 1e3, 1e6};
    const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};
    air_rng rng = air_rng_from_keys(11, 3);
    size_t lit = 0;
    for (int round = 0; round < 3000; round++) {
        batch b = {.medium = box_between(low, high), .sigma_t = sigmas[round % 5]};
        if (round % 3 == 0) { /* a corner cut off by some planes, one of them twice */
            for (int k = 0; k < 5; k++) {
                double *n = b.medium.planes[b.medium.plane_count++];
                random_direction(&rng, n);
                n[3] = 1.2;
            }
            memcpy(b.medium.planes[11], b.medium.planes[7], sizeof b.medium.planes[7]);
            b.medium.plane_count = 12;
        }
        const double nudge = nudges[round / 5 % 5];
        random_direction(&rng, b.to_light);
        if (round % 2 == 0) {
            b.to_light[round / 2 % 3] = nudge; /* along a face, or grazing it */
            b.to_light[(round / 2 + 1) % 3] = round % 4 == 0 ? 0.0 : b.to_light[0];
            normalise(b.to_light);
        }
        for (int i = 0; i < 24; i++) {
            double from[3], dir[3];
            random_direction(&rng, dir);
            for (int k = 0; k < 3; k++) {
                from[k] = random_between(&rng, -1.0, 1.0);
                /* Faces, edges and corners: 0 to 3 coordinates at the boundary. */
                from[k] = (air_rng_next(&rng) & 3u) == 0 ? (from[k] < 0.0 ? -1.0 : 1.0) : from[k];
                dir[k] = i % 4 == 3 && k != i % 3 ? (i % 8 == 3 ? 0.0 : -0.0) : dir[k];
            }
            for (int k = 0; k < 3 && i % 4 < 2; k++) {
                dir[k] = (i % 4 == 0 ? 1.0 : -1.0) * b.to_light[k] + (k == i % 3 ? nudge : 0.0);
            }
            normalise(dir);
            move_along(from, dir, i % 5 == 0 ? -3.0 : 0.0, from);
            add_ray(&b, from, dir, i % 6 == 0 ? random_between(&rng, 0.0, 4.0) : INFINITY);
        }
        lit += compare(&b);
    }
    assert_true(lit > 30000); /* of 72,000 */
}

/* Half-spaces, slabs, all of space, planes that contradict each other, no extinction. */
static void open_and_empty_media_agree(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 4);
    size_t lit = 0;
    for (int round = 0; round < 2000; round++) {
        batch b = random_batch(&rng, 6 + (size_t)round % 5, 12);
        b.medium.plane_count = (size_t)round / 5 % 6;
        if (round % 7 == 0) {
            b.medium.planes[1][3] = -b.medium.planes[0][3] - 1.0;
        }
        b.sigma_t = round % 11 == 0 ? 0.0 : b.sigma_t;
        lit += compare(&b);
    }
    assert_true(lit > 5000);
    batch b = random_batch(&rng, 6, 5);
    b.sigma_t = NAN;
    assert_int_equal(compare(&b), 0);
    b.sigma_t = -1.0;
    assert_int_equal(compare(&b), 0);
    b.sigma_t = 1.0;
    b.to_light[1] = INFINITY;
    assert_int_equal(compare(&b), 0);
}

static void what_is_not_finite_gives_zero_and_leaves_its_neighbours_alone(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 5);
    const batch whole = random_batch(&rng, 6, 24);
    static const double bad[3] = {NAN, INFINITY, -INFINITY};
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        double t[MOST_RAYS], log_t[MOST_RAYS], t0[MOST_RAYS], log_t0[MOST_RAYS];
        evaluate(&whole, cpu, true, t0, log_t0);
        for (size_t at = 0; at < 24; at++) {
            for (int field = 0; field < 7; field++) {
                for (int kind = 0; kind < (field == 6 ? 1 : 3); kind++) {
                    batch b = whole;
                    double *value = field < 3   ? &b.origin[field][at]
                                    : field < 6 ? &b.dir[field - 3][at]
                                                : &b.t_max[at];
                    *value = bad[kind];
                    evaluate(&b, cpu, true, t, log_t);
                    assert_true(t[at] == 0.0 && log_t[at] == -INFINITY);
                    t[at] = t0[at];
                    log_t[at] = log_t0[at];
                    assert_memory_equal(t, t0, 24 * sizeof *t);
                    assert_memory_equal(log_t, log_t0, 24 * sizeof *t);
                }
            }
        }
    }
}

static void log_t_is_right_where_t_underflows(void **state)
{
    (void)state;
    const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};
    batch b = {.medium = box_between(low, high), .to_light = {0.0, 0.0, 1.0}, .sigma_t = 2000.0};
    for (int i = 0; i < 9; i++) {
        const double from[3] = {0.1 * i, 0.0, -0.5}, dir[3] = {0.0, 0.0, -1.0};
        add_ray(&b, from, dir, INFINITY);
    }
    /* Looking away from the light at depth d = 1.5: exp(-sigma d)(1 - exp(-2 sigma b))/(2 sigma).
     */
    const double expected = -2000.0 * 1.5 - log(4000.0);
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        double t[MOST_RAYS], log_t[MOST_RAYS];
        evaluate(&b, cpu, true, t, log_t);
        for (int i = 0; i < 9; i++) {
            assert_true(t[i] == 0.0);
            assert_true(fabs(log_t[i] - expected) <= 4.0 * DBL_EPSILON * -expected);
        }
    }
}

static void counts_that_fill_no_group_give_the_same_bytes(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 6);
    for (size_t planes = 6; planes <= 20; planes += 14) {
        batch b = random_batch(&rng, planes, 40);
        for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
            double t[MOST_RAYS], log_t[MOST_RAYS], t0[MOST_RAYS], log_t0[MOST_RAYS];
            b.count = 40;
            evaluate(&b, cpu, true, t0, log_t0);
            for (b.count = 0; b.count < 40; b.count++) {
                memset(t, 0x55, sizeof t);
                memset(log_t, 0x55, sizeof log_t);
                double untouched = t[0];
                evaluate(&b, cpu, true, t, log_t);
                assert_memory_equal(t, t0, b.count * sizeof *t);
                assert_memory_equal(log_t, log_t0, b.count * sizeof *t);
                assert_true(t[b.count] == untouched && log_t[b.count] == untouched);
            }
        }
    }
}

static void no_t_max_is_infinity_and_log_t_may_be_left_out(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 7);
    batch b = random_batch(&rng, 6, 21);
    for (size_t i = 0; i < b.count; i++) {
        b.t_max[i] = INFINITY;
    }
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        double t[MOST_RAYS], log_t[MOST_RAYS], t0[MOST_RAYS], log_t0[MOST_RAYS];
        evaluate(&b, cpu, true, t0, log_t0);
        evaluate(&b, cpu, false, t, log_t);
        assert_memory_equal(t, t0, b.count * sizeof *t);
        assert_memory_equal(log_t, log_t0, b.count * sizeof *t);
        memset(t, 0, sizeof t);
        evaluate(&b, cpu, false, t, NULL);
        assert_memory_equal(t, t0, b.count * sizeof *t);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_agree),
        cmocka_unit_test(polyhedra_agree),
        cmocka_unit_test(limits_agree),
        cmocka_unit_test(open_and_empty_media_agree),
        cmocka_unit_test(what_is_not_finite_gives_zero_and_leaves_its_neighbours_alone),
        cmocka_unit_test(log_t_is_right_where_t_underflows),
        cmocka_unit_test(counts_that_fill_no_group_give_the_same_bytes),
        cmocka_unit_test(no_t_max_is_infinity_and_log_t_may_be_left_out),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

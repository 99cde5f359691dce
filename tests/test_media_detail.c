/* Procedural detail: the noise against a slow version, its range and moments; media with it. */
#include <float.h>
#include <stdlib.h>

#include "core/cpu.h"
#include "core/random.h"
#include "memory_files.h"
#include "scene/media/field.h"
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

static air_detail plain_detail(float strength, float scale, uint32_t octaves, uint32_t seed)
{
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.density.detail.strength = strength;
    desc.density.detail.scale = scale;
    desc.density.detail.octaves = octaves;
    desc.density.detail.seed = seed;
    return desc.density.detail;
}

static air_detail_field make(uint32_t octaves, uint32_t seed)
{
    const air_detail detail = plain_detail(0.5f, 1.0f, octaves, seed);
    air_detail_field field;
    air_detail_make(&detail, AIR_CPU_C, &field);
    return field;
}

static air_vec3 random_point(air_rng *rng, float half)
{
    const float x = air_rng_float(rng), y = air_rng_float(rng), z = air_rng_float(rng);
    return vec3_scale(vec3(2.0f * x - 1.0f, 2.0f * y - 1.0f, 2.0f * z - 1.0f), half);
}

/* ---- the slow version ---- */

static const double edges[12][3] = {{0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1},
                                    {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
                                    {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}};

static const double *slow_gradient(const int32_t at[3], uint32_t seed)
{
    static const uint32_t factors[3] = {0x9e3779b1u, 0x85ebca77u, 0xc2b2ae3du};
    uint32_t key = seed;
    for (int axis = 0; axis < 3; axis++) {
        key ^= ((uint32_t)at[axis] % 4096u) * factors[axis];
    }
    const uint32_t hash = air_hash32(key), left_out = (hash % 65536u) * 3u / 65536u;
    return edges[4 * left_out + hash / 0x80000000u + 2 * (hash / 0x40000000u % 2)];
}

static double slow_fade(double t) { return t * t * t * (10.0 + t * (6.0 * t - 15.0)); }

static double slow_octave(const double at[3], uint32_t seed)
{
    double sum = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1.0, rest[3], slope = 0.0;
        int32_t lattice[3];
        for (int axis = 0; axis < 3; axis++) {
            const int up = corner >> axis & 1;
            const double share = slow_fade(at[axis] - floor(at[axis]));
            lattice[axis] = (int32_t)floor(at[axis]) + up;
            rest[axis] = at[axis] - (double)lattice[axis];
            weight *= up == 1 ? share : 1.0 - share;
        }
        const double *gradient = slow_gradient(lattice, seed);
        for (int axis = 0; axis < 3; axis++) {
            slope += gradient[axis] * rest[axis];
        }
        sum += weight * slope;
    }
    return sum;
}

static double slow_noise(uint32_t octaves, uint32_t seed, const double point[3])
{
    double sum = 0.0, variance = 0.0;
    for (uint32_t k = 0; k < octaves; k++) {
        const uint32_t key = air_hash_combine(air_hash32(seed), k);
        double at[3];
        for (int axis = 0; axis < 3; axis++) {
            at[axis] = ldexp(point[axis], (int)k) + (double)(key >> (10 * axis) & 1023u) / 1024.0;
        }
        sum += ldexp(slow_octave(at, key), -(int)k);
        variance += 0.27003508 * 0.27003508 * ldexp(1.0, -2 * (int)k);
    }
    sum = fmax(fmin(0.5 * sum / sqrt(variance), 1.0), -1.0);
    return 1.5 * sum - 0.5 * sum * sum * sum;
}

static void noise_is_what_the_slow_version_says(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 7);
    for (uint32_t n = 0; n < 20000; n++) {
        const uint32_t octaves = 1 + n % 8;
        const air_detail_field field = make(octaves, n / 8);
        const air_vec3 p = random_point(&rng, 20.0f);
        const double at[3] = {(double)p.x, (double)p.y, (double)p.z};
        /* Lattice coordinates of 20 * 2^7 are rounded to 2^-13, where slopes of an octave are at
         * most about 3, times its share of 2^-7 and the 1.6 and 1.5 of scale and bend: as in any
         * other octave, 8 of which are 8 * 3 * 2.4 * 20 * 2^-24 = 7e-5. */
        assert_true(fabs(slow_noise(octaves, n / 8, at) -
                         (double)air_detail_noise(&field, p, 0.0f)) < 7e-5);
    }
}

/* ---- moments ---- */

/* Of points far apart, so that they are as good as independent: the standard error of the mean is
 * 0.6 / sqrt(n) = 1.3e-3, of the deviation below 1e-3. */
static void mean_is_0_and_deviation_0_6(void **state)
{
    (void)state;
    enum { POINTS = 200000 };
    for (uint32_t octaves = 1; octaves <= AIR_MAX_OCTAVES; octaves += octaves < 4 ? 1 : 4) {
        const air_detail_field field = make(octaves, octaves);
        air_rng rng = air_rng_from_keys(2, octaves);
        double sum = 0.0, squares = 0.0;
        for (int n = 0; n < POINTS; n++) {
            const double x = (double)air_detail_noise(&field, random_point(&rng, 200.0f), 0.0f);
            assert_true(fabs(x) <= 1.0);
            sum += x;
            squares += x * x;
        }
        const double deviation = sqrt(squares / POINTS);
        assert_true(fabs(sum / POINTS) < 5.0 * 0.6 / sqrt((double)POINTS));
        assert_true(deviation > 0.58 && deviation < 0.62);
    }
}

/* Half of the seeds' patterns are above 0 at a place, and their mean is 0: gradients and their
 * opposites are equally likely, at lattice points' own distances too. */
static void no_place_is_denser_than_others(void **state)
{
    (void)state;
    enum { SEEDS = 20000 };
    static const air_vec3 places[4] = {{0, 0, 0}, {0.5f, 0.5f, 0.5f}, {7, 3.5f, -2}, {0.1f, 9, 9}};
    for (int i = 0; i < 4; i++) {
        double sum = 0.0;
        int above = 0;
        for (uint32_t seed = 0; seed < SEEDS; seed++) {
            const air_detail_field field = make(3, seed);
            const float x = air_detail_noise(&field, places[i], 0.0f);
            sum += (double)x;
            above += x > 0.0f;
        }
        assert_true(fabs(sum / SEEDS) < 5.0 * 0.6 / sqrt((double)SEEDS));
        assert_true(fabs((double)above / SEEDS - 0.5) < 5.0 * 0.5 / sqrt((double)SEEDS));
    }
}

static void factor_keeps_its_range(void **state)
{
    (void)state;
    static const float strengths[3] = {0.1f, 0.7f, 1.0f - FLT_EPSILON};
    air_rng rng = air_rng_from_keys(3, 0);
    for (int i = 0; i < 3; i++) {
        const air_detail detail = plain_detail(strengths[i], 0.3f, 3, 5);
        float least = 1.0f, most = 1.0f;
        air_detail_field field;
        air_detail_make(&detail, AIR_CPU_C, &field);
        for (int n = 0; n < 100000; n++) {
            const float factor = air_detail_factor(&field, random_point(&rng, 30.0f), 0.0f);
            least = fminf(least, factor);
            most = fmaxf(most, factor);
        }
        assert_true(least >= 1.0f - strengths[i] && most <= air_detail_most(&field));
        /* a thirtieth of all places is cut off on either side */
        assert_true(least < 1.0f - 0.999f * strengths[i] && most > 1.0f + 0.999f * strengths[i]);
    }
}

/* ---- shape ---- */

/* Across borders of lattice cells too: no step, and no step in the slope. */
static void noise_is_smooth(void **state)
{
    (void)state;
    const air_detail_field field = make(2, 3);
    air_rng rng = air_rng_from_keys(4, 0);
    for (int n = 0; n < 2000; n++) {
        const float h = 1.0f / 1024.0f;
        const air_vec3 from = random_point(&rng, 8.0f);
        const air_vec3 dir = vec3_normalize(random_point(&rng, 1.0f));
        float before = air_detail_noise(&field, from, 0.0f), slope = 0.0f;
        for (int i = 1; i < 64; i++) {
            const float now = air_detail_noise(&field, vec3_madd(from, (float)i * h, dir), 0.0f);
            const float change = (now - before) / h;
            /* Slopes of two octaves: 2 * 3 * 1.7 * 1.5; second derivatives of the finer one, the
             * bend among them, are below 300 per unit squared; values are rounded to 1e-6. */
            assert_true(fabsf(change) < 16.0f);
            assert_true(i == 1 || fabsf(change - slope) < 300.0f * h + 4e-3f);
            slope = change;
            before = now;
        }
    }
}

static void noise_repeats_after_4096_features(void **state)
{
    (void)state;
    const air_detail_field field = make(4, 9);
    air_rng rng = air_rng_from_keys(5, 0);
    int same = 0;
    for (int n = 0; n < 1000; n++) {
        air_vec3 p = random_point(&rng, 4.0f);
        p = vec3(floorf(p.x * 64.0f) / 64.0f, floorf(p.y * 64.0f) / 64.0f,
                 floorf(p.z * 64.0f) / 64.0f); /* so that sums are exact */
        const float here = air_detail_noise(&field, p, 0.0f);
        const float there = air_detail_noise(&field, vec3_add(p, vec3(4096, -4096, 8192)), 0.0f);
        /* Shifts of 2^-10 are rounded to 2^-8 of a lattice of 8 * 8192 points: an octave changes
         * by 3 * 2^-9 * 2^-3, the sum by less than 4 * 2.6 * 3 * 2^-12. */
        assert_true(fabsf(here - there) < 8e-3f);
        same += fabsf(here - air_detail_noise(&field, vec3_add(p, vec3(64, 0, 0)), 0.0f)) < 8e-3f;
    }
    assert_true(same < 50); /* and not before */
}

static void seeds_and_places_decide_and_nothing_else(void **state)
{
    (void)state;
    const air_detail_field a = make(4, 1), b = make(4, 1), c = make(4, 2);
    air_rng rng = air_rng_from_keys(6, 0);
    double product = 0.0;
    for (int n = 0; n < 20000; n++) {
        const air_vec3 p = random_point(&rng, 100.0f);
        const float x = air_detail_noise(&a, p, 0.0f);
        assert_true(x == air_detail_noise(&b, p, 0.0f));
        product += (double)x * (double)air_detail_noise(&c, p, 0.0f);
    }
    /* independent patterns: 0.36 / sqrt(n), five times */
    assert_true(fabs(product / 20000) < 5.0 * 0.36 / sqrt(20000.0));
}

/* Detail belongs to the space that it is said in. */
static void noise_moves_with_its_space(void **state)
{
    (void)state;
    static const float map[12] = {0, -2, 0, 3, 2, 0, 0, -1, 0, 0, 2, 0.5f};
    air_detail detail = plain_detail(0.5f, 0.25f, 3, 4);
    air_detail_field here, there;
    air_rng rng = air_rng_from_keys(7, 0);
    air_detail_make(&detail, AIR_CPU_C, &here);
    memcpy(detail.to_world, map, sizeof map);
    air_detail_make(&detail, AIR_CPU_C, &there);
    assert_float_equal(here.feature_m, 0.25f, 1e-7f);
    assert_float_equal(there.feature_m, 0.5f, 1e-7f);
    assert_float_equal(air_detail_finest(&there), 0.125f, 1e-7f);
    for (int n = 0; n < 1000; n++) {
        const air_vec3 p = random_point(&rng, 2.0f);
        /* coordinates up to 7 rounded, times slopes of up to 16 / 0.25 */
        assert_float_equal(air_detail_noise(&here, p, 0.0f),
                           air_detail_noise(&there, affine_point(map, p), 0.0f), 1e-4f);
    }
}

static void wide_looks_see_no_fine_octaves(void **state)
{
    (void)state;
    const air_detail_field all = make(3, 8);
    air_detail_field two = all;
    air_rng rng = air_rng_from_keys(8, 0);
    two.octaves = 2;
    for (int n = 0; n < 1000; n++) {
        const air_vec3 p = random_point(&rng, 10.0f);
        const float whole = air_detail_noise(&all, p, 0.0f), less = air_detail_noise(&two, p, 0.0f);
        assert_true(air_detail_noise(&all, p, 0.25f) == whole); /* the finest's spacing */
        assert_true(air_detail_noise(&all, p, 0.5f) == less);
        assert_true(air_detail_noise(&all, p, 2.0f) == 0.0f);
        assert_true(air_detail_noise(&all, p, INFINITY) == 0.0f);
        const float between = air_detail_noise(&all, p, 0.375f);
        assert_true((between - whole) * (between - less) <= 1e-6f);
    }
}

/* Of every instruction set that the machine has, to the bit. */
static void many_points_are_as_one(void **state)
{
    (void)state;
    enum { COUNT = 150 };
    const air_detail detail = plain_detail(0.9f, 0.7f, 5, 11);
    air_rng rng = air_rng_from_keys(12, 0);
    for (int cpu = AIR_CPU_C; cpu <= (int)air_cpu_detect(); cpu++) {
        air_detail_field field;
        air_detail_make(&detail, (air_cpu)cpu, &field);
        for (int n = 0; n < 200; n++) {
            const float width = n % 2 == 0 ? 0.0f : air_rng_float(&rng);
            const size_t count = (size_t)(n % COUNT) + 1;
            air_vec3 points[COUNT];
            float factors[COUNT];
            for (size_t i = 0; i < count; i++) {
                points[i] = random_point(&rng, n % 5 == 0 && i % 7 == 0 ? 1e6f : 30.0f);
            }
            air_detail_factors(&field, points, count, width, factors);
            for (size_t i = 0; i < count; i++) {
                assert_true(factors[i] == air_detail_factor(&field, points[i], width));
            }
        }
    }
}

/* No place that floats can say, or cannot, gives anything but a number. */
static void far_places_are_harmless(void **state)
{
    (void)state;
    static const float far[6] = {1e6f, 1e9f, 1e38f, INFINITY, -INFINITY, NAN};
    const air_detail_field field = make(AIR_MAX_OCTAVES, 0);
    for (int i = 0; i < 6; i++) {
        assert_true(fabsf(air_detail_noise(&field, vec3(far[i], 0.5f, 0.5f), 0.0f)) <= 1.0f);
    }
    assert_true(air_detail_noise(&field, vec3(INFINITY, 0, 0), 0.0f) == 0.0f);
}

/* ---- media ---- */

static air_medium_desc haze(void)
{
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.name = "haze";
    desc.boundary.kind = AIR_BOUNDARY_BOX;
    desc.density.detail = plain_detail(0.8f, 0.5f, 3, 1);
    for (int c = 0; c < 3; c++) {
        desc.sigma_s[c] = 1.0f + (float)c;
        desc.sigma_a[c] = 0.5f;
        desc.emission[c] = 0.25f;
    }
    return desc;
}

static void all_coefficients_have_the_factor(void **state)
{
    memory_file *files = *state;
    air_medium_desc desc = haze();
    const air_medium_source source = {&desc, NULL, NULL, NULL};
    air_rng rng = air_rng_from_keys(9, 0);
    air_media media;
    desc.density.kind = AIR_DENSITY_LAYERED;
    desc.density.layer_count = 1;
    desc.density.layer_bottom[0] = -INFINITY;
    desc.density.layer_density[0] = 2.0f;
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_OK);
    assert_false(media.all_constant || media.regions[0].constant);
    for (int n = 0; n < 1000; n++) {
        const air_vec3 p = random_point(&rng, 1.0f);
        const float factor = air_detail_factor(&media.media[0].detail, p, 0.0f);
        const air_coefficients c = air_medium_coefficients(&media.media[0], &media.regions[0], p);
        assert_float_equal(c.sigma_s.y, 4.0f * factor, 1e-5f);
        assert_float_equal(c.sigma_t.x, 3.0f * factor, 1e-5f);
        assert_float_equal(c.emission.z, 0.5f * factor, 1e-5f);
        air_vec3 points[AIR_LOOKS];
        air_coefficients run[AIR_LOOKS];
        for (int i = 0; i < AIR_LOOKS; i++) {
            points[i] = i == n % AIR_LOOKS ? p : random_point(&rng, 1.0f);
        }
        air_medium_coefficients_run(&media.media[0], &media.regions[0], points, AIR_LOOKS, 0.0f,
                                    run);
        assert_memory_equal(&run[n % AIR_LOOKS], &c, sizeof c);
    }
    air_media_finish(files->context, &media);
    desc.density.detail.strength = 0.0f;
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_OK);
    assert_true(media.all_constant && media.regions[0].constant);
    air_media_finish(files->context, &media);
}

typedef struct fault {
    float strength, scale;
    uint32_t octaves;
    const char *message;
} fault;

static void bad_detail_is_refused(void **state)
{
    static const fault faults[] = {
        {-0.1f, 1, 4, "strength is -0.1, but must be at least 0 and below 1"},
        {1, 1, 4, "strength is 1, but must be at least 0 and below 1"},
        {NAN, 1, 4, "but must be at least 0 and below 1"},
        {INFINITY, 1, 4, "strength is inf, but must be at least 0 and below 1"},
        {0.5f, 0, 4, "scale is 0, but must be finite and above 0"},
        {0.5f, -1, 4, "scale is -1, but must be finite and above 0"},
        {0.5f, NAN, 4, "but must be finite and above 0"},
        {0.5f, INFINITY, 4, "scale is inf, but must be finite and above 0"},
        {0.5f, 1e-40f, 4, "but must be finite and above 0"},
        {0.5f, 1, 0, "octaves is 0, but must be 1 to 12"},
        {0.5f, 1, 13, "octaves is 13, but must be 1 to 12"},
    };
    memory_file *files = *state;
    air_medium_desc desc = haze();
    assert_int_equal(air_medium_check(files->context, &desc), AIR_OK);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        desc.density.detail =
            plain_detail(faults[i].strength, faults[i].scale, faults[i].octaves, 0);
        assert_int_equal(air_medium_check(files->context, &desc), AIR_ERROR_ARGUMENT);
        assert_non_null(
            strstr(air_context_last_error(files->context), "medium \"haze\": density.detail."));
        assert_non_null(strstr(air_context_last_error(files->context), faults[i].message));
    }
    desc.density.detail = plain_detail(0.5f, 1.0f, 4, 0);
    desc.density.detail.to_world[0] = 0.0f;
    assert_int_equal(air_medium_check(files->context, &desc), AIR_ERROR_ARGUMENT);
    assert_non_null(
        strstr(air_context_last_error(files->context), "density.detail.to_world is singular"));
    desc.density.detail.strength = 0.0f; /* then nothing else is looked at */
    assert_int_equal(air_medium_check(files->context, &desc), AIR_OK);
}

static void endless_media_have_no_detail(void **state)
{
    static const float slab[8] = {0, 1, 0, 1, 0, -1, 0, 1};
    memory_file *files = *state;
    air_medium_desc desc = haze();
    for (int i = 0; i < 2; i++) {
        desc.boundary.kind = i == 0 ? AIR_BOUNDARY_UNBOUNDED : AIR_BOUNDARY_CONVEX;
        desc.boundary.planes = slab;
        desc.boundary.plane_count = 2;
        assert_int_equal(air_medium_check(files->context, &desc), AIR_ERROR_ARGUMENT);
        assert_string_equal(air_context_last_error(files->context),
                            "medium \"haze\": density.detail: the medium has no end, expected a "
                            "boundary that ends everywhere, or a grid");
    }
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid = 1;
    assert_int_equal(air_medium_check(files->context, &desc), AIR_OK);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(noise_is_what_the_slow_version_says),
        TEST(mean_is_0_and_deviation_0_6),
        TEST(no_place_is_denser_than_others),
        TEST(factor_keeps_its_range),
        TEST(noise_is_smooth),
        TEST(noise_repeats_after_4096_features),
        TEST(seeds_and_places_decide_and_nothing_else),
        TEST(noise_moves_with_its_space),
        TEST(wide_looks_see_no_fine_octaves),
        TEST(many_points_are_as_one),
        TEST(far_places_are_harmless),
        TEST(all_coefficients_have_the_factor),
        TEST(bad_detail_is_refused),
        TEST(endless_media_have_no_detail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

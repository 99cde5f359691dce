/* Sample patterns: uniform, stratified, systematic, blue. */
#include "core/pattern.h"

#include <math.h>
#include <string.h>

#include "chi_square.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/vec.h"

enum { SIDE = AIR_TILE_SIDE, PIXELS = AIR_TILE_PIXELS, MOST = 4096, PATTERNS = 4 };

static air_blue_noise tile;

static int set_up(void **state)
{
    (void)state;
    air_blue_noise_init(&tile);
    return 0;
}

static air_pattern_source source_of(int pattern, uint32_t log2_count, uint32_t seed)
{
    return (air_pattern_source){(air_pattern)pattern, &tile, log2_count, seed};
}

/* ---- each number by itself ---- */

/* The p-value of one sample index over pixels, or over seeds at one pixel; 64 bins. There are 80 of
 * them: one of 1,250 such runs has one below 1e-5. */
static double uniformity(const air_pattern_source *source, uint32_t index, bool over_seeds)
{
    enum { BINS = 64, COUNT = 64 * 1024 };
    double observed[BINS] = {0.0}, expected[BINS];
    air_pattern_source s = *source;
    for (uint32_t i = 0; i < COUNT; i++) {
        s.seed = over_seeds ? i : source->seed;
        const double u =
            air_pattern_get(&s, over_seeds ? 5 : i % 256, over_seeds ? 9 : i / 256, index);
        assert_true(u >= 0.0 && u < 1.0);
        observed[(int)(u * BINS)] += 1.0;
    }
    for (int i = 0; i < BINS; i++) {
        expected[i] = (double)COUNT / BINS;
    }
    return chi_square_p(observed, expected, BINS, NULL);
}

static void every_number_is_uniform(void **state)
{
    (void)state;
    static const uint32_t indices[] = {0, 1, 2, 7, 1000};
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        for (uint32_t m = 0; m <= 4; m += 4) {
            const air_pattern_source source = source_of(pattern, m, 3);
            for (int i = 0; i < 5; i++) {
                assert_true(uniformity(&source, indices[i], false) > 1e-5);
                assert_true(uniformity(&source, indices[i], true) > 1e-5);
            }
        }
    }
}

/* Pairs of successive numbers of a pixel, in 16 x 16 bins. */
static void independent_numbers_do_not_know_each_other(void **state)
{
    (void)state;
    enum { BINS = 256, COUNT = 1 << 17 };
    double observed[BINS] = {0.0}, expected[BINS];
    const air_pattern_source source = source_of(AIR_PATTERN_INDEPENDENT, 0, 1);
    for (uint32_t i = 0; i < COUNT; i++) {
        const double u = air_pattern_get(&source, i / 16 % 128, i / 2048, 2 * (i % 16));
        const double v = air_pattern_get(&source, i / 16 % 128, i / 2048, 2 * (i % 16) + 1);
        observed[16 * (int)(16.0 * u) + (int)(16.0 * v)] += 1.0;
    }
    for (int i = 0; i < BINS; i++) {
        expected[i] = (double)COUNT / BINS;
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-5);
}

/* ---- a pixel's numbers together ---- */

static void every_aligned_run_of_a_power_of_two_is_stratified(void **state)
{
    (void)state;
    for (int pattern = AIR_PATTERN_STRATIFIED; pattern < PATTERNS; pattern++) {
        for (uint32_t pixel = 0; pixel < 40; pixel++) {
            const air_pattern_source source = source_of(pattern, pixel % 5, pixel);
            for (uint32_t n = 1; n <= MOST; n *= 2) {
                for (uint32_t run = 0; run < 3; run++) {
                    bool taken[MOST] = {false};
                    for (uint32_t i = 0; i < n; i++) {
                        const double u = air_pattern_get(&source, pixel, 7 * pixel, run * n + i);
                        const uint32_t stratum = (uint32_t)(u * n);
                        assert_false(taken[stratum]);
                        taken[stratum] = true;
                    }
                }
            }
        }
    }
}

/* Within a stratum stratified numbers are uniform and do not know those of other strata: the place
 * of the numbers of strata 0 and 1, in 8 x 8 bins. */
static void places_in_two_strata_are_independent(void **state)
{
    (void)state;
    enum { BINS = 64, COUNT = 1 << 15, N = 16 };
    double observed[BINS] = {0.0}, expected[BINS];
    const air_pattern_source source = source_of(AIR_PATTERN_STRATIFIED, 0, 2);
    for (uint32_t i = 0; i < COUNT; i++) {
        double place[N];
        for (uint32_t k = 0; k < N; k++) {
            const double u = N * air_pattern_get(&source, i % 256, i / 256, k);
            place[(int)u] = u - floor(u);
        }
        observed[8 * (int)(8.0 * place[0]) + (int)(8.0 * place[1])] += 1.0;
    }
    for (int i = 0; i < BINS; i++) {
        expected[i] = (double)COUNT / BINS;
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-5);
}

/* Exact: all numbers are multiples of 2^-32. */
static void systematic_samples_are_equally_spaced(void **state)
{
    (void)state;
    for (int pattern = AIR_PATTERN_SYSTEMATIC; pattern < PATTERNS; pattern++) {
        for (uint32_t pixel = 0; pixel < 100; pixel++) {
            const air_pattern_source source = source_of(pattern, 3, pixel);
            for (uint32_t n = 1; n <= MOST; n *= 4) {
                const double first = n * air_pattern_get(&source, pixel, 3, 0);
                const double place = first - floor(first);
                for (uint32_t i = 1; i < n; i++) {
                    const double u = n * air_pattern_get(&source, pixel, 3, i);
                    assert_true(u - floor(u) == place);
                }
            }
        }
    }
}

static void the_tile_sets_the_offset_at_its_number_of_samples(void **state)
{
    (void)state;
    for (uint32_t m = 0; m <= 20; m += 4) {
        const air_pattern_source source = source_of(AIR_PATTERN_BLUE_NOISE, m, 8);
        bool taken[PIXELS] = {false};
        for (uint32_t i = 0; i < PIXELS; i++) {
            const double u =
                ldexp(air_pattern_get(&source, 64 + i % SIDE, 128 + i / SIDE, 0), (int)m);
            const int rank = (int)(PIXELS * (u - floor(u)));
            assert_false(taken[rank]);
            taken[rank] = true;
        }
    }
}

/* ---- the tile ---- */

static void the_tile_holds_each_rank_once(void **state)
{
    (void)state;
    bool taken[PIXELS] = {false};
    for (int i = 0; i < PIXELS; i++) {
        assert_in_range(tile.rank[i], 0, PIXELS - 1);
        assert_false(taken[tile.rank[i]]);
        taken[tile.rank[i]] = true;
    }
}

static void the_tile_is_always_the_same(void **state)
{
    (void)state;
    uint32_t hash = 0;
    air_blue_noise again;
    air_blue_noise_init(&again);
    assert_memory_equal(&again, &tile, sizeof tile);
    for (int i = 0; i < PIXELS; i++) {
        hash = air_hash_combine(hash, tile.rank[i]);
    }
    assert_int_equal(hash, 0x26d0f785); /* of the tile that every machine makes */
}

/* The mean power of f at frequencies of length in (0, radius] cycles per tile, in units of the
 * power of white noise of the same variance. */
static double low_power(const double f[PIXELS], double radius)
{
    double mean = 0.0, variance = 0.0, power = 0.0;
    int count = 0;
    const int most = (int)radius;
    for (int i = 0; i < PIXELS; i++) {
        mean += f[i] / PIXELS;
    }
    for (int i = 0; i < PIXELS; i++) {
        variance += (f[i] - mean) * (f[i] - mean) / PIXELS;
    }
    for (int ky = -most; ky <= most; ky++) {
        for (int kx = -most; kx <= most; kx++) {
            const double length = sqrt((double)(kx * kx + ky * ky));
            if (length == 0.0 || length > radius) {
                continue;
            }
            double re = 0.0, im = 0.0;
            for (int i = 0; i < PIXELS; i++) {
                const double phase = 2.0 * AIR_PI * (kx * (i % SIDE) + ky * (i / SIDE)) / SIDE;
                re += (f[i] - mean) * cos(phase);
                im += (f[i] - mean) * sin(phase);
            }
            power += (re * re + im * im) / (PIXELS * variance);
            count++;
        }
    }
    return power / count;
}

/* Below 8 cycles per tile, an eighth of the sampling frequency; white noise has 1 +- 0.1 there
 * (196 frequencies, half of them independent, exponentially distributed: 1/sqrt(98) is 0.1).
 * Measured: 0.0004. */
static void the_tile_is_blue(void **state)
{
    (void)state;
    static double f[PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        f[i] = tile.rank[i];
    }
    const double blue = low_power(f, 8.0);
    for (uint32_t i = 0; i < PIXELS; i++) {
        f[i] = air_hash32(i);
    }
    const double white = low_power(f, 8.0);
    print_message("low frequencies: tile %.4f, white noise %.4f\n", blue, white);
    assert_true(white > 0.7 && white < 1.3);
    assert_true(blue < 0.002);
}

/* So are all its thresholds, here at 1/16, 1/4, 1/2 and 7/8: points of one density are spread
 * evenly. Measured: 0.06, 0.02, 0.02, 0.05. */
static void pictures_of_any_threshold_are_blue(void **state)
{
    (void)state;
    static const int thresholds[] = {PIXELS / 16, PIXELS / 4, PIXELS / 2, PIXELS - PIXELS / 8};
    static double f[PIXELS];
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < PIXELS; i++) {
            f[i] = tile.rank[i] < thresholds[k];
        }
        const double blue = low_power(f, 6.0);
        print_message("below rank %d: %.4f\n", thresholds[k], blue);
        assert_true(blue < 0.1);
    }
}

/* What it is for: the error of 4 samples of a smooth function has little left at low frequencies.
 * Measured: 0.0004. */
static void errors_of_a_picture_are_blue(void **state)
{
    (void)state;
    static double f[PIXELS];
    for (uint32_t seed = 0; seed < 2; seed++) {
        const air_pattern_source source = source_of(AIR_PATTERN_BLUE_NOISE, 2, seed);
        for (uint32_t i = 0; i < PIXELS; i++) {
            f[i] = 0.0;
            for (uint32_t k = 0; k < 4; k++) {
                f[i] += exp(-2.0 * air_pattern_get(&source, i % SIDE, i / SIDE, k));
            }
        }
        const double blue = low_power(f, 8.0);
        print_message("error of 4 samples: %.4f\n", blue);
        assert_true(blue < 0.002);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_number_is_uniform),
        cmocka_unit_test(independent_numbers_do_not_know_each_other),
        cmocka_unit_test(every_aligned_run_of_a_power_of_two_is_stratified),
        cmocka_unit_test(places_in_two_strata_are_independent),
        cmocka_unit_test(systematic_samples_are_equally_spaced),
        cmocka_unit_test(the_tile_sets_the_offset_at_its_number_of_samples),
        cmocka_unit_test(the_tile_holds_each_rank_once),
        cmocka_unit_test(the_tile_is_always_the_same),
        cmocka_unit_test(the_tile_is_blue),
        cmocka_unit_test(pictures_of_any_threshold_are_blue),
        cmocka_unit_test(errors_of_a_picture_are_blue),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}

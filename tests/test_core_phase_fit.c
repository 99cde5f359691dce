/* Tables of phase functions as sums of lobes: what comes back, how near, and what is refused. */
#include <math.h>
#include <string.h>

#include "airlight/phase_fit.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/vec.h"

enum { COUNT = 801 };

/* Cosines dense towards both ends: equal steps in an angle whose cosine is stretched again. */
static void make_cosines(double out[COUNT])
{
    for (int i = 0; i < COUNT; ++i) {
        out[i] = sin(0.5 * AIR_PI * sin(0.5 * AIR_PI * (2.0 * i / (COUNT - 1) - 1.0)));
    }
    out[0] = -1.0;
    out[COUNT - 1] = 1.0;
}

static double hg(double g, double c)
{
    return (1.0 - g * g) / (4.0 * AIR_PI * pow(1.0 + g * g - 2.0 * g * c, 1.5));
}

static double sum_of_weights(const air_phase_mixture *mixture)
{
    double sum = 0.0;
    for (size_t i = 0; i < mixture->lobe_count; ++i) {
        sum += (double)mixture->lobes[i].weight;
    }
    return sum;
}

/* The fit's value over the table's less 1, largest over the table. */
static double largest_relative_error(const air_phase_mixture *mixture, const double *cosines,
                                     const double *values)
{
    const air_phase phase = {.kind = AIR_PHASE_MIXTURE, .mixture = mixture};
    double largest = 0.0;
    for (int i = 0; i < COUNT; ++i) {
        const double got = (double)air_phase_eval(phase, (float)cosines[i]);
        largest = fmax(largest, fabs(got / values[i] - 1.0));
    }
    return largest;
}

/* As of haze: a forward lobe, and a weak backward one. The g are none of the set's. In x = -ln(1 -
 * |g|) the set's lobes stand h = -ln 0.86 apart; a lobe's second derivative there is at most 4
 * times its value (in the peak), so the line between two neighbours is off by at most 4 h^2 / 8
 * = 1.14 % of it, and the best fit by no more in the mean. The table's own chords add less than
 * 1e-3. What is small pointwise, where the other lobe has most of the light, may be off by some
 * times that. */
static void double_lobes_come_back(void **state)
{
    static const double pairs[][3] = {
        {0.85, -0.4, 0.9}, {0.9, -0.25, 0.97}, {0.6, 0.1, 0.5}, {0.97, 0.5, 0.7}, {-0.8, 0.7, 0.3}};
    double cosines[COUNT], values[COUNT], error;
    (void)state;
    make_cosines(cosines);
    for (size_t n = 0; n < sizeof pairs / sizeof *pairs; ++n) {
        air_phase_mixture mixture;
        const double *p = pairs[n];
        for (int i = 0; i < COUNT; ++i) {
            values[i] = p[2] * hg(p[0], cosines[i]) + (1.0 - p[2]) * hg(p[1], cosines[i]);
        }
        assert_int_equal(air_phase_fit(NULL, cosines, values, COUNT, &mixture, &error), AIR_OK);
        assert_true(error < 0.0124);
        assert_true(fabs(sum_of_weights(&mixture) - 1.0) < 1e-6);
        assert_true(largest_relative_error(&mixture, cosines, values) < 0.05);
    }
}

static void lobes_of_the_set_come_back_alone(void **state)
{
    double cosines[COUNT], values[COUNT], error;
    air_phase_mixture mixture;
    (void)state;
    make_cosines(cosines);
    for (int i = 0; i < COUNT; ++i) {
        values[i] = 7.0 * (1.0 + cosines[i] * cosines[i]);
    }
    assert_int_equal(air_phase_fit(NULL, cosines, values, COUNT, &mixture, &error), AIR_OK);
    assert_int_equal(mixture.lobe_count, 1);
    assert_int_equal(mixture.lobes[0].kind, AIR_PHASE_RAYLEIGH);
    assert_true(mixture.lobes[0].weight == 1.0f && error < 1e-4);
    const double ends[2] = {-1.0, 1.0}, equal[2] = {3e-300, 3e-300};
    assert_int_equal(air_phase_fit(NULL, ends, equal, 2, &mixture, &error), AIR_OK);
    assert_int_equal(mixture.lobe_count, 1);
    assert_int_equal(mixture.lobes[0].kind, AIR_PHASE_ISOTROPIC);
    assert_true(error < 1e-6);
}

/* Twelve lobes, all over: eight stand for them. In x (as above) g = 0.97 to 0 is 3.5 wide; four or
 * five lobes for it stand 0.8 apart, 5 h, whose line would be off by 32 % of a single lobe between
 * two. Twelve side by side are smooth in x, so errors of both signs cancel: 1.1 % were measured,
 * and three times that is the limit. */
static void many_lobes_become_eight(void **state)
{
    static const double g[] = {0.97, 0.93, 0.85,  0.7,   0.5,  0.2,
                               0.0,  -0.3, -0.55, -0.75, -0.9, -0.96};
    double cosines[COUNT], values[COUNT] = {0.0}, error;
    air_phase_mixture mixture, again;
    (void)state;
    make_cosines(cosines);
    for (int i = 0; i < COUNT; ++i) {
        for (size_t k = 0; k < sizeof g / sizeof *g; ++k) {
            values[i] += hg(g[k], cosines[i]);
        }
    }
    assert_int_equal(air_phase_fit(NULL, cosines, values, COUNT, &mixture, &error), AIR_OK);
    assert_int_equal(mixture.lobe_count, AIR_PHASE_MAX_LOBES);
    assert_true(error < 0.03);
    for (size_t i = 1; i < mixture.lobe_count; ++i) {
        assert_true(mixture.lobes[i].weight <= mixture.lobes[i - 1].weight);
    }
    assert_int_equal(air_phase_fit(NULL, cosines, values, COUNT, &again, NULL), AIR_OK);
    assert_memory_equal(mixture.lobes, again.lobes, sizeof mixture.lobes);
}

/* Whatever the values, weights are positive and sum to 1. */
static void any_table_gives_a_phase_function(void **state)
{
    air_rng rng = air_rng_from_keys(3, 8);
    (void)state;
    for (int n = 0; n < 200; ++n) {
        double cosines[16], values[16], error;
        air_phase_mixture mixture;
        const size_t count = 2 + (size_t)n % 15;
        for (size_t i = 0; i < count; ++i) {
            const double u = (double)air_rng_float(&rng);
            cosines[i] = 2.0 * (double)i / (double)(count - 1) - 1.0;
            values[i] = u < 0.3 ? 0.0 : exp(20.0 * u - 10.0);
        }
        values[n % 2 == 0 ? 0 : count - 1] = exp(10.0 * (n % 5));
        assert_int_equal(air_phase_fit(NULL, cosines, values, count, &mixture, &error), AIR_OK);
        assert_true(mixture.lobe_count >= 1 && mixture.lobe_count <= AIR_PHASE_MAX_LOBES);
        assert_true(fabs(sum_of_weights(&mixture) - 1.0) < 1e-6);
        assert_true(isfinite(error) && error >= 0.0);
        for (size_t i = 0; i < mixture.lobe_count; ++i) {
            assert_true(mixture.lobes[i].weight > 0.0f && fabsf(mixture.lobes[i].g) <= 0.981f);
        }
    }
}

static void tables_out_of_order_are_refused(void **state)
{
    static const double cosines[5][3] = {
        {-1, 0, 0.9}, {-0.9, 0, 1}, {-1, -1, 1}, {-1, NAN, 1}, {-1, 0, 1}};
    static const double values[5][3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, NAN}};
    static const double zero[3] = {0, 0, 0};
    air_phase_mixture mixture = {.lobe_count = 77};
    (void)state;
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(air_phase_fit(NULL, cosines[i], values[i], 3, &mixture, NULL),
                         AIR_ERROR_ARGUMENT);
    }
    assert_int_equal(air_phase_fit(NULL, cosines[4], zero, 3, &mixture, NULL), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_phase_fit(NULL, cosines[4], values[0], 1, &mixture, NULL),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(mixture.lobe_count, 77);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(double_lobes_come_back),
        cmocka_unit_test(lobes_of_the_set_come_back_alone),
        cmocka_unit_test(many_lobes_become_eight),
        cmocka_unit_test(any_table_gives_a_phase_function),
        cmocka_unit_test(tables_out_of_order_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

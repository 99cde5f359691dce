/* Two and more events: the kernels against fluences, reciprocity and the quadratures of one event.
 */
#include <math.h>
#include <stdlib.h>

#include "cmocka_test.h"
#include "core/vec.h"
#include "failing_allocator.h"
#include "impulse/multiple.h"

enum { ORDER = AIR_IMPULSE_ORDER };

static impulse_curves curves;
static impulse_half_space half;

static int set_up(void **state)
{
    double *const matrix = malloc(sizeof *matrix * HALF_COUNT * HALF_COUNT);
    (void)state;
    if (matrix == NULL) {
        return 1;
    }
    impulse_curves_fluences(IMPULSE_K, &curves);
    for (int i = 0; i < CURVE_POINTS; i++) {
        impulse_curves_ratios(&curves, i);
    }
    impulse_half_space_solve(IMPULSE_K, &half, matrix);
    free(matrix);
    return 0;
}

static double vector_error(const double *found, const double *expected, double scale)
{
    double error = 0.0, square = 0.0;
    for (int l = 0; l < ORDER; l++) {
        const double e = scale * expected[l];
        error += (found[l] - e) * (found[l] - e);
        square += e * e;
    }
    return sqrt(error / square);
}

/* The fluence is sqrt(4 pi) c_0: by the line integral of order k - 1, and by the contour. Curves
 * between their knots are good to 1e-6 (test_impulse_fluence). */
static void band_0_is_the_fluence(void **state)
{
    const impulse_quality fine = impulse_quality_fine();
    static const double distances[4] = {0.01, 0.3, 2.0, 15.0};
    double c[(IMPULSE_K + 1) * ORDER];
    (void)state;
    for (int i = 0; i < 4; i++) {
        const double d = distances[i];
        impulse_point_multiple(&fine, &curves, d, 1, IMPULSE_K, ORDER, c, ORDER);
        for (int k = 1; k <= IMPULSE_K; k++) {
            const double fluence = sqrt(4.0 * AIR_PI) * c[k * ORDER] * exp(-d);
            assert_true(fabs(fluence / air_impulse_point_fluence(k, d) - 1.0) < 1e-6);
        }
    }
}

/* All bands of one event, by integrals over two distances and over two angles. */
static void one_event_is_that_of_the_other_quadratures(void **state)
{
    const impulse_quality fine = impulse_quality_fine();
    static const double distances[4] = {0.01, 0.3, 2.0, 15.0};
    double c[2 * ORDER], exact[ORDER];
    (void)state;
    for (int i = 0; i < 4; i++) {
        const double d = distances[i];
        impulse_point_multiple(&fine, &curves, d, 1, 1, ORDER, c, ORDER);
        air_impulse_point(d, 0.0, ORDER, exact);
        assert_true(vector_error(c + ORDER, exact, exp(d)) < 1e-7);
        impulse_directional_multiple(&half, d, 1, 1, ORDER, c, ORDER);
        air_impulse_directional(d, 0.0, ORDER, exact);
        /* the boundary layer's last panel */
        assert_true(vector_error(c + ORDER, exact, exp(d)) < 1e-5);
    }
}

/* What a patch sends to a point is what a point light there sends to the patch. */
static void a_patch_obeys_reciprocity(void **state)
{
    const impulse_quality fine = impulse_quality_fine();
    static const double angles[3] = {0.2, 1.3, 2.6};
    double area[(IMPULSE_K + 1) * 3 * MULTIPLE_COUNT], point[(IMPULSE_K + 1) * ORDER];
    double lobe[ORDER];
    (void)state;
    air_zh_clamped_cosine(ORDER, lobe);
    for (double d = 0.05; d < 12.0; d *= 5.0) {
        impulse_area_multiple(&fine, &curves, d, IMPULSE_K, angles, 3, area, MULTIPLE_COUNT);
        impulse_point_multiple(&fine, &curves, d, 2, IMPULSE_K, ORDER, point, ORDER);
        for (int i = 0; i < 3 * (IMPULSE_K - 1); i++) {
            const int k = 2 + i / 3;
            const double fluence = sqrt(4.0 * AIR_PI) * area[(k * 3 + i % 3) * MULTIPLE_COUNT];
            const double irradiance =
                air_zh_product(ORDER, lobe, point + k * ORDER, cos(angles[i % 3]));
            /* the ratios' curves have the tables' quality, 1e-5 */
            assert_true(fabs(fluence / irradiance - 1.0) < 2e-5);
        }
    }
}

/* Half the light that enters a half space through order k comes out again or goes on, and all of
 * it in the end: the sum over k of what is scattered, the integral of the fluence, is the sum over
 * orders of shares that were not lost. For order 1: the integral of Phi_0 is 1, that of Phi_1 is 1
 * less what left, by E_2: the integral of exp(-t) E_2(t)/2, t from 0, is (1 - ln 2)/2. */
static void the_half_space_loses_what_leaves_it(void **state)
{
    const graded_rule rule = graded_rule_make(HALF_NODES);
    double sums[2] = {0.0};
    (void)state;
    for (int i = 0; i < HALF_COUNT; i++) {
        const int panel = i / HALF_NODES;
        const double width = half.edges[panel + 1] - half.edges[panel];
        for (int k = 0; k < 2; k++) {
            sums[k] += width * rule.w[i % HALF_NODES] * half.fluence[k][i];
        }
    }
    assert_true(fabs(sums[0] - 1.0) < 1e-12);
    assert_true(fabs(sums[1] - (1.0 - 0.5 * (1.0 - log(2.0)))) < 1e-6);
}

static void fluences_of_other_emitters_are_these(void **state)
{
    failing_allocator allocator;
    air_context_params params = failing_params(&allocator, 1000);
    air_context *context;
    double out[4], point[2 * ORDER];
    (void)state;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_int_equal(air_impulse_directional_fluences(context, 3, 1.5, out), AIR_OK);
    impulse_directional_multiple(&half, 1.5, 1, 1, ORDER, point, ORDER);
    assert_true(fabs(out[1] - exp(-1.5) * sqrt(4.0 * AIR_PI) * point[ORDER]) < 1e-12);
    for (long left = 0; left < 2; left++) {
        atomic_store(&allocator.remaining, left);
        assert_int_equal(air_impulse_directional_fluences(context, 3, 1.5, out), AIR_ERROR_MEMORY);
    }
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
    /* The mean of a patch's fluence over its orientations is a quarter of a point light's: over
     * cos(theta_s) the sum of bands has only band 0 left. */
    for (int k = 2; k <= 6; k += 2) {
        const graded_rule rule = graded_rule_make(8);
        double mean = 0.0;
        for (int i = 0; i < 16; i++) {
            const double c = (i / 8 == 0 ? -1.0 : 0.0) + rule.x[i % 8];
            mean += 0.5 * rule.w[i % 8] * air_impulse_area_fluence(k, 1.2, acos(c));
        }
        assert_true(fabs(mean * 4.0 / air_impulse_point_fluence(k, 1.2) - 1.0) < 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(band_0_is_the_fluence),
        cmocka_unit_test(one_event_is_that_of_the_other_quadratures),
        cmocka_unit_test(a_patch_obeys_reciprocity),
        cmocka_unit_test(the_half_space_loses_what_leaves_it),
        cmocka_unit_test(fluences_of_other_emitters_are_these),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}

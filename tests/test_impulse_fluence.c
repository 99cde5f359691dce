/* Fluences after k events: energy, published values, and the closed total. */
#include <math.h>

#include "airlight/impulse.h"
#include "cmocka_test.h"
#include "core/vec.h"
#include "impulse/fluence.h"
#include "impulse/graded.h"
#include "impulse/multiple.h"

/* Nothing is absorbed and space is infinite: every order scatters all of the power, 4 pi. The
 * integral to 200 leaves out exp(-200) of each; panels double, 12 nodes each. */
static void every_order_keeps_the_power(void **state)
{
    const graded_rule rule = graded_rule_make(12);
    double sums[AIR_IMPULSE_BOUNCES_MAX + 1] = {0.0}, scaled[AIR_IMPULSE_BOUNCES_MAX + 1];
    (void)state;
    for (double from = 1e-6; from < 200.0;) {
        const double width = double_min(from, 4.0);
        for (int i = 0; i < rule.nodes; i++) {
            const double r = from + width * rule.x[i];
            impulse_fluences_scaled(AIR_IMPULSE_BOUNCES_MAX, r, scaled);
            for (int k = 0; k <= AIR_IMPULSE_BOUNCES_MAX; k++) {
                sums[k] += width * rule.w[i] * r * r * exp(-r) * scaled[k];
            }
        }
        from += width;
    }
    for (int k = 0; k <= AIR_IMPULSE_BOUNCES_MAX; k++) {
        /* k = 0 lacks its first 1e-6 */
        assert_true(fabs(sums[k] - 1.0) < (k == 0 ? 2e-6 : 1e-9));
    }
}

static void values_are_the_published_ones(void **state)
{
    static const double given[10] = {0.4340201594, 0.3748869316, 0.2921008367, 0.2211006277,
                                     0.1679986578, 0.1299531010, 0.1028119366, 0.0831953467,
                                     0.0687277080, 0.0578178369};
    (void)state;
    for (int k = 1; k <= 10; k++) {
        assert_true(fabs(air_impulse_point_fluence(k, 1.0) - given[k - 1]) < 1e-10);
    }
    assert_true(air_impulse_point_fluence(0, 2.0) == exp(-2.0) / 4.0);
}

/* Many orders share a contour that is the best of one of them. */
static void contours_agree(void **state)
{
    static const double distances[] = {1e-4, 0.01, 0.3, 2.0, 9.0, 40.0};
    double scaled[AIR_IMPULSE_BOUNCES_MAX + 1];
    (void)state;
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; i++) {
        const double r = distances[i];
        impulse_fluences_scaled(AIR_IMPULSE_BOUNCES_MAX, r, scaled);
        for (int k = 1; k <= AIR_IMPULSE_BOUNCES_MAX; k++) {
            const double own = air_impulse_point_fluence(k, r);
            assert_true(fabs(exp(-r) * scaled[k] - own) < 1e-9 * own);
        }
    }
}

/* Orders one by one and the closed rest behind them make the closed total; and with absorption
 * enough the orders converge by themselves: 0.4^21 is 4e-9, of fluences that at r = 6 are still 30
 * times the first. */
static void the_rest_is_what_orders_leave(void **state)
{
    static const double albedos[] = {0.4, 0.9, 0.999, 1.0}, distances[] = {0.1, 1.0, 6.0};
    (void)state;
    for (int i = 0; i < 4 * 3; i++) {
        const double alpha = albedos[i % 4], r = distances[i / 4];
        const double all = air_impulse_point_fluence_rest(0, alpha, r);
        double sum = 0.0;
        for (int k = 1; k <= AIR_IMPULSE_BOUNCES_MAX; k++) {
            sum += pow(alpha, k) * air_impulse_point_fluence(k, r);
        }
        const double rest = air_impulse_point_fluence_rest(AIR_IMPULSE_BOUNCES_MAX, alpha, r);
        assert_true(fabs(sum + rest - all) < 1e-9 * all);
        if (alpha < 0.5) {
            assert_true(fabs(sum - all) < 2e-7 * all);
        }
    }
}

/* Totals that were published with five digits; far away 3/r. */
static void totals_are_the_published_ones(void **state)
{
    static const double given[3][2] = {{0.1, 116.54}, {1.0, 3.2800}, {4.0, 0.75062}};
    (void)state;
    for (int i = 0; i < 3; i++) {
        const double r = given[i][0];
        const double total =
            air_impulse_point_fluence(0, r) + air_impulse_point_fluence_rest(0, 1.0, r);
        assert_true(fabs(total / given[i][1] - 1.0) < 4e-5);
    }
    assert_true(fabs(air_impulse_point_fluence_rest(0, 1.0, 40.0) * 40.0 / 3.0 - 1.0) < 1e-12);
}

/* In the closed total the pole's formula changes near 1: both sides meet. Slope of the total in
 * alpha is that of exp(-sqrt(3 (1 - alpha)) r): 2e-3 over a step of 1e-8. */
static void the_total_goes_on_to_albedo_1(void **state)
{
    const double a = air_impulse_point_fluence_rest(0, 1.0 - 1.01e-7, 2.0);
    const double b = air_impulse_point_fluence_rest(0, 1.0 - 0.99e-7, 2.0);
    const double one = air_impulse_point_fluence_rest(0, 1.0, 2.0);
    (void)state;
    assert_true(fabs(a - b) < 1e-4 && b > a && one > b && one - a < 3e-3);
}

/* Between the knots of the curves. */
static void curves_are_the_functions(void **state)
{
    static impulse_curves curves;
    double at[AIR_IMPULSE_BOUNCES_MAX + 1], exact[AIR_IMPULSE_BOUNCES_MAX + 1];
    (void)state;
    impulse_curves_fluences(AIR_IMPULSE_BOUNCES_MAX, &curves);
    for (double r = 2.3e-5; r < 60.0; r *= 1.37) {
        impulse_curves_at(&curves, AIR_IMPULSE_BOUNCES_MAX, r, at);
        impulse_fluences_scaled(AIR_IMPULSE_BOUNCES_MAX, r, exact);
        for (int k = 0; k <= AIR_IMPULSE_BOUNCES_MAX; k++) {
            assert_true(fabs(at[k] / exact[k] - 1.0) < 1e-6);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_order_keeps_the_power),
        cmocka_unit_test(values_are_the_published_ones),
        cmocka_unit_test(contours_agree),
        cmocka_unit_test(the_rest_is_what_orders_leave),
        cmocka_unit_test(totals_are_the_published_ones),
        cmocka_unit_test(the_total_goes_on_to_albedo_1),
        cmocka_unit_test(curves_are_the_functions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

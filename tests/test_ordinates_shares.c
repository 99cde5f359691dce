/* Shares of lobes: against quadrature over the sphere, their sums and limits, and fast forms. */
#include "ordinates/shares.h"

#include <stdlib.h>

#include "cmocka_test.h"

/* ---- quadrature: adaptive Simpson, to 1e-15 a piece but for rounding ---- */

typedef struct lobe_integrand {
    double a;
    double (*weight)(double mu);
} lobe_integrand;

typedef double integrand(const lobe_integrand *self, double x);

static double simpson(integrand *f, const lobe_integrand *self, double a, double b, double fa,
                      double fm, double fb, double tolerance, int depth)
{
    const double m = 0.5 * (a + b), l = 0.5 * (a + m), r = 0.5 * (m + b);
    const double fl = f(self, l), fr = f(self, r), h = (b - a) / 12.0;
    const double whole = 2.0 * h * (fa + 4.0 * fm + fb);
    const double halves = h * (fa + 4.0 * fl + fm) + h * (fm + 4.0 * fr + fb);
    if (depth <= 0 || fabs(halves - whole) <= 15.0 * tolerance) {
        return halves + (halves - whole) / 15.0;
    }
    return simpson(f, self, a, m, fa, fl, fm, tolerance, depth - 1) +
           simpson(f, self, m, b, fm, fr, fb, tolerance, depth - 1);
}

/* A step from 0 to 1 whose slopes there are 0, of seventh degree. */
static double graded(double x)
{
    return x * x * x * x * (35.0 - x * (84.0 - x * (70.0 - 20.0 * x)));
}

/* In pieces, lest a narrow peak is missed; they are small at either end. */
static double integral(integrand *f, const lobe_integrand *self, double a, double b)
{
    enum { PIECES = 64 };
    double sum = 0.0;
    for (int i = 0; i < PIECES; i++) {
        const double low = a + (b - a) * graded((double)i / PIECES);
        const double high = a + (b - a) * graded((double)(i + 1) / PIECES);
        sum += simpson(f, self, low, high, f(self, low), f(self, 0.5 * (low + high)), f(self, high),
                       1e-15, 12);
    }
    return sum;
}

/* The lobe by its polar angle, with the square that does not cancel near the peak. */
static double at_angle(const lobe_integrand *self, double theta)
{
    const double a = self->a, b = fabs(a), half = a > 0.0 ? sin(0.5 * theta) : cos(0.5 * theta);
    const double s2 = (1.0 - b) * (1.0 - b) + 4.0 * b * half * half;
    return 0.5 * (1.0 - b) * (1.0 + b) * sin(theta) / (s2 * sqrt(s2)) * self->weight(cos(theta));
}

static double one(double mu)
{
    (void)mu;
    return 1.0;
}

static double itself(double mu) { return mu; }

/* ---- the paper's regions ---- */

static const double lobes[12] = {-0.99, -0.7, -0.3, -0.01, 0.0, 1e-9,
                                 0.01,  0.3,  0.5,  0.7,   0.9, 0.995};

/* Simpson to 64 times 1e-14, shares of order 1. */
static void shares_are_integrals_over_cones(void **state)
{
    (void)state;
    for (int i = 0; i < 12; i++) {
        const lobe_integrand share = {lobes[i], one}, mean = {lobes[i], itself};
        const air_ordinates_shares s = air_ordinates_shares_of(lobes[i]);
        const double quarter = 0.25 * AIR_PI;
        const double found[6] = {s.front,      4.0 * s.side,      s.back,
                                 s.front_mean, 4.0 * s.side_mean, s.back_mean};
        for (int region = 0; region < 3; region++) {
            const double low = region == 0 ? 0.0 : region == 1 ? quarter : 3.0 * quarter;
            const double high = region == 0 ? quarter : region == 1 ? 3.0 * quarter : AIR_PI;
            assert_true(fabs(found[region] - integral(at_angle, &share, low, high)) < 1e-12);
            assert_true(fabs(found[3 + region] - integral(at_angle, &mean, low, high)) < 1e-12);
        }
    }
}

/* Printed with ten digits. */
static void shares_are_the_golden_ones(void **state)
{
    static const double golden[6][7] = {
        {0.0, 0.1464466094, 0.1464466094, 0.1767766953, 0.1250000000, -0.1250000000, 0.0},
        {0.3, 0.3078389343, 0.0658401596, 0.1565802265, 0.2662044893, -0.0559334856, 0.0224322491},
        {0.5, 0.4821024832, 0.0361101165, 0.1204468501, 0.4250184446, -0.0306376099, 0.0264047913},
        {0.7, 0.6991339343, 0.0170383011, 0.0709569411, 0.6381381200, -0.0144476934, 0.0190773933},
        {0.9, 0.9115398211, 0.0045630598, 0.0209742798, 0.8794868094, -0.0038684546, 0.0060954113},
        {1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0}};
    (void)state;
    for (int i = 0; i < 6; i++) {
        const air_ordinates_shares s = air_ordinates_shares_of(golden[i][0]);
        const double found[6] = {s.front, s.back, s.side, s.front_mean, s.back_mean, s.side_mean};
        for (int k = 0; k < 6; k++) {
            assert_true(fabs(found[k] - golden[i][1 + k]) < 6e-11);
        }
    }
}

/* The last of three rounded sums may be off by a few 1e-16. */
static void shares_add_up(void **state)
{
    (void)state;
    for (double a = -1.0; a <= 1.0; a += 1.0 / 512.0) {
        const air_ordinates_shares s = air_ordinates_shares_of(a);
        assert_true(fabs(s.front + 4.0 * s.side + s.back - 1.0) < 1e-15);
        assert_true(fabs(s.front_mean + 4.0 * s.side_mean + s.back_mean - a) < 1e-15);
        assert_true(s.side >= 0.0 && s.front >= 0.0 && s.back >= 0.0);
    }
}

/* The stated errors of the polynomials, 3.5e-5 and 2.6e-5, and 1e-6 of floats. */
static void fast_shares_are_near(void **state)
{
    double worst[2] = {0.0, 0.0}, least = 1.0;
    (void)state;
    for (int i = -100000; i <= 100000; i++) {
        const double a = i * 1e-5;
        const air_ordinates_shares s = air_ordinates_shares_of(a);
        float odd, odd_mean;
        const float even = ordinates_halves(ordinates_front, (float)a, &odd);
        const float even_mean = ordinates_halves(ordinates_front_mean, (float)a, &odd_mean);
        worst[0] = double_max(worst[0], fabs((double)(even + odd) - s.front));
        worst[0] = double_max(worst[0], fabs((double)(even - odd) - s.back));
        worst[1] = double_max(worst[1], fabs((double)(even_mean + odd_mean) - s.front_mean));
        worst[1] = double_max(worst[1], fabs((double)(odd_mean - even_mean) - s.back_mean));
        least = double_min(least, (double)(even - fabsf(odd)));
    }
    print_message("front %.2e, front mean %.2e, least share %.1e\n", worst[0], worst[1], least);
    assert_true(worst[0] < 3.6e-5 && worst[1] < 2.7e-5);
}

/* The fit's stated error, 7e-3, against the mean of the inverse sum; a sharp lobe goes straight. */
static void path_is_near_the_mean_inverse_sum(void **state)
{
    ordinates_upwind_row *const rows = malloc(ORDINATES_ROWS * sizeof *rows);
    double worst = 0.0;
    (void)state;
    assert_non_null(rows);
    ordinates_upwind_tabulate(rows);
    for (double a = -1.0; a <= 1.0; a += 1e-3) {
        worst = double_max(worst, fabs(ordinates_path(a) - ordinates_upwind_at(rows, a).path));
    }
    print_message("path %.1e\n", worst);
    assert_true(worst < 7.2e-3);
    assert_true(ordinates_path(1.0) == 1.0 && ordinates_path(-1.0) == 1.0);
    free(rows);
}

/* ---- cumulative and phase function ---- */

static void cumulative_is_the_integral_of_the_lobe(void **state)
{
    (void)state;
    for (int i = 0; i < 12; i++) {
        const lobe_integrand share = {lobes[i], one};
        for (double mu = -0.9; mu < 1.0; mu += 0.3) {
            const double below = integral(at_angle, &share, acos(mu), AIR_PI);
            assert_true(fabs(ordinates_cumulative(lobes[i], mu) - below) < 1e-12);
            const double phase = ordinates_phase(lobes[i], mu);
            const double there = at_angle(&share, acos(mu)) / sqrt(1.0 - mu * mu);
            assert_true(fabs(phase * 2.0 * AIR_PI / there - 1.0) < 1e-12);
        }
        assert_true(ordinates_cumulative(lobes[i], 1.0) == 1.0);
        assert_true(ordinates_cumulative(lobes[i], -1.0) == 0.0);
    }
    /* beams: all of it in the last bin, or in the first */
    assert_true(ordinates_cumulative(1.0, 0.9) == 0.0);
    assert_true(fabs(ordinates_cumulative(-1.0, -0.9) - 1.0) < 1e-15);
    assert_true(ordinates_dull(1.0) == 0.995 && ordinates_dull(-1.0) == -0.995);
}

/* ---- upwind shares ---- */

/* By the midpoint rule over a quarter of the circle, extrapolated: errors go as 1/n^4. */
static double mean_inverse_sum(double mu)
{
    double sums[2];
    for (int i = 0; i < 2; i++) {
        const int n = 128 << i;
        const double r = sqrt(double_max(0.0, 1.0 - mu * mu));
        sums[i] = 0.0;
        for (int k = 0; k < n; k++) {
            const double phi = 0.5 * AIR_PI * (k + 0.5) / n;
            sums[i] += 1.0 / (fabs(mu) + r * (cos(phi) + sin(phi))) / n;
        }
    }
    return sums[1] + (sums[1] - sums[0]) / 3.0;
}

static double front_weight(double mu) { return mu > 0.0 ? mu * mean_inverse_sum(mu) : 0.0; }
static double mean_weight(double mu) { return mu * front_weight(mu); }

/* Nodes hold the integrals but for the midpoint rule's 1/n^4 = 4e-9; between them the straight line
 * is off by (1/256)^2/8 = 2e-6 times the second derivative by t, 10 at most. */
static void upwind_shares_are_integrals(void **state)
{
    ordinates_upwind_row *const rows = malloc(ORDINATES_ROWS * sizeof *rows);
    double at_nodes = 0.0, between = 0.0;
    (void)state;
    assert_non_null(rows);
    ordinates_upwind_tabulate(rows);
    for (int i = 2; i < 2 * ORDINATES_ROWS - 2; i += 23) {
        const double t = i * (0.5 / (ORDINATES_ROWS - 1));
        for (int sign = -1; sign <= 1; sign += 2) {
            const double a = sign * (1.0 - t * t);
            const ordinates_upwind s = ordinates_upwind_at(rows, a);
            const lobe_integrand share = {a, front_weight}, mean = {a, mean_weight};
            const double off =
                double_max(fabs(s.front - integral(at_angle, &share, 0.0, 0.5 * AIR_PI)),
                           fabs(s.front_mean - integral(at_angle, &mean, 0.0, 0.5 * AIR_PI)));
            double *const worst = i % 2 == 0 ? &at_nodes : &between;
            *worst = double_max(*worst, off);
        }
    }
    print_message("upwind: nodes %.1e, between %.1e\n", at_nodes, between);
    assert_true(at_nodes < 1e-8 && between < 2e-5);
    free(rows);
}

/* Isotropic light leaves by all faces alike; a beam goes straight. */
static void upwind_shares_have_their_limits(void **state)
{
    ordinates_upwind_row *const rows = malloc(ORDINATES_ROWS * sizeof *rows);
    (void)state;
    assert_non_null(rows);
    ordinates_upwind_tabulate(rows);
    const ordinates_upwind even = ordinates_upwind_at(rows, 0.0),
                           beam = ordinates_upwind_at(rows, 1.0);
    assert_true(fabs(even.front - 1.0 / 6.0) < 1e-12 && fabs(even.side - 1.0 / 6.0) < 1e-12);
    assert_true(fabs(even.front_mean - even.back_mean) < 1e-15 && fabs(even.side_axial) < 1e-15);
    /* by symmetry the same momentum to the front as to a side's normal */
    assert_true(fabs(even.side_lateral - even.front_mean) < 1e-12);
    assert_true(beam.front == 1.0 && beam.front_mean == 1.0 && beam.path == 1.0);
    assert_true(beam.back == 0.0 && beam.side == 0.0);
    for (double a = -1.0; a <= 1.0; a += 1e-3) {
        const ordinates_upwind s = ordinates_upwind_at(rows, a);
        assert_true(fabs(s.front + s.back + 4.0 * s.side - 1.0) < 1e-15);
        assert_true(fabs(s.front_mean - s.back_mean + 4.0 * s.side_axial - a) < 1e-15);
        assert_true(s.side >= 0.0 && s.side_lateral >= 0.0);
    }
    free(rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_are_integrals_over_cones),
        cmocka_unit_test(shares_are_the_golden_ones),
        cmocka_unit_test(shares_add_up),
        cmocka_unit_test(fast_shares_are_near),
        cmocka_unit_test(path_is_near_the_mean_inverse_sum),
        cmocka_unit_test(cumulative_is_the_integral_of_the_lobe),
        cmocka_unit_test(upwind_shares_are_integrals),
        cmocka_unit_test(upwind_shares_have_their_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

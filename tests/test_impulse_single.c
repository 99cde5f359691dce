/* One event: against plain integrals over the ray and the directions, and identities. */
#include <math.h>

#include "airlight/impulse.h"
#include "cmocka_test.h"
#include "core/harmonics.h"
#include "core/vec.h"
#include "impulse/single.h"

enum { ORDER = AIR_IMPULSE_ORDER, COUNT = AIR_IMPULSE_SH_COUNT };

static double vector_error(const double *found, const double *expected, int count)
{
    double error = 0.0, square = 0.0;
    for (int i = 0; i < count; i++) {
        error += (found[i] - expected[i]) * (found[i] - expected[i]);
        square += expected[i] * expected[i];
    }
    return sqrt(error / square);
}

/* The coefficients are integrals of radiance: 40 panels of 8 nodes in theta, closer towards the
 * light, where radiance grows as 1/sin(theta), which the sphere's measure takes away. */
static void radiance_along_rays_makes_the_coefficients(void **state)
{
    static const double cases[4][3] = {
        {0.05, 0.0, 0.3}, {0.7, 0.5, 1.1}, {2.0, -0.6, 2.0}, {6.0, 0.85, 0.25}};
    const graded_rule rule = graded_rule_make(8);
    (void)state;
    for (int i = 0; i < 4; i++) {
        const double sigma = cases[i][2], tau = cases[i][0], g = cases[i][1], d = tau / sigma;
        double sum[ORDER] = {0.0}, y[ORDER], exact[ORDER];
        graded_list theta = {.count = 0};
        graded_both(&theta, &rule, 0.0, AIR_PI, 20, 12);
        for (int j = 0; j < theta.count; j++) {
            const double c = cos(theta.x[j]);
            /* a ray in two pieces */
            const double radiance = air_impulse_point_ray(sigma, sigma, g, d, c, 0.0, 0.8 * d) +
                                    air_impulse_point_ray(sigma, sigma, g, d, c, 0.8 * d, INFINITY);
            air_zh_evaluate(ORDER, c, y);
            for (int l = 0; l < ORDER; l++) {
                sum[l] += theta.w[j] * 2.0 * AIR_PI * sin(theta.x[j]) * radiance * y[l];
            }
        }
        air_impulse_point(tau, g, ORDER, exact);
        for (int l = 0; l < ORDER; l++) {
            exact[l] *= sigma * sigma;
        }
        assert_true(vector_error(sum, exact, ORDER) < 1e-6);
    }
}

/* The integral over the ray as it stands, sigma_s p exp(-sigma_t (t + r))/r^2, by 400 panels. */
static void a_piece_of_a_ray_is_its_integral(void **state)
{
    const graded_rule rule = graded_rule_make(8);
    const double sigma_s = 0.3, sigma_t = 0.5, g = 0.4, d = 1.7;
    (void)state;
    for (double cosine = -0.95; cosine < 1.0; cosine += 0.19) {
        const double t0 = 0.2, t1 = 5.1;
        double sum = 0.0;
        for (int i = 0; i < 400 * 8; i++) {
            const double t = t0 + (t1 - t0) * (i / 8 + rule.x[i % 8]) / 400.0;
            const double r = sqrt(d * d + t * t - 2.0 * d * t * cosine);
            const double turned = (d * cosine - t) / r; /* of light on its way to x */
            sum += (t1 - t0) / 400.0 * rule.w[i % 8] * sigma_s * impulse_phase(g, turned) *
                   exp(-sigma_t * (t + r)) / (r * r);
        }
        const double found = air_impulse_point_ray(sigma_s, sigma_t, g, d, cosine, t0, t1);
        assert_true(fabs(found - sum) < 1e-7 * sum);
    }
    assert_true(isinf(air_impulse_point_ray(1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 2.0)));
    assert_true(isfinite(air_impulse_point_ray(1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.5)));
    assert_true(isfinite(air_impulse_point_ray(1.0, 1.0, 0.0, 1.0, -1.0, 0.0, INFINITY)));
}

/* A patch that faces all ways in turn is a point light of a quarter of its intensity: the mean of
 * max(0, cos) is 1/4. 12 Gauss nodes on each side of the right angle, whose integrand is smooth but
 * for its second derivative there; higher bands of azimuth vanish. */
static void all_orientations_of_a_patch_make_a_point_light(void **state)
{
    static const double cases[3][2] = {{0.1, 0.0}, {1.0, -0.4}, {3.0, 0.6}};
    const graded_rule rule = graded_rule_make(6);
    (void)state;
    for (int i = 0; i < 3; i++) {
        double mean[ORDER] = {0.0}, point[ORDER], sh[COUNT];
        graded_list theta = {.count = 0};
        graded_both(&theta, &rule, 0.0, 0.5 * AIR_PI, 0, 2);
        graded_both(&theta, &rule, 0.5 * AIR_PI, AIR_PI, 2, 0);
        for (int j = 0; j < theta.count; j++) {
            air_impulse_area(cases[i][0], theta.x[j], cases[i][1], ORDER, sh);
            for (int l = 0; l < ORDER; l++) {
                mean[l] += theta.w[j] * 0.5 * sin(theta.x[j]) * sh[l * (l + 1) / 2];
            }
        }
        air_impulse_point(cases[i][0], cases[i][1], ORDER, point);
        for (int l = 0; l < ORDER; l++) {
            point[l] *= 0.25;
        }
        assert_true(vector_error(mean, point, ORDER) < 1e-5);
    }
}

/* Facing and averted patches have no azimuth, and together they are more than one alone. */
static void a_patch_along_the_axis_is_zonal(void **state)
{
    double facing[COUNT], averted[COUNT];
    (void)state;
    air_impulse_area(0.8, 0.0, 0.3, ORDER, facing);
    air_impulse_area(0.8, AIR_PI, 0.3, ORDER, averted);
    for (int l = 0; l < ORDER; l++) {
        for (int m = 1; m <= l; m++) {
            assert_true(fabs(facing[l * (l + 1) / 2 + m]) < 1e-10 * facing[0]);
            assert_true(fabs(averted[l * (l + 1) / 2 + m]) < 1e-10 * facing[0]);
        }
    }
    assert_true(averted[0] > 0.0 && averted[0] < facing[0]);
}

/* The clamp's moments against 4000 angles by the midpoint rule, whose error where the slope jumps
 * is the square of the step. */
static void moments_of_the_clamp_are_their_integrals(void **state)
{
    double moments[ORDER];
    (void)state;
    for (double a = -1.4; a < 1.5; a += 0.35) {
        impulse_clamped_moments(a, 0.9, ORDER, moments);
        for (int m = 0; m < ORDER; m++) {
            double sum = 0.0;
            for (int i = 0; i < 4000; i++) {
                const double phi = 2.0 * AIR_PI * (i + 0.5) / 4000.0;
                sum += cos(m * phi) * double_max(0.0, a + 0.9 * cos(phi)) * 2.0 * AIR_PI / 4000.0;
            }
            assert_true(fabs(moments[m] - sum) < 3e-6);
        }
    }
}

static void the_clamp_cuts_a_part_of_the_turn_between_its_two_angles(void **state)
{
    (void)state;
    for (double theta_s = 0.1; theta_s < AIR_PI; theta_s += 0.2) {
        double cuts[2];
        impulse_clamp_cuts(theta_s, cuts);
        assert_true(0.0 < cuts[0] && cuts[0] < cuts[1] && cuts[1] < AIR_PI);
        for (double gamma = 0.05; gamma < AIR_PI; gamma += 0.1) {
            const double a = cos(theta_s) * cos(gamma), b = sin(theta_s) * sin(gamma);
            assert_int_equal(fabs(a) < b, cuts[0] < gamma && gamma < cuts[1]);
        }
    }
}

static void directional_coefficients_are_those_of_the_slab_ray(void **state)
{
    static const double cases[3][2] = {{0.02, 0.0}, {1.3, 0.5}, {6.0, -0.7}};
    const graded_rule rule = graded_rule_make(12);
    const double up[3] = {0.0, 0.0, 1.0};
    (void)state;
    for (int i = 0; i < 3; i++) {
        double sum[ORDER] = {0.0}, y[ORDER], exact[ORDER];
        graded_list mu = {.count = 0};
        graded_both(&mu, &rule, 0.0, 1.0, 24, 12);
        graded_both(&mu, &rule, -1.0, 0.0, 12, 2);
        for (int j = 0; j < mu.count; j++) {
            const double w[3] = {sqrt(1.0 - mu.x[j] * mu.x[j]), 0.0, mu.x[j]};
            const double radiance =
                air_impulse_slab_ray(0.6, 0.6, cases[i][1], up, up, cases[i][0] / 0.6, w, INFINITY);
            air_zh_evaluate(ORDER, mu.x[j], y);
            for (int l = 0; l < ORDER; l++) {
                sum[l] += mu.w[j] * 2.0 * AIR_PI * radiance * y[l];
            }
        }
        air_impulse_directional(cases[i][0], cases[i][1], ORDER, exact);
        assert_true(vector_error(sum, exact, ORDER) < 1e-9);
    }
}

/* A slab's irradiance against a plain sum over a grid of 600 x 600 directions, whose horizons cost
 * some 1e-4; and for light across the boundary against the zonal coefficients, of which the bands
 * beyond 10 are missing (0.6 % at most for a horizontal receiver). */
static void slab_irradiance_is_the_integral_of_the_ray(void **state)
{
    const double n[3] = {0.0, 0.0, 1.0}, l[3] = {0.6, 0.0, 0.8};
    const double r[3] = {-0.36, 0.48, 0.8};
    double sum = 0.0, zh[ORDER], lobe[ORDER];
    (void)state;
    for (int i = 0; i < 600 * 600; i++) {
        const double z = 2.0 * (i / 600 + 0.5) / 600.0 - 1.0, s = sqrt(1.0 - z * z);
        const double phi = 2.0 * AIR_PI * (i % 600 + 0.5) / 600.0;
        const double w[3] = {s * cos(phi), s * sin(phi), z};
        const double cosine = w[0] * r[0] + w[1] * r[1] + w[2] * r[2];
        sum += 4.0 * AIR_PI / 360000.0 * double_max(0.0, cosine) *
               air_impulse_slab_ray(0.8, 1.0, 0.4, l, n, 0.9, w, INFINITY);
    }
    const double found = air_impulse_slab_irradiance(0.8, 0.4, l, n, 0.9, r);
    assert_true(fabs(found / sum - 1.0) < 1e-3);
    air_impulse_directional(0.9, 0.4, ORDER, zh);
    air_impulse_lobe_cosine(ORDER, 1.0, lobe);
    const double zonal = air_impulse_zonal_receive(ORDER, zh, lobe, 1.0);
    assert_true(fabs(air_impulse_slab_irradiance(1.0, 0.4, n, n, 0.9, n) / zonal - 1.0) < 0.006);
}

/* Radiance is positive, so no band is more than band 0 times its y_l(1)/y_0. */
static void extremes_are_finite(void **state)
{
    static const double taus[3] = {1e-6, 1.0, 60.0}, gs[3] = {-0.97, 0.0, 0.97};
    double zh[ORDER];
    (void)state;
    for (int i = 0; i < 9; i++) {
        air_impulse_point(taus[i % 3], gs[i / 3], ORDER, zh);
        assert_true(isfinite(zh[0]) && zh[0] > 0.0 && zh[0] >= fabs(zh[10]) / sqrt(21.0));
        air_impulse_directional(taus[i % 3], gs[i / 3], ORDER, zh);
        assert_true(isfinite(zh[0]) && zh[0] > 0.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radiance_along_rays_makes_the_coefficients),
        cmocka_unit_test(a_piece_of_a_ray_is_its_integral),
        cmocka_unit_test(all_orientations_of_a_patch_make_a_point_light),
        cmocka_unit_test(a_patch_along_the_axis_is_zonal),
        cmocka_unit_test(moments_of_the_clamp_are_their_integrals),
        cmocka_unit_test(the_clamp_cuts_a_part_of_the_turn_between_its_two_angles),
        cmocka_unit_test(directional_coefficients_are_those_of_the_slab_ray),
        cmocka_unit_test(slab_irradiance_is_the_integral_of_the_ray),
        cmocka_unit_test(extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

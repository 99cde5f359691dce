/* Whole-volume sampling and the estimators: distributions, and means against partial integrals. */
#include "chi_square.h"
#include "cmocka_test.h"
#include "collimated_fixture.h"

enum { CONFIGURATIONS = 300, SAMPLES = 20000, BINS = 40 };

/* A profile with something in it: one medium, a medium through windows, or cells that overlap, the
 * first of which may only absorb. */
static const air_collimated_profile *random_profile(air_rng *rng, int kind, roomy_profile *room,
                                                    roomy_profile *other)
{
    for (;;) {
        const lit_ray r = random_lit_ray(rng);
        const lit_ray behind = random_lit_ray(rng);
        const air_collimated_profile *out = roomy(room);
        make_profile(&r, &room->profile);
        if (kind == 1) {
            const air_interval windows[3] = {{0.0, 0.3}, {0.7, 1.5}, {1.6, 9.0}};
            air_collimated_profile_restrict(&room->profile, windows, 3, roomy(other));
            out = &other->profile;
        } else if (kind == 2) {
            const air_collimated_cell cells[2] = {
                {behind.medium, fmin(behind.sigma_t, 3.0), air_rng_next(rng) % 2u == 0 ? 0.0 : 2.0},
                {r.medium, fmin(r.sigma_t, 3.0), 1.0}};
            air_collimated_profile_make_cells(cells, 2, r.to_light, r.origin, r.dir, r.t_max,
                                              &room->profile);
        }
        if (out->count > 0) {
            return out;
        }
    }
}

static double begin_of(const air_collimated_profile *profile) { return profile->pieces[0].t0; }
static double end_of(const air_collimated_profile *profile)
{
    return profile->pieces[profile->count - 1].t1;
}

static double sample_p_value(const air_collimated_profile *profile, air_rng *rng)
{
    double observed[BINS] = {0.0}, expected[BINS];
    const double a = begin_of(profile), b = end_of(profile);
    for (int i = 0; i < SAMPLES; i++) {
        const double t = air_collimated_sample(profile, random_unit(rng));
        const int bin = (int)((t - a) / (b - a) * BINS);
        observed[bin < BINS ? bin : BINS - 1] += 1.0;
    }
    double before = 0.0;
    for (int i = 0; i < BINS; i++) {
        const double after =
            i == BINS - 1 ? 1.0 : air_collimated_sample_cdf(profile, a + (b - a) * (i + 1) / BINS);
        expected[i] = SAMPLES * (after - before);
        before = after;
    }
    return chi_square_p(observed, expected, BINS, NULL);
}

static void samples_follow_the_cdf(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 5);
    roomy_profile room, other;
    double low = 0.0, tenths[10] = {0.0}, even[10];
    for (int n = 0; n < CONFIGURATIONS; n++) {
        const double p = sample_p_value(random_profile(&rng, n % 3, &room, &other), &rng);
        low += p < 0.01;
        tenths[p < 1.0 ? (int)(10.0 * p) : 9] += p < 1.0; /* 1: a single pool */
    }
    double tested = 0.0;
    for (int i = 0; i < 10; i++) {
        tested += tenths[i];
    }
    for (int i = 0; i < 10; i++) {
        even[i] = 0.1 * tested;
    }
    assert_true(tested > 0.9 * CONFIGURATIONS);
    assert_true(low < 0.03 * CONFIGURATIONS);
    assert_true(chi_square_p(tenths, even, 10, NULL) > 1e-3);
}

static void the_cdf_is_the_integral_of_the_pdf_which_is_the_integrand(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 5);
    roomy_profile room, other;
    double x[32], w[32];
    air_gauss_legendre(32, x, w);
    for (int n = 0; n < CONFIGURATIONS; n++) {
        const air_collimated_profile *profile = random_profile(&rng, n % 3, &room, &other);
        double sum = 0.0;
        for (size_t i = 0; i < profile->count; i++) {
            const air_collimated_piece *p = &profile->pieces[i];
            /* 32 nodes integrate exp(-x) over x of 4 to rounding. */
            const int parts = 1 + (int)(0.25 * fabs(p->depth1 - p->depth0));
            const double step = (p->t1 - p->t0) / parts;
            for (int k = 0; k < parts; k++) {
                const double a = p->t0 + step * k;
                for (int j = 0; j < 32; j++) {
                    sum += 0.5 * step * w[j] *
                           air_collimated_sample_pdf(profile, a + 0.5 * step * (1.0 + x[j]));
                }
            }
            assert_true(fabs(air_collimated_sample_cdf(profile, p->t1) - sum) < 1e-11);
            const double t = random_between(&rng, p->t0, p->t1);
            const double integrand = air_collimated_integrand(profile, t);
            /* Depths up to 400, with their rounding. */
            assert_true(
                fabs(air_collimated_sample_pdf(profile, t) * air_collimated_integral(profile) -
                     integrand) <= 1e-12 * integrand);
        }
        assert_true(fabs(sum - 1.0) < 1e-11);
        assert_true(air_collimated_sample_pdf(profile, begin_of(profile) - 0.1) == 0.0);
        assert_true(air_collimated_sample_pdf(profile, end_of(profile) + 0.1) == 0.0);
        assert_true(air_collimated_sample_cdf(profile, begin_of(profile) - 0.1) == 0.0);
        assert_true(air_collimated_sample_cdf(profile, end_of(profile) + 0.1) == 1.0);
    }
}

static void the_cdf_of_a_sample_is_its_number(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 5);
    roomy_profile room, other;
    for (int n = 0; n < 10 * CONFIGURATIONS; n++) {
        const air_collimated_profile *profile = random_profile(&rng, n % 3, &room, &other);
        double last = begin_of(profile);
        for (int k = 0; k <= 20; k++) {
            const double u = k < 20 ? k / 20.0 : 1.0 - 0x1p-53;
            const double t = air_collimated_sample(profile, u);
            assert_true(t >= last && t <= end_of(profile));
            /* t rounds to 1e-15 of 10, times densities up to 1000. */
            assert_true(fabs(air_collimated_sample_cdf(profile, t) - u) < 1e-11);
            last = t;
        }
    }
}

static void whole_volume_samples_weigh_the_integral(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(4, 5);
    roomy_profile room, other;
    for (int n = 0; n < CONFIGURATIONS; n++) {
        const air_collimated_profile *profile = random_profile(&rng, n % 3, &room, &other);
        const double u = random_unit(&rng);
        const air_collimated_draw draw = air_collimated_estimate(AIR_COLLIMATED_WVDS, profile, u);
        assert_true(draw.t == air_collimated_sample(profile, u));
        assert_true(draw.unoccluded == air_collimated_integral(profile));
        assert_true(draw.analytic == draw.unoccluded);
    }
}

/* What the estimator makes of N stratified numbers with [dark.begin, dark.end] in shadow; the mean
 * and the largest unoccluded value. */
static double estimate(air_collimated_estimator estimator, const air_collimated_profile *profile,
                       air_interval dark, int count, double *out_largest)
{
    double analytic = 0.0, unoccluded = 0.0, lit = 0.0, largest = 0.0;
    for (int i = 0; i < count; i++) {
        const air_collimated_draw draw =
            air_collimated_estimate(estimator, profile, (i + 0.5) / count);
        const bool visible = draw.t < dark.begin || draw.t > dark.end;
        assert_true(draw.unoccluded >= 0.0);
        analytic += draw.analytic;
        unoccluded += draw.unoccluded;
        lit += visible ? draw.unoccluded : 0.0;
        largest = fmax(largest, draw.unoccluded);
    }
    *out_largest = largest;
    if (air_collimated_estimator_is_ratio(estimator)) {
        return unoccluded > 0.0 ? analytic / count * lit / unoccluded : 0.0;
    }
    return lit / count;
}

static void estimators_converge_to_the_lit_integral(void **state)
{
    (void)state;
    enum { NUMBERS = 20000, ROUNDS = 60 };
    air_rng rng = air_rng_from_keys(5, 5);
    roomy_profile room, other;
    for (int n = 0; n < ROUNDS; n++) {
        const air_collimated_profile *profile = random_profile(&rng, n % 3, &room, &other);
        const double a = begin_of(profile), b = end_of(profile);
        const double first = random_between(&rng, a, b), second = random_between(&rng, a, b);
        const air_interval dark = {fmin(first, second), fmax(first, second)};
        const double lit = air_collimated_partial_integral(profile, a, dark.begin) +
                           air_collimated_partial_integral(profile, dark.end, b);
        for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
            const air_collimated_estimator estimator = (air_collimated_estimator)k;
            double largest;
            const double found = estimate(estimator, profile, dark, NUMBERS, &largest);
            /* The midpoint rule for a function of total variation at most twice its largest value
             * per piece and per end of the shadow: that over 2 NUMBERS; a ratio has it above and
             * below. */
            const double variation = 2.0 * largest * (double)(profile->count + 2);
            assert_true(fabs(found - lit) <= 2.0 * variation / NUMBERS);
            const double whole =
                estimate(estimator, profile, (air_interval){b, a}, NUMBERS, &largest);
            assert_true(fabs(whole - air_collimated_integral(profile)) <=
                        2.0 * variation / NUMBERS);
        }
    }
}

static void distances_are_those_of_the_formulas(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 5);
    roomy_profile room, other;
    for (int n = 0; n < CONFIGURATIONS; n++) {
        const air_collimated_profile *profile = random_profile(&rng, 0, &room, &other);
        const air_collimated_piece *last = &profile->pieces[profile->count - 1];
        const double a = begin_of(profile), b = end_of(profile), u = random_unit(&rng);
        const double sigma_t = last->camera1 / (b - a), z = -expm1(-sigma_t * (b - a));
        const air_collimated_draw rm = air_collimated_estimate(AIR_COLLIMATED_RM, profile, u);
        const air_collimated_draw ds = air_collimated_estimate(AIR_COLLIMATED_DS, profile, u);
        assert_true(fabs(rm.t - (a + u * (b - a))) < 1e-14 * b);
        assert_true(fabs(ds.t - (a - log1p(-u * z) / sigma_t)) < 1e-12 * b);
        /* Z/sigma exp(-sigma d_m); (b - a) exp(-sigma E) */
        const double g = air_collimated_integrand(profile, ds.t);
        const double expected = z / sigma_t * g * exp(sigma_t * (ds.t - a));
        assert_true(fabs(ds.unoccluded - expected) <= 1e-11 * expected);
        const double uniform = (b - a) * air_collimated_integrand(profile, rm.t);
        assert_true(fabs(rm.unoccluded - uniform) <= 1e-12 * uniform);
        assert_true(air_collimated_estimate(AIR_COLLIMATED_REES, profile, u).t == rm.t);
        assert_true(air_collimated_estimate(AIR_COLLIMATED_REDS, profile, u).t == ds.t);
    }
}

static void extinction_far_behind_an_absorber_is_still_sampled(void **state)
{
    (void)state;
    /* Optical depth 2000 of smoke before fog: the camera sees nothing, but the distances in the fog
     * follow its extinction, and no estimate is NaN. */
    const double smoke_low[3] = {1.0, -1.0, -1.0}, smoke_high[3] = {2.0, 1.0, 1.0};
    const double fog_low[3] = {2.0, -1.0, -1.0}, fog_high[3] = {4.0, 1.0, 1.0};
    const air_collimated_cell cells[2] = {{box_between(smoke_low, smoke_high), 2000.0, 0.0},
                                          {box_between(fog_low, fog_high), 0.5, 1.0}};
    const double origin[3] = {0.0, 0.0, 0.0}, dir[3] = {1.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0};
    roomy_profile room;
    air_collimated_profile_make_cells(cells, 2, up, origin, dir, INFINITY, roomy(&room));
    for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
        const air_collimated_draw draw =
            air_collimated_estimate((air_collimated_estimator)k, &room.profile, 0.25);
        assert_true(draw.unoccluded == 0.0 && draw.analytic == 0.0);
        assert_true(k == AIR_COLLIMATED_RM || k == AIR_COLLIMATED_REES
                        ? draw.t == 2.5
                        : fabs(draw.t - (2.0 - log1p(0.25 * expm1(-1.0)) / 0.5)) < 1e-12);
    }
}

static void without_extinction_distances_are_uniform(void **state)
{
    (void)state;
    const double low[3] = {1.0, -1.0, -1.0}, high[3] = {3.0, 1.0, 1.0};
    const air_collimated_medium box = box_between(low, high);
    const double origin[3] = {0.0, 0.0, 0.0}, dir[3] = {1.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0};
    roomy_profile room;
    air_collimated_profile_make(&box, up, 0.0, origin, dir, INFINITY, roomy(&room));
    for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
        const air_collimated_draw draw =
            air_collimated_estimate((air_collimated_estimator)k, &room.profile, 0.25);
        assert_true(draw.t == 1.5 && draw.unoccluded == 2.0 && draw.analytic == 2.0);
    }
}

static void an_empty_profile_gives_zeros(void **state)
{
    (void)state;
    roomy_profile room;
    const air_collimated_profile *empty = roomy(&room);
    for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
        const air_collimated_draw draw =
            air_collimated_estimate((air_collimated_estimator)k, empty, 0.5);
        assert_true(draw.t == 0.0 && draw.unoccluded == 0.0 && draw.analytic == 0.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_the_cdf),
        cmocka_unit_test(the_cdf_is_the_integral_of_the_pdf_which_is_the_integrand),
        cmocka_unit_test(the_cdf_of_a_sample_is_its_number),
        cmocka_unit_test(whole_volume_samples_weigh_the_integral),
        cmocka_unit_test(estimators_converge_to_the_lit_integral),
        cmocka_unit_test(distances_are_those_of_the_formulas),
        cmocka_unit_test(extinction_far_behind_an_absorber_is_still_sampled),
        cmocka_unit_test(without_extinction_distances_are_uniform),
        cmocka_unit_test(an_empty_profile_gives_zeros),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Source functions towards an observer, against phase functions and fields that are known. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_view.h"
#include "cmocka_test.h"
#include "core/harmonics.h"
#include "core/phase.h"
#include "random_geometry.h"

enum { CHANNELS = 4, X = 70, Y = 3, Z = 4, CELLS = X * Y * Z, MOST_BANDS = AIR_SH_ORDER_MAX };

static air_phase hg(float g) { return (air_phase){AIR_PHASE_HG, g, NULL}; }
static const air_phase rayleigh = {AIR_PHASE_RAYLEIGH, 0.0f, NULL};
static const air_phase even = {AIR_PHASE_ISOTROPIC, 0.0f, NULL};

static const air_phase_mixture haze = {3,
                                       {{AIR_PHASE_HG, 0.8f, 0.5f},
                                        {AIR_PHASE_RAYLEIGH, 0.0f, 0.3f},
                                        {AIR_PHASE_ISOTROPIC, 0.0f, 0.2f}}};
static const air_phase_mixture both_ways = {
    2, {{AIR_PHASE_HG, 0.8f, 0.6f}, {AIR_PHASE_HG, -0.8f, 0.4f}}};

static air_phase mixture(const air_phase_mixture *m)
{
    return (air_phase){AIR_PHASE_MIXTURE, 0.0f, m};
}

static air_seen_box make_box(bool distant)
{
    air_seen_box box = {{X, Y, Z}, {0.1f, 0.3f, 0.2f}, distant, {0.0f, 0.0f, 0.0f}};
    const double near[3] = {2.0, 1.5, -0.7};
    double far[3] = {0.3, -0.5, 0.8};
    normalise(far);
    for (int k = 0; k < 3; k++) {
        box.observer[k] = (float)(distant ? far[k] : near[k]);
    }
    return box;
}

/* Unit, from the centre of a cell to a point, or a direction as it is. */
static void way_to(const air_seen_box *box, size_t cell, bool distant, const float to[3],
                   double out[3])
{
    const size_t at[3] = {cell % X, cell / X % Y, cell / X / Y};
    for (int k = 0; k < 3; k++) {
        const double center = ((double)at[k] + 0.5) * (double)box->cell_m[k];
        out[k] = (double)to[k] - (distant ? 0.0 : center);
    }
    normalise(out);
}

/* Between travel in a beam and travel to the observer. */
static double cosine_between(const air_seen_box *box, const air_seen_beam *beam, size_t cell)
{
    double v[3], d[3];
    way_to(box, cell, box->distant, box->observer, v);
    way_to(box, cell, !beam->local, beam->dir, d);
    return beam->local ? -dot(v, d) : dot(v, d);
}

static float *numbers(size_t count)
{
    float *const out = calloc(count, sizeof *out);
    assert_non_null(out);
    return out;
}

/* Random fluences, at least 1/10 of which arrives. */
static float *make_fluence(void)
{
    air_rng rng = air_rng_from_keys(5, 6);
    float *const out = numbers(CELLS * CHANNELS);
    for (size_t i = 0; i < CELLS * CHANNELS; i++) {
        out[i] = (float)random_between(&rng, 0.1, 1.0);
    }
    return out;
}

static air_seen_beam make_beam(bool local, float lobe, const float *fluence)
{
    air_seen_beam beam = {
        .local = local, .power = {2.0f, 1.0f, 0.5f}, .lobe = lobe, .fluence = fluence};
    double dir[3] = {-0.2, 0.9, 0.4};
    normalise(dir);
    for (int k = 0; k < 3; k++) {
        beam.dir[k] = local ? 0.77f + 0.1f * (float)k : (float)dir[k];
    }
    return beam;
}

static float *see(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                  air_phase phase, const air_seen_peak *peak)
{
    float *const out = numbers(CELLS * CHANNELS);
    air_seen_beams(NULL, box, beams, count, phase, peak, 0, Z, out);
    return out;
}

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance)) {
        fail_msg("%.9g, expected %.9g within %g", found, expected, tolerance);
    }
}

/* ---- beams ---- */

/* Directions in float: cosines are off by 2^-23, of which a lobe of g = 0.8 makes the derivative of
 * its value, up to 3 g / (1 - g)^2 = 60, times as much. */
static void what_is_seen_of_beams_is_the_phase_function(void **state)
{
    (void)state;
    const air_phase phases[5] = {hg(0.8f), hg(-0.5f), rayleigh, even, mixture(&haze)};
    float *const fluence = make_fluence();
    for (int n = 0; n < 20; n++) {
        const air_seen_box box = make_box(n % 2 == 1);
        const air_seen_beam beams[2] = {make_beam(n / 2 % 2 == 1, 1.0f, fluence),
                                        make_beam(false, 1.0f, fluence)};
        const air_phase phase = phases[n / 4];
        float *const found = see(&box, beams, 2, phase, NULL);
        for (size_t cell = 0; cell < CELLS; cell++) {
            double value = 0.0;
            for (int b = 0; b < 2; b++) {
                const double cosine = cosine_between(&box, &beams[b], cell);
                value += (double)air_phase_eval(phase, (float)cosine);
            }
            for (size_t c = 0; c < 3; c++) {
                const double light = (double)(beams[0].power[c] * fluence[cell * CHANNELS + c]);
                assert_near((double)found[cell * CHANNELS + c], light * value,
                            2e-5 * light * value);
            }
            assert_true(found[cell * CHANNELS + 3] == 0.0f);
        }
        free(found);
    }
    free(fluence);
}

/* A spread beam's light, convolved with the phase function: of two HG the means multiply; else by
 * quadrature over the sphere about the observer's direction. */
static double convolved(air_phase phase, double lobe, double cosine)
{
    enum { POLAR = 400, AROUND = 400 };
    const double sine = sqrt(1.0 - cosine * cosine);
    double sum = 0.0;
    for (int i = 0; i < POLAR; i++) {
        const double mu = 2.0 * (i + 0.5) / POLAR - 1.0, s = sqrt(1.0 - mu * mu);
        for (int k = 0; k < AROUND; k++) {
            const double between = mu * cosine + s * sine * cos(2.0 * AIR_PI * (k + 0.5) / AROUND);
            const double d = 1.0 + lobe * lobe - 2.0 * lobe * between;
            sum += (1.0 - lobe * lobe) / (d * sqrt(d)) * (double)phase_eval(phase, (float)mu) /
                   (POLAR * AROUND);
        }
    }
    return sum; /* 4 pi of solid angle over 4 pi of the lobe */
}

static void lobes_widen_phase_functions(void **state)
{
    (void)state;
    const air_phase phases[4] = {hg(0.7f), rayleigh, even, mixture(&haze)};
    const air_seen_box box = make_box(false);
    float *const fluence = make_fluence();
    for (int n = 0; n < 4; n++) {
        const air_seen_beam beam = make_beam(false, 0.6f, fluence);
        float *const found = see(&box, &beam, 1, phases[n], NULL);
        for (size_t cell = 0; cell < CELLS; cell += 97) {
            const double cosine = cosine_between(&box, &beam, cell);
            const double light = (double)(beam.power[1] * fluence[cell * CHANNELS + 1]);
            /* midpoints on 400 x 400: 1e-4 */
            assert_near((double)found[cell * CHANNELS + 1] / light,
                        convolved(phases[n], 0.6, cosine), 2e-4);
        }
        free(found);
    }
    free(fluence);
}

/* ---- moments ---- */

/* Radiance is a random series; factors 1 make it what is seen. */
static void moments_reproduce_their_field(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 8);
    for (int bands = 1; bands <= MOST_BANDS; bands += 2) {
        const air_seen_box box = make_box(bands % 4 == 1);
        const size_t count = (size_t)(bands * bands);
        float *const moments = numbers(CELLS * count * CHANNELS);
        float *const found = numbers(CELLS * CHANNELS);
        double factors[MOST_BANDS];
        for (int l = 0; l < bands; l++) {
            factors[l] = l % 2 == 0 ? 1.0 : -0.5;
        }
        for (size_t i = 0; i < CELLS * count * CHANNELS; i++) {
            moments[i] = (float)random_between(&rng, -1.0, 1.0);
        }
        air_seen_moments(NULL, &box, bands, moments, factors, 0, Z, found);
        for (size_t cell = 0; cell < CELLS; cell++) {
            double v[3], y[AIR_SH_COUNT_MAX], sum = 0.0;
            way_to(&box, cell, box.distant, box.observer, v);
            air_sh_evaluate(bands, v, y);
            for (int l = 0, m = 0; l < bands; l++) {
                for (; m < (l + 1) * (l + 1); m++) {
                    sum += factors[l] * y[m] *
                           (double)moments[(cell * count + (size_t)m) * CHANNELS + 2];
                }
            }
            /* 121 numbers of up to 5, whose directions are off by 2^-23, of slopes to 11 times */
            assert_near((double)found[cell * CHANNELS + 2], sum, 1e-4);
        }
        free(moments);
        free(found);
    }
}

/* Eleven bands of g = 0.5 x 0.6 leave the sum of (2l+1)/(4 pi) g^l from 11 on: 5e-6. */
static void moments_of_beams_show_what_beams_do(void **state)
{
    (void)state;
    float *const fluence = make_fluence();
    for (int n = 0; n < 4; n++) {
        const air_seen_box box = make_box(n % 2 == 1);
        const air_seen_beam beam = make_beam(n / 2 == 1, 0.6f, fluence);
        float *const expected = see(&box, &beam, 1, hg(0.5f), NULL);
        double last = INFINITY;
        for (int bands = 3; bands <= MOST_BANDS; bands += 4) {
            const size_t count = (size_t)(bands * bands);
            float *const moments = numbers(CELLS * count * CHANNELS);
            float *const found = numbers(CELLS * CHANNELS);
            double factors[MOST_BANDS], most = 0.0;
            for (int l = 0; l < bands; l++) {
                factors[l] = pow(0.5, l);
            }
            air_beam_moments(NULL, &box, &beam, 1, bands, 0, Z, moments);
            air_seen_moments(NULL, &box, bands, moments, factors, 0, Z, found);
            for (size_t i = 0; i < CELLS * CHANNELS; i++) {
                most = fmax(most, fabs((double)found[i] - (double)expected[i]));
            }
            assert_true(most < 0.05 * last);
            assert_true(bands < 11 || most < 2.0 * 6e-6);
            last = most;
            free(moments);
            free(found);
        }
        free(expected);
    }
    free(fluence);
}

/* ---- peaks ---- */

/* min(f, cap) ahead of where it begins, and f behind, over the sphere. */
static double below(air_phase phase, double lobe, double cap)
{
    enum { POINTS = 200000 };
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        /* cosines crowd ahead: cos = 1 - 2 t^3 */
        const double t = (i + 0.5) / POINTS, mu = 1.0 - 2.0 * t * t * t;
        double value = 0.0;
        if (phase.kind == AIR_PHASE_MIXTURE) {
            for (size_t n = 0; n < phase.mixture->lobe_count; n++) {
                const air_phase_lobe *const l = &phase.mixture->lobes[n];
                const double g = l->kind == AIR_PHASE_HG ? (double)l->g * lobe : 0.0;
                const double d = 1.0 + g * g - 2.0 * g * mu, band = 1.5 * mu * mu - 0.5;
                value += (double)l->weight / (4.0 * AIR_PI) *
                         (l->kind == AIR_PHASE_RAYLEIGH ? 1.0 + 0.5 * lobe * lobe * band
                                                        : (1.0 - g * g) / (d * sqrt(d)));
            }
        } else {
            const double g = (double)phase.g * lobe, d = 1.0 + g * g - 2.0 * g * mu;
            value = (1.0 - g * g) / (4.0 * AIR_PI * d * sqrt(d));
        }
        sum += 2.0 * AIR_PI * (mu > 0.0 ? fmin(value, cap) : value) * 6.0 * t * t / POINTS;
    }
    return sum;
}

static void the_cap_cuts_off_its_share(void **state)
{
    (void)state;
    static const double gs[4] = {0.3, 0.7, 0.9, 0.98}, lobe_of[3] = {1.0, 0.8, 0.3};
    for (int n = 0; n < 12; n++) {
        const double g = gs[n % 4], lobe = lobe_of[n / 4];
        for (int bands = 3; bands <= 8; bands++) {
            const double share = pow(g * lobe, bands);
            const float cap = air_seen_cap(hg((float)g), (float)lobe, share);
            assert_near(below(hg((float)g), lobe, (double)cap), 1.0 - share, 2e-6);
        }
    }
    for (int n = 0; n < 4; n++) {
        const air_phase phase = mixture(n < 2 ? &haze : &both_ways);
        const double lobe = n % 2 == 0 ? 1.0 : 0.7, share = n < 2 ? 0.12 : 0.2;
        const float cap = air_seen_cap(phase, (float)lobe, share);
        assert_near(below(phase, lobe, (double)cap), 1.0 - share, 2e-6);
    }
}

/* A share of 0 is no peak: the cap is the value straight ahead. */
static void without_a_share_there_is_no_peak(void **state)
{
    (void)state;
    const air_seen_box box = make_box(false);
    float *const fluence = make_fluence();
    const air_seen_beam beam = make_beam(true, 1.0f, fluence);
    const air_seen_peak none = {0.0, 3.0, NULL};
    float *const a = see(&box, &beam, 1, hg(0.8f), NULL);
    float *const b = see(&box, &beam, 1, hg(0.8f), &none);
    assert_memory_equal(a, b, CELLS * CHANNELS * sizeof *a);
    assert_near((double)air_seen_cap(hg(0.8f), 1.0f, 0.0), (double)phase_eval(hg(0.8f), 1.0f),
                1e-5);
    free(a);
    free(b);
    free(fluence);
}

/* Light goes on straight ahead through a slab to the observer. Of events in the peak, a share f of
 * all, none counts on the way (depth tau' = (1 - f) tau); shown each time they happen they would
 * add up to more than there is. What is let through with them less what is let through without is
 * seen, times the peak's height over its share. */
static void the_peak_is_shown_once(void **state)
{
    (void)state;
    const double tau = 6.0, g = 0.9, share = pow(g, 4.0), scaled = tau * (1.0 - share);
    const air_seen_box box = {{X, 1, 1}, {1.0f / X, 1.0f, 1.0f}, true, {1.0f, 0.0f, 0.0f}};
    float fluence[X * CHANNELS], depth[X], seen[X * CHANNELS] = {0}, dull[X * CHANNELS] = {0};
    for (int i = 0; i < X; i++) {
        const double at = scaled * (i + 0.5) / X;
        depth[i] = (float)(scaled - at);
        for (int c = 0; c < CHANNELS; c++) {
            fluence[i * CHANNELS + c] = (float)exp(-at);
        }
    }
    air_seen_beam beam = {false, false, {1, 0, 0}, {1, 1, 1}, 1.0f, fluence};
    const air_seen_peak peak = {share, share / (1.0 - share), depth};
    air_seen_beams(NULL, &box, &beam, 1, hg((float)g), &peak, 0, 1, seen);
    beam.peakless = true;
    air_seen_beams(NULL, &box, &beam, 1, hg((float)g), &peak, 0, 1, dull);
    double sum = 0.0;
    const double cap = (double)air_seen_cap(hg((float)g), 1.0f, share);
    for (int i = 0; i < X; i++) {
        assert_near((double)dull[i * CHANNELS], cap * (double)fluence[i * CHANNELS], 1e-6);
        sum += tau / X * exp(-(double)depth[i]) * (double)(seen[i * CHANNELS] - dull[i * CHANNELS]);
    }
    const double height = (1.0 + g) / (4.0 * AIR_PI * (1.0 - g) * (1.0 - g));
    const double expected = (height - cap) / share * (exp(-scaled) - exp(-tau));
    /* the value straight ahead in float: 1 + g^2 - 2 g is 0.01 of sums of 2, to 2^-24 */
    assert_near(sum / expected, 1.0, 3e-5);
}

/* Light from behind keeps its peak, wherever there is one: it does not go on. */
static void peaks_backwards_stay(void **state)
{
    (void)state;
    const air_seen_box box = {{X, 1, 1}, {1.0f / X, 1.0f, 1.0f}, true, {-1.0f, 0.0f, 0.0f}};
    float fluence[X * CHANNELS], depth[X], seen[X * CHANNELS] = {0};
    for (int i = 0; i < X; i++) {
        depth[i] = 2.0f;
        for (int c = 0; c < CHANNELS; c++) {
            fluence[i * CHANNELS + c] = 0.25f;
        }
    }
    for (int peakless = 0; peakless < 2; peakless++) {
        const air_seen_beam beam = {false, peakless == 1, {1, 0, 0}, {1, 1, 1}, 1.0f, fluence};
        const air_seen_peak peak = {0.2, 3.0, depth};
        memset(seen, 0, sizeof seen);
        air_seen_beams(NULL, &box, &beam, 1, mixture(&both_ways), &peak, 0, 1, seen);
        const double value = (double)air_phase_eval(mixture(&both_ways), -1.0f);
        assert_near((double)seen[0], 0.25 * value, 1e-5);
    }
}

/* ---- ranges ---- */

static void parts_give_the_same_bytes_and_nothing_else(void **state)
{
    (void)state;
    enum { BANDS = 4 };
    const air_seen_box box = make_box(false);
    float *const fluence = make_fluence();
    const air_seen_beam beams[2] = {make_beam(true, 0.7f, fluence),
                                    make_beam(false, 1.0f, fluence)};
    const size_t numbers_of[2] = {CELLS * CHANNELS, CELLS * BANDS * BANDS * CHANNELS};
    const double factors[BANDS] = {1.0, 0.7, 0.4, 0.2};
    float *const depth = numbers(CELLS);
    const air_seen_peak peak = {0.2, 0.5, depth};
    float *light[2], *moments[2];
    for (int n = 0; n < 2; n++) {
        light[n] = numbers(numbers_of[0]);
        moments[n] = numbers(numbers_of[1]);
    }
    air_beam_moments(NULL, &box, beams, 2, BANDS, 0, Z, moments[0]);
    air_seen_beams(NULL, &box, beams, 2, mixture(&haze), &peak, 0, Z, light[0]);
    air_seen_moments(NULL, &box, BANDS, moments[0], factors, 0, Z, light[0]);
    for (size_t part = 0; part < Z; part++) {
        const size_t k = (part + 2) % Z, slab = X * Y * CHANNELS;
        air_beam_moments(NULL, &box, beams, 2, BANDS, k, k + 1, moments[1]);
        air_seen_beams(NULL, &box, beams, 2, mixture(&haze), &peak, k, k + 1, light[1]);
        air_seen_moments(NULL, &box, BANDS, moments[0], factors, k, k + 1, light[1]);
        const size_t next = (part + 3) % Z;
        for (size_t i = next * slab; part + 1 < Z && i < (next + 1) * slab; i++) {
            assert_true(light[1][i] == 0.0f);
        }
    }
    assert_memory_equal(light[0], light[1], numbers_of[0] * sizeof(float));
    assert_memory_equal(moments[0], moments[1], numbers_of[1] * sizeof(float));
    for (int n = 0; n < 2; n++) {
        free(light[n]);
        free(moments[n]);
    }
    free(depth);
    free(fluence);
}

/* Cells that the observer or a light is in the middle of have no direction to it: numbers, still.
 */
static void cells_at_the_observer_and_the_light_have_numbers(void **state)
{
    (void)state;
    air_seen_box box = make_box(false);
    float *const fluence = make_fluence();
    air_seen_beam beam = make_beam(true, 0.9f, fluence);
    for (int k = 0; k < 3; k++) {
        box.observer[k] = 1.5f * box.cell_m[k];
        beam.dir[k] = 2.5f * box.cell_m[k];
    }
    float *const depth = numbers(CELLS);
    const air_seen_peak peak = {0.5, 1.0, depth};
    memset(fluence, 0, CHANNELS * sizeof *fluence); /* nor where no light comes */
    float *const found = see(&box, &beam, 1, hg(0.9f), &peak);
    for (size_t i = 0; i < CELLS * CHANNELS; i++) {
        assert_true(isfinite(found[i]) && found[i] >= 0.0f);
    }
    free(found);
    free(depth);
    free(fluence);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_seen_of_beams_is_the_phase_function),
        cmocka_unit_test(lobes_widen_phase_functions),
        cmocka_unit_test(moments_reproduce_their_field),
        cmocka_unit_test(moments_of_beams_show_what_beams_do),
        cmocka_unit_test(the_cap_cuts_off_its_share),
        cmocka_unit_test(without_a_share_there_is_no_peak),
        cmocka_unit_test(the_peak_is_shown_once),
        cmocka_unit_test(peaks_backwards_stay),
        cmocka_unit_test(parts_give_the_same_bytes_and_nothing_else),
        cmocka_unit_test(cells_at_the_observer_and_the_light_have_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

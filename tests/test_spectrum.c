#include <math.h>
#include <string.h>

#include "cmocka_test.h"
#include "scene/import/spectrum.h"
#include "scene/import/spectrum_observer.h"

enum { FIRST = AIR_OBSERVER_FIRST_NM, STEP = AIR_OBSERVER_STEP_NM, ROWS = AIR_OBSERVER_COUNT };

/* The inverse of sRGB's matrix as [IEC61966-2-1] gives it. */
static void xyz_from_rgb(const float rgb[3], double xyz[3])
{
    static const double matrix[3][3] = {{0.412453, 0.357580, 0.180423},
                                        {0.212671, 0.715160, 0.072169},
                                        {0.019334, 0.119193, 0.950227}};
    for (int i = 0; i < 3; ++i)
        xyz[i] = matrix[i][0] * (double)rgb[0] + matrix[i][1] * (double)rgb[1] +
                 matrix[i][2] * (double)rgb[2];
}

static void expect_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g is not within %g of %.9g", value, tolerance, expected);
}

static void expect_rgb(const float rgb[3], double r, double g, double b, double tolerance)
{
    expect_near((double)rgb[0], r, tolerance);
    expect_near((double)rgb[1], g, tolerance);
    expect_near((double)rgb[2], b, tolerance);
}

/* One lobe of the fit of [Wyman2013]: a Gaussian of two widths. */
static double lobe(double nm, double mean, double low_width, double high_width)
{
    const double t = (nm - mean) / (nm < mean ? low_width : high_width);
    return exp(-0.5 * t * t);
}

static void fitted_observer(double nm, double out[3])
{
    out[0] = 1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7) -
             0.065 * lobe(nm, 501.1, 20.4, 26.2);
    out[1] = 0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1);
    out[2] = 1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8);
}

/* The table against an independent fit, which is within 0.016 of x and y and 0.03 of z: a wrong
 * digit anywhere would stand out. */
static void the_observer_is_that_of_1931(void **state)
{
    (void)state;
    double sums[4] = {0.0};
    for (int i = 0; i < ROWS; ++i) {
        double fit[3];
        fitted_observer(FIRST + STEP * i, fit);
        for (int k = 0; k < 3; ++k) {
            expect_near(air_observer[i][k], fit[k], k == 2 ? 0.03 : 0.016);
            sums[k] += STEP * air_observer[i][k];
        }
        sums[3] += STEP * air_observer[i][1] * air_observer[i][3];
    }
    /* the three functions have one area, 106.857 nm for y */
    expect_near(sums[1], 106.857, 1e-3);
    expect_near(sums[0], sums[1], 0.01);
    expect_near(sums[2], sums[1], 0.04);
    /* chromaticity of D65: 0.3127, 0.3290 */
    double xyz[3] = {0.0};
    for (int i = 0; i < ROWS; ++i) {
        for (int k = 0; k < 3; ++k)
            xyz[k] += air_observer[i][k] * air_observer[i][3];
    }
    const double sum = xyz[0] + xyz[1] + xyz[2];
    expect_near(xyz[0] / sum, 0.3127, 5e-5);
    expect_near(xyz[1] / sum, 0.3290, 5e-5);
}

static void surfaces_are_seen_in_daylight(void **state)
{
    (void)state;
    static const float nm[] = {300.0f, 900.0f}, half[] = {0.5f, 0.5f}, two[] = {2.0f, 2.0f};
    float rgb[3];
    air_spectrum_reflectance_rgb(nm, half, 2, rgb);
    expect_rgb(rgb, 0.5, 0.5, 0.5, 1e-4); /* sRGB's matrix has its white to that */
    air_spectrum_reflectance_rgb(nm, two, 2, rgb);
    expect_rgb(rgb, 1.0, 1.0, 1.0, 0.0);
    air_spectrum_reflectance_rgb(nm, half, 1, rgb); /* a point has no width */
    expect_rgb(rgb, 0.0, 0.0, 0.0, 0.0);
    static const float outside[] = {830.0f, 1000.0f};
    air_spectrum_reflectance_rgb(outside, half, 2, rgb);
    expect_rgb(rgb, 0.0, 0.0, 0.0, 0.0);
}

static void lights_of_equal_energy_have_luminance_one(void **state)
{
    (void)state;
    static const float nm[] = {360.0f, 830.0f}, ones[] = {1.0f, 1.0f};
    float rgb[3];
    double xyz[3];
    air_spectrum_emission_rgb(nm, ones, 2, rgb);
    xyz_from_rgb(rgb, xyz);
    for (int k = 0; k < 3; ++k) /* of x and z: 1.0001 and 1.0003; of the matrix: 6 digits */
        expect_near(xyz[k], 1.0, 5e-4);
    /* D65 is white as a light too */
    float d65_nm[ROWS], d65[ROWS];
    for (int i = 0; i < ROWS; ++i) {
        d65_nm[i] = (float)(FIRST + STEP * i);
        d65[i] = (float)air_observer[i][3];
    }
    air_spectrum_emission_rgb(d65_nm, d65, ROWS, rgb);
    expect_rgb(rgb, (double)rgb[1], (double)rgb[1], (double)rgb[1], 1e-3 * (double)rgb[1]);
}

/* What the rgb variants of Mitsuba 3.9.1 make of spectra, read off its parameters. Its own sums
 * have a thousand steps, and its D65 is 0.11 % darker than 1, which is taken into account. */
static void spectra_are_those_of_mitsuba(void **state)
{
    (void)state;
    static const float nm[] = {400.0f, 500.0f, 600.0f, 700.0f};
    static const float lamp[] = {0.0f, 8.0f, 15.6f, 18.4f};
    static const float wood_nm[] = {400.0f, 500.0f, 700.0f}, wood[] = {0.3f, 0.5f, 0.9f};
    float rgb[3];
    air_spectrum_emission_rgb(nm, lamp, 4, rgb);
    expect_near((double)rgb[0] / 20.7108, 1.0, 1e-3);
    expect_near((double)rgb[1] / 10.8546, 1.0, 1e-3);
    expect_near((double)rgb[2] / 2.77115, 1.0, 1e-3);
    air_spectrum_reflectance_rgb(wood_nm, wood, 3, rgb);
    expect_near((double)rgb[0] * 0.99889 / 0.781092, 1.0, 1e-3);
    expect_near((double)rgb[1] * 0.99889 / 0.585800, 1.0, 1e-3);
    expect_near((double)rgb[2] * 0.99889 / 0.380098, 1.0, 1e-3);
}

/* Points on its lines do not change a spectrum: each piece is integrated exactly. */
static void points_between_change_nothing(void **state)
{
    (void)state;
    static const float nm[] = {401.0f, 533.0f, 533.0f, 702.5f},
                       values[] = {1.0f, 0.25f, 0.0f, 3.0f};
    static const float finer_nm[] = {401.0f, 467.0f, 533.0f, 533.0f, 575.375f, 702.5f};
    static const float finer[] = {1.0f, 0.625f, 0.25f, 0.0f, 0.75f, 3.0f};
    float a[3], b[3];
    air_spectrum_emission_rgb(nm, values, 4, a);
    air_spectrum_emission_rgb(finer_nm, finer, 6, b);
    expect_rgb(a, (double)b[0], (double)b[1], (double)b[2], 1e-6); /* a rounding of floats */
}

/* Planckian chromaticities to the digits that tables have, 1e-4 for c2 of theirs or ours; and the
 * candela of 1948, by which platinum at its freezing point, 2042 K, has 60 cd/cm^2: within 1 %, for
 * a degree more or less and the 683 lm/W of now [Wyszecki2000]. */
static void black_bodies_have_their_colors(void **state)
{
    (void)state;
    static const double known[][3] = {{2500, 0.4770, 0.4137},
                                      {4000, 0.3805, 0.3768},
                                      {6500, 0.3135, 0.3237},
                                      {10000, 0.2807, 0.2884}};
    float rgb[3];
    double xyz[3];
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i) {
        air_blackbody_rgb((float)known[i][0], 2.0f, rgb);
        xyz_from_rgb(rgb, xyz);
        const double sum = xyz[0] + xyz[1] + xyz[2];
        expect_near(xyz[0] / sum, known[i][1], 2e-4);
        expect_near(xyz[1] / sum, known[i][2], 2e-4);
    }
    air_blackbody_rgb(2042.0f, 1.0f, rgb);
    xyz_from_rgb(rgb, xyz);
    expect_near(xyz[1] * 683.0 * 106.857 / 6e5, 1.0, 0.01);
}

static double normal_reflectance(double eta, double k)
{
    return ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
}

/* Against what others publish as the colours of clean metals in linear sRGB [Hoffman2013]: they
 * average reflectances, Mitsuba averages indices, in a light of equal energy. 0.07 holds both. */
static void metals_reflect_as_metals_do(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double rgb[3];
    } known[] = {{"Au", {1.000, 0.766, 0.336}},       {"Ag", {0.972, 0.960, 0.915}},
                 {"Al", {0.913, 0.921, 0.925}},       {"Cu", {0.955, 0.638, 0.538}},
                 {"Cu_palik", {0.955, 0.638, 0.538}}, {"none", {1.0, 1.0, 1.0}}};
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i) {
        float eta[3], k[3];
        assert_true(air_metal_find(known[i].name, eta, k));
        for (int c = 0; c < 3; ++c)
            expect_near(normal_reflectance((double)eta[c], (double)k[c]), known[i].rgb[c], 0.07);
    }
}

static void all_names_are_known(void **state)
{
    (void)state;
    static const char *const names[] = {
        "a-C",  "Ag",      "Al",       "AlAs", "AlSb",     "Au",   "Be",  "Cr",         "CsI",
        "Cu",   "Cu2O",    "CuO",      "d-C",  "Hg",       "HgTe", "Ir",  "K",          "Li",
        "MgO",  "Mo",      "Na_palik", "Nb",   "Ni_palik", "Rh",   "Se",  "Se-e_palik", "SiC",
        "SnTe", "Ta",      "Te",       "Te-e", "ThF4",     "TiC",  "TiN", "TiO2",       "TiO2-e",
        "VC",   "V_palik", "VN",       "W",    "Na",       "Ni",   "V",   "none"};
    float eta[3], k[3];
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        if (!air_metal_find(names[i], eta, k))
            fail_msg("%s is not known", names[i]);
        for (int c = 0; c < 3; ++c)
            assert_true(eta[c] > 0.0f && k[c] >= 0.0f);
    }
    assert_false(air_metal_find("au", eta, k));
    assert_false(air_metal_find("", eta, k));
    assert_false(air_metal_find("_palik", eta, k));
    assert_false(air_metal_find("Unobtainium", eta, k));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_observer_is_that_of_1931),
        cmocka_unit_test(surfaces_are_seen_in_daylight),
        cmocka_unit_test(lights_of_equal_energy_have_luminance_one),
        cmocka_unit_test(spectra_are_those_of_mitsuba),
        cmocka_unit_test(points_between_change_nothing),
        cmocka_unit_test(black_bodies_have_their_colors),
        cmocka_unit_test(metals_reflect_as_metals_do),
        cmocka_unit_test(all_names_are_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include "scene/import/spectrum.h"

#include <math.h>

#include "scene/import/spectrum_observer.h"

enum { RED, GREEN, BLUE };

static const double first_nm = AIR_OBSERVER_FIRST_NM;
static const double last_nm =
    AIR_OBSERVER_FIRST_NM + AIR_OBSERVER_STEP_NM * (AIR_OBSERVER_COUNT - 1);

typedef enum spectrum_light { LIGHT_EQUAL, LIGHT_D65 } spectrum_light;

/* The observer at a wavelength, in that light; its table is linear between the rows. */
static void observe(double nm, spectrum_light light, double out[3])
{
    const double place = (nm - first_nm) / AIR_OBSERVER_STEP_NM;
    int row = (int)place;
    row = row < 0 ? 0 : row > AIR_OBSERVER_COUNT - 2 ? AIR_OBSERVER_COUNT - 2 : row;
    const double share = place - row;
    const double *low = air_observer[row], *high = air_observer[row + 1];
    const double power = light == LIGHT_D65 ? low[3] + share * (high[3] - low[3]) : 1.0;
    for (int k = 0; k < 3; ++k)
        out[k] = power * (low[k] + share * (high[k] - low[k]));
}

/* Adds an interval between two rows of the table by Simpson's rule, which is exact for cubics: for
 * products of a linear spectrum, the observer and an illuminant. `values`: at both ends and between
 * them. */
static void add_interval(double from, double to, const double values[3], spectrum_light light,
                         double xyz[3])
{
    static const double weights[] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
    for (int i = 0; i < 3; ++i) {
        double observer[3];
        observe(from + 0.5 * i * (to - from), light, observer);
        for (int k = 0; k < 3; ++k)
            xyz[k] += weights[i] * (to - from) * values[i] * observer[k];
    }
}

/* The next row's wavelength above this one. */
static double next_row(double nm)
{
    return first_nm +
           AIR_OBSERVER_STEP_NM * (floor((nm - first_nm) / AIR_OBSERVER_STEP_NM + 1e-9) + 1.0);
}

/* A line from one point of a spectrum to the next, over what the observer sees of it. */
static void add_line(const float nm[2], const float values[2], spectrum_light light, double xyz[3])
{
    const double slope = ((double)values[1] - (double)values[0]) / ((double)nm[1] - (double)nm[0]);
    const double end = fmin((double)nm[1], last_nm);
    double from = fmax((double)nm[0], first_nm);
    while (from < end) {
        const double to = fmin(next_row(from), end);
        double at[3];
        for (int i = 0; i < 3; ++i)
            at[i] = (double)values[0] + slope * (from + 0.5 * i * (to - from) - (double)nm[0]);
        add_interval(from, to, at, light, xyz);
        from = to;
    }
}

static void integrate(const float *nm, const float *values, size_t count, spectrum_light light,
                      double xyz[3])
{
    for (size_t i = 0; i + 1 < count; ++i)
        add_line(nm + i, values + i, light, xyz);
}

/* The luminance of a spectrum that is 1 at all wavelengths. */
static double unit_luminance(spectrum_light light)
{
    static const float nm[2] = {AIR_OBSERVER_FIRST_NM,
                                AIR_OBSERVER_FIRST_NM +
                                    AIR_OBSERVER_STEP_NM * (AIR_OBSERVER_COUNT - 1)};
    static const float ones[2] = {1.0f, 1.0f};
    double xyz[3] = {0.0};
    integrate(nm, ones, 2, light, xyz);
    return xyz[1];
}

/* [IEC61966-2-1], and what is out of gamut cut to it. */
static void store_rgb(const double xyz[3], double factor, float out[3])
{
    static const double matrix[3][3] = {{3.240479, -1.537150, -0.498535},
                                        {-0.969256, 1.875991, 0.041556},
                                        {0.055648, -0.204043, 1.057311}};
    for (int k = RED; k <= BLUE; ++k) {
        const double sum = matrix[k][0] * xyz[0] + matrix[k][1] * xyz[1] + matrix[k][2] * xyz[2];
        out[k] = (float)fmax(factor * sum, 0.0);
    }
}

void air_spectrum_reflectance_rgb(const float *nm, const float *values, size_t count, float out[3])
{
    double xyz[3] = {0.0};
    integrate(nm, values, count, LIGHT_D65, xyz);
    store_rgb(xyz, 1.0 / unit_luminance(LIGHT_D65), out);
    for (int k = RED; k <= BLUE; ++k)
        out[k] = fminf(out[k], 1.0f);
}

void air_spectrum_emission_rgb(const float *nm, const float *values, size_t count, float out[3])
{
    double xyz[3] = {0.0};
    integrate(nm, values, count, LIGHT_EQUAL, xyz);
    store_rgb(xyz, 1.0 / unit_luminance(LIGHT_EQUAL), out);
}

/* Planck's law in W/(m^2 sr nm) with the constants of [SI2019]. */
static double planck(double kelvin, double nm)
{
    const double h = 6.62607015e-34, c = 299792458.0, k = 1.380649e-23;
    const double lambda = 1e-9 * nm;
    return 1e-9 * 2.0 * h * c * c / pow(lambda, 5.0) / expm1(h * c / (lambda * k * kelvin));
}

void air_blackbody_rgb(float kelvin, float scale, float out[3])
{
    double xyz[3] = {0.0};
    for (int i = 0; i + 1 < AIR_OBSERVER_COUNT; ++i) {
        const double from = first_nm + AIR_OBSERVER_STEP_NM * i;
        double values[3];
        for (int k = 0; k < 3; ++k)
            values[k] = planck((double)kelvin, from + 0.5 * AIR_OBSERVER_STEP_NM * k);
        add_interval(from, from + AIR_OBSERVER_STEP_NM, values, LIGHT_EQUAL, xyz);
    }
    store_rgb(xyz, (double)scale / unit_luminance(LIGHT_EQUAL), out);
}

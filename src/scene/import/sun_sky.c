#include "scene/import/sun_sky.h"

#include <string.h>

#include "core/vec.h"
#include "scene/import/spectrum.h"

/* ---- the sky's distribution ---- */

/* Perez's five numbers of luminance and of chromaticity x and y, and what makes the formula's value
 * at the zenith the one that is due there. */
typedef struct perez {
    double a, b, c, d, e;
    double factor;
} perez;

typedef struct sky_model {
    perez luminance, x, y; /* W/(m^2 sr nm), as equal energy would have it; chromaticity */
    air_vec3 sun;          /* in the sky's space */
    air_vec3 ground;       /* radiance that the ground adds, everywhere */
    float scale;
    size_t width;
    float *rgb;
} sky_model;

/* [Preetham1999, eq. 3]: theta from the zenith, gamma from the sun. */
static double perez_value(const perez *p, double cos_theta, double gamma)
{
    const double cos_gamma = cos(gamma);
    return (1.0 + p->a * exp(p->b / cos_theta)) *
           (1.0 + p->c * exp(p->d * gamma) + p->e * cos_gamma * cos_gamma);
}

/* Rows of t and 1, by the five numbers. */
static perez perez_make(const double coefficients[5][2], double t, double zenith, double sun_theta)
{
    double values[5];
    for (int i = 0; i < 5; ++i)
        values[i] = coefficients[i][0] * t + coefficients[i][1];
    perez p = {values[0], values[1], values[2], values[3], values[4], 1.0};
    p.factor = zenith / perez_value(&p, 1.0, sun_theta);
    return p;
}

/* [Preetham1999, section A.2]: a polynomial in turbidity and the sun's angle from the zenith. */
static double zenith_chromaticity(const double m[3][4], double t, double theta)
{
    const double by_turbidity[3] = {t * t, t, 1.0};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
        sum +=
            by_turbidity[i] * (((m[i][0] * theta + m[i][1]) * theta + m[i][2]) * theta + m[i][3]);
    return sum;
}

/* Chromaticity is that of [Preetham1999, section A.2]. The numbers of its luminance are not: with
 * those the logarithm of luminance is 0.41 off (rms over skies of 8 turbidities and 9 elevations)
 * from the simulated skies of [Hosek2012], as Mitsuba 3.9.1 evaluates them. With these, fitted to
 * them by least squares, it is 0.15. */
static void set_distributions(sky_model *model, double turbidity, double theta)
{
    static const double luminance[5][2] = {{-0.0468, -0.9652},
                                           {-0.0830, -0.0654},
                                           {2.9422, -3.0320},
                                           {0.1072, -4.4847},
                                           {-0.0616, 0.6622}};
    static const double x[5][2] = {{-0.0193, -0.2592},
                                   {-0.0665, 0.0008},
                                   {-0.0004, 0.2125},
                                   {-0.0641, -0.8989},
                                   {-0.0033, 0.0452}};
    static const double y[5][2] = {{-0.0167, -0.2608},
                                   {-0.0950, 0.0092},
                                   {-0.0079, 0.2102},
                                   {-0.0441, -1.6537},
                                   {-0.0109, 0.0529}};
    static const double zenith_x[3][4] = {{0.00166, -0.00375, 0.00209, 0.0},
                                          {-0.02903, 0.06377, -0.03202, 0.00394},
                                          {0.11693, -0.21196, 0.06052, 0.25886}};
    static const double zenith_y[3][4] = {{0.00275, -0.00610, 0.00317, 0.0},
                                          {-0.04214, 0.08970, -0.04153, 0.00516},
                                          {0.15346, -0.26756, 0.06670, 0.26688}};
    /* Perez's exponents change their sign below a turbidity of 1.2: the sky is then taken for that
     * of 2, where the fit begins. */
    const double t = fmax(turbidity, 2.0);
    model->luminance = perez_make(luminance, t, 1.0, theta);
    model->x = perez_make(x, t, zenith_chromaticity(zenith_x, t, theta), theta);
    model->y = perez_make(y, t, zenith_chromaticity(zenith_y, t, theta), theta);
}

/* ---- radiance ---- */

static air_vec3 rgb_from_xyy(double x, double y, double luminance)
{
    const double cap_x = x / y * luminance, cap_z = (1.0 - x - y) / y * luminance;
    const double rgb[3] = {3.240479 * cap_x - 1.537150 * luminance - 0.498535 * cap_z,
                           -0.969256 * cap_x + 1.875991 * luminance + 0.041556 * cap_z,
                           0.055648 * cap_x - 0.204043 * luminance + 1.057311 * cap_z};
    return vec3((float)fmax(rgb[0], 0.0), (float)fmax(rgb[1], 0.0), (float)fmax(rgb[2], 0.0));
}

/* Without what the ground adds. */
static air_vec3 radiance(const sky_model *model, air_vec3 dir)
{
    const double cos_theta = (double)dir.y;
    const double gamma = acos(fmin(fmax((double)vec3_dot(dir, model->sun), -1.0), 1.0));
    const double luminance =
        model->luminance.factor * perez_value(&model->luminance, cos_theta, gamma);
    const double x = model->x.factor * perez_value(&model->x, cos_theta, gamma);
    const double y = model->y.factor * perez_value(&model->y, cos_theta, gamma);
    return rgb_from_xyy(x, y, luminance);
}

/* The direction through a place of the image, as in lights/environment.h. */
static air_vec3 image_direction(double u, double v)
{
    const double phi = 2.0 * AIR_PI * (u - 0.5), theta = AIR_PI * v;
    return vec3((float)(sin(phi) * sin(theta)), (float)cos(theta), (float)(-cos(phi) * sin(theta)));
}

static void fill_row(void *user, size_t row, size_t worker)
{
    const sky_model *model = user;
    const size_t height = model->width / 2;
    (void)worker;
    for (size_t i = 0; i < model->width; ++i) {
        const air_vec3 dir = image_direction(((double)i + 0.5) / (double)model->width,
                                             ((double)row + 0.5) / (double)height);
        const air_vec3 sum =
            dir.y > 0.0f ? vec3_add(radiance(model, dir), model->ground) : vec3_set1(0.0f);
        vec3_store(model->rgb + 3 * (row * model->width + i), vec3_scale(sum, model->scale));
    }
}

/* ---- how much there is of it ---- */

/* Irradiance of the sky on the ground, by midpoints: within 0.2 % of its limit. */
static air_vec3 sky_irradiance(const sky_model *model)
{
    enum { RINGS = 32, SECTORS = 64 };
    air_vec3 sum = vec3_set1(0.0f);
    for (int i = 0; i < RINGS * SECTORS; ++i) {
        const double sin2 = (i / SECTORS + 0.5) / RINGS, phi = AIR_PI * (i % SECTORS + 0.5) / 32.0;
        const air_vec3 dir = vec3((float)(sqrt(sin2) * cos(phi)), (float)sqrt(1.0 - sin2),
                                  (float)(sqrt(sin2) * sin(phi)));
        sum = vec3_add(sum, radiance(model, dir));
    }
    return vec3_scale(sum, AIR_PI_F / (RINGS * SECTORS));
}

enum { HOSEK_TURBIDITIES = 7, HOSEK_ELEVATIONS = 8 };

/* How much light, W/(m^2 nm) of equal energy, skies shed on the ground: rows by turbidity, columns
 * by the sun's elevation, over black ground. Measured on the tables of [Hosek2012] as Mitsuba 3.9.1
 * evaluates them, by a quadrature of 24 x 48 directions. */
static const double hosek_turbidity[HOSEK_TURBIDITIES] = {1, 2, 3, 4, 6, 8, 10};
static const double hosek_elevation[HOSEK_ELEVATIONS] = {0, 5, 10, 20, 30, 50, 70, 90};
static const double hosek_irradiance[HOSEK_TURBIDITIES][HOSEK_ELEVATIONS] = {
    {0.0331, 0.0788, 0.1036, 0.1308, 0.1445, 0.1549, 0.1590, 0.1677},
    {0.0330, 0.0827, 0.1108, 0.1433, 0.1610, 0.1732, 0.1777, 0.1891},
    {0.0329, 0.0885, 0.1221, 0.1627, 0.1864, 0.2043, 0.2080, 0.2201},
    {0.0323, 0.0962, 0.1386, 0.1926, 0.2260, 0.2539, 0.2568, 0.2702},
    {0.0319, 0.1066, 0.1616, 0.2355, 0.2876, 0.3424, 0.3472, 0.3583},
    {0.0306, 0.1139, 0.1817, 0.2818, 0.3695, 0.4924, 0.5074, 0.4585},
    {0.0266, 0.1071, 0.1874, 0.3288, 0.4787, 0.8005, 0.8901, 0.6618}};

/* Which interval of ascending knots x lies in, and where in it. */
static size_t find_interval(const double *knots, size_t count, double x, double *share)
{
    size_t i = 0;
    while (i + 2 < count && x >= knots[i + 1])
        ++i;
    *share = (x - knots[i]) / (knots[i + 1] - knots[i]);
    return i;
}

/* Linear between the rows and columns: within 5 % of what they are taken from, 15 % for a sun that
 * sets. */
static double expected_irradiance(double turbidity, double elevation_degrees)
{
    double s, t;
    const size_t i = find_interval(hosek_turbidity, HOSEK_TURBIDITIES, turbidity, &s);
    const size_t j = find_interval(hosek_elevation, HOSEK_ELEVATIONS, elevation_degrees, &t);
    const double *low = &hosek_irradiance[i][j], *high = &hosek_irradiance[i + 1][j];
    return (1.0 - s) * ((1.0 - t) * low[0] + t * low[1]) + s * ((1.0 - t) * high[0] + t * high[1]);
}

/* Instead of the formula of [Preetham1999] for the zenith's luminance, whose skies are up to twice
 * as bright as those of [Hosek2012]. */
static void set_brightness(sky_model *model, double turbidity, double theta)
{
    const double elevation = 90.0 - theta * 180.0 / AIR_PI;
    model->luminance.factor *=
        expected_irradiance(turbidity, elevation) / (double)vec3_luminance(sky_irradiance(model));
}

/* ---- the sun ---- */

/* Irradiance outside the atmosphere, W/(m^2 nm), and what ozone, water and mixed gases absorb, all
 * from [Bird1986, table 1]. */
static const float sun_table[][5] = {
    {360.0f, 0.9759f, 0.0f, 0.0f, 0.0f},        {370.0f, 1.1199f, 0.0f, 0.0f, 0.0f},
    {380.0f, 1.1038f, 0.0f, 0.0f, 0.0f},        {390.0f, 1.0338f, 0.0f, 0.0f, 0.0f},
    {400.0f, 1.4791f, 0.0f, 0.0f, 0.0f},        {410.0f, 1.7013f, 0.0f, 0.0f, 0.0f},
    {420.0f, 1.7404f, 0.0f, 0.0f, 0.0f},        {430.0f, 1.5872f, 0.0f, 0.0f, 0.0f},
    {440.0f, 1.8370f, 0.0f, 0.0f, 0.0f},        {450.0f, 2.0050f, 0.003f, 0.0f, 0.0f},
    {460.0f, 2.0430f, 0.006f, 0.0f, 0.0f},      {470.0f, 1.9870f, 0.009f, 0.0f, 0.0f},
    {480.0f, 2.0270f, 0.014f, 0.0f, 0.0f},      {490.0f, 1.8960f, 0.021f, 0.0f, 0.0f},
    {500.0f, 1.9090f, 0.030f, 0.0f, 0.0f},      {510.0f, 1.9270f, 0.040f, 0.0f, 0.0f},
    {520.0f, 1.8310f, 0.048f, 0.0f, 0.0f},      {530.0f, 1.8910f, 0.063f, 0.0f, 0.0f},
    {540.0f, 1.8980f, 0.075f, 0.0f, 0.0f},      {550.0f, 1.8920f, 0.085f, 0.0f, 0.0f},
    {570.0f, 1.8400f, 0.120f, 0.0f, 0.0f},      {593.0f, 1.7680f, 0.119f, 0.075f, 0.0f},
    {610.0f, 1.7280f, 0.120f, 0.0f, 0.0f},      {630.0f, 1.6580f, 0.090f, 0.0f, 0.0f},
    {656.0f, 1.5240f, 0.065f, 0.0f, 0.0f},      {667.6f, 1.5310f, 0.051f, 0.0f, 0.0f},
    {690.0f, 1.4200f, 0.028f, 0.016f, 0.15f},   {710.0f, 1.3990f, 0.018f, 0.0125f, 0.0f},
    {718.0f, 1.3740f, 0.015f, 1.8f, 0.0f},      {724.4f, 1.3730f, 0.012f, 2.5f, 0.0f},
    {740.0f, 1.2980f, 0.010f, 0.061f, 0.0f},    {752.5f, 1.2690f, 0.008f, 0.0008f, 0.0f},
    {757.5f, 1.2450f, 0.007f, 0.0001f, 0.0f},   {762.5f, 1.2230f, 0.006f, 0.00001f, 4.0f},
    {767.5f, 1.2050f, 0.005f, 0.00001f, 0.35f}, {780.0f, 1.1830f, 0.0f, 0.0006f, 0.0f},
    {800.0f, 1.1480f, 0.0f, 0.036f, 0.0f},      {816.0f, 1.0910f, 0.0f, 1.6f, 0.0f},
    {823.7f, 1.0620f, 0.0f, 2.5f, 0.0f},        {831.5f, 1.0380f, 0.0f, 0.5f, 0.0f}};

enum { SUN_ROWS = sizeof sun_table / sizeof *sun_table };

/* The share that reaches the ground through the air mass m [Preetham1999, section A.1]: past air,
 * aerosols (Angstrom's formula), 0.35 cm of ozone, mixed gases and 2 cm of water. Aerosols are as
 * in the simulated suns that go with the skies of [Hosek2012], fitted to luminances that
 * Mitsuba 3.9.1 has: within 15 % for turbidities of 2 to 8 and suns above 15 degrees. Preetham's
 * own 0.04608 t - 0.04586 dims suns in haze to half of that, which the sky does not gain. */
static double transmittance(const float row[5], double m, double turbidity)
{
    const double lambda = 1e-3 * (double)row[0]; /* micrometres */
    const double beta = 0.0145 * turbidity;
    const double ozone = (double)row[2], water = (double)row[3], gas = (double)row[4];
    const double depth = 0.008735 * pow(lambda, -4.08) * m + beta * pow(lambda, -1.3) * m +
                         0.35 * ozone * m +
                         0.2385 * water * 2.0 * m / pow(1.0 + 20.07 * water * 2.0 * m, 0.45) +
                         1.41 * gas * m / pow(1.0 + 118.93 * gas * m, 0.45);
    return exp(-depth);
}

/* Irradiance across the light of a sun at this angle from the zenith. */
static void sun_irradiance(double theta, double turbidity, float out[3])
{
    /* [Kasten1965] */
    const double m = 1.0 / (cos(theta) + 0.15 * pow(93.885 - theta * 180.0 / AIR_PI, -1.253));
    float nm[SUN_ROWS], values[SUN_ROWS];
    for (int i = 0; i < SUN_ROWS; ++i) {
        nm[i] = sun_table[i][0];
        values[i] = sun_table[i][1] * (float)transmittance(sun_table[i], m, turbidity);
    }
    air_spectrum_emission_rgb(nm, values, SUN_ROWS, out);
}

/* ---- the whole ---- */

static air_status check(air_context *context, const air_sun_sky *sky, air_vec3 sun)
{
    if (!(sky->turbidity >= 1.0f && sky->turbidity <= 10.0f))
        return air_fail(context, AIR_ERROR_ARGUMENT, "sky: turbidity is %g, expected 1 to 10",
                        (double)sky->turbidity);
    for (int k = 0; k < 3; ++k) {
        if (!(sky->albedo[k] >= 0.0f && sky->albedo[k] <= 1.0f))
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "sky: the albedo of the ground is %g, expected 0 to 1",
                            (double)sky->albedo[k]);
    }
    if (!(sky->sky_scale >= 0.0f && sky->sun_scale >= 0.0f))
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "sky: the scales are %g and %g, expected 0 or more", (double)sky->sky_scale,
                        (double)sky->sun_scale);
    if (!vec3_is_finite(sun) || !(sun.y >= 0.0f))
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "sky: the sun's direction is (%g, %g, %g) and its height %g, expected a "
                        "sun above the horizon",
                        (double)sky->sun_dir[0], (double)sky->sun_dir[1], (double)sky->sun_dir[2],
                        (double)sun.y);
    if (sky->width < 2 || sky->width % 2 != 0)
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "sky: the image's width is %zu, expected an even one", sky->width);
    return AIR_OK;
}

/* The world's direction in the space of the sky: the rotation is transposed. */
static air_vec3 to_sky(const float m[9], air_vec3 v)
{
    return vec3_normalize(vec3(m[0] * v.x + m[3] * v.y + m[6] * v.z,
                               m[1] * v.x + m[4] * v.y + m[7] * v.z,
                               m[2] * v.x + m[5] * v.y + m[8] * v.z));
}

/* What the ground reflects and the air sends back again and again, as if from all directions
 * alike. Air reflects 7, 12 and 19 % of light from below: so the sky grows brighter over white
 * ground in the tables of [Hosek2012], within a fifth for turbidities of 2 to 6 and suns at 20 and
 * 60 degrees. */
static air_vec3 ground_radiance(const sky_model *model, const air_sun_sky *sky,
                                const float sun_perpendicular[3])
{
    static const float air[3] = {0.07f, 0.12f, 0.19f};
    const air_vec3 from_sky = sky_irradiance(model);
    const air_vec3 total = vec3_madd(from_sky, model->sun.y, vec3_load(sun_perpendicular));
    air_vec3 share;
    share.x = air[0] * sky->albedo[0] / (1.0f - air[0] * sky->albedo[0]);
    share.y = air[1] * sky->albedo[1] / (1.0f - air[1] * sky->albedo[1]);
    share.z = air[2] * sky->albedo[2] / (1.0f - air[2] * sky->albedo[2]);
    return vec3_scale(vec3_mul(share, total), 1.0f / AIR_PI_F);
}

air_status air_sun_sky_image(air_context *context, const air_sun_sky *sky, float *out_rgb,
                             float out_sun_irradiance[3])
{
    sky_model model = {.sun = to_sky(sky->to_world, vec3_load(sky->sun_dir)),
                       .scale = sky->sky_scale,
                       .width = sky->width,
                       .rgb = out_rgb};
    const air_status status = check(context, sky, model.sun);
    if (status != AIR_OK)
        return status;
    const double theta = acos(fmin((double)model.sun.y, 1.0)), turbidity = (double)sky->turbidity;
    float sun[3];
    sun_irradiance(theta, turbidity, sun);
    set_distributions(&model, turbidity, theta);
    set_brightness(&model, turbidity, theta);
    model.ground = ground_radiance(&model, sky, sun);
    air_parallel_for(context, model.width / 2, fill_row, &model);
    for (int k = 0; k < 3; ++k)
        out_sun_irradiance[k] = sky->sun_scale * sun[k];
    return AIR_OK;
}

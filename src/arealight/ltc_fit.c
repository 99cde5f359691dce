/* ltc_fit.c: the matrix for one alpha and cos_o: a turn in the plane of wo and the normal, after
 * ((a, 0, c), (0, b, 0), (0, 0, 1)). a, b, c and the turn are fitted, to what of the transformed
 * cosine is above the surface, brought to 1. */
#include <math.h>

#include "airlight/area_ltc.h"
#include "core/quadrature.h"
#include "core/vec.h"

/* Directions per axis at which lobe and fit are compared. */
enum { GRID = 24, ALBEDO_GRID = 64, PARAMETERS = 4 };

typedef struct lobe {
    double alpha, wo[3];
    double albedo;
    double tilt; /* of the mean direction from the normal, away from wo below 0 */
} lobe;

/* ---- the lobe ---- */

static double smith(double alpha, const double w[3])
{
    const double tangent2 = (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);
    return 0.5 * (sqrt(1.0 + alpha * alpha * tangent2) - 1.0);
}

static double distribution(double alpha, const double h[3])
{
    const double x = h[0] / alpha, y = h[1] / alpha, q = x * x + y * y + h[2] * h[2];
    return 1.0 / (AIR_PI * alpha * alpha * q * q);
}

/* f cos, and the density with which reflect_visible draws the direction. */
static double lobe_value(const lobe *self, const double wi[3], double *out_pdf)
{
    double h[3], length = 0.0;
    *out_pdf = 0.0;
    if (!(wi[2] > 0.0)) {
        return 0.0;
    }
    for (int k = 0; k < 3; k++) {
        h[k] = wi[k] + self->wo[k];
        length += h[k] * h[k];
    }
    for (int k = 0; k < 3; k++) {
        h[k] /= sqrt(length);
    }
    const double common = distribution(self->alpha, h) / (4.0 * self->wo[2]);
    const double out = smith(self->alpha, self->wo);
    *out_pdf = common / (1.0 + out);
    return common / (1.0 + out + smith(self->alpha, wi));
}

/* wo reflected at a visible normal, for two numbers in [0, 1) [Dupuy2023]. */
static void reflect_visible(const lobe *self, double u, double v, double wi[3])
{
    double s[3] = {self->alpha * self->wo[0], self->alpha * self->wo[1], self->wo[2]};
    const double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (int k = 0; k < 3; k++) {
        s[k] /= length;
    }
    const double phi = 2.0 * AIR_PI * u, up = (1.0 - v) * (1.0 + s[2]), z = up - s[2];
    const double radius = sqrt(fmax(0.0, (1.0 - z) * (1.0 + z)));
    double h[3] = {self->alpha * (radius * cos(phi) + s[0]),
                   self->alpha * (radius * sin(phi) + s[1]), up};
    const double scale = 1.0 / sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double cosine = 0.0;
    for (int k = 0; k < 3; k++) {
        h[k] *= scale;
        cosine += h[k] * self->wo[k];
    }
    for (int k = 0; k < 3; k++) {
        wi[k] = 2.0 * cosine * h[k] - self->wo[k];
    }
}

static lobe lobe_make(double alpha, double cos_o)
{
    lobe out = {.alpha = alpha, .wo = {sqrt(fmax(0.0, 1.0 - cos_o * cos_o)), 0.0, cos_o}};
    double x = 0.0, z = 0.0, node[ALBEDO_GRID], share[ALBEDO_GRID];
    air_gauss_legendre(ALBEDO_GRID, node, share);
    for (int i = 0; i < ALBEDO_GRID; i++) {
        for (int j = 0; j < ALBEDO_GRID; j++) {
            double wi[3], pdf;
            reflect_visible(&out, (i + 0.5) / ALBEDO_GRID, 0.5 * (1.0 + node[j]), wi);
            const double value = lobe_value(&out, wi, &pdf);
            const double weight = pdf > 0.0 ? 0.5 * share[j] * value / pdf / ALBEDO_GRID : 0.0;
            out.albedo += weight;
            x += weight * wi[0];
            z += weight * wi[2];
        }
    }
    out.tilt = atan2(x, z);
    return out;
}

/* ---- the transformed cosine ---- */

typedef struct cosine {
    double a, b, c;
    double sine, cosine; /* of the turn */
    double above;        /* the share above the surface */
} cosine;

static cosine cosine_of(const double parameters[PARAMETERS])
{
    const double a = exp(parameters[0]), b = exp(parameters[1]), c = parameters[2];
    const double sine = sin(parameters[3]), turn_cosine = cos(parameters[3]);
    /* the surface's normal, transformed back, is at this angle to the cosine's axis */
    const double z = turn_cosine - sine * c, x = sine * a;
    return (cosine){a, b, c, sine, turn_cosine, 0.5 * (1.0 + z / sqrt(z * z + x * x))};
}

/* The density of the fit in a direction: the source's where it comes from, times the Jacobian. */
static double cosine_density(const cosine *fit, const double w[3])
{
    /* into the mean direction's frame, then back through the triangle */
    const double x = fit->cosine * w[0] - fit->sine * w[2];
    const double z = fit->sine * w[0] + fit->cosine * w[2];
    const double from[3] = {(x - fit->c * z) / fit->a, w[1] / fit->b, z};
    const double square = from[0] * from[0] + from[1] * from[1] + from[2] * from[2];
    return w[2] > 0.0 && from[2] > 0.0
               ? from[2] / (AIR_PI * fit->a * fit->b * square * square * fit->above)
               : 0.0;
}

/* The integral of |lobe/albedo - fit|^1.5 over directions drawn by the lobe, in one half of it, the
 * other being its mirror image. Lights over a polygon are integrals: over the oracle's polygons the
 * first power is off by 1.2 % of the albedo, 6.8 % at most, this by 0.8 and 2.6 %, the usual third
 * power, which weighs the peak, by 2.2 and 10.8 % (of a fit not cut at the surface). */
static double loss(const lobe *of, const double parameters[PARAMETERS])
{
    const cosine fit = cosine_of(parameters);
    double sum = 0.0;
    for (int i = 0; i < GRID * GRID / 2; i++) {
        double w[3], pdf;
        reflect_visible(of, (i / GRID + 0.5) / GRID, (i % GRID + 0.5) / GRID, w);
        const double p = lobe_value(of, w, &pdf) / of->albedo;
        const double off = fabs(p - cosine_density(&fit, w));
        sum += pdf > 0.0 ? off * sqrt(off) / pdf : 0.0;
    }
    return sum / (GRID * GRID / 2);
}

/* ---- minimisation ---- */

typedef struct vertex {
    double at[PARAMETERS], value;
} vertex;

static void along(const lobe *of, const double centre[], const vertex *from, double step,
                  vertex *out)
{
    for (int k = 0; k < PARAMETERS; k++) {
        out->at[k] = centre[k] + step * (centre[k] - from->at[k]);
    }
    out->value = loss(of, out->at);
}

static void sort(vertex simplex[PARAMETERS + 1])
{
    for (int i = 1; i <= PARAMETERS; i++) {
        for (int k = i; k > 0 && simplex[k].value < simplex[k - 1].value; k--) {
            const vertex swapped = simplex[k];
            simplex[k] = simplex[k - 1];
            simplex[k - 1] = swapped;
        }
    }
}

/* [Nelder1965]; start becomes the best place. */
static void minimise(const lobe *of, double start[PARAMETERS])
{
    enum { MOST_STEPS = 400 };
    const double steps[PARAMETERS] = {0.15, 0.15, 0.05, 0.1 * fmin(1.0, exp(start[0]))};
    vertex simplex[PARAMETERS + 1], tried, further;
    for (int i = 0; i <= PARAMETERS; i++) {
        for (int k = 0; k < PARAMETERS; k++) {
            simplex[i].at[k] = start[k] + (i == k + 1 ? steps[k] : 0.0);
        }
        simplex[i].value = loss(of, simplex[i].at);
    }
    for (int step = 0; step < MOST_STEPS; step++) {
        double centre[PARAMETERS] = {0.0};
        sort(simplex);
        vertex *worst = &simplex[PARAMETERS];
        if (worst->value - simplex[0].value <= 1e-8 * simplex[0].value) {
            break;
        }
        for (int i = 0; i < PARAMETERS; i++) {
            for (int k = 0; k < PARAMETERS; k++) {
                centre[k] += simplex[i].at[k] / PARAMETERS;
            }
        }
        along(of, centre, worst, 1.0, &tried);
        if (tried.value < simplex[0].value) {
            along(of, centre, worst, 2.0, &further);
            *worst = further.value < tried.value ? further : tried;
            continue;
        }
        if (tried.value < simplex[PARAMETERS - 1].value) {
            *worst = tried;
            continue;
        }
        along(of, centre, worst, -0.5, &further);
        if (further.value < worst->value) {
            *worst = further;
            continue;
        }
        for (int i = 1; i <= PARAMETERS; i++) {
            for (int k = 0; k < PARAMETERS; k++) {
                simplex[i].at[k] = 0.5 * (simplex[0].at[k] + simplex[i].at[k]);
            }
            simplex[i].value = loss(of, simplex[i].at);
        }
    }
    sort(simplex);
    for (int k = 0; k < PARAMETERS; k++) {
        start[k] = simplex[0].at[k];
    }
}

/* ---- the fit ---- */

/* The way back, R being the turn to the mean direction: T^-1 R^T, divided by its middle. */
static air_area_ltc matrix_of(const lobe *of, const cosine *fit)
{
    const double s = fit->sine, c = fit->cosine, a = fit->a, b = fit->b, m = fit->c;
    return (air_area_ltc){.xx = b * (c - m * s) / a,
                          .xz = -b * (s + m * c) / a,
                          .zx = b * s,
                          .zz = b * c,
                          .albedo = of->albedo};
}

air_area_ltc air_area_ltc_fit(double alpha, double cos_o)
{
    const double smallest = 1e-3, level = 1e-3;
    const double a = fmin(fmax(alpha, smallest), 1.0), c = fmin(fmax(cos_o, level), 1.0);
    const lobe of = lobe_make(a, c);
    /* a peak as wide as the lobe about its mirror, longer towards grazing */
    double parameters[PARAMETERS] = {log(a), log(a), 0.0, of.tilt};
    minimise(&of, parameters);
    minimise(&of, parameters); /* once more from there: the first simplex may have collapsed */
    if (c == 1.0) {            /* the same all round */
        parameters[0] = parameters[1] = 0.5 * (parameters[0] + parameters[1]);
        parameters[2] = parameters[3] = 0.0;
    }
    const cosine fit = cosine_of(parameters);
    return matrix_of(&of, &fit);
}

/* fit.c: one parameter for each half of the sphere, or two: by symmetry the transformation
 * stretches along the axis only. */
#include <math.h>

#include "airlight/area_table.h"
#include "arealight/gauss.h"
#include "arealight/scatter_lobes.h"
#include "core/vec.h"

/* ---- densities of one half, c the cosine to its pole, in [0, 1] ---- */

/* The half under way: its phase function, normalised, c measured from its own pole. */
typedef struct half_phase {
    double gamma, mass;
    bool near;
} half_phase;

static double phase_r(double gamma, double c)
{
    return sqrt((1.0 - gamma) * (1.0 - gamma) + 2.0 * gamma * (1.0 - c));
}

double air_area_phase_density(double g, double c)
{
    const double gamma = fabs(g), r = phase_r(gamma, c);
    return (1.0 - gamma) * (1.0 + gamma) / (4.0 * AIR_PI * r * r * r);
}

static double half_density(const half_phase *half, double c)
{
    return air_area_phase_density(half->gamma, half->near ? c : -c) / half->mass;
}

/* From the pole down to c. */
static double half_cap(const half_phase *half, double c)
{
    const double gamma = half->near ? half->gamma : -half->gamma;
    const double r = phase_r(gamma, c);
    return (1.0 + gamma) * (1.0 - c) / (r * (r + 1.0 - gamma)) / half->mass;
}

/* A direction before it was stretched, and how much its surroundings were. */
typedef struct stretched {
    double c, density;
} stretched;

static stretched unstretch(double s, double c)
{
    const double square = 1.0 - c * c + c * c / (s * s), length = sqrt(square);
    return (stretched){c / (s * length), 1.0 / (s * square * length)};
}

static double mixture_density(double s, double w, double c)
{
    const stretched at = unstretch(s, c);
    return (0.5 * (1.0 - w) + w * at.c) * at.density / AIR_PI;
}

static double mixture_cap(double s, double w, double c)
{
    const double at = unstretch(s, c).c;
    return (1.0 - at) * ((1.0 - w) + w * (1.0 + at));
}

/* ---- losses ---- */

/* Panels that halve towards the pole, where peaks are. */
enum { PANELS = 18, NODES = 8, POINTS = PANELS * NODES };

typedef struct half_fit {
    half_phase half;
    air_area_loss loss;
    double w;
    double c[POINTS], weight[POINTS];
    double density[POINTS], cap[POINTS]; /* of the phase function */
} half_fit;

static void half_fit_make(double gamma, bool near, air_area_loss loss, half_fit *out)
{
    double x[NODES], v[NODES];
    const double mass = air_near_share(gamma);
    air_area_gauss(NODES, x, v);
    out->half = (half_phase){gamma, near ? mass : 1.0 - mass, near};
    out->loss = loss;
    for (int k = 0; k < PANELS; k++) {
        /* the last one reaches the pole */
        const double begin = 1.0 - ldexp(1.0, -k), half = ldexp(k + 1 < PANELS ? 0.25 : 0.5, -k);
        for (int i = 0; i < NODES; i++) {
            const int j = k * NODES + i;
            out->c[j] = begin + half * (1.0 + x[i]);
            out->weight[j] = half * v[i];
            out->density[j] = half_density(&out->half, out->c[j]);
            out->cap[j] = half_cap(&out->half, out->c[j]);
        }
    }
}

static double loss_at(const half_fit *fit, double s)
{
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        double value;
        if (fit->loss == AIR_AREA_CDF_L2) {
            const double d = fit->cap[i] - mixture_cap(s, fit->w, fit->c[i]);
            value = d * d;
        } else {
            const double p = fit->density[i], d = mixture_density(s, fit->w, fit->c[i]);
            value = fit->loss == AIR_AREA_KL   ? -p * log(d)
                    : fit->loss == AIR_AREA_L2 ? (p - d) * (p - d)
                                               : fabs(p - d) * (p - d) * (p - d);
        }
        sum += fit->weight[i] * value;
    }
    return sum;
}

/* ---- minimisation ---- */

/* [Brent1973, ch. 5]: a parabola through three points where it can be trusted, else the golden
 * section. Where the least value is, in [a, b]. */
static double minimise(double (*f)(void *user, double x), void *user, double a, double b,
                       double *out_least)
{
    enum { MOST_STEPS = 100 };
    const double golden = 0.3819660112501051, tolerance = 1e-9;
    double x = a + golden * (b - a), w = x, v = x, step = 0.0, last = 0.0;
    double fx = f(user, x), fw = fx, fv = fx;
    for (int i = 0; i < MOST_STEPS; i++) {
        const double middle = 0.5 * (a + b), least = tolerance * (fabs(x) + 1.0);
        if (fabs(x - middle) <= 2.0 * least - 0.5 * (b - a)) {
            break;
        }
        double p = 0.0, q = 0.0;
        if (fabs(last) > least) {
            const double r = (x - w) * (fx - fv);
            q = (x - v) * (fx - fw);
            p = (x - v) * q - (x - w) * r;
            q = 2.0 * (q - r);
            p = q > 0.0 ? -p : p;
            q = fabs(q);
        }
        if (q > 0.0 && fabs(p) < fabs(0.5 * q * last) && p > q * (a - x) && p < q * (b - x)) {
            last = step;
            step = p / q;
        } else {
            last = x < middle ? b - x : a - x;
            step = golden * last;
        }
        const double u = x + (fabs(step) >= least ? step : copysign(least, step));
        const double fu = f(user, u);
        if (fu <= fx) {
            (u < x) ? (b = x) : (a = x);
            v = w, fv = fw, w = x, fw = fx, x = u, fx = fu;
        } else {
            (u < x) ? (a = u) : (b = u);
            if (fu <= fw || w == x) {
                v = w, fv = fw, w = u, fw = fu;
            } else if (fu <= fv || v == x || v == w) {
                v = u, fv = fu;
            }
        }
    }
    *out_least = fx;
    return x;
}

static const double least_log_s = -4.0, largest_log_s = 7.0;

static double loss_of_log_s(void *user, double x)
{
    const half_fit *fit = user;
    return loss_at(fit, exp(x));
}

/* s for the w that stands. */
static double fit_s(half_fit *fit, double *out_loss)
{
    return exp(minimise(loss_of_log_s, fit, least_log_s, largest_log_s, out_loss));
}

static double loss_of_w(void *user, double w)
{
    half_fit *fit = user;
    double loss;
    fit->w = w;
    (void)fit_s(fit, &loss);
    return loss;
}

/* A scan first: Brent's method by itself can end in the wrong valley. */
static void fit_both(half_fit *fit, double *out_s, double *out_w)
{
    enum { STEPS = 40 };
    double best = INFINITY, at = 0.0, loss;
    for (int i = 0; i <= STEPS; i++) {
        const double w = -1.0 + 2.0 * i / STEPS, here = loss_of_w(fit, w);
        if (here < best) {
            best = here;
            at = w;
        }
    }
    const double step = 2.0 / STEPS;
    const double w = minimise(loss_of_w, fit, fmax(at - step, -1.0), fmin(at + step, 1.0), &loss);
    fit->w = loss <= best ? w : at;
    *out_w = fit->w;
    *out_s = fit_s(fit, &loss);
}

/* ---- fits ---- */

/* One transformed source for the whole sphere: both halves are judged. */
typedef struct whole_fit {
    half_fit halves[2];
    air_area_source source;
} whole_fit;

static double whole_density(air_area_source source, double s, bool near, double c)
{
    const stretched at = unstretch(s, c);
    if (source == AIR_AREA_SOURCE_UNIFORM) {
        return at.density / (4.0 * AIR_PI);
    }
    return near ? at.c * at.density / AIR_PI : 0.0;
}

/* Of the sphere: the masses of the halves are those of the phase function. */
static double whole_loss(void *user, double x)
{
    const whole_fit *fit = user;
    double sum = 0.0;
    for (int h = 0; h < 2; h++) {
        const half_fit *half = &fit->halves[h];
        for (int i = 0; i < POINTS; i++) {
            const double p = half->density[i] * half->half.mass;
            const double d =
                fabs(p - whole_density(fit->source, exp(x), half->half.near, half->c[i]));
            sum += half->weight[i] * (half->loss == AIR_AREA_L3 ? d * d * d : d * d);
        }
    }
    return sum;
}

static air_area_lobe fit_whole(air_area_source source, air_area_loss loss, double gamma)
{
    whole_fit fit = {.source = source};
    double least;
    half_fit_make(gamma, true, loss, &fit.halves[0]);
    half_fit_make(gamma, false, loss, &fit.halves[1]);
    const double s = exp(minimise(whole_loss, &fit, least_log_s, largest_log_s, &least));
    return (air_area_lobe){.s_near = s, .w_near = 1.0, .s_far = s, .w_far = 1.0};
}

static double within(double gamma) { return gamma < 0.99 ? gamma : 0.99; }

air_area_lobe air_area_fit(air_area_source source, air_area_loss loss, double g)
{
    const double gamma = within(fabs(g));
    air_area_lobe out = {.w_near = 1.0, .w_far = -1.0};
    half_fit fit;
    double least;
    if (source == AIR_AREA_SOURCE_COSINE || source == AIR_AREA_SOURCE_UNIFORM) {
        out = fit_whole(source, loss, gamma);
    } else if (source == AIR_AREA_SOURCE_MIX) {
        half_fit_make(gamma, true, AIR_AREA_CDF_L2, &fit);
        fit_both(&fit, &out.s_near, &out.w_near);
        half_fit_make(gamma, false, AIR_AREA_CDF_L2, &fit);
        fit_both(&fit, &out.s_far, &out.w_far);
    } else {
        half_fit_make(gamma, true, loss, &fit);
        fit.w = out.w_near;
        out.s_near = fit_s(&fit, &least);
        half_fit_make(gamma, false, loss, &fit);
        fit.w = out.w_far;
        out.s_far = fit_s(&fit, &least);
    }
    out.g = copysign(gamma, g);
    return out;
}

double air_area_lobe_density(air_area_source source, const air_area_lobe *lobe, double c)
{
    const double mass = air_near_share(fabs(lobe->g));
    if (source == AIR_AREA_SOURCE_COSINE || source == AIR_AREA_SOURCE_UNIFORM) {
        return whole_density(source, lobe->s_near, c >= 0.0, fabs(c));
    }
    return c >= 0.0 ? mass * mixture_density(lobe->s_near, lobe->w_near, c)
                    : (1.0 - mass) * mixture_density(lobe->s_far, lobe->w_far, -c);
}

void air_area_table_fit(air_area_source source, air_area_loss loss, air_area_table *out)
{
    out->source = source;
    out->loss = source == AIR_AREA_SOURCE_MIX ? AIR_AREA_CDF_L2 : loss;
    for (int k = 0; k < AIR_AREA_KNOTS; k++) {
        out->knots[k] = air_area_fit(source, loss, 0.99 * k / (AIR_AREA_KNOTS - 1));
    }
}

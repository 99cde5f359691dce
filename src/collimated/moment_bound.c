/* moment_bound.c: the Hamburger moment problem for four and six moments [Peters2016, Peters2017].
 *
 * Of all distributions with given moments b_0 .. b_m, the one that has least (and most) mass below
 * a depth z_0 is carried by z_0 and m/2 other points. With p(z) = (1, z, .., z^(m/2)) and the
 * Hankel matrix H_ij = b_(i+j), these are the roots of p(z)' H^-1 p(z_0), the Christoffel-Darboux
 * kernel, and the mass at each of the points is 1 / (p(z)' H^-1 p(z)) [Szegoe1939, theorem 3.4.2];
 * that formula needs no Vandermonde system, and points far out get the weight 0 that they should.
 */
#include "collimated/moment_bound.h"

#include <math.h>
#include <stdbool.h>

#include "core/vec.h"

enum { MOST_ORDER = AIR_MOMENT_MOST / 2 + 1 };

/* Points beyond this, where depths are within [-1, 1], carry less than 1e-12 / bias. */
static const double FAR_OUT = 1e6;

/* H = L L', lower triangle of L in rows; its diagonal holds the reciprocals. */
typedef struct cholesky {
    size_t order;
    double l[MOST_ORDER][MOST_ORDER];
} cholesky;

/* The moments of a spread-out distribution that given ones are drawn towards [Peters2017]: of all
 * even ones those that keep the Hankel matrix best away from singular ones (src/collimated/
 * README-moment.md says what a scan of them gave). */
static const double SPREAD4[5] = {1.0, 0.0, 0.628, 0.0, 0.628};
static const double SPREAD6[7] = {1.0, 0.0, 0.5566, 0.0, 0.489, 0.0, 0.47869};

static void factorise(const double *moments, size_t count, double bias, cholesky *out)
{
    const double *spread = count == 4 ? SPREAD4 : SPREAD6;
    double b[AIR_MOMENT_MOST + 1];
    for (size_t k = 0; k <= count; k++) {
        b[k] = (1.0 - bias) * (moments[k] / moments[0]) + bias * spread[k];
    }
    out->order = count / 2 + 1;
    for (size_t i = 0; i < out->order; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = b[i + j];
            for (size_t k = 0; k < j; k++) {
                sum -= out->l[i][k] * out->l[j][k];
            }
            /* The spread part alone keeps pivots above 0.01 bias; the floor only catches the
             * rounding of a bias below 1e-12. */
            out->l[i][j] = i == j ? 1.0 / sqrt(fmax(sum, 1e-15)) : sum * out->l[j][j];
        }
    }
}

/* y = L^-1 (1, z, z^2, ..): p(z)' H^-1 p(z) is its square. */
static void forward(const cholesky *c, double z, double *y)
{
    double power = 1.0;
    for (size_t i = 0; i < c->order; i++) {
        double sum = power;
        for (size_t k = 0; k < i; k++) {
            sum -= c->l[i][k] * y[k];
        }
        y[i] = sum * c->l[i][i];
        power *= z;
    }
}

/* q = L'^-1 y */
static void backward(const cholesky *c, const double *y, double *q)
{
    for (size_t i = c->order; i-- > 0;) {
        double sum = y[i];
        for (size_t k = i + 1; k < c->order; k++) {
            sum -= c->l[k][i] * q[k];
        }
        q[i] = sum * c->l[i][i];
    }
}

/* The mass of the distribution that has z among its points. */
static double mass_at(const cholesky *c, double z)
{
    if (!(fabs(z) < FAR_OUT)) {
        return 0.0;
    }
    double y[MOST_ORDER], square = 0.0;
    forward(c, z, y);
    for (size_t i = 0; i < c->order; i++) {
        square += y[i] * y[i];
    }
    return 1.0 / square;
}

/* Roots of q[0] + q[1] z + q[2] z^2, which are real: without cancellation; a vanishing q[2] sends
 * one to infinity. */
static void quadratic_roots(const double *q, double *out)
{
    const double root = sqrt(fmax(q[1] * q[1] - 4.0 * q[0] * q[2], 0.0));
    const double s = -0.5 * (q[1] + copysign(root, q[1]));
    out[0] = s / q[2];
    out[1] = s != 0.0 ? q[0] / s : 0.0;
}

/* Roots of q[0] + .. + q[3] z^3, which are real: the trigonometric solution, then two steps of
 * Newton's method for what it lost where one of them is large. */
static void cubic_roots(const double *q, double *out)
{
    if (!(fabs(q[3]) * FAR_OUT > fabs(q[0]) + fabs(q[1]) + fabs(q[2]))) {
        quadratic_roots(q, out);
        out[2] = INFINITY;
        return;
    }
    const double a = q[2] / q[3], b = q[1] / q[3], c = q[0] / q[3];
    const double p = fmax(a * a - 3.0 * b, 0.0) / 9.0;
    const double r = (a * (2.0 * a * a - 9.0 * b) + 27.0 * c) / 54.0;
    const double p15 = p * sqrt(p);
    const double angle = acos(p15 > 0.0 ? fmin(fmax(r / p15, -1.0), 1.0) : 0.0) / 3.0;
    for (int i = 0; i < 3; i++) {
        double z = -2.0 * sqrt(p) * cos(angle + (double)(i - 1) * (2.0 * AIR_PI / 3.0)) - a / 3.0;
        for (int step = 0; step < 2; step++) {
            const double value = c + z * (b + z * (a + z));
            const double slope = b + z * (2.0 * a + 3.0 * z);
            z -= slope != 0.0 ? value / slope : 0.0;
        }
        out[i] = z;
    }
}

double air_moment_bound(const double *moments, size_t count, double bias, double depth,
                        double overestimation)
{
    cholesky c;
    factorise(moments, count, bias, &c);
    double y[MOST_ORDER], q[MOST_ORDER] = {0.0}, roots[MOST_ORDER - 1];
    forward(&c, depth, y);
    backward(&c, y, q);
    if (count == 4) {
        quadratic_roots(q, roots);
    } else {
        cubic_roots(q, roots);
    }
    double below = 0.0;
    for (size_t i = 0; i < count / 2; i++) {
        if (roots[i] < depth) {
            below += mass_at(&c, roots[i]);
        }
    }
    return fmin(below + overestimation * mass_at(&c, depth), 1.0);
}

/* shares.c: shares and moments of lobes, and tables of the upwind ones. */
#include "ordinates/shares.h"

#include "core/quadrature.h"

/* The share of the cone ahead is the cumulative from cos 45 degrees on, 1 - c the height of its
 * cap. With s^2 = 1 + a^2 - 2ac the difference of inverse roots goes over one denominator and the
 * factor a cancels. [Elek2014, eqs. 1, 3] */
static double front_share(double a, double *out_mean)
{
    const double c = 0.70710678118654752440;
    const double s2 = 1.0 + a * a - 2.0 * a * c, s = sqrt(s2);
    const double share = (1.0 + a) * (1.0 - c) / (s2 + s * (1.0 - a));
    *out_mean = share * ((1.0 + c) * (1.0 + a * a) - 2.0 * a * c) / (1.0 + a * a + s * (1.0 - a));
    return share;
}

air_ordinates_shares air_ordinates_shares_of(double a)
{
    air_ordinates_shares out;
    double behind;
    out.front = front_share(a, &out.front_mean);
    out.back = front_share(-a, &behind);
    out.back_mean = -behind;
    out.side = 0.25 * (1.0 - out.front - out.back);
    out.side_mean = 0.25 * (a - out.front_mean - out.back_mean);
    return out;
}

/* ---- upwind shares ---- */

/* The mean of 1/(|x|+|y|+|z|) over the azimuth at cosine m >= 0 to the axis: of an eighth of the
 * circle, 1/(m + R cos psi) with R = sqrt(2 (1-m^2)), by u = tan(psi/2): 2/(m+R) times an arc
 * tangent of z = tan^2(pi/8) (m-R)/(m+R) over its argument. |z| < 0.172: the series to z^19 leaves
 * 0.172^20/41 < 2e-17. */
static double inverse_sum(double m)
{
    const double u = 0.41421356237309504880, big = sqrt(2.0 * double_max(0.0, 1.0 - m * m));
    const double z = u * u * (m - big) / (m + big);
    double sum = 0.0;
    for (int i = 19; i >= 0; i--) {
        sum = 1.0 / (2 * i + 1) - z * sum;
    }
    return 8.0 / AIR_PI * u / (m + big) * sum;
}

enum { NODES = 48 };

typedef struct half_rule {
    double x[NODES], w[NODES]; /* on [0, 1] */
} half_rule;

/* 1, mu and mu^2 over |x|+|y|+|z| of the hemisphere ahead of the lobe. Sharp lobes are integrated
 * in w with sin(theta/2) = b sinh w, b = (1-a)/(2 sqrt a): then s = (1-a) cosh w, and the density,
 * (1-a^2) sin(theta)/(2 s^3) d theta, is (1+a)/(2a) sinh w/cosh^2 w dw, as smooth as can be. */
static void hemisphere(const half_rule *rule, double a, double out[3])
{
    const bool sharp = a > 0.2;
    const double b = sharp ? (1.0 - a) / (2.0 * sqrt(a)) : 1.0;
    const double end = sharp ? asinh(sqrt(0.5) / b) : 0.5 * AIR_PI;
    out[0] = out[1] = out[2] = 0.0;
    for (int i = 0; i < NODES; i++) {
        const double at = end * rule->x[i];
        double mu, density;
        if (sharp) {
            const double sine = b * sinh(at), cosine = cosh(at);
            mu = 1.0 - 2.0 * sine * sine;
            density = (1.0 + a) / (2.0 * a) * sinh(at) / (cosine * cosine);
        } else {
            mu = cos(at);
            const double s2 = 1.0 + a * a - 2.0 * a * mu;
            density = 0.5 * (1.0 - a * a) * sin(at) / (s2 * sqrt(s2));
        }
        const double part = end * rule->w[i] * density * inverse_sum(mu);
        out[0] += part;
        out[1] += part * mu;
        out[2] += part * mu * mu;
    }
}

void ordinates_upwind_tabulate(ordinates_upwind_row *out_rows)
{
    half_rule rule;
    air_gauss_legendre(NODES, rule.x, rule.w);
    for (int i = 0; i < NODES; i++) {
        rule.x[i] = 0.5 + 0.5 * rule.x[i];
        rule.w[i] *= 0.5;
    }
    for (int i = 0; i < ORDINATES_ROWS; i++) {
        const double t = (double)i / (ORDINATES_ROWS - 1), a = 1.0 - t * t;
        double ahead[3] = {1.0, 1.0, 1.0}, behind[3] = {0.0, 0.0, 0.0};
        if (i > 0) {
            hemisphere(&rule, a, ahead);
            hemisphere(&rule, -a, behind);
        }
        out_rows[i].v[0] = ahead[1];
        out_rows[i].v[1] = behind[1];
        out_rows[i].v[2] = ahead[2];
        out_rows[i].v[3] = behind[2];
        out_rows[i].v[4] = ahead[0] + behind[0];
    }
}

/* Sides are formed from what is left: nothing is lost to interpolation. A side's lateral mean is a
 * quarter of (x^2+y^2)/(|x|+|y|+|z|) = path - z^2/(..). */
ordinates_upwind ordinates_upwind_at(const ordinates_upwind_row *rows, double a)
{
    const double at = sqrt(double_max(0.0, 1.0 - fabs(a))) * (ORDINATES_ROWS - 1);
    const int row = (int)double_min(at, ORDINATES_ROWS - 2);
    const double share = at - row;
    double v[ORDINATES_COLUMNS];
    for (int i = 0; i < ORDINATES_COLUMNS; i++) {
        v[i] = rows[row].v[i] + share * (rows[row + 1].v[i] - rows[row].v[i]);
    }
    const int ahead = a < 0.0 ? 1 : 0;
    ordinates_upwind out = {.front = v[ahead],
                            .back = v[1 - ahead],
                            .front_mean = v[2 + ahead],
                            .back_mean = v[3 - ahead],
                            .path = v[4]};
    out.side = 0.25 * (1.0 - out.front - out.back);
    out.side_axial = 0.25 * (a - out.front_mean + out.back_mean);
    out.side_lateral = 0.25 * (out.path - out.front_mean - out.back_mean);
    return out;
}

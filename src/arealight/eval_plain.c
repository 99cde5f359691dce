/* eval_plain.c: S at many points, one after the other: what the versions in lanes are held against.
 *
 * By edges. With a the peak's axis, c = a.w and r^2 = 1 + gamma^2 - 2 gamma c, the phase function
 * has the antiderivative G+(c) of the spec, 0 at the peak; less (1 - c) / (4 pi) it vanishes at
 * both poles, and by Stokes
 *
 *     S = Omega / (4 pi) + sum over edges of Int (G+ - (1 - c) / (4 pi)) dphi
 *       = Omega / (4 pi) + gamma / (2 pi) sum h Int (r + 2) / (r ((r + 1)^2 - gamma^2)) du,
 *
 * u the arc along the edge, h = a.n, n its unit normal: r is never 0, no edge is cut at a horizon
 * and none is special. The integrand is large near the peak only, where the Moebius map of the
 * edge's circle that takes its Poisson kernel to 1, with du = r^2 / D dtheta, D^2 = (1 - gamma^2)^2
 * + 4 gamma^2 h^2, leaves (D + 2 q) / ((D + q)^2 - gamma^2 q^2), q = D / r: between 0.3 and 1.2 for
 * every gamma. q^2 = 1 + gamma^2 + P cos psi + Q sin psi, psi the angle theta from its middle. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "arealight/eval.h"
#include "core/triple.h"

typedef const double (*polygon)[3];

/* a.(b x c), of b and c the difference, which keeps digits where they are close. */
static double triple(const double a[3], const double b[3], const double c[3])
{
    const double edge[3] = {c[0] - b[0], c[1] - b[1], c[2] - b[2]};
    double normal[3];
    air_cross3(b, edge, normal);
    return air_dot3(a, normal);
}

/* Half the signed solid angle of the triangle of these directions, of any lengths. */
static double half_solid_angle(const double a[3], const double b[3], const double c[3])
{
    const double x = air_length3(a), y = air_length3(b), z = air_length3(c);
    return atan2(triple(a, b, c),
                 x * y * z + air_dot3(a, b) * z + air_dot3(b, c) * x + air_dot3(c, a) * y);
}

/* The fan's apex is the foot of the point, or above it: no triangle has opposite corners, except on
 * an edge. */
static double solid_angle(polygon p, size_t count, const double apex[3])
{
    double half = 0.0;
    for (size_t i = 0; i < count; i++) {
        half += half_solid_angle(apex, p[i], p[(i + 1) % count]);
    }
    return 2.0 * half;
}

/* ---- by edges ---- */

/* Along the arc: h, D, P, Q and half of theta's range. */
typedef struct arc {
    double h, d, p, q, half;
} arc;

/* a: the axis; v0, v1: the ends, of any length. False if the arc is none. */
static bool arc_make(double gamma, const double a[3], const double v0[3], const double v1[3],
                     arc *out)
{
    const double edge[3] = {v1[0] - v0[0], v1[1] - v0[1], v1[2] - v0[2]};
    double n[3];
    air_cross3(v0, edge, n);
    const double size = air_length3(n), lengths = air_length3(v0) * air_length3(v1);
    if (!(size > DBL_MIN)) {
        return false;
    }
    const double sine = size / lengths, cosine = air_dot3(v0, v1) / lengths;
    const double angle = atan2(sine, cosine), sm = sin(0.5 * angle), cm = cos(0.5 * angle);
    const double z0 = air_dot3(a, v0) / air_length3(v0), z1 = air_dot3(a, v1) / air_length3(v1);
    const double middle = (z0 + z1) / (2.0 * cm), along = (z1 - z0) / (2.0 * sm);
    const double g2 = gamma * gamma, h = air_dot3(a, n) / size;
    const double d = sqrt((1.0 - g2) * (1.0 - g2) + 4.0 * g2 * h * h);
    /* r0 r1 times the cosine and sine of theta's half. */
    const double x = (1.0 + g2) * cm - 2.0 * gamma * middle, y = d * sm, rr = sqrt(x * x + y * y);
    *out = (arc){h, d, 2.0 * gamma * ((1.0 + g2) * middle - 2.0 * gamma * cm * (1.0 - h * h)) / rr,
                 2.0 * gamma * d * along / rr, atan2(y, x)};
    return true;
}

/* The integrand at q^2. */
static double kernel(double gamma, double d, double q2)
{
    const double least = 1.0 - gamma, q = sqrt(fmax(q2, least * least));
    return (d + 2.0 * q) / ((d + q) * (d + q) - gamma * gamma * q * q);
}

/* The rule's variable is tan(psi / 4): smooth, and in lanes it needs no trigonometry. */
static double arc_integral(const air_area_plan *plan, const arc *e)
{
    const double mean = 1.0 + plan->gamma * plan->gamma, end = tan(0.25 * e->half);
    double sum = 0.0;
    for (int i = 0; i < plan->pairs; i++) {
        const double t = plan->node[i] * end, psi = 4.0 * atan(t);
        const double even = mean + e->p * cos(psi), odd = e->q * sin(psi);
        sum += plan->weight[i] * 4.0 * end / (1.0 + t * t) *
               (kernel(plan->gamma, e->d, even + odd) + kernel(plan->gamma, e->d, even - odd));
    }
    return e->h * sum;
}

static double by_edges(const air_area_plan *plan, polygon p, const double axis[3],
                       const double apex[3])
{
    const size_t count = plan->lamp->vertex_count;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        arc e;
        if (arc_make(plan->gamma, axis, p[i], p[(i + 1) % count], &e)) {
            sum += arc_integral(plan, &e);
        }
    }
    return fabs(0.5 * solid_angle(p, count, apex) + plan->gamma * sum) / (2.0 * acos(-1.0));
}

/* ---- by lobes ---- */

/* The part of the cone over p where k.v >= 0; returns its number of vertices. */
static size_t cut(polygon p, size_t count, const double k[3], double (*out)[3])
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        const double *v0 = p[i], *v1 = p[(i + 1) % count];
        const double z0 = air_dot3(k, v0), z1 = air_dot3(k, v1);
        if (z0 >= 0.0) {
            memcpy(out[kept++], v0, sizeof *out);
        }
        if ((z0 >= 0.0) != (z1 >= 0.0)) {
            const double t = z0 / (z0 - z1);
            for (int j = 0; j < 3; j++) {
                out[kept][j] = v0[j] + t * (v1[j] - v0[j]);
            }
            kept++;
        }
    }
    return kept < 3 ? 0 : kept;
}

/* The integral of (1 - w) / (2 pi) + w cos / pi over the half about k, stretched by s [KT2025]. */
static double half_lobe(polygon p, size_t count, const double k[3], double s, double w)
{
    double v[AIR_AREA_MAX_VERTICES + 2][3], irradiance = 0.0;
    const size_t kept = cut(p, count, k, v);
    for (size_t i = 0; i < kept; i++) {
        const double lift = (1.0 / s - 1.0) * air_dot3(k, v[i]);
        for (int j = 0; j < 3; j++) {
            v[i][j] += lift * k[j];
        }
    }
    for (size_t i = 0; i < kept; i++) {
        const double *v0 = v[i], *v1 = v[(i + 1) % kept];
        const double edge[3] = {v1[0] - v0[0], v1[1] - v0[1], v1[2] - v0[2]};
        double n[3];
        air_cross3(v0, edge, n);
        const double size = air_length3(n);
        irradiance += size > DBL_MIN ? atan2(size, air_dot3(v0, v1)) * air_dot3(k, n) / size : 0.0;
    }
    const double pi = acos(-1.0);
    return ((1.0 - w) * fabs(solid_angle((polygon)v, kept, k)) + w * fabs(irradiance)) / (2.0 * pi);
}

static double by_lobes(const air_area_plan *plan, polygon p, const double axis[3])
{
    const double away[3] = {-axis[0], -axis[1], -axis[2]};
    const size_t count = plan->lamp->vertex_count;
    return plan->share[0] * half_lobe(p, count, axis, plan->s[0], plan->w[0]) +
           plan->share[1] * half_lobe(p, count, away, plan->s[1], plan->w[1]);
}

/* ---- points ---- */

static double eval_point(const air_area_plan *plan, const double position[3], const double wo[3])
{
    const air_area_lamp *lamp = plan->lamp;
    double p[AIR_AREA_MAX_VERTICES][3], axis[3], apex[3];
    for (size_t i = 0; i < lamp->vertex_count; i++) {
        for (int j = 0; j < 3; j++) {
            p[i][j] = lamp->vertices[i][j] - position[j];
        }
    }
    const double height = air_dot3(lamp->normal, p[0]); /* of the plane over the point */
    if (!(lamp->two_sided || height < 0.0)) {
        return 0.0;
    }
    for (int j = 0; j < 3; j++) {
        axis[j] = plan->peak * wo[j];
        apex[j] = height < 0.0 ? -lamp->normal[j] : lamp->normal[j];
    }
    const double s =
        plan->lobes ? by_lobes(plan, (polygon)p, axis) : by_edges(plan, (polygon)p, axis, apex);
    return s < INFINITY ? fmin(fmax(s, 0.0), 1.0) : 0.0;
}

void air_area_eval_c(const air_area_plan *plan, const air_area_shading_points *points, size_t count,
                     double *out_s)
{
    for (size_t i = 0; i < count; i++) {
        const double position[3] = {points->position[0][i], points->position[1][i],
                                    points->position[2][i]};
        const double wo[3] = {points->wo[0][i], points->wo[1][i], points->wo[2][i]};
        out_s[i] = eval_point(plan, position, wo);
    }
}

void air_area_eval_float_c(const air_area_plan *plan, const air_area_shading_points_float *points,
                           size_t count, float *out_s)
{
    for (size_t i = 0; i < count; i++) {
        const double position[3] = {points->position[0][i], points->position[1][i],
                                    points->position[2][i]};
        const double wo[3] = {points->wo[0][i], points->wo[1][i], points->wo[2][i]};
        out_s[i] = (float)eval_point(plan, position, wo);
    }
}

/* edge.c: the phase function over a polygon by its edges: the plain version. */
#include "arealight/edge.h"

#include <float.h>

#include "arealight/gauss.h"
#include "core/vec.h"

/* Beyond, 1 - |g| has few digits and the peak is a point of light. */
static const double largest_g = 0.99999;

void air_edge_rule_make(int nodes, air_edge_rule *out)
{
    const int n = nodes < 2 ? 2 : nodes < 2 * AIR_EDGE_PAIRS ? nodes : 2 * AIR_EDGE_PAIRS;
    double x[2 * AIR_EDGE_PAIRS], w[2 * AIR_EDGE_PAIRS];
    air_area_gauss((size_t)n, x, w);
    out->pairs = (n + 1) / 2;
    for (int i = 0; i < out->pairs; i++) {
        const bool middle = 2 * i + 1 == n; /* a pair of itself */
        out->node[i] = middle ? 0.0 : -x[i];
        out->weight[i] = middle ? 0.5 * w[i] : w[i];
    }
}

/* Along the arc: h, D, P, Q and half of theta's range. */
typedef struct arc {
    double h, d, p, q, half;
} arc;

/* a: the axis; v0, v1: the ends, of any length; edge: the way between. False if the arc is none. */
static bool arc_make(double gamma, const double a[3], const double v0[3], const double v1[3],
                     const double edge[3], arc *out)
{
    double n[3];
    air_cross3(v0, edge, n);
    const double size = air_length3(n), length0 = air_length3(v0), length1 = air_length3(v1);
    if (!(size > DBL_MIN)) {
        return false;
    }
    const double angle = atan2(size, air_dot3(v0, v1));
    const double sm = sin(0.5 * angle), cm = cos(0.5 * angle);
    const double z0 = air_dot3(a, v0) / length0, z1 = air_dot3(a, v1) / length1;
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
static double arc_integral(const air_edge_rule *rule, double gamma, const arc *e)
{
    const double mean = 1.0 + gamma * gamma, end = tan(0.25 * e->half);
    double sum = 0.0;
    for (int i = 0; i < rule->pairs; i++) {
        /* cos psi and sin psi of the quarter's tangent */
        const double t = rule->node[i] * end, t2 = t * t, below = 1.0 / ((1.0 + t2) * (1.0 + t2));
        const double even = mean + e->p * (1.0 + t2 * (t2 - 6.0)) * below;
        const double odd = e->q * 4.0 * t * (1.0 - t2) * below;
        sum += rule->weight[i] * 4.0 * end / (1.0 + t2) *
               (kernel(gamma, e->d, even + odd) + kernel(gamma, e->d, even - odd));
    }
    return e->h * sum;
}

/* Half the signed solid angle, by a fan whose apex is the foot of the point, or above it: no
 * triangle has opposite corners, except for a point on an edge [VanOosterom1983]. */
static double half_solid_angle(const air_cone *cone)
{
    double apex[3], sum = 0.0;
    air_cone_normal(cone, apex);
    const double length = copysign(air_length3(apex), air_dot3(apex, cone->vertices[0]));
    if (!(fabs(length) > 0.0)) {
        return 0.0;
    }
    for (size_t i = 0; i < cone->count; i++) {
        const double *a = cone->vertices[i], *b = cone->vertices[i + 1 < cone->count ? i + 1 : 0];
        const double la = air_length3(a), lb = air_length3(b);
        double normal[3];
        air_cross3(a, cone->edges[i], normal);
        sum += atan2(air_dot3(apex, normal) / length,
                     la * lb + air_dot3(a, b) +
                         (air_dot3(apex, a) * lb + air_dot3(apex, b) * la) / length);
    }
    return sum;
}

double air_edge_scatter(const air_edge_rule *rule, double gamma, const air_cone *cone,
                        const double axis[3])
{
    double sum = 0.0;
    for (size_t i = 0; i < cone->count; i++) {
        const double *next = cone->vertices[i + 1 < cone->count ? i + 1 : 0];
        arc e;
        if (arc_make(gamma, axis, cone->vertices[i], next, cone->edges[i], &e)) {
            sum += arc_integral(rule, gamma, &e);
        }
    }
    const double s = fabs(half_solid_angle(cone) + gamma * sum) / (2.0 * AIR_PI);
    return s < INFINITY ? fmin(s, 1.0) : 0.0;
}

double air_area_scatter_edge(const double (*polygon)[3], size_t count, const double wo[3], double g,
                             int nodes)
{
    air_edge_rule rule;
    air_cone cone;
    double axis[3];
    if (!air_cone_make(polygon, count, &cone)) {
        return 0.0;
    }
    air_edge_rule_make(nodes, &rule);
    for (int i = 0; i < 3; i++) {
        axis[i] = g > 0.0 ? -wo[i] : wo[i];
    }
    return air_edge_scatter(&rule, fmin(fabs(g), largest_g), &cone, axis);
}

int air_area_edge_nodes(double g)
{
    const double gamma = fabs(g);
    return gamma <= 0.6 ? 4 : (gamma <= 0.9 ? 6 : (gamma <= 0.95 ? 8 : 12));
}

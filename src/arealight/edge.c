/* edge.c: the phase function over a polygon by its edges: the plain version. */
#include "arealight/edge.h"

#include "arealight/gauss.h"
#include "arealight/polygon.h"

enum { MOST_NODES = 32 };

/* Beyond, 1 - |g| has few digits and the peak is a point of light. */
static const double largest_g = 0.99999;

/* Below, an edge lies in the horizon: the direction to the peak has no projection on its plane. The
 * linear term that is kept leaves an error of the square. */
static const double least_c0 = 1e-7;

typedef struct phase_rule {
    double gamma, axis[3];
    size_t count;
    double nodes[MOST_NODES], weights[MOST_NODES];
} phase_rule;

/* An edge's great circle: unit normal, and the axis' projection on its plane c0 long, along `top`;
 * across = normal x top, both still c0 long if that is too short to be divided by. */
typedef struct arc {
    double h, c0, normal_length;
    double top[3], across[3];
} arc;

static bool arc_make(const double axis[3], const double from[3], const double way[3], arc *out)
{
    double normal[3];
    air_cross3(from, way, normal);
    out->normal_length = air_length3(normal);
    if (!(out->normal_length > 0.0)) {
        return false;
    }
    for (int i = 0; i < 3; i++) {
        normal[i] /= out->normal_length;
    }
    out->h = air_dot3(axis, normal);
    air_along3(axis, -out->h, normal, out->top);
    out->c0 = air_length3(out->top);
    if (out->c0 >= least_c0) {
        for (int i = 0; i < 3; i++) {
            out->top[i] /= out->c0;
        }
    }
    air_cross3(normal, out->top, out->across);
    return true;
}

/* An edge in the horizon: c grows from c0 sin u there, so its integral is a difference. */
static double horizon_part(const phase_rule *rule, const arc *edge, const double from[3],
                           const double to[3], double length, bool near)
{
    const double r = air_edge_r(rule->gamma, 1.0);
    const double value =
        near ? air_edge_near(rule->gamma, 0.0, r) : air_edge_far(rule->gamma, 0.0, r);
    const double slope =
        near ? air_edge_near_slope(rule->gamma, r) : air_edge_far_slope(rule->gamma, r);
    const double integral_c = air_dot3(edge->across, to) / air_length3(to) -
                              air_dot3(edge->across, from) / air_length3(from);
    return value * (length + slope * integral_c);
}

/* sin(u/2) of a point whose coordinates along top and across are x > 0 (or nearly) and y. */
static double sine_of_half(double x, double y)
{
    const double distance = sqrt(x * x + y * y);
    const double sum = 2.0 * distance * (distance + x);
    return sum > 0.0 ? y / sqrt(sum) : 0.0;
}

static double stretched_part(const phase_rule *rule, const arc *edge, double q, double kappa,
                             double v0, double v1)
{
    const double middle = 0.5 * (v0 + v1), half = 0.5 * (v1 - v0);
    double sum = 0.0;
    for (size_t i = 0; i < rule->count; i++) {
        const double grow = exp(middle + half * rule->nodes[i]), fall = 1.0 / grow;
        sum += rule->weights[i] * air_edge_near_stretched(rule->gamma, edge->c0, q, kappa,
                                                          0.5 * (grow - fall), 0.5 * (grow + fall));
    }
    return half * sum;
}

static double plain_part(const phase_rule *rule, const arc *edge, double u0, double length,
                         bool near)
{
    const double middle = u0 + 0.5 * length, half = 0.5 * length;
    double sum = 0.0;
    for (size_t i = 0; i < rule->count; i++) {
        const double c = edge->c0 * cos(middle + half * rule->nodes[i]);
        const double r = air_edge_r(rule->gamma, 1.0 - c);
        sum += rule->weights[i] *
               (near ? air_edge_near(rule->gamma, c, r) : air_edge_far(rule->gamma, c, r));
    }
    return half * sum;
}

/* The integral over the azimuth along a part of an edge, all of it on one side of the horizon;
 * share: how much of the edge it is. */
static double part(const phase_rule *rule, const arc *edge, const double from[3],
                   const double to[3], double share, bool near)
{
    const double length = atan2(share * edge->normal_length, air_dot3(from, to));
    if (edge->c0 < least_c0) {
        return edge->h * horizon_part(rule, edge, from, to, length, near);
    }
    const double x0 = air_dot3(from, edge->top), y0 = air_dot3(from, edge->across);
    if (near) {
        const double square = air_edge_least_square(rule->gamma, edge->c0, edge->h);
        const double kappa = air_edge_kappa(rule->gamma, edge->c0, square);
        if (length > 2.0 * kappa) {
            const double x1 = air_dot3(to, edge->top), y1 = air_dot3(to, edge->across);
            return edge->h * stretched_part(rule, edge, sqrt(square), kappa,
                                            asinh(sine_of_half(x0, y0) / kappa),
                                            asinh(sine_of_half(x1, y1) / kappa));
        }
    }
    return edge->h * plain_part(rule, edge, atan2(y0, x0), length, near);
}

/* One whole edge; where it passes the horizon, its two parts. */
static double edge_integral(const phase_rule *rule, const double a[3], const double b[3],
                            air_horizon *horizon)
{
    const double up_a = air_dot3(rule->axis, a), up_b = air_dot3(rule->axis, b);
    const bool near_a = up_a > 0.0, near_b = up_b > 0.0;
    double way[3], point[3];
    arc edge;
    air_subtract3(b, a, way);
    const bool some = arc_make(rule->axis, a, way, &edge);
    if (near_a == near_b) {
        return some ? part(rule, &edge, a, b, 1.0, near_a) : 0.0;
    }
    const double share = air_horizon_share(up_a, up_b);
    air_along3(a, share, way, point);
    air_horizon_pass(horizon, rule->axis, a, way, share, near_b);
    return some ? part(rule, &edge, a, point, share, near_a) +
                      part(rule, &edge, point, b, 1.0 - share, near_b)
                : 0.0;
}

double air_area_scatter_edge(const double (*polygon)[3], size_t count, const double wo[3], double g,
                             int nodes)
{
    phase_rule rule;
    if (count < 3) {
        return 0.0;
    }
    rule.count = nodes < 2 ? 2 : (nodes < MOST_NODES ? (size_t)nodes : MOST_NODES);
    air_area_gauss(rule.count, rule.nodes, rule.weights);
    rule.gamma = fabs(g) < largest_g ? fabs(g) : largest_g;
    for (int i = 0; i < 3; i++) {
        rule.axis[i] = g > 0.0 ? -wo[i] : wo[i];
    }
    double sum = 0.0;
    air_horizon horizon = {.angle = 0.0};
    for (size_t i = 0; i < count; i++) {
        sum += edge_integral(&rule, polygon[i], polygon[i + 1 < count ? i + 1 : 0], &horizon);
    }
    sum = fabs(sum + air_horizon_angle(&horizon, rule.axis) / (2.0 * AIR_PI));
    return sum < 1.0 ? sum : 1.0;
}

int air_area_edge_nodes(double g)
{
    const double gamma = fabs(g);
    return gamma <= 0.6 ? 4 : (gamma <= 0.9 ? 6 : (gamma <= 0.95 ? 8 : 12));
}

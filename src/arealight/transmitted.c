/* transmitted.c: transmittance integrated over a polygon's directions, by its edges.
 *
 * Seen from the origin, exp(-sigma_t distance) = exp(-x/c), x = sigma_t H, H the distance of the
 * polygon's plane and c the cosine to its normal: a zonal function, and Stokes' theorem holds as it
 * does for the phase function (edge.h). From the pole down to c it integrates to
 *     Q = E2(x) - c E2(x/c),
 * E2 being the second exponential integral. On an edge x/c is sigma_t times the distance, and the
 * edge's point nearest to the origin is where c is largest.
 *
 * Where the haze is thick, E2(x) is far larger than what comes from edges, and cancels badly if the
 * pole is outside of the polygon. An edge that is farther than the pole by an optical depth of 1
 * therefore leaves E2(x) out; what it would have given is E2(x) times an azimuth, and all of these
 * together are E2(x) times the whole turn, if the pole is inside, less the azimuths of the edges
 * that kept it. */
#include "arealight/exponential_integral.h"
#include "arealight/gauss.h"
#include "arealight/polygon.h"
#include "core/vec.h"

enum { MOST_NODES = 48, INNER_NODES = 6 };

typedef struct haze_rule {
    double sigma_t, height, depth, whole; /* H, x, E2(x) */
    size_t count;
    double nodes[MOST_NODES], weights[MOST_NODES];
    double inner_nodes[INNER_NODES], inner_weights[INNER_NODES];
} haze_rule;

/* An edge: c = c0 cos u, u from u0 to u0 + length; c0 = height/nearest_line; 1 - c^2 = h^2 + (c0
 * sin u)^2. */
typedef struct haze_edge {
    double h, c0, nearest_line, u0, length;
    double nearest; /* distance to the nearest point of the edge itself */
    double azimuth;
} haze_edge;

/* From a to b, places in the plane about the pole's foot. The azimuth grows by h du/(1 - c^2), so
 * the outline closes to the last digit, as it must: the terms of a small lamp cancel. */
static bool haze_edge_make(double height, const double a[2], const double b[2], haze_edge *out)
{
    const double way[2] = {b[0] - a[0], b[1] - a[1]};
    const double way_length = sqrt(way[0] * way[0] + way[1] * way[1]);
    if (!(way_length > 0.0)) {
        return false;
    }
    const double aside = (a[0] * way[1] - a[1] * way[0]) / way_length;
    const double along_a = (a[0] * way[0] + a[1] * way[1]) / way_length;
    const double along_b = (b[0] * way[0] + b[1] * way[1]) / way_length;
    const double ab = a[0] * b[0] + a[1] * b[1];
    out->nearest_line = sqrt(height * height + aside * aside);
    if (!(out->nearest_line > 0.0)) {
        return false;
    }
    out->h = aside / out->nearest_line;
    out->c0 = height / out->nearest_line;
    out->u0 = atan2(along_a, out->nearest_line);
    out->length = atan2(way_length * out->nearest_line, ab + height * height);
    const double past = along_a > 0.0 ? along_a : (along_b < 0.0 ? along_b : 0.0);
    out->nearest = sqrt(out->nearest_line * out->nearest_line + past * past);
    out->azimuth = atan2(aside * way_length, ab);
    return true;
}

/* Q/(1 - c). Where the exponent hardly changes between c and the pole, the mean of the integrand;
 * elsewhere the difference has its digits. */
static double mean_from_pole(const haze_rule *rule, double c, double below_pole, double distance)
{
    if (below_pole < 0.3 && rule->depth * below_pole < 0.5) {
        double sum = 0.0;
        for (int i = 0; i < INNER_NODES; i++) {
            const double at = 1.0 - 0.5 * below_pole * (1.0 + rule->inner_nodes[i]);
            sum += rule->inner_weights[i] * exp(-rule->depth / at);
        }
        return 0.5 * sum;
    }
    return (rule->whole - c * air_exponential_integral_2(rule->sigma_t * distance)) / below_pole;
}

/* The edge's integrand over u; kept: with E2(x). */
static double integrand(const haze_rule *rule, const haze_edge *edge, double u, bool kept)
{
    const double cos_u = fabs(cos(u)), across = edge->c0 * sin(u), c = edge->c0 * cos_u;
    const double distance = edge->nearest_line / cos_u;
    const double square = edge->h * edge->h + across * across; /* 1 - c^2 */
    if (kept) {
        return mean_from_pole(rule, c, square / (1.0 + c), distance) / (1.0 + c);
    }
    return -c * air_exponential_integral_2(rule->sigma_t * distance) / square;
}

/* exp(-sigma_t distance) falls within about 1/sqrt(sigma_t distance) of the nearest point: where
 * that is short, nodes are as dense there as u = width sinh v puts them. */
static double edge_integral(const haze_rule *rule, const haze_edge *edge, bool kept)
{
    const double width = 1.0 / sqrt(rule->sigma_t * edge->nearest_line);
    const bool narrow = edge->length > 2.0 * width;
    const double u1 = edge->u0 + edge->length;
    const double v0 = narrow ? asinh(edge->u0 / width) : edge->u0;
    const double half = 0.5 * ((narrow ? asinh(u1 / width) : u1) - v0);
    double sum = 0.0;
    for (size_t i = 0; i < rule->count; i++) {
        const double v = v0 + half * (1.0 + rule->nodes[i]);
        const double grow = narrow ? exp(v) : 1.0, fall = 1.0 / grow;
        const double u = narrow ? 0.5 * width * (grow - fall) : v;
        sum += rule->weights[i] * (narrow ? 0.5 * width * (grow + fall) : 1.0) *
               integrand(rule, edge, u, kept);
    }
    return edge->h * half * sum;
}

/* The polygon in its plane: places about the foot of the pole, and the plane's distance. Vertices
 * that are out of plane are moved into it. False if the polygon has no area. */
static bool flatten(const air_cone *cone, double (*places)[2], double *out_height)
{
    double normal[3], s[3], t[3], sum = 0.0;
    air_cone_normal(cone, normal);
    const double length = air_length3(normal);
    if (!(length > 0.0)) {
        return false;
    }
    for (int i = 0; i < 3; i++) {
        normal[i] /= length;
    }
    air_axes_across(normal, s, t);
    for (size_t i = 0; i < cone->count; i++) {
        sum += air_dot3(normal, cone->vertices[i]);
        places[i][0] = air_dot3(s, cone->vertices[i]);
        places[i][1] = air_dot3(t, cone->vertices[i]);
    }
    *out_height = fabs(sum) / (double)cone->count;
    return true;
}

/* The sum over the edges, before it is known to be of the right sign and within its bounds. */
static double edges_sum(const haze_rule *rule, const double (*places)[2], size_t count)
{
    double sum = 0.0, turn = 0.0, kept_turn = 0.0;
    for (size_t i = 0; i < count; i++) {
        haze_edge edge;
        if (haze_edge_make(rule->height, places[i], places[i + 1 < count ? i + 1 : 0], &edge)) {
            const bool kept = rule->sigma_t * (edge.nearest - rule->height) < 1.0;
            sum += edge_integral(rule, &edge, kept);
            turn += edge.azimuth;
            kept_turn += kept ? edge.azimuth : 0.0;
        }
    }
    const double whole_turn = 2.0 * AIR_PI * nearbyint(turn / (2.0 * AIR_PI));
    return kept_turn == turn ? sum : sum + rule->whole * (whole_turn - kept_turn);
}

static double farthest(const air_cone *cone)
{
    double most = 0.0;
    for (size_t i = 0; i < cone->count; i++) {
        const double square = air_dot3(cone->vertices[i], cone->vertices[i]);
        most = square > most ? square : most;
    }
    return sqrt(most);
}

double air_area_transmitted_solid_angle(const double (*polygon)[3], size_t count, double sigma_t,
                                        int nodes)
{
    air_cone cone;
    haze_rule rule = {.sigma_t = sigma_t};
    double places[AIR_AREA_MAX_VERTICES][2];
    if (!air_cone_make(polygon, count, &cone) || !flatten(&cone, places, &rule.height)) {
        return 0.0;
    }
    const double solid_angle = air_cone_solid_angle(&cone);
    if (!(sigma_t > 0.0)) {
        return solid_angle;
    }
    /* The mean transmittance is between those of the farthest and the nearest point: what is left
     * of the sum where a coarse rule, or rounding in the lamp's plane, has spoilt it. */
    const double least = solid_angle * exp(-sigma_t * farthest(&cone));
    const double most = solid_angle * exp(-sigma_t * air_area_min_distance(polygon, count));
    rule.depth = sigma_t * rule.height;
    rule.whole = air_exponential_integral_2(rule.depth);
    rule.count = nodes < 2 ? 2 : (nodes < MOST_NODES ? (size_t)nodes : MOST_NODES);
    air_area_gauss(rule.count, rule.nodes, rule.weights);
    air_area_gauss(INNER_NODES, rule.inner_nodes, rule.inner_weights);
    const double sum = fabs(edges_sum(&rule, (const double(*)[2])places, count));
    return sum > least ? (sum < most ? sum : most) : least;
}

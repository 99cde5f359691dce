/* edge.h: the phase function integrated along a polygon's edges.
 *
 * With a the peak's axis, gamma = |g|, c = a.w and r^2 = 1 + gamma^2 - 2 gamma c, the phase
 * function integrates from the peak down to c to G+ = (1 + gamma) (1 - c) / (2 pi r (r + 1 -
 * gamma)) per angle about the axis. Less (1 - c) / (4 pi) it vanishes at both poles, and by Stokes
 *
 *     S = Omega / (4 pi) + sum over edges of Int (G+ - (1 - c) / (4 pi)) dphi
 *       = Omega / (4 pi) + gamma / (2 pi) sum h Int (r + 2) / (r ((r + 1)^2 - gamma^2)) du,
 *
 * u the arc along the edge, h = a.n, n its unit normal: r is never 0, no edge is cut at a horizon
 * and none is special. The integrand is large near the peak only, where the Moebius map of the
 * edge's circle that takes its Poisson kernel to 1, with du = r^2 / D dtheta, D^2 = (1 - gamma^2)^2
 * + 4 gamma^2 h^2, leaves (D + 2 q) / ((D + q)^2 - gamma^2 q^2), q = D / r: between 0.3 and 1.2 for
 * every gamma. q^2 = 1 + gamma^2 + P cos psi + Q sin psi, psi the angle theta from its middle. */
#ifndef AIR_AREALIGHT_EDGE_H
#define AIR_AREALIGHT_EDGE_H

#include "arealight/polygon.h"

enum { AIR_EDGE_PAIRS = 16 };

/* A rule on [-1, 1] in pairs of nodes of equal weight, node[i] and -node[i], over tan(psi / 4). */
typedef struct air_edge_rule {
    int pairs;
    double node[AIR_EDGE_PAIRS], weight[AIR_EDGE_PAIRS];
} air_edge_rule;

/* nodes: from 2 to 2 AIR_EDGE_PAIRS (beyond, the nearest). */
void air_edge_rule_make(int nodes, air_edge_rule *out);

/* S, in [0, 1]; 0 where rounding leaves no number. axis: unit, towards the peak; gamma in [0, 1).
 */
double air_edge_scatter(const air_edge_rule *rule, double gamma, const air_cone *cone,
                        const double axis[3]);

#endif

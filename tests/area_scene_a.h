/* area_scene_a.h: a rectangular lamp over a floor in haze without end, rendered by the kernel alone
 * with every way to integrate, for tests and benchmarks. The scene, its reference and the figures
 * are those of the specification's sections 8 and 12. */
#ifndef AREA_SCENE_A_H
#define AREA_SCENE_A_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/airlight.h"
#include "core/phase.h"
#include "core/quadrature.h"

enum {
    SCENE_WIDTH = 96,
    SCENE_HEIGHT = 54,
    SCENE_PIXELS = SCENE_WIDTH * SCENE_HEIGHT,
    REFERENCE_LINE = 64, /* nodes along a ray */
    SETTINGS = 15
};

static const double scene_g[5] = {-0.95, -0.6, -0.1, 0.4, 0.9};
static const double scene_sigma[3] = {0.05, 0.2, 1.0};

static const double scene_albedo = 0.5, scene_radiance = 10.0, scene_far = 15.0;
static const double scene_eye[3] = {0.0, -6.0, 1.5};

typedef struct area_scene {
    double g, sigma; /* sigma_s = sigma_t */
    air_area_lamp lamp;
    double points[2][AIR_AREA_MAX_POINTS][3], weights[2][AIR_AREA_MAX_POINTS]; /* 3 x 3, 8 x 8 */
    size_t point_count[2];
    air_area_lobe ltsd, mix;
} area_scene;

static inline area_scene scene_make(double g, double sigma)
{
    /* counter-clockwise as seen from below, to where it emits */
    static const double corners[4][3] = {
        {-1.0, -0.5, 2.0}, {-1.0, 0.5, 2.0}, {1.0, 0.5, 2.0}, {1.0, -0.5, 2.0}};
    area_scene out = {.g = g, .sigma = sigma};
    if (air_area_lamp_make(NULL, corners, 4, false, &out.lamp) != AIR_OK) {
        abort();
    }
    out.point_count[0] = air_area_lamp_points(&out.lamp, 3, out.points[0], out.weights[0]);
    out.point_count[1] = air_area_lamp_points(&out.lamp, 8, out.points[1], out.weights[1]);
    out.ltsd = air_area_lobe_ltsd(g);
    out.mix = air_area_lobe_mix(g);
    return out;
}

static inline double scene_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The ray through a pixel's centre, and its length to the floor or to where the scene ends. */
static inline bool scene_ray(int pixel, double dir[3], double *out_length)
{
    const double x = pixel % SCENE_WIDTH + 0.5, y = pixel / SCENE_WIDTH + 0.5;
    const double half = tan(20.0 * AIR_PI / 180.0);
    const double to[3] = {0.0, 6.0, -0.5}, scale = 1.0 / sqrt(scene_dot(to, to));
    const double f[3] = {0.0, to[1] * scale, to[2] * scale}, u[3] = {0.0, -f[2], f[1]};
    const double right = (2.0 * x / SCENE_WIDTH - 1.0) * half * SCENE_WIDTH / SCENE_HEIGHT;
    const double up = (1.0 - 2.0 * y / SCENE_HEIGHT) * half;
    dir[0] = right;
    dir[1] = f[1] + up * u[1];
    dir[2] = f[2] + up * u[2];
    const double length = sqrt(scene_dot(dir, dir));
    for (int k = 0; k < 3; k++) {
        dir[k] /= length;
    }
    const double floor = -scene_eye[2] / dir[2];
    const bool met = dir[2] < 0.0 && floor <= scene_far;
    *out_length = met ? floor : scene_far;
    return met;
}

/* How a picture is made. */
typedef enum scene_scatter { SCATTER_LTSD, SCATTER_MIX, SCATTER_EDGE } scene_scatter;

typedef struct scene_plan {
    scene_scatter scatter;
    int edge_nodes;
    bool shortest; /* transmittance by the shortest way; else by points of the lamp */
    bool many;     /* 8 x 8 of them near the lamp */
    air_area_rule rule;
    size_t nodes;
} scene_plan;

/* The mean transmittance from a point by the lamp's points; wo NULL: on the floor. */
static inline double scene_tau(const area_scene *s, const scene_plan *plan, const double point[3],
                               const double *wo, double nearest)
{
    if (plan->shortest) {
        return exp(-s->sigma * nearest);
    }
    const int fine = plan->many && nearest < 0.5 * sqrt(s->lamp.area);
    double through = 0.0, all = 0.0;
    for (size_t i = 0; i < s->point_count[fine]; i++) {
        double wi[3];
        for (int k = 0; k < 3; k++) {
            wi[k] = s->points[fine][i][k] - point[k];
        }
        const double r = sqrt(scene_dot(wi, wi));
        const double cosine = wo != NULL ? -scene_dot(wo, wi) / r : wi[2] / r;
        const double value =
            wo != NULL ? (double)phase_eval((air_phase){.kind = AIR_PHASE_HG, .g = (float)s->g},
                                            (float)cosine)
                       : cosine;
        const double share = s->weights[fine][i] * value / (r * r * r);
        through += share * exp(-s->sigma * r);
        all += share;
    }
    return all > 0.0 ? through / all : 0.0;
}

static inline double scene_scattered(const area_scene *s, const scene_plan *plan,
                                     const double point[3], const double wo[3])
{
    double polygon[AIR_AREA_MAX_VERTICES][3];
    if (!air_area_lamp_seen_from(&s->lamp, point, polygon)) {
        return 0.0;
    }
    const double(*seen)[3] = (const double(*)[3])polygon;
    const double value = plan->scatter == SCATTER_EDGE
                             ? air_area_scatter_edge(seen, 4, wo, s->g, plan->edge_nodes)
                             : air_area_scatter_lobes(
                                   seen, 4, wo, plan->scatter == SCATTER_MIX ? &s->mix : &s->ltsd);
    return value * scene_tau(s, plan, point, wo, air_area_min_distance(seen, 4));
}

static inline double scene_air(const area_scene *s, const scene_plan *plan, const double dir[3],
                               double length)
{
    double t[AIR_AREA_MAX_NODES], w[AIR_AREA_MAX_NODES], sum = 0.0;
    const double wo[3] = {-dir[0], -dir[1], -dir[2]};
    air_interval lit = {0.0, length};
    if (plan->rule != AIR_AREA_RIEMANN &&
        !air_area_lit_interval(&s->lamp, scene_eye, dir, length, &lit)) {
        return 0.0;
    }
    air_area_line_nodes(plan->rule, &s->lamp, scene_eye, dir, lit, s->sigma, plan->nodes, t, w);
    for (size_t i = 0; i < plan->nodes; i++) {
        const double point[3] = {scene_eye[0] + t[i] * dir[0], scene_eye[1] + t[i] * dir[1],
                                 scene_eye[2] + t[i] * dir[2]};
        sum += w[i] * exp(-s->sigma * t[i]) * scene_scattered(s, plan, point, wo);
    }
    return scene_radiance * s->sigma * sum;
}

static inline double scene_floor(const area_scene *s, const scene_plan *plan, const double dir[3],
                                 double length)
{
    static const double normal[3] = {0.0, 0.0, 1.0};
    double polygon[AIR_AREA_MAX_VERTICES][3];
    const double point[3] = {scene_eye[0] + length * dir[0], scene_eye[1] + length * dir[1], 0.0};
    if (!air_area_lamp_seen_from(&s->lamp, point, polygon)) {
        return 0.0;
    }
    const double(*seen)[3] = (const double(*)[3])polygon;
    const double nearest = air_area_min_distance(seen, 4);
    return scene_radiance * scene_albedo * air_area_irradiance(seen, 4, normal) *
           scene_tau(s, plan, point, NULL, nearest) * exp(-s->sigma * length);
}

/* ---- the reference: the regularised rule along the ray, the lamp cut finer where it is near ----
 */

enum { LEAF = 6, MOST_CUTS = 14 };

/* Seen from a point below, and what arrives from a direction. */
typedef struct scene_place {
    const area_scene *scene;
    const double *point, *wo; /* wo NULL: on the floor */
    double x[LEAF], w[LEAF];  /* a Gauss rule on [-1, 1] */
    double smallness;         /* of a part against its distance */
} scene_place;

static inline scene_place scene_place_at(const area_scene *scene, const double point[3],
                                         const double *wo)
{
    scene_place out = {.scene = scene, .point = point, .wo = wo};
    air_gauss_legendre(LEAF, out.x, out.w);
    out.smallness = fabs(scene->g) > 0.7 && wo != NULL ? 0.1 : 0.6;
    return out;
}

static inline double scene_kernel(const scene_place *at, double x, double y)
{
    const area_scene *s = at->scene;
    const double wi[3] = {x - at->point[0], y - at->point[1], 2.0 - at->point[2]};
    const double r2 = scene_dot(wi, wi), r = sqrt(r2);
    double value = wi[2] / (AIR_PI * r);
    if (at->wo != NULL) {
        const double d = 1.0 + s->g * s->g + 2.0 * s->g * scene_dot(at->wo, wi) / r;
        value = (1.0 - s->g * s->g) / (4.0 * AIR_PI * d * sqrt(d));
    }
    return value * exp(-s->sigma * r) * wi[2] / (r2 * r);
}

/* The integral over the part of the lamp around (x, y) with half sides a, b. */
static inline double scene_part(const scene_place *at, double x, double y, double a, double b,
                                int cuts)
{
    const double dx = fmax(0.0, fabs(at->point[0] - x) - a);
    const double dy = fmax(0.0, fabs(at->point[1] - y) - b), dz = 2.0 - at->point[2];
    const double nearest = sqrt(dx * dx + dy * dy + dz * dz);
    double sum = 0.0;
    if (cuts < MOST_CUTS && fmax(a, b) > at->smallness * nearest) {
        const bool wide = a >= b;
        const double half_a = wide ? 0.5 * a : a, half_b = wide ? b : 0.5 * b;
        sum += scene_part(at, x - (a - half_a), y - (b - half_b), half_a, half_b, cuts + 1);
        sum += scene_part(at, x + (a - half_a), y + (b - half_b), half_a, half_b, cuts + 1);
        return sum;
    }
    for (int i = 0; i < LEAF; i++) {
        for (int j = 0; j < LEAF; j++) {
            sum += at->w[i] * at->w[j] * scene_kernel(at, x + a * at->x[i], y + b * at->x[j]);
        }
    }
    return sum * a * b;
}

static inline double scene_exact(const area_scene *s, const double point[3], const double *wo)
{
    const scene_place at = scene_place_at(s, point, wo);
    return point[2] < 2.0 ? scene_part(&at, 0.0, 0.0, 1.0, 0.5, 0) : 0.0;
}

static inline double scene_air_exact(const area_scene *s, const double dir[3], double length)
{
    double t[REFERENCE_LINE], w[REFERENCE_LINE], sum = 0.0;
    const double wo[3] = {-dir[0], -dir[1], -dir[2]};
    air_interval lit;
    if (!air_area_lit_interval(&s->lamp, scene_eye, dir, length, &lit)) {
        return 0.0;
    }
    air_area_line_nodes(AIR_AREA_EQUIANGULAR, &s->lamp, scene_eye, dir, lit, s->sigma,
                        REFERENCE_LINE, t, w);
    for (size_t i = 0; i < REFERENCE_LINE; i++) {
        const double point[3] = {scene_eye[0] + t[i] * dir[0], scene_eye[1] + t[i] * dir[1],
                                 scene_eye[2] + t[i] * dir[2]};
        sum += w[i] * exp(-s->sigma * t[i]) * scene_exact(s, point, wo);
    }
    return scene_radiance * s->sigma * sum;
}

static inline double scene_floor_exact(const area_scene *s, const double dir[3], double length)
{
    const double point[3] = {scene_eye[0] + length * dir[0], scene_eye[1] + length * dir[1], 0.0};
    const scene_place at = scene_place_at(s, point, NULL);
    /* the floor's cosine is that of the lamp, which scene_kernel holds */
    return scene_radiance * scene_albedo * exp(-s->sigma * length) *
           scene_part(&at, 0.0, 0.0, 1.0, 0.5, 0);
}

#endif

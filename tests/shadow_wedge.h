/* shadow_wedge.h: the shadow of a triangle by the definition, in doubles and world space: the wedge
 * under it. What the tests and the benchmark of the shadow tree hold it against. */
#ifndef AIR_TESTS_SHADOW_WEDGE_H
#define AIR_TESTS_SHADOW_WEDGE_H

#include <stdlib.h>

#include "airlight/shadow.h"
#include "core/triple.h"

/* The set of points under a triangle: n.x <= h for each of its planes. */
typedef struct shadow_wedge {
    double planes[4][4];
} shadow_wedge;

typedef struct shadow_wedges {
    shadow_wedge *wedges;
    size_t count;
} shadow_wedges;

static inline void subtract(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] - b[i];
    }
}

static inline void triangle_corners(const air_shadow_mesh *mesh, size_t triangle, double out[3][3])
{
    for (size_t k = 0; k < 3; k++) {
        for (size_t i = 0; i < 3; i++) {
            out[k][i] = (double)mesh->positions[3 * mesh->indices[3 * triangle + k] + i];
        }
    }
}

/* The plane through a point, n away from another one. */
static inline void plane_away_from(const double n[3], const double through[3],
                                   const double away_from[3], double out[4])
{
    double d[3];
    subtract(through, away_from, d);
    const double turn = air_dot3(n, d) < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; i++) {
        out[i] = turn * n[i];
    }
    out[3] = air_dot3(out, through);
}

/* False for triangles edge-on to the light: the wedge has no inside. */
static inline bool make_wedge(double p[3][3], const double to_light[3], shadow_wedge *out)
{
    double u[3], v[3], n[3], under[3];
    subtract(p[1], p[0], u);
    subtract(p[2], p[0], v);
    air_cross3(u, v, n);
    if (fabs(air_dot3(n, to_light)) <= 1e-12 * sqrt(air_dot3(n, n))) {
        return false;
    }
    subtract(p[0], to_light, under);
    plane_away_from(n, p[0], under, out->planes[3]);
    for (int e = 0; e < 3; e++) {
        double edge[3], m[3];
        subtract(p[(e + 1) % 3], p[e], edge);
        air_cross3(to_light, edge, m);
        plane_away_from(m, p[e], p[(e + 2) % 3], out->planes[e]);
    }
    return true;
}

/* To be freed with free(wedges), which is NULL if memory is out. */
static inline shadow_wedges make_wedges(const air_shadow_mesh *meshes, size_t mesh_count,
                                        const double to_light[3])
{
    shadow_wedges out = {0};
    size_t most = 1;
    for (size_t m = 0; m < mesh_count; m++) {
        most += meshes[m].triangle_count;
    }
    out.wedges = malloc(most * sizeof *out.wedges);
    for (size_t m = 0; out.wedges != NULL && m < mesh_count; m++) {
        for (size_t i = 0; i < meshes[m].triangle_count; i++) {
            double p[3][3];
            triangle_corners(&meshes[m], i, p);
            out.count += make_wedge(p, to_light, &out.wedges[out.count]);
        }
    }
    return out;
}

/* Clips [begin, end] to the wedge; false if nothing is left. */
static inline bool clip_to_wedge(const shadow_wedge *wedge, const double o[3], const double v[3],
                                 double begin, double end, air_interval *out)
{
    for (int k = 0; k < 4; k++) {
        const double *n = wedge->planes[k], room = n[3] - air_dot3(n, o), speed = air_dot3(n, v);
        const double t = room / speed;
        if (speed > 0.0) {
            end = t < end ? t : end;
        } else if (speed < 0.0) {
            begin = t > begin ? t : begin;
        } else if (room < 0.0) {
            return false;
        }
        if (!(begin < end)) {
            return false;
        }
    }
    *out = (air_interval){begin, end};
    return true;
}

#endif

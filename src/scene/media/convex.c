#include "scene/media/convex.h"

/* Faces whose normals differ by less count as parallel; thin boxes far from the origin have such
 * roundings. Only the kind of boundary that is shown depends on it. */
#define PARALLEL 1e-3f

typedef struct plane64 {
    double n[3], h;
} plane64;

static double dot64(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross64(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

bool air_convex_plane(const float values[4], air_plane *out)
{
    const double n[3] = {(double)values[0], (double)values[1], (double)values[2]};
    const double scale = 1.0 / sqrt(dot64(n, n));
    *out = (air_plane){vec3((float)(n[0] * scale), (float)(n[1] * scale), (float)(n[2] * scale)),
                       (float)((double)values[3] * scale)};
    return isfinite(scale) && vec3_is_finite(out->n) && isfinite(out->h);
}

bool air_convex_box_planes(const float box_to_world[12], air_plane out_planes[6])
{
    double axes[3][3], center[3];
    for (int k = 0; k < 3; k++) {
        center[k] = (double)box_to_world[4 * k + 3];
        for (int a = 0; a < 3; a++) {
            axes[a][k] = (double)box_to_world[4 * k + a];
        }
    }
    for (int a = 0; a < 3; a++) {
        double n[3];
        cross64(axes[(a + 1) % 3], axes[(a + 2) % 3], n);
        const double length = sqrt(dot64(n, n));
        /* half the thickness of the box between the two faces, signed */
        const double reach = dot64(n, axes[a]) / length;
        if (!isfinite(reach) || fabs(reach) <= 1e-6 * sqrt(dot64(axes[a], axes[a]))) {
            return false;
        }
        const double scale = copysign(1.0 / length, reach);
        const double offset = dot64(n, center) * scale;
        const air_vec3 normal =
            vec3((float)(n[0] * scale), (float)(n[1] * scale), (float)(n[2] * scale));
        out_planes[2 * a] = (air_plane){normal, (float)(offset + fabs(reach))};
        out_planes[2 * a + 1] = (air_plane){vec3_neg(normal), (float)(fabs(reach) - offset)};
        if (!isfinite(out_planes[2 * a].h) || !isfinite(out_planes[2 * a + 1].h)) {
            return false;
        }
    }
    return true;
}

void air_convex_box_bounds(const float box_to_world[12], float out_min[3], float out_max[3])
{
    for (int k = 0; k < 3; k++) {
        const float *row = box_to_world + 4 * k;
        const float reach = fabsf(row[0]) + fabsf(row[1]) + fabsf(row[2]);
        out_min[k] = row[3] - reach;
        out_max[k] = row[3] + reach;
    }
}

/* The point where three planes meet; false if they hardly do. */
static bool meet(const plane64 *a, const plane64 *b, const plane64 *c, double out[3])
{
    double ab[3], bc[3], ca[3];
    cross64(a->n, b->n, ab);
    cross64(b->n, c->n, bc);
    cross64(c->n, a->n, ca);
    const double det = dot64(a->n, bc);
    if (fabs(det) < 1e-9) {
        return false;
    }
    for (int k = 0; k < 3; k++) {
        out[k] = (a->h * bc[k] + b->h * ca[k] + c->h * ab[k]) / det;
    }
    return true;
}

/* Corners of the polyhedron are where three planes meet inside all others. */
typedef struct corner_bounds {
    const plane64 *planes;
    size_t count;
    double low[3], high[3];
    double depth[AIR_MAX_PLANES + 6]; /* the largest distance of a corner behind each plane */
} corner_bounds;

static void add_corner(corner_bounds *bounds, const double p[3])
{
    const double size = fabs(p[0]) + fabs(p[1]) + fabs(p[2]);
    for (size_t i = 0; i < bounds->count; i++) {
        const plane64 *plane = &bounds->planes[i];
        if (dot64(plane->n, p) - plane->h > 1e-10 * (size + fabs(plane->h))) {
            return;
        }
    }
    for (size_t i = 0; i < bounds->count; i++) {
        bounds->depth[i] =
            fmax(bounds->depth[i], bounds->planes[i].h - dot64(bounds->planes[i].n, p));
    }
    for (int k = 0; k < 3; k++) {
        bounds->low[k] = fmin(bounds->low[k], p[k]);
        bounds->high[k] = fmax(bounds->high[k], p[k]);
    }
}

static void enumerate_corners(corner_bounds *bounds)
{
    double p[3];
    for (size_t i = 0; i < bounds->count; i++) {
        for (size_t j = i + 1; j < bounds->count; j++) {
            for (size_t k = j + 1; k < bounds->count; k++) {
                if (meet(&bounds->planes[i], &bounds->planes[j], &bounds->planes[k], p)) {
                    add_corner(bounds, p);
                }
            }
        }
    }
}

bool air_convex_bounds(const air_plane *planes, size_t plane_count, float out_min[3],
                       float out_max[3])
{
    plane64 all[AIR_MAX_PLANES + 6];
    double largest = 0.0;
    for (size_t i = 0; i < plane_count; i++) {
        const double n[3] = {(double)planes[i].n.x, (double)planes[i].n.y, (double)planes[i].n.z};
        all[i] = (plane64){{n[0], n[1], n[2]}, (double)planes[i].h};
        largest = fmax(largest, fabs(all[i].h));
    }
    /* A far box makes every polyhedron bounded; where a bound comes from it, the polyhedron has
     * none. */
    const double far = 1e6 * (1.0 + largest);
    for (int k = 0; k < 6; k++) {
        plane64 *plane = &all[plane_count + (size_t)k];
        *plane = (plane64){{0.0, 0.0, 0.0}, far};
        plane->n[k / 2] = k % 2 == 0 ? 1.0 : -1.0;
    }
    corner_bounds bounds = {.planes = all,
                            .count = plane_count + 6,
                            .low = {INFINITY, INFINITY, INFINITY},
                            .high = {-INFINITY, -INFINITY, -INFINITY}};
    enumerate_corners(&bounds);
    /* A polyhedron without inside lies wholly in one of its own planes (an implicit equality).
     * Offsets are rounded to 2^-24 of their size. */
    for (size_t i = 0; i < plane_count; i++) {
        if (!(bounds.depth[i] > 2e-7 * largest)) {
            return false;
        }
    }
    for (int k = 0; k < 3; k++) {
        out_min[k] = bounds.low[k] < -0.5 * far ? -INFINITY : (float)bounds.low[k];
        out_max[k] = bounds.high[k] > 0.5 * far ? INFINITY : (float)bounds.high[k];
    }
    return bounds.low[0] <= bounds.high[0];
}

bool air_convex_is_box(const air_plane *planes, size_t plane_count)
{
    if (plane_count != 6) {
        return false;
    }
    unsigned paired = 0;
    for (size_t i = 0; i < 6; i++) {
        for (size_t j = i + 1; j < 6; j++) {
            if (vec3_length(vec3_add(planes[i].n, planes[j].n)) < PARALLEL) {
                paired |= 1u << i | 1u << j;
            }
        }
    }
    return paired == 63u;
}

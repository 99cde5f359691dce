/* eval_plain.c: S at many points, one after the other: what the versions in lanes are held against.
 */
#include <float.h>
#include <string.h>

#include "arealight/eval.h"
#include "core/vec.h"

/* ---- by lobes, the fan of the solid angle about the axis ---- */

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

static double solid_angle(polygon p, size_t count, const double apex[3])
{
    double half = 0.0;
    for (size_t i = 0; i < count; i++) {
        half += half_solid_angle(apex, p[i], p[(i + 1) % count]);
    }
    return 2.0 * half;
}

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
    return ((1.0 - w) * fabs(solid_angle((polygon)v, kept, k)) + w * fabs(irradiance)) /
           (2.0 * AIR_PI);
}

static double by_lobes(const air_area_plan *plan, polygon p, const double axis[3])
{
    const double away[3] = {-axis[0], -axis[1], -axis[2]};
    const size_t count = plan->lamp->vertex_count;
    return plan->halves.share[0] * half_lobe(p, count, axis, plan->halves.s[0], plan->halves.w[0]) +
           plan->halves.share[1] * half_lobe(p, count, away, plan->halves.s[1], plan->halves.w[1]);
}

/* ---- points ---- */

static double eval_point(const air_area_plan *plan, const double position[3], const double wo[3])
{
    const air_area_lamp *lamp = plan->lamp;
    double p[AIR_AREA_MAX_VERTICES][3], axis[3];
    air_cone cone;
    for (size_t i = 0; i < lamp->vertex_count; i++) {
        air_subtract3(lamp->vertices[i], position, p[i]);
    }
    if (!(lamp->two_sided || air_dot3(lamp->normal, p[0]) < 0.0)) {
        return 0.0;
    }
    for (int j = 0; j < 3; j++) {
        axis[j] = plan->peak * wo[j];
    }
    if (plan->lobes) {
        const double s = by_lobes(plan, (polygon)p, axis);
        return s < INFINITY ? fmin(fmax(s, 0.0), 1.0) : 0.0;
    }
    return air_cone_make((polygon)p, lamp->vertex_count, &cone)
               ? air_edge_scatter(&plan->rule, plan->gamma, &cone, axis)
               : 0.0;
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

/* medium.c: convex media as half-spaces; a ray's stretch inside; the distance to the boundary. */
#include <float.h>

#include "collimated/planes.h"
#include "core/host.h"

/* Squared lengths of normals must be neither 0 nor infinite in double. */
static const double shortest_normal = 1e-150, longest_normal = 1e150;

air_status air_collimated_medium_from_planes(air_context *context, const double (*planes)[4],
                                             size_t plane_count, air_collimated_medium *out)
{
    if (plane_count > AIR_COLLIMATED_MAX_PLANES) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "collimated medium: %zu planes, must be at most %d", plane_count,
                        AIR_COLLIMATED_MAX_PLANES);
    }
    for (size_t k = 0; k < plane_count; k++) {
        const double *n = planes[k];
        const double longest = fmax(fmax(fabs(n[0]), fabs(n[1])), fabs(n[2]));
        if (!air_finite3(n) || !isfinite(n[3])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "collimated medium: plane %zu: (%g, %g, %g, %g) is not finite", k, n[0],
                            n[1], n[2], n[3]);
        }
        if (!(longest > shortest_normal && longest < longest_normal)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "collimated medium: plane %zu: the normal (%g, %g, %g) is %s", k, n[0],
                            n[1], n[2], longest < 1.0 ? "0" : "too long");
        }
    }
    out->plane_count = plane_count;
    for (size_t k = 0; k < plane_count; k++) {
        for (size_t i = 0; i < 4; i++) {
            out->planes[k][i] = planes[k][i];
        }
    }
    return AIR_OK;
}

/* The volume spanned by the rows made unit; 0 if one of them is 0. */
static double unit_volume(const double m[12])
{
    double u[3][3];
    for (int r = 0; r < 3; r++) {
        const double *row = m + 4 * r;
        const double longest = fmax(fmax(fabs(row[0]), fabs(row[1])), fabs(row[2]));
        if (!(longest > 0.0)) {
            return 0.0;
        }
        for (int i = 0; i < 3; i++) {
            u[r][i] = row[i] / longest;
        }
        const double length = sqrt(air_dot3(u[r], u[r]));
        for (int i = 0; i < 3; i++) {
            u[r][i] /= length;
        }
    }
    return u[0][0] * (u[1][1] * u[2][2] - u[1][2] * u[2][1]) +
           u[0][1] * (u[1][2] * u[2][0] - u[1][0] * u[2][2]) +
           u[0][2] * (u[1][0] * u[2][1] - u[1][1] * u[2][0]);
}

air_status air_collimated_medium_from_box(air_context *context, const double world_to_box[12],
                                          air_collimated_medium *out)
{
    for (int i = 0; i < 12; i++) {
        if (!isfinite(world_to_box[i])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "collimated box: number %d of the matrix is %g, must be finite", i,
                            world_to_box[i]);
        }
    }
    /* Entries of unit rows carry an error of 1.5 half ulps, each of the six products three of them
     * and two roundings, their sum a few more: below 16 epsilon together. */
    if (!(fabs(unit_volume(world_to_box)) > 16.0 * DBL_EPSILON)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "collimated box: the matrix is singular: the box has no inside");
    }
    double planes[6][4];
    for (int r = 0; r < 3; r++) {
        const double *row = world_to_box + 4 * r;
        for (int i = 0; i < 3; i++) {
            planes[2 * r][i] = row[i];
            planes[2 * r + 1][i] = -row[i];
        }
        planes[2 * r][3] = 1.0 - row[3];
        planes[2 * r + 1][3] = 1.0 + row[3];
    }
    return air_collimated_medium_from_planes(context, (const double(*)[4])planes, 6, out);
}

bool air_collimated_interval(const air_collimated_medium *medium, const double origin[3],
                             const double dir[3], double t_max, air_interval *out)
{
    air_plane_crossings ray;
    if (!air_finite3(origin) || !air_finite3(dir) ||
        !air_planes_cross(medium, origin, dir, t_max, &ray)) {
        return false;
    }
    out->begin = ray.begin;
    out->end = ray.end;
    return true;
}

double air_collimated_boundary_distance(const air_collimated_medium *medium,
                                        const double to_light[3], const double point[3])
{
    double distance = INFINITY;
    if (!air_finite3(to_light) || !air_finite3(point)) {
        return 0.0;
    }
    for (size_t k = 0; k < medium->plane_count; k++) {
        const double *n = medium->planes[k], nl = air_plane_facing(n, to_light);
        if (nl > 0.0) {
            const double d = (n[3] - air_dot3(n, point)) / nl;
            distance = d < distance ? d : distance;
        }
    }
    return distance > 0.0 ? distance : 0.0;
}

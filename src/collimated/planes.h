/* planes.h: a ray against the half-spaces of a convex medium, as numbers per plane. */
#ifndef AIR_COLLIMATED_PLANES_H
#define AIR_COLLIMATED_PLANES_H

#include "airlight/collimated.h"
#include "core/triple.h"
#include "core/vec.h"

/* n.x <= h along o + t v reads nv t <= no, with no = h - n.o and nv = n.v. */
typedef struct air_plane_crossings {
    double no[AIR_COLLIMATED_MAX_PLANES], nv[AIR_COLLIMATED_MAX_PLANES];
    double begin, end;  /* the stretch inside; end may be INFINITY */
    size_t enter, exit; /* the planes at its ends; plane_count where no plane ends it */
} air_plane_crossings;

/* n.l where the plane faces the light; 0 where it looks away, or is parallel to the light to within
 * rounding: then it never stops a ray towards the light. 1e-15 is the rounding of n.l / |n|. */
static inline double air_plane_facing(const double plane[4], const double to_light[3])
{
    const double nl = air_dot3(plane, to_light);
    return nl * nl > 1e-30 * air_dot3(plane, plane) ? nl : 0.0;
}

/* False if the ray has no stretch inside before t_max. */
static inline bool air_planes_cross(const air_collimated_medium *medium, const double origin[3],
                                    const double dir[3], double t_max, air_plane_crossings *out)
{
    const size_t count = medium->plane_count;
    double begin = 0.0, end = t_max;
    size_t enter = count, exit = count;
    for (size_t k = 0; k < count; k++) {
        const double *n = medium->planes[k];
        const double no = n[3] - air_dot3(n, origin), nv = air_dot3(n, dir), t = no / nv;
        out->no[k] = no;
        out->nv[k] = nv;
        if (nv > 0.0) {
            exit = t < end ? k : exit;
            end = t < end ? t : end;
        } else if (nv < 0.0) {
            enter = t > begin ? k : enter;
            begin = t > begin ? t : begin;
        } else if (!(no >= 0.0)) {
            return false;
        }
    }
    out->begin = begin;
    out->end = end;
    out->enter = enter;
    out->exit = exit;
    return begin < end; /* false where t_max is NaN */
}

#endif

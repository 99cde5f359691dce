/* scatter_lobes.c: the phase function over a polygon as two linearly transformed lobes [KT2025].
 *
 * About the axis of its hemisphere the transformation is diag(1, 1, s), so that its inverse only
 * stretches along the axis, by 1/s up to a factor, and no frame is needed. The source before it is
 * (1 - w)/(2 pi) + w cos/pi over the hemisphere, its integral (1 - w) Omega/(2 pi) + w E. */
#include "arealight/scatter_lobes.h"

#include "arealight/polygon.h"

#include "core/vec.h"

static void stretch(const double v[3], double by, const double axis[3], double out[3])
{
    air_along3(v, (by - 1.0) * air_dot3(v, axis), axis, out);
}

/* The integral of one half's density, which is 1 over the whole hemisphere. */
static double half_share(const air_cone *cone, const double axis[3], double s, double w)
{
    air_cone stretched = {.count = cone->count}, above;
    for (size_t i = 0; i < cone->count; i++) {
        stretch(cone->vertices[i], 1.0 / s, axis, stretched.vertices[i]);
        stretch(cone->edges[i], 1.0 / s, axis, stretched.edges[i]);
    }
    air_cone_clip(&stretched, axis, &above);
    const double share = (1.0 - w) * air_cone_solid_angle(&above) / (2.0 * AIR_PI) +
                         w * air_cone_irradiance(&stretched, axis);
    return share > 0.0 ? (share < 1.0 ? share : 1.0) : 0.0;
}

air_lobe_halves air_lobe_halves_make(const air_area_lobe *lobe, double gamma)
{
    const double near = air_near_share(gamma);
    return (air_lobe_halves){
        {near, 1.0 - near}, {lobe->s_near, lobe->s_far}, {lobe->w_near, lobe->w_far}};
}

double air_area_scatter_lobes(const double (*polygon)[3], size_t count, const double wo[3],
                              const air_area_lobe *lobe)
{
    air_cone cone;
    double axis[3], away[3];
    if (!air_cone_make(polygon, count, &cone)) {
        return 0.0;
    }
    if (lobe->g == 0.0) {
        return air_cone_solid_angle(&cone) / (4.0 * AIR_PI);
    }
    for (int i = 0; i < 3; i++) {
        axis[i] = lobe->g > 0.0 ? -wo[i] : wo[i];
        away[i] = -axis[i];
    }
    const air_lobe_halves halves = air_lobe_halves_make(lobe, fabs(lobe->g));
    return halves.share[0] * half_share(&cone, axis, halves.s[0], halves.w[0]) +
           halves.share[1] * half_share(&cone, away, halves.s[1], halves.w[1]);
}

/* arealight_reflect.c: the integral of a Lambert surface's reflectance over a lamp. */
#include "render/arealight_state.h"

air_vec3 air_area_reflect(const air_bsdf *bsdf, const double (*polygon)[3], size_t count)
{
    double normal[3];
    vec3_store64(normal, bsdf->frame.n);
    return vec3_scale(bsdf->diffuse, (float)air_area_irradiance(polygon, count, normal));
}

/* arealight_reflect.c: the integral of a surface's reflectance over a lamp: its GGX lobe by a
 * transformed cosine [Heitz2016], the rest, which varies slowly over the lamp, at the lamp's mean
 * direction times the cosine's integral. */
#include "airlight/area_ltc.h"
#include "render/arealight_state.h"

/* The mean of the directions to the vertices, lifted above the surface. */
static air_vec3 mean_direction(const air_bsdf *bsdf, const double (*polygon)[3], size_t count)
{
    const float least = 0.02f;
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < count; i++) {
        const air_vec3 v = vec3((float)polygon[i][0], (float)polygon[i][1], (float)polygon[i][2]);
        sum = vec3_add(sum, vec3_scale(v, 1.0f / float_max(vec3_length(v), 1e-30f)));
    }
    air_vec3 mean = vec3_scale(sum, 1.0f / float_max(vec3_length(sum), 1e-30f));
    const air_vec3 normals[2] = {bsdf->frame.n, bsdf->normal};
    for (int k = 0; k < 2; k++) {
        const float height = vec3_dot(mean, normals[k]);
        if (height < least) {
            mean = vec3_normalize(vec3_madd(mean, least - height, normals[k]));
        }
    }
    return mean;
}

air_vec3 air_area_reflect(const air_bsdf *bsdf, air_vec3 wo, const double (*polygon)[3],
                          size_t count)
{
    double normal[3], towards[3];
    vec3_store64(normal, bsdf->frame.n);
    vec3_store64(towards, wo);
    const double irradiance = air_area_irradiance(polygon, count, normal);
    if (!(irradiance > 0.0)) {
        return vec3_set1(0.0f);
    }
    if (bsdf->f90 == 0.0f) {
        return vec3_scale(bsdf->diffuse, (float)irradiance);
    }
    const air_vec3 smooth = air_bsdf_eval_smooth(bsdf, wo, mean_direction(bsdf, polygon, count));
    const double cos_o = (double)vec3_dot(wo, bsdf->frame.n);
    const air_area_ltc ltc = air_area_ltc_ggx((double)bsdf->alpha, cos_o);
    const double share = air_area_ltc_share(&ltc, polygon, count, normal, towards);
    return vec3_madd(vec3_scale(smooth, (float)(AIR_PI * irradiance)), (float)share,
                     air_bsdf_lobe_albedo(bsdf, wo));
}

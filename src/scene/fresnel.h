/* fresnel.h: what smooth interfaces reflect of unpolarised light. */
#ifndef AIR_SCENE_FRESNEL_H
#define AIR_SCENE_FRESNEL_H

#include "core/vec.h"

/* Between dielectrics, ior: index beyond the interface over that before it. *out_cos: cosine of the
 * refracted direction, 0 where all is reflected. cos_in in [0, 1]. */
static inline float air_fresnel_dielectric(float cos_in, float ior, float *out_cos)
{
    const float sin2 = float_max(0.0f, (1.0f - cos_in) * (1.0f + cos_in)) / (ior * ior);
    if (sin2 >= 1.0f) {
        *out_cos = 0.0f;
        return 1.0f;
    }
    const float cos_out = sqrtf(1.0f - sin2);
    const float across = (cos_in - ior * cos_out) / (cos_in + ior * cos_out);
    const float along = (ior * cos_in - cos_out) / (ior * cos_in + cos_out);
    *out_cos = cos_out;
    return float_min(0.5f * (across * across + along * along), 1.0f);
}

/* Of a metal with the complex index eta - i absorption over that before it [Born1999, sec. 14.2].
 */
static inline float air_fresnel_conductor(float cos_in, float eta, float absorption)
{
    const float cos2 = cos_in * cos_in, sin2 = float_max(0.0f, 1.0f - cos2);
    const float eta2 = eta * eta, absorption2 = absorption * absorption;
    const float t = eta2 - absorption2 - sin2;
    const float a2_b2 = sqrtf(t * t + 4.0f * eta2 * absorption2);
    const float a = sqrtf(float_max(0.0f, 0.5f * (a2_b2 + t)));
    const float sum = a2_b2 + cos2, twice = 2.0f * a * cos_in;
    const float across = (sum - twice) / (sum + twice);
    const float sum_along = cos2 * a2_b2 + sin2 * sin2, twice_along = twice * sin2;
    const float along = across * (sum_along - twice_along) / (sum_along + twice_along);
    return 0.5f * (across + along);
}

/* A direction w above a surface with normal n, w.n = cos_in > 0, goes on below it; cos_out as given
 * by air_fresnel_dielectric. Both point away from the surface. */
static inline air_vec3 air_refract(air_vec3 w, air_vec3 n, float cos_in, float cos_out, float ior)
{
    return vec3_madd(vec3_scale(w, -1.0f / ior), cos_in / ior - cos_out, n);
}

static inline air_vec3 air_reflect(air_vec3 w, air_vec3 n)
{
    return vec3_sub(vec3_scale(n, 2.0f * vec3_dot(w, n)), w);
}

#endif

/* warp.h: maps from the unit square to the domains that light is sampled on, each with its density.
 *
 * u1, u2 in [0, 1). Local frames have z as axis. */
#ifndef AIR_CORE_WARP_H
#define AIR_CORE_WARP_H

#include "core/angle.h"
#include "core/vec.h"

/* Unit disk by the concentric map [Shirley1997], which keeps strata compact. z = 0. */
static inline air_vec3 sample_disk_concentric(float u1, float u2)
{
    const float a = 2.0f * u1 - 1.0f, b = 2.0f * u2 - 1.0f;
    if (a == 0.0f && b == 0.0f) {
        return vec3_set1(0.0f);
    }
    const bool wide = fabsf(a) > fabsf(b);
    const float r = wide ? a : b, other = wide ? b : a;
    float across, along; /* of the angle from the nearer axis */
    air_sincos_eighth(AIR_PI_F / 4.0f * (other / r), &across, &along);
    return vec3(r * (wide ? along : across), r * (wide ? across : along), 0.0f);
}
/* Per area. */
static inline float sample_disk_concentric_pdf(void) { return 1.0f / AIR_PI_F; }

/* Hemisphere z >= 0 with density cos/pi: the disk projected upwards. */
static inline air_vec3 sample_cosine_hemisphere(float u1, float u2)
{
    const air_vec3 d = sample_disk_concentric(u1, u2);
    return vec3(d.x, d.y, sqrtf(float_max(0.0f, 1.0f - d.x * d.x - d.y * d.y)));
}
static inline float sample_cosine_hemisphere_pdf(float cos_theta)
{
    return float_max(cos_theta, 0.0f) * (1.0f / AIR_PI_F);
}

static inline air_vec3 sample_sphere(float u1, float u2)
{
    const float z = 1.0f - 2.0f * u1;
    const float r = 2.0f * sqrtf(u1 * (1.0f - u1)); /* sqrt(1 - z^2) without cancellation */
    float sine, cosine;
    air_sincos_turn(u2, &sine, &cosine);
    return vec3(r * cosine, r * sine, z);
}
static inline float sample_sphere_pdf(void) { return 1.0f / (4.0f * AIR_PI_F); }

/* Barycentrics of vertices 1 and 2, uniform in area. Folds the square over its diagonal as in
 * [Heitz2019], which moves points less than a square root does. */
static inline void sample_triangle(float u1, float u2, float *out_b1, float *out_b2)
{
    const float near = 0.5f * float_min(u1, u2), far = float_max(u1, u2) - near;
    *out_b1 = u1 < u2 ? near : far;
    *out_b2 = u1 < u2 ? far : near;
}
static inline float sample_triangle_pdf(float area) { return 1.0f / area; }

/* Directions within a cone around z, uniform in solid angle. The opening is given as 1 - cos, (0,
 * 2], so that a cone as narrow as the sun's keeps its digits. */
static inline air_vec3 sample_cone(float u1, float u2, float one_minus_cos_max)
{
    const float h = u1 * one_minus_cos_max;
    const float r = sqrtf(float_max(0.0f, h * (2.0f - h)));
    float sine, cosine;
    air_sincos_turn(u2, &sine, &cosine);
    return vec3(r * cosine, r * sine, 1.0f - h);
}
static inline float sample_cone_pdf(float one_minus_cos_max)
{
    return 1.0f / (2.0f * AIR_PI_F * one_minus_cos_max);
}

#endif

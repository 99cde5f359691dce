#include "scene/microfacets.h"

#define LEAST_ALPHA 1e-4f

air_facets air_facets_make(air_microfacets distribution, float alpha_u, float alpha_v)
{
    if (!(float_max(alpha_u, alpha_v) >= LEAST_ALPHA)) {
        return (air_facets){distribution, 0.0f, 0.0f};
    }
    return (air_facets){distribution, float_max(alpha_u, LEAST_ALPHA),
                        float_max(alpha_v, LEAST_ALPHA)};
}

/* [Walter2007, eqs. 25 and 33], stretched along two axes [Heitz2014, eqs. 79 and 85]. */
float air_facets_density(const air_facets *facets, air_vec3 h)
{
    const float x = h.x / facets->alpha_u, y = h.y / facets->alpha_v, z2 = h.z * h.z;
    const float area = AIR_PI_F * facets->alpha_u * facets->alpha_v;
    if (!(h.z > 0.0f)) {
        return 0.0f;
    }
    if (facets->distribution == AIR_MICROFACETS_BECKMANN) {
        const float bell = expf(-(x * x + y * y) / z2);
        return bell > 0.0f ? bell / (area * z2 * z2) : 0.0f; /* z2^2 may be 0 as well */
    }
    const float q = x * x + y * y + z2;
    return 1.0f / (area * q * q);
}

/* [Heitz2014, eqs. 68, 72 and 80]: 1 / (1 + lambda). */
float air_facets_seen(const air_facets *facets, air_vec3 w, air_vec3 h)
{
    const float x = facets->alpha_u * w.x, y = facets->alpha_v * w.y;
    const float slope2 = x * x + y * y, z = fabsf(w.z);
    if (!(vec3_dot(w, h) * w.z > 0.0f)) {
        return 0.0f;
    }
    if (facets->distribution == AIR_MICROFACETS_BECKMANN) {
        const float a = z / sqrtf(slope2);
        /* above, less than 1e-7 is hidden */
        return a < 3.5f ? 2.0f / (1.0f + erff(a) + expf(-a * a) / (a * sqrtf(AIR_PI_F))) : 1.0f;
    }
    return 2.0f * z / (z + sqrtf(z * z + slope2));
}

/* ---- sampling ---- */

/* GGX: a cap of the unit sphere, stretched back [Dupuy2023]. */
static air_vec3 sample_ggx(air_vec3 stretched, float u1, float u2)
{
    const float phi = 2.0f * AIR_PI_F * u1;
    const float up =
        (1.0f - u2) * (1.0f + stretched.z); /* z + stretched.z, exact near the bottom */
    const float z = up - stretched.z;
    const float radius = sqrtf(float_max(0.0f, (1.0f - z) * (1.0f + z)));
    return vec3(radius * cosf(phi) + stretched.x, radius * sinf(phi) + stretched.y, up);
}

/* A slope of Beckmann's distribution of width 1, as seen at a tangent `tan` from the normal, along
 * which it is drawn: density in proportion to exp(-s^2) (1 - s tan) up to s = 1 / tan, whose
 * integral is sqrt(pi)/2 (1 + erf s) + tan/2 exp(-s^2). Newton's steps within a shrinking bracket.
 */
static double beckmann_slope(double tan, double u)
{
    const double half = 0.5 * sqrt(AIR_PI);
    double low = -6.0, high = tan > 1.0 / 6.0 ? 1.0 / tan : 6.0, s = 0.0;
    const double whole = half * (1.0 + erf(high)) + 0.5 * tan * exp(-high * high);
    s = s < high ? s : 0.5 * (low + high);
    for (int i = 0; i < 40; i++) {
        const double bell = exp(-s * s);
        const double off = half * (1.0 + erf(s)) + 0.5 * tan * bell - u * whole;
        const double slope = bell * (1.0 - s * tan);
        low = off < 0.0 ? s : low;
        high = off < 0.0 ? high : s;
        const double next = s - off / slope;
        const bool inside = next > low && next < high;
        const double before = s;
        s = inside ? next : 0.5 * (low + high);
        if (fabs(s - before) < 1e-9) {
            break;
        }
    }
    return s;
}

/* Slopes along the view and across it are independent. */
static air_vec3 sample_beckmann(air_vec3 stretched, float u1, float u2)
{
    const float side = sqrtf(stretched.x * stretched.x + stretched.y * stretched.y);
    const float c = side > 0.0f ? stretched.x / side : 1.0f;
    const float s = side > 0.0f ? stretched.y / side : 0.0f;
    const double tan = double_min((double)side / (double)stretched.z, 1e6);
    const float along = (float)beckmann_slope(tan, (double)u1);
    const float across = (float)beckmann_slope(0.0, (double)u2);
    return vec3(-(c * along - s * across), -(s * along + c * across), 1.0f);
}

air_vec3 air_facets_sample(const air_facets *facets, air_vec3 w, float u1, float u2)
{
    const air_vec3 stretched =
        vec3_normalize(vec3(facets->alpha_u * w.x, facets->alpha_v * w.y, w.z));
    const air_vec3 h = facets->distribution == AIR_MICROFACETS_BECKMANN
                           ? sample_beckmann(stretched, u1, u2)
                           : sample_ggx(stretched, u1, u2);
    return vec3_normalize(vec3(facets->alpha_u * h.x, facets->alpha_v * h.y, h.z));
}

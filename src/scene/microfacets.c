#include "scene/microfacets.h"

#include "core/angle.h"

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
    float sine, cosine;
    air_sincos_turn(u1, &sine, &cosine);
    const float up =
        (1.0f - u2) * (1.0f + stretched.z); /* z + stretched.z, exact near the bottom */
    const float z = up - stretched.z;
    const float radius = sqrtf(float_max(0.0f, (1.0f - z) * (1.0f + z)));
    return vec3(radius * cosine + stretched.x, radius * sine + stretched.y, up);
}

/* The s at which 1 + erf(s) is q, 0 < q < 2, by [Giles2012]: off by 4e-7 of s. */
static float inverse_erf(float q)
{
    static const float middle[9] = {2.81022636e-08f,  3.43273939e-07f, -3.5233877e-06f,
                                    -4.39150654e-06f, 0.00021858087f,  -0.00125372503f,
                                    -0.00417768164f,  0.246640727f,    1.50140941f};
    static const float tail[9] = {-0.000200214257f, 0.000100950558f, 0.00134934322f,
                                  -0.00367342844f,  0.00573950773f,  -0.0076224613f,
                                  0.00943887047f,   1.00167406f,     2.83297682f};
    const float w = -logf(q * (2.0f - q)), x = w < 5.0f ? w - 2.5f : sqrtf(w) - 3.0f;
    const float *const c = w < 5.0f ? middle : tail;
    float sum = c[0];
    for (int i = 1; i < 9; i++) {
        sum = sum * x + c[i];
    }
    return sum * (q - 1.0f);
}

/* A slope s of Beckmann's distribution of width 1, as seen at a tangent `tan` from the normal,
 * along which it is drawn: density in proportion to exp(-s^2) (1 - s tan) up to s = 1 / tan, whose
 * integral is sqrt(pi)/2 (1 + erf s) + tan/2 exp(-s^2). Newton's steps in q = 1 + erf(s), in which
 * that is nearly a line, within a shrinking bracket: two or three of them. */
static float beckmann_slope(float tan, float u)
{
    const float half = 0.886226925f; /* sqrt(pi) / 2 */
    const float least = 1e-9f, end = tan > 1.0f / 6.0f ? 1.0f / tan : 6.0f;
    float low = 0.0f, high = 1.0f + erff(end), s = 0.0f;
    const float goal = u * (half * high + 0.5f * tan * expf(-end * end));
    float q = u * high / (1.0f + tan * (1.0f - u));
    for (int i = 0; i < 20; i++) {
        q = float_max(q, least);
        s = inverse_erf(q);
        const float off = half * q + 0.5f * tan * expf(-s * s) - goal;
        if (fabsf(off) <= 4e-7f * goal) {
            break;
        }
        low = off < 0.0f ? q : low;
        high = off < 0.0f ? high : q;
        const float next = q - off / (half * (1.0f - s * tan));
        q = next > low && next < high ? next : 0.5f * (low + high);
    }
    return s;
}

/* Slopes along the view and across it are independent. */
static air_vec3 sample_beckmann(air_vec3 stretched, float u1, float u2)
{
    const float side = sqrtf(stretched.x * stretched.x + stretched.y * stretched.y);
    const float c = side > 0.0f ? stretched.x / side : 1.0f;
    const float s = side > 0.0f ? stretched.y / side : 0.0f;
    const float along = beckmann_slope(float_min(side / stretched.z, 1e6f), u1);
    const float across = inverse_erf(float_max(2.0f * u2, 1e-9f));
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

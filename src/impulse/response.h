/* response.h: prepared responses: irradiance as polynomials in the normal's coordinates.
 *
 * A channel's entries lie on the cubic axis of rho = sigma d, where sigma is the slower of the two
 * extinctions that the medium and its reduced twin have (half of it where all orders are summed),
 * scaled by rho exp(fall rho)/sigma^2 (directional: exp(fall rho)). An entry is a polynomial in z =
 * n.l, and for area light x = n.x: against the powers of the normal it gives the irradiance.
 */
#ifndef AIR_IMPULSE_RESPONSE_H
#define AIR_IMPULSE_RESPONSE_H

#include <string.h>

#include "core/exponential.h"
#include "core/vec.h"
#include "impulse/polynomial.h"
#include "impulse/tables.h"

typedef struct response_channel {
    float sigma;          /* 0: nothing is scattered */
    float fall;           /* entries are scaled by exp(fall rho) */
    float reduced, whole; /* extinctions of the residual rule's excess, both 0 without */
    float *entries;       /* zonal [bin][8]; area [angle][bin][12] */
} response_channel;

typedef void impulse_batch(const air_impulse_response *response, const air_impulse_places *places,
                           size_t count, float *const *out);

struct air_impulse_response {
    air_context *context;
    impulse_batch *batch;
    air_impulse_emitter emitter;
    size_t bins, angles, channel_count;
    float first, scale;         /* of the bins in u */
    float quarter, angle_scale; /* angles of a right angle */
    response_channel channels[AIR_IMPULSE_CHANNELS_MAX];
};

impulse_batch impulse_batch_plain, impulse_batch_sse42, impulse_batch_avx2, impulse_batch_avx512;

typedef float four __attribute__((vector_size(16)));
typedef float eight __attribute__((vector_size(32)));

static inline four four_load(const float *p)
{
    four v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* By pointer: compilers warn of vectors that are passed by value where the set lacks them. */
static inline void eight_load(const float *p, eight *out) { memcpy(out, p, sizeof *out); }

/* The cube root of x in [1e-30, 1e30], relative error 3e-7: x^(-1/3) from the exponent to 4 %, then
 * twice y (1 + e/3 + 2 e^2/9), e = 1 - x y^3, of third order. */
static inline float impulse_cube_root(float x)
{
    float y = air_float_from_bits(0x54a20000u - air_float_bits(x) / 3u);
    for (int i = 0; i < 2; i++) {
        const float e = 1.0f - x * y * (y * y);
        y += y * e * (1.0f / 3.0f + e * (2.0f / 9.0f));
    }
    return x * y * y;
}

/* acos of c in [-1, 1], absolute error 5e-7 [Abramowitz1964, 4.4.46]. */
static inline float impulse_arc_cosine(float c)
{
    const float a = fabsf(c), a2 = a * a, a4 = a2 * a2;
    const float p01 = 1.5707963050f - 0.2145988016f * a, p23 = 0.0889789874f - 0.0501743046f * a;
    const float p45 = 0.0308918810f - 0.0170881256f * a, p67 = 0.0066700901f - 0.0012624911f * a;
    const float p = (p01 + p23 * a2) + (p45 + p67 * a2) * a4;
    const float angle = sqrtf(1.0f - a) * p;
    return 0.5f * AIR_PI_F - copysignf(0.5f * AIR_PI_F - angle, c);
}

/* exp(x), x <= 0; that of -86 below. */
static inline float impulse_exp(float x)
{
    float power;
    const float p = air_exp_parts(float_max(x, -86.0f), &power);
    return (p + 1.0f) * power;
}

static inline float clamp_cosine(float c) { return float_max(-1.0f, float_min(1.0f, c)); }

/* An index and the share of the next entry. */
typedef struct response_place {
    int32_t lower;
    float share;
} response_place;

static inline response_place response_angle(const air_impulse_response *r, float cos_s)
{
    const float turned = impulse_arc_cosine(clamp_cosine(cos_s)) * r->angle_scale;
    const float at = turned + float_max(0.0f, turned - r->quarter);
    const int32_t lower = (int32_t)float_min(at, (float)(int32_t)r->angles - 2.0f);
    return (response_place){lower, at - (float)lower};
}

/* The bin, and what turns its entry into an irradiance: 0 beyond the last one. */
static inline response_place response_bin(const air_impulse_response *r, const response_channel *c,
                                          float distance, float *out_scale)
{
    const float rho = float_max(c->sigma * distance, 1e-20f);
    const float u = impulse_cube_root(rho * (float)(1.0 / IMPULSE_TAU_GREATEST));
    const float last = (float)(int32_t)r->bins - 1.0f;
    const float at = float_min(last, float_max(0.0f, (u - r->first) * r->scale));
    const int32_t lower = (int32_t)float_min(at, last - 1.0f);
    const float fall = impulse_exp(-c->fall * rho);
    const float scale = r->emitter == AIR_IMPULSE_DIRECTIONAL ? fall : fall * c->sigma / distance;
    const float inside = c->sigma > 0.0f ? scale : 0.0f;
    *out_scale = rho <= (float)IMPULSE_TAU_GREATEST ? inside : 0.0f;
    return (response_place){lower, at - (float)lower};
}

static inline float zonal_sum(const float *at, float share, float n_l)
{
    const float z = clamp_cosine(n_l), z2 = z * z, z4 = z2 * z2, z8 = z4 * z4;
    const eight powers = {1.0f, z, z2, z4, z4 * z2, z8, z8 * z2, 0.0f};
    eight a, b;
    eight_load(at, &a);
    eight_load(at + ZONAL_POWERS, &b);
    const eight s = (a + share * (b - a)) * powers;
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

static inline float area_sum(const float *at, size_t angle_step, float share, float angle_share,
                             float n_l, float n_x)
{
    const float *const up = at + angle_step;
    const float z = clamp_cosine(n_l), x = clamp_cosine(n_x), z2 = z * z, x2 = x * x, xz = x * z;
    const eight powers = {1.0f, z, x, z2, xz, x2, z2 * z2, xz * z2};
    const four rest = {x2 * z2, xz * x2, x2 * x2, 0.0f};
    eight a, b, c, d;
    eight_load(at, &a);
    eight_load(at + AREA_POWERS, &b);
    eight_load(up, &c);
    eight_load(up + AREA_POWERS, &d);
    const eight low = a + share * (b - a), high = c + share * (d - c);
    const eight s = (low + angle_share * (high - low)) * powers;
    const four e = four_load(at + 8), f = four_load(at + AREA_POWERS + 8);
    const four g = four_load(up + 8), h = four_load(up + AREA_POWERS + 8);
    const four low_rest = e + share * (f - e), high_rest = g + share * (h - g);
    const four t = (low_rest + angle_share * (high_rest - low_rest)) * rest;
    return (((s[0] + s[4]) + t[0]) + ((s[2] + s[6]) + t[2])) +
           (((s[1] + s[5]) + t[1]) + ((s[3] + s[7]) + t[3]));
}

/* The residual rule's unscattered light. */
static inline float response_excess(const air_impulse_response *r, const response_channel *c,
                                    float distance, float n_l, float cos_s)
{
    const float more = impulse_exp(-c->reduced * distance) - impulse_exp(-c->whole * distance);
    const float facing = float_max(0.0f, n_l) * more;
    const float spread = facing / (distance * distance);
    const float cosine = r->emitter == AIR_IMPULSE_AREA ? float_max(0.0f, cos_s) : 1.0f;
    return r->emitter == AIR_IMPULSE_DIRECTIONAL ? facing : spread * cosine;
}

#endif

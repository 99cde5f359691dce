/* response.h: prepared responses: irradiance as polynomials in the normal's coordinates.
 *
 * A channel's entries lie on the cubic axis of rho = sigma d, where sigma is the slower of the two
 * extinctions that the medium and its reduced twin have, scaled by rho exp(rho)/sigma^2
 * (directional: exp(rho)). An entry is a polynomial in z = n.l, and for area light x = n.x: against
 * the powers of the normal it gives the irradiance. */
#ifndef AIR_IMPULSE_RESPONSE_H
#define AIR_IMPULSE_RESPONSE_H

#include <string.h>

#include "core/exponential.h"
#include "impulse/tables.h"

enum {
    ZONAL_POWERS = 8, /* 1, z, z^2, z^4, z^6, z^8, z^10, none */
    AREA_POWERS = 12  /* 1, z, x, z^2, xz, x^2, z^4, xz^3, x^2 z^2, x^3 z, x^4, none */
};

typedef struct response_channel {
    float sigma;          /* 0: nothing is scattered */
    float reduced, whole; /* extinctions of the residual rule's excess, both 0 without */
    float *entries;       /* zonal [bin][8]; area [angle][bin][12] */
} response_channel;

struct air_impulse_response {
    air_context *context;
    air_impulse_emitter emitter;
    size_t bins, angles, channel_count;
    float first, scale; /* of the bins in u */
    float angle_scale;
    response_channel channels[AIR_IMPULSE_CHANNELS_MAX];
};

typedef float four __attribute__((vector_size(16)));

static inline four four_load(const float *p)
{
    four v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* The cube root of x in [1e-30, 1e30], relative error 3e-7: x^(-1/3) from the exponent, then twice
 * y (1 + e/3 + 2 e^2/9), e = 1 - x y^3, of third order. */
static inline float impulse_cube_root(float x)
{
    float y = air_float_from_bits(0x54a20000u - air_float_bits(x) / 3u);
    for (int i = 0; i < 2; i++) {
        const float e = 1.0f - x * y * (y * y);
        y += y * e * (1.0f / 3.0f + e * (2.0f / 9.0f));
    }
    return x * y * y;
}

/* acos of c in [-1, 1], absolute error 2e-7 [Abramowitz1964, 4.4.46]. */
static inline float impulse_arc_cosine(float c)
{
    const float a = c < 0.0f ? -c : c, a2 = a * a, a4 = a2 * a2;
    const float p01 = 1.5707963050f - 0.2145988016f * a, p23 = 0.0889789874f - 0.0501743046f * a;
    const float p45 = 0.0308918810f - 0.0170881256f * a, p67 = 0.0066700901f - 0.0012624911f * a;
    const float p = (p01 + p23 * a2) + (p45 + p67 * a2) * a4;
    const float angle = sqrtf(1.0f - a) * p;
    return c < 0.0f ? 3.14159265f - angle : angle;
}

#endif

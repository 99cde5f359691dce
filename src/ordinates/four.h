/* four.h: four floats at once, in any instruction set: the channels of a cell. */
#ifndef AIR_ORDINATES_FOUR_H
#define AIR_ORDINATES_FOUR_H

#include <stdint.h>
#include <string.h>

typedef float four __attribute__((vector_size(16)));
typedef int32_t four_ints __attribute__((vector_size(16)));

static inline four four_load(const float *p)
{
    four v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void four_store(float *p, four v) { memcpy(p, &v, sizeof v); }

static inline four four_all(float x) { return (four){x, x, x, x}; }

static inline four four_select(four_ints mask, four a, four b)
{
    return (four)(((four_ints)a & mask) | ((four_ints)b & ~mask));
}

static inline four four_max(four a, four b) { return four_select(a > b, a, b); }
static inline four four_min(four a, four b) { return four_select(a < b, a, b); }

/* exp(x) for x in [-87, 0], as air_exp (core/exponential.h): relative error 1e-7. */
static inline four four_exp(four x)
{
    const four_ints n = __builtin_convertvector(x * 1.44269504f - 0.5f, four_ints);
    const four whole = __builtin_convertvector(n, four);
    const four r = (x - whole * 0.693359375f) + whole * 2.12194440e-4f, r2 = r * r;
    const four p23 = 0.5f + r * (1.0f / 6.0f);
    const four p45 = 1.0f / 24.0f + r * (1.0f / 120.0f);
    const four p67 = 1.0f / 720.0f + r * (1.0f / 5040.0f);
    const four p = r + r2 * (p23 + r2 * (p45 + r2 * p67));
    return (p + 1.0f) * (four)((n + 127) << 23);
}

#endif

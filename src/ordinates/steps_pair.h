/* steps_pair.h: two vectors of floats side by side, for the instruction set of the including file.
 *
 * Steps are long chains of arithmetic of which each waits for the one before; processors look ahead
 * over few of them. Two chains of which the operations alternate take little longer than one. */
#ifndef AIR_ORDINATES_STEPS_PAIR_H
#define AIR_ORDINATES_STEPS_PAIR_H

#include "core/lanes_float.h"

enum { PAIR = 2 * LANES };

typedef struct pair {
    lanes a, b;
} pair;

static inline pair pair_all(float x) { return (pair){lanes_all(x), lanes_all(x)}; }
static inline pair pair_load(const float *p)
{
    return (pair){lanes_load(p), lanes_load(p + LANES)};
}
static inline void pair_store(float *p, pair x)
{
    lanes_store(p, x.a);
    lanes_store(p + LANES, x.b);
}
static inline pair pair_add(pair x, pair y) { return (pair){x.a + y.a, x.b + y.b}; }
static inline pair pair_sub(pair x, pair y) { return (pair){x.a - y.a, x.b - y.b}; }
static inline pair pair_mul(pair x, pair y) { return (pair){x.a * y.a, x.b * y.b}; }
static inline pair pair_min(pair x, pair y)
{
    return (pair){lanes_min(x.a, y.a), lanes_min(x.b, y.b)};
}
static inline pair pair_max(pair x, pair y)
{
    return (pair){lanes_max(x.a, y.a), lanes_max(x.b, y.b)};
}
/* x y + z and z - x y */
static inline pair pair_madd(pair x, pair y, pair z)
{
    return (pair){lanes_madd(x.a, y.a, z.a), lanes_madd(x.b, y.b, z.b)};
}
static inline pair pair_nmadd(pair x, pair y, pair z)
{
    return (pair){lanes_nmadd(x.a, y.a, z.a), lanes_nmadd(x.b, y.b, z.b)};
}
static inline pair pair_rough_inverse(pair x)
{
    return (pair){lanes_rough_inverse(x.a), lanes_rough_inverse(x.b)};
}
static inline pair pair_rough_inverse_root(pair x)
{
    return (pair){lanes_rough_inverse_root(x.a), lanes_rough_inverse_root(x.b)};
}

/* In the order of a tree. */
static inline double pair_sum(pair x)
{
    float parts[LANES];
    lanes_store(parts, x.a + x.b);
    for (int half = LANES / 2; half >= 1; half /= 2) {
        for (int i = 0; i < half; i++) {
            parts[i] += parts[i + half];
        }
    }
    return (double)parts[0];
}

#endif

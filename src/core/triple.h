/* triple.h: triples of doubles, as the kernels take points and directions. */
#ifndef AIR_CORE_TRIPLE_H
#define AIR_CORE_TRIPLE_H

#include <math.h>
#include <stdbool.h>

static inline bool air_finite3(const double v[3])
{
    return (v[0] - v[0]) + (v[1] - v[1]) + (v[2] - v[2]) == 0.0;
}

static inline double air_dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double air_length3(const double v[3]) { return sqrt(air_dot3(v, v)); }

static inline void air_cross3(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void air_copy3(const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = v[i];
    }
}

static inline void air_subtract3(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] - b[i];
    }
}

/* a + s b; out may be a or b. */
static inline void air_along3(const double a[3], double s, const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] + s * b[i];
    }
}

/* Unit vectors s, t across the unit vector n, right-handed with it [Duff2017]. */
static inline void air_axes_across(const double n[3], double s[3], double t[3])
{
    const double sign = copysign(1.0, n[2]);
    const double a = -1.0 / (sign + n[2]), b = n[0] * n[1] * a;
    s[0] = 1.0 + sign * n[0] * n[0] * a;
    s[1] = sign * b;
    s[2] = -sign * n[0];
    t[0] = b;
    t[1] = sign + n[1] * n[1] * a;
    t[2] = -n[1];
}

#endif

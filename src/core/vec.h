/* vec.h: three-vectors of float (points, directions, RGB), frames and 3x4 affine maps; all inline.
 */
#ifndef AIR_CORE_VEC_H
#define AIR_CORE_VEC_H

#include <math.h>
#include <stdbool.h>

#define AIR_PI   3.14159265358979323846
#define AIR_PI_F 3.14159265358979f

/* One instruction each; fminf and fmaxf are calls, for the sake of NaN. Where one operand is NaN,
 * the second is given. */
static inline float float_min(float a, float b) { return a < b ? a : b; }
static inline float float_max(float a, float b) { return a > b ? a : b; }
static inline double double_min(double a, double b) { return a < b ? a : b; }
static inline double double_max(double a, double b) { return a > b ? a : b; }

typedef struct air_vec3 {
    float x, y, z;
} air_vec3;

static inline air_vec3 vec3(float x, float y, float z) { return (air_vec3){x, y, z}; }
static inline air_vec3 vec3_set1(float s) { return (air_vec3){s, s, s}; }
static inline air_vec3 vec3_load(const float v[3]) { return (air_vec3){v[0], v[1], v[2]}; }
static inline void vec3_store64(double out[3], air_vec3 v)
{
    out[0] = (double)v.x;
    out[1] = (double)v.y;
    out[2] = (double)v.z;
}
static inline void vec3_store(float out[3], air_vec3 v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}
static inline air_vec3 vec3_add(air_vec3 a, air_vec3 b)
{
    return vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline air_vec3 vec3_sub(air_vec3 a, air_vec3 b)
{
    return vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline air_vec3 vec3_mul(air_vec3 a, air_vec3 b)
{
    return vec3(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline air_vec3 vec3_scale(air_vec3 a, float s) { return vec3(a.x * s, a.y * s, a.z * s); }
static inline air_vec3 vec3_neg(air_vec3 a) { return vec3(-a.x, -a.y, -a.z); }
/* a + s b */
static inline air_vec3 vec3_madd(air_vec3 a, float s, air_vec3 b)
{
    return vec3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
static inline float vec3_dot(air_vec3 a, air_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline air_vec3 vec3_cross(air_vec3 a, air_vec3 b)
{
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float vec3_length(air_vec3 a) { return sqrtf(vec3_dot(a, a)); }
static inline air_vec3 vec3_normalize(air_vec3 a) { return vec3_scale(a, 1.0f / vec3_length(a)); }
/* Of length 1; what has it already, but for rounding, stays as it is: a direction that is told on
 * does not move. */
static inline air_vec3 vec3_unit(air_vec3 a)
{
    return fabsf(vec3_dot(a, a) - 1.0f) < 1e-6f ? a : vec3_normalize(a);
}
static inline float vec3_max(air_vec3 a) { return float_max(a.x, float_max(a.y, a.z)); }
static inline float vec3_min(air_vec3 a) { return float_min(a.x, float_min(a.y, a.z)); }
static inline float vec3_mean(air_vec3 a) { return (a.x + a.y + a.z) * (1.0f / 3.0f); }
static inline bool vec3_is_zero(air_vec3 a) { return a.x == 0.0f && a.y == 0.0f && a.z == 0.0f; }
static inline bool vec3_is_finite(air_vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}
static inline air_vec3 vec3_exp(air_vec3 a) { return vec3(expf(a.x), expf(a.y), expf(a.z)); }
/* Rec. 709 luminance */
static inline float vec3_luminance(air_vec3 a)
{
    return 0.2126f * a.x + 0.7152f * a.y + 0.0722f * a.z;
}

/* An orthonormal frame; n is its z axis. */
typedef struct air_frame {
    air_vec3 s, t, n;
} air_frame;

/* [Duff2017] "Building an Orthonormal Basis, Revisited". n must be unit. */
static inline air_frame frame_from_normal(air_vec3 n)
{
    const float sign = copysignf(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return (air_frame){vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
                       vec3(b, sign + n.y * n.y * a, -n.y), n};
}
static inline air_vec3 frame_to_world(const air_frame *f, air_vec3 v)
{
    return vec3_madd(vec3_madd(vec3_scale(f->s, v.x), v.y, f->t), v.z, f->n);
}
static inline air_vec3 frame_to_local(const air_frame *f, air_vec3 v)
{
    return vec3(vec3_dot(v, f->s), vec3_dot(v, f->t), vec3_dot(v, f->n));
}

/* 3x4 affine maps: 3 rows of 4. */
static inline air_vec3 affine_point(const float m[12], air_vec3 p)
{
    return vec3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}
static inline air_vec3 affine_vector(const float m[12], air_vec3 v)
{
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
                m[8] * v.x + m[9] * v.y + m[10] * v.z);
}
/* v as a covector of the inverse map: multiply by the transpose of inverse. */
static inline air_vec3 affine_normal(const float inverse[12], air_vec3 n)
{
    return vec3(inverse[0] * n.x + inverse[4] * n.y + inverse[8] * n.z,
                inverse[1] * n.x + inverse[5] * n.y + inverse[9] * n.z,
                inverse[2] * n.x + inverse[6] * n.y + inverse[10] * n.z);
}
static inline double affine_determinant(const float m[12])
{
    return (double)m[0] * ((double)m[5] * m[10] - (double)m[6] * m[9]) -
           (double)m[1] * ((double)m[4] * m[10] - (double)m[6] * m[8]) +
           (double)m[2] * ((double)m[4] * m[9] - (double)m[5] * m[8]);
}

/* out = a after b; out may be a or b. */
void affine_multiply(const float a[12], const float b[12], float out[12]);
/* False if m is singular or not finite. */
bool affine_invert(const float m[12], float out[12]);

#endif

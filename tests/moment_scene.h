/* moment_scene.h: a ball in a box of fog under light from infinity, solved exactly: scene A of the
 * collimated method's comparison [Velinov2021]. Independent of the library's own closed forms. */
#ifndef AIR_TESTS_MOMENT_SCENE_H
#define AIR_TESTS_MOMENT_SCENE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "core/random.h"

static const double SCENE_CAMERA[3] = {0.5, 1.0, 3.5};
static const double SCENE_BALL[3] = {0.2, 0.4, 0.0};
static const double SCENE_RADIUS = 0.5;
static const double SCENE_SIGMA_T = 1.0;

static inline double scene_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void scene_normalize(double v[3])
{
    const double length = sqrt(scene_dot(v, v));
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

static inline double uniform(air_rng *rng, double low, double high)
{
    return low + (high - low) * (double)air_rng_float(rng);
}

static inline void random_unit(air_rng *rng, double out[3])
{
    do {
        for (int i = 0; i < 3; i++) {
            out[i] = uniform(rng, -1.0, 1.0);
        }
    } while (!(scene_dot(out, out) > 0.01 && scene_dot(out, out) < 1.0));
    scene_normalize(out);
}

static inline void scene_light(double out[3])
{
    out[0] = -0.3;
    out[1] = 0.6;
    out[2] = -0.3;
    scene_normalize(out);
}

/* The ray through the centre of a pixel of a square image, field of view 40 degrees, aimed at the
 * origin. */
static inline void scene_ray(size_t size, size_t x, size_t y, double out[3])
{
    double f[3] = {-SCENE_CAMERA[0], -SCENE_CAMERA[1], -SCENE_CAMERA[2]};
    scene_normalize(f);
    double r[3] = {-f[2], 0.0, f[0]}; /* f x (0, 1, 0) */
    scene_normalize(r);
    const double u[3] = {r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2],
                         r[0] * f[1] - r[1] * f[0]};
    const double half = tan(20.0 * 3.14159265358979323846 / 180.0);
    const double sx = (2.0 * ((double)x + 0.5) / (double)size - 1.0) * half;
    const double sy = (1.0 - 2.0 * ((double)y + 0.5) / (double)size) * half;
    for (int i = 0; i < 3; i++) {
        out[i] = f[i] + sx * r[i] + sy * u[i];
    }
    scene_normalize(out);
}

/* Where the line o + t d is inside the unit ball scaled by radius, o relative to its centre; with
 * flat set, inside the cylinder along the unit vector flat instead. False if nowhere. */
static inline bool scene_quadric(const double o[3], const double d[3], const double *flat,
                                 double radius, double *t0, double *t1)
{
    double a = 1.0, b = scene_dot(o, d), c = scene_dot(o, o) - radius * radius;
    if (flat != NULL) {
        const double df = scene_dot(d, flat), of = scene_dot(o, flat);
        a -= df * df;
        b -= df * of;
        c -= of * of;
    }
    const double square = b * b - a * c;
    if (!(square > 0.0 && a > 0.0)) {
        return false;
    }
    *t0 = (-b - sqrt(square)) / a;
    *t1 = (-b + sqrt(square)) / a;
    return true;
}

/* One pixel: the stretch of fog before the ball, and its part in shadow (s0 = s1 if none). */
typedef struct scene_pixel {
    double dir[3], light[3];
    double a, b;
    double s0, s1;
} scene_pixel;

/* Distance to the boundary of [-1, 1]^3 from a point inside, along dir. */
static inline double scene_exit(const double point[3], const double dir[3])
{
    double d = INFINITY;
    for (int i = 0; i < 3; i++) {
        if (fabs(dir[i]) > 1e-15) {
            d = fmin(d, (copysign(1.0, dir[i]) - point[i]) / dir[i]);
        }
    }
    return d;
}

/* False if the ray misses the box. */
static inline bool scene_pixel_make(size_t size, size_t x, size_t y, scene_pixel *p)
{
    scene_ray(size, x, y, p->dir);
    scene_light(p->light);
    p->a = 0.0;
    p->b = INFINITY;
    for (int i = 0; i < 3; i++) {
        const double t0 = (-1.0 - SCENE_CAMERA[i]) / p->dir[i];
        const double t1 = (1.0 - SCENE_CAMERA[i]) / p->dir[i];
        p->a = fmax(p->a, fmin(t0, t1));
        p->b = fmin(p->b, fmax(t0, t1));
    }
    double o[3], t0, t1;
    for (int i = 0; i < 3; i++) {
        o[i] = SCENE_CAMERA[i] - SCENE_BALL[i];
    }
    double begin = INFINITY, end = -INFINITY;
    if (scene_quadric(o, p->dir, NULL, SCENE_RADIUS, &t0, &t1)) {
        p->b = t0 > 0.0 ? fmin(p->b, t0) : p->b;
        begin = t0;
        end = t1;
    }
    /* The half cylinder under the ball's centre. */
    if (scene_quadric(o, p->dir, p->light, SCENE_RADIUS, &t0, &t1)) {
        const double rise = scene_dot(p->dir, p->light), level = -scene_dot(o, p->light) / rise;
        t0 = rise < 0.0 ? fmax(t0, level) : t0;
        t1 = rise > 0.0 ? fmin(t1, level) : t1;
        if (t0 < t1) {
            begin = fmin(begin, t0);
            end = fmax(end, t1);
        }
    }
    p->s0 = fmin(fmax(begin, p->a), p->b);
    p->s1 = fmax(fmin(end, p->b), p->s0);
    return p->a < p->b;
}

/* Optical depth to t and from there to the light. */
static inline double scene_depth(const scene_pixel *p, double t)
{
    double x[3];
    for (int i = 0; i < 3; i++) {
        x[i] = SCENE_CAMERA[i] + t * p->dir[i];
    }
    return SCENE_SIGMA_T * (t - p->a + fmax(scene_exit(x, p->light), 0.0));
}

/* Integral of exp(-depth) over [t0, t1] within [a, b]: the depth is affine between the candidates
 * where two faces towards the light are equally far. */
static inline double scene_integral(const scene_pixel *p, double t0, double t1)
{
    double cut[8] = {t0, t1};
    size_t count = 2;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < i; k++) {
            const double li = p->light[i], lk = p->light[k];
            const double ni = copysign(1.0, li) - SCENE_CAMERA[i];
            const double nk = copysign(1.0, lk) - SCENE_CAMERA[k];
            const double t = (ni * lk - nk * li) / (p->dir[i] * lk - p->dir[k] * li);
            if (t > t0 && t < t1) {
                cut[count++] = t;
            }
        }
    }
    for (size_t i = 1; i < count; i++) {
        for (size_t k = i; k > 0 && cut[k - 1] > cut[k]; k--) {
            const double moved = cut[k];
            cut[k] = cut[k - 1];
            cut[k - 1] = moved;
        }
    }
    double sum = 0.0;
    for (size_t i = 0; i + 1 < count; i++) {
        const double e0 = scene_depth(p, cut[i]), e1 = scene_depth(p, cut[i + 1]);
        const double x = fabs(e1 - e0);
        sum += (cut[i + 1] - cut[i]) * exp(-fmin(e0, e1)) * (x > 0.0 ? -expm1(-x) / x : 1.0);
    }
    return sum;
}

/* The height of the ball's upper side over the camera, at a point of the plane perpendicular to
 * the light (any height); -INFINITY beside the ball. */
static inline double scene_height(const double point[3])
{
    double light[3], o[3];
    scene_light(light);
    for (int i = 0; i < 3; i++) {
        o[i] = point[i] - SCENE_BALL[i];
    }
    const double rise = scene_dot(o, light);
    const double square = SCENE_RADIUS * SCENE_RADIUS - (scene_dot(o, o) - rise * rise);
    return square >= 0.0
               ? scene_dot(SCENE_BALL, light) + sqrt(square) - scene_dot(SCENE_CAMERA, light)
               : -INFINITY;
}

#endif

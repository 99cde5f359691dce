/* roombeam_exact.h: the roombeam picture (direct light on surfaces + single scattering) by
 * quadrature, in doubles and independent of the library. Everything here is in the scene's own
 * axes, z up.
 *
 * Visibility is not sampled: along a camera ray the exact sphere shadows one interval, because the
 * shadowed set (the ball and the half cylinder behind it) is convex. Between the ends of that
 * interval and the kinks of the distance to the box's boundary the integrand is the exponential of
 * a linear function, which Gauss-Legendre quadrature with 8 nodes integrates to rounding.
 */
#ifndef ROOMBEAM_EXACT_H
#define ROOMBEAM_EXACT_H

#include <math.h>
#include <stdbool.h>

typedef struct exact_vec {
    double x, y, z;
} exact_vec;

typedef struct exact_interval {
    double t0, t1; /* empty unless t0 < t1 */
} exact_interval;

typedef struct exact_pixel {
    double surface; /* S0: direct light on floor or sphere, as it reaches the camera */
    double medium;  /* M1: single scattering */
    bool fog_only;  /* the ray crosses the box and hits neither floor nor sphere */
} exact_pixel;

enum { ROOMBEAM_WIDTH = 640, ROOMBEAM_HEIGHT = 480 };

static const double exact_pi = 3.14159265358979323846;
static const double roombeam_sigma_s = 0.25, roombeam_sigma_t = 0.30, roombeam_g = 0.3;
static const double roombeam_albedo = 0.5; /* of floor and sphere */
static const double roombeam_radius = 0.5, roombeam_floor_z = -0.001, roombeam_floor_half = 6.0;
static const exact_vec roombeam_box_min = {-2.0, -2.0, 0.0}, roombeam_box_max = {2.0, 2.0, 3.0};
static const exact_vec roombeam_centre = {0.0, 0.0, 1.5};
static const exact_vec roombeam_to_light = {-0.70710678118654752440, 0.0, 0.70710678118654752440};

static inline exact_vec exact_sub(exact_vec a, exact_vec b)
{
    return (exact_vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline double exact_dot(exact_vec a, exact_vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline exact_vec exact_at(exact_vec o, double t, exact_vec v)
{
    return (exact_vec){o.x + t * v.x, o.y + t * v.y, o.z + t * v.z};
}

static inline exact_vec exact_unit(exact_vec v)
{
    const double s = 1.0 / sqrt(exact_dot(v, v));
    return (exact_vec){v.x * s, v.y * s, v.z * s};
}

static inline exact_vec exact_cross(exact_vec a, exact_vec b)
{
    return (exact_vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline exact_interval exact_overlap(exact_interval a, exact_interval b)
{
    return (exact_interval){fmax(a.t0, b.t0), fmin(a.t1, b.t1)};
}

/* Where o + t v, t >= 0, is in the box. */
static inline exact_interval exact_box(exact_vec o, exact_vec v)
{
    const double po[3] = {o.x, o.y, o.z}, pv[3] = {v.x, v.y, v.z};
    const double lo[3] = {roombeam_box_min.x, roombeam_box_min.y, roombeam_box_min.z};
    const double hi[3] = {roombeam_box_max.x, roombeam_box_max.y, roombeam_box_max.z};
    exact_interval r = {0.0, INFINITY};
    for (int k = 0; k < 3; ++k) {
        if (pv[k] == 0.0) {
            if (po[k] < lo[k] || po[k] > hi[k])
                return (exact_interval){0.0, 0.0};
            continue;
        }
        const double a = (lo[k] - po[k]) / pv[k], b = (hi[k] - po[k]) / pv[k];
        r = exact_overlap(r, (exact_interval){fmin(a, b), fmax(a, b)});
    }
    return r;
}

/* Length of o + t v, 0 <= t <= t_end, inside the box. */
static inline double exact_box_length(exact_vec o, exact_vec v, double t_end)
{
    const exact_interval r = exact_overlap(exact_box(o, v), (exact_interval){0.0, t_end});
    return fmax(0.0, r.t1 - r.t0);
}

/* Where a t^2 + 2 b t + c <= 0, a > 0. */
static inline exact_interval exact_quadratic(double a, double b, double c)
{
    const double disc = b * b - a * c;
    if (disc <= 0.0)
        return (exact_interval){0.0, 0.0};
    const double root = sqrt(disc);
    return (exact_interval){(-b - root) / a, (-b + root) / a};
}

static inline exact_interval exact_ball(exact_vec o, exact_vec v)
{
    const exact_vec m = exact_sub(o, roombeam_centre);
    return exact_quadratic(1.0, exact_dot(m, v),
                           exact_dot(m, m) - roombeam_radius * roombeam_radius);
}

/* The part of a line the sphere keeps the light from: hull of its parts in the ball and in the half
 * cylinder {distance to the axis <= R, (x - centre).l <= 0}. */
static inline exact_interval exact_shadow(exact_vec o, exact_vec v)
{
    const exact_vec l = roombeam_to_light, m = exact_sub(o, roombeam_centre);
    const double ml = exact_dot(m, l), vl = exact_dot(v, l);
    const exact_vec mp = exact_at(m, -ml, l), vp = exact_at(v, -vl, l);
    const double a = exact_dot(vp, vp), c = exact_dot(mp, mp) - roombeam_radius * roombeam_radius;
    exact_interval tube = {-INFINITY, INFINITY};
    if (a > 1e-30)
        tube = exact_quadratic(a, exact_dot(mp, vp), c);
    else if (c > 0.0)
        tube.t1 = -INFINITY;
    if (vl > 0.0)
        tube.t1 = fmin(tube.t1, -ml / vl);
    else if (vl < 0.0)
        tube.t0 = fmax(tube.t0, -ml / vl);
    else if (ml > 0.0)
        tube.t1 = -INFINITY;
    const exact_interval ball = exact_ball(o, v);
    if (!(tube.t0 < tube.t1))
        return ball;
    if (!(ball.t0 < ball.t1))
        return tube;
    return (exact_interval){fmin(tube.t0, ball.t0), fmax(tube.t1, ball.t1)};
}

/* exp(-optical depth) of the light's way to x inside the box. */
static inline double exact_light_transmittance(exact_vec x)
{
    return exp(-roombeam_sigma_t * exact_box_length(x, roombeam_to_light, INFINITY));
}

/* Integral over [t0, t1] of exp(-sigma_t (t - t_enter)) times the light's transmittance; smooth
 * between kinks. */
static inline double exact_gauss(exact_vec o, exact_vec v, double t_enter, double t0, double t1)
{
    static const double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                   0.9602898564975363};
    static const double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                     0.1012285362903763};
    const double mid = 0.5 * (t0 + t1), half = 0.5 * (t1 - t0);
    double sum = 0.0;
    for (int k = 0; k < 8; ++k) {
        const double t = mid + (k < 4 ? -half : half) * node[k & 3];
        sum += weight[k & 3] * exp(-roombeam_sigma_t * (t - t_enter)) *
               exact_light_transmittance(exact_at(o, t, v));
    }
    return half * sum;
}

/* The same over any interval inside the box: split where the light path's exit face changes. Both
 * ways lead out through z = max (distance (z_max - z) sqrt 2) or x = min (distance (x - x_min) sqrt
 * 2). */
static inline double exact_inscatter(exact_vec o, exact_vec v, double t_enter, exact_interval lit)
{
    if (!(lit.t0 < lit.t1))
        return 0.0;
    const double slope = -v.z - v.x;
    const double kink = (o.x - roombeam_box_min.x - (roombeam_box_max.z - o.z)) / slope;
    if (slope != 0.0 && kink > lit.t0 && kink < lit.t1)
        return exact_gauss(o, v, t_enter, lit.t0, kink) + exact_gauss(o, v, t_enter, kink, lit.t1);
    return exact_gauss(o, v, t_enter, lit.t0, lit.t1);
}

/* [Henyey1941]; light travels along -l and is scattered to the camera, along -v. */
static inline double exact_phase(exact_vec v)
{
    const double c = exact_dot(roombeam_to_light, v), g = roombeam_g;
    return (1.0 - g * g) / (4.0 * exact_pi * pow(1.0 + g * g - 2.0 * g * c, 1.5));
}

/* Distance to floor or sphere along a camera ray and the surface's normal; false: neither is hit.
 */
static inline bool exact_surface(exact_vec o, exact_vec v, double *t, exact_vec *normal)
{
    const exact_interval ball = exact_ball(o, v);
    if (ball.t0 < ball.t1 && ball.t0 > 0.0) {
        *t = ball.t0;
        *normal = exact_unit(exact_sub(exact_at(o, *t, v), roombeam_centre));
        return true;
    }
    if (!(v.z < 0.0))
        return false;
    *t = (roombeam_floor_z - o.z) / v.z;
    const exact_vec x = exact_at(o, *t, v);
    *normal = (exact_vec){0.0, 0.0, 1.0};
    return fabs(x.x) <= roombeam_floor_half && fabs(x.y) <= roombeam_floor_half;
}

/* Reflected direct light: albedo/pi times irradiance, irradiance pi n.l times transmittance and
 * visibility. */
static inline double exact_surface_radiance(exact_vec x, exact_vec normal)
{
    const double cosine = exact_dot(normal, roombeam_to_light);
    /* On the sphere itself the shadow is where the normal turns away; elsewhere it is behind the
     * ball. */
    const exact_interval ball = exact_ball(x, roombeam_to_light);
    if (cosine <= 0.0 || (ball.t0 < ball.t1 && ball.t1 > 1e-9 && ball.t0 > 1e-9))
        return 0.0;
    return roombeam_albedo * cosine * exact_light_transmittance(x);
}

/* What comes from direction v at o, which is outside the box. */
static inline exact_pixel exact_radiance(exact_vec o, exact_vec v)
{
    exact_pixel out = {0.0, 0.0, false};
    double t_surface = INFINITY;
    exact_vec normal;
    const bool hit = exact_surface(o, v, &t_surface, &normal);
    if (!hit)
        t_surface = INFINITY;
    else
        out.surface = exact_surface_radiance(exact_at(o, t_surface, v), normal) *
                      exp(-roombeam_sigma_t * exact_box_length(o, v, t_surface));
    exact_interval in = exact_box(o, v);
    in.t1 = fmin(in.t1, t_surface);
    if (!(in.t0 < in.t1))
        return out;
    out.fog_only = !hit;
    exact_interval before = in, after = {in.t1, in.t1};
    const exact_interval dark = exact_overlap(exact_shadow(o, v), in);
    if (dark.t0 < dark.t1) {
        before.t1 = dark.t0;
        after = (exact_interval){dark.t1, in.t1};
    }
    out.medium = roombeam_sigma_s * exact_pi * exact_phase(v) *
                 (exact_inscatter(o, v, in.t0, before) + exact_inscatter(o, v, in.t0, after));
    return out;
}

/* The camera: (0,-7,2) looking at (0,0,1.3), 40 degrees high. x, y in pixels from the upper left
 * corner. */
static inline exact_vec exact_camera_position(void) { return (exact_vec){0.0, -7.0, 2.0}; }

static inline exact_vec exact_camera_dir(double x, double y)
{
    const exact_vec f = exact_unit(exact_sub((exact_vec){0.0, 0.0, 1.3}, exact_camera_position()));
    const exact_vec r = exact_unit(exact_cross(f, (exact_vec){0.0, 0.0, 1.0})),
                    u = exact_cross(r, f);
    const double half = tan(20.0 * exact_pi / 180.0);
    const double sx = (2.0 * x - ROOMBEAM_WIDTH) / ROOMBEAM_HEIGHT * half,
                 sy = (1.0 - 2.0 * y / ROOMBEAM_HEIGHT) * half;
    return exact_unit(exact_at(exact_at(f, sx, r), sy, u));
}

#endif

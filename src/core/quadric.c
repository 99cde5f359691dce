#include "core/quadric.h"

#include <float.h>

#include "core/angle.h"
#include "core/triple.h"

/* ---- maps ---- */

static void multiply(const double m[9], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
    }
}

static void multiply_transposed(const double m[9], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = m[i] * v[0] + m[i + 3] * v[1] + m[i + 6] * v[2];
    }
}

/* The inverse by cofactors; returns the determinant. */
static double invert(const double m[9], double out[9])
{
    for (int i = 0; i < 3; i++) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int k = 0; k < 3; k++) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            out[3 * k + i] = m[3 * i1 + k1] * m[3 * i2 + k2] - m[3 * i1 + k2] * m[3 * i2 + k1];
        }
    }
    const double determinant = m[0] * out[0] + m[1] * out[3] + m[2] * out[6];
    for (int i = 0; i < 9; i++) {
        out[i] /= determinant;
    }
    return determinant;
}

bool air_quadric_make(air_ray_shape shape, const float to_world[12], air_quadric *out)
{
    bool sound = shape == AIR_RAY_SPHERE || shape == AIR_RAY_CYLINDER || shape == AIR_RAY_DISK;
    air_quadric quadric = {.shape = shape};
    for (int i = 0; i < 12; i++) {
        quadric.to_world[i] = to_world[i];
        sound = sound && isfinite(to_world[i]);
    }
    for (int i = 0; i < 9; i++) {
        quadric.linear[i] = (double)to_world[4 * (i / 3) + i % 3];
    }
    quadric.determinant = invert(quadric.linear, quadric.inverse);
    for (int i = 0; i < 9; i++) {
        sound = sound && isfinite(quadric.inverse[i]);
    }
    if (sound) {
        *out = quadric;
    }
    return sound;
}

void air_quadric_to_local(const air_quadric *quadric, const double point[3], double out[3])
{
    double from_center[3];
    for (int i = 0; i < 3; i++) {
        from_center[i] = point[i] - (double)quadric->to_world[4 * i + 3];
    }
    multiply(quadric->inverse, from_center, out);
}

void air_quadric_dir_to_local(const air_quadric *quadric, const double dir[3], double out[3])
{
    multiply(quadric->inverse, dir, out);
}

void air_quadric_dir_to_world(const air_quadric *quadric, const double local[3], double out[3])
{
    multiply(quadric->linear, local, out);
}

air_vec3 air_quadric_to_world(const air_quadric *quadric, const double local[3])
{
    double p[3];
    multiply(quadric->linear, local, p);
    const float *m = quadric->to_world;
    return vec3((float)(p[0] + (double)m[3]), (float)(p[1] + (double)m[7]),
                (float)(p[2] + (double)m[11]));
}

/* ---- intersection ---- */

/* How many of the first coordinates count in the sum of squares that is 1. */
static int round_axes(air_ray_shape shape) { return shape == AIR_RAY_SPHERE ? 3 : 2; }

static inline double partial_dot(const double a[3], const double b[3], int axes)
{
    const double sum = a[0] * b[0] + a[1] * b[1];
    return axes == 3 ? sum + a[2] * b[2] : sum;
}

/* The part of a line within: from nearest - half to nearest + half, about `foot`. */
typedef struct chord {
    double nearest, half;
    double foot[3];
} chord;

/* From the line's point nearest to the centre (or axis), where half the chord is sqrt(1 - r^2): b^2
 * - 4ac would lose all digits of a sphere far away. */
static inline bool chord_make(int axes, const double origin[3], const double dir[3], chord *out)
{
    const double dd = partial_dot(dir, dir, axes);
    if (!(dd > 0.0)) {
        return false;
    }
    const double inverse = 1.0 / dd;
    out->nearest = -partial_dot(origin, dir, axes) * inverse;
    air_along3(origin, out->nearest, dir, out->foot);
    const double rest = 1.0 - partial_dot(out->foot, out->foot, axes);
    if (!(rest >= 0.0)) {
        return false;
    }
    out->half = sqrt(rest * inverse);
    return true;
}

static inline void chord_end(const chord *line, const double dir[3], double from_foot,
                             air_quadric_hit *out)
{
    out->t = line->nearest + from_foot;
    air_along3(line->foot, from_foot, dir, out->local);
}

static inline size_t meet_sphere(const double origin[3], const double dir[3],
                                 air_quadric_hit out[2])
{
    chord line;
    if (!chord_make(3, origin, dir, &line)) {
        return 0;
    }
    chord_end(&line, dir, -line.half, &out[0]);
    chord_end(&line, dir, line.half, &out[1]);
    return 2;
}

static size_t meet_cylinder(const double origin[3], const double dir[3], air_quadric_hit out[2])
{
    chord line;
    size_t count = 0;
    if (!chord_make(2, origin, dir, &line)) {
        return 0;
    }
    for (int side = -1; side <= 1; side += 2) {
        air_quadric_hit *hit = &out[count];
        chord_end(&line, dir, (double)side * line.half, hit);
        count += hit->local[2] >= 0.0 && hit->local[2] <= 1.0 ? 1 : 0;
    }
    return count;
}

static size_t meet_disk(const double origin[3], const double dir[3], air_quadric_hit *out)
{
    if (dir[2] == 0.0) {
        return 0;
    }
    out->t = -origin[2] / dir[2];
    air_along3(origin, out->t, dir, out->local);
    out->local[2] = 0.0;
    return partial_dot(out->local, out->local, 2) <= 1.0 ? 1 : 0;
}

/* A ray of the world, before the map. */
static inline void ray_to_local(const air_quadric *quadric, const float origin[3],
                                const float dir[3], double out_origin[3], double out_dir[3])
{
    const double o[3] = {(double)origin[0], (double)origin[1], (double)origin[2]};
    const double d[3] = {(double)dir[0], (double)dir[1], (double)dir[2]};
    air_quadric_to_local(quadric, o, out_origin);
    multiply(quadric->inverse, d, out_dir);
}

size_t air_quadric_intersect(const air_quadric *quadric, const float origin[3], const float dir[3],
                             air_quadric_hit out[2])
{
    double o[3], d[3];
    ray_to_local(quadric, origin, dir, o, d);
    switch (quadric->shape) {
    case AIR_RAY_SPHERE:
        return meet_sphere(o, d, out);
    case AIR_RAY_CYLINDER:
        return meet_cylinder(o, d, out);
    default:
        return meet_disk(o, d, out);
    }
}

bool air_quadric_sphere_chord(const air_quadric *sphere, const float origin[3], const float dir[3],
                              double out_ends[2])
{
    double o[3], d[3];
    chord line;
    ray_to_local(sphere, origin, dir, o, d);
    if (!chord_make(3, o, d, &line)) {
        return false;
    }
    out_ends[0] = line.nearest - line.half;
    out_ends[1] = line.nearest + line.half;
    return true;
}

/* ---- places ---- */

/* The angle about Z over a turn, in [0, 1]. */
static double turn_of(const double local[3])
{
    const double turn = atan2(local[1], local[0]) / (2.0 * AIR_PI);
    return turn < 0.0 ? turn + 1.0 : turn;
}

void air_quadric_uv(air_ray_shape shape, const double local[3], float out_uv[2])
{
    const double radius = sqrt(local[0] * local[0] + local[1] * local[1]);
    const float turn = (float)turn_of(local);
    if (shape == AIR_RAY_DISK) {
        out_uv[0] = (float)radius;
        out_uv[1] = turn;
        return;
    }
    out_uv[0] = turn;
    out_uv[1] =
        shape == AIR_RAY_SPHERE ? (float)(atan2(radius, local[2]) / AIR_PI) : (float)local[2];
}

void air_quadric_place(air_ray_shape shape, float u, float v, double out_local[3])
{
    const double angle = 2.0 * AIR_PI * (double)(shape == AIR_RAY_DISK ? v : u);
    double radius = 1.0, z = (double)v;
    if (shape == AIR_RAY_SPHERE) {
        radius = sin(AIR_PI * (double)v);
        z = cos(AIR_PI * (double)v);
    } else if (shape == AIR_RAY_DISK) {
        radius = (double)u;
        z = 0.0;
    }
    out_local[0] = radius * cos(angle);
    out_local[1] = radius * sin(angle);
    out_local[2] = z;
}

void air_quadric_local_normal(air_ray_shape shape, const double local[3], double out[3])
{
    out[0] = shape == AIR_RAY_DISK ? 0.0 : local[0];
    out[1] = shape == AIR_RAY_DISK ? 0.0 : local[1];
    out[2] = shape == AIR_RAY_DISK ? 1.0 : shape == AIR_RAY_SPHERE ? local[2] : 0.0;
    const double length = air_length3(out);
    for (int i = 0; i < 3; i++) {
        out[i] /= length;
    }
}

/* A local normal of any length in the world. */
static inline air_vec3 normal_to_world(const air_quadric *quadric, const double local[3])
{
    double world[3];
    multiply_transposed(quadric->inverse, local, world);
    const double scale = 1.0 / air_length3(world);
    return vec3((float)(world[0] * scale), (float)(world[1] * scale), (float)(world[2] * scale));
}

air_vec3 air_quadric_normal(const air_quadric *quadric, const double local[3])
{
    double n[3];
    if (quadric->shape == AIR_RAY_SPHERE) {
        return normal_to_world(quadric, local);
    }
    air_quadric_local_normal(quadric->shape, local, n);
    return normal_to_world(quadric, n);
}

void air_quadric_sphere_place(const air_quadric *sphere, const float normal[3], double out_local[3])
{
    const double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    multiply_transposed(sphere->linear, n, out_local);
    const double scale = 1.0 / air_length3(out_local);
    for (int i = 0; i < 3; i++) {
        out_local[i] *= scale;
    }
}

static air_vec3 dir_to_world(const air_quadric *quadric, double x, double y, double z)
{
    const double local[3] = {x, y, z};
    double world[3];
    multiply(quadric->linear, local, world);
    return vec3((float)world[0], (float)world[1], (float)world[2]);
}

void air_quadric_slopes(const air_quadric *quadric, float u, float v, air_vec3 *out_by_u,
                        air_vec3 *out_by_v)
{
    const bool disk = quadric->shape == AIR_RAY_DISK;
    const double turn = 2.0 * AIR_PI, angle = turn * (double)(disk ? v : u);
    const double c = cos(angle), s = sin(angle), polar = AIR_PI * (double)v;
    double radius = 1.0;
    if (disk) {
        radius = (double)u;
        *out_by_u = dir_to_world(quadric, c, s, 0.0);
    } else if (quadric->shape == AIR_RAY_SPHERE) {
        radius = sin(polar);
        *out_by_v = dir_to_world(quadric, AIR_PI * cos(polar) * c, AIR_PI * cos(polar) * s,
                                 -AIR_PI * radius);
    } else {
        *out_by_v = dir_to_world(quadric, 0.0, 0.0, 1.0);
    }
    *(disk ? out_by_v : out_by_u) =
        dir_to_world(quadric, -turn * radius * s, turn * radius * c, 0.0);
}

/* ---- area ---- */

/* A map of determinant D takes the area element n dA to D A^-T n dA. */
double air_quadric_stretch(const air_quadric *quadric, const double local[3])
{
    double n[3], mapped[3];
    air_quadric_local_normal(quadric->shape, local, n);
    multiply_transposed(quadric->inverse, n, mapped);
    return fabs(quadric->determinant) * air_length3(mapped);
}

double air_quadric_local_area(air_ray_shape shape)
{
    return shape == AIR_RAY_SPHERE     ? 4.0 * AIR_PI
           : shape == AIR_RAY_CYLINDER ? 2.0 * AIR_PI
                                       : AIR_PI;
}

/* The mean stretch over places even in local area: exact where the map keeps shapes, which most
 * do; else by the midpoint rule, which converges fast in the angle about Z. */
double air_quadric_area(const air_quadric *quadric)
{
    enum { TURNS = 64, HEIGHTS = 256 };
    double sum = 0.0;
    for (int i = 0; i < TURNS * HEIGHTS; i++) {
        double local[3];
        air_quadric_sample(quadric->shape, ((float)(i / TURNS) + 0.5f) / HEIGHTS,
                           ((float)(i % TURNS) + 0.5f) / TURNS, local);
        sum += air_quadric_stretch(quadric, local);
    }
    return air_quadric_local_area(quadric->shape) * sum / (TURNS * HEIGHTS);
}

void air_quadric_sample(air_ray_shape shape, float u1, float u2, double out_local[3])
{
    double radius = 1.0, z = (double)u1, sine, cosine;
    air_sincos_turn64((double)u2, &sine, &cosine);
    if (shape == AIR_RAY_SPHERE) {
        z = 1.0 - 2.0 * (double)u1;
        radius = 2.0 * sqrt((double)u1 * (1.0 - (double)u1));
    } else if (shape == AIR_RAY_DISK) {
        radius = sqrt((double)u1);
        z = 0.0;
    }
    out_local[0] = radius * cosine;
    out_local[1] = radius * sine;
    out_local[2] = z;
}

/* ---- bounds ---- */

void air_quadric_bounds(const air_quadric *quadric, float out_min[3], float out_max[3])
{
    for (int i = 0; i < 3; i++) {
        const double *row = quadric->linear + 3 * i;
        const double center = (double)quadric->to_world[4 * i + 3];
        const double reach = sqrt(partial_dot(row, row, round_axes(quadric->shape)));
        const double along = quadric->shape == AIR_RAY_CYLINDER ? row[2] : 0.0;
        out_min[i] = nextafterf((float)(center + fmin(along, 0.0) - reach), -FLT_MAX);
        out_max[i] = nextafterf((float)(center + fmax(along, 0.0) + reach), FLT_MAX);
    }
}

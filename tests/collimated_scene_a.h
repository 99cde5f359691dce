/* collimated_scene_a.h: the scene that estimators are compared in: a black sphere in a box of fog
 * under light from infinity, with its exact picture; and random scenes like it. For tests and the
 * benchmark. */
#ifndef AIR_TESTS_COLLIMATED_SCENE_A_H
#define AIR_TESTS_COLLIMATED_SCENE_A_H

#include "airlight/collimated_walk.h"
#include "collimated_fixture.h"
#include "core/host.h"
#include "core/vec.h"

/* A square picture: axes of the camera, right and up scaled by tan(fov / 2). */
typedef struct sphere_scene {
    air_collimated_medium medium;
    double sigma_t, to_light[3];
    double centre[3], radius;
    double eye[3], forward[3], right[3], up[3];
    int size;
} sphere_scene;

static inline void look_at(sphere_scene *self, const double eye[3], double fov_deg)
{
    static const double sky[3] = {0.0, 1.0, 0.0};
    for (int i = 0; i < 3; i++) {
        self->eye[i] = eye[i];
        self->forward[i] = -eye[i]; /* at the origin */
    }
    normalise(self->forward);
    cross(self->forward, sky, self->right);
    normalise(self->right);
    cross(self->right, self->forward, self->up);
    for (int i = 0; i < 3; i++) {
        self->right[i] *= tan(0.5 * fov_deg * AIR_PI / 180.0);
        self->up[i] *= tan(0.5 * fov_deg * AIR_PI / 180.0);
    }
}

static inline sphere_scene scene_a(int size)
{
    static const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};
    static const double eye[3] = {0.5, 1.0, 3.5};
    sphere_scene out = {.medium = box_between(low, high),
                        .sigma_t = 1.0,
                        .to_light = {-0.3, 0.6, -0.3},
                        .centre = {0.2, 0.4, 0.0},
                        .radius = 0.5,
                        .size = size};
    normalise(out.to_light);
    look_at(&out, eye, 40.0);
    return out;
}

/* Camera 3 to 5 from the centre of the box, light from anywhere, a sphere that fits the box. */
static inline sphere_scene random_sphere_scene(air_rng *rng, int size)
{
    double eye[3];
    sphere_scene out = scene_a(size);
    do {
        random_direction(rng, eye);
    } while (fabs(eye[1]) > 0.95);
    const double distance = random_between(rng, 3.0, 5.0);
    for (int i = 0; i < 3; i++) {
        eye[i] *= distance;
        out.centre[i] = random_between(rng, -0.5, 0.5);
    }
    out.radius = random_between(rng, 0.2, 0.5);
    random_direction(rng, out.to_light);
    look_at(&out, eye, 40.0);
    return out;
}

static inline void scene_direction(const sphere_scene *self, int pixel, double out[3])
{
    const double x = 2.0 * (pixel % self->size + 0.5) / self->size - 1.0;
    const double y = 1.0 - 2.0 * (pixel / self->size + 0.5) / self->size;
    for (int i = 0; i < 3; i++) {
        out[i] = self->forward[i] + x * self->right[i] + y * self->up[i];
    }
    normalise(out);
}

/* The stretch of o + t v inside the sphere; false if there is none. */
static inline bool sphere_stretch(const sphere_scene *self, const double o[3], const double v[3],
                                  air_interval *out)
{
    const double to[3] = {self->centre[0] - o[0], self->centre[1] - o[1], self->centre[2] - o[2]};
    const double along = dot(to, v),
                 off = along * along - dot(to, to) + self->radius * self->radius;
    if (!(off > 0.0)) {
        return false;
    }
    out->begin = along - sqrt(off);
    out->end = along + sqrt(off);
    return true;
}

/* Where a ray meets the sphere from outside; INFINITY if it does not. */
static inline double sphere_hit(const sphere_scene *self, const double origin[3],
                                const double dir[3])
{
    air_interval inside;
    const bool met = sphere_stretch(self, origin, dir, &inside);
    return met && inside.begin > 0.0 ? inside.begin : INFINITY;
}

/* The surroundings of a walk. */
static inline double sphere_distance(void *scene, const double origin[3], const double dir[3])
{
    return sphere_hit(scene, origin, dir);
}

static inline bool sphere_occludes(void *scene, const double point[3])
{
    const sphere_scene *self = scene;
    return sphere_hit(self, point, self->to_light) < INFINITY;
}

/* The stretch of a ray in shadow: that convex set is the ball and half of the cylinder about it
 * along the light, {distance from the axis <= R, (x-c).l <= 0}; so the hull of the ray's stretches
 * in both. Empty (begin >= end) if there is none. */
static inline air_interval sphere_shadow(const sphere_scene *self, const double o[3],
                                         const double v[3])
{
    air_interval out = {INFINITY, -INFINITY}, ball;
    const double *l = self->to_light;
    const double to[3] = {o[0] - self->centre[0], o[1] - self->centre[1], o[2] - self->centre[2]};
    const double ol = dot(to, l), vl = dot(v, l);
    /* Across the light: |p + t q| <= R. */
    double p[3], q[3];
    for (int i = 0; i < 3; i++) {
        p[i] = to[i] - ol * l[i];
        q[i] = v[i] - vl * l[i];
    }
    const double q2 = dot(q, q), pq = dot(p, q);
    const double off = pq * pq - q2 * (dot(p, p) - self->radius * self->radius);
    if (q2 > 0.0 && off > 0.0) {
        double begin = (-pq - sqrt(off)) / q2, end = (-pq + sqrt(off)) / q2;
        const double middle = -ol / vl; /* where the half begins, if the ray goes down */
        if (vl < 0.0) {
            begin = fmax(begin, middle);
        } else {
            end = vl > 0.0 ? fmin(end, middle) : ol <= 0.0 ? end : begin;
        }
        if (begin < end) {
            out = (air_interval){begin, end};
        }
    }
    if (sphere_stretch(self, o, v, &ball)) {
        out.begin = fmin(out.begin, ball.begin);
        out.end = fmax(out.end, ball.end);
    }
    return out;
}

/* ---- pixels ---- */

/* What a pixel's ray meets. */
typedef struct scene_ray {
    double dir[3];
    roomy_profile room;
    air_interval shadow; /* clipped to the medium; empty: begin >= end */
    double unoccluded, exact;
} scene_ray;

/* profile is the pixel's; false where the ray misses the medium. */
static inline bool scene_ray_make(const sphere_scene *self, int pixel, scene_ray *out)
{
    scene_direction(self, pixel, out->dir);
    const double t_max = sphere_hit(self, self->eye, out->dir);
    air_collimated_profile *profile = roomy(&out->room);
    air_collimated_profile_make(&self->medium, self->to_light, self->sigma_t, self->eye, out->dir,
                                t_max, profile);
    out->unoccluded = out->exact = 0.0;
    out->shadow = (air_interval){0.0, 0.0};
    if (profile->count == 0) {
        return false;
    }
    const double begin = profile->pieces[0].t0, end = profile->pieces[profile->count - 1].t1;
    const air_interval shadow = sphere_shadow(self, self->eye, out->dir);
    out->shadow = (air_interval){fmax(shadow.begin, begin), fmin(shadow.end, end)};
    out->unoccluded = out->exact = air_collimated_integral(profile);
    if (out->shadow.begin < out->shadow.end) {
        out->exact = air_collimated_partial_integral(profile, begin, out->shadow.begin) +
                     air_collimated_partial_integral(profile, out->shadow.end, end);
    }
    return true;
}

static inline bool scene_ray_sees(const scene_ray *ray, double t)
{
    return t < ray->shadow.begin || t > ray->shadow.end;
}

/* ---- sample patterns ---- */

/* The numbers of one pixel's samples; a pattern that looks at neighbours has pixel and size. */
typedef struct pattern_place {
    int pixel, size;
    uint32_t seed;
} pattern_place;

typedef struct sample_pattern {
    const char *name;
    void (*make)(const pattern_place *place, int count, double *u);
} sample_pattern;

static inline air_rng pattern_rng(const pattern_place *place)
{
    return air_rng_from_keys(place->seed, (uint32_t)place->pixel);
}

static inline void pattern_independent(const pattern_place *place, int count, double *u)
{
    air_rng rng = pattern_rng(place);
    for (int k = 0; k < count; k++) {
        u[k] = random_unit(&rng);
    }
}

static inline void pattern_stratified(const pattern_place *place, int count, double *u)
{
    air_rng rng = pattern_rng(place);
    for (int k = 0; k < count; k++) {
        u[k] = (k + random_unit(&rng)) / count;
    }
}

static inline void pattern_systematic(const pattern_place *place, int count, double *u)
{
    air_rng rng = pattern_rng(place);
    const double offset = random_unit(&rng);
    for (int k = 0; k < count; k++) {
        u[k] = (k + offset) / count;
    }
}

/* One line for another. */
static const sample_pattern sample_patterns[] = {
    {"independent", pattern_independent},
    {"stratified", pattern_stratified},
    {"systematic", pattern_systematic},
};
enum { PATTERN_INDEPENDENT, PATTERN_STRATIFIED, PATTERN_SYSTEMATIC };
enum { PATTERN_COUNT = sizeof sample_patterns / sizeof *sample_patterns, MOST_SAMPLES = 256 };

/* ---- estimates ---- */

/* The kernel's estimators, and one more: distances by extinction that are not truncated to the
 * medium. */
enum { ESTIMATOR_DS_UNTRUNCATED = AIR_COLLIMATED_ESTIMATOR_COUNT, ESTIMATOR_COUNT };

static inline double sums_value(air_collimated_estimator estimator, air_collimated_sums sums,
                                double samples)
{
    if (!air_collimated_estimator_is_ratio(estimator)) {
        return sums.occluded / samples;
    }
    return sums.unoccluded > 0.0 ? sums.analytic / samples * sums.occluded / sums.unoccluded : 0.0;
}

static inline void sums_add(air_collimated_sums *to, air_collimated_sums more)
{
    to->analytic += more.analytic;
    to->unoccluded += more.unoccluded;
    to->occluded += more.occluded;
}

static inline air_collimated_draw draw_untruncated(const scene_ray *ray, double sigma_t, double u)
{
    const air_collimated_profile *profile = &ray->room.profile;
    const double way = -log1p(-u) / sigma_t, t = profile->pieces[0].t0 + way;
    return (air_collimated_draw){
        .t = t, .unoccluded = air_collimated_integrand(profile, t) * exp(sigma_t * way) / sigma_t};
}

static inline air_collimated_sums scene_sums(const sphere_scene *self, const scene_ray *ray,
                                             int estimator, const double *u, int count)
{
    air_collimated_sums sums = {0.0, 0.0, 0.0};
    for (int k = 0; k < count; k++) {
        const air_collimated_draw draw =
            estimator == ESTIMATOR_DS_UNTRUNCATED
                ? draw_untruncated(ray, self->sigma_t, u[k])
                : air_collimated_estimate((air_collimated_estimator)estimator, &ray->room.profile,
                                          u[k]);
        sums_add(&sums, (air_collimated_sums){draw.analytic, draw.unoccluded,
                                              scene_ray_sees(ray, draw.t) ? draw.unoccluded : 0.0});
    }
    return sums;
}

/* ---- pictures ---- */

/* Squared errors of many ways to make one picture, against its exact one. */
typedef struct picture_error {
    double sum, peak; /* of squares; largest exact value */
} picture_error;

static inline double picture_psnr(picture_error error, int size)
{
    const double mean = error.sum / ((double)size * size);
    return -10.0 * log10(mean / (error.peak * error.peak));
}

/* How pictures are made: with one entry of each. */
typedef struct picture_plan {
    const sphere_scene *scene;
    int estimator, pattern, samples;
    uint32_t seed;
} picture_plan;

typedef struct picture_work {
    const picture_plan *plans;
    size_t count;
    picture_error *rows; /* size x count */
} picture_work;

static inline void picture_row(void *user, size_t row, size_t worker)
{
    const picture_work *work = user;
    const sphere_scene *scene = work->plans[0].scene;
    scene_ray ray;
    double u[MOST_SAMPLES];
    (void)worker;
    for (int x = 0; x < scene->size; x++) {
        const int pixel = (int)row * scene->size + x;
        if (!scene_ray_make(scene, pixel, &ray)) {
            continue; /* every estimate is 0, exactly */
        }
        for (size_t i = 0; i < work->count; i++) {
            const picture_plan *plan = &work->plans[i];
            const pattern_place place = {pixel, scene->size, plan->seed};
            sample_patterns[plan->pattern].make(&place, plan->samples, u);
            const air_collimated_sums sums =
                scene_sums(scene, &ray, plan->estimator, u, plan->samples);
            const double error =
                sums_value((air_collimated_estimator)plan->estimator, sums, plan->samples) -
                ray.exact;
            picture_error *out = &work->rows[row * work->count + i];
            out->sum += error * error;
            out->peak = fmax(out->peak, ray.exact);
        }
    }
}

/* PSNR of count plans of one scene. False: out of memory. */
static inline bool picture_compare(air_context *context, const picture_plan *plans, size_t count,
                                   double *out_psnr)
{
    const int size = plans[0].scene->size;
    picture_error *rows = calloc((size_t)size * count, sizeof *rows);
    picture_work work = {plans, count, rows};
    if (rows == NULL) {
        return false;
    }
    air_parallel_for(context, (size_t)size, picture_row, &work);
    for (size_t i = 0; i < count; i++) {
        picture_error total = {0.0, 0.0};
        for (int row = 0; row < size; row++) {
            const picture_error *part = &rows[(size_t)row * count + i];
            total.sum += part->sum;
            total.peak = fmax(total.peak, part->peak);
        }
        out_psnr[i] = picture_psnr(total, size);
    }
    free(rows);
    return true;
}

/* ---- multiple scattering ---- */

static inline double next_number(void *rng) { return random_unit(rng); }

static inline air_collimated_walk_params walk_in(sphere_scene *scene, double albedo)
{
    air_collimated_walk_params out;
    air_collimated_walk_params_default(&out);
    out.medium = &scene->medium;
    memcpy(out.to_light, scene->to_light, sizeof out.to_light);
    out.sigma_t = scene->sigma_t;
    out.sigma_s = albedo * scene->sigma_t;
    out.irradiance = 4.0 * AIR_PI;
    out.max_events = 8;
    out.roulette = 0.0;
    out.surroundings = (air_collimated_surroundings){sphere_distance, sphere_occludes, scene};
    return out;
}

typedef struct mean_error {
    double mean, error;
} mean_error;

/* Means and products of the sums of many walks. */
typedef struct moments {
    double count, sum[3], product[3][3];
} moments;

static inline moments walk_moments(const air_collimated_walk_params *params, const double origin[3],
                                   const double dir[3], int count, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, (uint32_t)params->distance);
    moments out = {.count = count};
    for (int n = 0; n < count; n++) {
        const air_collimated_sums s = air_collimated_walk(params, origin, dir, next_number, &rng);
        const double value[3] = {s.analytic, s.unoccluded, s.occluded};
        for (int i = 0; i < 3; i++) {
            out.sum[i] += value[i] / count;
            for (int j = 0; j < 3; j++) {
                out.product[i][j] += value[i] * value[j] / count;
            }
        }
    }
    return out;
}

/* The error of a function of the three means whose derivatives are given. */
static inline double propagated(const moments *m, const double derivative[3])
{
    double variance = 0.0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            variance += derivative[i] * derivative[j] * (m->product[i][j] - m->sum[i] * m->sum[j]);
        }
    }
    return sqrt(fmax(0.0, variance) / m->count);
}

static inline mean_error plain_of(const moments *m)
{
    const double derivative[3] = {0.0, 0.0, 1.0};
    return (mean_error){m->sum[2], propagated(m, derivative)};
}

static inline mean_error ratio_of(const moments *m)
{
    const double *s = m->sum;
    const double derivative[3] = {s[2] / s[1], -s[0] * s[2] / (s[1] * s[1]), s[0] / s[1]};
    return (mean_error){s[0] * s[2] / s[1], propagated(m, derivative)};
}

#endif

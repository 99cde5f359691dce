/* area_ris.h: Volume-RIS without reuse and without visibility [Lin2021] in scene A: distances by
 * extinction, points uniform on the lamp; the mean of its candidates. */
#ifndef AREA_RIS_H
#define AREA_RIS_H

#include "area_scene_a.h"
#include "core/random.h"

static inline double ris_unit(air_rng *rng) { return (double)air_rng_float(rng); }

/* A point of the lamp, and cos / r^2 over the density of points. */
static inline double ris_lamp(const double from[3], air_rng *rng, double wi[3], double *out_r)
{
    const double to[3] = {2.0 * ris_unit(rng) - 1.0, ris_unit(rng) - 0.5, 2.0};
    double r2 = 0.0;
    for (int k = 0; k < 3; k++) {
        wi[k] = to[k] - from[k];
        r2 += wi[k] * wi[k];
    }
    *out_r = sqrt(r2);
    for (int k = 0; k < 3; k++) {
        wi[k] /= *out_r;
    }
    return wi[2] > 0.0 ? 2.0 * wi[2] / r2 : 0.0;
}

static inline double ris_air(const area_scene *s, const double dir[3], double length,
                             int candidates, air_rng *rng)
{
    const double share = -expm1(-s->sigma * length);
    double sum = 0.0;
    for (int i = 0; i < candidates; i++) {
        const double t = -log1p(-ris_unit(rng) * share) / s->sigma;
        const double point[3] = {scene_eye[0] + t * dir[0], scene_eye[1] + t * dir[1],
                                 scene_eye[2] + t * dir[2]};
        double wi[3], r;
        const double form = ris_lamp(point, rng, wi, &r);
        const double d = 1.0 + s->g * s->g - 2.0 * s->g * scene_dot(dir, wi);
        const double phase = (1.0 - s->g * s->g) / (4.0 * AIR_PI * d * sqrt(d));
        /* sigma_s T(t) over the density sigma_t T(t) / share is share */
        sum += share * phase * form * exp(-s->sigma * r);
    }
    return scene_radiance * sum / candidates;
}

/* As a path tracer does it: distances by the regularised angle at the lamp. */
static inline double path_air(const area_scene *s, const double dir[3], double length, int samples,
                              air_rng *rng)
{
    air_interval lit;
    double sum = 0.0;
    if (!air_area_lit_interval(&s->lamp, scene_eye, dir, length, &lit)) {
        return 0.0;
    }
    for (int i = 0; i < samples; i++) {
        double wi[3], r, pdf;
        const double t =
            air_area_sample_distance(&s->lamp, scene_eye, dir, lit, ris_unit(rng), &pdf);
        const double point[3] = {scene_eye[0] + t * dir[0], scene_eye[1] + t * dir[1],
                                 scene_eye[2] + t * dir[2]};
        const double form = ris_lamp(point, rng, wi, &r);
        const double d = 1.0 + s->g * s->g - 2.0 * s->g * scene_dot(dir, wi);
        const double phase = (1.0 - s->g * s->g) / (4.0 * AIR_PI * d * sqrt(d));
        sum += s->sigma * phase * form * exp(-s->sigma * (r + t)) / pdf;
    }
    return scene_radiance * sum / samples;
}

static inline double ris_floor(const area_scene *s, const double dir[3], double length,
                               int candidates, air_rng *rng)
{
    const double point[3] = {scene_eye[0] + length * dir[0], scene_eye[1] + length * dir[1], 0.0};
    double sum = 0.0;
    for (int i = 0; i < candidates; i++) {
        double wi[3], r;
        const double form = ris_lamp(point, rng, wi, &r);
        sum += scene_albedo / AIR_PI * wi[2] * form * exp(-s->sigma * r);
    }
    return scene_radiance * sum / candidates * exp(-s->sigma * length);
}

#endif

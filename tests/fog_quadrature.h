/* fog_quadrature.h: single scattering in boxes of homogeneous fog along a ray, by quadrature; a
 * truth for volumetric path tracers.
 *
 * In double precision and by the plainest means: the midpoint rule between the ray's crossings of
 * box sides, transmittance from the clipped length of each box, phase functions as they stand in
 * books. */
#ifndef AIR_TESTS_FOG_QUADRATURE_H
#define AIR_TESTS_FOG_QUADRATURE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "airlight/medium.h"

typedef struct fog_vec {
    double x, y, z;
} fog_vec;

static inline fog_vec fog_at(fog_vec o, double t, fog_vec d)
{
    return (fog_vec){o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
}
static inline fog_vec fog_between(fog_vec from, fog_vec to) { return fog_at(to, -1.0, from); }
static inline double fog_dot(fog_vec a, fog_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline fog_vec fog_unit(fog_vec v)
{
    return fog_at((fog_vec){0.0, 0.0, 0.0}, 1.0 / sqrt(fog_dot(v, v)), v);
}

/* A box with sides along the axes. */
typedef struct fog_box {
    fog_vec low, high;
    double sigma_s[3], sigma_a[3];
    air_phase phase;
} fog_box;

typedef struct fog {
    const fog_box *boxes; /* overlaps add */
    size_t count;
} fog;

static inline bool fog_clip(double o, double d, double low, double high, double *t0, double *t1)
{
    if (d == 0.0) {
        return o > low && o < high;
    }
    const double a = (low - o) / d, b = (high - o) / d;
    *t0 = fmax(*t0, fmin(a, b));
    *t1 = fmin(*t1, fmax(a, b));
    return *t0 < *t1;
}

/* The part of the ray between *t0 and *t1 that lies in the box; false if there is none. */
static inline bool fog_interval(const fog_box *box, fog_vec o, fog_vec d, double *t0, double *t1)
{
    return fog_clip(o.x, d.x, box->low.x, box->high.x, t0, t1) &&
           fog_clip(o.y, d.y, box->low.y, box->high.y, t0, t1) &&
           fog_clip(o.z, d.z, box->low.z, box->high.z, t0, t1);
}

/* From o to o + length d; length may be INFINITY. */
static inline double fog_transmittance(const fog *f, int c, fog_vec o, fog_vec d, double length)
{
    double depth = 0.0;
    for (size_t i = 0; i < f->count; i++) {
        double t0 = 0.0, t1 = length;
        if (fog_interval(&f->boxes[i], o, d, &t0, &t1)) {
            depth += (f->boxes[i].sigma_s[c] + f->boxes[i].sigma_a[c]) * (t1 - t0);
        }
    }
    return exp(-depth);
}

static inline double fog_phase(air_phase phase, double cosine)
{
    const double pi = 3.14159265358979323846, g = (double)phase.g;
    double sum = 0.0;
    switch (phase.kind) {
    case AIR_PHASE_MIXTURE:
        for (size_t i = 0; i < phase.mixture->lobe_count; i++) {
            const air_phase_lobe *lobe = &phase.mixture->lobes[i];
            const air_phase single = {.kind = lobe->kind, .g = lobe->g};
            sum += (double)lobe->weight * fog_phase(single, cosine);
        }
        return sum;
    case AIR_PHASE_HG:
        return (1.0 - g * g) / (4.0 * pi * pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
    case AIR_PHASE_RAYLEIGH:
        return 3.0 / (16.0 * pi) * (1.0 + cosine * cosine);
    default:
        return 1.0 / (4.0 * pi);
    }
}

/* sigma_s times phase function at x, of all boxes that hold it; cosine between the directions of
 * travel. */
static inline double fog_scattering(const fog *f, int c, fog_vec x, double cosine)
{
    double sum = 0.0;
    for (size_t i = 0; i < f->count; i++) {
        const fog_box *b = &f->boxes[i];
        if (x.x > b->low.x && x.x < b->high.x && x.y > b->low.y && x.y < b->high.y &&
            x.z > b->low.z && x.z < b->high.z) {
            sum += b->sigma_s[c] * fog_phase(b->phase, cosine);
        }
    }
    return sum;
}

/* Light scattered at x into -d, without the transmittance from x to the viewer. */
typedef double fog_source(const void *user, const fog *f, int channel, fog_vec x, fog_vec d);

enum { FOG_MAX_BOXES = 4 };

/* Where the ray enters and leaves boxes, sorted; returns how many distances these are. */
static inline size_t fog_crossings(const fog *f, fog_vec o, fog_vec d, double t[2 * FOG_MAX_BOXES])
{
    size_t count = 0;
    for (size_t i = 0; i < f->count && i < FOG_MAX_BOXES; i++) {
        double ends[2] = {0.0, INFINITY};
        if (!fog_interval(&f->boxes[i], o, d, &ends[0], &ends[1])) {
            continue;
        }
        for (int e = 0; e < 2; e++) {
            size_t k = count++;
            for (; k > 0 && t[k - 1] > ends[e]; k--) {
                t[k] = t[k - 1];
            }
            t[k] = ends[e];
        }
    }
    return count;
}

/* Radiance against the unit direction d at o of light scattered once: the midpoint rule with
 * `steps` points between any two crossings. */
static inline double fog_radiance(const fog *f, int channel, fog_vec o, fog_vec d, size_t steps,
                                  fog_source *source, const void *user)
{
    double crossings[2 * FOG_MAX_BOXES], sum = 0.0;
    const size_t count = fog_crossings(f, o, d, crossings);
    for (size_t k = 0; k + 1 < count; k++) {
        const double h = (crossings[k + 1] - crossings[k]) / (double)steps;
        for (size_t i = 0; i < steps && h > 0.0; i++) {
            const double t = crossings[k] + ((double)i + 0.5) * h;
            const double scattered = source(user, f, channel, fog_at(o, t, d), d);
            sum += h * scattered * fog_transmittance(f, channel, o, d, t);
        }
    }
    return sum;
}

#endif

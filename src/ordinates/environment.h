/* environment.h: maps of the sky as ordinates.
 *
 * The sky is a sequence of elements along a curve over the sphere (sphere_curve.h), an element
 * being a pixel, or a part of one where pixels are large. Sums along it stand at every
 * ENVIRONMENT_RUN-th element, and at the first of each cell, which is what importance is constant
 * over. So a choice weighs the cells and then walks only along the runs in which the curve is cut.
 * A stratum is the difference of the sums at two cuts: whatever the cuts are, the strata add up to
 * the sky.
 *
 * Strips of rows cut into columns, the 2D distribution, make rounder strata of an even sky (16 of
 * them: mean cosine 0.931 against 0.922), but a strip goes through bright and dark alike: of
 * vestibule_1k 64 strata by luminance have 0.945 against 0.976, and light scattered once at g = 0.8
 * is off by 0.168 against 0.077. */
#ifndef AIR_ORDINATES_ENVIRONMENT_H
#define AIR_ORDINATES_ENVIRONMENT_H

#include "airlight/ordinates_lights.h"

enum {
    ENVIRONMENT_RUN = 64,
    ENVIRONMENT_CELL_BITS = 12,
    ENVIRONMENT_CELLS = 1 << ENVIRONMENT_CELL_BITS
};

/* From the first element to some place on the curve. */
typedef struct environment_sums {
    double weight; /* of solid angles, times luminance^contrast */
    double rgb[3];
    double moment[3]; /* integral of luminance times direction; of a black map, of direction */
    double solid_angle;
} environment_sums;

struct air_environment_ordinates {
    air_context *context;
    air_environment_map map;
    size_t split[2]; /* elements side by side in a pixel */
    size_t columns, rows, count;
    bool black;
    uint32_t *order;  /* elements along the curve, row * columns + column */
    double (*row)[3]; /* of an element: solid angle, integral of the cosine to +Y, and of the sine
                         per longitude */
    double (*column)[2]; /* integrals of x and z over the longitudes, per that sine */
    environment_sums
        *runs; /* before elements 0, ENVIRONMENT_RUN, 2 ENVIRONMENT_RUN, .., and of all */
    size_t run_count;
    size_t cell_first[ENVIRONMENT_CELLS + 1];
    environment_sums cell_sums[ENVIRONMENT_CELLS + 1];
    float cell_direction[ENVIRONMENT_CELLS][3];
};

static inline double environment_luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static inline void environment_sums_add(environment_sums *a, double scale,
                                        const environment_sums *b)
{
    a->weight += scale * b->weight;
    for (int k = 0; k < 3; k++) {
        a->rgb[k] += scale * b->rgb[k];
        a->moment[k] += scale * b->moment[k];
    }
    a->solid_angle += scale * b->solid_angle;
}

/* Of an element, row * columns + column. */
void environment_radiance(const air_environment_ordinates *self, size_t element, double out[3]);
/* Integral of the direction over it. */
void environment_direction(const air_environment_ordinates *self, size_t element, double out[3]);
environment_sums environment_element(const air_environment_ordinates *self, size_t element);

#endif

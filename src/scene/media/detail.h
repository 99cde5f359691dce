/* detail.h: procedural detail of density: a factor of mean 1 that varies from place to place, by
 * gradient noise in octaves.
 *
 * An octave is gradient noise [Perlin1985], [Perlin2002] on a lattice of its own: gradients are the
 * twelve edges' directions of a cube, chosen by a hash of seed, octave and lattice point, and the
 * fade is 6 t^5 - 15 t^4 + 10 t^3. Lattices repeat after 4096 points along each axis. Octaves halve
 * in size and in strength, so that all are equally steep, and are shifted against each other: noise
 * is 0 at lattice points, which must not coincide. The sum has the standard deviation 1/2 by its
 * scale; it is cut off at -1 and 1 and bent by (3 x - x^3) / 2, which is flat there.
 *
 * The set of gradients holds the opposite of each, so noise and its opposite are equally likely;
 * the bend is odd: the mean is 0 whatever the octaves, and that of the factor 1. */
#ifndef AIR_SCENE_MEDIA_DETAIL_H
#define AIR_SCENE_MEDIA_DETAIL_H

#include "airlight/medium.h"
#include "core/vec.h"

/* Lattice points along an axis before they repeat; a power of two. */
enum { AIR_DETAIL_PERIOD = 4096 };

/* Lattice coordinates have no fractions worth the name from here on. */
#define AIR_DETAIL_TOO_FINE 0x1p20f

/* What a lattice point's coordinates are multiplied by before they are hashed together; odd. */
#define AIR_DETAIL_KEY_X 0x9e3779b1u
#define AIR_DETAIL_KEY_Y 0x85ebca77u
#define AIR_DETAIL_KEY_Z 0xc2b2ae3du

/* An octave: what the coarsest lattice's coordinates are multiplied by, and then shifted by. */
typedef struct air_detail_octave {
    float scale, shift[3], amplitude;
    uint32_t seed;
} air_detail_octave;

/* Places in the coarsest lattice. */
typedef struct air_detail_points {
    const float *x, *y, *z;
    size_t count;
} air_detail_points;

/* Adds an octave of noise to sums, one per point. Coordinates in the octave's lattice must be below
 * AIR_DETAIL_TOO_FINE. */
typedef void air_detail_kernel(const air_detail_octave *octave, const air_detail_points *points,
                               float *sum);
air_detail_kernel air_detail_octave_plain, air_detail_octave_avx2, air_detail_octave_avx512;

typedef struct air_detail_field {
    float strength;   /* 0: there is none */
    float feature_m;  /* spacing of the coarsest lattice in the world; the mean of its sides */
    float amplitude;  /* of the first octave */
    uint32_t octaves; /* 1..AIR_MAX_OCTAVES */
    uint32_t seeds[AIR_MAX_OCTAVES];
    float shifts[AIR_MAX_OCTAVES][3]; /* of the octaves' lattices, in their own spacings */
    air_detail_kernel *kernel;
    float to_lattice[12]; /* from the world to the coarsest lattice */
} air_detail_field;

/* Of a checked description. All instruction sets give the same bytes. */
void air_detail_make(const air_detail *detail, air_cpu cpu, air_detail_field *out);

/* Noise at a world point, in [-1, 1]. Octaves whose lattice is finer than width_m (>= 0, metres)
 * fade out, and are gone at half of it: what steps of width_m cannot resolve. Octaves so fine that
 * floats have no places between their lattice points are 0. Thread-safe, as are the others. */
float air_detail_noise(const air_detail_field *field, air_vec3 point, float width_m);

/* What the density is multiplied by: 1 + strength times noise, in [1 - strength, 1 + strength]. */
static inline float air_detail_factor(const air_detail_field *field, air_vec3 point, float width_m)
{
    return 1.0f + field->strength * air_detail_noise(field, point, width_m);
}

/* The same at many points, which is faster. */
void air_detail_factors(const air_detail_field *field, const air_vec3 *points, size_t count,
                        float width_m, float *out);

static inline float air_detail_most(const air_detail_field *field)
{
    return 1.0f + field->strength;
}

/* The spacing of the finest lattice, metres. */
static inline float air_detail_finest(const air_detail_field *field)
{
    return field->feature_m / (float)(1u << (field->octaves - 1));
}

#endif

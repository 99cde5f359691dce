/* medium.h: participating media: coefficients, phase functions, density, boundaries, overlap.
 *
 * A medium is a set of coefficients at density 1 (per channel, linear Rec. 709, 1/m), a density
 * that varies in space (constant, layered, exponential in height, or a grid; any of them with
 * procedural detail), a phase function and a boundary outside which it is absent. Where media
 * overlap their coefficients add and the phase function is their sigma_s-weighted mixture, unless
 * one of them replaces (AIR_COMBINE_REPLACE): then, of the media present at a point, those of lower
 * priority than the highest replacing one are absent, and of the replacing ones of that priority
 * only the one added last remains. */
#ifndef AIRLIGHT_MEDIUM_H
#define AIRLIGHT_MEDIUM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Handles name what was added to a scene; AIR_NONE names nothing. */
typedef uint32_t air_handle;
enum { AIR_NONE = 0 };

enum { AIR_MAX_MEDIA = 64, AIR_MAX_PLANES = 32, AIR_MAX_LAYERS = 32, AIR_MAX_OCTAVES = 12 };

typedef enum air_phase_kind {
    AIR_PHASE_ISOTROPIC = 0,
    AIR_PHASE_HG = 1,       /* Henyey-Greenstein, g in (-1, 1), g > 0 forward */
    AIR_PHASE_RAYLEIGH = 2, /* 3/(16 pi) (1 + cos^2) */
    AIR_PHASE_MIXTURE = 3   /* a weighted sum of the others */
} air_phase_kind;

enum { AIR_PHASE_MAX_LOBES = 8 };

typedef struct air_phase_lobe {
    air_phase_kind kind; /* any but AIR_PHASE_MIXTURE */
    float g;             /* as in air_phase */
    float weight;        /* finite, >= 0 */
} air_phase_lobe;

typedef struct air_phase_mixture {
    size_t lobe_count; /* 1..AIR_PHASE_MAX_LOBES */
    air_phase_lobe lobes[AIR_PHASE_MAX_LOBES];
} air_phase_mixture;

typedef struct air_phase {
    air_phase_kind kind;
    float g;                          /* mean cosine; used by AIR_PHASE_HG only */
    const air_phase_mixture *mixture; /* borrowed; used by AIR_PHASE_MIXTURE only */
} air_phase;

/* Phase value in 1/sr. cos_theta is the cosine between the directions of travel before and after.
 * The weights of a mixture must sum to 1. Thread-safe. */
AIR_API float air_phase_eval(air_phase phase, float cos_theta);

typedef enum air_boundary_kind {
    AIR_BOUNDARY_UNBOUNDED = 0,
    AIR_BOUNDARY_BOX = 1, /* box_to_world maps [-1,1]^3 into the world; any invertible affine map */
    AIR_BOUNDARY_CONVEX = 2,   /* intersection of half-spaces n.x <= h */
    AIR_BOUNDARY_MESH = 3,     /* a closed triangle mesh */
    AIR_BOUNDARY_ELLIPSOID = 4 /* box_to_world maps the unit sphere into the world, likewise */
} air_boundary_kind;

typedef struct air_boundary {
    air_boundary_kind kind;
    float box_to_world[12]; /* 3 rows of 4 */
    const float
        *planes; /* 4 floats (n.x, n.y, n.z, h) each; n of any length, pointing out; copied */
    size_t plane_count;     /* 1..AIR_MAX_PLANES */
    const float *positions; /* world space, 3 floats per vertex; copied */
    size_t vertex_count;
    const uint32_t *indices; /* 3 per triangle; copied */
    size_t triangle_count;
} air_boundary;

typedef enum air_density_kind {
    AIR_DENSITY_CONSTANT = 0,    /* 1 */
    AIR_DENSITY_LAYERED = 1,     /* piecewise constant in height */
    AIR_DENSITY_EXPONENTIAL = 2, /* exp(-max(0, height - base_height) / scale_height) */
    AIR_DENSITY_GRID = 3         /* trilinear in a grid, 0 outside it */
} air_density_kind;

/* Procedural detail: the density is multiplied by a factor of mean 1 within [1 - strength,
 * 1 + strength], noise that is fixed in a space of the medium's own. Its standard deviation is
 * about 0.6 strength. A medium with detail must have an end: a boundary, or a grid. */
typedef struct air_detail {
    float strength;     /* [0, 1); 0: none, and the rest is not looked at */
    float scale;        /* size of the largest features, metres of that space; > 0 */
    uint32_t octaves;   /* 1..AIR_MAX_OCTAVES; each is half as large and half as strong */
    uint32_t seed;      /* any; another one is another pattern of the same kind */
    float to_world[12]; /* from that space; 3 rows of 4, invertible */
} air_detail;

typedef struct air_density {
    air_density_kind kind;
    float up[3];        /* unit; height = up . x */
    size_t layer_count; /* layered: 1..AIR_MAX_LAYERS */
    float
        layer_bottom[AIR_MAX_LAYERS]; /* heights, increasing; a layer reaches to the next bottom */
    float layer_density[AIR_MAX_LAYERS]; /* >= 0 */
    float layer_top;                     /* top of the last layer; may be INFINITY */
    float base_height, scale_height;     /* exponential: scale_height > 0, metres */
    air_handle grid;                     /* grid: density, 1 or 3 channels (coloured density) */
    air_handle albedo_grid;              /* sigma_s/sigma_t, 3 channels, or AIR_NONE */
    air_handle emission_grid;            /* scales emission, 1 or 3 channels, or AIR_NONE */
    float grid_to_world[12];             /* applied after the grid's own index-to-local map */
    air_detail detail;                   /* with any kind */
} air_density;

typedef enum air_combine { AIR_COMBINE_ADD = 0, AIR_COMBINE_REPLACE = 1 } air_combine;

typedef struct air_medium_desc {
    const char *name;  /* copied; may be NULL */
    float sigma_s[3];  /* 1/m, >= 0, finite */
    float sigma_a[3];  /* 1/m, >= 0, finite */
    float emission[3]; /* emitted radiance per metre at density 1, W/(m^3 sr), >= 0 */
    air_phase
        phase; /* a mixture is copied; its weights may have any sum > 0 and are divided by it */
    air_density density;
    air_boundary boundary;
    air_combine combine;
    int32_t priority;
} air_medium_desc;

/* An unbounded constant medium with all coefficients 0, isotropic, add, priority 0, height along
 * +Y, no detail (4 octaves of scale 1 and seed 0 in the world's space, should it be given
 * strength). With density.kind AIR_DENSITY_GRID, an albedo grid redistributes sigma_t = sigma_s +
 * sigma_a. */
AIR_API void air_medium_desc_default(air_medium_desc *desc);

/* A dense description of a voxel grid; values are copied (sparse bricks inside).
 * Value (i,j,k,channel) is values[((k*size[1]+j)*size[0]+i)*channels+channel], located at the point
 * index_to_local * (i, j, k, 1); between, trilinear; outside [−1/2, size−1/2] zero. */
typedef struct air_grid_desc {
    const char *name;
    size_t size[3];      /* each >= 1 */
    size_t channels;     /* 1 or 3 */
    const float *values; /* finite; negative values are clamped to 0 and counted in a warning */
    float index_to_local[12];
} air_grid_desc;

#ifdef __cplusplus
}
#endif
#endif

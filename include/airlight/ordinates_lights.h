/* ordinates_lights.h: which lights the propagation grids of ordinates.h are worth: directions from
 * a sky map, by what the camera sees of them, and point sources from a reflective shadow map
 * [Elek2014, sections 5 and 6]; deviations: src/ordinates/README.md.
 *
 * Kernels over arrays: no scene, nothing random: the same input gives the same bytes, also by any
 * number of the context's threads, which only importance takes.
 *
 * Units: metres, 1/m, sr; radiance W/(m^2 sr), RGB. Lat-long arrays: +Y is up, the centre looks
 * along -Z and +X is at u = 3/4; texel (i, j), row 0 on top, is entry j * width + i. */
#ifndef AIRLIGHT_ORDINATES_LIGHTS_H
#define AIRLIGHT_ORDINATES_LIGHTS_H

#include <stddef.h>

#include "airlight/context.h"
#include "airlight/ordinates.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AIR_ORDINATES_LIGHTS_MAX = 4096, /* that are chosen at once */
    AIR_IMPORTANCE_WIDTH = 32,       /* of an importance map, a lat-long array in world space */
    AIR_IMPORTANCE_HEIGHT = 16,
    AIR_IMPORTANCE_TEXELS = AIR_IMPORTANCE_WIDTH * AIR_IMPORTANCE_HEIGHT
};

/* ---- sky maps ---- */

/* Radiance is constant over each pixel, so that sums over pixels are integrals. */
typedef struct air_environment_map {
    const float *pixels;  /* R, G, B side by side; borrowed; NULL: no map, `radiance` alone */
    size_t width, height; /* 1..65535; not looked at without pixels */
    size_t pixel_stride, row_stride; /* floats from pixel to pixel, >= 3, and from row to row, >=
                                        width * pixel_stride */
    float radiance[3]; /* times the pixels; without them the radiance itself; 0..1e30 */
    float contrast;    /* ordinates are dense as (luminance x importance)^contrast, (0, 1];
                          default 2/3. 1: by flux, as in the paper, which puts the more of them into
                          one place the brighter it is. 1/2 minimises the mean squared angle by which
                          light is moved, 2/3 the mean angle [Zador1982] */
} air_environment_map;

/* No pixels, radiance 1, contrast 2/3. */
AIR_API void air_environment_map_default(air_environment_map *map);

/* A map prepared for choosing ordinates again and again: its pixels along a curve over the sphere,
 * and sums along it. Immutable: any thread may use it, several at once. */
typedef struct air_environment_ordinates air_environment_ordinates;

/* Takes about 200 ns and 5 bytes per pixel, while it works 16 more. The pixels must stay as they
 * are until destroy. AIR_ERROR_ARGUMENT: a parameter is out of range, or a pixel (the first is
 * named) is negative, above 1e30 or not a number; AIR_ERROR_MEMORY. On failure *out is NULL. */
AIR_API air_status air_environment_ordinates_create(air_context *context,
                                                    const air_environment_map *map,
                                                    air_environment_ordinates **out);
AIR_API void air_environment_ordinates_destroy(air_environment_ordinates *self); /* NULL is legal */

/* The integral of radiance over the sphere, W/m^2. */
AIR_API void air_environment_ordinates_integral(const air_environment_ordinates *self,
                                                double out[3]);

/* What an ordinate stands for. */
typedef enum air_ordinate_form {
    AIR_ORDINATE_STRATUM = 0, /* a part of the sky, whole: its flux and its mean direction */
    AIR_ORDINATE_POINT = 1    /* a sample of it, E0 = L / (N p) [Elek2014, section 5.1] */
} air_ordinate_form;

/* From what the mean cosine of an ordinate's light follows. */
typedef enum air_ordinate_lobe {
    AIR_ORDINATE_LOBE_MEAN = 0,  /* that of the stratum's radiance to its mean direction */
    AIR_ORDINATE_LOBE_ANGLE = 1, /* 1 - Omega / (4 pi): a cap of constant radiance */
    AIR_ORDINATE_LOBE_BEAM = 2   /* 1 */
} air_ordinate_lobe;

typedef struct air_environment_choice {
    size_t count;           /* N, 1..AIR_ORDINATES_LIGHTS_MAX; default 64 */
    air_ordinate_form form; /* default STRATUM */
    air_ordinate_lobe lobe; /* default MEAN */
    float beta; /* exponent on the lobe, > 0; default 3/2: a cap and the Henyey-Greenstein
                   lobe that stands for it then have the same second moment if they are
                   narrow (1 - 3 (1 - a) against a^2), where 1 gives the same first one and
                   ordinates that show one by one */
    const float *importance; /* AIR_IMPORTANCE_TEXELS, 0..1e30; NULL: 1; borrowed */
    float to_world[9];       /* rows of the rotation from map to world; default: none */
} air_environment_choice;

AIR_API void air_environment_choice_default(air_environment_choice *choice);

typedef struct air_ordinate {
    double travel[3];     /* unit direction of travel, in world space */
    double irradiance[3]; /* E0 across it, W/m^2, RGB */
    double lobe;          /* a_n, in [0, 1]: air_ordinates_params.lobe */
    double solid_angle;   /* of the stratum, sr; of a point 1 / (N p) */
} air_ordinate;

/* Chooses choice->count ordinates: the curve is cut into pieces of equal (luminance x
 * importance)^contrast, within pixels too. Of strata, irradiances sum to the integral, per channel,
 * and directions follow map, importance and rotation without jumps. A black map gives ordinates of
 * irradiance 0 evenly over the sphere; importance that is 0 wherever there is light is left out. A
 * stratum whose radiances cancel (the whole of an even sky) has lobe 0 and comes from the map's +Y.
 * Less than 1 ms for 64. Allocates nothing. AIR_ERROR_ARGUMENT: a parameter is out of range; out is
 * then untouched. */
AIR_API air_status air_environment_ordinates_choose(air_context *context,
                                                    const air_environment_ordinates *self,
                                                    const air_environment_choice *choice,
                                                    air_ordinate *out);

/* ---- what the camera sees of the sky ---- */

/* A pyramid that is cut into AIR_IMPORTANCE_CELLS cells along each axis: (i, j, k), entry (k *
 * AIR_IMPORTANCE_CELLS + j) * AIR_IMPORTANCE_CELLS + i, i to the right, j upwards, both even in the
 * tangent, k even in depth from near to far. It should hold all of the medium that is seen, and of
 * what is not what light comes through: beyond it there is nothing. */
typedef struct air_importance_camera {
    float position[3];
    float right[3], up[3], forward[3]; /* orthonormal, to 1e-3 */
    float tan_half[2];   /* tangents of half the angles of view, across and up, (0, 100] */
    float near_m, far_m; /* depths along forward; 0 <= near < far */
} air_importance_camera;

enum { AIR_IMPORTANCE_CELLS = 16, AIR_IMPORTANCE_CELLS_ALL = 16 * 16 * 16 };

/* Centres of the cells, 3 floats each, in world space: where to take coefficients.
 * AIR_ERROR_ARGUMENT: the camera is out of range. */
AIR_API air_status air_importance_points(air_context *context, const air_importance_camera *camera,
                                         float *out);

/* One number per cell; of RGB some mean. Borrowed. */
typedef struct air_importance_medium {
    const float *sigma_s, *sigma_a; /* 1/m, 0..1e30 */
    const float *g;                 /* in (-1, 1) */
} air_importance_medium;

/* In sr of the camera's view. in = through + scattered + absorbed + residual to 1e-5 of it. */
typedef struct air_importance_books {
    double in;        /* the pyramid's solid angle */
    double through;   /* leaves without an event */
    double scattered; /* leaves after some: what the map sums to */
    double absorbed;
    double residual; /* still under way after the last step: 1e-3 of in at most, or 64 steps */
} air_importance_books;

/* Bytes of scratch, to be aligned to 64, of air_importance_propagate. */
AIR_API size_t air_importance_scratch(void);

/* How much of the sky the camera sees by scattering: the integral over the view of the radiance
 * that comes to it so is the integral over the sky of radiance times map, AIR_IMPORTANCE_TEXELS, sr
 * per sr. The camera's rays are sent as light through the pyramid, and what leaves is sorted by
 * direction: light that comes from there goes the same ways back. Neighbouring rays count as
 * parallel, so the map is rough (figures: src/ordinates/README.md); it steers where ordinates are,
 * not what they carry. books may be NULL. AIR_ERROR_ARGUMENT: a camera or coefficient is out of
 * range; outputs are then untouched. [Elek2014, section 5.2] */
AIR_API air_status air_importance_propagate(air_context *context,
                                            const air_importance_camera *camera,
                                            const air_importance_medium *medium, void *scratch,
                                            float *out_map, air_importance_books *out_books);

/* A map made fit to choose by: smoothed over its neighbours (1/4, 1/2, 1/4 along each axis, over
 * the poles), scaled to mean 1 over the sphere and mixed with `floor` in [0, 1] of 1 (10 % is
 * usual). A map of zeros gives 1. out may be map. */
AIR_API void air_importance_smooth(const float *map, float floor, float *out);

/* keep times previous and 1 - keep times next, texel by texel: from picture to picture, 0.8 is
 * usual. out may be either. */
AIR_API void air_importance_blend(const float *previous, const float *next, float keep, float *out);

/* ---- lit surfaces ---- */

/* What a light sees of surfaces, a reflective shadow map: in an order in which neighbours are near
 * each other, such as rows to and fro or a Hilbert curve. Borrowed. */
typedef struct air_surface_samples {
    size_t count;               /* >= 1 */
    const float *position;      /* 3 each, m */
    const float *normal;        /* 3 each, unit to 1 % */
    const float *albedo;        /* R, G, B each, in [0, 1]; NULL: 1 */
    const float *irradiance;    /* R, G, B each, W/m^2, 0..1e30; without area W */
    const float *transmittance; /* R, G, B each, from light to surface, in [0, 1]; NULL: 1 */
    const float *area;          /* of surface that each stands for, m^2, 0..1e30; NULL: no area,
                                   and irradiance is power */
} air_surface_samples;

/* A diffuse patch, as a point that sends flux / pi max(0, n.w) W/sr along w. */
typedef struct air_surface_light {
    double position[3], normal[3]; /* weighted by luminance; m, unit */
    double flux[3];                /* W, R, G, B */
    double
        radius_m; /* r_0 of the disk with the samples' second moment: 1 / r^2 is to be taken as
                     1 / (r^2 + r_0^2), which is exact on the disk's axis, or no nearer than r_0 */
    double lobe;  /* mean cosine of light from that disk to the direction from its middle, at the
                     distance asked for, or r_0 if that is more: 2 r / (r + sqrt(r^2 + r_0^2)) */
} air_surface_light;

/* Chooses count, 1..AIR_ORDINATES_LIGHTS_MAX, lights: the samples in their order, cut into pieces
 * of equal luminance of albedo x irradiance x transmittance x area, within samples too, so that
 * fluxes sum to the samples' per channel. Where order jumps, a light may lie between surfaces, with
 * a radius that tells. Samples without light are passed over; if all are, fluxes are 0 and pieces
 * have equal numbers. distance_m, > 0: for the lobe, such as the radius of the first shell of a
 * radial grid. AIR_ERROR_ARGUMENT: a parameter or sample (the first is named) is out of range; out
 * is then untouched. [Elek2014, section 6] */
AIR_API air_status air_surface_lights_choose(air_context *context,
                                             const air_surface_samples *samples, size_t count,
                                             double distance_m, air_surface_light *out);

#ifdef __cplusplus
}
#endif
#endif

/* denoise.h: smoothing of noisy pictures by what their guides see: joint a-trous wavelet filter
 * [Dammertz2010].
 *
 * Each level replaces a pixel by a weighted mean of 5 x 5 pixels, 1, 2, 4, ... apart. Weights are
 * the B3 spline's [1 4 6 4 1]/16 along both axes, times what the guides say of the two pixels:
 *     exp(-|ln(z_p / z_q)| / (0.25 scale 2^level))    depths of the first surface
 *     max(0, n_p.n_q)^(32 / scale^2)                  its normals
 *     exp(-|v_p - v_q| / value_width)                 a value of the caller's
 * and 0 where only one of them met a surface. They depend on the guides alone, so the filter is
 * linear, and planes filtered together keep their order: if 0 <= a <= b everywhere, it stays so.
 *
 * scale in (0, 1] shrinks the filter, so that it can vanish as pictures get better: the variance of
 * its splines, the sum of 4^level, falls to its scale^2-th part, the coarsest level fading first,
 * and the guides' widths fall with it; with scale towards 0 the filter becomes the identity. */
#ifndef AIRLIGHT_DENOISE_H
#define AIRLIGHT_DENOISE_H

#include "airlight/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* TERMS: those of air_term (render.h) whose layers have noise: S0, S+, M1, M2. */
enum { AIR_DENOISE_MAX_LEVELS = 8, AIR_DENOISE_MAX_PLANES = 64, AIR_DENOISE_TERMS = 15 };

/* What tells pixels apart: width * height floats each, rows from the top; borrowed. */
typedef struct air_denoise_guides {
    size_t width, height;
    const float *depth;     /* > 0, or 0 where no surface was met; NULL: nothing is known */
    const float *normal[3]; /* of any length: only the direction counts; NULL: nothing is known */
    const float *value;     /* any further number, as of a first estimate; NULL: nothing is known */
} air_denoise_guides;

typedef struct air_denoise_params {
    uint32_t levels;   /* [0, AIR_DENOISE_MAX_LEVELS]; default 3 */
    float scale;       /* (0, 1]; default 1 */
    float value_width; /* > 0; default 1 */
    bool albedo;       /* of images: filter what surfaces receive, not what they reflect; default
                          true */
    uint32_t terms;    /* of images with layers: mask of 1 << air_term of those to filter; default
                          AIR_DENOISE_TERMS */
} air_denoise_params;

AIR_API void air_denoise_params_default(air_denoise_params *params);

/* Filters count planes of the guides' size in place, all with the same weights; at most
 * AIR_DENOISE_MAX_PLANES. Pixels that are not finite in a guide or in a plane take no part, and
 * stay as they are. AIR_ERROR_ARGUMENT: a parameter out of range; AIR_ERROR_MEMORY. On failure the
 * planes are as they were. The same bytes for any number of threads. */
AIR_API air_status air_denoise_planes(air_context *context, const air_denoise_guides *guides,
                                      const air_denoise_params *params, float *const *planes,
                                      size_t count);

/* Smooths count pairs of planes in place whose quotients visible / whole, in [0, 1], are estimated
 * from that many samples per pixel (> 0), all with the same weights; at most
 * AIR_DENOISE_MAX_PLANES / 2. Twice: the share that the first filter finds is a guide of the
 * second. What that blurs vanishes as samples grow, at edges of shadows too; it is only nearly
 * linear. Errors as above. */
AIR_API air_status air_denoise_shares(air_context *context, const air_denoise_guides *guides,
                                      double samples, float *const *whole, float *const *visible,
                                      size_t count);

/* A filtered copy of an image with R, G, B and the guides that `airlight render --guides` leaves in
 * it: depth.Z; normal.X, .Y, .Z and albedo.R, .G, .B, both of which may be absent.
 *
 * Where the image holds layers (render --layers), each is filtered by what concerns it: S0 and S+
 * by depth and normals, divided by albedo; M1 and M2, which are light in the air, by depth alone;
 * emission and background, which are seen directly and often sharp, not at all. R, G, B become
 * their sum. Otherwise R, G, B are filtered as if all were light on surfaces.
 *
 * All other channels and attributes are copied, except variance.*, which says nothing of the
 * filtered picture. AIR_ERROR_ARGUMENT: a channel is missing (the message names it), or terms are
 * chosen and there are no layers. *out_image is NULL on failure. */
AIR_API air_status air_image_denoise(air_context *context, const air_image *image,
                                     const air_denoise_params *params, air_image **out_image);

#ifdef __cplusplus
}
#endif
#endif

/* denoise.h: smoothing of noisy pictures by what their guides see: joint a-trous wavelet filter
 * [Dammertz2010].
 *
 * Each level replaces a pixel by a weighted mean of 5 x 5 pixels, 1, 2, 4, ... apart. Weights are
 * the B3 spline's [1 4 6 4 1]/16 along both axes, times what the guides say of the two pixels:
 *     exp(-|ln(z_p / z_q)| / (0.25 scale 2^level))    depths of the first surface
 *     max(0, n_p.n_q)^(32 / scale^2)                  its normals
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

enum { AIR_DENOISE_MAX_LEVELS = 8 };

/* What tells pixels apart: width * height floats each, rows from the top; borrowed. */
typedef struct air_denoise_guides {
    size_t width, height;
    const float *depth;     /* > 0, or 0 where no surface was met; NULL: nothing is known */
    const float *normal[3]; /* unit where there is a surface; NULL: nothing is known */
} air_denoise_guides;

typedef struct air_denoise_params {
    uint32_t levels; /* [0, AIR_DENOISE_MAX_LEVELS]; default 3 */
    float scale;     /* (0, 1]; default 1 */
    bool albedo;     /* of images: filter what surfaces receive, not what they reflect; default
                        true */
} air_denoise_params;

AIR_API void air_denoise_params_default(air_denoise_params *params);

/* The scale for pictures of that many samples per pixel (> 0), 1 for one, so that what the filter
 * blurs vanishes with the noise it is there for. */
AIR_API float air_denoise_scale(double samples);

/* Filters count planes of the guides' size in place, all with the same weights. Pixels that are not
 * finite in a guide or in a plane take no part, and stay as they are. AIR_ERROR_ARGUMENT: a
 * parameter out of range; AIR_ERROR_MEMORY. On failure the planes are as they were. The same bytes
 * for any number of threads. */
AIR_API air_status air_denoise_planes(air_context *context, const air_denoise_guides *guides,
                                      const air_denoise_params *params, float *const *planes,
                                      size_t count);

/* A filtered copy of R,G,B of an image with the guides that `airlight render --guides` leaves in
 * it: channels depth.Z, normal.X, .Y, .Z and, where params->albedo, albedo.R, .G, .B. All other
 * channels and attributes are copied. AIR_ERROR_ARGUMENT: no R,G,B or no depth.Z. *out_image is
 * NULL on failure. */
AIR_API air_status air_image_denoise(air_context *context, const air_image *image,
                                     const air_denoise_params *params, air_image **out_image);

#ifdef __cplusplus
}
#endif
#endif

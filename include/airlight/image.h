/* image.h: images, their files, view transforms and metrics.
 *
 * An air_image holds named float channels of one size; row 0 is the top. Colour is linear Rec. 709,
 * premultiplied by alpha where there is one. An image may be read from several threads at once,
 * edited from one. Where a function asks for R,G,B an image with a channel Y alone serves as grey.
 */
#ifndef AIRLIGHT_IMAGE_H
#define AIRLIGHT_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct air_image air_image;

/* channel_names: "R", "G", "B", "A", or "LAYER.R" and so on; copied; at most 1023 channels. Pixels
 * start as 0. AIR_ERROR_ARGUMENT: a size of 0 or above 65535, a duplicate or empty name. */
AIR_API air_status air_image_create(air_context *context, size_t width, size_t height,
                                    size_t channel_count, const char *const *channel_names,
                                    air_image **out_image);
AIR_API void air_image_destroy(air_image *image); /* NULL is legal */

AIR_API size_t air_image_width(const air_image *image);
AIR_API size_t air_image_height(const air_image *image);
AIR_API size_t air_image_channel_count(const air_image *image);
AIR_API const char *air_image_channel_name(const air_image *image, size_t channel);
/* Index of a channel, or -1. */
AIR_API ptrdiff_t air_image_find_channel(const air_image *image, const char *name);
/* One channel's plane: width*height floats, rows from the top; owned by the image. */
AIR_API float *air_image_plane(air_image *image, size_t channel);
AIR_API const float *air_image_plane_const(const air_image *image, size_t channel);

/* String attributes ("airlight:seed", ...), written to EXR headers and read back; copied. value
 * NULL removes. AIR_ERROR_ARGUMENT: an empty name or one above 255 bytes. */
AIR_API air_status air_image_set_attribute(air_image *image, const char *name, const char *value);
AIR_API const char *air_image_attribute(const air_image *image,
                                        const char *name); /* NULL if absent */
AIR_API size_t air_image_attribute_count(const air_image *image);
AIR_API const char *air_image_attribute_name(const air_image *image, size_t index);

/* ---- files; the format follows the extension: .exr .hdr .png .jpg .pfm .ktx2 (read), .exr
 * .png .pfm .ktx2 (written) ---- */

/* Reads a file through the context's reader. EXR: the first part, scanlines or tiles (level 0), all
 * channels, and string attributes; the image is the display window, 0 where the data window does
 * not reach. PNG and JPEG: 8 or 16 bits, sRGB decoded to linear, R,G,B (grey too) and A, which
 * multiplies the colours. HDR: R,G,B; EXPOSURE lines are ignored. PFM: R,G,B or Y; its scale is
 * ignored. KTX2: R,G,B of the first level of one flat picture, formats R16G16B16A16_SFLOAT,
 * R32G32B32A32_SFLOAT, B10G11R11_UFLOAT and E5B9G9R9_UFLOAT, plain or Zstandard; alpha is ignored.
 * AIR_ERROR_FORMAT: garbage, truncation, a side above 65535 or more than 2^31 bytes as floats;
 * AIR_ERROR_UNSUPPORTED: another extension, deep or subsampled EXR, another kind of KTX2. */
AIR_API air_status air_image_load(air_context *context, const char *path, air_image **out_image);

/* NEUTRAL: Khronos PBR Neutral. STANDARD: clipped to [0,1]. RAW: the numbers themselves clipped to
 * [0,1], without exposure and, in a file, without the sRGB transfer. */
typedef enum air_view { AIR_VIEW_NEUTRAL = 0, AIR_VIEW_STANDARD = 1, AIR_VIEW_RAW = 2 } air_view;

typedef struct air_image_save_params {
    bool half;          /* EXR, KTX2: 16-bit channels; default false */
    bool auto_exposure; /* PNG: from the log-average luminance; default true */
    float exposure_ev;  /* PNG: stops, used when auto_exposure is false; default 0 */
    air_view view; /* PNG: default AIR_VIEW_NEUTRAL (Khronos PBR Neutral), then sRGB transfer */
    bool alpha;    /* PNG: also A, if there is one; default false: the picture over black */
} air_image_save_params;

AIR_API void air_image_save_params_default(air_image_save_params *params);

/* Writes beside the final name, then renames: the file appears whole or not at all. EXR: all
 * channels and attributes, ZIP; in half, finite values beyond +-65504 become +-65504 with a
 * warning. PNG: 8 bits of R,G,B (and A); values that are not finite are written as 0. PFM: R,G,B,
 * else the only channel. KTX2: R,G,B (or Y) and an alpha of 1, Zstandard; half as for EXR. params
 * NULL: the defaults. AIR_ERROR_ARGUMENT: the format needs channels the image lacks;
 * AIR_ERROR_UNSUPPORTED: another extension. */
AIR_API air_status air_image_save(air_context *context, const air_image *image, const char *path,
                                  const air_image_save_params *params);

/* The exposure in stops that auto_exposure chooses: log2(0.18 / log-average luminance) over the
 * positive luminances, the darkest and the brightest 5 % of them left out; 0 for a black image or
 * one without colour. */
AIR_API float air_image_auto_exposure(const air_image *image);

/* Exposure and view transform of one linear pixel to display-linear [0,1] (before the sRGB
 * transfer). Components that are negative or not finite count as 0. */
AIR_API void air_view_apply(air_view view, float exposure_ev, const float rgb[3], float out_rgb[3]);

/* ---- metrics: one definition each, docs/metrics.md ---- */

typedef struct air_metrics {
    double mean_a, mean_b; /* means over R,G,B; B is the reference */
    double bias;           /* (mean_a - mean_b) / mean_b */
    double rmse;           /* sqrt(mean (A-B)^2) */
    double relative_rmse;  /* rmse / mean_b */
    double rel_mse;        /* mean((A-B)^2 / (B^2 + 1e-4 mean_b^2)) */
    double psnr;           /* -10 log10(mean((A-B)^2) / max(B)^2), dB */
    double flip;           /* LDR-FLIP of both after exposure and view transform, mean */
    double hdr_flip;       /* HDR-FLIP, mean */
    size_t pixel_count;
} air_metrics;

typedef struct air_metrics_params {
    float exposure_ev;       /* of the LDR pictures FLIP looks at */
    bool auto_exposure;      /* from the reference; default true */
    air_view view;           /* default AIR_VIEW_NEUTRAL */
    float pixels_per_degree; /* [1, 1000]; default 67.0206 (0.7 m from a 0.7 m wide 3840 px monitor)
                              */
    const uint8_t *mask;     /* width*height, non-zero = counted; NULL: all; borrowed */
} air_metrics_params;

AIR_API void air_metrics_params_default(air_metrics_params *params);

/* Compares R,G,B of two images of equal size; b is the reference. The mask selects what is
 * averaged; FLIP still sees the whole pictures. Ratios whose denominator is 0 are 0 if the
 * numerator is, else INFINITY. AIR_ERROR_ARGUMENT: sizes differ, no R,G,B, an empty mask;
 * AIR_ERROR_FORMAT: a value that is not finite (the message names the first pixel). */
AIR_API air_status air_image_compare(air_context *context, const air_image *a, const air_image *b,
                                     const air_metrics_params *params, air_metrics *out_metrics);

/* Per-pixel LDR-FLIP in [0,1] as a one-channel image "Y". Errors as air_image_compare. */
AIR_API air_status air_image_flip(air_context *context, const air_image *a, const air_image *b,
                                  const air_metrics_params *params, air_image **out_map);

/* |A - B| of R,G,B of two images of equal size, as an image R,G,B. Values that are not finite stay
 * so. */
AIR_API air_status air_image_difference(air_context *context, const air_image *a,
                                        const air_image *b, air_image **out_image);

/* A picture of magnitudes: the mean of |R|,|G|,|B| (or |Y|, or an image's only channel), divided by
 * scale_max and clipped to [0,1], through a perceptually even colour map from near black over
 * violet and orange to pale yellow; what is not finite becomes cyan. *out_image has linear R,G,B in
 * [0,1], to be saved with AIR_VIEW_STANDARD at exposure 0. AIR_ERROR_ARGUMENT: scale_max is not
 * positive and finite, or no such channels. */
AIR_API air_status air_image_false_colour(air_context *context, const air_image *image,
                                          float scale_max, air_image **out_image);

/* Two-sided Z-test that A and B have the same expectation, given variances of the means per pixel.
 * block x block pixels are averaged first. Each channel of each block is a test; its p-value comes
 * from Student's t. Each pixel variance has the stated degrees of freedom (replicates - 1); those
 * of a sum follow Welch and Satterthwaite. p-values over several channels, which are correlated,
 * are those of the worst one with a Sidak correction over the three. */
typedef struct air_ztest {
    size_t test_count;         /* channels of blocks with a positive variance */
    double min_p;              /* smallest p of one test */
    double sidak_p;            /* 1 - (1 - min_p)^test_count */
    double mean_z;             /* z of the image mean, of the channel where |z| is largest */
    double mean_p;             /* its p-value, Sidak-corrected over the channels */
    double chi_square_p;       /* of the sum of squared normal scores of the tests of one channel,
                                  likewise */
    double fraction_beyond_95; /* tests outside their own 95 % interval */
    size_t differing_without_variance; /* channels of blocks that differ although their variance is
                                          0; not tested */
} air_ztest;

/* variance_a, variance_b: channels variance.R, variance.G, variance.B, else R,G,B; either may be
 * NULL for an exact image. AIR_ERROR_ARGUMENT: both are NULL, sizes differ, missing channels, block
 * or degrees_of_freedom 0; AIR_ERROR_FORMAT: a value that is not finite, or a negative variance.
 * Without any positive variance test_count is 0 and every p is 1. */
AIR_API air_status air_image_ztest(air_context *context, const air_image *a, const air_image *b,
                                   const air_image *variance_a, const air_image *variance_b,
                                   size_t block, size_t degrees_of_freedom, air_ztest *out_test);

#ifdef __cplusplus
}
#endif
#endif

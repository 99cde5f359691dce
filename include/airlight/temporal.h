/* temporal.h: how much a sequence of pictures flickers, against a reference (docs/metrics.md).
 *
 * Two sequences of one scene, A and the reference B, are taken in frame by frame. What counts is
 * how each pixel changes from frame to frame: a constant error does not flicker, and motion that
 * both sequences have alike is none. */
#ifndef AIRLIGHT_TEMPORAL_H
#define AIRLIGHT_TEMPORAL_H

#include "airlight/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* With the changes dA = A_t - A_(t-1) and dB = B_t - B_(t-1) of each pixel and channel, and their
 * sample variances var A and var B over the frames (divisor: changes - 1). A pixel's variance is
 * the mean of those of R, G, B. */
typedef struct air_temporal_metrics {
    double variance_a, variance_b; /* means over the pixels */
    double mean_b;                 /* of B over pixels, channels and frames */
    double ratio; /* mean over the pixels of (var A + f) / (var B + f), f = 1e-6 mean_b^2 */
    double ratio_of_means; /* variance_a / variance_b */
    double difference;     /* mean over pixels, channels and changes of |dA - dB| */
    size_t pixel_count, frame_count;
} air_temporal_metrics;

/* Sums over a pair of sequences. Not to be used from several threads at once. */
typedef struct air_temporal air_temporal;

AIR_API air_status air_temporal_create(air_context *context, air_temporal **out_temporal);
AIR_API void air_temporal_destroy(air_temporal *temporal); /* NULL is legal */

/* Takes in the next frame of both, which are not kept; 168 bytes per pixel are. AIR_ERROR_ARGUMENT:
 * sizes differ, also from those of the frames before, or no R,G,B; AIR_ERROR_FORMAT: a value that
 * is not finite. On failure the frame does not count. */
AIR_API air_status air_temporal_add(air_temporal *temporal, const air_image *a, const air_image *b);

/* mask: a byte per pixel, non-zero = counted; NULL: all. Ratios whose denominator is 0 are 0 if the
 * numerator is, else INFINITY. AIR_ERROR_ARGUMENT: fewer than three frames, an empty mask. */
AIR_API air_status air_temporal_measure(const air_temporal *temporal, const uint8_t *mask,
                                        air_temporal_metrics *out_metrics);

/* Per pixel and channel the mean over the frames of |dA - dB|, as an image R,G,B.
 * AIR_ERROR_ARGUMENT: fewer than two frames. */
AIR_API air_status air_temporal_difference(const air_temporal *temporal, air_image **out_image);

#ifdef __cplusplus
}
#endif
#endif

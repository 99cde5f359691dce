/* view.c: exposure and view transforms: from scene-linear to display-linear colour. */
#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "image/image.h"

/* Khronos PBR Neutral [KhronosNeutral2024]: the identity (up to the offset f90) until the peak
 * reaches `start`, then a compression of the peak towards 1 with a growing desaturation. rgb >= 0.
 */
static air_vec3 neutral(air_vec3 rgb)
{
    const float f90 = 0.04f;
    const float start = 0.8f - f90;
    const float desaturation = 0.15f;
    const float low = vec3_min(rgb);
    const float offset = low < 2.0f * f90 ? low - low * low / (4.0f * f90) : f90;
    rgb = vec3_sub(rgb, vec3_set1(offset));
    const float peak = vec3_max(rgb);
    if (peak < start) {
        return rgb;
    }
    const float d = 1.0f - start;
    const float new_peak = 1.0f - d * d / (peak + d - start);
    const float grey = 1.0f - 1.0f / (desaturation * (peak - new_peak) + 1.0f);
    const air_vec3 compressed = vec3_scale(rgb, new_peak / peak);
    return vec3_madd(vec3_scale(compressed, 1.0f - grey), grey * new_peak, vec3_set1(1.0f));
}

static float clip(float value) { return fminf(fmaxf(value, 0.0f), 1.0f); }

void air_view_apply(air_view view, float exposure_ev, const float rgb[3], float out_rgb[3])
{
    /* Exposed values stop short of overflow, so that the compression below stays a number. */
    const float largest = 1e30f;
    const float scale = view == AIR_VIEW_RAW ? 1.0f : exp2f(exposure_ev);
    float exposed[3];
    for (size_t c = 0; c < 3; c++) {
        exposed[c] = isfinite(rgb[c]) && rgb[c] > 0.0f ? fminf(rgb[c] * scale, largest) : 0.0f;
    }
    air_vec3 v = vec3_load(exposed);
    if (view == AIR_VIEW_NEUTRAL) {
        v = neutral(v);
    }
    vec3_store(out_rgb, vec3(clip(v.x), clip(v.y), clip(v.z)));
}

/* Log-luminances are binned, 64 bins per stop, so that the tails can be left out without sorting;
 * within a bin their sum is kept, so that the average is exact but for the two bins the cuts go
 * through. */
enum { BINS_PER_STOP = 64, STOP_RANGE = 80, BIN_COUNT = 2 * STOP_RANGE * BINS_PER_STOP };

typedef struct log_histogram {
    uint64_t count[BIN_COUNT];
    double sum[BIN_COUNT]; /* of log2 luminance */
} log_histogram;

static uint64_t fill_histogram(log_histogram *histogram, const float *const planes[3], size_t count)
{
    uint64_t total = 0;
    memset(histogram, 0, sizeof(*histogram));
    for (size_t i = 0; i < count; i++) {
        const double y = 0.2126 * (double)planes[0][i] + 0.7152 * (double)planes[1][i] +
                         0.0722 * (double)planes[2][i];
        if (!(y > 0.0) || !isfinite(y)) {
            continue;
        }
        const double stops = log2(y);
        const double bin = fmin(fmax((stops + STOP_RANGE) * BINS_PER_STOP, 0.0), BIN_COUNT - 1.0);
        histogram->count[(size_t)bin]++;
        histogram->sum[(size_t)bin] += stops;
        total++;
    }
    return total;
}

float air_image_auto_exposure(const air_image *image)
{
    const float *planes[3];
    if (!air_image_colour(image, planes)) {
        return 0.0f;
    }
    log_histogram *histogram = air_allocate(image->context, 1, sizeof(*histogram));
    if (histogram == NULL) {
        return 0.0f;
    }
    const uint64_t total = fill_histogram(histogram, planes, image->width * image->height);
    float exposure = 0.0f;
    if (total > 0) {
        const double tail = 0.05;
        const double low = tail * (double)total;
        const double high = (1.0 - tail) * (double)total;
        double below = 0.0;
        double sum = 0.0;
        for (size_t i = 0; i < BIN_COUNT; i++) {
            const double n = (double)histogram->count[i];
            const double kept = fmin(below + n, high) - fmax(below, low);
            if (n > 0.0 && kept > 0.0) {
                sum += histogram->sum[i] * (kept / n);
            }
            below += n;
        }
        exposure = (float)(log2(0.18) - sum / (high - low));
    }
    air_free(image->context, histogram);
    return exposure;
}

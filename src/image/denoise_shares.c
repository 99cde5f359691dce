/* denoise_shares.c: visible shares of light, smoothed as far as their own noise asks for. */
#include <math.h>
#include <string.h>

#include "airlight/denoise.h"
#include "core/host.h"

/* A number of samples to a power, 1 for one and fewer. */
static float shrunk(double samples, double power)
{
    return samples > 1.0 ? (float)pow(samples, power) : 1.0f;
}

/* The share of all planes together; 1 where there is nothing. */
static float share_of(float *const *whole, float *const *visible, size_t count, size_t i)
{
    float total = 0.0f, seen = 0.0f;
    for (size_t k = 0; k < count; k++) {
        total += whole[k][i];
        seen += visible[k][i];
    }
    return total > 0.0f ? seen / total : 1.0f;
}

/* A first estimate, by the other guides alone, becomes a guide itself: where shares change, the
 * filter then becomes narrow, and where they do not it may stay wide. What it blurs is bounded by
 * the width of that guide, which falls as the noise of one pixel's share. The exponents were chosen
 * by bench_arealight_shadow. */
static air_status smooth_by_first(air_context *context, const air_denoise_guides *guides,
                                  double samples, float *const *planes, size_t count,
                                  float *const *first, float *share)
{
    air_denoise_params params;
    air_denoise_guides with_share = *guides;
    const size_t pixels = guides->width * guides->height;
    air_denoise_params_default(&params);
    params.scale = shrunk(samples, -0.25);
    air_status status = air_denoise_planes(context, guides, &params, first, 2 * count);
    if (status != AIR_OK) {
        return status;
    }
    for (size_t i = 0; i < pixels; i++) {
        share[i] = share_of(first, first + count, count, i);
    }
    with_share.value = share;
    params.scale = shrunk(samples, -0.15);
    params.value_width = 0.2f * shrunk(samples, -0.5);
    return air_denoise_planes(context, &with_share, &params, planes, 2 * count);
}

air_status air_denoise_shares(air_context *context, const air_denoise_guides *guides,
                              double samples, float *const *whole, float *const *visible,
                              size_t count)
{
    const size_t pixels = guides->width * guides->height;
    float *planes[AIR_DENOISE_MAX_PLANES], *first[AIR_DENOISE_MAX_PLANES];
    if (!(samples > 0.0) || 2 * count > AIR_DENOISE_MAX_PLANES) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "denoise: %g samples, %zu shares: expected samples above 0 and at most %d "
                        "shares",
                        samples, count, (int)AIR_DENOISE_MAX_PLANES / 2);
    }
    if (pixels == 0 || count == 0) {
        return AIR_OK;
    }
    float *copies = air_allocate(context, (2 * count + 1) * pixels, sizeof *copies);
    if (copies == NULL) {
        return air_fail_memory(context, "denoise");
    }
    for (size_t k = 0; k < 2 * count; k++) {
        planes[k] = k < count ? whole[k] : visible[k - count];
        first[k] = copies + k * pixels;
        memcpy(first[k], planes[k], pixels * sizeof *copies);
    }
    const air_status status = smooth_by_first(context, guides, samples, planes, count, first,
                                              copies + 2 * count * pixels);
    air_free(context, copies);
    return status;
}

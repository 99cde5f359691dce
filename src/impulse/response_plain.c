/* response_plain.c: batches, one place after the other: what the others are held against. */
#include "impulse/response.h"

void impulse_batch_plain(const air_impulse_response *response, const air_impulse_places *places,
                         size_t count, float *const *out)
{
    const bool area = response->emitter == AIR_IMPULSE_AREA;
    for (size_t i = 0; i < count; i++) {
        const air_impulse_place_float place = {.distance = places->distance[i],
                                               .n_l = places->n_l[i],
                                               .cos_s = area ? places->cos_s[i] : 1.0f,
                                               .n_x = area ? places->n_x[i] : 0.0f};
        float irradiance[AIR_IMPULSE_CHANNELS_MAX];
        air_impulse_response_irradiance(response, &place, irradiance);
        for (size_t c = 0; c < response->channel_count; c++) {
            out[c][i] = irradiance[c];
        }
    }
}

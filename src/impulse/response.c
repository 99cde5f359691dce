/* response.c: responses asked, one place at a time. */
#include "impulse/response.h"

static float channel_irradiance(const air_impulse_response *r, const response_channel *c,
                                const air_impulse_place_float *p, response_place angle)
{
    float scale, sum;
    const response_place bin = response_bin(r, c, p->distance, &scale);
    if (r->emitter == AIR_IMPULSE_AREA) {
        const size_t step = r->bins * AREA_POWERS;
        const float *const at =
            c->entries + (size_t)angle.lower * step + (size_t)bin.lower * AREA_POWERS;
        sum = area_sum(at, step, bin.share, angle.share, p->n_l, p->n_x);
    } else {
        sum = zonal_sum(c->entries + (size_t)bin.lower * ZONAL_POWERS, bin.share, p->n_l);
    }
    const float e = float_max(0.0f, sum * scale);
    return c->whole > 0.0f ? e + response_excess(r, c, p->distance, p->n_l, p->cos_s) : e;
}

void air_impulse_response_irradiance(const air_impulse_response *response,
                                     const air_impulse_place_float *place, float *out)
{
    response_place angle = {0, 0.0f};
    if (response->emitter == AIR_IMPULSE_AREA) {
        angle = response_angle(response, place->cos_s);
    }
    for (size_t i = 0; i < response->channel_count; i++) {
        out[i] = channel_irradiance(response, &response->channels[i], place, angle);
    }
}

void air_impulse_response_batch(const air_impulse_response *response,
                                const air_impulse_places *places, size_t count, float *const *out)
{
    response->batch(response, places, count, out);
}

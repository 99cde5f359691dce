/* response_prepare.c: entries of responses, from tables. */
#include "impulse/response.h"

#include "core/host.h"
#include "core/vec.h"
#include "impulse/lookup.h"
#include "impulse/rest.h"

static void store(const double *from, size_t count, double scale, float *out)
{
    for (size_t i = 0; i < count; i++) {
        out[i] = (float)(scale * from[i]);
    }
}

typedef struct preparing {
    const air_impulse_tables *tables;
    air_impulse_medium medium;
    const impulse_rest *rest; /* or NULL; of the reduced extinction */
    double rest_sigma_t;
    air_impulse_response *response;
    response_channel *channel;
} preparing;

static void prepare_zonal(const preparing *self, size_t bin, double distance, double scale)
{
    const double sigma = self->rest_sigma_t;
    double zh[AIR_IMPULSE_ORDER], powers[ZONAL_POWERS];
    air_impulse_zonal(self->tables, self->response->emitter, &self->medium, 1, self->medium.bounces,
                      distance, zh);
    if (self->rest != NULL) {
        impulse_rest_add_zonal(self->rest, sigma * distance, sigma * sigma, zh);
    }
    impulse_zonal_polynomial(zh, powers);
    store(powers, ZONAL_POWERS, scale, self->channel->entries + bin * ZONAL_POWERS);
}

static void prepare_area(const preparing *self, size_t bin, double distance, double scale)
{
    const air_impulse_response *const r = self->response;
    const double sigma = self->rest_sigma_t;
    double sh[AIR_IMPULSE_SH_COUNT], theta_s[TABLES_ANGLES_MAX], powers[AREA_POWERS];
    double rest[TABLES_ANGLES_MAX * MULTIPLE_COUNT] = {0.0};
    for (size_t angle = 0; angle < r->angles; angle++) {
        theta_s[angle] = impulse_angle(r->angles, angle);
    }
    if (self->rest != NULL) {
        impulse_rest_area(self->rest, sigma * distance, sigma * sigma, theta_s, (int)r->angles,
                          rest);
    }
    for (size_t angle = 0; angle < r->angles; angle++) {
        (void)air_impulse_mirrored(self->tables, &self->medium, 1, self->medium.bounces, distance,
                                   cos(theta_s[angle]), sh);
        for (size_t c = 0; c < MULTIPLE_COUNT; c++) {
            sh[c] += rest[angle * MULTIPLE_COUNT + c];
        }
        impulse_area_polynomial(sh, powers);
        store(powers, AREA_POWERS, scale,
              self->channel->entries + (angle * r->bins + bin) * AREA_POWERS);
    }
}

static void prepare_bin(void *user, size_t bin, size_t worker)
{
    const preparing *const self = user;
    const double rho = impulse_bin_tau(self->response->bins, bin), sigma = self->channel->sigma;
    const double rise = exp(rho * (double)self->channel->fall);
    (void)worker;
    if (self->response->emitter == AIR_IMPULSE_AREA) {
        prepare_area(self, bin, rho / sigma, rise * rho / (sigma * sigma));
    } else if (self->response->emitter == AIR_IMPULSE_POINT) {
        prepare_zonal(self, bin, rho / sigma, rise * rho / (sigma * sigma));
    } else {
        prepare_zonal(self, bin, rho / sigma, rise);
    }
}

/* The residual rule's excess is kept apart: it is a direction's, not bands'. With all orders light
 * falls off by the diffusion's kappa and is worth asking for twice as far away. */
static air_status prepare_channel(const air_impulse_tables *tables,
                                  const air_impulse_medium *medium, bool all_orders,
                                  air_impulse_response *response, response_channel *channel)
{
    const impulse_sum sum = impulse_sum_of(&tables->params, medium, 1, medium->bounces);
    preparing job = {.tables = tables,
                     .medium = impulse_sum_medium(&sum, medium),
                     .rest_sigma_t = sum.reduced_sigma_t,
                     .response = response,
                     .channel = channel};
    const bool several = sum.last > 1 || all_orders;
    const double slower = several ? double_min(sum.sigma_t, sum.reduced_sigma_t) : sum.sigma_t;
    impulse_rest *rest = NULL;
    channel->sigma = medium->sigma_s > 0.0 ? (float)(all_orders ? 0.5 * slower : slower) : 0.0f;
    if (!(channel->sigma > 0.0f)) {
        return AIR_OK;
    }
    if (sum.residual) {
        channel->reduced = (float)sum.reduced_sigma_t;
        channel->whole = (float)medium->sigma_t;
    }
    channel->fall = 1.0f;
    if (all_orders) {
        channel->fall = (float)(2.0 * impulse_diffusion_rate(sum.reduced_albedo) *
                                sum.reduced_sigma_t / slower);
        channel->fall = float_min(channel->fall, 2.0f);
        job.rest = rest = impulse_rest_create(response->context, sum.last, sum.reduced_albedo);
        if (rest == NULL) {
            return air_fail_memory(response->context, "impulse response");
        }
    }
    air_parallel_for(response->context, response->bins, prepare_bin, &job);
    impulse_rest_destroy(response->context, rest);
    return AIR_OK;
}

static impulse_batch *batch_of(const air_context *context)
{
#if defined(__x86_64__)
    if (air_context_cpu(context) == AIR_CPU_AVX512) {
        return impulse_batch_avx512;
    }
    if (air_context_cpu(context) == AIR_CPU_AVX2) {
        return impulse_batch_avx2;
    }
    if (air_context_cpu(context) == AIR_CPU_SSE42) {
        return impulse_batch_sse42;
    }
#endif
    (void)context;
    return impulse_batch_plain;
}

static bool is_medium(const air_impulse_medium *m)
{
    return m->sigma_t >= 0.0 && m->sigma_t <= 1e9 && m->sigma_s >= 0.0 &&
           m->sigma_s <= m->sigma_t && fabs(m->g) < 1.0 && m->bounces >= 1;
}

static air_status check(air_context *context, air_impulse_emitter emitter,
                        const air_impulse_medium *media, size_t channels)
{
    bool good = channels >= 1 && channels <= AIR_IMPULSE_CHANNELS_MAX &&
                (unsigned)emitter < AIR_IMPULSE_EMITTERS;
    for (size_t i = 0; i < channels && good; i++) {
        good = is_medium(&media[i]);
    }
    return good ? AIR_OK
                : air_fail(context, AIR_ERROR_ARGUMENT,
                           "impulse response: expected 1 to 3 media with 0 <= sigma_s <= sigma_t, "
                           "|g| < 1 and a bounce at least");
}

static void set_axes(const air_impulse_tables *tables, air_impulse_response *self)
{
    self->bins = tables->params.bins;
    self->angles = tables->angles;
    self->first = (float)cbrt(IMPULSE_TAU_LEAST / IMPULSE_TAU_GREATEST);
    self->scale = (float)(self->bins - 1) / (1.0f - self->first);
    self->quarter = (float)(self->angles - 1) / 3.0f;
    self->angle_scale = self->quarter * 2.0f / AIR_PI_F;
}

static air_status create(air_context *context, const air_impulse_tables *tables,
                         air_impulse_emitter emitter, const air_impulse_medium *media,
                         size_t channels, bool all_orders, air_impulse_response **out)
{
    *out = NULL;
    air_status status = check(context, emitter, media, channels);
    if (status != AIR_OK) {
        return status;
    }
    air_impulse_response *const self = air_allocate(context, 1, sizeof *self);
    if (self == NULL) {
        return air_fail_memory(context, "impulse response");
    }
    self->context = context;
    self->emitter = emitter;
    self->batch = batch_of(context);
    set_axes(tables, self);
    const size_t count = self->bins * (emitter == AIR_IMPULSE_AREA ? self->angles * AREA_POWERS
                                                                   : (size_t)ZONAL_POWERS);
    for (; self->channel_count < channels && status == AIR_OK; self->channel_count++) {
        response_channel *const channel = &self->channels[self->channel_count];
        air_impulse_medium medium = media[self->channel_count];
        medium.bounces = all_orders ? tables->params.bounces : medium.bounces;
        channel->entries = air_allocate(context, count, sizeof(float));
        status = channel->entries == NULL
                     ? air_fail_memory(context, "impulse response")
                     : prepare_channel(tables, &medium, all_orders, self, channel);
    }
    if (status != AIR_OK) {
        air_impulse_response_destroy(self);
        return status;
    }
    *out = self;
    return AIR_OK;
}

air_status air_impulse_response_create(air_context *context, const air_impulse_tables *tables,
                                       air_impulse_emitter emitter, const air_impulse_medium *media,
                                       size_t channels, air_impulse_response **out)
{
    return create(context, tables, emitter, media, channels, false, out);
}

air_status air_impulse_response_create_all_orders(air_context *context,
                                                  const air_impulse_tables *tables,
                                                  air_impulse_emitter emitter,
                                                  const air_impulse_medium *media, size_t channels,
                                                  air_impulse_response **out)
{
    if (emitter == AIR_IMPULSE_DIRECTIONAL) {
        *out = NULL;
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "impulse response: all orders of directional light are not known");
    }
    return create(context, tables, emitter, media, channels, true, out);
}

void air_impulse_response_destroy(air_impulse_response *response)
{
    if (response == NULL) {
        return;
    }
    for (size_t i = 0; i < response->channel_count; i++) {
        air_free(response->context, response->channels[i].entries);
    }
    air_free(response->context, response);
}

/* response_prepare.c: entries of responses, from tables. */
#include "impulse/response.h"

#include "core/host.h"
#include "core/vec.h"
#include "impulse/lookup.h"

/* ---- preparing ---- */

/* The sum of A_l c_l P_l(z) in powers of z. */
static void zonal_entry(const double *zh, double scale, float *out)
{
    double power[AIR_IMPULSE_ORDER][AIR_IMPULSE_ORDER] = {{1.0}, {0.0, 1.0}};
    double lobe[AIR_IMPULSE_ORDER], sum[AIR_IMPULSE_ORDER] = {0.0};
    air_zh_clamped_cosine(AIR_IMPULSE_ORDER, lobe);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        for (int n = 0; n <= l; n++) {
            if (l > 1) {
                const double up = n > 0 ? power[l - 1][n - 1] : 0.0;
                power[l][n] = ((2 * l - 1) * up - (l - 1) * power[l - 2][n]) / l;
            }
            sum[n] += scale * lobe[l] * zh[l] * power[l][n];
        }
    }
    for (int i = 0; i < CLAMPED_BANDS; i++) {
        out[i] = (float)sum[clamped_band(i)];
    }
}

/* The sum of n_l A_l c_lm y_lm, bands 0..4, in powers of z and x, with y^2 = 1 - x^2 - z^2. */
static void area_entry(const double *sh, double scale, float *out)
{
    double lobe[5], c[15], e[AREA_POWERS] = {0.0};
    air_zh_clamped_cosine(5, lobe);
    for (int l = 0; l < 5; l++) {
        for (int m = 0; m <= l; m++) {
            c[l * (l + 1) / 2 + m] = scale * air_zh_scale(l) * lobe[l] * sh[l * (l + 1) / 2 + m];
        }
    }
    const double k1 = sqrt(3.0 / (4.0 * AIR_PI)), k20 = sqrt(5.0 / (16.0 * AIR_PI));
    const double k21 = sqrt(15.0 / (4.0 * AIR_PI)), k40 = 3.0 / 16.0 / sqrt(AIR_PI);
    const double k41 = 0.75 * sqrt(2.5 / AIR_PI), k42 = 0.375 * sqrt(5.0 / AIR_PI);
    const double k43 = 0.75 * sqrt(17.5 / AIR_PI), k44 = 3.0 / 16.0 * sqrt(35.0 / AIR_PI);
    const double c22 = 0.5 * k21 * c[5], c40 = k40 * c[10], c41 = k41 * c[11], c42 = k42 * c[12];
    const double c43 = k43 * c[13], c44 = k44 * c[14];
    e[0] = c[0] / sqrt(4.0 * AIR_PI) - k20 * c[3] - c22 + 3.0 * c40 + c42 + c44;
    e[1] = k1 * c[1];
    e[2] = k1 * c[2];
    e[3] = 3.0 * k20 * c[3] + c22 - 30.0 * c40 - 8.0 * c42 - 2.0 * c44;
    e[4] = k21 * c[4] - 3.0 * c41 - 3.0 * c43;
    e[5] = 2.0 * c22 - 2.0 * c42 - 8.0 * c44;
    e[6] = 35.0 * c40 + 7.0 * c42 + c44;
    e[7] = 7.0 * c41 + 3.0 * c43;
    e[8] = 14.0 * c42 + 8.0 * c44;
    e[9] = 4.0 * c43;
    e[10] = 8.0 * c44;
    for (int i = 0; i < AREA_POWERS; i++) {
        out[i] = (float)e[i];
    }
}

typedef struct preparing {
    const air_impulse_tables *tables;
    air_impulse_medium medium;
    air_impulse_response *response;
    response_channel *channel;
} preparing;

static void prepare_bin(void *user, size_t bin, size_t worker)
{
    const preparing *const self = user;
    const air_impulse_response *const r = self->response;
    const double rho = impulse_bin_tau(r->bins, bin), sigma = self->channel->sigma;
    const double scale =
        exp(rho) * (r->emitter == AIR_IMPULSE_DIRECTIONAL ? 1.0 : rho / (sigma * sigma));
    double coefficients[AIR_IMPULSE_SH_COUNT];
    (void)worker;
    if (r->emitter != AIR_IMPULSE_AREA) {
        air_impulse_zonal(self->tables, r->emitter, &self->medium, 1, self->medium.bounces,
                          rho / sigma, coefficients);
        zonal_entry(coefficients, scale, self->channel->entries + bin * ZONAL_POWERS);
        return;
    }
    for (size_t angle = 0; angle < r->angles; angle++) {
        const double cos_s = cos(impulse_angle(r->angles, angle));
        (void)air_impulse_mirrored(self->tables, &self->medium, 1, self->medium.bounces,
                                   rho / sigma, cos_s, coefficients);
        area_entry(coefficients, scale,
                   self->channel->entries + (angle * r->bins + bin) * AREA_POWERS);
    }
}

/* The residual rule's excess is kept apart: it is a direction's, not bands'. */
static void prepare_channel(const air_impulse_tables *tables, const air_impulse_medium *medium,
                            air_impulse_response *response, response_channel *channel)
{
    const impulse_sum sum = impulse_sum_of(&tables->params, medium, 1, medium->bounces);
    preparing job = {.tables = tables, .medium = *medium, .response = response, .channel = channel};
    const double slower = sum.last > 1 ? double_min(sum.sigma_t, sum.reduced_sigma_t) : sum.sigma_t;
    channel->sigma = medium->sigma_s > 0.0 ? (float)slower : 0.0f;
    if (!(channel->sigma > 0.0f)) {
        return;
    }
    if (sum.residual) {
        channel->reduced = (float)sum.reduced_sigma_t;
        channel->whole = (float)medium->sigma_t;
        job.medium = (air_impulse_medium){
            .sigma_s = sum.albedo * sum.sigma_t, .sigma_t = sum.sigma_t, .bounces = sum.last};
    }
    air_parallel_for(response->context, response->bins, prepare_bin, &job);
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

air_status air_impulse_response_create(air_context *context, const air_impulse_tables *tables,
                                       air_impulse_emitter emitter, const air_impulse_medium *media,
                                       size_t channels, air_impulse_response **out)
{
    *out = NULL;
    bool good = channels >= 1 && channels <= AIR_IMPULSE_CHANNELS_MAX &&
                (unsigned)emitter < AIR_IMPULSE_EMITTERS;
    for (size_t i = 0; i < channels && good; i++) {
        good = is_medium(&media[i]);
    }
    if (!good) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "impulse response: expected 1 to 3 media with 0 <= sigma_s <= sigma_t, |g| "
                        "< 1 and a bounce at least");
    }
    air_impulse_response *const self = air_allocate(context, 1, sizeof *self);
    if (self == NULL) {
        return air_fail_memory(context, "impulse response");
    }
    self->context = context;
    self->emitter = emitter;
    self->batch = batch_of(context);
    self->bins = tables->params.bins;
    self->angles = tables->angles;
    self->first = (float)cbrt(IMPULSE_TAU_LEAST / IMPULSE_TAU_GREATEST);
    self->scale = (float)(self->bins - 1) / (1.0f - self->first);
    self->quarter = (float)(self->angles - 1) / 3.0f;
    self->angle_scale = self->quarter * 2.0f / AIR_PI_F;
    const size_t count = self->bins * (emitter == AIR_IMPULSE_AREA ? self->angles * AREA_POWERS
                                                                   : (size_t)ZONAL_POWERS);
    for (; self->channel_count < channels; self->channel_count++) {
        response_channel *const channel = &self->channels[self->channel_count];
        channel->entries = air_allocate(context, count, sizeof(float));
        if (channel->entries == NULL) {
            air_impulse_response_destroy(self);
            return air_fail_memory(context, "impulse response");
        }
        prepare_channel(tables, &media[self->channel_count], self, channel);
    }
    *out = self;
    return AIR_OK;
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

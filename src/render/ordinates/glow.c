/* glow.c: see glow.h. */
#include "render/ordinates/glow.h"

#include <math.h>
#include <string.h>

#include "core/harmonics.h"
#include "core/warp.h"

enum { CHANNELS = 4, CHUNK = 256, SEED = 0x6f726467 };

typedef struct glowing {
    const ord_glow *glow;
    const double *sums; /* of the cells' powers up to and with each */
    double total;
    ord_photons *photons;
} glowing;

/* What of a moment of band l a cell scatters, per metre: sigma_s times the means of P_l, less the
 * peak. */
static float scattered_share(const ord_glow *glow, size_t cell, size_t channel, int l)
{
    const ord_domain *const d = glow->space->domain;
    const size_t i = channel * d->cells + cell, at = cell * CHANNELS + channel;
    const float peak = glow->true_extinction[at] - glow->space->extinction[at];
    const double mean = l == 0                   ? 1.0
                        : glow->phase->g != NULL ? pow((double)glow->phase->g[i], l)
                                                 : glow->phase->legendre[l - 1];
    return d->sigma_s[i] * (float)mean - peak;
}

/* Of a cubic metre, of three channels. */
static void cell_powers(const ord_glow *glow, size_t cell, double out[3])
{
    const float *const at = glow->moments + cell * (size_t)(glow->bands * glow->bands) * CHANNELS;
    for (size_t c = 0; c < 3; c++) {
        out[c] = (double)(float_max(at[c], 0.0f) * scattered_share(glow, cell, c, 0)) *
                 sqrt(4.0 * AIR_PI);
    }
}

static double cell_power(const ord_glow *glow, size_t cell)
{
    double powers[3];
    cell_powers(glow, cell, powers);
    return powers[0] + powers[1] + powers[2];
}

/* Power per volume and solid angle that a cell scatters along a direction. */
static air_vec3 scattered_along(const ord_glow *glow, size_t cell, air_vec3 dir)
{
    const float *const at = glow->moments + cell * (size_t)(glow->bands * glow->bands) * CHANNELS;
    const double unit[3] = {(double)dir.x, (double)dir.y, (double)dir.z};
    double y[AIR_SH_COUNT_MAX];
    float sum[3] = {0.0f, 0.0f, 0.0f};
    air_sh_evaluate(glow->bands, unit, y);
    for (int l = 0, m = 0; l < glow->bands; l++) {
        float share[3];
        for (size_t c = 0; c < 3; c++) {
            share[c] = scattered_share(glow, cell, c, l);
        }
        for (; m < (l + 1) * (l + 1); m++) {
            for (size_t c = 0; c < 3; c++) {
                sum[c] += share[c] * (float)y[m] * at[(size_t)m * CHANNELS + c];
            }
        }
    }
    return vec3(float_max(sum[0], 0.0f), float_max(sum[1], 0.0f), float_max(sum[2], 0.0f));
}

static size_t find_cell(const glowing *self, double sum)
{
    size_t low = 0, high = self->glow->space->domain->cells - 1;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (self->sums[middle] > sum) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

static void shoot_chunk(void *user, size_t chunk, size_t worker)
{
    const glowing *const self = user;
    const ord_domain *const d = self->glow->space->domain;
    const double volume = (double)d->cell_m * (double)d->cell_m * (double)d->cell_m;
    const size_t count = self->photons->count, begin = chunk * CHUNK;
    (void)worker;
    for (size_t i = begin; i < begin + CHUNK && i < count; i++) {
        ord_photon *const out = &self->photons->items[i];
        const air_sampler sampler =
            air_sampler_make(self->glow->space->path->sobol, SEED, (uint32_t)i);
        const air_f32x4 u = air_sampler_get(&sampler, 0), v = air_sampler_get(&sampler, 1);
        const double place = ((double)i + (double)v[1]) / (double)count * self->total;
        const size_t cell = find_cell(self, place);
        size_t at[3];
        ord_domain_cell(d, cell, at);
        const air_vec3 local = vec3((float)(ptrdiff_t)at[0] + u[2], (float)(ptrdiff_t)at[1] + u[3],
                                    (float)(ptrdiff_t)at[2] + v[0]);
        const double share = cell_power(self->glow, cell) / self->total;
        out->position = ord_domain_world(d, vec3_scale(local, d->cell_m));
        out->dir = sample_sphere(u[0], u[1]);
        if (share > 0.0) {
            const double scale = 4.0 * AIR_PI * volume / (share * (double)count);
            out->flux = vec3_scale(scattered_along(self->glow, cell, out->dir), (float)scale);
        }
    }
}

air_status ord_photons_glow(const ord_glow *glow, ord_photons *out)
{
    const ord_domain *const d = glow->space->domain;
    air_context *const context = d->context;
    glowing self = {.glow = glow, .photons = out};
    double *const sums = air_allocate(context, d->cells, sizeof *sums);
    if (sums == NULL) {
        return air_fail_memory(context, "ordinates: light of media");
    }
    air_status status = ord_photons_create(context, ORD_PHOTONS, ORD_ROUNDS, out);
    for (size_t i = 0; i < d->cells; i++) {
        self.total += cell_power(glow, i);
        sums[i] = self.total;
    }
    if (status == AIR_OK && self.total > 0.0) {
        self.sums = sums;
        air_parallel_for(context, (out->count + CHUNK - 1) / CHUNK, shoot_chunk, &self);
        ord_photons_follow(glow->space, ORD_ROUNDS, true, out);
    }
    air_free(context, sums);
    return status;
}

void ord_glow_power(const ord_glow *glow, double out[3])
{
    const ord_domain *const d = glow->space->domain;
    const double volume = (double)d->cell_m * (double)d->cell_m * (double)d->cell_m;
    out[0] = out[1] = out[2] = 0.0;
    for (size_t i = 0; i < d->cells; i++) {
        double powers[3];
        cell_powers(glow, i, powers);
        for (int c = 0; c < 3; c++) {
            out[c] += powers[c] * volume;
        }
    }
}

void ord_glow_factors(const double first[3], const double both[3], float out[3])
{
    for (int c = 0; c < 3; c++) {
        const double ratio = first[c] > 0.0 ? both[c] / first[c] - 1.0 : 0.0;
        out[c] = (float)(1.0 / (1.0 - fmin(fmax(ratio, 0.0), 0.9)));
    }
}

void ord_glow_extend(const float *before, const float factors[3], size_t fours, float *after)
{
    for (size_t i = 0; i < fours * CHANNELS; i++) {
        const size_t c = i % CHANNELS;
        after[i] = c < 3 ? before[i] + factors[c] * (after[i] - before[i]) : after[i];
    }
}

void ord_earlier_finish(const air_with_ordinates *with, ord_earlier *earlier)
{
    for (size_t m = 0; earlier->shown != NULL && m < with->medium_count; m++) {
        air_free(with->context, earlier->shown[m]);
    }
    air_free(with->context, earlier->shown);
    air_free(with->context, earlier->moments);
    air_free(with->context, earlier->all);
}

air_status ord_earlier_keep(const air_with_ordinates *with, const air_dom *dom, size_t harmonics,
                            ord_earlier *out)
{
    air_context *const context = with->context;
    const size_t count = with->domain.cells * CHANNELS;
    memset(out, 0, sizeof *out);
    out->fours = with->domain.cells * harmonics;
    out->moments = air_allocate(context, out->fours * CHANNELS, sizeof *out->moments);
    out->all = air_allocate(context, out->fours * CHANNELS, sizeof *out->all);
    out->shown = air_allocate(context, with->medium_count, sizeof *out->shown);
    bool made = out->moments != NULL && out->all != NULL && out->shown != NULL;
    for (size_t m = 0; made && m < with->medium_count; m++) {
        const float *const light = with->media[m].light;
        if (light != NULL) {
            out->shown[m] = air_allocate(context, count, sizeof *light);
            made = out->shown[m] != NULL;
        }
        if (made && light != NULL) {
            memcpy(out->shown[m], light, count * sizeof *light);
        }
    }
    if (!made) {
        return air_fail_memory(context, "ordinates: light of surfaces");
    }
    air_dom_moments(dom, out->moments);
    return AIR_OK;
}

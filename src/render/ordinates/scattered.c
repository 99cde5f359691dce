/* scattered.c: light that is scattered on, by the solver, and what the camera sees of it.
 */
#include "airlight/ordinates_dom.h"
#include "core/phase.h"
#include "render/ordinates/glow.h"
#include "render/ordinates/patches.h"
#include "render/ordinates/solving.h"
#include "scene/fingerprint.h"

static void show_slab(void *user, size_t k, size_t worker)
{
    ord_solving *const self = user;
    (void)worker;
    air_seen_moments(self->with->context, &self->box, self->dom.bands, self->moments, self->factors,
                     k, k + 1, self->with->media[self->medium].light);
}

/* Unscattered light that came by the faces is shown as beams, with the whole phase function. */
static void take_through(const ord_solving *self, float *moments)
{
    const size_t count = self->domain->cells * (size_t)(self->dom.bands * self->dom.bands);
    for (size_t i = 0; self->through != NULL && i < count * ORD_CHANNELS; i++) {
        moments[i] -= self->through[i];
    }
}

/* Adds what the media scatter of light that was scattered before. */
static void show_scattered(ord_solving *self)
{
    for (self->medium = 0; self->medium < self->with->medium_count; self->medium++) {
        const air_phase phase = self->with->snapshot->media.media[self->medium].phase;
        const ord_medium *const medium = &self->with->media[self->medium];
        if (medium->light != NULL) {
            for (int l = 0; l < self->dom.bands; l++) {
                self->factors[l] = phase_legendre(phase, l) - (double)medium->peak;
            }
            air_parallel_for(self->with->context, self->domain->size[2], show_slab, self);
        }
    }
}

/* Power that is scattered out of unscattered light: what all further light is in proportion to. */
static void first_scattered(const ord_solving *self, double out[3])
{
    const size_t numbers = (size_t)(self->dom.bands * self->dom.bands) * ORD_CHANNELS;
    for (size_t c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (size_t cell = 0; cell < self->domain->cells; cell++) {
            const size_t at = cell * numbers + c;
            const float fluence =
                self->moments[at] + (self->through != NULL ? self->through[at] : 0.0f);
            out[c] +=
                (double)self->domain->sigma_s[c * self->domain->cells + cell] * (double)fluence;
        }
    }
}

/* Lets the solver begin from scattered light of the picture before. What comes through unscattered
 * is known anew. */
static air_status begin_from(const ord_solving *self, float *light, air_dom *dom)
{
    const size_t numbers = (size_t)(self->dom.bands * self->dom.bands) * ORD_CHANNELS;
    for (size_t i = 0; i < self->domain->cells * numbers; i++) {
        light[i] += self->through != NULL ? self->through[i] : 0.0f;
        if (i % numbers < 3) { /* differences of nearly the same may be less than 0 */
            light[i] = float_max(light[i], 0.0f);
        }
    }
    return air_dom_set_moments(dom, light);
}

/* Of all that the solver is given. */
static uint64_t problem_key(const ord_solving *self, const air_dom_solve_params *params)
{
    const ord_domain *const d = self->domain;
    const uint32_t numbers[] = {(uint32_t)self->dom.bands,         (uint32_t)self->dom.polar,
                                (uint32_t)self->dom.azimuths,      (uint32_t)self->dom.delta_m,
                                (uint32_t)(self->phase.g != NULL), params->sweeps};
    const size_t plane = 3 * d->cells * sizeof(float);
    const size_t moments = d->cells * (size_t)(self->dom.bands * self->dom.bands) * ORD_CHANNELS;
    uint64_t key = air_fingerprint_add(0, numbers, sizeof numbers);
    key = air_fingerprint_add(key, &params->change, sizeof params->change);
    key = air_fingerprint_add(key, self->phase.legendre, sizeof self->phase.legendre);
    key = air_fingerprint_add(key, d->origin, sizeof d->origin);
    key = air_fingerprint_add(key, d->size, sizeof d->size);
    key = air_fingerprint_add(key, &d->cell_m, sizeof d->cell_m);
    key = air_fingerprint_add(key, d->sigma_s, plane);
    key = air_fingerprint_add(key, d->sigma_a, plane);
    key = air_fingerprint_add(key, d->g, plane);
    key = air_fingerprint_add(key, self->moments, moments * sizeof(float));
    return self->through != NULL ? air_fingerprint_add(key, self->through, moments * sizeof(float))
                                 : key;
}

/* begin: words on what it begins from. */
static air_status solve(const ord_solving *self, const air_dom_solve_params *params,
                        const char *begin, air_dom *dom)
{
    air_dom_report report;
    air_status status = air_dom_set_light(dom, self->moments);
    status = status == AIR_OK ? air_dom_solve(dom, params, &report) : status;
    if (status == AIR_OK) {
        air_inform(self->with->context, "ordinates: %u sweeps, change %.2g%s", report.sweeps,
                   report.change, begin);
    }
    return status;
}

/* Solves what the picture before did not, from where it ended, into light. */
static air_status solve_next(ord_solving *self, const air_dom_solve_params *params, air_dom *dom,
                             uint64_t key, float *light)
{
    double first[3];
    first_scattered(self, first);
    const bool warm = ord_past_light_at(self->with->past, self->domain, &self->dom, first, light);
    air_status status = warm ? begin_from(self, light, dom) : AIR_OK;
    status = status == AIR_OK
                 ? solve(self, params, warm ? ", begun from the picture before" : "", dom)
                 : status;
    if (status == AIR_OK) {
        air_dom_moments(dom, light);
        take_through(self, light);
        ord_past_keep_light(self->with->past, self->domain, &self->dom, first, key, light);
    }
    return status;
}

/* Begins where the picture before ended, and keeps the light for the next one. Light that solves
 * this picture stays to the bit: one more sweep would make it better, and still media flicker. */
static air_status solve_on(ord_solving *self, const air_dom_solve_params *params, air_dom *dom)
{
    air_context *const context = self->with->context;
    const size_t bands = (size_t)self->dom.bands;
    const uint64_t key = problem_key(self, params);
    float *const light =
        air_allocate(context, self->domain->cells * bands * bands * ORD_CHANNELS, sizeof *light);
    if (light == NULL) {
        return air_fail_memory(context, "ordinates: light of the picture before");
    }
    const bool solved = ord_past_solution(self->with->past, key, light);
    const air_status status =
        solved ? begin_from(self, light, dom) : solve_next(self, params, dom, key, light);
    if (status == AIR_OK && solved) {
        air_inform(context, "ordinates: 0 sweeps, begun from the picture before");
    }
    if (status != AIR_OK || solved) {
        air_free(context, light);
    }
    return status;
}

static ord_glow glow_of(const ord_solving *self, const ord_space *space, const air_dom *dom,
                        ord_earlier *e)
{
    air_dom_moments(dom, e->all);
    for (size_t i = 0; i < e->fours * ORD_CHANNELS; i++) {
        e->all[i] += self->moments[i];
    }
    return (ord_glow){space, self->extinction[1], &self->phase, self->dom.bands, e->all};
}

/* Surfaces send back light that the media scatter to them, too: as a first solution has it. What
 * that adds is made as large as all further times would. Moments become those of scattered light.
 */
static air_status add_glow(ord_solving *self, const air_dom_solve_params *params, air_dom *dom)
{
    const ord_space space = {self->path, self->domain, self->extinction[0]};
    const size_t first = self->sources.count;
    ord_photons photons = {.context = NULL};
    const size_t bands = (size_t)self->dom.bands;
    ord_earlier e;
    air_status status = ord_earlier_keep(self->with, dom, bands * bands, &e);
    if (status == AIR_OK) {
        const ord_glow glow = glow_of(self, &space, dom, &e);
        ord_glow_power(&glow, e.power);
        status = ord_photons_glow(&glow, &photons);
    }
    if (status == AIR_OK) {
        const size_t patches = self->with->settings->patches;
        status = ord_patches_choose(&space, &photons, patches, &self->sources);
    }
    ord_photons_finish(&photons);
    status = status == AIR_OK
                 ? ord_take_sources(self, first, self->sources.count, self->sources.count)
                 : status;
    status = status == AIR_OK ? solve(self, params, ", with light that surfaces send back", dom)
                              : status;
    if (status == AIR_OK) {
        double power[3];
        float factors[3];
        const ord_glow glow = glow_of(self, &space, dom, &e);
        ord_glow_power(&glow, power);
        ord_glow_factors(e.power, power, factors);
        air_dom_moments(dom, self->moments);
        ord_glow_extend(e.moments, factors, e.fours, self->moments);
        for (size_t m = 0; m < self->with->medium_count; m++) {
            if (e.shown[m] != NULL) {
                ord_glow_extend(e.shown[m], factors, self->domain->cells,
                                self->with->media[m].light);
            }
        }
    }
    ord_earlier_finish(self->with, &e);
    return status;
}

static air_status set_dom(ord_solving *self, air_dom *dom)
{
    const ord_domain *const d = self->domain;
    const air_status status = air_dom_set_medium(dom, d->sigma_s, d->sigma_a, &self->phase);
    return status == AIR_OK && self->inflow ? ord_inflow_set(&self->sources, &self->dom, dom)
                                            : status;
}

air_status ord_scatter(ord_solving *self, uint32_t max_depth)
{
    const air_ordinates_settings *const settings = self->with->settings;
    const uint32_t events = max_depth - 1;          /* beyond the first */
    const bool counted = events < settings->sweeps; /* sweeps are events */
    const bool surfaces =
        self->with->snapshot->accelerator != NULL && max_depth > ORD_SURFACE_EVENTS;
    air_dom *dom = NULL;
    air_dom_solve_params params;
    air_dom_solve_params_default(&params);
    params.sweeps = counted ? events : settings->sweeps;
    params.change = settings->change;
    params.depth = counted ? 0 : params.depth;
    air_status status = air_dom_create(self->with->context, &self->dom, &dom);
    status = status == AIR_OK ? set_dom(self, dom) : status;
    if (status == AIR_OK) {
        const bool goes_on = self->with->past != NULL && !counted;
        status = goes_on ? solve_on(self, &params, dom) : solve(self, &params, "", dom);
    }
    if (status == AIR_OK && surfaces) {
        params.cold = counted;
        status = add_glow(self, &params, dom);
    } else if (status == AIR_OK) {
        air_dom_moments(dom, self->moments);
    }
    if (status == AIR_OK) {
        take_through(self, self->moments);
        show_scattered(self);
    }
    air_dom_destroy(dom);
    return status;
}

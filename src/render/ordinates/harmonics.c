/* harmonics.c: light in harmonics: what lost its direction in the grids, and all of it
 * where nothing but harmonics is asked for. */
#include <math.h>
#include <string.h>

#include "airlight/ordinates_dom.h"
#include "core/phase.h"
#include "render/ordinates/grids.h"

enum { CHANNELS = 4 };

/* A solver of the domain's cells, and its moments. */
typedef struct solved {
    air_dom_params params;
    air_dom *dom;
    float *light, *moments;
    size_t numbers;
} solved;

static air_status solved_make(const ord_carrying *carrying, solved *out)
{
    const ord_domain *const d = carrying->domain;
    air_context *const context = carrying->with->context;
    for (int axis = 0; axis < 3; axis++) {
        out->params.size[axis] = d->size[axis];
        out->params.cell_m[axis] = d->cell_m;
    }
    out->numbers = d->cells * (size_t)(out->params.bands * out->params.bands) * CHANNELS;
    out->light = air_allocate(context, out->numbers, sizeof *out->light);
    out->moments = air_allocate(context, out->numbers, sizeof *out->moments);
    air_status status = out->light != NULL && out->moments != NULL
                            ? air_dom_create(context, &out->params, &out->dom)
                            : air_fail_memory(context, "ordinates: harmonics");
    if (status == AIR_OK) {
        status = air_dom_set_medium(out->dom, d->sigma_s, d->sigma_a, &carrying->phase);
    }
    return status;
}

static void solved_finish(const ord_carrying *carrying, solved *s)
{
    air_dom_destroy(s->dom);
    air_free(carrying->with->context, s->light);
    air_free(carrying->with->context, s->moments);
}

static air_status solve(const ord_carrying *carrying, solved *s)
{
    air_dom_solve_params params;
    air_dom_solve_params_default(&params);
    params.sweeps = carrying->with->settings->sweeps;
    params.change = carrying->with->settings->change;
    air_status status = air_dom_set_light(s->dom, s->light);
    if (status == AIR_OK) {
        status = air_dom_solve(s->dom, &params, NULL);
    }
    if (status == AIR_OK) {
        air_dom_moments(s->dom, s->moments);
    }
    return status;
}

/* Adds what the media scatter of moments; the phase function is that of all of them together. */
static void show(const ord_carrying *carrying, const solved *s, bool light)
{
    const ord_domain *const d = carrying->domain;
    const double peak =
        s->params.delta_m && carrying->phase.g == NULL
            ? air_dom_peak(&s->params, carrying->phase.legendre[s->params.bands - 1])
            : 0.0;
    double factors[AIR_DOM_BANDS_MAX] = {1.0 - peak}, mean = 0.0, sum = 0.0;
    for (size_t i = 0; i < d->cells && carrying->phase.g != NULL; i++) {
        mean += (double)(d->sigma_s[i] * d->g[i]);
        sum += (double)d->sigma_s[i];
    }
    for (int l = 1; l < s->params.bands; l++) {
        const double g = carrying->phase.g != NULL ? pow(sum > 0.0 ? mean / sum : 0.0, l)
                                                   : carrying->phase.legendre[l - 1];
        factors[l] = g - peak;
    }
    air_seen_moments(carrying->with->context, &carrying->box, s->params.bands, s->moments, factors,
                     0, d->size[2], carrying->with->carried);
    if (light) {
        air_seen_moments(carrying->with->context, &carrying->box, s->params.bands, s->light,
                         factors, 0, d->size[2], carrying->with->carried);
    }
}

/* Isotropic emission rho, W/m^3, is what a cell scatters of an even radiance rho / (4 pi sigma_s),
 * whose moment 0 is sqrt(4 pi) times that. */
static void light_of_rest(const ord_carrying *carrying, solved *s)
{
    const ord_domain *const d = carrying->domain;
    const size_t stride = s->numbers / d->cells;
    for (size_t cell = 0; cell < d->cells; cell++) {
        for (size_t c = 0; c < 3; c++) {
            const float scattering = d->sigma_s[c * d->cells + cell];
            const float rest = carrying->rest[cell * CHANNELS + c];
            if (scattering * d->cell_m > 1e-4f) {
                s->light[cell * stride + c] = rest / (sqrtf(4.0f * AIR_PI_F) * scattering);
            }
        }
    }
}

air_status ord_carry_rest(ord_carrying *carrying)
{
    solved s = {.dom = NULL};
    air_dom_params_default(&s.params);
    s.params.delta_m = false; /* it has no beam to leave the peak in */
    air_status status = solved_make(carrying, &s);
    if (status == AIR_OK) {
        light_of_rest(carrying, &s);
        status = solve(carrying, &s);
    }
    if (status == AIR_OK) {
        show(carrying, &s, false);
    }
    solved_finish(carrying, &s);
    return status;
}

/* ---- harmonics alone ---- */

/* The faces by which a beam enters a box: -x, +x, -y, ... */
static uint32_t entry_faces(const double dir[3])
{
    uint32_t faces = 0;
    for (int axis = 0; axis < 3; axis++) {
        faces |= dir[axis] > 1e-6 ? 1u << 2 * axis : dir[axis] < -1e-6 ? 2u << 2 * axis : 0u;
    }
    return faces;
}

/* Suns and skies enter by the faces, windowed; lamps are moments in the cells. */
static air_status add_harmonics(const ord_carrying *carrying, solved *s, float *inflow,
                                uint32_t *faces)
{
    const ord_domain *const d = carrying->domain;
    air_context *const context = carrying->with->context;
    float *const fluence = air_allocate(context, d->cells * CHANNELS, sizeof *fluence);
    void *const scratch = air_allocate(context, ord_source_scratch(d), 1);
    air_status status = fluence != NULL && scratch != NULL
                            ? AIR_OK
                            : air_fail_memory(context, "ordinates: harmonics");
    for (size_t i = 0; i < carrying->sources->count && status == AIR_OK; i++) {
        const ord_source *const source = &carrying->sources->items[i];
        float moments[AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX * CHANNELS];
        double dir[3], power[3];
        if (source->mode != AIR_ORDINATES_MODE_SHDOM) {
            continue;
        }
        if (source->local) {
            ord_source_fluence(d, source, carrying->with->path, carrying->extinction, scratch,
                               fluence);
            const air_seen_beam beam = ord_source_beam(d, source, fluence);
            air_beam_moments(context, &carrying->box, &beam, 1, s->params.bands, 0, d->size[2],
                             s->light);
            continue;
        }
        vec3_store64(dir, source->place);
        *faces |= entry_faces(dir);
        vec3_store64(power, source->power);
        air_dom_hanning_beam(s->params.bands, dir, power, (double)source->lobe, moments);
        for (int m = 0; m < s->params.bands * s->params.bands * CHANNELS; m++) {
            inflow[m] += moments[m];
        }
    }
    air_free(context, fluence);
    air_free(context, scratch);
    return status;
}

air_status ord_carry_harmonics(ord_carrying *carrying)
{
    float inflow[AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX * CHANNELS] = {0.0f};
    solved s = {.dom = NULL};
    uint32_t faces = 0;
    air_dom_params_default(&s.params);
    air_dom_params_shdom(&s.params, carrying->with->rule.bands);
    air_status status = solved_make(carrying, &s);
    if (status == AIR_OK) {
        status = add_harmonics(carrying, &s, inflow, &faces);
    }
    if (status == AIR_OK) {
        status = air_dom_set_inflow(s.dom, inflow, faces);
    }
    if (status == AIR_OK) {
        status = solve(carrying, &s);
    }
    if (status == AIR_OK) {
        show(carrying, &s, true);
    }
    solved_finish(carrying, &s);
    return status;
}

air_status ord_carry(ord_carrying *carrying)
{
    air_context *const context = carrying->with->context;
    const ord_domain *const d = carrying->domain;
    bool grids = false, harmonics = false;
    for (size_t i = 0; i < carrying->sources->count; i++) {
        const ord_source *const source = &carrying->sources->items[i];
        grids = grids || ord_source_is_carried(source);
        harmonics = harmonics || source->mode == AIR_ORDINATES_MODE_SHDOM;
    }
    carrying->grey = memcmp(d->sigma_s, d->sigma_s + d->cells, 2 * d->cells * sizeof(float)) == 0 &&
                     memcmp(d->sigma_a, d->sigma_a + d->cells, 2 * d->cells * sizeof(float)) == 0 &&
                     memcmp(d->g, d->g + d->cells, 2 * d->cells * sizeof(float)) == 0;
    air_status status = AIR_OK;
    if (grids && carrying->with->settings->residuum) {
        carrying->rest = air_allocate(context, d->cells * CHANNELS, sizeof *carrying->rest);
        status = carrying->rest != NULL ? AIR_OK : air_fail_memory(context, "ordinates: grids");
    }
    status = status == AIR_OK && grids ? ord_carry_directions(carrying) : status;
    status = status == AIR_OK && grids ? ord_carry_points(carrying) : status;
    status = status == AIR_OK && carrying->rest != NULL ? ord_carry_rest(carrying) : status;
    status = status == AIR_OK && harmonics ? ord_carry_harmonics(carrying) : status;
    air_free(context, carrying->rest);
    carrying->rest = NULL;
    return status;
}

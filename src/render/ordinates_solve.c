/* ordinates_solve.c: the light in the cells, by discrete ordinates, and what the camera sees of it.
 */
#include <math.h>
#include <string.h>

#include "airlight/ordinates_beam.h"
#include "airlight/ordinates_dom.h"
#include "core/phase.h"
#include "render/ordinates_glow.h"
#include "render/ordinates_grids.h"
#include "render/ordinates_importance.h"
#include "render/ordinates_patches.h"
#include "render/ordinates_state.h"

enum { CHANNELS = 4, BLOCK = ORD_BLOCK };

/* Optical depth of a cell from which on the sky enters by the box's faces. */
#define THICK 0.4

/* All that one solution needs. */
typedef struct solving {
    air_with_ordinates *with;
    const air_path *path;
    const ord_domain *domain;
    air_seen_box box;
    air_dom_params dom;
    air_dom_phase phase;
    ord_source_list sources;
    uint32_t scatter_most; /* events after which light may be scattered once more */
    float *extinction[2];  /* for all light, and the true one; channels and mean of each cell */
    float *view_depth;     /* between each cell and the camera, by the former */
    double peak_ratio;
    float *moments; /* of beams */
    bool inflow;    /* some of the sky enters by the faces: */
    float inflow_moments[AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX * CHANNELS];
    float *through;    /* moments of it, where it was not scattered */
    float *fluence[2]; /* of a block's sources, likewise */
    char *scratch;     /* of a block's sources */
    size_t scratch_size;
    air_seen_beam beams[2][BLOCK];
    size_t begin, count, solved;       /* the block, of which the first are the solver's */
    double factors[AIR_DOM_BANDS_MAX]; /* of the medium under way */
    size_t medium;
} solving;

/* ---- the medium ---- */

/* Do all media that scatter have the same phase function? Then the index of one, else SIZE_MAX. */
static size_t only_phase(const air_media *media)
{
    size_t found = SIZE_MAX;
    for (size_t i = 0; i < media->count; i++) {
        if (vec3_is_zero(media->media[i].sigma_s)) {
            continue;
        }
        if (found != SIZE_MAX) {
            const air_phase a = media->media[found].phase, b = media->media[i].phase;
            if (a.kind != b.kind || a.g != b.g || a.kind == AIR_PHASE_MIXTURE) {
                return SIZE_MAX;
            }
        }
        found = found == SIZE_MAX ? i : found;
    }
    return found;
}

static void set_phase(solving *self)
{
    const air_media *const media = &self->with->snapshot->media;
    const size_t only = only_phase(media);
    self->phase.g = only == SIZE_MAX ? self->domain->g : NULL;
    for (int l = 1; l <= self->dom.bands && only != SIZE_MAX; l++) {
        self->phase.legendre[l - 1] = phase_legendre(media->media[only].phase, l);
    }
}

/* What the solver takes for extinction of unscattered light in a cell. */
static double scaled_extinction(const solving *self, size_t i)
{
    const ord_domain *const d = self->domain;
    const double last = self->phase.g != NULL ? pow((double)self->phase.g[i], self->dom.bands)
                                              : self->phase.legendre[self->dom.bands - 1];
    const bool forward = self->phase.g == NULL || self->phase.g[i] > 0.0f;
    const double peak = forward ? air_dom_peak(&self->dom, last) : 0.0;
    return (double)d->sigma_s[i] * (1.0 - peak) + (double)d->sigma_a[i];
}

static void set_extinction(solving *self)
{
    const ord_domain *const d = self->domain;
    for (size_t cell = 0; cell < d->cells; cell++) {
        for (size_t c = 0; c < 3; c++) {
            const size_t i = c * d->cells + cell;
            self->extinction[0][cell * CHANNELS + c] = (float)scaled_extinction(self, i);
            self->extinction[1][cell * CHANNELS + c] = d->sigma_s[i] + d->sigma_a[i];
        }
        for (int i = 0; i < 2; i++) {
            float *const at = self->extinction[i] + cell * CHANNELS;
            at[3] = (at[0] + at[1] + at[2]) * (1.0f / 3.0f);
        }
    }
}

/* Of all cells: optical depth of events that count as none, over that of the others. */
static double peak_ratio(const solving *self)
{
    double all = 0.0, scaled = 0.0;
    for (size_t cell = 0; cell < self->domain->cells; cell++) {
        all += (double)self->extinction[1][cell * CHANNELS + 3];
        scaled += (double)self->extinction[0][cell * CHANNELS + 3];
    }
    return scaled > 0.0 ? all / scaled - 1.0 : 0.0;
}

/* Depths between cells and camera. */
static void look_back_slab(void *user, size_t k, size_t worker)
{
    solving *const self = user;
    const ord_domain *const d = self->domain;
    const size_t slab = d->size[0] * d->size[1];
    const air_beam_box box = {{d->size[0], d->size[1], d->size[2]},
                              {d->cell_m, d->cell_m, d->cell_m},
                              self->extinction[0]};
    const float far = 4.0f * d->cell_m * (float)(ptrdiff_t)(d->size[0] + d->size[1] + d->size[2]);
    (void)worker;
    for (size_t cell = k * slab; cell < (k + 1) * slab; cell++) {
        float center[3], observer[3], depth[CHANNELS];
        size_t at[3];
        ord_domain_cell(d, cell, at);
        for (int axis = 0; axis < 3; axis++) {
            center[axis] = ((float)(ptrdiff_t)at[axis] + 0.5f) * d->cell_m;
            observer[axis] = self->box.observer[axis];
            if (self->box.distant) {
                observer[axis] = center[axis] + far * observer[axis];
            }
        }
        air_beam_depth(&box, center, observer, depth);
        self->view_depth[cell] = depth[3];
    }
}

/* ---- sources, a block at a time ---- */

static void fill_source(void *user, size_t index, size_t worker)
{
    solving *const self = user;
    const ord_source *const source = &self->sources.items[self->begin + index];
    (void)worker;
    for (int i = 0; i < 2; i++) {
        if (self->fluence[i] != NULL && (i == 0 ? index < self->solved : source->events == 0)) {
            float *const out = self->fluence[i] + index * self->domain->cells * CHANNELS;
            ord_source_fluence(self->domain, source, self->path, self->extinction[i],
                               self->scratch + index * self->scratch_size, out);
            self->beams[i][index] = ord_source_beam(self->domain, source, out);
        }
    }
}

static void take_slab(void *user, size_t k, size_t worker)
{
    solving *const self = user;
    (void)worker;
    for (size_t i = 0; self->moments != NULL && i < self->solved; i++) {
        const ord_source *const source = &self->sources.items[self->begin + i];
        if (source->events < self->scatter_most) {
            air_beam_moments(self->with->context, &self->box, &self->beams[0][i], 1,
                             self->dom.bands, k, k + 1,
                             source->inflow ? self->through : self->moments);
        }
    }
    for (size_t m = 0; m < self->with->medium_count; m++) {
        const ord_medium *const medium = &self->with->media[m];
        const air_phase phase = self->with->snapshot->media.media[m].phase;
        if (medium->light != NULL) {
            const air_seen_peak peak = {(double)medium->peak, self->peak_ratio, self->view_depth};
            air_seen_beams(self->with->context, &self->box, self->beams[0], self->solved, phase,
                           &peak, k, k + 1, medium->light);
        }
        for (size_t i = 0; medium->first != NULL && i < self->count; i++) {
            if (self->sources.items[self->begin + i].events == 0) {
                air_seen_beams(self->with->context, &self->box, &self->beams[1][i], 1, phase, NULL,
                               k, k + 1, medium->first);
            }
        }
    }
}

/* Brings the sources of mode dom to the front, in their order; returns their number. */
static size_t solved_first(ord_source_list *sources)
{
    size_t count = 0;
    for (size_t i = 0; i < sources->count; i++) {
        const ord_source source = sources->items[i];
        if (source.mode == AIR_ORDINATES_MODE_DOM) {
            memmove(&sources->items[count + 1], &sources->items[count],
                    (i - count) * sizeof source);
            sources->items[count++] = source;
        }
    }
    return count;
}

/* Sources [first, end), of which those below `solved` are the solver's. */
static air_status take_sources(solving *self, size_t first, size_t end, size_t solved)
{
    air_context *const context = self->with->context;
    for (self->begin = first; self->begin < end; self->begin += BLOCK) {
        const size_t rest = end - self->begin,
                     own = solved > self->begin ? solved - self->begin : 0;
        self->count = rest < BLOCK ? rest : BLOCK;
        self->solved = own < self->count ? own : self->count;
        air_parallel_for(context, self->count, fill_source, self);
        air_parallel_for(context, self->domain->size[2], take_slab, self);
        if (!air_progress(context, 0.0, "light in cells")) {
            return AIR_ERROR_INTERRUPTED;
        }
    }
    return AIR_OK;
}

/* ---- scattered light ---- */

static void show_slab(void *user, size_t k, size_t worker)
{
    solving *const self = user;
    (void)worker;
    air_seen_moments(self->with->context, &self->box, self->dom.bands, self->moments, self->factors,
                     k, k + 1, self->with->media[self->medium].light);
}

/* Unscattered light that came by the faces is shown as beams, with the whole phase function. */
static void take_through(solving *self)
{
    const size_t count = self->domain->cells * (size_t)(self->dom.bands * self->dom.bands);
    for (size_t i = 0; self->through != NULL && i < count * CHANNELS; i++) {
        self->moments[i] -= self->through[i];
    }
}

/* Adds what the media scatter of light that was scattered before. */
static void show_scattered(solving *self)
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

static air_status solve(const solving *self, const air_dom_solve_params *params, air_dom *dom)
{
    const air_status status = air_dom_set_light(dom, self->moments);
    return status == AIR_OK ? air_dom_solve(dom, params, NULL) : status;
}

static ord_glow glow_of(const solving *self, const ord_space *space, const air_dom *dom,
                        ord_earlier *e)
{
    air_dom_moments(dom, e->all);
    for (size_t i = 0; i < e->fours * CHANNELS; i++) {
        e->all[i] += self->moments[i];
    }
    return (ord_glow){space, self->extinction[1], &self->phase, self->dom.bands, e->all};
}

/* Surfaces send back light that the media scatter to them, too: as a first solution has it. What
 * that adds is made as large as all further times would. Moments become those of scattered light.
 */
static air_status add_glow(solving *self, const air_dom_solve_params *params, air_dom *dom)
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
    status = status == AIR_OK ? take_sources(self, first, self->sources.count, self->sources.count)
                              : status;
    status = status == AIR_OK ? solve(self, params, dom) : status;
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

static air_status scatter(solving *self, uint32_t max_depth)
{
    const air_ordinates_settings *const settings = self->with->settings;
    const uint32_t events = max_depth - 1; /* beyond the first */
    air_dom *dom = NULL;
    air_dom_solve_params params;
    air_dom_solve_params_default(&params);
    params.sweeps = events < settings->sweeps ? events : settings->sweeps;
    params.change = settings->change;
    params.depth = events < settings->sweeps ? 0 : params.depth;
    air_status status = air_dom_create(self->with->context, &self->dom, &dom);
    if (status == AIR_OK) {
        status =
            air_dom_set_medium(dom, self->domain->sigma_s, self->domain->sigma_a, &self->phase);
    }
    if (status == AIR_OK && self->inflow) {
        status = ord_inflow_set(&self->sources, &self->dom, dom);
    }
    if (status == AIR_OK) {
        status = solve(self, &params, dom);
    }
    const bool surfaces =
        self->with->snapshot->accelerator != NULL && max_depth > ORD_SURFACE_EVENTS;
    if (status == AIR_OK && surfaces) {
        params.cold = params.depth == 0; /* sweeps count events */
        status = add_glow(self, &params, dom);
    }
    if (status == AIR_OK && !surfaces) {
        air_dom_moments(dom, self->moments);
    }
    if (status == AIR_OK) {
        take_through(self);
        show_scattered(self);
    }
    air_dom_destroy(dom);
    return status;
}

/* ---- all ---- */

static void set_box(solving *self, const air_camera_view *view)
{
    const ord_domain *const d = self->domain;
    self->box.distant = view->kind != AIR_CAMERA_PERSPECTIVE;
    for (int axis = 0; axis < 3; axis++) {
        self->box.size[axis] = d->size[axis];
        self->box.cell_m[axis] = d->cell_m;
        self->dom.size[axis] = d->size[axis];
        self->dom.cell_m[axis] = d->cell_m;
    }
    const air_vec3 to = self->box.distant ? vec3_neg(view->dir) : ord_domain_local(d, view->origin);
    vec3_store(self->box.observer, to);
}

/* Can the sky enter by the box's faces? Nothing may stand between, sweep n must not stand for n
 * further events, and it must be worth it: in thin cells beams are truer. */
static bool may_flow_in(const solving *self, const air_render_params *params)
{
    const ord_domain *const d = self->domain;
    double most = 0.0;
    for (size_t i = 0; i < 3 * d->cells; i++) {
        most = fmax(most, scaled_extinction(self, i));
    }
    return params->max_depth == UINT32_MAX && self->with->snapshot->accelerator == NULL &&
           most * (double)d->cell_m > THICK;
}

static bool make_arrays(solving *self, bool deep)
{
    air_context *const context = self->with->context;
    const size_t cells = self->domain->cells;
    const size_t bands = (size_t)self->dom.bands;
    const bool wanted[2] = {self->with->all, self->with->single};
    bool made = true;
    self->scratch_size = ord_source_scratch(self->domain);
    self->scratch = air_allocate(context, BLOCK, self->scratch_size);
    for (int i = 0; i < 2; i++) {
        self->extinction[i] = air_allocate(context, cells * CHANNELS, sizeof(float));
        made = made && self->extinction[i] != NULL;
        if (wanted[i]) {
            self->fluence[i] = air_allocate(context, BLOCK * cells * CHANNELS, sizeof(float));
            made = made && self->fluence[i] != NULL;
        }
    }
    if (deep) {
        self->moments = air_allocate(context, cells * bands * bands * CHANNELS, sizeof(float));
        made = made && self->moments != NULL;
    }
    if (self->inflow) {
        self->through = air_allocate(context, cells * bands * bands * CHANNELS, sizeof(float));
        made = made && self->through != NULL;
    }
    self->view_depth = air_allocate(context, cells, sizeof *self->view_depth);
    return made && self->scratch != NULL && self->view_depth != NULL;
}

static void free_arrays(solving *self)
{
    air_context *const context = self->with->context;
    for (int i = 0; i < 2; i++) {
        air_free(context, self->extinction[i]);
        air_free(context, self->fluence[i]);
    }
    air_free(context, self->moments);
    air_free(context, self->through);
    air_free(context, self->view_depth);
    air_free(context, self->scratch);
    ord_sources_finish(&self->sources);
}

static air_status make_media(air_with_ordinates *with, const air_dom_params *dom)
{
    const air_media *const media = &with->snapshot->media;
    with->medium_count = media->count;
    with->media = air_allocate(with->context, media->count, sizeof *with->media);
    bool made = with->media != NULL;
    for (size_t i = 0; made && i < media->count; i++) {
        ord_medium *const m = &with->media[i];
        m->peak = (float)air_dom_peak(dom, phase_legendre(media->media[i].phase, dom->bands));
        if (phase_legendre(media->media[i].phase, 1) < 0.0) {
            m->peak = 0.0f;
        }
        if (vec3_is_zero(media->media[i].sigma_s)) {
            continue;
        }
        if (with->all) {
            m->light = air_allocate(with->context, with->domain.cells * CHANNELS, sizeof(float));
        }
        if (with->single) {
            m->first = air_allocate(with->context, with->domain.cells * CHANNELS, sizeof(float));
        }
        made = (m->light != NULL || !with->all) && (m->first != NULL || !with->single);
    }
    return made ? AIR_OK : air_fail_memory(with->context, "ordinates: media");
}

/* Light of the other modes. */
static air_status carry(solving *self)
{
    air_with_ordinates *const with = self->with;
    ord_carrying carrying = {.with = with,
                             .domain = self->domain,
                             .sources = &self->sources,
                             .box = self->box,
                             .extinction = self->extinction[1],
                             .phase = self->phase};
    bool any = false;
    for (size_t i = 0; i < self->sources.count; i++) {
        any = any || self->sources.items[i].mode != AIR_ORDINATES_MODE_DOM;
    }
    if (!any) {
        return AIR_OK;
    }
    with->carried =
        air_allocate(with->context, self->domain->cells * CHANNELS, sizeof *with->carried);
    return with->carried != NULL ? ord_carry(&carrying)
                                 : air_fail_memory(with->context, "ordinates: grids");
}

/* The sky is blurred by the medium that scatters most. */
static air_status make_sky(air_with_ordinates *with, const air_owner_table *owners)
{
    const air_media *const media = &with->snapshot->media;
    size_t most = 0;
    for (size_t i = 1; i < media->count; i++) {
        const bool more = vec3_max(media->media[i].sigma_s) > vec3_max(media->media[most].sigma_s);
        most = more ? i : most;
    }
    return ord_sky_make(with->snapshot, owners, media->media[most].phase,
                        (double)with->media[most].peak, &with->sky);
}

air_status ord_solve(air_with_ordinates *with, const air_owner_table *owners,
                     const air_camera_view *view, const air_render_params *params)
{
    const air_ordinates_settings *const settings = with->settings;
    float importance[ORD_IMPORTANCE_TEXELS];
    bool steered = false;
    solving self = {.with = with, .path = with->path, .domain = &with->domain};
    const bool deep = with->all && params->max_depth > 1;
    air_dom_params_default(&self.dom);
    self.dom.bands = settings->bands;
    self.dom.polar = settings->polar;
    self.dom.azimuths = settings->azimuths;
    /* Where events are counted, those of the forward peak count too. */
    self.dom.delta_m = params->max_depth > settings->sweeps;
    set_box(&self, view);
    air_status status = make_media(with, &self.dom);
    if (status != AIR_OK) {
        return status;
    }
    set_phase(&self);
    status = with->all ? make_sky(with, owners) : AIR_OK;
    if (status != AIR_OK) {
        return status;
    }
    if (status == AIR_OK && settings->importance && with->snapshot->lights.environment_count > 0) {
        status = ord_importance_make(self.domain, view, params->width, params->height, NULL,
                                     importance, &steered);
    }
    const ord_lighting lighting = {with->path, owners, settings, steered ? importance : NULL};
    status = status == AIR_OK ? ord_sources_make(&lighting, &self.sources) : status;
    if (status == AIR_OK && deep && may_flow_in(&self, params)) {
        self.inflow = ord_inflow_choose(&self.sources);
    }
    if (status == AIR_OK && !make_arrays(&self, deep)) {
        status = air_fail_memory(with->context, "ordinates: light");
    }
    const size_t lights = self.sources.count;
    self.scatter_most = params->max_depth - 1;
    if (status == AIR_OK) {
        set_extinction(&self);
        if (deep) {
            const ord_space space = {with->path, &with->domain, self.extinction[0]};
            status = ord_patches_add(&lighting, &space, params->max_depth, &self.sources);
            for (size_t i = lights; i < self.sources.count && lights > 0; i++) {
                self.sources.items[i].mode = self.sources.items[0].mode;
            }
        }
    }
    if (status == AIR_OK) {
        self.peak_ratio = peak_ratio(&self);
        air_parallel_for(with->context, self.domain->size[2], look_back_slab, &self);
        const size_t solved = solved_first(&self.sources);
        status = take_sources(&self, 0, with->single ? self.sources.count : solved, solved);
    }
    if (status == AIR_OK && deep && self.sources.count > 0 &&
        self.sources.items[0].mode == AIR_ORDINATES_MODE_DOM) {
        status = scatter(&self, params->max_depth);
    }
    if (status == AIR_OK && with->all) {
        status = carry(&self);
    }
    free_arrays(&self);
    return status;
}

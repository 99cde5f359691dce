/* solve.c: the light in the cells, from the lights to what the camera sees of it. */
#include <math.h>
#include <string.h>

#include "core/phase.h"
#include "render/ordinates/grids.h"
#include "render/ordinates/importance.h"
#include "render/ordinates/patches.h"
#include "render/ordinates/solving.h"

/* Optical depths of a cell between which the sky goes over from beams to light that enters by the
 * box's faces. Evenly: the two differ by some 10 % of the light, and media change. */
#define THIN  0.25
#define THICK 0.55

static void set_box(ord_solving *self, const air_camera_view *view)
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

/* How much of the sky may enter by the box's faces? None where something may stand between or sweep
 * n stands for n further events, or where it is not worth it: in thin cells beams are truer. */
static float may_flow_in(const ord_solving *self, const air_render_params *params)
{
    if (params->max_depth != UINT32_MAX || self->with->snapshot->accelerator != NULL) {
        return 0.0f;
    }
    const double share = (ord_solving_thickness(self) - THIN) / (THICK - THIN);
    return (float)fmin(fmax(share, 0.0), 1.0);
}

static bool make_arrays(ord_solving *self, bool deep)
{
    air_context *const context = self->with->context;
    const size_t cells = self->domain->cells;
    const size_t bands = (size_t)self->dom.bands;
    const bool wanted[2] = {self->with->all, self->with->single};
    bool made = true;
    self->scratch_size = ord_source_scratch(self->domain);
    self->scratch = air_allocate(context, ORD_BLOCK, self->scratch_size);
    for (int i = 0; i < 2; i++) {
        self->extinction[i] = air_allocate(context, cells * ORD_CHANNELS, sizeof(float));
        made = made && self->extinction[i] != NULL;
        if (wanted[i]) {
            self->fluence[i] =
                air_allocate(context, ORD_BLOCK * cells * ORD_CHANNELS, sizeof(float));
            made = made && self->fluence[i] != NULL;
        }
    }
    if (deep) {
        self->moments = air_allocate(context, cells * bands * bands * ORD_CHANNELS, sizeof(float));
        made = made && self->moments != NULL;
    }
    if (self->inflow) {
        self->through = air_allocate(context, cells * bands * bands * ORD_CHANNELS, sizeof(float));
        made = made && self->through != NULL;
    }
    self->view_depth = air_allocate(context, cells, sizeof *self->view_depth);
    return made && self->scratch != NULL && self->view_depth != NULL;
}

static void free_arrays(ord_solving *self)
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
            m->light =
                air_allocate(with->context, with->domain.cells * ORD_CHANNELS, sizeof(float));
        }
        if (with->single) {
            m->first =
                air_allocate(with->context, with->domain.cells * ORD_CHANNELS, sizeof(float));
        }
        made = (m->light != NULL || !with->all) && (m->first != NULL || !with->single);
    }
    return made ? AIR_OK : air_fail_memory(with->context, "ordinates: media");
}

/* Light of the other modes. */
static air_status carry(ord_solving *self)
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
        air_allocate(with->context, self->domain->cells * ORD_CHANNELS, sizeof *with->carried);
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
                        (double)with->media[most].peak, with->past, &with->sky);
}

static void set_up(ord_solving *self, const air_camera_view *view, const air_render_params *params)
{
    self->dom = self->with->rule;
    /* Where events are counted, those of the forward peak count too. */
    self->dom.delta_m = params->max_depth > self->with->settings->sweeps;
    self->scatter_most = params->max_depth - 1;
    set_box(self, view);
}

/* The lights, and then, with room and coefficients for all, the patches that they light. */
static air_status make_sources(ord_solving *self, const ord_lighting *lighting,
                               const air_render_params *params, bool deep)
{
    air_status status = ord_sources_make(lighting, &self->sources);
    if (status == AIR_OK && deep) {
        self->inflow = ord_inflow_choose(&self->sources, may_flow_in(self, params));
    }
    if (status == AIR_OK && !make_arrays(self, deep)) {
        status = air_fail_memory(self->with->context, "ordinates: light");
    }
    if (status != AIR_OK) {
        return status;
    }
    const size_t lights = self->sources.count;
    ord_solving_set_medium(self);
    if (deep) {
        const ord_space space = {self->path, self->domain, self->extinction[0]};
        status = ord_patches_add(lighting, &space, params->max_depth, &self->sources);
    }
    for (size_t i = lights; i < self->sources.count && lights > 0; i++) {
        self->sources.items[i].mode = self->sources.items[0].mode;
    }
    return status;
}

static air_status light_cells(ord_solving *self, const air_render_params *params, bool deep)
{
    const bool single = self->with->single;
    const size_t solved = ord_solved_first(&self->sources);
    air_status status = ord_take_sources(self, 0, single ? self->sources.count : solved, solved);
    if (status == AIR_OK && deep && solved > 0) {
        status = ord_scatter(self, params->max_depth);
    }
    return status == AIR_OK && self->with->all ? carry(self) : status;
}

air_status ord_solve(air_with_ordinates *with, const air_owner_table *owners,
                     const air_camera_view *view, const air_render_params *params)
{
    float importance[ORD_IMPORTANCE_TEXELS];
    bool steered = false;
    ord_solving self = {.with = with, .path = with->path, .domain = &with->domain};
    const bool deep = with->all && params->max_depth > 1;
    set_up(&self, view, params);
    air_status status = make_media(with, &self.dom);
    if (status != AIR_OK) {
        return status;
    }
    ord_solving_set_phase(&self);
    status = with->all ? make_sky(with, owners) : AIR_OK;
    if (status == AIR_OK && with->settings->importance &&
        with->snapshot->lights.environment_count > 0) {
        status = ord_importance_make(self.domain, view, params->width, params->height, with->past,
                                     importance, &steered);
    }
    const ord_lighting lighting = {with->path, owners, with->settings, steered ? importance : NULL,
                                   with->past};
    status = status == AIR_OK ? make_sources(&self, &lighting, params, deep) : status;
    status = status == AIR_OK ? light_cells(&self, params, deep) : status;
    if (status == AIR_OK && with->past != NULL) {
        ord_past_end(with->past, &with->domain);
        with->history = with->past->history;
    }
    free_arrays(&self);
    return status;
}

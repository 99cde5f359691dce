/* medium.c: the media as the solver takes them, cell by cell. */
#include <math.h>

#include "airlight/ordinates_beam.h"
#include "core/phase.h"
#include "render/ordinates/solving.h"

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

void ord_solving_set_phase(ord_solving *self)
{
    const air_media *const media = &self->with->snapshot->media;
    const size_t only = only_phase(media);
    self->phase.g = only == SIZE_MAX ? self->domain->g : NULL;
    for (int l = 1; l <= self->dom.bands && only != SIZE_MAX; l++) {
        self->phase.legendre[l - 1] = phase_legendre(media->media[only].phase, l);
    }
}

/* What the solver takes for extinction of unscattered light in a cell. */
static double scaled_extinction(const ord_solving *self, size_t i)
{
    const ord_domain *const d = self->domain;
    const double last = self->phase.g != NULL ? pow((double)self->phase.g[i], self->dom.bands)
                                              : self->phase.legendre[self->dom.bands - 1];
    const bool forward = self->phase.g == NULL || self->phase.g[i] > 0.0f;
    const double peak = forward ? air_dom_peak(&self->dom, last) : 0.0;
    return (double)d->sigma_s[i] * (1.0 - peak) + (double)d->sigma_a[i];
}

static void set_extinction(ord_solving *self)
{
    const ord_domain *const d = self->domain;
    for (size_t cell = 0; cell < d->cells; cell++) {
        for (size_t c = 0; c < 3; c++) {
            const size_t i = c * d->cells + cell;
            self->extinction[0][cell * ORD_CHANNELS + c] = (float)scaled_extinction(self, i);
            self->extinction[1][cell * ORD_CHANNELS + c] = d->sigma_s[i] + d->sigma_a[i];
        }
        for (int i = 0; i < 2; i++) {
            float *const at = self->extinction[i] + cell * ORD_CHANNELS;
            at[3] = (at[0] + at[1] + at[2]) * (1.0f / 3.0f);
        }
    }
}

/* Of all cells: optical depth of events that count as none, over that of the others. */
static double peak_ratio(const ord_solving *self)
{
    double all = 0.0, scaled = 0.0;
    for (size_t cell = 0; cell < self->domain->cells; cell++) {
        all += (double)self->extinction[1][cell * ORD_CHANNELS + 3];
        scaled += (double)self->extinction[0][cell * ORD_CHANNELS + 3];
    }
    return scaled > 0.0 ? all / scaled - 1.0 : 0.0;
}

/* Depths between cells and camera. */
static void look_back_slab(void *user, size_t k, size_t worker)
{
    ord_solving *const self = user;
    const ord_domain *const d = self->domain;
    const size_t slab = d->size[0] * d->size[1];
    const air_beam_box box = {{d->size[0], d->size[1], d->size[2]},
                              {d->cell_m, d->cell_m, d->cell_m},
                              self->extinction[0]};
    const float far = 4.0f * d->cell_m * (float)(ptrdiff_t)(d->size[0] + d->size[1] + d->size[2]);
    (void)worker;
    for (size_t cell = k * slab; cell < (k + 1) * slab; cell++) {
        float center[3], observer[3], depth[ORD_CHANNELS];
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

void ord_solving_set_medium(ord_solving *self)
{
    set_extinction(self);
    self->peak_ratio = peak_ratio(self);
    air_parallel_for(self->with->context, self->domain->size[2], look_back_slab, self);
}

double ord_solving_thickness(const ord_solving *self)
{
    const ord_domain *const d = self->domain;
    double most = 0.0;
    for (size_t i = 0; i < 3 * d->cells; i++) {
        most = fmax(most, scaled_extinction(self, i));
    }
    return most * (double)d->cell_m;
}

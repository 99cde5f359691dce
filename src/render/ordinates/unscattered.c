/* unscattered.c: what reaches the cells of each source without an event, a block of
 * sources at a time. */
#include <string.h>

#include "airlight/ordinates_beam.h"
#include "render/ordinates/solving.h"

static void fill_source(void *user, size_t index, size_t worker)
{
    ord_solving *const self = user;
    const ord_source *const source = &self->sources.items[self->begin + index];
    (void)worker;
    for (int i = 0; i < 2; i++) {
        if (self->fluence[i] != NULL && (i == 0 ? index < self->solved : source->events == 0)) {
            float *const out = self->fluence[i] + index * self->domain->cells * ORD_CHANNELS;
            ord_source_fluence(self->domain, source, self->path, self->extinction[i],
                               self->scratch + index * self->scratch_size, out);
            self->beams[i][index] = ord_source_beam(self->domain, source, out);
        }
    }
}

/* Of a beam of which a share enters by the faces. */
static void add_moments(const ord_solving *self, const air_seen_beam *beam, float inflow, size_t k)
{
    float *const out[2] = {self->moments, self->through};
    const float shares[2] = {1.0f - inflow, inflow};
    for (int i = 0; i < 2; i++) {
        air_seen_beam part = *beam;
        for (size_t c = 0; c < 3; c++) {
            part.power[c] *= shares[i];
        }
        if (shares[i] > 0.0f) {
            air_beam_moments(self->with->context, &self->box, &part, 1, self->dom.bands, k, k + 1,
                             out[i]);
        }
    }
}

static void take_slab(void *user, size_t k, size_t worker)
{
    ord_solving *const self = user;
    (void)worker;
    for (size_t i = 0; self->moments != NULL && i < self->solved; i++) {
        const ord_source *const source = &self->sources.items[self->begin + i];
        if (source->events < self->scatter_most) {
            add_moments(self, &self->beams[0][i], source->inflow, k);
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

size_t ord_solved_first(ord_source_list *sources)
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

air_status ord_take_sources(ord_solving *self, size_t first, size_t end, size_t solved)
{
    air_context *const context = self->with->context;
    for (self->begin = first; self->begin < end; self->begin += ORD_BLOCK) {
        const size_t rest = end - self->begin,
                     own = solved > self->begin ? solved - self->begin : 0;
        self->count = rest < ORD_BLOCK ? rest : ORD_BLOCK;
        self->solved = own < self->count ? own : self->count;
        air_parallel_for(context, self->count, fill_source, self);
        air_parallel_for(context, self->domain->size[2], take_slab, self);
        if (!air_progress(context, 0.0, "light in cells")) {
            return AIR_ERROR_INTERRUPTED;
        }
    }
    return AIR_OK;
}

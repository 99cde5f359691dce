/* grids.c: a grid along the direction of each part of the sky and each sun. */
#include "render/ordinates/grids.h"

#include <math.h>
#include <string.h>

#include "airlight/ordinates.h"

enum { CHANNELS = 4, SLOTS = 16 /* grids at a time */ };

/* One grid, in the frame of its direction: s, t, n are i, j, k. */
typedef struct slot {
    air_frame frame;
    float least[3]; /* of the domain's corners, along s, t, n */
    air_ordinates_cells cells;
    size_t count;
    float *sigma_s[3], *sigma_a[3], *g[3], *cosine, *entry;
    float *seen[3], *energy[3];
    void *block, *scratch;
    size_t scratch_size;
    air_status status;
} slot;

typedef struct directions {
    ord_carrying *carrying;
    const ord_source *sources[SLOTS];
    slot slots[SLOTS];
    size_t count, capacity; /* of this block; cells of a slot at most */
} directions;

/* ---- trilinear ---- */

typedef struct place {
    size_t low[3], high[3];
    float share[3];
} place;

/* Held in the outer half cells. False: beyond the border. */
static bool find_place(const float at[3], const size_t size[3], place *out)
{
    for (int axis = 0; axis < 3; axis++) {
        const float last = (float)(ptrdiff_t)size[axis] - 1.0f;
        if (!(at[axis] >= -0.5f && at[axis] <= last + 0.5f)) {
            return false;
        }
        const float held = float_min(float_max(at[axis], 0.0f), last);
        out->low[axis] = (size_t)held;
        out->high[axis] = out->low[axis] + 1 < size[axis] ? out->low[axis] + 1 : out->low[axis];
        out->share[axis] = held - (float)(ptrdiff_t)out->low[axis];
    }
    return true;
}

static float sample_place(const place *p, const size_t size[3], const float *values, size_t stride)
{
    float sum = 0.0f;
    for (int c = 0; c < 8; c++) {
        const size_t x = (c & 1) != 0 ? p->high[0] : p->low[0];
        const size_t y = (c & 2) != 0 ? p->high[1] : p->low[1];
        const size_t z = (c & 4) != 0 ? p->high[2] : p->low[2];
        const float weight = ((c & 1) != 0 ? p->share[0] : 1.0f - p->share[0]) *
                             ((c & 2) != 0 ? p->share[1] : 1.0f - p->share[1]) *
                             ((c & 4) != 0 ? p->share[2] : 1.0f - p->share[2]);
        sum += weight * values[((z * size[1] + y) * size[0] + x) * stride];
    }
    return sum;
}

float ord_domain_sample(const ord_domain *domain, const float *values, size_t stride,
                        const float local[3])
{
    float at[3];
    place p;
    for (int axis = 0; axis < 3; axis++) {
        at[axis] = local[axis] / domain->cell_m - 0.5f;
    }
    return find_place(at, domain->size, &p) ? sample_place(&p, domain->size, values, stride) : 0.0f;
}

/* ---- one grid ---- */

/* The box about the domain's corners in the frame, `cells` along its longest side. */
static void place_slot(const ord_carrying *carrying, const ord_source *source, slot *s)
{
    const ord_domain *const d = carrying->domain;
    const uint32_t cells = carrying->with->settings->cells;
    float high[3], longest = 0.0f;
    s->frame = frame_from_normal(source->place);
    for (int corner = 0; corner < 8; corner++) {
        const air_vec3 at =
            vec3((corner & 1) != 0 ? d->cell_m * (float)(ptrdiff_t)d->size[0] : 0.0f,
                 (corner & 2) != 0 ? d->cell_m * (float)(ptrdiff_t)d->size[1] : 0.0f,
                 (corner & 4) != 0 ? d->cell_m * (float)(ptrdiff_t)d->size[2] : 0.0f);
        const air_vec3 turned = frame_to_local(&s->frame, at);
        const float along[3] = {turned.x, turned.y, turned.z};
        for (int axis = 0; axis < 3; axis++) {
            s->least[axis] = corner == 0 ? along[axis] : float_min(s->least[axis], along[axis]);
            high[axis] = corner == 0 ? along[axis] : float_max(high[axis], along[axis]);
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        longest = float_max(longest, high[axis] - s->least[axis]);
    }
    s->cells.cell_m = longest / (float)cells;
    s->count = 1;
    for (int axis = 0; axis < 3; axis++) {
        const float count = ceilf((high[axis] - s->least[axis]) / s->cells.cell_m - 1e-3f);
        s->cells.size[axis] = (size_t)float_min(float_max(count, 1.0f), (float)cells);
        s->count *= s->cells.size[axis];
    }
}

static void cell_center(const slot *s, size_t cell, float out[3])
{
    const size_t *const n = s->cells.size;
    const size_t at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
    float along[3];
    for (int axis = 0; axis < 3; axis++) {
        along[axis] = s->least[axis] + ((float)(ptrdiff_t)at[axis] + 0.5f) * s->cells.cell_m;
    }
    vec3_store(out, frame_to_world(&s->frame, vec3(along[0], along[1], along[2])));
}

/* The cosine between the direction of travel and that to the camera. */
static float view_cosine(const air_seen_box *box, air_vec3 travel, const float local[3])
{
    air_vec3 to = vec3_load(box->observer);
    if (!box->distant) {
        to = vec3_sub(to, vec3_load(local));
    }
    const float length = vec3_length(to);
    const float cosine = length > 0.0f ? vec3_dot(to, travel) / length : 1.0f;
    return float_min(float_max(cosine, -1.0f), 1.0f);
}

static void fill_slot(const ord_carrying *carrying, const ord_source *source, slot *s)
{
    const ord_domain *const d = carrying->domain;
    for (size_t cell = 0; cell < s->count; cell++) {
        float local[3], at[3];
        place p;
        cell_center(s, cell, local);
        for (int axis = 0; axis < 3; axis++) {
            at[axis] = local[axis] / d->cell_m - 0.5f;
        }
        const bool inside = find_place(at, d->size, &p);
        for (size_t c = 0; c < 3; c++) {
            const size_t plane = c * d->cells;
            s->sigma_s[c][cell] = inside ? sample_place(&p, d->size, d->sigma_s + plane, 1) : 0.0f;
            s->sigma_a[c][cell] = inside ? sample_place(&p, d->size, d->sigma_a + plane, 1) : 0.0f;
            s->g[c][cell] = inside ? sample_place(&p, d->size, d->g + plane, 1) : 0.0f;
        }
        s->cosine[cell] = view_cosine(&carrying->box, source->place, local);
    }
    for (size_t i = 0; i < s->cells.size[0] * s->cells.size[1]; i++) {
        float local[3];
        cell_center(s, i, local);
        s->entry[i] =
            ord_source_share(source, carrying->with->path, ord_domain_world(d, vec3_load(local)));
    }
}

static air_status run_slot(const ord_carrying *carrying, const ord_source *source, slot *s)
{
    const air_ordinates_settings *const settings = carrying->with->settings;
    air_ordinates_params params;
    air_status status = AIR_OK;
    air_ordinates_params_default(&params);
    params.stencil = source->mode == AIR_ORDINATES_MODE_LITERAL ? AIR_ORDINATES_LITERAL
                     : source->mode == AIR_ORDINATES_MODE_SIX   ? AIR_ORDINATES_SIX
                                                                : AIR_ORDINATES_CM;
    params.decay = source->mode == AIR_ORDINATES_MODE_LITERAL ? AIR_ORDINATES_DECAY_PAPER
                                                              : AIR_ORDINATES_DECAY_POISSON;
    params.steps = settings->steps;
    params.lobe = source->lobe;
    for (size_t c = 0; c < (carrying->grey ? 1u : 3u) && status == AIR_OK; c++) {
        s->cells.sigma_s = s->sigma_s[c];
        s->cells.sigma_a = s->sigma_a[c];
        s->cells.g = s->g[c];
        s->cells.entry = s->entry;
        const air_ordinates_results results = {
            .view_cosine = s->cosine, .seen = s->seen[c], .energy = s->energy[c]};
        status = air_ordinates_scratch(&s->cells, &params) <= s->scratch_size
                     ? air_ordinates_run(carrying->with->context, &s->cells, &params, s->scratch,
                                         &results)
                     : AIR_ERROR_ARGUMENT;
    }
    for (size_t c = 1; c < 3 && carrying->grey && status == AIR_OK; c++) {
        memcpy(s->seen[c], s->seen[0], s->count * sizeof(float));
        memcpy(s->energy[c], s->energy[0], s->count * sizeof(float));
    }
    return status;
}

static void carry_slot(void *user, size_t index, size_t worker)
{
    directions *const self = user;
    slot *const s = &self->slots[index];
    (void)worker;
    place_slot(self->carrying, self->sources[index], s);
    fill_slot(self->carrying, self->sources[index], s);
    s->status = run_slot(self->carrying, self->sources[index], s);
}

/* ---- merging ---- */

/* Sums over grids, never means: each has light of its own. */
static void merge_cell(const directions *self, size_t cell)
{
    const ord_carrying *const carrying = self->carrying;
    const ord_domain *const d = carrying->domain;
    size_t at[3];
    ord_domain_cell(d, cell, at);
    const air_vec3 local = vec3(((float)(ptrdiff_t)at[0] + 0.5f) * d->cell_m,
                                ((float)(ptrdiff_t)at[1] + 0.5f) * d->cell_m,
                                ((float)(ptrdiff_t)at[2] + 0.5f) * d->cell_m);
    for (size_t n = 0; n < self->count; n++) {
        const slot *const s = &self->slots[n];
        const air_vec3 turned = frame_to_local(&s->frame, local);
        const float inverse = 1.0f / s->cells.cell_m;
        const float inside[3] = {(turned.x - s->least[0]) * inverse - 0.5f,
                                 (turned.y - s->least[1]) * inverse - 0.5f,
                                 (turned.z - s->least[2]) * inverse - 0.5f};
        const air_vec3 power = self->sources[n]->power;
        const float powers[3] = {power.x, power.y, power.z};
        place p;
        if (!find_place(inside, s->cells.size, &p)) {
            continue;
        }
        for (size_t c = 0; c < 3; c++) {
            carrying->with->carried[cell * CHANNELS + c] +=
                powers[c] * sample_place(&p, s->cells.size, s->seen[c], 1);
            if (carrying->rest != NULL) {
                carrying->rest[cell * CHANNELS + c] +=
                    powers[c] * inverse * inverse * inverse *
                    sample_place(&p, s->cells.size, s->energy[c], 1);
            }
        }
    }
}

static void merge_slab(void *user, size_t k, size_t worker)
{
    const directions *const self = user;
    const ord_domain *const d = self->carrying->domain;
    const size_t slab = d->size[0] * d->size[1];
    (void)worker;
    for (size_t cell = k * slab; cell < (k + 1) * slab; cell++) {
        merge_cell(self, cell);
    }
}

/* ---- all ---- */

enum { ARRAYS = 16 };

static bool make_slot(air_context *context, size_t capacity, uint32_t cells, slot *s)
{
    const air_ordinates_cells largest = {.size = {cells, cells, cells}, .cell_m = 1.0f};
    air_ordinates_params params;
    air_ordinates_params_default(&params);
    for (int stencil = AIR_ORDINATES_LITERAL; stencil <= AIR_ORDINATES_SIX; stencil++) {
        params.stencil = (air_ordinates_stencil)stencil;
        const size_t bytes = air_ordinates_scratch(&largest, &params);
        s->scratch_size = bytes > s->scratch_size ? bytes : s->scratch_size;
    }
    float *const numbers = air_allocate(context, capacity * ARRAYS, sizeof *numbers);
    s->block = air_allocate(context, s->scratch_size + AIR_ALIGNMENT, 1);
    s->entry = air_allocate(context, (size_t)cells * cells, sizeof *s->entry);
    s->cosine = numbers;
    if (numbers == NULL || s->block == NULL || s->entry == NULL) {
        return false;
    }
    s->scratch = air_align(s->block);
    for (size_t c = 0; c < 3; c++) {
        s->sigma_s[c] = numbers + (1 + c) * capacity;
        s->sigma_a[c] = numbers + (4 + c) * capacity;
        s->g[c] = numbers + (7 + c) * capacity;
        s->seen[c] = numbers + (10 + c) * capacity;
        s->energy[c] = numbers + (13 + c) * capacity;
    }
    return true;
}

static air_status carry_block(directions *self)
{
    air_context *const context = self->carrying->with->context;
    air_parallel_for(context, self->count, carry_slot, self);
    for (size_t n = 0; n < self->count; n++) {
        if (self->slots[n].status != AIR_OK) {
            return self->slots[n].status;
        }
    }
    air_parallel_for(context, self->carrying->domain->size[2], merge_slab, self);
    self->count = 0;
    return air_progress(context, 0.0, "light in grids") ? AIR_OK : AIR_ERROR_INTERRUPTED;
}

air_status ord_carry_directions(ord_carrying *carrying)
{
    air_context *const context = carrying->with->context;
    const uint32_t cells = carrying->with->settings->cells;
    const size_t capacity = (size_t)cells * cells * cells;
    directions *const self = air_allocate(context, 1, sizeof *self);
    air_status status = self != NULL ? AIR_OK : air_fail_memory(context, "ordinates: grids");
    for (size_t i = 0; i < carrying->sources->count && status == AIR_OK; i++) {
        const ord_source *const source = &carrying->sources->items[i];
        if (source->local || !ord_source_is_carried(source)) {
            continue;
        }
        slot *const s = &self->slots[self->count];
        self->carrying = carrying;
        if (s->cosine == NULL && !make_slot(context, capacity, cells, s)) {
            status = air_fail_memory(context, "ordinates: grids");
            break;
        }
        self->sources[self->count++] = source;
        status = self->count == SLOTS ? carry_block(self) : AIR_OK;
    }
    if (status == AIR_OK && self->count > 0) {
        status = carry_block(self);
    }
    for (size_t n = 0; self != NULL && n < SLOTS; n++) {
        air_free(context, self->slots[n].cosine);
        air_free(context, self->slots[n].block);
        air_free(context, self->slots[n].entry);
    }
    air_free(context, self);
    return status;
}

/* past.c: see past.h. */
#include "render/ordinates/past.h"

#include <math.h>
#include <string.h>

#include "core/host.h"
#include "ordinates/environment.h"
#include "scene/fingerprint.h"

enum { CHANNELS = AIR_DOM_STRIDE };

_Static_assert((int)ORD_IMPORTANCE_TEXELS == (int)AIR_IMPORTANCE_TEXELS,
               "the kernel's maps of importance");

/* Of the importance of the picture before. [Elek2014, section 5.2] */
#define KEPT_IMPORTANCE 0.8f

void ord_past_init(air_context *context, ord_past *past)
{
    memset(past, 0, sizeof *past);
    past->context = context;
}

static void finish_sky(const ord_past *past, ord_past_sky *sky)
{
    air_environment_ordinates_destroy(sky->ordinates);
    air_free(past->context, sky->blurred);
}

void ord_past_finish(ord_past *past)
{
    for (size_t i = 0; i < past->sky_count; i++) {
        finish_sky(past, &past->skies[i]);
    }
    air_free(past->context, past->skies);
    air_free(past->context, past->light.moments);
}

void ord_past_begin(ord_past *past)
{
    for (size_t i = 0; past != NULL && i < past->sky_count; i++) {
        past->skies[i].used = false;
    }
    if (past != NULL) {
        past->history = 0;
        past->new_importance = false;
    }
}

void ord_past_end(ord_past *past, const ord_domain *domain)
{
    size_t kept = 0;
    if (past == NULL) {
        return;
    }
    past->lattice = domain->lattice;
    if (past->new_importance) {
        memcpy(past->importance[0], past->importance[1], sizeof past->importance[0]);
        past->has_importance = true;
    }
    for (size_t i = 0; i < past->sky_count; i++) {
        if (past->skies[i].used) {
            past->skies[kept++] = past->skies[i];
        } else {
            finish_sky(past, &past->skies[i]);
        }
    }
    past->sky_count = kept;
}

const ord_lattice *ord_past_lattice(const ord_past *past)
{
    return past != NULL && past->lattice.cells > 0 ? &past->lattice : NULL;
}

static void add_history(ord_past *past, const void *data, size_t size)
{
    past->history = air_fingerprint_add(past->history, data, size);
    past->history += past->history == 0;
}

/* ---- light ---- */

/* From one box of cells to another. */
typedef struct resampling {
    const ord_past_light *from;
    const ord_domain *to;
    size_t numbers; /* of a cell */
    float scale[CHANNELS];
    float *out;
} resampling;

/* The two cells about the centre of the domain's number `at` along an axis, and the latter's share.
 */
static float neighbours(const resampling *self, int axis, size_t at, size_t out[2])
{
    const ord_past_light *const from = self->from;
    const float moved = self->to->goes_on ? self->to->lattice.base[axis] - from->base[axis] : 0.0f;
    const float centre =
        self->to->origin[axis] - moved + ((float)(ptrdiff_t)at + 0.5f) * self->to->cell_m;
    const float place = (centre - from->origin[axis]) / from->cell_m - 0.5f;
    const float last = (float)(ptrdiff_t)(from->size[axis] - 1);
    const float held = fminf(fmaxf(place, 0.0f), last);
    out[0] = (size_t)held;
    out[1] = out[0] + 1 < from->size[axis] ? out[0] + 1 : out[0];
    return held - floorf(held);
}

static void add_scaled(const resampling *self, size_t cell, float weight, float *out)
{
    const float *const from = self->from->moments + cell * self->numbers;
    for (size_t i = 0; i < self->numbers && weight > 0.0f; i++) {
        out[i] += weight * self->scale[i % CHANNELS] * from[i];
    }
}

static void resample_slab(void *user, size_t k, size_t worker)
{
    const resampling *const self = user;
    const size_t *const size = self->to->size, *const old = self->from->size;
    size_t x[2], y[2], z[2];
    const float share_z = neighbours(self, 2, k, z);
    (void)worker;
    for (size_t j = 0; j < size[1]; j++) {
        const float share_y = neighbours(self, 1, j, y);
        for (size_t i = 0; i < size[0]; i++) {
            const float share_x = neighbours(self, 0, i, x);
            float *const out = self->out + ((k * size[1] + j) * size[0] + i) * self->numbers;
            memset(out, 0, self->numbers * sizeof *out);
            for (int c = 0; c < 8; c++) {
                const int cx = c & 1, cy = c >> 1 & 1, cz = c >> 2;
                const float weight = (cx != 0 ? share_x : 1.0f - share_x) *
                                     (cy != 0 ? share_y : 1.0f - share_y) *
                                     (cz != 0 ? share_z : 1.0f - share_z);
                add_scaled(self, (z[cz] * old[1] + y[cy]) * old[0] + x[cx], weight, out);
            }
        }
    }
}

static bool fits(const ord_past *past, const air_dom_params *dom)
{
    return past != NULL && past->light.moments != NULL && past->light.bands == dom->bands &&
           past->light.delta_m == dom->delta_m;
}

bool ord_past_light_at(ord_past *past, const ord_domain *domain, const air_dom_params *dom,
                       const double first[3], float *moments)
{
    if (!fits(past, dom)) {
        return false;
    }
    resampling self = {.from = &past->light,
                       .to = domain,
                       .numbers = (size_t)(dom->bands * dom->bands) * CHANNELS,
                       .out = moments};
    bool any = false;
    for (size_t c = 0; c < 3; c++) {
        /* What is scattered is in proportion to what there is to scatter. */
        const double ratio = past->light.first[c] > 0.0 ? first[c] / past->light.first[c] : 0.0;
        self.scale[c] = ratio < 1e15 ? (float)ratio : 0.0f;
        any = any || self.scale[c] > 0.0f;
    }
    if (!any) {
        return false;
    }
    air_parallel_for(past->context, domain->size[2], resample_slab, &self);
    add_history(past, moments, domain->cells * self.numbers * sizeof *moments);
    return true;
}

bool ord_past_solution(ord_past *past, uint64_t key, float *moments)
{
    const ord_past_light *const light = &past->light;
    if (light->moments == NULL || light->key != key) {
        return false;
    }
    const size_t cells = light->size[0] * light->size[1] * light->size[2];
    const size_t count = cells * (size_t)(light->bands * light->bands) * CHANNELS;
    memcpy(moments, light->moments, count * sizeof *moments);
    add_history(past, moments, count * sizeof *moments);
    return true;
}

void ord_past_keep_light(ord_past *past, const ord_domain *domain, const air_dom_params *dom,
                         const double first[3], uint64_t key, float *moments)
{
    ord_past_light *const light = &past->light;
    air_free(past->context, light->moments);
    light->moments = moments;
    light->key = key;
    light->cell_m = domain->cell_m;
    light->bands = dom->bands;
    light->delta_m = dom->delta_m;
    for (int axis = 0; axis < 3; axis++) {
        light->origin[axis] = domain->origin[axis];
        light->base[axis] = domain->lattice.base[axis];
        light->size[axis] = domain->size[axis];
        light->first[axis] = first[axis];
    }
}

/* ---- importance ---- */

void ord_past_mix_importance(ord_past *past, float map[ORD_IMPORTANCE_TEXELS])
{
    if (past == NULL) {
        return;
    }
    if (past->has_importance) {
        air_importance_blend(past->importance[0], map, KEPT_IMPORTANCE, map);
        add_history(past, map, AIR_IMPORTANCE_TEXELS * sizeof *map);
    }
    memcpy(past->importance[1], map, sizeof past->importance[1]);
    past->new_importance = true;
}

/* ---- skies ---- */

uint64_t ord_past_sky_key(const air_environment_map *map)
{
    const uint64_t numbers[] = {map->pixels != NULL, map->width, map->height, map->pixel_stride,
                                map->row_stride};
    uint64_t key = air_fingerprint_add(0, map->radiance, sizeof map->radiance);
    key = air_fingerprint_add(key, &map->contrast, sizeof map->contrast);
    if (map->pixels != NULL) {
        key = air_fingerprint_add(key, numbers, sizeof numbers);
        key = air_fingerprint_add(key, map->pixels,
                                  map->height * map->row_stride * sizeof *map->pixels);
    }
    return key + (key == 0);
}

static ord_past_sky *find_sky(const ord_past *past, uint64_t key)
{
    for (size_t i = 0; past != NULL && i < past->sky_count; i++) {
        if (past->skies[i].key == key) {
            past->skies[i].used = true;
            return &past->skies[i];
        }
    }
    return NULL;
}

/* The sky of that key, which may be new. NULL: no memory. */
static ord_past_sky *have_sky(ord_past *past, uint64_t key)
{
    ord_past_sky *const found = find_sky(past, key);
    if (found != NULL) {
        return found;
    }
    ord_past_sky *const skies =
        air_reallocate(past->context, past->skies, past->sky_count + 1, sizeof *skies);
    if (skies == NULL) {
        return NULL;
    }
    past->skies = skies;
    skies[past->sky_count] = (ord_past_sky){.key = key, .used = true};
    return &skies[past->sky_count++];
}

air_status ord_past_prepare_sky(ord_past *past, air_context *context,
                                const air_environment_map *map, air_environment_ordinates **out)
{
    *out = NULL;
    if (past == NULL) {
        return air_environment_ordinates_create(context, map, out);
    }
    ord_past_sky *const sky = have_sky(past, ord_past_sky_key(map));
    if (sky == NULL) {
        return air_fail_memory(context, "ordinates: sky");
    }
    if (sky->ordinates == NULL) {
        const air_status status = air_environment_ordinates_create(context, map, &sky->ordinates);
        if (status != AIR_OK) {
            return status;
        }
    }
    /* The pixels are the same, but they may lie elsewhere than those of the picture before. */
    sky->ordinates->map.pixels = map->pixels;
    *out = sky->ordinates;
    return AIR_OK;
}

void ord_past_release_sky(const ord_past *past, air_environment_ordinates *ordinates)
{
    if (past == NULL) {
        air_environment_ordinates_destroy(ordinates);
    }
}

bool ord_past_blurred_sky(ord_past *past, uint64_t key, uint64_t blur_key, float *out, size_t count)
{
    const ord_past_sky *const sky = find_sky(past, key);
    if (sky == NULL || sky->blurred == NULL || sky->blur_key != blur_key) {
        return false;
    }
    memcpy(out, sky->blurred, count * sizeof *out);
    return true;
}

/* Without memory it is made again next time. */
void ord_past_keep_blurred_sky(ord_past *past, uint64_t key, uint64_t blur_key,
                               const float *blurred, size_t count)
{
    ord_past_sky *const sky = past != NULL ? have_sky(past, key) : NULL;
    if (sky != NULL && sky->blurred == NULL) {
        sky->blurred = air_allocate(past->context, count, sizeof *blurred);
    }
    if (sky != NULL && sky->blurred != NULL) {
        memcpy(sky->blurred, blurred, count * sizeof *blurred);
        sky->blur_key = blur_key;
    }
}

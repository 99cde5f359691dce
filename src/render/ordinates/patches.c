/* patches.c: see patches.h. */
#include "render/ordinates/patches.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_lights.h"

enum {
    HILBERT_BITS = 10,
    NORMAL_CLASSES = 6,
    DISTANCES = 16,
    SIGHT_SHIFT = 3 * HILBERT_BITS + 8,
    DEPTH_ROUNDS = 4,
    WINDOW = 32,
    SEED = 0x6f726470
};

/* Surfaces closer than this share of the domain's diagonal are near. */
#define NEAR_SHARE 0.25f

/* Along a curve on which neighbours are near each other, the key of a photon: how far from the
 * domain, which way it faces, where on a Hilbert curve it is. */
typedef struct spot {
    uint64_t key;
    float weight; /* luminance, less far away */
    const ord_photon *photon;
    bool sees; /* the domain */
} spot;

typedef struct choosing {
    const ord_space *space;
    air_vec3 low, high, size; /* the domain */
    float diagonal;
    air_vec3 from, extent; /* bounds of the photons that shine on it */
    spot *spots;
    size_t count;
    double weight; /* of all */
    size_t patches;
    ord_source_list *out;
    float *position, *normal, *flux; /* of a run */
    air_surface_light *lights;
} choosing;

static float component(air_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* ---- order ---- */

/* Is some corner of the domain before the surface? */
static bool shines_on(const choosing *self, const ord_photon *photon)
{
    const air_vec3 n = photon->normal;
    const air_vec3 corner =
        vec3(n.x > 0.0f ? self->high.x : self->low.x, n.y > 0.0f ? self->high.y : self->low.y,
             n.z > 0.0f ? self->high.z : self->low.z);
    return vec3_dot(vec3_sub(corner, photon->position), n) > 0.0f;
}

static float distance_to_domain(const choosing *self, air_vec3 p)
{
    const air_vec3 held = vec3(float_min(float_max(p.x, self->low.x), self->high.x),
                               float_min(float_max(p.y, self->low.y), self->high.y),
                               float_min(float_max(p.z, self->low.z), self->high.z));
    return vec3_length(vec3_sub(p, held)) / self->diagonal;
}

static uint64_t normal_class(air_vec3 n)
{
    const float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
    const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    return (uint64_t)(2 * axis + (component(n, axis) < 0.0f ? 1 : 0));
}

/* Position on a Hilbert curve through a cube of 2^HILBERT_BITS cells along each axis, from its
 * transposed form [Skilling2004]. */
static uint64_t hilbert(uint32_t x[3])
{
    for (uint32_t q = 1u << (HILBERT_BITS - 1); q > 1; q >>= 1) {
        const uint32_t p = q - 1;
        for (int i = 0; i < 3; i++) {
            const uint32_t t = (x[i] & q) != 0 ? 0 : (x[0] ^ x[i]) & p;
            x[0] ^= (x[i] & q) != 0 ? p : t;
            x[i] ^= i > 0 ? t : 0;
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    uint32_t t = 0;
    for (uint32_t q = 1u << (HILBERT_BITS - 1); q > 1; q >>= 1) {
        t ^= (x[2] & q) != 0 ? q - 1 : 0;
    }
    uint64_t key = 0;
    for (int bit = HILBERT_BITS - 1; bit >= 0; bit--) {
        for (int i = 0; i < 3; i++) {
            key = key << 1 | (((x[i] ^ t) >> bit) & 1u);
        }
    }
    return key;
}

static uint64_t key_of(const choosing *self, const ord_photon *photon, float distance)
{
    uint32_t at[3];
    for (int axis = 0; axis < 3; axis++) {
        const float extent = component(self->extent, axis);
        const float share =
            extent > 0.0f
                ? (component(photon->position, axis) - component(self->from, axis)) / extent
                : 0.0f;
        const float most = (float)((1 << HILBERT_BITS) - 1);
        at[axis] = (uint32_t)(float_min(float_max(share, 0.0f), 1.0f) * most);
    }
    const float octaves = distance > NEAR_SHARE ? ceilf(log2f(distance / NEAR_SHARE)) : 0.0f;
    const uint64_t class = (uint64_t)float_min(octaves, (float)(DISTANCES - 1));
    return (class * NORMAL_CLASSES + normal_class(photon->normal)) << (3 * HILBERT_BITS) |
           hilbert(at);
}

static int by_key(const void *a, const void *b)
{
    const spot *const x = a, *const y = b;
    if (x->key != y->key) {
        return x->key < y->key ? -1 : 1;
    }
    return (x->photon > y->photon) - (x->photon < y->photon);
}

/* The photons that shine on the domain, in order. */
static void set_spots(choosing *self, const ord_photon *photons, size_t count)
{
    air_vec3 low = vec3_set1(HUGE_VALF), high = vec3_set1(-HUGE_VALF);
    for (size_t i = 0; i < count; i++) {
        const air_vec3 p = photons[i].position;
        if (vec3_luminance(photons[i].flux) > 0.0f && shines_on(self, &photons[i])) {
            self->spots[self->count++].photon = &photons[i];
            low = vec3(float_min(low.x, p.x), float_min(low.y, p.y), float_min(low.z, p.z));
            high = vec3(float_max(high.x, p.x), float_max(high.y, p.y), float_max(high.z, p.z));
        }
    }
    const air_vec3 size = vec3_sub(high, low);
    self->from = low;
    self->extent = vec3_set1(vec3_max(size)); /* a cube, so that near is near in all directions */
    for (size_t i = 0; i < self->count; i++) {
        spot *const at = &self->spots[i];
        const float distance = distance_to_domain(self, at->photon->position);
        at->key = key_of(self, at->photon, distance);
        at->weight = vec3_luminance(at->photon->flux) / (1.0f + 4.0f * distance * distance);
        self->weight += (double)at->weight;
    }
    qsort(self->spots, self->count, sizeof *self->spots, by_key);
}

/* Do they see the domain? A look at a place in it for each. */
static void look_from_spots(void *user, size_t chunk, size_t worker)
{
    const choosing *const self = user;
    const air_path *const path = self->space->path;
    const size_t begin = chunk * WINDOW, rest = self->count - begin;
    const size_t count = rest < WINDOW ? rest : WINDOW;
    air_ray rays[WINDOW] = {{.mask = 0}};
    uint8_t occluded[WINDOW];
    (void)worker;
    for (size_t i = 0; i < count; i++) {
        const ord_photon *const p = self->spots[begin + i].photon;
        const air_sampler sampler = air_sampler_make(path->sobol, SEED, (uint32_t)(begin + i));
        const air_f32x4 u = air_sampler_get(&sampler, 0);
        const air_vec3 to = vec3_add(self->low, vec3_mul(self->size, vec3(u[0], u[1], u[2])));
        const air_vec3 dir = vec3_sub(to, p->position);
        rays[i] = (air_ray){.tmax = 1.0f, .mask = AIR_MASK_SHADOW_OPAQUE};
        vec3_store(rays[i].origin, p->position);
        vec3_store(rays[i].dir, dir);
        rays[i].mask = vec3_dot(dir, p->normal) > 0.0f ? rays[i].mask : 0;
    }
    path->rays->occluded(path->snapshot->accelerator, rays, count, occluded);
    for (size_t i = 0; i < count; i++) {
        self->spots[begin + i].sees = rays[i].mask != 0 && !occluded[i];
    }
}

/* Spots that are next to each other see the domain alike. Those that see none of it are left out,
 * and such as see little of it are apart from others, so that they have patches of their own. */
static void sort_by_sight(choosing *self)
{
    size_t kept = 0;
    air_parallel_for(self->out->context, (self->count + WINDOW - 1) / WINDOW, look_from_spots,
                     self);
    self->weight = 0.0;
    for (size_t begin = 0; begin < self->count; begin += WINDOW) {
        const size_t rest = self->count - begin, count = rest < WINDOW ? rest : WINDOW;
        size_t seeing = 0;
        for (size_t i = begin; i < begin + count; i++) {
            seeing += self->spots[i].sees ? 1 : 0;
        }
        const float share = (float)(ptrdiff_t)seeing / (float)(ptrdiff_t)count;
        const uint64_t blind = share < 0.08f ? 2 : share < 0.25f ? 1 : 0;
        for (size_t i = begin; i < begin + count && seeing > 0; i++) {
            spot *const at = &self->spots[kept++];
            *at = self->spots[i];
            at->weight *= share;
            at->key |= blind << SIGHT_SHIFT;
            self->weight += (double)at->weight;
        }
    }
    self->count = kept;
    qsort(self->spots, self->count, sizeof *self->spots, by_key);
}

/* ---- patches ---- */

/* The photon nearest to the middle of a patch: means of curved surfaces lie within them. */
static const ord_photon *nearest(const spot *spots, size_t count, const air_surface_light *light)
{
    const air_vec3 at =
        vec3((float)light->position[0], (float)light->position[1], (float)light->position[2]);
    const air_vec3 normal =
        vec3((float)light->normal[0], (float)light->normal[1], (float)light->normal[2]);
    const ord_photon *best = spots[0].photon;
    float least = HUGE_VALF;
    for (size_t i = 0; i < count; i++) {
        const ord_photon *const p = spots[i].photon;
        const air_vec3 off = vec3_sub(p->position, at);
        const float turned = 1.0f - vec3_dot(p->normal, normal);
        const float square = vec3_dot(off, off) * (1.0f + 4.0f * turned * turned);
        best = square < least ? p : best;
        least = float_min(square, least);
    }
    return best;
}

static air_status add_source(const choosing *self, const spot *spots, size_t count,
                             const air_surface_light *light)
{
    const ord_photon *const photon = nearest(spots, count, light);
    const air_vec3 normal =
        vec3((float)light->normal[0], (float)light->normal[1], (float)light->normal[2]);
    const float inverse_pi = 1.0f / AIR_PI_F;
    /* A square of the disk's second moment has edges of sqrt(3) radii; no smaller than a cell, in
     * which its light is spread anyway. */
    const float least = self->space->domain->cell_m * 0.57735027f;
    const ord_source source = {
        .local = true,
        .events = 1,
        .place = photon->position,
        .power = vec3((float)light->flux[0] * inverse_pi, (float)light->flux[1] * inverse_pi,
                      (float)light->flux[2] * inverse_pi),
        .lobe = (float)light->lobe,
        .radius_m = float_max((float)light->radius_m, least),
        .cosine = true,
        .casts_shadow = true,
        .normal = vec3_dot(normal, photon->normal) > 0.0f ? normal : photon->normal};
    return vec3_is_zero(source.power) ? AIR_OK : ord_sources_add(self->out, &source);
}

/* Spots of one run as `patches` sources. */
static air_status add_run(const choosing *self, const spot *spots, size_t count, size_t patches)
{
    for (size_t i = 0; i < count; i++) {
        const ord_photon *const p = spots[i].photon;
        vec3_store(self->position + 3 * i, p->position);
        vec3_store(self->normal + 3 * i, p->normal);
        vec3_store(self->flux + 3 * i, p->flux);
    }
    const air_surface_samples samples = {.count = count,
                                         .position = self->position,
                                         .normal = self->normal,
                                         .irradiance = self->flux};
    air_status status = air_surface_lights_choose(self->out->context, &samples, patches,
                                                  (double)(0.25f * self->diagonal), self->lights);
    for (size_t i = 0; i < patches && status == AIR_OK; i++) {
        status = add_source(self, spots, count, &self->lights[i]);
    }
    return status;
}

/* Runs of spots that are as far away and face the same way have patches by their share of the
 * weight; those that have too little for one are taken together. */
static air_status add_runs(const choosing *self)
{
    const double each = self->weight / (double)self->patches;
    double weight = 0.0;
    size_t begin = 0;
    air_status status = AIR_OK;
    for (size_t i = 0; i < self->count && status == AIR_OK; i++) {
        const bool last = i + 1 == self->count;
        const int shift = 3 * HILBERT_BITS;
        const bool ends = last || self->spots[i].key >> shift != self->spots[i + 1].key >> shift;
        weight += (double)self->spots[i].weight;
        if (last || (ends && weight >= 0.5 * each)) {
            const double share = floor(weight / each + 0.5);
            const size_t patches = share >= 1.0 ? (size_t)share : 1;
            status = add_run(self, self->spots + begin, i + 1 - begin, patches);
            begin = i + 1;
            weight = 0.0;
        }
    }
    return status;
}

static air_status choose(const ord_space *space, const ord_photon *photons, size_t count,
                         size_t patches, ord_source_list *out)
{
    air_context *const context = out->context;
    const ord_domain *const d = space->domain;
    choosing self = {.space = space, .patches = patches, .out = out};
    air_status status = AIR_OK;
    self.low = vec3_load(d->origin);
    self.size = vec3_scale(vec3((float)(ptrdiff_t)d->size[0], (float)(ptrdiff_t)d->size[1],
                                (float)(ptrdiff_t)d->size[2]),
                           d->cell_m);
    self.high = vec3_add(self.low, self.size);
    self.diagonal = vec3_length(self.size);
    self.spots = air_allocate(context, count, sizeof *self.spots);
    self.position = air_allocate(context, 3 * count, sizeof *self.position);
    self.normal = air_allocate(context, 3 * count, sizeof *self.normal);
    self.flux = air_allocate(context, 3 * count, sizeof *self.flux);
    self.lights = air_allocate(context, patches + 1, sizeof *self.lights);
    if (self.spots == NULL || self.position == NULL || self.normal == NULL || self.flux == NULL ||
        self.lights == NULL) {
        status = air_fail_memory(context, "ordinates: patches");
    } else {
        set_spots(&self, photons, count);
        sort_by_sight(&self);
        status = add_runs(&self);
    }
    air_free(context, self.spots);
    air_free(context, self.position);
    air_free(context, self.normal);
    air_free(context, self.flux);
    air_free(context, self.lights);
    return status;
}

air_status ord_patches_choose(const ord_space *space, const ord_photons *photons, size_t patches,
                              ord_source_list *out)
{
    return choose(space, photons->items + photons->count, photons->count * (photons->rounds - 1),
                  patches, out);
}

air_status ord_patches_add(const ord_lighting *lighting, const ord_space *space, uint32_t max_depth,
                           ord_source_list *out)
{
    const size_t patches = lighting->settings->patches;
    const bool endless = max_depth > ORD_SURFACE_EVENTS;
    const size_t most = endless ? ORD_ROUNDS : DEPTH_ROUNDS, events = (size_t)max_depth - 1;
    ord_photons photons;
    if (space->path->snapshot->accelerator == NULL || max_depth < 2) {
        return AIR_OK;
    }
    air_status status = ord_photons_shoot(lighting, space, events < most ? events : most, &photons);
    if (status == AIR_OK && endless) {
        status = ord_patches_choose(space, &photons, patches, out);
    }
    for (size_t round = 1; !endless && status == AIR_OK && round < photons.rounds; round++) {
        const size_t before = out->count;
        status = choose(space, photons.items + round * photons.count, photons.count, patches, out);
        for (size_t i = before; i < out->count; i++) {
            out->items[i].events = (uint32_t)round;
        }
    }
    ord_photons_finish(&photons);
    return status;
}

/* photons.c: see photons.h. */
#include "render/ordinates/photons.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "airlight/ordinates_beam.h"
#include "core/warp.h"
#include "scene/surface.h"

enum { CHUNK = 64, LAYERS = 32, SEED = 0x6f726470 };

/* Rounds end when they carry less than this share of the first. */
#define LEAST_FLUX 0.02

air_status ord_photons_create(air_context *context, size_t count, size_t rounds, ord_photons *out)
{
    memset(out, 0, sizeof *out);
    out->items = air_allocate(context, count * (rounds + 1), sizeof *out->items);
    if (out->items == NULL) {
        return air_fail_memory(context, "ordinates: light of surfaces");
    }
    out->context = context;
    out->count = count;
    out->rounds = 1;
    return AIR_OK;
}

void ord_photons_finish(ord_photons *photons)
{
    if (photons->items != NULL) {
        air_free(photons->context, photons->items);
    }
    memset(photons, 0, sizeof *photons);
}

/* ---- from surface to surface ---- */

typedef struct flight {
    const ord_space *space;
    const ord_photon *from;
    ord_photon *to;
    size_t count, round;
} flight;

static air_sampler sampler_of(const ord_space *space, size_t photon)
{
    return air_sampler_make(space->path->sobol, SEED, (uint32_t)photon);
}

/* Does the light end at this hit? Coverage decides by chance, and where a surface is lit but lets
 * all light pass, each of both happens half of the time. */
static bool ends(const ord_space *space, const air_hit *hit, air_rng *rng, air_vec3 *flux,
                 const air_light *light)
{
    const air_snapshot *const snapshot = space->path->snapshot;
    const air_mesh *const mesh = snapshot->meshes[hit->mesh];
    const bool covers = (mesh->mask & (AIR_MASK_SHADOW_OPAQUE | AIR_MASK_SHADOW_ALPHA)) != 0;
    const float alpha = air_surface_alpha(snapshot, hit);
    if (alpha < 1.0f && air_rng_float(rng) >= alpha) {
        return false;
    }
    if (light == NULL || (light->casts_shadow && covers)) {
        return true;
    }
    *flux = vec3_scale(*flux, 2.0f);
    return air_rng_float(rng) < 0.5f;
}

static air_vec3 let_through(const ord_space *space, air_vec3 from, air_vec3 to)
{
    const ord_domain *const d = space->domain;
    const air_beam_box box = {
        {d->size[0], d->size[1], d->size[2]}, {d->cell_m, d->cell_m, d->cell_m}, space->extinction};
    float a[3], b[3], depth[4];
    vec3_store(a, ord_domain_local(d, from));
    vec3_store(b, ord_domain_local(d, to));
    air_beam_depth(&box, a, b, depth);
    return vec3_exp(vec3(-depth[0], -depth[1], -depth[2]));
}

/* What a photon becomes at the surface that it meets. */
static void land(const ord_space *space, const ord_photon *from, const air_hit *hit, air_vec3 flux,
                 const float u[2], ord_photon *to)
{
    air_surface surface;
    air_surface_make(space->path->snapshot, hit, from->dir, &surface);
    const air_vec3 wo = vec3_neg(from->dir);
    if (air_bsdf_is_black(&surface.bsdf)) {
        return;
    }
    const air_vec3 albedo = air_bsdf_albedo(&surface.bsdf, wo);
    const air_vec3 passed = let_through(space, from->position, surface.position);
    const air_frame frame = frame_from_normal(surface.bsdf.normal);
    to->position = air_surface_origin(&surface, surface.bsdf.normal);
    to->normal = surface.bsdf.normal;
    to->dir = frame_to_world(&frame, sample_cosine_hemisphere(u[0], u[1]));
    to->flux =
        vec3_mul(vec3_mul(flux, passed), vec3(float_min(albedo.x, 1.0f), float_min(albedo.y, 1.0f),
                                              float_min(albedo.z, 1.0f)));
}

static void fly_one(const flight *self, size_t i, air_ray *ray, air_hit *hit)
{
    const ord_space *const space = self->space;
    const air_sampler sampler = sampler_of(space, i);
    const air_f32x4 u = air_sampler_get(&sampler, (uint32_t)self->round);
    const ord_photon *const from = &self->from[i];
    air_rng rng = air_sampler_rng(&sampler, (uint32_t)self->round);
    air_vec3 flux = from->flux;
    for (int layer = 0; layer < LAYERS && hit->mesh != (uint32_t)AIR_NO_HIT; layer++) {
        if (ends(space, hit, &rng, &flux, from->light)) {
            const float pair[2] = {u[0], u[1]};
            land(space, from, hit, flux, pair, &self->to[i]);
            return;
        }
        ray->tmin = hit->t * (1.0f + 4.0f * FLT_EPSILON);
        space->path->rays->intersect(space->path->snapshot->accelerator, ray, 1, hit);
    }
}

static void fly_chunk(void *user, size_t chunk, size_t worker)
{
    const flight *const self = user;
    const air_path *const path = self->space->path;
    const size_t begin = chunk * CHUNK;
    const size_t rest = self->count - begin, count = rest < CHUNK ? rest : CHUNK;
    air_ray rays[CHUNK];
    air_hit hits[CHUNK];
    size_t which[CHUNK], alive = 0;
    (void)worker;
    for (size_t i = begin; i < begin + count; i++) {
        const ord_photon *const from = &self->from[i];
        memset(&self->to[i], 0, sizeof self->to[i]);
        if (!vec3_is_zero(from->flux)) {
            air_ray *const ray = &rays[alive];
            *ray = (air_ray){.tmax = FLT_MAX, .mask = AIR_MASK_SCATTER};
            vec3_store(ray->origin, from->position);
            vec3_store(ray->dir, from->dir);
            which[alive++] = i;
        }
    }
    if (alive > 0) {
        path->rays->intersect(path->snapshot->accelerator, rays, alive, hits);
    }
    for (size_t n = 0; n < alive; n++) {
        fly_one(self, which[n], &rays[n], &hits[n]);
    }
}

static void total_flux(const ord_photon *photons, size_t count, double out[3])
{
    memset(out, 0, 3 * sizeof *out);
    for (size_t i = 0; i < count; i++) {
        out[0] += (double)photons[i].flux.x;
        out[1] += (double)photons[i].flux.y;
        out[2] += (double)photons[i].flux.z;
    }
}

/* The last round, and as much again for those that would follow it, which are much like it. */
static void stand_for_rest(ord_photon *last, size_t count, const double before[3],
                           const double now[3])
{
    float scale[3];
    for (int c = 0; c < 3; c++) {
        const double ratio = before[c] > 0.0 ? now[c] / before[c] : 0.0;
        scale[c] = (float)(1.0 / (1.0 - fmin(ratio, 0.95)));
    }
    for (size_t i = 0; i < count; i++) {
        last[i].flux = vec3_mul(last[i].flux, vec3_load(scale));
    }
}

void ord_photons_follow(const ord_space *space, size_t rounds, bool endless, ord_photons *photons)
{
    const size_t count = photons->count, chunks = (count + CHUNK - 1) / CHUNK;
    double first = 0.0, before[3], now[3] = {0.0, 0.0, 0.0};
    for (size_t round = 1; round <= rounds; round++) {
        ord_photon *const to = photons->items + round * count;
        flight self = {space, to - count, to, count, round};
        air_parallel_for(photons->context, chunks, fly_chunk, &self);
        memcpy(before, now, sizeof before);
        total_flux(to, count, now);
        const double flux = now[0] + now[1] + now[2];
        first = round == 1 ? flux : first;
        photons->rounds = round + 1;
        const bool last = round == rounds || !(flux > LEAST_FLUX * first);
        if (last && endless && round > 1) {
            stand_for_rest(to, count, before, now);
        }
        if (last) {
            break;
        }
    }
}

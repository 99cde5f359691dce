/* connect.c: rays against the scene: shadow rays, and nearest hits past transparent surfaces. */
#include <string.h>

#include "path/tracking.h"
#include "path/vertex.h"

/* Moves a ray's start just behind a hit; at most so many transparent surfaces are passed. */
enum { MAX_LAYERS = 64 };

static void step_behind(air_ray *ray, float t) { ray->tmin = t + fmaxf(t * 1e-5f, 1e-6f); }

float air_path_alpha_transmittance(const air_path *path, const air_ray *shadow_ray)
{
    air_ray ray = *shadow_ray;
    float product = 1.0f;
    ray.mask = AIR_MASK_SHADOW_ALPHA;
    for (int layer = 0; layer < MAX_LAYERS && product > 0.0f; layer++) {
        air_hit hit;
        path->rays->intersect(path->snapshot->accelerator, &ray, 1, &hit);
        if (hit.mesh == (uint32_t)AIR_NO_HIT) {
            break;
        }
        product *= 1.0f - air_surface_alpha(path->snapshot, &hit);
        step_behind(&ray, hit.t);
    }
    return product;
}

void air_path_shares(const air_path *path, const air_ray *rays, size_t count, uint8_t *occluded,
                     float *out_shares)
{
    const air_snapshot *snapshot = path->snapshot;
    memset(occluded, 0, count);
    if (snapshot->accelerator != NULL && count > 0) {
        path->rays->occluded(snapshot->accelerator, rays, count, occluded);
    }
    for (size_t i = 0; i < count; i++) {
        const bool alpha = snapshot->has_alpha && rays[i].mask != 0 && !occluded[i];
        out_shares[i] = occluded[i] ? 0.0f
                        : alpha     ? air_path_alpha_transmittance(path, &rays[i])
                                    : 1.0f;
    }
}

/* Of a way that nothing stops. */
static air_vec3 late_transmittance(const air_path *path, air_path_scratch *scratch,
                                   const air_path_lane *lane, const air_ray *ray,
                                   const path_shadow *shadow)
{
    air_vec3 transmittance = vec3_set1(1.0f);
    if (path_attenuate_closed(path, scratch, ray, shadow->distance, &transmittance)) {
        return transmittance;
    }
    air_rng rng = air_sampler_rng(&lane->sampler, shadow->stream);
    return air_track_transmittance(&scratch->media, fminf(shadow->distance, AIR_FAR), &rng);
}

static air_vec3 *target_sum(air_path_lane *lane, uint32_t target)
{
    return target == PATH_TO_RECEIVER ? &lane->connected
           : target == PATH_THROUGH   ? &lane->through
                                      : &lane->terms[target];
}

/* Light that media scattered on the way is there where the way is free; what they scatter later is
 * what arrives. */
static void add_scattered(const path_shadow *shadow, float share, air_vec3 transmittance,
                          air_path_lane *lane)
{
    const air_vec3 carried = vec3_mul(shadow->carried, transmittance);
    air_vec3 *sum = &lane->terms[AIR_TERM_M2];
    *sum = vec3_add(*sum, vec3_scale(vec3_add(shadow->scattered, carried), share));
    lane->lit_share = shadow->lit ? share : lane->lit_share;
}

void path_connect(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes)
{
    const size_t count = scratch->shadow_count;
    scratch->shadow_count = 0;
    air_path_shares(path, scratch->shadow_rays, count, scratch->occluded, scratch->shares);
    for (size_t i = 0; i < count; i++) {
        const path_shadow *shadow = &scratch->shadows[i];
        const air_ray *ray = &scratch->shadow_rays[i];
        const float share = scratch->shares[i] * (shadow->paired ? scratch->shares[i + 1] : 1.0f);
        if (share == 0.0f) {
            continue;
        }
        air_path_lane *lane = &lanes[shadow->lane];
        air_vec3 transmittance = vec3_set1(1.0f);
        if (shadow->late) {
            transmittance = late_transmittance(path, scratch, lane, ray, shadow);
        }
        if (shadow->paired && shadow[1].late && !vec3_is_zero(transmittance)) {
            transmittance = vec3_mul(transmittance,
                                     late_transmittance(path, scratch, lane, ray + 1, shadow + 1));
        }
        if (path_responds(path)) {
            add_scattered(shadow, share, transmittance, lane);
        }
        air_vec3 *sum = target_sum(lane, shadow->target);
        *sum = vec3_add(*sum, vec3_mul(vec3_scale(shadow->value, share), transmittance));
    }
}

/* Is the surface there for this ray? BLEND decides by chance. */
static bool stops(const air_path *path, const air_hit *hit, air_rng *rng)
{
    const float alpha = air_surface_alpha(path->snapshot, hit);
    return alpha >= 1.0f || (alpha > 0.0f && air_rng_float(rng) < alpha);
}

static void pass_transparent(const air_path *path, air_ray *ray, air_hit *hit,
                             const air_sampler *sampler, uint32_t stream)
{
    air_rng rng = air_sampler_rng(sampler, stream);
    for (int layer = 0; layer < MAX_LAYERS && hit->mesh != (uint32_t)AIR_NO_HIT; layer++) {
        const air_mesh *mesh = path->snapshot->meshes[hit->mesh];
        if (path->snapshot->materials[mesh->material].alpha_mode == AIR_ALPHA_OPAQUE ||
            stops(path, hit, &rng)) {
            return;
        }
        step_behind(ray, hit->t);
        path->rays->intersect(path->snapshot->accelerator, ray, 1, hit);
    }
}

void path_intersect(const air_path *path, air_path_scratch *scratch, const air_path_lane *lanes,
                    size_t count)
{
    const air_snapshot *snapshot = path->snapshot;
    if (snapshot->accelerator == NULL) {
        for (size_t i = 0; i < count; i++) {
            scratch->hits[i].mesh = (uint32_t)AIR_NO_HIT;
        }
        return;
    }
    path->rays->intersect(snapshot->accelerator, scratch->rays, count, scratch->hits);
    for (size_t i = 0; snapshot->has_alpha && i < count; i++) {
        const path_walk *walk = &scratch->walks[i];
        pass_transparent(path, &scratch->rays[i], &scratch->hits[i], &lanes[walk->lane].sampler,
                         0x10000u + walk->depth * 2 + walk->branch);
    }
}

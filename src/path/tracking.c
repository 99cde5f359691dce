#include "path/tracking.h"

#include "scene/media/grid.h"

enum { MAX_GRIDS = 8 }; /* grids walked brick by brick at once; the rest go in by their maxima */

/* Pieces of a segment with a bound on sigma_t (all channels) over each. */
typedef struct majorant_walk {
    const air_ray_media *ray;
    const air_ray_segment *segment;
    float t, t_end;
    float constant; /* constant media, detailed ones too, and grids beyond MAX_GRIDS */
    size_t grid_count;
    struct {
        air_grid_walk walk;
        float scale; /* largest sigma_t where the grid is 1 */
        float t1, majorant;
    } grids[MAX_GRIDS];
} majorant_walk;

static void add_grid(majorant_walk *walk, const air_medium *medium, float t_end)
{
    const float scale = vec3_max(medium->sigma_t) * air_medium_most(medium);
    if (walk->grid_count == MAX_GRIDS) {
        walk->constant += scale * air_grid_max(medium->density_grid);
        return;
    }
    const size_t g = walk->grid_count++;
    walk->grids[g].scale = scale;
    walk->grids[g].t1 = walk->t;
    walk->grids[g].majorant = 0.0f;
    air_grid_walk_start(&walk->grids[g].walk, medium->density_grid,
                        affine_point(medium->world_to_grid, walk->ray->origin),
                        affine_vector(medium->world_to_grid, walk->ray->dir), walk->t, t_end);
}

static void walk_start(majorant_walk *walk, const air_ray_media *ray, size_t segment_index,
                       float t_end)
{
    const air_ray_segment *segment = &ray->segments[segment_index];
    walk->ray = ray;
    walk->segment = segment;
    walk->t = segment->t0;
    walk->t_end = fminf(segment->t1, t_end);
    walk->constant = vec3_max(segment->sigma_t);
    walk->grid_count = 0;
    for (uint64_t rest = segment->tracked ? segment->regions : 0; rest != 0; rest &= rest - 1) {
        const air_region *region = &ray->media->regions[__builtin_ctzll(rest)];
        const air_medium *medium = &ray->media->media[region->medium];
        if (medium->kind == AIR_DENSITY_GRID) {
            add_grid(walk, medium, walk->t_end);
        } else if (medium->kind == AIR_DENSITY_CONSTANT && !region->constant) {
            walk->constant += vec3_max(region->sigma_t) * air_medium_most(medium);
        }
    }
}

/* Exponential media are bounded over pieces of bounded length, so that the bound stays close. */
static float exponential_majorant(const majorant_walk *walk, float t0, float *t1)
{
    float sum = 0.0f;
    for (uint64_t rest = walk->segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &walk->ray->media->regions[__builtin_ctzll(rest)];
        const air_medium *medium = &walk->ray->media->media[region->medium];
        if (medium->kind == AIR_DENSITY_EXPONENTIAL) {
            *t1 = fminf(*t1, air_exponential_piece(medium, walk->ray->origin, walk->ray->dir, t0));
        }
    }
    for (uint64_t rest = walk->segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &walk->ray->media->regions[__builtin_ctzll(rest)];
        const air_medium *medium = &walk->ray->media->media[region->medium];
        if (medium->kind == AIR_DENSITY_EXPONENTIAL) {
            sum += vec3_max(medium->sigma_t) * air_medium_most(medium) *
                   air_exponential_max(medium, walk->ray->origin, walk->ray->dir, t0, *t1);
        }
    }
    return sum;
}

static bool walk_next(majorant_walk *walk, float *t0, float *t1, float *majorant)
{
    if (!(walk->t < walk->t_end)) {
        return false;
    }
    *t0 = walk->t;
    *t1 = walk->t_end;
    *majorant = walk->constant;
    for (size_t g = 0; g < walk->grid_count; g++) {
        float begin;
        while (walk->grids[g].t1 <= walk->t &&
               air_grid_walk_next(&walk->grids[g].walk, &begin, &walk->grids[g].t1,
                                  &walk->grids[g].majorant)) {
        }
        if (walk->grids[g].t1 > walk->t) {
            *t1 = fminf(*t1, walk->grids[g].t1);
            *majorant += walk->grids[g].scale * walk->grids[g].majorant;
        }
    }
    if (walk->segment->exponential) {
        *majorant += exponential_majorant(walk, *t0, t1);
    }
    walk->t = *t1;
    return true;
}

/* The next tentative collision after *t within the piece that ends at t1; false if there is none.
 */
static bool fly(float *t, float t1, float majorant, air_rng *rng)
{
    if (majorant <= 0.0f) {
        return false;
    }
    *t -= logf(1.0f - air_rng_float(rng)) / majorant;
    return *t < t1;
}

/* Ends a running product by Russian roulette once it is small; false when it ended. */
static bool roulette(air_vec3 *product, air_rng *rng)
{
    const float largest = vec3_max(*product);
    if (largest >= 0.05f) {
        return true;
    }
    const float survive = fmaxf(largest * 5.0f, 0.05f);
    if (air_rng_float(rng) >= survive) {
        return false;
    }
    *product = vec3_scale(*product, 1.0f / survive);
    return true;
}

/* The optical depth of an untracked segment from its begin to t, in closed form. */
static air_vec3 closed_depth(const air_ray_media *ray, const air_ray_segment *segment, float t)
{
    return vec3_sub(air_ray_media_segment_depth(ray, segment, t), segment->depth);
}

/* product *= transmittance of a varying segment up to t_end; false when it became 0. */
static bool ratio_segment(const air_ray_media *ray, size_t index, float t_end, air_vec3 *product,
                          air_rng *rng)
{
    majorant_walk walk;
    float t0, t1, majorant;
    walk_start(&walk, ray, index, t_end);
    while (walk_next(&walk, &t0, &t1, &majorant)) {
        float t = t0;
        while (fly(&t, t1, majorant, rng)) {
            const air_vec3 sigma_t =
                air_ray_media_coefficients(ray, &ray->segments[index], t).sigma_t;
            *product =
                vec3_mul(*product, vec3_sub(vec3_set1(1.0f), vec3_scale(sigma_t, 1.0f / majorant)));
            if (vec3_is_zero(*product) || !roulette(product, rng)) {
                return false;
            }
        }
    }
    return true;
}

air_vec3 air_track_transmittance(const air_ray_media *ray, float t, air_rng *rng)
{
    if (ray->closed) {
        return vec3_exp(vec3_neg(air_ray_media_depth(ray, t)));
    }
    air_vec3 product = vec3_set1(1.0f);
    for (size_t i = 0; i < ray->count && ray->segments[i].t0 < t; i++) {
        const air_ray_segment *segment = &ray->segments[i];
        if (!segment->tracked) {
            const air_vec3 depth = closed_depth(ray, segment, fminf(segment->t1, t));
            product = vec3_mul(product, vec3_exp(vec3_neg(depth)));
        } else if (!ratio_segment(ray, i, t, &product, rng)) {
            return vec3_set1(0.0f);
        }
    }
    return product;
}

/* Collisions are forced at least this often per metre of an emissive segment, so that emission
 * without extinction is found too. */
static float emission_rate(const air_ray_segment *segment)
{
    return 2.0f / fmaxf(segment->t1 - segment->t0, 1e-6f);
}

air_vec3 air_track_emission(const air_ray_media *ray, air_rng *rng)
{
    air_vec3 sum = vec3_set1(0.0f), product = vec3_set1(1.0f);
    for (size_t i = 0; i < ray->count; i++) {
        majorant_walk walk;
        float t0, t1, majorant;
        walk_start(&walk, ray, i, ray->segments[i].t1);
        while (walk_next(&walk, &t0, &t1, &majorant)) {
            float t = t0;
            majorant += emission_rate(&ray->segments[i]);
            while (fly(&t, t1, majorant, rng)) {
                const air_coefficients c = air_ray_media_coefficients(ray, &ray->segments[i], t);
                sum = vec3_add(sum, vec3_scale(vec3_mul(product, c.emission), 1.0f / majorant));
                product = vec3_mul(
                    product, vec3_sub(vec3_set1(1.0f), vec3_scale(c.sigma_t, 1.0f / majorant)));
                if (vec3_is_zero(product) || !roulette(&product, rng)) {
                    return sum;
                }
            }
        }
    }
    return sum;
}

/* Real with a probability that follows the throughput-weighted mean of sigma_t / majorant; returns
 * whether it was real and updates the weight. */
static bool collide(air_vec3 sigma_t, float majorant, air_vec3 throughput, air_vec3 *weight,
                    air_rng *rng)
{
    const air_vec3 now = vec3_mul(throughput, *weight);
    const float total = now.x + now.y + now.z;
    const float mean = total > 0.0f ? vec3_dot(now, sigma_t) / total : vec3_mean(sigma_t);
    const float real = fminf(mean / majorant, 1.0f);
    if (air_rng_float(rng) < real) {
        *weight = vec3_scale(*weight, 1.0f / (majorant * real));
        return true;
    }
    const air_vec3 null = vec3_sub(vec3_set1(majorant), sigma_t);
    *weight = vec3_mul(*weight, vec3_scale(null, 1.0f / (majorant * (1.0f - real))));
    return false;
}

/* Through an untracked segment in one step: free flight in a channel chosen by throughput, all
 * channels in the density, of passing too. */
static bool collide_closed(const air_ray_media *ray, size_t index, air_vec3 throughput,
                           air_collision *out, air_rng *rng)
{
    const air_ray_segment *segment = &ray->segments[index];
    const air_vec3 now = vec3_mul(throughput, out->weight);
    const float total = now.x + now.y + now.z;
    const float u = air_rng_float(rng) * total;
    const int channel = u < now.x ? 0 : u < now.x + now.y ? 1 : 2;
    const float flight = -logf(1.0f - air_rng_float(rng));
    const air_vec3 whole = closed_depth(ray, segment, segment->t1);
    out->happened = flight < air_channel(whole, channel);
    air_vec3 depth = whole;
    float scale = 1.0f;
    if (out->happened) {
        out->segment = index;
        out->t = air_ray_media_invert_segment(ray, segment, channel,
                                              air_channel(segment->depth, channel) + flight);
        depth = closed_depth(ray, segment, out->t);
    }
    const air_vec3 transmittance = vec3_exp(vec3_neg(depth));
    air_vec3 density = transmittance;
    if (out->happened) {
        density = vec3_mul(density, air_ray_media_coefficients(ray, segment, out->t).sigma_t);
    }
    const float pdf = vec3_dot(now, density);
    scale = pdf > 0.0f ? total / pdf : 0.0f;
    out->weight = vec3_scale(vec3_mul(out->weight, transmittance), scale);
    return out->happened;
}

air_collision air_track_collision(const air_ray_media *ray, air_vec3 throughput, air_rng *rng)
{
    air_collision out = {false, 0.0f, 0, vec3_set1(1.0f)};
    for (size_t i = 0; i < ray->count; i++) {
        majorant_walk walk;
        float t0, t1, majorant;
        if (!ray->segments[i].tracked) {
            if (collide_closed(ray, i, throughput, &out, rng)) {
                return out;
            }
            continue;
        }
        walk_start(&walk, ray, i, ray->segments[i].t1);
        while (walk_next(&walk, &t0, &t1, &majorant)) {
            float t = t0;
            while (fly(&t, t1, majorant, rng)) {
                const air_vec3 sigma_t =
                    air_ray_media_coefficients(ray, &ray->segments[i], t).sigma_t;
                if (collide(sigma_t, majorant, throughput, &out.weight, rng)) {
                    out.happened = true;
                    out.t = t;
                    out.segment = i;
                    return out;
                }
            }
        }
    }
    return out;
}

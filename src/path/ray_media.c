#include "path/ray_media.h"

#include "core/exponential.h"

air_vec3 air_ray_media_exponential_depth(const air_ray_media *ray, const air_ray_segment *segment,
                                         float t)
{
    air_vec3 depth = vec3_set1(0.0f);
    for (uint64_t rest = segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &ray->media->regions[__builtin_ctzll(rest)];
        const air_medium *medium = &ray->media->media[region->medium];
        if (medium->kind == AIR_DENSITY_EXPONENTIAL) {
            const float length =
                air_exponential_depth(medium, ray->origin, ray->dir, segment->t0, t);
            depth = vec3_madd(depth, length, medium->sigma_t);
        }
    }
    return depth;
}

/* What one medium adds to a segment. */
static void gather_region(air_ray_media *ray, const air_region *region, air_ray_segment *segment)
{
    const air_medium *medium = &ray->media->media[region->medium];
    ray->emits = ray->emits || !vec3_is_zero(medium->emission);
    ray->scatters = ray->scatters || !vec3_is_zero(medium->sigma_s);
    if (region->constant) {
        segment->sigma_s = vec3_add(segment->sigma_s, region->sigma_s);
        segment->sigma_t = vec3_add(segment->sigma_t, region->sigma_t);
        segment->emission = vec3_add(segment->emission, region->emission);
    } else {
        segment->exponential = segment->exponential || medium->kind == AIR_DENSITY_EXPONENTIAL;
        segment->tracked =
            segment->tracked || medium->kind == AIR_DENSITY_GRID || air_medium_is_detailed(medium);
    }
}

/* Sums the constant media of the segment and notes what else there is. */
static void gather(air_ray_media *ray, air_ray_segment *segment)
{
    segment->sigma_s = segment->sigma_t = segment->emission = vec3_set1(0.0f);
    segment->exponential = segment->tracked = false;
    for (uint64_t rest = segment->regions; rest != 0; rest &= rest - 1) {
        gather_region(ray, &ray->media->regions[__builtin_ctzll(rest)], segment);
    }
}

static void finish_depth(air_ray_media *ray)
{
    air_transmittance_and_loss(ray->depth.x, &ray->transmittance.x, &ray->loss.x);
    if (ray->grey) {
        ray->transmittance = vec3_set1(ray->transmittance.x);
        ray->loss = vec3_set1(ray->loss.x);
    } else {
        air_transmittance_and_loss(ray->depth.y, &ray->transmittance.y, &ray->loss.y);
        air_transmittance_and_loss(ray->depth.z, &ray->transmittance.z, &ray->loss.z);
    }
}

void air_ray_media_make(air_ray_media *ray, const air_media *media, air_vec3 origin, air_vec3 dir,
                        float tmax)
{
    air_segment found[AIR_MAX_SEGMENTS];
    ray->media = media;
    ray->origin = origin;
    ray->dir = dir;
    ray->count = air_media_segments(media, origin, dir, float_min(tmax, AIR_FAR), found);
    ray->closed = true;
    ray->grey = true;
    ray->scatters = ray->emits = false;
    ray->depth = ray->loss = vec3_set1(0.0f);
    ray->transmittance = vec3_set1(1.0f);
    for (size_t i = 0; i < ray->count; i++) {
        air_ray_segment *segment = &ray->segments[i];
        segment->t0 = found[i].t0;
        segment->t1 = found[i].t1;
        segment->regions = found[i].regions;
        gather(ray, segment);
        ray->closed = ray->closed && !segment->tracked;
        segment->depth = ray->depth;
        if (!segment->tracked) {
            ray->depth = air_ray_media_segment_depth(ray, segment, segment->t1);
            ray->grey = ray->grey && ray->depth.x == ray->depth.y && ray->depth.x == ray->depth.z;
        }
    }
    if (ray->count > 0 && ray->closed) {
        finish_depth(ray);
    }
}

/* The optical depth of a whole ray through media of constant density. */
static air_vec3 constant_depth(const air_media *media, air_vec3 origin, air_vec3 dir, float tmax)
{
    if (air_media_fill_space(media)) {
        return vec3_scale(media->regions[0].sigma_t, tmax);
    }
    air_segment found[AIR_MAX_SEGMENTS];
    const size_t count = air_media_segments(media, origin, dir, tmax, found);
    air_vec3 depth = vec3_set1(0.0f);
    for (size_t i = 0; i < count; i++) {
        for (uint64_t rest = found[i].regions; rest != 0; rest &= rest - 1) {
            const air_region *region = &media->regions[__builtin_ctzll(rest)];
            depth = vec3_madd(depth, found[i].t1 - found[i].t0, region->sigma_t);
        }
    }
    return depth;
}

air_vec3 air_constant_transmittance(const air_media *media, air_vec3 origin, air_vec3 dir,
                                    float tmax)
{
    const air_vec3 depth = constant_depth(media, origin, dir, float_min(tmax, AIR_FAR));
    if (depth.x == depth.y && depth.x == depth.z) {
        return vec3_set1(air_exp(-depth.x));
    }
    return vec3(air_exp(-depth.x), air_exp(-depth.y), air_exp(-depth.z));
}

size_t air_ray_media_find(const air_ray_media *ray, float t)
{
    for (size_t i = 0; i < ray->count; i++) {
        if (t < ray->segments[i].t1) {
            return t >= ray->segments[i].t0 ? i : ray->count;
        }
    }
    return ray->count;
}

air_vec3 air_ray_media_depth(const air_ray_media *ray, float t)
{
    for (size_t i = ray->count; i-- > 0;) {
        const air_ray_segment *segment = &ray->segments[i];
        if (t > segment->t0) {
            return air_ray_media_segment_depth(ray, segment, float_min(t, segment->t1));
        }
    }
    return vec3_set1(0.0f);
}

/* Bisection kept inside its bracket by Newton steps where they stay in it: the depth is increasing,
 * its derivative is sigma_t. */
static float invert_exponential(const air_ray_media *ray, const air_ray_segment *segment,
                                int channel, float depth)
{
    float low = segment->t0, high = segment->t1;
    float t = 0.5f * (low + float_min(high, low + 1e6f));
    for (int step = 0; step < 64 && high - low > 1e-6f * high; step++) {
        const float error =
            air_channel(air_ray_media_segment_depth(ray, segment, t), channel) - depth;
        if (error > 0.0f) {
            high = t;
        } else {
            low = t;
        }
        const float slope =
            air_channel(air_ray_media_coefficients(ray, segment, t).sigma_t, channel);
        const float newton = t - error / slope;
        if (fabsf(error) <= 1e-6f * depth) {
            break;
        }
        t = newton > low && newton < high ? newton : 0.5f * (low + high);
    }
    return t;
}

float air_ray_media_invert_segment(const air_ray_media *ray, const air_ray_segment *segment,
                                   int channel, float depth)
{
    if (segment->exponential) {
        return invert_exponential(ray, segment, channel, depth);
    }
    const float rest = float_max(depth - air_channel(segment->depth, channel), 0.0f);
    const float sigma = air_channel(segment->sigma_t, channel);
    const float t = sigma > 0.0f ? segment->t0 + rest / sigma : segment->t1;
    return float_min(t, segment->t1);
}

float air_ray_media_invert(const air_ray_media *ray, int channel, float depth, size_t *out_segment)
{
    size_t i = ray->count - 1;
    while (i > 0 && depth < air_channel(ray->segments[i].depth, channel)) {
        i--;
    }
    *out_segment = i;
    return air_ray_media_invert_segment(ray, &ray->segments[i], channel, depth);
}

air_coefficients air_ray_media_coefficients(const air_ray_media *ray,
                                            const air_ray_segment *segment, float t)
{
    air_coefficients sum = {segment->sigma_s, segment->sigma_t, segment->emission};
    if (!segment->exponential && !segment->tracked) {
        return sum;
    }
    const air_vec3 point = vec3_madd(ray->origin, t, ray->dir);
    for (uint64_t rest = segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &ray->media->regions[__builtin_ctzll(rest)];
        if (region->constant) {
            continue;
        }
        const air_coefficients c =
            air_medium_coefficients(&ray->media->media[region->medium], region, point);
        sum.sigma_s = vec3_add(sum.sigma_s, c.sigma_s);
        sum.sigma_t = vec3_add(sum.sigma_t, c.sigma_t);
        sum.emission = vec3_add(sum.emission, c.emission);
    }
    return sum;
}

/* Integral of exp(-sigma s) over [0, length]. */
static float slab_integral(float sigma, float length)
{
    const float x = sigma * length;
    return x > 1e-4f ? -expm1f(-x) / sigma : length * (1.0f - 0.5f * x);
}

air_vec3 air_ray_media_emission(const air_ray_media *ray)
{
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < ray->count; i++) {
        const air_ray_segment *s = &ray->segments[i];
        const float length = s->t1 - s->t0;
        const air_vec3 integral =
            vec3(slab_integral(s->sigma_t.x, length), slab_integral(s->sigma_t.y, length),
                 slab_integral(s->sigma_t.z, length));
        const air_vec3 local = vec3_mul(s->emission, integral);
        sum = vec3_add(sum, vec3_mul(vec3_exp(vec3_neg(s->depth)), local));
    }
    return sum;
}

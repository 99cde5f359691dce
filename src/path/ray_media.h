/* ray_media.h: the media along one ray, and their optical depth in closed form where there is one.
 *
 * "Closed" segments hold constant and exponential media only: their optical depth is known exactly.
 * Segments with grids or with detail are "tracked": see tracking.h. */
#ifndef AIR_PATH_RAY_MEDIA_H
#define AIR_PATH_RAY_MEDIA_H

#include "scene/media/field.h"
#include "scene/media/media.h"

/* What stands for infinity as a distance: products with 0 stay 0. */
#define AIR_FAR 1e30f

typedef struct air_ray_segment {
    float t0, t1;
    uint64_t regions;
    air_vec3 sigma_s, sigma_t, emission; /* of the constant media together */
    air_vec3 depth;                      /* optical depth of untracked segments before t0 */
    bool exponential;                    /* some exponential medium is present */
    bool tracked;                        /* some grid or detail is present */
} air_ray_segment;

typedef struct air_ray_media {
    const air_media *media;
    air_vec3 origin, dir; /* dir is unit */
    size_t count;
    bool closed;   /* no segment is tracked */
    bool grey;     /* one optical depth serves all three channels (closed rays) */
    bool scatters; /* some coefficient sigma_s is positive */
    bool emits;
    air_vec3 depth;               /* total; closed rays only, as are the next two */
    air_vec3 transmittance, loss; /* exp(-depth) and 1 - exp(-depth) */
    air_ray_segment segments[AIR_MAX_SEGMENTS];
} air_ray_media;

/* Lays the media along the ray out to tmax (INFINITY is legal). */
void air_ray_media_make(air_ray_media *ray, const air_media *media, air_vec3 origin, air_vec3 dir,
                        float tmax);

/* Transmittance over a whole ray through media of constant density (media->all_constant), without
 * laying it out. */
air_vec3 air_constant_transmittance(const air_media *media, air_vec3 origin, air_vec3 dir,
                                    float tmax);

/* Optical depth per channel from the origin to t, t >= 0; the ray must be closed. */
air_vec3 air_ray_media_depth(const air_ray_media *ray, float t);

/* What the exponential media of a segment add between its begin and t. */
air_vec3 air_ray_media_exponential_depth(const air_ray_media *ray, const air_ray_segment *segment,
                                         float t);

/* Optical depth from the origin to t, which lies in this segment. */
static inline air_vec3 air_ray_media_segment_depth(const air_ray_media *ray,
                                                   const air_ray_segment *segment, float t)
{
    const air_vec3 depth = vec3_madd(segment->depth, t - segment->t0, segment->sigma_t);
    return segment->exponential ? vec3_add(depth, air_ray_media_exponential_depth(ray, segment, t))
                                : depth;
}

/* The distance at which the optical depth of a channel reaches `depth`, and the segment it lies in;
 * depth must be below the total. The ray must be closed. */
float air_ray_media_invert(const air_ray_media *ray, int channel, float depth, size_t *out_segment);

/* The same within one untracked segment, which need not be of a closed ray; depth counts from
 * where segment->depth does. */
float air_ray_media_invert_segment(const air_ray_media *ray, const air_ray_segment *segment,
                                   int channel, float depth);

/* The segment that holds t; count if none does. */
size_t air_ray_media_find(const air_ray_media *ray, float t);

/* Coefficients at distance t in a segment, all media together. */
air_coefficients air_ray_media_coefficients(const air_ray_media *ray,
                                            const air_ray_segment *segment, float t);

/* Radiance that constant emissive media of a closed ray without exponential media send to its
 * origin. */
air_vec3 air_ray_media_emission(const air_ray_media *ray);

static inline float air_channel(air_vec3 v, int channel)
{
    return channel == 0 ? v.x : channel == 1 ? v.y : v.z;
}

#endif

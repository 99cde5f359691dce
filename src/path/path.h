/* path.h: the reference: unbiased volumetric path tracing of a block of samples at once.
 *
 * Sixteen camera samples of one pixel go together through the stages trace, scatter, connect, so
 * that rays meet the scene in packets. What one sample gives does not depend on the fifteen others.
 */
#ifndef AIR_PATH_PATH_H
#define AIR_PATH_PATH_H

#include "airlight/render.h"
#include "core/sobol.h"
#include "path/ray_media.h"
#include "scene/surface.h"

enum { AIR_PATH_LANES = 16 };

typedef struct air_path_settings {
    uint32_t max_depth;
    /* wanted[(light_owner * (medium_count + 1) + medium) * AIR_TERM_COUNT + term]: what path is to
     * compute; medium_count stands for no medium. Borrowed. NULL: all of it. */
    const uint8_t *wanted;
    uint32_t terms; /* mask over everything, emission and background too */
    bool guides;
    void (*vertex_hook)(void *user, size_t x, size_t y, uint32_t sample,
                        const air_path_vertex *vertex);
    void *vertex_hook_user;
} air_path_settings;

/* What is the same for all samples of a render. */
typedef struct air_path {
    const air_snapshot *snapshot;
    const air_ray_backend *rays;
    const air_sobol *sobol;
    air_path_settings settings;
    bool hittable_lights; /* some light can be met by a sampled direction, or some medium emits */
    bool emissive_media;
    bool pervious;     /* some mesh casts no shadow: then shadow rays see what directions do not */
    bool whole_volume; /* the media are one convex region of constant density: distances can follow
                          lights from infinity in closed form */
    air_collimated_medium volume; /* that region */
    bool extended_lights;         /* some light has an area or fills directions */
    /* The lights asked for at first events: the snapshot's, less those that are wholly other
     * methods' there. A view: only its cdf may be its own. */
    air_light_table first_lights;
    float *first_cdf; /* owned; NULL: the snapshot's */
} air_path;

/* On failure the path is as after air_path_finish. */
air_status air_path_init(air_path *path, const air_snapshot *snapshot, const air_sobol *sobol,
                         const air_path_settings *settings);
void air_path_finish(air_path *path);

/* One camera sample: in and out. */
typedef struct air_path_lane {
    air_vec3 origin, dir;
    air_sampler sampler;
    float u_distance,
        u_pick;   /* the last two numbers of the sampler's set 0; the first two chose the ray */
    float u_beam; /* for what the collimated method draws */
    uint32_t x, y, sample;
    air_hit hit; /* what the camera's ray met, transparent surfaces passed */
    air_vec3 terms[AIR_TERM_COUNT];
    air_vec3 albedo, normal;
    float depth; /* of the first surface, 0 if there is none */
} air_path_lane;

typedef struct air_path_scratch air_path_scratch; /* one per worker */
size_t air_path_scratch_size(void);

/* The product of 1 - alpha over the surfaces with coverage that a shadow ray meets. */
float air_path_alpha_transmittance(const air_path *path, const air_ray *shadow_ray);

/* What surfaces let through of shadow rays: 0 where one is in the way, else the product of 1 -
 * alpha over those with coverage; 1 for rays whose mask is 0. occluded: scratch of `count` bytes.
 */
void air_path_shares(const air_path *path, const air_ray *rays, size_t count, uint8_t *occluded,
                     float *out_shares);

/* Traces lanes[0..count), count <= AIR_PATH_LANES; the terms, guides included, are overwritten. */
void air_path_trace(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                    size_t count);

#endif

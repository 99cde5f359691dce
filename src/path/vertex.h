/* vertex.h: the state of a walk: the ray under way, the vertex it arrived at, the light asked for
 * there. */
#ifndef AIR_PATH_VERTEX_H
#define AIR_PATH_VERTEX_H

#include "path/path.h"

/* Two walks can start from one camera sample: from the surface it sees, and from the medium before
 * it. A medium event can have two vertices: one to go on from, one to ask for light at. */
enum {
    PATH_MOST_WINDOWS = 64, /* stretches of a ray that a light's windows may leave open */
    AIR_PATH_WALKS = 2 * AIR_PATH_LANES,
    AIR_PATH_VERTICES = 2 * AIR_PATH_WALKS,
    AIR_NO_MEDIUM = 0xffff
};

/* What stays the same along a walk, and what changes with each event. */
typedef struct path_walk {
    uint32_t lane;
    uint32_t depth;        /* events so far */
    uint32_t first_medium; /* of the first event; AIR_NO_MEDIUM if it was on a surface */
    uint32_t branch;       /* 0: started on a surface, 1: in a medium */
    air_vec3 beta; /* throughput, for a medium vertex still without sigma_s and phase function */
    float pdf_dir; /* density of the direction under way, per solid angle; 0 from the camera */
} path_walk;

typedef struct path_vertex {
    path_walk walk;
    bool on_surface;
    bool ends;         /* light is asked for, the walk goes on elsewhere */
    float light_share; /* factor on the light asked for */
    air_vec3 wo;       /* towards where the walk came from */
    union {
        air_surface surface;
        struct {
            air_vec3 position;
            uint64_t regions;
            float light_probability;
            air_light_point
                light; /* drawn before the distance was; unless the scene has no lights */
        } medium;
    } at;
} path_vertex;

/* A light connection waiting for its shadow ray. */
typedef struct path_shadow {
    air_vec3 value; /* what the lane gains if nothing is in between */
    uint32_t lane;
    uint32_t term;
    uint32_t stream; /* of random numbers, should the way be tracked */
    bool tracked;    /* value is still without the transmittance */
    float distance;  /* to the light, over which the media act */
} path_shadow;

struct air_path_scratch {
    air_ray rays[AIR_PATH_WALKS];
    air_hit hits[AIR_PATH_WALKS];
    path_walk walks[AIR_PATH_WALKS];
    path_vertex vertices[AIR_PATH_VERTICES];
    path_shadow shadows[AIR_PATH_VERTICES];
    air_ray shadow_rays[AIR_PATH_VERTICES];
    uint8_t occluded[AIR_PATH_VERTICES];
    float shares[AIR_PATH_VERTICES]; /* visible */
    size_t vertex_count, walk_count, shadow_count;
    air_ray_media media; /* along the ray that is looked at */
    /* What a light from infinity would send along it; before and after windows are cut out. */
    air_collimated_piece pieces[2][AIR_COLLIMATED_MAX_PIECES + PATH_MOST_WINDOWS];
    air_interval windows[PATH_MOST_WINDOWS];
    air_collimated_profile profile;
};

/* The sets of random numbers. Set 0 belongs to the camera sample: x, y, distance, light of the
 * first medium event. An event has two: one for the distance that led to it, the light and the
 * point on it; one for the direction that leaves it. */
static inline uint32_t path_light_set(const path_walk *walk)
{
    return walk->depth <= 1 ? 1 + walk->branch : 5 + ((walk->depth - 2) * 2 + walk->branch) * 2;
}

static inline uint32_t path_direction_set(const path_walk *walk)
{
    return walk->depth <= 1 ? 3 + walk->branch : path_light_set(walk) + 1;
}

/* A light that a sampled direction meets too, seen by it as by a shadow ray: the two are then
 * combined. */
static inline bool path_hittable(const air_path *path, uint32_t entry)
{
    const air_light_table *lights = &path->snapshot->lights;
    const air_light *light = &lights->entries[entry];
    return !path->pervious && light->casts_shadow &&
           (light->kind == AIR_LIGHT_ENVIRONMENT ||
            (light->kind == AIR_LIGHT_POLYGON &&
             (light->camera_visible || entry >= lights->explicit_count)));
}

/* The lights that a vertex of this depth asks. */
static inline const air_light_table *path_lights(const air_path *path, uint32_t depth)
{
    return depth == 1 ? &path->first_lights : &path->snapshot->lights;
}

static inline air_term path_term(const path_walk *walk)
{
    if (walk->depth == 1) {
        return walk->branch == 0 ? AIR_TERM_S0 : AIR_TERM_M1;
    }
    return walk->branch == 0 ? AIR_TERM_S_PLUS : AIR_TERM_M2;
}

/* Is the light's share of this walk's term path's to compute? */
static inline bool path_wanted(const air_path *path, uint32_t light_owner, uint32_t medium,
                               air_term term)
{
    if (((path->settings.terms >> term) & 1u) == 0) {
        return false;
    }
    if (path->settings.wanted == NULL) {
        return true;
    }
    const size_t media = path->snapshot->media.count;
    const size_t row = light_owner * (media + 1) + (medium == AIR_NO_MEDIUM ? media : medium);
    return path->settings.wanted[row * AIR_TERM_COUNT + term] != 0;
}

/* The media at a medium vertex with their sigma_s: a mixture of phase functions. */
typedef struct path_mixture {
    size_t count;
    float total; /* of the shares before normalisation */
    struct {
        uint32_t medium;
        air_vec3 sigma_s;
        float share; /* probability of sampling this one */
    } parts[AIR_MAX_REGIONS];
} path_mixture;

void path_mixture_make(const air_path *path, const path_vertex *vertex, path_mixture *out);

/* Chooses a light by power, and a point on it, for an event; the light table must not be empty. */
void path_draw_light(const air_path *path, const air_path_lane *lane, const path_walk *walk,
                     air_light_point *out_point, float *out_probability);

/* Asks for light at a vertex: queues at most one shadow ray. */
void path_gather(const air_path *path, air_path_scratch *scratch, const air_path_lane *lanes,
                 const path_vertex *vertex, const path_mixture *mixture);

/* Sends the queued shadow rays and adds what arrives. */
void path_connect(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes);

/* Nearest hits of scratch->rays[0..count), past surfaces that are transparent where they are met.
 */
void path_intersect(const air_path *path, air_path_scratch *scratch, const air_path_lane *lanes,
                    size_t count);

#endif

/* vertex.h: the state of a walk: the ray under way, the vertex it arrived at, the light asked for
 * there. */
#ifndef AIR_PATH_VERTEX_H
#define AIR_PATH_VERTEX_H

#include "path/path.h"
#include "path/receiver.h"

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
    uint32_t branch;       /* 0: started on a surface, 1: in a medium; of walks from receivers: 1
                              once they were in a medium */
    bool received;         /* the walk started at a receiver */
    bool from_surface;     /* the ray under way left a surface */
    bool through;          /* a ray from a receiver that looks for one event in media only */
    air_vec3 beta; /* throughput, for a medium vertex still without sigma_s and phase function */
    float dense; /* what indices of refraction have made of throughput, which is not lost: 1 / ior^2
                    inside glass */
    /* With air_path_respond: throughput of light that media scattered on the way (beta is that of
     * the rest), the normal that the ray under way left, and what a unit of irradiance there
     * brings. */
    air_vec3 scattered, normal, flat;
    float
        pdf_dir; /* density of the direction under way, per solid angle; 0 from the camera, and
                    after a choice of single directions: then no light that is met was asked for */
} path_walk;

typedef struct path_vertex {
    path_walk walk;
    bool on_surface;
    bool receives;     /* a receiver: at.surface has position, normals and offset only */
    bool ends;         /* light is asked for, the walk goes on elsewhere */
    bool gathers;      /* a medium's point that sends what the source says */
    bool numbered;     /* its light set was drawn from before: light_numbers */
    float light_share; /* factor on the light asked for */
    float light_numbers[4];
    air_vec3 wo; /* towards where the walk came from */
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

/* All that is not so unless said. */
static inline void path_vertex_begin(path_vertex *vertex, bool on_surface)
{
    vertex->on_surface = on_surface;
    vertex->receives = vertex->gathers = vertex->ends = vertex->numbered = false;
    vertex->light_share = 1.0f;
}

/* What path_draw_light takes as known. */
static inline const float *path_light_numbers(const path_vertex *vertex)
{
    return vertex->numbered ? vertex->light_numbers : NULL;
}

/* Where a shadow ray's light goes: an air_term, or one of these. */
enum { PATH_TO_RECEIVER = AIR_TERM_COUNT, PATH_THROUGH };

/* A light connection waiting for its shadow ray. */
typedef struct path_shadow {
    air_vec3 value; /* what the lane gains if nothing is in between */
    /* With air_path_respond: what media scatter of the light on its way, likewise; and what of the
     * light they scatter later, to M2. */
    air_vec3 scattered, carried;
    bool lit; /* likewise, of a receiver, whose lane has it */
    uint32_t lane;
    uint32_t target;
    uint32_t stream; /* of random numbers, should the way be tracked */
    bool late;       /* value is still without the transmittance */
    bool paired;     /* the next shadow ray is the way's other part; it carries no value itself */
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

/* The share of a way to find a light, of density `own` > 0, where another finds it with density
 * `other`: the power heuristic [Veach1995]. */
static inline float path_share(float own, float other)
{
    const float ratio = other / own;
    return 1.0f / (1.0f + ratio * ratio);
}

/* A receiver's walk at its next event, in media. */
static inline path_walk path_event_walk(const path_walk *walk)
{
    path_walk event = *walk;
    event.depth++;
    event.branch = 1;
    return event;
}

/* For the way through media: where the event is. Its light is drawn by the light set of the event.
 */
static inline uint32_t path_through_set(const path_walk *walk)
{
    const path_walk event = path_event_walk(walk);
    return path_direction_set(&event);
}

/* The lights that a vertex of this depth asks. */
static inline const air_light_table *path_lights(const air_path *path, uint32_t depth,
                                                 bool on_surface)
{
    return &path->lights[depth == 1][on_surface];
}

/* Is this walk's light asked for through.c's way? */
static inline bool path_goes_through(const air_path *path, const path_walk *walk)
{
    return path->settings.source.through && walk->received && !walk->through && walk->depth == 2 &&
           walk->branch == 1;
}

static inline air_term path_term(const path_walk *walk)
{
    if (walk->depth == 1) {
        return walk->branch == 0 ? AIR_TERM_S0 : AIR_TERM_M1;
    }
    if (walk->received && walk->depth == 2 && walk->branch == 1) {
        return AIR_TERM_M1;
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
    const size_t media = path->media->count;
    const size_t row = light_owner * (media + 1) + (medium == AIR_NO_MEDIUM ? media : medium);
    return path->settings.wanted[row * AIR_TERM_COUNT + term] != 0;
}

/* A stream for one purpose of the ray under way. The camera's ray has one of its own: a tracked ray
 * that leaves the surface must not repeat the numbers that let the camera's ray reach it. */
static inline air_rng path_ray_rng(const air_path_lane *lane, const path_walk *walk,
                                   uint32_t purpose)
{
    return air_sampler_rng(&lane->sampler, purpose + walk->depth * 2 + walk->branch);
}

/* The vertex at which the next event will be written; the surface a ray ends on is made there at
 * once. */
static inline path_vertex *path_next_vertex(air_path_scratch *scratch)
{
    return &scratch->vertices[scratch->vertex_count];
}

/* ---- emitters that a ray meets: each adds what it sends along the ray ---- */

void path_add_environments(const air_path *path, const path_walk *walk, const air_ray *ray,
                           air_vec3 transmittance, air_path_lane *lane);
void path_add_surface_emission(const air_path *path, const path_walk *walk, const air_ray *ray,
                               const air_hit *hit, const air_surface *surface,
                               air_vec3 transmittance, air_path_lane *lane);
/* Polygon lights stop nothing; each one the ray crosses adds its radiance. */
void path_add_polygon_lights(const air_path *path, const path_walk *walk, const air_ray *ray,
                             float tmax, const air_ray_media *media, air_path_lane *lane);
void path_add_media_emission(const air_path *path, const path_walk *walk,
                             const air_ray_media *media, air_path_lane *lane);

/* The events of a walk's ray, whose media are scratch->media: none, one, or more vertices. met: a
 * surface lies at its end at t, and has been made at the next vertex; transmittance: of the whole
 * ray, where it is closed or no event can be in the media. */
void path_events(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                 const air_ray *ray, bool met, float t, air_vec3 transmittance,
                 air_path_lane *lane);

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

/* Chooses a light by power, and a point on it, for an event; the light table must not be empty.
 * known: the numbers of the walk's light set, or NULL. */
void path_draw_light(const air_path *path, const air_light_table *lights, const air_path_lane *lane,
                     const path_walk *walk, const float *known, air_light_point *out_point,
                     float *out_probability);

static inline bool path_responds(const air_path *path)
{
    return path->settings.respond.patch != NULL && path->media->region_count > 0;
}

/* A ray has arrived at a surface at t, its media laid out: what they scatter of the light that
 * comes back along it goes into the walk, or, of a receiver's first ray, into the lane. */
void path_respond_patch(const air_path *path, const air_path_scratch *scratch, const air_ray *ray,
                        const air_surface *surface, float t, path_walk *walk, air_path_lane *lane);
/* What they scatter of the light that a connection brings: of a receiver into its lane, else into
 * the shadow. The way is laid out in scratch->media. */
void path_respond_light(const air_path *path, air_path_scratch *scratch, const path_vertex *vertex,
                        const air_light_point *light, const air_connection *connection,
                        float probability, air_path_lane *lane, path_shadow *shadow);

/* Asks for light at a vertex: queues at most one shadow ray. */
void path_gather(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                 const path_vertex *vertex, const path_mixture *mixture);

/* Light by one event in the media between a light and the receiver at the vertex: queues shadow
 * rays, or a ray that looks where the event could be. */
void path_ask_through(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                      const path_vertex *vertex);
/* That ray has arrived at t. */
void path_arrive_through(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                         const air_ray *ray, float t, air_path_lane *lane);

/* sigma_s times phase function towards wi of those media of a mixture whose light is wanted.
 * out_pdf (may be NULL): the density of sampling wi. */
air_vec3 path_mixture_eval(const air_path *path, const path_vertex *vertex,
                           const path_mixture *mixture, air_vec3 wi, uint32_t light_owner,
                           float *out_pdf);
/* Multiplies value by the transmittance of the ray up to distance, in closed form if possible; says
 * whether it was. If not, scratch->media is that ray's. */
bool path_attenuate_closed(const air_path *path, air_path_scratch *scratch, const air_ray *ray,
                           float distance, air_vec3 *value);
/* The same where it is cheap. If not, path_connect does it where the ray arrives. */
bool path_attenuate(const air_path *path, air_path_scratch *scratch, const air_ray *ray,
                    float distance, air_vec3 *value);
air_ray path_shadow_ray(const path_vertex *vertex, const air_connection *connection,
                        const air_light_point *light);

/* Sends the queued shadow rays and adds what arrives. */
void path_connect(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes);

/* Nearest hits of scratch->rays[0..count), past surfaces that are transparent where they are met.
 */
void path_intersect(const air_path *path, air_path_scratch *scratch, const air_path_lane *lanes,
                    size_t count);

#endif

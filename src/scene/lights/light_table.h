/* light_table.h: all lights of a snapshot as one table of entries: explicit lights in the order
 * they were added, then one entry per emissive triangle, sphere, cylinder or disk.
 *
 * Sampling has two steps, so that distances can be sampled knowing the light: air_light_sample
 * draws a point (or, at infinity, a direction) without knowing what it lights; air_light_connect
 * then evaluates it at a shaded point. */
#ifndef AIR_SCENE_LIGHTS_LIGHT_TABLE_H
#define AIR_SCENE_LIGHTS_LIGHT_TABLE_H

#include "airlight/interval.h"
#include "airlight/light.h"
#include "core/host.h"
#include "core/quadric.h"
#include "core/vec.h"

typedef struct air_light {
    char *name;          /* of explicit lights, "" if none was given; NULL for emissive surfaces */
    air_light_kind kind; /* emissive triangles: AIR_LIGHT_POLYGON with vertex_count 3; quadrics:
                            AIR_LIGHT_POLYGON without vertices or triangles */
    air_vec3 color;
    air_vec3 position; /* point, spot, projector */
    air_vec3 dir;      /* unit, direction of travel: spot, collimated */
    air_frame frame;   /* collimated: of dir, in which windows are 2-D; projector: of its picture,
                          to the right, up, and against the light */
    float tan_half[2]; /* projector: of half the angles that width and height fill */
    air_spot_shape falloff;
    float spot_scale,
        spot_offset;     /* COSINE: clamp(cos*scale + offset, 0, 1)^2, as
                            KHR_lights_punctual; ANGLE: clamp(angle*scale + offset, 0, 1) */
    double *windows;     /* collimated: concatenated 2-D vertices in (frame.s, frame.t) */
    size_t *window_ends; /* one past the last vertex of each window */
    size_t window_count;
    air_vec3 *vertices; /* polygon: its vertices; normal is their front side */
    size_t vertex_count;
    air_vec3 (*triangles)[3]; /* polygon: its triangulation (concave polygons too) */
    float *triangle_cdf;      /* cumulative area share; last is 1 */
    size_t triangle_count;
    air_vec3 normal;
    const air_quadric *quadric; /* emissive quadrics: borrowed; else NULL */
    bool inward;                /* quadrics: the front is where the normal points away from */
    float area;
    bool one_sided, camera_visible, casts_shadow;
    struct air_environment *environment;        /* environment with an image */
    const struct air_texture *emission_texture; /* emissive surfaces: radiance = color *
                                                   texture(uv); projector: its picture; borrowed */
    float uv[3][2]; /* already transformed; of quadrics, of (0, 0), (1, 0) and (0, 1) */
    uint32_t owner; /* index among the snapshot's lights as callers count them */
} air_light;

typedef struct air_light_table {
    air_light *entries;
    size_t count;          /* all entries */
    size_t explicit_count; /* the first ones; emissive surfaces follow */
    size_t owner_count;    /* explicit_count, plus 1 if there are emissive surfaces */
    bool spheres_by_sight; /* a connection draws its own place on a sphere, of what the point sees,
                              and light points have nothing but a place (path alone asks so); false:
                              it leads to the place of the light point, as for all others */
    bool spheres_unplaced; /* then not even the light point has a place on a sphere */
    float *cdf;            /* cumulative selection probability over entries; last is 1 */
    uint32_t environment_count;
    uint32_t *environments; /* entries of kind environment */
    air_vec3 scene_center;
    float scene_radius;        /* for the power of lights at infinity */
    void *visible_accelerator; /* camera-visible polygon lights, so that rays meet them; NULL if
                                  none. Hit mesh k is visible_entries[k] */
    uint32_t *visible_entries;
    float *visible_positions;
    uint32_t *visible_indices;
} air_light_table;

typedef struct air_light_point {
    uint32_t entry;
    bool infinite;     /* collimated, environment */
    bool delta;        /* point, spot, projector, collimated: cannot be hit */
    air_vec3 position; /* finite lights */
    air_vec3 normal;   /* area lights: front side */
    air_vec3 dir;      /* infinite lights: unit, towards the light */
    air_vec3 value;    /* radiance, intensity or E_perp */
    float pdf;   /* per area, per solid angle (environment), or 1 (delta); without the selection
                    probability */
    bool curved; /* on a quadric: a ray that passes close by its place may meet it before */
    float u[2];  /* quadrics: the numbers it was drawn by */
} air_light_point;

typedef struct air_connection {
    air_vec3 dir;      /* unit, towards the light */
    float distance;    /* INFINITY for lights at infinity */
    air_vec3 incident; /* delta: irradiance on a plane perpendicular to dir; else radiance */
    float
        pdf; /* delta: 1; else density per solid angle at the shaded point; without the selection
                probability. A contribution is f(dir) * incident / (pdf * selection probability) */
} air_connection;

/* Does it shine from one point? */
static inline bool air_light_is_placed(const air_light *light)
{
    return light->kind == AIR_LIGHT_POINT || light->kind == AIR_LIGHT_SPOT ||
           light->kind == AIR_LIGHT_PROJECTOR;
}

/* Where the entry's emission texture is looked up, by weights of corners 1 and 2, or by a quadric's
 * own coordinates. */
static inline void air_light_uv(const air_light *light, float b1, float b2, float out_uv[2])
{
    const float b0 = 1.0f - b1 - b2;
    for (int k = 0; k < 2; k++) {
        out_uv[k] = b0 * light->uv[0][k] + b1 * light->uv[1][k] + b2 * light->uv[2][k];
    }
}

/* Emissive triangles of meshes; and emissive spheres, cylinders and disks. */
size_t air_light_triangle_count(const air_light_table *table);
size_t air_light_quadric_count(const air_light_table *table);

/* Chooses an entry by power; *out_u is u rescaled to [0,1) within it. The table must not be empty.
 */
uint32_t air_light_pick(const air_light_table *table, float u, float *out_probability,
                        float *out_u);
float air_light_pick_probability(const air_light_table *table, uint32_t entry);

void air_light_sample(const air_light_table *table, uint32_t entry, float u1, float u2,
                      air_light_point *out);
/* False if the light does not reach `point` (behind a one-sided light, outside a cone or a gobo).
 * Occlusion is not asked. */
bool air_light_connect(const air_light_table *table, const air_light_point *light_point,
                       air_vec3 point, air_connection *out);

/* Density per solid angle, without the selection probability, with which air_light_sample and
 * air_light_connect give a place of this area light that is met from a point at `distance` along
 * unit `dir`. */
float air_light_hit_pdf(const air_light_table *table, uint32_t entry, air_vec3 from, air_vec3 dir,
                        float distance);
/* Radiance of an environment entry from the unit direction dir (pointing away from the viewer), and
 * its density. */
air_vec3 air_environment_radiance(const air_light *light, air_vec3 dir);
float air_environment_pdf(const air_light *light, air_vec3 dir);
/* The radiance a polygon light (not an emissive triangle of a mesh) sends against a ray along dir
 * that meets it. */
air_vec3 air_polygon_radiance(const air_light *light, air_vec3 dir);

/* Is the collimated light open at this point (inside one of its windows, or without any)? */
bool air_light_in_windows(const air_light *light, air_vec3 point);
/* The same for a ray, dir unit, t >= 0: the stretches its windows leave open, sorted and disjoint,
 * at most air_light_window_limit of them. For lights that have windows. */
size_t air_light_open_stretches(const air_light *light, const double origin[3], const double dir[3],
                                air_interval *out);
size_t air_light_window_limit(const air_light *light);

#endif

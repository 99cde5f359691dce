/* light.h: lights that are not emissive meshes. Radiometric units throughout: W, W/sr, W/m^2,
 * W/(m^2 sr). */
#ifndef AIRLIGHT_LIGHT_H
#define AIRLIGHT_LIGHT_H

#include "airlight/medium.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum air_light_kind {
    AIR_LIGHT_POINT = 0,      /* intensity, W/sr */
    AIR_LIGHT_SPOT = 1,       /* intensity on the axis, W/sr, falling off between two cone angles */
    AIR_LIGHT_COLLIMATED = 2, /* from infinity along dir: perpendicular irradiance E_perp, W/m^2;
                                 optional gobo windows */
    AIR_LIGHT_POLYGON = 3,    /* planar polygon of constant radiance, W/(m^2 sr), cosine emission */
    AIR_LIGHT_ENVIRONMENT = 4, /* radiance at infinity: constant, or lat-long image times it */
    AIR_LIGHT_PROJECTOR = 5    /* from a point through a picture; the intensity, W/sr, is that times
                                  its value over the cube of the cosine from the axis, so that it lies
                                  evenly on a screen across; nothing beside it or behind */
} air_light_kind;

/* A window of a gobo: light passes only inside the prism that the polygon sweeps along the light's
 * direction, both ways. Several windows: their union (they should not overlap; overlaps count
 * once). */
typedef struct air_gobo_window {
    const float
        *vertices;       /* 3 floats each, world space, in order around; a simple polygon; copied */
    size_t vertex_count; /* >= 3 */
} air_gobo_window;

/* How a spot's intensity falls from the inner cone to the outer one. */
typedef enum air_spot_shape {
    AIR_SPOT_COSINE = 0, /* KHR_lights_punctual: linear in the cosine, squared */
    AIR_SPOT_ANGLE = 1   /* linear in the angle, as Mitsuba's */
} air_spot_shape;

typedef struct air_light_desc {
    const char *name; /* copied; may be NULL */
    air_light_kind kind;
    float color[3];    /* the quantity named at the kind, >= 0, finite */
    float position[3]; /* point, spot, projector */
    float dir[3];      /* direction the light travels; spot, collimated; need not be unit */
    float inner_cone_rad, outer_cone_rad; /* spot: 0 <= inner < outer <= pi/2 */
    air_spot_shape falloff;               /* spot */
    float fov_x_rad; /* projector: full angle that the picture's width fills, (0, pi) */
    const air_gobo_window *windows; /* collimated: copied */
    size_t window_count;
    const float *vertices; /* polygon: 3 floats each, world space, planar, simple; emits to the side
                              from which the vertices run counter-clockwise; copied */
    size_t vertex_count;
    bool one_sided;      /* polygon: default true */
    bool camera_visible; /* polygon, environment: default true */
    bool casts_shadow;   /* false: nothing occludes this light; default true */
    air_handle image;    /* environment, projector: texture handle, or AIR_NONE for a constant (of
                            a projector a square) */
    float to_world[9];   /* environment, projector: rotation from image space (+Y up, image centre =
                            -Z) to world, row-major */
} air_light_desc;

/* A point light of intensity 0 at the origin, travelling along -Y, cones 0 and pi/4, cosine
 * falloff, field of view pi/4, two flags true, one_sided true, identity rotation. */
AIR_API void air_light_desc_default(air_light_desc *desc);

#ifdef __cplusplus
}
#endif
#endif

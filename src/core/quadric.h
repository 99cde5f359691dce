/* quadric.h: spheres, open cylinders and disks of unit size under an affine map, exactly.
 *
 * Local coordinates are those before the map: x^2 + y^2 + z^2 = 1; x^2 + y^2 = 1 with 0 <= z <= 1;
 * x^2 + y^2 <= 1 with z = 0. All is computed in doubles, from the floats of a ray or a map, so that
 * a sphere far away is met where it is and a ray that leaves a sphere does not meet it again. */
#ifndef AIR_CORE_QUADRIC_H
#define AIR_CORE_QUADRIC_H

#include "airlight/context.h"
#include "core/vec.h"

typedef struct air_quadric {
    air_ray_shape shape;
    float to_world[12];
    double linear[9], inverse[9]; /* of to_world, and its inverse */
    double determinant;           /* of linear */
} air_quadric;

/* A place on a quadric, at t along a ray. */
typedef struct air_quadric_hit {
    double t;
    double local[3];
} air_quadric_hit;

/* False if to_world is singular or not finite, or if the shape is not a quadric. */
bool air_quadric_make(air_ray_shape shape, const float to_world[12], air_quadric *out);

/* A point or a direction in local coordinates. */
void air_quadric_to_local(const air_quadric *quadric, const double point[3], double out[3]);
void air_quadric_dir_to_local(const air_quadric *quadric, const double dir[3], double out[3]);
void air_quadric_dir_to_world(const air_quadric *quadric, const double local[3], double out[3]);
/* A local point in the world. */
air_vec3 air_quadric_to_world(const air_quadric *quadric, const double local[3]);

/* Where the line of a ray of the world meets it, in the order of t, which may be negative; at most
 * two places. dir need not have unit length. */
size_t air_quadric_intersect(const air_quadric *quadric, const float origin[3], const float dir[3],
                             air_quadric_hit out[2]);
/* Of a sphere only the two t; false if the line misses it. */
bool air_quadric_sphere_chord(const air_quadric *sphere, const float origin[3], const float dir[3],
                              double out_ends[2]);

/* Texture coordinates of a local place, in [0, 1], and back. Sphere: angle about Z over a turn,
 * angle from +Z over pi; cylinder: angle about Z, z; disk: radius, angle about Z. */
void air_quadric_uv(air_ray_shape shape, const double local[3], float out_uv[2]);
void air_quadric_place(air_ray_shape shape, float u, float v, double out_local[3]);

/* Outward, of a disk along +Z: in local coordinates, and in the world, both unit. */
void air_quadric_local_normal(air_ray_shape shape, const double local[3], double out[3]);
air_vec3 air_quadric_normal(const air_quadric *quadric, const double local[3]);
/* Where a sphere has this normal, of any length. */
void air_quadric_sphere_place(const air_quadric *sphere, const float normal[3],
                              double out_local[3]);

/* How the place in the world moves with u and with v; not by u at the poles of a sphere, nor by v
 * in the middle of a disk. */
void air_quadric_slopes(const air_quadric *quadric, float u, float v, air_vec3 *out_by_u,
                        air_vec3 *out_by_v);

/* Area in the world over local area, at a place. */
double air_quadric_stretch(const air_quadric *quadric, const double local[3]);
/* Local area, and that in the world, m^2. */
double air_quadric_local_area(air_ray_shape shape);
double air_quadric_area(const air_quadric *quadric);

/* u1, u2 in [0, 1): a local place, uniform in local area. */
void air_quadric_sample(air_ray_shape shape, float u1, float u2, double out_local[3]);

void air_quadric_bounds(const air_quadric *quadric, float out_min[3], float out_max[3]);

#endif

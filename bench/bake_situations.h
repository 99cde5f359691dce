/* bake_situations.h: small scenes in which treatments of media differ, for bench_bake. */
#ifndef AIR_BENCH_BAKE_SITUATIONS_H
#define AIR_BENCH_BAKE_SITUATIONS_H

#include <string.h>

#include "airlight/scene.h"
#include "core/vec.h"

typedef struct situation {
    const char *name;
    air_status (*make)(air_scene *scene);
    float texels_per_metre;
} situation;

static inline void situation_set3(float out[3], float r, float g, float b)
{
    out[0] = r;
    out[1] = g;
    out[2] = b;
}

static inline air_status situation_material(air_scene *scene, float albedo, bool double_sided,
                                            air_handle *out)
{
    air_material_desc material;
    air_material_desc_default(&material);
    situation_set3(material.base_color, albedo, albedo, albedo);
    material.specular = 0.0f;
    material.double_sided = double_sided;
    return air_scene_add_material(scene, &material, out);
}

/* A parallelogram whose front looks along u x v. */
static inline air_status situation_quad(air_scene *scene, const char *name, air_vec3 corner,
                                        air_vec3 u, air_vec3 v, air_handle material)
{
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    float positions[12];
    air_mesh_desc mesh;
    air_handle handle;
    vec3_store(positions, corner);
    vec3_store(positions + 3, vec3_add(corner, u));
    vec3_store(positions + 6, vec3_add(corner, vec3_add(u, v)));
    vec3_store(positions + 9, vec3_add(corner, v));
    air_mesh_desc_default(&mesh);
    mesh.name = name;
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    mesh.material = material;
    return air_scene_add_mesh(scene, &mesh, &handle);
}

static inline air_status situation_floor(air_scene *scene, float half, air_handle material)
{
    return situation_quad(scene, "floor", vec3(-half, 0, half), vec3(2 * half, 0, 0),
                          vec3(0, 0, -2 * half), material);
}

static inline air_status situation_box_medium(air_scene *scene, air_vec3 center, air_vec3 half,
                                              float sigma_s, float sigma_a, float g)
{
    const float box[12] = {half.x, 0, 0, center.x, 0, half.y, 0, center.y, 0, 0, half.z, center.z};
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.name = "haze";
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    situation_set3(medium.sigma_s, sigma_s, sigma_s, sigma_s);
    situation_set3(medium.sigma_a, sigma_a, sigma_a, sigma_a);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = g;
    return air_scene_add_medium(scene, &medium, &handle);
}

static inline air_status situation_lamp(air_scene *scene, air_vec3 position, float intensity)
{
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.name = "lamp";
    vec3_store(light.position, position);
    situation_set3(light.color, intensity, intensity, intensity);
    return air_scene_add_light(scene, &light, &handle);
}

static inline air_status situation_sun(air_scene *scene, air_vec3 dir, float irradiance)
{
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.name = "sun";
    light.kind = AIR_LIGHT_COLLIMATED;
    vec3_store(light.dir, dir);
    situation_set3(light.color, irradiance, irradiance, irradiance);
    return air_scene_add_light(scene, &light, &handle);
}

/* Five walls about [-h, h] x [0, 3] x [-h, h], looking inwards, and the ceiling. */
static inline air_status situation_room(air_scene *scene, float h, air_handle m)
{
    air_status status = situation_floor(scene, h, m);
    status = status == AIR_OK ? situation_quad(scene, "ceiling", vec3(-h, 3, -h), vec3(2 * h, 0, 0),
                                               vec3(0, 0, 2 * h), m)
                              : status;
    status = status == AIR_OK ? situation_quad(scene, "back", vec3(-h, 0, -h), vec3(2 * h, 0, 0),
                                               vec3(0, 3, 0), m)
                              : status;
    status = status == AIR_OK ? situation_quad(scene, "front", vec3(h, 0, h), vec3(-2 * h, 0, 0),
                                               vec3(0, 3, 0), m)
                              : status;
    status = status == AIR_OK ? situation_quad(scene, "left", vec3(-h, 0, h), vec3(0, 0, -2 * h),
                                               vec3(0, 3, 0), m)
                              : status;
    return status == AIR_OK
               ? situation_quad(scene, "right", vec3(h, 0, -h), vec3(0, 0, 2 * h), vec3(0, 3, 0), m)
               : status;
}

/* A lamp in a room, with a box of haze that ends before the walls. */
static inline air_status make_haze_in_room(air_scene *scene)
{
    air_handle grey;
    air_status status = situation_material(scene, 0.6f, false, &grey);
    status = status == AIR_OK ? situation_room(scene, 2.5f, grey) : status;
    status = status == AIR_OK ? situation_box_medium(scene, vec3(0, 1, 0), vec3(1.8f, 1, 1.8f),
                                                     0.4f, 0.02f, 0.3f)
                              : status;
    return status == AIR_OK ? situation_lamp(scene, vec3(0.5f, 2.4f, 0.3f), 1.0f) : status;
}

/* A lamp two metres above a floor with a wall, fog below one metre. */
static inline air_status make_ground_fog(air_scene *scene)
{
    air_handle grey, both;
    air_status status = situation_material(scene, 0.5f, false, &grey);
    status = status == AIR_OK ? situation_material(scene, 0.5f, true, &both) : status;
    status = status == AIR_OK ? situation_floor(scene, 6.0f, grey) : status;
    status = status == AIR_OK ? situation_quad(scene, "wall", vec3(-3, 0, -2), vec3(6, 0, 0),
                                               vec3(0, 3, 0), both)
                              : status;
    status = status == AIR_OK
                 ? situation_box_medium(scene, vec3(0, 0.5f, 0), vec3(6, 0.5f, 6), 0.6f, 0.0f, 0.0f)
                 : status;
    return status == AIR_OK ? situation_lamp(scene, vec3(0, 2, 0), 1.0f) : status;
}

/* A slanted sun over two metres of fog, a post in it. */
static inline air_status make_sun_over_slab(air_scene *scene)
{
    air_handle grey, both;
    air_status status = situation_material(scene, 0.5f, false, &grey);
    status = status == AIR_OK ? situation_material(scene, 0.5f, true, &both) : status;
    status = status == AIR_OK ? situation_floor(scene, 10.0f, grey) : status;
    status = status == AIR_OK ? situation_quad(scene, "post", vec3(-0.5f, 0, 0), vec3(1, 0, 0),
                                               vec3(0, 2.5f, 0), both)
                              : status;
    status = status == AIR_OK
                 ? situation_box_medium(scene, vec3(0, 1, 0), vec3(40, 1, 40), 0.5f, 0.0f, 0.5f)
                 : status;
    return status == AIR_OK ? situation_sun(scene, vec3(-0.7f, -0.6f, -0.3f), 1.0f) : status;
}

/* A screen between a lamp and part of the floor, haze around all of it. */
static inline air_status make_occluded_lamp(air_scene *scene)
{
    air_handle grey, both;
    air_status status = situation_material(scene, 0.5f, false, &grey);
    status = status == AIR_OK ? situation_material(scene, 0.5f, true, &both) : status;
    status = status == AIR_OK ? situation_floor(scene, 3.0f, grey) : status;
    status = status == AIR_OK ? situation_quad(scene, "screen", vec3(0.2f, 1, -0.5f), vec3(0, 0, 1),
                                               vec3(1, 0, 0), both)
                              : status;
    status = status == AIR_OK
                 ? situation_box_medium(scene, vec3(0, 1.5f, 0), vec3(4, 1.5f, 4), 0.3f, 0.0f, 0.0f)
                 : status;
    return status == AIR_OK ? situation_lamp(scene, vec3(0, 2, 0), 1.0f) : status;
}

static const situation situations[] = {
    {"haze in a room", make_haze_in_room, 5.0f},
    {"ground fog", make_ground_fog, 4.0f},
    {"sun over a slab", make_sun_over_slab, 2.5f},
    {"occluded lamp", make_occluded_lamp, 7.0f},
};
enum { SITUATIONS = sizeof situations / sizeof situations[0] };

#endif

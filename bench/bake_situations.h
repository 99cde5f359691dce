/* bake_situations.h: small scenes in which treatments of media differ, for bench_bake. */
#ifndef AIR_BENCH_BAKE_SITUATIONS_H
#define AIR_BENCH_BAKE_SITUATIONS_H

#include <math.h>
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
static inline air_status situation_haze(air_scene *scene, float g)
{
    air_handle grey;
    air_status status = situation_material(scene, 0.6f, false, &grey);
    status = status == AIR_OK ? situation_room(scene, 2.5f, grey) : status;
    status = status == AIR_OK
                 ? situation_box_medium(scene, vec3(0, 1, 0), vec3(1.8f, 1, 1.8f), 0.4f, 0.02f, g)
                 : status;
    return status == AIR_OK ? situation_lamp(scene, vec3(0.5f, 2.4f, 0.3f), 1.0f) : status;
}

static inline air_status make_haze_in_room(air_scene *scene) { return situation_haze(scene, 0.3f); }
static inline air_status make_haze_even(air_scene *scene) { return situation_haze(scene, 0.0f); }
static inline air_status make_haze_half(air_scene *scene) { return situation_haze(scene, 0.5f); }
static inline air_status make_haze_sharp(air_scene *scene) { return situation_haze(scene, 0.8f); }

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

/* A sun at an angle to the vertical over two metres of fog and a bare floor. */
static inline air_status situation_layer(air_scene *scene, float angle_rad)
{
    air_handle grey;
    air_status status = situation_material(scene, 0.5f, false, &grey);
    status = status == AIR_OK ? situation_floor(scene, 10.0f, grey) : status;
    status = status == AIR_OK
                 ? situation_box_medium(scene, vec3(0, 1, 0), vec3(40, 1, 40), 0.5f, 0.0f, 0.0f)
                 : status;
    return status == AIR_OK
               ? situation_sun(scene, vec3(-sinf(angle_rad), -cosf(angle_rad), 0), 1.0f)
               : status;
}

static inline air_status make_layer_0(air_scene *scene) { return situation_layer(scene, 0.0f); }
static inline air_status make_layer_30(air_scene *scene) { return situation_layer(scene, 0.5236f); }
static inline air_status make_layer_60(air_scene *scene) { return situation_layer(scene, 1.0472f); }
static inline air_status make_layer_75(air_scene *scene) { return situation_layer(scene, 1.3090f); }

/* A lamp over a floor in fog without end. It absorbs a little: without, walks would never end. */
static inline air_status make_endless_fog(air_scene *scene)
{
    air_handle grey, handle;
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.name = "fog";
    medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    situation_set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    situation_set3(medium.sigma_a, 0.03f, 0.03f, 0.03f);
    air_status status = situation_material(scene, 0.5f, false, &grey);
    status = status == AIR_OK ? situation_floor(scene, 5.0f, grey) : status;
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    return status == AIR_OK ? situation_lamp(scene, vec3(0, 2, 0), 1.0f) : status;
}

/* A room full of haze, lit through a window of 1 m x 1 m by the sun and by a sky. */
static inline air_status make_window(air_scene *scene)
{
    static const struct {
        const char *name;
        air_vec3 corner, u, v;
    } walls[] = {
        {"floor", {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}},
        {"ceiling", {-2, 3, -2}, {4, 0, 0}, {0, 0, 4}},
        {"back", {-2, 0, -2}, {4, 0, 0}, {0, 3, 0}},
        {"front", {2, 0, 2}, {-4, 0, 0}, {0, 3, 0}},
        {"right", {2, 0, -2}, {0, 0, 4}, {0, 3, 0}},
        {"beside", {-2, 0, 2}, {0, 0, -1.5f}, {0, 3, 0}},
        {"beside", {-2, 0, -0.5f}, {0, 0, -1.5f}, {0, 3, 0}},
        {"under", {-2, 0, 0.5f}, {0, 0, -1}, {0, 1, 0}},
        {"over", {-2, 2, 0.5f}, {0, 0, -1}, {0, 1, 0}},
    };
    air_handle grey, handle;
    air_light_desc sky;
    air_status status = situation_material(scene, 0.6f, true, &grey);
    for (size_t i = 0; i < sizeof walls / sizeof walls[0] && status == AIR_OK; i++) {
        status =
            situation_quad(scene, walls[i].name, walls[i].corner, walls[i].u, walls[i].v, grey);
    }
    air_light_desc_default(&sky);
    sky.name = "sky";
    sky.kind = AIR_LIGHT_ENVIRONMENT;
    situation_set3(sky.color, 0.2f, 0.2f, 0.2f);
    status = status == AIR_OK ? air_scene_add_light(scene, &sky, &handle) : status;
    status = status == AIR_OK
                 ? situation_box_medium(scene, vec3(0, 1.5f, 0), vec3(2, 1.5f, 2), 0.2f, 0.0f, 0.5f)
                 : status;
    return status == AIR_OK ? situation_sun(scene, vec3(0.8f, -0.6f, 0), 5.0f) : status;
}

/* A ball of smoke that thins out, 12^3 values, over a floor and under a lamp. */
static inline air_status make_smoke(air_scene *scene)
{
    enum { SIDE = 12 };
    float values[SIDE * SIDE * SIDE];
    const float step = 2.4f / SIDE, low = 0.5f * step;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const float x = ((float)(i % SIDE) + 0.5f) / SIDE * 2.0f - 1.0f;
        const float y = ((float)(i / SIDE % SIDE) + 0.5f) / SIDE * 2.0f - 1.0f;
        const float z = ((float)(i / (SIDE * SIDE)) + 0.5f) / SIDE * 2.0f - 1.0f;
        values[i] = fmaxf(1.0f - (x * x + y * y + z * z), 0.0f);
    }
    const air_grid_desc grid = {
        .name = "smoke",
        .size = {SIDE, SIDE, SIDE},
        .channels = 1,
        .values = values,
        .index_to_local = {step, 0, 0, -1.2f + low, 0, step, 0, low, 0, 0, step, -1.2f + low}};
    air_medium_desc medium;
    air_handle grey, handle;
    air_medium_desc_default(&medium);
    medium.name = "smoke";
    situation_set3(medium.sigma_s, 1.5f, 1.5f, 1.5f);
    situation_set3(medium.sigma_a, 0.3f, 0.3f, 0.3f);
    medium.density.kind = AIR_DENSITY_GRID;
    air_status status = air_scene_add_grid(scene, &grid, &medium.density.grid);
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    status = status == AIR_OK ? situation_material(scene, 0.5f, false, &grey) : status;
    status = status == AIR_OK ? situation_floor(scene, 3.0f, grey) : status;
    return status == AIR_OK ? situation_lamp(scene, vec3(0.8f, 3, 0.4f), 1.0f) : status;
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
    {"haze in a room, g = 0", make_haze_even, 3.0f},
    {"haze in a room, g = 0.5", make_haze_half, 3.0f},
    {"haze in a room, g = 0.8", make_haze_sharp, 3.0f},
    {"endless fog", make_endless_fog, 3.0f},
    {"layer, sun at 0 degrees", make_layer_0, 1.5f},
    {"layer, sun at 30 degrees", make_layer_30, 1.5f},
    {"layer, sun at 60 degrees", make_layer_60, 1.5f},
    {"layer, sun at 75 degrees", make_layer_75, 1.5f},
    {"room, lit through a window", make_window, 4.0f},
    {"smoke in a grid", make_smoke, 5.0f},
};
enum { SITUATIONS = sizeof situations / sizeof situations[0] };

#endif

/* small_room.h: a scene with some of everything, made through the public interface. */
#ifndef AIR_TESTS_SMALL_ROOM_H
#define AIR_TESTS_SMALL_ROOM_H

#include <math.h>
#include <string.h>

#include "airlight/airlight.h"
#include "core/random.h"

static inline void room_set3(float out[3], float x, float y, float z)
{
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

/* A horizontal square of half width w at height y. */
static inline air_status room_add_square(air_scene *scene, float y, float w, air_handle material)
{
    const float positions[12] = {-w, y, w, w, y, w, w, y, -w, -w, y, -w};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    air_mesh_desc mesh;
    air_handle handle;
    air_mesh_desc_default(&mesh);
    mesh.name = "square";
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    mesh.material = material;
    return air_scene_add_mesh(scene, &mesh, &handle);
}

static inline air_status room_add_lights(air_scene *scene)
{
    static const float window[12] = {-0.6f, 2, 0, -0.1f, 2, 0, -0.1f, 2, 1, -0.6f, 2, 1};
    static const float panel[12] = {0.3f, 1.2f, -0.5f, 0.8f, 1.2f, -0.5f,
                                    0.8f, 1.2f, 0.2f,  0.3f, 1.2f, 0.2f};
    const air_gobo_window windows[1] = {{window, 4}};
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.name = "bulb";
    room_set3(light.color, 1.0f, 0.8f, 0.6f);
    room_set3(light.position, -0.5f, 0.9f, -0.4f);
    air_status status = air_scene_add_light(scene, &light, &handle);
    air_light_desc_default(&light);
    light.name = "sun";
    light.kind = AIR_LIGHT_COLLIMATED;
    room_set3(light.color, 3.0f, 3.0f, 2.5f);
    room_set3(light.dir, 0.4f, -1.0f, 0.1f);
    light.windows = windows;
    light.window_count = 1;
    status = status == AIR_OK ? air_scene_add_light(scene, &light, &handle) : status;
    air_light_desc_default(&light);
    light.name = "panel";
    light.kind = AIR_LIGHT_POLYGON;
    room_set3(light.color, 1.5f, 1.5f, 2.0f);
    light.vertices = panel;
    light.vertex_count = 4;
    status = status == AIR_OK ? air_scene_add_light(scene, &light, &handle) : status;
    air_light_desc_default(&light);
    light.name = "sky";
    light.kind = AIR_LIGHT_ENVIRONMENT;
    room_set3(light.color, 0.1f, 0.15f, 0.2f);
    return status == AIR_OK ? air_scene_add_light(scene, &light, &handle) : status;
}

static inline air_status room_add_grid_medium(air_scene *scene)
{
    enum { SIDE = 9 };
    float values[SIDE * SIDE * SIDE];
    air_rng rng = air_rng_from_keys(11, 12);
    air_medium_desc medium;
    air_handle handle;
    const float step = 1.0f / SIDE;
    air_grid_desc grid = {"puff",
                          {SIDE, SIDE, SIDE},
                          1,
                          values,
                          {step, 0, 0, -0.5f, 0, step, 0, 0.2f, 0, 0, step, -0.5f}};
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        values[i] = fmaxf(0.0f, 2.0f * air_rng_float(&rng) - 0.5f);
    }
    air_medium_desc_default(&medium);
    medium.name = "smoke";
    room_set3(medium.sigma_s, 1.2f, 1.0f, 0.8f);
    room_set3(medium.sigma_a, 0.2f, 0.2f, 0.4f);
    medium.density.kind = AIR_DENSITY_GRID;
    air_status status = air_scene_add_grid(scene, &grid, &medium.density.grid);
    return status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
}

/* A floor, an emissive patch above it, four kinds of lights, a box of haze, and on demand a grid of
 * smoke. */
static inline air_status room_make(air_context *context, bool with_grid,
                                   air_snapshot **out_snapshot)
{
    air_scene *scene = NULL;
    air_material_desc material;
    air_medium_desc medium;
    air_camera_desc camera;
    air_handle floor, glow, handle;
    air_status status = air_scene_create(context, &scene);
    air_material_desc_default(&material);
    room_set3(material.base_color, 0.6f, 0.5f, 0.4f);
    material.roughness = 0.4f;
    status = status == AIR_OK ? air_scene_add_material(scene, &material, &floor) : status;
    air_material_desc_default(&material);
    room_set3(material.emission, 0.5f, 1.0f, 0.5f);
    status = status == AIR_OK ? air_scene_add_material(scene, &material, &glow) : status;
    status = status == AIR_OK ? room_add_square(scene, 0.0f, 2.0f, floor) : status;
    status = status == AIR_OK ? room_add_square(scene, 0.05f, 0.2f, glow) : status;
    status = status == AIR_OK ? room_add_lights(scene) : status;
    air_medium_desc_default(&medium);
    medium.name = "haze";
    room_set3(medium.sigma_s, 0.3f, 0.35f, 0.4f);
    room_set3(medium.sigma_a, 0.05f, 0.05f, 0.05f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = 0.5f;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    const float box[12] = {1.5f, 0, 0, 0, 0, 1, 0, 0.8f, 0, 0, 1.5f, 0};
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    status = status == AIR_OK && with_grid ? room_add_grid_medium(scene) : status;
    air_camera_desc_default(&camera);
    const float to_world[12] = {1, 0, 0, 0, 0, 0.97f, 0.243f, 1.5f, 0, -0.243f, 0.97f, 4.0f};
    memcpy(camera.to_world, to_world, sizeof to_world);
    status = status == AIR_OK ? air_scene_add_camera(scene, &camera, &handle) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out_snapshot, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

#endif

/* grid_scene.h: media with an end and the lights that method ordinates takes into their cells. */
#ifndef AIR_TESTS_GRID_SCENE_H
#define AIR_TESTS_GRID_SCENE_H

#include "small_room.h"

typedef enum grid_light {
    GRID_SUN = 1,
    GRID_SKY = 2,
    GRID_WINDOW = 4, /* the sun comes through one */
    GRID_POINT_OUTSIDE = 8,
    GRID_POINT_INSIDE = 16,
    GRID_LAMP = 32 /* a flat polygon */
} grid_light;

/* What differs from scene to scene. */
typedef struct grid_scene {
    const char *name;
    unsigned lights;
    float sigma_s[3], sigma_a[3], g;
    bool blob;              /* density is a grid: a ball that fades outwards */
    bool second;            /* another medium overlaps the first, of another phase function */
    bool blocker;           /* a black square outside throws its shadow into the medium */
    bool endless;           /* a thin medium without end */
    float detail, detail_m; /* strength and scale of the first medium's detail */
} grid_scene;

static inline air_status grid_add_light(air_scene *scene, const char *name, air_light_desc *light)
{
    air_handle handle;
    light->name = name;
    light->camera_visible = false;
    return air_scene_add_light(scene, light, &handle);
}

static inline air_status grid_add_sun(air_scene *scene, bool window)
{
    static const float square[12] = {-0.3f, 2, -0.3f, 0.3f,  2, -0.3f,
                                     0.3f,  2, 0.3f,  -0.3f, 2, 0.3f};
    const air_gobo_window windows[1] = {{square, 4}};
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_COLLIMATED;
    room_set3(light.color, 3.0f, 2.5f, 2.0f);
    room_set3(light.dir, 0.3f, -1.0f, -0.5f);
    if (window) {
        room_set3(light.dir, 0.0f, -1.0f, 0.0f);
        light.windows = windows;
        light.window_count = 1;
    }
    return grid_add_light(scene, "sun", &light);
}

static inline air_status grid_add_point(air_scene *scene, bool inside)
{
    air_light_desc light;
    air_light_desc_default(&light);
    room_set3(light.color, 1.0f, 0.8f, 0.6f);
    room_set3(light.position, inside ? 0.1f : 0.9f, inside ? 0.1f : 0.7f, inside ? -0.1f : 0.2f);
    return grid_add_light(scene, "bulb", &light);
}

static inline air_status grid_add_lamp(air_scene *scene)
{
    static const float panel[12] = {-0.3f, 0.8f, -0.3f, 0.3f,  0.8f, -0.3f,
                                    0.3f,  0.8f, 0.3f,  -0.3f, 0.8f, 0.3f};
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_POLYGON;
    room_set3(light.color, 3.0f, 3.0f, 4.0f);
    light.vertices = panel;
    light.vertex_count = 4;
    return grid_add_light(scene, "lamp", &light);
}

static inline air_status grid_add_lights(air_scene *scene, unsigned lights)
{
    air_light_desc sky;
    air_status status = AIR_OK;
    if ((lights & GRID_SUN) != 0) {
        status = grid_add_sun(scene, (lights & GRID_WINDOW) != 0);
    }
    if (status == AIR_OK && (lights & GRID_SKY) != 0) {
        air_light_desc_default(&sky);
        sky.kind = AIR_LIGHT_ENVIRONMENT;
        room_set3(sky.color, 0.5f, 0.6f, 0.8f);
        status = grid_add_light(scene, "sky", &sky);
    }
    if (status == AIR_OK && (lights & (GRID_POINT_INSIDE | GRID_POINT_OUTSIDE)) != 0) {
        status = grid_add_point(scene, (lights & GRID_POINT_INSIDE) != 0);
    }
    return status == AIR_OK && (lights & GRID_LAMP) != 0 ? grid_add_lamp(scene) : status;
}

static inline air_status grid_add_blob(air_scene *scene, air_density *density)
{
    enum { SIDE = 16 };
    float values[SIDE * SIDE * SIDE];
    const float step = 1.0f / SIDE;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const float x = ((float)(i % SIDE) + 0.5f) * step - 0.5f;
        const float y = ((float)(i / SIDE % SIDE) + 0.5f) * step - 0.5f;
        const float z = ((float)(i / SIDE / SIDE) + 0.5f) * step - 0.5f;
        values[i] = fmaxf(1.0f - 2.0f * sqrtf(x * x + y * y + z * z), 0.0f);
    }
    const float first = 0.5f * step - 0.5f;
    const air_grid_desc grid = {"blob",
                                {SIDE, SIDE, SIDE},
                                1,
                                values,
                                {step, 0, 0, first, 0, step, 0, first, 0, 0, step, first}};
    density->kind = AIR_DENSITY_GRID;
    return air_scene_add_grid(scene, &grid, &density->grid);
}

static inline air_status grid_add_media(air_scene *scene, const grid_scene *s)
{
    const float cube[12] = {0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0};
    const float other[12] = {0.4f, 0, 0, 0.4f, 0, 0.3f, 0, -0.1f, 0, 0, 0.3f, 0.1f};
    air_medium_desc medium;
    air_handle handle;
    air_status status = AIR_OK;
    air_medium_desc_default(&medium);
    medium.name = "haze";
    memcpy(medium.sigma_s, s->sigma_s, sizeof medium.sigma_s);
    memcpy(medium.sigma_a, s->sigma_a, sizeof medium.sigma_a);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = s->g;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    memcpy(medium.boundary.box_to_world, cube, sizeof cube);
    medium.density.detail.strength = s->detail;
    medium.density.detail.scale = s->detail > 0.0f ? s->detail_m : 1.0f;
    status = s->blob ? grid_add_blob(scene, &medium.density) : status;
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    if (status == AIR_OK && s->second) {
        air_medium_desc_default(&medium);
        medium.name = "dust";
        room_set3(medium.sigma_s, 3.0f, 2.0f, 1.0f);
        room_set3(medium.sigma_a, 0.1f, 0.2f, 0.3f);
        medium.phase.kind = AIR_PHASE_HG;
        medium.phase.g = -0.3f;
        medium.boundary.kind = AIR_BOUNDARY_BOX;
        memcpy(medium.boundary.box_to_world, other, sizeof other);
        status = air_scene_add_medium(scene, &medium, &handle);
    }
    if (status == AIR_OK && s->endless) {
        air_medium_desc_default(&medium);
        medium.name = "air";
        room_set3(medium.sigma_s, 0.01f, 0.01f, 0.01f);
        status = air_scene_add_medium(scene, &medium, &handle);
    }
    return status;
}

/* Black, so that it sends no light on into the medium. */
static inline air_status grid_add_blocker(air_scene *scene)
{
    air_material_desc material;
    air_handle black;
    air_material_desc_default(&material);
    room_set3(material.base_color, 0.0f, 0.0f, 0.0f);
    material.specular = 0.0f;
    const air_status status = air_scene_add_material(scene, &material, &black);
    return status == AIR_OK ? room_add_square(scene, 0.7f, 0.25f, black) : status;
}

static inline air_status grid_scene_make(air_context *context, const grid_scene *s,
                                         air_snapshot **out_snapshot)
{
    /* From (0, 0.9, 2.4), 20 degrees down. */
    const float view[12] = {1, 0, 0, 0, 0, 0.94f, 0.342f, 0.9f, 0, -0.342f, 0.94f, 2.4f};
    air_scene *scene = NULL;
    air_camera_desc camera;
    air_handle handle;
    *out_snapshot = NULL;
    air_status status = air_scene_create(context, &scene);
    status = status == AIR_OK ? grid_add_lights(scene, s->lights) : status;
    status = status == AIR_OK ? grid_add_media(scene, s) : status;
    status = status == AIR_OK && s->blocker ? grid_add_blocker(scene) : status;
    air_camera_desc_default(&camera);
    memcpy(camera.to_world, view, sizeof view);
    camera.fov_y_rad = 0.55f;
    status = status == AIR_OK ? air_scene_add_camera(scene, &camera, &handle) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out_snapshot, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

#endif

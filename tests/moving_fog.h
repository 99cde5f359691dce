/* moving_fog.h: a box of fog of which frames are made: moved, thickened, lit otherwise. */
#ifndef AIR_TESTS_MOVING_FOG_H
#define AIR_TESTS_MOVING_FOG_H

#include "grid_scene.h"

enum { FOG_SKY_WIDTH = 16, FOG_SKY_HEIGHT = 8 };

typedef struct moving_fog {
    float sigma, g;       /* per metre, of scattering; a hundredth of it absorbs */
    float centre, height; /* of the box along x, and its extent along y; the others are 1 m */
    float sun, sky;       /* strengths; 0: none */
    int bright;           /* column of the sky's picture that is bright */
    float eye;            /* the camera's x */
} moving_fog;

static const moving_fog still_fog = {.sigma = 8, .g = 0.7f, .height = 1, .sun = 3, .sky = 1};

static inline air_status fog_add_sky(air_scene *scene, const moving_fog *fog)
{
    float pixels[FOG_SKY_WIDTH * FOG_SKY_HEIGHT * 3];
    for (int i = 0; i < FOG_SKY_WIDTH * FOG_SKY_HEIGHT * 3; i++) {
        const bool bright = i / 3 % FOG_SKY_WIDTH == fog->bright && i / 3 / FOG_SKY_WIDTH < 4;
        pixels[i] = fog->sky * (bright ? 5.0f : 0.5f + 0.1f * (float)(i % 3));
    }
    const air_texture_desc texture = {.name = "sky",
                                      .width = FOG_SKY_WIDTH,
                                      .height = FOG_SKY_HEIGHT,
                                      .channels = 3,
                                      .floats = pixels};
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    room_set3(light.color, 1.0f, 1.0f, 1.0f);
    const air_status status = air_scene_add_texture(scene, &texture, &light.image);
    return status == AIR_OK ? grid_add_light(scene, "sky", &light) : status;
}

static inline air_status fog_add_sun(air_scene *scene, float strength)
{
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_COLLIMATED;
    room_set3(light.color, strength, 0.8f * strength, 0.6f * strength);
    room_set3(light.dir, 0.3f, -1.0f, -0.5f);
    return grid_add_light(scene, "sun", &light);
}

static inline air_status fog_add_medium(air_scene *scene, const moving_fog *fog)
{
    const float box[12] = {0.5f, 0, 0, fog->centre, 0, 0.5f * fog->height, 0, 0, 0, 0, 0.5f, 0};
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.name = "fog";
    room_set3(medium.sigma_s, fog->sigma, 0.8f * fog->sigma, 0.6f * fog->sigma);
    room_set3(medium.sigma_a, 0.01f * fog->sigma, 0.01f * fog->sigma, 0.01f * fog->sigma);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = fog->g;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    return air_scene_add_medium(scene, &medium, &handle);
}

static inline air_status fog_add_camera(air_scene *scene, float eye)
{
    const float view[12] = {1, 0, 0, eye, 0, 1, 0, 0.1f, 0, 0, 1, 2.4f};
    air_camera_desc camera;
    air_handle handle;
    air_camera_desc_default(&camera);
    memcpy(camera.to_world, view, sizeof view);
    camera.fov_y_rad = 0.55f;
    return air_scene_add_camera(scene, &camera, &handle);
}

static inline air_status fog_make(air_context *context, const moving_fog *fog, air_snapshot **out)
{
    air_scene *scene = NULL;
    *out = NULL;
    air_status status = air_scene_create(context, &scene);
    status = status == AIR_OK && fog->sun > 0.0f ? fog_add_sun(scene, fog->sun) : status;
    status = status == AIR_OK && fog->sky > 0.0f ? fog_add_sky(scene, fog) : status;
    status = status == AIR_OK ? fog_add_medium(scene, fog) : status;
    status = status == AIR_OK ? fog_add_camera(scene, fog->eye) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

#endif

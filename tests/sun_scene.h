/* sun_scene.h: a floor, blocks that throw shadows and a box of haze under suns: what the collimated
 * method owns, made through the public interface. */
#ifndef AIR_TESTS_SUN_SCENE_H
#define AIR_TESTS_SUN_SCENE_H

#include "small_room.h"

/* What differs from scene to scene. */
typedef struct sun_scene {
    float sigma_s[3], sigma_a[3];
    float dir[3];       /* of the first sun */
    bool two_suns;      /* a second one, from elsewhere */
    bool one_name;      /* both are called "sun" */
    bool windows;       /* the first has two, one of them concave */
    bool second_medium; /* a box that overlaps the haze */
    bool third_medium;  /* a layer without end below it, which touches both */
    bool coverage;      /* one block is half transparent */
    bool lamp;          /* a point light that path has to render */
    bool camera_inside;
    int panels;    /* flat lamps: 1 in the haze, 2: also one that is not convex and has two sides */
    bool no_suns;  /* only these */
    int glow;      /* lamps are emissive meshes, the first of glow x glow cells */
    bool mirrored; /* that one comes by a transform that mirrors */
    bool mixture;  /* the first medium's phase function is one of three lobes */
    bool matte;    /* surfaces reflect evenly, without highlights */
    float near_distance; /* of the camera */
} sun_scene;

static inline sun_scene sun_scene_default(void)
{
    return (sun_scene){
        .sigma_s = {0.5f, 0.5f, 0.5f}, .sigma_a = {0.1f, 0.1f, 0.1f}, .dir = {0.5f, -1.0f, -0.3f}};
}

/* An axis-aligned block. */
static inline air_status sun_add_block(air_scene *scene, const float low[3], const float high[3],
                                       air_handle material)
{
    float positions[24];
    static const uint32_t indices[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    air_mesh_desc mesh;
    air_handle handle;
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) {
            positions[3 * i + k] = (i >> k & 1) != 0 ? high[k] : low[k];
        }
    }
    air_mesh_desc_default(&mesh);
    mesh.name = "block";
    mesh.positions = positions;
    mesh.vertex_count = 8;
    mesh.indices = indices;
    mesh.triangle_count = 12;
    mesh.material = material;
    return air_scene_add_mesh(scene, &mesh, &handle);
}

static inline air_status sun_add_glow(air_scene *scene, const air_mesh_desc *shape, bool two_sided)
{
    air_material_desc material;
    air_mesh_desc mesh = *shape;
    air_handle handle;
    air_material_desc_default(&material);
    room_set3(material.emission, 3.0f, 2.0f, 1.0f);
    material.double_sided = two_sided;
    air_status status = air_scene_add_material(scene, &material, &mesh.material);
    mesh.camera_visible = false;
    mesh.casts_shadow = false;
    return status == AIR_OK ? air_scene_add_mesh(scene, &mesh, &handle) : status;
}

/* The first panel as a mesh of n x n cells of two triangles. */
static inline air_status sun_add_cells(air_scene *scene, int n, bool mirrored)
{
    enum { MOST = 12 };
    float positions[3 * (MOST + 1) * (MOST + 1)];
    uint32_t indices[6 * MOST * MOST];
    air_mesh_desc mesh;
    air_mesh_desc_default(&mesh);
    mesh.name = "panel";
    for (int i = 0; i < (n + 1) * (n + 1); i++) {
        const float x = -0.4f + (float)(i % (n + 1)) / (float)n;
        const float z = -0.3f + 0.7f * (float)(i / (n + 1)) / (float)n;
        room_set3(positions + 3 * i, mirrored ? -x : x, 1.6f, z);
    }
    for (int i = 0; i < n * n; i++) {
        const uint32_t at = (uint32_t)(i / n * (n + 1) + i % n), up = at + (uint32_t)n + 1;
        const uint32_t left = mirrored ? at + 1 : at, right = mirrored ? at : at + 1;
        const uint32_t up_left = mirrored ? up + 1 : up, up_right = mirrored ? up : up + 1;
        const uint32_t cell[6] = {left, right, up_right, left, up_right, up_left};
        memcpy(indices + 6 * i, cell, sizeof cell);
    }
    mesh.positions = positions;
    mesh.vertex_count = (size_t)((n + 1) * (n + 1));
    mesh.indices = indices;
    mesh.triangle_count = (size_t)(2 * n * n);
    mesh.to_world[0] = mirrored ? -1.0f : 1.0f;
    return sun_add_glow(scene, &mesh, false);
}

static const float sun_corner[18] = {-1.2f, 0.5f, 0.8f, -1.2f, 1.5f, 0.8f,  -1.2f, 1.5f, 0.4f,
                                     -1.2f, 0.9f, 0.4f, -1.2f, 0.9f, -0.4f, -1.2f, 0.5f, -0.4f};

static inline air_status sun_add_glows(air_scene *scene, const sun_scene *s)
{
    static const uint32_t indices[12] = {3, 0, 1, 3, 1, 2, 3, 4, 5, 3, 5, 0};
    air_mesh_desc mesh;
    air_status status = sun_add_cells(scene, s->glow, s->mirrored);
    air_mesh_desc_default(&mesh);
    mesh.name = "corner";
    mesh.positions = sun_corner;
    mesh.vertex_count = 6;
    mesh.indices = indices;
    mesh.triangle_count = 4;
    return status == AIR_OK && s->panels > 1 ? sun_add_glow(scene, &mesh, true) : status;
}

static inline air_status sun_add_panels(air_scene *scene, const sun_scene *s)
{
    static const float square[12] = {-0.4f, 1.6f, -0.3f, 0.6f,  1.6f, -0.3f,
                                     0.6f,  1.6f, 0.4f,  -0.4f, 1.6f, 0.4f};
    air_light_desc light;
    air_handle handle;
    air_status status = AIR_OK;
    for (int i = 0; i < s->panels && status == AIR_OK; i++) {
        air_light_desc_default(&light);
        light.name = i == 0 ? "panel" : "corner";
        light.kind = AIR_LIGHT_POLYGON;
        room_set3(light.color, 3.0f, 2.0f, 1.0f);
        light.vertices = i == 0 ? square : sun_corner;
        light.vertex_count = i == 0 ? 4 : 6;
        light.one_sided = i == 0;
        light.camera_visible = false;
        status = air_scene_add_light(scene, &light, &handle);
    }
    return status;
}

static inline air_status sun_add_lights(air_scene *scene, const sun_scene *s)
{
    static const float square[12] = {-0.9f, 3, -0.6f, 0.3f,  3, -0.6f,
                                     0.3f,  3, 0.9f,  -0.9f, 3, 0.9f};
    static const float arrow[12] = {0.5f, 3, -0.5f, 1.4f, 3, 0, 0.5f, 3, 0.6f, 0.8f, 3, 0.05f};
    const air_gobo_window windows[2] = {{square, 4}, {arrow, 4}};
    air_light_desc light;
    air_handle handle;
    air_status status = s->glow > 0 ? sun_add_glows(scene, s) : sun_add_panels(scene, s);
    if (status != AIR_OK || s->no_suns) {
        return status;
    }
    air_light_desc_default(&light);
    light.name = "sun";
    light.kind = AIR_LIGHT_COLLIMATED;
    room_set3(light.color, 3.0f, 2.5f, 2.0f);
    memcpy(light.dir, s->dir, sizeof light.dir);
    light.windows = windows;
    light.window_count = s->windows ? 2 : 0;
    status = air_scene_add_light(scene, &light, &handle);
    if (status == AIR_OK && s->two_suns) {
        air_light_desc_default(&light);
        light.name = s->one_name ? "sun" : "second sun";
        light.kind = AIR_LIGHT_COLLIMATED;
        room_set3(light.color, 0.5f, 1.0f, 2.0f);
        room_set3(light.dir, -1.0f, -0.6f, 0.2f);
        status = air_scene_add_light(scene, &light, &handle);
    }
    if (status == AIR_OK && s->lamp) {
        air_light_desc_default(&light);
        light.name = "bulb";
        room_set3(light.color, 0.4f, 0.3f, 0.2f);
        room_set3(light.position, -0.8f, 1.2f, 0.4f);
        status = air_scene_add_light(scene, &light, &handle);
    }
    return status;
}

static inline air_status sun_add_media(air_scene *scene, const sun_scene *s)
{
    const float box[12] = {1.5f, 0, 0, 0, 0, 0.9f, 0, 0.9f, 0, 0, 1.5f, 0};
    const float other[12] = {0.5f, 0.2f, 0, 1.3f, -0.1f, 0.5f, 0.1f, 1.2f, 0, 0, 0.8f, 0.2f};
    static const float slab[8] = {0, 1, 0, 0, 0, -1, 0, 0.5f};
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.name = "haze";
    memcpy(medium.sigma_s, s->sigma_s, sizeof medium.sigma_s);
    memcpy(medium.sigma_a, s->sigma_a, sizeof medium.sigma_a);
    static const air_phase_mixture mixture = {3,
                                              {{AIR_PHASE_HG, 0.8f, 4.0f},
                                               {AIR_PHASE_HG, -0.4f, 2.0f},
                                               {AIR_PHASE_RAYLEIGH, 0.0f, 1.0f}}};
    medium.phase.kind = s->mixture ? AIR_PHASE_MIXTURE : AIR_PHASE_HG;
    medium.phase.g = 0.4f;
    medium.phase.mixture = &mixture;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    air_status status = air_scene_add_medium(scene, &medium, &handle);
    if (status == AIR_OK && s->second_medium) {
        medium.name = "dust";
        room_set3(medium.sigma_s, 0.3f, 0.2f, 0.1f);
        room_set3(medium.sigma_a, 0.3f, 0.3f, 0.5f);
        medium.phase.kind = AIR_PHASE_RAYLEIGH;
        memcpy(medium.boundary.box_to_world, other, sizeof other);
        status = air_scene_add_medium(scene, &medium, &handle);
    }
    if (status == AIR_OK && s->third_medium) {
        air_medium_desc_default(&medium);
        medium.name = "layer";
        room_set3(medium.sigma_s, 0.2f, 0.2f, 0.2f);
        medium.boundary.kind = AIR_BOUNDARY_CONVEX;
        medium.boundary.planes = slab;
        medium.boundary.plane_count = 2;
        status = air_scene_add_medium(scene, &medium, &handle);
    }
    return status;
}

static inline air_status sun_add_meshes(air_scene *scene, const sun_scene *s)
{
    static const float low[3][3] = {
        {-0.7f, 0.9f, -0.6f}, {0.2f, 1.0f, 0.1f}, {-0.2f, 0.02f, -1.0f}};
    static const float high[3][3] = {{-0.2f, 1.1f, 0.5f}, {0.9f, 1.3f, 0.4f}, {0.1f, 0.7f, -0.8f}};
    air_material_desc material;
    air_handle grey, glass;
    air_material_desc_default(&material);
    room_set3(material.base_color, 0.6f, 0.5f, 0.4f);
    material.roughness = 0.5f;
    material.specular = s->matte ? 0.0f : material.specular;
    air_status status = air_scene_add_material(scene, &material, &grey);
    material.base_color[3] = 0.5f;
    material.alpha_mode = AIR_ALPHA_BLEND;
    status = status == AIR_OK ? air_scene_add_material(scene, &material, &glass) : status;
    const float floor_y = s->third_medium ? -0.6f : 0.01f;
    status = status == AIR_OK ? room_add_square(scene, floor_y, 4.0f, grey) : status;
    for (int i = 0; i < 3 && status == AIR_OK; i++) {
        const bool clear = s->coverage && i == 1;
        status = sun_add_block(scene, low[i], high[i], clear ? glass : grey);
    }
    return status;
}

static inline air_status sun_scene_make(air_context *context, const sun_scene *s,
                                        air_snapshot **out_snapshot)
{
    const float outside[12] = {1, 0, 0, 0.2f, 0, 0.97f, 0.243f, 2.0f, 0, -0.243f, 0.97f, 5.0f};
    const float inside[12] = {1, 0, 0, 0.1f, 0, 0.99f, 0.141f, 0.8f, 0, -0.141f, 0.99f, 1.3f};
    air_scene *scene = NULL;
    air_camera_desc camera;
    air_handle handle;
    *out_snapshot = NULL;
    air_status status = air_scene_create(context, &scene);
    status = status == AIR_OK ? sun_add_meshes(scene, s) : status;
    status = status == AIR_OK ? sun_add_lights(scene, s) : status;
    status = status == AIR_OK ? sun_add_media(scene, s) : status;
    air_camera_desc_default(&camera);
    memcpy(camera.to_world, s->camera_inside ? inside : outside, sizeof camera.to_world);
    camera.fov_y_rad = s->camera_inside ? 1.2f : 0.6f;
    camera.near_distance = s->near_distance;
    status = status == AIR_OK ? air_scene_add_camera(scene, &camera, &handle) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out_snapshot, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

#endif

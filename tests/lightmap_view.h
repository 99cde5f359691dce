/* lightmap_view.h: scenes and lightmaps of few texels for tests of pictures that show baked light.
 */
#ifndef AIR_TESTS_LIGHTMAP_VIEW_H
#define AIR_TESTS_LIGHTMAP_VIEW_H

#include <math.h>

#include "airlight/airlight.h"
#include "core/host.h"
#include "scene_fixture.h"

enum { VIEW_SIZE = 8 };

/* A square of 2 m across in the plane z = 0, its lightmap coordinates as its uv: u from left to
 * right, v from top to bottom. */
static inline void view_add_square(air_scene *scene, const char *name, air_handle material)
{
    air_mesh_desc mesh = fixture_square(name);
    air_handle handle;
    mesh.uv[1] = fixture_square_uv;
    mesh.material = material;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
}

static inline air_handle view_add_material(air_scene *scene, const air_material_desc *material)
{
    air_handle handle;
    assert_int_equal(air_scene_add_material(scene, material, &handle), AIR_OK);
    return handle;
}

/* Without a highlight. */
static inline air_material_desc view_lambert(float r, float g, float b)
{
    air_material_desc material;
    air_material_desc_default(&material);
    material.base_color[0] = r;
    material.base_color[1] = g;
    material.base_color[2] = b;
    material.specular = 0.0f;
    material.metallic = 0.0f;
    return material;
}

/* Parallel rays along the z axis, 1 m apart from the plane z = 0, on the side of `side` (1: its
 * front): VIEW_SIZE pixels show 2 m, pixel (x, y) the point -1 + (x + 1/2) / 4 from the left. From
 * behind the picture is mirrored. */
static inline void view_add_camera(air_scene *scene, float side)
{
    air_camera_desc camera;
    air_handle handle;
    air_camera_desc_default(&camera);
    const float to_world[12] = {side, 0, 0, 0, 0, 1, 0, 0, 0, 0, side, side};
    memcpy(camera.to_world, to_world, sizeof to_world);
    camera.kind = AIR_CAMERA_ORTHOGRAPHIC;
    camera.half_height = 1.0f;
    assert_int_equal(air_scene_add_camera(scene, &camera, &handle), AIR_OK);
}

/* Haze of coefficients s and a in a box from z = 0 to z = depth. */
static inline void view_add_haze(air_scene *scene, float s, float a, float depth)
{
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.name = "haze";
    for (int c = 0; c < 3; c++) {
        medium.sigma_s[c] = s;
        medium.sigma_a[c] = a * (float)(c + 1);
    }
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    const float box[12] = {4, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0.5f * depth, 0.5f * depth};
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
}

/* Places in the order of a page's channels: R is 0, direct.R is 3, indirect.R 6, media.R 9, L0.R
 * 12. */
enum { VIEW_DIRECT = 3, VIEW_INDIRECT = 6, VIEW_MEDIA = 9, VIEW_HARMONICS = 12 };

/* A page of zeros. */
static inline air_image *view_page(air_context *context, size_t width, size_t height,
                                   bool directional)
{
    static const char *const names[] = {
        "R",          "G",          "B",       "direct.R",  "direct.G", "direct.B", "indirect.R",
        "indirect.G", "indirect.B", "media.R", "media.G",   "media.B",  "L0.R",     "L0.G",
        "L0.B",       "L1.y.R",     "L1.y.G",  "L1.y.B",    "L1.z.R",   "L1.z.G",   "L1.z.B",
        "L1.x.R",     "L1.x.G",     "L1.x.B",  "coverage.Y"};
    const char *list[25];
    const size_t count = directional ? 24 : 12;
    air_image *image = NULL;
    memcpy(list, names, sizeof list);
    list[count] = names[24];
    assert_int_equal(air_image_create(context, width, height, count + 1, list, &image), AIR_OK);
    return image;
}

/* A lightmap of one page, with the snapshot's meshes all over it, each at its own coordinates. */
static inline air_lightmap *view_lightmap(air_context *context, const char *const *meshes,
                                          size_t mesh_count, air_image *page)
{
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(context, &lightmap), AIR_OK);
    lightmap->pages = air_allocate(context, 1, sizeof(void *));
    lightmap->meshes = air_allocate(context, mesh_count, sizeof *lightmap->meshes);
    assert_non_null(lightmap->pages);
    assert_non_null(lightmap->meshes);
    lightmap->pages[0] = page;
    lightmap->page_count = 1;
    lightmap->mesh_count = mesh_count;
    lightmap->directional = air_image_find_channel(page, "L0.R") >= 0;
    for (size_t i = 0; i < mesh_count; i++) {
        lightmap->meshes[i] = (air_lightmap_mesh){.name = air_string_copy(context, meshes[i]),
                                                  .mesh = (uint32_t)i,
                                                  .node = -1,
                                                  .primitive = -1,
                                                  .scale = {1.0f, 1.0f}};
    }
    return lightmap;
}

static inline void view_fill(air_image *page, size_t channel, float r, float g, float b)
{
    const float values[3] = {r, g, b};
    const size_t count = air_image_width(page) * air_image_height(page);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++) {
            air_image_plane(page, channel + c)[i] = values[c];
        }
    }
}

/* Rays through pixel centres, terms apart. */
static inline air_render_params view_params(const air_lightmap *lightmap)
{
    air_render_params params;
    air_render_params_default(&params);
    params.width = params.height = VIEW_SIZE;
    params.sample_end = 1;
    params.filter = AIR_FILTER_POINT;
    params.methods = "path";
    params.layers = true;
    params.lightmap = lightmap;
    return params;
}

static inline air_image *view_render(air_context *context, const air_snapshot *snapshot,
                                     const air_render_params *params)
{
    air_film *film = NULL;
    air_image *image = NULL;
    const air_status status = air_render(context, snapshot, params, &film);
    if (status != AIR_OK) {
        fail_msg("%s", air_context_last_error(context));
    }
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
    air_film_destroy(film);
    return image;
}

static inline double view_value(const air_image *image, const char *channel, size_t x, size_t y)
{
    const ptrdiff_t index = air_image_find_channel(image, channel);
    assert_true(index >= 0);
    return (double)air_image_plane_const(image, (size_t)index)[y * air_image_width(image) + x];
}

#endif

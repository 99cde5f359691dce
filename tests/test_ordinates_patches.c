/* Light that surfaces send into the media of method ordinates: its energy, where it goes and where
 * it does not, and pictures against path's. */
#include <math.h>
#include <stdlib.h>

#include "grid_scene.h"
#include "picture_fixture.h"
#include "render/ordinates/patches.h"

/* Haze in a cube of 1 m about the origin, and surfaces of one colour. */
typedef struct patch_scene {
    float albedo;
    bool floor; /* below the haze: a square of 4 m at y = -0.6 */
    bool lid;   /* one above it, at 0.6 */
    bool walls; /* a closed box of 1.2 m about it */
    bool point; /* light: a point inside, else the sun */
    float sigma_s;
} patch_scene;

static air_status add_material(air_scene *scene, float albedo, air_handle *out)
{
    air_material_desc material;
    air_material_desc_default(&material);
    room_set3(material.base_color, albedo, albedo, albedo);
    material.specular = 0.0f;
    material.roughness = 1.0f;
    material.double_sided = true;
    return air_scene_add_material(scene, &material, out);
}

static air_status add_box(air_scene *scene, float half, air_handle material)
{
    static const uint32_t indices[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                         2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    float positions[24];
    air_mesh_desc mesh;
    air_handle handle;
    for (int i = 0; i < 8; i++) {
        room_set3(positions + 3 * i, (i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half,
                  (i & 4) != 0 ? half : -half);
    }
    air_mesh_desc_default(&mesh);
    mesh.name = "walls";
    mesh.positions = positions;
    mesh.vertex_count = 8;
    mesh.indices = indices;
    mesh.triangle_count = 12;
    mesh.material = material;
    mesh.camera_visible = false; /* the camera looks in from outside */
    return air_scene_add_mesh(scene, &mesh, &handle);
}

static air_snapshot *make(air_context *context, const patch_scene *s)
{
    const grid_scene haze = {.sigma_s = {s->sigma_s, s->sigma_s, s->sigma_s}, .g = 0.3f};
    const float view[12] = {1, 0, 0, 0, 0, 0.94f, 0.342f, 0.9f, 0, -0.342f, 0.94f, 2.4f};
    air_scene *scene;
    air_snapshot *snapshot;
    air_camera_desc camera;
    air_handle material, handle;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(grid_add_media(scene, &haze), AIR_OK);
    assert_int_equal(add_material(scene, s->albedo, &material), AIR_OK);
    assert_int_equal(s->point ? grid_add_point(scene, true) : grid_add_sun(scene, false), AIR_OK);
    if (s->floor) {
        assert_int_equal(room_add_square(scene, -0.6f, 2.0f, material), AIR_OK);
    }
    if (s->lid) {
        assert_int_equal(room_add_square(scene, 0.6f, 20.0f, material), AIR_OK);
    }
    if (s->walls) {
        assert_int_equal(add_box(scene, 0.6f, material), AIR_OK);
    }
    air_camera_desc_default(&camera);
    memcpy(camera.to_world, view, sizeof view);
    camera.fov_y_rad = 0.55f;
    assert_int_equal(air_scene_add_camera(scene, &camera, &handle), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

/* ---- pictures ---- */

/* The mean of all pixels and channels of the light of more than one event. */
static double mean_rest(air_context *context, const patch_scene *s, const char *methods,
                        uint32_t samples)
{
    static const char *const names[3] = {"R", "G", "B"};
    air_snapshot *snapshot = make(context, s);
    air_render_params params = picture(methods, samples);
    params.layers = false;
    params.terms = 1u << AIR_TERM_M2;
    params.max_depth = UINT32_MAX;
    params.ordinates.cells = 16;
    air_image *image = render(context, snapshot, &params);
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        const ptrdiff_t at = air_image_find_channel(image, names[c]);
        const float *const plane = air_image_plane(image, (size_t)at);
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            sum += (double)plane[i] / (3 * WIDTH * HEIGHT);
        }
    }
    air_image_destroy(image);
    air_snapshot_release(snapshot);
    return sum;
}

static void assert_near_path(const patch_scene *s, double most)
{
    air_context *context = make_context(2, NULL);
    const double truth = mean_rest(context, s, "path", 1024);
    const double got = mean_rest(context, s, "ordinates", 16);
    if (!(fabs(got / truth - 1.0) <= most)) {
        fail_msg("mean %g, path's %g: off by %g", got, truth, got / truth - 1.0);
    }
    air_context_destroy(context);
}

/* Patches are as large as some cells, so that light near them is smooth: a twentieth at most; path
 * is within 1 % at this number of samples. */
static void a_lit_floor_lights_thin_haze_as_path_has_it(void **state)
{
    (void)state;
    const patch_scene s = {.albedo = 0.8f, .floor = true, .sigma_s = 0.5f};
    assert_near_path(&s, 0.06);
}

/* Most of the light is reflected several times, and what the haze sends back counts. */
static void a_white_room_is_as_bright_as_path_has_it(void **state)
{
    (void)state;
    const patch_scene s = {.albedo = 0.8f, .walls = true, .point = true, .sigma_s = 0.5f};
    assert_near_path(&s, 0.06);
}

static void black_surfaces_send_nothing(void **state)
{
    (void)state;
    air_context *context = make_context(2, NULL);
    const patch_scene none = {.albedo = 0.0f, .sigma_s = 2.0f};
    const patch_scene black = {.albedo = 0.0f, .floor = true, .sigma_s = 2.0f};
    const double a = mean_rest(context, &none, "ordinates", 64);
    const double b = mean_rest(context, &black, "ordinates", 64);
    /* With surfaces the solver goes on from a solution that has changed by 1e-3 of itself in its
     * last sweep. */
    assert_true(a > 0.0);
    assert_true(fabs(a - b) < 5e-3 * a);
    air_context_destroy(context);
}

/* The lid is lit from above and hides the sun: below it is night. */
static void light_does_not_go_through_walls(void **state)
{
    (void)state;
    air_context *context = make_context(2, NULL);
    const patch_scene s = {.albedo = 0.8f, .lid = true, .floor = true, .sigma_s = 1.0f};
    assert_true(mean_rest(context, &s, "ordinates", 16) == 0.0);
    air_context_destroy(context);
}

/* ---- energy ---- */

typedef struct shone {
    double photons[ORD_ROUNDS + 1], patches; /* W of green */
    size_t count, rounds;
    bool inside; /* all patches are on the surfaces */
} shone;

static shone shine(const patch_scene *s, uint32_t patches)
{
    static air_sobol sobol;
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = make(context, s);
    const air_path_settings settings = {.max_depth = UINT32_MAX, .terms = AIR_TERMS_ALL};
    air_path path;
    ord_domain domain;
    air_owner_table *owners;
    ord_photons photons;
    air_render_params params;
    shone out = {.inside = true};
    air_sobol_init(&sobol);
    air_render_params_default(&params);
    assert_int_equal(air_owner_table_create(context, snapshot, "ordinates", &owners), AIR_OK);
    assert_int_equal(air_path_init(&path, snapshot, &sobol, &settings), AIR_OK);
    assert_int_equal(ord_domain_place(snapshot, 8, NULL, &domain), AIR_OK);
    float *extinction = calloc(domain.cells * 4, sizeof *extinction); /* nothing is lost */
    const ord_space space = {&path, &domain, extinction};
    const ord_lighting lighting = {&path, owners, &params.ordinates, NULL, NULL};
    ord_source_list list = {.context = context};
    assert_int_equal(ord_photons_shoot(&lighting, &space, 2, &photons), AIR_OK);
    for (size_t i = 0; i < photons.count * photons.rounds; i++) {
        out.photons[i / photons.count] += (double)photons.items[i].flux.y;
    }
    assert_int_equal(ord_patches_choose(&space, &photons, patches, &list), AIR_OK);
    for (size_t i = 0; i < list.count; i++) {
        const ord_source *const source = &list.items[i];
        out.patches += (double)source->power.y * AIR_PI;
        out.inside = out.inside && fabsf(fabsf(source->place.y) - 0.6f) < 1e-3f;
    }
    out.count = list.count;
    out.rounds = photons.rounds;
    ord_sources_finish(&list);
    ord_photons_finish(&photons);
    free(extinction);
    ord_domain_finish(&domain);
    air_path_finish(&path);
    air_owner_table_destroy(owners);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
    return out;
}

/* The floor of 16 m^2 gets 2.5 W/m^2 times the sun's cosine, and sends on 0.8 of it. A quarter of
 * the photons sees what lies about the domain: with 8192 of them 1 % is four deviations. */
static void patches_send_what_the_floor_reflects(void **state)
{
    (void)state;
    const patch_scene s = {.albedo = 0.8f, .floor = true, .sigma_s = 1e-6f};
    const double cosine = 1.0 / sqrt(0.09 + 1.0 + 0.25);
    for (uint32_t patches = 1; patches <= 256; patches *= 16) {
        const shone got = shine(&s, patches);
        assert_true(fabs(got.photons[1] / (0.8 * 16.0 * 2.5 * cosine) - 1.0) < 0.01);
        assert_int_equal(got.photons[2] > 0.0, 0); /* one plane */
        assert_true(fabs(got.patches / got.photons[1] - 1.0) < 1e-4);
        assert_true(got.inside && got.count >= patches);
    }
}

/* In a closed room all light comes to a wall, and 0.8 of it goes on, each time. */
static void a_closed_room_loses_only_what_it_absorbs(void **state)
{
    (void)state;
    const patch_scene s = {.albedo = 0.8f, .walls = true, .point = true, .sigma_s = 1e-6f};
    const shone got = shine(&s, 64);
    assert_int_equal(got.rounds, 3);
    assert_true(fabs(got.photons[1] / (0.8 * got.photons[0]) - 1.0) < 1e-4);
    assert_true(fabs(got.photons[2] / (0.8 * got.photons[1]) - 1.0) < 1e-4);
    assert_true(fabs(got.patches / (got.photons[1] + got.photons[2]) - 1.0) < 1e-4);
}

static void black_surfaces_have_no_patches(void **state)
{
    (void)state;
    const patch_scene s = {.albedo = 0.0f, .floor = true, .sigma_s = 1.0f};
    assert_int_equal(shine(&s, 64).count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_send_what_the_floor_reflects),
        cmocka_unit_test(a_closed_room_loses_only_what_it_absorbs),
        cmocka_unit_test(black_surfaces_have_no_patches),
        cmocka_unit_test(black_surfaces_send_nothing),
        cmocka_unit_test(light_does_not_go_through_walls),
        cmocka_unit_test(a_lit_floor_lights_thin_haze_as_path_has_it),
        cmocka_unit_test(a_white_room_is_as_bright_as_path_has_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

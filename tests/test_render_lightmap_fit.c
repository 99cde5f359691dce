/* Lightmaps that are not the scene's, meshes that are on no page, memory, threads and films. */
#include <limits.h>
#include <stdio.h>

#include "failing_allocator.h"
#include "lightmap_view.h"

static const char *const names[] = {"floor", "sign"};

typedef struct heard {
    size_t warnings;
    char last[512];
} heard;

static void listen(void *user, air_message_level level, const char *text)
{
    heard *h = user;
    if (level == AIR_MESSAGE_WARNING) {
        h->warnings++;
        snprintf(h->last, sizeof h->last, "%s", text);
    }
}

/* A Lambert floor with lightmap coordinates and a second square, the sign, without. */
static air_status make_snapshot(air_context *context, bool unlit_sign, air_snapshot **out)
{
    air_scene *scene = NULL;
    air_material_desc material = view_lambert(0.5f, 0.5f, 0.5f);
    air_mesh_desc mesh = fixture_square("floor");
    air_camera_desc camera;
    air_handle handle;
    air_status status = air_scene_create(context, &scene);
    mesh.uv[1] = fixture_square_uv;
    status = status == AIR_OK ? air_scene_add_material(scene, &material, &mesh.material) : status;
    status = status == AIR_OK ? air_scene_add_mesh(scene, &mesh, &handle) : status;
    mesh = fixture_square("sign");
    material.unlit = unlit_sign;
    status = status == AIR_OK ? air_scene_add_material(scene, &material, &mesh.material) : status;
    mesh.to_world[0] = mesh.to_world[5] = 0.3f;
    mesh.to_world[11] = 0.2f;
    status = status == AIR_OK ? air_scene_add_mesh(scene, &mesh, &handle) : status;
    air_camera_desc_default(&camera);
    camera.kind = AIR_CAMERA_ORTHOGRAPHIC;
    camera.to_world[11] = 1.0f;
    status = status == AIR_OK ? air_scene_add_camera(scene, &camera, &handle) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

/* Both meshes on a page of irradiance 1, the sign cut (its own coordinates are missing). */
static air_lightmap *make_lightmap(air_context *context)
{
    air_image *page = view_page(context, 4, 4, false);
    view_fill(page, VIEW_DIRECT, 1.0f, 1.0f, 1.0f);
    air_lightmap *lightmap = view_lightmap(context, names, 2, page);
    air_lightmap_mesh *sign = &lightmap->meshes[1];
    sign->vertex_count = 4;
    sign->triangle_count = 2;
    sign->sources = air_allocate(context, 4, sizeof(uint32_t));
    sign->indices = air_allocate(context, 6, sizeof(uint32_t));
    sign->uv = air_allocate(context, 8, sizeof(float));
    for (uint32_t i = 0; i < 4; i++) {
        sign->sources[i] = i;
    }
    memcpy(sign->indices, fixture_square_indices, sizeof fixture_square_indices);
    memcpy(sign->uv, fixture_square_uv, sizeof fixture_square_uv);
    return lightmap;
}

static void rename_mesh(air_context *context, air_lightmap_mesh *mesh, const char *name)
{
    air_free(context, mesh->name);
    mesh->name = air_string_copy(context, name);
}

static void spoil(air_context *context, air_lightmap *lightmap, int how)
{
    switch (how) {
    case 0:
        lightmap->mesh_count = 1;
        break;
    case 1:
        rename_mesh(context, &lightmap->meshes[1], "sigh");
        break;
    case 2:
        lightmap->meshes[1].triangle_count = 1;
        break;
    case 3: /* its corners are elsewhere */
        lightmap->meshes[1].sources[3] = 1;
        break;
    case 4:
        lightmap->meshes[1].sources[3] = 4;
        break;
    case 5: /* no cut, though the mesh has no coordinates of its own */
        air_free(context, lightmap->meshes[1].sources);
        air_free(context, lightmap->meshes[1].indices);
        air_free(context, lightmap->meshes[1].uv);
        lightmap->meshes[1].sources = lightmap->meshes[1].indices = NULL;
        lightmap->meshes[1].uv = NULL;
        lightmap->meshes[1].vertex_count = lightmap->meshes[1].triangle_count = 0;
        break;
    case 6:
        lightmap->meshes[1].mesh = 0;
        break;
    case 7:
        lightmap->meshes[0].page = 1;
        break;
    case 8:
        lightmap->directional = true; /* without the channels */
        break;
    case 9:
        air_image_plane(lightmap->pages[0], VIEW_MEDIA)[3] = NAN;
        break;
    default:
        lightmap->meshes[0].page = lightmap->meshes[1].page = -1;
        air_image_destroy(lightmap->pages[0]);
        lightmap->page_count = 0;
        break;
    }
}

/* Errors name the mesh, and the file of the scene that was baked. */
static void lightmaps_of_other_scenes_are_refused(void **state)
{
    (void)state;
    static const char *const said[] = {
        "lightmap of old.glb: it is of 1 meshes, a scene without a file has 2",
        "lightmap of old.glb: mesh 1 is \"sigh\", in a scene without a file it is \"sign\"",
        "lightmap of old.glb: mesh 1 \"sign\" has 1 triangles, in a scene without a file it has 2",
        "lightmap of old.glb: mesh 1 \"sign\" has other triangles in a scene without a file",
        "lightmap of old.glb: mesh 1 \"sign\" has other triangles in a scene without a file",
        "lightmap of old.glb: mesh 1 \"sign\" has no TEXCOORD_1 in a scene without a file",
        "lightmap of old.glb: mesh 0 is \"sign\"",
        "lightmap: mesh 0 lies on page 1, there are 1 pages",
        "lightmap: page 0 lacks a channel of \"L0\"",
        "lightmap: page 0: number 3 of its media.R is not finite",
        "lightmap of old.glb: it has no pages",
    };
    air_context *context = fixture_context();
    air_snapshot *snapshot = NULL;
    assert_int_equal(make_snapshot(context, false, &snapshot), AIR_OK);
    for (int how = 0; how < (int)(sizeof said / sizeof said[0]); how++) {
        air_lightmap *lightmap = make_lightmap(context);
        air_free(context, lightmap->scene);
        lightmap->scene = air_string_copy(context, "old.glb");
        spoil(context, lightmap, how);
        const air_render_params params = view_params(lightmap);
        air_film *film = (air_film *)&params;
        assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
        assert_null(film);
        fixture_expect_message(context, said[how]);
        lightmap->mesh_count = 2;
        air_lightmap_destroy(lightmap);
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* A sign on no page: black and said once, however many passes there are; unlit it shows itself. */
static void meshes_on_no_page_are_dark_and_said(void **state)
{
    (void)state;
    for (int unlit = 0; unlit < 2; unlit++) {
        heard h = {0};
        air_context_params context_params;
        air_context *context = NULL;
        air_snapshot *snapshot = NULL;
        air_context_params_default(&context_params);
        context_params.message = listen;
        context_params.message_user = &h;
        assert_int_equal(air_context_create(&context_params, &context), AIR_OK);
        assert_int_equal(make_snapshot(context, unlit == 1, &snapshot), AIR_OK);
        air_lightmap *lightmap = make_lightmap(context);
        lightmap->meshes[1].page = -1;
        air_render_params params = view_params(lightmap);
        params.sample_end = 64;
        air_image *image = view_render(context, snapshot, &params);
        assert_true(view_value(image, "R", 3, 4) == (unlit ? 0.5 : 0.0));
        assert_true(fabs(view_value(image, "R", 0, 0) - 0.5 / 3.14159265) < 1e-6);
        assert_int_equal(h.warnings, unlit ? 0 : 1);
        assert_true(unlit ||
                    strcmp(h.last, "lightmap: 1 meshes are on none of its pages and get no "
                                   "light, the first of them \"sign\"") == 0);
        air_image_destroy(image);
        air_lightmap_destroy(lightmap);
        air_snapshot_release(snapshot);
        air_context_destroy(context);
    }
}

/* A term that is not asked for is not there; the film of none of the two needs no lightmap at all.
 */
static void terms_are_asked_for_one_by_one(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    air_snapshot *snapshot = NULL;
    assert_int_equal(make_snapshot(context, false, &snapshot), AIR_OK);
    air_lightmap *lightmap = make_lightmap(context);
    view_fill(lightmap->pages[0], VIEW_INDIRECT, 2.0f, 2.0f, 2.0f);
    static const struct {
        uint32_t terms;
        double irradiance;
    } cases[] = {{1u << AIR_TERM_S0, 1.0},
                 {1u << AIR_TERM_S_PLUS, 2.0},
                 {1u << AIR_TERM_S0 | 1u << AIR_TERM_S_PLUS, 3.0},
                 {1u << AIR_TERM_M1, 0.0}};
    for (size_t k = 0; k < 4; k++) {
        air_render_params params = view_params(lightmap);
        params.terms = cases[k].terms;
        params.layers = k % 2 == 0;
        air_image *image = view_render(context, snapshot, &params);
        assert_true(fabs(view_value(image, "R", 1, 1) - 0.5 * cases[k].irradiance / 3.14159265) <
                    1e-6);
        air_image_destroy(image);
    }
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* Films of two bakes are films of two pictures. */
static void films_of_different_bakes_do_not_merge(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    air_snapshot *snapshot = NULL;
    air_film *films[3];
    assert_int_equal(make_snapshot(context, false, &snapshot), AIR_OK);
    air_lightmap *lightmap = make_lightmap(context);
    for (uint32_t k = 0; k < 3; k++) {
        air_render_params params = view_params(lightmap);
        params.sample_begin = 16 * k;
        params.sample_end = 16 * k + 16;
        if (k == 2) {
            air_image_plane(lightmap->pages[0], VIEW_MEDIA + 2)[15] = 1e-3f;
        }
        assert_int_equal(air_render(context, snapshot, &params, &films[k]), AIR_OK);
    }
    assert_int_equal(air_film_merge(films[0], films[1]), AIR_OK);
    assert_int_equal(air_film_merge(films[0], films[2]), AIR_ERROR_ARGUMENT);
    for (size_t k = 0; k < 3; k++) {
        air_film_destroy(films[k]);
    }
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    air_image *images[2];
    air_context *contexts[2];
    for (size_t k = 0; k < 2; k++) {
        air_context_params params;
        air_snapshot *snapshot = NULL;
        air_context_params_default(&params);
        params.thread_count = 1 + 2 * k;
        assert_int_equal(air_context_create(&params, &contexts[k]), AIR_OK);
        assert_int_equal(make_snapshot(contexts[k], false, &snapshot), AIR_OK);
        air_lightmap *lightmap = make_lightmap(contexts[k]);
        for (size_t i = 0; i < 16; i++) {
            air_image_plane(lightmap->pages[0], VIEW_DIRECT)[i] = (float)(i * i % 7);
        }
        air_render_params picture = view_params(lightmap);
        picture.filter = AIR_FILTER_GAUSSIAN;
        picture.sample_end = 24;
        picture.tile_size = 3 + k;
        images[k] = view_render(contexts[k], snapshot, &picture);
        air_lightmap_destroy(lightmap);
        air_snapshot_release(snapshot);
    }
    for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
        assert_true(view_value(images[0], "R", i % VIEW_SIZE, i / VIEW_SIZE) ==
                    view_value(images[1], "R", i % VIEW_SIZE, i / VIEW_SIZE));
    }
    for (size_t k = 0; k < 2; k++) {
        air_image_destroy(images[k]);
        air_context_destroy(contexts[k]);
    }
}

/* Any allocation may fail: an error, no film, nothing lost. */
static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    failing_allocator allocator;
    const air_context_params context_params = failing_params(&allocator, LONG_MAX);
    air_context *context = NULL;
    air_snapshot *snapshot = NULL;
    assert_int_equal(air_context_create(&context_params, &context), AIR_OK);
    assert_int_equal(make_snapshot(context, false, &snapshot), AIR_OK);
    air_lightmap *lightmap = make_lightmap(context);
    const air_render_params params = view_params(lightmap);
    const long before = atomic_load(&allocator.live);
    air_status status = AIR_ERROR_MEMORY;
    long allowed = 0;
    for (; status != AIR_OK && allowed < 1000; allowed++) {
        air_film *film = NULL;
        atomic_store(&allocator.remaining, allowed);
        status = air_render(context, snapshot, &params, &film);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_true((status == AIR_OK) == (film != NULL));
        air_film_destroy(film);
        assert_int_equal(atomic_load(&allocator.live), before);
    }
    assert_int_equal(status, AIR_OK);
    assert_true(allowed > 5);
    atomic_store(&allocator.remaining, LONG_MAX);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lightmaps_of_other_scenes_are_refused),
        cmocka_unit_test(meshes_on_no_page_are_dark_and_said),
        cmocka_unit_test(terms_are_asked_for_one_by_one),
        cmocka_unit_test(films_of_different_bakes_do_not_merge),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Cameras: rays, framing, checking. */
#include <math.h>

#include "core/random.h"
#include "scene/camera.h"
#include "scene_fixture.h"

static void assert_near(air_vec3 a, air_vec3 b, float tolerance)
{
    if (!(vec3_length(vec3_sub(a, b)) <= tolerance))
        fail_msg("(%g %g %g) is not (%g %g %g)", (double)a.x, (double)a.y, (double)a.z, (double)b.x,
                 (double)b.y, (double)b.z);
}

static air_camera camera_of(air_camera_kind kind)
{
    return (air_camera){.kind = kind,
                        .to_world = {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3},
                        .fov_y_rad = AIR_PI_F / 2.0f,
                        .half_height = 2.0f,
                        .aspect = 1.0f};
}

static void perspective_rays_span_the_vertical_field_of_view(void **state)
{
    const air_camera camera = camera_of(AIR_CAMERA_PERSPECTIVE);
    air_vec3 origin, dir;
    (void)state;
    air_camera_ray(&camera, 200, 100, 100.0f, 50.0f, &origin, &dir);
    assert_near(origin, vec3(1, 2, 3), 0.0f);
    assert_near(dir, vec3(0, 0, -1), 1e-6f);
    /* 90 degrees vertically: the upper edge is 45 degrees up; twice as wide, the left edge is at
     * slope 2 */
    air_camera_ray(&camera, 200, 100, 100.0f, 0.0f, &origin, &dir);
    assert_near(dir, vec3_normalize(vec3(0, 1, -1)), 1e-6f);
    air_camera_ray(&camera, 200, 100, 0.0f, 50.0f, &origin, &dir);
    assert_near(dir, vec3_normalize(vec3(-2, 0, -1)), 1e-6f);
    air_camera_ray(&camera, 200, 100, 200.0f, 100.0f, &origin, &dir);
    assert_near(dir, vec3_normalize(vec3(2, -1, -1)), 1e-6f);
}

static void orthographic_rays_are_parallel_and_start_in_a_plane(void **state)
{
    const air_camera camera = camera_of(AIR_CAMERA_ORTHOGRAPHIC);
    air_vec3 origin, dir;
    (void)state;
    air_camera_ray(&camera, 300, 100, 0.0f, 0.0f, &origin, &dir);
    assert_near(dir, vec3(0, 0, -1), 0.0f);
    assert_near(origin, vec3(1 - 6, 2 + 2, 3), 1e-6f);
    air_camera_ray(&camera, 300, 100, 300.0f, 100.0f, &origin, &dir);
    assert_near(dir, vec3(0, 0, -1), 0.0f);
    assert_near(origin, vec3(1 + 6, 2 - 2, 3), 2e-6f);
}

/* Where a point appears, in pixels; the inverse of a perspective ray. */
static void project(const air_camera *camera, size_t width, size_t height, air_vec3 point, float *x,
                    float *y)
{
    const float *m = camera->to_world;
    const air_vec3 d = vec3_sub(point, vec3(m[3], m[7], m[11]));
    const float right = m[0] * d.x + m[4] * d.y + m[8] * d.z;
    const float up = m[1] * d.x + m[5] * d.y + m[9] * d.z;
    const float front = -(m[2] * d.x + m[6] * d.y + m[10] * d.z);
    const float slope = tanf(0.5f * camera->fov_y_rad) * front;
    assert_true(front > 0.0f);
    *x = 0.5f * (float)width + 0.5f * (float)height * right / slope;
    *y = 0.5f * (float)height - 0.5f * (float)height * up / slope;
}

static air_camera framed(air_context *context, const float low[3], const float high[3])
{
    air_camera_desc desc;
    air_record *record = NULL;
    air_camera_frame(low, high, &desc);
    assert_int_equal(air_camera_record_create(context, &desc, &record), AIR_OK);
    const air_camera_desc *kept = &((air_camera_record *)record)->desc;
    air_camera camera = {.kind = kept->kind, .fov_y_rad = kept->fov_y_rad, .aspect = kept->aspect};
    memcpy(camera.to_world, kept->to_world, sizeof camera.to_world);
    air_record_release(record);
    return camera;
}

static void framing_shows_all_corners_and_fills_the_picture(void **state)
{
    air_context *context = fixture_context();
    air_rng rng = air_rng_from_keys(1, 1);
    (void)state;
    for (int i = 0; i < 1000; ++i) {
        float low[3], high[3];
        for (size_t axis = 0; axis < 3; ++axis) {
            low[axis] = 20.0f * air_rng_float(&rng) - 10.0f;
            high[axis] = low[axis] + powf(10.0f, 4.0f * air_rng_float(&rng) - 2.0f);
        }
        const air_camera camera = framed(context, low, high);
        float reach = 0.0f;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const air_vec3 p = vec3(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                                    corner & 4 ? high[2] : low[2]);
            float x, y;
            project(&camera, 640, 480, p, &x, &y);
            assert_true(x > 0.0f && x < 640.0f && y > 0.0f && y < 480.0f);
            reach = fmaxf(reach, fmaxf(fabsf(x - 320.0f) / 320.0f, fabsf(y - 240.0f) / 240.0f));
        }
        /* 95 % of the picture, to the accuracy with which float positions 10 m from the origin tell
         * boxes of 1 cm */
        assert_true(fabsf(reach - 0.95f) < 1e-3f);
    }
    air_context_destroy(context);
}

static void framing_looks_from_the_front_and_above_with_the_horizon_level(void **state)
{
    air_context *context = fixture_context();
    const float low[3] = {0, 0, 0}, high[3] = {4, 3, 5};
    (void)state;
    const air_camera camera = framed(context, low, high);
    const float *m = camera.to_world;
    assert_true(m[2] > 0.0f && m[6] > 0.0f && m[10] > 0.5f); /* back: right, up and mostly front */
    assert_true(m[4] == 0.0f && m[5] > 0.0f);
    air_context_destroy(context);
}

static void nothing_to_frame_still_gives_a_camera(void **state)
{
    air_context *context = fixture_context();
    const float none_low[3] = {INFINITY, INFINITY, INFINITY};
    const float none_high[3] = {-INFINITY, -INFINITY, -INFINITY};
    const float point[3] = {1e6f, 0, 0};
    (void)state;
    air_camera camera = framed(context, none_low, none_high);
    assert_true(vec3_is_finite(vec3(camera.to_world[3], camera.to_world[7], camera.to_world[11])));
    camera = framed(context, point, point);
    float x, y;
    project(&camera, 640, 480, vec3_load(point), &x, &y);
    assert_true(fabsf(x - 320.0f) < 40.0f &&
                fabsf(y - 240.0f) < 40.0f); /* 1/16 m in 1 m: the ulp of 1e6 */
    air_context_destroy(context);
}

static void scale_shear_and_mirroring_of_cameras_are_dropped(void **state)
{
    air_context *context = fixture_context();
    air_camera_desc desc;
    air_record *record = NULL;
    (void)state;
    air_camera_desc_default(&desc);
    const float map[12] = {-3, 0.5f, 0, 7, 0, 2, 0, 8, 0, 1, 5, 9};
    memcpy(desc.to_world, map, sizeof map);
    assert_int_equal(air_camera_record_create(context, &desc, &record), AIR_OK);
    const float *m = ((air_camera_record *)record)->desc.to_world;
    assert_near(vec3(m[2], m[6], m[10]), vec3(0, 0, 1), 1e-6f);
    assert_near(vec3(m[3], m[7], m[11]), vec3(7, 8, 9), 0.0f);
    const air_vec3 x = vec3(m[0], m[4], m[8]), y = vec3(m[1], m[5], m[9]),
                   z = vec3(m[2], m[6], m[10]);
    assert_near(vec3_cross(x, y), z, 1e-6f);
    assert_true(fabsf(vec3_length(x) - 1.0f) < 1e-6f && fabsf(vec3_length(y) - 1.0f) < 1e-6f);
    assert_true(y.y > 0.9f);
    air_record_release(record);
    air_context_destroy(context);
}

/* Left and right change places, up and down do not, and what a snapshot says of the camera makes
 * it again. */
static void a_mirrored_camera_sees_the_mirrored_picture(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_camera_desc desc;
    air_handle handles[2];
    (void)state;
    air_camera_desc_default(&desc);
    assert_int_equal(air_scene_add_camera(scene, &desc, &handles[0]), AIR_OK);
    desc.mirrored = true;
    assert_int_equal(air_scene_add_camera(scene, &desc, &handles[1]), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_vec3 origin, plain, mirrored;
    air_camera_ray(&snapshot->cameras[0], 64, 48, 10.0f, 7.0f, &origin, &plain);
    air_camera_ray(&snapshot->cameras[1], 64, 48, 10.0f, 7.0f, &origin, &mirrored);
    assert_near(mirrored, vec3(-plain.x, plain.y, plain.z), 1e-6f);
    assert_int_equal(air_snapshot_camera_desc(snapshot, handles[1], &desc), AIR_OK);
    assert_int_equal(air_scene_set_camera(scene, handles[0], &desc), AIR_OK);
    air_snapshot *again = fixture_commit(scene, NULL);
    air_camera_ray(&again->cameras[0], 64, 48, 10.0f, 7.0f, &origin, &plain);
    assert_near(mirrored, plain, 0.0f);
    air_snapshot_release(again);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* Whatever the pixel, and the place of the lens. */
static void rays_begin_in_the_near_plane(void **state)
{
    (void)state;
    air_camera camera = {.kind = AIR_CAMERA_PERSPECTIVE,
                         .to_world = {1, 0, 0, 3, 0, 1, 0, 4, 0, 0, 1, 5},
                         .fov_y_rad = 1.0f,
                         .lens_radius = 0.2f,
                         .focus_distance = 3.0f,
                         .near_distance = 0.75f};
    air_camera_view view;
    air_camera_view_init(&camera, 64, 48, &view);
    for (int i = 0; i < 48; i++) {
        air_vec3 origin, dir, plain_origin, plain_dir;
        const float u = (float)i / 48.0f;
        air_camera_view_lens_ray(&view, (float)i, 31.0f, u, 0.3f, &origin, &dir);
        assert_true(fabsf(origin.z - (5.0f - 0.75f)) < 1e-5f);
        camera.near_distance = 0.0f;
        air_camera_view at_eye;
        air_camera_view_init(&camera, 64, 48, &at_eye);
        air_camera_view_lens_ray(&at_eye, (float)i, 31.0f, u, 0.3f, &plain_origin, &plain_dir);
        assert_near(dir, plain_dir, 0.0f);
        assert_near(vec3_cross(vec3_sub(origin, plain_origin), dir), vec3_set1(0.0f), 1e-5f);
    }
}

static void bad_cameras_are_refused_by_field(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_camera_desc good;
    air_handle handle = 77;
    (void)state;
    air_camera_desc_default(&good);
    good.name = "view";
    air_camera_desc bad[6] = {good, good, good, good, good, good};
    bad[0].fov_y_rad = 3.2f;
    bad[1].kind = AIR_CAMERA_ORTHOGRAPHIC;
    bad[1].half_height = 0.0f;
    bad[2].aspect = NAN;
    bad[3].to_world[3] = INFINITY;
    bad[4].to_world[10] = 0.0f; /* looks nowhere */
    bad[5].to_world[9] = 1.0f;  /* up is along the view */
    bad[5].to_world[5] = 0.0f;
    const char *const parts[6] = {
        "fov_y_rad is 3.2",   "half_height is 0",        "aspect is",
        "to_world[3] is inf", "to_world has no viewing", "to_world has no viewing"};
    for (size_t i = 0; i < 6; ++i) {
        assert_int_equal(air_scene_add_camera(scene, &bad[i], &handle), AIR_ERROR_ARGUMENT);
        fixture_expect_message(context, "camera \"view\": ");
        fixture_expect_message(context, parts[i]);
        assert_int_equal(handle, 77);
    }
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- lenses ---- */

static void rays_through_a_lens_meet_in_the_plane_of_focus(void **state)
{
    air_camera camera = camera_of(AIR_CAMERA_PERSPECTIVE);
    air_camera_view view;
    air_rng rng = air_rng_from_keys(7, 1);
    (void)state;
    camera.lens_radius = 0.3f;
    camera.focus_distance = 4.0f;
    air_camera_view_init(&camera, 200, 100, &view);
    for (int i = 0; i < 200; ++i) {
        const float x = 200.0f * air_rng_float(&rng), y = 100.0f * air_rng_float(&rng);
        air_vec3 pinhole, sharp, origin, dir;
        air_camera_view_ray(&view, x, y, &pinhole, &sharp);
        /* z = 3 - 4 */
        const air_vec3 focus = vec3_madd(pinhole, 4.0f / -sharp.z, sharp);
        for (int k = 0; k < 16; ++k) {
            const float u1 = air_rng_float(&rng), u2 = air_rng_float(&rng);
            air_camera_view_lens_ray(&view, x, y, u1, u2, &origin, &dir);
            assert_true(origin.z == 3.0f);
            assert_true(vec3_length(vec3_sub(origin, pinhole)) < 0.3f + 1e-6f);
            const float t = 4.0f / -dir.z;
            assert_near(vec3_madd(origin, t, dir), focus, 5e-6f);
        }
    }
}

/* What a lens of radius r makes of a point at the distance d, in focus f: a disk in the plane of
 * focus of radius r |f - d| / d. Here the other way round: rays of one place of the picture are
 * spread over such a disk times d / f at the distance d. */
static void the_circle_of_confusion_has_its_size(void **state)
{
    enum { STEPS = 64 };
    const float depths[2] = {1.5f, 9.0f};
    air_camera camera = camera_of(AIR_CAMERA_PERSPECTIVE);
    air_camera_view view;
    (void)state;
    camera.lens_radius = 0.2f;
    camera.focus_distance = 3.0f;
    air_camera_view_init(&camera, 64, 64, &view);
    for (int i = 0; i < 2; ++i) {
        const float d = depths[i], expected = 0.2f * fabsf(3.0f - d) / 3.0f;
        air_vec3 pinhole, sharp;
        air_camera_view_ray(&view, 10.0f, 20.0f, &pinhole, &sharp);
        const air_vec3 middle = vec3_madd(pinhole, d / -sharp.z, sharp);
        double most = 0.0, squares = 0.0;
        for (int k = 0; k < STEPS * STEPS; ++k) {
            air_vec3 origin, dir;
            air_camera_view_lens_ray(&view, 10.0f, 20.0f, ((float)(k / STEPS) + 0.5f) / STEPS,
                                     ((float)(k % STEPS) + 0.5f) / STEPS, &origin, &dir);
            const air_vec3 at = vec3_madd(origin, d / -dir.z, dir);
            const double off = (double)vec3_length(vec3_sub(at, middle));
            most = fmax(most, off);
            squares += off * off / (STEPS * STEPS);
        }
        /* the outermost midpoints lie half a step of 2 / 64 inside; a uniform disk has the mean
         * square r^2 / 2 */
        assert_true(fabs(most / (double)expected - 1.0) < 0.02);
        assert_true(fabs(2.0 * squares / (double)(expected * expected) - 1.0) < 1e-3);
    }
}

static void a_pinhole_is_a_lens_without_size(void **state)
{
    const air_camera camera = camera_of(AIR_CAMERA_PERSPECTIVE);
    air_camera_view view;
    air_vec3 origins[2], dirs[2];
    (void)state;
    air_camera_view_init(&camera, 64, 64, &view);
    air_camera_view_ray(&view, 3.0f, 5.0f, &origins[0], &dirs[0]);
    air_camera_view_lens_ray(&view, 3.0f, 5.0f, 0.9f, 0.1f, &origins[1], &dirs[1]);
    assert_memory_equal(&origins[0], &origins[1], sizeof origins[0]);
    assert_memory_equal(&dirs[0], &dirs[1], sizeof dirs[0]);
}

static void lenses_and_films_are_kept_and_checked(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_camera_desc desc, kept;
    air_handle handle;
    air_camera_desc_default(&desc);
    assert_true(desc.lens_radius == 0.0f && desc.focus_distance == 1.0f && !desc.film.known);
    desc.lens_radius = 0.1f;
    desc.focus_distance = 7.0f;
    desc.film = (air_film_hint){.known = true,
                                .width = 320,
                                .height = 200,
                                .crop = {10, 20, 300, 150},
                                .samples = 64,
                                .filter = AIR_FILTER_MITCHELL,
                                .filter_radius = 2.0f};
    assert_int_equal(air_scene_add_camera(scene, &desc, &handle), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    assert_int_equal(air_snapshot_camera_desc(snapshot, handle, &kept), AIR_OK);
    assert_true(kept.lens_radius == 0.1f && kept.focus_distance == 7.0f);
    assert_true(kept.film.known && kept.film.crop[3] == 150 && kept.film.samples == 64);
    assert_int_equal(kept.film.filter, AIR_FILTER_MITCHELL);
    air_snapshot_release(snapshot);
    desc.focus_distance = 8.0f;
    assert_int_equal(air_scene_set_camera(scene, handle, &desc), AIR_OK);
    assert_int_equal(fixture_dirty(scene), AIR_DIRTY_CAMERA);
    desc.film.crop[2] = 321;
    assert_int_equal(air_scene_add_camera(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "film.crop is 10,20 to 321,150, but must be a part of 320 x");
    desc.film.known = false;
    desc.focus_distance = 0.0f;
    assert_int_equal(air_scene_add_camera(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "focus_distance is 0, but must be above 0");
    desc.focus_distance = 1.0f;
    desc.lens_radius = -1.0f;
    assert_int_equal(air_scene_add_camera(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "lens_radius is -1");
    air_scene_destroy(scene);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(perspective_rays_span_the_vertical_field_of_view),
        cmocka_unit_test(orthographic_rays_are_parallel_and_start_in_a_plane),
        cmocka_unit_test(framing_shows_all_corners_and_fills_the_picture),
        cmocka_unit_test(framing_looks_from_the_front_and_above_with_the_horizon_level),
        cmocka_unit_test(nothing_to_frame_still_gives_a_camera),
        cmocka_unit_test(scale_shear_and_mirroring_of_cameras_are_dropped),
        cmocka_unit_test(a_mirrored_camera_sees_the_mirrored_picture),
        cmocka_unit_test(rays_begin_in_the_near_plane),
        cmocka_unit_test(bad_cameras_are_refused_by_field),
        cmocka_unit_test(rays_through_a_lens_meet_in_the_plane_of_focus),
        cmocka_unit_test(the_circle_of_confusion_has_its_size),
        cmocka_unit_test(a_pinhole_is_a_lens_without_size),
        cmocka_unit_test(lenses_and_films_are_kept_and_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

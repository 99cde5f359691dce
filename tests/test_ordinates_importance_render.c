/* Which directions of the sky a scene's camera sees by scattering, as method ordinates asks. */
#include <math.h>

#include "grid_scene.h"
#include "picture_fixture.h"
#include "render/ordinates/importance.h"

static const grid_scene haze = {
    .name = "haze", .lights = GRID_SKY, .sigma_s = {4, 4, 4}, .g = 0.7f};

typedef struct looking {
    air_context *context;
    air_snapshot *snapshot;
    ord_domain domain;
    air_camera_view view;
} looking;

static looking begin(const grid_scene *s)
{
    looking l;
    l.context = make_context(1, NULL);
    assert_int_equal(grid_scene_make(l.context, s, &l.snapshot), AIR_OK);
    assert_int_equal(ord_domain_place(l.snapshot, 8, NULL, &l.domain), AIR_OK);
    assert_int_equal(ord_domain_fill(&l.domain), AIR_OK);
    air_camera_view_init(&l.snapshot->cameras[0], WIDTH, HEIGHT, &l.view);
    return l;
}

static void end(looking *l)
{
    ord_domain_finish(&l->domain);
    air_snapshot_release(l->snapshot);
    air_context_destroy(l->context);
}

/* The largest texel lies within 45 degrees of the view, seen through forward scattering haze. */
static void forward_haze_shows_the_sky_behind_it(void **state)
{
    (void)state;
    looking l = begin(&haze);
    float map[ORD_IMPORTANCE_TEXELS];
    bool made;
    assert_int_equal(ord_importance_make(&l.domain, &l.view, WIDTH, HEIGHT, NULL, map, &made),
                     AIR_OK);
    assert_true(made);
    size_t best = 0;
    for (size_t i = 0; i < ORD_IMPORTANCE_TEXELS; i++) {
        assert_true(isfinite(map[i]) && map[i] >= 0.1f - 1e-4f); /* the floor */
        best = map[i] > map[best] ? i : best;
    }
    const double theta = AIR_PI * ((double)(best / 32) + 0.5) / 16.0;
    const double phi = 2.0 * AIR_PI * (((double)(best % 32) + 0.5) / 32.0 - 0.5);
    /* +Y is up, the centre looks along -Z, +X is at u = 3/4 */
    const double dir[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)};
    assert_true(dir[0] * 0.0 + dir[1] * -0.342 + dir[2] * -0.94 > 0.7);
    end(&l);
}

static void the_map_before_is_mostly_kept(void **state)
{
    (void)state;
    looking l = begin(&haze);
    float map[ORD_IMPORTANCE_TEXELS], before[ORD_IMPORTANCE_TEXELS], out[ORD_IMPORTANCE_TEXELS];
    bool made;
    ord_past past;
    ord_past_init(l.context, &past);
    for (size_t i = 0; i < ORD_IMPORTANCE_TEXELS; i++) {
        before[i] = (float)(i % 7);
    }
    ord_past_begin(&past);
    ord_past_mix_importance(&past, before);
    ord_past_end(&past, &l.domain);
    ord_past_begin(&past);
    assert_int_equal(ord_importance_make(&l.domain, &l.view, WIDTH, HEIGHT, NULL, map, &made),
                     AIR_OK);
    assert_int_equal(ord_importance_make(&l.domain, &l.view, WIDTH, HEIGHT, &past, out, &made),
                     AIR_OK);
    for (size_t i = 0; i < ORD_IMPORTANCE_TEXELS; i++) {
        /* one multiplication and addition in float */
        assert_true(fabsf(out[i] - (0.8f * before[i] + 0.2f * map[i])) <= 1e-6f * (6.0f + map[i]));
    }
    ord_past_finish(&past);
    end(&l);
}

static void views_without_perspective_or_medium_have_no_map(void **state)
{
    (void)state;
    looking l = begin(&haze);
    float map[ORD_IMPORTANCE_TEXELS] = {3.0f};
    bool made = true;
    air_camera_view away = l.view, flat = l.view;
    away.origin = vec3(0.0f, 0.0f, -30.0f); /* looks away from it */
    flat.kind = AIR_CAMERA_ORTHOGRAPHIC;
    assert_int_equal(ord_importance_make(&l.domain, &away, WIDTH, HEIGHT, NULL, map, &made),
                     AIR_OK);
    assert_false(made);
    made = true;
    assert_int_equal(ord_importance_make(&l.domain, &flat, WIDTH, HEIGHT, NULL, map, &made),
                     AIR_OK);
    assert_false(made);
    assert_true(map[0] == 3.0f);
    end(&l);
}

static double mean_of(bool importance)
{
    looking l = begin(&haze);
    air_render_params params = picture("ordinates", 16);
    params.layers = false;
    params.terms = 1u << AIR_TERM_M1 | 1u << AIR_TERM_M2;
    params.max_depth = UINT32_MAX;
    params.ordinates.cells = 12;
    params.ordinates.importance = importance;
    air_image *image = render(l.context, l.snapshot, &params);
    const float *const plane = air_image_plane(image, (size_t)air_image_find_channel(image, "G"));
    double sum = 0.0;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        sum += (double)plane[i];
    }
    air_image_destroy(image);
    end(&l);
    return sum / (WIDTH * HEIGHT);
}

/* Directions differ, the sky's light does not: an even sky is as bright within a twentieth. */
static void steering_moves_directions_and_no_light(void **state)
{
    (void)state;
    const double without = mean_of(false), with = mean_of(true);
    assert_true(with != without);
    if (!(fabs(with / without - 1.0) < 0.05)) {
        fail_msg("%g without, %g with", without, with);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forward_haze_shows_the_sky_behind_it),
        cmocka_unit_test(the_map_before_is_mostly_kept),
        cmocka_unit_test(views_without_perspective_or_medium_have_no_map),
        cmocka_unit_test(steering_moves_directions_and_no_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

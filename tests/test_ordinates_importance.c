#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cmocka_test.h"
#include "importance_fixture.h"

/* ---- books ---- */

/* With any medium; the pyramid's solid angle by another formula, 4 asin(sin(alpha) sin(beta)) of
 * its half angles. Books in floats balance to 1e-5. */
static void books_balance(void **state)
{
    static medium m;
    const air_importance_camera camera = camera_of();
    const double half[2] = {atan((double)camera.tan_half[0]), atan((double)camera.tan_half[1])};
    const double angle = 4.0 * asin(sin(half[0]) * sin(half[1]));
    for (int n = 0; n < 4; n++) {
        float map[TEXELS];
        air_importance_books books;
        fill(&m, n == 1 ? 20.0f : 1.0f, n == 2 ? 1.0f : 0.0f, n == 3 ? -0.6f : 0.7f);
        if (n == 0) {
            fill_unevenly(*state, &camera, &m);
        }
        propagate(*state, &camera, &m, map, &books);
        assert_true(fabs(books.in - angle) < 1e-5 * angle);
        assert_true(fabs(books.through + books.scattered + books.absorbed + books.residual -
                         books.in) < 2e-5 * books.in);
        assert_true(fabs(integral(map) - books.scattered) < 1e-6 * books.scattered);
    }
}

static void clear_air_shows_nothing_by_scattering(void **state)
{
    static medium m;
    const air_importance_camera camera = camera_of();
    float map[TEXELS];
    air_importance_books books;
    fill(&m, 0.0f, 0.0f, 0.0f);
    propagate(*state, &camera, &m, map, &books);
    /* Floats leave a rest of the beam, and of that 1e-19 in the books. */
    assert_true(fabs(books.through - books.in) < 1e-5 && fabs(books.absorbed) < 1e-12);
    for (size_t t = 0; t < TEXELS; t++) {
        assert_true(map[t] >= 0.0f && map[t] < 1e-5f);
    }
    fill(&m, 0.0f, 0.5f, 0.0f);
    propagate(*state, &camera, &m, map, &books);
    air_importance_smooth(map, 0.1f, map);
    for (size_t t = 0; t < TEXELS; t++) {
        assert_true(map[t] == 1.0f);
    }
}

/* The brightest texel lies ahead for g > 0 and behind for g < 0, within a texel and a half. */
static void sharp_lobes_are_seen_ahead(void **state)
{
    static medium m;
    for (int n = 0; n < 8; n++) {
        const air_importance_camera camera = turned_camera(n);
        float map[TEXELS];
        size_t most = 0;
        double w[3];
        fill(&m, 0.2f, 0.0f, n % 2 ? 0.8f : -0.8f);
        propagate(*state, &camera, &m, map, NULL);
        for (size_t t = 0; t < TEXELS; t++) {
            most = map[t] > map[most] ? t : most;
        }
        texel_direction(most, w);
        const double cosine = w[0] * (double)camera.forward[0] + w[1] * (double)camera.forward[1] +
                              w[2] * (double)camera.forward[2];
        assert_true((n % 2 ? cosine : -cosine) > cos(1.5 * AIR_PI / AIR_IMPORTANCE_HEIGHT));
    }
}

static void cells_lie_in_the_pyramid(void **state)
{
    static float points[3 * ALL];
    const air_importance_camera camera = camera_of();
    assert_int_equal(air_importance_points(*state, &camera, points), AIR_OK);
    for (size_t i = 0; i < ALL; i++) {
        const air_vec3 p = vec3_sub(vec3_load(points + 3 * i), vec3_load(camera.position));
        assert_int_equal(cell_at(&camera, p), (ptrdiff_t)i);
    }
}

static void results_are_the_same_each_time(void **state)
{
    static medium m;
    const air_importance_camera camera = camera_of();
    float a[TEXELS], b[TEXELS];
    fill_unevenly(*state, &camera, &m);
    propagate(*state, &camera, &m, a, NULL);
    propagate(*state, &camera, &m, b, NULL);
    assert_memory_equal(a, b, sizeof a);
}

static void results_are_the_same_by_any_number_of_threads(void **state)
{
    static medium m;
    const air_importance_camera camera = camera_of();
    float one[TEXELS], other[TEXELS];
    fill_unevenly(*state, &camera, &m);
    propagate(NULL, &camera, &m, one, NULL);
    for (size_t threads = 1; threads <= 3; threads++) {
        air_context *context = NULL;
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = AIR_CPU_C; /* as without a context */
        params.thread_count = threads;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        propagate(context, &camera, &m, other, NULL);
        assert_memory_equal(one, other, sizeof one);
        air_context_destroy(context);
    }
}

/* ---- maps ---- */

static void smoothing_keeps_what_is_even_and_spreads_a_texel(void **state)
{
    (void)state;
    float map[TEXELS], out[TEXELS];
    for (size_t t = 0; t < TEXELS; t++) {
        map[t] = 3.0f;
    }
    air_importance_smooth(map, 0.1f, out);
    for (size_t t = 0; t < TEXELS; t++) {
        assert_true(fabsf(out[t] - 1.0f) < 1e-6f);
    }
    const size_t at[] = {5 * 32, 0 * 32 + 3, 15 * 32 + 31};
    for (int n = 0; n < 3; n++) {
        size_t touched = 0;
        memset(map, 0, sizeof map);
        map[at[n]] = 1.0f;
        air_importance_smooth(map, 0.1f, out);
        assert_true(fabs(integral(out) - 4.0 * AIR_PI) < 1e-5);
        for (size_t t = 0; t < TEXELS; t++) {
            assert_true(out[t] >= 0.1f - 1e-6f);
            touched += out[t] > 0.1f + 1e-6f;
        }
        assert_int_equal(touched, 9); /* around the horizon and over the poles too */
        assert_true(out[at[n]] > 1.0f);
    }
}

static void blending_keeps_a_share(void **state)
{
    (void)state;
    float a[TEXELS], b[TEXELS];
    for (size_t t = 0; t < TEXELS; t++) {
        a[t] = (float)t;
        b[t] = 2.0f;
    }
    air_importance_blend(a, b, 0.8f, a);
    for (size_t t = 0; t < TEXELS; t++) {
        assert_true(fabsf(a[t] - (0.8f * (float)t + 0.4f)) < 1e-4f);
    }
}

/* ---- refusals ---- */

static void bad_cameras_are_refused(void **state)
{
    static medium m;
    static _Alignas(64) char scratch[1 << 22];
    const air_importance_medium arrays = {m.sigma_s, m.sigma_a, m.g};
    assert_true(air_importance_scratch() <= sizeof scratch);
    fill(&m, 1.0f, 0.0f, 0.0f);
    for (int n = 0; n < 9; n++) {
        air_importance_camera camera = camera_of();
        float map[TEXELS] = {42.0f};
        static float points[3 * ALL];
        points[0] = 42.0f;
        switch (n) {
        case 0:
            camera.position[1] = NAN;
            break;
        case 1:
            camera.right[2] = 1.1f;
            break;
        case 2:
            vec3_store(camera.up, vec3_load(camera.right));
            break;
        case 3:
            camera.forward[0] = INFINITY;
            break;
        case 4:
            camera.tan_half[0] = 0.0f;
            break;
        case 5:
            camera.tan_half[1] = 101.0f;
            break;
        case 6:
            camera.near_m = -1.0f;
            break;
        case 7:
            camera.far_m = camera.near_m;
            break;
        default:
            camera.far_m = INFINITY;
            break;
        }
        assert_int_equal(air_importance_propagate(*state, &camera, &arrays, scratch, map, NULL),
                         AIR_ERROR_ARGUMENT);
        assert_int_equal(air_importance_points(*state, &camera, points), AIR_ERROR_ARGUMENT);
        assert_true(map[0] == 42.0f && points[0] == 42.0f);
    }
}

static void bad_media_are_named(void **state)
{
    static medium m;
    static _Alignas(64) char scratch[1 << 22];
    const air_importance_medium arrays = {m.sigma_s, m.sigma_a, m.g};
    const air_importance_camera camera = camera_of();
    for (int n = 0; n < 5; n++) {
        float map[TEXELS] = {42.0f};
        const size_t cell = (3 * SIDE + 2) * SIDE + 1;
        fill(&m, 1.0f, 0.0f, 0.0f);
        switch (n) {
        case 0:
            m.sigma_s[cell] = -1.0f;
            break;
        case 1:
            m.sigma_s[cell] = NAN;
            break;
        case 2:
            m.sigma_a[cell] = INFINITY;
            break;
        case 3:
            m.g[cell] = 1.0f;
            break;
        default:
            m.g[cell] = NAN;
            break;
        }
        assert_int_equal(air_importance_propagate(*state, &camera, &arrays, scratch, map, NULL),
                         AIR_ERROR_ARGUMENT);
        assert_true(map[0] == 42.0f);
        assert_non_null(strstr(air_context_last_error(*state), "cell (1, 2, 3)"));
    }
    float map[TEXELS] = {42.0f};
    fill(&m, 1.0f, 0.0f, 0.0f);
    assert_int_equal(air_importance_propagate(*state, &camera, &arrays, scratch + 4, map, NULL),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_importance_propagate(*state, &camera, &arrays, NULL, map, NULL),
                     AIR_ERROR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(books_balance),
        cmocka_unit_test(clear_air_shows_nothing_by_scattering),
        cmocka_unit_test(sharp_lobes_are_seen_ahead),
        cmocka_unit_test(cells_lie_in_the_pyramid),
        cmocka_unit_test(results_are_the_same_each_time),
        cmocka_unit_test(results_are_the_same_by_any_number_of_threads),
        cmocka_unit_test(smoothing_keeps_what_is_even_and_spreads_a_texel),
        cmocka_unit_test(blending_keeps_a_share),
        cmocka_unit_test(bad_cameras_are_refused),
        cmocka_unit_test(bad_media_are_named),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

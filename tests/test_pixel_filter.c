/* Pixel filters: where samples lie and how much they count. */
#include <math.h>

#include "path_scene.h"
#include "render/picture.h"

static air_snapshot *sky(void **state)
{
    air_scene *scene = path_scene(state);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    return path_freeze(scene);
}

static air_render_params filtered(air_filter filter)
{
    air_render_params params;
    air_render_params_default(&params);
    params.width = params.height = 8;
    params.filter = filter;
    params.filter_radius = air_filter_radius_default(filter);
    return params;
}

/* The cubic again, as a sum of powers over 18 [Mitchell1988, eq. 8]. */
static double cubic(double x)
{
    const double t = fabs(x);
    return t < 1.0   ? (21.0 * t * t * t - 36.0 * t * t + 16.0) / 18.0
           : t < 2.0 ? (-7.0 * t * t * t + 36.0 * t * t - 60.0 * t + 32.0) / 18.0
                     : 0.0;
}

/* The mean of weight times g over one axis, by midpoints of the filter's number; the other axis is
 * left in its middle and its weight divided out. */
static double mean_of(const air_picture *picture, double (*g)(double))
{
    enum { STEPS = 1 << 20 };
    float x, y;
    double sum = 0.0;
    const float middle = sqrtf(air_picture_sample_position(picture, 0, 0, 0.5f, 0.5f, &x, &y));
    for (int i = 0; i < STEPS; i++) {
        const float u = ((float)i + 0.5f) / STEPS;
        const float weight = air_picture_sample_position(picture, 3, 2, u, 0.5f, &x, &y);
        sum += (double)(weight / middle) * g((double)x - 3.5);
    }
    return sum / STEPS;
}

static double one(double x)
{
    (void)x;
    return 1.0;
}
static double same(double x) { return x; }
static double square(double x) { return x * x; }
static double wave(double x) { return cos(2.5 * x); }

static double integral_of(double (*g)(double))
{
    enum { STEPS = 100000 };
    double sum = 0.0;
    for (int i = 0; i < STEPS; i++) {
        const double x = 4.0 * (i + 0.5) / STEPS - 2.0;
        sum += 4.0 / STEPS * cubic(x) * g(x);
    }
    return sum;
}

static void mitchells_weights_have_the_moments_of_the_filter(void **state)
{
    air_snapshot *snapshot = sky(state);
    const air_render_params params = filtered(AIR_FILTER_MITCHELL);
    air_picture picture;
    assert_int_equal(air_picture_init(&picture, *state, snapshot, &params), AIR_OK);
    double (*const moments[4])(double) = {one, same, square, wave};
    for (int i = 0; i < 4; i++) {
        /* a thousand midpoints in each of the table's intervals; positions are floats of up to 8,
         * weights of up to 1.2 */
        assert_true(fabs(mean_of(&picture, moments[i]) - integral_of(moments[i])) < 2e-6);
    }
    assert_true(fabs(integral_of(one) - 1.0) < 1e-9);
    air_picture_finish(&picture);
    air_snapshot_release(snapshot);
}

static void other_filters_count_every_sample_once(void **state)
{
    air_snapshot *snapshot = sky(state);
    for (int filter = AIR_FILTER_BOX; filter <= AIR_FILTER_GAUSSIAN; filter++) {
        const air_render_params params = filtered((air_filter)filter);
        air_picture picture;
        float x, y;
        assert_int_equal(air_picture_init(&picture, *state, snapshot, &params), AIR_OK);
        for (int i = 0; i < 100; i++) {
            assert_true(air_picture_sample_position(&picture, 1, 2, (float)i / 100.0f, 0.3f, &x,
                                                    &y) == 1.0f);
            assert_true(fabsf(x - 1.5f) <= params.filter_radius);
        }
        air_picture_finish(&picture);
    }
    air_snapshot_release(snapshot);
}

/* A picture of a constant sky is that sky, but for the noise of the weights: they scatter by 0.6
 * about 1 (E w^2 = N^4 with N = 1.12 the integral of the filter's absolute value), and 1024 Sobol
 * samples have well below 0.6 / 32. */
static void a_constant_picture_keeps_its_value(void **state)
{
    air_snapshot *snapshot = sky(state);
    air_render_params params = filtered(AIR_FILTER_MITCHELL);
    air_film *film;
    air_image *image;
    air_resolve_params resolve;
    params.sample_end = 1024;
    assert_int_equal(air_render(*state, snapshot, &params, &film), AIR_OK);
    air_resolve_params_default(&resolve);
    assert_int_equal(air_film_resolve(film, &resolve, &image), AIR_OK);
    for (size_t i = 0; i < 64; i++) {
        assert_true(fabsf(air_image_plane(image, 0)[i] - 1.0f) < 0.02f);
    }
    air_image_destroy(image);
    air_film_destroy(film);
    air_snapshot_release(snapshot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mitchells_weights_have_the_moments_of_the_filter),
        cmocka_unit_test(other_filters_count_every_sample_once),
        cmocka_unit_test(a_constant_picture_keeps_its_value),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

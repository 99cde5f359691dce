/* Coefficients at points, and closed forms of exponential density against quadrature. */
#include <stdlib.h>

#include "core/quadrature.h"
#include "core/random.h"
#include "memory_files.h"
#include "scene/media/field.h"
#include "scene/media/media_build.h"

static int set_up(void **state)
{
    memory_file *files = calloc(1, sizeof *files);
    memory_file_init(files);
    *state = files;
    return 0;
}

static int tear_down(void **state)
{
    memory_file_finish(*state);
    free(*state);
    return 0;
}

static air_medium exponential(float base, float scale)
{
    return (air_medium){.kind = AIR_DENSITY_EXPONENTIAL,
                        .sigma_s = {1, 1, 1},
                        .sigma_t = {1, 1, 1},
                        .up = {0, 1, 0},
                        .base_height = base,
                        .inverse_scale_height = 1.0f / scale};
}

/* The density along a ray, in double. */
static double density_at(const air_medium *m, air_vec3 o, air_vec3 d, double t)
{
    const double h = (double)o.y + (double)d.y * t - (double)m->base_height;
    return exp(-fmax(0.0, h * (double)m->inverse_scale_height));
}

/* Gauss-Legendre on many pieces, split where the ray crosses the base. */
static double quadrature(const air_medium *m, air_vec3 o, air_vec3 d, double t0, double t1)
{
    enum { NODES = 16, PIECES = 64 };
    double nodes[NODES], weights[NODES], sum = 0.0;
    air_gauss_legendre(NODES, nodes, weights);
    double split = d.y != 0.0f ? ((double)m->base_height - (double)o.y) / (double)d.y : t1;
    split = fmin(fmax(split, t0), t1);
    for (int side = 0; side < 2; side++) {
        const double a = side == 0 ? t0 : split, b = side == 0 ? split : t1;
        for (int i = 0; i < PIECES; i++) {
            const double half = 0.5 * (b - a) / PIECES, middle = a + (2 * i + 1) * half;
            for (int n = 0; n < NODES; n++) {
                sum += weights[n] * half * density_at(m, o, d, middle + half * nodes[n]);
            }
        }
    }
    return sum;
}

static air_vec3 random_unit(air_rng *rng, int n)
{
    air_vec3 d =
        vec3(air_rng_float(rng) - 0.5f, air_rng_float(rng) - 0.5f, air_rng_float(rng) - 0.5f);
    d.y *= n % 4 == 0 ? 1e-6f : n % 4 == 1 ? 1e-3f : 1.0f; /* many nearly horizontal */
    d.y = n % 16 == 0 ? 0.0f : d.y;
    return vec3_normalize(d);
}

static void test_depth_equals_quadrature(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 1);
    for (int n = 0; n < 4000; n++) {
        const air_medium m =
            exponential(4.0f * air_rng_float(&rng) - 2.0f, 0.1f + 5.0f * air_rng_float(&rng));
        const air_vec3 o = vec3(0, 10.0f * air_rng_float(&rng) - 5.0f, 0), d = random_unit(&rng, n);
        const float t0 = 3.0f * air_rng_float(&rng),
                    t1 = t0 + 20.0f * air_rng_float(&rng) * air_rng_float(&rng);
        const double expected = quadrature(&m, o, d, (double)t0, (double)t1);
        const double found = (double)air_exponential_depth(&m, o, d, t0, t1);
        /* heights up to 30 in up to 10 scale heights each metre: exponents are rounded to 300 *
         * 2^-24 */
        assert_true(fabs(found - expected) <= 4e-5 * expected + 1e-30);
    }
}

static void test_depth_adds_up_over_pieces(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 1);
    for (int n = 0; n < 2000; n++) {
        const air_medium m = exponential(0.0f, 0.5f + air_rng_float(&rng));
        const air_vec3 o = vec3(0, 4.0f * air_rng_float(&rng) - 2.0f, 0), d = random_unit(&rng, n);
        const float t = 5.0f * air_rng_float(&rng);
        const float whole = air_exponential_depth(&m, o, d, 0.0f, 5.0f);
        const float parts =
            air_exponential_depth(&m, o, d, 0.0f, t) + air_exponential_depth(&m, o, d, t, 5.0f);
        assert_true(fabsf(whole - parts) <= 1e-5f * whole);
    }
}

static void test_depth_to_infinity_is_its_limit(void **state)
{
    (void)state;
    const air_medium m = exponential(1.0f, 2.0f);
    const air_vec3 up = vec3(0, 1, 0);
    /* one metre of density 1 below the base, then the scale height */
    assert_float_equal(air_exponential_depth(&m, vec3_set1(0), up, 0.0f, INFINITY), 3.0f, 1e-6f);
    assert_float_equal(air_exponential_depth(&m, vec3(0, 3, 0), up, 0.0f, INFINITY),
                       2.0f * expf(-1.0f), 1e-6f);
    assert_true(isinf(air_exponential_depth(&m, vec3(0, 3, 0), vec3(1, 0, 0), 0.0f, INFINITY)));
    assert_true(isinf(air_exponential_depth(&m, vec3(0, 3, 0), vec3(0, -1, 0), 0.0f, INFINITY)));
    assert_true(isinf(air_exponential_depth(&m, vec3(0, 0, 0), vec3(0, -1, 0), 0.0f, INFINITY)));
    const float far = air_exponential_depth(&m, vec3_set1(0), vec3(0.6f, 0.8f, 0), 0.0f, 1e30f);
    assert_float_equal(far, 3.0f / 0.8f, 1e-5f);
    /* so high that nothing is left */
    assert_true(air_exponential_depth(&m, vec3(0, 1e6f, 0), vec3(1, 0, 0), 0.0f, INFINITY) == 0.0f);
}

static void test_max_bounds_the_density_and_is_met(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(4, 1);
    for (int n = 0; n < 2000; n++) {
        const air_medium m = exponential(1.0f, 0.5f + air_rng_float(&rng));
        const air_region region = {.density = 1.0f};
        const air_vec3 o = vec3(0, 6.0f * air_rng_float(&rng) - 3.0f, 0), d = random_unit(&rng, n);
        const float t0 = air_rng_float(&rng), t1 = t0 + 4.0f * air_rng_float(&rng);
        const float bound = air_exponential_max(&m, o, d, t0, t1);
        float largest = 0.0f;
        for (int i = 0; i <= 50; i++) {
            const float t = i == 50 ? t1 : t0 + (t1 - t0) * (float)i / 50.0f;
            largest =
                fmaxf(largest, air_medium_coefficients(&m, &region, vec3_madd(o, t, d)).sigma_t.x);
        }
        /* heights of a few metres in units of at least 0.5, rounded to 2^-24 */
        assert_true(largest <= bound * 1.000004f && largest >= bound * 0.999996f);
    }
    const air_medium m = exponential(1.0f, 2.0f);
    assert_float_equal(air_exponential_max(&m, vec3(0, 3, 0), vec3(0, 1, 0), 0.0f, INFINITY),
                       expf(-1.0f), 1e-6f);
    assert_float_equal(air_exponential_max(&m, vec3(0, 3, 0), vec3(0, -1, 0), 0.0f, INFINITY), 1.0f,
                       0.0f);
    assert_float_equal(air_exponential_max(&m, vec3(0, 3, 0), vec3(1, 0, 0), 0.0f, INFINITY),
                       expf(-1.0f), 1e-6f);
}

static air_grid *constant_grid(memory_file *files, size_t channels, const float *value)
{
    float values[2 * 2 * 2 * 3];
    for (size_t i = 0; i < 8 * channels; i++) {
        values[i] = value[i % channels];
    }
    /* voxels fill [0,1]^3 */
    const air_grid_desc desc = {
        .size = {2, 2, 2},
        .channels = channels,
        .values = values,
        .index_to_local = {0.5f, 0, 0, 0.25f, 0, 0.5f, 0, 0.25f, 0, 0, 0.5f, 0.25f}};
    air_grid *grid = NULL;
    assert_int_equal(air_grid_create(files->context, &desc, &grid), AIR_OK);
    return grid;
}

static void expect_vec(air_vec3 v, float x, float y, float z)
{
    assert_float_equal(v.x, x, 1e-6f);
    assert_float_equal(v.y, y, 1e-6f);
    assert_float_equal(v.z, z, 1e-6f);
}

static void test_constant_density_scales_the_coefficients(void **state)
{
    (void)state;
    const air_medium m = {.sigma_s = {1, 2, 3}, .sigma_t = {2, 4, 6}, .emission = {5, 6, 7}};
    const air_region region = {.density = 0.5f};
    const air_coefficients c = air_medium_coefficients(&m, &region, vec3_set1(9.0f));
    expect_vec(c.sigma_s, 0.5f, 1.0f, 1.5f);
    expect_vec(c.sigma_t, 1.0f, 2.0f, 3.0f);
    expect_vec(c.emission, 2.5f, 3.0f, 3.5f);
}

static void test_grids_scale_and_share_out_the_coefficients(void **state)
{
    memory_file *files = *state;
    const float density_value = 2.0f, albedo_value[3] = {0.25f, 0.5f, 1.5f}, emission_value = 3.0f;
    air_grid *density = constant_grid(files, 1, &density_value);
    air_grid *albedo = constant_grid(files, 3, albedo_value);
    air_grid *emission = constant_grid(files, 1, &emission_value);
    air_medium_desc desc;
    air_media media;
    air_medium_desc_default(&desc);
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid = 1;
    desc.density.grid_to_world[0] = 10.0f; /* the grid fills [5,15] x [0,1] x [0,1] */
    desc.density.grid_to_world[3] = 5.0f;
    for (int k = 0; k < 3; k++) {
        desc.sigma_s[k] = 0.25f;
        desc.sigma_a[k] = 0.75f;
        desc.emission[k] = (float)k;
    }
    air_medium_source source = {&desc, density, albedo, emission};
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_OK);
    air_coefficients c =
        air_medium_coefficients(&media.media[0], &media.regions[0], vec3(14.9f, 0.5f, 0.1f));
    expect_vec(c.sigma_t, 2.0f, 2.0f, 2.0f);
    expect_vec(c.sigma_s, 0.5f, 1.0f, 2.0f); /* an albedo above 1 counts as 1 */
    expect_vec(c.emission, 0.0f, 6.0f, 12.0f);
    c = air_medium_coefficients(&media.media[0], &media.regions[0], vec3(4.9f, 0.5f, 0.1f));
    assert_true(vec3_is_zero(c.sigma_t) && vec3_is_zero(c.sigma_s) && vec3_is_zero(c.emission));
    air_media_finish(files->context, &media);
    source.albedo_grid = source.emission_grid = NULL;
    assert_int_equal(air_media_build(files->context, &source, 1, &media), AIR_OK);
    c = air_medium_coefficients(&media.media[0], &media.regions[0], vec3(5.1f, 0.5f, 0.1f));
    expect_vec(c.sigma_t, 2.0f, 2.0f, 2.0f);
    expect_vec(c.sigma_s, 0.5f, 0.5f, 0.5f);
    expect_vec(c.emission, 0.0f, 2.0f, 4.0f);
    air_media_finish(files->context, &media);
    air_grid_destroy(emission);
    air_grid_destroy(albedo);
    air_grid_destroy(density);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_depth_equals_quadrature),
        TEST(test_depth_adds_up_over_pieces),
        TEST(test_depth_to_infinity_is_its_limit),
        TEST(test_max_bounds_the_density_and_is_met),
        TEST(test_constant_density_scales_the_coefficients),
        TEST(test_grids_scale_and_share_out_the_coefficients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

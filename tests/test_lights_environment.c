#include "chi_square.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/warp.h"
#include "light_fixture.h"
#include "scene/lights/environment.h"

enum { MAX_PIXELS = 64 * 32 };

typedef struct picture {
    float pixels[3 * MAX_PIXELS];
    air_texture texture;
    air_light_desc desc;
} picture;

static void start(picture *p, size_t width, size_t height)
{
    memset(p, 0, sizeof *p);
    p->texture =
        (air_texture){.width = width, .height = height, .channels = 3, .floats = p->pixels};
    air_light_desc_default(&p->desc);
    p->desc.name = "sky";
    p->desc.kind = AIR_LIGHT_ENVIRONMENT;
    p->desc.color[0] = p->desc.color[1] = p->desc.color[2] = 1.0f;
}

static void set(picture *p, size_t x, size_t y, float r, float g, float b)
{
    float *pixel = p->pixels + 3 * (y * p->texture.width + x);
    pixel[0] = r;
    pixel[1] = g;
    pixel[2] = b;
}

/* Most pixels dark, some bright, whole rows black. */
static void scatter_pixels(picture *p, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 1);
    for (size_t i = 0; i < p->texture.width * p->texture.height; i++) {
        const size_t row = i / p->texture.width;
        const float level = air_rng_float(&rng);
        const float value = row % 4 == 3    ? 0.0f
                            : level > 0.97f ? 50.0f
                            : level > 0.4f  ? 0.0f
                                            : level;
        set(p, i % p->texture.width, row, value, value * air_rng_float(&rng), 0.5f * value);
    }
}

/* ---- orientation ---- */

static float red_towards(const air_light_table *table, float x, float y, float z)
{
    return air_environment_radiance(&table->entries[0], vec3_normalize(vec3(x, y, z))).x;
}

static void pictures_are_not_mirrored(void **state)
{
    /* 8 x 4: a different number for each of six directions; the two texels around a direction are
     * alike */
    picture p;
    start(&p, 8, 4);
    for (size_t y = 1; y < 3; y++) {
        for (size_t x = 0; x < 8; x++) {
            const float value[8] = {4.0f, 3.0f, 3.0f, 1.0f, 1.0f, 2.0f, 2.0f, 4.0f};
            set(&p, x, y, value[x], 0.0f, 0.0f);
        }
    }
    for (size_t x = 0; x < 8; x++) {
        set(&p, x, 0, 5.0f, 0.0f, 0.0f);
        set(&p, x, 3, 6.0f, 0.0f, 0.0f);
    }
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    const float tolerance = 1e-5f; /* of a bilinear mix of equal texels */
    assert_true(fabsf(red_towards(&table, 0, 0, -1) - 1.0f) < tolerance); /* image centre */
    assert_true(fabsf(red_towards(&table, 1, 0, 0) - 2.0f) < tolerance);  /* right of it */
    assert_true(fabsf(red_towards(&table, -1, 0, 0) - 3.0f) < tolerance); /* left of it */
    assert_true(fabsf(red_towards(&table, 0, 0, 1) - 4.0f) < tolerance); /* behind, over the seam */
    assert_true(fabsf(red_towards(&table, 0, 1, 0) - 5.0f) < tolerance);
    assert_true(fabsf(red_towards(&table, 0, -1, 0) - 6.0f) < tolerance);
    air_light_table_finish(*state, &table);

    /* +90 degrees about +Y takes -Z to -X */
    const float quarter[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    memcpy(p.desc.to_world, quarter, sizeof quarter);
    table = table_of_one(*state, &p.desc, &p.texture);
    assert_true(fabsf(red_towards(&table, -1, 0, 0) - 1.0f) < tolerance);
    assert_true(fabsf(red_towards(&table, 0, 0, -1) - 2.0f) < tolerance);
    air_light_table_finish(*state, &table);
}

static void radiance_is_bilinear_between_texel_centres(void **state)
{
    picture p;
    start(&p, 4, 2);
    set(&p, 1, 0, 8.0f, 0.0f, 0.0f);
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    /* texel (1, 0) is centred at u = 3/8, v = 1/4; a quarter of a texel to the right and half a
     * texel down */
    const double phi = 2.0 * AIR_PI * (3.0 / 8 + 0.25 / 4 - 0.5), theta = AIR_PI * 0.5;
    const float x = (float)(sin(theta) * sin(phi)), y = (float)cos(theta),
                z = (float)(-sin(theta) * cos(phi));
    assert_true(fabsf(red_towards(&table, x, y, z) - 8.0f * 0.75f * 0.5f) < 1e-5f);
    air_light_table_finish(*state, &table);
}

/* ---- density ---- */

static air_vec3 direction_at(double u, double v)
{
    const double phi = 2.0 * AIR_PI * (u - 0.5), theta = AIR_PI * v;
    return vec3((float)(sin(theta) * sin(phi)), (float)cos(theta), (float)(-sin(theta) * cos(phi)));
}

static void density_integrates_to_one(void **state)
{
    const size_t sizes[][2] = {{1, 1}, {2, 1}, {1, 2}, {7, 5}, {32, 16}};
    for (int s = 0; s < 5; s++) {
        picture p;
        start(&p, sizes[s][0], sizes[s][1]);
        scatter_pixels(&p, (uint32_t)s + 1);
        set(&p, 0, 0, 1.0f, 1.0f, 1.0f);
        air_light_table table = table_of_one(*state, &p.desc, &p.texture);
        enum { PER_TEXEL = 16 };
        /* an even number of midpoints per half texel integrates each bilinear piece exactly */
        const size_t nu = p.texture.width * PER_TEXEL, nv = p.texture.height * PER_TEXEL;
        double sum = 0.0;
        for (size_t j = 0; j < nv; j++) {
            for (size_t i = 0; i < nu; i++) {
                const double v = ((double)j + 0.5) / (double)nv;
                const air_vec3 dir = direction_at(((double)i + 0.5) / (double)nu, v);
                sum += (double)air_environment_pdf(&table.entries[0], dir) * sin(AIR_PI * v);
            }
        }
        sum *= 2.0 * AIR_PI * AIR_PI / (double)(nu * nv);
        assert_true(fabs(sum - 1.0) < 1e-4); /* float angles of 2^-22 times slopes of 50 texels */
        air_light_table_finish(*state, &table);
    }
}

static void density_is_positive_where_there_is_light(void **state)
{
    picture p;
    start(&p, 32, 16);
    scatter_pixels(&p, 9);
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    air_rng rng = air_rng_from_keys(6, 1);
    for (int i = 0; i < 100000; i++) {
        const float u1 = air_rng_float(&rng);
        const air_vec3 dir = sample_sphere(u1, air_rng_float(&rng));
        if (vec3_max(air_environment_radiance(&table.entries[0], dir)) > 0.0f) {
            assert_true(air_environment_pdf(&table.entries[0], dir) > 0.0f);
        }
    }
    air_light_table_finish(*state, &table);
}

static void samples_agree_with_the_lookups(void **state)
{
    picture p;
    start(&p, 32, 16);
    scatter_pixels(&p, 3);
    p.desc.color[1] = 0.25f;
    const float tilted[9] = {0.36f, 0.48f, -0.8f, -0.8f, 0.6f, 0.0f, 0.48f, 0.64f, 0.6f};
    memcpy(p.desc.to_world, tilted, sizeof tilted);
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    air_rng rng = air_rng_from_keys(7, 1);
    for (int i = 0; i < 20000; i++) {
        air_light_point point;
        air_connection c;
        const float u1 = air_rng_float(&rng);
        air_light_sample(&table, 0, u1, air_rng_float(&rng), &point);
        assert_true(fabsf(vec3_length(point.dir) - 1.0f) < 1e-6f);
        assert_true(air_light_connect(&table, &point, vec3(4.0f, 5.0f, 6.0f), &c));
        const air_vec3 radiance = air_environment_radiance(&table.entries[0], c.dir);
        const float pdf = air_light_hit_pdf(&table, 0, vec3_set1(0.0f), c.dir, INFINITY);
        /* Rounding of the direction, 2^-22, moves it by 32 2^-22 / (2 pi cos(latitude)) texels, of
         * which one changes radiance by up to 50; twice that is allowed, and for the density, which
         * falls with the latitude, the same of it. */
        const float y = vec3_dot(c.dir, vec3(tilted[1], tilted[4], tilted[7]));
        const float latitude = sqrtf(fmaxf(1e-12f, 1.0f - y * y));
        const float moved = 2.0f * 32.0f * 0x1p-22f / (2.0f * AIR_PI_F * latitude);
        const float scale = c.pdf / fmaxf(1e-3f, vec3_mean(point.value)); /* density per radiance */
        assert_true(fabsf(radiance.y - c.incident.y) <= moved * 50.0f);
        assert_true(fabsf(pdf - c.pdf) <= moved * fmaxf(50.0f * scale, c.pdf / latitude));
    }
    air_light_table_finish(*state, &table);
}

enum { BINS_U = 32, BINS_V = 16, BINS = BINS_U * BINS_V };

static void directions_follow_the_density(void **state)
{
    for (uint32_t seed = 1; seed <= 4; seed++) {
        picture p;
        start(&p, seed % 2 == 0 ? 32 : 7, seed % 2 == 0 ? 16 : 5);
        scatter_pixels(&p, seed);
        air_light_table table = table_of_one(*state, &p.desc, &p.texture);
        enum { FINE = 40, SAMPLES = 200000 };
        double expected[BINS] = {0.0}, observed[BINS] = {0.0};
        for (int j = 0; j < BINS_V * FINE; j++) {
            const double v = (j + 0.5) / (BINS_V * FINE);
            for (int i = 0; i < BINS_U * FINE; i++) {
                const air_vec3 dir = direction_at((i + 0.5) / (BINS_U * FINE), v);
                expected[j / FINE * BINS_U + i / FINE] +=
                    SAMPLES * (double)air_environment_pdf(&table.entries[0], dir) *
                    sin(AIR_PI * v) * 2.0 * AIR_PI * AIR_PI / (BINS * FINE * FINE);
            }
        }
        air_rng rng = air_rng_from_keys(seed, 8);
        for (int i = 0; i < SAMPLES; i++) {
            air_light_point point;
            const float u1 = air_rng_float(&rng);
            air_light_sample(&table, 0, u1, air_rng_float(&rng), &point);
            const float u = 0.5f + atan2f(point.dir.x, -point.dir.z) / (2.0f * AIR_PI_F);
            const float v = acosf(fmaxf(-1.0f, fminf(1.0f, point.dir.y))) / AIR_PI_F;
            const size_t column = (size_t)fminf(u * BINS_U, BINS_U - 1),
                         row = (size_t)fminf(v * BINS_V, BINS_V - 1);
            observed[row * BINS_U + column] += 1.0;
        }
        for (int i = 0; i < BINS; i++) { /* next to nothing: rounding at a black edge */
            if (expected[i] < 0.5 && observed[i] < 5.0) {
                expected[i] = observed[i] = 0.0;
            }
        }
        assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-4);
        air_light_table_finish(*state, &table);
    }
}

/* ---- irradiance ---- */

static double irradiance(const air_light_table *table, air_vec3 normal, double *out_error)
{
    enum { SAMPLES = 200000 };
    air_rng rng = air_rng_from_keys(11, 1);
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        air_light_point point;
        air_connection c;
        const float u1 = air_rng_float(&rng);
        air_light_sample(table, 0, u1, air_rng_float(&rng), &point);
        assert_true(air_light_connect(table, &point, vec3(0.0f, 0.0f, 0.0f), &c));
        const double value = (double)(c.incident.y * fmaxf(0.0f, vec3_dot(c.dir, normal)) / c.pdf);
        sum += value;
        squares += value * value;
    }
    const double mean = sum / SAMPLES;
    *out_error = sqrt((squares / SAMPLES - mean * mean) / SAMPLES);
    return mean;
}

static void constant_environment_gives_pi_times_radiance(void **state)
{
    picture p;
    start(&p, 1, 1);
    p.desc.color[1] = 3.0f;
    double error;
    air_light_table constant = table_of_one(*state, &p.desc, NULL);
    double mean = irradiance(&constant, vec3_normalize(vec3(1.0f, 2.0f, 3.0f)), &error);
    assert_true(fabs(mean - 3.0 * AIR_PI) < 4.5 * error && error < 0.05);
    assert_true(constant.entries[0].environment == NULL);
    air_light_table_finish(*state, &constant);

    start(&p, 16, 8); /* and so does an image of one colour */
    for (size_t i = 0; i < 16 * 8; i++) {
        set(&p, i % 16, i / 16, 1.0f, 3.0f, 2.0f);
    }
    air_light_table image = table_of_one(*state, &p.desc, &p.texture);
    mean = irradiance(&image, vec3_normalize(vec3(1.0f, 2.0f, 3.0f)), &error);
    assert_true(fabs(mean - 3.0 * AIR_PI) < 4.5 * error && error < 0.05);
    air_light_table_finish(*state, &image);
}

static void irradiance_of_an_image_is_its_integral(void **state)
{
    picture p;
    start(&p, 32, 16);
    scatter_pixels(&p, 5);
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    const air_vec3 normal = vec3_normalize(vec3(0.2f, 1.0f, -0.3f));
    enum { NU = 32 * 32, NV = 16 * 32 };
    double exact = 0.0;
    for (int j = 0; j < NV; j++) {
        for (int i = 0; i < NU; i++) {
            const air_vec3 dir = direction_at((i + 0.5) / NU, (j + 0.5) / NV);
            exact += (double)air_environment_radiance(&table.entries[0], dir).y *
                     (double)fmaxf(0.0f, vec3_dot(dir, normal)) * sin(AIR_PI * (j + 0.5) / NV) *
                     2.0 * AIR_PI * AIR_PI / ((double)NU * NV);
        }
    }
    double error;
    const double mean = irradiance(&table, normal, &error);
    assert_true(exact > 0.0 && error < 0.01 * exact);
    assert_true(fabs(mean - exact) < 4.5 * error + 1e-3 * exact); /* midpoints across the horizon */
    air_light_table_finish(*state, &table);
}

/* ---- images of other kinds ---- */

static void bytes_and_grey_images_are_lights_too(void **state)
{
    const uint8_t bytes[2] = {255, 0};
    picture p;
    start(&p, 2, 1);
    p.texture =
        (air_texture){.width = 2, .height = 1, .channels = 1, .bytes = (uint8_t *)(uintptr_t)bytes};
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    assert_true(fabsf(red_towards(&table, -1, 0, 0) - 1.0f) < 1e-6f);
    assert_true(fabsf(red_towards(&table, 1, 0, 0)) < 1e-6f);
    air_light_table_finish(*state, &table);
}

static void black_image_is_harmless(void **state)
{
    picture p;
    start(&p, 4, 2);
    air_light_table table = table_of_one(*state, &p.desc, &p.texture);
    air_light_point point;
    air_connection c;
    air_light_sample(&table, 0, 0.5f, 0.5f, &point);
    assert_true(air_light_connect(&table, &point, vec3(0.0f, 0.0f, 0.0f), &c));
    assert_true(vec3_is_zero(c.incident) && isfinite(c.pdf) && c.pdf > 0.0f);
    air_light_table_finish(*state, &table);
}

static void bad_pixels_are_named(void **state)
{
    const float bad[] = {-1.0f, NAN, INFINITY, 2e30f};
    const float low[3] = {0.0f, 0.0f, 0.0f}, high[3] = {1.0f, 1.0f, 1.0f};
    for (int i = 0; i < 4; i++) {
        picture p;
        start(&p, 8, 4);
        set(&p, 5, 2, 1.0f, bad[i], 1.0f);
        const air_light_source source = {&p.desc, &p.texture};
        air_light_table table;
        memset(&table, 0x55, sizeof table);
        const air_light_table before = table;
        assert_int_equal(
            air_light_table_build(*state, &source, 1, NULL, 0, NULL, low, high, &table, NULL),
            AIR_ERROR_ARGUMENT);
        assert_memory_equal(&table, &before, sizeof table);
        assert_non_null(strstr(air_context_last_error(*state), "\"sky\""));
        assert_non_null(strstr(air_context_last_error(*state), "pixel (5, 2), channel G"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_not_mirrored),
        cmocka_unit_test(radiance_is_bilinear_between_texel_centres),
        cmocka_unit_test(density_integrates_to_one),
        cmocka_unit_test(density_is_positive_where_there_is_light),
        cmocka_unit_test(samples_agree_with_the_lookups),
        cmocka_unit_test(directions_follow_the_density),
        cmocka_unit_test(constant_environment_gives_pi_times_radiance),
        cmocka_unit_test(irradiance_of_an_image_is_its_integral),
        cmocka_unit_test(bytes_and_grey_images_are_lights_too),
        cmocka_unit_test(black_image_is_harmless),
        cmocka_unit_test(bad_pixels_are_named),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}

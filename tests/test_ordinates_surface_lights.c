#include <math.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/triple.h"
#include "core/vec.h"

enum { MOST = AIR_ORDINATES_LIGHTS_MAX, COLUMNS = 64, ROWS = 32, COUNT = COLUMNS * ROWS };

static int set_up(void **state)
{
    air_context *context = NULL;
    const air_status status = air_context_create(NULL, &context);
    *state = context;
    return status == AIR_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    air_context_destroy(*state);
    return 0;
}

typedef struct room {
    float position[3 * COUNT], normal[3 * COUNT], albedo[3 * COUNT], irradiance[3 * COUNT];
    float transmittance[3 * COUNT], area[COUNT];
    air_surface_samples samples;
} room;

/* A floor of 2 x 1 m, rows to and fro, with a coloured, uneven light; without light in a quarter.
 */
static void build(room *r)
{
    air_rng rng = air_rng_from_keys(8, 8);
    for (size_t i = 0; i < COUNT; i++) {
        const size_t y = i / COLUMNS, x = y % 2 ? COLUMNS - 1 - i % COLUMNS : i % COLUMNS;
        const bool dark = x < COLUMNS / 2 && y < ROWS / 2;
        vec3_store(r->position + 3 * i,
                   vec3(((float)x + 0.5f) / 32.0f, 0.0f, ((float)y + 0.5f) / 32.0f));
        vec3_store(r->normal + 3 * i, vec3(0.0f, 1.0f, 0.0f));
        for (size_t k = 0; k < 3; k++) {
            r->albedo[3 * i + k] = air_rng_float(&rng);
            r->irradiance[3 * i + k] = dark ? 0.0f : 10.0f * air_rng_float(&rng);
            r->transmittance[3 * i + k] = 0.5f + 0.5f * air_rng_float(&rng);
        }
        r->area[i] = 1.0f / 1024.0f;
    }
    r->samples = (air_surface_samples){COUNT,         r->position,      r->normal, r->albedo,
                                       r->irradiance, r->transmittance, r->area};
}

static void flux_of(const room *r, double out[3])
{
    out[0] = out[1] = out[2] = 0.0;
    for (size_t i = 0; i < 3 * COUNT; i++) {
        out[i % 3] += (double)r->albedo[i] * (double)r->irradiance[i] *
                      (double)r->transmittance[i] * (double)r->area[i / 3];
    }
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static void choose(void *context, const room *r, size_t count, air_surface_light *out)
{
    assert_int_equal(air_surface_lights_choose(context, &r->samples, count, 0.1, out), AIR_OK);
}

/* Sums of some 1e4 doubles. */
static void fluxes_sum_to_the_samples(void **state)
{
    static room r;
    static air_surface_light lights[MOST];
    double expected[3];
    build(&r);
    flux_of(&r, expected);
    for (size_t count = 1; count <= MOST; count = count == 1 ? 7 : count * 3 + 1) {
        double sum[3] = {0.0, 0.0, 0.0};
        choose(*state, &r, count, lights);
        for (size_t n = 0; n < count; n++) {
            air_along3(sum, 1.0, lights[n].flux, sum);
            /* pieces of equal luminance */
            assert_true(fabs(luminance(lights[n].flux) * (double)count - luminance(expected)) <
                        1e-9 * luminance(expected));
            assert_true(air_finite3(lights[n].position) && lights[n].radius_m > 0.0);
            assert_true(lights[n].lobe > 0.8 && lights[n].lobe < 1.0);
            assert_true(fabs(lights[n].normal[1] - 1.0) < 1e-12);
        }
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(sum[k] - expected[k]) < 1e-12 * expected[k]);
        }
    }
}

/* Moments of what is lit survive too: positions are weighted by luminance, and all pieces have the
 * same. */
static void positions_average_to_the_samples(void **state)
{
    static room r;
    static air_surface_light lights[64];
    double expected[3] = {0.0, 0.0, 0.0}, mean[3] = {0.0, 0.0, 0.0}, all = 0.0;
    build(&r);
    for (size_t i = 0; i < COUNT; i++) {
        double flux[3], p[3];
        for (size_t k = 0; k < 3; k++) {
            flux[k] = (double)r.albedo[3 * i + k] * (double)r.irradiance[3 * i + k] *
                      (double)r.transmittance[3 * i + k];
        }
        vec3_store64(p, vec3_load(r.position + 3 * i));
        air_along3(expected, luminance(flux), p, expected);
        all += luminance(flux);
    }
    choose(*state, &r, 64, lights);
    for (size_t n = 0; n < 64; n++) {
        air_along3(mean, 1.0 / 64.0, lights[n].position, mean);
        /* none in the dark quarter, but where a piece goes around it */
        assert_true(lights[n].position[0] > 0.9 || lights[n].position[2] > 0.5);
    }
    for (int k = 0; k < 3; k++) {
        assert_true(fabs(mean[k] - expected[k] / all) < 1e-9);
    }
}

/* A disk, of samples on rings of equal area: r_0 is its radius, and 1/(r^2 + r_0^2) its irradiance
 * on the axis, which here is summed up: flux/pi z^2 / (z^2 + rho^2)^2 per unit of flux. The lobe is
 * the mean of z / sqrt(z^2 + rho^2). */
static void radius_and_lobe_are_those_of_a_disk(void **state)
{
    enum { RINGS = 40, TURNS = 50 };
    static room r;
    const double radius = 0.3, distance = 0.5;
    build(&r);
    for (size_t i = 0; i < RINGS * TURNS; i++) {
        const double rho = radius * sqrt(((double)(i / TURNS) + 0.5) / RINGS);
        const double phi = 2.0 * AIR_PI * (double)(i % TURNS) / TURNS;
        vec3_store(r.position + 3 * i,
                   vec3((float)(100.0 + rho * cos(phi)), 5.0f, (float)(rho * sin(phi))));
        for (size_t k = 0; k < 3; k++) {
            r.irradiance[3 * i + k] = 1.0f / (RINGS * TURNS);
        }
    }
    r.samples.count = RINGS * TURNS;
    r.samples.albedo = r.samples.transmittance = r.samples.area = NULL;
    air_surface_light light;
    assert_int_equal(air_surface_lights_choose(*state, &r.samples, 1, distance, &light), AIR_OK);
    double irradiance = 0.0, cosine = 0.0;
    for (size_t i = 0; i < RINGS; i++) {
        const double square = radius * radius * ((double)i + 0.5) / RINGS;
        const double away = distance * distance + square;
        irradiance += distance * distance / (away * away) / AIR_PI / RINGS;
        cosine += distance / sqrt(away) / RINGS;
    }
    /* midpoints of 40 rings: 1/(24 40^2) times the second derivative's size, ~1; floats at 100 m:
     * 4e-6 m of 0.3 */
    assert_true(fabs(light.radius_m / radius - 1.0) < 2e-5);
    assert_true(fabs(light.flux[1] - 1.0) < 1e-6);
    const double clamped =
        light.flux[1] / AIR_PI / (distance * distance + light.radius_m * light.radius_m);
    assert_true(fabs(clamped / irradiance - 1.0) < 1e-4);
    assert_true(fabs(light.lobe / cosine - 1.0) < 1e-4);
}

/* One sample, many lights: each is its disk. */
static void one_sample_may_be_cut(void **state)
{
    static room r;
    static air_surface_light lights[8];
    build(&r);
    r.samples.count = 1;
    vec3_store(r.irradiance, vec3(1.0f, 2.0f, 3.0f));
    choose(*state, &r, 8, lights);
    for (int n = 0; n < 8; n++) {
        assert_true(fabs(lights[n].radius_m - sqrt(1.0 / 1024.0 / AIR_PI)) < 1e-9);
        assert_true(fabs(lights[n].position[0] - (double)r.position[0]) < 1e-12);
        assert_true(fabs(lights[n].flux[2] / lights[0].flux[2] - 1.0) < 1e-12);
    }
    r.samples.area = NULL;
    choose(*state, &r, 1, lights);
    assert_true(lights[0].radius_m == 0.0 && lights[0].lobe == 1.0);
}

static void samples_without_light_are_passed_over(void **state)
{
    static room r;
    static air_surface_light lights[4];
    build(&r);
    memset(r.irradiance, 0, sizeof r.irradiance);
    r.irradiance[3 * 100] = r.irradiance[3 * 1500 + 2] = 1.0f; /* red and blue */
    r.samples.albedo = r.samples.transmittance = r.samples.area = NULL;
    choose(*state, &r, 1, lights);
    assert_true(lights[0].flux[0] == 1.0 && lights[0].flux[1] == 0.0 && lights[0].flux[2] == 1.0);
    choose(*state, &r, 4, lights); /* luminances 0.2126 and 0.0722: the last but one is both */
    assert_true(lights[0].position[0] == lights[1].position[0]);
    assert_true(fabs(lights[3].position[0] - (double)r.position[3 * 1500]) < 1e-12);
    assert_true(lights[3].flux[0] == 0.0);
}

static void dark_rooms_give_dark_lights(void **state)
{
    static room r;
    static air_surface_light lights[COUNT / 16];
    build(&r);
    memset(r.irradiance, 0, sizeof r.irradiance);
    choose(*state, &r, COUNT / 16, lights);
    for (size_t n = 0; n < COUNT / 16; n++) {
        assert_true(lights[n].flux[0] == 0.0 && lights[n].flux[1] == 0.0);
        assert_true(fabs(lights[n].position[2] - (double)r.position[3 * 16 * n + 2]) < 1e-6);
    }
}

static void normals_that_cancel_are_the_heaviest(void **state)
{
    static room r;
    air_surface_light light;
    build(&r);
    r.samples.count = 3;
    for (size_t i = 0; i < 9; i++) {
        r.irradiance[i] = i / 3 == 1 ? 2.0f : 1.0f;
    }
    vec3_store(r.normal + 3, vec3(0.0f, -1.0f, 0.0f));
    r.samples.albedo = r.samples.transmittance = r.samples.area = NULL;
    choose(*state, &r, 1, &light);
    assert_true(light.normal[1] == -1.0);
}

static void choices_are_the_same_each_time_and_stable(void **state)
{
    static room r;
    static air_surface_light a[64], b[64];
    build(&r);
    choose(*state, &r, 64, a);
    choose(*state, &r, 64, b);
    assert_memory_equal(a, b, sizeof a);
    /* 1 % more light on one half: cuts move by at most a quarter of a percent of all, 0.16 of a
     * piece, which are 64 x 32 / 48 = 43 samples = 1.3 m of a row long at most */
    for (size_t i = 0; i < 3 * COUNT / 2; i++) {
        r.irradiance[i] *= 1.01f;
    }
    choose(*state, &r, 64, b);
    for (int n = 0; n < 64; n++) {
        double apart[3];
        air_subtract3(a[n].position, b[n].position, apart);
        assert_true(air_length3(apart) < 0.16 * 1.3 * 2.0);
    }
}

static void bad_arguments_are_refused(void **state)
{
    static room r;
    for (int n = 0; n < 14; n++) {
        air_surface_light out = {.lobe = 42.0};
        size_t count = 1;
        double distance = 1.0;
        build(&r);
        switch (n) {
        case 0:
            count = 0;
            break;
        case 1:
            count = MOST + 1;
            break;
        case 2:
            distance = 0.0;
            break;
        case 3:
            distance = NAN;
            break;
        case 4:
            r.samples.count = 0;
            break;
        case 5:
            r.samples.normal = NULL;
            break;
        case 6:
            r.position[3 * 17] = NAN;
            break;
        case 7:
            r.normal[3 * 17] = 1.0f;
            break;
        case 8:
            r.albedo[3 * 17 + 1] = 1.5f;
            break;
        case 9:
            r.irradiance[3 * 17 + 2] = -1.0f;
            break;
        case 10:
            r.irradiance[3 * 17 + 2] = INFINITY;
            break;
        case 11:
            r.transmittance[3 * 17] = NAN;
            break;
        case 12:
            r.area[17] = -1.0f;
            break;
        default:
            r.samples.irradiance = NULL;
            break;
        }
        assert_int_equal(air_surface_lights_choose(*state, &r.samples, count, distance, &out),
                         AIR_ERROR_ARGUMENT);
        assert_true(out.lobe == 42.0);
        assert_true(n < 6 || n == 13 ||
                    strstr(air_context_last_error(*state), "sample 17: expected") != NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fluxes_sum_to_the_samples),
        cmocka_unit_test(positions_average_to_the_samples),
        cmocka_unit_test(radius_and_lobe_are_those_of_a_disk),
        cmocka_unit_test(one_sample_may_be_cut),
        cmocka_unit_test(samples_without_light_are_passed_over),
        cmocka_unit_test(dark_rooms_give_dark_lights),
        cmocka_unit_test(normals_that_cancel_are_the_heaviest),
        cmocka_unit_test(choices_are_the_same_each_time_and_stable),
        cmocka_unit_test(bad_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

/* Lightmaps for Bevy and in RGBM, read back. */
#include <errno.h>
#include <jansson.h>
#include <signal.h>
#include <sys/resource.h>

#include "image/decode.h"
#include "lightmap_fixture.h"

static const float pi = 3.14159265f;

static json_t *read_json(lightmap_fixture *self, const char *name)
{
    json_error_t error;
    json_t *json = json_load_file(lightmap_path(self, name), 0, &error);
    assert_non_null(json);
    return json;
}

static float number(const json_t *object, const char *key, size_t index)
{
    return (float)json_number_value(json_array_get(json_object_get(object, key), index));
}

/* ---- Bevy ---- */

static void bevy_gets_radiance_of_a_white_surface_in_halfs(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    assert_int_equal(air_lightmap_save_bevy(self->context, lightmap, lightmap_path(self, "bevy")),
                     AIR_OK);
    for (size_t p = 0; p < 2; p++) {
        const air_image *page = lightmap->pages[p];
        air_image *image = NULL;
        const char *path =
            lightmap_path(self, p == 0 ? "bevy/lightmap-0.ktx2" : "bevy/lightmap-1.ktx2");
        assert_int_equal(air_image_load(self->context, path, &image), AIR_OK);
        assert_int_equal(air_image_width(image), air_image_width(page));
        for (size_t c = 0; c < 3; c++) {
            for (size_t i = 0; i < air_image_width(page) * air_image_height(page); i++) {
                const float want = air_image_plane_const(page, c)[i] / pi;
                /* 11 bits, and the rounding of the division */
                assert_true(fabsf(air_image_plane(image, c)[i] - want) <=
                            fmaxf(0x1.01p-11f * want, 0x1p-25f));
            }
        }
        air_image_destroy(image);
    }
    assert_int_equal(lightmap_count_files(lightmap_path(self, "bevy")), 3);
    air_lightmap_destroy(lightmap);
}

/* Bevy samples at mix(min, max, uv). */
static void bevys_rectangle_takes_coordinates_to_the_page(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    assert_int_equal(air_lightmap_save_bevy(self->context, lightmap, lightmap_path(self, "bevy")),
                     AIR_OK);
    json_t *root = read_json(self, "bevy/bevy.json");
    assert_true(json_number_value(json_object_get(root, "lightmap_exposure")) == 683.0);
    json_t *meshes = json_object_get(root, "meshes");
    assert_int_equal(json_array_size(meshes), 2); /* the third lies on no page */
    json_t *floor = json_array_get(meshes, 0), *rect = json_object_get(floor, "uv_rect");
    for (size_t k = 0; k < 2; k++) {
        const float low = number(rect, "min", k), high = number(rect, "max", k);
        for (float uv = 0.0f; uv <= 1.0f; uv += 0.25f) {
            const float want = uv * lightmap->meshes[0].scale[k] + lightmap->meshes[0].offset[k];
            assert_true(fabsf(low + uv * (high - low) - want) < 4.0f * 0x1p-24f);
        }
    }
    assert_string_equal(json_string_value(json_object_get(floor, "image")), "lightmap-0.ktx2");
    assert_int_equal(json_integer_value(json_object_get(floor, "node")), 4);
    assert_true(json_is_null(json_object_get(json_array_get(meshes, 1), "uv_rect"))); /* cut */
    json_decref(root);
    lightmap->meshes[0].offset[1] = 0.8f; /* to 1.05 */
    assert_int_equal(air_lightmap_save_bevy(self->context, lightmap, lightmap_path(self, "bevy")),
                     AIR_ERROR_UNSUPPORTED);
    lightmap_expect(self, "mesh 0 (floor) covers 0.8 to 1.05");
    air_lightmap_destroy(lightmap);
}

/* ---- RGBM ---- */

typedef struct picture {
    size_t width, height, channels;
    uint8_t *bytes;
} picture;

static picture read_picture(lightmap_fixture *self, const char *name)
{
    picture result = {0};
    size_t size;
    char *data = lightmap_read(self, name, &size);
    assert_int_equal(air_decode_bytes(self->context, data, size, name, &result.width,
                                      &result.height, &result.channels, &result.bytes),
                     AIR_OK);
    free(data);
    assert_int_equal(result.channels, 4);
    return result;
}

/* Largest error of a page after decoding: as a share of the texel's largest channel where the bound
 * is that share, and of range / (2 * 255^2) elsewhere; both must not pass 1. */
static float worst_error(const picture *read, const air_image *page, float range)
{
    const float floor_error = range / (2.0f * 255.0f * 255.0f);
    float worst = 0.0f;
    for (size_t i = 0; i < read->width * read->height; i++) {
        float largest = 0.0f;
        for (size_t c = 0; c < 3; c++) {
            largest = fmaxf(largest, air_image_plane_const(page, c)[i] / pi);
        }
        const float bound = fmaxf(largest / 255.0f, floor_error);
        for (size_t c = 0; c < 3; c++) {
            const uint8_t *bytes = read->bytes + 4 * i;
            const float got = (float)bytes[c] / 255.0f * (float)bytes[3] / 255.0f * range;
            worst = fmaxf(worst, fabsf(got - air_image_plane_const(page, c)[i] / pi) / bound);
        }
    }
    return worst;
}

/* Light over five decades. */
static void spread_page(lightmap_fixture *self, air_image *page)
{
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < air_image_width(page) * air_image_height(page); i++) {
            air_image_plane(page, c)[i] = exp2f(4.0f * lightmap_number(self) - 12.0f);
        }
    }
}

static void rgbm_keeps_the_error_it_states(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    lightmap_add_page(self, lightmap, lightmap_page(self, 200, 150, 13));
    spread_page(self, lightmap->pages[0]);
    const float peak = air_lightmap_peak(lightmap);
    assert_int_equal(
        air_lightmap_save_rgbm(self->context, lightmap, lightmap_path(self, "rgbm"), peak), AIR_OK);
    assert_int_equal(self->warnings, 0);
    picture read = read_picture(self, "rgbm/page-0.png");
    assert_int_equal(read.width, 200);
    assert_int_equal(read.height, 150);
    const float worst = worst_error(&read, lightmap->pages[0], peak);
    assert_true(worst <= 1.0001f); /* roundings of floats */
    assert_true(worst > 0.5f);     /* the bound is no idle one */
    json_t *root = read_json(self, "rgbm/rgbm.json");
    assert_true((float)json_number_value(json_object_get(root, "range")) == peak);
    json_decref(root);
    air_free(self->context, read.bytes);
    air_lightmap_destroy(lightmap);
}

static void the_peak_is_the_largest_light_of_all_pages(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    air_image_plane(lightmap->pages[1], 2)[7] = 100.0f;
    assert_true(fabsf(air_lightmap_peak(lightmap) - 100.0f / pi) < 1e-5f);
    air_image_plane(lightmap->pages[0], 3)[7] = 1000.0f; /* a layer is no page's sum */
    assert_true(fabsf(air_lightmap_peak(lightmap) - 100.0f / pi) < 1e-5f);
    air_lightmap_destroy(lightmap);
}

static void what_is_brighter_than_the_range_keeps_its_hue(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    lightmap_add_page(self, lightmap, lightmap_page(self, 1, 1, 13));
    for (size_t c = 0; c < 3; c++) {
        air_image_plane(lightmap->pages[0], c)[0] = pi * (c == 0 ? 4.0f : c == 1 ? 1.0f : -1.0f);
    }
    assert_int_equal(
        air_lightmap_save_rgbm(self->context, lightmap, lightmap_path(self, "rgbm"), 2.0f), AIR_OK);
    picture read = read_picture(self, "rgbm/page-0.png");
    static const uint8_t want[4] = {255, 64, 0, 255}; /* (1, 1/4, 0) */
    assert_memory_equal(read.bytes, want, 4);
    assert_int_equal(self->warnings, 1);
    assert_non_null(strstr(self->warning, "rgbm/page-0.png: 1 texels are brighter"));
    air_free(self->context, read.bytes);
    assert_int_equal(
        air_lightmap_save_rgbm(self->context, lightmap, lightmap_path(self, "rgbm"), 0.0f),
        AIR_ERROR_ARGUMENT);
    lightmap_expect(self, "the range is 0");
    air_lightmap_destroy(lightmap);
}

/* ---- both ---- */

static air_status write_bevy(lightmap_fixture *self, const air_lightmap *lightmap)
{
    return air_lightmap_save_bevy(self->context, lightmap, lightmap_path(self, "out"));
}

static air_status write_rgbm(lightmap_fixture *self, const air_lightmap *lightmap)
{
    return air_lightmap_save_rgbm(self->context, lightmap, lightmap_path(self, "out"), 1.0f);
}

static air_status (*const writers[2])(lightmap_fixture *, const air_lightmap *) = {write_bevy,
                                                                                   write_rgbm};

static void writing_without_memory_leaves_nothing(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    const long live = atomic_load(&self->allocator.live);
    for (size_t w = 0; w < 2; w++) {
        air_status status = AIR_ERROR_MEMORY;
        long allowed = 0;
        for (; status != AIR_OK && allowed < 1000; allowed++) {
            atomic_store(&self->allocator.remaining, allowed);
            status = writers[w](self, lightmap);
            atomic_store(&self->allocator.remaining, LIGHTMAP_MANY);
            assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
            assert_int_equal(atomic_load(&self->allocator.live), live);
            assert_int_equal(access(lightmap_path(self, "out"), F_OK) == 0, status == AIR_OK);
        }
        assert_true(allowed > 10 && status == AIR_OK);
        (void)lightmap_remove(lightmap_path(self, "out"));
    }
    air_lightmap_destroy(lightmap);
}

static void a_full_disk_leaves_the_older_files(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    for (size_t w = 0; w < 2; w++) {
        assert_int_equal(writers[w](self, lightmap), AIR_OK);
        const size_t files = lightmap_count_files(lightmap_path(self, "out"));
        struct rlimit before;
        assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
        void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
        const struct rlimit small = {500, before.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        const air_status status = writers[w](self, lightmap);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        (void)signal(SIGXFSZ, handler);
        assert_int_equal(status, AIR_ERROR_IO);
        lightmap_expect(self, strerror(EFBIG));
        assert_int_equal(lightmap_count_files(lightmap_path(self, "out")), files);
        (void)lightmap_remove(lightmap_path(self, "out"));
    }
    air_lightmap_destroy(lightmap);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, lightmap_start, lightmap_finish)
    const struct CMUnitTest tests[] = {
        TEST(bevy_gets_radiance_of_a_white_surface_in_halfs),
        TEST(bevys_rectangle_takes_coordinates_to_the_page),
        TEST(rgbm_keeps_the_error_it_states),
        TEST(the_peak_is_the_largest_light_of_all_pages),
        TEST(what_is_brighter_than_the_range_keeps_its_hue),
        TEST(writing_without_memory_leaves_nothing),
        TEST(a_full_disk_leaves_the_older_files),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}

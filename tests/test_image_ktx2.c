/* KTX 2 in and out. */
#include <zstd.h>

#include "image/ktx2.h"
#include "image_fixture.h"

enum { FRONT = AIR_KTX2_HEADER + AIR_KTX2_LEVEL, CAPACITY = 1 << 16 };

static void put(uint8_t *out, size_t bytes, uint64_t value)
{
    for (size_t i = 0; i < bytes; i++) {
        out[i] = (uint8_t)(value >> (8 * i));
    }
}

/* A file of one level without data format descriptor and keys; returns its size. */
static size_t make_file(uint8_t *out, uint32_t vk_format, uint32_t width, uint32_t height,
                        const void *pixels, size_t size, bool zstandard)
{
    memset(out, 0, FRONT);
    memcpy(out, air_ktx2_identifier, sizeof air_ktx2_identifier);
    put(out + 12, 4, vk_format);
    put(out + 20, 4, width);
    put(out + 24, 4, height);
    put(out + 36, 4, 1);
    put(out + 40, 4, 1);
    put(out + 44, 4, zstandard ? AIR_KTX2_ZSTANDARD : 0);
    put(out + 80, 8, FRONT);
    put(out + 96, 8, size);
    size_t packed = size;
    if (zstandard) {
        packed = ZSTD_compress(out + FRONT, CAPACITY - FRONT, pixels, size, 1);
        assert_false(ZSTD_isError(packed));
    } else {
        memcpy(out + FRONT, pixels, size);
    }
    put(out + 88, 8, packed);
    return FRONT + packed;
}

static air_image *load(image_fixture *self, const uint8_t *file, size_t size)
{
    air_image *image = NULL;
    image_write_file(self, "a.ktx2", file, size);
    if (air_image_load(self->context, self->path, &image) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    return image;
}

static float value(air_image *image, size_t channel, size_t index)
{
    return air_image_plane(image, channel)[index];
}

static void shared_exponents_mean_what_the_format_says(void **state)
{
    image_fixture *self = *state;
    /* mantissa * 2^(exponent - 15 - 9) */
    const uint32_t words[3] = {1u | 2u << 9 | 511u << 18 | 15u << 27, 0u, 256u | 31u << 27};
    uint8_t pixels[12], file[CAPACITY];
    for (size_t i = 0; i < 3; i++) {
        put(pixels + 4 * i, 4, words[i]);
    }
    for (int zstandard = 0; zstandard < 2; zstandard++) {
        const size_t size =
            make_file(file, AIR_VK_E5B9G9R9_UFLOAT_PACK32, 3, 1, pixels, 12, zstandard);
        air_image *image = load(self, file, size);
        assert_int_equal(air_image_width(image), 3);
        assert_int_equal(air_image_height(image), 1);
        assert_true(value(image, 0, 0) == 1.0f / 512.0f);
        assert_true(value(image, 1, 0) == 2.0f / 512.0f);
        assert_true(value(image, 2, 0) == 511.0f / 512.0f);
        assert_true(value(image, 0, 1) == 0.0f);
        assert_true(value(image, 0, 2) == 32768.0f);
        air_image_destroy(image);
    }
}

static void small_floats_mean_what_the_format_says(void **state)
{
    image_fixture *self = *state;
    /* R and G: 5 bits of exponent, 6 of mantissa; B: 5 and 5. 1 is exponent 15. */
    const uint32_t one11 = 15u << 6, one10 = 15u << 5;
    const uint32_t words[2] = {one11 | (one11 | 32u) << 11 | (one10 + (1u << 5)) << 22,
                               1u | (30u << 6 | 63u) << 11 | 31u << 27};
    uint8_t pixels[8], file[CAPACITY];
    put(pixels, 4, words[0]);
    put(pixels + 4, 4, words[1]);
    const size_t size = make_file(file, AIR_VK_B10G11R11_UFLOAT_PACK32, 1, 2, pixels, 8, false);
    air_image *image = load(self, file, size);
    assert_true(value(image, 0, 0) == 1.0f);
    assert_true(value(image, 1, 0) == 1.5f);
    assert_true(value(image, 2, 0) == 2.0f);
    assert_true(value(image, 0, 1) == 0x1p-20f); /* the smallest: 2^-14 / 64 */
    assert_true(value(image, 1, 1) == 65024.0f); /* the largest: 2^15 (2 - 1/64) */
    assert_true(isinf(value(image, 2, 1)));
    air_image_destroy(image);
}

static void rows_may_be_stored_from_the_bottom(void **state)
{
    image_fixture *self = *state;
    static const uint8_t keys[] = "\x05\0\0\0aa\0b\0\0\0\0\x12\0\0\0KTXorientation\0ru\0";
    const uint32_t words[2] = {15u << 6, 16u << 6};
    uint8_t pixels[8], file[CAPACITY];
    put(pixels, 4, words[0]);
    put(pixels + 4, 4, words[1]);
    size_t size = make_file(file, AIR_VK_B10G11R11_UFLOAT_PACK32, 1, 2, pixels, 8, false);
    put(file + 56, 4, size);
    put(file + 60, 4, sizeof keys - 1);
    memcpy(file + size, keys, sizeof keys - 1);
    size += sizeof keys - 1;
    air_image *image = load(self, file, size);
    assert_true(value(image, 0, 0) == 2.0f);
    assert_true(value(image, 0, 1) == 1.0f);
    air_image_destroy(image);
    put(file + size - (sizeof keys - 1), 4, 1000); /* the first key ends beyond the keys */
    image_write_file(self, "a.ktx2", file, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "a key of 1000 bytes");
}

static air_image *make_noise(image_fixture *self, size_t width, size_t height)
{
    air_image *image = image_make_rgb(self, width, height);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < width * height; i++) {
            air_image_plane(image, c)[i] =
                (float)exp2(30.0 * image_fixture_random(self) - 15.0) * (i % 5 == 0 ? -1.0f : 1.0f);
        }
    }
    return image;
}

static void floats_come_back_exactly_and_halfs_rounded(void **state)
{
    image_fixture *self = *state;
    air_image *image = make_noise(self, 37, 21);
    air_image_plane(image, 2)[0] = -1e9f;
    air_image_plane(image, 2)[1] = INFINITY;
    for (int half = 0; half < 2; half++) {
        air_image_save_params params;
        air_image_save_params_default(&params);
        params.half = half;
        const char *path = image_fixture_path(self, "b.ktx2");
        assert_int_equal(air_image_save(self->context, image, path, &params), AIR_OK);
        air_image *back = NULL;
        assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
        assert_int_equal(air_image_width(back), 37);
        for (size_t c = 0; c < 3; c++) {
            for (size_t i = 0; i < 37 * 21; i++) {
                const float want = value(image, c, i), got = value(back, c, i);
                if (!half || isinf(want)) {
                    assert_true(got == want);
                } else if (want == -1e9f) {
                    assert_true(got == -65504.0f);
                } else {
                    /* 11 bits, rounded: 2^-11 of the value; 2^-25 below 2^-14 */
                    assert_true(fabsf(got - want) <= fmaxf(0x1p-11f * fabsf(want), 0x1p-25f));
                }
            }
        }
        assert_int_equal(self->warnings, half);
        air_image_destroy(back);
    }
    air_image_destroy(image);
}

/* What a reader that goes by the container alone finds [KTX2, section 3]. */
static void the_container_is_laid_out_as_specified(void **state)
{
    image_fixture *self = *state;
    air_image *image = make_noise(self, 5, 4);
    air_image_save_params params;
    air_image_save_params_default(&params);
    params.half = true;
    assert_int_equal(
        air_image_save(self->context, image, image_fixture_path(self, "c.ktx2"), &params), AIR_OK);
    uint8_t file[CAPACITY], pixels[5 * 4 * 8];
    const size_t size = image_read_file(self->path, file, CAPACITY);
    uint32_t head[17];
    memcpy(head, file + 12, sizeof head); /* this machine is little-endian, as the format is */
    assert_int_equal(head[0], 97);
    assert_int_equal(head[1], 2);
    assert_int_equal(head[9], FRONT);            /* descriptor: right behind the levels */
    assert_int_equal(head[10], 4 + 24 + 4 * 16); /* its own size, header, four samples */
    assert_int_equal(head[11], FRONT + 92);      /* keys: behind it */
    assert_int_equal(file[head[9]], 92);
    assert_memory_equal(file + head[11] + 4, "KTXorientation\0rd", 18);
    uint64_t level[3];
    memcpy(level, file + 80, sizeof level);
    assert_int_equal(level[0], head[11] + head[12]);
    assert_int_equal(level[0] + level[1], size);
    assert_int_equal(level[2], sizeof pixels);
    assert_int_equal(ZSTD_decompress(pixels, sizeof pixels, file + level[0], level[1]),
                     sizeof pixels);
    assert_int_equal(pixels[6] | pixels[7] << 8, 0x3c00); /* alpha: 1 */
    air_image_destroy(image);
}

static void what_cannot_be_read_is_refused_by_name(void **state)
{
    image_fixture *self = *state;
    uint8_t pixels[16] = {0}, file[CAPACITY];
    const size_t size =
        make_file(file, AIR_VK_E5B9G9R9_UFLOAT_PACK32, 2, 2, pixels, sizeof pixels, false);
    static const struct {
        size_t byte, size;
        uint64_t value;
        air_status status;
        const char *part;
    } edits[] = {
        {1, 1, 'k', AIR_ERROR_FORMAT, "byte 0: expected the identifier"},
        {12, 4, 43, AIR_ERROR_UNSUPPORTED, "format 43 cannot be read"},
        {20, 4, 0, AIR_ERROR_FORMAT, "each side must be"},
        {20, 4, 3, AIR_ERROR_FORMAT, "has 16 bytes, 3 x 2 pixels need 24"},
        {24, 4, 70000, AIR_ERROR_FORMAT, "each side must be"},
        {28, 4, 1, AIR_ERROR_UNSUPPORTED, "expected one flat picture"},
        {32, 4, 2, AIR_ERROR_UNSUPPORTED, "expected one flat picture"},
        {36, 4, 6, AIR_ERROR_UNSUPPORTED, "expected one flat picture"},
        {40, 4, 17, AIR_ERROR_FORMAT, "17 levels"},
        {44, 4, 1, AIR_ERROR_UNSUPPORTED, "supercompression 1 cannot be read"},
        {44, 4, 2, AIR_ERROR_FORMAT, "damaged Zstandard data"},
        {56, 4, 4000, AIR_ERROR_FORMAT, "the keys lie outside"},
        {80, 8, UINT64_MAX, AIR_ERROR_FORMAT, "truncated"},
        {80, 8, FRONT + 1, AIR_ERROR_FORMAT, "truncated"},
        {88, 8, 15, AIR_ERROR_FORMAT, "byte 80"},
        {96, 8, 17, AIR_ERROR_FORMAT, "byte 80"},
    };
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        uint8_t edited[CAPACITY];
        memcpy(edited, file, size);
        put(edited + edits[i].byte, edits[i].size, edits[i].value);
        image_write_file(self, "a.ktx2", edited, size);
        image_check_refused(self, self->path, edits[i].status, edits[i].part);
    }
}

/* A short file must not make us take memory out of proportion. */
static void a_picture_that_cannot_be_in_so_few_bytes_is_refused(void **state)
{
    image_fixture *self = *state;
    uint8_t file[CAPACITY], pixels[16] = {0};
    const size_t size = make_file(file, AIR_VK_E5B9G9R9_UFLOAT_PACK32, 2, 2, pixels, 16, true);
    put(file + 20, 4, 12000);
    put(file + 24, 4, 12000);
    put(file + 96, 8, (uint64_t)12000 * 12000 * 4);
    image_write_file(self, "a.ktx2", file, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "truncated");
}

static void truncations_and_damage_are_refused(void **state)
{
    image_fixture *self = *state;
    air_image *image = make_noise(self, 9, 9);
    assert_int_equal(air_image_save(self->context, image, image_fixture_path(self, "a.ktx2"), NULL),
                     AIR_OK);
    uint8_t file[CAPACITY];
    const size_t size = image_read_file(self->path, file, CAPACITY);
    image_check_truncations(self, "a.ktx2", file, size, 7);
    air_image_destroy(image);
}

/* Lightmaps that another baker wrote. */
static void shared_lightmaps_are_read(void **state)
{
    static const char *const names[] = {"Box", "Large", "Small"};
    (void)state;
    air_context *context = NULL;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    for (size_t i = 0; i < 3; i++) {
        char path[512];
        (void)snprintf(path, sizeof path, "%s/scenes/bevy/lightmaps/CornellBox-%s.zstd.ktx2",
                       AIR_SHARED_DIR, names[i]);
        if (access(path, R_OK) != 0) {
            print_message("%s is not here: skipped\n", path);
            air_context_destroy(context);
            skip();
        }
        air_image *image = NULL;
        assert_int_equal(air_image_load(context, path, &image), AIR_OK);
        assert_int_equal(air_image_width(image), 1024);
        assert_int_equal(air_image_height(image), 1024);
        /* Some 600 texels beside seams are infinite or no numbers; of the others all are light. */
        int odd = 0;
        for (size_t k = 0; k < 1024 * 1024; k++) {
            const float x = air_image_plane(image, 0)[k];
            odd += isfinite(x) ? 0 : 1;
            assert_true(!isfinite(x) || x >= 0.0f);
        }
        assert_true(odd < 1000);
        air_image_destroy(image);
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(shared_exponents_mean_what_the_format_says,
                                        image_fixture_start, image_fixture_finish),
        cmocka_unit_test_setup_teardown(small_floats_mean_what_the_format_says, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test_setup_teardown(rows_may_be_stored_from_the_bottom, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test_setup_teardown(floats_come_back_exactly_and_halfs_rounded,
                                        image_fixture_start, image_fixture_finish),
        cmocka_unit_test_setup_teardown(the_container_is_laid_out_as_specified, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test_setup_teardown(what_cannot_be_read_is_refused_by_name, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test_setup_teardown(a_picture_that_cannot_be_in_so_few_bytes_is_refused,
                                        image_fixture_start, image_fixture_finish),
        cmocka_unit_test_setup_teardown(truncations_and_damage_are_refused, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test(shared_lightmaps_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

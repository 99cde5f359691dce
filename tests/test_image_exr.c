/* OpenEXR in and out. Files other than our own kind are written with OpenEXRCore here. */
#include <OpenEXR/openexr.h>

#include "failing_allocator.h"
#include "image_fixture.h"

/* A number that uses many bits, different at each place. */
static float sample(size_t channel, size_t x, size_t y)
{
    return (float)(1.0 / 3.0 + (double)channel * 1.7 + (double)x * 0.013 + (double)y * 1.1e-5);
}

static air_image *make_layers(image_fixture *self, size_t width, size_t height)
{
    /* Not in alphabetical order, names longer than 31 characters among them. */
    static const char *const names[6] = {"S0.R", "R", "G",
                                         "B",    "A", "a layer with a long name, truly long.R"};
    air_image *image = image_make(self, width, height, 6, names);
    for (size_t c = 0; c < 6; c++) {
        for (size_t y = 0; y < height; y++) {
            for (size_t x = 0; x < width; x++) {
                air_image_plane(image, c)[y * width + x] = sample(c, x, y);
            }
        }
    }
    return image;
}

static air_image *save_and_load(image_fixture *self, const air_image *image, bool half)
{
    air_image_save_params params;
    air_image_save_params_default(&params);
    params.half = half;
    const char *const path = image_fixture_path(self, "a.exr");
    assert_int_equal(air_image_save(self->context, image, path, &params), AIR_OK);
    air_image *back = NULL;
    assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
    assert_int_equal(air_image_width(back), air_image_width(image));
    assert_int_equal(air_image_height(back), air_image_height(image));
    assert_int_equal(air_image_channel_count(back), air_image_channel_count(image));
    return back;
}

static void float_round_trip_keeps_every_bit(void **state)
{
    image_fixture *self = *state;
    air_image *image = make_layers(self, 37, 45); /* neither a multiple of the block of 16 rows */
    float *const odd = air_image_plane(image, 1);
    const float strange[6] = {-0.0f, INFINITY, -INFINITY, 1e-42f, 3.4e38f, -1e-30f};
    memcpy(odd + 100, strange, sizeof(strange));
    const uint32_t nan_bits = 0x7FC01234u;
    memcpy(odd + 200, &nan_bits, sizeof(nan_bits));
    air_image *back = save_and_load(self, image, false);
    for (size_t c = 0; c < 6; c++) {
        const ptrdiff_t k = air_image_find_channel(back, air_image_channel_name(image, c));
        assert_true(k >= 0);
        assert_memory_equal(air_image_plane(image, c), air_image_plane(back, (size_t)k),
                            37 * 45 * sizeof(float));
    }
    air_image_destroy(back);
    air_image_destroy(image);
}

/* A block of 1024 bytes, of which more and more are noise: its size compressed grows past that of
 * the block in steps of a few bytes, and with 4 kinds of noise meets it too. */
static void blocks_that_do_not_compress_keep_every_bit(void **state)
{
    enum { SIDE = 16, KINDS = 4 };
    static const char *const names[1] = {"Y"};
    image_fixture *self = *state;
    air_image *image = image_make(self, SIDE, SIDE, 1, names);
    float *const pixels = air_image_plane(image, 0);
    for (uint32_t kind = 0; kind < KINDS; kind++) {
        uint32_t bits = 1 + kind;
        memset(pixels, 0, SIDE * SIDE * sizeof *pixels);
        for (size_t i = 0; i < SIDE * SIDE; i++) {
            bits = bits * 747796405u + 2891336453u;
            memcpy(&pixels[i], &bits, sizeof bits);
            if (i < SIDE * SIDE * 3 / 4) {
                continue;
            }
            air_image *back = save_and_load(self, image, false);
            assert_memory_equal(air_image_plane(back, 0), pixels, SIDE * SIDE * sizeof *pixels);
            air_image_destroy(back);
        }
    }
    air_image_destroy(image);
}

static void channels_come_back_in_alphabetical_order(void **state)
{
    image_fixture *self = *state;
    air_image *image = make_layers(self, 2, 2);
    air_image *back = save_and_load(self, image, false);
    for (size_t c = 1; c < 6; c++) {
        assert_true(strcmp(air_image_channel_name(back, c - 1), air_image_channel_name(back, c)) <
                    0);
    }
    air_image_destroy(back);
    air_image_destroy(image);
}

static void string_attributes_survive(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 3, 2);
    char long_value[3000];
    memset(long_value, 'v', sizeof(long_value) - 1);
    long_value[sizeof(long_value) - 1] = '\0';
    assert_int_equal(air_image_set_attribute(image, "airlight:seed", "7"), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "airlight:command", long_value), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "empty", ""), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "unicode", "N\xc3\xa4he 50 m"), AIR_OK);
    air_image *back = save_and_load(self, image, false);
    assert_int_equal(air_image_attribute_count(back), 4);
    for (size_t i = 0; i < 4; i++) {
        const char *const name = air_image_attribute_name(image, i);
        assert_non_null(air_image_attribute(back, name));
        assert_string_equal(air_image_attribute(back, name), air_image_attribute(image, name));
    }
    air_image_destroy(back);
    air_image_destroy(image);
}

static void attributes_that_clash_with_the_format_are_refused(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 3, 2);
    assert_int_equal(air_image_set_attribute(image, "compression", "none"), AIR_OK);
    const char *const path = image_fixture_path(self, "a.exr");
    assert_int_equal(air_image_save(self->context, image, path, NULL), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(self->context), "compression"));
    assert_int_not_equal(access(path, F_OK), 0);
    air_image_destroy(image);
}

static void half_rounds_to_eleven_bits(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 64, 33);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < 64 * 33; i++) {
            const double exponent = 28.0 * image_fixture_random(self) - 13.5;
            air_image_plane(image, c)[i] = (float)exp2(exponent) * (i % 2 == 0 ? 1.0f : -1.0f);
        }
    }
    air_image *back = save_and_load(self, image, true);
    for (size_t c = 0; c < 3; c++) {
        const ptrdiff_t k = air_image_find_channel(back, air_image_channel_name(image, c));
        for (size_t i = 0; i < 64 * 33; i++) {
            const float value = air_image_plane(image, c)[i];
            const float error = fabsf(air_image_plane(back, (size_t)k)[i] - value);
            /* Normal halfs carry 11 significant bits: half a unit in the last place is 2^-11. */
            assert_true(error <= fabsf(value) * 0x1p-11f);
        }
    }
    assert_int_equal(self->warnings, 0);
    air_image_destroy(back);
    air_image_destroy(image);
}

static void half_clamps_what_it_cannot_hold_and_says_so(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 2, 2);
    const float values[4] = {68300.0f, -1e9f, INFINITY, 65504.0f};
    memcpy(air_image_plane(image, 0), values, sizeof(values));
    air_image *back = save_and_load(self, image, true);
    const float *const red = air_image_plane_const(back, (size_t)air_image_find_channel(back, "R"));
    assert_true(red[0] == 65504.0f && red[1] == -65504.0f);
    assert_true(isinf(red[2]) && red[3] == 65504.0f);
    assert_int_equal(self->warnings, 1);
    air_image_destroy(back);
    air_image_destroy(image);
}

static void the_number_of_threads_leaves_no_trace(void **state)
{
    image_fixture *self = *state;
    air_image *image = make_layers(self, 200, 150);
    static uint8_t files[2][2 << 20];
    size_t sizes[2];
    for (size_t i = 0; i < 2; i++) {
        air_context_params params;
        air_context_params_default(&params);
        params.thread_count = i == 0 ? 1 : 3;
        air_context *context = NULL;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        const char *const path = image_fixture_path(self, "a.exr");
        assert_int_equal(air_image_save(context, image, path, NULL), AIR_OK);
        sizes[i] = image_read_file(path, files[i], sizeof(files[i]));
        air_context_destroy(context);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(files[0], files[1], sizes[0]);
    air_image_destroy(image);
}

/* ---- files of other kinds ---- */

typedef struct foreign {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t data, display;
    exr_pixel_type_t types[3]; /* of B, G, R */
    int parts;
} foreign;

static foreign foreign_default(void)
{
    return (foreign){.storage = EXR_STORAGE_SCANLINE,
                     .compression = EXR_COMPRESSION_ZIP,
                     .data = {{{{0, 0}}}, {{{39, 29}}}},
                     .display = {{{{0, 0}}}, {{{39, 29}}}},
                     .types = {EXR_PIXEL_FLOAT, EXR_PIXEL_FLOAT, EXR_PIXEL_FLOAT},
                     .parts = 1};
}

/* The value at window coordinates: a small integer, so that every pixel type holds it. */
static uint32_t foreign_value(int channel, int x, int y)
{
    return (uint32_t)(channel * 300 + (x + 1000) % 17 + 17 * ((y + 1000) % 13));
}

static void encode_chunk(exr_context_t file, int part, const foreign *f,
                         const exr_chunk_info_t *chunk, int x0, int y0)
{
    static uint8_t pixels[3][64 * 64 * 4];
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(file, part, chunk, &encode), EXR_ERR_SUCCESS);
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < chunk->height; y++) {
            for (int x = 0; x < chunk->width; x++) {
                const uint32_t integer = foreign_value(c, x0 + x, y0 + y) + (uint32_t)(100 * part);
                const float number = (float)integer;
                memcpy(pixels[c] + 4 * (y * chunk->width + x),
                       f->types[c] == EXR_PIXEL_UINT ? (const void *)&integer
                                                     : (const void *)&number,
                       4);
            }
        }
        exr_coding_channel_info_t *const channel = &encode.channels[c];
        channel->user_data_type = f->types[c] == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = 4;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = 4 * chunk->width;
        channel->encode_from_ptr = pixels[c];
    }
    assert_int_equal(exr_encoding_choose_default_routines(file, part, &encode), EXR_ERR_SUCCESS);
    assert_int_equal(exr_encoding_run(file, part, &encode), EXR_ERR_SUCCESS);
    assert_int_equal(exr_encoding_destroy(file, &encode), EXR_ERR_SUCCESS);
}

static void declare_part(exr_context_t file, int part, const foreign *f)
{
    static const char *const names[3] = {"B", "G", "R"};
    const exr_attr_v2f_t centre = {{{0.0f, 0.0f}}};
    int index = -1;
    assert_int_equal(exr_add_part(file, part == 0 ? "first" : "second", f->storage, &index),
                     EXR_ERR_SUCCESS);
    assert_int_equal(exr_initialize_required_attr(file, part, &f->display, &f->data, 1.0f, &centre,
                                                  1.0f, EXR_LINEORDER_INCREASING_Y, f->compression),
                     EXR_ERR_SUCCESS);
    if (f->storage == EXR_STORAGE_TILED) {
        assert_int_equal(
            exr_set_tile_descriptor(file, part, 16, 16, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN),
            EXR_ERR_SUCCESS);
    }
    for (int c = 0; c < 3; c++) {
        assert_int_equal(
            exr_add_channel(file, part, names[c], f->types[c], EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
            EXR_ERR_SUCCESS);
    }
}

static void write_part(exr_context_t file, int part, const foreign *f)
{
    exr_chunk_info_t chunk;
    if (f->storage == EXR_STORAGE_TILED) {
        for (int y = f->data.min.y, j = 0; y <= f->data.max.y; y += 16, j++) {
            for (int x = f->data.min.x, i = 0; x <= f->data.max.x; x += 16, i++) {
                assert_int_equal(exr_write_tile_chunk_info(file, part, i, j, 0, 0, &chunk),
                                 EXR_ERR_SUCCESS);
                encode_chunk(file, part, f, &chunk, x, y);
            }
        }
        return;
    }
    int32_t lines = 0;
    assert_int_equal(exr_get_scanlines_per_chunk(file, part, &lines), EXR_ERR_SUCCESS);
    for (int y = f->data.min.y; y <= f->data.max.y; y += lines) {
        assert_int_equal(exr_write_scanline_chunk_info(file, part, y, &chunk), EXR_ERR_SUCCESS);
        encode_chunk(file, part, f, &chunk, f->data.min.x, y);
    }
}

static void write_foreign(image_fixture *self, const foreign *f)
{
    exr_context_t file = NULL;
    assert_int_equal(
        exr_start_write(&file, image_fixture_path(self, "b.exr"), EXR_WRITE_FILE_DIRECTLY, NULL),
        EXR_ERR_SUCCESS);
    for (int part = 0; part < f->parts; part++) {
        declare_part(file, part, f);
    }
    assert_int_equal(exr_write_header(file), EXR_ERR_SUCCESS);
    for (int part = 0; part < f->parts; part++) {
        write_part(file, part, f);
    }
    assert_int_equal(exr_finish(&file), EXR_ERR_SUCCESS);
}

/* Writes the file, loads it, and compares every pixel of the display window. */
static void check_foreign(image_fixture *self, const foreign *f)
{
    static const char *const names[3] = {"B", "G", "R"};
    write_foreign(self, f);
    air_image *image = NULL;
    assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
    const int width = f->display.max.x - f->display.min.x + 1;
    const int height = f->display.max.y - f->display.min.y + 1;
    assert_int_equal(air_image_width(image), width);
    assert_int_equal(air_image_height(image), height);
    assert_int_equal(air_image_channel_count(image), 3);
    for (int c = 0; c < 3; c++) {
        const ptrdiff_t k = air_image_find_channel(image, names[c]);
        for (int y = f->display.min.y; y <= f->display.max.y; y++) {
            for (int x = f->display.min.x; x <= f->display.max.x; x++) {
                const bool inside = x >= f->data.min.x && x <= f->data.max.x &&
                                    y >= f->data.min.y && y <= f->data.max.y;
                const float expected = inside ? (float)foreign_value(c, x, y) : 0.0f;
                const size_t i = (size_t)((y - f->display.min.y) * width + (x - f->display.min.x));
                assert_true(air_image_plane(image, (size_t)k)[i] == expected);
            }
        }
    }
    air_image_destroy(image);
}

static void every_lossless_compression_is_read(void **state)
{
    const exr_compression_t kinds[5] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                        EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                        EXR_COMPRESSION_PIZ};
    for (size_t i = 0; i < 5; i++) {
        foreign f = foreign_default();
        f.compression = kinds[i];
        check_foreign(*state, &f);
    }
}

static void half_float_and_integer_channels_are_read_side_by_side(void **state)
{
    foreign f = foreign_default();
    f.types[0] = EXR_PIXEL_UINT;
    f.types[1] = EXR_PIXEL_HALF; /* integers below 2048 are exact */
    check_foreign(*state, &f);
}

static void tiles_are_read(void **state)
{
    foreign f = foreign_default();
    f.storage = EXR_STORAGE_TILED;
    check_foreign(*state, &f);
    f.data = (exr_attr_box2i_t){{{{-5, 7}}}, {{{50, 33}}}};
    check_foreign(*state, &f);
}

static void data_windows_smaller_larger_and_shifted_land_in_the_display_window(void **state)
{
    const exr_attr_box2i_t windows[5] = {{{{{10, 5}}}, {{{20, 25}}}},
                                         {{{{-7, -9}}}, {{{45, 35}}}},
                                         {{{{-7, 4}}}, {{{3, 50}}}},
                                         {{{{39, 29}}}, {{{39, 29}}}},
                                         {{{{-12, -3}}}, {{{0, 0}}}}};
    for (size_t i = 0; i < 5; i++) {
        foreign f = foreign_default();
        f.data = windows[i];
        check_foreign(*state, &f);
        f.display = (exr_attr_box2i_t){{{{-3, -2}}}, {{{39, 29}}}};
        check_foreign(*state, &f);
    }
}

static void the_first_part_of_several_is_read(void **state)
{
    foreign f = foreign_default();
    f.parts = 2;
    check_foreign(*state, &f);
}

static void windows_without_overlap_are_refused(void **state)
{
    foreign f = foreign_default();
    f.data = (exr_attr_box2i_t){{{{100, 0}}}, {{{110, 10}}}};
    write_foreign(*state, &f);
    image_check_refused(*state, ((image_fixture *)*state)->path, AIR_ERROR_FORMAT,
                        "display window");
}

/* The first place of the pattern in the file at hand, which must hold it. */
static size_t find_bytes(const uint8_t *data, size_t size, const void *pattern, size_t length)
{
    size_t at = 0;
    while (at + length < size && memcmp(data + at, pattern, length) != 0) {
        at++;
    }
    assert_true(at + length < size);
    return at;
}

static void subsampled_channels_are_refused_by_name(void **state)
{
    static uint8_t data[1 << 16];
    image_fixture *self = *state;
    foreign f = foreign_default();
    write_foreign(self, &f);
    const size_t size = image_read_file(self->path, data, sizeof(data));
    /* In the channel list: the name, type, linear flag, three reserved bytes, x and y sampling. */
    const size_t at = find_bytes(data, size, "G\0\2\0\0\0\0\0\0\0\1\0\0\0\1", 15);
    data[at + 10] = data[at + 14] = 2;
    image_write_file(self, "b.exr", data, size);
    image_check_refused(self, self->path, AIR_ERROR_UNSUPPORTED, "channel G");
}

/* ---- damage ---- */

static void truncated_files_are_refused_at_every_length(void **state)
{
    static uint8_t data[1 << 16];
    image_fixture *self = *state;
    foreign f = foreign_default();
    write_foreign(self, &f);
    const size_t size = image_read_file(self->path, data, sizeof(data));
    image_check_truncations(self, "b.exr", data, size, 1);
}

static void damaged_bytes_never_crash(void **state)
{
    static uint8_t data[1 << 16];
    image_fixture *self = *state;
    foreign f = foreign_default();
    write_foreign(self, &f);
    const size_t size = image_read_file(self->path, data, sizeof(data));
    size_t refused = 0;
    for (size_t i = 0; i < size; i++) {
        const uint8_t kept = data[i];
        data[i] = (uint8_t)(kept ^ (1u << (i % 8)));
        image_write_file(self, "b.exr", data, size);
        air_image *image = NULL;
        refused += air_image_load(self->context, self->path, &image) != AIR_OK;
        air_image_destroy(image);
        data[i] = kept;
    }
    assert_true(refused > size / 2); /* most bytes are compressed pixels with a checksum */
}

static void garbage_is_refused(void **state)
{
    uint8_t noise[512];
    for (size_t i = 0; i < sizeof(noise); i++) {
        noise[i] = (uint8_t)(256.0 * image_fixture_random(*state));
    }
    image_write_file(*state, "a.exr", noise, sizeof(noise));
    image_check_refused(*state, ((image_fixture *)*state)->path, AIR_ERROR_FORMAT, "OpenEXR");
}

static void absurd_sizes_are_refused_with_the_size(void **state)
{
    static uint8_t data[1 << 16];
    static const char marker[] = "dataWindow\0box2i";
    image_fixture *self = *state;
    foreign f = foreign_default();
    write_foreign(self, &f);
    const size_t size = image_read_file(self->path, data, sizeof(data));
    const size_t at = find_bytes(data, size, marker, sizeof(marker));
    uint8_t *const max = data + at + sizeof(marker) + 4 + 8;
    const uint8_t wide[8] = {0xFE, 0xFF, 0, 0, 29, 0, 0, 0};
    memcpy(max, wide, sizeof(wide));
    image_write_file(self, "b.exr", data, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT,
                        ""); /* as wide as may be, but no data */
    const uint8_t large[8] = {0xFE, 0xFF, 0, 0, 0xFE, 0xFF, 0, 0};
    memcpy(max, large, sizeof(large));
    image_write_file(self, "b.exr", data, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "65535 x 65535");
    const uint8_t wider[8] = {0xFF, 0xFF, 0, 0, 29, 0, 0, 0};
    memcpy(max, wider, sizeof(wider));
    image_write_file(self, "b.exr", data, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "65536");
}

/* ---- allocation ---- */

static void allocation_failures_are_reported_and_leak_nothing(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 20, 40);
    const char *const path = image_fixture_path(self, "a.exr");
    assert_int_equal(air_image_save(self->context, image, path, NULL), AIR_OK);
    bool succeeded = false;
    for (long allowed = 0; !succeeded; allowed++) {
        assert_true(allowed < 200);
        failing_allocator allocator;
        air_context_params params = failing_params(&allocator, 1000);
        params.thread_count = 1;
        air_context *context = NULL;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        atomic_store(&allocator.remaining, allowed);
        air_image *loaded = NULL;
        const air_status load_status = air_image_load(context, path, &loaded);
        air_image_destroy(loaded);
        atomic_store(&allocator.remaining, allowed);
        const air_status save_status = air_image_save(context, image, path, NULL);
        assert_true(load_status == AIR_OK || load_status == AIR_ERROR_MEMORY);
        assert_true(save_status == AIR_OK || save_status == AIR_ERROR_MEMORY);
        succeeded = load_status == AIR_OK && save_status == AIR_OK;
        atomic_store(&allocator.remaining, 1000);
        air_context_destroy(context);
        assert_int_equal(atomic_load(&allocator.live), 0);
    }
    air_image_destroy(image);
}

#define WITH_FIXTURE(test)                                                                         \
    cmocka_unit_test_setup_teardown(test, image_fixture_start, image_fixture_finish)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FIXTURE(float_round_trip_keeps_every_bit),
        WITH_FIXTURE(blocks_that_do_not_compress_keep_every_bit),
        WITH_FIXTURE(channels_come_back_in_alphabetical_order),
        WITH_FIXTURE(string_attributes_survive),
        WITH_FIXTURE(attributes_that_clash_with_the_format_are_refused),
        WITH_FIXTURE(half_rounds_to_eleven_bits),
        WITH_FIXTURE(half_clamps_what_it_cannot_hold_and_says_so),
        WITH_FIXTURE(the_number_of_threads_leaves_no_trace),
        WITH_FIXTURE(every_lossless_compression_is_read),
        WITH_FIXTURE(half_float_and_integer_channels_are_read_side_by_side),
        WITH_FIXTURE(tiles_are_read),
        WITH_FIXTURE(data_windows_smaller_larger_and_shifted_land_in_the_display_window),
        WITH_FIXTURE(the_first_part_of_several_is_read),
        WITH_FIXTURE(windows_without_overlap_are_refused),
        WITH_FIXTURE(subsampled_channels_are_refused_by_name),
        WITH_FIXTURE(truncated_files_are_refused_at_every_length),
        WITH_FIXTURE(damaged_bytes_never_crash),
        WITH_FIXTURE(garbage_is_refused),
        WITH_FIXTURE(absurd_sizes_are_refused_with_the_size),
        WITH_FIXTURE(allocation_failures_are_reported_and_leak_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Radiance HDR, PNG, JPEG and PFM in, PNG and PFM out, and files of unknown kind. */
#include <zlib.h>

#include "image/decode.h"
#include "image/srgb.h"
#include "image_fixture.h"

/* ---- Radiance HDR ---- */

static const char hdr_header[] = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n";

/* An HDR file of `size` text and then the bytes of `pixels`. */
static size_t make_hdr(uint8_t *out, const char *size, const uint8_t *pixels, size_t count)
{
    const size_t header = sizeof(hdr_header) - 1;
    memcpy(out, hdr_header, header);
    memcpy(out + header, size, strlen(size));
    memcpy(out + header + strlen(size), pixels, count);
    return header + strlen(size) + count;
}

/* Two rows of 8 pixels. First: mantissas R a run of 128, G eight literals 0, 16, .., B a run of 3
 * of 255 and a run of 5 of 1, exponents a run of 129, that is times 2^(129-136) = 1/128. Second:
 * all runs, exponent 0, which means black. */
static const uint8_t rle_rows[] = {2,   2,   0,   8, /* new style scanline of 8 */
                                   136, 128,         /* R: run of 8 */
                                   8,   0,   16,  32, 48,  64,  80,  96,  112, /* G: 8 literals */
                                   131, 255, 133, 1, /* B: runs of 3 and 5 */
                                   136, 129,         /* E */
                                   2,   2,   0,   8,  136, 200, 136, 200, 136, 200, 136, 0};

static void hdr_runs_and_literals_decode_to_the_numbers_they_mean(void **state)
{
    uint8_t file[256];
    const size_t size = make_hdr(file, "-Y 2 +X 8\n", rle_rows, sizeof(rle_rows));
    image_fixture *self = *state;
    image_write_file(self, "a.hdr", file, size);
    air_image *image = NULL;
    assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
    assert_int_equal(air_image_width(image), 8);
    assert_int_equal(air_image_height(image), 2);
    assert_int_equal(air_image_channel_count(image), 3);
    for (size_t x = 0; x < 8; x++) {
        assert_true(air_image_plane(image, 0)[x] == 1.0f);
        assert_true(air_image_plane(image, 1)[x] == (float)(16 * x) / 128.0f);
        assert_true(air_image_plane(image, 2)[x] == (x < 3 ? 255.0f : 1.0f) / 128.0f);
        for (size_t c = 0; c < 3; c++) {
            assert_true(air_image_plane(image, c)[8 + x] == 0.0f);
        }
    }
    air_image_destroy(image);
}

static void hdr_without_runs_is_read(void **state)
{
    const uint8_t pixels[8] = {128, 64, 32, 130, 255, 0, 1, 128};
    uint8_t file[256];
    image_fixture *self = *state;
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y 1 +X 2\n", pixels, 8));
    air_image *image = NULL;
    assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
    const float expected[3][2] = {{2.0f, 255.0f / 256.0f}, {1.0f, 0.0f}, {0.5f, 1.0f / 256.0f}};
    for (size_t c = 0; c < 3; c++) {
        assert_memory_equal(air_image_plane(image, c), expected[c], sizeof(expected[c]));
    }
    air_image_destroy(image);
}

static void truncated_hdr_is_refused_at_every_length(void **state)
{
    uint8_t file[256];
    const size_t size = make_hdr(file, "-Y 2 +X 8\n", rle_rows, sizeof(rle_rows));
    image_check_truncations(*state, "a.hdr", file, size, 1);
    const uint8_t flat[8] = {128, 64, 32, 130, 255, 0, 1, 128};
    image_check_truncations(*state, "a.hdr", file, make_hdr(file, "-Y 1 +X 2\n", flat, 8), 1);
}

static void damaged_hdr_is_refused(void **state)
{
    uint8_t file[256];
    uint8_t pixels[sizeof(rle_rows)];
    image_fixture *self = *state;
    memcpy(pixels, rle_rows, sizeof(rle_rows));
    pixels[4] = 140; /* a run of 12 in a row of 8 */
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y 2 +X 8\n", pixels, sizeof(pixels)));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "damaged");
    pixels[4] = 0; /* no literals, then shifted nonsense */
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y 2 +X 8\n", pixels, sizeof(pixels)));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "");
    image_write_file(self, "a.hdr", file, make_hdr(file, "+X 8 -Y 2\n", pixels, sizeof(pixels)));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "-Y N +X M");
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y 70000 +X 8\n", pixels, 8));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "8 x 70000");
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y 65535 +X 65535\n", pixels, 8));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "65535 x 65535");
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y 4096 +X 8192\n", pixels, 8));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "truncated");
    image_write_file(self, "a.hdr", file, make_hdr(file, "-Y -4 +X 8\n", pixels, 8));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "8 x 0");
    image_write_file(self, "a.hdr", "plain text", 10);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "Radiance");
}

static void the_shared_environments_have_the_maxima_they_are_known_for(void **state)
{
    image_fixture *self = *state;
    const struct {
        const char *path;
        float low, high;
    } cases[2] = {{AIR_SHARED_DIR "/scenes/hdr/vestibule_1k.hdr", 223.0f, 225.0f},
                  {AIR_SHARED_DIR "/scenes/hdr/noon_grass_1k.hdr", 64255.0f, 64257.0f}};
    for (size_t i = 0; i < 2; i++) {
        if (access(cases[i].path, R_OK) != 0) {
            print_message("skipped: %s is not there\n", cases[i].path);
            skip();
        }
        air_image *image = NULL;
        assert_int_equal(air_image_load(self->context, cases[i].path, &image), AIR_OK);
        assert_int_equal(air_image_width(image), 1024);
        assert_int_equal(air_image_height(image), 512);
        float largest = 0.0f;
        for (size_t c = 0; c < 3; c++) {
            for (size_t k = 0; k < 1024 * 512; k++) {
                largest = fmaxf(largest, air_image_plane(image, c)[k]);
            }
        }
        assert_true(largest >= cases[i].low && largest <= cases[i].high);
        air_image_destroy(image);
    }
}

/* ---- PNG and JPEG ---- */

static air_image_save_params plain_png(void)
{
    air_image_save_params params;
    air_image_save_params_default(&params);
    params.auto_exposure = false;
    params.view = AIR_VIEW_STANDARD;
    return params;
}

static void png_keeps_all_256_values(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 16, 16);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < 256; i++) {
            air_image_plane(image, c)[i] = srgb_decode((float)((i * (c + 1) + c) % 256) / 255.0f);
        }
    }
    const air_image_save_params params = plain_png();
    const char *const path = image_fixture_path(self, "a.png");
    assert_int_equal(air_image_save(self->context, image, path, &params), AIR_OK);
    air_image *back = NULL;
    assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
    assert_int_equal(air_image_channel_count(back), 3);
    for (size_t c = 0; c < 3; c++) {
        assert_memory_equal(air_image_plane(image, c), air_image_plane(back, c), 256 * 4);
    }
    air_image_destroy(back);
    air_image_destroy(image);
}

static void png_alpha_is_written_on_request_and_multiplied_back(void **state)
{
    static const char *const names[4] = {"R", "G", "B", "A"};
    image_fixture *self = *state;
    air_image *image = image_make(self, 2, 1, 4, names);
    for (size_t c = 0; c < 3; c++) {
        air_image_plane(image, c)[0] = 0.6f * 0.25f * (float)(c + 1); /* premultiplied */
    }
    air_image_plane(image, 3)[0] = 0.6f; /* 153/255 */
    air_image_save_params params = plain_png();
    const char *const path = image_fixture_path(self, "a.png");
    for (size_t i = 0; i < 2; i++) {
        params.alpha = i == 1;
        assert_int_equal(air_image_save(self->context, image, path, &params), AIR_OK);
        air_image *back = NULL;
        assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
        assert_int_equal(air_image_channel_count(back), i == 1 ? 4 : 3);
        for (size_t c = 0; c < air_image_channel_count(back); c++) {
            /* Half a step of 1/255, times the largest slope of the sRGB decoding, 2.4/1.055. */
            assert_true(fabsf(air_image_plane(back, c)[0] - air_image_plane(image, c)[0]) <
                        0.5f / 255.0f * 2.28f);
            assert_true(air_image_plane(back, c)[1] == 0.0f);
        }
        air_image_destroy(back);
    }
    air_image_destroy(image);
}

static void png_shows_what_is_not_finite_as_black_and_clips(void **state)
{
    image_fixture *self = *state;
    const float values[5] = {NAN, INFINITY, -INFINITY, -3.0f, 1e30f};
    air_image *image = image_make_rgb(self, 5, 1);
    for (size_t c = 0; c < 3; c++) {
        memcpy(air_image_plane(image, c), values, sizeof(values));
    }
    const air_view views[3] = {AIR_VIEW_NEUTRAL, AIR_VIEW_STANDARD, AIR_VIEW_RAW};
    const char *const path = image_fixture_path(self, "a.png");
    for (size_t v = 0; v < 3; v++) {
        air_image_save_params params = plain_png();
        params.view = views[v];
        assert_int_equal(air_image_save(self->context, image, path, &params), AIR_OK);
        air_image *back = NULL;
        assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
        for (size_t i = 0; i < 5; i++) {
            assert_true(air_image_plane(back, 1)[i] == (i < 4 ? 0.0f : 1.0f));
        }
        air_image_destroy(back);
    }
    air_image_destroy(image);
}

static void raw_view_writes_the_numbers_without_transfer_and_exposure(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 1, 1);
    image_fill(image, 51.0f / 255.0f, 0.0f, 1.0f);
    air_image_save_params params = plain_png();
    params.view = AIR_VIEW_RAW;
    params.exposure_ev = 3.0f;
    const char *const path = image_fixture_path(self, "a.png");
    assert_int_equal(air_image_save(self->context, image, path, &params), AIR_OK);
    uint8_t data[512];
    const size_t size = image_read_file(path, data, sizeof(data));
    size_t width = 0;
    size_t height = 0;
    size_t channels = 0;
    uint8_t *bytes = NULL;
    assert_int_equal(
        air_decode_bytes(self->context, data, size, "a.png", &width, &height, &channels, &bytes),
        AIR_OK);
    assert_true(width == 1 && height == 1 && channels == 3);
    assert_true(bytes[0] == 51 && bytes[1] == 0 && bytes[2] == 255);
    air_free(self->context, bytes);
    air_image_destroy(image);
}

static void put_be32(uint8_t *out, uint32_t value)
{
    for (size_t i = 0; i < 4; i++) {
        out[i] = (uint8_t)(value >> (24 - 8 * i));
    }
}

static size_t put_chunk(uint8_t *out, const char *type, const uint8_t *data, size_t size)
{
    put_be32(out, (uint32_t)size);
    memcpy(out + 4, type, 4);
    memcpy(out + 8, data, size);
    put_be32(out + 8 + size, (uint32_t)crc32(0, out + 4, (uInt)(size + 4)));
    return size + 12;
}

/* A PNG of one row from its raw samples. colour: 0 grey, 2 RGB, 4 grey and alpha. */
static size_t make_png(uint8_t *out, uint32_t width, uint8_t depth, uint8_t colour,
                       const uint8_t *samples, size_t size)
{
    static const uint8_t signature[8] = {137, 'P', 'N', 'G', 13, 10, 26, 10};
    uint8_t header[13] = {0, 0, 0, 0, 0, 0, 0, 1, depth, colour, 0, 0, 0};
    uint8_t raw[64] = {0};
    uint8_t packed[256];
    uLongf packed_size = sizeof(packed);
    put_be32(header, width);
    memcpy(raw + 1, samples, size);
    assert_int_equal(compress(packed, &packed_size, raw, (uLong)(size + 1)), Z_OK);
    memcpy(out, signature, 8);
    size_t at = 8;
    at += put_chunk(out + at, "IHDR", header, 13);
    at += put_chunk(out + at, "IDAT", packed, packed_size);
    at += put_chunk(out + at, "IEND", header, 0);
    return at;
}

static void png_of_16_bits_keeps_them(void **state)
{
    image_fixture *self = *state;
    const uint16_t values[2][3] = {{0x1234, 0x8001, 0xFFFF}, {0x0001, 0x00FF, 0x0100}};
    uint8_t samples[12];
    uint8_t file[512];
    for (size_t i = 0; i < 6; i++) {
        samples[2 * i] = (uint8_t)(values[i / 3][i % 3] >> 8);
        samples[2 * i + 1] = (uint8_t)values[i / 3][i % 3];
    }
    image_write_file(self, "a.png", file, make_png(file, 2, 16, 2, samples, 12));
    air_image *image = NULL;
    assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
    for (size_t i = 0; i < 6; i++) {
        assert_true(air_image_plane(image, i % 3)[i / 3] ==
                    srgb_decode((float)values[i / 3][i % 3] / 65535.0f));
    }
    air_image_destroy(image);
}

static void grey_png_becomes_colour_and_alpha_multiplies_it(void **state)
{
    image_fixture *self = *state;
    const uint8_t samples[4] = {188, 255, 188, 51};
    uint8_t file[512];
    image_write_file(self, "a.png", file, make_png(file, 2, 8, 4, samples, 4));
    air_image *image = NULL;
    assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
    assert_int_equal(air_image_channel_count(image), 4);
    const float grey = srgb_decode(188.0f / 255.0f);
    for (size_t c = 0; c < 3; c++) {
        assert_true(air_image_plane(image, c)[0] == grey);
        assert_true(air_image_plane(image, c)[1] == grey * (51.0f / 255.0f));
    }
    assert_true(air_image_plane(image, 3)[0] == 1.0f);
    assert_true(air_image_plane(image, 3)[1] == 51.0f / 255.0f);
    air_image_destroy(image);
}

static void truncated_and_damaged_png_is_refused(void **state)
{
    image_fixture *self = *state;
    const uint8_t samples[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    uint8_t file[512];
    const size_t size = make_png(file, 4, 8, 2, samples, 12);
    image_check_truncations(self, "a.png", file, size, 1);
    put_be32(file + 16, 70000);
    image_write_file(self, "a.png", file, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "70000 x 1");
    put_be32(file + 16, 65535);
    put_be32(file + 20, 65535);
    image_write_file(self, "a.png", file, size);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "65535 x 65535");
    uint8_t hdr[256];
    image_write_file(self, "a.png", hdr, make_hdr(hdr, "-Y 2 +X 8\n", rle_rows, sizeof(rle_rows)));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "PNG or JPEG");
}

/* 8 x 8 pixels of grey 186, written by libjpeg at quality 95. */
static const uint8_t grey_jpeg[160] = {
    0xFF, 0xD8, 0xFF, 0xE0, 0x00, 0x10, 0x4A, 0x46, 0x49, 0x46, 0x00, 0x01, 0x01, 0x00, 0x00, 0x01,
    0x00, 0x01, 0x00, 0x00, 0xFF, 0xDB, 0x00, 0x43, 0x00, 0x02, 0x01, 0x01, 0x01, 0x01, 0x01, 0x02,
    0x01, 0x01, 0x01, 0x02, 0x02, 0x02, 0x02, 0x02, 0x04, 0x03, 0x02, 0x02, 0x02, 0x02, 0x05, 0x04,
    0x04, 0x03, 0x04, 0x06, 0x05, 0x06, 0x06, 0x06, 0x05, 0x06, 0x06, 0x06, 0x07, 0x09, 0x08, 0x06,
    0x07, 0x09, 0x07, 0x06, 0x06, 0x08, 0x0B, 0x08, 0x09, 0x0A, 0x0A, 0x0A, 0x0A, 0x0A, 0x06, 0x08,
    0x0B, 0x0C, 0x0B, 0x0A, 0x0C, 0x09, 0x0A, 0x0A, 0x0A, 0xFF, 0xC0, 0x00, 0x0B, 0x08, 0x00, 0x08,
    0x00, 0x08, 0x01, 0x01, 0x11, 0x00, 0xFF, 0xC4, 0x00, 0x14, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0xFF, 0xC4, 0x00, 0x14,
    0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0xFF, 0xDA, 0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x3F, 0x00, 0x74, 0x3F, 0xFF, 0xD9};

static void jpeg_is_read_and_its_truncations_refused(void **state)
{
    image_fixture *self = *state;
    image_write_file(self, "a.jpg", grey_jpeg, sizeof(grey_jpeg));
    air_image *image = NULL;
    assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
    assert_int_equal(air_image_channel_count(image), 3);
    for (size_t i = 0; i < 64; i++) {
        assert_true(air_image_plane(image, 2)[i] == srgb_decode(186.0f / 255.0f));
    }
    air_image_destroy(image);
    image_check_truncations(self, "a.jpg", grey_jpeg, sizeof(grey_jpeg), 1);
}

static void jpeg_with_oversized_huffman_tables_is_refused(void **state)
{
    image_fixture *self = *state;
    uint8_t file[sizeof(grey_jpeg)];
    memcpy(file, grey_jpeg, sizeof(file));
    size_t at = 2;
    while (file[at] != 0xFF || file[at + 1] != 0xC4) {
        at += 2 + (size_t)(file[at + 2] << 8 | file[at + 3]); /* the next segment */
        assert_true(at + 21 < sizeof(file));
    }
    memset(file + at + 5, 255, 16); /* the counts of the first table */
    image_write_file(self, "a.jpg", file, sizeof(file));
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "Huffman");
}

static void bytes_are_decoded_from_memory(void **state)
{
    image_fixture *self = *state;
    const uint8_t samples[6] = {1, 2, 3, 250, 251, 252};
    uint8_t file[512];
    const size_t size = make_png(file, 2, 8, 2, samples, 6);
    size_t width = 7;
    size_t height = 7;
    size_t channels = 7;
    uint8_t *bytes = NULL;
    assert_int_equal(air_decode_bytes(self->context, file, size - 1, "scene.glb: image 3", &width,
                                      &height, &channels, &bytes),
                     AIR_ERROR_FORMAT);
    assert_non_null(strstr(air_context_last_error(self->context), "scene.glb: image 3"));
    assert_true(width == 7 && height == 7 && channels == 7 && bytes == NULL);
    assert_int_equal(air_decode_bytes(self->context, file, size, "scene.glb: image 3", &width,
                                      &height, &channels, &bytes),
                     AIR_OK);
    assert_true(width == 2 && height == 1 && channels == 3);
    assert_memory_equal(bytes, samples, 6);
    air_free(self->context, bytes);
}

/* ---- PFM ---- */

static void pfm_round_trip_keeps_every_bit(void **state)
{
    static const char *const grey[1] = {"variance"};
    image_fixture *self = *state;
    for (size_t channels = 1; channels <= 3; channels += 2) {
        air_image *image =
            channels == 1 ? image_make(self, 5, 3, 1, grey) : image_make_rgb(self, 5, 3);
        for (size_t i = 0; i < 15 * channels; i++) {
            air_image_plane(image, i / 15)[i % 15] = (float)sin((double)i) * 1e10f;
        }
        air_image_plane(image, 0)[3] = -INFINITY;
        const char *const path = image_fixture_path(self, "a.pfm");
        assert_int_equal(air_image_save(self->context, image, path, NULL), AIR_OK);
        air_image *back = NULL;
        assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
        assert_int_equal(air_image_channel_count(back), channels);
        assert_string_equal(air_image_channel_name(back, 0), channels == 1 ? "Y" : "R");
        for (size_t c = 0; c < channels; c++) {
            assert_memory_equal(air_image_plane(image, c), air_image_plane(back, c), 15 * 4);
        }
        air_image_destroy(back);
        air_image_destroy(image);
    }
}

static void pfm_of_either_byte_order_starts_with_the_lowest_row(void **state)
{
    image_fixture *self = *state;
    /* 1 x 2, 1.0 in the lower row, -2.5 in the upper: big-endian, then little-endian. */
    const char *const files[2] = {"Pf\n1 2\n1.0\n\x3F\x80\0\0\xC0\x20\0\0",
                                  "Pf 1 2 -1e0\n\0\0\x80\x3F\0\0\x20\xC0"};
    const size_t headers[2] = {11, 12};
    for (size_t i = 0; i < 2; i++) {
        image_write_file(self, "a.pfm", files[i], headers[i] + 8);
        air_image *image = NULL;
        assert_int_equal(air_image_load(self->context, self->path, &image), AIR_OK);
        assert_true(air_image_width(image) == 1 && air_image_height(image) == 2);
        assert_true(air_image_plane(image, 0)[0] == -2.5f);
        assert_true(air_image_plane(image, 0)[1] == 1.0f);
        air_image_destroy(image);
        image_check_truncations(self, "a.pfm", (const uint8_t *)files[i], headers[i] + 8, 1);
    }
}

static void damaged_pfm_is_refused(void **state)
{
    const char *const files[] = {"PX\n1 1\n-1\nabcd",
                                 "PF\n-1 1\n-1\nabcd",
                                 "PF\n1 x\n-1\nabcd",
                                 "PF\n1 1\n0.0\nabcdabcdabcd",
                                 "PF\n1 1\nnan\nabcdabcdabcd",
                                 "PF\n70000 1\n-1\n",
                                 "PF\n99999999999999999999999999 1\n-1\n",
                                 "PF\n65535 65535\n-1\nabcd"};
    image_fixture *self = *state;
    for (size_t i = 0; i < sizeof(files) / sizeof(files[0]); i++) {
        image_write_file(self, "a.pfm", files[i], strlen(files[i]));
        image_check_refused(self, self->path, AIR_ERROR_FORMAT, "");
    }
    image_write_file(self, "a.pfm", "PF\n65535 65535\n-1\n", 18);
    image_check_refused(self, self->path, AIR_ERROR_FORMAT, "65535 x 65535");
}

/* ---- all of them ---- */

static void unknown_extensions_are_answered_with_the_known_ones(void **state)
{
    image_fixture *self = *state;
    image_check_refused(self, "picture.tiff", AIR_ERROR_UNSUPPORTED,
                        ".exr .hdr .png .jpg .jpeg .pfm");
    image_check_refused(self, ".png", AIR_ERROR_UNSUPPORTED, ".exr");
    air_image *image = image_make_rgb(self, 1, 1);
    assert_int_equal(air_image_save(self->context, image, "picture.hdr", NULL),
                     AIR_ERROR_UNSUPPORTED);
    assert_non_null(strstr(air_context_last_error(self->context), ".exr .png .pfm"));
    air_image_destroy(image);
}

static void extensions_may_be_upper_case(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 1, 1);
    const char *const path = image_fixture_path(self, "A.PFM");
    assert_int_equal(air_image_save(self->context, image, path, NULL), AIR_OK);
    air_image *back = NULL;
    assert_int_equal(air_image_load(self->context, path, &back), AIR_OK);
    air_image_destroy(back);
    air_image_destroy(image);
}

static void missing_files_and_folders_are_errors_of_input_and_output(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 1, 1);
    const char *const extensions[3] = {"exr", "png", "pfm"};
    for (size_t i = 0; i < 3; i++) {
        char path[160];
        (void)snprintf(path, sizeof(path), "%s/no/such.%s", self->folder, extensions[i]);
        image_check_refused(self, path, AIR_ERROR_IO, "");
        assert_int_equal(air_image_save(self->context, image, path, NULL), AIR_ERROR_IO);
    }
    air_image_destroy(image);
}

static void empty_files_are_refused(void **state)
{
    image_fixture *self = *state;
    const char *const names[5] = {"a.exr", "a.hdr", "a.png", "a.jpg", "a.pfm"};
    for (size_t i = 0; i < 5; i++) {
        image_write_file(self, names[i], "", 0);
        image_check_refused(self, self->path, AIR_ERROR_FORMAT, "");
        (void)unlink(self->path);
    }
}

static void pictures_need_colour(void **state)
{
    static const char *const names[2] = {"depth", "id"};
    image_fixture *self = *state;
    air_image *image = image_make(self, 2, 2, 2, names);
    const char *const files[2] = {"a.png", "a.pfm"};
    for (size_t i = 0; i < 2; i++) {
        const char *const path = image_fixture_path(self, files[i]);
        assert_int_equal(air_image_save(self->context, image, path, NULL), AIR_ERROR_ARGUMENT);
        assert_non_null(strstr(air_context_last_error(self->context), "R,G,B"));
        assert_int_not_equal(access(path, F_OK), 0);
    }
    air_image_destroy(image);
}

#define WITH_FIXTURE(test)                                                                         \
    cmocka_unit_test_setup_teardown(test, image_fixture_start, image_fixture_finish)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FIXTURE(hdr_runs_and_literals_decode_to_the_numbers_they_mean),
        WITH_FIXTURE(hdr_without_runs_is_read),
        WITH_FIXTURE(truncated_hdr_is_refused_at_every_length),
        WITH_FIXTURE(damaged_hdr_is_refused),
        WITH_FIXTURE(the_shared_environments_have_the_maxima_they_are_known_for),
        WITH_FIXTURE(png_keeps_all_256_values),
        WITH_FIXTURE(png_alpha_is_written_on_request_and_multiplied_back),
        WITH_FIXTURE(png_shows_what_is_not_finite_as_black_and_clips),
        WITH_FIXTURE(raw_view_writes_the_numbers_without_transfer_and_exposure),
        WITH_FIXTURE(png_of_16_bits_keeps_them),
        WITH_FIXTURE(grey_png_becomes_colour_and_alpha_multiplies_it),
        WITH_FIXTURE(truncated_and_damaged_png_is_refused),
        WITH_FIXTURE(jpeg_is_read_and_its_truncations_refused),
        WITH_FIXTURE(jpeg_with_oversized_huffman_tables_is_refused),
        WITH_FIXTURE(bytes_are_decoded_from_memory),
        WITH_FIXTURE(pfm_round_trip_keeps_every_bit),
        WITH_FIXTURE(pfm_of_either_byte_order_starts_with_the_lowest_row),
        WITH_FIXTURE(damaged_pfm_is_refused),
        WITH_FIXTURE(unknown_extensions_are_answered_with_the_known_ones),
        WITH_FIXTURE(extensions_may_be_upper_case),
        WITH_FIXTURE(missing_files_and_folders_are_errors_of_input_and_output),
        WITH_FIXTURE(empty_files_are_refused),
        WITH_FIXTURE(pictures_need_colour),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

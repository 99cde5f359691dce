/* Mitsuba grid volumes and raw grids: values and places come back, and damaged files are refused.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "core/random.h"
#include "memory_files.h"
#include "scene/media/grid.h"

enum { NX = 5, NY = 4, NZ = 3, HEADER_SIZE = 48 };

/* A .vol file in memory. */
typedef struct vol_file {
    uint8_t bytes[HEADER_SIZE + NX * NY * NZ * 3 * sizeof(float)];
    size_t size;
} vol_file;

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

/* Multiples of 1/255 and of 1/256 differ: value v is stored as v in uint8 and as v/256, exactly, in
 * half and float. */
static uint8_t voxel(size_t i, size_t j, size_t k, size_t c)
{
    return (uint8_t)(7 * i + 31 * j + 53 * k + 90 * c);
}

/* Half floats that are multiples of 2^-8 below 1, by their definition: sign, 5 bits of exponent, 10
 * of fraction. */
static uint16_t half_of(uint8_t v)
{
    int exponent = 15 + 7; /* of v * 2^-8 with v's leading bit at 2^-1 after the loop */
    uint32_t bits = v;
    if (v == 0) {
        return 0;
    }
    while ((bits & 0x80u) == 0) {
        bits <<= 1;
        exponent--;
    }
    return (uint16_t)((uint32_t)(exponent - 8) << 10 | (bits & 0x7fu) << 3);
}

static void put(vol_file *file, const void *data, size_t size)
{
    memcpy(file->bytes + file->size, data, size);
    file->size += size;
}

static vol_file make_vol(int32_t encoding, int32_t channels)
{
    static const float box[6] = {-1.0f, 0.0f, 2.0f, 4.0f, 2.0f, 3.5f};
    const int32_t header[5] = {encoding, NX, NY, NZ, channels};
    vol_file file = {.size = 0};
    put(&file, "VOL\3", 4);
    put(&file, header, sizeof header);
    put(&file, box, sizeof box);
    for (size_t n = 0; n < (size_t)(NX * NY * NZ * channels); n++) {
        const size_t c = n % (size_t)channels, at = n / (size_t)channels;
        const uint8_t v = voxel(at % NX, at / NX % NY, at / (NX * NY), c);
        const float f = (float)v / 256.0f;
        const uint16_t h = half_of(v);
        put(&file,
            encoding == 1   ? (const void *)&f
            : encoding == 2 ? (const void *)&h
                            : (const void *)&v,
            encoding == 1   ? 4
            : encoding == 2 ? 2
                            : 1);
    }
    return file;
}

static void test_every_encoding_gives_the_values_written(void **state)
{
    memory_file *files = *state;
    for (int32_t encoding = 1; encoding <= 3; encoding++) {
        for (int32_t channels = 1; channels <= 3; channels += 2) {
            const vol_file file = make_vol(encoding, channels);
            air_grid *grid = NULL;
            memory_file_serve(files, file.bytes, file.size);
            assert_int_equal(air_grid_load_vol(files->context, "x.vol", &grid), AIR_OK);
            assert_int_equal(air_grid_channels(grid), channels);
            const float unit = encoding == 3 ? 1.0f / 255.0f : 1.0f / 256.0f;
            for (size_t n = 0; n < NX * NY * NZ; n++) {
                const size_t i = n % NX, j = n / NX % NY, k = n / (NX * NY);
                const air_vec3 value = air_grid_lookup(grid, vec3((float)i, (float)j, (float)k));
                assert_float_equal(value.x, unit * (float)voxel(i, j, k, 0), 1e-7f);
                assert_float_equal(value.z, unit * (float)voxel(i, j, k, channels == 3 ? 2 : 0),
                                   1e-7f);
            }
            air_grid_destroy(grid);
        }
    }
}

static void test_voxels_fill_the_bounding_box(void **state)
{
    memory_file *files = *state;
    const vol_file file = make_vol(1, 1);
    air_grid *grid = NULL;
    memory_file_serve(files, file.bytes, file.size);
    assert_int_equal(air_grid_load_vol(files->context, "x.vol", &grid), AIR_OK);
    const float *map = air_grid_index_to_local(grid);
    const air_vec3 low = affine_point(map, vec3(-0.5f, -0.5f, -0.5f));
    const air_vec3 high = affine_point(map, vec3(NX - 0.5f, NY - 0.5f, NZ - 0.5f));
    assert_float_equal(low.x, -1.0f, 1e-6f);
    assert_float_equal(low.y, 0.0f, 1e-6f);
    assert_float_equal(low.z, 2.0f, 1e-6f);
    assert_float_equal(high.x, 4.0f, 1e-6f);
    assert_float_equal(high.y, 2.0f, 1e-6f);
    assert_float_equal(high.z, 3.5f, 1e-6f);
    air_grid_destroy(grid);
}

static void expect_refused(memory_file *files, const vol_file *file, const char *part)
{
    air_grid *grid = NULL;
    memory_file_serve(files, file->bytes, file->size);
    const air_status status = air_grid_load_vol(files->context, "x.vol", &grid);
    assert_true(status == AIR_ERROR_FORMAT || status == AIR_ERROR_UNSUPPORTED ||
                status == AIR_ERROR_ARGUMENT);
    assert_null(grid);
    memory_file_expect(files, "x.vol: ");
    memory_file_expect(files, part);
}

static void test_damaged_headers_are_refused_with_their_byte(void **state)
{
    static const struct {
        size_t at;
        uint32_t value;
        const char *part;
    } damages[] = {{0, 0x034c5056, "byte 0: expected"},
                   {0, 0x044c4f56, "byte 3: version 4, expected 3"},
                   {4, 0, "byte 4: encoding 0"},
                   {4, 4, "byte 4: encoding 4"},
                   {8, 0, "byte 8: size 0"},
                   {12, 0xffffffff, "byte 12: size -1"},
                   {16, 1 << 20, "bytes of values, the file ends after"},
                   {16, 0x7fffffff, "x 2147483647, each must be"},
                   {20, 2, "byte 20: 2 channels"},
                   {24, 0x7fc00000, "byte 24: the bounding box goes from nan"},
                   {36, 0xc0000000, "byte 24: the bounding box goes from -1 to -2"},
                   {48, 0x7f800000, "voxel (0, 0, 0) channel 0 is inf"}};
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++) {
        vol_file file = make_vol(1, 1);
        memcpy(file.bytes + damages[i].at, &damages[i].value, 4);
        expect_refused(*state, &file, damages[i].part);
    }
}

static void test_truncated_files_are_refused_at_every_length(void **state)
{
    memory_file *files = *state;
    for (int32_t encoding = 1; encoding <= 3; encoding++) {
        const vol_file file = make_vol(encoding, 3);
        for (size_t cut = 0; cut < file.size; cut++) {
            air_grid *grid = NULL;
            uint8_t *exact = malloc(cut + 1); /* so that a sanitizer sees reads beyond */
            memcpy(exact, file.bytes, cut);
            memory_file_serve(files, exact, cut);
            assert_int_equal(air_grid_load_vol(files->context, "x.vol", &grid), AIR_ERROR_FORMAT);
            free(exact);
        }
    }
}

static void test_shared_volumes_load(void **state)
{
    static const struct {
        const char *name;
        size_t size[3], channels;
        bool negative;
    } volumes[] = {{"smoke.vol", {128, 128, 50}, 1, false},
                   {"albedo.vol", {80, 80, 40}, 3, false},
                   {"colored_density.vol", {80, 80, 40}, 3, true}};
    air_context *context = NULL;
    (void)state;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    for (size_t i = 0; i < 3; i++) {
        char path[512];
        (void)snprintf(path, sizeof path, "%s/scenes/lajolla_volpath/%s", AIR_SHARED_DIR,
                       volumes[i].name);
        if (access(path, R_OK) != 0) {
            air_context_destroy(context);
            print_message("skipped: %s is not there\n", path);
            skip();
        }
        air_grid *grid = NULL;
        size_t size[3];
        assert_int_equal(air_grid_load_vol(context, path, &grid), AIR_OK);
        air_grid_size(grid, size);
        assert_memory_equal(size, volumes[i].size, sizeof size);
        assert_int_equal(air_grid_channels(grid), volumes[i].channels);
        assert_true(air_grid_max(grid) > 0.0f && isfinite(air_grid_max(grid)));
        air_grid_destroy(grid);
    }
    air_context_destroy(context);
}

static void test_raw_grids_fill_the_unit_cube(void **state)
{
    memory_file *files = *state;
    static const size_t size[3] = {2, 3, 4};
    float values[2 * 3 * 4 * 3];
    for (size_t i = 0; i < 72; i++) {
        values[i] = (float)i;
    }
    air_grid *grid = NULL;
    memory_file_serve(files, values, sizeof values);
    assert_int_equal(air_grid_load_raw(files->context, "x.raw", size, 3, &grid), AIR_OK);
    const air_vec3 value = air_grid_lookup(grid, vec3(1.0f, 2.0f, 3.0f));
    assert_true(value.x == 69.0f && value.y == 70.0f && value.z == 71.0f);
    const air_vec3 low = affine_point(air_grid_index_to_local(grid), vec3_set1(-0.5f));
    const air_vec3 high = affine_point(air_grid_index_to_local(grid), vec3(1.5f, 2.5f, 3.5f));
    assert_true(vec3_length(low) < 1e-6f && vec3_length(vec3_sub(high, vec3_set1(1.0f))) < 1e-6f);
    air_grid_destroy(grid);
    grid = NULL;
    assert_int_equal(air_grid_load_raw(files->context, "x.raw", size, 1, &grid), AIR_ERROR_FORMAT);
    memory_file_expect(
        files,
        "x.raw: the file has 288 bytes, expected 96: 2 x 3 x 4 float32 values of 1 channels");
    assert_int_equal(air_grid_load_raw(files->context, "x.raw", size, 4, &grid),
                     AIR_ERROR_ARGUMENT);
    static const size_t none[3] = {2, 0, 4};
    assert_int_equal(air_grid_load_raw(files->context, "x.raw", none, 1, &grid),
                     AIR_ERROR_ARGUMENT);
    assert_null(grid);
}

static void test_a_missing_file_is_an_error(void **state)
{
    air_context *context = NULL;
    air_grid *grid = NULL;
    static const size_t size[3] = {1, 1, 1};
    (void)state;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    assert_int_equal(air_grid_load_vol(context, "/nowhere.vol", &grid), AIR_ERROR_IO);
    assert_int_equal(air_grid_load_nvdb(context, "/nowhere.nvdb", NULL, &grid), AIR_ERROR_IO);
    assert_int_equal(air_grid_load_raw(context, "/nowhere.raw", size, 1, &grid), AIR_ERROR_IO);
    assert_null(grid);
    air_context_destroy(context);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_every_encoding_gives_the_values_written),
        TEST(test_voxels_fill_the_bounding_box),
        TEST(test_damaged_headers_are_refused_with_their_byte),
        TEST(test_truncated_files_are_refused_at_every_length),
        TEST(test_shared_volumes_load),
        TEST(test_raw_grids_fill_the_unit_cube),
        TEST(test_a_missing_file_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

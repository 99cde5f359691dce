/* NanoVDB files: what tests/data/nvdb/make_nvdb.cpp wrote must come back, and nothing a file holds
 * may do harm. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "core/random.h"
#include "memory_files.h"
#include "scene/media/grid.h"
#include "scene/media/nvdb_file.h"

#define DATA AIR_SOURCE_DIR "/tests/data/nvdb/"

enum { HEADER_SIZE = 16, DESCRIPTION_SIZE = 176 };

/* As in make_nvdb.cpp. */
static float pattern(int i, int j, int k)
{
    return 1.0f + (float)((3 * i + 5 * j + 7 * k) & 15) / 16.0f;
}

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

static uint8_t *read_bytes(const char *path, size_t *out_size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    uint8_t *bytes = malloc(1 << 20);
    *out_size = fread(bytes, 1, 1 << 20, file);
    (void)fclose(file);
    return bytes;
}

/* Loads bytes; the grid, or NULL with the status. */
static air_grid *load_bytes(memory_file *files, const void *bytes, size_t size, const char *name,
                            air_status *out_status)
{
    air_grid *grid = NULL;
    memory_file_serve(files, bytes, size);
    *out_status = air_grid_load_nvdb(files->context, "x.nvdb", name, &grid);
    assert_true((grid != NULL) == (*out_status == AIR_OK));
    return grid;
}

static air_grid *load_name(memory_file *files, const char *file, const char *name)
{
    size_t size;
    air_status status;
    uint8_t *bytes = read_bytes(file, &size);
    air_grid *grid = load_bytes(files, bytes, size, name, &status);
    free(bytes);
    if (grid == NULL) {
        fail_msg("%s: %s", file, air_context_last_error(files->context));
    }
    return grid;
}

static void expect_error(memory_file *files, const char *file, const char *name,
                         air_status expected, const char *part)
{
    size_t size;
    air_status status;
    uint8_t *bytes = read_bytes(file, &size);
    assert_null(load_bytes(files, bytes, size, name, &status));
    free(bytes);
    assert_int_equal(status, expected);
    memory_file_expect(files, part);
}

/* The value at index (i, j, k) of the file: its place is 0.25 (i, j, k) + (1, 2, 3). */
static air_vec3 value_at(const air_grid *grid, float i, float j, float k)
{
    float local_to_index[12];
    assert_true(affine_invert(air_grid_index_to_local(grid), local_to_index));
    const air_vec3 place = vec3(0.25f * i + 1.0f, 0.25f * j + 2.0f, 0.25f * k + 3.0f);
    return air_grid_lookup(grid, affine_point(local_to_index, place));
}

/* All voxels of the pattern and a border around it. */
static void check_pattern(const air_grid *grid, float tolerance)
{
    for (int k = 0; k <= 8; k++) {
        for (int j = -2; j <= 12; j++) {
            for (int i = -5; i <= 9; i++) {
                const bool inside = i >= -3 && i <= 6 && j >= 0 && j <= 9 && k >= 2 && k <= 5;
                const float expected = inside ? pattern(i, j, k) : 0.0f;
                const float found = value_at(grid, (float)i, (float)j, (float)k).x;
                assert_true(fabsf(found - expected) <= tolerance);
            }
        }
    }
}

/* Positions below 5 go through two maps with 4 steps per metre: 2^-24 * 5 * 4 * a few in index
 * units, times a slope of at most 2. */
static const float map_tolerance = 1e-5f;

static void test_every_codec_gives_the_values_written(void **state)
{
    static const char *const names[] = {DATA "zip.nvdb", DATA "blosc.nvdb"};
    for (size_t i = 0; i < 2; i++) {
        air_grid *grid = load_name(*state, names[i], NULL);
        assert_int_equal(air_grid_channels(grid), 1);
        assert_true(air_grid_max(grid) == 1.9375f);
        check_pattern(grid, map_tolerance);
        air_grid_destroy(grid);
    }
}

static void test_value_types_give_the_values_written(void **state)
{
    /* FpN, the last, keeps errors below 0.01 by default. The others quantise the range 0..1.9375 of
     * a leaf. */
    static const struct {
        const char *name;
        float error;
    } files[] = {{DATA "double.nvdb", 0.0f},
                 {DATA "fp4.nvdb", 1.9375f / 15.0f},
                 {DATA "fp8.nvdb", 1.9375f / 255.0f},
                 {DATA "fp16.nvdb", 1.9375f / 65535.0f},
                 {DATA "fpn.nvdb", 0.011f}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        air_grid *grid = load_name(*state, files[i].name, NULL);
        check_pattern(grid, files[i].error + map_tolerance);
        air_grid_destroy(grid);
    }
}

static void test_vectors_become_three_channels(void **state)
{
    air_grid *grid = load_name(*state, DATA "vec3f.nvdb", NULL);
    assert_int_equal(air_grid_channels(grid), 3);
    for (int i = -3; i <= 6; i++) {
        for (int k = 2; k <= 5; k++) {
            const air_vec3 value = value_at(grid, (float)i, 4.0f, (float)k);
            assert_true(fabsf(value.x - pattern(i, 4, k)) <= map_tolerance);
            assert_true(fabsf(value.y - 0.5f) <= map_tolerance);
            assert_true(fabsf(value.z - pattern(k, 4, i)) <= map_tolerance);
        }
    }
    air_grid_destroy(grid);
}

static void test_values_are_trilinear_between_voxels_and_fall_off_outside(void **state)
{
    air_grid *grid = load_name(*state, DATA "zip.nvdb", NULL);
    const float mean = 0.5f * (pattern(2, 3, 4) + pattern(3, 3, 4));
    assert_true(fabsf(value_at(grid, 2.5f, 3.0f, 4.0f).x - mean) <= map_tolerance);
    assert_true(fabsf(value_at(grid, 6.5f, 3.0f, 4.0f).x - 0.5f * pattern(6, 3, 4)) <=
                map_tolerance);
    assert_true(fabsf(value_at(grid, 2.0f, -0.75f, 4.0f).x - 0.25f * pattern(2, 0, 4)) <=
                map_tolerance);
    air_grid_destroy(grid);
}

static void test_active_tiles_are_filled(void **state)
{
    air_grid *grid = load_name(*state, DATA "tiles.nvdb", NULL);
    assert_true(value_at(grid, 3.0f, 3.0f, 3.0f).x == 0.25f);
    assert_true(value_at(grid, 2.0f, 3.0f, 3.0f).x == 0.0f);
    assert_true(value_at(grid, 8.0f, 0.0f, 0.0f).x == 0.5f &&
                value_at(grid, 15.0f, 7.0f, 7.0f).x == 0.5f);
    assert_true(value_at(grid, 16.0f, 7.0f, 7.0f).x == 0.0f);
    assert_true(value_at(grid, -128.0f, 0.0f, 0.0f).x == 2.0f &&
                value_at(grid, -1.0f, 127.0f, 127.0f).x == 2.0f);
    assert_true(value_at(grid, 0.0f, 127.0f, 127.0f).x == 0.0f);
    /* of the 17^3 bricks that see the large tile, the 15^3 inside it are one */
    assert_true(air_grid_bytes(grid) < (size_t)(17 * 17 * 17 - 15 * 15 * 15 + 50) * 3000);
    air_grid_destroy(grid);
}

static void test_a_grid_is_found_by_name_density_first(void **state)
{
    air_grid *density = load_name(*state, DATA "several.nvdb", NULL);
    assert_true(air_grid_max(density) == 1.9375f);
    air_grid_destroy(density);
    air_grid *warm = load_name(*state, DATA "several.nvdb", "warm");
    assert_true(air_grid_max(warm) == 300.0f);
    air_grid_destroy(warm);
    expect_error(
        *state, DATA "several.nvdb", "cold", AIR_ERROR_ARGUMENT,
        "no grid \"cold\" with float values; the file holds \"ids\" (int32), \"warm\" (float)");
    expect_error(*state, DATA "several.nvdb", "ids", AIR_ERROR_ARGUMENT,
                 "no grid \"ids\" with float values");
    expect_error(*state, DATA "ids.nvdb", NULL, AIR_ERROR_UNSUPPORTED,
                 "the file holds \"ids\" (int32)");
}

static void test_segments_may_follow_each_other(void **state)
{
    size_t first_size, second_size;
    air_status status;
    uint8_t *first = read_bytes(DATA "ids.nvdb", &first_size);
    uint8_t *second = read_bytes(DATA "blosc.nvdb", &second_size);
    memcpy(first + first_size, second, second_size);
    air_grid *grid = load_bytes(*state, first, first_size + second_size, NULL, &status);
    assert_non_null(grid);
    check_pattern(grid, map_tolerance);
    air_grid_destroy(grid);
    free(second);
    free(first);
}

static void test_values_that_are_no_densities_are_reported(void **state)
{
    memory_file *files = *state;
    expect_error(files, DATA "nan.nvdb", NULL, AIR_ERROR_FORMAT,
                 "voxel (4, 5, 3) channel 0 is nan");
    expect_error(files, DATA "level_set.nvdb", NULL, AIR_ERROR_UNSUPPORTED, "is a level set");
    const size_t before = files->warning_count;
    air_grid *grid = load_name(files, DATA "negative.nvdb", NULL);
    assert_int_equal(files->warning_count, before + 1);
    assert_non_null(strstr(files->warning, ": 1 negative values"));
    assert_true(value_at(grid, -2.0f, 1.0f, 2.0f).x < map_tolerance);
    air_grid_destroy(grid);
}

static void test_truncated_files_are_refused_at_every_length(void **state)
{
    static const char *const names[] = {DATA "zip.nvdb", DATA "blosc.nvdb", DATA "several.nvdb"};
    for (size_t n = 0; n < 3; n++) {
        size_t size;
        air_status status;
        uint8_t *bytes = read_bytes(names[n], &size);
        for (size_t cut = 0; cut < size; cut++) {
            uint8_t *exact = malloc(cut + 1); /* so that a sanitizer sees reads beyond */
            memcpy(exact, bytes, cut);
            assert_null(load_bytes(*state, exact, cut, NULL, &status));
            assert_int_equal(status, AIR_ERROR_FORMAT);
            memory_file_expect(*state, "x.nvdb: byte ");
            free(exact);
        }
        free(bytes);
    }
}

static void test_other_versions_magics_and_codecs_are_named(void **state)
{
    memory_file *files = *state;
    size_t size;
    air_status status;
    uint8_t *bytes = read_bytes(DATA "zip.nvdb", &size);
    bytes[7] = '2'; /* the magic number since OpenVDB 11 */
    air_grid *grid = load_bytes(files, bytes, size, NULL, &status);
    assert_non_null(grid);
    air_grid_destroy(grid);
    bytes[7] = '7';
    assert_null(load_bytes(files, bytes, size, NULL, &status));
    memory_file_expect(files, "byte 0: expected the magic number");
    bytes[7] = '0';
    const uint32_t version = 33u << 21 | 5u << 10 | 1u;
    memcpy(bytes + 8, &version, sizeof version);
    assert_null(load_bytes(files, bytes, size, NULL, &status));
    assert_int_equal(status, AIR_ERROR_UNSUPPORTED);
    memory_file_expect(files, "NanoVDB format 33.5.1, expected 32");
    free(bytes);
    bytes = read_bytes(DATA "zip.nvdb", &size);
    bytes[14] = 3;
    assert_null(load_bytes(files, bytes, size, NULL, &status));
    memory_file_expect(files, "byte 14: codec 3");
    free(bytes);
}

static bool accept_float(uint32_t type) { return type == 1; }

/* zip.nvdb with its grid unpacked: the same file as written with codec none. */
static uint8_t *plain_file(memory_file *files, size_t *out_size)
{
    air_nvdb_entry entry;
    uint8_t *grid = NULL;
    size_t size;
    uint8_t *bytes = read_bytes(DATA "zip.nvdb", &size);
    assert_int_equal(air_nvdb_find(files->context, "x", bytes, size, NULL, accept_float, &entry),
                     AIR_OK);
    assert_int_equal(air_nvdb_unpack(files->context, "x", bytes, &entry, &grid), AIR_OK);
    uint8_t *plain = calloc(entry.offset + entry.grid_size, 1);
    memcpy(plain, bytes, entry.offset);
    memcpy(plain + entry.offset, grid, entry.grid_size);
    plain[14] = 0;                /* the segment's codec */
    plain[HEADER_SIZE + 168] = 0; /* the grid's */
    memcpy(plain + HEADER_SIZE + 8, &entry.grid_size,
           sizeof entry.grid_size); /* its bytes in the file */
    *out_size = entry.offset + entry.grid_size;
    air_free(files->context, grid);
    free(bytes);
    return plain;
}

static void test_unpacked_files_give_the_values_written(void **state)
{
    size_t size;
    air_status status;
    uint8_t *plain = plain_file(*state, &size);
    air_grid *grid = load_bytes(*state, plain, size, "density", &status);
    assert_non_null(grid);
    check_pattern(grid, map_tolerance);
    air_grid_destroy(grid);
    free(plain);
}

/* Any damage must end in an error or a grid that is still sound. */
static void check_damaged(memory_file *files, const uint8_t *bytes, size_t size, size_t *failures)
{
    air_status status;
    air_grid *grid = load_bytes(files, bytes, size, NULL, &status);
    if (grid != NULL) {
        const air_vec3 value = air_grid_lookup(grid, vec3(9.5f, 10.5f, 11.5f));
        assert_true(vec3_min(value) >= 0.0f && vec3_max(value) <= air_grid_max(grid) * 1.000001f);
    }
    *failures += grid == NULL;
    air_grid_destroy(grid);
}

static void test_damaged_nodes_do_no_harm(void **state)
{
    static const uint64_t poison[] = {
        0, 1, 7, 32, 0x8000000000000000u, 0xffffffffffffffffu, 1024, 0x7fffffff, 0xffffffff00u};
    size_t size, failures = 0;
    uint8_t *plain = plain_file(*state, &size);
    air_rng rng = air_rng_from_keys(11, 3);
    const size_t begin = HEADER_SIZE + DESCRIPTION_SIZE + 8; /* "density" and its NUL */
    for (int n = 0; n < 300; n++) {
        /* half of it in header, tree, root and its tiles, the rest anywhere: masks, child tables,
         * leaves */
        const size_t range = n % 2 == 0 ? 900 : size - begin - 8;
        const size_t at = begin + (air_rng_next(&rng) % (uint32_t)range & ~7u);
        uint64_t kept;
        memcpy(&kept, plain + at, sizeof kept);
        const uint64_t value =
            n % 3 == 0 ? (uint64_t)air_rng_next(&rng) << (n % 32) : poison[n % 9];
        memcpy(plain + at, &value, sizeof value);
        check_damaged(*state, plain, size, &failures);
        memcpy(plain + at, &kept, sizeof kept);
    }
    assert_true(failures > 10);
    free(plain);
}

static void test_damaged_bytes_do_no_harm(void **state)
{
    static const char *const names[] = {DATA "zip.nvdb", DATA "blosc.nvdb", DATA "fpn.nvdb",
                                        DATA "tiles.nvdb"};
    air_rng rng = air_rng_from_keys(12, 3);
    size_t failures = 0;
    for (size_t f = 0; f < 4; f++) {
        size_t size;
        uint8_t *bytes = read_bytes(names[f], &size);
        for (int n = 0; n < 400; n++) {
            /* headers first, then the packed bytes */
            const size_t at = n < 200 ? (size_t)n : air_rng_next(&rng) % (uint32_t)size;
            const uint8_t kept = bytes[at];
            bytes[at] = (uint8_t)(kept ^ (1u + air_rng_next(&rng) % 255u));
            check_damaged(*state, bytes, size, &failures);
            bytes[at] = kept;
        }
        free(bytes);
    }
    assert_true(failures > 100);
}

static void test_impossible_sizes_are_refused_before_memory_is_asked_for(void **state)
{
    memory_file *files = *state;
    size_t size;
    air_status status;
    uint8_t *bytes = read_bytes(DATA "zip.nvdb", &size);
    const uint64_t huge = (uint64_t)1 << 40;
    memcpy(bytes + HEADER_SIZE, &huge, sizeof huge);
    assert_null(load_bytes(files, bytes, size, NULL, &status));
    assert_int_equal(status, AIR_ERROR_FORMAT);
    memory_file_expect(files, "to 1099511627776 bytes, which cannot be");
    free(bytes);
}

static void test_a_shared_file_of_an_older_format_says_so(void **state)
{
    const char *path = AIR_SHARED_DIR "/scenes/pbrt4_houdini_tests/resources/sphere.nvdb";
    if (access(path, R_OK) != 0) {
        print_message("skipped: %s is not there\n", path);
        skip();
    }
    /* written before NanoVDB's first release; neither PNanoVDB.h nor NanoVDB's own tools read it */
    expect_error(*state, path, NULL, AIR_ERROR_UNSUPPORTED, "NanoVDB format 0.0.19, expected 32");
}

static void test_allocation_failure_leaves_nothing_behind(void **state)
{
    memory_file *files = *state;
    size_t size;
    uint8_t *bytes = read_bytes(DATA "zip.nvdb", &size);
    const long live = atomic_load(&files->allocator.live);
    long allowed = 0;
    for (air_status status = AIR_ERROR_MEMORY; status != AIR_OK; allowed++) {
        atomic_store(&files->allocator.remaining, allowed);
        air_grid_destroy(load_bytes(files, bytes, size, NULL, &status));
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_true(atomic_load(&files->allocator.live) <= live + 1); /* the message may be kept */
    }
    assert_true(allowed > 6);
    free(bytes);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_every_codec_gives_the_values_written),
        TEST(test_value_types_give_the_values_written),
        TEST(test_vectors_become_three_channels),
        TEST(test_values_are_trilinear_between_voxels_and_fall_off_outside),
        TEST(test_active_tiles_are_filled),
        TEST(test_a_grid_is_found_by_name_density_first),
        TEST(test_segments_may_follow_each_other),
        TEST(test_values_that_are_no_densities_are_reported),
        TEST(test_truncated_files_are_refused_at_every_length),
        TEST(test_other_versions_magics_and_codecs_are_named),
        TEST(test_unpacked_files_give_the_values_written),
        TEST(test_damaged_nodes_do_no_harm),
        TEST(test_damaged_bytes_do_no_harm),
        TEST(test_impossible_sizes_are_refused_before_memory_is_asked_for),
        TEST(test_a_shared_file_of_an_older_format_says_so),
        TEST(test_allocation_failure_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

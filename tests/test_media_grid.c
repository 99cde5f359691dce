/* Bricks, lookups and walks against naive versions of themselves. */
#include <math.h>
#include <stdlib.h>

#include "core/random.h"
#include "memory_files.h"
#include "scene/media/grid.h"
#include "scene/media/grid_bricks.h"

typedef struct dense_grid {
    size_t size[3], channels;
    float *values;
} dense_grid;

static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

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

/* Random values; a share of them 0 in blobs, so that some bricks are empty. */
static dense_grid random_grid(size_t nx, size_t ny, size_t nz, size_t channels, float filled,
                              air_rng *rng)
{
    dense_grid dense = {{nx, ny, nz}, channels, calloc(nx * ny * nz * channels, sizeof(float))};
    for (size_t k = 0; k < nz; k++) {
        for (size_t j = 0; j < ny; j++) {
            for (size_t i = 0; i < nx; i++) {
                const uint32_t blob = (uint32_t)(i / 9 + 31 * (j / 9) + 977 * (k / 9));
                if (air_uint_to_float(air_hash32(blob)) < filled) {
                    for (size_t c = 0; c < channels; c++) {
                        dense.values[((k * ny + j) * nx + i) * channels + c] =
                            5.0f * air_rng_float(rng);
                    }
                }
            }
        }
    }
    return dense;
}

static air_grid *make_grid(memory_file *files, const dense_grid *dense)
{
    air_grid_desc desc = {.name = "test", .channels = dense->channels, .values = dense->values};
    memcpy(desc.size, dense->size, sizeof desc.size);
    memcpy(desc.index_to_local, identity, sizeof identity);
    air_grid *grid = NULL;
    assert_int_equal(air_grid_create(files->context, &desc, &grid), AIR_OK);
    return grid;
}

static double clamp(double x, double low, double high) { return fmin(fmax(x, low), high); }

/* The definition of medium.h, word by word, in double. */
static double naive_lookup(const dense_grid *dense, const float p[3], size_t channel)
{
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        if (p[k] < -0.5f || p[k] > (float)dense->size[k] - 0.5f) {
            return 0.0;
        }
    }
    for (int n = 0; n < 8; n++) {
        double weight = 1.0;
        size_t at[3];
        for (int k = 0; k < 3; k++) {
            const double last = (double)dense->size[k] - 1.0, x = clamp((double)p[k], 0.0, last);
            const double low = floor(x), f = x - low;
            const int high = n >> k & 1;
            at[k] = (size_t)clamp(low + high, 0.0, last);
            weight *= high ? f : 1.0 - f;
        }
        sum += weight *
               (double)dense->values[((at[2] * dense->size[1] + at[1]) * dense->size[0] + at[0]) *
                                         dense->channels +
                                     channel];
    }
    return sum;
}

static void check_lookup(const air_grid *grid, const dense_grid *dense, const float p[3])
{
    const air_vec3 value = air_grid_lookup(grid, vec3(p[0], p[1], p[2]));
    const float found[3] = {value.x, value.y, value.z};
    for (size_t c = 0; c < 3; c++) {
        const double expected = naive_lookup(dense, p, dense->channels == 3 ? c : 0);
        /* values up to 5; seven roundings of 2^-24 each, and the fraction's own */
        assert_true(fabs((double)found[c] - expected) <= 16.0 * 0x1p-24 * 5.0);
    }
}

static void test_lookup_equals_the_trilinear_definition(void **state)
{
    static const size_t sizes[][3] = {{1, 1, 1},  {2, 3, 1},    {8, 8, 8},   {9, 9, 9},
                                      {16, 7, 9}, {17, 23, 40}, {33, 24, 1}, {64, 5, 3}};
    air_rng rng = air_rng_from_keys(1, 2);
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        for (size_t channels = 1; channels <= 3; channels += 2) {
            dense_grid dense =
                random_grid(sizes[s][0], sizes[s][1], sizes[s][2], channels, 0.6f, &rng);
            air_grid *grid = make_grid(*state, &dense);
            for (int n = 0; n < 4000; n++) {
                float p[3];
                for (int k = 0; k < 3; k++) {
                    const float size = (float)dense.size[k];
                    p[k] = air_rng_float(&rng) * (size + 1.0f) - 1.0f;
                    /* a third of the points on samples, cell borders and the edge */
                    p[k] = n % 3 == 0 ? rintf(2.0f * p[k]) * 0.5f : p[k];
                }
                check_lookup(grid, &dense, p);
            }
            air_grid_destroy(grid);
            free(dense.values);
        }
    }
}

static void test_lookup_of_points_that_are_not_numbers_is_zero(void **state)
{
    air_rng rng = air_rng_from_keys(3, 2);
    dense_grid dense = random_grid(10, 10, 10, 1, 1.0f, &rng);
    air_grid *grid = make_grid(*state, &dense);
    assert_true(vec3_is_zero(air_grid_lookup(grid, vec3(NAN, 1.0f, 1.0f))));
    assert_true(vec3_is_zero(air_grid_lookup(grid, vec3(1.0f, INFINITY, 1.0f))));
    assert_true(vec3_is_zero(air_grid_lookup(grid, vec3(1.0f, 1.0f, -1e30f))));
    air_grid_destroy(grid);
    free(dense.values);
}

static air_vec3 random_direction(air_rng *rng, int n)
{
    air_vec3 dir = vec3(2.0f * air_rng_float(rng) - 1.0f, 2.0f * air_rng_float(rng) - 1.0f,
                        2.0f * air_rng_float(rng) - 1.0f);
    dir.x = n % 4 == 1 ? 0.0f : dir.x; /* some along planes and axes */
    dir.y = n % 8 == 1 ? 0.0f : dir.y;
    return vec3_scale(dir, 0.2f + 3.0f * air_rng_float(rng));
}

/* Walks one ray; returns the number of pieces. */
static size_t check_walk(const air_grid *grid, air_vec3 origin, air_vec3 dir, float t0, float t1,
                         air_rng *rng)
{
    air_grid_walk walk;
    float a, b, majorant, end = t0;
    size_t count = 0;
    air_grid_walk_start(&walk, grid, origin, dir, t0, t1);
    while (air_grid_walk_next(&walk, &a, &b, &majorant)) {
        assert_true(a == end && b > a && b <= t1);
        end = b;
        count++;
        /* Points and pieces are rounded separately, to 2^-22 of the largest index coordinate that
         * occurs (below 200), so samples keep this much away from a piece's ends. */
        const float margin = 2e-4f / vec3_length(dir);
        const float length = fminf(b, a + 1000.0f) - a - 2.0f * margin;
        for (int i = 0; i < 40 && length > 0.0f; i++) {
            const float t = a + margin + length * air_rng_float(rng);
            const air_vec3 value = air_grid_lookup(grid, vec3_madd(origin, t, dir));
            assert_true(vec3_max(value) <= majorant);
        }
    }
    assert_true(end == t1);
    return count;
}

static void test_walk_pieces_adjoin_cover_the_ray_and_bound_the_values(void **state)
{
    air_rng rng = air_rng_from_keys(5, 1);
    dense_grid dense = random_grid(40, 23, 17, 3, 0.4f, &rng);
    air_grid *grid = make_grid(*state, &dense);
    for (int n = 0; n < 2000; n++) {
        const air_vec3 origin =
            vec3(60.0f * air_rng_float(&rng) - 10.0f, 43.0f * air_rng_float(&rng) - 10.0f,
                 37.0f * air_rng_float(&rng) - 10.0f);
        const air_vec3 at = n % 5 == 0 ? vec3(8.0f, 16.0f, 0.0f) : origin; /* on brick borders */
        check_walk(grid, at, random_direction(&rng, n), 3.0f * air_rng_float(&rng),
                   n % 7 == 0 ? INFINITY : 3.0f + 40.0f * air_rng_float(&rng), &rng);
    }
    air_grid_destroy(grid);
    free(dense.values);
}

static void test_walk_gives_a_piece_per_brick(void **state)
{
    air_rng rng = air_rng_from_keys(6, 1);
    dense_grid dense = random_grid(64, 8, 8, 1, 1.0f, &rng);
    air_grid *grid = make_grid(*state, &dense);
    /* before, eight bricks, behind; along both directions */
    assert_int_equal(check_walk(grid, vec3(-5, 4, 4), vec3(1, 0, 0), 0.0f, 100.0f, &rng), 10);
    assert_int_equal(check_walk(grid, vec3(70, 4, 4), vec3(-1, 0, 0), 0.0f, 100.0f, &rng), 10);
    /* starts and ends inside */
    assert_int_equal(check_walk(grid, vec3(1, 4, 4), vec3(1, 0, 0), 0.0f, 10.0f, &rng), 2);
    /* misses */
    assert_int_equal(check_walk(grid, vec3(-5, 14, 4), vec3(1, 0, 0), 0.0f, INFINITY, &rng), 1);
    air_grid_destroy(grid);
    free(dense.values);
}

static void test_walk_joins_empty_bricks(void **state)
{
    dense_grid dense = {{80, 8, 8}, 1, calloc(80 * 8 * 8, sizeof(float))};
    dense.values[79] = 1.0f;
    air_grid *grid = make_grid(*state, &dense);
    air_grid_walk walk;
    float a, b, majorant;
    air_grid_walk_start(&walk, grid, vec3(0, 0, 0), vec3(1, 0, 0), 0.0f, 200.0f);
    assert_true(air_grid_walk_next(&walk, &a, &b, &majorant));
    assert_true(a == 0.0f && b == 72.0f && majorant == 0.0f);
    assert_true(air_grid_walk_next(&walk, &a, &b, &majorant));
    assert_true(a == 72.0f && b == 79.5f && majorant >= 1.0f && majorant < 1.0001f);
    assert_true(air_grid_walk_next(&walk, &a, &b, &majorant));
    assert_true(b == 200.0f && majorant == 0.0f);
    assert_false(air_grid_walk_next(&walk, &a, &b, &majorant));
    air_grid_destroy(grid);
    free(dense.values);
}

static void test_empty_and_uniform_bricks_take_no_memory(void **state)
{
    const size_t count = (size_t)128 * 128 * 128;
    dense_grid dense = {{128, 128, 128}, 1, calloc(count, sizeof(float))};
    air_grid *empty = make_grid(*state, &dense);
    assert_true(air_grid_bytes(empty) < 64 * 1024);
    assert_true(air_grid_max(empty) == 0.0f);
    for (size_t i = 0; i < count; i++) {
        dense.values[i] = 0.75f;
    }
    air_grid *uniform = make_grid(*state, &dense);
    assert_true(air_grid_bytes(uniform) < 64 * 1024);
    assert_true(air_grid_lookup(uniform, vec3(63.3f, 1.2f, 120.9f)).x == 0.75f);
    assert_true(air_grid_max(uniform) == 0.75f);
    air_grid_destroy(uniform);
    air_grid_destroy(empty);
    free(dense.values);
}

static void test_negative_values_are_clamped_and_counted_once(void **state)
{
    memory_file *files = *state;
    float values[17 * 9 * 9];
    for (size_t i = 0; i < 17 * 9 * 9; i++) {
        values[i] = -1.0f; /* each lies in up to eight bricks */
    }
    dense_grid dense = {{17, 9, 9}, 1, values};
    air_grid *grid = make_grid(files, &dense);
    assert_int_equal(files->warning_count, 1);
    assert_non_null(strstr(files->warning, "1377 negative values"));
    assert_true(air_grid_max(grid) == 0.0f);
    air_grid_destroy(grid);
}

static air_brick_kind give_one_sample(void *user, const int32_t base[3], float *out)
{
    (void)base;
    memcpy(out, user, 3 * sizeof *out);
    return AIR_BRICK_UNIFORM;
}

static void test_one_sample_for_a_uniform_brick_gives_what_all_samples_give(void **state)
{
    memory_file *files = *state;
    float sample[3] = {2.0f, -1.0f, 3.0f};
    float values[17 * 9 * 9 * 3];
    for (size_t i = 0; i < 17 * 9 * 9 * 3; i++) {
        values[i] = sample[i % 3];
    }
    dense_grid dense = {{17, 9, 9}, 3, values};
    air_grid_source source = {.what = "test",
                              .size = {17, 9, 9},
                              .channels = 3,
                              .user = sample,
                              .read_brick = give_one_sample};
    memcpy(source.index_to_local, identity, sizeof identity);
    air_grid *one = NULL, *all = make_grid(files, &dense);
    assert_non_null(strstr(files->warning, "1377 negative values"));
    files->warning[0] = '\0';
    assert_int_equal(air_grid_make(files->context, &source, &one), AIR_OK);
    assert_non_null(strstr(files->warning, "1377 negative values"));
    assert_int_equal(air_grid_bytes(one), air_grid_bytes(all));
    assert_true(air_grid_max(one) == air_grid_max(all));
    for (float x = -1.0f; x < 18.0f; x += 0.7f) {
        const air_vec3 a = air_grid_lookup(one, vec3(x, 8.2f, 0.4f));
        const air_vec3 b = air_grid_lookup(all, vec3(x, 8.2f, 0.4f));
        assert_true(a.x == b.x && a.y == b.y && a.z == b.z);
    }
    air_grid_destroy(all);
    air_grid_destroy(one);
    sample[1] = NAN;
    one = NULL;
    assert_int_equal(air_grid_make(files->context, &source, &one), AIR_ERROR_FORMAT);
    assert_null(one);
    memory_file_expect(files, "voxel (0, 0, 0) channel 1 is nan");
}

static void expect_refused(memory_file *files, const air_grid_desc *desc, air_status status,
                           const char *part)
{
    air_grid *grid = NULL;
    assert_int_equal(air_grid_create(files->context, desc, &grid), status);
    assert_null(grid);
    memory_file_expect(files, part);
}

static void test_what_cannot_be_a_grid_is_refused_with_the_reason(void **state)
{
    memory_file *files = *state;
    float values[600] = {0.0f};
    air_grid_desc good = {.name = "smoke", .size = {10, 10, 6}, .channels = 1, .values = values};
    memcpy(good.index_to_local, identity, sizeof identity);
    air_grid_desc bad = good;
    bad.size[1] = 0;
    expect_refused(files, &bad, AIR_ERROR_ARGUMENT, "smoke: the grid's size is 10 x 0 x 6");
    bad = good;
    bad.channels = 2;
    expect_refused(files, &bad, AIR_ERROR_ARGUMENT, "2 channels");
    bad = good;
    bad.values = NULL;
    expect_refused(files, &bad, AIR_ERROR_ARGUMENT, "no values");
    bad = good;
    bad.size[0] = bad.size[1] = bad.size[2] = 4000;
    expect_refused(files, &bad, AIR_ERROR_UNSUPPORTED, "256000000000 bytes");
    bad = good;
    bad.index_to_local[0] = 0.0f;
    expect_refused(files, &bad, AIR_ERROR_ARGUMENT, "cannot be inverted");
    bad.index_to_local[0] = NAN;
    expect_refused(files, &bad, AIR_ERROR_ARGUMENT, "cannot be inverted");
    values[(4 * 10 + 9) * 10 + 8] = NAN;
    expect_refused(files, &good, AIR_ERROR_FORMAT, "voxel (8, 9, 4) channel 0 is");
    values[(4 * 10 + 9) * 10 + 8] = -INFINITY;
    expect_refused(files, &good, AIR_ERROR_FORMAT, "voxel (8, 9, 4) channel 0 is -inf");
}

static void test_allocation_failure_leaves_nothing_behind(void **state)
{
    memory_file *files = *state;
    air_rng rng = air_rng_from_keys(8, 1);
    dense_grid dense = random_grid(70, 30, 30, 1, 0.5f, &rng);
    air_grid_desc desc = {.size = {70, 30, 30}, .channels = 1, .values = dense.values};
    memcpy(desc.index_to_local, identity, sizeof identity);
    const long live = atomic_load(&files->allocator.live);
    long allowed = 0;
    for (air_status status = AIR_ERROR_MEMORY; status != AIR_OK; allowed++) {
        air_grid *grid = NULL;
        atomic_store(&files->allocator.remaining, allowed);
        status = air_grid_create(files->context, &desc, &grid);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_true((status == AIR_OK) == (grid != NULL));
        air_grid_destroy(grid);
        assert_true(atomic_load(&files->allocator.live) <= live + 1); /* the message may be kept */
    }
    assert_true(allowed > 4);
    free(dense.values);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_lookup_equals_the_trilinear_definition, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_lookup_of_points_that_are_not_numbers_is_zero, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_walk_pieces_adjoin_cover_the_ray_and_bound_the_values,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_walk_gives_a_piece_per_brick, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_walk_joins_empty_bricks, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_empty_and_uniform_bricks_take_no_memory, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_negative_values_are_clamped_and_counted_once, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(
            test_one_sample_for_a_uniform_brick_gives_what_all_samples_give, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_what_cannot_be_a_grid_is_refused_with_the_reason,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_allocation_failure_leaves_nothing_behind, set_up,
                                        tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

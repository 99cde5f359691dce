/* Where a grid has values, against lookups and a naive search. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/random.h"
#include "scene/media/grid.h"

static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static air_grid *make_grid(air_context *context, const size_t size[3], size_t channels,
                           const float *values)
{
    air_grid_desc desc = {.name = "test", .channels = channels, .values = values};
    air_grid *grid = NULL;
    memcpy(desc.size, size, sizeof desc.size);
    memcpy(desc.index_to_local, identity, sizeof identity);
    assert_int_equal(air_grid_create(context, &desc, &grid), AIR_OK);
    return grid;
}

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

/* Values on a random box within, in (0, 1), of which at least the corners are above 1/2. */
static void fill(float *values, const size_t size[3], size_t channels, const size_t low[3],
                 const size_t high[3], air_rng *rng)
{
    for (size_t k = low[2]; k <= high[2]; k++) {
        for (size_t j = low[1]; j <= high[1]; j++) {
            for (size_t i = low[0]; i <= high[0]; i++) {
                const size_t at = ((k * size[1] + j) * size[0] + i) * channels;
                values[at + (i + j + k) % channels] = 0.99f * air_rng_float(rng) + 0.005f;
            }
        }
    }
    for (int corner = 0; corner < 8; corner++) {
        const size_t i = (corner & 1) != 0 ? high[0] : low[0];
        const size_t j = (corner & 2) != 0 ? high[1] : low[1];
        const size_t k = (corner & 4) != 0 ? high[2] : low[2];
        values[((k * size[1] + j) * size[0] + i) * channels] = 0.75f;
    }
}

static void check_support(air_context *context, air_rng *rng, float above)
{
    size_t size[3], low[3], high[3], count = 1;
    const size_t channels = air_rng_float(rng) < 0.5f ? 1 : 3;
    for (int k = 0; k < 3; k++) {
        size[k] = 1 + (size_t)(30.0f * air_rng_float(rng));
        const size_t a = (size_t)((float)(int)size[k] * air_rng_float(rng));
        const size_t b = (size_t)((float)(int)size[k] * air_rng_float(rng));
        low[k] = a < b ? a : b;
        high[k] = a < b ? b : a;
        count *= size[k];
    }
    float *const values = calloc(count * channels, sizeof *values);
    float found_low[3], found_high[3];
    assert_non_null(values);
    fill(values, size, channels, low, high, rng);
    air_grid *const grid = make_grid(context, size, channels, values);
    assert_true(air_grid_support(grid, above, found_low, found_high));
    for (int k = 0; k < 3; k++) {
        const float least = low[k] == 0 ? -0.5f : (float)low[k] - 1.0f;
        const float most = high[k] + 1 == size[k] ? (float)size[k] - 0.5f : (float)high[k] + 1.0f;
        assert_true(found_low[k] == least);
        assert_true(found_high[k] == most);
    }
    for (int n = 0; n < 2000; n++) {
        float p[3];
        bool outside = false;
        for (int k = 0; k < 3; k++) {
            p[k] = (float)size[k] * (1.4f * air_rng_float(rng) - 0.2f);
            outside = outside || p[k] < found_low[k] || p[k] > found_high[k];
        }
        assert_true(!outside || vec3_max(air_grid_lookup(grid, vec3(p[0], p[1], p[2]))) <= above);
    }
    air_grid_destroy(grid);
    free(values);
}

/* All values within the box count at 0; at a half its corners still do. */
static void outside_the_support_no_lookup_is_above(void **state)
{
    air_rng rng = air_rng_from_keys(3, 41);
    for (int n = 0; n < 60; n++) {
        check_support(*state, &rng, n % 2 == 0 ? 0.0f : 0.5f);
    }
}

static void what_is_nowhere_above_has_no_support(void **state)
{
    const size_t size[3] = {9, 20, 11};
    float *const values = calloc(9 * 20 * 11, sizeof *values);
    float low[3] = {7.0f, 7.0f, 7.0f}, high[3] = {7.0f, 7.0f, 7.0f};
    assert_non_null(values);
    air_grid *grid = make_grid(*state, size, 1, values);
    assert_false(air_grid_support(grid, 0.0f, low, high));
    air_grid_destroy(grid);
    values[777] = 1.0f;
    grid = make_grid(*state, size, 1, values);
    assert_false(air_grid_support(grid, 1.0f, low, high));
    assert_true(low[0] == 7.0f && high[2] == 7.0f);
    assert_true(air_grid_support(grid, 0.999f, low, high));
    assert_true(low[0] == 777 % 9 - 1 && high[0] == 777 % 9 + 1);
    air_grid_destroy(grid);
    free(values);
}

/* Bricks that are all alike are stored once. */
static void uniform_grids_have_all_of_their_box(void **state)
{
    const size_t size[3] = {40, 17, 24};
    float *const values = calloc(40 * 17 * 24, sizeof *values);
    float low[3], high[3];
    assert_non_null(values);
    for (size_t i = 0; i < 40 * 17 * 24; i++) {
        values[i] = 2.0f;
    }
    air_grid *grid = make_grid(*state, size, 1, values);
    assert_true(air_grid_support(grid, 0.0f, low, high));
    for (int k = 0; k < 3; k++) {
        assert_true(low[k] == -0.5f && high[k] == (float)size[k] - 0.5f);
    }
    air_grid_destroy(grid);
    free(values);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(outside_the_support_no_lookup_is_above, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_nowhere_above_has_no_support, set_up, tear_down),
        cmocka_unit_test_setup_teardown(uniform_grids_have_all_of_their_box, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* A beam through a box of cells, by every instruction set of this machine. */
#include "airlight/ordinates_beam.h"
#include "core/random.h"
#include "core/vec.h"
#include "ordinates_levels.h"

enum { MOST = 21 * 20 * 23 * 4, ROUNDS = 60 };

/* Rows that end within a vector, single cells, and the shape of the interactive frame. */
static const size_t sizes[][3] = {{1, 1, 1}, {5, 1, 3},  {2, 7, 1},   {20, 20, 20},
                                  {3, 4, 6}, {9, 8, 17}, {21, 20, 23}};
enum { SIZES = sizeof sizes / sizeof sizes[0] };

static size_t fill(air_rng *rng, int round, air_beam_box *box, float *extinction, float dir[3])
{
    const float most = round % 3 == 0 ? 0.1f : round % 3 == 1 ? 3.0f : 40.0f;
    size_t count = 4;
    for (int axis = 0; axis < 3; axis++) {
        box->size[axis] = sizes[round % SIZES][axis];
        box->cell_m[axis] = 0.05f + 0.1f * air_rng_float(rng);
        count *= box->size[axis];
        dir[axis] = air_rng_float(rng) - 0.5f;
    }
    if (round % 4 == 0) { /* along an axis */
        const int w = round / 4 % 3;
        dir[(w + 1) % 3] = dir[(w + 2) % 3] = 0.0f;
    }
    for (size_t i = 0; i < count; i++) {
        extinction[i] = air_rng_float(rng) < 0.2f ? 0.0f : most * air_rng_float(rng);
    }
    for (size_t i = 0; i < count && round % 5 > 2; i += 4) { /* grey; the fourth is a mean */
        extinction[i + 1] = extinction[i + 2] = extinction[i];
        extinction[i + 3] = (extinction[i] + extinction[i + 1] + extinction[i + 2]) * (1.0f / 3.0f);
    }
    box->extinction = extinction;
    vec3_store(dir, vec3_normalize(vec3_load(dir)));
    return count;
}

/* Transmittances are within some roundings of optical depths, 6e-8 of at most 80 in each of some 20
 * layers, and so of themselves; where neighbours differ much, the mean over a cell is up to e^2
 * times that of its middle, by a factor that the same roundings enter. Small ones may differ by
 * what the difference of two transmittances does: 6e-8 / 0.05. */
static void every_instruction_set_does_what_plain_c_does(void **state)
{
    static float extinction[MOST], plain[MOST], lanes[MOST];
    levels all = levels_make();
    air_rng rng = air_rng_from_keys(1, 2);
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        air_beam_box box;
        float dir[3];
        const size_t count = fill(&rng, round, &box, extinction, dir);
        void *const scratch = malloc(air_beam_scratch(box.size));
        assert_non_null(scratch);
        air_beam_directional(NULL, &box, dir, scratch, plain);
        for (int level = 0; level < all.count; level++) {
            air_beam_directional(all.contexts[level], &box, dir, scratch, lanes);
            for (size_t i = 0; i < count; i++) {
                const double p = (double)plain[i], difference = fabs((double)lanes[i] - p);
                assert_true(isfinite(lanes[i]));
                worst = fmax(worst, difference / (p + 1e-3));
            }
        }
        free(scratch);
    }
    print_message("instruction sets: %.1e\n", worst);
    assert_true(worst < 1e-5);
    levels_finish(&all);
}

/* One cell that is not, wherever it lies. */
static void grey_boxes_with_a_coloured_cell_are_not_grey(void **state)
{
    static float extinction[MOST], plain[MOST], lanes[MOST];
    levels all = levels_make();
    const air_beam_box box = {{3, 3, 5}, {0.1f, 0.1f, 0.1f}, extinction};
    const float dir[3] = {0.0f, 0.6f, 0.8f};
    void *const scratch = malloc(air_beam_scratch(box.size));
    (void)state;
    assert_non_null(scratch);
    for (size_t odd = 0; odd < 45; odd++) {
        for (size_t i = 0; i < 180; i++) {
            extinction[i] = 1.0f + (i == odd * 4 + 1 ? 1e-3f : 0.0f);
        }
        air_beam_directional(NULL, &box, dir, scratch, plain);
        for (int level = 0; level < all.count; level++) {
            air_beam_directional(all.contexts[level], &box, dir, scratch, lanes);
            for (size_t i = 0; i < 180; i++) {
                assert_true(fabsf(lanes[i] - plain[i]) < 1e-6f);
            }
        }
    }
    free(scratch);
    levels_finish(&all);
}

/* Extinctions at which nothing is left, and squares of depths leave floats. */
static void what_is_opaque_stays_finite(void **state)
{
    static float extinction[MOST], out[MOST];
    air_context *const context = levels_context(AIR_CPU_AUTO);
    const air_beam_box box = {{5, 6, 7}, {1.0f, 1.0f, 1.0f}, extinction};
    void *const scratch = malloc(air_beam_scratch(box.size));
    const float dir[3] = {0.6f, 0.0f, 0.8f};
    (void)state;
    assert_non_null(scratch);
    for (size_t i = 0; i < 5 * 6 * 7 * 4; i++) {
        extinction[i] = i / 4 % 2 == 0 ? 1e9f : 0.0f;
    }
    air_beam_directional(context, &box, dir, scratch, out);
    for (size_t i = 0; i < 5 * 6 * 7 * 4; i++) {
        assert_true(out[i] >= 0.0f && out[i] <= 1.0f);
    }
    free(scratch);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_instruction_set_does_what_plain_c_does),
        cmocka_unit_test(grey_boxes_with_a_coloured_cell_are_not_grey),
        cmocka_unit_test(what_is_opaque_stays_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

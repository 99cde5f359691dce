/* Discrete ordinates by every instruction set of this machine and any number of threads. */
#include "ordinates_box.h"

/* Bands whose moments do not fill lanes, and directions of an octant that are 1 of a group of 4, 3,
 * 6 of 8, or full. */
static const struct {
    int bands, polar, azimuths;
} shapes[] = {{1, 2, 4},  {2, 2, 4},  {2, 2, 8},  {3, 4, 8},  {3, 6, 12},  {4, 4, 8},
              {5, 6, 12}, {5, 8, 16}, {6, 6, 12}, {7, 8, 16}, {10, 10, 20}};

enum { SHAPES = sizeof shapes / sizeof shapes[0] };

/* What there is after a few sweeps. */
typedef struct outcome {
    float *moments, *scattered;
    double change;
} outcome;

static outcome outcome_of(air_cpu cpu, const box *fog, int depth)
{
    outcome self;
    air_context *const context = box_context(cpu, 1);
    air_dom *const dom = box_make(context, fog);
    self.change = box_solve(dom, 4, 0.0, depth).change;
    self.moments = box_moments(dom, fog);
    self.scattered = box_moments(dom, fog);
    air_dom_scattered(dom, self.scattered);
    air_dom_destroy(dom);
    air_context_destroy(context);
    return self;
}

static void outcome_finish(outcome *self)
{
    free(self->moments);
    free(self->scattered);
}

/* The largest difference of any instruction set from plain C. */
static double difference_of_sets(const box *fog, int depth, int best)
{
    const size_t count = fog->cells * fog->moments * AIR_DOM_STRIDE;
    outcome plain = outcome_of(AIR_CPU_C, fog, depth);
    double worst = 0.0;
    for (int cpu = AIR_CPU_SSE42; cpu <= best; cpu++) {
        outcome lanes = outcome_of((air_cpu)cpu, fog, depth);
        worst = fmax(worst, box_difference(plain.moments, lanes.moments, count));
        worst = fmax(worst, box_difference(plain.scattered, lanes.scattered, count));
        assert_true(fabs(plain.change - lanes.change) < 1e-3 * plain.change);
        outcome_finish(&lanes);
    }
    outcome_finish(&plain);
    return worst;
}

/* Steps alone: roundings, 6e-8, of some tens of cells and of sums over up to 200 directions.
 * Diamonds that leave next to nothing become steps or do not by a rounding, which then changes one
 * direction of a cell by much: one such of some hundreds' moments. */
static void every_instruction_set_does_what_plain_c_does(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    const int best = (int)air_context_cpu(context);
    double worst[2] = {0.0};
    (void)state;
    for (int i = 0; i < 2 * SHAPES; i++) {
        const int diamond = (i + i / 2) % 2;
        box fog = box_random(shapes[i / 2].bands, shapes[i / 2].polar, shapes[i / 2].azimuths,
                             (uint32_t)i);
        fog.params.diamond = diamond == 1;
        for (size_t j = 0; j < 3 * fog.cells && i % 2 == 1; j++) {
            fog.g[j] = 0.8f; /* the same everywhere */
        }
        worst[diamond] = fmax(worst[diamond], difference_of_sets(&fog, i % 3, best));
        box_finish(&fog);
    }
    print_message("instruction sets: steps %.1e, diamonds %.1e\n", worst[0], worst[1]);
    assert_true(worst[0] < 3e-6);
    assert_true(worst[1] < 1e-3);
    air_context_destroy(context);
}

static void threads_give_the_same_bytes(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        box fog = box_random(i < 2 ? 4 : 5, i < 2 ? 4 : 6, i < 2 ? 8 : 12, (uint32_t)i);
        const size_t bytes = fog.cells * fog.moments * AIR_DOM_STRIDE * sizeof(float);
        float *moments[3];
        air_dom_report reports[3];
        for (size_t threads = 1; threads <= 3; threads++) {
            air_context *const context = box_context(i == 3 ? AIR_CPU_C : AIR_CPU_AUTO, threads);
            air_dom *const dom = box_make(context, &fog);
            reports[threads - 1] = box_solve(dom, 9, 0.0, i % 2 * 4);
            moments[threads - 1] = box_moments(dom, &fog);
            air_dom_destroy(dom);
            air_context_destroy(context);
        }
        for (int j = 1; j < 3; j++) {
            assert_memory_equal(moments[0], moments[j], bytes);
            assert_memory_equal(&reports[0].books, &reports[j].books, sizeof reports[0].books);
            assert_true(reports[0].change == reports[j].change);
        }
        for (int j = 0; j < 3; j++) {
            free(moments[j]);
        }
        box_finish(&fog);
    }
}

/* One cell; rows, columns and plates of one. */
static void thin_boxes_balance(void **state)
{
    (void)state;
    for (int i = 0; i < 16; i++) {
        air_context *const context = box_context(i < 8 ? AIR_CPU_C : AIR_CPU_AUTO, 2);
        box fog = box_random(4, 4, 8, (uint32_t)i);
        for (int axis = 0; axis < 3; axis++) {
            fog.params.size[axis] = (i >> axis & 1) != 0 ? 1 : fog.params.size[axis];
        }
        fog.cells = fog.params.size[0] * fog.params.size[1] * fog.params.size[2];
        air_dom *const dom = box_make(context, &fog);
        const air_dom_report report = box_solve(dom, 4, 0.0, 4);
        for (int c = 0; c < 3; c++) {
            assert_true(box_imbalance(&report.books[c]) < (i < 8 ? 1e-12 : 1e-5));
        }
        air_dom_destroy(dom);
        box_finish(&fog);
        air_context_destroy(context);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_instruction_set_does_what_plain_c_does),
        cmocka_unit_test(threads_give_the_same_bytes),
        cmocka_unit_test(thin_boxes_balance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Discrete ordinates: energy, furnaces, mirrors, sums, slabs, finer cells; how fast solves end. */
#include <string.h>

#include "core/vec.h"
#include "ordinates_box.h"

static air_context *doubles, *floats;

static int set_up(void **state)
{
    (void)state;
    doubles = box_context(AIR_CPU_C, 2);
    floats = box_context(AIR_CPU_AUTO, 2);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    air_context_destroy(doubles);
    air_context_destroy(floats);
    return 0;
}

static double worst_imbalance(const air_dom_report *report)
{
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        worst = fmax(worst, box_imbalance(&report->books[c]));
    }
    return worst;
}

/* However few the sweeps, accelerated or not, steps or diamonds. */
static void books_balance(void **state)
{
    static const int polar[3] = {4, 6, 10};
    double worst[2] = {0.0};
    (void)state;
    for (int i = 0; i < 48; i++) {
        const int bands = 1 + i % AIR_DOM_BANDS_MAX, nodes = polar[(bands > 4) + (bands > 6)];
        box fog = box_random(bands, nodes, bands > 6 ? 20 : 12, (uint32_t)i);
        fog.params.delta_m = i % 5 != 0;
        fog.params.diamond = i % 7 != 0;
        for (int j = 0; j < 2; j++) {
            air_dom *const dom = box_make(j == 0 ? doubles : floats, &fog);
            const uint32_t sweeps[4] = {1, 2, 3, 12};
            const air_dom_report report = box_solve(dom, sweeps[i % 4], 0.0, i % 3 * 4);
            worst[j] = fmax(worst[j], worst_imbalance(&report));
            air_dom_destroy(dom);
        }
        box_finish(&fog);
    }
    print_message("books: %.1e in doubles, %.1e in floats\n", worst[0], worst[1]);
    assert_true(worst[0] < 1e-12);
    assert_true(worst[1] < 1e-5);
}

/* Numbers of one size at every one of many faces' cells, which naive sums in floats lose. */
static void books_balance_on_large_faces(void **state)
{
    air_dom_params params;
    (void)state;
    air_dom_params_default(&params);
    params.size[0] = params.size[1] = 160;
    params.size[2] = 2;
    params.cell_m[0] = params.cell_m[1] = 100.0f;
    params.cell_m[2] = 1.0f;
    params.bands = 1;
    params.polar = 2;
    params.azimuths = 4;
    box fog = box_empty(&params);
    for (size_t i = 0; i < 3 * fog.cells; i++) {
        fog.sigma_s[i] = 0.01f;
    }
    fog.inflow[0] = fog.inflow[1] = fog.inflow[2] = 0.7f;
    fog.faces = 1u << 4;
    air_dom *const dom = box_make(floats, &fog);
    const air_dom_report report = box_solve(dom, 3, 0.0, 0);
    assert_true(worst_imbalance(&report) < 2e-6);
    air_dom_destroy(dom);
    box_finish(&fog);
}

/* Radiance 1 from everywhere, no absorption: radiance 1 everywhere, whatever the fog. */
static void a_white_furnace_is_white(void **state)
{
    (void)state;
    for (int i = 0; i < 6; i++) {
        const bool precise = i % 2 == 0;
        box fog = box_random(2 + i, 8, 16, (uint32_t)i);
        memset(fog.sigma_a, 0, 3 * fog.cells * sizeof *fog.sigma_a);
        memset(fog.light, 0, fog.cells * fog.moments * AIR_DOM_STRIDE * sizeof *fog.light);
        memset(fog.inflow, 0, sizeof fog.inflow);
        for (int c = 0; c < 3; c++) {
            fog.inflow[c] = (float)sqrt(4.0 * AIR_PI);
        }
        fog.faces = 63u;
        air_dom *const dom = box_make(precise ? doubles : floats, &fog);
        const air_dom_report report = box_solve(dom, 300, precise ? 1e-9 : 1e-6, 4);
        float *const moments = box_moments(dom, &fog);
        double worst = 0.0;
        for (size_t j = 0; j < fog.cells * fog.moments * AIR_DOM_STRIDE; j++) {
            const bool mean = j / AIR_DOM_STRIDE % fog.moments == 0 && j % AIR_DOM_STRIDE < 3;
            const double exact = mean ? sqrt(4.0 * AIR_PI) : 0.0;
            worst = fmax(worst, fabs((double)moments[j] - exact) / sqrt(4.0 * AIR_PI));
        }
        print_message("furnace, %d bands: %.1e after %u sweeps\n", 2 + i, worst, report.sweeps);
        /* A sweep changes what is left by a tenth at least in so thin a box: the error is up to ten
         * times the last change; results are floats, 6e-8. */
        assert_true(report.sweeps < 300);
        assert_true(worst < (precise ? 2e-7 : 2e-5));
        free(moments);
        air_dom_destroy(dom);
        box_finish(&fog);
    }
}

/* The cell that mirrors this one, and the sign of a moment. */
static size_t mirrored_cell(const box *fog, size_t cell, int mirror)
{
    const size_t *const n = fog->params.size;
    size_t at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
    for (int axis = 0; axis < 3; axis++) {
        at[axis] = (mirror >> axis & 1) != 0 ? n[axis] - 1 - at[axis] : at[axis];
    }
    return (at[2] * n[1] + at[1]) * n[0] + at[0];
}

/* +-1 by comparing y_lm in a direction and its mirror image. */
static void mirror_signs(int bands, int mirror, float signs[AIR_SH_COUNT_MAX])
{
    double dir[3] = {0.4, 0.5, 0.6}, y[AIR_SH_COUNT_MAX], mirrored[AIR_SH_COUNT_MAX];
    normalise(dir);
    air_sh_evaluate(bands, dir, y);
    for (int axis = 0; axis < 3; axis++) {
        dir[axis] *= (mirror >> axis & 1) != 0 ? -1.0 : 1.0;
    }
    air_sh_evaluate(bands, dir, mirrored);
    for (int i = 0; i < bands * bands; i++) {
        signs[i] = y[i] * mirrored[i] > 0.0 ? 1.0f : -1.0f;
    }
}

static void mirror_moments(const box *fog, const float *from, int mirror, float *to)
{
    float signs[AIR_SH_COUNT_MAX];
    const size_t stride = fog->moments * AIR_DOM_STRIDE;
    mirror_signs(fog->params.bands, mirror, signs);
    for (size_t i = 0; i < fog->cells * stride; i++) {
        const size_t other = mirrored_cell(fog, i / stride, mirror);
        to[other * stride + i % stride] = signs[i % stride / AIR_DOM_STRIDE] * from[i];
    }
}

static box mirror_box(const box *fog, int mirror)
{
    box self = box_empty(&fog->params);
    float signs[AIR_SH_COUNT_MAX];
    for (size_t i = 0; i < 3 * fog->cells; i++) {
        const size_t to = i / fog->cells * fog->cells + mirrored_cell(fog, i % fog->cells, mirror);
        self.sigma_s[to] = fog->sigma_s[i];
        self.sigma_a[to] = fog->sigma_a[i];
        self.g[to] = fog->g[i];
    }
    mirror_moments(fog, fog->light, mirror, self.light);
    mirror_signs(fog->params.bands, mirror, signs);
    for (size_t i = 0; i < fog->moments * AIR_DOM_STRIDE; i++) {
        self.inflow[i] = signs[i / AIR_DOM_STRIDE] * fog->inflow[i];
    }
    for (int face = 0; face < 6; face++) {
        const int to = (mirror >> face / 2 & 1) != 0 ? face ^ 1 : face;
        self.faces |= (fog->faces >> face & 1u) << to;
    }
    return self;
}

/* To the last bit but where sources below 0 are cut, whose scale is a sum over directions in
 * another order; there to rounding. */
static void mirrored_boxes_have_mirrored_solutions(void **state)
{
    (void)state;
    for (int mirror = 1; mirror < 8; mirror++) {
        const bool mild = mirror % 2 == 0;
        box fog = box_random(mild ? 2 : 5, 6, 12, (uint32_t)mirror);
        const size_t count = fog.cells * fog.moments * AIR_DOM_STRIDE;
        for (size_t i = 0; i < 3 * fog.cells && mild; i++) {
            fog.g[i] = 0.3f; /* light of one direction is sent as 1 + 0.7 mu */
        }
        box other = mirror_box(&fog, mirror);
        air_dom *const a = box_make(floats, &fog), *const b = box_make(floats, &other);
        (void)box_solve(a, 6, 0.0, 0);
        (void)box_solve(b, 6, 0.0, 0);
        float *const found = box_moments(b, &other), *const moments = box_moments(a, &fog);
        float *const expected = box_numbers(count);
        mirror_moments(&fog, moments, mirror, expected);
        const double difference = box_difference(expected, found, count);
        assert_true(mild ? difference == 0.0 : difference < 1e-5);
        free(found);
        free(moments);
        free(expected);
        air_dom_destroy(a);
        air_dom_destroy(b);
        box_finish(&fog);
        box_finish(&other);
    }
}

static void scale_light(box *fog, float factor)
{
    for (size_t i = 0; i < fog->cells * fog->moments * AIR_DOM_STRIDE; i++) {
        fog->light[i] *= factor;
    }
    for (size_t i = 0; i < fog->moments * AIR_DOM_STRIDE; i++) {
        fog->inflow[i] *= factor;
    }
}

/* To the last bit, accelerated too: everything scales, and twice is exact. */
static void twice_the_light_gives_twice_the_solution(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        box fog = box_random(4 + i % 2, 6, 12, (uint32_t)i);
        const size_t count = fog.cells * fog.moments * AIR_DOM_STRIDE;
        air_dom *const dom = box_make(i < 2 ? doubles : floats, &fog);
        air_dom_solve_params params = box_solve_params(9, 0.0, 4);
        params.cold = true;
        assert_int_equal(air_dom_solve(dom, &params, NULL), AIR_OK);
        float *const once = box_moments(dom, &fog);
        scale_light(&fog, 2.0f);
        assert_int_equal(air_dom_set_light(dom, fog.light), AIR_OK);
        assert_int_equal(air_dom_set_inflow(dom, fog.inflow, fog.faces), AIR_OK);
        assert_int_equal(air_dom_solve(dom, &params, NULL), AIR_OK);
        float *const twice = box_moments(dom, &fog);
        for (size_t j = 0; j < count; j++) {
            assert_true(twice[j] == 2.0f * once[j]);
        }
        free(once);
        free(twice);
        air_dom_destroy(dom);
        box_finish(&fog);
    }
}

/* Sources and radiances are positive in this one, so that nothing is cut, and steps only are taken:
 * then the solution is linear, to 50 sweeps' roundings. */
static void solutions_add_up(void **state)
{
    box fog = box_random(2, 4, 8, 5);
    const size_t count = fog.cells * fog.moments * AIR_DOM_STRIDE;
    float *moments[3], *const light = fog.light;
    (void)state;
    fog.params.diamond = false;
    for (size_t i = 0; i < 3 * fog.cells; i++) {
        fog.g[i] = 0.3f;
    }
    for (int part = 0; part < 3; part++) { /* some cells' light, that of the others, all */
        fog.light = box_numbers(count);
        for (size_t i = 0; i < count; i++) {
            const int odd = (int)(i / AIR_DOM_STRIDE / fog.moments % 2);
            fog.light[i] = part == 2 || part == odd ? light[i] : 0.0f;
        }
        fog.faces = part == 0 ? 1u << 0 : part == 1 ? 1u << 3 : 1u << 0 | 1u << 3;
        air_dom *const dom = box_make(doubles, &fog);
        (void)box_solve(dom, 100, 1e-9, 4);
        moments[part] = box_moments(dom, &fog);
        air_dom_destroy(dom);
        free(fog.light);
    }
    for (size_t i = 0; i < count; i++) {
        moments[0][i] += moments[1][i];
    }
    assert_true(box_difference(moments[2], moments[0], count) < 3e-7);
    for (int part = 0; part < 3; part++) {
        free(moments[part]);
    }
    fog.light = light;
    box_finish(&fog);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(books_balance),
        cmocka_unit_test(books_balance_on_large_faces),
        cmocka_unit_test(a_white_furnace_is_white),
        cmocka_unit_test(mirrored_boxes_have_mirrored_solutions),
        cmocka_unit_test(twice_the_light_gives_twice_the_solution),
        cmocka_unit_test(solutions_add_up),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

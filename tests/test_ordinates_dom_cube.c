/* Discrete ordinates in the public cube: against photons that were counted, and beside what solvers
 * in harmonics alone make of it. */
#include "ordinates_box.h"
#include "ordinates_cube.h"

static cube_truth truth;
static bool have_truth;
static air_context *context;

static int set_up(void **state)
{
    (void)state;
    have_truth = cube_read(&truth);
    context = box_context(AIR_CPU_AUTO, 2);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    air_context_destroy(context);
    return 0;
}

/* Solves and tells. */
static cube_score solve_and_score(const char *name, const air_dom_params *params, uint32_t sweeps,
                                  double change, int depth)
{
    air_dom *const dom = cube_make(context, params);
    const air_dom_report report = box_solve(dom, sweeps, change, depth);
    const cube_score score = cube_score_of(&truth, params, dom, &report, 1.0);
    print_message("%s%2d bands, %2d x %2d, %2u sweeps: fluence %.4f, flux %.4f, angles %.4f, "
                  "radiance %.4f, exits %.4f\n",
                  name, params->bands, params->polar, params->azimuths, report.sweeps,
                  score.fluence, score.flux, score.angles, score.radiance, score.exits);
    air_dom_destroy(dom);
    return score;
}

/* Known of another solver: 0.0081 and 0.0051. The photons' own noise is 0.0025. */
static void five_bands_are_within_a_percent(void **state)
{
    const air_dom_params params = cube_params(CUBE_N, 5, 8, 16);
    (void)state;
    if (!have_truth) {
        skip();
    }
    const cube_score score = solve_and_score("", &params, 64, 1e-4, 4);
    assert_true(score.fluence <= 0.012);
    assert_true(score.flux <= 0.008);
    assert_true(score.exits <= 0.02); /* 0.014 */
}

/* Known: 0.017 and, with two bands, 0.047. */
static void few_sweeps_of_four_bands_are_close(void **state)
{
    const air_dom_params four = cube_params(CUBE_N, 4, 4, 8), two = cube_params(CUBE_N, 2, 2, 4);
    (void)state;
    if (!have_truth) {
        skip();
    }
    assert_true(solve_and_score("", &four, 8, 0.0, 0).fluence <= 0.025);
    assert_true(solve_and_score("", &two, 8, 0.0, 0).fluence <= 0.06);
}

/* Known: total variation 0.118, 0.033, 0.023, 0.0054. A tenth of slack. */
static void angles_get_finer_with_bands(void **state)
{
    static const struct {
        int bands, polar, azimuths;
        double angles;
    } rows[4] = {{2, 4, 8, 0.118}, {4, 8, 16, 0.033}, {5, 8, 16, 0.023}, {10, 12, 24, 0.0054}};
    double last = 1.0;
    (void)state;
    if (!have_truth) {
        skip();
    }
    for (int i = 0; i < 4; i++) {
        const air_dom_params params =
            cube_params(CUBE_N, rows[i].bands, rows[i].polar, rows[i].azimuths);
        const cube_score score = solve_and_score("", &params, 64, 1e-4, 4);
        assert_true(score.angles < 1.1 * rows[i].angles);
        assert_true(score.angles > 0.9 * rows[i].angles);
        assert_true(score.radiance < last);
        assert_true(rows[i].bands < 10 || score.exits <= 0.01);
        last = score.radiance;
    }
}

/* Known: 0.0124 without delta-M (another solver; ours: 0.0143), 0.046 with steps. */
static void each_part_of_the_method_helps(void **state)
{
    air_dom_params params = cube_params(CUBE_N, 5, 8, 16);
    (void)state;
    if (!have_truth) {
        skip();
    }
    const double all = solve_and_score("", &params, 64, 1e-4, 4).fluence;
    params.delta_m = false;
    const double without = solve_and_score("no delta-M, ", &params, 64, 1e-4, 4).fluence;
    params.delta_m = true;
    params.diamond = false;
    const double steps = solve_and_score("steps, ", &params, 64, 1e-4, 4).fluence;
    assert_true(all < without && without < steps);
    assert_true(fabs(without - 0.0124) < 0.004);
    assert_true(fabs(steps - 0.046) < 0.005);
}

/* The beam in harmonics, from the face it enters: clearly worse, 0.27 with five bands and 0.10 with
 * ten. Of the window's wide lobe a part misses the face, and what is below 0 is not sent: 0.92 and
 * 1.03 come in. */
static void harmonics_alone_are_worse(void **state)
{
    static const double along_z[3] = {0.0, 0.0, 1.0}, one[3] = {1.0, 1.0, 1.0};
    float inflow[AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX * AIR_DOM_STRIDE];
    (void)state;
    if (!have_truth) {
        skip();
    }
    for (int bands = 5; bands <= 10; bands += 5) {
        air_dom_params params = cube_params(CUBE_N, bands, 2, 4);
        air_dom *dom;
        air_dom_params_shdom(&params, bands);
        assert_int_equal(air_dom_create(context, &params, &dom), AIR_OK);
        cube_set_medium(dom, &params, cube_sigma_s);
        air_dom_hanning_beam(bands, along_z, one, 1.0, inflow);
        assert_int_equal(air_dom_set_inflow(dom, inflow, 1u << 4), AIR_OK);
        const air_dom_report report = box_solve(dom, 64, 1e-4, 4);
        const cube_score score = cube_score_of(&truth, &params, dom, &report, 0.0);
        print_message("harmonics alone, %d bands: in %.3f, fluence %.3f, flux %.3f, angles %.3f\n",
                      bands, report.books[0].in, score.fluence, score.flux, score.angles);
        assert_true(score.fluence > 0.05 && score.fluence < 1.0);
        assert_true(score.angles > 0.05);
        assert_true(box_imbalance(&report.books[0]) < 1e-5);
        air_dom_destroy(dom);
    }
}

/* Doubles and floats agree, to the changes at which they stop. */
static void doubles_are_the_same(void **state)
{
    const air_dom_params params = cube_params(CUBE_N, 4, 4, 8);
    air_context *const plain = box_context(AIR_CPU_C, 2);
    air_dom *const a = cube_make(plain, &params), *const b = cube_make(context, &params);
    const size_t count = cube_cells(&params) * 16 * AIR_DOM_STRIDE;
    (void)state;
    (void)box_solve(a, 8, 0.0, 0);
    (void)box_solve(b, 8, 0.0, 0);
    float *const in_doubles = cube_moments(a, &params), *const in_floats = cube_moments(b, &params);
    /* 16 cells' roundings of 1e-7, eight times */
    assert_true(box_difference(in_doubles, in_floats, count) < 1e-5);
    free(in_doubles);
    free(in_floats);
    air_dom_destroy(a);
    air_dom_destroy(b);
    air_context_destroy(plain);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(five_bands_are_within_a_percent),
        cmocka_unit_test(few_sweeps_of_four_bands_are_close),
        cmocka_unit_test(angles_get_finer_with_bands),
        cmocka_unit_test(each_part_of_the_method_helps),
        cmocka_unit_test(harmonics_alone_are_worse),
        cmocka_unit_test(doubles_are_the_same),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

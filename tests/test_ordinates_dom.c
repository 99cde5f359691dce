/* The discrete-ordinates solver's directions, classes, memory, and what it refuses. */
#include <limits.h>
#include <string.h>

#include "core/vec.h"
#include "memory_shortage.h"
#include "ordinates/dom.h"
#include "ordinates_box.h"

static int class_by_mirroring(int l, int m)
{
    int class = 0;
    for (int axis = 0; axis < 3; axis++) {
        double dir[3] = {0.31, 0.52, 0.43}, y[AIR_SH_COUNT_MAX], mirrored[AIR_SH_COUNT_MAX];
        normalise(dir);
        air_sh_evaluate(AIR_DOM_BANDS_MAX, dir, y);
        dir[axis] = -dir[axis];
        air_sh_evaluate(AIR_DOM_BANDS_MAX, dir, mirrored);
        class |= y[l * l + l + m] * mirrored[l * l + l + m] < 0.0 ? 1 << axis : 0;
    }
    return class;
}

static void classes_are_what_mirroring_does(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    (void)state;
    for (int bands = 1; bands <= AIR_DOM_BANDS_MAX; bands++) {
        int counts[DOM_OCTANTS] = {0}, begin = 0;
        air_dom_params params;
        air_dom *dom;
        air_dom_params_default(&params);
        for (int axis = 0; axis < 3; axis++) {
            params.size[axis] = 1;
            params.cell_m[axis] = 1.0f;
        }
        params.bands = bands;
        params.polar = 10;
        params.azimuths = 20;
        assert_int_equal(air_dom_create(context, &params, &dom), AIR_OK);
        for (int i = 0; i < dom->moments; i++) {
            const int l = dom->band_of[i], m = dom->order[i] - l * l - l;
            assert_int_equal(dom->class_of[i], class_by_mirroring(l, m));
            counts[dom->class_of[i]]++;
        }
        for (int class = 0; class < DOM_OCTANTS; class ++) {
            assert_int_equal(dom_class_begin[bands][class], begin);
            begin += counts[class];
        }
        assert_int_equal(dom_class_begin[bands][DOM_OCTANTS], begin);
        assert_int_equal(begin, bands * bands);
        air_dom_destroy(dom);
    }
    air_context_destroy(context);
}

/* The integral of two of the bands' harmonics by the solver's rule. */
static double product_of(const air_dom *dom, int a, int b)
{
    double sum = 0.0, y[AIR_SH_COUNT_MAX], dir[3];
    for (int octant = 0; octant < DOM_OCTANTS; octant++) {
        for (int o = 0; o < dom->directions; o++) {
            for (int axis = 0; axis < 3; axis++) {
                dir[axis] = (octant >> axis & 1) != 0 ? -dom->dir[axis][o] : dom->dir[axis][o];
            }
            air_sh_evaluate(dom->params.bands, dir, y);
            sum += dom->weight[o] * y[a] * y[b];
        }
    }
    return sum;
}

/* With the fewest directions that are allowed; of many pairs every seventh. */
static void directions_keep_harmonics_apart(void **state)
{
    air_context *const context = box_context(AIR_CPU_C, 1);
    (void)state;
    for (int bands = 1; bands <= AIR_DOM_BANDS_MAX; bands++) {
        box fog = box_random(bands, bands + bands % 2, (2 * bands + 3) / 4 * 4, 1);
        air_dom *const dom = box_make(context, &fog);
        const int count = bands * bands;
        for (int i = 0; i<count * count; i += bands> 4 ? 7 : 1) {
            const double exact = i / count == i % count ? 1.0 : 0.0;
            assert_true(fabs(product_of(dom, i / count, i % count) - exact) < 1e-12);
        }
        air_dom_destroy(dom);
        box_finish(&fog);
    }
    air_context_destroy(context);
}

static void the_peak_is_the_last_mean(void **state)
{
    air_dom_params params;
    (void)state;
    air_dom_params_default(&params);
    assert_true(air_dom_peak(&params, 0.25) == 0.25);
    assert_true(air_dom_peak(&params, -0.25) == 0.0);
    params.delta_m = false;
    assert_true(air_dom_peak(&params, 0.25) == 0.0);
}

/* ---- what is refused ---- */

typedef struct wrong_params {
    air_dom_params params;
    const char *named; /* in the message */
} wrong_params;

static void wrong_params_are_named(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    wrong_params wrong[11];
    (void)state;
    for (int i = 0; i < 11; i++) {
        box fog = box_random(4, 4, 8, 1);
        wrong[i] = (wrong_params){fog.params, "directions"};
        box_finish(&fog);
    }
    wrong[0].params.size[1] = 0, wrong[0].named = "along y";
    wrong[1].params.size[2] = AIR_DOM_SIZE_MAX + 1, wrong[1].named = "along z";
    wrong[2].params.cell_m[0] = NAN, wrong[2].named = "along x";
    wrong[3].params.cell_m[0] = 0.0f, wrong[3].named = "along x";
    wrong[4].params.bands = 0, wrong[4].named = "0 bands";
    wrong[5].params.bands = 11, wrong[5].named = "11 bands";
    wrong[6].params.polar = 5;
    wrong[7].params.polar = 2;
    wrong[8].params.azimuths = 10;
    wrong[9].params.azimuths = 4;
    wrong[10].params.polar = AIR_DOM_POLAR_MAX + 2;
    for (int i = 0; i < 11; i++) {
        air_dom *dom;
        assert_int_equal(air_dom_create(context, &wrong[i].params, &dom), AIR_ERROR_ARGUMENT);
        assert_null(dom);
        assert_non_null(strstr(air_context_last_error(context), wrong[i].named));
    }
    air_dom_destroy(NULL);
    air_context_destroy(context);
}

/* The solution after one more sweep: what is set shows in it. */
static float *after_a_sweep(air_dom *dom, const box *fog)
{
    air_dom_solve_params params = box_solve_params(3, 0.0, 0);
    params.cold = true;
    assert_int_equal(air_dom_solve(dom, &params, NULL), AIR_OK);
    return box_moments(dom, fog);
}

static void assert_refused(air_context *context, air_status status, const char *named)
{
    assert_int_equal(status, AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), named));
}

static void refuse_media(air_context *context, air_dom *dom, const box *fog)
{
    const air_dom_phase hg = {.g = fog->g};
    air_dom_phase means = {.legendre = {0.5, 0.3, 0.2, 0.1}};
    float *const sigma_s = fog->sigma_s, *const sigma_a = fog->sigma_a;
    const float s = sigma_s[7], a = sigma_a[2 * fog->cells + 3], g = fog->g[fog->cells];
    sigma_s[7] = -1.0f;
    assert_refused(context, air_dom_set_medium(dom, sigma_s, sigma_a, &hg), "cell 7, channel 0");
    sigma_s[7] = INFINITY;
    assert_refused(context, air_dom_set_medium(dom, sigma_s, sigma_a, &hg), "cell 7, channel 0");
    sigma_s[7] = s;
    sigma_a[2 * fog->cells + 3] = NAN;
    assert_refused(context, air_dom_set_medium(dom, sigma_s, sigma_a, &hg), "cell 3, channel 2");
    sigma_a[2 * fog->cells + 3] = a;
    fog->g[fog->cells] = 1.0f;
    assert_refused(context, air_dom_set_medium(dom, sigma_s, sigma_a, &hg), "cell 0, channel 1");
    fog->g[fog->cells] = g;
    means.legendre[1] = -1.1;
    assert_refused(context, air_dom_set_medium(dom, sigma_s, sigma_a, &means), "P_2");
    means.legendre[1] = 0.3;
    means.legendre[3] = 1.0; /* all of it peak */
    assert_refused(context, air_dom_set_medium(dom, sigma_s, sigma_a, &means), "P_4");
}

static void refuse_light(air_context *context, air_dom *dom, box *fog)
{
    const size_t at = (12 * fog->moments + 5) * AIR_DOM_STRIDE + 1;
    const float light = fog->light[at], inflow = fog->inflow[0];
    fog->light[at] = INFINITY;
    assert_refused(context, air_dom_set_light(dom, fog->light), "cell 12, moment 5, channel 1");
    fog->light[at] = light;
    fog->light[0] = -fog->light[0];
    assert_refused(context, air_dom_set_light(dom, fog->light), "cell 0, moment 0, channel 0");
    fog->light[0] = -fog->light[0];
    fog->inflow[0] = NAN;
    assert_refused(context, air_dom_set_inflow(dom, fog->inflow, 1), "inflow");
    fog->inflow[0] = inflow;
    assert_refused(context, air_dom_set_inflow(dom, fog->inflow, 64), "faces 64");
}

static void what_is_refused_changes_nothing(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    box fog = box_random(4, 4, 8, 3);
    air_dom *const dom = box_make(context, &fog);
    air_dom_solve_params params = box_solve_params(0, 0.1, 1);
    (void)state;
    float *const before = after_a_sweep(dom, &fog);
    refuse_media(context, dom, &fog);
    refuse_light(context, dom, &fog);
    assert_refused(context, air_dom_solve(dom, &params, NULL), "0 sweeps");
    params = box_solve_params(1, NAN, 1);
    assert_refused(context, air_dom_solve(dom, &params, NULL), "change");
    params = box_solve_params(1, 0.1, AIR_DOM_DEPTH_MAX + 1);
    assert_refused(context, air_dom_solve(dom, &params, NULL), "depth 9");
    float *const after = after_a_sweep(dom, &fog);
    assert_memory_equal(before, after, fog.cells * fog.moments * AIR_DOM_STRIDE * sizeof(float));
    free(before);
    free(after);
    air_dom_destroy(dom);
    box_finish(&fog);
    air_context_destroy(context);
}

/* ---- what is set ---- */

static void a_solution_goes_on_from_the_moments_it_had(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    box fog = box_random(4, 4, 8, 4);
    const size_t bytes = fog.cells * fog.moments * AIR_DOM_STRIDE * sizeof(float);
    air_dom *const one = box_make(context, &fog), *const other = box_make(context, &fog);
    (void)state;
    (void)box_solve(one, 5, 0.0, 0);
    float *const middle = box_moments(one, &fog);
    (void)box_solve(one, 2, 0.0, 0);
    assert_int_equal(air_dom_set_moments(other, middle), AIR_OK);
    (void)box_solve(other, 2, 0.0, 0);
    float *const ends[2] = {box_moments(one, &fog), box_moments(other, &fog)};
    assert_memory_equal(ends[0], ends[1], bytes);
    middle[0] = -1.0f;
    assert_refused(context, air_dom_set_moments(other, middle), "solution: cell 0, moment 0");
    assert_int_equal(air_dom_set_moments(other, NULL), AIR_OK);
    air_dom_moments(other, middle);
    memset(ends[0], 0, bytes);
    assert_memory_equal(middle, ends[0], bytes);
    free(middle);
    free(ends[0]);
    free(ends[1]);
    air_dom_destroy(one);
    air_dom_destroy(other);
    box_finish(&fog);
    air_context_destroy(context);
}

static void a_medium_keeps_the_solution(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    box fog = box_random(4, 4, 8, 4);
    const size_t bytes = fog.cells * fog.moments * AIR_DOM_STRIDE * sizeof(float);
    air_dom *const dom = box_make(context, &fog);
    const air_dom_phase phase = {.g = fog.g};
    (void)state;
    (void)box_solve(dom, 5, 0.0, 2);
    float *const before = box_moments(dom, &fog);
    for (size_t i = 0; i < 3 * fog.cells; i++) {
        fog.sigma_s[i] *= 2.0f;
    }
    assert_int_equal(air_dom_set_medium(dom, fog.sigma_s, fog.sigma_a, &phase), AIR_OK);
    float *const after = box_moments(dom, &fog);
    assert_memory_equal(before, after, bytes);
    free(before);
    free(after);
    air_dom_destroy(dom);
    box_finish(&fog);
    air_context_destroy(context);
}

/* Means of P_l = g^l given as such, and g in every cell. */
static void legendre_means_are_as_good_as_g(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    box fog = box_random(5, 6, 12, 6);
    const size_t count = fog.cells * fog.moments * AIR_DOM_STRIDE;
    air_dom_phase means = {.g = NULL};
    (void)state;
    for (size_t i = 0; i < 3 * fog.cells; i++) {
        fog.g[i] = 0.5f;
    }
    for (int l = 1; l <= 5; l++) {
        means.legendre[l - 1] = pow(0.5, l);
    }
    air_dom *const dom = box_make(context, &fog);
    float *const moments = after_a_sweep(dom, &fog), *const scattered = box_numbers(count);
    air_dom_scattered(dom, scattered);
    for (size_t i = 0; i < count; i++) {
        const int l = (int)sqrt((double)(i / AIR_DOM_STRIDE % fog.moments));
        const double exact = (pow(0.5, l) - pow(0.5, 5)) * (double)moments[i];
        assert_true(fabs((double)scattered[i] - exact) <= 1e-6 * fabs(exact));
    }
    assert_int_equal(air_dom_set_medium(dom, fog.sigma_s, fog.sigma_a, &means), AIR_OK);
    float *const again = after_a_sweep(dom, &fog);
    assert_true(box_difference(moments, again, count) == 0.0);
    free(moments);
    free(again);
    free(scattered);
    air_dom_destroy(dom);
    box_finish(&fog);
    air_context_destroy(context);
}

/* NULL light and NULL inflow are none, and no light gives none. */
static void no_light_gives_none(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    box fog = box_random(4, 4, 8, 9);
    air_dom *const dom = box_make(context, &fog);
    (void)state;
    assert_int_equal(air_dom_set_light(dom, NULL), AIR_OK);
    assert_int_equal(air_dom_set_inflow(dom, NULL, 63), AIR_OK);
    assert_int_equal(box_solve(dom, 20, 1e-3, 4).sweeps, 1);
    float *const moments = box_moments(dom, &fog);
    for (size_t i = 0; i < fog.cells * fog.moments * AIR_DOM_STRIDE; i++) {
        assert_true(moments[i] == 0.0f);
    }
    free(moments);
    air_dom_destroy(dom);
    box_finish(&fog);
    air_context_destroy(context);
}

/* ---- the weak baseline ---- */

static void harmonics_alone_take_the_fewest_directions(void **state)
{
    air_context *const context = box_context(AIR_CPU_AUTO, 1);
    (void)state;
    for (int bands = 1; bands <= AIR_DOM_BANDS_MAX; bands++) {
        box fog = box_random(1, 2, 4, 1);
        air_dom *dom;
        air_dom_params_shdom(&fog.params, bands);
        assert_false(fog.params.delta_m || fog.params.diamond);
        assert_int_equal(air_dom_create(context, &fog.params, &dom), AIR_OK);
        air_dom_destroy(dom);
        fog.params.azimuths -= 4;
        assert_int_equal(air_dom_create(context, &fog.params, &dom), AIR_ERROR_ARGUMENT);
        fog.params.azimuths += 4;
        fog.params.polar -= 2;
        assert_int_equal(air_dom_create(context, &fog.params, &dom), AIR_ERROR_ARGUMENT);
        box_finish(&fog);
    }
    air_context_destroy(context);
}

/* Its fluence is the irradiance; band l is y_lm times window and lobe^l. */
static void a_hanning_beam_is_a_windowed_dirac(void **state)
{
    static const double irradiance[3] = {1.0, 2.0, 0.5};
    double dir[3] = {0.3, -0.4, 0.8}, y[AIR_SH_COUNT_MAX];
    float moments[25 * AIR_DOM_STRIDE];
    (void)state;
    normalise(dir);
    air_sh_evaluate(5, dir, y);
    air_dom_hanning_beam(5, dir, irradiance, 0.9, moments);
    for (int l = 0; l < 5; l++) {
        const double window = pow(cos(0.5 * AIR_PI * l / 5.0), 2.0) * pow(0.9, l);
        for (int i = l * l; i < (l + 1) * (l + 1); i++) {
            for (int c = 0; c < 3; c++) {
                assert_true(fabs((double)moments[i * AIR_DOM_STRIDE + c] -
                                 irradiance[c] * window * y[i]) < 1e-6);
            }
            assert_true(moments[i * AIR_DOM_STRIDE + 3] == 0.0f);
        }
    }
    assert_true(fabs(sqrt(4.0 * AIR_PI) * (double)moments[1] - 2.0) < 1e-6);
}

/* ---- memory ---- */

static air_status create_and_solve(air_context *context, void *user)
{
    const box *const fog = user;
    const air_dom_phase phase = {.g = fog->g};
    const air_dom_solve_params params = box_solve_params(3, 0.0, 4);
    air_dom *dom;
    air_status status = air_dom_create(context, &fog->params, &dom);
    if (status == AIR_OK) {
        assert_int_equal(air_dom_set_medium(dom, fog->sigma_s, fog->sigma_a, &phase), AIR_OK);
        assert_int_equal(air_dom_set_light(dom, fog->light), AIR_OK);
        status = air_dom_solve(dom, &params, NULL);
    }
    air_dom_destroy(dom);
    return status;
}

static void lack_of_memory_leaves_nothing(void **state)
{
    box fog = box_random(3, 4, 8, 1);
    (void)state;
    assert_shortage_survived(create_and_solve, &fog, 60);
    box_finish(&fog);
}

/* Whichever allocation of a solve fails, the solution stays, and the solver works when there is
 * memory again. */
static void a_solve_without_memory_can_be_repeated(void **state)
{
    failing_allocator allocator;
    air_context_params context_params = failing_params(&allocator, LONG_MAX);
    air_context *context;
    box fog = box_random(3, 4, 8, 2);
    const size_t bytes = fog.cells * fog.moments * AIR_DOM_STRIDE * sizeof(float);
    const air_dom_solve_params params = box_solve_params(6, 0.0, AIR_DOM_DEPTH_MAX);
    (void)state;
    context_params.thread_count = 1;
    assert_int_equal(air_context_create(&context_params, &context), AIR_OK);
    air_dom *const dom = box_make(context, &fog), *const other = box_make(context, &fog);
    (void)box_solve(dom, 1, 0.0, 0);
    (void)box_solve(other, 1, 0.0, 0);
    float *const before = box_moments(dom, &fog);
    for (int attempt = 0; attempt < 100; attempt++) { /* one more array each time, and none lost */
        atomic_store(&allocator.remaining, attempt % 2);
        const air_status status = air_dom_solve(dom, &params, NULL);
        if (status == AIR_OK) {
            break;
        }
        assert_int_equal(status, AIR_ERROR_MEMORY);
        float *const after = box_moments(dom, &fog);
        assert_memory_equal(before, after, bytes);
        free(after);
    }
    atomic_store(&allocator.remaining, LONG_MAX);
    assert_int_equal(air_dom_solve(other, &params, NULL), AIR_OK);
    float *const found = box_moments(dom, &fog), *const expected = box_moments(other, &fog);
    assert_memory_equal(expected, found, bytes);
    free(before);
    free(found);
    free(expected);
    air_dom_destroy(dom);
    air_dom_destroy(other);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
    box_finish(&fog);
}

typedef struct counting {
    size_t bytes;
} counting;

static void *count_bytes(void *user, void *pointer, size_t size)
{
    counting *const self = user;
    self->bytes += size;
    if (size == 0) {
        free(pointer);
        return NULL;
    }
    return realloc(pointer, size);
}

static void bytes_are_as_announced(void **state)
{
    counting count = {0};
    air_context_params params;
    air_context *context;
    box fog = box_random(5, 6, 12, 2);
    (void)state;
    fog.params.size[0] = fog.params.size[1] = fog.params.size[2] = 20;
    air_context_params_default(&params);
    params.reallocate = count_bytes;
    params.allocate_user = &count;
    params.cpu = AIR_CPU_AUTO;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    if (air_context_cpu(context) != AIR_CPU_C) {
        air_dom *dom;
        count.bytes = 0;
        assert_int_equal(air_dom_create(context, &fog.params, &dom), AIR_OK);
        const size_t announced = air_dom_bytes(&fog.params, 0);
        assert_true(fabs((double)count.bytes - (double)announced) < 0.01 * (double)announced);
        (void)box_solve(dom, 2, 0.0, 3);
        const size_t more = air_dom_bytes(&fog.params, 3);
        assert_true(fabs((double)count.bytes - (double)more) < 0.01 * (double)more);
        air_dom_destroy(dom);
    }
    air_context_destroy(context);
    box_finish(&fog);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(classes_are_what_mirroring_does),
        cmocka_unit_test(directions_keep_harmonics_apart),
        cmocka_unit_test(the_peak_is_the_last_mean),
        cmocka_unit_test(wrong_params_are_named),
        cmocka_unit_test(what_is_refused_changes_nothing),
        cmocka_unit_test(a_solution_goes_on_from_the_moments_it_had),
        cmocka_unit_test(a_medium_keeps_the_solution),
        cmocka_unit_test(legendre_means_are_as_good_as_g),
        cmocka_unit_test(no_light_gives_none),
        cmocka_unit_test(harmonics_alone_take_the_fewest_directions),
        cmocka_unit_test(a_hanning_beam_is_a_windowed_dirac),
        cmocka_unit_test(lack_of_memory_leaves_nothing),
        cmocka_unit_test(a_solve_without_memory_can_be_repeated),
        cmocka_unit_test(bytes_are_as_announced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

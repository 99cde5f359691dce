/* The sky that enters a box of cells by its faces. */
#include <math.h>
#include <stdlib.h>

#include "core/harmonics.h"
#include "ordinates_box.h"
#include "render/ordinates/sources.h"

enum { PARTS = 64, BANDS = 4 };

/* Parts of a sky on a spiral, each of the same solid angle, of a radiance. */
static ord_source_list make_sky(air_context *context, double (*radiance)(const double to[3]))
{
    ord_source_list list = {.context = context};
    for (int i = 0; i < PARTS; i++) {
        const double z = 1.0 - (2.0 * i + 1.0) / PARTS, phi = 2.39996323 * i;
        const double r = sqrt(1.0 - z * z), to[3] = {r * cos(phi), r * sin(phi), z};
        const double angle = 4.0 * AIR_PI / PARTS, power = angle * radiance(to);
        const ord_source part = {.place = vec3((float)-to[0], (float)-to[1], (float)-to[2]),
                                 .power = vec3((float)power, (float)(2.0 * power), (float)power),
                                 .lobe = 0.98f,
                                 .solid_angle = (float)angle,
                                 .sky = true};
        if (power > 0.0) {
            assert_int_equal(ord_sources_add(&list, &part), AIR_OK);
        }
    }
    return list;
}

/* In a box without fog the radiance is that which enters, wherever one looks. */
static void moments_within(air_context *context, const ord_source_list *list, int polar,
                           double out[BANDS * BANDS], double *green)
{
    air_dom_params params;
    air_dom *dom;
    air_dom_solve_params solve;
    air_dom_params_default(&params);
    params.bands = BANDS;
    params.polar = polar;
    params.azimuths = 2 * polar;
    for (int axis = 0; axis < 3; axis++) {
        params.size[axis] = 2;
        params.cell_m[axis] = 1.0f;
    }
    const float none[3 * 8] = {0.0f};
    const air_dom_phase phase = {.g = none};
    float moments[8 * BANDS * BANDS * AIR_DOM_STRIDE];
    air_dom_solve_params_default(&solve);
    assert_int_equal(air_dom_create(context, &params, &dom), AIR_OK);
    assert_int_equal(air_dom_set_medium(dom, none, none, &phase), AIR_OK);
    assert_int_equal(ord_inflow_set(list, &params, dom), AIR_OK);
    assert_int_equal(air_dom_solve(dom, &solve, NULL), AIR_OK);
    air_dom_moments(dom, moments);
    for (int i = 0; i < BANDS * BANDS; i++) {
        out[i] = (double)moments[i * AIR_DOM_STRIDE];
    }
    *green = (double)moments[1];
    air_dom_destroy(dom);
}

static double fluence_of(const ord_source_list *list)
{
    double sum = 0.0;
    for (size_t i = 0; i < list->count; i++) {
        sum += list->items[i].inflow ? (double)list->items[i].power.x : 0.0;
    }
    return sum;
}

static double one(const double to[3])
{
    (void)to;
    return 1.0;
}

static double rising(const double to[3]) { return 1.0 + 0.8 * to[1]; }

static double upper(const double to[3]) { return to[1] > 0.0 ? 1.0 : 0.0; }

static double with_sun(const double to[3]) { return to[0] > 0.95 ? 1000.0 : 1.0; }

/* ---- radiance ---- */

/* Power that enters is what the parts have: sums of 32 to 128 floats. */
static void no_light_is_lost(void **state)
{
    double (*const skies[4])(const double to[3]) = {one, rising, upper, with_sun};
    for (int n = 0; n < 4; n++) {
        for (int polar = 4; polar <= 8; polar += 4) {
            double moments[BANDS * BANDS], green;
            ord_source_list list = make_sky(*state, skies[n]);
            assert_true(ord_inflow_choose(&list, 1.0f));
            moments_within(*state, &list, polar, moments, &green);
            const double root = sqrt(4.0 * AIR_PI), expected = fluence_of(&list);
            assert_true(fabs(moments[0] * root / expected - 1.0) < 1e-5);
            assert_true(fabs(green * root / expected - 2.0) < 2e-5);
            ord_sources_finish(&list);
        }
    }
}

/* Every moment but the first is 0 of an even sky, whose radiance is 1. */
static void an_even_sky_is_even(void **state)
{
    for (int polar = 4; polar <= 8; polar += 2) {
        double moments[BANDS * BANDS], green, most = 0.0;
        ord_source_list list = make_sky(*state, one);
        assert_true(ord_inflow_choose(&list, 1.0f));
        moments_within(*state, &list, polar, moments, &green);
        for (int i = 1; i < BANDS * BANDS; i++) {
            most = fmax(most, fabs(moments[i]) / moments[0]);
        }
        print_message("%d x %d directions: %.2g of the mean in other moments\n", polar, 2 * polar,
                      most);
        assert_true(most < 0.01);
        ord_sources_finish(&list);
    }
}

/* The first band of 1 + 0.8 y is 0.8 / sqrt(3) of the mean; blurred by parts and directions, each
 * some pi/8 wide, it loses up to a tenth. */
static void gradients_stay(void **state)
{
    double moments[BANDS * BANDS], green;
    ord_source_list list = make_sky(*state, rising);
    assert_true(ord_inflow_choose(&list, 1.0f));
    moments_within(*state, &list, 8, moments, &green);
    const double found = -moments[1] / moments[0] * sqrt(3.0); /* of travel, so against it */
    print_message("gradient %.4f of 0.8\n", found);
    assert_true(found > 0.72 && found < 0.8);
    assert_true(fabs(moments[2]) < 0.02 * moments[0] && fabs(moments[3]) < 0.02 * moments[0]);
    ord_sources_finish(&list);
}

/* Light from above alone: net flux over fluence is 1/2, of which blurring takes some. */
static void dark_halves_stay_dark(void **state)
{
    double moments[BANDS * BANDS], green;
    ord_source_list list = make_sky(*state, upper);
    assert_true(ord_inflow_choose(&list, 1.0f));
    moments_within(*state, &list, 8, moments, &green);
    const double found = -moments[1] / moments[0] / sqrt(3.0);
    print_message("flux %.4f of 0.5\n", found);
    assert_true(found > 0.45);
    ord_sources_finish(&list);
}

/* ---- choice ---- */

static void suns_stay_beams(void **state)
{
    ord_source_list list = make_sky(*state, with_sun);
    size_t beams = 0;
    assert_true(ord_inflow_choose(&list, 1.0f));
    for (size_t i = 0; i < list.count; i++) {
        const bool sun = list.items[i].place.x < -0.95f;
        beams += list.items[i].inflow ? 0 : 1;
        assert_true(list.items[i].inflow == !sun);
    }
    assert_true(beams > 0);
    ord_sources_finish(&list);
}

/* Lamps and suns are no part of a sky. */
static void without_a_sky_nothing_flows_in(void **state)
{
    ord_source_list list = {.context = *state};
    const ord_source lamp = {.local = true, .power = vec3(1.0f, 1.0f, 1.0f), .lobe = 1.0f};
    assert_false(ord_inflow_choose(&list, 1.0f));
    assert_int_equal(ord_sources_add(&list, &lamp), AIR_OK);
    assert_false(ord_inflow_choose(&list, 1.0f));
    assert_false(list.items[0].inflow);
    ord_sources_finish(&list);
}

static int set_up(void **state)
{
    *state = box_context(AIR_CPU_AUTO, 1);
    return 0;
}

static int tear_down(void **state)
{
    air_context_destroy(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(no_light_is_lost, set_up, tear_down),
        cmocka_unit_test_setup_teardown(an_even_sky_is_even, set_up, tear_down),
        cmocka_unit_test_setup_teardown(gradients_stay, set_up, tear_down),
        cmocka_unit_test_setup_teardown(dark_halves_stay_dark, set_up, tear_down),
        cmocka_unit_test_setup_teardown(suns_stay_beams, set_up, tear_down),
        cmocka_unit_test_setup_teardown(without_a_sky_nothing_flows_in, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

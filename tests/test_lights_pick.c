#include "chi_square.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/vec.h"
#include "light_fixture.h"
#include "scene/lights/pick.h"

enum { COUNT = 6 };

static const float SHEET[12] = {0, 0, 0, 2, 0, 0, 2, 0, -1, 0, 0, -1}; /* 2 m^2 */

/* One of each kind and a black one. */
static void describe(air_light_desc *descs, air_light_source *sources)
{
    for (int i = 0; i < COUNT; i++) {
        air_light_desc_default(&descs[i]);
        descs[i].color[0] = descs[i].color[1] = descs[i].color[2] = 1.0f;
        sources[i] = (air_light_source){&descs[i], NULL};
    }
    descs[1].kind = AIR_LIGHT_SPOT;
    descs[2].kind = AIR_LIGHT_COLLIMATED;
    descs[2].color[0] = descs[2].color[1] = descs[2].color[2] = 1000.0f;
    descs[3].kind = AIR_LIGHT_POLYGON;
    descs[3].vertices = SHEET;
    descs[3].vertex_count = 4;
    descs[4].color[0] = descs[4].color[1] = descs[4].color[2] = 0.0f;
    descs[5].kind = AIR_LIGHT_ENVIRONMENT;
}

static air_light_table one_of_each(air_context *context)
{
    air_light_desc descs[COUNT];
    air_light_source sources[COUNT];
    describe(descs, sources);
    return table_of(context, sources, COUNT);
}

static void flux_is_that_of_the_kind(void **state)
{
    air_light_table table = one_of_each(*state);
    /* The scene's radius is 1, its disk pi m^2. The spot's falloff is the square of what rises
     * linearly over 1 - cos 45. */
    const double expected[COUNT] = {4.0 * AIR_PI,
                                    2.0 * AIR_PI * (1.0 - sqrt(0.5)) / 3.0,
                                    1000.0 * AIR_PI,
                                    2.0 * AIR_PI,
                                    0.0,
                                    4.0 * AIR_PI * AIR_PI};
    for (int i = 0; i < COUNT; i++) {
        assert_true(fabs(air_light_flux(&table, &table.entries[i]) - expected[i]) <=
                    1e-5 * expected[i]);
    }
    table.entries[3].one_sided = false;
    assert_true(fabs(air_light_flux(&table, &table.entries[3]) - 4.0 * AIR_PI) < 1e-5);
    air_light_table_finish(*state, &table);
}

static void probabilities_sum_to_one_and_starve_nobody(void **state)
{
    air_light_table table = one_of_each(*state);
    double sum = 0.0;
    for (uint32_t i = 0; i < COUNT; i++) {
        const double p = (double)air_light_pick_probability(&table, i);
        sum += p;
        if (i == 4) {
            assert_true(p == 0.0); /* black */
        } else {
            assert_true(p > 0.049); /* a quarter of the choices over five lights */
        }
    }
    assert_true(fabs(sum - 1.0) < 1e-6);
    assert_true(table.cdf[COUNT - 1] == 1.0f);
    assert_true(air_light_pick_probability(&table, 2) > 0.75f);
    air_light_table_finish(*state, &table);
}

static void picks_follow_their_probability_and_u_stays_uniform(void **state)
{
    air_light_table table = one_of_each(*state);
    enum { SAMPLES = 200000, PARTS = 16, BINS = COUNT * PARTS };
    double observed[BINS] = {0.0}, expected[BINS];
    for (uint32_t i = 0; i < BINS; i++) {
        expected[i] = (double)air_light_pick_probability(&table, i / PARTS) * SAMPLES / PARTS;
    }
    air_rng rng = air_rng_from_keys(1, 1);
    for (int i = 0; i < SAMPLES; i++) {
        float probability, rest;
        const uint32_t entry = air_light_pick(&table, air_rng_float(&rng), &probability, &rest);
        assert_true(probability == air_light_pick_probability(&table, entry) && probability > 0.0f);
        assert_true(rest >= 0.0f && rest < 1.0f);
        observed[entry * PARTS + (uint32_t)(rest * PARTS)] += 1.0;
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-4);
    float probability, rest;
    assert_int_equal(air_light_pick(&table, 0.0f, &probability, &rest), 0);
    assert_int_equal(air_light_pick(&table, 0x1.fffffep-1f, &probability, &rest), COUNT - 1);
    assert_true(rest < 1.0f);
    air_light_table_finish(*state, &table);
}

static void black_lights_can_still_be_picked(void **state)
{
    air_light_desc desc;
    air_light_desc_default(&desc);
    const air_light_source sources[2] = {{&desc, NULL}, {&desc, NULL}};
    air_light_table table = table_of(*state, sources, 2);
    float probability, rest;
    assert_int_equal(air_light_pick(&table, 0.75f, &probability, &rest), 1);
    assert_true(probability == 0.5f && rest == 0.5f);
    air_light_table_finish(*state, &table);
}

static void windows_bound_the_flux_of_a_sun(void **state)
{
    const float pane[12] = {0, 0, 0, 0.1f, 0, 0, 0.1f, 0.1f, 0, 0, 0.1f, 0};
    const air_gobo_window window = {pane, 4};
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_COLLIMATED;
    desc.color[0] = desc.color[1] = desc.color[2] = 100.0f;
    desc.dir[1] = 0.0f;
    desc.dir[2] = 3.0f;
    desc.windows = &window;
    desc.window_count = 1;
    air_light_table table = table_of_one(*state, &desc, NULL);
    assert_true(fabs(air_light_flux(&table, &table.entries[0]) - 1.0) < 1e-5);
    air_light_table_finish(*state, &table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flux_is_that_of_the_kind),
        cmocka_unit_test(probabilities_sum_to_one_and_starve_nobody),
        cmocka_unit_test(picks_follow_their_probability_and_u_stays_uniform),
        cmocka_unit_test(black_lights_can_still_be_picked),
        cmocka_unit_test(windows_bound_the_flux_of_a_sun),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}

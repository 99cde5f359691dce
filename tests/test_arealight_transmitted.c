/* Transmittance over a polygon's directions, and the second exponential integral. */
#include <stdio.h>

#include "arealight/exponential_integral.h"
#include "arealight_fixture.h"
#include "arealight_tables.h"
#include "cmocka_test.h"

static area_row rows[AREA_ROWS];

static void e2_is_known(void **state)
{
    (void)state;
    /* The function of these doubles in 30 digits. */
    static const double known[][2] = {
        {1e-12, 0.999999999971946195},     {1e-6, 0.999985761704606937},
        {1e-3, 0.992668960469238842},      {0.1, 0.722545022194020496},
        {0.5, 0.326643862324553018},       {1, 0.148495506775922048},
        {1.0000001, 0.148495484837530435}, {1.5, 0.0731007865384808511},
        {2.5, 0.0197977039482244564},      {5, 0.00099646904270883811},
        {22.5, 6.92721829385074622e-12},   {100, 3.64782143388037827e-46},
        {700, 1.40451801215403973e-307},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const double found = air_exponential_integral_2(known[i][0]);
        if (!(fabs(found / known[i][1] - 1.0) < 2e-15)) {
            fail_msg("E2(%g): %.17g instead of %.17g", known[i][0], found, known[i][1]);
        }
    }
    assert_true(air_exponential_integral_2(0.0) == 1.0);
    assert_true(air_exponential_integral_2(INFINITY) == 0.0);
    assert_true(air_exponential_integral_2(1e6) == 0.0);
}

/* E2'' = exp(-x)/x, by second differences: across the border of series and fraction too. */
static void e2_solves_its_equation(void **state)
{
    (void)state;
    for (double x = 1e-3; x < 300.0; x *= 1.07) {
        /* The error is h^2/12 of the fourth derivative, 2/x^2 at most, and 4e-15/h^2 of
         * rounding. */
        const double h = 1e-2 * fmin(x, 1.0);
        const double second =
            (air_exponential_integral_2(x + h) - 2.0 * air_exponential_integral_2(x) +
             air_exponential_integral_2(x - h)) /
            (h * h);
        assert_true(fabs(second * x * exp(x) - 1.0) < 1e-3);
    }
}

static void tables_are_met(void **state)
{
    (void)state;
    static reference_table table;
    const size_t count =
        area_read_rows(AIR_SHARED_DIR "/spec/data/area-lights/oracle_public.csv", rows);
    bool ok = table_open(&table, AIR_SHARED_DIR "/spec/data/area-lights/oracleT_public.csv");
    if (count == 0 || table.file == NULL) {
        printf("skipped: no tables of reference values\n");
        skip();
    }
    static const struct bound {
        int nodes;
        double error;
    } bounds[] = {{48, 1e-9}, {32, 1e-9}, {16, 1e-7}, {8, 1e-5}, {6, 1e-3}, {4, 1e-3}};
    size_t read = 0;
    for (; table_next(&table, &ok); read++) {
        char id[TABLE_NAME];
        double sigma_t = 0.0, expected = 0.0;
        size_t i = 0;
        assert_true(table_text(&table, "id", id) && table_number(&table, "mu_t", &sigma_t) &&
                    table_number(&table, "Tbar", &expected));
        while (i < count && strcmp(rows[i].id, id) != 0) {
            i++;
        }
        assert_true(i < count);
        for (size_t b = 0; b < sizeof bounds / sizeof *bounds; b++) {
            const double found = air_area_transmitted_solid_angle(
                fixed(rows[i].polygon), rows[i].count, sigma_t, bounds[b].nodes);
            if (!(fabs(found / expected - 1.0) < bounds[b].error)) {
                fail_msg("%s, sigma_t %g, %d nodes: %.12g instead of %.12g", id, sigma_t,
                         bounds[b].nodes, found, expected);
            }
        }
    }
    table_close(&table);
    assert_true(ok && read > 0);
}

static double transmittance(const void *user, const double point[3], const double dir[3])
{
    (void)dir;
    return exp(-*(const double *)user * sqrt(dot(point, point)));
}

static void cubature_is_met(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 0);
    for (int i = 0; i < 200; i++) {
        polygon_vertices p;
        const double sigma_t = exp(random_between(&rng, log(1e-3), log(30.0)));
        const size_t count = random_polygon(&rng, p);
        const double expected = integrate_directions(p, count, transmittance, &sigma_t);
        const double found = air_area_transmitted_solid_angle(fixed(p), count, sigma_t, 48);
        const double coarse = air_area_transmitted_solid_angle(fixed(p), count, sigma_t, 8);
        /* 1e-11 of the cubature and what 48 nodes leave of depths of up to 100. */
        if (!(fabs(found / expected - 1.0) < 1e-7 && fabs(coarse / expected - 1.0) < 0.05)) {
            fail_msg("sigma_t %g, %g by 8: %.15g instead of %.15g", sigma_t, coarse, found,
                     expected);
        }
    }
}

static void thin_haze_leaves_the_solid_angle(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 0);
    for (int i = 0; i < 200; i++) {
        polygon_vertices p;
        const size_t count = random_polygon(&rng, p);
        const double solid_angle = air_area_solid_angle(fixed(p), count);
        assert_true(air_area_transmitted_solid_angle(fixed(p), count, 0.0, 8) == solid_angle);
        /* Within exp(-1e-9 d), d below 6. */
        const double thin = air_area_transmitted_solid_angle(fixed(p), count, 1e-9, 8);
        assert_true(fabs(thin / solid_angle - 1.0) < 1e-8);
        /* Thicker haze lets less through. */
        double before = solid_angle;
        for (double sigma_t = 1e-3; sigma_t < 50.0; sigma_t *= 3.0) {
            const double now = air_area_transmitted_solid_angle(fixed(p), count, sigma_t, 16);
            assert_true(now < before);
            before = now;
        }
    }
}

static void limits_are_within_their_bounds(void **state)
{
    (void)state;
    static const double places[] = {-1.0, -1.0 + 1e-9, 0.0, 1e-300, 2.0};
    static const double depths[] = {1e-6, 1.0, 1e3}, sizes[] = {1e-3, 1.0, 1e3};
    enum { PLACES = sizeof places / sizeof *places };
    for (int i = 0; i < PLACES * PLACES * PLACES * 9; i++) {
        const double x = places[i % PLACES], y = places[i / PLACES % PLACES];
        const double z = places[i / (PLACES * PLACES) % PLACES];
        const double sigma_t = depths[i % 3], size = sizes[i / 3 % 3];
        polygon_vertices p = {{size * (-1.0 - x), size * (-1.0 - y), -size * z},
                              {size * (1.0 - x), size * (-1.0 - y), -size * z},
                              {size * (1.0 - x), size * (1.0 - y), -size * z},
                              {size * (-1.0 - x), size * (1.0 - y), -size * z}};
        const double least = air_area_min_distance(fixed(p), 4);
        const double solid_angle = air_area_solid_angle(fixed(p), 4);
        for (int nodes = 2; nodes <= 48; nodes += 23) {
            const double found = air_area_transmitted_solid_angle(fixed(p), 4, sigma_t, nodes);
            if (!(found >= 0.0 && found <= solid_angle * exp(-sigma_t * least))) {
                fail_msg("at %g, %g, %g, size %g, sigma_t %g: %g", x, y, z, size, sigma_t, found);
            }
        }
    }
}

static void nothing_depends_on_frame_size_or_order(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 0);
    for (int i = 0; i < 300; i++) {
        polygon_vertices p, q, back;
        double frame[3][3];
        const size_t count = random_polygon(&rng, p);
        const double scale = exp(random_between(&rng, -7.0, 7.0));
        const double sigma_t = exp(random_between(&rng, -3.0, 2.0));
        random_frame(&rng, frame);
        for (size_t k = 0; k < count; k++) {
            turned(frame, scale, p[(k + 1) % count], q[k]);
        }
        reversed(q, count, back);
        const double expected = air_area_transmitted_solid_angle(fixed(p), count, sigma_t, 8);
        const double error = fmax(
            fabs(air_area_transmitted_solid_angle(fixed(q), count, sigma_t / scale, 8) - expected),
            fabs(air_area_transmitted_solid_angle(fixed(back), count, sigma_t / scale, 8) -
                 expected));
        /* Cones are 1e-3 wide at least; an edge at the border of two forms may take either. */
        if (!(error < 1e-9 * expected)) {
            fail_msg("sigma_t %g: %g of %g", sigma_t, error, expected);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(e2_is_known),
        cmocka_unit_test(e2_solves_its_equation),
        cmocka_unit_test(tables_are_met),
        cmocka_unit_test(cubature_is_met),
        cmocka_unit_test(thin_haze_leaves_the_solid_angle),
        cmocka_unit_test(limits_are_within_their_bounds),
        cmocka_unit_test(nothing_depends_on_frame_size_or_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Fits of lobes to the phase function: given values, the tables that the library carries, files. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/airlight.h"
#include "cmocka_test.h"
#include "core/vec.h"

#ifndef AIR_SHARED_DIR
#define AIR_SHARED_DIR "../shared"
#endif

/* s is printed to six digits; where its minimum is flat, rounding moves it by 1e-7 of itself. */
static void assert_near(double found, double given)
{
    if (!(fabs(found - given) <= 2e-6 * fmax(1.0, fabs(given)))) {
        fail_msg("%.9g, given %.9g", found, given);
    }
}

/* Specification, section 11. */
static void fits_are_the_given_ones(void **state)
{
    static const double given[][7] = {
        {.95, 11.369584, 1.505489, 13.834997, .556930, .884381, -.334875},
        {.6, 1.488494, 1.547560, 1.890748, .559027, .912242, -.335770},
        {.1, .614963, 1.898920, 1.021173, .133668, 1.040301, -.194085},
        {.4, .964044, 1.625894, 1.324243, .430880, .964292, -.337100},
        {.9, 5.809322, 1.506951, 7.040618, .595690, .885348, -.334907},
        {.99, 55.489298, 1.505051, 69.772177, .459195, .884092, -.334865},
    };
    (void)state;
    for (size_t i = 0; i < sizeof given / sizeof *given; i++) {
        const double *row = given[i];
        const air_area_lobe ltsd = air_area_fit(AIR_AREA_SOURCE_LTSD, AIR_AREA_KL, -row[0]);
        const air_area_lobe mix = air_area_fit(AIR_AREA_SOURCE_MIX, AIR_AREA_KL, row[0]);
        assert_true(ltsd.g == -row[0] && ltsd.w_near == 1.0 && ltsd.w_far == -1.0);
        assert_near(ltsd.s_near, row[1]);
        assert_near(ltsd.s_far, row[2]);
        assert_near(mix.s_near, row[3]);
        assert_near(mix.w_near, row[4]);
        assert_near(mix.s_far, row[5]);
        assert_near(mix.w_far, row[6]);
    }
}

/* All losses at all knots, held to the file's eight decimals or 1e-5 of s: in L2 and L3, whose
 * minima are flatter, rounding moves s by up to the root of its own size. */
static void all_losses_are_the_given_ones(void **state)
{
    static const air_area_loss losses[4] = {AIR_AREA_L2, AIR_AREA_L3, AIR_AREA_KL, AIR_AREA_CDF_L2};
    static air_area_table tables[4];
    char line[1024];
    int rows = 0;
    (void)state;
    FILE *file = fopen(AIR_SHARED_DIR "/spec/data/area-lights/table_s.csv", "r");
    if (file == NULL) {
        print_message("skipped: there is no shared data\n");
        return;
    }
    for (int i = 0; i < 4; i++) {
        air_area_table_fit(AIR_AREA_SOURCE_LTSD, losses[i], &tables[i]);
    }
    assert_non_null(fgets(line, sizeof line, file));
    for (; fgets(line, sizeof line, file) != NULL; rows++) {
        double v[15];
        char *at = line;
        for (int i = 0; i < 15; i++, at += *at == ',') {
            v[i] = strtod(at, &at);
        }
        for (int i = 0; i < 4; i++) {
            const air_area_lobe *lobe = &tables[i].knots[(int)v[0]];
            assert_true(fabs(lobe->s_near - v[3 + 2 * i]) <= 1e-5 * v[3 + 2 * i]);
            assert_true(fabs(lobe->s_far - v[4 + 2 * i]) <= 1e-5 * v[4 + 2 * i]);
        }
    }
    assert_int_equal(rows, AIR_AREA_KNOTS);
    fclose(file);
}

/* Generated data and the code that generates it belong together. */
static void the_carried_tables_are_the_fits(void **state)
{
    static air_area_table carried, fitted;
    (void)state;
    for (int source = 0; source < 2; source++) {
        air_area_table_default((air_area_source)source, &carried);
        air_area_table_fit((air_area_source)source, AIR_AREA_KL, &fitted);
        assert_int_equal(carried.loss, fitted.loss);
        for (size_t k = 0; k < AIR_AREA_KNOTS; k++) {
            const air_area_lobe *a = &carried.knots[k], *b = &fitted.knots[k];
            assert_near(a->s_near, b->s_near);
            assert_near(a->w_near, b->w_near);
            assert_near(a->s_far, b->s_far);
            assert_near(a->w_far, b->w_far);
        }
    }
}

/* Between knots 1/s and w are linear: the density there is that of the fit at g to 1 % of its
 * largest value (spec: the distribution functions differ by at most 8e-4). */
static void between_knots_lobes_are_nearly_fits(void **state)
{
    (void)state;
    for (int k = 0; k < AIR_AREA_KNOTS - 1; k += 9) {
        const double g = 0.99 * (k + 0.5) / (AIR_AREA_KNOTS - 1);
        for (int source = 0; source < 2; source++) {
            const air_area_lobe fit = air_area_fit((air_area_source)source, AIR_AREA_KL, g);
            const air_area_lobe lobe = source == 0 ? air_area_lobe_ltsd(g) : air_area_lobe_mix(-g);
            const double peak = air_area_lobe_density((air_area_source)source, &fit, 1.0);
            for (double c = -1.0; c <= 1.0; c += 0.125) {
                const double d = air_area_lobe_density((air_area_source)source, &fit, c) -
                                 air_area_lobe_density((air_area_source)source, &lobe, c);
                assert_true(fabs(d) <= 0.01 * peak);
            }
        }
    }
}

/* By the midpoint rule in angles, whose error for densities this smooth is below 1e-4 of 1. */
static void densities_integrate_to_one(void **state)
{
    enum { STEPS = 20000 };
    (void)state;
    for (double g = -0.9; g <= 0.9; g += 0.3) {
        for (int source = 0; source < AIR_AREA_SOURCES; source++) {
            const air_area_lobe lobe = air_area_fit((air_area_source)source, AIR_AREA_L2, g);
            double sums[2] = {0.0, 0.0};
            for (int i = 0; i < STEPS; i++) {
                const double angle = AIR_PI * (i + 0.5) / STEPS, c = cos(angle);
                const double ring = 2.0 * AIR_PI * sin(angle) * AIR_PI / STEPS;
                sums[0] += ring * air_area_phase_density(g, c);
                sums[1] += ring * air_area_lobe_density((air_area_source)source, &lobe, c);
            }
            assert_true(fabs(sums[0] - 1.0) <= 1e-4 && fabs(sums[1] - 1.0) <= 1e-4);
        }
    }
}

/* ---- files ---- */

static const char path[] = "test_arealight_fit.json";

static void files_keep_every_digit(void **state)
{
    static air_area_table table, loaded;
    air_context *context;
    (void)state;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    air_area_table_fit(AIR_AREA_SOURCE_LTSD, AIR_AREA_L3, &table);
    assert_int_equal(air_area_table_save(context, &table, path), AIR_OK);
    assert_int_equal(air_area_table_load(context, path, &loaded), AIR_OK);
    assert_int_equal(loaded.source, table.source);
    assert_int_equal(loaded.loss, table.loss);
    assert_memory_equal(loaded.knots, table.knots, sizeof table.knots);
    table.source = AIR_AREA_SOURCE_COSINE;
    assert_int_equal(air_area_table_save(context, &table, path), AIR_ERROR_ARGUMENT);
    remove(path);
    air_context_destroy(context);
}

static void wrong_files_are_refused_by_name_and_place(void **state)
{
    static const char *const texts[][2] = {
        {"", "not JSON"},
        {"[", "not JSON"},
        {"{}", "\"airlight_table\": expected the version number 1"},
        {"{\"airlight_table\":2}", "\"airlight_table\""},
        {"{\"airlight_table\":1,\"kind\":\"ltc\"}", "\"kind\": expected"},
        {"{\"airlight_table\":1,\"kind\":\"mix\"}", "\"loss\": expected"},
        {"{\"airlight_table\":1,\"kind\":\"mix\",\"loss\":\"kl\",\"g\":[0]}",
         "\"g\": expected an array of 128 numbers"},
    };
    air_area_table table = {.loss = AIR_AREA_L2};
    air_context *context;
    (void)state;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fputs(texts[i][0], file);
        fclose(file);
        assert_int_equal(air_area_table_load(context, path, &table), AIR_ERROR_FORMAT);
        assert_non_null(strstr(air_context_last_error(context), path));
        assert_non_null(strstr(air_context_last_error(context), texts[i][1]));
        assert_int_equal(table.loss, AIR_AREA_L2); /* untouched */
    }
    remove(path);
    assert_int_equal(air_area_table_load(context, path, &table), AIR_ERROR_IO);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fits_are_the_given_ones),
        cmocka_unit_test(all_losses_are_the_given_ones),
        cmocka_unit_test(the_carried_tables_are_the_fits),
        cmocka_unit_test(between_knots_lobes_are_nearly_fits),
        cmocka_unit_test(densities_integrate_to_one),
        cmocka_unit_test(files_keep_every_digit),
        cmocka_unit_test(wrong_files_are_refused_by_name_and_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

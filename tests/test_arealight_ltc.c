/* Transformed cosines for GGX: against the exact integrals, and the carried table against its fits.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/airlight.h"
#include "airlight/area_ltc.h"
#include "airlight/area_table.h"
#include "cmocka_test.h"
#include "core/vec.h"

#ifndef AIR_SHARED_DIR
#define AIR_SHARED_DIR "../shared"
#endif

static const double up[3] = {0.0, 0.0, 1.0};

static void direction_of(double cos_o, double wo[3])
{
    wo[0] = sqrt(1.0 - cos_o * cos_o);
    wo[1] = 0.0;
    wo[2] = cos_o;
}

/* A transformed cosine is not GGX: over the 48 polygons the integrals are off by 0.8 % of the
 * albedo in the root mean square and 2.7 % at most (bigger lobes' bends at grazing angles).
 * Albedos: the specification's, to the error of 64 x 64 points, 2e-4. */
static void integrals_are_near_the_exact_ones(void **state)
{
    char line[1024];
    double squares = 0.0, worst = 0.0;
    int count = 0;
    (void)state;
    FILE *file = fopen(AIR_SHARED_DIR "/spec/data/area-lights/oracle_ggx.csv", "r");
    if (file == NULL) {
        print_message("skipped: there is no shared data\n");
        return;
    }
    assert_non_null(fgets(line, sizeof line, file));
    for (; fgets(line, sizeof line, file) != NULL; count++) {
        double v[16], polygon[4][3], wo[3];
        char *at = line;
        for (int i = 0; i < 16; i++, at += *at == ',') {
            v[i] = strtod(at, &at);
        }
        for (int i = 0; i < 12; i++) {
            polygon[i / 3][i % 3] = v[3 + i];
        }
        direction_of(v[1], wo);
        const air_area_ltc ltc = air_area_ltc_at(air_area_ltc_table_default(), v[0], v[1]);
        const double found =
            ltc.albedo * air_area_ltc_share(&ltc, (const double(*)[3])polygon, 4, up, wo);
        const double off = fabs(found - v[15]) / ltc.albedo;
        squares += off * off;
        worst = fmax(worst, off);
    }
    fclose(file);
    print_message("off by %.4f of the albedo, at most %.4f\n", sqrt(squares / count), worst);
    assert_int_equal(count, 48);
    assert_true(sqrt(squares / count) <= 0.008 && worst <= 0.03);
}

static void albedos_are_the_given_ones(void **state)
{
    static const double given[4][4] = {{.1, .9883041, .9814186, .9045591},
                                       {.3, .8773584, .8445307, .8385119},
                                       {.6, .5915228, .6096858, .7609017},
                                       {1., .3068528, .3788878, .6416481}};
    static const double cosines[3] = {1.0, 0.7, 0.2};
    (void)state;
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 3; j++) {
            const air_area_ltc fit = air_area_ltc_fit(given[i][0], cosines[j]);
            assert_true(fabs(fit.albedo - given[i][1 + j]) <= 4e-4);
        }
    }
}

/* The faces of a box around the point share out the whole lobe, and a polygon below has nothing of
 * it: the surface's cut of a transformed cosine is exact. */
static void faces_of_a_box_share_out_the_lobe(void **state)
{
    static const double alphas[4] = {0.001, 0.05, 0.4, 1.0};
    (void)state;
    for (int n = 0; n < 4 * 5; n++) {
        const air_area_ltc ltc =
            air_area_ltc_at(air_area_ltc_table_default(), alphas[n % 4], n / 4 / 4.0);
        double sum = 0.0, wo[3];
        direction_of(n / 4 / 4.0, wo);
        for (int face = 0; face < 6; face++) {
            double polygon[4][3];
            for (int i = 0; i < 4; i++) {
                polygon[i][face / 2] = face % 2 == 0 ? 1.3 : -1.3;
                polygon[i][(face / 2 + 1) % 3] = i == 0 || i == 3 ? -1.3 : 1.3;
                polygon[i][(face / 2 + 2) % 3] = i < 2 ? -1.3 : 1.3;
            }
            const double share = air_area_ltc_share(&ltc, (const double(*)[3])polygon, 4, up, wo);
            assert_true(share >= 0.0 && share <= 1.0);
            sum += share;
            if (face == 5) {
                assert_true(share == 0.0);
            }
        }
        assert_true(fabs(sum - 1.0) <= 1e-9);
    }
}

/* Generated data and the code that generates it belong together: some knots. Float has 6e-8; the
 * search ends where losses agree to 1e-7, which in a valley as flat as that of |p - d| leaves 1e-3.
 */
static void the_carried_table_is_the_fit(void **state)
{
    static const size_t knots[4][2] = {{0, 5}, {9, 0}, {14, 17}, {23, 23}};
    (void)state;
    for (int n = 0; n < 4; n++) {
        const size_t i = knots[n][0], j = knots[n][1];
        const air_area_ltc fit =
            air_area_ltc_fit(air_area_ltc_knot_alpha(i), air_area_ltc_knot_cosine(j));
        const air_area_ltc *kept = &air_area_ltc_table_default()->knots[i][j];
        const double entries[5] = {fit.xx, fit.xz, fit.zx, fit.zz, fit.albedo};
        const double carried[5] = {kept->xx, kept->xz, kept->zx, kept->zz, kept->albedo};
        for (int k = 0; k < 5; k++) {
            assert_true(fabs(carried[k] - entries[k]) <= 1e-3 * fmax(1.0, fabs(entries[k])));
        }
    }
}

/* In the middle between knots, of alphas that lamps need closed forms for: a lamp of 2 x 2 over the
 * surface has a share that is off by no more than half of what the fits are off themselves. */
static void between_knots_it_is_nearly_the_fit(void **state)
{
    static const double lamp[4][3] = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
    double squares = 0.0;
    int count = 0;
    (void)state;
    for (size_t i = 4; i + 1 < AIR_LTC_SIDE; i += 5) {
        for (size_t j = 0; j + 1 < AIR_LTC_SIDE; j += 4, count++) {
            const double alpha =
                0.5 * (air_area_ltc_knot_alpha(i) + air_area_ltc_knot_alpha(i + 1));
            const double cos_o =
                0.5 * (air_area_ltc_knot_cosine(j) + air_area_ltc_knot_cosine(j + 1));
            const air_area_ltc between =
                air_area_ltc_at(air_area_ltc_table_default(), alpha, cos_o);
            const air_area_ltc fit = air_area_ltc_fit(alpha, cos_o);
            double wo[3];
            direction_of(cos_o, wo);
            const double off = air_area_ltc_share(&between, lamp, 4, up, wo) -
                               air_area_ltc_share(&fit, lamp, 4, up, wo);
            squares += off * off;
        }
    }
    print_message("off by %.4f between knots\n", sqrt(squares / count));
    assert_true(sqrt(squares / count) <= 0.004);
}

static void files_keep_tables(void **state)
{
    static air_area_ltc_table read;
    air_context *context;
    (void)state;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    const air_area_ltc_table *table = air_area_ltc_table_default();
    assert_int_equal(air_area_ltc_table_save(context, table, "ltc_test.json"), AIR_OK);
    assert_int_equal(air_area_ltc_table_load(context, "ltc_test.json", &read), AIR_OK);
    assert_memory_equal(table, &read, sizeof read);
    /* a table of lobes is another kind */
    static air_area_table lobes;
    assert_int_equal(air_area_table_load(context, "ltc_test.json", &lobes), AIR_ERROR_FORMAT);
    assert_non_null(strstr(air_context_last_error(context), "\"kind\""));
    air_area_table_default(AIR_AREA_SOURCE_MIX, &lobes);
    assert_int_equal(air_area_table_save(context, &lobes, "ltc_test.json"), AIR_OK);
    assert_int_equal(air_area_ltc_table_load(context, "ltc_test.json", &read), AIR_ERROR_FORMAT);
    assert_non_null(strstr(air_context_last_error(context), "expected \"ltc\""));
    (void)remove("ltc_test.json");
    air_context_destroy(context);
}

static void extremes_are_finite(void **state)
{
    static const double scales[3] = {1e-3, 1.0, 1e3};
    (void)state;
    for (int n = 0; n < 3 * 3 * 3; n++) {
        double polygon[3][3] = {{0.0, 0.0, 1.0}, {1.0, 0.0, 1.0}, {0.0, 1.0, 0.0}}, wo[3];
        const double scale = scales[n % 3], cos_o = n / 3 % 3 / 2.0;
        direction_of(cos_o, wo);
        for (int i = 0; i < 9; i++) {
            polygon[i / 3][i % 3] *= scale;
        }
        const air_area_ltc ltc = air_area_ltc_at(air_area_ltc_table_default(), n / 9 / 2.0, cos_o);
        const double share = air_area_ltc_share(&ltc, (const double(*)[3])polygon, 3, up, wo);
        assert_true(share >= 0.0 && share <= 1.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integrals_are_near_the_exact_ones),
        cmocka_unit_test(albedos_are_the_given_ones),
        cmocka_unit_test(faces_of_a_box_share_out_the_lobe),
        cmocka_unit_test(the_carried_table_is_the_fit),
        cmocka_unit_test(between_knots_it_is_nearly_the_fit),
        cmocka_unit_test(files_keep_tables),
        cmocka_unit_test(extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

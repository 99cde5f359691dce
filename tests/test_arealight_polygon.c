/* Solid angle, irradiance and distance of polygons. */
#include <stdio.h>

#include "arealight_fixture.h"
#include "arealight_tables.h"
#include "cmocka_test.h"

static area_row rows[AREA_ROWS];

static void assert_relative(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance * fabs(expected))) {
        fail_msg("%.17g instead of %.17g", value, expected);
    }
}

static void tables_are_met(void **state)
{
    (void)state;
    const size_t count =
        area_read_rows(AIR_SHARED_DIR "/spec/data/area-lights/oracle_public.csv", rows);
    if (count == 0) {
        printf("skipped: no table of reference values\n");
        skip();
    }
    for (size_t i = 0; i < count; i++) {
        const area_row *r = &rows[i];
        /* Vertices have 12 digits, and tiny and nearly flat cones magnify their rounding a hundred
         * times. */
        assert_relative(air_area_solid_angle(fixed(r->polygon), r->count), r->solid_angle, 1e-10);
        assert_relative(air_area_min_distance(fixed(r->polygon), r->count), r->min_distance, 1e-10);
    }
}

/* A rectangle whose corner is above the origin at height 1. */
static void corner_rectangle(double x, double y, polygon_vertices out)
{
    const double vertices[4][3] = {{0.0, 0.0, 1.0}, {x, 0.0, 1.0}, {x, y, 1.0}, {0.0, y, 1.0}};
    memcpy(out, vertices, sizeof vertices);
}

static void rectangles_have_their_closed_forms(void **state)
{
    (void)state;
    static const double sizes[] = {1e-3, 0.1, 0.7, 1.0, 3.0, 1e3};
    const double up[3] = {0.0, 0.0, 1.0}, aside[3] = {1.0, 0.0, 0.0};
    for (size_t i = 0; i < 36; i++) {
        const double x = sizes[i / 6], y = sizes[i % 6];
        const double rx = sqrt(1.0 + x * x), ry = sqrt(1.0 + y * y),
                     rxy = sqrt(1.0 + x * x + y * y);
        polygon_vertices p;
        corner_rectangle(x, y, p);
        /* A few roundings of numbers of one sign. */
        assert_relative(air_area_solid_angle(fixed(p), 4), atan(x * y / rxy), 1e-14);
        /* Sums of a rectangle's edges cancel as its size does, here to a thousandth. */
        assert_relative(air_area_irradiance(fixed(p), 4, up),
                        (x / rx * atan(y / rx) + y / ry * atan(x / ry)) / (2.0 * AIR_PI), 1e-12);
        /* About the x axis: contour integral of the two edges across it. At x = 1e-3 the closed
         * form itself cancels to 1e-6. */
        assert_relative(air_area_irradiance(fixed(p), 4, aside),
                        (atan(y) - atan(y / rx) / rx) / (2.0 * AIR_PI), 1e-9);
    }
}

static void irradiance_stops_at_the_horizon(void **state)
{
    (void)state;
    const double aside[3] = {1.0, 0.0, 0.0};
    polygon_vertices whole = {
        {-2.0, -0.5, 1.0}, {3.0, -0.5, 1.0}, {3.0, 0.8, 1.0}, {-2.0, 0.8, 1.0}};
    polygon_vertices half = {{0.0, -0.5, 1.0}, {3.0, -0.5, 1.0}, {3.0, 0.8, 1.0}, {0.0, 0.8, 1.0}};
    const double expected = air_area_irradiance(fixed(half), 4, aside);
    assert_relative(air_area_irradiance(fixed(whole), 4, aside), expected, 1e-14);
    /* With a vertex more on the horizon, and wholly below it. */
    polygon_vertices more = {{0.0, -0.5, 1.0}, {3.0, -0.5, 1.0}, {3.0, 0.8, 1.0},
                             {0.0, 0.8, 1.0},  {-2.0, 0.8, 1.0}, {-2.0, -0.5, 1.0}};
    assert_relative(air_area_irradiance(fixed(more), 6, aside), expected, 1e-14);
    const double other[3] = {-1.0, 0.0, 0.0};
    assert_true(air_area_irradiance(fixed(half), 4, other) < 1e-16);
}

static void a_box_is_all_directions(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 0);
    for (int i = 0; i < 200; i++) {
        double low[3], high[3], normal[3], solid_angle = 0.0, irradiance = 0.0;
        for (int k = 0; k < 3; k++) {
            low[k] = -exp(random_between(&rng, -5.0, 5.0));
            high[k] = exp(random_between(&rng, -5.0, 5.0));
        }
        random_direction(&rng, normal);
        for (int face = 0; face < 6; face++) {
            polygon_vertices p;
            box_face(low, high, face / 2, face % 2, p);
            solid_angle += air_area_solid_angle(fixed(p), 4);
            irradiance += air_area_irradiance(fixed(p), 4, normal);
        }
        /* Sums of six; of a face that is up to 1e4 times as wide as it is far, the angles' sines
         * and cosines are what is left of terms as much larger. */
        assert_relative(solid_angle, 4.0 * AIR_PI, 1e-10);
        assert_relative(irradiance, 1.0, 1e-12);
    }
}

static void small_lamps_keep_their_digits(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 0);
    const double half[2] = {5e-4, 5e-4};
    for (int i = 0; i < 200; i++) {
        /* 1 mm across, seen from 1 km: Omega = A cos/d^2 but for 1e-6 squared. The vertices are
         * rounded to 1e-13 m, 1e-10 of the lamp. */
        double frame[3][3], axis[3];
        polygon_vertices p, q;
        random_frame(&rng, frame);
        const double tilt = random_between(&rng, 0.0, 1.2);
        const double centre[3] = {1000.0 * sin(tilt), 0.0, 1000.0 * cos(tilt)};
        ellipse_polygon(&rng, frame, 5, half, centre, p);
        double normal[3] = {0.0, 0.0, 0.0}, to_lamp[3], part[3], a[3], b[3];
        for (size_t k = 1; k < 4; k++) {
            for (int j = 0; j < 3; j++) {
                a[j] = p[k][j] - p[0][j];
                b[j] = p[k + 1][j] - p[0][j];
            }
            cross(a, b, part);
            for (int j = 0; j < 3; j++) {
                normal[j] += 0.5 * part[j];
            }
        }
        memcpy(to_lamp, p[0], sizeof to_lamp);
        normalise(to_lamp);
        const double expected = fabs(dot(normal, to_lamp)) / dot(p[0], p[0]);
        assert_relative(air_area_solid_angle(fixed(p), 5), expected, 1e-5);
        /* Turned around, the same vertices give the same. */
        reversed(p, 5, q);
        assert_relative(air_area_solid_angle(fixed(q), 5), air_area_solid_angle(fixed(p), 5), 1e-8);
        memcpy(axis, frame[2], sizeof axis);
        assert_relative(air_area_irradiance(fixed(p), 5, axis), expected * cos(tilt) / AIR_PI,
                        1e-4);
    }
}

static void distances_are_the_least(void **state)
{
    (void)state;
    enum { STEPS = 60 };
    air_rng rng = air_rng_from_keys(3, 0);
    for (int i = 0; i < 300; i++) {
        polygon_vertices p;
        const size_t count = random_polygon(&rng, p);
        const double found = air_area_min_distance(fixed(p), count);
        double least = INFINITY, longest = 0.0;
        for (size_t k = 1; k + 1 < count; k++) {
            for (int j = 0; j <= STEPS; j++) {
                for (int l = 0; l <= STEPS; l++) {
                    const double x = (double)j / STEPS, y = (double)l / STEPS;
                    double q[3];
                    for (int m = 0; m < 3; m++) {
                        q[m] = p[0][m] +
                               x * ((1.0 - y) * (p[k][m] - p[0][m]) + y * (p[k + 1][m] - p[0][m]));
                    }
                    least = fmin(least, sqrt(dot(q, q)));
                }
            }
            for (int m = 0; m < 3; m++) {
                longest = fmax(longest, fabs(p[k][m] - p[0][m]));
                longest = fmax(longest, fabs(p[k + 1][m] - p[k][m]));
            }
        }
        /* Points of the polygon are farther, and the nearest of them within their spacing. */
        assert_true(found <= least * (1.0 + 1e-12));
        assert_true(found >= least - 4.0 * longest / STEPS);
    }
    polygon_vertices about = {
        {-1.0, -1.0, 0.0}, {1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}, {-1.0, 1.0, 0.0}};
    assert_true(air_area_min_distance(fixed(about), 4) == 0.0);
    about[0][2] = about[1][2] = about[2][2] = about[3][2] = 0.25;
    assert_true(air_area_min_distance(fixed(about), 4) == 0.25);
}

static void degenerate_polygons_are_harmless(void **state)
{
    (void)state;
    const double up[3] = {0.0, 0.0, 1.0};
    polygon_vertices beside = {{1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 1.0, 0.0}, {1.0, 1.0, 0.0}};
    assert_true(air_area_solid_angle(fixed(beside), 4) == 0.0);
    assert_true(air_area_irradiance(fixed(beside), 4, up) == 0.0);
    polygon_vertices at_vertex = {{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 1.0, 0.0}};
    polygon_vertices on_edge = {{-1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 1.0, 0.0}};
    polygon_vertices point = {{1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}};
    const double(*const all[])[3] = {fixed(at_vertex), fixed(on_edge), fixed(point)};
    for (size_t i = 0; i < 3; i++) {
        const double solid_angle = air_area_solid_angle(all[i], 3);
        const double irradiance = air_area_irradiance(all[i], 3, up);
        assert_true(solid_angle >= 0.0 && solid_angle <= 2.0 * AIR_PI);
        assert_true(irradiance >= 0.0 && irradiance <= 1.0);
        assert_true(air_area_min_distance(all[i], 3) >= 0.0);
    }
    assert_true(air_area_min_distance(all[0], 3) == 0.0);
    assert_true(air_area_min_distance(all[1], 3) == 0.0);
    assert_true(air_area_solid_angle(all[2], 3) == 0.0);
    assert_true(air_area_solid_angle(all[0], 2) == 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_met),
        cmocka_unit_test(rectangles_have_their_closed_forms),
        cmocka_unit_test(irradiance_stops_at_the_horizon),
        cmocka_unit_test(a_box_is_all_directions),
        cmocka_unit_test(small_lamps_keep_their_digits),
        cmocka_unit_test(distances_are_the_least),
        cmocka_unit_test(degenerate_polygons_are_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

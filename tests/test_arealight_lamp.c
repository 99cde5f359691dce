/* Lamps: what is accepted, what is said of the rest, and points on them. */
#include "arealight_fixture.h"
#include "cmocka_test.h"

static void squares_are_measured(void **state)
{
    (void)state;
    const double vertices[4][3] = {
        {1.0, 2.0, 3.0}, {3.0, 2.0, 3.0}, {3.0, 5.0, 3.0}, {1.0, 5.0, 3.0}};
    air_area_lamp lamp;
    assert_int_equal(air_area_lamp_make(NULL, vertices, 4, true, &lamp), AIR_OK);
    assert_int_equal(lamp.vertex_count, 4);
    assert_memory_equal(lamp.vertices, vertices, sizeof vertices);
    assert_true(lamp.area == 6.0 && lamp.two_sided);
    assert_true(lamp.normal[0] == 0.0 && lamp.normal[1] == 0.0 && lamp.normal[2] == 1.0);
    for (int i = 0; i < 3; i++) {
        assert_true(fabs(lamp.centre[i] - (i == 0 ? 2.0 : (i == 1 ? 3.5 : 3.0))) < 1e-15);
    }
}

static void polygons_are_measured(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 0);
    for (int i = 0; i < 300; i++) {
        polygon_vertices p;
        air_area_lamp lamp;
        double points[AIR_AREA_MAX_POINTS][3], weights[AIR_AREA_MAX_POINTS], area = 0.0;
        double centre[3] = {0.0, 0.0, 0.0};
        const size_t count = random_polygon(&rng, p);
        const double scale = exp(random_between(&rng, -7.0, 7.0));
        for (size_t k = 0; k < 3 * count; k++) {
            p[k / 3][k % 3] *= scale;
        }
        assert_int_equal(air_area_lamp_make(NULL, fixed(p), count, false, &lamp), AIR_OK);
        assert_true(fabs(dot(lamp.normal, lamp.normal) - 1.0) < 1e-14);
        const size_t found = air_area_lamp_points(&lamp, 2 + i % 3, points, weights);
        for (size_t k = 0; k < found; k++) {
            area += weights[k];
            for (int j = 0; j < 3; j++) {
                centre[j] += weights[k] * points[k][j];
            }
        }
        /* Two points a side integrate cubics in x and y: area and moments are of degree 3 at
         * most. */
        assert_true(fabs(area / lamp.area - 1.0) < 1e-12);
        for (int j = 0; j < 3; j++) {
            assert_true(fabs(centre[j] / area - lamp.centre[j]) < 1e-12 * scale * 6.0);
        }
        for (size_t k = 0; k < count; k++) { /* vertices run counter-clockwise about the normal */
            double into[3], out_of[3], turn[3];
            for (int j = 0; j < 3; j++) {
                into[j] = p[(k + 1) % count][j] - p[k][j];
                out_of[j] = p[(k + 2) % count][j] - p[(k + 1) % count][j];
            }
            cross(into, out_of, turn);
            assert_true(dot(turn, lamp.normal) > 0.0);
        }
    }
}

static double smooth(const double v[3]) { return exp(0.3 * v[0] - 0.2 * v[1] + 0.1 * v[2]); }

static void points_are_a_cubature(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 0);
    for (int i = 0; i < 100; i++) {
        polygon_vertices p;
        air_area_lamp lamp;
        double points[AIR_AREA_MAX_POINTS][3], weights[AIR_AREA_MAX_POINTS], sums[9] = {0.0};
        const size_t count = random_polygon(&rng, p);
        assert_int_equal(air_area_lamp_make(NULL, fixed(p), count, false, &lamp), AIR_OK);
        for (int m = 1; m <= 8; m++) {
            const size_t found = air_area_lamp_points(&lamp, m, points, weights);
            const size_t patches = count == 4 ? 1 : count - 2;
            assert_int_equal(found, patches * (size_t)(m * m));
            for (size_t k = 0; k < found; k++) {
                assert_true(weights[k] > 0.0);
                sums[m] += weights[k] * smooth(points[k]);
            }
        }
        /* exp over 4 m with a slope of 0.37: exp(0.75 x) on [-1, 1], whose rule of m points has
         * the relative error 0.75^2m 2^2m+1 m!^4/((2m+1) (2m)!^3): 0.1, 1e-3, 1e-5 .. 1e-16. */
        assert_true(fabs(sums[1] / sums[8] - 1.0) < 0.3);
        assert_true(fabs(sums[2] / sums[8] - 1.0) < 5e-3);
        assert_true(fabs(sums[4] / sums[8] - 1.0) < 1e-7);
        assert_true(fabs(sums[6] / sums[8] - 1.0) < 1e-12);
    }
    /* The most there can be. */
    polygon_vertices many;
    air_area_lamp lamp;
    double points[AIR_AREA_MAX_POINTS][3], weights[AIR_AREA_MAX_POINTS];
    for (int k = 0; k < AIR_AREA_MAX_VERTICES; k++) {
        many[k][0] = cos(2.0 * AIR_PI * k / AIR_AREA_MAX_VERTICES);
        many[k][1] = sin(2.0 * AIR_PI * k / AIR_AREA_MAX_VERTICES);
        many[k][2] = 1.0;
    }
    assert_int_equal(air_area_lamp_make(NULL, fixed(many), AIR_AREA_MAX_VERTICES, false, &lamp),
                     AIR_OK);
    assert_int_equal(air_area_lamp_points(&lamp, 99, points, weights), AIR_AREA_MAX_POINTS);
}

static void lamps_are_seen_from_their_front(void **state)
{
    (void)state;
    polygon_vertices p = {{0.0, 0.0, 1.0}, {1.0, 0.0, 1.0}, {0.0, 1.0, 1.0}}, seen;
    const double above[3] = {5.0, 4.0, 1.5}, below[3] = {0.1, 0.1, 0.5}, level[3] = {3.0, 0.0, 1.0};
    air_area_lamp lamp, both;
    assert_int_equal(air_area_lamp_make(NULL, fixed(p), 3, false, &lamp), AIR_OK);
    assert_int_equal(air_area_lamp_make(NULL, fixed(p), 3, true, &both), AIR_OK);
    assert_true(air_area_lamp_seen_from(&lamp, above, seen));
    assert_true(seen[1][0] == -4.0 && seen[1][1] == -4.0 && seen[1][2] == -0.5);
    assert_false(air_area_lamp_seen_from(&lamp, below, seen));
    assert_false(air_area_lamp_seen_from(&lamp, level, seen));
    assert_true(air_area_lamp_seen_from(&both, below, seen));
    assert_true(seen[0][0] == -0.1 && seen[0][2] == 0.5);
}

/* Which lamps are refused, and the words that the message must have. */
static void what_is_no_lamp_is_named(void **state)
{
    (void)state;
    static const struct refused {
        size_t count;
        double vertices[6][3];
        const char *said;
    } refused[] = {
        {2, {{0, 0, 0}, {1, 0, 0}}, "2 vertices, must be 3 to 16"},
        {17, {{0, 0, 0}}, "17 vertices, must be 3 to 16"},
        {3, {{0, 0, 0}, {1, 0, 0}, {0, INFINITY, 0}}, "vertex 2: (0, inf, 0) is not finite"},
        {3, {{NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}}, "vertex 0: (nan, 0, 0) is not finite"},
        {3, {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, "vertex 0: all others are within 0 m"},
        {3, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, "vertices 0 to 2 enclose no area"},
        {4, {{0, 0, 0}, {1, 0, 0}, {1, 1, 1e-3}, {0, 1, 0}}, "m out of plane"},
        {4,
         {{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}},
         "vertex 2: the polygon is not convex"},
        {4, {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}}, "the polygon"},
        {4, {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}}, "vertex 1: is the same as a neighbour"},
        {4, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, NULL},
        {5,
         {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {1, 1, 0}, {0, 1, 0}},
         "vertex 2: the polygon is not"},
        /* a star, which turns left everywhere */
        {5,
         {{1, 0, 0},
          {-0.809, 0.588, 0},
          {0.309, -0.951, 0},
          {0.309, 0.951, 0},
          {-0.809, -0.588, 0}},
         "the polygon crosses itself"},
    };
    air_context *context;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        const struct refused *r = &refused[i];
        polygon_vertices p = {{0.0}};
        air_area_lamp lamp = {.vertex_count = 77};
        memcpy(p, r->vertices, sizeof r->vertices);
        const air_status status = air_area_lamp_make(context, fixed(p), r->count, false, &lamp);
        if (r->said == NULL) {
            assert_int_equal(status, AIR_OK); /* a vertex on an edge is no harm */
            continue;
        }
        assert_int_equal(status, AIR_ERROR_ARGUMENT);
        assert_int_equal(lamp.vertex_count, 77);
        if (strstr(air_context_last_error(context), r->said) == NULL) {
            fail_msg("\"%s\" not in \"%s\"", r->said, air_context_last_error(context));
        }
        assert_int_equal(air_area_lamp_make(NULL, fixed(p), r->count, false, &lamp),
                         AIR_ERROR_ARGUMENT);
    }
    air_context_destroy(context);
}

static void planes_are_not_looked_at_too_closely(void **state)
{
    (void)state;
    /* As flat as floats leave a lamp 100 m from the origin. */
    air_rng rng = air_rng_from_keys(3, 0);
    for (int i = 0; i < 200; i++) {
        polygon_vertices p;
        air_area_lamp lamp;
        const size_t count = random_polygon(&rng, p);
        for (size_t k = 0; k < 3 * count; k++) {
            p[k / 3][k % 3] = (double)(float)(p[k / 3][k % 3] + 100.0);
        }
        assert_int_equal(air_area_lamp_make(NULL, fixed(p), count, false, &lamp), AIR_OK);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(squares_are_measured),
        cmocka_unit_test(polygons_are_measured),
        cmocka_unit_test(points_are_a_cubature),
        cmocka_unit_test(lamps_are_seen_from_their_front),
        cmocka_unit_test(what_is_no_lamp_is_named),
        cmocka_unit_test(planes_are_not_looked_at_too_closely),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

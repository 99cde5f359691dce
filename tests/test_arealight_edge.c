/* S by a polygon's edges. */
#include <float.h>
#include <stdio.h>

#include "arealight_fixture.h"
#include "arealight_tables.h"
#include "cmocka_test.h"

static area_row rows[AREA_ROWS];

static const double asymmetries[] = {-0.99, -0.9, -0.5, -0.05, 0.0, 1e-9, 0.3, 0.7, 0.95, 0.99};
enum { ASYMMETRIES = sizeof asymmetries / sizeof *asymmetries };

static void tables_are_met(void **state)
{
    (void)state;
    const size_t count =
        area_read_rows(AIR_SHARED_DIR "/spec/data/area-lights/oracle_public.csv", rows);
    if (count == 0) {
        printf("skipped: no table of reference values\n");
        skip();
    }
    static const struct bound {
        int nodes;
        double moderate, sharp;                                         /* |g| up to 0.9, beyond */
    } bounds[] = {{32, 1e-9, 1e-9}, {16, 1e-6, 1e-6}, {8, 2e-4, 2e-3}}; /* the spec's acceptance */
    for (size_t b = 0; b < sizeof bounds / sizeof *bounds; b++) {
        for (int k = 0; k < AREA_G; k++) {
            const double bound = fabs(area_g[k]) <= 0.9 ? bounds[b].moderate : bounds[b].sharp;
            for (size_t i = 0; i < count; i++) {
                const area_row *r = &rows[i];
                const double found = air_area_scatter_edge(fixed(r->polygon), r->count, r->wo,
                                                           area_g[k], bounds[b].nodes);
                if (!(fabs(found / r->scatter[k] - 1.0) <= bound)) {
                    fail_msg("%s, g %g, %d nodes: %.15g instead of %.15g", r->id, area_g[k],
                             bounds[b].nodes, found, r->scatter[k]);
                }
            }
        }
    }
}

typedef struct phase {
    double g, wo[3];
} phase;

static double phase_function(const void *user, const double point[3], const double dir[3])
{
    (void)point;
    const phase *self = user;
    return henyey_greenstein(self->g, dot(self->wo, dir));
}

static void cubature_is_met(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 0);
    for (int i = 0; i < 120; i++) {
        polygon_vertices p;
        phase user = {.g = random_between(&rng, -0.8, 0.8)};
        const size_t count = random_polygon(&rng, p);
        random_direction(&rng, user.wo);
        const double expected = integrate_directions(p, count, phase_function, &user);
        const double found = air_area_scatter_edge(fixed(p), count, user.wo, user.g, 32);
        /* 1e-11 of the cubature, and what 32 nodes leave at |g| = 0.8 (16: 1e-9). */
        if (!(fabs(found / expected - 1.0) < 1e-10)) {
            fail_msg("g %g: %.15g instead of %.15g", user.g, found, expected);
        }
    }
}

static void a_box_is_all_that_is_scattered(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 0);
    for (int i = 0; i < 300; i++) {
        double low[3], high[3], wo[3], sum = 0.0;
        for (int k = 0; k < 3; k++) {
            low[k] = -exp(random_between(&rng, -3.0, 3.0));
            high[k] = exp(random_between(&rng, -3.0, 3.0));
        }
        random_direction(&rng, wo);
        if (i % 3 == 0) { /* along an axis: edges in the horizon, the peak in a face */
            wo[0] = wo[1] = 0.0;
            wo[2] = i % 2 == 0 ? 1.0 : -1.0;
        }
        for (int face = 0; face < 6; face++) {
            polygon_vertices p;
            box_face(low, high, face / 2, face % 2, p);
            const double g = asymmetries[i % ASYMMETRIES];
            sum += air_area_scatter_edge(fixed(p), 4, wo, g, 2 * air_area_edge_nodes(g) + i % 9);
        }
        /* Each edge is passed both ways, with the same nodes but for rounding: whatever it gives,
         * it cancels (if no face's sum is so wrong that it has the other sign). The largest terms
         * are of the order of 1. */
        if (!(fabs(sum - 1.0) < 1e-13)) {
            fail_msg("g %g: %.15g", asymmetries[i % ASYMMETRIES], sum);
        }
    }
}

static void small_lamps_have_the_phase_function(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 0);
    const double half[2] = {5e-4, 5e-4};
    for (int i = 0; i < 400; i++) {
        double frame[3][3], wo[3], to_lamp[3];
        air_area_lamp lamp;
        polygon_vertices p;
        const double distance = i % 2 == 0 ? 10.0 : 1000.0;
        const double centre[3] = {0.5 * distance, 0.0, distance}, g = asymmetries[i % ASYMMETRIES];
        random_frame(&rng, frame);
        ellipse_polygon(&rng, frame, 4, half, centre, p);
        assert_int_equal(air_area_lamp_make(NULL, fixed(p), 4, true, &lamp), AIR_OK);
        memcpy(to_lamp, lamp.centre, sizeof to_lamp);
        normalise(to_lamp);
        random_direction(&rng, wo);
        if (i % 5 == 0) { /* seen in the peak, or opposite to it */
            for (int j = 0; j < 3; j++) {
                wo[j] = i % 3 == 0 ? to_lamp[j] : -to_lamp[j];
            }
        } else if (i % 5 == 1) { /* on the horizon, which passes the lamp */
            double other[3];
            cross(wo, to_lamp, other);
            memcpy(wo, other, sizeof wo);
            normalise(wo);
        }
        const double expected =
            henyey_greenstein(g, dot(wo, to_lamp)) * air_area_solid_angle(fixed(p), 4);
        const double found = air_area_scatter_edge(fixed(p), 4, wo, g, 4);
        /* The phase function's second difference over the lamp; and terms as large as the lamp is
         * wide, times G, cancel to its area, times p: G/p is about 2/(1 - |g|) at the horizon. */
        const double width = 1e-3 / distance, sharp = 1.0 / (1.0 - fabs(g));
        const double tolerance = 3.0 * pow(width * sharp, 2.0) + 50.0 * DBL_EPSILON * sharp / width;
        if (!(fabs(found / expected - 1.0) < tolerance)) {
            fail_msg("g %g, %g m: relative error %g", g, distance, found / expected - 1.0);
        }
    }
}

/* In front of the plane's inside and at no distance the lamp is half of all directions. */
static void the_plane_is_approached(void **state)
{
    (void)state;
    for (int a = 0; a < ASYMMETRIES; a++) {
        const double g = asymmetries[a], gamma = fabs(g), r = sqrt(1.0 + gamma * gamma);
        const double near = (1.0 + gamma) / (r * (r + 1.0 - gamma));
        for (int k = 1; k < 16; k++) {
            const double height = pow(10.0, -k);
            polygon_vertices p = {
                {-1.0, -1.0, height}, {2.0, -1.0, height}, {2.0, 1.5, height}, {-1.0, 1.5, height}};
            for (int side = 0; side < 2; side++) {
                const double wo[3] = {0.0, 0.0, side == 0 ? 1.0 : -1.0};
                const bool peak = (g > 0.0) == (side == 1);
                const double found = air_area_scatter_edge(fixed(p), 4, wo, g, 16);
                /* What is missing is a strip of width height, density below (1+g)/(1-g)^2/4 pi. */
                const double density = (1.0 + gamma) / pow(1.0 - gamma, 2.0);
                if (!(fabs(found - (peak ? near : 1.0 - near)) < 1e-6 + 2.0 * density * height)) {
                    fail_msg("g %g at %g: %g", g, height, found);
                }
            }
        }
    }
}

/* Points on edges, vertices, in the plane, and the peak on all of them. */
static void limits_are_finite(void **state)
{
    (void)state;
    static const double places[] = {-1.0, -1.0 + 1e-15, -1.0 + 1e-9, -0.3, 0.0, 1e-300, 1.0, 2.0};
    enum { PLACES = sizeof places / sizeof *places };
    static const double sizes[] = {1e-3, 1.0, 1e3};
    double wo[3], up[3] = {0.0, 0.0, 1.0};
    air_rng rng = air_rng_from_keys(4, 0);
    for (int i = 0; i < PLACES * PLACES * PLACES * 3; i++) {
        const double x = places[i % PLACES], y = places[i / PLACES % PLACES];
        const double z = places[i / (PLACES * PLACES) % PLACES], size = sizes[i % 3];
        polygon_vertices p = {{-1.0 - x, -1.0 - y, -z},
                              {1.0 - x, -1.0 - y, -z},
                              {1.0 - x, 1.0 - y, -z},
                              {-1.0 - x, 1.0 - y, -z}};
        for (int k = 0; k < 12; k++) {
            p[k / 3][k % 3] *= size;
        }
        for (int direction = 0; direction < 8; direction++) {
            random_direction(&rng, wo);
            for (int j = 0; j < 3 && direction < 6;
                 j++) { /* to the middles of edges, corners, up */
                wo[j] = direction == 0   ? p[0][j]
                        : direction == 1 ? -p[2][j]
                        : direction == 2 ? p[0][j] + p[1][j]
                        : direction == 3 ? -p[1][j] - p[2][j]
                        : direction == 4 ? up[j]
                                         : -up[j];
            }
            if (!(dot(wo, wo) > 0.0)) {
                continue;
            }
            normalise(wo);
            for (int a = 0; a < ASYMMETRIES; a++) {
                const double found =
                    air_area_scatter_edge(fixed(p), 4, wo, asymmetries[a], 2 + direction);
                if (!(found >= 0.0 && found <= 1.0)) {
                    fail_msg("at %g, %g, %g, size %g: %g", x, y, z, size, found);
                }
            }
        }
    }
    assert_true(air_area_scatter_edge(fixed(rows[0].polygon), 2, up, 0.5, 4) == 0.0);
}

/* The peak in a vertex and on an edge is a limit like others. */
static void the_peak_may_be_on_the_outline(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 0);
    for (int i = 0; i < 200; i++) {
        polygon_vertices p;
        double wo[3], near_by[3];
        const size_t count = random_polygon(&rng, p), k = air_rng_next(&rng) % count;
        const double share = i % 2 == 0 ? 0.0 : random_unit(&rng), g = asymmetries[i % ASYMMETRIES];
        for (int j = 0; j < 3; j++) {
            wo[j] = (1.0 - share) * p[k][j] + share * p[(k + 1) % count][j];
        }
        normalise(wo);
        for (int j = 0; j < 3; j++) {
            wo[j] = i % 3 == 0 ? -wo[j] : wo[j];
            near_by[j] = wo[j] + random_between(&rng, -1e-9, 1e-9);
        }
        normalise(near_by);
        const double found = air_area_scatter_edge(fixed(p), count, wo, g, 32);
        const double beside = air_area_scatter_edge(fixed(p), count, near_by, g, 32);
        /* S changes by less than 2 pi p of the outline per unit, at most 4e4 at 0.99. */
        if (!(fabs(found - beside) < 1e-4 * (1e-9 / pow(1.0 - fabs(g), 2.0) + 1e-9) * 1e5)) {
            fail_msg("g %g: %.12g beside %.12g", g, found, beside);
        }
    }
}

static void nothing_depends_on_frame_size_or_order(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 0);
    for (int i = 0; i < 500; i++) {
        polygon_vertices p, q, back;
        double wo[3], wo_turned[3], frame[3][3];
        const size_t count = random_polygon(&rng, p);
        const double scale = exp(random_between(&rng, -7.0, 7.0)), g = asymmetries[i % ASYMMETRIES];
        random_direction(&rng, wo);
        random_frame(&rng, frame);
        turned(frame, 1.0, wo, wo_turned);
        for (size_t k = 0; k < count; k++) {
            turned(frame, scale, p[(k + 1) % count], q[k]);
        }
        reversed(q, count, back);
        const double expected = air_area_scatter_edge(fixed(p), count, wo, g, 8);
        /* Directions are rounded to 1e-16, which a peak of 0.99 magnifies 300 times; sums of edges
         * cancel to the cone's size, 1e-3 at the least. */
        const double error =
            fmax(fabs(air_area_scatter_edge(fixed(q), count, wo_turned, g, 8) - expected),
                 fabs(air_area_scatter_edge(fixed(back), count, wo_turned, g, 8) - expected));
        if (!(error < 1e-10 * expected)) {
            fail_msg("g %g: %g of %g", g, error, expected);
        }
    }
}

static void advised_nodes_are_enough(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(7, 0);
    for (int a = 0; a < ASYMMETRIES; a++) {
        double square = 0.0, mean = 0.0;
        const int nodes = air_area_edge_nodes(asymmetries[a]);
        assert_true(nodes >= 4 && nodes <= 12);
        for (int i = 0; i < 1000; i++) {
            polygon_vertices p;
            double wo[3];
            const size_t count = random_polygon(&rng, p);
            random_direction(&rng, wo);
            const double expected = air_area_scatter_edge(fixed(p), count, wo, asymmetries[a], 32);
            const double found = air_area_scatter_edge(fixed(p), count, wo, asymmetries[a], nodes);
            square += (found - expected) * (found - expected) / 1000.0;
            mean += expected / 1000.0;
        }
        /* "near 1e-3": root of the mean square by the mean. */
        if (!(sqrt(square) < 1e-3 * mean)) {
            fail_msg("g %g: %g", asymmetries[a], sqrt(square) / mean);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_met),
        cmocka_unit_test(cubature_is_met),
        cmocka_unit_test(a_box_is_all_that_is_scattered),
        cmocka_unit_test(small_lamps_have_the_phase_function),
        cmocka_unit_test(the_plane_is_approached),
        cmocka_unit_test(limits_are_finite),
        cmocka_unit_test(the_peak_may_be_on_the_outline),
        cmocka_unit_test(nothing_depends_on_frame_size_or_order),
        cmocka_unit_test(advised_nodes_are_enough),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

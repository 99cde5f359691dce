/* Windows: against point-in-polygon tests along the ray; vertices, parallel rays, neighbours. */
#include "cmocka_test.h"
#include "collimated_fixture.h"

enum { MOST_VERTICES = 24 };

static const double axis_s[3] = {1.0, 0.0, 0.0}, axis_t[3] = {0.0, 1.0, 0.0};
static const double up[3] = {0.0, 0.0, 1.0};

/* Inside by angles: the polygon winds about the point. Independent of the kernel's crossings. */
static bool winds_about(const double *window, size_t count, double x, double y)
{
    double angle = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double *a = window + 2 * i, *b = window + 2 * ((i + 1) % count);
        const double ax = a[0] - x, ay = a[1] - y, bx = b[0] - x, by = b[1] - y;
        angle += atan2(ax * by - ay * bx, ax * bx + ay * by);
    }
    return fabs(angle) > 3.0;
}

/* A star-shaped polygon about a place: simple, mostly concave. */
static size_t random_star(air_rng *rng, double *out)
{
    const size_t count = 3 + air_rng_next(rng) % (MOST_VERTICES - 2u);
    const double x = random_between(rng, -0.5, 0.5), y = random_between(rng, -0.5, 0.5);
    for (size_t i = 0; i < count; i++) {
        const double angle =
            6.283185307179586 * ((double)i + 0.9 * random_unit(rng)) / (double)count;
        const double radius = random_between(rng, 0.2, 1.5);
        out[2 * i] = x + radius * cos(angle);
        out[2 * i + 1] = y + radius * sin(angle);
    }
    return count;
}

static void stretches_are_where_the_projection_is_inside(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 4);
    int inside = 0, several = 0;
    for (int n = 0; n < 3000; n++) {
        double window[2 * MOST_VERTICES], frame[3][3], origin[3], dir[3];
        air_interval out[MOST_VERTICES / 2 + 1];
        const size_t vertices = random_star(&rng, window);
        random_frame(&rng, frame);
        random_direction(&rng, dir);
        for (int i = 0; i < 3; i++) {
            origin[i] = random_between(&rng, -1.0, 1.0);
        }
        const double begin = random_between(&rng, 0.0, 1.0), end = random_between(&rng, 1.0, 4.0);
        const size_t count = air_collimated_window(window, vertices, frame[0], frame[1], origin,
                                                   dir, begin, end, out);
        assert_true(count <= vertices / 2 + 1);
        several += count > 1;
        for (size_t k = 0; k < count; k++) {
            assert_true(out[k].begin < out[k].end && out[k].begin >= begin && out[k].end <= end);
            assert_true(k == 0 || out[k - 1].end < out[k].begin);
        }
        for (int k = 0; k < 20; k++) {
            const double t = random_between(&rng, 0.0, 5.0);
            double x[3];
            bool listed = false, close = false;
            for (size_t i = 0; i < count; i++) {
                listed = listed || (t > out[i].begin && t < out[i].end);
                close = close || fabs(t - out[i].begin) < 1e-9 || fabs(t - out[i].end) < 1e-9;
            }
            move_along(origin, dir, t, x);
            const bool expected = t > begin && t < end &&
                                  winds_about(window, vertices, dot(frame[0], x), dot(frame[1], x));
            assert_true(close || listed == expected);
            inside += expected;
        }
    }
    assert_true(inside > 3000 && several > 100);
}

static void rays_along_the_light_pass_whole_or_not_at_all(void **state)
{
    (void)state;
    const double l_shape[12] = {0, 0, 2, 0, 2, 1, 1, 1, 1, 2, 0, 2};
    const double in[3] = {0.5, 1.5, 7.0}, out[3] = {1.5, 1.5, 7.0};
    const double nearly_up[3] = {1e-13, 0.0, 1.0};
    air_interval found[7];
    assert_int_equal(
        air_collimated_window(l_shape, 6, axis_s, axis_t, in, up, 1.0, INFINITY, found), 1);
    assert_true(found[0].begin == 1.0 && found[0].end == INFINITY);
    assert_int_equal(
        air_collimated_window(l_shape, 6, axis_s, axis_t, in, nearly_up, 1.0, 9.0, found), 1);
    assert_int_equal(air_collimated_window(l_shape, 6, axis_s, axis_t, out, up, 1.0, 9.0, found),
                     0);
}

static void a_concave_window_can_be_passed_twice(void **state)
{
    (void)state;
    const double u_shape[16] = {0, 0, 3, 0, 3, 2, 2, 2, 2, 1, 1, 1, 1, 2, 0, 2};
    const double origin[3] = {-1.0, 1.5, 0.0}, dir[3] = {0.6, 0.0, 0.8};
    air_interval found[9];
    assert_int_equal(
        air_collimated_window(u_shape, 8, axis_s, axis_t, origin, dir, 0.0, 100.0, found), 2);
    const double expected[4] = {1.0 / 0.6, 2.0 / 0.6, 3.0 / 0.6, 4.0 / 0.6};
    const double ends[4] = {found[0].begin, found[0].end, found[1].begin, found[1].end};
    for (int i = 0; i < 4; i++) {
        assert_true(fabs(ends[i] - expected[i]) < 1e-14);
    }
}

static double covered(const double *window, size_t vertices, const double origin[3],
                      const double dir[3])
{
    air_interval found[MOST_VERTICES];
    double sum = 0.0;
    const size_t count =
        air_collimated_window(window, vertices, axis_s, axis_t, origin, dir, 0.0, 10.0, found);
    for (size_t i = 0; i < count; i++) {
        sum += found[i].end - found[i].begin;
    }
    return sum;
}

static void lines_through_vertices_and_along_edges_are_covered_once(void **state)
{
    (void)state;
    /* The square [0, 2]^2 and its quarters. Lines through integer points meet corners and run
     * along edges; the quarters together must cover what the square covers. */
    const double square[8] = {0, 0, 2, 0, 2, 2, 0, 2};
    const double quarters[4][8] = {{0, 0, 1, 0, 1, 1, 0, 1},
                                   {1, 0, 2, 0, 2, 1, 1, 1},
                                   {0, 1, 1, 1, 1, 2, 0, 2},
                                   {1, 1, 2, 1, 2, 2, 1, 2}};
    int passing = 0;
    for (int x = -4; x <= 4; x++) {
        for (int y = -4; y <= 4; y++) {
            for (int dx = -3; dx <= 3; dx++) {
                for (int dy = -3; dy <= 3; dy++) {
                    const double origin[3] = {x, y, 0.0};
                    double dir[3] = {dx, dy, 0.0}, sum = 0.0;
                    if (dx == 0 && dy == 0) {
                        continue;
                    }
                    normalise(dir);
                    for (int k = 0; k < 4; k++) {
                        sum += covered(quarters[k], 4, origin, dir);
                    }
                    const double whole = covered(square, 4, origin, dir);
                    assert_true(fabs(sum - whole) < 1e-14);
                    passing += whole > 0.0;
                }
            }
        }
    }
    assert_true(passing > 500);
}

static void windows_that_share_an_edge_leave_no_gap(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 4);
    int shared = 0;
    for (int n = 0; n < 3000; n++) {
        /* Two triangles of one quadrilateral: where one stretch ends the other begins, bit for bit.
         */
        double corners[8], origin[3], dir[3];
        for (int i = 0; i < 4; i++) {
            corners[2 * i] = (i == 1 || i == 2 ? 1.0 : -1.0) + random_between(&rng, -0.5, 0.5);
            corners[2 * i + 1] = (i > 1 ? 1.0 : -1.0) + random_between(&rng, -0.5, 0.5);
        }
        const double second[6] = {corners[4], corners[5], corners[6],
                                  corners[7], corners[0], corners[1]};
        air_interval a[3], b[3];
        random_direction(&rng, dir);
        for (int i = 0; i < 3; i++) {
            origin[i] = random_between(&rng, -0.3, 0.3);
        }
        move_along(origin, dir, -20.0, origin);
        const size_t a_count =
            air_collimated_window(corners, 3, axis_s, axis_t, origin, dir, 0.0, 40.0, a);
        const size_t b_count =
            air_collimated_window(second, 3, axis_s, axis_t, origin, dir, 0.0, 40.0, b);
        if (a_count == 1 && b_count == 1 && a[0].begin > 0.0 && b[0].begin > 0.0 &&
            a[0].end < 40.0 && b[0].end < 40.0) {
            assert_true(a[0].end == b[0].begin || b[0].end == a[0].begin);
            shared++;
        }
    }
    assert_true(shared > 500);
}

static void bad_input_passes_nothing(void **state)
{
    (void)state;
    const double square[8] = {0, 0, 2, 0, 2, 2, 0, 2};
    const double origin[3] = {-1.0, 1.0, 0.0}, dir[3] = {1.0, 0.0, 0.0};
    const double torn[6] = {0, 0, NAN, 0, 2, 2};
    const double nowhere[3] = {NAN, 1.0, 0.0}, far[3] = {INFINITY, 0.0, 0.0};
    air_interval found[4];
    assert_int_equal(air_collimated_window(square, 4, axis_s, axis_t, origin, dir, 0.0, 9.0, found),
                     1);
    assert_int_equal(air_collimated_window(torn, 3, axis_s, axis_t, origin, dir, 0.0, 9.0, found),
                     0);
    assert_int_equal(air_collimated_window(square, 2, axis_s, axis_t, origin, dir, 0.0, 9.0, found),
                     0);
    assert_int_equal(
        air_collimated_window(square, 4, axis_s, axis_t, nowhere, dir, 0.0, 9.0, found), 0);
    assert_int_equal(air_collimated_window(square, 4, axis_s, axis_t, origin, far, 0.0, 9.0, found),
                     0);
    assert_int_equal(air_collimated_window(square, 4, axis_s, axis_t, origin, dir, 9.0, 0.0, found),
                     0);
    assert_int_equal(air_collimated_window(square, 4, axis_s, axis_t, origin, dir, NAN, 9.0, found),
                     0);
}

static void a_window_restricts_a_profile(void **state)
{
    (void)state;
    /* A beam [0, 0.5] wide through a box, seen from the side: E = t + 1 along it, kept from the
     * camera's end of the box. */
    const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};
    const air_collimated_medium box = box_between(low, high);
    const double window[8] = {0, -9, 0.5, -9, 0.5, 9, 0, 9};
    const double origin[3] = {-3.0, 0.0, 0.0}, dir[3] = {1.0, 0.0, 0.0};
    roomy_profile room, lit_room;
    air_interval lit[3];
    air_collimated_profile_make(&box, up, 0.7, origin, dir, INFINITY, roomy(&room));
    const size_t count =
        air_collimated_window(window, 4, axis_s, axis_t, origin, dir, 2.0, 4.0, lit);
    air_collimated_profile_restrict(&room.profile, lit, count, roomy(&lit_room));
    const double exact = exp(-0.7 * 2.0) * -expm1(-0.7 * 0.5) / 0.7;
    assert_true(fabs(air_collimated_integral(&lit_room.profile) - exact) < 1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stretches_are_where_the_projection_is_inside),
        cmocka_unit_test(rays_along_the_light_pass_whole_or_not_at_all),
        cmocka_unit_test(a_concave_window_can_be_passed_twice),
        cmocka_unit_test(lines_through_vertices_and_along_edges_are_covered_once),
        cmocka_unit_test(windows_that_share_an_edge_leave_no_gap),
        cmocka_unit_test(bad_input_passes_nothing),
        cmocka_unit_test(a_window_restricts_a_profile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Convex media: what they refuse; stretches and distances against membership. */
#include <string.h>

#include "airlight/context.h"
#include "cmocka_test.h"
#include "collimated_fixture.h"

static const double identity[12] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0};

static void a_box_is_where_its_coordinates_are_within_1(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 3);
    for (int n = 0; n < 200; n++) {
        double frame[3][3], matrix[12];
        air_collimated_medium box;
        random_frame(&rng, frame);
        for (int i = 0; i < 12; i++) {
            matrix[i] =
                i % 4 == 3 ? random_between(&rng, -3.0, 3.0) : frame[i / 4][i % 4] * (1.0 + i / 4);
        }
        assert_int_equal(air_collimated_medium_from_box(NULL, matrix, &box), AIR_OK);
        assert_int_equal(box.plane_count, 6);
        for (int k = 0; k < 100; k++) {
            double x[3], farthest = 0.0;
            bool inside = true;
            for (int i = 0; i < 3; i++) {
                x[i] = random_between(&rng, -3.0, 3.0);
            }
            for (int i = 0; i < 3; i++) {
                const double *row = matrix + 4 * i;
                farthest = fmax(farthest, fabs(dot(row, x) + row[3]));
                inside = inside && dot(box.planes[2 * i], x) <= box.planes[2 * i][3] &&
                         dot(box.planes[2 * i + 1], x) <= box.planes[2 * i + 1][3];
            }
            assert_int_equal(inside, farthest <= 1.0);
        }
    }
}

/* How far inside a point is, by the plane that it is least inside of; negative outside. */
static double clearance(const air_collimated_medium *medium, const double x[3])
{
    double least = INFINITY;
    for (size_t k = 0; k < medium->plane_count; k++) {
        const double *n = medium->planes[k];
        least = fmin(least, (n[3] - dot(n, x)) / sqrt(dot(n, n)));
    }
    return least;
}

static void a_stretch_is_where_the_ray_is_inside(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 3);
    int hits = 0;
    for (int n = 0; n < 1000; n++) {
        const lit_ray r = random_lit_ray(&rng);
        air_interval stretch = {0.0, 0.0};
        const bool hit = air_collimated_interval(&r.medium, r.origin, r.dir, r.t_max, &stretch);
        hits += hit;
        assert_true(!hit || (stretch.begin >= 0.0 && stretch.end <= r.t_max));
        for (int k = 0; k < 20; k++) {
            const double t = random_between(&rng, 0.0, fmin(r.t_max, 12.0));
            double x[3];
            move_along(r.origin, r.dir, t, x);
            const double inside = clearance(&r.medium, x);
            if (fabs(inside) > 1e-12) { /* not at an end, to within rounding */
                assert_int_equal(inside > 0.0, hit && t > stretch.begin && t < stretch.end);
            }
        }
    }
    assert_true(hits > 500);
}

static void the_boundary_distance_ends_on_the_boundary(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 3);
    for (int n = 0; n < 1000; n++) {
        const lit_ray r = random_lit_ray(&rng);
        double x[3], end[3];
        move_along(r.origin, r.dir, 1.0, x);
        if (clearance(&r.medium, x) <= 0.0) {
            continue;
        }
        const double d = air_collimated_boundary_distance(&r.medium, r.to_light, x);
        move_along(x, r.to_light, d, end);
        assert_true(d > 0.0 && fabs(clearance(&r.medium, end)) < 1e-14);
    }
}

static void distances_beyond_lit_faces_are_0_and_without_faces_infinite(void **state)
{
    (void)state;
    const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};
    air_collimated_medium box = box_between(low, high);
    const double up[3] = {0.0, 0.0, 1.0}, above[3] = {0.0, 0.0, 1.5}, inside[3] = {0.0, 0.0, 0.5};
    const double nowhere[3] = {0.0, NAN, 0.0};
    assert_true(air_collimated_boundary_distance(&box, up, above) == 0.0);
    assert_true(air_collimated_boundary_distance(&box, up, inside) == 0.5);
    assert_true(air_collimated_boundary_distance(&box, up, nowhere) == 0.0);
    box.plane_count = 4; /* open above and below */
    assert_true(air_collimated_boundary_distance(&box, up, inside) == INFINITY);
    box.plane_count = 0;
    assert_true(air_collimated_boundary_distance(&box, up, inside) == INFINITY);
}

static void contradicting_planes_hold_nothing(void **state)
{
    (void)state;
    const double low[3] = {1.0, -1.0, -1.0}, high[3] = {-1.0, 1.0, 1.0};
    const air_collimated_medium inverted = box_between(low, high);
    air_rng rng = air_rng_from_keys(4, 3);
    roomy_profile room;
    for (int n = 0; n < 1000; n++) {
        double origin[3], dir[3], to_light[3];
        air_interval stretch;
        for (int i = 0; i < 3; i++) {
            origin[i] = random_between(&rng, -2.0, 2.0);
        }
        random_direction(&rng, dir);
        random_direction(&rng, to_light);
        if (n % 2 == 0) {
            dir[0] = 0.0; /* within the contradiction */
            normalise(dir);
        }
        assert_false(air_collimated_interval(&inverted, origin, dir, INFINITY, &stretch));
        air_collimated_profile_make(&inverted, to_light, 1.0, origin, dir, INFINITY, roomy(&room));
        assert_int_equal(room.profile.count, 0);
    }
}

static void all_of_space_is_a_medium(void **state)
{
    (void)state;
    air_collimated_medium space;
    air_interval stretch;
    const double origin[3] = {1.0, 2.0, 3.0}, dir[3] = {0.0, 0.0, 1.0};
    assert_int_equal(air_collimated_medium_from_planes(NULL, NULL, 0, &space), AIR_OK);
    assert_true(air_collimated_interval(&space, origin, dir, INFINITY, &stretch));
    assert_true(stretch.begin == 0.0 && stretch.end == INFINITY);
}

static void rays_that_are_not_finite_meet_nothing(void **state)
{
    (void)state;
    air_collimated_medium box;
    air_interval stretch;
    const double bad[3] = {NAN, INFINITY, -INFINITY};
    assert_int_equal(air_collimated_medium_from_box(NULL, identity, &box), AIR_OK);
    for (int number = 0; number < 7; number++) {
        for (int i = 0; i < 3; i++) {
            double values[7] = {0.0, 0.0, 0.0, 0.6, 0.0, 0.8, 10.0};
            if (number < 6 || bad[i] != INFINITY) {
                values[number] = bad[i];
                assert_false(
                    air_collimated_interval(&box, values, values + 3, values[6], &stretch));
            }
        }
    }
}

/* Refused with a sentence that holds `words`; the output is untouched. */
static void assert_refused(air_context *context, air_status status,
                           const air_collimated_medium *out, const char *words)
{
    assert_int_equal(status, AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), words));
    assert_int_equal(out->plane_count, 77);
}

static void bad_planes_are_refused_by_name(void **state)
{
    (void)state;
    air_context *context = NULL;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    air_collimated_medium out = {.plane_count = 77};
    double planes[AIR_COLLIMATED_MAX_PLANES + 1][4] = {{0.0}};
    const double(*const input)[4] = (const double(*)[4])planes;
    for (size_t k = 0; k <= AIR_COLLIMATED_MAX_PLANES; k++) {
        planes[k][2] = 1.0;
    }
    assert_refused(context, air_collimated_medium_from_planes(context, input, 41, &out), &out,
                   "41 planes");
    planes[3][2] = 0.0;
    assert_refused(context, air_collimated_medium_from_planes(context, input, 5, &out), &out,
                   "plane 3: the normal");
    planes[3][2] = NAN;
    assert_refused(context, air_collimated_medium_from_planes(context, input, 5, &out), &out,
                   "plane 3");
    planes[3][2] = 1e200;
    assert_refused(context, air_collimated_medium_from_planes(context, input, 5, &out), &out,
                   "plane 3");
    planes[3][2] = 1.0;
    planes[4][3] = INFINITY;
    assert_refused(context, air_collimated_medium_from_planes(context, input, 5, &out), &out,
                   "plane 4");
    assert_int_equal(air_collimated_medium_from_planes(NULL, input, 5, &out), AIR_ERROR_ARGUMENT);
    planes[4][3] = 1.0;
    assert_int_equal(air_collimated_medium_from_planes(context, input, 40, &out), AIR_OK);
    air_context_destroy(context);
}

static void degenerate_boxes_are_refused(void **state)
{
    (void)state;
    air_context *context = NULL;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    air_collimated_medium out = {.plane_count = 77};
    double matrix[12];
    memcpy(matrix, identity, sizeof matrix);
    matrix[10] = 0.0;
    assert_refused(context, air_collimated_medium_from_box(context, matrix, &out), &out,
                   "singular");
    /* rows (1, 2, 3), (4, 5, 6), (7, 8, 9) times 0.1, which is not exact */
    for (int i = 0; i < 12; i++) {
        matrix[i] = i % 4 == 3 ? 0.0 : 0.1 * (3 * (i / 4) + i % 4 + 1);
    }
    assert_refused(context, air_collimated_medium_from_box(context, matrix, &out), &out,
                   "singular");
    memcpy(matrix, identity, sizeof matrix);
    matrix[7] = NAN;
    assert_refused(context, air_collimated_medium_from_box(context, matrix, &out), &out,
                   "number 7");
    assert_int_equal(air_collimated_medium_from_box(NULL, matrix, &out), AIR_ERROR_ARGUMENT);
    air_context_destroy(context);
}

static void flat_and_sheared_boxes_are_not_degenerate(void **state)
{
    (void)state;
    air_collimated_medium out;
    double matrix[12];
    memcpy(matrix, identity, sizeof matrix);
    matrix[0] = 1e-20;
    matrix[5] = 1e20;
    assert_int_equal(air_collimated_medium_from_box(NULL, matrix, &out), AIR_OK);
    memcpy(matrix, identity, sizeof matrix);
    matrix[1] = 1e12; /* rows (1, 1e12, 0) and (0, 1, 0): far from parallel to within rounding */
    assert_int_equal(air_collimated_medium_from_box(NULL, matrix, &out), AIR_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_is_where_its_coordinates_are_within_1),
        cmocka_unit_test(a_stretch_is_where_the_ray_is_inside),
        cmocka_unit_test(the_boundary_distance_ends_on_the_boundary),
        cmocka_unit_test(distances_beyond_lit_faces_are_0_and_without_faces_infinite),
        cmocka_unit_test(contradicting_planes_hold_nothing),
        cmocka_unit_test(all_of_space_is_a_medium),
        cmocka_unit_test(rays_that_are_not_finite_meet_nothing),
        cmocka_unit_test(bad_planes_are_refused_by_name),
        cmocka_unit_test(degenerate_boxes_are_refused),
        cmocka_unit_test(flat_and_sheared_boxes_are_not_degenerate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

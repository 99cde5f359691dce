/* Profiles of one convex medium: against quadrature of the definition, limits with closed forms,
 * symmetries. */
#include <float.h>

#include "cmocka_test.h"
#include "collimated/pieces.h"
#include "collimated_fixture.h"

enum { CASES = 400 };

static const double middle_low[3] = {-1.0, -1.0, -1.0}, middle_high[3] = {1.0, 1.0, 1.0};

static void assert_close(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected))) {
        fail_msg("%.17g instead of %.17g, relative error %.3g", value, expected,
                 fabs(value - expected) / fabs(expected));
    }
}

/* log T and T in one medium. */
static double log_t_of(const air_collimated_medium *medium, const double to_light[3],
                       double sigma_t, const double origin[3], const double dir[3], double t_max)
{
    roomy_profile room;
    air_collimated_profile *profile = roomy(&room);
    air_collimated_profile_make(medium, to_light, sigma_t, origin, dir, t_max, profile);
    return air_collimated_log_integral(profile);
}

static double t_of(const air_collimated_medium *medium, const double to_light[3], double sigma_t,
                   const double origin[3], const double dir[3], double t_max)
{
    return exp(log_t_of(medium, to_light, sigma_t, origin, dir, t_max));
}

static void the_mean_transmittance_is_good_to_4_epsilon(void **state)
{
    (void)state;
    assert_true(air_mean_transmittance(0.0) == 1.0);
    for (double x = 1e-18; x < 1e4; x *= 1.003) {
        const double exact = (double)(-expm1l(-(long double)x) / (long double)x);
        assert_close(air_mean_transmittance(x), exact, 4.0 * DBL_EPSILON);
    }
}

static void the_integral_is_the_quadrature_of_the_definition(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 1);
    roomy_profile room;
    int hits = 0;
    for (int i = 0; i < CASES; i++) {
        lit_ray r = random_lit_ray(&rng);
        r.sigma_t = fmin(r.sigma_t, 10.0);
        const air_collimated_cell cell = {r.medium, r.sigma_t, 1.0};
        lit_cells cells = {.cells = &cell, .count = 1, .t_max = r.t_max};
        memcpy(cells.to_light, r.to_light, sizeof r.to_light);
        memcpy(cells.origin, r.origin, sizeof r.origin);
        memcpy(cells.dir, r.dir, sizeof r.dir);
        air_collimated_profile *profile = roomy(&room);
        air_interval stretch;
        make_profile(&r, profile);
        if (!air_collimated_interval(&r.medium, r.origin, r.dir, r.t_max, &stretch)) {
            assert_true(profile->count == 0 && air_collimated_integral(profile) == 0.0);
            continue;
        }
        hits++;
        /* Depths reach 100 and carry their rounding, 1e-14 of it, into both. */
        const double exact = integrate_cells(&cells, stretch.begin, stretch.end);
        assert_close(air_collimated_integral(profile), exact, 1e-11);
        assert_close(exp(air_collimated_log_integral(profile)), exact, 1e-11);
        const double t = random_between(&rng, stretch.begin, stretch.end);
        assert_close(air_collimated_integrand(profile, t), cells_integrand(&cells, t), 1e-11);
    }
    assert_true(hits > CASES / 2);
}

static void pieces_follow_each_other_and_depth_is_concave(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 1);
    roomy_profile room;
    size_t most = 0;
    for (int i = 0; i < 20 * CASES; i++) {
        const lit_ray r = random_lit_ray(&rng);
        air_collimated_profile *profile = roomy(&room);
        make_profile(&r, profile);
        double slope = INFINITY;
        for (size_t k = 0; k < profile->count; k++) {
            const air_collimated_piece *p = &profile->pieces[k];
            const double rise = (p->depth1 - p->depth0) / (p->t1 - p->t0);
            assert_true(p->t0 < p->t1 && p->camera0 <= p->depth0 && p->camera1 <= p->depth1);
            assert_true(k == 0 ? p->camera0 == 0.0 : p->t0 == p[-1].t1);
            assert_true(k == 0 || (p->depth0 == p[-1].depth1 && p->camera0 == p[-1].camera1));
            /* Depths carry 1e-14 of themselves. */
            const double noise = 1e-13 * (p->depth0 + p->depth1) / (p->t1 - p->t0);
            assert_true(rise <= slope + noise);
            slope = rise + noise;
        }
        most = profile->count > most ? profile->count : most;
    }
    assert_true(most >= 5);
}

static void looking_at_the_light_depth_is_constant(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double inside[3] = {0.1, 0.2, 0.25}, outside[3] = {0.1, 0.2, -3.0};
    const double up[3] = {0.0, 0.0, 1.0};
    /* [Velinov2021, eq. 7]: (b - a) exp(-sigma D), D the way through. */
    assert_close(t_of(&box, up, 1.5, inside, up, INFINITY), 0.75 * exp(-1.5 * 0.75), 1e-15);
    assert_close(t_of(&box, up, 1.5, inside, up, 0.5), 0.5 * exp(-1.5 * 0.75), 1e-15);
    assert_close(t_of(&box, up, 1.5, outside, up, INFINITY), 2.0 * exp(-1.5 * 2.0), 4e-15);
}

static void light_from_behind_has_the_two_way_form(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double inside[3] = {0.1, 0.2, 0.25}, outside[3] = {0.1, 0.2, -3.0};
    const double up[3] = {0.0, 0.0, 1.0}, down[3] = {0.0, 0.0, -1.0};
    /* [Velinov2021, eq. 8] */
    assert_close(t_of(&box, down, 1.5, inside, up, INFINITY),
                 exp(-1.5 * 1.25) * -expm1(-3.0 * 0.75) / 3.0, 1e-15);
    assert_close(t_of(&box, down, 1.5, outside, up, INFINITY), -expm1(-3.0 * 2.0) / 3.0, 1e-15);
}

static void a_face_along_the_light_stops_nothing(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double origin[3] = {-0.5, 0.3, 0.5}, along_x[3] = {1.0, 0.0, 0.0},
                 up[3] = {0.0, 0.0, 1.0};
    const double tilted[3] = {1e-17, 0.0, 1.0};
    /* d = 0.5 everywhere, E = t + 0.5. A light tilted by less than rounding is the same light. */
    const double exact = exp(-0.5) * -expm1(-1.5);
    assert_close(t_of(&box, up, 1.0, origin, along_x, INFINITY), exact, 1e-15);
    assert_close(t_of(&box, tilted, 1.0, origin, along_x, INFINITY), exact, 1e-15);
}

static void grazing_light_crosses_the_far_face_only_near_it(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double along_x[3] = {1.0, 0.0, 0.0};
    const double tilt = 1e-9, to_light[3] = {tilt, 0.0, sqrt(1.0 - tilt * tilt)};
    for (double z = -0.9; z < 1.0; z += 0.1003) {
        /* E = t + d up to the last stretch, of length tilt d, where d falls to 0. */
        const double origin[3] = {-0.47, 0.3, z}, d = (1.0 - z) / to_light[2], end = 1.47;
        const double skin = tilt * d, kink = end - skin;
        const double exact =
            exp(-d) * -expm1(-kink) + skin * exp(-end) * -expm1(-(d - skin)) / (d - skin);
        assert_close(t_of(&box, to_light, 1.0, origin, along_x, INFINITY), exact, 1e-14);
    }
}

static void without_extinction_the_integral_is_the_length(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 1);
    roomy_profile room;
    for (int i = 0; i < CASES; i++) {
        lit_ray r = random_lit_ray(&rng);
        air_interval stretch = {0.0, 0.0};
        (void)air_collimated_interval(&r.medium, r.origin, r.dir, r.t_max, &stretch);
        const double length = stretch.end - stretch.begin;
        air_collimated_profile *profile = roomy(&room);
        r.sigma_t = 0.0;
        make_profile(&r, profile);
        assert_true(air_collimated_integral(profile) == length);
        r.sigma_t = 1e-12; /* E is below 20 */
        make_profile(&r, profile);
        assert_close(air_collimated_integral(profile), length, 2e-11);
        assert_true(air_collimated_integral(profile) <= length);
    }
}

static void thick_media_shine_from_their_skin(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double origin[3] = {0.0, 0.0, 5.0}, down[3] = {0.0, 0.0, -1.0};
    const double to_light[3] = {0.6, 0.0, 0.8};
    /* E = t' + t'/0.8 at first: T = 1/(sigma (1 + 1/0.8)). */
    for (double sigma_t = 1e3; sigma_t < 1e15; sigma_t *= 10.0) {
        assert_close(t_of(&box, to_light, sigma_t, origin, down, INFINITY), 1.0 / (sigma_t * 2.25),
                     1e-14);
    }
}

static void optical_depths_that_underflow_keep_their_logarithm(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double origin[3] = {0.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0}, along_x[3] = {1.0, 0.0, 0.0};
    roomy_profile room;
    air_collimated_profile *profile = roomy(&room);
    air_collimated_profile_make(&box, up, 2000.0, origin, along_x, INFINITY, profile);
    assert_true(air_collimated_integral(profile) == 0.0);
    assert_close(air_collimated_log_integral(profile), -2000.0 - log(2000.0), 1e-15);
    /* Still exponential with rate 2000. */
    for (double u = 0.01; u < 1.0; u += 0.01) {
        assert_close(air_collimated_sample(profile, u), -log1p(-u) / 2000.0, 1e-13);
        assert_close(air_collimated_sample_pdf(profile, air_collimated_sample(profile, u)),
                     2000.0 * (1.0 - u), 1e-11); /* depths of 2000: 2000 epsilon */
    }
}

static void nothing_is_added_where_the_ray_crosses_a_lit_face(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(4, 1);
    roomy_profile room;
    int entered = 0, left = 0;
    for (int i = 0; i < CASES; i++) {
        lit_ray r = random_lit_ray(&rng);
        r.t_max = INFINITY;
        air_collimated_profile *profile = roomy(&room);
        make_profile(&r, profile);
        if (profile->count == 0) {
            continue;
        }
        const air_collimated_piece *first = profile->pieces, *last = first + profile->count - 1;
        for (size_t k = 0; k < r.medium.plane_count; k++) {
            const double *n = r.medium.planes[k];
            const double t = (n[3] - dot(n, r.origin)) / dot(n, r.dir);
            if (dot(n, r.to_light) > 0.0 && t == first->t0) {
                assert_true(first->depth0 == 0.0);
                entered++;
            }
            if (dot(n, r.to_light) > 0.0 && t == last->t1) {
                assert_true(last->depth1 == last->camera1);
                left++;
            }
        }
    }
    assert_true(entered > 20 && left > 20);
}

static void a_camera_on_a_face_sees_in_but_not_out(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double corner[3] = {1.0, 1.0, 1.0}, edge[3] = {1.0, 0.0, 1.0}, face[3] = {1.0, 0.0, 0.0};
    const double *const places[3] = {corner, edge, face};
    const double s = 1.0 / sqrt(3.0), in[3] = {-s, -s, -s}, out[3] = {s, s, s};
    const double along[3] = {0.0, 1.0, 0.0};
    for (int i = 0; i < 3; i++) {
        assert_true(t_of(&box, out, 1.0, places[i], out, INFINITY) == 0.0);
        assert_true(t_of(&box, in, 1.0, places[i], out, INFINITY) == 0.0);
        const double length = sqrt(3.0) * (i == 0 ? 2.0 : 1.0);
        assert_close(t_of(&box, out, 1.0, places[i], in, INFINITY), -0.5 * expm1(-2.0 * length),
                     1e-15);
    }
    /* Along the face itself, light through it: d = 0, E = t. */
    assert_close(t_of(&box, out, 1.0, face, along, INFINITY), -expm1(-1.0), 1e-15);
}

static void surfaces_end_the_stretch(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double origin[3] = {0.0, 0.0, 5.0}, down[3] = {0.0, 0.0, -1.0}, up[3] = {0.0, 0.0, 1.0};
    assert_true(t_of(&box, up, 1.0, origin, down, 3.0) == 0.0);
    assert_true(t_of(&box, up, 1.0, origin, down, 4.0) == 0.0);
    assert_close(t_of(&box, up, 1.0, origin, down, 4.5), -0.5 * expm1(-1.0), 1e-15);
    assert_true(t_of(&box, up, 1.0, origin, down, 6.0) == t_of(&box, up, 1.0, origin, down, 7.0));
    assert_true(t_of(&box, up, 1.0, origin, down, 0.0) == 0.0);
    assert_true(t_of(&box, up, 1.0, origin, down, -1.0) == 0.0);
}

static void media_without_end_have_finite_integrals(void **state)
{
    (void)state;
    air_collimated_medium half = {.plane_count = 1, .planes = {{0.0, 1.0, 0.0, 0.0}}};
    const double origin[3] = {3.0, -0.5, 2.0}, aside[3] = {1.0, 0.0, 0.0},
                 down[3] = {0.0, -1.0, 0.0};
    const double up[3] = {0.0, 1.0, 0.0};
    /* Level: E = t + 0.5; downwards: E = 2 t + 0.5. */
    assert_close(t_of(&half, up, 0.01, origin, aside, INFINITY), exp(-0.005) / 0.01, 1e-15);
    assert_close(t_of(&half, up, 0.01, origin, down, INFINITY), exp(-0.005) / 0.02, 1e-15);
    /* Lit from below: nothing arrives through fog without end. */
    assert_true(t_of(&half, down, 0.01, origin, aside, INFINITY) == 0.0);
    half.plane_count = 0;
    assert_true(t_of(&half, up, 0.01, origin, aside, INFINITY) == 0.0);
    assert_true(log_t_of(&half, up, 0.0, origin, aside, 7.0) == log(7.0));
    assert_true(t_of(&half, up, 0.0, origin, aside, INFINITY) == 0.0);
}

static void what_is_not_finite_gives_an_empty_profile(void **state)
{
    (void)state;
    const air_collimated_medium box = box_between(middle_low, middle_high);
    const double bad[3] = {NAN, INFINITY, -INFINITY};
    for (int number = 0; number < 11; number++) {
        for (int i = 0; i < 3; i++) {
            double values[11] = {0.0, 0.6, 0.8, 0.1, 0.2, 0.3, 0.8, 0.0, 0.6, 1.0, 10.0};
            roomy_profile room;
            air_collimated_profile *profile = roomy(&room);
            values[number] = bad[i];
            if (number == 10 && bad[i] == INFINITY) {
                continue; /* t_max may be */
            }
            air_collimated_profile_make(&box, values, values[9], values + 3, values + 6, values[10],
                                        profile);
            assert_true(profile->count == 0 && air_collimated_integral(profile) == 0.0);
            assert_true(air_collimated_log_integral(profile) == -INFINITY);
            assert_true(air_collimated_partial_integral(profile, 0.0, 1.0) == 0.0);
            assert_true(air_collimated_integrand(profile, 0.5) == 0.0);
            assert_true(air_collimated_sample_pdf(profile, 0.5) == 0.0);
            assert_true(air_collimated_sample_cdf(profile, 0.5) == 0.0);
        }
    }
}

static void parts_add_up(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 1);
    roomy_profile room, rest_room;
    for (int i = 0; i < 10 * CASES; i++) {
        const lit_ray r = random_lit_ray(&rng);
        air_collimated_profile *profile = roomy(&room), *rest = roomy(&rest_room);
        make_profile(&r, profile);
        if (profile->count == 0) {
            continue;
        }
        const double a = profile->pieces[0].t0, b = profile->pieces[profile->count - 1].t1;
        double cuts[4] = {a - 1.0, random_between(&rng, a, b), random_between(&rng, a, b), b + 1.0};
        if (cuts[1] > cuts[2]) {
            const double swapped = cuts[1];
            cuts[1] = cuts[2];
            cuts[2] = swapped;
        }
        /* 1e-12: depths up to 400 carry 400 epsilon. */
        const double whole = air_collimated_integral(profile);
        double sum = 0.0;
        for (int k = 0; k < 3; k++) {
            sum += air_collimated_partial_integral(profile, cuts[k], cuts[k + 1]);
        }
        assert_close(sum, whole, 1e-12);
        const air_interval lit[2] = {{cuts[0], cuts[1]}, {cuts[2], cuts[3]}};
        air_collimated_profile_restrict(profile, lit, 2, rest);
        assert_true(rest->count <= profile->count + 1);
        const double middle = air_collimated_partial_integral(profile, cuts[1], cuts[2]);
        assert_close(air_collimated_integral(rest) + middle, whole, 1e-12);
        const double t = 0.5 * (cuts[1] + cuts[2]);
        assert_true(air_collimated_integrand(rest, t) == 0.0);
        assert_close(air_collimated_integrand(rest, 0.5 * (a + cuts[1])),
                     air_collimated_integrand(profile, 0.5 * (a + cuts[1])), 1e-12);
    }
}

/* The rotation whose rows are given. */
static void turn(double rows[3][3], const double x[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = dot(rows[i], x);
    }
}

static void one_rigid_motion_of_everything_changes_nothing(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 1);
    for (int i = 0; i < 10 * CASES; i++) {
        const lit_ray r = random_lit_ray(&rng);
        lit_ray moved = r;
        double rows[3][3], shift[3];
        random_frame(&rng, rows);
        turn(rows, r.to_light, moved.to_light);
        turn(rows, r.dir, moved.dir);
        turn(rows, r.origin, moved.origin);
        for (int k = 0; k < 3; k++) {
            shift[k] = random_between(&rng, -5.0, 5.0);
            moved.origin[k] += shift[k];
        }
        for (size_t k = 0; k < r.medium.plane_count; k++) {
            turn(rows, r.medium.planes[k], moved.medium.planes[k]);
            moved.medium.planes[k][3] = r.medium.planes[k][3] + dot(moved.medium.planes[k], shift);
        }
        const double before = log_t_of(&r.medium, r.to_light, r.sigma_t, r.origin, r.dir, r.t_max);
        const double after =
            log_t_of(&moved.medium, moved.to_light, r.sigma_t, moved.origin, moved.dir, r.t_max);
        /* Distances of 10 carry 1e-15 of it, divided by n.l / |n| down to 1e-3, times sigma_t 20.
         */
        assert_true(before == after || fabs(before - after) < 1e-9);
    }
}

static void lengths_scale(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(7, 1);
    for (int i = 0; i < 10 * CASES; i++) {
        const lit_ray r = random_lit_ray(&rng);
        const double scale = exp(random_between(&rng, -8.0, 8.0));
        lit_ray scaled = r;
        for (int k = 0; k < 3; k++) {
            scaled.origin[k] *= scale;
        }
        for (size_t k = 0; k < r.medium.plane_count; k++) {
            scaled.medium.planes[k][3] *= scale;
        }
        scaled.t_max *= scale;
        scaled.sigma_t /= scale;
        const double before = log_t_of(&r.medium, r.to_light, r.sigma_t, r.origin, r.dir, r.t_max);
        const double after = log_t_of(&scaled.medium, scaled.to_light, scaled.sigma_t,
                                      scaled.origin, scaled.dir, scaled.t_max);
        /* As for rigid motions. */
        assert_true(before == after || fabs(before + log(scale) - after) < 1e-9);
    }
}

static void needless_planes_change_nothing(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(8, 1);
    for (int i = 0; i < 10 * CASES; i++) {
        const lit_ray r = random_lit_ray(&rng);
        lit_ray more = r;
        size_t *count = &more.medium.plane_count;
        for (size_t k = 0; k < r.medium.plane_count; k += 2) {
            const double length = random_between(&rng, 0.3, 3.0);
            for (int c = 0; c < 4; c++) { /* the same plane again */
                more.medium.planes[*count][c] = length * r.medium.planes[k][c];
            }
            (*count)++;
            memcpy(more.medium.planes[*count], r.medium.planes[k], 3 * sizeof(double));
            more.medium.planes[(*count)++][3] = r.medium.planes[k][3] + 0.1; /* and one outside */
        }
        const double before = log_t_of(&r.medium, r.to_light, r.sigma_t, r.origin, r.dir, r.t_max);
        const double after =
            log_t_of(&more.medium, r.to_light, r.sigma_t, r.origin, r.dir, r.t_max);
        /* As for rigid motions, of which only the rounding of the planes is left. */
        assert_true(before == after || fabs(before - after) < 1e-10);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_mean_transmittance_is_good_to_4_epsilon),
        cmocka_unit_test(the_integral_is_the_quadrature_of_the_definition),
        cmocka_unit_test(pieces_follow_each_other_and_depth_is_concave),
        cmocka_unit_test(looking_at_the_light_depth_is_constant),
        cmocka_unit_test(light_from_behind_has_the_two_way_form),
        cmocka_unit_test(a_face_along_the_light_stops_nothing),
        cmocka_unit_test(grazing_light_crosses_the_far_face_only_near_it),
        cmocka_unit_test(without_extinction_the_integral_is_the_length),
        cmocka_unit_test(thick_media_shine_from_their_skin),
        cmocka_unit_test(optical_depths_that_underflow_keep_their_logarithm),
        cmocka_unit_test(nothing_is_added_where_the_ray_crosses_a_lit_face),
        cmocka_unit_test(a_camera_on_a_face_sees_in_but_not_out),
        cmocka_unit_test(surfaces_end_the_stretch),
        cmocka_unit_test(media_without_end_have_finite_integrals),
        cmocka_unit_test(what_is_not_finite_gives_an_empty_profile),
        cmocka_unit_test(parts_add_up),
        cmocka_unit_test(one_rigid_motion_of_everything_changes_nothing),
        cmocka_unit_test(lengths_scale),
        cmocka_unit_test(needless_planes_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Profiles through piecewise constant media: against quadrature of the definition, against one
 * medium, by hand where the depth jumps. */
#include "cmocka_test.h"
#include "collimated_fixture.h"

enum { MOST_CELLS = 6 };

static const double up[3] = {0.0, 0.0, 1.0}, along_x[3] = {1.0, 0.0, 0.0};

static void assert_close(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected))) {
        fail_msg("%.17g instead of %.17g, relative error %.3g", value, expected,
                 fabs(value - expected) / fabs(expected));
    }
}

static air_collimated_cell box_cell(double x0, double y0, double z0, double x1, double y1,
                                    double z1, double sigma_t, double weight)
{
    const double low[3] = {x0, y0, z0}, high[3] = {x1, y1, z1};
    return (air_collimated_cell){box_between(low, high), sigma_t, weight};
}

static void make(const lit_cells *r, air_collimated_profile *profile)
{
    air_collimated_profile_make_cells(r->cells, r->count, r->to_light, r->origin, r->dir, r->t_max,
                                      profile);
}

static double integral_of(const lit_cells *r)
{
    roomy_profile room;
    make(r, roomy(&room));
    return air_collimated_integral(&room.profile);
}

/* A ray through the neighbourhood of the origin. */
static void random_ray(air_rng *rng, lit_cells *out)
{
    double target[3];
    for (int i = 0; i < 3; i++) {
        target[i] = random_between(rng, -1.0, 1.0);
    }
    random_direction(rng, out->to_light);
    random_direction(rng, out->dir);
    move_along(target, out->dir, air_rng_next(rng) % 2u == 0 ? 0.0 : -random_between(rng, 0.0, 8.0),
               out->origin);
    out->t_max = air_rng_next(rng) % 3u == 0 ? random_between(rng, 0.1, 8.0) : INFINITY;
}

static double to_infinity(const lit_cells *r) { return r->t_max < INFINITY ? r->t_max : 40.0; }

static size_t random_cells(air_rng *rng, air_collimated_cell cells[MOST_CELLS])
{
    const size_t count = 1 + air_rng_next(rng) % MOST_CELLS;
    for (size_t i = 0; i < count; i++) {
        double centre[3];
        for (int k = 0; k < 3; k++) {
            centre[k] = random_between(rng, -1.5, 1.5);
        }
        const uint32_t kind = air_rng_next(rng) % 8u;
        cells[i].medium = random_polyhedron(rng, 6 + air_rng_next(rng) % 6u, centre);
        cells[i].sigma_t = kind == 0 ? 0.0 : random_between(rng, 0.01, 2.0);
        cells[i].weight = kind == 1 ? 0.0 : random_between(rng, 0.1, 2.0);
    }
    return count;
}

static void overlapping_polyhedra_match_quadrature_of_the_definition(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 2);
    for (int n = 0; n < 300; n++) {
        air_collimated_cell cells[MOST_CELLS];
        lit_cells r = {.cells = cells, .count = random_cells(&rng, cells)};
        random_ray(&rng, &r);
        /* Cells lie within 40 of the origin of any ray. Depths reach 50 and carry 1e-14 of
         * themselves, times the ill condition of thin overlaps, which the quadrature has too. */
        const double exact = integrate_cells(&r, 0.0, to_infinity(&r));
        assert_close(integral_of(&r), exact, 1e-10);
    }
}

static void the_integrand_is_the_definition(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 2);
    roomy_profile room;
    int positive = 0;
    for (int n = 0; n < 2000; n++) {
        air_collimated_cell cells[MOST_CELLS];
        lit_cells r = {.cells = cells, .count = random_cells(&rng, cells)};
        random_ray(&rng, &r);
        make(&r, roomy(&room));
        const double t = random_between(&rng, 0.0, fmin(r.t_max, 4.0));
        const double exact = cells_integrand(&r, t);
        assert_close(air_collimated_integrand(&room.profile, t), exact, 1e-11);
        positive += exact > 0.0;
    }
    assert_true(positive > 300);
}

static void one_cell_is_one_medium(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 2);
    roomy_profile room;
    for (int n = 0; n < 3000; n++) {
        const lit_ray one = random_lit_ray(&rng);
        const air_collimated_cell cell = {one.medium, one.sigma_t, 1.0};
        lit_cells r = {.cells = &cell, .count = 1, .t_max = one.t_max};
        memcpy(r.to_light, one.to_light, sizeof r.to_light);
        memcpy(r.origin, one.origin, sizeof r.origin);
        memcpy(r.dir, one.dir, sizeof r.dir);
        make_profile(&one, roomy(&room));
        const double log_one = air_collimated_log_integral(&room.profile);
        make(&r, roomy(&room));
        const double log_cell = air_collimated_log_integral(&room.profile);
        /* Depths up to 400, with their rounding. */
        assert_true(log_one == log_cell || fabs(log_one - log_cell) < 1e-10);
    }
}

/* Cuts every cell in two by a plane through the origin. */
static size_t cut_cells(air_rng *rng, air_collimated_cell *cells, size_t count)
{
    double n[3];
    random_direction(rng, n);
    for (size_t i = 0; i < count; i++) {
        air_collimated_cell *near = &cells[i], *far = &cells[count + i];
        *far = *near;
        for (int k = 0; k < 3; k++) {
            near->medium.planes[near->medium.plane_count][k] = n[k];
            far->medium.planes[far->medium.plane_count][k] = -n[k];
        }
        near->medium.planes[near->medium.plane_count++][3] = 0.1;
        far->medium.planes[far->medium.plane_count++][3] = -0.1;
    }
    return 2 * count;
}

static void a_box_in_pieces_is_the_box(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(4, 2);
    for (int n = 0; n < 500; n++) {
        air_collimated_cell cells[16] = {box_cell(-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 0.8, 1.0)};
        lit_cells r = {.cells = cells, .count = 1};
        random_ray(&rng, &r);
        const double whole = integral_of(&r);
        for (int k = 0; k < 4; k++) {
            r.count = cut_cells(&rng, cells, r.count);
        }
        /* Sixteen cells of 10 planes, some empty; the cuts move the depth by their rounding. */
        assert_close(integral_of(&r), whole, 1e-11);
    }
}

static void shares_of_a_box_add_up_to_it(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 2);
    for (int n = 0; n < 300; n++) {
        air_collimated_cell cells[4];
        lit_cells r = {.cells = cells, .count = 1};
        cells[0] = box_cell(-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 0.8, 1.0);
        random_ray(&rng, &r);
        const double whole = integral_of(&r);
        for (int i = 0; i < 4; i++) {
            cells[i] = box_cell(-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 0.2, 0.25);
        }
        r.count = 4;
        assert_close(integral_of(&r), whole, 1e-13);
    }
}

static void the_order_of_cells_does_not_matter(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 2);
    for (int n = 0; n < 500; n++) {
        air_collimated_cell cells[MOST_CELLS], reversed[MOST_CELLS];
        lit_cells r = {.cells = cells, .count = random_cells(&rng, cells)};
        random_ray(&rng, &r);
        const double forth = integral_of(&r);
        for (size_t i = 0; i < r.count; i++) {
            reversed[i] = cells[r.count - 1 - i];
        }
        r.cells = reversed;
        assert_close(integral_of(&r), forth, 1e-12);
    }
}

static void slab_stacks_match_quadrature(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(7, 2);
    for (int n = 0; n < 200; n++) {
        air_collimated_cell cells[5];
        double floor = -1.5;
        lit_cells r = {.cells = cells, .count = 5};
        for (int i = 0; i < 5; i++) {
            const double roof = floor + random_between(&rng, 0.1, 1.0);
            cells[i] = box_cell(-2.0, -2.0, floor, 2.0, 2.0, roof, random_between(&rng, 0.0, 3.0),
                                random_between(&rng, 0.0, 1.0));
            floor = roof;
        }
        random_ray(&rng, &r);
        if (n % 4 == 0) { /* along the slabs: depths jump at their walls */
            memcpy(r.to_light, n % 8 == 0 ? along_x : up, sizeof r.to_light);
        }
        assert_close(integral_of(&r), integrate_cells(&r, 0.0, to_infinity(&r)), 1e-10);
    }
}

static void depth_jumps_exactly_at_walls_along_the_light(void **state)
{
    (void)state;
    const air_collimated_cell cells[2] = {box_cell(0.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
                                          box_cell(1.0, -1.0, -1.0, 2.0, 1.0, 3.0, 5.0, 2.0)};
    const lit_cells r = {.cells = cells,
                         .count = 2,
                         .to_light = {0.0, 0.0, 1.0},
                         .origin = {-1.0, 0.0, 0.5},
                         .dir = {1.0, 0.0, 0.0},
                         .t_max = INFINITY};
    roomy_profile room;
    make(&r, roomy(&room));
    /* x in [0, 1]: E = x + 0.5. x in [1, 2]: E = 1 + 5 (x - 1) + 5 * 2.5. */
    assert_int_equal(room.profile.count, 2);
    assert_true(room.pieces[0].t0 == 1.0 && room.pieces[0].t1 == 2.0 && room.pieces[1].t1 == 3.0);
    assert_true(room.pieces[0].depth0 == 0.5 && room.pieces[0].depth1 == 1.5);
    assert_true(room.pieces[1].depth0 == 13.5 && room.pieces[1].depth1 == 18.5);
    assert_true(room.pieces[1].camera0 == 1.0 && room.pieces[1].camera1 == 6.0);
    assert_close(air_collimated_integral(&room.profile),
                 exp(-0.5) * -expm1(-1.0) + 2.0 * exp(-13.5) * -expm1(-5.0) / 5.0, 1e-15);
}

static void cells_without_weight_only_shade(void **state)
{
    (void)state;
    /* A roof above half of the box, and a curtain before it. */
    const air_collimated_cell cells[3] = {box_cell(0.0, -1.0, -1.0, 2.0, 1.0, 1.0, 0.5, 1.0),
                                          box_cell(1.0, -1.0, 4.0, 5.0, 1.0, 4.5, 2.0, 0.0),
                                          box_cell(-0.5, -1.0, -1.0, -0.25, 1.0, 1.0, 4.0, 0.0)};
    const lit_cells r = {.cells = cells,
                         .count = 3,
                         .to_light = {0.0, 0.0, 1.0},
                         .origin = {-1.0, 0.0, 0.0},
                         .dir = {1.0, 0.0, 0.0},
                         .t_max = INFINITY};
    roomy_profile room;
    make(&r, roomy(&room));
    /* Depth: curtain 1, way up 0.5, roof 1. */
    assert_int_equal(room.profile.count, 2);
    assert_close(air_collimated_integral(&room.profile),
                 exp(-1.5) * -expm1(-0.5) / 0.5 * (1.0 + exp(-0.5) * exp(-1.0)), 1e-15);
}

static void an_l_of_two_boxes_matches_quadrature(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(8, 2);
    const air_collimated_cell cells[2] = {box_cell(-1.0, -1.0, -1.0, 1.0, 0.0, 1.0, 0.7, 1.0),
                                          box_cell(-1.0, 0.0, -1.0, 0.0, 1.0, 1.0, 0.7, 1.0)};
    for (int n = 0; n < 300; n++) {
        lit_cells r = {.cells = cells, .count = 2};
        random_ray(&rng, &r);
        assert_close(integral_of(&r), integrate_cells(&r, 0.0, to_infinity(&r)), 1e-11);
    }
}

static void fog_without_end_towards_the_light_is_dark_only_below_it(void **state)
{
    (void)state;
    /* Fog for x < 1 reaches up for ever; beyond x = 1 the box alone. */
    air_collimated_cell cells[2] = {box_cell(0.0, -1.0, -1.0, 2.0, 1.0, 1.0, 0.5, 1.0)};
    cells[1] =
        (air_collimated_cell){{.plane_count = 1, .planes = {{1.0, 0.0, 0.0, 1.0}}}, 0.25, 1.0};
    lit_cells r = {.cells = cells,
                   .count = 2,
                   .to_light = {0.0, 0.0, 1.0},
                   .origin = {-1.0, 0.0, 0.0},
                   .dir = {1.0, 0.0, 0.0},
                   .t_max = INFINITY};
    roomy_profile room;
    make(&r, roomy(&room));
    /* 2 m of the fog and 1 m of the box before, 1 m of the box above. */
    assert_int_equal(room.profile.count, 1);
    assert_close(air_collimated_integral(&room.profile),
                 exp(-0.25 * 2.0 - 0.5 - 0.5) * -expm1(-0.5) / 0.5, 1e-15);
    r.cells = cells + 1;
    r.count = 1;
    assert_true(integral_of(&r) == 0.0);
    cells[1].sigma_t = 0.0; /* without extinction it is as bright as it is long */
    assert_true(integral_of(&r) == 2.0);
    cells[1].medium.plane_count = 0;
    assert_true(integral_of(&r) == 0.0); /* and without end of no use */
}

static void fog_without_end_along_the_ray_has_a_finite_integral(void **state)
{
    (void)state;
    /* Ground fog up to z = 1, a box in it. */
    const air_collimated_cell cells[2] = {
        {{.plane_count = 1, .planes = {{0.0, 0.0, 2.0, 2.0}}}, 0.01, 1.0},
        box_cell(2.0, -1.0, -1.0, 4.0, 1.0, 0.5, 0.5, 3.0)};
    const lit_cells r = {.cells = cells,
                         .count = 2,
                         .to_light = {0.0, 0.0, 1.0},
                         .origin = {0.0, 0.0, 0.0},
                         .dir = {1.0, 0.0, 0.0},
                         .t_max = INFINITY};
    const double before = exp(-0.01) * -expm1(-0.02) / 0.01;
    const double within = 4.0 * exp(-0.01 - 0.02 - 0.25) * -expm1(-1.02) / 0.51;
    const double after = exp(-0.01 - 0.04 - 1.0) / 0.01;
    assert_close(integral_of(&r), before + within + after, 1e-14);
}

static void the_piece_limit_holds(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(9, 2);
    size_t most = 0;
    for (int n = 0; n < 5000; n++) {
        air_collimated_cell cells[MOST_CELLS];
        lit_cells r = {.cells = cells, .count = random_cells(&rng, cells)};
        random_ray(&rng, &r);
        r.t_max = INFINITY;
        const size_t limit = air_collimated_cells_piece_limit(cells, r.count);
        const air_collimated_piece unused = {.t0 = -7.0, .weight = -8.0};
        roomy_profile room;
        air_collimated_profile *profile = roomy(&room);
        room.pieces[limit] = unused;
        profile->capacity = limit;
        make(&r, profile);
        assert_true(profile->count < limit);
        assert_true(room.pieces[limit].t0 == -7.0 && room.pieces[limit].weight == -8.0);
        most = profile->count > most ? profile->count : most;
        for (size_t k = 0; k < profile->count; k++) {
            const air_collimated_piece *p = &profile->pieces[k];
            assert_true(p->weight > 0.0 && p->t0 < p->t1 && p->depth0 >= p->camera0);
            assert_true(k == 0 || p->t0 >= p[-1].t1);
        }
    }
    assert_true(most > 20);
    assert_int_equal(air_collimated_cells_piece_limit(NULL, 0), 0);
}

static void samples_invert_the_distribution(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(10, 2);
    roomy_profile room;
    for (int n = 0; n < 1000; n++) {
        air_collimated_cell cells[MOST_CELLS];
        lit_cells r = {.cells = cells, .count = random_cells(&rng, cells)};
        random_ray(&rng, &r);
        make(&r, roomy(&room));
        for (int k = 0; k < 20 && room.profile.count > 0; k++) {
            const double u = random_unit(&rng), t = air_collimated_sample(&room.profile, u);
            assert_true(fabs(air_collimated_sample_cdf(&room.profile, t) - u) < 1e-11);
        }
    }
}

static void bad_numbers_and_empty_media_give_an_empty_profile(void **state)
{
    (void)state;
    roomy_profile room;
    air_collimated_cell cells[2] = {box_cell(0.0, -1.0, -1.0, 2.0, 1.0, 1.0, 0.5, 1.0),
                                    box_cell(1.0, -1.0, -1.0, 0.0, 1.0, 1.0, 0.5, 1.0)};
    lit_cells r = {.cells = cells + 1,
                   .count = 1,
                   .to_light = {0.0, 0.0, 1.0},
                   .origin = {-1.0, 0.0, 0.0},
                   .dir = {1.0, 0.0, 0.0},
                   .t_max = INFINITY};
    assert_true(integral_of(&r) == 0.0); /* turned inside out */
    r.count = 0;
    assert_true(integral_of(&r) == 0.0);
    r.cells = cells;
    r.count = 2;
    assert_true(integral_of(&r) > 0.0);
    double *const numbers[] = {&r.t_max,       &r.origin[1],      &r.dir[2],
                               &r.to_light[0], &cells[1].sigma_t, &cells[0].weight};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        const double kept = *numbers[i];
        *numbers[i] = NAN;
        make(&r, roomy(&room));
        assert_true(room.profile.count == 0 && air_collimated_integral(&room.profile) == 0.0);
        *numbers[i] = i == 0 ? -1.0 : -INFINITY;
        make(&r, roomy(&room));
        assert_true(room.profile.count == 0);
        *numbers[i] = kept;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(overlapping_polyhedra_match_quadrature_of_the_definition),
        cmocka_unit_test(the_integrand_is_the_definition),
        cmocka_unit_test(one_cell_is_one_medium),
        cmocka_unit_test(a_box_in_pieces_is_the_box),
        cmocka_unit_test(shares_of_a_box_add_up_to_it),
        cmocka_unit_test(the_order_of_cells_does_not_matter),
        cmocka_unit_test(slab_stacks_match_quadrature),
        cmocka_unit_test(depth_jumps_exactly_at_walls_along_the_light),
        cmocka_unit_test(cells_without_weight_only_shade),
        cmocka_unit_test(an_l_of_two_boxes_matches_quadrature),
        cmocka_unit_test(fog_without_end_towards_the_light_is_dark_only_below_it),
        cmocka_unit_test(fog_without_end_along_the_ray_has_a_finite_integral),
        cmocka_unit_test(the_piece_limit_holds),
        cmocka_unit_test(samples_invert_the_distribution),
        cmocka_unit_test(bad_numbers_and_empty_media_give_an_empty_profile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Shadows of balls and convex polyhedra along rays, against their meaning: a point is in shadow iff
 * the ray from it towards the light meets the body. */
#include <stdio.h>

#include "airlight/shadow.h"
#include "cmocka_test.h"
#include "collimated_fixture.h"

enum { STEPS = 64 };

typedef struct shadow_ray {
    double to_light[3], origin[3], dir[3], begin, end;
} shadow_ray;

/* Within 10 m of the origin: looking at anything near it, or with, against and nearly along the
 * light. */
static shadow_ray random_ray(air_rng *rng, int kind)
{
    static const double nudges[] = {0.0, 1e-15, 1e-12, 1e-9, 1e-5};
    shadow_ray out;
    double target[3];
    random_direction(rng, out.to_light);
    random_direction(rng, out.dir);
    for (int k = 0; k < 3; k++) {
        target[k] = random_between(rng, -2.0, 2.0);
        if (kind % 4 > 1) {
            const double along = kind % 4 == 2 ? out.to_light[k] : -out.to_light[k];
            out.dir[k] = along + nudges[kind / 4 % 5] * out.dir[k];
        }
    }
    if (kind % 4 > 1 && kind / 4 % 5 > 0) {
        normalise(out.dir);
    }
    move_along(target, out.dir, kind % 3 == 0 ? 0.0 : -random_between(rng, 0.0, 5.0), out.origin);
    out.begin = random_between(rng, -2.0, 3.0);
    out.end = out.begin + random_between(rng, 0.0, 8.0);
    return out;
}

/* How deep x is in the shadow of a ball, in metres; negative outside. */
static double ball_depth(const double centre[3], double radius, const double l[3],
                         const double x[3])
{
    double to[3], foot[3];
    for (int k = 0; k < 3; k++) {
        to[k] = centre[k] - x[k];
    }
    move_along(to, l, -fmax(0.0, dot(to, l)), foot);
    return radius - sqrt(dot(foot, foot));
}

/* The same for a polyhedron, along the light: the length of the ray towards the light inside, or
 * how much is missing. */
static double polyhedron_depth(const air_collimated_medium *p, const double l[3], const double x[3])
{
    double enter = 0.0, leave = INFINITY;
    for (size_t k = 0; k < p->plane_count; k++) {
        const double *n = p->planes[k], nl = dot(n, l), s = (n[3] - dot(n, x)) / nl;
        enter = nl < 0.0 ? fmax(enter, s) : enter;
        leave = nl > 0.0 ? fmin(leave, s) : leave;
    }
    return leave - enter;
}

static double steepness(const air_collimated_medium *p, const double l[3])
{
    double least = 1.0;
    for (size_t k = 0; k < p->plane_count; k++) {
        const double *n = p->planes[k];
        least = fmin(least, fabs(dot(n, l)) / sqrt(dot(n, n)));
    }
    return least;
}

/* Points along the ray are in the interval iff they are in shadow, unless their depth is rounding.
 * Gives how many are in shadow. */
typedef double depth_function(const void *body, const double l[3], const double x[3]);

static int check_points(const shadow_ray *r, bool found, air_interval s, depth_function *depth,
                        const void *body, double rounding)
{
    int shadowed = 0;
    assert_true(!found || (r->begin <= s.begin && s.begin < s.end && s.end <= r->end));
    for (int i = 0; i <= STEPS; i++) {
        double x[3];
        const double t = r->begin + (r->end - r->begin) * i / STEPS;
        move_along(r->origin, r->dir, t, x);
        const double d = depth(body, r->to_light, x);
        const bool inside = found && t >= s.begin && t <= s.end;
        if (inside != (d >= 0.0) && fabs(d) > rounding) {
            print_error("at %.17g: depth %g, interval %d [%.17g, %.17g]\n", t, d, (int)found,
                        s.begin, s.end);
            fail();
        }
        shadowed += inside;
    }
    return shadowed;
}

typedef struct ball {
    double centre[3], radius;
} ball;

static double depth_in_ball(const void *body, const double l[3], const double x[3])
{
    const ball *b = body;
    return ball_depth(b->centre, b->radius, l, x);
}

static double depth_in_polyhedron(const void *body, const double l[3], const double x[3])
{
    return polyhedron_depth(body, l, x);
}

/* Coordinates are below 16 m: an ulp is 1.8e-15, and a depth takes some ten operations on either
 * side. */
static const double point_rounding = 32.0 * 1.8e-15;

static void a_ball_shadows_what_sees_it_towards_the_light(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(12, 1);
    int shadowed = 0;
    for (int i = 0; i < 20000; i++) {
        const shadow_ray r = random_ray(&rng, i);
        ball b = {.radius = exp(random_between(&rng, log(0.05), log(3.0)))};
        air_interval s = {0.0, 0.0};
        for (int k = 0; k < 3; k++) {
            b.centre[k] = random_between(&rng, -2.0, 2.0);
        }
        const bool found =
            air_shadow_sphere(b.centre, b.radius, r.to_light, r.origin, r.dir, r.begin, r.end, &s);
        shadowed += check_points(&r, found, s, depth_in_ball, &b, point_rounding);
    }
    assert_in_range(shadowed, 100000, 1000000); /* of 1,300,000 */
}

static bool polyhedron_shadow(const air_collimated_medium *p, const shadow_ray *r,
                              air_interval *out)
{
    return air_shadow_polyhedron((const double(*)[4])p->planes, p->plane_count, r->to_light,
                                 r->origin, r->dir, r->begin, r->end, out);
}

static void check_polyhedra(size_t least_planes, size_t most_planes, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(12, seed);
    int shadowed = 0;
    for (int i = 0; i < 20000; i++) {
        const shadow_ray r = random_ray(&rng, i);
        double centre[3];
        air_interval s = {0.0, 0.0};
        for (int k = 0; k < 3; k++) {
            centre[k] = random_between(&rng, -2.0, 2.0);
        }
        const size_t planes = least_planes + (size_t)i % (most_planes - least_planes + 1);
        const air_collimated_medium p = random_polyhedron(&rng, planes, centre);
        const bool found = polyhedron_shadow(&p, &r, &s);
        /* Along the light distances from planes grow by 1 / n.l. */
        shadowed += check_points(&r, found, s, depth_in_polyhedron, &p,
                                 point_rounding / steepness(&p, r.to_light));
    }
    assert_in_range(shadowed, 100000, 1000000);
}

static void a_box_shadows_what_sees_it_towards_the_light(void **state)
{
    (void)state;
    check_polyhedra(6, 6, 2);
}

static void polyhedra_shadow_what_sees_them_towards_the_light(void **state)
{
    (void)state;
    check_polyhedra(7, 24, 3);
}

/* Light along faces, and a ray along the light, where whole planes drop out. */
static void light_along_the_faces_of_a_box_casts_its_outline(void **state)
{
    (void)state;
    const double low[3] = {-1.0, -1.0, 0.0}, high[3] = {1.0, 1.0, 1.0};
    const air_collimated_medium box = box_between(low, high);
    shadow_ray r = {
        .to_light = {0.0, 0.0, 1.0}, .origin = {-3.0, 0.5, -2.0}, .dir = {1.0, 0.0, 0.0}, .end = 9};
    air_interval s;
    assert_true(polyhedron_shadow(&box, &r, &s));
    assert_true(s.begin == 2.0 && s.end == 4.0);
    r.origin[2] = 1.5; /* above it */
    assert_false(polyhedron_shadow(&box, &r, &s));
    r = (shadow_ray){
        .to_light = {0.0, 0.0, 1.0}, .origin = {0.5, 0.5, 4.0}, .dir = {0.0, 0.0, -1.0}, .end = 9};
    assert_true(polyhedron_shadow(&box, &r, &s)); /* down its middle */
    assert_true(s.begin == 3.0 && s.end == 9.0);
    r.origin[0] = 1.5; /* beside it */
    assert_false(polyhedron_shadow(&box, &r, &s));
    const double low2[3] = {2.0, -1.0, 0.0}, high2[3] = {1.0, 1.0, 1.0}; /* inside out */
    const air_collimated_medium nothing = box_between(low2, high2);
    assert_false(polyhedron_shadow(&nothing, &r, &s));
}

/* Exact: planes that decide nothing are never the first or last to be met. */
static void redundant_planes_change_nothing(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(12, 4);
    int found = 0;
    for (int i = 0; i < 5000; i++) {
        const shadow_ray r = random_ray(&rng, 4 * i);
        const double centre[3] = {0.0, 0.0, 0.0};
        const air_collimated_medium p = random_polyhedron(&rng, 8, centre);
        air_collimated_medium more = p;
        air_interval s, t;
        memcpy(more.planes[8], p.planes[3], sizeof p.planes[3]);
        random_direction(&rng, more.planes[9]);
        more.planes[9][3] = 5.0; /* the cube about p has its corners below 2.6 */
        more.plane_count = 10;
        const bool shadowed = polyhedron_shadow(&p, &r, &s);
        assert_int_equal(polyhedron_shadow(&more, &r, &t), shadowed);
        if (shadowed) {
            assert_true(t.begin == s.begin && t.end == s.end);
            found++;
        }
    }
    assert_true(found > 1000);
}

/* A dodecahedron about a ball casts a larger shadow, and a smaller one than the ball about it: its
 * circumradius is sqrt(3) sqrt(1 + g^2) / (1 + g) times the radius of its inscribed ball. */
static void a_dodecahedron_lies_between_two_balls(void **state)
{
    (void)state;
    const double g = 0.5 + 0.5 * sqrt(5.0), outer = sqrt(3.0) * sqrt(1.0 + g * g) / (1.0 + g);
    const double centre[3] = {0.0, 0.0, 0.0};
    air_collimated_medium p = {.plane_count = 12};
    air_rng rng = air_rng_from_keys(12, 5);
    int found = 0;
    for (int k = 0; k < 12; k++) {
        p.planes[k][(k / 4 + 1) % 3] = k % 2 == 0 ? 1.0 : -1.0;
        p.planes[k][(k / 4 + 2) % 3] = k / 2 % 2 == 0 ? g : -g;
        p.planes[k][3] = sqrt(1.0 + g * g);
    }
    for (int i = 0; i < 5000; i++) {
        const shadow_ray r = random_ray(&rng, i);
        air_interval least, s, most;
        if (air_shadow_sphere(centre, 1.0, r.to_light, r.origin, r.dir, r.begin, r.end, &least)) {
            assert_true(polyhedron_shadow(&p, &r, &s));
            assert_true(air_shadow_sphere(centre, outer, r.to_light, r.origin, r.dir, r.begin,
                                          r.end, &most));
            /* The balls touch the solid at single points only: room for rounding there, where a
             * lateral 1e-15 is 3e-8 of t at worst and far less at these rays. */
            const double room = 1e-9;
            assert_true(most.begin <= s.begin + room && s.begin <= least.begin + room);
            assert_true(most.end >= s.end - room && s.end >= least.end - room);
            found++;
        }
    }
    assert_true(found > 1000);
}

static void what_is_not_finite_is_not_in_shadow(void **state)
{
    (void)state;
    const double centre[3] = {0.0, 0.0, 0.0}, l[3] = {0.0, 0.0, 1.0};
    const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};
    const air_collimated_medium box = box_between(low, high);
    static const double bad[2] = {NAN, INFINITY};
    for (int i = 0; i < 16; i++) {
        air_interval s;
        shadow_ray r = {.to_light = {0.0, 0.0, 1.0}, .dir = {1.0, 0.0, 0.0}, .end = 9.0};
        double *fields[8] = {&r.origin[0], &r.origin[1], &r.origin[2],   &r.dir[0],
                             &r.dir[1],    &r.dir[2],    &r.to_light[2], &r.begin};
        assert_true(polyhedron_shadow(&box, &r, &s));
        assert_true(air_shadow_sphere(centre, 1.0, l, r.origin, r.dir, r.begin, r.end, &s));
        *fields[i / 2] = bad[i % 2];
        assert_false(polyhedron_shadow(&box, &r, &s));
        assert_false(
            air_shadow_sphere(centre, 1.0, r.to_light, r.origin, r.dir, r.begin, r.end, &s));
    }
}

/* Scene A: a black sphere in a box of fog, seen from (0.5, 1, 3.5) under 40 degrees. */
typedef struct pixel_oracle {
    int x, y;
    double begin, end; /* 0, 0: none */
    double integral;
} pixel_oracle;

static const pixel_oracle oracles[] = {
    {128, 128, 3.07558658287, 3.27969431227, 0.140540390403},
    {180, 150, 2.92491431385, 3.91941037685, 0.141533921419},
    {110, 90, 0.0, 0.0, 0.258461129085},
    {40, 60, 0.0, 0.0, 0.548961662825},
    {200, 50, 0.0, 0.0, 0.693721124032},
    {128, 200, 0.0, 0.0, 0.119128203081},
};

static void pixel_direction(int x, int y, const double eye[3], double out[3])
{
    const double up[3] = {0.0, 1.0, 0.0}, half = tan(20.0 * 3.14159265358979323846 / 180.0);
    double f[3] = {-eye[0], -eye[1], -eye[2]}, right[3], above[3];
    normalise(f);
    cross(f, up, right);
    normalise(right);
    cross(right, f, above);
    for (int k = 0; k < 3; k++) {
        out[k] = f[k] + (2.0 * (x + 0.5) / 256.0 - 1.0) * half * right[k] +
                 (1.0 - 2.0 * (y + 0.5) / 256.0) * half * above[k];
    }
    normalise(out);
}

static void pixels_of_scene_a_have_their_shadows_and_integrals(void **state)
{
    (void)state;
    const double low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0}, eye[3] = {0.5, 1.0, 3.5};
    const double centre[3] = {0.2, 0.4, 0.0}, radius = 0.5;
    const air_collimated_medium box = box_between(low, high);
    double to_light[3] = {-0.3, 0.6, -0.3};
    normalise(to_light);
    for (size_t i = 0; i < sizeof oracles / sizeof *oracles; i++) {
        const pixel_oracle *o = &oracles[i];
        double dir[3], w[3], lit_sum = 0.0, t_max = INFINITY;
        air_interval stretch, shadow, lit[2];
        pixel_direction(o->x, o->y, eye, dir);
        for (int k = 0; k < 3; k++) {
            w[k] = eye[k] - centre[k];
        }
        const double b = dot(w, dir), c = dot(w, w) - radius * radius;
        t_max = b * b > c ? -b - sqrt(b * b - c) : t_max;
        assert_true(air_collimated_interval(&box, eye, dir, t_max, &stretch));
        const bool found = air_shadow_sphere(centre, radius, to_light, eye, dir, stretch.begin,
                                             stretch.end, &shadow);
        assert_int_equal(found, o->end > 0.0);
        if (found) { /* given to 11 digits after the point: half of the last one */
            assert_true(fabs(shadow.begin - o->begin) < 6e-12);
            assert_true(fabs(shadow.end - o->end) < 6e-12);
        }
        roomy_profile store;
        air_collimated_profile *profile = roomy(&store);
        air_collimated_profile_make(&box, to_light, 1.0, eye, dir, t_max, profile);
        const size_t count =
            air_intervals_gaps(&shadow, found ? 1 : 0, stretch.begin, stretch.end, lit);
        for (size_t k = 0; k < count; k++) {
            lit_sum += air_collimated_partial_integral(profile, lit[k].begin, lit[k].end);
        }
        assert_true(fabs(lit_sum - o->integral) < 6e-13); /* 12 digits */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_shadows_what_sees_it_towards_the_light),
        cmocka_unit_test(a_box_shadows_what_sees_it_towards_the_light),
        cmocka_unit_test(polyhedra_shadow_what_sees_them_towards_the_light),
        cmocka_unit_test(light_along_the_faces_of_a_box_casts_its_outline),
        cmocka_unit_test(redundant_planes_change_nothing),
        cmocka_unit_test(a_dodecahedron_lies_between_two_balls),
        cmocka_unit_test(what_is_not_finite_is_not_in_shadow),
        cmocka_unit_test(pixels_of_scene_a_have_their_shadows_and_integrals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

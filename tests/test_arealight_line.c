/* Quadrature and sampling along rays, and the table of Gauss' rules. */
#include "arealight/gauss.h"
#include "arealight_fixture.h"
#include "chi_square.h"
#include "cmocka_test.h"

/* 2 x 1 m at height 2, shining down. */
static air_area_lamp make_lamp(bool two_sided)
{
    const double vertices[4][3] = {
        {-1.0, -0.5, 2.0}, {-1.0, 0.5, 2.0}, {1.0, 0.5, 2.0}, {1.0, -0.5, 2.0}};
    air_area_lamp lamp;
    assert_int_equal(air_area_lamp_make(NULL, vertices, 4, two_sided, &lamp), AIR_OK);
    assert_true(lamp.normal[2] == -1.0);
    return lamp;
}

static void small_rules_are_cores(void **state)
{
    (void)state;
    double nodes[64], weights[64], core_nodes[64], core_weights[64];
    for (size_t n = 1; n <= 40; n++) {
        air_area_gauss(n, nodes, weights);
        air_gauss_legendre(n, core_nodes, core_weights);
        for (size_t i = 0; i < n; i++) {
            /* Core's weights have the errors of a polynomial of degree n and its derivative. */
            assert_true(fabs(nodes[i] - core_nodes[i]) < 1e-15);
            assert_true(fabs(weights[i] - core_weights[i]) < 1e-13);
        }
    }
}

static void rays_are_lit_in_front(void **state)
{
    (void)state;
    const air_area_lamp lamp = make_lamp(false), both = make_lamp(true);
    const double below[3] = {0.0, 0.0, 0.5}, above[3] = {0.0, 0.0, 3.0}, up[3] = {0.0, 0.0, 1.0},
                 down[3] = {0.0, 0.0, -1.0}, level[3] = {1.0, 0.0, 0.0};
    air_interval lit = {-1.0, -1.0};
    assert_true(air_area_lit_interval(&lamp, below, up, 9.0, &lit));
    assert_true(lit.begin == 0.0 && lit.end == 1.5);
    assert_true(air_area_lit_interval(&lamp, below, up, 1.0, &lit) && lit.end == 1.0);
    assert_true(air_area_lit_interval(&lamp, above, down, 9.0, &lit));
    assert_true(lit.begin == 1.0 && lit.end == 9.0);
    assert_true(air_area_lit_interval(&lamp, above, down, INFINITY, &lit) && isinf(lit.end));
    assert_true(air_area_lit_interval(&lamp, below, level, INFINITY, &lit));
    assert_true(lit.begin == 0.0 && isinf(lit.end));
    lit = (air_interval){-1.0, -1.0};
    assert_false(air_area_lit_interval(&lamp, above, level, 9.0, &lit));
    assert_false(air_area_lit_interval(&lamp, above, up, 9.0, &lit));
    assert_false(air_area_lit_interval(&lamp, above, down, 0.5, &lit));
    assert_false(air_area_lit_interval(&lamp, lamp.centre, level, 9.0, &lit));
    assert_false(air_area_lit_interval(&lamp, below, level, 0.0, &lit));
    assert_false(air_area_lit_interval(&lamp, below, level, NAN, &lit));
    assert_true(lit.begin == -1.0); /* untouched */
    assert_true(air_area_lit_interval(&both, above, up, 9.0, &lit));
    assert_true(lit.begin == 0.0 && lit.end == 9.0);
    assert_false(air_area_lit_interval(&both, above, up, -1.0, &lit));
}

typedef struct ray {
    double origin[3], dir[3];
    air_interval lit;
} ray;

/* Rays below the lamp, through it or past it, lit for 10 m at most. */
static ray random_ray(air_rng *rng, const air_area_lamp *lamp)
{
    ray out;
    double target[3];
    do {
        for (int i = 0; i < 3; i++) {
            out.origin[i] = random_between(rng, -4.0, 4.0);
            target[i] = random_between(rng, -2.0, 2.0);
            out.dir[i] = target[i] - out.origin[i];
        }
        normalise(out.dir);
    } while (!air_area_lit_interval(lamp, out.origin, out.dir, 10.0, &out.lit));
    return out;
}

static double lit_integrand(const air_area_lamp *lamp, const ray *r, double g, double sigma_t,
                            double t)
{
    double point[3], wo[3];
    polygon_vertices p;
    for (int i = 0; i < 3; i++) {
        point[i] = r->origin[i] + t * r->dir[i];
        wo[i] = -r->dir[i];
    }
    if (!air_area_lamp_seen_from(lamp, point, p)) {
        return 0.0;
    }
    const double nearest = air_area_min_distance(fixed(p), lamp->vertex_count);
    return air_area_scatter_edge(fixed(p), lamp->vertex_count, wo, g, 12) *
           exp(-sigma_t * (nearest + t));
}

static double rule_integral(air_area_rule rule, const air_area_lamp *lamp, const ray *r, double g,
                            double sigma_t, size_t count)
{
    double t[AIR_AREA_MAX_NODES], w[AIR_AREA_MAX_NODES], sum = 0.0;
    air_area_line_nodes(rule, lamp, r->origin, r->dir, r->lit, sigma_t, count, t, w);
    for (size_t i = 0; i < count; i++) {
        assert_true(t[i] >= r->lit.begin && t[i] <= r->lit.end && w[i] > 0.0);
        assert_true(i == 0 || t[i] > t[i - 1]);
        sum += w[i] * lit_integrand(lamp, r, g, sigma_t, t[i]);
    }
    return sum;
}

/* d and h of the angle at the lamp, tan(theta) = (t - d)/h, by their definition. */
static double lamp_foot(const air_area_lamp *lamp, const ray *r, double *out_h)
{
    double from[3], across[3];
    for (int j = 0; j < 3; j++) {
        from[j] = lamp->centre[j] - r->origin[j];
    }
    const double foot = dot(from, r->dir);
    for (int j = 0; j < 3; j++) {
        across[j] = from[j] - foot * r->dir[j];
    }
    *out_h = sqrt(dot(across, across) + 0.15 * lamp->area);
    return foot;
}

/* Root of the mean square by the mean over rays, of each rule with 4, 8 .. 64 nodes. */
static void rules_converge(void **state)
{
    (void)state;
    enum { RAYS = 60, COUNTS = 5, RULES = 4 };
    /* Twice the errors measured of these rays and haze, g = -0.6, sigma_t = 0.2. */
    static const double most[RULES][COUNTS] = {{1.1, 0.22, 5e-2, 1.4e-2, 3.6e-3},
                                               {0.25, 1.4e-2, 2.7e-4, 2.5e-5, 3.6e-6},
                                               {8.5e-2, 6.2e-3, 1.7e-4, 1.8e-5, 2e-6},
                                               {3.1e-2, 3.2e-3, 5.5e-5, 7.2e-6, 5.4e-7}};
    const air_area_lamp lamp = make_lamp(false);
    for (int rule = 0; rule < RULES; rule++) {
        double squares[COUNTS] = {0.0}, mean = 0.0;
        air_rng rng = air_rng_from_keys(1, 0);
        for (int i = 0; i < RAYS; i++) {
            const ray r = random_ray(&rng, &lamp);
            const double expected =
                rule_integral(AIR_AREA_EQUIANGULAR, &lamp, &r, -0.6, 0.2, AIR_AREA_MAX_NODES);
            mean += expected;
            for (int k = 0; k < COUNTS; k++) {
                const double error =
                    rule_integral((air_area_rule)rule, &lamp, &r, -0.6, 0.2, (size_t)4 << k) -
                    expected;
                squares[k] += error * error;
            }
        }
        for (int k = 0; k < COUNTS; k++) {
            const double error = sqrt(squares[k] * RAYS) / mean;
            if (!(error < most[rule][k])) {
                fail_msg("rule %d, %d nodes: %g", rule, 4 << k, error);
            }
        }
    }
}

/* Rules integrate what they are made for. */
static void rules_are_exact_for_their_functions(void **state)
{
    (void)state;
    const air_area_lamp lamp = make_lamp(true);
    air_rng rng = air_rng_from_keys(2, 0);
    static const double depths[] = {0.0, 1e-6, 1e-3, 1.0, 50.0, 1e3};
    for (int i = 0; i < 120; i++) {
        double t[16], w[16], length = 0.0, cube = 0.0, light = 0.0, hump = 0.0, steps = 0.0;
        ray r = random_ray(&rng, &lamp);
        const double begin = random_between(&rng, 0.0, 3.0), sigma_t = depths[i % 6];
        const double end = begin + exp(random_between(&rng, -5.0, 2.0)), span = end - begin;
        r.lit = (air_interval){begin, end};
        air_area_line_nodes(AIR_AREA_RIEMANN, &lamp, r.origin, r.dir, r.lit, sigma_t, 16, t, w);
        for (int k = 0; k < 16; k++) {
            steps += w[k] * t[k];
        }
        assert_true(fabs(steps / (0.5 * (end * end - begin * begin)) - 1.0) < 1e-13);
        air_area_line_nodes(AIR_AREA_GAUSS, &lamp, r.origin, r.dir, r.lit, sigma_t, 16, t, w);
        for (int k = 0; k < 16; k++) {
            length += w[k];
            cube += w[k] * pow((t[k] - begin) / span, 3.0);
        }
        assert_true(fabs(length / span - 1.0) < 1e-13);
        assert_true(fabs(cube / span - 0.25) < 1e-13);
        air_area_line_nodes(AIR_AREA_OPTICAL, &lamp, r.origin, r.dir, r.lit, sigma_t, 16, t, w);
        for (int k = 0; k < 16; k++) {
            light += w[k] * exp(-sigma_t * (t[k] - begin));
        }
        const double depth = sigma_t * span;
        assert_true(fabs(light / (depth > 0.0 ? -expm1(-depth) / sigma_t : span) - 1.0) < 1e-12);
        /* The density's reciprocal: each node gives its weight of the angle. */
        air_area_line_nodes(AIR_AREA_EQUIANGULAR, &lamp, r.origin, r.dir, r.lit, 0.0, 16, t, w);
        double h;
        const double foot = lamp_foot(&lamp, &r, &h);
        for (int k = 0; k < 16; k++) {
            hump += w[k] * h / (h * h + (t[k] - foot) * (t[k] - foot));
        }
        const double angle = atan((end - foot) / h) - atan((begin - foot) / h);
        assert_true(fabs(hump / angle - 1.0) < 1e-12);
    }
}

static void endless_rays_have_an_integral(void **state)
{
    (void)state;
    const air_area_lamp lamp = make_lamp(false);
    const ray r = {.origin = {0.3, -5.0, 0.0}, .dir = {0.0, 1.0, 0.0}, .lit = {0.0, INFINITY}};
    for (int thick = 0; thick < 2; thick++) {
        const double sigma_t = thick == 0 ? 0.0 : 0.3;
        const double expected = rule_integral(AIR_AREA_EQUIANGULAR, &lamp, &r, 0.4, sigma_t, 256);
        /* Light falls with the square or cube of the distance, which is smooth over the angle. */
        assert_true(
            fabs(rule_integral(AIR_AREA_EQUIANGULAR, &lamp, &r, 0.4, sigma_t, 32) / expected -
                 1.0) < 3e-3);
        for (int rule = 0; rule < 4; rule++) { /* finite and positive, all of them */
            assert_true(rule_integral((air_area_rule)rule, &lamp, &r, 0.4, sigma_t, 64) > 0.0);
        }
    }
    assert_true(fabs(rule_integral(AIR_AREA_OPTICAL, &lamp, &r, 0.4, 0.3, 256) /
                         rule_integral(AIR_AREA_EQUIANGULAR, &lamp, &r, 0.4, 0.3, 256) -
                     1.0) < 1e-4);
}

static void extremes_are_finite(void **state)
{
    (void)state;
    static const double sizes[] = {1e-3, 1.0, 1e3}, begins[] = {0.0, 1e-9, 1.0, 1e4},
                        lengths[] = {1e-9, 1.0, 1e5, INFINITY}, depths[] = {0.0, 1e-6, 1e3};
    for (int i = 0; i < 3 * 4 * 4 * 3; i++) {
        air_area_lamp lamp = make_lamp(true);
        const double size = sizes[i % 3], begin = begins[i / 3 % 4], length = lengths[i / 12 % 4];
        const double sigma_t = depths[i / 48];
        lamp.area *= size * size;
        const double origin[3] = {lamp.centre[0], lamp.centre[1], lamp.centre[2] + 100.0};
        const double dir[3] = {0.0, 0.0, -1.0};
        const air_interval lit = {begin, begin + length};
        for (int rule = 0; rule < 4; rule++) {
            double t[64], w[64];
            air_area_line_nodes((air_area_rule)rule, &lamp, origin, dir, lit, sigma_t, 64, t, w);
            for (int k = 0; k < 64; k++) {
                assert_true(t[k] >= lit.begin && t[k] <= lit.end && isfinite(t[k]));
                assert_true(w[k] >= 0.0 && isfinite(w[k]));
                assert_true(k == 0 || t[k] >= t[k - 1]);
            }
        }
        for (double u = 0.0; u < 1.0; u += 0.0625) {
            double pdf;
            const double t = air_area_sample_distance(&lamp, origin, dir, lit, u, &pdf);
            assert_true(t >= lit.begin && t <= lit.end && pdf > 0.0 && isfinite(pdf));
        }
        double pdf;
        const double last = air_area_sample_distance(&lamp, origin, dir, lit, 1.0 - 0x1p-53, &pdf);
        assert_true(isfinite(last) && pdf > 0.0);
    }
    const air_area_lamp lamp = make_lamp(true);
    const double dir[3] = {0.0, 0.0, 1.0};
    double t[4], w[4], pdf;
    air_area_line_nodes(AIR_AREA_GAUSS, &lamp, dir, dir, (air_interval){2.0, 2.0}, 1.0, 4, t, w);
    assert_true(t[0] == 2.0 && t[3] == 2.0 && w[0] == 0.0 && w[3] == 0.0);
    assert_true(air_area_sample_distance(&lamp, dir, dir, (air_interval){2.0, 1.0}, 0.5, &pdf) ==
                2.0);
    assert_true(pdf == 0.0);
}

static void samples_invert_the_distribution(void **state)
{
    (void)state;
    const air_area_lamp lamp = make_lamp(true);
    air_rng rng = air_rng_from_keys(3, 0);
    for (int i = 0; i < 3000; i++) {
        ray r = random_ray(&rng, &lamp);
        const double u = random_unit(&rng);
        double pdf, h;
        r.lit.begin = random_between(&rng, 0.0, 5.0);
        r.lit.end = i % 3 == 0 ? INFINITY : r.lit.begin + random_between(&rng, 0.01, 9.0);
        const double t = air_area_sample_distance(&lamp, r.origin, r.dir, r.lit, u, &pdf);
        const double foot = lamp_foot(&lamp, &r, &h), begin = atan((r.lit.begin - foot) / h);
        const double angle = atan((r.lit.end - foot) / h) - begin;
        /* The difference of two arcs of the order of 1, 1e-16, by an angle of 1e-4 at least. */
        assert_true(fabs((atan((t - foot) / h) - begin) / angle - u) < 1e-11);
        assert_true(fabs(pdf * angle * (h * h + (t - foot) * (t - foot)) / h - 1.0) < 1e-11);
    }
}

static void samples_are_distributed_so(void **state)
{
    (void)state;
    enum { BINS = 32, DRAWS = 20000, RAYS = 40 };
    const air_area_lamp lamp = make_lamp(false);
    air_rng rng = air_rng_from_keys(4, 0);
    int suspicious = 0;
    for (int i = 0; i < RAYS; i++) {
        const ray r = random_ray(&rng, &lamp);
        double counts[BINS] = {0.0}, expected[BINS], whole = 0.0, h;
        const double width = (r.lit.end - r.lit.begin) / BINS, foot = lamp_foot(&lamp, &r, &h);
        for (int k = 0; k < BINS; k++) {
            const double begin = r.lit.begin + width * k - foot;
            expected[k] = atan((begin + width) / h) - atan(begin / h);
            whole += expected[k];
        }
        for (int k = 0; k < BINS; k++) {
            expected[k] *= DRAWS / whole;
        }
        for (int k = 0; k < DRAWS; k++) {
            double pdf;
            const double t =
                air_area_sample_distance(&lamp, r.origin, r.dir, r.lit, random_unit(&rng), &pdf);
            const int bin = (int)((t - r.lit.begin) / width);
            counts[bin < BINS ? bin : BINS - 1] += 1.0;
        }
        suspicious += chi_square_p(counts, expected, BINS, NULL) < 0.01;
    }
    /* 0.4 expected of 40 at this level; more than 4 has a probability of 1e-4. */
    assert_true(suspicious <= 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_rules_are_cores),
        cmocka_unit_test(rays_are_lit_in_front),
        cmocka_unit_test(rules_converge),
        cmocka_unit_test(rules_are_exact_for_their_functions),
        cmocka_unit_test(endless_rays_have_an_integral),
        cmocka_unit_test(extremes_are_finite),
        cmocka_unit_test(samples_invert_the_distribution),
        cmocka_unit_test(samples_are_distributed_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

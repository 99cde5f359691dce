/* S of many points: every instruction set that the machine has, in double and in float, against the
 * plain version and against the oracle's polygons. */
#include <float.h>

#include "arealight_batch.h"
#include "cmocka_test.h"

static air_context *contexts[BATCH_LEVELS];
static batch_points points;
static oracle_polygon oracle[ORACLE_POLYGONS];
static bool have_oracle;

static int set_up(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = cpu;
        if (air_context_create(&params, &contexts[cpu]) != AIR_OK) {
            return -1;
        }
    }
    have_oracle = oracle_load(oracle);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    for (int cpu = AIR_CPU_C; cpu < BATCH_LEVELS; cpu++) {
        air_context_destroy(contexts[cpu]);
    }
    return 0;
}

static void skip_without_oracle(void)
{
    if (!have_oracle) {
        print_message("skipped: no tables at " AIR_SHARED_DIR "/spec/data/area-lights\n");
        skip();
    }
}

/* ---- the oracle ---- */

/* The largest error over the polygons, relative to S by edges, absolute by lobes; tiny ones apart
 * in *out_tiny. */
static double oracle_error(air_cpu cpu, int g, int nodes, bool mix, bool floats, double *out_tiny)
{
    double error = 0.0, tiny = 0.0;
    for (int i = 0; i < ORACLE_POLYGONS; i++) {
        const oracle_polygon *p = &oracle[i];
        const air_area_lamp lamp = batch_lamp(p->vertices, p->count);
        const batch_question q = {oracle_g[g], nodes, oracle_lobe(g, mix)};
        const double origin[3] = {0.0, 0.0, 0.0};
        const double exact = nodes > 0 ? p->exact[g] : mix ? p->mix[g] : p->ltsd[g];
        double s;
        float s_float;
        points.count = 0;
        batch_add_exact(&points, origin, p->wo);
        batch_ask(contexts[cpu], &lamp, &q, &points, &s);
        batch_ask_float(contexts[cpu], &lamp, &q, &points, &s_float);
        const double off = fabs((floats ? (double)s_float : s) - exact);
        const double relative = nodes > 0 ? off / exact : off;
        assert_true(relative < INFINITY);
        if (strcmp(p->class, "tiny") == 0) {
            tiny = fmax(tiny, relative);
        } else {
            error = fmax(error, relative);
        }
    }
    *out_tiny = tiny;
    return error;
}

/* The spec asks for 1e-9, 1e-6 and 2e-4 (2e-3 at 0.99) of 32, 16 and 8 nodes; here 8 nodes are held
 * to twice what is measured, and so are 6 and 4. */
static void edges_in_double_meet_the_oracle(void **state)
{
    (void)state;
    static const int nodes[] = {32, 16, 8, 6, 4};
    static const double bound[5][ORACLE_GS] = {{1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9},
                                               {1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6},
                                               {1.4e-5, 6e-9, 4e-12, 2e-12, 1e-9, 6e-6, 1e-5},
                                               {6e-5, 2e-7, 6e-10, 2e-12, 6e-8, 3e-5, 2e-4},
                                               {1e-3, 4e-5, 6e-7, 2e-12, 8e-6, 6e-4, 2.5e-2}};
    skip_without_oracle();
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        for (int n = 0; n < 5; n++) {
            print_message("level %d, %2d nodes:", (int)cpu, nodes[n]);
            for (int g = 0; g < ORACLE_GS; g++) {
                double tiny;
                const double error = oracle_error(cpu, g, nodes[n], false, false, &tiny);
                print_message(" %.1e", fmax(error, tiny));
                assert_true(fmax(error, tiny) <= bound[n][g]);
            }
            print_message("\n");
        }
    }
}

/* Of float, with 16 nodes. The spec has, of 16 and 24: 4e-6 up to |g| = 0.1, 8e-5 up to
 * 0.95, 1.1e-3 at 0.99; tiny polygons 1e-4, 5e-4 and 1.3e-2, of which the middle one, at |g| = 0.9
 * and 0.95, is 6e-4 here. */
static void edges_in_float_meet_the_oracle(void **state)
{
    (void)state;
    static const double bound[ORACLE_GS] = {8e-5, 8e-5, 4e-6, 4e-6, 8e-5, 8e-5, 1.1e-3};
    static const double bound_tiny[ORACLE_GS] = {1e-3, 4e-4, 1e-4, 4e-6, 4e-4, 1e-3, 1e-2};
    skip_without_oracle();
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        print_message("level %d, float (tiny):", (int)cpu);
        for (int g = 0; g < ORACLE_GS; g++) {
            double tiny;
            const double error = oracle_error(cpu, g, 16, false, true, &tiny);
            print_message(" %.1e (%.1e)", error, tiny);
            assert_true(error <= bound[g]);
            assert_true(tiny <= bound_tiny[g]);
        }
        print_message("\n");
    }
}

/* The fits are known to 5e-7. A lobe's share of a region changes by at most d log s, and by half of
 * dw: with s >= 0.55 by 1e-6. Floats add some roundings of sums up to 1, the more so where the lobe
 * is narrow. */
static void lobes_meet_the_oracle(void **state)
{
    (void)state;
    skip_without_oracle();
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        for (int mix = 0; mix < 2; mix++) {
            for (int floats = 0; floats < 2; floats++) {
                print_message("level %d, %s, %s:", (int)cpu, mix ? "MIX" : "LTSD",
                              floats ? "float" : "double");
                for (int g = 0; g < ORACLE_GS; g++) {
                    double tiny;
                    const double larger = oracle_error(cpu, g, 0, mix != 0, floats != 0, &tiny);
                    const double error = fmax(larger, tiny);
                    print_message(" %.1e", error);
                    assert_true(error <= (floats ? 1.2e-5 : 1e-6));
                }
                print_message("\n");
            }
        }
    }
}

/* ---- the rule ---- */

/* The spec's random quadrilaterals: rectangles whose centre is at distance 1, half sides between
 * 0.1 and 2, seen at random. */
static air_area_lamp random_rectangle(air_rng *rng)
{
    double frame[3][3], centre[3], v[4][3];
    random_frame(rng, frame);
    random_direction(rng, centre);
    const double a = 0.1 * exp(log(20.0) * random_unit(rng)),
                 b = 0.1 * exp(log(20.0) * random_unit(rng));
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) {
            v[i][k] = centre[k] + (i == 1 || i == 2 ? a : -a) * frame[0][k] +
                      (i > 1 ? b : -b) * frame[1][k];
        }
    }
    return batch_lamp((const double(*)[3])v, 4);
}

/* The root of the mean square error of n nodes over the mean of S: held to twice what is measured.
 * The spec's rule, for 4 nodes: 3e-6, 4e-4, 7e-4, 1.6e-3, 3.6e-3, 1e-2, 5e-2. */
static void few_nodes_are_enough(void **state)
{
    (void)state;
    enum { LAMPS = 2000, RULES = 6 };
    static const double gs[] = {0.1, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99};
    static const int nodes[RULES] = {2, 3, 4, 6, 8, 12};
    static const double bound[7][RULES] = {
        {2e-4, 6e-6, 2e-7, 5e-10, 2e-12, 1e-15}, {7e-4, 4e-5, 3e-6, 2e-8, 2.4e-10, 1e-13},
        {2e-3, 1e-4, 8e-6, 2e-7, 6e-9, 1e-11},   {4e-3, 5e-4, 8e-5, 2e-6, 2e-7, 2e-9},
        {1e-2, 1e-3, 2e-4, 2e-5, 1.2e-6, 5e-8},  {2.4e-2, 2.4e-3, 2.4e-4, 3e-5, 5e-6, 2e-7},
        {6e-2, 7e-3, 8e-4, 3e-5, 8e-6, 2e-6}};
    const air_context *context = contexts[air_cpu_detect()];
    for (int k = 0; k < 7; k++) {
        air_rng rng = air_rng_from_keys(23, 8);
        double mean = 0.0, square[RULES] = {0.0};
        for (int i = 0; i < LAMPS; i++) {
            const air_area_lamp lamp = random_rectangle(&rng);
            const double origin[3] = {0.0, 0.0, 0.0};
            double wo[3], exact, s;
            random_direction(&rng, wo);
            points.count = 0;
            batch_add_exact(&points, origin, wo);
            const batch_question best = by_edges(gs[k], 32);
            batch_ask(context, &lamp, &best, &points, &exact);
            mean += exact / LAMPS;
            for (int n = 0; n < RULES; n++) {
                const batch_question q = by_edges(gs[k], nodes[n]);
                batch_ask(context, &lamp, &q, &points, &s);
                square[n] += (s - exact) * (s - exact) / LAMPS;
            }
        }
        print_message("g %4.2f, 2 3 4 6 8 12 nodes:", gs[k]);
        for (int n = 0; n < RULES; n++) {
            print_message(" %.1e", sqrt(square[n]) / mean);
            assert_true(sqrt(square[n]) / mean <= bound[k][n]);
        }
        print_message("\n");
    }
}

/* ---- lanes against the plain version ---- */

/* Convex: vertices on an ellipse, in turn. */
static air_area_lamp random_lamp(air_rng *rng, size_t count, double size)
{
    double frame[3][3], vertices[AIR_AREA_MAX_VERTICES][3], centre[3];
    random_frame(rng, frame);
    const double squash = random_between(rng, 0.2, 1.0), turn = random_between(rng, 0.0, 6.0);
    for (int k = 0; k < 3; k++) {
        centre[k] = random_between(rng, -3.0, 3.0);
    }
    for (size_t i = 0; i < count; i++) {
        const double angle =
            turn + 6.28318530717958648 * ((double)i + 0.6 * random_unit(rng)) / (double)count;
        for (int k = 0; k < 3; k++) {
            vertices[i][k] =
                centre[k] + size * (cos(angle) * frame[0][k] + squash * sin(angle) * frame[1][k]);
        }
    }
    return batch_lamp((const double(*)[3])vertices, count);
}

/* Points at distances from 1e-3 to 30 sizes from the lamp, every eighth over its plane's inside at
 * 1e-3; every fourth looks along or against the lamp's centre, a vertex or the middle of an edge.
 */
static void random_points(air_rng *rng, const air_area_lamp *lamp, double size, size_t count)
{
    points.count = 0;
    for (size_t i = 0; i < count; i++) {
        double dir[3], wo[3], at[3], to[3];
        random_direction(rng, dir);
        random_direction(rng, wo);
        const double reach = size * exp(random_between(rng, log(1e-3), log(30.0)));
        const double *v = lamp->vertices[i % lamp->vertex_count],
                     *w = lamp->vertices[(i + 1) % lamp->vertex_count];
        for (int k = 0; k < 3; k++) {
            at[k] = lamp->centre[k] + reach * dir[k];
            if (i % 8 == 5) {
                at[k] = lamp->centre[k] + 0.3 * (v[k] - lamp->centre[k]) +
                        1e-3 * size * lamp->normal[k];
            }
            to[k] = (i % 12 == 3   ? lamp->centre[k]
                     : i % 12 == 7 ? v[k]
                                   : 0.5 * (v[k] + w[k])) -
                    at[k];
        }
        if (i % 4 == 3) {
            normalise(to);
            for (int k = 0; k < 3; k++) {
                wo[k] = i % 8 == 3 ? to[k] : -to[k];
            }
        }
        batch_add_exact(&points, at, wo);
    }
}

/* The least r^2 along an edge from v to w, unit vectors, axis a. */
static double least_r2(double gamma, const double a[3], const double v[3], const double w[3])
{
    double n[3], from[3], to[3];
    cross(v, w, n);
    const double size = sqrt(dot(n, n));
    double c = fmax(dot(a, v), dot(a, w));
    cross(n, v, from);
    cross(n, w, to);
    if (size > 0.0 && dot(from, a) > 0.0 && dot(to, a) < 0.0) {
        const double h = dot(a, n) / size;
        c = sqrt(fmax(1.0 - h * h, 0.0)); /* the foot of the axis is on the edge */
    }
    return (1.0 - gamma) * (1.0 - gamma) + 2.0 * gamma * fmax(1.0 - c, 0.0);
}

/* How much S by edges may differ for one point. The solid angle is a sum of angles of triangles on
 * the edges, each off by some roundings of its size, and by more where an edge's ends are opposite
 * and 1 + cos is small. An edge's integral is at most 1 and at most its arc over r^2; the rounding
 * of z (in the plain version) gives r^2 a relative error of epsilon / r^2. One such rounding each
 * is allowed. What is small is off by 3 (angle / r)^2 of itself. */
static double edge_tolerance(const air_area_lamp *lamp, size_t i, double g, double s)
{
    const double gamma = fabs(g), sign = g > 0.0 ? -1.0 : 1.0;
    const double axis[3] = {sign * points.wo[0][i], sign * points.wo[1][i], sign * points.wo[2][i]};
    double sum = 0.0;
    for (size_t k = 0; k < lamp->vertex_count; k++) {
        double v[3], w[3];
        for (int j = 0; j < 3; j++) {
            v[j] = lamp->vertices[k][j] - points.position[j][i];
            w[j] = lamp->vertices[(k + 1) % lamp->vertex_count][j] - points.position[j][i];
        }
        normalise(v);
        normalise(w);
        const double cosine = fmin(fmax(dot(v, w), -1.0), 1.0), r2 = least_r2(gamma, axis, v, w);
        const double arc = acos(cosine) + 1e-8;
        sum += fmin(1.0, arc / r2) / r2 + arc / (1.0 + cosine);
    }
    const double small = cbrt(0.2 * DBL_EPSILON * (1.0 + gamma) / (1.0 - gamma));
    return DBL_EPSILON * sum + 3.0 * small * small * s;
}

typedef struct tally {
    double worst, worst_quotient;
    size_t lit;
} tally;

/* All levels against C for the points at hand. */
static void compare_edges(const air_area_lamp *lamp, double g, int nodes, tally *out)
{
    static double plain[BATCH_MOST], lanes[BATCH_MOST];
    const batch_question q = by_edges(g, nodes);
    batch_ask(contexts[AIR_CPU_C], lamp, &q, &points, plain);
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        batch_ask(contexts[cpu], lamp, &q, &points, lanes);
        for (size_t i = 0; i < points.count; i++) {
            const double off = fabs(lanes[i] - plain[i]),
                         tolerance = edge_tolerance(lamp, i, g, plain[i]);
            out->worst = fmax(out->worst, off);
            out->worst_quotient = fmax(out->worst_quotient, off / tolerance);
            out->lit += plain[i] > 0.0;
            if (!(off <= tolerance)) {
                print_error("level %d, point %zu, g %g: %.17g instead of %.17g, tolerance %g\n",
                            (int)cpu, i, g, lanes[i], plain[i], tolerance);
                fail();
            }
        }
    }
}

static void edges_agree(void **state)
{
    (void)state;
    static const double gs[] = {-0.99, -0.7, -0.2, 0.0, 0.3, 0.6, 0.9, 0.99};
    air_rng rng = air_rng_from_keys(23, 1);
    tally all = {0.0, 0.0, 0};
    for (int round = 0; round < 600; round++) {
        const double size = exp(random_between(&rng, log(1e-2), log(10.0)));
        air_area_lamp lamp = random_lamp(&rng, 3 + (size_t)round % 14, size);
        lamp.two_sided = round % 3 != 0;
        random_points(&rng, &lamp, size, 48);
        compare_edges(&lamp, gs[round % 8], 2 + round % 31, &all);
    }
    print_message("edges: off by %.2g, %.2g of what is allowed, %zu lit\n", all.worst,
                  all.worst_quotient, all.lit);
    assert_true(all.lit > 20000 || air_cpu_detect() == AIR_CPU_C);
}

/* How much S by lobes may differ: v^2 + (1 / s^2 - 1) z^2 cancels near the axis, which costs s^2
 * roundings; arcs are off by more where an edge's ends are opposite and 1 + cos is small, before
 * they are stretched or, by 1/s, after. So is, in the plain version, the arc along the horizon,
 * whose ends are as opposite as the lamp is wide over the point's height. 4 roundings each are
 * allowed. */
static double lobe_tolerance(const air_area_lamp *lamp, size_t i, const air_area_lobe *lobe)
{
    const double s = fmax(lobe->s_near, lobe->s_far), s2 = fmax(s * s, 4.0);
    double sum = 0.0, reach = 0.0, height = 0.0;
    for (size_t k = 0; k < lamp->vertex_count; k++) {
        double v[3], w[3];
        for (int j = 0; j < 3; j++) {
            v[j] = lamp->vertices[k][j] - points.position[j][i];
            w[j] = lamp->vertices[(k + 1) % lamp->vertex_count][j] - points.position[j][i];
        }
        reach = fmax(reach, sqrt(dot(v, v)));
        height = fabs(dot(v, lamp->normal));
        normalise(v);
        normalise(w);
        sum += s2 * (1.0 + 1.0 / (1.0 + fmax(dot(v, w), -1.0)));
    }
    return DBL_EPSILON * (sum + reach / height);
}

static void lobes_agree(void **state)
{
    (void)state;
    static double plain[BATCH_MOST], lanes[BATCH_MOST];
    air_rng rng = air_rng_from_keys(23, 2);
    double worst = 0.0, worst_quotient = 0.0;
    size_t lit = 0;
    for (int round = 0; round < 600; round++) {
        const double size = exp(random_between(&rng, log(1e-2), log(10.0)));
        const air_area_lamp lamp = random_lamp(&rng, 3 + (size_t)round % 14, size);
        const batch_question q = by_lobes(oracle_lobe(round % 7, round / 7 % 2 == 0));
        random_points(&rng, &lamp, size, 48);
        batch_ask(contexts[AIR_CPU_C], &lamp, &q, &points, plain);
        for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
            batch_ask(contexts[cpu], &lamp, &q, &points, lanes);
            for (size_t i = 0; i < points.count; i++) {
                const double off = fabs(lanes[i] - plain[i]),
                             tolerance = lobe_tolerance(&lamp, i, &q.lobe);
                worst = fmax(worst, off);
                worst_quotient = fmax(worst_quotient, off / tolerance);
                lit += plain[i] > 0.0;
                if (!(off <= tolerance)) {
                    print_error("level %d, round %d, point %zu: %.17g instead of %.17g\n", (int)cpu,
                                round, i, lanes[i], plain[i]);
                    fail();
                }
            }
        }
    }
    print_message("lobes: off by %.2g, %.2g of what is allowed, %zu lit\n", worst, worst_quotient,
                  lit);
    assert_true(lit > 20000 || air_cpu_detect() == AIR_CPU_C);
}

/* Held to three times what is measured, a few roundings of the terms, times 1 / r^2 near the peak;
 * points keep off the lamp by a tenth of its size, since over an edge S jumps. Small lamps far from
 * the origin are among them: floats of their vertices alone would give 4e-5. */
static void floats_agree(void **state)
{
    (void)state;
    static float plain[BATCH_MOST], lanes[BATCH_MOST];
    static const double gs[] = {-0.9, -0.6, 0.0, 0.4, 0.9, 0.99};
    static const double bound[] = {1e-6, 3e-7, 3e-7, 3e-7, 2e-6, 1e-5};
    air_rng rng = air_rng_from_keys(23, 3);
    double worst[6] = {0.0};
    for (int round = 0; round < 600; round++) {
        const double size = exp(random_between(&rng, log(1e-2), log(10.0)));
        const air_area_lamp lamp = random_lamp(&rng, 3 + (size_t)round % 14, size);
        const batch_question q = {gs[round % 6], round % 4 == 0 ? 0 : 8,
                                  oracle_lobe(4, round % 8 == 0)};
        points.count = 0;
        for (int i = 0; i < 48; i++) {
            double dir[3], wo[3], at[3];
            random_direction(&rng, dir);
            random_direction(&rng, wo);
            const double reach = size * exp(random_between(&rng, log(1.1), log(100.0)));
            move_along(lamp.centre, dir, reach, at);
            batch_add(&points, at, wo);
        }
        batch_ask_float(contexts[AIR_CPU_C], &lamp, &q, &points, plain);
        for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
            batch_ask_float(contexts[cpu], &lamp, &q, &points, lanes);
            for (size_t i = 0; i < points.count; i++) {
                const double off = fabs((double)lanes[i] - (double)plain[i]);
                worst[round % 6] = fmax(worst[round % 6], off);
            }
        }
    }
    for (int k = 0; k < 6; k++) {
        print_message("float, g %g: off by %.2g\n", gs[k], worst[k]);
        assert_true(worst[k] <= bound[k]);
    }
}

/* ---- what does not depend on the polygon ---- */

/* The six faces of a box are all directions: a sum of integrals in which edges cancel; 6 x 4 edges
 * of some roundings each. In float, g = 0.9, the same of FLT_EPSILON over 1 - gamma. */
static void faces_of_a_box_sum_to_one(void **state)
{
    (void)state;
    static double s[BATCH_MOST], sum[BATCH_MOST];
    static float s_float[BATCH_MOST], sum_float[BATCH_MOST];
    const batch_question questions[3] = {by_edges(0.9, 3), by_lobes(oracle_lobe(1, false)),
                                         by_lobes(oracle_lobe(5, true))};
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        for (int k = 0; k < 3; k++) {
            air_rng rng = air_rng_from_keys(23, 4);
            points.count = 0;
            for (int i = 0; i < 200; i++) {
                const double at[3] = {random_between(&rng, -0.95, 0.95),
                                      random_between(&rng, -0.95, 0.95),
                                      random_between(&rng, -0.95, 0.95)};
                double wo[3];
                random_direction(&rng, wo);
                batch_add_exact(&points, at, wo);
                sum[i] = sum_float[i] = 0.0F;
            }
            for (int face = 0; face < 6; face++) {
                double v[4][3];
                for (int j = 0; j < 4; j++) {
                    v[j][face / 2] = face % 2 == 0 ? 1.0 : -1.0;
                    v[j][(face / 2 + 1) % 3] = j == 1 || j == 2 ? 1.0 : -1.0;
                    v[j][(face / 2 + 2) % 3] = j > 1 ? 1.0 : -1.0;
                }
                const air_area_lamp lamp = batch_lamp((const double(*)[3])v, 4);
                batch_ask(contexts[cpu], &lamp, &questions[k], &points, s);
                batch_ask_float(contexts[cpu], &lamp, &questions[k], &points, s_float);
                for (int i = 0; i < 200; i++) {
                    sum[i] += s[i];
                    sum_float[i] += s_float[i];
                }
            }
            for (int i = 0; i < 200; i++) {
                assert_true(fabs(sum[i] - 1.0) <= 1e-13);
                assert_true(fabs((double)sum_float[i] - 1.0) <= 4e-5);
            }
        }
    }
}

static void neighbours_and_counts_change_no_byte(void **state)
{
    (void)state;
    static double whole[BATCH_MOST], part[BATCH_MOST];
    static float whole_float[BATCH_MOST], part_float[BATCH_MOST];
    air_rng rng = air_rng_from_keys(23, 5);
    const air_area_lamp lamp = random_lamp(&rng, 4, 1.0);
    const batch_question questions[2] = {by_edges(0.6, 4), by_lobes(oracle_lobe(4, true))};
    static const size_t counts[] = {1, 2, 3, 7, 15, 16, 17, 33, 4095, 4096, 4097, 4111};
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        for (int k = 0; k < 2; k++) {
            random_points(&rng, &lamp, 1.0, BATCH_MOST);
            batch_ask(contexts[cpu], &lamp, &questions[k], &points, whole);
            batch_ask_float(contexts[cpu], &lamp, &questions[k], &points, whole_float);
            for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
                points.count = counts[c];
                part[counts[c]] = -7.0;
                part_float[counts[c]] = -7.0F;
                batch_ask(contexts[cpu], &lamp, &questions[k], &points, part);
                batch_ask_float(contexts[cpu], &lamp, &questions[k], &points, part_float);
                assert_memory_equal(part, whole, counts[c] * sizeof *part);
                assert_memory_equal(part_float, whole_float, counts[c] * sizeof *part_float);
                assert_true(part[counts[c]] == -7.0 && part_float[counts[c]] == -7.0F);
            }
            /* Each point among strangers. */
            points.count = BATCH_MOST;
            for (int i = 0; i < BATCH_MOST; i += 2) {
                for (int j = 0; j < 3; j++) {
                    points.position[j][i] = points.position_float[j][i] = (float)(3 * j);
                }
            }
            batch_ask(contexts[cpu], &lamp, &questions[k], &points, part);
            batch_ask_float(contexts[cpu], &lamp, &questions[k], &points, part_float);
            for (int i = 1; i < BATCH_MOST; i += 2) {
                assert_true(part[i] == whole[i] && part_float[i] == whole_float[i]);
            }
        }
    }
}

static void hold_in_range(air_cpu cpu, const air_area_lamp *lamp, const batch_question *q)
{
    static double s[BATCH_MOST];
    static float s_float[BATCH_MOST];
    batch_ask(contexts[cpu], lamp, q, &points, s);
    batch_ask_float(contexts[cpu], lamp, q, &points, s_float);
    for (size_t i = 0; i < points.count; i++) {
        if (!(s[i] >= 0.0 && s[i] <= 1.0 && s_float[i] >= 0.0F && s_float[i] <= 1.0F)) {
            print_error("level %d, point %zu, g %g: %g, %g\n", (int)cpu, i, q->g, s[i],
                        (double)s_float[i]);
            fail();
        }
    }
}

/* Lamps of 1 mm to 1 km; points at vertices, on edges, on edges prolonged, on the lamp's centre, in
 * its plane outside, 1e-12 and 1e6 of its size away; views along edges, axes in the plane. */
static void extremes_are_finite(void **state)
{
    (void)state;
    static const double sizes[] = {1e-3, 1.0, 1e3}, gs[] = {-0.99, 0.0, 1e-9, 0.5, 0.99, 1.0};
    static const double along[] = {0.0, 0.5, 1.0, 1.5, -1e6}, off[] = {0.0, 1e-12, -1e-3, 1e6};
    for (int size = 0; size < 3; size++) {
        const double h = sizes[size],
                     v[4][3] = {{-h, -h, 0.0}, {h, -h, 0.0}, {h, h, 0.0}, {-h, h, 0.0}};
        const air_area_lamp lamp = batch_lamp((const double(*)[3])v, 4);
        points.count = 0;
        for (int i = 0; i < 5 * 5 * 4 * 6; i++) {
            const double at[3] = {h * (2.0 * along[i % 5] - 1.0),
                                  h * (2.0 * along[i / 5 % 5] - 1.0), h * off[i / 25 % 4]};
            double wo[3] = {0.0, 0.0, 0.0};
            wo[i / 100 % 3] = i / 300 == 0 ? 1.0 : -1.0;
            batch_add(&points, at, wo);
        }
        for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
            for (int g = 0; g < 6; g++) {
                batch_question q = by_edges(gs[g], 4);
                hold_in_range(cpu, &lamp, &q);
                q = by_lobes(oracle_lobe(g, g % 2 == 0));
                hold_in_range(cpu, &lamp, &q);
            }
        }
    }
}

/* Half of all directions: S is the phase function's share there, (1 +- something) / 2; for an axis
 * in the plane it is 1/2. */
static void on_the_lamp_half_of_all_directions_count(void **state)
{
    (void)state;
    const double v[4][3] = {{-1.0, -1.0, 0.0}, {1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}, {-1.0, 1.0, 0.0}};
    const air_area_lamp lamp = batch_lamp((const double(*)[3])v, 4);
    air_rng rng = air_rng_from_keys(23, 6);
    points.count = 0;
    for (int i = 0; i < 64; i++) {
        const double at[3] = {i == 0 ? 0.0 : random_between(&rng, -0.9, 0.9),
                              i == 0 ? 0.0 : random_between(&rng, -0.9, 0.9), 0.0};
        const double wo[3] = {0.6, 0.8, 0.0};
        batch_add_exact(&points, at, wo);
    }
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        static double s[BATCH_MOST];
        const batch_question q = by_edges(0.6, 16);
        batch_ask(contexts[cpu], &lamp, &q, &points, s);
        for (size_t i = 0; i < points.count; i++) {
            assert_true(fabs(s[i] - 0.5) <= 1e-5); /* the rule's error */
        }
    }
}

static void one_sided_lamps_are_dark_behind_and_nothing_comes_of_nan(void **state)
{
    (void)state;
    static double s[BATCH_MOST], two[BATCH_MOST];
    static float s_float[BATCH_MOST];
    air_rng rng = air_rng_from_keys(23, 7);
    air_area_lamp lamp = random_lamp(&rng, 5, 1.0);
    const batch_question q = by_edges(0.6, 4);
    static const double bad[3] = {NAN, INFINITY, -INFINITY};
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); cpu++) {
        random_points(&rng, &lamp, 1.0, 200);
        lamp.two_sided = true;
        batch_ask(contexts[cpu], &lamp, &q, &points, two);
        lamp.two_sided = false;
        batch_ask(contexts[cpu], &lamp, &q, &points, s);
        for (size_t i = 0; i < 200; i++) {
            double height = 0.0;
            for (int k = 0; k < 3; k++) {
                height += lamp.normal[k] * (points.position[k][i] - lamp.vertices[0][k]);
            }
            assert_true(two[i] > 0.0 && s[i] == (height > 0.0 ? two[i] : 0.0));
        }
        for (int at = 0; at < 6; at++) {
            for (int kind = 0; kind < 3; kind++) {
                lamp.two_sided = true;
                random_points(&rng, &lamp, 1.0, 40);
                (at < 3 ? points.position[at] : points.wo[at - 3])[17] = bad[kind];
                (at < 3 ? points.position_float[at] : points.wo_float[at - 3])[17] =
                    (float)bad[kind];
                batch_ask(contexts[cpu], &lamp, &q, &points, s);
                batch_ask_float(contexts[cpu], &lamp, &q, &points, s_float);
                assert_true(s[17] == 0.0 && s_float[17] == 0.0F);
                assert_true(s[16] > 0.0 && s[18] > 0.0 && s_float[16] > 0.0F);
            }
        }
        const batch_question none = by_edges(NAN, 4);
        batch_ask(contexts[cpu], &lamp, &none, &points, s);
        assert_true(s[0] == 0.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_in_double_meet_the_oracle),
        cmocka_unit_test(edges_in_float_meet_the_oracle),
        cmocka_unit_test(lobes_meet_the_oracle),
        cmocka_unit_test(few_nodes_are_enough),
        cmocka_unit_test(edges_agree),
        cmocka_unit_test(lobes_agree),
        cmocka_unit_test(floats_agree),
        cmocka_unit_test(faces_of_a_box_sum_to_one),
        cmocka_unit_test(neighbours_and_counts_change_no_byte),
        cmocka_unit_test(extremes_are_finite),
        cmocka_unit_test(on_the_lamp_half_of_all_directions_count),
        cmocka_unit_test(one_sided_lamps_are_dark_behind_and_nothing_comes_of_nan),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

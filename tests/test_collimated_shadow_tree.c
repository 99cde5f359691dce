/* The shadow tree, ray by ray: the same bits from every instruction set and any number of threads,
 * no cracks, parts that add up to the whole, and what happens when the caller or memory fails. */
#include <limits.h>

#include "cmocka_test.h"
#include "failing_allocator.h"
#include "shadow_meshes.h"
#include "shadow_reference.h"

static foggy_scene scene; /* too large for the stack; every test sets it */
static loose_mesh mesh;
static air_shadow_mesh borrowed;

static const double centre[3] = {0.2, 0.4, 0.0};
static const double radius = 0.5;

/* The mesh in the cube [-1, 1]^3. */
static void start_scene(double lx, double ly, double lz)
{
    borrowed = borrow_mesh(&mesh);
    scene = (foggy_scene){{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0},     1.0,
                          {lx, ly, lz},       .meshes = &borrowed, .mesh_count = 1};
    normalise(scene.to_light);
}

static air_context *create_context(void)
{
    air_context *context;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    return context;
}

/* A ray through the cube: [0, *end] of it is inside. Some run along axes or the light. */
static void random_ray(air_rng *rng, double origin[3], double dir[3], double *end)
{
    const air_collimated_medium fog = box_between(scene.low, scene.high);
    air_interval inside;
    for (int i = 0; i < 3; i++) {
        origin[i] = random_between(rng, -1.0, 1.0);
    }
    random_direction(rng, dir);
    const uint32_t kind = air_rng_next(rng) % 8u;
    if (kind < 3) {
        const double sign = air_rng_next(rng) % 2u == 0 ? 1.0 : -1.0;
        for (int i = 0; i < 3; i++) {
            dir[i] = sign * (i == (int)kind ? 1.0 : 0.0);
        }
    } else if (kind == 3) {
        for (int i = 0; i < 3; i++) {
            dir[i] = scene.to_light[i] + 1e-7 * dir[i];
        }
        normalise(dir);
    }
    *end = air_collimated_interval(&fog, origin, dir, INFINITY, &inside) ? inside.end : 0.0;
}

/* ---- the same bits ---- */

enum { RAYS = 2000 };

typedef struct answers {
    size_t size;
    size_t counts[RAYS];
    air_interval shadows[RAYS][64];
} answers;

/* Rays by themselves, or in batches. Three of four have a neighbour's direction, slightly turned:
 * these go through the tree together. */
static void ask(air_context *context, bool together, answers *out)
{
    static air_shadow_query queries[RAYS];
    air_rng rng = air_rng_from_keys(1, 20);
    air_shadow_tree *tree = make_tree(context, &scene, NULL);
    memset(out, 0, sizeof *out);
    out->size = air_shadow_tree_size(tree);
    for (size_t i = 0; i < RAYS; i++) {
        air_shadow_query *query = &queries[i];
        *query = (air_shadow_query){.out = out->shadows[i], .capacity = 64};
        if (i % 4 == 0) {
            random_ray(&rng, query->origin, query->dir, &query->end);
        } else {
            memcpy(query->origin, query[-1].origin, sizeof query->origin);
            memcpy(query->dir, query[-1].dir, sizeof query->dir);
            query->dir[i % 3] += 0.01;
            const double length = sqrt(dot(query->dir, query->dir));
            for (int k = 0; k < 3; k++) {
                query->dir[k] /= length;
            }
            query->end = 0.9 * query[-1].end;
        }
    }
    if (together) {
        air_shadow_tree_query_rays(tree, queries, RAYS);
    }
    for (size_t i = 0; i < RAYS; i++) {
        const air_shadow_query *query = &queries[i];
        out->counts[i] = together ? query->count
                                  : air_shadow_tree_query(tree, query->origin, query->dir, 0.0,
                                                          query->end, out->shadows[i], 64);
        assert_true(out->counts[i] <= 64);
    }
    air_shadow_tree_destroy(tree);
}

static void assert_same_answers(const air_context_params *params, bool together,
                                const answers *expected)
{
    static answers found;
    air_context *context;
    if (air_context_create(params, &context) != AIR_OK) {
        print_message("skipped: this machine lacks instruction set %d\n", (int)params->cpu);
        return;
    }
    ask(context, together, &found);
    assert_int_equal(found.size, expected->size);
    assert_memory_equal(found.counts, expected->counts, sizeof found.counts);
    for (size_t i = 0; i < RAYS; i++) {
        assert_memory_equal(found.shadows[i], expected->shadows[i],
                            found.counts[i] * sizeof found.shadows[i][0]);
    }
    air_context_destroy(context);
}

static void check_all_contexts(void)
{
    static answers expected;
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.thread_count = 1;
    params.cpu = AIR_CPU_C;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    ask(context, false, &expected);
    air_context_destroy(context);
    for (int threads = 1; threads <= 3; threads++) {
        params.thread_count = (size_t)threads;
        for (int cpu = AIR_CPU_C; cpu <= AIR_CPU_AVX512; cpu++) {
            params.cpu = (air_cpu)cpu;
            assert_same_answers(&params, false, &expected);
            assert_same_answers(&params, true, &expected);
        }
    }
}

static void instruction_sets_and_threads_give_the_same_bits(void **state)
{
    (void)state;
    make_soup(&mesh, 1000, 2);
    start_scene(0.3, 0.5, -0.6);
    check_all_contexts();
    start_scene(0.0, 1.0, 0.0);
    check_all_contexts();
    make_sphere(&mesh, centre, radius, 32);
    start_scene(-0.3, 0.6, -0.3);
    check_all_contexts();
}

/* ---- no cracks ---- */

/* Is the point in the ball that the sphere's mesh contains, or under it? */
static bool under_ball(const double x[3], double ball)
{
    double d[3];
    subtract(x, centre, d);
    const double height = dot(d, scene.to_light), size2 = dot(d, d);
    return size2 < ball * ball || (height < 0.0 && size2 - height * height < ball * ball);
}

/* Radius of the largest ball in the mesh, but for the rounding of floats in the tree, 1e-6. */
static double inner_radius(void)
{
    double least = INFINITY;
    for (size_t i = 0; i < mesh.count; i++) {
        double p[3][3], u[3], v[3], n[3], d[3];
        triangle_corners(&borrowed, i, p);
        subtract(p[1], p[0], u);
        subtract(p[2], p[0], v);
        subtract(p[0], centre, d);
        cross(u, v, n);
        least = fmin(least, fabs(dot(n, d)) / sqrt(dot(n, n)));
    }
    return least - 1e-6;
}

/* The shadow of a ball is convex: between two points of it a ray has one shadow. Returns whether
 * there were two. */
static bool check_unbroken(const air_shadow_tree *tree, const double o[3], const double v[3],
                           double begin, double end, double ball)
{
    enum { PROBES = 64 };
    air_interval found[64];
    double first = INFINITY, last = -INFINITY;
    for (int i = 0; i < PROBES; i++) {
        const double t = begin + (end - begin) * (i + 0.5) / PROBES;
        double x[3];
        move_along(o, v, t, x);
        if (under_ball(x, ball)) {
            first = fmin(first, t);
            last = t;
        }
    }
    const size_t count = air_shadow_tree_query(tree, o, v, begin, end, found, 64);
    assert_true(count <= 64);
    bool whole = !(first < last);
    for (size_t i = 0; i < count; i++) {
        whole = whole || (found[i].begin <= first && found[i].end >= last);
    }
    if (!whole) {
        fail_msg("light in [%.9g, %.9g] of (%g, %g, %g) + t (%.17g, %.17g, %.17g)", first, last,
                 o[0], o[1], o[2], v[0], v[1], v[2]);
    }
    return first < last;
}

/* A ray that passes under a corner of the mesh or a point of an edge of it, somewhere inside the
 * cube; one in three along the edge, as seen from the light. */
static void ray_under_edge(air_rng *rng, double o[3], double v[3])
{
    const float *p = mesh.positions + 9 * (air_rng_next(rng) % mesh.count);
    const double along = air_rng_next(rng) % 2u == 0 ? 0.0 : random_unit(rng);
    double at[3], edge[3];
    for (int k = 0; k < 3; k++) {
        edge[k] = (double)p[3 + k] - (double)p[k];
        at[k] = (double)p[k] + along * edge[k];
    }
    move_along(at, scene.to_light, -random_between(rng, 0.1, 0.6), at);
    random_direction(rng, v);
    if (air_rng_next(rng) % 3u == 0) {
        move_along(edge, scene.to_light, random_between(rng, -1.0, 1.0) * radius / 32.0, v);
        normalise(v);
    }
    move_along(at, v, -0.2, o);
}

static void check_closed_sphere(air_context *context, double lx, double ly, double lz)
{
    air_rng rng = air_rng_from_keys(2, 20);
    int checked = 0;
    start_scene(lx, ly, lz);
    const double ball = inner_radius();
    air_shadow_tree *tree = make_tree(context, &scene, NULL);
    for (int i = 0; i < 20000; i++) {
        double o[3], v[3];
        ray_under_edge(&rng, o, v);
        checked += check_unbroken(tree, o, v, 0.0, 0.4, ball);
    }
    assert_true(checked > 8000);
    air_shadow_tree_destroy(tree);
}

static void no_ray_finds_a_crack_in_a_closed_sphere(void **state)
{
    (void)state;
    make_sphere(&mesh, centre, radius, 32);
    for (int cpu = AIR_CPU_C; cpu <= AIR_CPU_AVX512; cpu++) {
        air_context_params params;
        air_context *context;
        air_context_params_default(&params);
        params.cpu = (air_cpu)cpu;
        if (air_context_create(&params, &context) != AIR_OK) {
            continue;
        }
        check_closed_sphere(context, -0.3, 0.6, -0.3);
        check_closed_sphere(context, 0.0, 1.0, 0.0);
        check_closed_sphere(context, 0.0, 1e-4, -1.0);
        air_context_destroy(context);
    }
}

enum { ROOF_SQUARES = 16 };

/* A roof of squares over the cube, at heights between 1.0 and 1.5, seen from above a lattice of the
 * given step about 0, whose points are moved by up to blur. */
static void make_roof(double step, double blur)
{
    static float points[ROOF_SQUARES + 1][ROOF_SQUARES + 1][3];
    air_rng rng = air_rng_from_keys(6, 20);
    for (int y = 0; y <= ROOF_SQUARES; y++) {
        for (int x = 0; x <= ROOF_SQUARES; x++) {
            float *p = points[y][x];
            p[0] = (float)(step * (x - ROOF_SQUARES / 2) + random_between(&rng, -blur, blur));
            p[1] = (float)(step * (y - ROOF_SQUARES / 2) + random_between(&rng, -blur, blur));
            p[2] = 1.0f + 0.0625f * (float)((x * 5 + y * 3) % 8);
        }
    }
    mesh.count = 0;
    for (int y = 0; y < ROOF_SQUARES; y++) {
        for (int x = 0; x < ROOF_SQUARES; x++) {
            add_triangle(&mesh, points[y][x], points[y][x + 1], points[y + 1][x]);
            add_triangle(&mesh, points[y][x + 1], points[y + 1][x + 1], points[y + 1][x]);
        }
    }
}

static void rays_along_the_edges_of_a_roof_see_no_light(void **state)
{
    (void)state;
    static const double slopes[] = {0.0, -0.0, 1e-60, -1e-60, 1e-30, -1e-30, 0.3, -0.3};
    static const double ways[][2] = {{1, 0},     {1, -0.0},   {-1, 0},     {-1, -0.0}, {0, 1},
                                     {-0.0, 1},  {0, -1},     {-0.0, -1},  {1, -1},    {-1, 1},
                                     {1, 1e-60}, {1, -1e-60}, {-1e-60, 1}, {1e-60, -1}};
    air_context *context = create_context();
    make_roof(0.125, 0.0); /* on dyadic numbers: rays run along its edges to the last bit */
    start_scene(0.0, 0.0, 1.0);
    for (int covers = 0; covers < 2; covers++) {
        air_shadow_tree_params params;
        air_shadow_tree_params_default(&params);
        params.covers = covers == 1;
        air_shadow_tree *tree = make_tree(context, &scene, &params);
        for (int i = 0; i < 15 * 15 * 8 * 14; i++) {
            const int at = i / (8 * 14);
            const double *way = ways[i % 14];
            const double o[3] = {-0.875 + 0.125 * (at % 15), -0.875 + 0.125 * (at / 15), 0.0};
            double v[3] = {way[0], way[1], slopes[i / 14 % 8]};
            air_interval found[8];
            normalise(v);
            assert_int_equal(air_shadow_tree_query(tree, o, v, -0.1, 0.1, found, 8), 1);
            assert_true(found[0].begin == -0.1 && found[0].end == 0.1);
        }
        air_shadow_tree_destroy(tree);
    }
    air_context_destroy(context);
}

/* The lattice is that of the tree's cells, two of the cube's sides and the pad of 2e-6 of them at
 * either end: rays, edges and borders of cells lie within some roundings of floats of each other.
 */
static void rays_along_borders_of_cells_see_no_light(void **state)
{
    (void)state;
    const double step = (1.0 + 4e-6) / (ROOF_SQUARES / 2);
    air_context *context = create_context();
    air_rng rng = air_rng_from_keys(7, 20);
    make_roof(step, 1.5e-7);
    start_scene(0.0, 0.0, 1.0);
    for (int covers = 0; covers < 2; covers++) {
        air_shadow_tree_params params;
        air_shadow_tree_params_default(&params);
        params.covers = covers == 1;
        air_shadow_tree *tree = make_tree(context, &scene, &params);
        for (int i = 0; i < 50000; i++) {
            const size_t across = (size_t)(i % 2), along = 1 - across;
            double o[3] = {0.0, 0.0, random_between(&rng, -0.5, 0.5)}, v[3] = {0.0, 0.0, 0.0};
            air_interval found[64];
            o[across] = step * (double)(air_rng_next(&rng) % 15u) - 7.0 * step;
            o[across] += random_between(&rng, -2e-7, 2e-7);
            v[across] = random_between(&rng, -2e-7, 2e-7);
            v[along] = 1.0;
            normalise(v);
            assert_int_equal(air_shadow_tree_query(tree, o, v, -0.9, 0.9, found, 64), 1);
            assert_true(found[0].begin == -0.9 && found[0].end == 0.9);
        }
        air_shadow_tree_destroy(tree);
    }
    air_context_destroy(context);
}

/* ---- parts ---- */

static double total_length(const air_interval *intervals, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        assert_true(intervals[i].begin < intervals[i].end);
        assert_true(i == 0 || intervals[i - 1].end < intervals[i].begin);
        sum += intervals[i].end - intervals[i].begin;
    }
    return sum;
}

/* How much of one list is not in the other. */
static double difference(const air_interval *a, size_t a_count, const air_interval *b,
                         size_t b_count)
{
    static air_interval both[2 * MOST_SHADOWS];
    const size_t count = air_intervals_intersect(a, a_count, b, b_count, both);
    return total_length(a, a_count) + total_length(b, b_count) - 2.0 * total_length(both, count);
}

/* A ray's parameter reaches 3.5 here; cut elsewhere it is rounded elsewhere, by 2^-23 at most, at
 * either side of the cut. */
static const double cut_error = 2.4e-7;

static void parts_of_a_ray_add_up_to_the_whole(void **state)
{
    (void)state;
    static air_interval whole[MOST_SHADOWS], parts[2 * MOST_SHADOWS];
    air_context *context = create_context();
    air_rng rng = air_rng_from_keys(3, 20);
    size_t most = 0;
    make_soup(&mesh, 1000, 3);
    start_scene(0.3, 0.5, -0.6);
    air_shadow_tree *tree = make_tree(context, &scene, NULL);
    for (int i = 0; i < 5000; i++) {
        double o[3], v[3], end;
        random_ray(&rng, o, v, &end);
        const double middle = end * random_unit(&rng);
        const size_t count = air_shadow_tree_query(tree, o, v, 0.0, end, whole, MOST_SHADOWS);
        size_t both = air_shadow_tree_query(tree, o, v, 0.0, middle, parts, MOST_SHADOWS);
        both += air_shadow_tree_query(tree, o, v, middle, end, parts + both, MOST_SHADOWS);
        both = air_intervals_join(parts, both);
        assert_true(difference(whole, count, parts, both) <= cut_error);
        most = count > most ? count : most;
    }
    assert_true(most > 4);
    air_shadow_tree_destroy(tree);
    air_context_destroy(context);
}

/* The answer through a list that holds few, by halves. */
static size_t ask_by_halves(const air_shadow_tree *tree, const double o[3], const double v[3],
                            double begin, double end, size_t capacity, air_interval *out)
{
    const size_t count = air_shadow_tree_query(tree, o, v, begin, end, out, capacity);
    if (count <= capacity) {
        return count;
    }
    const double middle = 0.5 * (begin + end);
    const size_t left = ask_by_halves(tree, o, v, begin, middle, capacity, out);
    return left + ask_by_halves(tree, o, v, middle, end, capacity, out + left);
}

static void a_full_list_says_so_and_halves_make_the_whole(void **state)
{
    (void)state;
    static air_interval whole[MOST_SHADOWS], parts[MOST_SHADOWS];
    air_context *context = create_context();
    air_rng rng = air_rng_from_keys(4, 20);
    int overflows = 0;
    make_soup(&mesh, 1000, 3);
    start_scene(0.3, 0.5, -0.6);
    air_shadow_tree *tree = make_tree(context, &scene, NULL);
    for (int i = 0; i < 5000; i++) {
        double o[3], v[3], end;
        const size_t capacity = 1 + (size_t)i % 3;
        random_ray(&rng, o, v, &end);
        const size_t count = air_shadow_tree_query(tree, o, v, 0.0, end, whole, MOST_SHADOWS);
        parts[capacity] = (air_interval){-7.0, -8.0}; /* beyond the list: not to be touched */
        const size_t found = air_shadow_tree_query(tree, o, v, 0.0, end, parts, capacity);
        assert_true(parts[capacity].begin == -7.0 && parts[capacity].end == -8.0);
        assert_true(count <= capacity || found > capacity);
        assert_int_equal(air_shadow_tree_query(tree, o, v, 0.0, end, NULL, 0) > 0, count > 0);
        overflows += found > capacity;
        size_t joined = ask_by_halves(tree, o, v, 0.0, end, capacity, parts);
        joined = air_intervals_join(parts, joined);
        /* one cut for each overflow, few per ray */
        assert_true(difference(whole, count, parts, joined) <= 16.0 * cut_error);
    }
    assert_true(overflows > 500);
    air_shadow_tree_destroy(tree);
    air_context_destroy(context);
}

/* ---- rays that are none ---- */

static void rays_that_are_not_finite_give_nothing_or_numbers(void **state)
{
    (void)state;
    static const double odd[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 1e39, -1e39, 0.0};
    air_context *context = create_context();
    air_rng rng = air_rng_from_keys(5, 20);
    air_interval found[64];
    make_soup(&mesh, 1000, 3);
    start_scene(0.3, 0.5, -0.6);
    air_shadow_tree *tree = make_tree(context, &scene, NULL);
    for (int i = 0; i < 20000; i++) {
        double ray[8]; /* origin, direction, begin, end */
        random_ray(&rng, ray, ray + 3, &ray[7]);
        ray[6] = 0.0;
        for (uint32_t k = 0; k <= air_rng_next(&rng) % 3u; k++) {
            ray[air_rng_next(&rng) % 8u] = odd[air_rng_next(&rng) % 8u];
        }
        const size_t count = air_shadow_tree_query(tree, ray, ray + 3, ray[6], ray[7], found, 64);
        for (size_t k = 0; k < count && count <= 64; k++) {
            if (!(isfinite(found[k].begin) && isfinite(found[k].end))) {
                fail_msg("[%g, %g] of (%g, %g, %g) + t (%g, %g, %g), t in [%g, %g]", found[k].begin,
                         found[k].end, ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], ray[6],
                         ray[7]);
            }
        }
    }
    air_shadow_tree_destroy(tree);
    air_context_destroy(context);
}

static void snap_to_quarters(double v[3])
{
    for (int i = 0; i < 3; i++) {
        v[i] = floor(4.0 * v[i]) / 4.0;
    }
}

/* Corners and rays on a lattice of quarters: shadows end where rays do, and some that are found are
 * one float long. */
static void lists_are_sorted_disjoint_and_without_empty_intervals(void **state)
{
    (void)state;
    air_context *context = create_context();
    air_rng rng = air_rng_from_keys(9, 20);
    air_interval found[256];
    for (uint32_t n = 0; n < 120; n++) {
        make_soup(&mesh, 200, n + 1);
        for (size_t i = 0; i < 9 * mesh.count; i++) {
            mesh.positions[i] = floorf(4.0f * mesh.positions[i]) / 4.0f;
        }
        start_scene(n % 3 == 0 ? 1.0 : 0.0, n % 3 == 1 ? 1.0 : 0.0, n % 3 == 2 ? 1.0 : 0.0);
        air_shadow_tree *tree = make_tree(context, &scene, NULL);
        for (int i = 0; i < 1000; i++) {
            double o[3], v[3];
            for (int k = 0; k < 3; k++) {
                o[k] = random_between(&rng, -1.0, 1.0);
                v[k] = random_between(&rng, -1.0, 1.0);
            }
            snap_to_quarters(o);
            snap_to_quarters(v);
            for (int k = 0; k < 3; k++) {
                v[k] -= o[k];
            }
            const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            if (length == 0.0) {
                continue;
            }
            normalise(v);
            const size_t count = air_shadow_tree_query(tree, o, v, 0.0, length, found, 256);
            assert_true(count <= 256);
            for (size_t k = 0; k < count; k++) {
                assert_true(found[k].begin < found[k].end);
                assert_true(found[k].begin >= (k > 0 ? found[k - 1].end : 0.0));
                assert_true(found[k].end <= length);
            }
        }
        air_shadow_tree_destroy(tree);
    }
    air_context_destroy(context);
}

static void an_empty_stretch_has_no_shadow(void **state)
{
    (void)state;
    const double o[3] = {0.2, 0.4, 0.0}, v[3] = {1.0, 0.0, 0.0};
    air_context *context = create_context();
    air_interval found[4];
    make_sphere(&mesh, centre, radius, 8);
    start_scene(0.0, 1.0, 0.0);
    air_shadow_tree *tree = make_tree(context, &scene, NULL);
    assert_int_equal(air_shadow_tree_query(tree, o, v, -0.1, 0.1, found, 4), 1);
    assert_int_equal(air_shadow_tree_query(tree, o, v, 0.1, 0.1, found, 4), 0);
    assert_int_equal(air_shadow_tree_query(tree, o, v, 0.1, -0.1, found, 4), 0);
    air_shadow_tree_destroy(tree);
    air_context_destroy(context);
}

static void without_triangles_there_is_no_shadow(void **state)
{
    (void)state;
    const double o[3] = {0.2, 0.4, 0.0}, v[3] = {1.0, 0.0, 0.0};
    air_context *context = create_context();
    air_interval found[4];
    mesh.count = 0;
    start_scene(0.0, 1.0, 0.0);
    for (size_t meshes = 0; meshes < 2; meshes++) {
        scene.mesh_count = meshes;
        scene.meshes = meshes == 0 ? NULL : &borrowed;
        air_shadow_tree *tree = make_tree(context, &scene, NULL);
        assert_true(air_shadow_tree_size(tree) > 0);
        assert_int_equal(air_shadow_tree_query(tree, o, v, -1.0, 0.5, found, 4), 0);
        air_shadow_tree_destroy(tree);
    }
    air_shadow_tree_destroy(NULL);
    air_context_destroy(context);
}

/* ---- what the caller can get wrong ---- */

static const double hull[2][3] = {{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};

static void params_of_cube(air_shadow_tree_params *params)
{
    air_shadow_tree_params_default(params);
    params->to_light[1] = 1.0;
    params->hull = hull[0];
    params->hull_count = 2;
}

static void assert_refused(air_context *context, const air_shadow_tree_params *params,
                           const char *named)
{
    air_shadow_tree *tree = (air_shadow_tree *)(void *)&scene;
    assert_int_equal(air_shadow_tree_create(context, params, &borrowed, 1, &tree),
                     AIR_ERROR_ARGUMENT);
    assert_null(tree);
    if (strstr(air_context_last_error(context), named) == NULL) {
        fail_msg("\"%s\" does not name \"%s\"", air_context_last_error(context), named);
    }
}

static void wrong_parameters_are_refused_by_name(void **state)
{
    (void)state;
    static const double lights[][3] = {
        {NAN, 0.0, 1.0}, {0.0, 0.0, 0.0}, {0.0, 1.0 + 1e-5, 0.0}, {0.0, INFINITY, 0.0}};
    air_context *context = create_context();
    air_shadow_tree_params params;
    double broken[2][3] = {{-1.0, -1.0, -1.0}, {1.0, NAN, 1.0}};
    make_sphere(&mesh, centre, radius, 2);
    borrowed = borrow_mesh(&mesh);
    params_of_cube(&params);
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) {
        memcpy(params.to_light, lights[i], sizeof params.to_light);
        assert_refused(context, &params, "direction to the light");
    }
    params_of_cube(&params);
    params.hull_count = 0;
    assert_refused(context, &params, "hull has no points");
    params_of_cube(&params);
    params.hull = NULL;
    assert_refused(context, &params, "hull has no points");
    params_of_cube(&params);
    params.hull = broken[0];
    assert_refused(context, &params, "point 1 of the hull");
    params_of_cube(&params);
    params.leaf_size = 0;
    assert_refused(context, &params, "leaf size 0");
    params.leaf_size = 65;
    assert_refused(context, &params, "leaf size 65");
    params_of_cube(&params);
    params.max_depth = 17;
    assert_refused(context, &params, "depth 17");
    air_context_destroy(context);
}

static void wrong_meshes_are_refused_by_name(void **state)
{
    (void)state;
    air_context *context = create_context();
    air_shadow_tree_params params;
    params_of_cube(&params);
    make_sphere(&mesh, centre, radius, 2);
    borrowed = borrow_mesh(&mesh);
    mesh.indices[7] = (uint32_t)borrowed.vertex_count;
    assert_refused(context, &params, "mesh 0, triangle 2: index 96");
    borrowed = borrow_mesh(&mesh);
    mesh.positions[3 * 11 + 1] = NAN;
    assert_refused(context, &params, "mesh 0, vertex 11: position is not finite");
    mesh.positions[3 * 11 + 1] = INFINITY;
    assert_refused(context, &params, "mesh 0, vertex 11: position is not finite");
    mesh.positions[3 * 11 + 1] = 0.0f;
    borrowed.indices = NULL;
    assert_refused(context, &params, "mesh 0 has no positions or no indices");
    borrowed = borrow_mesh(&mesh);
    borrowed.positions = NULL;
    assert_refused(context, &params, "mesh 0 has no positions or no indices");
    air_context_destroy(context);
}

/* ---- when memory fails ---- */

static void check_failing_allocations(size_t threads, long least)
{
    failing_allocator allocator;
    air_context_params context_params = failing_params(&allocator, LONG_MAX);
    air_context *context;
    air_shadow_tree_params params;
    air_shadow_tree *tree = NULL;
    air_status status = AIR_ERROR_MEMORY;
    long failures = 0;
    context_params.thread_count = threads;
    assert_int_equal(air_context_create(&context_params, &context), AIR_OK);
    params_of_cube(&params);
    const long live = atomic_load(&allocator.live);
    for (long allowed = 0; status != AIR_OK; allowed++) {
        tree = (air_shadow_tree *)(void *)&scene;
        atomic_store(&allocator.remaining, allowed);
        status = air_shadow_tree_create(context, &params, &borrowed, 1, &tree);
        if (status != AIR_OK) {
            assert_int_equal(status, AIR_ERROR_MEMORY);
            assert_null(tree);
            assert_int_equal(atomic_load(&allocator.live), live);
            failures++;
        }
    }
    assert_true(failures >= least);
    air_shadow_tree_destroy(tree);
    assert_int_equal(atomic_load(&allocator.live), live);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

static void any_failing_allocation_is_an_error_and_loses_nothing(void **state)
{
    (void)state;
    make_sphere(&mesh, centre, radius, 12);
    borrowed = borrow_mesh(&mesh);
    check_failing_allocations(1, 100);
    check_failing_allocations(2, 100);
    mesh.count = 5; /* no cell is divided */
    borrowed = borrow_mesh(&mesh);
    check_failing_allocations(1, 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(instruction_sets_and_threads_give_the_same_bits),
        cmocka_unit_test(no_ray_finds_a_crack_in_a_closed_sphere),
        cmocka_unit_test(rays_along_the_edges_of_a_roof_see_no_light),
        cmocka_unit_test(rays_along_borders_of_cells_see_no_light),
        cmocka_unit_test(parts_of_a_ray_add_up_to_the_whole),
        cmocka_unit_test(a_full_list_says_so_and_halves_make_the_whole),
        cmocka_unit_test(rays_that_are_not_finite_give_nothing_or_numbers),
        cmocka_unit_test(lists_are_sorted_disjoint_and_without_empty_intervals),
        cmocka_unit_test(an_empty_stretch_has_no_shadow),
        cmocka_unit_test(without_triangles_there_is_no_shadow),
        cmocka_unit_test(wrong_parameters_are_refused_by_name),
        cmocka_unit_test(wrong_meshes_are_refused_by_name),
        cmocka_unit_test(any_failing_allocation_is_an_error_and_loses_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The default ray backend. */
#include "core/ray_embree.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/host.h"
#include "core/random.h"
#include "core/vec.h"
#include "core/warp.h"
#include "failing_allocator.h"
#include "ray_tracer.h"

enum { RINGS = 40, SPOKES = 80, SOUP = 300, RAYS = 20000, BOX_VERTICES = 24, CAPACITY = 64 };
enum { SPHERE_VERTICES = 2 + (RINGS - 1) * SPOKES, SPHERE_TRIANGLES = 2 * SPOKES * (RINGS - 1) };

/* ---- meshes ---- */

static float sphere_positions[3 * SPHERE_VERTICES + 1];
static uint32_t sphere_indices[3 * SPHERE_TRIANGLES];
static float soup_positions[9 * SOUP + 1];
static uint32_t soup_indices[3 * SOUP];

static uint32_t sphere_vertex(int ring, int spoke)
{
    if (ring == 0 || ring == RINGS) {
        return ring == 0 ? 0 : 1;
    }
    return (uint32_t)(2 + (ring - 1) * SPOKES + spoke % SPOKES);
}

static void add_triangle(uint32_t *indices, size_t *count, uint32_t a, uint32_t b, uint32_t c)
{
    if (a != b && b != c && a != c) {
        indices[3 * *count] = a;
        indices[3 * *count + 1] = b;
        indices[3 * *count + 2] = c;
        ++*count;
    }
}

/* A closed sphere of radius 1, outward, with shared vertices. */
static air_ray_mesh make_sphere(void)
{
    for (int ring = 0; ring <= RINGS; ++ring) {
        for (int spoke = 0; spoke < SPOKES; ++spoke) {
            const double theta = AIR_PI * ring / RINGS, phi = 2.0 * AIR_PI * spoke / SPOKES;
            const double r = ring % RINGS == 0 ? 0.0 : sin(theta);
            vec3_store(sphere_positions + 3 * sphere_vertex(ring, spoke),
                       vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)cos(theta)));
        }
    }
    size_t count = 0;
    for (int ring = 0; ring < RINGS; ++ring) {
        for (int spoke = 0; spoke < SPOKES; ++spoke) {
            const uint32_t a = sphere_vertex(ring, spoke), b = sphere_vertex(ring, spoke + 1);
            const uint32_t c = sphere_vertex(ring + 1, spoke),
                           d = sphere_vertex(ring + 1, spoke + 1);
            add_triangle(sphere_indices, &count, a, c, b);
            add_triangle(sphere_indices, &count, b, c, d);
        }
    }
    assert_int_equal(count, SPHERE_TRIANGLES);
    return (air_ray_mesh){.positions = sphere_positions,
                          .vertex_count = SPHERE_VERTICES,
                          .indices = sphere_indices,
                          .triangle_count = SPHERE_TRIANGLES,
                          .mask = 1};
}

typedef struct box_mesh {
    float positions[3 * BOX_VERTICES + 1];
    uint32_t indices[36];
} box_mesh;

/* An outward box around 0 with four vertices of its own per face, as files with flat normals have.
 */
static air_ray_mesh make_box(box_mesh *box, float half, uint32_t mask)
{
    size_t count = 0;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const float side = face % 2 == 0 ? half : -half;
        for (int corner = 0; corner < 4; ++corner) {
            float *p = box->positions + 3 * (4 * face + corner);
            p[axis] = side;
            p[(axis + 1) % 3] = (corner == 1 || corner == 2) == (side > 0.0f) ? half : -half;
            p[(axis + 2) % 3] = corner >= 2 ? half : -half;
        }
        const uint32_t first = (uint32_t)(4 * face);
        add_triangle(box->indices, &count, first, first + 1, first + 2);
        add_triangle(box->indices, &count, first, first + 2, first + 3);
    }
    return (air_ray_mesh){.positions = box->positions,
                          .vertex_count = BOX_VERTICES,
                          .indices = box->indices,
                          .triangle_count = 12,
                          .mask = mask};
}

/* Separate random triangles in the unit cube. */
static air_ray_mesh make_soup(void)
{
    air_rng rng = air_rng_from_keys(21, 22);
    for (uint32_t i = 0; i < SOUP; ++i) {
        const float centre[3] = {air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)};
        for (uint32_t k = 0; k < 9; ++k) {
            soup_positions[9 * i + k] = centre[k % 3] + 0.3f * (air_rng_float(&rng) - 0.5f);
        }
        for (uint32_t k = 0; k < 3; ++k) {
            soup_indices[3 * i + k] = 3 * i + k;
        }
    }
    return (air_ray_mesh){.positions = soup_positions,
                          .vertex_count = 3 * SOUP,
                          .indices = soup_indices,
                          .triangle_count = SOUP,
                          .mask = 1};
}

/* ---- fixture ---- */

static ray_tracer build(const air_ray_mesh *meshes, size_t count)
{
    return ray_tracer_build(NULL, meshes, count);
}

static air_hit trace(const ray_tracer *self, const air_ray *ray)
{
    air_hit hit;
    self->backend.intersect(self->accelerator, ray, 1, &hit);
    return hit;
}

static bool is_occluded(const ray_tracer *self, const air_ray *ray)
{
    uint8_t occluded = 2;
    self->backend.occluded(self->accelerator, ray, 1, &occluded);
    assert_true(occluded <= 1);
    return occluded != 0;
}

static size_t trace_all(const ray_tracer *self, const air_ray *ray, air_hit *hits, size_t capacity)
{
    return self->backend.intersect_all(self->accelerator, ray, hits, capacity);
}

static bool is_hit(const air_hit *hit) { return hit->mesh != (uint32_t)AIR_NO_HIT; }

static air_vec3 random_point(air_rng *rng, float size)
{
    return vec3(size * (air_rng_float(rng) - 0.5f), size * (air_rng_float(rng) - 0.5f),
                size * (air_rng_float(rng) - 0.5f));
}

static air_vec3 corner(const air_ray_mesh *mesh, size_t triangle, int k)
{
    return vec3_load(mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + (size_t)k]);
}

/* ---- nearest hits and occlusion ---- */

/* A direction from origin to a random point of a random edge of the sphere, away from its corners.
 */
static air_vec3 towards_edge(const air_ray_mesh *sphere, air_rng *rng, air_vec3 origin)
{
    const size_t triangle = air_rng_next(rng) % SPHERE_TRIANGLES;
    const air_vec3 a = corner(sphere, triangle, 0), b = corner(sphere, triangle, 1);
    const float s = 0.05f + 0.9f * air_rng_float(rng);
    return vec3_sub(vec3_madd(a, s, vec3_sub(b, a)), origin);
}

enum { BUNDLE = 16 };

static void check_bundle_inside(const ray_tracer *self, const air_ray_mesh *sphere, air_rng *rng)
{
    air_ray rays[BUNDLE];
    air_hit hits[BUNDLE];
    uint8_t occluded[BUNDLE];
    const air_vec3 origin = random_point(rng, 1.0f);
    const air_vec3 axis = towards_edge(sphere, rng, origin);
    for (int i = 0; i < BUNDLE; ++i) {
        const air_vec3 spread = random_point(rng, i % 4 == 0 ? 0.0f : 0.003f);
        rays[i] = ray_tracer_ray(origin, vec3_add(axis, spread));
    }
    self->backend.intersect(self->accelerator, rays, BUNDLE, hits);
    self->backend.occluded(self->accelerator, rays, BUNDLE, occluded);
    for (int i = 0; i < BUNDLE; ++i) {
        assert_true(is_hit(&hits[i]));
        assert_int_equal(occluded[i], 1);
    }
}

static void nothing_leaks_out_of_a_closed_mesh_at_any_instruction_set(void **state)
{
    (void)state;
    const air_ray_mesh sphere = make_sphere();
    air_context_params params;
    air_context_params_default(&params);
    for (int cpu = AIR_CPU_C; cpu <= AIR_CPU_AVX512; ++cpu) {
        params.cpu = (air_cpu)cpu;
        air_context *probe = NULL;
        if (air_context_create(&params, &probe) != AIR_OK) {
            continue;
        }
        air_context_destroy(probe);
        ray_tracer self = ray_tracer_build(&params, &sphere, 1);
        air_rng rng = air_rng_from_keys(1, (uint32_t)cpu);
        for (int i = 0; i < RAYS; ++i) {
            const air_vec3 origin = random_point(&rng, 1.0f);
            const air_vec3 dir =
                i % 2 == 0 ? random_point(&rng, 1.0f) : towards_edge(&sphere, &rng, origin);
            const air_ray ray = ray_tracer_ray(origin, dir);
            const air_hit hit = trace(&self, &ray);
            assert_true(is_hit(&hit));
            assert_true(is_occluded(&self, &ray));
            check_bundle_inside(&self, &sphere, &rng);
        }
        ray_tracer_finish(&self);
    }
}

static void t_barycentrics_and_normal_describe_the_same_point(void **state)
{
    (void)state;
    const air_ray_mesh soup = make_soup();
    ray_tracer self = build(&soup, 1);
    air_rng rng = air_rng_from_keys(2, 1);
    int hits = 0;
    for (int i = 0; i < RAYS; ++i) {
        const air_vec3 origin = vec3_add(random_point(&rng, 2.0f), vec3_set1(0.5f));
        const air_vec3 dir = vec3_scale(random_point(&rng, 1.0f), 3.0f); /* not unit */
        const air_ray ray = ray_tracer_ray(origin, dir);
        const air_hit hit = trace(&self, &ray);
        if (!is_hit(&hit)) {
            continue;
        }
        ++hits;
        const air_vec3 a = corner(&soup, hit.triangle, 0), b = corner(&soup, hit.triangle, 1),
                       c = corner(&soup, hit.triangle, 2);
        const air_vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a);
        const air_vec3 surface = vec3_madd(vec3_madd(a, hit.u, ab), hit.v, ac);
        const air_vec3 along = vec3_madd(origin, hit.t, dir);
        const air_vec3 normal = vec3_cross(ab, ac), given = vec3_load(hit.normal);
        /* Lengths up to 3 carry a few 2^-24 each; a grazing ray divides that by the cosine, a thin
         * triangle (height over longest edge) by its thinness. */
        const float cosine =
            fabsf(vec3_dot(normal, dir)) / (vec3_length(normal) * vec3_length(dir));
        const float edge =
            fmaxf(vec3_length(ab), fmaxf(vec3_length(ac), vec3_length(vec3_sub(b, c))));
        const float thin = vec3_length(normal) / (edge * edge);
        const float tolerance = 32.0f * 3.0f * 0x1p-24f / (cosine * thin);
        assert_true(vec3_length(vec3_sub(surface, along)) < tolerance);
        assert_true(vec3_length(vec3_sub(normal, given)) < 32.0f * 3.0f * 0x1p-24f * edge);
        assert_true(hit.u >= -1e-5f && hit.v >= -1e-5f && hit.u + hit.v <= 1.0f + 1e-5f);
    }
    assert_true(hits > RAYS / 10);
    ray_tracer_finish(&self);
}

/* t of the triangle in double [MoellerTrumbore1997]; INFINITY if missed, NAN if too near an edge or
 * the plane to tell. */
static double exact_hit(const air_ray_mesh *mesh, size_t triangle, const air_ray *ray)
{
    double e1[3], e2[3], s[3], p[3], q[3];
    const float *a = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle];
    const float *b = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + 1];
    const float *c = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + 2];
    for (int i = 0; i < 3; ++i) {
        e1[i] = (double)b[i] - (double)a[i];
        e2[i] = (double)c[i] - (double)a[i];
        s[i] = (double)ray->origin[i] - (double)a[i];
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        p[i] = (double)ray->dir[j] * e2[k] - (double)ray->dir[k] * e2[j];
        q[i] = s[j] * e1[k] - s[k] * e1[j];
    }
    const double determinant = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
    const double u = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) / determinant;
    const double v =
        ((double)ray->dir[0] * q[0] + (double)ray->dir[1] * q[1] + (double)ray->dir[2] * q[2]) /
        determinant;
    const double t = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / determinant;
    const double inside = fmin(u, fmin(v, 1.0 - u - v));
    if (inside > -0.1 && (fabs(determinant) < 1e-4 || fabs(inside) < 1e-4 || fabs(t) < 1e-4)) {
        return NAN;
    }
    return inside > 0.0 && t > 0.0 ? t : INFINITY;
}

static void hits_agree_with_testing_every_triangle(void **state)
{
    (void)state;
    const air_ray_mesh soup = make_soup();
    ray_tracer self = build(&soup, 1);
    air_rng rng = air_rng_from_keys(3, 1);
    int compared = 0;
    for (int i = 0; i < RAYS / 4; ++i) {
        const air_ray ray = ray_tracer_ray(vec3_add(random_point(&rng, 1.5f), vec3_set1(0.5f)),
                                           random_point(&rng, 2.0f));
        double nearest = INFINITY;
        size_t count = 0;
        bool clear = true;
        for (size_t k = 0; k < SOUP; ++k) {
            const double t = exact_hit(&soup, k, &ray);
            clear = clear && !isnan(t);
            nearest = fmin(nearest, t);
            count += isfinite(t);
        }
        if (!clear) {
            continue;
        }
        ++compared;
        air_hit hits[CAPACITY];
        const air_hit hit = trace(&self, &ray);
        assert_int_equal(is_hit(&hit), count > 0);
        assert_int_equal(is_occluded(&self, &ray), count > 0);
        assert_int_equal(trace_all(&self, &ray, hits, CAPACITY), count);
        if (count > 0) {
            /* determinant >= 1e-4 bounds the amplification of about ten roundings of values
             * below 3. */
            assert_true(fabs((double)hit.t - nearest) < 30.0 * 0x1p-24 / 1e-4);
        }
    }
    assert_true(compared > RAYS / 16);
    ray_tracer_finish(&self);
}

enum { BATCH = 1000 };

/* Half of the rays form a narrow bundle, as a pixel's do; the others go everywhere. */
static void make_batch(air_ray rays[BATCH])
{
    air_rng rng = air_rng_from_keys(4, 1);
    for (int i = 0; i < BATCH; ++i) {
        const air_vec3 spread = random_point(&rng, 0.01f);
        rays[i] = i % 64 < 32 ? ray_tracer_ray(vec3(0.1f, 0.2f, 3.0f),
                                               vec3_add(spread, vec3(0.1f, 0.0f, -1.0f)))
                              : ray_tracer_ray(random_point(&rng, 3.0f), random_point(&rng, 1.0f));
        rays[i].tmax = 4.0f * air_rng_float(&rng);
    }
}

static void batches_meet_what_single_rays_meet(void **state)
{
    (void)state;
    const air_ray_mesh meshes[2] = {make_sphere(), make_soup()};
    ray_tracer self = build(meshes, 2);
    static air_ray rays[BATCH];
    static air_hit hits[BATCH];
    static uint8_t occluded[BATCH];
    make_batch(rays);
    for (size_t size = 1; size <= BATCH; size = size * 3 + 1) {
        self.backend.intersect(self.accelerator, rays, size, hits);
        self.backend.occluded(self.accelerator, rays, size, occluded);
        for (size_t i = 0; i < size; ++i) {
            const air_hit single = trace(&self, &rays[i]);
            assert_int_equal(single.mesh, hits[i].mesh);
            assert_int_equal(occluded[i], is_hit(&single));
            assert_int_equal(occluded[i], is_occluded(&self, &rays[i]));
            if (is_hit(&single)) {
                /* Both carry a few 2^-24 of coordinates up to 8, across the surface. */
                const air_vec3 n = vec3_load(single.normal);
                const float across =
                    fabsf((single.t - hits[i].t) * vec3_dot(n, vec3_load(rays[i].dir)));
                assert_true(across <= 8.0f * 8.0f * 0x1p-24f * vec3_length(n));
            }
        }
    }
    ray_tracer_finish(&self);
}

static void a_batch_gives_the_same_bytes_again(void **state)
{
    (void)state;
    const air_ray_mesh meshes[2] = {make_sphere(), make_soup()};
    static air_ray rays[BATCH];
    static air_hit hits[2][BATCH];
    make_batch(rays);
    memset(hits, 0, sizeof hits);
    for (size_t i = 0; i < 2; ++i) {
        ray_tracer self = build(meshes, 2);
        self.backend.intersect(self.accelerator, rays, BATCH, hits[i]);
        ray_tracer_finish(&self);
    }
    assert_memory_equal(hits[0], hits[1], sizeof hits[0]);
}

static void the_number_of_build_threads_changes_no_hit(void **state)
{
    (void)state;
    const air_ray_mesh meshes[2] = {make_sphere(), make_soup()};
    air_context_params params;
    air_context_params_default(&params);
    params.thread_count = 1;
    ray_tracer one = ray_tracer_build(&params, meshes, 2);
    params.thread_count = 4;
    ray_tracer four = ray_tracer_build(&params, meshes, 2);
    air_rng rng = air_rng_from_keys(5, 1);
    for (int i = 0; i < RAYS; ++i) {
        const air_vec3 origin = random_point(&rng, 1.0f);
        /* Half of the rays aim at corners, where several triangles tie. */
        const air_vec3 at = i % 2 == 0
                                ? random_point(&rng, 2.0f)
                                : corner(&meshes[0], air_rng_next(&rng) % SPHERE_TRIANGLES, 0);
        const air_ray ray = ray_tracer_ray(origin, vec3_sub(at, origin));
        air_hit a = {0}, b = {0};
        one.backend.intersect(one.accelerator, &ray, 1, &a);
        four.backend.intersect(four.accelerator, &ray, 1, &b);
        assert_memory_equal(&a, &b, sizeof a);
    }
    ray_tracer_finish(&one);
    ray_tracer_finish(&four);
}

static void masks_choose_the_meshes(void **state)
{
    (void)state;
    static box_mesh small, large;
    const air_ray_mesh meshes[2] = {make_box(&small, 1.0f, 1), make_box(&large, 2.0f, 6)};
    ray_tracer self = build(meshes, 2);
    air_ray ray = ray_tracer_ray(vec3(-5.0f, 0.1f, 0.2f), vec3(1.0f, 0.0f, 0.0f));
    const struct {
        uint32_t mask, mesh, count;
    } cases[] = {{1, 0, 2}, {2, 1, 2},          {4, 1, 2},         {7, 1, 4},
                 {3, 1, 4}, {8, UINT32_MAX, 0}, {0, UINT32_MAX, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        air_hit hits[CAPACITY];
        ray.mask = cases[i].mask;
        assert_int_equal(trace(&self, &ray).mesh, cases[i].mesh);
        assert_int_equal(is_occluded(&self, &ray), cases[i].count > 0);
        assert_int_equal(trace_all(&self, &ray, hits, CAPACITY), cases[i].count);
    }
    ray_tracer_finish(&self);
}

static void the_interval_is_open_at_both_ends(void **state)
{
    (void)state;
    static box_mesh box;
    const air_ray_mesh mesh = make_box(&box, 1.0f, 1);
    ray_tracer self = build(&mesh, 1);
    const float inf = INFINITY;
    const struct {
        float tmin, tmax;
        size_t count;
    } cases[] = {{0, inf, 2}, {4, inf, 1},   {0, 4, 0},       {4, 6, 0}, {3.99f, 6.01f, 2},
                 {6, inf, 0}, {0, 4.01f, 1}, {0, FLT_MAX, 2}, {0, 0, 0}, {5, 4.5f, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        air_hit hits[CAPACITY];
        air_ray ray = ray_tracer_ray(vec3(-5.0f, 0.25f, 0.5f), vec3(1.0f, 0.0f, 0.0f));
        ray.tmin = cases[i].tmin;
        ray.tmax = cases[i].tmax;
        const air_hit hit = trace(&self, &ray);
        assert_int_equal(is_hit(&hit), cases[i].count > 0);
        assert_int_equal(is_occluded(&self, &ray), cases[i].count > 0);
        assert_int_equal(trace_all(&self, &ray, hits, CAPACITY), cases[i].count);
    }
    ray_tracer_finish(&self);
}

static void meshes_keep_their_index_and_empty_ones_are_legal(void **state)
{
    (void)state;
    static box_mesh box;
    const air_ray_mesh empty = {.positions = box.positions, .indices = box.indices, .mask = 1};
    const air_ray_mesh meshes[3] = {empty, empty, make_box(&box, 1.0f, 1)};
    const air_ray ray = ray_tracer_ray(vec3(0.1f, 0.2f, 9.0f), vec3(0.0f, 0.0f, -1.0f));
    ray_tracer self = build(meshes, 3);
    assert_int_equal(trace(&self, &ray).mesh, 2);
    ray_tracer_finish(&self);
    ray_tracer nothing = build(meshes, 0);
    air_hit hits[1];
    assert_int_equal(trace(&nothing, &ray).mesh, UINT32_MAX);
    assert_false(is_occluded(&nothing, &ray));
    assert_int_equal(trace_all(&nothing, &ray, hits, 1), 0);
    ray_tracer_finish(&nothing);
}

/* ---- all hits ---- */

static bool enters(const air_hit *hit, const air_ray *ray)
{
    return vec3_dot(vec3_load(hit->normal), vec3_load(ray->dir)) < 0.0f;
}

/* Checks that hits are sorted and that, mesh by mesh, entries and exits alternate; returns their
 * sum (entries +1). */
static int check_alternating(const air_hit *hits, size_t count, const air_ray *ray, bool inside)
{
    int balance = inside ? 1 : 0;
    for (size_t i = 0; i < count; ++i) {
        assert_true(i == 0 || hits[i].t >= hits[i - 1].t);
        balance += enters(&hits[i], ray) ? 1 : -1;
        assert_in_range(balance, 0, 1);
    }
    return balance;
}

static void a_ray_enters_and_leaves_a_closed_mesh_in_turn(void **state)
{
    (void)state;
    const air_ray_mesh sphere = make_sphere();
    ray_tracer self = build(&sphere, 1);
    air_rng rng = air_rng_from_keys(6, 1);
    for (int i = 0; i < RAYS; ++i) {
        air_hit hits[CAPACITY];
        const air_vec3 origin =
            vec3_scale(sample_sphere(air_rng_float(&rng), air_rng_float(&rng)), 3.0f);
        air_vec3 at = random_point(&rng, 2.2f);
        if (i % 2 == 1) { /* through an edge */
            const size_t triangle = air_rng_next(&rng) % SPHERE_TRIANGLES;
            at = vec3_scale(vec3_add(corner(&sphere, triangle, 0), corner(&sphere, triangle, 1)),
                            0.5f);
        }
        const air_ray ray = ray_tracer_ray(origin, vec3_sub(at, origin));
        const size_t count = trace_all(&self, &ray, hits, CAPACITY);
        assert_true(count == 0 || count == 2);
        assert_int_equal(check_alternating(hits, count, &ray, false), 0);
        const air_ray out = ray_tracer_ray(random_point(&rng, 1.0f), random_point(&rng, 1.0f));
        assert_int_equal(trace_all(&self, &out, hits, CAPACITY), 1);
        assert_int_equal(check_alternating(hits, 1, &out, true), 0);
    }
    ray_tracer_finish(&self);
}

static void crossings_at_edges_and_corners_count_once(void **state)
{
    (void)state;
    static box_mesh box;
    const air_ray_mesh mesh = make_box(&box, 1.0f, 1);
    ray_tracer self = build(&mesh, 1);
    air_hit hits[CAPACITY];
    const struct {
        air_vec3 origin, dir;
    } cases[] = {
        {{0, 0, 5}, {0, 0, -1}},       /* the diagonals of two faces */
        {{5, 0.3f, 0.3f}, {-1, 0, 0}}, /* likewise, off the centre */
        {{3, 3, 0.4f}, {-1, -1, 0}},   /* two edges of the box */
        {{3, 3, 3}, {-1, -1, -1}},     /* two corners, each of at least three triangles */
        {{-3, 3, -3}, {1, -1, 1}},     /* two others */
        {{3, 1.5f, 0.25f}, {-1, -0.25f, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const air_ray ray = ray_tracer_ray(cases[i].origin, cases[i].dir);
        const size_t count = trace_all(&self, &ray, hits, CAPACITY);
        /* Two faces that meet at an edge are both entered (or both left) there: one crossing each
         * way. */
        assert_int_equal(count, 2);
        assert_int_equal(check_alternating(hits, count, &ray, false), 0);
    }
    ray_tracer_finish(&self);
}

static void coincident_faces_of_different_meshes_are_all_kept(void **state)
{
    (void)state;
    static box_mesh a, b, c;
    const air_ray_mesh meshes[3] = {make_box(&a, 1.0f, 1), make_box(&b, 1.0f, 1),
                                    make_box(&c, 0.5f, 1)};
    ray_tracer self = build(meshes, 3);
    air_hit hits[CAPACITY];
    const air_ray ray = ray_tracer_ray(vec3(0.1f, 0.2f, 5.0f), vec3(0.0f, 0.0f, -1.0f));
    const uint32_t order[6] = {0, 1, 2, 2, 0, 1};
    assert_int_equal(trace_all(&self, &ray, hits, CAPACITY), 6);
    for (size_t i = 0; i < 6; ++i) {
        assert_int_equal(hits[i].mesh, order[i]);
        assert_int_equal(enters(&hits[i], &ray), i < 3);
    }
    ray_tracer_finish(&self);
}

static void the_nearest_are_kept_when_there_is_no_room_for_all(void **state)
{
    (void)state;
    const air_ray_mesh soup = make_soup();
    ray_tracer self = build(&soup, 1);
    air_rng rng = air_rng_from_keys(7, 1);
    size_t most = 0;
    for (int i = 0; i < RAYS / 4; ++i) {
        air_hit all[CAPACITY], some[CAPACITY];
        const air_ray ray = ray_tracer_ray(vec3_add(random_point(&rng, 1.0f), vec3_set1(0.5f)),
                                           random_point(&rng, 1.0f));
        const size_t count = trace_all(&self, &ray, all, CAPACITY);
        most = count > most ? count : most;
        for (size_t capacity = 0; capacity <= count; ++capacity) {
            assert_int_equal(trace_all(&self, &ray, some, capacity), capacity);
            if (capacity > 0) {
                assert_memory_equal(some, all, capacity * sizeof *all);
            }
        }
        if (count > 0) {
            const air_hit nearest = trace(&self, &ray);
            assert_memory_equal(&nearest, all, sizeof nearest);
        }
    }
    assert_true(most > 5 && most < CAPACITY);
    ray_tracer_finish(&self);
}

/* ---- failure ---- */

static void building_without_memory_fails_and_leaks_nothing(void **state)
{
    (void)state;
    static box_mesh box;
    const air_ray_mesh mesh = make_box(&box, 1.0f, 1);
    air_status status = AIR_ERROR_MEMORY;
    for (long allowed = 1; status != AIR_OK; ++allowed) {
        failing_allocator allocator;
        const air_context_params params = failing_params(&allocator, allowed);
        air_context *context = NULL;
        void *accelerator = NULL;
        assert_true(allowed < 20);
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        const air_ray_backend *backend = air_context_ray_backend(context);
        status = backend->build(backend->user, context, &mesh, 1, &accelerator);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_int_equal(accelerator != NULL, status == AIR_OK);
        backend->destroy(accelerator);
        air_context_destroy(context);
        assert_int_equal(atomic_load(&allocator.live), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_leaks_out_of_a_closed_mesh_at_any_instruction_set),
        cmocka_unit_test(t_barycentrics_and_normal_describe_the_same_point),
        cmocka_unit_test(hits_agree_with_testing_every_triangle),
        cmocka_unit_test(batches_meet_what_single_rays_meet),
        cmocka_unit_test(a_batch_gives_the_same_bytes_again),
        cmocka_unit_test(the_number_of_build_threads_changes_no_hit),
        cmocka_unit_test(masks_choose_the_meshes),
        cmocka_unit_test(the_interval_is_open_at_both_ends),
        cmocka_unit_test(meshes_keep_their_index_and_empty_ones_are_legal),
        cmocka_unit_test(a_ray_enters_and_leaves_a_closed_mesh_in_turn),
        cmocka_unit_test(crossings_at_edges_and_corners_count_once),
        cmocka_unit_test(coincident_faces_of_different_meshes_are_all_kept),
        cmocka_unit_test(the_nearest_are_kept_when_there_is_no_room_for_all),
        cmocka_unit_test(building_without_memory_fails_and_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Quadrics, by themselves and behind the default ray backend. */
#include "core/quadric.h"

#include <float.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/cpu.h"
#include "core/host.h"
#include "core/random.h"
#include "ray_tracer.h"

enum { RAYS = 4000, SHAPES = 3, PACKET = 16 };

static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static float between(air_rng *rng, float low, float high)
{
    return low + (high - low) * air_rng_float(rng);
}

static air_vec3 random_point(air_rng *rng, float size)
{
    return vec3(between(rng, -size, size), between(rng, -size, size), between(rng, -size, size));
}

/* An affine map that is far from singular. */
static void random_map(air_rng *rng, float out[12])
{
    do {
        for (int i = 0; i < 12; i++) {
            out[i] = between(rng, -1.0f, 1.0f);
        }
    } while (fabs(affine_determinant(out)) < 0.1);
}

/* ---- the backend ---- */

/* At an instruction set; without a context where the machine lacks it. */
static ray_tracer build(air_cpu cpu, const air_ray_mesh *meshes, size_t count)
{
    air_context_params params;
    air_context_params_default(&params);
    params.cpu = cpu;
    if (cpu > air_cpu_detect()) {
        return (ray_tracer){0};
    }
    return ray_tracer_build(&params, meshes, count);
}

static bool is_hit(const air_hit *hit) { return hit->mesh != (uint32_t)AIR_NO_HIT; }

/* ---- closed forms ---- */

/* x of m x = b by Cramer's rule. */
static void solve(const float m[12], const long double b[3], long double out[3])
{
    long double a[3][3];
    for (int i = 0; i < 9; i++) {
        a[i / 3][i % 3] = m[4 * (i / 3) + i % 3];
    }
    const long double whole = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
                              a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
                              a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    for (int k = 0; k < 3; k++) {
        long double c[3][3];
        memcpy(c, a, sizeof c);
        for (int i = 0; i < 3; i++) {
            c[i][k] = b[i];
        }
        out[k] = (c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) -
                  c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0]) +
                  c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0])) /
                 whole;
    }
}

/* The t > 0 at which a ray meets a quadric, by the quadratic formula in long double; *out_doubt:
 * too near an edge or a silhouette to tell. */
static size_t closed_form(air_ray_shape shape, const float m[12], const air_ray *ray,
                          long double out[2], bool *out_doubt)
{
    long double from[3], along[3], o[3], d[3], roots[2];
    for (int i = 0; i < 3; i++) {
        from[i] = (long double)ray->origin[i] - (long double)m[4 * i + 3];
        along[i] = ray->dir[i];
    }
    solve(m, from, o);
    solve(m, along, d);
    const int axes = shape == AIR_RAY_SPHERE ? 3 : 2;
    long double a = 0.0L, b = 0.0L, c = -1.0L;
    for (int i = 0; i < axes; i++) {
        a += d[i] * d[i];
        b += o[i] * d[i];
        c += o[i] * o[i];
    }
    *out_doubt = false;
    size_t count = 2, kept = 0;
    if (shape == AIR_RAY_DISK) {
        count = 1;
        roots[0] = -o[2] / d[2];
    } else {
        const long double discriminant = b * b - a * c;
        *out_doubt = fabsl(discriminant) < 1e-9L * (b * b + fabsl(a * c));
        if (discriminant < 0.0L) {
            return 0;
        }
        roots[0] = (-b - sqrtl(discriminant)) / a;
        roots[1] = (-b + sqrtl(discriminant)) / a;
    }
    for (size_t k = 0; k < count; k++) {
        const long double x = o[0] + roots[k] * d[0], y = o[1] + roots[k] * d[1];
        const long double z = o[2] + roots[k] * d[2];
        const long double inside = shape == AIR_RAY_DISK       ? 1.0L - x * x - y * y
                                   : shape == AIR_RAY_CYLINDER ? z * (1.0L - z)
                                                               : 1.0L;
        *out_doubt = *out_doubt || fabsl(inside) < 1e-9L || fabsl(roots[k]) < 1e-9L;
        if (inside > 0.0L && roots[k] > 0.0L) {
            out[kept++] = roots[k];
        }
    }
    return kept;
}

static void hits_of_random_maps_agree_with_the_quadratic_formula(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 1);
    int met = 0;
    for (int i = 0; i < RAYS; i++) {
        const air_ray_shape shape = (air_ray_shape)(AIR_RAY_SPHERE + i % SHAPES);
        float map[12];
        random_map(&rng, map);
        const air_ray_mesh mesh = {.mask = 1, .shape = shape, .to_world = map};
        ray_tracer self = build(AIR_CPU_AUTO, &mesh, 1);
        for (int k = 0; k < 16; k++) {
            const air_vec3 centre = vec3(map[3], map[7], map[11]), from = random_point(&rng, 3.0f);
            const air_vec3 to = vec3_add(centre, random_point(&rng, 0.7f));
            const air_ray ray = ray_tracer_ray(from, vec3_sub(to, from));
            long double expected[2];
            bool doubt;
            const size_t count = closed_form(shape, map, &ray, expected, &doubt);
            air_hit hit, all[4];
            uint8_t occluded;
            self.backend.intersect(self.accelerator, &ray, 1, &hit);
            self.backend.occluded(self.accelerator, &ray, 1, &occluded);
            if (doubt) {
                continue;
            }
            assert_int_equal(is_hit(&hit), count > 0);
            assert_int_equal(occluded, count > 0);
            assert_int_equal(self.backend.intersect_all(self.accelerator, &ray, all, 4), count);
            for (size_t h = 0; h < count; h++) {
                /* a float's rounding, and a double's where 1 - r^2 cancels down to 1e-9 */
                assert_true(fabs((double)(expected[h] - (long double)all[h].t)) <
                            0x1p-23 * (double)expected[h] + 1e-9);
                assert_int_equal(all[h].triangle, 0);
                met++;
            }
            if (count > 0) {
                assert_memory_equal(&hit, &all[0], sizeof hit);
            }
        }
        ray_tracer_finish(&self);
    }
    assert_true(met > RAYS);
}

static void texture_coordinates_and_normal_describe_the_place(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 1);
    for (int i = 0; i < RAYS; i++) {
        const air_ray_shape shape = (air_ray_shape)(AIR_RAY_SPHERE + i % SHAPES);
        float map[12], uv[2];
        air_quadric quadric;
        double local[3], back[3];
        random_map(&rng, map);
        assert_true(air_quadric_make(shape, map, &quadric));
        air_quadric_sample(shape, air_rng_float(&rng), air_rng_float(&rng), local);
        air_quadric_uv(shape, local, uv);
        air_quadric_place(shape, uv[0], uv[1], back);
        for (int k = 0; k < 3; k++) {
            /* an angle in turns has 2^-24 of 1, which 2 pi makes a way of 4e-7 */
            assert_true(fabs(local[k] - back[k]) < 6e-7);
        }
        /* the normal stands on the ways between places to both sides: chords of circles and
         * straight lines, which are parallel to the surface here */
        const air_vec3 n = air_quadric_normal(&quadric, local);
        for (int k = 0; k < 2; k++) {
            air_vec3 side[2];
            for (int s = 0; s < 2; s++) {
                const float step = s == 0 ? 1e-2f : -1e-2f;
                air_quadric_place(shape, uv[0] + (k == 0 ? step : 0.0f),
                                  uv[1] + (k == 1 ? step : 0.0f), back);
                side[s] = air_quadric_to_world(&quadric, back);
            }
            /* positions of up to 3 round to floats, coordinates turn the way by 4e-7 */
            assert_true(fabsf(vec3_dot(n, vec3_sub(side[0], side[1]))) < 2e-6f);
        }
        assert_true(fabsf(vec3_length(n) - 1.0f) < 1e-6f);
    }
}

static void normals_point_out_whatever_the_map_mirrors(void **state)
{
    (void)state;
    const float mirror[12] = {-2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 3};
    const double top[3] = {0.6, 0.0, 0.8}, side[3] = {0.6, 0.8, 0.3}, disk[3] = {0.2, 0.1, 0.0};
    air_quadric quadric;
    assert_true(air_quadric_make(AIR_RAY_SPHERE, mirror, &quadric));
    air_vec3 n = air_quadric_normal(&quadric, top);
    assert_true(fabsf(n.x + 0.6f) < 1e-6f && fabsf(n.z - 0.8f) < 1e-6f);
    assert_true(air_quadric_make(AIR_RAY_CYLINDER, mirror, &quadric));
    n = air_quadric_normal(&quadric, side);
    assert_true(fabsf(n.x + 0.6f) < 1e-6f && fabsf(n.y - 0.8f) < 1e-6f);
    assert_true(air_quadric_make(AIR_RAY_DISK, mirror, &quadric));
    n = air_quadric_normal(&quadric, disk);
    assert_true(fabsf(n.z - 1.0f) < 1e-6f);
}

/* ---- far, small, in packets ---- */

static void a_tiny_sphere_far_away_is_met_where_it_is(void **state)
{
    (void)state;
    const float radius = 1e-3f;
    const float map[12] = {radius, 0, 0, 0.7f, 0, radius, 0, -0.2f, 0, 0, radius, 0.1f};
    const air_ray_mesh mesh = {.mask = 1, .shape = AIR_RAY_SPHERE, .to_world = map};
    const air_vec3 centre = vec3(map[3], map[7], map[11]);
    for (int cpu = AIR_CPU_C; cpu <= AIR_CPU_AVX512; cpu++) {
        ray_tracer self = build((air_cpu)cpu, &mesh, 1);
        if (self.context == NULL) {
            continue;
        }
        air_rng rng = air_rng_from_keys(3, 1);
        int met = 0;
        for (int i = 0; i < RAYS; i++) {
            const air_vec3 origin =
                vec3_scale(vec3_normalize(random_point(&rng, 1.0f)), between(&rng, 500.0f, 1e3f));
            /* every other bundle to where the sphere touches its box */
            const float edge = (i & 1) != 0 ? radius : -radius;
            const air_vec3 touch = i % 6 < 2   ? vec3(edge, 0.0f, 0.0f)
                                   : i % 6 < 4 ? vec3(0.0f, edge, 0.0f)
                                               : vec3(0.0f, 0.0f, edge);
            const air_vec3 off = i % 12 < 6 ? touch : random_point(&rng, 1.2f * radius);
            const air_vec3 dir = vec3_sub(vec3_add(centre, off), origin);
            air_ray rays[PACKET];
            air_hit hits[PACKET], single;
            uint8_t occluded[PACKET];
            for (int k = 0; k < PACKET; k++) {
                const air_vec3 spread = random_point(&rng, k % 2 == 0 ? 0.0f : 0.2f * radius);
                rays[k] = ray_tracer_ray(origin, vec3_add(dir, spread));
            }
            self.backend.intersect(self.accelerator, rays, PACKET, hits);
            self.backend.occluded(self.accelerator, rays, PACKET, occluded);
            for (int k = 0; k < PACKET; k++) {
                self.backend.intersect(self.accelerator, &rays[k], 1, &single);
                assert_int_equal(is_hit(&single), is_hit(&hits[k]));
                assert_int_equal(occluded[k], is_hit(&hits[k]));
                if (is_hit(&single)) {
                    assert_memory_equal(&single, &hits[k], sizeof single);
                    met++;
                }
                /* how far the ray passes the centre, by the cross product */
                double oo[3], dd[3], x = 0.0;
                for (int a = 0; a < 3; a++) {
                    oo[a] = (double)rays[k].origin[a] - (double)map[4 * a + 3];
                    dd[a] = (double)rays[k].dir[a];
                }
                for (int a = 0; a < 3; a++) {
                    const int b = (a + 1) % 3, c = (a + 2) % 3;
                    const double cross = oo[b] * dd[c] - oo[c] * dd[b];
                    x += cross * cross;
                }
                const double length = sqrt(dd[0] * dd[0] + dd[1] * dd[1] + dd[2] * dd[2]);
                const double miss = sqrt(x) / length - (double)radius;
                /* products of up to 1e6 round to doubles */
                if (fabs(miss) > 1e-9) {
                    assert_int_equal(is_hit(&single), miss < 0.0);
                }
            }
        }
        assert_true(met > RAYS);
        ray_tracer_finish(&self);
    }
}

static void a_ray_that_leaves_a_sphere_does_not_meet_it_again(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(4, 1);
    for (int i = 0; i < RAYS; i++) {
        const float radius = powf(10.0f, between(&rng, -3.0f, 3.0f));
        const air_vec3 c = random_point(&rng, 10.0f);
        const float map[12] = {radius, 0, 0, c.x, 0, radius, 0, c.y, 0, 0, radius, c.z};
        air_quadric quadric;
        air_quadric_hit met[2];
        double local[3];
        assert_true(air_quadric_make(AIR_RAY_SPHERE, map, &quadric));
        air_quadric_sample(AIR_RAY_SPHERE, air_rng_float(&rng), air_rng_float(&rng), local);
        const air_vec3 n = air_quadric_normal(&quadric, local);
        const air_vec3 p = air_quadric_to_world(&quadric, local);
        const float offset = 2.0f * FLT_EPSILON * (fabsf(p.x) + fabsf(p.y) + fabsf(p.z));
        const air_vec3 across = random_point(&rng, 1.0f);
        /* nearly along the surface, but away from it */
        air_vec3 dir = vec3_madd(across, -vec3_dot(across, n), n);
        dir = vec3_madd(dir, 1e-6f, n);
        float origin[3], along[3];
        vec3_store(origin, vec3_madd(p, offset, n));
        vec3_store(along, dir);
        const size_t count = air_quadric_intersect(&quadric, origin, along, met);
        for (size_t k = 0; k < count; k++) {
            assert_true(met[k].t < 0.0);
        }
        vec3_store(origin, vec3_madd(p, -offset, n));
        vec3_store(along, vec3_neg(dir));
        /* inside there is one way out */
        assert_int_equal(air_quadric_intersect(&quadric, origin, along, met), 2);
        assert_true(met[0].t < 0.0 && met[1].t > 0.0);
    }
}

/* ---- among others ---- */

static void masks_intervals_and_triangles_hold_for_quadrics_too(void **state)
{
    (void)state;
    static const float positions[10] = {-5, -5, -3, 5, -5, -3, 0, 5, -3, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    const float far[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -6};
    const air_ray_mesh meshes[3] = {{.mask = 2, .shape = AIR_RAY_SPHERE, .to_world = identity},
                                    {.positions = positions,
                                     .vertex_count = 3,
                                     .indices = indices,
                                     .triangle_count = 1,
                                     .mask = 1},
                                    {.mask = 1, .shape = AIR_RAY_DISK, .to_world = far}};
    ray_tracer self = build(AIR_CPU_AUTO, meshes, 3);
    air_ray ray = ray_tracer_ray(vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -2.0f));
    air_hit all[8];
    /* z = 1, -1, -3, -6 at twice the speed */
    assert_int_equal(self.backend.intersect_all(self.accelerator, &ray, all, 8), 4);
    const float expected[4] = {1.5f, 2.5f, 3.5f, 5.0f};
    const uint32_t of[4] = {0, 0, 1, 2};
    for (int i = 0; i < 4; i++) {
        assert_true(all[i].t == expected[i]);
        assert_int_equal(all[i].mesh, of[i]);
    }
    assert_int_equal(self.backend.intersect_all(self.accelerator, &ray, all, 1), 1);
    assert_int_equal(all[0].mesh, 0);
    ray.mask = 1;
    assert_int_equal(self.backend.intersect_all(self.accelerator, &ray, all, 8), 2);
    self.backend.intersect(self.accelerator, &ray, 1, all);
    assert_int_equal(all[0].mesh, 1);
    ray.mask = 3;
    ray.tmin = 1.5f;
    self.backend.intersect(self.accelerator, &ray, 1, all);
    assert_true(all[0].t == 2.5f);
    ray.tmax = 2.5f;
    uint8_t occluded = 2;
    self.backend.occluded(self.accelerator, &ray, 1, &occluded);
    assert_int_equal(occluded, 0);
    ray_tracer_finish(&self);
}

/* ---- area and bounds ---- */

static void areas_are_those_of_spheres_spheroids_and_cylinders(void **state)
{
    (void)state;
    const float ball[12] = {0, 0, 3, 1, 3, 0, 0, 1, 0, 3, 0, 1};
    const float egg[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0};
    air_quadric quadric;
    assert_true(air_quadric_make(AIR_RAY_SPHERE, ball, &quadric));
    assert_true(fabs(air_quadric_area(&quadric) / (36.0 * AIR_PI) - 1.0) < 1e-6);
    /* a prolate spheroid: 2 pi a^2 (1 + c / (a e) asin e), e^2 = 1 - a^2 / c^2; by the midpoint
     * rule in z, whose error is of the order of the square of a 256th */
    assert_true(air_quadric_make(AIR_RAY_SPHERE, egg, &quadric));
    const double e = sqrt(0.75), exact = 2.0 * AIR_PI * (1.0 + 2.0 / e * asin(e));
    assert_true(fabs(air_quadric_area(&quadric) / exact - 1.0) < 2e-5);
    assert_true(air_quadric_make(AIR_RAY_CYLINDER, egg, &quadric));
    assert_true(fabs(air_quadric_area(&quadric) / (4.0 * AIR_PI) - 1.0) < 1e-6);
    assert_true(air_quadric_make(AIR_RAY_DISK, ball, &quadric));
    assert_true(fabs(air_quadric_area(&quadric) / (9.0 * AIR_PI) - 1.0) < 1e-6);
}

static void bounds_are_tight(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 1);
    for (int i = 0; i < 30; i++) {
        const air_ray_shape shape = (air_ray_shape)(AIR_RAY_SPHERE + i % SHAPES);
        float map[12], low[3], high[3], least[3], most[3];
        air_quadric quadric;
        random_map(&rng, map);
        assert_true(air_quadric_make(shape, map, &quadric));
        air_quadric_bounds(&quadric, low, high);
        for (int k = 0; k < 3; k++) {
            least[k] = INFINITY;
            most[k] = -INFINITY;
        }
        for (int s = 0; s < 256 * 256; s++) {
            double local[3];
            float p[3];
            air_quadric_place(shape, shape == AIR_RAY_DISK ? 1.0f : (float)(s % 256) / 255.0f,
                              (float)(s / 256) / 255.0f, local);
            vec3_store(p, air_quadric_to_world(&quadric, local));
            for (int k = 0; k < 3; k++) {
                least[k] = fminf(least[k], p[k]);
                most[k] = fmaxf(most[k], p[k]);
            }
        }
        for (int k = 0; k < 3; k++) {
            /* steps of an angle of 2 pi / 255 miss the extreme by half their square at most, of a
             * reach of up to 1.8 */
            assert_true(low[k] <= least[k] && low[k] > least[k] - 1e-3f);
            assert_true(high[k] >= most[k] && high[k] < most[k] + 1e-3f);
        }
    }
}

static void singular_maps_are_none(void **state)
{
    (void)state;
    float map[12] = {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0};
    air_quadric quadric;
    assert_false(air_quadric_make(AIR_RAY_SPHERE, map, &quadric));
    map[10] = NAN;
    assert_false(air_quadric_make(AIR_RAY_SPHERE, map, &quadric));
    assert_false(air_quadric_make(AIR_RAY_TRIANGLES, identity, &quadric));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_of_random_maps_agree_with_the_quadratic_formula),
        cmocka_unit_test(texture_coordinates_and_normal_describe_the_place),
        cmocka_unit_test(normals_point_out_whatever_the_map_mirrors),
        cmocka_unit_test(a_tiny_sphere_far_away_is_met_where_it_is),
        cmocka_unit_test(a_ray_that_leaves_a_sphere_does_not_meet_it_again),
        cmocka_unit_test(masks_intervals_and_triangles_hold_for_quadrics_too),
        cmocka_unit_test(areas_are_those_of_spheres_spheroids_and_cylinders),
        cmocka_unit_test(bounds_are_tight),
        cmocka_unit_test(singular_maps_are_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

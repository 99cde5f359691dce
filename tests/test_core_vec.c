/* Vectors, frames and affine maps. */
#include "core/vec.h"

#include <float.h>

#include "cmocka_test.h"
#include "core/random.h"
#include "core/warp.h"

enum { TRIALS = 10000 };

static float signed_random(air_rng *rng) { return 2.0f * air_rng_float(rng) - 1.0f; }

static void random_map(air_rng *rng, float m[12])
{
    for (int i = 0; i < 12; ++i) {
        m[i] = signed_random(rng);
    }
}

/* Largest absolute row sum of the 3x3 part. */
static double norm(const float m[12])
{
    double largest = 0.0;
    for (int row = 0; row < 3; ++row) {
        const float *r = m + 4 * row;
        largest = fmax(largest, fabs((double)r[0]) + fabs((double)r[1]) + fabs((double)r[2]));
    }
    return largest;
}

static void inverse_undoes_the_map(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 6);
    for (int i = 0; i < TRIALS; ++i) {
        float m[12], inverse[12], product[12];
        random_map(&rng, m);
        assert_true(affine_invert(m, inverse));
        affine_multiply(inverse, m, product);
        /* Rounding the inverse to float changes each entry by at most 2^-24 of it; the product sums
         * four such. */
        const double tolerance = 0x1p-24 * (norm(inverse) * norm(m) * 4.0 + 4.0) +
                                 0x1p-24 * 4.0 *
                                     (fabs((double)inverse[3]) + norm(inverse) +
                                      fabs((double)inverse[7]) + fabs((double)inverse[11]));
        for (int k = 0; k < 12; ++k) {
            const double expected = k % 5 == 0 ? 1.0 : 0.0;
            assert_true(fabs((double)product[k] - expected) <= tolerance);
        }
    }
}

static void the_determinant_of_a_product_is_the_product(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(7, 8);
    for (int i = 0; i < TRIALS; ++i) {
        float a[12], b[12], product[12];
        random_map(&rng, a);
        random_map(&rng, b);
        affine_multiply(a, b, product);
        /* Entries below 3 are rounded by 2^-23; a determinant has 9 first derivatives below 18. */
        assert_true(fabs(affine_determinant(product) -
                         affine_determinant(a) * affine_determinant(b)) < 9.0 * 18.0 * 0x1p-23);
    }
}

static void a_product_applies_the_right_map_first_and_may_overwrite_its_factors(void **state)
{
    (void)state;
    const float a[12] = {0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 2, 7};
    const float b[12] = {2, 0, 0, 1, 0, 3, 0, 2, 0, 0, 4, 3};
    float product[12], left[12], right[12];
    affine_multiply(a, b, product);
    for (int i = 0; i < 12; ++i) {
        left[i] = a[i];
        right[i] = b[i];
    }
    const air_vec3 p = vec3(1.0f, -2.0f, 3.0f);
    const air_vec3 expected = affine_point(a, affine_point(b, p));
    const air_vec3 got = affine_point(product, p);
    assert_true(got.x == expected.x && got.y == expected.y && got.z == expected.z);
    affine_multiply(left, b, left);
    affine_multiply(a, right, right);
    assert_memory_equal(left, product, sizeof product);
    assert_memory_equal(right, product, sizeof product);
}

static void tiny_and_huge_scales_invert(void **state)
{
    (void)state;
    for (float scale = 1e-10f; scale < 2e10f; scale *= 1e5f) {
        const float m[12] = {scale, 0, 0, scale, 0, scale, 0, 0, 0, 0, -scale, 0};
        float inverse[12];
        assert_true(affine_invert(m, inverse));
        assert_true(fabsf(inverse[0] * scale - 1.0f) < 2.0f * FLT_EPSILON);
        assert_true(fabsf(inverse[10] * scale + 1.0f) < 2.0f * FLT_EPSILON);
        assert_true(fabsf(inverse[3] + 1.0f) < 2.0f * FLT_EPSILON);
    }
}

static void singular_and_infinite_maps_are_refused_and_leave_the_output(void **state)
{
    (void)state;
    float out[12] = {42.0f};
    const float flat[12] = {1, 2, 3, 0, 2, 4, 6, 0, 0, 0, 1, 0};
    const float infinite[12] = {INFINITY, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float lost[12] = {1, 0, 0, NAN, 0, 1, 0, 0, 0, 0, 1, 0};
    const float tiny[12] = {1e-40f, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}; /* 1e40 is no float */
    assert_false(affine_invert(flat, out));
    assert_false(affine_invert(infinite, out));
    assert_false(affine_invert(lost, out));
    assert_false(affine_invert(tiny, out));
    assert_true(out[0] == 42.0f);
}

static void frames_are_orthonormal_and_right_handed(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(9, 10);
    for (int i = 0; i < TRIALS; ++i) {
        air_vec3 n = sample_sphere(air_rng_float(&rng), air_rng_float(&rng));
        if (i < 2) {
            n = vec3(0.0f, 0.0f, i == 0 ? 1.0f : -1.0f);
        }
        const air_frame f = frame_from_normal(n);
        /* [Duff2017] states errors of a few 2^-23. */
        const float tolerance = 8.0f * FLT_EPSILON;
        assert_true(fabsf(vec3_dot(f.s, f.t)) < tolerance);
        assert_true(fabsf(vec3_dot(f.s, f.n)) < tolerance);
        assert_true(fabsf(vec3_dot(f.t, f.n)) < tolerance);
        assert_true(fabsf(vec3_length(f.s) - 1.0f) < tolerance);
        assert_true(fabsf(vec3_length(f.t) - 1.0f) < tolerance);
        assert_true(vec3_dot(vec3_cross(f.s, f.t), f.n) > 0.99f);
        const air_vec3 v = vec3(0.3f, -0.5f, 0.8f);
        const air_vec3 back = frame_to_local(&f, frame_to_world(&f, v));
        assert_true(vec3_length(vec3_sub(back, v)) < 2.0f * tolerance);
    }
}

static void mapped_normals_stay_perpendicular(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 12);
    for (int i = 0; i < TRIALS; ++i) {
        float m[12], inverse[12];
        random_map(&rng, m);
        assert_true(affine_invert(m, inverse));
        const air_vec3 n = sample_sphere(air_rng_float(&rng), air_rng_float(&rng));
        const air_frame f = frame_from_normal(n);
        const air_vec3 tangent = affine_vector(m, f.s);
        const air_vec3 normal = affine_normal(inverse, n);
        /* |n' . t'| is exactly 0; terms are below norm(inverse) norm(m) and carry about eight
         * roundings. */
        assert_true(fabs((double)vec3_dot(tangent, normal)) <
                    8.0 * 3.0 * 0x1p-23 * norm(m) * (norm(inverse) + 1.0) * 3.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverse_undoes_the_map),
        cmocka_unit_test(the_determinant_of_a_product_is_the_product),
        cmocka_unit_test(a_product_applies_the_right_map_first_and_may_overwrite_its_factors),
        cmocka_unit_test(tiny_and_huge_scales_invert),
        cmocka_unit_test(singular_and_infinite_maps_are_refused_and_leave_the_output),
        cmocka_unit_test(frames_are_orthonormal_and_right_handed),
        cmocka_unit_test(mapped_normals_stay_perpendicular),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include <stdio.h>

#include "chi_square.h"
#include "cmocka_test.h"
#include "core/quadrature.h"
#include "core/random.h"
#include "core/warp.h"
#include "scene/bsdf.h"
#include "scene/ggx_albedo_table.h"

static air_bsdf_input plain_input(float mu)
{
    return (air_bsdf_input){
        .base_color = {1.0f, 1.0f, 1.0f},
        .roughness = 0.5f,
        .specular = 1.0f,
        .ior = 1.5f,
        .shading_normal = {0.0f, 0.0f, 1.0f},
        .geometric_normal = {0.0f, 0.0f, 1.0f},
        .wo = {sqrtf(fmaxf(0.0f, 1.0f - mu * mu)), 0.0f, mu},
    };
}

static float uniform(air_rng *rng, float low, float high)
{
    return low + (high - low) * air_rng_float(rng);
}

static air_vec3 random_direction(air_rng *rng)
{
    const float u1 = air_rng_float(rng);
    return sample_sphere(u1, air_rng_float(rng));
}

static air_bsdf_input random_input(air_rng *rng)
{
    air_bsdf_input input = plain_input(0.5f);
    input.base_color = vec3(air_rng_float(rng), air_rng_float(rng), air_rng_float(rng));
    input.metallic = fminf(1.0f, fmaxf(0.0f, uniform(rng, -0.5f, 1.5f)));
    input.roughness = uniform(rng, 0.15f, 1.0f);
    input.specular = fmaxf(0.0f, uniform(rng, -0.2f, 1.0f));
    input.ior = uniform(rng, 1.0f, 2.5f);
    input.geometric_normal = random_direction(rng);
    input.shading_normal =
        vec3_normalize(vec3_madd(input.geometric_normal, 0.3f, random_direction(rng)));
    input.wo = random_direction(rng);
    return input;
}

static void reflection_is_reciprocal(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 1);
    size_t compared = 0;
    for (int i = 0; i < 20000; i++) {
        const air_bsdf_input input = random_input(&rng);
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        const air_vec3 wi = random_direction(&rng);
        const air_vec3 there = air_bsdf_eval(&bsdf, input.wo, wi);
        const air_vec3 back = air_bsdf_eval(&bsdf, wi, input.wo);
        const float cos_i = vec3_dot(wi, bsdf.frame.n), cos_o = vec3_dot(input.wo, bsdf.frame.n);
        if (vec3_is_zero(there)) {
            assert_true(vec3_is_zero(back));
            continue;
        }
        compared++;
        /* A dozen products, each rounded to 6e-8; the lobe's slope multiplies the rounding of h by
         * at most 4 / alpha^2, and alpha >= 0.0225: only where the value itself is small, so 1e-4
         * of it is ample. */
        assert_true(fabsf(there.x / cos_i - back.x / cos_o) <= 1e-4f * there.x / cos_i);
        assert_true(fabsf(there.z / cos_i - back.z / cos_o) <= 1e-4f * there.z / cos_i);
    }
    assert_true(compared > 3000);
}

/* ---- white furnace ---- */

enum { RINGS = 96 };

/* The integral of f cos over wi: polar coordinates around the mirror direction with the logarithm
 * of the angle, which resolves lobes of any width, cut at the horizon. Seen at grazing angles a
 * lobe is 1/mu times as long as it is wide. */
static air_vec3 albedo(const air_bsdf *bsdf, air_vec3 wo)
{
    double nodes[RINGS], weights[RINGS];
    air_gauss_legendre(RINGS, nodes, weights);
    const int azimuths = (int)(128.0f / fmaxf(wo.z, 0.01f)) + 64;
    const air_vec3 mirror = vec3(-wo.x, -wo.y, wo.z);
    const air_frame frame = frame_from_normal(mirror);
    double sum[3] = {0.0, 0.0, 0.0};
    for (int a = 0; a < azimuths; a++) {
        const double phi = 2.0 * AIR_PI * (a + 0.5) / azimuths;
        const air_vec3 side =
            vec3_add(vec3_scale(frame.s, (float)cos(phi)), vec3_scale(frame.t, (float)sin(phi)));
        /* z = mirror.z cos + side.z sin is 0 here */
        const double edge = atan2((double)mirror.z, -(double)side.z);
        const double low = log(1e-7), high = log(edge);
        for (int r = 0; r < RINGS; r++) {
            const double angle = exp(low + (high - low) * 0.5 * (1.0 + nodes[r]));
            const double weight =
                weights[r] * 0.5 * (high - low) * angle * sin(angle) * 2.0 * AIR_PI / azimuths;
            const air_vec3 wi = vec3_normalize(
                vec3_madd(vec3_scale(mirror, (float)cos(angle)), (float)sin(angle), side));
            const air_vec3 f = air_bsdf_eval(bsdf, wo, wi);
            sum[0] += weight * (double)f.x;
            sum[1] += weight * (double)f.y;
            sum[2] += weight * (double)f.z;
        }
    }
    return vec3((float)sum[0], (float)sum[1], (float)sum[2]);
}

static const float ROUGHNESS[] = {0.0f, 0.05f, 0.1f, 0.2f, 0.35f, 0.5f, 0.7f, 0.85f, 1.0f};
static const float COSINES[] = {0.01f, 0.03f, 0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 0.95f, 1.0f};
enum { ROUGHNESS_COUNT = 9, COSINE_COUNT = 9 };

static void white_metal_keeps_what_it_gets(void **state)
{
    (void)state;
    float least = 1.0f, most = 0.0f;
    for (int r = 0; r < ROUGHNESS_COUNT; r++) {
        for (int c = 0; c < COSINE_COUNT; c++) {
            air_bsdf_input input = plain_input(COSINES[c]);
            input.metallic = 1.0f;
            input.roughness = ROUGHNESS[r];
            air_bsdf bsdf;
            air_bsdf_make(&input, &bsdf);
            const float white = albedo(&bsdf, input.wo).x;
            least = fminf(least, white);
            most = fmaxf(most, white);
        }
    }
    printf("white metal: albedo between %.5f and %.5f\n", (double)least, (double)most);
    assert_true(least >= 0.995f);
    assert_true(most <= 1.0f + 5e-5f);
}

static void further_reflections_are_tinted(void **state)
{
    (void)state;
    /* A metal that reflects half at normal incidence: each further reflection between facets is
     * multiplied by the mean Fresnel term (20 f0 + 1) / 21, and a share of the rest leaves each
     * time. */
    air_bsdf_input input = plain_input(0.6f);
    input.metallic = 1.0f;
    input.roughness = 0.9f;
    input.base_color = vec3_set1(0.5f);
    air_bsdf bsdf;
    air_bsdf_make(&input, &bsdf);
    const air_ggx_albedo once = air_ggx_albedo_at(0.6f, bsdf.alpha, bsdf.alpha_axis);
    const double stays = (double)air_ggx_albedo_mean(bsdf.alpha_axis).loss;
    const double tint = (20.0 * 0.5 + 1.0) / 21.0;
    double expected = 0.5 * (1.0 - (double)once.loss) + 0.5 * (double)once.fresnel;
    double still_in = (double)once.loss * tint;
    for (int i = 0; i < 100; i++) {
        still_in *= tint;
        expected += still_in * (1.0 - stays);
        still_in *= stays;
    }
    /* the tables' error, 0.0017 and 0.0026, each times 1/2 */
    assert_true(fabs((double)albedo(&bsdf, input.wo).x - expected) < 0.0022);
    assert_true(expected < 0.5);
}

/* Shading normals that differ from the geometric ones only cut light off. */
static void no_surface_reflects_more_than_it_receives(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 1);
    float most = 0.0f;
    for (int i = 0; i < 300; i++) {
        air_bsdf_input input = plain_input(uniform(&rng, 0.02f, 1.0f));
        /* beyond the ranges too: they are clamped */
        input.base_color = vec3(uniform(&rng, 0.5f, 1.5f), air_rng_float(&rng), 1.0f);
        input.metallic = uniform(&rng, -0.5f, 1.2f);
        input.roughness = uniform(&rng, 0.0f, 1.2f);
        input.specular = uniform(&rng, -0.2f, 1.5f);
        input.ior = i % 4 == 0 ? uniform(&rng, 1.0f, 1.2f) : uniform(&rng, 1.0f, 20.0f);
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        most = fmaxf(most, vec3_max(albedo(&bsdf, input.wo)));
    }
    printf("any surface: albedo at most %.5f\n", (double)most);
    /* 5e-5: quadrature, seen as the change when RINGS is doubled */
    assert_true(most <= 1.0f + 5e-5f);
}

static void white_dielectric_keeps_what_it_gets(void **state)
{
    (void)state;
    for (int r = 0; r < ROUGHNESS_COUNT; r++) {
        for (int c = 0; c < COSINE_COUNT; c++) {
            air_bsdf_input input = plain_input(COSINES[c]);
            input.roughness = ROUGHNESS[r];
            air_bsdf bsdf;
            air_bsdf_make(&input, &bsdf);
            const float white = albedo(&bsdf, input.wo).y;
            /* the tables' error, 0.0025 for the Fresnel term and 0.0017 for the loss */
            assert_true(white >= 0.995f && white <= 1.0f + 5e-5f);
        }
    }
}

static void without_specular_it_is_lambert(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(7, 1);
    for (int i = 0; i < 1000; i++) {
        air_bsdf_input input = random_input(&rng);
        input.specular = 0.0f;
        input.metallic = 0.0f;
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        const air_vec3 wi = random_direction(&rng);
        const air_vec3 f = air_bsdf_eval(&bsdf, input.wo, wi);
        const float cos_i = vec3_dot(wi, bsdf.frame.n);
        const bool lit = cos_i > 0.0f && vec3_dot(wi, bsdf.normal) > 0.0f;
        const float expected = lit ? input.base_color.x * cos_i / AIR_PI_F : 0.0f;
        assert_true(fabsf(f.x - expected) <= 1e-6f); /* two roundings of numbers below 1/pi */
    }
}

/* The part without a highlight is part of the whole: all of it where there is no highlight, nearly
 * all far from a sharp one, next to nothing in it. */
static void smooth_part_leaves_the_highlight(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 11);
    for (int i = 0; i < 20000; i++) {
        air_bsdf_input input = random_input(&rng);
        air_bsdf bsdf;
        input.specular = i % 4 == 0 ? 0.0f : input.specular;
        input.metallic = i % 4 == 0 ? 0.0f : input.metallic;
        air_bsdf_make(&input, &bsdf);
        const air_vec3 wi = random_direction(&rng);
        const air_vec3 whole = air_bsdf_eval(&bsdf, input.wo, wi);
        const air_vec3 smooth = air_bsdf_eval_smooth(&bsdf, input.wo, wi);
        air_vec3 part;
        const air_vec3 both = air_bsdf_eval_parts(&bsdf, input.wo, wi, &part);
        assert_memory_equal(&both, &whole, sizeof whole);
        assert_memory_equal(&part, &smooth, sizeof smooth);
        assert_true(smooth.x >= 0.0f && smooth.y >= 0.0f && smooth.z >= 0.0f);
        /* sums of three terms, rounded */
        assert_true(smooth.x <= whole.x * (1.0f + 1e-6f) && smooth.y <= whole.y * (1.0f + 1e-6f) &&
                    smooth.z <= whole.z * (1.0f + 1e-6f));
        assert_true(bsdf.f90 > 0.0f || vec3_mean(smooth) == vec3_mean(whole));
    }
    air_bsdf_input input = plain_input(0.8f);
    air_bsdf bsdf;
    input.roughness = 0.15f;
    air_bsdf_make(&input, &bsdf);
    const air_vec3 mirror = vec3(-input.wo.x, 0.0f, input.wo.z), aside = vec3(0.6f, 0.6f, 0.529f);
    const float in_it = vec3_mean(air_bsdf_eval_smooth(&bsdf, input.wo, mirror)) /
                        vec3_mean(air_bsdf_eval(&bsdf, input.wo, mirror));
    const float off_it = vec3_mean(air_bsdf_eval_smooth(&bsdf, input.wo, aside)) /
                         vec3_mean(air_bsdf_eval(&bsdf, input.wo, aside));
    assert_true(in_it < 0.1f && off_it > 0.99f);
}

/* Of all roughnesses, from metals to plastics, towards all sides, against quadrature. */
static void albedo_is_the_integral_of_the_reflection(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 12);
    float worst = 0.0f;
    for (int i = 0; i < 400; i++) {
        air_bsdf_input input = plain_input(uniform(&rng, 0.01f, 1.0f));
        air_bsdf bsdf;
        input.base_color = vec3(air_rng_float(&rng), air_rng_float(&rng), 1.0f);
        input.metallic = fminf(1.0f, fmaxf(0.0f, uniform(&rng, -1.0f, 2.0f)));
        input.roughness = uniform(&rng, 0.0f, 1.0f);
        input.ior = uniform(&rng, 1.0f, 2.5f);
        air_bsdf_make(&input, &bsdf);
        const air_vec3 quadrature = albedo(&bsdf, input.wo);
        const air_vec3 closed = air_bsdf_albedo(&bsdf, input.wo);
        worst = fmaxf(worst, fabsf(closed.x - quadrature.x));
        worst = fmaxf(worst, fabsf(closed.y - quadrature.y));
        worst = fmaxf(worst, fabsf(closed.z - quadrature.z));
    }
    printf("albedo: off by at most %.5f\n", (double)worst);
    /* the tables' error, 0.0025 for the Fresnel term and 0.0017 for the loss, and 5e-5 for the
     * quadrature; what one lobe has too much the base under it has too little, so they do not add
     */
    assert_true(worst <= 0.0026f);
    air_bsdf_input input = plain_input(0.3f);
    air_bsdf bsdf;
    input.specular = 0.0f;
    input.base_color = vec3(0.2f, 0.5f, 0.9f);
    air_bsdf_make(&input, &bsdf);
    const air_vec3 lambert = air_bsdf_albedo(&bsdf, input.wo);
    assert_memory_equal(&lambert, &input.base_color, sizeof lambert);
    assert_true(vec3_is_zero(air_bsdf_albedo(&bsdf, vec3_neg(input.wo))));
}

static void light_does_not_leak_through_the_surface(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(9, 1);
    for (int i = 0; i < 20000; i++) {
        const air_bsdf_input input = random_input(&rng);
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        assert_true(vec3_dot(input.wo, bsdf.frame.n) > 0.0f);
        assert_true(vec3_dot(input.wo, bsdf.normal) >= 0.0f);
        const air_vec3 wi = random_direction(&rng);
        const float side = vec3_dot(wi, bsdf.normal) * vec3_dot(wi, bsdf.frame.n);
        if (side < 0.0f || vec3_dot(wi, bsdf.normal) < 0.0f) {
            assert_true(vec3_is_zero(air_bsdf_eval(&bsdf, input.wo, wi)));
            assert_true(air_bsdf_sample_pdf(&bsdf, input.wo, wi) == 0.0f);
        }
        const float u[3] = {air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)};
        air_vec3 sampled, weight;
        float pdf;
        if (air_bsdf_sample(&bsdf, input.wo, u, &sampled, &weight, &pdf)) {
            assert_true(vec3_dot(sampled, bsdf.normal) > 0.0f && pdf > 0.0f);
        }
    }
}

/* ---- sampling ---- */

static void weight_times_density_is_the_value(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(11, 1);
    for (int i = 0; i < 20000; i++) {
        const air_bsdf_input input = random_input(&rng);
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        const float u[3] = {air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)};
        air_vec3 wi, weight;
        float pdf;
        if (!air_bsdf_sample(&bsdf, input.wo, u, &wi, &weight, &pdf) ||
            vec3_dot(wi, bsdf.frame.n) < 1e-4f) {
            continue; /* at the horizon rounding decides whether there is light at all */
        }
        const air_vec3 f = air_bsdf_eval(&bsdf, input.wo, wi);
        const float again = air_bsdf_sample_pdf(&bsdf, input.wo, wi);
        /* wi goes to world space and back, which moves it by 1e-7: D changes by at most 4e-7 /
         * alpha^2 = 8e-4 of its peak and cos by 1e-3 of itself. */
        assert_true(fabsf(again - pdf) <= 2e-3f * pdf);
        assert_true(fabsf(weight.x * pdf - f.x) <= 4e-3f * f.x + 1e-7f);
        assert_true(fabsf(weight.z * pdf - f.z) <= 4e-3f * f.z + 1e-7f);
    }
}

enum { BINS_Z = 16, BINS_PHI = 32, BINS = 2 * BINS_Z * BINS_PHI + 1, FINE = 32 };

static size_t bin_of(air_vec3 w)
{
    const float phi = atan2f(w.y, w.x) / (2.0f * AIR_PI_F) + 0.5f;
    const size_t z = (size_t)fminf((w.z + 1.0f) * BINS_Z, 2 * BINS_Z - 1);
    return z * BINS_PHI + (size_t)fminf(phi * BINS_PHI, BINS_PHI - 1);
}

/* The share of samples that each bin of directions should get; the last is "no reflection". */
static double expect_shares(const air_bsdf *bsdf, air_vec3 wo, double *shares)
{
    double total = 0.0;
    for (size_t bin = 0; bin + 1 < BINS; bin++) {
        shares[bin] = 0.0;
    }
    for (int iz = 0; iz < 2 * BINS_Z * FINE; iz++) {
        const float z = ((float)iz + 0.5f) / (BINS_Z * FINE) - 1.0f;
        const float radius = sqrtf(1.0f - z * z);
        for (int ip = 0; ip < BINS_PHI * FINE; ip++) {
            const float phi = 2.0f * AIR_PI_F * (((float)ip + 0.5f) / (BINS_PHI * FINE) - 0.5f);
            const air_vec3 wi = vec3(radius * cosf(phi), radius * sinf(phi), z);
            const double share = (double)air_bsdf_sample_pdf(bsdf, wo, wi) * 4.0 * AIR_PI /
                                 (2.0 * BINS_Z * BINS_PHI * FINE * FINE);
            shares[(size_t)(iz / FINE) * BINS_PHI + (size_t)(ip / FINE)] += share;
            total += share;
        }
    }
    shares[BINS - 1] = 1.0 - total;
    return total;
}

static void check_sampler(const air_bsdf_input *input, uint32_t seed, bool complete)
{
    enum { SAMPLES = 200000 };
    double expected[BINS], observed[BINS] = {0.0};
    air_bsdf bsdf;
    air_bsdf_make(input, &bsdf);
    const double total = expect_shares(&bsdf, input->wo, expected);
    assert_true(total <
                1.0 + 2e-3); /* midpoints over the edges of the hemispheres: 1 / (BINS_Z FINE) */
    if (complete) {
        assert_true(total > 1.0 - 2e-3);
    }
    air_rng rng = air_rng_from_keys(seed, 13);
    double missed = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        const float u[3] = {air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)};
        air_vec3 wi, weight;
        float pdf;
        if (air_bsdf_sample(&bsdf, input->wo, u, &wi, &weight, &pdf)) {
            observed[bin_of(wi)] += 1.0;
        } else {
            missed += 1.0;
        }
    }
    observed[BINS - 1] = missed;
    for (size_t bin = 0; bin < BINS; bin++) {
        expected[bin] = fmax(0.0, expected[bin]) * SAMPLES;
        /* bins which only an edge cuts: the midpoints may have missed it */
        if (expected[bin] < 1.0) {
            expected[bin] = observed[bin] = 0.0;
        }
    }
    const double p = chi_square_p(observed, expected, BINS, NULL);
    assert_true(p > 1e-4); /* one false alarm in 10,000 seeds */
}

static void samples_follow_their_density(void **state)
{
    (void)state;
    const float mus[] = {0.15f, 0.5f, 0.9f};
    const float roughness[] = {0.35f, 0.6f, 1.0f};
    for (uint32_t i = 0; i < 9; i++) {
        air_bsdf_input input = plain_input(mus[i / 3]);
        input.roughness = roughness[i % 3];
        input.metallic = i % 2 == 0 ? 1.0f : 0.3f;
        check_sampler(&input, i, false);
    }
    air_bsdf_input lambert = plain_input(0.4f);
    lambert.specular = 0.0f;
    check_sampler(&lambert, 20, true);
    air_bsdf_input tilted = plain_input(0.4f);
    tilted.shading_normal = vec3_normalize(vec3(0.2f, -0.3f, 1.0f));
    check_sampler(&tilted, 21, false);
}

/* What is taken away and what stays are the whole, and samples of what stays have its density. */
static void surfaces_without_their_base_keep_the_rest(void **state)
{
    (void)state;
    for (int i = 0; i < 27; i++) {
        const float cosine = 0.2f + 0.35f * (float)(i % 3);
        air_bsdf_input input = {.base_color = {0.8f, 0.5f, 0.2f},
                                .metallic = 0.5f * (float)(i / 9),
                                .roughness = 0.1f + 0.4f * (float)(i / 3 % 3),
                                .specular = 1.0f,
                                .ior = 1.5f,
                                .shading_normal = {0, 0, 1},
                                .geometric_normal = {0, 0, 1},
                                .wo = {sqrtf(1.0f - cosine * cosine), 0, cosine}};
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        const air_vec3 whole = air_bsdf_albedo(&bsdf, input.wo);
        const air_vec3 base = air_bsdf_take_base(&bsdf, input.wo);
        const air_vec3 rest = air_bsdf_albedo(&bsdf, input.wo);
        assert_float_equal(base.x + rest.x, whole.x, 1e-6f);
        assert_float_equal(base.z + rest.z, whole.z, 1e-6f);
        assert_true(vec3_is_zero(air_bsdf_take_base(&bsdf, input.wo)));
        assert_false(air_bsdf_is_black(&bsdf));
        double sum = 0.0;
        air_rng rng = air_rng_from_keys(5, (uint32_t)i);
        for (int k = 0; k < 20000; k++) {
            const float u[3] = {air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)};
            air_vec3 wi, weight;
            float pdf;
            sum += air_bsdf_sample(&bsdf, input.wo, u, &wi, &weight, &pdf) ? (double)weight.x : 0.0;
        }
        /* weights are below 2 albedos, so their mean is within 2 / sqrt(20000) = 1.4 %, thrice */
        assert_true(fabs(sum / 20000.0 - (double)rest.x) < 0.042 * (double)rest.x + 0.0025);
    }
    air_bsdf lambert;
    air_bsdf_make(&(air_bsdf_input){.base_color = {0.5f, 0.5f, 0.5f},
                                    .roughness = 1.0f,
                                    .ior = 1.5f,
                                    .shading_normal = {0, 0, 1},
                                    .geometric_normal = {0, 0, 1},
                                    .wo = {0, 0, 1}},
                  &lambert);
    assert_float_equal(air_bsdf_take_base(&lambert, vec3(0, 0, 1)).y, 0.5f, 0.0f);
    assert_true(air_bsdf_is_black(&lambert));
}

static void mean_weight_is_the_albedo(void **state)
{
    (void)state;
    enum { SAMPLES = 40000 };
    for (uint32_t i = 0; i < 12; i++) {
        air_bsdf_input input = plain_input(0.1f + 0.07f * (float)i);
        input.roughness = 0.08f * (float)i;
        input.metallic = 0.25f * (float)(i % 5);
        input.base_color = vec3(0.9f, 0.5f, 0.1f);
        air_bsdf bsdf;
        air_bsdf_make(&input, &bsdf);
        air_rng rng = air_rng_from_keys(i, 17);
        double sum = 0.0, squares = 0.0;
        for (int k = 0; k < SAMPLES; k++) {
            const float u[3] = {air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)};
            air_vec3 wi, weight = {0.0f, 0.0f, 0.0f};
            float pdf;
            if (!air_bsdf_sample(&bsdf, input.wo, u, &wi, &weight, &pdf)) {
                weight = vec3_set1(0.0f);
            }
            sum += (double)weight.x;
            squares += (double)(weight.x * weight.x);
        }
        const double mean = sum / SAMPLES;
        const double error = sqrt(fmax(0.0, squares / SAMPLES - mean * mean) / SAMPLES);
        const double expected = (double)albedo(&bsdf, input.wo).x;
        assert_true(fabs(mean - expected) <
                    4.5 * error + 1e-3); /* 1e-3: the quadrature at grazing */
        /* lobes are chosen by albedo, so weights stay near it: the noise is small */
        assert_true(error * sqrt(SAMPLES) < 0.75);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reflection_is_reciprocal),
        cmocka_unit_test(white_metal_keeps_what_it_gets),
        cmocka_unit_test(white_dielectric_keeps_what_it_gets),
        cmocka_unit_test(further_reflections_are_tinted),
        cmocka_unit_test(no_surface_reflects_more_than_it_receives),
        cmocka_unit_test(without_specular_it_is_lambert),
        cmocka_unit_test(smooth_part_leaves_the_highlight),
        cmocka_unit_test(albedo_is_the_integral_of_the_reflection),
        cmocka_unit_test(light_does_not_leak_through_the_surface),
        cmocka_unit_test(weight_times_density_is_the_value),
        cmocka_unit_test(samples_follow_their_density),
        cmocka_unit_test(surfaces_without_their_base_keep_the_rest),
        cmocka_unit_test(mean_weight_is_the_albedo),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

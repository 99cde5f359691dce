/* Prepared responses: what the tables give, alone, in batches and by every instruction set. */
#include <stdlib.h>

#include "core/vec.h"
#include "failing_allocator.h"
#include "impulse/response.h"
#include "impulse_tables_shared.h"

enum { MEDIA = 6, PLACES = 4000 };

static impulse_shared shared;

static const air_impulse_medium media[MEDIA] = {
    {.sigma_s = 0.3, .sigma_t = 0.3, .g = 0.0, .bounces = 1},
    {.sigma_s = 0.2, .sigma_t = 0.3, .g = 0.4, .bounces = 6},
    {.sigma_s = 0.3, .sigma_t = 0.4, .g = 0.6, .bounces = 6, .rule = AIR_IMPULSE_RESIDUAL},
    {.sigma_s = 0.3, .sigma_t = 0.3, .g = -0.4, .bounces = 3},
    {.sigma_s = 0.0, .sigma_t = 0.5, .g = 0.2, .bounces = 3},
    {.sigma_s = 0.0, .sigma_t = 0.0, .g = 0.0, .bounces = 3}};

static int set_up(void **state)
{
    air_impulse_params params;
    (void)state;
    air_impulse_params_default(&params);
    params.bins = 128;
    params.g_count = 3;
    params.g[0] = -0.5;
    params.g[1] = 0.0;
    params.g[2] = 0.6;
    params.bounces = 6;
    shared_make(&shared, &params);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    shared_destroy(&shared);
    return 0;
}

static air_impulse_response *make(air_impulse_emitter emitter, const air_impulse_medium *medium,
                                  size_t channels)
{
    air_impulse_response *response;
    assert_int_equal(air_impulse_response_create(shared.context, shared.tables, emitter, medium,
                                                 channels, &response),
                     AIR_OK);
    return response;
}

static air_impulse_place_float to_float(const air_impulse_place *p)
{
    return (air_impulse_place_float){.distance = (float)p->distance,
                                     .n_l = (float)p->n_l,
                                     .cos_s = (float)p->cos_s,
                                     .n_x = (float)p->n_x};
}

/* Relative to the largest irradiance at the place, over normals (six of them): floats and the short
 * functions have 1e-6, powers of the normal up to 10 times that; where bounces of another
 * extinction are summed, bins lie elsewhere: a bin's own error again, of 128 bins 4 times 1e-4
 * (2e-3 near the directional light's first bin, of what is 1e-3 of the whole). */
static void it_is_what_the_tables_give(void **state)
{
    static const double bounds[MEDIA] = {3e-5, 2e-3, 2e-3, 2e-3, 0.0, 0.0};
    (void)state;
    for (int i = 0; i < MEDIA * AIR_IMPULSE_EMITTERS; i++) {
        const air_impulse_medium *const medium = &media[i % MEDIA];
        const air_impulse_emitter emitter = (air_impulse_emitter)(i / MEDIA);
        air_impulse_response *const response = make(emitter, medium, 1);
        air_rng rng = air_rng_from_keys(3, (uint32_t)i);
        double worst = 0.0;
        for (int j = 0; j < PLACES; j++) {
            const air_impulse_place place = shared_place(&rng);
            const air_impulse_place_float as_float = to_float(&place);
            double most = 1e-30;
            float found;
            for (int axis = 0; axis < 6; axis++) {
                air_impulse_place other = place;
                const double sign = axis % 2 == 0 ? 1.0 : -1.0;
                other.n_l = axis / 2 == 0 ? sign : 0.0;
                other.n_x = axis / 2 == 1 ? sign : 0.0;
                most = double_max(most,
                                  air_impulse_irradiance(shared.tables, emitter, medium, &other));
            }
            air_impulse_response_irradiance(response, &as_float, &found);
            const double exact = air_impulse_irradiance(shared.tables, emitter, medium, &place);
            assert_true(found >= 0.0f);
            worst = double_max(worst, fabs(found - exact) / most);
        }
        print_message("emitter %d, medium %d: %.1e\n", i / MEDIA, i % MEDIA, worst);
        assert_true(worst <= bounds[i % MEDIA]);
        air_impulse_response_destroy(response);
    }
}

/* Every instruction set of this machine, counts that do not fill lanes, three channels. */
static void batches_are_the_same(void **state)
{
    static float distance[PLACES], n_l[PLACES], cos_s[PLACES], n_x[PLACES], out[3][PLACES];
    static const size_t counts[4] = {1, 15, 64, PLACES - 3};
    impulse_batch *const batches[4] = {
        impulse_batch_plain,
#if defined(__x86_64__)
        impulse_batch_sse42,
        impulse_batch_avx2,
        impulse_batch_avx512
#endif
    };
    const int levels = (int)air_context_cpu(shared.context); /* C is 1 */
    const air_impulse_places places = {distance, n_l, cos_s, n_x};
    float *const outs[3] = {out[0], out[1], out[2]};
    air_rng rng = air_rng_from_keys(8, 8);
    (void)state;
    for (int i = 0; i < PLACES; i++) {
        const air_impulse_place place = shared_place(&rng);
        const air_impulse_place_float p = to_float(&place);
        distance[i] = p.distance * (i % 7 == 0 ? 10.0f : 1.0f); /* beyond the tables, too */
        n_l[i] = p.n_l;
        cos_s[i] = i == 0 ? 1.0f : i == 1 ? -1.0f : p.cos_s;
        n_x[i] = p.n_x;
    }
    for (int i = 0; i < 4 * levels * AIR_IMPULSE_EMITTERS; i++) {
        const air_impulse_emitter emitter = (air_impulse_emitter)(i / 4 / levels);
        air_impulse_response *const response = make(emitter, media, 3);
        const size_t count = counts[i % 4];
        batches[i / 4 % levels](response, &places, count, outs);
        for (size_t j = 0; j < count; j++) {
            const air_impulse_place_float place = {distance[j], n_l[j], cos_s[j], n_x[j]};
            float expected[3];
            air_impulse_response_irradiance(response, &place, expected);
            for (int c = 0; c < 3; c++) {
                /* places in the table to 2e-6 of a bin's width times 128, entries vary by a tenth
                 * from bin to bin, and cancel where the receiver is turned away: 1e-4 of the entry
                 */
                const float size =
                    expected[c] +
                    (emitter == AIR_IMPULSE_DIRECTIONAL ? 0.1f : 0.1f * 0.3f / distance[j]) *
                        expf(-0.3f * distance[j]);
                assert_true(fabsf(out[c][j] - expected[c]) <= 1e-4f * size);
            }
        }
        air_impulse_response_destroy(response);
    }
}

/* Without absorption all of a point light's power, 4 pi, goes through any sphere about it: what a
 * receiver that faces the light has more than one that looks away is 1/d^2 less the unscattered
 * exp(-tau)/d^2. Only band 1 is in it. A patch's mean over its orientations is a quarter. Of
 * 128 bins the scaled sum of terms that fall off as exp(-2 rho) and slowly is off by (2 d rho)^2/8
 * at most, d rho = 0.08 at rho = 1: 3e-3 of the former's share, which there is a third at most. */
static void all_orders_carry_the_power(void **state)
{
    const air_impulse_medium medium = {.sigma_s = 0.5, .sigma_t = 0.5, .bounces = 1};
    const graded_rule rule = graded_rule_make(12);
    (void)state;
    for (int i = 0; i < 2; i++) {
        const air_impulse_emitter emitter = i == 0 ? AIR_IMPULSE_POINT : AIR_IMPULSE_AREA;
        air_impulse_response *response;
        double worst = 0.0;
        assert_int_equal(air_impulse_response_create_all_orders(shared.context, shared.tables,
                                                                emitter, &medium, 1, &response),
                         AIR_OK);
        for (double tau = 0.05; tau < 20.0; tau *= 1.31) {
            const double d = tau / 0.5, exact = -expm1(-tau) / (d * d) * (i == 0 ? 1.0 : 0.25);
            double flux = 0.0;
            for (int j = 0; j < 24; j++) {
                const double c = (j < 12 ? -1.0 : 0.0) + rule.x[j % 12];
                float e[2];
                for (int side = 0; side < 2; side++) {
                    const air_impulse_place_float place = {
                        .distance = (float)d, .n_l = side == 0 ? 1.0f : -1.0f, .cos_s = (float)c};
                    air_impulse_response_irradiance(response, &place, &e[side]);
                }
                flux += 0.5 * rule.w[j % 12] * ((double)e[0] - (double)e[1]);
            }
            worst = double_max(worst, fabs(flux / exact - 1.0));
        }
        print_message("flux, emitter %d: %.1e\n", i, worst);
        assert_true(worst < 1e-3);
        air_impulse_response_destroy(response);
    }
}

/* With absorption enough the tables' six bounces and what they leave, 0.3^7 of little, are as good
 * as six bounces alone. */
static void all_orders_of_an_absorbing_medium_are_its_first(void **state)
{
    const air_impulse_medium medium = {.sigma_s = 0.15, .sigma_t = 0.5, .bounces = 6};
    air_impulse_response *all, *some;
    (void)state;
    assert_int_equal(air_impulse_response_create_all_orders(shared.context, shared.tables,
                                                            AIR_IMPULSE_AREA, &medium, 1, &all),
                     AIR_OK);
    some = make(AIR_IMPULSE_AREA, &medium, 1);
    for (double d = 0.1; d < 20.0; d *= 1.7) {
        for (int j = 0; j < 9; j++) {
            const air_impulse_place_float place = {
                .distance = (float)d, .n_l = 0.8f, .cos_s = 0.25f * (float)j - 1.0f, .n_x = 0.3f};
            float a, b;
            air_impulse_response_irradiance(all, &place, &a);
            air_impulse_response_irradiance(some, &place, &b);
            assert_true(fabsf(a - b) < 0.01f * b);
        }
    }
    air_impulse_response_destroy(all);
    air_impulse_response_destroy(some);
    assert_int_equal(air_impulse_response_create_all_orders(
                         shared.context, shared.tables, AIR_IMPULSE_DIRECTIONAL, &medium, 1, &all),
                     AIR_ERROR_UNSUPPORTED);
    assert_null(all);
}

static void cube_roots_and_arc_cosines_are_exact_enough(void **state)
{
    (void)state;
    for (double x = 1e-25; x < 1e6; x *= 1.0037) {
        assert_true(fabs(impulse_cube_root((float)x) / cbrt((float)x) - 1.0) < 5e-7);
    }
    for (double c = -1.0; c <= 1.0; c += 1e-4) {
        assert_true(fabs(impulse_arc_cosine((float)c) - acos((float)c)) < 7e-7);
    }
}

static void wrong_media_are_refused(void **state)
{
    air_impulse_response *response;
    air_impulse_medium wrong[5];
    (void)state;
    for (int i = 0; i < 5; i++) {
        wrong[i] = media[0];
    }
    wrong[0].sigma_s = 0.4; /* more than is taken out */
    wrong[1].sigma_t = NAN;
    wrong[2].g = 1.0;
    wrong[3].bounces = 0;
    wrong[4].sigma_s = -0.1;
    for (int i = 0; i < 5; i++) {
        assert_int_equal(air_impulse_response_create(shared.context, shared.tables,
                                                     AIR_IMPULSE_POINT, &wrong[i], 1, &response),
                         AIR_ERROR_ARGUMENT);
        assert_null(response);
    }
    assert_int_equal(air_impulse_response_create(shared.context, shared.tables, AIR_IMPULSE_POINT,
                                                 media, 4, &response),
                     AIR_ERROR_ARGUMENT);
    air_impulse_response_destroy(NULL);
}

static void lack_of_memory_leaves_nothing(void **state)
{
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, 1000);
    air_context *context;
    air_impulse_response *response;
    (void)state;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    const long before = atomic_load(&allocator.live);
    for (long allowed = 0; allowed < 4; allowed++) {
        atomic_store(&allocator.remaining, allowed);
        const air_status status = air_impulse_response_create(
            context, shared.tables, AIR_IMPULSE_POINT, media, 3, &response);
        assert_int_equal(status, AIR_ERROR_MEMORY);
        assert_null(response);
    }
    atomic_store(&allocator.remaining, 1000);
    air_context_destroy(context);
    assert_true(atomic_load(&allocator.live) == 0 && before >= 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_what_the_tables_give),
        cmocka_unit_test(batches_are_the_same),
        cmocka_unit_test(all_orders_carry_the_power),
        cmocka_unit_test(all_orders_of_an_absorbing_medium_are_its_first),
        cmocka_unit_test(cube_roots_and_arc_cosines_are_exact_enough),
        cmocka_unit_test(wrong_media_are_refused),
        cmocka_unit_test(lack_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

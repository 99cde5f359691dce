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
        cmocka_unit_test(cube_roots_and_arc_cosines_are_exact_enough),
        cmocka_unit_test(wrong_media_are_refused),
        cmocka_unit_test(lack_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

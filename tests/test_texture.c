/* Textures: transfer function, channels, filter, wrap modes. */
#include <math.h>

#include "scene/texture.h"
#include "scene_fixture.h"

/* 2 x 2 texels, grey: 1 2 / 3 5. */
static float grey[4] = {1.0f, 2.0f, 3.0f, 5.0f};

static air_texture grey_texture(air_wrap wrap_u, air_wrap wrap_v, air_filter_kind filter)
{
    return (air_texture){.width = 2,
                         .height = 2,
                         .channels = 1,
                         .floats = grey,
                         .wrap_u = wrap_u,
                         .wrap_v = wrap_v,
                         .filter = filter};
}

static void assert_value(const air_texture *texture, float u, float v, float expected)
{
    const float value = air_texture_rgb(texture, u, v).x;
    /* three interpolations of numbers below 5 in float, and the rounding of u and v: below 1e-5 */
    if (!(fabsf(value - expected) < 1e-5f))
        fail_msg("at (%g, %g): %g, not %g", (double)u, (double)v, (double)value, (double)expected);
}

static void texel_centres_give_the_texels(void **state)
{
    (void)state;
    for (int wrap = 0; wrap < 3; ++wrap) {
        for (int filter = 0; filter < 2; ++filter) {
            const air_texture texture =
                grey_texture((air_wrap)wrap, (air_wrap)wrap, (air_filter_kind)filter);
            assert_value(&texture, 0.25f, 0.25f, 1.0f);
            assert_value(&texture, 0.75f, 0.25f, 2.0f);
            assert_value(&texture, 0.25f, 0.75f, 3.0f);
            assert_value(&texture, 0.75f, 0.75f, 5.0f);
        }
    }
}

static void linear_filter_interpolates(void **state)
{
    const air_texture texture = grey_texture(AIR_WRAP_REPEAT, AIR_WRAP_REPEAT, AIR_TEXTURE_LINEAR);
    (void)state;
    assert_value(&texture, 0.5f, 0.25f, 1.5f);
    assert_value(&texture, 0.25f, 0.5f, 2.0f);
    assert_value(&texture, 0.5f, 0.5f, 2.75f);
    /* a quarter of the way in u and three quarters in v: 0.25 (0.75 1 + 0.25 2) + 0.75 (0.75 3 +
     * 0.25 5) */
    assert_value(&texture, 0.375f, 0.625f, 0.25f * 1.25f + 0.75f * 3.5f);
}

static void repeat_joins_the_edges(void **state)
{
    const air_texture texture = grey_texture(AIR_WRAP_REPEAT, AIR_WRAP_REPEAT, AIR_TEXTURE_LINEAR);
    (void)state;
    assert_value(&texture, 0.0f, 0.25f, 1.5f);
    assert_value(&texture, 1.0f, 0.25f, 1.5f);
    assert_value(&texture, 0.25f, 0.0f, 2.0f);
    for (int i = -3; i <= 3; ++i) {
        assert_value(&texture, 0.375f + (float)i, 0.25f, 1.25f);
        assert_value(&texture, 0.25f, 0.375f + (float)i, 1.5f);
    }
}

static void clamp_holds_the_edges(void **state)
{
    const air_texture texture = grey_texture(AIR_WRAP_CLAMP, AIR_WRAP_CLAMP, AIR_TEXTURE_LINEAR);
    (void)state;
    assert_value(&texture, 0.0f, 0.0f, 1.0f);
    assert_value(&texture, -7.0f, 0.25f, 1.0f);
    assert_value(&texture, 1.0f, 0.25f, 2.0f);
    assert_value(&texture, 9.0f, 9.0f, 5.0f);
    assert_value(&texture, 0.5f, 9.0f, 4.0f);
}

static void mirror_turns_every_other_copy_round(void **state)
{
    const air_texture texture = grey_texture(AIR_WRAP_MIRROR, AIR_WRAP_MIRROR, AIR_TEXTURE_LINEAR);
    (void)state;
    assert_value(&texture, 0.0f, 0.25f, 1.0f);
    assert_value(&texture, 1.0f, 0.25f, 2.0f);
    assert_value(&texture, 1.25f, 0.25f, 2.0f);
    assert_value(&texture, 1.625f, 0.25f, 1.25f);
    assert_value(&texture, -0.375f, 0.25f, 1.25f);
    assert_value(&texture, -1.375f, 0.25f, 1.75f);
    assert_value(&texture, 2.375f, -1.75f, 1.25f);
}

static void wrap_modes_are_separate_for_u_and_v(void **state)
{
    const air_texture texture = grey_texture(AIR_WRAP_CLAMP, AIR_WRAP_REPEAT, AIR_TEXTURE_LINEAR);
    (void)state;
    assert_value(&texture, -1.0f, 1.25f, 1.0f);
    assert_value(&texture, 2.0f, -0.25f, 5.0f);
}

static void nearest_filter_does_not_interpolate(void **state)
{
    const air_texture texture = grey_texture(AIR_WRAP_REPEAT, AIR_WRAP_CLAMP, AIR_TEXTURE_NEAREST);
    (void)state;
    assert_value(&texture, 0.49f, 0.49f, 1.0f);
    assert_value(&texture, 0.51f, 0.49f, 2.0f);
    assert_value(&texture, -0.01f, 0.0f, 2.0f);
    assert_value(&texture, 0.0f, 1.0f, 3.0f);
    assert_value(&texture, 1.0f, 1.0f, 3.0f);
}

static void any_coordinate_is_safe(void **state)
{
    const float strange[] = {NAN,    INFINITY, -INFINITY, 1e30f,
                             -1e30f, 3.4e38f,  -1e-30f,   16777217.0f};
    const size_t count = sizeof strange / sizeof *strange;
    (void)state;
    for (int wrap = 0; wrap < 3; ++wrap) {
        for (int filter = 0; filter < 2; ++filter) {
            const air_texture texture =
                grey_texture((air_wrap)wrap, (air_wrap)wrap, (air_filter_kind)filter);
            for (size_t i = 0; i < count * count; ++i) {
                const float value =
                    air_texture_rgb(&texture, strange[i % count], strange[i / count]).x;
                assert_true(value >= 1.0f && value <= 5.0f);
            }
        }
    }
}

static void missing_channels_are_grey_and_opaque(void **state)
{
    float values[4] = {0.1f, 0.2f, 0.3f, 0.4f};
    const float expected[4][4] = {{0.1f, 0.1f, 0.1f, 1.0f},
                                  {0.1f, 0.1f, 0.1f, 0.2f},
                                  {0.1f, 0.2f, 0.3f, 1.0f},
                                  {0.1f, 0.2f, 0.3f, 0.4f}};
    (void)state;
    for (size_t channels = 1; channels <= 4; ++channels) {
        const air_texture texture = {
            .width = 1, .height = 1, .channels = channels, .floats = values};
        float rgba[4];
        air_texture_lookup(&texture, 0.3f, 0.7f, rgba);
        assert_memory_equal(rgba, expected[channels - 1], sizeof rgba);
    }
}

static void srgb_bytes_follow_the_transfer_function_except_in_alpha(void **state)
{
    (void)state;
    for (int i = 0; i < 256; ++i) {
        uint8_t bytes[4] = {(uint8_t)i, (uint8_t)i, (uint8_t)i, (uint8_t)i};
        air_texture texture = {
            .width = 1, .height = 1, .channels = 4, .bytes = bytes, .srgb = true};
        float rgba[4];
        const double c = i / 255.0;
        const double linear = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        air_texture_lookup(&texture, 0.5f, 0.5f, rgba);
        assert_true(fabs((double)rgba[1] - linear) <= 1e-7 * linear);
        assert_true(fabs((double)rgba[3] - c) <= 1e-7 * c);
        texture.srgb = false;
        air_texture_lookup(&texture, 0.5f, 0.5f, rgba);
        assert_true(fabs((double)rgba[1] - c) <= 1e-7 * c);
    }
}

static void slots_move_coordinates(void **state)
{
    /* a quarter turn, scale 2 and an offset, as KHR_texture_transform composes them */
    const air_texture_slot slot = {.uv_transform = {0, 2, 0.5f, -2, 0, 0.25f}};
    const float uv[2] = {0.1f, 0.3f};
    float out[2];
    (void)state;
    air_texture_slot_uv(&slot, uv, out);
    assert_true(fabsf(out[0] - 1.1f) < 1e-6f && fabsf(out[1] - 0.05f) < 1e-6f);
}

static void triangle_means_are_means(void **state)
{
    const float whole[3][2] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}};
    const float other[3][2] = {{1.0f, 1.0f}, {0.0f, 1.0f}, {1.0f, 0.0f}};
    const float point[3][2] = {{0.75f, 0.75f}, {0.75f, 0.75f}, {0.75f, 0.75f}};
    enum { SIDE = 128 };
    static float ramp[SIDE * SIDE];
    (void)state;
    for (size_t i = 0; i < SIDE * SIDE; ++i)
        ramp[i] = ((float)(i % SIDE) + 0.5f) / SIDE;
    const air_texture texture = {.width = SIDE,
                                 .height = SIDE,
                                 .channels = 1,
                                 .floats = ramp,
                                 .wrap_u = AIR_WRAP_CLAMP,
                                 .wrap_v = AIR_WRAP_CLAMP,
                                 .filter = AIR_TEXTURE_LINEAR};
    /* of u over the two halves of the unit square: 1/3 and 2/3. The midpoint rule is exact for
     * linear functions; the texture departs from u by at most 1/256 in the half texels at its
     * sides, 1/128 of its area: 3e-5 */
    assert_true(fabsf(air_texture_triangle_mean(&texture, whole).x - 1.0f / 3.0f) < 4e-5f);
    assert_true(fabsf(air_texture_triangle_mean(&texture, other).x - 2.0f / 3.0f) < 4e-5f);
    assert_true(fabsf(air_texture_triangle_mean(&texture, point).x - 0.75f) < 1e-5f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texel_centres_give_the_texels),
        cmocka_unit_test(linear_filter_interpolates),
        cmocka_unit_test(repeat_joins_the_edges),
        cmocka_unit_test(clamp_holds_the_edges),
        cmocka_unit_test(mirror_turns_every_other_copy_round),
        cmocka_unit_test(wrap_modes_are_separate_for_u_and_v),
        cmocka_unit_test(nearest_filter_does_not_interpolate),
        cmocka_unit_test(any_coordinate_is_safe),
        cmocka_unit_test(missing_channels_are_grey_and_opaque),
        cmocka_unit_test(srgb_bytes_follow_the_transfer_function_except_in_alpha),
        cmocka_unit_test(slots_move_coordinates),
        cmocka_unit_test(triangle_means_are_means),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

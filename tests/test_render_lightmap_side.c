/* Which side and which normal of a surface baked light belongs to. */
#include "core/harmonics.h"
#include "core/vec.h"
#include "lightmap_view.h"

static const char *const one_square[] = {"square"};

/* Light from one direction, of irradiance 1 across it, as a page of one texel: irradiance on the
 * plane z = 0, and the coefficients of its radiance. */
static air_image *beam_page(air_context *context, air_vec3 dir)
{
    const float d[3] = {dir.x, dir.y, dir.z};
    const float irradiance = fmaxf(0.1f, dir.z);
    float y[9];
    air_image *page = view_page(context, 1, 1, true);
    view_fill(page, VIEW_DIRECT, irradiance, irradiance, irradiance);
    view_fill(page, VIEW_MEDIA, 2.0f * irradiance, 0.0f, 0.0f);
    air_sh_evaluate_3(d, y);
    for (size_t k = 0; k < AIR_DIRECTIONAL_COEFFICIENTS; k++) {
        view_fill(page, VIEW_HARMONICS + 3 * k, y[k], y[k], y[k]);
    }
    return page;
}

/* A white square with the normal everywhere (in its own frame: x along u, y against v), and no
 * normal map where that is +z. */
static air_snapshot *tilted_scene(air_context *context, air_vec3 normal, bool double_sided,
                                  float side)
{
    const float rgba[4] = {0.5f + 0.5f * normal.x, 0.5f + 0.5f * normal.y, 0.5f + 0.5f * normal.z,
                           1.0f};
    const air_texture_desc texture = {
        .name = "tilt", .width = 1, .height = 1, .channels = 4, .floats = rgba};
    air_scene *scene = fixture_scene(context);
    air_material_desc material = view_lambert(1.0f, 1.0f, 1.0f);
    material.double_sided = double_sided;
    if (normal.z < 1.0f) {
        assert_int_equal(air_scene_add_texture(scene, &texture, &material.normal_texture.texture),
                         AIR_OK);
    }
    view_add_square(scene, "square", view_add_material(scene, &material));
    view_add_camera(scene, side);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    return snapshot;
}

typedef struct shown {
    double direct, further; /* times pi: irradiance as the normal has it */
} shown;

/* What the middle of the picture shows of a page, which it takes. */
static shown show(air_context *context, air_snapshot *snapshot, air_image *page)
{
    air_lightmap *lightmap = view_lightmap(context, one_square, 1, page);
    const air_render_params params = view_params(lightmap);
    air_image *image = view_render(context, snapshot, &params);
    const shown out = {AIR_PI * view_value(image, "S0.R", 3, 4),
                       AIR_PI * view_value(image, "S+.R", 3, 4)};
    air_image_destroy(image);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    return out;
}

static void normal_maps_turn_irradiance(void **state)
{
    (void)state;
    static const struct {
        air_vec3 normal, dir;
    } cases[] = {
        {{0.6f, 0.0f, 0.8f}, {0.6f, 0.0f, 0.8f}},   {{0.6f, 0.0f, 0.8f}, {-0.6f, 0.0f, 0.8f}},
        {{0.0f, 0.6f, 0.8f}, {0.0f, 0.8f, 0.6f}},   {{0.0f, -0.6f, 0.8f}, {0.0f, 0.8f, 0.6f}},
        {{0.28f, 0.0f, 0.96f}, {0.0f, 0.0f, 1.0f}}, {{0.6f, 0.0f, 0.8f}, {1.0f, 0.0f, 0.0f}},
    };
    air_context *context = fixture_context();
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const air_vec3 n = cases[k].normal, d = cases[k].dir;
        const double turned = 0.25 + 0.5 * (double)vec3_dot(n, d);
        const double baked = 0.25 + 0.5 * (double)d.z;
        const double irradiance = fmax((double)0.1f, (double)d.z);
        const shown got =
            show(context, tilted_scene(context, n, false, 1.0f), beam_page(context, d));
        /* constants of harmonics are rounded to 8 digits, the rest to 6e-8 a dozen times, and what
         * is subtracted is at most three times as large as what is left */
        assert_true(fabs(got.direct - irradiance * turned / baked) <= 1e-5);
        assert_true(fabs(got.further - 2.0 * irradiance * turned / baked) <= 2e-5);
    }
    air_context_destroy(context);
}

/* A normal map that agrees with the mesh changes no bit. */
static void without_a_normal_map_directions_do_not_matter(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    const air_vec3 up = vec3(0.0f, 0.0f, 1.0f), d = vec3(0.48f, 0.64f, 0.6f);
    air_image *plain = view_page(context, 1, 1, false);
    view_fill(plain, VIEW_DIRECT, 0.6f, 0.6f, 0.6f);
    view_fill(plain, VIEW_MEDIA, 1.2f, 0.0f, 0.0f);
    const shown with = show(context, tilted_scene(context, up, false, 1.0f), beam_page(context, d));
    const shown without = show(context, tilted_scene(context, up, false, 1.0f), plain);
    assert_true(with.direct == without.direct && with.further == without.further);
    assert_true(with.direct > 0.0);
    air_context_destroy(context);
}

/* Noise can make coefficients that no light from the front has. */
static void irradiance_is_never_negative_or_more_than_three_times_as_much(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    const air_vec3 steep = vec3(0.96f, 0.0f, 0.28f), tilt = vec3(0.6f, 0.0f, 0.8f);
    const shown none = show(context, tilted_scene(context, steep, false, 1.0f),
                            beam_page(context, vec3(-1.0f, 0.0f, 0.0f)));
    assert_true(none.direct == 0.0 && none.further == 0.0);
    const shown most = show(context, tilted_scene(context, tilt, false, 1.0f),
                            beam_page(context, vec3(0.9f, 0.0f, -0.43588989f)));
    assert_true(fabs(most.direct - 0.3) <= 1e-6); /* 3 times 0.1 */
    /* below the horizon altogether: no ratio to be had, so what was baked stays */
    const shown same = show(context, tilted_scene(context, tilt, false, 1.0f),
                            beam_page(context, vec3(0.0f, 0.0f, -1.0f)));
    assert_true(fabs(same.direct - 0.1) <= 1e-6);
    air_context_destroy(context);
}

static void backs_are_dark_unless_both_sides_count(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    const air_vec3 up = vec3(0.0f, 0.0f, 1.0f), tilt = vec3(0.6f, 0.0f, 0.8f);
    const air_vec3 d = vec3(0.6f, 0.0f, 0.8f);
    const shown back =
        show(context, tilted_scene(context, up, false, -1.0f), beam_page(context, d));
    assert_true(back.direct == 0.0 && back.further == 0.0);
    for (int tilted = 0; tilted < 2; tilted++) {
        const air_vec3 n = tilted ? tilt : up;
        const shown front =
            show(context, tilted_scene(context, n, true, 1.0f), beam_page(context, d));
        const shown both =
            show(context, tilted_scene(context, n, true, -1.0f), beam_page(context, d));
        assert_true(fabs(front.direct - (tilted ? 0.8 * 0.75 / 0.65 : 0.8)) <= 1e-5);
        assert_true(fabs(both.direct - front.direct) <= 1e-6);
        assert_true(fabs(both.further - front.further) <= 2e-6);
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normal_maps_turn_irradiance),
        cmocka_unit_test(without_a_normal_map_directions_do_not_matter),
        cmocka_unit_test(irradiance_is_never_negative_or_more_than_three_times_as_much),
        cmocka_unit_test(backs_are_dark_unless_both_sides_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

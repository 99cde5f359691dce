/* Pictures that show a lightmap: what a surface sends is its albedo times irradiance / pi, exactly,
 * and everything else is as without. */
#include "core/vec.h"
#include "lightmap_view.h"

static const char *const one_square[] = {"square"};
static const char *const channels[3] = {"R", "G", "B"};
static const char *const direct_names[3] = {"S0.R", "S0.G", "S0.B"};
static const char *const further_names[3] = {"S+.R", "S+.G", "S+.B"};

/* Every value here is a product or sum of at most a dozen numbers of one sign, each rounded to
 * 6e-8, and air_exp is within 2.4e-7. */
#define ROUNDING 1e-6

static void assert_near(double got, double expected)
{
    if (!(fabs(got - expected) <= ROUNDING * fabs(expected))) {
        fail_msg("%.9g instead of %.9g", got, expected);
    }
}

/* A Lambert square, seen from its front or its back. */
static air_snapshot *square_scene(air_context *context, const air_material_desc *material,
                                  float side)
{
    air_scene *scene = fixture_scene(context);
    view_add_square(scene, "square", view_add_material(scene, material));
    view_add_camera(scene, side);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    return snapshot;
}

/* Irradiance 1, 2, 3 straight from lights, 4, 5, 6 by way of surfaces, 7, 8, 9 from media. */
static air_image *even_page(air_context *context)
{
    air_image *page = view_page(context, 4, 4, false);
    view_fill(page, VIEW_DIRECT, 1.0f, 2.0f, 3.0f);
    view_fill(page, VIEW_INDIRECT, 4.0f, 5.0f, 6.0f);
    view_fill(page, VIEW_MEDIA, 7.0f, 8.0f, 9.0f);
    return page;
}

static void even_light_leaves_as_albedo_times_irradiance_over_pi(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    const air_material_desc material = view_lambert(0.2f, 0.5f, 0.8f);
    air_snapshot *snapshot = square_scene(context, &material, 1.0f);
    air_lightmap *lightmap = view_lightmap(context, one_square, 1, even_page(context));
    const air_render_params params = view_params(lightmap);
    air_image *image = view_render(context, snapshot, &params);
    for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
        for (size_t c = 0; c < 3; c++) {
            const double albedo = (double)material.base_color[c];
            const double direct = albedo * (double)(1 + c) / AIR_PI;
            const double further = albedo * (double)(11 + 2 * c) / AIR_PI;
            assert_near(view_value(image, direct_names[c], i % VIEW_SIZE, i / VIEW_SIZE), direct);
            assert_near(view_value(image, further_names[c], i % VIEW_SIZE, i / VIEW_SIZE), further);
            assert_near(view_value(image, channels[c], i % VIEW_SIZE, i / VIEW_SIZE),
                        direct + further);
        }
    }
    air_image_destroy(image);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- where on the page ---- */

/* direct.R = 1 + 10 x + 100 y at the texel (x, y). */
static air_image *sloping_page(air_context *context, size_t width, size_t height)
{
    air_image *page = view_page(context, width, height, false);
    for (size_t i = 0; i < width * height; i++) {
        air_image_plane(page, VIEW_DIRECT)[i] = (float)(1 + 10 * (i % width) + 100 * (i / width));
    }
    return page;
}

/* The same at page coordinates, between the outermost texel centres. */
static double slope_at(double u, double v, size_t width, size_t height)
{
    const double x = fmin(fmax(u * (double)width - 0.5, 0.0), (double)(width - 1));
    const double y = fmin(fmax(v * (double)height - 0.5, 0.0), (double)(height - 1));
    return 1.0 + 10.0 * x + 100.0 * y;
}

static void light_between_texels_is_bilinear(void **state)
{
    (void)state;
    static const size_t sizes[][2] = {{5, 3}, {8, 16}, {1, 1}, {1, 7}};
    static const float places[][4] = {{1, 1, 0, 0}, {0.5f, 0.25f, 0.25f, 0.5f}};
    air_context *context = fixture_context();
    const air_material_desc white = view_lambert(1.0f, 1.0f, 1.0f);
    air_snapshot *snapshot = square_scene(context, &white, 1.0f);
    for (size_t k = 0; k < 8; k++) {
        const size_t *size = sizes[k / 2];
        const float *place = places[k % 2];
        air_lightmap *lightmap =
            view_lightmap(context, one_square, 1, sloping_page(context, size[0], size[1]));
        memcpy(lightmap->meshes[0].scale, place, 2 * sizeof(float));
        memcpy(lightmap->meshes[0].offset, place + 2, 2 * sizeof(float));
        const air_render_params params = view_params(lightmap);
        air_image *image = view_render(context, snapshot, &params);
        for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
            const size_t x = i % VIEW_SIZE, y = i / VIEW_SIZE;
            const double u = ((double)x + 0.5) / VIEW_SIZE * (double)place[0] + (double)place[2];
            const double v = ((double)y + 0.5) / VIEW_SIZE * (double)place[1] + (double)place[3];
            /* hits are where the ray is to 1e-6 m, 16e-6 texels of at most 100 / pi each */
            const double got = view_value(image, "S0.R", x, y);
            assert_true(fabs(got - slope_at(u, v, size[0], size[1]) / AIR_PI) <= 1e-3);
        }
        air_image_destroy(image);
        air_lightmap_destroy(lightmap);
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* The square cut along its diagonal, its two triangles on the left and the right half of the page:
 * u of the mesh becomes u / 2 below the diagonal, 1 - v / 2 above it. */
static void cut_meshes_are_looked_up_by_their_own_corners(void **state)
{
    (void)state;
    static const uint32_t sources[6] = {0, 1, 2, 2, 0, 3}, indices[6] = {0, 1, 2, 4, 3, 5};
    static const float uv[12] = {0, 0, 0.5f, 0, 0.5f, 0, 1, 0, 0.5f, 0, 1, 0};
    air_context *context = fixture_context();
    const air_material_desc white = view_lambert(1.0f, 1.0f, 1.0f);
    air_snapshot *snapshot = square_scene(context, &white, 1.0f);
    air_lightmap *lightmap = view_lightmap(context, one_square, 1, sloping_page(context, 64, 1));
    air_lightmap_mesh *mesh = &lightmap->meshes[0];
    mesh->vertex_count = 6;
    mesh->triangle_count = 2;
    mesh->sources = air_allocate(context, 6, sizeof(uint32_t));
    mesh->indices = air_allocate(context, 6, sizeof(uint32_t));
    mesh->uv = air_allocate(context, 12, sizeof(float));
    memcpy(mesh->sources, sources, sizeof sources);
    memcpy(mesh->indices, indices, sizeof indices);
    memcpy(mesh->uv, uv, sizeof uv);
    const air_render_params params = view_params(lightmap);
    air_image *image = view_render(context, snapshot, &params);
    size_t below = 0;
    for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
        const size_t x = i % VIEW_SIZE, y = i / VIEW_SIZE;
        const double u = ((double)x + 0.5) / VIEW_SIZE, v = ((double)y + 0.5) / VIEW_SIZE;
        if (x + y == VIEW_SIZE - 1) {
            continue; /* on the cut */
        }
        below += x + y > VIEW_SIZE - 1;
        const double at = x + y > VIEW_SIZE - 1 ? 0.5 * u : 1.0 - 0.5 * v;
        assert_true(fabs(view_value(image, "S0.R", x, y) - slope_at(at, 0, 64, 1) / AIR_PI) < 1e-3);
    }
    assert_int_equal(below, VIEW_SIZE * (VIEW_SIZE - 1) / 2);
    air_image_destroy(image);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- behind media ---- */

static void media_in_front_take_light_away(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_material_desc white = view_lambert(1.0f, 1.0f, 1.0f);
    view_add_square(scene, "square", view_add_material(scene, &white));
    view_add_haze(scene, 0.75f, 0.5f, 0.5f); /* 0.5 m of extinction 1.25, 1.75, 2.25 */
    view_add_camera(scene, 1.0f);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    air_lightmap *lightmap = view_lightmap(context, one_square, 1, even_page(context));
    const air_render_params params = view_params(lightmap);
    air_image *image = view_render(context, snapshot, &params);
    for (size_t c = 0; c < 3; c++) {
        const double passes = exp(-0.5 * (1.25 + 0.5 * (double)c));
        assert_near(view_value(image, direct_names[c], 3, 4), passes * (double)(1 + c) / AIR_PI);
        assert_near(view_value(image, further_names[c], 3, 4),
                    passes * (double)(11 + 2 * c) / AIR_PI);
    }
    air_image_destroy(image);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* A glowing white square of radiance 1 and irradiance pi behind smoke: ratio tracking must give
 * what is seen of both the same share, sample by sample. */
static void smoke_dims_baked_light_as_it_dims_emission(void **state)
{
    (void)state;
    const float values[8] = {0.5f, 3, 1, 0, 2, 0.25f, 1, 4};
    const air_grid_desc grid = {
        "puff", {2, 2, 2}, 1, values, {1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 0.4f, 0.1f}};
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc glow = view_lambert(1.0f, 1.0f, 1.0f);
    air_medium_desc medium;
    air_handle handle;
    glow.emission[0] = glow.emission[1] = glow.emission[2] = 1.0f;
    view_add_square(scene, "square", view_add_material(scene, &glow));
    air_medium_desc_default(&medium);
    medium.name = "smoke";
    medium.sigma_s[0] = medium.sigma_s[1] = medium.sigma_s[2] = 1.0f;
    medium.density.kind = AIR_DENSITY_GRID;
    assert_int_equal(air_scene_add_grid(scene, &grid, &medium.density.grid), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
    view_add_camera(scene, 1.0f);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    air_image *page = view_page(context, 2, 2, false);
    view_fill(page, VIEW_DIRECT, AIR_PI_F, AIR_PI_F, AIR_PI_F);
    air_lightmap *lightmap = view_lightmap(context, one_square, 1, page);
    air_render_params params = view_params(lightmap);
    params.terms = 1u << AIR_TERM_S0 | 1u << AIR_TERM_EMISSION;
    params.sample_end = 4;
    air_image *image = view_render(context, snapshot, &params);
    size_t between = 0;
    for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
        const double emission = view_value(image, "emission.G", i % VIEW_SIZE, i / VIEW_SIZE);
        assert_near(view_value(image, "S0.G", i % VIEW_SIZE, i / VIEW_SIZE), emission);
        between += emission > 0.05 && emission < 0.95;
    }
    assert_true(between > VIEW_SIZE * VIEW_SIZE / 2);
    air_image_destroy(image);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- everything else ---- */

static void add_lamp_and_sky(air_scene *scene)
{
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.name = "lamp";
    light.color[0] = light.color[1] = 1.0f;
    light.position[0] = 0.3f;
    light.position[2] = 0.4f;
    assert_int_equal(air_scene_add_light(scene, &light, &handle), AIR_OK);
    air_light_desc_default(&light);
    light.name = "sky";
    light.kind = AIR_LIGHT_ENVIRONMENT;
    light.color[0] = 0.5f;
    assert_int_equal(air_scene_add_light(scene, &light, &handle), AIR_OK);
}

/* Haze that a lamp and the sky light, a glowing square, an unlit one beside it and nothing beyond:
 * the media's terms, emission and background are the same bytes with and without. */
static void other_terms_do_not_know_of_it(void **state)
{
    (void)state;
    static const char *const names[] = {"square", "sign"};
    static const char *const terms[] = {"M1.R", "M2.R", "M2.G", "emission.R", "background.R"};
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc glow = view_lambert(0.5f, 0.5f, 0.5f), unlit = view_lambert(0.3f, 0.6f, 0.9f);
    glow.emission[0] = 2.0f;
    unlit.unlit = true;
    view_add_square(scene, "square", view_add_material(scene, &glow));
    air_mesh_desc sign = fixture_square("sign");
    air_handle handle;
    const float to_world[12] = {0.3f, 0, 0, 0.5f, 0, 0.3f, 0, 0.5f, 0, 0, 1, 0.2f};
    memcpy(sign.to_world, to_world, sizeof to_world);
    sign.material = view_add_material(scene, &unlit);
    assert_int_equal(air_scene_add_mesh(scene, &sign, &handle), AIR_OK);
    add_lamp_and_sky(scene);
    view_add_haze(scene, 0.5f, 0.1f, 0.8f);
    view_add_camera(scene, 1.0f);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    air_lightmap *lightmap = view_lightmap(context, names, 2, even_page(context));
    lightmap->meshes[1].page = -1;
    air_render_params params = view_params(NULL);
    params.filter_radius = 4.0f; /* some rays miss the square */
    params.filter = AIR_FILTER_BOX;
    params.sample_end = 16;
    air_image *without = view_render(context, snapshot, &params);
    params.lightmap = lightmap;
    air_image *with = view_render(context, snapshot, &params);
    for (size_t k = 0; k < sizeof terms / sizeof terms[0]; k++) {
        double sum = 0.0;
        for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
            const double value = view_value(with, terms[k], i % VIEW_SIZE, i / VIEW_SIZE);
            assert_true(value == view_value(without, terms[k], i % VIEW_SIZE, i / VIEW_SIZE));
            sum += value;
        }
        if (!(sum > 0.0)) {
            fail_msg("no %s", terms[k]);
        }
    }
    assert_true(view_value(with, "S0.R", 2, 2) != view_value(without, "S0.R", 2, 2));
    air_image_destroy(with);
    air_image_destroy(without);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void add_sun_and_panel(air_scene *scene)
{
    static const float panel[12] = {-0.5f, -0.5f, 0.7f, 0,     -0.5f, 0.7f,
                                    0,     0.5f,  0.7f, -0.5f, 0.5f,  0.7f};
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.name = "sun";
    light.kind = AIR_LIGHT_COLLIMATED;
    light.color[0] = 2.0f;
    light.dir[0] = 0.6f;
    light.dir[1] = 0.0f;
    light.dir[2] = -0.8f;
    assert_int_equal(air_scene_add_light(scene, &light, &handle), AIR_OK);
    air_light_desc_default(&light);
    light.name = "panel";
    light.kind = AIR_LIGHT_POLYGON;
    light.color[0] = 3.0f;
    light.vertices = panel;
    light.vertex_count = 4;
    light.one_sided = false;
    assert_int_equal(air_scene_add_light(scene, &light, &handle), AIR_OK);
}

/* Methods that own S0 and M1 of their lights keep M1 and leave S0 to the lightmap. */
static void other_methods_leave_surfaces_to_it(void **state)
{
    (void)state;
    static const char *const methods[] = {"collimated", "collimated:reds", "arealight"};
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_material_desc white = view_lambert(1.0f, 1.0f, 1.0f);
    view_add_square(scene, "square", view_add_material(scene, &white));
    add_sun_and_panel(scene);
    view_add_haze(scene, 0.75f, 0.5f, 0.5f);
    view_add_camera(scene, 1.0f);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    air_lightmap *lightmap = view_lightmap(context, one_square, 1, even_page(context));
    for (size_t k = 0; k < sizeof methods / sizeof methods[0]; k++) {
        air_render_params params = view_params(NULL);
        params.methods = methods[k];
        params.sample_end = 4;
        air_image *without = view_render(context, snapshot, &params);
        params.lightmap = lightmap;
        air_image *with = view_render(context, snapshot, &params);
        for (size_t i = 0; i < VIEW_SIZE * VIEW_SIZE; i++) {
            const size_t x = i % VIEW_SIZE, y = i / VIEW_SIZE;
            const double scattered = view_value(with, "M1.R", x, y);
            assert_true(scattered > 0.0 && scattered == view_value(without, "M1.R", x, y));
            assert_near(view_value(with, "S0.R", x, y), exp(-0.5 * 1.25) / AIR_PI);
        }
        air_image_destroy(with);
        air_image_destroy(without);
    }
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* A shiny white surface under even light of radiance 1 keeps what it gets. */
static void highlights_are_those_of_an_even_sky(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    for (int metal = 0; metal < 2; metal++) {
        air_material_desc material = view_lambert(1.0f, 1.0f, 1.0f);
        material.specular = 1.0f;
        material.metallic = (float)metal;
        material.roughness = 0.3f;
        air_snapshot *snapshot = square_scene(context, &material, 1.0f);
        air_image *page = view_page(context, 2, 2, false);
        view_fill(page, VIEW_DIRECT, AIR_PI_F, AIR_PI_F, AIR_PI_F);
        air_lightmap *lightmap = view_lightmap(context, one_square, 1, page);
        const air_render_params params = view_params(lightmap);
        air_image *image = view_render(context, snapshot, &params);
        /* the albedo tables' error, at most 0.005 and on the dark side */
        const double white = view_value(image, "S0.G", 2, 5);
        assert_true(white >= 0.995 && white <= 1.0 + ROUNDING);
        air_image_destroy(image);
        air_lightmap_destroy(lightmap);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(even_light_leaves_as_albedo_times_irradiance_over_pi),
        cmocka_unit_test(light_between_texels_is_bilinear),
        cmocka_unit_test(cut_meshes_are_looked_up_by_their_own_corners),
        cmocka_unit_test(media_in_front_take_light_away),
        cmocka_unit_test(smoke_dims_baked_light_as_it_dims_emission),
        cmocka_unit_test(other_terms_do_not_know_of_it),
        cmocka_unit_test(other_methods_leave_surfaces_to_it),
        cmocka_unit_test(highlights_are_those_of_an_even_sky),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

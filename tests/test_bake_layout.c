/* Meshes on pages: apart from each other, of the size asked for, in their own coordinates where
 * these serve. */
#include "bake/layout.h"
#include "bake_fixture.h"

static air_bake_layout *lay_out(const bake_host *host, const air_snapshot *snapshot,
                                const air_bake_params *params)
{
    air_bake_layout *layout = NULL;
    if (air_bake_layout_create(host->context, snapshot, params, &layout) != AIR_OK) {
        fail_msg("%s", air_context_last_error(host->context));
    }
    return layout;
}

/* First and last texel of a mesh's rectangle on its page. */
typedef struct rectangle {
    double x0, y0, x1, y1;
} rectangle;

static rectangle rectangle_of(const air_bake_layout *layout, size_t mesh)
{
    const air_lightmap_mesh *m = &layout->meshes[mesh];
    const double width = layout->pages[m->page].width, height = layout->pages[m->page].height;
    const double x = (double)m->offset[0] * width, y = (double)m->offset[1] * height;
    return (rectangle){x, y, x + (double)m->scale[0] * width, y + (double)m->scale[1] * height};
}

/* Rectangles lie on their pages, `padding` texels apart from each other, and no two triangles
 * overlap. Numbers of texels below 2^14 come back from floats within 2^-10. */
static void assert_apart(const bake_host *host, const air_bake_layout *layout, double padding)
{
    const double slack = 0x1p-9;
    for (size_t i = 0; i < layout->mesh_count; i++) {
        const rectangle a = rectangle_of(layout, i);
        const air_bake_page *page = &layout->pages[layout->meshes[i].page];
        assert_true(a.x0 >= -slack && a.y0 >= -slack);
        assert_true(a.x1 <= page->width + slack && a.y1 <= page->height + slack);
        for (size_t k = 0; k < i; k++) {
            const rectangle b = rectangle_of(layout, k);
            const double gap = fmax(fmax(a.x0 - b.x1, b.x0 - a.x1), fmax(a.y0 - b.y1, b.y0 - a.y1));
            if (layout->meshes[i].page == layout->meshes[k].page && !(gap >= padding - slack)) {
                fail_msg("meshes %zu and %zu are %g texels apart", k, i, gap);
            }
        }
    }
    /* with no padding neighbours may overlap by the rounding of their scales and offsets to floats
     */
    for (size_t p = 0; p < layout->page_count && padding > 0.0; p++) {
        air_coverage_overlap overlap;
        assert_int_equal(
            air_coverage_find_overlap(host->context, layout->pages[p].coverage, &overlap), AIR_OK);
        assert_int_equal(overlap.texel_count, 0);
    }
}

/* Quads of many sizes and shapes, every second one with coordinates of its own. */
static air_snapshot *many_quads(const bake_host *host, int count)
{
    air_scene *scene = bake_scene(host);
    air_rng rng = air_rng_from_keys(5, 6);
    for (int i = 0; i < count; i++) {
        const air_vec3 corner = vec3((float)i, air_rng_float(&rng), 0.0f);
        const air_vec3 u = vec3(0.1f + air_rng_float(&rng), 0.0f, air_rng_float(&rng));
        const air_vec3 v = vec3(0.0f, 0.1f + air_rng_float(&rng), 0.3f);
        bake_add_quad(scene, "quad", corner, u, v, i % 2 == 0 ? bake_unit_uv : NULL, AIR_NONE);
    }
    return path_freeze(scene);
}

static void meshes_lie_apart_on_few_and_on_many_pages(void **state)
{
    const uint32_t sizes[] = {1024, 96, 40};
    const uint32_t paddings[] = {0, 1, 4, 7};
    size_t pages[3] = {0};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = many_quads(&host, 60);
    for (int s = 0; s < 3; s++) {
        for (int k = 0; k < 4; k++) {
            air_bake_params params = bake_raw_params(1, 16.0f);
            params.page_size = sizes[s];
            params.padding = paddings[k];
            air_bake_layout *layout = lay_out(&host, snapshot, &params);
            assert_apart(&host, layout, paddings[k]);
            for (size_t p = 0; p < layout->page_count; p++) {
                assert_true(layout->pages[p].width <= sizes[s]);
                assert_true(layout->pages[p].height <= sizes[s]);
                assert_true(layout->pages[p].part_count > 0);
            }
            pages[s] = layout->page_count;
            air_bake_layout_destroy(layout);
        }
    }
    assert_int_equal(pages[0], 1);
    assert_true(pages[1] > 1 && pages[2] > pages[1]);
    assert_int_equal(host.warnings, 0);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void a_mesh_that_fills_a_page_has_neighbours_elsewhere(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    for (int own = 0; own < 2; own++) {
        air_scene *scene = bake_scene(&host);
        const float *uv = own ? bake_unit_uv : NULL;
        bake_add_quad(scene, "floor", vec3(0, 0, 0), vec3(9, 0, 0), vec3(0, 0, -9), uv, AIR_NONE);
        bake_add_quad(scene, "chair", vec3(0, 1, 0), vec3(1, 0, 0), vec3(0, 0, -1), uv, AIR_NONE);
        bake_add_quad(scene, "shelf", vec3(0, 2, 0), vec3(1, 0, 0), vec3(0, 0, -2), uv, AIR_NONE);
        air_snapshot *snapshot = path_freeze(scene);
        air_bake_params params = bake_raw_params(1, 8.0f);
        params.page_size = 64; /* the floor wants 72 */
        air_bake_layout *layout = lay_out(&host, snapshot, &params);
        assert_apart(&host, layout, params.padding);
        const rectangle floor = rectangle_of(layout, 0), chair = rectangle_of(layout, 1);
        /* it gets what there is, the others what they asked for */
        assert_true(floor.x1 - floor.x0 >= 64.0 - 2.0 * params.padding);
        assert_true(chair.x1 - chair.x0 >= 7.999);
        air_bake_layout_destroy(layout);
        air_snapshot_release(snapshot);
    }
    bake_close(&host);
}

/* Own coordinates of the whole unit square: as many texels as the surface needs, rounded up. Cut
 * ones: chart by chart. */
static void sizes_follow_the_density_or_the_size_asked_for(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    bake_add_quad(scene, "own", vec3(0, 0, 0), vec3(2, 0, 0), vec3(0, 0, -1), bake_unit_uv,
                  AIR_NONE);
    bake_add_quad(scene, "cut", vec3(0, 2, 0), vec3(2, 0, 0), vec3(0, 0, -1), NULL, AIR_NONE);
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(1, 16.0f);
    air_bake_layout *layout = lay_out(&host, snapshot, &params);
    const double side = ceil(16.0 * sqrt(2.0));
    rectangle own = rectangle_of(layout, 0), cut = rectangle_of(layout, 1);
    bake_assert_near("width", own.x1 - own.x0, side, 1e-3);
    bake_assert_near("height", own.y1 - own.y0, side, 1e-3);
    /* one chart of 32 x 16 texels, of which half a texel on each side may be rim, and padding */
    const double longer = fmax(cut.x1 - cut.x0, cut.y1 - cut.y0);
    const double shorter = fmin(cut.x1 - cut.x0, cut.y1 - cut.y0);
    assert_true(longer >= 32.0 - 1e-3 && longer <= 34.0 + params.padding);
    assert_true(shorter >= 16.0 - 1e-3 && shorter <= 18.0 + params.padding);
    double area = 0.0;
    for (uint32_t y = 0; y < layout->pages[0].height; y++) {
        for (uint32_t x = 0; x < layout->pages[0].width; x++) {
            area += (double)air_coverage_area(layout->pages[0].coverage, x, y);
        }
    }
    /* areas are exact but for the rounding of uv to floats, 2^-24 of 64 texels along 100 of them */
    bake_assert_near("covered", area, side * side + 32.0 * 16.0, 1e-2);
    air_bake_layout_destroy(layout);

    params.mesh_size = 12;
    layout = lay_out(&host, snapshot, &params);
    own = rectangle_of(layout, 0);
    bake_assert_near("width", own.x1 - own.x0, 12.0, 1e-3);
    bake_assert_near("height", own.y1 - own.y0, 12.0, 1e-3);
    air_bake_layout_destroy(layout);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void own_coordinates_are_kept_and_the_others_are_cut(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = many_quads(&host, 4);
    air_bake_params params = bake_raw_params(1, 16.0f);
    for (int uv = AIR_BAKE_UV_AUTO; uv <= AIR_BAKE_UV_UNWRAP; uv += AIR_BAKE_UV_UNWRAP) {
        params.uv = (air_bake_uv)uv;
        air_bake_layout *layout = lay_out(&host, snapshot, &params);
        for (size_t i = 0; i < 4; i++) {
            const air_lightmap_mesh *mesh = &layout->meshes[i];
            const bool cut = uv == AIR_BAKE_UV_UNWRAP || i % 2 == 1;
            assert_int_equal(mesh->sources != NULL, cut);
            assert_int_equal(mesh->mesh, i);
            assert_string_equal(mesh->name, "quad");
            for (size_t v = 0; v < mesh->vertex_count; v++) {
                assert_true(mesh->sources[v] < 4);
                assert_true(mesh->uv[2 * v] >= 0.0f && mesh->uv[2 * v] <= 1.0f);
                assert_true(mesh->uv[2 * v + 1] >= 0.0f && mesh->uv[2 * v + 1] <= 1.0f);
            }
            for (size_t k = 0; k < 3 * mesh->triangle_count; k++) {
                /* the same triangles in the same order */
                assert_int_equal(mesh->sources[mesh->indices[k]], snapshot->meshes[i]->indices[k]);
            }
        }
        air_bake_layout_destroy(layout);
    }
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* A quad whose TEXCOORD_1 are these. */
static air_snapshot *one_quad(const bake_host *host, const float *uv)
{
    air_scene *scene = bake_scene(host);
    bake_add_quad(scene, "table", vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 0, -1), uv, AIR_NONE);
    return path_freeze(scene);
}

static void coordinates_that_do_not_serve_are_named(void **state)
{
    static const struct {
        float uv[8];
        const char *says;
    } cases[] = {
        /* both triangles on the same half of the square */
        {{0, 0, 1, 0, 1, 1, 1, 0}, "overlap in"},
        {{0, 0, 1.5f, 0, 1.5f, 1, 0, 1},
         "2 triangles lie outside [0, 1], first triangle 0 at (1.5"},
        {{0, 0, 0, 0, 0, 0, 0, 0}, "no triangle has an area in TEXCOORD_1"},
    };
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_bake_params params = bake_raw_params(1, 16.0f);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        air_snapshot *snapshot = one_quad(&host, cases[i].uv);
        air_bake_layout *layout = NULL;
        params.uv = AIR_BAKE_UV_FILE;
        assert_int_equal(air_bake_layout_create(host.context, snapshot, &params, &layout),
                         AIR_ERROR_ARGUMENT);
        assert_null(layout);
        bake_expect(&host, "mesh 0 \"table\": ");
        bake_expect(&host, cases[i].says);
        if (i == 0) {
            bake_expect(&host, "texels of 16 x 16, first texel (0, 0), triangles 0 and 1");
        }
        params.uv = AIR_BAKE_UV_AUTO;
        const int before = host.warnings;
        layout = lay_out(&host, snapshot, &params);
        assert_int_equal(host.warnings, before + 1);
        bake_expect_warning(&host, cases[i].says);
        bake_expect_warning(&host, "it is unwrapped instead");
        assert_non_null(layout->meshes[0].sources);
        assert_apart(&host, layout, 0.0);
        air_bake_layout_destroy(layout);
        air_snapshot_release(snapshot);
    }
    air_snapshot *snapshot = one_quad(&host, NULL);
    air_bake_layout *layout = NULL;
    params.uv = AIR_BAKE_UV_FILE;
    assert_int_equal(air_bake_layout_create(host.context, snapshot, &params, &layout),
                     AIR_ERROR_ARGUMENT);
    bake_expect(&host, "mesh 0 \"table\": it has no TEXCOORD_1");
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* Two squares whose coordinates share a strip of a thirtieth. */
static void a_small_overlap_is_said_and_kept(void **state)
{
    static const float positions[24] = {0, 0, 0, 1, 0, 0, 1, 0, -1, 0, 0, -1,
                                        2, 0, 0, 3, 0, 0, 3, 0, -1, 2, 0, -1};
    static const float uv[16] = {0, 0, 0.52f, 0, 0.52f, 1, 0, 1, 0.50f, 0, 1, 0, 1, 1, 0.50f, 1};
    static const uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    bake_host host;
    air_mesh_desc mesh;
    air_handle handle;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    air_mesh_desc_default(&mesh);
    mesh.name = "pair";
    mesh.positions = positions;
    mesh.uv[1] = uv;
    mesh.vertex_count = 8;
    mesh.indices = indices;
    mesh.triangle_count = 4;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    air_snapshot *snapshot = path_freeze(scene);
    const air_bake_params params = bake_raw_params(1, 32.0f);
    air_bake_layout *layout = lay_out(&host, snapshot, &params);
    assert_int_equal(host.warnings, 1);
    bake_expect_warning(&host, "mesh \"pair\": TEXCOORD_1 overlap in");
    assert_null(layout->meshes[0].sources);
    air_bake_layout_destroy(layout);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void meshes_without_light_of_their_own_take_no_texels(void **state)
{
    bake_host host;
    air_material_desc material;
    air_handle unlit;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    air_material_desc_default(&material);
    material.unlit = true;
    assert_int_equal(air_scene_add_material(scene, &material, &unlit), AIR_OK);
    bake_add_quad(scene, "sign", vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 0, -1), NULL, unlit);
    bake_add_quad(scene, "table", vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 0, -1), bake_unit_uv,
                  AIR_NONE);
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(1, 16.0f);
    params.uv = AIR_BAKE_UV_FILE; /* the sign has none, and needs none */
    air_bake_layout *layout = lay_out(&host, snapshot, &params);
    assert_int_equal(layout->meshes[0].page, -1);
    assert_int_equal(layout->meshes[1].page, 0);
    assert_int_equal(layout->page_count, 1);
    assert_int_equal(layout->pages[0].part_count, 1);
    assert_int_equal(layout->pages[0].part_meshes[0], 1);
    air_bake_layout_destroy(layout);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void scenes_with_little_in_them_are_laid_out(void **state)
{
    static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 0, -1}, line[9] = {0, 0, 0, 1, 0, 0, 2};
    static const float some[15] = {0, 0, 0, 1, 0, 0, 0, 0, -1, 2, 0, 0, 3, 0, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 1, 3};
    const struct {
        const float *positions;
        size_t vertex_count, triangle_count;
        bool texels;
    } cases[] = {{triangle, 3, 1, true}, {line, 3, 1, false}, {some, 5, 2, true}};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    const air_bake_params params = bake_raw_params(4, 16.0f);
    for (size_t i = 0; i < 3; i++) {
        air_scene *scene = bake_scene(&host);
        air_mesh_desc mesh;
        air_handle handle;
        air_mesh_desc_default(&mesh);
        mesh.positions = cases[i].positions;
        mesh.vertex_count = cases[i].vertex_count;
        mesh.indices = indices;
        mesh.triangle_count = cases[i].triangle_count;
        assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
        add_environment(scene, 1.0f, 1.0f, 1.0f);
        air_snapshot *snapshot = path_freeze(scene);
        air_lightmap *lightmap = bake_well(&host, snapshot, &params);
        float most = 0.0f;
        for (size_t p = 0; p < lightmap->page_count; p++) {
            const float *area = bake_plane(lightmap->pages[p], "coverage.Y");
            for (size_t t = 0;
                 t < air_image_width(lightmap->pages[p]) * air_image_height(lightmap->pages[p]);
                 t++) {
                most = fmaxf(most, area[t]);
            }
        }
        assert_int_equal(most > 0.0f, cases[i].texels);
        air_lightmap_destroy(lightmap);
        air_snapshot_release(snapshot);
    }
    bake_close(&host);
}

static void a_scene_without_meshes_has_no_pages(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    air_snapshot *snapshot = path_freeze(scene);
    for (int media = 0; media < AIR_BAKE_MEDIA_COUNT; media++) {
        air_bake_params params;
        air_bake_params_default(&params);
        params.media = (air_bake_media)media;
        params.vertices = true;
        air_lightmap *lightmap = bake_well(&host, snapshot, &params);
        assert_int_equal(lightmap->page_count, 0);
        assert_int_equal(lightmap->vertex_light_count, 0);
        air_lightmap_destroy(lightmap);
    }
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void a_chart_too_large_for_a_page_shrinks_with_a_warning(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    bake_add_quad(scene, "plain", vec3(0, 0, 0), vec3(99, 0, 0), vec3(0, 0, -99), NULL, AIR_NONE);
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(1, 16.0f);
    params.page_size = 32;
    air_bake_layout *layout = lay_out(&host, snapshot, &params);
    assert_int_equal(host.warnings, 1);
    bake_expect_warning(&host, "mesh \"plain\" does not fit a page of 32 texels");
    assert_apart(&host, layout, 0.0);
    air_bake_layout_destroy(layout);
    /* with no room between the paddings the option is named */
    params.page_size = 16;
    params.padding = 64;
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_bake(host.context, snapshot, &params, &lightmap, NULL),
                     AIR_ERROR_ARGUMENT);
    bake_expect(&host, "padding is 64");
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void a_thousand_meshes_lie_apart(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = many_quads(&host, 1000);
    air_bake_params params = bake_raw_params(1, 8.0f);
    params.page_size = 256;
    air_bake_layout *layout = lay_out(&host, snapshot, &params);
    assert_apart(&host, layout, params.padding);
    air_bake_layout_destroy(layout);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_lie_apart_on_few_and_on_many_pages),
        cmocka_unit_test(a_mesh_that_fills_a_page_has_neighbours_elsewhere),
        cmocka_unit_test(sizes_follow_the_density_or_the_size_asked_for),
        cmocka_unit_test(own_coordinates_are_kept_and_the_others_are_cut),
        cmocka_unit_test(coordinates_that_do_not_serve_are_named),
        cmocka_unit_test(a_small_overlap_is_said_and_kept),
        cmocka_unit_test(meshes_without_light_of_their_own_take_no_texels),
        cmocka_unit_test(scenes_with_little_in_them_are_laid_out),
        cmocka_unit_test(a_scene_without_meshes_has_no_pages),
        cmocka_unit_test(a_chart_too_large_for_a_page_shrinks_with_a_warning),
        cmocka_unit_test(a_thousand_meshes_lie_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

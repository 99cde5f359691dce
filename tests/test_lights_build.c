#include "cmocka_test.h"
#include "core/random.h"
#include "core/warp.h"
#include "failing_allocator.h"
#include "light_fixture.h"

/* ---- meshes that emit ---- */

enum { MESHES = 3 };

/* Four triangles: a unit right angle in z = 0, one without area, one twice as large, one far off.
 */
static float POSITIONS[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 2, 2, 0,
                            0, 5, 2, 0, 5, 0, 2, 5, 3, 3, 3, 0};
static uint32_t INDICES[] = {0, 1, 2, 0, 1, 1, 4, 5, 6, 3, 7, 3};
static float UV[] = {0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};

typedef struct emissive_scene {
    air_mesh meshes[MESHES];
    const air_mesh *pointers[MESHES];
    air_material materials[2];
    uint32_t first[MESHES];
    uint8_t texels[2 * 3];
    air_texture texture;
} emissive_scene;

static void make_emissive(emissive_scene *s)
{
    memset(s, 0, sizeof *s);
    s->materials[1].emission = vec3(2.0f, 4.0f, 6.0f);
    for (int i = 0; i < MESHES; i++) {
        s->meshes[i] = (air_mesh){.positions = POSITIONS,
                                  .uv = {UV, NULL},
                                  .vertex_count = 8,
                                  .indices = INDICES,
                                  .triangle_count = 4,
                                  .material = i == 1 ? 0 : 1,
                                  .mask = AIR_MASK_CAMERA};
        s->pointers[i] = &s->meshes[i];
    }
    s->meshes[2].triangle_count = 1;
    s->meshes[2].flip = true;
}

static air_light_table emissive_table(air_context *context, emissive_scene *s,
                                      const air_light_source *sources, size_t count)
{
    const float low[3] = {0.0f, 0.0f, 0.0f}, high[3] = {3.0f, 3.0f, 5.0f};
    air_light_table table;
    assert_int_equal(air_light_table_build(context, sources, count, s->pointers, MESHES,
                                           s->materials, low, high, &table, s->first),
                     AIR_OK);
    return table;
}

static void emissive_triangles_follow_the_explicit_lights(void **state)
{
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.color[0] = 1.0f;
    const air_light_source source = {&desc, NULL};
    emissive_scene s;
    make_emissive(&s);
    air_light_table table = emissive_table(*state, &s, &source, 1);
    assert_int_equal(table.explicit_count, 1);
    assert_int_equal(table.count, 1 + 4 + 1);
    assert_int_equal(table.owner_count, 2);
    assert_int_equal(s.first[0], 1);
    assert_int_equal(s.first[1], UINT32_MAX);
    assert_int_equal(s.first[2], 5);
    for (uint32_t i = 1; i < 6; i++) {
        assert_int_equal(table.entries[i].owner, 1);
        assert_int_equal(table.entries[i].vertex_count, 3);
    }
    assert_true(table.entries[1].normal.z == 1.0f && table.entries[5].normal.z == -1.0f);
    assert_true(table.entries[1].one_sided && table.entries[1].camera_visible);
    air_light_table_finish(*state, &table);
}

static void triangles_are_picked_by_power(void **state)
{
    emissive_scene s;
    make_emissive(&s);
    air_light_table table = emissive_table(*state, &s, NULL, 0);
    const float small = air_light_pick_probability(&table, 0);
    assert_true(air_light_pick_probability(&table, 1) == 0.0f); /* no area */
    assert_true(air_light_pick_probability(&table, 3) == 0.0f);
    assert_true(fabsf(air_light_pick_probability(&table, 2) - 4.0f * small) < 1e-6f);
    assert_true(fabsf(air_light_pick_probability(&table, 4) - small) < 1e-6f);
    air_light_table_finish(*state, &table);
}

static void textured_emission_weighs_and_shines_by_its_texels(void **state)
{
    emissive_scene s;
    make_emissive(&s);
    s.texels[3] = s.texels[4] = s.texels[5] = 255; /* left black, right white */
    s.texture = (air_texture){.width = 2,
                              .height = 1,
                              .channels = 3,
                              .bytes = s.texels,
                              .wrap_u = AIR_WRAP_CLAMP,
                              .wrap_v = AIR_WRAP_CLAMP,
                              .filter = AIR_TEXTURE_NEAREST};
    s.materials[1].emission_slot =
        (air_texture_slot){.texture = &s.texture, .uv_transform = {1, 0, 0, 0, 1, 0}};
    air_light_table table = emissive_table(*state, &s, NULL, 0);
    /* the third triangle has uv (0,0) throughout: black */
    assert_true(air_light_pick_probability(&table, 2) == 0.0f);
    air_rng rng = air_rng_from_keys(1, 1);
    double sum = 0.0;
    enum { SAMPLES = 20000 };
    for (int i = 0; i < SAMPLES; i++) {
        air_light_point point;
        const float u1 = air_rng_float(&rng);
        air_light_sample(&table, 0, u1, air_rng_float(&rng), &point);
        assert_true(point.value.y == (point.position.x >= 0.5f ? 4.0f : 0.0f) ||
                    fabsf(point.position.x - 0.5f) < 1e-6f);
        assert_true(point.pdf == 2.0f);
        sum += (double)point.value.y / 4.0;
    }
    /* a quarter of the triangle lies at x > 1/2; 5 standard deviations */
    assert_true(fabs(sum / SAMPLES - 0.25) < 5.0 * sqrt(0.25 * 0.75 / SAMPLES));
    air_light_table_finish(*state, &table);
}

static void a_large_emissive_mesh_is_picked_evenly(void **state)
{
    enum { TRIANGLES = 100000 };
    float *positions = calloc(9 * TRIANGLES + 1, sizeof *positions);
    uint32_t *indices = calloc(3 * TRIANGLES, sizeof *indices);
    assert_true(positions != NULL && indices != NULL);
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++) {
        indices[i] = i;
        positions[3 * i + i % 3] = 1.0f;
    }
    emissive_scene s;
    make_emissive(&s);
    s.meshes[0] = (air_mesh){.positions = positions,
                             .vertex_count = 3 * TRIANGLES,
                             .indices = indices,
                             .triangle_count = TRIANGLES,
                             .material = 1};
    s.pointers[0] = &s.meshes[0];
    s.pointers[2] = &s.meshes[1];
    air_light_table table = emissive_table(*state, &s, NULL, 0);
    assert_int_equal(table.count, TRIANGLES);
    double sum = 0.0;
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        const float probability = air_light_pick_probability(&table, i);
        /* rounding of the cumulative sums near 1 */
        assert_true(fabsf(probability - 1.0f / TRIANGLES) <= 0x1p-23f);
        sum += (double)probability;
    }
    assert_true(fabs(sum - 1.0) < 1e-9); /* differences of floats telescope exactly */
    air_light_table_finish(*state, &table);
    free(indices);
    free(positions);
}

/* ---- explicit lights ---- */

static const float SHEET[12] = {0, 0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1}; /* x = 0, facing +X */
static const float ARROW[12] = {3, 0, 0, 3, 2,    1,
                                3, 0, 2, 3, 0.5f, 1}; /* x = 3, concave, facing +X */
static const float HIDDEN[9] = {1, 0, 0, 1, 2, 0, 1, 2, 1};
static const float PANE[9] = {0, 0, 0, 1, 0, 0, 0, 0, 1};
static const air_gobo_window WINDOWS[1] = {{PANE, 3}};

enum { LIGHTS = 6 };

static void describe(air_light_desc *descs, air_light_source *sources, const air_texture *image)
{
    const float *vertices[LIGHTS] = {NULL, SHEET, HIDDEN, NULL, ARROW, NULL};
    for (int i = 0; i < LIGHTS; i++) {
        air_light_desc_default(&descs[i]);
        descs[i].color[0] = descs[i].color[1] = descs[i].color[2] = 1.0f;
        if (vertices[i] != NULL) {
            descs[i].kind = AIR_LIGHT_POLYGON;
            descs[i].vertices = vertices[i];
            descs[i].vertex_count = i == 2 ? 3 : 4;
        }
        sources[i] = (air_light_source){&descs[i], NULL};
    }
    descs[0].kind = AIR_LIGHT_COLLIMATED;
    descs[0].windows = WINDOWS;
    descs[0].window_count = 1;
    descs[2].camera_visible = false;
    descs[3].kind = AIR_LIGHT_ENVIRONMENT;
    descs[5].kind = AIR_LIGHT_ENVIRONMENT;
    sources[5].image = image;
}

static const uint8_t GREY_TEXELS[2] = {255, 128};

static air_texture grey_image(void)
{
    return (air_texture){
        .width = 2, .height = 1, .channels = 1, .bytes = (uint8_t *)(uintptr_t)GREY_TEXELS};
}

static void environments_and_visible_polygons_are_listed(void **state)
{
    air_light_desc descs[LIGHTS];
    air_light_source sources[LIGHTS];
    const air_texture image = grey_image();
    describe(descs, sources, &image);
    air_light_table table = table_of(*state, sources, LIGHTS);
    assert_int_equal(table.environment_count, 2);
    assert_int_equal(table.environments[0], 3);
    assert_int_equal(table.environments[1], 5);
    assert_true(fabsf(table.scene_radius - 1.0f) < 1e-6f);

    const air_ray_backend *rays = air_context_ray_backend(*state);
    assert_non_null(table.visible_accelerator);
    const air_ray across = {{5.0f, 0.6f, 0.5f}, 0.0f, {-1.0f, 0.0f, 0.0f}, INFINITY, UINT32_MAX};
    air_hit hits[4];
    const size_t count = rays->intersect_all(table.visible_accelerator, &across, hits, 4);
    assert_int_equal(count, 2);
    const uint32_t entry[2] = {table.visible_entries[hits[0].mesh],
                               table.visible_entries[hits[1].mesh]};
    assert_int_equal(entry[0], 4);
    assert_int_equal(entry[1], 1);
    for (int i = 0; i < 2; i++) {
        const air_vec3 radiance =
            air_polygon_radiance(&table.entries[entry[i]], vec3_load(across.dir));
        assert_true(radiance.x == (table.entries[entry[i]].normal.x > 0.0f ? 1.0f : 0.0f));
    }
    /* through the notch of the arrow */
    const air_ray notch = {{5.0f, 0.2f, 1.0f}, 0.0f, {-1.0f, 0.0f, 0.0f}, 2.5f, UINT32_MAX};
    assert_int_equal(rays->intersect_all(table.visible_accelerator, &notch, hits, 4), 0);
    air_light_table_finish(*state, &table);
}

static void an_empty_table_is_legal(void **state)
{
    const float low[3] = {1.0f, 1.0f, 1.0f}, high[3] = {-1.0f, -1.0f, -1.0f};
    air_light_table table;
    assert_int_equal(air_light_table_build(*state, NULL, 0, NULL, 0, NULL, low, high, &table, NULL),
                     AIR_OK);
    assert_int_equal(table.count, 0);
    assert_true(table.scene_radius > 0.0f && table.visible_accelerator == NULL);
    air_light_table_finish(*state, &table);
    air_light_table_finish(*state, &table); /* all zero */
}

static void running_out_of_memory_leaks_nothing(void **state)
{
    (void)state;
    const air_texture image = grey_image();
    const float low[3] = {0.0f, 0.0f, 0.0f}, high[3] = {1.0f, 1.0f, 1.0f};
    for (long allowed = 0;; allowed++) {
        failing_allocator allocator;
        air_context_params params = failing_params(&allocator, 1000);
        params.thread_count = 1;
        air_context *context = NULL;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        air_light_desc descs[LIGHTS];
        air_light_source sources[LIGHTS];
        describe(descs, sources, &image);
        emissive_scene s;
        make_emissive(&s);
        air_light_table table;
        const long live = atomic_load(&allocator.live);
        atomic_store(&allocator.remaining, allowed);
        const air_status status = air_light_table_build(
            context, sources, LIGHTS, s.pointers, MESHES, s.materials, low, high, &table, s.first);
        atomic_store(&allocator.remaining, 1000);
        if (status == AIR_OK) {
            air_light_table_finish(context, &table);
        } else {
            assert_int_equal(status, AIR_ERROR_MEMORY);
            assert_int_equal(s.first[0], 0);
        }
        /* the message of this thread may be kept */
        assert_true(atomic_load(&allocator.live) <= live + 1);
        air_context_destroy(context);
        assert_int_equal(atomic_load(&allocator.live), 0);
        if (status == AIR_OK) {
            assert_true(allowed > 10);
            break;
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(emissive_triangles_follow_the_explicit_lights),
        cmocka_unit_test(triangles_are_picked_by_power),
        cmocka_unit_test(textured_emission_weighs_and_shines_by_its_texels),
        cmocka_unit_test(a_large_emissive_mesh_is_picked_evenly),
        cmocka_unit_test(environments_and_visible_polygons_are_listed),
        cmocka_unit_test(an_empty_table_is_legal),
        cmocka_unit_test(running_out_of_memory_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}

/* Copies of glTF scenes that show their lightmap: what becomes of meshes and materials. */
#include "lightmap_gltf_scene.h"
#include "scene/texture.h"

static const float pi = 3.14159265f;
/* A channel of 8 bits in sRGB is off by half a step; at its brightest the decoded value changes
 * by 2.4 / 1.055 per unit of the encoded one. Of the page's largest value: */
static const float png_error = 0.5f / 255.0f * 2.4f / 1.055f * 1.001f;

/* ---- what meshes become ---- */

static void own_coordinates_move_to_their_place_on_the_page(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.glb", NULL);
    scene_loaded copy = scene_load(self, "lit.glb");
    const air_mesh *left = scene_find_mesh(&copy, "left");
    assert_int_equal(left->vertex_count, 4);
    assert_int_equal(left->triangle_count, 2);
    for (size_t i = 0; i < 8; i++) {
        const float own = (float)scene_uv1[i] / 65535.0f;
        const float want = i % 2 == 0 ? own * 0.5f + 0.25f : own * 0.25f + 0.5f;
        assert_true(left->uv[1][i] == want);
    }
    assert_memory_equal(left->positions, scene_corners, sizeof scene_corners);
    scene_unload(&copy);
    air_lightmap_destroy(lightmap);
}

/* Interleaved, normalised and sparse: every vertex keeps what its source had. */
static void cut_meshes_gather_every_attribute(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.glb", NULL);
    scene_loaded copy = scene_load(self, "lit.glb"), source = scene_load(self, "room.gltf");
    const air_mesh *right = scene_find_mesh(&copy, "right"),
                   *old = scene_find_mesh(&source, "right");
    assert_int_equal(right->vertex_count, 6);
    assert_int_equal(right->triangle_count, 2);
    for (size_t i = 0; i < 6; i++) {
        const size_t from = scene_cut_sources[i];
        assert_memory_equal(right->positions + 3 * i, old->positions + 3 * from, 12);
        assert_memory_equal(right->normals + 3 * i, old->normals + 3 * from, 12);
        assert_memory_equal(right->uv[0] + 2 * i, old->uv[0] + 2 * from, 8);
        assert_memory_equal(right->colors + 4 * i, old->colors + 4 * from, 16);
        assert_memory_equal(right->uv[1] + 2 * i, scene_cut_uv + 2 * i, 8);
        assert_int_equal(right->indices[i], i);
    }
    scene_unload(&source);
    scene_unload(&copy);
    air_lightmap_destroy(lightmap);
}

/* Numbers of an accessor whose view lies in the file's one buffer. */
static const uint8_t *accessor_bytes(json_t *root, const uint8_t *binary, size_t accessor,
                                     size_t *out_stride)
{
    json_t *json = scene_item(root, "accessors", accessor);
    json_t *view = scene_item(root, "bufferViews",
                              (size_t)json_integer_value(json_object_get(json, "bufferView")));
    *out_stride = (size_t)json_integer_value(json_object_get(view, "byteStride"));
    assert_int_equal(json_integer_value(json_object_get(view, "buffer")), 0);
    assert_null(json_object_get(json, "byteOffset"));
    return binary + json_integer_value(json_object_get(view, "byteOffset"));
}

/* What the importer does not look at: skinning, morph targets, bounds, layout. */
static void morph_targets_and_skinning_are_cut_as_well(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.gltf", NULL);
    json_t *root = scene_read_json(self, "lit.gltf");
    const size_t mesh =
        (size_t)json_integer_value(json_object_get(scene_item(root, "nodes", 1), "mesh"));
    json_t *primitive =
        json_array_get(json_object_get(scene_item(root, "meshes", mesh), "primitives"), 0);
    json_t *attributes = json_object_get(primitive, "attributes");
    json_t *target = json_array_get(json_object_get(primitive, "targets"), 0);
    size_t size, stride;
    char *binary = lightmap_read(self, "lit.bin", &size);
    const uint8_t *bytes = (const uint8_t *)binary;

    const size_t joints = (size_t)json_integer_value(json_object_get(attributes, "JOINTS_0"));
    const uint8_t *joint = accessor_bytes(root, bytes, joints, &stride);
    const size_t weights = (size_t)json_integer_value(json_object_get(attributes, "WEIGHTS_0"));
    const uint8_t *weight = accessor_bytes(root, bytes, weights, &stride);
    const size_t morphs = (size_t)json_integer_value(json_object_get(target, "POSITION"));
    const uint8_t *morph = accessor_bytes(root, bytes, morphs, &stride);
    for (size_t i = 0; i < 6; i++) {
        float z;
        memcpy(&z, morph + 12 * i + 8, 4);
        assert_true(z == (float)scene_cut_sources[i]);
        for (size_t k = 0; k < 4; k++) {
            assert_int_equal(joint[4 * i + k], 4 * scene_cut_sources[i] + k);
            assert_int_equal(weight[4 * i + k], 16 * (4 * scene_cut_sources[i] + k));
        }
    }
    assert_true(
        json_is_true(json_object_get(scene_item(root, "accessors", weights), "normalized")));
    assert_null(json_object_get(scene_item(root, "accessors", joints), "normalized"));
    /* Three bytes of colour lie four bytes apart. */
    const size_t colors = (size_t)json_integer_value(json_object_get(attributes, "COLOR_0"));
    (void)accessor_bytes(root, bytes, colors, &stride);
    assert_int_equal(stride, 4);
    const size_t corners = (size_t)json_integer_value(json_object_get(attributes, "POSITION"));
    json_t *accessor = scene_item(root, "accessors", corners);
    assert_string_equal(json_string_value(json_object_get(accessor, "name")), "corners");
    assert_true(json_number_value(json_array_get(json_object_get(accessor, "max"), 1)) == 1.0);
    free(binary);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

static void nodes_that_share_a_mesh_get_their_own(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.glb", NULL);
    json_t *root = scene_read_json(self, "lit.glb");
    const json_int_t left =
        json_integer_value(json_object_get(scene_item(root, "nodes", 0), "mesh"));
    const json_int_t right =
        json_integer_value(json_object_get(scene_item(root, "nodes", 1), "mesh"));
    assert_int_equal(json_array_size(json_object_get(root, "meshes")), 3);
    assert_true(left != right);
    assert_string_equal(
        json_string_value(json_object_get(scene_item(root, "meshes", (size_t)left), "name")),
        "quad");
    assert_string_equal(
        json_string_value(json_object_get(scene_item(root, "meshes", (size_t)right), "name")),
        "quad");
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

static void what_is_not_lit_is_kept_as_it_is(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.glb", NULL);
    json_t *root = scene_read_json(self, "lit.glb"), *source = scene_read_json(self, "room.gltf");
    assert_true(json_equal(json_object_get(scene_item(root, "nodes", 0), "extras"),
                           json_object_get(scene_item(source, "nodes", 0), "extras")));
    assert_true(json_is_object(json_object_get(scene_item(root, "nodes", 1), "nobodyKnows")));
    assert_true(json_equal(scene_item(root, "nodes", 2), scene_item(source, "nodes", 2)));
    assert_true(json_equal(scene_item(root, "nodes", 3), scene_item(source, "nodes", 3)));
    assert_true(
        json_equal(scene_item(root, "meshes", 1), scene_item(source, "meshes", 1))); /* it emits */
    assert_true(json_equal(scene_item(root, "materials", 0), scene_item(source, "materials", 0)));
    assert_true(
        json_equal(json_object_get(root, "extensions"), json_object_get(source, "extensions")));
    json_decref(source);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

/* A texture of the material's own in TEXCOORD_1 keeps its coordinates, in another set. */
static void a_set_that_is_in_use_makes_room(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "\"metallicFactor\":0}",
                "\"metallicFactor\":0},\"occlusionTexture\":{\"index\":9,\"texCoord\":1}");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.glb", NULL);
    json_t *root = scene_read_json(self, "lit.glb"), *source = scene_read_json(self, "room.gltf");
    for (size_t node = 0; node < 2; node++) {
        const size_t mesh =
            (size_t)json_integer_value(json_object_get(scene_item(root, "nodes", node), "mesh"));
        json_t *primitive =
            json_array_get(json_object_get(scene_item(root, "meshes", mesh), "primitives"), 0);
        json_t *attributes = json_object_get(primitive, "attributes");
        json_t *material = scene_item(
            root, "materials", (size_t)json_integer_value(json_object_get(primitive, "material")));
        json_t *occlusion = json_object_get(material, "occlusionTexture");
        json_t *emission = json_object_get(material, "emissiveTexture");
        assert_int_equal(json_integer_value(json_object_get(occlusion, "texCoord")), 2);
        assert_int_equal(json_integer_value(json_object_get(emission, "texCoord")), 1);
        assert_non_null(json_object_get(attributes, "TEXCOORD_2"));
        if (node == 0) {
            assert_int_equal(json_integer_value(json_object_get(attributes, "TEXCOORD_2")), 4);
        }
    }
    assert_true(json_equal(scene_item(root, "materials", 0), scene_item(source, "materials", 0)));
    json_decref(source);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

/* ---- what is shown ---- */

/* Light that rises from 1/2 to 1, covered everywhere. */
static void image_like_wall(air_image *page)
{
    const size_t count = air_image_width(page) * air_image_height(page);
    for (size_t c = 0; c < 13; c++) {
        for (size_t i = 0; i < count; i++) {
            air_image_plane(page, c)[i] =
                c == 12 ? 1.0f : 0.5f + 0.5f * (float)i / (float)(count - 1);
        }
    }
}

/* Emission at every texel of a mesh's page against irradiance / pi times tint (or the page's
 * albedo). */
static void check_emission(const scene_loaded *copy, const char *name, const air_image *page,
                           const float tint[3], bool albedo, float scale)
{
    const air_material *material =
        &copy->snapshot->materials[scene_find_mesh(copy, name)->material];
    const size_t width = air_image_width(page), height = air_image_height(page);
    const float *values[3], *albedos[3];
    float peak = 0.0f;
    for (size_t c = 0; c < 3; c++) {
        values[c] = air_image_plane_const(page, c);
        albedos[c] = albedo ? air_image_plane_const(page, LIGHTMAP_PAGE_CHANNELS + c) : NULL;
        for (size_t i = 0; i < width * height; i++) {
            peak = fmaxf(peak, values[c][i] * (albedo ? albedos[c][i] : 1.0f) / pi * scale);
        }
    }
    assert_true(vec3_is_zero(material->base_color));
    assert_non_null(material->emission_slot.texture);
    assert_int_equal(material->emission_slot.uv_set, 1);
    const float factor[3] = {material->emission.x, material->emission.y, material->emission.z};
    for (size_t i = 0; i < width * height; i++) {
        const float u = ((float)(i % width) + 0.5f) / (float)width;
        const float v = ((float)(i / width) + 0.5f) / (float)height;
        float rgba[4];
        air_texture_lookup(material->emission_slot.texture, u, v, rgba);
        for (size_t c = 0; c < 3; c++) {
            const float want = values[c][i] / pi * scale * (albedo ? albedos[c][i] : tint[c]);
            assert_true(fabsf(factor[c] * rgba[c] - want) <= png_error * peak * tint[c]);
        }
    }
}

/* The importer divides by 683, the writer has multiplied by it: the scene is photometric. */
static void surfaces_send_out_what_they_reflect(void **state)
{
    lightmap_fixture *self = *state;
    static const float tint[3] = {0.5f, 0.25f, 1.0f};
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "lit.glb", NULL);
    scene_loaded copy = scene_load(self, "lit.glb");
    check_emission(&copy, "left", lightmap->pages[0], tint, false, 1.0f);
    check_emission(&copy, "right", lightmap->pages[1], tint, false, 1.0f);
    scene_unload(&copy);
    air_lightmap_destroy(lightmap);
}

static void albedo_of_the_page_goes_before_that_of_the_material(void **state)
{
    lightmap_fixture *self = *state;
    static const float white[3] = {1.0f, 1.0f, 1.0f};
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, LIGHTMAP_PAGE_CHANNELS + 3);
    scene_save(self, lightmap, "lit.glb", NULL);
    scene_loaded copy = scene_load(self, "lit.glb");
    check_emission(&copy, "left", lightmap->pages[0], white, true, 1.0f);
    check_emission(&copy, "right", lightmap->pages[1], white, true, 1.0f);
    scene_unload(&copy);
    air_lightmap_destroy(lightmap);
}

static void scale_multiplies_and_dim_light_needs_no_extension(void **state)
{
    lightmap_fixture *self = *state;
    static const float tint[3] = {0.5f, 0.25f, 1.0f};
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    const air_lightmap_gltf_params params = {.show = AIR_SHOW_EMISSIVE, .scale = 1e-4f};
    scene_save(self, lightmap, "lit.gltf", &params);
    scene_loaded copy = scene_load(self, "lit.gltf");
    check_emission(&copy, "left", lightmap->pages[0], tint, false, 1e-4f);
    scene_unload(&copy);
    json_t *root = scene_read_json(self, "lit.gltf");
    assert_int_equal(json_array_size(json_object_get(root, "extensionsUsed")), 1);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

static void lightmaps_are_stated_in_lux(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    for (int keep = 0; keep < 2; keep++) {
        const air_lightmap_gltf_params params = {
            .show = AIR_SHOW_LIGHTMAP, .scale = 1.0f, .keep_lights = keep};
        scene_save(self, lightmap, "lit.glb", &params);
        json_t *root = scene_read_json(self, "lit.glb"),
               *source = scene_read_json(self, "room.gltf");
        const size_t mesh =
            (size_t)json_integer_value(json_object_get(scene_item(root, "nodes", 0), "mesh"));
        json_t *primitive =
            json_array_get(json_object_get(scene_item(root, "meshes", mesh), "primitives"), 0);
        json_t *material = scene_item(
            root, "materials", (size_t)json_integer_value(json_object_get(primitive, "material")));
        json_t *extension =
            json_object_get(json_object_get(material, "extensions"), "MOZ_lightmap");
        float peak = 0.0f;
        for (size_t i = 0; i < 192; i++) {
            peak = fmaxf(peak, air_image_plane_const(lightmap->pages[0], i / 64)[i % 64]);
        }
        const double intensity = json_number_value(json_object_get(extension, "intensity"));
        assert_true(fabs(intensity / (683.0 * (double)peak) - 1.0) < 1e-6); /* float roundings */
        assert_int_equal(json_integer_value(json_object_get(extension, "texCoord")), 1);
        assert_true(json_equal(
            json_object_get(material, "pbrMetallicRoughness"),
            json_object_get(scene_item(source, "materials", 0), "pbrMetallicRoughness")));
        assert_int_equal(json_object_get(scene_item(root, "nodes", 3), "extensions") != NULL, keep);
        json_decref(source);
        json_decref(root);
    }
    scene_loaded copy = scene_load(self, "lit.glb"); /* still a scene */
    scene_unload(&copy);
    air_lightmap_destroy(lightmap);
}

/* One texel that went wrong, and one that nothing covers, do not make the others black. */
static void stray_texels_do_not_take_the_steps_of_the_others(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    air_image *page = lightmap_page(self, 100, 20, 13);
    air_image_destroy(lightmap->pages[0]);
    lightmap->pages[0] = page;
    image_like_wall(page);
    air_image_plane(page, 0)[77] = 1e6f;
    air_image_plane(page, 1)[78] = 1e7f;
    air_image_plane(page, 12)[78] = 0.0f;
    const air_lightmap_gltf_params params = {.show = AIR_SHOW_LIGHTMAP, .scale = 1.0f};
    scene_save(self, lightmap, "lit.gltf", &params);
    assert_int_equal(self->warnings, 1);
    assert_non_null(strstr(self->warning, "page 0: 1 texels brighter than "));
    air_image *picture = NULL;
    assert_int_equal(
        air_image_load(self->context, lightmap_path(self, "lit-lightmap-0.png"), &picture), AIR_OK);
    /* The wall is 1 at its brightest, so white is 4. */
    for (size_t i = 0; i < 2000; i++) {
        const float want = fminf(air_image_plane(page, 0)[i] / 4.0f, 1.0f);
        assert_true(fabsf(air_image_plane(picture, 0)[i] - want) <= png_error);
    }
    air_image_destroy(picture);
    /* Where nothing is said to be covered, all counts. */
    memset(air_image_plane(page, 12), 0, 2000 * sizeof(float));
    air_image_plane(page, 0)[77] = air_image_plane(page, 1)[78] = 0.5f;
    scene_save(self, lightmap, "lit.gltf", &params);
    assert_int_equal(
        air_image_load(self->context, lightmap_path(self, "lit-lightmap-0.png"), &picture), AIR_OK);
    assert_true(air_image_plane(picture, 0)[1999] == 1.0f);
    air_image_destroy(picture);
    air_lightmap_destroy(lightmap);
}

/* For engines: coordinates are there, materials as they were, and no picture. */
static void coordinates_alone_leave_materials_alone(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    const air_lightmap_gltf_params params = {.show = AIR_SHOW_COORDINATES, .scale = 1.0f};
    scene_save(self, lightmap, "out/lit.gltf", &params);
    assert_int_equal(lightmap_count_files(lightmap_path(self, "out")), 2);
    json_t *root = scene_read_json(self, "out/lit.gltf"),
           *source = scene_read_json(self, "room.gltf");
    static const char *const same[] = {"materials", "images", "textures", "samplers",
                                       "extensionsUsed"};
    for (size_t i = 0; i < 5; i++) {
        json_t *a = json_object_get(root, same[i]), *b = json_object_get(source, same[i]);
        assert_true(a == b || json_equal(a, b));
    }
    scene_loaded copy = scene_load(self, "out/lit.gltf");
    assert_memory_equal(scene_find_mesh(&copy, "right")->uv[1], scene_cut_uv, sizeof scene_cut_uv);
    assert_true(scene_find_mesh(&copy, "lamp")->uv[1][0] == 0.0f);
    scene_unload(&copy);
    json_decref(source);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

static void pictures_come_along(void **state)
{
    lightmap_fixture *self = *state;
    static const float tint[3] = {1.0f, 1.0f, 1.0f};
    air_lightmap *lightmap = scene_lightmap(self, 13);
    air_image *picture = NULL;
    assert_int_equal(air_image_create(self->context, 2, 2, 3, lightmap_channels, &picture), AIR_OK);
    assert_int_equal(
        air_image_save(self->context, picture, lightmap_path(self, "paint it.png"), NULL), AIR_OK);
    air_image_destroy(picture);
    scene_write(self, "\"baseColorFactor\":[0.5,0.25,1,0.75]",
                "\"baseColorTexture\":{\"index\":0}");
    char *text = lightmap_read(self, "room.gltf", NULL), edited[8192];
    (void)snprintf(edited, sizeof edited,
                   "{\"images\":[{\"uri\":\"paint%%20it.png\"}],\"textures\":[{\"source\":0}],%s",
                   text + 1);
    lightmap_write(self, "room.gltf", edited, strlen(edited));
    free(text);
    scene_save(self, lightmap, "elsewhere/lit.gltf", NULL);
    assert_non_null(strstr(self->warning, "the lightmap has no albedo"));
    json_t *root = scene_read_json(self, "elsewhere/lit.gltf");
    json_t *image = scene_item(root, "images", 0);
    assert_null(json_object_get(image, "uri"));
    assert_string_equal(json_string_value(json_object_get(image, "mimeType")), "image/png");
    json_decref(root);
    scene_loaded copy = scene_load(self, "elsewhere/lit.gltf");
    check_emission(&copy, "left", lightmap->pages[0], tint, false, 1.0f);
    assert_non_null(
        copy.snapshot->materials[scene_find_mesh(&copy, "left")->material].base_color_slot.texture);
    scene_unload(&copy);
    air_lightmap_destroy(lightmap);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, lightmap_start, lightmap_finish)
    const struct CMUnitTest tests[] = {
        TEST(own_coordinates_move_to_their_place_on_the_page),
        TEST(cut_meshes_gather_every_attribute),
        TEST(morph_targets_and_skinning_are_cut_as_well),
        TEST(nodes_that_share_a_mesh_get_their_own),
        TEST(what_is_not_lit_is_kept_as_it_is),
        TEST(a_set_that_is_in_use_makes_room),
        TEST(surfaces_send_out_what_they_reflect),
        TEST(albedo_of_the_page_goes_before_that_of_the_material),
        TEST(scale_multiplies_and_dim_light_needs_no_extension),
        TEST(lightmaps_are_stated_in_lux),
        TEST(stray_texels_do_not_take_the_steps_of_the_others),
        TEST(coordinates_alone_leave_materials_alone),
        TEST(pictures_come_along),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}

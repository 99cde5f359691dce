/* Copies of glTF scenes that show their lightmap, loaded again by the importer. */
#include <errno.h>
#include <jansson.h>
#include <signal.h>
#include <sys/resource.h>

#include "lightmap_gltf_scene.h"
#include "scene/texture.h"

static const float pi = 3.14159265f;
/* A channel of 8 bits in sRGB is off by half a step; at its brightest the decoded value changes
 * by 2.4 / 1.055 per unit of the encoded one. Of the page's largest value: */
static const float png_error = 0.5f / 255.0f * 2.4f / 1.055f * 1.001f;

static void save(lightmap_fixture *self, const air_lightmap *lightmap, const char *name,
                 const air_lightmap_gltf_params *params)
{
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    if (air_lightmap_save_gltf(self->context, lightmap, scene, lightmap_path(self, name), params) !=
        AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
}

typedef struct loaded {
    air_scene *scene;
    air_snapshot *snapshot;
} loaded;

static loaded load(lightmap_fixture *self, const char *name)
{
    loaded result = {0};
    air_load_params params;
    air_load_params_default(&params);
    if (air_scene_load(self->context, lightmap_path(self, name), &params, &result.scene) !=
            AIR_OK ||
        air_scene_commit(result.scene, &result.snapshot, NULL) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    return result;
}

static void unload(loaded *self)
{
    air_snapshot_release(self->snapshot);
    air_scene_destroy(self->scene);
}

/* The JSON of a .gltf or .glb. */
static json_t *read_json(lightmap_fixture *self, const char *name)
{
    json_error_t error;
    size_t size;
    char *data = lightmap_read(self, name, &size);
    uint32_t length = 0;
    const bool binary = memcmp(data, "glTF", 4) == 0;
    if (binary) {
        memcpy(&length, data + 8, 4);
        assert_int_equal(length, size);
        memcpy(&length, data + 12, 4);
    }
    json_t *json = json_loadb(binary ? data + 20 : data, binary ? length : size, 0, &error);
    assert_non_null(json);
    free(data);
    return json;
}

static const air_mesh *find_mesh(const loaded *self, const char *name)
{
    for (size_t i = 0; i < self->snapshot->mesh_count; i++) {
        if (strcmp(self->snapshot->meshes[i]->name, name) == 0) {
            return self->snapshot->meshes[i];
        }
    }
    fail_msg("no mesh is called %s", name);
    return NULL;
}

static json_t *item(json_t *root, const char *list, size_t index)
{
    json_t *value = json_array_get(json_object_get(root, list), index);
    assert_non_null(value);
    return value;
}

/* ---- what meshes become ---- */

static void own_coordinates_move_to_their_place_on_the_page(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    save(self, lightmap, "lit.glb", NULL);
    loaded copy = load(self, "lit.glb");
    const air_mesh *left = find_mesh(&copy, "left");
    assert_int_equal(left->vertex_count, 4);
    assert_int_equal(left->triangle_count, 2);
    for (size_t i = 0; i < 8; i++) {
        const float own = (float)scene_uv1[i] / 65535.0f;
        const float want = i % 2 == 0 ? own * 0.5f + 0.25f : own * 0.25f + 0.5f;
        assert_true(left->uv[1][i] == want);
    }
    assert_memory_equal(left->positions, scene_corners, sizeof scene_corners);
    unload(&copy);
    air_lightmap_destroy(lightmap);
}

/* Interleaved, normalised and sparse: every vertex keeps what its source had. */
static void cut_meshes_gather_every_attribute(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    save(self, lightmap, "lit.glb", NULL);
    loaded copy = load(self, "lit.glb"), source = load(self, "room.gltf");
    const air_mesh *right = find_mesh(&copy, "right"), *old = find_mesh(&source, "right");
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
    unload(&source);
    unload(&copy);
    air_lightmap_destroy(lightmap);
}

/* Numbers of an accessor whose view lies in the file's one buffer. */
static const uint8_t *accessor_bytes(json_t *root, const uint8_t *binary, size_t accessor,
                                     size_t *out_stride)
{
    json_t *json = item(root, "accessors", accessor);
    json_t *view =
        item(root, "bufferViews", (size_t)json_integer_value(json_object_get(json, "bufferView")));
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
    save(self, lightmap, "lit.gltf", NULL);
    json_t *root = read_json(self, "lit.gltf");
    const size_t mesh = (size_t)json_integer_value(json_object_get(item(root, "nodes", 1), "mesh"));
    json_t *primitive =
        json_array_get(json_object_get(item(root, "meshes", mesh), "primitives"), 0);
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
    assert_true(json_is_true(json_object_get(item(root, "accessors", weights), "normalized")));
    assert_null(json_object_get(item(root, "accessors", joints), "normalized"));
    /* Three bytes of colour lie four bytes apart. */
    const size_t colors = (size_t)json_integer_value(json_object_get(attributes, "COLOR_0"));
    (void)accessor_bytes(root, bytes, colors, &stride);
    assert_int_equal(stride, 4);
    const size_t corners = (size_t)json_integer_value(json_object_get(attributes, "POSITION"));
    json_t *accessor = item(root, "accessors", corners);
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
    save(self, lightmap, "lit.glb", NULL);
    json_t *root = read_json(self, "lit.glb");
    const json_int_t left = json_integer_value(json_object_get(item(root, "nodes", 0), "mesh"));
    const json_int_t right = json_integer_value(json_object_get(item(root, "nodes", 1), "mesh"));
    assert_int_equal(json_array_size(json_object_get(root, "meshes")), 3);
    assert_true(left != right);
    assert_string_equal(
        json_string_value(json_object_get(item(root, "meshes", (size_t)left), "name")), "quad");
    assert_string_equal(
        json_string_value(json_object_get(item(root, "meshes", (size_t)right), "name")), "quad");
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

static void what_is_not_lit_is_kept_as_it_is(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    save(self, lightmap, "lit.glb", NULL);
    json_t *root = read_json(self, "lit.glb"), *source = read_json(self, "room.gltf");
    assert_true(json_equal(json_object_get(item(root, "nodes", 0), "extras"),
                           json_object_get(item(source, "nodes", 0), "extras")));
    assert_true(json_is_object(json_object_get(item(root, "nodes", 1), "nobodyKnows")));
    assert_true(json_equal(item(root, "nodes", 2), item(source, "nodes", 2)));
    assert_true(json_equal(item(root, "nodes", 3), item(source, "nodes", 3)));
    assert_true(json_equal(item(root, "meshes", 1), item(source, "meshes", 1))); /* it emits */
    assert_true(json_equal(item(root, "materials", 0), item(source, "materials", 0)));
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
    save(self, lightmap, "lit.glb", NULL);
    json_t *root = read_json(self, "lit.glb"), *source = read_json(self, "room.gltf");
    for (size_t node = 0; node < 2; node++) {
        const size_t mesh =
            (size_t)json_integer_value(json_object_get(item(root, "nodes", node), "mesh"));
        json_t *primitive =
            json_array_get(json_object_get(item(root, "meshes", mesh), "primitives"), 0);
        json_t *attributes = json_object_get(primitive, "attributes");
        json_t *material = item(root, "materials",
                                (size_t)json_integer_value(json_object_get(primitive, "material")));
        json_t *occlusion = json_object_get(material, "occlusionTexture");
        json_t *emission = json_object_get(material, "emissiveTexture");
        assert_int_equal(json_integer_value(json_object_get(occlusion, "texCoord")), 2);
        assert_int_equal(json_integer_value(json_object_get(emission, "texCoord")), 1);
        assert_non_null(json_object_get(attributes, "TEXCOORD_2"));
        if (node == 0) {
            assert_int_equal(json_integer_value(json_object_get(attributes, "TEXCOORD_2")), 4);
        }
    }
    assert_true(json_equal(item(root, "materials", 0), item(source, "materials", 0)));
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
static void check_emission(const loaded *copy, const char *name, const air_image *page,
                           const float tint[3], bool albedo, float scale)
{
    const air_material *material = &copy->snapshot->materials[find_mesh(copy, name)->material];
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
    save(self, lightmap, "lit.glb", NULL);
    loaded copy = load(self, "lit.glb");
    check_emission(&copy, "left", lightmap->pages[0], tint, false, 1.0f);
    check_emission(&copy, "right", lightmap->pages[1], tint, false, 1.0f);
    unload(&copy);
    air_lightmap_destroy(lightmap);
}

static void albedo_of_the_page_goes_before_that_of_the_material(void **state)
{
    lightmap_fixture *self = *state;
    static const float white[3] = {1.0f, 1.0f, 1.0f};
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, LIGHTMAP_PAGE_CHANNELS + 3);
    save(self, lightmap, "lit.glb", NULL);
    loaded copy = load(self, "lit.glb");
    check_emission(&copy, "left", lightmap->pages[0], white, true, 1.0f);
    check_emission(&copy, "right", lightmap->pages[1], white, true, 1.0f);
    unload(&copy);
    air_lightmap_destroy(lightmap);
}

static void scale_multiplies_and_dim_light_needs_no_extension(void **state)
{
    lightmap_fixture *self = *state;
    static const float tint[3] = {0.5f, 0.25f, 1.0f};
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    const air_lightmap_gltf_params params = {.show = AIR_SHOW_EMISSIVE, .scale = 1e-4f};
    save(self, lightmap, "lit.gltf", &params);
    loaded copy = load(self, "lit.gltf");
    check_emission(&copy, "left", lightmap->pages[0], tint, false, 1e-4f);
    unload(&copy);
    json_t *root = read_json(self, "lit.gltf");
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
        save(self, lightmap, "lit.glb", &params);
        json_t *root = read_json(self, "lit.glb"), *source = read_json(self, "room.gltf");
        const size_t mesh =
            (size_t)json_integer_value(json_object_get(item(root, "nodes", 0), "mesh"));
        json_t *primitive =
            json_array_get(json_object_get(item(root, "meshes", mesh), "primitives"), 0);
        json_t *material = item(root, "materials",
                                (size_t)json_integer_value(json_object_get(primitive, "material")));
        json_t *extension =
            json_object_get(json_object_get(material, "extensions"), "MOZ_lightmap");
        float peak = 0.0f;
        for (size_t i = 0; i < 192; i++) {
            peak = fmaxf(peak, air_image_plane_const(lightmap->pages[0], i / 64)[i % 64]);
        }
        const double intensity = json_number_value(json_object_get(extension, "intensity"));
        assert_true(fabs(intensity / (683.0 * (double)peak) - 1.0) < 1e-6); /* float roundings */
        assert_int_equal(json_integer_value(json_object_get(extension, "texCoord")), 1);
        assert_true(
            json_equal(json_object_get(material, "pbrMetallicRoughness"),
                       json_object_get(item(source, "materials", 0), "pbrMetallicRoughness")));
        assert_int_equal(json_object_get(item(root, "nodes", 3), "extensions") != NULL, keep);
        json_decref(source);
        json_decref(root);
    }
    loaded copy = load(self, "lit.glb"); /* still a scene */
    unload(&copy);
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
    save(self, lightmap, "lit.gltf", &params);
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
    save(self, lightmap, "lit.gltf", &params);
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
    save(self, lightmap, "out/lit.gltf", &params);
    assert_int_equal(lightmap_count_files(lightmap_path(self, "out")), 2);
    json_t *root = read_json(self, "out/lit.gltf"), *source = read_json(self, "room.gltf");
    static const char *const same[] = {"materials", "images", "textures", "samplers",
                                       "extensionsUsed"};
    for (size_t i = 0; i < 5; i++) {
        json_t *a = json_object_get(root, same[i]), *b = json_object_get(source, same[i]);
        assert_true(a == b || json_equal(a, b));
    }
    loaded copy = load(self, "out/lit.gltf");
    assert_memory_equal(find_mesh(&copy, "right")->uv[1], scene_cut_uv, sizeof scene_cut_uv);
    assert_true(find_mesh(&copy, "lamp")->uv[1][0] == 0.0f);
    unload(&copy);
    json_decref(source);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

/* ---- files ---- */

static void all_kinds_of_buffers_and_copies_mean_the_same(void **state)
{
    lightmap_fixture *self = *state;
    static const char *const names[] = {"lit.glb", "lit.gltf", "other/my room.gltf", "again.glb"};
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_write(self, "", "");
    for (size_t i = 0; i < 4; i++) {
        if (i == 3) { /* of a copy in a GLB file; it emits already, so all stays */
            size_t size;
            char *data = lightmap_read(self, "lit.glb", &size);
            lightmap_write(self, "room.gltf", data, size);
            free(data);
        }
        save(self, lightmap, names[i], NULL);
        loaded copy = load(self, names[i]);
        const air_mesh *right = find_mesh(&copy, "right");
        assert_int_equal(right->vertex_count, 6);
        assert_memory_equal(right->uv[1], scene_cut_uv, sizeof scene_cut_uv);
        assert_non_null(copy.snapshot->materials[right->material].emission_slot.texture);
        unload(&copy);
    }
    assert_int_equal(lightmap_count_files(lightmap_path(self, "other")), 4);
    assert_int_equal(access(lightmap_path(self, "other/my room-lightmap-1.png"), F_OK), 0);
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
    save(self, lightmap, "elsewhere/lit.gltf", NULL);
    assert_non_null(strstr(self->warning, "the lightmap has no albedo"));
    json_t *root = read_json(self, "elsewhere/lit.gltf");
    json_t *image = item(root, "images", 0);
    assert_null(json_object_get(image, "uri"));
    assert_string_equal(json_string_value(json_object_get(image, "mimeType")), "image/png");
    json_decref(root);
    loaded copy = load(self, "elsewhere/lit.gltf");
    check_emission(&copy, "left", lightmap->pages[0], tint, false, 1.0f);
    assert_non_null(
        copy.snapshot->materials[find_mesh(&copy, "left")->material].base_color_slot.texture);
    unload(&copy);
    air_lightmap_destroy(lightmap);
}

static void a_full_disk_leaves_the_older_copy(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    save(self, lightmap, "out/lit.gltf", NULL);
    size_t before, after;
    char *old = lightmap_read(self, "out/lit.bin", &before);
    air_image_plane(lightmap->pages[0], 0)[0] = 100.0f;
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit small = {2000, limit.rlim_max}; /* the JSON, which comes last, has more */
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const air_status status = air_lightmap_save_gltf(self->context, lightmap, scene,
                                                     lightmap_path(self, "out/lit.gltf"), NULL);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    (void)signal(SIGXFSZ, handler);
    assert_int_equal(status, AIR_ERROR_IO);
    lightmap_expect(self, "/out/lit.gltf: cannot be written: ");
    char *now = lightmap_read(self, "out/lit.bin", &after);
    assert_int_equal(before, after);
    assert_memory_equal(old, now, before);
    assert_int_equal(lightmap_count_files(lightmap_path(self, "out")), 4);
    free(now);
    free(old);
    air_lightmap_destroy(lightmap);
}

/* ---- what is refused ---- */

static void refuse(lightmap_fixture *self, const air_lightmap *lightmap, air_status status,
                   const char *part)
{
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    const air_status got = air_lightmap_save_gltf(self->context, lightmap, scene,
                                                  lightmap_path(self, "none.glb"), NULL);
    if (got != status) {
        fail_msg("status %d (%s), expected %d and \"%s\"", (int)got,
                 air_context_last_error(self->context), (int)status, part);
    }
    lightmap_expect(self, part);
    assert_int_equal(access(self->path, F_OK), -1);
}

static void scenes_that_were_not_baked_are_refused(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = scene_lightmap(self, 13);
    static const struct {
        const char *from, *to;
        air_status status;
        const char *part;
    } edits[] = {
        {"\"TEXCOORD_1\":4,", "", AIR_ERROR_FORMAT,
         "$.nodes[0].mesh.primitives[0].attributes.TEXCOORD_1: expected coordinates"},
        {"\"mesh\":0,", "", AIR_ERROR_FORMAT, "$.nodes[0].mesh: expected"},
        {"\"mesh\":0,", "\"mesh\":7,", AIR_ERROR_FORMAT, "$.nodes[0].mesh: expected a whole"},
        {"\"byteLength\":240", "\"byteLength\":241", AIR_ERROR_FORMAT,
         "$.buffers[0].byteLength: expected at most the 240 bytes"},
        {"a%20b.bin", "data:x;base64,!", AIR_ERROR_FORMAT, "$.buffers[0].uri: expected base64"},
        {"a%20b.bin", "http://x/y", AIR_ERROR_FORMAT, "$.buffers[0].uri: expected a relative path"},
        {"a%20b.bin", "nowhere.bin", AIR_ERROR_IO, "nowhere.bin"},
        {"\"byteLength\":48", "\"byteLength\":47", AIR_ERROR_FORMAT, "$.accessors[0]: expected 4"},
        {"\"buffer\":0", "\"buffer\":1", AIR_ERROR_FORMAT, "$.bufferViews[0].buffer: expected"},
        {"\"indices\":5,\"material\":0",
         "\"indices\":5,\"extensions\":{\"KHR_draco_mesh_compression\":{}},\"material\":0",
         AIR_ERROR_UNSUPPORTED, "KHR_draco_mesh_compression"},
        {"\"byteLength\":12}",
         "\"byteLength\":12,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0}}}",
         AIR_ERROR_UNSUPPORTED, "EXT_meshopt_compression"},
        {"\"material\":0", "\"material\":2", AIR_ERROR_FORMAT, "$.materials[2]: expected a mat"},
        {"\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1",
         "\"type\":\"MAT2\",\"min\":[0,0,0],\"max\":[1", AIR_ERROR_FORMAT,
         "$.accessors[0].type: expected"},
        {"{\"asset\"", "[\"asset\"", AIR_ERROR_FORMAT, "room.gltf:1:"},
    };
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        scene_write(self, edits[i].from, edits[i].to);
        refuse(self, lightmap, edits[i].status, edits[i].part);
    }
    scene_write(self, "", "");
    lightmap->meshes[1].sources[3] = 4;
    refuse(self, lightmap, AIR_ERROR_FORMAT, "there are 4");
    lightmap->meshes[1].sources[3] = 0;
    lightmap->meshes[0].node = 9;
    refuse(self, lightmap, AIR_ERROR_FORMAT, "$.nodes[9]: expected a node");
    lightmap->meshes[0].node = 0;
    lightmap->meshes[0].primitive = 1;
    refuse(self, lightmap, AIR_ERROR_FORMAT, "primitives[1].attributes: expected attributes");
    lightmap->meshes[0].primitive = 0;
    air_lightmap_destroy(lightmap);
}

static void names_and_scales_are_checked(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_write(self, "", "");
    const air_lightmap_gltf_params params = {.scale = 0.0f};
    assert_int_equal(air_lightmap_save_gltf(self->context, lightmap, "x.gltf", "y.obj", NULL),
                     AIR_ERROR_ARGUMENT);
    lightmap_expect(self, "y.obj: expected a name that ends in .glb or .gltf");
    assert_int_equal(air_lightmap_save_gltf(self->context, lightmap, "x.gltf", "y.glb", &params),
                     AIR_ERROR_ARGUMENT);
    lightmap_expect(self, "the scale is 0");
    air_lightmap_destroy(lightmap);
}

static void truncated_glb_files_are_refused(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_write(self, "", "");
    save(self, lightmap, "lit.glb", NULL);
    size_t size;
    char *data = lightmap_read(self, "lit.glb", &size);
    for (size_t length = 0; length < size; length += 97) {
        lightmap_write(self, "room.gltf", data, length);
        refuse(self, lightmap, AIR_ERROR_FORMAT, "room.gltf");
    }
    free(data);
    air_lightmap_destroy(lightmap);
}

static void writing_without_memory_leaves_nothing(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_write(self, "", "");
    const size_t files = lightmap_count_files(self->folder);
    const long live = atomic_load(&self->allocator.live);
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    for (int binary = 0; binary < 2; binary++) {
        air_status status = AIR_ERROR_MEMORY;
        long allowed = 0;
        const char *path = lightmap_path(self, binary ? "new.glb" : "new.gltf");
        for (; status != AIR_OK && allowed < 2000; allowed++) {
            atomic_store(&self->allocator.remaining, allowed);
            status = air_lightmap_save_gltf(self->context, lightmap, scene, path, NULL);
            atomic_store(&self->allocator.remaining, LIGHTMAP_MANY);
            assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
            assert_int_equal(atomic_load(&self->allocator.live), live);
            assert_int_equal(lightmap_count_files(self->folder) != files + (binary ? 4 : 0),
                             status == AIR_OK);
        }
        assert_int_equal(status, AIR_OK);
        assert_true(allowed > 50);
    }
    air_lightmap_destroy(lightmap);
}

/* Somebody else's file: two boxes and a room, each with coordinates of its own. */
static void a_shared_scene_is_copied_with_its_own_coordinates(void **state)
{
    lightmap_fixture *self = *state;
    static const int32_t nodes[5] = {1, 2, 3, 3, 3}, primitives[5] = {0, 0, 0, 1, 2};
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/scenes/bevy/CornellBox/CornellBox.glb", AIR_SHARED_DIR);
    if (access(scene, R_OK) != 0) {
        print_message("%s is not here: skipped\n", scene);
        skip();
    }
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    lightmap_add_page(self, lightmap, lightmap_page(self, 32, 32, 13));
    lightmap->mesh_count = 5;
    lightmap->meshes = air_allocate(self->context, 5, sizeof *lightmap->meshes);
    for (uint32_t i = 0; i < 5; i++) {
        lightmap->meshes[i] = (air_lightmap_mesh){.mesh = i + 1,
                                                  .node = nodes[i],
                                                  .primitive = primitives[i],
                                                  .scale = {0.25f, 0.5f},
                                                  .offset = {0.5f, 0.25f}};
    }
    if (air_lightmap_save_gltf(self->context, lightmap, scene, lightmap_path(self, "box.glb"),
                               NULL) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    loaded copy = load(self, "box.glb"), source = {0};
    air_load_params params;
    air_load_params_default(&params);
    assert_int_equal(air_scene_load(self->context, scene, &params, &source.scene), AIR_OK);
    assert_int_equal(air_scene_commit(source.scene, &source.snapshot, NULL), AIR_OK);
    assert_int_equal(copy.snapshot->mesh_count, source.snapshot->mesh_count);
    for (size_t m = 0; m < source.snapshot->mesh_count; m++) {
        const air_mesh *a = source.snapshot->meshes[m], *b = copy.snapshot->meshes[m];
        assert_int_equal(a->vertex_count, b->vertex_count);
        assert_memory_equal(a->positions, b->positions, 12 * a->vertex_count);
        for (size_t i = 0; m > 0 && i < 2 * a->vertex_count; i++) {
            assert_true(b->uv[1][i] ==
                        a->uv[1][i] * (i % 2 ? 0.5f : 0.25f) + (i % 2 ? 0.25f : 0.5f));
        }
        assert_int_equal(copy.snapshot->materials[b->material].emission_slot.texture != NULL,
                         m > 0); /* the lamp stays */
    }
    unload(&source);
    unload(&copy);
    air_lightmap_destroy(lightmap);
}

/* Cuts every primitive of a scene into single triangles, by what the importer has of it. Meshes are
 * in the order of nodes and primitives, as nodes are flat. */
static air_lightmap *cut_all(lightmap_fixture *self, const air_snapshot *snapshot, json_t *root)
{
    air_lightmap *lightmap = NULL;
    size_t node, primitive, next = 0;
    json_t *node_json, *primitive_json;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    lightmap_add_page(self, lightmap, lightmap_page(self, 32, 32, 13));
    lightmap->meshes = air_allocate(self->context, snapshot->mesh_count, sizeof *lightmap->meshes);
    lightmap->mesh_count = snapshot->mesh_count;
    json_array_foreach(json_object_get(root, "nodes"), node, node_json)
    {
        json_t *mesh_at = json_object_get(node_json, "mesh");
        json_t *mesh =
            mesh_at == NULL ? NULL : item(root, "meshes", (size_t)json_integer_value(mesh_at));
        json_array_foreach(json_object_get(mesh, "primitives"), primitive, primitive_json)
        {
            const air_mesh *source = snapshot->meshes[next];
            const size_t count = 3 * source->triangle_count;
            uint32_t *order = calloc(count, sizeof *order);
            float *uv = calloc(2 * count, sizeof *uv);
            for (size_t i = 0; i < count; i++) {
                order[i] = (uint32_t)i;
                uv[2 * i] = (float)i / (float)count;
            }
            lightmap->meshes[next] = (air_lightmap_mesh){.mesh = (uint32_t)next,
                                                         .node = (int32_t)node,
                                                         .primitive = (int32_t)primitive,
                                                         .scale = {1, 1}};
            lightmap_cut(self, &lightmap->meshes[next], count, source->indices, uv,
                         source->triangle_count, order);
            free(order);
            free(uv);
            next++;
        }
    }
    assert_int_equal(next, snapshot->mesh_count);
    return lightmap;
}

/* A whole room, pictures and all: the same triangles with the same corners, colours and
 * coordinates. */
static void a_furnished_room_is_cut_and_stays_the_room(void **state)
{
    lightmap_fixture *self = *state;
    static const char scene[] = AIR_SOURCE_DIR "/scenes/sunroom/sunroom.gltf";
    json_error_t error;
    json_t *root = json_load_file(scene, 0, &error);
    loaded source = {0};
    air_load_params params;
    air_load_params_default(&params);
    assert_non_null(root);
    assert_int_equal(air_scene_load(self->context, scene, &params, &source.scene), AIR_OK);
    assert_int_equal(air_scene_commit(source.scene, &source.snapshot, NULL), AIR_OK);
    air_lightmap *lightmap = cut_all(self, source.snapshot, root);
    if (air_lightmap_save_gltf(self->context, lightmap, scene, lightmap_path(self, "room.glb"),
                               NULL) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    loaded copy = load(self, "room.glb");
    assert_int_equal(copy.snapshot->mesh_count, source.snapshot->mesh_count);
    for (size_t m = 0; m < source.snapshot->mesh_count; m++) {
        const air_mesh *a = source.snapshot->meshes[m], *b = copy.snapshot->meshes[m];
        assert_int_equal(a->triangle_count, b->triangle_count);
        assert_true((a->uv[0] != NULL) == (b->uv[0] != NULL));
        for (size_t i = 0; i < 3 * a->triangle_count; i++) {
            const size_t from = a->indices[i], to = b->indices[i];
            assert_memory_equal(a->positions + 3 * from, b->positions + 3 * to, 12);
            assert_memory_equal(a->normals + 3 * from, b->normals + 3 * to, 12);
            if (a->uv[0] != NULL) {
                assert_memory_equal(a->uv[0] + 2 * from, b->uv[0] + 2 * to, 8);
            }
            assert_true(b->uv[1][2 * to] == (float)i / (float)(3 * a->triangle_count));
        }
    }
    unload(&copy);
    unload(&source);
    json_decref(root);
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
        TEST(all_kinds_of_buffers_and_copies_mean_the_same),
        TEST(pictures_come_along),
        TEST(a_full_disk_leaves_the_older_copy),
        TEST(scenes_that_were_not_baked_are_refused),
        TEST(names_and_scales_are_checked),
        TEST(truncated_glb_files_are_refused),
        TEST(writing_without_memory_leaves_nothing),
        TEST(a_furnished_room_is_cut_and_stays_the_room),
        TEST(a_shared_scene_is_copied_with_its_own_coordinates),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}

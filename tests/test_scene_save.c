/* Scenes written as .glb and read again: kind by kind, number by number. Where nothing else is
 * said the numbers are the same to the last bit. */
#include "saved_scene.h"
#include "scene/export/export.h"

/* ---- meshes ---- */

static void meshes_keep_their_arrays_and_their_place(void **state)
{
    (void)state;
    saved_fixture f;
    float normals[12], tangents[16], uv[2][8], colors[16];
    air_rng random = air_rng_from_keys(1, 2);
    saved_init(&f);
    for (size_t i = 0; i < 4; ++i) {
        saved_random_direction(&random, normals + 3 * i);
        saved_random_direction(&random, tangents + 4 * i);
        tangents[4 * i + 3] = i % 2 == 0 ? 1.0f : -1.0f;
    }
    for (size_t i = 0; i < 16; ++i) {
        uv[i / 8][i % 8] = saved_random_between(&random, -3.0f, 3.0f);
        colors[i] = saved_random_between(&random, 0.0f, 1.0f);
    }
    air_mesh_desc mesh = saved_square_mesh("all of it");
    mesh.normals = normals;
    mesh.tangents = tangents;
    mesh.uv[0] = uv[0];
    mesh.uv[1] = uv[1];
    mesh.colors = colors;
    mesh.camera_visible = false;
    const float map[12] = {0.0f, -2.0f, 0.0f, 0.1f, 2.0f, 0.0f,
                           0.0f, -7.3f, 0.0f, 0.0f, 3.0f, 1e5f};
    memcpy(mesh.to_world, map, sizeof map);
    saved_add_mesh(&f, &mesh);
    mesh = saved_square_mesh("bare");
    mesh.casts_shadow = false;
    saved_add_mesh(&f, &mesh);
    saved_round(&f);
    assert_int_equal(f.again->lists[AIR_OBJECT_MESH].count, 2);
    for (size_t i = 0; i < 2; ++i) {
        const air_mesh_record *a =
            (const air_mesh_record *)saved_record(f.scene, AIR_OBJECT_MESH, i);
        const air_mesh_record *b =
            (const air_mesh_record *)saved_record(f.again, AIR_OBJECT_MESH, i);
        assert_string_equal(a->base.name, b->base.name);
        assert_true(air_geometry_equal(a->geometry, b->geometry));
        assert_true(air_mesh_place_equal(a, b));
        assert_int_equal(a->camera_visible, b->camera_visible);
        assert_int_equal(a->casts_shadow, b->casts_shadow);
    }
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

/* glTF's nodes do not shear: such a mesh is written in world space, a mirrored one with its
 * triangles turned, so that fronts stay fronts. */
static void sheared_and_mirrored_meshes_are_written_where_they_are(void **state)
{
    (void)state;
    saved_fixture f;
    air_snapshot *before = NULL, *after = NULL;
    saved_init(&f);
    air_mesh_desc mesh = saved_square_mesh("sheared");
    const float map[12] = {-1.0f, 0.5f, 0.0f, 3.0f, 0.0f, 1.0f,
                           0.25f, 0.0f, 0.0f, 0.0f, 2.0f, 1.0f};
    memcpy(mesh.to_world, map, sizeof map);
    saved_add_mesh(&f, &mesh);
    saved_round(&f);
    assert_int_equal(air_scene_commit(f.scene, &before, NULL), AIR_OK);
    assert_int_equal(air_scene_commit(f.again, &after, NULL), AIR_OK);
    const air_mesh *a = before->meshes[0], *b = after->meshes[0];
    assert_memory_equal(a->positions, b->positions, 12 * sizeof(float));
    assert_true(a->flip && !b->flip);
    for (size_t t = 0; t < 2; ++t) {
        assert_int_equal(a->indices[3 * t], b->indices[3 * t]);
        assert_int_equal(a->indices[3 * t + 1], b->indices[3 * t + 2]);
    }
    air_snapshot_release(after);
    air_snapshot_release(before);
    saved_finish(&f);
}

static void equal_arrays_are_written_once(void **state)
{
    (void)state;
    saved_fixture f;
    saved_init(&f);
    air_mesh_desc mesh = saved_square_mesh("one");
    for (size_t i = 0; i < 200; ++i) {
        mesh.to_world[3] = (float)i;
        saved_add_mesh(&f, &mesh);
    }
    saved_round(&f);
    assert_int_equal(f.again->lists[AIR_OBJECT_MESH].count, 200);
    FILE *file = fopen(f.path, "rb");
    uint8_t head[20];
    assert_non_null(file);
    assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
    const long text = (long)(head[12] | head[13] << 8 | head[14] << 16);
    assert_int_equal(fseek(file, 20 + text, SEEK_SET), 0);
    assert_int_equal(fread(head, 1, 8, file), 8);
    fclose(file);
    assert_int_equal(head[0], 12 * 4 + 6 * 4); /* positions and indices */
    assert_int_equal(head[1] + head[2] + head[3], 0);
    saved_finish(&f);
}

/* ---- materials ---- */

static void materials_keep_their_numbers(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(4, 5);
    saved_init(&f);
    enum { COUNT = 200 };
    for (size_t i = 0; i < COUNT; ++i) {
        air_material_desc desc;
        char name[16];
        snprintf(name, sizeof name, "m%zu", i);
        air_material_desc_default(&desc);
        desc.name = name;
        for (size_t c = 0; c < 4; ++c)
            desc.base_color[c] = saved_random_between(&random, 0.0f, 1.0f);
        desc.metallic = saved_random_between(&random, 0.0f, 1.0f);
        desc.roughness = saved_random_between(&random, 0.0f, 1.0f);
        desc.specular = saved_random_between(&random, 0.0f, 1.0f);
        desc.ior = saved_random_between(&random, 1.0f, 3.0f);
        for (size_t c = 0; c < 3; ++c)
            desc.emission[c] = i % 3 == c ? 0.0f : saved_random_strength(&random);
        desc.alpha_mode = (air_alpha_mode)(i % 3);
        desc.alpha_cutoff =
            i % 3 == AIR_ALPHA_MASK ? saved_random_between(&random, 0.0f, 1.0f) : 0.5f;
        desc.double_sided = i % 2 == 0;
        desc.unlit = i % 5 == 0;
        saved_show_material(&f, &desc);
    }
    saved_round(&f);
    assert_int_equal(f.again->lists[AIR_OBJECT_MATERIAL].count, COUNT);
    for (size_t i = 0; i < COUNT; ++i) {
        const air_record *a = saved_record(f.scene, AIR_OBJECT_MATERIAL, i);
        const air_record *b = saved_record(f.again, AIR_OBJECT_MATERIAL, i);
        assert_string_equal(a->name, b->name);
        assert_true(air_material_equal(&((const air_material_record *)a)->desc,
                                       &((const air_material_record *)b)->desc));
    }
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

static void textures_of_bytes_stay_as_they_are(void **state)
{
    (void)state;
    saved_fixture f;
    uint8_t bytes[4 * 3 * 4];
    air_handle handles[8];
    air_rng random = air_rng_from_keys(7, 8);
    saved_init(&f);
    for (size_t i = 0; i < sizeof bytes; ++i)
        bytes[i] = (uint8_t)saved_random_between(&random, 0.0f, 256.0f);
    for (size_t i = 0; i < 8; ++i) {
        const air_texture_desc desc = {.name = "picture",
                                       .width = 4,
                                       .height = 3,
                                       .channels = i % 4 + 1,
                                       .bytes = bytes,
                                       .srgb = i < 4,
                                       .wrap_u = (air_wrap)(i % 3),
                                       .wrap_v = (air_wrap)((i + 1) % 3),
                                       .filter = (air_filter_kind)(i % 2)};
        handles[i] = saved_add_texture(&f, &desc);
    }
    for (size_t i = 0; i < 4; ++i) {
        air_material_desc desc;
        air_material_desc_default(&desc);
        desc.base_color_texture.texture = handles[i];
        desc.base_color_texture.uv_set = i % 2;
        desc.metallic_roughness_texture.texture = handles[4 + i];
        desc.normal_texture.texture = handles[7 - i];
        desc.normal_scale = 0.3f;
        const float map[6] = {2.5f, 0.0f, 0.1f, 0.0f, -0.7f, -3.0f};
        memcpy(desc.metallic_roughness_texture.uv_transform, map, sizeof map);
        saved_show_material(&f, &desc);
    }
    saved_round(&f);
    for (size_t i = 0; i < 4; ++i) {
        const air_material_desc *again = saved_material_again(&f, i);
        const air_material_desc *before =
            &((const air_material_record *)saved_record(f.scene, AIR_OBJECT_MATERIAL, i))->desc;
        saved_same_texture(saved_texture(f.scene, handles[i]),
                           saved_texture(f.again, again->base_color_texture.texture));
        saved_same_texture(saved_texture(f.scene, handles[4 + i]),
                           saved_texture(f.again, again->metallic_roughness_texture.texture));
        saved_same_texture(saved_texture(f.scene, handles[7 - i]),
                           saved_texture(f.again, again->normal_texture.texture));
        assert_int_equal(again->base_color_texture.uv_set, i % 2);
        assert_true(again->normal_scale == before->normal_scale);
        for (size_t k = 0; k < 6; ++k)
            assert_true(again->metallic_roughness_texture.uv_transform[k] ==
                        before->metallic_roughness_texture.uv_transform[k]);
    }
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

/* A rotation is one angle in the file: sine and cosine come back within the rounding of the angle
 * and of themselves, 2^-23 in all for angles below pi, times the scale. */
static void maps_of_coordinates_may_turn_and_mirror(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(10, 11);
    const uint8_t byte = 200;
    const air_texture_desc texture = {.width = 1, .height = 1, .channels = 1, .bytes = &byte};
    saved_init(&f);
    const air_handle handle = saved_add_texture(&f, &texture);
    enum { COUNT = 50 };
    float maps[COUNT][6];
    for (size_t i = 0; i < COUNT; ++i) {
        const float angle = saved_random_between(&random, -3.1f, 3.1f);
        const float sx = saved_random_between(&random, 0.1f, 4.0f);
        const float sy = saved_random_between(&random, -4.0f, 4.0f);
        const float map[6] = {
            cosf(angle) * sx,  sinf(angle) * sy, saved_random_between(&random, -1, 1),
            -sinf(angle) * sx, cosf(angle) * sy, saved_random_between(&random, -1, 1)};
        air_material_desc desc;
        air_material_desc_default(&desc);
        desc.normal_texture.texture = handle;
        memcpy(maps[i], map, sizeof map);
        memcpy(desc.normal_texture.uv_transform, map, sizeof map);
        saved_show_material(&f, &desc);
    }
    saved_round(&f);
    for (size_t i = 0; i < COUNT; ++i)
        for (size_t k = 0; k < 6; ++k)
            assert_true(fabsf(saved_material_again(&f, i)->normal_texture.uv_transform[k] -
                              maps[i][k]) < 4.0f * 4.0f * 0x1p-23f);
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

/* Floats become bytes: within half a step of 1/255 times the greatest slope of the sRGB curve, 2.4
 * / 1.055 at white: 0.0045. Emission above 1 goes into the strength. */
static void float_textures_are_rounded_with_a_warning(void **state)
{
    (void)state;
    saved_fixture f;
    float floats[16 * 3];
    air_rng random = air_rng_from_keys(13, 14);
    saved_init(&f);
    for (size_t i = 0; i < 16 * 3; ++i)
        floats[i] = saved_random_between(&random, 0.0f, 8.0f);
    floats[5] = 8.0f;
    const air_texture_desc texture = {
        .name = "glow", .width = 16, .height = 1, .channels = 3, .floats = floats};
    air_material_desc desc;
    air_material_desc_default(&desc);
    desc.emission[0] = 2.0f;
    desc.emission[1] = desc.emission[2] = 1.0f;
    desc.emission_texture.texture = saved_add_texture(&f, &texture);
    saved_show_material(&f, &desc);
    saved_round(&f);
    saved_expect_warning(&f, "texture \"glow\": rounded to 8 bits");
    assert_null(strstr(f.said[AIR_MESSAGE_WARNING], "cut off"));
    const air_material_desc *again = saved_material_again(&f, 0);
    for (size_t i = 0; i < 16; ++i) {
        float rgba[4];
        air_texture_texel(saved_texture(f.again, again->emission_texture.texture), i, 0, rgba);
        for (size_t c = 0; c < 3; ++c)
            assert_true(fabsf(again->emission[c] * rgba[c] - desc.emission[c] * floats[3 * i + c]) <
                        0.0046f * 8.0f * desc.emission[c]);
    }
    saved_finish(&f);
}

/* ---- shapes ---- */

/* Exact shapes come back as such; other programs see triangles, whose corners lie on them. */
static void shapes_stay_exact(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(34, 35);
    saved_init(&f);
    for (size_t i = 0; i < 6; ++i) {
        static const char *const names[] = {"sphere", "cylinder", "disk"};
        air_mesh_desc mesh;
        air_mesh_desc_default(&mesh);
        mesh.name = names[i % 3];
        mesh.shape = (air_shape)(AIR_SHAPE_SPHERE + i % 3);
        mesh.flip_normals = i >= 3;
        const float scale = saved_random_between(&random, 0.1f, 5.0f);
        for (size_t k = 0; k < 3; ++k) {
            mesh.to_world[5 * k] = k == 0 && i % 2 == 0 ? -scale : scale;
            mesh.to_world[4 * k + 3] = saved_random_between(&random, -5.0f, 5.0f);
        }
        saved_add_mesh(&f, &mesh);
    }
    saved_round(&f);
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_same_pictures(f.scene, f.again);
    saved_finish(&f);
}

/* The volume inside triangles by the divergence theorem. Of a ball cut into n = 64 parts around and
 * 32 from pole to pole they miss a share: the chord of an arc of angle a lies a^2 / 24 of the
 * radius inside on average, a^2 / 12 of the radius' square; a = 2 pi / 64 for both, and there are
 * two directions, of which the first shrinks two axes. It is between 0.2 and 0.5 %, and positive,
 * for fronts are outside. */
static void a_sheared_sphere_becomes_triangles(void **state)
{
    (void)state;
    saved_fixture f;
    saved_init(&f);
    air_mesh_desc mesh;
    air_mesh_desc_default(&mesh);
    mesh.name = "egg";
    mesh.shape = AIR_SHAPE_SPHERE;
    const float map[12] = {-1.0f, 0.5f, 0, 3, 0, 2.0f, 0, 0, 0, 0.3f, 1.0f, 0};
    memcpy(mesh.to_world, map, sizeof map);
    saved_add_mesh(&f, &mesh);
    saved_round(&f);
    saved_expect_warning(&f, "sphere \"egg\" is sheared and became triangles");
    const air_geometry *triangles =
        ((const air_mesh_record *)saved_record(f.again, AIR_OBJECT_MESH, 0))->geometry;
    double volume = 0.0;
    for (size_t t = 0; t < triangles->triangle_count; ++t) {
        air_vec3 corner[3];
        for (size_t c = 0; c < 3; ++c)
            corner[c] = vec3_load(triangles->positions + 3 * (size_t)triangles->indices[3 * t + c]);
        volume += (double)vec3_dot(corner[0], vec3_cross(corner[1], corner[2])) / 6.0;
    }
    const double exact = 4.0 / 3.0 * AIR_PI * 2.0;
    assert_true(volume > 0.995 * exact && volume < 0.998 * exact);
    assert_int_equal(triangles->triangle_count, 2 * 64 * 32 - 2 * 64);
    saved_finish(&f);
}

/* Fronts of triangles are said by the order of their corners. */
static void flipped_triangles_are_turned(void **state)
{
    (void)state;
    saved_fixture f;
    const float up[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    saved_init(&f);
    air_mesh_desc mesh = saved_square_mesh("turned");
    mesh.normals = up;
    mesh.flip_normals = true;
    saved_add_mesh(&f, &mesh);
    saved_round(&f);
    const air_geometry *again =
        ((const air_mesh_record *)saved_record(f.again, AIR_OBJECT_MESH, 0))->geometry;
    assert_int_equal(again->indices[1], saved_square_indices[2]);
    assert_int_equal(again->indices[2], saved_square_indices[1]);
    assert_true(again->normals[2] == -1.0f);
    saved_finish(&f);
}

/* ---- cameras ---- */

static void cameras_stay_where_they_are(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(22, 23);
    saved_init(&f);
    const air_mesh_desc mesh = saved_square_mesh("wall");
    saved_add_mesh(&f, &mesh);
    for (size_t i = 0; i < 60; ++i) {
        air_camera_desc desc;
        char name[16];
        air_handle handle = AIR_NONE;
        float axis[3];
        snprintf(name, sizeof name, "c%zu", i);
        air_camera_desc_default(&desc);
        desc.name = name;
        desc.kind = (air_camera_kind)(i % 2);
        saved_random_direction(&random, axis);
        const air_frame frame = frame_from_normal(vec3_load(axis));
        const float length = saved_random_between(&random, 0.5f, 2.0f);
        for (size_t row = 0; row < 3; ++row) {
            desc.to_world[4 * row] = (&frame.s.x)[row] * length;
            desc.to_world[4 * row + 1] = (&frame.t.x)[row] * length;
            desc.to_world[4 * row + 2] = (&frame.n.x)[row] * length;
            desc.to_world[4 * row + 3] = saved_random_between(&random, -10.0f, 10.0f);
        }
        desc.fov_y_rad = saved_random_between(&random, 0.1f, 3.0f);
        desc.half_height = saved_random_between(&random, 0.1f, 30.0f);
        desc.aspect = saved_random_between(&random, 0.2f, 5.0f);
        desc.lens_radius = i % 4 == 0 ? 0.03f : 0.0f;
        desc.focus_distance = i % 4 == 0 ? 7.7f : 1.0f;
        desc.near_distance = i % 3 == 0 ? 0.7f : 0.0f;
        desc.mirrored = i % 2 == 0;
        if (i % 3 == 0)
            desc.film = (air_film_hint){.known = true,
                                        .width = 640,
                                        .height = 480,
                                        .crop = {10, 20, 630, 480},
                                        .samples = 77,
                                        .filter = (air_filter)(i % 5),
                                        .filter_radius = 1.3f};
        assert_int_equal(air_scene_add_camera(f.scene, &desc, &handle), AIR_OK);
    }
    saved_round(&f);
    saved_same_pictures(f.scene, f.again);
    for (size_t i = 0; i < 60; ++i) {
        air_camera_desc a =
            ((const air_camera_record *)saved_record(f.scene, AIR_OBJECT_CAMERA, i))->desc;
        const air_camera_desc b =
            ((const air_camera_record *)saved_record(f.again, AIR_OBJECT_CAMERA, i))->desc;
        if (a.kind == AIR_CAMERA_ORTHOGRAPHIC) { /* its aspect is a quotient: two roundings */
            assert_true(fabsf(b.aspect / a.aspect - 1.0f) <= 0x1p-22f);
            a.aspect = b.aspect;
        }
        assert_true(air_camera_equal(&a, &b));
    }
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

/* ---- what is not glTF's ---- */

static void fill_model(air_rng *random, air_material_model model, air_material_desc *desc)
{
    air_material_desc_default(desc);
    desc->model = model;
    desc->microfacets = model % 2 == 0 ? AIR_MICROFACETS_BECKMANN : AIR_MICROFACETS_GGX;
    desc->alpha_u = saved_random_between(random, 0.0f, 0.5f);
    desc->alpha_v = saved_random_between(random, 0.0f, 0.5f);
    desc->ior = saved_random_between(random, 1.1f, 2.0f);
    for (size_t i = 0; i < 3; ++i) {
        desc->base_color[i] = saved_random_between(random, 0.0f, 1.0f);
        desc->reflectance[i] = saved_random_between(random, 0.0f, 1.0f);
        desc->transmittance[i] = saved_random_between(random, 0.0f, 1.0f);
        desc->eta[i] = saved_random_between(random, 0.1f, 3.0f);
        desc->absorption[i] = saved_random_between(random, 0.0f, 5.0f);
    }
    desc->nonlinear = true;
    desc->one_sided = true;
}

static void same_facets(const air_material_desc *a, const air_material_desc *b)
{
    assert_int_equal(a->microfacets, b->microfacets);
    assert_true(a->alpha_u == b->alpha_u && a->alpha_v == b->alpha_v);
    assert_memory_equal(a->reflectance, b->reflectance, sizeof a->reflectance);
    if (a->model == AIR_MATERIAL_CONDUCTOR) {
        assert_memory_equal(a->eta, b->eta, sizeof a->eta);
        assert_memory_equal(a->absorption, b->absorption, sizeof a->absorption);
        return;
    }
    assert_true(a->ior == b->ior);
    assert_memory_equal(a->transmittance, b->transmittance, sizeof a->transmittance);
    if (a->model == AIR_MATERIAL_PLASTIC) {
        assert_true(b->nonlinear);
        assert_memory_equal(a->base_color, b->base_color, sizeof a->base_color);
    }
}

static void other_models_are_read_as_they_were(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(38, 39);
    const uint8_t byte = 77;
    const air_texture_desc texture = {.width = 1, .height = 1, .channels = 1, .bytes = &byte};
    air_material_desc descs[AIR_MATERIAL_NULL + 1];
    saved_init(&f);
    const air_handle handle = saved_add_texture(&f, &texture);
    for (size_t i = 0; i <= AIR_MATERIAL_NULL; ++i) {
        fill_model(&random, (air_material_model)i, &descs[i]);
        descs[i].bump_texture = descs[i].base_color_texture;
        descs[i].bump_texture.texture = i % 2 == 0 ? handle : AIR_NONE;
        descs[i].bump_scale = 0.02f;
        if (i == AIR_MATERIAL_BLEND) {
            descs[i].blend[0] = f.scene->lists[AIR_OBJECT_MATERIAL].slots[3].handle;
            descs[i].blend[1] = f.scene->lists[AIR_OBJECT_MATERIAL].slots[1].handle;
            descs[i].blend_weight = 0.3f;
            descs[i].blend_texture = descs[i].base_color_texture;
            descs[i].blend_texture.texture = handle;
        }
        saved_show_material(&f, &descs[i]);
    }
    saved_round(&f);
    for (size_t i = 0; i <= AIR_MATERIAL_NULL; ++i) {
        const air_material_desc *again = saved_material_again(&f, i);
        assert_int_equal(again->model, i);
        assert_true(again->one_sided);
        assert_int_equal(again->bump_texture.texture != AIR_NONE, i % 2 == 0);
        if (i % 2 == 0)
            assert_true(again->bump_scale == 0.02f);
        if (i >= AIR_MATERIAL_DIELECTRIC && i <= AIR_MATERIAL_PLASTIC)
            same_facets(&descs[i], again);
        if (i == AIR_MATERIAL_BLEND) {
            assert_int_equal(again->blend[0], f.again->lists[AIR_OBJECT_MATERIAL].slots[3].handle);
            assert_int_equal(again->blend[1], f.again->lists[AIR_OBJECT_MATERIAL].slots[1].handle);
            assert_true(again->blend_weight == 0.3f && again->blend_texture.texture != AIR_NONE);
        }
    }
    saved_finish(&f);
}

/* What programs see that do not know the airlight object: gold by its reflectance, ((eta-1)^2 +
 * k^2) / ((eta+1)^2 + k^2) = 9.64 / 10.44, with glTF's roughness, the root of the slopes' width. */
static void other_programs_see_what_is_nearest(void **state)
{
    (void)state;
    air_export self = {0};
    air_material_desc desc, out;
    air_material_desc_default(&desc);
    desc.model = AIR_MATERIAL_CONDUCTOR;
    desc.alpha_u = desc.alpha_v = 0.25f;
    for (size_t i = 0; i < 3; ++i) {
        desc.reflectance[i] = 1.0f;
        desc.eta[i] = 0.2f;
        desc.absorption[i] = 3.0f;
    }
    air_export_nearest_material(&self, &desc, &out);
    assert_int_equal(out.model, AIR_MATERIAL_METALLIC_ROUGHNESS);
    assert_true(out.metallic == 1.0f && out.roughness == 0.5f);
    assert_true(fabsf(out.base_color[0] - 9.64f / 10.44f) < 1e-6f);
}

/* The clipping plane that other programs see is the near distance, where a camera has one. */
static void cameras_clip_where_rays_begin(void **state)
{
    (void)state;
    static const char *const planes[] = {"\"znear\":0.01", "\"znear\":0.25"};
    for (size_t i = 0; i < 2; ++i) {
        saved_fixture f;
        char text[4096];
        air_camera_desc desc;
        air_handle handle = AIR_NONE;
        saved_init(&f);
        air_camera_desc_default(&desc);
        desc.near_distance = i == 1 ? 0.25f : 0.0f;
        assert_int_equal(air_scene_add_camera(f.scene, &desc, &handle), AIR_OK);
        saved_round(&f);
        FILE *file = fopen(f.path, "rb");
        assert_non_null(file);
        const size_t header = 20, size = fread(text, 1, sizeof text - 1, file);
        fclose(file);
        assert_true(size > header);
        text[size] = '\0';
        assert_non_null(strstr(text + header, planes[i]));
        saved_finish(&f);
    }
}

/* The red of an opacity texture becomes the alpha of the base colour's, texel by texel. */
static void opacity_becomes_alpha(void **state)
{
    (void)state;
    saved_fixture f;
    const uint8_t colors[2 * 3] = {10, 20, 30, 200, 100, 0}, covered[2] = {51, 255};
    const air_texture_desc color = {
        .width = 2, .height = 1, .channels = 3, .bytes = colors, .srgb = true};
    const air_texture_desc opacity = {.width = 2, .height = 1, .channels = 1, .bytes = covered};
    air_material_desc desc;
    saved_init(&f);
    air_material_desc_default(&desc);
    desc.opacity_texture = desc.base_color_texture;
    desc.opacity_texture.texture = saved_add_texture(&f, &opacity);
    saved_show_material(&f, &desc);
    desc.base_color_texture.texture = saved_add_texture(&f, &color);
    saved_show_material(&f, &desc);
    saved_round(&f);
    for (size_t i = 0; i < 2; ++i) {
        const air_texture *again =
            saved_texture(f.again, saved_material_again(&f, i)->base_color_texture.texture);
        assert_int_equal(again->channels, 4);
        for (size_t texel = 0; texel < 2; ++texel) {
            assert_int_equal(again->bytes[4 * texel + 3], covered[texel]);
            for (size_t c = 0; c < 3; ++c)
                assert_int_equal(again->bytes[4 * texel + c], i == 0 ? 255 : colors[3 * texel + c]);
        }
    }
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

/* ---- files ---- */

static void a_sidecar_in_the_way_is_refused(void **state)
{
    (void)state;
    saved_fixture f;
    char path[96];
    saved_init(&f);
    snprintf(path, sizeof path, "%s/saved.airlight.json", f.folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(air_scene_save(f.context, f.scene, f.path), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(f.said[AIR_MESSAGE_ERROR], "saved.airlight.json"));
    assert_int_equal(access(f.path, F_OK), -1);
    assert_int_equal(air_scene_save(f.context, f.scene, "saved.gltf"), AIR_ERROR_UNSUPPORTED);
    assert_int_equal(air_scene_save(f.context, NULL, f.path), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_save(f.context, f.scene, NULL), AIR_ERROR_ARGUMENT);
    saved_finish(&f);
}

static void an_empty_scene_is_a_file(void **state)
{
    (void)state;
    saved_fixture f;
    saved_init(&f);
    saved_round(&f);
    assert_int_equal(f.again->lists[AIR_OBJECT_MESH].count, 0);
    saved_finish(&f);
}

/* With each allocation failing in turn: an error, nothing kept, nothing written. */
static void every_allocation_may_fail(void **state)
{
    (void)state;
    saved_fixture f;
    static const float tetrahedron[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const float sheared[12] = {-1, 0.5f, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float straight[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float floats[6] = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
    air_rng random = air_rng_from_keys(31, 32);
    const air_texture_desc texture = {.width = 2, .height = 1, .channels = 3, .floats = floats};
    air_material_desc material;
    air_light_desc light;
    air_medium_desc medium;
    saved_init(&f);
    air_material_desc_default(&material);
    material.base_color_texture.texture = saved_add_texture(&f, &texture);
    air_mesh_desc mesh = saved_square_mesh("wall");
    mesh.material = saved_add_material(&f, &material);
    memcpy(mesh.to_world, sheared, sizeof sheared);
    saved_add_mesh(&f, &mesh);
    air_mesh_desc_default(&mesh);
    mesh.shape = AIR_SHAPE_DISK;
    mesh.flip_normals = true;
    saved_add_mesh(&f, &mesh);
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    light.image = material.base_color_texture.texture;
    saved_add_light(&f, &light);
    air_medium_desc_default(&medium);
    medium.name = "smoke";
    medium.sigma_s[0] = 1.0f;
    medium.density.kind = AIR_DENSITY_GRID;
    medium.density.grid = saved_add_grid(&f, &random, 1, straight);
    medium.boundary = (air_boundary){.kind = AIR_BOUNDARY_MESH,
                                     .positions = tetrahedron,
                                     .vertex_count = 4,
                                     .indices = faces,
                                     .triangle_count = 4};
    saved_add_medium(&f, &medium);
    air_status status = AIR_ERROR_MEMORY;
    long count = 0;
    for (; status != AIR_OK; ++count) {
        const long live = atomic_load(&f.allocator.live);
        assert_true(count < 10000);
        memset(f.said, 0, sizeof f.said);
        atomic_store(&f.allocator.remaining, count);
        status = air_scene_save(f.context, f.scene, f.path);
        atomic_store(&f.allocator.remaining, SAVED_MANY);
        if (status == AIR_OK)
            break;
        assert_int_equal(status, AIR_ERROR_MEMORY);
        assert_int_equal(access(f.path, F_OK), -1);
        /* a mesh may have been placed in the world meanwhile, which its scene keeps: four blocks
         * and its name */
        assert_true(atomic_load(&f.allocator.live) <= live + 5);
    }
    print_message("%ld allocations\n", count);
    saved_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_keep_their_arrays_and_their_place),
        cmocka_unit_test(sheared_and_mirrored_meshes_are_written_where_they_are),
        cmocka_unit_test(equal_arrays_are_written_once),
        cmocka_unit_test(materials_keep_their_numbers),
        cmocka_unit_test(textures_of_bytes_stay_as_they_are),
        cmocka_unit_test(maps_of_coordinates_may_turn_and_mirror),
        cmocka_unit_test(float_textures_are_rounded_with_a_warning),
        cmocka_unit_test(shapes_stay_exact),
        cmocka_unit_test(a_sheared_sphere_becomes_triangles),
        cmocka_unit_test(flipped_triangles_are_turned),
        cmocka_unit_test(cameras_stay_where_they_are),
        cmocka_unit_test(cameras_clip_where_rays_begin),
        cmocka_unit_test(other_models_are_read_as_they_were),
        cmocka_unit_test(other_programs_see_what_is_nearest),
        cmocka_unit_test(opacity_becomes_alpha),
        cmocka_unit_test(a_sidecar_in_the_way_is_refused),
        cmocka_unit_test(an_empty_scene_is_a_file),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

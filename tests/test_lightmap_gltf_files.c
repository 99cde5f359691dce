/* Copies of glTF scenes that show their lightmap: files, whole scenes, and what is refused. */
#include <errno.h>
#include <jansson.h>
#include <signal.h>
#include <sys/resource.h>

#include "lightmap_gltf_scene.h"

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
        scene_save(self, lightmap, names[i], NULL);
        scene_loaded copy = scene_load(self, names[i]);
        const air_mesh *right = scene_find_mesh(&copy, "right");
        assert_int_equal(right->vertex_count, 6);
        assert_memory_equal(right->uv[1], scene_cut_uv, sizeof scene_cut_uv);
        assert_non_null(copy.snapshot->materials[right->material].emission_slot.texture);
        scene_unload(&copy);
    }
    assert_int_equal(lightmap_count_files(lightmap_path(self, "other")), 4);
    assert_int_equal(access(lightmap_path(self, "other/my room-lightmap-1.png"), F_OK), 0);
    air_lightmap_destroy(lightmap);
}

static void a_full_disk_leaves_the_older_copy(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    scene_save(self, lightmap, "out/lit.gltf", NULL);
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
    scene_save(self, lightmap, "lit.glb", NULL);
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
    scene_loaded copy = scene_load(self, "box.glb"), source = {0};
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
    scene_unload(&source);
    scene_unload(&copy);
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
        json_t *mesh = mesh_at == NULL
                           ? NULL
                           : scene_item(root, "meshes", (size_t)json_integer_value(mesh_at));
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
    scene_loaded source = {0};
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
    scene_loaded copy = scene_load(self, "room.glb");
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
    scene_unload(&copy);
    scene_unload(&source);
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, lightmap_start, lightmap_finish)
    const struct CMUnitTest tests[] = {
        TEST(all_kinds_of_buffers_and_copies_mean_the_same),
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

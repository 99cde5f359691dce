/* The frame of a glTF file: container, JSON, version, extensions, hierarchy, scenes, resources. */
#include <math.h>

#include "import_fixture.h"
#include "scene/import/resource.h"

#define ROOM "{" GLTF_SCENE ",'nodes':[{'mesh':0}]," GLTF_TRIANGLE "}"

static void a_triangle_with_embedded_data_loads_without_a_word(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, ROOM);
    assert_int_equal(f.snapshot->mesh_count, 1);
    assert_int_equal(f.snapshot->triangle_count, 1);
    const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    assert_memory_equal(f.snapshot->meshes[0]->positions, expected, sizeof expected);
    assert_string_equal(f.snapshot->source, "room.gltf");
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_expect_silence(&f, AIR_MESSAGE_ERROR);
    import_finish(&f);
}

static void a_missing_file_is_named(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    assert_int_equal(air_scene_load(f.context, "absent.glb", NULL, &f.scene), AIR_ERROR_IO);
    assert_null(f.scene);
    import_expect(&f, AIR_MESSAGE_ERROR, "absent.glb");
    import_finish(&f);
}

static void arguments_are_checked(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    assert_int_equal(air_scene_load(f.context, NULL, NULL, &f.scene), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_load(f.context, "room.gltf", NULL, NULL), AIR_ERROR_ARGUMENT);
    import_finish(&f);
}

static void what_is_not_gltf_is_refused_with_its_place(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    assert_int_equal(import_text(&f, "{\n 'asset': }"), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.gltf: $: not valid JSON at line 2, column 1");
    import_refuses(
        &f, "<scene version='3.0.0'/>", AIR_ERROR_FORMAT,
        "room.gltf: byte 0: expected a glTF file, which is JSON text or begins with \"glTF\"");
    import_refuses(
        &f, "", AIR_ERROR_FORMAT,
        "room.gltf: byte 0: expected a glTF file, which is JSON text or begins with \"glTF\"");
    import_refuses(&f, "[]", AIR_ERROR_FORMAT,
                   "room.gltf: $: expected an object, found an array of 0");
    import_refuses(&f, "{}", AIR_ERROR_FORMAT,
                   "room.gltf: $.asset: expected an object, found nothing");
    import_refuses(&f, "{'asset':{'version':'1.0'}}", AIR_ERROR_FORMAT,
                   "room.gltf: $.asset.version: expected glTF version \"2.0\", found \"1.0\"");
    import_refuses(
        &f, "{'asset':{'version':'2.1','minVersion':'2.1'}}", AIR_ERROR_FORMAT,
        "room.gltf: $.asset.minVersion: expected at most glTF version \"2.0\", found \"2.1\"");
    import_refuses(&f, "{" GLTF_ASSET ",'nodes':{}}", AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes: expected an array, found an object");
    import_finish(&f);
}

/* ---- extensions ---- */

static void a_required_extension_that_is_not_supported_is_named(void **state)
{
    (void)state;
    static const char *const names[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                        "KHR_texture_basisu", "KHR_materials_clearcoat",
                                        "ACME_anything"};
    import_fixture f;
    import_init(&f);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char message[256];
        snprintf(message, sizeof message,
                 "room.gltf: $.extensionsRequired[1]: the file requires the extension %s, which is "
                 "not supported",
                 names[i]);
        assert_int_equal(
            import_format(&f, "{" GLTF_ASSET ",'extensionsRequired':['KHR_lights_punctual','%s']}",
                          names[i]),
            AIR_ERROR_UNSUPPORTED);
        import_expect(&f, AIR_MESSAGE_ERROR, message);
    }
    import_finish(&f);
}

static void a_used_extension_that_is_not_supported_gives_one_warning(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, "{" GLTF_ASSET
                     ",'extensionsUsed':['KHR_materials_sheen','KHR_materials_unlit','ACME_x',"
                     "'KHR_xmp_json_ld'],'nodes':[{'mesh':0}]," GLTF_TRIANGLE "}");
    assert_string_equal(f.said[AIR_MESSAGE_WARNING],
                        "room.gltf: the extension KHR_materials_sheen is not supported: "
                        "the sheen is left out\n"
                        "room.gltf: the extension ACME_x is not known and left out\n");
    assert_int_equal(f.snapshot->warning_count, 2);
    import_finish(&f);
}

/* ---- GLB ---- */

static size_t put_u32(uint8_t *out, size_t at, uint32_t value)
{
    for (size_t i = 0; i < 4; ++i)
        out[at + i] = (uint8_t)(value >> (8 * i));
    return at + 4;
}

/* A GLB file of a JSON text and a binary chunk (NULL: none). Returns its size. */
static size_t make_glb(uint8_t *out, const char *json, const void *chunk, size_t chunk_size)
{
    char text[FIXTURE_TEXT];
    strcpy(text, json);
    import_quotes(text);
    while (strlen(text) % 4 != 0)
        strcat(text, " ");
    const size_t length = strlen(text);
    put_u32(out, 0, 0x46546C67);
    put_u32(out, 4, 2);
    put_u32(out, 12, (uint32_t)length);
    put_u32(out, 16, 0x4E4F534A);
    memcpy(out + 20, text, length);
    size_t end = 20 + length;
    if (chunk != NULL) {
        end = put_u32(out, end, (uint32_t)chunk_size);
        end = put_u32(out, end, 0x004E4942);
        memcpy(out + end, chunk, chunk_size);
        end += chunk_size;
    }
    put_u32(out, 8, (uint32_t)end);
    return end;
}

static const char glb_json[] =
    "{" GLTF_SCENE
    ",'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"
    "'buffers':[{'byteLength':36}],'bufferViews':[{'buffer':0,'byteLength':36}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]} ";

static const float glb_positions[9] = {0, 0, 0, 2, 0, 0, 0, 2, 0};

static air_status load_bytes(import_fixture *f, const uint8_t *bytes, size_t size)
{
    import_reset(f);
    import_serve(f, "room.glb", bytes, size);
    const air_status status = air_scene_load(f->context, "room.glb", NULL, &f->scene);
    return status == AIR_OK ? air_scene_commit(f->scene, &f->snapshot, NULL) : status;
}

static void a_glb_file_gives_its_binary_chunk_to_buffer_0(void **state)
{
    (void)state;
    import_fixture f;
    uint8_t bytes[4096];
    import_init(&f);
    const size_t size = make_glb(bytes, glb_json, glb_positions, sizeof glb_positions);
    assert_int_equal(load_bytes(&f, bytes, size), AIR_OK);
    assert_memory_equal(f.snapshot->meshes[0]->positions, glb_positions, sizeof glb_positions);
    /* bytes behind the stated length do not count */
    put_u32(bytes, size, 0xffffffffu);
    assert_int_equal(load_bytes(&f, bytes, size + 4), AIR_OK);
    import_finish(&f);
}

static void json_chunks_may_be_padded_with_zeros(void **state)
{
    (void)state;
    import_fixture f;
    uint8_t bytes[4096];
    import_init(&f);
    const size_t size = make_glb(bytes, glb_json, glb_positions, sizeof glb_positions);
    size_t end = 20 + bytes[12] + 256u * bytes[13];
    assert_int_equal(bytes[end - 1], ' ');
    for (; bytes[end - 1] == ' '; --end)
        bytes[end - 1] = '\0';
    assert_int_equal(load_bytes(&f, bytes, size), AIR_OK);
    import_finish(&f);
}

static void a_glb_file_cut_anywhere_is_refused(void **state)
{
    (void)state;
    import_fixture f;
    uint8_t bytes[4096];
    import_init(&f);
    const size_t size = make_glb(bytes, glb_json, glb_positions, sizeof glb_positions);
    for (size_t cut = 0; cut < size; ++cut)
        assert_int_not_equal(load_bytes(&f, bytes, cut), AIR_OK);
    import_finish(&f);
}

static void glb_errors_name_the_byte(void **state)
{
    (void)state;
    import_fixture f;
    uint8_t bytes[4096];
    import_init(&f);
    size_t size = make_glb(bytes, glb_json, NULL, 0);
    assert_int_equal(load_bytes(&f, bytes, size), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR,
                  "room.glb: $.buffers[0].uri: expected a URI: the file has no binary chunk");
    assert_int_equal(load_bytes(&f, bytes, size - 1), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.glb: byte 8: the GLB header states");
    put_u32(bytes, 12, 4000);
    assert_int_equal(load_bytes(&f, bytes, size), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.glb: byte 12: the GLB chunk states 4000 bytes");
    put_u32(bytes, 4, 1);
    assert_int_equal(load_bytes(&f, bytes, size), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.glb: byte 4: expected a GLB header of version 2");
    size = make_glb(bytes, glb_json, NULL, 0);
    put_u32(bytes, 16, 0x12345678);
    assert_int_equal(load_bytes(&f, bytes, size), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.glb: byte 12: expected a JSON chunk");
    import_finish(&f);
}

/* ---- buffers ---- */

#define EXTERNAL(uri)                                                                              \
    "{" GLTF_SCENE                                                                                 \
    ",'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"             \
    "'buffers':[{'byteLength':36,'uri':'" uri "'}],'bufferViews':[{'buffer':0,'byteLength':36}],"  \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]}"

static void external_buffers_lie_beside_the_scene(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    char text[] = EXTERNAL("../my%20data/%6dain.bin");
    import_quotes(text);
    import_serve(&f, "scenes/a/room.gltf", text, strlen(text));
    import_serve(&f, "scenes/a/../my data/main.bin", glb_positions, sizeof glb_positions);
    assert_int_equal(air_scene_load(f.context, "scenes/a/room.gltf", NULL, &f.scene), AIR_OK);
    import_finish(&f);
}

static void bad_buffers_are_refused_with_their_place(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    assert_int_equal(import_text(&f, EXTERNAL("gone.bin")), AIR_ERROR_IO);
    import_expect(&f, AIR_MESSAGE_ERROR, "gone.bin");
    import_refuses(
        &f, EXTERNAL("https://example.org/a.bin"), AIR_ERROR_UNSUPPORTED,
        "room.gltf: $.buffers[0].uri: expected a relative path or a data URI, found \"https:...\"");
    import_refuses(&f, EXTERNAL("/etc/passwd"), AIR_ERROR_FORMAT,
                   "room.gltf: $.buffers[0].uri: expected a path relative to the scene file, found "
                   "\"/etc/passwd\"");
    import_refuses(
        &f, EXTERNAL("a%00b"), AIR_ERROR_FORMAT,
        "room.gltf: $.buffers[0].uri: expected a path relative to the scene file, found \"a%00b\"");
    import_refuses(&f, EXTERNAL("data:;base64,AAA*"), AIR_ERROR_FORMAT,
                   "room.gltf: $.buffers[0].uri: expected base64 after the comma of the data URI");
    import_refuses(&f, EXTERNAL("data:AAAA"), AIR_ERROR_FORMAT,
                   "room.gltf: $.buffers[0].uri: expected a comma in the data URI");
    import_serve(&f, "short.bin", glb_positions, 35);
    import_refuses(&f, EXTERNAL("short.bin"), AIR_ERROR_FORMAT,
                   "room.gltf: $.buffers[0].byteLength: 36 bytes are stated, short.bin has 35");
    import_finish(&f);
}

static void base64_is_decoded_with_and_without_padding(void **state)
{
    (void)state;
    static const struct {
        const char *text, *data;
    } cases[] = {{"", ""},        {"Zg==", "f"},      {"Zg", "f"},          {"Zm8=", "fo"},
                 {"Zm9v", "foo"}, {"Zm9vYg", "foob"}, {"Zm9vYmE", "fooba"}, {"Zm9vYmFy", "foobar"}};
    uint8_t out[16];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        assert_int_equal(air_base64_decode(cases[i].text, strlen(cases[i].text), out),
                         strlen(cases[i].data));
        assert_memory_equal(out, cases[i].data, strlen(cases[i].data));
    }
    assert_int_equal(air_base64_decode("+/-_", 4, out), 3);
    assert_memory_equal(out, ((uint8_t[]){0xfb, 0xff, 0xbf}), 3);
    assert_int_equal(air_base64_decode("A", 1, out), SIZE_MAX);
    assert_int_equal(air_base64_decode("A B=", 4, out), SIZE_MAX);
}

/* ---- hierarchy ---- */

static void nodes_multiply_from_the_root_down(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    /* x -> 2x, a quarter turn about +Y (x -> -z), then moved by (10, 0, 0) by a matrix */
    import_loads(&f, "{" GLTF_SCENE
                     ",'nodes':[{'children':[1],'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,10,0,0,1]},"
                     "{'children':[2],'rotation':[0,0.70710678,0,0.70710678]},"
                     "{'mesh':0,'scale':[2,1,1],'translation':[0,0,0]}]," GLTF_TRIANGLE "}");
    const float *p = f.snapshot->meshes[0]->positions;
    const float expected[9] = {10, 0, 0, 10, 0, -2, 10, 1, 0};
    for (size_t i = 0; i < 9; ++i) /* a few roundings of numbers up to 10 */
        assert_true(fabsf(p[i] - expected[i]) < 1e-5f);
    import_finish(&f);
}

static void names_are_those_of_the_nodes(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, "{" GLTF_ASSET
                     ",'nodes':[{'mesh':0,'name':'Wall'},{'mesh':0}],'meshes':[{'name':'Data',"
                     "'primitives':[{'attributes':{'POSITION':0}}]}]," GLTF_TRIANGLE_DATA "}");
    assert_string_equal(f.snapshot->meshes[0]->name, "Wall");
    assert_string_equal(f.snapshot->meshes[1]->name, "Data");
    import_finish(&f);
}

static void cycles_and_shared_nodes_are_refused(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_refuses(&f, "{" GLTF_SCENE ",'nodes':[{'children':[1]},{'children':[0]}]}",
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes[1].children[0]: node 0 is already in the hierarchy: a "
                   "cycle, or two parents");
    import_refuses(&f, "{" GLTF_SCENE ",'nodes':[{'children':[1,2]},{'children':[2]},{}]}",
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes[1].children[0]: node 2 is already in the hierarchy: a "
                   "cycle, or two parents");
    import_refuses(&f, "{" GLTF_SCENE ",'nodes':[{'children':[7]}]}", AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes[0].children[0]: expected the index of a node, of which "
                   "there are 1, found 7");
    import_finish(&f);
}

static void a_very_deep_hierarchy_loads(void **state)
{
    (void)state;
    enum { DEPTH = 200000 };
    import_fixture f;
    import_init(&f);
    const size_t room = (size_t)DEPTH * 24 + 1024;
    char *text = malloc(room);
    size_t used = (size_t)snprintf(text, room, "{" GLTF_SCENE "," GLTF_TRIANGLE ",'nodes':[");
    for (int i = 1; i < DEPTH; ++i)
        used += (size_t)snprintf(text + used, room - used, "{'children':[%d]},", i);
    snprintf(text + used, room - used, "{'mesh':0}]}");
    import_quotes(text);
    import_serve(&f, "deep.gltf", text, strlen(text));
    assert_int_equal(air_scene_load(f.context, "deep.gltf", NULL, &f.scene), AIR_OK);
    free(text);
    import_finish(&f);
}

static void bad_transformations_are_refused(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_refuses(
        &f, "{" GLTF_SCENE ",'nodes':[{'matrix':[1,0,0,0]}]}", AIR_ERROR_FORMAT,
        "room.gltf: $.nodes[0].matrix: expected an array of 16 numbers, found an array of 4");
    import_refuses(&f, "{" GLTF_SCENE ",'nodes':[{'rotation':[0,0,0,0]}]}", AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes[0].rotation: expected a quaternion x, y, z, w that is not "
                   "0, found an array of 4");
    import_refuses(
        &f, "{" GLTF_SCENE ",'nodes':[{'scale':[1,1,1e39]}]}", AIR_ERROR_FORMAT,
        "room.gltf: $.nodes[0].scale[2]: expected a number within single precision, found 1e39");
    import_refuses(&f,
                   "{" GLTF_SCENE ",'nodes':[{'scale':[1e30,1,1],'children':[1]},{'scale':[1e30,1,"
                   "1],'mesh':0}]," GLTF_TRIANGLE "}",
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes[1]: the node's transformation is not finite");
    import_finish(&f);
}

static void a_node_scaled_to_nothing_is_left_out_with_a_warning(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, "{" GLTF_ASSET
                     ",'nodes':[{'mesh':0,'scale':[1,1,0]},{'mesh':0}]," GLTF_TRIANGLE "}");
    assert_int_equal(f.snapshot->mesh_count, 1);
    import_expect(&f, AIR_MESSAGE_WARNING, "nodes with a mesh scaled to nothing and left out: 1");
    import_finish(&f);
}

static void the_scene_asked_for_is_loaded(void **state)
{
    (void)state;
    static const char text[] =
        "{" GLTF_ASSET ",'scene':1,'scenes':[{'nodes':[0]},{'nodes':[0,1]},{}],'nodes':[{'mesh':0},"
        "{'mesh':0}]," GLTF_TRIANGLE "}";
    import_fixture f;
    import_init(&f);
    import_loads(&f, text);
    assert_int_equal(f.snapshot->mesh_count, 2);
    f.params.scene_index = 0;
    import_loads(&f, text);
    assert_int_equal(f.snapshot->mesh_count, 1);
    f.params.scene_index = 2;
    import_loads(&f, text);
    assert_int_equal(f.snapshot->mesh_count, 0);
    f.params.scene_index = 3;
    import_refuses(&f, text, AIR_ERROR_ARGUMENT, "room.gltf: there is no scene 3, the file has 3");
    import_finish(&f);
}

static void without_scenes_all_parentless_nodes_are_shown(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f,
                 "{" GLTF_ASSET
                 ",'nodes':[{'mesh':0},{'mesh':0,'children':[0]},{'mesh':0}]," GLTF_TRIANGLE "}");
    assert_int_equal(f.snapshot->mesh_count, 3);
    import_finish(&f);
}

static void rest_poses_are_announced(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, "{" GLTF_SCENE
                     ",'animations':[{}],'skins':[{'joints':[0]}],'nodes':[{'mesh':0,'skin':0}],"
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':"
                     "0}]}]}]," GLTF_TRIANGLE_DATA "}");
    import_expect(&f, AIR_MESSAGE_WARNING, "skinned meshes shown in their rest pose: 1");
    import_expect(&f, AIR_MESSAGE_WARNING,
                  "primitives with morph targets shown in their rest pose: 1");
    import_expect(&f, AIR_MESSAGE_WARNING, "animations left out, the scene is in its rest pose: 1");
    import_finish(&f);
}

/* Whatever allocation fails, the load says so, frees everything and leaves no scene. */
static void every_failing_allocation_is_survived(void **state)
{
    (void)state;
    static const char text[] =
        "{" GLTF_SCENE
        ",'nodes':[{'mesh':0,'name':'a','extras':{'airlight':{'media':[{'sigma_s':1,'boundary':"
        "{'planes':[[0,1,0,1]]}}],'lights':[{'type':'point','position':[0,1,0],'intensity':1}]}}}],"
        "'materials':[{}]," GLTF_PAINTED_TRIANGLE "}";
    import_fixture f;
    import_init(&f);
    air_status status = AIR_ERROR_MEMORY;
    strcpy(f.text, text);
    import_quotes(f.text);
    import_serve(&f, "room.gltf", f.text, strlen(f.text));
    long allowed = 0;
    for (; status == AIR_ERROR_MEMORY && allowed < 10000; ++allowed) {
        atomic_store(&f.allocator.remaining, allowed);
        status = air_scene_load(f.context, "room.gltf", &f.params, &f.scene);
        assert_true((status == AIR_OK) == (f.scene != NULL));
    }
    atomic_store(&f.allocator.remaining, FIXTURE_MANY);
    assert_int_equal(status, AIR_OK);
    assert_true(allowed > 20); /* it was not the first allocation that mattered */
    import_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_triangle_with_embedded_data_loads_without_a_word),
        cmocka_unit_test(a_missing_file_is_named),
        cmocka_unit_test(arguments_are_checked),
        cmocka_unit_test(what_is_not_gltf_is_refused_with_its_place),
        cmocka_unit_test(a_required_extension_that_is_not_supported_is_named),
        cmocka_unit_test(a_used_extension_that_is_not_supported_gives_one_warning),
        cmocka_unit_test(a_glb_file_gives_its_binary_chunk_to_buffer_0),
        cmocka_unit_test(json_chunks_may_be_padded_with_zeros),
        cmocka_unit_test(a_glb_file_cut_anywhere_is_refused),
        cmocka_unit_test(glb_errors_name_the_byte),
        cmocka_unit_test(external_buffers_lie_beside_the_scene),
        cmocka_unit_test(bad_buffers_are_refused_with_their_place),
        cmocka_unit_test(base64_is_decoded_with_and_without_padding),
        cmocka_unit_test(nodes_multiply_from_the_root_down),
        cmocka_unit_test(names_are_those_of_the_nodes),
        cmocka_unit_test(cycles_and_shared_nodes_are_refused),
        cmocka_unit_test(a_very_deep_hierarchy_loads),
        cmocka_unit_test(bad_transformations_are_refused),
        cmocka_unit_test(a_node_scaled_to_nothing_is_left_out_with_a_warning),
        cmocka_unit_test(the_scene_asked_for_is_loaded),
        cmocka_unit_test(without_scenes_all_parentless_nodes_are_shown),
        cmocka_unit_test(rest_poses_are_announced),
        cmocka_unit_test(every_failing_allocation_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

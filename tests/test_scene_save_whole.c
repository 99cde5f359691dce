/* Whole scenes written as .glb and read again: everything that a picture depends on is the same. */
#include <jansson.h>

#include "saved_scene.h"

static void load(saved_fixture *self, const char *path)
{
    air_scene_destroy(self->scene);
    self->scene = NULL;
    if (air_scene_load(self->context, path, NULL, &self->scene) != AIR_OK)
        fail_msg("%s: %s", path, air_context_last_error(self->context));
}

/* Reading what was written gives no warning. */
static void read_in_silence(saved_fixture *self)
{
    memset(self->said, 0, sizeof self->said);
    saved_read(self);
    assert_string_equal(self->said[AIR_MESSAGE_WARNING], "");
}

static void shipped_scenes_stay_the_same(void **state)
{
    (void)state;
    static const char *const paths[] = {AIR_SOURCE_DIR "/scenes/roombeam/roombeam.gltf",
                                        AIR_SOURCE_DIR "/scenes/sunroom/sunroom.gltf"};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; ++i) {
        saved_fixture f;
        saved_init(&f);
        load(&f, paths[i]);
        saved_round(&f);
        assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
        read_in_silence(&f);
        saved_same_pictures(f.scene, f.again);
        saved_finish(&f);
    }
}

/* Here the sky comes before the fire; in the file lights of glTF are the first. */
static void lights_of_gltf_come_first(void **state)
{
    (void)state;
    saved_fixture f;
    saved_init(&f);
    load(&f, AIR_SOURCE_DIR "/scenes/smoke/smoke.gltf");
    const air_slot_list *lights = &f.scene->lists[AIR_OBJECT_LIGHT];
    const air_handle sky = lights->slots[0].handle;
    air_light_desc desc = ((const air_light_record *)lights->slots[0].record)->desc;
    desc.name = "sky";
    assert_string_equal(lights->slots[0].record->name, desc.name);
    saved_round(&f);
    read_in_silence(&f);
    assert_int_equal(air_scene_remove(f.scene, sky), AIR_OK);
    saved_add_light(&f, &desc);
    saved_same_pictures(f.scene, f.again);
    saved_finish(&f);
}

static void scenes_of_other_people_stay_the_same(void **state)
{
    (void)state;
    static const char *const paths[] = {
        "bevy/CornellBox/CornellBox.glb",
        "bevy/VolumetricFogExample/VolumetricFogExample.glb",
        "geometry/classroom.glb",
        "gltf_blender_io/14_emission_strength/14_emission_strength.gltf",
        "gltf_blender_io/16_volume/16_volume.gltf",
        "gltf_khronos/AttenuationTest/glTF/AttenuationTest.gltf",
        "gltf_khronos/EmissiveStrengthTest/glTF/EmissiveStrengthTest.gltf",
        "gltf_khronos/GlassHurricaneCandleHolder/glTF/GlassHurricaneCandleHolder.gltf",
        "gltf_khronos/LightsPunctualLamp/glTF/LightsPunctualLamp.gltf",
        "gltf_khronos/MultiUVTest/glTF/MultiUVTest.gltf",
        "gltf_nvpro_cornell/cornellBox.gltf",
        "gltf_playcanvas/Lights.glb",
        "gltf_playcanvas/house.glb",
    };
    if (access(AIR_SHARED_DIR "/scenes", F_OK) != 0) {
        print_message("skipped: there is no " AIR_SHARED_DIR "/scenes\n");
        skip();
    }
    for (size_t i = 0; i < sizeof paths / sizeof *paths; ++i) {
        saved_fixture f;
        char path[512];
        saved_init(&f);
        snprintf(path, sizeof path, AIR_SHARED_DIR "/scenes/%s", paths[i]);
        load(&f, path);
        saved_round(&f);
        print_message("%s %s\n", paths[i], f.said[AIR_MESSAGE_WARNING]);
        read_in_silence(&f);
        saved_same_pictures(f.scene, f.again);
        saved_finish(&f);
    }
}

/* ---- the file itself ---- */

static json_int_t integer(const json_t *object, const char *key)
{
    return json_integer_value(json_object_get(object, key));
}

static uint32_t word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* [glTF2, section 3.6.2.4]: accessors begin at multiples of their components' size, here 4, and lie
 * within their view. */
static void check_accessor(const json_t *root, const json_t *accessor, const uint8_t *chunk)
{
    const json_t *view = json_array_get(json_object_get(root, "bufferViews"),
                                        (size_t)integer(accessor, "bufferView"));
    const char *type = json_string_value(json_object_get(accessor, "type"));
    const size_t components = type[0] == 'S' ? 1 : (size_t)(type[3] - '0');
    const size_t count = (size_t)integer(accessor, "count");
    const json_t *low = json_object_get(accessor, "min"), *high = json_object_get(accessor, "max");
    assert_int_equal(integer(view, "byteOffset") % 4, 0);
    assert_int_equal(integer(view, "byteLength"), count * components * 4);
    assert_int_equal(json_array_size(low), json_array_size(high));
    for (size_t c = 0; c < json_array_size(low); ++c) {
        float least = INFINITY, greatest = -INFINITY;
        for (size_t i = 0; i < count; ++i) {
            float value;
            memcpy(&value, chunk + integer(view, "byteOffset") + 4 * (i * components + c), 4);
            least = fminf(least, value);
            greatest = fmaxf(greatest, value);
        }
        assert_true((float)json_number_value(json_array_get(low, c)) == least);
        assert_true((float)json_number_value(json_array_get(high, c)) == greatest);
    }
}

static void check_meshes(const json_t *root)
{
    const json_t *accessors = json_object_get(root, "accessors");
    const json_t *mesh, *primitive, *attribute;
    size_t i, j;
    json_array_foreach(json_object_get(root, "meshes"), i, mesh)
    {
        json_array_foreach(json_object_get(mesh, "primitives"), j, primitive)
        {
            json_t *attributes = json_object_get(primitive, "attributes");
            const json_t *positions =
                json_array_get(accessors, (size_t)integer(attributes, "POSITION"));
            const char *key;
            assert_non_null(json_object_get(positions, "min"));
            json_object_foreach(attributes, key, attribute)
            {
                const json_t *accessor =
                    json_array_get(accessors, (size_t)json_integer_value(attribute));
                assert_int_equal(integer(accessor, "count"), integer(positions, "count"));
                assert_int_equal(integer(accessor, "componentType"), 5126);
            }
            assert_int_equal(
                integer(json_array_get(accessors, (size_t)integer(primitive, "indices")),
                        "componentType"),
                5125);
        }
    }
}

/* [glTF2, section 4.4] */
static void the_file_is_as_the_specification_wants_it(void **state)
{
    (void)state;
    saved_fixture f;
    static uint8_t bytes[1 << 21];
    saved_init(&f);
    load(&f, AIR_SOURCE_DIR "/scenes/sunroom/sunroom.gltf");
    saved_round(&f);
    FILE *file = fopen(f.path, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_true(size < sizeof bytes);
    assert_memory_equal(bytes, "glTF\2\0\0\0", 8);
    assert_int_equal(word(bytes + 8), size);
    const size_t text = word(bytes + 12);
    assert_memory_equal(bytes + 16, "JSON", 4);
    assert_int_equal(text % 4, 0);
    const uint8_t *chunk = bytes + 20 + text;
    assert_memory_equal(chunk + 4, "BIN\0", 4);
    assert_int_equal(word(chunk), size - text - 28);
    assert_int_equal(word(chunk) % 4, 0);
    json_t *root = json_loadb((const char *)bytes + 20, text, 0, NULL);
    assert_non_null(root);
    const json_t *buffers = json_object_get(root, "buffers"), *accessor;
    assert_int_equal(json_array_size(buffers), 1);
    assert_true(word(chunk) - (size_t)integer(json_array_get(buffers, 0), "byteLength") < 4);
    size_t i;
    json_array_foreach(json_object_get(root, "accessors"), i, accessor)
        check_accessor(root, accessor, chunk + 8);
    check_meshes(root);
    json_decref(root);
    saved_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shipped_scenes_stay_the_same),
        cmocka_unit_test(lights_of_gltf_come_first),
        cmocka_unit_test(scenes_of_other_people_stay_the_same),
        cmocka_unit_test(the_file_is_as_the_specification_wants_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

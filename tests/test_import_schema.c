/* What is published about the airlight object: the schema has the keys that the reader knows, the
 * examples load. */
#include <jansson.h>
#include <stdlib.h>

#include "core/host.h"
#include "import_fixture.h"

#define CUBE_ROOM "{" GLTF_SCENE ",'nodes':[{'mesh':0,'name':'Fog'}]," GLTF_CUBE "}"

#define NODE_ROOM                                                                                  \
    "{" GLTF_SCENE ",'nodes':[{'mesh':0,'camera':0,'extras':{'airlight':%s}}],"                    \
    "'cameras':[{'type':'perspective','perspective':{'yfov':1}}]," GLTF_CUBE "}"

#define MATERIAL_ROOM                                                                              \
    "{" GLTF_SCENE                                                                                 \
    ",'nodes':[{'mesh':0}],'materials':[{'extras':{'airlight':%s}}]," GLTF_PAINTED_TRIANGLE "}"

/* An object of the schema and a sidecar in which it has a key that nobody knows. */
typedef struct known_object {
    const char *path; /* from the top of the schema: keys with spaces between */
    const char *text;
} known_object;

static const known_object objects[] = {
    {"", "{'?':1}"},
    {"$defs flags", "{'objects':{'Fog':{'?':1}}}"},
    {"$defs medium", "{'media':[{'?':1}]}"},
    {"$defs phase oneOf 1", "{'media':[{'sigma_s':1,'phase':{'type':'hg','?':1}}]}"},
    {"$defs phase oneOf 2", "{'media':[{'sigma_s':1,'phase':{'type':'mixture','?':1}}]}"},
    {"$defs phase oneOf 3", "{'media':[{'sigma_s':1,'phase':{'type':'table','?':1}}]}"},
    {"$defs lobe", "{'media':[{'sigma_s':1,'phase':{'type':'mixture','lobes':[{'?':1}]}}]}"},
    {"$defs boundary oneOf 1", "{'media':[{'sigma_s':1,'boundary':{'?':1}}]}"},
    {"$defs boundary oneOf 1 properties sphere",
     "{'media':[{'sigma_s':1,'boundary':{'sphere':{'?':1}}}]}"},
    {"$defs box", "{'media':[{'sigma_s':1,'boundary':{'box':{'?':1}}}]}"},
    {"$defs density", "{'media':[{'sigma_s':1,'density':{'?':1}}]}"},
    {"$defs layer", "{'media':[{'sigma_s':1,'density':{'layers':[{'?':1}]}}]}"},
    {"$defs exponential", "{'media':[{'sigma_s':1,'density':{'exponential':{'?':1}}}]}"},
    {"$defs grid", "{'media':[{'sigma_s':1,'density':{'grid':{'?':1}}}]}"},
    {"$defs side_grid", "{'media':[{'sigma_s':1,'density':{'grid':{'file':'a.raw','size':[1,1,1]}},"
                        "'albedo_grid':{'?':1}}]}"},
    {"$defs detail", "{'media':[{'sigma_s':1,'detail':{'?':1}}]}"},
    {"$defs point_light", "{'lights':[{'type':'point','?':1}]}"},
    {"$defs spot_light", "{'lights':[{'type':'spot','?':1}]}"},
    {"$defs collimated_light", "{'lights':[{'type':'collimated','?':1}]}"},
    {"$defs polygon_light", "{'lights':[{'type':'polygon','?':1}]}"},
    {"$defs projector_light", "{'lights':[{'type':'projector','?':1}]}"},
    {"$defs environment_light", "{'lights':[{'type':'environment','?':1}]}"},
    {"$defs camera", "{'camera':{'?':1}}"},
};

/* The same for the airlight objects of nodes. */
static const known_object node_objects[] = {
    {"$defs node", "{'?':1}"},
    {"$defs film", "{'film':{'?':1}}"},
};

/* And for those of materials. */
static const known_object material_objects[] = {
    {"$defs material", "{'?':1}"},
};

static json_t *read_schema(air_context *context)
{
    void *data = NULL;
    size_t size = 0;
    assert_int_equal(
        air_file_read(context, AIR_SOURCE_DIR "/docs/airlight.schema.json", &data, &size), AIR_OK);
    json_t *schema = json_loadb(data, size, JSON_REJECT_DUPLICATES, NULL);
    air_free(context, data);
    assert_non_null(schema);
    return schema;
}

static json_t *descend(json_t *value, const char *path)
{
    char step[64];
    int used = 0;
    while (sscanf(path, "%63s%n", step, &used) == 1) {
        value = json_is_array(value) ? json_array_get(value, (size_t)atoi(step))
                                     : json_object_get(value, step);
        assert_non_null(value);
        path += used;
    }
    return value;
}

/* Every key of the schema's object is in the list of the message, and the list is no longer. */
static void compare(json_t *object, const char *message, const char *path)
{
    const char *list = strstr(message, "known are ");
    if (list == NULL)
        fail_msg("%s: \"%s\" lists no keys", path, message);
    list += strlen("known are ");
    size_t listed = 1, described = 0;
    for (const char *c = list; *c != '\0'; ++c)
        listed += *c == ',';
    const char *key;
    json_t *value;
    assert_true(json_is_false(json_object_get(object, "additionalProperties")));
    json_object_foreach(json_object_get(object, "properties"), key, value)
    {
        char around[80];
        char commas[512];
        if (strcmp(key, "comment") == 0)
            continue;
        described++;
        snprintf(commas, sizeof commas, ", %s,", list);
        for (char *c = commas; *c != '\0'; ++c)
            if (*c == '\n')
                *c = ',';
        snprintf(around, sizeof around, " %s,", key);
        if (strstr(commas, around) == NULL)
            fail_msg("%s: the reader does not know \"%s\": %s", path, key, message);
    }
    if (listed != described)
        fail_msg("%s: the schema has %zu keys, the reader knows %zu: %s", path, described, listed,
                 message);
}

/* room: a scene with a place for the object, or NULL: in a sidecar. */
static void check_object(json_t *schema, const known_object *object, const char *room)
{
    static const float value = 1.0f;
    import_fixture f;
    char text[512];
    uint8_t cube[168];
    import_init(&f);
    import_serve_cube(&f, cube);
    import_serve(&f, "a.raw", &value, sizeof value);
    strcpy(text, room != NULL ? "{}" : object->text);
    import_quotes(text);
    import_serve(&f, "room.airlight.json", text, strlen(text));
    if (room != NULL)
        assert_int_equal(import_format(&f, room, object->text), AIR_ERROR_FORMAT);
    else
        assert_int_equal(import_text(&f, CUBE_ROOM), AIR_ERROR_FORMAT);
    compare(descend(schema, object->path), f.said[AIR_MESSAGE_ERROR], object->path);
    import_finish(&f);
}

static void the_published_schema_has_the_keys_that_the_reader_knows(void **state)
{
    (void)state;
    air_context *plain = NULL;
    assert_int_equal(air_context_create(NULL, &plain), AIR_OK);
    json_t *schema = read_schema(plain);
    for (size_t i = 0; i < sizeof objects / sizeof objects[0]; ++i)
        check_object(schema, &objects[i], NULL);
    for (size_t i = 0; i < sizeof node_objects / sizeof node_objects[0]; ++i)
        check_object(schema, &node_objects[i], NODE_ROOM);
    for (size_t i = 0; i < sizeof material_objects / sizeof material_objects[0]; ++i)
        check_object(schema, &material_objects[i], MATERIAL_ROOM);
    json_decref(schema);
    air_context_destroy(plain);
}

/* ---- docs/sidecar.md ---- */

static void the_examples_of_the_documentation_load(void **state)
{
    (void)state;
    air_context *plain = NULL;
    void *data = NULL;
    size_t size = 0, count = 0;
    uint8_t cube[168];
    assert_int_equal(air_context_create(NULL, &plain), AIR_OK);
    assert_int_equal(air_file_read(plain, AIR_SOURCE_DIR "/docs/sidecar.md", &data, &size), AIR_OK);
    for (const char *block = strstr(data, "```json\n"); block != NULL;
         block = strstr(block, "```json\n")) {
        import_fixture f;
        block += strlen("```json\n");
        const char *end = strstr(block, "```");
        assert_non_null(end);
        import_init(&f);
        import_serve_cube(&f, cube);
        import_serve(&f, "room.airlight.json", block, (size_t)(end - block));
        /* the files that an example names do not exist */
        if (import_text(&f, CUBE_ROOM) == AIR_ERROR_IO)
            import_expect(&f, AIR_MESSAGE_ERROR, "smoke.nvdb");
        else
            import_expect_silence(&f, AIR_MESSAGE_ERROR);
        import_finish(&f);
        block = end + 3;
        count++;
    }
    assert_int_equal(count, 5);
    air_free(plain, data);
    air_context_destroy(plain);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_published_schema_has_the_keys_that_the_reader_knows),
        cmocka_unit_test(the_examples_of_the_documentation_load),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

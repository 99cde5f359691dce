/* lightmap_gltf_scene.h: a glTF scene with all that makes copying hard, and a lightmap for it: two
 * nodes that share a quad of interleaved, normalised and sparse accessors with a morph target, a
 * lamp, a punctual light, and members nobody knows. */
#ifndef AIR_TESTS_LIGHTMAP_GLTF_SCENE_H
#define AIR_TESTS_LIGHTMAP_GLTF_SCENE_H

#include <jansson.h>

#include "lightmap_fixture.h"
#include "scene/snapshot.h"

enum { SCENE_BINARY = 240 };

static const char scene_text[] =
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0,1,2,3]}],"
    "'extensionsUsed':['KHR_lights_punctual'],"
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':100}]}},"
    "'nodes':[{'mesh':0,'name':'left','extras':{'tag':[1,2.5,'x']}},"
    "{'mesh':0,'name':'right','translation':[3,0,0],'nobodyKnows':{'this':true}},"
    "{'mesh':1,'name':'lamp','translation':[0,0,5]},"
    "{'name':'bulb','extensions':{'KHR_lights_punctual':{'light':0}}}],"
    "'meshes':[{'name':'quad','primitives':[{'attributes':{'POSITION':0,'NORMAL':1,"
    "'TEXCOORD_0':2,'COLOR_0':3,'TEXCOORD_1':4,'JOINTS_0':7,'WEIGHTS_0':8},'indices':5,"
    "'material':0,'targets':[{'POSITION':6}]}],'weights':[0]},"
    "{'name':'lampshade','primitives':[{'attributes':{'POSITION':0,'TEXCOORD_1':4},'indices':5,"
    "'material':1}]}],"
    "'materials':[{'name':'wall','extras':{'kept':true},'pbrMetallicRoughness':"
    "{'baseColorFactor':[0.5,0.25,1,0.75],'metallicFactor':0}},"
    "{'name':'glow','emissiveFactor':[1,1,1]}],"
    "'buffers':[{'byteLength':240,'uri':'%s'}],"
    "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':48,"
    "'byteStride':12},{'buffer':0,'byteOffset':96,'byteLength':12},"
    "{'buffer':0,'byteOffset':108,'byteLength':4},{'buffer':0,'byteOffset':112,'byteLength':48},"
    "{'buffer':0,'byteOffset':160,'byteLength':48},{'buffer':0,'byteOffset':208,'byteLength':16},"
    "{'buffer':0,'byteOffset':224,'byteLength':16}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','min':[0,0,0],"
    "'max':[1,1,0],'name':'corners'},"
    "{'componentType':5126,'count':4,'type':'VEC3','sparse':{'count':4,'indices':{'bufferView':3,"
    "'componentType':5121},'values':{'bufferView':4}}},"
    "{'bufferView':1,'componentType':5123,'normalized':true,'count':4,'type':'VEC2'},"
    "{'bufferView':1,'byteOffset':4,'componentType':5121,'normalized':true,'count':4,"
    "'type':'VEC3'},"
    "{'bufferView':1,'byteOffset':8,'componentType':5123,'normalized':true,'count':4,"
    "'type':'VEC2'},"
    "{'bufferView':2,'componentType':5123,'count':6,'type':'SCALAR'},"
    "{'bufferView':5,'componentType':5126,'count':4,'type':'VEC3','min':[0,0,0],'max':[0,0,3]},"
    "{'bufferView':6,'componentType':5121,'count':4,'type':'VEC4'},"
    "{'bufferView':7,'componentType':5121,'normalized':true,'count':4,'type':'VEC4'}]}";

static const float scene_corners[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const float scene_normals[12] = {0, 0, 1, 0.6f, 0, 0.8f, 0, 0.6f, 0.8f, 0, 0, 1};
static const uint16_t scene_uv0[8] = {0, 0, 65535, 0, 65535, 13107, 0, 13107};
static const uint8_t scene_colors[12] = {255, 0, 51, 255, 255, 255, 102, 204, 0, 0, 0, 255};
static const uint16_t scene_uv1[8] = {0, 65535, 65535, 65535, 65535, 0, 0, 0};
static const uint16_t scene_indices[6] = {0, 1, 2, 0, 2, 3};

static inline void scene_binary(uint8_t out[SCENE_BINARY])
{
    static const float morph[12] = {0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3};
    static const uint8_t order[4] = {0, 1, 2, 3};
    memset(out, 0, SCENE_BINARY);
    memcpy(out, scene_corners, 48);
    for (size_t i = 0; i < 4; i++) {
        memcpy(out + 48 + 12 * i, scene_uv0 + 2 * i, 4);
        memcpy(out + 52 + 12 * i, scene_colors + 3 * i, 3);
        memcpy(out + 56 + 12 * i, scene_uv1 + 2 * i, 4);
    }
    memcpy(out + 96, scene_indices, 12);
    memcpy(out + 108, order, 4);
    memcpy(out + 112, scene_normals, 48);
    memcpy(out + 160, morph, 48);
    for (size_t i = 0; i < 16; i++) {
        out[208 + i] = (uint8_t)i;
        out[224 + i] = (uint8_t)(16 * i);
    }
}

/* The text with double quotes; free it. */
static inline char *scene_json(const char *text, const char *uri)
{
    char *json = malloc(strlen(text) + strlen(uri) + 1);
    const char *at = strstr(text, "%s");
    assert_non_null(at);
    (void)sprintf(json, "%.*s%s%s", (int)(at - text), text, uri, at + 2);
    for (char *c = json; *c != '\0'; c++) {
        *c = *c == '\'' ? '"' : *c;
    }
    return json;
}

/* room.gltf and its buffer, with one piece of text replaced by another ("": as it is). */
static inline void scene_write(lightmap_fixture *self, const char *from, const char *to)
{
    uint8_t binary[SCENE_BINARY];
    char *json = scene_json(scene_text, "a%20b.bin");
    char *at = strstr(json, from);
    assert_non_null(at);
    char *edited = malloc(strlen(json) + strlen(to) + 1);
    (void)sprintf(edited, "%.*s%s%s", (int)(at - json), json, to, at + strlen(from));
    scene_binary(binary);
    lightmap_write(self, "a b.bin", binary, SCENE_BINARY);
    lightmap_write(self, "room.gltf", edited, strlen(edited));
    free(edited);
    free(json);
}

static const uint32_t scene_cut_sources[6] = {0, 1, 2, 0, 2, 3};
static const uint32_t scene_cut_indices[6] = {0, 1, 2, 3, 4, 5};
static const float scene_cut_uv[12] = {0.1f, 0.1f, 0.4f, 0.1f, 0.4f, 0.4f,
                                       0.6f, 0.6f, 0.9f, 0.9f, 0.6f, 0.9f};

/* The left quad as it is, on page 0; the right one cut, on page 1; the lamp, which emits. */
static inline air_lightmap *scene_lightmap(lightmap_fixture *self, size_t channels)
{
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    lightmap->photometric = true;
    lightmap->directional = channels > 13;
    lightmap_add_page(self, lightmap, lightmap_page(self, 8, 8, channels));
    lightmap_add_page(self, lightmap, lightmap_page(self, 16, 4, channels));
    lightmap->mesh_count = 3;
    lightmap->meshes = air_allocate(self->context, 3, sizeof *lightmap->meshes);
    lightmap->meshes[0] =
        (air_lightmap_mesh){.node = 0, .scale = {0.5f, 0.25f}, .offset = {0.25f, 0.5f}};
    lightmap->meshes[1] = (air_lightmap_mesh){.mesh = 1, .node = 1, .page = 1, .scale = {1, 1}};
    lightmap->meshes[2] = (air_lightmap_mesh){.mesh = 2, .node = 2, .page = 0, .scale = {1, 1}};
    lightmap_cut(self, &lightmap->meshes[1], 6, scene_cut_sources, scene_cut_uv, 2,
                 scene_cut_indices);
    return lightmap;
}

/* ---- copies, loaded again ---- */

static inline void scene_save(lightmap_fixture *self, const air_lightmap *lightmap,
                              const char *name, const air_lightmap_gltf_params *params)
{
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    if (air_lightmap_save_gltf(self->context, lightmap, scene, lightmap_path(self, name), params) !=
        AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
}

typedef struct scene_loaded {
    air_scene *scene;
    air_snapshot *snapshot;
} scene_loaded;

static inline scene_loaded scene_load(lightmap_fixture *self, const char *name)
{
    scene_loaded result = {0};
    air_load_params params;
    air_load_params_default(&params);
    if (air_scene_load(self->context, lightmap_path(self, name), &params, &result.scene) !=
            AIR_OK ||
        air_scene_commit(result.scene, &result.snapshot, NULL) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    return result;
}

static inline void scene_unload(scene_loaded *self)
{
    air_snapshot_release(self->snapshot);
    air_scene_destroy(self->scene);
}

/* The JSON of a .gltf or .glb. */
static inline json_t *scene_read_json(lightmap_fixture *self, const char *name)
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

static inline const air_mesh *scene_find_mesh(const scene_loaded *self, const char *name)
{
    for (size_t i = 0; i < self->snapshot->mesh_count; i++) {
        if (strcmp(self->snapshot->meshes[i]->name, name) == 0) {
            return self->snapshot->meshes[i];
        }
    }
    fail_msg("no mesh is called %s", name);
    return NULL;
}

static inline json_t *scene_item(json_t *root, const char *list, size_t index)
{
    json_t *value = json_array_get(json_object_get(root, list), index);
    assert_non_null(value);
    return value;
}

#endif

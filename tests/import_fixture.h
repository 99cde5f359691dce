/* import_fixture.h: scenes loaded from texts and bytes in memory, and what the loader said. */
#ifndef AIR_TESTS_IMPORT_FIXTURE_H
#define AIR_TESTS_IMPORT_FIXTURE_H

#include <stdio.h>
#include <string.h>

#include "airlight/scene.h"
#include "cmocka_test.h"
#include "failing_allocator.h"
#include "scene/snapshot.h"

enum { FIXTURE_FILES = 8, FIXTURE_TEXT = 8192, FIXTURE_MANY = 1000000000 };

typedef struct import_file {
    const char *path;
    const void *data;
    size_t size;
} import_file;

typedef struct import_fixture {
    failing_allocator allocator;
    air_context *context;
    import_file files[FIXTURE_FILES];
    size_t file_count;
    char text[FIXTURE_TEXT];    /* of the scene file */
    char said[3][FIXTURE_TEXT]; /* messages by level, one a line */
    air_load_params params;
    air_scene *scene;
    air_snapshot *snapshot;
} import_fixture;

static inline air_status import_read(void *user, air_context *context, const char *path,
                                     void **out_data, size_t *out_size)
{
    const import_fixture *self = user;
    (void)context;
    for (size_t i = 0; i < self->file_count; ++i) {
        if (strcmp(self->files[i].path, path) != 0)
            continue;
        void *copy =
            failing_reallocate((void *)(uintptr_t)&self->allocator, NULL, self->files[i].size + 1);
        if (copy == NULL)
            return AIR_ERROR_MEMORY;
        memcpy(copy, self->files[i].data, self->files[i].size);
        *out_data = copy;
        *out_size = self->files[i].size;
        return AIR_OK;
    }
    return AIR_ERROR_IO;
}

static inline void import_message(void *user, air_message_level level, const char *text)
{
    import_fixture *self = user;
    const size_t used = strlen(self->said[level]);
    snprintf(self->said[level] + used, FIXTURE_TEXT - used, "%s\n", text);
}

static inline void import_init(import_fixture *self)
{
    *self = (import_fixture){0};
    air_context_params params = failing_params(&self->allocator, FIXTURE_MANY);
    params.read_file = import_read;
    params.read_user = self;
    params.message = import_message;
    params.message_user = self;
    params.thread_count = 1;
    assert_int_equal(air_context_create(&params, &self->context), AIR_OK);
    air_load_params_default(&self->params);
}

/* Lets go of the scene and of what was said. */
static inline void import_reset(import_fixture *self)
{
    air_snapshot_release(self->snapshot);
    air_scene_destroy(self->scene);
    self->snapshot = NULL;
    self->scene = NULL;
    memset(self->said, 0, sizeof self->said);
}

/* Fails the test if anything allocated was not freed. */
static inline void import_finish(import_fixture *self)
{
    import_reset(self);
    air_context_destroy(self->context);
    assert_int_equal(atomic_load(&self->allocator.live), 0);
}

/* Data are borrowed. A second file of a path replaces the first. */
static inline void import_serve(import_fixture *self, const char *path, const void *data,
                                size_t size)
{
    size_t i = 0;
    while (i < self->file_count && strcmp(self->files[i].path, path) != 0)
        ++i;
    assert_true(i < FIXTURE_FILES);
    self->files[i] = (import_file){path, data, size};
    self->file_count += i == self->file_count;
}

/* Single quotes to double ones: JSON that can be read in C. */
static inline void import_quotes(char *text)
{
    for (; *text != '\0'; ++text)
        if (*text == '\'')
            *text = '"';
}

/* Loads and commits "room.gltf", which has this text. */
static inline air_status import_text(import_fixture *self, const char *text)
{
    import_reset(self);
    assert_true(strlen(text) < FIXTURE_TEXT);
    if (text != self->text)
        strcpy(self->text, text);
    import_quotes(self->text);
    import_serve(self, "room.gltf", self->text, strlen(self->text));
    air_status status = air_scene_load(self->context, "room.gltf", &self->params, &self->scene);
    if (status == AIR_OK)
        status = air_scene_commit(self->scene, &self->snapshot, NULL);
    else
        assert_null(self->scene);
    return status;
}

/* import_text, with printf. */
static inline air_status import_format(import_fixture *self, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static inline air_status import_format(import_fixture *self, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(self->text, FIXTURE_TEXT, format, arguments);
    va_end(arguments);
    assert_true(length > 0 && length < FIXTURE_TEXT);
    return import_text(self, self->text);
}

static inline void import_loads(import_fixture *self, const char *text)
{
    if (import_text(self, text) != AIR_OK)
        fail_msg("%s", air_context_last_error(self->context));
}

static inline void import_expect(const import_fixture *self, air_message_level level,
                                 const char *part)
{
    if (strstr(self->said[level], part) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", self->said[level], part);
}

static inline void import_expect_silence(const import_fixture *self, air_message_level level)
{
    assert_string_equal(self->said[level], "");
}

/* The text does not load, with this status and exactly this one message. */
static inline void import_refuses(import_fixture *self, const char *text, air_status status,
                                  const char *message)
{
    char line[2048];
    assert_int_equal(import_text(self, text), status);
    snprintf(line, sizeof line, "%s\n", message);
    assert_string_equal(self->said[AIR_MESSAGE_ERROR], line);
}

/* ---- pieces of glTF ---- */

#define GLTF_ASSET "'asset':{'version':'2.0'}"
#define GLTF_SCENE GLTF_ASSET ",'scenes':[{'nodes':[0]}]"

/* The triangle (0,0,0) (1,0,0) (0,1,0), facing +Z, as a data URI. */
#define GLTF_TRIANGLE_DATA                                                                         \
    "'buffers':[{'byteLength':36,'uri':'data:application/octet-stream;base64,"                     \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'}],'bufferViews':[{'buffer':0,'byteLength':" \
    "36}],"                                                                                        \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]"

/* One mesh of that triangle. */
#define GLTF_TRIANGLE                                                                              \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," GLTF_TRIANGLE_DATA

/* The same with a material, number 0. */
#define GLTF_PAINTED_TRIANGLE                                                                      \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}]," GLTF_TRIANGLE_DATA

/* Positions and indices of the cube [-1,1]^3, facing outwards: "cube.bin". */
static const float import_cube_positions[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                                                -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const uint16_t import_cube_indices[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7,
                                                 0, 1, 5, 0, 5, 4, 3, 6, 2, 3, 7, 6,
                                                 0, 7, 3, 0, 4, 7, 1, 2, 6, 1, 6, 5};

#define GLTF_CUBE GLTF_CUBE_OF("'mode':4")

/* The same with more to say of its primitive. */
#define GLTF_CUBE_OF(more)                                                                         \
    "'meshes':[{'name':'CubeMesh','primitives':[{'attributes':{'POSITION':0},'indices':1," more    \
    "}]}],"                                                                                        \
    "'buffers':[{'byteLength':168,'uri':'cube.bin'}],'bufferViews':[{'buffer':0,'byteLength':96}," \
    "{'buffer':0,'byteOffset':96,'byteLength':72}],"                                               \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':8,'type':'VEC3'},"                  \
    "{'bufferView':1,'componentType':5123,'count':36,'type':'SCALAR'}]"

/* bytes: 168 of them, which must outlive the fixture. */
static inline void import_serve_cube(import_fixture *self, uint8_t *bytes)
{
    memcpy(bytes, import_cube_positions, 96);
    memcpy(bytes + 96, import_cube_indices, 72);
    import_serve(self, "cube.bin", bytes, 168);
}

#endif

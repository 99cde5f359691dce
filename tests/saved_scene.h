/* saved_scene.h: a scene written to a file and read again, and whether it is the same. */
#ifndef AIR_TESTS_SAVED_SCENE_H
#define AIR_TESTS_SAVED_SCENE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "airlight/scene.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/vec.h"
#include "failing_allocator.h"
#include "scene/fingerprint.h"
#include "scene/grid_record.h"
#include "scene/light_record.h"
#include "scene/material.h"
#include "scene/medium_record.h"
#include "scene/mesh.h"
#include "scene/scene.h"
#include "scene/shared.h"
#include "scene/snapshot.h"
#include "scene/texture.h"

enum { SAVED_TEXT = 4096, SAVED_MANY = 1000000000 };

typedef struct saved_fixture {
    failing_allocator allocator;
    air_context *context;
    char said[3][SAVED_TEXT]; /* messages by level, one a line */
    char folder[64];
    char path[96]; /* of the file */
    air_scene *scene, *again;
} saved_fixture;

static inline void saved_message(void *user, air_message_level level, const char *text)
{
    saved_fixture *self = user;
    const size_t used = strlen(self->said[level]);
    snprintf(self->said[level] + used, SAVED_TEXT - used, "%s\n", text);
}

/* Makes a folder for the file, and an empty scene. */
static inline void saved_init(saved_fixture *self)
{
    *self = (saved_fixture){0};
    air_context_params params = failing_params(&self->allocator, SAVED_MANY);
    params.message = saved_message;
    params.message_user = self;
    params.thread_count = 1;
    assert_int_equal(air_context_create(&params, &self->context), AIR_OK);
    assert_int_equal(air_scene_create(self->context, &self->scene), AIR_OK);
    strcpy(self->folder, "/tmp/airlight-save-XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    snprintf(self->path, sizeof self->path, "%s/saved.glb", self->folder);
}

/* Fails the test if anything allocated was not freed. */
static inline void saved_finish(saved_fixture *self)
{
    char command[128];
    air_scene_destroy(self->again);
    air_scene_destroy(self->scene);
    air_context_destroy(self->context);
    assert_int_equal(atomic_load(&self->allocator.live), 0);
    snprintf(command, sizeof command, "rm -rf %s", self->folder);
    assert_int_equal(system(command), 0);
}

static inline void saved_read(saved_fixture *self)
{
    air_scene_destroy(self->again);
    self->again = NULL;
    if (air_scene_load(self->context, self->path, NULL, &self->again) != AIR_OK)
        fail_msg("%s", air_context_last_error(self->context));
}

/* Writes the scene and reads it. */
static inline void saved_round(saved_fixture *self)
{
    memset(self->said, 0, sizeof self->said);
    if (air_scene_save(self->context, self->scene, self->path) != AIR_OK)
        fail_msg("%s", air_context_last_error(self->context));
    saved_read(self);
}

static inline void saved_expect_warning(const saved_fixture *self, const char *part)
{
    if (strstr(self->said[AIR_MESSAGE_WARNING], part) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", self->said[AIR_MESSAGE_WARNING], part);
}

/* The object number `index` of its kind, in the order they were added. */
static inline const air_record *saved_record(const air_scene *scene, air_object_kind kind,
                                             size_t index)
{
    assert_true(index < scene->lists[kind].count);
    return scene->lists[kind].slots[index].record;
}

static inline const air_texture *saved_texture(const air_scene *scene, air_handle handle)
{
    const size_t index = air_slot_find(&scene->lists[AIR_OBJECT_TEXTURE], handle);
    return &((const air_texture_record *)saved_record(scene, AIR_OBJECT_TEXTURE, index))->texture;
}

static inline void saved_same_texture(const air_texture *a, const air_texture *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    assert_int_equal(a->srgb, b->srgb);
    assert_int_equal(a->wrap_u, b->wrap_u);
    assert_int_equal(a->wrap_v, b->wrap_v);
    assert_int_equal(a->filter, b->filter);
    assert_int_equal(a->floats == NULL, b->floats == NULL);
    const size_t count = a->width * a->height * a->channels;
    if (a->floats != NULL)
        assert_memory_equal(a->floats, b->floats, count * sizeof(float));
    else
        assert_memory_equal(a->bytes, b->bytes, count);
}

static inline void saved_same_camera(const air_camera *a, const air_camera *b)
{
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->kind, b->kind);
    assert_memory_equal(a->to_world, b->to_world, sizeof a->to_world);
    if (a->kind == AIR_CAMERA_PERSPECTIVE)
        assert_true(a->fov_y_rad == b->fov_y_rad);
    else
        assert_true(a->half_height == b->half_height);
}

/* Everything that a picture depends on is the same, to the last bit. */
static inline void saved_same_pictures(air_scene *a, air_scene *b)
{
    air_snapshot *first = NULL, *second = NULL;
    assert_int_equal(air_scene_commit(a, &first, NULL), AIR_OK);
    assert_int_equal(air_scene_commit(b, &second, NULL), AIR_OK);
    assert_int_equal(first->camera_count, second->camera_count);
    for (size_t i = 0; i < first->camera_count; ++i)
        saved_same_camera(&first->cameras[i], &second->cameras[i]);
    assert_true(air_fingerprint_snapshot(first) == air_fingerprint_snapshot(second));
    air_snapshot_release(second);
    air_snapshot_release(first);
}

/* ---- what scenes are made of ---- */

static const float saved_square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const uint32_t saved_square_indices[6] = {0, 1, 2, 0, 2, 3};

static inline air_mesh_desc saved_square_mesh(const char *name)
{
    air_mesh_desc desc;
    air_mesh_desc_default(&desc);
    desc.name = name;
    desc.positions = saved_square;
    desc.vertex_count = 4;
    desc.indices = saved_square_indices;
    desc.triangle_count = 2;
    return desc;
}

static inline void saved_add_mesh(saved_fixture *self, const air_mesh_desc *desc)
{
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_mesh(self->scene, desc, &handle), AIR_OK);
}

static inline void saved_add_light(saved_fixture *self, const air_light_desc *desc)
{
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_light(self->scene, desc, &handle), AIR_OK);
}

static inline void saved_add_medium(saved_fixture *self, const air_medium_desc *desc)
{
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_medium(self->scene, desc, &handle), AIR_OK);
}

static inline air_handle saved_add_material(saved_fixture *self, const air_material_desc *desc)
{
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_material(self->scene, desc, &handle), AIR_OK);
    return handle;
}

/* A material is read where a mesh has it. */
static inline void saved_show_material(saved_fixture *self, const air_material_desc *desc)
{
    air_mesh_desc mesh = saved_square_mesh("wall");
    mesh.material = saved_add_material(self, desc);
    saved_add_mesh(self, &mesh);
}

static inline const air_material_desc *saved_material_again(const saved_fixture *self, size_t index)
{
    return &((const air_material_record *)saved_record(self->again, AIR_OBJECT_MATERIAL, index))
                ->desc;
}

static inline const air_light_desc *saved_light_again(const saved_fixture *self, size_t index)
{
    return &((const air_light_record *)saved_record(self->again, AIR_OBJECT_LIGHT, index))->desc;
}

static inline void saved_same_lights(const air_scene *a, const air_scene *b)
{
    const size_t count = a->lists[AIR_OBJECT_LIGHT].count;
    assert_int_equal(b->lists[AIR_OBJECT_LIGHT].count, count);
    for (size_t i = 0; i < count; ++i) {
        const air_record *before = saved_record(a, AIR_OBJECT_LIGHT, i);
        const air_record *after = saved_record(b, AIR_OBJECT_LIGHT, i);
        assert_string_equal(before->name, after->name);
        assert_true(air_light_equal(&((const air_light_record *)before)->desc,
                                    &((const air_light_record *)after)->desc));
    }
}

static inline void saved_same_media(const saved_fixture *self, size_t count)
{
    assert_int_equal(self->again->lists[AIR_OBJECT_MEDIUM].count, count);
    for (size_t i = 0; i < count; ++i) {
        const air_record *before = saved_record(self->scene, AIR_OBJECT_MEDIUM, i);
        const air_record *after = saved_record(self->again, AIR_OBJECT_MEDIUM, i);
        assert_string_equal(before->name, after->name);
        assert_true(air_medium_equal(&((const air_medium_record *)before)->desc,
                                     &((const air_medium_record *)after)->desc));
    }
}

static inline float saved_random_between(air_rng *random, float low, float high)
{
    return low + (high - low) * air_rng_float(random);
}

/* Of all magnitudes that lights have. */
static inline float saved_random_strength(air_rng *random)
{
    return expf(saved_random_between(random, -12.0f, 12.0f));
}

static inline void saved_random_direction(air_rng *random, float out[3])
{
    air_vec3 v;
    do {
        v = vec3(saved_random_between(random, -1.0f, 1.0f),
                 saved_random_between(random, -1.0f, 1.0f),
                 saved_random_between(random, -1.0f, 1.0f));
    } while (!(vec3_length(v) > 0.1f) || vec3_length(v) > 1.0f);
    vec3_store(out, vec3_normalize(v));
}

static inline air_handle saved_add_texture(saved_fixture *self, const air_texture_desc *desc)
{
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_texture(self->scene, desc, &handle), AIR_OK);
    return handle;
}

static inline air_handle saved_add_grid(saved_fixture *self, air_rng *random, size_t channels,
                                        const float map[12])
{
    float values[6 * 5 * 4 * 3];
    air_grid_desc desc = {
        .name = "grid", .size = {6, 5, 4}, .channels = channels, .values = values};
    air_handle handle = AIR_NONE;
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i)
        values[i] = i % 3 == 0 ? 0.0f : saved_random_between(random, 0.0f, 1.0f);
    memcpy(desc.index_to_local, map, sizeof desc.index_to_local);
    assert_int_equal(air_scene_add_grid(self->scene, &desc, &handle), AIR_OK);
    return handle;
}

#endif

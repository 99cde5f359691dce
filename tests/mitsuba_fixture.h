/* mitsuba_fixture.h: Mitsuba scenes loaded from texts in memory, and what became of them. */
#ifndef AIR_TESTS_MITSUBA_FIXTURE_H
#define AIR_TESTS_MITSUBA_FIXTURE_H

#include "import_fixture.h"
#include "scene/camera.h"
#include "scene/light_record.h"
#include "scene/material.h"
#include "scene/medium_record.h"
#include "scene/mesh.h"
#include "scene/scene.h"

static inline void mitsuba_init(void **state)
{
    import_fixture *self = calloc(1, sizeof *self);
    assert_non_null(self);
    import_init(self);
    *state = self;
}

static inline void mitsuba_finish(void **state)
{
    import_finish(*state);
    free(*state);
}

static int set_up(void **state)
{
    mitsuba_init(state);
    return 0;
}

static int tear_down(void **state)
{
    mitsuba_finish(state);
    return 0;
}

/* Loads "scenes/room.xml", which has this text. */
static inline air_status mitsuba_text(import_fixture *self, const char *text)
{
    import_reset(self);
    import_serve(self, "scenes/room.xml", text, strlen(text));
    const air_status status =
        air_scene_load(self->context, "scenes/room.xml", &self->params, &self->scene);
    if (status != AIR_OK)
        assert_null(self->scene);
    return status;
}

/* A scene of this version with this in it. */
static inline air_status mitsuba_inside(import_fixture *self, const char *version,
                                        const char *inside)
{
    snprintf(self->text, sizeof self->text, "<scene version='%s'>\n%s\n</scene>\n", version,
             inside);
    return mitsuba_text(self, self->text);
}

static inline void mitsuba_loads(import_fixture *self, const char *version, const char *inside)
{
    if (mitsuba_inside(self, version, inside) != AIR_OK)
        fail_msg("%s", air_context_last_error(self->context));
}

/* It does not load, and the last message is this, behind the file's name. */
static inline void mitsuba_refuses(import_fixture *self, const char *version, const char *inside,
                                   const char *message)
{
    char whole[2048];
    assert_int_not_equal(mitsuba_inside(self, version, inside), AIR_OK);
    snprintf(whole, sizeof whole, "scenes/room.xml: %s", message);
    assert_string_equal(air_context_last_error(self->context), whole);
}

static inline const air_record *mitsuba_record(const import_fixture *self, air_object_kind kind,
                                               size_t index)
{
    const air_slot_list *list = &self->scene->lists[kind];
    assert_true(index < list->count);
    return list->slots[index].record;
}

static inline size_t mitsuba_count(const import_fixture *self, air_object_kind kind)
{
    return self->scene->lists[kind].count;
}

static inline const air_camera_desc *mitsuba_camera(const import_fixture *self, size_t index)
{
    return &((const air_camera_record *)mitsuba_record(self, AIR_OBJECT_CAMERA, index))->desc;
}

static inline const air_light_desc *mitsuba_light(const import_fixture *self, size_t index)
{
    return &((const air_light_record *)mitsuba_record(self, AIR_OBJECT_LIGHT, index))->desc;
}

static inline const air_material_desc *mitsuba_material(const import_fixture *self, size_t index)
{
    return &((const air_material_record *)mitsuba_record(self, AIR_OBJECT_MATERIAL, index))->desc;
}

static inline const air_medium_desc *mitsuba_medium(const import_fixture *self, size_t index)
{
    return &((const air_medium_record *)mitsuba_record(self, AIR_OBJECT_MEDIUM, index))->desc;
}

static inline const air_mesh_record *mitsuba_mesh(const import_fixture *self, size_t index)
{
    return (const air_mesh_record *)mitsuba_record(self, AIR_OBJECT_MESH, index);
}

static inline void assert_floats(const float *values, size_t count, const float *expected)
{
    for (size_t i = 0; i < count; ++i)
        if (!(fabsf(values[i] - expected[i]) <= 1e-5f * (1.0f + fabsf(expected[i]))))
            fail_msg("value %zu is %g, expected %g", i, (double)values[i], (double)expected[i]);
}

#endif

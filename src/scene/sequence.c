/* sequence.c: scenes whose grids are other files at every frame. */
#include <inttypes.h>

#include "scene/grid_record.h"
#include "scene/scene.h"

/* The grids of a sequence at another frame, in `fresh` at the indices of their slots. */
static air_status load_grids(air_context *context, const air_slot_list *list, int64_t frame,
                             air_record **fresh)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < list->count && status == AIR_OK; ++i) {
        const air_grid_file *file = &((const air_grid_record *)list->slots[i].record)->sequence;
        if (file->path != NULL)
            status = air_grid_record_load(context, file, frame, &fresh[i]);
    }
    return status;
}

air_status air_scene_set_frame(air_scene *scene, int64_t frame)
{
    if (scene == NULL)
        return AIR_ERROR_ARGUMENT;
    if (frame != AIR_FRAME_NONE && (frame < 0 || frame > AIR_FRAME_MAX))
        return air_fail(scene->context, AIR_ERROR_ARGUMENT,
                        "frame %" PRId64 ", expected 0 to %d, or AIR_FRAME_NONE", frame,
                        (int)AIR_FRAME_MAX);
    if (frame == scene->frame || frame == AIR_FRAME_NONE) {
        scene->frame = frame;
        return AIR_OK;
    }
    air_slot_list *list = &scene->lists[AIR_OBJECT_GRID];
    air_record **fresh = air_allocate(scene->context, list->count, sizeof(air_record *));
    if (fresh == NULL)
        return air_fail_memory(scene->context, "scene");
    const air_status status = load_grids(scene->context, list, frame, fresh);
    /* What lets go of the old grids in the one case lets go of the new ones in the other. */
    for (size_t i = 0; i < list->count; ++i) {
        air_record *unused = fresh[i];
        if (status == AIR_OK && fresh[i] != NULL) {
            unused = list->slots[i].record;
            list->slots[i].record = fresh[i];
        }
        air_record_release(unused);
    }
    air_free(scene->context, fresh);
    if (status == AIR_OK)
        scene->frame = frame;
    return status;
}

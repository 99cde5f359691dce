/* Scenes at one frame after the other: what is read, what is kept, what a commit says. */
#include "import_fixture.h"
#include "scene/media/grid.h"

/* A triangle and smoke whose density is the number of the frame, 1 to 3. */
#define SMOKE_ROOM                                                                                 \
    "{" GLTF_ASSET ",'scenes':[{'nodes':[0],'extras':{'airlight':{'media':[{'sigma_s':1,"          \
    "'density':{'grid':{'file':'smoke.##.vol'}}}]}}}],'nodes':[{'mesh':0}]," GLTF_TRIANGLE "}"

/* A Mitsuba grid volume of 2 x 2 x size_z samples of one value in [0,1] x [0,1] x [0, size_z / 2].
 */
typedef struct volume {
    char magic[4];
    int32_t encoding, size[3], channels;
    float box[6], values[16];
} volume;

static volume make_volume(int32_t size_z, float value)
{
    volume made = {.magic = {'V', 'O', 'L', 3},
                   .encoding = 1,
                   .size = {2, 2, size_z},
                   .channels = 1,
                   .box = {0, 0, 0, 1, 1, 0.5f * (float)size_z}};
    for (size_t i = 0; i < 16; ++i)
        made.values[i] = value;
    return made;
}

static size_t volume_bytes(const volume *made) { return 48 + 16 * (size_t)made->size[2]; }

/* Serves frames 1 to 3. */
static void serve(import_fixture *f, volume frames[3])
{
    static const char *const names[3] = {"smoke.01.vol", "smoke.02.vol", "smoke.03.vol"};
    for (size_t i = 0; i < 3; ++i) {
        frames[i] = make_volume(i == 2 ? 4 : 2, (float)(i + 1));
        import_serve(f, names[i], &frames[i], volume_bytes(&frames[i]));
    }
}

static float smoke_max(const air_snapshot *snapshot)
{
    assert_int_equal(snapshot->media.count, 1);
    return air_grid_max(snapshot->media.media[0].density_grid);
}

static void the_next_frame_is_a_new_medium_in_the_same_scene(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    uint32_t dirty = 0;
    air_snapshot *next = NULL;
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 1;
    import_loads(&f, SMOKE_ROOM);
    assert_float_equal(smoke_max(f.snapshot), 1.0f, 0.0f);
    assert_int_equal(air_scene_set_frame(f.scene, 2), AIR_OK);
    assert_int_equal(air_scene_commit(f.scene, &next, &dirty), AIR_OK);
    assert_int_equal(dirty, AIR_DIRTY_MEDIUM);
    assert_float_equal(smoke_max(next), 2.0f, 0.0f);
    assert_float_equal(smoke_max(f.snapshot), 1.0f, 0.0f); /* which stays what it was */
    assert_ptr_equal(next->accelerator, f.snapshot->accelerator);
    assert_ptr_equal(next->meshes[0]->positions, f.snapshot->meshes[0]->positions);
    air_snapshot_release(next);
    import_finish(&f);
}

static void a_frame_in_a_sequence_is_the_frame_loaded_alone(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    air_snapshot *moved = NULL;
    air_scene_info after, alone;
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 1;
    import_loads(&f, SMOKE_ROOM);
    assert_int_equal(air_scene_set_frame(f.scene, 3), AIR_OK);
    assert_int_equal(air_scene_commit(f.scene, &moved, NULL), AIR_OK);
    air_snapshot_info(moved, &after);
    air_snapshot_release(moved);
    f.params.frame = 3;
    import_loads(&f, SMOKE_ROOM);
    air_snapshot_info(f.snapshot, &alone);
    /* Its grid is twice as deep as that of frame 1. */
    assert_float_equal(alone.media_max[2], 2.0f, 1e-6f);
    assert_memory_equal(after.bounds_min, alone.bounds_min, sizeof alone.bounds_min);
    assert_memory_equal(after.bounds_max, alone.bounds_max, sizeof alone.bounds_max);
    assert_memory_equal(after.media_min, alone.media_min, sizeof alone.media_min);
    assert_memory_equal(after.media_max, alone.media_max, sizeof alone.media_max);
    import_finish(&f);
}

static void a_frame_that_is_missing_leaves_the_scene_at_the_last(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    uint32_t dirty = 0;
    air_snapshot *again = NULL;
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 2;
    import_loads(&f, SMOKE_ROOM);
    assert_int_equal(air_scene_set_frame(f.scene, 4), AIR_ERROR_IO);
    import_expect(&f, AIR_MESSAGE_ERROR, "smoke.04.vol: ");
    assert_int_equal(air_scene_commit(f.scene, &again, &dirty), AIR_OK);
    assert_int_equal(dirty, 0);
    assert_float_equal(smoke_max(again), 2.0f, 0.0f);
    air_snapshot_release(again);
    import_finish(&f);
}

static void the_frame_at_hand_is_not_read_again(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 2;
    import_loads(&f, SMOKE_ROOM);
    f.file_count = 0;
    assert_int_equal(air_scene_set_frame(f.scene, 2), AIR_OK);
    assert_int_equal(air_scene_set_frame(f.scene, AIR_FRAME_NONE), AIR_OK);
    assert_int_equal(air_scene_set_frame(f.scene, 1), AIR_ERROR_IO);
    import_finish(&f);
}

static void frames_out_of_range_are_refused(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 1;
    import_loads(&f, SMOKE_ROOM);
    assert_int_equal(air_scene_set_frame(NULL, 1), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_set_frame(f.scene, -2), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_set_frame(f.scene, (int64_t)AIR_FRAME_MAX + 1), AIR_ERROR_ARGUMENT);
    import_expect(&f, AIR_MESSAGE_ERROR, "frame 1000000000, expected 0 to 999999999");
    f.params.frame = -2;
    assert_int_equal(import_text(&f, SMOKE_ROOM), AIR_ERROR_ARGUMENT);
    import_finish(&f);
}

static void a_failing_allocator_leaves_the_scene_and_no_leak(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    bool done = false;
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 1;
    import_loads(&f, SMOKE_ROOM);
    for (long allowed = 0; !done && allowed < 1000; ++allowed) {
        atomic_store(&f.allocator.remaining, allowed);
        done = air_scene_set_frame(f.scene, 2) == AIR_OK;
    }
    assert_true(done);
    atomic_store(&f.allocator.remaining, FIXTURE_MANY);
    import_finish(&f);
}

static void a_camera_is_told_as_it_was_given(void **state)
{
    (void)state;
    import_fixture f;
    volume frames[3];
    air_camera_desc desc, told;
    air_handle camera = AIR_NONE;
    air_snapshot *with_camera = NULL;
    import_init(&f);
    serve(&f, frames);
    f.params.frame = 1;
    import_loads(&f, SMOKE_ROOM);
    assert_int_equal(air_snapshot_camera_desc(f.snapshot, AIR_NONE, &told), AIR_OK);
    air_camera_desc_default(&desc);
    desc.name = "eye";
    desc.to_world[3] = 5.0f;
    desc.fov_y_rad = 0.25f;
    assert_int_equal(air_scene_add_camera(f.scene, &desc, &camera), AIR_OK);
    assert_int_equal(air_scene_commit(f.scene, &with_camera, NULL), AIR_OK);
    assert_int_equal(air_snapshot_camera_desc(with_camera, camera, &told), AIR_OK);
    assert_string_equal(told.name, "eye");
    assert_memory_equal(told.to_world, desc.to_world, sizeof desc.to_world);
    assert_float_equal(told.fov_y_rad, 0.25f, 0.0f);
    assert_int_equal(air_snapshot_camera_desc(f.snapshot, camera, &told), AIR_ERROR_ARGUMENT);
    air_snapshot_release(with_camera);
    import_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_next_frame_is_a_new_medium_in_the_same_scene),
        cmocka_unit_test(a_frame_in_a_sequence_is_the_frame_loaded_alone),
        cmocka_unit_test(a_frame_that_is_missing_leaves_the_scene_at_the_last),
        cmocka_unit_test(the_frame_at_hand_is_not_read_again),
        cmocka_unit_test(frames_out_of_range_are_refused),
        cmocka_unit_test(a_failing_allocator_leaves_the_scene_and_no_leak),
        cmocka_unit_test(a_camera_is_told_as_it_was_given),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

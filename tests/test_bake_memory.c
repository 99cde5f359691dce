/* A bake with something of everything when memory runs out at any allocation: an error, nothing
 * lost, and the same bake works once there is memory. */
#include "bake_fixture.h"

/* A floor with coordinates of its own, a wall to be cut, and haze; pages, vertices, probes. */
static air_snapshot *small_scene(const bake_host *host)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 0.5f, 0), vec3(1, 0.5f, 1));
    set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    add_medium(scene, &medium);
    bake_add_quad(scene, "floor", vec3(-0.5f, 0, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1), bake_unit_uv,
                  AIR_NONE);
    bake_add_quad(scene, "wall", vec3(-0.5f, 0, -0.5f), vec3(1, 0, 0), vec3(0, 1, 0), NULL,
                  AIR_NONE);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    return path_freeze(scene);
}

static const float positions[6] = {0, 0.6f, 0, 0.3f, 0.2f, 0.3f};
static const air_probe_request requests[2] = {
    {.name = "free", .kind = AIR_PROBES_FREE, .positions = positions, .count = 2},
    {.name = "auto", .kind = AIR_PROBES_AUTO, .spacing = 0.7f}};

static air_bake_params small_params(air_bake_media media)
{
    air_bake_params params;
    air_bake_params_default(&params);
    params.samples = 1;
    params.max_bounces = 2;
    params.media = media;
    params.cache_resolution = 2;
    params.cache_samples = 16;
    params.impulse_bounces = 1;
    params.texels_per_metre = 4.0f;
    params.page_size = 16;
    params.directional = true;
    params.vertices = true;
    params.probes = requests;
    params.probe_count = 2;
    return params;
}

/* Returns whether so many allocations sufficed. */
static bool bake_with(bake_host *host, const air_snapshot *snapshot, const air_bake_params *params,
                      long allocations)
{
    air_lightmap *lightmap = NULL;
    air_bake_report report = {.texels = 12345};
    const long live = atomic_load(&host->allocator.live);
    atomic_store(&host->allocator.remaining, allocations);
    const air_status status = air_bake(host->context, snapshot, params, &lightmap, &report);
    atomic_store(&host->allocator.remaining, LIGHTMAP_MANY);
    if (status != AIR_OK) {
        assert_int_equal(status, AIR_ERROR_MEMORY);
        /* the message needs memory too, once for each thread */
        if (air_context_last_error(host->context)[0] != '\0') {
            bake_expect(host, "out of memory");
        }
        assert_null(lightmap);
        assert_int_equal(report.texels, 12345);
    }
    air_lightmap_destroy(lightmap);
    if (atomic_load(&host->allocator.live) != live) {
        fail_msg("after %ld allocations %ld blocks are lost", allocations,
                 atomic_load(&host->allocator.live) - live);
    }
    return status == AIR_OK;
}

/* How many allocations the bake makes. */
static long allocations_of(bake_host *host, const air_snapshot *snapshot,
                           const air_bake_params *params)
{
    air_lightmap *lightmap = NULL;
    atomic_store(&host->allocator.remaining, LIGHTMAP_MANY);
    assert_int_equal(air_bake(host->context, snapshot, params, &lightmap, NULL), AIR_OK);
    const long made = LIGHTMAP_MANY - atomic_load(&host->allocator.remaining);
    air_lightmap_destroy(lightmap);
    return made;
}

static void run_out(bake_host *host, air_bake_media media, bool file, long step)
{
    char path[LIGHTMAP_PATH];
    (void)snprintf(path, sizeof path, "%s", bake_path(host, "bake.progress"));
    air_snapshot *snapshot = small_scene(host);
    air_bake_params params = small_params(media);
    params.progress_path = file ? path : NULL;
    air_lightmap *expected = bake_well(host, snapshot, &params);
    const long all = allocations_of(host, snapshot, &params);
    assert_true(all > 200);
    for (long n = 0; n < all; n += step) {
        assert_false(bake_with(host, snapshot, &params, n));
    }
    assert_int_equal(access(path, F_OK), file ? 0 : -1);
    air_lightmap *lightmap = bake_well(host, snapshot, &params);
    bake_assert_same(expected, lightmap);
    air_lightmap_destroy(lightmap);
    air_lightmap_destroy(expected);
    air_snapshot_release(snapshot);
}

static void every_allocation_may_fail(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    run_out(&host, AIR_BAKE_EXACT, false, 1);
    bake_close(&host);
}

/* With a file, each attempt goes on where the last one ended. */
static void progress_stays_when_memory_runs_out(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    run_out(&host, AIR_BAKE_EXACT, true, 1);
    bake_close(&host);
}

/* On two threads the allocation that fails is any. */
static void memory_runs_out_on_two_threads(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 2);
    run_out(&host, AIR_BAKE_REFERENCE, false, 3);
    bake_close(&host);
}

/* Tables of responses are a second of work, so not all allocations have their turn. */
static void responses_may_run_out_of_memory_too(void **state)
{
    bake_host host;
    long n = 0;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = small_scene(&host);
    air_bake_params params = small_params(AIR_BAKE_IMPULSE), none = small_params(AIR_BAKE_IMPULSE);
    params.lightmaps = params.vertices = false;
    none = params;
    none.media = AIR_BAKE_NONE;
    const long all = allocations_of(&host, snapshot, &params);
    const long others = allocations_of(&host, snapshot, &none);
    assert_true(all > others);
    for (; n < all - 1; n += 11) {
        assert_false(bake_with(&host, snapshot, &params, n));
    }
    assert_false(bake_with(&host, snapshot, &params, all - 1));
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(progress_stays_when_memory_runs_out),
        cmocka_unit_test(memory_runs_out_on_two_threads),
        cmocka_unit_test(responses_may_run_out_of_memory_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

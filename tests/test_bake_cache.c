/* Cached light in media: where its points lie, what they see, that no wall leaks. */
#include "bake/cache_grid.h"
#include "bake/cache_sight.h"
#include "bake_tally.h"

/* A box of haze, cut in two by a double-sided wall; a lamp in the left part. No light can get round
 * the wall: it is larger than the box. */
static air_snapshot *two_chambers(const bake_host *host, float wall)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 1, 0), vec3(2, 1, 1));
    air_material_desc material;
    air_light_desc lamp;
    air_handle black;
    set3(medium.sigma_s, 0.6f, 0.6f, 0.6f);
    add_medium(scene, &medium);
    air_material_desc_default(&material);
    set3(material.base_color, 0.0f, 0.0f, 0.0f);
    material.specular = 0.0f;
    material.double_sided = true;
    assert_int_equal(air_scene_add_material(scene, &material, &black), AIR_OK);
    bake_add_quad(scene, "left", vec3(-2, 0, 1), vec3(wall + 2, 0, 0), vec3(0, 0, -2), NULL, black);
    bake_add_quad(scene, "right", vec3(wall, 0, 1), vec3(2 - wall, 0, 0), vec3(0, 0, -2), NULL,
                  black);
    bake_add_quad(scene, "wall", vec3(wall, -1, 2), vec3(0, 0, -4), vec3(0, 4, 0), NULL, black);
    air_light_desc_default(&lamp);
    set3(lamp.position, -1.0f, 1.0f, 0.0f);
    set3(lamp.color, 1.0f, 1.0f, 1.0f);
    add_light(scene, &lamp);
    return path_freeze(scene);
}

/* What media scatter to the vertices of one mesh, in the mean. */
static double mesh_mean(const air_lightmap *lightmap, size_t mesh)
{
    const air_vertex_light *light = &lightmap->vertex_lights[mesh];
    double sum = 0.0;
    for (size_t i = 0; i < light->vertex_count; i++) {
        sum += (double)light->layers[AIR_LAYER_MEDIA][3 * i + 1] / (double)light->vertex_count;
    }
    return sum;
}

/* Cells are 1/3 m here, their parts 1/12 m. Walls between parts let nothing through; a part that a
 * wall cuts is on one side as a whole, so what is in at most 1/24 m of two behind the wall may be
 * as bright as what is before it, where it is less than half of the mean over the left part.
 */
static void walls_keep_light_on_their_side(void **state)
{
    static const struct {
        float wall;
        double most;
    } walls[] = {{0.0f, 0.0}, {1.0f / 6.0f, 0.0}, {0.13f, 0.5 / 48.0}, {0.31f, 0.5 / 48.0}};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    for (size_t i = 0; i < sizeof walls / sizeof walls[0]; i++) {
        air_snapshot *snapshot = two_chambers(&host, walls[i].wall);
        air_bake_params params = bake_raw_params(4096, 1.0f);
        params.lightmaps = false;
        params.vertices = true;
        params.cache_resolution = 12;
        params.cache_samples = 32;
        air_lightmap *lightmap = bake_well(&host, snapshot, &params);
        const double left = mesh_mean(lightmap, 0), right = mesh_mean(lightmap, 1);
        if (!(left > 0.01 && right <= walls[i].most * left)) {
            fail_msg("wall at %g: left %g, right %g", (double)walls[i].wall, left, right);
        }
        air_lightmap_destroy(lightmap);
        air_snapshot_release(snapshot);
    }
    bake_close(&host);
}

/* Whatever the resolution: grids get coarser in their order, and the last holds all of the medium
 * that is near. */
static void the_last_grid_holds_all(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = two_chambers(&host, 0.0f);
    for (uint32_t resolution = 2; resolution <= 64; resolution *= 2) {
        air_cache_grids grids;
        assert_int_equal(air_cache_grids_place(host.context, snapshot, &snapshot->media.media[0],
                                               resolution, &grids),
                         AIR_OK);
        assert_true(grids.count > 0);
        for (size_t i = 0; i < grids.count; i++) {
            const air_cache_grid *g = &grids.grids[i];
            const bool last = i + 1 == grids.count;
            const float cell = float_max(g->step.x, float_max(g->step.y, g->step.z));
            if (!last) {
                const air_vec3 next = grids.grids[i + 1].step;
                assert_true(cell <= float_max(next.x, float_max(next.y, next.z)));
            }
            if (last) {
                assert_float_equal(g->low.x - 0.5f * g->step.x, -2.0f, 1e-5f);
                assert_float_equal(g->low.x + ((float)g->size[0] - 0.5f) * g->step.x, 2.0f, 1e-5f);
            }
        }
        air_cache_grids_finish(host.context, &grids);
    }
    const uint32_t chosen = air_cache_resolution(snapshot, 8192.0);
    assert_true(chosen >= 24 && chosen <= 34 && chosen % 2 == 0); /* 4 x 2 x 2 m: n^3 / 4 points */
    assert_int_equal(air_cache_resolution(snapshot, 1.0), 8);
    assert_int_equal(air_cache_resolution(snapshot, 1e12), 64);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* Interpolation is linear within, and goes on with the border's values beyond. */
static void places_are_between_their_points(void **state)
{
    const air_cache_grid g = {.low = {0.5f, 0.5f, 0}, .step = {1, 1, 0}, .size = {4, 3, 1}};
    (void)state;
    const air_cache_place in = air_cache_locate(&g, vec3(1.75f, 1.5f, 7));
    assert_int_equal(in.lower[0], 1);
    assert_int_equal(in.upper[0], 2);
    assert_float_equal(in.share[0], 0.25f, 1e-6f);
    assert_int_equal(in.lower[2], 0);
    assert_int_equal(in.upper[2], 0);
    assert_int_equal(in.sees, 0xff);
    const air_cache_place below = air_cache_locate(&g, vec3(-9, 0.2f, 0));
    assert_int_equal(below.lower[0], 0);
    assert_int_equal(below.upper[0], 0);
    assert_int_equal(below.lower[1], 0);
    assert_int_equal(below.upper[1], 0);
    const air_cache_place above = air_cache_locate(&g, vec3(9, 2.9f, 0));
    assert_int_equal(above.lower[0], 3);
    assert_int_equal(above.upper[0], 3);
    assert_int_equal(above.lower[1], 2);
    assert_int_equal(above.upper[1], 2);
}

/* Every part of every cell against rays of its own. */
static void points_are_seen_unless_a_wall_is_between(void **state)
{
    const float wall = 0.13f;
    bake_host host;
    (void)state;
    bake_open(&host, 2);
    air_snapshot *snapshot = two_chambers(&host, wall);
    air_cache_grids grids;
    assert_int_equal(
        air_cache_grids_place(host.context, snapshot, &snapshot->media.media[0], 8, &grids),
        AIR_OK);
    air_cache_grid *g = &grids.grids[grids.count - 1];
    assert_int_equal(air_cache_sight_make(host.context, snapshot, g), AIR_OK);
    size_t apart = 0;
    for (uint32_t part = 0; part < 4 * g->size[0]; part++) {
        const float x = g->low.x + (((float)part + 0.5f) / 4.0f - 0.5f) * g->step.x;
        const air_cache_place place = air_cache_locate(g, vec3(x, g->low.y, g->low.z));
        for (int upper = 0; upper < 2; upper++) {
            const uint32_t at = upper ? place.upper[0] : place.lower[0];
            const float point = g->low.x + ((float)at + 0.031f) * g->step.x;
            const bool between = (x < wall) != (point < wall);
            apart += between ? 1 : 0;
            assert_int_equal(place.sees >> upper & 1, between ? 0 : 1);
        }
    }
    assert_true(apart > 0);
    air_cache_grids_finish(host.context, &grids);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_between_their_points),
        cmocka_unit_test(points_are_seen_unless_a_wall_is_between),
        cmocka_unit_test(the_last_grid_holds_all),
        cmocka_unit_test(walls_keep_light_on_their_side),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

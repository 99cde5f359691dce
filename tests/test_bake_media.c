/* What media scatter onto surfaces: exact against reference, and responses against independent
 * walks. */
#include "bake_tally.h"

/* Haze on a floor with a wall and a block, under the sun, or by a glowing panel. No light from all
 * around. */
static air_snapshot *foggy_room(const bake_host *host, bool panel, float albedo)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 1, 0), vec3(1.2f, 1.0f, 1.2f));
    set3(medium.sigma_s, 0.5f, 0.5f, 0.5f);
    set3(medium.sigma_a, 0.1f, 0.1f, 0.1f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = 0.4f;
    add_medium(scene, &medium);
    const air_handle grey = add_lambert(scene, albedo, 0.0f);
    add_floor(scene, 0.0f, 1.0f, grey);
    bake_add_box(scene, vec3(0.1f, 0, -0.4f), vec3(0.6f, 0.9f, 0.3f), false, grey);
    if (panel) {
        add_quad(scene, vec3(-1, 0.5f, 0.5f), vec3(0, 0, -1), vec3(0, 1, 0),
                 add_lambert(scene, 0.0f, 1.0f));
        return path_freeze(scene);
    }
    add_sun(scene, vec3(2.0f, 2.0f, 2.0f), vec3(-0.5f, -1.0f, 0.2f));
    return path_freeze(scene);
}

/* Both modes, layer by layer. Direct light and light by way of surfaces have no approximation in
 * them; nor has what one event scatters. The cached light is interpolated over cells of 0.4 m and
 * cut after band 2: 2.5 % of what media scatter over a bare floor of albedo 1/2, where with cells
 * of 0.15 m 1 % is left. */
static void compare(const bake_host *host, const air_snapshot *snapshot, uint32_t bounces,
                    uint32_t samples, double largest)
{
    static const char *const names[3] = {"direct.G", "indirect.G", "media.G"};
    tally layers[2][3];
    memset(layers, 0, sizeof layers);
    for (uint64_t seed = 0; seed < TALLY_SEEDS; seed++) {
        for (int mode = 0; mode < 2; mode++) {
            air_bake_params params = bake_raw_params(samples, 3.0f);
            params.media = mode == 0 ? AIR_BAKE_EXACT : AIR_BAKE_REFERENCE;
            params.seed = 100 + seed;
            params.max_bounces = bounces;
            params.cache_resolution = 6;
            params.cache_samples = 32;
            air_lightmap *lightmap = bake_well(host, snapshot, &params);
            for (int k = 0; k < 3; k++) {
                tally_add(&layers[mode][k], tally_page_mean(lightmap, names[k]));
            }
            air_lightmap_destroy(lightmap);
        }
    }
    for (int k = 0; k < 3; k++) {
        const double exact = tally_mean(&layers[0][k]), truth = tally_mean(&layers[1][k]);
        const double error = hypot(tally_error(&layers[0][k]), tally_error(&layers[1][k]));
        const double slack = k == 2 && bounces > 1 ? 0.03 * truth : 1e-6;
        print_message("%u bounces, %s: exact %.5g, reference %.5g, %+.2f %% +- %.2f %%\n", bounces,
                      names[k], exact, truth, truth > 0.0 ? 100.0 * (exact / truth - 1.0) : 0.0,
                      truth > 0.0 ? 100.0 * error / truth : 0.0);
        if (!(error <= largest * truth) || !(fabs(exact - truth) <= 5.0 * error + slack)) {
            fail_msg("%s: exact %.6g, reference %.6g +- %.2g", names[k], exact, truth, error);
        }
    }
}

static void exact_agrees_with_the_reference(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = foggy_room(&host, false, 0.5f);
    compare(&host, snapshot, UINT32_MAX, 16, 0.05);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* Counted alike, as far as surfaces reflect nothing. */
static void events_are_counted_as_in_the_reference(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = foggy_room(&host, false, 0.0f);
    compare(&host, snapshot, 0, 16, 0.01);
    compare(&host, snapshot, 1, 32, 0.01);
    compare(&host, snapshot, 2, 16, 0.02);
    air_snapshot_release(snapshot);
    snapshot = foggy_room(&host, true, 0.0f);
    compare(&host, snapshot, 1, 64, 0.05);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* Two clouds over a floor, small as seen from there; one of them in puffs, on demand. */
static air_scene *cloudy_scene(const bake_host *host, bool puffs)
{
    enum { SIDE = 6 };
    air_scene *scene = bake_scene(host);
    for (int i = 0; i < 2; i++) {
        const air_vec3 half = vec3(0.2f, 0.15f, 0.2f);
        const air_vec3 center = vec3(i == 0 ? -0.5f : 0.6f, 0.8f, 0.1f);
        air_medium_desc cloud = medium_in_box(center, half);
        set3(cloud.sigma_s, 3.0f, 3.0f, 3.0f);
        set3(cloud.sigma_a, 0.5f, 0.5f, 0.5f);
        cloud.phase.kind = AIR_PHASE_HG;
        cloud.phase.g = i == 0 ? 0.0f : 0.6f;
        if (puffs && i == 0) {
            float values[SIDE * SIDE * SIDE];
            for (size_t k = 0; k < SIDE * SIDE * SIDE; k++) {
                values[k] = k % 5 == 0 ? 3.0f : 0.0f;
            }
            cloud.density.kind = AIR_DENSITY_GRID;
            cloud.density.grid = add_box_grid(scene, SIDE, 1, values, center, half);
        }
        add_medium(scene, &cloud);
    }
    add_floor(scene, 0.0f, 1.0f, add_lambert(scene, 0.0f, 0.0f));
    return scene;
}

/* Under a sun, a lamp, and the lamp with puffs. */
static void clouds_are_found_from_afar(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    for (int kind = 0; kind < 3; kind++) {
        air_scene *scene = cloudy_scene(&host, kind == 2);
        if (kind > 0) {
            add_point_light(scene, vec3(0, 1.5f, 0), 1.0f);
        } else {
            add_sun(scene, vec3(2.0f, 2.0f, 2.0f), vec3(-0.5f, -1.0f, 0.2f));
        }
        air_snapshot *snapshot = path_freeze(scene);
        compare(&host, snapshot, 1, 256, 0.02);
        compare(&host, snapshot, UINT32_MAX, kind == 2 ? 256 : 64, 0.04);
        air_snapshot_release(snapshot);
    }
    bake_close(&host);
}

/* ---- responses ---- */

/* A lamp 2 m above a plane in haze without end, sigma_s = 0.3: irradiance of all that the haze
 * scatters up to ten times, by independent walks [Dubouchet2019, our reading, section 8]. */
typedef struct foot_row {
    float x;
    double direct, media, error;
} foot_row;

static const foot_row foot_rows[] = {
    {0, 1.37203e-01, 7.2197e-02 + 8.4738e-02, 1.4e-04},
    {2, 3.78341e-02, 2.7815e-02 + 5.4569e-02, 1.1e-04},
    {4, 5.84545e-03, 6.7269e-03 + 2.8101e-02, 6e-05},
};
enum { FOOT_ROWS = sizeof foot_rows / sizeof foot_rows[0] };

/* Of vertices, the mean over a mesh. */
static double vertex_mean(const air_vertex_light *light, air_light_layer layer)
{
    double sum = 0.0;
    for (size_t i = 0; i < light->vertex_count; i++) {
        sum += (double)light->layers[layer][3 * i + 1] / (double)light->vertex_count;
    }
    return sum;
}

/* Irradiance on a plane that looks up, by three bands: of light from one direction that is off by
 * 3/32 of it at most (test_bake_probes), so here by that share of the fluence. Corners of the
 * icosahedron, at which the light is asked for, know bands to degree 5 apart; what is above is part
 * of the bound. The 5 cm between probe and plane are 2.5 % of the way to the lamp. */
static void assert_probe_agrees(const air_probe_set *set, int probe_index, const foot_row *row)
{
    const float *media = set->layers[AIR_LAYER_MEDIA] + (size_t)27 * (size_t)probe_index;
    const float *direct = set->layers[AIR_LAYER_DIRECT] + (size_t)27 * (size_t)probe_index;
    const double k[9] = {0.282094792, 0.488602512, 0, 0, 0, 0, -0.315391565, 0, -0.546274215};
    double irradiance = 0.0;
    for (int i = 0; i < 9; i++) {
        const double factor = i == 0 ? AIR_PI : i < 4 ? 2.0 * AIR_PI / 3.0 : 0.25 * AIR_PI;
        irradiance += factor * k[i] * (double)media[3 * i + 1];
    }
    const double fluence = sqrt(4.0 * AIR_PI) * (double)media[1];
    assert_true(fluence > irradiance && fluence < 12.0 * row->media);
    bake_assert_near("probe", irradiance, row->media, 3.0 / 32.0 * fluence + 0.03 * row->media);
    /* of the lamp itself only what the way lets through: E = I h / r^3 T, and fluence E r / h */
    const double x = (double)row->x, r = sqrt(x * x + 1.95 * 1.95);
    bake_assert_near("lamp", sqrt(4.0 * AIR_PI) * (double)direct[1], exp(-0.3 * r) / (r * r), 1e-6);
}

/* Receivers of 1 cm, too small to stand in the light's way. Tables are within 0.5 % of the walks
 * (src/impulse/README.md); 4 standard errors of the walks are added. What lobes do is
 * test_impulse_lookup's matter. */
static void responses_in_endless_haze_are_the_truth(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    add_medium(scene, &medium);
    add_point_light(scene, vec3(0, 2, 0), 1.0f);
    for (int i = 0; i < FOOT_ROWS; i++) {
        bake_add_quad(scene, "receiver", vec3(foot_rows[i].x - 0.005f, 0, 0.005f),
                      vec3(0.01f, 0, 0), vec3(0, 0, -0.01f), NULL, add_lambert(scene, 0.0f, 0.0f));
    }
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(16, 1.0f);
    params.lightmaps = false;
    params.vertices = true;
    params.media = AIR_BAKE_IMPULSE;
    float positions[3 * FOOT_ROWS] = {0.0f};
    const air_probe_request request = {
        .name = "feet", .kind = AIR_PROBES_FREE, .positions = positions, .count = FOOT_ROWS};
    for (int i = 0; i < FOOT_ROWS; i++) {
        positions[3 * i] = foot_rows[i].x;
        positions[3 * i + 1] = 0.05f;
    }
    params.probes = &request;
    params.probe_count = 1;
    air_lightmap *lightmap = bake_well(&host, snapshot, &params);
    for (int i = 0; i < FOOT_ROWS; i++) {
        assert_probe_agrees(&lightmap->probe_sets[0], i, &foot_rows[i]);
        const foot_row *row = &foot_rows[i];
        const air_vertex_light *light = &lightmap->vertex_lights[i];
        /* over 1 cm light is off its middle's by a few 1e-5 */
        bake_assert_near("direct", vertex_mean(light, AIR_LAYER_DIRECT), row->direct,
                         1e-4 * row->direct);
        bake_assert_near("media", vertex_mean(light, AIR_LAYER_MEDIA), row->media,
                         4.0 * row->error + 0.005 * row->media);
    }
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* A ceiling sees the fog that a panel below it lights downwards, the panel's back between them and
 * not in the way. One event, in haze without end: from behind the table's finer angles are read
 * between, 3 % at most (src/impulse/README.md has 0.3 % of the largest irradiance before the panel,
 * eight times this one). */
static void fog_before_a_panel_lights_what_is_behind_it(void **state)
{
    static const float corners[12] = {-0.1f, 1, 0.1f,  -0.1f, 1, -0.1f,
                                      0.1f,  1, -0.1f, 0.1f,  1, 0.1f};
    bake_host host;
    double light[2];
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    air_medium_desc medium;
    air_light_desc panel;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    add_medium(scene, &medium);
    air_light_desc_default(&panel);
    panel.kind = AIR_LIGHT_POLYGON;
    panel.vertices = corners;
    panel.vertex_count = 4;
    set3(panel.color, 10.0f, 10.0f, 10.0f);
    add_light(scene, &panel);
    bake_add_quad(scene, "ceiling", vec3(-0.01f, 2, -0.01f), vec3(0.02f, 0, 0), vec3(0, 0, 0.02f),
                  NULL, add_lambert(scene, 0.0f, 0.0f));
    air_snapshot *snapshot = path_freeze(scene);
    for (int mode = 0; mode < 2; mode++) {
        air_bake_params params = bake_raw_params(4096, 1.0f);
        params.lightmaps = false;
        params.vertices = true;
        params.media = mode == 0 ? AIR_BAKE_EXACT : AIR_BAKE_IMPULSE;
        params.max_bounces = 1;
        params.impulse_bounces = 1;
        air_lightmap *lightmap = bake_well(&host, snapshot, &params);
        assert_true(vertex_mean(&lightmap->vertex_lights[0], AIR_LAYER_DIRECT) == 0.0);
        light[mode] = vertex_mean(&lightmap->vertex_lights[0], AIR_LAYER_MEDIA);
        air_lightmap_destroy(lightmap);
    }
    print_message("behind a panel: exact %.5g, impulse %.5g\n", light[0], light[1]);
    assert_true(light[0] > 0.0);
    bake_assert_near("media", light[1], light[0], 0.03 * light[0]);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_agrees_with_the_reference),
        cmocka_unit_test(events_are_counted_as_in_the_reference),
        cmocka_unit_test(clouds_are_found_from_afar),
        cmocka_unit_test(responses_in_endless_haze_are_the_truth),
        cmocka_unit_test(fog_before_a_panel_lights_what_is_behind_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

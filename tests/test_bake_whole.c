/* Whole bakes against what is known: furnaces, closed forms, independent walks, each other. */
#include "bake_tally.h"

/* ---- furnaces ---- */

/* A closed box whose walls send out 1/2 and reflect a half of what comes: the radiance within is 1
 * everywhere, also where a medium scatters all of it. */
static air_snapshot *furnace(const bake_host *host, float g)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 0, 0), vec3(0.8f, 0.95f, 0.95f));
    set3(medium.sigma_s, 0.9f, 0.9f, 0.9f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = g;
    add_medium(scene, &medium);
    bake_add_box(scene, vec3(-1, -1, -1), vec3(1, 1, 1), true, add_lambert(scene, 0.5f, 0.5f));
    return path_freeze(scene);
}

static void radiance_in_a_furnace_is_that_of_its_walls(void **state)
{
    static const air_bake_media modes[] = {AIR_BAKE_NONE, AIR_BAKE_EXACT, AIR_BAKE_REFERENCE};
    const float positions[6] = {0.1f, 0.2f, 0.3f, -0.9f, 0, 0};
    const air_probe_request request = {
        .name = "two", .kind = AIR_PROBES_FREE, .positions = positions, .count = 2};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = furnace(&host, 0.3f);
    for (size_t m = 0; m < sizeof modes / sizeof modes[0]; m++) {
        tally texels = {.count = 0}, vertices = texels, along = texels;
        tally probes[2] = {texels, texels};
        for (uint64_t seed = 0; seed < TALLY_SEEDS; seed++) {
            air_bake_params params = bake_raw_params(32, 2.0f);
            params.media = modes[m];
            params.seed = seed;
            params.cache_resolution = 4;
            params.cache_samples = 32;
            params.vertices = true;
            params.probes = &request;
            params.probe_count = 1;
            air_lightmap *lightmap = bake_well(&host, snapshot, &params);
            double sum = 0.0;
            for (size_t i = 0; i < lightmap->vertex_light_count; i++) {
                for (size_t k = 0; k < 4 * AIR_LAYER_COUNT; k++) {
                    const float *layer = lightmap->vertex_lights[i].layers[k / 4];
                    sum += (double)layer[3 * (k % 4) + 1] / 24.0;
                }
            }
            tally_add(&texels, tally_page_mean(lightmap, "G"));
            tally_add(&vertices, sum);
            for (size_t i = 0; i < 2; i++) {
                double values[2] = {0.0, 0.0};
                for (int layer = 0; layer < AIR_LAYER_COUNT; layer++) {
                    values[0] += (double)lightmap->probe_sets[0].layers[layer][27 * i + 1];
                    values[1] += (double)lightmap->probe_sets[0].layers[layer][27 * i + 10];
                }
                tally_add(&probes[i], values[0]);
                tally_add(&along, values[1]);
            }
            assert_true((tally_page_mean(lightmap, "media.G") > 0.1) ==
                        (modes[m] != AIR_BAKE_NONE));
            air_lightmap_destroy(lightmap);
        }
        const char *name = air_bake_media_name(modes[m]);
        assert_tally(name, &texels, AIR_PI, 0.02, 1e-5);
        assert_tally(name, &vertices, AIR_PI, 0.06, 1e-5);
        assert_tally(name, &probes[0], sqrt(4.0 * AIR_PI), 0.2, 1e-5);
        assert_tally(name, &probes[1], sqrt(4.0 * AIR_PI), 0.2, 1e-5);
        assert_tally(name, &along, 0.0, 0.2, 1e-5);
    }
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* Attenuated, what the medium takes away is missing; nothing is scattered. */
static void attenuation_only_takes_away(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = furnace(&host, 0.0f);
    air_bake_params params = bake_raw_params(64, 2.0f);
    params.media = AIR_BAKE_ATTENUATE;
    air_lightmap *lightmap = bake_well(&host, snapshot, &params);
    assert_true(tally_page_mean(lightmap, "media.G") == 0.0);
    /* no ray is longer than 2 sqrt(3) m in the box, E is less than by a transmittance of 1 */
    assert_true(tally_page_mean(lightmap, "G") < 0.9 * AIR_PI);
    assert_true(tally_page_mean(lightmap, "G") > AIR_PI * 0.5 * exp(-0.9 * 2.0 * sqrt(3.0)));
    assert_string_equal(lightmap->media, "attenuate");
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* ---- a lamp over a floor ---- */

/* 2 m x 2 m of floor, a lamp of 1 W/sr 1 m above it; haze without end on demand. */
static air_snapshot *lamp_scene(const bake_host *host, float sigma_s, float sigma_a)
{
    air_scene *scene = bake_scene(host);
    if (sigma_s + sigma_a > 0.0f) {
        air_medium_desc medium;
        air_medium_desc_default(&medium);
        medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
        set3(medium.sigma_s, sigma_s, sigma_s, sigma_s);
        set3(medium.sigma_a, sigma_a, 2.0f * sigma_a, 0.0f);
        add_medium(scene, &medium);
    }
    bake_add_quad(scene, "floor", vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2), bake_unit_uv,
                  add_lambert(scene, 0.5f, 0.0f));
    add_point_light(scene, vec3(0.2f, 1, 0), 1.0f);
    return path_freeze(scene);
}

/* The mean over a texel of h / r^3 exp(-sigma r), by 16 x 16 midpoints. */
static double lamp_irradiance(double x0, double z0, double side, double sigma)
{
    double sum = 0.0;
    for (int i = 0; i < 256; i++) {
        const double x = x0 + side * (i % 16 + 0.5) / 16.0 - 0.2;
        const double z = z0 + side * (i / 16 + 0.5) / 16.0;
        const double r = sqrt(1.0 + x * x + z * z);
        sum += exp(-sigma * r) / (r * r * r) / 256.0;
    }
    return sum;
}

/* Each texel within 1e-3: its light varies by some 20 %, with a deviation of 6 %, of which 256
 * independent samples would miss 0.4 %, those of a (0, 2) sequence far less. */
static void attenuated_light_of_a_lamp_is_the_closed_form(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = lamp_scene(&host, 0.4f, 0.3f);
    for (int media = AIR_BAKE_NONE; media <= AIR_BAKE_ATTENUATE; media++) {
        air_bake_params params = bake_raw_params(256, 8.0f);
        params.media = (air_bake_media)media;
        params.padding = 0;
        air_lightmap *lightmap = bake_well(&host, snapshot, &params);
        const air_image *page = lightmap->pages[0];
        assert_int_equal(air_image_width(page), 16);
        const char *const names[3] = {"R", "G", "B"};
        const double sigmas[3] = {0.7, 1.0, 0.4};
        for (int c = 0; c < 3; c++) {
            const float *plane = bake_plane(page, names[c]);
            for (int i = 0; i < 256; i++) {
                const double x = -1.0 + 0.125 * (i % 16), z = 1.0 - 0.125 * (i / 16 + 1);
                const double expected =
                    lamp_irradiance(x, z, 0.125, media == AIR_BAKE_NONE ? 0.0 : sigmas[c]);
                bake_assert_near(names[c], (double)plane[i], expected, 1e-3 * expected);
            }
        }
        assert_true(tally_page_mean(lightmap, "media.G") == 0.0);
        air_lightmap_destroy(lightmap);
    }
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void without_media_fog_changes_no_byte(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *clear = lamp_scene(&host, 0.0f, 0.0f), *foggy = lamp_scene(&host, 0.4f, 0.3f);
    air_bake_params params = bake_raw_params(8, 4.0f);
    params.vertices = true;
    params.media = AIR_BAKE_NONE;
    air_lightmap *a = bake_well(&host, clear, &params), *b = bake_well(&host, foggy, &params);
    bake_assert_same(a, b);
    air_lightmap_destroy(b);
    /* and where there is no fog, all ways to treat it are one */
    for (int media = AIR_BAKE_ATTENUATE; media < AIR_BAKE_MEDIA_COUNT; media++) {
        params.media = (air_bake_media)media;
        b = bake_well(&host, clear, &params);
        bake_assert_same(a, b);
        air_lightmap_destroy(b);
    }
    air_lightmap_destroy(a);
    air_snapshot_release(clear);
    air_snapshot_release(foggy);
    bake_close(&host);
}

/* Light asked for at a lamp is no matter of chance: with no bounce only that is left, and it is the
 * same whatever is made of the media. */
static void direct_light_alone_is_the_same_in_all_modes_with_media(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = lamp_scene(&host, 0.4f, 0.3f);
    air_bake_params params = bake_raw_params(16, 4.0f);
    params.max_bounces = 0;
    params.media = AIR_BAKE_ATTENUATE;
    air_lightmap *a = bake_well(&host, snapshot, &params);
    const air_bake_media modes[] = {AIR_BAKE_EXACT, AIR_BAKE_REFERENCE};
    for (size_t m = 0; m < 2; m++) {
        params.media = modes[m];
        air_lightmap *b = bake_well(&host, snapshot, &params);
        const double expected = tally_page_mean(a, "direct.G");
        bake_assert_near("direct", tally_page_mean(b, "direct.G"), expected, 1e-5 * expected);
        assert_true(tally_page_mean(b, "media.G") == 0.0 &&
                    tally_page_mean(b, "indirect.G") == 0.0);
        air_lightmap_destroy(b);
    }
    air_lightmap_destroy(a);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radiance_in_a_furnace_is_that_of_its_walls),
        cmocka_unit_test(attenuation_only_takes_away),
        cmocka_unit_test(attenuated_light_of_a_lamp_is_the_closed_form),
        cmocka_unit_test(without_media_fog_changes_no_byte),
        cmocka_unit_test(direct_light_alone_is_the_same_in_all_modes_with_media),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

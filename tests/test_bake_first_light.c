/* Final gathering: paths that end in the light of a first pass bring what whole paths do. */
#include "bake_tally.h"

/* A room with a lamp and a sun in its doorway, a double-sided screen that is seen from both sides,
 * a block of polished metal, one of glossy paint, and haze in all of it. */
static air_snapshot *crowded_room(const bake_host *host)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 1, 0), vec3(1.4f, 0.95f, 1.4f));
    air_material_desc material;
    air_light_desc sun;
    air_handle metal, paint, screen;
    set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    set3(medium.sigma_a, 0.1f, 0.1f, 0.1f);
    add_medium(scene, &medium);
    air_material_desc_default(&material);
    set3(material.base_color, 0.9f, 0.8f, 0.7f);
    material.metallic = 1.0f;
    material.roughness = 0.3f;
    assert_int_equal(air_scene_add_material(scene, &material, &metal), AIR_OK);
    air_material_desc_default(&material);
    set3(material.base_color, 0.6f, 0.6f, 0.6f);
    material.roughness = 0.4f;
    assert_int_equal(air_scene_add_material(scene, &material, &paint), AIR_OK);
    material.specular = 0.0f;
    material.double_sided = true;
    assert_int_equal(air_scene_add_material(scene, &material, &screen), AIR_OK);
    bake_add_box(scene, vec3(-1.5f, 0, -1.5f), vec3(1.5f, 2, 1.5f), true,
                 add_lambert(scene, 0.7f, 0.0f));
    bake_add_box(scene, vec3(-1.2f, 0, -1.2f), vec3(-0.7f, 0.8f, -0.7f), false, metal);
    bake_add_box(scene, vec3(0.6f, 0, -1.1f), vec3(1.1f, 0.5f, -0.6f), false, paint);
    bake_add_quad(scene, "screen", vec3(-0.8f, 0.3f, 0.4f), vec3(1.6f, 0, 0.2f), vec3(0, 1, 0),
                  NULL, screen);
    add_point_light(scene, vec3(0.4f, 1.6f, -0.2f), 1.0f);
    air_light_desc_default(&sun);
    sun.kind = AIR_LIGHT_COLLIMATED;
    sun.casts_shadow = false;
    set3(sun.color, 0.3f, 0.3f, 0.3f);
    set3(sun.dir, -0.3f, -1.0f, 0.8f);
    add_light(scene, &sun);
    return path_freeze(scene);
}

/* What varies within a texel of 1/4 m is seen as its mean, and what is hidden of one as if it were
 * seen: 0.5 % are left to it. */
static void compare(const bake_host *host, const air_snapshot *snapshot, air_bake_media media,
                    uint32_t bounces, const air_impulse_tables *tables)
{
    static const char *const names[3] = {"direct.G", "indirect.G", "media.G"};
    tally layers[2][3];
    memset(layers, 0, sizeof layers);
    for (uint64_t seed = 0; seed < TALLY_SEEDS; seed++) {
        for (int whole = 0; whole < 2; whole++) {
            air_bake_params params = bake_raw_params(32, 4.0f);
            params.media = media;
            params.impulse_tables = tables;
            params.seed = 300 + seed;
            params.max_bounces = bounces;
            params.final_gather = whole == 0;
            params.cache_resolution = 6;
            params.cache_samples = 32;
            air_lightmap *lightmap = bake_well(host, snapshot, &params);
            for (int k = 0; k < 3; k++) {
                tally_add(&layers[whole][k], tally_page_mean(lightmap, names[k]));
            }
            air_lightmap_destroy(lightmap);
        }
    }
    for (int k = 0; k < 3; k++) {
        const double mean = tally_mean(&layers[0][k]), truth = tally_mean(&layers[1][k]);
        const double error = hypot(tally_error(&layers[0][k]), tally_error(&layers[1][k]));
        print_message("%s, %u bounces, %s: %.5g, whole paths %.5g: %+.2f %% +- %.2f %%\n",
                      air_bake_media_name(media), bounces, names[k], mean, truth,
                      truth > 0.0 ? 100.0 * (mean / truth - 1.0) : 0.0,
                      truth > 0.0 ? 100.0 * error / truth : 0.0);
        if (!(error <= 0.01 * truth) || !(fabs(mean - truth) <= 5.0 * error + 0.005 * truth)) {
            fail_msg("%s: %.6g, expected %.6g +- %.2g", names[k], mean, truth, error);
        }
    }
}

static void first_light_ends_paths_without_a_change(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = crowded_room(&host);
    compare(&host, snapshot, AIR_BAKE_ATTENUATE, UINT32_MAX, NULL);
    compare(&host, snapshot, AIR_BAKE_ATTENUATE, 1, NULL);
    compare(&host, snapshot, AIR_BAKE_ATTENUATE, 2, NULL);
    compare(&host, snapshot, AIR_BAKE_EXACT, UINT32_MAX, NULL);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void responses_stay_as_well(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = crowded_room(&host);
    air_impulse_params coarse; /* the same for both */
    air_impulse_tables *tables;
    air_impulse_params_default(&coarse);
    coarse.bins = 16;
    coarse.angles = 4;
    assert_int_equal(air_impulse_tables_create(host.context, &coarse, &tables), AIR_OK);
    compare(&host, snapshot, AIR_BAKE_IMPULSE, UINT32_MAX, tables);
    air_impulse_tables_destroy(tables);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_light_ends_paths_without_a_change),
        cmocka_unit_test(responses_stay_as_well),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

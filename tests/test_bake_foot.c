/* The end-to-end scene of our reading of [Dubouchet2019], section 8: a point light of 1 W/sr two
 * metres above a floor in haze without end, sigma_s = 0.3: what each treatment of media makes of
 * it. */
#include <stdio.h>

#include "bake/cache.h"
#include "bake/respond.h"
#include "path_scene.h"

/* By 700,000 independent walks, with standard errors; floor: -1 none, else its albedo. */
typedef struct foot_row {
    float x, g, floor;
    double direct, once, once_error, more, more_error, by_floor;
} foot_row;

static const foot_row rows[] = {
    {0, 0, -1, 1.37203e-01, 7.2197e-02, 9e-05, 8.4738e-02, 1e-04, 0},
    {2, 0, -1, 3.78341e-02, 2.7815e-02, 4e-05, 5.4569e-02, 1e-04, 0},
    {4, 0, -1, 5.84545e-03, 6.7269e-03, 1e-05, 2.8101e-02, 6e-05, 0},
    {6, 0, -1, 1.18556e-03, 1.9239e-03, 3e-06, 1.5119e-02, 5e-05, 0},
    {0, 0, 0, 1.37203e-01, 7.2180e-02, 9e-05, 7.3148e-02, 1e-04, 0},
    {2, 0, 0, 3.78341e-02, 2.7754e-02, 4e-05, 4.4868e-02, 1e-04, 0},
    {4, 0, 0, 5.84545e-03, 6.7041e-03, 1e-05, 2.0969e-02, 5e-05, 0},
    {0, 0, 0.5f, 1.37203e-01, 7.2220e-02, 9e-05, 7.2888e-02, 1e-04, 3.349e-02},
    {2, 0, 0.5f, 3.78341e-02, 2.7834e-02, 4e-05, 4.4614e-02, 1e-04, 2.066e-02},
    {0, 0.5f, -1, 1.37203e-01, 7.7412e-02, 2e-04, 4.9401e-02, 3e-04, 0},
    {2, 0.5f, -1, 3.78341e-02, 3.0049e-02, 8e-05, 3.1864e-02, 2e-04, 0},
    {6, 0.5f, -1, 1.18556e-03, 2.1571e-03, 6e-06, 1.0359e-02, 1e-04, 0},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static air_snapshot *foot_scene(void **state, const foot_row *row)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = row->g;
    add_medium(scene, &medium);
    add_point_light(scene, vec3(0, 2, 0), 1.0f);
    if (row->floor >= 0.0f) {
        add_floor(scene, 0.0f, 100.0f, add_lambert(scene, row->floor, 0.0f));
    }
    return path_freeze(scene);
}

static bool draw(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    (void)site, (void)u;
    *out = (air_path_receiver){.position = vec3(*(const float *)user, 0, 0),
                               .normal = {0, 1, 0},
                               .geometric = {0, 1, 0},
                               .offset = 1e-5f};
    return true;
}

/* Irradiance of the three layers, green. */
static void measure(const air_snapshot *snapshot, const air_sobol *sobol,
                    const air_path_settings *settings, float x, uint32_t samples,
                    double out[AIR_LAYER_COUNT])
{
    air_path path;
    assert_int_equal(air_path_init(&path, snapshot, sobol, settings), AIR_OK);
    air_site_list list = {
        .what = "foot", .count = 1, .draw = draw, .user = &x, .seed = 1, .samples = samples};
    assert_int_equal(air_sites_run(&path, &list, NULL, 0.0, 1.0), AIR_OK);
    for (int layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        out[layer] = (double)list.records[AIR_SITE_LIGHT + 3 * layer + 1];
    }
    air_free(snapshot->context, list.records);
    air_path_finish(&path);
}

static air_sobol *make_sobol(void)
{
    air_sobol *sobol = malloc(sizeof *sobol);
    assert_non_null(sobol);
    air_sobol_init(sobol);
    return sobol;
}

static void responses(void **state, bool literal)
{
    air_sobol *sobol = make_sobol();
    for (int i = 0; i < ROWS; i += 1) {
        const foot_row *row = &rows[i];
        air_snapshot *snapshot = foot_scene(state, row);
        const air_responder_params params = {literal, 10};
        air_responder *responder;
        double got[AIR_LAYER_COUNT];
        assert_int_equal(air_responder_create(*state, snapshot, &params, &responder), AIR_OK);
        const air_path_settings settings = {.max_depth = UINT32_MAX,
                                            .terms = AIR_TERMS_ALL,
                                            .media = AIR_PATH_ATTENUATE,
                                            .respond = air_responder_hooks(responder)};
        measure(snapshot, sobol, &settings, row->x, 64, got);
        const double truth = row->once + row->more;
        printf("x %g g %g floor %g: direct %+.4f media %.5g of %.5g: %+.4f\n", (double)row->x,
               (double)row->g, (double)row->floor, got[0] / row->direct - 1, got[2], truth,
               got[2] / truth - 1);
        air_responder_destroy(responder);
        air_snapshot_release(snapshot);
    }
    free(sobol);
}

static void literal_responses(void **state) { responses(state, true); }
static void better_responses(void **state) { responses(state, false); }

static void exact(void **state)
{
    air_sobol *sobol = make_sobol();
    for (int i = 0; i < ROWS; i += 1) {
        const foot_row *row = &rows[i];
        air_snapshot *snapshot = foot_scene(state, row);
        const air_light_cache_params params = {12, 128, 11, 7};
        air_light_cache *cache;
        double got[AIR_LAYER_COUNT];
        assert_int_equal(
            air_light_cache_create(*state, snapshot, sobol, &params, NULL, 1.0, &cache), AIR_OK);
        const air_path_settings settings = {.max_depth = 11,
                                            .terms = AIR_TERMS_ALL,
                                            .media = AIR_PATH_GATHER,
                                            .source = {air_light_cache_scattered, cache, true}};
        measure(snapshot, sobol, &settings, row->x, 16384, got);
        const double truth = row->once + row->more;
        printf("x %g g %g floor %g: direct %+.4f media %.5g of %.5g: %+.4f (floor %.5g)\n",
               (double)row->x, (double)row->g, (double)row->floor, got[0] / row->direct - 1, got[2],
               truth, got[2] / truth - 1, got[2] + got[1] - truth);
        air_light_cache_destroy(cache);
        air_snapshot_release(snapshot);
    }
    free(sobol);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        // cmocka_unit_test(literal_responses),
        // cmocka_unit_test(better_responses),
        cmocka_unit_test(exact),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

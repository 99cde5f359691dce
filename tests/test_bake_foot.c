/* The end-to-end scene of our reading of [Dubouchet2019], section 8: a point light of 1 W/sr two
 * metres above a floor in haze without end, sigma_s = 0.3: what each treatment of media makes of
 * it. */
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
    air_site_list list = {.what = "foot",
                          .count = 1,
                          .draw = draw,
                          .user = &x,
                          .seed = 1,
                          .samples = samples,
                          .through = samples};
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

/* What the model of responses gives for each row, relative to the truth. */
static void respond_all(void **state, bool literal, double out[ROWS])
{
    air_sobol *sobol = make_sobol();
    air_impulse_tables *tables;
    air_impulse_params table;
    air_impulse_params_paper(&table);
    if (!literal) {
        table.form = AIR_IMPULSE_SH5;
        table.angles = 16;
    }
    assert_int_equal(air_impulse_tables_create(*state, &table, &tables), AIR_OK);
    for (int i = 0; i < ROWS; i++) {
        const foot_row *row = &rows[i];
        air_snapshot *snapshot = foot_scene(state, row);
        const air_responder_params params = {literal, 10, tables};
        air_responder *responder;
        double got[AIR_LAYER_COUNT];
        assert_int_equal(air_responder_create(*state, snapshot, &params, &responder), AIR_OK);
        const air_path_settings settings = {.max_depth = UINT32_MAX,
                                            .terms = AIR_TERMS_ALL,
                                            .media = AIR_PATH_ATTENUATE,
                                            .respond = air_responder_hooks(responder)};
        measure(snapshot, sobol, &settings, row->x, 16, got);
        assert_true(fabs(got[AIR_LAYER_DIRECT] / row->direct - 1.0) < 1e-5);
        out[i] = got[AIR_LAYER_MEDIA];
        air_responder_destroy(responder);
        air_snapshot_release(snapshot);
    }
    air_impulse_tables_destroy(tables);
    free(sobol);
}

/* Without a floor and with isotropic scattering the tables are right: one event within 0.5 %, two
 * to ten within 1 %, and three standard errors of the walks. */
static void responses_are_right_in_haze_without_end(void **state)
{
    for (int literal = 0; literal < 2; literal++) {
        double got[ROWS];
        respond_all(state, literal != 0, got);
        for (int i = 0; i < ROWS; i++) {
            const foot_row *row = &rows[i];
            const double truth = row->once + row->more;
            const double slack =
                0.005 * row->once + 0.01 * row->more + 3.0 * (row->once_error + row->more_error);
            if (row->floor < 0.0f && row->g == 0.0f && !(fabs(got[i] - truth) < slack)) {
                fail_msg("x %g: %.5g, expected %.5g +- %.2g", (double)row->x, got[i], truth, slack);
            }
        }
    }
}

/* The stated failures of the model: light that a floor would stop is counted, 16 to 45 % of what
 * two and more events bring; and forward scattering after the first event, by the paper's rule 4 to
 * 34 % too low, by the better one 1 to 13 % off. */
static void responses_fail_as_stated(void **state)
{
    double literal[ROWS], better[ROWS];
    respond_all(state, true, literal);
    respond_all(state, false, better);
    for (int i = 0; i < ROWS; i++) {
        const foot_row *row = &rows[i];
        const double truth = row->once + row->more;
        const double lost = (literal[i] - truth) / row->more;
        const double rest = (better[i] - truth) / row->more;
        print_message(
            "x %g, g %g, floor %g: literal %+.1f %%, better %+.1f %%; of two to ten events "
            "alone %+.1f, %+.1f %%\n",
            (double)row->x, (double)row->g, (double)row->floor, 100.0 * (literal[i] / truth - 1.0),
            100.0 * (better[i] / truth - 1.0), 100.0 * lost, 100.0 * rest);
        if (row->floor >= 0.0f && !(lost > 0.14 && lost < 0.47)) {
            fail_msg("x %g, floor: %+.3f", (double)row->x, lost);
        }
        if (row->g > 0.0f &&
            !(lost < -0.02 && lost > -0.37 && fabs(rest) < 0.15 && fabs(rest) < fabs(lost))) {
            fail_msg("x %g, g %g: %+.3f, better %+.3f", (double)row->x, (double)row->g, lost, rest);
        }
    }
}

/* Above a floor, black or grey, cached light is what the model of responses is not: within 6 % of
 * all that fog and floor bring, three times the noise of the coarse cache here (2 % over three
 * seeds), where responses are 8 to 26 % off. */
static void cached_light_knows_the_floor(void **state)
{
    static const int chosen[] = {1, 6, 8};
    air_sobol *sobol = make_sobol();
    for (size_t i = 0; i < sizeof chosen / sizeof chosen[0]; i++) {
        const foot_row *row = &rows[chosen[i]];
        air_snapshot *snapshot = foot_scene(state, row);
        const air_light_cache_params params = {
            .resolution = 12, .samples = 256, .max_depth = 10, .seed = 7};
        air_light_cache *cache;
        double got[AIR_LAYER_COUNT];
        assert_int_equal(
            air_light_cache_create(*state, snapshot, sobol, &params, NULL, 1.0, &cache), AIR_OK);
        const air_path_settings settings = {.max_depth = 11,
                                            .terms = AIR_TERMS_ALL,
                                            .media = AIR_PATH_GATHER,
                                            .source = {air_light_cache_scattered, cache, true}};
        measure(snapshot, sobol, &settings, row->x, 8192, got);
        const double truth = row->once + row->more + row->by_floor;
        print_message("x %g, floor %g: cached light %+.1f %%\n", (double)row->x, (double)row->floor,
                      100.0 * ((got[AIR_LAYER_MEDIA] + got[AIR_LAYER_INDIRECT]) / truth - 1.0));
        if (!(fabs(got[AIR_LAYER_MEDIA] + got[AIR_LAYER_INDIRECT] - truth) < 0.06 * truth)) {
            fail_msg("x %g: %.5g, expected %.5g", (double)row->x,
                     got[AIR_LAYER_MEDIA] + got[AIR_LAYER_INDIRECT], truth);
        }
        air_light_cache_destroy(cache);
        air_snapshot_release(snapshot);
    }
    free(sobol);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(responses_are_right_in_haze_without_end),
        cmocka_unit_test(responses_fail_as_stated),
        cmocka_unit_test(cached_light_knows_the_floor),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

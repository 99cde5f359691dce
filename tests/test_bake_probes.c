/* Probes: where they are, and that their coefficients are those of the light around them. */
#include "bake/probes.h"
#include "bake_fixture.h"
#include "core/harmonics.h"

/* ---- where ---- */

/* A floor of 4 m x 1 m and a lamp's wall of 2 m: bounds from (0, 0, 0) to (4, 2, 1). */
static air_snapshot *corner_scene(const bake_host *host)
{
    air_scene *scene = bake_scene(host);
    add_quad(scene, vec3(0, 0, 1), vec3(4, 0, 0), vec3(0, 0, -1), AIR_NONE);
    add_quad(scene, vec3(0, 0, 1), vec3(0, 0, -1), vec3(0, 2, 0), AIR_NONE);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    return path_freeze(scene);
}

static void free_set(air_context *context, air_probe_set *set)
{
    air_free(context, set->name);
    air_free(context, set->positions);
    air_free(context, set->validity);
    for (int k = 0; k < AIR_LAYER_COUNT; k++) {
        air_free(context, set->layers[k]);
    }
}

static void assert_position(const air_probe_set *set, size_t number, double x, double y, double z)
{
    bake_assert_near("x", (double)set->positions[3 * number], x, 1e-6);
    bake_assert_near("y", (double)set->positions[3 * number + 1], y, 1e-6);
    bake_assert_near("z", (double)set->positions[3 * number + 2], z, 1e-6);
}

static void a_grid_counts_its_first_axis_fastest(void **state)
{
    const air_probe_request request = {.name = "grid",
                                       .kind = AIR_PROBES_GRID,
                                       .size = {3, 2, 2},
                                       .origin = {0.5f, 0.25f, 0.125f},
                                       .step = {{1, 0, 0}, {0, 0, 0.5f}, {0.125f, 1, 0}}};
    bake_host host;
    air_probe_set set;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = corner_scene(&host);
    assert_int_equal(air_probes_place(host.context, snapshot, &request, &set), AIR_OK);
    assert_int_equal(set.count, 12);
    assert_true(set.grid);
    assert_string_equal(set.name, "grid");
    for (size_t k = 0; k < 2; k++) {
        for (size_t j = 0; j < 2; j++) {
            for (size_t i = 0; i < 3; i++) {
                const double di = (double)i, dj = (double)j, dk = (double)k;
                assert_position(&set, i + 3 * (j + 2 * k), 0.5 + di + 0.125 * dk, 0.25 + dk,
                                0.125 + 0.5 * dj);
            }
        }
    }
    assert_int_equal(host.warnings, 0);
    free_set(host.context, &set);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void automatic_probes_lie_in_the_middle_of_cells(void **state)
{
    static const struct {
        float spacing;
        size_t size[3];
    } cases[] = {{1.0f, {4, 2, 1}}, {0.7f, {6, 3, 2}}, {9.0f, {1, 1, 1}}, {0.5f, {8, 4, 2}}};
    const double extents[3] = {4.0, 2.0, 1.0};
    bake_host host;
    air_probe_set set;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = corner_scene(&host);
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const air_probe_request request = {
            .name = "auto", .kind = AIR_PROBES_AUTO, .spacing = cases[n].spacing};
        assert_int_equal(air_probes_place(host.context, snapshot, &request, &set), AIR_OK);
        double step[3];
        for (int k = 0; k < 3; k++) {
            assert_int_equal(set.size[k], cases[n].size[k]);
            step[k] = extents[k] / (double)set.size[k];
            assert_true(step[k] <= (double)cases[n].spacing * 1.001);
            bake_assert_near("step", (double)set.step[k][k], step[k], 1e-6);
        }
        assert_int_equal(set.count, set.size[0] * set.size[1] * set.size[2]);
        assert_position(&set, 0, 0.5 * step[0], 0.5 * step[1], 0.5 * step[2]);
        assert_position(&set, set.count - 1, 4.0 - 0.5 * step[0], 2.0 - 0.5 * step[1],
                        1.0 - 0.5 * step[2]);
        free_set(host.context, &set);
    }
    assert_int_equal(host.warnings, 0);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void free_probes_are_where_they_are_put(void **state)
{
    const float positions[9] = {1, 1.5f, 0.5f, 0, 0, 0, 2000, 1, -5};
    const air_probe_request request = {
        .name = "free", .kind = AIR_PROBES_FREE, .positions = positions, .count = 3};
    const air_probe_request none = {.name = "none", .kind = AIR_PROBES_FREE};
    bake_host host;
    air_probe_set set;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = corner_scene(&host);
    assert_int_equal(air_probes_place(host.context, snapshot, &request, &set), AIR_OK);
    assert_int_equal(set.count, 3);
    assert_false(set.grid);
    assert_memory_equal(set.positions, positions, sizeof positions);
    assert_int_equal(host.warnings, 1);
    bake_expect_warning(&host, "probes \"free\": 1 of 3 are far outside of the scene, the first, "
                               "2, at (2000, 1, -5)");
    free_set(host.context, &set);
    assert_int_equal(air_probes_place(host.context, snapshot, &none, &set), AIR_OK);
    assert_int_equal(set.count, 0);
    free_set(host.context, &set);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void requests_that_mean_nothing_are_refused_by_name(void **state)
{
    static const float bad[6] = {0, 0, 0, 1, NAN, 0};
    static const struct {
        air_probe_request request;
        const char *says;
    } cases[] = {
        {{.kind = AIR_PROBES_FREE, .positions = bad, .count = 2}, "position 1 is not finite"},
        {{.kind = AIR_PROBES_FREE, .count = 2}, "no positions"},
        {{.kind = AIR_PROBES_GRID, .size = {0, 1, 1}}, "a size of 1 to 16777216 along axis 0"},
        {{.kind = AIR_PROBES_GRID, .size = {1, 16777217, 1}}, "along axis 1"},
        {{.kind = AIR_PROBES_GRID, .size = {1, 1, SIZE_MAX}}, "along axis 2"},
        {{.kind = AIR_PROBES_GRID, .size = {4096, 4096, 2}}, "4096 x 4096 x 2 are more than"},
        {{.kind = AIR_PROBES_GRID, .size = {16777216, 16777216, 16777216}}, "are more than"},
        {{.kind = AIR_PROBES_GRID, .size = {1, 1, 1}, .origin = {0, 0, INFINITY}}, "finite"},
        {{.kind = AIR_PROBES_GRID, .size = {2, 1, 1}, .step = {{NAN, 0, 0}}}, "finite"},
        {{.kind = AIR_PROBES_AUTO, .spacing = 0.0f}, "a positive spacing, got 0"},
        {{.kind = AIR_PROBES_AUTO, .spacing = -1.0f}, "a positive spacing, got -1"},
        {{.kind = AIR_PROBES_AUTO, .spacing = NAN}, "a positive spacing"},
        {{.kind = AIR_PROBES_AUTO, .spacing = INFINITY}, "a positive spacing"},
        {{.kind = AIR_PROBES_AUTO, .spacing = 1e-9f}, "probes along one side"},
        {{.kind = AIR_PROBES_AUTO, .spacing = 1e-3f}, "are more than"},
        {{.kind = (air_probe_kind)3, .count = 1, .positions = bad}, "kind 3"},
    };
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = corner_scene(&host);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        air_probe_request request = cases[i].request;
        air_bake_params params = bake_raw_params(1, 1.0f);
        air_lightmap *lightmap = NULL;
        request.name = "hall";
        params.lightmaps = false;
        params.probes = &request;
        params.probe_count = 1;
        if (air_bake(host.context, snapshot, &params, &lightmap, NULL) != AIR_ERROR_ARGUMENT) {
            fail_msg("case %zu is accepted", i);
        }
        assert_null(lightmap);
        bake_expect(&host, "probes \"hall\": ");
        bake_expect(&host, cases[i].says);
    }
    air_snapshot_release(snapshot);
    bake_close(&host);
}

static void a_scene_without_bounds_has_no_automatic_probes(void **state)
{
    const air_probe_request request = {.name = "sky", .kind = AIR_PROBES_AUTO, .spacing = 1.0f};
    bake_host host;
    air_lightmap *lightmap = NULL;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(1, 1.0f);
    params.lightmaps = false;
    params.probes = &request;
    params.probe_count = 1;
    assert_int_equal(air_bake(host.context, snapshot, &params, &lightmap, NULL),
                     AIR_ERROR_ARGUMENT);
    bake_expect(&host, "probes \"sky\": the scene has no bounds");
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* ---- their light ---- */

enum { COUNT = AIR_PROBE_COEFFICIENTS, SEEDS = 16 };

/* Coefficients of one probe, all layers together, green, with standard errors over seeds. */
typedef struct probed {
    double mean[COUNT], error[COUNT], validity;
} probed;

static probed probe_at(const bake_host *host, const air_snapshot *snapshot, air_vec3 position,
                       uint32_t samples)
{
    probed out;
    double squares[COUNT] = {0.0};
    const float at[3] = {position.x, position.y, position.z};
    const air_probe_request request = {
        .name = "p", .kind = AIR_PROBES_FREE, .positions = at, .count = 1};
    memset(&out, 0, sizeof out);
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        air_bake_params params = bake_raw_params(samples, 1.0f);
        params.lightmaps = false;
        params.probes = &request;
        params.probe_count = 1;
        params.seed = seed;
        air_lightmap *lightmap = bake_well(host, snapshot, &params);
        const air_probe_set *set = &lightmap->probe_sets[0];
        for (int i = 0; i < COUNT; i++) {
            const double value = (double)set->layers[0][3 * i + 1] +
                                 (double)set->layers[1][3 * i + 1] +
                                 (double)set->layers[2][3 * i + 1];
            out.mean[i] += value / SEEDS;
            squares[i] += value * value / SEEDS;
        }
        out.validity += (double)set->validity[0] / SEEDS;
        air_lightmap_destroy(lightmap);
    }
    for (int i = 0; i < COUNT; i++) {
        out.error[i] = sqrt(fmax(squares[i] - out.mean[i] * out.mean[i], 0.0) / (SEEDS - 1));
    }
    return out;
}

/* Within 4.5 standard errors of ours: Student's t with 15 degrees of freedom is beyond once in
 * 2,300 times; the seeds are fixed. slack: of what is expected, and of floats. */
static void assert_coefficients(const char *what, const probed *got, const double expected[COUNT],
                                double largest_error, double slack)
{
    for (int i = 0; i < COUNT; i++) {
        if (!(got->error[i] <= largest_error) ||
            !(fabs(got->mean[i] - expected[i]) <= 4.5 * got->error[i] + slack)) {
            fail_msg("%s, coefficient %d: %.7g +- %.2g, expected %.7g", what, i, got->mean[i],
                     got->error[i], expected[i]);
        }
    }
}

/* Irradiance by bands 0 to 2 for a normal [Ramamoorthi2001]. */
static double irradiance_of(const double coefficients[COUNT], const double normal[3])
{
    const double factors[3] = {AIR_PI, 2.0 * AIR_PI / 3.0, AIR_PI / 4.0};
    double y[COUNT], sum = 0.0;
    air_sh_evaluate(3, normal, y);
    for (int i = 0; i < COUNT; i++) {
        sum += factors[air_sh_band_3(i)] * coefficients[i] * y[i];
    }
    return sum;
}

/* The sun of E_perp = 1 from (2, 3, 6)/7 has the harmonics of that direction as coefficients: the
 * published test vector, in its order and with its signs (docs/conventions.md). No number of it is
 * left to chance. Irradiance by three bands is 1/4 + c/2 + 5/32 (3 c^2 - 1) of the cosine c, off
 * max(0, c) by 3/32 at c = 0 and by less elsewhere (1/16 at both ends). */
static void the_sun_gives_the_published_vector(void **state)
{
    static const double published[COUNT] = {0.282094792, 0.209401077, 0.418802153,
                                            0.139600718, 0.133781440, 0.401344321,
                                            0.379757191, 0.267562881, -0.055742267};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    add_sun(scene, vec3(1.0f, 1.0f, 1.0f), vec3(-2.0f, -3.0f, -6.0f));
    air_snapshot *snapshot = path_freeze(scene);
    const probed got = probe_at(&host, snapshot, vec3(1, 2, 3), 16);
    assert_coefficients("sun", &got, published, 1e-7, 3e-7);
    double most = 0.0;
    for (int i = 0; i <= 64; i++) {
        const double c = i / 32.0 - 1.0, s = sqrt(1.0 - c * c);
        /* turned from the sun about an axis across it */
        const double normal[3] = {c * 2.0 / 7.0 + s * 3.0 / sqrt(13.0),
                                  c * 3.0 / 7.0 - s * 2.0 / sqrt(13.0), c * 6.0 / 7.0};
        const double off = irradiance_of(got.mean, normal) - fmax(c, 0.0);
        most = fmax(most, fabs(off));
    }
    bake_assert_near("truncation", most, 3.0 / 32.0, 1e-5);
    bake_assert_near("validity", got.validity, 1.0, 0.0);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

enum { SKY_WIDTH = 16, SKY_HEIGHT = 256 };

/* A sky whose radiance depends on the height y of the direction alone. */
static air_snapshot *sky_scene(const bake_host *host, double (*radiance)(double y))
{
    float pixels[3 * SKY_WIDTH * SKY_HEIGHT];
    const air_texture_desc image = {
        .name = "sky", .width = SKY_WIDTH, .height = SKY_HEIGHT, .channels = 3, .floats = pixels};
    air_scene *scene = bake_scene(host);
    air_light_desc light;
    for (int i = 0; i < SKY_WIDTH * SKY_HEIGHT; i++) {
        const double y = cos(AIR_PI * (i / SKY_WIDTH + 0.5) / SKY_HEIGHT);
        for (int c = 0; c < 3; c++) {
            pixels[3 * i + c] = (float)radiance(y);
        }
    }
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    set3(light.color, 1.0f, 1.0f, 1.0f);
    assert_int_equal(air_scene_add_texture(scene, &image, &light.image), AIR_OK);
    add_light(scene, &light);
    return path_freeze(scene);
}

static double one(double y) { return 1.0 + 0.0 * y; }
static double cosine(double y) { return 1.0 + y; }
static double two_colours(double y) { return y > 0.0 ? 1.0 : 0.25; }
static double squared(double y) { return y * y; }

/* Bands 0 and 1 hold 1 + y, bands 0 to 2 hold y^2 in full; of two colours with a border at the
 * horizon bands 3, 5, ... are missing, which irradiance does not see. Rows are interpolated: (pi /
 * 256)^2 / 8 = 2e-5 of the largest second derivative, and the border is as wide as a row, even to
 * both sides, which changes band 1 by (pi / 256)^2 / 12 at most. All coefficients are at most 4. */
static void skies_have_their_coefficients_and_irradiance(void **state)
{
    static const struct {
        const char *name;
        double (*radiance)(double y);
        double mean, along, square; /* coefficients of 1, y, and (3 y^2 - 1) / 2 */
    } skies[] = {{"constant", one, 1.0, 0.0, 0.0},
                 {"cosine", cosine, 1.0, 1.0, 0.0},
                 /* of a step from -1/2 to 1/2 band 1 is 3/4 */
                 {"two colours", two_colours, 0.625, 0.75 * 0.75, 0.0},
                 {"square", squared, 1.0 / 3.0, 0.0, 2.0 / 3.0}};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    for (size_t i = 0; i < sizeof skies / sizeof skies[0]; i++) {
        /* y is the axis of index 1; P_2(y) is spread over indices 6 and 8: its zonal coefficient
         * sqrt(4 pi / 5), turned to y_2m of the axis y: -1/2 and -sqrt(3)/2 */
        const double zonal = skies[i].square * sqrt(4.0 * AIR_PI / 5.0);
        const double expected[COUNT] = {skies[i].mean * sqrt(4.0 * AIR_PI),
                                        skies[i].along * sqrt(4.0 * AIR_PI / 3.0),
                                        0.0,
                                        0.0,
                                        0.0,
                                        0.0,
                                        -0.5 * zonal,
                                        0.0,
                                        -0.5 * sqrt(3.0) * zonal};
        air_snapshot *snapshot = sky_scene(&host, skies[i].radiance);
        const probed got = probe_at(&host, snapshot, vec3(0, 0, 0), 1024);
        assert_coefficients(skies[i].name, &got, expected, 0.02, 1e-4);
        for (int k = 0; k <= 8; k++) {
            const double y = k / 4.0 - 1.0;
            const double normal[3] = {sqrt(1.0 - y * y), y, 0.0};
            /* exactly, band by band; for y^2 too: the integral is pi (1 + y^2) / 4 */
            const double truth = i == 3 ? AIR_PI * (1.0 + y * y) / 4.0
                                        : AIR_PI * (skies[i].mean + skies[i].along * y / 1.5);
            /* eight coefficients' errors times A_l y_lm, at most 2.1 * 0.49, 0.79 * 1.1 */
            double slack = 1e-3;
            for (int c = 0; c < COUNT; c++) {
                slack += 4.5 * got.error[c];
            }
            bake_assert_near(skies[i].name, irradiance_of(got.mean, normal), truth, slack);
        }
        air_snapshot_release(snapshot);
    }
    bake_close(&host);
}

/* A point lamp: coefficients of its direction, times intensity over squared distance; behind a wall
 * nothing of it. */
static void a_lamp_is_seen_from_where_it_stands(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_scene *scene = bake_scene(&host);
    add_point_light(scene, vec3(0, 3, 0), 2.0f);
    add_quad(scene, vec3(4, 2, 1), vec3(2, 0, 0), vec3(0, 0, -2), add_lambert(scene, 0.0f, 0.0f));
    air_snapshot *snapshot = path_freeze(scene);
    const double dir[3] = {0.6, 0.8, 0.0}; /* from (-3, -1, 0), at 5 m */
    double expected[COUNT] = {0.0};
    probed got = probe_at(&host, snapshot, vec3(10, 1, 0), 16);
    assert_true(got.mean[0] == 0.0);
    air_sh_evaluate(3, dir, expected);
    for (int i = 0; i < COUNT; i++) {
        expected[i] *= 2.0 / 25.0;
    }
    got = probe_at(&host, snapshot, vec3(-3, -1, 0), 16);
    assert_coefficients("lamp", &got, expected, 1e-7, 1e-7);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* Who sees backs only is inside of something; leaves and glass enclose nothing. */
static void validity_says_what_is_inside(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    for (int leaf = 0; leaf < 2; leaf++) {
        air_scene *scene = bake_scene(&host);
        air_material_desc material;
        air_handle handle;
        air_material_desc_default(&material);
        material.double_sided = leaf == 1;
        assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_OK);
        bake_add_box(scene, vec3(-1, -1, -1), vec3(1, 1, 1), false, handle);
        add_environment(scene, 1.0f, 1.0f, 1.0f);
        air_snapshot *snapshot = path_freeze(scene);
        probed got = probe_at(&host, snapshot, vec3(0.2f, 0.1f, -0.3f), 64);
        bake_assert_near("inside", got.validity, leaf == 1 ? 1.0 : 0.0, 0.0);
        got = probe_at(&host, snapshot, vec3(0, 1.5f, 0), 64);
        bake_assert_near("above", got.validity, 1.0, 0.0);
        assert_true(got.mean[0] > 0.0);
        air_snapshot_release(snapshot);
    }
    /* below one floor: half of all directions end on its back, if it is large */
    air_scene *scene = bake_scene(&host);
    add_floor(scene, 0.0f, 1e4f, AIR_NONE);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    air_snapshot *snapshot = path_freeze(scene);
    const probed got = probe_at(&host, snapshot, vec3(0, -0.1f, 0), 64);
    bake_assert_near("below", got.validity, 0.5, 1.0 / 64.0); /* by a stratified sequence */
    air_snapshot_release(snapshot);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_grid_counts_its_first_axis_fastest),
        cmocka_unit_test(automatic_probes_lie_in_the_middle_of_cells),
        cmocka_unit_test(free_probes_are_where_they_are_put),
        cmocka_unit_test(requests_that_mean_nothing_are_refused_by_name),
        cmocka_unit_test(a_scene_without_bounds_has_no_automatic_probes),
        cmocka_unit_test(the_sun_gives_the_published_vector),
        cmocka_unit_test(skies_have_their_coefficients_and_irradiance),
        cmocka_unit_test(a_lamp_is_seen_from_where_it_stands),
        cmocka_unit_test(validity_says_what_is_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* What the samples of a site add up to: records, and light that is known by irradiance only. */
#include "bake/sites.h"
#include "bake_fixture.h"
#include "core/harmonics.h"

enum { COUNT = AIR_PROBE_COEFFICIENTS };

/* ---- gains ---- */

/* Irradiance on a normal of radiance with these coefficients. */
static double irradiance_of(const double coefficients[COUNT], air_vec3 normal)
{
    const double factors[3] = {AIR_PI, 2.0 * AIR_PI / 3.0, AIR_PI / 4.0};
    const double at[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    double y[COUNT], sum = 0.0;
    air_sh_evaluate(3, at, y);
    for (int i = 0; i < COUNT; i++) {
        sum += factors[air_sh_band_3(i)] * coefficients[i] * y[i];
    }
    return sum;
}

/* Radiance of bands 0 to 2 comes back from its irradiance on the axes alone: the corners of an
 * icosahedron integrate products of two such functions (degree 4) exactly. The fluence is
 * sqrt(4 pi) times the first coefficient; a surface has its own irradiance besides. */
static void radiance_comes_back_from_irradiance_on_the_axes(void **state)
{
    const double coefficients[COUNT] = {3.0, 0.5, -0.7, 0.2, 0.3, -0.4, 0.6, 0.1, -0.2};
    (void)state;
    for (int surface = 0; surface < 2; surface++) {
        air_path_receiver receiver = {.sphere = surface == 0, .normal = {0.6f, 0.0f, 0.8f}};
        air_vec3 axes[AIR_GAIN_AXES];
        air_path_lane lane;
        air_gain gain;
        memset(&lane, 0, sizeof lane);
        memset(&gain, 0, sizeof gain);
        air_gain_set_axes(&receiver, COUNT, axes);
        assert_int_equal(receiver.axis_count, surface == 0 ? 12 : 13);
        lane.receiver = &receiver;
        lane.lit_share = 0.5f;
        for (size_t k = 0; k < receiver.axis_count; k++) {
            bake_assert_near("axis", (double)vec3_length(axes[k]), 1.0, 1e-6);
            const float e = (float)irradiance_of(coefficients, axes[k]);
            lane.lit[k] = vec3(e, 2.0f * e, 4.0f * e);
        }
        air_gain_add(&gain, &lane, COUNT);
        for (int i = 0; i < COUNT; i++) {
            /* twelve roundings of numbers up to 10 */
            bake_assert_near("coefficient", gain.harmonics[AIR_LAYER_MEDIA][i][1], coefficients[i],
                             5e-6);
            bake_assert_near("blue", gain.harmonics[AIR_LAYER_MEDIA][i][2], 2.0 * coefficients[i],
                             1e-5);
        }
        const double light = surface == 0 ? sqrt(4.0 * AIR_PI) * coefficients[0]
                                          : irradiance_of(coefficients, receiver.normal);
        bake_assert_near("light", gain.layers[AIR_LAYER_MEDIA][1], light, 1e-5);
        assert_true(gain.layers[AIR_LAYER_DIRECT][1] == 0.0 && gain.samples == 1.0);
        /* adding two gains adds all that is in them */
        air_gain sum = gain;
        air_gain_merge(&sum, &gain, COUNT);
        assert_true(sum.samples == 2.0);
        assert_true(sum.squares[AIR_LAYER_MEDIA] == 2.0 * gain.squares[AIR_LAYER_MEDIA]);
        assert_true(sum.harmonics[AIR_LAYER_MEDIA][5][0] ==
                    2.0 * gain.harmonics[AIR_LAYER_MEDIA][5][0]);
    }
}

/* ---- records ---- */

typedef struct row {
    float inside; /* share of the samples in the box */
    bool nowhere; /* odd sites have no place at all */
} row;

/* In the box about the origin or above it. */
static bool draw(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    const row *self = user;
    *out = (air_path_receiver){.sphere = true};
    out->position = u[0] < self->inside ? vec3(0.1f, 0.2f, u[1] - 0.5f) : vec3(u[1], 2, 0);
    return !self->nowhere || site % 2 == 0;
}

typedef struct work {
    bake_host host;
    air_snapshot *snapshot;
    air_sobol *sobol;
    air_path path;
} work;

/* A closed black box of 2 m under the sun, or under a sky. */
static void begin(work *self, bool sky)
{
    /* with a depth of 1 and nothing but the sun no ray would leave, and nobody would see the box */
    const air_path_settings settings = {.max_depth = 2, .terms = AIR_TERMS_ALL};
    air_light_desc sun;
    bake_open(&self->host, 1);
    air_scene *scene = bake_scene(&self->host);
    bake_add_box(scene, vec3(-1, -1, -1), vec3(1, 1, 1), false, add_lambert(scene, 0.0f, 0.0f));
    air_light_desc_default(&sun);
    sun.kind = sky ? AIR_LIGHT_ENVIRONMENT : AIR_LIGHT_COLLIMATED;
    set3(sun.color, 1.0f, 2.0f, 4.0f);
    set3(sun.dir, 0.0f, -1.0f, 0.0f);
    add_light(scene, &sun);
    self->snapshot = path_freeze(scene);
    self->sobol = malloc(sizeof *self->sobol);
    assert_non_null(self->sobol);
    air_sobol_init(self->sobol);
    assert_int_equal(air_path_init(&self->path, self->snapshot, self->sobol, &settings), AIR_OK);
}

static void end(work *self)
{
    air_path_finish(&self->path);
    free(self->sobol);
    air_snapshot_release(self->snapshot);
    bake_close(&self->host);
}

static float *run(const work *self, const row *place, size_t count, uint32_t samples,
                  air_site_list *out)
{
    *out = (air_site_list){.what = "rows",
                           .count = count,
                           .draw = draw,
                           .user = place,
                           .seed = 5,
                           .samples = samples,
                           .coefficients = 4};
    assert_int_equal(air_sites_run(&self->path, out, NULL, 0.0, 1.0), AIR_OK);
    return out->records;
}

/* Fluence of the sun is E_perp for each sample in the open, 0 in the box. Samples in the box are
 * left out if they are more than a twentieth, and counted where they are fewer. */
static void buried_samples_are_left_out_unless_few(void **state)
{
    const float shares[] = {0.0f, 1.0f / 64.0f, 3.0f / 64.0f, 0.25f, 0.75f, 1.0f};
    const uint32_t samples[] = {64, 17, 1};
    work self;
    (void)state;
    begin(&self, false);
    for (size_t i = 0; i < sizeof shares / sizeof shares[0]; i++) {
        for (size_t k = 0; k < 3; k++) {
            const row place = {shares[i], false};
            air_site_list list;
            float *records = run(&self, &place, 3, samples[k], &list);
            for (size_t site = 0; site < 3; site++) {
                const float *record = records + site * air_site_stride(&list);
                const double validity = (double)record[AIR_SITE_VALIDITY];
                const double open = validity == 0.0 ? 0.0 : validity < 0.95 ? 1.0 : validity;
                if (samples[k] == 64) { /* strata of a sequence, jittered within */
                    bake_assert_near("validity", validity, 1.0 - (double)shares[i], 1.01 / 64.0);
                }
                bake_assert_near("light", (double)record[AIR_SITE_LIGHT + 1], 2.0 * open, 1e-6);
                bake_assert_near("band 0", (double)record[AIR_SITE_HARMONICS + 2],
                                 4.0 * open * 0.282094792, 1e-6);
                bake_assert_near("band 1 y", (double)record[AIR_SITE_HARMONICS + 4],
                                 2.0 * open * 0.488602512, 1e-6);
                /* all samples of one value: no variance but that of those that are dark */
                const double luminance = 0.2126 + 2.0 * 0.7152 + 4.0 * 0.0722;
                const double variance =
                    samples[k] > 1 ? open * (1.0 - open) / (samples[k] - 1.0) : 0.0;
                bake_assert_near("variance", (double)record[AIR_SITE_VARIANCE],
                                 variance * luminance * luminance, 1e-6);
            }
            air_free(self.host.context, records);
        }
    }
    end(&self);
}

/* What stands in a case of glass is no part of it. */
static void what_is_in_glass_is_not_buried(void **state)
{
    const row place = {1.0f, false};
    work self;
    (void)state;
    for (int glass = 0; glass < 2; glass++) {
        air_site_list list;
        begin(&self, false);
        air_material *material = &self.snapshot->materials[self.snapshot->meshes[0]->material];
        material->model = glass ? AIR_MATERIAL_DIELECTRIC : AIR_MATERIAL_METALLIC_ROUGHNESS;
        float *records = run(&self, &place, 1, 16, &list);
        bake_assert_near("validity", (double)records[AIR_SITE_VALIDITY], (double)glass, 0.0);
        air_free(self.host.context, records);
        end(&self);
    }
}

static void sites_without_a_place_are_black_and_not_valid(void **state)
{
    const row place = {0.0f, true};
    work self;
    air_site_list list;
    (void)state;
    begin(&self, false);
    float *records = run(&self, &place, 4, 16, &list);
    for (size_t site = 0; site < 4; site++) {
        const float *record = records + site * air_site_stride(&list);
        assert_true((record[AIR_SITE_VALIDITY] == 1.0f) == (site % 2 == 0));
        for (size_t i = 0; i < air_site_stride(&list) && site % 2 == 1; i++) {
            assert_true(record[i] == 0.0f);
        }
    }
    air_free(self.host.context, records);
    end(&self);
}

/* What a site gets depends on its number alone; another seed gives other numbers. */
static void records_do_not_depend_on_the_others(void **state)
{
    const row place = {0.2f, false};
    work self;
    air_site_list many, few;
    (void)state;
    begin(&self, true);
    float *a = run(&self, &place, 200, 16, &many), *b = run(&self, &place, 70, 16, &few);
    assert_int_equal(air_site_stride(&many), air_site_stride(&few));
    assert_memory_equal(a, b, 70 * air_site_stride(&few) * sizeof *b);
    assert_memory_not_equal(a, a + air_site_stride(&many), air_site_stride(&many) * sizeof *a);
    few.seed = 6;
    assert_int_equal(air_sites_run(&self.path, &few, NULL, 0.0, 1.0), AIR_OK);
    assert_memory_not_equal(a, b, 70 * air_site_stride(&few) * sizeof *b);
    air_free(self.host.context, a);
    air_free(self.host.context, b);
    end(&self);
}

/* The variance is that of a mean of independent samples; those of a sequence do better, so over
 * sites the light varies by less. Single samples are independent: with groups of one sample the
 * variance over sites is the mean of what 64 samples say, times 64. */
static void variance_is_that_of_independent_samples(void **state)
{
    enum { SITES = 4096 };
    const row place = {0.0f, false};
    work self;
    air_site_list one, many;
    double sum = 0.0, square = 0.0, said = 0.0, mean = 0.0, spread = 0.0;
    (void)state;
    begin(&self, true);
    float *single = run(&self, &place, SITES, 1, &one), *group = run(&self, &place, 512, 64, &many);
    for (size_t i = 0; i < SITES; i++) {
        const float *light = single + i * air_site_stride(&one) + AIR_SITE_LIGHT;
        const double y =
            0.2126 * (double)light[0] + 0.7152 * (double)light[1] + 0.0722 * (double)light[2];
        sum += y / SITES;
        square += y * y / SITES;
    }
    for (size_t i = 0; i < 512; i++) {
        const float *record = group + i * air_site_stride(&many);
        const double y =
            0.2126 * (double)record[0] + 0.7152 * (double)record[1] + 0.0722 * (double)record[2];
        said += 64.0 * (double)record[AIR_SITE_VARIANCE] / 512.0;
        mean += y / 512.0;
        spread += y * y / 512.0;
    }
    const double variance = square - sum * sum;
    /* of 4,096 numbers of bounded size: the variance's deviation is below sqrt(2 / 4096) = 2.2 %
     * for tails no heavier than a bell's, four of them are allowed */
    assert_true(variance > 0.0);
    bake_assert_near("variance of a sample", said, variance, 0.09 * variance);
    assert_true(spread - mean * mean < 1.5 * variance / 64.0);
    air_free(self.host.context, single);
    air_free(self.host.context, group);
    end(&self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radiance_comes_back_from_irradiance_on_the_axes),
        cmocka_unit_test(buried_samples_are_left_out_unless_few),
        cmocka_unit_test(what_is_in_glass_is_not_buried),
        cmocka_unit_test(sites_without_a_place_are_black_and_not_valid),
        cmocka_unit_test(records_do_not_depend_on_the_others),
        cmocka_unit_test(variance_is_that_of_independent_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Isotropic point source in infinite fog, against the closed forms of [Case1967] as
 * analytic_fluence.h has them: the fluence of every number of scatterings and of all of them. */
#include "analytic_fluence.h"
#include "path_scene.h"

/* Each replicate. Beyond the first scattering the tracer's directions are drawn by the phase
 * function, although the light around a point source rises as 1 / sin(angle): the variance diverges
 * with the logarithm of the samples, and replicates of a few thousand of them miss its tail. */
enum { SAMPLES = 32768 };

static air_snapshot *point_in_fog(void **state, float sigma_s, float sigma_a)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    set3(medium.sigma_s, sigma_s, sigma_s, sigma_s);
    set3(medium.sigma_a, sigma_a, sigma_a, sigma_a);
    add_medium(scene, &medium);
    add_point_light(scene, vec3_set1(0.0f), 1.0f);
    return path_freeze(scene);
}

static void assert_fluence(const char *what, const probe_result *got, double expected)
{
    const double grey[3] = {expected, expected, expected};
    assert_measured(what, got, grey, 0.02);
}

static void each_number_of_scatterings_has_its_fluence(void **state)
{
    static const float distances[3] = {0.5f, 1.0f, 3.0f};
    air_snapshot *snapshot = point_in_fog(state, 1.0f, 0.0f);
    for (size_t i = 0; i < 3; i++) {
        double expected = 0.0;
        for (uint32_t bounces = 1; bounces <= 3; bounces++) {
            const probe_result got = measure_fluence(snapshot, vec3(distances[i], 0.0f, 0.0f),
                                                     vec3_set1(0.0f), bounces, SAMPLES);
            expected += fluence_of_bounce((int)bounces, 1.0, 0.0, (double)distances[i]);
            assert_fluence("up to three scatterings", &got, expected);
        }
    }
    air_snapshot_release(snapshot);
}

static void all_scatterings_together_have_theirs(void **state)
{
    static const float distances[3] = {0.5f, 1.0f, 2.0f};
    air_snapshot *snapshot = point_in_fog(state, 0.9f, 0.1f);
    for (size_t i = 0; i < 3; i++) {
        const double d = (double)distances[i];
        const double expected =
            fluence_of_all_bounces(0.9, 0.1, d) - fluence_of_bounce(0, 0.9, 0.1, d);
        const probe_result got = measure_fluence(snapshot, vec3(0.0f, distances[i], 0.0f),
                                                 vec3_set1(0.0f), UINT32_MAX, SAMPLES);
        assert_fluence("all scatterings", &got, expected);
    }
    air_snapshot_release(snapshot);
}

/* Both numbers of scatterings in the terms that the film keeps apart. The first one alone converges
 * fast: its error is far below that of the sum, which is the other's. */
static void the_first_scattering_is_the_term_m1(void **state)
{
    air_snapshot *snapshot = point_in_fog(state, 1.0f, 0.0f);
    const probe_result got =
        measure_fluence(snapshot, vec3(1.0f, 0.0f, 0.0f), vec3_set1(0.0f), 2, SAMPLES);
    const double m1 = fluence_of_bounce(1, 1.0, 0.0, 1.0), m2 = fluence_of_bounce(2, 1.0, 0.0, 1.0);
    assert_true(got.error[1] < 0.02 * m1);
    assert_true(fabs(got.terms[AIR_TERM_M1] - m1) < 1e-3 * m1);
    assert_true(fabs(got.terms[AIR_TERM_M2] - m2) < 4.0 * got.error[1]);
    assert_true(got.terms[AIR_TERM_S0] == 0.0 && got.terms[AIR_TERM_S_PLUS] == 0.0);
    air_snapshot_release(snapshot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_number_of_scatterings_has_its_fluence),
        cmocka_unit_test(all_scatterings_together_have_theirs),
        cmocka_unit_test(the_first_scattering_is_the_term_m1),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

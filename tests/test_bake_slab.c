/* Suns over layers of fog: what is added to the directional response. */
#include "bake/slab.h"

#include "bake_fixture.h"

/* A box of haze under a slanted sun. */
static air_snapshot *hazy_box(const bake_host *host, air_phase phase)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 0, 0), vec3(2, 1, 2));
    air_light_desc sun;
    set3(medium.sigma_s, 0.5f, 0.5f, 0.5f);
    medium.phase = phase;
    add_medium(scene, &medium);
    air_light_desc_default(&sun);
    sun.kind = AIR_LIGHT_COLLIMATED;
    set3(sun.dir, -0.6f, -0.8f, 0.0f);
    add_light(scene, &sun);
    return path_freeze(scene);
}

static air_vec3 correction(const bake_host *host, air_phase phase)
{
    air_snapshot *snapshot = hazy_box(host, phase);
    air_slab *slab = NULL;
    assert_int_equal(air_slab_create(host->context, snapshot, 0, &slab), AIR_OK);
    assert_non_null(slab);
    const air_vec3 out =
        air_slab_correction(slab, 0, vec3(0, -0.5f, 0), vec3(0.6f, 0.8f, 0), vec3(0, 1, 0));
    air_slab_destroy(slab);
    air_snapshot_release(snapshot);
    return out;
}

/* The same to the bit: halves of 0.75 are 0.75. */
static void a_lobe_in_two_halves_is_that_lobe(void **state)
{
    const air_phase_mixture halves = {2,
                                      {{AIR_PHASE_HG, 0.75f, 0.5f}, {AIR_PHASE_HG, 0.75f, 0.5f}}};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    const air_vec3 isotropic = correction(&host, (air_phase){.kind = AIR_PHASE_ISOTROPIC});
    const air_vec3 whole = correction(&host, (air_phase){.kind = AIR_PHASE_HG, .g = 0.75f});
    const air_vec3 parts =
        correction(&host, (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = &halves});
    assert_true(parts.x == whole.x && parts.y == whole.y && parts.z == whole.z);
    assert_true(whole.x != isotropic.x);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_lobe_in_two_halves_is_that_lobe)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

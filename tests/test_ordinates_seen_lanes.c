/* Source functions and moments of beams, by every instruction set of this machine. */
#include "airlight/ordinates_dom.h"
#include "airlight/ordinates_view.h"
#include "core/random.h"
#include "core/vec.h"
#include "ordinates_levels.h"

enum {
    MOST = 67 * 3 * 2,
    BEAMS = 19,
    ROUNDS = 20,
    MOMENTS = AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX
};

static const size_t sizes[][3] = {{67, 3, 2}, {5, 4, 3}, {1, 1, 1}, {16, 2, 3}};

typedef struct light {
    air_seen_box box;
    size_t cells;
    int bands;
    air_seen_beam beams[BEAMS];
    float fluence[BEAMS][MOST * 4], moments[MOST * MOMENTS * 4], depth[MOST];
    double factors[AIR_DOM_BANDS_MAX];
} light;

static void set_direction(air_rng *rng, float out[3])
{
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = air_rng_float(rng) - 0.5f;
    }
    vec3_store(out, vec3_normalize(vec3_load(out)));
}

static void make(air_rng *rng, int round, light *out)
{
    *out = (light){.bands = 1 + round % AIR_DOM_BANDS_MAX, .cells = 1};
    out->box.distant = round % 3 == 0;
    set_direction(rng, out->box.observer);
    for (int axis = 0; axis < 3; axis++) {
        out->box.size[axis] = sizes[round % 4][axis];
        out->box.cell_m[axis] = 0.1f;
        out->cells *= out->box.size[axis];
    }
    for (int b = 0; b < BEAMS; b++) {
        air_seen_beam *const beam = &out->beams[b];
        *beam = (air_seen_beam){.local = b % 3 == 1, .peakless = b % 5 == 0, .lobe = 1.0f};
        beam->lobe = b % 2 == 0 ? 1.0f : air_rng_float(rng);
        set_direction(rng, beam->dir);
        beam->fluence = out->fluence[b];
        for (size_t i = 0; i < 4 * out->cells; i++) {
            out->fluence[b][i] = air_rng_float(rng);
        }
        for (int c = 0; c < 3; c++) {
            beam->power[c] = air_rng_float(rng);
        }
    }
    for (size_t i = 0; i < out->cells * MOMENTS * 4; i++) {
        out->moments[i] = air_rng_float(rng) - 0.5f;
    }
    for (int l = 0; l < out->bands; l++) {
        out->factors[l] = pow(0.8, l);
    }
    for (size_t i = 0; i < out->cells; i++) {
        out->depth[i] = air_rng_float(rng);
    }
}

/* y_lm are below 2, by recurrences of some ten roundings that at most ten times grow; 100 products
 * are summed: 1e-4 of the largest, 20, at most. */
static void moments_are_seen_as_by_plain_c(void **state)
{
    static light self;
    static float out[2][MOST * 4];
    levels all = levels_make();
    air_rng rng = air_rng_from_keys(6, 1);
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        make(&rng, round, &self);
        for (int level = 0; level < all.count; level++) {
            float *const to = out[level > 0];
            memset(to, 0, sizeof out[0]);
            for (size_t k = 0; k < self.box.size[2]; k++) {
                air_seen_moments(all.contexts[level], &self.box, self.bands, self.moments,
                                 self.factors, k, k + 1, to);
            }
            worst = fmax(worst, levels_difference(out[0], to, 4 * self.cells));
        }
    }
    print_message("moments seen: %.1e\n", worst);
    assert_true(worst < 2e-5);
    levels_finish(&all);
}

static void moments_of_beams_are_those_of_plain_c(void **state)
{
    static light self;
    static float out[2][MOST * MOMENTS * 4];
    levels all = levels_make();
    air_rng rng = air_rng_from_keys(6, 2);
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        make(&rng, round, &self);
        const size_t numbers = self.cells * (size_t)(self.bands * self.bands) * 4;
        for (int level = 0; level < all.count; level++) {
            float *const to = out[level > 0];
            memset(to, 0, sizeof out[0]);
            for (size_t k = 0; k < self.box.size[2]; k++) {
                air_beam_moments(all.contexts[level], &self.box, self.beams, BEAMS, self.bands, k,
                                 k + 1, to);
            }
            worst = fmax(worst, levels_difference(out[0], to, numbers));
        }
    }
    print_message("moments of beams: %.1e\n", worst);
    assert_true(worst < 2e-5);
    levels_finish(&all);
}

/* The phase function's denominator is off by a rounding of 2, which where it is least, (1 - g)^2 =
 * 0.04, is 3e-6 of it, and times 3/2 of the value, up to 3.6; 19 such are summed. */
static void beams_are_seen_as_by_plain_c(void **state)
{
    static const air_phase_mixture mixture = {
        .lobe_count = 2, .lobes = {{AIR_PHASE_HG, 0.8f, 0.6f}, {AIR_PHASE_RAYLEIGH, 0.0f, 0.4f}}};
    static const air_phase phases[] = {{.kind = AIR_PHASE_HG, .g = 0.8f},
                                       {.kind = AIR_PHASE_MIXTURE, .mixture = &mixture},
                                       {.kind = AIR_PHASE_ISOTROPIC},
                                       {.kind = AIR_PHASE_HG, .g = -0.4f}};
    static light self;
    static float out[2][MOST * 4];
    levels all = levels_make();
    air_rng rng = air_rng_from_keys(6, 3);
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        make(&rng, round, &self);
        const air_seen_peak peak = {0.4, 0.7, self.depth};
        const air_seen_peak *const given = round % 8 < 2 ? &peak : NULL;
        for (int level = 0; level < all.count; level++) {
            float *const to = out[level > 0];
            memset(to, 0, sizeof out[0]);
            for (size_t k = 0; k < self.box.size[2]; k++) {
                air_seen_beams(all.contexts[level], &self.box, self.beams, BEAMS, phases[round % 4],
                               given, k, k + 1, to);
            }
            worst = fmax(worst, levels_difference(out[0], to, 4 * self.cells));
        }
    }
    print_message("beams seen: %.1e\n", worst);
    assert_true(worst < 1e-4);
    levels_finish(&all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_are_seen_as_by_plain_c),
        cmocka_unit_test(moments_of_beams_are_those_of_plain_c),
        cmocka_unit_test(beams_are_seen_as_by_plain_c),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

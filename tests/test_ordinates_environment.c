#include <math.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/triple.h"
#include "environment_fixture.h"

static void sum_of(const air_ordinate *ordinates, size_t count, double sum[3])
{
    memset(sum, 0, 3 * sizeof *sum);
    for (size_t n = 0; n < count; n++) {
        air_along3(sum, 1.0, ordinates[n].irradiance, sum);
        assert_true(fabs(air_length3(ordinates[n].travel) - 1.0) < 1e-12);
        assert_true(ordinates[n].lobe >= 0.0 && ordinates[n].lobe <= 1.0);
        assert_true(ordinates[n].solid_angle >= 0.0);
    }
}

static void assert_sums(const air_ordinate *ordinates, size_t count, const double expected[3],
                        double tolerance)
{
    double sum[3];
    sum_of(ordinates, count, sum);
    for (int k = 0; k < 3; k++) {
        assert_true(fabs(sum[k] - expected[k]) <= tolerance * expected[k]);
    }
}

static double degrees_between(const double a[3], const double b[3])
{
    double across[3];
    air_cross3(a, b, across);
    return atan2(air_length3(across), air_dot3(a, b)) * 180.0 / AIR_PI;
}

/* ---- sums ---- */

static void constant_skies_give_four_pi(void **state)
{
    const size_t counts[] = {1, 2, 16, 63, 64, 256, MOST};
    air_environment_map map;
    air_environment_map_default(&map);
    map.radiance[0] = 0.5f;
    map.radiance[1] = 1.0f;
    map.radiance[2] = 2.0f;
    air_environment_ordinates *sky = prepare(*state, &map);
    static air_ordinate ordinates[MOST];
    const double expected[3] = {2.0 * AIR_PI, 4.0 * AIR_PI, 8.0 * AIR_PI};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        choose(*state, sky, counts[i], NULL, ordinates);
        /* 1e5 additions of 2^-53 relative each */
        assert_sums(ordinates, counts[i], expected, 2e-11);
    }
    air_environment_ordinates_destroy(sky);
    static float white[3 * 37 * 11]; /* and as pixels, which split unevenly */
    for (size_t i = 0; i < 3 * 37 * 11; i++) {
        white[i] = i % 3 == 0 ? 0.5f : i % 3 == 1 ? 1.0f : 2.0f;
    }
    map = map_of(white, 37, 11);
    sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, ordinates);
    assert_sums(ordinates, 64, expected, 2e-11);
    air_environment_ordinates_destroy(sky);
}

/* Pixels' solid angles times their radiance, summed another way. */
static void strata_sum_to_the_map(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT], importance[AIR_IMPORTANCE_TEXELS];
    static air_ordinate ordinates[MOST];
    double expected[3] = {0.0, 0.0, 0.0}, integral[3];
    paint(pixels, WIDTH, HEIGHT, 40);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        const double y = (double)(i / WIDTH);
        const double angle =
            2.0 * AIR_PI / WIDTH * (cos(AIR_PI * y / HEIGHT) - cos(AIR_PI * (y + 1.0) / HEIGHT));
        for (int k = 0; k < 3; k++) {
            expected[k] += angle * (double)pixels[3 * i + (size_t)k];
        }
    }
    for (size_t i = 0; i < AIR_IMPORTANCE_TEXELS; i++) { /* 0 over a half: its light still counts */
        importance[i] = i % AIR_IMPORTANCE_WIDTH < 16 ? 0.0f : (float)(i % 7);
    }
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    air_environment_ordinates *sky = prepare(*state, &map);
    air_environment_ordinates_integral(sky, integral);
    for (int k = 0; k < 3; k++) {
        assert_true(fabs(integral[k] - expected[k]) < 1e-10 * expected[k]);
    }
    for (size_t count = 1; count <= MOST; count = count * 3 + 1) {
        choose(*state, sky, count, NULL, ordinates);
        assert_sums(ordinates, count, expected, 1e-10);
        choose(*state, sky, count, importance, ordinates);
        assert_sums(ordinates, count, expected, 1e-10);
    }
    air_environment_ordinates_destroy(sky);
}

/* Points: an estimate of the integral, better with more of them; with p in proportion to the
 * luminance their luminances are all alike and sum to it exactly. */
static void points_estimate_the_map(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    static air_ordinate ordinates[MOST];
    double integral[3], sum[3];
    paint(pixels, WIDTH, HEIGHT, 40);
    air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    map.contrast = 1.0f;
    air_environment_ordinates *sky = prepare(*state, &map);
    air_environment_ordinates_integral(sky, integral);
    air_environment_choice choice;
    air_environment_choice_default(&choice);
    choice.form = AIR_ORDINATE_POINT;
    choice.lobe = AIR_ORDINATE_LOBE_ANGLE;
    choice.beta = 1.0f;
    for (size_t count = 16; count <= 1024; count *= 8) {
        choice.count = count;
        assert_int_equal(air_environment_ordinates_choose(*state, sky, &choice, ordinates), AIR_OK);
        sum_of(ordinates, count, sum);
        const double luminance = 0.2126 * sum[0] + 0.7152 * sum[1] + 0.0722 * sum[2];
        const double exact = 0.2126 * integral[0] + 0.7152 * integral[1] + 0.0722 * integral[2];
        assert_true(fabs(luminance - exact) < 1e-10 * exact);
        /* a colour varies between strata by less than 100 % of it and within them by the stratum's
         * size, ~ 1/sqrt(N) */
        assert_true(fabs(sum[2] - integral[2]) < integral[2] / sqrt((double)count));
        for (size_t n = 0; n < count; n++) { /* [Elek2014], corrected: 1 - Omega / (4 pi) */
            const double lobe = fmax(0.0, 1.0 - ordinates[n].solid_angle / (4.0 * AIR_PI));
            assert_true(fabs(ordinates[n].lobe - lobe) < 1e-12);
        }
    }
    air_environment_ordinates_destroy(sky);
}

/* ---- shape ---- */

/* Strata of an even sky have equal solid angles A, and none a higher mean cosine than the cap's, 1
 * - A / (4 pi). A small square has 1 - a = A / 12, pi/3 times the cap's, and if it is drawn to k
 * times its other side (k + 1/k) / 2 times that. Across the equator the octahedral map draws by k =
 * 8/pi, the most: 2 sqrt 2 against pi / (2 sqrt 2) along it; hence 1.54, and 0.06 for bent and
 * ragged edges. On average less: 1.34 measured. */
static void strata_of_an_even_sky_are_compact(void **state)
{
    const size_t counts[] = {16, 64, 256};
    air_environment_map map;
    air_environment_map_default(&map);
    air_environment_ordinates *sky = prepare(*state, &map);
    static air_ordinate ordinates[256];
    for (int i = 0; i < 3; i++) {
        const size_t count = counts[i];
        double mean = 0.0, least = 1.0;
        choose(*state, sky, count, NULL, ordinates);
        for (size_t n = 0; n < count; n++) {
            /* of pieces of equal weight, and the weight of an even sky is its angle */
            assert_true(fabs(ordinates[n].solid_angle * (double)count - 4.0 * AIR_PI) < 1e-9);
            mean += ordinates[n].lobe / (double)count;
            least = fmin(least, ordinates[n].lobe);
        }
        const double cap = 1.0 - 1.0 / (double)count;
        print_message("N = %zu: mean a %.5f, least %.5f, cap %.5f\n", count, mean, least, cap);
        assert_true(mean <= cap && 1.0 - mean < 1.4 * (1.0 - cap));
        assert_true(1.0 - least < 1.65 * (1.0 - cap));
    }
    air_environment_ordinates_destroy(sky);
}

/* Directions of an even sky: their mean is 0 and their second moments 1/3 times the identity; the
 * nearest neighbours are as near as the short sides of squares drawn to 8 : pi (see above), less a
 * tenth. */
static void directions_of_an_even_sky_are_even(void **state)
{
    enum { COUNT = 256 };
    air_environment_map map;
    air_environment_map_default(&map);
    air_environment_ordinates *sky = prepare(*state, &map);
    static air_ordinate ordinates[COUNT];
    double first[3] = {0, 0, 0}, second[3][3] = {{0}}, nearest = 180.0;
    choose(*state, sky, COUNT, NULL, ordinates);
    for (size_t n = 0; n < COUNT; n++) {
        const double *d = ordinates[n].travel;
        for (int i = 0; i < 3; i++) {
            first[i] += d[i] / COUNT;
            for (int j = 0; j < 3; j++) {
                second[i][j] += d[i] * d[j] / COUNT;
            }
        }
        for (size_t m = 0; m < n; m++) {
            nearest = fmin(nearest, degrees_between(d, ordinates[m].travel));
        }
    }
    for (int i = 0; i < 3; i++) {
        /* sums of strata's means: off by their 1 - a <= 1.6/N each, if all conspired */
        assert_true(fabs(first[i]) < 1.6 / COUNT);
        for (int j = 0; j < 3; j++) {
            assert_true(fabs(second[i][j] - (i == j ? 1.0 / 3.0 : 0.0)) < 3.2 / COUNT);
        }
    }
    assert_true(nearest > 0.9 * sqrt(4.0 * AIR_PI / COUNT * AIR_PI / 8.0) * 180.0 / AIR_PI);
    air_environment_ordinates_destroy(sky);
}

/* A white quadrant around a direction: whatever the map's orientation means, the only light's
 * direction of travel is away from there. */
static void directions_are_not_mirrored(void **state)
{
    const struct {
        size_t x, y;
        double towards[3];
    } cases[] = {{64, 32, {0, 0, -1}}, {96, 32, {1, 0, 0}}, {32, 32, {-1, 0, 0}},
                 {127, 32, {0, 0, 1}}, {64, 0, {0, 1, 0}},  {64, 63, {0, -1, 0}}};
    static float pixels[3 * WIDTH * HEIGHT];
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    for (int i = 0; i < 6; i++) {
        air_ordinate one;
        memset(pixels, 0, sizeof pixels);
        pixels[3 * (cases[i].y * WIDTH + cases[i].x)] = 1.0f;
        air_environment_ordinates *sky = prepare(*state, &map);
        choose(*state, sky, 1, NULL, &one);
        const double back[3] = {-one.travel[0], -one.travel[1], -one.travel[2]};
        /* half a pixel's diagonal: 2.8 degrees / sqrt 2 */
        assert_true(degrees_between(back, cases[i].towards) < 2.01);
        air_environment_ordinates_destroy(sky);
    }
}

/* +90 degrees about +Y takes -Z to -X. */
static void rotations_turn_the_ordinates(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    static air_ordinate plain[64], turned[64];
    paint(pixels, WIDTH, HEIGHT, 40);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, plain);
    air_environment_choice choice;
    air_environment_choice_default(&choice);
    const float quarter[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    memcpy(choice.to_world, quarter, sizeof quarter);
    assert_int_equal(air_environment_ordinates_choose(*state, sky, &choice, turned), AIR_OK);
    for (size_t n = 0; n < 64; n++) {
        assert_true(fabs(turned[n].travel[0] - plain[n].travel[2]) < 1e-12);
        assert_true(fabs(turned[n].travel[1] - plain[n].travel[1]) < 1e-12);
        assert_true(fabs(turned[n].travel[2] + plain[n].travel[0]) < 1e-12);
        assert_memory_equal(turned[n].irradiance, plain[n].irradiance, 3 * sizeof(double));
    }
    air_environment_ordinates_destroy(sky);
}

/* Importance is in world space: where a turned map turns with it, strata stay the same. */
static void importance_is_in_world_space(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    float here[AIR_IMPORTANCE_TEXELS], there[AIR_IMPORTANCE_TEXELS];
    static air_ordinate plain[64], turned[64];
    paint(pixels, WIDTH, HEIGHT, 40);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    air_environment_ordinates *sky = prepare(*state, &map);
    for (size_t i = 0; i < AIR_IMPORTANCE_TEXELS; i++) {
        const size_t x = i % AIR_IMPORTANCE_WIDTH, row = i - x;
        here[i] = 1.0f + (float)((x * 5 + i / 32 * 3) % 11);
        there[row + (x + 24) % 32] = here[i]; /* -Z, the centre, to -X, at u = 1/4 */
    }
    choose(*state, sky, 64, here, plain);
    air_environment_choice choice;
    air_environment_choice_default(&choice);
    choice.importance = there;
    const float quarter[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    memcpy(choice.to_world, quarter, sizeof quarter);
    assert_int_equal(air_environment_ordinates_choose(*state, sky, &choice, turned), AIR_OK);
    for (size_t n = 0; n < 64; n++) {
        /* floats of 2^-23 in the look-up, times slopes of 11 per texel of 1/32, of weights that sum
         * to 64 strata */
        const double back[3] = {-turned[n].travel[2], turned[n].travel[1], turned[n].travel[0]};
        assert_true(degrees_between(back, plain[n].travel) < 0.05);
    }
    air_environment_ordinates_destroy(sky);
}

/* Twice the importance over a quarter of an even sky: its density is 2^contrast times as high. */
static void importance_draws_ordinates(void **state)
{
    enum { COUNT = 1024 };
    float importance[AIR_IMPORTANCE_TEXELS];
    static air_ordinate ordinates[COUNT];
    air_environment_map map;
    air_environment_map_default(&map);
    for (size_t i = 0; i < AIR_IMPORTANCE_TEXELS; i++) {
        importance[i] = i % 32 < 8 ? 8.0f : 1.0f;
    }
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, COUNT, importance, ordinates);
    size_t inside = 0;
    for (size_t n = 0; n < COUNT; n++) { /* u < 1/4: between +Z and -X */
        inside += ordinates[n].travel[0] > 0.0 && ordinates[n].travel[2] < 0.0;
    }
    /* 8^(2/3) = 4 on a quarter: 4/7; the bilinear edge is a texel of 8 wide at half the contrast,
     * on both sides: about +-4 % of what is inside */
    assert_true(fabs((double)inside / COUNT - 4.0 / 7.0) < 0.04);
    air_environment_ordinates_destroy(sky);
}

/* ---- stability ---- */

static void choices_are_deterministic(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    static air_ordinate a[256], b[256];
    paint(pixels, WIDTH, HEIGHT, 40);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    for (int form = 0; form < 2; form++) {
        air_environment_ordinates *first = prepare(*state, &map), *second = prepare(*state, &map);
        choose(*state, first, 256, NULL, a);
        choose(*state, second, 256, NULL, b);
        assert_memory_equal(a, b, sizeof a);
        air_environment_ordinates_destroy(first);
        air_environment_ordinates_destroy(second);
    }
}

/* The farthest that any of n moves, and the mean over them by irradiance. */
static void moved(const air_ordinate *a, const air_ordinate *b, size_t count, double *most,
                  double *mean)
{
    double flux = 0.0;
    *most = *mean = 0.0;
    for (size_t n = 0; n < count; n++) {
        const double angle = degrees_between(a[n].travel, b[n].travel);
        *most = fmax(*most, angle);
        *mean += angle * a[n].irradiance[1];
        flux += a[n].irradiance[1];
    }
    *mean /= flux;
}

/* 1 % more importance over half of the sky moves at most a quarter of a percent of all weight over
 * any cut: 0.16 of a stratum of 64, and its mean direction by that part of its size, sqrt(4 pi /
 * 64) = 25 degrees, or twice that for two that touch along a corner. */
static void small_changes_of_importance_move_ordinates_little(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    float importance[AIR_IMPORTANCE_TEXELS];
    static air_ordinate a[64], b[64];
    double most, mean;
    paint(pixels, WIDTH, HEIGHT, 40);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    air_environment_ordinates *sky = prepare(*state, &map);
    for (size_t i = 0; i < AIR_IMPORTANCE_TEXELS; i++) {
        importance[i] = 1.0f;
    }
    choose(*state, sky, 64, importance, a);
    for (size_t i = 0; i < AIR_IMPORTANCE_TEXELS; i++) {
        importance[i] = i % 32 < 16 ? 1.01f : 1.0f;
    }
    choose(*state, sky, 64, importance, b);
    moved(a, b, 64, &most, &mean);
    print_message("importance of half the sky + 1 %%: moved %.3f degrees, at most %.3f\n", mean,
                  most);
    assert_true(most < 0.16 * 50.0);
    assert_true(mean < 0.16 * 25.0);
    air_environment_ordinates_destroy(sky);
}

/* Content that turns by a pixel, 2.8 degrees, where the curve does not turn with it. */
static void small_turns_of_the_picture_move_ordinates_little(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    static air_ordinate a[64], b[64];
    double most, mean;
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    paint(pixels, WIDTH, HEIGHT, 40);
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, a);
    air_environment_ordinates_destroy(sky);
    paint(pixels, WIDTH, HEIGHT, 41);
    sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, b);
    moved(a, b, 64, &most, &mean);
    print_message("picture turned by 2.8 degrees: moved %.3f degrees, at most %.3f\n", mean, most);
    assert_true(mean < 2.0 * 2.8);
    assert_true(most < 25.0); /* a stratum's size */
    air_environment_ordinates_destroy(sky);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_skies_give_four_pi),
        cmocka_unit_test(strata_sum_to_the_map),
        cmocka_unit_test(points_estimate_the_map),
        cmocka_unit_test(strata_of_an_even_sky_are_compact),
        cmocka_unit_test(directions_of_an_even_sky_are_even),
        cmocka_unit_test(directions_are_not_mirrored),
        cmocka_unit_test(rotations_turn_the_ordinates),
        cmocka_unit_test(importance_is_in_world_space),
        cmocka_unit_test(importance_draws_ordinates),
        cmocka_unit_test(choices_are_deterministic),
        cmocka_unit_test(small_changes_of_importance_move_ordinates_little),
        cmocka_unit_test(small_turns_of_the_picture_move_ordinates_little),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

/* Radial grids against simulations: the public spheres, narrow lamps. */
#include <stdio.h>

#include "radial_fixture.h"

#ifndef AIR_SHARED_DIR
#define AIR_SHARED_DIR "../shared"
#endif

typedef struct sphere {
    double scattered, total; /* relative errors, root mean square over shells */
    double variation;        /* of the histogram of mu, the beam in its last bin */
} sphere;

/* Of the result against a file of /spec/data/ordinates. */
static sphere compare(FILE *file)
{
    char line[2048];
    sphere sum = {0};
    assert_non_null(fgets(line, sizeof line, file));
    for (int k = 0; k < 32; k++) {
        double v[6 + BINS], given = 0.0, found = 0.0;
        assert_non_null(fgets(line, sizeof line, file));
        char *at = line;
        for (int i = 0; i < 6 + BINS; i++, at += *at == ',') {
            v[i] = strtod(at, &at);
        }
        const double phi = (double)fluence[k * 1024], direct = (double)beam[k * 1024];
        v[6 + BINS - 1] += v[3];
        binned[k * 1024 * BINS + BINS - 1] += (float)direct;
        for (int b = 0; b < BINS; b++) {
            given += v[6 + b];
            found += (double)binned[k * 1024 * BINS + b];
        }
        for (int b = 0; b < BINS; b++) {
            sum.variation +=
                0.5 * fabs((double)binned[k * 1024 * BINS + b] / found - v[6 + b] / given) / 32.0;
        }
        sum.scattered += (phi / v[4] - 1.0) * (phi / v[4] - 1.0) / 32.0;
        const double total = (phi + direct) / (v[4] + v[3]) - 1.0;
        sum.total += total * total / 32.0;
        assert_true(direct == 0.0 || fabs(direct / v[3] - 1.0) < 1e-5); /* six digits printed */
    }
    sum.scattered = sqrt(sum.scattered);
    sum.total = sqrt(sum.total);
    return sum;
}

static const char *const names[] = {"0.8", "1.0", "1.3"};

static bool run_sphere(const char *name, const air_radial_params *params, sphere *out)
{
    char path[512];
    snprintf(path, sizeof path, "%s/spec/data/ordinates/radial_g0.7_s%s.csv", AIR_SHARED_DIR, name);
    FILE *const file = fopen(path, "r");
    if (file == NULL) {
        print_message("skipped: there is no %s\n", path);
        return false;
    }
    const air_radial_cells cells = uniform(32, 32, strtof(name, NULL), 0.0f, 0.7f);
    for (int c = 0; c < 1024; c++) {
        intensity[c] = (float)(1.0 / (4.0 * AIR_PI));
    }
    const air_radial_light light = {.intensity = intensity, .lobe = 1.0f};
    run(&cells, &light, params);
    *out = compare(file);
    fclose(file);
    return true;
}

/* 2e6 photons: standard errors of 3 % in the first shell to 0.1 % in the last. 3 % is asked; the
 * scheme gives 2.7, 2.9, 2.8 % for the scattered and 1.5, 1.6, 1.8 % for all light, 0.016 to 0.022
 * of total variation. */
static void public_spheres_are_met_to_3_per_cent(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        sphere found;
        air_radial_params params = defaults();
        params.steps = 300;
        params.residual = 1e-5;
        if (run_sphere(names[i], &params, &found)) {
            print_message("sigma_s %s: scattered %.4f, all light %.4f, variation %.4f, %u steps\n",
                          names[i], found.scattered, found.total, found.variation, books.steps);
            assert_true(found.scattered < 0.03);
            assert_true(found.total < 0.02);
            assert_true(found.variation < 0.03);
        }
    }
}

/* The paper's stencil from the paper's start, 32 passes: everything counts, the beam too. The
 * specification has 0.31 and 0.41, and 1.25 and 8.96 when all is out; here 0.31 and 0.40, and 1.1
 * and 9.4 after 3000 steps. */
static void the_papers_stencil_is_as_far_off_as_specified(void **state)
{
    static const double given[2] = {0.31, 0.41};
    (void)state;
    for (int i = 0; i < 2; i++) {
        air_radial_params params = defaults();
        params.stencil = AIR_ORDINATES_LITERAL;
        params.lateral = AIR_RADIAL_SIDES;
        params.decay = AIR_ORDINATES_DECAY_PAPER;
        params.start = AIR_ORDINATES_BOUNDARY;
        params.steps = 31;
        sphere found;
        if (run_sphere(names[2 * i], &params, &found)) {
            print_message("literal, sigma_s %s: %.3f\n", names[2 * i], found.total);
            assert_true(fabs(found.total - given[i]) < 0.03);
        }
    }
}

/* Paths in bands of the cosine to the axis, m per W, all light scattered at least once, of lamps in
 * R = 2.5, sigma_s = 1.3, g = 0.7: a simulation of 2e6 photons, counting collisions; its errors are
 * below 0.5 %. */
static const double cosine_lobe_bands[16] = {.03832, .04177, .04620, .05207, .05888, .06815,
                                             .07988, .09685, .12264, .15718, .19600, .23755,
                                             .28272, .32850, .37483, .42201};
static const double cone_30_bands[16] = {.03091, .03337, .03662, .04022, .04450, .04909,
                                         .05533, .06248, .07247, .08551, .10333, .12950,
                                         .17167, .24987, .45816, .98051};

/* Half the difference of the two distributions over the bands, 0 to 1. */
static double misplaced(const double axis[3], const double bands[16])
{
    double found[16] = {0}, size[16] = {0}, sum = 0.0, given = 0.0;
    for (uint32_t c = 0; c < 1024; c++) {
        double d[3];
        air_radial_direction(32, c % 32, c / 32, d);
        const double cosine = axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
        const int band = (int)double_min(15.0, 8.0 * (cosine + 1.0));
        const air_radial_grid grid = {.directions = 32, .shells = 32, .radius_m = 2.5f};
        size[band] += omega[c] * 16.0 / (4.0 * AIR_PI);
        for (uint32_t k = 0; k < 32; k++) {
            found[band] += (double)fluence[k * 1024 + c] * air_radial_volume(&grid, k, omega[c]);
        }
    }
    for (int b = 0; b < 16; b++) {
        sum += 0.5 * fabs(found[b] / size[b] - bands[b]);
        given += bands[b];
    }
    return sum / given;
}

/* Power 1 within 30 degrees of the axis; cells at the rim in part. */
static void fill_cone(const double axis[3])
{
    double power = 0.0;
    for (uint32_t c = 0; c < 1024; c++) {
        double d[3];
        air_radial_direction(32, c % 32, c / 32, d);
        const double angle = acos(axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2]);
        const double inside = 0.5 + (AIR_PI / 6.0 - angle) / sqrt(omega[c]);
        intensity[c] = (float)double_max(0.0, double_min(1.0, inside));
        power += (double)intensity[c] * omega[c];
    }
    for (int c = 0; c < 1024; c++) {
        intensity[c] = (float)((double)intensity[c] / power);
    }
}

/* SPREAD misplaces 3 % of a cosine lobe's light and 8 to 10 % of a narrow lamp's, hardly depending
 * on how the axis lies to the octahedron; SIDES 18 to 20 % and 37 %. */
static void narrow_light_spreads_as_simulated(void **state)
{
    static const double axes[2][3] = {{0.48, 0.6, 0.64}, {1.0, 0.0, 0.0}};
    (void)state;
    without_directions = true;
    for (int i = 0; i < 8; i++) {
        const double *const axis = axes[i & 1];
        const float normal[3] = {(float)axis[0], (float)axis[1], (float)axis[2]};
        const bool cone = (i & 2) != 0;
        const air_radial_cells cells = uniform(32, 32, 1.3f, 0.0f, 0.7f);
        const air_radial_light light = {.intensity = intensity, .lobe = 1.0f};
        air_radial_params params = defaults();
        params.lateral = i < 4 ? AIR_RADIAL_SPREAD : AIR_RADIAL_SIDES;
        if (cone) {
            fill_cone(axis);
        } else {
            air_radial_cosine_lobe(32, normal, intensity);
        }
        run(&cells, &light, &params);
        const double share = misplaced(axis, cone ? cone_30_bands : cosine_lobe_bands);
        print_message("%s, %s: %.3f\n", cone ? "30 degrees" : "cosine lobe",
                      i < 4 ? "spread" : "sides", share);
        assert_true(i < 4 ? share < (cone ? 0.12 : 0.05) : share > (cone ? 0.3 : 0.15));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(public_spheres_are_met_to_3_per_cent),
        cmocka_unit_test(the_papers_stencil_is_as_far_off_as_specified),
        cmocka_unit_test(narrow_light_spreads_as_simulated),
    };
    return cmocka_run_group_tests(tests, NULL, tear_down);
}

/* Outliers: which texels are, and that their light goes nowhere else. */
#include "atlas/outliers.h"

#include <math.h>
#include <string.h>

#include "atlas_fixture.h"

enum { SIZE = 48, TEXELS = SIZE * SIZE, AT = 24 * SIZE + 20 };

/* A plane of two charts, left and right, the texel's size 0.1 m. */
typedef struct field {
    uint32_t charts[TEXELS];
    float position[3][TEXELS], normal[3][TEXELS], area[TEXELS], spacing[TEXELS];
    float values[TEXELS], variance[TEXELS];
    uint16_t marks[TEXELS];
} field;

static void make_field(field *f)
{
    memset(f, 0, sizeof *f);
    for (size_t i = 0; i < TEXELS; i++) {
        f->charts[i] = i % SIZE < SIZE / 2 ? 1 : 2;
        f->position[0][i] = 0.1f * (float)(i % SIZE);
        f->position[1][i] = 0.1f * (float)(i / SIZE);
        f->normal[2][i] = 1.0f;
        f->area[i] = i % 3 == 0 ? 0.5f : 1.0f;
        f->spacing[i] = 0.1f;
        f->values[i] = i % SIZE < 12 ? 0.25f : 1.0f;
        f->variance[i] = 0.01f;
    }
}

static air_outlier_surface surface_of(const field *f)
{
    return (air_outlier_surface){.width = SIZE,
                                 .height = SIZE,
                                 .charts = f->charts,
                                 .position = {f->position[0], f->position[1], f->position[2]},
                                 .normal = {f->normal[0], f->normal[1], f->normal[2]},
                                 .area = f->area,
                                 .spacing = f->spacing,
                                 .least_cosine = 0.9f,
                                 .plane_distance = 1.0f};
}

static bool is_outlier(const field *f)
{
    const air_outlier_surface surface = surface_of(f);
    return air_outlier_is(&surface, f->values, f->variance, AT);
}

/* Alone, bright and uncertain; not with little more than the others' noise, not with a certain
 * value, not among five like it, and not where there is nothing to be held against. */
static void only_what_noise_made_is_an_outlier(void **state)
{
    static field f;
    (void)state;
    make_field(&f);
    assert_false(is_outlier(&f));
    f.values[AT] = 9.0f;
    f.variance[AT] = 64.0f;
    assert_true(is_outlier(&f));
    f.variance[AT] = 1.0f;
    assert_false(is_outlier(&f));
    f.variance[AT] = 64.0f;
    f.values[AT] = 1.25f;
    assert_false(is_outlier(&f));
    f.values[AT] = 9.0f;
    for (size_t n = 0; n < 5; n++) {
        assert_true(is_outlier(&f));
        f.values[AT - SIZE - 2 + n] = 9.0f;
        f.variance[AT - SIZE - 2 + n] = 64.0f;
    }
    assert_false(is_outlier(&f));
    make_field(&f);
    f.values[AT] = 9.0f;
    f.variance[AT] = 64.0f;
    for (size_t i = 0; i < TEXELS; i++) {
        f.charts[i] = i / SIZE == AT / SIZE ? 1 : AIR_NO_CHART;
    }
    assert_false(is_outlier(&f));
}

/* What there is on the chart is kept, by area, to the rounding of some hundred floats; the other
 * chart stays, what is farther than the radius stays, and where it is darker less arrives. */
static void light_is_spread_and_kept(void **state)
{
    static field f, before;
    air_outlier list[2];
    double sums[2] = {0.0, 0.0};
    (void)state;
    make_field(&f);
    f.values[AT] = 101.0f;
    f.values[AT + 2 * SIZE] = 51.0f;
    f.marks[AT] = f.marks[AT + 2 * SIZE] = 4;
    before = f;
    const air_outlier_surface surface = surface_of(&f);
    air_outliers_spread(&surface, f.marks, 4, list, f.values);
    for (size_t i = 0; i < TEXELS; i++) {
        const double dx = (double)(i % SIZE) - AT % SIZE, dy = (double)(i / SIZE) - AT / SIZE - 2.0;
        sums[0] += (double)(before.values[i] * f.area[i]);
        sums[1] += (double)(f.values[i] * f.area[i]);
        if (f.charts[i] == 2 || hypot(dx, dy) > AIR_OUTLIER_RADIUS + 2.0) {
            assert_true(f.values[i] == before.values[i]);
        }
    }
    assert_true(fabs(sums[1] / sums[0] - 1.0) < 1e-5);
    assert_true(f.values[AT] < 3.0f && f.values[AT] > 1.0f);
    const float bright = f.values[AT - 8] - 1.0f, dark = f.values[AT - 9] - 0.25f;
    assert_true(dark > 0.0f && dark < 0.6f * bright);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_what_noise_made_is_an_outlier),
        cmocka_unit_test(light_is_spread_and_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

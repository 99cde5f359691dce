/* Seams: which sides are found, and what the solver does to values along them. */
#include "atlas/seams.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "atlas_fixture.h"
#include "memory_shortage.h"

enum { SIZE = 48, TEXELS = SIZE * SIZE };

/* ---- a strip of the plane z = 0 in two charts ---- */

/* Two squares of a metre side by side, x from -1 to 0 and from 0 to 1, each 16 texels wide: the
 * first as it is at texel (4, 4), the second turned by an angle about the page's (34, 30). */
static atlas_mesh make_strip(double angle)
{
    static const uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    atlas_mesh mesh = atlas_mesh_make(8, 4);
    for (size_t v = 0; v < 8; v++) {
        const double x = v % 4 == 1 || v % 4 == 2 ? 1.0 : 0.0, y = v % 4 >= 2 ? 1.0 : 0.0;
        const double along = 16.0 * x - 8.0, down = 16.0 * y - 8.0;
        mesh.positions[3 * v] = (float)(v < 4 ? x - 1.0 : x);
        mesh.positions[3 * v + 1] = (float)y;
        const double at[2] = {
            v < 4 ? 4.0 + 16.0 * x : 34.0 + along * cos(angle) - down * sin(angle),
            v < 4 ? 4.0 + 16.0 * y : 30.0 + along * sin(angle) + down * cos(angle)};
        mesh.uv[2 * v] = (float)(at[0] / SIZE);
        mesh.uv[2 * v + 1] = (float)(at[1] / SIZE);
    }
    memcpy(mesh.indices, indices, sizeof indices);
    return mesh;
}

/* The place in the strip's plane of a texel's centre, by the chart that is nearer: the second is
 * the page's right part. */
static int position_of(size_t texel, double angle, double out[2])
{
    const double x = (double)(texel % SIZE) + 0.5, y = (double)(texel / SIZE) + 0.5;
    if (x < 21.5 && y < 21.5) {
        out[0] = (x - 4.0) / 16.0 - 1.0;
        out[1] = (y - 4.0) / 16.0;
        return 0;
    }
    const double along = (x - 34.0) * cos(angle) + (y - 30.0) * sin(angle);
    const double down = (y - 30.0) * cos(angle) - (x - 34.0) * sin(angle);
    out[0] = (along + 8.0) / 16.0;
    out[1] = (down + 8.0) / 16.0;
    return 1;
}

static bool is_on_chart(const double p[2], int chart)
{
    return p[0] >= (double)chart - 1.0 && p[0] <= (double)chart && p[1] >= 0.0 && p[1] <= 1.0;
}

static void make_charts(double angle, uint32_t *charts)
{
    for (size_t i = 0; i < TEXELS; i++) {
        double p[2];
        const int chart = position_of(i, angle, p);
        charts[i] = is_on_chart(p, chart) ? (uint32_t)chart : AIR_NO_CHART;
    }
}

static air_seams find(air_context *context, const air_atlas_part *parts, size_t count,
                      const float *const *normals)
{
    air_seams seams;
    air_seams_find_params params;
    air_seams_find_params_default(&params);
    assert_int_equal(air_seams_find(context, parts, count, normals, NULL, &params, &seams), AIR_OK);
    return seams;
}

/* ---- finding ---- */

static void sides_apart_on_the_page_are_seams(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_strip(0.5);
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    air_seams seams = find(context, &part, 1, NULL);
    assert_int_equal(seams.count, 1);
    const air_seam *seam = &seams.seams[0];
    assert_true(seam->triangle[0] / 2 != seam->triangle[1] / 2);
    /* side x = 20 of the first chart; ends are equal in space: y = 0 and y = 1 */
    const int first = seam->triangle[0] < 2 ? 0 : 1;
    for (int end = 0; end < 2; end++) {
        double p[2];
        const float *a = seam->place[first][end], *b = seam->place[1 - first][end];
        assert_float_equal(a[0], 20.0f, 1e-5f);
        const double along = ((double)b[0] - 34.0) * cos(0.5) + ((double)b[1] - 30.0) * sin(0.5);
        const double down = ((double)b[1] - 30.0) * cos(0.5) - ((double)b[0] - 34.0) * sin(0.5);
        p[0] = along + 8.0;
        p[1] = down + 8.0;
        assert_true(fabs(p[0]) < 1e-4);
        assert_true(fabs(p[1] - ((double)a[1] - 4.0)) < 1e-4);
    }
    air_seams_finish(context, &seams);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static void sides_that_are_one_are_none(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_grid(5, 0.2f, 1);
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    air_seams seams = find(context, &part, 1, NULL);
    assert_int_equal(seams.count, 0);
    air_seams_finish(context, &seams);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Folded by a right angle there is an edge, not a seam; unless vertices' normals say that it is
 * smooth. Between two parts it is the same. */
static void edges_are_no_seams(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_strip(0.0);
    float smooth[8 * 3];
    for (size_t v = 0; v < 8; v++) {
        if (v >= 4) { /* x to z */
            mesh.positions[3 * v + 2] = mesh.positions[3 * v];
            mesh.positions[3 * v] = 0.0f;
        }
        smooth[3 * v] = 1.0f;
        smooth[3 * v + 1] = 0.0f;
        smooth[3 * v + 2] = -1.0f;
    }
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    const float *normals[2] = {smooth, smooth + 12};
    air_seams seams = find(context, &part, 1, NULL);
    assert_int_equal(seams.count, 0);
    air_seams_finish(context, &seams);
    seams = find(context, &part, 1, normals);
    assert_int_equal(seams.count, 1);
    air_seams_finish(context, &seams);
    static const uint32_t second[6] = {0, 1, 2, 0, 2, 3};
    air_atlas_part parts[2] = {part, part};
    parts[0].vertex_count = parts[1].vertex_count = 4;
    parts[0].triangle_count = parts[1].triangle_count = 2;
    parts[1].positions += 12;
    parts[1].uv += 8;
    parts[1].indices = second;
    seams = find(context, parts, 2, normals);
    assert_int_equal(seams.count, 1);
    assert_true(seams.seams[0].triangle[0] < 2 && seams.seams[0].triangle[1] >= 2);
    air_seams_finish(context, &seams);
    seams = find(context, parts, 2, NULL);
    assert_int_equal(seams.count, 0);
    air_seams_finish(context, &seams);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* ---- solving ---- */

typedef struct field {
    float planes[3][TEXELS];
} field;

static air_seams_report solve_with(air_context *context, double angle,
                                   const air_seams_params *params, field *values)
{
    static uint32_t charts[TEXELS];
    atlas_mesh mesh = make_strip(angle);
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    float *const planes[3] = {values->planes[0], values->planes[1], values->planes[2]};
    const air_seams_page page = {SIZE, SIZE, charts, planes};
    air_seams_report report;
    air_seams seams = find(context, &part, 1, NULL);
    make_charts(angle, charts);
    assert_int_equal(air_seams_solve(context, &seams, &page, 1, 3, params, &report), AIR_OK);
    air_seams_finish(context, &seams);
    atlas_mesh_free(&mesh);
    return report;
}

static air_seams_report solve(air_context *context, double angle, field *values)
{
    air_seams_params params;
    air_seams_params_default(&params);
    return solve_with(context, angle, &params, values);
}

/* Constant, linear in x, linear in y over the surface and its gutters: bilinear samples are exact
 * at any angle, so nothing needs to change. The uv are rounded to float: 48 texels by 2^-25 move
 * samples by 1.5e-6 texels, of 1/16 of the slope each. */
static void what_agrees_stays(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    for (int n = 0; n < 5; n++) {
        static field before, after;
        const double angle = 0.4 * n;
        for (size_t i = 0; i < TEXELS; i++) {
            double p[2];
            (void)position_of(i, angle, p);
            before.planes[0][i] = 0.37f;
            before.planes[1][i] = (float)(0.5 + 0.2 * p[0]);
            before.planes[2][i] = (float)(0.5 - 0.3 * p[1]);
        }
        after = before;
        (void)solve(context, angle, &after);
        for (size_t i = 0; i < TEXELS; i++) {
            assert_true(after.planes[0][i] == before.planes[0][i]);
            assert_float_equal(after.planes[1][i], before.planes[1][i], 1e-6f);
            assert_float_equal(after.planes[2][i], before.planes[2][i], 1e-6f);
        }
    }
    air_context_destroy(context);
}

/* Texels between a centre and the seam's sides on the page. */
static double distance_to_seam(size_t texel, double angle)
{
    double p[2];
    const int chart = position_of(texel, angle, p);
    const double outside = p[1] < 0.0 ? -p[1] : p[1] > 1.0 ? p[1] - 1.0 : 0.0;
    (void)chart;
    return 16.0 * hypot(p[0], outside);
}

/* A jump from 0.2 to 0.8 shrinks at least 200 times, and nothing beyond two texels from the seam
 * changes. */
static void jumps_shrink(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    for (int n = 0; n < 5; n++) {
        static field before, after;
        const double angle = 0.4 * n;
        for (size_t i = 0; i < TEXELS; i++) {
            double p[2];
            const int chart = position_of(i, angle, p);
            before.planes[0][i] = chart == 0 ? 0.2f : 0.8f;
            before.planes[1][i] = (float)(0.5 + 0.2 * p[0] + (chart == 0 ? 0.0 : 0.1));
            before.planes[2][i] = (float)(0.5 + 0.2 * sin(6.0 * p[1]) * (chart == 0 ? 1.0 : 0.5));
        }
        after = before;
        const air_seams_report report = solve(context, angle, &after);
        (void)printf("turned by %.1f: jump %.2f of 255, then rms %.3f, most %.3f; %zu samples, "
                     "%zu texels, %u iterations\n",
                     angle, 255.0 * report.most_before, 255.0 * report.rms_after,
                     255.0 * report.most_after, report.sample_count, report.texel_count,
                     report.iterations);
        assert_true(fabs(report.most_before - 0.6) < 1e-3);
        assert_true(report.most_after < report.most_before / 200.0);
        assert_true(report.rms_after < report.rms_before / 200.0);
        for (size_t i = 0; i < TEXELS; i++) {
            for (int k = 0; k < 3 && distance_to_seam(i, angle) > 2.0; k++) {
                assert_true(after.planes[k][i] == before.planes[k][i]);
            }
            /* nothing swings beyond what was there */
            assert_true(after.planes[0][i] > 0.199f && after.planes[0][i] < 0.801f);
        }
    }
    air_context_destroy(context);
}

/* Weights that stand out of the rounding of values. */
static air_seams_params strong_params(void)
{
    air_seams_params params;
    air_seams_params_default(&params);
    params.hold = 0.01;
    params.hold_free = 0.005;
    params.stiffness = 0.003;
    params.tolerance = 1e-5;
    return params;
}

/* The sum of squares of four texels' changes less their mean. */
static double unevenness(const float *before, const float *after)
{
    static const size_t at[4] = {0, 1, SIZE, SIZE + 1};
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < 4; k++) {
        const double change = (double)after[at[k]] - (double)before[at[k]];
        sum += change;
        squares += change * change;
    }
    return squares - 0.25 * sum * sum;
}

/* What is made least with strong_params, anew: bilinear samples along both sides. */
static double energy(const air_seams *seams, const uint32_t *charts, const float *before,
                     const float *after)
{
    double sum = 0.0;
    for (size_t i = 0; i < seams->count; i++) {
        const air_seam *seam = &seams->seams[i];
        for (int n = 0; n <= 32; n++) { /* 16 texels */
            double side[2];
            for (int s = 0; s < 2; s++) {
                double at[2];
                for (int k = 0; k < 2; k++) {
                    const double a = (double)seam->place[s][0][k];
                    at[k] = a + n / 32.0 * ((double)seam->place[s][1][k] - a) - 0.5;
                }
                const double u = floor(at[0]), v = floor(at[1]);
                const double fu = at[0] - u, fv = at[1] - v;
                const size_t first = (size_t)v * SIZE + (size_t)u;
                const float *p = after + first;
                sum += 0.003 * unevenness(before + first, p);
                side[s] = (1.0 - fv) * ((1.0 - fu) * (double)p[0] + fu * (double)p[1]) +
                          fv * ((1.0 - fu) * (double)p[SIZE] + fu * (double)p[SIZE + 1]);
            }
            sum += (side[0] - side[1]) * (side[0] - side[1]);
        }
    }
    for (size_t i = 0; i < TEXELS; i++) {
        const double change = (double)after[i] - (double)before[i];
        sum += (charts[i] == AIR_NO_CHART ? 0.005 : 0.01) * change * change;
    }
    return sum;
}

/* Noise: no small change of a texel makes the energy less. A change by e adds g e + c e^2 with c of
 * at least hold; the gradient g is 0 to the solver's 1e-5 of what it was and to the rounding of
 * values to float (2^-25 times a curvature of at most 8), so g is below 1e-5 and e = 0.01 adds 2e-7
 * at least and takes 1e-7 at most. */
static void the_least_is_found(void **state)
{
    static field before, after;
    static uint32_t charts[TEXELS];
    const double angle = 0.7;
    (void)state;
    air_context *context = atlas_context(1);
    air_rng rng = air_rng_from_keys(5, 5);
    for (size_t i = 0; i < 3 * TEXELS; i++) {
        before.planes[i / TEXELS][i % TEXELS] = air_rng_float(&rng);
    }
    after = before;
    const air_seams_params params = strong_params();
    (void)solve_with(context, angle, &params, &after);
    make_charts(angle, charts);
    atlas_mesh mesh = make_strip(angle);
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    air_seams seams = find(context, &part, 1, NULL);
    const double least = energy(&seams, charts, before.planes[1], after.planes[1]);
    assert_true(least < 0.1 * energy(&seams, charts, before.planes[1], before.planes[1]));
    for (size_t i = 0; i < 2 * TEXELS; i++) {
        float *value = &after.planes[1][i / 2];
        const float kept = *value;
        if (distance_to_seam(i / 2, angle) < 2.0) {
            *value += i % 2 == 0 ? 0.01f : -0.01f;
            assert_true(energy(&seams, charts, before.planes[1], after.planes[1]) > least);
            *value = kept;
        }
    }
    air_seams_finish(context, &seams);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Mostly dark with bright texels between: what joins them swings below 0. As light it does not,
 * and where it would the rest makes up for it: the energy is less than with the excess cut off. A
 * plane that is no light has the bytes that it would have alone, and what was below 0 may stay. */
static void light_does_not_fall_below_0(void **state)
{
    static field before, free_sign, light;
    static uint32_t charts[TEXELS];
    size_t below[3] = {0, 0, 0};
    (void)state;
    air_context *context = atlas_context(1);
    for (int n = 0; n < 5; n++) {
        const double angle = 0.4 * n;
        air_rng rng = air_rng_from_keys(8, (uint32_t)n);
        for (size_t i = 0; i < 3 * TEXELS; i++) {
            const float x = air_rng_float(&rng);
            before.planes[i / TEXELS][i % TEXELS] = x * x * x * x * x * x;
        }
        before.planes[1][SIZE * 12 + 19] = -0.25f; /* at the seam */
        free_sign = light = before;
        air_seams_params params = strong_params();
        (void)solve_with(context, angle, &params, &free_sign);
        params.light_planes = 2;
        (void)solve_with(context, angle, &params, &light);
        assert_memory_equal(light.planes[2], free_sign.planes[2], sizeof light.planes[2]);
        for (size_t i = 0; i < 3 * TEXELS; i++) {
            const size_t k = i / TEXELS, t = i % TEXELS;
            below[k] += free_sign.planes[k][t] < 0.0f;
            assert_true(k == 2 || light.planes[k][t] >= 0.0f || before.planes[k][t] < 0.0f);
            free_sign.planes[k][t] = fmaxf(free_sign.planes[k][t], 0.0f);
        }
        make_charts(angle, charts);
        atlas_mesh mesh = make_strip(angle);
        const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
        air_seams seams = find(context, &part, 1, NULL);
        const double solved = energy(&seams, charts, before.planes[0], light.planes[0]);
        const double cut = energy(&seams, charts, before.planes[0], free_sign.planes[0]);
        (void)printf("turned by %.1f: energy %.5f, with light below 0 cut off %.5f\n", angle,
                     solved, cut);
        assert_true(solved < cut);
        air_seams_finish(context, &seams);
        atlas_mesh_free(&mesh);
    }
    assert_true(below[0] > 0 && below[1] > 0 && below[2] > 0);
    air_context_destroy(context);
}

/* ---- the rest ---- */

static void threads_do_not_matter(void **state)
{
    static field start, both[2];
    (void)state;
    air_rng rng = air_rng_from_keys(6, 6);
    for (size_t i = 0; i < 3 * TEXELS; i++) {
        start.planes[i / TEXELS][i % TEXELS] = air_rng_float(&rng);
    }
    start.planes[2][SIZE * 10 + 20] = NAN; /* a plane that stays */
    for (size_t i = 0; i < 2; i++) {
        air_context *context = atlas_context(1 + 3 * i);
        both[i] = start;
        (void)solve(context, 0.3, &both[i]);
        air_context_destroy(context);
    }
    assert_memory_equal(&both[0], &both[1], sizeof both[0]);
    assert_memory_equal(both[0].planes[2], start.planes[2], sizeof start.planes[2]);
    assert_memory_not_equal(both[0].planes[1], start.planes[1], sizeof start.planes[1]);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_strip(0.5);
    air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    air_seams_find_params finding = {-1.0};
    air_seams seams;
    assert_int_equal(air_seams_find(context, &part, 1, NULL, NULL, &finding, &seams),
                     AIR_ERROR_ARGUMENT);
    finding.angle_rad = 0.1;
    part.positions = NULL;
    assert_int_equal(air_seams_find(context, &part, 1, NULL, NULL, &finding, &seams),
                     AIR_ERROR_ARGUMENT);
    assert_null(seams.seams);
    air_seam seam = {.page = {0, 1}};
    const air_seams one = {&seam, 1};
    static uint32_t charts[TEXELS];
    static float plane[TEXELS];
    float *const planes[1] = {plane};
    const air_seams_page page = {SIZE, SIZE, charts, planes};
    air_seams_params params;
    air_seams_params_default(&params);
    assert_int_equal(air_seams_solve(context, &one, &page, 1, 1, &params, NULL),
                     AIR_ERROR_ARGUMENT);
    seam.page[1] = 0;
    assert_int_equal(air_seams_solve(context, &one, &page, 1, 1, &params, NULL), AIR_OK);
    params.hold = 0.0;
    assert_int_equal(air_seams_solve(context, &one, &page, 1, 1, &params, NULL),
                     AIR_ERROR_ARGUMENT);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static air_status try_seams(air_context *context, void *part)
{
    static uint32_t charts[TEXELS];
    static float plane[TEXELS];
    float *const planes[1] = {plane};
    const air_seams_page page = {SIZE, SIZE, charts, planes};
    air_seams_find_params finding;
    air_seams_params params;
    air_seams seams = {NULL, 0};
    air_seams_find_params_default(&finding);
    air_seams_params_default(&params);
    air_status status = air_seams_find(context, part, 1, NULL, NULL, &finding, &seams);
    if (status == AIR_OK) {
        status = air_seams_solve(context, &seams, &page, 1, 1, &params, NULL);
    }
    air_seams_finish(context, &seams);
    return status;
}

static void want_of_memory_is_reported(void **state)
{
    (void)state;
    atlas_mesh mesh = make_strip(0.5);
    air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, SIZE, SIZE);
    assert_shortage_survived(try_seams, &part, 100);
    atlas_mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_apart_on_the_page_are_seams),
        cmocka_unit_test(sides_that_are_one_are_none),
        cmocka_unit_test(edges_are_no_seams),
        cmocka_unit_test(what_agrees_stays),
        cmocka_unit_test(jumps_shrink),
        cmocka_unit_test(the_least_is_found),
        cmocka_unit_test(light_does_not_fall_below_0),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

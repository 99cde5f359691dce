/* Coverage of texels by triangles: areas, points, centres, what is reported. */
#include "atlas/coverage.h"

#include <math.h>
#include <string.h>

#include "atlas_fixture.h"
#include "memory_shortage.h"

static air_coverage *cover(air_context *context, size_t width, size_t height,
                           const air_atlas_part *parts, size_t count, air_coverage_report *report)
{
    air_coverage *self = NULL;
    assert_int_equal(air_coverage_create(context, width, height, parts, count, &self, report),
                     AIR_OK);
    return self;
}

static double uv_area(const air_atlas_part *part, size_t t)
{
    double p[3][2];
    for (size_t i = 0; i < 3; i++) {
        for (size_t k = 0; k < 2; k++) {
            p[i][k] = (double)part->uv[2 * part->indices[3 * t + i] + k] * part->size[k];
        }
    }
    return 0.5 * fabs((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                      (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]));
}

/* Adds up the fragments' areas by triangle, in doubles. */
static void add_areas(const air_coverage *self, double *sums)
{
    for (size_t i = 0; i < self->width * self->height; i++) {
        const size_t x = i % self->width, y = i / self->width;
        size_t count;
        const air_fragment *fragments = air_coverage_texel(self, x, y, &count);
        for (size_t k = 0; k < count; k++) {
            air_piece outline;
            const uint32_t t = air_fragment_triangle(fragments[k]);
            air_coverage_outline(self, x, y, t, &outline);
            const double area = air_piece_area(&outline);
            assert_true(area > 0.0);
            /* half an ulp */
            assert_true(fabs((double)fragments[k].area - area) <= 0x1p-24 * area);
            sums[t] += area;
        }
    }
}

static void check_sums(float size, double offset)
{
    enum { COUNT = 300 };
    air_context *context = atlas_context(2);
    atlas_mesh mesh = atlas_random(COUNT, size, 5);
    const air_atlas_part part = atlas_part(&mesh, offset, offset, 201.5, 77.25);
    double sums[COUNT] = {0.0};
    air_coverage_report report;
    air_coverage *self = cover(context, 256, 128, &part, 1, &report);
    assert_int_equal(report.outside_count, 0);
    assert_int_equal(report.degenerate_count, 0);
    add_areas(self, sums);
    for (size_t t = 0; t < COUNT; t++) {
        const double area = uv_area(&part, t);
        if (fabs(sums[t] - area) > 1e-9 * area) {
            fail_msg("triangle %zu: %.17g, expected %.17g", t, sums[t], area);
        }
    }
    air_coverage_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Large triangles, some of about a texel, and tiny ones, whose coordinates have few digits left. */
static void areas_sum_to_the_triangles(void **state)
{
    (void)state;
    check_sums(1.0f, 0.0);
    check_sums(0.02f, 3.5);
    check_sums(1e-3f, 20.125);
}

/* Points of triangles are in texels that have a fragment of the triangle. */
static void no_texel_is_missed(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    atlas_mesh mesh = atlas_random(200, 0.5f, 6);
    const air_atlas_part part = atlas_part(&mesh, 2.0, 1.0, 60.0, 50.0);
    air_coverage *self = cover(context, 64, 64, &part, 1, NULL);
    air_rng rng = air_rng_from_keys(1, 1);
    for (size_t n = 0; n < 100000; n++) {
        const size_t t = n % mesh.triangle_count;
        double b[2] = {(double)air_rng_float(&rng), (double)air_rng_float(&rng)}, at[2];
        if (b[0] + b[1] > 1.0) {
            b[0] = 1.0 - b[0];
            b[1] = 1.0 - b[1];
        }
        for (size_t k = 0; k < 2; k++) {
            const float *uv = mesh.uv + 6 * t + k;
            const double u =
                (1.0 - b[0] - b[1]) * (double)uv[0] + b[0] * (double)uv[2] + b[1] * (double)uv[4];
            at[k] = u * part.size[k] + part.offset[k];
        }
        size_t count, found = 0;
        const air_fragment *fragments =
            air_coverage_texel(self, (size_t)at[0], (size_t)at[1], &count);
        for (size_t k = 0; k < count; k++) {
            found += air_fragment_triangle(fragments[k]) == t;
            assert_true(k == 0 || air_fragment_triangle(fragments[k]) >
                                      air_fragment_triangle(fragments[k - 1]));
        }
        assert_int_equal(found, 1);
    }
    air_coverage_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* A closed grid covers each texel with area 1 and each centre once, also where vertices and sides
 * lie on centres and corners of texels (grid of 8 cells, no jitter). */
static void a_closed_grid_covers_all_once(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    for (uint32_t seed = 0; seed < 6; seed++) {
        atlas_mesh mesh = atlas_grid(seed == 0 ? 8 : 5 * seed, seed == 0 ? 0.0f : 0.2f, seed);
        const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 40.0, 24.0);
        air_coverage_report report;
        air_coverage_overlap overlap;
        air_coverage *self = cover(context, 40, 24, &part, 1, &report);
        assert_int_equal(report.covered_texels, 40 * 24);
        assert_int_equal(self->chart_count, 1);
        for (size_t i = 0; i < 40 * 24; i++) {
            size_t count, centres = 0;
            double sum = 0.0;
            const air_fragment *fragments = air_coverage_texel(self, i % 40, i / 40, &count);
            for (size_t k = 0; k < count; k++) {
                centres += (fragments[k].tag & AIR_FRAGMENT_CENTRE) != 0;
                sum += (double)fragments[k].area;
            }
            assert_int_equal(centres, 1);
            /* each area is rounded to float: the sum of half ulps */
            assert_true(fabs(sum - 1.0) <= 0x1p-24 + 1e-12);
        }
        assert_int_equal(air_coverage_find_overlap(context, self, &overlap), AIR_OK);
        assert_int_equal(overlap.texel_count, 0);
        air_coverage_destroy(context, self);
        atlas_mesh_free(&mesh);
    }
    air_context_destroy(context);
}

/* Where the weights put a point on the page. */
static void place_of(const air_atlas_part *part, const air_coverage_point *point, double out[2])
{
    double sum = 0.0;
    out[0] = out[1] = 0.0;
    for (size_t i = 0; i < 3; i++) {
        const float *uv = part->uv + 2 * part->indices[3 * point->triangle + i];
        assert_true(point->weights[i] >= 0.0);
        sum += point->weights[i];
        for (size_t k = 0; k < 2; k++) {
            out[k] += point->weights[i] * ((double)uv[k] * part->size[k] + part->offset[k]);
        }
    }
    assert_true(fabs(sum - 1.0) < 1e-14);
}

/* Adds a piece's area, and its centre of mass times that. */
static void add_mass(const air_piece *p, double *all, double mass[2])
{
    for (int j = 1; j + 1 < p->count; j++) {
        const double *a = p->point[0], *b = p->point[j], *c = p->point[j + 1];
        const double area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        *all += area;
        mass[0] += area * (a[0] + b[0] + c[0]) / 3.0;
        mass[1] += area * (a[1] + b[1] + c[1]) / 3.0;
    }
}

/* Strata of n x n points in a texel: the share that falls into each fragment is its area's, and the
 * mean of the points the pieces' centre of mass. A stratified point set of n^2 cells is off by less
 * than the cells along the borders between fragments: 1/n each (at most 6 fragments here, each with
 * at most 5 pieces of its fan). */
static void points_are_spread_over_what_is_covered(void **state)
{
    enum { N = 200 };
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_grid(9, 0.2f, 3);
    mesh.triangle_count -= 40; /* some texels are partly covered */
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 12.0, 12.0);
    air_coverage *self = cover(context, 12, 12, &part, 1, NULL);
    for (size_t i = 0; i < 144; i++) {
        const size_t x = i % 12, y = i / 12;
        size_t count;
        double all = 0.0, mass[2] = {0.0, 0.0}, mean[2] = {0.0, 0.0};
        const air_fragment *fragments = air_coverage_texel(self, x, y, &count);
        size_t hits[16] = {0};
        assert_true(count <= 16);
        for (size_t k = 0; k < count; k++) {
            air_piece p;
            air_coverage_outline(self, x, y, air_fragment_triangle(fragments[k]), &p);
            add_mass(&p, &all, mass);
        }
        for (size_t n = 0; n < N * N; n++) {
            const double u[2] = {((double)(n % N) + 0.5) / N, ((double)(n / N) + 0.5) / N};
            double at[2];
            air_coverage_point point;
            const bool drawn = air_coverage_draw(self, x, y, u, &point);
            assert_int_equal(drawn, count > 0);
            for (size_t k = 0; k < count; k++) {
                hits[k] += point.triangle == air_fragment_triangle(fragments[k]);
            }
            if (drawn) {
                place_of(&part, &point, at);
                for (int c = 0; c < 2; c++) {
                    const double in = at[c] - (double)(c == 0 ? x : y);
                    assert_true(in > -1e-9 && in < 1.0 + 1e-9);
                    mean[c] += in / (N * N);
                }
            }
        }
        for (size_t k = 0; k < count; k++) {
            const double share = (double)hits[k] / (N * N);
            assert_true(fabs(share - (double)fragments[k].area / all) <= 1.0 / N);
        }
        for (int c = 0; c < 2 && count > 0; c++) {
            assert_true(fabs(mean[c] - mass[c] / all) <= 0.5 * (double)count / N);
        }
    }
    air_coverage_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static void centres_are_where_they_are(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_random(40, 0.4f, 8);
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 32.0, 32.0);
    air_coverage *self = cover(context, 32, 32, &part, 1, NULL);
    size_t covered = 0;
    for (size_t i = 0; i < 32 * 32; i++) {
        air_coverage_point point;
        double at[2];
        if (air_coverage_centre(self, i % 32, i / 32, &point)) {
            place_of(&part, &point, at);
            assert_true(fabs(at[0] - (double)(i % 32) - 0.5) < 1e-9);
            assert_true(fabs(at[1] - (double)(i / 32) - 0.5) < 1e-9);
            covered++;
        }
    }
    assert_true(covered > 100 && covered < 32 * 32);
    air_coverage_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Four triangles: good, flat in space, flat in uv, outside; and one with NaN. */
static void what_is_wrong_is_reported(void **state)
{
    static const float positions[15 * 3] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 1,
                                            2, 2, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0,
                                            1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    float uv[15 * 2] = {0,    0,    0.5f, 0, 0,     0.5f,  0,    0,    0.5f, 0,
                        0,    0.5f, 0,    0, 0.25f, 0.25f, 0.5f, 0.5f, 0.5f, 0.5f,
                        1.5f, 0.5f, 0.5f, 1, 0,     0,     0.5f, 0,    0,    0.5f};
    static const uint32_t indices[15] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
    (void)state;
    air_context *context = atlas_context(1);
    const air_atlas_part part = {.positions = positions,
                                 .uv = uv,
                                 .indices = indices,
                                 .vertex_count = 15,
                                 .triangle_count = 5,
                                 .offset = {1.0, 1.0},
                                 .size = {8.0, 8.0}};
    air_coverage_report report;
    uv[28] = NAN;
    air_coverage *self = cover(context, 16, 16, &part, 1, &report);
    assert_int_equal(report.degenerate_count, 3); /* the one with NaN, too */
    assert_int_equal(report.first_degenerate, 1);
    assert_int_equal(report.outside_count, 2);
    assert_int_equal(report.first_outside, 3);
    assert_float_equal(report.outside_uv[0], 1.5f, 0.0f);
    assert_float_equal(report.outside_uv[1], 0.5f, 0.0f);
    for (size_t y = 0; y < 16; y++) {
        size_t count;
        (void)air_coverage_texel(self, 9, y, &count); /* beyond the part's rectangle */
        assert_int_equal(count, 0);
    }
    double sums[5] = {0.0};
    add_areas(self, sums);
    assert_true(fabs(sums[0] - 8.0) < 1e-12);
    assert_true(fabs(sums[3] - 12.0) < 1e-12); /* of 16, 4 are cut off at u = 1 */
    assert_true(sums[1] + sums[2] + sums[4] == 0.0);
    air_coverage_destroy(context, self);
    air_context_destroy(context);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_grid(1, 0.0f, 1);
    air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 8.0, 8.0);
    air_coverage *self;
    assert_int_equal(air_coverage_create(context, 0, 8, &part, 1, &self, NULL), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_coverage_create(context, 8, 65537, &part, 1, &self, NULL),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_coverage_create(context, 8, 8, &part, 0, &self, NULL), AIR_ERROR_ARGUMENT);
    mesh.indices[4] = 4;
    assert_int_equal(air_coverage_create(context, 8, 8, &part, 1, &self, NULL), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "triangle 1"));
    mesh.indices[4] = 2;
    part.size[1] = 0.0;
    assert_int_equal(air_coverage_create(context, 8, 8, &part, 1, &self, NULL), AIR_ERROR_ARGUMENT);
    assert_null(self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* ---- overlaps ---- */

static air_coverage_overlap find_overlap(air_context *context, size_t size,
                                         const air_atlas_part *parts, size_t count)
{
    air_coverage_overlap overlap = {0};
    air_coverage *self = cover(context, size, size, parts, count, NULL);
    assert_int_equal(air_coverage_find_overlap(context, self, &overlap), AIR_OK);
    air_coverage_destroy(context, self);
    return overlap;
}

/* A strip of large triangles meets one of small ones along a slanted line; the small ones' vertices
 * are rounded to float, so they leave the line by half an ulp. */
static void rounding_is_no_overlap(void **state)
{
    enum { N = 64 };
    (void)state;
    air_context *context = atlas_context(2);
    atlas_mesh mesh = atlas_mesh_make(N + 4, N + 1);
    const float a[2] = {0.503f, 0.101f}, b[2] = {0.707f, 0.998f};
    for (size_t i = 0; i <= N; i++) {
        for (size_t k = 0; k < 2; k++) {
            const double share = (double)i / N;
            mesh.uv[2 * i + k] = (float)((double)a[k] + share * ((double)b[k] - (double)a[k]));
        }
    }
    mesh.uv[2 * (N + 1)] = 0.99f;
    mesh.uv[2 * (N + 1) + 1] = 0.5f;
    mesh.uv[2 * (N + 2)] = 0.1f;
    mesh.uv[2 * (N + 2) + 1] = 0.5f;
    for (size_t i = 0; i < N; i++) {
        mesh.indices[3 * i] = (uint32_t)i;
        mesh.indices[3 * i + 1] = (uint32_t)i + 1;
        mesh.indices[3 * i + 2] = N + 1;
    }
    mesh.indices[3 * N] = 0;
    mesh.indices[3 * N + 1] = N;
    mesh.indices[3 * N + 2] = N + 2;
    memset(mesh.positions, 0, 3 * mesh.vertex_count * sizeof(float));
    air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 4096.0, 4096.0);
    part.positions = NULL;
    assert_int_equal(find_overlap(context, 4096, &part, 1).texel_count, 0);
    /* 2e-6 is 8e-3 texels, ten times the tolerance */
    mesh.uv[0] += 2e-6f;
    const air_coverage_overlap overlap = find_overlap(context, 4096, &part, 1);
    assert_true(overlap.texel_count > 10);
    assert_int_equal(overlap.triangle[1], N);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Two squares that share a quarter: 4 x 4 texels of 8 x 8. */
static void overlapping_parts_are_found(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    atlas_mesh mesh = atlas_grid(1, 0.0f, 1);
    air_atlas_part parts[2] = {atlas_part(&mesh, 0.0, 0.0, 8.0, 8.0),
                               atlas_part(&mesh, 4.0, 4.0, 8.0, 8.0)};
    const air_coverage_overlap overlap = find_overlap(context, 40, parts, 2);
    assert_int_equal(overlap.texel_count, 16);
    assert_int_equal(overlap.texel[0], 4);
    assert_int_equal(overlap.texel[1], 4);
    assert_true(overlap.triangle[0] < 2 && overlap.triangle[1] >= 2);
    parts[1] = atlas_part(&mesh, 8.0, 0.0, 8.0, 8.0); /* side by side */
    assert_int_equal(find_overlap(context, 40, parts, 2).texel_count, 0);
    parts[1] = atlas_part(&mesh, 7.75, 0.0, 8.0, 8.0); /* a quarter of a texel */
    assert_int_equal(find_overlap(context, 40, parts, 2).texel_count, 8);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* 20,000 triangles in one texel, without and with an overlap, and 20,000 equal ones: the calls end,
 * and say so. */
static void crowded_texels_are_judged(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    atlas_mesh mesh = atlas_grid(100, 0.2f, 4);
    const air_atlas_part part = atlas_part(&mesh, 0.25, 0.25, 0.5, 0.5);
    assert_int_equal(find_overlap(context, 1, &part, 1).texel_count, 0);
    mesh.indices[3 * 7001 + 1] = mesh.indices[0];
    assert_int_equal(find_overlap(context, 1, &part, 1).texel_count, 1);
    for (size_t i = 3; i < 3 * mesh.triangle_count; i++) {
        mesh.indices[i] = mesh.indices[i - 3];
    }
    assert_int_equal(find_overlap(context, 4, &part, 1).texel_count, 1);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* ---- planes, threads, memory ---- */

static void planes_say_chart_and_area(void **state)
{
    enum { N = 20 };
    (void)state;
    air_context *context = atlas_context(2);
    atlas_mesh mesh = atlas_grid(1, 0.0f, 1);
    const air_atlas_part parts[2] = {atlas_part(&mesh, 1.0, 1.0, 4.5, 4.0),
                                     atlas_part(&mesh, 10.0, 1.0, 8.0, 17.0)};
    air_coverage *self = cover(context, N, N, parts, 2, NULL);
    static uint32_t charts[N * N];
    static float areas[N * N];
    assert_int_equal(self->chart_count, 2);
    air_coverage_planes(context, self, charts, areas);
    for (size_t i = 0; i < N * N; i++) {
        const double x = (double)(i % N), y = (double)(i / N);
        const bool first = x >= 1 && x < 5.5 && y >= 1 && y < 5;
        const bool second = x >= 10 && x < 18 && y >= 1 && y < 18;
        assert_int_equal(charts[i], first ? 0 : second ? 1 : AIR_NO_CHART);
        const double area = first ? fmin(1.0, 5.5 - x) : second ? 1.0 : 0.0;
        assert_true(fabs((double)areas[i] - area) <= 1e-6);
        assert_true(areas[i] == air_coverage_area(self, i % N, i / N));
    }
    air_coverage_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    atlas_mesh mesh = atlas_random(2000, 0.1f, 9);
    const air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 100.0, 100.0);
    air_context *contexts[2] = {atlas_context(1), atlas_context(3)};
    air_coverage *both[2];
    air_coverage_report reports[2];
    air_coverage_overlap overlaps[2];
    memset(reports, 0, sizeof reports);
    memset(overlaps, 0, sizeof overlaps);
    for (int i = 0; i < 2; i++) {
        both[i] = cover(contexts[i], 100, 100, &part, 1, &reports[i]);
        assert_int_equal(air_coverage_find_overlap(contexts[i], both[i], &overlaps[i]), AIR_OK);
    }
    assert_int_equal(reports[0].fragment_count, reports[1].fragment_count);
    assert_int_equal(reports[0].covered_texels, reports[1].covered_texels);
    assert_memory_equal(&overlaps[0], &overlaps[1], sizeof overlaps[0]);
    assert_true(overlaps[0].texel_count > 1000);
    for (size_t i = 0; i < both[0]->band_count; i++) {
        const size_t rows = i + 1 < both[0]->band_count ? 16 : 100 % 16;
        const uint32_t *first = both[0]->bands[i].first;
        assert_memory_equal(first, both[1]->bands[i].first, (rows * 100 + 1) * sizeof *first);
        assert_memory_equal(both[0]->bands[i].fragments, both[1]->bands[i].fragments,
                            first[rows * 100] * sizeof(air_fragment));
    }
    for (int i = 0; i < 2; i++) {
        air_coverage_destroy(contexts[i], both[i]);
        air_context_destroy(contexts[i]);
    }
    atlas_mesh_free(&mesh);
}

static air_status try_coverage(air_context *context, void *part)
{
    air_coverage *self = NULL;
    air_coverage_overlap overlap;
    air_status status = air_coverage_create(context, 40, 40, part, 1, &self, NULL);
    if (status == AIR_OK) {
        status = air_coverage_find_overlap(context, self, &overlap);
    }
    air_coverage_destroy(context, self);
    return status;
}

static void want_of_memory_is_reported(void **state)
{
    (void)state;
    atlas_mesh mesh = atlas_grid(6, 0.2f, 2);
    air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 40.0, 40.0);
    assert_shortage_survived(try_coverage, &part, 100);
    atlas_mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_sum_to_the_triangles),
        cmocka_unit_test(no_texel_is_missed),
        cmocka_unit_test(a_closed_grid_covers_all_once),
        cmocka_unit_test(points_are_spread_over_what_is_covered),
        cmocka_unit_test(centres_are_where_they_are),
        cmocka_unit_test(what_is_wrong_is_reported),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(rounding_is_no_overlap),
        cmocka_unit_test(overlapping_parts_are_found),
        cmocka_unit_test(crowded_texels_are_judged),
        cmocka_unit_test(planes_say_chart_and_area),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

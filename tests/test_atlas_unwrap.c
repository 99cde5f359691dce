/* Unwrapping: what holds for any mesh, and how well it does on some. */
#include "atlas/unwrap.h"

#include <math.h>
#include <string.h>

#include "atlas/coverage.h"
#include "atlas/islands.h"
#include "atlas_scene.h"
#include "core/triple.h"
#include "memory_shortage.h"

static const double pi = 3.14159265358979323846;

static air_unwrap *unwrap(air_context *context, const atlas_mesh *mesh,
                          const air_unwrap_params *params)
{
    air_unwrap *self = NULL;
    assert_int_equal(air_unwrap_create(context, mesh->positions, mesh->vertex_count, mesh->indices,
                                       mesh->triangle_count, params, &self),
                     AIR_OK);
    return self;
}

/* ---- what always holds ---- */

static void point_of(const atlas_mesh *mesh, uint32_t v, double out[3])
{
    for (size_t k = 0; k < 3; k++) {
        out[k] = (double)mesh->positions[3 * (size_t)v + k];
    }
}

/* Doubled area; 0 where there is none. */
static double normal_of(const atlas_mesh *mesh, size_t t, double out[3])
{
    double p[3][3], e[2][3];
    for (size_t i = 0; i < 3; i++) {
        point_of(mesh, mesh->indices[3 * t + i], p[i]);
    }
    air_subtract3(p[1], p[0], e[0]);
    air_subtract3(p[2], p[0], e[1]);
    air_cross3(e[0], e[1], out);
    const double length = air_length3(out);
    for (int k = 0; k < 3 && length > 0.0; k++) {
        out[k] /= length;
    }
    return length;
}

/* Vertices are those of the input; places are inside their rectangles; triangles with an area are
 * all turned the same way on the page, and their normals are near the chart's. */
static void check_triangles(const atlas_mesh *mesh, const air_unwrap *self, double angle)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const air_unwrap_chart *chart = &self->charts[self->triangle_charts[t]];
        double q[3][2], normal[3];
        assert_true(self->triangle_charts[t] < self->chart_count);
        for (size_t i = 0; i < 3; i++) {
            const uint32_t v = self->indices[3 * t + i];
            assert_true(v < self->vertex_count);
            assert_int_equal(self->vertices[v], mesh->indices[3 * t + i]);
            for (size_t k = 0; k < 2; k++) {
                q[i][k] = (double)self->places[2 * v + k];
                /* the place is rounded to float */
                assert_true(q[i][k] >= 0.0 && q[i][k] <= chart->extent[k] * (1.0 + 0x1p-23));
            }
        }
        if (normal_of(mesh, t, normal) > 1e-9) {
            const double turn = (q[1][0] - q[0][0]) * (q[2][1] - q[0][1]) -
                                (q[1][1] - q[0][1]) * (q[2][0] - q[0][0]);
            assert_true(turn < 0.0); /* y points down */
            assert_true(air_dot3(normal, chart->normal) >= cos(angle) - 1e-9);
        }
    }
}

/* Each chart by itself on a page, four times as large: nothing overlaps. */
static void check_overlaps(air_context *context, const air_unwrap *self)
{
    uint32_t *indices = atlas_zeros(3 * self->triangle_count, sizeof *indices);
    float *uv = atlas_zeros(2 * self->vertex_count, sizeof *uv);
    for (uint32_t c = 0; c < self->chart_count; c++) {
        const air_unwrap_chart *chart = &self->charts[c];
        air_atlas_part part = {.uv = uv,
                               .indices = indices,
                               .vertex_count = self->vertex_count,
                               .size = {4.0 * chart->texels[0], 4.0 * chart->texels[1]}};
        for (size_t t = 0; t < self->triangle_count; t++) {
            if (self->triangle_charts[t] == c) {
                memcpy(indices + 3 * part.triangle_count++, self->indices + 3 * t,
                       3 * sizeof *indices);
            }
        }
        for (size_t i = 0; i < 3 * part.triangle_count; i++) {
            for (size_t k = 0; k < 2; k++) {
                const size_t at = 2 * indices[i] + k;
                uv[at] = self->places[at] / (float)chart->texels[k];
            }
        }
        air_coverage *coverage;
        air_coverage_overlap overlap;
        assert_int_equal(air_coverage_create(context, 4 * chart->texels[0], 4 * chart->texels[1],
                                             &part, 1, &coverage, NULL),
                         AIR_OK);
        assert_int_equal(air_coverage_find_overlap(context, coverage, &overlap), AIR_OK);
        assert_int_equal(overlap.texel_count, 0);
        air_coverage_destroy(context, coverage);
    }
    free(uv);
    free(indices);
}

/* Charts hang together: over sides with equal positions and places there are as many islands. */
static void check_islands(air_context *context, const atlas_mesh *mesh, const air_unwrap *self)
{
    float *positions = atlas_zeros(3 * self->vertex_count, sizeof *positions);
    float *uv = atlas_zeros(2 * self->vertex_count, sizeof *uv);
    uint32_t *islands = atlas_zeros(self->triangle_count, sizeof *islands);
    size_t count;
    for (size_t t = 0; t < self->triangle_count; t++) {
        for (size_t i = 3 * t; i < 3 * t + 3; i++) {
            const size_t v = self->indices[i];
            memcpy(positions + 3 * v, mesh->positions + 3 * (size_t)self->vertices[v],
                   3 * sizeof *positions);
            /* charts apart */
            uv[2 * v] = self->places[2 * v];
            uv[2 * v + 1] = self->places[2 * v + 1] + 4096.0f * (float)self->triangle_charts[t];
        }
    }
    const air_atlas_part part = {.positions = positions,
                                 .uv = uv,
                                 .indices = self->indices,
                                 .vertex_count = self->vertex_count,
                                 .triangle_count = self->triangle_count};
    assert_int_equal(air_islands_find(context, &part, islands, &count), AIR_OK);
    assert_int_equal(count, self->chart_count);
    free(islands);
    free(uv);
    free(positions);
}

static air_unwrap_quality check_all(air_context *context, const atlas_mesh *mesh,
                                    const air_unwrap *self, const air_unwrap_params *params)
{
    check_triangles(mesh, self, fmax(params->angle_rad, params->merge_angle_rad));
    check_overlaps(context, self);
    check_islands(context, mesh, self);
    return air_unwrap_measure(self, mesh->positions, params->texels_per_metre);
}

/* Unwraps, checks, and gives the number of charts. */
static size_t charts_of(air_context *context, const atlas_mesh *mesh, double density,
                        air_unwrap_quality *out_quality)
{
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    params.texels_per_metre = density;
    air_unwrap *self = unwrap(context, mesh, &params);
    const air_unwrap_quality quality = check_all(context, mesh, self, &params);
    const size_t count = self->chart_count;
    if (out_quality != NULL) {
        *out_quality = quality;
    }
    air_unwrap_destroy(context, self);
    return count;
}

/* ---- meshes ---- */

static void set_point(atlas_mesh *mesh, size_t v, double x, double y, double z)
{
    mesh->positions[3 * v] = (float)x;
    mesh->positions[3 * v + 1] = (float)y;
    mesh->positions[3 * v + 2] = (float)z;
}

static void set_triangle(atlas_mesh *mesh, size_t t, size_t a, size_t b, size_t c)
{
    mesh->indices[3 * t] = (uint32_t)a;
    mesh->indices[3 * t + 1] = (uint32_t)b;
    mesh->indices[3 * t + 2] = (uint32_t)c;
}

/* A box with 8 vertices. */
static atlas_mesh make_box(double x, double y, double z)
{
    static const uint8_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    atlas_mesh mesh = atlas_mesh_make(8, 12);
    for (size_t v = 0; v < 8; v++) {
        set_point(&mesh, v, (v & 1) != 0 ? x : 0.0, (v & 2) != 0 ? y : 0.0, (v & 4) != 0 ? z : 0.0);
    }
    for (size_t f = 0; f < 6; f++) {
        set_triangle(&mesh, 2 * f, faces[f][0], faces[f][1], faces[f][2]);
        set_triangle(&mesh, 2 * f + 1, faces[f][0], faces[f][2], faces[f][3]);
    }
    return mesh;
}

/* Rings of `around` quads; `height` rows. closed: the last column is the first. */
static atlas_mesh make_sheet(size_t around, size_t rows)
{
    atlas_mesh mesh = atlas_mesh_make((around + 1) * (rows + 1), 2 * around * rows);
    for (size_t c = 0; c < around * rows; c++) {
        const size_t a = c / around * (around + 1) + c % around, b = a + around + 1;
        set_triangle(&mesh, 2 * c, a, a + 1, b + 1);
        set_triangle(&mesh, 2 * c + 1, a, b + 1, b);
    }
    return mesh;
}

static atlas_mesh make_sphere(size_t around, size_t rows)
{
    atlas_mesh mesh = make_sheet(around, rows);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        const size_t at = v % (around + 1) % around, row = v / (around + 1);
        const double phi = 2.0 * pi * (double)at / (double)around;
        const double theta = pi * (double)row / (double)rows;
        const double r = row == rows ? 0.0 : sin(theta);
        set_point(&mesh, v, r * cos(phi), cos(theta), r * sin(phi));
    }
    return mesh;
}

/* A band with half a twist; the ends meet turned over. */
static atlas_mesh make_moebius(size_t around)
{
    atlas_mesh mesh = make_sheet(around, 4);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        const size_t column = v % (around + 1), row = v / (around + 1);
        const bool last = column == around;
        const double phi = last ? 0.0 : 2.0 * pi * (double)column / (double)around;
        const double wide = 0.1 * ((double)row - 2.0) * (last ? -1.0 : 1.0);
        const double r = 1.0 + wide * cos(0.5 * phi);
        set_point(&mesh, v, r * cos(phi), wide * sin(0.5 * phi), r * sin(phi));
    }
    return mesh;
}

/* ---- tests ---- */

static void a_quad_is_one_chart(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    for (int turned = 0; turned < 8; turned++) {
        atlas_mesh mesh = make_sheet(1, 1);
        const double angle = 0.3 * turned;
        for (size_t v = 0; v < 4; v++) {
            const double x = v % 2 == 0 ? 0.0 : 3.0, y = v / 2 == 0 ? 0.0 : 2.0;
            set_point(&mesh, v, x * cos(angle), y, x * sin(angle));
        }
        air_unwrap *self = unwrap(context, &mesh, &params);
        const air_unwrap_quality quality = check_all(context, &mesh, self, &params);
        assert_int_equal(self->chart_count, 1);
        assert_int_equal(self->vertex_count, 4);
        /* walls stand: 3 m are across and 2 m are down, whichever way the wall looks */
        assert_int_equal(self->charts[0].texels[0], 30);
        assert_int_equal(self->charts[0].texels[1], 20);
        /* corners are rounded to float, 3 m by 2^-25 */
        assert_true(fabs(quality.least_stretch - 1.0) < 1e-6);
        assert_true(fabs(quality.most_stretch - 1.0) < 1e-6);
        assert_true(fabs(quality.utilisation - 1.0) < 1e-6);
        for (size_t i = 0; i < 8; i++) {
            const float texel = self->places[i];
            assert_true(fabsf(texel - rintf(texel)) < 1e-5f);
        }
        air_unwrap_destroy(context, self);
        atlas_mesh_free(&mesh);
    }
    air_context_destroy(context);
}

static void a_box_is_six_rectangles(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_box(1.03, 2.08, 0.51);
    air_unwrap_quality quality;
    assert_int_equal(charts_of(context, &mesh, 20.0, &quality), 6);
    /* 20.6, 41.6 and 10.2 texels become 21, 42 and 10 */
    assert_true(fabs(quality.most_stretch - 21.0 / 20.6) < 1e-5);
    assert_true(fabs(quality.least_stretch - 10.0 / 10.2) < 1e-5);
    assert_true(fabs(quality.utilisation - 1.0) < 1e-5);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Without snapping texels are squares; sizes are what the density says. */
static void without_snapping_nothing_is_stretched(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_box(1.03, 2.08, 0.51);
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    params.snap = false;
    params.texels_per_metre = 20.0;
    air_unwrap *self = unwrap(context, &mesh, &params);
    const air_unwrap_quality quality = check_all(context, &mesh, self, &params);
    assert_true(fabs(quality.most_stretch - 1.0) < 1e-5);
    assert_true(fabs(quality.least_stretch - 1.0) < 1e-5);
    assert_true(fabs(self->charts[0].extent[0] * self->charts[0].extent[1] - 20.6 * 41.6) < 1e-3);
    air_unwrap_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* A chart's normals are within 40 degrees of its mean, so shrinking is at most by cos 40 = 0.77
 * (merging aside, which needs less than 8 texels). A cap of 40 degrees is 0.117 of a sphere, so 9
 * charts are the least. */
static void a_sphere_is_a_few_caps(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_sphere(100, 50);
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    params.texels_per_metre = 50.0;
    params.snap = false;
    air_unwrap *self = unwrap(context, &mesh, &params);
    const air_unwrap_quality quality = check_all(context, &mesh, self, &params);
    (void)printf("sphere: %zu charts, stretch %.3f to %.3f, mean %.3f, utilisation %.3f\n",
                 self->chart_count, quality.least_stretch, quality.most_stretch,
                 quality.mean_stretch, quality.utilisation);
    assert_true(self->chart_count >= 9 && self->chart_count <= 40);
    assert_true(quality.least_stretch >= cos(65.0 * pi / 180.0));
    assert_true(quality.most_stretch <= 1.0 + 1e-4);
    assert_true(quality.mean_stretch >= cos(40.0 * pi / 180.0));
    air_unwrap_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* A helix of one and a half turns of a flat ramp is over itself: its normals alone would make it
 * one chart. */
static void what_would_overlap_is_split(void **state)
{
    enum { AROUND = 90 };
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_sheet(AROUND, 2);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        const double phi = 3.0 * pi * (double)(v % (AROUND + 1)) / AROUND;
        const double r = 2.0 + 0.5 * (double)(v / (AROUND + 1));
        set_point(&mesh, v, r * cos(phi), 0.3 * phi, r * sin(phi));
    }
    assert_int_equal(charts_of(context, &mesh, 20.0, NULL), 2);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static void one_sided_bands_are_unwrapped(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_moebius(60);
    const size_t charts = charts_of(context, &mesh, 30.0, NULL);
    assert_true(charts >= 4 && charts <= 30);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Five walls that meet in one side; ten equal triangles; triangles that meet in a point only. */
static void odd_meshes_are_unwrapped(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh fan = atlas_mesh_make(12, 10), stack = atlas_mesh_make(3, 10);
    for (size_t v = 0; v < 12; v++) {
        const double angle = 2.0 * pi * (double)(v / 2) / 5.0;
        set_point(&fan, v, v < 10 ? cos(angle) : 0.0, (double)(v % 2), v < 10 ? sin(angle) : 0.0);
    }
    for (size_t w = 0; w < 5; w++) {
        set_triangle(&fan, 2 * w, 10, 11, 2 * w + 1);
        set_triangle(&fan, 2 * w + 1, 10, 2 * w + 1, 2 * w);
    }
    assert_int_equal(charts_of(context, &fan, 10.0, NULL), 5);
    set_point(&stack, 1, 1.0, 0.0, 0.0);
    set_point(&stack, 2, 0.0, 1.0, 0.0);
    for (size_t t = 0; t < 10; t++) {
        set_triangle(&stack, t, 0, t % 2 == 0 ? 1 : 2, t % 2 == 0 ? 2 : 1);
    }
    assert_int_equal(charts_of(context, &stack, 10.0, NULL), 10);
    set_triangle(&fan, 1, 0, 5, 7); /* parallel to no wall */
    assert_true(charts_of(context, &fan, 10.0, NULL) >= 5);
    atlas_mesh_free(&stack);
    atlas_mesh_free(&fan);
    air_context_destroy(context);
}

/* A quad cut at a T-junction, filled with a triangle without area; a lonely one without area; and
 * one whose vertices are one. */
static void triangles_without_area_are_taken_along(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_mesh_make(9, 6);
    set_point(&mesh, 0, 0, 0, 0);
    set_point(&mesh, 1, 2, 0, 0);
    set_point(&mesh, 2, 1, 1, 0);
    set_point(&mesh, 3, 1, 0, 0); /* on side 0 1 */
    set_point(&mesh, 4, 0, -1, 0);
    set_point(&mesh, 5, 2, -1, 0);
    set_point(&mesh, 6, 5, 5, 5);
    set_point(&mesh, 7, 6, 6, 6);
    set_point(&mesh, 8, 7, 7, 7);
    set_triangle(&mesh, 0, 0, 1, 2);
    set_triangle(&mesh, 1, 0, 3, 1);
    set_triangle(&mesh, 2, 4, 3, 0);
    set_triangle(&mesh, 3, 4, 5, 3);
    set_triangle(&mesh, 4, 5, 1, 3);
    set_triangle(&mesh, 5, 6, 7, 8);
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    air_unwrap *self = unwrap(context, &mesh, &params);
    assert_int_equal(self->chart_count, 1);
    check_triangles(&mesh, self, 1e-6);
    check_overlaps(context, self);
    for (size_t i = 15; i < 18; i++) { /* the lonely one is a point */
        const uint32_t v = self->indices[i];
        assert_true(self->places[2 * v] == 0.0f && self->places[2 * v + 1] == 0.0f);
    }
    air_unwrap_destroy(context, self);
    for (size_t t = 0; t < 6; t++) {
        set_triangle(&mesh, t, t, t, t);
    }
    self = unwrap(context, &mesh, &params); /* nothing but points */
    assert_int_equal(self->chart_count, 1);
    assert_int_equal(self->charts[0].texels[0], 1);
    check_triangles(&mesh, self, 1e-6);
    air_unwrap_destroy(context, self);
    mesh.triangle_count = 0;
    self = unwrap(context, &mesh, &params);
    assert_int_equal(self->chart_count, 0);
    air_unwrap_destroy(context, self);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* A large sheet with a bump of steep small sides: the sides are less than 8 texels and join where
 * they are within 65 degrees; with that switched off they are charts. */
static void tiny_charts_join_their_neighbours(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_sheet(20, 20);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        const size_t x = v % 21, z = v / 21;
        const double bump = x == 10 && z == 10 ? 0.14 : 0.0; /* 54 degrees over 0.1 m */
        set_point(&mesh, v, 0.1 * (double)x, -bump, 0.1 * (double)z);
    }
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    air_unwrap *joined = unwrap(context, &mesh, &params);
    params.merge_texels = 0.0;
    air_unwrap *apart = unwrap(context, &mesh, &params);
    (void)check_all(context, &mesh, joined, &params);
    (void)check_all(context, &mesh, apart, &params);
    assert_int_equal(joined->chart_count, 1);
    assert_true(apart->chart_count > 3);
    air_unwrap_destroy(context, apart);
    air_unwrap_destroy(context, joined);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static void pieces_apart_are_charts_apart(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_random(200, 0.2f, 4); /* overlapping, but not joined */
    assert_int_equal(charts_of(context, &mesh, 100.0, NULL), 200);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Triangles between vertices drawn at random, so that sides have many triangles and none fits
 * another; far from the origin, too, where positions have few digits. */
static void soups_are_unwrapped(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    for (uint32_t seed = 0; seed < 24; seed++) {
        const size_t vertices = 6 + 4 * (size_t)seed;
        const double scale = pow(10.0, (double)(seed % 5) - 2.0),
                     away = seed % 3 == 0 ? 1000.0 : 0.0;
        atlas_mesh mesh = atlas_mesh_make(vertices, 200);
        air_rng rng = air_rng_from_keys(seed, 11);
        for (size_t i = 0; i < 3 * vertices; i++) {
            mesh.positions[i] = (float)(scale * (away + (double)air_rng_float(&rng)));
        }
        for (size_t i = 0; i < 600; i++) {
            mesh.indices[i] = air_rng_next(&rng) % (uint32_t)vertices;
        }
        air_unwrap_params params;
        air_unwrap_params_default(&params);
        params.texels_per_metre = 12.0 / scale;
        params.snap = seed % 2 == 0;
        air_unwrap *self = unwrap(context, &mesh, &params);
        check_triangles(&mesh, self, params.merge_angle_rad);
        check_overlaps(context, self);
        air_unwrap_destroy(context, self);
        atlas_mesh_free(&mesh);
    }
    air_context_destroy(context);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = make_box(1.0, 1.0, 1.0);
    air_unwrap_params params;
    air_unwrap *self;
    for (int i = 0; i < 5; i++) {
        air_unwrap_params_default(&params);
        params.texels_per_metre = i == 0 ? 0.0 : 1.0;
        params.angle_rad = i == 1 ? 1.5 : 0.5;
        params.merge_texels = i == 2 ? -1.0 : 1.0;
        mesh.positions[3] = i == 3 ? NAN : 0.5f;
        mesh.indices[7] = i == 4 ? 8 : 1;
        assert_int_equal(
            air_unwrap_create(context, mesh.positions, 8, mesh.indices, 12, &params, &self),
            AIR_ERROR_ARGUMENT);
        assert_null(self);
    }
    assert_non_null(strstr(air_context_last_error(context), "triangle 2"));
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static air_status try_unwrap(air_context *context, void *user)
{
    const atlas_mesh *mesh = user;
    air_unwrap_params params;
    air_unwrap *self = NULL;
    air_unwrap_params_default(&params);
    const air_status status =
        air_unwrap_create(context, mesh->positions, mesh->vertex_count, mesh->indices,
                          mesh->triangle_count, &params, &self);
    air_unwrap_destroy(context, self);
    return status;
}

static void want_of_memory_is_reported(void **state)
{
    (void)state;
    atlas_mesh mesh = make_sphere(8, 4);
    assert_shortage_survived(try_unwrap, &mesh, 200);
    atlas_mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_quad_is_one_chart),
        cmocka_unit_test(a_box_is_six_rectangles),
        cmocka_unit_test(without_snapping_nothing_is_stretched),
        cmocka_unit_test(a_sphere_is_a_few_caps),
        cmocka_unit_test(what_would_overlap_is_split),
        cmocka_unit_test(one_sided_bands_are_unwrapped),
        cmocka_unit_test(odd_meshes_are_unwrapped),
        cmocka_unit_test(triangles_without_area_are_taken_along),
        cmocka_unit_test(tiny_charts_join_their_neighbours),
        cmocka_unit_test(pieces_apart_are_charts_apart),
        cmocka_unit_test(soups_are_unwrapped),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

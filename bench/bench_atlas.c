/* The atlas: seconds of each step, medians of five runs on all processors; and the bytes that a
 * coverage takes. Coverage and overlaps of a jittered grid on pages of 2048 x 2048 and 4096 x 4096
 * texels; a bumpy sphere of 200k triangles unwrapped and packed; then dilation, seams and denoising
 * of three planes on its page of about 2048 x 2048 texels. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "atlas/coverage.h"
#include "atlas/denoise.h"
#include "atlas/dilate.h"
#include "atlas/pack.h"
#include "atlas/seams.h"
#include "atlas/unwrap.h"
#include "core/host.h"
#include "core/random.h"

enum { ROUNDS = 5 };

typedef struct grid {
    float *positions, *uv;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
} grid;

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double times[ROUNDS])
{
    qsort(times, ROUNDS, sizeof *times, compare_doubles);
    return times[ROUNDS / 2];
}

/* n x n cells, inner vertices off by up to a fifth of one; false when out of memory. */
static bool make_grid(grid *g, size_t n)
{
    air_rng rng = air_rng_from_keys(1, 1);
    g->vertex_count = (n + 1) * (n + 1);
    g->triangle_count = 2 * n * n;
    g->positions = calloc(3 * g->vertex_count, sizeof(float));
    g->uv = calloc(2 * g->vertex_count, sizeof(float));
    g->indices = calloc(3 * g->triangle_count, sizeof(uint32_t));
    if (g->positions == NULL || g->uv == NULL || g->indices == NULL) {
        return false;
    }
    for (size_t i = 0; i < g->vertex_count; i++) {
        const size_t cell[2] = {i % (n + 1), i / (n + 1)};
        for (size_t k = 0; k < 2; k++) {
            const float move = 0.2f * (2.0f * air_rng_float(&rng) - 1.0f);
            const bool inner = cell[k] > 0 && cell[k] < n;
            g->uv[2 * i + k] = ((float)cell[k] + (inner ? move : 0.0f)) / (float)n;
            g->positions[3 * i + k] = g->uv[2 * i + k];
        }
    }
    for (size_t c = 0; c < n * n; c++) {
        const uint32_t a = (uint32_t)(c / n * (n + 1) + c % n), b = a + (uint32_t)n + 1;
        const uint32_t corners[6] = {a, b, a + 1, a + 1, b, b + 1};
        for (size_t k = 0; k < 6; k++) {
            g->indices[6 * c + k] = corners[k];
        }
    }
    return true;
}

static void free_grid(grid *g)
{
    free(g->positions);
    free(g->uv);
    free(g->indices);
}

static double time_draws(const air_coverage *coverage, size_t size)
{
    air_rng rng = air_rng_from_keys(2, 2);
    double sum = 0.0;
    const double start = seconds();
    for (size_t i = 0; i < 1000000; i++) {
        const size_t at = air_rng_next(&rng) % (size * size);
        const double u[2] = {(double)air_rng_float(&rng), (double)air_rng_float(&rng)};
        air_coverage_point point = {0, {0.0, 0.0, 0.0}};
        (void)air_coverage_draw(coverage, at % size, at / size, u, &point);
        sum += point.weights[0];
    }
    const double taken = seconds() - start;
    return sum > 0.0 ? taken : -1.0; /* the sum is used */
}

static bool measure_coverage(air_context *context, const grid *g, size_t size)
{
    double create[ROUNDS], overlap[ROUNDS], draws = 0.0;
    air_coverage_report report = {0};
    const air_atlas_part part = {.positions = g->positions,
                                 .uv = g->uv,
                                 .indices = g->indices,
                                 .vertex_count = g->vertex_count,
                                 .triangle_count = g->triangle_count,
                                 .offset = {0.0, 0.0},
                                 .size = {(double)size, (double)size}};
    for (int i = 0; i < ROUNDS; i++) {
        air_coverage *coverage;
        air_coverage_overlap found;
        const double start = seconds();
        if (air_coverage_create(context, size, size, &part, 1, &coverage, &report) != AIR_OK) {
            return false;
        }
        const double made = seconds();
        (void)air_coverage_find_overlap(context, coverage, &found);
        overlap[i] = seconds() - made;
        create[i] = made - start;
        draws = i == 0 ? time_draws(coverage, size) : draws;
        air_coverage_destroy(context, coverage);
    }
    const double texels = (double)size * (double)size;
    printf("%zu x %zu, %zu triangles: coverage %.3f s, overlaps %.3f s; %.2f fragments and %.1f "
           "bytes a texel; a point drawn %.0f ns\n",
           size, size, g->triangle_count, median(create), median(overlap),
           (double)report.fragment_count / texels,
           4.0 + 8.0 * (double)report.fragment_count / texels, 1e3 * draws);
    return true;
}

/* ---- a sphere from triangles to texels ---- */

typedef struct sphere {
    grid mesh;   /* as given */
    grid placed; /* with uv over the page */
    air_unwrap *unwrap;
    air_pack *pack;
    air_coverage *coverage;
    size_t width, height, texels;
    uint32_t *charts;
    float *guides[6], *planes[3], *variance[3], *kept[3];
} sphere;

static bool make_sphere(grid *g, size_t around, size_t rows)
{
    const double pi = 3.14159265358979323846;
    g->vertex_count = (around + 1) * (rows + 1);
    g->triangle_count = 2 * around * rows;
    g->positions = calloc(3 * g->vertex_count, sizeof(float));
    g->indices = calloc(3 * g->triangle_count, sizeof(uint32_t));
    if (g->positions == NULL || g->indices == NULL) {
        return false;
    }
    for (size_t v = 0; v < g->vertex_count; v++) {
        const double phi = 2.0 * pi * (double)(v % (around + 1) % around) / (double)around;
        const double theta = pi * (double)(v / (around + 1)) / (double)rows;
        const double r = 1.0 + 0.02 * sin(9.0 * phi) * sin(theta) * sin(7.0 * theta);
        g->positions[3 * v] = (float)(r * sin(theta) * cos(phi));
        g->positions[3 * v + 1] = (float)(r * cos(theta));
        g->positions[3 * v + 2] = (float)(r * sin(theta) * sin(phi));
    }
    for (size_t c = 0; c < around * rows; c++) {
        const uint32_t a = (uint32_t)(c / around * (around + 1) + c % around);
        const uint32_t b = a + (uint32_t)around + 1;
        const uint32_t corners[6] = {a, a + 1, b + 1, a, b + 1, b};
        memcpy(g->indices + 6 * c, corners, sizeof corners);
    }
    return true;
}

static bool pack_charts(air_context *context, sphere *s)
{
    air_pack_params params;
    air_pack_params_default(&params);
    params.power_of_two = false;
    air_pack_item *items = calloc(s->unwrap->chart_count, sizeof *items);
    for (size_t i = 0; items != NULL && i < s->unwrap->chart_count; i++) {
        items[i].size[0] = s->unwrap->charts[i].texels[0];
        items[i].size[1] = s->unwrap->charts[i].texels[1];
    }
    const bool good = items != NULL && air_pack_create(context, items, s->unwrap->chart_count,
                                                       &params, &s->pack) == AIR_OK;
    free(items);
    return good;
}

static bool unwrap_sphere(air_context *context, sphere *s)
{
    double unwraps[ROUNDS], packs[ROUNDS];
    air_unwrap_params params;
    air_unwrap_params_default(&params);
    params.texels_per_metre = 450.0;
    for (int i = 0; i < ROUNDS; i++) {
        air_pack_destroy(context, s->pack);
        air_unwrap_destroy(context, s->unwrap);
        s->pack = NULL;
        double start = seconds();
        if (air_unwrap_create(context, s->mesh.positions, s->mesh.vertex_count, s->mesh.indices,
                              s->mesh.triangle_count, &params, &s->unwrap) != AIR_OK) {
            return false;
        }
        unwraps[i] = seconds() - start;
        start = seconds();
        if (!pack_charts(context, s)) {
            return false;
        }
        packs[i] = seconds() - start;
    }
    s->width = s->pack->pages[0].width;
    s->height = s->pack->pages[0].height;
    s->texels = s->width * s->height;
    const air_unwrap_quality q =
        air_unwrap_measure(s->unwrap, s->mesh.positions, params.texels_per_metre);
    printf("sphere of %zu triangles: unwrapped in %.3f s, packed in %.3f s: %zu charts, mean "
           "stretch %.3f, page %zu x %zu filled %.2f\n",
           s->mesh.triangle_count, median(unwraps), median(packs), s->unwrap->chart_count,
           q.mean_stretch, s->width, s->height, s->pack->utilisation * q.utilisation);
    return true;
}

static air_atlas_part placed_part(const sphere *s)
{
    return (air_atlas_part){.positions = s->placed.positions,
                            .uv = s->placed.uv,
                            .indices = s->placed.indices,
                            .vertex_count = s->placed.vertex_count,
                            .triangle_count = s->placed.triangle_count,
                            .size = {(double)s->width, (double)s->height},
                            .charts = s->unwrap->triangle_charts};
}

static bool place_sphere(air_context *context, sphere *s)
{
    const air_unwrap *u = s->unwrap;
    grid *g = &s->placed;
    g->vertex_count = u->vertex_count;
    g->triangle_count = u->triangle_count;
    g->positions = calloc(3 * g->vertex_count, sizeof(float));
    g->uv = calloc(2 * g->vertex_count, sizeof(float));
    g->indices = calloc(3 * g->triangle_count, sizeof(uint32_t));
    if (g->positions == NULL || g->uv == NULL || g->indices == NULL) {
        return false;
    }
    for (size_t i = 0; i < 3 * g->triangle_count; i++) {
        const size_t v = u->indices[i];
        const double place[2] = {(double)u->places[2 * v], (double)u->places[2 * v + 1]};
        double at[2];
        air_pack_point(s->pack, u->triangle_charts[i / 3], place, at);
        g->indices[i] = (uint32_t)v;
        g->uv[2 * v] = (float)(at[0] / (double)s->width);
        g->uv[2 * v + 1] = (float)(at[1] / (double)s->height);
        memcpy(g->positions + 3 * v, s->mesh.positions + 3 * (size_t)u->vertices[v],
               3 * sizeof(float));
    }
    const air_atlas_part part = placed_part(s);
    return air_coverage_create(context, s->width, s->height, &part, 1, &s->coverage, NULL) ==
           AIR_OK;
}

/* Positions and normals (of a sphere) at drawn points; light with a shadow and 30 % of noise. */
static void fill_texel(sphere *s, size_t i, air_rng *rng)
{
    const double u[2] = {0.5, 0.5};
    air_coverage_point at;
    float p[3] = {0.0f, 0.0f, 0.0f};
    if (!air_coverage_draw(s->coverage, i % s->width, i / s->width, u, &at)) {
        return;
    }
    for (size_t k = 0; k < 9; k++) {
        const size_t v = s->placed.indices[3 * (size_t)at.triangle + k / 3];
        p[k % 3] += (float)at.weights[k / 3] * s->placed.positions[3 * v + k % 3];
    }
    const float light = p[0] > 0.2f * p[1] ? 1.0f : 0.1f;
    const float noise = 0.5f + air_rng_float(rng); /* 29 % */
    for (size_t k = 0; k < 3; k++) {
        s->guides[k][i] = s->guides[3 + k][i] = p[k];
        s->kept[k][i] = light * noise;
        s->variance[k][i] = light * light / 12.0f;
    }
}

static bool fill_planes(air_context *context, sphere *s)
{
    air_rng rng = air_rng_from_keys(5, 5);
    s->charts = calloc(s->texels, sizeof *s->charts);
    bool good = s->charts != NULL;
    for (size_t k = 0; k < 6; k++) {
        s->guides[k] = calloc(s->texels, sizeof(float));
        good = good && s->guides[k] != NULL;
    }
    for (size_t k = 0; k < 3; k++) {
        s->planes[k] = calloc(s->texels, sizeof(float));
        s->kept[k] = calloc(s->texels, sizeof(float));
        s->variance[k] = calloc(s->texels, sizeof(float));
        good = good && s->planes[k] != NULL && s->kept[k] != NULL && s->variance[k] != NULL;
    }
    if (good) {
        air_coverage_planes(context, s->coverage, s->charts, NULL);
        for (size_t i = 0; i < s->texels; i++) {
            fill_texel(s, i, &rng);
        }
    }
    return good;
}

static void restore(sphere *s)
{
    for (size_t k = 0; k < 3; k++) {
        memcpy(s->planes[k], s->kept[k], s->texels * sizeof(float));
    }
}

static bool measure_denoise(air_context *context, sphere *s)
{
    double times[ROUNDS];
    const air_atlas_guides guides = {s->width,
                                     s->height,
                                     s->charts,
                                     {s->guides[0], s->guides[1], s->guides[2]},
                                     {s->guides[3], s->guides[4], s->guides[5]},
                                     NULL};
    const air_atlas_layer layer = {
        s->planes, (const float *const[3]){s->variance[0], s->variance[1], s->variance[2]}, 3};
    air_atlas_denoise_params params;
    air_atlas_denoise_params_default(&params);
    for (int i = 0; i < ROUNDS; i++) {
        restore(s);
        const double start = seconds();
        if (air_atlas_denoise(context, &guides, &params, &layer) != AIR_OK) {
            return false;
        }
        times[i] = seconds() - start;
    }
    printf("denoising 3 planes, radius %u: %.2f s\n", params.radius, median(times));
    return true;
}

static bool measure_seams(air_context *context, sphere *s)
{
    double dilations[ROUNDS], finds[ROUNDS], solves[ROUNDS];
    const air_seams_page page = {s->width, s->height, s->charts, s->planes};
    const air_atlas_part part = placed_part(s);
    air_seams_report report = {0};
    air_seams_params params;
    air_seams_find_params finding;
    air_dilate_params dilating;
    size_t count = 0;
    bool good = true;
    air_seams_params_default(&params);
    air_seams_find_params_default(&finding);
    air_dilate_params_default(&dilating);
    dilating.everything = true;
    for (int i = 0; i < ROUNDS && good; i++) {
        air_seams seams;
        restore(s);
        const double start = seconds();
        good =
            air_dilate(context, s->width, s->height, s->charts, &dilating, s->planes, 3) == AIR_OK;
        const double dilated = seconds();
        good = good && air_seams_find(context, &part, 1, NULL, NULL, &finding, &seams) == AIR_OK;
        const double found = seconds();
        good = good && air_seams_solve(context, &seams, &page, 1, 3, &params, &report) == AIR_OK;
        solves[i] = seconds() - found;
        finds[i] = found - dilated;
        dilations[i] = dilated - start;
        count = good ? seams.count : 0;
        air_seams_finish(context, &seams);
    }
    printf("dilating 3 planes everywhere: %.3f s\n%zu seams found in %.3f s; %zu samples, %zu "
           "texels, 3 planes, %u iterations: %.3f s\n",
           median(dilations), count, median(finds), report.sample_count, report.texel_count,
           report.iterations, median(solves));
    return good;
}

static bool measure_sphere(air_context *context)
{
    sphere s = {.unwrap = NULL};
    const bool good = make_sphere(&s.mesh, 448, 224) && unwrap_sphere(context, &s) &&
                      place_sphere(context, &s) && fill_planes(context, &s) &&
                      measure_seams(context, &s) && measure_denoise(context, &s);
    for (size_t k = 0; k < 6; k++) {
        free(s.guides[k]);
    }
    for (size_t k = 0; k < 3; k++) {
        free(s.planes[k]);
        free(s.kept[k]);
        free(s.variance[k]);
    }
    free(s.charts);
    air_coverage_destroy(context, s.coverage);
    air_pack_destroy(context, s.pack);
    air_unwrap_destroy(context, s.unwrap);
    free_grid(&s.placed);
    free_grid(&s.mesh);
    return good;
}

int main(void)
{
    air_context *context = NULL;
    grid fine = {0}, coarse = {0};
    bool good = air_context_create(NULL, &context) == AIR_OK && make_grid(&fine, 316) &&
                make_grid(&coarse, 30);
    good = good && measure_coverage(context, &fine, 2048) &&
           measure_coverage(context, &fine, 4096) && measure_coverage(context, &coarse, 4096) &&
           measure_sphere(context);
    free_grid(&coarse);
    free_grid(&fine);
    air_context_destroy(context);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

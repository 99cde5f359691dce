/* The atlas: seconds of each step. Coverage and overlaps of a jittered grid of 200k triangles on a
 * page of 2048 x 2048 texels and of 4096 x 4096; points drawn.
 *
 * Printed are the medians of five runs on all processors; and the bytes that a coverage takes. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "atlas/coverage.h"
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

int main(void)
{
    air_context *context = NULL;
    grid fine = {0}, coarse = {0};
    bool good = air_context_create(NULL, &context) == AIR_OK && make_grid(&fine, 316) &&
                make_grid(&coarse, 30);
    good = good && measure_coverage(context, &fine, 2048) &&
           measure_coverage(context, &fine, 4096) && measure_coverage(context, &coarse, 4096);
    free_grid(&coarse);
    free_grid(&fine);
    air_context_destroy(context);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* dilate.c: the nearest covered texel in the row, then over all rows by the lower envelope of
 * parabolas: exact, and linear [Meijster2000]. First in the gutters, each for itself, then on the
 * whole page. */
#include "atlas/dilate.h"

#include <math.h>

enum { COLUMNS = 16 }; /* that are worked on together: a line of the cache */

/* In the place of a source. */
static const uint32_t source_none = UINT32_MAX, source_never = UINT32_MAX - 1;

typedef struct dilate_work {
    size_t width, height;
    const uint32_t *charts;
    const air_dilate_params *params;
    double reach_squared;
    float *const *planes;
    size_t plane_count;
    uint32_t *sources;  /* of each texel: the texel whose values it takes */
    int32_t *nearest;   /* of the whole page */
    int32_t *envelopes; /* per worker: two numbers per row */
    int32_t *scratch;   /* per worker: the largest gutter */
    size_t scratch_size;
} dilate_work;

/* A rectangle of the page, and whose values count there (AIR_NO_CHART: all). */
typedef struct region {
    size_t x, y, width, height;
    uint32_t chart;
    int32_t *nearest; /* width * height: column of the nearest source in the row, or -1 */
} region;

void air_dilate_params_default(air_dilate_params *params)
{
    *params =
        (air_dilate_params){.radius = 4.0, .everything = false, .gutters = NULL, .gutter_count = 0};
}

static bool is_source(const dilate_work *work, const region *r, size_t texel)
{
    const uint32_t chart = work->charts[texel];
    return chart != AIR_NO_CHART && (r->chart == AIR_NO_CHART || r->chart == chart);
}

/* Equally near: the left one. */
static void scan_row(const dilate_work *work, const region *r, size_t row)
{
    const size_t first = (r->y + row) * work->width + r->x;
    int32_t *nearest = r->nearest + row * r->width, last = -1;
    for (size_t x = 0; x < r->width; x++) {
        last = is_source(work, r, first + x) ? (int32_t)x : last;
        nearest[x] = last;
    }
    last = -1;
    for (size_t x = r->width; x-- > 0;) {
        last = is_source(work, r, first + x) ? (int32_t)x : last;
        const bool nearer = nearest[x] < 0 || last - (int32_t)x < (int32_t)x - nearest[x];
        nearest[x] = last >= 0 && nearer ? last : nearest[x];
    }
}

/* ---- columns ---- */

static int64_t squared_distance(const region *r, size_t x, int32_t from_row, int64_t row)
{
    const int64_t across = (int64_t)r->nearest[(size_t)from_row * r->width + x] - (int64_t)x;
    const int64_t down = row - from_row;
    return across * across + down * down;
}

/* The last row at which row `upper` is not farther than row `lower` below it. */
static int64_t last_row_of(const region *r, size_t x, int32_t upper, int32_t lower)
{
    const int64_t numerator = squared_distance(r, x, lower, 0) - squared_distance(r, x, upper, 0);
    const int64_t denominator = 2 * ((int64_t)lower - upper);
    const int64_t quotient = numerator / denominator;
    return quotient - (numerator % denominator < 0);
}

/* Rows whose nearest texels are nearest to some row, from above, and where each begins; how many.
 */
static size_t find_envelope(const region *r, size_t x, int32_t *rows, int32_t *starts)
{
    size_t count = 0;
    for (size_t y = 0; y < r->height; y++) {
        const int32_t here = (int32_t)y;
        if (r->nearest[y * r->width + x] < 0) {
            continue;
        }
        while (count > 0 && squared_distance(r, x, rows[count - 1], starts[count - 1]) >
                                squared_distance(r, x, here, starts[count - 1])) {
            count--;
        }
        const int64_t start = count > 0 ? last_row_of(r, x, rows[count - 1], here) + 1 : 0;
        if (start < (int64_t)r->height) {
            rows[count] = here;
            starts[count++] = (int32_t)start;
        }
    }
    return count;
}

static void scan_column(const dilate_work *work, const region *r, size_t x, size_t worker)
{
    int32_t *rows = work->envelopes + 2 * work->height * worker;
    int32_t *starts = rows + work->height;
    size_t at = find_envelope(r, x, rows, starts);
    for (size_t y = r->height; y-- > 0 && at > 0;) {
        const size_t texel = (r->y + y) * work->width + r->x + x;
        while (starts[at - 1] > (int32_t)y) {
            at--;
        }
        const int32_t from = rows[at - 1];
        if (work->sources[texel] == source_none &&
            (double)squared_distance(r, x, from, (int64_t)y) <= work->reach_squared) {
            const size_t column = (size_t)r->nearest[(size_t)from * r->width + x];
            work->sources[texel] = (uint32_t)((r->y + (size_t)from) * work->width + r->x + column);
        }
    }
}

/* ---- steps ---- */

static void begin_row(void *user, size_t row, size_t worker)
{
    const dilate_work *work = user;
    (void)worker;
    for (size_t i = row * work->width; i < (row + 1) * work->width; i++) {
        work->sources[i] = work->charts[i] != AIR_NO_CHART ? (uint32_t)i : source_none;
    }
}

/* What the gutter's chart does not reach is not left to others, unless it has no texel at all. */
static void fill_gutter(void *user, size_t index, size_t worker)
{
    const dilate_work *work = user;
    const air_dilate_gutter *g = &work->params->gutters[index];
    const region r = {g->x,      g->y,     g->width,
                      g->height, g->chart, work->scratch + worker * work->scratch_size};
    bool any = false;
    for (size_t y = 0; y < r.height; y++) {
        scan_row(work, &r, y);
        any = any || (r.width > 0 && r.nearest[y * r.width] >= 0);
    }
    for (size_t x = 0; x < r.width && any; x++) {
        scan_column(work, &r, x, worker);
    }
    for (size_t i = 0; i < r.width * r.height && any; i++) {
        const size_t texel = (r.y + i / r.width) * work->width + r.x + i % r.width;
        work->sources[texel] =
            work->sources[texel] == source_none ? source_never : work->sources[texel];
    }
}

static region whole_page(const dilate_work *work)
{
    return (region){0, 0, work->width, work->height, AIR_NO_CHART, work->nearest};
}

static void fill_row(void *user, size_t row, size_t worker)
{
    const region r = whole_page(user);
    (void)worker;
    scan_row(user, &r, row);
}

static void fill_columns(void *user, size_t index, size_t worker)
{
    const dilate_work *work = user;
    const region r = whole_page(work);
    for (size_t x = index * COLUMNS; x < (index + 1) * COLUMNS && x < work->width; x++) {
        scan_column(work, &r, x, worker);
    }
}

static void copy_row(void *user, size_t row, size_t worker)
{
    const dilate_work *work = user;
    (void)worker;
    for (size_t k = 0; k < work->plane_count; k++) {
        float *plane = work->planes[k];
        for (size_t i = row * work->width; i < (row + 1) * work->width; i++) {
            const uint32_t from = work->sources[i];
            if (from != i && from != source_none && from != source_never) {
                plane[i] = plane[from];
            }
        }
    }
}

/* ---- all of it ---- */

static air_status check(air_context *context, size_t width, size_t height,
                        const air_dilate_params *params)
{
    if (width == 0 || height == 0 || width > 65536 || height > 65536 ||
        width * height >= source_never || !(params->radius >= 0.0)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "dilate: %zu x %zu texels, radius %g: expected 1 to 65536 texels a side, "
                        "fewer than 2^32 - 2 in all, and a radius of at least 0",
                        width, height, params->radius);
    }
    for (size_t i = 0; i < params->gutter_count && params->gutters != NULL; i++) {
        const air_dilate_gutter *g = &params->gutters[i];
        if ((uint64_t)g->x + g->width > width || (uint64_t)g->y + g->height > height) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "dilate: gutter %zu of %u x %u texels at (%u, %u) leaves the page of "
                            "%zu x %zu",
                            i, g->width, g->height, g->x, g->y, width, height);
        }
    }
    return AIR_OK;
}

static void run(air_context *context, dilate_work *work)
{
    air_parallel_for(context, work->height, begin_row, work);
    if (work->params->gutters != NULL) {
        air_parallel_for(context, work->params->gutter_count, fill_gutter, work);
    }
    air_parallel_for(context, work->height, fill_row, work);
    air_parallel_for(context, (work->width + COLUMNS - 1) / COLUMNS, fill_columns, work);
    air_parallel_for(context, work->height, copy_row, work);
}

air_status air_dilate(air_context *context, size_t width, size_t height, const uint32_t *charts,
                      const air_dilate_params *params, float *const *planes, size_t plane_count)
{
    const size_t workers = air_context_thread_count(context);
    dilate_work work = {.width = width,
                        .height = height,
                        .charts = charts,
                        .params = params,
                        .planes = planes,
                        .plane_count = plane_count};
    air_status status = check(context, width, height, params);
    if (status != AIR_OK) {
        return status;
    }
    for (size_t i = 0; i < params->gutter_count && params->gutters != NULL; i++) {
        const size_t size = (size_t)params->gutters[i].width * params->gutters[i].height;
        work.scratch_size = size > work.scratch_size ? size : work.scratch_size;
    }
    work.reach_squared = params->everything ? INFINITY : params->radius * params->radius;
    work.sources = air_allocate(context, width * height, sizeof *work.sources);
    work.nearest = air_allocate(context, width * height, sizeof *work.nearest);
    work.envelopes = air_allocate(context, workers * height, 2 * sizeof *work.envelopes);
    work.scratch = air_allocate(context, workers * work.scratch_size, sizeof *work.scratch);
    if (work.sources != NULL && work.nearest != NULL && work.envelopes != NULL &&
        work.scratch != NULL) {
        run(context, &work);
    } else {
        status = air_fail_memory(context, "dilate");
    }
    air_free(context, work.scratch);
    air_free(context, work.envelopes);
    air_free(context, work.nearest);
    air_free(context, work.sources);
    return status;
}

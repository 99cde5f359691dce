/* coverage.c: triangles are dealt out to bands of rows, and each band sorts its own fragments by
 * texel: bands share nothing, so any number of threads gives the same. */
#include "atlas/coverage.h"

#include <math.h>
#include <stdatomic.h>

#include "atlas/islands.h"
#include "atlas/triangle.h"
#include "core/vec.h"

/* ---- what a triangle is worth ---- */

/* Rounding of uv that is still inside. */
static const float uv_slack = 0x1p-22f;

static bool is_flat_in_space(const air_atlas_part *part, size_t t)
{
    double normal[3];
    return part->positions != NULL &&
           !air_triangle_normal(part->positions, part->indices + 3 * t, normal);
}

static bool is_flat_in_uv(const air_texel_triangle *triangle)
{
    double longest = 0.0;
    for (int i = 0; i < 3; i++) {
        const double *a = triangle->point[i], *b = triangle->point[(i + 1) % 3];
        const double x = b[0] - a[0], y = b[1] - a[1];
        longest = double_max(longest, x * x + y * y);
    }
    const double doubled =
        air_doubled_area(triangle->point[0], triangle->point[1], triangle->point[2]);
    return air_triangle_is_flat(doubled, longest);
}

/* A corner with uv outside [0, 1], or NULL. NaN is outside. */
static const float *corner_outside(const air_atlas_part *part, size_t t)
{
    for (size_t i = 0; i < 3; i++) {
        const float *uv = part->uv + 2 * (size_t)part->indices[3 * t + i];
        for (int k = 0; k < 2; k++) {
            if (!(uv[k] >= -uv_slack) || !(uv[k] <= 1.0f + uv_slack)) {
                return uv;
            }
        }
    }
    return NULL;
}

/* ---- where a triangle is ---- */

/* Texels [low, high) along an axis. */
typedef struct texel_range {
    ptrdiff_t low, high;
} texel_range;

/* The texels that points from low to high touch with a positive area, inside `within`. */
static texel_range clamp_range(texel_range within, double low, double high)
{
    const double least = (double)within.low, most = (double)within.high;
    const double from = double_min(double_max(floor(low), least), most);
    const double to = double_min(double_max(ceil(high), from), most);
    return (texel_range){(ptrdiff_t)from, (ptrdiff_t)to};
}

static texel_range part_range(const air_atlas_part *part, int axis, size_t page)
{
    const texel_range whole = {0, (ptrdiff_t)page};
    return clamp_range(whole, part->offset[axis], part->offset[axis] + part->size[axis]);
}

/* points: x, y, x, y and so on */
static texel_range polygon_range(const double *points, int count, int axis, double origin,
                                 texel_range within)
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < count; i++) {
        low = double_min(low, points[2 * i + axis]);
        high = double_max(high, points[2 * i + axis]);
    }
    return count > 0 ? clamp_range(within, low + origin, high + origin) : (texel_range){0, 0};
}

/* ---- dealing triangles out to bands ---- */

typedef struct build {
    air_context *context;
    air_coverage *self;
    uint32_t *band_first; /* of each band in band_triangles, and one more */
    uint32_t *band_triangles;
    struct band_scratch *scratch; /* per worker */
    size_t worker_count;
    atomic_size_t fragment_count, covered_texels;
    atomic_bool out_of_memory;
    air_coverage_report report;
} build;

/* The bands of triangle t of a part; none where it is left out. */
static texel_range bands_of(const air_coverage *self, const air_atlas_part *part, size_t t)
{
    const air_texel_triangle triangle = air_texel_triangle_of(part, t);
    if (is_flat_in_uv(&triangle) || is_flat_in_space(part, t)) {
        return (texel_range){-1, -1};
    }
    const texel_range rows = polygon_range(triangle.point[0], 3, 1, triangle.origin[1],
                                           part_range(part, 1, self->height));
    if (rows.low >= rows.high) {
        return (texel_range){0, 0};
    }
    return (texel_range){rows.low / AIR_COVERAGE_BAND, (rows.high - 1) / AIR_COVERAGE_BAND + 1};
}

static void judge(build *b, const air_atlas_part *part, size_t t, uint32_t number,
                  texel_range bands)
{
    air_coverage_report *report = &b->report;
    const float *outside = corner_outside(part, t);
    if (bands.low < 0 && report->degenerate_count++ == 0) {
        report->first_degenerate = number;
    }
    if (outside != NULL && report->outside_count++ == 0) {
        report->first_outside = number;
        report->outside_uv[0] = outside[0];
        report->outside_uv[1] = outside[1];
    }
}

/* Counts (triangles NULL) or lists the triangles of each band. */
static void deal(build *b, uint64_t *next, uint32_t *triangles)
{
    const air_coverage *self = b->self;
    for (size_t p = 0; p < self->part_count; p++) {
        const air_atlas_part *part = &self->parts[p];
        for (size_t t = 0; t < part->triangle_count; t++) {
            const uint32_t number = self->first_triangle[p] + (uint32_t)t;
            const texel_range bands = bands_of(self, part, t);
            if (triangles == NULL) {
                judge(b, part, t, number, bands);
            }
            for (ptrdiff_t i = bands.low; i < bands.high; i++) {
                if (triangles != NULL) {
                    triangles[next[i]] = number;
                }
                next[i]++;
            }
        }
    }
}

static air_status deal_triangles(build *b)
{
    const size_t count = b->self->band_count;
    uint64_t *next = air_allocate(b->context, count, sizeof *next), sum = 0;
    b->band_first = air_allocate(b->context, count + 1, sizeof *b->band_first);
    if (next == NULL || b->band_first == NULL) {
        air_free(b->context, next);
        return AIR_ERROR_MEMORY;
    }
    deal(b, next, NULL);
    for (size_t i = 0; i < count; i++) {
        const uint64_t here = next[i];
        b->band_first[i] = (uint32_t)sum;
        next[i] = sum;
        sum += here;
    }
    b->band_first[count] = (uint32_t)sum;
    b->band_triangles =
        sum <= UINT32_MAX ? air_allocate(b->context, (size_t)sum, sizeof *b->band_triangles) : NULL;
    if (b->band_triangles != NULL) {
        deal(b, next, b->band_triangles);
    }
    air_free(b->context, next);
    return b->band_triangles != NULL ? AIR_OK : AIR_ERROR_MEMORY;
}

/* ---- one band ---- */

typedef struct band_record {
    uint32_t texel; /* in the band */
    air_fragment fragment;
} band_record;

typedef struct band_scratch {
    band_record *records;
    size_t count, capacity;
} band_scratch;

static bool reserve_row(build *b, band_scratch *scratch)
{
    const size_t needed = scratch->count + b->self->width;
    if (needed <= scratch->capacity) {
        return true;
    }
    const size_t capacity = 2 * needed;
    band_record *grown =
        air_reallocate(b->context, scratch->records, capacity, sizeof *scratch->records);
    if (grown == NULL) {
        return false;
    }
    scratch->records = grown;
    scratch->capacity = capacity;
    return true;
}

/* The triangle's fragment in texel (x, y) from its origin; area 0: none. */
static air_fragment fragment_in(const air_texel_triangle *triangle, const air_piece *row,
                                uint32_t number, double x, double y)
{
    air_piece piece;
    if (air_texel_triangle_has_texel(triangle, x, y)) {
        return (air_fragment){number | AIR_FRAGMENT_CENTRE, 1.0f};
    }
    air_piece_column(row, x, &piece);
    const bool centre = air_texel_triangle_has(triangle, (double[2]){x + 0.5, y + 0.5});
    return (air_fragment){number | (centre ? AIR_FRAGMENT_CENTRE : 0u),
                          (float)air_piece_area(&piece)};
}

static void record_row(band_scratch *scratch, const air_texel_triangle *triangle, uint32_t number,
                       ptrdiff_t y, texel_range columns, uint32_t first_texel)
{
    air_piece row;
    const double at_y = (double)y - triangle->origin[1];
    air_piece_row(triangle, at_y, &row);
    const texel_range range =
        polygon_range(row.point[0], row.count, 0, triangle->origin[0], columns);
    for (ptrdiff_t x = range.low; x < range.high; x++) {
        const air_fragment fragment =
            fragment_in(triangle, &row, number, (double)x - triangle->origin[0], at_y);
        if (fragment.area > 0.0f) {
            scratch->records[scratch->count++] = (band_record){first_texel + (uint32_t)x, fragment};
        }
    }
}

static bool record_triangle(build *b, band_scratch *scratch, uint32_t number, ptrdiff_t top,
                            ptrdiff_t bottom)
{
    const air_coverage *self = b->self;
    size_t local;
    const air_atlas_part *part = &self->parts[air_coverage_part(self, number, &local)];
    const air_texel_triangle triangle = air_texel_triangle_of(part, local);
    const texel_range columns = part_range(part, 0, self->width);
    texel_range rows = part_range(part, 1, self->height);
    rows.low = rows.low > top ? rows.low : top;
    rows.high = rows.high < bottom ? rows.high : bottom;
    rows = polygon_range(triangle.point[0], 3, 1, triangle.origin[1], rows);
    for (ptrdiff_t y = rows.low; y < rows.high; y++) {
        if (!reserve_row(b, scratch)) {
            return false;
        }
        record_row(scratch, &triangle, number, y, columns,
                   (uint32_t)((size_t)(y - top) * self->width));
    }
    return true;
}

/* A counting sort by texel; triangles stay in order. */
static bool keep_band(build *b, const band_scratch *scratch, size_t texels, air_coverage_band *band)
{
    if (scratch->count == 0) {
        return true;
    }
    band->first = air_allocate(b->context, texels + 1, sizeof *band->first);
    band->fragments = air_allocate(b->context, scratch->count, sizeof *band->fragments);
    if (band->first == NULL || band->fragments == NULL) {
        return false;
    }
    size_t covered = 0;
    for (size_t i = 0; i < scratch->count; i++) {
        covered += band->first[scratch->records[i].texel]++ == 0;
    }
    uint32_t sum = 0;
    for (size_t i = 0; i <= texels; i++) {
        sum += band->first[i];
        band->first[i] = sum;
    }
    for (size_t i = scratch->count; i-- > 0;) {
        band->fragments[--band->first[scratch->records[i].texel]] = scratch->records[i].fragment;
    }
    atomic_fetch_add(&b->fragment_count, scratch->count);
    atomic_fetch_add(&b->covered_texels, covered);
    return true;
}

static void build_band(void *user, size_t index, size_t worker)
{
    build *const b = user;
    air_coverage *const self = b->self;
    band_scratch *const scratch = &b->scratch[worker];
    const size_t top = index * AIR_COVERAGE_BAND;
    const size_t rest = self->height - top;
    const size_t rows = rest < AIR_COVERAGE_BAND ? rest : AIR_COVERAGE_BAND;
    scratch->count = 0;
    bool good = !atomic_load(&b->out_of_memory);
    for (uint32_t i = b->band_first[index]; i < b->band_first[index + 1] && good; i++) {
        good = record_triangle(b, scratch, b->band_triangles[i], (ptrdiff_t)top,
                               (ptrdiff_t)(top + rows));
    }
    if (!good || scratch->count > UINT32_MAX ||
        !keep_band(b, scratch, rows * self->width, &self->bands[index])) {
        atomic_store(&b->out_of_memory, true);
    }
}

static air_status build_bands(build *b)
{
    b->worker_count = air_context_thread_count(b->context);
    b->scratch = air_allocate(b->context, b->worker_count, sizeof *b->scratch);
    if (b->scratch == NULL) {
        return AIR_ERROR_MEMORY;
    }
    air_parallel_for(b->context, b->self->band_count, build_band, b);
    b->report.fragment_count = atomic_load(&b->fragment_count);
    b->report.covered_texels = atomic_load(&b->covered_texels);
    return atomic_load(&b->out_of_memory) ? AIR_ERROR_MEMORY : AIR_OK;
}

/* ---- lifecycle ---- */

static air_status check_part(air_context *context, const air_atlas_part *part, size_t number)
{
    for (int k = 0; k < 2; k++) {
        if (!(part->size[k] > 0.0) || !isfinite(part->size[k]) || !isfinite(part->offset[k])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "coverage: part %zu: size %g, offset %g: expected a positive size",
                            number, part->size[k], part->offset[k]);
        }
    }
    for (size_t i = 0; i < 3 * part->triangle_count; i++) {
        if (part->indices[i] >= part->vertex_count) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "coverage: part %zu: triangle %zu: expected an index below %zu, not %u",
                            number, i / 3, part->vertex_count, part->indices[i]);
        }
    }
    return AIR_OK;
}

static air_status check(air_context *context, size_t width, size_t height,
                        const air_atlas_part *parts, size_t part_count)
{
    size_t triangles = 0;
    if (width == 0 || height == 0 || width > 65536 || height > 65536 || part_count == 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "coverage: %zu x %zu texels, %zu parts: expected 1 to 65536 texels a side "
                        "and at least one part",
                        width, height, part_count);
    }
    for (size_t i = 0; i < part_count; i++) {
        const air_status status = check_part(context, &parts[i], i);
        if (status != AIR_OK) {
            return status;
        }
        triangles += parts[i].triangle_count;
    }
    if (triangles >= AIR_FRAGMENT_CENTRE) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "coverage: %zu triangles: expected fewer than 2^31", triangles);
    }
    return AIR_OK;
}

/* The charts of all parts, numbered through. */
static air_status number_charts(air_context *context, air_coverage *self)
{
    for (size_t p = 0; p < self->part_count; p++) {
        const air_atlas_part *part = &self->parts[p];
        uint32_t *charts = self->charts + self->first_triangle[p];
        size_t count = 0;
        if (part->charts == NULL) {
            const air_status status = air_islands_find(context, part, charts, &count);
            if (status != AIR_OK) {
                return status;
            }
        }
        for (size_t t = 0; t < part->triangle_count; t++) {
            const uint32_t chart = part->charts != NULL ? part->charts[t] : charts[t];
            count = chart + 1u > count ? chart + 1u : count;
            charts[t] = chart + (uint32_t)self->chart_count;
        }
        self->chart_count += count;
    }
    return AIR_OK;
}

static air_status set_up(air_context *context, air_coverage *self, const air_atlas_part *parts)
{
    size_t sum = 0;
    self->parts = air_allocate(context, self->part_count, sizeof *self->parts);
    self->first_triangle =
        air_allocate(context, self->part_count + 1, sizeof *self->first_triangle);
    self->band_count = (self->height + AIR_COVERAGE_BAND - 1) / AIR_COVERAGE_BAND;
    self->bands = air_allocate(context, self->band_count, sizeof *self->bands);
    if (self->parts == NULL || self->first_triangle == NULL || self->bands == NULL) {
        return AIR_ERROR_MEMORY;
    }
    for (size_t p = 0; p < self->part_count; p++) {
        self->parts[p] = parts[p];
        self->first_triangle[p] = (uint32_t)sum;
        sum += parts[p].triangle_count;
    }
    self->first_triangle[self->part_count] = (uint32_t)sum;
    self->charts = air_allocate(context, sum, sizeof *self->charts);
    return self->charts != NULL ? number_charts(context, self) : AIR_ERROR_MEMORY;
}

static void finish_build(build *b)
{
    for (size_t i = 0; i < b->worker_count && b->scratch != NULL; i++) {
        air_free(b->context, b->scratch[i].records);
    }
    air_free(b->context, b->scratch);
    air_free(b->context, b->band_triangles);
    air_free(b->context, b->band_first);
}

air_status air_coverage_create(air_context *context, size_t width, size_t height,
                               const air_atlas_part *parts, size_t part_count,
                               air_coverage **out_coverage, air_coverage_report *out_report)
{
    *out_coverage = NULL;
    air_status status = check(context, width, height, parts, part_count);
    if (status != AIR_OK) {
        return status;
    }
    air_coverage *self = air_allocate(context, 1, sizeof *self);
    build b = {.context = context, .self = self};
    if (self == NULL) {
        return air_fail_memory(context, "coverage");
    }
    self->width = width;
    self->height = height;
    self->part_count = part_count;
    status = set_up(context, self, parts);
    status = status == AIR_OK ? deal_triangles(&b) : status;
    status = status == AIR_OK ? build_bands(&b) : status;
    finish_build(&b);
    if (status != AIR_OK) {
        air_coverage_destroy(context, self);
        return status == AIR_ERROR_MEMORY ? air_fail_memory(context, "coverage") : status;
    }
    *out_coverage = self;
    if (out_report != NULL) {
        *out_report = b.report;
    }
    return AIR_OK;
}

void air_coverage_destroy(air_context *context, air_coverage *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; i < self->band_count && self->bands != NULL; i++) {
        air_free(context, self->bands[i].fragments);
        air_free(context, self->bands[i].first);
    }
    air_free(context, self->bands);
    air_free(context, self->charts);
    air_free(context, self->first_triangle);
    air_free(context, self->parts);
    air_free(context, self);
}

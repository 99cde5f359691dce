/* coverage_overlap.c: pairs of fragments of a texel, found by a sweep along x, told apart first by
 * the triangles' sides and then by cutting. A texel is done with its first overlap, so stacks of
 * equal triangles cost no more than others. */
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "atlas/coverage.h"
#include "atlas/separation.h"
#include "core/vec.h"

/* A triangle relative to the texel, and the box of its piece in there. */
typedef struct sweep_entry {
    air_flat_triangle flat;
    double low[2], high[2];
    uint32_t triangle;
} sweep_entry;

typedef struct sweep_scratch {
    sweep_entry *entries;
    size_t capacity;
} sweep_scratch;

/* What a band finds. */
typedef struct band_overlap {
    size_t texel_count;
    air_coverage_overlap first;
} band_overlap;

typedef struct overlap_work {
    air_context *context;
    const air_coverage *self;
    band_overlap *bands;
    sweep_scratch *scratch;
    atomic_bool out_of_memory;
} overlap_work;

static double tolerance_of(const air_atlas_part *part)
{
    return 2.0 * sqrt(2.0) * 0x1p-24 * double_max(part->size[0], part->size[1]);
}

static sweep_entry entry_of(const air_coverage *self, uint32_t number, size_t x, size_t y,
                            double *tolerance)
{
    const double texel[2] = {(double)x, (double)y};
    size_t local;
    const air_atlas_part *part = &self->parts[air_coverage_part(self, number, &local)];
    const air_texel_triangle triangle = air_texel_triangle_of(part, local);
    sweep_entry e = {.triangle = number};
    for (int k = 0; k < 2; k++) {
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < 3; i++) {
            e.flat.point[i][k] = triangle.point[i][k] + (triangle.origin[k] - texel[k]);
            low = double_min(low, e.flat.point[i][k]);
            high = double_max(high, e.flat.point[i][k]);
        }
        e.low[k] = double_max(low, 0.0);
        e.high[k] = double_min(high, 1.0);
    }
    air_flat_triangle_set_ways(&e.flat);
    *tolerance = double_max(*tolerance, tolerance_of(part));
    return e;
}

/* Does self's piece in the texel reach into the other triangle, deeper than the tolerance and as
 * wide? */
static bool reaches_into(const sweep_entry *self, const sweep_entry *other, double tolerance)
{
    air_piece a = {.count = 3}, b;
    for (int i = 0; i < 3; i++) {
        a.point[i][0] = self->flat.point[i][0];
        a.point[i][1] = self->flat.point[i][1];
    }
    air_piece_cut(&a, 0, 0.0, false, &b);
    air_piece_cut(&b, 0, 1.0, true, &a);
    air_piece_cut(&a, 1, 0.0, false, &b);
    air_piece_cut(&b, 1, 1.0, true, &a);
    for (int i = 0; i < 3; i++) {
        air_piece_cut_line(&a, other->flat.point[i], other->flat.way[i], tolerance, &b);
        a = b;
    }
    return air_piece_area(&a) > tolerance * tolerance;
}

static bool overlap(const sweep_entry *a, const sweep_entry *b, double tolerance)
{
    if (b->low[1] >= a->high[1] - tolerance || a->low[1] >= b->high[1] - tolerance ||
        !air_flat_triangles_overlap(&a->flat, &b->flat, tolerance)) {
        return false;
    }
    return reaches_into(a, b, tolerance) || reaches_into(b, a, tolerance);
}

/* By the box's left side, then by number. */
static int compare_entries(const void *a, const void *b)
{
    const sweep_entry *x = a, *y = b;
    if (x->low[0] != y->low[0]) {
        return x->low[0] < y->low[0] ? -1 : 1;
    }
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static bool sweep(const sweep_entry *entries, size_t count, double tolerance, uint32_t out[2])
{
    for (size_t i = 0; i < count; i++) {
        for (size_t k = i + 1; k < count; k++) {
            if (entries[k].low[0] >= entries[i].high[0] - tolerance) {
                break;
            }
            if (overlap(&entries[i], &entries[k], tolerance)) {
                const uint32_t a = entries[i].triangle, b = entries[k].triangle;
                out[0] = a < b ? a : b;
                out[1] = a < b ? b : a;
                return true;
            }
        }
    }
    return false;
}

static bool sweep_texel(overlap_work *work, sweep_scratch *scratch, size_t x, size_t y,
                        band_overlap *out)
{
    size_t count;
    double tolerance = 0.0;
    uint32_t pair[2];
    const air_fragment *fragments = air_coverage_texel(work->self, x, y, &count);
    if (count < 2) {
        return true;
    }
    if (count > scratch->capacity) {
        sweep_entry *grown =
            air_reallocate(work->context, scratch->entries, 2 * count, sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        scratch->entries = grown;
        scratch->capacity = 2 * count;
    }
    for (size_t i = 0; i < count; i++) {
        scratch->entries[i] =
            entry_of(work->self, air_fragment_triangle(fragments[i]), x, y, &tolerance);
    }
    qsort(scratch->entries, count, sizeof *scratch->entries, compare_entries);
    if (sweep(scratch->entries, count, tolerance, pair) && out->texel_count++ == 0) {
        out->first = (air_coverage_overlap){0, {(uint32_t)x, (uint32_t)y}, {pair[0], pair[1]}};
    }
    return true;
}

static void sweep_band(void *user, size_t index, size_t worker)
{
    overlap_work *const work = user;
    const air_coverage *self = work->self;
    const size_t top = index * AIR_COVERAGE_BAND, end = top + AIR_COVERAGE_BAND;
    if (self->bands[index].first == NULL) {
        return;
    }
    for (size_t y = top; y < end && y < self->height; y++) {
        for (size_t x = 0; x < self->width; x++) {
            if (!sweep_texel(work, &work->scratch[worker], x, y, &work->bands[index])) {
                atomic_store(&work->out_of_memory, true);
                return;
            }
        }
    }
}

air_status air_coverage_find_overlap(air_context *context, const air_coverage *self,
                                     air_coverage_overlap *out_overlap)
{
    const size_t workers = air_context_thread_count(context);
    overlap_work work = {.context = context, .self = self};
    air_coverage_overlap found = {0};
    work.bands = air_allocate(context, self->band_count, sizeof *work.bands);
    work.scratch = air_allocate(context, workers, sizeof *work.scratch);
    bool good = work.bands != NULL && work.scratch != NULL;
    if (good) {
        air_parallel_for(context, self->band_count, sweep_band, &work);
        good = !atomic_load(&work.out_of_memory);
    }
    for (size_t i = self->band_count; i-- > 0 && good;) {
        const size_t count = found.texel_count + work.bands[i].texel_count;
        found = work.bands[i].texel_count > 0 ? work.bands[i].first : found;
        found.texel_count = count;
    }
    for (size_t i = 0; i < workers && work.scratch != NULL; i++) {
        air_free(context, work.scratch[i].entries);
    }
    air_free(context, work.scratch);
    air_free(context, work.bands);
    if (!good) {
        return air_fail_memory(context, "coverage: overlaps");
    }
    *out_overlap = found;
    return AIR_OK;
}

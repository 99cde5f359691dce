/* seams_solve.c: least squares over samples of both sides of seams.
 *
 * Unknowns are changes d of the texels in the samples' footprints. A sample has eight of them: a
 * has the bilinear weights of the one side and, negative, of the other, r = a x is their
 * difference. With m taking the mean of four texels away from each, least is
 *
 *     sum (a (x + d))^2 + sum h d^2 + s sum |m d|^2
 *
 * the last over both sides of all samples, so (sum a a' + h + s sum m' m) d = -sum a (a x). */
#include <math.h>
#include <string.h>

#include "atlas/seams.h"
#include "core/vec.h"

/* MOST_ROUNDS: a few texels go below 0 at first, fewer each time; what is left is cut off. */
enum { FOOTPRINT = 8, MOST_INTERVALS = 1 << 18 /* twice the longest page */, MOST_ROUNDS = 6 };

typedef struct seam_sample {
    uint32_t unknown[FOOTPRINT]; /* four of each side, by rows */
    double fraction[2][2];       /* [side][axis]: the place between the first texel and the next */
} seam_sample;

/* What a plane needs; doubles per unknown. */
typedef struct plane_scratch {
    double *change, *residual, *direction, *image;
    bool *fixed; /* texels that would go below 0: they are 0 */
} plane_scratch;

/* What a plane says. */
typedef struct plane_report {
    double squares_before, squares_after, most_before, most_after;
    uint32_t iterations;
} plane_report;

typedef struct seam_solver {
    air_context *context;
    const air_seams_page *pages;
    size_t page_count;
    const air_seams_params *params;
    uint32_t **numbers; /* per page and texel: its unknown plus 1 */
    seam_sample *samples;
    size_t sample_count;
    uint64_t *texels; /* of each unknown: page << 32 | texel */
    float *hold;
    double *diagonal; /* of the matrix */
    size_t unknown_count, unknown_capacity;
    plane_scratch *scratch; /* per worker, or per plane where those are fewer */
    size_t scratch_count;
    bool by_plane;
    plane_report *reports; /* per plane */
} seam_solver;

void air_seams_params_default(air_seams_params *params)
{
    *params = (air_seams_params){.hold = 0.0003,
                                 .hold_free = 0.00015,
                                 .stiffness = 0.0001,
                                 .iterations = 2000,
                                 .tolerance = 1e-4};
}

/* ---- samples ---- */

static double side_length(const air_seam *seam, int side)
{
    const float(*p)[2] = seam->place[side];
    return hypot((double)p[1][0] - (double)p[0][0], (double)p[1][1] - (double)p[0][1]);
}

/* Intervals of at most half a texel (but for rounding), on whichever side is longer. */
static size_t interval_count(const air_seam *seam)
{
    const double longer = double_max(side_length(seam, 0), side_length(seam, 1));
    return (size_t)double_min(double_max(ceil(2.0 * longer - 1e-3), 1.0), MOST_INTERVALS);
}

static bool number_texel(seam_solver *s, uint32_t page, size_t texel, uint32_t *out)
{
    uint32_t *number = &s->numbers[page][texel];
    if (*number == 0) {
        if (s->unknown_count == s->unknown_capacity) {
            const size_t capacity = 2 * s->unknown_capacity + 1024;
            uint64_t *grown = air_reallocate(s->context, s->texels, capacity, sizeof *grown);
            if (grown == NULL) {
                return false;
            }
            s->texels = grown;
            s->unknown_capacity = capacity;
        }
        s->texels[s->unknown_count++] = (uint64_t)page << 32 | texel;
        *number = (uint32_t)s->unknown_count;
    }
    *out = *number - 1;
    return true;
}

/* The four texels about a place, those beyond the border moved onto it. */
static bool set_side(seam_solver *s, const air_seam *seam, int side, double share,
                     seam_sample *sample)
{
    const air_seams_page *page = &s->pages[seam->page[side]];
    const size_t size[2] = {page->width, page->height};
    size_t at[2][2];
    for (int k = 0; k < 2; k++) {
        const double a = (double)seam->place[side][0][k], b = (double)seam->place[side][1][k];
        const double most = (double)size[k] - 1.0;
        const double x = double_min(double_max(a + share * (b - a) - 0.5, 0.0), most);
        const double low = floor(x);
        at[k][0] = (size_t)low;
        at[k][1] = (size_t)double_min(low + 1.0, most);
        sample->fraction[side][k] = x - low;
    }
    for (int i = 0; i < 4; i++) {
        const size_t texel = at[1][i / 2] * page->width + at[0][i % 2];
        if (!number_texel(s, seam->page[side], texel, &sample->unknown[4 * side + i])) {
            return false;
        }
    }
    return true;
}

/* Weights of the unknowns in the difference of both sides. */
static void weigh(const seam_sample *sample, double out[FOOTPRINT])
{
    for (int side = 0; side < 2; side++) {
        const double x = sample->fraction[side][0], y = sample->fraction[side][1];
        const double sign = side == 0 ? 1.0 : -1.0, upper = sign * (1.0 - y), lower = sign * y;
        out[4 * side] = (1.0 - x) * upper;
        out[4 * side + 1] = x * upper;
        out[4 * side + 2] = (1.0 - x) * lower;
        out[4 * side + 3] = x * lower;
    }
}

static air_status make_samples(seam_solver *s, const air_seams *seams)
{
    size_t count = 0;
    for (size_t i = 0; i < seams->count; i++) {
        count += interval_count(&seams->seams[i]) + 1;
    }
    s->samples = air_allocate(s->context, count, sizeof *s->samples);
    if (s->samples == NULL) {
        return AIR_ERROR_MEMORY;
    }
    for (size_t i = 0; i < seams->count; i++) {
        const air_seam *seam = &seams->seams[i];
        const size_t intervals = interval_count(seam);
        for (size_t k = 0; k <= intervals; k++) {
            seam_sample *sample = &s->samples[s->sample_count++];
            const double share = (double)k / (double)intervals;
            if (!set_side(s, seam, 0, share, sample) || !set_side(s, seam, 1, share, sample)) {
                return AIR_ERROR_MEMORY;
            }
        }
    }
    return AIR_OK;
}

/* The weights that hold texels, and the matrix's diagonal. */
static air_status set_diagonal(seam_solver *s)
{
    s->hold = air_allocate(s->context, s->unknown_count, sizeof *s->hold);
    s->diagonal = air_allocate(s->context, s->unknown_count, sizeof *s->diagonal);
    if (s->hold == NULL || s->diagonal == NULL) {
        return AIR_ERROR_MEMORY;
    }
    for (size_t i = 0; i < s->unknown_count; i++) {
        const air_seams_page *page = &s->pages[s->texels[i] >> 32];
        const bool covered = page->charts[s->texels[i] & UINT32_MAX] != AIR_NO_CHART;
        s->hold[i] = (float)(covered ? s->params->hold : s->params->hold_free);
        s->diagonal[i] = (double)s->hold[i];
    }
    for (size_t i = 0; i < s->sample_count; i++) {
        double weight[FOOTPRINT];
        weigh(&s->samples[i], weight);
        for (int k = 0; k < FOOTPRINT; k++) {
            s->diagonal[s->samples[i].unknown[k]] +=
                weight[k] * weight[k] + 0.75 * s->params->stiffness;
        }
    }
    return AIR_OK;
}

/* ---- the matrix ---- */

static double difference(const seam_sample *sample, const double *values,
                         const double weight[FOOTPRINT])
{
    double sum = 0.0;
    for (int k = 0; k < FOOTPRINT; k++) {
        sum += weight[k] * values[sample->unknown[k]];
    }
    return sum;
}

/* out += factor a' (a values) */
static void spread(const seam_sample *sample, double factor, const double *values, double *out)
{
    double weight[FOOTPRINT];
    weigh(sample, weight);
    const double scaled = factor * difference(sample, values, weight);
    for (int k = 0; k < FOOTPRINT; k++) {
        out[sample->unknown[k]] += scaled * weight[k];
    }
}

/* out += factor m' m values, of both sides. Along a border at most two of a side's four texels may
 * be one: their weights are theirs twice, and the diagonal is then only near to the matrix's. */
static void stiffen(const seam_sample *sample, double factor, const double *values, double *out)
{
    for (int side = 0; side < 2; side++) {
        const uint32_t *unknown = sample->unknown + 4 * side;
        const double mean = 0.25 * (values[unknown[0]] + values[unknown[1]] + values[unknown[2]] +
                                    values[unknown[3]]);
        for (int k = 0; k < 4; k++) {
            out[unknown[k]] += factor * (values[unknown[k]] - mean);
        }
    }
}

static void multiply(const seam_solver *s, const double *values, double *out)
{
    for (size_t i = 0; i < s->unknown_count; i++) {
        out[i] = (double)s->hold[i] * values[i];
    }
    for (size_t i = 0; i < s->sample_count; i++) {
        spread(&s->samples[i], 1.0, values, out);
        stiffen(&s->samples[i], s->params->stiffness, values, out);
    }
}

/* residual . D^-1 residual */
static double norm_of(const seam_solver *s, const double *residual)
{
    double sum = 0.0;
    for (size_t i = 0; i < s->unknown_count; i++) {
        sum += residual[i] * residual[i] / s->diagonal[i];
    }
    return sum;
}

/* Conjugate gradients for the change, from what it is on, by the residual; the matrix's diagonal is
 * the preconditioner. What is fixed has no residual, so no direction either. Ends where the
 * residual's norm is no more than enough, and counts on from `done`. */
static uint32_t solve(const seam_solver *s, const plane_scratch *at, double enough, uint32_t done)
{
    const size_t count = s->unknown_count;
    double norm = norm_of(s, at->residual);
    for (size_t i = 0; i < count; i++) {
        at->direction[i] = at->residual[i] / s->diagonal[i];
    }
    for (; done < s->params->iterations && norm > enough; done++) {
        double curvature = 0.0;
        multiply(s, at->direction, at->image);
        for (size_t i = 0; i < count; i++) {
            curvature += at->direction[i] * at->image[i];
        }
        if (!(curvature > 0.0)) {
            break;
        }
        const double step = norm / curvature;
        for (size_t i = 0; i < count; i++) {
            at->change[i] += step * at->direction[i];
            at->residual[i] = at->fixed[i] ? 0.0 : at->residual[i] - step * at->image[i];
        }
        const double next = norm_of(s, at->residual);
        for (size_t i = 0; i < count; i++) {
            at->direction[i] = at->residual[i] / s->diagonal[i] + next / norm * at->direction[i];
        }
        norm = next;
    }
    return done;
}

/* ---- planes ---- */

static float *value_of(const seam_solver *s, size_t plane, size_t unknown)
{
    const air_seams_page *page = &s->pages[s->texels[unknown] >> 32];
    return &page->planes[plane][s->texels[unknown] & UINT32_MAX];
}

/* Texels' values, and over all samples the sum of squares and the largest difference. */
static void measure(const seam_solver *s, size_t plane, double *values, double *squares,
                    double *most)
{
    *squares = *most = 0.0;
    for (size_t i = 0; i < s->unknown_count; i++) {
        values[i] = (double)*value_of(s, plane, i);
    }
    for (size_t i = 0; i < s->sample_count; i++) {
        double weight[FOOTPRINT];
        weigh(&s->samples[i], weight);
        const double d = difference(&s->samples[i], values, weight);
        *squares += d * d;
        *most = double_max(*most, fabs(d));
    }
}

/* What is left of the equation for the change d; 0 for what is fixed. */
static void set_residual(const seam_solver *s, size_t plane, const plane_scratch *at)
{
    double *values = at->image;
    multiply(s, at->change, at->residual);
    for (size_t i = 0; i < s->unknown_count; i++) {
        at->residual[i] = -at->residual[i];
        values[i] = (double)*value_of(s, plane, i);
    }
    for (size_t i = 0; i < s->sample_count; i++) {
        spread(&s->samples[i], -1.0, values, at->residual);
    }
    for (size_t i = 0; i < s->unknown_count; i++) {
        at->residual[i] = at->fixed[i] ? 0.0 : at->residual[i];
    }
}

/* Light that would fall below 0 is fixed at 0. Was there any? */
static bool fix_negative(const seam_solver *s, size_t plane, const plane_scratch *at)
{
    bool any = false;
    for (size_t i = 0; i < s->unknown_count; i++) {
        const double value = (double)*value_of(s, plane, i);
        if (value >= 0.0 && !at->fixed[i] && value + at->change[i] < 0.0) {
            at->change[i] = -value;
            at->fixed[i] = true;
            any = true;
        }
    }
    return any;
}

static void solve_plane(void *user, size_t plane, size_t worker)
{
    const seam_solver *s = user;
    const plane_scratch *at = &s->scratch[s->by_plane ? plane : worker];
    plane_report *report = &s->reports[plane];
    const bool light = plane < s->params->light_planes;
    measure(s, plane, at->image, &report->squares_before, &report->most_before);
    memset(at->change, 0, s->unknown_count * sizeof *at->change);
    memset(at->fixed, 0, s->unknown_count * sizeof *at->fixed);
    set_residual(s, plane, at);
    const double tolerance = s->params->tolerance;
    const double enough = norm_of(s, at->residual) * tolerance * tolerance;
    report->iterations = solve(s, at, enough, 0);
    for (int round = 1; round < MOST_ROUNDS && light && fix_negative(s, plane, at); round++) {
        set_residual(s, plane, at);
        report->iterations = solve(s, at, enough, report->iterations);
    }
    for (size_t i = 0; i < s->unknown_count; i++) {
        float *value = value_of(s, plane, i);
        const double sum = (double)*value + at->change[i];
        *value = light && *value >= 0.0f && sum < 0.0 ? 0.0f : (float)sum;
    }
    measure(s, plane, at->image, &report->squares_after, &report->most_after);
}

static void sum_up(const seam_solver *s, size_t plane_count, air_seams_report *out)
{
    const double samples = double_max((double)s->sample_count * (double)plane_count, 1.0);
    *out = (air_seams_report){.sample_count = s->sample_count, .texel_count = s->unknown_count};
    for (size_t i = 0; i < plane_count; i++) {
        const plane_report *r = &s->reports[i];
        out->rms_before += r->squares_before;
        out->rms_after += r->squares_after;
        out->most_before = double_max(out->most_before, r->most_before);
        out->most_after = double_max(out->most_after, r->most_after);
        out->iterations = r->iterations > out->iterations ? r->iterations : out->iterations;
    }
    out->rms_before = sqrt(out->rms_before / samples);
    out->rms_after = sqrt(out->rms_after / samples);
}

/* ---- all of it ---- */

static air_status check(air_context *context, const air_seams *seams, const air_seams_page *pages,
                        size_t page_count, const air_seams_params *params)
{
    if (!(params->hold > 0.0) || !(params->hold_free > 0.0) || !(params->stiffness >= 0.0) ||
        !(params->tolerance >= 0.0)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "seams: weights %g, %g, %g, tolerance %g: expected positive numbers",
                        params->hold, params->hold_free, params->stiffness, params->tolerance);
    }
    for (size_t i = 0; i < page_count; i++) {
        if (pages[i].width == 0 || pages[i].height == 0 || pages[i].width > 65536 ||
            pages[i].height > 65536 || pages[i].width * pages[i].height >= UINT32_MAX) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "seams: page %zu of %zu x %zu texels: expected 1 to 65536 a side", i,
                            pages[i].width, pages[i].height);
        }
    }
    for (size_t i = 0; i < seams->count; i++) {
        const air_seam *seam = &seams->seams[i];
        if (seam->page[0] >= page_count || seam->page[1] >= page_count) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "seams: seam %zu: pages %u and %u: expected numbers below %zu", i,
                            seam->page[0], seam->page[1], page_count);
        }
    }
    return AIR_OK;
}

static air_status make_numbers(seam_solver *s)
{
    s->numbers = air_allocate(s->context, s->page_count, sizeof *s->numbers);
    for (size_t i = 0; i < s->page_count && s->numbers != NULL; i++) {
        s->numbers[i] =
            air_allocate(s->context, s->pages[i].width * s->pages[i].height, sizeof **s->numbers);
        if (s->numbers[i] == NULL) {
            return AIR_ERROR_MEMORY;
        }
    }
    return s->numbers != NULL ? AIR_OK : AIR_ERROR_MEMORY;
}

static air_status make_scratch(seam_solver *s, size_t plane_count)
{
    const size_t workers = air_context_thread_count(s->context);
    s->by_plane = plane_count < workers;
    s->scratch_count = s->by_plane ? plane_count : workers;
    s->reports = air_allocate(s->context, plane_count, sizeof *s->reports);
    s->scratch = air_allocate(s->context, s->scratch_count, sizeof *s->scratch);
    if (s->reports == NULL || s->scratch == NULL) {
        return AIR_ERROR_MEMORY;
    }
    for (size_t i = 0; i < s->scratch_count; i++) {
        const size_t count = s->unknown_count;
        double *block = air_allocate(s->context, count, 4 * sizeof *block);
        s->scratch[i].change = block;
        s->scratch[i].fixed = air_allocate(s->context, count, sizeof *s->scratch[i].fixed);
        if (block == NULL || s->scratch[i].fixed == NULL) {
            return AIR_ERROR_MEMORY;
        }
        s->scratch[i].residual = block + count;
        s->scratch[i].direction = block + 2 * count;
        s->scratch[i].image = block + 3 * count;
    }
    return AIR_OK;
}

static void finish_solver(seam_solver *s)
{
    for (size_t i = 0; s->scratch != NULL && i < s->scratch_count; i++) {
        air_free(s->context, s->scratch[i].fixed);
        air_free(s->context, s->scratch[i].change);
    }
    for (size_t i = 0; s->numbers != NULL && i < s->page_count; i++) {
        air_free(s->context, s->numbers[i]);
    }
    air_free(s->context, s->scratch);
    air_free(s->context, s->reports);
    air_free(s->context, s->diagonal);
    air_free(s->context, s->hold);
    air_free(s->context, s->texels);
    air_free(s->context, s->samples);
    air_free(s->context, s->numbers);
}

air_status air_seams_solve(air_context *context, const air_seams *seams,
                           const air_seams_page *pages, size_t page_count, size_t plane_count,
                           const air_seams_params *params, air_seams_report *out_report)
{
    seam_solver s = {
        .context = context, .pages = pages, .page_count = page_count, .params = params};
    air_status status = check(context, seams, pages, page_count, params);
    if (status != AIR_OK) {
        return status;
    }
    status = make_numbers(&s);
    status = status == AIR_OK ? make_samples(&s, seams) : status;
    status = status == AIR_OK ? set_diagonal(&s) : status;
    status = status == AIR_OK ? make_scratch(&s, plane_count) : status;
    if (status == AIR_OK) {
        air_parallel_for(context, plane_count, solve_plane, &s);
        if (out_report != NULL) {
            sum_up(&s, plane_count, out_report);
        }
    }
    finish_solver(&s);
    return status == AIR_OK ? AIR_OK : air_fail_memory(context, "seams");
}

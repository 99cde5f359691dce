/* denoise.c: for each offset a row of distances, summed over 3 x 3 texels, becomes a row of
 * weights; bands of rows share nothing. */
#include "atlas/denoise.h"

#include <math.h>
#include <string.h>

#include "core/exponential.h"
#include "core/vec.h"

/* PATCH: texels on each side of those whose neighbourhoods are compared. */
enum { BAND = 16, PATCH = 1, MOST_PLANES = AIR_ATLAS_DENOISE_PLANES };

typedef struct filter_work {
    const air_atlas_guides *guides;
    const air_atlas_denoise_params *params;
    const air_atlas_layer *layer;
    uint32_t *charts; /* AIR_NO_CHART also where a number is not finite */
    float *values[MOST_PLANES], *variances[MOST_PLANES]; /* copies; variances are smoothed */
    float *spacing;                                      /* metres from a texel to the next */
    float inverse_strength_squared, least_cosine, plane_distance;
    float *scratch; /* per worker */
    size_t scratch_size;
} filter_work;

/* A band's arrays. Rows of distances reach PATCH rows beyond the band on both sides. */
typedef struct filter_band {
    ptrdiff_t top, bottom;     /* rows [top, bottom) */
    float *pairs, *single;     /* one row: which texels have a distance, and it */
    float *distances, *counts; /* BAND + 2 PATCH rows of sums over 2 PATCH + 1 columns */
    float *sums, *weights;     /* per plane, and of weights: BAND rows */
} filter_band;

void air_atlas_denoise_params_default(air_atlas_denoise_params *params)
{
    *params = (air_atlas_denoise_params){.radius = 5,
                                         .strength = 0.8,
                                         .normal_angle_rad = 25.0 * AIR_PI / 180.0,
                                         .plane_distance = 1.0};
}

/* ---- preparing ---- */

static bool takes_part(const filter_work *work, size_t i)
{
    const air_atlas_guides *g = work->guides;
    float sum = g->area != NULL ? g->area[i] - g->area[i] : 0.0f;
    for (size_t k = 0; k < 3; k++) {
        sum += g->position[k][i] - g->position[k][i];
        sum += g->normal[k][i] - g->normal[k][i];
    }
    for (size_t k = 0; k < work->layer->plane_count; k++) {
        sum += work->layer->planes[k][i] - work->layer->planes[k][i];
        sum += work->layer->variance[k][i] - work->layer->variance[k][i];
    }
    return g->charts[i] != AIR_NO_CHART && sum == 0.0f;
}

static void copy_row(void *user, size_t y, size_t worker)
{
    const filter_work *work = user;
    const size_t width = work->guides->width;
    (void)worker;
    for (size_t i = y * width; i < (y + 1) * width; i++) {
        const bool part = takes_part(work, i);
        work->charts[i] = part ? work->guides->charts[i] : AIR_NO_CHART;
        for (size_t k = 0; k < work->layer->plane_count; k++) {
            work->values[k][i] = part ? work->layer->planes[k][i] : 0.0f;
        }
    }
}

static float distance_between(const air_atlas_guides *g, size_t a, size_t b)
{
    float sum = 0.0f;
    for (int k = 0; k < 3; k++) {
        const float d = g->position[k][a] - g->position[k][b];
        sum += d * d;
    }
    return sqrtf(sum);
}

/* The distance to the nearer neighbour on both axes, whichever is larger: a step on one side of the
 * texel does not count. 0 where there is none. */
static float spacing_at(const filter_work *work, size_t x, size_t y)
{
    const size_t width = work->guides->width, i = y * width + x;
    const bool has[4] = {x > 0, x + 1 < width, y > 0, y + 1 < work->guides->height};
    const size_t at[4] = {i - 1, i + 1, i - width, i + width};
    float nearest[2] = {INFINITY, INFINITY};
    for (int k = 0; k < 4; k++) {
        if (has[k] && work->charts[at[k]] == work->charts[i]) {
            nearest[k / 2] = float_min(nearest[k / 2], distance_between(work->guides, i, at[k]));
        }
    }
    const float most = float_max(nearest[0], nearest[1]);
    return isfinite(most)         ? most
           : isfinite(nearest[0]) ? nearest[0]
           : isfinite(nearest[1]) ? nearest[1]
                                  : 0.0f;
}

/* The mean of variances over 3 x 3 texels of the chart: a variance of few samples is itself noise,
 * and 0 where none of them found the light. */
static float smooth_variance(const filter_work *work, const float *variance, size_t x, size_t y)
{
    const size_t width = work->guides->width, height = work->guides->height;
    float sum = 0.0f, count = 0.0f;
    for (size_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < height; v++) {
        for (size_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < width; u++) {
            const bool same = work->charts[v * width + u] == work->charts[y * width + x];
            sum += same ? float_max(variance[v * width + u], 0.0f) : 0.0f;
            count += same ? 1.0f : 0.0f;
        }
    }
    return sum / count;
}

static void prepare_row(void *user, size_t y, size_t worker)
{
    const filter_work *work = user;
    const size_t width = work->guides->width;
    (void)worker;
    for (size_t x = 0; x < width; x++) {
        const size_t i = y * width + x;
        if (work->charts[i] == AIR_NO_CHART) {
            continue;
        }
        work->spacing[i] = spacing_at(work, x, y);
        for (size_t k = 0; k < work->layer->plane_count; k++) {
            work->variances[k][i] = smooth_variance(work, work->layer->variance[k], x, y);
        }
    }
}

/* ---- one offset ---- */

/* The texels x of a row whose neighbour at x + dx is on the page. */
typedef struct column_range {
    size_t first, end;
} column_range;

static column_range columns_of(size_t width, ptrdiff_t dx)
{
    const size_t left = dx < 0 ? (size_t)-dx : 0, right = dx > 0 ? (size_t)dx : 0;
    return (column_range){left < width ? left : width, right < width ? width - right : 0};
}

/* Adds to a row of distances those of a plane: squared differences less the noise's share of them,
 * in units of the noise [Rousselle2012, eq. 4]. */
static void add_distances(const filter_work *work, size_t plane, size_t from, ptrdiff_t offset,
                          column_range columns, float *out)
{
    const float *u = work->values[plane] + from, *v = work->variances[plane] + from;
    const float *other = u + offset, *other_v = v + offset;
    const float scale = work->inverse_strength_squared;
    for (size_t x = columns.first; x < columns.end; x++) {
        const float d = u[x] - other[x], sum = v[x] + other_v[x];
        const float noise = v[x] + float_min(v[x], other_v[x]);
        const float distance = (d * d - noise) * scale / (sum + 1e-30f);
        out[x] += float_min(distance, 1e6f);
    }
}

/* out[x] is the sum of in over columns x - PATCH to x + PATCH; in has PATCH zeros on both sides. */
static void sum_columns(const float *in, size_t width, float *out)
{
    for (size_t x = 0; x < width; x++) {
        float sum = in[x];
        for (size_t k = 1; k <= 2 * PATCH; k++) {
            sum += in[x + k];
        }
        out[x] = sum;
    }
}

/* Row y of distances and of how many there are, summed over columns. */
static void fill_distances(const filter_work *work, const filter_band *band, ptrdiff_t y,
                           ptrdiff_t dx, ptrdiff_t dy)
{
    const size_t width = work->guides->width, row = (size_t)(y - band->top + PATCH) * width;
    const ptrdiff_t offset = dy * (ptrdiff_t)width + dx;
    const ptrdiff_t height = (ptrdiff_t)work->guides->height;
    float *single = band->single + PATCH, *pairs = band->pairs + PATCH;
    if (y < 0 || y >= height || y + dy < 0 || y + dy >= height) {
        memset(band->distances + row, 0, width * sizeof(float));
        memset(band->counts + row, 0, width * sizeof(float));
        return;
    }
    const column_range columns = columns_of(width, dx);
    const uint32_t *charts = work->charts + (size_t)y * width, *other = charts + offset;
    memset(single, 0, width * sizeof *single);
    memset(pairs, 0, width * sizeof *pairs);
    for (size_t k = 0; k < work->layer->plane_count; k++) {
        add_distances(work, k, (size_t)y * width, offset, columns, single);
    }
    for (size_t x = columns.first; x < columns.end; x++) {
        const bool pair = charts[x] == other[x] && charts[x] != AIR_NO_CHART;
        pairs[x] = pair ? 1.0f : 0.0f;
        single[x] = pair ? single[x] : 0.0f;
    }
    sum_columns(band->single, width, band->distances + row);
    sum_columns(band->pairs, width, band->counts + row);
}

/* Is the neighbour on the same surface: 1, else 0. */
static float same_surface(const filter_work *work, size_t a, size_t b, float texels_squared)
{
    const air_atlas_guides *g = work->guides;
    float off = 0.0f, squared = 0.0f, na = 0.0f, nb = 0.0f, cosine = 0.0f;
    for (int k = 0; k < 3; k++) {
        const float d = g->position[k][b] - g->position[k][a];
        const float m = g->normal[k][a], n = g->normal[k][b];
        off += m * d;
        squared += d * d;
        na += m * m;
        nb += n * n;
        cosine += m * n;
    }
    const float spacing = work->spacing[a] * work->spacing[a];
    const float reach = 1.0001f * work->plane_distance * work->plane_distance * spacing * na;
    const bool faces = cosine >= work->least_cosine * sqrtf(na * nb);
    const bool near = off * off <= reach && squared <= 6.25f * spacing * texels_squared;
    return faces && near ? 1.0f : 0.0f;
}

/* From the mean distance of both neighbourhoods; `at` is the texel in the band. */
static float weight_of(const filter_work *work, const filter_band *band, size_t at)
{
    const size_t width = work->guides->width;
    float sum = 0.0f, count = 0.0f;
    for (size_t r = 0; r <= 2 * PATCH; r++) {
        sum += band->distances[at + r * width];
        count += band->counts[at + r * width];
    }
    const float distance = sum / (count * (float)work->layer->plane_count);
    return air_exp(-float_max(distance, 0.0f));
}

static void add_row(const filter_work *work, const filter_band *band, ptrdiff_t y, ptrdiff_t dx,
                    ptrdiff_t dy)
{
    const size_t width = work->guides->width, from = (size_t)y * width;
    const ptrdiff_t offset = dy * (ptrdiff_t)width + dx;
    const size_t in_band = (size_t)(y - band->top) * width;
    const column_range columns = columns_of(width, dx);
    const float texels_squared = (float)(dx * dx + dy * dy);
    if (y + dy < 0 || y + dy >= (ptrdiff_t)work->guides->height) {
        return;
    }
    for (size_t x = columns.first; x < columns.end; x++) {
        const size_t i = from + x, other = (size_t)((ptrdiff_t)i + offset);
        if (work->charts[i] == AIR_NO_CHART || work->charts[i] != work->charts[other]) {
            continue;
        }
        float weight = weight_of(work, band, in_band + x);
        if (weight < 1e-6f) {
            continue;
        }
        weight *= offset == 0 ? 1.0f : same_surface(work, i, other, texels_squared);
        weight *= work->guides->area != NULL ? work->guides->area[other] : 1.0f;
        band->weights[in_band + x] += weight;
        for (size_t k = 0; k < work->layer->plane_count; k++) {
            band->sums[k * BAND * width + in_band + x] += weight * work->values[k][other];
        }
    }
}

/* ---- bands ---- */

static filter_band make_band(const filter_work *work, size_t index, size_t worker)
{
    const size_t width = work->guides->width, height = work->guides->height;
    const size_t top = index * BAND, end = top + BAND < height ? top + BAND : height;
    float *block = work->scratch + worker * work->scratch_size;
    filter_band band = {.top = (ptrdiff_t)top, .bottom = (ptrdiff_t)end, .pairs = block};
    band.single = band.pairs + width + 2 * PATCH;
    band.distances = band.single + width + 2 * PATCH;
    band.counts = band.distances + (BAND + 2 * PATCH) * width;
    band.weights = band.counts + (BAND + 2 * PATCH) * width;
    band.sums = band.weights + BAND * width;
    memset(band.weights, 0, (work->layer->plane_count + 1) * BAND * width * sizeof(float));
    return band;
}

static void filter_rows(void *user, size_t index, size_t worker)
{
    const filter_work *work = user;
    const filter_band band = make_band(work, index, worker);
    const size_t width = work->guides->width;
    const ptrdiff_t radius = (ptrdiff_t)work->params->radius;
    for (ptrdiff_t dy = -radius; dy <= radius; dy++) {
        for (ptrdiff_t dx = -radius; dx <= radius; dx++) {
            for (ptrdiff_t y = band.top - PATCH; y < band.bottom + PATCH; y++) {
                fill_distances(work, &band, y, dx, dy);
            }
            for (ptrdiff_t y = band.top; y < band.bottom; y++) {
                add_row(work, &band, y, dx, dy);
            }
        }
    }
    for (size_t i = 0; i < (size_t)(band.bottom - band.top) * width; i++) {
        const size_t texel = (size_t)band.top * width + i;
        const bool filtered = work->charts[texel] != AIR_NO_CHART && band.weights[i] > 0.0f;
        for (size_t k = 0; k < work->layer->plane_count && filtered; k++) {
            work->layer->planes[k][texel] = band.sums[k * BAND * width + i] / band.weights[i];
        }
    }
}

/* ---- all of it ---- */

static air_status check(air_context *context, const air_atlas_guides *guides,
                        const air_atlas_denoise_params *params, const air_atlas_layer *layer)
{
    if (guides->width == 0 || guides->height == 0 || guides->width > 65536 ||
        guides->height > 65536 || layer->plane_count == 0 || layer->plane_count > MOST_PLANES) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "denoise: %zu x %zu texels, %zu planes: expected 1 to 65536 texels a side "
                        "and 1 to %d planes",
                        guides->width, guides->height, layer->plane_count, MOST_PLANES);
    }
    if (params->radius < 1 || params->radius > 20 || !(params->strength > 0.0) ||
        !(params->normal_angle_rad > 0.0 && params->normal_angle_rad <= 3.1416) ||
        !(params->plane_distance >= 0.0)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "denoise: radius %u, strength %g, angle %g, distance %g: expected a radius "
                        "of 1 to 20, a positive strength, an angle in (0, pi] and no negative "
                        "distance",
                        params->radius, params->strength, params->normal_angle_rad,
                        params->plane_distance);
    }
    return AIR_OK;
}

static air_status allocate(air_context *context, filter_work *work, size_t count)
{
    const size_t texels = work->guides->width * work->guides->height;
    work->charts = air_allocate(context, texels, sizeof *work->charts);
    work->spacing = air_allocate(context, texels, sizeof *work->spacing);
    work->scratch_size =
        (2 * (BAND + 2 * PATCH) + (count + 1) * BAND + 2) * work->guides->width + 4 * PATCH;
    work->scratch = air_allocate(context, air_context_thread_count(context) * work->scratch_size,
                                 sizeof *work->scratch);
    bool good = work->charts != NULL && work->spacing != NULL && work->scratch != NULL;
    for (size_t k = 0; k < count && good; k++) {
        work->values[k] = air_allocate(context, texels, sizeof(float));
        work->variances[k] = air_allocate(context, texels, sizeof(float));
        good = work->values[k] != NULL && work->variances[k] != NULL;
    }
    return good ? AIR_OK : AIR_ERROR_MEMORY;
}

air_status air_atlas_denoise(air_context *context, const air_atlas_guides *guides,
                             const air_atlas_denoise_params *params, const air_atlas_layer *layer)
{
    air_status status = check(context, guides, params, layer);
    if (status != AIR_OK) {
        return status;
    }
    filter_work work = {.guides = guides,
                        .params = params,
                        .layer = layer,
                        .inverse_strength_squared =
                            (float)(1.0 / (params->strength * params->strength)),
                        .least_cosine = (float)cos(params->normal_angle_rad),
                        .plane_distance = (float)params->plane_distance};
    status = allocate(context, &work, layer->plane_count);
    if (status == AIR_OK) {
        air_parallel_for(context, guides->height, copy_row, &work);
        air_parallel_for(context, guides->height, prepare_row, &work);
        air_parallel_for(context, (guides->height + BAND - 1) / BAND, filter_rows, &work);
    }
    for (size_t k = layer->plane_count; k-- > 0;) {
        air_free(context, work.variances[k]);
        air_free(context, work.values[k]);
    }
    air_free(context, work.scratch);
    air_free(context, work.spacing);
    air_free(context, work.charts);
    return status == AIR_OK ? AIR_OK : air_fail_memory(context, "denoise");
}

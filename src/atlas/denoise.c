/* denoise.c: for each offset a row of distances, summed over 3 x 3 texels, becomes a row of
 * weights; bands of rows share nothing. */
#include "atlas/denoise.h"

#include <math.h>
#include <string.h>

#include "atlas/outliers.h"
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
    float *normals[3];                                   /* unit; 0 where a texel takes no part */
    float *spacing;                                      /* metres from a texel to the next */
    uint16_t *marks;                                     /* a bit for each plane: an outlier */
    air_outlier *outliers;
    size_t first_outlier[MOST_PLANES]; /* of each plane in the list */
    float inverse_strength_squared, least_cosine, plane_distance;
    float *scratch; /* per worker */
    size_t scratch_size;
} filter_work;

/* A band's arrays. Rows of distances reach PATCH rows beyond the band on both sides. */
typedef struct filter_band {
    ptrdiff_t top, bottom;     /* rows [top, bottom) */
    float *pairs, *single;     /* one row: which texels have a distance, and it */
    float *row;                /* one row of weights */
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

static void copy_normal(const filter_work *work, size_t i, bool part)
{
    const float *const *normal = work->guides->normal;
    const float x = normal[0][i], y = normal[1][i], z = normal[2][i];
    const float length = sqrtf(x * x + y * y + z * z);
    for (size_t k = 0; k < 3; k++) {
        work->normals[k][i] = part && length > 0.0f ? normal[k][i] / length : 0.0f;
    }
}

static void copy_row(void *user, size_t y, size_t worker)
{
    const filter_work *work = user;
    const size_t width = work->guides->width;
    (void)worker;
    for (size_t i = y * width; i < (y + 1) * width; i++) {
        const bool part = takes_part(work, i);
        work->charts[i] = part ? work->guides->charts[i] : AIR_NO_CHART;
        copy_normal(work, i, part);
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

/* ---- outliers ---- */

static air_outlier_surface surface_of(const filter_work *work)
{
    const air_atlas_guides *g = work->guides;
    return (air_outlier_surface){.width = g->width,
                                 .height = g->height,
                                 .charts = work->charts,
                                 .position = {g->position[0], g->position[1], g->position[2]},
                                 .normal = {work->normals[0], work->normals[1], work->normals[2]},
                                 .area = g->area,
                                 .spacing = work->spacing,
                                 .least_cosine = work->least_cosine,
                                 .plane_distance = work->plane_distance};
}

static void mark_row(void *user, size_t y, size_t worker)
{
    const filter_work *work = user;
    const air_outlier_surface surface = surface_of(work);
    (void)worker;
    for (size_t i = y * surface.width; i < (y + 1) * surface.width; i++) {
        uint16_t mark = 0;
        for (size_t k = 0; k < work->layer->plane_count; k++) {
            const bool is = air_outlier_is(&surface, work->values[k], work->layer->variance[k], i);
            mark = (uint16_t)(mark | (is ? 1u << k : 0u));
        }
        work->marks[i] = mark;
    }
}

static void spread_plane(void *user, size_t plane, size_t worker)
{
    const filter_work *work = user;
    const air_outlier_surface surface = surface_of(work);
    (void)worker;
    air_outliers_spread(&surface, work->marks, (uint16_t)(1u << plane),
                        work->outliers + work->first_outlier[plane], work->values[plane]);
}

static air_status spread_outliers(air_context *context, filter_work *work)
{
    const size_t texels = work->guides->width * work->guides->height;
    size_t count = 0;
    for (size_t k = 0; k < work->layer->plane_count; k++) {
        work->first_outlier[k] = count;
        for (size_t i = 0; i < texels; i++) {
            count += (uint32_t)(work->marks[i] >> k) & 1u;
        }
    }
    if (count == 0) {
        return AIR_OK;
    }
    work->outliers = air_allocate(context, count, sizeof *work->outliers);
    if (work->outliers == NULL) {
        return AIR_ERROR_MEMORY;
    }
    air_parallel_for(context, work->layer->plane_count, spread_plane, work);
    air_free(context, work->outliers);
    return AIR_OK;
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
                          column_range columns, float *restrict out)
{
    const float *u = work->values[plane] + from, *v = work->variances[plane] + from;
    const float *other = u + offset, *other_v = v + offset;
    const float scale = work->inverse_strength_squared;
    for (size_t x = columns.first; x < columns.end; x++) {
        const float d = u[x] - other[x], sum = v[x] + other_v[x];
        /* the smaller variance without a branch, which would be taken at random */
        const float smaller = 0.5f * (sum - fabsf(v[x] - other_v[x]));
        const float distance = (d * d - (v[x] + smaller)) * scale / (sum + 1e-30f);
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

/* Weights by the mean distance of both neighbourhoods: exp(-max(0, distance)), or exp(-80) where
 * that is less: nothing to a float. 0 where texel and neighbour are no pair. */
static void set_weights(const filter_work *work, const filter_band *band, size_t in_band,
                        const uint32_t *charts, ptrdiff_t offset, column_range columns)
{
    const size_t width = work->guides->width;
    const float *distances = band->distances + in_band, *counts = band->counts + in_band;
    const uint32_t *other = charts + offset;
    const float planes = (float)work->layer->plane_count;
    float *restrict weights = band->row;
    float *restrict sums = band->single + PATCH, *restrict pairs = band->pairs + PATCH;
    memset(sums, 0, width * sizeof *sums);
    memset(pairs, 0, width * sizeof *pairs);
    for (size_t r = 0; r <= 2 * PATCH; r++) {
        for (size_t x = columns.first; x < columns.end; x++) {
            sums[x] += distances[x + r * width];
            pairs[x] += counts[x + r * width];
        }
    }
    for (size_t x = columns.first; x < columns.end; x++) {
        const float distance = sums[x] / (pairs[x] * planes + 1e-30f);
        sums[x] = float_min(float_max(distance, 0.0f), 80.0f);
        pairs[x] = charts[x] == other[x] ? 1.0f : 0.0f;
    }
    for (size_t x = columns.first; x < columns.end; x++) {
        float power;
        const float p = air_exp_parts(-sums[x], &power);
        weights[x] = pairs[x] * ((p + 1.0f) * power);
    }
}

/* Weights become 0 where the neighbour turns away, lies off the texel's plane, or is farther than
 * its place on the page says. */
static void cut_weights(const filter_work *work, size_t from, ptrdiff_t offset,
                        float texels_squared, column_range columns, float *restrict weights)
{
    const float *const *position = work->guides->position;
    const float *px = position[0] + from, *py = position[1] + from, *pz = position[2] + from;
    const float *nx = work->normals[0] + from, *ny = work->normals[1] + from;
    const float *nz = work->normals[2] + from, *spacing = work->spacing + from;
    const float *qx = px + offset, *qy = py + offset, *qz = pz + offset;
    const float *mx = nx + offset, *my = ny + offset, *mz = nz + offset;
    const float off_plane = 1.0001f * work->plane_distance * work->plane_distance;
    const float least_cosine = work->least_cosine, away = 6.25f * texels_squared;
    for (size_t x = columns.first; x < columns.end; x++) {
        const float dx = qx[x] - px[x], dy = qy[x] - py[x], dz = qz[x] - pz[x];
        const float off = nx[x] * dx + ny[x] * dy + nz[x] * dz;
        const float cosine = nx[x] * mx[x] + ny[x] * my[x] + nz[x] * mz[x];
        const float step = spacing[x] * spacing[x];
        const bool near = (off * off <= off_plane * step) &
                          (dx * dx + dy * dy + dz * dz <= away * step) & (cosine >= least_cosine);
        weights[x] = near ? weights[x] : 0.0f;
    }
}

static void add_row(const filter_work *work, const filter_band *band, ptrdiff_t y, ptrdiff_t dx,
                    ptrdiff_t dy)
{
    const size_t width = work->guides->width, from = (size_t)y * width;
    const ptrdiff_t offset = dy * (ptrdiff_t)width + dx;
    const size_t in_band = (size_t)(y - band->top) * width;
    const column_range columns = columns_of(width, dx);
    float *weights = band->row, *total = band->weights + in_band;
    if (y + dy < 0 || y + dy >= (ptrdiff_t)work->guides->height) {
        return;
    }
    set_weights(work, band, in_band, work->charts + from, offset, columns);
    if (offset != 0) {
        cut_weights(work, from, offset, (float)(dx * dx + dy * dy), columns, weights);
    }
    if (work->guides->area != NULL) {
        const float *area = work->guides->area + from + offset;
        for (size_t x = columns.first; x < columns.end; x++) {
            weights[x] = weights[x] > 0.0f ? weights[x] * area[x] : 0.0f;
        }
    }
    for (size_t x = columns.first; x < columns.end; x++) {
        total[x] += weights[x];
    }
    for (size_t k = 0; k < work->layer->plane_count; k++) {
        const float *values = work->values[k] + from + offset;
        float *sums = band->sums + k * BAND * width + in_band;
        for (size_t x = columns.first; x < columns.end; x++) {
            sums[x] += weights[x] * values[x];
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
    band.row = band.single + width + 2 * PATCH;
    band.distances = band.row + width;
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
    work->marks = air_allocate(context, texels, sizeof *work->marks);
    work->scratch_size =
        (2 * (BAND + 2 * PATCH) + (count + 1) * BAND + 3) * work->guides->width + 4 * PATCH;
    work->scratch = air_allocate(context, air_context_thread_count(context) * work->scratch_size,
                                 sizeof *work->scratch);
    bool good = work->charts != NULL && work->spacing != NULL && work->marks != NULL &&
                work->scratch != NULL;
    for (size_t k = 0; k < 3 && good; k++) {
        work->normals[k] = air_allocate(context, texels, sizeof(float));
        good = work->normals[k] != NULL;
    }
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
        air_parallel_for(context, guides->height, mark_row, &work);
        air_parallel_for(context, guides->height, prepare_row, &work);
        status = spread_outliers(context, &work);
    }
    if (status == AIR_OK) {
        air_parallel_for(context, (guides->height + BAND - 1) / BAND, filter_rows, &work);
    }
    for (size_t k = layer->plane_count; k-- > 0;) {
        air_free(context, work.variances[k]);
        air_free(context, work.values[k]);
    }
    for (size_t k = 3; k-- > 0;) {
        air_free(context, work.normals[k]);
    }
    air_free(context, work.scratch);
    air_free(context, work.marks);
    air_free(context, work.spacing);
    air_free(context, work.charts);
    return status == AIR_OK ? AIR_OK : air_fail_memory(context, "denoise");
}

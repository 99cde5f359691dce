/* denoise.c: the filter: what is prepared once, and level after level. */
#include "airlight/denoise.h"

#include <math.h>
#include <string.h>

#include "core/host.h"
#include "image/denoise_rows.h"

/* In the place of ln depth where there is no surface: further from any (those of floats are within
 * +-104) than the widest level, 4 / 0.25 a unit, can bridge. */
static const float sky = 1e5f;

void air_denoise_params_default(air_denoise_params *params)
{
    *params = (air_denoise_params){.levels = 3,
                                   .scale = 1.0f,
                                   .value_width = 1.0f,
                                   .albedo = true,
                                   .terms = AIR_DENOISE_TERMS};
}

void air_denoise_row_c(const air_denoise_level *level, size_t row) { filter_row(level, row); }

static air_denoise_row *row_version(air_cpu cpu)
{
#if defined(__x86_64__)
    return cpu >= AIR_CPU_AVX512 ? air_denoise_row_avx512
           : cpu >= AIR_CPU_AVX2 ? air_denoise_row_avx2
                                 : air_denoise_row_c;
#else
    (void)cpu;
    return air_denoise_row_c;
#endif
}

/* ---- levels ---- */

/* How much of the spline there is at a level, in [0, 1]: the filter's variance along an axis, the
 * sum of 4^level over all levels, is brought to its scale^2-th part from the coarsest level down.
 */
static double share_of_level(const air_denoise_params *params, uint32_t index)
{
    const double all = (pow(4.0, (double)params->levels) - 1.0) / 3.0;
    const double finer = (pow(4.0, (double)index) - 1.0) / 3.0;
    const double left = all * (double)params->scale * (double)params->scale - finer;
    return fmin(fmax(left / pow(4.0, (double)index), 0.0), 1.0);
}

/* The kernel along an axis. */
static void make_kernel(double share, float out[AIR_DENOISE_TAPS])
{
    static const double spline[AIR_DENOISE_TAPS] = {1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0,
                                                    1.0 / 16.0};
    for (int i = 0; i < AIR_DENOISE_TAPS; i++) {
        out[i] = (float)(share * spline[i] + (i == AIR_DENOISE_TAPS / 2 ? 1.0 - share : 0.0));
    }
}

/* Taps that leave a row of `width` pixels from everywhere are taken out. */
static void set_level(air_denoise_level *level, const air_denoise_params *params, uint32_t index,
                      size_t width)
{
    level->step = (ptrdiff_t)1 << index;
    level->depth_factor = 4.0f / (params->scale * (float)(1u << index));
    level->value_factor = 1.0f / params->value_width;
    level->normal_power = 32.0f / (params->scale * params->scale);
    make_kernel(share_of_level(params, index), level->kernel_y);
    memcpy(level->kernel_x, level->kernel_y, sizeof level->kernel_x);
    for (int i = 0; i < AIR_DENOISE_TAPS; i++) {
        const int away = i - AIR_DENOISE_TAPS / 2;
        const bool outside = (away < 0 ? -away : away) * level->step >= (ptrdiff_t)width;
        level->offset[i] = outside ? 0 : away * level->step;
        level->kernel_x[i] = outside ? 0.0f : level->kernel_x[i];
    }
}

/* ---- preparing ---- */

typedef struct denoise_work {
    const air_denoise_guides *guides;
    air_denoise_level level;
    air_denoise_row *filter_row;
    float *const *planes; /* the caller's */
    float *guide_copies;  /* ln depth, then the normal's, then the value */
    float *copies[2][AIR_DENOISE_MAX_PLANES];
} denoise_work;

static bool has_normals(const air_denoise_guides *guides) { return guides->normal[0] != NULL; }

/* Planes of guides, ln depth first. */
static size_t guide_count(const air_denoise_guides *guides)
{
    return 1u + (has_normals(guides) ? 3u : 0u) + (guides->value != NULL ? 1u : 0u);
}

/* Does pixel i take part: are all its numbers finite? Differences with themselves are 0, else NaN.
 */
static bool takes_part(const denoise_work *work, size_t i)
{
    const air_denoise_guides *guides = work->guides;
    const float z = guides->depth != NULL ? guides->depth[i] : 0.0f;
    float sum = z - z;
    for (size_t k = 0; k < work->level.count; k++) {
        sum += work->planes[k][i] - work->planes[k][i];
    }
    for (size_t k = 0; k < 3 && has_normals(guides); k++) {
        sum += guides->normal[k][i] - guides->normal[k][i];
    }
    sum += guides->value != NULL ? guides->value[i] - guides->value[i] : 0.0f;
    return sum == 0.0f && z >= 0.0f;
}

/* Pixels on edges hold the mean of several normals: only its direction counts. 0 stays 0, which is
 * like nothing but itself. The sky has no normal: there it is the same for all. */
static void copy_normal(const denoise_work *work, size_t from, bool surface, size_t to)
{
    const size_t plane = work->level.height * work->level.stride;
    const float *const *normal = work->guides->normal;
    const double n[3] = {(double)normal[0][from], (double)normal[1][from], (double)normal[2][from]};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (size_t k = 0; k < 3; k++) {
        const double unit = length > 0.0 ? n[k] / length : 0.0;
        work->guide_copies[(k + 1) * plane + to] = surface ? (float)unit : (float)(k == 0);
    }
}

/* One row of guides and planes into the padded copies. The sky has no normal: there it is the same
 * for all pixels. Pixels that take no part have zeros, that sums are not spoilt by 0 * NaN. */
static void copy_row(void *user, size_t row, size_t worker)
{
    const denoise_work *work = user;
    const air_denoise_level *level = &work->level;
    const air_denoise_guides *guides = work->guides;
    (void)worker;
    for (size_t x = 0; x < level->stride; x++) {
        work->guide_copies[row * level->stride + x] = NAN;
    }
    for (size_t x = 0; x < guides->width; x++) {
        const size_t from = row * guides->width + x, to = row * level->stride + level->pad + x;
        if (!takes_part(work, from)) {
            continue;
        }
        const float z = guides->depth != NULL ? guides->depth[from] : 1.0f;
        work->guide_copies[to] = z > 0.0f ? logf(z) : sky;
        if (has_normals(guides)) {
            copy_normal(work, from, z > 0.0f, to);
        }
        if (guides->value != NULL) {
            const size_t last = guide_count(guides) - 1;
            work->guide_copies[last * level->height * level->stride + to] = guides->value[from];
        }
        for (size_t k = 0; k < level->count; k++) {
            work->copies[0][k][to] = work->planes[k][from];
        }
    }
}

static void run_row(void *user, size_t row, size_t worker)
{
    const denoise_work *work = user;
    (void)worker;
    work->filter_row(&work->level, row);
}

static void run_levels(air_context *context, denoise_work *work, const air_denoise_params *params)
{
    air_denoise_level *level = &work->level;
    const air_denoise_guides *guides = work->guides;
    uint32_t done = 0;
    air_parallel_for(context, level->height, copy_row, work);
    for (; done < params->levels && share_of_level(params, done) > 0.0; done++) {
        level->planes = work->copies[done % 2];
        level->out = work->copies[1 - done % 2];
        set_level(level, params, done, guides->width);
        air_parallel_for(context, level->height, run_row, work);
    }
    for (size_t k = 0; k < level->count; k++) {
        for (size_t y = 0; y < level->height; y++) {
            const size_t from = y * level->stride + level->pad;
            float *row = work->planes[k] + y * guides->width;
            for (size_t x = 0; x < guides->width; x++) {
                const bool part = !isnan(level->log_depth[from + x]);
                row[x] = part ? work->copies[done % 2][k][from + x] : row[x];
            }
        }
    }
}

/* ---- all of it ---- */

static air_status check(air_context *context, const air_denoise_params *params, size_t count)
{
    if (params->levels > AIR_DENOISE_MAX_LEVELS || !(params->scale > 0.0f) ||
        !(params->scale <= 1.0f) || !(params->value_width > 0.0f)) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "denoise: %u levels, scale %g, value width %g: expected at most %d levels, a "
            "scale in (0, 1] and a width above 0",
            params->levels, (double)params->scale, (double)params->value_width,
            (int)AIR_DENOISE_MAX_LEVELS);
    }
    if (count > AIR_DENOISE_MAX_PLANES) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "denoise: %zu planes are more than %d", count,
                        (int)AIR_DENOISE_MAX_PLANES);
    }
    return AIR_OK;
}

/* Sizes of the padded copies: taps reach 2^levels pixels away, but none further than the row is
 * wide. */
static void set_layout(air_denoise_level *level, const air_denoise_guides *guides,
                       const air_denoise_params *params)
{
    const size_t reach = (size_t)1 << params->levels;
    level->height = guides->height;
    level->pad = reach < guides->width ? reach : guides->width;
    level->chunks = (guides->width + AIR_DENOISE_CHUNK - 1) / AIR_DENOISE_CHUNK;
    level->stride = level->chunks * AIR_DENOISE_CHUNK + 2 * level->pad;
}

air_status air_denoise_planes(air_context *context, const air_denoise_guides *guides,
                              const air_denoise_params *params, float *const *planes, size_t count)
{
    denoise_work work = {.guides = guides, .planes = planes, .level = {.count = count}};
    air_denoise_level *level = &work.level;
    air_status status = check(context, params, count);
    if (status != AIR_OK || params->levels == 0 || guides->width * guides->height == 0 ||
        count == 0) {
        return status;
    }
    set_layout(level, guides, params);
    const size_t plane = level->height * level->stride, guides_held = guide_count(guides);
    work.guide_copies = air_allocate(context, guides_held * plane, sizeof(float));
    float *copies = air_allocate(context, 2 * count * plane, sizeof(float));
    if (work.guide_copies == NULL || copies == NULL) {
        status = air_fail_memory(context, "denoise");
        goto done;
    }
    level->log_depth = work.guide_copies;
    for (size_t k = 0; k < 3 && has_normals(guides); k++) {
        level->normal[k] = work.guide_copies + (k + 1) * plane;
    }
    level->value = guides->value != NULL ? work.guide_copies + (guides_held - 1) * plane : NULL;
    for (size_t k = 0; k < count; k++) {
        work.copies[0][k] = copies + k * plane;
        work.copies[1][k] = copies + (count + k) * plane;
    }
    work.filter_row = row_version(air_context_cpu(context));
    run_levels(context, &work, params);
done:
    air_free(context, copies);
    air_free(context, work.guide_copies);
    return status;
}

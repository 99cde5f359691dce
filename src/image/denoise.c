#include "airlight/denoise.h"

#include <math.h>
#include <string.h>

#include "core/exponential.h"
#include "core/host.h"
#include "core/vec.h"

enum { TAPS = 5 };

/* One level under way. */
typedef struct level {
    const air_denoise_guides *guides;
    const float *log_depth; /* NaN: takes no part; +INFINITY: no surface */
    float *const *planes;   /* read */
    float *const *out;
    size_t count;
    ptrdiff_t step;
    float kernel[TAPS]; /* along an axis */
    float depth_factor; /* 1 / width in ln depth */
    float normal_power;
} level;

void air_denoise_params_default(air_denoise_params *params)
{
    *params = (air_denoise_params){.levels = 3, .scale = 1.0f, .albedo = true};
}

/* What the filter blurs grows as scale^4 where shadows are smooth, and as scale at sharp edges;
 * the noise it leaves falls as 1 / (samples scale^2). Both fall in step with scale^2 = samples^-1/3
 * and scale^3 = 1 / samples; this is in between. */
float air_denoise_scale(double samples) { return samples > 1.0 ? (float)pow(samples, -0.3) : 1.0f; }

/* ---- one row ---- */

/* exp(x), x <= 0, without a branch. */
static inline float decay(float x)
{
    float power;
    const float p = air_exp_parts(float_max(x, -87.0f), &power);
    return (p + 1.0f) * power;
}

/* The guides' part of the weights between pixels first..last of a row and those `shift` further in
 * memory. */
static void guide_weights(const level *self, size_t first, size_t last, ptrdiff_t shift,
                          float kernel, float *weights)
{
    const float *depth = self->log_depth;
    const float *const *normal = self->guides->normal;
    for (size_t i = first; i < last; i++) {
        const float a = depth[i], b = depth[(ptrdiff_t)i + shift];
        const float apart = fabsf(a - b);
        /* two pixels without surface: INFINITY - INFINITY */
        const float weight = a == b             ? 1.0f
                             : apart < INFINITY ? decay(-apart * self->depth_factor)
                                                : 0.0f;
        weights[i - first] = a != a || b != b ? 0.0f : kernel * weight;
    }
    for (size_t i = first; normal[0] != NULL && i < last; i++) {
        const size_t q = (size_t)((ptrdiff_t)i + shift);
        const float cosine =
            normal[0][i] * normal[0][q] + normal[1][i] * normal[1][q] + normal[2][i] * normal[2][q];
        /* sky has no normal */
        const float likeness =
            depth[i] == INFINITY ? 1.0f : powf(float_max(cosine, 0.0f), self->normal_power);
        weights[i - first] *= likeness;
    }
}

/* Adds one tap to the row's sums: planes, then weights. */
static void add_tap(const level *self, size_t row, ptrdiff_t dx, ptrdiff_t dy, float kernel,
                    float *weights, float *sums)
{
    const ptrdiff_t width = (ptrdiff_t)self->guides->width;
    const ptrdiff_t height = (ptrdiff_t)self->guides->height;
    const ptrdiff_t y = (ptrdiff_t)row + dy;
    const ptrdiff_t begin = dx < 0 ? -dx : 0, end = dx > 0 ? width - dx : width;
    if (y < 0 || y >= height || begin >= end || kernel == 0.0f) {
        return;
    }
    const size_t first = row * (size_t)width + (size_t)begin;
    const size_t last = row * (size_t)width + (size_t)end;
    const ptrdiff_t shift = dy * width + dx;
    guide_weights(self, first, last, shift, kernel, weights);
    float *total = sums + self->count * (size_t)width + begin;
    for (size_t i = first; i < last; i++) {
        total[i - first] += weights[i - first];
    }
    for (size_t k = 0; k < self->count; k++) {
        const float *values = self->planes[k] + shift;
        float *sum = sums + k * (size_t)width + begin;
        for (size_t i = first; i < last; i++) {
            sum[i - first] += weights[i - first] * values[i];
        }
    }
}

typedef struct level_work {
    level level;
    float *scratch; /* per worker: a row of weights, sums of all planes and of weights */
} level_work;

static void filter_row(void *user, size_t row, size_t worker)
{
    const level_work *work = user;
    const level *self = &work->level;
    const size_t width = self->guides->width;
    float *weights = work->scratch + worker * (self->count + 2) * width, *sums = weights + width;
    memset(sums, 0, (self->count + 1) * width * sizeof *sums);
    for (int j = 0; j < TAPS; j++) {
        for (int i = 0; i < TAPS; i++) {
            add_tap(self, row, self->step * (i - TAPS / 2), self->step * (j - TAPS / 2),
                    self->kernel[i] * self->kernel[j], weights, sums);
        }
    }
    const float *total = sums + self->count * width;
    for (size_t k = 0; k < self->count; k++) {
        const float *in = self->planes[k] + row * width;
        float *out = self->out[k] + row * width;
        for (size_t x = 0; x < width; x++) {
            out[x] = total[x] > 0.0f ? sums[k * width + x] / total[x] : in[x];
        }
    }
}

/* ---- all levels ---- */

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

static void make_kernel(double share, float out[TAPS])
{
    static const double spline[TAPS] = {1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0};
    for (int i = 0; i < TAPS; i++) {
        out[i] = (float)(share * spline[i] + (i == TAPS / 2 ? 1.0 - share : 0.0));
    }
}

/* ln depth, what takes no part marked: there is a number that is not finite. */
static void make_log_depth(const air_denoise_guides *guides, float *const *planes, size_t count,
                           float *out)
{
    for (size_t i = 0; i < guides->width * guides->height; i++) {
        const float z = guides->depth != NULL ? guides->depth[i] : 1.0f;
        float sum = z - z;
        for (size_t k = 0; k < count; k++) {
            sum += planes[k][i] - planes[k][i];
        }
        for (size_t k = 0; k < 3 && guides->normal[0] != NULL; k++) {
            sum += guides->normal[k][i] - guides->normal[k][i];
        }
        out[i] = sum != 0.0f || z < 0.0f ? NAN : z == 0.0f ? INFINITY : logf(z);
    }
}

/* Pixels that take no part must not spoil sums by 0 * NaN. */
static void copy_finite(const float *plane, const float *log_depth, size_t pixels, float *out)
{
    for (size_t i = 0; i < pixels; i++) {
        out[i] = log_depth[i] == log_depth[i] ? plane[i] : 0.0f;
    }
}

static air_status check(air_context *context, const air_denoise_params *params)
{
    if (params->levels > AIR_DENOISE_MAX_LEVELS || !(params->scale > 0.0f) ||
        !(params->scale <= 1.0f)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "denoise: %u levels, scale %g: expected at most %d and a scale in (0, 1]",
                        params->levels, (double)params->scale, (int)AIR_DENOISE_MAX_LEVELS);
    }
    return AIR_OK;
}

enum { MOST_PLANES = 64 };

air_status air_denoise_planes(air_context *context, const air_denoise_guides *guides,
                              const air_denoise_params *params, float *const *planes, size_t count)
{
    const size_t pixels = guides->width * guides->height;
    const size_t workers = air_context_thread_count(context);
    float *pointers[2][MOST_PLANES];
    air_status status = check(context, params);
    if (status != AIR_OK || params->levels == 0 || pixels == 0 || count == 0) {
        return status;
    }
    if (count > MOST_PLANES) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "denoise: %zu planes are more than %d", count,
                        (int)MOST_PLANES);
    }
    float *log_depth = air_allocate(context, pixels, sizeof *log_depth);
    float *copies = air_allocate(context, 2 * count * pixels, sizeof *copies);
    float *scratch = air_allocate(context, workers * (count + 2) * guides->width, sizeof *scratch);
    if (log_depth == NULL || copies == NULL || scratch == NULL) {
        status = air_fail_memory(context, "denoise");
        goto done;
    }
    make_log_depth(guides, planes, count, log_depth);
    for (size_t k = 0; k < count; k++) {
        pointers[0][k] = copies + k * pixels;
        pointers[1][k] = copies + (count + k) * pixels;
        copy_finite(planes[k], log_depth, pixels, pointers[0][k]);
    }
    for (uint32_t i = 0; i < params->levels; i++) {
        level_work work = {.level = {.guides = guides,
                                     .log_depth = log_depth,
                                     .planes = pointers[i % 2],
                                     .out = pointers[1 - i % 2],
                                     .count = count,
                                     .step = (ptrdiff_t)1 << i,
                                     .depth_factor = 4.0f / (params->scale * (float)(1u << i)),
                                     .normal_power = 32.0f / (params->scale * params->scale)},
                           .scratch = scratch};
        make_kernel(share_of_level(params, i), work.level.kernel);
        air_parallel_for(context, guides->height, filter_row, &work);
    }
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < pixels; i++) {
            planes[k][i] =
                log_depth[i] == log_depth[i] ? pointers[params->levels % 2][k][i] : planes[k][i];
        }
    }
done:
    air_free(context, scratch);
    air_free(context, copies);
    air_free(context, log_depth);
    return status;
}

/* ---- images ---- */

static const float *find(const air_image *image, const char *name)
{
    const ptrdiff_t channel = air_image_find_channel(image, name);
    return channel < 0 ? NULL : air_image_plane_const(image, (size_t)channel);
}

static air_status copy_image(air_context *context, const air_image *image, air_image **out)
{
    enum { MOST_CHANNELS = 1023 };
    const char *names[MOST_CHANNELS];
    const size_t count = air_image_channel_count(image);
    for (size_t i = 0; i < count; i++) {
        names[i] = air_image_channel_name(image, i);
    }
    air_status status = air_image_create(context, air_image_width(image), air_image_height(image),
                                         count, names, out);
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        memcpy(air_image_plane(*out, i), air_image_plane_const(image, i),
               air_image_width(image) * air_image_height(image) * sizeof(float));
    }
    for (size_t i = 0; i < air_image_attribute_count(image) && status == AIR_OK; i++) {
        const char *name = air_image_attribute_name(image, i);
        status = air_image_set_attribute(*out, name, air_image_attribute(image, name));
    }
    return status;
}

/* What a surface reflects, so far as it is worth dividing by. */
static float divisor(const float *albedo, const float *depth, size_t i)
{
    return depth[i] > 0.0f && albedo[i] > 1e-3f ? albedo[i] : 1.0f;
}

air_status air_image_denoise(air_context *context, const air_image *image,
                             const air_denoise_params *params, air_image **out_image)
{
    static const char *const colour[3] = {"R", "G", "B"};
    static const char *const normals[3] = {"normal.X", "normal.Y", "normal.Z"};
    static const char *const albedos[3] = {"albedo.R", "albedo.G", "albedo.B"};
    air_denoise_guides guides = {air_image_width(image),
                                 air_image_height(image),
                                 find(image, "depth.Z"),
                                 {NULL, NULL, NULL}};
    const size_t pixels = guides.width * guides.height;
    float *planes[3];
    air_image *out = NULL;
    *out_image = NULL;
    if (guides.depth == NULL || find(image, "R") == NULL || find(image, "G") == NULL ||
        find(image, "B") == NULL) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "denoise: the image has no channel %s: expected R, G, B and the guides that "
            "render --guides writes",
            guides.depth == NULL ? "depth.Z" : "R, G or B");
    }
    for (int c = 0; c < 3 && find(image, normals[2]) != NULL; c++) {
        guides.normal[c] = find(image, normals[c]);
    }
    air_status status = copy_image(context, image, &out);
    for (int c = 0; c < 3 && status == AIR_OK; c++) {
        const float *albedo = params->albedo ? find(image, albedos[c]) : NULL;
        planes[c] = air_image_plane(out, (size_t)air_image_find_channel(out, colour[c]));
        for (size_t i = 0; albedo != NULL && i < pixels; i++) {
            planes[c][i] /= divisor(albedo, guides.depth, i);
        }
    }
    status = status == AIR_OK ? air_denoise_planes(context, &guides, params, planes, 3) : status;
    for (int c = 0; c < 3 && status == AIR_OK; c++) {
        const float *albedo = params->albedo ? find(image, albedos[c]) : NULL;
        for (size_t i = 0; albedo != NULL && i < pixels; i++) {
            planes[c][i] *= divisor(albedo, guides.depth, i);
        }
    }
    if (status != AIR_OK) {
        air_image_destroy(out);
        return status;
    }
    *out_image = out;
    return AIR_OK;
}

/* environment.c: see environment.h. */
#include "scene/lights/environment.h"

#include <string.h>

#include "core/warp.h"
#include "scene/lights/cdf.h"
#include "scene/subject.h"
#include "scene/texture.h"

/* ---- the bilinear function ---- */

/* Cell (column, row) lies between the centres of texels column - 1 and column, row - 1 and row;
 * column 0 wraps, rows 0 and height hold. (x, y) in [0, 1] is where within. */
typedef struct footprint {
    const float *pixels[4]; /* upper left, upper right, lower left, lower right */
    float latitude[2];
    float x, y;
} footprint;

static footprint footprint_at(const air_environment *env, size_t column, size_t row, float x,
                              float y)
{
    const size_t left = column > 0 ? column - 1 : env->width - 1;
    const size_t upper = row > 0 ? row - 1 : 0;
    const size_t lower = row < env->height ? row : env->height - 1;
    const float *top = env->pixels + upper * env->width * env->stride;
    const float *bottom = env->pixels + lower * env->width * env->stride;
    return (footprint){{top + left * env->stride, top + column * env->stride,
                        bottom + left * env->stride, bottom + column * env->stride},
                       {env->row_latitude[upper], env->row_latitude[lower]},
                       x,
                       y};
}

static float mix(float a, float b, float t) { return a + t * (b - a); }

static air_vec3 footprint_radiance(const footprint *f)
{
    float rgb[3];
    for (int k = 0; k < 3; k++) {
        rgb[k] = mix(mix(f->pixels[0][k], f->pixels[1][k], f->x),
                     mix(f->pixels[2][k], f->pixels[3][k], f->x), f->y);
    }
    return vec3_load(rgb);
}

/* The mean of the channels and not their luminance: noise is measured over all three alike. */
static float corner_weight(const footprint *f, int corner)
{
    return vec3_mean(vec3_load(f->pixels[corner])) * f->latitude[corner / 2];
}

static float footprint_weight(const footprint *f)
{
    return mix(mix(corner_weight(f, 0), corner_weight(f, 1), f->x),
               mix(corner_weight(f, 2), corner_weight(f, 3), f->x), f->y);
}

/* ---- directions ---- */

static air_vec3 to_image(const air_environment *env, air_vec3 dir)
{
    const float *m = env->to_world;
    return vec3(m[0] * dir.x + m[3] * dir.y + m[6] * dir.z,
                m[1] * dir.x + m[4] * dir.y + m[7] * dir.z,
                m[2] * dir.x + m[5] * dir.y + m[8] * dir.z);
}

static air_vec3 to_world(const air_environment *env, air_vec3 dir)
{
    const float *m = env->to_world;
    return vec3(m[0] * dir.x + m[1] * dir.y + m[2] * dir.z,
                m[3] * dir.x + m[4] * dir.y + m[5] * dir.z,
                m[6] * dir.x + m[7] * dir.y + m[8] * dir.z);
}

/* Where a direction falls; *out_latitude is the cosine of its latitude. */
static footprint footprint_of(const air_environment *env, air_vec3 dir, float *out_latitude)
{
    const air_vec3 local = to_image(env, dir);
    *out_latitude = sqrtf(local.x * local.x + local.z * local.z);
    const float u = 0.5f + atan2f(local.x, -local.z) * (0.5f / AIR_PI_F);
    const float v = atan2f(*out_latitude, local.y) * (1.0f / AIR_PI_F);
    const float x = u * (float)env->width + 0.5f, y = v * (float)env->height + 0.5f;
    const size_t column = (size_t)fmaxf(x, 0.0f), row = (size_t)fmaxf(y, 0.0f);
    return footprint_at(env, column < env->width ? column : 0,
                        row < env->height ? row : env->height, fminf(x - (float)column, 1.0f),
                        fminf(y - (float)row, 1.0f));
}

static float density(const air_environment *env, float weight, float latitude)
{
    if (env->density == 0.0f) {
        return sample_sphere_pdf();
    }
    return weight * env->density / fmaxf(latitude, 1e-7f);
}

air_vec3 air_environment_radiance(const air_light *light, air_vec3 dir)
{
    if (light->environment == NULL) {
        return light->color;
    }
    float latitude;
    const footprint f = footprint_of(light->environment, dir, &latitude);
    return vec3_mul(light->color, footprint_radiance(&f));
}

float air_environment_pdf(const air_light *light, air_vec3 dir)
{
    if (light->environment == NULL) {
        return sample_sphere_pdf();
    }
    float latitude;
    const footprint f = footprint_of(light->environment, dir, &latitude);
    return density(light->environment, footprint_weight(&f), latitude);
}

/* ---- sampling ---- */

/* [0, 1] with a density that goes linearly from a to b: inverts a x + (b - a) x^2 / 2 = u (a + b) /
 * 2 without cancellation. */
static float sample_linear(float a, float b, float u)
{
    const float most = fmaxf(a, b);
    if (!(most > 0.0f)) {
        return u;
    }
    const float p = a / most, q = b / most; /* so that squares do not overflow */
    const float root = sqrtf((1.0f - u) * p * p + u * q * q);
    return p + root > 0.0f ? fminf(u * (p + q) / (p + root), 1.0f) : u;
}

static void sample_image(const air_environment *env, float u1, float u2, air_light_point *out)
{
    const size_t row = air_cdf_choose(env->row_cdf, env->height + 1, &u2);
    const size_t column = air_cdf_choose(env->cell_cdf + row * env->width, env->width, &u1);
    footprint f = footprint_at(env, column, row, 0.0f, 0.0f);
    f.y = sample_linear(corner_weight(&f, 0) + corner_weight(&f, 1),
                        corner_weight(&f, 2) + corner_weight(&f, 3), u2);
    if (row == 0 || row == env->height) { /* half a cell */
        f.y = 0.5f * (f.y + (row == 0 ? 1.0f : 0.0f));
    }
    f.x = sample_linear(mix(corner_weight(&f, 0), corner_weight(&f, 2), f.y),
                        mix(corner_weight(&f, 1), corner_weight(&f, 3), f.y), u1);
    const float phi = 2.0f * AIR_PI_F * (((float)column + f.x - 0.5f) / (float)env->width - 0.5f);
    const float theta = AIR_PI_F * (((float)row + f.y - 0.5f) / (float)env->height);
    const float latitude = sinf(theta);
    const air_vec3 dir = vec3(latitude * sinf(phi), cosf(theta), -latitude * cosf(phi));
    out->dir = to_world(env, dir);
    out->value = footprint_radiance(&f);
    out->pdf = density(env, footprint_weight(&f), latitude);
}

void air_environment_sample(const air_light *light, float u1, float u2, air_light_point *out)
{
    const air_environment *env = light->environment;
    out->infinite = true;
    if (env != NULL && env->density > 0.0f) {
        sample_image(env, u1, u2, out);
        out->value = vec3_mul(out->value, light->color);
    } else {
        out->dir = sample_sphere(u1, u2);
        out->value = air_environment_radiance(light, out->dir);
        out->pdf = sample_sphere_pdf();
    }
}

/* ---- building ---- */

static const float MAX_PIXEL = 1e30f; /* sums and densities of such pixels still fit a float */

static air_status check_pixels(const air_subject *subject, const air_environment *env)
{
    for (size_t i = 0; i < env->width * env->height; i++) {
        const float *pixel = env->pixels + i * env->stride;
        for (int k = 0; k < 3; k++) {
            if (!(pixel[k] >= 0.0f && pixel[k] <= MAX_PIXEL)) {
                return air_subject_fail(
                    subject, "image pixel (%zu, %zu), channel %c, is %g, but must be in [0, %g]",
                    i % env->width, i / env->width, "RGB"[k], (double)pixel[k], (double)MAX_PIXEL);
            }
        }
    }
    return AIR_OK;
}

static bool set_pixels(air_context *context, const air_texture *image, air_environment *env)
{
    env->width = image->width;
    env->height = image->height;
    if (image->floats != NULL && image->channels >= 3) {
        env->pixels = image->floats;
        env->stride = image->channels;
        return true;
    }
    env->owned_pixels = air_allocate(context, env->width * env->height, 3 * sizeof(float));
    if (env->owned_pixels == NULL) {
        return false;
    }
    for (size_t i = 0; i < env->width * env->height; i++) {
        float rgba[4];
        air_texture_texel(image, i % env->width, i / env->width, rgba);
        memcpy(env->owned_pixels + 3 * i, rgba, 3 * sizeof(float));
    }
    env->pixels = env->owned_pixels;
    env->stride = 3;
    return true;
}

typedef struct row_job {
    air_environment *env;
    double *sums; /* of each row of cells */
} row_job;

/* The integral of the weight over a cell, in units of a whole cell. */
static double cell_weight(const air_environment *env, size_t column, size_t row)
{
    const footprint f = footprint_at(env, column, row, 0.5f, 0.5f);
    const double height = row == 0 || row == env->height ? 0.5 : 1.0;
    return height * (double)footprint_weight(&f);
}

static void build_row(void *user, size_t row, size_t worker)
{
    (void)worker;
    const row_job *job = user;
    air_environment *env = job->env;
    double total = 0.0, sum = 0.0;
    for (size_t column = 0; column < env->width; column++) {
        total += cell_weight(env, column, row);
    }
    float *cdf = env->cell_cdf + row * env->width;
    for (size_t column = 0; column < env->width; column++) {
        sum += cell_weight(env, column, row);
        cdf[column] = total > 0.0 ? (float)(sum / total) : 0.0f;
    }
    job->sums[row] = total;
}

static void build_distribution(air_context *context, air_environment *env, double *sums)
{
    for (size_t row = 0; row < env->height; row++) {
        env->row_latitude[row] = (float)sin(AIR_PI * ((double)row + 0.5) / (double)env->height);
    }
    row_job job = {env, sums};
    air_parallel_for(context, env->height + 1, build_row, &job);
    double total = 0.0, sum = 0.0;
    for (size_t row = 0; row <= env->height; row++) {
        total += sums[row];
    }
    for (size_t row = 0; row <= env->height; row++) {
        sum += sums[row];
        env->row_cdf[row] = total > 0.0 ? (float)(sum / total) : 0.0f;
    }
    /* (u, v) in [0,1]^2 has the density weight / mean weight; d omega = 2 pi^2 cos(latitude) du dv
     */
    env->integral = total / ((double)env->width * (double)env->height) * 2.0 * AIR_PI * AIR_PI;
    env->density = env->integral > 1e-30 ? (float)(1.0 / env->integral) : 0.0f;
}

/* Rows made exactly orthonormal, so that directions come out with unit length. */
static void set_rotation(const float m[9], air_environment *env)
{
    const air_vec3 x = vec3_normalize(vec3_load(m)), row = vec3_load(m + 3);
    const air_vec3 y = vec3_normalize(vec3_madd(row, -vec3_dot(row, x), x));
    vec3_store(env->to_world, x);
    vec3_store(env->to_world + 3, y);
    vec3_store(env->to_world + 6, vec3_cross(x, y));
}

air_status air_environment_create(air_context *context, const char *light_name,
                                  const struct air_texture *image, const float to_world_rotation[9],
                                  air_environment **out_environment)
{
    const air_subject subject = {context, "light", light_name};
    air_status status = AIR_OK;
    double *sums = NULL;
    air_environment *env = air_allocate(context, 1, sizeof *env);
    if (env == NULL || !set_pixels(context, image, env)) {
        status = air_fail_memory(context, "environment");
        goto cleanup;
    }
    set_rotation(to_world_rotation, env);
    status = check_pixels(&subject, env);
    if (status != AIR_OK) {
        goto cleanup;
    }
    env->row_latitude = air_allocate(context, env->height, sizeof *env->row_latitude);
    env->row_cdf = air_allocate(context, env->height + 1, sizeof *env->row_cdf);
    env->cell_cdf = air_allocate(context, env->height + 1, env->width * sizeof *env->cell_cdf);
    sums = air_allocate(context, env->height + 1, sizeof *sums);
    if (env->row_latitude == NULL || env->row_cdf == NULL || env->cell_cdf == NULL ||
        sums == NULL) {
        status = air_fail_memory(context, "environment");
        goto cleanup;
    }
    build_distribution(context, env, sums);
    *out_environment = env;
    env = NULL;
cleanup:
    air_free(context, sums);
    air_environment_destroy(context, env);
    return status;
}

void air_environment_destroy(air_context *context, air_environment *env)
{
    if (env != NULL) {
        air_free(context, env->cell_cdf);
        air_free(context, env->row_cdf);
        air_free(context, env->row_latitude);
        air_free(context, env->owned_pixels);
        air_free(context, env);
    }
}

#include "render/ordinates/sky.h"

#include <math.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "airlight/ordinates_view.h"
#include "core/phase.h"
#include "render/ordinates/sources.h"
#include "render/ordinates/with_ordinates.h"
#include "scene/fingerprint.h"
#include "scene/lights/environment.h"

enum { WIDTH = ORD_SKY_WIDTH, HEIGHT = ORD_SKY_HEIGHT, STRIDE = 4 };

/* ---- the image, small ---- */

/* Means over texels of the small map, weighted by solid angle. */
static void shrink(const air_light *light, float *out)
{
    const air_environment *const env = light->environment;
    float weights[HEIGHT * WIDTH] = {0.0f};
    for (size_t j = 0; j < env->height; j++) {
        const size_t row = j * HEIGHT / env->height;
        for (size_t i = 0; i < env->width; i++) {
            const size_t at = row * WIDTH + i * WIDTH / env->width;
            const float *const pixel = env->pixels + (j * env->width + i) * env->stride;
            weights[at] += env->row_latitude[j];
            out[at * STRIDE] += env->row_latitude[j] * pixel[0] * light->color.x;
            out[at * STRIDE + 1] += env->row_latitude[j] * pixel[1] * light->color.y;
            out[at * STRIDE + 2] += env->row_latitude[j] * pixel[2] * light->color.z;
        }
    }
    for (size_t at = 0; at < HEIGHT * WIDTH; at++) {
        const size_t row = at / WIDTH * env->height / HEIGHT,
                     column = at % WIDTH * env->width / WIDTH;
        const float *const pixel = env->pixels + (row * env->width + column) * env->stride;
        const float colour[3] = {light->color.x, light->color.y, light->color.z};
        for (size_t c = 0; c < 3; c++) { /* images smaller than the map leave gaps */
            float *const value = &out[at * STRIDE + c];
            *value = weights[at] > 0.0f ? *value / weights[at] : pixel[c] * colour[c];
        }
    }
}

/* ---- blur ---- */

typedef struct blurring {
    air_phase phase;
    float cap;
    const float *from;
    float *out;
} blurring;

/* Weights of texels of row `from`, by how many columns they lie from one of row `to`. */
static bool row_kernel(const blurring *self, size_t to, size_t from, float out[WIDTH])
{
    const double a = AIR_PI * ((double)to + 0.5) / HEIGHT,
                 b = AIR_PI * ((double)from + 0.5) / HEIGHT;
    bool any = false;
    for (int i = 0; i < WIDTH; i++) {
        const double cosine =
            cos(a) * cos(b) + sin(a) * sin(b) * cos(2.0 * AIR_PI * (double)i / WIDTH);
        const float value = phase_eval(self->phase, (float)fmin(1.0, cosine)) - self->cap;
        const bool above = value > 0.0f && cosine > 0.0; /* a peak backwards is none */
        out[i] = above ? value * (float)sin(b) : 0.0f;
        any = any || above;
    }
    return any;
}

static void add_row(const float *from, const float kernel[WIDTH], float sums[WIDTH * STRIDE])
{
    for (int shift = 0; shift < WIDTH; shift++) {
        for (int i = 0; i < WIDTH && kernel[shift] > 0.0f; i++) {
            const float *const at = from + (i + shift) % WIDTH * STRIDE;
            for (int c = 0; c < 3; c++) {
                sums[i * STRIDE + c] += kernel[shift] * at[c];
            }
            sums[i * STRIDE + 3] += kernel[shift];
        }
    }
}

static void blur_row(void *user, size_t j, size_t worker)
{
    const blurring *const self = user;
    float sums[WIDTH * STRIDE] = {0.0f}, kernel[WIDTH];
    (void)worker;
    for (size_t from = 0; from < HEIGHT; from++) {
        if (row_kernel(self, j, from, kernel)) {
            add_row(self->from + from * WIDTH * STRIDE, kernel, sums);
        }
    }
    for (size_t i = 0; i < WIDTH * STRIDE; i++) {
        const size_t place = j * WIDTH * STRIDE + i;
        const float weight = sums[i / STRIDE * STRIDE + 3];
        self->out[place] = weight > 0.0f ? sums[i] / weight : self->from[place];
    }
}

/* What the blur depends on beside the picture. */
static uint64_t blur_key(air_phase phase, double share)
{
    uint64_t key = air_fingerprint_add((uint64_t)phase.kind, &share, sizeof share);
    key = air_fingerprint_add(key, &phase.g, sizeof phase.g);
    if (phase.kind == AIR_PHASE_MIXTURE) {
        for (size_t i = 0; i < phase.mixture->lobe_count; i++) {
            const air_phase_lobe *const lobe = &phase.mixture->lobes[i];
            key = air_fingerprint_add(key, lobe, sizeof *lobe);
        }
    }
    return key;
}

static air_status blur_map(air_context *context, const air_light *light, air_phase phase,
                           double share, float *out)
{
    float *const small = air_allocate(context, HEIGHT * WIDTH * STRIDE, sizeof *small);
    if (small == NULL) {
        return air_fail_memory(context, "ordinates: sky");
    }
    shrink(light, small);
    blurring blur = {phase, air_seen_cap(phase, 1.0f, share), small, out};
    air_parallel_for(context, HEIGHT, blur_row, &blur);
    air_free(context, small);
    return AIR_OK;
}

static air_status make_map(ord_sky *sky, const air_light *light, air_phase phase, double share,
                           ord_past *past)
{
    enum { NUMBERS = HEIGHT * WIDTH * STRIDE };
    ord_sky_map *const map = &sky->maps[sky->count++];
    map->light = light;
    if (light->environment == NULL) {
        return AIR_OK;
    }
    map->radiance = air_allocate(sky->context, NUMBERS, sizeof *map->radiance);
    if (map->radiance == NULL) {
        return air_fail_memory(sky->context, "ordinates: sky");
    }
    if (past == NULL) {
        return blur_map(sky->context, light, phase, share, map->radiance);
    }
    air_environment_map values;
    ord_environment_map(light, &values);
    const uint64_t key = ord_past_sky_key(&values), blur = blur_key(phase, share);
    if (ord_past_blurred_sky(past, key, blur, map->radiance, NUMBERS)) {
        return AIR_OK;
    }
    const air_status status = blur_map(sky->context, light, phase, share, map->radiance);
    if (status == AIR_OK) {
        ord_past_keep_blurred_sky(past, key, blur, map->radiance, NUMBERS);
    }
    return status;
}

air_status ord_sky_make(const air_snapshot *snapshot, const air_owner_table *owners,
                        air_phase phase, double share, ord_past *past, ord_sky *out)
{
    const air_light_table *const lights = &snapshot->lights;
    memset(out, 0, sizeof *out);
    out->context = snapshot->context;
    out->maps = air_allocate(out->context, lights->explicit_count, sizeof *out->maps);
    air_status status =
        out->maps != NULL ? AIR_OK : air_fail_memory(out->context, "ordinates: sky");
    for (size_t i = 0; i < lights->explicit_count && status == AIR_OK; i++) {
        if (lights->entries[i].kind == AIR_LIGHT_ENVIRONMENT &&
            air_owner_table_uses(owners, i, AIR_METHOD_ORDINATES) &&
            owners->modes[i] == AIR_ORDINATES_MODE_DOM) {
            status = make_map(out, &lights->entries[i], phase, share, past);
        }
    }
    if (status != AIR_OK) {
        ord_sky_finish(out);
    }
    return status;
}

void ord_sky_finish(ord_sky *sky)
{
    for (size_t i = 0; i < sky->count; i++) {
        air_free(sky->context, sky->maps[i].radiance);
    }
    air_free(sky->context, sky->maps);
    memset(sky, 0, sizeof *sky);
}

/* ---- look-up ---- */

static air_vec3 texel(const float *map, long i, long j)
{
    const size_t column = (size_t)((i + WIDTH) % WIDTH);
    const size_t row = (size_t)(j < 0 ? 0 : j >= HEIGHT ? HEIGHT - 1 : j);
    return vec3_load(map + (row * WIDTH + column) * STRIDE);
}

static air_vec3 mix(air_vec3 a, air_vec3 b, float share)
{
    return vec3_madd(a, share, vec3_sub(b, a));
}

static air_vec3 map_radiance(const ord_sky_map *map, air_vec3 dir)
{
    if (map->radiance == NULL) {
        return map->light->color;
    }
    const float *const m = map->light->environment->to_world;
    const air_vec3 d =
        vec3(m[0] * dir.x + m[3] * dir.y + m[6] * dir.z, m[1] * dir.x + m[4] * dir.y + m[7] * dir.z,
             m[2] * dir.x + m[5] * dir.y + m[8] * dir.z);
    const float u = 0.5f + atan2f(d.x, -d.z) / (2.0f * AIR_PI_F);
    const float v = acosf(float_min(float_max(d.y, -1.0f), 1.0f)) / AIR_PI_F;
    const float x = u * WIDTH - 0.5f, y = v * HEIGHT - 0.5f;
    const long i = (long)floorf(x), j = (long)floorf(y);
    const float share_x = x - (float)i, share_y = y - (float)j;
    return mix(mix(texel(map->radiance, i, j), texel(map->radiance, i + 1, j), share_x),
               mix(texel(map->radiance, i, j + 1), texel(map->radiance, i + 1, j + 1), share_x),
               share_y);
}

air_vec3 ord_sky_radiance(const ord_sky *sky, air_vec3 dir)
{
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < sky->count; i++) {
        sum = vec3_add(sum, map_radiance(&sky->maps[i], dir));
    }
    return sum;
}

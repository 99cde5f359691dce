/* punctual.c: see punctual.h. */
#include "scene/lights/punctual.h"

#include "airlight/collimated.h"
#include "scene/texture.h"

/* ---- spot ---- */

void air_spot_set_cone(air_light *light, air_spot_shape falloff, double inner_cone_rad,
                       double outer_cone_rad)
{
    light->falloff = falloff;
    if (falloff == AIR_SPOT_ANGLE) {
        light->spot_scale = (float)(-1.0 / (outer_cone_rad - inner_cone_rad));
        light->spot_offset = (float)(outer_cone_rad / (outer_cone_rad - inner_cone_rad));
        return;
    }
    /* KHR_lights_punctual: the difference of the cosines is kept from becoming 0 */
    const double scale = 1.0 / fmax(0.001, cos(inner_cone_rad) - cos(outer_cone_rad));
    light->spot_scale = (float)scale;
    light->spot_offset = (float)(-cos(outer_cone_rad) * scale);
}

float air_spot_falloff(const air_light *light, float cosine)
{
    if (light->falloff == AIR_SPOT_ANGLE) {
        const float angle = acosf(fminf(fmaxf(cosine, -1.0f), 1.0f));
        return fminf(fmaxf(angle * light->spot_scale + light->spot_offset, 0.0f), 1.0f);
    }
    const float x = fminf(fmaxf(cosine * light->spot_scale + light->spot_offset, 0.0f), 1.0f);
    return x * x;
}

/* The inner and outer angle of a falloff that is linear between them. */
static void linear_angles(const air_light *light, double *inner, double *outer)
{
    const double width = -1.0 / (double)light->spot_scale;
    *outer = (double)light->spot_offset * width;
    *inner = fmax(*outer - width, 0.0);
}

float air_spot_opening(const air_light *light)
{
    if (light->falloff == AIR_SPOT_ANGLE) {
        double inner, outer;
        linear_angles(light, &inner, &outer);
        const double half = sin(0.5 * outer);
        return (float)(2.0 * half * half);
    }
    return float_min(float_max(1.0f + light->spot_offset / light->spot_scale, 1e-7f), 2.0f);
}

double air_spot_solid_angle(const air_light *light)
{
    if (light->falloff == AIR_SPOT_ANGLE) {
        double inner, outer;
        linear_angles(light, &inner, &outer);
        /* by parts: 1 - the mean of the cosine between the angles */
        return 2.0 * AIR_PI * (1.0 - (sin(outer) - sin(inner)) / (outer - inner));
    }
    /* the square of a number that rises by 1 while the cosine rises by `rise` from `outer` */
    const double rise = 1.0 / (double)light->spot_scale;
    const double outer = -(double)light->spot_offset * rise;
    const double reached = fmin(1.0, (1.0 - outer) / rise);
    return 2.0 * AIR_PI *
           (rise / 3.0 * reached * reached * reached + fmax(0.0, 1.0 - outer - rise));
}

/* ---- projector ---- */

void air_projector_set(air_light *light, const air_light_desc *desc,
                       const struct air_texture *image)
{
    const float *m = desc->to_world;
    light->position = vec3_load(desc->position);
    light->frame =
        (air_frame){vec3(m[0], m[3], m[6]), vec3(m[1], m[4], m[7]), vec3(m[2], m[5], m[8])};
    light->emission_texture = image;
    light->tan_half[0] = tanf(0.5f * desc->fov_x_rad);
    light->tan_half[1] =
        light->tan_half[0] * (image != NULL ? (float)image->height / (float)image->width : 1.0f);
}

/* Of the centres of the outermost texels a border goes on outwards, whatever the texture's wrap. */
static float clamp_to_centers(float x, size_t texels)
{
    const float half = 0.5f / (float)texels;
    return float_min(float_max(x, half), 1.0f - half);
}

air_vec3 air_projector_share(const air_light *light, air_vec3 dir)
{
    const air_vec3 local = frame_to_local(&light->frame, dir);
    const float cosine = -local.z;
    if (!(cosine > 0.0f)) {
        return vec3_set1(0.0f);
    }
    const float x = local.x / (cosine * light->tan_half[0]);
    const float y = local.y / (cosine * light->tan_half[1]);
    if (!(fabsf(x) <= 1.0f && fabsf(y) <= 1.0f)) {
        return vec3_set1(0.0f);
    }
    const struct air_texture *image = light->emission_texture;
    const air_vec3 value =
        image == NULL ? vec3_set1(1.0f)
                      : air_texture_rgb(image, clamp_to_centers(0.5f + 0.5f * x, image->width),
                                        clamp_to_centers(0.5f - 0.5f * y, image->height));
    return vec3_scale(value, 1.0f / (cosine * cosine * cosine));
}

/* dw = cos^3 dA on the screen at the distance 1. */
air_vec3 air_projector_solid_angle(const air_light *light)
{
    static const float corners[2][3][2] = {{{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}},
                                           {{0.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}};
    air_vec3 mean = vec3_set1(1.0f);
    if (light->emission_texture != NULL) {
        mean = vec3_scale(vec3_add(air_texture_triangle_mean(light->emission_texture, corners[0]),
                                   air_texture_triangle_mean(light->emission_texture, corners[1])),
                          0.5f);
    }
    return vec3_scale(mean, 4.0f * light->tan_half[0] * light->tan_half[1]);
}

/* ---- windows of collimated lights ---- */

static double dot64(air_vec3 a, air_vec3 b)
{
    return (double)a.x * (double)b.x + (double)a.y * (double)b.y + (double)a.z * (double)b.z;
}

air_status air_windows_build(air_context *context, const air_gobo_window *windows, size_t count,
                             air_light *light)
{
    size_t total = 0;
    for (size_t i = 0; i < count; i++) {
        total += windows[i].vertex_count;
    }
    light->windows = air_allocate(context, 2 * total, sizeof *light->windows);
    light->window_ends = air_allocate(context, count, sizeof *light->window_ends);
    if (light->windows == NULL || light->window_ends == NULL) {
        return air_fail_memory(context, "collimated light");
    }
    light->window_count = count;
    size_t next = 0;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < windows[i].vertex_count; k++, next++) {
            const air_vec3 v = vec3_load(windows[i].vertices + 3 * k);
            light->windows[2 * next] = dot64(v, light->frame.s);
            light->windows[2 * next + 1] = dot64(v, light->frame.t);
        }
        light->window_ends[i] = next;
    }
    return AIR_OK;
}

void air_windows_finish(air_context *context, air_light *light)
{
    air_free(context, light->window_ends);
    air_free(context, light->windows);
}

double air_windows_area(const air_light *light)
{
    double sum = 0.0;
    size_t begin = 0;
    for (size_t i = 0; i < light->window_count; i++) {
        const size_t end = light->window_ends[i];
        double area = 0.0;
        for (size_t k = begin; k < end; k++) {
            const double *a = light->windows + 2 * k;
            const double *b = light->windows + 2 * (k + 1 < end ? k + 1 : begin);
            area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
        }
        sum += fabs(area);
        begin = end;
    }
    return sum;
}

/* Even-odd rule: how often does the half-line to the right of (x, y) cross the edges? */
static bool inside(const double *vertices, size_t count, double x, double y)
{
    bool odd = false;
    const double *a = vertices + 2 * (count - 1);
    for (size_t i = 0; i < count; i++) {
        const double *b = vertices + 2 * i;
        if ((a[1] > y) != (b[1] > y)) {
            const double cross = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
            if ((cross > 0.0) == (b[1] > a[1])) {
                odd = !odd;
            }
        }
        a = b;
    }
    return odd;
}

bool air_light_in_windows(const air_light *light, air_vec3 point)
{
    if (light->window_count == 0) {
        return true;
    }
    const double x = dot64(point, light->frame.s), y = dot64(point, light->frame.t);
    size_t begin = 0;
    for (size_t i = 0; i < light->window_count; i++) {
        const size_t end = light->window_ends[i];
        if (inside(light->windows + 2 * begin, end - begin, x, y)) {
            return true;
        }
        begin = end;
    }
    return false;
}

size_t air_light_window_limit(const air_light *light)
{
    size_t limit = 0, begin = 0;
    for (size_t i = 0; i < light->window_count; i++) {
        limit += (light->window_ends[i] - begin) / 2 + 1;
        begin = light->window_ends[i];
    }
    return limit;
}

size_t air_light_open_stretches(const air_light *light, const double origin[3], const double dir[3],
                                air_interval *out)
{
    double axis_s[3], axis_t[3];
    vec3_store64(axis_s, light->frame.s);
    vec3_store64(axis_t, light->frame.t);
    size_t count = 0, begin = 0;
    for (size_t i = 0; i < light->window_count; i++) {
        const size_t end = light->window_ends[i];
        count += air_collimated_window(light->windows + 2 * begin, end - begin, axis_s, axis_t,
                                       origin, dir, 0.0, INFINITY, out + count);
        begin = end;
    }
    return air_intervals_join(out, count);
}

/* ---- sampling ---- */

void air_punctual_sample(const air_light *light, air_light_point *out)
{
    out->delta = true;
    out->position = light->position;
    out->infinite = light->kind == AIR_LIGHT_COLLIMATED;
    out->dir = vec3_neg(light->dir);
    out->value = light->color;
    out->pdf = 1.0f;
}

bool air_punctual_connect(const air_light *light, air_vec3 point, air_connection *out)
{
    const air_vec3 to_light = vec3_sub(light->position, point);
    const float distance2 = vec3_dot(to_light, to_light);
    if (!(distance2 > 0.0f)) {
        return false;
    }
    const float distance = sqrtf(distance2);
    out->dir = vec3_scale(to_light, 1.0f / distance);
    out->distance = distance;
    out->pdf = 1.0f;
    if (light->kind == AIR_LIGHT_PROJECTOR) {
        const air_vec3 share = air_projector_share(light, vec3_neg(out->dir));
        out->incident = vec3_scale(vec3_mul(light->color, share), 1.0f / distance2);
        return !vec3_is_zero(share);
    }
    float share = 1.0f;
    if (light->kind == AIR_LIGHT_SPOT) {
        share = air_spot_falloff(light, -vec3_dot(out->dir, light->dir));
    }
    out->incident = vec3_scale(light->color, share / distance2);
    return share > 0.0f;
}

bool air_collimated_connect(const air_light *light, air_vec3 point, air_connection *out)
{
    out->dir = vec3_neg(light->dir);
    out->distance = INFINITY;
    out->incident = light->color;
    out->pdf = 1.0f;
    return air_light_in_windows(light, point);
}

/* through.c: light by one event in media between a light and a receiver.
 *
 * Along directions drawn by the receiver's cosine this light has infinite variance: about a lamp it
 * rises as one over the angle. In the plane through receiver, event and a light's point at the
 * distance D, the angle theta at the receiver between event and light, and the angle v by which
 * light turns in the event, take the two squared distances away: dV / (t^2 r^2) = dphi dtheta dv /
 * D. For lights at infinity the direction is drawn by cosine or phase function, and the distance by
 * what the light sends along it. */
#include <float.h>

#include "core/phase.h"
#include "core/warp.h"
#include "path/aim.h"
#include "path/vertex.h"

/* ---- how far light turns ---- */

/* Densities h of (theta, v) in the triangle 0 < theta < v < pi: even, and for media that scatter
 * forward in part as 1 / (a^2 + v^2)^(3/2), which follows Henyey and Greenstein's lobe with a = (1
 * - g) / sqrt(g). Its integral over v is q(v) = v / sqrt(a^2 + v^2), but for a factor. */
typedef struct turn {
    float even, lobe; /* factors of the two densities */
    float a, share;   /* share: of points drawn by the lobe */
} turn;

static turn turn_make(const air_path *path)
{
    const float plain = 2.0f / (AIR_PI_F * AIR_PI_F);
    float g = 0.0f;
    for (size_t i = 0; i < path->media->count; i++) {
        g = float_max(g, phase_mean_cosine(path->media->media[i].phase));
    }
    if (g < 0.2f) {
        return (turn){plain, 0.0f, 1.0f, 0.0f};
    }
    const float a = (1.0f - g) / sqrtf(g), share = 0.75f;
    const float whole = 1.0f / a - 1.0f / sqrtf(a * a + AIR_PI_F * AIR_PI_F);
    return (turn){(1.0f - share) * plain, share / whole, a, share};
}

static float turn_lobe_integral(const turn *t, float v)
{
    return v / (t->a * t->a * sqrtf(t->a * t->a + v * v));
}

/* u in [0, 1) twice: theta, which is even below a v drawn by v h. */
static float turn_sample_theta(const turn *t, float u, float below)
{
    if (u < t->share) {
        const float y = 1.0f / t->a - u / t->lobe;
        return below * sqrtf(float_max(1.0f / (y * y) - t->a * t->a, 0.0f));
    }
    return below * AIR_PI_F * sqrtf((u - t->share) / (1.0f - t->share));
}

/* Over theta, of points drawn as above. */
static float turn_theta_density(const turn *t, float theta)
{
    return t->even * (AIR_PI_F - theta) +
           t->lobe * (turn_lobe_integral(t, AIR_PI_F) - turn_lobe_integral(t, theta));
}

/* v between two bounds, in proportion to h, and the density over v. */
static float turn_sample_v(const turn *t, float u, float v0, float v1, float *out_density)
{
    const float q0 = turn_lobe_integral(t, v0), q1 = turn_lobe_integral(t, v1);
    const float even = t->even * (v1 - v0), lobe = t->lobe * (q1 - q0), at = u * (even + lobe);
    float v;
    if (at < lobe) {
        const float w = (q0 + (q1 - q0) * at / lobe) * t->a * t->a;
        v = t->a * w / sqrtf(float_max(1.0f - w * w, 1e-9f));
    } else {
        v = v0 + (v1 - v0) * (at - lobe) / even;
    }
    v = float_min(float_max(v, v0), v1);
    const float d2 = t->a * t->a + v * v;
    const float h = t->even + (t->lobe > 0.0f ? t->lobe / (d2 * sqrtf(d2)) : 0.0f);
    *out_density = h / (even + lobe);
    return v;
}

/* ---- lamps: both distances from two angles ---- */

/* The way over an event: out along dir from the receiver to t, on to a light. */
typedef struct detour {
    air_vec3 dir;
    float t, r;
    float weight; /* 1 over the density of the event, with 1 / (t^2 r^2) taken away */
} detour;

/* How light turns that goes over a distance t along theta. */
static float turn_at(float theta, float t, float distance)
{
    return theta + atan2f(t * sinf(theta), distance - t * cosf(theta));
}

static float distance_at(float theta, float v, float distance)
{
    return distance * sinf(v - theta) / sinf(v);
}

/* How much a place on the ray scatters; grey. */
static float scattering_at(const air_ray_media *media, float t)
{
    const size_t segment = air_ray_media_find(media, t);
    return segment == media->count
               ? 0.0f
               : vec3_mean(air_ray_media_coefficients(media, &media->segments[segment], t).sigma_s);
}

/* v between v0 and v1. Where density varies, one of some candidates, in proportion to what the
 * places scatter [Talbot2005]. *out_density 0: none scatters. */
static float draw_turn(const turn *lobe, const air_ray_media *media, float theta, float distance,
                       float v0, float v1, float u, float *out_density)
{
    enum { CANDIDATES = 8 };
    float v[CANDIDATES], amounts[CANDIDATES], weights[CANDIDATES], sum = 0.0f;
    if (media->closed) {
        return turn_sample_v(lobe, u, v0, v1, out_density);
    }
    for (int i = 0; i < CANDIDATES; i++) {
        float density;
        v[i] = turn_sample_v(lobe, ((float)i + u) / CANDIDATES, v0, v1, &density);
        amounts[i] = scattering_at(media, distance_at(theta, v[i], distance));
        weights[i] = amounts[i] / density;
        sum += weights[i];
    }
    /* a second number from the first: its low bits are as good */
    float rest = air_uint_to_float(air_hash32((uint32_t)(u * 0x1p24f))) * sum;
    int chosen = 0;
    while (chosen + 1 < CANDIDATES && rest >= weights[chosen]) {
        rest -= weights[chosen++];
    }
    *out_density = sum > 0.0f ? amounts[chosen] * CANDIDATES / sum : 0.0f;
    return v[chosen];
}

/* A direction by theta and phi about the light's, or towards media. *out_theta: from the light's;
 * *out_density: over theta and phi. */
static air_vec3 detour_dir(const turn *lobe, const air_aim *aim, air_vec3 to_light, air_f32x4 u,
                           float *out_theta, float *out_density)
{
    air_vec3 dir;
    if (u[0] < aim->share) {
        const float at[3] = {u[0] / aim->share, u[1], u[2]};
        dir = air_aim_sample(aim, at);
        *out_theta = atan2f(vec3_length(vec3_cross(to_light, dir)), vec3_dot(to_light, dir));
    } else {
        const air_frame frame = frame_from_normal(to_light);
        const float first = (u[0] - aim->share) / (1.0f - aim->share);
        const float theta = turn_sample_theta(lobe, first, u[1]);
        const float phi = 2.0f * AIR_PI_F * u[2], s = sinf(theta);
        dir = frame_to_world(&frame, vec3(s * cosf(phi), s * sinf(phi), cosf(theta)));
        *out_theta = theta;
    }
    *out_density = (1.0f - aim->share) * turn_theta_density(lobe, *out_theta) / (2.0f * AIR_PI_F) +
                   aim->share * air_aim_sample_pdf(aim, dir) * sinf(*out_theta);
    return dir;
}

/* A way over a place in media: a direction, and then v between where media begin and end along this
 * ray, which is left in *media. False if no light comes that way. */
static bool detour_make(const air_path *path, const air_path_receiver *receiver, air_vec3 from,
                        air_vec3 towards, air_f32x4 u, air_ray_media *media, detour *out)
{
    const turn lobe = turn_make(path);
    const air_aim aim = air_aim_make(path->media, from);
    const float distance = vec3_length(towards);
    float theta, density, density_v;
    if (!(distance > 0.0f)) {
        return false;
    }
    out->dir = detour_dir(&lobe, &aim, vec3_scale(towards, 1.0f / distance), u, &theta, &density);
    if (!(air_receiver_sample_pdf(receiver, out->dir) > 0.0f)) {
        return false;
    }
    air_ray_media_make(media, path->media, from, out->dir, INFINITY);
    if (media->count == 0) {
        return false;
    }
    const float v0 = turn_at(theta, media->segments[0].t0, distance);
    const float v1 =
        float_min(turn_at(theta, media->segments[media->count - 1].t1, distance), AIR_PI_F);
    if (!(v1 > v0)) {
        return false;
    }
    const float v = draw_turn(&lobe, media, theta, distance, v0, v1, u[3], &density_v);
    const float sine = sinf(v);
    out->t = distance_at(theta, v, distance);
    out->r = distance * sinf(theta) / sine;
    out->weight = 1.0f / (density * density_v * distance);
    return sine > 1e-6f && density_v > 0.0f && out->t > 0.0f && out->t < 1e6f * distance;
}

/* Makes the event; false if no medium is there. The transmittance on the way multiplies *value
 * where it is closed. */
static bool make_event(const air_ray_media *media, const path_vertex *vertex, const detour *way,
                       path_vertex *event, bool *out_tracked, air_vec3 *value)
{
    const size_t segment = air_ray_media_find(media, way->t);
    if (segment == media->count) {
        return false;
    }
    event->walk = path_event_walk(&vertex->walk);
    event->on_surface = false;
    event->wo = vec3_neg(way->dir);
    event->at.medium.position = vec3_madd(vertex->at.surface.position, way->t, way->dir);
    event->at.medium.regions = media->segments[segment].regions;
    *out_tracked = !media->closed;
    if (media->closed) {
        const air_vec3 depth =
            air_ray_media_segment_depth(media, &media->segments[segment], way->t);
        *value = vec3_mul(*value, vec3_exp(vec3_neg(depth)));
    }
    return true;
}

/* Queues the two parts of the way from the receiver to the light. */
static void queue_pair(const air_path *path, air_path_scratch *scratch, const path_vertex *vertex,
                       const path_vertex *event, const detour *way, bool tracked,
                       const air_light_point *light, const air_connection *connection,
                       air_vec3 value)
{
    const air_vec3 origin = air_surface_origin(&vertex->at.surface, way->dir);
    const path_shadow both = {.lane = vertex->walk.lane, .target = PATH_THROUGH};
    path_shadow parts[2] = {both, both};
    air_ray rays[2] = {{{origin.x, origin.y, origin.z},
                        0.0f,
                        {way->dir.x, way->dir.y, way->dir.z},
                        way->t,
                        AIR_MASK_SHADOW_OPAQUE},
                       path_shadow_ray(event, connection, light)};
    parts[0].stream = 0x70000u;
    parts[0].late = tracked;
    parts[0].paired = true;
    parts[0].distance = way->t;
    parts[1].stream = 0x70001u;
    parts[1].distance = connection->distance;
    parts[1].late = !path_attenuate(path, scratch, &rays[1], connection->distance, &value);
    parts[0].value = value;
    if (vec3_is_zero(value)) {
        return;
    }
    if (!path->snapshot->lights.entries[light->entry].casts_shadow) {
        rays[1].mask = 0;
    }
    for (int i = 0; i < 2; i++) {
        scratch->shadows[scratch->shadow_count] = parts[i];
        scratch->shadow_rays[scratch->shadow_count++] = rays[i];
    }
}

static void ask_lamp(const air_path *path, air_path_scratch *scratch, air_path_lane *lane,
                     const path_vertex *vertex)
{
    const air_light_table *lights = path_lights(path, 2, false);
    const air_light_point *light = &lane->through_light;
    const air_vec3 from = vertex->at.surface.position, towards = vec3_sub(light->position, from);
    const air_f32x4 u = air_sampler_get(&lane->sampler, path_through_set(&vertex->walk));
    detour way;
    path_vertex event;
    air_connection connection;
    bool tracked;
    if (!detour_make(path, lane->receiver, from, towards, u, &scratch->media, &way)) {
        return;
    }
    air_vec3 value = vec3_set1(lane->through_weight * way.weight / lane->through_probability);
    if (!make_event(&scratch->media, vertex, &way, &event, &tracked, &value) ||
        !air_light_connect(lights, light, event.at.medium.position, &connection)) {
        return;
    }
    path_mixture mixture;
    path_mixture_make(path, &event, &mixture);
    const uint32_t owner = lights->entries[light->entry].owner;
    const air_vec3 scattered =
        path_mixture_eval(path, &event, &mixture, connection.dir, owner, NULL);
    const air_vec3 intensity = vec3_scale(connection.incident, way.r * way.r / connection.pdf);
    value = vec3_mul(vec3_mul(value, scattered), intensity);
    lane->through_dir = way.dir;
    if (!vec3_is_zero(value)) {
        queue_pair(path, scratch, vertex, &event, &way, tracked, light, &connection, value);
    }
}

/* ---- lights at infinity: a ray that looks how far the medium reaches ---- */

/* The share of directions drawn by phase functions about the light, of those not aimed. */
#define PHASE_SHARE 0.5f

static float sky_pdf(const air_path *path, const air_path_receiver *receiver, const air_aim *aim,
                     air_vec3 to_light, air_vec3 dir)
{
    const float count = (float)path->media->count, cosine = vec3_dot(to_light, dir);
    const float plain = air_receiver_sample_pdf(receiver, dir);
    float phase = 0.0f;
    for (size_t i = 0; i < path->media->count; i++) {
        phase += phase_eval(path->media->media[i].phase, cosine) / count;
    }
    const float rest = (1.0f - PHASE_SHARE) * plain + PHASE_SHARE * phase;
    return plain > 0.0f ? (1.0f - aim->share) * rest + aim->share * air_aim_sample_pdf(aim, dir)
                        : 0.0f;
}

static air_vec3 sky_sample(const air_path *path, const air_path_receiver *receiver,
                           const air_aim *aim, air_vec3 to_light, air_f32x4 u)
{
    const size_t count = path->media->count;
    air_vec3 dir;
    float pdf;
    if (u[2] < aim->share) {
        const float at[3] = {u[2] / aim->share, u[0], u[1]};
        return air_aim_sample(aim, at);
    }
    u[2] = (u[2] - aim->share) / (1.0f - aim->share);
    if (u[2] >= PHASE_SHARE) {
        u[2] = (u[2] - PHASE_SHARE) / (1.0f - PHASE_SHARE);
        (void)air_receiver_sample(receiver, u, &dir, &pdf);
        return dir;
    }
    const size_t medium = (size_t)(u[2] / PHASE_SHARE * (float)count);
    const air_phase phase = path->media->media[medium < count ? medium : count - 1].phase;
    return air_phase_sample(phase, to_light, u[0], u[1], &pdf);
}

static void ask_sky(const air_path *path, air_path_scratch *scratch, air_path_lane *lane,
                    const path_vertex *vertex)
{
    const air_vec3 to_light = lane->through_light.dir;
    const air_f32x4 u = air_sampler_get(&lane->sampler, path_through_set(&vertex->walk));
    const air_aim aim = air_aim_make(path->media, vertex->at.surface.position);
    const air_vec3 dir = sky_sample(path, lane->receiver, &aim, to_light, u);
    const float pdf = sky_pdf(path, lane->receiver, &aim, to_light, dir);
    if (!(pdf > 0.0f)) {
        return;
    }
    lane->through_dir = dir;
    const air_vec3 origin = air_surface_origin(&vertex->at.surface, dir);
    const size_t i = scratch->walk_count++;
    scratch->walks[i] = vertex->walk;
    scratch->walks[i].through = true;
    scratch->walks[i].beta = vec3_set1(lane->through_weight / pdf);
    scratch->rays[i] = (air_ray){
        {origin.x, origin.y, origin.z}, 0.0f, {dir.x, dir.y, dir.z}, FLT_MAX, AIR_MASK_SCATTER};
}

void path_ask_through(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                      const path_vertex *vertex)
{
    air_path_lane *lane = &lanes[vertex->walk.lane];
    const path_walk event = path_event_walk(&vertex->walk);
    if (path->media->count == 0 || path->settings.max_depth < 2 || lane->through_weight == 0.0f ||
        path_lights(path, 2, false)->count == 0) {
        return;
    }
    path_draw_light(path, path_lights(path, 2, false), lane, &event, NULL, &lane->through_light,
                    &lane->through_probability);
    if (lane->through_light.infinite) {
        ask_sky(path, scratch, lane, vertex);
    } else {
        ask_lamp(path, scratch, lane, vertex);
    }
}

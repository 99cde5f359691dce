#include "path/distance.h"

#include "core/angle.h"
#include "core/exponential.h"

/* Normalised throughput: the probabilities of the three channels. */
static air_vec3 channel_shares(const air_ray_media *ray, air_vec3 throughput)
{
    if (ray->grey) {
        return vec3(1.0f, 0.0f, 0.0f);
    }
    const air_vec3 positive =
        vec3(ray->depth.x > 0.0f ? throughput.x : 0.0f, ray->depth.y > 0.0f ? throughput.y : 0.0f,
             ray->depth.z > 0.0f ? throughput.z : 0.0f);
    const float sum = positive.x + positive.y + positive.z;
    if (!(sum > 0.0f)) {
        return vec3_set1(1.0f / 3.0f);
    }
    return vec3_scale(positive, 1.0f / sum);
}

float air_distance_event_probability(const air_ray_media *ray, air_vec3 throughput)
{
    const float sum = throughput.x + throughput.y + throughput.z;
    return ray->grey || !(sum > 0.0f) ? vec3_min(ray->loss) : vec3_dot(throughput, ray->loss) / sum;
}

/* The equi-angular variable over the stretch of the ray that holds media. */
typedef struct equiangular {
    float delta, distance; /* foot of the light on the ray, distance from it */
    float start;           /* where the stretch begins, from the foot */
    float angle;           /* that the light sees of it */
} equiangular;

static bool equiangular_make(const air_ray_media *ray, air_vec3 light, equiangular *out)
{
    const float begin = ray->segments[0].t0, end = ray->segments[ray->count - 1].t1;
    const air_vec3 to_light = vec3_sub(light, ray->origin);
    out->delta = vec3_dot(to_light, ray->dir);
    out->distance = vec3_length(vec3_madd(to_light, -out->delta, ray->dir));
    if (!(out->distance > 1e-6f * (fabsf(out->delta) + 1e-6f))) {
        return false;
    }
    out->start = begin - out->delta;
    /* the angle between the ways to both ends, over the distance; 1e12 is as good as infinite */
    const float inverse = 1.0f / out->distance, most = 1e12f;
    const float a = out->start * inverse, b = float_min((end - out->delta) * inverse, most);
    out->angle =
        air_plane_angle(1.0f + a * b, float_max(float_min((end - begin) * inverse, most), 0.0f));
    return out->angle > 0.0f;
}

static float equiangular_pdf(const equiangular *e, float t)
{
    const float x = t - e->delta;
    return e->distance / (e->angle * (e->distance * e->distance + x * x));
}

/* The way to the beginning, turned. */
static float equiangular_sample(const equiangular *e, float u)
{
    float s, c;
    air_sincos_turn(u * e->angle * (0.5f / AIR_PI_F), &s, &c);
    return e->delta +
           e->distance * (e->start * c + e->distance * s) / (e->distance * c - e->start * s);
}

/* Density by extinction at t, to which this transmittance is left; grey rays only. */
static float grey_extinction_pdf(const air_ray_media *ray, size_t segment, float t,
                                 float transmittance)
{
    const float sigma_t = air_ray_media_coefficients(ray, &ray->segments[segment], t).sigma_t.x;
    return sigma_t * transmittance / ray->loss.x;
}

/* Density by extinction; also gives the transmittance to t. */
static float extinction_pdf(const air_ray_media *ray, air_vec3 shares, size_t segment, float t,
                            air_vec3 *transmittance)
{
    const air_ray_segment *s = &ray->segments[segment];
    const air_vec3 depth = air_ray_media_segment_depth(ray, s, t);
    if (ray->grey) {
        *transmittance = vec3_set1(air_exp(-depth.x));
        return grey_extinction_pdf(ray, segment, t, transmittance->x);
    }
    const air_vec3 sigma_t = air_ray_media_coefficients(ray, s, t).sigma_t;
    *transmittance = vec3(air_exp(-depth.x), air_exp(-depth.y), air_exp(-depth.z));
    float pdf = 0.0f;
    for (int c = 0; c < 3; c++) {
        if (air_channel(shares, c) > 0.0f) {
            pdf += air_channel(shares, c) * air_channel(sigma_t, c) *
                   air_channel(*transmittance, c) / air_channel(ray->loss, c);
        }
    }
    return pdf;
}

/* A place drawn by extinction, with its density and the transmittance to it. */
static float sample_extinction(const air_ray_media *ray, air_vec3 shares, float u,
                               air_distance *out, air_vec3 *transmittance)
{
    int channel = 0;
    if (ray->grey) {
        const float lost = u * ray->loss.x;
        out->t = air_ray_media_invert(ray, 0, air_neg_log1m(lost), &out->segment);
        *transmittance = vec3_set1(1.0f - lost);
        return grey_extinction_pdf(ray, out->segment, out->t, 1.0f - lost);
    }
    while (channel < 2 && u >= air_channel(shares, channel)) {
        u -= air_channel(shares, channel);
        channel++;
    }
    u = float_min(u / float_max(air_channel(shares, channel), 1e-20f), 1.0f - 0x1p-24f);
    const float depth = air_neg_log1m(u * air_channel(ray->loss, channel));
    out->t = air_ray_media_invert(ray, channel, depth, &out->segment);
    return extinction_pdf(ray, shares, out->segment, out->t, transmittance);
}

/* ---- both together ---- */

/* The guide, ready to be drawn from: nothing where its light lies on the ray. */
typedef struct guide_state {
    const air_distance_guide *guide;
    bool usable;
    equiangular angular;
} guide_state;

static guide_state guide_make(const air_ray_media *ray, const air_distance_guide *guide)
{
    guide_state state = {.guide = guide, .usable = guide != NULL};
    if (guide != NULL && guide->profile == NULL) {
        state.usable = equiangular_make(ray, *guide->point, &state.angular);
    }
    return state;
}

static float guide_pdf(const guide_state *state, float t)
{
    if (!state->usable) {
        return 0.0f;
    }
    return state->guide->profile != NULL
               ? (float)air_collimated_sample_pdf(state->guide->profile, (double)t)
               : equiangular_pdf(&state->angular, t);
}

static float guide_sample(const guide_state *state, float u)
{
    if (state->guide->profile != NULL) {
        return (float)air_collimated_sample(state->guide->profile, (double)u);
    }
    return equiangular_sample(&state->angular, u);
}

bool air_distance_sample(const air_ray_media *ray, air_vec3 throughput,
                         const air_distance_guide *guide, float u, air_distance *out)
{
    const air_vec3 shares = channel_shares(ray, throughput);
    const guide_state state = guide_make(ray, guide);
    const float share = guide != NULL ? guide->share : 0.0f;
    air_vec3 transmittance;
    float extinction;
    if (u < share) {
        if (!state.usable) {
            return false;
        }
        out->t = guide_sample(&state, u / share);
        out->segment = air_ray_media_find(ray, out->t);
        if (out->segment == ray->count) {
            return false;
        }
        extinction = extinction_pdf(ray, shares, out->segment, out->t, &transmittance);
    } else {
        extinction =
            sample_extinction(ray, shares, (u - share) / (1.0f - share), out, &transmittance);
    }
    const float pdf = share * guide_pdf(&state, out->t) + (1.0f - share) * extinction;
    if (!(pdf > 0.0f)) {
        return false;
    }
    out->weight = vec3_scale(transmittance, 1.0f / pdf);
    out->extinction_share = extinction / pdf;
    return true;
}

float air_distance_sample_pdf(const air_ray_media *ray, air_vec3 throughput,
                              const air_distance_guide *guide, float t)
{
    const size_t segment = air_ray_media_find(ray, t);
    const guide_state state = guide_make(ray, guide);
    const float share = guide != NULL ? guide->share : 0.0f;
    air_vec3 transmittance;
    const float extinction =
        segment == ray->count
            ? 0.0f
            : extinction_pdf(ray, channel_shares(ray, throughput), segment, t, &transmittance);
    return share * guide_pdf(&state, t) + (1.0f - share) * extinction;
}

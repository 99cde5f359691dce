#include "render/arealight/sample.h"

#include "core/phase.h"
#include "core/triple.h"

/* A point uniform in area: the fan's triangle by the first number, in it by what is left of it and
 * the second. */
static void sample_point(const area_lamp *lamp, double u, double v, double out[3])
{
    const air_area_lamp *shape = &lamp->shape;
    size_t i = 0;
    while (i + 3 < shape->vertex_count && u >= lamp->fan[i]) {
        i++;
    }
    const double before = i > 0 ? lamp->fan[i - 1] : 0.0;
    const double rest = fmin((u - before) / (lamp->fan[i] - before), 1.0);
    const double root = sqrt(rest), b1 = root * (1.0 - v), b2 = root * v;
    for (int k = 0; k < 3; k++) {
        out[k] = (1.0 - root) * shape->vertices[0][k] + b1 * shape->vertices[i + 1][k] +
                 b2 * shape->vertices[i + 2][k];
    }
}

/* From a point to the sampled one. */
typedef struct area_way {
    double wi[3]; /* unit, towards the lamp */
    double form;  /* cosine at the lamp over squared distance, times its area */
} area_way;

static bool make_way(const area_lamp *lamp, const area_sample *sample, area_way *out)
{
    for (int k = 0; k < 3; k++) {
        out->wi[k] = sample->source[k] - sample->point[k];
    }
    const double r2 = air_dot3(out->wi, out->wi), r = sqrt(r2);
    double cosine = -air_dot3(out->wi, lamp->shape.normal) / r;
    cosine = lamp->shape.two_sided ? fabs(cosine) : cosine;
    if (!(r > 0.0) || !(cosine > 0.0)) {
        return false;
    }
    for (int k = 0; k < 3; k++) {
        out->wi[k] /= r;
    }
    out->form = lamp->shape.area * cosine / r2;
    return true;
}

static air_vec3 radiance_times(const area_lamp *lamp, double factor)
{
    return vec3((float)((double)lamp->radiance.x * factor),
                (float)((double)lamp->radiance.y * factor),
                (float)((double)lamp->radiance.z * factor));
}

/* sigma_s p of all media at t, towards wi. */
static air_vec3 scatter(const air_with_arealight *with, const air_ray_segment *segment,
                        const double dir[3], const double wi[3])
{
    const air_media *media = &with->snapshot->media;
    const float cosine = (float)air_dot3(dir, wi);
    air_vec3 sum = vec3_set1(0.0f);
    for (uint64_t rest = segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(rest)];
        sum =
            vec3_madd(sum, phase_eval(media->media[region->medium].phase, cosine), region->sigma_s);
    }
    return sum;
}

/* What arrives at the camera from the sampled points, t along the ray, over the density. */
static void set_volume_value(const air_with_arealight *with, const air_ray_media *media,
                             const area_lamp *lamp, const area_ray *ray, double t, double pdf,
                             area_sample *out)
{
    area_way way;
    const size_t i = air_ray_media_find(media, (float)t);
    for (int k = 0; k < 3; k++) {
        out->point[k] = ray->origin[k] + t * ray->dir[k];
    }
    out->value = vec3_set1(0.0f);
    if (i == media->count || !make_way(lamp, out, &way)) {
        return;
    }
    const air_ray_segment *segment = &media->segments[i];
    const air_vec3 depth = air_ray_media_segment_depth(media, segment, (float)t);
    const air_vec3 through = vec3(expf(-depth.x), expf(-depth.y), expf(-depth.z));
    const air_vec3 scattered =
        vec3_mul(scatter(with, segment, ray->dir, way.wi), radiance_times(lamp, way.form / pdf));
    out->value = vec3_mul(vec3_mul(scattered, through),
                          air_area_transmittance(with, out->point, out->source));
}

area_sample air_area_sample_volume(const air_with_arealight *with, const air_area_scratch *scratch,
                                   const area_lamp *lamp, const area_ray *ray, const double u[3])
{
    const air_ray_media *media = &scratch->media;
    area_sample out = {.value = {0.0f, 0.0f, 0.0f}, .highlight = {0.0f, 0.0f, 0.0f}};
    air_interval lit;
    double pdf;
    if (media->count == 0) {
        return out;
    }
    const float last = media->segments[media->count - 1].t1;
    const double end = fmin(ray->t_max, last >= AIR_FAR ? INFINITY : (double)last);
    if (!air_area_lit_interval(&lamp->shape, ray->origin, ray->dir, end, &lit)) {
        return out;
    }
    lit.begin = fmax(lit.begin, (double)media->segments[0].t0);
    if (!(lit.begin < lit.end)) {
        return out;
    }
    const double t = air_area_sample_distance(&lamp->shape, ray->origin, ray->dir, lit, u[0], &pdf);
    sample_point(lamp, u[1], u[2], out.source);
    set_volume_value(with, media, lamp, ray, t, pdf, &out);
    return out;
}

area_sample air_area_sample_extinction(const air_with_arealight *with,
                                       const air_area_scratch *scratch, const area_lamp *lamp,
                                       const area_ray *ray, const double u[3])
{
    const air_ray_media *media = &scratch->media;
    area_sample out = {.value = {0.0f, 0.0f, 0.0f}, .highlight = {0.0f, 0.0f, 0.0f}};
    const float total = media->depth.y, share = -expm1f(-total);
    if (media->count == 0 || !(share > 0.0f)) {
        return out;
    }
    size_t segment;
    const float depth = fminf(-log1pf(-(float)u[0] * share), total * (1.0f - 1e-6f));
    const float t = air_ray_media_invert(media, 1, depth, &segment);
    const float sigma_t = air_ray_media_coefficients(media, &media->segments[segment], t).sigma_t.y;
    sample_point(lamp, u[1], u[2], out.source);
    set_volume_value(with, media, lamp, ray, (double)t, (double)(sigma_t * expf(-depth) / share),
                     &out);
    return out;
}

area_sample air_area_sample_surface(const air_with_arealight *with, const area_lamp *lamp,
                                    const area_ray *ray, const double u[2])
{
    area_sample out = {.value = {0.0f, 0.0f, 0.0f}, .highlight = {0.0f, 0.0f, 0.0f}};
    area_way way;
    vec3_store64(out.point, ray->surface->position);
    sample_point(lamp, u[0], u[1], out.source);
    if (!make_way(lamp, &out, &way)) {
        return out;
    }
    const air_vec3 wo = vec3((float)-ray->dir[0], (float)-ray->dir[1], (float)-ray->dir[2]);
    const air_vec3 wi = vec3((float)way.wi[0], (float)way.wi[1], (float)way.wi[2]);
    const air_bsdf *bsdf = &ray->surface->bsdf;
    air_vec3 smooth;
    const air_vec3 f = air_bsdf_eval_parts(bsdf, wo, wi, &smooth);
    if (vec3_is_zero(f)) {
        return out;
    }
    const air_vec3 light = vec3_mul(
        radiance_times(lamp, way.form),
        vec3_mul(ray->camera_transmittance, air_area_transmittance(with, out.point, out.source)));
    out.value = vec3_mul(smooth, light);
    const air_vec3 rest = vec3_sub(f, smooth); /* not below 0 but for rounding */
    out.highlight = vec3_mul(
        vec3(float_max(rest.x, 0.0f), float_max(rest.y, 0.0f), float_max(rest.z, 0.0f)), light);
    return out;
}

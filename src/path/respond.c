/* respond.c: light that media scatter along the segments of surface paths, from what is known of
 * the media beforehand (air_path_respond); no further rays. */
#include "path/tracking.h"
#include "path/vertex.h"

/* A patch seen edge on subtends nothing, but lights the medium: strength per solid angle grows
 * without bound. It is cut where hits are rare. */
#define LEAST_COSINE 0.02f

/* I0 of what a direction of density 1 per solid angle meets. */
static float patch_strength(float t, float cosine)
{
    return t * t / float_max(cosine, LEAST_COSINE);
}

void path_respond_patch(const air_path *path, const air_path_scratch *scratch, const air_ray *ray,
                        const air_surface *surface, float t, path_walk *walk, air_path_lane *lane)
{
    const air_path_respond *respond = &path->settings.respond;
    const air_path_segment segment = {vec3_load(ray->origin), vec3_load(ray->dir), t,
                                      &scratch->media};
    const float strength = patch_strength(t, -vec3_dot(surface->bsdf.normal, segment.dir));
    if (walk->depth == 2) { /* arrived at: the ray left a receiver */
        const air_path_receiver *receiver = lane->receiver;
        respond->patch(respond->user, &segment, surface->bsdf.normal, receiver->axes,
                       receiver->axis_count, lane->patch);
        for (size_t i = 0; i < receiver->axis_count; i++) {
            lane->patch[i] = vec3_scale(lane->patch[i], strength);
        }
        return;
    }
    air_vec3 irradiance;
    respond->patch(respond->user, &segment, surface->bsdf.normal, &walk->normal, 1, &irradiance);
    walk->scattered =
        vec3_add(walk->scattered, vec3_scale(vec3_mul(walk->flat, irradiance), strength));
}

/* I0, or E0, of a connection. Of areas connections have the side that shines only, points both. */
static air_vec3 light_strength(const air_light_point *light, const air_connection *connection)
{
    const float d2 = connection->distance * connection->distance;
    if (!light->delta && !light->infinite) {
        return vec3_scale(light->value, 1.0f / light->pdf);
    }
    return vec3_scale(connection->incident, (light->infinite ? 1.0f : d2) / connection->pdf);
}

void path_respond_light(const air_path *path, air_path_scratch *scratch, const path_vertex *vertex,
                        const air_light_point *light, const air_connection *connection,
                        float probability, air_path_lane *lane, path_shadow *shadow)
{
    const air_path_respond *respond = &path->settings.respond;
    const air_path_segment segment = {vertex->at.surface.position, connection->dir,
                                      light->infinite ? AIR_FAR : connection->distance,
                                      &scratch->media};
    const air_vec3 strength = vec3_scale(light_strength(light, connection), 1.0f / probability);
    air_ray_media_make(&scratch->media, path->media, segment.origin, segment.dir,
                       light->infinite ? INFINITY : segment.length);
    if (vertex->receives) {
        const air_path_receiver *receiver = lane->receiver;
        respond->light(respond->user, &segment, light, receiver->axes, receiver->axis_count,
                       lane->lit);
        for (size_t i = 0; i < receiver->axis_count; i++) {
            lane->lit[i] = vec3_mul(lane->lit[i], strength);
        }
        shadow->lit = true;
        return;
    }
    const air_bsdf *bsdf = &vertex->at.surface.bsdf;
    air_vec3 irradiance;
    respond->light(respond->user, &segment, light, &bsdf->frame.n, 1, &irradiance);
    const air_vec3 throughput =
        vec3_scale(vec3_add(vertex->walk.beta, vertex->walk.scattered), 1.0f / AIR_PI_F);
    shadow->scattered =
        vec3_mul(vec3_mul(throughput, bsdf->diffuse), vec3_mul(irradiance, strength));
}

/* analytic.c: light of a lamp on a camera ray and on a surface, without regard to what is
 * in between: quadrature along the ray of the phase function over the lamp times a mean
 * transmittance. */
#include <string.h>

#include "core/exponential.h"
#include "core/phase.h"
#include "core/triple.h"
#include "render/arealight/state.h"

/* ---- transmittance ---- */

air_vec3 air_area_transmittance(const air_with_arealight *with, const double from[3],
                                const double to[3])
{
    double way[3];
    air_subtract3(to, from, way);
    const double length = air_length3(way);
    if (with->snapshot->media.region_count == 0 || !(length > 0.0)) {
        return vec3_set1(1.0f);
    }
    return air_constant_transmittance(
        &with->snapshot->media, vec3((float)from[0], (float)from[1], (float)from[2]),
        vec3((float)(way[0] / length), (float)(way[1] / length), (float)(way[2] / length)),
        (float)length);
}

static air_vec3 along_length(air_vec3 sigma_t, float length)
{
    const float x = air_exp(-sigma_t.x * length);
    return sigma_t.x == sigma_t.y && sigma_t.x == sigma_t.z
               ? vec3_set1(x)
               : vec3(x, air_exp(-sigma_t.y * length), air_exp(-sigma_t.z * length));
}

/* Which shares [begin, end) of the ways from the point to the cubature's points lie in a convex
 * region: each face cuts off what is beyond it. */
static void shares_inside(const air_region *region, const double point[3],
                          const area_cubature *cubature, double *begin, double *end)
{
    for (size_t i = 0; i < cubature->count; i++) {
        begin[i] = 0.0;
        end[i] = 1.0;
    }
    for (size_t k = 0; k < region->plane_count; k++) {
        const air_plane *plane = &region->planes[k];
        const double n[3] = {(double)plane->n.x, (double)plane->n.y, (double)plane->n.z};
        const double at = air_dot3(n, point), room = (double)plane->h - at;
        for (size_t i = 0; i < cubature->count; i++) {
            const double rise = air_dot3(n, cubature->points[i]) - at, here = room / rise;
            /* on the way out it ends here, on the way in it begins */
            const double last = rise > 0.0 ? here : (room < 0.0 && rise == 0.0 ? 0.0 : 1.0);
            const double first = rise < 0.0 ? here : 0.0;
            end[i] = double_min(end[i], last);
            begin[i] = double_max(begin[i], first);
        }
    }
}

/* Transmittances from the point to the cubature's points. */
static void transmittances(const air_with_arealight *with, air_area_scratch *scratch,
                           const double point[3], const area_cubature *cubature)
{
    const air_media *media = &with->snapshot->media;
    air_vec3 *depths = scratch->through;
    if (!with->convex) {
        for (size_t i = 0; i < cubature->count; i++) {
            scratch->through[i] = air_area_transmittance(with, point, cubature->points[i]);
        }
        return;
    }
    memset(depths, 0, cubature->count * sizeof *depths);
    for (size_t r = 0; r < media->region_count; r++) {
        const air_region *region = &media->regions[r];
        shares_inside(region, point, cubature, scratch->begin, scratch->end);
        for (size_t i = 0; i < cubature->count; i++) {
            const double share = scratch->end[i] - scratch->begin[i];
            if (share > 0.0) {
                depths[i] =
                    vec3_madd(depths[i], (float)(share * scratch->lengths[i]), region->sigma_t);
            }
        }
    }
    for (size_t i = 0; i < cubature->count; i++) {
        depths[i] = along_length(depths[i], 1.0f);
    }
}

/* Where in the volume the lamp is seen from. */
typedef struct area_view {
    const double *point;
    const double *wo; /* towards the camera */
    const air_ray_segment *segment;
    double nearest; /* distance to the lamp */
} area_view;

/* The mean phase function of the media towards wi. */
static double directional_weight(const air_with_arealight *with, const area_view *view,
                                 const double wi[3])
{
    const air_media *media = &with->snapshot->media;
    double sum = 0.0;
    for (uint64_t rest = view->segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(rest)];
        sum += (double)(vec3_mean(region->sigma_s) * phase_eval(media->media[region->medium].phase,
                                                                -(float)air_dot3(view->wo, wi)));
    }
    return sum;
}

/* Shares of the lamp's points in what arrives through clear air: p cos / r^2, where the cosine at
 * the lamp is H / r and H is the same for all. Returns their sum. */
static double point_shares(const air_with_arealight *with, const area_view *view,
                           const area_cubature *cubature, air_area_scratch *scratch)
{
    double sum = 0.0;
    for (size_t i = 0; i < cubature->count; i++) {
        double wi[3];
        air_subtract3(cubature->points[i], view->point, wi);
        const double r2 = air_dot3(wi, wi), r = sqrt(r2);
        scratch->lengths[i] = r;
        scratch->shares[i] = 0.0;
        if (r > 0.0) {
            for (int k = 0; k < 3; k++) {
                wi[k] /= r;
            }
            scratch->shares[i] =
                cubature->weights[i] * directional_weight(with, view, wi) / (r2 * r);
        }
        sum += scratch->shares[i];
    }
    return sum;
}

/* Many points where the lamp is near. */
static const area_cubature *points_for(const area_lamp *lamp, double nearest)
{
    return nearest < 0.5 * sqrt(lamp->shape.area) ? &lamp->many : &lamp->few;
}

/* tau per channel: the mean of the transmittances to points of the lamp, each with its share. */
static air_vec3 mean_transmittance(const air_with_arealight *with, air_area_scratch *scratch,
                                   const area_lamp *lamp, const area_view *view)
{
    const area_cubature *cubature = points_for(lamp, view->nearest);
    if (with->snapshot->media.region_count == 0) {
        return vec3_set1(1.0f);
    }
    double sum = point_shares(with, view, cubature, scratch);
    if (!(sum > 0.0)) { /* nothing is scattered from the points themselves */
        memcpy(scratch->shares, cubature->weights, cubature->count * sizeof *cubature->weights);
        sum = lamp->shape.area;
    }
    transmittances(with, scratch, view->point, cubature);
    double tau[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < cubature->count; i++) {
        const double share = scratch->shares[i] / sum;
        tau[0] += share * (double)scratch->through[i].x;
        tau[1] += share * (double)scratch->through[i].y;
        tau[2] += share * (double)scratch->through[i].z;
    }
    return vec3((float)tau[0], (float)tau[1], (float)tau[2]);
}

/* ---- the volume ---- */

/* S of one lobe of weight 1 at all nodes. */
static void scatter_lobe(const air_with_arealight *with, const area_lobe *lobe,
                         const area_lamp *lamp, const area_nodes *nodes, double *out)
{
    const air_area_shading_points points = {
        {nodes->position[0], nodes->position[1], nodes->position[2]},
        {nodes->wo[0], nodes->wo[1], nodes->wo[2]}};
    if (lobe->rayleigh) {
        for (size_t i = 0; i < nodes->count; i++) {
            double polygon[AIR_AREA_MAX_VERTICES][3];
            const double point[3] = {nodes->position[0][i], nodes->position[1][i],
                                     nodes->position[2][i]};
            const double wo[3] = {nodes->wo[0][i], nodes->wo[1][i], nodes->wo[2][i]};
            out[i] = air_area_lamp_seen_from(&lamp->shape, point, polygon)
                         ? air_area_scatter_rayleigh((const double(*)[3])polygon,
                                                     lamp->shape.vertex_count, wo)
                         : 0.0;
        }
    } else if (lamp->mode == AIR_AREA_MODE_EDGE) {
        air_area_eval_edge(with->context, &lamp->shape, lobe->g, lobe->nodes, &points, nodes->count,
                           out);
    } else {
        air_area_eval_lobes(with->context, &lamp->shape,
                            &lobe->fits[lamp->mode == AIR_AREA_MODE_LTSD ? 1 : 0], &points,
                            nodes->count, out);
    }
}

/* S of one medium at all nodes, into nodes->s: it is linear in the phase function. */
static void scatter(const air_with_arealight *with, const area_phase *phase, const area_lamp *lamp,
                    area_nodes *nodes)
{
    scatter_lobe(with, &phase->lobes[0], lamp, nodes, nodes->s);
    for (size_t i = 0; i < nodes->count; i++) {
        nodes->s[i] *= phase->lobes[0].weight;
    }
    for (size_t k = 1; k < phase->lobe_count; k++) {
        scatter_lobe(with, &phase->lobes[k], lamp, nodes, nodes->s_lobe);
        for (size_t i = 0; i < nodes->count; i++) {
            nodes->s[i] += phase->lobes[k].weight * nodes->s_lobe[i];
        }
    }
}

/* sigma_s S of all media of a segment, per channel, at all nodes. */
static void scatter_segment(const air_with_arealight *with, const area_lamp *lamp,
                            const air_ray_segment *segment, area_nodes *nodes)
{
    const air_media *media = &with->snapshot->media;
    uint32_t last = UINT32_MAX;
    memset(nodes->scattered, 0, nodes->count * sizeof *nodes->scattered);
    for (uint64_t rest = segment->regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(rest)];
        if (region->medium != last) {
            scatter(with, &with->phases[region->medium], lamp, nodes);
            last = region->medium;
        }
        for (size_t i = 0; i < nodes->count; i++) {
            nodes->scattered[i] =
                vec3_madd(nodes->scattered[i], (float)nodes->s[i], region->sigma_s);
        }
    }
}

/* Transmittance from the lamp to a node. */
static air_vec3 lamp_transmittance(const air_with_arealight *with, air_area_scratch *scratch,
                                   const area_lamp *lamp, const air_ray_segment *segment, size_t i)
{
    const area_nodes *nodes = &scratch->nodes;
    const double point[3] = {nodes->position[0][i], nodes->position[1][i], nodes->position[2][i]};
    const double wo[3] = {nodes->wo[0][i], nodes->wo[1][i], nodes->wo[2][i]};
    double polygon[AIR_AREA_MAX_VERTICES][3];
    if (!air_area_lamp_seen_from(&lamp->shape, point, polygon)) {
        return vec3_set1(0.0f);
    }
    const double nearest =
        air_area_min_distance((const double(*)[3])polygon, lamp->shape.vertex_count);
    const area_view view = {point, wo, segment, nearest};
    return lamp->mode == AIR_AREA_MODE_LTSD ? along_length(segment->sigma_t, (float)nearest)
                                            : mean_transmittance(with, scratch, lamp, &view);
}

/* Places the rule's nodes. */
static void place_nodes(const air_with_arealight *with, const area_lamp *lamp,
                        const air_ray_segment *segment, const double origin[3], const double dir[3],
                        air_interval part, area_nodes *nodes)
{
    nodes->count = with->params->area_nodes;
    air_area_line_nodes(with->params->area_rule, &lamp->shape, origin, dir, part,
                        (double)vec3_mean(segment->sigma_t), nodes->count, nodes->t, nodes->w);
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < nodes->count; i++) {
            nodes->position[k][i] = origin[k] + nodes->t[i] * dir[k];
            nodes->wo[k][i] = -dir[k];
        }
    }
}

/* The part of a segment in front of the lamp; the paper's rule takes all of it. */
static bool lit_part(const air_with_arealight *with, const area_lamp *lamp,
                     const air_ray_segment *segment, const double origin[3], const double dir[3],
                     air_interval *out)
{
    const double begin = (double)segment->t0;
    const double end = segment->t1 >= AIR_FAR ? INFINITY : (double)segment->t1;
    *out = (air_interval){begin, end};
    if (with->params->area_rule != AIR_AREA_RIEMANN) {
        if (!air_area_lit_interval(&lamp->shape, origin, dir, end, out)) {
            return false;
        }
        out->begin = fmax(out->begin, begin);
    }
    return out->begin < out->end;
}

/* Radiance scattered to the camera on one segment, for a lamp of radiance 1. */
static air_vec3 segment_light(const air_with_arealight *with, air_area_scratch *scratch,
                              const area_lamp *lamp, const air_ray_segment *segment)
{
    const area_nodes *nodes = &scratch->nodes;
    air_vec3 sum = vec3_set1(0.0f);
    scatter_segment(with, lamp, segment, &scratch->nodes);
    for (size_t i = 0; i < nodes->count; i++) {
        if (vec3_is_zero(nodes->scattered[i])) {
            continue;
        }
        const float t = (float)(nodes->t[i] - (double)segment->t0);
        const air_vec3 camera = along_length(vec3_madd(segment->depth, t, segment->sigma_t), 1.0f);
        const air_vec3 light =
            vec3_mul(nodes->scattered[i], lamp_transmittance(with, scratch, lamp, segment, i));
        sum = vec3_madd(sum, (float)nodes->w[i], vec3_mul(light, camera));
    }
    return sum;
}

air_vec3 air_area_volume_light(const air_with_arealight *with, air_area_scratch *scratch,
                               const area_lamp *lamp, const double origin[3], const double dir[3])
{
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < scratch->media.count; i++) {
        const air_ray_segment *segment = &scratch->media.segments[i];
        air_interval part;
        if (!vec3_is_zero(segment->sigma_s) && lit_part(with, lamp, segment, origin, dir, &part)) {
            place_nodes(with, lamp, segment, origin, dir, part, &scratch->nodes);
            sum = vec3_add(sum, segment_light(with, scratch, lamp, segment));
        }
    }
    return vec3_mul(sum, lamp->radiance);
}

/* ---- surfaces ---- */

/* The reflectance without a highlight, which is smooth, towards a point, times its cosine. */
static air_vec3 smooth_reflection(const air_surface *surface, air_vec3 wo, const double way[3],
                                  double length)
{
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    const air_vec3 wi =
        vec3((float)(way[0] * scale), (float)(way[1] * scale), (float)(way[2] * scale));
    return air_bsdf_eval_smooth(&surface->bsdf, wo, wi);
}

/* Lengths of the ways to the lamp's points, their shares of the irradiance, and what is reflected
 * of it. Returns the sum of the shares. */
static double reflect_points(const air_surface *surface, air_vec3 wo, const double point[3],
                             const double normal[3], const area_cubature *cubature,
                             air_area_scratch *scratch)
{
    double sum = 0.0;
    for (size_t i = 0; i < cubature->count; i++) {
        double way[3];
        air_subtract3(cubature->points[i], point, way);
        const double r = air_length3(way), height = air_dot3(normal, way);
        scratch->lengths[i] = r;
        scratch->shares[i] = 0.0;
        if (height > 0.0) {
            scratch->shares[i] = cubature->weights[i] * height / (r * r * r * r);
            scratch->reflected[i] =
                vec3_scale(smooth_reflection(surface, wo, way, r), (float)(AIR_PI * r / height));
        }
        sum += scratch->shares[i];
    }
    return sum;
}

/* The mean over the lamp of reflectance times transmittance. */
static air_vec3 mean_reflected(const air_with_arealight *with, air_area_scratch *scratch,
                               const area_cubature *cubature, const double point[3], double total)
{
    air_vec3 sum = vec3_set1(0.0f);
    const bool clear = with->snapshot->media.region_count == 0;
    if (!clear) {
        transmittances(with, scratch, point, cubature);
    }
    for (size_t i = 0; i < cubature->count; i++) {
        if (scratch->shares[i] > 0.0) {
            const air_vec3 through = clear ? vec3_set1(1.0f) : scratch->through[i];
            sum = vec3_madd(sum, (float)(scratch->shares[i] / total),
                            vec3_mul(scratch->reflected[i], through));
        }
    }
    return sum;
}

/* Where all points are below the surface, the highest corner stands for what is above. */
static air_vec3 corner_reflected(const air_with_arealight *with, const area_lamp *lamp,
                                 const air_surface *surface, air_vec3 wo, const double point[3],
                                 const double normal[3])
{
    double highest = 0.0, best[3] = {0.0, 0.0, 0.0};
    size_t corner = 0;
    for (size_t i = 0; i < lamp->shape.vertex_count; i++) {
        double way[3];
        air_subtract3(lamp->shape.vertices[i], point, way);
        if (air_dot3(normal, way) > highest) {
            highest = air_dot3(normal, way);
            air_copy3(way, best);
            corner = i;
        }
    }
    if (!(highest > 0.0)) {
        return vec3_set1(0.0f);
    }
    const double length = air_length3(best);
    return vec3_scale(vec3_mul(smooth_reflection(surface, wo, best, length),
                               air_area_transmittance(with, point, lamp->shape.vertices[corner])),
                      (float)(AIR_PI * length / highest));
}

air_vec3 air_area_surface_light(const air_with_arealight *with, air_area_scratch *scratch,
                                const area_lamp *lamp, const air_surface *surface, air_vec3 wo)
{
    double point[3], normal[3], polygon[AIR_AREA_MAX_VERTICES][3];
    vec3_store64(point, surface->position);
    vec3_store64(normal, surface->bsdf.frame.n);
    if (!air_area_lamp_seen_from(&lamp->shape, point, polygon)) {
        return vec3_set1(0.0f);
    }
    const double(*seen)[3] = (const double(*)[3])polygon;
    const double irradiance = air_area_irradiance(seen, lamp->shape.vertex_count, normal);
    if (!(irradiance > 0.0)) {
        return vec3_set1(0.0f);
    }
    const double nearest = air_area_min_distance(seen, lamp->shape.vertex_count);
    const area_cubature *cubature = points_for(lamp, nearest);
    const double total = reflect_points(surface, wo, point, normal, cubature, scratch);
    const air_vec3 reflected = total > 0.0
                                   ? mean_reflected(with, scratch, cubature, point, total)
                                   : corner_reflected(with, lamp, surface, wo, point, normal);
    return vec3_scale(vec3_mul(reflected, lamp->radiance), (float)irradiance);
}

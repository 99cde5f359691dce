#include "scene/media/media.h"

#include <float.h>

/* How many boundary hits of one ray are looked at, all mesh regions together. */
enum { MAX_BOUNDARY_HITS = AIR_MAX_SEGMENTS, MAX_EVENTS = 2 * AIR_MAX_REGIONS + MAX_BOUNDARY_HITS };

/* Region `region` begins (or ends) at t. */
typedef struct region_event {
    float t;
    uint32_t region;
    bool enter;
} region_event;

static void pack_planes(air_region *region)
{
    region->pack_count = (region->plane_count + 3) / 4;
    for (size_t k = 0; k < 4 * region->pack_count; k++) {
        const bool used = k < region->plane_count;
        air_plane_pack *pack = &region->packs[k / 4];
        pack->x[k % 4] = used ? region->planes[k].n.x : 0.0f;
        pack->y[k % 4] = used ? region->planes[k].n.y : 0.0f;
        pack->z[k % 4] = used ? region->planes[k].n.z : 0.0f;
        pack->h[k % 4] = used ? region->planes[k].h : 1.0f;
    }
}

void air_media_prepare(air_media *media)
{
    for (size_t r = 0; r < media->region_count; r++) {
        air_region *region = &media->regions[r];
        const air_medium *medium = &media->media[region->medium];
        pack_planes(region);
        region->constant = air_medium_is_constant(medium);
        region->sigma_s = vec3_scale(medium->sigma_s, region->density);
        region->sigma_t = vec3_scale(medium->sigma_t, region->density);
        region->emission = vec3_scale(medium->emission, region->density);
    }
}

void air_region_planes(const air_region *region, air_collimated_medium *out)
{
    out->plane_count = region->plane_count;
    for (size_t k = 0; k < region->plane_count; k++) {
        const air_plane *plane = &region->planes[k];
        vec3_store64(out->planes[k], plane->n);
        out->planes[k][3] = (double)plane->h;
    }
}

typedef int32_t mask_lanes __attribute__((vector_size(16)));

static inline air_plane_lanes select_lanes(mask_lanes mask, air_plane_lanes yes, air_plane_lanes no)
{
    return (air_plane_lanes)((mask & (mask_lanes)yes) | (~mask & (mask_lanes)no));
}

static inline air_plane_lanes all_lanes(float x) { return (air_plane_lanes){x, x, x, x}; }

/* Clips [*a, *b] to the intersection of the half-spaces; false if nothing is left. */
static bool clip_convex(const air_region *region, air_vec3 origin, air_vec3 dir, float *a, float *b)
{
    if (region->pack_count == 0) {
        return *a < *b;
    }
    air_plane_lanes enter = all_lanes(*a), leave = all_lanes(*b);
    for (size_t k = 0; k < region->pack_count; k++) {
        const air_plane_pack *pack = &region->packs[k];
        const air_plane_lanes no =
            pack->h - (pack->x * origin.x + pack->y * origin.y + pack->z * origin.z);
        const air_plane_lanes nv = pack->x * dir.x + pack->y * dir.y + pack->z * dir.z;
        const air_plane_lanes t = no / nv;
        leave = select_lanes((nv > 0.0f) & (t < leave), t, leave);
        enter = select_lanes((nv < 0.0f) & (t > enter), t, enter);
        /* parallel to the plane and outside: nothing is left */
        enter = select_lanes((nv == 0.0f) & (no < 0.0f), all_lanes(INFINITY), enter);
    }
    *a = float_max(float_max(enter[0], enter[1]), float_max(enter[2], enter[3]));
    *b = float_min(float_min(leave[0], leave[1]), float_min(leave[2], leave[3]));
    return *a < *b;
}

/* Clips [*a, *b] to an ellipsoid; false if nothing is left. */
static bool clip_ellipsoid(const air_quadric *ellipsoid, air_vec3 origin, air_vec3 dir, float *a,
                           float *b)
{
    const float from[3] = {origin.x, origin.y, origin.z}, along[3] = {dir.x, dir.y, dir.z};
    double ends[2];
    if (!air_quadric_sphere_chord(ellipsoid, from, along, ends)) {
        return false;
    }
    *a = float_max((float)ends[0], *a);
    *b = float_min((float)ends[1], *b);
    return *a < *b;
}

/* The same to a region; of a mesh, to what else bounds its medium. */
static bool clip_region(const air_region *region, air_vec3 origin, air_vec3 dir, float *a, float *b)
{
    return clip_convex(region, origin, dir, a, b) &&
           (region->kind != AIR_REGION_ELLIPSOID ||
            clip_ellipsoid(&region->ellipsoid, origin, dir, a, b));
}

/* Of the regions present, those that count: see medium.h on overlap. */
static uint64_t apply_replacement(const air_media *media, uint64_t present)
{
    int32_t highest = INT32_MIN;
    uint32_t keep = UINT32_MAX;
    for (uint64_t rest = present; rest != 0; rest &= rest - 1) {
        const uint32_t m = media->regions[__builtin_ctzll(rest)].medium;
        if (media->media[m].combine == AIR_COMBINE_REPLACE &&
            (keep == UINT32_MAX || media->media[m].priority >= highest)) {
            highest = media->media[m].priority;
            keep = m;
        }
    }
    if (keep == UINT32_MAX) {
        return present;
    }
    uint64_t kept = 0;
    for (uint64_t rest = present; rest != 0; rest &= rest - 1) {
        const uint32_t m = media->regions[__builtin_ctzll(rest)].medium;
        const air_medium *medium = &media->media[m];
        if (medium->combine == AIR_COMBINE_REPLACE ? m == keep : medium->priority >= highest) {
            kept |= rest & (~rest + 1);
        }
    }
    return kept;
}

/* What remains inside of the crossings of one boundary mesh, clipped to [a, b]. Meshes are oriented
 * outwards, so the first crossing tells whether the origin is inside. */
static size_t add_mesh_region(const air_hit *hits, size_t hit_count, uint32_t r,
                              const air_region *region, air_vec3 dir, float a, float b,
                              region_event *events, size_t count)
{
    int inside = 0; /* how many of its parts hold the point: at infinity none */
    for (size_t i = 0; i < hit_count; i++) {
        if (hits[i].mesh == region->mesh) {
            inside += vec3_dot(vec3_load(hits[i].normal), dir) < 0.0f ? -1 : 1;
        }
    }
    float entered = 0.0f;
    for (size_t i = 0; i < hit_count && count + 2 <= MAX_BOUNDARY_HITS; i++) {
        if (hits[i].mesh != region->mesh) {
            continue;
        }
        const int before = inside;
        inside += vec3_dot(vec3_load(hits[i].normal), dir) < 0.0f ? 1 : -1;
        if (before <= 0 && inside > 0) {
            entered = hits[i].t;
        } else if (before > 0 && inside <= 0) {
            const float t0 = float_max(entered, a), t1 = float_min(hits[i].t, b);
            if (t0 < t1) {
                events[count++] = (region_event){t0, r, true};
                events[count++] = (region_event){t1, r, false};
            }
        }
    }
    return count;
}

/* The begin and end of every region on [0, tmax]. */
static size_t collect_events(const air_media *media, air_vec3 origin, air_vec3 dir, float tmax,
                             region_event *events)
{
    air_hit hits[MAX_BOUNDARY_HITS];
    size_t hit_count = 0, count = 0;
    if (media->boundary_accelerator != NULL) {
        const air_ray ray = {
            {origin.x, origin.y, origin.z}, 0.0f, {dir.x, dir.y, dir.z}, FLT_MAX, UINT32_MAX};
        hit_count = media->backend->intersect_all(media->boundary_accelerator, &ray, hits,
                                                  MAX_BOUNDARY_HITS);
    }
    for (uint32_t r = 0; r < media->region_count; r++) {
        const air_region *region = &media->regions[r];
        float a = 0.0f, b = tmax;
        if (!clip_region(region, origin, dir, &a, &b)) {
            continue;
        }
        if (region->kind == AIR_REGION_MESH) {
            count = add_mesh_region(hits, hit_count, r, region, dir, a, b, events, count);
        } else {
            events[count++] = (region_event){a, r, true};
            events[count++] = (region_event){b, r, false};
        }
    }
    return count;
}

static void sort_events(region_event *events, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        const region_event event = events[i];
        size_t k = i;
        for (; k > 0 && events[k - 1].t > event.t; k--) {
            events[k] = events[k - 1];
        }
        events[k] = event;
    }
}

static size_t sweep(const air_media *media, const region_event *events, size_t event_count,
                    air_segment *out)
{
    uint64_t present = 0;
    size_t count = 0;
    for (size_t i = 0; i + 1 < event_count && count < AIR_MAX_SEGMENTS; i++) {
        const uint64_t bit = (uint64_t)1 << events[i].region;
        present = events[i].enter ? present | bit : present & ~bit;
        if (present == 0 || !(events[i].t < events[i + 1].t)) {
            continue;
        }
        const uint64_t kept = media->any_replace ? apply_replacement(media, present) : present;
        out[count++] = (air_segment){events[i].t, events[i + 1].t, kept};
    }
    return count;
}

size_t air_media_segments(const air_media *media, air_vec3 origin, air_vec3 dir, float tmax,
                          air_segment *out)
{
    if (media->region_count == 0) {
        return 0;
    }
    if (air_media_fill_space(media)) {
        out[0] = (air_segment){0.0f, tmax, 1};
        return tmax > 0.0f ? 1 : 0;
    }
    region_event events[MAX_EVENTS];
    const size_t count = collect_events(media, origin, dir, tmax, events);
    if (count == 2) { /* one region, once: the usual case */
        out[0] = (air_segment){events[0].t, events[1].t, (uint64_t)1 << events[0].region};
        return 1;
    }
    sort_events(events, count);
    return sweep(media, events, count, out);
}

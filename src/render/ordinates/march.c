/* march.c: along a camera ray through the media, with the light of the cells. */
#include <math.h>
#include <string.h>

#include "render/ordinates/corners.h"
#include "render/ordinates/march.h"
#include "scene/media/field.h"

/* Below this share of the light the march ends. */
#define LEAST_SHARE 1e-5f

enum { MOST_REFINEMENT = 2 };

/* The media at a point. */
typedef struct look {
    air_vec3 sigma_t[ORD_MARCHES], sent[ORD_MARCHES];
} look;

/* found: the coefficients of the regions, in the order of their numbers, ORD_MARCH_BLOCK from one
 * to the next. */
static look look_at(const air_with_ordinates *with, uint64_t regions, air_vec3 point,
                    const air_coefficients *found)
{
    const air_media *const media = &with->snapshot->media;
    air_vec3 sigma_s[AIR_MAX_REGIONS];
    uint32_t medium[AIR_MAX_REGIONS];
    look out;
    size_t count = 0;
    memset(&out, 0, sizeof out);
    for (; regions != 0; regions &= regions - 1, count++, found += ORD_MARCH_BLOCK) {
        const air_region *region = &media->regions[__builtin_ctzll(regions)];
        medium[count] = region->medium;
        sigma_s[count] = found->sigma_s;
        out.sigma_t[ORD_FIRST] = vec3_add(out.sigma_t[ORD_FIRST], found->sigma_t);
        out.sigma_t[ORD_SOLVED] =
            vec3_add(out.sigma_t[ORD_SOLVED],
                     vec3_madd(found->sigma_t, -with->media[region->medium].peak, found->sigma_s));
    }
    out.sigma_t[ORD_CARRIED] = out.sigma_t[ORD_FIRST];
    const ord_corners c = ord_corners_find(with, point, vec3_mean(out.sigma_t[ORD_FIRST]));
    for (size_t i = 0; i < count; i++) {
        const ord_medium *const m = &with->media[medium[i]];
        if (m->light != NULL) {
            out.sent[ORD_SOLVED] = vec3_add(out.sent[ORD_SOLVED],
                                            vec3_mul(sigma_s[i], ord_corners_gather(&c, m->light)));
        }
        if (m->first != NULL) {
            out.sent[ORD_FIRST] = vec3_add(out.sent[ORD_FIRST],
                                           vec3_mul(sigma_s[i], ord_corners_gather(&c, m->first)));
        }
        if (with->carried != NULL) {
            out.sent[ORD_CARRIED] = vec3_add(
                out.sent[ORD_CARRIED], vec3_mul(sigma_s[i], ord_corners_gather(&c, with->carried)));
        }
    }
    return out;
}

/* What a step adds per metre's worth of source, (1 - exp(-sigma length)) / sigma, and lets through.
 */
static float step_channel(float sigma_t, float length, float *through)
{
    const float depth = sigma_t * length;
    float loss;
    air_transmittance_and_loss(depth, through, &loss);
    return depth > 1e-6f ? loss / sigma_t : length;
}

static void step(air_vec3 sigma_t, air_vec3 sent, float length, air_vec3 *through, air_vec3 *sum)
{
    air_vec3 left, gain;
    gain.x = step_channel(sigma_t.x, length, &left.x);
    gain.y = step_channel(sigma_t.y, length, &left.y);
    gain.z = step_channel(sigma_t.z, length, &left.z);
    *sum = vec3_add(*sum, vec3_mul(*through, vec3_mul(gain, sent)));
    *through = vec3_mul(*through, left);
}

/* Media that only glow are nothing to march through, and may have no end. */
static bool attenuates(const air_media *media, uint64_t regions)
{
    bool any = false;
    for (; regions != 0 && !any; regions &= regions - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(regions)];
        any = !vec3_is_zero(media->media[region->medium].sigma_t);
    }
    return any;
}

/* Steps as long as the light of cells asks for, but no longer than the finest features of detail,
 * down to half of that. Then smoke with features of three steps and below lacks 3.5 % of a picture
 * (rms) instead of 12.5, for 1.5 times the time; half of it again would take 2.5 times. */
static float longest_step(const air_with_ordinates *with, uint64_t regions)
{
    const air_media *const media = &with->snapshot->media;
    const float longest = with->domain.cell_m / (float)with->settings->march;
    float finest = longest;
    for (; regions != 0; regions &= regions - 1) {
        const air_medium *medium = &media->media[media->regions[__builtin_ctzll(regions)].medium];
        if (air_medium_is_detailed(medium)) {
            finest = float_min(finest, air_detail_finest(&medium->detail));
        }
    }
    return float_max(finest, longest / MOST_REFINEMENT);
}

static void look_at_media(const air_with_ordinates *with, uint64_t regions, const air_vec3 *points,
                          size_t count, float length, air_march_scratch *scratch)
{
    const air_media *const media = &with->snapshot->media;
    for (size_t r = 0; regions != 0; regions &= regions - 1, r++) {
        const air_region *region = &media->regions[__builtin_ctzll(regions)];
        air_medium_coefficients_run(&media->media[region->medium], region, points, count, length,
                                    scratch->found[r]);
    }
}

/* Without detail, looking at steps together gains nothing and goes on behind the march's end. */
static size_t block_of(const air_media *media, uint64_t regions)
{
    bool detailed = false;
    for (; regions != 0; regions &= regions - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(regions)];
        detailed = detailed || air_medium_is_detailed(&media->media[region->medium]);
    }
    return detailed ? ORD_MARCH_BLOCK : 1;
}

/* Point by point, in the stretch from t0 to t1. */
static void march_points(const air_with_ordinates *with, air_march_scratch *scratch,
                         uint64_t regions, float t0, float t1, const air_path_lane *lane,
                         ord_gathered *g)
{
    const size_t block = block_of(&with->snapshot->media, regions);
    const float longest = longest_step(with, regions);
    const float steps = ceilf(float_min((t1 - t0) / longest, ORD_MOST_STEPS));
    const float length = (t1 - t0) / float_max(steps, 1.0f);
    air_vec3 points[ORD_MARCH_BLOCK];
    for (float n = 0.0f; n < steps; n += (float)(ptrdiff_t)block) {
        const size_t count = (size_t)float_min(steps - n, (float)(ptrdiff_t)block);
        for (size_t i = 0; i < count; i++) {
            const float at = n + (float)(ptrdiff_t)i + lane->u_distance;
            points[i] = vec3_madd(lane->origin, t0 + at * length, lane->dir);
        }
        look_at_media(with, regions, points, count, length, scratch);
        for (size_t i = 0; i < count; i++) {
            const look seen = look_at(with, regions, points[i], &scratch->found[0][i]);
            for (int m = 0; m < ORD_MARCHES; m++) {
                step(seen.sigma_t[m], seen.sent[m], length, &g->through[m], &g->sum[m]);
            }
            if (vec3_max(g->through[ORD_SOLVED]) < LEAST_SHARE) {
                return;
            }
        }
    }
}

/* Through voxels, if all media on the way are single and have them, as a list; false: there is
 * something else, or too much. */
static bool list_spans(const air_with_ordinates *with, const air_ray_media *media, ord_span *spans,
                       size_t *out_count)
{
    *out_count = 0;
    for (size_t s = 0; s < media->count; s++) {
        const air_ray_segment *const segment = &media->segments[s];
        const uint64_t regions = segment->regions;
        const uint32_t region = (uint32_t)__builtin_ctzll(regions);
        if (!attenuates(&with->snapshot->media, regions)) {
            continue;
        }
        if ((regions & (regions - 1)) != 0 || with->voxels[region].empty == NULL ||
            *out_count == ORD_SPANS) {
            return false;
        }
        spans[(*out_count)++] = (ord_span){segment->t0, segment->t1, region};
    }
    return true;
}

static void march_segments(const air_with_ordinates *with, air_march_scratch *scratch,
                           const air_path_lane *lane, ord_gathered *g)
{
    const air_ray_media *const media = &scratch->media;
    for (size_t s = 0; s < media->count; s++) {
        const air_ray_segment *const segment = &media->segments[s];
        if (attenuates(&with->snapshot->media, segment->regions)) {
            march_points(with, scratch, segment->regions, segment->t0, segment->t1, lane, g);
        }
    }
}

static void add_sky(const air_with_ordinates *with, const air_path_lane *lane, ord_gathered *g)
{
    const air_vec3 peak = vec3_sub(g->through[ORD_SOLVED], g->through[ORD_FIRST]);
    g->sum[ORD_SOLVED] =
        vec3_add(g->sum[ORD_SOLVED], vec3_mul(peak, ord_sky_radiance(&with->sky, lane->dir)));
}

void ord_march(const air_with_ordinates *with, air_march_scratch *scratch,
               const air_path_lane *lanes, size_t count, air_vec3 (*out)[2])
{
    const air_vec3 one = vec3_set1(1.0f), none = vec3_set1(0.0f);
    ord_gathered g[AIR_PATH_LANES];
    for (size_t i = 0; i < count; i++) {
        const bool met = lanes[i].hit.mesh != (uint32_t)AIR_NO_HIT;
        g[i] = (ord_gathered){{one, one, one}, {none, none, none}};
        air_ray_media_make(&scratch->media, &with->snapshot->media, lanes[i].origin, lanes[i].dir,
                           met ? lanes[i].hit.t : AIR_FAR);
        if (!list_spans(with, &scratch->media, scratch->spans[i], &scratch->span_count[i])) {
            scratch->span_count[i] = 0;
            march_segments(with, scratch, &lanes[i], &g[i]);
        }
    }
    ord_march_voxels(with, scratch, lanes, count, g);
    for (size_t i = 0; i < count; i++) {
        if (with->all && lanes[i].hit.mesh == (uint32_t)AIR_NO_HIT) {
            add_sky(with, &lanes[i], &g[i]);
        }
        out[i][0] = vec3_add(g[i].sum[ORD_SOLVED], g[i].sum[ORD_CARRIED]);
        out[i][1] = g[i].sum[ORD_FIRST];
    }
}

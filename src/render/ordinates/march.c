/* march.c: along a camera ray through the media, with the light of the cells. */
#include <math.h>
#include <string.h>

#include "core/exponential.h"
#include "render/ordinates/state.h"
#include "scene/media/field.h"

/* In one stretch of a ray at most; below this share of the light the march ends. */
enum { MOST_STEPS = 16384 };
#define LEAST_SHARE 1e-5f

/* Eight cells about a point, and their shares. */
typedef struct corners {
    size_t cell[8];
    float weight[8];
} corners;

/* In the outer half cells the line through the two nearest centres goes on (`onward`), else the
 * outer centre's light holds there: a border that light falls on would be too dark. */
static corners find_corners(const ord_domain *domain, air_vec3 world, bool onward)
{
    const float beyond = onward ? 0.5f : 0.0f;
    const air_vec3 local = ord_domain_local(domain, world);
    const float at[3] = {local.x, local.y, local.z};
    size_t low[3], high[3];
    float share[3];
    corners out;
    for (int axis = 0; axis < 3; axis++) {
        const float place = at[axis] / domain->cell_m - 0.5f;
        const size_t last = domain->size[axis] > 1 ? domain->size[axis] - 2 : 0;
        const float held = float_min(float_max(place, 0.0f), (float)(ptrdiff_t)last);
        low[axis] = (size_t)held;
        high[axis] = low[axis] + 1 < domain->size[axis] ? low[axis] + 1 : low[axis];
        share[axis] =
            float_min(float_max(place - (float)(ptrdiff_t)low[axis], -beyond), 1.0f + beyond);
    }
    for (int c = 0; c < 8; c++) {
        const size_t x = (c & 1) != 0 ? high[0] : low[0], y = (c & 2) != 0 ? high[1] : low[1];
        const size_t z = (c & 4) != 0 ? high[2] : low[2];
        out.cell[c] = (z * domain->size[1] + y) * domain->size[0] + x;
        out.weight[c] = ((c & 1) != 0 ? share[0] : 1.0f - share[0]) *
                        ((c & 2) != 0 ? share[1] : 1.0f - share[1]) *
                        ((c & 4) != 0 ? share[2] : 1.0f - share[2]);
    }
    return out;
}

/* Gives cells of like extinction more weight: exp(-(s(p) - s(q))^2 / (2 r^2)), r a tenth of the
 * largest; where none is alike, the weights stay. [Elek2014, section 5.4] */
static void weigh_by_extinction(const air_with_ordinates *with, float sigma_t, corners *c)
{
    const float inverse = 1.0f / (0.1f * with->largest + 1e-6f);
    float weight[8], sum = 0.0f;
    for (int i = 0; i < 8; i++) {
        const float difference = (with->extinction[c->cell[i]] - sigma_t) * inverse;
        weight[i] = c->weight[i] * air_exp(-0.5f * difference * difference);
        sum += weight[i];
    }
    for (int i = 0; i < 8 && sum >= 1e-6f; i++) {
        c->weight[i] = weight[i] / sum;
    }
}

static air_vec3 gather(const corners *c, const float *light)
{
    air_vec3 sum = vec3_set1(0.0f);
    for (int i = 0; i < 8; i++) {
        sum = vec3_madd(sum, c->weight[i], vec3_load(light + c->cell[i] * 4));
    }
    return vec3(float_max(sum.x, 0.0f), float_max(sum.y, 0.0f), float_max(sum.z, 0.0f));
}

/* What is marched for: the solver's light, with its extinction, and with the true one that of first
 * events alone, and that of grids. */
enum { SOLVED = 0, FIRST = 1, CARRIED = 2, MARCHES = 3 };

/* The media at a point. */
typedef struct look {
    air_vec3 sigma_t[MARCHES], sent[MARCHES];
} look;

static look look_at(const air_with_ordinates *with, uint64_t regions, air_vec3 point)
{
    const air_media *const media = &with->snapshot->media;
    corners c = find_corners(&with->domain, point, !with->settings->bilateral);
    air_vec3 sigma_s[AIR_MAX_REGIONS];
    uint32_t medium[AIR_MAX_REGIONS];
    look out;
    size_t count = 0;
    memset(&out, 0, sizeof out);
    for (; regions != 0; regions &= regions - 1, count++) {
        const air_region *region = &media->regions[__builtin_ctzll(regions)];
        const air_coefficients found =
            air_medium_coefficients(&media->media[region->medium], region, point);
        medium[count] = region->medium;
        sigma_s[count] = found.sigma_s;
        out.sigma_t[FIRST] = vec3_add(out.sigma_t[FIRST], found.sigma_t);
        out.sigma_t[SOLVED] =
            vec3_add(out.sigma_t[SOLVED],
                     vec3_madd(found.sigma_t, -with->media[region->medium].peak, found.sigma_s));
    }
    out.sigma_t[CARRIED] = out.sigma_t[FIRST];
    if (with->settings->bilateral) {
        weigh_by_extinction(with, vec3_mean(out.sigma_t[FIRST]), &c);
    }
    for (size_t i = 0; i < count; i++) {
        const ord_medium *const m = &with->media[medium[i]];
        if (m->light != NULL) {
            out.sent[SOLVED] =
                vec3_add(out.sent[SOLVED], vec3_mul(sigma_s[i], gather(&c, m->light)));
        }
        if (m->first != NULL) {
            out.sent[FIRST] = vec3_add(out.sent[FIRST], vec3_mul(sigma_s[i], gather(&c, m->first)));
        }
        if (with->carried != NULL) {
            out.sent[CARRIED] =
                vec3_add(out.sent[CARRIED], vec3_mul(sigma_s[i], gather(&c, with->carried)));
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

void ord_march(const air_with_ordinates *with, air_march_scratch *scratch,
               const air_path_lane *lane, air_vec3 out[2])
{
    const bool met = lane->hit.mesh != (uint32_t)AIR_NO_HIT;
    const float longest = with->domain.cell_m / (float)with->settings->march;
    const air_vec3 one = vec3_set1(1.0f), none = vec3_set1(0.0f);
    air_vec3 through[MARCHES] = {one, one, one}, sum[MARCHES] = {none, none, none};
    air_ray_media *const media = &scratch->media;
    air_ray_media_make(media, &with->snapshot->media, lane->origin, lane->dir,
                       met ? lane->hit.t : AIR_FAR);
    for (size_t s = 0; s < media->count; s++) {
        const air_ray_segment *const segment = &media->segments[s];
        if (!attenuates(&with->snapshot->media, segment->regions)) {
            continue;
        }
        const float extent = segment->t1 - segment->t0;
        const float count = ceilf(float_min(extent / longest, (float)MOST_STEPS));
        const float length = extent / float_max(count, 1.0f);
        for (float n = 0.0f; n < count; n += 1.0f) {
            const float t = segment->t0 + (n + lane->u_distance) * length;
            const look seen =
                look_at(with, segment->regions, vec3_madd(lane->origin, t, lane->dir));
            for (int i = 0; i < MARCHES; i++) {
                step(seen.sigma_t[i], seen.sent[i], length, &through[i], &sum[i]);
            }
            if (vec3_max(through[SOLVED]) < LEAST_SHARE) {
                s = media->count;
                break;
            }
        }
    }
    if (with->all && !met) {
        const air_vec3 peak = vec3_sub(through[SOLVED], through[FIRST]);
        sum[SOLVED] =
            vec3_add(sum[SOLVED], vec3_mul(peak, ord_sky_radiance(&with->sky, lane->dir)));
    }
    out[0] = vec3_add(sum[SOLVED], sum[CARRIED]);
    out[1] = sum[FIRST];
}

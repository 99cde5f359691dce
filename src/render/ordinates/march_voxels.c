/* march_voxels.c: stretches of rays through the voxels of a region, as many as have the same one
 * side by side. */
#include <math.h>

#include "render/ordinates/march.h"

/* Rays of one region, coordinate by coordinate. */
typedef struct bundle {
    const ord_voxels *voxels;
    size_t count, lane[AIR_PATH_LANES];
    float origin[3][AIR_PATH_LANES], dir[3][AIR_PATH_LANES];
    float t0[AIR_PATH_LANES], t1[AIR_PATH_LANES], jitter[AIR_PATH_LANES];
    float longest_m;
} bundle;

/* The part of the stretch that is in the voxels' box. */
static void clip(const ord_voxels *v, const float origin[3], const float dir[3], float *t0,
                 float *t1)
{
    for (int axis = 0; axis < 3; axis++) {
        if (dir[axis] != 0.0f) {
            const float a = (v->low[axis] - origin[axis]) / dir[axis];
            const float b = (v->high[axis] - origin[axis]) / dir[axis];
            *t0 = float_max(*t0, float_min(a, b));
            *t1 = float_min(*t1, float_max(a, b));
        } else if (origin[axis] < v->low[axis] || origin[axis] > v->high[axis]) {
            *t1 = *t0;
        }
    }
}

static void add_ray(bundle *b, const air_path_lane *lane, const ord_span *span, size_t index)
{
    const size_t n = b->count;
    float origin[3], dir[3], t0 = span->t0, t1 = span->t1;
    vec3_store(origin, lane->origin);
    vec3_store(dir, lane->dir);
    clip(b->voxels, origin, dir, &t0, &t1);
    if (!(t1 > t0)) {
        return;
    }
    for (int axis = 0; axis < 3; axis++) {
        b->origin[axis][n] = origin[axis] - b->voxels->low[axis];
        b->dir[axis][n] = dir[axis];
    }
    b->t0[n] = t0;
    b->t1[n] = t1;
    b->jitter[n] = lane->u_distance;
    b->lane[n] = index;
    b->longest_m = float_max(b->longest_m, t1 - t0);
    b->count++;
}

typedef float channels[3][AIR_PATH_LANES];

static air_vec3 of_ray(channels from, size_t n) { return vec3(from[0][n], from[1][n], from[2][n]); }

static void add_gathered(const bundle *b, ord_marched march, channels radiance, channels through,
                         ord_gathered *g)
{
    for (size_t n = 0; n < b->count; n++) {
        ord_gathered *const out = &g[b->lane[n]];
        out->sum[march] =
            vec3_add(out->sum[march], vec3_mul(out->through[march], of_ray(radiance, n)));
        out->through[march] = vec3_mul(out->through[march], of_ray(through, n));
    }
}

/* The true extinction is the solver's times the same number everywhere. */
static void let_through(const bundle *b, channels through, ord_gathered *g)
{
    for (size_t n = 0; n < b->count; n++) {
        air_vec3 *const out = &g[b->lane[n]].through[ORD_FIRST];
        const float *const power = b->voxels->power;
        *out = vec3_mul(*out, vec3(powf(through[0][n], power[0]), powf(through[1][n], power[1]),
                                   powf(through[2][n], power[2])));
    }
}

static void march_bundle(const air_with_ordinates *with, const bundle *b, ord_gathered *g)
{
    const air_volume_rays rays = {{b->origin[0], b->origin[1], b->origin[2]},
                                  {b->dir[0], b->dir[1], b->dir[2]},
                                  b->t0,
                                  b->t1,
                                  b->jitter};
    const float cell = with->domain.cell_m / (float)with->settings->march;
    const float step_m = float_min(cell, b->voxels->step_m);
    const float steps = ceilf(float_min(b->longest_m / step_m, ORD_MOST_STEPS));
    for (int m = 0; m < ORD_MARCHES; m++) {
        const air_volume *const volume = &b->voxels->volume[m];
        channels radiance, through;
        float *const to_radiance[3] = {radiance[0], radiance[1], radiance[2]};
        float *const to_through[3] = {through[0], through[1], through[2]};
        if (volume->voxels != NULL) {
            air_volume_march(with->context, volume, &rays, b->count, (uint32_t)steps, to_radiance,
                             to_through);
            add_gathered(b, (ord_marched)m, radiance, through, g);
            if (m == ORD_SOLVED && b->voxels->volume[ORD_FIRST].voxels == NULL) {
                let_through(b, through, g);
            }
        }
    }
}

/* The n-th stretches of rays, where they have so many, region by region. */
static void march_nth(const air_with_ordinates *with, const air_march_scratch *scratch, size_t n,
                      const air_path_lane *lanes, size_t count, ord_gathered *g)
{
    uint32_t left = 0;
    for (size_t i = 0; i < count; i++) {
        left |= scratch->span_count[i] > n ? 1u << i : 0;
    }
    while (left != 0) {
        const uint32_t region = scratch->spans[__builtin_ctz(left)][n].region;
        bundle b = {.voxels = &with->voxels[region]};
        for (size_t i = 0; i < count; i++) {
            const ord_span *const span = &scratch->spans[i][n];
            if ((left >> i & 1u) != 0 && span->region == region) {
                add_ray(&b, &lanes[i], span, i);
                left &= ~(1u << i);
            }
        }
        if (b.count > 0) {
            march_bundle(with, &b, g);
        }
    }
}

void ord_march_voxels(const air_with_ordinates *with, const air_march_scratch *scratch,
                      const air_path_lane *lanes, size_t count, ord_gathered *g)
{
    for (size_t n = 0; n < ORD_SPANS; n++) {
        march_nth(with, scratch, n, lanes, count, g);
    }
}

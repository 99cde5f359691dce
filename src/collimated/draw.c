/* draw.c: many draws along one ray, and their sums with visibility, tile by tile. */
#include "collimated/draw_tile.h"

static air_draw_tile_function *draw_tile_for(const air_context *context)
{
#if defined(__x86_64__)
    const air_cpu cpu = context != NULL ? air_context_cpu(context) : AIR_CPU_C;
    return cpu >= AIR_CPU_AVX512 ? air_draw_tile_avx512
           : cpu >= AIR_CPU_AVX2 ? air_draw_tile_avx2
                                 : air_draw_tile_c;
#else
    (void)context;
    return air_draw_tile_c;
#endif
}

void air_draw_tile_c(air_collimated_estimator estimator, const air_collimated_profile *profile,
                     air_draw_tile *tile)
{
    air_draw_all(estimator, profile, tile);
}

void air_collimated_draw_many(const air_context *context, air_collimated_estimator estimator,
                              const air_collimated_profile *profile, const double *u, size_t count,
                              double *out_t, double *out_unoccluded)
{
    air_draw_tile_function *draw_tile = draw_tile_for(context);
    const bool drawn = profile->count > 0, constant = !drawn || estimator == AIR_COLLIMATED_WVDS;
    const double integral = drawn ? air_collimated_integral(profile) : 0.0;
    air_draw_tile tile;
    for (size_t at = 0; at < count; at += AIR_DRAW_TILE) {
        tile.count = count - at < AIR_DRAW_TILE ? count - at : AIR_DRAW_TILE;
        memcpy(tile.u, u + at, tile.count * sizeof *u);
        if (drawn) {
            draw_tile(estimator, profile, &tile);
        }
        for (size_t i = 0; i < tile.count; i++) {
            out_t[at + i] = drawn ? tile.t[i] : 0.0;
        }
        for (size_t i = 0; i < tile.count && out_unoccluded != NULL; i++) {
            out_unoccluded[at + i] = constant ? integral : tile.unoccluded[i];
        }
    }
}

static size_t count_visible(const uint8_t *occluded, size_t count)
{
    size_t visible = count;
    for (size_t i = 0; i < count; i++) {
        visible -= occluded[i];
    }
    return visible;
}

/* In four strands, so that additions do not wait for each other. */
static void add_visible(const air_draw_tile *tile, const uint8_t *occluded,
                        air_collimated_sums *sums)
{
    double all[4] = {0.0}, seen[4] = {0.0};
    for (size_t i = 0; i < tile->count; i++) {
        const double value = tile->unoccluded[i];
        all[i % 4] += value;
        seen[i % 4] += value * (double)(1 - occluded[i]);
    }
    sums->unoccluded += (all[0] + all[1]) + (all[2] + all[3]);
    sums->occluded += (seen[0] + seen[1]) + (seen[2] + seen[3]);
}

air_collimated_sums air_collimated_gather(const air_context *context,
                                          air_collimated_estimator estimator,
                                          const air_collimated_profile *profile,
                                          const double origin[3], const double dir[3],
                                          const double *u, size_t count,
                                          air_collimated_occluded occluded, void *user)
{
    air_draw_tile_function *draw_tile = draw_tile_for(context);
    air_collimated_sums sums = {0.0, 0.0, 0.0};
    air_draw_tile tile;
    double *const x = tile.a, *const y = tile.b, *const z = tile.c; /* no longer needed there */
    const double *const points[3] = {x, y, z};
    uint8_t hidden[AIR_DRAW_TILE];
    if (profile->count == 0) {
        return sums;
    }
    size_t visible = 0;
    for (size_t at = 0; at < count; at += AIR_DRAW_TILE) {
        tile.count = count - at < AIR_DRAW_TILE ? count - at : AIR_DRAW_TILE;
        memcpy(tile.u, u + at, tile.count * sizeof *u);
        draw_tile(estimator, profile, &tile);
        for (size_t i = 0; i < tile.count; i++) {
            x[i] = origin[0] + tile.t[i] * dir[0];
            y[i] = origin[1] + tile.t[i] * dir[1];
            z[i] = origin[2] + tile.t[i] * dir[2];
        }
        occluded(user, points, tile.count, hidden);
        if (estimator == AIR_COLLIMATED_WVDS) {
            visible += count_visible(hidden, tile.count);
        } else {
            add_visible(&tile, hidden, &sums);
        }
    }
    const double integral = air_collimated_integral(profile);
    sums.analytic = (double)count * integral;
    if (estimator == AIR_COLLIMATED_WVDS) {
        sums.unoccluded = sums.analytic;
        sums.occluded = (double)visible * integral;
    }
    return sums;
}

size_t air_collimated_choose(const double *contributions, size_t count, double u, double *rest)
{
    double total = 0.0;
    for (size_t i = 0; i < count; i++) {
        total += contributions[i];
    }
    double left = u * total;
    size_t chosen = 0;
    for (size_t i = 0; i < count; i++) {
        if (contributions[i] > 0.0) {
            chosen = i;
            if (left < contributions[i]) {
                break;
            }
            left -= contributions[i];
        }
    }
    const double share = contributions[chosen] > 0.0 ? left / contributions[chosen] : u;
    *rest = share < 1.0 - 0x1p-53 ? share : 1.0 - 0x1p-53;
    return chosen;
}

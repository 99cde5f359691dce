/* draw_tile.h: up to a tile of draws along one ray, built once per instruction set.
 *
 * Numbers that rise meet one piece after the other, so a piece's constants are found once and laid
 * out beside its numbers; then one loop without branches, of which the compiler makes lanes, does
 * the tile. */
#ifndef AIR_COLLIMATED_DRAW_TILE_H
#define AIR_COLLIMATED_DRAW_TILE_H

#include "collimated/exponentials.h"
#include "collimated/pieces.h"

enum { AIR_DRAW_TILE = 256, AIR_DRAW_BLOCK = 8 };

/* Numbers and what becomes of them; what a to d mean is said where they are filled. Lanes beyond
 * the count, to the end of a block, hold 0. */
typedef struct air_draw_tile {
    double u[AIR_DRAW_TILE];
    double a[AIR_DRAW_TILE], b[AIR_DRAW_TILE], c[AIR_DRAW_TILE], d[AIR_DRAW_TILE];
    double t[AIR_DRAW_TILE], unoccluded[AIR_DRAW_TILE];
    size_t count;
} air_draw_tile;

/* Sets t, and unoccluded except by WVDS, where it is the integral. The profile is not empty. */
typedef void air_draw_tile_function(air_collimated_estimator estimator,
                                    const air_collimated_profile *profile, air_draw_tile *tile);

air_draw_tile_function air_draw_tile_c;
air_draw_tile_function air_draw_tile_avx2;
air_draw_tile_function air_draw_tile_avx512;

static inline size_t air_draw_padded(size_t count)
{
    return (count + AIR_DRAW_BLOCK - 1) / AIR_DRAW_BLOCK * AIR_DRAW_BLOCK;
}

static inline void air_draw_pad(air_draw_tile *tile)
{
    for (size_t i = tile->count; i < air_draw_padded(tile->count); i++) {
        tile->u[i] = tile->a[i] = tile->b[i] = tile->c[i] = tile->d[i] = tile->t[i] = 0.0;
    }
}

/* The first of the numbers from `at` on that is not below the limit. */
static inline size_t air_draw_until(const double *numbers, size_t at, size_t count, double limit)
{
    while (at < count && numbers[at] < limit) {
        at++;
    }
    return at;
}

static inline void air_draw_fill(air_draw_tile *tile, size_t begin, size_t end, double a, double b,
                                 double c, double d)
{
    for (size_t i = begin; i < end; i++) {
        tile->a[i] = a;
        tile->b[i] = b;
        tile->c[i] = c;
        tile->d[i] = d;
    }
}

static inline double air_draw_clamp(double x, double low, double high)
{
    const double not_above = air_double_select(x < high, x, high);
    return air_double_select(not_above > low, not_above, low);
}

/* Rounding leads no further than the ends. */
static inline void air_draw_clamp_all(const air_collimated_profile *profile, air_draw_tile *tile)
{
    const double begin = profile->pieces[0].t0, end = profile->pieces[profile->count - 1].t1;
    const size_t padded = air_draw_padded(tile->count);
    for (size_t i = 0; i < padded; i++) {
        tile->t[i] = air_draw_clamp(tile->t[i], begin, end);
    }
}

/* Pieces of constant depth: t is affine in u there. */
static inline void air_draw_flat_pieces(const air_collimated_profile *profile, air_draw_tile *tile)
{
    for (size_t k = 0, i = 0; i < tile->count; k++) {
        const air_collimated_piece *p = &profile->pieces[k];
        const bool last = k + 1 == profile->count;
        const double after = last ? profile->scaled : p[1].before;
        const size_t end =
            air_draw_until(tile->u, i, tile->count, last ? INFINITY : after / profile->scaled);
        for (; i < end; i++) {
            if (fabs(p->depth1 - p->depth0) < 1e-12) {
                const double share =
                    (tile->u[i] * profile->scaled - p->before) / (after - p->before);
                tile->t[i] = p->t0 + share * air_piece_length(p);
            }
        }
    }
}

/* t = c + d (-log(1 - (a + b u))): the bracket is the share of a piece's integral, counted from its
 * thinner end, that the number leaves behind, times 1 - exp(-x), x the change of depth. */
static inline void air_draw_whole_volume(const air_collimated_profile *profile, air_draw_tile *tile)
{
    bool flat = false;
    for (size_t k = 0, i = 0; i < tile->count; k++) {
        const air_collimated_piece *p = &profile->pieces[k];
        const bool last = k + 1 == profile->count;
        const double after = last ? profile->scaled : p[1].before;
        const size_t end =
            air_draw_until(tile->u, i, tile->count, last ? INFINITY : after / profile->scaled);
        if (end > i) {
            const double rise = p->depth1 - p->depth0, x = fabs(rise);
            const double least = rise < 0.0 ? p->depth1 : p->depth0;
            const double thin =
                least == profile->least_depth ? 1.0 : exp(profile->least_depth - least);
            /* The piece's integral is weight length thin (1 - exp(-x))/x. */
            const double per_integral = x / (p->weight * air_piece_length(p) * thin);
            const double loss = per_integral * (after - p->before);
            const double scale = x < 1e-12 ? 0.0 : air_piece_length(p) / rise;
            const double a = -per_integral * p->before, b = per_integral * profile->scaled;
            air_draw_fill(tile, i, end, rise < 0.0 ? loss - a : a, rise < 0.0 ? -b : b,
                          rise < 0.0 ? p->t1 : p->t0, scale);
            flat = flat || x < 1e-12;
        }
        i = end;
    }
    air_draw_pad(tile);
    const double largest = 1.0 - 0x1p-53;
    const size_t padded = air_draw_padded(tile->count);
    for (size_t i = 0; i < padded; i++) {
        const double y = air_draw_clamp(tile->a[i] + tile->b[i] * tile->u[i], 0.0, largest);
        tile->t[i] = tile->c[i] + tile->d[i] * air_neg_log1m_double(y);
    }
    if (flat) {
        air_draw_flat_pieces(profile, tile);
    }
    air_draw_clamp_all(profile, tile);
}

/* t = a + total u, unoccluded = d exp(-(b + c u)). */
static inline void air_draw_uniform(const air_collimated_profile *profile, air_draw_tile *tile)
{
    const double total = air_profile_length(profile);
    double before = 0.0;
    for (size_t k = 0, i = 0; i < tile->count; k++) {
        const air_collimated_piece *p = &profile->pieces[k];
        const bool last = k + 1 == profile->count;
        const double slope = (p->depth1 - p->depth0) / air_piece_length(p), begin = before;
        before += air_piece_length(p);
        const size_t end =
            air_draw_until(tile->u, i, tile->count, last ? INFINITY : before / total);
        air_draw_fill(tile, i, end, p->t0 - begin, p->depth0 - slope * begin, slope * total,
                      p->weight * total);
        i = end;
    }
    air_draw_pad(tile);
    const size_t padded = air_draw_padded(tile->count);
    for (size_t i = 0; i < padded; i++) {
        const double depth = tile->b[i] + tile->c[i] * tile->u[i];
        tile->t[i] = tile->a[i] + total * tile->u[i];
        tile->unoccluded[i] = tile->d[i] * air_decay(air_draw_clamp(depth, 0.0, INFINITY));
    }
    air_draw_clamp_all(profile, tile);
}

/* Without gaps, and thinning out all the way: then the depth from the camera is -log(1 - u Z). */
static inline bool air_draw_one_run(const air_collimated_profile *profile)
{
    for (size_t k = 0; k < profile->count; k++) {
        const air_collimated_piece *p = &profile->pieces[k];
        if (!(p->camera1 > p->camera0) || (k > 0 && p->camera0 != p[-1].camera1)) {
            return false;
        }
    }
    return true;
}

/* With s = -log(1 - Z u), the depth from the camera, in the place of u: t = a + b s; unoccluded is
 * the inverse density without its exponential times exp(-(c + d s)), the way to the light. */
static inline void air_draw_by_extinction(const air_collimated_profile *profile,
                                          air_draw_tile *tile)
{
    const double base = profile->pieces[0].camera0;
    const double total = -expm1(base - profile->pieces[profile->count - 1].camera1);
    air_draw_pad(tile);
    const size_t padded = air_draw_padded(tile->count);
    for (size_t i = 0; i < padded; i++) {
        tile->u[i] = air_neg_log1m_double(total * tile->u[i]);
    }
    for (size_t k = 0, i = 0; i < tile->count; k++) {
        const air_collimated_piece *p = &profile->pieces[k];
        const bool last = k + 1 == profile->count;
        const double rise = p->camera1 - p->camera0, first = p->camera0 - base;
        const double light0 = p->depth0 - p->camera0, light1 = p->depth1 - p->camera1;
        const double per_depth = air_piece_length(p) / rise, slope = (light1 - light0) / rise;
        const size_t end =
            air_draw_until(tile->u, i, tile->count, last ? INFINITY : p->camera1 - base);
        air_draw_fill(tile, i, end, p->t0 - per_depth * first, per_depth,
                      light0 + base - slope * first, slope);
        for (size_t j = i; j < end; j++) {
            tile->unoccluded[j] = p->weight * total * per_depth;
        }
        i = end;
    }
    air_draw_pad(tile);
    for (size_t i = 0; i < padded; i++) {
        const double light = tile->c[i] + tile->d[i] * tile->u[i];
        tile->t[i] = tile->a[i] + tile->b[i] * tile->u[i];
        tile->unoccluded[i] *= air_decay(air_draw_clamp(light, 0.0, INFINITY));
    }
    air_draw_clamp_all(profile, tile);
}

static inline void air_draw_all(air_collimated_estimator estimator,
                                const air_collimated_profile *profile, air_draw_tile *tile)
{
    const bool by_extinction = estimator == AIR_COLLIMATED_DS || estimator == AIR_COLLIMATED_REDS;
    if (estimator == AIR_COLLIMATED_WVDS) {
        air_draw_whole_volume(profile, tile);
    } else if (!by_extinction) {
        air_draw_uniform(profile, tile);
    } else if (air_draw_one_run(profile)) {
        air_draw_by_extinction(profile, tile);
    } else {
        for (size_t i = 0; i < tile->count; i++) {
            const air_collimated_draw draw =
                air_collimated_estimate(estimator, profile, tile->u[i]);
            tile->t[i] = draw.t;
            tile->unoccluded[i] = draw.unoccluded;
        }
    }
}

#endif

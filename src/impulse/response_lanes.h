/* response_lanes.h: many places, for the instruction set of the including file, which defines
 * IMPULSE_BATCH as the function's name.
 *
 * Where things lie is found in lanes, a tile at a time; then each place takes its entries as
 * vectors. */
#include "core/lanes_float.h"

#include "impulse/response.h"

enum { BATCH_TILE = 64 };

/* Indices and shares of a tile's places. */
typedef struct batch_tile {
    int32_t bin[BATCH_TILE], angle[BATCH_TILE];
    float share[BATCH_TILE], angle_share[BATCH_TILE], scale[BATCH_TILE];
    float distance[BATCH_TILE], cos_s[BATCH_TILE]; /* copied, the end filled up */
} batch_tile;

/* Below 2^22 in size, what is added leaves the nearest integer in the low bits. */
static inline lanes lanes_exp(lanes x)
{
    const lanes magic = lanes_all(0x1.8p23f), one = lanes_all(1.0f);
    const lanes least = lanes_max(x, lanes_all(-86.0f));
    const lanes shifted = lanes_madd(least, lanes_all(1.44269504f), magic), n = shifted - magic;
    const lanes r = lanes_nmadd(n, lanes_all(2.12194440e-4f) * -1.0f,
                                lanes_nmadd(n, lanes_all(0.693359375f), least));
    const lanes r2 = r * r;
    const lanes p23 = lanes_madd(r, lanes_all(1.0f / 6.0f), lanes_all(0.5f));
    const lanes p45 = lanes_madd(r, lanes_all(1.0f / 120.0f), lanes_all(1.0f / 24.0f));
    const lanes p6 = lanes_all(1.0f / 720.0f);
    const lanes p = lanes_madd(r2, lanes_madd(r2, lanes_madd(r2, p6, p45), p23), r);
    const lanes power = (lanes)(((lane_ints)shifted << 23) + (lane_ints)one);
    return lanes_madd(p, power, power);
}

/* As impulse_cube_root. */
static inline lanes lanes_cube_root(lanes x)
{
    const lanes bits = __builtin_convertvector((lane_ints)x, lanes);
    const lanes third = bits * lanes_all(1.0f / 3.0f), one = lanes_all(1.0f);
    lanes y = (lanes)(0x54a20000 - __builtin_convertvector(third, lane_ints));
    for (int i = 0; i < 2; i++) {
        const lanes e = lanes_nmadd(x * y, y * y, one);
        const lanes f = lanes_madd(e, lanes_all(2.0f / 9.0f), lanes_all(1.0f / 3.0f));
        y = lanes_madd(y * e, f, y);
    }
    return x * y * y;
}

/* As impulse_arc_cosine. */
static inline lanes lanes_arc_cosine(lanes c)
{
    const lanes a = lanes_abs(c), a2 = a * a;
    const lanes p01 = lanes_madd(a, lanes_all(-0.2145988016f), lanes_all(1.5707963050f));
    const lanes p23 = lanes_madd(a, lanes_all(-0.0501743046f), lanes_all(0.0889789874f));
    const lanes p45 = lanes_madd(a, lanes_all(-0.0170881256f), lanes_all(0.0308918810f));
    const lanes p67 = lanes_madd(a, lanes_all(-0.0012624911f), lanes_all(0.0066700901f));
    const lanes p = lanes_madd(a2 * a2, lanes_madd(a2, p67, p45), lanes_madd(a2, p23, p01));
    const lanes angle = lanes_root(lanes_max(lanes_all(1.0f) - a, lanes_all(1e-30f))) * p;
    return lanes_select(lanes_less(c, lanes_all(0.0f)), AIR_PI_F - angle, angle);
}

static inline void lanes_place(lanes at, lanes last, int32_t *out_lower, float *out_share)
{
    const lane_ints lower = __builtin_convertvector(lanes_min(at, last), lane_ints);
    memcpy(out_lower, &lower, sizeof lower);
    lanes_store(out_share, at - __builtin_convertvector(lower, lanes));
}

static void tile_bins(const air_impulse_response *r, const response_channel *c, size_t count,
                      batch_tile *tile)
{
    const lanes first = lanes_all(r->first), last = lanes_all((float)(int32_t)r->bins - 1.0f);
    const lanes zero = lanes_all(0.0f), sigma = lanes_all(c->sigma); /* 0: scale is, too */
    const bool directional = r->emitter == AIR_IMPULSE_DIRECTIONAL;
    for (size_t i = 0; i < count; i += LANES) {
        const lanes distance = lanes_load(tile->distance + i);
        const lanes rho = lanes_max(sigma * distance, lanes_all(1e-20f));
        const lanes u = lanes_cube_root(rho * (float)(1.0 / IMPULSE_TAU_GREATEST));
        const lanes at = lanes_min(last, lanes_max(zero, (u - first) * r->scale));
        const lanes fall = lanes_exp(rho * -c->fall);
        lanes scale = fall;
        if (!directional) {
            scale = fall * sigma / distance;
        }
        const lane_mask beyond = lanes_less(lanes_all((float)IMPULSE_TAU_GREATEST), rho);
        lanes_place(at, last - 1.0f, tile->bin + i, tile->share + i);
        lanes_store(tile->scale + i, lanes_select(beyond, zero, scale));
    }
}

static void tile_angles(const air_impulse_response *r, size_t count, batch_tile *tile)
{
    const lanes last = lanes_all((float)(int32_t)r->angles - 2.0f), one = lanes_all(1.0f);
    for (size_t i = 0; i < count; i += LANES) {
        const lanes c = lanes_max(-one, lanes_min(one, lanes_load(tile->cos_s + i)));
        const lanes turned = lanes_arc_cosine(c) * r->angle_scale;
        const lanes more = lanes_max(turned - r->quarter, lanes_all(0.0f));
        lanes_place(turned + more, last, tile->angle + i, tile->angle_share + i);
    }
}

static void tile_sums(const air_impulse_response *r, const response_channel *c,
                      const batch_tile *tile, const float *n_l, const float *n_x, size_t count,
                      float *out)
{
    const size_t step = r->bins * AREA_POWERS;
    for (size_t i = 0; i < count && n_x != NULL; i++) {
        const float *const at =
            c->entries + (size_t)tile->angle[i] * step + (size_t)tile->bin[i] * AREA_POWERS;
        const float sum = area_sum(at, step, tile->share[i], tile->angle_share[i], n_l[i], n_x[i]);
        out[i] = float_max(0.0f, sum * tile->scale[i]);
    }
    for (size_t i = 0; i < count && n_x == NULL; i++) {
        const float *const at = c->entries + (size_t)tile->bin[i] * ZONAL_POWERS;
        out[i] = float_max(0.0f, zonal_sum(at, tile->share[i], n_l[i]) * tile->scale[i]);
    }
}

static void copy_padded(const float *from, size_t count, float *out)
{
    memcpy(out, from, count * sizeof *out);
    for (size_t i = count; i % LANES != 0; i++) {
        out[i] = from[count - 1];
    }
}

void IMPULSE_BATCH(const air_impulse_response *response, const air_impulse_places *places,
                   size_t count, float *const *out)
{
    const bool area = response->emitter == AIR_IMPULSE_AREA;
    for (size_t start = 0; start < count; start += BATCH_TILE) {
        const size_t n = count - start < BATCH_TILE ? count - start : BATCH_TILE;
        const float *const n_l = places->n_l + start;
        batch_tile tile;
        copy_padded(places->distance + start, n, tile.distance);
        if (area) {
            copy_padded(places->cos_s + start, n, tile.cos_s);
            tile_angles(response, n, &tile);
        }
        for (size_t i = 0; i < response->channel_count; i++) {
            const response_channel *const c = &response->channels[i];
            float *const to = out[i] + start;
            tile_bins(response, c, n, &tile);
            tile_sums(response, c, &tile, n_l, area ? places->n_x + start : NULL, n, to);
            for (size_t j = 0; j < n && c->whole > 0.0f; j++) {
                to[j] += response_excess(response, c, tile.distance[j], n_l[j],
                                         area ? tile.cos_s[j] : 1.0f);
            }
        }
    }
}

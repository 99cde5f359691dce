/* corners.h: the light of cells at a point between their centres. */
#ifndef AIR_RENDER_ORDINATES_CORNERS_H
#define AIR_RENDER_ORDINATES_CORNERS_H

#include "core/exponential.h"
#include "render/ordinates/state.h"

/* Eight cells about a point, and their shares. */
typedef struct ord_corners {
    size_t cell[8];
    float weight[8];
} ord_corners;

/* Along one axis: the two cells about a place, and the share of the higher one. In the outer half
 * cells the line through the two nearest centres goes on (onward), or the outer centre's light
 * holds there (held). */
typedef struct ord_neighbours {
    size_t low, high;
    float onward, held;
} ord_neighbours;

static inline ord_neighbours ord_neighbours_find(float place, size_t cells)
{
    const size_t last = cells > 1 ? cells - 2 : 0;
    const size_t low = (size_t)float_min(float_max(place, 0.0f), (float)(ptrdiff_t)last);
    const float share = place - (float)(ptrdiff_t)low;
    return (ord_neighbours){low, low + 1 < cells ? low + 1 : low,
                            float_min(float_max(share, -0.5f), 1.5f),
                            float_min(float_max(share, 0.0f), 1.0f)};
}

/* How alike the extinctions of a cell and of a point are: exp(-(s(p) - s(q))^2 / (2 r^2)), r a
 * tenth of the largest. [Elek2014, section 5.4] */
static inline float ord_likeness(const air_with_ordinates *with, size_t cell, float sigma_t)
{
    const float inverse = 1.0f / (0.1f * with->largest + 1e-6f);
    const float difference = (with->extinction[cell] - sigma_t) * inverse;
    return air_exp(-0.5f * difference * difference);
}

static inline float ord_corner_weight(const ord_neighbours n[3], int corner, bool onward)
{
    float weight = 1.0f;
    for (int axis = 0; axis < 3; axis++) {
        const float share = onward ? n[axis].onward : n[axis].held;
        weight *= (corner >> axis & 1) != 0 ? share : 1.0f - share;
    }
    return weight;
}

/* Weights by place times likeness, which must not be below 0, as they are where lines go on; these
 * count as far as all cells are alike. Where none is, as though likeness were not asked for. */
static inline void ord_corners_weigh(const air_with_ordinates *with, const ord_neighbours n[3],
                                     float sigma_t, ord_corners *c)
{
    float like[8], held[8], least = 1.0f, sum = 0.0f, onward = 0.0f;
    for (int i = 0; i < 8; i++) {
        like[i] = ord_likeness(with, c->cell[i], sigma_t);
        held[i] = like[i] * ord_corner_weight(n, i, false);
        sum += held[i];
        onward += like[i] * c->weight[i];
        least = float_min(least, like[i]);
    }
    for (int i = 0; i < 8 && sum >= 1e-6f; i++) {
        const float share = onward > 0.5f ? least : 0.0f;
        const float line = share > 0.0f ? like[i] * c->weight[i] / onward : 0.0f;
        c->weight[i] = share * line + (1.0f - share) * held[i] / sum;
    }
}

/* sigma_t: the media's extinction at the point, mean of channels. */
static inline ord_corners ord_corners_find(const air_with_ordinates *with, air_vec3 world,
                                           float sigma_t)
{
    const ord_domain *const domain = &with->domain;
    const air_vec3 local = ord_domain_local(domain, world);
    const float at[3] = {local.x, local.y, local.z};
    ord_neighbours n[3];
    ord_corners out;
    for (int axis = 0; axis < 3; axis++) {
        n[axis] = ord_neighbours_find(at[axis] / domain->cell_m - 0.5f, domain->size[axis]);
    }
    for (int c = 0; c < 8; c++) {
        const size_t x = (c & 1) != 0 ? n[0].high : n[0].low;
        const size_t y = (c & 2) != 0 ? n[1].high : n[1].low;
        const size_t z = (c & 4) != 0 ? n[2].high : n[2].low;
        out.cell[c] = (z * domain->size[1] + y) * domain->size[0] + x;
        out.weight[c] = ord_corner_weight(n, c, true);
    }
    if (with->settings->bilateral) {
        ord_corners_weigh(with, n, sigma_t, &out);
    }
    return out;
}

static inline air_vec3 ord_corners_gather(const ord_corners *c, const float *light)
{
    air_vec3 sum = vec3_set1(0.0f);
    for (int i = 0; i < 8; i++) {
        sum = vec3_madd(sum, c->weight[i], vec3_load(light + c->cell[i] * 4));
    }
    return vec3(float_max(sum.x, 0.0f), float_max(sum.y, 0.0f), float_max(sum.z, 0.0f));
}

#endif

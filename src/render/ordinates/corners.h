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

/* In the outer half cells the line through the two nearest centres goes on (`onward`), else the
 * outer centre's light holds there: a border that light falls on would be too dark. */
static inline ord_corners ord_corners_find(const ord_domain *domain, air_vec3 world, bool onward)
{
    const float beyond = onward ? 0.5f : 0.0f;
    const air_vec3 local = ord_domain_local(domain, world);
    const float at[3] = {local.x, local.y, local.z};
    size_t low[3], high[3];
    float share[3];
    ord_corners out;
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
static inline void ord_corners_weigh(const air_with_ordinates *with, float sigma_t, ord_corners *c)
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

static inline air_vec3 ord_corners_gather(const ord_corners *c, const float *light)
{
    air_vec3 sum = vec3_set1(0.0f);
    for (int i = 0; i < 8; i++) {
        sum = vec3_madd(sum, c->weight[i], vec3_load(light + c->cell[i] * 4));
    }
    return vec3(float_max(sum.x, 0.0f), float_max(sum.y, 0.0f), float_max(sum.z, 0.0f));
}

#endif

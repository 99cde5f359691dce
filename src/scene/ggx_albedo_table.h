/* ggx_albedo_table.h: directional albedo of the GGX lobe (height-correlated Smith shadowing),
 * tabulated.
 *
 * For Schlick's Fresnel term F = f0 + (f90 - f0) (1 - cos)^5 the albedo of single scattering
 * towards mu is
 *
 *     E(mu) = f0 (1 - loss(mu)) + (f90 - f0) fresnel(mu)
 *
 * where 1 - loss is the albedo for F = 1 and fresnel that for F = (1 - cos)^5. The tables err on
 * the dark side: between and at the nodes loss is never above its true value and fresnel never
 * below it, so that what is built on them cannot give out more than it takes in.
 * `test_ggx_albedo_table --print` writes the tables' source. */
#ifndef AIR_SCENE_GGX_ALBEDO_TABLE_H
#define AIR_SCENE_GGX_ALBEDO_TABLE_H

#include <math.h>

enum { AIR_GGX_MU_COUNT = 64, AIR_GGX_ALPHA_COUNT = 32, AIR_GGX_MEAN_COUNT = 249 };
/* Every eighth mean lies on an alpha node: 249 = 31 * 8 + 1. */

typedef struct air_ggx_albedo {
    float loss, fresnel;
} air_ggx_albedo;

/* [alpha][mu]: the directional albedo; [alpha]: its cosine-weighted mean, 2 integral E mu dmu. */
extern const air_ggx_albedo air_ggx_albedo_table[AIR_GGX_ALPHA_COUNT][AIR_GGX_MU_COUNT];
extern const air_ggx_albedo air_ggx_albedo_mean_table[AIR_GGX_MEAN_COUNT];

/* The smallest alpha of the tables. */
static inline float air_ggx_alpha_min(void) { return 1e-3f; }

/* alpha to [0, 1], linear in roughness = sqrt(alpha). */
static inline float air_ggx_alpha_axis(float alpha)
{
    const float start = 0.0316227766f; /* sqrt(air_ggx_alpha_min()) */
    return (sqrtf(alpha) - start) / (1.0f - start);
}

/* mu to [0, 1]. The albedo dips at mu = alpha, whatever alpha: half of the resolution follows mu /
 * alpha, the other half resolves (1 - mu)^5. Both are rational, so that a loss that starts linearly
 * in mu does so in the table. */
static inline float air_ggx_mu_axis(float mu, float alpha)
{
    return 0.5f * mu * ((1.0f + alpha) / (mu + alpha) + 1.25f / (mu + 0.25f));
}

/* The cell of an axis of `count` nodes that x in [0, 1] falls into; *out_share is where within it.
 */
static inline int air_ggx_cell(float x, int count, float *out_share)
{
    const float scaled = x * (float)(count - 1);
    int cell = (int)scaled;
    cell = cell < count - 2 ? cell : count - 2;
    *out_share = scaled - (float)cell;
    return cell;
}

static inline air_ggx_albedo air_ggx_mix(air_ggx_albedo a, air_ggx_albedo b, float share)
{
    return (air_ggx_albedo){a.loss + share * (b.loss - a.loss),
                            a.fresnel + share * (b.fresnel - a.fresnel)};
}

/* The directional albedo at mu in [0, 1]; alpha_axis is air_ggx_alpha_axis(alpha). */
static inline air_ggx_albedo air_ggx_albedo_at(float mu, float alpha, float alpha_axis)
{
    float row_share, column_share;
    const int row = air_ggx_cell(alpha_axis, AIR_GGX_ALPHA_COUNT, &row_share);
    const int column = air_ggx_cell(air_ggx_mu_axis(mu, alpha), AIR_GGX_MU_COUNT, &column_share);
    const air_ggx_albedo *low = air_ggx_albedo_table[row] + column;
    const air_ggx_albedo *high = air_ggx_albedo_table[row + 1] + column;
    return air_ggx_mix(air_ggx_mix(low[0], low[1], column_share),
                       air_ggx_mix(high[0], high[1], column_share), row_share);
}

/* Its cosine-weighted mean. */
static inline air_ggx_albedo air_ggx_albedo_mean(float alpha_axis)
{
    float share;
    const int cell = air_ggx_cell(alpha_axis, AIR_GGX_MEAN_COUNT, &share);
    return air_ggx_mix(air_ggx_albedo_mean_table[cell], air_ggx_albedo_mean_table[cell + 1], share);
}

#endif

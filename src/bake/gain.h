/* gain.h: what the samples of one receiver add up to. */
#ifndef AIR_BAKE_GAIN_H
#define AIR_BAKE_GAIN_H

#include "airlight/lightmap.h"
#include "path/path.h"

/* Sums over samples. */
typedef struct air_gain {
    double layers[AIR_LAYER_COUNT][3]; /* irradiance; fluence of points in space */
    double squares[AIR_LAYER_COUNT];   /* of the samples' luminance */
    double harmonics[AIR_LAYER_COUNT][AIR_PROBE_COEFFICIENTS][3]; /* incident radiance */
    double samples;
} air_gain;

/* Adds one traced lane, with `count` coefficients of harmonics (0, 4 or 9). */
void air_gain_add(air_gain *gain, const air_path_lane *lane, size_t count);

/* Adds other to gain. */
void air_gain_merge(air_gain *gain, const air_gain *other, size_t count);

/* Did the lane's first ray meet the back of a surface that has a front only? Then it started inside
 * of something solid. */
bool air_gain_is_buried(const air_snapshot *snapshot, const air_path_lane *lane);

#endif

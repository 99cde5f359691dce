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

/* Normals whose irradiance says all that bands 0 to 2 of the radiance do: the corners of an
 * icosahedron, even to degree 5. Surfaces have their own normal in front of them. */
enum { AIR_GAIN_AXES = AIR_RECEIVER_AXES };
/* Fills axes[0..AIR_GAIN_AXES) for a receiver and makes them its own. coefficients: as below. */
void air_gain_set_axes(air_path_receiver *receiver, size_t coefficients,
                       air_vec3 axes[AIR_GAIN_AXES]);

/* Adds one traced lane, with `count` coefficients of harmonics (0, 4 or 9). */
void air_gain_add(air_gain *gain, const air_path_lane *lane, size_t count);

/* Adds other to gain. */
void air_gain_merge(air_gain *gain, const air_gain *other, size_t count);

/* Did the lane's first ray meet the back of a surface that has a front only? Then it started inside
 * of something solid. Leaves and the like, which have holes, enclose nothing; what is in glass is
 * seen. */
bool air_gain_is_buried(const air_snapshot *snapshot, const air_path_lane *lane);

#endif

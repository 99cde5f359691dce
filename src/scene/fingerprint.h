/* fingerprint.h: a number that differs where pictures would. */
#ifndef AIR_SCENE_FINGERPRINT_H
#define AIR_SCENE_FINGERPRINT_H

#include "scene/snapshot.h"

/* Mixes size bytes into a hash. */
uint64_t air_fingerprint_add(uint64_t hash, const void *data, size_t size);

/* Of everything in a snapshot that a picture depends on, but for the camera: geometry, materials
 * with their textures, lights, media with their grids. */
uint64_t air_fingerprint_snapshot(const air_snapshot *snapshot);

#endif

/* ordinates_beam.h: unscattered light in a box of cells: attenuated, mean over each cell.
 *
 * Plain functions over arrays, without threads or allocation; calls with their own output may run
 * at once. Cells and their order are those of ordinates_dom.h; numbers of cells come in fours,
 * three channels and one that is not looked at. */
#ifndef AIRLIGHT_ORDINATES_BEAM_H
#define AIRLIGHT_ORDINATES_BEAM_H

#include <stddef.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A box of cells from the origin along the axes. */
typedef struct air_beam_box {
    size_t size[3];          /* cells, >= 1 */
    float cell_m[3];         /* edges of a cell, > 0 */
    const float *extinction; /* per metre, >= 0, finite; 4 per cell; borrowed */
} air_beam_box;

/* Bytes of scratch for air_beam_directional, of any alignment. */
AIR_API size_t air_beam_scratch(const size_t size[3]);

/* Fluence of light that travels along unit dir and has irradiance 1 across it outside the box: its
 * mean transmittance over each cell, 4 per cell to out_fluence.
 *
 * Optical depths of the centres of faces across the main axis are carried from layer to layer along
 * characteristics, bilinear between centres; along an axis this is exact for what is constant in
 * each cell. A cell's mean takes the depth to change evenly across it. The context chooses the
 * instruction set; NULL is legal and takes the plainest. */
AIR_API void air_beam_directional(const air_context *context, const air_beam_box *box,
                                  const float dir[3], void *scratch, float *out_fluence);

/* Transmittance between a point, in or outside the box, and the centre of each cell, 4 per cell to
 * out. The extinction of a cell is constant in it. */
AIR_API void air_beam_point(const air_beam_box *box, const float position[3], float *out);

/* The four optical depths between two points. */
AIR_API void air_beam_depth(const air_beam_box *box, const float from[3], const float to[3],
                            float out[4]);

/* The mean of 1/r^2 over each cell as seen from a point, one number per cell: times an intensity
 * the fluence of a point light without attenuation. Finite in the cell that holds the point. */
AIR_API void air_beam_spread(const air_beam_box *box, const float position[3], float *out);

#ifdef __cplusplus
}
#endif
#endif

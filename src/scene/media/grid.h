/* grid.h: a sparse voxel grid: 8^3 bricks with an apron, so that a trilinear lookup reads one
 * brick, and per-brick maxima as majorants. Values are at integer index coordinates; outside [-1/2,
 * size-1/2] the grid is 0; between the outermost sample and that edge the value is held. */
#ifndef AIR_SCENE_MEDIA_GRID_H
#define AIR_SCENE_MEDIA_GRID_H

#include "airlight/medium.h"
#include "core/host.h"
#include "core/vec.h"

enum { AIR_BRICK = 8 };

typedef struct air_grid air_grid;

/* Copies the description into bricks; negative values are clamped to 0 and counted in a warning. */
air_status air_grid_create(air_context *context, const air_grid_desc *desc, air_grid **out_grid);
void air_grid_destroy(air_grid *grid);

const float *air_grid_index_to_local(const air_grid *grid); /* 12 floats */
void air_grid_size(const air_grid *grid, size_t out_size[3]);
size_t air_grid_channels(const air_grid *grid);
size_t air_grid_bytes(const air_grid *grid);
float air_grid_max(const air_grid *grid); /* over all values and channels */

/* The least box in index coordinates outside which no lookup, of any channel, is above `above`
 * (>= 0). False: none is anywhere; out is then untouched. */
bool air_grid_support(const air_grid *grid, float above, float out_low[3], float out_high[3]);

/* Trilinear value at index coordinates; one-channel grids give the same in x, y and z. */
air_vec3 air_grid_lookup(const air_grid *grid, air_vec3 index);

/* Walks the bricks along the index-space ray origin + t dir, t in (t0, t1): a 3-D DDA over
 * brick-sized cells in index space (dir need not be unit; t is the caller's parameter; t1 may be
 * INFINITY). */
typedef struct air_grid_walk {
    const air_grid *grid;
    float t, t_end;         /* where the walk is, and t1 */
    float t_enter, t_leave; /* the part of (t0, t1) inside the grid; empty: both t1 */
    float origin[3], inverse_dir[3];
    float t_next[3]; /* where the ray leaves the present cell along each axis */
    int32_t cell[3], cell_step[3];
} air_grid_walk;

void air_grid_walk_start(air_grid_walk *walk, const air_grid *grid, air_vec3 origin, air_vec3 dir,
                         float t0, float t1);
/* The next piece [*out_t0, *out_t1], not empty, with an upper bound of all trilinear values (and
 * channels) of its cell; pieces adjoin and cover (t0, t1) wholly. Empty cells are joined into one
 * piece with majorant 0, as is what lies outside the grid. False at the end. */
bool air_grid_walk_next(air_grid_walk *walk, float *out_t0, float *out_t1, float *out_majorant);

/* ---- files; each gives a grid with the map its file states; message names file and byte ---- */

/* A grid of a NanoVDB file: the one named, or with name NULL the one called "density", else the
 * first with values that can be read (float, double, Fp4, Fp8, Fp16, FpN: one channel; Vec3f:
 * three). Codecs none, zip and blosc; file format 32. The grid is 0 outside the nodes of the tree.
 */
air_status air_grid_load_nvdb(air_context *context, const char *path, const char *name,
                              air_grid **out_grid);
/* Mitsuba .vol, version 3, float32/float16/uint8, 1 or 3 channels. Voxels fill its bounding box
 * (samples at voxel centres). */
air_status air_grid_load_vol(air_context *context, const char *path, air_grid **out_grid);
/* Raw little-endian float32, x fastest, of the stated size and channels, filling [0,1]^3. */
air_status air_grid_load_raw(air_context *context, const char *path, const size_t size[3],
                             size_t channels, air_grid **out_grid);

#endif

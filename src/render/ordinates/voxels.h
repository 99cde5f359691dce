/* voxels.h: a region of one medium as voxels of the medium's own detail, with the light of the
 * cells: what rays march through side by side. */
#ifndef AIR_RENDER_ORDINATES_VOXELS_H
#define AIR_RENDER_ORDINATES_VOXELS_H

#include "airlight/ordinates_view.h"
#include "render/ordinates/domain.h"

struct air_with_ordinates;

/* What is marched for: the solver's light, with its extinction, and with the true one that of first
 * events alone, and that of grids. */
typedef enum ord_marched { ORD_SOLVED = 0, ORD_FIRST = 1, ORD_CARRIED = 2 } ord_marched;
enum { ORD_MARCHES = 3 };

/* Voxels about centres of the medium's grid where that lies along the world's axes, else as fine
 * as the grid. */
typedef struct ord_voxels {
    air_volume volume[ORD_MARCHES]; /* size and voxel_m of all; voxels NULL: not wanted, owned */
    uint8_t *empty;                 /* of all */
    float low[3], high[3];          /* the box, world */
    float step_m;                   /* least edge of a voxel */
    float power[3]; /* transmittance by the true extinction is that by the solver's to this, where
                       the albedo is the same everywhere */
} ord_voxels;

/* Lays the voxels of the scene's regions out, in with->voxels, by region; size 0 where a region has
 * more than are worth their while for a picture of so many pixels. The domain is placed. */
air_status ord_voxels_lay_out(struct air_with_ordinates *with, size_t pixels);

/* Bytes that they will take. */
double ord_voxels_bytes(const struct air_with_ordinates *with);

/* Gives them the media's detail and the light of the cells, which are solved. */
air_status ord_voxels_fill(struct air_with_ordinates *with);
void ord_voxels_finish(struct air_with_ordinates *with);

#endif

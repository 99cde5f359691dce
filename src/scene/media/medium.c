#include "airlight/medium.h"

#include <math.h>
#include <string.h>

void air_medium_desc_default(air_medium_desc *desc)
{
    memset(desc, 0, sizeof *desc);
    desc->phase.kind = AIR_PHASE_ISOTROPIC;
    desc->density.kind = AIR_DENSITY_CONSTANT;
    desc->density.up[1] = 1.0f;
    desc->density.layer_top = INFINITY;
    desc->density.scale_height = 1.0f;
    desc->boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    desc->density.detail.scale = 1.0f;
    desc->density.detail.octaves = 4;
    for (int i = 0; i < 12; i += 5) {
        desc->density.detail.to_world[i] = 1.0f;
        desc->density.grid_to_world[i] = 1.0f;
        desc->boundary.box_to_world[i] = 1.0f;
    }
}

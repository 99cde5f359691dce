/* lobe_table.h: the fitted lobes that the library carries. */
#ifndef AIR_AREALIGHT_LOBE_TABLE_H
#define AIR_AREALIGHT_LOBE_TABLE_H

#include "airlight/area_table.h"

extern const double air_ltsd_table[AIR_AREA_KNOTS][4], air_mix_table[AIR_AREA_KNOTS][4];

#endif

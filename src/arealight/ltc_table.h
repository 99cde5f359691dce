/* ltc_table.h: the fitted matrices that the library carries. */
#ifndef AIR_AREALIGHT_LTC_TABLE_H
#define AIR_AREALIGHT_LTC_TABLE_H

#include "airlight/area_ltc.h"

extern const air_area_ltc_table air_ltc_table;

#endif

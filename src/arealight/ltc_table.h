/* ltc_table.h: fitted matrices that the library carries. */
#ifndef AIR_AREALIGHT_LTC_TABLE_H
#define AIR_AREALIGHT_LTC_TABLE_H

enum { AIR_LTC_SIDE = 24 };

/* [alpha][cos_o]: sqrt(alpha) even from sqrt(0.001) to 1, sqrt(1 - cos_o) from 0 to 1; xx, xz, zx,
 * zz, albedo. */
extern const float air_ltc_table[AIR_LTC_SIDE][AIR_LTC_SIDE][5];

#endif

#include <math.h>

#include "core/vec.h"
#include "scene/import/sun_sky.h"

/* Days, with their fraction, since noon of 1 January 2000, universal time. Integer divisions, as
 * the calendar's rule has them, are towards zero. */
static double days_since_2000(int year, int month, int day, double hours)
{
    const int before_march = (month - 14) / 12;
    const int julian = 1461 * (year + 4800 + before_march) / 4 +
                       367 * (month - 2 - 12 * before_march) / 12 -
                       3 * ((year + 4900 + before_march) / 100) / 4 + day - 32075;
    return julian - 2451545.5 + hours / 24.0;
}

void air_sun_direction(int year, int month, int day, double hour, double minute, double second,
                       double latitude, double longitude, double timezone, float out_dir[3])
{
    const double radians = AIR_PI / 180.0;
    const double hours = hour - timezone + minute / 60.0 + second / 3600.0;
    const double n = days_since_2000(year, month, day, hours);

    /* [Blanco2001, table 1]: where the sun is on the ecliptic */
    const double omega = 2.1429 - 0.0010394594 * n;
    const double mean_longitude = 4.8950630 + 0.017202791698 * n;
    const double anomaly = 6.2400600 + 0.0172019699 * n;
    const double ecliptic = mean_longitude + 0.03341607 * sin(anomaly) +
                            0.00034894 * sin(2.0 * anomaly) - 0.0001134 - 0.0000203 * sin(omega);
    const double obliquity = 0.4090928 - 6.2140e-9 * n + 0.0000396 * cos(omega);
    const double ascension = atan2(cos(obliquity) * sin(ecliptic), cos(ecliptic));
    const double declination = asin(sin(obliquity) * sin(ecliptic));

    /* and how far the earth has turned */
    const double greenwich = 6.6974243242 + 0.0657098283 * n + hours;
    const double turn = (15.0 * greenwich + longitude) * radians - ascension;
    const double phi = latitude * radians;
    const double north = sin(declination) * cos(phi) - cos(declination) * sin(phi) * cos(turn);
    out_dir[0] = (float)(-cos(declination) * sin(turn));
    out_dir[1] = (float)(sin(declination) * sin(phi) + cos(declination) * cos(phi) * cos(turn));
    out_dir[2] = (float)-north;
}

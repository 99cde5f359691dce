/* sun_sky.h: clear skies by day, with their sun [Preetham1999].
 *
 * Radiance and irradiance are linear RGB of what Mitsuba's are: W/(m^2 sr nm) and W/(m^2 nm),
 * averaged by the observer as in air_spectrum_emission_rgb; times 72,983 they are cd/m^2 and lux.
 */
#ifndef AIR_SCENE_IMPORT_SUN_SKY_H
#define AIR_SCENE_IMPORT_SUN_SKY_H

#include "core/host.h"

typedef struct air_sun_sky {
    float sun_dir[3];           /* to the sun, in the world; of any length, not below the horizon */
    float turbidity;            /* 1 to 10; 2 very clear, 3 clear, 6 warm and moist, 10 hazy */
    float albedo[3];            /* of the ground, [0,1] */
    float sky_scale, sun_scale; /* factors, >= 0 */
    float sun_radius_scale;     /* for those who make a disk of the sun; its light is the same */
    float to_world[9];          /* rotation of the sky, whose up is +Y and whose north is -Z */
    size_t width;               /* of the image, >= 2 and even; its height is the half */
} air_sun_sky;

/* The sky before to_world as an image of radiance in the orientation of environment lights: 3
 * floats per texel, width * width / 2 of them, 0 below the horizon; and the irradiance of the sun
 * on a plane across its light. AIR_ERROR_ARGUMENT: a value out of its range. */
air_status air_sun_sky_image(air_context *context, const air_sun_sky *sky, float *out_rgb,
                             float out_sun_irradiance[3]);

/* Where the sun is, as a unit vector: X east, Y up, Z south. Latitude and longitude in degrees,
 * north and east positive; the time is that of a clock `timezone` hours before UTC. Good to 0.02
 * degrees from 1950 to 2050, refraction left out [Blanco2001]. */
void air_sun_direction(int year, int month, int day, double hour, double minute, double second,
                       double latitude, double longitude, double timezone, float out_dir[3]);

#endif

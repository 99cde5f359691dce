/* environment.h: a lat-long image as a light at infinity.
 *
 * Directions in image space (what to_world rotates into the world): +Y is up, the image's centre
 * looks along -Z, and u grows to the right as seen from inside, so that +X is at u = 3/4. Texel (i,
 * j) is centred at u = (i + 1/2) / width, v = (j + 1/2) / height; between centres radiance is
 * bilinear, around the horizon it wraps, beyond the first and last row it holds. */
#ifndef AIR_SCENE_LIGHTS_ENVIRONMENT_H
#define AIR_SCENE_LIGHTS_ENVIRONMENT_H

#include "scene/lights/light_table.h"

/* Sampled in proportion to the bilinear interpolation of (mean of R, G, B) x (cosine of the texel's
 * latitude): the cells between texel centres by cumulative sums, a bilinear function within. Hence
 * no radiance has density 0. */
typedef struct air_environment {
    size_t width, height;
    const float *pixels; /* borrowed from the texture, or owned_pixels */
    size_t stride;       /* floats from pixel to pixel, >= 3 */
    float *owned_pixels;
    float *row_latitude; /* cosine of the latitude of each row of texels */
    float *row_cdf;  /* height + 1 rows of cells: the first and last lie half beyond the image */
    float *cell_cdf; /* width cells in each of them, from the last texel's centre on */
    float density; /* weight to density per solid angle, times the cosine of the latitude; 0: black
                      image */
    double integral; /* of mean radiance over the sphere */
    float to_world[9];
} air_environment;

/* Pixels that are negative, above 1e30 or not numbers: AIR_ERROR_ARGUMENT naming light and pixel.
 * The texture's floats are borrowed where they can be. */
air_status air_environment_create(air_context *context, const char *light_name,
                                  const struct air_texture *image, const float to_world[9],
                                  air_environment **out_environment);
void air_environment_destroy(air_context *context,
                             air_environment *environment); /* NULL is legal */

/* A direction in proportion to the radiance, or over the sphere for a constant environment. */
void air_environment_sample(const air_light *light, float u1, float u2, air_light_point *out);

#endif

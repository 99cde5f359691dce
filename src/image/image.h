/* image.h: what an air_image is made of, for the files of this room. */
#ifndef AIR_IMAGE_IMAGE_H
#define AIR_IMAGE_IMAGE_H

#include "airlight/image.h"
#include "core/host.h"

enum { AIR_IMAGE_MAX_SIDE = 65535, AIR_IMAGE_MAX_CHANNELS = 1023 };

typedef struct air_attribute {
    char *name;
    char *value;
} air_attribute;

struct air_image {
    air_context *context;
    size_t width, height, channel_count;
    char **names;
    float *pixels; /* channel after channel */
    air_attribute *attributes;
    size_t attribute_count;
};

/* The channels of a colour image: R,G,B, or Y three times. False if it has neither. */
bool air_image_colour(const air_image *image, const float *out_planes[3]);

/* Is the value neither NaN nor infinite in all three planes? The index of the first pixel where it
 * is not goes to *out_first, their number is returned. */
size_t air_image_count_not_finite(const float *const planes[3], size_t pixel_count,
                                  size_t *out_first);

#endif

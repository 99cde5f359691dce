/* srgb.h: the sRGB transfer function [IEC61966-2-1] between display-linear and encoded values in
 * [0,1]. */
#ifndef AIR_IMAGE_SRGB_H
#define AIR_IMAGE_SRGB_H

#include <math.h>

static inline float srgb_decode(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f : powf((encoded + 0.055f) / 1.055f, 2.4f);
}

static inline float srgb_encode(float linear)
{
    return linear <= 0.0031308f ? linear * 12.92f : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

#endif

/* false_colour.c: magnitudes as colours. */
#include <math.h>

#include "core/vec.h"
#include "image/image.h"

/* Oklab to linear Rec. 709 [Ottosson2020]. */
static air_vec3 rgb_from_oklab(float lightness, float a, float b)
{
    const float l = lightness + 0.3963377774f * a + 0.2158037573f * b;
    const float m = lightness - 0.1055613458f * a - 0.0638541728f * b;
    const float s = lightness - 0.0894841775f * a - 1.2914855480f * b;
    const float l3 = l * l * l;
    const float m3 = m * m * m;
    const float s3 = s * s * s;
    return vec3(4.0767416621f * l3 - 3.3077115913f * m3 + 0.2309699292f * s3,
                -1.2684380046f * l3 + 2.6097574011f * m3 - 0.3413193965f * s3,
                -0.0041960863f * l3 - 0.7034186147f * m3 + 1.7076147010f * s3);
}

/* The map: in Oklab, in which equal steps look equal, lightness rises linearly while the hue turns
 * from violet over red and orange to yellow; the chroma is an arc that keeps the whole curve within
 * the sRGB gamut. t in [0,1]. */
static air_vec3 colour_map(float t)
{
    const float lightness = 0.16f + 0.80f * t;
    const float hue_rad = (300.0f + 168.0f * t) * (AIR_PI_F / 180.0f);
    const float chroma = 0.60f * t * (1.0f - t) + 0.03f;
    return rgb_from_oklab(lightness, chroma * cosf(hue_rad), chroma * sinf(hue_rad));
}

/* The planes whose magnitudes count: R,G,B, Y, or the only channel. */
static size_t find_planes(const air_image *image, const float *out_planes[3])
{
    if (air_image_colour(image, out_planes)) {
        return 3;
    }
    out_planes[0] = air_image_plane_const(image, 0);
    return image->channel_count == 1 ? 1 : 0;
}

air_status air_image_false_colour(air_context *context, const air_image *image, float scale_max,
                                  air_image **out_image)
{
    static const char *const names[3] = {"R", "G", "B"};
    *out_image = NULL;
    if (!(scale_max > 0.0f) || !isfinite(scale_max)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "false colour: the scale is %g, must be positive and finite",
                        (double)scale_max);
    }
    const float *planes[3];
    const size_t plane_count = find_planes(image, planes);
    if (plane_count == 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "false colour: expected the channels R,G,B or Y, or one channel only");
    }
    air_image *out = NULL;
    const air_status status =
        air_image_create(context, image->width, image->height, 3, names, &out);
    if (status != AIR_OK) {
        return status;
    }
    for (size_t i = 0; i < image->width * image->height; i++) {
        float sum = 0.0f;
        for (size_t k = 0; k < plane_count; k++) {
            sum += fabsf(planes[k][i]);
        }
        const float value = sum / (float)plane_count / scale_max;
        air_vec3 colour = vec3(0.0f, 1.0f, 1.0f);
        if (isfinite(value)) {
            colour = colour_map(fminf(value, 1.0f));
        }
        air_image_plane(out, 0)[i] = fminf(fmaxf(colour.x, 0.0f), 1.0f);
        air_image_plane(out, 1)[i] = fminf(fmaxf(colour.y, 0.0f), 1.0f);
        air_image_plane(out, 2)[i] = fminf(fmaxf(colour.z, 0.0f), 1.0f);
    }
    *out_image = out;
    return AIR_OK;
}

/* hdr.c: Radiance HDR into an image. */
#include "image/stb_image.h"

air_status air_hdr_read(air_context *context, const air_source *source, air_image **out_image)
{
    static const char *const names[3] = {"R", "G", "B"};
    air_stb_picture picture;
    air_status status = air_stb_decode(context, source, AIR_STB_FLOATS, &picture);
    if (status != AIR_OK) {
        return status;
    }
    air_image *image = NULL;
    status = air_image_create(context, picture.width, picture.height, 3, names, &image);
    if (status == AIR_OK) {
        const size_t count = picture.width * picture.height;
        for (size_t c = 0; c < 3; c++) {
            float *const plane = air_image_plane(image, c);
            for (size_t i = 0; i < count; i++) {
                plane[i] = picture.floats[3 * i + c];
            }
        }
        *out_image = image;
    }
    air_stb_free(&picture);
    return status;
}

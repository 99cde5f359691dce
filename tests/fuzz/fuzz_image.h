/* fuzz_image.h: what the harnesses of the image loaders share. */
#ifndef AIR_TESTS_FUZZ_IMAGE_H
#define AIR_TESTS_FUZZ_IMAGE_H

#include "airlight/image.h"
#include "fuzz_host.h"

/* Loads a file, whose extension names the format, and reads every pixel. */
static inline void fuzz_load_image(air_context *context, const char *path)
{
    air_image *image = NULL;
    const air_status status = air_image_load(context, path, &image);
    fuzz_check_outcome(context, status, image);
    if (image != NULL)
        (void)air_image_auto_exposure(image);
    air_image_destroy(image);
}

#endif

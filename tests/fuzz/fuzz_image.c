/* fuzz_image.c: any bytes as an EXR, PNG or JPEG, PFM and KTX 2: no crash, no leak, an image or an
 * error. */
#include "fuzz_image.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    if (context != NULL) {
        fuzz_load_image(context, "input.exr");
        fuzz_load_image(context, "input.png");
        fuzz_load_image(context, "input.pfm");
        fuzz_load_image(context, "input.ktx2");
    }
    air_context_destroy(context);
    return 0;
}

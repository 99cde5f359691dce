/* fuzz_image.c: any bytes as an EXR, HDR, PNG or JPEG, and PFM: no crash, no leak, an image or an
 * error. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/image.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* One allocation may have this much: enough for the files of a corpus, and no reason to run out of
 * memory. */
enum { MAX_ALLOCATION = 1 << 28 };

typedef struct input {
    const uint8_t *data;
    size_t size;
} input;

static void *reallocate(void *user, void *pointer, size_t size)
{
    (void)user;
    if (size == 0) {
        free(pointer);
        return NULL;
    }
    return size <= MAX_ALLOCATION ? realloc(pointer, size) : NULL;
}

/* Gives the input for every path. */
static air_status read_input(void *user, air_context *context, const char *path, void **out_data,
                             size_t *out_size)
{
    const input *const self = user;
    (void)context;
    (void)path;
    char *const copy = malloc(self->size + 1);
    if (copy == NULL) {
        return AIR_ERROR_MEMORY;
    }
    if (self->size > 0) {
        memcpy(copy, self->data, self->size);
    }
    copy[self->size] = '\0';
    *out_data = copy;
    *out_size = self->size;
    return AIR_OK;
}

static void load(air_context *context, const char *path)
{
    air_image *image = NULL;
    const air_status status = air_image_load(context, path, &image);
    if ((status == AIR_OK) != (image != NULL)) {
        abort();
    }
    if (image != NULL) {
        (void)air_image_auto_exposure(image); /* reads every pixel */
    }
    air_image_destroy(image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input self = {data, size};
    air_context_params params;
    air_context_params_default(&params);
    params.thread_count = 1;
    params.reallocate = reallocate;
    params.read_file = read_input;
    params.read_user = &self;
    air_context *context = NULL;
    if (air_context_create(&params, &context) == AIR_OK) {
        load(context, "input.exr");
        load(context, "input.hdr");
        load(context, "input.png");
        load(context, "input.pfm");
    }
    air_context_destroy(context);
    return 0;
}

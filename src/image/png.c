/* png.c: PNG and JPEG into images, images into PNG, and 8-bit decoding for textures. */
#include <math.h>
#include <string.h>

#include "image/decode.h"
#include "image/srgb.h"
#include "image/stb_image.h"

air_status air_decode_bytes(air_context *context, const void *data, size_t size, const char *what,
                            size_t *out_width, size_t *out_height, size_t *out_channels,
                            uint8_t **out_bytes)
{
    const air_source source = {.path = what, .data = data, .size = size};
    air_stb_picture picture;
    air_status status = air_stb_decode(context, &source, AIR_STB_BYTES, &picture);
    if (status != AIR_OK) {
        return status;
    }
    const size_t count = picture.width * picture.height * picture.channels;
    uint8_t *bytes = air_allocate(context, count, 1);
    if (bytes != NULL) {
        memcpy(bytes, picture.bytes, count);
        *out_width = picture.width;
        *out_height = picture.height;
        *out_channels = picture.channels;
        *out_bytes = bytes;
    } else {
        status = air_fail_memory(context, what);
    }
    air_stb_free(&picture);
    return status;
}

/* A value of the picture as a fraction of its maximum. */
static float fraction(const air_stb_picture *picture, size_t index)
{
    return picture->words != NULL ? (float)picture->words[index] / 65535.0f
                                  : (float)picture->bytes[index] / 255.0f;
}

air_status air_png_read(air_context *context, const air_source *source, air_image **out_image)
{
    static const char *const names[4] = {"R", "G", "B", "A"};
    air_stb_picture picture;
    air_status status = air_stb_decode(context, source, AIR_STB_BYTES_OR_WORDS, &picture);
    if (status != AIR_OK) {
        return status;
    }
    const size_t channels = picture.channels;
    const bool grey = channels < 3;
    const bool alpha = channels == 2 || channels == 4;
    const size_t out_channels = alpha ? 4 : 3;
    air_image *image = NULL;
    status = air_format_check_size(context, source->path, picture.width, picture.height,
                                   out_channels * sizeof(float));
    if (status == AIR_OK) {
        status =
            air_image_create(context, picture.width, picture.height, out_channels, names, &image);
    }
    if (status == AIR_OK) {
        const size_t count = picture.width * picture.height;
        float *const a = alpha ? air_image_plane(image, 3) : NULL;
        for (size_t i = 0; alpha && i < count; i++) {
            a[i] = fraction(&picture, channels * i + channels - 1);
        }
        for (size_t c = 0; c < 3; c++) {
            float *const plane = air_image_plane(image, c);
            for (size_t i = 0; i < count; i++) {
                const float linear = srgb_decode(fraction(&picture, channels * i + (grey ? 0 : c)));
                plane[i] = alpha ? linear * a[i] : linear;
            }
        }
        *out_image = image;
    }
    air_stb_free(&picture);
    return status;
}

typedef struct png_job {
    const float *colour[3];
    const float *alpha; /* NULL: none */
    size_t width, channels;
    float exposure_ev;
    air_view view;
    uint8_t *bytes;
} png_job;

static uint8_t quantise(float value) { return (uint8_t)(value * 255.0f + 0.5f); }

static void encode_row(void *user, size_t row, size_t worker)
{
    const png_job *const job = user;
    (void)worker;
    for (size_t i = row * job->width; i < (row + 1) * job->width; i++) {
        float rgb[3] = {job->colour[0][i], job->colour[1][i], job->colour[2][i]};
        uint8_t *const out = job->bytes + i * job->channels;
        if (job->alpha != NULL) {
            const float a = job->alpha[i] > 0.0f ? fminf(job->alpha[i], 1.0f) : 0.0f;
            for (size_t c = 0; c < 3 && a > 0.0f; c++) {
                rgb[c] /= a;
            }
            out[3] = quantise(a);
        }
        air_view_apply(job->view, job->exposure_ev, rgb, rgb);
        for (size_t c = 0; c < 3; c++) {
            out[c] = quantise(job->view == AIR_VIEW_RAW ? rgb[c] : srgb_encode(rgb[c]));
        }
    }
}

air_status air_png_write(air_context *context, const air_image *image, const char *path,
                         const air_image_save_params *params, air_sink *sink)
{
    png_job job = {.width = image->width, .view = params->view};
    if (!air_image_colour(image, job.colour)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: a PNG needs the channels R,G,B or Y, the image has neither", path);
    }
    const ptrdiff_t alpha = params->alpha ? air_image_find_channel(image, "A") : -1;
    job.alpha = alpha >= 0 ? air_image_plane_const(image, (size_t)alpha) : NULL;
    job.channels = job.alpha != NULL ? 4 : 3;
    job.exposure_ev = params->auto_exposure ? air_image_auto_exposure(image) : params->exposure_ev;
    if (!isfinite(job.exposure_ev)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: the exposure is not finite", path);
    }
    /* stb_image_write counts in int, one filter byte per row included. */
    if ((uint64_t)image->height * (image->width * job.channels + 1) >= (uint64_t)1 << 30) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: %zu x %zu pixels are too many for a PNG, write an EXR", path,
                        image->width, image->height);
    }
    job.bytes = air_allocate(context, image->width * image->height, job.channels);
    if (job.bytes == NULL) {
        return air_fail_memory(context, path);
    }
    air_parallel_for(context, image->height, encode_row, &job);
    air_status status = AIR_OK;
    if (!air_stb_encode_png(sink, image->width, image->height, job.channels, job.bytes)) {
        status = air_fail_memory(context, path);
    }
    air_free(context, job.bytes);
    return status;
}

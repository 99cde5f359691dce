/* exr_write.c: images into OpenEXR: one part of scanlines, ZIP, through OpenEXRCore. */
#include <math.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "image/format.h"

enum { HALF_LARGEST = 65504 };

static int64_t write_bytes(exr_const_context_t file, void *user, const void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)file;
    (void)fail;
    return air_sink_write(user, offset, buffer, size) ? (int64_t)size : -1;
}

static void drop_message(exr_const_context_t file, exr_result_t code, const char *message)
{
    (void)file;
    (void)code;
    (void)message;
}

static air_status fail_exr(const air_sink *sink, const char *path, const char *what,
                           exr_result_t code)
{
    if (sink->failed || code == EXR_ERR_OUT_OF_MEMORY) {
        return air_fail_memory(sink->context, path);
    }
    const bool callers = code == EXR_ERR_INVALID_ARGUMENT || code == EXR_ERR_ATTR_TYPE_MISMATCH;
    return air_fail(sink->context, callers ? AIR_ERROR_ARGUMENT : AIR_ERROR_INTERNAL,
                    "%s: cannot write %s: %s", path, what, exr_get_default_error_message(code));
}

/* A channel and its name, to be sorted as the format demands. */
typedef struct named_plane {
    const char *name;
    const float *pixels;
} named_plane;

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const named_plane *)a)->name, ((const named_plane *)b)->name);
}

static air_status write_header(const air_sink *sink, const air_image *image, const char *path,
                               const named_plane *planes, bool half, exr_context_t file)
{
    int part = 0;
    exr_result_t result = exr_set_longname_support(file, 1);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_add_part(file, "airlight", EXR_STORAGE_SCANLINE, &part);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = exr_initialize_required_attr_simple(file, 0, (int32_t)image->width,
                                                     (int32_t)image->height, EXR_COMPRESSION_ZIP);
    }
    if (result != EXR_ERR_SUCCESS) {
        return fail_exr(sink, path, "the header", result);
    }
    for (size_t i = 0; i < image->channel_count; i++) {
        result = exr_add_channel(file, 0, planes[i].name, half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
        if (result != EXR_ERR_SUCCESS) {
            return fail_exr(sink, path, planes[i].name, result);
        }
    }
    for (size_t i = 0; i < image->attribute_count; i++) {
        result =
            exr_attr_set_string(file, 0, image->attributes[i].name, image->attributes[i].value);
        if (result != EXR_ERR_SUCCESS) {
            return fail_exr(sink, path, image->attributes[i].name, result);
        }
    }
    result = exr_write_header(file);
    return result == EXR_ERR_SUCCESS ? AIR_OK : fail_exr(sink, path, "the header", result);
}

/* Blocks of rows are compressed side by side, a batch at a time, and written in order. */
typedef struct exr_encode_job {
    air_context *context;
    exr_context_t file;
    const named_plane *planes;
    size_t width, height, channel_count;
    bool half;
    size_t block_height;
    size_t first_block;
    exr_encode_pipeline_t *pipelines; /* per block of the batch */
    exr_result_t *results;
    size_t *clamped; /* per block of the batch: values beyond half's range */
} exr_encode_job;

/* A copy of the rows with finite values clamped to the range of half; *out_clamped counts them. */
static float *clamp_rows(const exr_encode_job *job, size_t first, size_t rows, size_t *out_clamped)
{
    const size_t count = job->width * rows;
    float *copy = air_allocate(job->context, count * job->channel_count, sizeof(*copy));
    *out_clamped = 0;
    for (size_t c = 0; copy != NULL && c < job->channel_count; c++) {
        const float *const in = job->planes[c].pixels + first * job->width;
        float *const out = copy + c * count;
        for (size_t i = 0; i < count; i++) {
            out[i] = in[i];
            if (isfinite(in[i]) && fabsf(in[i]) > (float)HALF_LARGEST) {
                out[i] = copysignf((float)HALF_LARGEST, in[i]);
                *out_clamped += 1;
            }
        }
    }
    return copy;
}

static exr_result_t encode_rows(const exr_encode_job *job, size_t first, const float *clamped,
                                exr_encode_pipeline_t *encode)
{
    exr_chunk_info_t chunk;
    exr_result_t result = exr_write_scanline_chunk_info(job->file, 0, (int)first, &chunk);
    if (result != EXR_ERR_SUCCESS) {
        return result;
    }
    result = exr_encoding_initialize(job->file, 0, &chunk, encode);
    if (result != EXR_ERR_SUCCESS) {
        return result;
    }
    const size_t count = job->width * (size_t)chunk.height;
    for (size_t c = 0; c < job->channel_count; c++) {
        exr_coding_channel_info_t *const channel = &encode->channels[c];
        const float *const rows =
            clamped != NULL ? clamped + c * count : job->planes[c].pixels + first * job->width;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)(job->width * sizeof(float));
        channel->encode_from_ptr = (const uint8_t *)rows;
    }
    result = exr_encoding_choose_default_routines(job->file, 0, encode);
    if (result == EXR_ERR_SUCCESS) {
        encode->yield_until_ready_fn = NULL;
        encode->write_fn = NULL;
        result = exr_encoding_run(job->file, 0, encode);
    }
    if (result == EXR_ERR_SUCCESS && encode->compressed_bytes == encode->packed_bytes) {
        /* Readers take a block of this size for one that is not compressed. OpenEXRCore 3.1 leaves
         * the compressed bytes there if they are exactly as many. */
        memcpy(encode->compressed_buffer, encode->packed_buffer, encode->packed_bytes);
    }
    return result;
}

static void encode_block(void *user, size_t index, size_t worker)
{
    const exr_encode_job *const job = user;
    const size_t first = (job->first_block + index) * job->block_height;
    const size_t left = job->height - first;
    const size_t rows = left < job->block_height ? left : job->block_height;
    float *clamped = NULL;
    (void)worker;
    if (job->half) {
        clamped = clamp_rows(job, first, rows, &job->clamped[index]);
        if (clamped == NULL) {
            job->results[index] = EXR_ERR_OUT_OF_MEMORY;
            return;
        }
    }
    job->results[index] = encode_rows(job, first, clamped, &job->pipelines[index]);
    air_free(job->context, clamped);
}

/* Writes one encoded block and lets go of its buffers. */
static exr_result_t flush_block(const exr_encode_job *job, size_t index)
{
    exr_encode_pipeline_t *const encode = &job->pipelines[index];
    exr_result_t result = job->results[index];
    if (result == EXR_ERR_SUCCESS) {
        /* The buffer to be written, also when compression did not pay. */
        result = exr_write_scanline_chunk(job->file, 0,
                                          (int)((job->first_block + index) * job->block_height),
                                          encode->compressed_buffer, encode->compressed_bytes);
    }
    (void)exr_encoding_destroy(job->file, encode);
    *encode = (exr_encode_pipeline_t)EXR_ENCODE_PIPELINE_INITIALIZER;
    return result;
}

static air_status write_pixels(const air_sink *sink, const char *path, exr_encode_job *job)
{
    air_context *const context = sink->context;
    int32_t block_height = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(job->file, 0, &block_height);
    if (result != EXR_ERR_SUCCESS || block_height < 1) {
        return fail_exr(sink, path, "pixels", result);
    }
    job->block_height = (size_t)block_height;
    const size_t block_count = (job->height + job->block_height - 1) / job->block_height;
    const size_t batch = 4 * air_context_thread_count(context);
    job->pipelines = air_allocate(context, batch, sizeof(*job->pipelines));
    job->results = air_allocate(context, batch, sizeof(*job->results));
    job->clamped = air_allocate(context, batch, sizeof(*job->clamped));
    size_t clamped = 0;
    if (job->pipelines == NULL || job->results == NULL || job->clamped == NULL) {
        result = EXR_ERR_OUT_OF_MEMORY;
    }
    for (size_t first = 0; first < block_count && result == EXR_ERR_SUCCESS; first += batch) {
        const size_t count = block_count - first < batch ? block_count - first : batch;
        job->first_block = first;
        air_parallel_for(context, count, encode_block, job);
        for (size_t i = 0; i < count; i++) {
            const exr_result_t block_result = flush_block(job, i);
            result = result != EXR_ERR_SUCCESS ? result : block_result;
            clamped += job->clamped[i];
        }
    }
    air_free(context, job->clamped);
    air_free(context, job->results);
    air_free(context, job->pipelines);
    if (result != EXR_ERR_SUCCESS) {
        return fail_exr(sink, path, "pixels", result);
    }
    if (clamped > 0) {
        air_warn(context, "%s: %zu values beyond the range of half were clamped to +-%d", path,
                 clamped, HALF_LARGEST);
    }
    return AIR_OK;
}

air_status air_exr_write(air_context *context, const air_image *image, const char *path,
                         const air_image_save_params *params, air_sink *sink)
{
    named_plane *planes = air_allocate(context, image->channel_count, sizeof(*planes));
    if (planes == NULL) {
        return air_fail_memory(context, path);
    }
    for (size_t i = 0; i < image->channel_count; i++) {
        planes[i] = (named_plane){image->names[i], air_image_plane_const(image, i)};
    }
    qsort(planes, image->channel_count, sizeof(*planes), compare_names);

    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = drop_message;
    initializer.user_data = sink;
    initializer.write_fn = write_bytes;
    exr_context_t file = NULL;
    exr_result_t result = exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, &initializer);
    air_status status = AIR_OK;
    if (result == EXR_ERR_SUCCESS) {
        exr_encode_job job = {.context = context,
                              .file = file,
                              .planes = planes,
                              .width = image->width,
                              .height = image->height,
                              .channel_count = image->channel_count,
                              .half = params->half};
        status = write_header(sink, image, path, planes, params->half, file);
        if (status == AIR_OK) {
            status = write_pixels(sink, path, &job);
        }
        result = exr_finish(&file); /* writes the offset table */
    }
    if (status == AIR_OK && result != EXR_ERR_SUCCESS) {
        status = fail_exr(sink, path, "the file", result);
    }
    air_free(context, planes);
    return status;
}

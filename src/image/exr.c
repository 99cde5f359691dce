/* exr.c: OpenEXR into images: the first part, scanlines or tiles, through OpenEXRCore. */
#include <openexr.h>
#include <string.h>

#include "image/format.h"

/* What OpenEXRCore's callbacks see. Its sentences are kept while the header is parsed, which one
 * thread does. */
typedef struct exr_input {
    const air_source *source;
    bool keep_message;
    char message[256];
} exr_input;

static int64_t read_bytes(exr_const_context_t file, void *user, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    const exr_input *const input = user;
    (void)file;
    (void)fail;
    if (offset >= input->source->size) {
        return 0;
    }
    const uint64_t left = input->source->size - offset;
    const uint64_t count = size < left ? size : left;
    memcpy(buffer, input->source->data + offset, count);
    return (int64_t)count;
}

static int64_t query_size(exr_const_context_t file, void *user)
{
    const exr_input *const input = user;
    (void)file;
    return (int64_t)input->source->size;
}

static void keep_message(exr_const_context_t file, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    if (file == NULL || exr_get_user_data(file, &user) != EXR_ERR_SUCCESS || user == NULL) {
        return;
    }
    exr_input *const input = user;
    if (input->keep_message && input->message[0] == '\0') {
        strncpy(input->message, message, sizeof(input->message) - 1);
    }
}

static air_status fail_exr(air_context *context, const exr_input *input, exr_result_t code)
{
    return air_fail(context, code == EXR_ERR_OUT_OF_MEMORY ? AIR_ERROR_MEMORY : AIR_ERROR_FORMAT,
                    "%s: not a readable OpenEXR file: %s", input->source->path,
                    input->message[0] != '\0' ? input->message
                                              : exr_get_default_error_message(code));
}

/* How the data window is cut into chunks: columns x rows of them, each width x height pixels at
 * most. */
typedef struct exr_layout {
    int32_t width, height, columns, rows;
} exr_layout;

/* The part as it is read. Windows are inclusive, as in the file. */
typedef struct exr_part {
    exr_context_t file;
    const exr_attr_chlist_t *channels;
    exr_attr_box2i_t data, display;
    bool tiled;
    exr_layout layout;
    exr_chunk_info_t *chunks; /* row after row */
    size_t chunk_count;
} exr_part;

static int64_t span(int32_t low, int32_t high) { return (int64_t)high - low + 1; }

static air_status check_channels(air_context *context, const char *path, const exr_part *part)
{
    const int count = part->channels->num_channels;
    if (count < 1 || count > AIR_IMAGE_MAX_CHANNELS) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s: %d channels, expected 1 to %d", path, count,
                        AIR_IMAGE_MAX_CHANNELS);
    }
    for (int i = 0; i < count; i++) {
        const exr_attr_chlist_entry_t *const entry = &part->channels->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1) {
            return air_fail(context, AIR_ERROR_UNSUPPORTED,
                            "%s: channel %s is subsampled (%d x %d), expected 1 x 1", path,
                            entry->name.str, entry->x_sampling, entry->y_sampling);
        }
        if (entry->name.length < 1 ||
            (i > 0 && strcmp(entry->name.str, part->channels->entries[i - 1].name.str) == 0)) {
            return air_fail(context, AIR_ERROR_FORMAT,
                            "%s: channel %d (\"%s\") is unnamed or there twice", path, i,
                            entry->name.str);
        }
    }
    return AIR_OK;
}

static air_status check_windows(air_context *context, const char *path, const exr_part *part)
{
    const exr_attr_box2i_t data = part->data;
    const exr_attr_box2i_t display = part->display;
    const int64_t width = span(display.min.x, display.max.x);
    const int64_t height = span(display.min.y, display.max.y);
    const int64_t data_width = span(data.min.x, data.max.x);
    const int64_t data_height = span(data.min.y, data.max.y);
    const uint64_t pixel = (uint64_t)part->channels->num_channels * sizeof(float);
    air_status status =
        air_format_check_size(context, path, data_width > 0 ? (uint64_t)data_width : 0,
                              data_height > 0 ? (uint64_t)data_height : 0, pixel);
    if (status == AIR_OK) {
        status = air_format_check_size(context, path, width > 0 ? (uint64_t)width : 0,
                                       height > 0 ? (uint64_t)height : 0, pixel);
    }
    if (status == AIR_OK && (data.max.x < display.min.x || data.min.x > display.max.x ||
                             data.max.y < display.min.y || data.min.y > display.max.y)) {
        status = air_fail(context, AIR_ERROR_FORMAT,
                          "%s: the data window (%d,%d)-(%d,%d) lies outside the display window "
                          "(%d,%d)-(%d,%d)",
                          path, data.min.x, data.min.y, data.max.x, data.max.y, display.min.x,
                          display.min.y, display.max.x, display.max.y);
    }
    return status;
}

static air_status read_header(air_context *context, const exr_input *input, exr_part *part)
{
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    exr_result_t result = exr_get_storage(part->file, 0, &storage);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_get_channels(part->file, 0, &part->channels);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = exr_get_data_window(part->file, 0, &part->data);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = exr_get_display_window(part->file, 0, &part->display);
    }
    if (result != EXR_ERR_SUCCESS) {
        return fail_exr(context, input, result);
    }
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: the first part holds deep data, expected scanlines or tiles",
                        input->source->path);
    }
    part->tiled = storage == EXR_STORAGE_TILED;
    air_status status = check_channels(context, input->source->path, part);
    if (status == AIR_OK) {
        status = check_windows(context, input->source->path, part);
    }
    return status;
}

static exr_result_t get_layout(const exr_part *part, exr_layout *out)
{
    const int64_t width = span(part->data.min.x, part->data.max.x);
    const int64_t height = span(part->data.min.y, part->data.max.y);
    exr_result_t result = EXR_ERR_SUCCESS;
    out->width = (int32_t)width;
    if (part->tiled) {
        result = exr_get_tile_sizes(part->file, 0, 0, 0, &out->width, &out->height);
    } else {
        result = exr_get_scanlines_per_chunk(part->file, 0, &out->height);
    }
    if (result == EXR_ERR_SUCCESS && (out->width < 1 || out->height < 1)) {
        result = EXR_ERR_INVALID_ATTR;
    }
    if (result == EXR_ERR_SUCCESS) {
        out->columns = (int32_t)((width + out->width - 1) / out->width);
        out->rows = (int32_t)((height + out->height - 1) / out->height);
    }
    return result;
}

/* The window coordinates of a chunk's first pixel. */
static void chunk_corner(const exr_part *part, size_t index, int64_t *out_x, int64_t *out_y)
{
    const int64_t columns = part->layout.columns;
    *out_x = part->data.min.x + (int64_t)index % columns * part->layout.width;
    *out_y = part->data.min.y + (int64_t)index / columns * part->layout.height;
}

static air_status fail_chunk(air_context *context, const exr_input *input, const exr_part *part,
                             size_t index, exr_result_t result)
{
    int64_t x;
    int64_t y;
    chunk_corner(part, index, &x, &y);
    return air_fail(context, result == EXR_ERR_OUT_OF_MEMORY ? AIR_ERROR_MEMORY : AIR_ERROR_FORMAT,
                    "%s: truncated or damaged: the block of pixels at (%lld,%lld) cannot be read: "
                    "%s",
                    input->source->path, (long long)x, (long long)y,
                    exr_get_default_error_message(result));
}

/* Looks up every chunk before any memory for pixels is taken, so that a short file that claims to
 * be large is cheap. */
static air_status find_chunks(air_context *context, const exr_input *input, exr_part *part)
{
    const exr_result_t layout_result = get_layout(part, &part->layout);
    if (layout_result != EXR_ERR_SUCCESS) {
        return fail_exr(context, input, layout_result);
    }
    part->chunk_count = (size_t)part->layout.columns * (size_t)part->layout.rows;
    /* Each chunk has an entry of 8 bytes in the file's offset table. */
    if (part->chunk_count > input->source->size / 8) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: truncated: %zu bytes cannot hold %zu blocks of pixels",
                        input->source->path, input->source->size, part->chunk_count);
    }
    part->chunks = air_allocate(context, part->chunk_count, sizeof(*part->chunks));
    if (part->chunks == NULL) {
        return air_fail_memory(context, input->source->path);
    }
    for (size_t i = 0; i < part->chunk_count; i++) {
        exr_chunk_info_t *const chunk = &part->chunks[i];
        int64_t x;
        int64_t y;
        chunk_corner(part, i, &x, &y);
        exr_result_t result;
        if (part->tiled) {
            const size_t columns = (size_t)part->layout.columns;
            result = exr_read_tile_chunk_info(part->file, 0, (int)(i % columns), (int)(i / columns),
                                              0, 0, chunk);
        } else {
            result = exr_read_scanline_chunk_info(part->file, 0, (int)y, chunk);
        }
        if (result == EXR_ERR_SUCCESS &&
            (chunk->width < 1 || chunk->height < 1 || chunk->width > part->layout.width ||
             chunk->height > part->layout.height)) {
            result = EXR_ERR_CORRUPT_CHUNK;
        }
        if (result != EXR_ERR_SUCCESS) {
            return fail_chunk(context, input, part, i, result);
        }
    }
    return AIR_OK;
}

typedef struct exr_decode_job {
    air_context *context;
    const exr_part *part;
    air_image *image;
    exr_result_t *results; /* per chunk */
} exr_decode_job;

/* Copies the part of a decoded chunk that lies in the display window. */
static void copy_chunk(const exr_decode_job *job, size_t index, const float *pixels)
{
    const exr_attr_box2i_t display = job->part->display;
    const int64_t width = job->part->chunks[index].width;
    const int64_t height = job->part->chunks[index].height;
    int64_t x0;
    int64_t y0;
    chunk_corner(job->part, index, &x0, &y0);
    const int64_t left = x0 > display.min.x ? x0 : display.min.x;
    const int64_t right = x0 + width - 1 < display.max.x ? x0 + width - 1 : display.max.x;
    const int64_t top = y0 > display.min.y ? y0 : display.min.y;
    const int64_t bottom = y0 + height - 1 < display.max.y ? y0 + height - 1 : display.max.y;
    if (left > right) {
        return;
    }
    for (size_t c = 0; c < job->image->channel_count; c++) {
        float *const plane = air_image_plane(job->image, c);
        const float *const block = pixels + c * (size_t)(width * height);
        for (int64_t y = top; y <= bottom; y++) {
            memcpy(plane + (size_t)(y - display.min.y) * job->image->width + (left - display.min.x),
                   block + (y - y0) * width + (left - x0),
                   (size_t)(right - left + 1) * sizeof(float));
        }
    }
}

static exr_result_t decode_into(const exr_decode_job *job, const exr_chunk_info_t *chunk,
                                exr_decode_pipeline_t *decode, float *pixels)
{
    const size_t plane = (size_t)chunk->width * (size_t)chunk->height;
    if ((size_t)decode->channel_count != job->image->channel_count) {
        return EXR_ERR_CORRUPT_CHUNK;
    }
    for (int16_t c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *const channel = &decode->channels[c];
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = chunk->width * (int32_t)sizeof(float);
        channel->decode_to_ptr = (uint8_t *)(pixels + (size_t)c * plane);
    }
    exr_result_t result = exr_decoding_choose_default_routines(job->part->file, 0, decode);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_decoding_run(job->part->file, 0, decode);
    }
    return result;
}

static void decode_chunk(void *user, size_t index, size_t worker)
{
    const exr_decode_job *const job = user;
    const exr_chunk_info_t *const chunk = &job->part->chunks[index];
    (void)worker;
    float *pixels = air_allocate(job->context, (size_t)chunk->width * (size_t)chunk->height,
                                 job->image->channel_count * sizeof(float));
    if (pixels == NULL) {
        job->results[index] = EXR_ERR_OUT_OF_MEMORY;
        return;
    }
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t result = exr_decoding_initialize(job->part->file, 0, chunk, &decode);
    if (result == EXR_ERR_SUCCESS) {
        result = decode_into(job, chunk, &decode, pixels);
        (void)exr_decoding_destroy(job->part->file, &decode);
    }
    if (result == EXR_ERR_SUCCESS) {
        copy_chunk(job, index, pixels);
    }
    job->results[index] = result;
    air_free(job->context, pixels);
}

static air_status create_image(air_context *context, const char *path, const exr_part *part,
                               air_image **out_image)
{
    const size_t count = (size_t)part->channels->num_channels;
    const char **names = air_allocate(context, count, sizeof(*names));
    if (names == NULL) {
        return air_fail_memory(context, path);
    }
    for (size_t i = 0; i < count; i++) {
        names[i] = part->channels->entries[i].name.str;
    }
    const air_status status = air_image_create(
        context, (size_t)span(part->display.min.x, part->display.max.x),
        (size_t)span(part->display.min.y, part->display.max.y), count, names, out_image);
    air_free(context, names);
    return status;
}

static air_status read_pixels(air_context *context, const exr_input *input, const exr_part *part,
                              air_image *image)
{
    exr_decode_job job = {.context = context, .part = part, .image = image};
    job.results = air_allocate(context, part->chunk_count, sizeof(*job.results));
    if (job.results == NULL) {
        return air_fail_memory(context, input->source->path);
    }
    air_parallel_for(context, part->chunk_count, decode_chunk, &job);
    air_status status = AIR_OK;
    for (size_t i = 0; i < part->chunk_count && status == AIR_OK; i++) {
        if (job.results[i] != EXR_ERR_SUCCESS) {
            status = fail_chunk(context, input, part, i, job.results[i]);
        }
    }
    air_free(context, job.results);
    return status;
}

/* String attributes; those that the format itself puts into multi-part files ("name", "type") stay
 * out. */
static air_status read_attributes(const exr_part *part, air_image *image)
{
    int32_t count = 0;
    air_status status = AIR_OK;
    if (exr_get_attribute_count(part->file, 0, &count) != EXR_ERR_SUCCESS) {
        return status;
    }
    for (int32_t i = 0; i < count && status == AIR_OK; i++) {
        const exr_attribute_t *attribute = NULL;
        if (exr_get_attribute_by_index(part->file, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) ==
                EXR_ERR_SUCCESS &&
            attribute->type == EXR_ATTR_STRING && attribute->name_length > 0 &&
            attribute->string->str != NULL && strcmp(attribute->name, "name") != 0 &&
            strcmp(attribute->name, "type") != 0) {
            status = air_image_set_attribute(image, attribute->name, attribute->string->str);
        }
    }
    return status;
}

air_status air_exr_read(air_context *context, const air_source *source, air_image **out_image)
{
    exr_input input = {.source = source, .keep_message = true};
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = keep_message;
    initializer.user_data = &input;
    initializer.read_fn = read_bytes;
    initializer.size_fn = query_size;
    initializer.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_part part = {0};
    const exr_result_t result = exr_start_read(&part.file, source->path, &initializer);
    if (result != EXR_ERR_SUCCESS) {
        return fail_exr(context, &input, result);
    }
    input.keep_message = false;
    air_image *image = NULL;
    air_status status = read_header(context, &input, &part);
    if (status == AIR_OK) {
        status = find_chunks(context, &input, &part);
    }
    if (status == AIR_OK) {
        status = create_image(context, source->path, &part, &image);
    }
    if (status == AIR_OK) {
        status = read_pixels(context, &input, &part, image);
    }
    if (status == AIR_OK) {
        status = read_attributes(&part, image);
    }
    if (status == AIR_OK) {
        *out_image = image;
        image = NULL;
    }
    air_image_destroy(image);
    air_free(context, part.chunks);
    (void)exr_finish(&part.file);
    return status;
}

#include "scene/media/grid_bricks.h"

/* A file that was read, as floats; malloc'ed memory is aligned for them. */
static air_status make_grid(air_context *context, const char *path, const float *values,
                            size_t bytes, const size_t size[3], size_t channels,
                            air_grid **out_grid)
{
    static const float box_min[3] = {0.0f, 0.0f, 0.0f}, box_max[3] = {1.0f, 1.0f, 1.0f};
    const size_t expected = size[0] * size[1] * size[2] * channels * sizeof *values;
    if (bytes != expected) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: the file has %zu bytes, expected %zu: %zu x %zu x %zu float32 values "
                        "of %zu channels",
                        path, bytes, expected, size[0], size[1], size[2], channels);
    }
    air_grid_source source = {
        .what = path, .size = {size[0], size[1], size[2]}, .channels = channels};
    air_grid_map_box(size, box_min, box_max, source.index_to_local);
    return air_grid_make_dense(context, &source, values, out_grid);
}

air_status air_grid_load_raw(air_context *context, const char *path, const size_t size[3],
                             size_t channels, air_grid **out_grid)
{
    void *data = NULL;
    size_t bytes = 0;
    air_status status = air_grid_check_size(context, path, size, channels);
    if (status == AIR_OK) {
        status = air_file_read(context, path, &data, &bytes);
    }
    if (status == AIR_OK) {
        status = make_grid(context, path, data, bytes, size, channels, out_grid);
    }
    air_free(context, data);
    return status;
}

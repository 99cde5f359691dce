#include "scene/grid_record.h"

#include <string.h>
#include <strings.h>

static void destroy_grid(air_record *record)
{
    air_grid_record *self = (air_grid_record *)record;
    air_grid_destroy(self->grid);
    air_free(record->context, (void *)self->sequence.path);
    air_free(record->context, (void *)self->sequence.name);
}

/* Takes the grid, also on failure. */
static air_status make_record(air_context *context, const char *name, air_grid *grid,
                              air_grid_record **out_record)
{
    air_grid_record *record = air_record_create(context, sizeof *record, destroy_grid, name);
    if (record == NULL) {
        air_grid_destroy(grid);
        return AIR_ERROR_MEMORY;
    }
    record->grid = grid;
    *out_record = record;
    return AIR_OK;
}

air_status air_grid_record_create(air_context *context, const air_grid_desc *desc,
                                  air_record **out_record)
{
    air_grid *grid = NULL;
    air_grid_record *record = NULL;
    air_status status = air_grid_create(context, desc, &grid);
    if (status == AIR_OK)
        status = make_record(context, desc->name, grid, &record);
    if (status == AIR_OK)
        *out_record = &record->base;
    return status;
}

/* ---- files ---- */

static bool has_ending(const char *path, const char *ending)
{
    const size_t length = strlen(path), ending_length = strlen(ending);
    return length >= ending_length && strcasecmp(path + length - ending_length, ending) == 0;
}

static air_status load_grid(air_context *context, const char *path, const air_grid_file *file,
                            air_grid **out_grid)
{
    if (file->raw)
        return air_grid_load_raw(context, path, file->size, file->channels, out_grid);
    if (has_ending(path, ".nvdb"))
        return air_grid_load_nvdb(context, path, file->name, out_grid);
    if (has_ending(path, ".vol"))
        return air_grid_load_vol(context, path, out_grid);
    return air_fail(context, AIR_ERROR_UNSUPPORTED,
                    "%s: grid files end in .nvdb or .vol (airlight convert makes .nvdb from .vdb)",
                    path);
}

static air_status load_record(air_context *context, const char *path, const air_grid_file *file,
                              air_grid_record **out_record)
{
    air_grid *grid = NULL;
    const air_status status = load_grid(context, path, file, &grid);
    return status == AIR_OK ? make_record(context, path, grid, out_record) : status;
}

static air_status keep_sequence(air_grid_record *record, const air_grid_file *file)
{
    air_context *context = record->base.context;
    bool ok = true;
    record->sequence = *file;
    record->sequence.path = air_record_copy(context, file->path, strlen(file->path) + 1, 1, &ok);
    record->sequence.name =
        file->name == NULL ? NULL
                           : air_record_copy(context, file->name, strlen(file->name) + 1, 1, &ok);
    return ok ? AIR_OK : air_fail_memory(context, "grid");
}

static air_status load_frame(air_context *context, const air_grid_file *file, int64_t frame,
                             air_grid_record **out_record)
{
    const size_t size = strlen(file->path) + AIR_FRAME_DIGITS_MAX + 1;
    char *path = air_allocate(context, size, 1);
    if (path == NULL)
        return air_fail_memory(context, file->path);
    air_status status = air_frame_path(context, file->path, frame, path, size);
    if (status == AIR_OK)
        status = load_record(context, path, file, out_record);
    air_free(context, path);
    if (status != AIR_OK)
        return status;
    status = keep_sequence(*out_record, file);
    if (status != AIR_OK)
        air_record_release(&(*out_record)->base);
    return status;
}

/* Without a frame a name with # is that of a file like others, which mostly is not there. Read
 * twice if it is: the message is to be the only one. */
static air_status check_literal(air_context *context, const char *path)
{
    const char *const slash = strrchr(path, '/');
    void *data = NULL;
    size_t size = 0;
    if (strchr(slash != NULL ? slash : path, '#') == NULL)
        return AIR_OK;
    const air_status status = air_file_read_optional(context, path, &data, &size);
    if (status == AIR_OK && data == NULL)
        return air_fail(context, AIR_ERROR_IO,
                        "%s: there is no such file, and # stands for the number of a frame: "
                        "expected one (--frames of airlight render, --frame of bake and info)",
                        path);
    air_free(context, data);
    return status;
}

air_status air_grid_record_load(air_context *context, const air_grid_file *file, int64_t frame,
                                air_record **out_record)
{
    air_grid_record *record = NULL;
    size_t digits = 0;
    air_status status = frame == AIR_FRAME_NONE ? check_literal(context, file->path)
                                                : air_frame_digits(context, file->path, &digits);
    if (status == AIR_OK)
        status = digits > 0 ? load_frame(context, file, frame, &record)
                            : load_record(context, file->path, file, &record);
    if (status == AIR_OK)
        *out_record = &record->base;
    return status;
}

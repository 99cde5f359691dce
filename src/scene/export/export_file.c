/* export_file.c: files beside the GLB: environments as OpenEXR, grids as Mitsuba's .vol. Both hold
 * floats as they are. */
#include <ctype.h>
#include <string.h>

#include "core/vec.h"
#include "scene/export/export.h"

/* ---- names ---- */

static bool is_taken(const air_export *self, const char *name)
{
    for (size_t i = 0; i < self->file_count; ++i)
        if (strcmp(self->files[i].name, name) == 0)
            return true;
    return false;
}

/* "STEM.NAME.ENDING", not yet taken; NULL when memory is out. */
static char *choose_name(air_export *self, const char *name, const char *ending)
{
    char part[64];
    size_t length = 0;
    for (; name[length] != '\0' && length + 1 < sizeof part; ++length) {
        const unsigned char c = (unsigned char)name[length];
        part[length] = isalnum(c) || c == '-' || c == '_' ? (char)c : '-';
    }
    part[length] = '\0';
    for (size_t number = 1;; ++number) {
        char *file =
            number == 1
                ? air_string_format(self->context, "%s.%s%s", self->stem, part, ending)
                : air_string_format(self->context, "%s.%s-%zu%s", self->stem, part, number, ending);
        if (file == NULL)
            (void)air_fail_memory(self->context, self->path);
        if (file == NULL || !is_taken(self, file))
            return file;
        air_free(self->context, file);
    }
}

/* Keeps (takes) the name under which something is to be found. */
static air_status keep_file(air_export *self, air_handle handle, const float box[6], char *name)
{
    if (self->file_count == self->file_capacity) {
        const size_t capacity = 2 * self->file_capacity + 4;
        air_export_file *grown =
            air_reallocate(self->context, self->files, capacity, sizeof *grown);
        if (grown == NULL) {
            air_free(self->context, name);
            return air_fail_memory(self->context, self->path);
        }
        self->files = grown;
        self->file_capacity = capacity;
    }
    air_export_file *file = &self->files[self->file_count++];
    *file = (air_export_file){.handle = handle, .name = name};
    if (box != NULL)
        memcpy(file->box, box, sizeof file->box);
    return AIR_OK;
}

/* That name, NULL if it is not there yet. */
static const char *find_file(const air_export *self, air_handle handle, const float box[6])
{
    static const float none[6] = {0.0f};
    for (size_t i = 0; i < self->file_count; ++i)
        if (self->files[i].handle == handle &&
            memcmp(self->files[i].box, box != NULL ? box : none, sizeof none) == 0)
            return self->files[i].name;
    return NULL;
}

/* ---- environments ---- */

/* R, G, B as the reader lays them side by side again. */
static void fill_planes(const air_texture *texture, air_image *image)
{
    for (size_t i = 0; i < texture->width * texture->height; ++i) {
        float rgba[4];
        air_texture_texel(texture, i % texture->width, i / texture->width, rgba);
        for (size_t c = 0; c < 3; ++c)
            air_image_plane(image, c)[i] = rgba[c];
    }
}

static air_status add_image(air_export *self, const air_texture *texture, const char *file)
{
    static const char *const channels[] = {"R", "G", "B"};
    air_image *image = NULL;
    air_image_save_params params;
    air_image_save_params_default(&params);
    air_status status =
        air_image_create(self->context, texture->width, texture->height, 3, channels, &image);
    if (status != AIR_OK)
        return status;
    fill_planes(texture, image);
    status = air_staging_add_image(&self->staging, file, image, &params);
    air_image_destroy(image);
    return status;
}

air_status air_export_image(air_export *self, air_handle texture, const char *name,
                            const char **out_file)
{
    *out_file = find_file(self, texture, NULL);
    if (*out_file != NULL)
        return AIR_OK;
    const air_record *record = air_export_record(self, AIR_OBJECT_TEXTURE, texture);
    char *file = choose_name(self, name[0] != '\0' ? name : "environment", ".exr");
    if (file == NULL)
        return AIR_ERROR_MEMORY;
    air_status status = keep_file(self, texture, NULL, file);
    if (status == AIR_OK)
        status = add_image(self, &((const air_texture_record *)record)->texture, file);
    if (status == AIR_OK)
        *out_file = file;
    return status;
}

/* ---- grids ---- */

/* The header of grid_vol.c: encoding 1 is float32. */
typedef struct air_vol_header {
    char magic[3];
    uint8_t version;
    int32_t encoding, size[3], channels;
    float box[6];
} air_vol_header;

/* The grid's values where the .vol has its own, x fastest. */
static void sample_grid(const air_export_grid_source *source, size_t channels, float *out)
{
    for (size_t k = 0; k < source->size[2]; ++k)
        for (size_t j = 0; j < source->size[1]; ++j)
            for (size_t i = 0; i < source->size[0]; ++i, out += channels) {
                const air_vec3 at =
                    affine_point(source->to_index, vec3((float)i, (float)j, (float)k));
                float rgb[3];
                vec3_store(rgb, air_grid_lookup(source->grid, at));
                memcpy(out, rgb, channels * sizeof *out);
            }
}

static air_status add_grid(air_export *self, const air_export_grid_source *source, const char *file)
{
    const size_t channels = air_grid_channels(source->grid);
    const size_t *n = source->size;
    air_vol_header header = {.magic = {'V', 'O', 'L'},
                             .version = 3,
                             .encoding = 1,
                             .size = {(int32_t)n[0], (int32_t)n[1], (int32_t)n[2]},
                             .channels = (int32_t)channels};
    memcpy(header.box, source->box, sizeof header.box);
    const size_t count = n[0] * n[1] * n[2] * channels;
    uint8_t *data =
        air_allocate(self->context, count + sizeof header / sizeof(float), sizeof(float));
    if (data == NULL)
        return air_fail_memory(self->context, file);
    memcpy(data, &header, sizeof header);
    sample_grid(source, channels, (float *)(void *)(data + sizeof header));
    const air_status status =
        air_staging_add(&self->staging, file, data, sizeof header + count * sizeof(float));
    air_free(self->context, data);
    return status;
}

air_status air_export_grid(air_export *self, air_handle handle, const char *name,
                           const air_export_grid_source *source, const char **out_file)
{
    *out_file = find_file(self, handle, source->box);
    if (*out_file != NULL)
        return AIR_OK;
    char *file = choose_name(self, name, ".vol");
    if (file == NULL)
        return AIR_ERROR_MEMORY;
    air_status status = keep_file(self, handle, source->box, file);
    if (status == AIR_OK)
        status = add_grid(self, source, file);
    if (status == AIR_OK)
        *out_file = file;
    return status;
}

/* export_grid.c: the grids of a medium. A .vol file knows a box but no map, so that the rest of a
 * grid's map goes into the medium's. */
#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/export/export.h"

enum { DENSITY = 0, ALBEDO = 1, EMISSION = 2, ROLES = 3 };

/* The grids of a medium on their way into files. */
typedef struct air_medium_grids {
    const air_medium_desc *medium;
    air_handle handles[ROLES];
    air_export_grid_source sources[ROLES];
    float to_world[12]; /* from the space that the boxes are in */
} air_medium_grids;

/* As the reader of .vol: the step between voxels and the place of the first, along one axis. */
static void read_axis(float low, float high, size_t size, float *step, float *first)
{
    const double exact = ((double)high - (double)low) / (double)size;
    *step = (float)exact;
    *first = (float)((double)low + 0.5 * exact);
}

/* The ends between which `size` voxels have this step and this first place, to the last bit if
 * there are such; returns whether. */
static bool find_ends(float step, float first, size_t size, float *out_low, float *out_high)
{
    const float low = (float)((double)first - 0.5 * (double)step);
    const float high = (float)((double)first + ((double)size - 0.5) * (double)step);
    *out_low = low;
    *out_high = high;
    for (int i = 0; i < 25; ++i) {
        float tried[2] = {low, high}, step_read = 0.0f, first_read = 0.0f;
        const int moves[2] = {i % 5 - 2, i / 5 - 2};
        for (int end = 0; end < 2; ++end)
            for (int move = 0; move < abs(moves[end]); ++move)
                tried[end] = nextafterf(tried[end], moves[end] < 0 ? -INFINITY : INFINITY);
        read_axis(tried[0], tried[1], size, &step_read, &first_read);
        if (step_read == step && first_read == first) {
            *out_low = tried[0];
            *out_high = tried[1];
            return true;
        }
    }
    return false;
}

typedef enum air_box_fit { AIR_BOX_NONE = 0, AIR_BOX_NEAR = 1, AIR_BOX_EXACT = 2 } air_box_fit;

/* The box that voxels of this map fill. NONE: the map turns, shears or mirrors. */
static air_box_fit find_box(const float map[12], const size_t size[3], float out[6])
{
    air_box_fit fit = AIR_BOX_EXACT;
    float least = INFINITY, off = 0.0f;
    for (size_t i = 0; i < 12; ++i) {
        if (i % 5 == 0)
            least = fminf(least, map[i]);
        else if (i % 4 != 3)
            off = fmaxf(off, fabsf(map[i]));
    }
    if (!(least > 0.0f) || off > 1e-5f * least)
        return AIR_BOX_NONE;
    for (size_t k = 0; k < 3; ++k)
        if (!find_ends(map[5 * k], map[4 * k + 3], size[k], &out[k], &out[3 + k]))
            fit = AIR_BOX_NEAR;
    return off > 0.0f ? AIR_BOX_NEAR : fit;
}

static void open_source(const air_export *self, air_handle handle, air_export_grid_source *out)
{
    static const float identity[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                       0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    out->grid = ((const air_grid_record *)air_export_record(self, AIR_OBJECT_GRID, handle))->grid;
    air_grid_size(out->grid, out->size);
    memcpy(out->to_index, identity, sizeof identity);
}

/* Every grid as it is, in the space they have in common; false: not all of their maps are boxes. */
static bool place_as_they_are(air_medium_grids *grids)
{
    memcpy(grids->to_world, grids->medium->density.grid_to_world, sizeof grids->to_world);
    for (size_t i = 0; i < ROLES; ++i) {
        air_export_grid_source *source = &grids->sources[i];
        if (source->grid != NULL && find_box(air_grid_index_to_local(source->grid), source->size,
                                             source->box) != AIR_BOX_EXACT)
            return false;
    }
    return true;
}

/* Samples a grid anew where the density has its voxels. */
static void sample_like_density(const air_export *self, const float density_to_index[12],
                                air_medium_grids *grids, size_t role)
{
    const air_export_grid_source *density = &grids->sources[DENSITY];
    air_export_grid_source *source = &grids->sources[role];
    memcpy(source->size, density->size, sizeof source->size);
    memcpy(source->box, density->box, sizeof source->box);
    memcpy(source->to_index, density_to_index, sizeof source->to_index);
    air_warn(self->context,
             "%s: medium \"%s\": its %s grid, which is turned against the density, was sampled "
             "anew at the density's places",
             self->path, grids->medium->name, role == ALBEDO ? "albedo" : "emission");
}

/* All grids in the index space of the density, whose map goes into that of the medium. */
static air_status place_by_density(const air_export *self, air_medium_grids *grids)
{
    air_export_grid_source *density = &grids->sources[DENSITY];
    const float *to_local = air_grid_index_to_local(density->grid);
    float from_local[12], relative[12], inverse[12];
    if (!affine_invert(to_local, from_local))
        return air_fail(self->context, AIR_ERROR_INTERNAL, "%s: the map of a grid is singular",
                        self->path);
    affine_multiply(grids->medium->density.grid_to_world, to_local, grids->to_world);
    for (size_t k = 0; k < 3; ++k) {
        density->box[k] = -0.5f;
        density->box[3 + k] = (float)density->size[k] - 0.5f;
    }
    for (size_t i = ALBEDO; i < ROLES; ++i) {
        air_export_grid_source *source = &grids->sources[i];
        if (source->grid == NULL)
            continue;
        affine_multiply(from_local, air_grid_index_to_local(source->grid), relative);
        if (find_box(relative, source->size, source->box) == AIR_BOX_NONE &&
            affine_invert(relative, inverse))
            sample_like_density(self, inverse, grids, i);
    }
    return AIR_OK;
}

static void warn_of_sequence(const air_export *self, const air_medium_grids *grids)
{
    for (size_t i = 0; i < ROLES; ++i) {
        if (grids->handles[i] == AIR_NONE)
            continue;
        const air_grid_record *record =
            (const air_grid_record *)air_export_record(self, AIR_OBJECT_GRID, grids->handles[i]);
        if (record->sequence.path != NULL)
            air_warn(self->context,
                     "%s: medium \"%s\": of the sequence %s the present frame is written",
                     self->path, grids->medium->name, record->sequence.path);
    }
}

/* "NAME", "NAME-albedo" */
static air_status write_grid(air_export *self, const air_medium_grids *grids, size_t role,
                             const char **out_file)
{
    static const char *const suffixes[ROLES] = {"", "-albedo", "-emission"};
    const char *medium = grids->medium->name[0] != '\0' ? grids->medium->name : "density";
    char *name = air_string_format(self->context, "%s%s", medium, suffixes[role]);
    if (name == NULL)
        return air_fail_memory(self->context, self->path);
    const air_status status =
        air_export_grid(self, grids->handles[role], name, &grids->sources[role], out_file);
    air_free(self->context, name);
    return status;
}

air_status air_export_medium_grids(air_export *self, const air_medium_desc *medium, json_t *object)
{
    static const char *const keys[ROLES] = {"grid", "albedo_grid", "emission_grid"};
    const air_density *density = &medium->density;
    air_medium_grids grids = {
        .medium = medium, .handles = {density->grid, density->albedo_grid, density->emission_grid}};
    for (size_t i = 0; i < ROLES; ++i)
        if (grids.handles[i] != AIR_NONE)
            open_source(self, grids.handles[i], &grids.sources[i]);
    warn_of_sequence(self, &grids);
    air_status status = place_as_they_are(&grids) ? AIR_OK : place_by_density(self, &grids);
    for (size_t i = 0; i < ROLES && status == AIR_OK; ++i) {
        const char *file = NULL;
        if (grids.handles[i] == AIR_NONE)
            continue;
        json_t *parent = i == DENSITY ? air_export_object(self, object, "density") : object;
        json_t *grid = air_export_object(self, parent, keys[i]);
        status = write_grid(self, &grids, i, &file);
        if (file != NULL)
            air_export_put(self, grid, "file", air_export_string(self, file));
        if (i == DENSITY && !air_export_is_identity(grids.to_world))
            air_export_put(self, grid, "to_world", air_export_rows(self, grids.to_world));
    }
    return status;
}

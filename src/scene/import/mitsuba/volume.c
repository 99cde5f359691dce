#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/grid_record.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/scene.h"

/* A volume: either a grid with its map to the world, or the same value everywhere. */
typedef struct air_mitsuba_volume {
    air_handle grid; /* AIR_NONE: constant */
    float grid_to_world[12];
    float value[3];
} air_mitsuba_volume;

static const air_grid *grid_of(const air_mitsuba *mitsuba, air_handle handle)
{
    const air_slot_list *list = &mitsuba->import->scene->lists[AIR_OBJECT_GRID];
    const air_slot *slot = &list->slots[air_slot_find(list, handle)];
    return ((const air_grid_record *)slot->record)->grid;
}

/* The box that a file says its grid fills: its cells', which airlight's grids are made of. */
static void file_box(const air_grid *grid, size_t size[3], float low[3], float high[3])
{
    const float *map = air_grid_index_to_local(grid);
    air_grid_size(grid, size);
    for (size_t i = 0; i < 3; ++i) {
        low[i] = map[4 * i + 3] - 0.5f * map[5 * i];
        high[i] = low[i] + (float)size[i] * map[5 * i];
    }
}

/* Where the box is to lie. Version 3: the unit cube, unless use_grid_bbox; 0.x: as in the file, or
 * from min to max. */
static air_status read_box(const air_mitsuba *mitsuba, const air_xml *at, float low[3],
                           float high[3])
{
    bool own = air_mitsuba_is_old(at);
    air_status status = air_mitsuba_boolean(mitsuba, at, "use_grid_bbox", &own);
    for (size_t i = 0; i < 3 && !own; ++i) {
        low[i] = 0.0f;
        high[i] = 1.0f;
    }
    if (status == AIR_OK)
        status = air_mitsuba_vector(mitsuba, at, "min", low);
    if (status == AIR_OK)
        status = air_mitsuba_vector(mitsuba, at, "max", high);
    for (size_t i = 0; i < 3 && status == AIR_OK; ++i)
        if (!(low[i] < high[i]))
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected min below max, found %g and %g", (double)low[i],
                                    (double)high[i]);
    return status;
}

/* Version 0.x has the outermost values on the faces of the box, not half a cell inside: that
 * stretches the grid about the box's middle [Mitsuba06, gridvolume]. */
static void place(const air_grid *grid, const float low[3], const float high[3], bool on_faces,
                  float out[12])
{
    size_t size[3];
    float from[3], to[3];
    file_box(grid, size, from, to);
    memset(out, 0, 12 * sizeof *out);
    for (size_t i = 0; i < 3; ++i) {
        const float stretch =
            on_faces && size[i] > 1 ? (float)size[i] / (float)(size[i] - 1) : 1.0f;
        const float scale = stretch * (high[i] - low[i]) / (to[i] - from[i]);
        out[5 * i] = scale;
        out[4 * i + 3] = 0.5f * (low[i] + high[i]) - scale * 0.5f * (from[i] + to[i]);
    }
}

static air_status load_grid(air_mitsuba *mitsuba, air_xml *at, air_handle *out_handle)
{
    const air_mitsuba_made *made = air_mitsuba_find_made(at, NULL);
    const char *name = NULL;
    char *path = NULL;
    if (made != NULL) {
        (void)air_mitsuba_parameter(at, "filename");
        *out_handle = made->handle;
        return AIR_OK;
    }
    air_status status = air_mitsuba_filename(mitsuba, at, &name);
    if (status == AIR_OK)
        status = air_mitsuba_file(mitsuba, at, name, &path);
    if (status == AIR_OK)
        status = air_xml_place_error(
            &mitsuba->document, at,
            air_scene_load_grid(mitsuba->import->scene, path, NULL, out_handle));
    air_free(mitsuba->context, path);
    if (status == AIR_OK && air_mitsuba_note_made(mitsuba, at, NULL, *out_handle) == NULL)
        status = AIR_ERROR_MEMORY;
    return status;
}

static air_status read_grid(air_mitsuba *mitsuba, air_xml *at, air_mitsuba_volume *out)
{
    static const char *const ignored[] = {"send_data", "raw", "accel", "max_value", "wrap_mode"};
    static const char *const filters[] = {"trilinear", "nearest"};
    float to_world[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, low[3], high[3], local[12];
    size_t size[3], filter = 0;
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = load_grid(mitsuba, at, &out->grid);
    if (status == AIR_OK)
        status = air_mitsuba_choice(mitsuba, at, "filter_type", filters, 2, &filter);
    if (status == AIR_OK && filter == 1)
        status = air_mitsuba_warn(mitsuba, at, "between its values the grid is taken as trilinear");
    if (status == AIR_OK)
        status = air_mitsuba_transform(mitsuba, at, "to_world", to_world);
    if (status != AIR_OK)
        return status;
    const air_grid *grid = grid_of(mitsuba, out->grid);
    file_box(grid, size, low, high);
    status = read_box(mitsuba, at, low, high);
    place(grid, low, high, air_mitsuba_is_old(at), local);
    affine_multiply(to_world, local, out->grid_to_world);
    return status;
}

/* A parameter that is a volume, or a number or colour as version 3 allows. */
static air_status read_volume(air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              air_mitsuba_volume *out)
{
    static const char *const types[] = {"gridvolume", "constvolume"};
    air_xml *found = air_mitsuba_parameter(at, name), *target = NULL;
    if (found == NULL)
        return AIR_OK;
    air_status status = air_mitsuba_resolve(mitsuba, found, &target);
    if (status != AIR_OK)
        return status;
    if (strcmp(target->tag, "volume") != 0)
        return air_mitsuba_read_color(mitsuba, target, AIR_MITSUBA_REFLECTANCE, out->value);
    target->used = target->asked = true;
    if (air_mitsuba_is(target, "gridvolume"))
        return read_grid(mitsuba, target, out);
    if (air_mitsuba_is(target, "constvolume"))
        return air_mitsuba_color(mitsuba, target, "value", AIR_MITSUBA_REFLECTANCE, out->value);
    return air_mitsuba_unknown_type(mitsuba, target, types, 2, "1 is taken");
}

/* Within rounding. */
static bool same_map(const float a[12], const float b[12])
{
    for (size_t i = 0; i < 12; ++i)
        if (fabsf(a[i] - b[i]) > 1e-4f * (fabsf(a[i]) + fabsf(b[i])) + 1e-6f)
            return false;
    return true;
}

air_status air_mitsuba_read_volumes(air_mitsuba *mitsuba, air_xml *at, float scale,
                                    air_medium_desc *desc)
{
    air_mitsuba_volume density = {.value = {1.0f, 1.0f, 1.0f}};
    air_mitsuba_volume albedo = {.value = {0.75f, 0.75f, 0.75f}};
    air_status status =
        read_volume(mitsuba, at, air_mitsuba_has(at, "sigma_t") ? "sigma_t" : "density", &density);
    if (status == AIR_OK)
        status = read_volume(mitsuba, at, "albedo", &albedo);
    if (status != AIR_OK)
        return status;
    if (albedo.grid != AIR_NONE && density.grid == AIR_NONE)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "an albedo that varies is supported only where the density does");
    if (albedo.grid != AIR_NONE && !same_map(albedo.grid_to_world, density.grid_to_world))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "expected the grids of density and albedo to have the same place");
    for (size_t i = 0; i < 3; ++i) {
        const float share = albedo.grid != AIR_NONE ? 1.0f : albedo.value[i];
        const float sigma_t = scale * (density.grid != AIR_NONE ? 1.0f : density.value[i]);
        if (!(share >= 0.0f && share <= 1.0f))
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected an albedo of 0 to 1, found %g", (double)share);
        desc->sigma_s[i] = sigma_t * share;
        desc->sigma_a[i] = sigma_t - desc->sigma_s[i];
    }
    if (density.grid == AIR_NONE)
        return AIR_OK;
    desc->density.kind = AIR_DENSITY_GRID;
    desc->density.grid = density.grid;
    desc->density.albedo_grid = albedo.grid;
    memcpy(desc->density.grid_to_world, density.grid_to_world, sizeof density.grid_to_world);
    return AIR_OK;
}

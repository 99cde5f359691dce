#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/import.h"
#include "scene/import/resource.h"

/* Heights h = up . x of a space become n . y = h / stretch + offset in the world, n unit. */
typedef struct air_height_map {
    float up[3];
    float stretch, offset;
} air_height_map;

static air_status map_heights(const air_json *at, const air_json *up_at, const float to_world[12],
                              air_height_map *out)
{
    float up[3] = {0.0f, 1.0f, 0.0f}, inverse[12];
    if (up_at->value != NULL) {
        const air_status status = air_sidecar_read_direction(up_at, up);
        if (status != AIR_OK)
            return status;
    }
    if (!affine_invert(to_world, inverse))
        return air_json_fail(at, AIR_ERROR_FORMAT, "the node is scaled to nothing");
    const air_vec3 normal =
        affine_normal(inverse, vec3_load(up)); /* planes map by the inverse transpose */
    out->stretch = vec3_length(normal);
    const air_vec3 unit = vec3_scale(normal, 1.0f / out->stretch);
    vec3_store(out->up, unit);
    out->offset = vec3_dot(unit, vec3(to_world[3], to_world[7], to_world[11]));
    return AIR_OK;
}

static air_status read_layer(const air_json *at, size_t index, const air_height_map *map,
                             air_density *density)
{
    static const char *const keys[] = {"bottom", "density"};
    const air_json bottom_at = air_json_get(at, "bottom");
    const air_json density_at = air_json_get(at, "density");
    float bottom = 0.0f;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, 2);
    if (status == AIR_OK)
        status = air_json_require(&bottom_at, "a height");
    if (status == AIR_OK)
        status = air_json_float(&bottom_at, AIR_JSON_ANY, &bottom);
    if (status == AIR_OK)
        status = air_json_require(&density_at, "a density");
    if (status == AIR_OK)
        status = air_json_float(&density_at, AIR_JSON_NON_NEGATIVE, &density->layer_density[index]);
    if (status != AIR_OK)
        return status;
    density->layer_bottom[index] = bottom / map->stretch + map->offset;
    if (index > 0 && !(density->layer_bottom[index] > density->layer_bottom[index - 1]))
        return air_json_expected(&bottom_at, "a height above the layer before");
    return AIR_OK;
}

static air_status read_layers(const air_json *at, const air_json *layers, const air_height_map *map,
                              air_density *density)
{
    const air_json top_at = air_json_get(at, "top");
    const size_t count = air_json_count(layers);
    if (count < 1 || count > AIR_MAX_LAYERS)
        return air_json_expected(layers, "an array of 1 to %d layers", (int)AIR_MAX_LAYERS);
    air_status status = AIR_OK;
    for (size_t i = 0; i < count && status == AIR_OK; ++i) {
        const air_json layer = air_json_at(layers, i);
        status = read_layer(&layer, i, map, density);
    }
    float top = INFINITY;
    if (status == AIR_OK)
        status = air_json_float(&top_at, AIR_JSON_ANY, &top);
    if (status != AIR_OK)
        return status;
    density->kind = AIR_DENSITY_LAYERED;
    density->layer_count = count;
    density->layer_top = top / map->stretch + map->offset;
    if (!(density->layer_top > density->layer_bottom[count - 1]))
        return air_json_expected(&top_at, "a height above the bottom of the last layer");
    return AIR_OK;
}

static air_status read_exponential(const air_json *at, const air_height_map *map,
                                   air_density *density)
{
    static const char *const keys[] = {"base_height", "scale_height"};
    const air_json base_at = air_json_get(at, "base_height");
    const air_json scale_at = air_json_get(at, "scale_height");
    float base = 0.0f, scale = 1.0f;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, 2);
    if (status == AIR_OK)
        status = air_json_float(&base_at, AIR_JSON_ANY, &base);
    if (status == AIR_OK)
        status = air_json_require(&scale_at, "a scale height in metres");
    if (status == AIR_OK)
        status = air_json_float(&scale_at, AIR_JSON_POSITIVE, &scale);
    if (status != AIR_OK)
        return status;
    density->kind = AIR_DENSITY_EXPONENTIAL;
    density->base_height = base / map->stretch + map->offset;
    density->scale_height = scale / map->stretch;
    return AIR_OK;
}

static bool is_raw(const char *path)
{
    const size_t length = strlen(path);
    return length >= 4 && strcmp(path + length - 4, ".raw") == 0;
}

static air_status load_raw_grid(const air_sidecar_part *part, const air_json *at, const char *path,
                                air_handle *out_handle)
{
    const air_json size_at = air_json_get(at, "size");
    const air_json channels_at = air_json_get(at, "channels");
    size_t size[3] = {0, 0, 0}, channels = 1;
    air_status status = AIR_OK;
    if (air_json_count(&size_at) != 3)
        status = air_json_expected(&size_at, "an array of three sizes for a raw grid");
    for (size_t i = 0; i < 3 && status == AIR_OK; ++i) {
        const air_json one = air_json_at(&size_at, i);
        status = air_json_size(&one, &size[i]);
        if (status == AIR_OK && size[i] == 0)
            status = air_json_expected(&one, "a size of at least 1");
    }
    if (status == AIR_OK)
        status = air_json_size(&channels_at, &channels);
    if (status == AIR_OK && channels != 1 && channels != 3)
        status = air_json_expected(&channels_at, "1 or 3");
    return status == AIR_OK
               ? air_scene_load_raw_grid(part->import->scene, path, size, channels, out_handle)
               : status;
}

/* Loads the grid that an object {"file", "name", "size", "channels"} describes. placed: it may have
 * a map of its own. */
static air_status load_grid(const air_sidecar_part *part, const air_json *at, bool placed,
                            air_handle *out_handle)
{
    static const char *const keys[] = {"file", "name", "size", "channels", "to_world"};
    const air_json file_at = air_json_get(at, "file");
    const air_json name_at = air_json_get(at, "name");
    const air_json size_at = air_json_get(at, "size");
    const air_json channels_at = air_json_get(at, "channels");
    const char *file = NULL, *name = NULL;
    air_context *context = part->import->context;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, placed ? 5 : 4);
    if (status == AIR_OK)
        status = air_json_require(&file_at, "the path of a grid");
    if (status == AIR_OK)
        status = air_json_string(&file_at, &file);
    if (status == AIR_OK)
        status = air_json_string(&name_at, &name);
    if (status == AIR_OK && !is_raw(file) && (size_at.value != NULL || channels_at.value != NULL))
        status = air_json_fail(size_at.value != NULL ? &size_at : &channels_at, AIR_ERROR_FORMAT,
                               "only a raw grid has to be told its size");
    if (status != AIR_OK)
        return status;
    char *path = air_path_join(context, at->document->folder, file);
    if (path == NULL)
        return AIR_ERROR_MEMORY;
    status = is_raw(file) ? load_raw_grid(part, at, path, out_handle)
                          : air_scene_load_grid(part->import->scene, path, name, out_handle);
    air_free(context, path);
    return status;
}

static air_status read_grid(const air_sidecar_part *part, const air_json *at, air_density *density)
{
    const air_json map_at = air_json_get(at, "to_world");
    float local[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    air_status status = load_grid(part, at, true, &density->grid);
    if (status == AIR_OK && map_at.value != NULL)
        status = air_sidecar_read_map(&map_at, local);
    if (status != AIR_OK)
        return status;
    density->kind = AIR_DENSITY_GRID;
    affine_multiply(part->to_world, local, density->grid_to_world);
    return AIR_OK;
}

/* Grids beside the density: of the albedo and of the emission. */
static air_status read_side_grid(const air_sidecar_part *part, const char *key,
                                 air_density *density, air_handle *out_handle)
{
    const air_json at = air_json_get(part->at, key);
    if (at.value == NULL)
        return AIR_OK;
    if (density->kind != AIR_DENSITY_GRID)
        return air_json_fail(&at, AIR_ERROR_FORMAT, "expected a density grid beside it");
    return load_grid(part, &at, false, out_handle);
}

static air_status read_kind(const air_sidecar_part *part, const air_json *at, air_density *density)
{
    static const char *const keys[] = {"layers", "top", "exponential", "grid", "up"};
    const air_json layers = air_json_get(at, "layers");
    const air_json top = air_json_get(at, "top");
    const air_json exponential = air_json_get(at, "exponential");
    const air_json grid = air_json_get(at, "grid");
    const air_json up = air_json_get(at, "up");
    air_height_map map = {0};
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, sizeof keys / sizeof keys[0]);
    if (status != AIR_OK)
        return status;
    if ((layers.value != NULL) + (exponential.value != NULL) + (grid.value != NULL) != 1)
        return air_json_fail(at, AIR_ERROR_FORMAT, "expected one of layers, exponential and grid");
    if (top.value != NULL && layers.value == NULL)
        return air_json_fail(&top, AIR_ERROR_FORMAT, "only layers have a top");
    if (up.value != NULL && grid.value != NULL)
        return air_json_fail(&up, AIR_ERROR_FORMAT, "a grid has no up; give it a to_world");
    if (grid.value != NULL)
        return read_grid(part, &grid, density);
    status = map_heights(at, &up, part->to_world, &map);
    if (status != AIR_OK)
        return status;
    memcpy(density->up, map.up, sizeof density->up);
    return layers.value != NULL ? read_layers(at, &layers, &map, density)
                                : read_exponential(&exponential, &map, density);
}

air_status air_sidecar_read_density(const air_sidecar_part *part, air_medium_desc *desc)
{
    const air_json at = air_json_get(part->at, "density");
    air_status status = AIR_OK;
    if (at.value != NULL)
        status = read_kind(part, &at, &desc->density);
    if (status == AIR_OK)
        status = read_side_grid(part, "albedo_grid", &desc->density, &desc->density.albedo_grid);
    if (status == AIR_OK)
        status =
            read_side_grid(part, "emission_grid", &desc->density, &desc->density.emission_grid);
    return status;
}

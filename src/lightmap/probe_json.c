/* probe_json.c: probes as JSON. */
#include <string.h>

#include "lightmap/files.h"

static json_t *set_to_json(const air_probe_set *set)
{
    json_t *object = json_object();
    json_object_set_new(object, "name", air_place_text(set->name != NULL ? set->name : ""));
    json_object_set_new(object, "count", json_integer((json_int_t)set->count));
    if (set->grid) {
        json_t *grid = json_object(), *size = json_array();
        for (size_t k = 0; k < 3; k++) {
            json_array_append_new(size, json_integer((json_int_t)set->size[k]));
        }
        json_object_set_new(grid, "size", size);
        json_object_set_new(grid, "origin", air_place_numbers(set->origin, 3));
        json_object_set_new(grid, "step", air_place_numbers(set->step[0], 9));
        json_object_set_new(object, "grid", grid);
    }
    json_object_set_new(object, "positions", air_place_numbers(set->positions, 3 * set->count));
    json_object_set_new(object, "validity", air_place_numbers(set->validity, set->count));
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        json_object_set_new(
            object, air_light_layer_name((air_light_layer)k),
            air_place_numbers(set->layers[k], 3 * AIR_PROBE_COEFFICIENTS * set->count));
    }
    return object;
}

json_t *air_probe_sets_to_json(const air_lightmap *lightmap)
{
    json_t *root = json_object(), *sets = json_array();
    json_object_set_new(root, "airlight_probes", json_integer(AIR_LIGHTMAP_VERSION));
    for (size_t i = 0; i < lightmap->probe_set_count; i++) {
        json_array_append_new(sets, set_to_json(&lightmap->probe_sets[i]));
    }
    json_object_set_new(root, "sets", sets);
    return root;
}

static air_status grid_from_json(const air_place *at, air_probe_set *set)
{
    const air_place size = air_place_get(at, "size");
    const air_place origin = air_place_get(at, "origin");
    const air_place step = air_place_get(at, "step");
    air_status status = AIR_OK;
    if (air_place_count(&size) != 3) {
        return air_place_wrong(&size, "an array of 3 whole numbers");
    }
    for (size_t k = 0; k < 3 && status == AIR_OK; k++) {
        const air_place item = air_place_at(&size, k);
        status = air_place_size(&item, UINT32_MAX, &set->size[k]);
    }
    if (status == AIR_OK) {
        status = air_place_floats(&origin, 3, set->origin);
    }
    if (status == AIR_OK) {
        status = air_place_floats(&step, 9, set->step[0]);
    }
    set->grid = true;
    return status;
}

static air_status set_from_json(const air_place *at, air_probe_set *set)
{
    const air_place name = air_place_get(at, "name");
    const air_place count = air_place_get(at, "count");
    const air_place grid = air_place_get(at, "grid");
    const air_place positions = air_place_get(at, "positions");
    const air_place validity = air_place_get(at, "validity");
    air_status status = air_place_string(&name, &set->name);
    if (status == AIR_OK) {
        status = air_place_size(&count, UINT32_MAX, &set->count);
    }
    if (status == AIR_OK && grid.value != NULL) {
        status = grid_from_json(&grid, set);
    }
    if (status == AIR_OK) {
        status = air_place_new_floats(&positions, 3 * set->count, &set->positions);
    }
    if (status == AIR_OK) {
        status = air_place_new_floats(&validity, set->count, &set->validity);
    }
    for (size_t k = 0; k < AIR_LAYER_COUNT && status == AIR_OK; k++) {
        const air_place layer = air_place_get(at, air_light_layer_name((air_light_layer)k));
        status =
            air_place_new_floats(&layer, 3 * AIR_PROBE_COEFFICIENTS * set->count, &set->layers[k]);
    }
    return status;
}

air_status air_probe_sets_from_json(const air_place *root, air_lightmap *lightmap)
{
    const air_place version = air_place_get(root, "airlight_probes");
    const air_place sets = air_place_get(root, "sets");
    int64_t number = 0;
    air_status status =
        air_place_integer(&version, AIR_LIGHTMAP_VERSION, AIR_LIGHTMAP_VERSION, &number);
    if (status == AIR_OK) {
        status = air_place_array(&sets);
    }
    if (status != AIR_OK || air_place_count(&sets) == 0) {
        return status;
    }
    lightmap->probe_sets =
        air_allocate(root->context, air_place_count(&sets), sizeof *lightmap->probe_sets);
    if (lightmap->probe_sets == NULL) {
        return air_fail_memory(root->context, root->file);
    }
    lightmap->probe_set_count = air_place_count(&sets);
    for (size_t i = 0; i < lightmap->probe_set_count && status == AIR_OK; i++) {
        const air_place at = air_place_at(&sets, i);
        status = set_from_json(&at, &lightmap->probe_sets[i]);
    }
    return status;
}

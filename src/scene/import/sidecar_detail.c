#include "core/vec.h"
#include "scene/import/import.h"

static air_status read_strength(const air_json *detail, air_detail *out)
{
    const air_json at = air_json_get(detail, "strength");
    air_status status = air_json_require(&at, "a strength of at least 0 and below 1");
    if (status == AIR_OK)
        status = air_json_float(&at, AIR_JSON_NON_NEGATIVE, &out->strength);
    if (status == AIR_OK && !(out->strength < 1.0f))
        status = air_json_expected(&at, "a number of at least 0 and below 1");
    return status;
}

static air_status read_octaves(const air_json *detail, air_detail *out)
{
    const air_json at = air_json_get(detail, "octaves");
    size_t octaves = out->octaves;
    const air_status status = air_json_size(&at, &octaves);
    if (status != AIR_OK)
        return status;
    if (octaves < 1 || octaves > AIR_MAX_OCTAVES)
        return air_json_expected(&at, "a whole number from 1 to %d", (int)AIR_MAX_OCTAVES);
    out->octaves = (uint32_t)octaves;
    return AIR_OK;
}

static air_status read_seed(const air_json *detail, air_detail *out)
{
    const air_json at = air_json_get(detail, "seed");
    size_t seed = out->seed;
    const air_status status = air_json_size(&at, &seed);
    if (status == AIR_OK && seed > UINT32_MAX)
        return air_json_expected(&at, "a whole number below 2^32");
    out->seed = (uint32_t)seed;
    return status;
}

air_status air_sidecar_read_detail(const air_sidecar_part *part, air_medium_desc *desc)
{
    static const char *const keys[] = {"strength", "scale", "octaves", "seed", "to_world"};
    const air_json at = air_json_get(part->at, "detail");
    const air_json scale_at = air_json_get(&at, "scale");
    const air_json map_at = air_json_get(&at, "to_world");
    float local[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    air_detail *detail = &desc->density.detail;
    if (at.value == NULL)
        return AIR_OK;
    air_status status = air_json_check_object(&at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(&at, keys, sizeof keys / sizeof keys[0]);
    if (status == AIR_OK)
        status = read_strength(&at, detail);
    if (status == AIR_OK)
        status = air_json_require(&scale_at, "the size of the largest features in metres");
    if (status == AIR_OK)
        status = air_json_float(&scale_at, AIR_JSON_POSITIVE, &detail->scale);
    if (status == AIR_OK)
        status = read_octaves(&at, detail);
    if (status == AIR_OK)
        status = read_seed(&at, detail);
    if (status == AIR_OK && map_at.value != NULL)
        status = air_sidecar_read_map(&map_at, local);
    if (status != AIR_OK)
        return status;
    if (detail->strength > 0.0f && desc->boundary.kind == AIR_BOUNDARY_UNBOUNDED &&
        desc->density.kind != AIR_DENSITY_GRID)
        return air_json_fail(&at, AIR_ERROR_FORMAT,
                             "expected a boundary or a grid beside it: only media with an end "
                             "have detail");
    affine_multiply(part->to_world, local, detail->to_world);
    return AIR_OK;
}

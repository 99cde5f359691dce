/* gltf_volume.c: glass: KHR_materials_transmission and KHR_materials_volume. */
#include <math.h>

#include "scene/import/gltf.h"
#include "scene/media/boundary_topology.h"

/* Of the media a scene can hold, the others are left to sidecars. */
enum { MOST_VOLUMES = AIR_MAX_MEDIA / 2 };

/* Light of a colour that is 0 is let through by a millionth, which no picture shows. */
#define LEAST_COLOR 1e-6

/* [KHR_materials_volume]: after attenuationDistance white light has attenuationColor. */
static air_status read_attenuation(const air_json *at, air_gltf_volume *volume)
{
    const air_json distance_at = air_json_get(at, "attenuationDistance");
    const air_json color_at = air_json_get(at, "attenuationColor");
    float distance = INFINITY, color[3] = {1.0f, 1.0f, 1.0f};
    air_status status = air_json_float(&distance_at, AIR_JSON_POSITIVE, &distance);
    if (status == AIR_OK)
        status = air_json_floats(&color_at, AIR_JSON_UNIT, 3, color);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; i < 3; ++i) {
        const double depth = log(1.0 / fmax((double)color[i], LEAST_COLOR));
        volume->sigma_a[i] = (float)(depth / (double)distance);
        volume->absorbs = volume->absorbs || volume->sigma_a[i] > 0.0f;
    }
    return AIR_OK;
}

air_status air_gltf_read_transmission(air_gltf *gltf, const air_json *extensions,
                                      air_material_desc *desc, air_gltf_volume *volume)
{
    const air_json transmission = air_json_get(extensions, "KHR_materials_transmission");
    const air_json factor_at = air_json_get(&transmission, "transmissionFactor");
    const air_json texture = air_json_get(&transmission, "transmissionTexture");
    const air_json inside = air_json_get(extensions, "KHR_materials_volume");
    const air_json thickness_at = air_json_get(&inside, "thicknessFactor");
    float thickness = 0.0f;
    air_status status = air_json_check_object(&transmission, false);
    if (status == AIR_OK)
        status = air_json_float(&factor_at, AIR_JSON_UNIT, &desc->transmission);
    if (status == AIR_OK && desc->transmission > 0.0f)
        status = air_gltf_read_texture(gltf, &texture, false, &desc->transmission_texture);
    if (status == AIR_OK)
        status = air_json_check_object(&inside, false);
    if (status == AIR_OK)
        status = air_json_float(&thickness_at, AIR_JSON_NON_NEGATIVE, &thickness);
    desc->thin_walled = !(thickness > 0.0f);
    if (status == AIR_OK && desc->transmission > 0.0f && !desc->thin_walled)
        status = read_attenuation(&inside, volume);
    return status;
}

air_status air_gltf_add_volume(air_gltf *gltf, const char *name, const air_gltf_volume *volume,
                               const air_boundary *boundary)
{
    bool closed = boundary->kind == AIR_BOUNDARY_ELLIPSOID;
    air_medium_desc medium;
    air_handle handle;
    air_status status = AIR_OK;
    if (boundary->kind == AIR_BOUNDARY_MESH)
        status = air_topology_is_closed(gltf->context, boundary->positions, boundary->vertex_count,
                                        boundary->indices, boundary->triangle_count, &closed);
    if (status != AIR_OK || !closed) {
        gltf->tally.open_volumes += status == AIR_OK;
        return status;
    }
    if (gltf->tally.volumes == MOST_VOLUMES) {
        gltf->tally.crowded_volumes++;
        return AIR_OK;
    }
    gltf->tally.volumes++;
    air_medium_desc_default(&medium);
    medium.name = name;
    for (size_t i = 0; i < 3; ++i)
        medium.sigma_a[i] = volume->sigma_a[i];
    medium.boundary = *boundary;
    medium.combine = AIR_COMBINE_REPLACE; /* no fog inside glass */
    return air_scene_add_medium(gltf->import->scene, &medium, &handle);
}

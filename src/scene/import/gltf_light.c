#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/gltf.h"

static const float half_turn_quarter = 1.57079632679489662f; /* pi/2 rounded to float */

/* [KHR_lights_punctual]: innerConeAngle < outerConeAngle <= pi/2. */
static air_status read_cone(const air_json *light, air_light_desc *desc)
{
    const air_json spot = air_json_get(light, "spot");
    const air_json inner_at = air_json_get(&spot, "innerConeAngle");
    const air_json outer_at = air_json_get(&spot, "outerConeAngle");
    air_status status = air_json_check_object(&spot, false);
    if (status == AIR_OK)
        status = air_json_float(&inner_at, AIR_JSON_NON_NEGATIVE, &desc->inner_cone_rad);
    if (status == AIR_OK)
        status = air_json_float(&outer_at, AIR_JSON_POSITIVE, &desc->outer_cone_rad);
    if (status != AIR_OK)
        return status;
    if (desc->outer_cone_rad > half_turn_quarter + 1e-4f)
        return air_json_expected(&outer_at, "an angle of at most pi/2");
    desc->outer_cone_rad = fminf(desc->outer_cone_rad, half_turn_quarter);
    if (desc->inner_cone_rad > desc->outer_cone_rad)
        return air_json_expected(&inner_at, "an angle below the outer one");
    /* Equal angles mean a hard edge; exporters write them, the falloff divides by their distance.
     */
    desc->inner_cone_rad = fminf(desc->inner_cone_rad, 0.999f * desc->outer_cone_rad);
    return AIR_OK;
}

air_status air_gltf_add_light(air_gltf *gltf, const air_import_object *object)
{
    static const char *const types[] = {"directional", "point", "spot"};
    static const air_light_kind kinds[] = {AIR_LIGHT_COLLIMATED, AIR_LIGHT_POINT, AIR_LIGHT_SPOT};
    const air_json at = air_json_at(&gltf->lights, object->light);
    const air_json type_at = air_json_get(&at, "type");
    const air_json color_at = air_json_get(&at, "color");
    const air_json intensity_at = air_json_get(&at, "intensity");
    const air_json range_at = air_json_get(&at, "range");
    air_light_desc desc;
    air_light_desc_default(&desc);
    float color[3] = {1.0f, 1.0f, 1.0f}, intensity = 1.0f;
    size_t type = 0;
    air_handle handle = AIR_NONE;
    air_status status = air_json_check_object(&at, true);
    if (status == AIR_OK)
        status = air_json_require(&type_at, "a light type");
    if (status == AIR_OK)
        status = air_json_choice(&type_at, types, 3, &type);
    if (status == AIR_OK)
        status = air_json_floats(&color_at, AIR_JSON_NON_NEGATIVE, 3, color);
    if (status == AIR_OK)
        status = air_json_float(&intensity_at, AIR_JSON_NON_NEGATIVE, &intensity);
    if (status == AIR_OK && kinds[type] == AIR_LIGHT_SPOT)
        status = read_cone(&at, &desc);
    if (status != AIR_OK)
        return status;
    gltf->tally.ranges += range_at.value != NULL;
    const air_vec3 forward = affine_vector(object->to_world, vec3(0.0f, 0.0f, -1.0f));
    desc.name = air_gltf_name(object);
    desc.kind = kinds[type];
    desc.casts_shadow = object->casts_shadow;
    vec3_store(desc.position, affine_point(object->to_world, vec3_set1(0.0f)));
    if (!vec3_is_zero(forward))
        vec3_store(desc.dir, vec3_unit(forward));
    else if (desc.kind != AIR_LIGHT_POINT)
        return air_json_fail(&at, AIR_ERROR_FORMAT,
                             "the light \"%s\" has no direction: its node is scaled to nothing",
                             desc.name);
    for (size_t i = 0; i < 3; ++i)
        desc.color[i] = color[i] * intensity * gltf->light_scale;
    status = air_scene_add_light(gltf->import->scene, &desc, &handle);
    return status == AIR_OK ? AIR_OK : air_json_place_error(&at, status);
}

static air_status read_perspective(const air_json *at, air_camera_desc *desc)
{
    const air_json fov_at = air_json_get(at, "yfov");
    const air_json aspect_at = air_json_get(at, "aspectRatio");
    desc->kind = AIR_CAMERA_PERSPECTIVE;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_require(&fov_at, "an angle");
    if (status == AIR_OK)
        status = air_json_float(&fov_at, AIR_JSON_POSITIVE, &desc->fov_y_rad);
    if (status == AIR_OK && desc->fov_y_rad >= AIR_PI_F)
        status = air_json_expected(&fov_at, "an angle below pi");
    if (status == AIR_OK)
        status = air_json_float(&aspect_at, AIR_JSON_POSITIVE, &desc->aspect);
    return status;
}

static air_status read_orthographic(const air_json *at, air_camera_desc *desc)
{
    const air_json width_at = air_json_get(at, "xmag");
    const air_json height_at = air_json_get(at, "ymag");
    float half_width = 1.0f;
    desc->kind = AIR_CAMERA_ORTHOGRAPHIC;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_require(&width_at, "half the width");
    if (status == AIR_OK)
        status = air_json_float(&width_at, AIR_JSON_POSITIVE, &half_width);
    if (status == AIR_OK)
        status = air_json_require(&height_at, "half the height");
    if (status == AIR_OK)
        status = air_json_float(&height_at, AIR_JSON_POSITIVE, &desc->half_height);
    if (status == AIR_OK)
        desc->aspect = half_width / desc->half_height;
    return status;
}

air_status air_gltf_add_camera(air_gltf *gltf, const air_import_object *object)
{
    static const char *const types[] = {"perspective", "orthographic"};
    const air_json at = air_json_at(&gltf->cameras, object->camera);
    const air_json type_at = air_json_get(&at, "type");
    size_t type = 0;
    air_handle handle = AIR_NONE;
    air_camera_desc desc = object->camera_rest;
    air_status status = air_json_check_object(&at, true);
    if (status == AIR_OK)
        status = air_json_require(&type_at, "a camera type");
    if (status == AIR_OK)
        status = air_json_choice(&type_at, types, 2, &type);
    if (status != AIR_OK)
        return status;
    const air_json part = air_json_get(&at, types[type]);
    status = type == 0 ? read_perspective(&part, &desc) : read_orthographic(&part, &desc);
    if (status != AIR_OK)
        return status;
    desc.name = air_gltf_name(object);
    memcpy(desc.to_world, object->to_world, sizeof desc.to_world);
    status = air_scene_add_camera(gltf->import->scene, &desc, &handle);
    return status == AIR_OK ? AIR_OK : air_json_place_error(&at, status);
}

#include <math.h>

#include "core/vec.h"
#include "scene/import/import.h"

/* The map of a camera at `position` that looks along `forward` (unit): its -Z. */
static void set_view(air_vec3 position, air_vec3 forward, air_vec3 right, float out[12])
{
    const air_vec3 up = vec3_cross(right, forward);
    const air_vec3 columns[4] = {right, up, vec3_neg(forward), position};
    for (size_t i = 0; i < 4; ++i) {
        out[i] = columns[i].x;
        out[4 + i] = columns[i].y;
        out[8 + i] = columns[i].z;
    }
}

static air_status read_view(const air_json *at, float out[12], float *out_distance)
{
    const air_json position_at = air_json_get(at, "position");
    const air_json target_at = air_json_get(at, "look_at");
    const air_json up_at = air_json_get(at, "up");
    float position[3] = {0.0f, 0.0f, 0.0f}, target[3] = {0.0f, 0.0f, 0.0f},
          up[3] = {0.0f, 1.0f, 0.0f};
    air_status status = air_json_require(&position_at, "a point");
    if (status == AIR_OK)
        status = air_json_floats(&position_at, AIR_JSON_ANY, 3, position);
    if (status == AIR_OK)
        status = air_json_require(&target_at, "a point");
    if (status == AIR_OK)
        status = air_json_floats(&target_at, AIR_JSON_ANY, 3, target);
    if (status == AIR_OK && up_at.value != NULL)
        status = air_sidecar_read_direction(&up_at, up);
    if (status != AIR_OK)
        return status;
    const air_vec3 way = vec3_sub(vec3_load(target), vec3_load(position));
    const float distance = vec3_length(way);
    if (!(distance > 0.0f) || !isfinite(distance))
        return air_json_expected(&target_at, "a point apart from the position");
    const air_vec3 forward = vec3_scale(way, 1.0f / distance);
    air_vec3 right = vec3_cross(forward, vec3_load(up));
    if (vec3_length(right) < 1e-4f && up_at.value != NULL)
        return air_json_expected(&up_at, "a direction that is not that of the view");
    if (vec3_length(right) < 1e-4f) /* straight down or up: north is -Z, as on a map */
        right = vec3_cross(forward, vec3(0.0f, 0.0f, -1.0f));
    set_view(vec3_load(position), forward, vec3_normalize(right), out);
    *out_distance = distance;
    return AIR_OK;
}

air_status air_sidecar_read_camera(const air_json *at, air_camera_desc *desc)
{
    const air_json radius_at = air_json_get(at, "lens_radius");
    const air_json focus_at = air_json_get(at, "focus_distance");
    const air_json near_at = air_json_get(at, "near_distance");
    const air_json mirrored_at = air_json_get(at, "mirrored");
    air_status status = air_json_float(&radius_at, AIR_JSON_NON_NEGATIVE, &desc->lens_radius);
    if (status == AIR_OK)
        status = air_json_float(&focus_at, AIR_JSON_POSITIVE, &desc->focus_distance);
    if (status == AIR_OK)
        status = air_json_float(&near_at, AIR_JSON_NON_NEGATIVE, &desc->near_distance);
    return status == AIR_OK ? air_json_bool(&mirrored_at, &desc->mirrored) : status;
}

/* In focus is what lies as far as look_at, unless said otherwise. */
static air_status read_rest(const air_json *at, air_camera_desc *desc)
{
    const air_json radius_at = air_json_get(at, "lens_radius");
    const air_json focus_at = air_json_get(at, "focus_distance");
    if (desc->kind != AIR_CAMERA_PERSPECTIVE && (radius_at.value != NULL || focus_at.value != NULL))
        return air_json_fail(radius_at.value != NULL ? &radius_at : &focus_at, AIR_ERROR_FORMAT,
                             "expected fov_y_degrees with it: a lens is perspective");
    return air_sidecar_read_camera(at, desc);
}

static air_status read_lens(const air_json *at, air_camera_desc *desc)
{
    const air_json fov_at = air_json_get(at, "fov_y_degrees");
    const air_json height_at = air_json_get(at, "half_height");
    const air_json aspect_at = air_json_get(at, "aspect");
    double fov = 0.0;
    if ((fov_at.value != NULL) == (height_at.value != NULL))
        return air_json_fail(
            at, AIR_ERROR_FORMAT,
            "expected either fov_y_degrees (perspective) or half_height (orthographic)");
    air_status status = air_json_number(&fov_at, AIR_JSON_POSITIVE, &fov);
    if (status == AIR_OK && fov >= 179.9)
        status = air_json_expected(&fov_at, "an angle below 179.9 degrees");
    if (status == AIR_OK)
        status = air_json_float(&height_at, AIR_JSON_POSITIVE, &desc->half_height);
    if (status == AIR_OK)
        status = air_json_float(&aspect_at, AIR_JSON_POSITIVE, &desc->aspect);
    if (status != AIR_OK)
        return status;
    desc->kind = fov_at.value != NULL ? AIR_CAMERA_PERSPECTIVE : AIR_CAMERA_ORTHOGRAPHIC;
    if (fov_at.value != NULL)
        desc->fov_y_rad = (float)(fov * AIR_PI / 180.0);
    return read_rest(at, desc);
}

air_status air_sidecar_add_camera(const air_sidecar_part *part)
{
    static const char *const keys[] = {
        "name",   "position",    "look_at",        "up",       "fov_y_degrees", "half_height",
        "aspect", "lens_radius", "focus_distance", "mirrored", "near_distance"};
    const air_json name_at = air_json_get(part->at, "name");
    air_camera_desc desc;
    air_camera_desc_default(&desc);
    desc.name = part->fallback_name;
    float local[12];
    air_handle handle = AIR_NONE;
    air_status status = air_json_check_object(part->at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(part->at, keys, sizeof keys / sizeof keys[0]);
    if (status == AIR_OK)
        status = air_json_string(&name_at, &desc.name);
    if (status == AIR_OK)
        status = read_view(part->at, local, &desc.focus_distance);
    if (status == AIR_OK)
        status = read_lens(part->at, &desc);
    if (status != AIR_OK)
        return status;
    affine_multiply(part->to_world, local, desc.to_world);
    status = air_scene_add_camera(part->import->scene, &desc, &handle);
    return status == AIR_OK ? AIR_OK : air_json_place_error(part->at, status);
}

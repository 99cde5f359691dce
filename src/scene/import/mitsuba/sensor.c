#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/number.h"

/* The picture's two angles from one of them, or from a focal length: [Mitsuba3], perspective. */
enum { FOV_X, FOV_Y, FOV_DIAGONAL, FOV_SMALLER, FOV_LARGER };

/* "50mm" of film 36 mm by 24 mm: its diagonal. */
static air_status read_focal_length(const air_mitsuba *mitsuba, const air_xml *at, double *tangent)
{
    const char *text = "50mm";
    double millimetres = 0.0;
    const air_status status = air_mitsuba_string(mitsuba, at, "focal_length", &text);
    if (status != AIR_OK)
        return status;
    size_t length = strlen(text);
    if (length > 2 && strcmp(text + length - 2, "mm") == 0)
        length -= 2;
    if (!air_number_parse(text, length, &millimetres) || !(millimetres > 0.0))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected focal_length as in 50mm, found \"%.40s\"", text);
    *tangent = sqrt(36.0 * 36.0 + 24.0 * 24.0) / (2.0 * millimetres);
    return AIR_OK;
}

air_status air_mitsuba_read_fov(const air_mitsuba *mitsuba, const air_xml *at, double aspect,
                                double *out_tangent)
{
    static const char *const axes[] = {"x", "y", "diagonal", "smaller", "larger"};
    size_t axis = FOV_X;
    float fov = 0.0f;
    double tangent = 0.0;
    air_status status = air_mitsuba_choice(mitsuba, at, "fov_axis", axes, 5, &axis);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "fov", &fov);
    if (status == AIR_OK && !air_mitsuba_has(at, "fov")) {
        axis = FOV_DIAGONAL;
        status = read_focal_length(mitsuba, at, &tangent);
    } else if (status == AIR_OK && !(fov > 0.0f && fov < 180.0f)) {
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected fov to be above 0 and below 180 degrees, found %g",
                                  (double)fov);
    } else {
        tangent = tan(0.5 * (double)fov * (AIR_PI / 180.0));
    }
    if (axis == FOV_SMALLER)
        axis = aspect > 1.0 ? FOV_Y : FOV_X;
    if (axis == FOV_LARGER)
        axis = aspect > 1.0 ? FOV_X : FOV_Y;
    if (axis == FOV_X)
        tangent /= aspect;
    if (axis == FOV_DIAGONAL)
        tangent /= sqrt(1.0 + aspect * aspect);
    *out_tangent = tangent;
    return status;
}

/* Mitsuba's sensors look along +Z with +X to the left. */
static void turn_about_y(float map[12])
{
    for (size_t row = 0; row < 3; ++row) {
        map[4 * row] = -map[4 * row];
        map[4 * row + 2] = -map[4 * row + 2];
    }
}

/* An orthographic sensor sees x from -1 to 1 in its own space, and y to go with it. */
static void set_orthographic(double aspect, air_camera_desc *desc)
{
    const float *m = desc->to_world;
    const float half_width = vec3_length(vec3(m[0], m[4], m[8]));
    desc->kind = AIR_CAMERA_ORTHOGRAPHIC;
    desc->half_height = (float)((double)half_width / aspect);
}

static air_status read_lens(const air_mitsuba *mitsuba, const air_xml *at, air_camera_desc *desc)
{
    if (!air_mitsuba_has(at, "aperture_radius"))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected the parameter aperture_radius");
    float far = 1e4f;
    air_status status = air_mitsuba_float(mitsuba, at, "aperture_radius", &desc->lens_radius);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "far_clip", &far);
    desc->focus_distance = far;
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "focus_distance", &desc->focus_distance);
    if (status == AIR_OK && !(desc->focus_distance > 0.0f && desc->lens_radius >= 0.0f))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected an aperture_radius that is not below 0 and a "
                                  "focus_distance above 0");
    return status;
}

air_status air_mitsuba_add_sensor(air_mitsuba *mitsuba, air_xml *at, const char *name)
{
    static const char *const types[] = {"perspective", "thinlens", "orthographic"};
    static const char *const ignored[] = {"far_clip", "focus_distance", "shutter_open",
                                          "shutter_close", "srf"};
    air_camera_desc desc;
    air_handle handle = AIR_NONE;
    air_xml *medium = NULL;
    air_camera_desc_default(&desc);
    desc.name = name;
    at->asked = true;
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = AIR_OK;
    if (!air_mitsuba_is(at, types[0]) && !air_mitsuba_is(at, types[1]) &&
        !air_mitsuba_is(at, types[2]))
        status = air_mitsuba_unknown_type(mitsuba, at, types, 3, "a perspective sensor is taken");
    if (status == AIR_OK)
        status = air_mitsuba_read_film(mitsuba, at, &desc.film);
    if (status == AIR_OK)
        status = air_mitsuba_transform(mitsuba, at, "to_world", desc.to_world);
    if (status == AIR_OK) /* it is noted with the media */
        status = air_mitsuba_child(mitsuba, at, "medium", NULL, &medium);
    if (status != AIR_OK)
        return status;
    const double aspect = (double)desc.film.width / (double)desc.film.height;
    double tangent = 0.0;
    desc.aspect = (float)aspect;
    desc.near_distance = 1e-2f;
    status = air_mitsuba_float(mitsuba, at, "near_clip", &desc.near_distance);
    desc.mirrored = affine_determinant(desc.to_world) < 0.0;
    if (air_mitsuba_is(at, "orthographic"))
        set_orthographic(aspect, &desc);
    else if (status == AIR_OK)
        status = air_mitsuba_read_fov(mitsuba, at, aspect, &tangent);
    if (desc.kind == AIR_CAMERA_PERSPECTIVE)
        desc.fov_y_rad = (float)(2.0 * atan(tangent));
    if (status == AIR_OK && air_mitsuba_is(at, "thinlens"))
        status = read_lens(mitsuba, at, &desc);
    turn_about_y(desc.to_world);
    if (status == AIR_OK) {
        status = air_scene_add_camera(mitsuba->import->scene, &desc, &handle);
        if (status != AIR_OK)
            status = air_xml_place_error(&mitsuba->document, at, status);
    }
    return status;
}

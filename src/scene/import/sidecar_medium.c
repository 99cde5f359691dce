#include <float.h>
#include <math.h>
#include <string.h>

#include "scene/import/import.h"
#include "scene/media/media_build.h"

/* Share of the extinction that is scattering where only an extinction or a visibility is given:
 * water fog absorbs next to nothing, haze and smoke more. */
static const float default_albedo = 0.99f;

/* sigma_t = -ln(0.02) / visibility: the distance at which 2 % of an object's contrast is left
 * [Koschmieder1924]. */
static const double koschmieder = 3.912023005428146;

/* sigma_t and albedo into sigma_s and sigma_a. */
static air_status read_extinction(const air_json *at, const air_json *sigma_t_at,
                                  const air_json *visibility_at, air_medium_desc *desc)
{
    const air_json albedo_at = air_json_get(at, "albedo");
    float sigma_t[3] = {0.0f, 0.0f, 0.0f};
    float albedo[3] = {default_albedo, default_albedo, default_albedo};
    double visibility = 1.0;
    air_status status = air_json_color(sigma_t_at, AIR_JSON_NON_NEGATIVE, sigma_t);
    if (status == AIR_OK)
        status = air_json_number(visibility_at, AIR_JSON_POSITIVE, &visibility);
    if (status == AIR_OK)
        status = air_json_color(&albedo_at, AIR_JSON_UNIT, albedo);
    if (status != AIR_OK)
        return status;
    if (visibility_at->value != NULL && koschmieder / visibility > 1e30)
        return air_json_expected(visibility_at, "a distance in metres");
    for (size_t i = 0; i < 3; ++i) {
        if (visibility_at->value != NULL)
            sigma_t[i] = (float)(koschmieder / visibility);
        desc->sigma_s[i] = sigma_t[i] * albedo[i];
        desc->sigma_a[i] = sigma_t[i] - desc->sigma_s[i];
    }
    return AIR_OK;
}

static air_status read_coefficients(const air_json *at, air_medium_desc *desc)
{
    const air_json sigma_s = air_json_get(at, "sigma_s");
    const air_json sigma_a = air_json_get(at, "sigma_a");
    const air_json sigma_t = air_json_get(at, "sigma_t");
    const air_json visibility = air_json_get(at, "visibility");
    const air_json albedo = air_json_get(at, "albedo");
    const air_json emission = air_json_get(at, "emission");
    air_status status = air_json_color(&emission, AIR_JSON_NON_NEGATIVE, desc->emission);
    if (status != AIR_OK)
        return status;
    const bool apart = sigma_s.value != NULL || sigma_a.value != NULL;
    if (sigma_t.value != NULL && (apart || visibility.value != NULL))
        return air_json_fail(
            &sigma_t, AIR_ERROR_FORMAT,
            "expected one of sigma_t, visibility, and sigma_s with sigma_a, found several");
    if (visibility.value != NULL && apart)
        return air_json_fail(
            &visibility, AIR_ERROR_FORMAT,
            "expected one of sigma_t, visibility, and sigma_s with sigma_a, found several");
    if (sigma_t.value != NULL || visibility.value != NULL)
        return read_extinction(at, &sigma_t, &visibility, desc);
    if (albedo.value != NULL)
        return air_json_fail(&albedo, AIR_ERROR_FORMAT,
                             "expected sigma_t or visibility beside the albedo");
    if (!apart && emission.value == NULL)
        return air_json_fail(at, AIR_ERROR_FORMAT,
                             "expected sigma_s and sigma_a, or sigma_t, or visibility");
    status = air_json_color(&sigma_s, AIR_JSON_NON_NEGATIVE, desc->sigma_s);
    return status == AIR_OK ? air_json_color(&sigma_a, AIR_JSON_NON_NEGATIVE, desc->sigma_a)
                            : status;
}

static air_status read_combine(const air_json *at, air_medium_desc *desc)
{
    static const char *const modes[] = {"add", "replace"};
    const air_json combine_at = air_json_get(at, "combine");
    const air_json priority_at = air_json_get(at, "priority");
    size_t mode = AIR_COMBINE_ADD;
    double priority = 0.0;
    air_status status = air_json_choice(&combine_at, modes, 2, &mode);
    if (status == AIR_OK)
        status = air_json_number(&priority_at, AIR_JSON_ANY, &priority);
    if (status == AIR_OK && (floor(priority) != priority || fabs(priority) > 1e9))
        status = air_json_expected(&priority_at, "a whole number");
    if (status != AIR_OK)
        return status;
    desc->combine = (air_combine)mode;
    desc->priority = (int32_t)priority;
    return AIR_OK;
}

static air_status check_medium_keys(const air_json *at)
{
    static const char *const keys[] = {
        "name",          "sigma_s", "sigma_a",  "sigma_t",          "albedo",  "visibility",
        "emission",      "phase",   "g",        "boundary",         "density", "albedo_grid",
        "emission_grid", "combine", "priority", "boundary_visible", "detail"};
    const air_status status = air_json_check_object(at, true);
    return status == AIR_OK ? air_json_check_keys(at, keys, sizeof keys / sizeof keys[0]) : status;
}

/* The scene's own check, with a name that also says where the medium was described. */
static air_status check_with_place(const air_sidecar_part *part, const air_medium_desc *desc)
{
    air_medium_desc annotated = *desc;
    char *name = air_json_annotate(part->at, desc->name);
    if (name == NULL)
        return AIR_ERROR_MEMORY;
    annotated.name = name;
    const air_status status = air_medium_check(part->import->context, &annotated);
    air_free(part->import->context, name);
    return status;
}

air_status air_sidecar_add_medium(const air_sidecar_part *part)
{
    const air_json name_at = air_json_get(part->at, "name");
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.name = part->fallback_name;
    air_phase_mixture mixture;
    float *planes = NULL;
    air_import_geometry geometry = {0};
    air_handle handle = AIR_NONE;
    air_status status = check_medium_keys(part->at);
    if (status == AIR_OK)
        status = air_json_string(&name_at, &desc.name);
    if (status == AIR_OK)
        status = read_coefficients(part->at, &desc);
    if (status == AIR_OK)
        status = air_sidecar_read_phase(part, &desc, &mixture);
    if (status == AIR_OK)
        status = read_combine(part->at, &desc);
    if (status == AIR_OK)
        status = air_sidecar_read_density(part, &desc);
    if (status == AIR_OK)
        status = air_sidecar_read_boundary(part, &desc, &planes, &geometry);
    if (status == AIR_OK)
        status = air_sidecar_read_detail(part, &desc);
    if (status == AIR_OK)
        status = check_with_place(part, &desc);
    if (status == AIR_OK)
        status = air_scene_add_medium(part->import->scene, &desc, &handle);
    air_import_geometry_finish(part->import->context, &geometry);
    air_free(part->import->context, planes);
    return status;
}

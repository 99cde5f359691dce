/* gltf_model.c: the airlight object of a material: what glTF cannot say of it. */
#include <string.h>

#include "scene/import/gltf.h"
#include "scene/material.h"

static air_json object_of(const air_json *extras) { return air_json_get(extras, "airlight"); }

/* alpha: one width of slopes, or two, along and across. */
static air_status read_facets(const air_json *object, air_material_desc *desc)
{
    static const char *const kinds[] = {"ggx", "beckmann"};
    const air_json kind_at = air_json_get(object, "microfacets");
    const air_json alpha_at = air_json_get(object, "alpha");
    size_t kind = AIR_MICROFACETS_GGX;
    float alpha[2] = {desc->alpha_u, desc->alpha_v};
    air_status status = air_json_choice(&kind_at, kinds, 2, &kind);
    desc->microfacets = (air_microfacets)kind;
    if (status == AIR_OK)
        status = air_json_floats(&alpha_at, AIR_JSON_NON_NEGATIVE, 2, alpha);
    desc->alpha_u = alpha[0];
    desc->alpha_v = alpha[1];
    return status;
}

static air_status read_interface(const air_json *object, air_material_desc *desc)
{
    const air_json ior = air_json_get(object, "ior");
    const air_json reflectance = air_json_get(object, "reflectance");
    const air_json transmittance = air_json_get(object, "transmittance");
    const air_json eta = air_json_get(object, "eta");
    const air_json absorption = air_json_get(object, "absorption");
    const air_json nonlinear = air_json_get(object, "nonlinear");
    air_status status = air_json_float(&ior, AIR_JSON_POSITIVE, &desc->ior);
    if (status == AIR_OK)
        status = air_json_color(&reflectance, AIR_JSON_UNIT, desc->reflectance);
    if (status == AIR_OK)
        status = air_json_color(&transmittance, AIR_JSON_UNIT, desc->transmittance);
    if (status == AIR_OK)
        status = air_json_color(&eta, AIR_JSON_NON_NEGATIVE, desc->eta);
    if (status == AIR_OK)
        status = air_json_color(&absorption, AIR_JSON_NON_NEGATIVE, desc->absorption);
    return status == AIR_OK ? air_json_bool(&nonlinear, &desc->nonlinear) : status;
}

/* A part of a blend, which is none itself: so the materials of a file cannot go in circles. */
static air_status read_part(air_gltf *gltf, const air_json *at, air_handle *out)
{
    size_t index = 0;
    const air_status status =
        air_json_index(at, air_json_count(&gltf->materials), "a material", &index);
    if (status != AIR_OK)
        return status;
    const air_json material = air_json_at(&gltf->materials, index);
    const air_json extras = air_json_get(&material, "extras");
    const air_json object = object_of(&extras), model = air_json_get(&object, "model");
    const char *name = json_string_value(model.value);
    if (name != NULL && strcmp(name, air_material_model_names[AIR_MATERIAL_BLEND]) == 0)
        return air_json_expected(at, "a material that is no blend");
    return air_gltf_material(gltf, index, out);
}

static air_status read_blend(air_gltf *gltf, const air_json *object, air_material_desc *desc)
{
    const air_json parts = air_json_get(object, "blend");
    const air_json weight = air_json_get(object, "weight");
    const air_json texture = air_json_get(object, "weight_texture");
    if (desc->model != AIR_MATERIAL_BLEND)
        return AIR_OK;
    if (air_json_count(&parts) != 2)
        return air_json_expected(&parts, "an array of two materials");
    const air_json first = air_json_at(&parts, 0), second = air_json_at(&parts, 1);
    air_status status = read_part(gltf, &first, &desc->blend[0]);
    if (status == AIR_OK)
        status = read_part(gltf, &second, &desc->blend[1]);
    if (status == AIR_OK)
        status = air_json_float(&weight, AIR_JSON_UNIT, &desc->blend_weight);
    return status == AIR_OK ? air_gltf_read_texture(gltf, &texture, false, &desc->blend_texture)
                            : status;
}

static air_status read_bump(air_gltf *gltf, const air_json *object, air_material_desc *desc)
{
    const air_json texture = air_json_get(object, "bump_texture");
    const air_json scale = air_json_get(object, "bump_scale");
    const air_status status = air_gltf_read_texture(gltf, &texture, false, &desc->bump_texture);
    return status == AIR_OK ? air_json_float(&scale, AIR_JSON_ANY, &desc->bump_scale) : status;
}

air_status air_gltf_read_model(air_gltf *gltf, const air_json *material, air_material_desc *desc)
{
    static const char *const keys[] = {
        "model",          "one_sided",    "microfacets", "alpha",     "ior",   "reflectance",
        "transmittance",  "eta",          "absorption",  "nonlinear", "blend", "weight",
        "weight_texture", "bump_texture", "bump_scale"};
    const air_json extras = air_json_get(material, "extras");
    const air_json object = object_of(&extras);
    const air_json model_at = air_json_get(&object, "model");
    const air_json one_sided = air_json_get(&object, "one_sided");
    size_t model = AIR_MATERIAL_METALLIC_ROUGHNESS;
    if (object.value == NULL)
        return AIR_OK;
    air_status status = air_json_check_object(&object, true);
    if (status == AIR_OK)
        status = air_json_check_keys(&object, keys, sizeof keys / sizeof keys[0]);
    if (status == AIR_OK)
        status = air_json_choice(&model_at, air_material_model_names, AIR_MATERIAL_MODELS, &model);
    desc->model = (air_material_model)model;
    if (desc->model != AIR_MATERIAL_METALLIC_ROUGHNESS)
        desc->transmission = 0.0f; /* said for those who do not know the model */
    if (status == AIR_OK)
        status = air_json_bool(&one_sided, &desc->one_sided);
    if (status == AIR_OK)
        status = read_facets(&object, desc);
    if (status == AIR_OK)
        status = read_interface(&object, desc);
    if (status == AIR_OK)
        status = read_blend(gltf, &object, desc);
    return status == AIR_OK ? read_bump(gltf, &object, desc) : status;
}

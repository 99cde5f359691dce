#include <math.h>
#include <string.h>

#include "scene/import/gltf.h"

static air_status read_metallic_roughness(air_gltf *gltf, const air_json *at,
                                          air_material_desc *desc)
{
    const air_json color = air_json_get(at, "baseColorFactor");
    const air_json metallic = air_json_get(at, "metallicFactor");
    const air_json roughness = air_json_get(at, "roughnessFactor");
    const air_json color_texture = air_json_get(at, "baseColorTexture");
    const air_json texture = air_json_get(at, "metallicRoughnessTexture");
    air_status status = air_json_check_object(at, false);
    if (status == AIR_OK)
        status = air_json_floats(&color, AIR_JSON_UNIT, 4, desc->base_color);
    if (status == AIR_OK)
        status = air_json_float(&metallic, AIR_JSON_UNIT, &desc->metallic);
    if (status == AIR_OK)
        status = air_json_float(&roughness, AIR_JSON_UNIT, &desc->roughness);
    if (status == AIR_OK)
        status = air_gltf_read_texture(gltf, &color_texture, true, &desc->base_color_texture);
    if (status == AIR_OK)
        status = air_gltf_read_texture(gltf, &texture, false, &desc->metallic_roughness_texture);
    return status;
}

/* Perceived brightness, as KHR_materials_pbrSpecularGlossiness' conversion to metal and roughness
 * defines it. */
static double brightness(const float rgb[3])
{
    const double r = (double)rgb[0], g = (double)rgb[1], b = (double)rgb[2];
    return sqrt(0.299 * r * r + 0.587 * g * g + 0.114 * b * b);
}

/* The metallic and base colour whose diffuse part and reflectance at normal incidence come nearest
 * to the given ones. A metallic m with reflectance 0.04 of its dielectric part solves 0.04 m^2 + b
 * m + 0.04 - specular = 0. */
static void convert_specular(const float diffuse[3], const float specular[3],
                             air_material_desc *desc)
{
    const double dielectric = 0.04, tiny = 1e-6;
    const double strongest = (double)fmaxf(specular[0], fmaxf(specular[1], specular[2]));
    const double specular_brightness = brightness(specular);
    double metallic = 0.0;
    if (specular_brightness > dielectric) {
        const double b = brightness(diffuse) * (1.0 - strongest) / (1.0 - dielectric) +
                         specular_brightness - 2.0 * dielectric;
        const double c = dielectric - specular_brightness;
        metallic = (-b + sqrt(fmax(b * b - 4.0 * dielectric * c, 0.0))) / (2.0 * dielectric);
        metallic = fmin(fmax(metallic, 0.0), 1.0);
    }
    for (size_t i = 0; i < 3; ++i) {
        const double from_diffuse = (double)diffuse[i] * (1.0 - strongest) /
                                    ((1.0 - dielectric) * fmax(1.0 - metallic, tiny));
        const double from_specular =
            ((double)specular[i] - dielectric * (1.0 - metallic)) / fmax(metallic, tiny);
        const double mixed = from_diffuse + metallic * metallic * (from_specular - from_diffuse);
        desc->base_color[i] = (float)fmin(fmax(mixed, 0.0), 1.0);
    }
    desc->metallic = (float)metallic;
}

static air_status read_specular_glossiness(air_gltf *gltf, const air_json *at,
                                           air_material_desc *desc)
{
    const air_json diffuse_at = air_json_get(at, "diffuseFactor");
    const air_json specular_at = air_json_get(at, "specularFactor");
    const air_json glossiness_at = air_json_get(at, "glossinessFactor");
    const air_json diffuse_texture = air_json_get(at, "diffuseTexture");
    const air_json texture = air_json_get(at, "specularGlossinessTexture");
    float diffuse[4] = {1.0f, 1.0f, 1.0f, 1.0f}, specular[3] = {1.0f, 1.0f, 1.0f},
          glossiness = 1.0f;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_floats(&diffuse_at, AIR_JSON_UNIT, 4, diffuse);
    if (status == AIR_OK)
        status = air_json_floats(&specular_at, AIR_JSON_UNIT, 3, specular);
    if (status == AIR_OK)
        status = air_json_float(&glossiness_at, AIR_JSON_UNIT, &glossiness);
    if (status != AIR_OK)
        return status;
    convert_specular(diffuse, specular, desc);
    desc->base_color[3] = diffuse[3];
    desc->roughness = 1.0f - glossiness;
    if (texture.value != NULL)
        gltf->tally.specular_textures++;
    if (desc->metallic >
        0.5f) /* then base_color is the colour of the highlight, which this texture does not tint */
        return AIR_OK;
    return air_gltf_read_texture(gltf, &diffuse_texture, true, &desc->base_color_texture);
}

static air_status read_emission(air_gltf *gltf, const air_json *material, air_material_desc *desc)
{
    const air_json factor_at = air_json_get(material, "emissiveFactor");
    const air_json texture = air_json_get(material, "emissiveTexture");
    const air_json extensions = air_json_get(material, "extensions");
    const air_json extension = air_json_get(&extensions, "KHR_materials_emissive_strength");
    const air_json strength_at = air_json_get(&extension, "emissiveStrength");
    float factor[3] = {0.0f, 0.0f, 0.0f}, strength = 1.0f;
    air_status status = air_json_floats(&factor_at, AIR_JSON_NON_NEGATIVE, 3, factor);
    if (status == AIR_OK)
        status = air_json_check_object(&extension, false);
    if (status == AIR_OK)
        status = air_json_float(&strength_at, AIR_JSON_NON_NEGATIVE, &strength);
    if (status != AIR_OK)
        return status;
    bool emits = false;
    for (size_t i = 0; i < 3; ++i) {
        const double emission = (double)factor[i] * (double)strength * (double)gltf->emission_scale;
        if (emission > 3.4e38)
            return air_json_fail(&strength_at, AIR_ERROR_FORMAT,
                                 "the emission is too strong to be a number");
        desc->emission[i] = (float)emission;
        emits = emits || emission > 0.0;
    }
    /* Not valid, but seen; what is meant is clear. */
    if (fmaxf(factor[0], fmaxf(factor[1], factor[2])) > 1.0f)
        gltf->tally.strong_emission++;
    return emits ? air_gltf_read_texture(gltf, &texture, true, &desc->emission_texture) : AIR_OK;
}

static air_status read_specular(air_gltf *gltf, const air_json *extensions, air_material_desc *desc)
{
    const air_json ior = air_json_get(extensions, "KHR_materials_ior");
    const air_json ior_at = air_json_get(&ior, "ior");
    const air_json specular = air_json_get(extensions, "KHR_materials_specular");
    const air_json specular_at = air_json_get(&specular, "specularFactor");
    const air_json texture = air_json_get(&specular, "specularTexture");
    const air_json color = air_json_get(&specular, "specularColorFactor");
    const air_json color_texture = air_json_get(&specular, "specularColorTexture");
    air_status status = air_json_check_object(&ior, false);
    if (status == AIR_OK && json_is_number(ior_at.value) && json_number_value(ior_at.value) == 0.0)
        desc->ior = 1e4f; /* the extension's word for a reflectance of 1 at normal incidence */
    else if (status == AIR_OK)
        status = air_json_float(&ior_at, AIR_JSON_AT_LEAST_1, &desc->ior);
    if (status == AIR_OK)
        status = air_json_check_object(&specular, false);
    if (status == AIR_OK)
        status = air_json_float(&specular_at, AIR_JSON_UNIT, &desc->specular);
    if (texture.value != NULL || color.value != NULL || color_texture.value != NULL)
        gltf->tally.specular_textures++;
    return status;
}

static air_status read_alpha(const air_json *material, air_material_desc *desc)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND"};
    const air_json mode_at = air_json_get(material, "alphaMode");
    const air_json cutoff_at = air_json_get(material, "alphaCutoff");
    size_t mode = AIR_ALPHA_OPAQUE;
    air_status status = air_json_choice(&mode_at, modes, 3, &mode);
    desc->alpha_mode = (air_alpha_mode)mode;
    desc->alpha_cutoff = 0.5f;
    if (status == AIR_OK)
        status = air_json_float(&cutoff_at, AIR_JSON_NON_NEGATIVE, &desc->alpha_cutoff);
    return status;
}

static air_status read_material(air_gltf *gltf, const air_json *at, air_material_desc *desc,
                                air_gltf_volume *volume)
{
    const air_json extensions = air_json_get(at, "extensions");
    const air_json glossiness = air_json_get(&extensions, "KHR_materials_pbrSpecularGlossiness");
    const air_json metallic = air_json_get(at, "pbrMetallicRoughness");
    const air_json normal = air_json_get(at, "normalTexture");
    const air_json scale = air_json_get(&normal, "scale");
    const air_json double_sided = air_json_get(at, "doubleSided");
    const air_json unlit = air_json_get(&extensions, "KHR_materials_unlit");
    const air_json name = air_json_get(at, "name");
    desc->name = json_string_value(name.value);
    desc->metallic = 1.0f; /* glTF's default differs from ours */
    desc->unlit = unlit.value != NULL;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_object(&extensions, false);
    if (status == AIR_OK && glossiness.value != NULL)
        status = read_specular_glossiness(gltf, &glossiness, desc);
    else if (status == AIR_OK)
        status = read_metallic_roughness(gltf, &metallic, desc);
    if (status == AIR_OK)
        status = air_gltf_read_texture(gltf, &normal, false, &desc->normal_texture);
    if (status == AIR_OK)
        status = air_json_float(&scale, AIR_JSON_ANY, &desc->normal_scale);
    if (status == AIR_OK)
        status = read_emission(gltf, at, desc);
    if (status == AIR_OK)
        status = read_specular(gltf, &extensions, desc);
    if (status == AIR_OK)
        status = air_gltf_read_transmission(gltf, &extensions, desc, volume);
    if (status == AIR_OK)
        status = read_alpha(at, desc);
    if (status == AIR_OK)
        status = air_json_bool(&double_sided, &desc->double_sided);
    return status == AIR_OK ? air_gltf_read_model(gltf, at, desc) : status;
}

air_status air_gltf_material(air_gltf *gltf, size_t index, air_handle *out_handle)
{
    const air_json at = air_json_at(&gltf->materials, index);
    if (gltf->material_store[index] == AIR_NONE) {
        air_material_desc desc;
        air_material_desc_default(&desc);
        air_status status = read_material(gltf, &at, &desc, &gltf->volume_store[index]);
        if (status != AIR_OK)
            return status;
        status = air_scene_add_material(gltf->import->scene, &desc, &gltf->material_store[index]);
        if (status != AIR_OK)
            return air_json_place_error(&at, status);
    }
    *out_handle = gltf->material_store[index];
    return AIR_OK;
}

/* export_material.c: materials, as glTF and its extensions have them. */
#include <math.h>

#include "scene/export/export.h"

/* How textures of colours and of numbers are read. */
static const air_export_texture colours = {.srgb = true, .scale = 1.0f},
                                numbers = {.srgb = false, .scale = 1.0f};

/* A slot of a material, left out where it has no texture. */
static air_status put_texture(air_export *self, json_t *object, const char *key,
                              const air_texture_ref *reference, const air_export_texture *way)
{
    json_t *info = NULL;
    const air_status status = air_export_texture_info(self, reference, way, &info);
    if (info != NULL)
        air_export_put(self, object, key, info);
    return status;
}

static bool same_places(const air_texture_ref *a, const air_texture_ref *b)
{
    return a->uv_set == b->uv_set &&
           air_bytes_equal(a->uv_transform, b->uv_transform, sizeof a->uv_transform);
}

/* glTF has its alpha in the alpha of the base colour. */
static air_status put_base_texture(air_export *self, const air_material_desc *desc, json_t *base)
{
    air_export_texture way = colours;
    const air_texture_ref *color = &desc->base_color_texture, *opacity = &desc->opacity_texture;
    if (opacity->texture == AIR_NONE)
        return put_texture(self, base, "baseColorTexture", color, &way);
    if (color->texture != AIR_NONE && !same_places(color, opacity)) {
        air_warn(self->context,
                 "%s: material \"%s\": its opacity texture lies otherwise than that of the base "
                 "colour, and is left out",
                 self->path, desc->name);
        return put_texture(self, base, "baseColorTexture", color, &way);
    }
    way.opacity = opacity->texture;
    return put_texture(self, base, "baseColorTexture", color->texture != AIR_NONE ? color : opacity,
                       &way);
}

static air_status put_base(air_export *self, const air_material_desc *desc, json_t *material)
{
    json_t *base = air_export_object(self, material, "pbrMetallicRoughness");
    air_export_put(self, base, "baseColorFactor", air_export_floats(self, desc->base_color, 4));
    air_export_put(self, base, "metallicFactor", json_real((double)desc->metallic));
    air_export_put(self, base, "roughnessFactor", json_real((double)desc->roughness));
    air_status status = put_base_texture(self, desc, base);
    if (status == AIR_OK)
        status = put_texture(self, base, "metallicRoughnessTexture",
                             &desc->metallic_roughness_texture, &numbers);
    if (status == AIR_OK)
        status = put_texture(self, material, "normalTexture", &desc->normal_texture, &numbers);
    json_t *normal = json_object_get(material, "normalTexture");
    if (normal != NULL && desc->normal_scale != 1.0f)
        air_export_put(self, normal, "scale", json_real((double)desc->normal_scale));
    return status;
}

/* As the reader multiplies: in double, by the efficacy rounded to float. */
static float emission_product(float factor, float strength)
{
    return (float)((double)factor * (double)strength * (double)(1.0f / 683.0f));
}

static air_status put_emission(air_export *self, const air_material_desc *desc, json_t *material)
{
    const float peak = air_export_texture_peak(self, desc->emission_texture.texture);
    float emission[3], factors[3], strength = 0.0f;
    for (size_t i = 0; i < 3; ++i)
        emission[i] = desc->emission[i] * peak;
    if (!(fmaxf(emission[0], fmaxf(emission[1], emission[2])) > 0.0f))
        return AIR_OK;
    air_export_split(emission, emission_product, factors, &strength);
    json_t *extension = air_export_extension(self, material, "KHR_materials_emissive_strength");
    air_export_put(self, extension, "emissiveStrength", json_real((double)strength));
    air_export_put(self, material, "emissiveFactor", air_export_floats(self, factors, 3));
    const air_export_texture way = {.srgb = true, .scale = peak};
    return put_texture(self, material, "emissiveTexture", &desc->emission_texture, &way);
}

static void put_alpha(air_export *self, const air_material_desc *desc, json_t *material)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND"};
    if (desc->alpha_mode != AIR_ALPHA_OPAQUE)
        air_export_put(self, material, "alphaMode", json_string(modes[desc->alpha_mode]));
    if (desc->alpha_mode == AIR_ALPHA_MASK)
        air_export_put(self, material, "alphaCutoff", json_real((double)desc->alpha_cutoff));
    if (desc->double_sided)
        air_export_put(self, material, "doubleSided", json_true());
    if (desc->unlit)
        (void)air_export_extension(self, material, "KHR_materials_unlit");
}

static air_status put_interface(air_export *self, const air_material_desc *desc, json_t *material)
{
    if (desc->ior != 1.5f)
        air_export_put(self, air_export_extension(self, material, "KHR_materials_ior"), "ior",
                       json_real((double)desc->ior));
    if (desc->specular != 1.0f)
        air_export_put(self, air_export_extension(self, material, "KHR_materials_specular"),
                       "specularFactor", json_real((double)desc->specular));
    if (!(desc->transmission > 0.0f))
        return AIR_OK;
    json_t *transmission = air_export_extension(self, material, "KHR_materials_transmission");
    air_export_put(self, transmission, "transmissionFactor", json_real((double)desc->transmission));
    /* Any thickness above 0 says that light is bent; how far it goes inside, the mesh does. */
    if (!desc->thin_walled)
        air_export_put(self, air_export_extension(self, material, "KHR_materials_volume"),
                       "thicknessFactor", json_real(1.0));
    return put_texture(self, transmission, "transmissionTexture", &desc->transmission_texture,
                       &numbers);
}

static air_status add_material(air_export *self, const air_material_record *record)
{
    air_material_desc desc;
    json_t *material = json_object();
    air_export_nearest_material(self, &record->desc, &desc);
    air_export_name(self, material, record->base.name);
    air_status status = put_base(self, &desc, material);
    if (status == AIR_OK)
        status = put_emission(self, &desc, material);
    if (status == AIR_OK)
        status = put_interface(self, &desc, material);
    if (status == AIR_OK)
        status = air_export_model(self, &record->desc, material);
    put_alpha(self, &desc, material);
    (void)air_export_append(self, "materials", material);
    return status;
}

air_status air_export_materials(air_export *self)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_MATERIAL];
    air_status status = AIR_OK;
    for (size_t i = 0; i < list->count && status == AIR_OK; ++i)
        status = add_material(self, (const air_material_record *)list->slots[i].record);
    return status;
}

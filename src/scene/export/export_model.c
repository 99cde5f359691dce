/* export_model.c: materials of other models than glTF's, by what comes nearest to them. */
#include <math.h>

#include "scene/export/export.h"

/* The reflectance of a metal at normal incidence, ((eta-1)^2 + k^2) / ((eta+1)^2 + k^2). */
static float metal_reflectance(float eta, float k)
{
    const float below = (eta + 1.0f) * (eta + 1.0f) + k * k;
    return ((eta - 1.0f) * (eta - 1.0f) + k * k) / below;
}

/* glTF squares its roughness into the width of the slopes; along and across it has but one. */
static float roughness_of(const air_material_desc *desc)
{
    return fminf(sqrtf(sqrtf(desc->alpha_u * desc->alpha_v)), 1.0f);
}

static void from_conductor(const air_material_desc *desc, air_material_desc *out)
{
    out->metallic = 1.0f;
    out->roughness = roughness_of(desc);
    for (size_t i = 0; i < 3; ++i)
        out->base_color[i] = fminf(
            metal_reflectance(desc->eta[i], desc->absorption[i]) * desc->reflectance[i], 1.0f);
}

static void from_dielectric(const air_material_desc *desc, air_material_desc *out)
{
    out->metallic = 0.0f;
    out->roughness = roughness_of(desc);
    out->transmission = 1.0f;
    out->thin_walled = desc->model == AIR_MATERIAL_THIN_DIELECTRIC;
    out->ior = fmaxf(desc->ior, 1.0f / desc->ior);
    for (size_t i = 0; i < 3; ++i)
        out->base_color[i] = desc->transmittance[i];
}

static void from_plastic(const air_material_desc *desc, air_material_desc *out)
{
    out->metallic = 0.0f;
    out->roughness = roughness_of(desc);
    out->ior = fmaxf(desc->ior, 1.0f / desc->ior);
}

static void from_nothing(air_material_desc *out)
{
    out->base_color[3] = 0.0f;
    out->alpha_mode = AIR_ALPHA_BLEND;
}

static const air_material_desc *part_of(const air_export *self, const air_material_desc *desc,
                                        size_t index)
{
    return &((const air_material_record *)air_export_record(self, AIR_OBJECT_MATERIAL,
                                                            desc->blend[index]))
                ->desc;
}

static void from_model(const air_material_desc *desc, air_material_desc *out)
{
    switch (desc->model) {
    case AIR_MATERIAL_CONDUCTOR:
        from_conductor(desc, out);
        break;
    case AIR_MATERIAL_DIELECTRIC:
    case AIR_MATERIAL_THIN_DIELECTRIC:
        from_dielectric(desc, out);
        break;
    case AIR_MATERIAL_PLASTIC:
        from_plastic(desc, out);
        break;
    case AIR_MATERIAL_NULL:
        from_nothing(out);
        break;
    case AIR_MATERIAL_METALLIC_ROUGHNESS:
    case AIR_MATERIAL_BLEND:
        break;
    }
    out->model = AIR_MATERIAL_METALLIC_ROUGHNESS;
}

static float mix(float a, float b, float share) { return a + share * (b - a); }

/* The numbers are mixed; what cannot be is taken from the part with the greater share. */
static void from_blend(const air_export *self, const air_material_desc *desc,
                       air_material_desc *out)
{
    air_material_desc parts[2];
    const float share = desc->blend_weight;
    for (size_t i = 0; i < 2; ++i) {
        parts[i] = *part_of(self, desc, i);
        from_model(part_of(self, desc, i), &parts[i]);
    }
    *out = parts[share > 0.5f];
    for (size_t i = 0; i < 4; ++i)
        out->base_color[i] = mix(parts[0].base_color[i], parts[1].base_color[i], share);
    for (size_t i = 0; i < 3; ++i)
        out->emission[i] = desc->emission[i];
    out->emission_texture = desc->emission_texture;
    out->metallic = mix(parts[0].metallic, parts[1].metallic, share);
    out->roughness = mix(parts[0].roughness, parts[1].roughness, share);
    out->transmission = mix(parts[0].transmission, parts[1].transmission, share);
}

static const char *const became[] = {
    [AIR_MATERIAL_DIELECTRIC] = "a dielectric, which became KHR_materials_transmission and _volume",
    [AIR_MATERIAL_THIN_DIELECTRIC] = "a thin dielectric, which became KHR_materials_transmission",
    [AIR_MATERIAL_CONDUCTOR] = "a conductor, which became metal of its reflectance seen head-on",
    [AIR_MATERIAL_PLASTIC] = "a plastic, which became glTF's dielectric with its base colour",
    [AIR_MATERIAL_BLEND] = "a blend, which became one material with the numbers of both mixed",
    [AIR_MATERIAL_NULL] = "nothing at all, which became a surface with alpha 0",
};

static void warn_of_textures(const air_export *self, const air_material_desc *desc)
{
    const struct {
        const air_texture_ref *reference;
        const char *what;
    } slots[] = {{&desc->bump_texture, "bump"}, {&desc->blend_texture, "blend"}};
    for (size_t i = 0; i < sizeof slots / sizeof *slots; ++i)
        if (slots[i].reference->texture != AIR_NONE)
            air_warn(self->context, "%s: material \"%s\": its %s texture is left out", self->path,
                     desc->name, slots[i].what);
}

void air_export_nearest_material(const air_export *self, const air_material_desc *desc,
                                 air_material_desc *out)
{
    *out = *desc;
    warn_of_textures(self, desc);
    if (desc->model == AIR_MATERIAL_METALLIC_ROUGHNESS)
        return;
    air_warn(self->context, "%s: material \"%s\" is %s", self->path, desc->name,
             became[desc->model]);
    if (desc->model == AIR_MATERIAL_BLEND)
        from_blend(self, desc, out);
    from_model(desc, out);
}

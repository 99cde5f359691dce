/* export_model.c: materials of other models than glTF's: for other programs by what comes nearest
 * to them, for ours in an airlight object. */
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
    for (size_t i = 0; i < 3; ++i)
        out->base_color[i] = mix(parts[0].base_color[i], parts[1].base_color[i], share);
    for (size_t i = 0; i < 3; ++i)
        out->emission[i] = desc->emission[i];
    out->emission_texture = desc->emission_texture;
    out->base_color[3] = desc->base_color[3]; /* coverage is the blend's own */
    out->opacity_texture = desc->opacity_texture;
    out->alpha_mode = desc->alpha_mode;
    out->alpha_cutoff = desc->alpha_cutoff;
    out->double_sided = desc->double_sided;
    out->metallic = mix(parts[0].metallic, parts[1].metallic, share);
    out->roughness = mix(parts[0].roughness, parts[1].roughness, share);
    out->transmission = mix(parts[0].transmission, parts[1].transmission, share);
}

void air_export_nearest_material(const air_export *self, const air_material_desc *desc,
                                 air_material_desc *out)
{
    *out = *desc;
    if (desc->model == AIR_MATERIAL_BLEND)
        from_blend(self, desc, out);
    from_model(desc, out);
}

/* ---- the airlight object ---- */

static void put_facets(air_export *self, const air_material_desc *desc, json_t *object)
{
    const float alpha[2] = {desc->alpha_u, desc->alpha_v};
    if (desc->microfacets == AIR_MICROFACETS_BECKMANN)
        air_export_put(self, object, "microfacets", json_string("beckmann"));
    air_export_put(self, object, "alpha", air_export_floats(self, alpha, 2));
    air_export_put(self, object, "reflectance", air_export_color(self, desc->reflectance));
    if (desc->model == AIR_MATERIAL_CONDUCTOR) {
        air_export_put(self, object, "eta", air_export_color(self, desc->eta));
        air_export_put(self, object, "absorption", air_export_color(self, desc->absorption));
        return;
    }
    air_export_put(self, object, "ior", json_real((double)desc->ior));
    air_export_put(self, object, "transmittance", air_export_color(self, desc->transmittance));
    if (desc->model == AIR_MATERIAL_PLASTIC && desc->nonlinear)
        air_export_put(self, object, "nonlinear", json_true());
}

static air_status put_texture(air_export *self, json_t *object, const char *key,
                              const air_texture_ref *reference)
{
    const air_export_texture way = {.srgb = false, .scale = 1.0f};
    json_t *info = NULL;
    const air_status status = air_export_texture_info(self, reference, &way, &info);
    if (info != NULL)
        air_export_put(self, object, key, info);
    return status;
}

static air_status put_blend(air_export *self, const air_material_desc *desc, json_t *object)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_MATERIAL];
    json_t *parts = air_export_list(self, object, "blend");
    for (size_t i = 0; i < 2; ++i)
        air_export_push(self, parts, json_integer((json_int_t)air_slot_find(list, desc->blend[i])));
    air_export_put(self, object, "weight", json_real((double)desc->blend_weight));
    return put_texture(self, object, "weight_texture", &desc->blend_texture);
}

air_status air_export_model(air_export *self, const air_material_desc *desc, json_t *material)
{
    const bool own = desc->model != AIR_MATERIAL_METALLIC_ROUGHNESS;
    const bool bumped = desc->bump_texture.texture != AIR_NONE;
    air_status status = AIR_OK;
    if (!own && !bumped && !desc->one_sided)
        return AIR_OK;
    json_t *object = air_export_node_object(self, material);
    if (own)
        air_export_put(self, object, "model", json_string(air_material_model_names[desc->model]));
    if (desc->one_sided)
        air_export_put(self, object, "one_sided", json_true());
    if (desc->model == AIR_MATERIAL_BLEND)
        status = put_blend(self, desc, object);
    else if (own && desc->model != AIR_MATERIAL_NULL)
        put_facets(self, desc, object);
    if (status == AIR_OK && bumped) {
        air_export_put(self, object, "bump_scale", json_real((double)desc->bump_scale));
        status = put_texture(self, object, "bump_texture", &desc->bump_texture);
    }
    return status;
}

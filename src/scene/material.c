#include "scene/material.h"

#include "scene/subject.h"

/* The texture references of a description, in the order of air_material_links. */
enum {
    BASE_COLOR = 0,
    METALLIC_ROUGHNESS = 1,
    NORMAL = 2,
    EMISSION = 3,
    TRANSMISSION = 4,
    BLEND = 5,
    OPACITY = 6,
    BUMP = 7
};

static void list_references(const air_material_desc *desc,
                            const air_texture_ref *out[AIR_MATERIAL_TEXTURES])
{
    out[BASE_COLOR] = &desc->base_color_texture;
    out[METALLIC_ROUGHNESS] = &desc->metallic_roughness_texture;
    out[NORMAL] = &desc->normal_texture;
    out[EMISSION] = &desc->emission_texture;
    out[TRANSMISSION] = &desc->transmission_texture;
    out[BLEND] = &desc->blend_texture;
    out[OPACITY] = &desc->opacity_texture;
    out[BUMP] = &desc->bump_texture;
}

static const char *const reference_names[AIR_MATERIAL_TEXTURES] = {
    "base_color_texture",   "metallic_roughness_texture",
    "normal_texture",       "emission_texture",
    "transmission_texture", "blend_texture",
    "opacity_texture",      "bump_texture"};

const char *const air_material_model_names[AIR_MATERIAL_MODELS] = {
    "metallic_roughness", "dielectric", "thin_dielectric", "conductor", "plastic", "blend", "null"};

void air_material_desc_default(air_material_desc *desc)
{
    const air_texture_ref none = {
        .texture = AIR_NONE, .uv_set = 0, .uv_transform = {1, 0, 0, 0, 1, 0}};
    *desc = (air_material_desc){.base_color = {1.0f, 1.0f, 1.0f, 1.0f},
                                .base_color_texture = none,
                                .metallic = 0.0f,
                                .roughness = 1.0f,
                                .metallic_roughness_texture = none,
                                .normal_scale = 1.0f,
                                .normal_texture = none,
                                .emission_texture = none,
                                .specular = 1.0f,
                                .ior = 1.5f,
                                .transmission_texture = none,
                                .thin_walled = true,
                                .reflectance = {1.0f, 1.0f, 1.0f},
                                .transmittance = {1.0f, 1.0f, 1.0f},
                                .absorption = {1.0f, 1.0f, 1.0f},
                                .blend = {AIR_NONE, AIR_NONE},
                                .blend_weight = 0.5f,
                                .blend_texture = none,
                                .opacity_texture = none,
                                .bump_texture = none,
                                .bump_scale = 1.0f,
                                .alpha_mode = AIR_ALPHA_OPAQUE,
                                .alpha_cutoff = 0.5f};
}

static bool has_free_ior(const air_material_desc *desc)
{
    return desc->model == AIR_MATERIAL_DIELECTRIC || desc->model == AIR_MATERIAL_PLASTIC;
}

/* What holds of one model only. */
static air_status check_model(const air_subject *subject, const air_material_desc *desc)
{
    const float *emission = desc->emission;
    for (size_t i = 0; desc->model == AIR_MATERIAL_CONDUCTOR && i < 3; ++i) {
        if (desc->eta[i] == 0.0f && desc->absorption[i] == 0.0f)
            return air_subject_fail(subject,
                                    "eta[%zu] and absorption[%zu] are 0, but a conductor's index "
                                    "must not be",
                                    i, i);
    }
    if (desc->model == AIR_MATERIAL_NULL &&
        (emission[0] > 0.0f || emission[1] > 0.0f || emission[2] > 0.0f))
        return air_subject_fail(subject,
                                "emission must be 0 of the model NULL, which no ray meets");
    return AIR_OK;
}

static air_status check_references(const air_subject *subject, const air_material_desc *desc)
{
    const air_texture_ref *references[AIR_MATERIAL_TEXTURES];
    air_status status = AIR_OK;
    list_references(desc, references);
    for (size_t i = 0; i < AIR_MATERIAL_TEXTURES && status == AIR_OK; ++i) {
        if (references[i]->texture == AIR_NONE)
            continue;
        if (references[i]->uv_set > 1)
            return air_subject_fail(subject, "%s.uv_set is %u, but must be 0 or 1",
                                    reference_names[i], references[i]->uv_set);
        status = air_subject_check(subject, reference_names[i], references[i]->uv_transform, 6,
                                   -INFINITY, INFINITY);
    }
    return status;
}

static air_status check_material(air_context *context, const air_material_desc *desc)
{
    const air_subject subject = {context, "material", desc->name};
    const struct {
        const char *field;
        const float *values;
        size_t count;
        float low, high;
    } checks[] = {
        {"base_color", desc->base_color, 4, 0.0f, 1.0f},
        {"metallic", &desc->metallic, 1, 0.0f, 1.0f},
        {"roughness", &desc->roughness, 1, 0.0f, 1.0f},
        {"normal_scale", &desc->normal_scale, 1, -INFINITY, INFINITY},
        {"emission", desc->emission, 3, 0.0f, INFINITY},
        {"specular", &desc->specular, 1, 0.0f, 1.0f},
        {"ior", &desc->ior, 1, has_free_ior(desc) ? 1e-3f : 1.0f, 1e4f},
        {"transmission", &desc->transmission, 1, 0.0f, 1.0f},
        {"alpha_u", &desc->alpha_u, 1, 0.0f, 1e3f},
        {"alpha_v", &desc->alpha_v, 1, 0.0f, 1e3f},
        {"reflectance", desc->reflectance, 3, 0.0f, 1.0f},
        {"transmittance", desc->transmittance, 3, 0.0f, 1.0f},
        {"eta", desc->eta, 3, 0.0f, 1e4f},
        {"absorption", desc->absorption, 3, 0.0f, 1e4f},
        {"blend_weight", &desc->blend_weight, 1, 0.0f, 1.0f},
        {"bump_scale", &desc->bump_scale, 1, -INFINITY, INFINITY},
        {"alpha_cutoff", &desc->alpha_cutoff, 1, 0.0f, INFINITY},
    };
    air_status status = air_subject_check_enum(&subject, "alpha_mode", (int)desc->alpha_mode, 3);
    if (status == AIR_OK)
        status = air_subject_check_enum(&subject, "model", (int)desc->model, AIR_MATERIAL_MODELS);
    if (status == AIR_OK)
        status = air_subject_check_enum(&subject, "microfacets", (int)desc->microfacets, 2);
    for (size_t i = 0; i < sizeof checks / sizeof *checks && status == AIR_OK; ++i)
        status = air_subject_check(&subject, checks[i].field, checks[i].values, checks[i].count,
                                   checks[i].low, checks[i].high);
    if (status == AIR_OK)
        status = check_model(&subject, desc);
    return status == AIR_OK ? check_references(&subject, desc) : status;
}

static air_facets facets_of(const air_material_desc *desc)
{
    return air_facets_make(desc->microfacets, desc->alpha_u, desc->alpha_v);
}

air_status air_material_record_create(air_context *context, const air_material_desc *desc,
                                      air_record **out_record)
{
    const air_status status = check_material(context, desc);
    if (status != AIR_OK)
        return status;
    air_material_record *record =
        air_record_create(context, sizeof *record, air_record_own_nothing, desc->name);
    if (record == NULL)
        return AIR_ERROR_MEMORY;
    record->desc = *desc;
    record->desc.name = record->base.name;
    if (desc->model == AIR_MATERIAL_PLASTIC) {
        const air_facets facets = facets_of(desc);
        air_plastic_table_make(&facets, desc->ior, &record->plastic);
    }
    *out_record = &record->base;
    return AIR_OK;
}

void air_material_links(const air_material_desc *desc, air_link out_links[AIR_MAX_LINKS])
{
    const air_texture_ref *references[AIR_MATERIAL_TEXTURES];
    const bool blends = desc->model == AIR_MATERIAL_BLEND;
    list_references(desc, references);
    for (size_t i = 0; i < AIR_MATERIAL_TEXTURES; ++i)
        out_links[i] =
            (air_link){references[i]->texture, AIR_OBJECT_TEXTURE, reference_names[i], false};
    for (size_t i = 0; i < 2; ++i)
        out_links[AIR_MATERIAL_TEXTURES + i] =
            (air_link){blends ? desc->blend[i] : AIR_NONE, AIR_OBJECT_MATERIAL, "blend", blends};
}

static bool reference_equal(const air_texture_ref *a, const air_texture_ref *b)
{
    return a->texture == b->texture &&
           (a->texture == AIR_NONE ||
            (a->uv_set == b->uv_set &&
             air_bytes_equal(a->uv_transform, b->uv_transform, sizeof a->uv_transform)));
}

bool air_material_emission_equal(const air_material_desc *a, const air_material_desc *b)
{
    return air_bytes_equal(a->emission, b->emission, sizeof a->emission) &&
           reference_equal(&a->emission_texture, &b->emission_texture) &&
           a->double_sided == b->double_sided;
}

static bool facets_equal(const air_material_desc *a, const air_material_desc *b)
{
    return a->microfacets == b->microfacets && a->alpha_u == b->alpha_u &&
           a->alpha_v == b->alpha_v &&
           air_bytes_equal(a->reflectance, b->reflectance, sizeof a->reflectance) &&
           air_bytes_equal(a->transmittance, b->transmittance, sizeof a->transmittance) &&
           air_bytes_equal(a->eta, b->eta, sizeof a->eta) &&
           air_bytes_equal(a->absorption, b->absorption, sizeof a->absorption) &&
           a->nonlinear == b->nonlinear;
}

static bool blend_equal(const air_material_desc *a, const air_material_desc *b)
{
    return a->blend[0] == b->blend[0] && a->blend[1] == b->blend[1] &&
           a->blend_weight == b->blend_weight &&
           reference_equal(&a->blend_texture, &b->blend_texture);
}

bool air_material_equal(const air_material_desc *a, const air_material_desc *b)
{
    return air_material_emission_equal(a, b) && a->model == b->model && facets_equal(a, b) &&
           blend_equal(a, b) && a->transmission == b->transmission &&
           reference_equal(&a->transmission_texture, &b->transmission_texture) &&
           a->thin_walled == b->thin_walled && a->one_sided == b->one_sided &&
           reference_equal(&a->opacity_texture, &b->opacity_texture) &&
           reference_equal(&a->bump_texture, &b->bump_texture) && a->bump_scale == b->bump_scale &&
           air_bytes_equal(a->base_color, b->base_color, sizeof a->base_color) &&
           reference_equal(&a->base_color_texture, &b->base_color_texture) &&
           a->metallic == b->metallic && a->roughness == b->roughness &&
           reference_equal(&a->metallic_roughness_texture, &b->metallic_roughness_texture) &&
           a->normal_scale == b->normal_scale &&
           reference_equal(&a->normal_texture, &b->normal_texture) && a->specular == b->specular &&
           a->ior == b->ior && a->alpha_mode == b->alpha_mode &&
           a->alpha_cutoff == b->alpha_cutoff && a->unlit == b->unlit;
}

static air_texture_slot make_slot(const air_texture_ref *reference, const air_texture *texture)
{
    air_texture_slot slot = {.texture = texture, .uv_set = reference->uv_set};
    for (size_t i = 0; i < 6; ++i)
        slot.uv_transform[i] = reference->uv_transform[i];
    return slot;
}

/* Can the coverage of a surface of this material be less than 1 anywhere? */
static bool has_coverage(const air_material_desc *desc, const air_texture *base_color,
                         const air_texture *opacity, bool colored)
{
    if (desc->alpha_mode == AIR_ALPHA_OPAQUE || desc->model == AIR_MATERIAL_NULL)
        return false;
    const bool varies =
        colored || opacity != NULL || (base_color != NULL && base_color->channels % 2 == 0);
    const float covered = desc->alpha_mode == AIR_ALPHA_MASK ? desc->alpha_cutoff : 1.0f;
    return varies || desc->base_color[3] < covered;
}

/* Is it an interface that changes no light? Rays then pass it, shadow rays too. */
static bool is_matched(const air_material_desc *desc)
{
    const float *t = desc->transmittance, *e = desc->emission;
    return desc->model == AIR_MATERIAL_DIELECTRIC && desc->ior == 1.0f && t[0] == 1.0f &&
           t[1] == 1.0f && t[2] == 1.0f && e[0] == 0.0f && e[1] == 0.0f && e[2] == 0.0f;
}

static air_optics make_optics(const air_material_record *record)
{
    const air_material_desc *desc = &record->desc;
    return (air_optics){.facets = facets_of(desc),
                        .reflectance = vec3_load(desc->reflectance),
                        .transmittance = vec3_load(desc->transmittance),
                        .eta = vec3_load(desc->eta),
                        .absorption = vec3_load(desc->absorption),
                        .nonlinear = desc->nonlinear,
                        .plastic = desc->model == AIR_MATERIAL_PLASTIC ? &record->plastic : NULL};
}

void air_material_init(const air_material_record *record,
                       const air_texture *const textures[AIR_MATERIAL_TEXTURES], bool colored,
                       air_material *out_material)
{
    const air_material_desc *desc = &record->desc;
    *out_material = (air_material){
        .name = record->base.name,
        .model = is_matched(desc) ? AIR_MATERIAL_NULL : desc->model,
        .base_color = vec3_load(desc->base_color),
        .alpha = desc->base_color[3],
        .metallic = desc->metallic,
        .roughness = desc->roughness,
        .normal_scale = desc->normal_scale,
        .specular = desc->specular,
        .ior = desc->ior,
        .emission = vec3_load(desc->emission),
        .base_color_slot = make_slot(&desc->base_color_texture, textures[BASE_COLOR]),
        .metallic_roughness_slot =
            make_slot(&desc->metallic_roughness_texture, textures[METALLIC_ROUGHNESS]),
        .normal_slot = make_slot(&desc->normal_texture, textures[NORMAL]),
        .emission_slot = make_slot(&desc->emission_texture, textures[EMISSION]),
        .alpha_mode = has_coverage(desc, textures[BASE_COLOR], textures[OPACITY], colored)
                          ? desc->alpha_mode
                          : AIR_ALPHA_OPAQUE,
        .alpha_cutoff = desc->alpha_cutoff,
        .double_sided = desc->double_sided,
        .one_sided = desc->one_sided,
        .unlit = desc->unlit,
        .transmission = desc->transmission,
        .thin_walled = desc->thin_walled,
        .optics = make_optics(record),
        .transmission_slot = make_slot(&desc->transmission_texture, textures[TRANSMISSION]),
        .blend_slot = make_slot(&desc->blend_texture, textures[BLEND]),
        .opacity_slot = make_slot(&desc->opacity_texture, textures[OPACITY]),
        .bump_slot = make_slot(&desc->bump_texture, textures[BUMP]),
        .bump_scale = desc->bump_scale,
        .blend_weight = desc->blend_weight,
    };
    for (size_t i = 0; i < AIR_MATERIAL_TEXTURES; ++i)
        out_material->textured = out_material->textured || textures[i] != NULL;
}

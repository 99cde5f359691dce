#include "scene/material.h"

#include "scene/subject.h"

/* The texture references of a description, in the order of air_material_links. */
enum { BASE_COLOR = 0, METALLIC_ROUGHNESS = 1, NORMAL = 2, EMISSION = 3 };

static void list_references(const air_material_desc *desc,
                            const air_texture_ref *out[AIR_MAX_LINKS])
{
    out[BASE_COLOR] = &desc->base_color_texture;
    out[METALLIC_ROUGHNESS] = &desc->metallic_roughness_texture;
    out[NORMAL] = &desc->normal_texture;
    out[EMISSION] = &desc->emission_texture;
}

static const char *const reference_names[AIR_MAX_LINKS] = {
    "base_color_texture", "metallic_roughness_texture", "normal_texture", "emission_texture"};

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
                                .alpha_mode = AIR_ALPHA_OPAQUE,
                                .alpha_cutoff = 0.5f};
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
        {"ior", &desc->ior, 1, 1.0f, INFINITY},
        {"alpha_cutoff", &desc->alpha_cutoff, 1, 0.0f, INFINITY},
    };
    air_status status = air_subject_check_enum(&subject, "alpha_mode", (int)desc->alpha_mode, 3);
    for (size_t i = 0; i < sizeof checks / sizeof *checks && status == AIR_OK; ++i)
        status = air_subject_check(&subject, checks[i].field, checks[i].values, checks[i].count,
                                   checks[i].low, checks[i].high);
    const air_texture_ref *references[AIR_MAX_LINKS];
    list_references(desc, references);
    for (size_t i = 0; i < AIR_MAX_LINKS && status == AIR_OK; ++i) {
        if (references[i]->texture == AIR_NONE)
            continue;
        if (references[i]->uv_set > 1)
            return air_subject_fail(&subject, "%s.uv_set is %u, but must be 0 or 1",
                                    reference_names[i], references[i]->uv_set);
        status = air_subject_check(&subject, reference_names[i], references[i]->uv_transform, 6,
                                   -INFINITY, INFINITY);
    }
    return status;
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
    *out_record = &record->base;
    return AIR_OK;
}

void air_material_links(const air_material_desc *desc, air_link out_links[AIR_MAX_LINKS])
{
    const air_texture_ref *references[AIR_MAX_LINKS];
    list_references(desc, references);
    for (size_t i = 0; i < AIR_MAX_LINKS; ++i)
        out_links[i] =
            (air_link){references[i]->texture, AIR_OBJECT_TEXTURE, reference_names[i], false};
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

bool air_material_equal(const air_material_desc *a, const air_material_desc *b)
{
    return air_material_emission_equal(a, b) &&
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
static bool has_coverage(const air_material_desc *desc, const air_texture *base_color, bool colored)
{
    if (desc->alpha_mode == AIR_ALPHA_OPAQUE)
        return false;
    const bool varies = colored || (base_color != NULL && base_color->channels % 2 == 0);
    const float covered = desc->alpha_mode == AIR_ALPHA_MASK ? desc->alpha_cutoff : 1.0f;
    return varies || desc->base_color[3] < covered;
}

void air_material_init(const air_material_record *record,
                       const air_texture *const textures[AIR_MAX_LINKS], bool colored,
                       air_material *out_material)
{
    const air_material_desc *desc = &record->desc;
    *out_material = (air_material){
        .name = record->base.name,
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
        .alpha_mode =
            has_coverage(desc, textures[BASE_COLOR], colored) ? desc->alpha_mode : AIR_ALPHA_OPAQUE,
        .alpha_cutoff = desc->alpha_cutoff,
        .double_sided = desc->double_sided,
        .unlit = desc->unlit,
    };
    for (size_t i = 0; i < AIR_MAX_LINKS; ++i)
        out_material->textured = out_material->textured || textures[i] != NULL;
}

#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"

/* ---- surfaces ---- */

static void set_lambert(const air_mitsuba *mitsuba, float reflectance, air_material_desc *desc)
{
    desc->model = AIR_MATERIAL_METALLIC_ROUGHNESS;
    desc->one_sided = !mitsuba->both_sides;
    desc->specular = 0.0f; /* with metallic 0 a pure Lambert surface */
    desc->base_color[0] = desc->base_color[1] = desc->base_color[2] = reflectance;
}

/* Reflectance under its name, and under that of version 0.x. */
static air_status read_diffuse(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    const char *name = air_mitsuba_has(at, "reflectance") ? "reflectance" : "diffuse_reflectance";
    set_lambert(mitsuba, 0.5f, desc);
    return air_mitsuba_textured(mitsuba, at, name, AIR_MITSUBA_REFLECTANCE, desc->base_color,
                                &desc->base_color_texture);
}

/* What is not known: its diffuse part, if it can be told. */
static air_status replace_bsdf(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    static const char *const types[] = {
        "diffuse",   "null",           "dielectric", "roughdielectric", "thindielectric",
        "conductor", "roughconductor", "plastic",    "roughplastic",    "twosided",
        "mask",      "bumpmap",        "normalmap",  "blendbsdf"};
    air_status status = air_mitsuba_unknown_type(mitsuba, at, types, sizeof types / sizeof *types,
                                                 "a diffuse surface of its colour is taken");
    set_lambert(mitsuba, 0.5f, desc);
    if (status == AIR_OK && air_mitsuba_has(at, "base_color"))
        status = air_mitsuba_textured(mitsuba, at, "base_color", AIR_MITSUBA_REFLECTANCE,
                                      desc->base_color, &desc->base_color_texture);
    else if (status == AIR_OK)
        status = read_diffuse(mitsuba, at, desc);
    at->asked = false; /* the one warning says it */
    return status;
}

/* ---- around other bsdfs ---- */

/* The only nested bsdf. */
static air_status nested(const air_mitsuba *mitsuba, const air_xml *at, air_xml **out)
{
    air_status status = air_mitsuba_child(mitsuba, at, "bsdf", NULL, out);
    if (status == AIR_OK && *out == NULL)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected a <bsdf> within it");
    return status;
}

/* What reflects only in front does so behind, too. */
static air_status read_twosided(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    static const char *const ignored[] = {"allow_transmission"};
    air_xml *from = at->child, *child = NULL, *front = NULL, *back = NULL;
    air_mitsuba_ignore(at, ignored, 1);
    air_status status = air_mitsuba_next(mitsuba, &from, "bsdf", &child, &front);
    if (status == AIR_OK && from != NULL)
        status = air_mitsuba_next(mitsuba, &from, "bsdf", &child, &back);
    if (status == AIR_OK && front == NULL)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected a <bsdf> within it");
    if (status == AIR_OK && back != NULL && back != front)
        status = air_mitsuba_replace(mitsuba, at, "sides that differ are not supported",
                                     "the first one is taken for both");
    if (status != AIR_OK)
        return status;
    const bool outer = mitsuba->both_sides;
    mitsuba->both_sides = true;
    status = air_mitsuba_read_bsdf(mitsuba, front, desc);
    mitsuba->both_sides = outer;
    return status;
}

static air_status read_mask(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    float opacity[3] = {0.5f, 0.5f, 0.5f};
    air_xml *inner = NULL;
    air_texture_ref ref;
    air_status status = nested(mitsuba, at, &inner);
    if (status == AIR_OK)
        status = air_mitsuba_read_bsdf(mitsuba, inner, desc);
    if (status == AIR_OK)
        status =
            air_mitsuba_textured(mitsuba, at, "opacity", AIR_MITSUBA_REFLECTANCE, opacity, &ref);
    if (status == AIR_OK && (opacity[0] != opacity[1] || opacity[0] != opacity[2]))
        status = air_mitsuba_warn(mitsuba, at, "the opacity is taken as grey: its mean");
    if (status == AIR_OK && ref.texture != AIR_NONE)
        desc->opacity_texture = ref;
    desc->base_color[3] *= vec3_mean(vec3_load(opacity));
    desc->alpha_mode = AIR_ALPHA_BLEND;
    return status;
}

/* The texture that shapes a surface is the nested one, under whatever name. */
static air_status read_relief(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    static const char *const ignored[] = {"flip_invalid_normals", "use_shadowing_function"};
    const bool bump = air_mitsuba_is(at, "bumpmap");
    float scale[3] = {1.0f, 1.0f, 1.0f}, height = 1.0f;
    air_xml *inner = NULL, *texture = NULL;
    air_mitsuba_ignore(at, ignored, 2);
    air_status status = nested(mitsuba, at, &inner);
    if (status == AIR_OK)
        status = air_mitsuba_read_bsdf(mitsuba, inner, desc);
    if (status == AIR_OK)
        status = air_mitsuba_child(mitsuba, at, "texture", NULL, &texture);
    if (status == AIR_OK && texture == NULL)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected a <texture> within it");
    if (status == AIR_OK)
        status = air_mitsuba_texture(mitsuba, texture, true, scale,
                                     bump ? &desc->bump_texture : &desc->normal_texture);
    if (status == AIR_OK && bump)
        status = air_mitsuba_float(mitsuba, at, "scale", &height);
    if (bump)
        desc->bump_scale = height * scale[0];
    return status;
}

/* A part of a blend as a material of its own. */
static air_status add_part(air_mitsuba *mitsuba, air_xml *at, air_handle *out_handle)
{
    air_material_desc desc;
    const air_xml *with = mitsuba->both_sides ? at : NULL;
    const air_mitsuba_made *made = air_mitsuba_find_made(at, with);
    if (made != NULL) {
        *out_handle = made->handle;
        return AIR_OK;
    }
    air_material_desc_default(&desc);
    desc.name = air_mitsuba_name(at);
    air_status status = air_mitsuba_read_bsdf(mitsuba, at, &desc);
    if (status == AIR_OK && desc.model == AIR_MATERIAL_BLEND)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                  "a blend within a blend is not supported");
    if (status == AIR_OK && desc.model == AIR_MATERIAL_NULL)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                  "a null surface within a blend is not supported, expected a mask "
                                  "around the other");
    if (status == AIR_OK) {
        status = air_scene_add_material(mitsuba->import->scene, &desc, out_handle);
        if (status != AIR_OK)
            status = air_xml_place_error(&mitsuba->document, at, status);
    }
    if (status == AIR_OK && air_mitsuba_note_made(mitsuba, at, with, *out_handle) == NULL)
        status = AIR_ERROR_MEMORY;
    return status;
}

static air_status read_blend(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    float weight[3] = {0.5f, 0.5f, 0.5f};
    air_xml *from = at->child, *child = NULL, *parts[2] = {NULL, NULL};
    air_status status = air_mitsuba_next(mitsuba, &from, "bsdf", &child, &parts[0]);
    if (status == AIR_OK && from != NULL)
        status = air_mitsuba_next(mitsuba, &from, "bsdf", &child, &parts[1]);
    if (status == AIR_OK && parts[1] == NULL)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected two <bsdf> within it");
    for (size_t i = 0; i < 2 && status == AIR_OK; ++i)
        status = add_part(mitsuba, parts[i], &desc->blend[i]);
    if (status == AIR_OK)
        status = air_mitsuba_textured(mitsuba, at, "weight", AIR_MITSUBA_REFLECTANCE, weight,
                                      &desc->blend_texture);
    desc->model = AIR_MATERIAL_BLEND;
    desc->blend_weight = vec3_mean(vec3_load(weight));
    return status;
}

static air_status read_type(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    if (air_mitsuba_is(at, "diffuse"))
        return read_diffuse(mitsuba, at, desc);
    if (air_mitsuba_is_interface(at))
        return air_mitsuba_read_interface(mitsuba, at, desc);
    if (air_mitsuba_is(at, "twosided"))
        return read_twosided(mitsuba, at, desc);
    if (air_mitsuba_is(at, "mask"))
        return read_mask(mitsuba, at, desc);
    if (air_mitsuba_is(at, "bumpmap") || air_mitsuba_is(at, "normalmap"))
        return read_relief(mitsuba, at, desc);
    if (air_mitsuba_is(at, "blendbsdf"))
        return read_blend(mitsuba, at, desc);
    if (!air_mitsuba_is(at, "null"))
        return replace_bsdf(mitsuba, at, desc);
    desc->model = AIR_MATERIAL_NULL;
    return AIR_OK;
}

air_status air_mitsuba_read_bsdf(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    static const char *const ignored[] = {"ensure_energy_conservation"};
    air_status status = air_mitsuba_enter(mitsuba, at);
    if (status != AIR_OK)
        return status;
    air_mitsuba_ignore(at, ignored, 1);
    status = read_type(mitsuba, at, desc);
    air_mitsuba_leave(mitsuba);
    return status;
}

/* ---- shapes ---- */

/* A shape without a bsdf: a lamp is black; where there is a medium, version 0.x lets rays pass. */
static void set_bare(const air_mitsuba *mitsuba, const air_xml *shape, bool emits,
                     air_material_desc *desc)
{
    const bool medium = air_mitsuba_has(shape, "interior") || air_mitsuba_has(shape, "exterior");
    set_lambert(mitsuba, emits ? 0.0f : 0.5f, desc);
    if (medium && !emits && air_mitsuba_is_old(shape))
        desc->model = AIR_MATERIAL_NULL;
}

static air_status read_emission(air_mitsuba *mitsuba, air_xml *emitter, air_material_desc *desc)
{
    static const char *const ignored[] = {"sampling_weight"};
    desc->emission[0] = desc->emission[1] = desc->emission[2] = 1.0f;
    emitter->asked = true;
    air_mitsuba_ignore(emitter, ignored, 1);
    const air_status status =
        air_mitsuba_textured(mitsuba, emitter, "radiance", AIR_MITSUBA_EMISSION, desc->emission,
                             &desc->emission_texture);
    for (size_t i = 0; i < 3; ++i)
        desc->emission[i] *= mitsuba->emission_scale;
    return status;
}

static bool is_clear(const air_material_desc *desc)
{
    return desc->model == AIR_MATERIAL_NULL || desc->model == AIR_MATERIAL_DIELECTRIC ||
           desc->model == AIR_MATERIAL_THIN_DIELECTRIC || desc->model == AIR_MATERIAL_BLEND ||
           desc->alpha_mode != AIR_ALPHA_OPAQUE;
}

/* What is opaque and not black from behind has two sides, which bakes ask for; but of a lamp the
 * front alone shines. */
static bool has_two_sides(const air_material_desc *desc, bool emits)
{
    return !desc->one_sided && !emits &&
           (desc->model == AIR_MATERIAL_METALLIC_ROUGHNESS ||
            desc->model == AIR_MATERIAL_CONDUCTOR || desc->model == AIR_MATERIAL_PLASTIC);
}

static air_status make_material(air_mitsuba *mitsuba, air_xml *shape, air_xml *bsdf,
                                air_xml *emitter, air_handle *out_handle, bool *out_clear)
{
    air_material_desc desc;
    air_status status = AIR_OK;
    air_material_desc_default(&desc);
    desc.name = bsdf != NULL ? air_mitsuba_name(bsdf) : "bare";
    if (bsdf != NULL)
        status = air_mitsuba_read_bsdf(mitsuba, bsdf, &desc);
    else
        set_bare(mitsuba, shape, emitter != NULL, &desc);
    if (status == AIR_OK && emitter != NULL)
        status = read_emission(mitsuba, emitter, &desc);
    if (status != AIR_OK)
        return status;
    desc.double_sided = has_two_sides(&desc, emitter != NULL);
    *out_clear = is_clear(&desc);
    *out_handle = AIR_NONE;
    if (desc.model == AIR_MATERIAL_NULL && emitter == NULL)
        return AIR_OK;
    status = air_scene_add_material(mitsuba->import->scene, &desc, out_handle);
    return status == AIR_OK
               ? status
               : air_xml_place_error(&mitsuba->document, bsdf != NULL ? bsdf : shape, status);
}

air_status air_mitsuba_material(air_mitsuba *mitsuba, air_xml *shape, air_handle *out_handle,
                                bool *out_clear)
{
    air_xml *bsdf = NULL, *emitter = NULL;
    air_status status = air_mitsuba_child(mitsuba, shape, "bsdf", NULL, &bsdf);
    if (status == AIR_OK)
        status = air_mitsuba_child(mitsuba, shape, "emitter", NULL, &emitter);
    if (status != AIR_OK)
        return status;
    if (emitter != NULL && !air_mitsuba_is(emitter, "area"))
        emitter = NULL; /* it makes a light of its own */
    air_xml *at = bsdf != NULL ? bsdf : shape;
    const air_xml *with = emitter != NULL ? emitter : mitsuba->scene;
    air_mitsuba_made *made = air_mitsuba_find_made(at, with);
    if (made == NULL) {
        bool clear = false;
        air_handle handle = AIR_NONE;
        status = make_material(mitsuba, shape, bsdf, emitter, &handle, &clear);
        if (status != AIR_OK)
            return status;
        made = air_mitsuba_note_made(mitsuba, at, with, handle);
        if (made == NULL)
            return AIR_ERROR_MEMORY;
        made->clear = clear;
    }
    *out_handle = made->handle;
    *out_clear = made->clear;
    return AIR_OK;
}

/* material.h: materials: checking, and the form that snapshots hold. */
#ifndef AIR_SCENE_MATERIAL_H
#define AIR_SCENE_MATERIAL_H

#include "scene/record.h"
#include "scene/snapshot.h"

/* The texture references of a description come first among its links. */
enum { AIR_MATERIAL_TEXTURES = 8 };

typedef struct air_material_record {
    air_record base;
    air_material_desc desc; /* name is the record's */
    air_plastic_table plastic;
} air_material_record;

/* What files and reports call the models, in the order of air_material_model. */
enum { AIR_MATERIAL_MODELS = AIR_MATERIAL_NULL + 1 };
extern const char *const air_material_model_names[AIR_MATERIAL_MODELS];

/* Checks and copies a description; handles are not looked at. */
air_status air_material_record_create(air_context *context, const air_material_desc *desc,
                                      air_record **out_record);

/* The textures and materials it refers to: AIR_MAX_LINKS of them, AIR_NONE among them. */
void air_material_links(const air_material_desc *desc, air_link out_links[AIR_MAX_LINKS]);

/* Are two descriptions the same but for the name? */
bool air_material_equal(const air_material_desc *a, const air_material_desc *b);
/* Do two that both emit give the same light table entries? */
bool air_material_emission_equal(const air_material_desc *a, const air_material_desc *b);

/* The form that snapshots hold; blended materials are left to them. textures: those of
 * air_material_links, in its order. colored: a
 * mesh of this material has vertex colours, so that coverage may vary even without a texture.
 * Without anything that could make coverage less than 1, MASK and BLEND become OPAQUE. */
void air_material_init(const air_material_record *record,
                       const air_texture *const textures[AIR_MATERIAL_TEXTURES], bool colored,
                       air_material *out_material);

/* Is a mesh of this material a light, with entries in the light table? Surfaces with coverage are
 * left out: rays meet their emission, but no point on them is sampled, since a sampled point would
 * not know its coverage. */
static inline bool air_material_is_emitter(const air_material *material)
{
    return !material->unlit && material->alpha_mode == AIR_ALPHA_OPAQUE &&
           !vec3_is_zero(material->emission);
}

/* May light pass surfaces of this material, apart from their coverage? */
static inline bool air_material_lets_through(const air_material *material)
{
    return material->model == AIR_MATERIAL_DIELECTRIC ||
           material->model == AIR_MATERIAL_THIN_DIELECTRIC ||
           material->model == AIR_MATERIAL_BLEND || material->model == AIR_MATERIAL_NULL ||
           material->transmission > 0.0f;
}

#endif

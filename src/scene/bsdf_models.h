/* bsdf_models.h: the models behind bsdf.h. Callers have seen that wo is above the surface, and that
 * wi is on one side of it for both normals. */
#ifndef AIR_SCENE_BSDF_MODELS_H
#define AIR_SCENE_BSDF_MODELS_H

#include "scene/bsdf.h"

/* ---- Lambert under GGX; directions in world space, wi above ---- */

void air_metallic_make(const air_bsdf_input *input, air_bsdf *out);
air_vec3 air_metallic_eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
air_vec3 air_metallic_eval_smooth(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
air_vec3 air_metallic_eval_parts(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi,
                                 air_vec3 *out_smooth);
air_vec3 air_metallic_albedo(const air_bsdf *bsdf, air_vec3 wo);
air_vec3 air_metallic_take_base(air_bsdf *bsdf, air_vec3 wo);
float air_metallic_sample_pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
bool air_metallic_sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                         air_vec3 *out_weight, float *out_pdf);

/* ---- the others; directions in the shading frame ---- */

/* One model: f |cos|, its part without a highlight, the density of sample (delta lobes have none),
 * and a sample, whose density is 0 where it is of a delta lobe. */
typedef struct air_bsdf_model {
    air_vec3 (*eval)(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
    float (*pdf)(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
    bool (*sample)(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                   air_vec3 *out_weight, float *out_pdf);
    /* What is reflected altogether; of rough facets as of smooth ones. */
    air_vec3 (*albedo)(const air_bsdf *bsdf, float cos_o);
} air_bsdf_model;

extern const air_bsdf_model air_dielectric, air_conductor, air_plastic;

/* PLASTIC: its base, and what that reflects. */
void air_plastic_make_base(const air_bsdf_input *input, air_bsdf *out);
air_vec3 air_plastic_eval_base(const air_bsdf *bsdf, float cos_o, float cos_i);

#endif

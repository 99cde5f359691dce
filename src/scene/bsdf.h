/* bsdf.h: how a surface reflects light and lets it through.
 *
 * wo points towards where the light goes to (the camera side), wi towards where it comes from; both
 * unit, world space, pointing away from the surface.
 *
 * METALLIC_ROUGHNESS has three lobes: GGX with Schlick's Fresnel term; what GGX loses to multiple
 * scattering between its facets, given back as in [Kulla2017]; and a Lambert base under them,
 * dimmed by what they reflect on the way in and out. Each is reciprocal, and together they never
 * reflect more than they receive. Inputs are clamped to their ranges for that.
 *
 * The other models are those of the field's renderers: exact Fresnel terms, facets that scatter
 * once (what they scatter again is lost), and light that is let through. Smooth ones have delta
 * lobes: eval and sample_pdf know nothing of those, sample says so by a density of 0. */
#ifndef AIR_SCENE_BSDF_H
#define AIR_SCENE_BSDF_H

#include "scene/optics.h"

typedef struct air_bsdf {
    air_material_model model;
    air_frame frame;      /* shading frame; frame.n on the side of wo */
    air_vec3 normal;      /* geometric normal on the side of wo */
    air_vec3 diffuse;     /* albedo of the Lambert part, already without the metallic share */
    air_vec3 f0;          /* specular reflectance at normal incidence; 0: pure Lambert */
    float f90;            /* specular reflectance at grazing incidence; see air_bsdf_make */
    float alpha;          /* GGX alpha = roughness^2, clamped to at least 0.001: roughness 0.0316 */
    float alpha_axis;     /* alpha on the axis of the albedo tables */
    air_vec3 multiple;    /* Fresnel factor of multiple scattering */
    float multiple_scale; /* f = multiple multiple_scale loss(wo) loss(wi) */
    air_vec3 diffuse_scale; /* f = diffuse_scale (1 - E(wo)) (1 - E(wi)) */
    float specular_share;   /* probability of sampling the GGX lobe, for the wo it was made for */
    /* The other models; of the above diffuse, f0 and f90 are sensible, diffuse_scale is PLASTIC's.
     */
    air_facets facets;
    float ior;   /* index beyond the surface over that on the side of wo */
    bool single; /* THIN_DIELECTRIC: of one interface, without what is reflected inside the pane */
    air_vec3 reflectance, transmittance;
    const air_optics *optics; /* borrowed */
} air_bsdf;

typedef struct air_bsdf_input {
    air_material_model model; /* not BLEND, not NULL */
    air_vec3 base_color;
    float metallic, roughness, specular;
    float ior;                                 /* of DIELECTRIC: inside over outside */
    air_vec3 shading_normal, geometric_normal; /* unit; the geometric one points outside */
    air_vec3 tangent; /* what alpha_u is along, any length; 0: any direction */
    air_vec3 wo;
    bool one_sided; /* reflects nothing behind the geometric normal; not of dielectrics */
    bool single;
    air_facets facets; /* of what follows the model METALLIC_ROUGHNESS needs nothing */
    air_vec3 reflectance, transmittance;
    const air_optics *optics; /* CONDUCTOR, PLASTIC: borrowed as long as the result is used */
} air_bsdf_input;

/* Normals are turned to the side of wo, the shading normal to that of the geometric one; where it
 * still faces away from wo, it is bent towards wo until it just does not. Dielectric f0 =
 * ((ior-1)/(ior+1))^2 specular, mixed with base_color by metallic; f90 is 1, but falls to 0 with f0
 * below 2 %, less than any common dielectric has. */
void air_bsdf_make(const air_bsdf_input *input, air_bsdf *out);

/* f(wo, wi) |cos(wi, n)| with the shading normal; 0 if wo is below the geometric or the shading
 * surface, or wi below one of them, of models that let light through below one only. What passes
 * into another index is radiance, which grows by the square of the index [Walter2007, eq. 21]. */
air_vec3 air_bsdf_eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
/* What of it has no highlight: the base, and multiple scattering between facets. */
air_vec3 air_bsdf_eval_smooth(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
/* Both, for little more than the first. */
air_vec3 air_bsdf_eval_parts(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi, air_vec3 *out_smooth);
/* The directional-hemispherical reflectance: the integral of f cos over all wi above, where the
 * shading normal is the geometric one. Exact for Lambert, else of METALLIC_ROUGHNESS as good as the
 * albedo tables: at most 0.0025 too dark or bright; of other models as if facets lost nothing. wo
 * must be above the surface; 0 if it is not. */
air_vec3 air_bsdf_albedo(const air_bsdf *bsdf, air_vec3 wo);
/* METALLIC_ROUGHNESS: takes the Lambert base away and returns its directional-hemispherical
 * reflectance, exact for Lambert, else as air_bsdf_albedo. What is left reflects by facets only;
 * nothing, where there was a base alone. Other models keep all, and 0 is returned. wo must be above
 * the surface. */
air_vec3 air_bsdf_take_base(air_bsdf *bsdf, air_vec3 wo);
/* Does it neither reflect nor let through anything? */
bool air_bsdf_is_black(const air_bsdf *bsdf);
/* By how much radiance from wi is less on the side of wo, for its index alone; 1 but of light that
 * a DIELECTRIC bends. */
static inline float air_bsdf_radiance_factor(const air_bsdf *bsdf, air_vec3 wi)
{
    const bool bent = bsdf->model == AIR_MATERIAL_DIELECTRIC && vec3_dot(wi, bsdf->normal) < 0.0f;
    return bent ? 1.0f / (bsdf->ior * bsdf->ior) : 1.0f;
}
/* Density of air_bsdf_sample per solid angle. */
float air_bsdf_sample_pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi);
/* u: three numbers in [0,1). Returns false if nothing is reflected; *out_weight = f cos / pdf.
 * *out_pdf 0: one of finitely many directions, and the weight is what comes from it over the
 * probability that it was chosen. */
bool air_bsdf_sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                     air_vec3 *out_weight, float *out_pdf);

#endif

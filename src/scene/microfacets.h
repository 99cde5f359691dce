/* microfacets.h: rough surfaces as small facets: distributions of their normals, how they hide each
 * other, and sampling those that can be seen [Walter2007; Heitz2014].
 *
 * Directions are in the frame of the surface, z along its normal; h is a facet's normal, unit, h.z
 * > 0. */
#ifndef AIR_SCENE_MICROFACETS_H
#define AIR_SCENE_MICROFACETS_H

#include "airlight/scene.h"
#include "core/vec.h"

typedef struct air_facets {
    air_microfacets distribution;
    float alpha_u, alpha_v; /* both 0: the surface is smooth */
} air_facets;

/* Widths as they are used: below 1e-4 a lobe is narrower than floats resolve, and the surface is
 * smooth; where only one width is, it is raised to that. */
air_facets air_facets_make(air_microfacets distribution, float alpha_u, float alpha_v);

static inline bool air_facets_smooth(const air_facets *facets) { return facets->alpha_u == 0.0f; }

/* The density of normals per solid angle, over the surface's area. */
float air_facets_density(const air_facets *facets, air_vec3 h);
/* The share of facets of one normal that is seen from w (Smith); 0 where w sees their back. */
float air_facets_seen(const air_facets *facets, air_vec3 w, air_vec3 h);
/* A normal in proportion to what is seen of it from w, w.z > 0. Its density is density seen |w.h| /
 * w.z. */
air_vec3 air_facets_sample(const air_facets *facets, air_vec3 w, float u1, float u2);

/* That density. */
static inline float air_facets_sample_pdf(const air_facets *facets, air_vec3 w, air_vec3 h)
{
    return air_facets_density(facets, h) * air_facets_seen(facets, w, h) * fabsf(vec3_dot(w, h)) /
           w.z;
}

/* The density per solid angle of directions that facets so drawn reflect to, wi.z > 0; *out_h: the
 * facet's normal. */
static inline float air_facets_reflect_pdf(const air_facets *facets, air_vec3 wo, air_vec3 wi,
                                           air_vec3 *out_h)
{
    *out_h = vec3_normalize(vec3_add(wo, wi));
    return air_facets_sample_pdf(facets, wo, *out_h) * 0.25f / vec3_dot(wo, *out_h);
}

#endif

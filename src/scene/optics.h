/* optics.h: what materials other than METALLIC_ROUGHNESS are made of, as snapshots hold it. */
#ifndef AIR_SCENE_OPTICS_H
#define AIR_SCENE_OPTICS_H

#include "scene/microfacets.h"

enum { AIR_PLASTIC_ROWS = 32 };

/* PLASTIC: what its interface lets through. */
typedef struct air_plastic_table {
    float internal; /* reflectance of the interface from inside, of light that fills directions */
    /* Rough: transmittance from outside, over the cosine in equal steps from 0 to 1. */
    float passed[AIR_PLASTIC_ROWS];
} air_plastic_table;

typedef struct air_optics {
    air_facets facets;
    air_vec3 reflectance, transmittance;
    air_vec3 eta, absorption;
    bool nonlinear;
    const air_plastic_table *plastic; /* borrowed */
} air_optics;

void air_plastic_table_make(const air_facets *facets, float ior, air_plastic_table *out);

#endif

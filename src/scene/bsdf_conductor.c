/* bsdf_conductor.c: metals by their complex index of refraction. Directions are local to the
 * shading frame, wo.z > 0. */
#include "scene/bsdf_models.h"
#include "scene/fresnel.h"

static air_vec3 reflected(const air_bsdf *bsdf, float cos_o)
{
    const air_vec3 eta = bsdf->optics->eta, absorption = bsdf->optics->absorption;
    const float c = float_min(cos_o, 1.0f);
    return vec3_mul(bsdf->reflectance, vec3(air_fresnel_conductor(c, eta.x, absorption.x),
                                            air_fresnel_conductor(c, eta.y, absorption.y),
                                            air_fresnel_conductor(c, eta.z, absorption.z)));
}

/* 0 without a normal where no facets reflect to wi. */
static float pdf_and_normal(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi, air_vec3 *out_h)
{
    if (air_facets_smooth(&bsdf->facets) || !(wi.z > 0.0f)) {
        return 0.0f;
    }
    return air_facets_reflect_pdf(&bsdf->facets, wo, wi, out_h);
}

static float pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    air_vec3 h;
    return pdf_and_normal(bsdf, wo, wi, &h);
}

static air_vec3 eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    air_vec3 h;
    const float density = pdf_and_normal(bsdf, wo, wi, &h);
    if (density == 0.0f) {
        return vec3_set1(0.0f);
    }
    return vec3_scale(reflected(bsdf, vec3_dot(wo, h)),
                      density * air_facets_seen(&bsdf->facets, wi, h));
}

static bool sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                   air_vec3 *out_weight, float *out_pdf)
{
    if (air_facets_smooth(&bsdf->facets)) {
        *out_wi = vec3(-wo.x, -wo.y, wo.z);
        *out_weight = reflected(bsdf, wo.z);
        *out_pdf = 0.0f;
        return true;
    }
    const air_vec3 h = air_facets_sample(&bsdf->facets, wo, u[0], u[1]);
    const air_vec3 wi = air_reflect(wo, h);
    *out_wi = wi;
    *out_pdf = pdf(bsdf, wo, wi);
    *out_weight =
        vec3_scale(reflected(bsdf, vec3_dot(wo, h)), air_facets_seen(&bsdf->facets, wi, h));
    return *out_pdf > 0.0f;
}

static air_vec3 albedo(const air_bsdf *bsdf, float cos_o) { return reflected(bsdf, cos_o); }

const air_bsdf_model air_conductor = {eval, pdf, sample, albedo};

/* bsdf_plastic.c: a Lambert base below the interface of a dielectric, smooth or rough. Light passes
 * the interface on the way in and out, and is reflected at it from inside any number of times: the
 * base's share of what it gets there is a geometric series. The model of Mitsuba's `plastic` and
 * `roughplastic`. Directions are local to the shading frame, wo.z > 0. */
#include "core/quadrature.h"
#include "core/warp.h"
#include "scene/bsdf_models.h"
#include "scene/fresnel.h"

/* ---- tables ---- */

/* What facets let through of light from w, or reflect: the mean over those that are seen of it.
 * Light that then meets another facet is lost. */
static double facets_mean(const air_facets *facets, float ior, float cos_o, bool through)
{
    enum { STEPS = 24 };
    const air_vec3 w = vec3(sqrtf((1.0f - cos_o) * (1.0f + cos_o)), 0.0f, cos_o);
    double sum = 0.0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        const float u1 = ((float)(i / STEPS) + 0.5f) / STEPS;
        const float u2 = ((float)(i % STEPS) + 0.5f) / STEPS;
        const air_vec3 h = air_facets_sample(facets, w, u1, u2);
        const float cos_h = float_min(vec3_dot(w, h), 1.0f);
        float cos_out;
        const float fresnel = air_fresnel_dielectric(cos_h, ior, &cos_out);
        const air_vec3 out = through ? air_refract(w, h, cos_h, cos_out, ior) : air_reflect(w, h);
        if (cos_h > 0.0f && (through ? out.z < 0.0f : out.z > 0.0f)) {
            sum += (double)((through ? 1.0f - fresnel : fresnel) * air_facets_seen(facets, out, h));
        }
    }
    return sum / (STEPS * STEPS);
}

/* Reflectance from inside of light that fills directions evenly: twice the integral of R cos over
 * the cosine. Above the critical angle R rises as a square root, which squared nodes take up; below
 * it is 1 but for roughness. */
static double internal_reflectance(const air_facets *facets, float ior)
{
    enum { NODES = 16 };
    double nodes[NODES], weights[NODES], sum = 0.0;
    const double critical = ior > 1.0f ? sqrt(1.0 - 1.0 / ((double)ior * (double)ior)) : 0.0;
    air_gauss_legendre(NODES, nodes, weights);
    for (int i = 0; i < 2 * NODES; i++) {
        const double s = 0.5 * (1.0 + nodes[i / 2]), weight = weights[i / 2];
        const double cosine = i % 2 == 0 ? critical * s : critical + (1.0 - critical) * s * s;
        const double scale = i % 2 == 0 ? critical : (1.0 - critical) * 2.0 * s;
        float cos_out;
        const double reflected =
            air_facets_smooth(facets)
                ? (double)air_fresnel_dielectric((float)cosine, 1.0f / ior, &cos_out)
                : facets_mean(facets, 1.0f / ior, float_max((float)cosine, 1e-3f), false);
        sum += weight * scale * cosine * reflected;
    }
    return sum;
}

void air_plastic_table_make(const air_facets *facets, float ior, air_plastic_table *out)
{
    /* high indices leave less than floats tell from nothing, and what leaves is divided by */
    out->internal = (float)double_min(internal_reflectance(facets, ior), 1.0 - 1e-6);
    for (int i = 0; i < AIR_PLASTIC_ROWS && !air_facets_smooth(facets); i++) {
        const float cos_o = (float)i / (AIR_PLASTIC_ROWS - 1);
        out->passed[i] = (float)facets_mean(facets, ior, float_max(cos_o, 1e-3f), true);
    }
}

/* Transmittance of the interface from outside. */
static float passed(const air_bsdf *bsdf, float cosine)
{
    const float c = float_min(cosine, 1.0f);
    if (air_facets_smooth(&bsdf->facets)) {
        float cos_out;
        return 1.0f - air_fresnel_dielectric(c, bsdf->ior, &cos_out);
    }
    const float at = c * (AIR_PLASTIC_ROWS - 1);
    const int row = at < AIR_PLASTIC_ROWS - 2 ? (int)at : AIR_PLASTIC_ROWS - 2;
    const float *table = bsdf->optics->plastic->passed;
    return table[row] + (at - (float)row) * (table[row + 1] - table[row]);
}

/* ---- the model ---- */

static air_vec3 reflected(const air_bsdf *bsdf, float cos_o)
{
    float cos_out;
    const float c = float_min(cos_o, 1.0f);
    return vec3_scale(bsdf->reflectance, air_fresnel_dielectric(c, bsdf->ior, &cos_out));
}

/* What leaves of light that has entered, of one colour: base (1 - internal) / (1 - again internal),
 * where light that is reflected inside finds the base white unless nonlinear. */
static float base_share(const air_optics *optics, float base)
{
    const float internal = optics->plastic->internal;
    const float again = optics->nonlinear ? base : 1.0f;
    return base * (1.0f - internal) / (1.0f - again * internal);
}

void air_plastic_make_base(const air_bsdf_input *input, air_bsdf *out)
{
    const float cos_o = vec3_dot(input->wo, out->frame.n), ior2 = input->ior * input->ior;
    const air_vec3 base = input->base_color;
    const air_vec3 share = vec3(base_share(out->optics, base.x), base_share(out->optics, base.y),
                                base_share(out->optics, base.z));
    const float left = 1.0f - out->optics->plastic->internal;
    out->f0 = reflected(out, 1.0f);
    out->diffuse = vec3_scale(share, passed(out, cos_o));
    /* the cosine-weighted mean of what passes from outside is ior^2 (1 - internal) */
    out->diffuse_scale = vec3_scale(share, 1.0f / (AIR_PI_F * ior2 * left));
    const float highlight = vec3_mean(reflected(out, cos_o)), whole = vec3_mean(out->diffuse);
    out->specular_share = highlight + whole > 0.0f ? highlight / (highlight + whole) : 0.0f;
}

air_vec3 air_plastic_eval_base(const air_bsdf *bsdf, float cos_o, float cos_i)
{
    return vec3_scale(bsdf->diffuse_scale, passed(bsdf, cos_o) * passed(bsdf, cos_i) * cos_i);
}

static air_vec3 eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (!(wi.z > 0.0f)) {
        return vec3_set1(0.0f);
    }
    const air_vec3 base = air_plastic_eval_base(bsdf, wo.z, wi.z);
    if (air_facets_smooth(&bsdf->facets)) {
        return base;
    }
    air_vec3 h;
    const float density = air_facets_reflect_pdf(&bsdf->facets, wo, wi, &h);
    return vec3_madd(base, density * air_facets_seen(&bsdf->facets, wi, h),
                     reflected(bsdf, vec3_dot(wo, h)));
}

static float pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    air_vec3 h;
    const float base = (1.0f - bsdf->specular_share) * sample_cosine_hemisphere_pdf(wi.z);
    if (air_facets_smooth(&bsdf->facets) || !(wi.z > 0.0f)) {
        return base;
    }
    return base + bsdf->specular_share * air_facets_reflect_pdf(&bsdf->facets, wo, wi, &h);
}

static bool sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                   air_vec3 *out_weight, float *out_pdf)
{
    const bool smooth = air_facets_smooth(&bsdf->facets);
    const bool highlight = u[2] < bsdf->specular_share;
    if (highlight && smooth) {
        *out_wi = vec3(-wo.x, -wo.y, wo.z);
        *out_weight = vec3_scale(reflected(bsdf, wo.z), 1.0f / bsdf->specular_share);
        *out_pdf = 0.0f;
        return true;
    }
    *out_wi = highlight ? air_reflect(wo, air_facets_sample(&bsdf->facets, wo, u[0], u[1]))
                        : sample_cosine_hemisphere(u[0], u[1]);
    *out_pdf = pdf(bsdf, wo, *out_wi);
    *out_weight = vec3_scale(eval(bsdf, wo, *out_wi), 1.0f / *out_pdf);
    return out_wi->z > 0.0f && *out_pdf > 0.0f;
}

static air_vec3 albedo(const air_bsdf *bsdf, float cos_o)
{
    const float left = 1.0f - bsdf->optics->plastic->internal, ior2 = bsdf->ior * bsdf->ior;
    return vec3_madd(reflected(bsdf, cos_o), AIR_PI_F * ior2 * left * passed(bsdf, cos_o),
                     bsdf->diffuse_scale);
}

const air_bsdf_model air_plastic = {eval, pdf, sample, albedo};

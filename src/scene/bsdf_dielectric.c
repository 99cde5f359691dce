/* bsdf_dielectric.c: interfaces between dielectrics, and panes [Walter2007]. What passes an
 * interface is radiance, which grows by the square of the index: from the camera's side f has 1 /
 * ior^2. What passes a pane leaves as it came, mirrored from what is reflected.
 *
 * Directions are local to the shading frame, wo.z > 0. */
#include "scene/bsdf_models.h"
#include "scene/fresnel.h"

/* One facet as seen from wo. */
typedef struct facet {
    air_vec3 h;
    float cos_o;   /* wo . h */
    float cos_out; /* of the refracted direction */
    float fresnel; /* reflected share */
    float chosen;  /* probability with which sampling reflects */
} facet;

static bool is_pane(const air_bsdf *bsdf) { return bsdf->model == AIR_MATERIAL_THIN_DIELECTRIC; }

/* Of a pane both interfaces together: R + T^2 R + T^2 R^3 + ... = 2 R / (1 + R). */
static float reflected_share(const air_bsdf *bsdf, float cos_o, float *out_cos)
{
    const float once = air_fresnel_dielectric(float_min(cos_o, 1.0f), bsdf->ior, out_cos);
    return is_pane(bsdf) && !bsdf->single ? 2.0f * once / (1.0f + once) : once;
}

static facet facet_make(const air_bsdf *bsdf, air_vec3 wo, air_vec3 h)
{
    facet out = {.h = h, .cos_o = vec3_dot(wo, h)};
    out.fresnel = reflected_share(bsdf, out.cos_o, &out.cos_out);
    const float reflected = out.fresnel * vec3_mean(bsdf->reflectance);
    const float passed = (1.0f - out.fresnel) * vec3_mean(bsdf->transmittance);
    out.chosen = reflected + passed > 0.0f ? reflected / (reflected + passed) : 0.0f;
    return out;
}

static air_vec3 mirrored(air_vec3 w) { return vec3(w.x, w.y, -w.z); }

/* Does light pass the surface bent? */
static bool bends(const air_bsdf *bsdf, air_vec3 wi) { return wi.z < 0.0f && !is_pane(bsdf); }

/* The facet that sends light from wi to wo; its normal on the side of wo. False if none does. */
static bool find_facet(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi, facet *out)
{
    air_vec3 h = vec3_add(wo, wi.z < 0.0f ? mirrored(wi) : wi);
    if (bends(bsdf, wi)) {
        h = vec3_madd(wo, bsdf->ior, wi);
        h = h.z < 0.0f ? vec3_neg(h) : h;
    }
    *out = facet_make(bsdf, wo, vec3_normalize(h));
    return out->cos_o > 0.0f && (!bends(bsdf, wi) || vec3_dot(wi, out->h) < 0.0f);
}

/* ior^2 |wi . h| / (ior wi . h + wo . h)^2: how densely refracted directions lie against normals
 * [Walter2007, eq. 17]. */
static float spread(const air_bsdf *bsdf, const facet *f, air_vec3 wi)
{
    const float cos_i = vec3_dot(wi, f->h), sum = bsdf->ior * cos_i + f->cos_o;
    return bsdf->ior * bsdf->ior * fabsf(cos_i) / (sum * sum);
}

/* The density with which sampling facets gives wi, without the choice of what happens there. */
static float direction_density(const air_bsdf *bsdf, const facet *f, air_vec3 wo, air_vec3 wi)
{
    return air_facets_sample_pdf(&bsdf->facets, wo, f->h) *
           (bends(bsdf, wi) ? spread(bsdf, f, wi) : 0.25f / f->cos_o);
}

/* What a facet sends from wi to wo, of what it gets: hidden facets do not get anything. */
static air_vec3 factor(const air_bsdf *bsdf, const facet *f, air_vec3 wi)
{
    const float seen =
        air_facets_smooth(&bsdf->facets)
            ? 1.0f
            : air_facets_seen(&bsdf->facets, wi.z < 0.0f && !bends(bsdf, wi) ? mirrored(wi) : wi,
                              f->h);
    const float radiance = bends(bsdf, wi) ? 1.0f / (bsdf->ior * bsdf->ior) : 1.0f;
    return wi.z < 0.0f ? vec3_scale(bsdf->transmittance, (1.0f - f->fresnel) * (seen * radiance))
                       : vec3_scale(bsdf->reflectance, f->fresnel * seen);
}

static air_vec3 eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    facet f;
    if (air_facets_smooth(&bsdf->facets) || !find_facet(bsdf, wo, wi, &f)) {
        return vec3_set1(0.0f);
    }
    return vec3_scale(factor(bsdf, &f, wi), direction_density(bsdf, &f, wo, wi));
}

static float pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    facet f;
    if (air_facets_smooth(&bsdf->facets) || !find_facet(bsdf, wo, wi, &f)) {
        return 0.0f;
    }
    const float chosen = wi.z < 0.0f ? 1.0f - f.chosen : f.chosen;
    return chosen * direction_density(bsdf, &f, wo, wi);
}

static bool sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                   air_vec3 *out_weight, float *out_pdf)
{
    const bool smooth = air_facets_smooth(&bsdf->facets);
    const facet f = facet_make(bsdf, wo,
                               smooth ? vec3(0.0f, 0.0f, 1.0f)
                                      : air_facets_sample(&bsdf->facets, wo, u[0], u[1]));
    const bool reflects = u[2] < f.chosen;
    const float chosen = reflects ? f.chosen : 1.0f - f.chosen;
    air_vec3 wi = air_reflect(wo, f.h);
    if (!reflects) {
        wi = is_pane(bsdf) ? mirrored(wi) : air_refract(wo, f.h, f.cos_o, f.cos_out, bsdf->ior);
    }
    if (!(f.cos_o > 0.0f) || (reflects ? !(wi.z > 0.0f) : !(wi.z < 0.0f))) {
        return false;
    }
    *out_wi = wi;
    *out_weight = vec3_scale(factor(bsdf, &f, wi), 1.0f / chosen);
    *out_pdf = smooth ? 0.0f : chosen * direction_density(bsdf, &f, wo, wi);
    return (smooth || *out_pdf > 0.0f) && !vec3_is_zero(*out_weight);
}

static air_vec3 albedo(const air_bsdf *bsdf, float cos_o)
{
    float cos_out;
    return vec3_scale(bsdf->reflectance, reflected_share(bsdf, cos_o, &cos_out));
}

const air_bsdf_model air_dielectric = {eval, pdf, sample, albedo};

/* bsdf.c: see bsdf.h: sides of the surface, and which model answers. */
#include "scene/bsdf.h"

#include "scene/bsdf_models.h"

static const air_bsdf_model *model_of(const air_bsdf *bsdf)
{
    switch (bsdf->model) {
    case AIR_MATERIAL_CONDUCTOR:
        return &air_conductor;
    case AIR_MATERIAL_PLASTIC:
        return &air_plastic;
    default:
        return &air_dielectric;
    }
}

static bool is_metallic(const air_bsdf *bsdf)
{
    return bsdf->model == AIR_MATERIAL_METALLIC_ROUGHNESS;
}

/* ---- making ---- */

static void make_frame(const air_bsdf_input *input, air_bsdf *out)
{
    const float side = vec3_dot(input->geometric_normal, input->wo) < 0.0f ? -1.0f : 1.0f;
    out->normal = vec3_scale(input->geometric_normal, side);
    air_vec3 n = input->shading_normal;
    if (vec3_dot(n, out->normal) < 0.0f) {
        n = vec3_neg(n);
    }
    const float cos_min = 1e-3f;
    const float cos_o = vec3_dot(n, input->wo);
    if (cos_o < cos_min) {
        n = vec3_normalize(vec3_madd(n, cos_min - cos_o, input->wo));
    }
    out->frame = frame_from_normal(n);
}

/* Turns the frame about its normal. */
static void turn_frame(air_vec3 tangent, air_frame *frame)
{
    const air_vec3 flat = vec3_madd(tangent, -vec3_dot(tangent, frame->n), frame->n);
    const float length = vec3_length(flat);
    if (length > 0.0f) {
        frame->s = vec3_scale(flat, 1.0f / length);
        frame->t = vec3_cross(frame->n, frame->s);
    }
}

static void make_facets(const air_bsdf_input *input, bool front, air_bsdf *out)
{
    const bool refracts = input->model == AIR_MATERIAL_DIELECTRIC;
    out->facets = input->facets;
    out->ior = front || !refracts ? input->ior : 1.0f / input->ior;
    out->single = input->single;
    out->reflectance = input->reflectance;
    out->transmittance = input->transmittance;
    out->optics = input->optics;
    out->f0 = vec3_set1(1.0f);
    out->f90 = 1.0f;
    if (refracts && fabsf(input->ior - 1.0f) < 1e-4f) {
        out->facets.alpha_u = out->facets.alpha_v = 0.0f; /* facets of nothing turn no light */
    }
    if (out->facets.alpha_u != out->facets.alpha_v) {
        turn_frame(input->tangent, &out->frame);
    }
    if (input->model == AIR_MATERIAL_CONDUCTOR) {
        out->f0 = air_conductor.albedo(out, 1.0f);
    }
    if (input->model == AIR_MATERIAL_PLASTIC) {
        air_plastic_make_base(input, out);
    }
}

void air_bsdf_make(const air_bsdf_input *input, air_bsdf *out)
{
    const bool front = vec3_dot(input->geometric_normal, input->wo) >= 0.0f;
    const bool dielectric =
        input->model == AIR_MATERIAL_DIELECTRIC || input->model == AIR_MATERIAL_THIN_DIELECTRIC;
    *out = (air_bsdf){.alpha = 1.0f};
    make_frame(input, out);
    if (input->one_sided && !front && !dielectric) {
        return; /* black */
    }
    out->model = input->model;
    if (is_metallic(out)) {
        air_metallic_make(input, out);
    } else {
        make_facets(input, front, out);
    }
}

/* ---- asking ---- */

static bool above(const air_bsdf *bsdf, air_vec3 w)
{
    return vec3_dot(w, bsdf->frame.n) > 0.0f && vec3_dot(w, bsdf->normal) > 0.0f;
}

/* Is wi on one side for both normals? */
static bool clear(const air_bsdf *bsdf, air_vec3 wi)
{
    return vec3_dot(wi, bsdf->frame.n) * vec3_dot(wi, bsdf->normal) > 0.0f;
}

air_vec3 air_bsdf_eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (is_metallic(bsdf)) {
        return above(bsdf, wo) && above(bsdf, wi) ? air_metallic_eval(bsdf, wo, wi)
                                                  : vec3_set1(0.0f);
    }
    return above(bsdf, wo) && clear(bsdf, wi)
               ? model_of(bsdf)->eval(bsdf, frame_to_local(&bsdf->frame, wo),
                                      frame_to_local(&bsdf->frame, wi))
               : vec3_set1(0.0f);
}

air_vec3 air_bsdf_eval_smooth(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (bsdf->model == AIR_MATERIAL_PLASTIC && above(bsdf, wo) && above(bsdf, wi)) {
        return air_plastic_eval_base(bsdf, vec3_dot(wo, bsdf->frame.n),
                                     vec3_dot(wi, bsdf->frame.n));
    }
    return is_metallic(bsdf) && above(bsdf, wo) && above(bsdf, wi)
               ? air_metallic_eval_smooth(bsdf, wo, wi)
               : vec3_set1(0.0f);
}

air_vec3 air_bsdf_eval_parts(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi, air_vec3 *out_smooth)
{
    if (is_metallic(bsdf) && above(bsdf, wo) && above(bsdf, wi)) {
        return air_metallic_eval_parts(bsdf, wo, wi, out_smooth);
    }
    *out_smooth = air_bsdf_eval_smooth(bsdf, wo, wi);
    return air_bsdf_eval(bsdf, wo, wi);
}

air_vec3 air_bsdf_albedo(const air_bsdf *bsdf, air_vec3 wo)
{
    if (!above(bsdf, wo)) {
        return vec3_set1(0.0f);
    }
    return is_metallic(bsdf)
               ? air_metallic_albedo(bsdf, wo)
               : model_of(bsdf)->albedo(bsdf, float_min(vec3_dot(wo, bsdf->frame.n), 1.0f));
}

air_vec3 air_bsdf_take_base(air_bsdf *bsdf, air_vec3 wo)
{
    return is_metallic(bsdf) ? air_metallic_take_base(bsdf, wo) : vec3_set1(0.0f);
}

bool air_bsdf_is_black(const air_bsdf *bsdf)
{
    return is_metallic(bsdf) && bsdf->f90 == 0.0f && vec3_is_zero(bsdf->diffuse);
}

float air_bsdf_sample_pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (is_metallic(bsdf)) {
        return above(bsdf, wo) && above(bsdf, wi) ? air_metallic_sample_pdf(bsdf, wo, wi) : 0.0f;
    }
    return above(bsdf, wo) && clear(bsdf, wi)
               ? model_of(bsdf)->pdf(bsdf, frame_to_local(&bsdf->frame, wo),
                                     frame_to_local(&bsdf->frame, wi))
               : 0.0f;
}

bool air_bsdf_sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                     air_vec3 *out_weight, float *out_pdf)
{
    if (!above(bsdf, wo)) {
        return false;
    }
    if (is_metallic(bsdf)) {
        return air_metallic_sample(bsdf, wo, u, out_wi, out_weight, out_pdf);
    }
    air_vec3 local, weight;
    if (!model_of(bsdf)->sample(bsdf, frame_to_local(&bsdf->frame, wo), u, &local, &weight,
                                out_pdf)) {
        return false;
    }
    *out_wi = frame_to_world(&bsdf->frame, local);
    *out_weight = weight;
    return local.z * vec3_dot(*out_wi, bsdf->normal) > 0.0f;
}

/* bsdf_metallic.c: Lambert under GGX. Within this file directions are local to the shading frame, z
 * along its normal. */
#include "scene/bsdf_models.h"

#include "core/warp.h"
#include "scene/fresnel.h"
#include "scene/ggx_albedo_table.h"

static const float INVERSE_PI = 1.0f / AIR_PI_F;

/* NaN becomes 0. */
static float clamp01(float x) { return float_min(float_max(x, 0.0f), 1.0f); }

static air_vec3 clamp01_rgb(air_vec3 v) { return vec3(clamp01(v.x), clamp01(v.y), clamp01(v.z)); }

static air_vec3 mix(air_vec3 a, air_vec3 b, float t)
{
    return vec3_madd(vec3_scale(a, 1.0f - t), t, b);
}

/* ---- the GGX lobe ---- */

/* sqrt(z^2 + alpha^2 (x^2 + y^2)): Smith's lambda is (this / z - 1) / 2. */
static float smith_length(air_vec3 w, float alpha)
{
    return sqrtf(w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y));
}

/* The distribution of normals [Walter2007, eq. 33], with the sine instead of 1 - cos^2, which keeps
 * its digits near the peak. h is unit. */
static float ggx_distribution(air_vec3 h, float alpha)
{
    const float x = h.x / alpha, y = h.y / alpha;
    const float q = x * x + y * y + h.z * h.z;
    return 1.0f / (AIR_PI_F * alpha * alpha * q * q);
}

static air_vec3 ggx_sample(air_vec3 wo, float alpha, float u1, float u2)
{
    const air_facets facets = {AIR_MICROFACETS_GGX, alpha, alpha};
    return air_reflect(wo, air_facets_sample(&facets, wo, u1, u2));
}

/* ---- albedos ---- */

/* Of both specular lobes. */
static air_vec3 specular_albedo(const air_bsdf *bsdf, air_ggx_albedo table)
{
    const air_vec3 rise = vec3_sub(vec3_set1(bsdf->f90), bsdf->f0);
    const air_vec3 lost = vec3_sub(bsdf->f0, bsdf->multiple);
    return vec3_madd(vec3_madd(bsdf->f0, table.fresnel, rise), -table.loss, lost);
}

/* What the specular lobes leave to the base. */
static air_vec3 left_to_base(const air_bsdf *bsdf, air_ggx_albedo table)
{
    return clamp01_rgb(vec3_sub(vec3_set1(1.0f), specular_albedo(bsdf, table)));
}

/* The share of energy that multiple scattering keeps: a geometric series of reflections with mean
 * Fresnel term, of which a part leaves at each turn [Kulla2017]. The mean of Schlick's term over
 * the cosine is (20 f0 + f90) / 21. */
static float multiple_factor(float f0, float f90, float mean_loss)
{
    const float fresnel = (20.0f * f0 + f90) * (1.0f / 21.0f);
    return fresnel * fresnel * (1.0f - mean_loss) / (1.0f - fresnel * mean_loss);
}

/* diffuse / (pi mean(1 - E)); nothing is left to a base under a perfect mirror. */
static float diffuse_factor(float diffuse, float mean_left)
{
    return mean_left > 1e-3f ? diffuse * INVERSE_PI / mean_left : 0.0f;
}

/* How samples are shared out between GGX lobe and the others, by what each reflects to wo. Returns
 * what the base does. */
static air_vec3 share_out(air_bsdf *bsdf, air_vec3 wo)
{
    const float cos_o = clamp01(vec3_dot(wo, bsdf->frame.n));
    const air_ggx_albedo table = air_ggx_albedo_at(cos_o, bsdf->alpha, bsdf->alpha_axis);
    const air_vec3 whole = specular_albedo(bsdf, table);
    const air_vec3 single = vec3_madd(whole, -table.loss, bsdf->multiple);
    const air_vec3 base = vec3_mul(bsdf->diffuse, left_to_base(bsdf, table));
    bsdf->specular_share = clamp01(vec3_mean(single) / vec3_mean(vec3_add(whole, base)));
    return base;
}

static void make_specular(const air_bsdf_input *input, air_bsdf *out)
{
    const float roughness = clamp01(input->roughness);
    out->alpha = float_max(roughness * roughness, air_ggx_alpha_min());
    out->alpha_axis = air_ggx_alpha_axis(out->alpha);
    const air_ggx_albedo mean = air_ggx_albedo_mean(out->alpha_axis);
    out->multiple = vec3(multiple_factor(out->f0.x, out->f90, mean.loss),
                         multiple_factor(out->f0.y, out->f90, mean.loss),
                         multiple_factor(out->f0.z, out->f90, mean.loss));
    out->multiple_scale = INVERSE_PI / mean.loss;
    const air_vec3 left = left_to_base(out, mean);
    out->diffuse_scale =
        vec3(diffuse_factor(out->diffuse.x, left.x), diffuse_factor(out->diffuse.y, left.y),
             diffuse_factor(out->diffuse.z, left.z));

    (void)share_out(out, input->wo);
}

void air_metallic_make(const air_bsdf_input *input, air_bsdf *out)
{
    const air_vec3 base = clamp01_rgb(input->base_color);
    const float metallic = clamp01(input->metallic);
    if (metallic == 0.0f && input->specular == 0.0f) {
        out->diffuse = base;
        return;
    }
    out->diffuse = vec3_scale(base, 1.0f - metallic);
    const float ratio = (input->ior - 1.0f) / (input->ior + 1.0f);
    const float dielectric = clamp01(ratio * ratio) * clamp01(input->specular);
    out->f0 = mix(vec3_set1(dielectric), base, metallic);
    if (!vec3_is_zero(out->f0)) {
        out->f90 = float_max(float_min(50.0f * vec3_max(out->f0), 1.0f), vec3_max(out->f0));
        make_specular(input, out);
    }
}

/* ---- evaluation ---- */

/* The lobes without a highlight. */
typedef struct smooth_lobes {
    air_vec3 base;
    float multiple; /* times bsdf->multiple */
} smooth_lobes;

static smooth_lobes smooth_at(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    const air_ggx_albedo at_o =
        air_ggx_albedo_at(float_min(wo.z, 1.0f), bsdf->alpha, bsdf->alpha_axis);
    const air_ggx_albedo at_i =
        air_ggx_albedo_at(float_min(wi.z, 1.0f), bsdf->alpha, bsdf->alpha_axis);
    return (smooth_lobes){
        vec3_mul(bsdf->diffuse_scale, vec3_mul(left_to_base(bsdf, at_o), left_to_base(bsdf, at_i))),
        bsdf->multiple_scale * (at_o.loss * at_i.loss)};
}

static air_vec3 smooth_value(const air_bsdf *bsdf, smooth_lobes smooth, air_vec3 wi)
{
    return vec3_scale(vec3_madd(smooth.base, smooth.multiple, bsdf->multiple), wi.z);
}

/* f |cos(wi)|, both directions above the shading surface. */
static air_vec3 eval_with(const air_bsdf *bsdf, smooth_lobes smooth, air_vec3 wo, air_vec3 wi)
{
    const air_vec3 h = vec3_normalize(vec3_add(wo, wi));
    const float rise = 1.0f - clamp01(vec3_dot(wi, h));
    const float rise2 = rise * rise;
    const air_vec3 fresnel = mix(bsdf->f0, vec3_set1(bsdf->f90), rise2 * rise2 * rise);
    /* D G2 / (4 cos cos) with the height-correlated Smith term [Heitz2014, eq. 99] */
    const float single =
        0.5f * ggx_distribution(h, bsdf->alpha) /
        (wi.z * smith_length(wo, bsdf->alpha) + wo.z * smith_length(wi, bsdf->alpha));
    const air_vec3 f =
        vec3_madd(vec3_madd(smooth.base, single, fresnel), smooth.multiple, bsdf->multiple);
    return vec3_scale(f, wi.z);
}

static air_vec3 eval_local(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    return eval_with(bsdf, smooth_at(bsdf, wo, wi), wo, wi);
}

static float pdf_local(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    const air_vec3 h = vec3_normalize(vec3_add(wo, wi));
    /* D G1 / (4 cos) with G1 = 2 cos / (cos + length) */
    const float specular =
        0.5f * ggx_distribution(h, bsdf->alpha) / (wo.z + smith_length(wo, bsdf->alpha));
    return bsdf->specular_share * specular +
           (1.0f - bsdf->specular_share) * sample_cosine_hemisphere_pdf(wi.z);
}

air_vec3 air_metallic_eval(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (bsdf->f90 == 0.0f) {
        return vec3_scale(bsdf->diffuse, vec3_dot(wi, bsdf->frame.n) * INVERSE_PI);
    }
    return eval_local(bsdf, frame_to_local(&bsdf->frame, wo), frame_to_local(&bsdf->frame, wi));
}

air_vec3 air_metallic_eval_smooth(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (bsdf->f90 == 0.0f) {
        return air_metallic_eval(bsdf, wo, wi);
    }
    const air_vec3 local_i = frame_to_local(&bsdf->frame, wi);
    const air_vec3 local_o = frame_to_local(&bsdf->frame, wo);
    return smooth_value(bsdf, smooth_at(bsdf, local_o, local_i), local_i);
}

air_vec3 air_metallic_eval_parts(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi,
                                 air_vec3 *out_smooth)
{
    if (bsdf->f90 == 0.0f) {
        return *out_smooth = air_metallic_eval(bsdf, wo, wi);
    }
    const air_vec3 local_o = frame_to_local(&bsdf->frame, wo);
    const air_vec3 local_i = frame_to_local(&bsdf->frame, wi);
    const smooth_lobes smooth = smooth_at(bsdf, local_o, local_i);
    *out_smooth = smooth_value(bsdf, smooth, local_i);
    return eval_with(bsdf, smooth, local_o, local_i);
}

air_vec3 air_metallic_albedo(const air_bsdf *bsdf, air_vec3 wo)
{
    if (bsdf->f90 == 0.0f) {
        return bsdf->diffuse;
    }
    const float cos_o = clamp01(vec3_dot(wo, bsdf->frame.n));
    const air_ggx_albedo table = air_ggx_albedo_at(cos_o, bsdf->alpha, bsdf->alpha_axis);
    return vec3_add(specular_albedo(bsdf, table),
                    vec3_mul(bsdf->diffuse, left_to_base(bsdf, table)));
}

air_vec3 air_metallic_take_base(air_bsdf *bsdf, air_vec3 wo)
{
    air_vec3 base = bsdf->diffuse;
    if (bsdf->f90 > 0.0f) {
        base = share_out(bsdf, wo);
        bsdf->diffuse = bsdf->diffuse_scale = vec3_set1(0.0f);
        (void)share_out(bsdf, wo);
    }
    bsdf->diffuse = vec3_set1(0.0f);
    return base;
}

float air_metallic_sample_pdf(const air_bsdf *bsdf, air_vec3 wo, air_vec3 wi)
{
    if (bsdf->f90 == 0.0f) {
        return sample_cosine_hemisphere_pdf(vec3_dot(wi, bsdf->frame.n));
    }
    return pdf_local(bsdf, frame_to_local(&bsdf->frame, wo), frame_to_local(&bsdf->frame, wi));
}

/* The base alone: nothing depends on wo. */
static bool sample_lambert(const air_bsdf *bsdf, const float u[3], air_vec3 *out_wi,
                           air_vec3 *out_weight, float *out_pdf)
{
    const air_vec3 local = sample_cosine_hemisphere(u[0], u[1]);
    *out_wi = frame_to_world(&bsdf->frame, local);
    *out_weight = bsdf->diffuse;
    *out_pdf = sample_cosine_hemisphere_pdf(local.z);
    return local.z > 0.0f && vec3_dot(*out_wi, bsdf->normal) > 0.0f;
}

bool air_metallic_sample(const air_bsdf *bsdf, air_vec3 wo, const float u[3], air_vec3 *out_wi,
                         air_vec3 *out_weight, float *out_pdf)
{
    if (bsdf->f90 == 0.0f) {
        return sample_lambert(bsdf, u, out_wi, out_weight, out_pdf);
    }
    const air_vec3 local_o = frame_to_local(&bsdf->frame, wo);
    const air_vec3 local_i = u[2] < bsdf->specular_share
                                 ? ggx_sample(local_o, bsdf->alpha, u[0], u[1])
                                 : sample_cosine_hemisphere(u[0], u[1]);
    const air_vec3 wi = frame_to_world(&bsdf->frame, local_i);
    if (!(local_i.z > 0.0f) || !(vec3_dot(wi, bsdf->normal) > 0.0f)) {
        return false;
    }
    *out_pdf = pdf_local(bsdf, local_o, local_i);
    *out_weight = vec3_scale(eval_local(bsdf, local_o, local_i), 1.0f / *out_pdf);
    *out_wi = wi;
    return true;
}

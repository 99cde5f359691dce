/* phase.h: phase functions: value and sampling, inline for the path tracer's inner loop.
 *
 * cos_theta is the cosine between the directions of travel before and after, so g > 0 is forward.
 */
#ifndef AIR_CORE_PHASE_H
#define AIR_CORE_PHASE_H

#include "airlight/medium.h"
#include "core/angle.h"
#include "core/vec.h"

/* [Henyey1941] with the denominator 1 + g^2 - 2 g cos written as (1-|g|)^2 + 2|g|(1 -+
 * cos), which keeps its digits in the peak of a sharp lobe. */
static inline float phase_eval_hg(float g, float cos_theta)
{
    const float a = fabsf(g);
    const float from_peak = fmaxf(0.0f, 1.0f - copysignf(1.0f, g) * cos_theta);
    const float d = (1.0f - a) * (1.0f - a) + 2.0f * a * from_peak;
    return (1.0f - a) * (1.0f + a) / (4.0f * AIR_PI_F * d * sqrtf(d));
}

/* A direction given by 1 - cos and 1 + cos, both kept so that neither peak loses digits. */
typedef struct air_phase_angle {
    float one_minus_cos, one_plus_cos;
} air_phase_angle;

/* phase_eval and phase_sample_angle of mixtures whose weights sum to 1; out of line, so that what
 * the single lobes take of a loop stays short. */
float phase_eval_mixture(const air_phase_mixture *mixture, float cos_theta);
air_phase_angle phase_sample_angle_mixture(const air_phase_mixture *mixture, float u);

/* The same phase function for evaluation: the g of those without one is 0, a mixture is *own (which
 * must outlive the result), with weights that sum to 1 and without lobes of weight 0. What is left
 * with one lobe becomes that lobe. phase: as a medium's description may have it. */
air_phase phase_prepare(air_phase phase, air_phase_mixture *own);

/* The mean cosine: g, 0 where there is none, of mixtures the lobes' by weight (of any sum). */
float phase_mean_cosine(air_phase phase);

/* The integral of the phase function times P_l, l >= 0: what scattering leaves of band l. */
double phase_legendre(air_phase phase, int l);

/* What is wrong with a mixture (may be NULL), as in "lobes[2].g must be between -1 and 1", or NULL.
 */
const char *phase_mixture_fault(const air_phase_mixture *mixture, char buffer[64]);

/* As air_phase_eval. */
static inline float phase_eval(air_phase phase, float cos_theta)
{
    switch (phase.kind) {
    case AIR_PHASE_HG:
        return phase_eval_hg(phase.g, cos_theta);
    case AIR_PHASE_RAYLEIGH:
        return 3.0f / (16.0f * AIR_PI_F) * (1.0f + cos_theta * cos_theta);
    case AIR_PHASE_MIXTURE:
        return phase_eval_mixture(phase.mixture, cos_theta);
    case AIR_PHASE_ISOTROPIC:
        break;
    }
    return 1.0f / (4.0f * AIR_PI_F);
}

/* Inversion of the HG distribution. With u uniform the textbook form is cos = (1 + g^2 - s^2)/(2g),
 * s = (1-g^2)/(1-g+2gu); it divides by g and cancels near the peaks. Expanding the numerator, g
 * divides out: 1 - cos = 2 (1-u) (1-g)^2 (1 + g u) / (1-g+2gu)^2, 1 + cos = 2 u (1+g)^2 (1-g + g u)
 * / (1-g+2gu)^2. For g >= 0 every term is non-negative, so nothing cancels; g < 0 is the mirror
 * image. */
static inline air_phase_angle phase_sample_angle_hg(float g, float u)
{
    const float a = fabsf(g);
    const float v = g < 0.0f ? 1.0f - u : u, w = g < 0.0f ? u : 1.0f - u;
    const float q = 1.0f / ((1.0f - a) + 2.0f * a * v);
    const float narrow = (1.0f - a) * q, wide = (1.0f + a) * q;
    const float to_peak = 2.0f * w * narrow * narrow * (1.0f + a * v);
    const float to_back = 2.0f * v * wide * wide * ((1.0f - a) + a * v);
    return g < 0.0f ? (air_phase_angle){to_back, to_peak} : (air_phase_angle){to_peak, to_back};
}

/* Rayleigh: the distribution function is a cubic, cos^3 + 3 cos = 8u - 4, whose real root is 2
 * sinh(asinh(4u-2)/3). */
static inline air_phase_angle phase_sample_angle_rayleigh(float u)
{
    const float c = 2.0f * sinhf(asinhf(4.0f * u - 2.0f) * (1.0f / 3.0f));
    return (air_phase_angle){fmaxf(0.0f, 1.0f - c), fmaxf(0.0f, 1.0f + c)};
}

static inline air_phase_angle phase_sample_angle(air_phase phase, float u)
{
    switch (phase.kind) {
    case AIR_PHASE_HG:
        return phase_sample_angle_hg(phase.g, u);
    case AIR_PHASE_RAYLEIGH:
        return phase_sample_angle_rayleigh(u);
    case AIR_PHASE_MIXTURE:
        return phase_sample_angle_mixture(phase.mixture, u);
    case AIR_PHASE_ISOTROPIC:
        break;
    }
    return (air_phase_angle){2.0f * (1.0f - u), 2.0f * u};
}

/* Draws the direction of travel after scattering with density phase_eval; travel_dir (unit) is the
 * one before. u1, u2 in [0, 1). *out_pdf, in 1/sr, is also the phase function's value. */
static inline air_vec3 air_phase_sample(air_phase phase, air_vec3 travel_dir, float u1, float u2,
                                        float *out_pdf)
{
    const air_phase_angle angle = phase_sample_angle(phase, u1);
    const float forward = 1.0f - angle.one_minus_cos, backward = angle.one_plus_cos - 1.0f;
    const float cos_theta = angle.one_minus_cos < 1.0f ? forward : backward;
    const float sin_theta = sqrtf(angle.one_minus_cos * angle.one_plus_cos);
    float sin_phi, cos_phi;
    air_sincos_turn(u2, &sin_phi, &cos_phi);
    *out_pdf = phase_eval(phase, cos_theta);
    const air_frame frame = frame_from_normal(travel_dir);
    return frame_to_world(&frame, vec3(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta));
}

/* Density of air_phase_sample per solid angle: the phase function itself. */
static inline float air_phase_sample_pdf(air_phase phase, float cos_theta)
{
    return phase_eval(phase, cos_theta);
}

#endif

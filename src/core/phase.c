/* phase.c: the public face of phase.h, and mixtures. */
#include "core/phase.h"

#include <stdio.h>

float air_phase_eval(air_phase phase, float cos_theta) { return phase_eval(phase, cos_theta); }

static air_phase lobe_phase(const air_phase_lobe *lobe)
{
    return (air_phase){.kind = lobe->kind, .g = lobe->g};
}

float phase_eval_mixture(const air_phase_mixture *mixture, float cos_theta)
{
    float sum = 0.0f;
    for (size_t i = 0; i < mixture->lobe_count; ++i) {
        const air_phase_lobe *lobe = &mixture->lobes[i];
        sum += lobe->weight * phase_eval(lobe_phase(lobe), cos_theta);
    }
    return sum;
}

/* The number chooses a lobe; what is left of it, stretched to [0, 1), the angle. */
air_phase_angle phase_sample_angle_mixture(const air_phase_mixture *mixture, float u)
{
    const air_phase_lobe *lobe = mixture->lobes;
    const air_phase_lobe *last = mixture->lobes + mixture->lobe_count - 1;
    while (lobe < last && u >= lobe->weight) {
        u -= lobe->weight;
        ++lobe;
    }
    return phase_sample_angle(lobe_phase(lobe), fminf(u / lobe->weight, 1.0f - 0x1p-24f));
}

air_phase phase_prepare(air_phase phase, air_phase_mixture *own)
{
    if (phase.kind != AIR_PHASE_MIXTURE) {
        return (air_phase){.kind = phase.kind, .g = phase.kind == AIR_PHASE_HG ? phase.g : 0.0f};
    }
    double sum = 0.0;
    for (size_t i = 0; i < phase.mixture->lobe_count; ++i) {
        sum += (double)phase.mixture->lobes[i].weight;
    }
    size_t count = 0;
    for (size_t i = 0; i < phase.mixture->lobe_count; ++i) {
        air_phase_lobe lobe = phase.mixture->lobes[i];
        lobe.weight = (float)((double)lobe.weight / sum);
        lobe.g = lobe.kind == AIR_PHASE_HG ? lobe.g : 0.0f;
        if (lobe.weight > 0.0f) {
            own->lobes[count++] = lobe;
        }
    }
    own->lobe_count = count;
    return count == 1 ? lobe_phase(own->lobes)
                      : (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = own};
}

float phase_mean_cosine(air_phase phase)
{
    float sum = 0.0f, weights = 0.0f;
    if (phase.kind != AIR_PHASE_MIXTURE) {
        return phase.kind == AIR_PHASE_HG ? phase.g : 0.0f;
    }
    for (size_t i = 0; i < phase.mixture->lobe_count; ++i) {
        const air_phase_lobe *lobe = &phase.mixture->lobes[i];
        sum += lobe->weight * phase_mean_cosine(lobe_phase(lobe));
        weights += lobe->weight;
    }
    return weights > 0.0f ? sum / weights : 0.0f;
}

static const char *lobe_fault(const air_phase_lobe *lobe)
{
    if (lobe->kind != AIR_PHASE_ISOTROPIC && lobe->kind != AIR_PHASE_HG &&
        lobe->kind != AIR_PHASE_RAYLEIGH) {
        return "kind must be in 0..2";
    }
    if (lobe->kind == AIR_PHASE_HG && !(fabsf(lobe->g) < 1.0f)) {
        return "g must be between -1 and 1";
    }
    return lobe->weight >= 0.0f && lobe->weight < INFINITY ? NULL
                                                           : "weight must be finite and at least 0";
}

const char *phase_mixture_fault(const air_phase_mixture *mixture, char buffer[64])
{
    if (mixture == NULL) {
        return "mixture must not be NULL";
    }
    if (mixture->lobe_count < 1 || mixture->lobe_count > AIR_PHASE_MAX_LOBES) {
        snprintf(buffer, 64, "lobe_count is %zu, but must be in 1..%d", mixture->lobe_count,
                 AIR_PHASE_MAX_LOBES);
        return buffer;
    }
    double sum = 0.0;
    for (size_t i = 0; i < mixture->lobe_count; ++i) {
        const char *fault = lobe_fault(&mixture->lobes[i]);
        if (fault != NULL) {
            snprintf(buffer, 64, "lobes[%zu].%s", i, fault);
            return buffer;
        }
        sum += (double)mixture->lobes[i].weight;
    }
    return sum > 0.0 ? NULL : "the weights of the lobes sum to 0";
}

static double lobe_legendre(air_phase_kind kind, float g, int l)
{
    switch (kind) {
    case AIR_PHASE_HG:
        return pow((double)g, l);
    case AIR_PHASE_RAYLEIGH: /* 1 + P_2 / 2, and the integral of P_2^2 is 4 pi / 5 */
        return l == 0 ? 1.0 : l == 2 ? 0.1 : 0.0;
    case AIR_PHASE_ISOTROPIC:
    case AIR_PHASE_MIXTURE:
        break;
    }
    return l == 0 ? 1.0 : 0.0;
}

double phase_legendre(air_phase phase, int l)
{
    double sum = 0.0;
    if (phase.kind != AIR_PHASE_MIXTURE) {
        return lobe_legendre(phase.kind, phase.g, l);
    }
    for (size_t i = 0; i < phase.mixture->lobe_count; i++) {
        const air_phase_lobe *const lobe = &phase.mixture->lobes[i];
        sum += (double)lobe->weight * lobe_legendre(lobe->kind, lobe->g, l);
    }
    return sum;
}

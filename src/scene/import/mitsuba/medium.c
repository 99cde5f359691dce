#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/number.h"

/* ---- phase functions ---- */

static air_status add_lobes(air_mitsuba *mitsuba, air_xml *at, float weight,
                            air_phase_mixture *mixture);

static air_status add_lobe(air_mitsuba *mitsuba, air_xml *at, air_phase_kind kind, float weight,
                           air_phase_mixture *mixture)
{
    air_phase_lobe lobe = {.kind = kind, .weight = weight};
    air_status status = AIR_OK;
    if (mixture->lobe_count == AIR_PHASE_MAX_LOBES)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "a phase function of more than %d parts is not supported",
                                AIR_PHASE_MAX_LOBES);
    if (kind == AIR_PHASE_HG) {
        lobe.g = 0.8f;
        status = air_mitsuba_float(mitsuba, at, "g", &lobe.g);
    }
    if (status == AIR_OK && !(fabsf(lobe.g) < 1.0f))
        status =
            air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                             "expected g to be above -1 and below 1, found %g", (double)lobe.g);
    mixture->lobes[mixture->lobe_count++] = lobe;
    return status;
}

static air_status add_blend(air_mitsuba *mitsuba, air_xml *at, float weight,
                            air_phase_mixture *mixture)
{
    float second = 0.5f;
    air_xml *from = at->child, *child = NULL, *parts[2] = {NULL, NULL};
    air_status status = air_mitsuba_float(mitsuba, at, "weight", &second);
    if (status == AIR_OK && !(second >= 0.0f && second <= 1.0f))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected weight to be 0 to 1, found %g", (double)second);
    if (status == AIR_OK)
        status = air_mitsuba_next(mitsuba, &from, "phase", &child, &parts[0]);
    if (status == AIR_OK && from != NULL)
        status = air_mitsuba_next(mitsuba, &from, "phase", &child, &parts[1]);
    if (status == AIR_OK && parts[1] == NULL)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected two <phase> within it");
    if (status == AIR_OK)
        status = add_lobes(mitsuba, parts[0], weight * (1.0f - second), mixture);
    return status == AIR_OK ? add_lobes(mitsuba, parts[1], weight * second, mixture) : status;
}

static air_status add_lobes(air_mitsuba *mitsuba, air_xml *at, float weight,
                            air_phase_mixture *mixture)
{
    static const char *const types[] = {"isotropic", "hg", "rayleigh", "blendphase"};
    air_status status = air_mitsuba_enter(mitsuba, at);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; i < 3; ++i) /* the order of air_phase_kind */
        if (air_mitsuba_is(at, types[i])) {
            status = add_lobe(mitsuba, at, (air_phase_kind)i, weight, mixture);
            air_mitsuba_leave(mitsuba);
            return status;
        }
    if (air_mitsuba_is(at, "blendphase"))
        status = add_blend(mitsuba, at, weight, mixture);
    else
        status = air_mitsuba_unknown_type(mitsuba, at, types, 4, "isotropic is taken");
    air_mitsuba_leave(mitsuba);
    return status;
}

static air_status read_phase(air_mitsuba *mitsuba, const air_xml *at, air_medium_desc *desc,
                             air_phase_mixture *mixture)
{
    air_xml *phase = NULL;
    mixture->lobe_count = 0;
    air_status status = air_mitsuba_child(mitsuba, at, "phase", NULL, &phase);
    if (status == AIR_OK && phase != NULL)
        status = add_lobes(mitsuba, phase, 1.0f, mixture);
    desc->phase = (air_phase){.kind = AIR_PHASE_ISOTROPIC};
    if (mixture->lobe_count == 1)
        desc->phase = (air_phase){.kind = mixture->lobes[0].kind, .g = mixture->lobes[0].g};
    if (mixture->lobe_count > 1)
        desc->phase = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = mixture};
    return status;
}

/* ---- coefficients ---- */

/* sigma_t and albedo into sigma_s and sigma_a. */
static void split(const float sigma_t[3], const float albedo[3], air_medium_desc *desc)
{
    for (size_t i = 0; i < 3; ++i) {
        desc->sigma_s[i] = sigma_t[i] * albedo[i];
        desc->sigma_a[i] = sigma_t[i] * (1.0f - albedo[i]);
    }
}

static air_status check_albedo(const air_mitsuba *mitsuba, const air_xml *at, const float albedo[3])
{
    for (size_t i = 0; i < 3; ++i)
        if (!(albedo[i] >= 0.0f && albedo[i] <= 1.0f))
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected an albedo of 0 to 1, found %g", (double)albedo[i]);
    return AIR_OK;
}

/* A colour, or a volume that is the same everywhere, of version 3. */
static air_status read_constant(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                float value[3])
{
    air_xml *found = air_mitsuba_parameter(at, name), *target = NULL;
    if (found == NULL)
        return AIR_OK;
    const air_status status = air_mitsuba_resolve(mitsuba, found, &target);
    if (status != AIR_OK || strcmp(target->tag, "volume") != 0)
        return status == AIR_OK
                   ? air_mitsuba_read_color(mitsuba, target, AIR_MITSUBA_REFLECTANCE, value)
                   : status;
    target->used = target->asked = true;
    if (!air_mitsuba_is(target, "constvolume"))
        return air_mitsuba_fail(mitsuba, found, AIR_ERROR_UNSUPPORTED,
                                "expected a number or a colour in a homogeneous medium");
    return air_mitsuba_color(mitsuba, target, "value", AIR_MITSUBA_REFLECTANCE, value);
}

static air_status read_homogeneous(const air_mitsuba *mitsuba, const air_xml *at, float scale,
                                   air_medium_desc *desc)
{
    float sigma_t[3] = {1.0f, 1.0f, 1.0f}, albedo[3] = {0.75f, 0.75f, 0.75f};
    const bool apart = air_mitsuba_has(at, "sigma_s") || air_mitsuba_has(at, "sigma_a");
    const bool whole = air_mitsuba_has(at, "sigma_t") || air_mitsuba_has(at, "albedo");
    if (apart && whole)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected sigma_s and sigma_a, or sigma_t and albedo, found both");
    if (air_mitsuba_has(at, "material") || (air_mitsuba_is_old(at) && !apart && !whole))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "named materials of media are not supported, expected sigma_s and "
                                "sigma_a, or sigma_t and albedo");
    air_status status =
        air_mitsuba_color(mitsuba, at, "sigma_s", AIR_MITSUBA_REFLECTANCE, desc->sigma_s);
    if (status == AIR_OK)
        status = air_mitsuba_color(mitsuba, at, "sigma_a", AIR_MITSUBA_REFLECTANCE, desc->sigma_a);
    if (status == AIR_OK && !apart)
        status = read_constant(mitsuba, at, "sigma_t", sigma_t);
    if (status == AIR_OK && !apart)
        status = read_constant(mitsuba, at, "albedo", albedo);
    if (status == AIR_OK && !apart)
        status = check_albedo(mitsuba, at, albedo);
    if (status == AIR_OK && !apart)
        split(sigma_t, albedo, desc);
    for (size_t i = 0; i < 3; ++i) {
        desc->sigma_s[i] *= scale;
        desc->sigma_a[i] *= scale;
    }
    return status;
}

air_status air_mitsuba_read_medium(air_mitsuba *mitsuba, air_xml *at, air_medium_desc *desc,
                                   air_phase_mixture *mixture)
{
    static const char *const types[] = {"homogeneous", "heterogeneous"};
    static const char *const ignored[] = {"method",
                                          "step_size",
                                          "strategy",
                                          "sample_emitters",
                                          "monochromatic",
                                          "medium_sampling_weight",
                                          "has_spectral_extinction",
                                          "sampling_density",
                                          "channel"};
    float scale = 1.0f;
    at->used = at->asked = true;
    air_medium_desc_default(desc);
    desc->name = air_mitsuba_name(at);
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = air_mitsuba_float(mitsuba, at, "scale", &scale);
    if (status == AIR_OK && !(scale >= 0.0f))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected a scale that is not below 0, found %g", (double)scale);
    if (status == AIR_OK)
        status = read_phase(mitsuba, at, desc, mixture);
    if (status != AIR_OK)
        return status;
    if (air_mitsuba_is(at, "homogeneous"))
        return read_homogeneous(mitsuba, at, scale, desc);
    if (air_mitsuba_is(at, "heterogeneous"))
        return air_mitsuba_read_volumes(mitsuba, at, scale, desc);
    return air_mitsuba_unknown_type(mitsuba, at, types, 2, "nothing is in its place");
}

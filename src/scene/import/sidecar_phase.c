/* sidecar_phase.c: "phase", and "g" beside it. */
#include "scene/import/import.h"

static const char *const types[] = {"isotropic", "hg", "rayleigh", "mixture"};
enum { LOBE_TYPES = 3, TYPES = sizeof types / sizeof types[0] };

/* Of a lobe, or of a phase function that is one. */
static air_status read_g(const air_json *g_at, air_phase_kind kind, float *out)
{
    const air_status status = air_json_float(g_at, AIR_JSON_SIGNED_OPEN, out);
    if (status == AIR_OK && g_at->value != NULL && kind != AIR_PHASE_HG)
        return air_json_fail(g_at, AIR_ERROR_FORMAT, "only the phase function \"hg\" has a g");
    return status;
}

/* {"type": "hg", "g": 0.8, "weight": 0.7} */
static air_status read_lobe(const air_json *at, air_phase_lobe *out)
{
    static const char *const keys[] = {"type", "g", "weight"};
    const air_json type_at = air_json_get(at, "type");
    const air_json g_at = air_json_get(at, "g");
    const air_json weight_at = air_json_get(at, "weight");
    size_t type = AIR_PHASE_ISOTROPIC;
    *out = (air_phase_lobe){.weight = 0.0f};
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, 3);
    if (status == AIR_OK)
        status = air_json_require(&type_at, "a phase function");
    if (status == AIR_OK)
        status = air_json_choice(&type_at, types, LOBE_TYPES, &type);
    if (status == AIR_OK)
        status = read_g(&g_at, (air_phase_kind)type, &out->g);
    if (status == AIR_OK)
        status = air_json_require(&weight_at, "the lobe's weight");
    if (status == AIR_OK)
        status = air_json_float(&weight_at, AIR_JSON_NON_NEGATIVE, &out->weight);
    out->kind = (air_phase_kind)type;
    return status;
}

/* {"type": "mixture", "lobes": [...]} */
static air_status read_mixture(const air_json *at, air_phase_mixture *out)
{
    static const char *const keys[] = {"type", "lobes"};
    const air_json lobes_at = air_json_get(at, "lobes");
    air_status status = air_json_check_keys(at, keys, 2);
    if (status != AIR_OK)
        return status;
    bool some = false;
    out->lobe_count = air_json_count(&lobes_at);
    if (out->lobe_count < 1 || out->lobe_count > AIR_PHASE_MAX_LOBES)
        return air_json_expected(&lobes_at, "an array of 1 to %d lobes", AIR_PHASE_MAX_LOBES);
    for (size_t i = 0; i < out->lobe_count && status == AIR_OK; ++i) {
        const air_json lobe_at = air_json_at(&lobes_at, i);
        status = read_lobe(&lobe_at, &out->lobes[i]);
        some = some || out->lobes[i].weight > 0.0f;
    }
    if (status == AIR_OK && !some)
        return air_json_fail(&lobes_at, AIR_ERROR_FORMAT, "expected a weight above 0");
    return status;
}

/* {"type": ...} */
static air_status read_object(const air_json *at, air_phase *out, air_phase_mixture *mixture)
{
    static const char *const keys[] = {"type", "g"};
    const air_json type_at = air_json_get(at, "type");
    const air_json g_at = air_json_get(at, "g");
    size_t type = AIR_PHASE_ISOTROPIC;
    air_status status = air_json_require(&type_at, "a phase function");
    if (status == AIR_OK)
        status = air_json_choice(&type_at, types, TYPES, &type);
    if (status != AIR_OK)
        return status;
    *out = (air_phase){.kind = (air_phase_kind)type, .mixture = mixture};
    if (out->kind == AIR_PHASE_MIXTURE)
        return read_mixture(at, mixture);
    status = air_json_check_keys(at, keys, 2);
    return status == AIR_OK ? read_g(&g_at, out->kind, &out->g) : status;
}

air_status air_sidecar_read_phase(const air_sidecar_part *part, air_medium_desc *desc,
                                  air_phase_mixture *mixture)
{
    const air_json at = air_json_get(part->at, "phase");
    const air_json g_at = air_json_get(part->at, "g");
    if (json_is_object(at.value)) {
        if (g_at.value != NULL)
            return air_json_fail(&g_at, AIR_ERROR_FORMAT,
                                 "expected g inside the phase, where its type is");
        return read_object(&at, &desc->phase, mixture);
    }
    size_t type = g_at.value != NULL ? AIR_PHASE_HG : AIR_PHASE_ISOTROPIC;
    const air_status status = air_json_choice(&at, types, LOBE_TYPES, &type);
    desc->phase.kind = (air_phase_kind)type;
    return status == AIR_OK ? read_g(&g_at, desc->phase.kind, &desc->phase.g) : status;
}

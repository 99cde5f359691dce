/* sidecar_phase.c: "phase", and "g" beside it. */
#include <stdio.h>

#include "core/phase_fit.h"
#include "scene/import/import.h"

/* In the order of air_phase_kind; a table becomes a mixture. */
static const char *const types[] = {"isotropic", "hg", "rayleigh", "mixture", "table"};
enum { LOBE_TYPES = 3, TABLE = 4, TYPES = sizeof types / sizeof types[0] };

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

/* ---- tables ---- */

/* A fit whose error is larger is warned of. */
static const double good_fit = 0.1;

static air_status report_fit(const air_sidecar_part *part, const air_json *at, size_t lobe_count,
                             double error)
{
    char place[256];
    air_json_describe(at, place, sizeof place);
    if (error <= good_fit) {
        air_inform(part->import->context, "%s: %s: the table became %zu lobes, rms error %.2g %%",
                   at->document->file, place, lobe_count, 100.0 * error);
        return AIR_OK;
    }
    return air_import_warn(part->import,
                           "%s: %s: the table became %zu lobes, rms error %.2g %%: lobes of Henyey "
                           "and Greenstein cannot follow it better",
                           at->document->file, place, lobe_count, 100.0 * error);
}

/* An array of count numbers, count >= 2, into a fresh one. */
static air_status read_numbers(const air_json *at, size_t count, double **out)
{
    air_status status = AIR_OK;
    *out = air_allocate(at->document->context, count, sizeof **out);
    if (*out == NULL)
        return air_fail_memory(at->document->context, "phase function");
    for (size_t i = 0; i < count && status == AIR_OK; ++i) {
        const air_json element = air_json_at(at, i);
        status = air_json_number(&element, AIR_JSON_ANY, &(*out)[i]);
    }
    return status;
}

static air_status fit_table(const air_sidecar_part *part, const air_json *at, const double *cosines,
                            const double *values, size_t count, air_phase_mixture *out)
{
    char buffer[AIR_PHASE_FAULT_SIZE];
    const char *fault = air_phase_table_fault(cosines, values, count, buffer);
    if (fault != NULL)
        return air_json_fail(at, AIR_ERROR_FORMAT, "%s", fault);
    double error = 0.0;
    const air_status status =
        air_phase_fit(part->import->context, cosines, values, count, out, &error);
    return status == AIR_OK ? report_fit(part, at, out->lobe_count, error) : status;
}

/* {"type": "table", "cosines": [-1, ..., 1], "values": [...]} */
static air_status read_table(const air_sidecar_part *part, const air_json *at,
                             air_phase_mixture *out)
{
    static const char *const keys[] = {"type", "cosines", "values"};
    const air_json cosines_at = air_json_get(at, "cosines");
    const air_json values_at = air_json_get(at, "values");
    const size_t count = air_json_count(&cosines_at);
    double *cosines = NULL, *values = NULL;
    air_status status = air_json_check_keys(at, keys, 3);
    if (status == AIR_OK && count < 2)
        status = air_json_expected(&cosines_at, "an array of at least 2 numbers");
    if (status == AIR_OK && air_json_count(&values_at) != count)
        status = air_json_expected(&values_at, "an array of %zu numbers, one per cosine", count);
    if (status == AIR_OK)
        status = read_numbers(&cosines_at, count, &cosines);
    if (status == AIR_OK)
        status = read_numbers(&values_at, count, &values);
    if (status == AIR_OK)
        status = fit_table(part, at, cosines, values, count, out);
    air_free(part->import->context, values);
    air_free(part->import->context, cosines);
    return status;
}

/* ---- the whole ---- */

/* {"type": ...} */
static air_status read_object(const air_sidecar_part *part, const air_json *at, air_phase *out,
                              air_phase_mixture *mixture)
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
    *out = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = mixture};
    if (type == TABLE)
        return read_table(part, at, mixture);
    if (type == AIR_PHASE_MIXTURE)
        return read_mixture(at, mixture);
    *out = (air_phase){.kind = (air_phase_kind)type};
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
        return read_object(part, &at, &desc->phase, mixture);
    }
    size_t type = g_at.value != NULL ? AIR_PHASE_HG : AIR_PHASE_ISOTROPIC;
    const air_status status = air_json_choice(&at, types, LOBE_TYPES, &type);
    desc->phase.kind = (air_phase_kind)type;
    return status == AIR_OK ? read_g(&g_at, desc->phase.kind, &desc->phase.g) : status;
}

/* dom_fields.c: what callers set and ask of a solver: medium, light, inflow; moments and what is
 * scattered. */
#include "ordinates/dom.h"

#include <math.h>
#include <string.h>

#include "core/harmonics.h"
#include "core/host.h"
#include "ordinates/four.h"

static const double sigma_most = 1e9, moment_most = 1e15;

/* ---- the medium ---- */

static air_status check_medium(const air_dom *dom, const float *sigma_s, const float *sigma_a,
                               const air_dom_phase *phase)
{
    for (size_t i = 0; i < 3 * dom->cells; i++) {
        const double s = (double)sigma_s[i], a = (double)sigma_a[i];
        const double g = phase->g != NULL ? (double)phase->g[i] : 0.0;
        if (!(s >= 0.0) || !(a >= 0.0) || !(s + a <= sigma_most) || !(fabs(g) < 1.0)) {
            return air_fail(dom->context, AIR_ERROR_ARGUMENT,
                            "discrete ordinates: cell %zu, channel %zu: sigma_s %g, sigma_a %g, g "
                            "%g: expected numbers >= 0 that add up to at most %g, and g between -1 "
                            "and 1",
                            i % dom->cells, i / dom->cells, s, a, g, sigma_most);
        }
    }
    for (int l = 1; phase->g == NULL && l <= dom->params.bands; l++) {
        const double mean = phase->legendre[l - 1];
        if (!(fabs(mean) <= 1.0) || (l == dom->params.bands && !(mean < 1.0))) {
            return air_fail(dom->context, AIR_ERROR_ARGUMENT,
                            "discrete ordinates: the mean of P_%d is %g: expected -1 to 1, of the "
                            "last less than 1",
                            l, mean);
        }
    }
    return AIR_OK;
}

/* Is g the same wherever there is scattering? Then it is the first such. */
static bool find_uniform(const air_dom *dom, const float *sigma_s, const float *g, float *out_g)
{
    bool found = false;
    *out_g = 0.0f;
    for (size_t i = 0; i < 3 * dom->cells; i++) {
        if (sigma_s[i] > 0.0f && (!found || g[i] != *out_g)) {
            if (found) {
                return false;
            }
            *out_g = g[i];
            found = true;
        }
    }
    return true;
}

static void set_legendre(air_dom *dom, const float *sigma_s, const air_dom_phase *phase)
{
    float g = 0.0f;
    dom->uniform = phase->g == NULL || find_uniform(dom, sigma_s, phase->g, &g);
    for (int l = 1; l <= dom->params.bands; l++) {
        dom->legendre[l] = phase->g == NULL ? phase->legendre[l - 1] : pow((double)g, l);
    }
}

static void set_cell(air_dom *dom, size_t cell, size_t c, double s, double a, double g)
{
    const int bands = dom->params.bands;
    const double last = dom->uniform ? dom->legendre[bands] : pow(g, bands);
    const double peak = air_dom_peak(&dom->params, last);
    const size_t at = cell * AIR_DOM_STRIDE + c;
    dom->peak[at] = (float)peak;
    dom_put(dom, &dom->sigma_s, at, s * (1.0 - peak));
    dom_put(dom, &dom->sigma_a, at, a);
    dom_put(dom, &dom->sigma_t, at, s * (1.0 - peak) + a);
    double power = 1.0;
    for (int l = 0; l < bands && !dom->uniform; l++) {
        dom_put(dom, &dom->phase, (cell * (size_t)bands + (size_t)l) * AIR_DOM_STRIDE + c,
                dom_scaled_legendre(power, peak));
        power *= g;
    }
}

air_status air_dom_set_medium(air_dom *dom, const float *sigma_s, const float *sigma_a,
                              const air_dom_phase *phase)
{
    const air_status status = check_medium(dom, sigma_s, sigma_a, phase);
    if (status != AIR_OK) {
        return status;
    }
    set_legendre(dom, sigma_s, phase);
    dom_make_harmonics(dom);
    for (size_t c = 0; c < 3; c++) {
        for (size_t cell = 0; cell < dom->cells; cell++) {
            const size_t i = c * dom->cells + cell;
            set_cell(dom, cell, c, (double)sigma_s[i], (double)sigma_a[i],
                     phase->g != NULL ? (double)phase->g[i] : 0.0);
        }
    }
    return AIR_OK;
}

/* ---- light ---- */

/* Number i of our arrays, of the m-th moment, in those of callers. */
static size_t moment_place(const air_dom *dom, size_t i, size_t m)
{
    return i + ((size_t)dom->order[m] - m) * AIR_DOM_STRIDE;
}

static bool are_moments_fine(const float *moments, size_t cells, size_t count)
{
    const four most = four_all((float)moment_most), none = four_all(0.0f);
    four_ints fine = ~(four_ints){0};
    for (size_t cell = 0; cell < cells; cell++) {
        const float *const at = moments + cell * count * AIR_DOM_STRIDE;
        fine &= four_load(at) >= none;
        for (size_t m = 0; m < count; m++) {
            const four value = four_load(at + m * AIR_DOM_STRIDE);
            fine &= (value <= most) & (value >= -most);
        }
    }
    return fine[0] != 0 && fine[1] != 0 && fine[2] != 0;
}

/* Are these cells' moments of a size that can be reckoned with? */
static air_status check_moments(const air_dom *dom, const float *moments, size_t cells,
                                const char *what)
{
    const size_t count = (size_t)dom->moments;
    if (are_moments_fine(moments, cells, count)) {
        return AIR_OK;
    }
    for (size_t i = 0; i < cells * count * AIR_DOM_STRIDE; i++) { /* which is it? */
        const double value = (double)moments[i];
        const size_t c = i % AIR_DOM_STRIDE, m = i / AIR_DOM_STRIDE % count;
        if (c < 3 && !(fabs(value) <= moment_most)) {
            return air_fail(dom->context, AIR_ERROR_ARGUMENT,
                            "discrete ordinates: %s: cell %zu, moment %zu, channel %zu is %g: "
                            "expected at most %g in size",
                            what, i / AIR_DOM_STRIDE / count, m, c, value, moment_most);
        }
        if (c < 3 && m == 0 && value < 0.0) {
            return air_fail(dom->context, AIR_ERROR_ARGUMENT,
                            "discrete ordinates: %s: cell %zu, moment 0, channel %zu is %g: "
                            "expected fluence, >= 0",
                            what, i / AIR_DOM_STRIDE / count, c, value);
        }
    }
    return AIR_OK;
}

/* What is given and where it comes from or goes to: k by k. */
typedef struct transfer {
    const air_dom *dom;
    const dom_array *array;
    const float *from;
    float *to;
} transfer;

static void take_slab(void *user, size_t k, size_t worker)
{
    const transfer *const self = user;
    const air_dom *const dom = self->dom;
    const size_t count = (size_t)dom->moments;
    (void)worker;
    for (size_t i = k * dom->slab * count; i < (k + 1) * dom->slab * count; i++) {
        four value = four_load(self->from + moment_place(dom, i * AIR_DOM_STRIDE, i % count));
        value[3] = 0.0f;
        for (size_t c = 0; c < AIR_DOM_STRIDE && dom->number != sizeof(float); c++) {
            self->array->d[i * AIR_DOM_STRIDE + c] = (double)value[c];
        }
        if (dom->number == sizeof(float)) {
            four_store(self->array->f + i * AIR_DOM_STRIDE, value);
        }
    }
}

/* Puts callers' moments of all cells, NULL: 0, into an array of ours. */
static air_status put_moments(air_dom *dom, const float *moments, const char *what, dom_array *out)
{
    transfer given = {.dom = dom, .array = out, .from = moments};
    const air_status status =
        moments != NULL ? check_moments(dom, moments, dom->cells, what) : AIR_OK;
    if (moments == NULL) {
        memset(out->any, 0, dom->cells * (size_t)dom->moments * AIR_DOM_STRIDE * dom->number);
    } else if (status == AIR_OK) {
        air_parallel_for(dom->context, dom->params.size[2], take_slab, &given);
    }
    return status;
}

air_status air_dom_set_light(air_dom *dom, const float *moments)
{
    return put_moments(dom, moments, "light", &dom->light);
}

air_status air_dom_set_moments(air_dom *dom, const float *moments)
{
    return put_moments(dom, moments, "solution", &dom->field);
}

/* Direction o of an octant. */
static void direction_of(const air_dom *dom, int octant, int o, double out[3])
{
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = (octant >> axis & 1) != 0 ? -dom->dir[axis][o] : dom->dir[axis][o];
    }
}

static void put_inflow(air_dom *dom, int octant, int o, size_t c, double radiance)
{
    const size_t at = (size_t)octant * (size_t)dom->directions + (size_t)o;
    dom_put(dom, &dom->inflow, at * AIR_DOM_STRIDE + c, radiance);
}

static air_status check_faces(const air_dom *dom, uint32_t faces)
{
    return faces <= 63u
               ? AIR_OK
               : air_fail(dom->context, AIR_ERROR_ARGUMENT,
                          "discrete ordinates: inflow: faces %u: expected bits 0 to 5", faces);
}

air_status air_dom_set_inflow(air_dom *dom, const float *moments, uint32_t faces)
{
    double y[DOM_MOMENTS_MAX];
    air_status status = check_faces(dom, faces);
    if (status == AIR_OK && moments != NULL) {
        status = check_moments(dom, moments, 1, "inflow");
    }
    if (status != AIR_OK) {
        return status;
    }
    dom->inflow_faces = moments != NULL ? faces : 0u;
    for (int octant = 0; octant < DOM_OCTANTS && moments != NULL; octant++) {
        for (int o = 0; o < dom->directions; o++) {
            double dir[3];
            direction_of(dom, octant, o, dir);
            air_sh_evaluate(dom->params.bands, dir, y);
            for (size_t c = 0; c < AIR_DOM_STRIDE; c++) {
                double sum = 0.0;
                for (size_t m = 0; m < (size_t)dom->moments && c < 3; m++) {
                    sum += y[m] * (double)moments[m * AIR_DOM_STRIDE + c];
                }
                put_inflow(dom, octant, o, c, fmax(sum, 0.0));
            }
        }
    }
    return AIR_OK;
}

/* Of one octant, without those that only fill it up. */
static int real_directions(const air_dom_params *p) { return p->polar / 2 * (p->azimuths / 4); }

size_t air_dom_direction_count(const air_dom_params *params)
{
    return (size_t)DOM_OCTANTS * (size_t)real_directions(params);
}

void air_dom_directions(const air_dom *dom, double (*out_dir)[3], double *out_solid_angle)
{
    const int count = real_directions(&dom->params);
    for (int i = 0; i < DOM_OCTANTS * count; i++) {
        direction_of(dom, i / count, i % count, out_dir[i]);
        out_solid_angle[i] = dom->weight[i % count];
    }
}

air_status air_dom_set_inflow_directions(air_dom *dom, const float *radiance, uint32_t faces)
{
    const int count = real_directions(&dom->params);
    const size_t all = air_dom_direction_count(&dom->params) * AIR_DOM_STRIDE;
    const air_status status = check_faces(dom, faces);
    for (size_t i = 0; status == AIR_OK && i < all; i++) {
        if (i % AIR_DOM_STRIDE < 3 && !(radiance[i] >= 0.0f && radiance[i] <= 1e15f)) {
            return air_fail(
                dom->context, AIR_ERROR_ARGUMENT,
                "discrete ordinates: inflow: direction %zu, channel %zu: %g: expected 0 "
                "to 1e15",
                i / AIR_DOM_STRIDE, i % AIR_DOM_STRIDE, (double)radiance[i]);
        }
    }
    dom->inflow_faces = status == AIR_OK ? faces : dom->inflow_faces;
    for (int octant = 0; octant < DOM_OCTANTS && status == AIR_OK; octant++) {
        for (int o = 0; o < dom->directions; o++) { /* those that fill up have no weight */
            const size_t from = (size_t)(octant * count + (o < count ? o : 0)) * AIR_DOM_STRIDE;
            for (size_t c = 0; c < 3; c++) {
                put_inflow(dom, octant, o, c, o < count ? (double)radiance[from + c] : 0.0);
            }
        }
    }
    return status;
}

/* ---- results ---- */

static void give_slab(void *user, size_t k, size_t worker)
{
    const transfer *const self = user;
    const air_dom *const dom = self->dom;
    const size_t count = (size_t)dom->moments;
    (void)worker;
    for (size_t i = k * dom->slab * count; i < (k + 1) * dom->slab * count; i++) {
        float *const to = self->to + moment_place(dom, i * AIR_DOM_STRIDE, i % count);
        for (size_t c = 0; c < AIR_DOM_STRIDE && dom->number != sizeof(float); c++) {
            to[c] = (float)dom_get(dom, &dom->field, i * AIR_DOM_STRIDE + c);
        }
        if (dom->number == sizeof(float)) {
            four_store(to, four_load(dom->field.f + i * AIR_DOM_STRIDE));
        }
    }
}

void air_dom_moments(const air_dom *dom, float *out)
{
    transfer wanted = {.dom = dom, .to = out};
    air_parallel_for(dom->context, dom->params.size[2], give_slab, &wanted);
}

void air_dom_scattered(const air_dom *dom, float *out)
{
    const int bands = dom->params.bands;
    for (size_t cell = 0; cell < dom->cells; cell++) {
        for (int m = 0; m < dom->moments; m++) {
            const size_t l = (size_t)dom->band_of[m];
            for (size_t c = 0; c < AIR_DOM_STRIDE; c++) {
                const size_t i = (cell * (size_t)dom->moments + (size_t)m) * AIR_DOM_STRIDE + c;
                const double peak = (double)dom->peak[cell * AIR_DOM_STRIDE + c];
                const size_t at = (cell * (size_t)bands + l) * AIR_DOM_STRIDE + c;
                const double g = dom->uniform ? dom->legendre[l] - peak
                                              : (1.0 - peak) * dom_get(dom, &dom->phase, at);
                out[moment_place(dom, i, (size_t)m)] = (float)(g * dom_get(dom, &dom->field, i));
            }
        }
    }
}

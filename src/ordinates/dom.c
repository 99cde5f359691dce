/* dom.c: the solver: its directions and its memory. */
#include "ordinates/dom.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/harmonics.h"
#include "core/host.h"
#include "core/quadrature.h"
#include "core/vec.h"

void air_dom_params_default(air_dom_params *params)
{
    memset(params, 0, sizeof *params);
    params->bands = 4;
    params->polar = 4;
    params->azimuths = 8;
    params->delta_m = true;
    params->diamond = true;
}

double air_dom_peak(const air_dom_params *params, double last_legendre)
{
    return params->delta_m ? fmax(last_legendre, 0.0) : 0.0;
}

/* Numbers of this size and their squares, products and sums stay far from floats' ends. */
static const double edge_least = 1e-6, edge_most = 1e6;

static air_status check(air_context *context, const air_dom_params *p)
{
    for (int axis = 0; axis < 3; axis++) {
        const double edge = (double)p->cell_m[axis];
        if (p->size[axis] < 1 || p->size[axis] > AIR_DOM_SIZE_MAX || !(edge >= edge_least) ||
            !(edge <= edge_most)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "discrete ordinates: %zu cells of %g m along %c: expected 1 to %d of "
                            "%g to %g m",
                            p->size[axis], edge, "xyz"[axis], (int)AIR_DOM_SIZE_MAX, edge_least,
                            edge_most);
        }
    }
    if (p->bands < 1 || p->bands > AIR_DOM_BANDS_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "discrete ordinates: %d bands: expected 1 to %d", p->bands,
                        (int)AIR_DOM_BANDS_MAX);
    }
    if (p->polar % 2 != 0 || p->polar < p->bands || p->polar < 2 || p->polar > AIR_DOM_POLAR_MAX ||
        p->azimuths % 4 != 0 || p->azimuths < 2 * p->bands || p->azimuths < 4 ||
        p->azimuths > 2 * AIR_DOM_POLAR_MAX) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "discrete ordinates: %d x %d directions for %d bands: expected an even number of polar "
            "ones, at least as many as bands and at most %d, and a multiple of 4 round the axis, "
            "at least twice as many as bands and at most %d",
            p->polar, p->azimuths, p->bands, (int)AIR_DOM_POLAR_MAX, 2 * (int)AIR_DOM_POLAR_MAX);
    }
    return AIR_OK;
}

/* ---- sizes ---- */

/* Of one octant, filled up. */
static int direction_count(const air_dom_params *p)
{
    const int real = p->polar / 2 * (p->azimuths / 4);
    return (real + DOM_GROUP - 1) / DOM_GROUP * DOM_GROUP;
}

size_t air_dom_bytes(const air_dom_params *p, int depth)
{
    const double cells = (double)p->size[0] * (double)p->size[1] * (double)p->size[2];
    const double moments = 4.0 * p->bands * p->bands, row = 4.0 * direction_count(p);
    const double histories = depth > 0 ? 3.0 + 2.0 * depth : 0.0;
    const double faces = (double)p->size[0] * (1.0 + (double)p->size[1]) + (double)p->size[1];
    const double numbers =
        cells * ((3.0 + histories) * moments + 8.0 * row + 12.0 + 4.0 * p->bands) +
        8.0 * faces * row;
    const double bytes = (numbers + 4.0 * cells) * sizeof(float) + 24.0 * row * sizeof(double);
    return bytes < 0.5 * (double)SIZE_MAX ? (size_t)bytes : SIZE_MAX;
}

bool dom_array_make(air_dom *dom, size_t count, dom_array *out)
{
    out->any = NULL;
    if (dom->block_count == DOM_BLOCKS_MAX || count > (SIZE_MAX - AIR_ALIGNMENT) / dom->number) {
        return false;
    }
    void *const block = air_allocate(dom->context, count * dom->number + AIR_ALIGNMENT, 1);
    if (block == NULL) {
        return false;
    }
    dom->blocks[dom->block_count++] = block;
    out->any = air_align(block);
    return true;
}

static bool make_arrays(air_dom *dom)
{
    const size_t cells = dom->cells, row = dom->row, *const n = dom->params.size;
    const size_t moments = (size_t)dom->moments, all = cells * moments * AIR_DOM_STRIDE;
    const size_t bands = (size_t)dom->params.bands;
    bool made = true;
    for (int axis = 0; axis < 3; axis++) {
        made = made && dom_array_make(dom, row, &dom->slope[axis]);
    }
    made = made && dom_array_make(dom, row, &dom->weights);
    made = made && dom_array_make(dom, row * moments, &dom->emitting);
    made = made && dom_array_make(dom, row * (moments + 3), &dom->gathering);
    made = made && dom_array_make(dom, cells * AIR_DOM_STRIDE, &dom->sigma_s);
    made = made && dom_array_make(dom, cells * AIR_DOM_STRIDE, &dom->sigma_t);
    made = made && dom_array_make(dom, cells * AIR_DOM_STRIDE, &dom->sigma_a);
    made = made && dom_array_make(dom, cells * AIR_DOM_STRIDE * bands, &dom->phase);
    made = made && dom_array_make(dom, all, &dom->light);
    made = made && dom_array_make(dom, all, &dom->field);
    made = made && dom_array_make(dom, all, &dom->next);
    made = made && dom_array_make(dom, DOM_OCTANTS * dom->octant, &dom->radiance);
    made = made && dom_array_make(dom, DOM_OCTANTS * n[1] * row, &dom->face_x);
    made = made && dom_array_make(dom, DOM_OCTANTS * n[0] * row, &dom->face_y);
    made = made && dom_array_make(dom, DOM_OCTANTS * dom->slab * row, &dom->face_z);
    made = made && dom_array_make(dom, DOM_OCTANTS * row, &dom->inflow);
    dom->leaving = air_allocate(dom->context, DOM_OCTANTS * 3 * row, sizeof *dom->leaving);
    dom->peak = air_allocate(dom->context, cells * AIR_DOM_STRIDE, sizeof *dom->peak);
    dom->sums = air_allocate(dom->context, n[2], sizeof *dom->sums);
    for (int axis = 0; axis < 3; axis++) {
        dom->dir[axis] = air_allocate(dom->context, (size_t)dom->directions, sizeof(double));
        made = made && dom->dir[axis] != NULL;
    }
    dom->weight = air_allocate(dom->context, (size_t)dom->directions, sizeof(double));
    return made && dom->weight != NULL && dom->leaving != NULL && dom->peak != NULL &&
           dom->sums != NULL;
}

/* ---- directions ---- */

static void make_directions(air_dom *dom)
{
    const int polar = dom->params.polar, quarter = dom->params.azimuths / 4;
    double nodes[AIR_DOM_POLAR_MAX], weights[AIR_DOM_POLAR_MAX];
    air_gauss_legendre((size_t)polar, nodes, weights);
    for (int o = 0; o < dom->directions; o++) {
        const bool real = o < polar / 2 * quarter;
        const int p = polar / 2 + (real ? o / quarter : 0), a = real ? o % quarter : 0;
        const double z = nodes[p], r = sqrt(1.0 - z * z);
        const double phi = (a + 0.5) * 2.0 * AIR_PI / dom->params.azimuths;
        dom->dir[0][o] = r * cos(phi);
        dom->dir[1][o] = r * sin(phi);
        dom->dir[2][o] = z;
        dom->weight[o] = real ? weights[p] * 2.0 * AIR_PI / dom->params.azimuths : 0.0;
    }
    for (int o = 0; o < dom->directions; o++) {
        for (size_t c = 0; c < AIR_DOM_STRIDE; c++) {
            const size_t at = (size_t)o * AIR_DOM_STRIDE + c;
            dom_put(dom, &dom->weights, at, dom->weight[o]);
            for (int axis = 0; axis < 3; axis++) {
                dom_put(dom, &dom->slope[axis], at,
                        2.0 * dom->dir[axis][o] / (double)dom->params.cell_m[axis]);
            }
        }
    }
}

/* How y_lm changes under mirroring in x, y and z: cos(m phi) is even in y, sin odd; phi to pi - phi
 * and cos theta to -cos theta give the others. */
static int class_of(int l, int m)
{
    const int n = abs(m), odd = n % 2;
    const int x = m >= 0 ? odd : 1 - odd, y = m < 0, z = (l + n) % 2;
    return x | y << 1 | z << 2;
}

static void sort_moments(air_dom *dom)
{
    int count = 0;
    for (int class = 0; class < DOM_OCTANTS; class ++) {
        for (int l = 0; l < dom->params.bands; l++) {
            for (int m = -l; m <= l; m++) {
                if (class_of(l, m) == class) {
                    dom->class_of[count] = class;
                    dom->band_of[count] = l;
                    dom->order[count++] = l * l + l + m;
                }
            }
        }
    }
}

void dom_make_harmonics(air_dom *dom)
{
    const double peak = air_dom_peak(&dom->params, dom->legendre[dom->params.bands]);
    double y[DOM_MOMENTS_MAX];
    for (int o = 0; o < dom->directions; o++) {
        const double dir[3] = {dom->dir[0][o], dom->dir[1][o], dom->dir[2][o]};
        air_sh_evaluate(dom->params.bands, dir, y);
        for (int m = 0; m < dom->moments; m++) {
            const double g = dom_scaled_legendre(dom->legendre[dom->band_of[m]], peak);
            const double emitted = y[dom->order[m]] * (dom->uniform ? g : 1.0);
            for (size_t c = 0; c < AIR_DOM_STRIDE; c++) {
                const size_t at = (size_t)m * dom->row + (size_t)o * AIR_DOM_STRIDE + c;
                dom_put(dom, &dom->emitting, at, emitted);
                dom_put(dom, &dom->gathering, at, dom->weight[o] * y[dom->order[m]]);
            }
        }
    }
}

static const dom_kernel *kernel_of(air_cpu cpu)
{
    switch (cpu) {
#if defined(__x86_64__)
    case AIR_CPU_AVX512:
        return &dom_kernel_avx512;
    case AIR_CPU_AVX2:
        return &dom_kernel_avx2;
    case AIR_CPU_SSE42:
        return &dom_kernel_sse42;
#endif
    default:
        return &dom_kernel_plain;
    }
}

air_status air_dom_create(air_context *context, const air_dom_params *params, air_dom **out_dom)
{
    *out_dom = NULL;
    const air_status status = check(context, params);
    if (status != AIR_OK) {
        return status;
    }
    const bool countable = air_dom_bytes(params, 0) < SIZE_MAX / sizeof(double);
    air_dom *const dom = countable ? air_allocate(context, 1, sizeof *dom) : NULL;
    if (dom == NULL) {
        return air_fail_memory(context, "discrete ordinates");
    }
    dom->context = context;
    dom->params = *params;
    dom->kernel = kernel_of(air_context_cpu(context));
    dom->number = dom->kernel == &dom_kernel_plain ? sizeof(double) : sizeof(float);
    dom->slab = params->size[0] * params->size[1];
    dom->cells = dom->slab * params->size[2];
    dom->moments = params->bands * params->bands;
    dom->directions = direction_count(params);
    dom->row = (size_t)dom->directions * AIR_DOM_STRIDE;
    /* Not a multiple of the cache's ways, which eight streams side by side would share. */
    dom->octant = dom->cells * dom->row + 9 * 16;
    dom->uniform = true;
    dom->legendre[0] = 1.0;
    if (!make_arrays(dom)) {
        air_dom_destroy(dom);
        return air_fail_memory(context, "discrete ordinates");
    }
    make_directions(dom);
    sort_moments(dom);
    dom_make_harmonics(dom);
    *out_dom = dom;
    return AIR_OK;
}

void air_dom_destroy(air_dom *dom)
{
    if (dom == NULL) {
        return;
    }
    for (int i = 0; i < dom->block_count; i++) {
        air_free(dom->context, dom->blocks[i]);
    }
    for (int axis = 0; axis < 3; axis++) {
        air_free(dom->context, dom->dir[axis]);
    }
    air_free(dom->context, dom->weight);
    air_free(dom->context, dom->history.dots);
    air_free(dom->context, dom->leaving);
    air_free(dom->context, dom->peak);
    air_free(dom->context, dom->sums);
    air_free(dom->context, dom);
}

/* dom_solve.c: sweeps until nothing changes, with Anderson's acceleration [Anderson1965], and the
 * books. */
#include <math.h>
#include <string.h>

#include "core/host.h"
#include "core/vec.h"
#include "ordinates/dom.h"

void air_dom_solve_params_default(air_dom_solve_params *params)
{
    memset(params, 0, sizeof *params);
    params->sweeps = 32;
    params->change = 1e-3;
    params->depth = 4;
}

/* ---- one sweep ---- */

static void emit_slab(void *user, size_t k, size_t worker)
{
    air_dom *const dom = user;
    (void)worker;
    dom->kernel->emit(dom, &dom->field, k);
}

static void sweep_octant(void *user, size_t octant, size_t worker)
{
    air_dom *const dom = user;
    (void)worker;
    dom->kernel->sweep(dom, (int)octant);
}

static void gather_slab(void *user, size_t k, size_t worker)
{
    air_dom *const dom = user;
    (void)worker;
    dom->kernel->gather(dom, k);
}

/* And the next sweep's sources, while moments and radiances are near. */
static void gather_and_emit_slab(void *user, size_t k, size_t worker)
{
    air_dom *const dom = user;
    (void)worker;
    dom->kernel->gather(dom, k);
    dom->kernel->emit(dom, &dom->next, k);
}

/* How much the moments changed, as a share. */
static double change_of(const air_dom *dom)
{
    dom_sums sums = {0.0, 0.0};
    for (size_t k = 0; k < dom->params.size[2]; k++) {
        sums.change += dom->sums[k].change;
        sums.size += dom->sums[k].size;
    }
    return sums.size > 0.0 ? sqrt(sums.change / sums.size) : 0.0;
}

static void swap(dom_array *a, dom_array *b)
{
    const dom_array keep = *a;
    *a = *b;
    *b = keep;
}

/* ---- acceleration ---- */

/* An array that a solve before, or one that ended for lack of memory, may have made. */
static bool have_array(air_dom *dom, dom_array *array)
{
    const size_t all = dom->cells * (size_t)dom->moments * AIR_DOM_STRIDE;
    return array->any != NULL || dom_array_make(dom, all, array);
}

static air_status make_history(air_dom *dom, int depth)
{
    dom_history *const h = &dom->history;
    bool made = true;
    h->count = h->next_slot = 0;
    if (depth == 0) {
        return AIR_OK;
    }
    if (h->dots == NULL) {
        h->dots = air_allocate(dom->context, dom->params.size[2],
                               2 * AIR_DOM_DEPTH_MAX * sizeof *h->dots);
    }
    made = h->dots != NULL && have_array(dom, &h->residual) && have_array(dom, &h->last_residual) &&
           have_array(dom, &h->last_next);
    for (int i = 0; i < depth && made; i++) {
        made = have_array(dom, &h->residuals[i]) && have_array(dom, &h->nexts[i]);
    }
    return made ? AIR_OK : air_fail_memory(dom->context, "discrete ordinates");
}

/* Keeps the latest step's differences of some numbers, and adds their products with all that are
 * kept to dots. */
static void remember(air_dom *dom, size_t begin, size_t end, double *dots)
{
    dom_history *const h = &dom->history;
    const dom_kernel *const kernel = dom->kernel;
    dom_array *const latest = &h->residuals[h->next_slot];
    kernel->subtract(&dom->next, &dom->field, &h->residual, begin, end);
    if (h->count == 0) {
        return;
    }
    kernel->subtract(&h->residual, &h->last_residual, latest, begin, end);
    kernel->subtract(&dom->next, &h->last_next, &h->nexts[h->next_slot], begin, end);
    for (int i = 0; i < h->count; i++) {
        dots[i] += kernel->dot(latest, &h->residuals[i], begin, end);
        dots[AIR_DOM_DEPTH_MAX + i] += kernel->dot(&h->residual, &h->residuals[i], begin, end);
    }
}

/* In portions that stay near. */
static void gather_and_remember_slab(void *user, size_t k, size_t worker)
{
    enum { PORTION = 1024 };
    air_dom *const dom = user;
    double *const dots = dom->history.dots + k * 2 * AIR_DOM_DEPTH_MAX;
    size_t begin, end;
    (void)worker;
    dom->kernel->gather(dom, k);
    dom_slab_range(dom, k, &begin, &end);
    memset(dots, 0, 2 * AIR_DOM_DEPTH_MAX * sizeof *dots);
    for (; begin < end; begin += PORTION) {
        remember(dom, begin, end - begin < PORTION ? end : begin + PORTION, dots);
    }
}

static void sum_dots(dom_history *h, size_t slabs)
{
    for (int i = 0; i < h->count; i++) {
        double product = 0.0, right = 0.0;
        for (size_t k = 0; k < slabs; k++) {
            product += h->dots[k * 2 * AIR_DOM_DEPTH_MAX + (size_t)i];
            right += h->dots[k * 2 * AIR_DOM_DEPTH_MAX + AIR_DOM_DEPTH_MAX + (size_t)i];
        }
        h->gram[h->next_slot][i] = h->gram[i][h->next_slot] = product;
        h->right[i] = right;
    }
}

/* Solves (gram + 1e-10 trace) x = right by Cholesky's decomposition; false where that is singular.
 */
static bool solve_normal(const dom_history *h, double *x)
{
    const int n = h->count;
    double factor[AIR_DOM_DEPTH_MAX][AIR_DOM_DEPTH_MAX], trace = 0.0;
    for (int i = 0; i < n; i++) {
        trace += h->gram[i][i];
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = h->gram[i][j] + (i == j ? 1e-10 * trace : 0.0);
            for (int k = 0; k < j; k++) {
                sum -= factor[i][k] * factor[j][k];
            }
            if (i == j && !(sum > 0.0)) {
                return false;
            }
            factor[i][j] = i == j ? sqrt(sum) : sum / factor[j][j];
        }
    }
    for (int i = 0; i < n; i++) {
        x[i] = h->right[i];
        for (int k = 0; k < i; k++) {
            x[i] -= factor[i][k] * x[k];
        }
        x[i] /= factor[i][i];
    }
    for (int i = n; i-- > 0;) {
        for (int k = i + 1; k < n; k++) {
            x[i] -= factor[k][i] * x[k];
        }
        x[i] /= factor[i][i];
    }
    return true;
}

typedef struct mixing {
    air_dom *dom;
    double factors[AIR_DOM_DEPTH_MAX];
    int count;
} mixing;

static void mix_and_emit_slab(void *user, size_t k, size_t worker)
{
    const mixing *const self = user;
    air_dom *const dom = self->dom;
    size_t begin, end;
    (void)worker;
    dom_slab_range(dom, k, &begin, &end);
    dom->kernel->combine(&dom->next, dom->history.nexts, self->factors, self->count, &dom->field,
                         begin, end);
    /* Extrapolated fluence may be negative, which no source can be. */
    for (; begin < end; begin += (size_t)dom->moments * AIR_DOM_STRIDE) {
        for (size_t c = 0; c < 3; c++) {
            dom_put(dom, &dom->field, begin + c, fmax(dom_get(dom, &dom->field, begin + c), 0.0));
        }
    }
    dom->kernel->emit(dom, &dom->field, k);
}

/* field = the combination of the last results whose residual is least, and its sources. */
static void accelerate(air_dom *dom, int depth)
{
    dom_history *const h = &dom->history;
    mixing mix = {.dom = dom};
    if (h->count > 0) {
        sum_dots(h, dom->params.size[2]);
        mix.count = solve_normal(h, mix.factors) ? h->count : 0;
        h->next_slot = (h->next_slot + 1) % depth;
    }
    air_parallel_for(dom->context, dom->params.size[2], mix_and_emit_slab, &mix);
    swap(&h->residual, &h->last_residual);
    swap(&dom->next, &h->last_next);
}

/* ---- books ---- */

static double face_area(const air_dom *dom, int axis)
{
    const float *const m = dom->params.cell_m;
    return (double)m[(axis + 1) % 3] * (double)m[(axis + 2) % 3];
}

static size_t face_cells(const air_dom *dom, int axis)
{
    return dom->cells / dom->params.size[axis];
}

/* Power through the box's faces: out, and in by the inflow. */
static void add_boundary(const air_dom *dom, size_t c, air_dom_books *books)
{
    for (int octant = 0; octant < DOM_OCTANTS; octant++) {
        for (int axis = 0; axis < 3; axis++) {
            const int side = octant >> axis & 1;
            const bool lit = (dom->inflow_faces >> (2 * axis + side)) & 1u;
            double out = 0.0, in = 0.0;
            for (int o = 0; o < dom->directions; o++) {
                const size_t at = (size_t)o * AIR_DOM_STRIDE + c;
                const double share = dom->weight[o] * dom->dir[axis][o] * face_area(dom, axis);
                out += share * dom->leaving[((size_t)octant * 3 + (size_t)axis) * dom->row + at];
                in += share * dom_get(dom, &dom->inflow, (size_t)octant * dom->row + at);
            }
            books->out[2 * axis + 1 - side] += out;
            books->in += lit ? in * (double)face_cells(dom, axis) : 0.0;
        }
    }
}

/* Of the sweep that made next from field. */
static void balance(const air_dom *dom, air_dom_books books[3])
{
    const float *const m = dom->params.cell_m;
    const double volume = (double)m[0] * (double)m[1] * (double)m[2];
    const double fluence = sqrt(4.0 * AIR_PI) * volume;
    for (size_t i = 0; i < 3 * dom->cells; i++) {
        const size_t cell = i / 3, c = i % 3, at = cell * AIR_DOM_STRIDE + c;
        const size_t zero = cell * (size_t)dom->moments * AIR_DOM_STRIDE + c;
        const double sigma_s = dom_get(dom, &dom->sigma_s, at);
        const double sigma_a = dom_get(dom, &dom->sigma_a, at);
        const double now = dom_get(dom, &dom->next, zero);
        books[c].in += fluence * sigma_s * dom_get(dom, &dom->light, zero);
        books[c].absorbed += fluence * sigma_a * now;
        books[c].residual += fluence * sigma_s * (now - dom_get(dom, &dom->field, zero));
    }
    for (size_t c = 0; c < 3; c++) {
        add_boundary(dom, c, &books[c]);
    }
}

/* ---- all ---- */

/* Leaves in next what the last sweep made of field. */
static void sweep_all(air_dom *dom, const air_dom_solve_params *params, air_dom_report *result)
{
    const size_t slabs = dom->params.size[2];
    dom_history *const h = &dom->history;
    air_parallel_for(dom->context, slabs, emit_slab, dom);
    while (true) {
        const bool last = result->sweeps + 1 >= params->sweeps;
        air_parallel_for(dom->context, DOM_OCTANTS, sweep_octant, dom);
        if (last) {
            air_parallel_for(dom->context, slabs, gather_slab, dom);
        } else if (params->depth == 0) {
            air_parallel_for(dom->context, slabs, gather_and_emit_slab, dom);
        } else {
            h->count = result->sweeps == 0 ? 0 : h->count + (h->count < params->depth);
            air_parallel_for(dom->context, slabs, gather_and_remember_slab, dom);
        }
        result->change = change_of(dom);
        result->sweeps++;
        if (last || result->change < params->change) {
            return;
        }
        if (params->depth == 0) {
            swap(&dom->field, &dom->next);
        } else {
            accelerate(dom, params->depth);
        }
    }
}

air_status air_dom_solve(air_dom *dom, const air_dom_solve_params *params, air_dom_report *report)
{
    air_dom_report result = {0};
    if (params->sweeps < 1 || !(params->change >= 0.0) || params->depth < 0 ||
        params->depth > AIR_DOM_DEPTH_MAX) {
        return air_fail(dom->context, AIR_ERROR_ARGUMENT,
                        "discrete ordinates: %u sweeps, change %g, depth %d: expected at least one "
                        "sweep, a change >= 0 and a depth of 0 to %d",
                        params->sweeps, params->change, params->depth, (int)AIR_DOM_DEPTH_MAX);
    }
    const air_status status = make_history(dom, params->depth);
    if (status != AIR_OK) {
        return status;
    }
    if (params->cold) {
        memset(dom->field.any, 0, dom->cells * (size_t)dom->moments * AIR_DOM_STRIDE * dom->number);
    }
    sweep_all(dom, params, &result);
    if (report != NULL) {
        balance(dom, result.books);
        *report = result;
    }
    swap(&dom->field, &dom->next);
    return AIR_OK;
}

/* oracle_ordinates_field.c: runs the kernels in a cube under a beam. */
#include "oracle_ordinates_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/harmonics.h"
#include "core/quadrature.h"
#include "core/vec.h"

double field_beam(double sigma, double z0, double z1)
{
    const double depth = sigma * (z1 - z0);
    return exp(-sigma * z0) * (depth > 0.0 ? -expm1(-depth) / depth : 1.0);
}

static bool field_make(size_t n, bool with_bins, cube_field *out)
{
    memset(out, 0, sizeof *out);
    out->n = n;
    out->fluence = calloc(n * n * n, sizeof *out->fluence);
    out->flux = calloc(n * n * n, sizeof *out->flux);
    out->bins = with_bins ? calloc(n * n * BINS, sizeof *out->bins) : NULL;
    return out->fluence != NULL && out->flux != NULL && (out->bins != NULL || !with_bins);
}

void field_finish(cube_field *self)
{
    free(self->fluence);
    free(self->flux);
    free(self->bins);
    memset(self, 0, sizeof *self);
}

static double imbalance(double in, double absorbed, double residual, const double out[FACES])
{
    double sum = absorbed + residual;
    for (int face = 0; face < FACES; face++) {
        sum += out[face];
    }
    return fabs(sum - in) / in;
}

/* Which of the two middle slices a cell is in: its place in bins; SIZE_MAX: neither. */
static size_t middle_place(size_t n, size_t cell)
{
    const size_t i = cell % n, j = cell / n % n, k = cell / n / n;
    return j == n / 2 - 1 || j == n / 2 ? k * n + i : SIZE_MAX;
}

/* ---- rectilinear grids ---- */

/* Finer than what is compared, so that the flux is known from them too, to 1e-3. */
enum { FINER = 2, FINE_BINS = FINER * BINS };

static void take_steps(const simulated *what, const float *fluence, const float *beam,
                       const float *binned, cube_field *out)
{
    const size_t n = out->n;
    for (size_t cell = 0; cell < n * n * n; cell++) {
        const double direct = (double)beam[cell];
        const size_t place = middle_place(n, cell);
        out->fluence[cell] = what->light * ((double)fluence[cell] + direct);
        out->flux[cell] = what->light * direct;
        if (binned == NULL) {
            continue;
        }
        for (int bin = 0; bin < FINE_BINS; bin++) {
            const double there = what->light * (double)binned[cell * FINE_BINS + (size_t)bin];
            out->flux[cell] += there * (-1.0 + (2.0 * bin + 1.0) / FINE_BINS);
            if (place != SIZE_MAX) {
                out->bins[place * BINS + (size_t)(bin / FINER)] += 0.5 * there;
            }
        }
        if (place != SIZE_MAX) {
            out->bins[place * BINS + BINS - 1] += 0.5 * what->light * direct;
        }
    }
}

static void take_books(const air_ordinates_books *books, cube_field *out)
{
    for (int face = 0; face < FACES; face++) {
        out->leaves[face] = books->out[face] / books->in;
    }
    out->residual = books->residual / books->in;
    out->imbalance = imbalance(books->in, books->absorbed, books->residual, books->out);
}

bool field_by_steps(air_context *context, const simulated *what, size_t n,
                    const air_ordinates_params *params, bool with_bins, cube_field *out)
{
    const size_t count = n * n * n, bins = with_bins ? FINE_BINS : 0;
    const size_t at = (n / 2 * n + n / 2 - 1) * n + n / 2 - 1;
    float *const numbers = malloc(count * (7 + bins) * sizeof *numbers);
    float *const to = numbers + 3 * count; /* fluence, beam, energy, mean cosine, bins */
    const air_ordinates_cells cells = {.size = {n, n, n},
                                       .cell_m = (float)(what->size_m / (double)n),
                                       .sigma_s = numbers,
                                       .sigma_a = numbers + count,
                                       .g = numbers + 2 * count};
    air_ordinates_books books;
    const air_ordinates_results results = {.fluence = to,
                                           .beam = to + count,
                                           .energy = to + 2 * count,
                                           .asymmetry = to + 3 * count,
                                           .bins = bins,
                                           .binned = with_bins ? to + 4 * count : NULL,
                                           .books = &books};
    bool good = field_make(n, with_bins, out) && numbers != NULL;
    for (size_t i = 0; i < count && good; i++) {
        numbers[i] = (float)what->sigma_s;
        numbers[count + i] = (float)what->sigma_a;
        numbers[2 * count + i] = (float)what->g;
    }
    const size_t bytes = good ? air_ordinates_scratch(&cells, params) : 0;
    void *const scratch = bytes > 0 ? aligned_alloc(64, (bytes + 63) / 64 * 64) : NULL;
    good = good && scratch != NULL &&
           air_ordinates_run(context, &cells, params, scratch, &results) == AIR_OK;
    if (good) {
        take_steps(what, to, to + count, results.binned, out);
        take_books(&books, out);
        out->scattered = (double)to[at] + (double)to[count + at];
        out->energy = (double)to[2 * count + at];
        out->mean_cosine = (double)to[3 * count + at];
    }
    free(scratch);
    free(numbers);
    return good;
}

/* ---- discrete ordinates ---- */

/* Integrals of y_l0 times 2 pi over the bins. */
static void harmonics_in_bins(int bands, double out[BINS][AIR_SH_ORDER_MAX])
{
    double nodes[6], weights[6], y[AIR_SH_ORDER_MAX];
    air_gauss_legendre(6, nodes, weights);
    for (int bin = 0; bin < BINS; bin++) {
        memset(out[bin], 0, sizeof out[bin]);
        for (int i = 0; i < 6; i++) {
            air_zh_evaluate(bands, -1.0 + (2.0 * bin + 1.0 + nodes[i]) / BINS, y);
            for (int l = 0; l < bands; l++) {
                out[bin][l] += 2.0 * AIR_PI * weights[i] / BINS * y[l];
            }
        }
    }
}

static double beam_in(const cube_field *field, const simulated *what, double sigma, size_t cell)
{
    const double edge = what->size_m / (double)field->n;
    const double k = (double)(cell / field->n / field->n);
    return what->light * field_beam(sigma, k * edge, (k + 1.0) * edge);
}

static void take_moments(const simulated *what, double sigma, int bands, const float *moments,
                         cube_field *out)
{
    const size_t n = out->n, stride = (size_t)(bands * bands) * AIR_DOM_STRIDE;
    double bins[BINS][AIR_SH_ORDER_MAX];
    harmonics_in_bins(bands, bins);
    for (size_t cell = 0; cell < n * n * n; cell++) {
        const float *const at = moments + cell * stride;
        const double direct = beam_in(out, what, sigma, cell);
        const size_t place = out->bins != NULL ? middle_place(n, cell) : SIZE_MAX;
        out->fluence[cell] = sqrt(4.0 * AIR_PI) * (double)at[0] + direct;
        out->flux[cell] =
            bands > 1 ? sqrt(4.0 * AIR_PI / 3.0) * (double)at[2 * (size_t)AIR_DOM_STRIDE] + direct
                      : direct;
        for (int bin = 0; bin < BINS && place != SIZE_MAX; bin++) {
            double sum = bin == BINS - 1 ? direct : 0.0;
            for (int l = 0; l < bands; l++) {
                sum += bins[bin][l] * (double)at[(size_t)(l * l + l) * AIR_DOM_STRIDE];
            }
            out->bins[place * BINS + (size_t)bin] += 0.5 * sum;
        }
    }
}

/* Numbers of the medium and moments of the beam. */
static bool set_up(air_dom *dom, const simulated *what, double sigma, int bands,
                   const cube_field *field, float *moments, float *numbers)
{
    static const double along_z[3] = {0.0, 0.0, 1.0};
    const size_t count = field->n * field->n * field->n, each = (size_t)(bands * bands);
    const air_dom_phase phase = {.g = numbers + 6 * count};
    double y[AIR_SH_COUNT_MAX];
    air_sh_evaluate(bands, along_z, y);
    for (size_t i = 0; i < 3 * count; i++) {
        numbers[i] = (float)what->sigma_s;
        numbers[3 * count + i] = (float)what->sigma_a;
        numbers[6 * count + i] = (float)what->g;
    }
    for (size_t cell = 0; cell < count; cell++) {
        const double beam = beam_in(field, what, sigma, cell);
        for (size_t i = 0; i < each * AIR_DOM_STRIDE; i++) {
            moments[cell * each * AIR_DOM_STRIDE + i] =
                i % AIR_DOM_STRIDE < 3 ? (float)(beam * y[i / AIR_DOM_STRIDE]) : 0.0f;
        }
    }
    return air_dom_set_medium(dom, numbers, numbers + 3 * count, &phase) == AIR_OK &&
           air_dom_set_light(dom, moments) == AIR_OK;
}

bool field_by_dom(air_context *context, const simulated *what, size_t n, const field_dom *how,
                  bool with_bins, cube_field *out)
{
    const size_t count = n * n * n, each = (size_t)(how->bands * how->bands);
    const float edge = (float)(what->size_m / (double)n);
    float *const moments = malloc(count * (each * AIR_DOM_STRIDE + 9) * sizeof *moments);
    air_dom_params params;
    air_dom_report report;
    air_dom *dom = NULL;
    air_dom_params_default(&params);
    for (int axis = 0; axis < 3; axis++) {
        params.size[axis] = n;
        params.cell_m[axis] = edge;
    }
    params.bands = how->bands;
    params.polar = how->polar;
    params.azimuths = how->azimuths;
    const double peak = air_dom_peak(&params, pow(what->g, how->bands));
    const double sigma = what->sigma_s * (1.0 - peak) + what->sigma_a;
    const bool good = field_make(n, with_bins, out) && moments != NULL &&
                      air_dom_create(context, &params, &dom) == AIR_OK &&
                      set_up(dom, what, sigma, how->bands, out, moments,
                             moments + count * each * AIR_DOM_STRIDE) &&
                      air_dom_solve(dom, &how->solve, &report) == AIR_OK;
    if (good) {
        const air_dom_books *const b = &report.books[0];
        const double in = what->light * what->size_m * what->size_m;
        air_dom_moments(dom, moments);
        take_moments(what, sigma, how->bands, moments, out);
        for (int face = 0; face < FACES; face++) {
            out->leaves[face] = b->out[face] / in;
        }
        out->leaves[FACES - 1] += exp(-sigma * what->size_m);
        out->residual = b->residual / in;
        out->imbalance = imbalance(b->in, b->absorbed, b->residual, b->out);
    }
    air_dom_destroy(dom);
    free(moments);
    return good;
}

/* dom_plain.c: the solver's kernel in plain C and doubles: what the versions in lanes are held
 * against. Sections in brackets: src/ordinates/README.md. */
#include <math.h>

#include "core/vec.h"
#include "ordinates/dom.h"

enum { CHANNELS = AIR_DOM_STRIDE };

static double *radiance_at(const air_dom *dom, int octant, size_t cell)
{
    return dom->radiance.d + dom_radiance(dom, (size_t)octant, cell);
}

/* What a cell's moments send along each direction of an octant, per metre. */
static void emit_octant(const air_dom *dom, const double *scattered, int octant, double *source)
{
    const int *const begin = dom_class_begin[dom->params.bands];
    for (size_t o = 0; o < dom->row; o++) {
        double sum = 0.0;
        for (int class = 0; class < DOM_OCTANTS; class ++) {
            double part = 0.0;
            for (int m = begin[class]; m < begin[class + 1]; m++) {
                part += dom->emitting.d[(size_t)m * dom->row + o] *
                        scattered[m * CHANNELS + (int)(o % CHANNELS)];
            }
            sum += dom_sign(class, octant) * part;
        }
        source[o] = sum;
    }
}

/* Series of peaked phase functions dip below 0: what is negative goes, and the rest is scaled so
 * that as much is sent as before. */
static void keep_positive(const air_dom *dom, size_t cell, const double total[CHANNELS])
{
    double positive[CHANNELS] = {0.0};
    for (int octant = 0; octant < DOM_OCTANTS; octant++) {
        double *const source = radiance_at(dom, octant, cell);
        for (size_t o = 0; o < dom->row; o++) {
            source[o] = fmax(source[o], 0.0);
            positive[o % CHANNELS] += dom->weights.d[o] * source[o];
        }
    }
    for (int octant = 0; octant < DOM_OCTANTS; octant++) {
        double *const source = radiance_at(dom, octant, cell);
        for (size_t o = 0; o < dom->row; o++) {
            const double sum = positive[o % CHANNELS];
            source[o] *= sum > 0.0 ? fmax(total[o % CHANNELS], 0.0) / sum : 0.0;
        }
    }
}

static void emit_cell(air_dom *dom, const dom_array *moments, size_t cell)
{
    const size_t count = (size_t)dom->moments * CHANNELS;
    const double *const field = moments->d + cell * count;
    const double *const light = dom->light.d + cell * count;
    const double *const sigma_s = dom->sigma_s.d + cell * CHANNELS;
    double scattered[DOM_MOMENTS_MAX * CHANNELS], total[CHANNELS];
    for (size_t i = 0; i < count; i++) {
        const size_t c = i % CHANNELS, l = (size_t)dom->band_of[i / CHANNELS];
        const size_t at = (cell * (size_t)dom->params.bands + l) * CHANNELS + c;
        scattered[i] = sigma_s[c] * (field[i] + light[i]);
        scattered[i] *= dom->uniform ? 1.0 : dom->phase.d[at];
    }
    for (int c = 0; c < CHANNELS; c++) {
        total[c] = sqrt(4.0 * AIR_PI) * scattered[c];
    }
    for (int octant = 0; octant < DOM_OCTANTS; octant++) {
        emit_octant(dom, scattered, octant, radiance_at(dom, octant, cell));
    }
    keep_positive(dom, cell, total);
}

static void emit(air_dom *dom, const dom_array *field, size_t k)
{
    for (size_t cell = k * dom->slab; cell < (k + 1) * dom->slab; cell++) {
        emit_cell(dom, field, cell);
    }
}

/* One cell and direction: x, y, z are what arrives through the near faces, and become what leaves.
 * Diamond differences; where these are negative, steps. */
static double pass_cell(const air_dom *dom, size_t o, double source, double sigma_t, double in[3])
{
    double arrived = source, slopes = 0.0, half = source;
    for (int axis = 0; axis < 3; axis++) {
        const double slope = dom->slope[axis].d[o];
        arrived += slope * in[axis];
        half += 0.5 * slope * in[axis];
        slopes += slope;
    }
    const double psi = arrived / (sigma_t + slopes);
    const double twice = 2.0 * psi;
    if (dom->params.diamond && twice >= in[0] && twice >= in[1] && twice >= in[2]) {
        for (int axis = 0; axis < 3; axis++) {
            in[axis] = twice - in[axis];
        }
        return psi;
    }
    in[0] = in[1] = in[2] = half / (sigma_t + 0.5 * slopes);
    return in[0];
}

/* A row along x, from the side that the octant's light comes from. */
static void sweep_row(air_dom *dom, int octant, size_t j, size_t k)
{
    const size_t n = dom->params.size[0], row = dom->row;
    double *const face_x = dom->face_x.d + ((size_t)octant * dom->params.size[1] + j) * row;
    double *const face_y = dom->face_y.d + (size_t)octant * n * row;
    double *const face_z = dom->face_z.d + ((size_t)octant * dom->slab + j * n) * row;
    const bool lit = (dom->inflow_faces >> (octant & 1)) & 1u;
    for (size_t o = 0; o < row; o++) {
        double in[3] = {lit ? dom->inflow.d[(size_t)octant * row + o] : 0.0, 0.0, 0.0};
        for (size_t step = 0; step < n; step++) {
            const size_t i = (octant & 1) != 0 ? n - 1 - step : step;
            const size_t cell = k * dom->slab + j * n + i;
            double *const radiance = radiance_at(dom, octant, cell) + o;
            in[1] = face_y[i * row + o];
            in[2] = face_z[i * row + o];
            *radiance =
                pass_cell(dom, o, *radiance, dom->sigma_t.d[cell * CHANNELS + o % CHANNELS], in);
            face_y[i * row + o] = in[1];
            face_z[i * row + o] = in[2];
        }
        face_x[o] = in[0];
    }
}

/* What enters through a face of the box, or nothing. */
static void enter(const air_dom *dom, int octant, int axis, double *face, size_t places)
{
    const int side = octant >> axis & 1;
    const bool lit = (dom->inflow_faces >> (2 * axis + side)) & 1u;
    for (size_t i = 0; i < places * dom->row; i++) {
        face[i] = lit ? dom->inflow.d[(size_t)octant * dom->row + i % dom->row] : 0.0;
    }
}

static void leave(const air_dom *dom, double *sum, const double *face, size_t places)
{
    for (size_t i = 0; i < places * dom->row; i++) {
        sum[i % dom->row] += face[i];
    }
}

static void sweep(air_dom *dom, int octant)
{
    const size_t *const n = dom->params.size, row = dom->row;
    double *const leaving = dom->leaving + (size_t)octant * 3 * row;
    double *const face_y = dom->face_y.d + (size_t)octant * n[0] * row;
    double *const face_z = dom->face_z.d + (size_t)octant * dom->slab * row;
    for (size_t o = 0; o < 3 * row; o++) {
        leaving[o] = 0.0;
    }
    enter(dom, octant, 2, face_z, dom->slab);
    for (size_t slab = 0; slab < n[2]; slab++) {
        const size_t k = (octant & 4) != 0 ? n[2] - 1 - slab : slab;
        enter(dom, octant, 1, face_y, n[0]);
        for (size_t line = 0; line < n[1]; line++) {
            sweep_row(dom, octant, (octant & 2) != 0 ? n[1] - 1 - line : line, k);
        }
        leave(dom, leaving, dom->face_x.d + (size_t)octant * n[1] * row, n[1]);
        leave(dom, leaving + row, face_y, n[0]);
    }
    leave(dom, leaving + 2 * row, face_z, dom->slab);
}

static void gather(air_dom *dom, size_t k)
{
    const size_t count = (size_t)dom->moments * CHANNELS;
    dom_sums sums = {0.0, 0.0};
    for (size_t cell = k * dom->slab; cell < (k + 1) * dom->slab; cell++) {
        double *const next = dom->next.d + cell * count;
        const double *const field = dom->field.d + cell * count;
        for (int m = 0; m < dom->moments; m++) {
            double sum[CHANNELS] = {0.0};
            for (int octant = 0; octant < DOM_OCTANTS; octant++) {
                const double *const radiance = radiance_at(dom, octant, cell);
                for (size_t o = 0; o < dom->row; o++) {
                    sum[o % CHANNELS] += dom_sign(dom->class_of[m], octant) * radiance[o] *
                                         dom->gathering.d[(size_t)m * dom->row + o];
                }
            }
            for (int c = 0; c < CHANNELS; c++) {
                next[m * CHANNELS + c] = sum[c];
            }
        }
        for (size_t i = 0; i < count; i++) {
            sums.change += (next[i] - field[i]) * (next[i] - field[i]);
            sums.size += next[i] * next[i];
        }
    }
    dom->sums[k] = sums;
}

static double dot(const dom_array *a, const dom_array *b, size_t begin, size_t end)
{
    double sum = 0.0;
    for (size_t i = begin; i < end; i++) {
        sum += a->d[i] * b->d[i];
    }
    return sum;
}

static void subtract(const dom_array *a, const dom_array *b, dom_array *out, size_t begin,
                     size_t end)
{
    for (size_t i = begin; i < end; i++) {
        out->d[i] = a->d[i] - b->d[i];
    }
}

static void combine(const dom_array *a, const dom_array *parts, const double *factors, int count,
                    dom_array *out, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i++) {
        double sum = a->d[i];
        for (int part = 0; part < count; part++) {
            sum -= factors[part] * parts[part].d[i];
        }
        out->d[i] = sum;
    }
}

const dom_kernel dom_kernel_plain = {emit, sweep, gather, dot, subtract, combine};

/* dom_lanes_sweep.h: how light passes the cells, in lanes. For dom_lanes.h alone. */
#ifndef AIR_ORDINATES_DOM_LANES_SWEEP_H
#define AIR_ORDINATES_DOM_LANES_SWEEP_H

#include <math.h>

#include "ordinates/dom_channels.h"

typedef struct slopes {
    lanes x, y, z, sum; /* 2 |O| / cell_m */
} slopes;

/* Steps where diamond differences left a negative number. */
static lanes step_instead(const slopes *s, lanes source, lanes sigma_t, lane_mask negative,
                          const lanes in[3], lanes psi, lanes out[3])
{
    const lanes half = lanes_all(0.5f);
    const lanes arrived = lanes_madd(s->x, in[0], lanes_madd(s->y, in[1], s->z * in[2]));
    const lanes step =
        lanes_madd(half, arrived, source) * lanes_inverse(lanes_madd(half, s->sum, sigma_t));
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = lanes_select(negative, step, out[axis]);
    }
    return lanes_select(negative, step, psi);
}

/* floor: outflow below it is replaced. */
static inline lanes pass_cell(const slopes *s, lanes floor, lanes source, lanes sigma_t, lanes *x,
                              lanes *y, lanes *z)
{
    const lanes in[3] = {*x, *y, *z};
    const lanes inverse = lanes_inverse(sigma_t + s->sum);
    const lanes rest = lanes_madd(s->y, in[1], lanes_madd(s->z, in[2], source));
    lanes psi = lanes_madd(s->x, in[0], rest) * inverse;
    const lanes twice = psi + psi;
    lanes out[3] = {twice - in[0], twice - in[1], twice - in[2]};
    const lane_mask negative = lanes_less(lanes_min(out[0], lanes_min(out[1], out[2])), floor);
    if (__builtin_expect(mask_any(negative), 0)) {
        psi = step_instead(s, source, sigma_t, negative, in, psi, out);
    }
    *x = out[0];
    *y = out[1];
    *z = out[2];
    return psi;
}

/* Rows that are swept side by side, each a cell behind the one before, from which it takes what
 * arrives along y: a cell waits for its neighbours, and the other rows fill the time. */
enum { ROWS = 4 };

typedef struct strip {
    slopes s;
    lanes floor;
    /* of the first row's next cell; that of the row behind is `back` numbers away */
    float *radiance, *face_y, *face_z;
    const float *sigma_t;
    ptrdiff_t ahead, back;                /* to the next cell, to the next row's cell */
    ptrdiff_t ahead_sigma, back_sigma;    /* likewise */
    ptrdiff_t to_strip;                   /* to the cell of the row that comes `count` rows later */
    lanes x0, x1, x2, x3, y0, y1, y2, y3; /* what goes on along x and y, by row */
} strip;

static inline void pass_row(strip *self, int r, lanes *x, lanes arriving, lanes *y)
{
    float *const radiance = self->radiance + r * self->back;
    float *const face_z = self->face_z + r * self->back;
    __builtin_prefetch(radiance + self->to_strip, 1);
    lanes z = lanes_load(face_z), along_y = arriving;
    const lanes sigma_t = lanes_repeat(self->sigma_t + r * self->back_sigma);
    lanes_store(radiance,
                pass_cell(&self->s, self->floor, lanes_load(radiance), sigma_t, x, &along_y, &z));
    lanes_store(face_z, z);
    *y = along_y;
}

/* A cell in each of the rows first .. last of `count`. */
static inline __attribute__((always_inline)) void pass_rows(strip *self, int first, int last,
                                                            int count)
{
    if (first <= 3 && last >= 3) {
        pass_row(self, 3, &self->x3, self->y2, &self->y3);
    }
    if (first <= 2 && last >= 2) {
        pass_row(self, 2, &self->x2, self->y1, &self->y2);
    }
    if (first <= 1 && last >= 1) {
        pass_row(self, 1, &self->x1, self->y0, &self->y1);
    }
    if (first <= 0) {
        pass_row(self, 0, &self->x0, lanes_load(self->face_y), &self->y0);
    }
    if (last == count - 1) {
        lanes_store(self->face_y - last * self->ahead, last == 3 ? self->y3 : self->y0);
    }
    self->radiance += self->ahead;
    self->face_y += self->ahead;
    self->face_z += self->ahead;
    self->sigma_t += self->ahead_sigma;
}

/* Four rows of n cells. */
static inline void pass_strip(strip *self, int n)
{
    int step = 0;
    for (; step < ROWS - 1; step++) {
        pass_rows(self, step < n ? 0 : step - n + 1, step, ROWS);
    }
    for (; step < n; step++) {
        pass_rows(self, 0, ROWS - 1, ROWS);
    }
    for (; step < n + ROWS - 1; step++) {
        pass_rows(self, step - n + 1, ROWS - 1, ROWS);
    }
}

static inline void pass_line(strip *self, int n)
{
    for (int step = 0; step < n; step++) {
        pass_rows(self, 0, 0, 1);
    }
}

/* `count` rows along x of slab k, four or one, from `line` on in the order in which the octant's
 * light passes them. */
static inline void sweep_rows(air_dom *dom, int octant, size_t line, size_t k, int count)
{
    const size_t *const n = dom->params.size, row = dom->row;
    const ptrdiff_t to_cell = (octant & 1) != 0 ? -1 : 1;
    const ptrdiff_t to_line = (octant & 2) != 0 ? -(ptrdiff_t)n[0] : (ptrdiff_t)n[0];
    const bool lit = (dom->inflow_faces >> (octant & 1)) & 1u;
    const size_t i = to_cell < 0 ? n[0] - 1 : 0, j = to_line < 0 ? n[1] - 1 - line : line;
    const size_t place = j * n[0] + i, cell = k * dom->slab + place;
    float *const face_x = dom->face_x.f + ((size_t)octant * n[1] + line) * row;
    strip self;
    self.floor = lanes_all(dom->params.diamond ? 0.0f : INFINITY);
    self.ahead = to_cell * (ptrdiff_t)row;
    self.back = (to_line - to_cell) * (ptrdiff_t)row;
    self.ahead_sigma = to_cell * CHANNELS;
    self.back_sigma = (to_line - to_cell) * CHANNELS;
    self.to_strip = count * to_line * (ptrdiff_t)row;
    for (size_t o = 0; o < row; o += LANES) {
        self.s.x = lanes_load(dom->slope[0].f + o);
        self.s.y = lanes_load(dom->slope[1].f + o);
        self.s.z = lanes_load(dom->slope[2].f + o);
        self.s.sum = self.s.x + self.s.y + self.s.z;
        self.radiance = dom->radiance.f + dom_radiance(dom, (size_t)octant, cell) + o;
        self.face_y = dom->face_y.f + ((size_t)octant * n[0] + i) * row + o;
        self.face_z = dom->face_z.f + ((size_t)octant * dom->slab + place) * row + o;
        self.sigma_t = dom->sigma_t.f + cell * CHANNELS;
        self.x0 = lit ? lanes_load(dom->inflow.f + (size_t)octant * row + o) : lanes_all(0.0f);
        self.x1 = self.x2 = self.x3 = self.x0;
        self.y0 = self.y1 = self.y2 = self.y3 = lanes_all(0.0f);
        if (count == ROWS) {
            pass_strip(&self, (int)n[0]);
            lanes_store(face_x + row + o, self.x1);
            lanes_store(face_x + 2 * row + o, self.x2);
            lanes_store(face_x + 3 * row + o, self.x3);
        } else {
            pass_line(&self, (int)n[0]);
        }
        lanes_store(face_x + o, self.x0);
    }
}

/* What enters through a face of the box, or nothing. */
static void enter(const air_dom *dom, int octant, int axis, float *face, size_t places)
{
    const int side = octant >> axis & 1;
    if (((dom->inflow_faces >> (2 * axis + side)) & 1u) == 0) {
        memset(face, 0, places * dom->row * sizeof *face);
        return;
    }
    for (size_t i = 0; i < places; i++) {
        memcpy(face + i * dom->row, dom->inflow.f + (size_t)octant * dom->row,
               dom->row * sizeof *face);
    }
}

/* Adds up what leaves at a line of places, which is short enough for floats. */
static void leave(const air_dom *dom, double *sum, const float *face, size_t places)
{
    for (size_t o = 0; o < dom->row; o += LANES) {
        lanes part = lanes_all(0.0f);
        for (size_t i = 0; i < places; i++) {
            part += lanes_load(face + i * dom->row + o);
        }
        for (int lane = 0; lane < LANES; lane++) {
            sum[o + (size_t)lane] += (double)part[lane];
        }
    }
}

static void sweep(air_dom *dom, int octant)
{
    const size_t *const n = dom->params.size, row = dom->row;
    double *const leaving = dom->leaving + (size_t)octant * 3 * row;
    float *const face_y = dom->face_y.f + (size_t)octant * n[0] * row;
    float *const face_z = dom->face_z.f + (size_t)octant * dom->slab * row;
    memset(leaving, 0, 3 * row * sizeof *leaving);
    enter(dom, octant, 2, face_z, dom->slab);
    for (size_t slab = 0; slab < n[2]; slab++) {
        const size_t k = (octant & 4) != 0 ? n[2] - 1 - slab : slab;
        enter(dom, octant, 1, face_y, n[0]);
        size_t line = 0;
        for (; line + ROWS <= n[1]; line += ROWS) {
            sweep_rows(dom, octant, line, k, ROWS);
        }
        for (; line < n[1]; line++) {
            sweep_rows(dom, octant, line, k, 1);
        }
        leave(dom, leaving, dom->face_x.f + (size_t)octant * n[1] * row, n[1]);
        leave(dom, leaving + row, face_y, n[0]);
    }
    for (size_t j = 0; j < n[1]; j++) {
        leave(dom, leaving + 2 * row, face_z + j * n[0] * row, n[0]);
    }
}

#endif

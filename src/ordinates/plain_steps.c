/* plain_steps.c: a step of each stencil, in doubles. */
#include "ordinates/plain.h"

typedef void plain_cell(plain_grid *self, size_t cell, const size_t at[3]);

static void each_cell(plain_grid *self, plain_cell *send)
{
    size_t at[3], cell = 0;
    for (at[2] = 0; at[2] < self->size[2]; at[2]++) {
        for (at[1] = 0; at[1] < self->size[1]; at[1]++) {
            for (at[0] = 0; at[0] < self->size[0]; at[0]++) {
                send(self, cell++, at);
            }
        }
    }
}

/* What arrived at a lobe of a cell, which is left empty for the next step. Rounding may carry the
 * mean cosine past 1, and so may six lobes' split of sideways light. */
static double receive(plain_grid *self, int lobe, size_t cell, double *out_mean)
{
    const double energy = self->sent[lobe][cell], moment = self->moment[lobe][cell];
    self->sent[lobe][cell] = self->moment[lobe][cell] = 0.0;
    *out_mean = energy > 0.0 ? double_max(-1.0, double_min(1.0, moment / energy)) : 0.0;
    return energy;
}

/* ---- the paper's: half a cell of absorption and decay on either side [Elek2014, eqs. 2-6] ---- */

static void send_literal(plain_grid *self, size_t cell, const size_t at[3])
{
    const double energy = self->energy[0][cell], a = self->mean[0][cell];
    if (energy == 0.0) {
        return;
    }
    const air_ordinates_shares s = air_ordinates_shares_of(a);
    const double left = energy * self->absorb[cell], mean = a * self->turn[cell];
    self->books.absorbed += energy - left;
    plain_send(self, cell, at, ORDINATES_AHEAD, 0, left * s.front, left * s.front * mean);
    plain_send(self, cell, at, ORDINATES_BEHIND, 0, left * s.back, left * s.back * mean);
    for (int face = 0; face < ORDINATES_BEHIND; face++) {
        plain_send(self, cell, at, face, 0, left * s.side, left * s.side * mean);
    }
}

void plain_step_literal(plain_grid *self)
{
    each_cell(self, send_literal);
    for (size_t i = 0; i < self->count; i++) {
        double mean;
        const double energy = receive(self, 0, i, &mean);
        self->energy[0][i] = energy * self->absorb[i];
        self->mean[0][i] = mean * self->turn[i];
        self->books.absorbed += energy - self->energy[0][i];
    }
}

/* ---- conditional moments: light keeps the mean cosine of the patch it leaves through ---- */

static void send_cm(plain_grid *self, size_t cell, const size_t at[3])
{
    const double energy = self->energy[0][cell], a = self->mean[0][cell];
    if (energy == 0.0) {
        return;
    }
    const air_ordinates_shares s = air_ordinates_shares_of(a);
    const double path = ordinates_path(a);
    const double left = energy * exp(-self->absorb[cell] * path);
    const double moment = left * exp(-self->turn[cell] * path);
    self->books.absorbed += energy - left;
    plain_send(self, cell, at, ORDINATES_AHEAD, 0, left * s.front, moment * s.front_mean);
    plain_send(self, cell, at, ORDINATES_BEHIND, 0, left * s.back, moment * s.back_mean);
    for (int face = 0; face < ORDINATES_BEHIND; face++) {
        plain_send(self, cell, at, face, 0, left * s.side, moment * s.side_mean);
    }
}

void plain_step_cm(plain_grid *self)
{
    each_cell(self, send_cm);
    for (size_t i = 0; i < self->count; i++) {
        double mean;
        const double energy = receive(self, 0, i, &mean), path = ordinates_path(mean);
        self->energy[0][i] = energy * exp(-self->absorb[i] * path);
        self->mean[0][i] = mean * exp(-self->turn[i] * path);
        self->books.absorbed += energy - self->energy[0][i];
    }
}

/* ---- six lobes ---- */

/* What leaves sideways has a mean cosine both to the side's normal and to the axis; it is shared in
 * their proportion between the neighbour's lobes along the two. */
static void send_lobe(plain_grid *self, size_t cell, const size_t at[3], int lobe)
{
    const double energy = self->energy[lobe][cell], a = self->mean[lobe][cell];
    if (energy == 0.0) {
        return;
    }
    const ordinates_upwind s = ordinates_upwind_at(self->rows, a);
    const double left = energy * exp(-self->absorb[cell] * s.path);
    const double moment = left * exp(-self->turn[cell] * s.path);
    const double axial = fabs(s.side_axial), both = axial + s.side_lateral;
    const double turned = both > 0.0 ? s.side_lateral / both : 1.0;
    const int along = s.side_axial < 0.0 ? lobe ^ 1 : lobe;
    self->books.absorbed += energy - left;
    plain_send(self, cell, at, lobe, lobe, left * s.front, moment * s.front_mean);
    plain_send(self, cell, at, lobe ^ 1, lobe ^ 1, left * s.back, moment * s.back_mean);
    for (int face = 0; face < ORDINATES_FACES; face++) {
        if (face / 2 != lobe / 2) {
            const double side = left * s.side, rest = side - side * turned;
            plain_send(self, cell, at, face, face, side * turned, moment * s.side_lateral);
            plain_send(self, cell, at, face, along, rest, moment * axial);
        }
    }
}

static void send_six(plain_grid *self, size_t cell, const size_t at[3])
{
    for (int lobe = 0; lobe < PLAIN_LOBES; lobe++) {
        send_lobe(self, cell, at, lobe);
    }
}

void plain_step_six(plain_grid *self)
{
    each_cell(self, send_six);
    for (int lobe = 0; lobe < PLAIN_LOBES; lobe++) {
        for (size_t i = 0; i < self->count; i++) {
            double mean;
            const double energy = receive(self, lobe, i, &mean);
            if (energy > 0.0) {
                const double path = ordinates_upwind_at(self->rows, mean).path;
                self->energy[lobe][i] = energy * exp(-self->absorb[i] * path);
                self->mean[lobe][i] = mean * exp(-self->turn[i] * path);
                self->books.absorbed += energy - self->energy[lobe][i];
            } else {
                self->energy[lobe][i] = self->mean[lobe][i] = 0.0;
            }
        }
    }
}

/* phase_fit.c: non-negative least squares [Lawson1974, ch. 23] on the normal equations, then fewer
 * lobes, one less at a time. */
#include "core/phase_fit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/host.h"
#include "core/quadrature.h"
#include "core/vec.h"

/* ---- the set of lobes ---- */

/* 1 - |g| falls from lobe to lobe by this factor: neighbours then stand for what lies between them
 * within a percent or two. */
#define RATIO 0.86
enum { SIDE = 26, LOBES = 2 + 2 * SIDE };

/* Rises with g: backward lobes from the sharpest on, isotropic, Rayleigh, forward lobes. */
static air_phase_lobe lobe_number(int i)
{
    const int step = i < SIDE ? SIDE - i : i - SIDE - 1;
    const float g = (float)(1.0 - pow(RATIO, step));
    if (i == SIDE || i == SIDE + 1) {
        return (air_phase_lobe){i == SIDE ? AIR_PHASE_ISOTROPIC : AIR_PHASE_RAYLEIGH, 0.0f, 0.0f};
    }
    return (air_phase_lobe){AIR_PHASE_HG, i < SIDE ? -g : g, 0.0f};
}

/* 1/sr, of all lobes at once. */
static void eval_lobes(const air_phase_lobe lobes[LOBES], double c, double out[LOBES])
{
    for (int i = 0; i < LOBES; ++i) {
        const double g = (double)lobes[i].g, r2 = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - c);
        out[i] = lobes[i].kind == AIR_PHASE_RAYLEIGH
                     ? 3.0 / (16.0 * AIR_PI) * (1.0 + c * c)
                     : (1.0 - g * g) / (4.0 * AIR_PI * r2 * sqrt(r2));
    }
}

/* ---- normal equations ---- */

/* Weighted products, integrated over the sphere, of lobes and table. */
typedef struct fit {
    air_phase_lobe lobes[LOBES];
    double gram[LOBES][LOBES], moment[LOBES], table;
} fit;

static const double weight_floor = 0.01 / (4.0 * AIR_PI);

static void add_point(fit *self, double c, double p, double measure)
{
    double at[LOBES];
    const double weight = measure / (p + weight_floor);
    eval_lobes(self->lobes, c, at);
    for (int i = 0; i < LOBES; ++i) {
        for (int k = 0; k <= i; ++k) {
            self->gram[i][k] += weight * at[i] * at[k];
        }
        self->moment[i] += weight * at[i] * p;
    }
    self->table += weight * p * p;
}

/* The next place above c where the rule starts anew, whatever the table: halving towards both ends,
 * where lobes are sharp. */
static double next_break(double c)
{
    enum { HALVINGS = 14 }; /* 6e-5, below the width of the sharpest lobe, 2e-4 */
    for (int i = HALVINGS; i >= 0; --i) {
        if (ldexp(1.0, -i) - 1.0 > c) {
            return ldexp(1.0, -i) - 1.0;
        }
    }
    for (int i = 1; i <= HALVINGS; ++i) {
        if (1.0 - ldexp(1.0, -i) > c) {
            return 1.0 - ldexp(1.0, -i);
        }
    }
    return 1.0;
}

static void integrate(fit *self, const double *cosines, const double *values, size_t count,
                      double total)
{
    enum { POINTS = 4 };
    double x[POINTS], w[POINTS];
    air_gauss_legendre(POINTS, x, w);
    for (size_t i = 0; i + 1 < count; ++i) {
        const double length = cosines[i + 1] - cosines[i];
        for (double begin = cosines[i]; begin < cosines[i + 1];) {
            const double end = fmin(next_break(begin), cosines[i + 1]);
            for (int n = 0; n < POINTS; ++n) {
                const double c = begin + 0.5 * (end - begin) * (1.0 + x[n]);
                const double share = (c - cosines[i]) / length;
                const double p = (1.0 - share) * values[i] + share * values[i + 1];
                add_point(self, c, p / total, AIR_PI * (end - begin) * w[n]);
            }
            begin = end;
        }
    }
    for (int i = 0; i < LOBES; ++i) {
        for (int k = 0; k < i; ++k) {
            self->gram[k][i] = self->gram[i][k];
        }
    }
}

/* The integral of the squared error. */
static double squared_error(const fit *self, const double x[LOBES])
{
    double sum = self->table;
    for (int i = 0; i < LOBES; ++i) {
        double row = -2.0 * self->moment[i];
        for (int k = 0; k < LOBES; ++k) {
            row += self->gram[i][k] * x[k];
        }
        sum += x[i] * row;
    }
    return fmax(sum, 0.0);
}

/* ---- non-negative least squares ---- */

/* Lobes by number. */
typedef struct lobe_set {
    int count;
    int members[LOBES];
} lobe_set;

static void remove_member(lobe_set *set, int place)
{
    --set->count;
    memmove(&set->members[place], &set->members[place + 1],
            (size_t)(set->count - place) * sizeof *set->members);
}

/* Least squares without regard to signs, by Cholesky's factors. False if the set's lobes are
 * linearly dependent to working precision. */
static bool solve(const fit *self, const lobe_set *set, double out[LOBES])
{
    double factor[LOBES][LOBES];
    for (int i = 0; i < set->count; ++i) {
        const int row = set->members[i];
        double rest = self->moment[row];
        for (int k = 0; k <= i; ++k) {
            double sum = self->gram[row][set->members[k]];
            for (int n = 0; n < k; ++n) {
                sum -= factor[i][n] * factor[k][n];
            }
            if (k == i && !(sum > 1e-12 * self->gram[row][row])) {
                return false;
            }
            factor[i][k] = k == i ? sqrt(sum) : sum / factor[k][k];
            rest -= k < i ? factor[i][k] * out[k] : 0.0;
        }
        out[i] = rest / factor[i][i];
    }
    for (int i = set->count - 1; i >= 0; --i) {
        for (int n = i + 1; n < set->count; ++n) {
            out[i] -= factor[n][i] * out[n];
        }
        out[i] /= factor[i][i];
    }
    return true;
}

/* Goes from x towards the set's least squares as far as no weight is negative, lets go of the lobes
 * that are 0 there, and so on until all are positive. False, with x as it was: dependent (parts of
 * an independent set never are). */
static bool settle(const fit *self, lobe_set *set, double x[LOBES])
{
    double target[LOBES];
    while (set->count > 0) {
        double step = 1.0;
        if (!solve(self, set, target)) {
            return false;
        }
        for (int i = 0; i < set->count; ++i) {
            const double now = x[set->members[i]];
            step = target[i] <= 0.0 ? fmin(step, now / (now - target[i])) : step;
        }
        for (int i = set->count - 1; i >= 0; --i) {
            double *weight = &x[set->members[i]];
            const bool stops = target[i] <= 0.0 && *weight / (*weight - target[i]) <= step;
            *weight = stops ? 0.0 : fmax(*weight + step * (target[i] - *weight), 0.0);
            if (stops) {
                remove_member(set, i);
            }
        }
        if (step >= 1.0) {
            return true;
        }
    }
    return true;
}

/* The lobe outside the set along which the error falls most steeply, -1 if along none. */
static int steepest(const fit *self, const bool closed[LOBES], const double x[LOBES])
{
    int best = -1;
    double most = 1e-9 * sqrt(self->table);
    for (int i = 0; i < LOBES; ++i) {
        double slope = self->moment[i];
        for (int k = 0; k < LOBES; ++k) {
            slope -= self->gram[i][k] * x[k];
        }
        slope /= sqrt(self->gram[i][i]);
        if (!closed[i] && x[i] == 0.0 && slope > most) {
            most = slope;
            best = i;
        }
    }
    return best;
}

/* The best non-negative weights x of the lobes that are not closed; the set of those above 0. */
static void fit_lobes(const fit *self, const bool closed_at_first[LOBES], lobe_set *set,
                      double x[LOBES])
{
    bool closed[LOBES];
    memcpy(closed, closed_at_first, sizeof closed);
    memset(x, 0, LOBES * sizeof *x);
    set->count = 0;
    for (int rounds = 0; rounds < 3 * LOBES; ++rounds) {
        const int next = steepest(self, closed, x);
        if (next < 0) {
            return;
        }
        lobe_set larger = *set;
        larger.members[larger.count++] = next;
        if (settle(self, &larger, x)) {
            *set = larger;
        }
        /* What did not help will not: dependent, or held back by rounding. */
        closed[next] = closed[next] || x[next] == 0.0;
    }
}

/* ---- few lobes ---- */

/* The fit without one lobe, and perhaps with another (-1: none) open, of those of the set. */
static double fit_changed(const fit *self, const lobe_set *from, int without, int with,
                          lobe_set *out, double x[LOBES])
{
    bool closed[LOBES];
    memset(closed, true, sizeof closed);
    for (int i = 0; i < from->count; ++i) {
        closed[from->members[i]] = from->members[i] == without;
    }
    if (with >= 0) {
        closed[with] = false;
    }
    fit_lobes(self, closed, out, x);
    return squared_error(self, x);
}

/* Takes the lobe out whose loss costs least, if there are too many or what is left is good enough.
 */
static bool drop_lobe(const fit *self, double enough, lobe_set *set, double x[LOBES])
{
    lobe_set best = {0};
    double least = INFINITY, best_x[LOBES];
    for (int i = 0; i < set->count; ++i) {
        lobe_set trial;
        double trial_x[LOBES];
        const double error = fit_changed(self, set, set->members[i], -1, &trial, trial_x);
        if (error < least) {
            least = error;
            best = trial;
            memcpy(best_x, trial_x, sizeof best_x);
        }
    }
    if (set->count <= AIR_PHASE_MAX_LOBES && (best.count == 0 || least > enough)) {
        return false;
    }
    *set = best;
    memcpy(x, best_x, sizeof best_x);
    return true;
}

/* Exchanges one lobe for the neighbour of one, if that helps. */
static bool move_lobe(const fit *self, lobe_set *set, double x[LOBES])
{
    const double before = squared_error(self, x);
    for (int i = 0; i < set->count; ++i) {
        for (int with = set->members[i] - 1; with <= set->members[i] + 1; with += 2) {
            lobe_set trial;
            double trial_x[LOBES];
            if (with >= 0 && with < LOBES && x[with] == 0.0 &&
                fit_changed(self, set, set->members[i], with, &trial, trial_x) <
                    before * (1.0 - 1e-6)) {
                *set = trial;
                memcpy(x, trial_x, sizeof trial_x);
                return true;
            }
        }
    }
    return false;
}

/* Lobes cost time wherever light scatters: those go that take less than a hundredth off the error,
 * or take it from 1 % to less. */
static void make_few(const fit *self, lobe_set *set, double x[LOBES])
{
    enum { MOVES = 100 };
    const double enough = fmax(1.01 * 1.01 * squared_error(self, x), 0.01 * 0.01);
    bool fewer = false;
    while (drop_lobe(self, enough, set, x)) {
        fewer = true;
    }
    for (int i = 0; fewer && i < MOVES && move_lobe(self, set, x); ++i) {
    }
}

/* ---- the whole ---- */

const char *air_phase_table_fault(const double *cosines, const double *values, size_t count,
                                  char buffer[AIR_PHASE_FAULT_SIZE])
{
    double sum = 0.0;
    if (count < 2) {
        snprintf(buffer, AIR_PHASE_FAULT_SIZE, "the table has %zu values, but must have at least 2",
                 count);
        return buffer;
    }
    for (size_t i = 0; i < count; ++i) {
        const double c = cosines[i], end = i == 0 ? -1.0 : 1.0;
        if ((i == 0 || i + 1 == count) && c != end) {
            snprintf(buffer, AIR_PHASE_FAULT_SIZE, "cosines[%zu] is %g, but must be %g", i, c, end);
            return buffer;
        }
        if (i > 0 && !(c > cosines[i - 1])) {
            snprintf(buffer, AIR_PHASE_FAULT_SIZE,
                     "cosines[%zu] is %g, but must be above the one before, %g", i, c,
                     cosines[i - 1]);
            return buffer;
        }
        if (!(values[i] >= 0.0 && values[i] < INFINITY)) {
            snprintf(buffer, AIR_PHASE_FAULT_SIZE,
                     "values[%zu] is %g, but must be finite and at least 0", i, values[i]);
            return buffer;
        }
        sum += values[i];
    }
    return sum > 0.0 ? NULL : "all values are 0";
}

/* By falling weight, so that evaluation and sampling meet the heavy ones first; weights as floats
 * that sum to 1. */
static void write_mixture(const fit *self, const lobe_set *set, const double x[LOBES],
                          air_phase_mixture *out)
{
    double sum = 0.0;
    for (int i = 0; i < set->count; ++i) {
        sum += x[set->members[i]];
    }
    out->lobe_count = 0;
    for (int i = 0; i < set->count; ++i) {
        air_phase_lobe lobe = self->lobes[set->members[i]];
        size_t place = out->lobe_count++;
        lobe.weight = (float)(x[set->members[i]] / sum);
        for (; place > 0 && out->lobes[place - 1].weight < lobe.weight; --place) {
            out->lobes[place] = out->lobes[place - 1];
        }
        out->lobes[place] = lobe;
    }
}

/* Over the sphere; the table is linear in between, so this is exact. */
static double table_integral(const double *cosines, const double *values, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i + 1 < count; ++i) {
        sum += AIR_PI * (cosines[i + 1] - cosines[i]) * (values[i] + values[i + 1]);
    }
    return sum;
}

air_status air_phase_fit(air_context *context, const double *cosines, const double *values,
                         size_t count, air_phase_mixture *out_mixture, double *out_error)
{
    char buffer[AIR_PHASE_FAULT_SIZE];
    const char *fault = air_phase_table_fault(cosines, values, count, buffer);
    if (fault != NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "phase table: %s", fault);
    }
    fit self = {.table = 0.0};
    const bool closed[LOBES] = {false};
    lobe_set set;
    double x[LOBES];
    for (int i = 0; i < LOBES; ++i) {
        self.lobes[i] = lobe_number(i);
    }
    integrate(&self, cosines, values, count, table_integral(cosines, values, count));
    fit_lobes(&self, closed, &set, x);
    make_few(&self, &set, x);
    write_mixture(&self, &set, x, out_mixture);
    if (out_error != NULL) {
        double sum = 0.0;
        for (int i = 0; i < LOBES; ++i) {
            sum += x[i];
        }
        for (int i = 0; i < LOBES; ++i) {
            x[i] /= sum;
        }
        *out_error = sqrt(squared_error(&self, x));
    }
    return AIR_OK;
}

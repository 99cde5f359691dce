/* radial_step.c: one step [Elek2014, eqs. 2-6], with conditional moments and curvature.
 *
 * Half of a step's decay and absorption is taken where it starts, half where it ends, each by the
 * cell's own coefficients. In place: the sources of three shells are enough to gather one. */
#include "ordinates/radial.h"
#include "ordinates/radial_shares.h"

/* |P| <= E, but for the rounding of sums of 2n terms: kept from making a lobe more than a beam. */
static const double BELOW_ONE = 1.0 - 1e-13;
static const double NOTHING = 1e-300; /* so that 0/0 is 0 */

/* Fills the six parts of a flux, and paths with those of a cell as deep as 1. Inlined where the two
 * booleans are constants, and all pointers its own parameters: else no loop is vectorised. */
static inline void send_row(bool moments, bool absorbing, size_t count, const double *restrict e,
                            const double *restrict a, const double *restrict scatter,
                            const double *restrict absorb, double *restrict front,
                            double *restrict side, double *restrict back,
                            double *restrict front_mean, double *restrict side_mean,
                            double *restrict back_mean, double *restrict paths)
{
    for (size_t i = 0; i < count; i++) {
        const radial_shares r = radial_shares_of(a[i]);
        const double l = moments ? r.path : 1.0;
        const double kept = absorbing ? e[i] * radial_exp(absorb[i] * l) : e[i];
        const double p = kept * radial_exp(scatter[i] * l);
        paths[i] = l;
        front[i] = kept * r.front;
        side[i] = kept * r.side;
        back[i] = kept * r.back;
        front_mean[i] = p * (moments ? r.front_mean : r.front * a[i]);
        side_mean[i] = p * (moments ? r.side_mean : r.side * a[i]);
        back_mean[i] = p * (moments ? r.back_mean : r.back * a[i]);
    }
}

static void send(radial_run *run, uint32_t k, double weight)
{
    const size_t count = run->mesh.count, at = k * count;
    const radial_flux f = run->flux[k % 3];
    const double *const e = run->energy + at, *const a = run->mean + at;
    const double *const scatter = run->scatter_half + at, *const absorb = run->absorb_half + at;
    double *const paths = run->rings[0];
    if (run->params->stencil == AIR_ORDINATES_LITERAL) {
        send_row(false, true, count, e, a, scatter, absorb, f.front, f.side, f.back, f.front_mean,
                 f.side_mean, f.back_mean, paths);
    } else if (run->absorbing) {
        send_row(true, true, count, e, a, scatter, absorb, f.front, f.side, f.back, f.front_mean,
                 f.side_mean, f.back_mean, paths);
    } else {
        send_row(true, false, count, e, a, scatter, absorb, f.front, f.side, f.back, f.front_mean,
                 f.side_mean, f.back_mean, paths);
    }
    if (run->absorbing) {
        double lost = 0.0;
        for (size_t i = 0; i < count; i++) {
            lost += e[i] - (f.front[i] + f.side[i] + f.back[i]);
        }
        run->books.absorbed += lost;
    }
    radial_count(run, k, paths, weight);
}

/* What reaches the cells of shell k, E and P, from its neighbours. */
static void gather(radial_run *run, uint32_t k)
{
    const radial_mesh *const mesh = &run->mesh;
    const size_t count = mesh->count;
    const radial_flux *const here = &run->flux[k % 3];
    double *restrict const e = run->energy + k * count, *restrict const p = run->mean + k * count;
    if (run->params->lateral == AIR_RADIAL_SIDES) {
        for (size_t i = 0; i < count; i++) {
            e[i] = mesh->stay[i] * here->side[i];
            p[i] = mesh->stay[i] * here->side_mean[i];
            for (int side = 0; side < 4; side++) {
                const size_t j = mesh->neighbour[side][i];
                e[i] += mesh->from[side][i] * here->side[j];
                p[i] += mesh->from[side][i] * here->side_mean[j];
            }
        }
    } else {
        memcpy(e, here->side, count * sizeof *e);
        memcpy(p, here->side_mean, count * sizeof *p);
    }
    if (k > 0) {
        const radial_flux *const below = &run->flux[(k - 1) % 3];
        for (size_t i = 0; i < count; i++) {
            e[i] += below->front[i];
            p[i] += below->front_mean[i];
        }
    } else { /* through the ball and out on its other side */
        for (size_t i = 0; i < count; i++) {
            e[i] += here->back[mesh->opposite[i]];
            p[i] -= here->back_mean[mesh->opposite[i]];
        }
    }
    if (k + 1 < run->cells->grid.shells) {
        const radial_flux *const above = &run->flux[(k + 1) % 3];
        for (size_t i = 0; i < count; i++) {
            e[i] += above->back[i];
            p[i] += above->back_mean[i];
        }
    } else {
        double out = 0.0;
        for (size_t i = 0; i < count; i++) {
            out += here->front[i];
        }
        run->books.out += out;
    }
}

/* Half a path of decay and absorption in the cell that is reached; p holds P, then a. lost: power
 * absorbed; mobility: of SPREAD. Curvature: a straight path has d mu/ds = (1 - mu^2) / r, whose
 * mean over a lobe is about (2/3) (1 - a^2) / r, so the artanh of a grows by turn l, turn = 2/3
 * depth / r, or 0. tanh x = x (15 + x^2) / (15 + 6 x^2), error 4e-5 at the largest x, 0.7. */
static inline void arrive_row(bool moments, bool absorbing, size_t count, double turn,
                              const double *restrict ease, const double *restrict scatter,
                              const double *restrict absorb, double *restrict e, double *restrict p,
                              double *restrict lost, double *restrict mobility)
{
    for (size_t i = 0; i < count; i++) {
        const double merged = BELOW_ONE * p[i] / (e[i] + NOTHING);
        const double l = moments ? radial_path_fit(merged) : 1.0;
        const double kept = absorbing ? e[i] * radial_exp(absorb[i] * l) : e[i];
        const double decayed = merged * radial_exp(scatter[i] * l);
        const double x = turn * l, x2 = x * x;
        const double low = 15.0 + 6.0 * x2, high = x * (15.0 + x2);
        const double a = (decayed * low + high) / (low + decayed * high);
        lost[i] = e[i] - kept;
        e[i] = kept;
        p[i] = a;
        mobility[i] = ease[i] * l * (1.0 - a * a);
    }
}

static void arrive(radial_run *run, uint32_t k)
{
    const size_t count = run->mesh.count, at = k * count;
    const double inner = air_radial_radius(&run->cells->grid, k);
    const double outer = air_radial_radius(&run->cells->grid, k + 1);
    const double depth = outer - inner, radius = 0.5 * (outer + inner);
    const double turn = run->curved ? 2.0 / 3.0 * depth / radius : 0.0;
    const double *const ease = run->ease + at;
    const double *const scatter = run->scatter_half + at, *const absorb = run->absorb_half + at;
    double *const e = run->energy + at, *const a = run->mean + at;
    double *const lost = run->rings[0], *const mobility = run->mobility;
    if (run->params->stencil == AIR_ORDINATES_LITERAL) {
        arrive_row(false, true, count, turn, ease, scatter, absorb, e, a, lost, mobility);
    } else if (run->absorbing) {
        arrive_row(true, true, count, turn, ease, scatter, absorb, e, a, lost, mobility);
    } else {
        arrive_row(true, false, count, turn, ease, scatter, absorb, e, a, lost, mobility);
    }
    if (run->absorbing) {
        double sum = 0.0;
        for (size_t i = 0; i < count; i++) {
            sum += lost[i];
        }
        run->books.absorbed += sum;
    }
    if (run->params->lateral == AIR_RADIAL_SPREAD) {
        for (size_t i = 0; i < count; i++) {
            a[i] *= e[i];
        }
        radial_spread(run, e, a);
        for (size_t i = 0; i < count; i++) {
            a[i] = BELOW_ONE * a[i] / (e[i] + NOTHING);
        }
    }
}

void radial_step(radial_run *run, double weight)
{
    const uint32_t shells = run->cells->grid.shells;
    send(run, 0, weight);
    for (uint32_t k = 0; k < shells; k++) {
        if (k + 1 < shells) {
            send(run, k + 1, weight);
        }
        gather(run, k);
        arrive(run, k);
    }
}

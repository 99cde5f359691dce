/* radial_step.c: one step [Elek2014, eqs. 2-6], with conditional moments and curvature.
 *
 * Half of a step's decay and absorption is taken where it starts, half where it ends, each by the
 * cell's own coefficients. In place: the sources of three shells are enough to gather one. */
#include "ordinates/radial.h"
#include "ordinates/radial_shares.h"

/* For light that goes sideways: its distance before it turns is 1 / (2/r + (1-g) sigma_s +
 * sigma_a). 2/r as straight paths turn radial: at 90 degrees d mu/ds = 1/r, and the mean of mu d
 * mu/ds over what moves sideways makes it lose its tangential part twice as fast. */
static const double TURNS_PER_RADIUS = 2.0;

/* Whether the compiler sees constants for the three booleans decides about the speed: always
 * inlined. Fills flux, and paths with those of a cell as deep as 1. */
static inline void send_row(bool moments, bool absorbing, size_t count, const double *restrict e,
                            const double *restrict a, const double *restrict scatter,
                            const double *restrict absorb, const radial_flux *flux,
                            double *restrict paths)
{
    double *restrict const front = flux->front, *restrict const side = flux->side,
                           *restrict const back = flux->back;
    double *restrict const front_mean = flux->front_mean,
                           *restrict const side_mean = flux->side_mean,
                           *restrict const back_mean = flux->back_mean;
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
    const bool moments = run->params->stencil == AIR_ORDINATES_CM;
    const size_t count = run->mesh.count, at = k * count;
    const radial_flux *const flux = &run->flux[k % 3];
    const double *const e = run->energy + at, *const a = run->mean + at;
    const double *const scatter = run->scatter_half + at, *const absorb = run->absorb_half + at;
    double *const paths = run->rings[0];
    if (!moments) {
        send_row(false, true, count, e, a, scatter, absorb, flux, paths);
    } else if (run->absorbing) {
        send_row(true, true, count, e, a, scatter, absorb, flux, paths);
    } else {
        send_row(true, false, count, e, a, scatter, absorb, flux, paths);
    }
    if (run->absorbing) {
        double lost = 0.0;
        for (size_t i = 0; i < count; i++) {
            lost += e[i] - (flux->front[i] + flux->side[i] + flux->back[i]);
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
 * mean over a lobe is about (2/3) (1 - a^2) / r, so the artanh of a grows by 2l / 3r: tanh x = x
 * (15 + x^2) / (15 + 6 x^2), error 4e-5 at the largest x, 0.7. */
static inline void arrive_row(bool moments, bool curved, bool absorbing, size_t count, double depth,
                              double radius, const double *restrict omega,
                              const double *restrict scatter, const double *restrict absorb,
                              double *restrict e, double *restrict p, double *restrict lost,
                              double *restrict mobility)
{
    const double turn = 2.0 / 3.0 * depth / radius;
    const double free_turn = TURNS_PER_RADIUS * depth * radius, medium_turn = 2.0 * radius * radius;
    for (size_t i = 0; i < count; i++) {
        const double merged = double_max(-1.0, double_min(1.0, p[i] / double_max(e[i], 1e-300)));
        const double l = moments ? radial_path(merged) : 1.0;
        const double kept = absorbing ? e[i] * radial_exp(absorb[i] * l) : e[i];
        double a = merged * radial_exp(scatter[i] * l);
        if (curved) {
            const double x = turn * l, x2 = x * x, tau = x * (15.0 + x2) / (15.0 + 6.0 * x2);
            a = (a + tau) / (1.0 + a * tau);
        }
        lost[i] = e[i] - kept;
        e[i] = kept;
        p[i] = a;
        mobility[i] = (1.0 - a * a) * l * depth * depth /
                      (3.0 * omega[i] * (free_turn + medium_turn * (scatter[i] + absorb[i])));
    }
}

static void arrive(radial_run *run, uint32_t k)
{
    const bool moments = run->params->stencil == AIR_ORDINATES_CM;
    const size_t count = run->mesh.count, at = k * count;
    const double inner = air_radial_radius(&run->cells->grid, k);
    const double outer = air_radial_radius(&run->cells->grid, k + 1);
    const double depth = outer - inner, radius = 0.5 * (outer + inner);
    const double *const omega = run->mesh.omega;
    const double *const scatter = run->scatter_half + at, *const absorb = run->absorb_half + at;
    double *const e = run->energy + at, *const a = run->mean + at;
    double *const lost = run->rings[0], *const mobility = run->mobility;
    if (moments && run->curved && !run->absorbing) {
        arrive_row(true, true, false, count, depth, radius, omega, scatter, absorb, e, a, lost,
                   mobility);
    } else if (moments && run->curved) {
        arrive_row(true, true, true, count, depth, radius, omega, scatter, absorb, e, a, lost,
                   mobility);
    } else {
        arrive_row(moments, run->curved, true, count, depth, radius, omega, scatter, absorb, e, a,
                   lost, mobility);
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
            a[i] /= double_max(e[i], 1e-300);
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

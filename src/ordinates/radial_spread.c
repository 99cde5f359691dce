/* radial_spread.c: diffusion between the directions of a shell.
 *
 * From cell to cell of a family flows E_c mobility_c link, so that fields uniform per solid angle
 * stay so where the mobility is uniform. One implicit step per family: tridiagonal systems whose
 * columns sum to 1, so power is kept, and whose inverses have no negative entries, so power stays
 * positive and momentum no larger than it, at any mobility. All systems of one length side by
 * side. */
#include "ordinates/radial.h"

#include <stddef.h>

/* A row of cells, one of each system: mobility, conductance to the next row, right hand sides that
 * become solutions, the share b of the open unknown (rings), the inverse of the diagonal. */
typedef struct rows {
    const double *m, *link;
    double *e, *p, *b, *beta;
    size_t width, length;
} rows;

/* Eliminates the row before. restrict holds for parameters only, and without it no loop is
 * vectorised. */
static inline void eliminate_row(bool ring, size_t width, const double *restrict m_before,
                                 const double *restrict link_before,
                                 const double *restrict beta_before,
                                 const double *restrict e_before, const double *restrict p_before,
                                 const double *restrict b_before, const double *restrict m,
                                 const double *restrict link, double *restrict beta,
                                 double *restrict e, double *restrict p, double *restrict b)
{
    for (size_t i = 0; i < width; i++) {
        const double w = link_before[i], up = m_before[i] * w * beta_before[i];
        beta[i] = 1.0 / (1.0 + m[i] * (link[i] + w) - up * (m[i] * w));
        e[i] += up * e_before[i];
        p[i] += up * p_before[i];
        if (ring) {
            b[i] = up * b_before[i];
        }
    }
}

static inline void substitute_row(bool ring, size_t width, const double *restrict m_after,
                                  const double *restrict link, const double *restrict beta,
                                  const double *restrict e_after, const double *restrict p_after,
                                  const double *restrict b_after, double *restrict e,
                                  double *restrict p, double *restrict b)
{
    for (size_t i = 0; i < width; i++) {
        const double down = m_after[i] * link[i];
        e[i] = beta[i] * (e[i] + down * e_after[i]);
        p[i] = beta[i] * (p[i] + down * p_after[i]);
        if (ring) {
            b[i] = beta[i] * (b[i] + down * b_after[i]);
        }
    }
}

static inline void eliminate(bool ring, size_t width, size_t count, const rows *r)
{
    for (size_t q = 1; q < count; q++) {
        const size_t at = q * width, before = at - width;
        eliminate_row(ring, width, r->m + before, r->link + before, r->beta + before, r->e + before,
                      r->p + before, r->b + before, r->m + at, r->link + at, r->beta + at,
                      r->e + at, r->p + at, r->b + at);
    }
}

static inline void substitute(bool ring, size_t width, size_t count, const rows *r)
{
    for (size_t q = count - 1; q-- > 0;) {
        const size_t at = q * width, after = at + width;
        substitute_row(ring, width, r->m + after, r->link + at, r->beta + at, r->e + after,
                       r->p + after, r->b + after, r->e + at, r->p + at, r->b + at);
    }
}

/* Chains with open ends: the last row's link is 0. */
static inline void solve_chains(size_t width, const rows *r)
{
    const size_t last = (r->length - 1) * width;
    for (size_t i = 0; i < width; i++) {
        r->beta[i] = 1.0 / (1.0 + r->m[i] * r->link[i]);
    }
    eliminate(false, width, r->length, r);
    for (size_t i = last; i < last + width; i++) {
        r->e[i] *= r->beta[i];
        r->p[i] *= r->beta[i];
    }
    substitute(false, width, r->length, r);
}

/* Rings: the last row z stays open, x = A + B z in all others, until they have met. */
static void solve_rings(const rows *r)
{
    const size_t width = r->width, z = (r->length - 1) * width, end = z - width;
    for (size_t i = 0; i < width; i++) {
        r->beta[i] = 1.0 / (1.0 + r->m[i] * (r->link[i] + r->link[z + i]));
        r->b[i] = r->m[z + i] * r->link[z + i];
    }
    eliminate(true, width, r->length - 1, r);
    for (size_t i = 0; i < width; i++) {
        r->e[end + i] *= r->beta[end + i];
        r->p[end + i] *= r->beta[end + i];
        r->b[end + i] = r->beta[end + i] * (r->b[end + i] + r->m[z + i] * r->link[end + i]);
    }
    substitute(true, width, r->length - 1, r);
    for (size_t i = 0; i < width; i++) {
        const double up = r->m[end + i] * r->link[end + i], down = r->m[i] * r->link[z + i];
        const double diagonal = 1.0 + r->m[z + i] * (r->link[z + i] + r->link[end + i]);
        const double beta = 1.0 / (diagonal - up * r->b[end + i] - down * r->b[i]);
        r->e[z + i] = (r->e[z + i] + up * r->e[end + i] + down * r->e[i]) * beta;
        r->p[z + i] = (r->p[z + i] + up * r->p[end + i] + down * r->p[i]) * beta;
    }
    for (size_t q = 0; q < z; q += width) {
        for (size_t i = 0; i < width; i++) {
            r->e[q + i] += r->b[q + i] * r->e[z + i];
            r->p[q + i] += r->b[q + i] * r->p[z + i];
        }
    }
}

/* Four quadrants of both hemispheres for each height, then of the equator; chains of one cell have
 * no links. */
static void solve_levels(const rows *all, size_t n)
{
    size_t at = 8;
    for (size_t m = 2; m <= n / 2; m++) {
        const rows r = {.m = all->m + at,
                        .link = all->link + at,
                        .e = all->e + at,
                        .p = all->p + at,
                        .b = all->b + at,
                        .beta = all->beta + at,
                        .length = m};
        if (m < n / 2) {
            solve_chains(8, &r);
        } else {
            solve_chains(4, &r);
        }
        at += 8 * m;
    }
}

void radial_spread(radial_run *run, double *energy, double *momentum)
{
    const radial_mesh *const mesh = &run->mesh;
    double *const m = run->rings[0], *const e = run->rings[1], *const p = run->rings[2];
    for (int family = 0; family < 3; family++) {
        const uint32_t *const order = mesh->order[family];
        const rows all = {.m = m,
                          .link = mesh->link[family],
                          .e = e,
                          .p = p,
                          .b = run->rings[3],
                          .beta = run->rings[4],
                          .width = mesh->n / 2,
                          .length = 2 * mesh->n};
        for (size_t i = 0; i < mesh->count; i++) {
            m[i] = run->mobility[order[i]];
            e[i] = energy[order[i]];
            p[i] = momentum[order[i]];
        }
        if (family < 2) {
            solve_rings(&all);
        } else {
            solve_levels(&all, mesh->n);
        }
        for (size_t i = 0; i < mesh->count; i++) {
            energy[order[i]] = e[i];
            momentum[order[i]] = p[i];
        }
    }
}

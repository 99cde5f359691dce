/* radial_spread.c: diffusion between the directions of a shell.
 *
 * From cell to cell along a ring flows E_c mobility_c link, so that fields uniform per solid angle
 * stay so where the mobility is uniform. One implicit step per family of rings: a cyclic
 * tridiagonal system whose columns sum to 1, so power is kept, and whose inverse has no negative
 * entries, so power stays positive and momentum no larger than it, at any mobility. All rings of a
 * family side by side. */
#include "ordinates/radial.h"

#include <stddef.h>

/* Eliminates upwards. The last cell's value z is left open: x = A + B z; e and p begin as right
 * hand sides and become A, b becomes B, c the coefficients of the next. */
static void eliminate(const double *restrict m, const double *restrict link, size_t half,
                      size_t length, double *restrict e, double *restrict p, double *restrict b,
                      double *restrict c)
{
    const size_t last = (length - 1) * half;
    for (size_t i = 0; i < half; i++) {
        const double beta = 1.0 / (1.0 + m[i] * (link[i] + link[last + i]));
        c[i] = m[half + i] * link[i] * beta;
        b[i] = m[last + i] * link[last + i] * beta;
        e[i] *= beta;
        p[i] *= beta;
    }
    for (size_t q = 1; q + 1 < length; q++) {
        const size_t at = q * half;
        for (size_t i = at; i < at + half; i++) {
            const double up = m[i - half] * link[i - half];
            const double beta = 1.0 / (1.0 + m[i] * (link[i] + link[i - half]) - up * c[i - half]);
            c[i] = m[i + half] * link[i] * beta;
            b[i] = up * b[i - half] * beta;
            e[i] = (e[i] + up * e[i - half]) * beta;
            p[i] = (p[i] + up * p[i - half]) * beta;
        }
    }
    for (size_t i = last - half; i < last; i++) { /* its next is the last: not open, but z */
        b[i] += c[i];
        c[i] = 0.0;
    }
}

static void substitute(const double *restrict m, const double *restrict link, size_t half,
                       size_t length, double *restrict e, double *restrict p, double *restrict b,
                       const double *restrict c)
{
    const size_t last = (length - 1) * half;
    for (size_t i = last - half; i-- > 0;) {
        e[i] += c[i] * e[i + half];
        p[i] += c[i] * p[i + half];
        b[i] += c[i] * b[i + half];
    }
    for (size_t i = 0; i < half; i++) {
        const size_t z = last + i;
        const double up = m[z - half] * link[z - half], down = m[i] * link[z];
        const double beta =
            1.0 / (1.0 + m[z] * (link[z] + link[z - half]) - up * b[z - half] - down * b[i]);
        e[z] = (e[z] + up * e[z - half] + down * e[i]) * beta;
        p[z] = (p[z] + up * p[z - half] + down * p[i]) * beta;
    }
    for (size_t q = 0; q + 1 < length; q++) {
        for (size_t i = 0; i < half; i++) {
            e[q * half + i] += b[q * half + i] * e[last + i];
            p[q * half + i] += b[q * half + i] * p[last + i];
        }
    }
}

static void solve(radial_run *run, int family, size_t at, size_t half, size_t length)
{
    double *const *const r = run->rings;
    const double *const link = run->mesh.link[family] + at;
    eliminate(r[0] + at, link, half, length, r[1] + at, r[2] + at, r[3] + at, r[4] + at);
    substitute(r[0] + at, link, half, length, r[1] + at, r[2] + at, r[3] + at, r[4] + at);
}

void radial_spread(radial_run *run, double *energy, double *momentum)
{
    const radial_mesh *const mesh = &run->mesh;
    double *const m = run->rings[0], *const e = run->rings[1], *const p = run->rings[2];
    for (int family = 0; family < 3; family++) {
        const uint32_t *const order = mesh->order[family];
        for (size_t i = 0; i < mesh->count; i++) {
            m[i] = run->mobility[order[i]];
            e[i] = energy[order[i]];
            p[i] = momentum[order[i]];
        }
        if (family < 2) {
            solve(run, family, 0, mesh->n / 2, 2 * mesh->n);
        } else {
            size_t at = 0;
            for (size_t level = 1; level < mesh->n / 2; level++) {
                solve(run, family, at, 2, 4 * level);
                at += 8 * level;
            }
            solve(run, family, at, 1, 2 * mesh->n);
        }
        for (size_t i = 0; i < mesh->count; i++) {
            energy[order[i]] = e[i];
            momentum[order[i]] = p[i];
        }
    }
}

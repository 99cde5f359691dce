/* collimated_fixture.h: random media, rays and lights, and the single-scattering integral by
 * quadrature of its definition, for tests of the collimated kernel. */
#ifndef AIR_TESTS_COLLIMATED_FIXTURE_H
#define AIR_TESTS_COLLIMATED_FIXTURE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/collimated.h"
#include "core/quadrature.h"
#include "random_geometry.h"

enum { ROOM = 1024 }; /* pieces */

/* A profile with its pieces; setup by roomy(). */
typedef struct roomy_profile {
    air_collimated_piece pieces[ROOM];
    air_collimated_profile profile;
} roomy_profile;

static inline air_collimated_profile *roomy(roomy_profile *self)
{
    self->profile = (air_collimated_profile){.pieces = self->pieces, .capacity = ROOM};
    return &self->profile;
}

static inline void move_along(const double from[3], const double dir[3], double t, double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = from[i] + t * dir[i];
    }
}

static inline air_collimated_medium box_between(const double low[3], const double high[3])
{
    air_collimated_medium box = {.plane_count = 6};
    for (int i = 0; i < 3; i++) {
        box.planes[2 * i][i] = 1.0;
        box.planes[2 * i][3] = high[i];
        box.planes[2 * i + 1][i] = -1.0;
        box.planes[2 * i + 1][3] = -low[i];
    }
    return box;
}

/* Planes that touch a ball about the centre at random places, normals of random lengths, about a
 * cube that closes them off. */
static inline air_collimated_medium random_polyhedron(air_rng *rng, size_t plane_count,
                                                      const double centre[3])
{
    double axes[3][3];
    air_collimated_medium out = {.plane_count = plane_count};
    random_frame(rng, axes);
    for (size_t k = 0; k < plane_count; k++) {
        double *n = out.planes[k];
        double height = 1.0;
        if (k < 6) {
            for (int i = 0; i < 3; i++) {
                n[i] = k % 2 == 0 ? axes[k / 2][i] : -axes[k / 2][i];
            }
            height = random_between(rng, 0.5, 1.5);
        } else {
            random_direction(rng, n);
        }
        const double length = random_between(rng, 0.2, 5.0);
        for (int i = 0; i < 3; i++) {
            n[i] *= length;
        }
        n[3] = height * length + dot(n, centre);
    }
    return out;
}

/* A configuration of one medium; the camera is inside it or outside, looking towards it. */
typedef struct lit_ray {
    air_collimated_medium medium;
    double to_light[3], origin[3], dir[3], sigma_t, t_max;
} lit_ray;

static inline lit_ray random_lit_ray(air_rng *rng)
{
    lit_ray out;
    double centre[3], target[3];
    for (int i = 0; i < 3; i++) {
        centre[i] = random_between(rng, -2.0, 2.0);
        target[i] = centre[i] + random_between(rng, -0.4, 0.4);
    }
    out.medium = random_polyhedron(rng, 6 + air_rng_next(rng) % 12u, centre);
    random_direction(rng, out.to_light);
    random_direction(rng, out.dir);
    move_along(target, out.dir, air_rng_next(rng) % 2u == 0 ? 0.0 : -random_between(rng, 0.0, 6.0),
               out.origin);
    out.sigma_t = exp(random_between(rng, log(0.01), log(20.0)));
    out.t_max = air_rng_next(rng) % 3u == 0 ? random_between(rng, 0.1, 8.0) : INFINITY;
    return out;
}

static inline void make_profile(const lit_ray *r, air_collimated_profile *out)
{
    air_collimated_profile_make(&r->medium, r->to_light, r->sigma_t, r->origin, r->dir, r->t_max,
                                out);
}

/* ---- the definition, by quadrature ---- */

/* Many cells and a ray. */
typedef struct lit_cells {
    const air_collimated_cell *cells;
    size_t count;
    double to_light[3], origin[3], dir[3], t_max;
} lit_cells;

/* The length of o + t v inside the half-spaces for 0 < t < t_max, straight from their meaning. */
static inline double length_inside(const air_collimated_medium *medium, const double o[3],
                                   const double v[3], double t_max)
{
    double begin = 0.0, end = t_max;
    for (size_t k = 0; k < medium->plane_count; k++) {
        const double *n = medium->planes[k], room = n[3] - dot(n, o), speed = dot(n, v);
        if (fabs(speed) <= 1e-15 * sqrt(dot(n, n))) {
            end = room < 0.0 ? -INFINITY : end;
        } else if (speed > 0.0) {
            end = fmin(end, room / speed);
        } else {
            begin = fmax(begin, room / speed);
        }
    }
    return end > begin ? end - begin : 0.0;
}

/* weight exp(-depth) at t, by the definition. */
static inline double cells_integrand(const lit_cells *r, double t)
{
    double x[3], depth = 0.0, weight = 0.0;
    move_along(r->origin, r->dir, t, x);
    for (size_t i = 0; i < r->count; i++) {
        const air_collimated_cell *cell = &r->cells[i];
        bool inside = true;
        for (size_t k = 0; k < cell->medium.plane_count; k++) {
            inside = inside && dot(cell->medium.planes[k], x) <= cell->medium.planes[k][3];
        }
        weight += inside ? cell->weight : 0.0;
        if (cell->sigma_t > 0.0) {
            depth += cell->sigma_t * (length_inside(&cell->medium, r->origin, r->dir, t) +
                                      length_inside(&cell->medium, x, r->to_light, INFINITY));
        }
    }
    return weight * exp(-depth);
}

static inline double gauss_10(const lit_cells *r, double a, double b)
{
    double x[10], w[10], sum = 0.0;
    air_gauss_legendre(10, x, w);
    for (int i = 0; i < 10; i++) {
        sum += w[i] * cells_integrand(r, 0.5 * (a + b) + 0.5 * (b - a) * x[i]);
    }
    return 0.5 * (b - a) * sum;
}

/* Halves until a part agrees with its halves. */
static inline double integrate_part(const lit_cells *r, double a, double b, double whole,
                                    double error, int depth)
{
    const double m = 0.5 * (a + b), left = gauss_10(r, a, m), right = gauss_10(r, m, b);
    if (depth == 0 || fabs(left + right - whole) <= error) {
        return left + right;
    }
    return integrate_part(r, a, m, left, error, depth - 1) +
           integrate_part(r, m, b, right, error, depth - 1);
}

static inline int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* The integral over [a, b], cut wherever it might bend or jump: at the ray's crossing of any plane,
 * and where the light's way meets two planes of one cell at once, (no_i - nv_i t)/nl_i =
 * (no_j - nv_j t)/nl_j. The rest is smooth: relative error about 1e-14. */
static inline double integrate_cells(const lit_cells *r, double a, double b)
{
    enum { MOST = 4096 };
    static double cuts[MOST];
    size_t count = 0;
    double estimate = 0.0, sum = 0.0;
    cuts[count++] = a;
    cuts[count++] = b;
    for (size_t c = 0; c < r->count; c++) {
        const air_collimated_medium *m = &r->cells[c].medium;
        for (size_t i = 0; i < m->plane_count; i++) {
            const double *n = m->planes[i], no = n[3] - dot(n, r->origin), nv = dot(n, r->dir);
            cuts[count++] = no / nv;
            for (size_t j = 0; j < i; j++) {
                const double *k = m->planes[j], ko = k[3] - dot(k, r->origin), kv = dot(k, r->dir);
                const double nl = dot(n, r->to_light), kl = dot(k, r->to_light);
                cuts[count++] = (no * kl - ko * nl) / (nv * kl - kv * nl);
            }
        }
    }
    for (size_t i = 0; i < count; i++) {
        cuts[i] = cuts[i] > a && cuts[i] < b ? cuts[i] : i == 1 ? b : a;
    }
    qsort(cuts, count, sizeof *cuts, compare_doubles);
    for (size_t i = 0; i + 1 < count; i++) {
        estimate += gauss_10(r, cuts[i], cuts[i + 1]);
    }
    for (size_t i = 0; i + 1 < count; i++) {
        if (cuts[i] < cuts[i + 1]) {
            sum += integrate_part(r, cuts[i], cuts[i + 1], gauss_10(r, cuts[i], cuts[i + 1]),
                                  1e-16 * estimate, 20);
        }
    }
    return sum;
}

#endif

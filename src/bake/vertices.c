#include "bake/vertices.h"

#include <string.h>

#include "scene/surface.h"

/* Sorts corners by vertex. */
static void sort_corners(air_vertex_sites *self)
{
    const air_mesh *mesh = self->mesh;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        self->first[mesh->indices[i] + 1]++;
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        self->first[v + 1] += self->first[v];
    }
    for (size_t i = 3 * mesh->triangle_count; i > 0; i--) {
        const uint32_t v = mesh->indices[i - 1];
        self->corners[--self->first[v + 1]] = (uint32_t)(i - 1);
    }
    /* what was counted down now stands one place too late */
    memmove(self->first, self->first + 1, mesh->vertex_count * sizeof *self->first);
    self->first[mesh->vertex_count] = (uint32_t)(3 * mesh->triangle_count);
}

air_status air_vertex_sites_init(air_context *context, const air_mesh *mesh, air_vertex_sites *out)
{
    const size_t corners = 3 * mesh->triangle_count;
    *out = (air_vertex_sites){.mesh = mesh};
    out->first = air_allocate(context, mesh->vertex_count + 1, sizeof *out->first);
    out->corners = air_allocate(context, corners, sizeof *out->corners);
    out->cdf = air_allocate(context, corners, sizeof *out->cdf);
    out->areas = air_allocate(context, mesh->vertex_count, sizeof *out->areas);
    out->triangles = air_allocate(context, mesh->triangle_count, sizeof *out->triangles);
    if (out->first == NULL || out->corners == NULL || out->cdf == NULL || out->areas == NULL ||
        out->triangles == NULL) {
        air_vertex_sites_finish(context, out);
        return air_fail_memory(context, mesh->name);
    }
    sort_corners(out);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        out->triangles[t] = air_mesh_triangle_area(mesh, t);
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double sum = 0.0;
        for (uint32_t i = out->first[v]; i < out->first[v + 1]; i++) {
            sum += out->triangles[out->corners[i] / 3];
            out->cdf[i] = (float)sum;
        }
        for (uint32_t i = out->first[v]; i < out->first[v + 1]; i++) {
            out->cdf[i] = sum > 0.0 ? (float)((double)out->cdf[i] / sum) : 0.0f;
        }
        out->areas[v] = sum;
    }
    return AIR_OK;
}

void air_vertex_sites_finish(air_context *context, air_vertex_sites *sites)
{
    air_free(context, sites->first);
    air_free(context, sites->corners);
    air_free(context, sites->cdf);
    air_free(context, sites->areas);
    air_free(context, sites->triangles);
    *sites = (air_vertex_sites){.mesh = NULL};
}

bool air_vertex_draw(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    const air_vertex_sites *self = user;
    uint32_t i = self->first[site];
    const uint32_t end = self->first[site + 1];
    if (!(self->areas[site] > 0.0)) {
        return false;
    }
    while (i + 1 < end && u[0] >= self->cdf[i]) {
        i++;
    }
    const float before = i > self->first[site] ? self->cdf[i - 1] : 0.0f;
    const float size = self->cdf[i] - before;
    const float rest = size > 0.0f ? float_min((u[0] - before) / size, 0x1.fffffep-1f) : 0.0f;
    /* The hat's value over its triangle has the density 6 h (1 - h), whose cumulative function
     * 3 h^2 - 2 h^3 is inverted by a cosine; what is left of the weights is even. */
    const float h = 0.5f - sinf(asinf(1.0f - 2.0f * rest) * (1.0f / 3.0f));
    float weights[3];
    const uint32_t corner = self->corners[i] % 3;
    weights[corner] = h;
    weights[(corner + 1) % 3] = (1.0f - h) * u[1];
    weights[(corner + 2) % 3] = (1.0f - h) * (1.0f - u[1]);
    air_surface_place place;
    if (!air_surface_place_make(self->mesh, self->corners[i] / 3, weights[1], weights[2], &place)) {
        return false;
    }
    *out = (air_path_receiver){.position = place.position,
                               .normal = place.normal,
                               .geometric = place.geometric,
                               .offset = place.offset};
    return true;
}

/* ---- inside of something ---- */

/* Sums of known neighbours' means, and their weights, for all vertices that are not known. */
static void sum_neighbours(const air_vertex_sites *sites, const uint8_t *known, const float *means,
                           double *sums)
{
    const air_mesh *mesh = sites->mesh;
    memset(sums, 0, 4 * mesh->vertex_count * sizeof *sums);
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const size_t t = i / 3, v = mesh->indices[i];
        for (size_t k = 1; k < 3 && !known[v]; k++) {
            const size_t w = mesh->indices[3 * t + (i + k) % 3];
            const double area = known[w] ? sites->triangles[t] : 0.0;
            for (size_t c = 0; c < 3; c++) {
                sums[4 * v + c] += area * (double)means[3 * w + c];
            }
            sums[4 * v + 3] += area;
        }
    }
}

air_status air_vertex_fill(air_context *context, const air_vertex_sites *sites,
                           const uint8_t *valid, float *means)
{
    enum { RINGS = 64 }; /* what lies deeper does not reach what is seen */
    const size_t n = sites->mesh->vertex_count;
    double *sums = air_allocate(context, n, 4 * sizeof *sums);
    uint8_t *known = air_allocate(context, n, 1);
    const bool complete = sums != NULL && known != NULL;
    size_t found = complete ? n : 0;
    if (complete) {
        memcpy(known, valid, n);
    }
    for (int ring = 0; ring < RINGS && found > 0; ring++) {
        found = 0;
        sum_neighbours(sites, known, means, sums);
        for (size_t i = 0; i < n; i++) {
            if (!known[i] && sums[4 * i + 3] > 0.0) {
                for (size_t c = 0; c < 3; c++) {
                    means[3 * i + c] = (float)(sums[4 * i + c] / sums[4 * i + 3]);
                }
                known[i] = 1;
                found++;
            }
        }
    }
    air_free(context, sums);
    air_free(context, known);
    return complete ? AIR_OK : air_fail_memory(context, sites->mesh->name);
}

/* ---- least squares ---- */

/* out = M v for the mass matrix: a triangle of area A gives A/6 to each of its corners, A/12 to
 * each pair. */
static void multiply(const air_vertex_sites *sites, const double *v, double *out)
{
    const air_mesh *mesh = sites->mesh;
    memset(out, 0, mesh->vertex_count * sizeof *out);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *at = mesh->indices + 3 * t;
        const double area = sites->triangles[t] / 12.0;
        const double sum = v[at[0]] + v[at[1]] + v[at[2]];
        for (int c = 0; c < 3; c++) {
            out[at[c]] += area * (sum + v[at[c]]);
        }
    }
}

static double dot(const double *a, const double *b, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* Conjugate gradients with the diagonal as preconditioner; the matrix' condition is then at most 4
 * [Wathen1987], so each step gains a factor of 3. x: in the start, out the solution. */
static void solve(const air_vertex_sites *sites, const double *b, double *x, double *work)
{
    enum { STEPS = 30 };
    const size_t n = sites->mesh->vertex_count;
    double *r = work, *z = work + n, *p = work + 2 * n, *q = work + 3 * n;
    double before = 1.0, tolerance = 0.0;
    multiply(sites, x, q);
    memset(p, 0, n * sizeof *p);
    for (size_t i = 0; i < n; i++) {
        r[i] = b[i] - q[i];
        /* of the right side, in the norm of what is left: 1e-14 of its square */
        tolerance += sites->areas[i] > 0.0 ? 1e-14 * b[i] * b[i] * 6.0 / sites->areas[i] : 0.0;
    }
    for (int step = 0; step < STEPS; step++) {
        for (size_t i = 0; i < n; i++) {
            z[i] = sites->areas[i] > 0.0 ? r[i] * 6.0 / sites->areas[i] : 0.0;
        }
        const double now = dot(r, z, n);
        if (!(now > tolerance)) {
            return;
        }
        for (size_t i = 0; i < n; i++) {
            p[i] = z[i] + (step > 0 ? now / before : 0.0) * p[i];
        }
        multiply(sites, p, q);
        const double alpha = now / dot(p, q, n);
        for (size_t i = 0; i < n; i++) {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
        }
        before = now;
    }
}

air_status air_vertex_solve(air_context *context, const air_vertex_sites *sites, float *values)
{
    const size_t n = sites->mesh->vertex_count;
    double *work = air_allocate(context, n, 6 * sizeof *work);
    if (work == NULL) {
        return air_fail_memory(context, sites->mesh->name);
    }
    double *b = work + 4 * n, *x = work + 5 * n;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            /* the integral of a hat is a third of its triangles' area */
            x[i] = (double)values[3 * i + (size_t)c];
            b[i] = x[i] * sites->areas[i] / 3.0;
        }
        solve(sites, b, x, work);
        for (size_t i = 0; i < n; i++) {
            values[3 * i + (size_t)c] = (float)double_max(x[i], 0.0);
        }
    }
    air_free(context, work);
    return AIR_OK;
}

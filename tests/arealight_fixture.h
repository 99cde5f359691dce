/* arealight_fixture.h: random polygons, and integrals over them by adaptive cubature of their
 * definition, for tests of the arealight kernel. */
#ifndef AIR_TESTS_AREALIGHT_FIXTURE_H
#define AIR_TESTS_AREALIGHT_FIXTURE_H

#include <math.h>
#include <string.h>

#include "airlight/arealight.h"
#include "core/quadrature.h"
#include "core/vec.h"
#include "random_geometry.h"

typedef double polygon_vertices[AIR_AREA_MAX_VERTICES][3];

/* What the kernel takes, of an array of triples, const or not. */
static inline const double (*fixed(const void *polygon))[3] { return (const double(*)[3])polygon; }

/* A convex polygon with its vertices on an ellipse of half axes a and b in the frame's first two
 * directions, height along the third, its centre moved by (x, y). */
static inline void ellipse_polygon(air_rng *rng, double frame[3][3], size_t count,
                                   const double half[2], const double centre[3],
                                   polygon_vertices out)
{
    for (size_t k = 0; k < count; k++) {
        const double angle =
            2.0 * AIR_PI * ((double)k + random_between(rng, -0.3, 0.3)) / (double)count;
        const double place[3] = {centre[0] + half[0] * cos(angle), centre[1] + half[1] * sin(angle),
                                 centre[2]};
        for (int i = 0; i < 3; i++) {
            out[k][i] = place[0] * frame[0][i] + place[1] * frame[1][i] + place[2] * frame[2][i];
        }
    }
}

/* A polygon of 3 to 8 vertices, half axes 0.1 to 2, at heights of 0.05 to 3 above a plane. */
static inline size_t random_polygon(air_rng *rng, polygon_vertices out)
{
    double frame[3][3];
    const size_t count = 3 + air_rng_next(rng) % 6u;
    const double half[2] = {exp(random_between(rng, log(0.1), log(2.0))),
                            exp(random_between(rng, log(0.1), log(2.0)))};
    const double centre[3] = {random_between(rng, -2.0, 2.0), random_between(rng, -2.0, 2.0),
                              exp(random_between(rng, log(0.05), log(3.0)))};
    random_frame(rng, frame);
    ellipse_polygon(rng, frame, count, half, centre, out);
    return count;
}

/* The face of the box [low, high] about the origin: axis 0 to 2 and side 0 or 1. */
static inline void box_face(const double low[3], const double high[3], int axis, int side,
                            polygon_vertices out)
{
    const int s = (axis + 1) % 3, t = (axis + 2) % 3;
    for (int k = 0; k < 4; k++) {
        out[k][axis] = side == 0 ? low[axis] : high[axis];
        out[k][s] = k == 0 || k == 3 ? low[s] : high[s];
        out[k][t] = k < 2 ? low[t] : high[t];
    }
}

static inline void reversed(polygon_vertices polygon, size_t count, polygon_vertices out)
{
    for (size_t k = 0; k < count; k++) {
        memcpy(out[k], polygon[count - 1 - k], sizeof out[k]);
    }
}

/* Turned by the frame and scaled. */
static inline void turned(double frame[3][3], double scale, const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = scale * dot(frame[i], v);
    }
}

static inline double henyey_greenstein(double g, double cosine)
{
    const double square = 1.0 + g * g + 2.0 * g * cosine;
    return (1.0 - g * g) / (4.0 * AIR_PI * square * sqrt(square));
}

/* ---- integrals over directions by their definition ---- */

/* f of a point of the polygon; also its unit direction is given. */
typedef double area_function(const void *user, const double point[3], const double dir[3]);

typedef struct area_integral {
    area_function *f;
    const void *user;
    double nodes[10], weights[10];
    double error;
} area_integral;

/* f dw over a triangle, 10 x 10 points by the map that shrinks a square's side to a. */
static inline double triangle_once(const area_integral *self, const double a[3], const double b[3],
                                   const double c[3])
{
    double ab[3], ac[3], bc[3], normal[3], sum = 0.0;
    for (int i = 0; i < 3; i++) {
        ab[i] = b[i] - a[i];
        ac[i] = c[i] - a[i];
        bc[i] = c[i] - b[i];
    }
    cross(ab, ac, normal);
    for (int j = 0; j < 100; j++) {
        const double x = 0.5 * (1.0 + self->nodes[j / 10]), y = 0.5 * (1.0 + self->nodes[j % 10]);
        double point[3], dir[3];
        for (int i = 0; i < 3; i++) {
            point[i] = a[i] + x * (ab[i] + y * bc[i]);
        }
        const double square = dot(point, point), distance = sqrt(square);
        for (int i = 0; i < 3; i++) {
            dir[i] = point[i] / distance;
        }
        sum += 0.25 * self->weights[j / 10] * self->weights[j % 10] * x * fabs(dot(normal, dir)) /
               square * self->f(self->user, point, dir);
    }
    return sum;
}

/* Cut into four until they agree with the whole. */
static inline double triangle_integral(const area_integral *self, const double a[3],
                                       const double b[3], const double c[3], double whole,
                                       int depth)
{
    double ab[3], bc[3], ca[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = 0.5 * (a[i] + b[i]);
        bc[i] = 0.5 * (b[i] + c[i]);
        ca[i] = 0.5 * (c[i] + a[i]);
    }
    const double parts[4] = {triangle_once(self, a, ab, ca), triangle_once(self, b, bc, ab),
                             triangle_once(self, c, ca, bc), triangle_once(self, ab, bc, ca)};
    const double sum = parts[0] + parts[1] + parts[2] + parts[3];
    if (depth == 0 || fabs(sum - whole) <= self->error) {
        return sum;
    }
    return triangle_integral(self, a, ab, ca, parts[0], depth - 1) +
           triangle_integral(self, b, bc, ab, parts[1], depth - 1) +
           triangle_integral(self, c, ca, bc, parts[2], depth - 1) +
           triangle_integral(self, ab, bc, ca, parts[3], depth - 1);
}

/* The integral over the polygon's directions; relative error about 1e-11 for smooth f. */
static inline double integrate_directions(polygon_vertices polygon, size_t count, area_function *f,
                                          const void *user)
{
    area_integral self = {.f = f, .user = user};
    double wholes[AIR_AREA_MAX_VERTICES] = {0.0}, sum = 0.0;
    air_gauss_legendre(10, self.nodes, self.weights);
    for (size_t k = 1; k + 1 < count; k++) {
        wholes[k] = triangle_once(&self, polygon[0], polygon[k], polygon[k + 1]);
        sum += wholes[k];
    }
    self.error = 1e-12 * fabs(sum);
    sum = 0.0;
    for (size_t k = 1; k + 1 < count; k++) {
        sum += triangle_integral(&self, polygon[0], polygon[k], polygon[k + 1], wholes[k], 12);
    }
    return sum;
}

#endif

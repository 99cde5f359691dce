/* radial_geometry.c: the octahedral square and the shells. */
#include <assert.h>

#include "core/vec.h"
#include "ordinates/radial.h"

double radial_ratio(uint32_t n) { return 1.0 + sqrt(4.0 * AIR_PI) / (double)n; }

double air_radial_radius(const air_radial_grid *grid, uint32_t k)
{
    assert(k <= grid->shells);
    return (double)grid->radius_m * pow(radial_ratio(grid->directions), (double)k - grid->shells);
}

double air_radial_volume(const air_radial_grid *grid, uint32_t k, double solid_angle)
{
    const double inner = air_radial_radius(grid, k), rho = radial_ratio(grid->directions);
    return solid_angle * inner * inner * inner * (rho * rho * rho - 1.0) / 3.0;
}

/* The unit direction of a point of the square. */
static void direction_of(double x, double y, double out[3])
{
    const double z = 1.0 - fabs(x) - fabs(y);
    const double dx = z < 0.0 ? copysign(1.0 - fabs(y), x) : x;
    const double dy = z < 0.0 ? copysign(1.0 - fabs(x), y) : y;
    const double scale = 1.0 / sqrt(dx * dx + dy * dy + z * z);
    out[0] = dx * scale;
    out[1] = dy * scale;
    out[2] = z * scale;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double angle_between(const double a[3], const double b[3])
{
    double c[3];
    cross(a, b, c);
    return atan2(sqrt(dot(c, c)), dot(a, b));
}

void air_radial_direction(uint32_t n, uint32_t u, uint32_t v, double out_direction[3])
{
    assert(u < n && v < n);
    direction_of((2.0 * u + 1.0) / n - 1.0, (2.0 * v + 1.0) / n - 1.0, out_direction);
}

/* Corner (i, j) of the lattice, i, j in [0, n]. */
static void corner(uint32_t n, uint32_t i, uint32_t j, double out[3])
{
    direction_of(2.0 * i / n - 1.0, 2.0 * j / n - 1.0, out);
}

/* [VanOosterom1983, eq. 8] for unit vectors. */
static double triangle(const double a[3], const double b[3], const double c[3])
{
    double bc[3];
    cross(b, c, bc);
    return 2.0 * atan2(fabs(dot(a, bc)), 1.0 + dot(a, b) + dot(b, c) + dot(a, c));
}

/* Two triangles; where the fold |x| + |y| = 1 crosses the cell it is their common edge. */
static double solid_angle_of(uint32_t n, uint32_t u, uint32_t v)
{
    double p00[3], p10[3], p01[3], p11[3];
    corner(n, u, v, p00);
    corner(n, u + 1, v, p10);
    corner(n, u, v + 1, p01);
    corner(n, u + 1, v + 1, p11);
    if ((2 * u < n) == (2 * v < n)) {
        return triangle(p00, p10, p01) + triangle(p11, p10, p01);
    }
    return triangle(p00, p10, p11) + triangle(p00, p01, p11);
}

void air_radial_solid_angles(uint32_t n, double *out_solid_angles)
{
    for (uint32_t v = 0; v < n; v++) {
        for (uint32_t u = 0; u < n; u++) {
            out_solid_angles[v * n + u] = solid_angle_of(n, u, v);
        }
    }
}

uint32_t air_radial_neighbour(uint32_t n, uint32_t u, uint32_t v, int side)
{
    assert(u < n && v < n && side >= 0 && side < 4);
    switch (side) {
    case 0:
        return u > 0 ? v * n + u - 1 : (n - 1 - v) * n;
    case 1:
        return u + 1 < n ? v * n + u + 1 : (n - 1 - v) * n + n - 1;
    case 2:
        return v > 0 ? (v - 1) * n + u : n - 1 - u;
    default:
        return v + 1 < n ? (v + 1) * n + u : (n - 1) * n + n - 1 - u;
    }
}

double air_radial_arc(uint32_t n, uint32_t u, uint32_t v, int side)
{
    assert(u < n && v < n && side >= 0 && side < 4);
    double a[3], b[3];
    corner(n, side == 1 ? u + 1 : u, side == 3 ? v + 1 : v, a);
    corner(n, side == 0 ? u : u + 1, side == 2 ? v : v + 1, b);
    return angle_between(a, b);
}

/* With odd integers i = 2u + 1 - n and j likewise for coordinates, -d of (i, j) is (-sign(i) (n -
 * |j|), -sign(j) (n - |i|)), on either side of the fold. */
uint32_t air_radial_opposite(uint32_t n, uint32_t u, uint32_t v)
{
    assert(u < n && v < n);
    const uint32_t from_u = 2 * u < n ? 2 * u + 1 : 2 * n - 2 * u - 1; /* n - |i| */
    const uint32_t from_v = 2 * v < n ? 2 * v + 1 : 2 * n - 2 * v - 1;
    const uint32_t i = 2 * u < n ? n + from_v : n - from_v;
    const uint32_t j = 2 * v < n ? n + from_u : n - from_u;
    return (j - 1) / 2 * n + (i - 1) / 2;
}

/* Cell (i, j), each of which may be one step off the square. */
static uint32_t glued(uint32_t n, int32_t i, int32_t j)
{
    const int32_t last = (int32_t)n - 1;
    if (i < 0 || i > last) {
        i = i < 0 ? 0 : last;
        j = last - j;
    }
    if (j < 0 || j > last) {
        j = j < 0 ? 0 : last;
        i = last - i;
    }
    return (uint32_t)(j * (int32_t)n + i);
}

void air_radial_surrounding(uint32_t n, const double direction[3], uint32_t out_cells[4],
                            double out_weights[4])
{
    const double scale = 1.0 / (fabs(direction[0]) + fabs(direction[1]) + fabs(direction[2]));
    double x = direction[0] * scale, y = direction[1] * scale;
    if (direction[2] < 0.0) {
        const double folded = copysign(1.0 - fabs(y), x);
        y = copysign(1.0 - fabs(x), y);
        x = folded;
    }
    const double fu = 0.5 * (x + 1.0) * n - 0.5, fv = 0.5 * (y + 1.0) * n - 0.5;
    const double iu = floor(fu), iv = floor(fv), wu = fu - iu, wv = fv - iv;
    for (int c = 0; c < 4; c++) {
        out_cells[c] = glued(n, (int32_t)iu + (c & 1), (int32_t)iv + (c >> 1));
        out_weights[c] = ((c & 1) != 0 ? wu : 1.0 - wu) * ((c >> 1) != 0 ? wv : 1.0 - wv);
    }
}

void air_radial_cosine_lobe(uint32_t n, const float normal[3], float *out_intensity)
{
    const double axis[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    double power = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t v = 0; v < n; v++) {
            for (uint32_t u = 0; u < n; u++) {
                double d[3];
                air_radial_direction(n, u, v, d);
                const double cosine = double_max(0.0, dot(axis, d));
                if (pass == 0) {
                    power += cosine * solid_angle_of(n, u, v);
                } else {
                    out_intensity[v * n + u] = (float)(cosine / power);
                }
            }
        }
    }
}

/* ---- tables of a run ---- */

/* Of the lateral power that leaves a cell the part arc / perimeter would go through each edge. A
 * field uniform per solid angle stays so if what passes an edge is the same both ways: so each
 * passes 4 arc min(omega / perimeter) of its two cells, per power per solid angle, and the rest
 * stays where it is. */
static void fill_sides(radial_mesh *mesh)
{
    const uint32_t n = (uint32_t)mesh->n;
    double *const ratio = mesh->stay; /* first omega / perimeter */
    for (uint32_t c = 0; c < n * n; c++) {
        double perimeter = 0.0;
        for (int side = 0; side < 4; side++) {
            mesh->neighbour[side][c] = air_radial_neighbour(n, c % n, c / n, side);
            mesh->from[side][c] = air_radial_arc(n, c % n, c / n, side);
            perimeter += mesh->from[side][c];
        }
        ratio[c] = mesh->omega[c] / perimeter;
    }
    for (int side = 0; side < 4; side++) {
        for (uint32_t c = 0; c < n * n; c++) {
            mesh->from[side][c] *= double_min(ratio[c], ratio[mesh->neighbour[side][c]]);
        }
    }
    for (uint32_t c = 0; c < n * n; c++) {
        mesh->stay[c] = 1.0;
        for (int side = 0; side < 4; side++) {
            mesh->stay[c] -= mesh->from[side][c] / mesh->omega[c];
            mesh->from[side][c] /= mesh->omega[mesh->neighbour[side][c]];
        }
    }
}

/* ---- diffusion: linear finite elements on the triangles between the centres of cells ---- */

/* Squares of four centres are cut along the diagonal that is level on the octahedron's face, so
 * that all angles stay below 90 degrees; across the rims of faces they are trapezoids, and it does
 * not matter. Square (i, j) has its lower left centre at cell (i, j); i, j in [-1, n - 1]. */
static bool falls(uint32_t n, int32_t i, int32_t j)
{
    const int32_t middle = (int32_t)n / 2 - 1;
    return (i > middle) == (j > middle);
}

static void centre(uint32_t n, int32_t i, int32_t j, double out[3])
{
    const uint32_t cell = glued(n, i, j);
    air_radial_direction(n, cell % n, cell / n, out);
}

/* The cotangent of the angle at a; 0 where two corners are one: at the middles of the square's rim
 * two cells meet along two edges. */
static double cotangent(const double a[3], const double b[3], const double c[3])
{
    const double ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const double ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    double normal[3];
    cross(ab, ac, normal);
    const double area = sqrt(dot(normal, normal));
    return area > 0.0 ? dot(ab, ac) / area : 0.0;
}

/* Conductance from (i, j) to (i + 1, j), or with along_v to (i, j + 1): half the cotangents of the
 * angles that its two triangles have opposite to it. */
static double side_link(uint32_t n, int32_t i, int32_t j, bool along_v)
{
    double from[3], to[3], above[3], below[3];
    centre(n, i, j, from);
    if (along_v) {
        centre(n, i, j + 1, to);
        centre(n, i + 1, falls(n, i, j) ? j : j + 1, above);
        centre(n, i - 1, falls(n, i - 1, j) ? j + 1 : j, below);
    } else {
        centre(n, i + 1, j, to);
        centre(n, falls(n, i, j) ? i : i + 1, j + 1, above);
        centre(n, falls(n, i, j - 1) ? i + 1 : i, j - 1, below);
    }
    return double_max(0.0, 0.5 * (cotangent(above, from, to) + cotangent(below, from, to)));
}

/* The same for the diagonal of square (i, j). */
static double diagonal_link(uint32_t n, int32_t i, int32_t j)
{
    double p[2][2][3];
    for (int a = 0; a < 4; a++) {
        centre(n, i + (a & 1), j + (a >> 1), p[a >> 1][a & 1]);
    }
    const bool falling = falls(n, i, j);
    const double *const from = falling ? p[0][1] : p[0][0], *const to = falling ? p[1][0] : p[1][1];
    const double *const one = falling ? p[0][0] : p[0][1], *const two = falling ? p[1][1] : p[1][0];
    return double_max(0.0, 0.5 * (cotangent(one, from, to) + cotangent(two, from, to)));
}

static void fill_straight_rings(radial_mesh *mesh)
{
    const uint32_t n = (uint32_t)mesh->n;
    for (uint32_t q = 0; q < 2 * n; q++) {
        for (uint32_t p = 0; p < n / 2; p++) {
            const uint32_t along = q < n ? q : 2 * n - 1 - q, across = q < n ? p : n - 1 - p;
            const size_t at = (size_t)q * (n / 2) + p;
            const int32_t begin = q < n ? (int32_t)along : (int32_t)along - 1;
            mesh->order[0][at] = along * n + across;
            mesh->link[0][at] = side_link(n, (int32_t)across, begin, true);
            mesh->order[1][at] = across * n + along;
            mesh->link[1][at] = side_link(n, begin, (int32_t)across, false);
        }
    }
}

/* Cells of |i| + |j| = sum, i = 2u + 1 - n, j likewise, m of them in each quadrant: a chain, the
 * quadrant's entries next to each other, joined by diagonals. */
static void fill_level(radial_mesh *mesh, uint32_t m, bool lower, size_t at, size_t stride)
{
    const int32_t n = (int32_t)mesh->n, sum = lower ? 2 * n - 2 * (int32_t)m : 2 * (int32_t)m;
    const int32_t first = lower ? sum - n + 1 : 1;
    for (int32_t t = 0; t < (int32_t)m; t++, at += stride) {
        int32_t j = first + 2 * t, i = sum - j, next_i = i - 2, next_j = j + 2;
        for (size_t quadrant = 0; quadrant < 4; quadrant++) {
            const int32_t u = (i + n - 1) / 2, v = (j + n - 1) / 2;
            mesh->order[2][at + quadrant] = (uint32_t)(v * n + u);
            mesh->link[2][at + quadrant] = 0.0;
            if (t + 1 < (int32_t)m) {
                mesh->link[2][at + quadrant] =
                    diagonal_link((uint32_t)n, next_i < i ? u - 1 : u, next_j < j ? v - 1 : v);
            }
            const int32_t turned = i, next_turned = next_i;
            i = -j;
            j = turned;
            next_i = -next_j;
            next_j = next_turned;
        }
    }
}

static void fill_rings(radial_mesh *mesh)
{
    fill_straight_rings(mesh);
    size_t at = 0;
    for (uint32_t m = 1; m < mesh->n / 2; m++) {
        fill_level(mesh, m, false, at, 8);
        fill_level(mesh, m, true, at + 4, 8);
        at += 8 * m;
    }
    fill_level(mesh, (uint32_t)mesh->n / 2, false, at, 4);
}

void radial_mesh_fill(radial_mesh *mesh, const air_radial_params *params)
{
    const uint32_t n = (uint32_t)mesh->n;
    air_radial_solid_angles(n, mesh->omega);
    for (uint32_t c = 0; c < n * n; c++) {
        mesh->opposite[c] = air_radial_opposite(n, c % n, c / n);
    }
    if (params->lateral == AIR_RADIAL_SIDES) {
        fill_sides(mesh);
    } else {
        fill_rings(mesh);
    }
}

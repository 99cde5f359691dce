/* lamp.c: checked lamps, their vertices seen from a point, points on them. */
#include "arealight/gauss.h"
#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"

#include "airlight/arealight.h"

/* Squares of areas of such lamps, and of distances to them, are neither 0 nor infinite. */
static const double smallest_size = 1e-30, largest_size = 1e30;

/* Of the lamp's size: how far a vertex may be out of plane, and the least width of an area. */
static const double flatness = 1e-4, least_width = 1e-9;

/* Sines of angles between edges below this are rounding: the edges continue each other. */
static const double straight = 1e-9;

/* The edges into and out of vertex k. */
static void corner(const double (*vertices)[3], size_t count, size_t k, double into[3],
                   double out_of[3])
{
    air_subtract3(vertices[k], vertices[k > 0 ? k - 1 : count - 1], into);
    air_subtract3(vertices[k + 1 < count ? k + 1 : 0], vertices[k], out_of);
}

static air_status check_numbers(air_context *context, const double (*vertices)[3], size_t count,
                                double *out_size)
{
    double size = 0.0;
    if (count < 3 || count > AIR_AREA_MAX_VERTICES) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "area lamp: %zu vertices, must be 3 to %d",
                        count, AIR_AREA_MAX_VERTICES);
    }
    for (size_t k = 0; k < count; k++) {
        double way[3];
        if (!air_finite3(vertices[k])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "area lamp: vertex %zu: (%g, %g, %g) is not finite", k, vertices[k][0],
                            vertices[k][1], vertices[k][2]);
        }
        air_subtract3(vertices[k], vertices[0], way);
        size = fmax(size, fmax(fabs(way[0]), fmax(fabs(way[1]), fabs(way[2]))));
    }
    if (!(size > smallest_size && size < largest_size)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "area lamp: vertex 0: all others are within %g m of it, must be more than "
                        "%g and less than %g",
                        size, smallest_size, largest_size);
    }
    *out_size = size;
    return AIR_OK;
}

/* Area, centre of gravity and normal by a fan. Parts of the fan that turn the other way count
 * against it, which only polygons have that are refused afterwards. */
static air_status measure(air_context *context, double size, air_area_lamp *lamp)
{
    double sum[3] = {0.0, 0.0, 0.0}, moment[3] = {0.0, 0.0, 0.0}, parts[AIR_AREA_MAX_VERTICES][3];
    const double *first = lamp->vertices[0];
    for (size_t k = 1; k + 1 < lamp->vertex_count; k++) {
        double a[3], b[3];
        air_subtract3(lamp->vertices[k], first, a);
        air_subtract3(lamp->vertices[k + 1], first, b);
        air_cross3(a, b, parts[k]);
        air_along3(sum, 0.5, parts[k], sum);
    }
    lamp->area = air_length3(sum);
    if (!(lamp->area > least_width * size * size)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "area lamp: vertices 0 to %zu enclose no area",
                        lamp->vertex_count - 1);
    }
    for (int i = 0; i < 3; i++) {
        lamp->normal[i] = sum[i] / lamp->area;
    }
    for (size_t k = 1; k + 1 < lamp->vertex_count; k++) {
        const double share = 0.5 * air_dot3(parts[k], lamp->normal) / lamp->area;
        for (int i = 0; i < 3; i++) {
            moment[i] +=
                share / 3.0 *
                ((lamp->vertices[k][i] - first[i]) + (lamp->vertices[k + 1][i] - first[i]));
        }
    }
    air_along3(first, 1.0, moment, lamp->centre);
    return AIR_OK;
}

static air_status check_plane(air_context *context, const air_area_lamp *lamp, double size)
{
    for (size_t k = 0; k < lamp->vertex_count; k++) {
        double way[3];
        air_subtract3(lamp->vertices[k], lamp->centre, way);
        const double height = fabs(air_dot3(way, lamp->normal));
        if (!(height <= flatness * size)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "area lamp: vertex %zu: %g m out of plane, must be at most %g", k,
                            height, flatness * size);
        }
    }
    return AIR_OK;
}

/* Every corner turns left, and all together turn once: a star turns left too, but twice. */
static air_status check_corners(air_context *context, const air_area_lamp *lamp)
{
    double turn = 0.0;
    for (size_t k = 0; k < lamp->vertex_count; k++) {
        double into[3], out_of[3], normal[3];
        corner(lamp->vertices, lamp->vertex_count, k, into, out_of);
        air_cross3(into, out_of, normal);
        const double lengths = air_length3(into) * air_length3(out_of);
        const double left = air_dot3(normal, lamp->normal), on = air_dot3(into, out_of);
        if (!(lengths > 0.0)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "area lamp: vertex %zu: is the same as a neighbour", k);
        }
        if (!(left > straight * lengths) && !(left >= -straight * lengths && on > 0.0)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "area lamp: vertex %zu: the polygon is not convex there", k);
        }
        turn += atan2(left, on);
        if (!(turn < 3.0 * AIR_PI)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "area lamp: vertex %zu: the polygon crosses itself", k);
        }
    }
    return AIR_OK;
}

air_status air_area_lamp_make(air_context *context, const double (*vertices)[3],
                              size_t vertex_count, bool two_sided, air_area_lamp *out)
{
    double size = 0.0;
    air_status status = check_numbers(context, vertices, vertex_count, &size);
    if (status != AIR_OK) {
        return status;
    }
    air_area_lamp lamp = {.vertex_count = vertex_count, .two_sided = two_sided};
    for (size_t k = 0; k < vertex_count; k++) {
        air_copy3(vertices[k], lamp.vertices[k]);
    }
    status = measure(context, size, &lamp);
    if (status == AIR_OK) {
        status = check_plane(context, &lamp, size);
    }
    if (status == AIR_OK) {
        status = check_corners(context, &lamp);
    }
    if (status == AIR_OK) {
        *out = lamp;
    }
    return status;
}

bool air_area_lamp_seen_from(const air_area_lamp *lamp, const double point[3], double (*out)[3])
{
    double from_centre[3];
    air_subtract3(point, lamp->centre, from_centre);
    for (size_t k = 0; k < lamp->vertex_count; k++) {
        air_subtract3(lamp->vertices[k], point, out[k]);
    }
    return lamp->two_sided || air_dot3(from_centre, lamp->normal) > 0.0;
}

/* The point of a quadrilateral at (x, y) in the unit square: (1-x)(1-y) a + x (1-y) b + x y c +
 * (1-x) y d; weight gets the area of a unit of the square there. */
static void quadrilateral_point(const air_area_lamp *lamp, double x, double y, double point[3],
                                double *weight)
{
    const double *a = lamp->vertices[0];
    double ab[3], ad[3], cross[3], along_x[3], along_y[3], normal[3];
    air_subtract3(lamp->vertices[1], a, ab);
    air_subtract3(lamp->vertices[3], a, ad);
    for (int i = 0; i < 3; i++) {
        cross[i] = (lamp->vertices[2][i] - lamp->vertices[1][i]) - ad[i];
        along_x[i] = ab[i] + y * cross[i];
        along_y[i] = ad[i] + x * cross[i];
        point[i] = a[i] + x * ab[i] + y * along_y[i];
    }
    air_cross3(along_x, along_y, normal);
    *weight = air_dot3(normal, lamp->normal);
}

/* The point of a fan's triangle at distance x from vertex 0 (1: on the far edge) and y along that
 * edge, by Duffy's map [Duffy1982]. */
static void triangle_point(const air_area_lamp *lamp, size_t triangle, double x, double y,
                           double point[3], double *weight)
{
    const double *a = lamp->vertices[0];
    double ab[3], bc[3], normal[3];
    air_subtract3(lamp->vertices[triangle + 1], a, ab);
    air_subtract3(lamp->vertices[triangle + 2], lamp->vertices[triangle + 1], bc);
    for (int i = 0; i < 3; i++) {
        point[i] = a[i] + x * (ab[i] + y * bc[i]);
    }
    air_cross3(ab, bc, normal);
    *weight = x * air_dot3(normal, lamp->normal);
}

size_t air_area_lamp_points(const air_area_lamp *lamp, int m, double (*points)[3], double *weights)
{
    double nodes[AIR_AREA_MAX_CUBATURE], shares[AIR_AREA_MAX_CUBATURE];
    const size_t n = m < 1 ? 1 : (m < AIR_AREA_MAX_CUBATURE ? (size_t)m : AIR_AREA_MAX_CUBATURE);
    const size_t patches = lamp->vertex_count == 4 ? 1 : lamp->vertex_count - 2;
    size_t count = 0;
    air_area_gauss(n, nodes, shares);
    for (size_t patch = 0; patch < patches; patch++) {
        for (size_t i = 0; i < n * n; i++) {
            const double x = 0.5 * (1.0 + nodes[i / n]), y = 0.5 * (1.0 + nodes[i % n]);
            double area;
            if (lamp->vertex_count == 4) {
                quadrilateral_point(lamp, x, y, points[count], &area);
            } else {
                triangle_point(lamp, patch, x, y, points[count], &area);
            }
            weights[count++] = 0.25 * shares[i / n] * shares[i % n] * area;
        }
    }
    return count;
}

/* polygon.c: see polygon.h. Geometry is checked in double, so that thin and distant polygons keep
 * their digits. */
#include "scene/lights/polygon.h"

#include <assert.h>

#include "core/warp.h"
#include "scene/lights/cdf.h"
#include "scene/texture.h"

/* ---- the plane ---- */

static double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross3(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void relative(const air_polygon_plane *plane, const float *vertex, double out[3])
{
    for (int k = 0; k < 3; k++) {
        out[k] = (double)vertex[k] - plane->center[k];
    }
}

/* A unit vector across n, from the axis that n points along least. */
static void across(const double n[3], double out[3])
{
    int least = 0;
    for (int k = 1; k < 3; k++) {
        least = fabs(n[k]) < fabs(n[least]) ? k : least;
    }
    double axis[3] = {0.0, 0.0, 0.0};
    axis[least] = 1.0;
    cross3(axis, n, out);
    const double length = sqrt(dot3(out, out));
    for (int k = 0; k < 3; k++) {
        out[k] /= length;
    }
}

/* Newell's normal: half the sum of the cross products of neighbours has the length of the area. */
static void fit_normal(air_polygon_plane *plane, const float *vertices, size_t count)
{
    double sum[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < count; i++) {
        double a[3], b[3], c[3];
        relative(plane, vertices + 3 * i, a);
        relative(plane, vertices + 3 * ((i + 1) % count), b);
        cross3(a, b, c);
        for (int k = 0; k < 3; k++) {
            sum[k] += 0.5 * c[k];
        }
    }
    plane->area = sqrt(dot3(sum, sum));
    for (int k = 0; k < 3; k++) {
        plane->normal[k] = plane->area > 0.0 ? sum[k] / plane->area : (k == 2 ? 1.0 : 0.0);
    }
}

air_polygon_plane air_polygon_fit(const float *vertices, size_t count)
{
    air_polygon_plane plane = {.area = 0.0};
    for (size_t i = 0; i < 3 * count; i++) {
        plane.center[i % 3] += (double)vertices[i] / (double)count;
        plane.magnitude = fmax(plane.magnitude, fabs((double)vertices[i]));
    }
    fit_normal(&plane, vertices, count);
    across(plane.normal, plane.s);
    cross3(plane.normal, plane.s, plane.t);
    for (size_t i = 0; i < count; i++) {
        double v[3];
        relative(&plane, vertices + 3 * i, v);
        plane.extent = fmax(plane.extent, sqrt(dot3(v, v)));
        plane.deviation = fmax(plane.deviation, fabs(dot3(v, plane.normal)));
    }
    return plane;
}

void air_polygon_flatten(const air_polygon_plane *plane, const float *vertices, size_t count,
                         air_point2 *out_points)
{
    for (size_t i = 0; i < count; i++) {
        double v[3];
        relative(plane, vertices + 3 * i, v);
        out_points[i] = (air_point2){dot3(v, plane->s), dot3(v, plane->t)};
    }
}

/* ---- in the plane ---- */

/* Twice the signed area of the triangle a, b, c. */
static double turn(air_point2 a, air_point2 b, air_point2 c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double air_polygon_area(const air_point2 *points, size_t count)
{
    double sum = 0.0;
    for (size_t i = 2; i < count; i++) {
        sum += 0.5 * turn(points[0], points[i - 1], points[i]);
    }
    return sum;
}

bool air_polygon_is_thin(double area, double extent, double magnitude)
{
    const double rounding = 0x1p-23; /* of float coordinates, both ends of an edge */
    return !(area > 4.0 * rounding * extent * fmax(extent, magnitude));
}

static bool edges_cross(air_point2 a, air_point2 b, air_point2 c, air_point2 d)
{
    const double c_side = turn(a, b, c), d_side = turn(a, b, d);
    const double a_side = turn(c, d, a), b_side = turn(c, d, b);
    return ((c_side > 0.0 && d_side < 0.0) || (c_side < 0.0 && d_side > 0.0)) &&
           ((a_side > 0.0 && b_side < 0.0) || (a_side < 0.0 && b_side > 0.0));
}

size_t air_polygon_crossing(const air_point2 *points, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        for (size_t j = i + 1; j < count; j++) {
            if (edges_cross(points[i], points[(i + 1) % count], points[j],
                            points[(j + 1) % count])) {
                return i;
            }
        }
    }
    return count;
}

/* ---- ear clipping ---- */

typedef struct ring {
    const air_point2 *points;
    size_t *previous, *next;
} ring;

static double turn_at(const ring *r, size_t i)
{
    return turn(r->points[r->previous[i]], r->points[i], r->points[r->next[i]]);
}

static bool same_point(air_point2 a, air_point2 b) { return a.x == b.x && a.y == b.y; }

/* Can the corner at i be cut off? It must turn left, and no other vertex may lie in its triangle.
 * Only vertices that do not turn left can be the first to lie there; those that coincide with a
 * corner belong to seams of polygons with holes. */
static bool is_ear(const ring *r, size_t i)
{
    const size_t before = r->previous[i], after = r->next[i];
    const air_point2 a = r->points[before], b = r->points[i], c = r->points[after];
    for (size_t k = r->next[after]; k != before; k = r->next[k]) {
        const air_point2 p = r->points[k];
        if (turn_at(r, k) > 0.0 || same_point(p, a) || same_point(p, b) || same_point(p, c)) {
            continue;
        }
        if (turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0) {
            return false;
        }
    }
    return true;
}

static void cut(ring *r, size_t i)
{
    r->next[r->previous[i]] = r->next[i];
    r->previous[r->next[i]] = r->previous[i];
}

size_t air_polygon_triangulate(const air_point2 *points, size_t count, size_t *links,
                               uint32_t (*out_triangles)[3])
{
    ring r = {points, links, links + count};
    for (size_t i = 0; i < count; i++) {
        r.previous[i] = (i + count - 1) % count;
        r.next[i] = (i + 1) % count;
    }
    size_t triangles = 0, left = count, at = 0, waited = 0;
    while (left > 2 && waited < left) {
        const double corner = turn_at(&r, at);
        const size_t next = r.next[at];
        if (corner > 0.0 && is_ear(&r, at)) {
            out_triangles[triangles][0] = (uint32_t)r.previous[at];
            out_triangles[triangles][1] = (uint32_t)at;
            out_triangles[triangles][2] = (uint32_t)next;
            triangles++;
        } else if (corner != 0.0) {
            at = next;
            waited++;
            continue;
        }
        /* cut, be it an ear or a corner that turns by nothing */
        cut(&r, at);
        left--;
        waited = 0;
        at = next;
    }
    return left > 2 ? 0 : triangles;
}

/* ---- building ---- */

/* On the plane, with the deviation that the check allowed taken out. */
static air_vec3 lift(const air_polygon_plane *plane, air_point2 p)
{
    double v[3];
    for (int k = 0; k < 3; k++) {
        v[k] = plane->center[k] + p.x * plane->s[k] + p.y * plane->t[k];
    }
    return vec3((float)v[0], (float)v[1], (float)v[2]);
}

static double triangle_area(const air_point2 *points, const uint32_t corners[3])
{
    return 0.5 * turn(points[corners[0]], points[corners[1]], points[corners[2]]);
}

static void store_triangles(const air_point2 *points, uint32_t (*corners)[3], air_light *light)
{
    double total = 0.0, sum = 0.0;
    for (size_t i = 0; i < light->triangle_count; i++) {
        total += triangle_area(points, corners[i]);
    }
    for (size_t i = 0; i < light->triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            light->triangles[i][k] = light->vertices[corners[i][k]];
        }
        sum += triangle_area(points, corners[i]);
        light->triangle_cdf[i] = (float)(sum / total);
    }
    light->area = (float)total;
}

air_status air_polygon_build(air_context *context, const float *vertices, size_t count,
                             air_light *light)
{
    air_status status = AIR_OK;
    const air_polygon_plane plane = air_polygon_fit(vertices, count);
    air_point2 *points = air_allocate(context, count, sizeof *points);
    size_t *links = air_allocate(context, 2 * count, sizeof *links);
    uint32_t(*corners)[3] = air_allocate(context, count, sizeof *corners);
    light->vertices = air_allocate(context, count, sizeof *light->vertices);
    light->triangles = air_allocate(context, count - 2, sizeof *light->triangles);
    light->triangle_cdf = air_allocate(context, count - 2, sizeof *light->triangle_cdf);
    if (points == NULL || links == NULL || corners == NULL || light->vertices == NULL ||
        light->triangles == NULL || light->triangle_cdf == NULL) {
        status = air_fail_memory(context, "polygon light");
        goto cleanup;
    }
    air_polygon_flatten(&plane, vertices, count, points);
    for (size_t i = 0; i < count; i++) {
        light->vertices[i] = lift(&plane, points[i]);
    }
    light->vertex_count = count;
    light->normal = vec3((float)plane.normal[0], (float)plane.normal[1], (float)plane.normal[2]);
    light->triangle_count = air_polygon_triangulate(points, count, links, corners);
    assert(light->triangle_count > 0);
    store_triangles(points, corners, light);
cleanup:
    air_free(context, corners);
    air_free(context, links);
    air_free(context, points);
    return status;
}

void air_polygon_finish(air_context *context, air_light *light)
{
    air_free(context, light->triangle_cdf);
    air_free(context, light->triangles);
    air_free(context, light->vertices);
}

/* ---- sampling ---- */

void air_polygon_sample(const air_light *light, float u1, float u2, air_light_point *out)
{
    const size_t triangle = air_cdf_choose(light->triangle_cdf, light->triangle_count, &u1);
    const air_vec3 *p = light->triangles[triangle];
    float b1, b2;
    sample_triangle(u1, u2, &b1, &b2);
    const float b0 = 1.0f - b1 - b2;
    out->position = vec3_madd(vec3_madd(vec3_scale(p[0], b0), b1, p[1]), b2, p[2]);
    out->normal = light->normal;
    out->value = light->color;
    if (light->emission_texture != NULL) {
        float uv[2];
        air_light_uv(light, b1, b2, uv);
        out->value = vec3_mul(light->color, air_texture_rgb(light->emission_texture, uv[0], uv[1]));
    }
    out->pdf = 1.0f / light->area;
}

bool air_polygon_connect(const air_light *light, const air_light_point *light_point, air_vec3 point,
                         air_connection *out)
{
    const air_vec3 to_light = vec3_sub(light_point->position, point);
    const float distance2 = vec3_dot(to_light, to_light);
    if (!(distance2 > 0.0f)) {
        return false;
    }
    const float distance = sqrtf(distance2);
    out->dir = vec3_scale(to_light, 1.0f / distance);
    out->distance = distance;
    out->incident = light_point->value;
    out->pdf = air_polygon_hit_pdf(light, out->dir, distance);
    return out->pdf > 0.0f;
}

float air_polygon_hit_pdf(const air_light *light, air_vec3 dir, float distance)
{
    const float toward = -vec3_dot(light->normal, dir); /* > 0: dir meets the front */
    const float cosine = light->one_sided ? toward : fabsf(toward);
    const float projected = cosine * light->area;
    return projected > 0.0f ? distance * distance / projected : 0.0f;
}

air_vec3 air_polygon_radiance(const air_light *light, air_vec3 dir)
{
    const bool dark = light->one_sided && vec3_dot(light->normal, dir) >= 0.0f;
    return dark ? vec3_set1(0.0f) : light->color;
}

/* polygon.c: clipping, solid angle, irradiance, distance. */
#include "arealight/polygon.h"

#include "core/vec.h"

bool air_cone_make(const double (*polygon)[3], size_t count, air_cone *out)
{
    out->count = 0;
    if (count < 3 || count > AIR_AREA_MAX_VERTICES) {
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        const double *next = polygon[i + 1 < count ? i + 1 : 0];
        air_subtract3(next, polygon[i], out->edges[i]);
        air_copy3(polygon[i], out->vertices[i]);
    }
    out->count = count;
    return true;
}

/* Adds the part of edge i from share `from` on, `part` of it long. */
static void add_part(air_cone *out, const air_cone *cone, size_t i, double from, double part)
{
    air_along3(cone->vertices[i], from, cone->edges[i], out->vertices[out->count]);
    for (int k = 0; k < 3; k++) {
        out->edges[out->count][k] = part * cone->edges[i][k];
    }
    out->count++;
}

void air_cone_clip(const air_cone *cone, const double axis[3], air_cone *out)
{
    out->count = 0;
    double height = cone->count > 0 ? air_dot3(axis, cone->vertices[0]) : 0.0;
    const double first = height;
    size_t left[AIR_CONE_VERTICES],
        left_count = 0; /* vertices from which the horizon is followed */
    for (size_t i = 0; i < cone->count; i++) {
        const double next = i + 1 < cone->count ? air_dot3(axis, cone->vertices[i + 1]) : first;
        const bool inside = height >= 0.0, stays = next >= 0.0;
        const double share = inside != stays ? air_horizon_share(height, next) : 1.0;
        if (inside) {
            add_part(out, cone, i, 0.0, share);
        }
        if (inside && !stays) {
            left[left_count++] = out->count;
            add_part(out, cone, i, share, 0.0);
        } else if (!inside && stays) {
            add_part(out, cone, i, share, 1.0 - share);
        }
        height = next;
    }
    for (size_t k = 0; k < left_count; k++) {
        const size_t next = left[k] + 1 < out->count ? left[k] + 1 : 0;
        air_subtract3(out->vertices[next], out->vertices[left[k]], out->edges[left[k]]);
    }
    if (out->count < 3) {
        out->count = 0;
    }
}

void air_cone_normal(const air_cone *cone, double out[3])
{
    double to_here[3] = {0.0, 0.0, 0.0}, part[3];
    out[0] = out[1] = out[2] = 0.0;
    for (size_t i = 1; i + 1 < cone->count; i++) {
        air_along3(to_here, 1.0, cone->edges[i - 1], to_here);
        air_cross3(to_here, cone->edges[i], part);
        air_along3(out, 1.0, part, out);
    }
}

/* A fan of triangles, each by [VanOosterom1983] with the triple product taken from the edges. */
double air_cone_solid_angle(const air_cone *cone)
{
    double sum = 0.0, to_here[3] = {0.0, 0.0, 0.0};
    for (size_t i = 1; i + 1 < cone->count; i++) {
        const double *a = cone->vertices[0], *b = cone->vertices[i], *c = cone->vertices[i + 1];
        double normal[3];
        air_along3(to_here, 1.0, cone->edges[i - 1], to_here);
        air_cross3(to_here, cone->edges[i], normal);
        const double la = air_length3(a), lb = air_length3(b), lc = air_length3(c);
        sum += atan2(air_dot3(a, normal), la * lb * lc + air_dot3(a, b) * lc + air_dot3(b, c) * la +
                                              air_dot3(c, a) * lb);
    }
    return fabs(2.0 * sum);
}

/* The angle from a to b about the axis, both across it. */
static double angle_about(const double axis[3], const air_edge_place *a, const air_edge_place *b)
{
    double from[3], way[3], normal[3];
    for (int i = 0; i < 3; i++) {
        from[i] = a->vertex[i] + a->way[i];
        way[i] = (b->vertex[i] - a->vertex[i]) + (b->way[i] - a->way[i]);
    }
    air_cross3(from, way, normal);
    return atan2(air_dot3(axis, normal), air_dot3(from, from) + air_dot3(from, way));
}

void air_horizon_pass(air_horizon *self, const double axis[3], const double vertex[3],
                      const double edge[3], double share, bool upwards)
{
    air_edge_place place;
    for (int i = 0; i < 3; i++) {
        place.vertex[i] = vertex[i];
        place.way[i] = share * edge[i];
    }
    if (!upwards) {
        self->last_down = place;
        self->is_below = true;
    } else if (self->is_below) {
        self->angle += angle_about(axis, &self->last_down, &place);
        self->is_below = false;
    } else {
        self->first_up = place;
        self->starts_below = true;
    }
}

double air_horizon_angle(air_horizon *self, const double axis[3])
{
    if (self->starts_below && self->is_below) {
        self->angle += angle_about(axis, &self->last_down, &self->first_up);
        self->starts_below = self->is_below = false;
    }
    return self->angle;
}

/* Lambert's sum over the edges, angle times the cosine of the edge's normal [KT2025, eq. 21 and
 * erratum E6], divided by 2 pi. Arcs along the horizon have the axis for a normal. */
double air_cone_irradiance(const air_cone *cone, const double axis[3])
{
    double sum = 0.0;
    air_horizon horizon = {.angle = 0.0};
    for (size_t i = 0; i < cone->count; i++) {
        const double *a = cone->vertices[i], *b = cone->vertices[i + 1 < cone->count ? i + 1 : 0];
        const double up_a = air_dot3(axis, a), up_b = air_dot3(axis, b);
        double normal[3], from[3] = {a[0], a[1], a[2]}, to[3] = {b[0], b[1], b[2]}, part = 1.0;
        if (!(up_a > 0.0) && !(up_b > 0.0)) {
            continue;
        }
        if (!(up_a > 0.0) || !(up_b > 0.0)) {
            const double share = air_horizon_share(up_a, up_b);
            const bool upwards = up_b > 0.0;
            double *const end = upwards ? from : to;
            air_along3(a, share, cone->edges[i], end);
            air_horizon_pass(&horizon, axis, a, cone->edges[i], share, upwards);
            part = upwards ? 1.0 - share : share;
        }
        air_cross3(a, cone->edges[i], normal);
        const double length = air_length3(normal);
        if (length > 0.0) {
            sum += air_dot3(axis, normal) / length * atan2(part * length, air_dot3(from, to));
        }
    }
    sum += air_horizon_angle(&horizon, axis);
    const double irradiance = fabs(sum) / (2.0 * AIR_PI);
    return irradiance < 1.0 ? irradiance : 1.0;
}

double air_area_solid_angle(const double (*polygon)[3], size_t count)
{
    air_cone cone;
    return air_cone_make(polygon, count, &cone) ? air_cone_solid_angle(&cone) : 0.0;
}

double air_area_irradiance(const double (*polygon)[3], size_t count, const double normal[3])
{
    air_cone cone;
    return air_cone_make(polygon, count, &cone) ? air_cone_irradiance(&cone, normal) : 0.0;
}

/* The squared distance from the origin to a + s way, s in [0, 1]. */
static double segment_square(const double a[3], const double way[3])
{
    const double square = air_dot3(way, way), s = -air_dot3(a, way);
    double nearest[3];
    air_along3(a, s <= 0.0 ? 0.0 : (s < square ? s / square : 1.0), way, nearest);
    return air_dot3(nearest, nearest);
}

/* The origin's foot on the plane if it is inside of every edge, else the nearest edge's point. */
double air_area_min_distance(const double (*polygon)[3], size_t count)
{
    air_cone cone;
    double normal[3], least = INFINITY;
    if (!air_cone_make(polygon, count, &cone)) {
        return 0.0;
    }
    air_cone_normal(&cone, normal);
    const double length = air_length3(normal);
    bool inside = length > 0.0;
    for (size_t i = 0; i < count; i++) {
        double outwards[3];
        const double square = segment_square(cone.vertices[i], cone.edges[i]);
        air_cross3(cone.vertices[i], cone.edges[i], outwards);
        inside = inside && air_dot3(normal, outwards) >= 0.0;
        least = square < least ? square : least;
    }
    return inside ? fabs(air_dot3(normal, cone.vertices[0])) / length : sqrt(least);
}

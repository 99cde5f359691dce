/* light_check.c: is a light description sound? */
#include <stdio.h>

#include "scene/lights/light_build.h"
#include "scene/lights/polygon.h"
#include "scene/subject.h"

void air_light_desc_default(air_light_desc *desc)
{
    *desc = (air_light_desc){
        .kind = AIR_LIGHT_POINT,
        .dir = {0.0f, -1.0f, 0.0f},
        .outer_cone_rad = AIR_PI_F / 4.0f,
        .fov_x_rad = AIR_PI_F / 4.0f,
        .one_sided = true,
        .camera_visible = true,
        .casts_shadow = true,
        .image = AIR_NONE,
        .to_world = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f},
    };
}

static air_status check_direction(const air_subject *subject, const float dir[3])
{
    const air_status status = air_subject_check(subject, "dir", dir, 3, -INFINITY, INFINITY);
    if (status != AIR_OK) {
        return status;
    }
    const float most = fmaxf(fabsf(dir[0]), fmaxf(fabsf(dir[1]), fabsf(dir[2])));
    if (most < 1e-18f || most > 1e18f) { /* its square would leave the range of floats */
        return air_subject_fail(
            subject, "dir is (%g, %g, %g), but must have a length between 1e-18 and 1e18",
            (double)dir[0], (double)dir[1], (double)dir[2]);
    }
    return AIR_OK;
}

static air_status check_cone(const air_subject *subject, const air_light_desc *desc)
{
    const air_status status =
        air_subject_check_enum(subject, "falloff", (int)desc->falloff, AIR_SPOT_ANGLE + 1);
    const float inner = desc->inner_cone_rad, outer = desc->outer_cone_rad;
    if (status != AIR_OK) {
        return status;
    }
    if (inner >= 0.0f && inner < outer && outer <= 0.5f * AIR_PI_F) {
        return AIR_OK;
    }
    return air_subject_fail(
        subject,
        "inner_cone_rad is %g and outer_cone_rad %g, but 0 <= inner < outer <= pi/2 must hold",
        (double)inner, (double)outer);
}

static air_status check_fov(const air_subject *subject, const air_light_desc *desc)
{
    if (desc->fov_x_rad > 0.0f && desc->fov_x_rad < AIR_PI_F) {
        return AIR_OK;
    }
    return air_subject_fail(subject, "fov_x_rad is %g, but must be above 0 and below pi",
                            (double)desc->fov_x_rad);
}

/* ---- polygons ---- */

static air_status check_vertices(const air_subject *subject, const char *field,
                                 const float *vertices, size_t count)
{
    if (count < 3 || count > AIR_MAX_POLYGON_VERTICES) {
        return air_subject_fail(subject, "%s: there are %zu, but must be 3 to %d", field, count,
                                AIR_MAX_POLYGON_VERTICES);
    }
    if (vertices == NULL) {
        return air_subject_fail(subject, "%s must not be NULL", field);
    }
    return air_subject_check(subject, field, vertices, 3 * count, -1e15f, 1e15f);
}

static air_status fail_crossing(const air_subject *subject, const char *field, size_t edge,
                                size_t count)
{
    return air_subject_fail(
        subject,
        "%s: the edge from vertex %zu to %zu crosses another, but the polygon must be simple",
        field, edge, (edge + 1) % count);
}

/* Beyond crossing edges: triangles that do not make up the area, where edges touch and the winding
 * changes. */
static air_status check_triangles(const air_subject *subject, const air_point2 *points,
                                  size_t count)
{
    air_context *context = subject->context;
    size_t *links = air_allocate(context, 2 * count, sizeof *links);
    uint32_t(*triangles)[3] = air_allocate(context, count, sizeof *triangles);
    air_status status = AIR_OK;
    if (links == NULL || triangles == NULL) {
        status = air_fail_memory(context, "polygon light");
        goto cleanup;
    }
    const size_t triangle_count = air_polygon_triangulate(points, count, links, triangles);
    double sum = 0.0;
    for (size_t i = 0; i < triangle_count; i++) {
        const air_point2 corners[3] = {points[triangles[i][0]], points[triangles[i][1]],
                                       points[triangles[i][2]]};
        sum += air_polygon_area(corners, 3);
    }
    const double area = air_polygon_area(points, count);
    if (triangle_count == 0 || fabs(sum - area) > 1e-6 * area) {
        status = air_subject_fail(subject,
                                  "vertices: the polygon folds over itself, but must be simple");
    }
cleanup:
    air_free(context, triangles);
    air_free(context, links);
    return status;
}

static air_status check_polygon(const air_subject *subject, const float *vertices, size_t count)
{
    air_status status = check_vertices(subject, "vertices", vertices, count);
    if (status != AIR_OK) {
        return status;
    }
    const air_polygon_plane plane = air_polygon_fit(vertices, count);
    if (air_polygon_is_thin(plane.area, plane.extent, plane.magnitude)) {
        return air_subject_fail(subject, "vertices: the polygon has no area");
    }
    /* a thousandth of its size: what files with few digits may leave */
    if (plane.deviation > 1e-3 * plane.extent) {
        return air_subject_fail(subject,
                                "vertices: a vertex lies %g m off the polygon's plane, but it must "
                                "be planar within %g m",
                                plane.deviation, 1e-3 * plane.extent);
    }
    air_point2 *points = air_allocate(subject->context, count, sizeof *points);
    if (points == NULL) {
        return air_fail_memory(subject->context, "polygon light");
    }
    air_polygon_flatten(&plane, vertices, count, points);
    const size_t crossing = air_polygon_crossing(points, count);
    status = crossing < count ? fail_crossing(subject, "vertices", crossing, count)
                              : check_triangles(subject, points, count);
    air_free(subject->context, points);
    return status;
}

/* Seen along the light, a window need not be planar. */
static air_status check_window(const air_subject *subject, const air_gobo_window *window,
                               size_t index, const air_frame *frame)
{
    char field[48];
    (void)snprintf(field, sizeof field, "windows[%zu].vertices", index);
    const size_t count = window->vertex_count;
    air_status status = check_vertices(subject, field, window->vertices, count);
    if (status != AIR_OK) {
        return status;
    }
    air_point2 *points = air_allocate(subject->context, count, sizeof *points);
    if (points == NULL) {
        return air_fail_memory(subject->context, "collimated light");
    }
    const air_polygon_plane plane = air_polygon_fit(window->vertices, count);
    for (size_t i = 0; i < count; i++) {
        const air_vec3 v = vec3_load(window->vertices + 3 * i);
        points[i] = (air_point2){(double)vec3_dot(v, frame->s), (double)vec3_dot(v, frame->t)};
    }
    const size_t crossing = air_polygon_crossing(points, count);
    if (air_polygon_is_thin(fabs(air_polygon_area(points, count)), plane.extent, plane.magnitude)) {
        status =
            air_subject_fail(subject, "%s: seen along the light, the window has no area", field);
    } else if (crossing < count) {
        status = fail_crossing(subject, field, crossing, count);
    }
    air_free(subject->context, points);
    return status;
}

static air_status check_windows(const air_subject *subject, const air_light_desc *desc)
{
    if (desc->window_count > 0 && desc->windows == NULL) {
        return air_subject_fail(subject, "windows must not be NULL where window_count is %zu",
                                desc->window_count);
    }
    const air_frame frame = frame_from_normal(vec3_normalize(vec3_load(desc->dir)));
    for (size_t i = 0; i < desc->window_count; i++) {
        const air_status status = check_window(subject, &desc->windows[i], i, &frame);
        if (status != AIR_OK) {
            return status;
        }
    }
    return AIR_OK;
}

/* ---- environments ---- */

static air_status check_rotation(const air_subject *subject, const float m[9])
{
    const air_status status = air_subject_check(subject, "to_world", m, 9, -2.0f, 2.0f);
    if (status != AIR_OK) {
        return status;
    }
    const air_vec3 rows[3] = {vec3_load(m), vec3_load(m + 3), vec3_load(m + 6)};
    float worst = fabsf(vec3_dot(vec3_cross(rows[0], rows[1]), rows[2]) - 1.0f);
    for (int i = 0; i < 3; i++) {
        for (int k = i; k < 3; k++) {
            worst = fmaxf(worst, fabsf(vec3_dot(rows[i], rows[k]) - (i == k ? 1.0f : 0.0f)));
        }
    }
    if (worst > 1e-3f) {
        return air_subject_fail(
            subject, "to_world must be a rotation (orthonormal, not mirrored), but is off by %g",
            (double)worst);
    }
    return AIR_OK;
}

air_status air_light_check(air_context *context, const air_light_desc *desc)
{
    const air_subject subject = {context, "light", desc->name};
    air_status status =
        air_subject_check_enum(&subject, "kind", (int)desc->kind, AIR_LIGHT_PROJECTOR + 1);
    if (status == AIR_OK) {
        status = air_subject_check(&subject, "color", desc->color, 3, 0.0f, 1e30f);
    }
    if (status == AIR_OK && (desc->kind == AIR_LIGHT_POINT || desc->kind == AIR_LIGHT_SPOT ||
                             desc->kind == AIR_LIGHT_PROJECTOR)) {
        status = air_subject_check(&subject, "position", desc->position, 3, -1e15f, 1e15f);
    }
    if (status == AIR_OK && (desc->kind == AIR_LIGHT_SPOT || desc->kind == AIR_LIGHT_COLLIMATED)) {
        status = check_direction(&subject, desc->dir);
    }
    if (status != AIR_OK) {
        return status;
    }
    switch (desc->kind) {
    case AIR_LIGHT_POINT:
        return AIR_OK;
    case AIR_LIGHT_SPOT:
        return check_cone(&subject, desc);
    case AIR_LIGHT_COLLIMATED:
        return check_windows(&subject, desc);
    case AIR_LIGHT_POLYGON:
        return check_polygon(&subject, desc->vertices, desc->vertex_count);
    case AIR_LIGHT_ENVIRONMENT:
        return check_rotation(&subject, desc->to_world);
    case AIR_LIGHT_PROJECTOR:
        status = check_fov(&subject, desc);
        return status == AIR_OK ? check_rotation(&subject, desc->to_world) : status;
    }
    return AIR_ERROR_INTERNAL;
}

#include "core/phase.h"
#include "scene/media/boundary_topology.h"
#include "scene/media/convex.h"
#include "scene/media/media_build.h"
#include "scene/subject.h"

static air_status check_phase(const air_subject *subject, const air_phase *phase)
{
    const air_status status = air_subject_check_enum(subject, "phase.kind", (int)phase->kind, 4);
    if (status != AIR_OK) {
        return status;
    }
    if (phase->kind == AIR_PHASE_HG && !(fabsf(phase->g) < 1.0f)) {
        return air_subject_fail(subject, "phase.g is %g, but must be between -1 and 1",
                                (double)phase->g);
    }
    char buffer[64];
    const char *fault =
        phase->kind == AIR_PHASE_MIXTURE ? phase_mixture_fault(phase->mixture, buffer) : NULL;
    return fault == NULL ? AIR_OK : air_subject_fail(subject, "phase mixture: %s", fault);
}

static air_status check_coefficients(const air_subject *subject, const air_medium_desc *desc)
{
    air_status status = air_subject_check(subject, "sigma_s", desc->sigma_s, 3, 0.0f, INFINITY);
    if (status == AIR_OK) {
        status = air_subject_check(subject, "sigma_a", desc->sigma_a, 3, 0.0f, INFINITY);
    }
    if (status == AIR_OK) {
        status = air_subject_check(subject, "emission", desc->emission, 3, 0.0f, INFINITY);
    }
    return status == AIR_OK ? check_phase(subject, &desc->phase) : status;
}

static air_status check_up(const air_subject *subject, const air_density *density)
{
    const air_vec3 up = vec3_load(density->up);
    if (fabsf(vec3_length(up) - 1.0f) < 1e-3f) {
        return AIR_OK;
    }
    return air_subject_fail(subject, "density.up is (%g, %g, %g), but must have length 1",
                            (double)up.x, (double)up.y, (double)up.z);
}

/* The first layer may begin at -INFINITY, the last end at INFINITY. */
static air_status check_layers(const air_subject *subject, const air_density *density)
{
    if (density->layer_count < 1 || density->layer_count > AIR_MAX_LAYERS) {
        return air_subject_fail(subject, "density has %zu layers, but must have 1 to %d",
                                density->layer_count, AIR_MAX_LAYERS);
    }
    for (size_t i = 0; i < density->layer_count; i++) {
        const bool last = i + 1 == density->layer_count;
        const float bottom = density->layer_bottom[i];
        const float top = last ? density->layer_top : density->layer_bottom[i + 1];
        if (!(bottom < top)) {
            return air_subject_fail(
                subject,
                "layer %zu of density reaches from %g to %g, but its top must be above its bottom",
                i, (double)bottom, (double)top);
        }
    }
    return air_subject_check(subject, "density.layer_density", density->layer_density,
                             density->layer_count, 0.0f, INFINITY);
}

static air_status check_exponential(const air_subject *subject, const air_density *density)
{
    const air_status status = air_subject_check(subject, "density.base_height",
                                                &density->base_height, 1, -INFINITY, INFINITY);
    if (status != AIR_OK) {
        return status;
    }
    if (!(density->scale_height > 0.0f) || !isfinite(density->scale_height) ||
        !isfinite(1.0f / density->scale_height)) {
        return air_subject_fail(subject,
                                "density.scale_height is %g, but must be finite and above 0",
                                (double)density->scale_height);
    }
    return AIR_OK;
}

static air_status check_detail(const air_subject *subject, const air_detail *detail)
{
    const float finest = detail->scale > 0.0f ? 1.0f / detail->scale : INFINITY;
    if (detail->strength == 0.0f) {
        return AIR_OK;
    }
    if (!(detail->strength >= 0.0f && detail->strength < 1.0f)) {
        return air_subject_fail(subject,
                                "density.detail.strength is %g, but must be at least 0 and below 1",
                                (double)detail->strength);
    }
    if (!isfinite(detail->scale) || !isfinite(finest)) {
        return air_subject_fail(subject,
                                "density.detail.scale is %g, but must be finite and above 0",
                                (double)detail->scale);
    }
    if (detail->octaves < 1 || detail->octaves > AIR_MAX_OCTAVES) {
        return air_subject_fail(subject, "density.detail.octaves is %u, but must be 1 to %d",
                                (unsigned)detail->octaves, AIR_MAX_OCTAVES);
    }
    return air_subject_check_map(subject, "density.detail.to_world", detail->to_world);
}

/* Tracking through detail takes time in proportion to the way: it must have an end. */
static air_status check_detail_ends(const air_subject *subject, const air_medium_desc *desc)
{
    const air_boundary *boundary = &desc->boundary;
    air_plane planes[AIR_MAX_PLANES];
    float low[3] = {0.0f}, high[3] = {0.0f};
    bool ends = boundary->kind != AIR_BOUNDARY_UNBOUNDED;
    if (desc->density.detail.strength == 0.0f || desc->density.kind == AIR_DENSITY_GRID) {
        return AIR_OK;
    }
    if (boundary->kind == AIR_BOUNDARY_CONVEX) {
        for (size_t i = 0; i < boundary->plane_count; i++) {
            air_convex_plane(boundary->planes + 4 * i, &planes[i]);
        }
        air_convex_bounds(planes, boundary->plane_count, low, high);
    }
    for (int k = 0; k < 3; k++) {
        ends = ends && isfinite(low[k]) && isfinite(high[k]);
    }
    return ends ? AIR_OK
                : air_subject_fail(subject, "density.detail: the medium has no end, expected a "
                                            "boundary that ends everywhere, or a grid");
}

static air_status check_density(const air_subject *subject, const air_density *density)
{
    air_status status = air_subject_check_enum(subject, "density.kind", (int)density->kind, 4);
    if (status == AIR_OK) {
        status = check_detail(subject, &density->detail);
    }
    if (status != AIR_OK || density->kind == AIR_DENSITY_CONSTANT) {
        return status;
    }
    if (density->kind == AIR_DENSITY_GRID) {
        return air_subject_check_map(subject, "density.grid_to_world", density->grid_to_world);
    }
    status = check_up(subject, density);
    if (status != AIR_OK) {
        return status;
    }
    return density->kind == AIR_DENSITY_LAYERED ? check_layers(subject, density)
                                                : check_exponential(subject, density);
}

static air_status check_planes(const air_subject *subject, const air_boundary *boundary)
{
    air_plane planes[AIR_MAX_PLANES];
    float low[3], high[3];
    if (boundary->plane_count < 1 || boundary->plane_count > AIR_MAX_PLANES ||
        boundary->planes == NULL) {
        return air_subject_fail(subject, "boundary has %zu planes, but must have 1 to %d",
                                boundary->plane_count, AIR_MAX_PLANES);
    }
    for (size_t i = 0; i < boundary->plane_count; i++) {
        if (!air_convex_plane(boundary->planes + 4 * i, &planes[i])) {
            return air_subject_fail(
                subject, "plane %zu of boundary must be finite with a normal that is not 0", i);
        }
    }
    if (!air_convex_bounds(planes, boundary->plane_count, low, high)) {
        return air_subject_fail(subject, "the planes of boundary enclose nothing");
    }
    return AIR_OK;
}

static air_status check_mesh(const air_subject *subject, const air_boundary *boundary)
{
    air_topology topology;
    if (boundary->positions == NULL || boundary->indices == NULL) {
        return air_subject_fail(subject, "the boundary mesh has no positions or no indices");
    }
    const air_status status =
        air_topology_make(subject, boundary->positions, boundary->vertex_count, boundary->indices,
                          boundary->triangle_count, &topology);
    if (status == AIR_OK) {
        air_topology_finish(subject->context, &topology);
    }
    return status;
}

static air_status check_boundary(const air_subject *subject, const air_boundary *boundary)
{
    air_plane planes[6];
    air_quadric ellipsoid;
    switch (boundary->kind) {
    case AIR_BOUNDARY_UNBOUNDED:
        return AIR_OK;
    case AIR_BOUNDARY_BOX:
        return air_convex_box_planes(boundary->box_to_world, planes)
                   ? AIR_OK
                   : air_subject_fail(subject,
                                      "the box of boundary has no volume, or is not finite");
    case AIR_BOUNDARY_CONVEX:
        return check_planes(subject, boundary);
    case AIR_BOUNDARY_MESH:
        return check_mesh(subject, boundary);
    case AIR_BOUNDARY_ELLIPSOID:
        return air_quadric_make(AIR_RAY_SPHERE, boundary->box_to_world, &ellipsoid)
                   ? AIR_OK
                   : air_subject_fail(subject,
                                      "the ellipsoid of boundary has no volume, or is not finite");
    }
    return air_subject_check_enum(subject, "boundary.kind", (int)boundary->kind,
                                  AIR_BOUNDARY_ELLIPSOID + 1);
}

air_status air_medium_check(air_context *context, const air_medium_desc *desc)
{
    const air_subject subject = {context, "medium", desc->name};
    air_status status = check_coefficients(&subject, desc);
    if (status == AIR_OK) {
        status = check_density(&subject, &desc->density);
    }
    if (status == AIR_OK) {
        status = air_subject_check_enum(&subject, "combine", (int)desc->combine, 2);
    }
    if (status == AIR_OK) {
        status = check_boundary(&subject, &desc->boundary);
    }
    return status == AIR_OK ? check_detail_ends(&subject, desc) : status;
}

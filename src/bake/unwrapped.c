#include "bake/unwrapped.h"

#include <stdio.h>
#include <string.h>

#include "atlas/pack.h"
#include "atlas/triangle.h"
#include "atlas/unwrap.h"
#include "scene/mesh.h"
#include "scene/surface.h"

/* ---- the mesh's own coordinates ---- */

static double uv_area_of(const float *a, const float *b, const float *c)
{
    const double p[3][2] = {
        {(double)a[0], (double)a[1]}, {(double)b[0], (double)b[1]}, {(double)c[0], (double)c[1]}};
    return 0.5 * fabs(air_doubled_area(p[0], p[1], p[2]));
}

/* The side in texels that the unit square of the mesh's coordinates needs for the density. */
static double side_for_density(const air_mesh *mesh, double texels_per_metre)
{
    double area = 0.0, uv_area = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *at = mesh->indices + 3 * t;
        const float *uv = mesh->uv[1];
        area += air_mesh_triangle_area(mesh, t);
        uv_area +=
            uv_area_of(uv + 2 * (size_t)at[0], uv + 2 * (size_t)at[1], uv + 2 * (size_t)at[2]);
    }
    return uv_area > 0.0 ? texels_per_metre * sqrt(area / uv_area) : 0.0;
}

static double own_side(const air_mesh *mesh, const air_bake_params *params)
{
    enum { LEAST = 4 };
    const double most = (double)params->page_size;
    const double side = params->mesh_size > 0
                            ? (double)params->mesh_size
                            : ceil(side_for_density(mesh, (double)params->texels_per_metre));
    return side < LEAST ? LEAST : side > most ? most : side;
}

/* So much of what a mesh covers may overlap before its coordinates are not meant for lightmaps. */
#define OVERLAP_SHARE 0.1

/* What makes the mesh's own coordinates useless for a lightmap, as a sentence; "" if nothing does.
 * Overlaps of some texels are said, and mix the light of what lies there. */
static air_status check_own(air_context *context, const air_mesh *mesh, double side,
                            char problem[256])
{
    const air_atlas_part part = {.positions = mesh->positions,
                                 .uv = mesh->uv[1],
                                 .indices = mesh->indices,
                                 .vertex_count = mesh->vertex_count,
                                 .triangle_count = mesh->triangle_count,
                                 .size = {side, side}};
    const size_t texels = (size_t)ceil(side);
    air_coverage *coverage = NULL;
    air_coverage_report report;
    air_coverage_overlap overlap = {.texel_count = 0};
    problem[0] = '\0';
    air_status status = air_coverage_create(context, texels, texels, &part, 1, &coverage, &report);
    if (status == AIR_OK) {
        status = air_coverage_find_overlap(context, coverage, &overlap);
    }
    if (status == AIR_OK && report.covered_texels == 0) {
        snprintf(problem, 256, "no triangle has an area in TEXCOORD_1");
    } else if (status == AIR_OK && report.outside_count > 0) {
        snprintf(problem, 256,
                 "TEXCOORD_1 of %zu triangles lie outside [0, 1], first triangle %u at (%g, %g)",
                 report.outside_count, report.first_outside, (double)report.outside_uv[0],
                 (double)report.outside_uv[1]);
    } else if (status == AIR_OK && overlap.texel_count > 0) {
        snprintf(problem, 256,
                 "TEXCOORD_1 overlap in %zu texels of %zu x %zu, first texel (%u, %u), triangles "
                 "%u and %u",
                 overlap.texel_count, texels, texels, overlap.texel[0], overlap.texel[1],
                 overlap.triangle[0], overlap.triangle[1]);
    }
    if (status == AIR_OK && overlap.texel_count > 0 && report.outside_count == 0 &&
        (double)overlap.texel_count <= OVERLAP_SHARE * (double)report.covered_texels) {
        air_warn(context, "bake: mesh \"%s\": %s", mesh->name, problem);
        problem[0] = '\0';
    }
    air_coverage_destroy(context, coverage);
    return status;
}

/* ---- new coordinates ---- */

/* Packs the charts of a mesh into one rectangle and writes its vertices. */
static air_status place_charts(air_context *context, const air_unwrap *unwrap,
                               const air_bake_params *params, air_lightmap_mesh *out,
                               air_mesh_rectangle *rectangle)
{
    air_pack_params packing;
    air_pack *pack = NULL;
    air_pack_item *items = air_allocate(context, unwrap->chart_count, sizeof *items);
    uint8_t *placed = air_allocate(context, unwrap->vertex_count, 1);
    air_status status =
        items == NULL || placed == NULL ? air_fail_memory(context, "charts") : AIR_OK;
    air_pack_params_default(&packing);
    packing.padding = air_half_padding(params);
    packing.max_size = params->page_size;
    packing.max_pages = 1;
    packing.power_of_two = false;
    packing.scale_to_fit = true;
    for (size_t i = 0; i < unwrap->chart_count && status == AIR_OK; i++) {
        items[i] = (air_pack_item){
            .size = {(double)unwrap->charts[i].texels[0], (double)unwrap->charts[i].texels[1]}};
    }
    if (status == AIR_OK) {
        status = air_pack_create(context, items, unwrap->chart_count, &packing, &pack);
    }
    if (status == AIR_OK) {
        rectangle->width = (double)pack->pages[0].width;
        rectangle->height = (double)pack->pages[0].height;
        if (pack->scale < 1.0) {
            air_warn(context,
                     "bake: mesh \"%s\" does not fit a page of %u texels at the density asked for: "
                     "it gets %.3g of it along each side",
                     out->name, params->page_size, pack->scale);
        }
    }
    for (size_t i = 0; i < 3 * unwrap->triangle_count && status == AIR_OK; i++) {
        const uint32_t v = unwrap->indices[i], chart = unwrap->triangle_charts[i / 3];
        const double at[2] = {(double)unwrap->places[2 * v], (double)unwrap->places[2 * v + 1]};
        double on_page[2];
        if (placed[v]) {
            continue;
        }
        placed[v] = 1;
        air_pack_point(pack, chart, at, on_page);
        out->uv[2 * v] = (float)(on_page[0] / rectangle->width);
        out->uv[2 * v + 1] = (float)(on_page[1] / rectangle->height);
    }
    air_pack_destroy(context, pack);
    air_free(context, items);
    air_free(context, placed);
    return status;
}

static air_status copy_cut(air_context *context, const air_unwrap *unwrap, air_lightmap_mesh *out)
{
    out->vertex_count = unwrap->vertex_count;
    out->triangle_count = unwrap->triangle_count;
    out->sources = air_allocate(context, unwrap->vertex_count, sizeof *out->sources);
    out->uv = air_allocate(context, unwrap->vertex_count, 2 * sizeof *out->uv);
    out->indices = air_allocate(context, unwrap->triangle_count, 3 * sizeof *out->indices);
    if (out->sources == NULL || out->uv == NULL || out->indices == NULL) {
        return air_fail_memory(context, out->name);
    }
    memcpy(out->sources, unwrap->vertices, unwrap->vertex_count * sizeof *out->sources);
    memcpy(out->indices, unwrap->indices, unwrap->triangle_count * 3 * sizeof *out->indices);
    return AIR_OK;
}

static air_status cut(air_context *context, const air_mesh *mesh, const air_bake_params *params,
                      air_lightmap_mesh *out, air_mesh_rectangle *rectangle)
{
    air_unwrap_params unwrapping;
    air_unwrap *unwrap = NULL;
    air_unwrap_params_default(&unwrapping);
    unwrapping.texels_per_metre = (double)params->texels_per_metre;
    unwrapping.angle_rad = (double)params->chart_angle_rad;
    air_status status =
        air_unwrap_create(context, mesh->positions, mesh->vertex_count, mesh->indices,
                          mesh->triangle_count, &unwrapping, &unwrap);
    if (status == AIR_OK) {
        status = copy_cut(context, unwrap, out);
    }
    if (status == AIR_OK) {
        status = place_charts(context, unwrap, params, out, rectangle);
    }
    air_unwrap_destroy(context, unwrap);
    return status;
}

/* ---- the choice ---- */

air_status air_mesh_coordinates(air_context *context, const air_snapshot *snapshot, size_t index,
                                const air_bake_params *params, air_lightmap_mesh *out,
                                air_mesh_rectangle *rectangle)
{
    const air_mesh *mesh = snapshot->meshes[index];
    const bool wanted = params->uv != AIR_BAKE_UV_UNWRAP;
    char problem[256] = "it has no TEXCOORD_1";
    *rectangle = (air_mesh_rectangle){0.0, 0.0};
    out->mesh = (uint32_t)index;
    out->node = mesh->node;
    out->primitive = mesh->primitive;
    out->page = -1;
    out->scale[0] = out->scale[1] = 1.0f;
    out->name = air_string_copy(context, mesh->name);
    if (out->name == NULL) {
        return air_fail_memory(context, mesh->name);
    }
    if (mesh->quadric != NULL) {
        air_warn(context,
                 "bake: mesh %zu \"%s\" is a %s, not triangles: it gets no lightmap, but takes "
                 "part in the light of the others",
                 index, mesh->name, air_shape_names[mesh->quadric->shape]);
        return AIR_OK;
    }
    const air_material *material = &snapshot->materials[mesh->material];
    if (material->unlit || material->model == AIR_MATERIAL_NULL || mesh->triangle_count == 0) {
        return AIR_OK;
    }
    if (wanted && mesh->uv[1] != NULL) {
        const double side = own_side(mesh, params);
        const air_status status = check_own(context, mesh, side, problem);
        if (status != AIR_OK) {
            return status;
        }
        if (problem[0] == '\0') {
            *rectangle = (air_mesh_rectangle){side, side};
            return AIR_OK;
        }
    }
    if (params->uv == AIR_BAKE_UV_FILE) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "bake: mesh %zu \"%s\": %s", index, mesh->name,
                        problem);
    }
    if (wanted && mesh->uv[1] != NULL) {
        air_warn(context, "bake: mesh %zu \"%s\": %s: it is unwrapped instead", index, mesh->name,
                 problem);
    }
    return cut(context, mesh, params, out, rectangle);
}

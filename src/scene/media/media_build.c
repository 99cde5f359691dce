#include "scene/media/media_build.h"

#include <string.h>

#include "core/phase.h"
#include "scene/media/boundary_topology.h"
#include "scene/media/convex.h"
#include "scene/subject.h"

/* Media under construction. */
typedef struct media_builder {
    air_context *context;
    air_media media;
    air_topology *meshes; /* one per boundary mesh */
} media_builder;

static void add_plane(air_region *region, air_vec3 n, float h)
{
    region->planes[region->plane_count++] = (air_plane){n, h};
    region->kind = region->kind == AIR_REGION_EVERYWHERE ? AIR_REGION_CONVEX : region->kind;
}

static void unbounded(float low[3], float high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = -INFINITY;
        high[k] = INFINITY;
    }
}

static void set_convex(air_region *region, const air_plane *planes, size_t count)
{
    region->kind = AIR_REGION_CONVEX;
    region->plane_count = count;
    memcpy(region->planes, planes, count * sizeof *planes);
}

static void mesh_bounds(const air_topology *mesh, float low[3], float high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        low[i % 3] = fminf(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], mesh->positions[i]);
    }
}

/* A mesh becomes planes where it is convex and has few; else it goes to the accelerator. */
static air_status build_mesh(media_builder *builder, const air_subject *subject,
                             const air_boundary *boundary, air_medium *medium, air_region *region)
{
    air_topology mesh;
    air_plane planes[AIR_MAX_PLANES];
    size_t plane_count = 0;
    air_status status = air_topology_make(subject, boundary->positions, boundary->vertex_count,
                                          boundary->indices, boundary->triangle_count, &mesh);
    if (status != AIR_OK) {
        return status;
    }
    mesh_bounds(&mesh, medium->bounds_min, medium->bounds_max);
    status = air_topology_convex_planes(builder->context, &mesh, planes, &plane_count);
    if (status != AIR_OK || plane_count > 0) {
        air_topology_finish(builder->context, &mesh);
        set_convex(region, planes, plane_count);
        medium->boundary =
            air_convex_is_box(planes, plane_count) ? AIR_BOUNDARY_BOX : AIR_BOUNDARY_CONVEX;
        return status;
    }
    medium->boundary = AIR_BOUNDARY_MESH;
    region->kind = AIR_REGION_MESH;
    region->mesh = (uint32_t)builder->media.boundary_mesh_count;
    builder->meshes[builder->media.boundary_mesh_count++] = mesh;
    return AIR_OK;
}

static air_status build_boundary(media_builder *builder, const air_subject *subject,
                                 const air_boundary *boundary, air_medium *medium,
                                 air_region *region)
{
    medium->boundary = boundary->kind;
    region->kind = AIR_REGION_EVERYWHERE;
    unbounded(medium->bounds_min, medium->bounds_max);
    switch (boundary->kind) {
    case AIR_BOUNDARY_UNBOUNDED:
        break;
    case AIR_BOUNDARY_BOX:
        region->kind = AIR_REGION_CONVEX;
        region->plane_count = 6;
        air_convex_box_planes(boundary->box_to_world, region->planes);
        air_convex_box_bounds(boundary->box_to_world, medium->bounds_min, medium->bounds_max);
        break;
    case AIR_BOUNDARY_CONVEX:
        region->kind = AIR_REGION_CONVEX;
        region->plane_count = boundary->plane_count;
        for (size_t i = 0; i < boundary->plane_count; i++) {
            air_convex_plane(boundary->planes + 4 * i, &region->planes[i]);
        }
        air_convex_bounds(region->planes, region->plane_count, medium->bounds_min,
                          medium->bounds_max);
        break;
    case AIR_BOUNDARY_MESH:
        return build_mesh(builder, subject, boundary, medium, region);
    case AIR_BOUNDARY_ELLIPSOID:
        region->kind = AIR_REGION_ELLIPSOID;
        (void)air_quadric_make(AIR_RAY_SPHERE, boundary->box_to_world, &region->ellipsoid);
        air_quadric_bounds(&region->ellipsoid, medium->bounds_min, medium->bounds_max);
        break;
    }
    return AIR_OK;
}

/* The map from the world to the index space of a grid. */
static air_status grid_map(const air_subject *subject, const air_density *density,
                           const air_grid *grid, float out[12])
{
    float index_to_world[12];
    affine_multiply(density->grid_to_world, air_grid_index_to_local(grid), index_to_world);
    if (!affine_invert(index_to_world, out)) {
        return air_subject_fail(
            subject, "density.grid_to_world together with the map of its grid is singular");
    }
    return AIR_OK;
}

/* Nothing is outside the density grid's box: where there is room for its planes, the region is cut
 * down to it. A medium that replaces others does so in all of its boundary, though. */
static void clip_to_grid(const air_density *density, const air_grid *grid, air_medium *medium,
                         air_region *region)
{
    size_t size[3];
    float box_to_index[12] = {0.0f}, box_to_world[12], low[3], high[3];
    air_plane planes[6];
    air_grid_size(grid, size);
    for (int k = 0; k < 3; k++) {
        box_to_index[5 * k] = 0.5f * (float)size[k];
        box_to_index[4 * k + 3] = 0.5f * (float)(size[k] - 1);
    }
    affine_multiply(air_grid_index_to_local(grid), box_to_index, box_to_world);
    affine_multiply(density->grid_to_world, box_to_world, box_to_world);
    if (medium->combine == AIR_COMBINE_REPLACE && medium->boundary != AIR_BOUNDARY_UNBOUNDED) {
        return;
    }
    if (region->plane_count + 6 > AIR_MAX_PLANES || !air_convex_box_planes(box_to_world, planes)) {
        return;
    }
    for (int i = 0; i < 6; i++) {
        add_plane(region, planes[i].n, planes[i].h);
    }
    air_convex_box_bounds(box_to_world, low, high);
    for (int k = 0; k < 3; k++) {
        medium->bounds_min[k] = fmaxf(medium->bounds_min[k], low[k]);
        medium->bounds_max[k] = fminf(medium->bounds_max[k], high[k]);
    }
}

static air_status build_grids(const air_subject *subject, const air_medium_source *source,
                              air_medium *medium, air_region *region)
{
    const air_density *density = &source->desc->density;
    if (source->density_grid == NULL) {
        return air_subject_fail(subject, "density.grid names no grid");
    }
    medium->density_grid = source->density_grid;
    medium->albedo_grid = source->albedo_grid;
    medium->emission_grid = source->emission_grid;
    air_status status = grid_map(subject, density, source->density_grid, medium->world_to_grid);
    if (status == AIR_OK && source->albedo_grid != NULL) {
        status = grid_map(subject, density, source->albedo_grid, medium->world_to_albedo);
        medium->sigma_s = medium->sigma_t; /* what scattering can reach at density 1 */
    }
    if (status == AIR_OK && source->emission_grid != NULL) {
        status = grid_map(subject, density, source->emission_grid, medium->world_to_emission);
    }
    if (status == AIR_OK && !(air_grid_max(source->density_grid) > 0.0f)) {
        /* No error: a sequence of smoke may begin without any. */
        air_warn(subject->context,
                 "medium \"%s\": no value of its density grid is above 0: it is empty",
                 subject->name);
    }
    if (status == AIR_OK) {
        clip_to_grid(density, source->density_grid, medium, region);
    }
    return status;
}

static air_status add_region(media_builder *builder, const air_subject *subject,
                             const air_region *region)
{
    air_media *media = &builder->media;
    if (media->region_count == AIR_MAX_REGIONS) {
        return air_subject_fail(
            subject, "with it the scene has more than %d regions of media (layers count one each)",
            AIR_MAX_REGIONS);
    }
    media->regions[media->region_count++] = *region;
    return AIR_OK;
}

/* One region per layer; those that neither hold anything nor replace anything are left out. */
static air_status add_layers(media_builder *builder, const air_subject *subject,
                             const air_medium *medium, const air_density *density,
                             const air_region *base)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < density->layer_count && status == AIR_OK; i++) {
        const float top =
            i + 1 < density->layer_count ? density->layer_bottom[i + 1] : density->layer_top;
        air_region region = *base;
        if (density->layer_density[i] == 0.0f && medium->combine == AIR_COMBINE_ADD) {
            continue;
        }
        region.density = density->layer_density[i];
        if (isfinite(density->layer_bottom[i])) {
            add_plane(&region, vec3_neg(medium->up), -density->layer_bottom[i]);
        }
        if (isfinite(top)) {
            add_plane(&region, medium->up, top);
        }
        status = add_region(builder, subject, &region);
    }
    return status;
}

static void set_coefficients(air_medium *medium, const air_medium_desc *desc, air_cpu cpu)
{
    const air_density *density = &desc->density;
    medium->sigma_s = vec3_load(desc->sigma_s);
    medium->sigma_a = vec3_load(desc->sigma_a);
    medium->sigma_t = vec3_add(medium->sigma_s, medium->sigma_a);
    medium->emission = vec3_load(desc->emission);
    medium->phase = phase_prepare(desc->phase, &medium->mixture);
    medium->declared_kind = density->kind;
    medium->kind = density->kind == AIR_DENSITY_LAYERED ? AIR_DENSITY_CONSTANT : density->kind;
    medium->combine = desc->combine;
    medium->priority = desc->priority;
    if (density->detail.strength > 0.0f) {
        air_detail_make(&density->detail, cpu, &medium->detail);
    }
    if (density->kind == AIR_DENSITY_LAYERED || density->kind == AIR_DENSITY_EXPONENTIAL) {
        medium->up = vec3_normalize(vec3_load(density->up));
    }
    if (density->kind == AIR_DENSITY_EXPONENTIAL) {
        medium->base_height = density->base_height;
        medium->inverse_scale_height = 1.0f / density->scale_height;
    }
}

static air_status build_medium(media_builder *builder, const air_medium_source *source)
{
    const air_medium_desc *desc = source->desc;
    const air_subject subject = {builder->context, "medium", desc->name};
    air_media *media = &builder->media;
    air_medium *medium = &media->media[media->count];
    air_region region = {.medium = (uint32_t)media->count, .density = 1.0f};
    medium->name = air_string_copy(builder->context, desc->name);
    if (medium->name == NULL) {
        return air_fail_memory(builder->context, "medium");
    }
    media->count++;
    set_coefficients(medium, desc, air_context_cpu(builder->context));
    air_status status = build_boundary(builder, &subject, &desc->boundary, medium, &region);
    if (status == AIR_OK && desc->density.kind == AIR_DENSITY_GRID) {
        status = build_grids(&subject, source, medium, &region);
    }
    if (status != AIR_OK) {
        return status;
    }
    media->any_replace = media->any_replace || medium->combine == AIR_COMBINE_REPLACE;
    media->all_constant = media->all_constant && air_medium_is_constant(medium);
    if (desc->density.kind == AIR_DENSITY_LAYERED) {
        return add_layers(builder, &subject, medium, &desc->density, &region);
    }
    return add_region(builder, &subject, &region);
}

/* Hands the meshes over to the media and builds their accelerator. */
static air_status build_accelerator(media_builder *builder)
{
    air_media *media = &builder->media;
    const size_t count = media->boundary_mesh_count;
    if (count == 0) {
        return AIR_OK;
    }
    media->boundary_meshes = air_allocate(builder->context, count, sizeof *media->boundary_meshes);
    if (media->boundary_meshes == NULL) {
        return air_fail_memory(builder->context, "media");
    }
    for (size_t i = 0; i < count; i++) {
        air_topology *mesh = &builder->meshes[i];
        media->boundary_meshes[i] = (air_ray_mesh){.positions = mesh->positions,
                                                   .vertex_count = mesh->vertex_count,
                                                   .indices = mesh->indices,
                                                   .triangle_count = mesh->triangle_count,
                                                   .mask = UINT32_MAX};
        *mesh = (air_topology){0};
    }
    return media->backend->build(media->backend->user, builder->context, media->boundary_meshes,
                                 count, &media->boundary_accelerator);
}

air_status air_media_build(air_context *context, const air_medium_source *sources, size_t count,
                           air_media *out)
{
    media_builder builder = {.context = context};
    air_media *media = &builder.media;
    air_status status = AIR_OK;
    if (count > AIR_MAX_MEDIA) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "the scene has %zu media, but at most %d are possible", count,
                        AIR_MAX_MEDIA);
    }
    media->backend = air_context_ray_backend(context);
    media->all_constant = true;
    media->media = air_allocate(context, count, sizeof *media->media);
    media->regions = air_allocate(context, AIR_MAX_REGIONS, sizeof *media->regions);
    builder.meshes = air_allocate(context, count, sizeof *builder.meshes);
    if (media->media == NULL || media->regions == NULL || builder.meshes == NULL) {
        status = air_fail_memory(context, "media");
    }
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        status = build_medium(&builder, &sources[i]);
    }
    if (status == AIR_OK) {
        status = build_accelerator(&builder);
    }
    for (size_t i = 0; builder.meshes != NULL && i < count; i++) {
        air_topology_finish(context, &builder.meshes[i]);
    }
    air_free(context, builder.meshes);
    if (status != AIR_OK) {
        air_media_finish(context, media);
        return status;
    }
    air_media_prepare(media);
    *out = *media;
    return AIR_OK;
}

void air_media_finish(air_context *context, air_media *media)
{
    if (media->boundary_accelerator != NULL) {
        media->backend->destroy(media->boundary_accelerator);
    }
    for (size_t i = 0; media->boundary_meshes != NULL && i < media->boundary_mesh_count; i++) {
        air_free(context, (void *)media->boundary_meshes[i].indices);
        air_free(context, (void *)media->boundary_meshes[i].positions);
    }
    air_free(context, media->boundary_meshes);
    air_free(context, media->regions);
    for (size_t i = 0; i < media->count; i++) {
        air_free(context, media->media[i].name);
    }
    air_free(context, media->media);
    *media = (air_media){0};
}

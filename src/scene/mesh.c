#include "scene/mesh.h"

#include <string.h>

#include "scene/subject.h"

static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

void air_mesh_desc_default(air_mesh_desc *desc)
{
    *desc = (air_mesh_desc){.material = AIR_NONE,
                            .camera_visible = true,
                            .casts_shadow = true,
                            .node = -1,
                            .primitive = -1};
    memcpy(desc->to_world, identity, sizeof identity);
}

const char *const air_shape_names[AIR_SHAPES] = {"triangles", "sphere", "cylinder", "disk"};

/* ---- checking ---- */

static air_status check_attribute(const air_subject *subject, const char *field,
                                  const float *values, size_t vertex_count, size_t width)
{
    if (values == NULL)
        return AIR_OK;
    for (size_t i = 0; i < vertex_count * width; ++i) {
        if (!isfinite(values[i]))
            return air_subject_fail(subject, "%s of vertex %zu is %g, but must be finite", field,
                                    i / width, (double)values[i]);
    }
    return AIR_OK;
}

static air_status check_indices(const air_subject *subject, const air_mesh_desc *desc)
{
    for (size_t i = 0; i < 3 * desc->triangle_count; ++i) {
        if (desc->indices[i] >= desc->vertex_count)
            return air_subject_fail(subject,
                                    "index %zu of triangle %zu is %u, but there are %zu vertices",
                                    i % 3, i / 3, desc->indices[i], desc->vertex_count);
    }
    return AIR_OK;
}

static air_status check_quadric(const air_subject *subject, const air_mesh_desc *desc)
{
    if (desc->vertex_count > 0 || desc->triangle_count > 0)
        return air_subject_fail(subject,
                                "is a %s and has %zu vertices and %zu triangles, but must have "
                                "none of either",
                                air_shape_names[desc->shape], desc->vertex_count,
                                desc->triangle_count);
    return air_subject_check_map(subject, "to_world", desc->to_world);
}

static air_status check_mesh(air_context *context, const air_mesh_desc *desc)
{
    const air_subject subject = {context, "mesh", desc->name};
    const air_status known =
        air_subject_check_enum(&subject, "shape", (int)desc->shape, AIR_SHAPES);
    if (known != AIR_OK || desc->shape != AIR_SHAPE_TRIANGLES)
        return known != AIR_OK ? known : check_quadric(&subject, desc);
    const struct {
        const char *field;
        const float *values;
        size_t width;
    } attributes[] = {{"position", desc->positions, 3}, {"normal", desc->normals, 3},
                      {"tangent", desc->tangents, 4},   {"uv[0]", desc->uv[0], 2},
                      {"uv[1]", desc->uv[1], 2},        {"color", desc->colors, 4}};
    if (desc->positions == NULL || desc->vertex_count == 0)
        return air_subject_fail(&subject, "has no positions");
    if (desc->indices == NULL || desc->triangle_count == 0)
        return air_subject_fail(&subject, "has no triangles");
    if (desc->vertex_count > UINT32_MAX || desc->triangle_count > UINT32_MAX)
        return air_subject_fail(&subject,
                                "has %zu vertices and %zu triangles, but at most %u are possible",
                                desc->vertex_count, desc->triangle_count, UINT32_MAX);
    air_status status = air_subject_check_map(&subject, "to_world", desc->to_world);
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes && status == AIR_OK; ++i)
        status = check_attribute(&subject, attributes[i].field, attributes[i].values,
                                 desc->vertex_count, attributes[i].width);
    return status == AIR_OK ? check_indices(&subject, desc) : status;
}

/* ---- arrays ---- */

static void destroy_geometry(air_record *record)
{
    air_geometry *geometry = (air_geometry *)record;
    air_context *context = record->context;
    air_free(context, geometry->indices);
    air_free(context, geometry->colors);
    air_free(context, geometry->uv[1]);
    air_free(context, geometry->uv[0]);
    air_free(context, geometry->tangents);
    air_free(context, geometry->normals);
    air_free(context, geometry->positions);
}

/* Room for the positions of n vertices and one more float, which the ray backend may read. */
static float *allocate_positions(air_context *context, size_t n)
{
    return air_allocate(context, 3 * n + 1, sizeof(float));
}

static air_status create_geometry(air_context *context, const air_mesh_desc *desc,
                                  air_geometry **out_geometry)
{
    air_geometry *geometry = air_record_create(context, sizeof *geometry, destroy_geometry, NULL);
    if (geometry == NULL)
        return AIR_ERROR_MEMORY;
    const size_t n = desc->vertex_count;
    bool ok = true;
    geometry->shape = desc->shape;
    geometry->vertex_count = n;
    geometry->triangle_count = desc->triangle_count;
    geometry->positions = allocate_positions(context, n);
    geometry->normals = air_record_copy(context, desc->normals, n, 3 * sizeof(float), &ok);
    geometry->tangents = air_record_copy(context, desc->tangents, n, 4 * sizeof(float), &ok);
    geometry->uv[0] = air_record_copy(context, desc->uv[0], n, 2 * sizeof(float), &ok);
    geometry->uv[1] = air_record_copy(context, desc->uv[1], n, 2 * sizeof(float), &ok);
    geometry->colors = air_record_copy(context, desc->colors, n, 4 * sizeof(float), &ok);
    geometry->indices =
        air_record_copy(context, desc->indices, desc->triangle_count, 3 * sizeof(uint32_t), &ok);
    if (!ok || geometry->positions == NULL) {
        air_record_release(&geometry->base);
        return air_fail_memory(context, "mesh");
    }
    if (n > 0)
        memcpy(geometry->positions, desc->positions, n * 3 * sizeof(float));
    *out_geometry = geometry;
    return AIR_OK;
}

/* The arrays of a geometry as a description, to be compared with one. */
static air_mesh_desc geometry_desc(const air_geometry *geometry)
{
    return (air_mesh_desc){.shape = geometry->shape,
                           .positions = geometry->positions,
                           .normals = geometry->normals,
                           .tangents = geometry->tangents,
                           .uv = {geometry->uv[0], geometry->uv[1]},
                           .colors = geometry->colors,
                           .vertex_count = geometry->vertex_count,
                           .indices = geometry->indices,
                           .triangle_count = geometry->triangle_count};
}

static bool arrays_equal(const air_mesh_desc *a, const air_mesh_desc *b)
{
    const size_t row = a->vertex_count * sizeof(float);
    if (a->shape != b->shape)
        return false;
    if (a->shape != AIR_SHAPE_TRIANGLES)
        return true;
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           air_bytes_equal(a->positions, b->positions, 3 * row) &&
           air_bytes_equal(a->normals, b->normals, 3 * row) &&
           air_bytes_equal(a->tangents, b->tangents, 4 * row) &&
           air_bytes_equal(a->uv[0], b->uv[0], 2 * row) &&
           air_bytes_equal(a->uv[1], b->uv[1], 2 * row) &&
           air_bytes_equal(a->colors, b->colors, 4 * row) &&
           air_bytes_equal(a->indices, b->indices, 3 * a->triangle_count * sizeof(uint32_t));
}

bool air_geometry_equal(const air_geometry *a, const air_geometry *b)
{
    const air_mesh_desc desc_a = geometry_desc(a), desc_b = geometry_desc(b);
    return a == b || arrays_equal(&desc_a, &desc_b);
}

bool air_mesh_place_equal(const air_mesh_record *a, const air_mesh_record *b)
{
    return air_bytes_equal(a->to_world, b->to_world, sizeof a->to_world);
}

/* ---- records ---- */

static void destroy_mesh(air_record *record)
{
    air_mesh_record *mesh = (air_mesh_record *)record;
    if (mesh->world != NULL)
        air_record_release(&mesh->world->base);
    if (mesh->geometry != NULL)
        air_record_release(&mesh->geometry->base);
}

/* Takes the arrays, and the placed arrays, from `previous` where they are the same. */
static void share_with_previous(const air_mesh_desc *desc, const air_mesh_record *previous,
                                air_mesh_record *record)
{
    const air_mesh_desc arrays = geometry_desc(previous->geometry);
    if (!arrays_equal(desc, &arrays))
        return;
    air_record_retain(&previous->geometry->base);
    record->geometry = previous->geometry;
    if (previous->world != NULL && air_mesh_place_equal(record, previous)) {
        air_record_retain(&previous->world->base);
        record->world = previous->world;
    }
}

air_status air_mesh_record_create(air_context *context, const air_mesh_desc *desc,
                                  const air_mesh_record *previous, air_record **out_record)
{
    air_status status = check_mesh(context, desc);
    if (status != AIR_OK)
        return status;
    air_mesh_record *record = air_record_create(context, sizeof *record, destroy_mesh, desc->name);
    if (record == NULL)
        return AIR_ERROR_MEMORY;
    memcpy(record->to_world, desc->to_world, sizeof record->to_world);
    record->material = desc->material;
    record->camera_visible = desc->camera_visible;
    record->node = desc->node;
    record->primitive = desc->primitive;
    record->casts_shadow = desc->casts_shadow;
    record->flip_normals = desc->flip_normals;
    if (previous != NULL)
        share_with_previous(desc, previous, record);
    if (record->geometry == NULL)
        status = create_geometry(context, desc, &record->geometry);
    if (status != AIR_OK) {
        air_record_release(&record->base);
        return status;
    }
    *out_record = &record->base;
    return AIR_OK;
}

/* ---- placing ---- */

static void destroy_world_mesh(air_record *record)
{
    air_world_mesh *world = (air_world_mesh *)record;
    if (!world->borrowed) {
        air_free(record->context, world->tangents);
        air_free(record->context, world->normals);
        air_free(record->context, world->positions);
    }
    if (world->geometry != NULL)
        air_record_release(&world->geometry->base);
}

static air_vec3 unit_or_zero(air_vec3 v)
{
    /* lengths are taken in double, so that tiny and huge scales neither vanish nor overflow */
    const double length = sqrt((double)v.x * v.x + (double)v.y * v.y + (double)v.z * v.z);
    if (!(length > 0.0))
        return vec3_set1(0.0f);
    return vec3((float)(v.x / length), (float)(v.y / length), (float)(v.z / length));
}

/* Fills the world arrays. A mirroring map turns the bitangent normal x tangent round, hence the
 * sign of w. */
static void transform_arrays(const air_geometry *geometry, const float to_world[12],
                             const float inverse[12], air_world_mesh *world)
{
    for (size_t i = 0; i < geometry->vertex_count; ++i) {
        vec3_store(world->positions + 3 * i,
                   affine_point(to_world, vec3_load(geometry->positions + 3 * i)));
        if (geometry->normals != NULL)
            vec3_store(world->normals + 3 * i,
                       unit_or_zero(affine_normal(inverse, vec3_load(geometry->normals + 3 * i))));
        if (geometry->tangents != NULL) {
            const float *tangent = geometry->tangents + 4 * i;
            vec3_store(world->tangents + 4 * i,
                       unit_or_zero(affine_vector(to_world, vec3_load(tangent))));
            world->tangents[4 * i + 3] = world->flip ? -tangent[3] : tangent[3];
        }
    }
}

/* Bounds of the vertices that triangles use: loaders leave stray vertices, which nobody sees. */
static void measure_bounds(air_world_mesh *world)
{
    for (size_t axis = 0; axis < 3; ++axis) {
        world->bounds_min[axis] = INFINITY;
        world->bounds_max[axis] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * world->geometry->triangle_count; ++i) {
        const float *p = world->positions + 3 * (size_t)world->geometry->indices[i];
        for (size_t axis = 0; axis < 3; ++axis) {
            world->bounds_min[axis] = fminf(world->bounds_min[axis], p[axis]);
            world->bounds_max[axis] = fmaxf(world->bounds_max[axis], p[axis]);
        }
    }
}

static air_status allocate_world_arrays(air_context *context, const air_geometry *geometry,
                                        air_world_mesh *world)
{
    const size_t n = geometry->vertex_count;
    world->positions = allocate_positions(context, n);
    if (geometry->normals != NULL)
        world->normals = air_allocate(context, n, 3 * sizeof(float));
    if (geometry->tangents != NULL)
        world->tangents = air_allocate(context, n, 4 * sizeof(float));
    if (world->positions == NULL || (geometry->normals != NULL && world->normals == NULL) ||
        (geometry->tangents != NULL && world->tangents == NULL))
        return air_fail_memory(context, "mesh in world space");
    return AIR_OK;
}

static air_status place_arrays(const air_mesh_record *record, air_world_mesh *world)
{
    const air_geometry *geometry = record->geometry;
    float inverse[12];
    air_context *context = record->base.context;
    const air_status status = allocate_world_arrays(context, geometry, world);
    if (status != AIR_OK)
        return status;
    if (!affine_invert(record->to_world, inverse))
        return air_fail(context, AIR_ERROR_INTERNAL, "mesh \"%s\": to_world became singular",
                        record->base.name);
    world->flip = affine_determinant(record->to_world) < 0.0;
    transform_arrays(geometry, record->to_world, inverse, world);
    for (size_t i = 0; i < 3 * geometry->vertex_count; ++i) {
        if (!isfinite(world->positions[i])) {
            const air_subject subject = {context, "mesh", record->base.name};
            return air_subject_fail(
                &subject, "to_world moves vertex %zu beyond what a float can hold", i / 3);
        }
    }
    return AIR_OK;
}

static air_status place_quadric(const air_mesh_record *record, air_world_mesh *world)
{
    const air_subject subject = {record->base.context, "mesh", record->base.name};
    /* the values of the two enums are the same */
    if (!air_quadric_make((air_ray_shape)record->geometry->shape, record->to_world,
                          &world->quadric))
        return air_subject_fail(&subject, "to_world is singular");
    air_quadric_bounds(&world->quadric, world->bounds_min, world->bounds_max);
    if (!vec3_is_finite(vec3_load(world->bounds_min)) ||
        !vec3_is_finite(vec3_load(world->bounds_max)))
        return air_subject_fail(&subject, "to_world moves it beyond what a float can hold");
    return AIR_OK;
}

static air_status place_triangles(const air_mesh_record *record, air_world_mesh *world)
{
    air_status status = AIR_OK;
    if (memcmp(record->to_world, identity, sizeof identity) == 0) {
        world->borrowed = true;
        world->positions = record->geometry->positions;
        world->normals = record->geometry->normals;
        world->tangents = record->geometry->tangents;
    } else {
        status = place_arrays(record, world);
    }
    if (status == AIR_OK)
        measure_bounds(world);
    return status;
}

air_status air_mesh_record_place(air_mesh_record *record)
{
    if (record->world != NULL)
        return AIR_OK;
    air_world_mesh *world =
        air_record_create(record->base.context, sizeof *world, destroy_world_mesh, NULL);
    if (world == NULL)
        return AIR_ERROR_MEMORY;
    air_record_retain(&record->geometry->base);
    world->geometry = record->geometry;
    const air_status status = record->geometry->shape == AIR_SHAPE_TRIANGLES
                                  ? place_triangles(record, world)
                                  : place_quadric(record, world);
    if (status != AIR_OK) {
        air_record_release(&world->base);
        return status;
    }
    record->world = world;
    return AIR_OK;
}

void air_mesh_init(const air_mesh_record *record, uint32_t material_index,
                   const air_material *material, air_mesh *out_mesh)
{
    const air_geometry *geometry = record->geometry;
    const air_world_mesh *world = record->world;
    const bool there = material->model != AIR_MATERIAL_NULL;
    uint32_t mask = there ? AIR_MASK_SCATTER : 0;
    if (there && record->camera_visible)
        mask |= AIR_MASK_CAMERA;
    if (there && record->casts_shadow)
        mask |= material->alpha_mode == AIR_ALPHA_OPAQUE ? AIR_MASK_SHADOW_OPAQUE
                                                         : AIR_MASK_SHADOW_ALPHA;
    const bool quadric = geometry->shape != AIR_SHAPE_TRIANGLES;
    *out_mesh = (air_mesh){.name = record->base.name,
                           .quadric = quadric ? &world->quadric : NULL,
                           .positions = world->positions,
                           .normals = world->normals,
                           .tangents = world->tangents,
                           .uv = {geometry->uv[0], geometry->uv[1]},
                           .colors = geometry->colors,
                           .vertex_count = geometry->vertex_count,
                           .indices = geometry->indices,
                           .triangle_count = geometry->triangle_count,
                           .material = material_index,
                           .mask = mask,
                           .first_emitter = UINT32_MAX,
                           .flip = world->flip != record->flip_normals,
                           .node = record->node,
                           .primitive = record->primitive};
}

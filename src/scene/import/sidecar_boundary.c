#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/grid_record.h"
#include "scene/import/import.h"
#include "scene/scene.h"

/* ---- maps ---- */

air_status air_sidecar_read_map(const air_json *at, float out[12])
{
    const size_t rows = air_json_count(at);
    if (rows != 3 && rows != 4)
        return air_json_expected(at, "three or four rows of four numbers");
    for (size_t i = 0; i < rows; ++i) {
        const air_json row_at = air_json_at(at, i);
        float row[4];
        const air_status status = air_json_floats(&row_at, AIR_JSON_ANY, 4, row);
        if (status != AIR_OK)
            return status;
        if (i < 3)
            memcpy(out + 4 * i, row, sizeof row);
        else if (row[0] != 0.0f || row[1] != 0.0f || row[2] != 0.0f || row[3] != 1.0f)
            return air_json_expected(&row_at, "[0, 0, 0, 1] as the last row");
    }
    return AIR_OK;
}

air_status air_sidecar_read_rotation(const air_json *at, float out[9])
{
    float quaternion[4];
    const air_status status = air_json_floats(at, AIR_JSON_ANY, 4, quaternion);
    if (status != AIR_OK)
        return status;
    double q[4], length = 0.0;
    for (size_t i = 0; i < 4; ++i) {
        q[i] = (double)quaternion[i];
        length += q[i] * q[i];
    }
    if (!(length > 1e-30))
        return air_json_expected(at, "a quaternion x, y, z, w that is not 0");
    for (size_t i = 0; i < 4; ++i)
        q[i] /= sqrt(length);
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double m[9] = {
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z),       2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),       1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),       2.0 * (y * z + w * x),       1.0 - 2.0 * (x * x + y * y)};
    for (size_t i = 0; i < 9; ++i)
        out[i] = (float)m[i];
    return AIR_OK;
}

air_status air_sidecar_read_direction(const air_json *at, float out[3])
{
    air_status status = air_json_require(at, "a direction");
    if (status == AIR_OK)
        status = air_json_floats(at, AIR_JSON_ANY, 3, out);
    if (status != AIR_OK)
        return status;
    const double x = (double)out[0], y = (double)out[1], z = (double)out[2];
    const double length = sqrt(x * x + y * y + z * z);
    if (!(length > 1e-30))
        return air_json_expected(at, "a direction that is not 0");
    if (fabs(length - 1.0) < 5e-7) /* but for the rounding of floats: it stays as it is */
        return AIR_OK;
    out[0] = (float)(x / length);
    out[1] = (float)(y / length);
    out[2] = (float)(z / length);
    return AIR_OK;
}

/* ---- boundaries ---- */

static void set_box(const float center[3], const float half[3], const float rotation[9],
                    float out[12])
{
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            out[4 * row + column] = rotation[3 * row + column] * half[column];
        out[4 * row + 3] = center[row];
    }
}

/* The corners, or centre and size, of a box. */
static air_status read_extent(const air_json *at, float center[3], float half[3])
{
    const air_json min_at = air_json_get(at, "min");
    const air_json max_at = air_json_get(at, "max");
    const air_json center_at = air_json_get(at, "center");
    const air_json size_at = air_json_get(at, "size");
    const bool by_corners = min_at.value != NULL || max_at.value != NULL;
    float min[3] = {0.0f, 0.0f, 0.0f}, max[3] = {0.0f, 0.0f, 0.0f}, size[3] = {0.0f, 0.0f, 0.0f};
    if (by_corners == (center_at.value != NULL || size_at.value != NULL))
        return air_json_fail(at, AIR_ERROR_FORMAT,
                             "expected min and max, or center and size, or to_world");
    air_status status = air_json_require(by_corners ? &min_at : &center_at, "a point");
    if (status == AIR_OK)
        status = by_corners ? air_json_require(&max_at, "a point")
                            : air_json_require(&size_at, "three lengths");
    if (status == AIR_OK)
        status = air_json_floats(&min_at, AIR_JSON_ANY, 3, min);
    if (status == AIR_OK)
        status = air_json_floats(&max_at, AIR_JSON_ANY, 3, max);
    if (status == AIR_OK)
        status = air_json_floats(&center_at, AIR_JSON_ANY, 3, center);
    if (status == AIR_OK)
        status = air_json_floats(&size_at, AIR_JSON_POSITIVE, 3, size);
    for (size_t i = 0; i < 3 && status == AIR_OK; ++i) {
        const air_json upper = air_json_at(&max_at, i);
        if (by_corners && !(max[i] > min[i]))
            status = air_json_expected(&upper, "a number above %g, which is the box's min[%zu]",
                                       (double)min[i], i);
        if (by_corners)
            center[i] = 0.5f * min[i] + 0.5f * max[i];
        half[i] = by_corners ? 0.5f * max[i] - 0.5f * min[i] : 0.5f * size[i];
    }
    return status;
}

static air_status read_box(const air_sidecar_part *part, const air_json *at, air_boundary *boundary)
{
    static const char *const keys[] = {"min", "max", "center", "size", "rotation", "to_world"};
    const air_json map_at = air_json_get(at, "to_world");
    const air_json rotation_at = air_json_get(at, "rotation");
    float center[3] = {0.0f, 0.0f, 0.0f}, half[3] = {1.0f, 1.0f, 1.0f}, local[12], inverse[12];
    float rotation[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, sizeof keys / sizeof keys[0]);
    if (status != AIR_OK)
        return status;
    if (map_at.value != NULL) {
        if (json_object_size(at->value) !=
            1 + (size_t)(json_object_get(at->value, "comment") != NULL))
            return air_json_fail(&map_at, AIR_ERROR_FORMAT,
                                 "expected nothing else beside to_world");
        status = air_sidecar_read_map(&map_at, local);
    } else {
        status = read_extent(at, center, half);
        if (status == AIR_OK && rotation_at.value != NULL)
            status = air_sidecar_read_rotation(&rotation_at, rotation);
        set_box(center, half, rotation, local);
    }
    if (status != AIR_OK)
        return status;
    boundary->kind = AIR_BOUNDARY_BOX;
    affine_multiply(part->to_world, local, boundary->box_to_world);
    if (!affine_invert(boundary->box_to_world, inverse))
        return air_json_fail(at, AIR_ERROR_FORMAT, "the box has no volume");
    return AIR_OK;
}

/* {"center", "radius"}: of the node's space, whose map makes of it what it does of everything. */
static air_status read_sphere(const air_json *at, float out[12])
{
    static const char *const keys[] = {"center", "radius"};
    const air_json center_at = air_json_get(at, "center"), radius_at = air_json_get(at, "radius");
    const float none[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
    float center[3] = {0.0f, 0.0f, 0.0f}, radius = 0.0f;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_check_keys(at, keys, sizeof keys / sizeof keys[0]);
    if (status == AIR_OK && center_at.value != NULL)
        status = air_json_floats(&center_at, AIR_JSON_ANY, 3, center);
    if (status == AIR_OK)
        status = air_json_require(&radius_at, "a radius");
    if (status == AIR_OK)
        status = air_json_float(&radius_at, AIR_JSON_POSITIVE, &radius);
    const float half[3] = {radius, radius, radius};
    set_box(center, half, none, out);
    return status;
}

static air_status read_ellipsoid(const air_sidecar_part *part, const air_json *at, bool sphere,
                                 air_boundary *boundary)
{
    float local[12], inverse[12];
    const air_status status = sphere ? read_sphere(at, local) : air_sidecar_read_map(at, local);
    if (status != AIR_OK)
        return status;
    boundary->kind = AIR_BOUNDARY_ELLIPSOID;
    affine_multiply(part->to_world, local, boundary->box_to_world);
    if (!affine_invert(boundary->box_to_world, inverse))
        return air_json_fail(at, AIR_ERROR_FORMAT, "the %s has no volume",
                             sphere ? "sphere" : "ellipsoid");
    return AIR_OK;
}

/* n . x <= h with x in the node's space becomes n' . y <= h + n' . t, n' by the inverse transpose
 * and t the origin. */
static air_status read_planes(const air_sidecar_part *part, const air_json *at,
                              air_boundary *boundary, float **out)
{
    const size_t count = air_json_count(at);
    float inverse[12];
    if (count < 1 || count > AIR_MAX_PLANES)
        return air_json_expected(at, "an array of 1 to %d planes", (int)AIR_MAX_PLANES);
    if (!affine_invert(part->to_world, inverse))
        return air_json_fail(at, AIR_ERROR_FORMAT, "the node is scaled to nothing");
    float *planes = air_allocate(part->import->context, count, 4 * sizeof *planes);
    if (planes == NULL)
        return air_fail_memory(part->import->context, "medium boundary");
    *out = planes;
    const air_vec3 origin = vec3(part->to_world[3], part->to_world[7], part->to_world[11]);
    for (size_t i = 0; i < count; ++i) {
        const air_json plane_at = air_json_at(at, i);
        float *plane = planes + 4 * i;
        const air_status status = air_json_floats(&plane_at, AIR_JSON_ANY, 4, plane);
        if (status != AIR_OK)
            return status;
        const air_vec3 normal = affine_normal(inverse, vec3_load(plane));
        if (!(vec3_length(normal) > 0.0f))
            return air_json_expected(&plane_at, "nx, ny, nz, h with a normal that is not 0");
        vec3_store(plane, normal);
        plane[3] += vec3_dot(normal, origin);
    }
    boundary->kind = AIR_BOUNDARY_CONVEX;
    boundary->planes = planes;
    boundary->plane_count = count;
    return AIR_OK;
}

static void set_mesh(const air_import_geometry *geometry, air_boundary *boundary)
{
    boundary->kind = AIR_BOUNDARY_MESH;
    boundary->positions = geometry->positions;
    boundary->vertex_count = geometry->vertex_count;
    boundary->indices = geometry->indices;
    boundary->triangle_count = geometry->triangle_count;
}

/* The meshes of all objects of a name together. */
static air_status read_named_mesh(const air_sidecar_part *part, const air_json *at,
                                  air_boundary *boundary, air_import_geometry *geometry)
{
    const air_import *import = part->import;
    const char *name = "";
    air_status status = air_json_string(at, &name);
    for (size_t i = air_import_find(import, name, 0); i != SIZE_MAX && status == AIR_OK;
         i = air_import_find(import, name, i + 1))
        if (import->objects[i].mesh != SIZE_MAX)
            status = import->append_geometry(import->user, &import->objects[i], geometry);
    set_mesh(geometry, boundary);
    return status;
}

/* The box outside which a grid is 0: from half a cell before its first sample to half a cell behind
 * its last. Those of a sequence may each have another: every commit cuts the medium down to its
 * grid anyway. */
static void set_grid_box(const air_sidecar_part *part, const air_density *density,
                         air_boundary *boundary)
{
    const air_slot_list *list = &part->import->scene->lists[AIR_OBJECT_GRID];
    const air_slot *slot = &list->slots[air_slot_find(list, density->grid)];
    const air_grid_record *record = (const air_grid_record *)slot->record;
    const air_grid *grid = record->grid;
    const float no_rotation[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
    size_t size[3];
    float center[3], half[3], to_index[12], to_local[12];
    if (record->sequence.path != NULL)
        return;
    air_grid_size(grid, size);
    for (size_t i = 0; i < 3; ++i) {
        center[i] = 0.5f * (float)(size[i] - 1);
        half[i] = 0.5f * (float)size[i];
    }
    set_box(center, half, no_rotation, to_index);
    affine_multiply(air_grid_index_to_local(grid), to_index, to_local);
    affine_multiply(density->grid_to_world, to_local, boundary->box_to_world);
    boundary->kind = AIR_BOUNDARY_BOX;
}

static air_status read_given(const air_sidecar_part *part, const air_json *at,
                             air_boundary *boundary, float **planes, air_import_geometry *geometry)
{
    static const char *const keys[] = {"box", "mesh", "planes", "sphere", "ellipsoid"};
    static const char *const words[] = {"unbounded"};
    const air_json box = air_json_get(at, "box");
    const air_json mesh = air_json_get(at, "mesh");
    const air_json faces = air_json_get(at, "planes");
    const air_json sphere = air_json_get(at, "sphere");
    const air_json ellipsoid = air_json_get(at, "ellipsoid");
    size_t word = 0;
    if (json_is_string(at->value))
        return air_json_choice(at, words, 1, &word);
    if (!json_is_object(at->value))
        return air_json_expected(at, "\"unbounded\" or an object with box, mesh, planes, sphere or "
                                     "ellipsoid");
    const air_status status = air_json_check_keys(at, keys, sizeof keys / sizeof keys[0]);
    if (status != AIR_OK)
        return status;
    if ((box.value != NULL) + (mesh.value != NULL) + (faces.value != NULL) +
            (sphere.value != NULL) + (ellipsoid.value != NULL) !=
        1)
        return air_json_fail(at, AIR_ERROR_FORMAT,
                             "expected one of box, mesh, planes, sphere and ellipsoid");
    if (box.value != NULL)
        return read_box(part, &box, boundary);
    if (sphere.value != NULL || ellipsoid.value != NULL)
        return read_ellipsoid(part, sphere.value != NULL ? &sphere : &ellipsoid,
                              sphere.value != NULL, boundary);
    if (faces.value != NULL)
        return read_planes(part, &faces, boundary, planes);
    return read_named_mesh(part, &mesh, boundary, geometry);
}

air_status air_sidecar_read_boundary(const air_sidecar_part *part, air_medium_desc *desc,
                                     float **planes, air_import_geometry *geometry)
{
    const air_json at = air_json_get(part->at, "boundary");
    const air_import *import = part->import;
    if (at.value != NULL)
        return read_given(part, &at, &desc->boundary, planes, geometry);
    if (part->object != SIZE_MAX) {
        const air_status status =
            import->append_geometry(import->user, &import->objects[part->object], geometry);
        set_mesh(geometry, &desc->boundary);
        return status;
    }
    if (desc->density.kind == AIR_DENSITY_GRID)
        set_grid_box(part, &desc->density, &desc->boundary);
    return AIR_OK;
}

air_status air_sidecar_mark_boundary(const air_sidecar_part *part)
{
    air_import *import = part->import;
    const air_json boundary = air_json_get(part->at, "boundary");
    const air_json mesh = air_json_get(&boundary, "mesh");
    const air_json visible_at = air_json_get(part->at, "boundary_visible");
    bool visible = false;
    const char *name = NULL;
    air_status status = air_json_check_object(part->at, true);
    if (status == AIR_OK)
        status = air_json_bool(&visible_at, &visible);
    if (status == AIR_OK)
        status = air_json_string(&mesh, &name);
    if (status != AIR_OK)
        return status;
    if (boundary.value == NULL && part->object != SIZE_MAX && !visible)
        import->objects[part->object].bounds_medium = true;
    if (name == NULL)
        return AIR_OK;
    bool found = false;
    for (size_t i = air_import_find(import, name, 0); i != SIZE_MAX;
         i = air_import_find(import, name, i + 1)) {
        found = found || import->objects[i].mesh != SIZE_MAX;
        import->objects[i].bounds_medium |= !visible && import->objects[i].mesh != SIZE_MAX;
    }
    return found ? AIR_OK : air_import_unknown_name(import, &mesh, name);
}

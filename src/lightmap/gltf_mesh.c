/* gltf_mesh.c: meshes of a glTF file for the atlas. */
#include "lightmap/gltf_mesh.h"

#include <stdio.h>
#include <string.h>

#include "lightmap/files.h"

enum { TRIANGLES = 4, UNSIGNED_SHORT = 5123, UNSIGNED_INT = 5125, FLOAT = 5126, NAME = 32 };

/* A primitive that gets light. */
typedef struct lit_primitive {
    air_gltf_show *show;
    const air_lightmap_mesh *mesh;
    air_place at, attributes;
} lit_primitive;

/* ---- coordinates ---- */

static air_status set_index(const lit_primitive *self, json_t *object, const char *key,
                            size_t index)
{
    return json_object_set_new(object, key, json_integer((json_int_t)index)) == 0
               ? AIR_OK
               : air_fail_memory(self->at.context, self->at.file);
}

/* TEXCOORD_1 = uv * scale + offset. uv: two numbers per vertex. */
static air_status add_coordinates(const lit_primitive *self, const float *uv, size_t count)
{
    air_gltf_array array = {.count = count, .components = 2, .component_size = 4};
    size_t accessor = 0;
    array.component = FLOAT;
    array.bytes = air_allocate(self->at.context, count, 8);
    if (array.bytes == NULL) {
        return air_fail_memory(self->at.context, self->at.file);
    }
    for (size_t i = 0; i < 2 * count; i++) {
        const float value = uv[i] * self->mesh->scale[i % 2] + self->mesh->offset[i % 2];
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        air_put_u32(array.bytes + 4 * i, bits);
    }
    air_status status = air_gltf_array_add(self->show->copy, &array, false, false, &accessor);
    air_free(self->at.context, array.bytes);
    if (status == AIR_OK) {
        status = set_index(self, self->attributes.value, "TEXCOORD_1", accessor);
    }
    return status;
}

/* The mesh's own coordinates, moved to where the page has them. */
static air_status use_own_coordinates(const lit_primitive *self)
{
    const air_place at = air_place_get(&self->attributes, "TEXCOORD_1");
    const float *scale = self->mesh->scale, *offset = self->mesh->offset;
    air_gltf_array array = {0};
    if (at.value == NULL) {
        return air_place_wrong(&at, "coordinates: the lightmap does not cut this mesh");
    }
    air_status status = air_gltf_array_read(self->show->copy, &at, &array);
    if (status == AIR_OK && array.components != 2) {
        status = air_place_wrong(&at, "an accessor of \"VEC2\"");
    }
    const bool stays =
        scale[0] == 1.0f && scale[1] == 1.0f && offset[0] == 0.0f && offset[1] == 0.0f;
    if (status == AIR_OK && !stays) {
        float *uv = air_allocate(self->at.context, array.count, 2 * sizeof *uv);
        for (size_t i = 0; uv != NULL && i < 2 * array.count; i++) {
            uv[i] = (float)air_gltf_array_number(&array, i / 2, i % 2);
        }
        status = uv == NULL ? air_fail_memory(self->at.context, self->at.file)
                            : add_coordinates(self, uv, array.count);
        air_free(self->at.context, uv);
    }
    air_free(self->at.context, array.bytes);
    return status;
}

/* ---- cutting ---- */

/* Gathers every attribute of an object of attributes. */
static air_status gather(const lit_primitive *self, const air_place *attributes, bool target)
{
    const char *key;
    json_t *value;
    air_status status = AIR_OK;
    if (!json_is_object(attributes->value)) {
        return air_place_wrong(attributes, "an object of attributes");
    }
    /* A copy to walk over, since values are replaced. */
    json_t *walked = json_copy(attributes->value);
    json_object_foreach(walked, key, value)
    {
        const air_place at = air_place_get(attributes, key);
        air_gltf_array old = {0}, new = {0};
        size_t accessor = 0;
        if (!target && strcmp(key, "TEXCOORD_1") == 0) {
            continue; /* will be replaced */
        }
        if (status == AIR_OK) {
            status = air_gltf_array_read(self->show->copy, &at, &old);
        }
        for (size_t i = 0; i < self->mesh->vertex_count && status == AIR_OK; i++) {
            if (self->mesh->sources[i] >= old.count) {
                status = air_place_wrong(
                    &at, "more than %lu elements, as in the mesh that was baked; there are %zu",
                    (unsigned long)self->mesh->sources[i], old.count);
            }
        }
        if (status == AIR_OK) {
            status = air_gltf_array_gather(self->show->copy, &old, self->mesh->sources,
                                           self->mesh->vertex_count, &new);
        }
        if (status == AIR_OK) {
            const bool bounds = strcmp(key, "POSITION") == 0;
            status = air_gltf_array_add(self->show->copy, &new, false, bounds || target, &accessor);
        }
        if (status == AIR_OK) {
            status = set_index(self, attributes->value, key, accessor);
        }
        air_free(self->at.context, old.bytes);
        air_free(self->at.context, new.bytes);
    }
    json_decref(walked);
    return status;
}

static air_status add_indices(const lit_primitive *self)
{
    const air_lightmap_mesh *mesh = self->mesh;
    const bool small = mesh->vertex_count <= 65535;
    air_gltf_array array = {.count = 3 * mesh->triangle_count, .components = 1};
    size_t accessor = 0;
    array.component = small ? UNSIGNED_SHORT : UNSIGNED_INT;
    array.component_size = small ? 2 : 4;
    array.bytes = air_allocate(self->at.context, array.count, array.component_size);
    if (array.bytes == NULL) {
        return air_fail_memory(self->at.context, self->at.file);
    }
    for (size_t i = 0; i < array.count; i++) {
        uint8_t bytes[4];
        air_put_u32(bytes, mesh->indices[i]);
        memcpy(array.bytes + i * array.component_size, bytes, array.component_size);
    }
    air_status status = air_gltf_array_add(self->show->copy, &array, true, false, &accessor);
    air_free(self->at.context, array.bytes);
    if (status == AIR_OK) {
        status = set_index(self, self->at.value, "indices", accessor);
    }
    return status;
}

static air_status cut(const lit_primitive *self)
{
    const air_place targets = air_place_get(&self->at, "targets");
    air_status status = gather(self, &self->attributes, false);
    for (size_t i = 0; i < air_place_count(&targets) && status == AIR_OK; i++) {
        const air_place target = air_place_at(&targets, i);
        status = gather(self, &target, true);
    }
    if (status == AIR_OK) {
        status = add_indices(self);
    }
    if (status == AIR_OK) {
        status = set_index(self, self->at.value, "mode", TRIANGLES);
    }
    return status == AIR_OK ? add_coordinates(self, self->mesh->uv, self->mesh->vertex_count)
                            : status;
}

/* ---- primitives ---- */

/* Where the mesh's own set goes: the first that is free; AIR_GLTF_SET if nothing needs it. */
static size_t choose_moved_set(const lit_primitive *self, size_t material)
{
    size_t set = AIR_GLTF_SET;
    char name[NAME];
    if (json_object_get(self->attributes.value, "TEXCOORD_1") == NULL ||
        !air_gltf_show_uses_set(self->show, material)) {
        return set;
    }
    do {
        set++;
        (void)snprintf(name, sizeof name, "TEXCOORD_%zu", set);
    } while (json_object_get(self->attributes.value, name) != NULL);
    return set;
}

static air_status light_primitive(lit_primitive *self)
{
    const air_place material_at = air_place_get(&self->at, "material");
    const air_place extensions = air_place_get(&self->at, "extensions");
    const bool own = self->mesh->sources == NULL;
    size_t material = SIZE_MAX, copy = 0;
    bool wanted = false;
    if (json_object_get(extensions.value, "KHR_draco_mesh_compression") != NULL) {
        return air_fail(self->at.context, AIR_ERROR_UNSUPPORTED,
                        "%s: %s: meshes compressed by KHR_draco_mesh_compression cannot be changed",
                        self->at.file, self->at.text);
    }
    air_status status = AIR_OK;
    if (material_at.value != NULL) {
        status = air_place_size(&material_at, INT32_MAX, &material);
    }
    if (status == AIR_OK) {
        status = air_gltf_show_wanted(self->show, material, &wanted);
    }
    if (status != AIR_OK || !wanted) {
        return status;
    }
    const size_t moved = choose_moved_set(self, material);
    json_t *old = moved != AIR_GLTF_SET
                      ? json_copy(json_object_get(self->attributes.value, "TEXCOORD_1"))
                      : NULL;
    if (old != NULL) {
        char name[NAME];
        (void)snprintf(name, sizeof name, "TEXCOORD_%zu", moved);
        json_object_set_new(self->attributes.value, name, old);
    }
    status = own ? use_own_coordinates(self) : cut(self);
    if (status == AIR_OK && moved == AIR_GLTF_SET &&
        self->show->params.show == AIR_SHOW_COORDINATES) {
        return AIR_OK; /* nothing to say about the material */
    }
    if (status == AIR_OK) {
        status =
            air_gltf_show_material(self->show, material, (size_t)self->mesh->page, moved, &copy);
    }
    return status == AIR_OK ? set_index(self, self->at.value, "material", copy) : status;
}

/* ---- nodes ---- */

/* How many nodes use each mesh. */
static air_status count_uses(const air_gltf_copy *copy, size_t *uses, size_t mesh_count)
{
    const air_place root = air_gltf_copy_root(copy);
    const air_place nodes = air_place_get(&root, "nodes");
    air_status status = AIR_OK;
    for (size_t i = 0; i < air_place_count(&nodes) && status == AIR_OK; i++) {
        const air_place node = air_place_at(&nodes, i);
        const air_place mesh_at = air_place_get(&node, "mesh");
        size_t mesh = 0;
        if (mesh_at.value == NULL) {
            continue;
        }
        if (mesh_count == 0) {
            return air_place_wrong(&mesh_at, "no mesh, as there are none");
        }
        status = air_place_size(&mesh_at, mesh_count - 1, &mesh);
        uses[mesh] += status == AIR_OK;
    }
    return status;
}

/* The mesh of a node, for it alone. */
static air_status own_mesh(air_gltf_copy *copy, const air_place *node, size_t *uses,
                           size_t mesh_count, air_place *out_mesh)
{
    const air_place root = air_gltf_copy_root(copy);
    const air_place meshes = air_place_get(&root, "meshes");
    const air_place mesh_at = air_place_get(node, "mesh");
    size_t mesh = 0;
    if (air_place_count(&meshes) == 0) {
        return air_place_wrong(&mesh_at, "a mesh, as in the scene that was baked");
    }
    air_status status = air_place_size(&mesh_at, air_place_count(&meshes) - 1, &mesh);
    if (status == AIR_OK && mesh < mesh_count && uses[mesh] > 1) {
        json_t *twin = json_deep_copy(json_array_get(meshes.value, mesh));
        uses[mesh]--;
        status = twin == NULL ? air_fail_memory(copy->context, copy->path)
                              : air_gltf_copy_append(copy, "meshes", twin, &mesh);
        if (status == AIR_OK) {
            json_object_set_new(node->value, "mesh", json_integer((json_int_t)mesh));
        }
    }
    /* Named by its node: the copy has no number in the source. */
    *out_mesh = mesh_at;
    out_mesh->value = json_array_get(meshes.value, mesh);
    return status;
}

static air_status light_mesh(air_gltf_show *self, const air_lightmap_mesh *mesh, size_t *uses,
                             size_t mesh_count)
{
    const air_place root = air_gltf_copy_root(self->copy);
    const air_place nodes = air_place_get(&root, "nodes");
    const air_place node = air_place_at(&nodes, (size_t)mesh->node);
    air_place own;
    if (node.value == NULL) {
        return air_place_wrong(&node, "a node, as in the scene that was baked");
    }
    air_status status = own_mesh(self->copy, &node, uses, mesh_count, &own);
    if (status != AIR_OK) {
        return status;
    }
    const air_place primitives = air_place_get(&own, "primitives");
    lit_primitive primitive = {.show = self, .mesh = mesh};
    primitive.at = air_place_at(&primitives, (size_t)mesh->primitive);
    primitive.attributes = air_place_get(&primitive.at, "attributes");
    if (!json_is_object(primitive.attributes.value)) {
        return air_place_wrong(&primitive.attributes, "attributes, as in the scene that was baked");
    }
    return light_primitive(&primitive);
}

air_status air_gltf_mesh_light_all(air_gltf_show *self)
{
    const air_lightmap *lightmap = self->lightmap;
    const air_place root = air_gltf_copy_root(self->copy);
    const air_place meshes = air_place_get(&root, "meshes");
    const size_t mesh_count = air_place_count(&meshes);
    size_t elsewhere = 0;
    size_t *uses = air_allocate(self->copy->context, mesh_count, sizeof *uses);
    if (uses == NULL) {
        return air_fail_memory(self->copy->context, self->copy->path);
    }
    air_status status = count_uses(self->copy, uses, mesh_count);
    for (size_t i = 0; i < lightmap->mesh_count && status == AIR_OK; i++) {
        const air_lightmap_mesh *mesh = &lightmap->meshes[i];
        if (mesh->page >= 0 && mesh->node >= 0) {
            status = light_mesh(self, mesh, uses, mesh_count);
        }
        elsewhere += mesh->page >= 0 && mesh->node < 0;
    }
    air_free(self->copy->context, uses);
    if (status == AIR_OK && elsewhere > 0) {
        air_warn(self->copy->context, "%s: %zu meshes of the lightmap do not come from a glTF file",
                 self->copy->path, elsewhere);
    }
    return status;
}

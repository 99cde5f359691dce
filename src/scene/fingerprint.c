#include "scene/fingerprint.h"

#include <string.h>

#include "scene/lights/environment.h"
#include "scene/media/grid.h"

/* Eight bytes at a time: xor, multiply, fold the high half down. */
uint64_t air_fingerprint_add(uint64_t hash, const void *data, size_t size)
{
    const uint8_t *bytes = data;
    for (size_t at = 0; at < size; at += 8) {
        uint64_t word = 0;
        memcpy(&word, bytes + at, size - at < 8 ? size - at : 8);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
        hash ^= hash >> 32;
    }
    return (hash ^ size) * 0x9e3779b97f4a7c15ull;
}

/* Objects without padding or pointers only. */
#define ADD(hash, object) air_fingerprint_add(hash, &(object), sizeof(object))

static uint64_t add_array(uint64_t hash, const void *data, size_t size)
{
    return data != NULL ? air_fingerprint_add(hash, data, size) : hash;
}

static uint64_t add_flags(uint64_t hash, bool a, bool b, bool c)
{
    const uint32_t flags = (uint32_t)a | (uint32_t)b << 1 | (uint32_t)c << 2;
    return ADD(hash, flags);
}

static uint64_t add_mesh(uint64_t hash, const air_mesh *mesh)
{
    const size_t vertices = mesh->vertex_count;
    hash = add_array(hash, mesh->positions, 3 * vertices * sizeof(float));
    hash = add_array(hash, mesh->normals, 3 * vertices * sizeof(float));
    hash = add_array(hash, mesh->tangents, 4 * vertices * sizeof(float));
    hash = add_array(hash, mesh->uv[0], 2 * vertices * sizeof(float));
    hash = add_array(hash, mesh->uv[1], 2 * vertices * sizeof(float));
    hash = add_array(hash, mesh->colors, 4 * vertices * sizeof(float));
    hash = add_array(hash, mesh->indices, 3 * mesh->triangle_count * sizeof(uint32_t));
    if (mesh->quadric != NULL) {
        hash = ADD(hash, mesh->quadric->shape);
        hash = ADD(hash, mesh->quadric->to_world);
    }
    if (mesh->flip) {
        hash = add_flags(hash, mesh->flip, false, false);
    }
    hash = ADD(hash, mesh->material);
    return ADD(hash, mesh->mask);
}

static uint64_t add_texels(uint64_t hash, const air_texture *texture)
{
    const size_t values = texture->width * texture->height * texture->channels;
    hash = add_array(hash, texture->bytes, values);
    return add_array(hash, texture->floats, values * sizeof(float));
}

static uint64_t add_material(uint64_t hash, const air_material *material);

static uint64_t add_slot(uint64_t hash, const air_texture_slot *slot)
{
    const air_texture *texture = slot->texture;
    if (texture == NULL) {
        return hash;
    }
    hash = add_texels(hash, texture);
    hash = ADD(hash, texture->wrap_u);
    hash = ADD(hash, texture->wrap_v);
    hash = ADD(hash, texture->filter);
    hash = ADD(hash, slot->uv_set);
    hash = ADD(hash, slot->uv_transform);
    return add_flags(hash, texture->srgb, false, false);
}

/* Materials that are of METALLIC_ROUGHNESS alone have the fingerprints that they had before there
 * were others. */
static uint64_t add_optics(uint64_t hash, const air_material *material)
{
    const air_optics *optics = &material->optics;
    const float numbers[] = {optics->facets.alpha_u, optics->facets.alpha_v, material->transmission,
                             material->blend_weight, material->bump_scale};
    hash = add_slot(hash, &material->opacity_slot);
    hash = add_slot(hash, &material->bump_slot);
    hash = add_slot(hash, &material->transmission_slot);
    hash = add_slot(hash, &material->blend_slot);
    if (material->model == AIR_MATERIAL_METALLIC_ROUGHNESS && material->transmission == 0.0f &&
        material->bump_slot.texture == NULL && !material->one_sided) {
        return hash;
    }
    hash = ADD(hash, material->model);
    hash = ADD(hash, optics->facets.distribution);
    hash = ADD(hash, numbers);
    hash = ADD(hash, optics->reflectance);
    hash = ADD(hash, optics->transmittance);
    hash = ADD(hash, optics->eta);
    hash = ADD(hash, optics->absorption);
    for (size_t i = 0; material->blend[0] != NULL && i < 2; i++) {
        hash = add_material(hash, material->blend[i]);
    }
    return add_flags(hash, optics->nonlinear, material->thin_walled, material->one_sided);
}

static uint64_t add_material(uint64_t hash, const air_material *material)
{
    hash = add_optics(hash, material);
    const float numbers[] = {material->alpha,       material->metallic, material->roughness,
                             material->specular,    material->ior,      material->normal_scale,
                             material->alpha_cutoff};
    hash = ADD(hash, material->base_color);
    hash = ADD(hash, material->emission);
    hash = ADD(hash, numbers);
    hash = ADD(hash, material->alpha_mode);
    hash = add_flags(hash, material->double_sided, material->unlit, false);
    hash = add_slot(hash, &material->base_color_slot);
    hash = add_slot(hash, &material->metallic_roughness_slot);
    hash = add_slot(hash, &material->normal_slot);
    return add_slot(hash, &material->emission_slot);
}

static uint64_t add_light(uint64_t hash, const air_light *light)
{
    hash = ADD(hash, light->kind);
    hash = ADD(hash, light->color);
    hash = ADD(hash, light->position);
    hash = ADD(hash, light->dir);
    hash = ADD(hash, light->spot_scale);
    hash = ADD(hash, light->spot_offset);
    if (light->falloff != AIR_SPOT_COSINE) {
        hash = ADD(hash, light->falloff);
    }
    if (light->kind == AIR_LIGHT_PROJECTOR) {
        hash = ADD(hash, light->frame);
        hash = ADD(hash, light->tan_half);
        hash = light->emission_texture != NULL ? add_texels(hash, light->emission_texture) : hash;
    }
    const size_t corners =
        light->window_count > 0 ? light->window_ends[light->window_count - 1] : 0;
    hash = add_array(hash, light->windows, 2 * corners * sizeof(double));
    hash = add_array(hash, light->window_ends, light->window_count * sizeof(size_t));
    hash = add_array(hash, light->vertices, light->vertex_count * sizeof(air_vec3));
    for (int i = 0; light->environment != NULL && i < 64; i++) {
        /* the picture by its radiance in directions spread over the sphere */
        const float z = 1.0f - ((float)i + 0.5f) / 32.0f, phi = 2.39996323f * (float)i;
        const float r = sqrtf(1.0f - z * z);
        const air_vec3 radiance =
            air_environment_radiance(light, vec3(r * cosf(phi), z, r * sinf(phi)));
        hash = ADD(hash, radiance);
    }
    return add_flags(hash, light->one_sided, light->camera_visible, light->casts_shadow);
}

static uint64_t add_grid(uint64_t hash, const air_grid *grid, const float world_to_grid[12])
{
    size_t size[3];
    if (grid == NULL) {
        return hash;
    }
    air_grid_size(grid, size);
    const float max = air_grid_max(grid);
    hash = air_fingerprint_add(hash, world_to_grid, 12 * sizeof(float));
    hash = ADD(hash, size);
    hash = ADD(hash, max);
    for (uint32_t i = 0; i < 4096; i++) {
        /* the values along a line that visits all of the grid */
        const air_vec3 at = vec3((float)(i * 2654435769u) * 0x1p-32f * (float)size[0],
                                 (float)(i * 1640531513u) * 0x1p-32f * (float)size[1],
                                 (float)i / 4096.0f * (float)size[2]);
        const air_vec3 value = air_grid_lookup(grid, at);
        hash = ADD(hash, value);
    }
    return hash;
}

/* Media without detail have the fingerprints that they had before there was any. */
static uint64_t add_detail(uint64_t hash, const air_detail_field *detail)
{
    if (detail->strength == 0.0f) {
        return hash;
    }
    hash = ADD(hash, detail->strength);
    hash = ADD(hash, detail->octaves);
    hash = ADD(hash, detail->seeds[0]);
    return ADD(hash, detail->to_lattice);
}

static uint64_t add_medium(uint64_t hash, const air_medium *medium)
{
    const float numbers[] = {medium->phase.g, medium->base_height, medium->inverse_scale_height};
    hash = ADD(hash, medium->sigma_s);
    hash = ADD(hash, medium->sigma_a);
    hash = ADD(hash, medium->emission);
    hash = ADD(hash, medium->phase.kind);
    if (medium->phase.kind == AIR_PHASE_MIXTURE) {
        hash = add_array(hash, medium->mixture.lobes,
                         medium->mixture.lobe_count * sizeof *medium->mixture.lobes);
    }
    hash = ADD(hash, medium->kind);
    hash = ADD(hash, medium->up);
    hash = ADD(hash, numbers);
    hash = ADD(hash, medium->combine);
    hash = ADD(hash, medium->priority);
    hash = add_detail(hash, &medium->detail);
    hash = add_grid(hash, medium->density_grid, medium->world_to_grid);
    hash = add_grid(hash, medium->albedo_grid, medium->world_to_albedo);
    return add_grid(hash, medium->emission_grid, medium->world_to_emission);
}

static uint64_t add_media(uint64_t hash, const air_media *media)
{
    for (size_t i = 0; i < media->count; i++) {
        hash = add_medium(hash, &media->media[i]);
    }
    for (size_t r = 0; r < media->region_count; r++) {
        const air_region *region = &media->regions[r];
        hash = ADD(hash, region->kind);
        hash = ADD(hash, region->medium);
        hash = ADD(hash, region->density);
        hash = add_array(hash, region->planes, region->plane_count * sizeof *region->planes);
        if (region->kind == AIR_REGION_ELLIPSOID) {
            hash = ADD(hash, region->ellipsoid.to_world);
        }
    }
    for (size_t i = 0; i < media->boundary_mesh_count; i++) {
        const air_ray_mesh *mesh = &media->boundary_meshes[i];
        hash = add_array(hash, mesh->positions, 3 * mesh->vertex_count * sizeof(float));
        hash = add_array(hash, mesh->indices, 3 * mesh->triangle_count * sizeof(uint32_t));
    }
    return hash;
}

uint64_t air_fingerprint_snapshot(const air_snapshot *snapshot)
{
    uint64_t hash = 0;
    for (size_t i = 0; i < snapshot->mesh_count; i++) {
        hash = add_mesh(hash, snapshot->meshes[i]);
    }
    for (size_t i = 0; i < snapshot->material_count; i++) {
        hash = add_material(hash, &snapshot->materials[i]);
    }
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        hash = add_light(hash, &snapshot->lights.entries[i]);
    }
    return add_media(hash, &snapshot->media);
}

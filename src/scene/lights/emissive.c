/* emissive.c: see emissive.h. */
#include "scene/lights/emissive.h"

#include "scene/lights/quadric_lamp.h"
#include "scene/texture.h"

static void set_triangle(const air_mesh *mesh, const uint32_t *corners, air_vec3 *vertices,
                         air_light *out)
{
    for (int k = 0; k < 3; k++) {
        vertices[k] = vec3_load(mesh->positions + 3 * (size_t)corners[k]);
    }
    out->vertices = vertices;
    out->vertex_count = 3;
    out->triangles = (air_vec3(*)[3])vertices;
    out->triangle_count = 1;
    const air_vec3 cross =
        vec3_cross(vec3_sub(vertices[1], vertices[0]), vec3_sub(vertices[2], vertices[0]));
    const float length = vec3_length(cross);
    out->area = 0.5f * length;
    out->normal = length > 0.0f ? vec3_scale(cross, (mesh->flip ? -1.0f : 1.0f) / length)
                                : vec3(0.0f, 0.0f, 1.0f);
}

static void set_texture(const air_mesh *mesh, const uint32_t *corners, const air_texture_slot *slot,
                        air_light *out)
{
    const float *uv = mesh->uv[slot->uv_set];
    out->emission_texture = slot->texture;
    for (int k = 0; k < 3; k++) {
        const float none[2] = {0.0f, 0.0f};
        air_texture_slot_uv(slot, uv != NULL ? uv + 2 * (size_t)corners[k] : none, out->uv[k]);
    }
}

void air_emissive_build(const air_mesh *mesh, const air_material *material, uint32_t owner,
                        air_vec3 *vertices, float *certain, air_light *entries)
{
    if (mesh->quadric != NULL) {
        air_quadric_lamp_build(mesh, material, owner, &entries[0]);
        entries[0].vertices = vertices;
        entries[0].triangle_cdf = certain;
        return;
    }
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        air_light *out = &entries[i];
        *out = (air_light){.kind = AIR_LIGHT_POLYGON,
                           .color = material->emission,
                           .triangle_cdf = certain,
                           .one_sided = !material->double_sided,
                           .camera_visible = (mesh->mask & AIR_MASK_CAMERA) != 0,
                           .casts_shadow =
                               true, /* its light is occluded, whether or not it occludes */
                           .owner = owner};
        set_triangle(mesh, mesh->indices + 3 * i, vertices + 3 * i, out);
        if (material->emission_slot.texture != NULL) {
            set_texture(mesh, mesh->indices + 3 * i, &material->emission_slot, out);
        }
    }
}

air_vec3 air_emissive_mean(const air_light *light)
{
    if (light->quadric != NULL) {
        return air_quadric_lamp_mean(light);
    }
    if (light->emission_texture == NULL) {
        return light->color;
    }
    return vec3_mul(light->color, air_texture_triangle_mean(light->emission_texture,
                                                            (const float(*)[2])light->uv));
}

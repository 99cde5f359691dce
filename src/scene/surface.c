#include "scene/surface.h"

#include <float.h>
#include <string.h>

#include "core/random.h"
#include "scene/texture.h"

/* A hit with what it refers to. */
typedef struct hit_place {
    const air_mesh *mesh;
    const air_material *material;
    const uint32_t *corners; /* the triangle's three vertices; NULL: of a quadric */
    float b[3];              /* barycentrics; of cylinders and disks the last two are (u, v) */
    const float *normal;     /* as the hit has it */
} hit_place;

static hit_place find_place(const air_snapshot *snapshot, const air_hit *hit)
{
    const air_mesh *mesh = snapshot->meshes[hit->mesh];
    return (hit_place){.mesh = mesh,
                       .material = &snapshot->materials[mesh->material],
                       .corners =
                           mesh->quadric == NULL ? mesh->indices + 3 * (size_t)hit->triangle : NULL,
                       .b = {1.0f - hit->u - hit->v, hit->u, hit->v},
                       .normal = hit->normal};
}

/* ---- position ---- */

/* Position and offset of a hit; inverse_area2 is 1 over the length of (p1-p0) x (p2-p0).
 *
 * The offset has to exceed the error with which a ray that starts here knows its distance to the
 * triangle's plane, and to the planes of coplanar neighbours. With u = 2^-24, the unit roundoff,
 * and to first order in it:
 *
 * position = p0 + (b1 e1 + b2 e2) is off by u |p| for the last sum and 4 u (|b1 e1| + |b2 e2|) for
 * what it adds, in each coordinate, of which the normal takes its share. Barycentrics that are off
 * move the point within the plane only. Adding the offset rounds once more, u |p|.
 *
 * The vertices of a neighbour that is coplanar but for rounding are off by u |p| each, and its
 * plane by some of that: 4 u |p| is given to it.
 *
 * The ray's distance is Ng . (p0 - o) / |Ng| with edges and Ng in float: off by 3 u |p0 - o| for
 * the sum of products, and by |p0 - o| times the error of Ng's direction, 3 u |e| |e'| / |Ng| with
 * the two shorter edges. As |p0 - o| is at most the longest edge, that is 3 u times the product of
 * the three edges over |Ng|: the diameter D of the circumscribed circle, which is no shorter than
 * any edge.
 *
 * Together u (6 n.|p| + 10 D); FLT_EPSILON is 2 u. */
static void set_triangle_position(const hit_place *place, float inverse_area2, air_vec3 normal,
                                  air_vec3 *out_position, float *out_offset)
{
    const float *positions = place->mesh->positions;
    const air_vec3 p0 = vec3_load(positions + 3 * (size_t)place->corners[0]);
    const air_vec3 e1 = vec3_sub(vec3_load(positions + 3 * (size_t)place->corners[1]), p0);
    const air_vec3 e2 = vec3_sub(vec3_load(positions + 3 * (size_t)place->corners[2]), p0);
    const air_vec3 p = vec3_add(p0, vec3_madd(vec3_scale(e1, place->b[1]), place->b[2], e2));
    const float edges = vec3_length(e1) * vec3_length(e2) * vec3_length(vec3_sub(e2, e1));
    const float coordinate = fabsf(normal.x * p.x) + fabsf(normal.y * p.y) + fabsf(normal.z * p.z);
    *out_position = p;
    *out_offset = FLT_EPSILON * (3.0f * coordinate + 5.0f * (edges * inverse_area2));
}

/* Where a quadric was met, before its map. */
static void find_local(const hit_place *place, double out[3])
{
    const air_quadric *quadric = place->mesh->quadric;
    if (quadric->shape == AIR_RAY_SPHERE)
        air_quadric_sphere_place(quadric, place->normal, out);
    else
        air_quadric_place(quadric->shape, place->b[1], place->b[2], out);
}

/* The same on a quadric. Its place is found in doubles from the normal or from (u, v), whose own
 * rounding moves it along the surface, and rays meet quadrics in doubles: what is left is u n.|p|
 * for rounding the position to floats and as much for adding the offset. Of the neighbours that
 * touch it, disks' coplanar triangles among them, 4 u n.|p| as above. */
static void set_quadric_position(const hit_place *place, air_vec3 normal, air_vec3 *out_position,
                                 float *out_offset)
{
    const air_quadric *quadric = place->mesh->quadric;
    double local[3];
    find_local(place, local);
    const air_vec3 p = air_quadric_to_world(quadric, local);
    *out_position = p;
    *out_offset = 3.0f * FLT_EPSILON *
                  (fabsf(normal.x * p.x) + fabsf(normal.y * p.y) + fabsf(normal.z * p.z));
}

static void set_position(const hit_place *place, float inverse_area2, air_vec3 normal,
                         air_vec3 *out_position, float *out_offset)
{
    if (place->mesh->quadric != NULL) {
        set_quadric_position(place, normal, out_position, out_offset);
    } else {
        set_triangle_position(place, inverse_area2, normal, out_position, out_offset);
    }
}

/* ---- attributes ---- */

/* The barycentric mean of `width` floats per vertex. */
static void interpolate(const hit_place *place, const float *values, size_t width, float *out)
{
    const float *v0 = values + width * place->corners[0];
    const float *v1 = values + width * place->corners[1];
    const float *v2 = values + width * place->corners[2];
    for (size_t i = 0; i < width; ++i)
        out[i] = place->b[0] * v0[i] + place->b[1] * v1[i] + place->b[2] * v2[i];
}

/* A quadric's own coordinates at the hit. */
static void find_quadric_uv(const hit_place *place, float out_uv[2])
{
    double local[3];
    out_uv[0] = place->b[1];
    out_uv[1] = place->b[2];
    if (place->mesh->quadric->shape == AIR_RAY_SPHERE) {
        find_local(place, local);
        air_quadric_uv(AIR_RAY_SPHERE, local, out_uv);
    }
}

/* A slot's coordinates at the hit. Meshes without these coordinates are at (0, 0); quadrics have
 * their own. */
static void find_uv(const hit_place *place, const air_texture_slot *slot, float out_uv[2])
{
    float uv[2] = {0.0f, 0.0f};
    if (place->mesh->quadric != NULL)
        find_quadric_uv(place, uv);
    else if (place->mesh->uv[slot->uv_set] != NULL)
        interpolate(place, place->mesh->uv[slot->uv_set], 2, uv);
    air_texture_slot_uv(slot, uv, out_uv);
}

/* RGBA of a slot's texture at the hit. */
static void sample_slot(const hit_place *place, const air_texture_slot *slot, float out_rgba[4])
{
    float uv[2];
    find_uv(place, slot, uv);
    air_texture_lookup(slot->texture, uv[0], uv[1], out_rgba);
}

/* Base colour and alpha: factor, texture and vertex colour multiplied. */
static void base_color(const hit_place *place, float out_rgba[4])
{
    const air_material *material = place->material;
    vec3_store(out_rgba, material->base_color);
    out_rgba[3] = material->alpha;
    float factor[4];
    if (material->base_color_slot.texture != NULL) {
        sample_slot(place, &material->base_color_slot, factor);
        for (size_t i = 0; i < 4; ++i)
            out_rgba[i] *= factor[i];
    }
    if (place->mesh->colors != NULL) {
        interpolate(place, place->mesh->colors, 4, factor);
        for (size_t i = 0; i < 4; ++i)
            out_rgba[i] *= factor[i];
    }
    if (material->opacity_slot.texture != NULL) {
        sample_slot(place, &material->opacity_slot, factor);
        out_rgba[3] *= factor[0];
    }
}

/* A factor by the red of a slot's texture, if there is one. */
static float scaled(const hit_place *place, const air_texture_slot *slot, float factor)
{
    float rgba[4] = {1.0f};
    if (slot->texture != NULL)
        sample_slot(place, slot, rgba);
    return factor * rgba[0];
}

static float coverage(const air_material *material, float alpha)
{
    if (material->alpha_mode == AIR_ALPHA_OPAQUE)
        return 1.0f;
    if (material->alpha_mode == AIR_ALPHA_MASK)
        return alpha >= material->alpha_cutoff ? 1.0f : 0.0f;
    return float_min(float_max(alpha, 0.0f), 1.0f);
}

float air_surface_alpha(const air_snapshot *snapshot, const air_hit *hit)
{
    const hit_place place = find_place(snapshot, hit);
    if (place.material->alpha_mode == AIR_ALPHA_OPAQUE)
        return 1.0f;
    float rgba[4];
    base_color(&place, rgba);
    return coverage(place.material, rgba[3]);
}

/* ---- normals ---- */

/* The interpolated vertex normal, unit, on the side of the geometric one; that one where there is
 * none. Files whose normals point to the back of their triangles are common. */
static air_vec3 shading_normal(const hit_place *place, air_vec3 geometric)
{
    if (place->mesh->normals == NULL)
        return geometric;
    float values[3];
    interpolate(place, place->mesh->normals, 3, values);
    const air_vec3 n = vec3_load(values);
    const float length = vec3_length(n);
    if (!(length > 1e-6f)) /* normals that cancel have no direction but that of rounding */
        return geometric;
    const float side = vec3_dot(n, geometric) < 0.0f ? -1.0f : 1.0f;
    return vec3_scale(n, side / length);
}

/* Two ways from a place on the surface, the triangle's edges or a quadric's slopes, and how a
 * slot's coordinates change along them. */
typedef struct uv_edges {
    air_vec3 e1, e2;
    float u1, v1, u2, v2;
} uv_edges;

/* False if there are no coordinates. */
static bool find_uv_edges(const hit_place *place, const air_texture_slot *slot, uv_edges *out)
{
    const air_mesh *mesh = place->mesh;
    const float *uv = mesh->uv[slot->uv_set];
    air_vec3 p[3];
    float at[3][2], own[2] = {0.0f, 0.0f};
    if (mesh->quadric == NULL && uv == NULL)
        return false;
    if (mesh->quadric != NULL)
        find_quadric_uv(place, own);
    const float u = own[0], v = own[1];
    const float corners[3][2] = {{u, v}, {u + 1.0f, v}, {u, v + 1.0f}};
    for (size_t i = 0; i < 3; ++i) {
        if (mesh->quadric == NULL)
            p[i] = vec3_load(mesh->positions + 3 * (size_t)place->corners[i]);
        air_texture_slot_uv(
            slot, mesh->quadric != NULL ? corners[i] : uv + 2 * (size_t)place->corners[i], at[i]);
    }
    if (mesh->quadric != NULL) {
        air_quadric_slopes(mesh->quadric, u, v, &out->e1, &out->e2);
    } else {
        out->e1 = vec3_sub(p[1], p[0]);
        out->e2 = vec3_sub(p[2], p[0]);
    }
    out->u1 = at[1][0] - at[0][0];
    out->v1 = at[1][1] - at[0][1];
    out->u2 = at[2][0] - at[0][0];
    out->v2 = at[2][1] - at[0][1];
    return true;
}

/* dp/du and dp/dv times the area in uv. */
static air_vec3 along_u(const uv_edges *e)
{
    return vec3_sub(vec3_scale(e->e1, e->v2), vec3_scale(e->e2, e->v1));
}

static air_vec3 along_v(const uv_edges *e)
{
    return vec3_sub(vec3_scale(e->e2, e->u1), vec3_scale(e->e1, e->u2));
}

static float uv_area(const uv_edges *e) { return e->u1 * e->v2 - e->u2 * e->v1; }

/* The directions in which the normal map's coordinates grow, from how its texture lies on the
 * surface; v runs downwards, so the map's y axis is -dp/dv. *sign is that of the bitangent against
 * normal x tangent. */
static air_vec3 tangent_from_uv(const hit_place *place, air_vec3 normal, float *sign)
{
    uv_edges edges;
    if (!find_uv_edges(place, &place->material->normal_slot, &edges))
        return vec3_set1(0.0f);
    /* the sign of the area is put back */
    const float turn = uv_area(&edges) < 0.0f ? -1.0f : 1.0f;
    const air_vec3 tangent = vec3_scale(along_u(&edges), turn);
    const air_vec3 against_v = vec3_scale(along_v(&edges), -turn);
    *sign = vec3_dot(vec3_cross(normal, tangent), against_v) < 0.0f ? -1.0f : 1.0f;
    return tangent;
}

/* Turns the shading normal by the normal map. */
static air_vec3 mapped_normal(const hit_place *place, air_vec3 normal, air_vec3 geometric)
{
    float sign = 1.0f, rgba[4];
    air_vec3 tangent;
    if (place->mesh->tangents != NULL) {
        float values[4];
        interpolate(place, place->mesh->tangents, 4, values);
        tangent = vec3_load(values);
        sign = values[3] < 0.0f ? -1.0f : 1.0f;
    } else {
        tangent = tangent_from_uv(place, normal, &sign);
    }
    tangent = vec3_madd(tangent, -vec3_dot(tangent, normal), normal);
    const float length = vec3_length(tangent);
    if (!(length > 0.0f))
        return normal;
    tangent = vec3_scale(tangent, 1.0f / length);
    const air_vec3 bitangent = vec3_scale(vec3_cross(normal, tangent), sign);

    sample_slot(place, &place->material->normal_slot, rgba);
    const float scale = place->material->normal_scale;
    const air_vec3 local = vec3((2.0f * rgba[0] - 1.0f) * scale, (2.0f * rgba[1] - 1.0f) * scale,
                                2.0f * rgba[2] - 1.0f);
    air_vec3 mapped =
        vec3_madd(vec3_madd(vec3_scale(tangent, local.x), local.y, bitangent), local.z, normal);
    /* a map may point below the triangle: lift it to just above, or the reflection would turn it
     * round */
    const float mapped_length = vec3_length(mapped);
    if (!(mapped_length > 0.0f))
        return normal;
    mapped = vec3_scale(mapped, 1.0f / mapped_length);
    const float height = vec3_dot(mapped, geometric);
    if (height < 0.01f)
        mapped = vec3_normalize(vec3_madd(mapped, 0.01f - height, geometric));
    return mapped;
}

/* ---- bumps ---- */

/* How the position changes with a slot's coordinates; false where they do not span the surface. */
static bool uv_derivatives(const hit_place *place, const air_texture_slot *slot, air_vec3 *out_du,
                           air_vec3 *out_dv)
{
    uv_edges edges;
    if (!find_uv_edges(place, slot, &edges))
        return false;
    const float inverse = 1.0f / uv_area(&edges);
    *out_du = vec3_scale(along_u(&edges), inverse);
    *out_dv = vec3_scale(along_v(&edges), inverse);
    return isfinite(inverse);
}

/* The slope of red along u or v between the texels about the hit: that of the bilinear filter. */
static float height_slope(const air_texture *texture, const float uv[2], size_t axis)
{
    const float texels = (float)(axis == 0 ? texture->width : texture->height);
    float low[4], high[4], at[2] = {uv[0], uv[1]};
    const float before = floorf(uv[axis] * texels - 0.5f) + 0.5f;
    at[axis] = before / texels;
    air_texture_lookup(texture, at[0], at[1], low);
    at[axis] = (before + 1.0f) / texels;
    air_texture_lookup(texture, at[0], at[1], high);
    return (high[0] - low[0]) * texels;
}

/* The normal of the surface moved along its normal by the height map. */
static air_vec3 bumped_normal(const hit_place *place, air_vec3 normal)
{
    const air_texture_slot *slot = &place->material->bump_slot;
    const float scale = place->material->bump_scale;
    air_vec3 du, dv;
    float uv[2];
    if (!uv_derivatives(place, slot, &du, &dv))
        return normal;
    find_uv(place, slot, uv);
    /* within the surface du and dv lie across the normal; heights raise them along it */
    const float rise_u = scale * height_slope(slot->texture, uv, 0) - vec3_dot(du, normal);
    const float rise_v = scale * height_slope(slot->texture, uv, 1) - vec3_dot(dv, normal);
    const air_vec3 n = vec3_cross(vec3_madd(du, rise_u, normal), vec3_madd(dv, rise_v, normal));
    const float length = vec3_length(n);
    if (!(length > 0.0f))
        return normal;
    return vec3_scale(n, (vec3_dot(n, normal) < 0.0f ? -1.0f : 1.0f) / length);
}

/* ---- one of several models ---- */

/* An even number that is the same whenever the same ray meets the same place: what is blended is
 * chosen by it, which on the mean over places gives the blend. */
static float chance(air_vec3 position, air_vec3 dir, uint32_t purpose)
{
    const float keys[6] = {position.x, position.y, position.z, dir.x, dir.y, dir.z};
    uint32_t hash = purpose;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        uint32_t bits;
        memcpy(&bits, &keys[i], sizeof bits);
        hash = air_hash_combine(hash, bits);
    }
    return air_uint_to_float(hash);
}

static const air_material *blended(const hit_place *place, air_vec3 position, air_vec3 dir)
{
    const air_material *material = place->material;
    if (material->model != AIR_MATERIAL_BLEND)
        return material;
    const float second = scaled(place, &material->blend_slot, material->blend_weight);
    return material->blend[chance(position, dir, 1) < second];
}

/* KHR_materials_transmission: glass instead of the base, by a weight. The glass is chosen by
 * chance; what is left has more metal in it. */
static void choose_glass(const hit_place *place, air_vec3 position, air_vec3 dir,
                         air_bsdf_input *input)
{
    const air_material *material = place->material;
    const float share = (1.0f - input->metallic) *
                        scaled(place, &material->transmission_slot, material->transmission);
    if (chance(position, dir, 2) >= share) {
        input->metallic = float_min(input->metallic / (1.0f - share), 1.0f);
        return;
    }
    const float alpha = input->roughness * input->roughness;
    input->model = material->thin_walled ? AIR_MATERIAL_THIN_DIELECTRIC : AIR_MATERIAL_DIELECTRIC;
    input->single = true;
    input->facets = air_facets_make(AIR_MICROFACETS_GGX, alpha, alpha);
    input->reflectance = vec3_set1(material->specular);
    input->transmittance = input->base_color;
}

/* What the models behind METALLIC_ROUGHNESS need. */
static void set_optics(const hit_place *place, air_bsdf_input *input)
{
    const air_optics *optics = &place->material->optics;
    const air_texture_slot plain = {.uv_transform = {1, 0, 0, 0, 1, 0}};
    air_vec3 across;
    input->optics = optics;
    input->facets = optics->facets;
    input->reflectance = optics->reflectance;
    input->transmittance = optics->transmittance;
    if (optics->facets.alpha_u != optics->facets.alpha_v &&
        !uv_derivatives(place, &plain, &input->tangent, &across))
        input->tangent = vec3_set1(0.0f);
}

/* ---- the whole ---- */

/* What is the material's own even where it blends others. */
static void set_own(const hit_place *place, bool front, air_surface *out)
{
    const air_material *material = place->material;
    float rgba[4];
    out->emission = front || material->double_sided ? material->emission : vec3_set1(0.0f);
    out->alpha = 1.0f;
    if (material->alpha_mode != AIR_ALPHA_OPAQUE) {
        base_color(place, rgba);
        out->alpha = coverage(material, rgba[3]);
    }
    if (material->emission_slot.texture != NULL && !vec3_is_zero(out->emission)) {
        sample_slot(place, &material->emission_slot, rgba);
        out->emission = vec3_mul(out->emission, vec3_load(rgba));
    }
}

static void set_textured(const hit_place *place, air_bsdf_input *input)
{
    const air_material *material = place->material;
    float rgba[4];
    base_color(place, rgba);
    input->base_color = vec3_load(rgba);
    if (material->metallic_roughness_slot.texture != NULL) {
        sample_slot(place, &material->metallic_roughness_slot, rgba);
        input->roughness *= rgba[1];
        input->metallic *= rgba[2];
    }
    if (material->normal_slot.texture != NULL)
        input->shading_normal =
            mapped_normal(place, input->shading_normal, input->geometric_normal);
    if (material->bump_slot.texture != NULL)
        input->shading_normal = bumped_normal(place, input->shading_normal);
}

void air_surface_make(const air_snapshot *snapshot, const air_hit *hit, air_vec3 dir,
                      air_surface *out)
{
    hit_place place = find_place(snapshot, hit);
    const air_mesh *mesh = place.mesh;

    const air_vec3 area2 = vec3_load(hit->normal);
    const float inverse_area2 = 1.0f / vec3_length(area2);
    out->normal = vec3_scale(area2, mesh->flip ? -inverse_area2 : inverse_area2);
    set_position(&place, inverse_area2, out->normal, &out->position, &out->offset);

    set_own(&place, vec3_dot(out->normal, dir) < 0.0f, out);
    out->emitter =
        mesh->first_emitter == UINT32_MAX ? UINT32_MAX : mesh->first_emitter + hit->triangle;

    const air_material *material = place.material = blended(&place, out->position, dir);
    air_bsdf_input input = {.model = material->model,
                            .base_color = material->base_color,
                            .metallic = material->metallic,
                            .roughness = material->roughness,
                            .specular = material->specular,
                            .ior = material->ior,
                            .shading_normal = shading_normal(&place, out->normal),
                            .geometric_normal = out->normal,
                            .wo = vec3_neg(dir),
                            .one_sided = material->one_sided};
    if (material->textured || mesh->colors != NULL)
        set_textured(&place, &input);
    if (material->model != AIR_MATERIAL_METALLIC_ROUGHNESS)
        set_optics(&place, &input);
    else if (material->transmission > 0.0f)
        choose_glass(&place, out->position, dir, &input);
    if (material->unlit) {
        /* a picture of itself, from both sides */
        out->emission = input.base_color;
        input.model = AIR_MATERIAL_METALLIC_ROUGHNESS;
        input.base_color = vec3_set1(0.0f);
        input.metallic = 0.0f;
        input.specular = 0.0f;
    }
    air_bsdf_make(&input, &out->bsdf);
}

bool air_surface_place_make(const air_mesh *mesh, uint32_t triangle, float u, float v,
                            air_surface_place *out)
{
    const hit_place place = {
        .mesh = mesh, .corners = mesh->indices + 3 * (size_t)triangle, .b = {1.0f - u - v, u, v}};
    const air_vec3 p0 = vec3_load(mesh->positions + 3 * (size_t)place.corners[0]);
    const air_vec3 p1 = vec3_load(mesh->positions + 3 * (size_t)place.corners[1]);
    const air_vec3 p2 = vec3_load(mesh->positions + 3 * (size_t)place.corners[2]);
    const air_vec3 area2 = vec3_cross(vec3_sub(p1, p0), vec3_sub(p2, p0));
    const float length = vec3_length(area2);
    if (!(length > 0.0f) || !isfinite(length))
        return false;
    out->geometric = vec3_scale(area2, mesh->flip ? -1.0f / length : 1.0f / length);
    out->normal = shading_normal(&place, out->geometric);
    set_position(&place, 1.0f / length, out->geometric, &out->position, &out->offset);
    return true;
}

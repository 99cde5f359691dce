/* gltf_show.c: materials of a glTF file that show a lightmap. */
#include "lightmap/gltf_show.h"

#include <math.h>
#include <string.h>

/* Lumens per watt, by which scenes in photometric units were divided. */
static const double luminous_efficacy = 683.0;
static const double pi = 3.14159265358979323846;

/* The material's JSON, NULL for the default one. */
static json_t *find(const air_gltf_show *self, size_t material)
{
    return json_array_get(json_object_get(self->copy->json, "materials"), material);
}

/* What emission and irradiance are multiplied by to be in the file's units. */
static double unit(const air_gltf_show *self)
{
    return (double)self->params.scale * (self->lightmap->photometric ? luminous_efficacy : 1.0);
}

air_status air_gltf_show_wanted(const air_gltf_show *self, size_t material, bool *out_wanted)
{
    const json_t *json = find(self, material);
    const json_t *extensions = json_object_get(json, "extensions");
    const json_t *factor = json_object_get(json, "emissiveFactor");
    *out_wanted = true;
    if (material != SIZE_MAX && !json_is_object(json)) {
        const air_place root = air_gltf_copy_root(self->copy);
        const air_place list = air_place_get(&root, "materials");
        const air_place at = air_place_at(&list, material);
        return air_place_wrong(&at, "a material");
    }
    if (json_object_get(extensions, "KHR_materials_unlit") != NULL) {
        *out_wanted = self->params.show == AIR_SHOW_COORDINATES;
    }
    for (size_t c = 0; c < 3 && self->params.show == AIR_SHOW_EMISSIVE; c++) {
        if (json_number_value(json_array_get(factor, c)) > 0.0) {
            *out_wanted = false;
        }
    }
    return AIR_OK;
}

/* Does a textureInfo anywhere below use the set? With `moved` it then uses that one. */
static bool uses_set(json_t *json, size_t moved)
{
    bool uses = false;
    const char *key;
    json_t *value;
    size_t index;
    if (json_is_array(json)) {
        json_array_foreach(json, index, value) { uses = uses_set(value, moved) || uses; }
    }
    json_object_foreach(json, key, value)
    {
        if (strcmp(key, "extras") == 0) {
            continue;
        }
        if (strcmp(key, "texCoord") == 0 && json_integer_value(value) == AIR_GLTF_SET) {
            uses = true;
            if (moved != AIR_GLTF_SET) {
                json_integer_set(value, (json_int_t)moved);
            }
        } else {
            uses = uses_set(value, moved) || uses;
        }
    }
    return uses;
}

bool air_gltf_show_uses_set(const air_gltf_show *self, size_t material)
{
    return uses_set(find(self, material), AIR_GLTF_SET);
}

/* A member object, made where it is missing. */
static json_t *member(json_t *object, const char *key)
{
    json_t *value = json_object_get(object, key);
    if (!json_is_object(value)) {
        json_object_set_new(object, key, json_object());
        value = json_object_get(object, key);
    }
    return value;
}

/* Reads a factor of three or four numbers, 1 where it is absent, and makes its colour black. */
static void take_colour(json_t *object, const char *key, double out[3])
{
    const json_t *old = json_object_get(object, key);
    json_t *black = json_array();
    const json_t *alpha = json_array_get(old, 3);
    for (size_t c = 0; c < 3; c++) {
        const json_t *number = json_array_get(old, c);
        out[c] = json_is_number(number) ? fmin(fmax(json_number_value(number), 0.0), 1.0) : 1.0;
        json_array_append_new(black, json_real(0.0));
    }
    json_array_append_new(black, json_real(json_is_number(alpha) ? json_number_value(alpha) : 1.0));
    json_object_set_new(object, key, black);
}

/* Makes the diffuse colour black; what it was, as far as factors say, goes to out. */
static void take_diffuse(air_gltf_show *self, json_t *material, bool has_albedo, double out[3])
{
    json_t *glossiness = json_object_get(json_object_get(material, "extensions"),
                                         "KHR_materials_pbrSpecularGlossiness");
    json_t *pbr = member(material, "pbrMetallicRoughness");
    const json_t *metallic = json_object_get(pbr, "metallicFactor");
    const bool textured = json_object_get(pbr, "baseColorTexture") != NULL;
    const bool metal_textured = json_object_get(pbr, "metallicRoughnessTexture") != NULL;
    take_colour(pbr, "baseColorFactor", out);
    if (json_is_object(glossiness)) {
        take_colour(glossiness, "diffuseFactor", out);
    } else if (!metal_textured) {
        const double metal = json_is_number(metallic) ? json_number_value(metallic) : 1.0;
        for (size_t c = 0; c < 3; c++) {
            out[c] *= fmin(fmax(1.0 - metal, 0.0), 1.0);
        }
    }
    if (has_albedo) {
        out[0] = out[1] = out[2] = 1.0;
    } else if (textured || metal_textured ||
               json_object_get(glossiness, "diffuseTexture") != NULL) {
        self->guessed = true;
    }
}

static json_t *texture_info(const air_gltf_page *page)
{
    json_t *info = json_object();
    json_object_set_new(info, "index", json_integer((json_int_t)page->texture));
    json_object_set_new(info, "texCoord", json_integer(AIR_GLTF_SET));
    return info;
}

/* emission = factor x strength x texture, factors in [0, 1]. */
static air_status make_emissive(air_gltf_show *self, json_t *material, const air_gltf_page *page)
{
    const double strength = (double)page->peak * unit(self);
    double tint[3];
    json_t *factor = json_array();
    take_diffuse(self, material, page->has_albedo, tint);
    for (size_t c = 0; c < 3; c++) {
        json_array_append_new(factor, json_real(tint[c] * fmin(strength, 1.0)));
    }
    json_object_set_new(material, "emissiveFactor", factor);
    json_object_set_new(material, "emissiveTexture", texture_info(page));
    json_object_del(json_object_get(material, "extensions"), "KHR_materials_emissive_strength");
    if (!(strength > 1.0)) {
        return AIR_OK;
    }
    json_t *extension = member(member(material, "extensions"), "KHR_materials_emissive_strength");
    json_object_set_new(extension, "emissiveStrength", json_real(strength));
    return air_gltf_copy_use_extension(self->copy, "KHR_materials_emissive_strength");
}

/* Irradiance = intensity x texture. */
static air_status make_lightmap(air_gltf_show *self, json_t *material, const air_gltf_page *page)
{
    json_t *extension = texture_info(page);
    json_object_set_new(extension, "intensity", json_real(pi * (double)page->peak * unit(self)));
    json_object_set_new(member(material, "extensions"), "MOZ_lightmap", extension);
    return air_gltf_copy_use_extension(self->copy, "MOZ_lightmap");
}

static air_status remember(air_gltf_show *self, const air_gltf_material *entry)
{
    if (self->material_count == self->material_capacity) {
        const size_t capacity = 2 * self->material_capacity + 8;
        air_gltf_material *grown =
            air_reallocate(self->copy->context, self->materials, capacity, sizeof *self->materials);
        if (grown == NULL) {
            return air_fail_memory(self->copy->context, self->copy->path);
        }
        self->materials = grown;
        self->material_capacity = capacity;
    }
    self->materials[self->material_count++] = *entry;
    return AIR_OK;
}

static void rename_copy(json_t *material, size_t page)
{
    const char *name = json_string_value(json_object_get(material, "name"));
    if (name != NULL) {
        json_object_set_new(material, "name", json_sprintf("%s-lightmap-%zu", name, page));
    }
}

air_status air_gltf_show_material(air_gltf_show *self, size_t material, size_t page, size_t moved,
                                  size_t *out_index)
{
    for (size_t i = 0; i < self->material_count; i++) {
        const air_gltf_material *known = &self->materials[i];
        if (known->source == material && known->page == page && known->moved == moved) {
            *out_index = known->index;
            return AIR_OK;
        }
    }
    json_t *source = find(self, material);
    json_t *copy = source != NULL ? json_deep_copy(source) : json_object();
    if (copy == NULL) {
        return air_fail_memory(self->copy->context, self->copy->path);
    }
    if (self->params.show != AIR_SHOW_COORDINATES) {
        rename_copy(copy, page);
    }
    if (moved != AIR_GLTF_SET) {
        (void)uses_set(copy, moved);
    }
    air_gltf_material entry = {material, page, moved, 0};
    air_status status = AIR_OK;
    if (self->params.show == AIR_SHOW_EMISSIVE) {
        status = make_emissive(self, copy, &self->pages[page]);
    } else if (self->params.show == AIR_SHOW_LIGHTMAP) {
        status = make_lightmap(self, copy, &self->pages[page]);
    }
    if (status != AIR_OK) {
        json_decref(copy);
        return status;
    }
    status = air_gltf_copy_append(self->copy, "materials", copy, &entry.index);
    *out_index = entry.index;
    return status == AIR_OK ? remember(self, &entry) : status;
}

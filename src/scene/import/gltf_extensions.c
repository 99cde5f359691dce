#include <string.h>

#include "scene/import/gltf.h"

static const char *const supported_extensions[] = {
    "KHR_texture_transform",      "KHR_materials_emissive_strength",
    "KHR_materials_unlit",        "KHR_materials_ior",
    "KHR_materials_specular",     "KHR_materials_pbrSpecularGlossiness",
    "KHR_lights_punctual",        "KHR_mesh_quantization",
    "KHR_materials_transmission", "KHR_materials_volume",
};

/* Extensions that say nothing about the picture: left out without a word when merely used. */
static const char *const silent_extensions[] = {
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_materials_variants",
};

/* What leaving out an extension means for the picture. */
static const struct {
    const char *name, *consequence;
} ignored_extensions[] = {
    {"KHR_materials_diffuse_transmission", "these surfaces are shown opaque"},
    {"KHR_materials_volume_scatter", "scattering inside these objects is left out"},
    {"KHR_materials_clearcoat", "the coat is left out"},
    {"KHR_materials_sheen", "the sheen is left out"},
    {"KHR_materials_iridescence", "the thin film is left out"},
    {"KHR_materials_anisotropy", "highlights are isotropic"},
    {"KHR_materials_dispersion", "dispersion is left out"},
    {"KHR_node_visibility", "hidden nodes are shown"},
    {"EXT_mesh_gpu_instancing", "each instanced mesh is shown once"},
    {"EXT_texture_webp", "only textures with a PNG or JPEG fallback are shown"},
    {"KHR_texture_basisu", "only textures with a PNG or JPEG fallback are shown"},
    {"MSFT_texture_dds", "only textures with a PNG or JPEG fallback are shown"},
    {"EXT_lights_image_based", "its light is left out; give an environment in a sidecar"},
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static bool is_listed(const char *name, const char *const *names, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        if (strcmp(name, names[i]) == 0)
            return true;
    return false;
}

static bool is_supported(const char *name)
{
    return is_listed(name, supported_extensions, COUNT(supported_extensions));
}

static air_status check_required(air_gltf *gltf)
{
    const air_json required = air_json_get(&gltf->root, "extensionsRequired");
    air_status status = air_json_check_array(&required, false);
    for (size_t i = 0; i < air_json_count(&required) && status == AIR_OK; ++i) {
        const air_json at = air_json_at(&required, i);
        const char *name = "";
        status = air_json_string(&at, &name);
        if (status == AIR_OK && !is_supported(name))
            status = air_json_fail(&at, AIR_ERROR_UNSUPPORTED,
                                   "the file requires the extension %.64s, which is not supported",
                                   name);
    }
    return status;
}

static air_status warn_ignored(air_gltf *gltf, const char *name)
{
    for (size_t i = 0; i < COUNT(ignored_extensions); ++i)
        if (strcmp(name, ignored_extensions[i].name) == 0)
            return air_import_warn(gltf->import, "%s: the extension %s is not supported: %s",
                                   gltf->path, name, ignored_extensions[i].consequence);
    return air_import_warn(gltf->import, "%s: the extension %.64s is not known and left out",
                           gltf->path, name);
}

static air_status warn_used(air_gltf *gltf)
{
    const air_json used = air_json_get(&gltf->root, "extensionsUsed");
    air_status status = air_json_check_array(&used, false);
    for (size_t i = 0; i < air_json_count(&used) && status == AIR_OK; ++i) {
        const air_json at = air_json_at(&used, i);
        const char *name = "";
        status = air_json_string(&at, &name);
        if (status == AIR_OK && !is_supported(name) &&
            !is_listed(name, silent_extensions, COUNT(silent_extensions)))
            status = warn_ignored(gltf, name);
    }
    return status;
}

air_status air_gltf_check_asset(air_gltf *gltf)
{
    const air_json asset = air_json_get(&gltf->root, "asset");
    const air_json version = air_json_get(&asset, "version");
    const air_json least = air_json_get(&asset, "minVersion");
    const char *text = "", *least_text = "2.0";
    air_status status = air_json_check_object(&asset, true);
    if (status == AIR_OK)
        status = air_json_string(&version, &text);
    if (status == AIR_OK)
        status = air_json_string(&least, &least_text);
    if (status != AIR_OK)
        return status;
    if (strncmp(text, "2.", 2) != 0 && strcmp(text, "2") != 0)
        return air_json_expected(&version, "glTF version \"2.0\"");
    if (strcmp(least_text, "2.0") != 0)
        return air_json_expected(&least, "at most glTF version \"2.0\"");
    status = check_required(gltf);
    return status == AIR_OK ? warn_used(gltf) : status;
}

bool air_gltf_from_blender(const air_gltf *gltf)
{
    const air_json asset = air_json_get(&gltf->root, "asset");
    const json_t *generator = json_object_get(asset.value, "generator");
    const char *text = json_is_string(generator) ? json_string_value(generator) : "";
    /* "Khronos glTF Blender I/O v4.0.44", "Khronos Blender glTF 2.0 exporter", "Khronos Blender
     * glTF 2.0 I/O" */
    return strstr(text, "Khronos") != NULL && strstr(text, "Blender") != NULL;
}

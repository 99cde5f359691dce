/* What a snapshot holds, as JSON. */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/render.h"
#include "scene/light_record.h"
#include "scene/material.h"
#include "scene/media/grid.h"
#include "scene/mesh.h"
#include "scene/snapshot.h"

/* ---- values ---- */

/* The shortest decimal number that is this float, so that 0.1f reads 0.1; null for what JSON cannot
 * say. */
static json_t *number(float value)
{
    char text[32];
    double decimal = (double)value;
    if (!isfinite(value))
        return json_null();
    for (int digits = 6; digits <= 9; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        decimal = strtod(text, NULL);
        if ((float)decimal == value)
            break;
    }
    return json_real(decimal);
}

static json_t *numbers(const float *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; ++i)
        json_array_append_new(array, number(values[i]));
    return array;
}

static json_t *vector(air_vec3 v)
{
    const float values[3] = {v.x, v.y, v.z};
    return numbers(values, 3);
}

static json_t *integer(size_t value) { return json_integer((json_int_t)value); }

/* Names come from files: what is not UTF-8 has its bytes beyond ASCII replaced. */
static json_t *string(const char *text)
{
    json_t *value = json_string(text);
    if (value != NULL)
        return value;
    char ascii[256];
    size_t i = 0;
    for (; text[i] != '\0' && i + 1 < sizeof ascii; ++i)
        ascii[i] = (unsigned char)text[i] < 128 ? text[i] : '?';
    ascii[i] = '\0';
    return json_string(ascii);
}

static json_t *bounds(const float low[3], const float high[3])
{
    if (!(low[0] <= high[0]))
        return json_null();
    return json_pack("{s:o, s:o}", "min", numbers(low, 3), "max", numbers(high, 3));
}

/* Sets a member only where it says something. */
static void set_if(json_t *object, bool condition, const char *key, json_t *value)
{
    if (condition)
        json_object_set_new(object, key, value);
    else
        json_decref(value);
}

/* ---- objects ---- */

static json_t *describe_meshes(const air_snapshot *snapshot)
{
    json_t *array = json_array();
    for (size_t i = 0; i < snapshot->mesh_count; ++i) {
        const air_mesh *mesh = snapshot->meshes[i];
        json_t *object = json_object();
        json_object_set_new(object, "name", string(mesh->name));
        if (mesh->quadric == NULL)
            json_object_set_new(object, "triangles", integer(mesh->triangle_count));
        else
            json_object_set_new(object, "shape",
                                json_string(air_shape_names[mesh->quadric->shape]));
        set_if(object, mesh->material > 0, "material",
               string(snapshot->materials[mesh->material].name));
        set_if(object, mesh->first_emitter != UINT32_MAX, "emits", json_true());
        set_if(object, (mesh->mask & AIR_MASK_CAMERA) == 0, "camera_visible", json_false());
        set_if(object, (mesh->mask & (AIR_MASK_SHADOW_OPAQUE | AIR_MASK_SHADOW_ALPHA)) == 0,
               "casts_shadow", json_false());
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *describe_materials(const air_snapshot *snapshot)
{
    static const char *const alpha_modes[] = {"opaque", "mask", "blend"};
    json_t *array = json_array();
    for (size_t i = 1; i < snapshot->material_count; ++i) { /* 0 is the default one, in no file */
        const air_material *material = &snapshot->materials[i];
        json_t *object = json_object();
        json_object_set_new(object, "name", string(material->name));
        json_object_set_new(object, "base_color", vector(material->base_color));
        json_object_set_new(object, "metallic", number(material->metallic));
        json_object_set_new(object, "roughness", number(material->roughness));
        set_if(object, !vec3_is_zero(material->emission), "emission", vector(material->emission));
        set_if(object, material->model != AIR_MATERIAL_METALLIC_ROUGHNESS, "model",
               json_string(air_material_model_names[material->model]));
        set_if(object, material->transmission > 0.0f, "transmission",
               number(material->transmission));
        set_if(object, material->textured, "textured", json_true());
        set_if(object, material->alpha_mode != AIR_ALPHA_OPAQUE, "alpha_mode",
               json_string(alpha_modes[material->alpha_mode]));
        set_if(object, material->double_sided, "double_sided", json_true());
        set_if(object, material->unlit, "unlit", json_true());
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *describe_light(const air_light *light)
{
    static const char *const units[] = {"W/sr",       "W/sr",       "W/m^2",
                                        "W/(m^2 sr)", "W/(m^2 sr)", "W/sr"};
    const bool placed = air_light_is_placed(light);
    const bool directed = light->kind == AIR_LIGHT_SPOT || light->kind == AIR_LIGHT_COLLIMATED;
    const bool polygon = light->kind == AIR_LIGHT_POLYGON;
    const bool seen = polygon || light->kind == AIR_LIGHT_ENVIRONMENT;
    json_t *object = json_object();
    json_object_set_new(object, "name", string(light->name));
    json_object_set_new(object, "kind", json_string(air_light_kind_names[light->kind]));
    json_object_set_new(object, "color", vector(light->color));
    json_object_set_new(object, "units", json_string(units[light->kind]));
    set_if(object, placed, "position", vector(light->position));
    set_if(object, directed, "dir", vector(light->dir));
    set_if(object, light->window_count > 0, "windows", integer(light->window_count));
    set_if(object, polygon, "vertices", integer(light->vertex_count));
    set_if(object, polygon, "area", number(light->area));
    set_if(object, polygon, "one_sided", json_boolean(light->one_sided));
    set_if(object, light->environment != NULL, "image", json_true());
    set_if(object, seen && !light->camera_visible, "camera_visible", json_false());
    set_if(object, !light->casts_shadow, "casts_shadow", json_false());
    return object;
}

/* Explicit lights, and emissive meshes as one light behind them. */
static json_t *describe_lights(const air_snapshot *snapshot)
{
    const air_light_table *table = &snapshot->lights;
    json_t *array = json_array();
    for (size_t i = 0; i < table->explicit_count; ++i)
        json_array_append_new(array, describe_light(&table->entries[i]));
    if (table->count > table->explicit_count)
        json_array_append_new(array, json_pack("{s:s, s:s, s:o, s:s}", "name", "emissive meshes",
                                               "kind", "emissive", "triangles",
                                               integer(air_light_triangle_count(table)), "units",
                                               "W/(m^2 sr)"));
    return array;
}

static json_t *describe_grid(const air_grid *grid)
{
    size_t size[3];
    air_grid_size(grid, size);
    return json_pack("{s:[o, o, o], s:o, s:o, s:o}", "size", integer(size[0]), integer(size[1]),
                     integer(size[2]), "channels", integer(air_grid_channels(grid)), "bytes",
                     integer(air_grid_bytes(grid)), "max", number(air_grid_max(grid)));
}

static json_t *describe_lobe(air_phase_kind kind, float g)
{
    static const char *const kinds[] = {"isotropic", "hg", "rayleigh", "mixture"};
    json_t *object = json_pack("{s:s}", "kind", kinds[kind]);
    set_if(object, kind == AIR_PHASE_HG, "g", number(g));
    return object;
}

static json_t *describe_phase(air_phase phase)
{
    json_t *object = describe_lobe(phase.kind, phase.g);
    if (phase.kind != AIR_PHASE_MIXTURE)
        return object;
    json_t *lobes = json_array();
    for (size_t i = 0; i < phase.mixture->lobe_count; ++i) {
        const air_phase_lobe *lobe = &phase.mixture->lobes[i];
        json_t *described = describe_lobe(lobe->kind, lobe->g);
        json_object_set_new(described, "weight", number(lobe->weight));
        json_array_append_new(lobes, described);
    }
    json_object_set_new(object, "lobes", lobes);
    return object;
}

static json_t *describe_detail(const air_detail_field *detail)
{
    return json_pack("{s:o, s:o, s:o}", "strength", number(detail->strength), "scale",
                     number(detail->feature_m), "octaves", integer(detail->octaves));
}

static json_t *describe_medium(const air_medium *medium)
{
    static const char *const boundaries[] = {"unbounded", "box", "convex", "mesh", "ellipsoid"};
    static const char *const densities[] = {"constant", "layered", "exponential", "grid"};
    const bool exponential = medium->declared_kind == AIR_DENSITY_EXPONENTIAL;
    json_t *object = json_object();
    json_object_set_new(object, "name", string(medium->name));
    json_object_set_new(object, "boundary", json_string(boundaries[medium->boundary]));
    json_object_set_new(object, "density", json_string(densities[medium->declared_kind]));
    json_object_set_new(object, "sigma_s", vector(medium->sigma_s));
    json_object_set_new(object, "sigma_a", vector(medium->sigma_a));
    set_if(object, !vec3_is_zero(medium->emission), "emission", vector(medium->emission));
    json_object_set_new(object, "phase", describe_phase(medium->phase));
    set_if(object, exponential, "base_height", number(medium->base_height));
    set_if(object, exponential, "scale_height", number(1.0f / medium->inverse_scale_height));
    if (air_medium_is_detailed(medium))
        json_object_set_new(object, "detail", describe_detail(&medium->detail));
    if (medium->density_grid != NULL)
        json_object_set_new(object, "grid", describe_grid(medium->density_grid));
    if (medium->albedo_grid != NULL)
        json_object_set_new(object, "albedo_grid", describe_grid(medium->albedo_grid));
    if (medium->emission_grid != NULL)
        json_object_set_new(object, "emission_grid", describe_grid(medium->emission_grid));
    json_object_set_new(object, "combine",
                        json_string(medium->combine == AIR_COMBINE_REPLACE ? "replace" : "add"));
    set_if(object, medium->combine == AIR_COMBINE_REPLACE, "priority",
           json_integer(medium->priority));
    const bool bounded = medium->boundary != AIR_BOUNDARY_UNBOUNDED ||
                         isfinite(medium->bounds_min[0]); /* by its grid */
    set_if(object, bounded, "bounds", bounds(medium->bounds_min, medium->bounds_max));
    return object;
}

static json_t *describe_media(const air_snapshot *snapshot)
{
    json_t *array = json_array();
    for (size_t i = 0; i < snapshot->media.count; ++i)
        json_array_append_new(array, describe_medium(&snapshot->media.media[i]));
    return array;
}

static json_t *describe_cameras(const air_snapshot *snapshot)
{
    json_t *array = json_array();
    for (size_t i = 0; i < snapshot->camera_count; ++i) {
        const air_camera *camera = &snapshot->cameras[i];
        const float *map = camera->to_world;
        const bool perspective = camera->kind == AIR_CAMERA_PERSPECTIVE;
        json_t *object = json_object();
        json_object_set_new(object, "name", string(camera->name));
        json_object_set_new(object, "handle", json_integer(camera->handle));
        json_object_set_new(object, "kind",
                            json_string(perspective ? "perspective" : "orthographic"));
        json_object_set_new(object, "position", vector(vec3(map[3], map[7], map[11])));
        json_object_set_new(object, "dir", vector(vec3(-map[2], -map[6], -map[10])));
        json_object_set_new(object, "up", vector(vec3(map[1], map[5], map[9])));
        if (perspective)
            json_object_set_new(object, "fov_y_deg",
                                number(camera->fov_y_rad * (180.0f / AIR_PI_F)));
        else
            json_object_set_new(object, "half_height", number(camera->half_height));
        json_object_set_new(object, "aspect", number(camera->aspect));
        set_if(object, perspective && camera->lens_radius > 0.0f, "lens_radius",
               number(camera->lens_radius));
        set_if(object, perspective && camera->lens_radius > 0.0f, "focus_distance",
               number(camera->focus_distance));
        set_if(object, camera->mirrored, "mirrored", json_true());
        set_if(object, camera->near_distance > 0.0f, "near_distance",
               number(camera->near_distance));
        set_if(object, camera->framed, "frames_the_bounds", json_true());
        json_array_append_new(array, object);
    }
    return array;
}

/* ---- owners ---- */

static void append_owner(json_t *array, const air_snapshot *snapshot, const air_owner_table *table,
                         size_t light, size_t medium, air_term term)
{
    const air_light_table *lights = &snapshot->lights;
    json_t *object = json_object();
    json_object_set_new(
        object, "light",
        string(light < lights->explicit_count ? lights->entries[light].name : "emissive meshes"));
    json_object_set_new(object, "light_index", json_integer((json_int_t)light));
    json_object_set_new(object, "medium",
                        medium < snapshot->media.count ? string(snapshot->media.media[medium].name)
                                                       : json_null());
    json_object_set_new(object, "term", json_string(air_term_name(term)));
    const air_method method = air_owner_table_get(table, light, medium, term);
    json_object_set_new(object, "method", json_string(air_method_name(method)));
    set_if(object, method != AIR_METHOD_PATH, "mode",
           json_string(air_owner_table_mode(table, light)));
    json_array_append_new(array, object);
}

/* Every light with every term: those of media once for each medium, the others once. */
static json_t *describe_owners(const air_snapshot *snapshot, const air_owner_table *table)
{
    const size_t medium_count = snapshot->media.count;
    json_t *array = json_array();
    for (size_t light = 0; light < snapshot->lights.owner_count; ++light) {
        for (unsigned term = 0; term < AIR_TERM_COUNT; ++term) {
            const bool in_media = term == AIR_TERM_M1 || term == AIR_TERM_M2;
            const size_t begin = in_media ? 0 : medium_count;
            const size_t end = in_media ? medium_count : medium_count + 1;
            for (size_t medium = begin; medium < end; ++medium)
                append_owner(array, snapshot, table, light, medium, (air_term)term);
        }
    }
    return array;
}

/* ---- the whole ---- */

static json_t *describe_warnings(const air_snapshot *snapshot)
{
    json_t *array = json_array();
    for (size_t i = 0; i < snapshot->warning_count; ++i)
        json_array_append_new(array, string(snapshot->warnings[i]));
    return array;
}

static const char *units_name(air_units units)
{
    return units == AIR_UNITS_PHOTOMETRIC ? "photometric" : "radiometric";
}

static json_t *describe(const air_snapshot *snapshot, const air_owner_table *owners)
{
    const size_t quadrics = air_light_quadric_count(&snapshot->lights);
    json_t *root = json_object();
    json_object_set_new(root, "source", string(snapshot->source));
    json_object_set_new(root, "triangles", integer(snapshot->triangle_count));
    json_object_set_new(root, "emissive_triangles",
                        integer(air_light_triangle_count(&snapshot->lights)));
    set_if(root, quadrics > 0, "emissive_quadrics", integer(quadrics));
    json_object_set_new(root, "textures", integer(snapshot->texture_count));
    json_object_set_new(root, "bounds", bounds(snapshot->bounds_min, snapshot->bounds_max));
    json_object_set_new(root, "units",
                        json_pack("{s:s, s:s}", "light", units_name(snapshot->light_units),
                                  "emissive", units_name(snapshot->emissive_units)));
    json_object_set_new(root, "cameras", describe_cameras(snapshot));
    json_object_set_new(root, "lights", describe_lights(snapshot));
    json_object_set_new(root, "media", describe_media(snapshot));
    json_object_set_new(root, "meshes", describe_meshes(snapshot));
    json_object_set_new(root, "materials", describe_materials(snapshot));
    json_object_set_new(root, "owners", describe_owners(snapshot, owners));
    json_object_set_new(root, "warnings", describe_warnings(snapshot));
    return root;
}

air_status air_snapshot_describe(const air_snapshot *snapshot, char *buffer, size_t *size)
{
    if (snapshot == NULL || size == NULL)
        return AIR_ERROR_ARGUMENT;
    air_owner_table *owners = NULL;
    json_t *root = NULL;
    char *text = NULL;
    air_status status = air_owner_table_create(snapshot->context, snapshot, "auto", &owners);
    if (status != AIR_OK)
        goto cleanup;
    root = describe(snapshot, owners);
    text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (text == NULL) {
        status = air_fail_memory(snapshot->context, "scene description");
        goto cleanup;
    }
    const size_t needed = strlen(text) + 1;
    if (buffer != NULL && *size < needed) {
        status = air_fail(snapshot->context, AIR_ERROR_ARGUMENT,
                          "scene description: the buffer has %zu bytes, but %zu are needed", *size,
                          needed);
        goto cleanup;
    }
    if (buffer != NULL)
        memcpy(buffer, text, needed);
    *size = needed;
cleanup:
    free(text);
    json_decref(root);
    air_owner_table_destroy(owners);
    return status;
}

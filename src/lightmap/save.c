/* save.c: a lightmap's folder (docs/lightmap-format.md). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "lightmap/check.h"
#include "lightmap/files.h"

enum { NAME = 64 };

/* The basis of probes at this direction is published in every file, to be held against. */
static const double test_direction[3] = {2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0};

void air_lightmap_harmonics(const double direction[3], double out[AIR_PROBE_COEFFICIENTS])
{
    const double pi = 3.14159265358979323846;
    const double x = direction[0], y = direction[1], z = direction[2];
    const double one = sqrt(3.0 / (4.0 * pi)), two = 0.5 * sqrt(15.0 / pi);
    out[0] = 0.5 / sqrt(pi);
    out[1] = one * y;
    out[2] = one * z;
    out[3] = one * x;
    out[4] = two * x * y;
    out[5] = two * y * z;
    out[6] = 0.25 * sqrt(5.0 / pi) * (3.0 * z * z - 1.0);
    out[7] = two * x * z;
    out[8] = 0.5 * two * (x * x - y * y);
}

void air_lightmap_save_params_default(air_lightmap_save_params *params)
{
    *params = (air_lightmap_save_params){.half = true};
}

static json_t *units_to_json(void)
{
    json_t *units = json_object();
    json_object_set_new(units, "pages", json_string("irradiance, W/m^2"));
    json_object_set_new(units, "vertices", json_string("irradiance, W/m^2"));
    json_object_set_new(units, "probes", json_string("incident radiance, W/(m^2 sr)"));
    json_object_set_new(units, "colour", json_string("linear Rec. 709"));
    return units;
}

static json_t *basis_to_json(void)
{
    double values[AIR_PROBE_COEFFICIENTS];
    json_t *basis = json_object(), *test = json_object(), *direction = json_array(),
           *list = json_array();
    air_lightmap_harmonics(test_direction, values);
    for (size_t k = 0; k < 3; k++) {
        json_array_append_new(direction, json_real(test_direction[k]));
    }
    for (size_t k = 0; k < AIR_PROBE_COEFFICIENTS; k++) {
        json_array_append_new(list, json_real(values[k]));
    }
    json_object_set_new(test, "direction", direction);
    json_object_set_new(test, "values", list);
    json_object_set_new(
        basis, "basis",
        json_string("real spherical harmonics, orthonormal, no Condon-Shortley phase"));
    json_object_set_new(basis, "order", json_integer(2));
    json_object_set_new(basis, "index", json_string("l^2 + l + m"));
    json_object_set_new(basis, "test", test);
    return basis;
}

static void add_place(json_t *object, const char *name, uint32_t mesh, int32_t node,
                      int32_t primitive)
{
    json_object_set_new(object, "name", air_place_text(name != NULL ? name : ""));
    json_object_set_new(object, "mesh", json_integer(mesh));
    json_object_set_new(object, "node", json_integer(node));
    json_object_set_new(object, "primitive", json_integer(primitive));
}

/* ---- pages ---- */

static air_status save_pages(air_staging *staging, const air_lightmap *lightmap, bool half,
                             json_t *root)
{
    json_t *pages = json_array();
    air_image_save_params params;
    air_status status = AIR_OK;
    json_object_set_new(root, "pages", pages);
    air_image_save_params_default(&params);
    params.half = half;
    for (size_t i = 0; i < lightmap->page_count && status == AIR_OK; i++) {
        const air_image *page = lightmap->pages[i];
        json_t *object = json_object();
        char name[NAME];
        (void)snprintf(name, sizeof name, "page-%zu.exr", i);
        json_object_set_new(object, "file", json_string(name));
        json_object_set_new(object, "width", json_integer((json_int_t)air_image_width(page)));
        json_object_set_new(object, "height", json_integer((json_int_t)air_image_height(page)));
        json_array_append_new(pages, object);
        status = air_staging_add_image(staging, name, page, &params);
    }
    return status;
}

/* ---- meshes ---- */

static size_t cut_size(const air_lightmap_mesh *mesh)
{
    return 4 * (3 * mesh->vertex_count + 3 * mesh->triangle_count);
}

static uint8_t *put_words(uint8_t *out, const void *words, size_t count)
{
    const char *bytes = words;
    for (size_t i = 0; i < count; i++) {
        uint32_t word;
        memcpy(&word, bytes + 4 * i, sizeof word);
        air_put_u32(out + 4 * i, word);
    }
    return out + 4 * count;
}

static json_t *mesh_to_json(const air_lightmap_mesh *mesh, size_t cut_offset)
{
    json_t *object = json_object();
    add_place(object, mesh->name, mesh->mesh, mesh->node, mesh->primitive);
    json_object_set_new(object, "page", json_integer(mesh->page));
    json_object_set_new(object, "scale", air_place_numbers(mesh->scale, 2));
    json_object_set_new(object, "offset", air_place_numbers(mesh->offset, 2));
    if (mesh->sources != NULL) {
        json_t *cut = json_object();
        json_object_set_new(cut, "file", json_string("cuts.bin"));
        json_object_set_new(cut, "byte", json_integer((json_int_t)cut_offset));
        json_object_set_new(cut, "vertices", json_integer((json_int_t)mesh->vertex_count));
        json_object_set_new(cut, "triangles", json_integer((json_int_t)mesh->triangle_count));
        json_object_set_new(object, "cut", cut);
    }
    return object;
}

static air_status save_meshes(air_staging *staging, const air_lightmap *lightmap, json_t *root)
{
    json_t *meshes = json_array();
    size_t size = AIR_CUT_HEADER, cut_count = 0;
    json_object_set_new(root, "meshes", meshes);
    for (size_t i = 0; i < lightmap->mesh_count; i++) {
        json_array_append_new(meshes, mesh_to_json(&lightmap->meshes[i], size));
        size += cut_size(&lightmap->meshes[i]);
        cut_count += lightmap->meshes[i].sources != NULL;
    }
    if (cut_count == 0) {
        return AIR_OK;
    }
    uint8_t *bytes = air_allocate(staging->context, size, 1);
    if (bytes == NULL) {
        return air_fail_memory(staging->context, "cuts.bin");
    }
    memcpy(bytes, "airlight", 8);
    air_put_u32(bytes + 8, AIR_LIGHTMAP_VERSION);
    air_put_u32(bytes + 12, (uint32_t)cut_count);
    uint8_t *out = bytes + AIR_CUT_HEADER;
    for (size_t i = 0; i < lightmap->mesh_count; i++) {
        const air_lightmap_mesh *mesh = &lightmap->meshes[i];
        out = put_words(out, mesh->sources, mesh->vertex_count);
        out = put_words(out, mesh->uv, 2 * mesh->vertex_count);
        out = put_words(out, mesh->indices, 3 * mesh->triangle_count);
    }
    const air_status status = air_staging_add(staging, "cuts.bin", bytes, size);
    air_free(staging->context, bytes);
    return status;
}

/* ---- light of vertices ---- */

static air_status save_vertex_lights(air_staging *staging, const air_lightmap *lightmap,
                                     json_t *root)
{
    json_t *lights = json_array();
    air_status status = AIR_OK;
    json_object_set_new(root, "vertex_lights", lights);
    for (size_t i = 0; i < lightmap->vertex_light_count && status == AIR_OK; i++) {
        const air_vertex_light *light = &lightmap->vertex_lights[i];
        json_t *object = json_object();
        air_image *image = NULL;
        char name[NAME];
        (void)snprintf(name, sizeof name, "vertices-%zu.exr", i);
        add_place(object, light->name, light->mesh, light->node, light->primitive);
        json_object_set_new(object, "vertices", json_integer((json_int_t)light->vertex_count));
        json_object_set_new(object, "file", json_string(name));
        json_array_append_new(lights, object);
        status = air_vertex_light_to_image(staging->context, light, &image);
        if (status == AIR_OK) {
            air_image_save_params params;
            air_image_save_params_default(&params);
            status = air_staging_add_image(staging, name, image, &params);
        }
        air_image_destroy(image);
    }
    return status;
}

static air_status save_parts(air_staging *staging, const air_lightmap *lightmap, bool half,
                             json_t *root)
{
    air_status status = save_pages(staging, lightmap, half, root);
    if (status == AIR_OK) {
        status = save_meshes(staging, lightmap, root);
    }
    if (status == AIR_OK) {
        status = save_vertex_lights(staging, lightmap, root);
    }
    if (status == AIR_OK && lightmap->probe_set_count > 0) {
        json_object_set_new(root, "probes", json_string("probes.json"));
        status = air_staging_add_json(staging, "probes.json", air_probe_sets_to_json(lightmap));
    }
    return status;
}

static json_t *head_to_json(const air_lightmap *lightmap)
{
    json_t *root = json_object();
    json_object_set_new(root, "airlight_lightmap", json_integer(AIR_LIGHTMAP_VERSION));
    json_object_set_new(root, "scene",
                        air_place_text(lightmap->scene != NULL ? lightmap->scene : ""));
    json_object_set_new(root, "media",
                        air_place_text(lightmap->media != NULL ? lightmap->media : "none"));
    json_object_set_new(root, "directional", json_boolean(lightmap->directional));
    json_object_set_new(root, "photometric", json_boolean(lightmap->photometric));
    json_object_set_new(root, "units", units_to_json());
    json_object_set_new(root, "harmonics", basis_to_json());
    return root;
}

air_status air_lightmap_save(air_context *context, const air_lightmap *lightmap, const char *folder,
                             const air_lightmap_save_params *params)
{
    air_lightmap_save_params defaults;
    air_lightmap_save_params_default(&defaults);
    air_status status = air_lightmap_check(context, lightmap, folder, AIR_ERROR_ARGUMENT);
    if (status != AIR_OK) {
        return status;
    }
    air_staging staging;
    status = air_staging_begin(context, folder, &staging);
    json_t *root = head_to_json(lightmap);
    if (status == AIR_OK) {
        status = save_parts(&staging, lightmap, (params != NULL ? params : &defaults)->half, root);
    }
    if (status == AIR_OK) {
        status = air_staging_add_json(&staging, "lightmap.json", json_incref(root));
    }
    if (status == AIR_OK) {
        status = air_staging_commit(&staging);
    }
    if (status == AIR_OK) {
        air_staging_remove_old(&staging, "page-", lightmap->page_count);
        air_staging_remove_old(&staging, "vertices-", lightmap->vertex_light_count);
    }
    json_decref(root);
    air_staging_finish(&staging);
    return status;
}

/* load.c: a lightmap's folder, read strictly (docs/lightmap-format.md). */
#include <string.h>

#include "lightmap/check.h"
#include "lightmap/files.h"

/* A folder while it is being read. */
typedef struct loader {
    air_context *context;
    const char *folder;
    air_lightmap *lightmap;
    uint8_t *cuts; /* cuts.bin, once a mesh asks for it */
    size_t cuts_size;
} loader;

static char *path_in(const loader *self, const char *name)
{
    const size_t length = strlen(self->folder);
    const bool slash = length == 0 || self->folder[length - 1] == '/';
    char *path = air_string_format(self->context, "%s%s%s", self->folder, slash ? "" : "/", name);
    if (path == NULL) {
        (void)air_fail_memory(self->context, self->folder);
    }
    return path;
}

/* An array of objects: *out_items has room for its elements, NULL if there are none. */
static air_status begin_list(const air_place *at, size_t size, void **out_items, size_t *out_count)
{
    const air_status status = air_place_array(at);
    const size_t count = air_place_count(at);
    if (status != AIR_OK || count == 0) {
        return status;
    }
    *out_items = air_allocate(at->context, count, size);
    if (*out_items == NULL) {
        return air_fail_memory(at->context, at->file);
    }
    *out_count = count;
    return AIR_OK;
}

static air_status load_image(const loader *self, const air_place *file, air_image **out_image,
                             char **out_path)
{
    const char *name;
    const air_status status = air_place_file_name(file, &name);
    if (status != AIR_OK) {
        return status;
    }
    *out_path = path_in(self, name);
    return *out_path == NULL ? AIR_ERROR_MEMORY
                             : air_image_load(self->context, *out_path, out_image);
}

/* ---- pages ---- */

static air_status load_page(const loader *self, const air_place *at, air_image **out_page)
{
    const air_place file = air_place_get(at, "file");
    const air_place width_at = air_place_get(at, "width");
    const air_place height_at = air_place_get(at, "height");
    size_t width = 0, height = 0;
    char *path = NULL;
    air_status status = air_place_size(&width_at, 65535, &width);
    if (status == AIR_OK) {
        status = air_place_size(&height_at, 65535, &height);
    }
    if (status == AIR_OK) {
        status = load_image(self, &file, out_page, &path);
    }
    if (status == AIR_OK &&
        (air_image_width(*out_page) != width || air_image_height(*out_page) != height)) {
        status = air_fail(self->context, AIR_ERROR_FORMAT,
                          "%s: the image is %zu x %zu, lightmap.json says %zu x %zu", path,
                          air_image_width(*out_page), air_image_height(*out_page), width, height);
    }
    air_free(self->context, path);
    return status;
}

static air_status load_pages(const loader *self, const air_place *root)
{
    air_lightmap *lightmap = self->lightmap;
    const air_place list = air_place_get(root, "pages");
    void *items = NULL;
    air_status status = begin_list(&list, sizeof *lightmap->pages, &items, &lightmap->page_count);
    lightmap->pages = items;
    for (size_t i = 0; i < lightmap->page_count && status == AIR_OK; i++) {
        const air_place at = air_place_at(&list, i);
        status = load_page(self, &at, &lightmap->pages[i]);
    }
    return status;
}

/* ---- meshes ---- */

static air_status load_place(const air_place *at, char **name, uint32_t *mesh, int32_t *node,
                             int32_t *primitive)
{
    const air_place name_at = air_place_get(at, "name");
    const air_place mesh_at = air_place_get(at, "mesh");
    const air_place node_at = air_place_get(at, "node");
    const air_place primitive_at = air_place_get(at, "primitive");
    int64_t numbers[3] = {0};
    air_status status = air_place_string(&name_at, name);
    if (status == AIR_OK) {
        status = air_place_integer(&mesh_at, 0, UINT32_MAX, &numbers[0]);
    }
    if (status == AIR_OK) {
        status = air_place_integer(&node_at, -1, INT32_MAX, &numbers[1]);
    }
    if (status == AIR_OK) {
        status = air_place_integer(&primitive_at, -1, INT32_MAX, &numbers[2]);
    }
    *mesh = (uint32_t)numbers[0];
    *node = (int32_t)numbers[1];
    *primitive = (int32_t)numbers[2];
    return status;
}

static air_status read_cuts(loader *self, const air_place *file)
{
    const char *name;
    void *data = NULL;
    if (self->cuts != NULL) {
        return AIR_OK;
    }
    air_status status = air_place_file_name(file, &name);
    if (status == AIR_OK && strcmp(name, "cuts.bin") != 0) {
        status = air_place_wrong(file, "\"cuts.bin\"");
    }
    char *path = status == AIR_OK ? path_in(self, name) : NULL;
    if (status == AIR_OK) {
        status = path == NULL ? AIR_ERROR_MEMORY
                              : air_file_read(self->context, path, &data, &self->cuts_size);
    }
    self->cuts = data;
    if (status == AIR_OK &&
        (self->cuts_size < AIR_CUT_HEADER || memcmp(self->cuts, "airlight", 8) != 0 ||
         air_get_u32(self->cuts + 8) != AIR_LIGHTMAP_VERSION)) {
        status = air_fail(self->context, AIR_ERROR_FORMAT,
                          "%s: byte 0: expected \"airlight\" and the version number %d", path,
                          AIR_LIGHTMAP_VERSION);
    }
    air_free(self->context, path);
    return status;
}

/* count words into fresh memory. */
static void *get_words(const loader *self, size_t offset, size_t count)
{
    uint32_t *words = air_allocate(self->context, count, sizeof *words);
    for (size_t i = 0; words != NULL && i < count; i++) {
        words[i] = air_get_u32(self->cuts + offset + 4 * i);
    }
    return words;
}

static air_status load_cut(loader *self, const air_place *at, air_lightmap_mesh *mesh)
{
    const air_place file = air_place_get(at, "file");
    const air_place byte_at = air_place_get(at, "byte");
    const air_place vertices_at = air_place_get(at, "vertices");
    const air_place triangles_at = air_place_get(at, "triangles");
    size_t byte = 0, vertices = 0, triangles = 0;
    air_status status = read_cuts(self, &file);
    if (status == AIR_OK) {
        status = air_place_size(&byte_at, self->cuts_size, &byte);
    }
    const size_t words = status == AIR_OK ? (self->cuts_size - byte) / 4 : 0;
    if (status == AIR_OK) {
        status = air_place_size(&vertices_at, words / 3, &vertices);
    }
    if (status == AIR_OK) {
        status = air_place_size(&triangles_at, words / 3 - vertices, &triangles);
    }
    if (status != AIR_OK) {
        return status;
    }
    mesh->vertex_count = vertices;
    mesh->triangle_count = triangles;
    mesh->sources = get_words(self, byte, vertices);
    mesh->uv = get_words(self, byte + 4 * vertices, 2 * vertices);
    mesh->indices = get_words(self, byte + 12 * vertices, 3 * triangles);
    return mesh->sources != NULL && mesh->uv != NULL && mesh->indices != NULL
               ? AIR_OK
               : air_fail_memory(self->context, at->file);
}

static air_status load_mesh(loader *self, const air_place *at, air_lightmap_mesh *mesh)
{
    const air_place page_at = air_place_get(at, "page");
    const air_place scale = air_place_get(at, "scale");
    const air_place offset = air_place_get(at, "offset");
    const air_place cut = air_place_get(at, "cut");
    int64_t page = -1;
    air_status status = load_place(at, &mesh->name, &mesh->mesh, &mesh->node, &mesh->primitive);
    if (status == AIR_OK) {
        status = air_place_integer(&page_at, -1, (int64_t)self->lightmap->page_count - 1, &page);
    }
    mesh->page = (int32_t)page;
    if (status == AIR_OK) {
        status = air_place_floats(&scale, 2, mesh->scale);
    }
    if (status == AIR_OK) {
        status = air_place_floats(&offset, 2, mesh->offset);
    }
    return status == AIR_OK && cut.value != NULL ? load_cut(self, &cut, mesh) : status;
}

static air_status load_meshes(loader *self, const air_place *root)
{
    air_lightmap *lightmap = self->lightmap;
    const air_place list = air_place_get(root, "meshes");
    void *items = NULL;
    air_status status = begin_list(&list, sizeof *lightmap->meshes, &items, &lightmap->mesh_count);
    lightmap->meshes = items;
    for (size_t i = 0; i < lightmap->mesh_count && status == AIR_OK; i++) {
        const air_place at = air_place_at(&list, i);
        status = load_mesh(self, &at, &lightmap->meshes[i]);
    }
    return status;
}

/* ---- light of vertices, probes ---- */

static air_status load_vertex_light(const loader *self, const air_place *at,
                                    air_vertex_light *light)
{
    const air_place file = air_place_get(at, "file");
    const air_place vertices = air_place_get(at, "vertices");
    air_image *image = NULL;
    char *path = NULL;
    air_status status = load_place(at, &light->name, &light->mesh, &light->node, &light->primitive);
    if (status == AIR_OK) {
        status = air_place_size(&vertices, UINT32_MAX, &light->vertex_count);
    }
    if (status == AIR_OK) {
        status = load_image(self, &file, &image, &path);
    }
    if (status == AIR_OK) {
        status = air_vertex_light_from_image(self->context, path, image, light);
    }
    air_image_destroy(image);
    air_free(self->context, path);
    return status;
}

static air_status load_vertex_lights(const loader *self, const air_place *root)
{
    air_lightmap *lightmap = self->lightmap;
    const air_place list = air_place_get(root, "vertex_lights");
    void *items = NULL;
    air_status status =
        begin_list(&list, sizeof *lightmap->vertex_lights, &items, &lightmap->vertex_light_count);
    lightmap->vertex_lights = items;
    for (size_t i = 0; i < lightmap->vertex_light_count && status == AIR_OK; i++) {
        const air_place at = air_place_at(&list, i);
        status = load_vertex_light(self, &at, &lightmap->vertex_lights[i]);
    }
    return status;
}

/* Reads a JSON file of the folder; the caller frees *out_path and releases *out_root. */
static air_status read_json(const loader *self, const char *name, char **out_path,
                            json_t **out_root)
{
    void *text = NULL;
    size_t size = 0;
    *out_path = path_in(self, name);
    if (*out_path == NULL) {
        return AIR_ERROR_MEMORY;
    }
    air_status status = air_file_read(self->context, *out_path, &text, &size);
    if (status == AIR_OK) {
        status = air_place_parse(self->context, *out_path, text, size, out_root);
    }
    air_free(self->context, text);
    return status;
}

static air_status load_probes(const loader *self, const air_place *root)
{
    const air_place file = air_place_get(root, "probes");
    const char *name;
    json_t *json = NULL;
    char *path = NULL;
    if (file.value == NULL) {
        return AIR_OK;
    }
    air_status status = air_place_file_name(&file, &name);
    if (status == AIR_OK) {
        status = read_json(self, name, &path, &json);
    }
    if (status == AIR_OK) {
        const air_place at = air_place_root(self->context, path, json);
        status = air_probe_sets_from_json(&at, self->lightmap);
    }
    json_decref(json);
    air_free(self->context, path);
    return status;
}

static air_status load_parts(loader *self, const air_place *root)
{
    air_lightmap *lightmap = self->lightmap;
    const air_place version = air_place_get(root, "airlight_lightmap");
    const air_place scene = air_place_get(root, "scene");
    const air_place media = air_place_get(root, "media");
    const air_place directional = air_place_get(root, "directional");
    const air_place photometric = air_place_get(root, "photometric");
    int64_t number = 0;
    air_status status =
        air_place_integer(&version, AIR_LIGHTMAP_VERSION, AIR_LIGHTMAP_VERSION, &number);
    if (status == AIR_OK) {
        status = air_place_string(&scene, &lightmap->scene);
    }
    if (status == AIR_OK) {
        status = air_place_string(&media, &lightmap->media);
    }
    if (status == AIR_OK) {
        status = air_place_bool(&directional, &lightmap->directional);
    }
    if (status == AIR_OK) {
        status = air_place_bool(&photometric, &lightmap->photometric);
    }
    if (status == AIR_OK) {
        status = load_pages(self, root);
    }
    if (status == AIR_OK) {
        status = load_meshes(self, root);
    }
    if (status == AIR_OK) {
        status = load_vertex_lights(self, root);
    }
    return status == AIR_OK ? load_probes(self, root) : status;
}

air_status air_lightmap_load(air_context *context, const char *folder, air_lightmap **out_lightmap)
{
    loader self = {.context = context, .folder = folder};
    char *path = NULL;
    json_t *json = NULL;
    *out_lightmap = NULL;
    air_status status = air_lightmap_create(context, &self.lightmap);
    if (status == AIR_OK) {
        status = read_json(&self, "lightmap.json", &path, &json);
    }
    if (status == AIR_OK) {
        const air_place root = air_place_root(context, path, json);
        status = load_parts(&self, &root);
    }
    if (status == AIR_OK) {
        status = air_lightmap_check(context, self.lightmap, path, AIR_ERROR_FORMAT);
    }
    if (status == AIR_OK) {
        *out_lightmap = self.lightmap;
    } else {
        air_lightmap_destroy(self.lightmap);
    }
    json_decref(json);
    air_free(context, self.cuts);
    air_free(context, path);
    return status;
}

/* godot_nodes.c: which of Godot's nodes has which slice: names as its glTF importer gives them. */
#include <stdio.h>
#include <string.h>

#include "lightmap/gltf_copy.h"
#include "lightmap/godot.h"

enum { DEEPEST = 256, SUFFIX = 24 };

typedef struct godot_nodes {
    air_context *context;
    air_gltf_copy *scene;
    char **names;    /* per node */
    size_t *parents; /* SIZE_MAX: none */
    size_t count;
} godot_nodes;

/* Characters that a node's name cannot have become underlines. */
static void make_valid(char *name)
{
    for (; *name != '\0'; name++) {
        if (strchr(".:@/\"%", *name) != NULL) {
            *name = '_';
        }
    }
}

static bool taken(const godot_nodes *self, size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(self->names[i], name) == 0) {
            return true;
        }
    }
    return false;
}

/* Names are unique in the whole file: "Chair", "Chair2", "Chair3". */
static air_status name_node(godot_nodes *self, size_t node, const air_place *at)
{
    const air_place name_at = air_place_get(at, "name");
    const air_place mesh_at = air_place_get(at, "mesh");
    const char *given = json_string_value(name_at.value);
    const char *fallback = mesh_at.value != NULL ? "Mesh" : "Node";
    char *name = air_string_copy(self->context, given != NULL && given[0] ? given : fallback);
    if (name == NULL) {
        return air_fail_memory(self->context, at->file);
    }
    make_valid(name);
    for (size_t number = 2; self->names[node] == NULL; number++) {
        char *numbered = number == 2 ? air_string_copy(self->context, name)
                                     : air_string_format(self->context, "%s%zu", name, number - 1);
        if (numbered == NULL) {
            air_free(self->context, name);
            return air_fail_memory(self->context, at->file);
        }
        if (taken(self, node, numbered)) {
            air_free(self->context, numbered);
        } else {
            self->names[node] = numbered;
        }
    }
    air_free(self->context, name);
    return AIR_OK;
}

static air_status read_nodes(godot_nodes *self)
{
    const air_place root = air_gltf_copy_root(self->scene);
    const air_place nodes = air_place_get(&root, "nodes");
    self->count = air_place_count(&nodes);
    self->names = air_allocate(self->context, self->count, sizeof *self->names);
    self->parents = air_allocate(self->context, self->count, sizeof *self->parents);
    if (self->names == NULL || self->parents == NULL) {
        return air_fail_memory(self->context, self->scene->path);
    }
    for (size_t i = 0; i < self->count; i++) {
        self->parents[i] = SIZE_MAX;
    }
    air_status status = AIR_OK;
    for (size_t i = 0; i < self->count && status == AIR_OK; i++) {
        const air_place at = air_place_at(&nodes, i);
        const air_place children = air_place_get(&at, "children");
        status = name_node(self, i, &at);
        for (size_t k = 0; k < air_place_count(&children) && status == AIR_OK; k++) {
            const air_place child_at = air_place_at(&children, k);
            size_t child = 0;
            status = air_place_size(&child_at, self->count - 1, &child);
            if (status == AIR_OK) {
                self->parents[child] = i;
            }
        }
    }
    return status;
}

/* A name within quotes; only backslashes are left to be escaped. */
static bool print_name(air_sink *sink, const char *name)
{
    bool done = true;
    for (; *name != '\0' && done; name++) {
        done = (*name != '\\' || air_sink_write(sink, sink->size, "\\", 1)) &&
               air_sink_write(sink, sink->size, name, 1);
    }
    return done;
}

/* "../Parent/Node", as seen from a sibling of the scene's uppermost nodes. */
static air_status print_path(const godot_nodes *self, size_t node, air_sink *sink)
{
    size_t way[DEEPEST], depth = 0;
    for (size_t at = node; at != SIZE_MAX && depth < DEEPEST; at = self->parents[at]) {
        way[depth++] = at;
    }
    if (depth == DEEPEST) {
        return air_fail(self->context, AIR_ERROR_FORMAT, "%s: $.nodes[%zu]: more than %d parents",
                        self->scene->path, node, DEEPEST - 1);
    }
    bool done = air_godot_print(sink, "NodePath(\"..");
    while (depth-- > 0) {
        done = done && air_sink_write(sink, sink->size, "/", 1) &&
               print_name(sink, self->names[way[depth]]);
    }
    return done && air_godot_print(sink, "\")") ? AIR_OK
                                                : air_fail_memory(self->context, self->scene->path);
}

/* The page of a node's meshes, if it is one: a MeshInstance3D has one slice. */
static int32_t page_of(const air_lightmap *lightmap, size_t first)
{
    int32_t page = -1;
    for (size_t i = first; i < lightmap->mesh_count; i++) {
        const air_lightmap_mesh *mesh = &lightmap->meshes[i];
        if (mesh->node == lightmap->meshes[first].node && mesh->page >= 0) {
            if (page >= 0 && mesh->page != page) {
                return -1;
            }
            page = mesh->page;
        }
    }
    return page;
}

static bool seen(const air_lightmap *lightmap, size_t mesh)
{
    for (size_t i = 0; i < mesh; i++) {
        if (lightmap->meshes[i].node == lightmap->meshes[mesh].node &&
            lightmap->meshes[i].page >= 0) {
            return true;
        }
    }
    return false;
}

static air_status print_user(const godot_nodes *self, const air_lightmap *lightmap, size_t mesh,
                             size_t widest, size_t highest, bool first, air_sink *sink)
{
    const size_t node = (size_t)lightmap->meshes[mesh].node;
    const int32_t page = page_of(lightmap, mesh);
    if (node >= self->count) {
        return air_fail(self->context, AIR_ERROR_FORMAT,
                        "%s: $.nodes[%zu]: expected a node, as in the scene that was baked",
                        self->scene->path, node);
    }
    if (page < 0) {
        air_warn(self->context, "%s: node %s lies on several pages, Godot knows one: left out",
                 self->scene->path, self->names[node]);
        return AIR_OK;
    }
    const double width = (double)air_image_width(lightmap->pages[page]) / (double)widest;
    const double height = (double)air_image_height(lightmap->pages[page]) / (double)highest;
    if (!first && !air_godot_print(sink, ", ")) {
        return air_fail_memory(self->context, self->scene->path);
    }
    const air_status status = print_path(self, node, sink);
    if (status != AIR_OK) {
        return status;
    }
    return air_godot_print(sink, ", Rect2(0, 0, %.9g, %.9g), %ld, -1", width, height, (long)page)
               ? AIR_OK
               : air_fail_memory(self->context, self->scene->path);
}

air_status air_godot_print_users(air_context *context, const air_lightmap *lightmap,
                                 const char *scene_path, size_t widest, size_t highest,
                                 air_sink *sink)
{
    air_gltf_copy scene;
    godot_nodes self = {.context = context, .scene = &scene};
    air_status status = air_gltf_copy_read_json(context, scene_path, &scene);
    if (status == AIR_OK) {
        status = read_nodes(&self);
    }
    if (status == AIR_OK && !air_godot_print(sink, "user_data = [")) {
        status = air_fail_memory(context, scene_path);
    }
    const size_t begin = sink->size;
    for (size_t i = 0; i < lightmap->mesh_count && status == AIR_OK; i++) {
        if (lightmap->meshes[i].page >= 0 && lightmap->meshes[i].node >= 0 && !seen(lightmap, i)) {
            status = print_user(&self, lightmap, i, widest, highest, sink->size == begin, sink);
        }
    }
    if (status == AIR_OK && !air_godot_print(sink, "]\n")) {
        status = air_fail_memory(context, scene_path);
    }
    for (size_t i = 0; self.names != NULL && i < self.count; i++) {
        air_free(context, self.names[i]);
    }
    air_free(context, self.names);
    air_free(context, self.parents);
    air_gltf_copy_finish(&scene);
    return status;
}

/* lightmap_fixture.h: what the tests of lightmaps share: a context that counts, a folder that is
 * removed, a small lightmap with something of everything. */
#ifndef AIR_TESTS_LIGHTMAP_FIXTURE_H
#define AIR_TESTS_LIGHTMAP_FIXTURE_H

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "airlight/lightmap.h"
#include "cmocka_test.h"
#include "core/host.h"
#include "failing_allocator.h"

enum { LIGHTMAP_NAME = 256, LIGHTMAP_PATH = 512, LIGHTMAP_MANY = 1000000000 };

typedef struct lightmap_fixture {
    failing_allocator allocator;
    air_context *context;
    char folder[64];
    char path[LIGHTMAP_PATH];
    int warnings;
    char warning[512]; /* the last one */
    uint32_t random;
} lightmap_fixture;

static inline void lightmap_message(void *user, air_message_level level, const char *text)
{
    lightmap_fixture *self = user;
    if (level == AIR_MESSAGE_WARNING) {
        self->warnings++;
        (void)snprintf(self->warning, sizeof self->warning, "%s", text);
    }
}

static inline int lightmap_start(void **state)
{
    lightmap_fixture *self = calloc(1, sizeof *self);
    air_context_params params = failing_params(&self->allocator, LIGHTMAP_MANY);
    params.message = lightmap_message;
    params.message_user = self;
    params.thread_count = 1;
    (void)snprintf(self->folder, sizeof self->folder, "/tmp/airlight-lightmap-XXXXXX");
    *state = self;
    return mkdtemp(self->folder) != NULL && air_context_create(&params, &self->context) == AIR_OK
               ? 0
               : -1;
}

/* Removes a folder and what is in it; returns how many entries there were. */
static inline size_t lightmap_remove(const char *folder)
{
    DIR *directory = opendir(folder);
    size_t count = 0;
    if (directory == NULL) {
        return 0;
    }
    for (struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) {
            continue;
        }
        char *path = malloc(strlen(folder) + strlen(entry->d_name) + 2);
        (void)sprintf(path, "%s/%s", folder, entry->d_name);
        if (unlink(path) != 0) {
            (void)lightmap_remove(path);
        }
        free(path);
        count++;
    }
    (void)closedir(directory);
    (void)rmdir(folder);
    return count;
}

/* Names in a folder, also hidden ones. */
static inline size_t lightmap_count_files(const char *folder)
{
    DIR *directory = opendir(folder);
    size_t count = 0;
    assert_non_null(directory);
    for (struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    }
    (void)closedir(directory);
    return count;
}

/* Fails if anything allocated was not freed. */
static inline int lightmap_finish(void **state)
{
    lightmap_fixture *self = *state;
    (void)lightmap_remove(self->folder);
    air_context_destroy(self->context);
    const long live = atomic_load(&self->allocator.live);
    free(self);
    return live == 0 ? 0 : -1;
}

/* A path below the fixture's folder, valid until the next call. */
static inline const char *lightmap_path(lightmap_fixture *self, const char *name)
{
    (void)snprintf(self->path, sizeof self->path, "%s/%s", self->folder, name);
    return self->path;
}

/* A whole file with a NUL behind; free it. */
static inline char *lightmap_read(lightmap_fixture *self, const char *name, size_t *out_size)
{
    FILE *file = fopen(lightmap_path(self, name), "rb");
    if (file == NULL) {
        fail_msg("%s is missing", self->path);
    }
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const size_t size = (size_t)ftell(file);
    char *data = calloc(size + 1, 1);
    rewind(file);
    assert_int_equal(fread(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    if (out_size != NULL) {
        *out_size = size;
    }
    return data;
}

static inline void lightmap_write(lightmap_fixture *self, const char *name, const void *data,
                                  size_t size)
{
    FILE *file = fopen(lightmap_path(self, name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void lightmap_expect(const lightmap_fixture *self, const char *part)
{
    const char *message = air_context_last_error(self->context);
    if (strstr(message, part) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", message, part);
    }
}

/* Numbers in [0, 4) that are sums of few powers of two, so halfs of them are not exact. */
static inline float lightmap_number(lightmap_fixture *self)
{
    self->random = self->random * 1664525u + 1013904223u;
    return (float)(self->random >> 8) * 0x1p-22f;
}

static inline float *lightmap_numbers(lightmap_fixture *self, size_t count)
{
    float *values = air_allocate(self->context, count, sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; i++) {
        values[i] = lightmap_number(self);
    }
    return values;
}

enum { LIGHTMAP_PAGE_CHANNELS = 25 };
/* Without directional light the first 13. */
static const char *const lightmap_channels[LIGHTMAP_PAGE_CHANNELS + 3] = {
    "R",          "G",          "B",       "direct.R", "direct.G", "direct.B",   "indirect.R",
    "indirect.G", "indirect.B", "media.R", "media.G",  "media.B",  "coverage.Y", "L0.R",
    "L0.G",       "L0.B",       "L1.y.R",  "L1.y.G",   "L1.y.B",   "L1.z.R",     "L1.z.G",
    "L1.z.B",     "L1.x.R",     "L1.x.G",  "L1.x.B",   "albedo.R", "albedo.G",   "albedo.B"};

/* A page whose R, G, B are the sums of the layers. */
static inline air_image *lightmap_page(lightmap_fixture *self, size_t width, size_t height,
                                       size_t channel_count)
{
    air_image *page = NULL;
    assert_int_equal(
        air_image_create(self->context, width, height, channel_count, lightmap_channels, &page),
        AIR_OK);
    for (size_t c = 3; c < channel_count; c++) {
        for (size_t i = 0; i < width * height; i++) {
            float *value = &air_image_plane(page, c)[i];
            *value = lightmap_number(self);
            if (c < 12) {
                air_image_plane(page, c % 3)[i] += *value;
            } else if (c == 12 || c >= LIGHTMAP_PAGE_CHANNELS) {
                *value *= 0.25f;
            }
        }
    }
    return page;
}

static inline void lightmap_add_page(lightmap_fixture *self, air_lightmap *lightmap,
                                     air_image *page)
{
    lightmap->pages = air_reallocate(self->context, lightmap->pages, lightmap->page_count + 1,
                                     sizeof *lightmap->pages);
    assert_non_null(lightmap->pages);
    lightmap->pages[lightmap->page_count++] = page;
}

static inline void lightmap_cut(lightmap_fixture *self, air_lightmap_mesh *mesh,
                                size_t vertex_count, const uint32_t *sources, const float *uv,
                                size_t triangle_count, const uint32_t *indices)
{
    mesh->vertex_count = vertex_count;
    mesh->triangle_count = triangle_count;
    mesh->sources = air_allocate(self->context, vertex_count, sizeof *mesh->sources);
    mesh->uv = air_allocate(self->context, vertex_count, 2 * sizeof *mesh->uv);
    mesh->indices = air_allocate(self->context, triangle_count, 3 * sizeof *mesh->indices);
    memcpy(mesh->sources, sources, vertex_count * sizeof *sources);
    memcpy(mesh->uv, uv, 2 * vertex_count * sizeof *uv);
    memcpy(mesh->indices, indices, 3 * triangle_count * sizeof *indices);
}

static inline void lightmap_add_probes(lightmap_fixture *self, air_probe_set *set, const char *name,
                                       size_t count)
{
    set->name = air_string_copy(self->context, name);
    set->count = count;
    set->positions = lightmap_numbers(self, 3 * count);
    set->validity = lightmap_numbers(self, count);
    for (size_t i = 0; i < count; i++) {
        set->validity[i] *= 0.25f;
    }
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        set->layers[k] = lightmap_numbers(self, 27 * count);
        for (size_t i = 0; i < 27 * count; i++) {
            set->layers[k][i] -= i / 3 % 9 != 0 ? 2.0f : 0.0f;
        }
    }
}

/* Two pages, a mesh that serves as it is, one that is cut and one without a place; 1500 vertices;
 * seven probes and a grid. */
static inline air_lightmap *lightmap_make(lightmap_fixture *self, bool directional)
{
    static const uint32_t sources[5] = {0, 1, 2, 2, 7}, indices[6] = {0, 1, 2, 1, 3, 4};
    static const float uv[10] = {0.0f, 0.0f, 0.5f, 0.1f, 0.3f, 0.9f, 1.0f, 1.0f, 0.25f, 0.75f};
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    air_free(self->context, lightmap->scene);
    air_free(self->context, lightmap->media);
    lightmap->scene = air_string_copy(self->context, "rooms/\xc3\xa9tude \"1\".gltf");
    lightmap->media = air_string_copy(self->context, "impulse");
    lightmap->directional = directional;
    lightmap->photometric = true;
    const size_t channels = directional ? LIGHTMAP_PAGE_CHANNELS : 13;
    lightmap_add_page(self, lightmap, lightmap_page(self, 33, 17, channels));
    lightmap_add_page(self, lightmap, lightmap_page(self, 8, 64, channels));

    lightmap->mesh_count = 3;
    lightmap->meshes = air_allocate(self->context, 3, sizeof *lightmap->meshes);
    lightmap->meshes[0] = (air_lightmap_mesh){.name = air_string_copy(self->context, "floor"),
                                              .mesh = 0,
                                              .node = 4,
                                              .primitive = 0,
                                              .page = 0,
                                              .scale = {0.5f, 0.25f},
                                              .offset = {0.1f, 0.7f}};
    lightmap->meshes[1] = (air_lightmap_mesh){.name = air_string_copy(self->context, "chair"),
                                              .mesh = 7,
                                              .node = 2,
                                              .primitive = 3,
                                              .page = 1,
                                              .scale = {1.0f, 1.0f}};
    lightmap_cut(self, &lightmap->meshes[1], 5, sources, uv, 2, indices);
    lightmap->meshes[2] =
        (air_lightmap_mesh){.name = NULL, .mesh = 8, .node = -1, .primitive = -1, .page = -1};

    lightmap->vertex_light_count = 1;
    lightmap->vertex_lights = air_allocate(self->context, 1, sizeof *lightmap->vertex_lights);
    air_vertex_light *light = &lightmap->vertex_lights[0];
    *light = (air_vertex_light){.mesh = 9, .node = 1, .primitive = 0, .vertex_count = 1500};
    light->name = air_string_copy(self->context, "leaves");
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        light->layers[k] = lightmap_numbers(self, 3 * light->vertex_count);
    }

    lightmap->probe_set_count = 2;
    lightmap->probe_sets = air_allocate(self->context, 2, sizeof *lightmap->probe_sets);
    lightmap_add_probes(self, &lightmap->probe_sets[0], "by hand", 7);
    air_probe_set *grid = &lightmap->probe_sets[1];
    lightmap_add_probes(self, grid, "", 24);
    grid->grid = true;
    memcpy(grid->size, (size_t[3]){4, 3, 2}, sizeof grid->size);
    memcpy(grid->origin, (float[3]){-1.0f, 0.1f, 2.5f}, sizeof grid->origin);
    memcpy(grid->step, (float[3][3]){{0.3f, 0, 0}, {0, 0.7f, 0}, {0.1f, 0, 1e-7f}},
           sizeof grid->step);
    return lightmap;
}

#endif

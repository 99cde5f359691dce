/* A lightmap's folder: what is saved is loaded, whole or not at all. */
#include <errno.h>
#include <jansson.h>
#include <signal.h>
#include <sys/resource.h>

#include "lightmap/files.h"
#include "lightmap_fixture.h"

static air_lightmap *save_and_load(lightmap_fixture *self, const air_lightmap *lightmap, bool half)
{
    const air_lightmap_save_params params = {.half = half};
    air_lightmap *loaded = NULL;
    if (air_lightmap_save(self->context, lightmap, lightmap_path(self, "bake"), &params) !=
            AIR_OK ||
        air_lightmap_load(self->context, self->path, &loaded) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    return loaded;
}

/* Channels may come in another order. */
static void check_page(const air_image *a, const air_image *b, float relative)
{
    const size_t count = air_image_width(a) * air_image_height(a);
    assert_int_equal(air_image_width(a), air_image_width(b));
    assert_int_equal(air_image_height(a), air_image_height(b));
    assert_int_equal(air_image_channel_count(a), air_image_channel_count(b));
    for (size_t c = 0; c < air_image_channel_count(a); c++) {
        const ptrdiff_t other = air_image_find_channel(b, air_image_channel_name(a, c));
        assert_true(other >= 0);
        for (size_t i = 0; i < count; i++) {
            const float x = air_image_plane_const(a, c)[i];
            assert_true(fabsf(x - air_image_plane_const(b, (size_t)other)[i]) <=
                        relative * fabsf(x));
        }
    }
}

static void check_mesh(const air_lightmap_mesh *a, const air_lightmap_mesh *b)
{
    assert_string_equal(a->name != NULL ? a->name : "", b->name);
    assert_true(a->mesh == b->mesh && a->node == b->node && a->primitive == b->primitive);
    assert_int_equal(a->page, b->page);
    assert_memory_equal(a->scale, b->scale, sizeof a->scale);
    assert_memory_equal(a->offset, b->offset, sizeof a->offset);
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    if (a->sources == NULL) {
        assert_true(b->sources == NULL && b->uv == NULL && b->indices == NULL);
        return;
    }
    assert_memory_equal(a->sources, b->sources, a->vertex_count * sizeof *a->sources);
    assert_memory_equal(a->uv, b->uv, 2 * a->vertex_count * sizeof *a->uv);
    assert_memory_equal(a->indices, b->indices, 3 * a->triangle_count * sizeof *a->indices);
}

static void check_probes(const air_probe_set *a, const air_probe_set *b)
{
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->grid, b->grid);
    assert_memory_equal(a->size, b->size, sizeof a->size);
    assert_memory_equal(a->origin, b->origin, sizeof a->origin);
    assert_memory_equal(a->step, b->step, sizeof a->step);
    assert_memory_equal(a->positions, b->positions, 3 * a->count * sizeof(float));
    assert_memory_equal(a->validity, b->validity, a->count * sizeof(float));
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        assert_memory_equal(a->layers[k], b->layers[k], 27 * a->count * sizeof(float));
    }
}

static void check_equal(const air_lightmap *a, const air_lightmap *b, float page_error)
{
    assert_string_equal(a->scene, b->scene);
    assert_string_equal(a->media, b->media);
    assert_true(a->directional == b->directional && a->photometric == b->photometric);
    assert_int_equal(a->page_count, b->page_count);
    for (size_t i = 0; i < a->page_count; i++) {
        check_page(a->pages[i], b->pages[i], page_error);
    }
    assert_int_equal(a->mesh_count, b->mesh_count);
    for (size_t i = 0; i < a->mesh_count; i++) {
        check_mesh(&a->meshes[i], &b->meshes[i]);
    }
    assert_int_equal(a->vertex_light_count, b->vertex_light_count);
    for (size_t i = 0; i < a->vertex_light_count; i++) {
        const air_vertex_light *x = &a->vertex_lights[i], *y = &b->vertex_lights[i];
        assert_string_equal(x->name, y->name);
        assert_true(x->mesh == y->mesh && x->node == y->node && x->primitive == y->primitive);
        assert_int_equal(x->vertex_count, y->vertex_count);
        for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
            assert_memory_equal(x->layers[k], y->layers[k], 3 * x->vertex_count * sizeof(float));
        }
    }
    assert_int_equal(a->probe_set_count, b->probe_set_count);
    for (size_t i = 0; i < a->probe_set_count; i++) {
        check_probes(&a->probe_sets[i], &b->probe_sets[i]);
    }
}

static void what_is_saved_is_loaded_bit_by_bit(void **state)
{
    lightmap_fixture *self = *state;
    for (int directional = 0; directional < 2; directional++) {
        air_lightmap *lightmap = lightmap_make(self, directional);
        air_lightmap *loaded = save_and_load(self, lightmap, false);
        check_equal(lightmap, loaded, 0.0f);
        air_lightmap_destroy(loaded);
        air_lightmap_destroy(lightmap);
    }
    /* lightmap.json, cuts.bin, probes.json, two pages, one image of vertices */
    assert_int_equal(lightmap_count_files(lightmap_path(self, "bake")), 6);
}

static void halfs_round_pages_and_nothing_else(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, true);
    air_lightmap *loaded = save_and_load(self, lightmap, true);
    /* Half the last place of 11 bits; the numbers are 2^-22 at least or 0, and below 2^-14 halfs
     * are 2^-24 apart, of which numbers of 2^-22 are multiples. */
    check_equal(lightmap, loaded, 0x1p-11f);
    const float *a = air_image_plane_const(lightmap->pages[0], 4);
    const ptrdiff_t channel =
        air_image_find_channel(loaded->pages[0], air_image_channel_name(lightmap->pages[0], 4));
    assert_memory_not_equal(a, air_image_plane_const(loaded->pages[0], (size_t)channel),
                            33 * 17 * sizeof(float));
    air_lightmap_destroy(loaded);
    air_lightmap_destroy(lightmap);
}

static void light_beyond_halfs_is_clamped_and_said(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    air_image_plane(lightmap->pages[1], 3)[5] = 1e6f;
    air_lightmap *loaded = save_and_load(self, lightmap, true);
    const ptrdiff_t channel = air_image_find_channel(loaded->pages[1], "direct.R");
    assert_true(air_image_plane_const(loaded->pages[1], (size_t)channel)[5] == 65504.0f);
    assert_int_equal(self->warnings, 1);
    assert_non_null(strstr(self->warning, "/bake/page-1.exr: 1 values beyond"));
    air_lightmap_destroy(loaded);
    air_lightmap_destroy(lightmap);
}

static void an_empty_lightmap_is_a_lightmap(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    air_lightmap *loaded = save_and_load(self, lightmap, true);
    check_equal(lightmap, loaded, 0.0f);
    assert_int_equal(lightmap_count_files(lightmap_path(self, "bake")), 1);
    air_lightmap_destroy(loaded);
    air_lightmap_destroy(lightmap);
}

static void folders_above_are_made_and_pages_of_an_older_bake_go(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    air_lightmap *loaded = NULL;
    const char *folder = lightmap_path(self, "some/new/bake/");
    assert_int_equal(air_lightmap_save(self->context, lightmap, folder, NULL), AIR_OK);
    air_image_destroy(lightmap->pages[1]);
    lightmap->page_count = 1;
    lightmap->meshes[1].page = 0;
    lightmap_write(self, "some/new/bake/page-3.exr", "not of this set", 15);
    folder = lightmap_path(self, "some/new/bake");
    assert_int_equal(air_lightmap_save(self->context, lightmap, folder, NULL), AIR_OK);
    assert_int_equal(access(lightmap_path(self, "some/new/bake/page-0.exr"), F_OK), 0);
    assert_int_equal(access(lightmap_path(self, "some/new/bake/page-1.exr"), F_OK), -1);
    assert_int_equal(access(lightmap_path(self, "some/new/bake/page-3.exr"), F_OK), 0);
    folder = lightmap_path(self, "some/new/bake");
    assert_int_equal(air_lightmap_load(self->context, folder, &loaded), AIR_OK);
    assert_int_equal(loaded->page_count, 1);
    air_lightmap_destroy(loaded);
    air_lightmap_destroy(lightmap);
}

/* Saves while files may have no more than `bytes`. */
static air_status save_on_a_small_disk(lightmap_fixture *self, const air_lightmap *lightmap,
                                       const char *folder, rlim_t bytes)
{
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit small = {bytes, before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const air_status status = air_lightmap_save(self->context, lightmap, folder, NULL);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)signal(SIGXFSZ, handler);
    return status;
}

static void a_full_disk_leaves_the_older_bake_as_it_was(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *old = lightmap_make(self, false);
    air_lightmap *loaded = save_and_load(self, old, false);
    air_lightmap_destroy(loaded);
    self->random = 99; /* other numbers */
    air_lightmap *new = lightmap_make(self, false);
    /* cuts.bin has 100 bytes, probes.json some 40,000, pages and vertices lie between. */
    static const rlim_t limits[] = {0, 50, 1000, 10000, 20000};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        char folder[LIGHTMAP_NAME];
        (void)snprintf(folder, sizeof folder, "%s/bake", self->folder);
        assert_int_equal(save_on_a_small_disk(self, new, folder, limits[i]), AIR_ERROR_IO);
        lightmap_expect(self, folder);
        lightmap_expect(self, strerror(EFBIG));
        assert_null(strstr(air_context_last_error(self->context), ".part"));
        assert_int_equal(lightmap_count_files(folder), 6);
        assert_int_equal(air_lightmap_load(self->context, folder, &loaded), AIR_OK);
        check_equal(old, loaded, 0.0f);
        air_lightmap_destroy(loaded);
        /* A folder that is new is not left behind either. */
        (void)snprintf(folder, sizeof folder, "%s/fresh", self->folder);
        assert_int_equal(save_on_a_small_disk(self, new, folder, limits[i]), AIR_ERROR_IO);
        assert_int_equal(access(folder, F_OK), -1);
    }
    air_lightmap_destroy(new);
    air_lightmap_destroy(old);
}

static void what_stands_in_the_way_is_named_and_stays(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    lightmap_write(self, "file", "x", 1);
    assert_int_equal(air_lightmap_save(self->context, lightmap, lightmap_path(self, "file"), NULL),
                     AIR_ERROR_IO);
    lightmap_expect(self, "/file: cannot be made a folder: Not a directory");
    assert_int_equal(
        air_lightmap_save(self->context, lightmap, lightmap_path(self, "file/bake"), NULL),
        AIR_ERROR_IO);
    air_lightmap *loaded = save_and_load(self, lightmap, false);
    air_lightmap_destroy(loaded);
    /* A folder called like the last of the files: nothing moves. */
    assert_int_equal(unlink(lightmap_path(self, "bake/probes.json")), 0);
    assert_int_equal(mkdir(lightmap_path(self, "bake/probes.json"), 0777), 0);
    size_t before, after;
    char *page = lightmap_read(self, "bake/page-0.exr", &before);
    air_image_plane(lightmap->pages[0], 0)[0] = 77.0f;
    assert_int_equal(air_lightmap_save(self->context, lightmap, lightmap_path(self, "bake"), NULL),
                     AIR_ERROR_IO);
    lightmap_expect(self, "/bake/probes.json: cannot be written");
    char *still = lightmap_read(self, "bake/page-0.exr", &after);
    assert_int_equal(before, after);
    assert_memory_equal(page, still, before);
    free(still);
    free(page);
    assert_int_equal(lightmap_count_files(lightmap_path(self, "bake")), 6);
    air_lightmap_destroy(lightmap);
}

/* ---- what is no lightmap is not written ---- */

static void refuse_save(lightmap_fixture *self, air_lightmap *lightmap, const char *part)
{
    assert_int_equal(air_lightmap_save(self->context, lightmap, lightmap_path(self, "none"), NULL),
                     AIR_ERROR_ARGUMENT);
    lightmap_expect(self, part);
    assert_int_equal(access(self->path, F_OK), -1);
}

static void what_is_no_lightmap_is_not_saved(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    lightmap->directional = true;
    refuse_save(self, lightmap, "page 0 lacks a channel of \"L0\"");
    lightmap->directional = false;
    float *value = &air_image_plane(lightmap->pages[1], 12)[3];
    *value = NAN;
    refuse_save(self, lightmap, "page 1: number 3 of its coverage.Y is not finite");
    *value = 1.0f;
    lightmap->meshes[0].page = 2;
    refuse_save(self, lightmap, "mesh 0 lies on page 2, there are 2 pages");
    lightmap->meshes[0].page = 0;
    lightmap->meshes[0].node = -1;
    refuse_save(self, lightmap, "mesh 0 has node -1 and primitive 0");
    lightmap->meshes[0].node = 4;
    lightmap->meshes[0].node = 2;
    lightmap->meshes[0].primitive = 3;
    refuse_save(self, lightmap, "mesh 1 is primitive 3 of node 2, as one before it");
    lightmap->meshes[0].node = 4;
    lightmap->meshes[0].primitive = 0;
    lightmap->meshes[1].indices[4] = 5;
    refuse_save(self, lightmap, "mesh 1: index 4 is 5, but it is cut to 5 vertices");
    lightmap->meshes[1].indices[4] = 4;
    lightmap->meshes[1].uv[9] = INFINITY;
    refuse_save(self, lightmap, "mesh 1: number 9 of its uv is not finite");
    lightmap->meshes[1].uv[9] = 0.0f;
    lightmap->meshes[0].triangle_count = 1;
    refuse_save(self, lightmap, "mesh 0 is cut to 0 vertices and 1 triangles");
    lightmap->meshes[0].triangle_count = 0;
    lightmap->vertex_lights[0].layers[2][10] = -INFINITY;
    refuse_save(self, lightmap, "vertex light 0: number 10 of its media is not finite");
    lightmap->vertex_lights[0].layers[2][10] = 0.0f;
    lightmap->probe_sets[1].size[1] = 4;
    refuse_save(self, lightmap, "probe set 1 has 24 probes, which its grid's size does not give");
    lightmap->probe_sets[1].size[1] = 3;
    lightmap->probe_sets[0].validity[6] = 1.5f;
    refuse_save(self, lightmap, "the validity of probe 6 is 1.5");
    lightmap->probe_sets[0].validity[6] = 1.0f;
    air_lightmap *loaded = save_and_load(self, lightmap, false); /* all is mended */
    air_lightmap_destroy(loaded);
    air_lightmap_destroy(lightmap);
}

/* ---- what is no lightmap is not loaded ---- */

static void refuse_load(lightmap_fixture *self, air_status status, const char *part)
{
    air_lightmap *loaded = (air_lightmap *)(uintptr_t)1;
    const air_status got = air_lightmap_load(self->context, lightmap_path(self, "bake"), &loaded);
    if (got != status) {
        fail_msg("status %d (%s), expected %d and \"%s\"", (int)got,
                 air_context_last_error(self->context), (int)status, part);
    }
    lightmap_expect(self, part);
    lightmap_expect(self, self->folder);
    assert_null(loaded);
}

/* Replaces the first `from` in a file by `to`, tries, and puts the file back. */
static void refuse_edit(lightmap_fixture *self, const char *name, const char *from, const char *to,
                        const char *part)
{
    size_t size;
    char *text = lightmap_read(self, name, &size);
    char *at = strstr(text, from);
    if (at == NULL) {
        fail_msg("%s has no %s", name, from);
    }
    char *edited = calloc(size + strlen(to) + 1, 1);
    (void)sprintf(edited, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    lightmap_write(self, name, edited, strlen(edited));
    refuse_load(self, AIR_ERROR_FORMAT, part);
    lightmap_write(self, name, text, size);
    free(edited);
    free(text);
}

static void what_is_wrong_in_the_json_is_named_with_its_place(void **state)
{
    lightmap_fixture *self = *state;
    static const char *const index = "bake/lightmap.json", *const probes = "bake/probes.json";
    air_lightmap *lightmap = lightmap_make(self, true);
    air_lightmap_destroy(save_and_load(self, lightmap, true));
    refuse_edit(self, index, "\"airlight_lightmap\": 1", "\"airlight_lightmap\": 2",
                "lightmap.json: $.airlight_lightmap: expected a whole number from 1 to 1");
    refuse_edit(self, index, "{", "[", "lightmap.json:2:");
    refuse_edit(self, index, "\"directional\": true", "\"directional\": 1",
                "$.directional: expected true or false");
    refuse_edit(self, index, "\"media\": \"impulse\"", "\"media\": \"im\\u0000pulse\"", "not JSON");
    refuse_edit(self, index, "\"scene\"", "\"scenery\"", "$.scene: expected a text");
    refuse_edit(self, index, "page-0.exr", "../page-0.exr", "$.pages[0].file: expected the name");
    refuse_edit(self, index, "page-0.exr", "/page-0.exr", "$.pages[0].file: expected the name");
    refuse_edit(self, index, "\"width\": 33", "\"width\": 32",
                "bake/page-0.exr: the image is 33 x 17, lightmap.json says 32 x 17");
    refuse_edit(self, index, "\"page\": 1", "\"page\": 2",
                "$.meshes[1].page: expected a whole number from -1 to 1");
    refuse_edit(self, index, "\"node\": 4", "\"node\": -1", "mesh 0 has node -1");
    refuse_edit(self, index, "\"node\": 4", "\"node\": 4.0", "$.meshes[0].node: expected a whole");
    refuse_edit(self, index, "\"node\": 4", "\"node\": -2", "$.meshes[0].node: expected a whole");
    refuse_edit(self, index, "\"scale\": [\n    0.5", "\"scale\": [\n    1e39",
                "$.meshes[0].scale[0]: expected a number, finite in single precision");
    refuse_edit(self, index, "\"triangles\": 2", "\"triangles\": 3",
                "$.meshes[1].cut.triangles: expected a whole number from 0 to 2");
    refuse_edit(self, index, "\"vertices\": 5", "\"vertices\": 1000000000",
                "$.meshes[1].cut.vertices: expected a whole number from 0 to 7");
    refuse_edit(self, index, "\"byte\": 16", "\"byte\": 20", "$.meshes[1].cut.triangles: expected");
    refuse_edit(self, index, "\"vertices\": 1500", "\"vertices\": 1000",
                "bake/vertices-0.exr: the image is 1024 x 2, 1000 vertices need 1000 x 1");
    refuse_edit(self, index, "vertices-0.exr", "page-1.exr", "page-1.exr: the image is 8 x 64");
    refuse_edit(self, probes, "\"airlight_probes\": 1", "\"airlight_probes\": 0",
                "probes.json: $.airlight_probes: expected");
    refuse_edit(self, probes, "\"count\": 7", "\"count\": 8",
                "$.sets[0].positions: expected an array of 24 numbers");
    refuse_edit(self, probes, "\"count\": 7", "\"count\": 4000000000",
                "$.sets[0].positions: expected an array of 12000000000 numbers");
    refuse_edit(self, probes, "     4,\n     3,\n     2", "     4,\n     3,\n     3",
                "probe set 1 has 24 probes");
    refuse_edit(self, probes, "\"validity\": [\n", "\"validity\": [\n \"x\",",
                "$.sets[0].validity");
    refuse_edit(self, probes, "\"direct\"", "\"directly\"", "$.sets[0].direct: expected an array");
    air_lightmap_destroy(lightmap);
}

static void files_that_are_missing_or_cut_off_are_named(void **state)
{
    lightmap_fixture *self = *state;
    static const char *const names[] = {"lightmap.json", "page-1.exr", "cuts.bin", "vertices-0.exr",
                                        "probes.json"};
    air_lightmap *lightmap = lightmap_make(self, false);
    air_lightmap_destroy(save_and_load(self, lightmap, true));
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char name[LIGHTMAP_NAME];
        size_t size;
        (void)snprintf(name, sizeof name, "bake/%s", names[i]);
        char *data = lightmap_read(self, name, &size);
        assert_int_equal(unlink(self->path), 0);
        refuse_load(self, AIR_ERROR_IO, names[i]);
        for (size_t k = 0; k < 8; k++) {
            lightmap_write(self, name, data, size * k / 8 + (k == 7 ? size / 8 - 3 : 0));
            /* Of cuts.bin it is the counts in lightmap.json that do not fit. */
            refuse_load(self, AIR_ERROR_FORMAT,
                        i == 2 && k > 1 ? "lightmap.json: $.meshes[1].cut" : names[i]);
        }
        lightmap_write(self, name, data, size);
        free(data);
    }
    air_lightmap_destroy(lightmap);
}

static void loading_without_memory_fails_cleanly(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    air_lightmap_destroy(save_and_load(self, lightmap, true));
    const long live = atomic_load(&self->allocator.live);
    air_status status = AIR_ERROR_MEMORY;
    long allowed = 0;
    for (; status != AIR_OK && allowed < 2000; allowed++) {
        air_lightmap *loaded = NULL;
        atomic_store(&self->allocator.remaining, allowed);
        status = air_lightmap_load(self->context, lightmap_path(self, "bake"), &loaded);
        atomic_store(&self->allocator.remaining, LIGHTMAP_MANY);
        assert_true(status == AIR_OK ? loaded != NULL : loaded == NULL);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        air_lightmap_destroy(loaded);
        assert_int_equal(atomic_load(&self->allocator.live), live);
    }
    assert_int_equal(status, AIR_OK);
    assert_true(allowed > 50);
    air_lightmap_destroy(lightmap);
}

static void saving_without_memory_changes_nothing(void **state)
{
    lightmap_fixture *self = *state;
    air_lightmap *lightmap = lightmap_make(self, false);
    air_lightmap_destroy(save_and_load(self, lightmap, true));
    size_t before;
    char *index = lightmap_read(self, "bake/lightmap.json", &before);
    const long live = atomic_load(&self->allocator.live);
    lightmap->mesh_count = 2; /* another lightmap.json */
    air_status status = AIR_ERROR_MEMORY;
    long allowed = 0;
    for (; status != AIR_OK && allowed < 2000; allowed++) {
        atomic_store(&self->allocator.remaining, allowed);
        status = air_lightmap_save(self->context, lightmap, lightmap_path(self, "bake"), NULL);
        atomic_store(&self->allocator.remaining, LIGHTMAP_MANY);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_int_equal(atomic_load(&self->allocator.live), live);
        assert_int_equal(lightmap_count_files(lightmap_path(self, "bake")), 6);
        size_t after;
        char *now = lightmap_read(self, "bake/lightmap.json", &after);
        assert_int_equal(before == after && memcmp(index, now, after) == 0, status != AIR_OK);
        free(now);
    }
    assert_int_equal(status, AIR_OK);
    assert_true(allowed > 20);
    free(index);
    lightmap->mesh_count = 3;
    air_lightmap_destroy(lightmap);
}

/* ---- the basis ---- */

/* Products of two functions have degree 4 at most: three Gauss nodes in z and eight angles
 * integrate them exactly. */
static void harmonics_are_orthonormal(void **state)
{
    static const double z[3] = {-0.7745966692414834, 0.0, 0.7745966692414834};
    static const double weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
    double sums[9][9] = {{0}};
    (void)state;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 8; k++) {
            const double angle = 2.0 * acos(-1.0) * (k + 0.3) / 8.0, r = sqrt(1.0 - z[i] * z[i]);
            const double direction[3] = {r * cos(angle), r * sin(angle), z[i]};
            double y[9];
            air_lightmap_harmonics(direction, y);
            for (int a = 0; a < 9; a++) {
                for (int b = 0; b < 9; b++) {
                    sums[a][b] += weight[i] * 2.0 * acos(-1.0) / 8.0 * y[a] * y[b];
                }
            }
        }
    }
    for (int a = 0; a < 9; a++) {
        for (int b = 0; b < 9; b++) {
            assert_true(fabs(sums[a][b] - (a == b)) < 1e-14);
        }
    }
}

static void the_file_tells_the_basis_by_an_example(void **state)
{
    lightmap_fixture *self = *state;
    /* (2, -1, 2) / 3 put into the polynomials by hand, times their constants. */
    static const double polynomials[9] = {1.0,        -1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, -2.0 / 9.0,
                                          -2.0 / 9.0, 1.0 / 3.0,  4.0 / 9.0, 3.0 / 9.0};
    static const double constants[9] = {0.2820947918, 0.4886025119, 0.4886025119,
                                        0.4886025119, 1.0925484306, 1.0925484306,
                                        0.3153915653, 1.0925484306, 0.5462742153};
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    air_lightmap_destroy(save_and_load(self, lightmap, true));
    json_error_t error;
    json_t *root = json_load_file(lightmap_path(self, "bake/lightmap.json"), 0, &error);
    const json_t *test = json_object_get(json_object_get(root, "harmonics"), "test");
    for (size_t k = 0; k < 9; k++) {
        const double value = json_number_value(json_array_get(json_object_get(test, "values"), k));
        assert_true(fabs(value - polynomials[k] * constants[k]) < 1e-8); /* nine digits */
    }
    json_decref(root);
    air_lightmap_destroy(lightmap);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_is_saved_is_loaded_bit_by_bit, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(halfs_round_pages_and_nothing_else, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(light_beyond_halfs_is_clamped_and_said, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(an_empty_lightmap_is_a_lightmap, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(folders_above_are_made_and_pages_of_an_older_bake_go,
                                        lightmap_start, lightmap_finish),
        cmocka_unit_test_setup_teardown(a_full_disk_leaves_the_older_bake_as_it_was, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(what_stands_in_the_way_is_named_and_stays, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(what_is_no_lightmap_is_not_saved, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(what_is_wrong_in_the_json_is_named_with_its_place,
                                        lightmap_start, lightmap_finish),
        cmocka_unit_test_setup_teardown(files_that_are_missing_or_cut_off_are_named, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(loading_without_memory_fails_cleanly, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test_setup_teardown(saving_without_memory_changes_nothing, lightmap_start,
                                        lightmap_finish),
        cmocka_unit_test(harmonics_are_orthonormal),
        cmocka_unit_test_setup_teardown(the_file_tells_the_basis_by_an_example, lightmap_start,
                                        lightmap_finish),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

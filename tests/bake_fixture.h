/* bake_fixture.h: what the tests of the baker share: a context that counts, says and stops, meshes
 * with lightmap coordinates, and whether two lightmaps are the same. */
#ifndef AIR_TESTS_BAKE_FIXTURE_H
#define AIR_TESTS_BAKE_FIXTURE_H

#include <limits.h>

#include "airlight/bake.h"
#include "lightmap_fixture.h"
#include "path_scene.h"

typedef struct bake_host {
    failing_allocator allocator;
    air_context *context;
    int warnings;
    char warning[1024]; /* the last one */
    long calls;         /* of the progress callback */
    long stop_after;    /* which call asks to stop; LONG_MAX: none */
    double fraction;    /* the last one said */
    bool backwards;     /* a fraction was less than one before */
    char folder[64];    /* removed at the end */
    char path[LIGHTMAP_PATH];
} bake_host;

static inline void bake_message(void *user, air_message_level level, const char *text)
{
    bake_host *self = user;
    if (level == AIR_MESSAGE_WARNING) {
        self->warnings++;
        (void)snprintf(self->warning, sizeof self->warning, "%s", text);
    }
}

static inline bool bake_progress(void *user, double fraction, const char *what)
{
    bake_host *self = user;
    (void)what;
    self->backwards = self->backwards || fraction < self->fraction;
    self->fraction = fraction;
    return ++self->calls < self->stop_after;
}

static inline void bake_open(bake_host *self, size_t threads)
{
    memset(self, 0, sizeof *self);
    air_context_params params = failing_params(&self->allocator, LIGHTMAP_MANY);
    params.message = bake_message;
    params.message_user = self;
    params.progress = bake_progress;
    params.progress_user = self;
    params.thread_count = threads;
    self->stop_after = LONG_MAX;
    (void)snprintf(self->folder, sizeof self->folder, "/tmp/airlight-bake-XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    assert_int_equal(air_context_create(&params, &self->context), AIR_OK);
}

/* Fails if anything allocated was not freed. */
static inline void bake_close(bake_host *self)
{
    (void)lightmap_remove(self->folder);
    air_context_destroy(self->context);
    assert_int_equal(atomic_load(&self->allocator.live), 0);
}

/* A path in the host's folder, valid until the next call. */
static inline const char *bake_path(bake_host *self, const char *name)
{
    (void)snprintf(self->path, sizeof self->path, "%s/%s", self->folder, name);
    return self->path;
}

static inline void bake_expect(const bake_host *self, const char *part)
{
    const char *message = air_context_last_error(self->context);
    if (strstr(message, part) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", message, part);
    }
}

static inline void bake_expect_warning(const bake_host *self, const char *part)
{
    if (strstr(self->warning, part) == NULL) {
        fail_msg("the last warning, \"%s\", does not say \"%s\"", self->warning, part);
    }
}

/* ---- scenes ---- */

static inline air_scene *bake_scene(const bake_host *self)
{
    void *state = self->context;
    return path_scene(&state);
}

/* A parallelogram as add_quad's with a name and with TEXCOORD_1 of its four corners (NULL: none).
 */
static inline air_mesh_desc bake_quad_desc(const char *name, air_vec3 corner, air_vec3 u,
                                           air_vec3 v, const float *uv, float positions[12])
{
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    air_mesh_desc mesh;
    vec3_store(positions, corner);
    vec3_store(positions + 3, vec3_add(corner, u));
    vec3_store(positions + 6, vec3_add(corner, vec3_add(u, v)));
    vec3_store(positions + 9, vec3_add(corner, v));
    air_mesh_desc_default(&mesh);
    mesh.name = name;
    mesh.positions = positions;
    mesh.uv[1] = uv;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    return mesh;
}

static inline void bake_add_quad(air_scene *scene, const char *name, air_vec3 corner, air_vec3 u,
                                 air_vec3 v, const float *uv, air_handle material)
{
    float positions[12];
    air_handle handle;
    air_mesh_desc mesh = bake_quad_desc(name, corner, u, v, uv, positions);
    mesh.material = material;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
}

/* The whole unit square, v along the quad's second side. */
static const float bake_unit_uv[8] = {0, 0, 1, 0, 1, 1, 0, 1};

/* Six quads of the box from low to high: fronts look out of it, or into it. */
static inline void bake_add_box(air_scene *scene, air_vec3 low, air_vec3 high, bool inwards,
                                air_handle material)
{
    const air_vec3 d = vec3_sub(high, low);
    const air_vec3 x = vec3(d.x, 0, 0), y = vec3(0, d.y, 0), z = vec3(0, 0, d.z);
    const air_vec3 corners[6] = {low, vec3_add(low, x), low, vec3_add(low, y),
                                 low, vec3_add(low, z)};
    /* pairs of sides whose cross product points along the negative, positive x, y, z */
    const air_vec3 sides[6][2] = {{z, y}, {y, z}, {x, z}, {z, x}, {y, x}, {x, y}};
    for (int i = 0; i < 6; i++) {
        add_quad(scene, corners[i], sides[i][inwards ? 1 : 0], sides[i][inwards ? 0 : 1], material);
    }
}

/* ---- bakes ---- */

/* Nothing is smoothed: what was sampled stays. */
static inline air_bake_params bake_raw_params(uint32_t samples, float texels_per_metre)
{
    air_bake_params params;
    air_bake_params_default(&params);
    params.samples = samples;
    params.texels_per_metre = texels_per_metre;
    params.denoise = params.stitch = false;
    params.dilate = 0;
    return params;
}

static inline air_lightmap *bake_well(const bake_host *self, const air_snapshot *snapshot,
                                      const air_bake_params *params)
{
    air_lightmap *lightmap = NULL;
    air_bake_report report;
    if (air_bake(self->context, snapshot, params, &lightmap, &report) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
    assert_non_null(lightmap);
    return lightmap;
}

static inline const float *bake_plane(const air_image *page, const char *name)
{
    const ptrdiff_t channel = air_image_find_channel(page, name);
    if (channel < 0) {
        fail_msg("no channel %s", name);
    }
    return air_image_plane_const(page, (size_t)channel);
}

/* ---- the same ---- */

static inline void bake_assert_near(const char *what, double got, double expected, double slack)
{
    if (!(fabs(got - expected) <= slack)) {
        fail_msg("%s: %.9g, expected %.9g +- %.3g", what, got, expected, slack);
    }
}

static inline void bake_assert_same_floats(const char *what, const float *a, const float *b,
                                           size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (memcmp(&a[i], &b[i], sizeof *a) != 0) {
            fail_msg("%s, number %zu of %zu: %.9g and %.9g", what, i, count, (double)a[i],
                     (double)b[i]);
        }
    }
}

static inline void bake_assert_same(const air_lightmap *a, const air_lightmap *b)
{
    assert_int_equal(a->page_count, b->page_count);
    assert_int_equal(a->vertex_light_count, b->vertex_light_count);
    assert_int_equal(a->probe_set_count, b->probe_set_count);
    for (size_t p = 0; p < a->page_count; p++) {
        const size_t texels = air_image_width(a->pages[p]) * air_image_height(a->pages[p]);
        assert_int_equal(air_image_width(a->pages[p]), air_image_width(b->pages[p]));
        assert_int_equal(air_image_channel_count(a->pages[p]),
                         air_image_channel_count(b->pages[p]));
        for (size_t c = 0; c < air_image_channel_count(a->pages[p]); c++) {
            bake_assert_same_floats(air_image_channel_name(a->pages[p], c),
                                    air_image_plane_const(a->pages[p], c),
                                    air_image_plane_const(b->pages[p], c), texels);
        }
    }
    for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        for (size_t i = 0; i < a->vertex_light_count; i++) {
            bake_assert_same_floats("vertices", a->vertex_lights[i].layers[layer],
                                    b->vertex_lights[i].layers[layer],
                                    3 * a->vertex_lights[i].vertex_count);
        }
        for (size_t i = 0; i < a->probe_set_count; i++) {
            bake_assert_same_floats("probes", a->probe_sets[i].layers[layer],
                                    b->probe_sets[i].layers[layer],
                                    (size_t)3 * AIR_PROBE_COEFFICIENTS * a->probe_sets[i].count);
        }
    }
}

#endif

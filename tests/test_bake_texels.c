/* Places drawn for texels: on the mesh, within the texel, seen from the front. */
#include "bake/texels.h"
#include "bake_fixture.h"

typedef struct work {
    bake_host host;
    air_snapshot *snapshot;
    air_bake_layout *layout;
} work;

static void finish(work *self)
{
    air_bake_layout_destroy(self->layout);
    air_snapshot_release(self->snapshot);
    bake_close(&self->host);
}

static void lay_out(work *self, air_scene *scene, const air_bake_params *params)
{
    self->snapshot = path_freeze(scene);
    if (air_bake_layout_create(self->host.context, self->snapshot, params, &self->layout) !=
        AIR_OK) {
        fail_msg("%s", air_context_last_error(self->host.context));
    }
}

/* The point's weights in a triangle of the mesh, the least of them, and its distance from the
 * plane. */
static double weights_in(const air_mesh *mesh, size_t triangle, air_vec3 point, double weights[3])
{
    const uint32_t *at = mesh->indices + 3 * triangle;
    const air_vec3 a = vec3_load(mesh->positions + 3 * (size_t)at[0]);
    const air_vec3 u = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[1]), a);
    const air_vec3 v = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[2]), a);
    const air_vec3 d = vec3_sub(point, a);
    const double uu = (double)vec3_dot(u, u), uv = (double)vec3_dot(u, v);
    const double vv = (double)vec3_dot(v, v), du = (double)vec3_dot(d, u);
    const double dv = (double)vec3_dot(d, v), det = uu * vv - uv * uv;
    weights[1] = (du * vv - dv * uv) / det;
    weights[2] = (dv * uu - du * uv) / det;
    weights[0] = 1.0 - weights[1] - weights[2];
    const air_vec3 n = vec3_normalize(vec3_cross(u, v));
    return fmax(fabs((double)vec3_dot(d, n)),
                -fmin(weights[0], fmin(weights[1], weights[2])) * sqrt(fmax(uu, vv)));
}

/* Is the point on some triangle of this mesh whose place on the page is in the texel? Positions are
 * floats of some metres: 1e-6, of texels that are 1/16 m wide. */
static bool is_in_texel(const work *self, size_t mesh_index, air_vec3 point, uint32_t x, uint32_t y)
{
    const double slack = 1e-4;
    const air_mesh *mesh = self->snapshot->meshes[mesh_index];
    const air_lightmap_mesh *place = &self->layout->meshes[mesh_index];
    const air_bake_page *page = &self->layout->pages[place->page];
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double w[3], at[2] = {0.0, 0.0};
        if (weights_in(mesh, t, point, w) > 5e-6) {
            continue;
        }
        for (int c = 0; c < 3; c++) {
            const float *uv = place->sources != NULL
                                  ? place->uv + 2 * (size_t)place->indices[3 * t + (size_t)c]
                                  : mesh->uv[1] + 2 * (size_t)mesh->indices[3 * t + (size_t)c];
            for (int k = 0; k < 2; k++) {
                at[k] += w[c] * (double)(uv[k] * place->scale[k] + place->offset[k]);
            }
        }
        at[0] *= (double)page->width;
        at[1] *= (double)page->height;
        if (at[0] > x - slack && at[0] < x + 1 + slack && at[1] > y - slack &&
            at[1] < y + 1 + slack) {
            return true;
        }
    }
    return false;
}

/* Draws some places for all texels of a page; returns how many. */
static size_t check_page(const work *self, const air_bake_page *page)
{
    static const float numbers[][2] = {
        {0.0f, 0.0f}, {0.5f, 0.5f}, {0.999f, 0.2f}, {0.1f, 0x1.fffffep-1f}};
    air_texel_sites sites;
    size_t drawn = 0;
    assert_int_equal(air_texel_sites_init(self->host.context, self->snapshot, page, &sites),
                     AIR_OK);
    for (size_t i = 0; i < sites.count; i++) {
        const uint32_t x = sites.texels[i] % page->width, y = sites.texels[i] / page->width;
        assert_true(air_coverage_area(page->coverage, x, y) > 0.0f);
        assert_true(i == 0 || sites.texels[i] > sites.texels[i - 1]); /* each once */
        for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++) {
            air_path_receiver receiver;
            memset(&receiver, 255, sizeof receiver); /* what is not set is seen */
            assert_true(air_texel_draw(&sites, i, numbers[k], &receiver));
            bool found = false;
            for (size_t p = 0; p < page->part_count; p++) {
                found = found || is_in_texel(self, page->part_meshes[p], receiver.position, x, y);
            }
            if (!found) {
                fail_msg("texel (%u, %u): (%g, %g, %g) is not in it", x, y,
                         (double)receiver.position.x, (double)receiver.position.y,
                         (double)receiver.position.z);
            }
            bake_assert_near("normal", (double)vec3_length(receiver.normal), 1.0, 1e-6);
            assert_true(vec3_dot(receiver.normal, receiver.geometric) > 0.0f);
            assert_false(receiver.sphere);
            assert_true(receiver.offset > 0.0f && receiver.offset < 1e-3f);
            drawn++;
        }
    }
    air_texel_sites_finish(self->host.context, &sites);
    return drawn;
}

static void places_lie_in_their_texels_and_on_the_mesh(void **state)
{
    work self;
    (void)state;
    bake_open(&self.host, 1);
    air_scene *scene = bake_scene(&self.host);
    bake_add_quad(scene, "own", vec3(0, 0, 0), vec3(2, 0.3f, 0), vec3(0, 0, -1), bake_unit_uv,
                  AIR_NONE);
    bake_add_quad(scene, "cut", vec3(5, 1, 0), vec3(1, 0, 1), vec3(0, 0.7f, 0), NULL, AIR_NONE);
    bake_add_box(scene, vec3(-3, 0, 0), vec3(-2.2f, 0.5f, 1.1f), false, AIR_NONE);
    air_bake_params params = bake_raw_params(1, 16.0f);
    params.page_size = 48;
    lay_out(&self, scene, &params);
    size_t drawn = 0;
    for (size_t p = 0; p < self.layout->page_count; p++) {
        drawn += check_page(&self, &self.layout->pages[p]);
    }
    assert_true(drawn > 4000); /* 2 m^2, 1 m^2 and the box at 256 texels a square metre, 4 each */
    finish(&self);
}

/* The same floor, and its mirror image: both look up, whatever way their triangles run. */
static void a_mirrored_mesh_looks_to_its_front(void **state)
{
    static const float mirror[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    static const float normals[12] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    work self;
    float positions[12];
    air_handle handle;
    (void)state;
    for (int smooth = 0; smooth < 2; smooth++) {
        bake_open(&self.host, 1);
        air_scene *scene = bake_scene(&self.host);
        air_mesh_desc mesh = bake_quad_desc("floor", vec3(1, 0, 0), vec3(1, 0, 0), vec3(0, 0, -1),
                                            bake_unit_uv, positions);
        mesh.normals = smooth ? normals : NULL;
        assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
        memcpy(mesh.to_world, mirror, sizeof mirror);
        assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
        const air_bake_params params = bake_raw_params(1, 8.0f);
        lay_out(&self, scene, &params);
        assert_true(self.snapshot->meshes[1]->flip && !self.snapshot->meshes[0]->flip);
        assert_int_equal(self.layout->page_count, 1);
        (void)check_page(&self, &self.layout->pages[0]);
        air_texel_sites sites;
        assert_int_equal(
            air_texel_sites_init(self.host.context, self.snapshot, &self.layout->pages[0], &sites),
            AIR_OK);
        size_t left = 0;
        for (size_t i = 0; i < sites.count; i++) {
            air_path_receiver receiver;
            const float middle[2] = {0.5f, 0.5f};
            assert_true(air_texel_draw(&sites, i, middle, &receiver));
            assert_true(receiver.normal.y > 0.999f && receiver.geometric.y > 0.999f);
            left += receiver.position.x < 0.0f;
        }
        assert_int_equal(2 * left, sites.count);
        air_texel_sites_finish(self.host.context, &sites);
        finish(&self);
    }
}

/* A patch of the unit sphere with its normals: those of the places are the interpolated ones, which
 * are off the sphere's by the sag of a triangle's side, 0.1 rad: 0.1^2 / 8 on each of two sides. */
static void smooth_normals_are_interpolated(void **state)
{
    enum { N = 8, SIDE = N + 1 };
    float positions[3 * SIDE * SIDE];
    uint32_t indices[6 * N * N];
    work self;
    air_mesh_desc mesh;
    air_handle handle;
    (void)state;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const air_vec3 p =
            vec3(0.1f * (float)(i % SIDE - N / 2), 1.0f, -0.1f * (float)(i / SIDE - N / 2));
        vec3_store(positions + 3 * i, vec3_normalize(p));
    }
    for (uint32_t c = 0; c < N * N; c++) {
        const uint32_t a = c / N * SIDE + c % N;
        const uint32_t corners[6] = {a, a + 1, a + SIDE, a + 1, a + SIDE + 1, a + SIDE};
        memcpy(indices + (size_t)6 * c, corners, sizeof corners);
    }
    bake_open(&self.host, 1);
    air_scene *scene = bake_scene(&self.host);
    air_mesh_desc_default(&mesh);
    mesh.positions = mesh.normals = positions;
    mesh.vertex_count = (size_t)SIDE * SIDE;
    mesh.indices = indices;
    mesh.triangle_count = (size_t)2 * N * N;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    const air_bake_params params = bake_raw_params(1, 40.0f);
    lay_out(&self, scene, &params);
    (void)check_page(&self, &self.layout->pages[0]);
    air_texel_sites sites;
    assert_int_equal(
        air_texel_sites_init(self.host.context, self.snapshot, &self.layout->pages[0], &sites),
        AIR_OK);
    double straying = 0.0;
    for (size_t i = 0; i < sites.count; i++) {
        air_path_receiver receiver;
        const float at[2] = {0.3f, 0.6f};
        assert_true(air_texel_draw(&sites, i, at, &receiver));
        const air_vec3 sphere = vec3_normalize(receiver.position);
        const double off = (double)vec3_length(vec3_sub(receiver.normal, sphere));
        assert_true(off < 2.0 * 0.01 / 8.0);
        straying = fmax(straying, (double)vec3_length(vec3_sub(receiver.geometric, sphere)));
    }
    assert_true(straying > 0.02); /* those of the triangles are not smooth */
    air_texel_sites_finish(self.host.context, &sites);
    finish(&self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_lie_in_their_texels_and_on_the_mesh),
        cmocka_unit_test(a_mirrored_mesh_looks_to_its_front),
        cmocka_unit_test(smooth_normals_are_interpolated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

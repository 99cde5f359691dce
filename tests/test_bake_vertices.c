/* Light of vertices: where it is sampled, and what the least squares make of it. */
#include <time.h>

#include "bake/vertices.h"
#include "bake_fixture.h"

/* A plane of n x n cells over [0, size]^2 in x and -z, its inner vertices moved, the diagonals
 * alternating; the last vertex belongs to no triangle. */
typedef struct plane {
    float *positions;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
} plane;

static plane plane_make(uint32_t n, float size)
{
    const uint32_t side = n + 1;
    plane self = {NULL, NULL, (size_t)side * side + 1, (size_t)2 * n * n};
    air_rng rng = air_rng_from_keys(n, 3);
    self.positions = calloc(3 * self.vertex_count, sizeof *self.positions);
    self.indices = calloc(3 * self.triangle_count, sizeof *self.indices);
    assert_true(self.positions != NULL && self.indices != NULL);
    for (uint32_t i = 0; i < side * side; i++) {
        const uint32_t x = i % side, y = i / side;
        const bool inner = x > 0 && y > 0 && x < n && y < n;
        const float dx = inner ? 0.6f * air_rng_float(&rng) - 0.3f : 0.0f;
        const float dy = inner ? 0.6f * air_rng_float(&rng) - 0.3f : 0.0f;
        self.positions[3 * (size_t)i] = size * ((float)x + dx) / (float)n;
        self.positions[3 * (size_t)i + 2] = -size * ((float)y + dy) / (float)n;
    }
    for (uint32_t c = 0; c < n * n; c++) {
        const uint32_t a = c / n * side + c % n, b = a + side;
        const uint32_t even[6] = {a, a + 1, b + 1, a, b + 1, b};
        const uint32_t odd[6] = {a, a + 1, b, a + 1, b + 1, b};
        memcpy(self.indices + (size_t)6 * c, c % 3 == 0 ? even : odd, sizeof even);
    }
    return self;
}

static void plane_free(plane *self)
{
    free(self->positions);
    free(self->indices);
}

static air_scene *plane_alone(const bake_host *host, const plane *p)
{
    air_scene *scene = bake_scene(host);
    air_mesh_desc mesh;
    air_handle handle;
    air_mesh_desc_default(&mesh);
    mesh.name = "plane";
    mesh.positions = p->positions;
    mesh.vertex_count = p->vertex_count;
    mesh.indices = p->indices;
    mesh.triangle_count = p->triangle_count;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    return scene;
}

static air_snapshot *plane_scene(const bake_host *host, const plane *p)
{
    air_scene *scene = plane_alone(host, p);
    add_sun(scene, vec3(0.3f, 1.0f, 2.0f), vec3(0.6f, -0.8f, 0.0f));
    return path_freeze(scene);
}

/* The mean of a function that is linear in space over each vertex' hat: over a triangle the hat's
 * weight of its own corner is A/6, of the others' A/12, of A/3 in all. */
static void hat_means(const air_mesh *mesh, const float *corner_values, float *out)
{
    double *sums = calloc(2 * mesh->vertex_count, sizeof *sums);
    assert_non_null(sums);
    double *weights = sums + mesh->vertex_count;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *at = mesh->indices + 3 * t;
        const air_vec3 a = vec3_load(mesh->positions + 3 * (size_t)at[0]);
        const air_vec3 u = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[1]), a);
        const air_vec3 v = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[2]), a);
        const double area = 0.5 * (double)vec3_length(vec3_cross(u, v));
        const double all = (double)corner_values[at[0]] + (double)corner_values[at[1]] +
                           (double)corner_values[at[2]];
        for (int c = 0; c < 3; c++) {
            sums[at[c]] += area / 12.0 * (all + (double)corner_values[at[c]]);
            weights[at[c]] += area / 3.0;
        }
    }
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const double mean = weights[i] > 0.0 ? sums[i] / weights[i] : 0.0;
        out[3 * i] = (float)mean;
        out[3 * i + 1] = (float)(2.0 * mean);
        out[3 * i + 2] = 0.5f; /* constant, unused vertices too */
    }
    free(sums);
}

/* Light that is linear over the plane comes back at the vertices; a constant stays; what has no
 * triangle is 0. Means are floats (6e-8 of up to 4), their matrix has the condition 4, and the
 * iteration ends at 1e-7 of the whole: 2e-6 in all. The size of the mesh does not matter: from
 * a millimetre to ten kilometres. */
static void linear_light_is_reproduced_at_every_scale(void **state)
{
    const float sizes[] = {1e-3f, 1.0f, 1e4f};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    for (int s = 0; s < 3; s++) {
        plane p = plane_make(12, sizes[s]);
        air_snapshot *snapshot = plane_scene(&host, &p);
        const air_mesh *mesh = snapshot->meshes[0];
        air_vertex_sites sites;
        float *values = calloc(4 * p.vertex_count, sizeof *values);
        assert_non_null(values);
        float *expected = values + 3 * p.vertex_count;
        for (size_t i = 0; i + 1 < p.vertex_count; i++) {
            const float *at = mesh->positions + 3 * i;
            expected[i] = 0.5f + (at[0] - 0.7f * at[2]) / sizes[s];
        }
        hat_means(mesh, expected, values);
        assert_int_equal(air_vertex_sites_init(host.context, mesh, &sites), AIR_OK);
        assert_int_equal(air_vertex_solve(host.context, &sites, values), AIR_OK);
        for (size_t i = 0; i + 1 < p.vertex_count; i++) {
            bake_assert_near("linear", (double)values[3 * i], (double)expected[i], 2e-6);
            bake_assert_near("twice", (double)values[3 * i + 1], 2.0 * (double)expected[i], 4e-6);
            bake_assert_near("constant", (double)values[3 * i + 2], 0.5, 1e-7);
        }
        air_vertex_sites_finish(host.context, &sites);
        free(values);
        air_snapshot_release(snapshot);
        plane_free(&p);
    }
    bake_close(&host);
}

/* Negative values of the least squares beside a dark edge are cut: light is not negative. */
static void no_vertex_is_negative(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    plane p = plane_make(6, 1.0f);
    air_snapshot *snapshot = plane_scene(&host, &p);
    air_vertex_sites sites;
    float *values = calloc(3 * p.vertex_count, sizeof *values);
    assert_non_null(values);
    values[3 * 24] = values[3 * 24 + 1] = values[3 * 24 + 2] = 1.0f; /* the middle one alone */
    assert_int_equal(air_vertex_sites_init(host.context, snapshot->meshes[0], &sites), AIR_OK);
    assert_int_equal(air_vertex_solve(host.context, &sites, values), AIR_OK);
    for (size_t i = 0; i < 3 * p.vertex_count; i++) {
        assert_true(values[i] >= 0.0f);
    }
    assert_true(values[3 * 24] > 1.0f);
    air_vertex_sites_finish(host.context, &sites);
    free(values);
    air_snapshot_release(snapshot);
    plane_free(&p);
    bake_close(&host);
}

/* Moments of what is drawn for a vertex: the mean of its own weight over its hat is
 * (A/6) / (A/3) = 1/2, of its square int 6 h^3 (1 - h) dh = 3/10, of the other corners' 1/4 each;
 * triangles come in proportion to their areas. A lattice of 128 x 128 numbers integrates such
 * smooth functions of u to 1e-4, with jumps at the triangles' borders to 1/128 of a share. */
static void places_follow_the_hat(void **state)
{
    enum { N = 128 };
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    plane p = plane_make(4, 1.0f);
    air_snapshot *snapshot = plane_scene(&host, &p);
    const air_mesh *mesh = snapshot->meshes[0];
    air_vertex_sites sites;
    assert_int_equal(air_vertex_sites_init(host.context, mesh, &sites), AIR_OK);
    float *means = calloc(3 * p.vertex_count, sizeof *means);
    float *x = calloc(p.vertex_count, sizeof *x);
    assert_true(means != NULL && x != NULL);
    for (size_t i = 0; i < p.vertex_count; i++) {
        x[i] = mesh->positions[3 * i];
    }
    hat_means(mesh, x, means);
    for (size_t i = 0; i + 1 < p.vertex_count; i++) {
        double sum = 0.0;
        for (int k = 0; k < N * N; k++) {
            const float u[2] = {((float)(k % N) + 0.5f) / N, ((float)(k / N) + 0.5f) / N};
            air_path_receiver receiver;
            assert_true(air_vertex_draw(&sites, i, u, &receiver));
            assert_true(receiver.normal.y > 0.999f);
            assert_true(fabsf(receiver.position.y) < 1e-6f);
            sum += (double)receiver.position.x / (N * N);
        }
        /* the jump is from one triangle to the next, half a cell's width at most */
        bake_assert_near("mean", sum, (double)means[3 * i], 0.25 / N);
    }
    const float u[2] = {0.5f, 0.5f};
    air_path_receiver receiver;
    assert_false(air_vertex_draw(&sites, p.vertex_count - 1, u, &receiver));
    air_vertex_sites_finish(host.context, &sites);
    free(means);
    free(x);
    air_snapshot_release(snapshot);
    plane_free(&p);
    bake_close(&host);
}

/* One triangle: mean and square of a vertex' own weight, exactly as its density says; the ends of
 * the numbers' range stay within the triangle. */
static void weights_have_the_moments_of_a_hat(void **state)
{
    enum { N = 256 };
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 0, -1};
    const uint32_t indices[3] = {0, 1, 2};
    const plane p = {(float *)corners, (uint32_t *)indices, 3, 1};
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    air_snapshot *snapshot = plane_scene(&host, &p);
    air_vertex_sites sites;
    assert_int_equal(air_vertex_sites_init(host.context, snapshot->meshes[0], &sites), AIR_OK);
    for (size_t corner = 0; corner < 3; corner++) {
        double own[2] = {0.0, 0.0}, other = 0.0;
        for (int k = 0; k < N * N; k++) {
            const float u[2] = {((float)(k % N) + 0.5f) / N, ((float)(k / N) + 0.5f) / N};
            air_path_receiver receiver;
            assert_true(air_vertex_draw(&sites, corner, u, &receiver));
            const double x = (double)receiver.position.x, z = -(double)receiver.position.z;
            const double weights[3] = {1.0 - x - z, x, z};
            own[0] += weights[corner] / (N * N);
            own[1] += weights[corner] * weights[corner] / (N * N);
            other += weights[(corner + 1) % 3] / (N * N);
        }
        /* midpoints of a function whose slope grows as 1/sqrt at both ends: some (1/N)^1.5 */
        bake_assert_near("mean", own[0], 0.5, 1e-4);
        bake_assert_near("mean square", own[1], 0.3, 1e-4);
        bake_assert_near("mean of the next corner", other, 0.25, 1e-4);
        const float ends[4][2] = {
            {0, 0}, {0, 0x1.fffffep-1f}, {0x1.fffffep-1f, 0}, {0x1.fffffep-1f, 0x1.fffffep-1f}};
        for (int k = 0; k < 4; k++) {
            air_path_receiver receiver;
            assert_true(air_vertex_draw(&sites, corner, ends[k], &receiver));
            const float x = receiver.position.x, z = -receiver.position.z;
            assert_true(x >= -1e-6f && z >= -1e-6f && x + z <= 1.0f + 1e-6f);
        }
    }
    air_vertex_sites_finish(host.context, &sites);
    air_snapshot_release(snapshot);
    bake_close(&host);
}

/* The sun on a plane: E_perp times 0.8 at every place, and so at every vertex. */
static void constant_light_is_constant_at_the_vertices(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    plane p = plane_make(5, 2.0f);
    air_snapshot *snapshot = plane_scene(&host, &p);
    air_bake_params params = bake_raw_params(16, 1.0f);
    params.lightmaps = false;
    params.vertices = true;
    air_lightmap *lightmap = bake_well(&host, snapshot, &params);
    assert_int_equal(lightmap->vertex_light_count, 1);
    const air_vertex_light *light = &lightmap->vertex_lights[0];
    assert_int_equal(light->vertex_count, p.vertex_count);
    assert_string_equal(light->name, "plane");
    const double perpendicular[3] = {0.3, 1.0, 2.0};
    for (size_t i = 0; i < p.vertex_count; i++) {
        for (size_t c = 0; c < 3; c++) {
            double sum = 0.0;
            for (int layer = 0; layer < AIR_LAYER_COUNT; layer++) {
                sum += (double)light->layers[layer][3 * i + c];
            }
            if (i + 1 == p.vertex_count) {
                assert_true(sum == 0.0); /* of no triangle */
            } else {
                const double expected = 0.8 * perpendicular[c];
                bake_assert_near("light", sum, expected, 1e-6 * expected); /* ten roundings */
            }
        }
    }
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    plane_free(&p);
    bake_close(&host);
}

/* The irradiance of a lamp at (0.7, 0.6, -0.4). */
static double lamp_at(const double p[3])
{
    const double d[3] = {0.7 - p[0], 0.6 - p[1], -0.4 - p[2]};
    const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    return d[1] / (square * sqrt(square));
}

/* Means over hats, by n^2 pieces of each triangle with the value in their middle. */
static void lamp_means(const air_mesh *mesh, int n, float *out)
{
    double *sums = calloc(2 * mesh->vertex_count, sizeof *sums);
    assert_non_null(sums);
    double *weights = sums + mesh->vertex_count;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *at = mesh->indices + 3 * t;
        const air_vec3 a = vec3_load(mesh->positions + 3 * (size_t)at[0]);
        const air_vec3 u = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[1]), a);
        const air_vec3 v = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[2]), a);
        const double area = 0.5 * (double)vec3_length(vec3_cross(u, v));
        for (int i = 0; i < 2 * n * n; i++) {
            const double third = i % 2 == 0 ? 1.0 / 3.0 : 2.0 / 3.0;
            const double s = (i / 2 % n + third) / n, r = (i / 2 / n + third) / n;
            const double hats[3] = {1.0 - s - r, s, r};
            if (hats[0] < 0.0) {
                continue; /* beyond the long side */
            }
            const air_vec3 p = vec3_madd(vec3_madd(a, (float)s, u), (float)r, v);
            const double place[3] = {(double)p.x, (double)p.y, (double)p.z};
            for (int c = 0; c < 3; c++) {
                sums[at[c]] += area * hats[c] * lamp_at(place);
                weights[at[c]] += area * hats[c];
            }
        }
    }
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        for (int c = 0; c < 3; c++) {
            out[3 * i + (size_t)c] = weights[i] > 0.0 ? (float)(sums[i] / weights[i]) : 0.0f;
        }
    }
    free(sums);
}

/* Sampled hats beside integrated ones, both solved for: 1024 samples of a smooth function in
 * Sobol's order. The lamp is a hat's width and more away; what least squares make of the noise is
 * bounded by their condition, 4. */
static void vertices_have_the_light_integrated_over_their_hats(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    plane p = plane_make(8, 1.0f);
    air_scene *scene = plane_alone(&host, &p);
    add_point_light(scene, vec3(0.7f, 0.6f, -0.4f), 1.0f);
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(1024, 1.0f);
    params.lightmaps = false;
    params.vertices = true;
    air_lightmap *lightmap = bake_well(&host, snapshot, &params);
    const float *light = lightmap->vertex_lights[0].layers[AIR_LAYER_DIRECT];
    float *expected = calloc(3 * p.vertex_count, sizeof *expected);
    assert_non_null(expected);
    air_vertex_sites sites;
    lamp_means(snapshot->meshes[0], 32, expected);
    assert_int_equal(air_vertex_sites_init(host.context, snapshot->meshes[0], &sites), AIR_OK);
    assert_int_equal(air_vertex_solve(host.context, &sites, expected), AIR_OK);
    double most = 0.0, square = 0.0, at_vertex = 0.0;
    const size_t count = p.vertex_count - 1;
    for (size_t i = 0; i < count; i++) {
        const float *at = p.positions + 3 * i;
        const double place[3] = {(double)at[0], (double)at[1], (double)at[2]};
        const double off = (double)light[3 * i] / (double)expected[3 * i] - 1.0;
        const double apart = lamp_at(place) / (double)expected[3 * i] - 1.0;
        most = fmax(most, fabs(off));
        square += off * off / (double)count;
        at_vertex += apart * apart / (double)count;
    }
    print_message("rms %.3g, most %.3g; light at the vertices themselves: rms %.3g\n", sqrt(square),
                  most, sqrt(at_vertex));
    assert_true(sqrt(square) < 2e-3 && most < 1e-2);
    air_vertex_sites_finish(host.context, &sites);
    free(expected);
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    plane_free(&p);
    bake_close(&host);
}

/* A black box in the middle of the plane: in the open E is E_perp, inside nothing is lit. The
 * plane's vertices are as if the box were not there, but for the twentieth of a hat's samples that
 * counts as a gap; least squares make at most twice as much of it (their condition is 4). */
static void what_is_inside_of_something_darkens_no_vertex(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    plane p = plane_make(20, 2.0f);
    air_scene *scene = bake_scene(&host);
    air_mesh_desc mesh;
    air_handle handle;
    add_sun(scene, vec3(1.0f, 1.0f, 1.0f), vec3(0.0f, -1.0f, 0.0f));
    air_mesh_desc_default(&mesh);
    mesh.positions = p.positions;
    mesh.vertex_count = p.vertex_count;
    mesh.indices = p.indices;
    mesh.triangle_count = p.triangle_count;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    bake_add_box(scene, vec3(0.57f, -0.1f, -1.44f), vec3(1.47f, 0.5f, -0.59f), false,
                 add_lambert(scene, 0.0f, 0.0f));
    air_snapshot *snapshot = path_freeze(scene);
    air_bake_params params = bake_raw_params(64, 1.0f);
    params.lightmaps = false;
    params.vertices = true;
    air_lightmap *lightmap = bake_well(&host, snapshot, &params);
    const float *light = lightmap->vertex_lights[0].layers[AIR_LAYER_DIRECT];
    for (size_t i = 0; i + 1 < p.vertex_count; i++) {
        bake_assert_near("light", (double)light[3 * i], 1.0, 0.1);
    }
    air_lightmap_destroy(lightmap);
    air_snapshot_release(snapshot);
    plane_free(&p);
    bake_close(&host);
}

/* 20,000 triangles: preparing, drawing once for each vertex and solving is linear. */
static void a_large_mesh_takes_no_time(void **state)
{
    bake_host host;
    (void)state;
    bake_open(&host, 1);
    plane p = plane_make(100, 10.0f);
    assert_int_equal(p.triangle_count, 20000);
    air_snapshot *snapshot = plane_scene(&host, &p);
    air_vertex_sites sites;
    float *values = calloc(3 * p.vertex_count, sizeof *values);
    assert_non_null(values);
    const clock_t start = clock();
    assert_int_equal(air_vertex_sites_init(host.context, snapshot->meshes[0], &sites), AIR_OK);
    for (size_t i = 0; i + 1 < p.vertex_count; i++) {
        const float u[2] = {0.37f, 0.71f};
        air_path_receiver receiver;
        assert_true(air_vertex_draw(&sites, i, u, &receiver));
        values[3 * i] = receiver.position.x;
    }
    assert_int_equal(air_vertex_solve(host.context, &sites, values), AIR_OK);
    /* measured 25 ms; a quadratic step would take 10,000 times 100 us */
    assert_true((double)(clock() - start) / CLOCKS_PER_SEC < 0.5);
    air_vertex_sites_finish(host.context, &sites);
    free(values);
    air_snapshot_release(snapshot);
    plane_free(&p);
    bake_close(&host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_light_is_reproduced_at_every_scale),
        cmocka_unit_test(no_vertex_is_negative),
        cmocka_unit_test(places_follow_the_hat),
        cmocka_unit_test(weights_have_the_moments_of_a_hat),
        cmocka_unit_test(constant_light_is_constant_at_the_vertices),
        cmocka_unit_test(vertices_have_the_light_integrated_over_their_hats),
        cmocka_unit_test(what_is_inside_of_something_darkens_no_vertex),
        cmocka_unit_test(a_large_mesh_takes_no_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

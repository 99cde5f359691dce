/* The segments of a ray against asking, point by point, which regions hold it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "airlight/airlight.h"
#include "core/random.h"
#include "core/warp.h"
#include "scene/snapshot.h"

static air_context *context;

static int set_up(void **state)
{
    (void)state;
    return air_context_create(NULL, &context) == AIR_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    air_context_destroy(context);
    return 0;
}

/* A medium in a box of half-widths h about c, as a box or as a mesh that is not recognised as one.
 */
typedef struct box {
    float c[3], h[3];
    air_combine combine;
    int32_t priority;
} box;

static void add_box(air_scene *scene, const box *b)
{
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.sigma_s[0] = medium.sigma_s[1] = medium.sigma_s[2] = 1.0f;
    medium.combine = b->combine;
    medium.priority = b->priority;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    for (int i = 0; i < 3; i++) {
        medium.boundary.box_to_world[5 * i] = b->h[i];
        medium.boundary.box_to_world[4 * i + 3] = b->c[i];
    }
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
}

static bool inside(const box *b, air_vec3 p)
{
    return fabsf(p.x - b->c[0]) < b->h[0] && fabsf(p.y - b->c[1]) < b->h[1] &&
           fabsf(p.z - b->c[2]) < b->h[2];
}

/* The rule of medium.h, written down again over media rather than regions. */
static uint64_t expected_set(const box *boxes, uint32_t count, air_vec3 p)
{
    uint32_t winner = UINT32_MAX;
    for (uint32_t i = 0; i < count; i++) {
        if (inside(&boxes[i], p) && boxes[i].combine == AIR_COMBINE_REPLACE &&
            (winner == UINT32_MAX || boxes[i].priority >= boxes[winner].priority)) {
            winner = i;
        }
    }
    uint64_t set = 0;
    for (uint32_t i = 0; i < count; i++) {
        const bool kept =
            winner == UINT32_MAX || i == winner ||
            (boxes[i].combine == AIR_COMBINE_ADD && boxes[i].priority >= boxes[winner].priority);
        if (inside(&boxes[i], p) && kept) {
            set |= (uint64_t)1 << i;
        }
    }
    return set;
}

static uint64_t set_at(const air_segment *segments, size_t count, float t)
{
    for (size_t i = 0; i < count; i++) {
        if (t >= segments[i].t0 && t < segments[i].t1) {
            return segments[i].regions;
        }
    }
    return 0;
}

static void check_ray(const air_media *media, const box *boxes, uint32_t box_count, air_rng *rng)
{
    air_segment segments[AIR_MAX_SEGMENTS];
    const air_vec3 origin = vec3(4.0f * air_rng_float(rng) - 2.0f, 4.0f * air_rng_float(rng) - 2.0f,
                                 4.0f * air_rng_float(rng) - 2.0f);
    const air_vec3 dir = sample_sphere(air_rng_float(rng), air_rng_float(rng));
    const float tmax = 6.0f * air_rng_float(rng);
    const size_t count = air_media_segments(media, origin, dir, tmax, segments);
    for (size_t i = 0; i < count; i++) {
        assert_true(segments[i].t0 < segments[i].t1 && segments[i].regions != 0);
        assert_true(segments[i].t0 >= 0.0f && segments[i].t1 <= tmax);
        assert_true(i == 0 || segments[i - 1].t1 <= segments[i].t0);
    }
    for (int k = 0; k < 64; k++) {
        const float t = tmax * air_rng_float(rng);
        bool near_edge = false;
        for (size_t i = 0; i < count; i++) {
            near_edge =
                near_edge || fabsf(t - segments[i].t0) < 1e-5f || fabsf(t - segments[i].t1) < 1e-5f;
        }
        if (!near_edge) {
            assert_true(set_at(segments, count, t) ==
                        expected_set(boxes, box_count, vec3_madd(origin, t, dir)));
        }
    }
}

static void overlapping_boxes_give_the_sets_that_hold_each_point(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(21, 22);
    for (int scene_index = 0; scene_index < 30; scene_index++) {
        box boxes[6];
        air_scene *scene;
        air_snapshot *snapshot;
        const uint32_t count = 1 + (uint32_t)scene_index % 6;
        assert_int_equal(air_scene_create(context, &scene), AIR_OK);
        for (uint32_t i = 0; i < count; i++) {
            for (int axis = 0; axis < 3; axis++) {
                boxes[i].c[axis] = 2.0f * air_rng_float(&rng) - 1.0f;
                boxes[i].h[axis] = 0.1f + air_rng_float(&rng);
            }
            boxes[i].combine = air_rng_float(&rng) < 0.4f ? AIR_COMBINE_REPLACE : AIR_COMBINE_ADD;
            boxes[i].priority = (int32_t)(air_rng_float(&rng) * 3.0f);
            add_box(scene, &boxes[i]);
        }
        assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
        for (int ray = 0; ray < 200; ray++) {
            check_ray(&snapshot->media, boxes, count, &rng);
        }
        air_snapshot_release(snapshot);
        air_scene_destroy(scene);
    }
}

/* A torus as a boundary: a ray through its plane is inside twice, from within it once less. */
static void a_mesh_is_entered_and_left_as_often_as_the_ray_crosses_it(void **state)
{
    (void)state;
    enum { N = 48, M = 24 };
    static float positions[3 * N * M];
    static uint32_t indices[6 * N * M];
    size_t n = 0;
    for (uint32_t i = 0; i < N; i++) {
        for (uint32_t j = 0; j < M; j++) {
            const double a = 2.0 * AIR_PI * i / N, b = 2.0 * AIR_PI * j / M, r = 2.0 + 0.5 * cos(b);
            const uint32_t i1 = (i + 1) % N, j1 = (j + 1) % M;
            const uint32_t quad[6] = {i * M + j, i1 * M + j1, i1 * M + j,
                                      i * M + j, i * M + j1,  i1 * M + j1};
            float *p = positions + 3 * (i * M + j);
            p[0] = (float)(r * cos(a));
            p[1] = (float)(0.5 * sin(b));
            p[2] = (float)(r * sin(a));
            memcpy(indices + n, quad, sizeof quad);
            n += 6;
        }
    }
    air_scene *scene;
    air_snapshot *snapshot;
    air_medium_desc medium;
    air_handle handle;
    air_segment segments[AIR_MAX_SEGMENTS];
    air_medium_desc_default(&medium);
    medium.sigma_s[0] = 1.0f;
    medium.boundary.kind = AIR_BOUNDARY_MESH;
    medium.boundary.positions = positions;
    medium.boundary.vertex_count = N * M;
    medium.boundary.indices = indices;
    medium.boundary.triangle_count = n / 3;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    const air_vec3 dir = vec3_normalize(vec3(1.0f, 0.013f, 0.021f));
    size_t count = air_media_segments(&snapshot->media, vec3(-4, 0, 0), dir, INFINITY, segments);
    assert_int_equal(count, 2);
    /* Facets lie up to 2.5 (1 - cos(pi/48)) + 0.5 (1 - cos(pi/24)) = 0.01 inside the torus. */
    assert_float_equal(segments[0].t0, 1.5f, 0.02f);
    assert_float_equal(segments[0].t1, 2.5f, 0.02f);
    assert_float_equal(segments[1].t1, 6.5f, 0.05f);
    count = air_media_segments(&snapshot->media, vec3(2, 0, 0), dir, INFINITY, segments);
    assert_int_equal(count, 1);
    assert_float_equal(segments[0].t0, 0.0f, 0.0f);
    count = air_media_segments(&snapshot->media, vec3(0, 0, 0), dir, 1.0f, segments);
    assert_int_equal(count, 0);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
}

/* ---- ellipsoids ---- */

static air_snapshot *ellipsoid(const float map[12], const air_density *density)
{
    air_scene *scene;
    air_snapshot *snapshot;
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.sigma_s[0] = 1.0f;
    medium.boundary.kind = AIR_BOUNDARY_ELLIPSOID;
    memcpy(medium.boundary.box_to_world, map, sizeof medium.boundary.box_to_world);
    if (density != NULL) {
        medium.density = *density;
    }
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

/* A ray is in a sphere for the chord 2 sqrt(r^2 - b^2) about its point nearest to the centre, seen
 * from as far as a thousand radii and from within. */
static void a_sphere_is_crossed_along_its_chord(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 1);
    for (int i = 0; i < 40; i++) {
        const float r = powf(10.0f, 4.0f * air_rng_float(&rng) - 2.0f);
        const air_vec3 c = vec3_scale(
            vec3(air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)), 3.0f * r);
        const float map[12] = {0, r, 0, c.x, 0, 0, r, c.y, r, 0, 0, c.z};
        air_snapshot *snapshot = ellipsoid(map, NULL);
        for (int k = 0; k < 200; k++) {
            air_segment segments[AIR_MAX_SEGMENTS];
            const float far = powf(10.0f, 4.0f * air_rng_float(&rng) - 1.0f) * r;
            const air_vec3 away = sample_sphere(air_rng_float(&rng), air_rng_float(&rng));
            const air_vec3 origin = vec3_madd(c, far, away);
            const air_vec3 target =
                vec3_madd(c, 1.2f * r, sample_sphere(air_rng_float(&rng), air_rng_float(&rng)));
            const air_vec3 dir = vec3_normalize(vec3_sub(target, origin));
            const double o[3] = {(double)origin.x - (double)c.x, (double)origin.y - (double)c.y,
                                 (double)origin.z - (double)c.z};
            const double d[3] = {(double)dir.x, (double)dir.y, (double)dir.z};
            const double dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            const double t = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / dd;
            double b2 = 0.0;
            for (int a = 0; a < 3; a++) {
                b2 += (o[a] + t * d[a]) * (o[a] + t * d[a]);
            }
            const double half2 = ((double)r * (double)r - b2) / dd;
            const size_t count =
                air_media_segments(&snapshot->media, origin, dir, INFINITY, segments);
            if (fabs(half2) < 1e-9 * (double)(r * r)) {
                continue;
            }
            const bool crossed = half2 > 0.0 && t + sqrt(half2) > 0.0;
            assert_int_equal(count, crossed);
            if (crossed) {
                /* a float's rounding of each end */
                const double t0 = fmax(t - sqrt(half2), 0.0), t1 = t + sqrt(half2);
                assert_true(fabs((double)segments[0].t0 - t0) <= 1e-7 * t0);
                assert_true(fabs((double)segments[0].t1 - t1) <= 1e-7 * t1);
            }
        }
        air_snapshot_release(snapshot);
    }
}

static void layers_cut_an_ellipsoid(void **state)
{
    (void)state;
    const float map[12] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    air_medium_desc desc;
    air_segment segments[AIR_MAX_SEGMENTS];
    air_medium_desc_default(&desc);
    desc.density.kind = AIR_DENSITY_LAYERED;
    desc.density.layer_count = 2;
    desc.density.layer_bottom[0] = -INFINITY;
    desc.density.layer_bottom[1] = 0.5f;
    desc.density.layer_density[0] = desc.density.layer_density[1] = 1.0f;
    desc.density.layer_top = 0.75f;
    air_snapshot *snapshot = ellipsoid(map, &desc.density);
    const air_medium *medium = &snapshot->media.media[0];
    assert_int_equal(medium->boundary, AIR_BOUNDARY_ELLIPSOID);
    assert_float_equal(medium->bounds_min[0], -2.0f, 1e-6f);
    assert_float_equal(medium->bounds_max[1], 1.0f, 1e-6f);
    size_t count =
        air_media_segments(&snapshot->media, vec3(0, -5, 0), vec3(0, 1, 0), INFINITY, segments);
    assert_int_equal(count, 2);
    assert_float_equal(segments[0].t0, 4.0f, 1e-6f);
    assert_float_equal(segments[0].t1, 5.5f, 1e-6f);
    assert_float_equal(segments[1].t1, 5.75f, 1e-6f);
    /* x = 2 sqrt(1 - 0.36) at y = 0.6 */
    count =
        air_media_segments(&snapshot->media, vec3(-5, 0.6f, 0), vec3(1, 0, 0), INFINITY, segments);
    assert_int_equal(count, 1);
    assert_float_equal(segments[0].t0, 3.4f, 1e-6f);
    assert_float_equal(segments[0].t1, 6.6f, 1e-6f);
    air_snapshot_release(snapshot);
}

static void a_flat_ellipsoid_is_refused(void **state)
{
    (void)state;
    air_scene *scene;
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    medium.name = "drop";
    medium.boundary.kind = AIR_BOUNDARY_ELLIPSOID;
    medium.boundary.box_to_world[0] = 0.0f;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_ERROR_ARGUMENT);
    assert_string_equal(
        air_context_last_error(context),
        "medium \"drop\": the ellipsoid of boundary has no volume, or is not finite");
    air_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(overlapping_boxes_give_the_sets_that_hold_each_point),
        cmocka_unit_test(a_mesh_is_entered_and_left_as_often_as_the_ray_crosses_it),
        cmocka_unit_test(a_sphere_is_crossed_along_its_chord),
        cmocka_unit_test(layers_cut_an_ellipsoid),
        cmocka_unit_test(a_flat_ellipsoid_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

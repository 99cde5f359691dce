/* Spheres, cylinders and disks as meshes of a scene: what surfaces, snapshots and walks make of
 * them. */
#include "core/random.h"
#include "path_scene.h"
#include "scene/fingerprint.h"
#include "scene_fixture.h"

static air_mesh_desc quadric_desc(air_shape shape, air_vec3 center, float scale)
{
    air_mesh_desc desc;
    air_mesh_desc_default(&desc);
    const float map[12] = {scale, 0, 0, center.x, 0, scale, 0, center.y, 0, 0, scale, center.z};
    desc.name = "ball";
    desc.shape = shape;
    memcpy(desc.to_world, map, sizeof map);
    return desc;
}

static air_handle add_quadric(air_scene *scene, const air_mesh_desc *desc)
{
    air_handle handle;
    assert_int_equal(air_scene_add_mesh(scene, desc, &handle), AIR_OK);
    return handle;
}

static bool look(const air_snapshot *snapshot, air_vec3 origin, air_vec3 dir, air_hit *hit,
                 air_surface *surface)
{
    air_ray ray = {.tmax = INFINITY, .mask = AIR_MASK_CAMERA};
    vec3_store(ray.origin, origin);
    vec3_store(ray.dir, dir);
    air_context_ray_backend(snapshot->context)->intersect(snapshot->accelerator, &ray, 1, hit);
    if (hit->mesh == (uint32_t)AIR_NO_HIT) {
        return false;
    }
    air_surface_make(snapshot, hit, dir, surface);
    return true;
}

/* ---- surfaces ---- */

static void surfaces_lie_on_the_quadric_and_rays_leave_them(void **state)
{
    static const float sizes[4] = {1e-3f, 0.1f, 3.0f, 1e3f};
    for (int i = 0; i < 12; i++) {
        const float size = sizes[i % 4];
        const air_vec3 center = i % 3 == 0 ? vec3_set1(0.0f) : vec3(7.0f, -2.0f, 3.0f);
        air_scene *scene = path_scene(state);
        const air_mesh_desc desc = quadric_desc(AIR_SHAPE_SPHERE, center, size);
        add_quadric(scene, &desc);
        air_snapshot *snapshot = path_freeze(scene);
        air_rng rng = air_rng_from_keys(1, (uint32_t)i);
        for (int k = 0; k < 1000; k++) {
            air_hit hit, next;
            air_surface surface, other;
            const air_vec3 axis = vec3(air_rng_float(&rng) - 0.5f, air_rng_float(&rng) - 0.5f,
                                       air_rng_float(&rng) - 0.5f);
            const air_vec3 from = vec3_madd(center, 5.0f * size, vec3_normalize(axis));
            const air_vec3 dir = vec3_normalize(vec3_sub(center, from));
            assert_true(look(snapshot, from, dir, &hit, &surface));
            const air_vec3 way = vec3_sub(surface.position, center);
            const float far =
                fabsf(surface.position.x) + fabsf(surface.position.y) + fabsf(surface.position.z);
            /* rounding of each coordinate, and of those of the difference here */
            assert_true(fabsf(vec3_length(way) - size) < 0x1p-23f * far + 2e-7f * size);
            assert_true(vec3_dot(surface.normal, way) > 0.99f * vec3_length(way));
            /* nearly along the surface: out there is nothing, in there the far side */
            air_vec3 along = vec3_cross(surface.normal, vec3(0.3f, 0.5f, 0.8f));
            along = vec3_madd(vec3_normalize(along), 1e-3f, surface.normal);
            assert_false(look(snapshot, air_surface_origin(&surface, along), along, &next, &other));
            along = vec3_normalize(vec3_madd(along, -1.0f, surface.normal));
            assert_true(look(snapshot, air_surface_origin(&surface, along), along, &next, &other));
            /* where offsets of rounding are small against the sphere */
            assert_true(size < 0.1f || next.t > 0.5f * size);
        }
        air_snapshot_release(snapshot);
    }
}

static void flipped_normals_turn_front_and_back(void **state)
{
    for (int flip = 0; flip < 2; flip++) {
        for (int shape = 0; shape <= AIR_SHAPE_DISK; shape++) {
            air_scene *scene = path_scene(state);
            air_mesh_desc desc = fixture_square("square");
            if (shape != AIR_SHAPE_TRIANGLES) {
                desc = quadric_desc((air_shape)shape, vec3_set1(0.0f), 1.0f);
            }
            desc.flip_normals = flip == 1;
            desc.material = add_lambert(scene, 0.5f, 2.0f);
            add_quadric(scene, &desc);
            air_snapshot *snapshot = path_freeze(scene);
            air_hit hit;
            air_surface surface;
            /* cylinders are met from the side */
            const air_vec3 from =
                shape == AIR_SHAPE_CYLINDER ? vec3(3.0f, 0.0f, 0.5f) : vec3(0.1f, 0.0f, 3.0f);
            const air_vec3 dir =
                shape == AIR_SHAPE_CYLINDER ? vec3(-1.0f, 0.0f, 0.0f) : vec3(0.0f, 0.0f, -1.0f);
            assert_true(look(snapshot, from, dir, &hit, &surface));
            assert_true((vec3_dot(surface.normal, dir) < 0.0f) == (flip == 0));
            assert_true(surface.emission.x == (flip == 0 ? 2.0f : 0.0f));
            air_snapshot_release(snapshot);
        }
    }
}

static void a_texture_lies_on_a_sphere_by_its_angles(void **state)
{
    static const uint8_t texels[4 * 3] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    air_scene *scene = path_scene(state);
    const air_texture_desc picture = {.name = "four",
                                      .width = 4,
                                      .height = 1,
                                      .channels = 3,
                                      .bytes = texels,
                                      .wrap_u = AIR_WRAP_REPEAT,
                                      .wrap_v = AIR_WRAP_CLAMP,
                                      .filter = AIR_TEXTURE_NEAREST};
    air_material_desc material;
    air_material_desc_default(&material);
    material.specular = 0.0f;
    assert_int_equal(air_scene_add_texture(scene, &picture, &material.base_color_texture.texture),
                     AIR_OK);
    air_mesh_desc desc = quadric_desc(AIR_SHAPE_SPHERE, vec3_set1(0.0f), 1.0f);
    assert_int_equal(air_scene_add_material(scene, &material, &desc.material), AIR_OK);
    add_quadric(scene, &desc);
    air_snapshot *snapshot = path_freeze(scene);
    for (int quarter = 0; quarter < 4; quarter++) {
        const float angle = ((float)quarter + 0.5f) * 0.5f * AIR_PI_F;
        const air_vec3 dir = vec3(-cosf(angle), -sinf(angle), 0.0f);
        air_hit hit;
        air_surface surface;
        assert_true(look(snapshot, vec3_scale(dir, -2.0f), dir, &hit, &surface));
        assert_true(fabsf(surface.bsdf.diffuse.x - (float)texels[3 * quarter] / 255.0f) < 1e-6f);
        assert_true(fabsf(surface.bsdf.diffuse.y - (float)texels[3 * quarter + 1] / 255.0f) <
                    1e-6f);
    }
    air_snapshot_release(snapshot);
}

/* ---- snapshots ---- */

static void vertices_of_a_quadric_and_singular_maps_are_refused(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc desc = fixture_square("ball");
    air_handle handle;
    desc.shape = AIR_SHAPE_SPHERE;
    assert_int_equal(air_scene_add_mesh(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "mesh \"ball\": is a sphere and has 4 vertices");
    desc = quadric_desc(AIR_SHAPE_DISK, vec3_set1(0.0f), 0.0f);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "to_world");
    desc.shape = (air_shape)4;
    assert_int_equal(air_scene_add_mesh(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "shape");
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void a_change_of_a_quadric_is_noticed_and_nothing_else(void **state)
{
    air_scene *scene = path_scene(state);
    air_mesh_desc desc = quadric_desc(AIR_SHAPE_SPHERE, vec3_set1(0.0f), 1.0f);
    const air_handle handle = add_quadric(scene, &desc);
    air_snapshot *first = fixture_commit(scene, NULL);
    assert_int_equal(air_scene_set_mesh(scene, handle, &desc), AIR_OK);
    assert_int_equal(fixture_dirty(scene), 0);
    desc.to_world[3] = 1.0f;
    assert_int_equal(air_scene_set_mesh(scene, handle, &desc), AIR_OK);
    assert_int_equal(fixture_dirty(scene) & (AIR_DIRTY_TRANSFORM | AIR_DIRTY_GEOMETRY),
                     AIR_DIRTY_TRANSFORM);
    desc.shape = AIR_SHAPE_CYLINDER;
    assert_int_equal(air_scene_set_mesh(scene, handle, &desc), AIR_OK);
    assert_true((fixture_dirty(scene) & AIR_DIRTY_GEOMETRY) != 0);
    air_scene_info info;
    desc.material = add_lambert(scene, 0.5f, 1.0f);
    desc.flip_normals = true;
    assert_int_equal(air_scene_set_mesh(scene, handle, &desc), AIR_OK);
    air_snapshot *last = fixture_commit(scene, NULL);
    air_snapshot_info(last, &info);
    assert_true(info.light_present);
    assert_int_equal(info.emissive_triangle_count, 0);
    assert_int_equal(info.triangle_count, 0);
    assert_int_equal(info.mesh_count, 1);
    assert_true(air_fingerprint_snapshot(first) != air_fingerprint_snapshot(last));
    /* x in [0, 2], z in [0, 1]: within rounding outwards */
    assert_true(fabsf(last->bounds_min[0]) < 1e-6f && fabsf(last->bounds_max[0] - 2.0f) < 1e-6f);
    assert_true(fabsf(last->bounds_min[2]) < 1e-6f && fabsf(last->bounds_max[2] - 1.0f) < 1e-6f);
    air_snapshot_release(first);
    air_snapshot_release(last);
    air_scene_destroy(scene);
}

/* ---- walks ---- */

/* Within a closed shape that reflects half and emits half radiance is 1 everywhere. */
static void within_a_sphere_that_gives_what_it_takes_radiance_is_one(void **state)
{
    for (int way = 0; way < 2; way++) {
        air_scene *scene = path_scene(state);
        air_mesh_desc desc = quadric_desc(AIR_SHAPE_SPHERE, vec3(1.0f, 2.0f, 3.0f), 2.0f);
        air_material_desc material;
        air_material_desc_default(&material);
        set3(material.base_color, 0.5f, 0.5f, 0.5f);
        set3(material.emission, 0.5f, 0.5f, 0.5f);
        material.specular = 0.0f;
        material.double_sided = way == 1;
        desc.flip_normals = way == 0;
        desc.to_world[0] = 1.5f; /* an ellipsoid */
        assert_int_equal(air_scene_add_material(scene, &material, &desc.material), AIR_OK);
        add_quadric(scene, &desc);
        air_snapshot *snapshot = path_freeze(scene);
        const probe_result got = measure_radiance(
            snapshot, vec3(1.3f, 2.5f, 3.7f), vec3_normalize(vec3(0.5f, 0.2f, -0.7f)), 200, 512);
        const double one[3] = {1.0, 1.0, 1.0};
        assert_measured("within", &got, one, 0.005);
        air_snapshot_release(snapshot);
    }
}

/* The radiance of a floor of albedo 0.8 below a lamp is 0.8 L (r / d)^2 cos. */
static void a_floor_shows_the_irradiance_of_a_sphere(void **state)
{
    air_scene *scene = path_scene(state);
    const air_vec3 center = vec3(0.5f, 2.0f, 0.0f);
    air_mesh_desc desc = quadric_desc(AIR_SHAPE_SPHERE, center, 0.4f);
    desc.material = add_lambert(scene, 0.0f, 3.0f);
    add_quadric(scene, &desc);
    add_floor(scene, 0.0f, 50.0f, add_lambert(scene, 0.8f, 0.0f));
    air_snapshot *snapshot = path_freeze(scene);
    const air_vec3 at = vec3(-0.7f, 0.0f, 0.3f), from = vec3(-2.0f, 1.0f, 0.3f);
    const air_vec3 way = vec3_sub(center, at);
    const double d2 = (double)vec3_dot(way, way);
    const double expected = 0.8 * 3.0 * 0.16 / d2 * 2.0 / sqrt(d2);
    const double all[3] = {expected, expected, expected};
    const probe_result got =
        measure_radiance(snapshot, from, vec3_normalize(vec3_sub(at, from)), 1, 256);
    assert_measured("floor", &got, all, 0.002);
    air_snapshot_release(snapshot);
}

/* A lamp within fog: connections drawn by sight against those to triangles by area. The triangles
 * lie between the inscribed and the circumscribed ones. */
static void fog_about_a_sphere_is_lit_as_about_its_triangles(void **state)
{
    enum { RINGS = 64, SPOKES = 128 };
    static float positions[3 * (RINGS + 1) * SPOKES];
    static uint32_t indices[6 * RINGS * SPOKES];
    probe_result got[2];
    for (uint32_t i = 0; i < (RINGS + 1) * SPOKES; i++) {
        const double theta = AIR_PI * (i / SPOKES) / RINGS,
                     phi = 2.0 * AIR_PI * (i % SPOKES) / SPOKES;
        const double r = 0.3 * (1.0 + 0.25 * AIR_PI * AIR_PI / (RINGS * RINGS) / 2.0);
        set3(positions + 3 * i, (float)(r * sin(theta) * cos(phi)),
             (float)(r * sin(theta) * sin(phi)), (float)(r * cos(theta)));
    }
    for (uint32_t i = 0; i < RINGS * SPOKES; i++) {
        const uint32_t a = i, b = i / SPOKES * SPOKES + (i + 1) % SPOKES;
        const uint32_t two[6] = {a, a + SPOKES, b, b, a + SPOKES, b + SPOKES};
        memcpy(indices + 6 * i, two, sizeof two);
    }
    for (int way = 0; way < 2; way++) {
        air_scene *scene = path_scene(state);
        air_mesh_desc desc = quadric_desc(AIR_SHAPE_SPHERE, vec3_set1(0.0f), 0.3f);
        if (way == 1) {
            air_mesh_desc_default(&desc);
            desc.positions = positions;
            desc.vertex_count = (RINGS + 1) * SPOKES;
            desc.indices = indices;
            desc.triangle_count = 2 * RINGS * SPOKES;
        }
        desc.material = add_lambert(scene, 0.0f, 5.0f);
        add_quadric(scene, &desc);
        air_medium_desc fog = medium_in_box(vec3_set1(0.0f), vec3_set1(2.0f));
        set3(fog.sigma_s, 0.3f, 0.3f, 0.3f);
        set3(fog.sigma_a, 0.1f, 0.1f, 0.1f);
        fog.phase.kind = AIR_PHASE_HG;
        fog.phase.g = 0.4f;
        add_medium(scene, &fog);
        air_snapshot *snapshot = path_freeze(scene);
        got[way] = measure_radiance(snapshot, vec3(0.5f, -3.0f, 0.2f), vec3(0.0f, 1.0f, 0.0f),
                                    UINT32_MAX, 8192);
        air_snapshot_release(snapshot);
    }
    assert_same_measured("fog", &got[0], &got[1], 0.004);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_lie_on_the_quadric_and_rays_leave_them),
        cmocka_unit_test(flipped_normals_turn_front_and_back),
        cmocka_unit_test(a_texture_lies_on_a_sphere_by_its_angles),
        cmocka_unit_test(vertices_of_a_quadric_and_singular_maps_are_refused),
        cmocka_unit_test(a_change_of_a_quadric_is_noticed_and_nothing_else),
        cmocka_unit_test(within_a_sphere_that_gives_what_it_takes_radiance_is_one),
        cmocka_unit_test(a_floor_shows_the_irradiance_of_a_sphere),
        cmocka_unit_test(fog_about_a_sphere_is_lit_as_about_its_triangles),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

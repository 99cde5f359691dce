/* Surfaces: where rays leave from, normals, coverage, emission, textures. */
#include <math.h>

#include "core/random.h"
#include "scene/surface.h"
#include "scene_fixture.h"

static air_vec3 random_unit(air_rng *rng)
{
    for (;;) {
        const air_vec3 v = vec3(2.0f * air_rng_float(rng) - 1.0f, 2.0f * air_rng_float(rng) - 1.0f,
                                2.0f * air_rng_float(rng) - 1.0f);
        const float square = vec3_dot(v, v);
        if (square > 1e-2f && square < 1.0f)
            return vec3_normalize(v);
    }
}

/* 10^x, x uniform. */
static float random_power(air_rng *rng, float low, float high)
{
    return powf(10.0f, low + (high - low) * air_rng_float(rng));
}

static air_hit shoot(const air_snapshot *snapshot, air_vec3 origin, air_vec3 dir)
{
    air_ray ray = {.tmin = 0.0f, .tmax = INFINITY, .mask = AIR_MASK_SCATTER};
    air_hit hit;
    vec3_store(ray.origin, origin);
    vec3_store(ray.dir, dir);
    const air_ray_backend *rays = air_context_ray_backend(snapshot->context);
    rays->intersect(snapshot->accelerator, &ray, 1, &hit);
    return hit;
}

/* Shoots along dir from in front of `target` and makes the surface it meets. */
static air_surface surface_at(const air_snapshot *snapshot, air_vec3 target, air_vec3 dir)
{
    const air_hit hit = shoot(snapshot, vec3_madd(target, -1.0f, dir), dir);
    air_surface surface;
    assert_true(hit.mesh != (uint32_t)AIR_NO_HIT);
    air_surface_make(snapshot, &hit, dir, &surface);
    return surface;
}

static void assert_near(air_vec3 a, air_vec3 b, float tolerance)
{
    if (!(vec3_length(vec3_sub(a, b)) <= tolerance))
        fail_msg("(%g %g %g) is not (%g %g %g)", (double)a.x, (double)a.y, (double)a.z, (double)b.x,
                 (double)b.y, (double)b.z);
}

/* ---- offsets ---- */

typedef struct offset_count {
    size_t rays, hits;
} offset_count;

/* Rays leave random points of triangle 0 to both sides, half of them at grazing angles. */
static void leave_triangle(const air_snapshot *snapshot, const air_vec3 p[3], air_rng *rng,
                           offset_count *count)
{
    const air_vec3 e1 = vec3_sub(p[1], p[0]), e2 = vec3_sub(p[2], p[0]);
    const air_vec3 n = vec3_normalize(vec3_cross(e1, e2));
    const float size = fmaxf(vec3_length(e1), vec3_length(e2));
    for (int i = 0; i < 40; ++i) {
        float u = air_rng_float(rng), v = air_rng_float(rng);
        if (u + v > 1.0f) {
            u = 1.0f - u;
            v = 1.0f - v;
        }
        const air_vec3 target = vec3_add(p[0], vec3_madd(vec3_scale(e1, u), v, e2));
        const air_vec3 in =
            vec3_neg(vec3_normalize(vec3_madd(random_unit(rng), i % 2 ? 1.5f : -1.5f, n)));
        const air_hit hit = shoot(snapshot, vec3_madd(target, -size, in), in);
        if (hit.mesh == (uint32_t)AIR_NO_HIT)
            continue; /* beside the edge by rounding */
        air_surface surface;
        air_surface_make(snapshot, &hit, in, &surface);
        for (int j = 0; j < 10; ++j) {
            air_vec3 out = random_unit(rng);
            /* grazing down to 1e-3: below about 1e-4 the side of the plane is itself a matter of
             * rounding */
            const float keep = j % 2 ? 1.0f : random_power(rng, -3.0f, 0.0f);
            out = vec3_normalize(
                vec3_madd(out, (keep - 1.0f) * vec3_dot(out, surface.normal), surface.normal));
            if (fabsf(vec3_dot(out, surface.normal)) < 1e-3f)
                continue;
            const air_hit next = shoot(snapshot, air_surface_origin(&surface, out), out);
            ++count->rays;
            count->hits += next.mesh != (uint32_t)AIR_NO_HIT;
        }
    }
}

/* A triangle of that size at that distance from the origin, and, where asked for, the other half of
 * its parallelogram, which is coplanar but for the rounding of its vertices. */
static void leave_random_triangle(air_context *context, air_rng *rng, float size, float distance,
                                  float width, bool neighbour, offset_count *count)
{
    const air_vec3 center = vec3_scale(random_unit(rng), distance);
    const air_vec3 a = random_unit(rng), side = random_unit(rng);
    air_vec3 p[4] = {center, vec3_madd(center, size, a)};
    p[2] = vec3_madd(vec3_madd(center, size * air_rng_float(rng), a), size * width, side);
    p[3] = vec3_add(vec3_sub(p[1], p[0]), p[2]);
    const uint32_t indices[6] = {0, 1, 2, 1, 3, 2};
    air_mesh_desc desc;
    air_mesh_desc_default(&desc);
    desc.positions = &p[0].x;
    desc.vertex_count = 4;
    desc.indices = indices;
    desc.triangle_count = neighbour ? 2 : 1;
    air_handle mesh;
    air_scene *scene = fixture_scene(context);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    leave_triangle(snapshot, p, rng, count);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
}

static void rays_leaving_a_triangle_do_not_meet_it_or_its_coplanar_neighbour(void **state)
{
    air_context *context = fixture_context();
    air_rng rng = air_rng_from_keys(1, 2);
    offset_count count = {0, 0};
    (void)state;
    for (int i = 0; i < 1500; ++i) {
        const float size = random_power(&rng, -3.0f, 4.0f);
        /* up to 1e4 times as far as it is large: beyond, the vertices of a float triangle are not a
         * triangle's */
        const float distance = i % 3 == 0 ? 0.0f : size * random_power(&rng, -1.0f, 4.0f);
        leave_random_triangle(context, &rng, size, distance, 0.2f + 0.8f * air_rng_float(&rng),
                              i % 2 == 1, &count);
    }
    assert_true(count.rays > 300000);
    assert_int_equal(count.hits, 0);
    air_context_destroy(context);
}

static void rays_leaving_a_sliver_do_not_meet_it(void **state)
{
    air_context *context = fixture_context();
    air_rng rng = air_rng_from_keys(3, 4);
    offset_count count = {0, 0};
    (void)state;
    for (int i = 0; i < 500; ++i)
        leave_random_triangle(context, &rng, random_power(&rng, -3.0f, 4.0f), 0.0f,
                              random_power(&rng, -2.5f, 0.0f), false, &count);
    assert_true(count.rays > 100000);
    assert_int_equal(count.hits, 0);
    air_context_destroy(context);
}

static void offsets_stay_a_millionth_of_what_is_around(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc desc = fixture_square("square");
    air_handle mesh;
    (void)state;
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    const air_surface surface = surface_at(snapshot, vec3(0.5f, 0.25f, 0.0f), vec3(0, 0, -1));
    /* the square has a diagonal of 2.83 m and its plane passes through the origin: 2^-23 * 5 * 2.83
     * = 1.7e-6 */
    assert_true(surface.offset > 0.0f && surface.offset < 2e-6f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- normals ---- */

static void positions_come_from_barycentrics(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc desc = fixture_square("square");
    air_handle mesh;
    (void)state;
    const float to_world[12] = {2, 0, 0, 5, 0, 2, 0, 6, 0, 0, 2, 7};
    memcpy(desc.to_world, to_world, sizeof to_world);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    const air_vec3 target = vec3(5.5f, 6.75f, 7.0f);
    const air_surface surface =
        surface_at(snapshot, target, vec3_normalize(vec3(0.3f, 0.2f, -0.9f)));
    /* u and v carry an error of a few 2^-24 of an edge of 4 m */
    assert_near(surface.position, target, 4e-6f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void mirrored_meshes_keep_their_front(void **state)
{
    air_context *context = fixture_context();
    (void)state;
    const float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        air_scene *scene = fixture_scene(context);
        air_mesh_desc desc = fixture_square("square");
        air_handle mesh;
        desc.normals = normals;
        if (mirrored)
            desc.to_world[0] = -1.0f;
        assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
        air_snapshot *snapshot = fixture_commit(scene, NULL);
        assert_int_equal(snapshot->meshes[0]->flip, mirrored);
        const air_surface front = surface_at(snapshot, vec3(0.3f, 0.1f, 0), vec3(0, 0, -1));
        const air_surface back = surface_at(snapshot, vec3(0.3f, 0.1f, 0), vec3(0, 0, 1));
        assert_near(front.normal, vec3(0, 0, 1), 0.0f);
        assert_near(back.normal, vec3(0, 0, 1), 0.0f);
        assert_near(front.bsdf.frame.n, vec3(0, 0, 1), 0.0f);
        assert_near(back.bsdf.frame.n, vec3(0, 0, -1), 0.0f);
        air_snapshot_release(snapshot);
        air_scene_destroy(scene);
    }
    air_context_destroy(context);
}

static void shading_normals_are_interpolated_with_the_inverse_transpose(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc desc = fixture_square("square");
    air_handle mesh;
    (void)state;
    /* normals lean by their x; the space is stretched fourfold in x, so that they lean a quarter of
     * that */
    const float normals[12] = {-0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f, -0.6f, 0, 0.8f};
    desc.normals = normals;
    desc.to_world[0] = 4.0f;
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    const air_vec3 edge = vec3_normalize(vec3(0.6f / 4.0f, 0, 0.8f));
    const air_surface surface = surface_at(snapshot, vec3(2.0f, 0.25f, 0), vec3(0, 0, -1));
    /* x = 2 of [-4,4]: three quarters of the way from the left normal to the right one */
    const air_vec3 expected =
        vec3_normalize(vec3_madd(vec3_scale(vec3(-edge.x, 0, edge.z), 0.25f), 0.75f, edge));
    assert_near(surface.bsdf.frame.n, expected, 1e-6f);
    assert_near(surface.normal, vec3(0, 0, 1), 0.0f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void shading_normals_face_the_ray(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc desc = fixture_square("square");
    air_handle mesh;
    air_rng rng = air_rng_from_keys(5, 6);
    (void)state;
    float normals[12];
    for (size_t i = 0; i < 4; ++i)
        vec3_store(normals + 3 * i, random_unit(&rng));
    desc.normals = normals;
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    for (int i = 0; i < 2000; ++i) {
        const air_vec3 dir = random_unit(&rng);
        const air_vec3 target =
            vec3(1.8f * air_rng_float(&rng) - 0.9f, 1.8f * air_rng_float(&rng) - 0.9f, 0);
        if (fabsf(dir.z) < 0.01f)
            continue;
        const air_surface surface = surface_at(snapshot, target, dir);
        assert_true(vec3_dot(surface.bsdf.frame.n, dir) < 0.0f);
        assert_true(vec3_dot(surface.bsdf.normal, dir) < 0.0f);
        assert_true(vec3_dot(surface.bsdf.frame.n, surface.bsdf.normal) > 0.0f);
    }
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- textures and materials ---- */

static air_handle add_texel(air_scene *scene, const float rgba[4])
{
    air_texture_desc desc = {
        .name = "texel", .width = 1, .height = 1, .channels = 4, .floats = rgba};
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_texture(scene, &desc, &handle), AIR_OK);
    return handle;
}

/* A square with that material, and what a ray from the front (or back) meets. */
static air_surface square_of(air_scene *scene, const air_mesh_desc *square,
                             const air_material_desc *material, air_vec3 target, air_vec3 dir)
{
    air_mesh_desc desc = *square;
    air_handle mesh;
    assert_int_equal(air_scene_add_material(scene, material, &desc.material), AIR_OK);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    const air_surface surface = surface_at(snapshot, target, dir);
    air_snapshot_release(snapshot);
    assert_int_equal(air_scene_remove(scene, mesh), AIR_OK);
    assert_int_equal(air_scene_remove(scene, desc.material), AIR_OK);
    return surface;
}

static void normal_maps_lean_along_the_texture(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_mesh_desc square = fixture_square("square");
    air_material_desc material;
    (void)state;
    /* a normal of (0.6, 0, 0.8) and one of (0, 0.6, 0.8), each stored as (n + 1) / 2 */
    const float right[4] = {0.8f, 0.5f, 0.9f, 1}, up[4] = {0.5f, 0.8f, 0.9f, 1};
    const air_vec3 target = vec3(0.3f, 0.1f, 0), down = vec3(0, 0, -1);
    air_material_desc_default(&material);
    material.specular = 0.0f;
    /* the fixture's u grows with x and its v with -y: the map's x is world x and its y is world y
     */
    material.normal_texture.texture = add_texel(scene, right);
    air_surface surface = square_of(scene, &square, &material, target, down);
    assert_near(surface.bsdf.frame.n, vec3(0.6f, 0, 0.8f), 1e-6f);
    /* a texture mirrored in u mirrors what it shows */
    material.normal_texture.uv_transform[0] = -1.0f;
    surface = square_of(scene, &square, &material, target, down);
    assert_near(surface.bsdf.frame.n, vec3(-0.6f, 0, 0.8f), 1e-6f);
    material.normal_texture.texture = add_texel(scene, up);
    surface = square_of(scene, &square, &material, target, down);
    assert_near(surface.bsdf.frame.n, vec3(0, 0.6f, 0.8f), 1e-6f);
    /* supplied tangents win: these run along y, so that the map's y is -x */
    const float tangents[16] = {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1};
    air_mesh_desc with_tangents = square;
    with_tangents.tangents = tangents;
    surface = square_of(scene, &with_tangents, &material, target, down);
    assert_near(surface.bsdf.frame.n, vec3(-0.6f, 0, 0.8f), 1e-6f);
    /* mirroring the mesh in x mirrors the relief: -x becomes x */
    with_tangents.to_world[0] = -1.0f;
    surface = square_of(scene, &with_tangents, &material, target, down);
    assert_near(surface.bsdf.frame.n, vec3(0.6f, 0, 0.8f), 1e-6f);
    /* half the scale: (0, 0.3, 0.8) made unit */
    material.normal_scale = 0.5f;
    surface = square_of(scene, &square, &material, target, down);
    assert_near(surface.bsdf.frame.n, vec3_normalize(vec3(0, 0.3f, 0.8f)), 1e-6f);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void factors_textures_and_vertex_colours_multiply(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc square = fixture_square("square");
    air_material_desc material;
    (void)state;
    const float texel[4] = {0.5f, 0.25f, 1.0f, 1.0f}, glow[4] = {1.0f, 0.5f, 0.0f, 1.0f};
    const float colors[16] = {1, 1, 0.5f, 1, 1, 1, 0.5f, 1, 1, 1, 0.5f, 1, 1, 1, 0.5f, 1};
    square.colors = colors;
    air_material_desc_default(&material);
    material.specular = 0.0f;
    material.base_color[0] = 0.8f;
    material.base_color_texture.texture = add_texel(scene, texel);
    material.emission[0] = material.emission[1] = material.emission[2] = 3.0f;
    material.emission_texture.texture = add_texel(scene, glow);
    const air_surface surface =
        square_of(scene, &square, &material, vec3(0.3f, 0.1f, 0), vec3(0, 0, -1));
    assert_near(surface.bsdf.diffuse, vec3(0.4f, 0.25f, 0.5f), 1e-6f);
    assert_near(surface.emission, vec3(3.0f, 1.5f, 0.0f), 1e-6f);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void metallic_is_blue_and_roughness_green(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_mesh_desc square = fixture_square("square");
    air_material_desc material;
    (void)state;
    const float texel[4] = {0.0f, 0.5f, 1.0f, 1.0f};
    air_material_desc_default(&material);
    material.metallic = 1.0f;
    material.roughness = 0.8f;
    material.metallic_roughness_texture.texture = add_texel(scene, texel);
    const air_surface surface =
        square_of(scene, &square, &material, vec3(0.3f, 0.1f, 0), vec3(0, 0, -1));
    assert_near(surface.bsdf.diffuse, vec3_set1(0.0f), 0.0f);
    assert_near(surface.bsdf.f0, vec3_set1(1.0f), 1e-6f);
    assert_true(fabsf(surface.bsdf.alpha - 0.4f * 0.4f) < 1e-6f);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void emission_leaves_the_front_unless_double_sided(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_mesh_desc square = fixture_square("square");
    const air_vec3 target = vec3(0.3f, 0.1f, 0), down = vec3(0, 0, -1), up = vec3(0, 0, 1);
    air_material_desc material;
    (void)state;
    air_material_desc_default(&material);
    material.emission[1] = 2.0f;
    air_surface surface = square_of(scene, &square, &material, target, down);
    assert_near(surface.emission, vec3(0, 2, 0), 0.0f);
    assert_true(surface.emitter != UINT32_MAX);
    surface = square_of(scene, &square, &material, target, up);
    assert_near(surface.emission, vec3(0, 0, 0), 0.0f);
    material.double_sided = true;
    surface = square_of(scene, &square, &material, target, up);
    assert_near(surface.emission, vec3(0, 2, 0), 0.0f);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void unlit_surfaces_show_their_colour_and_reflect_nothing(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_mesh_desc square = fixture_square("square");
    air_material_desc material;
    (void)state;
    air_material_desc_default(&material);
    material.unlit = true;
    material.base_color[2] = 0.25f;
    material.emission[0] = 5.0f; /* has no say */
    const air_surface surface =
        square_of(scene, &square, &material, vec3(0.3f, 0.1f, 0), vec3(0, 0, -1));
    assert_near(surface.emission, vec3(1, 1, 0.25f), 0.0f);
    assert_int_equal(surface.emitter, UINT32_MAX);
    assert_true(vec3_is_zero(surface.bsdf.diffuse) && vec3_is_zero(surface.bsdf.f0));
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void coverage_follows_the_alpha_mode(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_mesh_desc square = fixture_square("square");
    (void)state;
    const struct {
        air_alpha_mode mode;
        float alpha, texel, expected;
    } cases[] = {{AIR_ALPHA_OPAQUE, 0.25f, 0.5f, 1.0f},
                 {AIR_ALPHA_BLEND, 0.25f, 0.5f, 0.125f},
                 {AIR_ALPHA_BLEND, 1.0f, 1.0f, 1.0f},
                 {AIR_ALPHA_MASK, 1.0f, 0.5f, 1.0f},
                 {AIR_ALPHA_MASK, 0.75f, 0.5f, 0.0f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const float texel[4] = {1, 1, 1, cases[i].texel};
        air_material_desc material;
        air_material_desc_default(&material);
        material.alpha_mode = cases[i].mode; /* the cut-off is 0.5: what equals it stays */
        material.base_color[3] = cases[i].alpha;
        material.base_color_texture.texture = add_texel(scene, texel);
        const air_surface surface =
            square_of(scene, &square, &material, vec3(0.3f, 0.1f, 0), vec3(0, 0, -1));
        assert_true(surface.alpha == cases[i].expected);
    }
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void shadow_rays_see_the_same_coverage(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc desc = fixture_square("square");
    air_material_desc material;
    air_handle mesh;
    air_rng rng = air_rng_from_keys(7, 8);
    (void)state;
    const float texels[8] = {1, 0.1f, 1, 0.9f, 1, 0.6f, 1, 0.3f}; /* grey and alpha, 2 x 2 */
    air_texture_desc texture = {.width = 2, .height = 2, .channels = 2, .floats = texels};
    air_material_desc_default(&material);
    material.alpha_mode = AIR_ALPHA_BLEND;
    assert_int_equal(air_scene_add_texture(scene, &texture, &material.base_color_texture.texture),
                     AIR_OK);
    assert_int_equal(air_scene_add_material(scene, &material, &desc.material), AIR_OK);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    assert_true(snapshot->has_alpha);
    for (int i = 0; i < 500; ++i) {
        const air_vec3 origin =
            vec3(1.8f * air_rng_float(&rng) - 0.9f, 1.8f * air_rng_float(&rng) - 0.9f, 1);
        const air_hit hit = shoot(snapshot, origin, vec3(0, 0, -1));
        air_surface surface;
        air_surface_make(snapshot, &hit, vec3(0, 0, -1), &surface);
        assert_true(surface.alpha == air_surface_alpha(snapshot, &hit));
        assert_true(surface.alpha > 0.0999f && surface.alpha < 0.9001f);
    }
    /* at the centres of the texels, row 0 at the top, which is +y */
    for (int i = 0; i < 4; ++i) {
        const air_vec3 origin = vec3(i % 2 ? 0.5f : -0.5f, i / 2 ? -0.5f : 0.5f, 1);
        const air_hit hit = shoot(snapshot, origin, vec3(0, 0, -1));
        assert_true(fabsf(air_surface_alpha(snapshot, &hit) - texels[2 * i + 1]) < 1e-5f);
    }
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_leaving_a_triangle_do_not_meet_it_or_its_coplanar_neighbour),
        cmocka_unit_test(rays_leaving_a_sliver_do_not_meet_it),
        cmocka_unit_test(offsets_stay_a_millionth_of_what_is_around),
        cmocka_unit_test(positions_come_from_barycentrics),
        cmocka_unit_test(mirrored_meshes_keep_their_front),
        cmocka_unit_test(shading_normals_are_interpolated_with_the_inverse_transpose),
        cmocka_unit_test(shading_normals_face_the_ray),
        cmocka_unit_test(normal_maps_lean_along_the_texture),
        cmocka_unit_test(factors_textures_and_vertex_colours_multiply),
        cmocka_unit_test(metallic_is_blue_and_roughness_green),
        cmocka_unit_test(emission_leaves_the_front_unless_double_sided),
        cmocka_unit_test(unlit_surfaces_show_their_colour_and_reflect_nothing),
        cmocka_unit_test(coverage_follows_the_alpha_mode),
        cmocka_unit_test(shadow_rays_see_the_same_coverage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Surfaces whose material is of several models, and what moves their normals. */
#include <math.h>

#include "core/random.h"
#include "scene/surface.h"
#include "scene_fixture.h"

static const air_vec3 DOWN = {0.0f, 0.0f, -1.0f};

static air_surface surface_at(const air_snapshot *snapshot, air_vec3 target, air_vec3 dir)
{
    air_ray ray = {.tmin = 0.0f, .tmax = INFINITY, .mask = AIR_MASK_SCATTER};
    air_hit hit;
    air_surface surface;
    vec3_store(ray.origin, vec3_madd(target, -1.0f, dir));
    vec3_store(ray.dir, dir);
    air_context_ray_backend(snapshot->context)->intersect(snapshot->accelerator, &ray, 1, &hit);
    assert_true(hit.mesh != (uint32_t)AIR_NO_HIT);
    air_surface_make(snapshot, &hit, dir, &surface);
    return surface;
}

static air_handle add_floats(air_scene *scene, size_t width, size_t height, const float *values)
{
    const air_texture_desc desc = {.name = "grey",
                                   .width = width,
                                   .height = height,
                                   .channels = 1,
                                   .floats = values,
                                   .filter = AIR_TEXTURE_LINEAR};
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_texture(scene, &desc, &handle), AIR_OK);
    return handle;
}

/* The fixture's square of a material. */
static air_snapshot *square_of(air_scene *scene, const air_material_desc *material)
{
    air_mesh_desc desc = fixture_square("square");
    air_handle mesh;
    assert_int_equal(air_scene_add_material(scene, material, &desc.material), AIR_OK);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    return fixture_commit(scene, NULL);
}

static void assert_near(air_vec3 a, air_vec3 b, float tolerance)
{
    if (!(vec3_length(vec3_sub(a, b)) <= tolerance))
        fail_msg("(%g %g %g) is not (%g %g %g)", (double)a.x, (double)a.y, (double)a.z, (double)b.x,
                 (double)b.y, (double)b.z);
}

/* How often random places are of a model, seen from above. */
static double share_of(const air_snapshot *snapshot, air_material_model model)
{
    enum { PLACES = 20000 };
    air_rng rng = air_rng_from_keys(4, 7);
    int count = 0;
    for (int i = 0; i < PLACES; i++) {
        const air_vec3 target =
            vec3(1.9f * air_rng_float(&rng) - 0.95f, 1.9f * air_rng_float(&rng) - 0.95f, 0.0f);
        count += surface_at(snapshot, target, DOWN).bsdf.model == model;
    }
    return (double)count / PLACES;
}

/* Shares of 20000 places: a deviation of at most 0.0035. */
#define SHARE_TOLERANCE 0.015

/* weight: NULL or one texel that scales 0.6. */
static double blended_share(const float *weight)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc lambert, metal, blend;
    air_material_desc_default(&lambert);
    metal = blend = lambert;
    metal.model = AIR_MATERIAL_CONDUCTOR;
    blend.model = AIR_MATERIAL_BLEND;
    blend.blend_weight = 0.6f;
    if (weight != NULL)
        blend.blend_texture.texture = add_floats(scene, 1, 1, weight);
    assert_int_equal(air_scene_add_material(scene, &lambert, &blend.blend[0]), AIR_OK);
    assert_int_equal(air_scene_add_material(scene, &metal, &blend.blend[1]), AIR_OK);
    air_snapshot *snapshot = square_of(scene, &blend);
    const double share = share_of(snapshot, AIR_MATERIAL_CONDUCTOR);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
    return share;
}

static void blends_are_mixed_by_their_weight(void **state)
{
    const float half = 0.5f;
    (void)state;
    assert_true(fabs(blended_share(NULL) - 0.6) < SHARE_TOLERANCE);
    assert_true(fabs(blended_share(&half) - 0.3) < SHARE_TOLERANCE);
}

static void a_blend_needs_both_its_materials(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc blend;
    air_handle handle;
    (void)state;
    air_material_desc_default(&blend);
    blend.model = AIR_MATERIAL_BLEND;
    assert_int_equal(air_scene_add_material(scene, &blend, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "blend has to be a handle of a material, but it is AIR_NONE");
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void transmission_replaces_the_base(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc material;
    (void)state;
    air_material_desc_default(&material);
    material.metallic = 0.25f;
    material.roughness = 0.5f;
    material.transmission = 0.4f;
    material.base_color[0] = 0.5f;
    air_snapshot *snapshot = square_of(scene, &material);
    /* 0.4 of what is not metal; of the rest 0.25 / 0.7 is */
    assert_true(fabs(share_of(snapshot, AIR_MATERIAL_THIN_DIELECTRIC) - 0.3) < SHARE_TOLERANCE);
    for (int i = 0; i < 100; i++) {
        const air_surface s =
            surface_at(snapshot, vec3(0.009f * (float)i - 0.4f, 0.1f, 0.0f), DOWN);
        if (s.bsdf.model == AIR_MATERIAL_METALLIC_ROUGHNESS) {
            assert_true(fabsf(s.bsdf.diffuse.y - (1.0f - 0.25f / 0.7f)) < 1e-5f);
        } else {
            assert_near(s.bsdf.transmittance, vec3(0.5f, 1.0f, 1.0f), 0.0f);
            assert_true(s.bsdf.facets.alpha_u == 0.25f && s.bsdf.single);
        }
    }
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void refraction_is_by_the_side_that_is_seen(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc material;
    (void)state;
    air_material_desc_default(&material);
    material.model = AIR_MATERIAL_DIELECTRIC;
    material.ior = 1.25f;
    air_snapshot *snapshot = square_of(scene, &material);
    const air_vec3 target = vec3(0.3f, 0.2f, 0.0f);
    assert_true(surface_at(snapshot, target, DOWN).bsdf.ior == 1.25f);
    assert_true(surface_at(snapshot, target, vec3(0, 0, 1)).bsdf.ior == 0.8f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* u grows with x over 2 m, v against y: between the middle texels of four, 0.5 m apart, heights
 * that rise by 0.1 after scaling give the slope 0.2. */
static void bumps_tilt_the_normal_against_their_slope(void **state)
{
    static const float heights[4] = {0.0f, 0.1f, 0.3f, 0.4f};
    (void)state;
    for (int along = 0; along < 2; along++) {
        air_context *context = fixture_context();
        air_scene *scene = fixture_scene(context);
        air_material_desc material;
        air_material_desc_default(&material);
        material.bump_scale = 0.5f;
        material.bump_texture.texture =
            along == 0 ? add_floats(scene, 4, 1, heights) : add_floats(scene, 1, 4, heights);
        air_snapshot *snapshot = square_of(scene, &material);
        const air_surface front = surface_at(snapshot, vec3(0.1f, 0.12f, 0.0f), DOWN);
        const air_surface back = surface_at(snapshot, vec3(0.1f, 0.12f, 0.0f), vec3(0, 0, 1));
        const air_vec3 expected =
            vec3_normalize(along == 0 ? vec3(-0.2f, 0.0f, 1.0f) : vec3(0.0f, 0.2f, 1.0f));
        assert_near(front.bsdf.frame.n, expected, 1e-5f);
        assert_near(back.bsdf.frame.n, vec3_neg(expected), 1e-5f);
        air_snapshot_release(snapshot);
        air_scene_destroy(scene);
        air_context_destroy(context);
    }
}

/* A unit cylinder of a material, its u once around. */
static air_snapshot *cylinder_of(air_scene *scene, const air_material_desc *material)
{
    air_mesh_desc desc;
    air_handle mesh;
    air_mesh_desc_default(&desc);
    desc.shape = AIR_SHAPE_CYLINDER;
    assert_int_equal(air_scene_add_material(scene, material, &desc.material), AIR_OK);
    assert_int_equal(air_scene_add_mesh(scene, &desc, &mesh), AIR_OK);
    return fixture_commit(scene, NULL);
}

/* Heights rise by 0.1 after scaling over a quarter of the circumference: the slope is 0.4 / 2 pi.
 */
static void bumps_lie_around_a_cylinder(void **state)
{
    static const float heights[4] = {0.0f, 0.1f, 0.3f, 0.4f};
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc material;
    (void)state;
    air_material_desc_default(&material);
    material.bump_scale = 0.5f;
    material.bump_texture.texture = add_floats(scene, 4, 1, heights);
    air_snapshot *snapshot = cylinder_of(scene, &material);
    const float phi = 0.45f * 2.0f * AIR_PI_F, slope = 0.4f / (2.0f * AIR_PI_F);
    const air_vec3 radial = vec3(cosf(phi), sinf(phi), 0.0f);
    const air_vec3 around = vec3(-sinf(phi), cosf(phi), 0.0f);
    const air_surface s =
        surface_at(snapshot, vec3_add(radial, vec3(0.0f, 0.0f, 0.5f)), vec3_neg(radial));
    assert_near(s.bsdf.frame.n, vec3_normalize(vec3_madd(radial, -slope, around)), 1e-5f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void anisotropic_facets_lie_around_a_cylinder(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc metal, blend;
    (void)state;
    air_material_desc_default(&metal);
    metal.model = AIR_MATERIAL_CONDUCTOR;
    metal.alpha_u = 0.1f;
    metal.alpha_v = 0.4f;
    air_material_desc_default(&blend);
    blend.model = AIR_MATERIAL_BLEND;
    assert_int_equal(air_scene_add_material(scene, &metal, &blend.blend[0]), AIR_OK);
    blend.blend[1] = blend.blend[0];
    air_snapshot *snapshot = cylinder_of(scene, &blend);
    const air_surface s = surface_at(snapshot, vec3(1.0f, 0.0f, 0.5f), vec3(-1.0f, 0.0f, 0.0f));
    assert_near(s.bsdf.frame.s, vec3(0.0f, 1.0f, 0.0f), 1e-6f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void opacity_textures_scale_the_coverage(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc material;
    const float half = 0.5f;
    (void)state;
    air_material_desc_default(&material);
    material.model = AIR_MATERIAL_CONDUCTOR;
    material.alpha_mode = AIR_ALPHA_BLEND;
    material.base_color[3] = 0.5f;
    material.opacity_texture.texture = add_floats(scene, 1, 1, &half);
    air_snapshot *snapshot = square_of(scene, &material);
    assert_true(snapshot->has_alpha);
    assert_true(surface_at(snapshot, vec3(0.3f, 0.2f, 0.0f), DOWN).alpha == 0.25f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void anisotropic_facets_lie_along_u(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc material;
    (void)state;
    air_material_desc_default(&material);
    material.model = AIR_MATERIAL_CONDUCTOR;
    material.alpha_u = 0.1f;
    material.alpha_v = 0.4f;
    air_snapshot *snapshot = square_of(scene, &material);
    const air_surface s = surface_at(snapshot, vec3(0.3f, 0.2f, 0.0f), DOWN);
    assert_near(s.bsdf.frame.s, vec3(1.0f, 0.0f, 0.0f), 1e-6f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void impossible_materials_are_refused(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc material;
    air_handle handle;
    (void)state;
    air_material_desc_default(&material);
    material.model = AIR_MATERIAL_NULL;
    material.emission[1] = 1.0f;
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "emission must be 0 of the model NULL");
    air_material_desc_default(&material);
    material.model = AIR_MATERIAL_CONDUCTOR;
    material.absorption[2] = 0.0f;
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "eta[2] and absorption[2] are 0");
    air_material_desc_default(&material);
    material.ior = 0.5f;
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_ERROR_ARGUMENT);
    material.model = AIR_MATERIAL_DIELECTRIC;
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_OK);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blends_are_mixed_by_their_weight),
        cmocka_unit_test(a_blend_needs_both_its_materials),
        cmocka_unit_test(transmission_replaces_the_base),
        cmocka_unit_test(refraction_is_by_the_side_that_is_seen),
        cmocka_unit_test(bumps_tilt_the_normal_against_their_slope),
        cmocka_unit_test(bumps_lie_around_a_cylinder),
        cmocka_unit_test(anisotropic_facets_lie_around_a_cylinder),
        cmocka_unit_test(opacity_textures_scale_the_coverage),
        cmocka_unit_test(anisotropic_facets_lie_along_u),
        cmocka_unit_test(impossible_materials_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

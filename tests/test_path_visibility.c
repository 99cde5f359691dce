/* What shadow rays and sampled directions see differently must not change the light that arrives.
 */
#include "path_scene.h"

static air_handle add_grey(air_scene *scene, float alpha)
{
    air_material_desc material;
    air_handle handle;
    air_material_desc_default(&material);
    set3(material.base_color, 0.5f, 0.5f, 0.5f);
    material.specular = 0.0f;
    if (alpha < 1.0f) {
        material.base_color[3] = alpha;
        material.alpha_mode = AIR_ALPHA_BLEND;
    }
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_OK);
    return handle;
}

/* A horizontal square of half width w at height y. */
static void add_square(air_scene *scene, float y, float w, air_handle material, bool casts_shadow)
{
    const float positions[12] = {-w, y, w, w, y, w, w, y, -w, -w, y, -w};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    air_mesh_desc mesh;
    air_handle handle;
    air_mesh_desc_default(&mesh);
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    mesh.material = material;
    mesh.casts_shadow = casts_shadow;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
}

static void add_plane(air_scene *scene, float y, air_handle material, bool casts_shadow)
{
    add_square(scene, y, 1000.0f, material, casts_shadow);
}

static probe_result look(const air_snapshot *snapshot, air_vec3 origin, air_vec3 dir)
{
    const air_vec3 unit = vec3_normalize(dir);
    const probe p = {.origin = origin,
                     .dir = &unit,
                     .max_depth = 1,
                     .terms = AIR_TERMS_ALL,
                     .replicates = 16,
                     .samples = 1024};
    return probe_run(snapshot, &p);
}

/* Within four standard errors and rounding, and the error small enough to show a lost share. */
static void assert_radiance(const probe_result *got, double expected, double largest_error)
{
    assert_true(got->error[1] <= largest_error);
    if (fabs(got->mean[1] - expected) > 4.0 * got->error[1] + 1e-4 * expected) {
        fail_msg("radiance %g +- %g, expected %g", got->mean[1], got->error[1], expected);
    }
}

/* A floor of albedo 1/2 under a ceiling, in an environment of radiance 1. Where the ceiling or the
 * light casts no shadow, shadow rays pass and the floor shines with 1/2; sampled directions are
 * stopped by the ceiling all the same. */
static void light_that_casts_no_shadow_arrives_whole(void **state)
{
    for (int which = 0; which < 3; which++) {
        air_scene *scene = path_scene(state);
        const air_handle grey = add_grey(scene, 1.0f);
        air_light_desc sky;
        air_light_desc_default(&sky);
        sky.kind = AIR_LIGHT_ENVIRONMENT;
        set3(sky.color, 1.0f, 1.0f, 1.0f);
        sky.casts_shadow = which != 0;
        add_light(scene, &sky);
        add_plane(scene, 0.0f, grey, true);
        add_plane(scene, 10.0f, grey, which != 1);
        air_snapshot *snapshot = path_freeze(scene);
        const probe_result got = look(snapshot, vec3(0, 1, 0), vec3(0.1f, -1, 0));
        /* with both casting shadows only a rim beyond 1000 m of ceiling 10 m up is open: 1e-4 */
        assert_radiance(&got, which == 2 ? 5e-5 : 0.5, 0.01);
        air_snapshot_release(snapshot);
    }
}

/* A pane of coverage 0.3 that casts no shadow still lets 0.7 of the background through. */
static void a_pane_without_shadow_is_transparent(void **state)
{
    air_scene *scene = path_scene(state);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    add_plane(scene, 2.0f, add_grey(scene, 0.3f), false);
    air_snapshot *snapshot = path_freeze(scene);
    const probe p = {.origin = vec3(0, 0, 0),
                     .dir = &(air_vec3){0, 1, 0},
                     .max_depth = 1,
                     .terms = 1u << AIR_TERM_BACKGROUND,
                     .replicates = 16,
                     .samples = 1024};
    const probe_result got = probe_run(snapshot, &p);
    assert_radiance(&got, 0.7, 0.01);
    air_snapshot_release(snapshot);
}

/* A panel let into a ceiling lies in its plane. It must be seen, and light the floor below by both
 * ways of finding it. The floor at the foot of a square panel of half width a, h below it, has the
 * irradiance pi L times the form factor, 4 times that of a quarter: (2/pi) b atan(b) with b = a /
 * sqrt(a^2 + h^2) [Howell2010, C-11]. */
static void a_panel_in_the_plane_of_a_ceiling_shines(void **state)
{
    static const float panel[12] = {-1, 3, -1, 1, 3, -1, 1, 3, 1, -1, 3, 1};
    air_scene *scene = path_scene(state);
    const air_handle grey = add_grey(scene, 1.0f);
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_POLYGON;
    set3(light.color, 1.0f, 1.0f, 1.0f);
    light.vertices = panel;
    light.vertex_count = 4;
    add_light(scene, &light);
    /* not larger: the plane of a triangle of 1000 m is known to a millimetre only */
    add_square(scene, 3.0f, 20.0f, grey, true);
    add_square(scene, 0.0f, 20.0f, grey, true);
    air_snapshot *snapshot = path_freeze(scene);
    const double b = 1.0 / sqrt(1.0 + 9.0);
    const double form_factor = 4.0 * (2.0 / AIR_PI) * b * atan(b) / 2.0;
    probe_result got = look(snapshot, vec3(0, 1, 0), vec3(0, -1, 0));
    assert_radiance(&got, 0.5 * form_factor, 0.002);
    got = look(snapshot, vec3(0, 1, 0), vec3(0.05f, 1, 0.02f));
    assert_true(got.terms[AIR_TERM_EMISSION] > 0.999);
    air_snapshot_release(snapshot);
}

/* Emission of surfaces with coverage is met, never sampled; with no other light around it must
 * arrive too. */
static void emitters_with_coverage_shine_alone(void **state)
{
    air_scene *scene = path_scene(state);
    air_material_desc material;
    air_handle glow;
    air_material_desc_default(&material);
    set3(material.emission, 1.0f, 1.0f, 1.0f);
    set3(material.base_color, 0.0f, 0.0f, 0.0f);
    material.base_color[3] = 0.5f;
    material.specular = 0.0f;
    material.alpha_mode = AIR_ALPHA_BLEND;
    material.double_sided = true;
    assert_int_equal(air_scene_add_material(scene, &material, &glow), AIR_OK);
    add_plane(scene, 2.0f, glow, true);
    add_plane(scene, 0.0f, add_grey(scene, 1.0f), true);
    for (int i = 0; i < 3; i++) {
        air_medium_desc clear = medium_in_box(vec3(0, -50, 0), vec3(1, 1, 1));
        set3(clear.sigma_a, 1.0f, 1.0f, 1.0f);
        add_medium(scene, &clear);
    }
    air_snapshot *snapshot = path_freeze(scene);
    /* half of the sky above the floor is radiance 1, reflected by half: 1/4 */
    const probe_result got = look(snapshot, vec3(0, 1, 0), vec3(0.1f, -1, 0));
    assert_radiance(&got, 0.25, 0.005);
    air_snapshot_release(snapshot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_that_casts_no_shadow_arrives_whole),
        cmocka_unit_test(a_pane_without_shadow_is_transparent),
        cmocka_unit_test(a_panel_in_the_plane_of_a_ceiling_shines),
        cmocka_unit_test(emitters_with_coverage_shine_alone),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

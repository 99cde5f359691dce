/* path_scene.h: the scenes of the path tracer's tests, in few lines, and what measurements must
 * satisfy. The group's state is an air_context. */
#ifndef AIR_TESTS_PATH_SCENE_H
#define AIR_TESTS_PATH_SCENE_H

#include "path_probe.h"

static inline int path_set_up(void **state)
{
    air_context *context;
    if (air_context_create(NULL, &context) != AIR_OK) {
        return -1;
    }
    *state = context;
    return 0;
}

static inline int path_tear_down(void **state)
{
    air_context_destroy(*state);
    return 0;
}

static inline air_scene *path_scene(void **state)
{
    air_scene *scene;
    assert_int_equal(air_scene_create(*state, &scene), AIR_OK);
    return scene;
}

/* The snapshot of a scene that is not needed any more. */
static inline air_snapshot *path_freeze(air_scene *scene)
{
    air_snapshot *snapshot;
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

static inline void set3(float out[3], float r, float g, float b)
{
    out[0] = r;
    out[1] = g;
    out[2] = b;
}

static inline void add_light(air_scene *scene, const air_light_desc *light)
{
    air_handle handle;
    assert_int_equal(air_scene_add_light(scene, light, &handle), AIR_OK);
}

static inline void add_point_light(air_scene *scene, air_vec3 position, float intensity)
{
    air_light_desc light;
    air_light_desc_default(&light);
    set3(light.color, intensity, intensity, intensity);
    vec3_store(light.position, position);
    add_light(scene, &light);
}

/* dir: of travel. */
static inline void add_sun(air_scene *scene, air_vec3 irradiance, air_vec3 dir)
{
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_COLLIMATED;
    vec3_store(light.color, irradiance);
    vec3_store(light.dir, dir);
    add_light(scene, &light);
}

static inline void add_environment(air_scene *scene, float r, float g, float b)
{
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    set3(light.color, r, g, b);
    add_light(scene, &light);
}

static inline void add_medium(air_scene *scene, const air_medium_desc *medium)
{
    air_handle handle;
    assert_int_equal(air_scene_add_medium(scene, medium, &handle), AIR_OK);
}

/* A box with sides along the axes; without coefficients yet. */
static inline air_medium_desc medium_in_box(air_vec3 center, air_vec3 half)
{
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    const float box[12] = {half.x, 0, 0, center.x, 0, half.y, 0, center.y, 0, 0, half.z, center.z};
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    return medium;
}

/* side^3 values that fill the box exactly: the grid's outermost half cells continue its border. */
static inline air_handle add_box_grid(air_scene *scene, size_t side, size_t channels,
                                      const float *values, air_vec3 center, air_vec3 half)
{
    air_handle handle;
    const float n = (float)side, shift = 1.0f - 1.0f / n;
    const air_vec3 step = vec3_scale(half, 2.0f / n), first = vec3_madd(center, -shift, half);
    const air_grid_desc grid = {
        "grid",
        {side, side, side},
        channels,
        values,
        {step.x, 0, 0, first.x, 0, step.y, 0, first.y, 0, 0, step.z, first.z}};
    assert_int_equal(air_scene_add_grid(scene, &grid, &handle), AIR_OK);
    return handle;
}

/* A Lambertian material that may glow. */
static inline air_handle add_lambert(air_scene *scene, float albedo, float emission)
{
    air_material_desc material;
    air_handle handle;
    air_material_desc_default(&material);
    set3(material.base_color, albedo, albedo, albedo);
    set3(material.emission, emission, emission, emission);
    material.specular = 0.0f;
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_OK);
    return handle;
}

/* The parallelogram corner, corner + u, corner + u + v, corner + v; its front looks along u x v. */
static inline void add_quad(air_scene *scene, air_vec3 corner, air_vec3 u, air_vec3 v,
                            air_handle material)
{
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    float positions[12];
    air_mesh_desc mesh;
    air_handle handle;
    vec3_store(positions, corner);
    vec3_store(positions + 3, vec3_add(corner, u));
    vec3_store(positions + 6, vec3_add(corner, vec3_add(u, v)));
    vec3_store(positions + 9, vec3_add(corner, v));
    air_mesh_desc_default(&mesh);
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    mesh.material = material;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
}

/* The square |x|, |z| <= half at height y, looking up. */
static inline void add_floor(air_scene *scene, float y, float half, air_handle material)
{
    add_quad(scene, vec3(-half, y, half), vec3(2.0f * half, 0.0f, 0.0f),
             vec3(0.0f, 0.0f, -2.0f * half), material);
}

enum { PATH_REPLICATES = 32 };

static inline probe_result measure_radiance(const air_snapshot *snapshot, air_vec3 origin,
                                            air_vec3 dir, uint32_t max_depth, uint32_t samples)
{
    const probe p = {origin, &dir, max_depth, AIR_TERMS_ALL, PATH_REPLICATES, samples, origin};
    return probe_run(snapshot, &p);
}

static inline probe_result measure_fluence(const air_snapshot *snapshot, air_vec3 at,
                                           air_vec3 source, uint32_t max_depth, uint32_t samples)
{
    const probe p = {at, NULL, max_depth, AIR_TERMS_ALL, PATH_REPLICATES, samples, source};
    return probe_run(snapshot, &p);
}

/* Each channel within four standard errors, and these at most largest_error relative so that the
 * comparison means something. Student's t with 31 degrees of freedom is beyond 4 once in 2,700
 * times; the seeds are fixed. slack: relative error of what is expected. */
static inline void assert_measured_within(const char *what, const probe_result *got,
                                          const double expected[3], double largest_error,
                                          double slack)
{
    for (int c = 0; c < 3; c++) {
        const double size = fabs(expected[c]);
        if (!(got->error[c] <= largest_error * size) ||
            !(fabs(got->mean[c] - expected[c]) <= 4.0 * got->error[c] + slack * size)) {
            fail_msg("%s, channel %d: %.7g +- %.2g, expected %.7g", what, c, got->mean[c],
                     got->error[c], expected[c]);
        }
    }
}

/* Against exact values. What is computed without chance may be off by 1e-5 relative: some ten
 * operations in float, of an optical depth of at most 10. */
static inline void assert_measured(const char *what, const probe_result *got,
                                   const double expected[3], double largest_error)
{
    assert_measured_within(what, got, expected, largest_error, 1e-5);
}

/* Likewise for two measurements of the same. */
static inline void assert_same_measured(const char *what, const probe_result *a,
                                        const probe_result *b, double largest_error)
{
    for (int c = 0; c < 3; c++) {
        const double size = fabs(a->mean[c]), error = hypot(a->error[c], b->error[c]);
        if (!(error <= largest_error * size) ||
            !(fabs(a->mean[c] - b->mean[c]) <= 4.0 * error + 1e-5 * size)) {
            fail_msg("%s, channel %d: %.7g +- %.2g and %.7g +- %.2g", what, c, a->mean[c],
                     a->error[c], b->mean[c], b->error[c]);
        }
    }
}

#endif

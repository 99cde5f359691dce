/* Lights and media written as .glb and read again: number by number. Where nothing else is said
 * the numbers are the same to the last bit. */
#include "saved_scene.h"

/* ---- lights ---- */

/* A light's number is a product that rounds twice in the reader: the next float is met at worst. */
/* All lights are again what they were, without a warning; ends the fixture. */
static void lights_come_back(saved_fixture *f)
{
    saved_round(f);
    saved_same_lights(f->scene, f->again);
    assert_string_equal(f->said[AIR_MESSAGE_WARNING], "");
    saved_finish(f);
}

static void punctual_lights_stay_within_the_last_bit(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(16, 17);
    saved_init(&f);
    enum { COUNT = 300 };
    for (size_t i = 0; i < COUNT; ++i) {
        static const air_light_kind kinds[] = {AIR_LIGHT_POINT, AIR_LIGHT_SPOT,
                                               AIR_LIGHT_COLLIMATED};
        air_light_desc desc;
        char name[16];
        snprintf(name, sizeof name, "l%zu", i);
        air_light_desc_default(&desc);
        desc.name = name;
        desc.kind = kinds[i % 3];
        for (size_t c = 0; c < 3; ++c) {
            desc.color[c] = saved_random_strength(&random);
            desc.position[c] = saved_random_between(&random, -1000.0f, 1000.0f);
        }
        saved_random_direction(&random, desc.dir);
        desc.outer_cone_rad = saved_random_between(&random, 0.1f, 1.5f);
        desc.inner_cone_rad = desc.outer_cone_rad * saved_random_between(&random, 0.0f, 0.99f);
        desc.casts_shadow = i % 7 != 0;
        saved_add_light(&f, &desc);
    }
    saved_round(&f);
    for (size_t i = 0; i < COUNT; ++i) {
        const air_light_desc *before =
            &((const air_light_record *)saved_record(f.scene, AIR_OBJECT_LIGHT, i))->desc;
        const air_light_desc *after = saved_light_again(&f, i);
        for (size_t c = 0; c < 3; ++c) {
            const float color = before->color[c];
            assert_true(after->color[c] >= nextafterf(color, 0.0f));
            assert_true(after->color[c] <= nextafterf(color, INFINITY));
            assert_true(before->kind == AIR_LIGHT_POINT || after->dir[c] == before->dir[c]);
        }
    }
    /* the colours are now those that can be met, and nothing moves any more */
    air_scene *first = f.again;
    f.again = NULL;
    air_scene_destroy(f.scene);
    f.scene = first;
    lights_come_back(&f);
}

static void other_lights_go_into_the_airlight_object(void **state)
{
    (void)state;
    saved_fixture f;
    static const float corners[12] = {-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1};
    const air_gobo_window windows[2] = {{corners, 4}, {corners, 3}};
    air_light_desc desc;
    saved_init(&f);
    air_light_desc_default(&desc);
    desc.name = "panel";
    desc.kind = AIR_LIGHT_POLYGON;
    desc.color[0] = 12.1f;
    desc.color[1] = desc.color[2] = 0.3f;
    desc.vertices = corners;
    desc.vertex_count = 4;
    desc.one_sided = false;
    desc.camera_visible = false;
    saved_add_light(&f, &desc);
    desc.name = "windows";
    desc.kind = AIR_LIGHT_COLLIMATED;
    desc.camera_visible = true;
    desc.one_sided = true;
    desc.dir[0] = 0.6f;
    desc.dir[1] = -0.8f;
    desc.dir[2] = 0.0f;
    desc.windows = windows;
    desc.window_count = 2;
    desc.casts_shadow = false;
    saved_add_light(&f, &desc);
    desc.name = "hard edge";
    desc.kind = AIR_LIGHT_SPOT;
    desc.outer_cone_rad = 0.5f;
    desc.inner_cone_rad = nextafterf(0.5f, 0.0f);
    saved_add_light(&f, &desc);
    desc.name = "even in the angle";
    desc.falloff = AIR_SPOT_ANGLE;
    desc.inner_cone_rad = 0.1f;
    saved_add_light(&f, &desc);
    desc.name = "grey sky";
    desc.kind = AIR_LIGHT_ENVIRONMENT;
    desc.camera_visible = false;
    saved_add_light(&f, &desc);
    lights_come_back(&f);
}

/* The picture's axes come back within roundings of a cross product and a length, 2^-24 each. */
static void projectors_keep_their_picture_and_their_axes(void **state)
{
    (void)state;
    saved_fixture f;
    const float floats[2 * 3] = {0.1f, 2.0f, 0.0f, 5.0f, 1e-3f, 0.7f};
    const air_texture_desc texture = {.width = 2, .height = 1, .channels = 3, .floats = floats};
    air_rng random = air_rng_from_keys(36, 37);
    air_light_desc desc;
    float axis[3];
    saved_init(&f);
    air_light_desc_default(&desc);
    desc.name = "slides";
    desc.kind = AIR_LIGHT_PROJECTOR;
    desc.color[0] = desc.color[1] = 3.0f;
    desc.position[1] = 2.7f;
    desc.fov_x_rad = 0.77f;
    desc.image = saved_add_texture(&f, &texture);
    saved_random_direction(&random, axis);
    const air_frame frame = frame_from_normal(vec3_load(axis));
    const air_vec3 columns[3] = {frame.s, frame.t, frame.n};
    for (size_t column = 0; column < 3; ++column)
        for (size_t row = 0; row < 3; ++row)
            desc.to_world[3 * row + column] = (&columns[column].x)[row];
    saved_add_light(&f, &desc);
    saved_round(&f);
    const air_light_desc *again = saved_light_again(&f, 0);
    assert_int_equal(again->kind, AIR_LIGHT_PROJECTOR);
    assert_true(again->fov_x_rad == desc.fov_x_rad && again->position[1] == desc.position[1]);
    assert_memory_equal(again->color, desc.color, sizeof desc.color);
    assert_memory_equal(saved_texture(f.again, again->image)->floats, floats, sizeof floats);
    for (size_t k = 0; k < 9; ++k)
        assert_true(fabsf(again->to_world[k] - desc.to_world[k]) < 4.0f * 0x1p-24f);
    saved_finish(&f);
}

/* The image is in a file beside, exactly; the rotation a quaternion of floats, so that the matrix
 * is within some roundings: 4 products of two components, each 2^-24. */
static void environments_keep_their_image_and_turn(void **state)
{
    (void)state;
    saved_fixture f;
    float floats[8 * 4 * 3];
    air_rng random = air_rng_from_keys(19, 20);
    saved_init(&f);
    for (size_t i = 0; i < 8 * 4 * 3; ++i)
        floats[i] = saved_random_strength(&random);
    const air_texture_desc texture = {.name = "sky",
                                      .width = 8,
                                      .height = 4,
                                      .channels = 3,
                                      .floats = floats,
                                      .wrap_v = AIR_WRAP_CLAMP};
    const air_handle image = saved_add_texture(&f, &texture);
    enum { COUNT = 100 };
    for (size_t i = 0; i < COUNT; ++i) {
        air_light_desc desc;
        air_light_desc_default(&desc);
        desc.kind = AIR_LIGHT_ENVIRONMENT;
        desc.color[0] = desc.color[1] = desc.color[2] = 2.0f;
        desc.image = image;
        float axis[3];
        saved_random_direction(&random, axis);
        const air_frame frame = frame_from_normal(vec3_load(axis));
        const air_vec3 rows[3] = {frame.s, frame.t, frame.n};
        for (size_t row = 0; row < 3 && i > 0; ++row)
            vec3_store(desc.to_world + 3 * (i % 2 == 0 ? row : (row + i) % 3), rows[row]);
        saved_add_light(&f, &desc);
    }
    saved_round(&f);
    for (size_t i = 0; i < COUNT; ++i) {
        const air_light_desc *before =
            &((const air_light_record *)saved_record(f.scene, AIR_OBJECT_LIGHT, i))->desc;
        saved_same_texture(saved_texture(f.scene, image),
                           saved_texture(f.again, saved_light_again(&f, i)->image));
        for (size_t k = 0; k < 9; ++k)
            assert_true(fabsf(saved_light_again(&f, i)->to_world[k] - before->to_world[k]) <
                        (i == 0 ? 1e-30f : 8.0f * 0x1p-24f));
    }
    saved_finish(&f);
}

/* ---- media ---- */

static void media_keep_coefficients_phases_and_overlaps(void **state)
{
    (void)state;
    saved_fixture f;
    air_medium_desc desc;
    const air_phase_mixture mixture = {.lobe_count = 3,
                                       .lobes = {{AIR_PHASE_HG, 0.81f, 0.7f},
                                                 {AIR_PHASE_ISOTROPIC, 0.0f, 0.1f},
                                                 {AIR_PHASE_RAYLEIGH, 0.0f, 1.3f}}};
    saved_init(&f);
    air_medium_desc_default(&desc);
    desc.name = "haze";
    desc.sigma_s[0] = 0.1f;
    desc.sigma_s[1] = desc.sigma_s[2] = 0.7f;
    desc.sigma_a[1] = 1.0f / 3.0f;
    desc.phase = (air_phase){.kind = AIR_PHASE_HG, .g = -0.33f};
    saved_add_medium(&f, &desc);
    desc.name = "glow";
    desc.emission[2] = 1e-3f;
    desc.phase = (air_phase){.kind = AIR_PHASE_RAYLEIGH};
    desc.combine = AIR_COMBINE_REPLACE;
    desc.priority = -7;
    saved_add_medium(&f, &desc);
    desc.name = "";
    desc.phase = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = &mixture};
    saved_add_medium(&f, &desc);
    saved_round(&f);
    ((air_record *)(uintptr_t)saved_record(f.again, AIR_OBJECT_MEDIUM, 2))->name[0] = '\0';
    saved_same_media(&f, 3);
    saved_finish(&f);
}

static void media_keep_their_boundaries(void **state)
{
    (void)state;
    saved_fixture f;
    static const float tetrahedron[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    static const float planes[16] = {1, 0, 0, 2, -1, -1, 0, 0.5f, 0, 1, 1, 3, 0, 0, -3, 1};
    const float box[12] = {0.1f, 0.2f, 0.0f, 1.0f, -0.2f, 0.1f, 0.0f, 2.0f, 0.0f, 0.0f, 3.0f, 3.0f};
    air_medium_desc desc;
    saved_init(&f);
    air_mesh_desc wall =
        saved_square_mesh("fog boundary"); /* the name that a boundary would have */
    saved_add_mesh(&f, &wall);
    air_medium_desc_default(&desc);
    desc.name = "fog";
    desc.sigma_s[0] = desc.sigma_s[1] = desc.sigma_s[2] = 0.5f;
    desc.boundary.kind = AIR_BOUNDARY_BOX;
    memcpy(desc.boundary.box_to_world, box, sizeof box);
    saved_add_medium(&f, &desc);
    desc.boundary.kind = AIR_BOUNDARY_CONVEX;
    desc.boundary.planes = planes;
    desc.boundary.plane_count = 4;
    saved_add_medium(&f, &desc);
    desc.boundary.kind = AIR_BOUNDARY_MESH;
    desc.boundary.positions = tetrahedron;
    desc.boundary.vertex_count = 4;
    desc.boundary.indices = faces;
    desc.boundary.triangle_count = 4;
    saved_add_medium(&f, &desc);
    saved_add_medium(&f, &desc);
    desc.boundary.kind = AIR_BOUNDARY_ELLIPSOID;
    saved_add_medium(&f, &desc);
    saved_round(&f);
    saved_same_media(&f, 5);
    assert_int_equal(f.again->lists[AIR_OBJECT_MESH].count, 1);
    saved_finish(&f);
}

static void media_keep_heights_and_detail(void **state)
{
    (void)state;
    saved_fixture f;
    air_medium_desc desc;
    saved_init(&f);
    air_medium_desc_default(&desc);
    desc.name = "layers";
    desc.sigma_s[0] = 1.0f;
    desc.density.kind = AIR_DENSITY_LAYERED;
    desc.density.layer_count = 2;
    desc.density.layer_bottom[0] = -0.3f;
    desc.density.layer_bottom[1] = 1.7f;
    desc.density.layer_density[0] = 0.9f;
    desc.density.layer_density[1] = 0.1f;
    desc.density.layer_top = INFINITY;
    saved_add_medium(&f, &desc);
    desc.name = "capped";
    desc.density.layer_top = 5.1f;
    saved_add_medium(&f, &desc);
    desc.name = "exponential";
    desc.density.kind = AIR_DENSITY_EXPONENTIAL;
    desc.density.base_height = 0.37f;
    desc.density.scale_height = 12.3f;
    desc.density.up[1] = 0.0f;
    desc.density.up[2] = -1.0f;
    desc.boundary.kind = AIR_BOUNDARY_BOX;
    for (size_t i = 0; i < 12; ++i)
        desc.boundary.box_to_world[i] = i % 5 == 0 ? 2.0f : 0.0f;
    desc.density.detail.strength = 0.3f;
    desc.density.detail.scale = 0.7f;
    desc.density.detail.octaves = 3;
    desc.density.detail.seed = 4000000000u;
    desc.density.detail.to_world[1] = 0.25f;
    desc.density.detail.to_world[7] = -3.0f;
    saved_add_medium(&f, &desc);
    saved_round(&f);
    saved_same_media(&f, 3);
    saved_finish(&f);
}

/* ---- grids ---- */

static const air_grid *grid_of(const air_scene *scene, air_handle handle)
{
    const size_t index = air_slot_find(&scene->lists[AIR_OBJECT_GRID], handle);
    return ((const air_grid_record *)saved_record(scene, AIR_OBJECT_GRID, index))->grid;
}

/* The same values at the same places of the world, which are `tolerance` apart at most. */
static void same_grids(const saved_fixture *self, air_handle a, air_handle b,
                       const air_density *before, const air_density *after, float tolerance)
{
    const air_grid *grids[2] = {grid_of(self->scene, a), grid_of(self->again, b)};
    const air_density *densities[2] = {before, after};
    size_t size[2][3];
    float maps[2][12];
    for (size_t i = 0; i < 2; ++i) {
        air_grid_size(grids[i], size[i]);
        affine_multiply(densities[i]->grid_to_world, air_grid_index_to_local(grids[i]), maps[i]);
    }
    assert_memory_equal(size[0], size[1], sizeof size[0]);
    assert_int_equal(air_grid_channels(grids[0]), air_grid_channels(grids[1]));
    for (size_t i = 0; i < 12; ++i)
        assert_true(fabsf(maps[0][i] - maps[1][i]) <= tolerance);
    for (size_t i = 0; i < size[0][0] * size[0][1] * size[0][2]; ++i) {
        const air_vec3 at = vec3((float)(i % size[0][0]), (float)(i / size[0][0] % size[0][1]),
                                 (float)(i / size[0][0] / size[0][1]));
        const air_vec3 x = air_grid_lookup(grids[0], at), y = air_grid_lookup(grids[1], at);
        assert_true(x.x == y.x && x.y == y.y && x.z == y.z);
    }
}

static const air_density *density_of(const air_scene *scene, size_t index)
{
    return &((const air_medium_record *)saved_record(scene, AIR_OBJECT_MEDIUM, index))
                ->desc.density;
}

/* A box of voxels is written as it is; a turned one goes into the medium's map; side grids go with
 * the density. */
static void grids_keep_values_and_places(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(25, 26);
    const float straight[12] = {0.1f, 0, 0, -0.35f, 0, 0.2f, 0, 0.7f, 0, 0, 0.3f, 1.1f};
    const float moved[12] = {0.05f, 0, 0, -0.2f, 0, 0.1f, 0, 0.5f, 0, 0, 0.2f, 1.3f};
    const float turned[12] = {0.1f, -0.2f, 0, 4, 0.2f, 0.1f, 0, 5, 0, 0, 0.3f, 6};
    air_medium_desc desc;
    saved_init(&f);
    air_medium_desc_default(&desc);
    desc.name = "smoke";
    desc.sigma_s[0] = 1.0f;
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid = saved_add_grid(&f, &random, 1, straight);
    desc.density.albedo_grid = saved_add_grid(&f, &random, 3, moved);
    desc.density.emission_grid = saved_add_grid(&f, &random, 1, straight);
    desc.density.grid_to_world[1] = 0.5f;
    saved_add_medium(&f, &desc);
    desc.density.grid = saved_add_grid(&f, &random, 3, turned);
    desc.density.albedo_grid = saved_add_grid(&f, &random, 3, turned);
    desc.density.emission_grid = AIR_NONE;
    saved_add_medium(&f, &desc);
    saved_round(&f);
    /* a step and an offset, each from rounded ends of a box: 2^-24 of coordinates up to 8 */
    const float tolerance = 8.0f * 0x1p-23f;
    for (size_t i = 0; i < 2; ++i) {
        const air_density *a = density_of(f.scene, i), *b = density_of(f.again, i);
        same_grids(&f, a->grid, b->grid, a, b, i == 0 ? tolerance : 0.0f);
        same_grids(&f, a->albedo_grid, b->albedo_grid, a, b, tolerance);
        assert_int_equal(a->emission_grid == AIR_NONE, b->emission_grid == AIR_NONE);
    }
    assert_string_equal(f.said[AIR_MESSAGE_WARNING], "");
    saved_finish(&f);
}

static void a_side_grid_turned_against_the_density_is_sampled(void **state)
{
    (void)state;
    saved_fixture f;
    air_rng random = air_rng_from_keys(28, 29);
    const float straight[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float turned[12] = {0, -1, 0, 4, 1, 0, 0, 0, 0, 0, 1, 0};
    air_medium_desc desc;
    saved_init(&f);
    air_medium_desc_default(&desc);
    desc.name = "smoke";
    desc.sigma_s[0] = 1.0f;
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid = saved_add_grid(&f, &random, 1, straight);
    desc.density.albedo_grid = saved_add_grid(&f, &random, 3, turned);
    saved_add_medium(&f, &desc);
    saved_round(&f);
    saved_expect_warning(&f, "its albedo grid, which is turned against the density");
    /* local (i, j, k) is index (j, 4 - i, k) of the turned one */
    const air_grid *before = grid_of(f.scene, desc.density.albedo_grid);
    const air_grid *after = grid_of(f.again, density_of(f.again, 0)->albedo_grid);
    for (size_t i = 0; i < 5; ++i)
        for (size_t j = 0; j < 5; ++j) {
            const air_vec3 x = air_grid_lookup(before, vec3((float)j, 4.0f - (float)i, 2.0f));
            const air_vec3 y = air_grid_lookup(after, vec3((float)i, (float)j, 2.0f));
            assert_true(fabsf(x.x - y.x) < 1e-6f && fabsf(x.z - y.z) < 1e-6f);
        }
    saved_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(punctual_lights_stay_within_the_last_bit),
        cmocka_unit_test(other_lights_go_into_the_airlight_object),
        cmocka_unit_test(projectors_keep_their_picture_and_their_axes),
        cmocka_unit_test(environments_keep_their_image_and_turn),
        cmocka_unit_test(media_keep_coefficients_phases_and_overlaps),
        cmocka_unit_test(media_keep_their_boundaries),
        cmocka_unit_test(media_keep_heights_and_detail),
        cmocka_unit_test(grids_keep_values_and_places),
        cmocka_unit_test(a_side_grid_turned_against_the_density_is_sampled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Emissive spheres, cylinders and disks in the light table. */
#include "chi_square.h"
#include "core/random.h"
#include "core/warp.h"
#include "light_fixture.h"
#include "scene/lights/quadric_lamp.h"

/* A table of one lamp of radiance 1. */
typedef struct lamp_scene {
    air_quadric quadric;
    air_mesh mesh;
    air_material materials[1];
    air_light_table table;
} lamp_scene;

static void make_lamp(air_context *context, air_ray_shape shape, const float map[12], bool flip,
                      bool double_sided, const air_texture *texture, lamp_scene *s)
{
    const float low[3] = {-1.0f, -1.0f, -1.0f}, high[3] = {1.0f, 1.0f, 1.0f};
    const air_mesh *pointer = &s->mesh;
    uint32_t first = 7;
    memset(s, 0, sizeof *s);
    assert_true(air_quadric_make(shape, map, &s->quadric));
    s->mesh = (air_mesh){.quadric = &s->quadric, .flip = flip, .mask = AIR_MASK_CAMERA};
    s->materials[0].emission = vec3_set1(1.0f);
    s->materials[0].double_sided = double_sided;
    s->materials[0].emission_slot =
        (air_texture_slot){.texture = texture, .uv_transform = {1, 0, 0, 0, 1, 0}};
    assert_int_equal(air_light_table_build(context, NULL, 0, &pointer, 1, s->materials, low, high,
                                           &s->table, &first),
                     AIR_OK);
    assert_int_equal(s->table.count, 1);
    s->table.spheres_by_sight = true;
    assert_int_equal(first, 0);
}

/* The irradiance of a place without regard to shadows, by the midpoint rule over the lamp's random
 * numbers. */
static double irradiance(const lamp_scene *s, air_vec3 point, air_vec3 normal)
{
    enum { STEPS = 256 };
    double sum = 0.0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        air_light_point at;
        air_connection c;
        air_light_sample(&s->table, 0, ((float)(i / STEPS) + 0.5f) / STEPS,
                         ((float)(i % STEPS) + 0.5f) / STEPS, &at);
        if (air_light_connect(&s->table, &at, point, &c)) {
            sum += (double)(c.incident.x * fmaxf(0.0f, vec3_dot(c.dir, normal)) / c.pdf);
        }
    }
    return sum / (STEPS * STEPS);
}

static void assert_irradiance(const lamp_scene *s, air_vec3 point, air_vec3 normal, double expected,
                              double tolerance)
{
    const double got = irradiance(s, point, normal);
    if (fabs(got - expected) > tolerance * expected) {
        fail_msg("irradiance %.8g, expected %.8g", got, expected);
    }
}

/* ---- irradiance ---- */

static void a_sphere_lights_as_if_its_disk_were_a_point(void **state)
{
    air_rng rng = air_rng_from_keys(1, 1);
    for (int i = 0; i < 12; i++) {
        const float radius = powf(10.0f, 3.0f * air_rng_float(&rng) - 3.0f);
        const float map[12] = {0, radius, 0, 1, -radius, 0, 0, 2, 0, 0, radius, 3};
        lamp_scene s;
        make_lamp(*state, AIR_RAY_SPHERE, map, false, false, NULL, &s);
        const float distance = radius * powf(10.0f, 0.02f + 3.0f * air_rng_float(&rng));
        const air_vec3 away = sample_sphere(air_rng_float(&rng), air_rng_float(&rng));
        const air_vec3 point = vec3_madd(vec3(1.0f, 2.0f, 3.0f), distance, away);
        /* all of it is above the horizon: E = pi L (r / d)^2 cos */
        const air_frame frame = frame_from_normal(vec3_neg(away));
        const float tilt = 0.9f * acosf(radius / distance);
        const air_vec3 normal = frame_to_world(&frame, vec3(sinf(tilt), 0.0f, cosf(tilt)));
        const double ratio = (double)radius / (double)distance;
        /* distances as floats: 4e-7 of 4 over the radius, twice; the midpoint rule has none to
         * speak of, the integrand being linear in u1 and a cosine in u2 */
        const double off = 1e-6 * 4.0 / (double)fminf(1.0f, distance) + 1e-5;
        assert_irradiance(&s, point, normal, AIR_PI * ratio * ratio * cos((double)tilt), off);
        air_light_table_finish(*state, &s.table);
    }
}

static void a_disk_lights_its_axis_as_the_closed_form_says(void **state)
{
    const float map[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 1};
    lamp_scene s;
    make_lamp(*state, AIR_RAY_DISK, map, false, false, NULL, &s);
    /* pi L R^2 / (R^2 + d^2), before it; behind it nothing */
    assert_irradiance(&s, vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -1.0f), AIR_PI * 4.0 / 13.0,
                      1e-5);
    assert_true(irradiance(&s, vec3(0.0f, 0.0f, -1.0f), vec3(0.0f, 0.0f, 1.0f)) == 0.0);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_DISK, map, true, false, NULL, &s);
    assert_irradiance(&s, vec3(0.0f, 0.0f, -2.0f), vec3(0.0f, 0.0f, 1.0f), AIR_PI * 4.0 / 13.0,
                      1e-5);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_DISK, map, false, true, NULL, &s);
    assert_irradiance(&s, vec3(0.0f, 0.0f, -2.0f), vec3(0.0f, 0.0f, 1.0f), AIR_PI * 4.0 / 13.0,
                      1e-5);
    air_light_table_finish(*state, &s.table);
}

static void a_cylinder_lights_its_axis_as_what_its_end_leaves(void **state)
{
    const float map[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 5, 0};
    lamp_scene s;
    make_lamp(*state, AIR_RAY_CYLINDER, map, true, false, NULL, &s);
    /* the hemisphere's pi less that of the open end, a disk at the distance 3 */
    assert_irradiance(&s, vec3(0.0f, 0.0f, 2.0f), vec3(0.0f, 0.0f, 1.0f),
                      AIR_PI * (1.0 - 4.0 / 13.0), 1e-4);
    air_light_table_finish(*state, &s.table);
}

static void every_place_within_a_sphere_sees_all_of_it(void **state)
{
    const float map[12] = {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0};
    lamp_scene s;
    make_lamp(*state, AIR_RAY_SPHERE, map, true, false, NULL, &s);
    assert_irradiance(&s, vec3(0.2f, 0.9f, -1.0f), vec3(0.6f, 0.0f, 0.8f), AIR_PI, 1e-3);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_SPHERE, map, false, true, NULL, &s);
    assert_irradiance(&s, vec3(0.2f, 0.9f, -1.0f), vec3(0.6f, 0.0f, 0.8f), AIR_PI, 1e-3);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_SPHERE, map, false, false, NULL, &s);
    assert_true(irradiance(&s, vec3(0.2f, 0.9f, -1.0f), vec3(0.6f, 0.0f, 0.8f)) == 0.0);
    air_light_table_finish(*state, &s.table);
}

/* ---- densities ---- */

enum { ZS = 24, PHIS = 48, BINS = ZS * PHIS, DRAWS = 40000, FINE = 16 };

static size_t bin_of(air_vec3 dir)
{
    const double phi = atan2((double)dir.y, (double)dir.x) / (2.0 * AIR_PI) + 0.5;
    const double z = 0.5 * ((double)dir.z + 1.0);
    const size_t i = (size_t)fmin(z * ZS, ZS - 1), k = (size_t)fmin(phi * PHIS, PHIS - 1);
    return i * PHIS + k;
}

/* The integral of the density of hits over a bin, times the number of draws; a direction may leave
 * through a place that is not its first. */
static double expected_in(const lamp_scene *s, air_vec3 from, size_t bin)
{
    double sum = 0.0;
    for (int i = 0; i < FINE * FINE; i++) {
        const double z = 2.0 * ((double)(bin / PHIS) + (i / FINE + 0.5) / FINE) / ZS - 1.0;
        const double phi =
            2.0 * AIR_PI * (((double)(bin % PHIS) + (i % FINE + 0.5) / FINE) / PHIS - 0.5);
        const double r = sqrt(1.0 - z * z);
        const air_vec3 dir = vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
        float origin[3], along[3];
        air_quadric_hit hits[2];
        vec3_store(origin, from);
        vec3_store(along, dir);
        const size_t count = air_quadric_intersect(&s->quadric, origin, along, hits);
        const bool seen_only = s->quadric.shape == AIR_RAY_SPHERE && count == 2 && hits[0].t > 0.0;
        for (size_t k = 0; k < (seen_only ? 1 : count); k++) {
            if (hits[k].t > 0.0) {
                sum += (double)air_light_hit_pdf(&s->table, 0, from, dir, (float)hits[k].t);
            }
        }
    }
    return sum / (FINE * FINE) * (4.0 * AIR_PI / BINS) * DRAWS;
}

static void check_density(const lamp_scene *s, air_vec3 from, uint32_t key)
{
    static double observed[BINS + 1], expected[BINS + 1];
    air_rng rng = air_rng_from_keys(2, key);
    double rest = DRAWS;
    memset(observed, 0, sizeof observed);
    for (int i = 0; i < DRAWS; i++) {
        air_light_point at;
        air_connection c;
        air_light_sample(&s->table, 0, air_rng_float(&rng), air_rng_float(&rng), &at);
        if (!air_light_connect(&s->table, &at, from, &c)) {
            observed[BINS] += 1.0;
            continue;
        }
        observed[bin_of(c.dir)] += 1.0;
        const float pdf = air_light_hit_pdf(&s->table, 0, from, c.dir, c.distance);
        /* a grazing hit divides rounding by the cosine */
        assert_true(pdf == 0.0f || fabsf(pdf / c.pdf - 1.0f) < 1e-2f);
    }
    for (size_t i = 0; i < BINS; i++) {
        expected[i] = expected_in(s, from, i);
        rest -= expected[i];
    }
    expected[BINS] = fmax(rest, 0.0);
    /* bins that the silhouette crosses are integrated to a few hundredths of their content, less
     * than a tenth of what chance does to them; of those that it hardly touches the sum must do */
    for (size_t i = 0; i < BINS; i++) {
        if (expected[i] < 5.0 && observed[i] < 30.0) {
            expected[BINS] += expected[i];
            observed[BINS] += observed[i];
            expected[i] = observed[i] = 0.0;
        }
    }
    assert_true(fabs(observed[BINS] - expected[BINS]) < 5.0 * sqrt(expected[BINS] + 25.0));
    size_t dof;
    const double p = chi_square_p(observed, expected, BINS, &dof);
    if (p < 1e-4 || dof < 10) {
        fail_msg("case %u: p = %g with %zu degrees of freedom", key, p, dof);
    }
}

static void connections_have_the_density_that_they_say(void **state)
{
    static const float map[12] = {0.7f, 0.2f,  -0.1f, 0.3f, -0.3f, 0.8f,
                                  0.2f, -0.2f, 0.1f,  0.1f, 1.1f,  0.1f};
    static const float ball[12] = {0.9f, 0, 0, 0.3f, 0, 0.9f, 0, -0.2f, 0, 0, 0.9f, 0.1f};
    lamp_scene s;
    make_lamp(*state, AIR_RAY_SPHERE, ball, false, false, NULL, &s);
    check_density(&s, vec3(1.0f, 1.0f, 0.5f), 1);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_SPHERE, map, false, false, NULL, &s);
    check_density(&s, vec3(1.0f, 1.2f, 0.5f), 2);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_SPHERE, map, true, false, NULL, &s);
    check_density(&s, vec3(0.1f, 0.1f, 0.2f), 3);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_DISK, map, false, true, NULL, &s);
    check_density(&s, vec3(0.2f, 0.1f, 1.0f), 4);
    air_light_table_finish(*state, &s.table);
    make_lamp(*state, AIR_RAY_CYLINDER, map, true, false, NULL, &s);
    check_density(&s, vec3(0.3f, -0.2f, 0.6f), 5);
    air_light_table_finish(*state, &s.table);
}

static void by_area_the_light_point_is_kept(void **state)
{
    const float ball[12] = {0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0};
    lamp_scene s;
    make_lamp(*state, AIR_RAY_SPHERE, ball, false, false, NULL, &s);
    s.table.spheres_by_sight = false;
    air_light_point at;
    air_connection c;
    air_light_sample(&s.table, 0, 0.1f, 0.3f, &at);
    const air_vec3 point = vec3(0.2f, 0.3f, 3.0f);
    assert_true(air_light_connect(&s.table, &at, point, &c));
    const air_vec3 there = vec3_madd(point, c.distance, c.dir);
    assert_true(vec3_length(vec3_sub(there, at.position)) < 1e-6f);
    /* half the ball is behind: the lit half alone makes the irradiance */
    const double ratio = 0.5 / (double)vec3_length(point);
    assert_irradiance(&s, point, vec3_scale(point, -1.0f / vec3_length(point)),
                      AIR_PI * ratio * ratio, 1e-3);
    air_light_table_finish(*state, &s.table);
}

/* ---- power and textures ---- */

static void flux_and_textures_weigh_by_area(void **state)
{
    const float ball[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    uint8_t texels[2 * 3] = {255, 255, 255, 0, 0, 0}; /* white above the middle, black below */
    const air_texture texture = {.width = 1,
                                 .height = 2,
                                 .channels = 3,
                                 .bytes = texels,
                                 .wrap_u = AIR_WRAP_REPEAT,
                                 .wrap_v = AIR_WRAP_CLAMP,
                                 .filter = AIR_TEXTURE_NEAREST};
    lamp_scene s;
    make_lamp(*state, AIR_RAY_SPHERE, ball, false, false, &texture, &s);
    const air_light *light = &s.table.entries[0];
    assert_true(fabsf(light->area / (16.0f * AIR_PI_F) - 1.0f) < 1e-6f);
    assert_true(fabsf(air_quadric_lamp_mean(light).x - 0.5f) < 1e-6f);
    /* from +Z all is white, from -Z all is black, and so is what it makes */
    assert_irradiance(&s, vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -1.0f), AIR_PI * 0.25, 1e-5);
    assert_true(irradiance(&s, vec3(0.0f, 0.0f, -4.0f), vec3(0.0f, 0.0f, 1.0f)) == 0.0);
    air_light_table_finish(*state, &s.table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_lights_as_if_its_disk_were_a_point),
        cmocka_unit_test(a_disk_lights_its_axis_as_the_closed_form_says),
        cmocka_unit_test(a_cylinder_lights_its_axis_as_what_its_end_leaves),
        cmocka_unit_test(every_place_within_a_sphere_sees_all_of_it),
        cmocka_unit_test(connections_have_the_density_that_they_say),
        cmocka_unit_test(by_area_the_light_point_is_kept),
        cmocka_unit_test(flux_and_textures_weigh_by_area),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}

#include "chi_square.h"
#include "cmocka_test.h"
#include "core/random.h"
#include "core/warp.h"
#include "light_fixture.h"
#include "scene/lights/polygon.h"

/* ---- triangulation ---- */

enum { MAX_POINTS = 64 };

typedef struct triangulation {
    uint32_t triangles[MAX_POINTS][3];
    size_t count;
    double area;
} triangulation;

static triangulation triangulate(const air_point2 *points, size_t count)
{
    triangulation t = {.count = 0};
    size_t links[2 * MAX_POINTS];
    t.count = air_polygon_triangulate(points, count, links, t.triangles);
    for (size_t i = 0; i < t.count; i++) {
        const air_point2 corners[3] = {points[t.triangles[i][0]], points[t.triangles[i][1]],
                                       points[t.triangles[i][2]]};
        const double area = air_polygon_area(corners, 3);
        assert_true(area > 0.0);
        t.area += area;
    }
    return t;
}

/* A closed curve of random radius around the origin. */
static size_t random_star(air_rng *rng, air_point2 *points)
{
    const size_t count = 3 + air_rng_next(rng) % (MAX_POINTS - 3);
    for (size_t i = 0; i < count; i++) {
        const double angle = 2.0 * AIR_PI * (double)i / (double)count;
        const double radius = 0.05 + (double)air_rng_float(rng);
        points[i] = (air_point2){radius * cos(angle), radius * sin(angle)};
    }
    return count;
}

static void triangles_make_up_a_concave_polygon(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 1);
    for (int i = 0; i < 500; i++) {
        air_point2 points[MAX_POINTS];
        const size_t count = random_star(&rng, points);
        assert_int_equal(air_polygon_crossing(points, count), count);
        const triangulation t = triangulate(points, count);
        const double area = air_polygon_area(points, count);
        assert_true(t.count <= count - 2);
        /* positive triangles of that total area inside a simple polygon cannot overlap; sums of 64
         * terms near 1 */
        assert_true(fabs(t.area - area) < 1e-13);
    }
}

static void a_seam_makes_a_hole(void **state)
{
    (void)state;
    /* a square of side 4 with a square hole of side 2, joined by a seam from (0,0) to (1,1) */
    const air_point2 points[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0},
                                 {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    assert_int_equal(air_polygon_crossing(points, 10), 10);
    const triangulation t = triangulate(points, 10);
    assert_true(fabs(t.area - 12.0) < 1e-12);
}

static void crossing_edges_are_found(void **state)
{
    (void)state;
    const air_point2 bow_tie[] = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
    assert_int_equal(air_polygon_crossing(bow_tie, 4), 0);
    const air_point2 touching[] = {{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}};
    assert_int_equal(air_polygon_crossing(touching, 5), 5);
}

/* ---- lights ---- */

/* A U of seven unit squares in the plane z = 0, put into the world by an arbitrary rotation and
 * shift. */
static const float U_SHAPE[8][2] = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};

typedef struct placed {
    air_frame frame;
    air_vec3 origin;
    float vertices[24];
    air_light_desc desc;
} placed;

static void place_u(placed *p, air_vec3 normal, air_vec3 origin)
{
    p->frame = frame_from_normal(vec3_normalize(normal));
    p->origin = origin;
    for (int i = 0; i < 8; i++) {
        const air_vec3 local = vec3(U_SHAPE[i][0], U_SHAPE[i][1], 0.0f);
        vec3_store(p->vertices + 3 * i, vec3_add(origin, frame_to_world(&p->frame, local)));
    }
    air_light_desc_default(&p->desc);
    p->desc.kind = AIR_LIGHT_POLYGON;
    p->desc.vertices = p->vertices;
    p->desc.vertex_count = 8;
    p->desc.color[0] = 3.0f;
    p->desc.color[1] = 2.0f;
    p->desc.color[2] = 1.0f;
}

static void points_are_uniform_over_the_polygon(void **state)
{
    placed p;
    place_u(&p, vec3(0.3f, -0.5f, 0.7f), vec3(1.0f, 2.0f, -4.0f));
    air_light_table table = table_of_one(*state, &p.desc, NULL);
    enum { PER_UNIT = 5, SIDE = 3 * PER_UNIT, SAMPLES = 100000 };
    double observed[SIDE * SIDE] = {0.0}, expected[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE / PER_UNIT, y = i / SIDE / PER_UNIT;
        const bool hole = x == 1 && y > 0;
        expected[i] = hole ? 0.0 : SAMPLES / (7.0 * PER_UNIT * PER_UNIT);
    }
    air_rng rng = air_rng_from_keys(2, 1);
    for (int i = 0; i < SAMPLES; i++) {
        air_light_point point;
        const float u1 = air_rng_float(&rng);
        air_light_sample(&table, 0, u1, air_rng_float(&rng), &point);
        const air_vec3 local = frame_to_local(&p.frame, vec3_sub(point.position, p.origin));
        assert_true(fabsf(local.z) < 1e-5f); /* coordinates up to 8: 8 2^-24 and sums of it */
        assert_true(fabsf(point.pdf - 1.0f / 7.0f) < 1e-6f);
        /* within 1e-5 of an edge of the hole rounding decides */
        const float x = fmaxf(0.0f, fminf(local.x, 2.99999f)),
                    y = fmaxf(0.0f, fminf(local.y, 2.99999f));
        size_t bin = (size_t)(y * PER_UNIT) * SIDE + (size_t)(x * PER_UNIT);
        if (expected[bin] == 0.0) {
            const float outside = fminf(fminf(x - 1.0f, 2.0f - x), y - 1.0f);
            assert_true(outside < 1e-5f);
            continue;
        }
        observed[bin] += 1.0;
    }
    assert_true(chi_square_p(observed, expected, SIDE * SIDE, NULL) > 1e-4);
    air_light_table_finish(*state, &table);
}

/* Irradiance of a polygon of radiance 1 by Lambert's formula: half the sum over edges of the angle
 * they subtend times the cosine between the receiver's normal and the normal of the plane through
 * the edge and the receiver. */
static double lambert_irradiance(const float *vertices, size_t count, air_vec3 point,
                                 air_vec3 normal)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        const air_vec3 a = vec3_normalize(vec3_sub(vec3_load(vertices + 3 * i), point));
        const air_vec3 b =
            vec3_normalize(vec3_sub(vec3_load(vertices + 3 * ((i + 1) % count)), point));
        const air_vec3 cross = vec3_cross(a, b);
        const float length = vec3_length(cross);
        const double angle = atan2((double)length, (double)vec3_dot(a, b));
        sum += 0.5 * angle * (double)(vec3_dot(cross, normal) / length);
    }
    return fabs(sum);
}

static void irradiance_is_lamberts(void **state)
{
    placed p;
    place_u(&p, vec3(0.1f, -1.0f, 0.2f), vec3(-1.0f, 2.0f, -1.0f));
    air_light_table table = table_of_one(*state, &p.desc, NULL);
    const air_vec3 receivers[] = {vec3(0.5f, 0.0f, 0.0f), vec3(-2.0f, -1.0f, 1.0f),
                                  vec3(0.0f, -4.0f, 0.0f)};
    const air_vec3 up = vec3(0.0f, 1.0f, 0.0f);
    for (int r = 0; r < 3; r++) {
        enum { SIDE = 256 };
        double sum = 0.0, solid_angle = 0.0, squares = 0.0;
        air_rng rng = air_rng_from_keys(3, (uint32_t)r);
        for (int i = 0; i < SIDE * SIDE; i++) {
            air_light_point point;
            air_connection c;
            const float u1 = air_rng_float(&rng);
            air_light_sample(&table, 0, u1, air_rng_float(&rng), &point);
            assert_true(air_light_connect(&table, &point, receivers[r], &c));
            const double value = (double)(c.incident.y * vec3_dot(c.dir, up) / c.pdf);
            sum += value;
            squares += value * value;
            solid_angle += 1.0 / (double)c.pdf;
        }
        const double n = SIDE * SIDE, mean = sum / n;
        const double error = sqrt((squares / n - mean * mean) / n);
        const double exact = 2.0 * lambert_irradiance(p.vertices, 8, receivers[r], up);
        assert_true(exact > 0.1 && error < 0.01 * exact);
        assert_true(fabs(mean - exact) < 4.5 * error);
        /* and the mean of 1/pdf is a solid angle: less than a hemisphere, more than the irradiance
         * of radiance 1 */
        assert_true(solid_angle / n < 2.0 * AIR_PI && solid_angle / n > 0.5 * exact);
    }
    air_light_table_finish(*state, &table);
}

static void density_of_a_hit_is_that_of_the_connection(void **state)
{
    placed p;
    place_u(&p, vec3(0.3f, -1.0f, 0.2f), vec3(-1.0f, 2.0f, -1.0f));
    p.desc.one_sided = false;
    air_light_table table = table_of_one(*state, &p.desc, NULL);
    air_rng rng = air_rng_from_keys(4, 1);
    for (int i = 0; i < 10000; i++) {
        air_light_point point;
        air_connection c;
        const float u1 = air_rng_float(&rng);
        air_light_sample(&table, 0, u1, air_rng_float(&rng), &point);
        const float v1 = air_rng_float(&rng);
        const air_vec3 from = vec3_scale(sample_sphere(v1, air_rng_float(&rng)), 5.0f);
        if (air_light_connect(&table, &point, from, &c)) {
            assert_true(air_light_hit_pdf(&table, 0, vec3_set1(0.0f), c.dir, c.distance) == c.pdf);
        }
    }
    air_light_table_finish(*state, &table);
}

static void only_the_front_shines_where_one_sided(void **state)
{
    for (int two_sided = 0; two_sided < 2; two_sided++) {
        placed p;
        place_u(&p, vec3(0.0f, 0.0f, 1.0f), vec3(0.0f, 0.0f, 0.0f));
        p.desc.one_sided = two_sided == 0;
        air_light_table table = table_of_one(*state, &p.desc, NULL);
        air_light_point point;
        air_connection c;
        air_light_sample(&table, 0, 0.3f, 0.6f, &point);
        assert_true(point.normal.z > 0.999f); /* vertices run counter-clockwise seen from +z */
        assert_true(air_light_connect(&table, &point, vec3(0.0f, 0.0f, 2.0f), &c));
        assert_true(air_light_connect(&table, &point, vec3(0.0f, 0.0f, -2.0f), &c) ==
                    (two_sided == 1));
        const air_light *light = &table.entries[0];
        assert_true(air_polygon_radiance(light, vec3(0.0f, 0.0f, -1.0f)).x == 3.0f);
        assert_true(air_polygon_radiance(light, vec3(0.0f, 0.0f, 1.0f)).x ==
                    (two_sided ? 3.0f : 0.0f));
        air_light_table_finish(*state, &table);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_make_up_a_concave_polygon),
        cmocka_unit_test(a_seam_makes_a_hole),
        cmocka_unit_test(crossing_edges_are_found),
        cmocka_unit_test(points_are_uniform_over_the_polygon),
        cmocka_unit_test(irradiance_is_lamberts),
        cmocka_unit_test(density_of_a_hit_is_that_of_the_connection),
        cmocka_unit_test(only_the_front_shines_where_one_sided),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}

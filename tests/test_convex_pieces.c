/* Triangles joined to convex pieces: few, flat, convex, and of the same light. */
#include <stdlib.h>

#include "core/random.h"
#include "core/triple.h"
#include "failing_allocator.h"
#include "light_fixture.h"
#include "scene/lights/convex_pieces.h"
#include "scene/lights/polygon.h"

enum { MOST_POINTS = 400, MOST_TRIANGLES = 800, PROBES = 200 };

/* A flat mesh, and where it is in the world. */
typedef struct flat_mesh {
    air_point2 points[MOST_POINTS];
    size_t point_count;
    uint32_t triangles[MOST_TRIANGLES][3];
    size_t count;
    air_frame frame;
    double vertices[3 * MOST_TRIANGLES][3]; /* in the world, 3 per triangle */
} flat_mesh;

/* A place for it, with the rounding of float coordinates. */
static void place(flat_mesh *m, air_vec3 normal)
{
    const air_vec3 origin = vec3(1.0f, -2.0f, 0.7f);
    m->frame = frame_from_normal(vec3_normalize(normal));
    for (size_t i = 0; i < 3 * m->count; i++) {
        const air_point2 p = m->points[m->triangles[i / 3][i % 3]];
        const air_vec3 local = vec3((float)p.x, (float)p.y, 0.0f);
        vec3_store64(m->vertices[i], vec3_add(origin, frame_to_world(&m->frame, local)));
    }
}

static void shuffle(flat_mesh *m, air_rng *rng)
{
    for (size_t i = m->count - 1; i > 0; i--) {
        const size_t k = air_rng_next(rng) % (i + 1), turn = air_rng_next(rng) % 3;
        for (size_t c = 0; c < 3; c++) {
            const uint32_t kept = m->triangles[i][c];
            m->triangles[i][c] = m->triangles[k][c];
            m->triangles[k][c] = kept;
        }
        const uint32_t first = m->triangles[i][turn];
        const uint32_t second = m->triangles[i][(turn + 1) % 3];
        const uint32_t third = m->triangles[i][(turn + 2) % 3];
        m->triangles[i][0] = first;
        m->triangles[i][1] = second;
        m->triangles[i][2] = third;
    }
}

static void clip_ears(flat_mesh *m)
{
    size_t links[2 * MOST_POINTS];
    m->count = air_polygon_triangulate(m->points, m->point_count, links, m->triangles);
    assert_true(m->count > 0);
}

static void make_fan(flat_mesh *m)
{
    m->count = m->point_count - 2;
    for (uint32_t i = 0; i < m->count; i++) {
        m->triangles[i][0] = 0;
        m->triangles[i][1] = i + 1;
        m->triangles[i][2] = i + 2;
    }
}

/* Corners on an ellipse, in unequal steps. */
static void make_round(flat_mesh *m, air_rng *rng, size_t corners)
{
    m->point_count = corners;
    for (size_t i = 0; i < corners; i++) {
        const double at = (double)i + 0.8 * (double)air_rng_float(rng);
        const double angle = 2.0 * AIR_PI * at / (double)corners;
        m->points[i] = (air_point2){1.5 * cos(angle), 0.6 * sin(angle)};
    }
}

/* columns x rows cells of unequal width and height if `uneven`. */
static void make_grid(flat_mesh *m, size_t columns, size_t rows, bool uneven)
{
    m->point_count = (columns + 1) * (rows + 1);
    m->count = 0;
    for (size_t i = 0; i < m->point_count; i++) {
        const double x = (double)(i % (columns + 1)) / (double)columns;
        const double y = (double)(i / (columns + 1)) / (double)rows;
        m->points[i] = (air_point2){uneven ? x * x : x, 2.0 * (uneven ? y * y : y)};
    }
    for (size_t i = 0; i < columns * rows; i++) {
        const uint32_t right = 1, up = (uint32_t)columns + 1;
        const uint32_t at = (uint32_t)(i / columns * (columns + 1) + i % columns);
        const uint32_t corners[2][3] = {{at, at + right, at + right + up},
                                        {at, at + right + up, at + up}};
        memcpy(m->triangles[m->count], corners, sizeof corners);
        m->count += 2;
    }
}

/* ---- what must hold of all pieces ---- */

static bool is_inside(const double (*corners)[3], size_t count, const double normal[3],
                      const double point[3])
{
    for (size_t i = 0; i < count; i++) {
        double along[3], to[3], cross[3];
        air_subtract3(corners[(i + 1) % count], corners[i], along);
        air_subtract3(point, corners[i], to);
        air_cross3(along, to, cross);
        if (air_dot3(cross, normal) < 0.0) {
            return false;
        }
    }
    return true;
}

/* Points near an edge by chance would tell of rounding: there are none with these seeds. */
static void assert_same_set(const flat_mesh *m, const air_convex_pieces *pieces,
                            const double normal[3])
{
    air_rng rng = air_rng_from_keys(5, 6);
    for (int i = 0; i < PROBES; i++) {
        const float *origin = (const float[3]){1.0f, -2.0f, 0.7f};
        const air_vec3 local =
            vec3(3.2f * air_rng_float(&rng) - 1.6f, 3.2f * air_rng_float(&rng) - 1.6f, 0.0f);
        double point[3];
        int before = 0, after = 0;
        vec3_store64(point, vec3_add(vec3_load(origin), frame_to_world(&m->frame, local)));
        for (size_t t = 0; t < m->count; t++) {
            before += is_inside((const double(*)[3])m->vertices + 3 * t, 3, normal, point);
        }
        for (size_t k = 0, begin = 0; k < pieces->count; begin = pieces->ends[k++]) {
            after += is_inside((const double(*)[3])pieces->corners + begin, pieces->ends[k] - begin,
                               normal, point);
        }
        assert_int_equal(after, before);
    }
}

static double area_of(const double (*vertices)[3])
{
    double a[3], b[3], cross[3];
    air_subtract3(vertices[1], vertices[0], a);
    air_subtract3(vertices[2], vertices[0], b);
    air_cross3(a, b, cross);
    return 0.5 * air_length3(cross);
}

/* Coordinates are below 4, so that sides move by 2^-18 at most; they are shorter than 100 together.
 */
static air_convex_pieces join(air_context *context, const flat_mesh *m)
{
    air_convex_pieces pieces;
    double normal[3], before = 0.0, after = 0.0;
    const double(*vertices)[3] = (const double(*)[3])m->vertices;
    vec3_store64(normal, m->frame.n);
    assert_int_equal(air_convex_pieces_make(context, vertices, m->count, &pieces), AIR_OK);
    for (size_t t = 0; t < m->count; t++) {
        before += area_of(vertices + 3 * t);
    }
    for (size_t i = 0, begin = 0; i < pieces.count; begin = pieces.ends[i++]) {
        air_area_lamp lamp;
        assert_int_equal(air_area_lamp_make(context, (const double(*)[3])pieces.corners + begin,
                                            pieces.ends[i] - begin, false, &lamp),
                         AIR_OK);
        assert_true(air_dot3(lamp.normal, normal) > 0.9999);
        after += lamp.area;
    }
    assert_true(fabs(after - before) < 100.0 * 0x1p-18);
    assert_same_set(m, &pieces, normal);
    return pieces;
}

static void assert_count(air_context *context, const flat_mesh *m, size_t least, size_t most)
{
    air_convex_pieces pieces = join(context, m);
    if (pieces.count < least || pieces.count > most) {
        fail_msg("%zu pieces of %zu triangles, expected %zu to %zu", pieces.count, m->count, least,
                 most);
    }
    air_convex_pieces_finish(context, &pieces);
}

static void assert_polygon(air_context *context, const flat_mesh *m, size_t corners)
{
    air_convex_pieces pieces = join(context, m);
    assert_int_equal(pieces.count, 1);
    assert_int_equal(pieces.ends[0], corners);
    air_convex_pieces_finish(context, &pieces);
}

/* ---- tests ---- */

static void a_convex_polygon_comes_back_whole(void **state)
{
    air_rng rng = air_rng_from_keys(1, 2);
    for (int i = 0; i < 300; i++) {
        flat_mesh m;
        make_round(&m, &rng, 3 + air_rng_next(&rng) % (AIR_AREA_MAX_VERTICES - 2));
        if (i % 2 == 0) {
            make_fan(&m);
        } else {
            clip_ears(&m);
        }
        shuffle(&m, &rng);
        place(&m, vec3(air_rng_float(&rng) - 0.5f, air_rng_float(&rng) - 0.5f, 0.3f));
        assert_polygon(*state, &m, m.point_count);
    }
}

static void more_corners_than_a_lamp_has_make_several_pieces(void **state)
{
    air_rng rng = air_rng_from_keys(3, 4);
    for (int i = 0; i < 20; i++) {
        flat_mesh m;
        make_round(&m, &rng, 40);
        if (i % 2 == 0) {
            make_fan(&m);
        } else {
            clip_ears(&m);
        }
        place(&m, vec3(0.2f, 0.3f, 0.5f));
        /* 14 corners for each piece after the first, 40 + 2 to cover; half as full at worst */
        assert_count(*state, &m, 3, 6);
    }
}

static void a_grid_becomes_a_rectangle(void **state)
{
    static const size_t sizes[][2] = {{1, 1}, {4, 4}, {7, 3}, {1, 16}, {16, 16}, {19, 19}};
    air_rng rng = air_rng_from_keys(7, 8);
    for (size_t i = 0; i < 4 * sizeof sizes / sizeof *sizes; i++) {
        flat_mesh m;
        make_grid(&m, sizes[i / 4][0], sizes[i / 4][1], i % 2 == 1);
        if (i % 4 > 1) {
            shuffle(&m, &rng);
        }
        place(&m, vec3(0.3f * (float)i, -0.5f, 0.7f));
        assert_polygon(*state, &m, 4);
        place(&m, vec3(0.0f, 1.0f, 0.0f));
        assert_polygon(*state, &m, 4);
    }
}

/* One cut for each corner that turns right, or for two of them. */
static void concave_shapes_become_few_pieces(void **state)
{
    static const air_point2 l_shape[] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    static const air_point2 u_shape[] = {{0, 0},   {1.5, 0},   {1.5, 1.5}, {1, 1.5},
                                         {1, 0.5}, {0.5, 0.5}, {0.5, 1.5}, {0, 1.5}};
    static const air_point2 comb[] = {
        {0, 0},   {1.4, 0}, {1.4, 1}, {1.2, 1}, {1.2, .4}, {1.0, .4}, {1.0, 1}, {0.8, 1},
        {.8, .4}, {.6, .4}, {0.6, 1}, {0.4, 1}, {0.4, .4}, {0.2, .4}, {0.2, 1}, {0, 1}};
    flat_mesh star;
    star.point_count = 10;
    for (int i = 0; i < 10; i++) {
        const double radius = i % 2 == 0 ? 1.0 : 0.4, angle = AIR_PI * i / 5.0;
        star.points[i] = (air_point2){radius * cos(angle), radius * sin(angle)};
    }
    const struct {
        const air_point2 *points;
        size_t count, pieces;
    } shapes[] = {{l_shape, 6, 2}, {u_shape, 8, 3}, {comb, 16, 5}, {star.points, 10, 5}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        flat_mesh m;
        m.point_count = shapes[i].count;
        memcpy(m.points, shapes[i].points, m.point_count * sizeof *m.points);
        clip_ears(&m);
        place(&m, vec3(0.1f, 0.2f, -0.9f));
        assert_count(*state, &m, 2, shapes[i].pieces);
        place(&m, vec3(0.0f, 0.0f, 1.0f));
        assert_count(*state, &m, 2, shapes[i].pieces);
    }
}

/* Vertices in the world, as they are. */
static size_t count_pieces(air_context *context, const double (*vertices)[3], size_t triangles)
{
    air_convex_pieces pieces;
    assert_int_equal(air_convex_pieces_make(context, vertices, triangles, &pieces), AIR_OK);
    const size_t count = pieces.count;
    air_convex_pieces_finish(context, &pieces);
    return count;
}

static void what_does_not_belong_together_stays_apart(void **state)
{
    const double away = sin(5.0 * AIR_PI / 180.0), along = cos(5.0 * AIR_PI / 180.0);
    const double squares[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {2, 0, 0}, {3, 1, 0}, {2, 1, 0}};
    const double opposite[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    const double folded[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}, {1, 0, 0}, {0, 0, 0}};
    const double bent[][3] = {{0, 0, 0},
                              {1, 0, 0},
                              {1, 1, 0},
                              {0, 0, 0},
                              {1, 1, 0},
                              {0, 1, 0},
                              {1, 0, 0},
                              {1 + along, 0, away},
                              {1 + along, 1, away},
                              {1, 0, 0},
                              {1 + along, 1, away},
                              {1, 1, 0}};
    assert_int_equal(count_pieces(*state, squares, 4), 2);
    assert_int_equal(count_pieces(*state, opposite, 2), 2);
    assert_int_equal(count_pieces(*state, folded, 2), 2);
    assert_int_equal(count_pieces(*state, bent, 4), 2);
}

static void what_has_no_area_is_left_out(void **state)
{
    const double none[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 1, 0}, {2, 2, 0},
                              {5, 5, 5}, {5, 5, 5}, {5, 5, 5}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    assert_int_equal(count_pieces(*state, none, 0), 0);
    assert_int_equal(count_pieces(*state, none, 3), 0);
    assert_int_equal(count_pieces(*state, none, 4), 1);
}

/* A tooth's foot in the middle of a longer side, sewn to it by a triangle without area. */
static void seams_without_area_join(void **state)
{
    const double seam[][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 0, 0}, {2, 1, 0}, {0, 1, 0},
                              {0, 1, 0}, {2, 1, 0}, {1, 1, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0},
                              {1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 1, 0}, {2, 2, 0}, {0, 2, 0}};
    assert_int_equal(count_pieces(*state, seam, 6), 1);
}

static void running_out_of_memory_leaves_nothing(void **state)
{
    (void)state;
    const double one[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    failing_allocator allocator;
    air_context_params params = failing_params(&allocator, 1000);
    air_context *context;
    air_status status = AIR_ERROR_MEMORY;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    const long live = atomic_load(&allocator.live);
    for (long n = 0; status != AIR_OK; n++) {
        air_convex_pieces pieces;
        atomic_store(&allocator.remaining, n);
        status = air_convex_pieces_make(context, one, 1, &pieces);
        atomic_store(&allocator.remaining, 1000);
        assert_true(status == AIR_OK ? n == 6 : status == AIR_ERROR_MEMORY && pieces.count == 0);
        air_convex_pieces_finish(context, &pieces);
        assert_int_equal(atomic_load(&allocator.live), live);
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_convex_polygon_comes_back_whole),
        cmocka_unit_test(more_corners_than_a_lamp_has_make_several_pieces),
        cmocka_unit_test(a_grid_becomes_a_rectangle),
        cmocka_unit_test(concave_shapes_become_few_pieces),
        cmocka_unit_test(what_does_not_belong_together_stays_apart),
        cmocka_unit_test(what_has_no_area_is_left_out),
        cmocka_unit_test(seams_without_area_join),
        cmocka_unit_test(running_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}

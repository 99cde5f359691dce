/* Islands of a layout, and what they stand on: equal vertices and shared sides. */
#include "atlas/islands.h"

#include "atlas/edge_table.h"
#include "atlas/weld.h"
#include "atlas_fixture.h"
#include "memory_shortage.h"

static size_t islands_of(air_context *context, const atlas_mesh *mesh, uint32_t *charts)
{
    const air_atlas_part part = atlas_part(mesh, 0.0, 0.0, 1.0, 1.0);
    size_t count = 0;
    assert_int_equal(air_islands_find(context, &part, charts, &count), AIR_OK);
    return count;
}

/* The mesh with three vertices of its own for each triangle. */
static atlas_mesh unshared(const atlas_mesh *mesh)
{
    atlas_mesh out = atlas_mesh_make(3 * mesh->triangle_count, mesh->triangle_count);
    for (size_t i = 0; i < out.vertex_count; i++) {
        const size_t from = mesh->indices[i];
        for (size_t k = 0; k < 3; k++) {
            out.positions[3 * i + k] = mesh->positions[3 * from + k];
        }
        for (size_t k = 0; k < 2; k++) {
            out.uv[2 * i + k] = mesh->uv[2 * from + k];
        }
        out.indices[i] = (uint32_t)i;
    }
    return out;
}

static void equal_vertices_count_as_one(void **state)
{
    (void)state;
    static const float positions[6 * 3] = {0, 0, 0, 1, 0, 0, -0.0f, 0, 0,
                                           1, 0, 1, 1, 0, 0, 0,     0, 0};
    static const float uv[6 * 2] = {0, 0, 1, 0, 0, -0.0f, 1, 0, 1, 0.5f, 1, 0};
    static const uint32_t by_both[6] = {0, 1, 0, 3, 4, 5}, by_place[6] = {0, 1, 0, 3, 1, 0};
    uint32_t first[6];
    air_context *context = atlas_context(1);
    const air_weld_keys both = {positions, uv, 6}, place = {positions, NULL, 6};
    assert_int_equal(air_weld(context, &both, first), AIR_OK);
    assert_memory_equal(first, by_both, sizeof first);
    assert_int_equal(air_weld(context, &place, first), AIR_OK);
    assert_memory_equal(first, by_place, sizeof first);
    air_context_destroy(context);
}

static void sides_over_the_same_vertices_stand_together(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_grid(10, 0.0f, 1);
    uint32_t *names = atlas_zeros(mesh.vertex_count, sizeof *names);
    air_edge_table table;
    for (uint32_t v = 0; v < mesh.vertex_count; v++) {
        names[v] = v;
    }
    assert_int_equal(air_edge_table_init(context, names, mesh.vertex_count, mesh.indices,
                                         mesh.triangle_count, &table),
                     AIR_OK);
    assert_int_equal(table.count, 600);
    size_t inner = 0, border = 0;
    for (size_t i = 0; i < table.count; i = air_edge_table_run(&table, i)) {
        const size_t end = air_edge_table_run(&table, i);
        assert_true(end - i <= 2);
        if (end - i == 2) {
            assert_true(table.edges[i].triangle < table.edges[i + 1].triangle);
            assert_true(table.edges[i].reversed != table.edges[i + 1].reversed);
            inner++;
        } else {
            border++;
        }
        const air_edge *e = &table.edges[i];
        const uint32_t *corners = mesh.indices + 3 * e->triangle;
        const uint32_t a = corners[e->corner], b = corners[(e->corner + 1) % 3];
        assert_int_equal(e->reversed ? b : a, e->low);
        assert_int_equal(e->reversed ? a : b, e->high);
    }
    assert_int_equal(border, 40);
    assert_int_equal(inner, 280);
    air_edge_table_finish(context, &table);
    free(names);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* One grid, whether vertices are shared or not; two where uv or positions part along a line. */
static void sides_join_islands(void **state)
{
    enum { N = 8, T = 2 * N * N };
    (void)state;
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_grid(N, 0.2f, 1), apart = unshared(&mesh);
    uint32_t charts[T];
    assert_int_equal(islands_of(context, &mesh, charts), 1);
    assert_int_equal(islands_of(context, &apart, charts), 1);
    for (size_t i = 3 * T / 2; i < 3 * T; i++) { /* the lower half of the cells */
        apart.uv[2 * i] += 2.0f;
    }
    assert_int_equal(islands_of(context, &apart, charts), 2);
    for (size_t t = 0; t < T; t++) {
        assert_int_equal(charts[t], t >= T / 2);
        for (size_t i = 3 * t; i < 3 * t + 3 && t >= T / 2; i++) {
            apart.uv[2 * i] -= 2.0f;
            apart.positions[3 * i + 2] = 1.0f;
        }
    }
    /* uv - 2 + 2 is rounded, so take the grid's own again */
    for (size_t i = 0; i < 3 * T; i++) {
        apart.uv[2 * i] = mesh.uv[2 * mesh.indices[i]];
    }
    assert_int_equal(islands_of(context, &apart, charts), 2);
    atlas_mesh_free(&apart);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

/* Triangles that meet in a corner only are apart; islands are numbered by their first triangles. */
static void corners_do_not_join(void **state)
{
    (void)state;
    static const uint32_t indices[9] = {0, 1, 3, 4, 5, 7, 1, 2, 4};
    uint32_t charts[3];
    air_context *context = atlas_context(1);
    atlas_mesh mesh = atlas_grid(2, 0.0f, 1);
    mesh.triangle_count = 3;
    for (size_t i = 0; i < 9; i++) {
        mesh.indices[i] = indices[i];
    }
    assert_int_equal(islands_of(context, &mesh, charts), 3);
    assert_true(charts[0] == 0 && charts[1] == 1 && charts[2] == 2);
    atlas_mesh_free(&mesh);
    air_context_destroy(context);
}

static air_status try_islands(air_context *context, void *part)
{
    uint32_t charts[18];
    size_t count;
    return air_islands_find(context, part, charts, &count);
}

static void want_of_memory_is_reported(void **state)
{
    (void)state;
    atlas_mesh mesh = atlas_grid(3, 0.0f, 1);
    air_atlas_part part = atlas_part(&mesh, 0.0, 0.0, 1.0, 1.0);
    assert_shortage_survived(try_islands, &part, 50);
    atlas_mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_vertices_count_as_one),
        cmocka_unit_test(sides_over_the_same_vertices_stand_together),
        cmocka_unit_test(sides_join_islands),
        cmocka_unit_test(corners_do_not_join),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The box of cells about the media of a scene, and what is in them. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "grid_scene.h"
#include "memory_shortage.h"
#include "picture_fixture.h"
#include "render/ordinates/domain.h"

enum { SIDE = 32 };

static air_snapshot *make_scene(air_context *context, const grid_scene *s)
{
    air_snapshot *snapshot;
    assert_int_equal(grid_scene_make(context, s, &snapshot), AIR_OK);
    return snapshot;
}

static ord_domain make_domain(const air_snapshot *snapshot, uint32_t cells)
{
    ord_domain domain;
    assert_int_equal(ord_domain_place(snapshot, cells, NULL, &domain), AIR_OK);
    assert_int_equal(ord_domain_fill(&domain), AIR_OK);
    return domain;
}

/* A medium between two corners. */
static air_medium_desc box_medium(const char *name, float s, float a, float g, const float low[3],
                                  const float high[3])
{
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.name = name;
    room_set3(medium.sigma_s, s, 0.5f * s, 0.25f * s);
    room_set3(medium.sigma_a, a, a, 2.0f * a);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = g;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    for (int k = 0; k < 3; k++) {
        for (int n = 0; n < 3; n++) {
            medium.boundary.box_to_world[4 * k + n] = n == k ? 0.5f * (high[k] - low[k]) : 0.0f;
        }
        medium.boundary.box_to_world[4 * k + 3] = 0.5f * (high[k] + low[k]);
    }
    return medium;
}

static air_snapshot *commit(air_context *context, const air_medium_desc *media, size_t count)
{
    air_scene *scene;
    air_snapshot *snapshot;
    air_handle handle;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(air_scene_add_medium(scene, &media[i], &handle), AIR_OK);
    }
    assert_int_equal(grid_add_lights(scene, GRID_SUN), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance)) {
        fail_msg("%.9g, expected %.9g within %g", found, expected, tolerance);
    }
}

static double total(const ord_domain *domain, const float *plane)
{
    double sum = 0.0;
    for (size_t i = 0; i < domain->cells; i++) {
        sum += (double)plane[i];
    }
    return sum * pow((double)domain->cell_m, 3.0);
}

/* ---- boxes ---- */

/* 64 numbers added up in float: 64 x 2^-24. */
static void cells_of_a_box_hold_its_coefficients(void **state)
{
    (void)state;
    const grid_scene s = {
        .lights = GRID_SUN, .sigma_s = {2, 3, 4}, .sigma_a = {0.1f, 0.2f, 0.3f}, .g = 0.6f};
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = make_scene(context, &s);
    ord_domain domain = make_domain(snapshot, 7);
    assert_int_equal(domain.cells, 343);
    assert_near((double)domain.origin[1], -0.5, 1e-6);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < domain.cells; i++) {
            const size_t at = c * domain.cells + i;
            assert_near((double)domain.sigma_s[at], (double)s.sigma_s[c], 2e-5);
            assert_near((double)domain.sigma_a[at], (double)s.sigma_a[c], 2e-5);
            assert_near((double)domain.g[at], 0.6, 1e-5);
        }
    }
    ord_domain_finish(&domain);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* Borders cut cells; along an axis the looks in a cell miss up to half a look's distance at either
 * end: an eighth of a cell of 0.1 m, of a length of 0.8 m and 0.6 m. */
static void cells_that_borders_cut_hold_their_share(void **state)
{
    (void)state;
    const grid_scene s = {
        .lights = GRID_SUN, .sigma_s = {2, 3, 4}, .sigma_a = {0, 0, 0}, .g = 0.6f, .second = true};
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = make_scene(context, &s);
    ord_domain domain = make_domain(snapshot, 13);
    const double first = 1.0, second = 0.8 * 0.6 * 0.6, missed = 0.25 * 0.1;
    const double dust[3] = {3.0, 2.0, 1.0}, absorbed[3] = {0.1, 0.2, 0.3};
    const double bound = 3.0 * missed;
    for (size_t c = 0; c < 3; c++) {
        const double sigma = (double)s.sigma_s[c];
        const double expected = sigma * first + dust[c] * second;
        assert_near(total(&domain, domain.sigma_s + c * domain.cells) / expected, 1.0, bound);
        assert_near(total(&domain, domain.sigma_a + c * domain.cells) / (absorbed[c] * second), 1.0,
                    2.0 * bound);
        for (size_t i = 0; i < domain.cells; i++) {
            const double seen = (double)domain.sigma_s[c * domain.cells + i];
            const double g = (double)domain.g[c * domain.cells + i];
            assert_true(seen >= 0.0 && seen <= (sigma + dust[c]) * (1.0 + 1e-5));
            assert_true(seen > 0.0 ? g >= -0.3 - 1e-6 && g <= 0.6 + 1e-6 : g == 0.0);
        }
    }
    ord_domain_finish(&domain);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* The cell about a point. */
static size_t cell_at(const ord_domain *domain, float x, float y, float z)
{
    const float p[3] = {x, y, z};
    size_t at[3];
    for (int axis = 0; axis < 3; axis++) {
        at[axis] = (size_t)((p[axis] - domain->origin[axis]) / domain->cell_m);
        assert_true(at[axis] < domain->size[axis]);
    }
    return (at[2] * domain->size[1] + at[1]) * domain->size[0] + at[0];
}

static void media_that_overlap_add_up_or_replace(void **state)
{
    (void)state;
    const float a_low[3] = {0, 0, 0}, a_high[3] = {1, 1, 1}, b_low[3] = {0.5f, 0, 0};
    const float b_high[3] = {1.5f, 1, 1};
    air_medium_desc media[2] = {box_medium("a", 4.0f, 1.0f, 0.8f, a_low, a_high),
                                box_medium("b", 2.0f, 0.5f, -0.4f, b_low, b_high)};
    air_context *context = make_context(1, NULL);
    for (int replace = 0; replace < 2; replace++) {
        media[1].combine = replace == 1 ? AIR_COMBINE_REPLACE : AIR_COMBINE_ADD;
        media[1].priority = replace;
        air_snapshot *snapshot = commit(context, media, 2);
        ord_domain domain = make_domain(snapshot, 12);
        const size_t alone = cell_at(&domain, 0.2f, 0.5f, 0.5f);
        const size_t both = cell_at(&domain, 0.8f, 0.5f, 0.5f);
        assert_near((double)domain.sigma_s[alone], 4.0, 1e-5);
        assert_near((double)domain.g[alone], 0.8, 1e-6);
        assert_near((double)domain.sigma_s[both], replace == 1 ? 2.0 : 6.0, 2e-5);
        assert_near((double)domain.sigma_a[both], replace == 1 ? 0.5 : 1.5, 2e-5);
        assert_near((double)domain.g[both], replace == 1 ? -0.4 : (4.0 * 0.8 - 2.0 * 0.4) / 6.0,
                    1e-5);
        ord_domain_finish(&domain);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

static void media_that_only_glow_or_are_nothing_have_no_cells(void **state)
{
    (void)state;
    const float low[3] = {0, 0, 0}, high[3] = {1, 1, 1}, far_low[3] = {5, 0, 0};
    const float far_high[3] = {9, 1, 1};
    air_medium_desc media[2] = {box_medium("a", 4.0f, 1.0f, 0.0f, low, high),
                                box_medium("glow", 0.0f, 0.0f, 0.0f, far_low, far_high)};
    room_set3(media[1].emission, 1.0f, 1.0f, 1.0f);
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = commit(context, media, 2);
    ord_domain domain;
    assert_int_equal(ord_domain_place(snapshot, 4, NULL, &domain), AIR_OK);
    assert_int_equal(domain.size[0], 4);
    air_snapshot_release(snapshot);
    snapshot = commit(context, &media[1], 1);
    assert_int_equal(ord_domain_place(snapshot, 4, NULL, &domain), AIR_ERROR_ARGUMENT);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* A second medium of 1.5 cells, and one of 2.5. */
static void media_thinner_than_two_cells_are_told(void **state)
{
    (void)state;
    messages m;
    const float low[3] = {0, 0, 0}, high[3] = {1, 1, 1}, top[3] = {1, 0.15f, 1};
    air_medium_desc media[2] = {box_medium("air", 1.0f, 0.0f, 0.0f, low, high),
                                box_medium("sheet", 4.0f, 0.0f, 0.0f, low, top)};
    air_context *context = make_context(1, &m);
    for (int n = 0; n < 2; n++) {
        air_snapshot *snapshot = commit(context, media, 2);
        ord_domain domain = make_domain(snapshot, 10);
        assert_int_equal(m.warnings, 1);
        assert_non_null(strstr(m.last_warning, "medium \"sheet\" is 0.15 m thick"));
        ord_domain_finish(&domain);
        air_snapshot_release(snapshot);
        media[1].boundary.box_to_world[5] = 0.125f;
    }
    air_context_destroy(context);
}

/* ---- grids ---- */

/* A medium whose grid fills the unit cube, moved by so many voxels along x; density is 0 outside
 * voxels [low, high). */
static air_snapshot *commit_moved(air_context *context, const int low[3], const int high[3],
                                  float density, bool linear, float voxels)
{
    float *const values = calloc(SIDE * SIDE * SIDE, sizeof *values);
    air_grid_desc grid = {"smoke", {SIDE, SIDE, SIDE}, 1, values, {0}};
    const float step = 1.0f / SIDE;
    air_medium_desc medium;
    air_scene *scene;
    air_snapshot *snapshot;
    air_handle handle;
    assert_non_null(values);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        bool inside = true;
        for (int k = 0; k < 3; k++) {
            inside = inside && at[k] >= low[k] && at[k] < high[k];
        }
        values[i] = !inside  ? 0.0f
                    : linear ? 1.0f + ((float)at[0] + 2.0f * (float)at[2]) * step
                             : density;
    }
    for (int k = 0; k < 3; k++) {
        grid.index_to_local[5 * k] = step;
        grid.index_to_local[4 * k + 3] = (k == 0 ? 0.5f + voxels : 0.5f) * step;
    }
    air_medium_desc_default(&medium);
    medium.name = "smoke";
    room_set3(medium.sigma_s, 40.0f, 20.0f, 10.0f);
    medium.density.kind = AIR_DENSITY_GRID;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(air_scene_add_grid(scene, &grid, &medium.density.grid), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
    assert_int_equal(grid_add_lights(scene, GRID_SUN), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    free(values);
    return snapshot;
}

static air_snapshot *commit_grid(air_context *context, const int low[3], const int high[3],
                                 float density, bool linear)
{
    return commit_moved(context, low, high, density, linear, 0.0f);
}

static const int whole_low[3] = {0, 0, 0}, whole_high[3] = {SIDE, SIDE, SIDE};

/* Away from the grid's faces, where values are held, looks lie evenly about a cell's centre, and
 * the interpolated density is linear. */
static void cells_of_a_grid_hold_its_mean(void **state)
{
    (void)state;
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = commit_grid(context, whole_low, whole_high, 1.0f, true);
    ord_domain domain = make_domain(snapshot, 8);
    assert_int_equal(domain.cells, 512);
    for (size_t cell = 0; cell < domain.cells; cell++) {
        size_t at[3];
        ord_domain_cell(&domain, cell, at);
        if (at[0] % 7 != 0 && at[2] % 7 != 0) {
            const double x = ((double)at[0] + 0.5) / 8.0, z = ((double)at[2] + 0.5) / 8.0;
            const double density = 1.0 + x + 2.0 * z - 1.5 / SIDE;
            assert_near((double)domain.sigma_s[cell], 40.0 * density, 40.0 * density * 1e-5);
        }
    }
    ord_domain_finish(&domain);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* A lattice of 1/32 m: voxels [8, 20) reach to the centres of their neighbours, 7.5 and 20.5. */
static void the_box_leaves_empty_margins_out(void **state)
{
    (void)state;
    const int low[3] = {8, 8, 4}, high[3] = {20, 16, 12};
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = commit_grid(context, low, high, 1.0f, false);
    ord_domain domain = make_domain(snapshot, 14);
    assert_int_equal(domain.size[0], 14);
    assert_int_equal(domain.size[1], 10);
    assert_int_equal(domain.size[2], 10);
    assert_near((double)domain.cell_m, 1.0 / 32.0, 1e-7);
    assert_near((double)domain.origin[0], 7.0 / 32.0, 1e-6);
    assert_near((double)domain.origin[2], 3.0 / 32.0, 1e-6);
    /* Trilinear between voxels, the whole is what the voxels have; cells are voxels here, and in
     * one that is between 1 and 0 along one axis looks average a line whose end lies at a kink:
     * (1/8 + 3/8 ...)/4 is the line's mean. */
    const double volume = 12.0 * 8.0 * 8.0 / (SIDE * SIDE * SIDE);
    assert_near(total(&domain, domain.sigma_s), 40.0 * volume, 40.0 * volume * 1e-4);
    ord_domain_finish(&domain);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* As in a sequence of grids. */
static void the_box_rests_while_smoke_moves_within_its_lattice(void **state)
{
    (void)state;
    const int low[3] = {8, 8, 8}, high[3] = {20, 20, 20}, later_low[3] = {9, 8, 8};
    air_context *context = make_context(1, NULL);
    ord_domain first, later;
    air_snapshot *a = commit_grid(context, low, high, 1.0f, false);
    air_snapshot *b = commit_grid(context, low, high, 1e-9f, false);
    assert_int_equal(ord_domain_place(a, 10, NULL, &first), AIR_OK);
    air_snapshot_release(a);
    a = commit_grid(context, low, high, 0.2f, false);
    assert_int_equal(ord_domain_place(a, 10, NULL, &later), AIR_OK);
    assert_memory_equal(first.origin, later.origin, sizeof first.origin);
    assert_true(first.cell_m == later.cell_m);
    air_snapshot_release(a);
    a = commit_grid(context, later_low, high, 1.0f, false);
    assert_int_equal(ord_domain_place(a, 10, NULL, &later), AIR_OK);
    /* 13 of the lattice's lengths in 10 cells of 1.4: half of what is left is on either side. */
    assert_near((double)(later.origin[0] - first.origin[0]), 0.5 / 32.0, 1e-6);
    /* What is nowhere worth mention has the whole box. */
    assert_int_equal(ord_domain_place(b, 10, NULL, &later), AIR_OK);
    assert_near((double)later.origin[0], 0.0, 1e-6);
    assert_near((double)later.cell_m, 0.1, 1e-6);
    air_snapshot_release(a);
    air_snapshot_release(b);
    air_context_destroy(context);
}

/* How far the lattice of smoke in voxels [8, 20) goes with smoke in [from, from + 12) of a grid
 * that was moved, in voxels. */
static double voxels_followed(air_context *context, int from, float moved)
{
    const int low[3] = {8, 8, 8}, high[3] = {20, 20, 20};
    const int later_low[3] = {from, 8, 8}, later_high[3] = {from + 12, 20, 20};
    ord_domain first, later;
    air_snapshot *const a = commit_grid(context, low, high, 1.0f, false);
    air_snapshot *const b = commit_moved(context, later_low, later_high, 1.0f, false, moved);
    assert_int_equal(ord_domain_place(a, 10, NULL, &first), AIR_OK);
    assert_int_equal(ord_domain_place(b, 10, &first.lattice, &later), AIR_OK);
    assert_true(later.goes_on && later.cell_m == first.cell_m);
    air_snapshot_release(a);
    air_snapshot_release(b);
    return (double)(later.lattice.base[0] - first.lattice.base[0]) * SIDE;
}

/* Smoke drifts by a voxel: in a grid that rests, in one that is cut anew and has it in the same
 * voxels, in both ways at once. A grid that moves takes the cells along, by any part of a voxel. */
static void the_lattice_rests_while_smoke_drifts_and_follows_grids_that_move(void **state)
{
    (void)state;
    air_context *context = make_context(1, NULL);
    assert_near(voxels_followed(context, 9, 0.0f), 0.0, 1e-4);
    assert_near(voxels_followed(context, 8, 1.0f), 0.0, 1e-4);
    assert_near(voxels_followed(context, 7, 2.0f), 0.0, 1e-4);
    assert_near(voxels_followed(context, 8, 0.4f), 0.4, 1e-4);
    assert_near(voxels_followed(context, 8, -1.3f), -1.3, 1e-4);
    air_context_destroy(context);
}

static void empty_grids_have_their_box_and_nothing_in_it(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot = commit_grid(context, whole_high, whole_high, 1.0f, false);
    ord_domain domain = make_domain(snapshot, 4);
    assert_int_equal(m.warnings, 1);
    assert_int_equal(domain.cells, 64);
    for (size_t i = 0; i < 3 * domain.cells; i++) {
        assert_true(domain.sigma_s[i] == 0.0f && domain.sigma_a[i] == 0.0f && domain.g[i] == 0.0f);
    }
    ord_domain_finish(&domain);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- failure ---- */

static air_status try_domain(air_context *context, void *user)
{
    air_snapshot *snapshot;
    ord_domain domain;
    air_status status = grid_scene_make(context, user, &snapshot);
    if (status == AIR_OK) {
        status = ord_domain_place(snapshot, 3, NULL, &domain);
        assert_int_equal(status, AIR_OK);
        status = ord_domain_fill(&domain);
        ord_domain_finish(&domain);
    }
    air_snapshot_release(snapshot);
    return status;
}

static void allocation_failures_leave_nothing_behind(void **state)
{
    (void)state;
    grid_scene s = {.lights = GRID_SUN, .sigma_s = {2, 3, 4}, .blob = true};
    assert_shortage_survived(try_domain, &s, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_of_a_box_hold_its_coefficients),
        cmocka_unit_test(cells_that_borders_cut_hold_their_share),
        cmocka_unit_test(media_that_overlap_add_up_or_replace),
        cmocka_unit_test(media_that_only_glow_or_are_nothing_have_no_cells),
        cmocka_unit_test(media_thinner_than_two_cells_are_told),
        cmocka_unit_test(cells_of_a_grid_hold_its_mean),
        cmocka_unit_test(the_box_leaves_empty_margins_out),
        cmocka_unit_test(the_box_rests_while_smoke_moves_within_its_lattice),
        cmocka_unit_test(the_lattice_rests_while_smoke_drifts_and_follows_grids_that_move),
        cmocka_unit_test(empty_grids_have_their_box_and_nothing_in_it),
        cmocka_unit_test(allocation_failures_leave_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

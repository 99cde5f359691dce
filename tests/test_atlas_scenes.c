/* The atlas on meshes of real files. */
#include "atlas/coverage.h"
#include "atlas_scene.h"

/* The house's two meshes come with layouts of their own. What their triangles cover is their area
 * in uv, but for what is degenerate, and each texel's fragments are at most its 1 where nothing
 * overlaps. */
static void layouts_of_the_house_are_covered(void **state)
{
    enum { SIZE = 1024 };
    (void)state;
    air_context *context = atlas_context(2);
    air_snapshot *snapshot = atlas_snapshot(context, "gltf_playcanvas/house.glb");
    for (size_t m = 0; snapshot != NULL && m < snapshot->mesh_count; m++) {
        const air_mesh *mesh = snapshot->meshes[m];
        assert_non_null(mesh->uv[1]);
        const air_atlas_part part = atlas_scene_part(mesh, 1, SIZE);
        air_coverage *coverage;
        air_coverage_report report;
        air_coverage_overlap overlap;
        assert_int_equal(air_coverage_create(context, SIZE, SIZE, &part, 1, &coverage, &report),
                         AIR_OK);
        assert_int_equal(air_coverage_find_overlap(context, coverage, &overlap), AIR_OK);
        (void)printf("%s: %zu triangles, %zu islands, %zu texels, %zu fragments; degenerate %zu, "
                     "outside %zu, overlaps in %zu texels (%u, %u), triangles %u and %u\n",
                     mesh->name, mesh->triangle_count, coverage->chart_count, report.covered_texels,
                     report.fragment_count, report.degenerate_count, report.outside_count,
                     overlap.texel_count, overlap.texel[0], overlap.texel[1], overlap.triangle[0],
                     overlap.triangle[1]);
        air_coverage_destroy(context, coverage);
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layouts_of_the_house_are_covered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The atlas on meshes of real files, from triangles to seams. AIR_ATLAS_PICTURES names a folder for
 * pictures of charts. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/image.h"
#include "atlas/coverage.h"
#include "atlas/dilate.h"
#include "atlas/pack.h"
#include "atlas/seams.h"
#include "atlas/unwrap.h"
#include "atlas_scene.h"

static const char *const files[2] = {"gltf_playcanvas/house.glb", "geometry/classroom.glb"};

/* ---- pictures ---- */

static void save_picture(air_context *context, const char *name, size_t width, size_t height,
                         const float *const planes[3])
{
    static const char *const channels[3] = {"R", "G", "B"};
    const char *folder = getenv("AIR_ATLAS_PICTURES");
    air_image_save_params params;
    air_image *image = NULL;
    char path[512];
    if (folder == NULL) {
        return;
    }
    (void)snprintf(path, sizeof path, "%s/%s.png", folder, name);
    assert_int_equal(air_image_create(context, width, height, 3, channels, &image), AIR_OK);
    for (size_t k = 0; k < 3; k++) {
        memcpy(air_image_plane(image, k), planes[k], width * height * sizeof(float));
    }
    air_image_save_params_default(&params);
    params.auto_exposure = false;
    params.view = AIR_VIEW_STANDARD;
    assert_int_equal(air_image_save(context, image, path, &params), AIR_OK);
    air_image_destroy(image);
}

/* A colour for each chart, darker where less is covered. */
static void save_charts(air_context *context, const char *name, const air_coverage *coverage)
{
    const size_t count = coverage->width * coverage->height;
    uint32_t *charts = atlas_zeros(count, sizeof *charts);
    float *planes[3] = {atlas_zeros(count, sizeof(float)), atlas_zeros(count, sizeof(float)),
                        atlas_zeros(count, sizeof(float))};
    float *areas = atlas_zeros(count, sizeof *areas);
    air_coverage_planes(context, coverage, charts, areas);
    for (size_t i = 0; i < count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t hash = air_hash_combine(charts[i], k);
            planes[k][i] = areas[i] * (0.2f + 0.8f * air_uint_to_float(hash));
        }
    }
    save_picture(context, name, coverage->width, coverage->height,
                 (const float *const[3]){planes[0], planes[1], planes[2]});
    for (int k = 0; k < 3; k++) {
        free(planes[k]);
    }
    free(areas);
    free(charts);
}

/* ---- layouts that files come with ---- */

static double triangle_area(const air_atlas_part *part, size_t t)
{
    double p[3][2];
    for (size_t i = 0; i < 3; i++) {
        for (size_t k = 0; k < 2; k++) {
            p[i][k] = (double)part->uv[2 * (size_t)part->indices[3 * t + i] + k] * part->size[k];
        }
    }
    return 0.5 * fabs((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                      (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]));
}

/* Areas of all fragments by triangle are those of the triangles, each fragment rounded to float. */
static void check_areas(const air_coverage *coverage, const air_atlas_part *part)
{
    double *sums = atlas_zeros(part->triangle_count, sizeof *sums);
    for (size_t i = 0; i < coverage->width * coverage->height; i++) {
        size_t count;
        const air_fragment *fragments =
            air_coverage_texel(coverage, i % coverage->width, i / coverage->width, &count);
        for (size_t k = 0; k < count; k++) {
            sums[air_fragment_triangle(fragments[k])] += (double)fragments[k].area;
        }
    }
    for (size_t t = 0; t < part->triangle_count; t++) {
        const double area = triangle_area(part, t);
        assert_true(sums[t] == 0.0 || fabs(sums[t] - area) <= 0x1p-24 * area + 1e-12);
        assert_true(sums[t] > 0.0 || area < 1e-6);
    }
    free(sums);
}

/* The house's two meshes have layouts of their own; both overlap themselves somewhere. */
static void layouts_of_the_house_are_covered(void **state)
{
    enum { SIZE = 1024 };
    static const size_t islands[2] = {510, 647};
    (void)state;
    air_context *context = atlas_context(2);
    air_snapshot *snapshot = atlas_snapshot(context, files[0]);
    for (size_t m = 0; snapshot != NULL && m < snapshot->mesh_count; m++) {
        const air_mesh *mesh = snapshot->meshes[m];
        const air_atlas_part part = atlas_scene_part(mesh, 1, SIZE);
        air_coverage *coverage;
        air_coverage_report report;
        air_coverage_overlap overlap;
        assert_int_equal(air_coverage_create(context, SIZE, SIZE, &part, 1, &coverage, &report),
                         AIR_OK);
        assert_int_equal(air_coverage_find_overlap(context, coverage, &overlap), AIR_OK);
        (void)printf("%s: %zu triangles, %zu islands, %zu texels, %zu fragments; degenerate %zu, "
                     "outside %zu, overlaps in %zu texels, first (%u, %u), triangles %u and %u\n",
                     mesh->name, mesh->triangle_count, coverage->chart_count, report.covered_texels,
                     report.fragment_count, report.degenerate_count, report.outside_count,
                     overlap.texel_count, overlap.texel[0], overlap.texel[1], overlap.triangle[0],
                     overlap.triangle[1]);
        assert_int_equal(coverage->chart_count, islands[m]);
        assert_int_equal(report.outside_count, 0);
        assert_true(report.degenerate_count <= 1 && overlap.texel_count > 0);
        check_areas(coverage, &part);
        save_charts(context, m == 0 ? "house_own_0" : "house_own_1", coverage);
        air_coverage_destroy(context, coverage);
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- layouts made here ---- */

/* A mesh unwrapped, packed and covered. */
typedef struct baked {
    air_unwrap *unwrap;
    air_pack *pack;
    atlas_mesh mesh; /* with uv over the page */
    air_coverage *coverage;
    size_t width, height;
} baked;

/* The mesh's triangles with the places that the packer gave their charts. */
static void place_charts(baked *self, const air_mesh *mesh)
{
    const air_unwrap *unwrap = self->unwrap;
    const air_pack_page page = self->pack->pages[0];
    self->width = page.width;
    self->height = page.height;
    self->mesh = atlas_mesh_make(unwrap->vertex_count, unwrap->triangle_count);
    for (size_t i = 0; i < 3 * unwrap->triangle_count; i++) {
        const size_t v = unwrap->indices[i];
        const double place[2] = {(double)unwrap->places[2 * v], (double)unwrap->places[2 * v + 1]};
        double at[2];
        air_pack_point(self->pack, unwrap->triangle_charts[i / 3], place, at);
        self->mesh.indices[i] = (uint32_t)v;
        self->mesh.uv[2 * v] = (float)(at[0] / page.width);
        self->mesh.uv[2 * v + 1] = (float)(at[1] / page.height);
        memcpy(self->mesh.positions + 3 * v, mesh->positions + 3 * (size_t)unwrap->vertices[v],
               3 * sizeof(float));
    }
}

static air_atlas_part part_of(const baked *self)
{
    air_atlas_part part =
        atlas_part(&self->mesh, 0.0, 0.0, (double)self->width, (double)self->height);
    part.charts = self->unwrap->triangle_charts;
    return part;
}

/* Texels per metre so that the mesh has about as many texels. */
static double density_of(const air_mesh *mesh, double texels)
{
    double area = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double p[3][3], e[2][3];
        for (size_t i = 0; i < 9; i++) {
            const size_t v = mesh->indices[3 * t + i / 3];
            p[i / 3][i % 3] = (double)mesh->positions[3 * v + i % 3];
        }
        for (size_t k = 0; k < 3; k++) {
            e[0][k] = p[1][k] - p[0][k];
            e[1][k] = p[2][k] - p[0][k];
        }
        area += 0.5 * sqrt(pow(e[0][1] * e[1][2] - e[0][2] * e[1][1], 2.0) +
                           pow(e[0][2] * e[1][0] - e[0][0] * e[1][2], 2.0) +
                           pow(e[0][0] * e[1][1] - e[0][1] * e[1][0], 2.0));
    }
    return sqrt(texels / area);
}

/* Without snapping, which stretches what is thinner than a texel as far as it takes: projection
 * only shrinks, in one direction, by the cosine of an angle of at most 40 degrees where charts were
 * not joined, 65 where they were. Places are rounded to float. */
static air_unwrap_quality quality_of(air_context *context, const air_mesh *mesh, double density)
{
    air_unwrap_params params;
    air_unwrap *unwrap;
    air_unwrap_params_default(&params);
    params.texels_per_metre = density;
    params.snap = false;
    assert_int_equal(air_unwrap_create(context, mesh->positions, mesh->vertex_count, mesh->indices,
                                       mesh->triangle_count, &params, &unwrap),
                     AIR_OK);
    const air_unwrap_quality q = air_unwrap_measure(unwrap, mesh->positions, density);
    assert_true(q.mean_stretch <= 1.0 + 1e-4 && q.mean_stretch > cos(40.0 * 3.14159 / 180.0));
    air_unwrap_destroy(context, unwrap);
    return q;
}

static baked bake(air_context *context, const air_mesh *mesh, double texels)
{
    baked self = {.unwrap = NULL};
    air_unwrap_params params;
    air_pack_params packing;
    air_coverage_report report;
    air_coverage_overlap overlap;
    air_unwrap_params_default(&params);
    params.texels_per_metre = density_of(mesh, texels);
    double start = air_clock(context);
    assert_int_equal(air_unwrap_create(context, mesh->positions, mesh->vertex_count, mesh->indices,
                                       mesh->triangle_count, &params, &self.unwrap),
                     AIR_OK);
    const double taken = air_clock(context) - start;
    air_pack_item *items = atlas_zeros(self.unwrap->chart_count, sizeof *items);
    for (size_t i = 0; i < self.unwrap->chart_count; i++) {
        items[i].size[0] = self.unwrap->charts[i].texels[0];
        items[i].size[1] = self.unwrap->charts[i].texels[1];
    }
    air_pack_params_default(&packing);
    packing.power_of_two = false;
    start = air_clock(context);
    assert_int_equal(
        air_pack_create(context, items, self.unwrap->chart_count, &packing, &self.pack), AIR_OK);
    const double packed = air_clock(context) - start;
    assert_int_equal(self.pack->page_count, 1);
    place_charts(&self, mesh);
    const air_atlas_part part = part_of(&self);
    assert_int_equal(
        air_coverage_create(context, self.width, self.height, &part, 1, &self.coverage, &report),
        AIR_OK);
    assert_int_equal(air_coverage_find_overlap(context, self.coverage, &overlap), AIR_OK);
    const air_unwrap_quality q = quality_of(context, mesh, params.texels_per_metre);
    (void)printf("%s: %zu triangles, %zu charts, stretch %.3f to %.3f, mean %.3f; charts filled "
                 "%.2f, page %zu x %zu filled %.2f; unwrapped in %.3f s, packed in %.3f s\n",
                 mesh->name, mesh->triangle_count, self.unwrap->chart_count, q.least_stretch,
                 q.most_stretch, q.mean_stretch, q.utilisation, self.width, self.height,
                 self.pack->utilisation, taken, packed);
    assert_int_equal(report.outside_count, 0);
    assert_int_equal(overlap.texel_count, 0);
    free(items);
    return self;
}

static void finish_baked(air_context *context, baked *self)
{
    air_coverage_destroy(context, self->coverage);
    air_pack_destroy(context, self->pack);
    air_unwrap_destroy(context, self->unwrap);
    atlas_mesh_free(&self->mesh);
}

/* A smooth field in space: light that falls off, in metres of the mesh's own size. */
static float field_at(const float p[3], double scale)
{
    const double x = (double)p[0] / scale, y = (double)p[1] / scale, z = (double)p[2] / scale;
    return (float)(0.5 + 0.2 * sin(3.0 * x + y) + 0.2 * sin(2.0 * z - 4.0 * y));
}

/* The field at points drawn in each covered texel, with 10 % of noise. */
static void fill_field(const baked *self, double scale, float *plane)
{
    air_rng rng = air_rng_from_keys(1, 1);
    for (size_t i = 0; i < self->width * self->height; i++) {
        air_coverage_point at;
        const double u[2] = {0.5, 0.5};
        float p[3] = {0.0f, 0.0f, 0.0f};
        plane[i] = 0.0f;
        if (!air_coverage_draw(self->coverage, i % self->width, i / self->width, u, &at)) {
            continue;
        }
        for (size_t k = 0; k < 9; k++) {
            const size_t v = self->mesh.indices[3 * (size_t)at.triangle + k / 3];
            p[k % 3] += (float)(at.weights[k / 3] * (double)self->mesh.positions[3 * v + k % 3]);
        }
        plane[i] = field_at(p, scale) * (0.9f + 0.2f * air_rng_float(&rng));
    }
}

static void solve_seams(air_context *context, const baked *self, const char *name, double scale)
{
    const size_t count = self->width * self->height;
    const air_atlas_part part = part_of(self);
    uint32_t *charts = atlas_zeros(count, sizeof *charts);
    float *plane = atlas_zeros(count, sizeof *plane);
    float *const planes[1] = {plane};
    const air_seams_page page = {self->width, self->height, charts, planes};
    air_seams_find_params finding;
    air_seams_params params;
    air_dilate_params dilating;
    air_seams_report report;
    air_seams seams;
    fill_field(self, scale, plane);
    air_coverage_planes(context, self->coverage, charts, NULL);
    air_dilate_params_default(&dilating);
    assert_int_equal(air_dilate(context, self->width, self->height, charts, &dilating, planes, 1),
                     AIR_OK);
    air_seams_find_params_default(&finding);
    air_seams_params_default(&params);
    double start = air_clock(context);
    assert_int_equal(air_seams_find(context, &part, 1, NULL, NULL, &finding, &seams), AIR_OK);
    const double found = air_clock(context) - start;
    start = air_clock(context);
    assert_int_equal(air_seams_solve(context, &seams, &page, 1, 1, &params, &report), AIR_OK);
    (void)printf("%s: %zu seams, found in %.3f s; %zu samples, %zu texels, %u iterations, %.3f s; "
                 "difference in 1/255: rms %.2f then %.2f, most %.1f then %.1f\n",
                 name, seams.count, found, report.sample_count, report.texel_count,
                 report.iterations, air_clock(context) - start, 255.0 * report.rms_before,
                 255.0 * report.rms_after, 255.0 * report.most_before, 255.0 * report.most_after);
    assert_true(report.rms_after < 0.25 * report.rms_before || seams.count == 0);
    air_seams_finish(context, &seams);
    free(plane);
    free(charts);
}

/* Every mesh of both files with at least 300 triangles, at a quarter of a million texels. */
static void meshes_of_files_are_unwrapped(void **state)
{
    (void)state;
    air_context *context = atlas_context(2);
    for (size_t f = 0; f < 2; f++) {
        air_snapshot *snapshot = atlas_snapshot(context, files[f]);
        const double scale =
            snapshot == NULL ? 1.0 : (double)(snapshot->bounds_max[0] - snapshot->bounds_min[0]);
        size_t done = 0;
        for (size_t m = 0; snapshot != NULL && m < snapshot->mesh_count && done < 12; m++) {
            char name[64];
            if (snapshot->meshes[m]->triangle_count < 300) {
                continue;
            }
            baked self = bake(context, snapshot->meshes[m], 250000.0);
            (void)snprintf(name, sizeof name, "%s_%zu", f == 0 ? "house" : "classroom", m);
            save_charts(context, name, self.coverage);
            solve_seams(context, &self, name, scale);
            finish_baked(context, &self);
            done++;
        }
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layouts_of_the_house_are_covered),
        cmocka_unit_test(meshes_of_files_are_unwrapped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

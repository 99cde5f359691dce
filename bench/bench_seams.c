/* bench_seams.c: the step that a picture shows where a lightmap's charts meet.
 *
 *     bench_seams [SCENE] [--mesh-size N] [--texels D] [--spp N] [--threads N]
 *
 * Default: house.glb of the shared scenes, 512 texels along each mesh's own square, 400 texels per
 * metre where it is unwrapped, 64 samples, one thread; without that file it says so and ends. A sun
 * and an even sky light it (those of the anchor in docs/baking.md), and no fog.
 *
 * For sides that are one in space and two on the page, both are looked up bilinearly every quarter
 * of a texel and go through exposure (automatic, of the page), view transform and sRGB curve, as
 * `airlight convert PAGE.exr PAGE.png` does; the step is the largest difference of a channel, in
 * 1/255. Two sets of sides: those of triangles whose own normals are within 20 degrees, which is
 * what the baker makes agree, and those whose vertex normals are, at both ends, which is what is
 * shaded smoothly; of these the ones that are not in the first set. Charts are apart where the four
 * texels of the look-up have triangles of one chart only. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "airlight/airlight.h"
#include "atlas/seams.h"
#include "bake/layout.h"
#include "image/srgb.h"

enum { MOST_PARTS = 256, STEPS_PER_TEXEL = 4 };

typedef struct bench_options {
    const char *scene;
    uint32_t mesh_size, spp;
    float texels_per_metre;
    size_t threads;
} bench_options;

/* All parts of a layout in a row, as air_seams_find takes them. */
typedef struct all_parts {
    air_atlas_part parts[MOST_PARTS];
    uint32_t pages[MOST_PARTS];
    float *normals[MOST_PARTS]; /* of each part's vertices; NULL: the mesh has none */
    size_t count;
} all_parts;

typedef struct distribution {
    double *steps;
    size_t count, capacity;
} distribution;

/* ---- scene ---- */

static air_status add_lights(air_scene *scene)
{
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_COLLIMATED;
    for (int c = 0; c < 3; c++) {
        static const float dir[3] = {-0.35355f, -0.70711f, -0.61237f};
        light.color[c] = 3.0f;
        light.dir[c] = dir[c];
    }
    const air_status status = air_scene_add_light(scene, &light, &handle);
    if (status != AIR_OK) {
        return status;
    }
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    for (int c = 0; c < 3; c++) {
        light.color[c] = 0.5f;
    }
    return air_scene_add_light(scene, &light, &handle);
}

static air_status load(air_context *context, const char *path, air_snapshot **out)
{
    air_load_params params;
    air_scene *scene = NULL;
    air_load_params_default(&params);
    *out = NULL;
    air_status status = air_scene_load(context, path, &params, &scene);
    status = status == AIR_OK ? add_lights(scene) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

/* ---- sides ---- */

/* Normals of a part's vertices; owned where the mesh was cut. */
static float *part_normals(const air_mesh *mesh, const air_lightmap_mesh *cut)
{
    if (mesh->normals == NULL) {
        return NULL;
    }
    const size_t count = cut->sources != NULL ? cut->vertex_count : mesh->vertex_count;
    float *out = malloc(3 * count * sizeof *out);
    for (size_t i = 0; out != NULL && i < count; i++) {
        const size_t v = cut->sources != NULL ? cut->sources[i] : i;
        memcpy(out + 3 * i, mesh->normals + 3 * v, 3 * sizeof *out);
    }
    return out;
}

static bool gather(const air_snapshot *snapshot, const air_bake_layout *layout, all_parts *out)
{
    out->count = 0;
    for (size_t p = 0; p < layout->page_count; p++) {
        const air_bake_page *page = &layout->pages[p];
        for (size_t i = 0; i < page->part_count; i++) {
            if (out->count == MOST_PARTS) {
                fprintf(stderr, "bench_seams: more than %d meshes\n", MOST_PARTS);
                return false;
            }
            const uint32_t mesh = page->part_meshes[i];
            out->parts[out->count] = page->parts[i];
            out->pages[out->count] = (uint32_t)p;
            out->normals[out->count++] =
                part_normals(snapshot->meshes[mesh], &layout->meshes[mesh]);
        }
    }
    return true;
}

static void free_normals(all_parts *all)
{
    for (size_t i = 0; i < all->count; i++) {
        free(all->normals[i]);
    }
    all->count = 0;
}

/* ---- what is seen ---- */

/* The colour of a place, from black to white in [0, 1], encoded as a screen takes it. */
static void look_up(const air_image *page, const float at[2], float exposure_ev, float out[3])
{
    static const char *const names[3] = {"R", "G", "B"};
    const size_t size[2] = {air_image_width(page), air_image_height(page)};
    size_t texel[2][2];
    float share[2], light[3];
    for (int k = 0; k < 2; k++) {
        const float x = fminf(fmaxf(at[k] - 0.5f, 0.0f), (float)(size[k] - 1));
        texel[k][0] = (size_t)x;
        texel[k][1] = texel[k][0] + 1 < size[k] ? texel[k][0] + 1 : texel[k][0];
        share[k] = x - (float)texel[k][0];
    }
    for (int c = 0; c < 3; c++) {
        const ptrdiff_t channel = air_image_find_channel(page, names[c]);
        const float *plane = air_image_plane_const(page, (size_t)channel);
        float row[2];
        for (int y = 0; y < 2; y++) {
            const float *from = plane + texel[1][y] * size[0];
            row[y] = from[texel[0][0]] + share[0] * (from[texel[0][1]] - from[texel[0][0]]);
        }
        light[c] = row[0] + share[1] * (row[1] - row[0]);
    }
    air_view_apply(AIR_VIEW_NEUTRAL, exposure_ev, light, out);
    for (int c = 0; c < 3; c++) {
        out[c] = srgb_encode(out[c]);
    }
}

/* Do all four texels of a look-up belong to one chart, or to none? */
static bool reads_one_chart(const air_coverage *coverage, const float at[2])
{
    const size_t size[2] = {coverage->width, coverage->height};
    uint32_t chart = AIR_NO_CHART;
    for (int i = 0; i < 4; i++) {
        size_t texel[2], count;
        for (int k = 0; k < 2; k++) {
            const float x = floorf(at[k] - 0.5f) + (float)(k == 0 ? i % 2 : i / 2);
            texel[k] = (size_t)fminf(fmaxf(x, 0.0f), (float)(size[k] - 1));
        }
        const air_fragment *fragments = air_coverage_texel(coverage, texel[0], texel[1], &count);
        for (size_t f = 0; f < count; f++) {
            const uint32_t other = coverage->charts[air_fragment_triangle(fragments[f])];
            if (chart != AIR_NO_CHART && other != chart) {
                return false;
            }
            chart = other;
        }
    }
    return true;
}

static bool add_step(distribution *d, double step)
{
    if (d->count == d->capacity) {
        const size_t capacity = 2 * d->capacity + 4096;
        double *grown = realloc(d->steps, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        d->steps = grown;
        d->capacity = capacity;
    }
    d->steps[d->count++] = step;
    return true;
}

/* layout: only places whose look-ups read one chart on each side; NULL: all. */
static bool add_seam(distribution *d, const air_lightmap *lightmap, const air_seam *seam,
                     const air_bake_layout *layout, float exposure_ev)
{
    double longer = 0.0;
    for (int side = 0; side < 2; side++) {
        const float(*p)[2] = seam->place[side];
        longer = fmax(longer, hypot((double)(p[1][0] - p[0][0]), (double)(p[1][1] - p[0][1])));
    }
    const size_t count = (size_t)ceil(STEPS_PER_TEXEL * longer) + 1;
    for (size_t i = 0; i < count; i++) {
        const float share = ((float)i + 0.5f) / (float)count;
        float seen[2][3], step = 0.0f;
        bool wanted = true;
        for (int side = 0; side < 2; side++) {
            const uint32_t page = seam->page[side];
            float at[2];
            for (int k = 0; k < 2; k++) {
                const float a = seam->place[side][0][k], b = seam->place[side][1][k];
                at[k] = a + share * (b - a);
            }
            look_up(lightmap->pages[page], at, exposure_ev, seen[side]);
            wanted =
                wanted && (layout == NULL || reads_one_chart(layout->pages[page].coverage, at));
        }
        for (int c = 0; c < 3; c++) {
            step = fmaxf(step, fabsf(seen[0][c] - seen[1][c]));
        }
        if (wanted && !add_step(d, 255.0 * (double)step)) {
            return false;
        }
    }
    return true;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_steps(const char *title, distribution *d, size_t seams)
{
    size_t above = 0;
    qsort(d->steps, d->count, sizeof *d->steps, by_size);
    for (size_t i = 0; i < d->count; i++) {
        above += d->steps[i] > 1.0;
    }
    const double last = (double)(d->count - 1);
    printf("  %-34s %6zu sides, %7zu places: median %6.3f, 90 %% %6.3f, 99 %% %7.3f, 99.9 %% "
           "%7.3f, most %7.3f; above 1: %.3f %%\n",
           title, seams, d->count, d->steps[(size_t)(0.5 * last)], d->steps[(size_t)(0.9 * last)],
           d->steps[(size_t)(0.99 * last)], d->steps[(size_t)(0.999 * last)],
           d->steps[(size_t)last], 100.0 * (double)above / (double)d->count);
    fflush(stdout);
}

/* ---- runs ---- */

static bool has_side(const air_seams *seams, const air_seam *wanted)
{
    for (size_t i = 0; i < seams->count; i++) {
        const uint32_t *a = seams->seams[i].triangle, *b = wanted->triangle;
        if ((a[0] == b[0] && a[1] == b[1]) || (a[0] == b[1] && a[1] == b[0])) {
            return true;
        }
    }
    return false;
}

static air_status measure(const air_lightmap *lightmap, const air_seams *seams,
                          const air_seams *without, const air_bake_layout *layout,
                          float exposure_ev, const char *title)
{
    distribution d = {NULL, 0, 0};
    size_t count = 0;
    bool good = true;
    for (size_t i = 0; i < seams->count && good; i++) {
        if (without == NULL || !has_side(without, &seams->seams[i])) {
            good = add_seam(&d, lightmap, &seams->seams[i], layout, exposure_ev);
            count++;
        }
    }
    if (good && d.count > 0) {
        print_steps(title, &d, count);
    } else if (good) {
        printf("  %-34s none\n", title);
    }
    free(d.steps);
    return good ? AIR_OK : AIR_ERROR_MEMORY;
}

/* How far stitching moved the texels that it changed, and how many went below 0. */
static air_status measure_changes(const air_lightmap *before, const air_lightmap *after,
                                  float exposure_ev)
{
    distribution d = {NULL, 0, 0};
    size_t below = 0;
    bool good = true;
    for (size_t p = 0; p < before->page_count; p++) {
        const air_image *pages[2] = {before->pages[p], after->pages[p]};
        const size_t width = air_image_width(pages[0]), height = air_image_height(pages[0]);
        const ptrdiff_t coverage = air_image_find_channel(pages[0], "coverage.Y");
        const ptrdiff_t green = air_image_find_channel(pages[0], "G");
        const float *covered = air_image_plane_const(pages[0], (size_t)coverage);
        const float *light[2] = {air_image_plane_const(pages[0], (size_t)green),
                                 air_image_plane_const(pages[1], (size_t)green)};
        for (size_t i = 0; i < width * height && good; i++) {
            const float at[2] = {(float)(i % width) + 0.5f, (float)(i / width) + 0.5f};
            float seen[2][3], change = 0.0f;
            if (covered[i] == 0.0f || light[0][i] == light[1][i]) {
                continue;
            }
            look_up(pages[0], at, exposure_ev, seen[0]);
            look_up(pages[1], at, exposure_ev, seen[1]);
            for (int c = 0; c < 3; c++) {
                change = fmaxf(change, fabsf(seen[1][c] - seen[0][c]));
            }
            below += light[1][i] < 0.0f;
            good = add_step(&d, 255.0 * (double)change);
        }
    }
    if (good && d.count > 0) {
        print_steps("change of covered texels", &d, 0);
        printf("  of them below 0: %zu\n", below);
    }
    free(d.steps);
    return good ? AIR_OK : AIR_ERROR_MEMORY;
}

static air_status run_stitch(air_context *context, const air_snapshot *snapshot,
                             const air_bake_layout *layout, air_bake_params *params,
                             const air_seams *known, const air_seams *smooth)
{
    air_lightmap *lightmaps[2] = {NULL, NULL};
    air_status status = AIR_OK;
    for (int stitch = 0; stitch < 2 && status == AIR_OK; stitch++) {
        params->stitch = stitch == 1;
        status = air_bake(context, snapshot, params, &lightmaps[stitch], NULL);
        if (status != AIR_OK) {
            break;
        }
        const float exposure_ev = air_image_auto_exposure(lightmaps[0]->pages[0]);
        printf(" %s\n", stitch ? "stitched" : "not stitched");
        status = measure(lightmaps[stitch], known, NULL, NULL, exposure_ev, "triangles within 20");
        if (status == AIR_OK) {
            status = measure(lightmaps[stitch], known, NULL, layout, exposure_ev,
                             "of these, where charts are apart");
        }
        if (status == AIR_OK) {
            status = measure(lightmaps[stitch], smooth, known, NULL, exposure_ev,
                             "others, vertex normals within 20");
        }
        if (status == AIR_OK && stitch) {
            status = measure_changes(lightmaps[0], lightmaps[1], exposure_ev);
        }
    }
    air_lightmap_destroy(lightmaps[0]);
    air_lightmap_destroy(lightmaps[1]);
    return status;
}

static air_status run(air_context *context, const air_snapshot *snapshot,
                      const bench_options *options, air_bake_uv uv)
{
    static all_parts all;
    air_bake_params params;
    air_seams_find_params find;
    air_bake_layout *layout = NULL;
    air_seams known = {NULL, 0}, smooth = {NULL, 0};
    air_bake_params_default(&params);
    params.samples = options->spp;
    params.uv = uv;
    params.mesh_size = uv == AIR_BAKE_UV_AUTO ? options->mesh_size : 0;
    params.texels_per_metre = options->texels_per_metre;
    params.media = AIR_BAKE_NONE;
    air_seams_find_params_default(&find);
    air_status status = air_bake_layout_create(context, snapshot, &params, &layout);
    if (status == AIR_OK && !gather(snapshot, layout, &all)) {
        status = AIR_ERROR_ARGUMENT;
    }
    if (status == AIR_OK) {
        status = air_seams_find(context, all.parts, all.count, NULL, all.pages, &find, &known);
    }
    if (status == AIR_OK) {
        status = air_seams_find(context, all.parts, all.count, (const float *const *)all.normals,
                                all.pages, &find, &smooth);
    }
    if (status == AIR_OK) {
        printf("%s: %zu pages, the first of %u x %u\n",
               uv == AIR_BAKE_UV_AUTO ? "own coordinates" : "unwrapped", layout->page_count,
               layout->pages[0].width, layout->pages[0].height);
        status = run_stitch(context, snapshot, layout, &params, &known, &smooth);
    }
    air_seams_finish(context, &known);
    air_seams_finish(context, &smooth);
    free_normals(&all);
    air_bake_layout_destroy(layout);
    return status;
}

static bench_options read_options(int argc, char **argv)
{
    bench_options o = {AIR_SHARED_DIR "/scenes/gltf_playcanvas/house.glb", 512, 64, 400.0f, 1};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "0";
        if (argv[i][0] != '-') {
            o.scene = argv[i];
            continue;
        }
        i++;
        if (strcmp(argv[i - 1], "--mesh-size") == 0) {
            o.mesh_size = (uint32_t)strtoul(value, NULL, 10);
        } else if (strcmp(argv[i - 1], "--spp") == 0) {
            o.spp = (uint32_t)strtoul(value, NULL, 10);
        } else if (strcmp(argv[i - 1], "--texels") == 0) {
            o.texels_per_metre = strtof(value, NULL);
        } else if (strcmp(argv[i - 1], "--threads") == 0) {
            o.threads = strtoul(value, NULL, 10);
        }
    }
    return o;
}

int main(int argc, char **argv)
{
    const bench_options options = read_options(argc, argv);
    air_context_params params;
    air_context *context = NULL;
    air_snapshot *snapshot = NULL;
    if (access(options.scene, R_OK) != 0) {
        printf("bench_seams skipped: no %s\n", options.scene);
        return EXIT_SUCCESS;
    }
    air_context_params_default(&params);
    params.thread_count = options.threads;
    if (air_context_create(&params, &context) != AIR_OK) {
        return EXIT_FAILURE;
    }
    air_status status = load(context, options.scene, &snapshot);
    status = status == AIR_OK ? run(context, snapshot, &options, AIR_BAKE_UV_AUTO) : status;
    status = status == AIR_OK ? run(context, snapshot, &options, AIR_BAKE_UV_UNWRAP) : status;
    if (status != AIR_OK) {
        fprintf(stderr, "bench_seams: %s\n", air_context_last_error(context));
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
    return status == AIR_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* bake.c: one bake from beginning to end. */
#include "airlight/bake.h"

#include <string.h>

#include "bake/cache.h"
#include "bake/cache_grid.h"
#include "bake/finish.h"
#include "bake/first_light.h"
#include "bake/layout.h"
#include "bake/probes.h"
#include "bake/progress.h"
#include "bake/respond.h"
#include "bake/texels.h"
#include "bake/vertices.h"
#include "scene/fingerprint.h"

const char *air_bake_media_name(air_bake_media media)
{
    static const char *const names[AIR_BAKE_MEDIA_COUNT] = {"none", "attenuate", "impulse", "exact",
                                                            "reference"};
    return (unsigned)media < AIR_BAKE_MEDIA_COUNT ? names[media] : "";
}

void air_bake_params_default(air_bake_params *params)
{
    *params = (air_bake_params){.samples = 256,
                                .max_bounces = UINT32_MAX,
                                .media = AIR_BAKE_EXACT,
                                .final_gather = true,
                                .impulse_bounces = 10,
                                .lightmaps = true,
                                .texels_per_metre = 16.0f,
                                .page_size = 2048,
                                .padding = 4,
                                .chart_angle_rad = 40.0f * AIR_PI_F / 180.0f,
                                .denoise = true,
                                .stitch = true,
                                .dilate = 8,
                                .resume = true};
}

/* All that one bake knows. */
typedef struct baking {
    air_context *context;
    const air_snapshot *snapshot;
    const air_bake_params *params;
    air_bake_progress *progress;
    air_bake_layout *layout;
    air_texel_sites *texels;     /* one per page */
    air_finished_page *finished; /* likewise */
    air_light_cache *cache;
    air_responder *responder;
    air_first_light *first;
    air_sobol *sobol;
    air_path path;
    bool path_made;
    uint32_t seed;
    double work, done; /* samples: of the whole bake, of what is done */
    air_lightmap *lightmap;
    air_bake_report report;
} baking;

/* ---- checks ---- */

static air_status check_range(air_context *context, const char *name, double value, double least,
                              double most)
{
    if (value >= least && value <= most) {
        return AIR_OK;
    }
    return air_fail(context, AIR_ERROR_ARGUMENT, "bake: %s is %g, expected %g to %g", name, value,
                    least, most);
}

static air_status check_params(air_context *context, const air_bake_params *p)
{
    const struct {
        const char *name;
        double value, least, most;
    } ranges[] = {
        {"samples", p->samples, 1, 65536},
        {"media", p->media, 0, AIR_BAKE_MEDIA_COUNT - 1},
        {"cache_resolution", p->cache_resolution == 0 ? 2 : p->cache_resolution, 2, 128},
        {"cache_samples", p->cache_samples == 0 ? 16 : p->cache_samples, 16, 65536},
        {"impulse_bounces", p->impulse_bounces, 1, AIR_IMPULSE_BOUNCES_MAX},
        {"uv", p->uv, 0, AIR_BAKE_UV_UNWRAP},
        {"texels_per_metre", (double)p->texels_per_metre, 1e-6, 1e6},
        {"page_size", p->page_size, 16, 16384},
        {"mesh_size", p->mesh_size == 0 ? 4 : p->mesh_size, 4, p->page_size},
        {"padding", p->padding, 0, p->page_size > 130 ? 64 : p->page_size / 2 - 1},
        {"chart_angle_rad", (double)p->chart_angle_rad, 0.01, 80.0 * AIR_PI / 180.0},
    };
    air_status status = AIR_OK;
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0] && status == AIR_OK; i++) {
        status =
            check_range(context, ranges[i].name, ranges[i].value, ranges[i].least, ranges[i].most);
    }
    if (status == AIR_OK && !p->lightmaps && !p->vertices && p->probe_count == 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "bake: nothing is asked for: no lightmaps, vertices or probes");
    }
    return status;
}

/* ---- what is the same for all sites ---- */

static uint32_t max_depth(const air_bake_params *params)
{
    return params->max_bounces == UINT32_MAX ? UINT32_MAX : params->max_bounces + 1;
}

/* All that the sites' light depends on. Threads and what is made of the light are not in it. */
static uint64_t fingerprint(const air_snapshot *snapshot, const air_bake_params *p)
{
    const uint32_t numbers[] = {p->samples,
                                p->max_bounces,
                                (uint32_t)p->media,
                                p->final_gather,
                                p->cache_resolution,
                                p->cache_samples,
                                p->impulse_literal,
                                p->impulse_tables != NULL,
                                (uint32_t)p->impulse_bounces,
                                p->lightmaps,
                                (uint32_t)p->uv,
                                p->mesh_size,
                                p->page_size,
                                p->padding,
                                p->directional,
                                p->vertices};
    const float reals[] = {p->texels_per_metre, p->chart_angle_rad};
    uint64_t hash = air_fingerprint_snapshot(snapshot);
    hash = air_fingerprint_add(hash, &p->seed, sizeof p->seed);
    hash = air_fingerprint_add(hash, numbers, sizeof numbers);
    hash = air_fingerprint_add(hash, reals, sizeof reals);
    for (size_t i = 0; i < p->probe_count; i++) {
        const air_probe_request *request = &p->probes[i];
        const uint64_t counts[] = {request->kind, request->count, request->size[0],
                                   request->size[1], request->size[2]};
        hash = air_fingerprint_add(hash, counts, sizeof counts);
        hash = air_fingerprint_add(hash, request->origin, sizeof request->origin);
        hash = air_fingerprint_add(hash, request->step, sizeof request->step);
        hash = air_fingerprint_add(hash, &request->spacing, sizeof request->spacing);
        if (request->kind == AIR_PROBES_FREE && request->count > 0) {
            hash =
                air_fingerprint_add(hash, request->positions, request->count * 3 * sizeof(float));
        }
    }
    return hash;
}

/* Cached light gets a fortieth of the bake's samples, within what makes sense. Many points with
 * few samples: a place is lit by all points around it, so noise depends on the samples of all
 * together, and what cells are too large for on their number. */
static air_light_cache_params cache_params(const baking *b)
{
    enum { LEAST_POINTS = 8192 };
    const double budget = b->work / 40.0;
    const double points = double_max(budget / AIR_CACHE_SAMPLES_LEAST, LEAST_POINTS);
    const uint32_t asked = b->params->cache_resolution;
    const uint32_t resolution = asked > 0 ? asked : air_cache_resolution(b->snapshot, points);
    /* a point's own event is one of those that the bake allows */
    return (air_light_cache_params){.resolution = resolution,
                                    .samples = b->params->cache_samples,
                                    .budget = budget,
                                    .max_depth = b->params->max_bounces,
                                    .seed = b->seed};
}

static air_status make_cache(baking *b)
{
    if (b->params->media != AIR_BAKE_EXACT || b->snapshot->media.count == 0 ||
        b->params->max_bounces < 2) { /* one event is asked for without a cache */
        return AIR_OK;
    }
    const double start = air_clock(b->context);
    const air_light_cache_params params = cache_params(b);
    const double points = air_cache_scene_points(b->snapshot, params.resolution);
    const double each = double_max((double)params.samples, AIR_CACHE_SAMPLES_LEAST);
    const double work = double_max(params.budget, each * points);
    b->work += work;
    b->done = work;
    const air_status status = air_light_cache_create(b->context, b->snapshot, b->sobol, &params,
                                                     b->progress, work / b->work, &b->cache);
    if (status == AIR_OK) {
        b->report.cache_bytes = air_light_cache_bytes(b->cache);
    }
    b->report.cache_s = air_clock(b->context) - start;
    return status;
}

static air_status make_responder(baking *b)
{
    const double start = air_clock(b->context);
    const air_responder_params params = {b->params->impulse_literal, b->params->impulse_bounces,
                                         b->params->impulse_tables};
    if (b->params->media != AIR_BAKE_IMPULSE || b->snapshot->media.count == 0) {
        return AIR_OK;
    }
    const air_status status = air_responder_create(b->context, b->snapshot, &params, &b->responder);
    b->report.cache_s = air_clock(b->context) - start;
    return status;
}

/* A path of the bake, with a limit on events of its own. */
static air_status make_path(baking *b, uint32_t depth, air_path *out)
{
    static const air_path_media modes[AIR_BAKE_MEDIA_COUNT] = {
        AIR_PATH_IGNORE, AIR_PATH_ATTENUATE, AIR_PATH_ATTENUATE, AIR_PATH_GATHER, AIR_PATH_SCATTER};
    air_path_settings settings = {
        .max_depth = depth, .terms = AIR_TERMS_ALL, .media = modes[b->params->media]};
    if (b->responder != NULL) {
        settings.respond = air_responder_hooks(b->responder);
    }
    if (b->params->media == AIR_BAKE_EXACT) {
        settings.source =
            (air_path_source){b->cache != NULL ? air_light_cache_scattered : NULL, b->cache, true};
    }
    if (b->first != NULL) {
        settings.arrived = (air_path_arrived){air_first_light_irradiance, b->first};
    }
    return air_path_init(out, b->snapshot, b->sobol, &settings);
}

/* Runs one list as its share of the whole. */
static air_status run(baking *b, const air_path *path, air_site_list *list, uint32_t samples,
                      uint32_t purpose)
{
    const double begin = b->done / b->work;
    list->seed = air_hash_combine(b->seed, purpose);
    list->samples = samples;
    list->through = (list->samples + 1) / 2;
    b->done += (double)list->count * list->samples;
    return air_sites_run(path, list, b->progress, begin, b->done / b->work);
}

/* ---- final gathering ---- */

/* Samples of the first pass for each texel. Their noise is shared out among all texels that see it
 * and does not show in theirs, but in the mean over few texels; so bakes of few get more. */
static uint32_t first_samples(const baking *b)
{
    enum { SHARE = 32, LEAST = 65536 };
    const air_bake_params *params = b->params;
    if (!params->final_gather || !params->lightmaps || params->media == AIR_BAKE_REFERENCE ||
        params->max_bounces == 0 || b->report.texels == 0) {
        return 0;
    }
    const double least = double_max(ceil(LEAST / (double)b->report.texels), 1.0);
    const double most = double_max(0.5 * (double)params->samples, 1.0);
    return (uint32_t)double_min(double_max((double)(params->samples / SHARE), least), most);
}

static air_status take_first_page(baking *b, const air_path *path, air_first_light *light,
                                  size_t page, bool back)
{
    air_texel_sites sites = b->texels[page];
    sites.back = back;
    air_site_list list = {
        .what = "first pass", .count = sites.count, .draw = air_texel_draw, .user = &sites};
    air_status status =
        run(b, path, &list, first_samples(b), (back ? 0x50000u : 0x40000u) + (uint32_t)page);
    if (status == AIR_OK) {
        status = air_first_light_take(light, page, &sites, &list);
    }
    air_free(b->context, list.records);
    return status;
}

/* Light of all texels by one event less than the bake allows: the last one is the surface's that
 * looks it up. */
static air_status make_first_light(baking *b)
{
    const uint32_t depth = max_depth(b->params);
    const double start = air_clock(b->context);
    air_first_light *light = NULL;
    air_path path;
    if (first_samples(b) == 0) {
        return AIR_OK;
    }
    air_status status = make_path(b, depth == UINT32_MAX ? depth : depth - 1, &path);
    if (status != AIR_OK) {
        return status;
    }
    status = air_first_light_create(b->context, b->layout, &light);
    for (size_t p = 0; p < b->layout->page_count && status == AIR_OK; p++) {
        status = take_first_page(b, &path, light, p, false);
        if (status == AIR_OK && air_first_light_has_backs(light, p)) {
            status = take_first_page(b, &path, light, p, true);
        }
    }
    air_path_finish(&path);
    b->first = light;
    b->report.first_s = air_clock(b->context) - start;
    return status;
}

/* ---- targets ---- */

static air_status make_texels(baking *b)
{
    const size_t pages = b->layout->page_count;
    b->texels = air_allocate(b->context, pages, sizeof *b->texels);
    air_status status = b->texels == NULL ? air_fail_memory(b->context, "texels") : AIR_OK;
    for (size_t p = 0; p < pages && status == AIR_OK; p++) {
        status = air_texel_sites_init(b->context, b->snapshot, &b->layout->pages[p], &b->texels[p]);
        if (status == AIR_OK) {
            b->texels[p].uniform = b->params->directional ? 0.5f : 0.0f;
            b->report.texels += b->texels[p].count;
        }
    }
    b->work += (double)b->report.texels * (double)(b->params->samples + first_samples(b));
    return status;
}

static air_status bake_page(baking *b, size_t page)
{
    air_site_list list = {.what = "texels",
                          .count = b->texels[page].count,
                          .draw = air_texel_draw,
                          .user = &b->texels[page],
                          .coefficients =
                              b->params->directional ? AIR_DIRECTIONAL_COEFFICIENTS : 0};
    double start = air_clock(b->context);
    air_status status = run(b, &b->path, &list, b->params->samples, 0x10000u + (uint32_t)page);
    b->report.sample_s += air_clock(b->context) - start;
    b->report.page_bytes += list.count * air_site_stride(&list) * sizeof(float);
    start = air_clock(b->context);
    if (status == AIR_OK) {
        status =
            air_finish_page(b->context, b->params, &b->texels[page], &list, &b->finished[page]);
    }
    b->report.finish_s += air_clock(b->context) - start;
    b->report.invalid_texels += b->finished[page].invalid;
    air_free(b->context, list.records);
    return status;
}

static air_status bake_pages(baking *b)
{
    air_lightmap *lightmap = b->lightmap;
    lightmap->directional = b->params->directional;
    lightmap->pages = air_allocate(b->context, b->layout->page_count, sizeof *lightmap->pages);
    b->finished = air_allocate(b->context, b->layout->page_count, sizeof *b->finished);
    air_status status = lightmap->pages == NULL || b->finished == NULL
                            ? air_fail_memory(b->context, "pages")
                            : AIR_OK;
    for (size_t p = 0; p < b->layout->page_count && status == AIR_OK; p++) {
        status = bake_page(b, p);
    }
    if (status == AIR_OK && b->params->stitch) {
        const double start = air_clock(b->context);
        status = air_finish_seams(b->context, b->layout, b->finished);
        b->report.finish_s += air_clock(b->context) - start;
    }
    for (size_t p = 0; p < b->layout->page_count && status == AIR_OK; p++) {
        lightmap->pages[lightmap->page_count++] = b->finished[p].image;
        b->finished[p].image = NULL;
    }
    if (status == AIR_OK) {
        /* the meshes' places are the lightmap's from here on */
        lightmap->meshes = b->layout->meshes;
        lightmap->mesh_count = b->layout->mesh_count;
        b->layout->meshes = NULL;
    }
    return status;
}

/* What of a vertex' records is its layers' light, in order of vertices. */
static air_status take_vertices(baking *b, const air_vertex_sites *sites, const air_site_list *list,
                                air_vertex_light *out)
{
    const size_t stride = air_site_stride(list);
    uint8_t *valid = air_allocate(b->context, list->count, 1);
    air_status status = valid == NULL ? air_fail_memory(b->context, out->name) : AIR_OK;
    for (size_t i = 0; i < list->count && status == AIR_OK; i++) {
        valid[i] = list->records[i * stride + AIR_SITE_VALIDITY] >= AIR_SITE_VALID_SHARE;
    }
    for (size_t layer = 0; layer < AIR_LAYER_COUNT && status == AIR_OK; layer++) {
        float *light = air_allocate(b->context, list->count, 3 * sizeof *light);
        out->layers[layer] = light;
        if (light == NULL) {
            status = air_fail_memory(b->context, out->name);
            break;
        }
        for (size_t i = 0; i < list->count; i++) {
            memcpy(light + 3 * i, list->records + i * stride + AIR_SITE_LIGHT + 3 * layer,
                   3 * sizeof *light);
        }
        status = air_vertex_fill(b->context, sites, valid, light);
        if (status == AIR_OK) {
            status = air_vertex_solve(b->context, sites, light);
        }
    }
    air_free(b->context, valid);
    return status;
}

static air_status bake_mesh_vertices(baking *b, size_t index)
{
    const air_mesh *mesh = b->snapshot->meshes[index];
    air_vertex_light *out = &b->lightmap->vertex_lights[index];
    air_vertex_sites sites;
    out->mesh = (uint32_t)index;
    out->node = mesh->node;
    out->primitive = mesh->primitive;
    out->vertex_count = mesh->vertex_count;
    out->name = air_string_copy(b->context, mesh->name);
    b->lightmap->vertex_light_count++;
    air_status status = out->name == NULL ? air_fail_memory(b->context, mesh->name)
                                          : air_vertex_sites_init(b->context, mesh, &sites);
    if (status != AIR_OK) {
        return status;
    }
    air_site_list list = {
        .what = "vertices", .count = mesh->vertex_count, .draw = air_vertex_draw, .user = &sites};
    const double start = air_clock(b->context);
    status = run(b, &b->path, &list, b->params->samples, 0x20000u + (uint32_t)index);
    b->report.sample_s += air_clock(b->context) - start;
    if (status == AIR_OK) {
        status = take_vertices(b, &sites, &list, out);
    }
    air_free(b->context, list.records);
    air_vertex_sites_finish(b->context, &sites);
    return status;
}

static air_status bake_vertices(baking *b)
{
    const size_t count = b->snapshot->mesh_count;
    b->lightmap->vertex_lights =
        air_allocate(b->context, count, sizeof *b->lightmap->vertex_lights);
    air_status status =
        b->lightmap->vertex_lights == NULL ? air_fail_memory(b->context, "vertices") : AIR_OK;
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        status = bake_mesh_vertices(b, i);
    }
    return status;
}

static air_status place_probes(baking *b)
{
    air_lightmap *lightmap = b->lightmap;
    const size_t count = b->params->probe_count;
    lightmap->probe_sets = air_allocate(b->context, count, sizeof *lightmap->probe_sets);
    air_status status =
        lightmap->probe_sets == NULL ? air_fail_memory(b->context, "probes") : AIR_OK;
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        lightmap->probe_set_count++;
        status = air_probes_place(b->context, b->snapshot, &b->params->probes[i],
                                  &lightmap->probe_sets[i]);
        b->work += (double)lightmap->probe_sets[i].count * b->params->samples;
        b->report.probes += lightmap->probe_sets[i].count;
    }
    return status;
}

static air_status bake_probes(baking *b)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < b->lightmap->probe_set_count && status == AIR_OK; i++) {
        air_probe_set *set = &b->lightmap->probe_sets[i];
        air_site_list list = {.what = "probes",
                              .count = set->count,
                              .draw = air_probe_draw,
                              .user = set,
                              .coefficients = AIR_PROBE_COEFFICIENTS,
                              .apart = true};
        const double start = air_clock(b->context);
        status = run(b, &b->path, &list, b->params->samples, 0x30000u + (uint32_t)i);
        if (status == AIR_OK) {
            air_probes_take(&list, set);
        }
        b->report.sample_s += air_clock(b->context) - start;
        air_free(b->context, list.records);
    }
    return status;
}

/* ---- the whole ---- */

static air_status prepare(baking *b)
{
    air_lightmap *lightmap = b->lightmap;
    const double start = air_clock(b->context);
    air_status status = AIR_OK;
    air_free(b->context, lightmap->media);
    air_free(b->context, lightmap->scene);
    lightmap->media = air_string_copy(b->context, air_bake_media_name(b->params->media));
    lightmap->scene = air_string_copy(b->context, b->snapshot->source);
    lightmap->photometric = b->snapshot->light_units == AIR_UNITS_PHOTOMETRIC;
    if (lightmap->media == NULL || lightmap->scene == NULL) {
        return air_fail_memory(b->context, "bake");
    }
    if (b->params->lightmaps) {
        status = air_bake_layout_create(b->context, b->snapshot, b->params, &b->layout);
    }
    if (status == AIR_OK && b->params->lightmaps) {
        status = make_texels(b);
    }
    for (size_t i = 0; b->params->vertices && i < b->snapshot->mesh_count; i++) {
        b->report.vertices += b->snapshot->meshes[i]->vertex_count;
    }
    b->work += (double)b->report.vertices * b->params->samples;
    if (status == AIR_OK) {
        status = place_probes(b);
    }
    b->report.layout_s = air_clock(b->context) - start;
    return status;
}

static air_status bake(baking *b)
{
    const air_bake_params *params = b->params;
    air_status status = air_lightmap_create(b->context, &b->lightmap);
    if (status == AIR_OK) {
        status = prepare(b);
    }
    if (status == AIR_OK && params->progress_path != NULL) {
        status =
            air_bake_progress_open(b->context, params->progress_path,
                                   fingerprint(b->snapshot, params), params->resume, &b->progress);
    }
    if (status == AIR_OK) {
        status = make_cache(b);
    }
    if (status == AIR_OK) {
        status = make_responder(b);
    }
    if (status == AIR_OK) {
        status = make_first_light(b);
    }
    if (status == AIR_OK) {
        status = make_path(b, max_depth(params), &b->path);
        b->path_made = status == AIR_OK;
    }
    if (status == AIR_OK && params->lightmaps) {
        status = bake_pages(b);
    }
    if (status == AIR_OK && params->vertices) {
        status = bake_vertices(b);
    }
    return status == AIR_OK ? bake_probes(b) : status;
}

static void finish(baking *b, bool complete)
{
    b->report.resumed_jobs = air_bake_progress_resumed(b->progress);
    air_bake_progress_close(b->progress, complete);
    if (b->path_made) {
        air_path_finish(&b->path);
    }
    air_light_cache_destroy(b->cache);
    air_responder_destroy(b->responder);
    air_first_light_destroy(b->first);
    for (size_t p = 0; b->layout != NULL && p < b->layout->page_count; p++) {
        if (b->texels != NULL) {
            air_texel_sites_finish(b->context, &b->texels[p]);
        }
        if (b->finished != NULL) {
            air_finished_page_destroy(b->context, &b->finished[p]);
        }
    }
    air_free(b->context, b->texels);
    air_free(b->context, b->finished);
    air_bake_layout_destroy(b->layout);
    air_free(b->context, b->sobol);
}

air_status air_bake(air_context *context, const air_snapshot *snapshot,
                    const air_bake_params *params, air_lightmap **out_lightmap,
                    air_bake_report *out_report)
{
    baking b = {.context = context,
                .snapshot = snapshot,
                .params = params,
                .seed = air_hash_combine((uint32_t)params->seed, (uint32_t)(params->seed >> 32))};
    *out_lightmap = NULL;
    air_status status = check_params(context, params);
    if (status == AIR_OK) {
        b.sobol = air_allocate(context, 1, sizeof *b.sobol);
        status = b.sobol == NULL ? air_fail_memory(context, "bake") : AIR_OK;
    }
    if (status == AIR_OK) {
        air_sobol_init(b.sobol);
        status = bake(&b);
    }
    finish(&b, status == AIR_OK);
    if (status != AIR_OK) {
        air_lightmap_destroy(b.lightmap);
        return status;
    }
    *out_lightmap = b.lightmap;
    if (out_report != NULL) {
        *out_report = b.report;
    }
    return AIR_OK;
}

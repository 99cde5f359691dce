#include <airlight/render.h>
#include <airlight/version.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <sys/resource.h>

#include "host.h"
#include "output.h"
#include "render_options.h"
#include "scene_options.h"

static const char *const film_extensions[] = {".exr", ".png", ".pfm", ".film", NULL};

static const cli_usage render_usage = {
    .command = "render",
    .arguments = "SCENE",
    .summary =
        "Renders a scene (.gltf or .glb, with what NAME.airlight.json beside it adds) and writes "
        "the picture, by default NAME.exr in the current directory. An interrupt stops the pass "
        "under way: those before it are written, marked as partial, and the exit code is 130.",
    .examples =
        "  airlight render room.glb -o room.exr -o room.png\n"
        "  airlight render room.glb --medium visibility=50m --environment sky.hdr --quality draft\n"
        "  airlight render room.glb --time 60 --width 1920 --layers -o room.exr\n"
        "  airlight render room.glb --lightmap room.lightmap -o baked.exr\n"
        "  airlight render room.glb --samples 0:256 -o a.film    # and 256:512 elsewhere, then "
        "merge\n",
    .argument_min = 1,
    .argument_max = 1,
};

/* All that one run knows. */
typedef struct render_run {
    cli_parsed parsed;
    const char *scene_path;
    cli_render_options options;
    cli_output_options output;
    cli_scene_options scene;
    cli_host_options host_options;
    cli_host host;
    char default_output[512];
    air_snapshot *snapshot;
    json_t *description;
    cli_camera camera;
    air_render_params params;
    air_area_table area_table;
    air_lightmap *lightmap;
    cli_attributes attributes;
    air_film *film;
    bool interrupted;
    double load_s, render_s, write_s;
    double partial_s; /* when partial outputs were last written */
    bool partial_failed, partial_written;
    cli_written written;
} render_run;

/* ---- before rendering ---- */

static void set_default_output(render_run *run)
{
    cli_output_name(run->scene_path, ".exr", run->default_output, sizeof run->default_output);
    run->output.paths.items[run->output.paths.count++] = run->default_output;
}

/* Is there anything to see? */
static cli_exit check_content(render_run *run)
{
    const uint32_t without_light = 1u << AIR_TERM_EMISSION | 1u << AIR_TERM_BACKGROUND;
    const bool needs_light = run->lightmap == NULL && (run->params.terms & ~without_light) != 0;
    air_scene_info info;
    air_snapshot_info(run->snapshot, &info);
    if (needs_light &&
        cli_scene_need_light(&run->host, run->scene_path, run->snapshot, "picture") != CLI_OK) {
        return CLI_FAILED;
    }
    if (info.medium_count == 0) {
        cli_say(&run->host.progress, AIR_MESSAGE_WARNING,
                "%s: no medium in the scene, rendering it in clear air: --medium visibility=50m "
                "adds haze",
                run->scene_path);
    }
    return CLI_OK;
}

static const char *assumed_unit(const json_t *description, const char *key)
{
    const char *const unit =
        json_string_value(json_object_get(json_object_get(description, "units"), key));
    return unit != NULL ? unit : "unknown";
}

static void make_attributes(render_run *run)
{
    const air_render_params *const params = &run->params;
    cli_attributes *const attributes = &run->attributes;
    char terms[64];
    cli_render_term_list(params->terms, terms, sizeof terms);
    cli_attribute_add(attributes, "airlight:version", false, "%s", air_version());
    cli_attribute_add(attributes, "airlight:scene", false, "%s", run->scene_path);
    cli_attribute_add(attributes, "airlight:camera", false, "%s", run->camera.name);
    cli_attribute_add(attributes, "airlight:seed", false, "%llu", (unsigned long long)params->seed);
    cli_attribute_add(attributes, "airlight:units", false,
                      "radiance in W/(m^2 sr), linear Rec. 709; metres");
    cli_attribute_add(attributes, "airlight:light-units", false, "%s",
                      assumed_unit(run->description, "light"));
    cli_attribute_add(attributes, "airlight:emissive-units", false, "%s",
                      assumed_unit(run->description, "emissive"));
    cli_attribute_add(attributes, "airlight:method", false, "%s", params->methods);
    cli_attribute_add(attributes, "airlight:terms", false, "%s", terms);
    if (run->lightmap != NULL) {
        cli_attribute_add(attributes, "airlight:lightmap", false, "%s", run->options.lightmap);
    }
    cli_attribute_add(attributes, "airlight:filter", false, "%s",
                      cli_render_filter_name(params->filter));
    cli_attribute_add(attributes, "airlight:frame", false, "%zux%zu", params->width,
                      params->height);
    cli_attribute_add(attributes, "airlight:crop", false, "%zu,%zu,%zu,%zu", params->crop[0],
                      params->crop[1], params->crop[2], params->crop[3]);
    if (params->max_depth == UINT32_MAX) {
        cli_attribute_add(attributes, "airlight:max-depth", false, "unlimited");
    } else {
        cli_attribute_add(attributes, "airlight:max-depth", false, "%u", params->max_depth);
    }
    if (params->variance_replicates != 0) {
        cli_attribute_add(attributes, "airlight:variance-replicates", false, "%u",
                          params->variance_replicates);
    }
}

static cli_exit prepare(render_run *run)
{
    const double start_s = cli_clock();
    cli_exit result = cli_host_open(&run->host, &run->host_options);
    if (result == CLI_OK) {
        result = cli_output_check(&run->host, &run->output.paths, film_extensions);
    }
    if (result == CLI_OK) {
        result = cli_scene_open(&run->host, run->scene_path, &run->scene, &run->snapshot,
                                &run->description);
    }
    if (result == CLI_OK) {
        result = cli_scene_camera(&run->host, run->description, run->options.camera, &run->camera);
    }
    if (result == CLI_OK) {
        result = cli_render_params(&run->host, &run->options, &run->camera, &run->params);
    }
    if (result == CLI_OK && run->options.area_table != NULL) {
        const char *path = run->options.area_table;
        result = cli_host_exit(
            &run->host, air_area_table_load(run->host.context, path, &run->area_table), path);
        run->params.area_table = &run->area_table;
    }
    if (result == CLI_OK && run->options.lightmap != NULL) {
        const char *path = run->options.lightmap;
        result = cli_host_exit(&run->host,
                               air_lightmap_load(run->host.context, path, &run->lightmap), path);
        run->params.lightmap = run->lightmap;
    }
    run->load_s = cli_clock() - start_s;
    return result == CLI_OK ? check_content(run) : result;
}

/* ---- rendering and writing ---- */

/* Writes partial outputs when their time has come. A failure ends that, not the rendering. */
static bool on_pass_done(void *user, const air_film *film)
{
    render_run *const run = user;
    if (run->partial_failed || cli_clock() - run->partial_s < run->options.write_partial.value) {
        return true;
    }
    run->partial_written = true;
    run->partial_failed = cli_output_film(&run->host, &run->output, film, &run->attributes, true,
                                          &run->written) != CLI_OK;
    if (run->partial_failed) {
        cli_say(&run->host.progress, AIR_MESSAGE_WARNING, "--write-partial: giving up after that");
    }
    run->partial_s = cli_clock();
    return true;
}

static cli_exit render(render_run *run)
{
    const double start_s = cli_clock();
    uint32_t begin = 0, end = 0;
    if (run->options.write_partial.set) {
        run->params.pass_done = on_pass_done;
        run->params.pass_user = run;
        run->partial_s = start_s;
    }
    const air_status status =
        air_render(run->host.context, run->snapshot, &run->params, &run->film);
    run->render_s = cli_clock() - start_s;
    if (status != AIR_OK && status != AIR_ERROR_INTERRUPTED) {
        return cli_host_exit(&run->host, status, run->scene_path);
    }
    run->interrupted = status == AIR_ERROR_INTERRUPTED;
    run->host.finishing = true;
    if (run->film != NULL) {
        air_film_samples(run->film, &begin, &end);
    }
    if (begin == end) {
        cli_say(&run->host.progress, AIR_MESSAGE_WARNING,
                "interrupted before the first pass: nothing was written");
        return CLI_INTERRUPTED;
    }
    return CLI_OK;
}

static cli_exit write_outputs(render_run *run)
{
    const double start_s = cli_clock();
    cli_attributes *const attributes = &run->attributes;
    air_status status = AIR_OK;
    uint32_t begin, end;
    if (run->interrupted) {
        cli_attribute_add(attributes, "airlight:partial", false, "interrupted");
    }
    for (size_t i = 0; i < attributes->count && status == AIR_OK; i++) {
        if (!attributes->items[i].image_only) {
            status = air_film_set_attribute(run->film, attributes->items[i].name,
                                            attributes->items[i].value);
        }
    }
    air_film_samples(run->film, &begin, &end);
    cli_attribute_add(attributes, "airlight:samples", true, "%u:%u", begin, end);
    cli_exit result = cli_host_exit(&run->host, status, "setting attributes");
    if (result == CLI_OK) {
        result =
            cli_output_film(&run->host, &run->output, run->film, attributes, false, &run->written);
    }
    /* The partial files stay if the final ones could not be written: they are all there is. */
    if (result == CLI_OK && run->partial_written) {
        cli_output_remove_partial(&run->output);
    }
    run->write_s = cli_clock() - start_s;
    return result;
}

/* ---- statistics ---- */

typedef struct render_statistics {
    uint32_t begin, end;
    size_t width, height; /* of the crop */
    double samples, samples_per_second;
    double peak_bytes;
} render_statistics;

static render_statistics measure(const render_run *run)
{
    render_statistics statistics = {
        .width = run->params.crop[2] - run->params.crop[0],
        .height = run->params.crop[3] - run->params.crop[1],
    };
    struct rusage usage;
    air_film_samples(run->film, &statistics.begin, &statistics.end);
    statistics.samples = (double)(statistics.end - statistics.begin) * (double)statistics.width *
                         (double)statistics.height;
    statistics.samples_per_second = run->render_s > 0.0 ? statistics.samples / run->render_s : 0.0;
    getrusage(RUSAGE_SELF, &usage);
    statistics.peak_bytes = (double)usage.ru_maxrss * 1024.0; /* Linux counts in KiB */
    return statistics;
}

static void report(render_run *run, const render_statistics *statistics)
{
    cli_progress *const progress = &run->host.progress;
    cli_report(progress,
               "%s%zu x %zu pixels, %u samples each, in %.2f s (%.3g samples per second), peak "
               "memory %.0f MB",
               run->interrupted ? "interrupted: " : "", statistics->width, statistics->height,
               statistics->end - statistics->begin, run->render_s, statistics->samples_per_second,
               statistics->peak_bytes * 1e-6);
    for (size_t i = 0; i < run->output.paths.count; i++) {
        cli_report(progress, "wrote %s%s (exposure %+.2f EV)", run->output.paths.items[i],
                   run->interrupted ? ", partial" : "", run->written.exposure_ev);
    }
    if (run->options.stats) {
        const double *const mean = run->written.mean;
        cli_report(progress, "load %.2f s, render %.2f s, write %.2f s; %zu threads", run->load_s,
                   run->render_s, run->write_s, air_context_thread_count(run->host.context));
        cli_report(progress, "mean R %.6g, G %.6g, B %.6g; samples %u:%u; seed %llu", mean[0],
                   mean[1], mean[2], statistics->begin, statistics->end,
                   (unsigned long long)run->params.seed);
    }
}

static void print_json(const render_run *run, const render_statistics *statistics)
{
    json_t *const outputs = json_array();
    for (size_t i = 0; i < run->output.paths.count; i++) {
        json_array_append_new(outputs, json_string(run->output.paths.items[i]));
    }
    const double *const mean = run->written.mean;
    /* NaN is no JSON: a mean that is not finite becomes null. */
    json_t *const means = json_array();
    for (size_t c = 0; c < 3; c++) {
        json_array_append_new(means, isfinite(mean[c]) ? json_real(mean[c]) : json_null());
    }
    json_t *const object = json_pack(
        "{s:s, s:o, s:I, s:I, s:[I, I, I, I], s:[I, I], s:{s:f, s:f, s:f}, s:f, s:f, s:f, s:o, "
        "s:I, s:I, s:b}",
        "scene", run->scene_path, "outputs", outputs, "width", (json_int_t)run->params.width,
        "height", (json_int_t)run->params.height, "crop", (json_int_t)run->params.crop[0],
        (json_int_t)run->params.crop[1], (json_int_t)run->params.crop[2],
        (json_int_t)run->params.crop[3], "samples", (json_int_t)statistics->begin,
        (json_int_t)statistics->end, "seconds", "load", run->load_s, "render", run->render_s,
        "write", run->write_s, "samples_per_second", statistics->samples_per_second,
        "peak_memory_bytes", statistics->peak_bytes, "exposure_ev", run->written.exposure_ev,
        "mean", means, "threads", (json_int_t)air_context_thread_count(run->host.context),
        "max_depth", (json_int_t)run->params.max_depth, "interrupted", (int)run->interrupted);
    if (object != NULL) {
        json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        putchar('\n');
        json_decref(object);
    }
}

/* ---- the command ---- */

static cli_exit run_render(render_run *run)
{
    cli_exit result = prepare(run);
    if (result != CLI_OK) {
        return result;
    }
    make_attributes(run);
    result = render(run);
    if (result == CLI_OK) {
        result = write_outputs(run);
    }
    if (result != CLI_OK) {
        return result;
    }
    const render_statistics statistics = measure(run);
    report(run, &statistics);
    if (run->options.json) {
        print_json(run, &statistics);
    }
    return run->interrupted ? CLI_INTERRUPTED : CLI_OK;
}

static cli_exit parse(render_run *run, int argc, char **argv)
{
    enum { GROUP_COUNT = CLI_RENDER_GROUPS + 3 };
    cli_option_group groups[GROUP_COUNT];
    groups[0] = cli_output_group(&run->output);
    cli_render_groups(&run->options, groups + 1);
    groups[GROUP_COUNT - 2] = cli_scene_group(&run->scene);
    groups[GROUP_COUNT - 1] = cli_host_group(&run->host_options);
    run->parsed = cli_parse(&render_usage, groups, GROUP_COUNT, &argc, argv);
    if (run->parsed != CLI_PARSED) {
        return run->parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    run->scene_path = argv[0];
    if (run->output.paths.count == 0) {
        set_default_output(run);
    }
    return cli_render_check(&run->options);
}

cli_exit cli_render(int argc, char **argv)
{
    render_run run = {.parsed = CLI_PARSE_FAILED};
    /* Before parsing, which reorders the arguments. */
    cli_attribute_command(&run.attributes, "render", argc, argv);
    cli_exit result = parse(&run, argc, argv);
    if (result == CLI_OK && run.parsed == CLI_PARSED) {
        result = run_render(&run);
    }
    air_film_destroy(run.film);
    air_lightmap_destroy(run.lightmap);
    cli_attributes_finish(&run.attributes);
    json_decref(run.description);
    air_snapshot_release(run.snapshot);
    cli_host_close(&run.host);
    return result;
}

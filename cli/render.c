#include <airlight/render.h>
#include <airlight/version.h>
#include <jansson.h>
#include <stdio.h>

#include "frames.h"
#include "host.h"
#include "interrupt.h"
#include "output.h"
#include "render_options.h"
#include "rendered.h"
#include "scene_options.h"
#include "sequence.h"

static const char *const film_extensions[] = {".exr", ".png", ".pfm", ".film", NULL};

static const cli_usage render_usage = {
    .command = "render",
    .arguments = "SCENE",
    .summary =
        "Renders a scene (.gltf, .glb or .xml, with what NAME.airlight.json beside it adds) and "
        "writes the picture, by default NAME.exr in the current directory; with --frames, one for "
        "each frame. An interrupt stops the pass under way: those before it are written, marked "
        "as partial, and the exit code is 130.",
    .examples =
        "  airlight render room.glb -o room.exr -o room.png\n"
        "  airlight render room.glb --medium visibility=50m --environment sky.hdr --quality draft\n"
        "  airlight render room.glb --time 60 --width 1920 --layers -o room.exr\n"
        "  airlight render cloud.gltf --quality interactive -o cloud.png\n"
        "  airlight render smoke.gltf --method sky=ordinates,sun=path --cells 48 -o smoke.exr\n"
        "  airlight render room.glb --lightmap room.lightmap -o baked.exr\n"
        "  airlight render room.glb --samples 0:256 -o a.film    # and 256:512 elsewhere, then "
        "merge\n"
        "  airlight render stage.glb --medium grid=smoke.####.nvdb,sigma_s=8 --frames 1-48 "
        "-o stage.####.exr\n",
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
    cli_sequence sequence;
    json_t *description;
    cli_camera camera;
    air_render_params params;
    air_area_table area_table;
    air_lightmap *lightmap;
    air_render_state *state; /* of a sequence whose frames begin where those before ended */
    cli_attributes attributes;
    /* of the frame under way: */
    int64_t frame;              /* AIR_FRAME_NONE: there is one without a number */
    char label[32], prefix[40]; /* "frame 7", "frame 7: " */
    cli_frame_names names;      /* frame_output's */
    cli_output_options frame_output;
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
    cli_output_name(run->scene_path, run->options.frames != NULL ? ".####.exr" : ".exr",
                    run->default_output, sizeof run->default_output);
    run->output.paths.items[run->output.paths.count++] = run->default_output;
}

/* The names of the first frame, and those of the last: there runs of unlike length may meet. */
static cli_exit check_outputs(render_run *run)
{
    const cli_frames *const frames = &run->options.sequence;
    const size_t ends[2] = {0, cli_frames_count(frames) - 1};
    cli_exit result = cli_frames_check_names(&run->host, frames, &run->output.paths);
    for (size_t i = 0; i < 2 && result == CLI_OK; i++) {
        result = cli_frame_names_set(&run->host, &run->output.paths, cli_frames_at(frames, ends[i]),
                                     &run->names);
        if (result == CLI_OK) {
            result = cli_output_check(&run->host, &run->names.list, film_extensions);
        }
    }
    for (size_t i = 0; i < run->output.paths.count && result == CLI_OK; i++) {
        const bool exposed = run->output.exposure.set && !run->output.exposure.word;
        if (cli_frames_count(frames) > 1 && !exposed &&
            cli_has_extension(run->output.paths.items[i], ".png")) {
            cli_say(&run->host.progress, AIR_MESSAGE_WARNING,
                    "%s: each frame gets an exposure of its own, which may flicker: --exposure EV "
                    "sets one for all",
                    run->output.paths.items[i]);
            break;
        }
    }
    return result;
}

/* Which frame it is about, for messages, progress and reports. */
static void begin_frame(render_run *run, size_t index)
{
    const cli_frames *const frames = &run->options.sequence;
    run->frame = cli_frames_at(frames, index);
    if (frames->set) {
        snprintf(run->label, sizeof run->label, "frame %lld", (long long)run->frame);
        snprintf(run->prefix, sizeof run->prefix, "%s: ", run->label);
        run->host.about = run->label;
        cli_progress_frame(&run->host.progress, run->frame, index, cli_frames_count(frames));
    }
}

/* The scene at its first frame. */
static cli_exit open_scene(render_run *run)
{
    begin_frame(run, 0);
    cli_exit result =
        cli_sequence_open(&run->host, run->scene_path, &run->scene, run->frame, &run->sequence);
    if (result == CLI_OK) {
        result = cli_scene_describe(&run->host, run->sequence.snapshot, &run->description);
    }
    if (result == CLI_OK) {
        result = cli_scene_camera(&run->host, run->description, run->options.camera, &run->camera);
    }
    if (result == CLI_OK) {
        result =
            cli_sequence_set_camera(&run->host, &run->camera, &run->options.orbit, &run->sequence);
        run->camera.film = run->sequence.still.film;
    }
    return result;
}

/* Is there anything to see? */
static cli_exit check_content(render_run *run)
{
    const uint32_t without_light = 1u << AIR_TERM_EMISSION | 1u << AIR_TERM_BACKGROUND;
    const bool needs_light = run->lightmap == NULL && (run->params.terms & ~without_light) != 0;
    air_scene_info info;
    air_snapshot_info(run->sequence.snapshot, &info);
    if (needs_light && cli_scene_need_light(&run->host, run->scene_path, run->sequence.snapshot,
                                            "picture") != CLI_OK) {
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
        result = check_outputs(run);
    }
    if (result == CLI_OK) {
        result = open_scene(run);
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
    if (result == CLI_OK && cli_frames_count(&run->options.sequence) > 1 &&
        !run->options.no_warm_start) {
        result = cli_host_exit(&run->host, air_render_state_create(run->host.context, &run->state),
                               "the sequence");
        run->params.state = run->state;
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
    run->partial_failed = cli_output_film(&run->host, &run->frame_output, film, &run->attributes,
                                          true, &run->written) != CLI_OK;
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
        air_render(run->host.context, run->sequence.snapshot, &run->params, &run->film);
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
                "%sinterrupted before the first pass: nothing was written", run->prefix);
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
        result = cli_output_film(&run->host, &run->frame_output, run->film, attributes, false,
                                 &run->written);
    }
    /* The partial files stay if the final ones could not be written: they are all there is. */
    if (result == CLI_OK && run->partial_written) {
        cli_output_remove_partial(&run->frame_output);
    }
    run->write_s = cli_clock() - start_s;
    return result;
}

/* What was done, on stderr and stdout. */
static void report(render_run *run)
{
    const cli_rendered rendered = {
        .scene_path = run->scene_path,
        .outputs = &run->names.list,
        .frame = run->frame,
        .prefix = run->prefix,
        .params = &run->params,
        .film = run->film,
        .written = run->written,
        .interrupted = run->interrupted,
        .load_s = run->load_s,
        .render_s = run->render_s,
        .write_s = run->write_s,
    };
    cli_rendered_report(&run->host, &rendered, run->options.stats);
    if (run->options.json) {
        cli_rendered_json(&run->host, &rendered);
    }
}

/* ---- the command ---- */

/* The scene, the files and the attributes of the frame. */
static cli_exit prepare_frame(render_run *run)
{
    const double start_s = cli_clock();
    run->host.finishing = run->interrupted = run->partial_failed = run->partial_written = false;
    run->written = (cli_written){0};
    cli_exit result = cli_sequence_move(&run->host, &run->sequence, run->frame);
    if (result == CLI_OK) {
        result = cli_frame_names_set(&run->host, &run->output.paths, run->frame, &run->names);
    }
    run->params.camera = cli_sequence_camera(&run->sequence);
    run->frame_output = run->output;
    run->frame_output.paths = run->names.list;
    if (run->frame != AIR_FRAME_NONE) {
        cli_attribute_add(&run->attributes, "airlight:frame-number", false, "%lld",
                          (long long)run->frame);
    }
    run->load_s += cli_clock() - start_s;
    return result;
}

static cli_exit render_frame(render_run *run)
{
    cli_exit result = prepare_frame(run);
    if (result == CLI_OK) {
        result = render(run);
    }
    if (result == CLI_OK) {
        result = write_outputs(run);
    }
    if (result != CLI_OK) {
        return result;
    }
    report(run);
    return run->interrupted ? CLI_INTERRUPTED : CLI_OK;
}

/* One frame after the other, with the same samples and by the same seed: each as if it were the
 * only one, but for what run->state keeps. */
static cli_exit render_frames(render_run *run)
{
    const size_t attribute_count = run->attributes.count;
    const size_t count = cli_frames_count(&run->options.sequence);
    cli_exit result = CLI_OK;
    for (size_t i = 0; i < count && result == CLI_OK; i++) {
        if (i > 0 && cli_interrupt_pending()) {
            cli_say(&run->host.progress, AIR_MESSAGE_WARNING,
                    "interrupted after frame %lld: %zu of %zu are done", (long long)run->frame, i,
                    count);
            return CLI_INTERRUPTED;
        }
        begin_frame(run, i);
        result = render_frame(run);
        run->sequence.dirty = 0;
        run->load_s = 0.0;
        air_film_destroy(run->film);
        run->film = NULL;
        cli_attributes_cut(&run->attributes, attribute_count);
    }
    return result;
}

static cli_exit run_render(render_run *run)
{
    const cli_exit result = prepare(run);
    if (result != CLI_OK) {
        return result;
    }
    make_attributes(run);
    return render_frames(run);
}

static cli_exit parse(render_run *run, int argc, char **argv)
{
    enum { GROUP_COUNT = CLI_RENDER_GROUPS + 3 };
    cli_option_group groups[GROUP_COUNT];
    groups[0] = cli_output_group(&run->output);
    cli_render_groups(&run->options, groups + 1);
    groups[GROUP_COUNT - 2] = cli_scene_group_of_frames(&run->scene);
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
    cli_frame_names_finish(&run.names);
    air_render_state_destroy(run.state);
    air_lightmap_destroy(run.lightmap);
    cli_attributes_finish(&run.attributes);
    json_decref(run.description);
    cli_sequence_close(&run.sequence);
    cli_host_close(&run.host);
    return result;
}

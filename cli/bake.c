#include <airlight/bake.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bake_options.h"
#include "output.h"
#include "scene_options.h"

static const cli_usage bake_usage = {
    .command = "bake",
    .arguments = "SCENE",
    .summary =
        "Bakes the light on a scene's surfaces, at its vertices and in probes, with what fog "
        "scatters onto them, into a folder: lightmap.json, pages as EXR with the layers direct, "
        "indirect and media. An interrupt keeps what is done in DIR/bake.progress, and the same "
        "command goes on from there.",
    .examples =
        "  airlight bake room.glb -o room.lightmap --gltf room-lit.glb\n"
        "  airlight bake room.glb --medium visibility=30m --texels-per-metre 32 --quality high\n"
        "  airlight bake room.glb --uv file --mesh-size 512 --page-size 512\n"
        "  airlight bake room.glb --probes auto=1 --targets lightmap,vertices\n",
    .argument_min = 1,
    .argument_max = 1,
};

typedef struct bake_run {
    const char *scene_path;
    cli_bake_options options;
    cli_scene_options scene;
    cli_host_options host_options;
    cli_host host;
    char folder[1024], progress_path[1100];
    bool folder_made; /* by this run */
    air_snapshot *snapshot;
    json_t *description;
    cli_probes probes;
    air_bake_params params;
    air_bake_report report;
    air_impulse_tables *tables;
    air_lightmap *lightmap;
} bake_run;

static void set_folder(bake_run *run)
{
    if (run->options.output != NULL) {
        snprintf(run->folder, sizeof run->folder, "%s", run->options.output);
    } else {
        cli_output_name(run->scene_path, ".lightmap", run->folder, sizeof run->folder);
    }
    snprintf(run->progress_path, sizeof run->progress_path, "%s/bake.progress", run->folder);
}

/* Makes the folder, so that what cannot be written is known before the work. */
static cli_exit make_folder(bake_run *run)
{
    struct stat status;
    run->folder_made = mkdir(run->folder, 0777) == 0;
    if (run->folder_made) {
        return CLI_OK;
    }
    if (errno == EEXIST && stat(run->folder, &status) == 0 && S_ISDIR(status.st_mode)) {
        return CLI_OK;
    }
    cli_say(&run->host.progress, AIR_MESSAGE_ERROR, "%s: cannot make this folder: %s", run->folder,
            errno == EEXIST ? "a file has its name" : strerror(errno));
    return CLI_FAILED;
}

static cli_exit prepare(bake_run *run)
{
    cli_exit result = cli_host_open(&run->host, &run->host_options);
    if (result == CLI_OK) {
        result = cli_bake_params(&run->host, &run->options, &run->probes, &run->params);
    }
    if (result == CLI_OK) {
        result = cli_scene_open(&run->host, run->scene_path, &run->scene, &run->snapshot,
                                &run->description);
    }
    if (result == CLI_OK) {
        result = cli_scene_need_light(&run->host, run->scene_path, run->snapshot, "lightmap");
    }
    if (result == CLI_OK) {
        set_folder(run);
        result = make_folder(run);
    }
    run->params.progress_path = run->progress_path;
    if (result == CLI_OK && run->options.impulse_tables != NULL) {
        const char *const path = run->options.impulse_tables;
        result = cli_host_exit(
            &run->host, air_impulse_tables_load(run->host.context, path, &run->tables), path);
        run->params.impulse_tables = run->tables;
    }
    return result;
}

static cli_exit save(bake_run *run)
{
    const cli_bake_options *const options = &run->options;
    cli_host *const host = &run->host;
    air_context *const context = host->context;
    const air_lightmap *const lightmap = run->lightmap;
    air_lightmap_save_params params;
    air_lightmap_gltf_params show;
    air_lightmap_save_params_default(&params);
    air_lightmap_gltf_params_default(&show);
    show.show = options->gltf_show.set ? (air_lightmap_show)options->gltf_show.value : show.show;
    params.half = !options->full;
    host->finishing = true;
    cli_exit result = cli_host_exit(
        host, air_lightmap_save(context, lightmap, run->folder, &params), run->folder);
    if (result == CLI_OK && options->gltf != NULL) {
        result = cli_host_exit(
            host, air_lightmap_save_gltf(context, lightmap, run->scene_path, options->gltf, &show),
            options->gltf);
    }
    if (result == CLI_OK && options->godot != NULL) {
        result = cli_host_exit(
            host, air_lightmap_save_godot(context, lightmap, run->scene_path, options->godot, NULL),
            options->godot);
    }
    if (result == CLI_OK && options->bevy != NULL) {
        result = cli_host_exit(host, air_lightmap_save_bevy(context, lightmap, options->bevy),
                               options->bevy);
    }
    if (result == CLI_OK && options->rgbm != NULL) {
        const float range = options->rgbm_range.set ? (float)options->rgbm_range.value
                                                    : air_lightmap_peak(lightmap);
        result = cli_host_exit(
            host, air_lightmap_save_rgbm(context, lightmap, options->rgbm, range), options->rgbm);
    }
    return result;
}

static void report(bake_run *run)
{
    const air_bake_report *const r = &run->report;
    cli_report(&run->host.progress,
               "baked %zu texels on %zu pages, %zu vertices, %zu probes with %u samples, media %s: "
               "layout %.2f s, cached light %.2f s, first pass %.2f s, samples %.2f s, finishing "
               "%.2f s%s; wrote %s",
               r->texels, run->lightmap->page_count, r->vertices, r->probes, run->params.samples,
               run->lightmap->media, r->layout_s, r->cache_s, r->first_s, r->sample_s, r->finish_s,
               r->resumed_jobs > 0 ? " (resumed)" : "", run->folder);
    if (r->invalid_texels > 0) {
        cli_report(&run->host.progress,
                   "%zu texels lie inside of something and were filled from their neighbours",
                   r->invalid_texels);
    }
}

static cli_exit run_bake(bake_run *run)
{
    cli_exit result = prepare(run);
    if (result == CLI_OK) {
        result = cli_host_exit(
            &run->host,
            air_bake(run->host.context, run->snapshot, &run->params, &run->lightmap, &run->report),
            "baking");
    }
    if (result == CLI_OK) {
        result = save(run);
    }
    if (result == CLI_OK) {
        report(run);
    }
    return result;
}

cli_exit cli_bake(int argc, char **argv)
{
    bake_run run = {.lightmap = NULL};
    cli_option_group groups[CLI_BAKE_GROUPS + 2];
    cli_bake_groups(&run.options, groups);
    groups[CLI_BAKE_GROUPS] = cli_scene_group(&run.scene);
    groups[CLI_BAKE_GROUPS + 1] = cli_host_group(&run.host_options);
    const cli_parsed parsed =
        cli_parse(&bake_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed != CLI_PARSED) {
        return parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    run.scene_path = argv[0];
    const cli_exit result = run_bake(&run);
    if (result != CLI_OK && run.folder_made) {
        (void)rmdir(run.folder); /* if nothing is in it */
    }
    air_lightmap_destroy(run.lightmap);
    air_impulse_tables_destroy(run.tables);
    json_decref(run.description);
    air_snapshot_release(run.snapshot);
    cli_probes_finish(&run.probes);
    cli_host_close(&run.host);
    return result;
}

#include <airlight/render.h>
#include <stdio.h>

#include "host.h"
#include "output.h"

static const char *const film_extensions[] = {".exr", ".png", ".pfm", ".film", NULL};

static const cli_usage merge_usage = {
    .command = "merge",
    .arguments = "A.film [B.film ...]",
    .summary = "Adds films of the same picture with different samples, and writes the sum as a "
               "film or a picture. Adjacent sample ranges merge to the bytes of one run.",
    .examples = "  airlight merge a.film b.film -o all.film -o all.exr -o all.png\n"
                "  airlight merge part-*.film -o all.png --exposure 1.5\n",
    .argument_min = 1,
    .argument_max = SIZE_MAX,
};

typedef struct merge_run {
    cli_output_options output;
    cli_host_options host_options;
    cli_host host;
    cli_attributes attributes;
    air_film *film;
} merge_run;

/* Adds one more film; the first becomes the sum. */
static cli_exit add_film(merge_run *run, const char *path)
{
    air_film *film = NULL;
    air_status status = air_film_load(run->host.context, path, &film);
    if (status == AIR_OK && run->film == NULL) {
        run->film = film;
        return CLI_OK;
    }
    if (status == AIR_OK) {
        run->host.about = path;
        status = air_film_merge(run->film, film);
        run->host.about = NULL;
    }
    /* What an interrupt left out may well be in another film. */
    if (status == AIR_OK) {
        status = air_film_set_attribute(run->film, "airlight:partial", NULL);
    }
    air_film_destroy(film);
    return cli_host_exit(&run->host, status, path);
}

static cli_exit run_merge(merge_run *run, int path_count, char *const *paths)
{
    cli_written written;
    uint32_t begin, end;
    cli_exit result = cli_host_open(&run->host, &run->host_options);
    if (result == CLI_OK) {
        result = cli_output_check(&run->host, &run->output.paths, film_extensions);
    }
    for (int i = 0; i < path_count && result == CLI_OK; i++) {
        result = add_film(run, paths[i]);
    }
    if (result != CLI_OK) {
        return result;
    }
    air_film_samples(run->film, &begin, &end);
    cli_attribute_add(&run->attributes, "airlight:samples", true, "%u:%u", begin, end);
    result =
        cli_output_film(&run->host, &run->output, run->film, &run->attributes, false, &written);
    for (size_t i = 0; i < run->output.paths.count && result == CLI_OK; i++) {
        cli_report(&run->host.progress, "wrote %s: samples %u:%u (exposure %+.2f EV)",
                   run->output.paths.items[i], begin, end, written.exposure_ev);
    }
    return result;
}

cli_exit cli_merge(int argc, char **argv)
{
    merge_run run = {.film = NULL};
    cli_exit result = CLI_USAGE;
    cli_attribute_command(&run.attributes, "merge", argc, argv);
    const cli_option_group groups[] = {cli_output_group(&run.output),
                                       cli_host_group(&run.host_options)};
    const cli_parsed parsed =
        cli_parse(&merge_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed == CLI_PARSED_HELP) {
        result = CLI_OK;
    } else if (parsed == CLI_PARSED && run.output.paths.count == 0) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "merge: expected an output: -o FILE.film, .exr, .png or .pfm");
    } else if (parsed == CLI_PARSED) {
        result = run_merge(&run, argc, argv);
    }
    air_film_destroy(run.film);
    cli_attributes_finish(&run.attributes);
    cli_host_close(&run.host);
    return result;
}

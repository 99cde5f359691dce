#include "rendered.h"

#include <airlight/frame.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <sys/resource.h>

typedef struct statistics {
    uint32_t begin, end;
    size_t width, height; /* of the crop */
    double samples_per_second;
    double peak_bytes;
} statistics;

static statistics measure(const cli_rendered *rendered)
{
    const size_t *const crop = rendered->params->crop;
    statistics out = {.width = crop[2] - crop[0], .height = crop[3] - crop[1]};
    struct rusage usage;
    air_film_samples(rendered->film, &out.begin, &out.end);
    const double samples = (double)(out.end - out.begin) * (double)out.width * (double)out.height;
    out.samples_per_second = rendered->render_s > 0.0 ? samples / rendered->render_s : 0.0;
    getrusage(RUSAGE_SELF, &usage);
    out.peak_bytes = (double)usage.ru_maxrss * 1024.0; /* Linux counts in KiB */
    return out;
}

void cli_rendered_report(cli_host *host, const cli_rendered *rendered, bool stats)
{
    cli_progress *const progress = &host->progress;
    const statistics made = measure(rendered);
    const double *const mean = rendered->written.mean;
    cli_report(progress,
               "%s%s%zu x %zu pixels, %u samples each, in %.2f s (%.3g samples per second), peak "
               "memory %.0f MB",
               rendered->prefix, rendered->interrupted ? "interrupted: " : "", made.width,
               made.height, made.end - made.begin, rendered->render_s, made.samples_per_second,
               made.peak_bytes * 1e-6);
    for (size_t i = 0; i < rendered->outputs->count; i++) {
        cli_report(progress, "wrote %s%s (exposure %+.2f EV)", rendered->outputs->items[i],
                   rendered->interrupted ? ", partial" : "", rendered->written.exposure_ev);
    }
    if (stats) {
        cli_report(progress, "load %.2f s, render %.2f s, write %.2f s; %zu threads",
                   rendered->load_s, rendered->render_s, rendered->write_s,
                   air_context_thread_count(host->context));
        cli_report(progress, "mean R %.6g, G %.6g, B %.6g; samples %u:%u; seed %llu", mean[0],
                   mean[1], mean[2], made.begin, made.end,
                   (unsigned long long)rendered->params->seed);
    }
}

static json_t *describe(const cli_host *host, const cli_rendered *rendered)
{
    const air_render_params *const params = rendered->params;
    const statistics made = measure(rendered);
    json_t *const outputs = json_array();
    for (size_t i = 0; i < rendered->outputs->count; i++) {
        json_array_append_new(outputs, json_string(rendered->outputs->items[i]));
    }
    const double *const mean = rendered->written.mean;
    /* NaN is no JSON: a mean that is not finite becomes null. */
    json_t *const means = json_array();
    for (size_t c = 0; c < 3; c++) {
        json_array_append_new(means, isfinite(mean[c]) ? json_real(mean[c]) : json_null());
    }
    return json_pack(
        "{s:s, s:o, s:I, s:I, s:[I, I, I, I], s:[I, I], s:{s:f, s:f, s:f}, s:f, s:f, s:f, s:o, "
        "s:I, s:I, s:b}",
        "scene", rendered->scene_path, "outputs", outputs, "width", (json_int_t)params->width,
        "height", (json_int_t)params->height, "crop", (json_int_t)params->crop[0],
        (json_int_t)params->crop[1], (json_int_t)params->crop[2], (json_int_t)params->crop[3],
        "samples", (json_int_t)made.begin, (json_int_t)made.end, "seconds", "load",
        rendered->load_s, "render", rendered->render_s, "write", rendered->write_s,
        "samples_per_second", made.samples_per_second, "peak_memory_bytes", made.peak_bytes,
        "exposure_ev", rendered->written.exposure_ev, "mean", means, "threads",
        (json_int_t)air_context_thread_count(host->context), "max_depth",
        (json_int_t)params->max_depth, "interrupted", (int)rendered->interrupted);
}

void cli_rendered_json(const cli_host *host, const cli_rendered *rendered)
{
    json_t *const object = describe(host, rendered);
    const bool numbered = rendered->frame != AIR_FRAME_NONE;
    if (object == NULL) {
        return;
    }
    if (numbered) {
        json_object_set_new(object, "frame", json_integer(rendered->frame));
    }
    json_dumpf(object, stdout,
               JSON_REAL_PRECISION(9) | (size_t)(numbered ? JSON_COMPACT : JSON_INDENT(2)));
    putchar('\n');
    fflush(stdout);
    json_decref(object);
}

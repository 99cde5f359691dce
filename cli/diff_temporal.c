#include "diff_temporal.h"

#include <stdio.h>

#include "interrupt.h"

static cli_exit add_frame(cli_host *host, const cli_list *paths, air_temporal *temporal)
{
    air_image *images[2] = {NULL, NULL};
    cli_exit result = CLI_OK;
    for (size_t i = 0; i < 2 && result == CLI_OK; i++) {
        result = cli_host_exit(host, air_image_load(host->context, paths->items[i], &images[i]),
                               paths->items[i]);
    }
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_temporal_add(temporal, images[0], images[1]), "comparing");
    }
    air_image_destroy(images[0]);
    air_image_destroy(images[1]);
    return result;
}

cli_exit cli_diff_sequences(cli_host *host, char *const paths[2], const cli_frames *frames,
                            air_temporal **out)
{
    const cli_list patterns = {.count = 2, .items = {paths[0], paths[1]}};
    const size_t count = cli_frames_count(frames);
    cli_frame_names names = {0};
    cli_exit result = cli_frames_check_names(host, frames, &patterns);
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_temporal_create(host->context, out), "comparing");
    }
    for (size_t i = 0; i < count && result == CLI_OK; i++) {
        char label[32];
        const int64_t frame = cli_frames_at(frames, i);
        snprintf(label, sizeof label, "frame %lld", (long long)frame);
        host->about = label;
        cli_progress_update(&host->progress, (double)i / (double)count, "reading frames");
        result = cli_interrupt_pending() ? CLI_INTERRUPTED
                                         : cli_frame_names_set(host, &patterns, frame, &names);
        if (result == CLI_OK) {
            result = add_frame(host, &names.list, *out);
        }
        host->about = NULL;
    }
    cli_frame_names_finish(&names);
    return result;
}

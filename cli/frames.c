#include "frames.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* ---- which frames ---- */

/* Moves *text behind the digits it begins with. False: there are none, or they are no frame. */
static bool read_number(const char **text, int64_t *out)
{
    const char *at = *text;
    int64_t value = 0;
    for (; isdigit((unsigned char)*at); at++) {
        value = 10 * value + (*at - '0');
        if (value > AIR_FRAME_MAX) {
            return false;
        }
    }
    if (at == *text) {
        return false;
    }
    *text = at;
    *out = value;
    return true;
}

/* The whole text; whether the numbers make sense together is another question. */
static bool read_range(const char *text, cli_frames *out)
{
    *out = (cli_frames){.set = true, .step = 1};
    if (!read_number(&text, &out->first)) {
        return false;
    }
    out->last = out->first;
    if (*text == '-') {
        text++;
        if (!read_number(&text, &out->last)) {
            return false;
        }
        if (*text == '/') {
            text++;
            if (!read_number(&text, &out->step)) {
                return false;
            }
        }
    }
    return *text == '\0';
}

cli_exit cli_frames_read(const char *text, cli_frames *out)
{
    cli_frames frames;
    *out = (cli_frames){.set = false};
    if (text == NULL) {
        return CLI_OK;
    }
    if (!read_range(text, &frames)) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "--frames: expected N, A-B or A-B/STEP in whole numbers from 0 to %d, got \"%s\"",
                (int)AIR_FRAME_MAX, text);
        return CLI_USAGE;
    }
    if (frames.last < frames.first || frames.step < 1) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "--frames: expected A-B with A <= B and a step of at least 1, got \"%s\"", text);
        return CLI_USAGE;
    }
    if (cli_frames_count(&frames) > CLI_FRAMES_MAX) {
        cli_say(NULL, AIR_MESSAGE_ERROR, "--frames: expected at most %d frames, got %zu (\"%s\")",
                (int)CLI_FRAMES_MAX, cli_frames_count(&frames), text);
        return CLI_USAGE;
    }
    *out = frames;
    return CLI_OK;
}

size_t cli_frames_count(const cli_frames *frames)
{
    return frames->set ? (size_t)((frames->last - frames->first) / frames->step) + 1 : 1;
}

int64_t cli_frames_at(const cli_frames *frames, size_t index)
{
    return frames->set ? frames->first + frames->step * (int64_t)index : AIR_FRAME_NONE;
}

/* ---- which files ---- */

cli_exit cli_frames_check_names(cli_host *host, const cli_frames *frames, const cli_list *names)
{
    for (size_t i = 0; i < names->count && frames->set; i++) {
        size_t digits = 0;
        if (air_frame_digits(host->context, names->items[i], &digits) != AIR_OK) {
            return CLI_USAGE;
        }
        if (digits == 0 && cli_frames_count(frames) > 1) {
            cli_say(&host->progress, AIR_MESSAGE_ERROR,
                    "%s: expected a run of # in the name, for the number of each of %zu frames",
                    names->items[i], cli_frames_count(frames));
            return CLI_USAGE;
        }
    }
    return CLI_OK;
}

cli_exit cli_frame_names_set(cli_host *host, const cli_list *names, int64_t frame,
                             cli_frame_names *out)
{
    air_status status = AIR_OK;
    cli_frame_names_finish(out);
    for (size_t i = 0; i < names->count && status == AIR_OK; i++) {
        const char *const name = names->items[i];
        const size_t size = strlen(name) + AIR_FRAME_DIGITS_MAX + 1;
        char *const copy = malloc(size);
        if (copy == NULL) {
            status = AIR_ERROR_MEMORY;
        } else if (frame == AIR_FRAME_NONE) {
            memcpy(copy, name, strlen(name) + 1);
        } else {
            status = air_frame_path(host->context, name, frame, copy, size);
        }
        if (status == AIR_OK) {
            out->list.items[out->list.count++] = copy;
        } else {
            free(copy);
        }
    }
    return cli_host_exit(host, status, "naming files");
}

void cli_frame_names_finish(cli_frame_names *names)
{
    for (size_t i = 0; i < names->list.count; i++) {
        free((void *)names->list.items[i]);
    }
    names->list.count = 0;
}

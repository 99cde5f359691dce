#include "output.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PATH_LENGTH_MAX = 4096, FIRST_PICTURE_OPTION = 1 /* in output_options */ };

static const char *const view_names[] = {"neutral", "standard", "raw", NULL};

static const cli_option output_options[] = {
    {.name = "output",
     .letter = 'o',
     .kind = CLI_LIST,
     .value = "FILE",
     .offset = offsetof(cli_output_options, paths),
     .help = "Where to write: .exr, .png, .pfm, or .film for the raw sums. Repeatable."},
    {.name = "exposure",
     .kind = CLI_REAL,
     .value = "auto|EV",
     .min = -40.0,
     .max = 40.0,
     .word = "auto",
     .offset = offsetof(cli_output_options, exposure),
     .help = "Exposure of PNG files in stops; auto aims the average at middle grey. Printed, and "
             "kept in EXR files."},
    {.name = "view",
     .kind = CLI_CHOICE,
     .value = "VIEW",
     .choices = view_names,
     .offset = offsetof(cli_output_options, view),
     .help = "View transform of PNG files: neutral (Khronos PBR Neutral), standard (clip) or raw "
             "(clip, no sRGB curve); default neutral."},
    {.name = "half",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_output_options, half),
     .help = "Write EXR and KTX 2 channels with 16 bits instead of 32."},
};

cli_option_group cli_output_group(cli_output_options *options)
{
    return (cli_option_group){"Output", output_options,
                              sizeof output_options / sizeof output_options[0], options};
}

cli_option_group cli_picture_group(cli_output_options *options)
{
    const size_t count = sizeof output_options / sizeof output_options[0];
    return (cli_option_group){"Output", output_options + FIRST_PICTURE_OPTION,
                              count - FIRST_PICTURE_OPTION, options};
}

/* ---- checks before the work ---- */

static const char *name_of(const char *path)
{
    const char *const slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static const char *extension_of(const char *path)
{
    const char *const name = name_of(path), *const dot = strrchr(name, '.');
    return dot != NULL && dot != name ? dot : name + strlen(name);
}

bool cli_has_extension(const char *path, const char *extension)
{
    return strcasecmp(extension_of(path), extension) == 0;
}

void cli_output_name(const char *path, const char *extension, char *out, size_t size)
{
    const char *const name = name_of(path);
    snprintf(out, size, "%.*s%s", (int)(extension_of(path) - name), name, extension);
}

static bool extension_known(const char *path, const char *const *extensions)
{
    for (; *extensions != NULL; extensions++) {
        if (cli_has_extension(path, *extensions)) {
            return true;
        }
    }
    return false;
}

static cli_exit extension_failed(cli_host *host, const char *path, const char *const *extensions)
{
    char list[128] = "";
    size_t used = 0;
    for (size_t i = 0; extensions[i] != NULL && used < sizeof list; i++) {
        const char *const before = i == 0 ? "" : extensions[i + 1] == NULL ? " or " : ", ";
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", before, extensions[i]);
    }
    cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: expected an output that ends in %s", path,
            list);
    return CLI_USAGE;
}

/* Tries what saving will do: create a file beside the final one. */
static cli_exit check_writable(cli_host *host, const char *path)
{
    char probe[PATH_LENGTH_MAX];
    struct stat status;
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: cannot write: is a directory", path);
        return CLI_FAILED;
    }
    if ((size_t)snprintf(probe, sizeof probe, "%s.XXXXXX", path) >= sizeof probe) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%.60s...: cannot write: the name is too long",
                path);
        return CLI_FAILED;
    }
    const int file = mkstemp(probe);
    if (file < 0) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: cannot write: %s", path, strerror(errno));
        return CLI_FAILED;
    }
    close(file);
    unlink(probe);
    return CLI_OK;
}

cli_exit cli_output_check(cli_host *host, const cli_list *paths, const char *const *extensions)
{
    for (size_t i = 0; i < paths->count; i++) {
        if (!extension_known(paths->items[i], extensions)) {
            return extension_failed(host, paths->items[i], extensions);
        }
        for (size_t k = 0; k < i; k++) {
            if (strcmp(paths->items[i], paths->items[k]) == 0) {
                cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: given twice as an output",
                        paths->items[i]);
                return CLI_USAGE;
            }
        }
    }
    for (size_t i = 0; i < paths->count; i++) {
        const cli_exit result = check_writable(host, paths->items[i]);
        if (result != CLI_OK) {
            return result;
        }
    }
    return CLI_OK;
}

/* ---- attributes ---- */

static void add_attribute(cli_attributes *attributes, const char *name, bool image_only,
                          char *value)
{
    if (value == NULL || attributes->count == CLI_ATTRIBUTES_MAX) {
        attributes->failed = true;
        free(value);
        return;
    }
    attributes->items[attributes->count].name = name;
    attributes->items[attributes->count].value = value;
    attributes->items[attributes->count].image_only = image_only;
    attributes->count++;
}

void cli_attribute_add(cli_attributes *attributes, const char *name, bool image_only,
                       const char *format, ...)
{
    char value[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    add_attribute(attributes, name, image_only, strdup(value));
}

/* Appends one argument, in quotes where a shell would need them. */
static char *append_quoted(char *end, const char *text)
{
    if (text[0] != '\0' && strcspn(text, " \t\n'\"\\$`*?[]{}()<>|&;#!~") == strlen(text)) {
        return stpcpy(end, text);
    }
    *end++ = '\'';
    for (; *text != '\0'; text++) {
        end = *text == '\'' ? stpcpy(end, "'\\''") : stpncpy(end, text, 1);
    }
    return stpcpy(end, "'");
}

void cli_attribute_command(cli_attributes *attributes, const char *command, int argc,
                           char *const *argv)
{
    size_t size = sizeof "airlight " + strlen(command);
    for (int i = 0; i < argc; i++) {
        size += 4 * strlen(argv[i]) + 3;
    }
    char *const text = malloc(size);
    if (text != NULL) {
        char *end = stpcpy(stpcpy(text, "airlight "), command);
        for (int i = 0; i < argc; i++) {
            *end++ = ' ';
            end = append_quoted(end, argv[i]);
        }
    }
    add_attribute(attributes, "airlight:command", true, text);
}

void cli_attributes_cut(cli_attributes *attributes, size_t count)
{
    while (attributes->count > count) {
        free(attributes->items[--attributes->count].value);
    }
}

void cli_attributes_finish(cli_attributes *attributes)
{
    cli_attributes_cut(attributes, 0);
    *attributes = (cli_attributes){0};
}

static cli_exit set_attributes(cli_host *host, air_image *image, const cli_attributes *attributes,
                               float exposure_ev)
{
    char exposure[32];
    snprintf(exposure, sizeof exposure, "%.4f", (double)exposure_ev);
    air_status status = attributes->failed ? AIR_ERROR_MEMORY : AIR_OK;
    for (size_t i = 0; i < attributes->count && status == AIR_OK; i++) {
        status =
            air_image_set_attribute(image, attributes->items[i].name, attributes->items[i].value);
    }
    if (status == AIR_OK) {
        status = air_image_set_attribute(image, "airlight:exposure", exposure);
    }
    return cli_host_exit(host, status, "setting attributes");
}

/* ---- writing ---- */

float cli_output_exposure(const cli_output_options *options, const air_image *image)
{
    const bool given = options->exposure.set && !options->exposure.word;
    return given ? (float)options->exposure.value : air_image_auto_exposure(image);
}

cli_exit cli_output_image(cli_host *host, const cli_output_options *options, const char *path,
                          const air_image *image, float exposure_ev)
{
    air_image_save_params params;
    air_image_save_params_default(&params);
    params.half = options->half;
    params.auto_exposure = false;
    params.exposure_ev = exposure_ev;
    params.view = (air_view)options->view.value;
    return cli_host_exit(host, air_image_save(host->context, image, path, &params), path);
}

/* NAME.EXT becomes NAME.partial.EXT; false if that is too long. */
static bool partial_path(const char *path, char *out, size_t size)
{
    const char *const extension = extension_of(path);
    const int length = (int)(extension - path);
    return (size_t)snprintf(out, size, "%.*s.partial%s", length, path, extension) < size;
}

static void mean_of(const air_image *image, double out_mean[3])
{
    static const char *const names[3] = {"R", "G", "B"};
    const size_t pixels = air_image_width(image) * air_image_height(image);
    for (size_t c = 0; c < 3; c++) {
        const ptrdiff_t channel = air_image_find_channel(image, names[c]);
        double sum = 0.0;
        for (size_t i = 0; channel >= 0 && i < pixels; i++) {
            sum += (double)air_image_plane_const(image, (size_t)channel)[i];
        }
        out_mean[c] = sum / (double)pixels;
    }
}

cli_exit cli_output_film(cli_host *host, const cli_output_options *options, const air_film *film,
                         const cli_attributes *attributes, bool partial, cli_written *out_written)
{
    air_image *image = NULL;
    cli_exit result =
        cli_host_exit(host, air_film_resolve(film, NULL, &image), "resolving the film");
    if (result != CLI_OK) {
        return result;
    }
    const float exposure_ev = cli_output_exposure(options, image);
    result = set_attributes(host, image, attributes, exposure_ev);
    for (size_t i = 0; i < options->paths.count && result == CLI_OK; i++) {
        char other[PATH_LENGTH_MAX];
        const char *path = options->paths.items[i];
        if (partial && partial_path(path, other, sizeof other)) {
            path = other;
        } else if (partial) {
            continue;
        }
        result = cli_has_extension(path, ".film")
                     ? cli_host_exit(host, air_film_save(film, path), path)
                     : cli_output_image(host, options, path, image, exposure_ev);
    }
    if (result == CLI_OK) {
        out_written->exposure_ev = (double)exposure_ev;
        mean_of(image, out_written->mean);
    }
    air_image_destroy(image);
    return result;
}

void cli_output_remove_partial(const cli_output_options *options)
{
    for (size_t i = 0; i < options->paths.count; i++) {
        char path[PATH_LENGTH_MAX];
        if (partial_path(options->paths.items[i], path, sizeof path)) {
            unlink(path);
        }
    }
}

/* output.h: the files a command writes: the options about them, checks before the work, writing
 * after it. */
#ifndef AIR_CLI_OUTPUT_H
#define AIR_CLI_OUTPUT_H

#include <airlight/render.h>

#include "host.h"

typedef struct cli_output_options {
    cli_list paths;
    cli_real exposure; /* word: auto */
    cli_count view;
    bool half;
} cli_output_options;

enum { CLI_ATTRIBUTES_MAX = 24 };

/* String attributes for films and images; the values are owned here. */
typedef struct cli_attributes {
    size_t count;
    bool failed; /* memory ran out */
    struct {
        const char *name; /* static */
        char *value;
        bool image_only; /* differs between parts of one picture, which should merge to the bytes of
                            one run */
    } items[CLI_ATTRIBUTES_MAX];
} cli_attributes;

/* All of the options; and only those about pictures: --exposure, --view, --half. */
cli_option_group cli_output_group(cli_output_options *options);
cli_option_group cli_picture_group(cli_output_options *options);

/* True if `path` ends in `extension` (".exr"), in either case. */
bool cli_has_extension(const char *path, const char *extension);

/* NAME and the extension (".exr") for DIR/NAME.EXT: what goes into the current directory by
 * default.
 */
void cli_output_name(const char *path, const char *extension, char *out, size_t size);

/* Checks that each path has one of the extensions (NULL-terminated list) and is given once (exit
 * code 2), and that a file can be created there (1). */
cli_exit cli_output_check(cli_host *host, const cli_list *paths, const char *const *extensions);

void cli_attribute_add(cli_attributes *attributes, const char *name, bool image_only,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));
/* "airlight:command" as it could be typed again: the program, the subcommand and its arguments. */
void cli_attribute_command(cli_attributes *attributes, const char *command, int argc,
                           char *const *argv);
/* Drops those behind the first `count`. */
void cli_attributes_cut(cli_attributes *attributes, size_t count);
void cli_attributes_finish(cli_attributes *attributes);

typedef struct cli_written {
    double exposure_ev;
    double mean[3]; /* of R, G, B */
} cli_written;

/* The exposure to use for an image: the option's, else what auto exposure says. */
float cli_output_exposure(const cli_output_options *options, const air_image *image);

/* Writes the image to `path`, which is no .film. */
cli_exit cli_output_image(cli_host *host, const cli_output_options *options, const char *path,
                          const air_image *image, float exposure_ev);

/* Resolves the film and writes every output; images get the attributes and their exposure. Films
 * are saved as they are. With `partial`, everything goes to NAME.partial.EXT. */
cli_exit cli_output_film(cli_host *host, const cli_output_options *options, const air_film *film,
                         const cli_attributes *attributes, bool partial, cli_written *out_written);
/* Removes the files that cli_output_film wrote with `partial`. */
void cli_output_remove_partial(const cli_output_options *options);

#endif

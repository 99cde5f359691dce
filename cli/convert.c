#include <airlight/image.h>
#include <errno.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host.h"
#include "interrupt.h"
#include "output.h"
#include "scene_options.h"

extern char **environ;

#define CONVERTER "airlight-vdb2nvdb"

enum { PATH_LENGTH_MAX = 4096 };

static const char *const image_extensions[] = {".exr", ".png", ".pfm", ".ktx2", NULL};
static const char *const grid_extensions[] = {".nvdb", NULL};
static const char *const scene_extensions[] = {".glb", NULL};

static const cli_usage convert_usage = {
    .command = "convert",
    .arguments = "IN OUT",
    .summary =
        "Converts scenes (.gltf, .glb or Mitsuba's .xml, with all that belongs to them, to one "
        ".glb), images (.exr, .hdr, .png, .jpg, .pfm or .ktx2 to .exr, .png, .pfm or "
        ".ktx2) and density grids (.vdb to .nvdb, by the program " CONVERTER
        " of the optional OpenVDB part). Exposure and view default to what IN says: the "
        "exposure an EXR carries, none for pictures of 8 bits, else auto.",
    .examples = "  airlight convert scene.gltf whole.glb --medium visibility=50m\n"
                "  airlight convert room.exr room.png --exposure 1.5\n"
                "  airlight convert sky.hdr sky.exr --half\n"
                "  airlight convert lightmap-0.ktx2 lightmap-0.exr\n"
                "  airlight convert smoke.vdb smoke.nvdb\n",
    .argument_min = 2,
    .argument_max = 2,
};

typedef struct convert_options {
    const char *grid;
} convert_options;

static const cli_option convert_table[] = {
    {.name = "grid",
     .kind = CLI_TEXT,
     .value = "NAME",
     .offset = offsetof(convert_options, grid),
     .help = "Of a .vdb file convert only the grids of this name; default all."},
};

/* ---- images ---- */

static bool is_display_referred(const char *path)
{
    return cli_has_extension(path, ".png") || cli_has_extension(path, ".jpg") ||
           cli_has_extension(path, ".jpeg");
}

/* Fills in the exposure and view the user left open. */
static void choose_view(const char *path, const air_image *image, cli_output_options *options)
{
    const char *const stored = air_image_attribute(image, "airlight:exposure");
    double value = 0.0;
    const bool known =
        is_display_referred(path) || (stored != NULL && cli_read_real(stored, &value));
    if (!options->exposure.set && known) {
        options->exposure = (cli_real){.set = true, .value = value};
    }
    if (!options->view.set && is_display_referred(path)) {
        options->view = (cli_count){.set = true, .value = AIR_VIEW_STANDARD};
    }
}

static cli_exit convert_image(cli_host *host, const char *in, const char *out,
                              cli_output_options *options)
{
    air_image *image = NULL;
    cli_exit result = cli_host_exit(host, air_image_load(host->context, in, &image), in);
    if (result == CLI_OK) {
        choose_view(in, image, options);
        const float exposure_ev = cli_output_exposure(options, image);
        result = cli_output_image(host, options, out, image, exposure_ev);
        if (result == CLI_OK && cli_has_extension(out, ".png")) {
            cli_report(&host->progress, "wrote %s (exposure %+.2f EV)", out, (double)exposure_ev);
        } else if (result == CLI_OK) {
            cli_report(&host->progress, "wrote %s", out);
        }
    }
    air_image_destroy(image);
    return result;
}

/* ---- grids ---- */

/* The converter beside this program, "" if there is none; the system's PATH is searched then. */
static void find_beside(char *out, size_t size)
{
    const size_t room = size - sizeof CONVERTER;
    const ssize_t length = readlink("/proc/self/exe", out, room);
    out[length > 0 ? length : 0] = '\0';
    char *const slash = strrchr(out, '/');
    if (slash != NULL) {
        strcpy(slash + 1, CONVERTER);
    }
    if (slash == NULL || access(out, X_OK) != 0) {
        out[0] = '\0';
    }
}

static cli_exit converter_missing(cli_host *host, const char *in)
{
    cli_say(&host->progress, AIR_MESSAGE_ERROR,
            "%s: .vdb files are read by the program " CONVERTER
            ", which is neither beside airlight nor on PATH: build airlight with OpenVDB installed "
            "(libopenvdb-dev)",
            in);
    return CLI_FAILED;
}

static cli_exit run_converter(cli_host *host, const char *in, const char *out, const char *grid)
{
    char program[PATH_LENGTH_MAX];
    pid_t child;
    int status = 0;
    find_beside(program, sizeof program);
    const char *const name = program[0] != '\0' ? program : CONVERTER;
    char *const arguments[] = {CONVERTER, (char *)in, (char *)out, (char *)grid, NULL};
    const int error = posix_spawnp(&child, name, NULL, NULL, arguments, environ);
    if (error == ENOENT) {
        return converter_missing(host, in);
    }
    if (error != 0) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: cannot start: %s", name, strerror(error));
        return CLI_FAILED;
    }
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) {
            cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: cannot wait for it: %s", name,
                    strerror(errno));
            return CLI_FAILED;
        }
    }
    if (cli_interrupt_pending()) {
        return CLI_INTERRUPTED;
    }
    /* 127 is how some systems report a program that cannot be found. */
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
        return converter_missing(host, in);
    }
    if (!WIFEXITED(status)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: " CONVERTER " was ended by signal %d", in,
                WTERMSIG(status));
    }
    /* Any other failure it has explained itself. */
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? CLI_OK : CLI_FAILED;
}

/* The converter writes beside OUT and renames, so that OUT appears whole or not at all. */
static cli_exit convert_grid(cli_host *host, const char *in, const char *out, const char *grid)
{
    if (access(in, R_OK) != 0) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: cannot read: %s", in, strerror(errno));
        return CLI_FAILED;
    }
    const cli_exit result = run_converter(host, in, out, grid);
    if (result == CLI_OK) {
        cli_report(&host->progress, "wrote %s", out);
    }
    return result;
}

/* ---- scenes ---- */

static bool is_scene(const char *path)
{
    return cli_has_extension(path, ".gltf") || cli_has_extension(path, ".glb") ||
           cli_has_extension(path, ".xml");
}

static bool is_same_file(const char *a, const char *b)
{
    struct stat status_a, status_b;
    return stat(a, &status_a) == 0 && stat(b, &status_b) == 0 &&
           status_a.st_dev == status_b.st_dev && status_a.st_ino == status_b.st_ino;
}

static cli_exit convert_scene(cli_host *host, const char *in, const char *out,
                              const cli_scene_options *options)
{
    const int64_t frame = options->frame.set ? (int64_t)options->frame.value : AIR_FRAME_NONE;
    air_scene *scene = NULL;
    if (!is_scene(in)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "%s: expected a scene that ends in .gltf, .glb or .xml", in);
        return CLI_USAGE;
    }
    if (is_same_file(in, out)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: is the scene itself: choose another name",
                out);
        return CLI_USAGE;
    }
    cli_exit result = cli_scene_load(host, in, options, frame, &scene);
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_scene_save(host->context, scene, out), out);
    }
    if (result == CLI_OK) {
        cli_report(&host->progress, "wrote %s", out);
    }
    air_scene_destroy(scene);
    return result;
}

/* ---- the command ---- */

typedef struct convert_run {
    convert_options options;
    cli_scene_options scene;
    cli_output_options output;
    cli_host_options host_options;
    cli_host host;
} convert_run;

static cli_exit run_convert(convert_run *run, const char *in, const char *out)
{
    cli_host *const host = &run->host;
    const bool grid = cli_has_extension(in, ".vdb");
    const bool scene = is_scene(in) || cli_has_extension(out, ".glb");
    const cli_list paths = {.count = 1, .items = {out}};
    cli_exit result = cli_host_open(host, &run->host_options);
    if (result != CLI_OK) {
        return result;
    }
    if (cli_has_extension(in, ".film")) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "%s: films become pictures by airlight merge %s -o %s", in, in, out);
        return CLI_USAGE;
    }
    result = cli_output_check(host, &paths,
                              scene  ? scene_extensions
                              : grid ? grid_extensions
                                     : image_extensions);
    if (result != CLI_OK) {
        return result;
    }
    if (scene) {
        return convert_scene(host, in, out, &run->scene);
    }
    return grid ? convert_grid(host, in, out, run->options.grid)
                : convert_image(host, in, out, &run->output);
}

cli_exit cli_convert(int argc, char **argv)
{
    convert_run run = {.options = {.grid = NULL}};
    const cli_option_group groups[] = {
        cli_scene_group(&run.scene),
        cli_picture_group(&run.output),
        {"Grids", convert_table, sizeof convert_table / sizeof convert_table[0], &run.options},
        cli_host_group(&run.host_options),
    };
    const cli_parsed parsed =
        cli_parse(&convert_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed != CLI_PARSED) {
        return parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    const cli_exit result = run_convert(&run, argv[0], argv[1]);
    cli_host_close(&run.host);
    return result;
}

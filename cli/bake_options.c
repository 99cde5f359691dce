#include "bake_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const media_names[] = {"none",  "attenuate", "impulse",
                                          "exact", "reference", NULL};
static const char *const quality_names[] = {"draft", "medium", "high", NULL};
static const uint32_t quality_samples[] = {32, 256, 1024};
static const char *const show_names[] = {"emissive", "lightmap", "coordinates", NULL};
static const char *const uv_names[] = {"auto", "file", "unwrap", NULL};
enum { TARGET_LIGHTMAP, TARGET_VERTICES };
static const char *const target_names[] = {"lightmap", "vertices", NULL};

static const cli_option light_options[] = {
    {.name = "media",
     .kind = CLI_CHOICE,
     .value = "MODE",
     .choices = media_names,
     .offset = offsetof(cli_bake_options, media),
     .help =
         "What media do to light: none, attenuate, impulse (responses of infinite media), exact "
         "(the default), reference (volumetric path tracing of every texel)."},
    {.name = "spp",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 65536,
     .offset = offsetof(cli_bake_options, spp),
     .help = "Samples of each texel, vertex and probe; default 256."},
    {.name = "quality",
     .kind = CLI_CHOICE,
     .value = "NAME",
     .choices = quality_names,
     .offset = offsetof(cli_bake_options, quality),
     .help = "Sets --spp: draft (32), medium (256), high (1024)."},
    {.name = "bounces",
     .kind = CLI_COUNT,
     .value = "N",
     .max = 4294967294.0,
     .offset = offsetof(cli_bake_options, bounces),
     .help = "Events on surfaces and in media before light reaches a receiver; 0: direct light "
             "only; default: no limit."},
    {.name = "seed",
     .kind = CLI_COUNT,
     .value = "N",
     .max = 9007199254740992.0,
     .offset = offsetof(cli_bake_options, seed),
     .help = "Another seed gives other noise; default 0."},
    {.name = "cache-resolution",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 2,
     .max = 128,
     .offset = offsetof(cli_bake_options, cache_resolution),
     .help = "Of --media exact: points of cached light along the longest side of each medium; "
             "default: 8 to 64, so that they have about a fortieth of the samples."},
    {.name = "cache-samples",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 16,
     .max = 65536,
     .offset = offsetof(cli_bake_options, cache_samples),
     .help = "Likewise, samples of each of these points; default: 32 to 1024."},
    {.name = "impulse-bounces",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = AIR_IMPULSE_BOUNCES_MAX,
     .offset = offsetof(cli_bake_options, impulse_bounces),
     .help = "Of --media impulse: events in media that are summed; default 10."},
    {.name = "impulse-tables",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(cli_bake_options, impulse_tables),
     .help = "Of --media impulse: tables as `airlight table build impulse` writes them; default: "
             "made anew, in some seconds."},
    {.name = "impulse-literal",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, impulse_literal),
     .help = "Of --media impulse: tables, forms and rules as the paper has them, for comparison."},
};

static const cli_option map_options[] = {
    {.name = "targets",
     .kind = CLI_SET,
     .value = "LIST",
     .choices = target_names,
     .offset = offsetof(cli_bake_options, targets),
     .help = "What is baked, with commas between: lightmap, vertices; default lightmap, but with "
             "--probes only these."},
    {.name = "uv",
     .kind = CLI_CHOICE,
     .value = "CHOICE",
     .choices = uv_names,
     .offset = offsetof(cli_bake_options, uv),
     .help = "Where lightmap coordinates come from: auto (TEXCOORD_1 where a mesh has one without "
             "overlaps, else unwrapped), file, unwrap; default auto."},
    {.name = "texels-per-metre",
     .kind = CLI_REAL,
     .value = "D",
     .min = 1e-6,
     .max = 1e6,
     .offset = offsetof(cli_bake_options, texels_per_metre),
     .help = "Density of texels on surfaces; default 16."},
    {.name = "mesh-size",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 4,
     .max = 16384,
     .offset = offsetof(cli_bake_options, mesh_size),
     .help = "Texels along each side of the square that a mesh's own TEXCOORD_1 span, in place of "
             "a density."},
    {.name = "page-size",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 16,
     .max = 16384,
     .offset = offsetof(cli_bake_options, page_size),
     .help = "Most texels along a side of a page; default 2048."},
    {.name = "padding",
     .kind = CLI_COUNT,
     .value = "N",
     .max = 64,
     .offset = offsetof(cli_bake_options, padding),
     .help = "Texels between charts, and between meshes; default 4."},
    {.name = "chart-angle",
     .kind = CLI_REAL,
     .value = "DEGREES",
     .min = 1,
     .max = 80,
     .offset = offsetof(cli_bake_options, chart_angle),
     .help = "Unwrapping: how far normals of a chart stray from its mean; default 40."},
    {.name = "directional",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, directional),
     .help = "Keep which way light comes from: bands 0 and 1 of the incident radiance, for normal "
             "maps."},
    {.name = "dilate",
     .kind = CLI_COUNT,
     .value = "N",
     .max = 16384,
     .word = "all",
     .offset = offsetof(cli_bake_options, dilate),
     .help = "Texels by which charts are continued into what is around them, or \"all\"; default "
             "8."},
    {.name = "no-final-gather",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, no_final_gather),
     .help = "Trace paths to their end instead of ending them in the light of a first pass."},
    {.name = "no-denoise",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, no_denoise),
     .help = "Leave the noise of samples as it is."},
    {.name = "no-stitch",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, no_stitch),
     .help = "Leave texels along seams as they are."},
};

static const cli_option probe_options[] = {
    {.name = "probes",
     .kind = CLI_LIST,
     .value = "SPEC",
     .offset = offsetof(cli_bake_options, probes),
     .help = "Probes: auto=SPACING (metres; over the scene's bounds), grid=X,Y,Z:X,Y,Z:NX,NY,NZ "
             "(corners and counts), or a text file of positions, three numbers a line. "
             "Repeatable."},
};

static const cli_option file_options[] = {
    {.name = "output",
     .letter = 'o',
     .kind = CLI_TEXT,
     .value = "DIR",
     .offset = offsetof(cli_bake_options, output),
     .help = "The folder for lightmap.json and what belongs to it; default NAME.lightmap in the "
             "current directory."},
    {.name = "gltf",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(cli_bake_options, gltf),
     .help = "Also a copy of the scene that shows the light, .glb or .gltf."},
    {.name = "gltf-show",
     .kind = CLI_CHOICE,
     .value = "HOW",
     .choices = show_names,
     .offset = offsetof(cli_bake_options, gltf_show),
     .help =
         "How that copy shows it: emissive (every viewer), lightmap (MOZ_lightmap), coordinates "
         "(TEXCOORD_1 only, for engines); default emissive."},
    {.name = "godot",
     .kind = CLI_TEXT,
     .value = "DIR",
     .offset = offsetof(cli_bake_options, godot),
     .help = "Also the files of Godot's LightmapGI."},
    {.name = "bevy",
     .kind = CLI_TEXT,
     .value = "DIR",
     .offset = offsetof(cli_bake_options, bevy),
     .help = "Also KTX 2 images and rectangles for Bevy."},
    {.name = "rgbm",
     .kind = CLI_TEXT,
     .value = "DIR",
     .offset = offsetof(cli_bake_options, rgbm),
     .help = "Also pages as PNG of colour and multiplier."},
    {.name = "rgbm-range",
     .kind = CLI_REAL,
     .value = "R",
     .min = 1e-6,
     .max = 1e6,
     .offset = offsetof(cli_bake_options, rgbm_range),
     .help = "The largest value these hold; default: the largest there is."},
    {.name = "full",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, full),
     .help = "Pages in 32-bit floats; default 16 bits."},
    {.name = "no-resume",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_bake_options, no_resume),
     .help = "Begin anew where an interrupted bake of the same could go on."},
};

#define COUNT(table) (sizeof(table) / sizeof(table)[0])

void cli_bake_groups(cli_bake_options *options, cli_option_group *groups)
{
    groups[0] = (cli_option_group){"Light", light_options, COUNT(light_options), options};
    groups[1] = (cli_option_group){"Lightmap", map_options, COUNT(map_options), options};
    groups[2] = (cli_option_group){"Probes", probe_options, COUNT(probe_options), options};
    groups[3] = (cli_option_group){"Files", file_options, COUNT(file_options), options};
}

/* ---- probes ---- */

static cli_exit bad_probes(cli_host *host, const char *spec, const char *expected)
{
    cli_say(&host->progress, AIR_MESSAGE_ERROR, "--probes %s: expected %s", spec, expected);
    return CLI_USAGE;
}

/* Reads "X,Y,Z"; *text is moved behind it. */
static bool read_triple(const char **text, double out[3])
{
    for (int k = 0; k < 3; k++) {
        char *end;
        out[k] = strtod(*text, &end);
        if (end == *text || (k < 2 && *end != ',')) {
            return false;
        }
        *text = k < 2 ? end + 1 : end;
    }
    return true;
}

static cli_exit read_grid(cli_host *host, const char *spec, air_probe_request *out)
{
    static const char expected[] =
        "grid=X,Y,Z:X,Y,Z:NX,NY,NZ with two corners and a count along each axis";
    const char *at = spec + strlen("grid=");
    double low[3], high[3], counts[3];
    if (!read_triple(&at, low) || *at++ != ':' || !read_triple(&at, high) || *at++ != ':' ||
        !read_triple(&at, counts) || *at != '\0') {
        return bad_probes(host, spec, expected);
    }
    out->kind = AIR_PROBES_GRID;
    for (int k = 0; k < 3; k++) {
        const bool whole =
            counts[k] >= 1.0 && counts[k] <= 1e6 && counts[k] == (double)(size_t)counts[k];
        if (!whole) {
            return bad_probes(host, spec, expected);
        }
        out->size[k] = (size_t)counts[k];
        out->origin[k] = (float)low[k];
        out->step[k][k] = out->size[k] > 1 ? (float)((high[k] - low[k]) / (counts[k] - 1.0)) : 0.0f;
    }
    return CLI_OK;
}

/* Appends the three numbers of a line; blank lines and those that begin with # are skipped. */
static cli_exit read_line(cli_host *host, const char *path, size_t number, const char *line,
                          float **positions, size_t *count)
{
    double at[3];
    char rest;
    if (strspn(line, " \t\r\n") == strlen(line) || line[strspn(line, " \t")] == '#') {
        return CLI_OK;
    }
    if (sscanf(line, "%lf%*[ ,\t]%lf%*[ ,\t]%lf %c", &at[0], &at[1], &at[2], &rest) != 3) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "%s: line %zu: expected three numbers, a position in metres", path, number);
        return CLI_FAILED;
    }
    if ((*count & (*count - 1)) == 0) {
        float *grown = realloc(*positions, (*count > 0 ? 2 * *count : 1) * 3 * sizeof *grown);
        if (grown == NULL) {
            return cli_host_exit(host, AIR_ERROR_MEMORY, path);
        }
        *positions = grown;
    }
    for (size_t k = 0; k < 3; k++) {
        (*positions)[3 * *count + k] = (float)at[k];
    }
    ++*count;
    return CLI_OK;
}

/* The next line; of one that is longer than any position, its beginning. */
static bool next_line(FILE *file, char *line, int size)
{
    if (fgets(line, size, file) == NULL) {
        return false;
    }
    if (strchr(line, '\n') == NULL) {
        for (int c = fgetc(file); c != EOF && c != '\n';) {
            c = fgetc(file);
        }
    }
    return true;
}

static cli_exit read_positions(cli_host *host, const char *path, air_probe_request *out,
                               float **positions)
{
    char line[512];
    size_t number = 0;
    cli_exit result = CLI_OK;
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        return bad_probes(host, path, "auto=SPACING, grid=..., or a file that can be read");
    }
    while (result == CLI_OK && next_line(file, line, sizeof line)) {
        result = read_line(host, path, ++number, line, positions, &out->count);
    }
    fclose(file);
    out->kind = AIR_PROBES_FREE;
    out->positions = *positions;
    if (result == CLI_OK && out->count == 0) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: no position in it", path);
        return CLI_FAILED;
    }
    return result;
}

static cli_exit read_probes(cli_host *host, const char *spec, size_t index, cli_probes *probes)
{
    air_probe_request *out = &probes->requests[index];
    double spacing;
    out->name = spec;
    if (strncmp(spec, "auto=", 5) == 0) {
        if (!cli_read_real(spec + 5, &spacing) || !(spacing > 0.0)) {
            return bad_probes(host, spec, "auto=SPACING with a positive number of metres");
        }
        out->kind = AIR_PROBES_AUTO;
        out->spacing = (float)spacing;
        return CLI_OK;
    }
    return strncmp(spec, "grid=", 5) == 0
               ? read_grid(host, spec, out)
               : read_positions(host, spec, out, &probes->positions[index]);
}

void cli_probes_finish(cli_probes *probes)
{
    for (size_t i = 0; i < CLI_LIST_MAX; i++) {
        free(probes->positions[i]);
        probes->positions[i] = NULL;
    }
}

/* ---- parameters ---- */

static void set_count(uint32_t *out, const cli_count *option)
{
    *out = option->set ? (uint32_t)option->value : *out;
}

static void set_real(float *out, const cli_real *option)
{
    *out = option->set ? (float)option->value : *out;
}

cli_exit cli_bake_params(cli_host *host, const cli_bake_options *options, cli_probes *probes,
                         air_bake_params *params)
{
    const uint64_t targets = options->targets.set        ? options->targets.value
                             : options->probes.count > 0 ? 0
                                                         : 1u << TARGET_LIGHTMAP;
    cli_exit result = CLI_OK;
    air_bake_params_default(params);
    if (options->quality.set) {
        params->samples = quality_samples[options->quality.value];
    }
    set_count(&params->samples, &options->spp);
    set_count(&params->max_bounces, &options->bounces);
    set_count(&params->cache_resolution, &options->cache_resolution);
    set_count(&params->cache_samples, &options->cache_samples);
    set_count(&params->mesh_size, &options->mesh_size);
    set_count(&params->page_size, &options->page_size);
    set_count(&params->padding, &options->padding);
    set_count(&params->dilate, &options->dilate);
    set_real(&params->texels_per_metre, &options->texels_per_metre);
    params->seed = options->seed.set ? options->seed.value : params->seed;
    params->media = options->media.set ? (air_bake_media)options->media.value : params->media;
    params->uv = options->uv.set ? (air_bake_uv)options->uv.value : params->uv;
    params->impulse_bounces = options->impulse_bounces.set ? (int)options->impulse_bounces.value
                                                           : params->impulse_bounces;
    params->impulse_literal = options->impulse_literal;
    if (options->chart_angle.set) {
        params->chart_angle_rad = (float)(options->chart_angle.value * 0.017453292519943295);
    }
    if (options->dilate.word) {
        params->dilate = UINT32_MAX;
    }
    params->lightmaps = ((targets >> TARGET_LIGHTMAP) & 1u) != 0;
    params->vertices = ((targets >> TARGET_VERTICES) & 1u) != 0;
    params->directional = options->directional;
    params->final_gather = !options->no_final_gather;
    params->denoise = !options->no_denoise;
    params->stitch = !options->no_stitch;
    params->resume = !options->no_resume;
    if (params->mesh_size > params->page_size) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "--mesh-size %u: expected at most the page size, %u (--page-size)",
                params->mesh_size, params->page_size);
        return CLI_USAGE;
    }
    for (size_t i = 0; i < options->probes.count && result == CLI_OK; i++) {
        result = read_probes(host, options->probes.items[i], i, probes);
    }
    probes->count = options->probes.count;
    params->probes = probes->requests;
    params->probe_count = probes->count;
    return result;
}

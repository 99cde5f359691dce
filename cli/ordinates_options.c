#include "ordinates_options.h"

#include <airlight/ordinates_dom.h>

enum { POLAR_MAX = 64 };

static const cli_option ordinates_options[] = {
    {.name = "cells",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 2,
     .max = 256,
     .offset = offsetof(cli_ordinates_options, cells),
     .help = "Along the longest side of the media's bounds; the others have cubes of that size. "
             "--quality chooses 20, 24, 32 or 48."},
    {.name = "directions",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 4096,
     .offset = offsetof(cli_ordinates_options, directions),
     .help = "From which each environment shines; by --quality 128, 128, 128 or 256."},
    {.name = "patches",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 4096,
     .offset = offsetof(cli_ordinates_options, patches),
     .help = "Points of light for each lamp with an area, and for what surfaces reflect; by "
             "--quality 16, 32, 64 or 256."},
    {.name = "bands",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = AIR_DOM_BANDS_MAX,
     .offset = offsetof(cli_ordinates_options, bands),
     .help = "Of dom and shdom: orders of spherical harmonics that scattered light keeps; by "
             "--quality 4, 4, 7 or 8; 7 too in place of 4 where a mean cosine is above 0.9."},
    {.name = "angles",
     .kind = CLI_COUNTS,
     .value = "PxA",
     .expected = "PxA: an even number of at least --bands, and a multiple of 4 of at least twice "
                 "as many",
     .min = 1,
     .max = 128,
     .length = 2,
     .separator = 'x',
     .offset = offsetof(cli_ordinates_options, angles),
     .help = "Of dom and shdom: directions that scattered light is followed in, P from pole to "
             "pole by A around; default the least that --bands needs."},
    {.name = "sweeps",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 4294967295.0,
     .offset = offsetof(cli_ordinates_options, sweeps),
     .help = "Of dom and shdom: through all cells, at most; by --quality 8, 16, 64 or 256."},
    {.name = "steps",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 4096,
     .offset = offsetof(cli_ordinates_options, steps),
     .help = "Of cm, six and literal: from cell to cell, at most; by --quality 20, 24, 32 or 48."},
    {.name = "march",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 64,
     .offset = offsetof(cli_ordinates_options, march),
     .help = "Looks at the media per cell along camera rays; by --quality 1, 2, 2 or 2."},
    {.name = "no-prefilter",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_ordinates_options, no_prefilter),
     .help = "Directions stand for points of the sky, not for the parts about them."},
    {.name = "importance",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_ordinates_options, importance),
     .help = "Choose directions of the sky also by what the camera sees of them."},
    {.name = "no-residuum",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_ordinates_options, no_residuum),
     .help = "Of cm, six and literal: drop light that is still under way after --steps."},
    {.name = "no-bilateral",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_ordinates_options, no_bilateral),
     .help = "Take light from cells by their distance alone, not from those of like density, which "
             "keeps it from bleeding over sharp edges of media."},
};

cli_option_group cli_ordinates_group(cli_ordinates_options *options)
{
    return (cli_option_group){"Light in a grid (method ordinates)", ordinates_options,
                              sizeof ordinates_options / sizeof ordinates_options[0], options};
}

cli_exit cli_ordinates_check(const cli_ordinates_options *options, int quality_bands)
{
    const uint64_t *const angles = options->angles.value;
    const uint64_t least = quality_bands > 0 ? (uint64_t)quality_bands : 2; /* whatever the media */
    const uint64_t bands = options->bands.set ? options->bands.value : least;
    const uint64_t polar = (bands + 1) / 2 * 2, azimuths = (2 * bands + 3) / 4 * 4;
    if (!options->angles.set) {
        return CLI_OK;
    }
    if (angles[0] % 2 != 0 || angles[0] < polar || angles[0] > POLAR_MAX || angles[1] % 4 != 0 ||
        angles[1] < azimuths) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "--angles: expected for %llu bands PxA with P even, %llu to 64, and A a multiple "
                "of 4, %llu to 128, got %llux%llu",
                (unsigned long long)bands, (unsigned long long)polar, (unsigned long long)azimuths,
                (unsigned long long)angles[0], (unsigned long long)angles[1]);
        return CLI_USAGE;
    }
    return CLI_OK;
}

static void set_count(const cli_count *option, uint32_t *out)
{
    if (option->set) {
        *out = (uint32_t)option->value;
    }
}

void cli_ordinates_set(const cli_ordinates_options *options, air_ordinates_settings *settings)
{
    set_count(&options->cells, &settings->cells);
    set_count(&options->directions, &settings->directions);
    set_count(&options->patches, &settings->patches);
    set_count(&options->sweeps, &settings->sweeps);
    set_count(&options->steps, &settings->steps);
    set_count(&options->march, &settings->march);
    if (options->bands.set) {
        settings->bands = (int)options->bands.value;
    }
    if (options->angles.set) {
        settings->polar = (int)options->angles.value[0];
        settings->azimuths = (int)options->angles.value[1];
    }
    settings->prefilter = settings->prefilter && !options->no_prefilter;
    settings->importance = settings->importance || options->importance;
    settings->residuum = settings->residuum && !options->no_residuum;
    settings->bilateral = settings->bilateral && !options->no_bilateral;
}

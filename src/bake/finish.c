#include "bake/finish.h"

#include <string.h>

/* Channels: R, G, B, three layers of three, four coefficients of three, coverage. */
enum {
    CHANNEL_SUM = 0,
    CHANNEL_LAYERS = 3,
    CHANNEL_COEFFICIENTS = 12,
    CHANNEL_COVERAGE_PLAIN = 12,
    CHANNEL_COVERAGE_DIRECTIONAL = 24,
    CHANNELS_MOST = 25
};

static const char *const names[CHANNELS_MOST] = {
    "R",          "G",          "B",       "direct.R",  "direct.G", "direct.B", "indirect.R",
    "indirect.G", "indirect.B", "media.R", "media.G",   "media.B",  "L0.R",     "L0.G",
    "L0.B",       "L1.y.R",     "L1.y.G",  "L1.y.B",    "L1.z.R",   "L1.z.G",   "L1.z.B",
    "L1.x.R",     "L1.x.G",     "L1.x.B",  "coverage.Y"};

/* At least so much of a texel's samples must be outside of solid things. */
#define VALID_SHARE 0.5f

static air_status make_image(air_context *context, const air_bake_page *page, bool directional,
                             air_image **out_image)
{
    const char *list[CHANNELS_MOST];
    size_t count = directional ? CHANNEL_COVERAGE_DIRECTIONAL : CHANNEL_COVERAGE_PLAIN;
    memcpy(list, names, sizeof list);
    list[count] = names[CHANNEL_COVERAGE_DIRECTIONAL];
    return air_image_create(context, page->width, page->height, count + 1, list, out_image);
}

/* Scatters records into planes. */
static size_t write_planes(const air_texel_sites *sites, const air_site_list *list,
                           bool directional, air_image *image)
{
    const size_t coverage = directional ? CHANNEL_COVERAGE_DIRECTIONAL : CHANNEL_COVERAGE_PLAIN;
    size_t invalid = 0;
    for (size_t i = 0; i < sites->count; i++) {
        const float *record = list->records + i * air_site_stride(list);
        const uint32_t texel = sites->texels[i], width = sites->page->width;
        if (record[AIR_SITE_VALIDITY] < VALID_SHARE) {
            invalid++;
            continue;
        }
        for (size_t c = 0; c < 3; c++) {
            float sum = 0.0f;
            for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
                const float value = record[AIR_SITE_LIGHT + 3 * layer + c];
                air_image_plane(image, CHANNEL_LAYERS + 3 * layer + c)[texel] = value;
                sum += value;
            }
            air_image_plane(image, CHANNEL_SUM + c)[texel] = sum;
        }
        for (size_t k = 0; k < (size_t)3 * list->coefficients; k++) {
            air_image_plane(image, CHANNEL_COEFFICIENTS + k)[texel] =
                record[AIR_SITE_HARMONICS + k];
        }
        air_image_plane(image, coverage)[texel] =
            air_coverage_area(sites->page->coverage, texel % width, texel / width);
    }
    return invalid;
}

air_status air_bake_finish(air_context *context, const air_bake_params *params,
                           const air_texel_sites *sites, const air_site_list *list,
                           air_image **out_image, size_t *out_invalid)
{
    air_image *image = NULL;
    const air_status status = make_image(context, sites->page, params->directional, &image);
    if (status == AIR_OK) {
        *out_invalid = write_planes(sites, list, params->directional, image);
    }
    *out_image = image;
    return status;
}

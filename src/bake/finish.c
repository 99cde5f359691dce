#include "bake/finish.h"

#include <string.h>

#include "atlas/denoise.h"
#include "atlas/dilate.h"
#include "atlas/seams.h"
#include "scene/surface.h"

/* Channels: R, G, B; layer by layer; albedo; coverage; bands 0 and 1 of the radiance. */
enum {
    CHANNEL_SUM = 0,
    CHANNEL_LAYERS = 3,
    CHANNEL_ALBEDO = 12,
    CHANNEL_COVERAGE = 15,
    CHANNEL_COEFFICIENTS = 16,
    CHANNELS_PLAIN = 16,
    CHANNELS_DIRECTIONAL = 28
};

static const char *const names[CHANNELS_DIRECTIONAL] = {
    "R",          "G",          "B",       "direct.R", "direct.G", "direct.B", "indirect.R",
    "indirect.G", "indirect.B", "media.R", "media.G",  "media.B",  "albedo.R", "albedo.G",
    "albedo.B",   "coverage.Y", "L0.R",    "L0.G",     "L0.B",     "L1.y.R",   "L1.y.G",
    "L1.y.B",     "L1.z.R",     "L1.z.G",  "L1.z.B",   "L1.x.R",   "L1.x.G",   "L1.x.B"};

/* ---- what a texel shows ---- */

/* Position, normal and diffuse albedo in the middle of what is covered of a texel. */
typedef struct texel_place {
    air_surface_place place;
    air_vec3 albedo;
} texel_place;

static bool place_of(const air_texel_sites *sites, uint32_t texel, texel_place *out)
{
    const air_bake_page *page = sites->page;
    const uint32_t x = texel % page->width, y = texel / page->width;
    const double middle[2] = {0.5, 0.5};
    air_coverage_point point;
    if (!air_coverage_centre(page->coverage, x, y, &point) &&
        !air_coverage_draw(page->coverage, x, y, middle, &point)) {
        return false;
    }
    air_hit hit = air_texel_hit(page, &point);
    const air_mesh *mesh = sites->snapshot->meshes[hit.mesh];
    if (!air_surface_place_make(mesh, hit.triangle, hit.u, hit.v, &out->place)) {
        return false;
    }
    air_surface surface;
    vec3_store(hit.normal, mesh->flip ? vec3_neg(out->place.geometric) : out->place.geometric);
    air_surface_make(sites->snapshot, &hit, vec3_neg(out->place.geometric), &surface);
    out->albedo = surface.bsdf.diffuse;
    return true;
}

/* ---- planes ---- */

static float *plane(air_image *image, size_t channel) { return air_image_plane(image, channel); }

static void store_color(air_image *image, size_t channel, uint32_t texel, air_vec3 value)
{
    plane(image, channel)[texel] = value.x;
    plane(image, channel + 1)[texel] = value.y;
    plane(image, channel + 2)[texel] = value.z;
}

/* Guides of the denoiser, and the variance of each layer's channels: of their luminance, which is
 * what is measured, by the square of their share in it. */
typedef struct guide_planes {
    float *position[3], *normal[3], *variance[AIR_LAYER_COUNT][3];
} guide_planes;

enum { GUIDE_PLANES = 6 + 3 * AIR_LAYER_COUNT };

static void store_variance(const guide_planes *guides, const float *record, uint32_t texel)
{
    for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        const float *light = record + AIR_SITE_LIGHT + 3 * layer;
        const float luminance = vec3_luminance(vec3_load(light));
        for (size_t c = 0; c < 3; c++) {
            const float ratio = luminance > 0.0f ? light[c] / luminance : 1.0f;
            guides->variance[layer][c][texel] =
                record[AIR_SITE_VARIANCE + layer] * float_max(ratio * ratio, 0.01f);
        }
    }
}

static void store_texel(const air_texel_sites *sites, const air_site_list *list, size_t site,
                        const guide_planes *guides, air_finished_page *out)
{
    const float *record = list->records + site * air_site_stride(list);
    const uint32_t texel = sites->texels[site], width = sites->page->width;
    texel_place at;
    if (record[AIR_SITE_VALIDITY] < AIR_SITE_VALID_SHARE || !place_of(sites, texel, &at)) {
        out->charts[texel] = AIR_NO_CHART;
        out->invalid++;
        return;
    }
    for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        store_color(out->image, CHANNEL_LAYERS + 3 * layer, texel,
                    vec3_load(record + AIR_SITE_LIGHT + 3 * layer));
    }
    store_color(out->image, CHANNEL_ALBEDO, texel, at.albedo);
    for (size_t k = 0; k < (size_t)3 * list->coefficients; k++) {
        plane(out->image, CHANNEL_COEFFICIENTS + k)[texel] = record[AIR_SITE_HARMONICS + k];
    }
    plane(out->image, CHANNEL_COVERAGE)[texel] =
        air_coverage_area(sites->page->coverage, texel % width, texel / width);
    const float p[3] = {at.place.position.x, at.place.position.y, at.place.position.z};
    const float n[3] = {at.place.normal.x, at.place.normal.y, at.place.normal.z};
    for (int k = 0; k < 3; k++) {
        guides->position[k][texel] = p[k];
        guides->normal[k][texel] = n[k];
    }
    store_variance(guides, record, texel);
}

static void lay_guides(float *block, size_t texels, guide_planes *out)
{
    for (size_t k = 0; k < 3; k++) {
        out->position[k] = block + k * texels;
        out->normal[k] = block + (3 + k) * texels;
        for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
            out->variance[layer][k] = block + (6 + 3 * layer + k) * texels;
        }
    }
}

/* ---- steps ---- */

static air_atlas_guides guides_of(const air_bake_page *page, const guide_planes *guides,
                                  const air_finished_page *out)
{
    return (air_atlas_guides){
        .width = page->width,
        .height = page->height,
        .charts = out->charts,
        .position = {guides->position[0], guides->position[1], guides->position[2]},
        .normal = {guides->normal[0], guides->normal[1], guides->normal[2]},
        .area = plane(out->image, CHANNEL_COVERAGE)};
}

/* All layers with the same weights, which come from all of them: that is better for each than
 * weights of its own (src/atlas/README.md). */
static air_status denoise(air_context *context, const air_bake_page *page,
                          const guide_planes *guides, const air_finished_page *out)
{
    enum { PLANES = 3 * AIR_LAYER_COUNT };
    air_atlas_denoise_params params;
    const air_atlas_guides atlas = guides_of(page, guides, out);
    float *planes[PLANES];
    const float *variance[PLANES];
    for (size_t k = 0; k < PLANES; k++) {
        planes[k] = plane(out->image, CHANNEL_LAYERS + k);
        variance[k] = guides->variance[k / 3][k % 3];
    }
    const air_atlas_layer filtered = {planes, variance, PLANES};
    air_atlas_denoise_params_default(&params);
    return air_atlas_denoise(context, &atlas, &params, &filtered);
}

/* Bands 0 and 1 with one set of weights. A band's noise is a share of that of irradiance: E =
 * pi/n_0 of the mean radiance, which is 0.2 to 0.3 of it for all that comes from one side. */
static air_status denoise_directions(air_context *context, const air_bake_page *page,
                                     const guide_planes *guides, const air_finished_page *out)
{
    enum { PLANES = 3 * AIR_DIRECTIONAL_COEFFICIENTS };
    air_atlas_denoise_params params;
    const size_t texels = (size_t)page->width * page->height;
    const air_atlas_guides atlas = guides_of(page, guides, out);
    float *planes[PLANES];
    const float *variance[PLANES];
    for (size_t i = 0; i < texels; i++) {
        for (size_t c = 0; c < 3; c++) {
            float sum = 0.0f;
            for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
                sum += guides->variance[layer][c][i];
            }
            guides->variance[0][c][i] = 0.0625f * sum;
        }
    }
    for (size_t k = 0; k < PLANES; k++) {
        planes[k] = plane(out->image, CHANNEL_COEFFICIENTS + k);
        variance[k] = guides->variance[0][k % 3];
    }
    const air_atlas_layer filtered = {planes, variance, PLANES};
    air_atlas_denoise_params_default(&params);
    return air_atlas_denoise(context, &atlas, &params, &filtered);
}

/* What is continued into free texels: everything but the coverage. */
static size_t light_planes(const air_finished_page *page, float *planes[CHANNELS_DIRECTIONAL])
{
    const size_t channels = air_image_channel_count(page->image);
    size_t count = 0;
    for (size_t k = 0; k < channels; k++) {
        if (k != CHANNEL_COVERAGE) {
            planes[count++] = plane(page->image, k);
        }
    }
    return count;
}

static air_status dilate(air_context *context, const air_bake_params *bake,
                         const air_bake_page *page, const air_finished_page *out)
{
    air_dilate_params params;
    float *planes[CHANNELS_DIRECTIONAL];
    const size_t count = light_planes(out, planes);
    air_dilate_params_default(&params);
    params.everything = bake->dilate == UINT32_MAX;
    params.radius = params.everything ? 0.0 : (double)bake->dilate;
    /* texels just inside of something are what a renderer mixes with those outside */
    if (out->invalid > 0 && params.radius < 2.0) {
        params.radius = 2.0;
    }
    return air_dilate(context, page->width, page->height, out->charts, &params, planes, count);
}

static void add_layers(const air_finished_page *page)
{
    const size_t texels = air_image_width(page->image) * air_image_height(page->image);
    for (size_t c = 0; c < 3; c++) {
        float *sum = plane(page->image, CHANNEL_SUM + c);
        const float *direct = plane(page->image, CHANNEL_LAYERS + c);
        const float *indirect = plane(page->image, CHANNEL_LAYERS + 3 + c);
        const float *media = plane(page->image, CHANNEL_LAYERS + 6 + c);
        for (size_t i = 0; i < texels; i++) {
            sum[i] = direct[i] + indirect[i] + media[i];
        }
    }
}

air_status air_finish_page(air_context *context, const air_bake_params *params,
                           const air_texel_sites *sites, const air_site_list *list,
                           air_finished_page *out)
{
    const air_bake_page *page = sites->page;
    const size_t texels = (size_t)page->width * page->height;
    guide_planes guides;
    *out = (air_finished_page){.image = NULL};
    float *block = air_allocate(context, texels, GUIDE_PLANES * sizeof *block);
    out->charts = air_allocate(context, texels, sizeof *out->charts);
    air_status status =
        block == NULL || out->charts == NULL ? air_fail_memory(context, "pages") : AIR_OK;
    if (status == AIR_OK) {
        status = air_image_create(context, page->width, page->height,
                                  params->directional ? CHANNELS_DIRECTIONAL : CHANNELS_PLAIN,
                                  names, &out->image);
    }
    if (status == AIR_OK) {
        lay_guides(block, texels, &guides);
        air_coverage_planes(context, page->coverage, out->charts, NULL);
        for (size_t i = 0; i < sites->count; i++) {
            store_texel(sites, list, i, &guides, out);
        }
    }
    if (status == AIR_OK && params->denoise) {
        status = denoise(context, page, &guides, out);
    }
    if (status == AIR_OK && params->denoise && params->directional) {
        status = denoise_directions(context, page, &guides, out);
    }
    if (status == AIR_OK) {
        status = dilate(context, params, page, out);
    }
    if (status == AIR_OK) {
        add_layers(out);
    }
    air_free(context, block);
    return status;
}

void air_finished_page_destroy(air_context *context, air_finished_page *page)
{
    air_image_destroy(page->image);
    air_free(context, page->charts);
    *page = (air_finished_page){.image = NULL};
}

/* ---- seams ---- */

/* All parts of all pages in a row. */
static void gather_parts(const air_bake_layout *layout, air_atlas_part *parts, uint32_t *pages)
{
    size_t count = 0;
    for (size_t p = 0; p < layout->page_count; p++) {
        for (size_t i = 0; i < layout->pages[p].part_count; i++) {
            parts[count] = layout->pages[p].parts[i];
            pages[count++] = (uint32_t)p;
        }
    }
}

static air_status solve(air_context *context, const air_bake_layout *layout,
                        const air_finished_page *pages, const air_seams *seams)
{
    typedef float *plane_list[CHANNELS_DIRECTIONAL];
    air_seams_page *solved = air_allocate(context, layout->page_count, sizeof *solved);
    plane_list *planes = air_allocate(context, layout->page_count, sizeof *planes);
    air_seams_params params;
    size_t count = 0;
    air_status status =
        solved == NULL || planes == NULL ? air_fail_memory(context, "seams") : AIR_OK;
    air_seams_params_default(&params);
    for (size_t p = 0; p < layout->page_count && status == AIR_OK; p++) {
        count = light_planes(&pages[p], planes[p]);
        /* the sum and the albedo are not solved for: behind the layers come bands, if any */
        memmove(&planes[p][0], &planes[p][CHANNEL_LAYERS], 9 * sizeof planes[p][0]);
        memmove(&planes[p][9], &planes[p][CHANNEL_COVERAGE],
                (count - CHANNEL_COVERAGE) * sizeof planes[p][0]);
        solved[p] = (air_seams_page){.width = layout->pages[p].width,
                                     .height = layout->pages[p].height,
                                     .charts = pages[p].charts,
                                     .planes = planes[p]};
    }
    if (status == AIR_OK) {
        /* layers, and band 0 if there is one; band 1 has a sign */
        params.light_planes = count > CHANNEL_COVERAGE ? 12 : 9;
        status = air_seams_solve(context, seams, solved, layout->page_count,
                                 9 + count - CHANNEL_COVERAGE, &params, NULL);
    }
    for (size_t p = 0; p < layout->page_count && status == AIR_OK; p++) {
        add_layers(&pages[p]);
    }
    air_free(context, solved);
    air_free(context, planes);
    return status;
}

air_status air_finish_seams(air_context *context, const air_bake_layout *layout,
                            const air_finished_page *pages)
{
    air_seams_find_params params;
    air_seams seams = {NULL, 0};
    size_t count = 0;
    for (size_t p = 0; p < layout->page_count; p++) {
        count += layout->pages[p].part_count;
    }
    air_atlas_part *parts = air_allocate(context, count, sizeof *parts);
    uint32_t *part_pages = air_allocate(context, count, sizeof *part_pages);
    air_status status =
        parts == NULL || part_pages == NULL ? air_fail_memory(context, "seams") : AIR_OK;
    air_seams_find_params_default(&params);
    if (status == AIR_OK) {
        gather_parts(layout, parts, part_pages);
        status = air_seams_find(context, parts, count, NULL, part_pages, &params, &seams);
    }
    if (status == AIR_OK && seams.count > 0) {
        status = solve(context, layout, pages, &seams);
    }
    air_seams_finish(context, &seams);
    air_free(context, parts);
    air_free(context, part_pages);
    return status;
}

/* gltf_page.c: pages as textures of a glTF file. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lightmap/check.h"
#include "lightmap/engine.h"
#include "lightmap/gltf_show.h"
#include "lightmap/uri.h"

enum { LINEAR = 9729, CLAMP_TO_EDGE = 33071 };

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* What 255 stands for: the largest value, but no more than four times what 99.9 % of the texels do
 * not pass: a few texels that went wrong must not take all steps from the others. largest: per
 * texel; is sorted. */
static float choose_peak(float *largest, size_t count)
{
    if (count == 0) {
        return 0.0f;
    }
    qsort(largest, count, sizeof *largest, compare_floats);
    const float most = largest[count - 1], usual = largest[count - 1 - count / 1000];
    return usual > 0.0f ? fminf(most, 4.0f * usual) : most;
}

/* Multiplies by the albedo, divides by the peak; both go to *page, as does the number of texels
 * beyond it. Texels that nothing covers do not count where others are covered. */
static air_status normalise(air_context *context, const air_image *source, bool by_albedo,
                            air_image *image, air_gltf_page *page)
{
    const size_t count = air_image_width(image) * air_image_height(image);
    const ptrdiff_t coverage = air_image_find_channel(source, "coverage.Y");
    const float *covered = coverage < 0 ? NULL : air_image_plane_const(source, (size_t)coverage);
    const float *albedo[3];
    float *planes[3], *largest = air_allocate(context, count, sizeof *largest);
    size_t used = 0;
    if (largest == NULL) {
        return air_fail_memory(context, "lightmap");
    }
    page->has_albedo = by_albedo && air_lightmap_planes(source, "albedo", albedo);
    for (size_t c = 0; c < 3; c++) {
        planes[c] = air_image_plane(image, c);
        for (size_t i = 0; i < count && page->has_albedo; i++) {
            planes[c][i] *= albedo[c][i];
        }
    }
    for (int all = 0; all < 2 && used == 0; all++) {
        for (size_t i = 0; i < count; i++) {
            if (all || covered == NULL || covered[i] > 0.0f) {
                largest[used++] = fmaxf(planes[0][i], fmaxf(planes[1][i], planes[2][i]));
            }
        }
    }
    page->peak = fmaxf(choose_peak(largest, used), 0.0f);
    for (size_t i = used; i-- > 0 && largest[i] > page->peak;) {
        page->clipped++;
    }
    for (size_t c = 0; c < 3 && page->peak > 0.0f; c++) {
        for (size_t i = 0; i < count; i++) {
            planes[c][i] /= page->peak;
        }
    }
    air_free(context, largest);
    return AIR_OK;
}

/* 8 bits with sRGB's transfer. */
static air_status encode(air_gltf_show *self, size_t index)
{
    air_context *context = self->copy->context;
    const air_image *source = self->lightmap->pages[index];
    air_gltf_page *page = &self->pages[index];
    air_image *image = NULL;
    air_image_save_params params;
    air_image_save_params_default(&params);
    params.auto_exposure = false;
    params.view = AIR_VIEW_STANDARD;
    page->png.context = context;
    air_status status = air_lightmap_page_radiance(context, source, &image);
    if (status == AIR_OK) {
        status = normalise(context, source, self->params.show == AIR_SHOW_EMISSIVE, image, page);
    }
    if (status == AIR_OK) {
        status = air_png_write(context, image, "lightmap", &params, &page->png);
    }
    air_image_destroy(image);
    if (status == AIR_OK && page->clipped > 0) {
        air_warn(context,
                 "page %zu: %zu texels brighter than %g W/(m^2 sr) are shown as bright as that",
                 index, page->clipped, (double)page->peak);
    }
    return status;
}

/* The picture's place in the file. */
static air_status add_image(air_gltf_show *self, size_t index, const char *stem, size_t *out_image)
{
    air_gltf_copy *copy = self->copy;
    air_gltf_page *page = &self->pages[index];
    json_t *image = json_object();
    air_status status = AIR_OK;
    json_object_set_new(image, "name", json_sprintf("lightmap-%zu", index));
    json_object_set_new(image, "mimeType", json_string("image/png"));
    if (stem == NULL) {
        size_t view = 0;
        status = air_gltf_copy_add_view(copy, page->png.data, page->png.size, 0, 0, &view);
        json_object_set_new(image, "bufferView", json_integer((json_int_t)view));
    } else {
        char *uri = air_uri_encode(copy->context, stem);
        status = uri == NULL ? AIR_ERROR_MEMORY : AIR_OK;
        if (uri != NULL) {
            json_object_set_new(image, "uri", json_sprintf("%s-lightmap-%zu.png", uri, index));
        }
        air_free(copy->context, uri);
    }
    if (status != AIR_OK) {
        json_decref(image);
        return status;
    }
    return air_gltf_copy_append(copy, "images", image, out_image);
}

/* Smooth, without smaller versions: they would mix charts. */
static air_status add_sampler(air_gltf_copy *copy, size_t *out_index)
{
    json_t *sampler = json_object();
    json_object_set_new(sampler, "magFilter", json_integer(LINEAR));
    json_object_set_new(sampler, "minFilter", json_integer(LINEAR));
    json_object_set_new(sampler, "wrapS", json_integer(CLAMP_TO_EDGE));
    json_object_set_new(sampler, "wrapT", json_integer(CLAMP_TO_EDGE));
    return air_gltf_copy_append(copy, "samplers", sampler, out_index);
}

air_status air_gltf_show_begin(air_gltf_show *self, const char *stem)
{
    const size_t count = self->lightmap->page_count;
    size_t sampler = 0;
    self->pages = air_allocate(self->copy->context, count, sizeof *self->pages);
    if (self->pages == NULL) {
        return air_fail_memory(self->copy->context, self->copy->path);
    }
    if (count == 0 || self->params.show == AIR_SHOW_COORDINATES) {
        return AIR_OK;
    }
    air_status status = add_sampler(self->copy, &sampler);
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        size_t image = 0;
        status = encode(self, i);
        if (status == AIR_OK) {
            status = add_image(self, i, stem, &image);
        }
        if (status == AIR_OK) {
            json_t *texture = json_object();
            json_object_set_new(texture, "sampler", json_integer((json_int_t)sampler));
            json_object_set_new(texture, "source", json_integer((json_int_t)image));
            status = air_gltf_copy_append(self->copy, "textures", texture, &self->pages[i].texture);
        }
    }
    return status;
}

void air_gltf_show_finish(air_gltf_show *self)
{
    for (size_t i = 0; self->pages != NULL && i < self->lightmap->page_count; i++) {
        air_free(self->copy->context, self->pages[i].png.data);
    }
    air_free(self->copy->context, self->pages);
    air_free(self->copy->context, self->materials);
}

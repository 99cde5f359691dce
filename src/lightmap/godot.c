/* godot.c: lightmaps for Godot 4: LightmapGIData and its texture array (docs/lightmap-engines.md).
 */
#include "lightmap/godot.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "image/staging.h"
#include "lightmap/check.h"

enum { TALLEST = 16384, NAME = 64 };

static const float one_over_pi = 0.318309886183790672f;
/* What linear irradiance over pi takes of the coefficients of radiance: the basis' constants times
 * 1 and 2/3. */
static const float take_l0 = 0.282094791773878143f, take_l1 = 0.325735007935279948f;

typedef struct godot_writer {
    air_context *context;
    const air_lightmap *lightmap;
    air_staging *staging;
    float unit;             /* what radiance is multiplied by */
    size_t widest, highest; /* of pages, which is the size of slices */
    size_t slices;          /* per page */
    size_t pages_per_texture, texture_count;
} godot_writer;

void air_lightmap_godot_params_default(air_lightmap_godot_params *params)
{
    *params = (air_lightmap_godot_params){.scale = 1.0f};
}

bool air_godot_print(air_sink *sink, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return length >= 0 && (size_t)length < sizeof text &&
           air_sink_write(sink, sink->size, text, (size_t)length);
}

/* ---- the texture ---- */

/* Light of one texel in one slice. */
typedef struct slice_source {
    const float *planes[3], *l0[3];
    float factor;
} slice_source;

/* Slices of a directional page: L0, then L1 along y, z and x, packed: L1 / (8 L0) + 1/2. */
static float slice_value(const slice_source *source, size_t c, size_t i)
{
    if (source->l0[0] == NULL) {
        return source->planes[c][i] * source->factor;
    }
    const float l0 = source->l0[c][i] * take_l0, l1 = source->planes[c][i] * take_l1;
    if (!(l0 > 0.0f)) {
        return 0.5f;
    }
    return fminf(fmaxf(l1 / (8.0f * l0) + 0.5f, 0.0f), 1.0f);
}

/* Puts a slice of a page into the image, `row` rows down. */
static void put_slice(const godot_writer *self, const air_image *page, size_t slice,
                      air_image *image, size_t row)
{
    const size_t width = air_image_width(page), height = air_image_height(page);
    slice_source source = {.factor = one_over_pi * self->unit};
    bool whole = air_lightmap_planes(page, self->slices == 1 ? "" : air_lightmap_bands[slice],
                                     source.planes);
    if (self->slices > 1 && slice == 0) {
        source.factor = take_l0 * self->unit;
    } else if (self->slices > 1) {
        whole = air_lightmap_planes(page, air_lightmap_bands[0], source.l0) && whole;
    }
    for (size_t y = 0; y < height && whole; y++) {
        for (size_t x = 0; x < width; x++) {
            for (size_t c = 0; c < 3; c++) {
                air_image_plane(image, c)[(row + y) * self->widest + x] =
                    slice_value(&source, c, y * width + x);
            }
        }
    }
}

static void texture_name(const godot_writer *self, size_t texture, char name[NAME])
{
    if (self->texture_count == 1) {
        (void)snprintf(name, NAME, "lightmap.exr");
    } else {
        (void)snprintf(name, NAME, "lightmap_%zu.exr", texture);
    }
}

static air_status add_import(const godot_writer *self, const char *name, size_t slices)
{
    char file[2 * NAME], text[512];
    (void)snprintf(file, sizeof file, "%s.import", name);
    const int length = snprintf(text, sizeof text,
                                "[remap]\n\nimporter=\"2d_array_texture\"\n"
                                "type=\"CompressedTexture2DArray\"\n\n[params]\n\n"
                                "compress/mode=3\ncompress/channel_pack=1\n"
                                "mipmaps/generate=false\nslices/horizontal=1\n"
                                "slices/vertical=%zu\n",
                                slices);
    return air_staging_add(self->staging, file, text, (size_t)length);
}

static air_status add_texture(const godot_writer *self, size_t texture)
{
    const size_t first = texture * self->pages_per_texture;
    const size_t left = self->lightmap->page_count - first;
    const size_t pages = left < self->pages_per_texture ? left : self->pages_per_texture;
    const size_t slices = pages * self->slices;
    air_image *image = NULL;
    air_image_save_params params;
    char name[NAME];
    air_image_save_params_default(&params);
    params.half = true;
    texture_name(self, texture, name);
    air_status status = air_image_create(self->context, self->widest, slices * self->highest, 3,
                                         air_lightmap_colours, &image);
    for (size_t i = 0; i < slices && status == AIR_OK; i++) {
        put_slice(self, self->lightmap->pages[first + i / self->slices], i % self->slices, image,
                  i * self->highest);
    }
    if (status == AIR_OK) {
        status = air_staging_add_image(self->staging, name, image, &params);
    }
    air_image_destroy(image);
    return status == AIR_OK ? add_import(self, name, slices) : status;
}

/* ---- the resource ---- */

static bool print_head(const godot_writer *self, air_sink *sink)
{
    bool done =
        air_godot_print(sink, "[gd_resource type=\"LightmapGIData\" load_steps=%zu format=3]\n\n",
                        self->texture_count + 1);
    for (size_t i = 0; i < self->texture_count; i++) {
        char name[NAME];
        texture_name(self, i, name);
        done = done && air_godot_print(sink,
                                       "[ext_resource type=\"CompressedTexture2DArray\" "
                                       "path=\"%s\" id=\"%zu\"]\n",
                                       name, i + 1);
    }
    done = done && air_godot_print(sink, "\n[resource]\nlight_textures = [");
    for (size_t i = 0; i < self->texture_count; i++) {
        done = done && air_godot_print(sink, "%sExtResource(\"%zu\")", i > 0 ? ", " : "", i + 1);
    }
    return done && air_godot_print(sink, "]\nuses_spherical_harmonics = %s\n",
                                   self->slices > 1 ? "true" : "false");
}

static air_status add_resource(const godot_writer *self, const char *scene_path)
{
    air_sink sink = {.context = self->context};
    air_status status =
        print_head(self, &sink) ? AIR_OK : air_fail_memory(self->context, "lightmap.tres");
    if (status == AIR_OK) {
        status = air_godot_print_users(self->context, self->lightmap, scene_path, self->widest,
                                       self->highest, &sink);
    }
    if (status == AIR_OK) {
        status = air_godot_print_probes(self->context, self->lightmap, self->unit, &sink);
    }
    if (status == AIR_OK && !air_godot_print(&sink, "_uses_packed_directional = %s\n",
                                             self->slices > 1 ? "true" : "false")) {
        status = air_fail_memory(self->context, "lightmap.tres");
    }
    if (status == AIR_OK) {
        status = air_staging_add(self->staging, "lightmap.tres", sink.data, sink.size);
    }
    air_free(self->context, sink.data);
    return status;
}

/* How pages become slices of textures. */
static air_status lay_out(godot_writer *self, const char *folder)
{
    const air_lightmap *lightmap = self->lightmap;
    self->slices = lightmap->directional ? AIR_DIRECTIONAL_COEFFICIENTS : 1;
    for (size_t i = 0; i < lightmap->page_count; i++) {
        const size_t width = air_image_width(lightmap->pages[i]);
        const size_t height = air_image_height(lightmap->pages[i]);
        self->widest = width > self->widest ? width : self->widest;
        self->highest = height > self->highest ? height : self->highest;
    }
    if (self->widest > TALLEST || self->highest * self->slices > TALLEST) {
        return air_fail(
            self->context, AIR_ERROR_UNSUPPORTED,
            "%s: pages of %zu x %zu are too large: Godot takes images of up to %d, with "
            "%zu slices for a page",
            folder, self->widest, self->highest, TALLEST, self->slices);
    }
    if (lightmap->page_count > 0) {
        self->pages_per_texture = TALLEST / (self->highest * self->slices);
        self->texture_count =
            (lightmap->page_count + self->pages_per_texture - 1) / self->pages_per_texture;
    }
    return AIR_OK;
}

air_status air_lightmap_save_godot(air_context *context, const air_lightmap *lightmap,
                                   const char *scene_path, const char *folder,
                                   const air_lightmap_godot_params *params)
{
    air_staging staging;
    godot_writer self = {.context = context, .lightmap = lightmap, .staging = &staging};
    const float scale = params != NULL ? params->scale : 1.0f;
    if (!(scale > 0.0f && scale < INFINITY)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: the scale is %g, must be positive",
                        folder, (double)scale);
    }
    self.unit = scale * (lightmap->photometric ? 683.0f : 1.0f);
    air_status status = air_lightmap_check(context, lightmap, folder, AIR_ERROR_ARGUMENT);
    if (status == AIR_OK) {
        status = lay_out(&self, folder);
    }
    if (status != AIR_OK) {
        return status;
    }
    status = air_staging_begin(context, folder, &staging);
    for (size_t i = 0; i < self.texture_count && status == AIR_OK; i++) {
        status = add_texture(&self, i);
    }
    if (status == AIR_OK) {
        status = add_resource(&self, scene_path);
    }
    if (status == AIR_OK) {
        status = air_staging_commit(&staging);
    }
    air_staging_finish(&staging);
    return status;
}

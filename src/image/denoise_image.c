/* denoise_image.c: the denoiser on images: which channels, with which guides. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "airlight/denoise.h"
#include "image/image.h"

enum { TERM_COUNT = 6, FIRST_FOG_TERM = 2, NOISY_TERM_COUNT = 4, NAME_LENGTH = 32 };

/* Layers by air_term. The last two are what the camera sees directly, and have no noise to speak
 * of. */
static const char *const term_names[TERM_COUNT] = {"S0", "S+",       "M1",
                                                   "M2", "emission", "background"};

typedef struct denoise_image {
    air_context *context;
    const air_image *in;
    air_image *out;
    const air_denoise_params *params;
    const float *depth, *normal[3], *albedo[3]; /* the last two NULL where there are none */
} denoise_image;

/* ---- channels ---- */

static const float *find(const air_image *image, const char *name)
{
    const ptrdiff_t channel = air_image_find_channel(image, name);
    return channel < 0 ? NULL : air_image_plane_const(image, (size_t)channel);
}

/* Planes LAYER.R and so on; the picture's own for "". How many there are; *missing names the
 * first that is not. */
static int find_three(const air_image *image, const char *layer, const char *components,
                      const float *out[3], char missing[NAME_LENGTH])
{
    int count = 0;
    for (int c = 0; c < 3; c++) {
        char name[NAME_LENGTH];
        snprintf(name, sizeof name, "%s%s%c", layer, layer[0] != '\0' ? "." : "", components[c]);
        out[c] = find(image, name);
        if (out[c] == NULL && count == c) {
            memcpy(missing, name, sizeof name);
        }
        count += out[c] != NULL;
    }
    return count;
}

static bool find_layer(const air_image *image, int term, const float *out[3])
{
    char missing[NAME_LENGTH];
    return find_three(image, term_names[term], "RGB", out, missing) == 3;
}

static bool has_layers(const air_image *image)
{
    const float *planes[3];
    for (int term = 0; term < NOISY_TERM_COUNT; term++) {
        if (find_layer(image, term, planes)) {
            return true;
        }
    }
    return false;
}

static air_status channel_missing(const denoise_image *self, const char *name)
{
    return air_fail(self->context, AIR_ERROR_ARGUMENT,
                    "denoise: the image has no channel %s: expected R, G, B and the guides that "
                    "render --guides writes",
                    name);
}

/* Guides that come in threes are there as a whole or not at all. */
static air_status find_guides(denoise_image *self)
{
    const float *colour[3];
    char missing[NAME_LENGTH];
    if (find_three(self->in, "", "RGB", colour, missing) != 3) {
        return channel_missing(self, missing);
    }
    self->depth = find(self->in, "depth.Z");
    if (self->depth == NULL) {
        return channel_missing(self, "depth.Z");
    }
    if (find_three(self->in, "normal", "XYZ", self->normal, missing) % 3 != 0) {
        return channel_missing(self, missing);
    }
    if (self->params->albedo &&
        find_three(self->in, "albedo", "RGB", self->albedo, missing) % 3 != 0) {
        return channel_missing(self, missing);
    }
    return AIR_OK;
}

/* ---- copies ---- */

/* Variances are those of the noisy picture, and say nothing of this one. */
static bool is_kept(const char *name)
{
    return strncmp(name, "variance.", 9) != 0 && strcmp(name, "airlight:variance-replicates") != 0;
}

static air_status copy_image(air_context *context, const air_image *image, air_image **out)
{
    const char *names[AIR_IMAGE_MAX_CHANNELS] = {NULL};
    size_t count = 0;
    for (size_t i = 0; i < image->channel_count; i++) {
        if (is_kept(image->names[i])) {
            names[count++] = image->names[i];
        }
    }
    air_status status = air_image_create(context, image->width, image->height, count, names, out);
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        memcpy(air_image_plane(*out, i), find(image, names[i]),
               image->width * image->height * sizeof(float));
    }
    for (size_t i = 0; i < air_image_attribute_count(image) && status == AIR_OK; i++) {
        const char *name = air_image_attribute_name(image, i);
        status = is_kept(name)
                     ? air_image_set_attribute(*out, name, air_image_attribute(image, name))
                     : AIR_OK;
    }
    return status;
}

/* ---- filtering ---- */

/* What a surface reflects, so far as it is worth dividing by. */
static float divisor(const float *albedo, const float *depth, size_t i)
{
    return depth[i] > 0.0f && albedo[i] > 1e-3f && isfinite(albedo[i]) ? albedo[i] : 1.0f;
}

/* Filters three planes of `out`, whose original values are those of `in`. */
static air_status filter_planes(denoise_image *self, const float *const in[3], float *const out[3],
                                bool on_surfaces)
{
    const size_t pixels = self->in->width * self->in->height;
    const bool divide = on_surfaces && self->albedo[0] != NULL;
    air_denoise_guides guides = {self->in->width, self->in->height, self->depth, {NULL}, NULL};
    for (int c = 0; c < 3; c++) {
        guides.normal[c] = on_surfaces ? self->normal[c] : NULL;
        for (size_t i = 0; divide && i < pixels; i++) {
            out[c][i] = in[c][i] / divisor(self->albedo[c], self->depth, i);
        }
    }
    const air_status status = air_denoise_planes(self->context, &guides, self->params, out, 3);
    for (int c = 0; c < 3 && divide && status == AIR_OK; c++) {
        for (size_t i = 0; i < pixels; i++) {
            const float by = divisor(self->albedo[c], self->depth, i);
            /* what was not filtered is not rounded either */
            out[c][i] = out[c][i] == in[c][i] / by ? in[c][i] : out[c][i] * by;
        }
    }
    return status;
}

/* The planes of a copy that has the same channels. */
static void find_out(const denoise_image *self, const char *layer, float *out[3])
{
    const float *found[3];
    char missing[NAME_LENGTH];
    (void)find_three(self->out, layer, "RGB", found, missing);
    for (int c = 0; c < 3; c++) {
        out[c] = self->out->pixels + (found[c] - self->out->pixels);
    }
}

/* Each layer by what concerns it, and the picture as their sum. */
static air_status filter_layers(denoise_image *self)
{
    const size_t pixels = self->in->width * self->in->height;
    const float *in[3];
    float *out[3], *sum[3];
    air_status status = AIR_OK;
    find_out(self, "", sum);
    for (int c = 0; c < 3; c++) {
        memset(sum[c], 0, pixels * sizeof(float));
    }
    for (int term = 0; term < TERM_COUNT && status == AIR_OK; term++) {
        if (!find_layer(self->in, term, in)) {
            continue;
        }
        find_out(self, term_names[term], out);
        if (term < NOISY_TERM_COUNT && (self->params->terms >> term & 1u) != 0) {
            status = filter_planes(self, in, out, term < FIRST_FOG_TERM);
        }
        for (int c = 0; c < 3; c++) {
            for (size_t i = 0; i < pixels; i++) {
                sum[c][i] += out[c][i];
            }
        }
    }
    return status;
}

static air_status filter_whole(denoise_image *self)
{
    const float *in[3];
    float *out[3];
    char missing[NAME_LENGTH];
    if ((self->params->terms & AIR_DENOISE_TERMS) != AIR_DENOISE_TERMS) {
        return air_fail(self->context, AIR_ERROR_ARGUMENT,
                        "denoise: the image has no layers to choose from: expected those that "
                        "render --layers writes");
    }
    (void)find_three(self->in, "", "RGB", in, missing);
    find_out(self, "", out);
    return filter_planes(self, in, out, true);
}

air_status air_image_denoise(air_context *context, const air_image *image,
                             const air_denoise_params *params, air_image **out_image)
{
    denoise_image self = {.context = context, .in = image, .params = params};
    *out_image = NULL;
    air_status status = find_guides(&self);
    if (status == AIR_OK) {
        status = copy_image(context, image, &self.out);
    }
    if (status == AIR_OK) {
        status = has_layers(image) ? filter_layers(&self) : filter_whole(&self);
    }
    if (status != AIR_OK) {
        air_image_destroy(self.out);
        return status;
    }
    *out_image = self.out;
    return AIR_OK;
}

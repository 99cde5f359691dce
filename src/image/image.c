/* image.c: the container: named planes and string attributes. */
#include "image/image.h"

#include <math.h>
#include <string.h>

enum { MAX_ATTRIBUTE_NAME = 255 };

static air_status check_names(air_context *context, size_t count, const char *const *names)
{
    for (size_t i = 0; i < count; i++) {
        if (names[i] == NULL || names[i][0] == '\0') {
            return air_fail(context, AIR_ERROR_ARGUMENT, "image: channel %zu has no name", i);
        }
        for (size_t j = 0; j < i; j++) {
            if (strcmp(names[i], names[j]) == 0) {
                return air_fail(context, AIR_ERROR_ARGUMENT, "image: two channels are called %s",
                                names[i]);
            }
        }
    }
    return AIR_OK;
}

air_status air_image_create(air_context *context, size_t width, size_t height, size_t channel_count,
                            const char *const *channel_names, air_image **out_image)
{
    *out_image = NULL;
    if (width < 1 || height < 1 || width > AIR_IMAGE_MAX_SIDE || height > AIR_IMAGE_MAX_SIDE) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "image: size %zu x %zu, each side must be 1 to %d", width, height,
                        AIR_IMAGE_MAX_SIDE);
    }
    if (channel_count < 1 || channel_count > AIR_IMAGE_MAX_CHANNELS) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "image: %zu channels, must be 1 to %d",
                        channel_count, AIR_IMAGE_MAX_CHANNELS);
    }
    air_status status = check_names(context, channel_count, channel_names);
    if (status != AIR_OK) {
        return status;
    }
    air_image *image = air_allocate(context, 1, sizeof(*image));
    if (image == NULL) {
        return air_fail_memory(context, "image");
    }
    image->context = context;
    image->width = width;
    image->height = height;
    image->channel_count = channel_count;
    image->names = air_allocate(context, channel_count, sizeof(*image->names));
    image->pixels = air_allocate(context, width * height * channel_count, sizeof(*image->pixels));
    if (image->names == NULL || image->pixels == NULL) {
        status = air_fail_memory(context, "image");
        goto cleanup;
    }
    for (size_t i = 0; i < channel_count; i++) {
        image->names[i] = air_string_copy(context, channel_names[i]);
        if (image->names[i] == NULL) {
            status = air_fail_memory(context, "image");
            goto cleanup;
        }
    }
    *out_image = image;
    return AIR_OK;
cleanup:
    air_image_destroy(image);
    return status;
}

void air_image_destroy(air_image *image)
{
    if (image == NULL) {
        return;
    }
    air_context *context = image->context;
    for (size_t i = 0; i < image->attribute_count; i++) {
        air_free(context, image->attributes[i].name);
        air_free(context, image->attributes[i].value);
    }
    air_free(context, image->attributes);
    for (size_t i = 0; image->names != NULL && i < image->channel_count; i++) {
        air_free(context, image->names[i]);
    }
    air_free(context, image->names);
    air_free(context, image->pixels);
    air_free(context, image);
}

size_t air_image_width(const air_image *image) { return image->width; }
size_t air_image_height(const air_image *image) { return image->height; }
size_t air_image_channel_count(const air_image *image) { return image->channel_count; }

const char *air_image_channel_name(const air_image *image, size_t channel)
{
    return channel < image->channel_count ? image->names[channel] : NULL;
}

ptrdiff_t air_image_find_channel(const air_image *image, const char *name)
{
    for (size_t i = 0; i < image->channel_count; i++) {
        if (strcmp(image->names[i], name) == 0) {
            return (ptrdiff_t)i;
        }
    }
    return -1;
}

float *air_image_plane(air_image *image, size_t channel)
{
    return channel < image->channel_count ? image->pixels + channel * image->width * image->height
                                          : NULL;
}

const float *air_image_plane_const(const air_image *image, size_t channel)
{
    return channel < image->channel_count ? image->pixels + channel * image->width * image->height
                                          : NULL;
}

bool air_image_colour(const air_image *image, const float *out_planes[3])
{
    static const char *const rgb[3] = {"R", "G", "B"};
    for (size_t i = 0; i < 3; i++) {
        const ptrdiff_t channel = air_image_find_channel(image, rgb[i]);
        if (channel < 0) {
            const ptrdiff_t grey = air_image_find_channel(image, "Y");
            if (grey < 0) {
                return false;
            }
            out_planes[0] = out_planes[1] = out_planes[2] =
                air_image_plane_const(image, (size_t)grey);
            return true;
        }
        out_planes[i] = air_image_plane_const(image, (size_t)channel);
    }
    return true;
}

size_t air_image_count_not_finite(const float *const planes[3], size_t pixel_count,
                                  size_t *out_first)
{
    size_t count = 0;
    for (size_t i = 0; i < pixel_count; i++) {
        if (!isfinite(planes[0][i]) || !isfinite(planes[1][i]) || !isfinite(planes[2][i])) {
            if (count == 0) {
                *out_first = i;
            }
            count++;
        }
    }
    return count;
}

static size_t find_attribute(const air_image *image, const char *name)
{
    size_t i = 0;
    while (i < image->attribute_count && strcmp(image->attributes[i].name, name) != 0) {
        i++;
    }
    return i;
}

static void remove_attribute(air_image *image, size_t index)
{
    air_free(image->context, image->attributes[index].name);
    air_free(image->context, image->attributes[index].value);
    image->attribute_count--;
    memmove(&image->attributes[index], &image->attributes[index + 1],
            (image->attribute_count - index) * sizeof(*image->attributes));
}

/* Adds an empty entry for name at the end. */
static air_status add_attribute(air_image *image, const char *name)
{
    air_context *context = image->context;
    char *name_copy = air_string_copy(context, name);
    air_attribute *grown = air_reallocate(context, image->attributes, image->attribute_count + 1,
                                          sizeof(*image->attributes));
    if (grown != NULL) {
        image->attributes = grown;
    }
    if (name_copy == NULL || grown == NULL) {
        air_free(context, name_copy);
        return air_fail_memory(context, "image attribute");
    }
    image->attributes[image->attribute_count] = (air_attribute){name_copy, NULL};
    image->attribute_count++;
    return AIR_OK;
}

air_status air_image_set_attribute(air_image *image, const char *name, const char *value)
{
    const size_t length = name != NULL ? strlen(name) : 0;
    if (length < 1 || length > MAX_ATTRIBUTE_NAME) {
        return air_fail(image->context, AIR_ERROR_ARGUMENT,
                        "image: an attribute's name has %zu bytes, must be 1 to %d", length,
                        MAX_ATTRIBUTE_NAME);
    }
    const size_t index = find_attribute(image, name);
    if (value == NULL) {
        if (index < image->attribute_count) {
            remove_attribute(image, index);
        }
        return AIR_OK;
    }
    char *value_copy = air_string_copy(image->context, value);
    if (value_copy == NULL) {
        return air_fail_memory(image->context, "image attribute");
    }
    if (index == image->attribute_count) {
        const air_status status = add_attribute(image, name);
        if (status != AIR_OK) {
            air_free(image->context, value_copy);
            return status;
        }
    }
    air_free(image->context, image->attributes[index].value);
    image->attributes[index].value = value_copy;
    return AIR_OK;
}

const char *air_image_attribute(const air_image *image, const char *name)
{
    const size_t index = find_attribute(image, name);
    return index < image->attribute_count ? image->attributes[index].value : NULL;
}

size_t air_image_attribute_count(const air_image *image) { return image->attribute_count; }

const char *air_image_attribute_name(const air_image *image, size_t index)
{
    return index < image->attribute_count ? image->attributes[index].name : NULL;
}

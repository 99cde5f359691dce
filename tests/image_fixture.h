/* image_fixture.h: what the tests of images share: a context, a folder that is removed, small
 * images, numbers. */
#ifndef AIR_TESTS_IMAGE_FIXTURE_H
#define AIR_TESTS_IMAGE_FIXTURE_H

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "airlight/image.h"
#include "cmocka_test.h"

typedef struct image_fixture {
    air_context *context;
    char folder[64];
    char path[128];
    int warnings;
    uint64_t random;
} image_fixture;

static inline void image_fixture_message(void *user, air_message_level level, const char *text)
{
    image_fixture *const self = user;
    (void)text;
    self->warnings += level == AIR_MESSAGE_WARNING;
}

static inline int image_fixture_start(void **state)
{
    image_fixture *self = calloc(1, sizeof(*self));
    air_context_params params;
    air_context_params_default(&params);
    params.message = image_fixture_message;
    params.message_user = self;
    self->random = 1;
    (void)snprintf(self->folder, sizeof(self->folder), "/tmp/airlight-image-XXXXXX");
    *state = self;
    return mkdtemp(self->folder) != NULL && air_context_create(&params, &self->context) == AIR_OK
               ? 0
               : -1;
}

/* Fails if a test or the library left anything but the one file at self->path. */
static inline int image_fixture_finish(void **state)
{
    image_fixture *self = *state;
    if (self->path[0] != '\0') {
        (void)unlink(self->path);
    }
    const int left = rmdir(self->folder);
    air_context_destroy(self->context);
    free(self);
    return left;
}

static inline const char *image_fixture_path(image_fixture *self, const char *name)
{
    (void)snprintf(self->path, sizeof(self->path), "%s/%s", self->folder, name);
    return self->path;
}

/* Uniform in [0,1): a 64-bit linear congruential generator with Knuth's constants, upper bits. */
static inline double image_fixture_random(image_fixture *self)
{
    self->random = self->random * 6364136223846793005u + 1442695040888963407u;
    return (double)(self->random >> 11) * 0x1p-53;
}

static inline air_image *image_make(image_fixture *self, size_t width, size_t height, size_t count,
                                    const char *const *names)
{
    air_image *image = NULL;
    assert_int_equal(air_image_create(self->context, width, height, count, names, &image), AIR_OK);
    return image;
}

static inline air_image *image_make_rgb(image_fixture *self, size_t width, size_t height)
{
    static const char *const names[3] = {"R", "G", "B"};
    return image_make(self, width, height, 3, names);
}

static inline void image_fill(air_image *image, float r, float g, float b)
{
    const float rgb[3] = {r, g, b};
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < air_image_width(image) * air_image_height(image); i++) {
            air_image_plane(image, c)[i] = rgb[c];
        }
    }
}

static inline void image_write_file(image_fixture *self, const char *name, const void *data,
                                    size_t size)
{
    FILE *file = fopen(image_fixture_path(self, name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline size_t image_read_file(const char *path, uint8_t *data, size_t capacity)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(data, 1, capacity, file);
    assert_true(size < capacity);
    assert_int_equal(fclose(file), 0);
    return size;
}

/* Loading `path` fails with `status`, a message that names the file and contains `part`, and no
 * image. */
static inline void image_check_refused(image_fixture *self, const char *path, air_status status,
                                       const char *part)
{
    air_image *image = (air_image *)(uintptr_t)1;
    const air_status got = air_image_load(self->context, path, &image);
    const char *const message = air_context_last_error(self->context);
    if (got != status || strstr(message, part) == NULL || strstr(message, path) == NULL) {
        fail_msg("status %d, message \"%s\", expected status %d and \"%s\"", (int)got, message,
                 (int)status, part);
    }
    assert_null(image);
}

/* Every proper prefix of the file's bytes is refused as AIR_ERROR_FORMAT; `step` bytes apart. */
static inline void image_check_truncations(image_fixture *self, const char *name,
                                           const uint8_t *data, size_t size, size_t step)
{
    for (size_t length = 0; length < size; length += step) {
        image_write_file(self, name, data, length);
        image_check_refused(self, self->path, AIR_ERROR_FORMAT, "");
    }
}

#endif

/* staging.c: several files that appear together or not at all. */
#include "image/staging.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image/format.h"

enum { ATTEMPTS = 1000, ERROR_TEXT = 128 };

static air_status fail_errno(air_context *context, const char *path, const char *what, int error)
{
    char text[ERROR_TEXT];
    if (strerror_r(error, text, sizeof text) != 0) {
        (void)snprintf(text, sizeof text, "error %d", error);
    }
    return air_fail(context, AIR_ERROR_IO, "%s: %s: %s", path, what, text);
}

/* Makes a folder and those above it; *out_made: the last one was missing. */
static air_status make_folder(air_context *context, const char *folder, bool *out_made)
{
    char *path = air_string_copy(context, folder);
    int error = 0;
    if (path == NULL) {
        return air_fail_memory(context, folder);
    }
    for (char *slash = strchr(path + 1, '/'); path[0] != '\0' && slash != NULL;
         slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        (void)mkdir(path, 0777); /* what is wrong with it the last one will say */
        *slash = '/';
    }
    *out_made = mkdir(path, 0777) == 0;
    if (!*out_made) {
        struct stat info;
        error = errno;
        if (error == EEXIST && stat(path, &info) == 0) {
            error = S_ISDIR(info.st_mode) ? 0 : ENOTDIR;
        }
    }
    air_free(context, path);
    return error == 0 ? AIR_OK : fail_errno(context, folder, "cannot be made a folder", error);
}

/* Makes the temporary folder. */
static air_status make_temporary(air_staging *self)
{
    int error = EEXIST;
    for (int i = 0; i < ATTEMPTS && error == EEXIST; i++) {
        char *name = air_string_format(self->context, "%s/.airlight-%ld-%d.part", self->folder,
                                       (long)getpid(), i);
        if (name == NULL) {
            return air_fail_memory(self->context, self->folder);
        }
        error = mkdir(name, 0777) == 0 ? 0 : errno;
        if (error == 0) {
            self->temporary = name;
        } else {
            air_free(self->context, name);
        }
    }
    return error == 0 ? AIR_OK
                      : fail_errno(self->context, self->folder, "cannot be written into", error);
}

air_status air_staging_begin(air_context *context, const char *folder, air_staging *out)
{
    *out = (air_staging){.context = context, .folder_file = -1, .temporary_file = -1};
    out->folder = air_string_copy(context, folder[0] != '\0' ? folder : ".");
    if (out->folder == NULL) {
        return air_fail_memory(context, folder);
    }
    for (size_t last = strlen(out->folder); last > 1 && out->folder[last - 1] == '/'; last--) {
        out->folder[last - 1] = '\0';
    }
    air_status status = make_folder(context, out->folder, &out->folder_made);
    if (status == AIR_OK) {
        status = make_temporary(out);
    }
    if (status == AIR_OK) {
        out->folder_file = open(out->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        out->temporary_file = open(out->temporary, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (out->folder_file < 0 || out->temporary_file < 0) {
            status = fail_errno(context, out->folder, "cannot be written into", errno);
        }
    }
    return status;
}

/* The message for what happened to one file, by its final name. */
static air_status fail_file(const air_staging *self, const char *name, const char *what, int error)
{
    char *path = air_string_format(self->context, "%s/%s", self->folder, name);
    const air_status status = fail_errno(self->context, path != NULL ? path : name, what, error);
    air_free(self->context, path);
    return status;
}

static air_status remember(air_staging *self, const char *name)
{
    if (self->count == self->capacity) {
        const size_t capacity = 2 * self->capacity + 8;
        char **names = air_reallocate(self->context, self->names, capacity, sizeof *names);
        if (names == NULL) {
            return air_fail_memory(self->context, self->folder);
        }
        self->names = names;
        self->capacity = capacity;
    }
    self->names[self->count] = air_string_copy(self->context, name);
    if (self->names[self->count] == NULL) {
        return air_fail_memory(self->context, self->folder);
    }
    self->count++;
    return AIR_OK;
}

air_status air_staging_add(air_staging *self, const char *name, const void *data, size_t size)
{
    air_status status = remember(self, name);
    if (status != AIR_OK) {
        return status;
    }
    const int file =
        openat(self->temporary_file, name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    const char *bytes = data;
    int error = file < 0 ? errno : 0;
    while (size > 0 && error == 0) {
        const ssize_t count = write(file, bytes, size);
        if (count >= 0) {
            bytes += count;
            size -= (size_t)count;
        } else if (errno != EINTR) {
            error = errno;
        }
    }
    if (file >= 0 && close(file) != 0 && error == 0) {
        error = errno;
    }
    return error == 0 ? AIR_OK : fail_file(self, name, "cannot be written", error);
}

air_status air_staging_add_image(air_staging *self, const char *name, const air_image *image,
                                 const air_image_save_params *params)
{
    const char *ending = strrchr(name, '.');
    air_sink sink = {.context = self->context};
    char *path = air_string_format(self->context, "%s/%s", self->folder, name);
    if (path == NULL) {
        return air_fail_memory(self->context, name);
    }
    air_status status = AIR_OK;
    if (ending != NULL && strcmp(ending, ".png") == 0) {
        status = air_png_write(self->context, image, path, params, &sink);
    } else if (ending != NULL && strcmp(ending, ".ktx2") == 0) {
        status = air_ktx2_write(self->context, image, path, params, &sink);
    } else {
        status = air_exr_write(self->context, image, path, params, &sink);
    }
    if (status == AIR_OK) {
        status = air_staging_add(self, name, sink.data, sink.size);
    }
    air_free(self->context, sink.data);
    air_free(self->context, path);
    return status;
}

air_status air_staging_add_json(air_staging *self, const char *name, json_t *root)
{
    /* Nine digits bring a float back exactly. */
    char *text = root != NULL ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(root);
    if (text == NULL) {
        return air_fail_memory(self->context, name);
    }
    const air_status status = air_staging_add(self, name, text, strlen(text));
    free(text);
    return status;
}

air_status air_staging_commit(air_staging *self)
{
    /* A folder that has a file's name would stop the move half-way. */
    for (size_t i = 0; i < self->count; i++) {
        struct stat info;
        if (fstatat(self->folder_file, self->names[i], &info, AT_SYMLINK_NOFOLLOW) == 0 &&
            S_ISDIR(info.st_mode)) {
            return fail_file(self, self->names[i], "cannot be written", EISDIR);
        }
    }
    if (self->count > 1) {
        const char *index = self->names[self->count - 1];
        self->replaced = unlinkat(self->folder_file, index, 0) == 0;
        if (!self->replaced && errno != ENOENT) {
            return fail_file(self, index, "cannot be replaced", errno);
        }
    }
    for (size_t i = 0; i < self->count; i++) {
        if (renameat(self->temporary_file, self->names[i], self->folder_file, self->names[i]) !=
            0) {
            return fail_file(self, self->names[i], "cannot be written", errno);
        }
    }
    self->folder_made = false; /* it stays */
    return AIR_OK;
}

void air_staging_remove_old(const air_staging *self, const char *prefix, size_t first)
{
    char name[64];
    int error = 0;
    for (size_t i = first; self->replaced && error == 0; i++) {
        (void)snprintf(name, sizeof name, "%s%zu.exr", prefix, i);
        error = unlinkat(self->folder_file, name, 0);
    }
}

void air_staging_finish(air_staging *self)
{
    for (size_t i = 0; i < self->count; i++) {
        (void)unlinkat(self->temporary_file, self->names[i], 0);
        air_free(self->context, self->names[i]);
    }
    if (self->temporary != NULL) {
        (void)rmdir(self->temporary);
    }
    if (self->folder_made) {
        (void)rmdir(self->folder);
    }
    if (self->temporary_file >= 0) {
        (void)close(self->temporary_file);
    }
    if (self->folder_file >= 0) {
        (void)close(self->folder_file);
    }
    air_free(self->context, self->names);
    air_free(self->context, self->temporary);
    air_free(self->context, self->folder);
    *self = (air_staging){.folder_file = -1, .temporary_file = -1};
}

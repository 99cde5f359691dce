/* file.c: whole files in, whole files out. */
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/context_state.h"

enum { TEXT_SIZE = 128, TEMP_ATTEMPTS = 1000 };

static air_status fail_errno(air_context *context, const char *path, const char *what, int error)
{
    char text[TEXT_SIZE];
    if (strerror_r(error, text, sizeof text) != 0) {
        (void)snprintf(text, sizeof text, "error %d", error);
    }
    return air_fail(context, AIR_ERROR_IO, "%s: %s: %s", path, what, text);
}

/* Makes room for at least one byte behind `used`. */
static bool grow(air_context *context, char **data, size_t *capacity, size_t used)
{
    if (used < *capacity) {
        return true;
    }
    const size_t larger = *capacity <= SIZE_MAX / 2 ? *capacity * 2 : SIZE_MAX;
    char *moved = air_reallocate(context, *data, larger, 1);
    if (moved == NULL) {
        return false;
    }
    *data = moved;
    *capacity = larger;
    return true;
}

/* Everything that can be read from an open file, and a NUL. */
static air_status read_all(air_context *context, const char *path, int file, void **out_data,
                           size_t *out_size)
{
    air_status status = AIR_OK;
    struct stat info = {0};
    /* The size is only a first guess: pipes have none, and files may grow. */
    const bool regular = fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_size >= 0;
    size_t capacity = regular ? (size_t)info.st_size + 2 : 65536;
    size_t used = 0;
    char *data = air_reallocate(context, NULL, capacity, 1);
    if (data == NULL) {
        return air_fail_memory(context, path);
    }
    for (;;) {
        if (!grow(context, &data, &capacity, used + 1)) {
            status = air_fail_memory(context, path);
            goto cleanup;
        }
        const ssize_t count = read(file, data + used, capacity - used - 1);
        if (count == 0) {
            break;
        }
        if (count > 0) {
            used += (size_t)count;
        } else if (errno != EINTR) {
            status = fail_errno(context, path, "cannot be read", errno);
            goto cleanup;
        }
    }
    data[used] = '\0';
    *out_data = data;
    *out_size = used;
    data = NULL;
cleanup:
    air_free(context, data);
    return status;
}

/* A host's reader knows nothing of the NUL and sends no message. An optional file it does not have
 * leaves the outputs as they are. */
static air_status read_from_host(air_context *context, const char *path, bool optional,
                                 void **out_data, size_t *out_size)
{
    void *data = NULL;
    size_t size = 0;
    const air_status status =
        context->params.read_file(context->params.read_user, context, path, &data, &size);
    if (status == AIR_ERROR_IO && optional) {
        return AIR_OK;
    }
    if (status != AIR_OK) {
        return air_fail(context, status, "%s: cannot be read", path);
    }
    char *text = size < SIZE_MAX ? air_reallocate(context, data, size + 1, 1) : NULL;
    if (text == NULL) {
        air_free(context, data);
        return air_fail_memory(context, path);
    }
    text[size] = '\0';
    *out_data = text;
    *out_size = size;
    return AIR_OK;
}

air_status air_file_read(air_context *context, const char *path, void **out_data, size_t *out_size)
{
    if (context->params.read_file != NULL) {
        return read_from_host(context, path, false, out_data, out_size);
    }
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return fail_errno(context, path, "cannot be opened", errno);
    }
    const air_status status = read_all(context, path, file, out_data, out_size);
    (void)close(file);
    return status;
}

air_status air_file_read_optional(air_context *context, const char *path, void **out_data,
                                  size_t *out_size)
{
    *out_data = NULL;
    *out_size = 0;
    if (context->params.read_file != NULL) {
        return read_from_host(context, path, true, out_data, out_size);
    }
    if (access(path, F_OK) != 0 && errno == ENOENT) {
        return AIR_OK;
    }
    return air_file_read(context, path, out_data, out_size);
}

/* 0, or the errno of what failed. Closes the file in any case. */
static int write_and_close(int file, const char *data, size_t size)
{
    int error = 0;
    while (size > 0 && error == 0) {
        const ssize_t count = write(file, data, size);
        if (count >= 0) {
            data += count;
            size -= (size_t)count;
        } else if (errno != EINTR) {
            error = errno;
        }
    }
    if (close(file) != 0 && error == 0) {
        error = errno;
    }
    return error;
}

/* Opens a new file beside `path` and puts its name into temp[temp_size]. Returns -1 with errno if
 * that fails. */
static int open_beside(const char *path, char *temp, size_t temp_size)
{
    for (int attempt = 0; attempt < TEMP_ATTEMPTS; ++attempt) {
        (void)snprintf(temp, temp_size, "%s.%ld-%d.part", path, (long)getpid(), attempt);
        const int file = open(temp, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0 || errno != EEXIST) {
            return file;
        }
    }
    return -1;
}

/* Devices and pipes cannot be renamed onto. */
static air_status write_special(air_context *context, const char *path, const void *data,
                                size_t size)
{
    const int file = open(path, O_WRONLY | O_CLOEXEC);
    const int error = file < 0 ? errno : write_and_close(file, data, size);
    return error == 0 ? AIR_OK : fail_errno(context, path, "cannot be written", error);
}

air_status air_file_write(air_context *context, const char *path, const void *data, size_t size)
{
    struct stat info = {0};
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        return write_special(context, path, data, size);
    }
    const size_t temp_size = strlen(path) + 64;
    char *temp = air_allocate(context, temp_size, 1);
    if (temp == NULL) {
        return air_fail_memory(context, path);
    }
    air_status status = AIR_OK;
    const int file = open_beside(path, temp, temp_size);
    int error = file < 0 ? errno : write_and_close(file, data, size);
    if (error == 0 && rename(temp, path) != 0) {
        error = errno;
    }
    if (error != 0) {
        if (file >= 0) {
            (void)unlink(temp);
        }
        status = fail_errno(context, path, "cannot be written", error);
    }
    air_free(context, temp);
    return status;
}

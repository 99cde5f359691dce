/* realpath is in POSIX 2008's XSI part. */
#define _XOPEN_SOURCE 700

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/resource.h"

/* Does a path whose folder does not exist stay below it? Counts parts; the folder itself begins
 * the path. */
static bool stays_below(const char *folder, const char *path)
{
    const size_t length = strlen(folder);
    int depth = 0;
    if (strncmp(path, folder, length) != 0 || path[length] == '/')
        return false;
    for (const char *part = path + length; *part != '\0';) {
        const size_t size = strcspn(part, "/");
        if (size == 2 && part[0] == '.' && part[1] == '.')
            --depth;
        else if (size > 0 && !(size == 1 && part[0] == '.'))
            ++depth;
        if (depth < 0)
            return false;
        part += size + (part[size] == '/');
    }
    return true;
}

/* With links followed, where the file system knows the file. */
static bool is_inside(const char *folder, const char *path)
{
    char *real_folder = realpath(folder[0] != '\0' ? folder : ".", NULL);
    char *real_path = realpath(path, NULL);
    bool inside;
    if (real_folder != NULL && real_path != NULL) {
        const size_t length = strcmp(real_folder, "/") == 0 ? 0 : strlen(real_folder);
        inside = strncmp(real_path, real_folder, length) == 0 &&
                 (real_path[length] == '/' || real_path[length] == '\0');
    } else {
        inside = stays_below(folder, path);
    }
    free(real_folder);
    free(real_path);
    return inside;
}

/* Candidate number i for where a file lies; NULL: there are no more, or memory is out. */
static char *candidate(const air_mitsuba *mitsuba, const air_xml *at, const char *name, size_t i)
{
    if (i > 0)
        return i - 1 < mitsuba->folder_count
                   ? air_path_join(mitsuba->context, mitsuba->folders[i - 1], name)
                   : NULL;
    char *folder = air_path_folder(mitsuba->context, at->file);
    char *path = folder != NULL ? air_path_join(mitsuba->context, folder, name) : NULL;
    air_free(mitsuba->context, folder);
    return path;
}

air_status air_mitsuba_filename(const air_mitsuba *mitsuba, const air_xml *at,
                                const char **out_name)
{
    *out_name = NULL;
    const air_status status = air_mitsuba_string(mitsuba, at, "filename", out_name);
    return status == AIR_OK && *out_name == NULL
               ? air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the parameter filename")
               : status;
}

air_status air_mitsuba_file(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                            char **out_path)
{
    if (name[0] == '\0')
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the name of a file");
    /* Where nothing is found the messages are about the scene's own folder. */
    char *path = air_path_join(mitsuba->context, mitsuba->folder, name);
    if (path == NULL)
        return AIR_ERROR_MEMORY;
    for (size_t i = 0; access(path, F_OK) != 0 && i <= mitsuba->folder_count; ++i) {
        char *other = candidate(mitsuba, at, name, i);
        if (other == NULL || access(other, F_OK) != 0) {
            air_free(mitsuba->context, other);
            continue;
        }
        air_free(mitsuba->context, path);
        path = other;
    }
    if (!mitsuba->import->params->files_anywhere && !is_inside(mitsuba->folder, path)) {
        air_free(mitsuba->context, path);
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "\"%.200s\" lies outside the scene's folder, expected a path "
                                "within it, or --files-anywhere",
                                name);
    }
    *out_path = path;
    return AIR_OK;
}

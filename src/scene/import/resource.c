#include "scene/import/resource.h"

#include <stdint.h>
#include <string.h>

/* Length of the folder part of a path with its slash. */
static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash == NULL ? 0 : (size_t)(slash - path) + 1;
}

char *air_path_folder(air_context *context, const char *path)
{
    const size_t length = folder_length(path);
    char *folder = air_allocate(context, length + 1, 1);
    if (folder == NULL) {
        (void)air_fail_memory(context, path);
        return NULL;
    }
    memcpy(folder, path, length);
    return folder;
}

char *air_path_with_ending(air_context *context, const char *path, const char *ending)
{
    const size_t folder = folder_length(path);
    const char *dot = strrchr(path + folder, '.');
    const size_t stem = dot == NULL ? strlen(path) : (size_t)(dot - path);
    char *result = air_allocate(context, stem + strlen(ending) + 1, 1);
    if (result == NULL) {
        (void)air_fail_memory(context, path);
        return NULL;
    }
    memcpy(result, path, stem);
    memcpy(result + stem, ending, strlen(ending) + 1);
    return result;
}

char *air_path_join(air_context *context, const char *folder, const char *path)
{
    char *result = air_string_format(context, "%s%s", path[0] == '/' ? "" : folder, path);
    if (result == NULL)
        (void)air_fail_memory(context, path);
    return result;
}

/* 0..63, or -1. Both the standard and the URL alphabet. */
static int base64_digit(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    if (c == '+' || c == '-')
        return 62;
    return c == '/' || c == '_' ? 63 : -1;
}

size_t air_base64_decode(const char *text, size_t length, uint8_t *out)
{
    size_t size = 0;
    uint32_t bits = 0;
    unsigned bit_count = 0;
    while (length > 0 && text[length - 1] == '=')
        --length;
    for (size_t i = 0; i < length; ++i) {
        const int digit = base64_digit(text[i]);
        if (digit < 0)
            return SIZE_MAX;
        bits = (bits << 6 | (uint32_t)digit) & 0xffffu;
        bit_count += 6;
        if (bit_count >= 8) {
            bit_count -= 8;
            out[size++] = (uint8_t)(bits >> bit_count);
        }
    }
    return bit_count == 6 ? SIZE_MAX : size; /* a lone last digit is no byte */
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    const char lower = (char)(c | 0x20);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/* Resolves %XX in place; returns the new length. Sequences that are not %XX stay as they are. */
static size_t percent_decode(char *text, size_t length)
{
    size_t end = 0;
    for (size_t i = 0; i < length; ++i) {
        const int high = text[i] == '%' && i + 2 < length ? hex_digit(text[i + 1]) : -1;
        const int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
        text[end++] = low >= 0 ? (char)(high * 16 + low) : text[i];
        if (low >= 0)
            i += 2;
    }
    text[end] = '\0';
    return end;
}

/* "scheme:" at the start of a URI, RFC 3986, section 3.1. */
static bool has_scheme(const char *uri)
{
    const size_t length = strcspn(uri, ":/?#");
    if (uri[length] != ':' || length == 0)
        return false;
    for (size_t i = 0; i < length; ++i) {
        const bool letter = (uri[i] | 0x20) >= 'a' && (uri[i] | 0x20) <= 'z';
        const bool other = (uri[i] >= '0' && uri[i] <= '9') || strchr("+-.", uri[i]) != NULL;
        if (!letter && !(i > 0 && other))
            return false;
    }
    return true;
}

static air_status read_data_uri(const air_json *at, const char *uri, void **out_data,
                                size_t *out_size)
{
    air_context *context = at->document->context;
    const char *comma = strchr(uri, ',');
    if (comma == NULL)
        return air_json_fail(at, AIR_ERROR_FORMAT, "expected a comma in the data URI");
    const char *text = comma + 1;
    const size_t length = strlen(text);
    uint8_t *data = air_allocate(context, length + 4, 1);
    if (data == NULL)
        return air_fail_memory(context, "data URI");
    const char marker[] = ";base64";
    const size_t marker_length = sizeof marker - 1, head = (size_t)(comma - uri);
    if (head >= marker_length && memcmp(comma - marker_length, marker, marker_length) == 0) {
        *out_size = air_base64_decode(text, length, data);
        if (*out_size == SIZE_MAX) {
            air_free(context, data);
            return air_json_fail(at, AIR_ERROR_FORMAT,
                                 "expected base64 after the comma of the data URI");
        }
        data[*out_size] = 0;
    } else {
        memcpy(data, text, length);
        *out_size = percent_decode((char *)data, length);
    }
    *out_data = data;
    return AIR_OK;
}

static air_status read_relative_file(const air_json *at, const char *uri, void **out_data,
                                     size_t *out_size, char **out_what)
{
    air_context *context = at->document->context;
    char *relative = air_string_copy(context, uri);
    if (relative == NULL)
        return air_fail_memory(context, uri);
    const size_t length = percent_decode(relative, strlen(relative));
    char *path = NULL;
    air_status status = AIR_OK;
    if (length == 0 || strlen(relative) != length || relative[0] == '/')
        status = air_json_expected(at, "a path relative to the scene file");
    if (status == AIR_OK) {
        path = air_path_join(context, at->document->folder, relative);
        status = path == NULL ? AIR_ERROR_MEMORY : air_file_read(context, path, out_data, out_size);
    }
    if (status == AIR_OK)
        *out_what = path;
    else
        air_free(context, path);
    air_free(context, relative);
    return status;
}

air_status air_resource_read(const air_json *at, void **out_data, size_t *out_size, char **out_what)
{
    air_context *context = at->document->context;
    const char *uri = NULL;
    air_status status = air_json_string(at, &uri);
    if (status == AIR_OK && uri == NULL)
        status = air_json_expected(at, "a URI");
    if (status != AIR_OK)
        return status;
    if (strncmp(uri, "data:", 5) == 0) {
        char place[256];
        air_json_describe(at, place, sizeof place);
        char *what = air_string_format(context, "%s: %s", at->document->file, place);
        if (what == NULL)
            return air_fail_memory(context, "data URI");
        status = read_data_uri(at, uri, out_data, out_size);
        if (status == AIR_OK)
            *out_what = what;
        else
            air_free(context, what);
        return status;
    }
    if (has_scheme(uri))
        return air_json_fail(at, AIR_ERROR_UNSUPPORTED,
                             "expected a relative path or a data URI, found \"%.*s:...\"",
                             (int)strcspn(uri, ":"), uri);
    return read_relative_file(at, uri, out_data, out_size, out_what);
}

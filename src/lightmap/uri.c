/* uri.c: what glTF files refer to. */
#include "lightmap/uri.h"

#include <stdint.h>
#include <string.h>

char *air_uri_folder(air_context *context, const char *path)
{
    const char *slash = strrchr(path, '/');
    const size_t length = slash == NULL ? 0 : (size_t)(slash - path) + 1;
    char *folder = air_string_copy(context, path);
    if (folder == NULL) {
        (void)air_fail_memory(context, path);
        return NULL;
    }
    folder[length] = '\0';
    return folder;
}

char *air_uri_encode(air_context *context, const char *name)
{
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
    static const char hex[] = "0123456789ABCDEF";
    char *uri = air_allocate(context, 3 * strlen(name) + 1, 1);
    if (uri == NULL) {
        (void)air_fail_memory(context, name);
        return NULL;
    }
    char *out = uri;
    for (; *name != '\0'; name++) {
        const unsigned char byte = (unsigned char)*name;
        if (strchr(plain, *name) != NULL) {
            *out++ = *name;
        } else {
            *out++ = '%';
            *out++ = hex[byte >> 4];
            *out++ = hex[byte & 15];
        }
    }
    *out = '\0';
    return uri;
}

static int hex_digit(char c)
{
    static const char digits[] = "0123456789abcdef";
    const char *at = c != '\0' ? strchr(digits, c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c) : NULL;
    return at == NULL ? -1 : (int)(at - digits);
}

/* Resolves %XX in place; returns the new length. */
static size_t percent_decode(char *text)
{
    char *out = text;
    for (const char *in = text; *in != '\0'; in++) {
        const int high = *in == '%' ? hex_digit(in[1]) : -1;
        const int low = high >= 0 ? hex_digit(in[2]) : -1;
        *out++ = low >= 0 ? (char)(16 * high + low) : *in;
        in += low >= 0 ? 2 : 0;
    }
    *out = '\0';
    return (size_t)(out - text);
}

static int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c != '\0' ? strchr(digits, c) : NULL;
    return at != NULL ? (int)(at - digits) : c == '-' ? 62 : c == '_' ? 63 : -1;
}

/* Decodes in place; SIZE_MAX if the text is not base64. */
static size_t base64_decode(char *text)
{
    uint8_t *out = (uint8_t *)text;
    size_t length = strlen(text), size = 0;
    uint32_t bits = 0;
    unsigned count = 0;
    while (length > 0 && text[length - 1] == '=') {
        length--;
    }
    for (size_t i = 0; i < length; i++) {
        const int digit = base64_digit(text[i]);
        if (digit < 0) {
            return SIZE_MAX;
        }
        bits = (bits << 6 | (uint32_t)digit) & 0xffff;
        count += 6;
        if (count >= 8) {
            count -= 8;
            out[size++] = (uint8_t)(bits >> count);
        }
    }
    return count == 6 ? SIZE_MAX : size;
}

static air_status read_data(const air_place *at, const char *uri, void **out_data, size_t *out_size,
                            char **out_kind)
{
    static const char marker[] = ";base64";
    const size_t marker_length = sizeof marker - 1;
    const char *comma = strchr(uri, ',');
    if (comma == NULL) {
        return air_place_wrong(at, "a comma in the data URI");
    }
    const size_t head = (size_t)(comma - uri);
    const bool base64 =
        head >= marker_length && memcmp(comma - marker_length, marker, marker_length) == 0;
    char *text = air_string_copy(at->context, comma + 1);
    char *kind = air_string_format(at->context, "%.*s", (int)strcspn(uri + 5, ";,"), uri + 5);
    if (text == NULL || kind == NULL) {
        air_free(at->context, text);
        air_free(at->context, kind);
        return air_fail_memory(at->context, at->file);
    }
    *out_size = base64 ? base64_decode(text) : percent_decode(text);
    if (*out_size == SIZE_MAX) {
        air_free(at->context, text);
        air_free(at->context, kind);
        return air_place_wrong(at, "base64 after the comma of the data URI");
    }
    *out_data = text;
    *out_kind = kind;
    return AIR_OK;
}

static air_status read_file(const air_place *at, const char *folder, const char *uri,
                            void **out_data, size_t *out_size, char **out_kind)
{
    air_context *context = at->context;
    char *name = air_string_copy(context, uri);
    if (name == NULL) {
        return air_fail_memory(context, at->file);
    }
    const size_t length = percent_decode(name);
    char *path = NULL, *kind = NULL;
    air_status status = AIR_OK;
    if (length == 0 || strlen(name) != length || name[0] == '/') {
        status = air_place_wrong(at, "a path relative to the scene file");
        goto cleanup;
    }
    const char *dot = strrchr(name, '.');
    path = air_string_format(context, "%s%s", folder, name);
    kind = air_string_copy(context, dot != NULL && strchr(dot, '/') == NULL ? dot : "");
    status = path == NULL || kind == NULL ? air_fail_memory(context, at->file)
                                          : air_file_read(context, path, out_data, out_size);
    if (status == AIR_OK) {
        *out_kind = kind;
        kind = NULL;
    }
cleanup:
    air_free(context, kind);
    air_free(context, path);
    air_free(context, name);
    return status;
}

air_status air_uri_read(const air_place *at, const char *folder, void **out_data, size_t *out_size,
                        char **out_kind)
{
    const char *uri = json_string_value(at->value);
    if (uri == NULL) {
        return air_place_wrong(at, "a URI");
    }
    if (strncmp(uri, "data:", 5) == 0) {
        return read_data(at, uri, out_data, out_size, out_kind);
    }
    const size_t scheme = strcspn(uri, ":/?#");
    if (uri[scheme] == ':') {
        return air_place_wrong(at, "a relative path or a data URI");
    }
    return read_file(at, folder, uri, out_data, out_size, out_kind);
}

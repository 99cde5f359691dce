/* place.c: JSON files of this room, read strictly. */
#include "lightmap/place.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

air_status air_place_parse(air_context *context, const char *file, const char *text, size_t size,
                           json_t **out_root)
{
    json_error_t error;
    *out_root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &error);
    if (*out_root == NULL) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s:%d:%d: not JSON: %s", file, error.line,
                        error.column, error.text);
    }
    return AIR_OK;
}

air_place air_place_root(air_context *context, const char *file, json_t *root)
{
    return (air_place){.context = context, .file = file, .text = "$", .value = root};
}

/* A place below another; its text is cut where it gets too long. */
static air_place below(const air_place *parent, json_t *value)
{
    air_place at = {.context = parent->context, .file = parent->file, .value = value};
    memcpy(at.text, parent->text, sizeof at.text);
    return at;
}

air_place air_place_get(const air_place *object, const char *key)
{
    air_place at = below(object, json_object_get(object->value, key));
    const size_t used = strlen(at.text);
    (void)snprintf(at.text + used, sizeof at.text - used, ".%s", key);
    return at;
}

air_place air_place_at(const air_place *array, size_t index)
{
    air_place at = below(array, json_array_get(array->value, index));
    const size_t used = strlen(at.text);
    (void)snprintf(at.text + used, sizeof at.text - used, "[%zu]", index);
    return at;
}

size_t air_place_count(const air_place *array) { return json_array_size(array->value); }

air_status air_place_wrong(const air_place *at, const char *what, ...)
{
    char expected[256];
    va_list arguments;
    va_start(arguments, what);
    (void)vsnprintf(expected, sizeof expected, what, arguments);
    va_end(arguments);
    return air_fail(at->context, AIR_ERROR_FORMAT, "%s: %s: expected %s", at->file, at->text,
                    expected);
}

air_status air_place_array(const air_place *at)
{
    return json_is_array(at->value) ? AIR_OK : air_place_wrong(at, "an array");
}

air_status air_place_integer(const air_place *at, int64_t least, int64_t largest, int64_t *out)
{
    const int64_t value = json_integer_value(at->value);
    if (!json_is_integer(at->value) || value < least || value > largest) {
        return air_place_wrong(at, "a whole number from %lld to %lld", (long long)least,
                               (long long)largest);
    }
    *out = value;
    return AIR_OK;
}

air_status air_place_size(const air_place *at, size_t largest, size_t *out)
{
    int64_t value = 0;
    const int64_t limit = largest < INT64_MAX ? (int64_t)largest : INT64_MAX;
    const air_status status = air_place_integer(at, 0, limit, &value);
    if (status == AIR_OK) {
        *out = (size_t)value;
    }
    return status;
}

air_status air_place_bool(const air_place *at, bool *out)
{
    if (!json_is_boolean(at->value)) {
        return air_place_wrong(at, "true or false");
    }
    *out = json_is_true(at->value);
    return AIR_OK;
}

air_status air_place_string(const air_place *at, char **out)
{
    if (!json_is_string(at->value) ||
        strlen(json_string_value(at->value)) != json_string_length(at->value)) {
        return air_place_wrong(at, "a text");
    }
    char *copy = air_string_copy(at->context, json_string_value(at->value));
    if (copy == NULL) {
        return air_fail_memory(at->context, at->file);
    }
    air_free(at->context, *out);
    *out = copy;
    return AIR_OK;
}

air_status air_place_floats(const air_place *at, size_t count, float *out)
{
    if (!json_is_array(at->value) || air_place_count(at) != count) {
        return air_place_wrong(at, "an array of %zu numbers", count);
    }
    for (size_t i = 0; i < count; i++) {
        const json_t *item = json_array_get(at->value, i);
        const double value = json_number_value(item);
        if (!json_is_number(item) || !(fabs(value) <= (double)FLT_MAX)) {
            const air_place element = air_place_at(at, i);
            return air_place_wrong(&element, "a number, finite in single precision");
        }
        out[i] = (float)value;
    }
    return AIR_OK;
}

air_status air_place_new_floats(const air_place *at, size_t count, float **out)
{
    if (!json_is_array(at->value) || air_place_count(at) != count) {
        return air_place_wrong(at, "an array of %zu numbers", count);
    }
    float *values = air_allocate(at->context, count, sizeof *values);
    if (values == NULL) {
        return air_fail_memory(at->context, at->file);
    }
    const air_status status = air_place_floats(at, count, values);
    if (status != AIR_OK) {
        air_free(at->context, values);
        return status;
    }
    *out = values;
    return AIR_OK;
}

air_status air_place_file_name(const air_place *at, const char **out)
{
    const char *name = json_string_value(at->value);
    if (name == NULL || name[0] == '\0' || name[0] == '.' || strpbrk(name, "/\\:") != NULL) {
        return air_place_wrong(at, "the name of a file beside this one");
    }
    *out = name;
    return AIR_OK;
}

json_t *air_place_text(const char *text)
{
    json_t *string = json_string(text);
    if (string != NULL) {
        return string;
    }
    /* Not UTF-8: keep what is ASCII. */
    char kept[512];
    size_t length = 0;
    for (; text[length] != '\0' && length < sizeof kept - 1; length++) {
        kept[length] = (unsigned char)text[length] < 128 ? text[length] : '?';
    }
    return json_stringn(kept, length);
}

json_t *air_place_numbers(const float *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++) {
        json_array_append_new(array, json_real((double)values[i]));
    }
    return array;
}

#include "scene/import/json_place.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { AIR_PLACE_SIZE = 256, AIR_FOUND_SIZE = 64 };

air_status air_json_parse(const air_json_document *document, const char *text, size_t size,
                          json_t **out_json)
{
    static const char byte_order_mark[] = "\xef\xbb\xbf"; /* some editors begin UTF-8 with it */
    json_error_t error;
    if (size >= 3 && memcmp(text, byte_order_mark, 3) == 0) {
        text += 3;
        size -= 3;
    }
    json_t *json = json_loadb(text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &error);
    if (json == NULL && json_error_code(&error) == json_error_out_of_memory)
        return air_fail_memory(document->context, document->file);
    if (json == NULL)
        return air_fail(document->context, AIR_ERROR_FORMAT,
                        "%s: %s: not valid JSON at line %d, column %d: %s", document->file,
                        document->prefix, error.line, error.column, error.text);
    *out_json = json;
    return AIR_OK;
}

air_json air_json_root(const air_json_document *document, json_t *value)
{
    return (air_json){.document = document, .value = value};
}

air_json air_json_get(const air_json *object, const char *key)
{
    return (air_json){.document = object->document,
                      .parent = object,
                      .key = key,
                      .value = json_object_get(object->value, key)};
}

air_json air_json_at(const air_json *array, size_t index)
{
    return (air_json){.document = array->document,
                      .parent = array,
                      .index = index,
                      .value = json_array_get(array->value, index)};
}

size_t air_json_count(const air_json *array) { return json_array_size(array->value); }

/* ---- places as text ---- */

/* Appends, cutting at size; returns the new length. */
static size_t append(char *buffer, size_t size, size_t length, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static size_t append(char *buffer, size_t size, size_t length, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int added = vsnprintf(buffer + length, size - length, format, arguments);
    va_end(arguments);
    if (added < 0)
        return length;
    const size_t end = length + (size_t)added;
    return end < size ? end : size - 1;
}

static bool is_plain_key(const char *key)
{
    if (key[0] == '\0' || strlen(key) > 64)
        return false;
    for (const char *c = key; *c != '\0'; ++c) {
        const bool letter = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || *c == '_';
        if (!letter && !(*c >= '0' && *c <= '9'))
            return false;
    }
    return true;
}

/* The way from the root, without the root. */
static size_t append_steps(const air_json *at, char *buffer, size_t size, size_t length)
{
    if (at->parent == NULL)
        return length;
    length = append_steps(at->parent, buffer, size, length);
    if (at->key == NULL)
        return append(buffer, size, length, "[%zu]", at->index);
    if (is_plain_key(at->key))
        return append(buffer, size, length, ".%s", at->key);
    return append(buffer, size, length, "[\"%.64s\"]", at->key);
}

/* Is the value at `path` the one at `outer`, or a part of it? */
static bool is_within(const char *path, const char *outer)
{
    const size_t length = strlen(outer);
    return strncmp(path, outer, length) == 0 && strchr(".[", path[length]) != NULL;
}

/* The option that said the value at a path, or what it is in, or else the first thing in it. */
static const air_json_column *match_column(const air_json_document *document, const char *path)
{
    for (size_t i = 0; i < document->column_count; ++i)
        if (is_within(path, document->columns[i].path))
            return &document->columns[i];
    for (size_t i = 0; i < document->column_count; ++i)
        if (is_within(document->columns[i].path, path))
            return &document->columns[i];
    return NULL;
}

/* The same, or, for something that was not said, the option that said something beside it; cuts the
 * path. */
static const air_json_column *find_column(const air_json_document *document, char *path)
{
    while (path[0] != '\0') {
        const air_json_column *found = match_column(document, path);
        char *last = strrchr(path, '.');
        if (found != NULL || last == NULL)
            return found;
        *last = '\0';
    }
    return NULL;
}

void air_json_describe(const air_json *at, char *buffer, size_t size)
{
    char path[AIR_PLACE_SIZE] = "";
    (void)append_steps(at, path, sizeof path, 0);
    buffer[0] = '\0';
    if (at->document->columns == NULL) {
        (void)append(buffer, size, 0, "%s%s", at->document->prefix, path);
        return;
    }
    const air_json_column *column = find_column(at->document, path);
    if (column != NULL)
        (void)append(buffer, size, 0, "column %zu (%s)", column->column, column->option);
    else
        (void)append(buffer, size, 0, "column 1");
}

char *air_json_annotate(const air_json *at, const char *name)
{
    char place[AIR_PLACE_SIZE];
    air_json_describe(at, place, sizeof place);
    char *text =
        air_string_format(at->document->context, "%s (%s: %s)", name, at->document->file, place);
    if (text == NULL)
        (void)air_fail_memory(at->document->context, name);
    return text;
}

/* What a message says it found. */
static void describe_value(const json_t *value, char buffer[AIR_FOUND_SIZE])
{
    if (value == NULL) {
        snprintf(buffer, AIR_FOUND_SIZE, "nothing");
    } else if (json_is_object(value)) {
        snprintf(buffer, AIR_FOUND_SIZE, "an object");
    } else if (json_is_array(value)) {
        snprintf(buffer, AIR_FOUND_SIZE, "an array of %zu", json_array_size(value));
    } else {
        const size_t room = AIR_FOUND_SIZE - 4;
        const size_t size = json_dumpb(
            value, buffer, room, JSON_ENCODE_ANY | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(15));
        if (size <= room)
            buffer[size] = '\0';
        else
            memcpy(buffer + room, "...", 4);
    }
}

/* What is wrong with an argument is no matter of a file's format. */
static air_status status_of(const air_json *at, air_status status)
{
    return at->document->columns != NULL && status == AIR_ERROR_FORMAT ? AIR_ERROR_ARGUMENT
                                                                       : status;
}

air_status air_json_expected(const air_json *at, const char *what, ...)
{
    char place[AIR_PLACE_SIZE], found[AIR_FOUND_SIZE], expected[AIR_PLACE_SIZE];
    va_list arguments;
    va_start(arguments, what);
    vsnprintf(expected, sizeof expected, what, arguments);
    va_end(arguments);
    air_json_describe(at, place, sizeof place);
    describe_value(at->value, found);
    return air_fail(at->document->context, status_of(at, AIR_ERROR_FORMAT),
                    "%s: %s: expected %s, found %s", at->document->file, place, expected, found);
}

air_status air_json_fail(const air_json *at, air_status status, const char *sentence, ...)
{
    char place[AIR_PLACE_SIZE], text[2 * AIR_PLACE_SIZE];
    va_list arguments;
    va_start(arguments, sentence);
    vsnprintf(text, sizeof text, sentence, arguments);
    va_end(arguments);
    air_json_describe(at, place, sizeof place);
    return air_fail(at->document->context, status_of(at, status), "%s: %s: %s", at->document->file,
                    place, text);
}

air_status air_json_place_error(const air_json *at, air_status status)
{
    if (status == AIR_OK || status == AIR_ERROR_MEMORY)
        return status;
    char sentence[2 * AIR_PLACE_SIZE]; /* a copy: the next failure overwrites the last one's text */
    snprintf(sentence, sizeof sentence, "%s", air_context_last_error(at->document->context));
    return air_json_fail(at, status, "%s", sentence);
}

/* ---- checks ---- */

air_status air_json_require(const air_json *at, const char *what)
{
    return at->value != NULL ? AIR_OK : air_json_expected(at, "%s", what);
}

air_status air_json_check_object(const air_json *at, bool required)
{
    if (json_is_object(at->value) || (at->value == NULL && !required))
        return AIR_OK;
    return air_json_expected(at, "an object");
}

air_status air_json_check_array(const air_json *at, bool required)
{
    if (json_is_array(at->value) || (at->value == NULL && !required))
        return AIR_OK;
    return air_json_expected(at, "an array");
}

enum { AIR_NEAR_LENGTH = 31 };

/* Edits (insert, delete, replace) from a to b, both at most AIR_NEAR_LENGTH long; letters compare
 * without case. */
static size_t edit_distance(const char *a, const char *b)
{
    size_t row[AIR_NEAR_LENGTH + 1];
    const size_t b_length = strlen(b);
    for (size_t j = 0; j <= b_length; ++j)
        row[j] = j;
    for (size_t i = 0; a[i] != '\0'; ++i) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < b_length; ++j) {
            const size_t replaced = diagonal + ((a[i] | 0x20) != (b[j] | 0x20));
            const size_t inserted = (row[j] < row[j + 1] ? row[j] : row[j + 1]) + 1;
            diagonal = row[j + 1];
            row[j + 1] = replaced < inserted ? replaced : inserted;
        }
    }
    return row[b_length];
}

const char *air_nearest_name(const char *text, const char *const *names, size_t count)
{
    const char *nearest = NULL;
    if (strlen(text) > AIR_NEAR_LENGTH)
        return NULL;
    size_t least = strlen(text) / 2 + 1; /* farther than half the word is another word */
    for (size_t i = 0; i < count; ++i) {
        if (strlen(names[i]) > AIR_NEAR_LENGTH)
            continue;
        const size_t distance = edit_distance(text, names[i]);
        if (distance < least) {
            least = distance;
            nearest = names[i];
        }
    }
    return nearest;
}

static void list_names(const char *const *names, size_t count, char *buffer, size_t size)
{
    size_t length = 0;
    buffer[0] = '\0';
    for (size_t i = 0; i < count; ++i)
        length = append(buffer, size, length, "%s%s", i == 0 ? "" : ", ", names[i]);
}

air_status air_json_check_keys(const air_json *object, const char *const *keys, size_t key_count)
{
    const char *key;
    json_t *value;
    json_object_foreach(object->value, key, value)
    {
        bool known = strcmp(key, "comment") == 0;
        for (size_t i = 0; i < key_count && !known; ++i)
            known = strcmp(key, keys[i]) == 0;
        if (known)
            continue;
        const air_json at = {
            .document = object->document, .parent = object, .key = key, .value = value};
        const char *nearest = air_nearest_name(key, keys, key_count);
        if (nearest != NULL)
            return air_json_fail(&at, AIR_ERROR_FORMAT, "unknown key; did you mean \"%s\"?",
                                 nearest);
        char list[2 * AIR_PLACE_SIZE - 64];
        list_names(keys, key_count, list, sizeof list);
        return air_json_fail(&at, AIR_ERROR_FORMAT, "unknown key; known are %s", list);
    }
    return AIR_OK;
}

/* ---- getters ---- */

static const char *range_text(air_json_range range)
{
    switch (range) {
    case AIR_JSON_NON_NEGATIVE:
        return "a number >= 0";
    case AIR_JSON_POSITIVE:
        return "a number > 0";
    case AIR_JSON_UNIT:
        return "a number in [0, 1]";
    case AIR_JSON_SIGNED_OPEN:
        return "a number above -1 and below 1";
    case AIR_JSON_AT_LEAST_1:
        return "a number >= 1";
    case AIR_JSON_ANY:
        break;
    }
    return "a number";
}

/* What counts is the float that a number becomes: 1e-60 is no positive number. */
static bool in_range(air_json_range range, float value)
{
    switch (range) {
    case AIR_JSON_NON_NEGATIVE:
        return value >= 0.0f;
    case AIR_JSON_POSITIVE:
        return value > 0.0f;
    case AIR_JSON_UNIT:
        return value >= 0.0f && value <= 1.0f;
    case AIR_JSON_SIGNED_OPEN:
        return value > -1.0f && value < 1.0f;
    case AIR_JSON_AT_LEAST_1:
        return value >= 1.0f;
    case AIR_JSON_ANY:
        break;
    }
    return true;
}

air_status air_json_number(const air_json *at, air_json_range range, double *out)
{
    if (at->value == NULL)
        return AIR_OK;
    const double value = json_number_value(at->value);
    if (json_is_number(at->value) && !(fabs(value) <= (double)FLT_MAX))
        return air_json_expected(at, "a number within single precision");
    if (!json_is_number(at->value) || !in_range(range, (float)value))
        return air_json_expected(at, "%s", range_text(range));
    *out = value;
    return AIR_OK;
}

air_status air_json_float(const air_json *at, air_json_range range, float *out)
{
    double value = (double)*out;
    const air_status status = air_json_number(at, range, &value);
    if (status == AIR_OK)
        *out = (float)value;
    return status;
}

air_status air_json_floats(const air_json *at, air_json_range range, size_t count, float *out)
{
    if (at->value == NULL)
        return AIR_OK;
    if (!json_is_array(at->value) || json_array_size(at->value) != count)
        return air_json_expected(at, "an array of %zu numbers", count);
    for (size_t i = 0; i < count; ++i) {
        const air_json element = air_json_at(at, i);
        const air_status status = air_json_float(&element, range, &out[i]);
        if (status != AIR_OK)
            return status;
    }
    return AIR_OK;
}

air_status air_json_color(const air_json *at, air_json_range range, float out[3])
{
    if (json_is_array(at->value))
        return air_json_floats(at, range, 3, out);
    if (at->value != NULL && !json_is_number(at->value))
        return air_json_expected(at, "%s, or an array of three", range_text(range));
    float grey = out[0];
    const air_status status = air_json_float(at, range, &grey);
    if (status == AIR_OK && at->value != NULL)
        out[0] = out[1] = out[2] = grey;
    return status;
}

air_status air_json_bool(const air_json *at, bool *out)
{
    if (at->value == NULL)
        return AIR_OK;
    if (!json_is_boolean(at->value))
        return air_json_expected(at, "true or false");
    *out = json_is_true(at->value);
    return AIR_OK;
}

air_status air_json_string(const air_json *at, const char **out)
{
    if (at->value == NULL)
        return AIR_OK;
    if (!json_is_string(at->value))
        return air_json_expected(at, "a string");
    *out = json_string_value(at->value);
    return AIR_OK;
}

/* The whole number a value is; some exporters write 3.0 for 3, which JSON says is the same. */
static bool whole_number(const json_t *value, size_t *out)
{
    const double largest = 9007199254740992.0; /* 2^53 */
    const double number = json_number_value(value);
    if (!json_is_number(value) || !(number >= 0.0) || number > largest || floor(number) != number)
        return false;
    *out = (size_t)number;
    return true;
}

air_status air_json_size(const air_json *at, size_t *out)
{
    if (at->value == NULL || whole_number(at->value, out))
        return AIR_OK;
    return air_json_expected(at, "a whole number >= 0");
}

air_status air_json_index(const air_json *at, size_t limit, const char *what, size_t *out)
{
    size_t index = 0;
    if (at->value == NULL)
        return AIR_OK;
    if (!whole_number(at->value, &index))
        return air_json_expected(at, "the index of %s", what);
    if (index >= limit)
        return air_json_expected(at, "the index of %s, of which there are %zu", what, limit);
    *out = index;
    return AIR_OK;
}

air_status air_json_choice(const air_json *at, const char *const *names, size_t count, size_t *out)
{
    if (at->value == NULL)
        return AIR_OK;
    for (size_t i = 0; i < count && json_is_string(at->value); ++i)
        if (strcmp(json_string_value(at->value), names[i]) == 0) {
            *out = i;
            return AIR_OK;
        }
    char list[AIR_PLACE_SIZE - 16];
    list_names(names, count, list, sizeof list);
    return air_json_expected(at, "one of %s", list);
}

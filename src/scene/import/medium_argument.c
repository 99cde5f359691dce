#include <stdio.h>
#include <string.h>

#include "scene/import/import.h"
#include "scene/import/number.h"

/* How the text of an option becomes JSON. What does not fit becomes a string, which the reader of
 * the JSON then refuses with the range it wants. */
typedef enum air_option_kind {
    AIR_OPTION_TEXT = 0,
    AIR_OPTION_NUMBERS = 1,   /* one, or several with commas between */
    AIR_OPTION_LENGTH = 2,    /* a number, with m or km behind it if one likes */
    AIR_OPTION_BOX = 3,       /* x,y,z:x,y,z, as {"min", "max"} */
    AIR_OPTION_BOX_MAP = 4,   /* the same, as the map of the unit cube to it */
    AIR_OPTION_UNBOUNDED = 5, /* without a value */
    AIR_OPTION_SPHERE = 6     /* x,y,z,r, as {"center", "radius"} */
} air_option_kind;

typedef struct air_option {
    const char *name;
    const char *path; /* in the JSON of a medium, docs/sidecar.md */
    air_option_kind kind;
} air_option;

static const air_option options[] = {
    {"name", ".name", AIR_OPTION_TEXT},
    {"sigma_s", ".sigma_s", AIR_OPTION_NUMBERS},
    {"sigma_a", ".sigma_a", AIR_OPTION_NUMBERS},
    {"sigma_t", ".sigma_t", AIR_OPTION_NUMBERS},
    {"albedo", ".albedo", AIR_OPTION_NUMBERS},
    {"visibility", ".visibility", AIR_OPTION_LENGTH},
    {"emission", ".emission", AIR_OPTION_NUMBERS},
    {"phase", ".phase", AIR_OPTION_TEXT},
    {"g", ".g", AIR_OPTION_NUMBERS},
    {"box", ".boundary.box", AIR_OPTION_BOX},
    {"sphere", ".boundary.sphere", AIR_OPTION_SPHERE},
    {"mesh", ".boundary.mesh", AIR_OPTION_TEXT},
    {"unbounded", ".boundary", AIR_OPTION_UNBOUNDED},
    {"exp_base", ".density.exponential.base_height", AIR_OPTION_NUMBERS},
    {"exp_height", ".density.exponential.scale_height", AIR_OPTION_NUMBERS},
    {"grid", ".density.grid.file", AIR_OPTION_TEXT},
    {"grid_name", ".density.grid.name", AIR_OPTION_TEXT},
    {"grid_size", ".density.grid.size", AIR_OPTION_NUMBERS},
    {"grid_channels", ".density.grid.channels", AIR_OPTION_NUMBERS},
    {"grid_box", ".density.grid.to_world", AIR_OPTION_BOX_MAP},
    {"albedo_grid", ".albedo_grid.file", AIR_OPTION_TEXT},
    {"emission_grid", ".emission_grid.file", AIR_OPTION_TEXT},
    {"detail_strength", ".detail.strength", AIR_OPTION_NUMBERS},
    {"detail_scale", ".detail.scale", AIR_OPTION_LENGTH},
    {"detail_octaves", ".detail.octaves", AIR_OPTION_NUMBERS},
    {"detail_seed", ".detail.seed", AIR_OPTION_NUMBERS},
    {"combine", ".combine", AIR_OPTION_TEXT},
    {"priority", ".priority", AIR_OPTION_NUMBERS},
};

enum { AIR_OPTION_COUNT = sizeof options / sizeof options[0] };
_Static_assert((int)AIR_OPTION_COUNT <= (int)AIR_MEDIUM_OPTIONS, "every option may be given once");

/* One option as it stands in the argument. */
typedef struct air_item {
    const char *name, *value;
    size_t name_length, value_length, column;
} air_item;

typedef struct air_argument {
    air_context *context;
    const char *file; /* names the argument in messages */
    json_t *json;
    air_json_column *columns;
    size_t count;
} air_argument;

static air_status fail_at(const air_argument *argument, const air_item *item, const char *sentence)
{
    return air_fail(argument->context, AIR_ERROR_ARGUMENT, "%s: column %zu: \"%.*s\": %s",
                    argument->file, item->column,
                    (int)(item->name_length < 60 ? item->name_length : 60), item->name, sentence);
}

static void trim(const char **text, size_t *length)
{
    while (*length > 0 && **text == ' ') {
        ++*text;
        --*length;
    }
    while (*length > 0 && (*text)[*length - 1] == ' ')
        --*length;
}

/* Splits a token at its '='. */
static air_item split(const char *token, size_t length, size_t column)
{
    const char *equals = memchr(token, '=', length);
    air_item item = {.name = token, .name_length = length, .column = column};
    if (equals != NULL) {
        item.name_length = (size_t)(equals - token);
        item.value = equals + 1;
        item.value_length = length - item.name_length - 1;
    }
    const char *start = item.name;
    trim(&item.name, &item.name_length);
    item.column += (size_t)(item.name - start);
    return item;
}

/* The next item from *offset on: up to the next comma behind which stands another NAME= or the word
 * unbounded. */
static air_item next_item(const char *text, size_t *offset)
{
    const size_t start = *offset;
    size_t end = start + strcspn(text + start, ",");
    while (text[end] == ',') {
        const size_t length = strcspn(text + end + 1, ",");
        const air_item next = split(text + end + 1, length, 1);
        const bool flag =
            next.name_length == strlen("unbounded") && strncmp(next.name, "unbounded", 9) == 0;
        if (next.value != NULL || flag)
            break;
        end += 1 + length;
    }
    *offset = text[end] == ',' ? end + 1 : end;
    air_item item = split(text + start, end - start, start + 1);
    if (item.value != NULL)
        trim(&item.value, &item.value_length);
    return item;
}

/* Up to `most` numbers with commas between; returns how many, 0 if the text is anything else. */
static size_t parse_numbers(const char *text, size_t length, size_t most, double *out)
{
    size_t count = 0, offset = 0;
    while (offset <= length) {
        const char *comma = memchr(text + offset, ',', length - offset);
        const size_t end = comma != NULL ? (size_t)(comma - text) : length;
        if (count == most || !air_number_parse(text + offset, end - offset, &out[count]))
            return 0;
        ++count;
        offset = end + 1;
    }
    return count;
}

static json_t *triple(const double values[3])
{
    return json_pack("[f,f,f]", values[0], values[1], values[2]);
}

/* A whole number stays one, so that messages show it as it was written. */
static json_t *number(double value)
{
    const bool whole = value > -1e15 && value < 1e15 && value == (double)(json_int_t)value;
    return whole ? json_integer((json_int_t)value) : json_real(value);
}

static json_t *numbers_json(const air_item *item)
{
    double values[3] = {0.0, 0.0, 0.0};
    const size_t count = parse_numbers(item->value, item->value_length, 3, values);
    if (count == 0)
        return json_stringn(item->value, item->value_length);
    if (count == 1)
        return number(values[0]);
    json_t *array = json_array();
    for (size_t i = 0; i < count; ++i)
        if (json_array_append_new(array, number(values[i])) != 0) {
            json_decref(array);
            return NULL;
        }
    return array;
}

static json_t *length_json(const air_item *item)
{
    size_t length = item->value_length;
    double value = 0.0, unit = 1.0;
    if (length > 0 && item->value[length - 1] == 'm') {
        --length;
        if (length > 0 && item->value[length - 1] == 'k') {
            --length;
            unit = 1000.0;
        }
    }
    if (!air_number_parse(item->value, length, &value))
        return json_stringn(item->value, item->value_length);
    return number(value * unit);
}

/* x,y,z:x,y,z */
static bool parse_box(const air_item *item, double min[3], double max[3])
{
    const char *colon = memchr(item->value, ':', item->value_length);
    if (colon == NULL)
        return false;
    const size_t first = (size_t)(colon - item->value);
    return parse_numbers(item->value, first, 3, min) == 3 &&
           parse_numbers(colon + 1, item->value_length - first - 1, 3, max) == 3;
}

static json_t *box_json(const double min[3], const double max[3])
{
    return json_pack("{s:o,s:o}", "min", triple(min), "max", triple(max));
}

static json_t *box_map_json(const double min[3], const double max[3])
{
    return json_pack("[[f,f,f,f],[f,f,f,f],[f,f,f,f]]", max[0] - min[0], 0.0, 0.0, min[0], 0.0,
                     max[1] - min[1], 0.0, min[1], 0.0, 0.0, max[2] - min[2], min[2]);
}

static json_t *sphere_json(const air_item *item)
{
    double values[4];
    return parse_numbers(item->value, item->value_length, 4, values) == 4
               ? json_pack("{s:o,s:o}", "center", triple(values), "radius", number(values[3]))
               : NULL;
}

/* NULL if the text is no box or sphere, or not in UTF-8. */
static json_t *value_json(const air_option *option, const air_item *item)
{
    double min[3], max[3];
    switch (option->kind) {
    case AIR_OPTION_NUMBERS:
        return numbers_json(item);
    case AIR_OPTION_LENGTH:
        return length_json(item);
    case AIR_OPTION_BOX:
        return parse_box(item, min, max) ? box_json(min, max) : NULL;
    case AIR_OPTION_BOX_MAP:
        return parse_box(item, min, max) ? box_map_json(min, max) : NULL;
    case AIR_OPTION_SPHERE:
        return sphere_json(item);
    case AIR_OPTION_UNBOUNDED:
        return json_string("unbounded");
    case AIR_OPTION_TEXT:
        break;
    }
    return json_stringn(item->value, item->value_length);
}

/* Puts a value (taken) at a path; false if something else is there, or memory is out. */
static bool place_value(json_t *object, const char *path, json_t *value)
{
    char key[32];
    for (;;) {
        const size_t length = strcspn(path + 1, ".");
        snprintf(key, sizeof key, "%.*s", (int)length, path + 1);
        path += 1 + length;
        json_t *inner = json_object_get(object, key);
        if (*path == '\0') {
            if (inner == NULL)
                return json_object_set_new(object, key, value) == 0;
            break;
        }
        if (inner == NULL && json_object_set_new(object, key, inner = json_object()) != 0)
            break;
        if (!json_is_object(inner))
            break;
        object = inner;
    }
    json_decref(value);
    return false;
}

static const air_option *find_option(const air_item *item)
{
    for (size_t i = 0; i < AIR_OPTION_COUNT; ++i)
        if (strlen(options[i].name) == item->name_length &&
            strncmp(options[i].name, item->name, item->name_length) == 0)
            return &options[i];
    return NULL;
}

static air_status fail_unknown(const air_argument *argument, const air_item *item)
{
    const char *names[AIR_OPTION_COUNT];
    char written[64], sentence[128];
    for (size_t i = 0; i < AIR_OPTION_COUNT; ++i)
        names[i] = options[i].name;
    snprintf(written, sizeof written, "%.*s",
             (int)(item->name_length < 60 ? item->name_length : 60), item->name);
    const char *nearest = air_nearest_name(written, names, AIR_OPTION_COUNT);
    if (nearest == NULL)
        return fail_at(argument, item, "unknown option; see docs/sidecar.md");
    snprintf(sentence, sizeof sentence, "unknown option; did you mean \"%s\"?", nearest);
    return fail_at(argument, item, sentence);
}

static const char *value_expected(const air_option *option)
{
    const bool box = option->kind == AIR_OPTION_BOX || option->kind == AIR_OPTION_BOX_MAP;
    return box                                 ? "expected two corners as x,y,z:x,y,z"
           : option->kind == AIR_OPTION_SPHERE ? "expected a centre and a radius as x,y,z,r"
                                               : "expected text in UTF-8";
}

static air_status add_item(air_argument *argument, const air_item *item)
{
    const air_option *option = find_option(item);
    if (option == NULL)
        return fail_unknown(argument, item);
    if (option->kind == AIR_OPTION_UNBOUNDED && item->value != NULL)
        return fail_at(argument, item, "expected no value");
    if (option->kind != AIR_OPTION_UNBOUNDED && (item->value == NULL || item->value_length == 0))
        return fail_at(argument, item, "expected \"=\" and a value");
    for (size_t i = 0; i < argument->count; ++i)
        if (strcmp(argument->columns[i].option, option->name) == 0)
            return fail_at(argument, item, "given twice");
    json_t *value = value_json(option, item);
    if (value == NULL)
        return fail_at(argument, item, value_expected(option));
    if (!place_value(argument->json, option->path, value))
        return fail_at(argument, item, "contradicts what stands before it");
    argument->columns[argument->count++] =
        (air_json_column){.path = option->path, .option = option->name, .column = item->column};
    return AIR_OK;
}

air_status air_medium_argument_parse(air_context *context, const char *file, const char *argument,
                                     json_t **out_json,
                                     air_json_column out_columns[AIR_MEDIUM_OPTIONS],
                                     size_t *out_column_count)
{
    if (argument[0] == '{') {
        const air_json_document document = {
            .context = context, .file = file, .prefix = "$", .folder = ""};
        *out_column_count = 0;
        return air_json_parse(&document, argument, strlen(argument), out_json);
    }
    air_argument parsed = {
        .context = context, .file = file, .json = json_object(), .columns = out_columns};
    if (parsed.json == NULL)
        return air_fail_memory(context, file);
    air_status status = AIR_OK;
    size_t offset = 0;
    do {
        const air_item item = next_item(argument, &offset);
        status = add_item(&parsed, &item);
    } while (argument[offset] != '\0' && status == AIR_OK);
    if (status != AIR_OK) {
        json_decref(parsed.json);
        return status;
    }
    *out_json = parsed.json;
    *out_column_count = parsed.count;
    return AIR_OK;
}

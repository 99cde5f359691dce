#include "render/owner.h"

#include <string.h>

#include "scene/snapshot.h"

const char *air_term_name(air_term term)
{
    static const char *const names[AIR_TERM_COUNT] = {"S0", "S+",       "M1",
                                                      "M2", "emission", "background"};
    return (unsigned)term < AIR_TERM_COUNT ? names[term] : "unknown";
}

const char *air_method_name(air_method method)
{
    static const char *const names[AIR_METHOD_COUNT] = {"path"};
    return (unsigned)method < AIR_METHOD_COUNT ? names[method] : "unknown";
}

size_t air_owner_table_size(const air_owner_table *table)
{
    return table->light_count * (table->medium_count + 1) * AIR_TERM_COUNT;
}

void air_owner_table_mask(const air_owner_table *table, air_method method, uint8_t *wanted)
{
    for (size_t i = 0; i < air_owner_table_size(table); i++) {
        wanted[i] = table->methods[i] == (uint8_t)method;
    }
}

air_method air_owner_table_get(const air_owner_table *table, size_t light, size_t medium,
                               air_term term)
{
    if (light >= table->light_count || medium > table->medium_count) {
        return AIR_METHOD_PATH;
    }
    const size_t row = light * (table->medium_count + 1) + medium;
    return (air_method)table->methods[row * AIR_TERM_COUNT + (size_t)term];
}

/* A word of the method string: text[0..length). */
typedef struct word {
    const char *text;
    int length;
} word;

static bool word_is(word w, const char *text)
{
    return strlen(text) == (size_t)w.length && strncmp(w.text, text, (size_t)w.length) == 0;
}

static air_status parse_method(const air_owner_table *table, word w, air_method *out)
{
    if (word_is(w, "auto") || word_is(w, "path")) {
        *out = AIR_METHOD_PATH;
        return AIR_OK;
    }
    return air_fail(table->context, AIR_ERROR_ARGUMENT,
                    "method \"%.*s\" is not known: expected auto or path", w.length, w.text);
}

static void assign(air_owner_table *table, size_t light, air_method method)
{
    const size_t row = (table->medium_count + 1) * AIR_TERM_COUNT;
    memset(table->methods + light * row, (int)method, row);
}

static air_status assign_named(air_owner_table *table, const air_snapshot *snapshot, word light,
                               air_method method)
{
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        if (snapshot->lights.entries[i].name != NULL &&
            word_is(light, snapshot->lights.entries[i].name)) {
            assign(table, i, method);
            return AIR_OK;
        }
    }
    return air_fail(table->context, AIR_ERROR_ARGUMENT, "method: there is no light named \"%.*s\"",
                    light.length, light.text);
}

static air_status parse(air_owner_table *table, const air_snapshot *snapshot, const char *methods)
{
    const char *rest = methods;
    while (true) {
        const size_t length = strcspn(rest, ",");
        const char *equals = memchr(rest, '=', length);
        word light = {rest, equals != NULL ? (int)(equals - rest) : 0};
        const char *begin = equals != NULL ? equals + 1 : rest;
        word method_word = {begin, (int)(rest + length - begin)};
        air_method method;
        air_status status = parse_method(table, method_word, &method);
        if (status == AIR_OK && equals != NULL) {
            status = assign_named(table, snapshot, light, method);
        } else if (status == AIR_OK) {
            for (size_t i = 0; i < table->light_count; i++) {
                assign(table, i, method);
            }
        }
        if (status != AIR_OK || rest[length] == '\0') {
            return status;
        }
        rest += length + 1;
    }
}

air_status air_owner_table_create(air_context *context, const air_snapshot *snapshot,
                                  const char *methods, air_owner_table **out_table)
{
    *out_table = NULL;
    if (methods == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "method: expected a text, not NULL");
    }
    air_owner_table *table = air_allocate(context, 1, sizeof *table);
    if (table == NULL) {
        return air_fail_memory(context, "owner table");
    }
    table->context = context;
    table->light_count = snapshot->lights.owner_count;
    table->medium_count = snapshot->media.count;
    table->methods = air_allocate(context, air_owner_table_size(table), 1);
    air_status status = table->methods == NULL ? air_fail_memory(context, "owner table")
                                               : parse(table, snapshot, methods);
    if (status != AIR_OK) {
        air_owner_table_destroy(table);
        return status;
    }
    *out_table = table;
    return AIR_OK;
}

void air_owner_table_destroy(air_owner_table *table)
{
    if (table != NULL) {
        air_free(table->context, table->methods);
        air_free(table->context, table);
    }
}

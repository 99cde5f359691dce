#include "render/owner.h"

#include <string.h>

#include "render/with_collimated.h"
#include "scene/snapshot.h"

const char *air_term_name(air_term term)
{
    static const char *const names[AIR_TERM_COUNT] = {"S0", "S+",       "M1",
                                                      "M2", "emission", "background"};
    return (unsigned)term < AIR_TERM_COUNT ? names[term] : "unknown";
}

const char *air_method_name(air_method method)
{
    static const char *const names[AIR_METHOD_COUNT] = {"path", "collimated"};
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

bool air_owner_table_uses(const air_owner_table *table, size_t light, air_method method)
{
    const size_t row = (table->medium_count + 1) * AIR_TERM_COUNT;
    return memchr(table->methods + light * row, (int)method, row) != NULL;
}

const char *air_owner_table_mode(const air_owner_table *table, size_t light)
{
    return light < table->light_count && air_owner_table_uses(table, light, AIR_METHOD_COLLIMATED)
               ? air_collimated_mode_name((air_collimated_mode)table->modes[light])
               : "";
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

/* What a word asks for. */
typedef struct method_choice {
    air_method method;
    air_collimated_mode mode;
    bool automatic; /* where it applies, and not a word where it does not */
} method_choice;

static air_status parse_method(const air_owner_table *table, word w, method_choice *out)
{
    static const char collimated[] = "collimated";
    const int length = (int)sizeof collimated - 1;
    const bool named = w.length >= length && strncmp(w.text, collimated, (size_t)length) == 0 &&
                       (w.length == length || w.text[length] == ':');
    *out = (method_choice){AIR_METHOD_PATH, AIR_COLLIMATED_EXACT, false};
    if (word_is(w, "path")) {
        return AIR_OK;
    }
    if (word_is(w, "auto") || named) {
        out->method = AIR_METHOD_COLLIMATED;
        out->automatic = !named;
    }
    if (word_is(w, "auto") || (named && w.length == length) ||
        (named && air_collimated_mode_parse(w.text + length + 1, (size_t)(w.length - length - 1),
                                            &out->mode))) {
        return AIR_OK;
    }
    char modes[AIR_COLLIMATED_MODE_LIST];
    air_collimated_mode_list(modes);
    return air_fail(table->context, AIR_ERROR_ARGUMENT,
                    "method \"%.*s\" is not known: expected auto, path or collimated[:MODE] with "
                    "MODE one of %s",
                    w.length, w.text, modes);
}

/* ---- who gets what ---- */

static void assign(air_owner_table *table, size_t light, method_choice choice)
{
    const size_t media = table->medium_count;
    uint8_t *rows = table->methods + light * (media + 1) * AIR_TERM_COUNT;
    memset(rows, AIR_METHOD_PATH, (media + 1) * AIR_TERM_COUNT);
    table->modes[light] = (uint8_t)choice.mode;
    /* Also where a term does not occur (S0 in a medium): path then sees that nothing is left. */
    for (size_t m = 0; choice.method == AIR_METHOD_COLLIMATED && m <= media; m++) {
        rows[m * AIR_TERM_COUNT + AIR_TERM_S0] = AIR_METHOD_COLLIMATED;
        rows[m * AIR_TERM_COUNT + AIR_TERM_M1] = AIR_METHOD_COLLIMATED;
    }
}

/* Lights that a method was asked for and does not apply to; told of in one warning. */
typedef struct refusals {
    size_t count;
    const char *first_light; /* its name */
    char first_reason[AIR_COLLIMATED_REASON];
} refusals;

static void assign_or_refuse(air_owner_table *table, const air_snapshot *snapshot, size_t light,
                             method_choice choice, refusals *refused)
{
    char reason[AIR_COLLIMATED_REASON];
    if (choice.method == AIR_METHOD_COLLIMATED &&
        !air_collimated_applies(snapshot, light, reason)) {
        choice.method = AIR_METHOD_PATH;
        if (!choice.automatic && refused->count++ == 0) {
            refused->first_light = light < snapshot->lights.explicit_count
                                       ? snapshot->lights.entries[light].name
                                       : "emissive meshes";
            memcpy(refused->first_reason, reason, sizeof reason);
        }
    }
    assign(table, light, choice);
}

static void warn_of_refusals(const air_owner_table *table, const refusals *refused)
{
    if (refused->count == 1) {
        air_warn(table->context, "method collimated leaves light \"%s\" to path: %s",
                 refused->first_light, refused->first_reason);
    } else if (refused->count > 1) {
        air_warn(table->context,
                 "method collimated leaves %zu lights to path, the first of them \"%s\": %s",
                 refused->count, refused->first_light, refused->first_reason);
    }
}

static air_status assign_named(air_owner_table *table, const air_snapshot *snapshot, word light,
                               method_choice choice, refusals *refused)
{
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        if (snapshot->lights.entries[i].name != NULL &&
            word_is(light, snapshot->lights.entries[i].name)) {
            assign_or_refuse(table, snapshot, i, choice, refused);
            return AIR_OK;
        }
    }
    return air_fail(table->context, AIR_ERROR_ARGUMENT, "method: there is no light named \"%.*s\"",
                    light.length, light.text);
}

static air_status parse(air_owner_table *table, const air_snapshot *snapshot, const char *methods)
{
    const char *rest = methods;
    refusals refused = {0};
    for (size_t i = 0; i < table->light_count; i++) { /* what is not named is automatic */
        const method_choice automatic = {AIR_METHOD_COLLIMATED, AIR_COLLIMATED_EXACT, true};
        assign_or_refuse(table, snapshot, i, automatic, &refused);
    }
    while (true) {
        const size_t length = strcspn(rest, ",");
        const char *equals = memchr(rest, '=', length);
        word light = {rest, equals != NULL ? (int)(equals - rest) : 0};
        const char *begin = equals != NULL ? equals + 1 : rest;
        word method_word = {begin, (int)(rest + length - begin)};
        method_choice choice;
        air_status status = parse_method(table, method_word, &choice);
        if (status == AIR_OK && equals != NULL) {
            status = assign_named(table, snapshot, light, choice, &refused);
        }
        for (size_t i = 0; status == AIR_OK && equals == NULL && i < table->light_count; i++) {
            assign_or_refuse(table, snapshot, i, choice, &refused);
        }
        if (status == AIR_OK && rest[length] == '\0') {
            warn_of_refusals(table, &refused);
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
    table->modes = air_allocate(context, table->light_count, 1);
    air_status status = table->methods == NULL || table->modes == NULL
                            ? air_fail_memory(context, "owner table")
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
        air_free(table->context, table->modes);
        air_free(table->context, table->methods);
        air_free(table->context, table);
    }
}

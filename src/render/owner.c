#include "render/owner.h"

#include <stdio.h>
#include <string.h>

#include "render/method.h"
#include "scene/snapshot.h"

const char *air_term_name(air_term term)
{
    static const char *const names[AIR_TERM_COUNT] = {"S0", "S+",       "M1",
                                                      "M2", "emission", "background"};
    return (unsigned)term < AIR_TERM_COUNT ? names[term] : "unknown";
}

/* By air_method; path, which does everything else, has no kind. */
static const air_method_kind *const kinds[AIR_METHOD_COUNT] = {
    NULL, &air_collimated_method, &air_area_method, &air_ordinates_method};

const char *air_method_name(air_method method)
{
    if ((unsigned)method >= AIR_METHOD_COUNT) {
        return "unknown";
    }
    return kinds[method] != NULL ? kinds[method]->name : "path";
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
    for (int m = 0; m < AIR_METHOD_COUNT && light < table->light_count; m++) {
        if (kinds[m] != NULL && air_owner_table_uses(table, light, (air_method)m)) {
            return kinds[m]->modes[table->modes[light]];
        }
    }
    return "";
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
    uint8_t mode;   /* of the method's; the first is its default */
    bool automatic; /* where it applies, and not a word where it does not */
} method_choice;

/* "auto": collimated is the one that is true and free of noise. */
static const method_choice automatic = {AIR_METHOD_COLLIMATED, 0, true};
/* "interactive": ordinates is free of noise, whatever the light and the media. */
static const method_choice interactive = {AIR_METHOD_ORDINATES, 0, true};

enum { EXPECTED = 512 };

/* "path, collimated[:exact|rm|...], ..." */
static void list_methods(char out[EXPECTED])
{
    size_t used = (size_t)snprintf(out, EXPECTED, "auto, interactive, path");
    for (int m = 0; m < AIR_METHOD_COUNT; m++) {
        for (size_t i = 0; kinds[m] != NULL && i < kinds[m]->mode_count && used < EXPECTED; i++) {
            const bool last = i + 1 == kinds[m]->mode_count;
            used += (size_t)snprintf(out + used, EXPECTED - used, "%s%s%s%s%s", i == 0 ? ", " : "|",
                                     i == 0 ? kinds[m]->name : "", i == 0 ? "[:" : "",
                                     kinds[m]->modes[i], last ? "]" : "");
        }
    }
}

/* Is the word the kind's name, with or without one of its modes? */
static bool parse_kind(const air_method_kind *kind, word w, uint8_t *out_mode)
{
    const int length = (int)strlen(kind->name);
    *out_mode = 0;
    if (w.length < length || strncmp(w.text, kind->name, (size_t)length) != 0) {
        return false;
    }
    if (w.length == length) {
        return true;
    }
    const word mode = {w.text + length + 1, w.length - length - 1};
    for (size_t i = 0; w.text[length] == ':' && i < kind->mode_count; i++) {
        if (word_is(mode, kind->modes[i])) {
            *out_mode = (uint8_t)i;
            return true;
        }
    }
    return false;
}

static air_status parse_method(const air_owner_table *table, word w, method_choice *out)
{
    *out = (method_choice){AIR_METHOD_PATH, 0, false};
    if (word_is(w, "path")) {
        return AIR_OK;
    }
    if (word_is(w, "auto") || word_is(w, "interactive")) {
        *out = word_is(w, "auto") ? automatic : interactive;
        return AIR_OK;
    }
    for (int m = 0; m < AIR_METHOD_COUNT; m++) {
        if (kinds[m] != NULL && parse_kind(kinds[m], w, &out->mode)) {
            out->method = (air_method)m;
            return AIR_OK;
        }
    }
    char expected[EXPECTED];
    list_methods(expected);
    return air_fail(table->context, AIR_ERROR_ARGUMENT,
                    "method \"%.*s\" is not known: expected one of %s", w.length, w.text, expected);
}

/* ---- who gets what ---- */

static void assign(air_owner_table *table, size_t light, method_choice choice)
{
    const size_t media = table->medium_count;
    uint8_t *rows = table->methods + light * (media + 1) * AIR_TERM_COUNT;
    memset(rows, AIR_METHOD_PATH, (media + 1) * AIR_TERM_COUNT);
    table->modes[light] = choice.mode;
    const uint32_t terms = kinds[choice.method] != NULL ? kinds[choice.method]->terms : 0;
    /* Also where a term does not occur (S0 in a medium): path then sees that nothing is left. */
    for (size_t i = 0; i < (media + 1) * AIR_TERM_COUNT; i++) {
        if ((terms >> i % AIR_TERM_COUNT & 1u) != 0) {
            rows[i] = (uint8_t)choice.method;
        }
    }
}

/* Lights that a method was asked for and does not apply to; told of in one warning. */
typedef struct refusals {
    size_t count;
    air_method first_method;
    const char *first_light; /* its name */
    char first_reason[AIR_METHOD_REASON];
} refusals;

/* Is most scattered light scattered once? Of media with bounds; then what single scattering shows,
 * the edges of beams, is worth more than the rest. */
static bool media_are_thin(const air_snapshot *snapshot)
{
    float events = 0.0f; /* at most, along the longest sides of the bounds */
    for (size_t i = 0; i < snapshot->media.count; i++) {
        const air_medium *const medium = &snapshot->media.media[i];
        float longest = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            longest = float_max(longest, medium->bounds_max[axis] - medium->bounds_min[axis]);
        }
        events += vec3_is_zero(medium->sigma_s) ? 0.0f : longest * vec3_max(medium->sigma_s);
    }
    return events <= 1.0f;
}

/* What "interactive" means for a light: cells blur beams, so that collimated keeps its suns where
 * light is scattered once if at all. */
static method_choice interactive_choice(const air_snapshot *snapshot, size_t light)
{
    char reason[AIR_METHOD_REASON];
    const bool grid = air_ordinates_method.applies(snapshot, light, reason);
    const bool beam = air_collimated_method.applies(snapshot, light, reason);
    return grid && !(beam && media_are_thin(snapshot)) ? interactive : automatic;
}

static void assign_or_refuse(air_owner_table *table, const air_snapshot *snapshot, size_t light,
                             method_choice choice, refusals *refused)
{
    char reason[AIR_METHOD_REASON];
    if (choice.automatic && choice.method == AIR_METHOD_ORDINATES) {
        choice = interactive_choice(snapshot, light);
    }
    const air_method_kind *kind = kinds[choice.method];
    if (kind != NULL && !kind->applies(snapshot, light, reason)) {
        if (!choice.automatic && refused->count++ == 0) {
            refused->first_method = choice.method;
            refused->first_light = light < snapshot->lights.explicit_count
                                       ? snapshot->lights.entries[light].name
                                       : "emissive meshes";
            memcpy(refused->first_reason, reason, sizeof reason);
        }
        choice.method = AIR_METHOD_PATH;
    }
    assign(table, light, choice);
}

static void warn_of_refusals(const air_owner_table *table, const refusals *refused)
{
    if (refused->count == 1) {
        air_warn(table->context, "method %s leaves light \"%s\" to path: %s",
                 air_method_name(refused->first_method), refused->first_light,
                 refused->first_reason);
    } else if (refused->count > 1) {
        air_warn(table->context,
                 "method %s leaves %zu lights to path, the first of them \"%s\": %s",
                 air_method_name(refused->first_method), refused->count, refused->first_light,
                 refused->first_reason);
    }
}

/* To all lights of the name: files may hold several. */
static air_status assign_named(air_owner_table *table, const air_snapshot *snapshot, word light,
                               method_choice choice, refusals *refused)
{
    bool found = false;
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        if (snapshot->lights.entries[i].name != NULL &&
            word_is(light, snapshot->lights.entries[i].name)) {
            assign_or_refuse(table, snapshot, i, choice, refused);
            found = true;
        }
    }
    return found ? AIR_OK
                 : air_fail(table->context, AIR_ERROR_ARGUMENT,
                            "method: there is no light named \"%.*s\"", light.length, light.text);
}

static air_status parse(air_owner_table *table, const air_snapshot *snapshot, const char *methods)
{
    const char *rest = methods;
    refusals refused = {0};
    for (size_t i = 0; i < table->light_count; i++) { /* what is not named is automatic */
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

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/import/json_place.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/number.h"

/* ---- messages ---- */

air_status air_mitsuba_fail(const air_mitsuba *mitsuba, const air_xml *at, air_status status,
                            const char *sentence, ...)
{
    va_list arguments;
    va_start(arguments, sentence);
    const air_status said = air_xml_vfail(&mitsuba->document, at, status, sentence, arguments);
    va_end(arguments);
    return said;
}

air_status air_mitsuba_warn(const air_mitsuba *mitsuba, const air_xml *at, const char *sentence,
                            ...)
{
    char place[1024], text[1024];
    va_list arguments;
    va_start(arguments, sentence);
    vsnprintf(text, sizeof text, sentence, arguments);
    va_end(arguments);
    air_xml_describe(at, place, sizeof place);
    return air_import_warn(mitsuba->import, "%s: %s", place, text);
}

air_status air_mitsuba_replace(const air_mitsuba *mitsuba, const air_xml *at, const char *what,
                               const char *instead)
{
    if (mitsuba->import->params->lenient)
        return air_mitsuba_warn(mitsuba, at, "%s: %s", what, instead);
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED, "%s (--lenient: %s)", what,
                            instead);
}

air_status air_mitsuba_unknown_type(const air_mitsuba *mitsuba, const air_xml *at,
                                    const char *const *types, size_t count, const char *instead)
{
    char what[256];
    const char *type = air_mitsuba_type(at), *nearest = air_nearest_name(type, types, count);
    if (type[0] == '\0')
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the attribute type");
    if (nearest != NULL && strcmp(nearest, type) != 0)
        snprintf(what, sizeof what, "the %.40s \"%.60s\" is not supported, did you mean \"%s\"?",
                 at->tag, type, nearest);
    else
        snprintf(what, sizeof what, "the %.40s \"%.60s\" is not supported", at->tag, type);
    return air_mitsuba_replace(mitsuba, at, what, instead);
}

/* ---- finding ---- */

const char *air_mitsuba_type(const air_xml *at)
{
    const char *type = air_xml_attribute_of(at, "type");
    return type != NULL ? type : "";
}

bool air_mitsuba_is(const air_xml *at, const char *type)
{
    return strcmp(air_mitsuba_type(at), type) == 0;
}

static bool is_named(const air_xml *at, const char *name)
{
    const char *own = air_xml_attribute_of(at, "name");
    return own != NULL && strcmp(own, name) == 0;
}

air_xml *air_mitsuba_parameter(const air_xml *at, const char *name)
{
    air_xml *found = NULL;
    for (air_xml *i = at->child; i != NULL; i = i->next) {
        if (is_named(i, name)) {
            i->used = true;
            found = i; /* the last one has the last word */
        }
    }
    return found;
}

bool air_mitsuba_has(const air_xml *at, const char *name)
{
    for (const air_xml *i = at->child; i != NULL; i = i->next)
        if (is_named(i, name))
            return true;
    return false;
}

void air_mitsuba_ignore(const air_xml *at, const char *const *names, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        (void)air_mitsuba_parameter(at, names[i]);
}

air_status air_mitsuba_next(const air_mitsuba *mitsuba, air_xml **from, const char *tag,
                            air_xml **out_child, air_xml **out_target)
{
    *out_child = *out_target = NULL;
    for (air_xml *i = *from; i != NULL; i = i->next) {
        air_xml *target = NULL;
        if (strcmp(i->tag, tag) != 0 && strcmp(i->tag, "ref") != 0)
            continue;
        const air_status status = air_mitsuba_resolve(mitsuba, i, &target);
        if (status != AIR_OK)
            return status;
        if (strcmp(target->tag, tag) != 0)
            continue;
        i->used = target->used = true;
        *out_child = i;
        *out_target = target;
        *from = i->next;
        return AIR_OK;
    }
    *from = NULL;
    return AIR_OK;
}

air_status air_mitsuba_child(const air_mitsuba *mitsuba, const air_xml *at, const char *tag,
                             const char *name, air_xml **out_target)
{
    air_xml *from = at->child, *child = NULL, *target = NULL;
    air_status status = AIR_OK;
    *out_target = NULL;
    do {
        status = air_mitsuba_next(mitsuba, &from, tag, &child, &target);
        if (status == AIR_OK && target != NULL && (name == NULL || is_named(child, name))) {
            *out_target = target;
            return AIR_OK;
        }
    } while (status == AIR_OK && from != NULL);
    return status;
}

/* ---- numbers ---- */

static const char *const separators = " ,\t\r\n";

/* Of a text that is no number, or one too many. */
static air_status refuse_number(const air_mitsuba *mitsuba, const air_xml *at,
                                const char *attribute, size_t most, const char *text, size_t length,
                                bool more)
{
    char expected[64] = "one finite number";
    if (most > 1)
        snprintf(expected, sizeof expected, "at most %zu finite numbers", most);
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected %s as %s, found \"%.*s\"%s",
                            expected, attribute, (int)(length < 60 ? length : 60), text,
                            more ? " as one more" : "");
}

air_status air_mitsuba_numbers(const air_mitsuba *mitsuba, const air_xml *at, const char *attribute,
                               size_t most, double *out, size_t *out_count)
{
    const char *text = air_xml_attribute_of(at, attribute);
    size_t count = 0;
    if (text == NULL)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the attribute %s",
                                attribute);
    for (text += strspn(text, separators); *text != '\0'; text += strspn(text, separators)) {
        const size_t length = strcspn(text, separators);
        if (count == most || !air_number_parse(text, length, &out[count]) ||
            fabs(out[count]) > 3e38)
            return refuse_number(mitsuba, at, attribute, most, text, length, count == most);
        ++count;
        text += length;
    }
    if (count == 0)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected a number as %s",
                                attribute);
    *out_count = count;
    return AIR_OK;
}

static air_status check_tag(const air_mitsuba *mitsuba, const air_xml *at, const char *tag,
                            const char *other)
{
    if (strcmp(at->tag, tag) == 0 || (other != NULL && strcmp(at->tag, other) == 0))
        return AIR_OK;
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected <%s>%s%s%s", tag,
                            other != NULL ? " or <" : "", other != NULL ? other : "",
                            other != NULL ? ">" : "");
}

static air_status read_number(const air_mitsuba *mitsuba, const air_xml *at, double *value)
{
    size_t count = 0;
    return air_mitsuba_numbers(mitsuba, at, "value", 1, value, &count);
}

air_status air_mitsuba_plain(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                             const air_xml **out)
{
    air_xml *found = air_mitsuba_parameter(at, name), *target = found;
    air_status status = AIR_OK;
    *out = NULL;
    if (found != NULL && strcmp(found->tag, "ref") == 0)
        status = air_mitsuba_resolve(mitsuba, found, &target);
    if (status != AIR_OK || found == NULL)
        return status;
    if (strcmp(target->tag, "texture") != 0) {
        *out = found;
        return AIR_OK;
    }
    target->used = true;
    return air_mitsuba_replace(mitsuba, found, "a texture is not supported here",
                               "the parameter's default is taken");
}

air_status air_mitsuba_float(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                             float *value)
{
    const air_xml *found = NULL;
    double number = 0.0;
    air_status status = air_mitsuba_plain(mitsuba, at, name, &found);
    if (found == NULL)
        return status;
    status = check_tag(mitsuba, found, "float", "integer");
    if (status == AIR_OK)
        status = read_number(mitsuba, found, &number);
    if (status == AIR_OK)
        *value = (float)number;
    return status;
}

air_status air_mitsuba_integer(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                               long *value)
{
    const air_xml *found = air_mitsuba_parameter(at, name);
    double number = 0.0;
    if (found == NULL)
        return AIR_OK;
    air_status status = check_tag(mitsuba, found, "integer", NULL);
    if (status == AIR_OK)
        status = read_number(mitsuba, found, &number);
    if (status == AIR_OK && (number != floor(number) || fabs(number) > 1e9))
        status = air_mitsuba_fail(mitsuba, found, AIR_ERROR_FORMAT,
                                  "expected a whole number, found \"%.40s\"",
                                  air_xml_attribute_of(found, "value"));
    if (status == AIR_OK)
        *value = (long)number;
    return status;
}

air_status air_mitsuba_integer_within(const air_mitsuba *mitsuba, const air_xml *at,
                                      const char *name, long least, long most, long *value)
{
    const air_status status = air_mitsuba_integer(mitsuba, at, name, value);
    if (status == AIR_OK && (*value < least || *value > most))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected %s to be %ld to %ld, found %ld", name, least, most,
                                *value);
    return status;
}

air_status air_mitsuba_string(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              const char **value)
{
    const air_xml *found = air_mitsuba_parameter(at, name);
    if (found == NULL)
        return AIR_OK;
    const char *text = air_xml_attribute_of(found, "value");
    const air_status status = check_tag(mitsuba, found, "string", NULL);
    if (status == AIR_OK && text == NULL)
        return air_mitsuba_fail(mitsuba, found, AIR_ERROR_FORMAT, "expected the attribute value");
    if (status == AIR_OK)
        *value = text;
    return status;
}

/* Words of ASCII letters. */
static bool same_word(const char *a, const char *b)
{
    while (*a != '\0' && tolower((unsigned char)*a) == tolower((unsigned char)*b)) {
        ++a;
        ++b;
    }
    return *a == '\0' && *b == '\0';
}

static air_status choose(const air_mitsuba *mitsuba, const air_xml *at, const char *const *words,
                         size_t count, size_t *value)
{
    char list[256] = "";
    const char *text = air_xml_attribute_of(at, "value");
    for (size_t i = 0; i < count; ++i) {
        const size_t used = strlen(list);
        if (text != NULL && same_word(text, words[i])) {
            *value = i;
            return AIR_OK;
        }
        snprintf(list + used, sizeof list - used, "%s%s", i == 0 ? "" : ", ", words[i]);
    }
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected one of %s, found \"%.60s\"",
                            list, text != NULL ? text : "");
}

air_status air_mitsuba_boolean(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                               bool *value)
{
    static const char *const words[] = {"false", "true"};
    const air_xml *found = air_mitsuba_parameter(at, name);
    size_t chosen = *value;
    if (found == NULL)
        return AIR_OK;
    air_status status = check_tag(mitsuba, found, "boolean", NULL);
    if (status == AIR_OK)
        status = choose(mitsuba, found, words, 2, &chosen);
    *value = chosen == 1;
    return status;
}

air_status air_mitsuba_choice(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              const char *const *words, size_t count, size_t *value)
{
    const air_xml *found = air_mitsuba_parameter(at, name);
    if (found == NULL)
        return AIR_OK;
    const air_status status = check_tag(mitsuba, found, "string", NULL);
    return status == AIR_OK ? choose(mitsuba, found, words, count, value) : status;
}

/* x, y and z apart, or value with one or three numbers. */
air_status air_mitsuba_read_vector(const air_mitsuba *mitsuba, const air_xml *at, double value[3])
{
    static const char *const axes[] = {"x", "y", "z"};
    air_status status = AIR_OK;
    size_t count = 0;
    if (air_xml_attribute_of(at, "value") != NULL) {
        status = air_mitsuba_numbers(mitsuba, at, "value", 3, value, &count);
        if (status == AIR_OK && count == 2)
            status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                      "expected one number or three, found two");
        if (status == AIR_OK && count == 1)
            value[1] = value[2] = value[0];
        return status;
    }
    for (size_t i = 0; i < 3 && status == AIR_OK; ++i)
        if (air_xml_attribute_of(at, axes[i]) != NULL)
            status = air_mitsuba_numbers(mitsuba, at, axes[i], 1, &value[i], &count);
    return status;
}

air_status air_mitsuba_vector(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              float value[3])
{
    const air_xml *found = air_mitsuba_parameter(at, name);
    double numbers[3] = {0.0, 0.0, 0.0};
    if (found == NULL)
        return AIR_OK;
    air_status status = check_tag(mitsuba, found, "point", "vector");
    if (status == AIR_OK)
        status = air_mitsuba_read_vector(mitsuba, found, numbers);
    for (size_t i = 0; i < 3 && status == AIR_OK; ++i)
        value[i] = (float)numbers[i];
    return status;
}

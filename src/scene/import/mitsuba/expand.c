#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "scene/import/json_place.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/number.h"
#include "scene/import/resource.h"

/* Files that include files that include files. */
enum { INCLUDE_DEPTH = 16, INCLUDES = 1000 };

/* A file that is being read, within those that include it. */
typedef struct air_mitsuba_source {
    const char *path;
    size_t depth;
    const struct air_mitsuba_source *outer;
} air_mitsuba_source;

/* ---- $parameters ---- */

/* Texts that are no UTF-8 are refused like those for which there is no memory. */
static air_status set_parameter(air_mitsuba *mitsuba, const char *name, const char *value)
{
    if (json_object_set_new(mitsuba->parameters, name, json_string(value)) != 0)
        return air_fail(mitsuba->context, AIR_ERROR_ARGUMENT,
                        "%s: parameter \"%.60s\": expected a name and a value in UTF-8",
                        mitsuba->path, name);
    return AIR_OK;
}

/* --define name=value */
static air_status add_defines(air_mitsuba *mitsuba)
{
    const air_load_params *params = mitsuba->import->params;
    air_status status = AIR_OK;
    for (size_t i = 0; i < params->define_count && status == AIR_OK; ++i) {
        const char *text = params->defines[i];
        const char *equals = strchr(text, '=');
        if (equals == NULL || equals == text)
            return air_fail(mitsuba->context, AIR_ERROR_ARGUMENT,
                            "--define \"%.80s\": expected NAME=VALUE", text);
        char *key = air_xml_copy(&mitsuba->document, text, (size_t)(equals - text));
        if (key == NULL)
            return AIR_ERROR_MEMORY;
        status = set_parameter(mitsuba, key, equals + 1);
    }
    return status;
}

/* Misspelt ones, as likely as not. */
static air_status warn_of_unwanted(const air_mitsuba *mitsuba)
{
    const air_load_params *params = mitsuba->import->params;
    air_status status = AIR_OK;
    for (size_t i = 0; i < params->define_count && status == AIR_OK; ++i) {
        const char *text = params->defines[i];
        const size_t length = strcspn(text, "=");
        if (json_object_getn(mitsuba->wanted, text, length) == NULL)
            status = air_import_warn(mitsuba->import, "--define \"%.80s\": the scene has no $%.*s",
                                     text, (int)(length < 60 ? length : 60), text);
    }
    return status;
}

static bool is_name(char c) { return isalnum((unsigned char)c) || c == '_'; }

static air_status unknown_parameter(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                    size_t length)
{
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                            "the parameter $%.*s has no value: expected a <default> before it, or "
                            "--define %.*s=VALUE",
                            (int)(length < 60 ? length : 60), name,
                            (int)(length < 60 ? length : 60), name);
}

enum { NAME_LENGTH = 255 };

/* The parameter whose name these are, or with `begin` the longest that they begin with, as Mitsuba
 * takes it: $res in "$resolution" only where there is no $resolution. NULL: there is none. */
static const char *parameter_value(const air_mitsuba *mitsuba, const char *text, size_t length,
                                   bool begin, size_t *out_length)
{
    char name[NAME_LENGTH + 1];
    if (length > NAME_LENGTH)
        return NULL;
    memcpy(name, text, length);
    for (const size_t least = begin ? 1 : length; length >= least && length > 0; --length) {
        name[length] = '\0';
        const json_t *value = json_object_get(mitsuba->parameters, name);
        if (value != NULL) {
            *out_length = length;
            json_object_set_new(mitsuba->wanted, name, json_true());
            return json_string_value(value);
        }
    }
    return NULL;
}

/* Appends to a text of at most `size` bytes; false where there is no room. */
static bool append(char *out, size_t size, size_t *used, const char *text, size_t length)
{
    if (*used + length >= size)
        return false;
    memcpy(out + *used, text, length);
    *used += length;
    out[*used] = '\0';
    return true;
}

/* Replaces $name, ${name}, and \$ by a dollar. Values are not looked at again. */
static air_status substitute(air_mitsuba *mitsuba, const air_xml *at, air_xml_attribute *attribute)
{
    char out[4096] = "";
    size_t used = 0;
    bool room = true;
    if (strchr(attribute->value, '$') == NULL)
        return AIR_OK;
    for (const char *text = attribute->value; *text != '\0' && room;) {
        if (text[0] == '\\' && text[1] == '$') {
            room = append(out, sizeof out, &used, "$", 1);
            text += 2;
            continue;
        }
        if (text[0] != '$') {
            room = append(out, sizeof out, &used, text++, 1);
            continue;
        }
        const bool braces = text[1] == '{';
        const char *name = text + 1 + braces;
        size_t length = 0;
        while (braces ? name[length] != '}' && name[length] != '\0' : is_name(name[length]))
            ++length;
        const char *value = parameter_value(mitsuba, name, length, !braces, &length);
        if (value == NULL)
            return unknown_parameter(mitsuba, at, name, length);
        room = append(out, sizeof out, &used, value, strlen(value));
        text = name + length + (braces && name[length] == '}');
    }
    if (!room)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "%.40s with its parameters has more than %zu characters",
                                attribute->name, sizeof out - 1);
    attribute->value = air_xml_copy(&mitsuba->document, out, used);
    return attribute->value != NULL ? AIR_OK : AIR_ERROR_MEMORY;
}

/* ---- names ---- */

/* camelCase of older versions into snake_case: "toWorld" is "to_world", "intIOR" "int_ior". */
static air_status snake_case(air_mitsuba *mitsuba, const char **name)
{
    const size_t length = strlen(*name);
    char *out = air_xml_allocate(&mitsuba->document, 2 * length + 1);
    size_t used = 0;
    if (out == NULL)
        return AIR_ERROR_MEMORY;
    for (size_t i = 0; i < length; ++i) {
        const char c = (*name)[i];
        const bool upper = isupper((unsigned char)c);
        const bool inside = i > 0 && upper && isupper((unsigned char)(*name)[i - 1]) && used > 0 &&
                            islower((unsigned char)out[used - 1]);
        if (upper && i > 0 && islower((unsigned char)(*name)[i - 1]))
            out[used++] = '_';
        out[used] = c;
        if (inside || (used > 0 && out[used - 1] == '_' && upper))
            out[used] = (char)tolower((unsigned char)c);
        ++used;
    }
    *name = out;
    return AIR_OK;
}

static air_status note_name(air_mitsuba *mitsuba, air_xml *at, const char *id)
{
    const json_t *known = json_object_get(mitsuba->names, id);
    if (json_is_integer(known)) {
        const air_xml *other = mitsuba->named[json_integer_value(known)];
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "the id \"%.60s\" is taken by the <%.40s> of line %zu", id,
                                other->tag, other->line);
    }
    if (mitsuba->named_count == mitsuba->named_capacity) {
        const size_t capacity = 2 * mitsuba->named_capacity + 64;
        air_xml **named =
            air_reallocate(mitsuba->context, mitsuba->named, capacity, sizeof *mitsuba->named);
        if (named == NULL)
            return air_fail_memory(mitsuba->context, mitsuba->path);
        mitsuba->named = named;
        mitsuba->named_capacity = capacity;
    }
    mitsuba->named[mitsuba->named_count] = at;
    if (json_object_set_new(mitsuba->names, id, json_integer((json_int_t)mitsuba->named_count)) !=
        0)
        return air_fail_memory(mitsuba->context, mitsuba->path);
    ++mitsuba->named_count;
    return AIR_OK;
}

static air_status note_alias(air_mitsuba *mitsuba, air_xml *at)
{
    const char *id = air_xml_attribute_of(at, "id"), *as = air_xml_attribute_of(at, "as");
    at->used = true;
    if (id == NULL || as == NULL)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the attributes id and as");
    return json_object_set_new(mitsuba->names, as, json_string(id)) == 0
               ? AIR_OK
               : air_fail_memory(mitsuba->context, mitsuba->path);
}

static air_status unknown_name(const air_mitsuba *mitsuba, const air_xml *at, const char *id)
{
    const size_t count = json_object_size(mitsuba->names);
    const char **names = air_allocate(mitsuba->context, count, sizeof *names);
    size_t i = 0;
    const char *name, *nearest;
    json_t *value;
    if (names == NULL)
        return air_fail_memory(mitsuba->context, mitsuba->path);
    json_object_foreach(mitsuba->names, name, value) names[i++] = name;
    nearest = air_nearest_name(id, names, count);
    air_free(mitsuba->context, names);
    return nearest == NULL
               ? air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "nothing has the id \"%.60s\"", id)
               : air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "nothing has the id \"%.60s\"; did you mean \"%s\"?", id,
                                  nearest);
}

air_status air_mitsuba_resolve(const air_mitsuba *mitsuba, air_xml *at, air_xml **out)
{
    enum { ALIASES = 32 }; /* of aliases */
    if (strcmp(at->tag, "ref") != 0) {
        *out = at;
        return AIR_OK;
    }
    const char *id = air_xml_attribute_of(at, "id");
    if (id == NULL)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the attribute id");
    const json_t *found = json_object_get(mitsuba->names, id);
    for (int i = 0; json_is_string(found) && i < ALIASES; ++i)
        found = json_object_get(mitsuba->names, json_string_value(found));
    if (!json_is_integer(found))
        return unknown_name(mitsuba, at, id);
    *out = mitsuba->named[json_integer_value(found)];
    return AIR_OK;
}

/* ---- files ---- */

/* "0.5.0" or "3.1": major and minor. */
static air_status read_version(const air_mitsuba *mitsuba, air_xml *root)
{
    const char *text = air_xml_attribute_of(root, "version");
    if (text == NULL)
        return air_mitsuba_fail(mitsuba, root, AIR_ERROR_FORMAT,
                                "expected the attribute version, as in <scene version=\"3.0.0\">");
    size_t length = strcspn(text, ".");
    if (text[length] == '.')
        length += 1 + strcspn(text + length + 1, ".");
    if (!air_number_parse(text, length, &root->version) || root->version < 0.4 ||
        root->version >= 4.0)
        return air_mitsuba_fail(mitsuba, root, AIR_ERROR_UNSUPPORTED,
                                "version \"%.40s\" is not read, expected 0.4 to 3", text);
    return AIR_OK;
}

static air_status expand_children(air_mitsuba *mitsuba, air_xml *parent,
                                  const air_mitsuba_source *source);

static air_status read_source(air_mitsuba *mitsuba, const air_mitsuba_source *source,
                              air_xml **out_root)
{
    air_xml *root = NULL;
    air_status status = air_xml_read(&mitsuba->document, source->path, &root);
    if (status == AIR_OK)
        status = read_version(mitsuba, root);
    if (status == AIR_OK)
        status = expand_children(mitsuba, root, source);
    if (status == AIR_OK)
        *out_root = root;
    return status;
}

/* Puts the children of an included scene, or an included object itself, in the include's place. */
static void splice(air_xml *include, air_xml *root)
{
    air_xml *parent = include->parent, *first = root, *last = root;
    if (strcmp(root->tag, "scene") == 0) {
        first = root->child;
        last = root->last_child;
    }
    if (first == NULL)
        return;
    for (air_xml *i = first; i != NULL; i = i->next)
        i->parent = parent;
    last->next = include->next;
    include->next = first;
    if (parent->last_child == include)
        parent->last_child = last;
}

static air_status include(air_mitsuba *mitsuba, air_xml *at, const air_mitsuba_source *source)
{
    const char *name = air_xml_attribute_of(at, "filename");
    air_mitsuba_source inner = {.depth = source->depth + 1, .outer = source};
    air_xml *root = NULL;
    char *path = NULL;
    at->used = true;
    if (name == NULL)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the attribute filename");
    if (inner.depth > INCLUDE_DEPTH)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "files include each other more than %d deep", INCLUDE_DEPTH);
    if (++mitsuba->include_count > INCLUDES)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "more than %d files are included", INCLUDES);
    air_status status = air_mitsuba_file(mitsuba, at, name, &path);
    for (const air_mitsuba_source *i = source; i != NULL && status == AIR_OK; i = i->outer)
        if (strcmp(i->path, path) == 0)
            status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                      "\"%.200s\" includes itself, by way of this", name);
    inner.path = path;
    if (status == AIR_OK)
        status = read_source(mitsuba, &inner, &root);
    if (status == AIR_ERROR_IO)
        status = air_xml_place_error(&mitsuba->document, at, status);
    air_free(mitsuba->context, path);
    if (status == AIR_OK)
        splice(at, root);
    return status;
}

static air_status add_default(air_mitsuba *mitsuba, air_xml *at)
{
    const char *name = air_xml_attribute_of(at, "name");
    const char *value = air_xml_attribute_of(at, "value");
    at->used = true;
    if (name == NULL || value == NULL || name[0] == '\0')
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected the attributes name and value");
    return json_object_get(mitsuba->parameters, name) != NULL ? AIR_OK
                                                              : set_parameter(mitsuba, name, value);
}

static air_status add_folder(air_mitsuba *mitsuba, air_xml *at)
{
    const char *value = air_xml_attribute_of(at, "value");
    char *path = NULL;
    at->used = true;
    if (value == NULL)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected the attribute value");
    if (mitsuba->folder_count == AIR_MITSUBA_FOLDERS)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED, "there are more than %d paths",
                                AIR_MITSUBA_FOLDERS);
    const air_status status = air_mitsuba_file(mitsuba, at, value, &path);
    if (status != AIR_OK)
        return status;
    const char *slash = path[0] != '\0' && path[strlen(path) - 1] == '/' ? "" : "/";
    char *folder = air_string_format(mitsuba->context, "%s%s", path, slash);
    const char *kept =
        folder != NULL ? air_xml_copy(&mitsuba->document, folder, strlen(folder)) : NULL;
    air_free(mitsuba->context, folder);
    air_free(mitsuba->context, path);
    if (kept == NULL)
        return air_fail_memory(mitsuba->context, mitsuba->path);
    mitsuba->folders[mitsuba->folder_count++] = kept;
    return AIR_OK;
}

static air_status expand_attributes(air_mitsuba *mitsuba, air_xml *at)
{
    const bool plain = strcmp(at->tag, "default") == 0;
    air_status status = AIR_OK;
    for (air_xml_attribute *i = at->attributes; i != NULL && status == AIR_OK; i = i->next) {
        status = substitute(mitsuba, at, i);
        if (status == AIR_OK && strcmp(i->name, "name") == 0 && !plain)
            status = snake_case(mitsuba, &i->value);
    }
    if (strcmp(at->tag, "lookAt") == 0)
        at->tag = "lookat";
    return status;
}

/* In the order of the file: a <default> is known to what follows it. */
static air_status expand_children(air_mitsuba *mitsuba, air_xml *parent,
                                  const air_mitsuba_source *source)
{
    air_status status = expand_attributes(mitsuba, parent);
    const char *own_id = air_xml_attribute_of(parent, "id");
    if (status == AIR_OK && own_id != NULL)
        status = note_name(mitsuba, parent, own_id);
    for (air_xml *at = parent->child, *next = NULL; at != NULL && status == AIR_OK; at = next) {
        next = at->next; /* what an include brings is expanded already */
        at->version = parent->version;
        if (strcmp(at->tag, "ref") == 0) {
            status = expand_attributes(mitsuba, at);
            continue;
        }
        if (strcmp(at->tag, "alias") == 0) {
            status = expand_attributes(mitsuba, at);
            if (status == AIR_OK)
                status = note_alias(mitsuba, at);
            continue;
        }
        status = expand_children(mitsuba, at, source);
        if (status != AIR_OK)
            break;
        if (strcmp(at->tag, "default") == 0)
            status = add_default(mitsuba, at);
        else if (strcmp(at->tag, "path") == 0)
            status = add_folder(mitsuba, at);
        else if (strcmp(at->tag, "include") == 0)
            status = include(mitsuba, at, source);
    }
    return status;
}

air_status air_mitsuba_expand(air_mitsuba *mitsuba)
{
    const air_mitsuba_source source = {.path = mitsuba->path};
    mitsuba->parameters = json_object();
    mitsuba->wanted = json_object();
    mitsuba->names = json_object();
    if (mitsuba->parameters == NULL || mitsuba->wanted == NULL || mitsuba->names == NULL)
        return air_fail_memory(mitsuba->context, mitsuba->path);
    air_status status = add_defines(mitsuba);
    if (status == AIR_OK)
        status = read_source(mitsuba, &source, &mitsuba->scene);
    if (status == AIR_OK && strcmp(mitsuba->scene->tag, "scene") != 0)
        status = air_mitsuba_fail(mitsuba, mitsuba->scene, AIR_ERROR_FORMAT,
                                  "expected <scene> as the outermost element");
    return status == AIR_OK ? warn_of_unwanted(mitsuba) : status;
}

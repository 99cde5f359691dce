#include "scene/import/mitsuba/xml.h"

#include <expat.h>
#include <stdio.h>
#include <string.h>

/* ---- memory ---- */

enum { BLOCK_SIZE = 1 << 16, BLOCK_ALIGNMENT = 16 };

struct air_xml_block {
    air_xml_block *next;
    size_t used, size;
    _Alignas(BLOCK_ALIGNMENT) char bytes[];
};

void air_xml_finish(air_xml_document *document)
{
    while (document->blocks != NULL) {
        air_xml_block *next = document->blocks->next;
        air_free(document->context, document->blocks);
        document->blocks = next;
    }
}

void *air_xml_allocate(air_xml_document *document, size_t size)
{
    air_xml_block *block = document->blocks;
    const size_t rounded = (size + BLOCK_ALIGNMENT - 1) / BLOCK_ALIGNMENT * BLOCK_ALIGNMENT;
    if (block == NULL || block->size - block->used < rounded) {
        const size_t room = rounded > BLOCK_SIZE ? rounded : BLOCK_SIZE;
        block = air_allocate(document->context, sizeof *block + room, 1);
        if (block == NULL) {
            (void)air_fail_memory(document->context, "scene file");
            return NULL;
        }
        block->next = document->blocks;
        block->size = room;
        document->blocks = block;
    }
    void *out = block->bytes + block->used;
    block->used += rounded;
    return out;
}

char *air_xml_copy(air_xml_document *document, const char *text, size_t length)
{
    char *copy = air_xml_allocate(document, length + 1);
    if (copy != NULL)
        memcpy(copy, text, length);
    return copy;
}

/* ---- reading ---- */

typedef struct air_xml_reader {
    air_xml_document *document;
    XML_Parser parser;
    const char *file;
    air_xml *root, *open;
    size_t depth;
    air_status status; /* of the first failure of a handler */
} air_xml_reader;

static void stop(air_xml_reader *reader, air_status status)
{
    reader->status = status;
    (void)XML_StopParser(reader->parser, XML_FALSE);
}

static size_t line_of(const air_xml_reader *reader)
{
    return (size_t)XML_GetCurrentLineNumber(reader->parser);
}

/* A copy of the tag and attributes; NULL when memory is out. */
static air_xml *make_element(air_xml_reader *reader, const char *tag, const char **attributes)
{
    air_xml_document *document = reader->document;
    air_xml *element = air_xml_allocate(document, sizeof *element);
    if (element == NULL)
        return NULL;
    element->file = reader->file;
    element->line = line_of(reader);
    element->tag = air_xml_copy(document, tag, strlen(tag));
    bool ok = element->tag != NULL;
    air_xml_attribute **end = &element->attributes;
    for (size_t i = 0; ok && attributes[i] != NULL; i += 2) {
        air_xml_attribute *attribute = air_xml_allocate(document, sizeof *attribute);
        if (attribute == NULL)
            return NULL;
        attribute->name = air_xml_copy(document, attributes[i], strlen(attributes[i]));
        attribute->value = air_xml_copy(document, attributes[i + 1], strlen(attributes[i + 1]));
        ok = attribute->name != NULL && attribute->value != NULL;
        *end = attribute;
        end = &attribute->next;
    }
    return ok ? element : NULL;
}

static void append_child(air_xml *parent, air_xml *child)
{
    child->parent = parent;
    if (parent->last_child != NULL)
        parent->last_child->next = child;
    else
        parent->child = child;
    parent->last_child = child;
}

static void start_element(void *user, const char *tag, const char **attributes)
{
    air_xml_reader *reader = user;
    air_xml_document *document = reader->document;
    if (reader->status != AIR_OK)
        return;
    if (reader->depth >= AIR_XML_DEPTH) {
        stop(reader, air_fail(document->context, AIR_ERROR_UNSUPPORTED,
                              "%s: line %zu: <%.40s>: elements are nested more than %d deep",
                              reader->file, line_of(reader), tag, AIR_XML_DEPTH));
        return;
    }
    if (++document->element_count > AIR_XML_ELEMENTS) {
        stop(reader, air_fail(document->context, AIR_ERROR_UNSUPPORTED,
                              "%s: line %zu: <%.40s>: there are more than %d elements",
                              reader->file, line_of(reader), tag, AIR_XML_ELEMENTS));
        return;
    }
    air_xml *element = make_element(reader, tag, attributes);
    if (element == NULL) {
        stop(reader, AIR_ERROR_MEMORY);
        return;
    }
    if (reader->open == NULL)
        reader->root = element;
    else
        append_child(reader->open, element);
    reader->open = element;
    ++reader->depth;
}

static void end_element(void *user, const char *tag)
{
    air_xml_reader *reader = user;
    (void)tag;
    if (reader->status != AIR_OK)
        return;
    reader->open = reader->open->parent;
    --reader->depth;
}

static void refuse_doctype(void *user, const char *name, const char *system_id,
                           const char *public_id, int has_internal_subset)
{
    air_xml_reader *reader = user;
    (void)system_id;
    (void)public_id;
    (void)has_internal_subset;
    if (reader->status == AIR_OK)
        stop(reader, air_fail(reader->document->context, AIR_ERROR_UNSUPPORTED,
                              "%s: line %zu: <!DOCTYPE %.40s>: document types and entities are "
                              "not read, expected <scene>",
                              reader->file, line_of(reader), name));
}

/* Expat takes sizes as int. */
static air_status parse(air_xml_reader *reader, const char *text, size_t size)
{
    enum { PIECE = 1 << 24 };
    bool ok = true;
    do {
        const size_t piece = size < PIECE ? size : PIECE;
        size -= piece;
        ok = XML_Parse(reader->parser, text, (int)piece, size == 0) == XML_STATUS_OK;
        text += piece;
    } while (ok && size > 0);
    if (reader->status != AIR_OK || ok)
        return reader->status;
    const enum XML_Error error = XML_GetErrorCode(reader->parser);
    if (error == XML_ERROR_NO_MEMORY)
        return air_fail_memory(reader->document->context, reader->file);
    return air_fail(reader->document->context, AIR_ERROR_FORMAT,
                    "%s: line %zu: not well-formed XML: %s", reader->file, line_of(reader),
                    XML_ErrorString(error));
}

air_status air_xml_read(air_xml_document *document, const char *path, air_xml **out_root)
{
    void *data = NULL;
    size_t size = 0;
    air_status status = air_file_read(document->context, path, &data, &size);
    if (status != AIR_OK)
        return status;
    air_xml_reader reader = {.document = document, .parser = XML_ParserCreate(NULL)};
    reader.file = air_xml_copy(document, path, strlen(path));
    if (reader.parser == NULL) {
        status = air_fail_memory(document->context, path);
    } else if (reader.file == NULL) {
        status = AIR_ERROR_MEMORY;
    } else {
        XML_SetUserData(reader.parser, &reader);
        XML_SetElementHandler(reader.parser, start_element, end_element);
        XML_SetStartDoctypeDeclHandler(reader.parser, refuse_doctype);
        status = parse(&reader, data, size);
    }
    if (reader.parser != NULL)
        XML_ParserFree(reader.parser);
    air_free(document->context, data);
    if (status == AIR_OK)
        *out_root = reader.root;
    return status;
}

/* ---- places ---- */

const char *air_xml_attribute_of(const air_xml *at, const char *name)
{
    for (const air_xml_attribute *i = at->attributes; i != NULL; i = i->next)
        if (strcmp(i->name, name) == 0)
            return i->value;
    return NULL;
}

void air_xml_describe(const air_xml *at, char *buffer, size_t size)
{
    static const char *const telling[] = {"type", "name", "id"};
    int used = snprintf(buffer, size, "%s: line %zu: <%.40s", at->file, at->line, at->tag);
    for (size_t i = 0; i < sizeof telling / sizeof *telling; ++i) {
        const char *value = air_xml_attribute_of(at, telling[i]);
        if (value != NULL && used >= 0 && (size_t)used < size)
            used +=
                snprintf(buffer + used, size - (size_t)used, " %s=\"%.60s\"", telling[i], value);
    }
    if (used >= 0 && (size_t)used < size)
        snprintf(buffer + used, size - (size_t)used, ">");
}

air_status air_xml_vfail(const air_xml_document *document, const air_xml *at, air_status status,
                         const char *sentence, va_list arguments)
{
    char place[1024], text[1024];
    vsnprintf(text, sizeof text, sentence, arguments);
    air_xml_describe(at, place, sizeof place);
    return air_fail(document->context, status, "%s: %s", place, text);
}

air_status air_xml_fail(const air_xml_document *document, const air_xml *at, air_status status,
                        const char *sentence, ...)
{
    va_list arguments;
    va_start(arguments, sentence);
    const air_status said = air_xml_vfail(document, at, status, sentence, arguments);
    va_end(arguments);
    return said;
}

air_status air_xml_place_error(const air_xml_document *document, const air_xml *at,
                               air_status status)
{
    char text[1024];
    if (status == AIR_OK || status == AIR_ERROR_MEMORY)
        return status;
    snprintf(text, sizeof text, "%s", air_context_last_error(document->context));
    return air_xml_fail(document, at, status, "%s", text);
}

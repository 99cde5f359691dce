/* xml.h: an XML file as a tree of elements that know where they stand.
 *
 * Files are read by Expat. Document types, and with them entities, are refused: nothing is
 * expanded. All elements and strings live in their document's blocks and go with them. */
#ifndef AIR_SCENE_IMPORT_MITSUBA_XML_H
#define AIR_SCENE_IMPORT_MITSUBA_XML_H

#include "core/host.h"

/* Deeper nesting, and more elements in all files of a document, are taken for an attack. */
enum { AIR_XML_DEPTH = 64, AIR_XML_ELEMENTS = 4000000 };

typedef struct air_xml_attribute {
    const char *name, *value;
    struct air_xml_attribute *next;
} air_xml_attribute;

typedef struct air_xml {
    const char *tag;
    air_xml_attribute *attributes;
    const char *file;
    size_t line;
    double version; /* of its file's root: "0.5.0" is 0.5 */
    struct air_xml *parent, *child, *last_child, *next;
    void *made; /* what readers keep with it; NULL at first */
    bool used;  /* somebody took it into account */
    bool asked; /* what was not used of its children is worth a warning */
} air_xml;

typedef struct air_xml_block air_xml_block;

typedef struct air_xml_document {
    air_context *context;
    air_xml_block *blocks;
    size_t element_count;
} air_xml_document;

void air_xml_finish(air_xml_document *document);

/* Memory that lives as long as the document, set to 0; NULL when it is out, which is then said. */
void *air_xml_allocate(air_xml_document *document, size_t size);
/* A copy that lives as long. */
char *air_xml_copy(air_xml_document *document, const char *text, size_t length);

/* Reads a file; *out_root is its outermost element. The message names file and line. */
air_status air_xml_read(air_xml_document *document, const char *path, air_xml **out_root);

/* The value of an attribute, NULL if there is none. */
const char *air_xml_attribute_of(const air_xml *at, const char *name);

/* "FILE: line 12: <float name="fov">" with what distinguishes the element. */
void air_xml_describe(const air_xml *at, char *buffer, size_t size);
/* The status, with that and a sentence. */
air_status air_xml_fail(const air_xml_document *document, const air_xml *at, air_status status,
                        const char *sentence, ...) __attribute__((format(printf, 4, 5)));
air_status air_xml_vfail(const air_xml_document *document, const air_xml *at, air_status status,
                         const char *sentence, va_list arguments)
    __attribute__((format(printf, 4, 0)));
/* After a callee failed with a message of its own: says it again behind the place. */
air_status air_xml_place_error(const air_xml_document *document, const air_xml *at,
                               air_status status);

#endif

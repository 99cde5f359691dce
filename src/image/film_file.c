/* film_file.c: films on disk, docs/film-format.md. Little-endian, as every machine this is built
 * for. */
#include <string.h>

#include "image/film.h"

enum { MAGIC_SIZE = 8, MAX_NODES = 4096, MAX_ATTRIBUTES = 4096, MAX_TEXT = 1 << 20 };
enum { MAX_ATTRIBUTE_NAME = 255 }; /* what an image takes */

static const char magic[MAGIC_SIZE] = {'A', 'I', 'R', 'F', 'I', 'L', 'M', '1'};

/* The fixed part of the header, after the magic. */
typedef struct film_header {
    uint32_t width, height, crop[4];
    uint64_t seed, settings;
    uint32_t replicate_size, slot_count, node_count, attribute_count;
} film_header;

/* ---- writing ---- */

typedef struct byte_writer {
    uint8_t *data;
    size_t size;
} byte_writer;

/* With data NULL only counts. */
static void put(byte_writer *writer, const void *data, size_t size)
{
    if (writer->data != NULL) {
        memcpy(writer->data + writer->size, data, size);
    }
    writer->size += size;
}

static void put_text(byte_writer *writer, const char *text)
{
    const uint32_t length = (uint32_t)strlen(text);
    put(writer, &length, sizeof length);
    put(writer, text, length);
}

static void put_film(byte_writer *writer, const air_film *film)
{
    film_header header;
    memset(&header, 0, sizeof header);
    header.width = film->width;
    header.height = film->height;
    memcpy(header.crop, film->crop, sizeof header.crop);
    header.seed = film->seed;
    header.settings = film->settings;
    header.replicate_size = film->replicate_size;
    header.slot_count = film->layout.slot_count;
    header.node_count = (uint32_t)film->node_count;
    header.attribute_count = (uint32_t)film->attribute_count;
    put(writer, magic, MAGIC_SIZE);
    put(writer, &header, sizeof header);
    for (uint32_t i = 0; i < film->layout.slot_count; i++) {
        const air_film_slot *slot = &film->layout.slots[i];
        const uint32_t kind = (uint32_t)slot->kind;
        put(writer, &kind, sizeof kind);
        put(writer, &slot->components, sizeof slot->components);
        put(writer, slot->name, AIR_FILM_NAME);
    }
    for (size_t i = 0; i < film->attribute_count; i++) {
        put_text(writer, film->attributes[i].name);
        put_text(writer, film->attributes[i].value);
    }
    for (size_t i = 0; i < film->node_count; i++) {
        const air_film_node *node = &film->nodes[i];
        put(writer, &node->begin, sizeof node->begin);
        put(writer, &node->end, sizeof node->end);
        put(writer, node->sums,
            air_film_pixel_count(film) * film->layout.stride * sizeof *node->sums);
    }
}

air_status air_film_save(const air_film *film, const char *path)
{
    byte_writer writer = {NULL, 0};
    put_film(&writer, film);
    writer.data = air_allocate(film->context, writer.size, 1);
    if (writer.data == NULL) {
        return air_fail_memory(film->context, path);
    }
    writer.size = 0;
    put_film(&writer, film);
    const air_status status = air_file_write(film->context, path, writer.data, writer.size);
    air_free(film->context, writer.data);
    return status;
}

/* ---- reading ---- */

typedef struct byte_reader {
    air_context *context;
    const char *path;
    const uint8_t *data;
    size_t size, at;
} byte_reader;

static air_status broken(const byte_reader *reader, const char *expected)
{
    return air_fail(reader->context, AIR_ERROR_FORMAT, "%s: byte %zu: expected %s", reader->path,
                    reader->at, expected);
}

static air_status take(byte_reader *reader, void *out, size_t size, const char *what)
{
    if (reader->size - reader->at < size) {
        return broken(reader, what);
    }
    memcpy(out, reader->data + reader->at, size);
    reader->at += size;
    return AIR_OK;
}

static bool has_slot(const air_film_layout *layout, const char *name)
{
    for (uint32_t i = 0; i < layout->slot_count; i++) {
        if (strcmp(layout->slots[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

static air_status take_slots(byte_reader *reader, uint32_t count, air_film_layout *layout)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t kind = 0, components = 0;
        char name[AIR_FILM_NAME];
        air_status status = take(reader, &kind, sizeof kind, "a slot");
        status = status == AIR_OK ? take(reader, &components, sizeof components, "a slot") : status;
        status = status == AIR_OK ? take(reader, name, sizeof name, "a slot name") : status;
        if (status != AIR_OK) {
            return status;
        }
        const bool fits =
            kind <= AIR_SLOT_SHARE && (kind == AIR_SLOT_RATIO   ? components == 12
                                       : kind == AIR_SLOT_SHARE ? components == 13
                                       : kind == AIR_SLOT_GUIDE ? components == 1 || components == 3
                                                                : components == 3);
        if (!fits || name[AIR_FILM_NAME - 1] != '\0' || name[0] == '\0') {
            return broken(reader, "a slot of a known kind, number of components and name");
        }
        if (has_slot(layout, name)) {
            return broken(reader, "a slot of another name than those before");
        }
        air_film_layout_add(layout, (air_slot_kind)kind, name, components);
    }
    return AIR_OK;
}

static air_status take_text(byte_reader *reader, char **out)
{
    uint32_t length = 0;
    air_status status = take(reader, &length, sizeof length, "the length of a text");
    if (status != AIR_OK) {
        return status;
    }
    if (length > MAX_TEXT || length > reader->size - reader->at) {
        return broken(reader, "a text that ends within the file");
    }
    *out = air_string_format(reader->context, "%.*s", (int)length,
                             (const char *)reader->data + reader->at);
    reader->at += length;
    return *out == NULL ? air_fail_memory(reader->context, reader->path) : AIR_OK;
}

static air_status take_attribute(byte_reader *reader, air_film *film)
{
    char *name = NULL, *value = NULL;
    air_status status = take_text(reader, &name);
    if (status == AIR_OK && (name[0] == '\0' || strlen(name) > MAX_ATTRIBUTE_NAME)) {
        status = broken(reader, "an attribute's name of 1 to 255 bytes");
    }
    status = status == AIR_OK ? take_text(reader, &value) : status;
    status = status == AIR_OK ? air_film_set_attribute(film, name, value) : status;
    air_free(reader->context, name);
    air_free(reader->context, value);
    return status;
}

static air_status take_node(byte_reader *reader, air_film *film)
{
    uint32_t range[2];
    air_film_node node;
    const uint32_t last = film->node_count > 0 ? film->nodes[film->node_count - 1].end : 0;
    const size_t bytes = air_film_pixel_count(film) * film->layout.stride * sizeof *node.sums;
    air_status status = take(reader, range, sizeof range, "a sample range");
    if (status != AIR_OK) {
        return status;
    }
    if (range[0] < last || range[0] >= range[1] || bytes > reader->size - reader->at) {
        return broken(reader, "sample ranges in order and the sums of every pixel");
    }
    status = air_film_node_create(film, range[0], range[1], &node);
    if (status == AIR_OK) {
        status = take(reader, node.sums, bytes, "sums");
        status = status == AIR_OK ? air_film_add(film, &node) : status;
        air_free(film->context, node.sums);
    }
    return status;
}

static bool sane(const film_header *h)
{
    return h->width >= 1 && h->width <= 65535 && h->height >= 1 && h->height <= 65535 &&
           h->crop[0] < h->crop[2] && h->crop[1] < h->crop[3] && h->crop[2] <= h->width &&
           h->crop[3] <= h->height && h->slot_count >= 1 && h->slot_count <= AIR_FILM_MAX_SLOTS &&
           h->node_count <= MAX_NODES && h->attribute_count <= MAX_ATTRIBUTES;
}

static air_status take_film(byte_reader *reader, air_film **out_film)
{
    char found[MAGIC_SIZE];
    film_header header;
    air_film description;
    air_status status = take(reader, found, sizeof found, "an airlight film");
    if (status != AIR_OK) {
        return status;
    }
    if (memcmp(found, magic, MAGIC_SIZE) != 0) {
        reader->at = 0;
        return broken(reader, "\"AIRFILM1\", the mark of an airlight film");
    }
    status = take(reader, &header, sizeof header, "a film header");
    if (status != AIR_OK || !sane(&header)) {
        return status != AIR_OK ? status : broken(reader, "a film header with sizes in range");
    }
    memset(&description, 0, sizeof description);
    description.width = header.width;
    description.height = header.height;
    memcpy(description.crop, header.crop, sizeof description.crop);
    description.seed = header.seed;
    description.settings = header.settings;
    description.replicate_size = header.replicate_size;
    status = take_slots(reader, header.slot_count, &description.layout);
    if (status != AIR_OK) {
        return status;
    }
    status = air_film_create(reader->context, &description, out_film);
    for (uint32_t i = 0; i < header.attribute_count && status == AIR_OK; i++) {
        status = take_attribute(reader, *out_film);
    }
    for (uint32_t i = 0; i < header.node_count && status == AIR_OK; i++) {
        status = take_node(reader, *out_film);
    }
    if (status == AIR_OK && reader->at != reader->size) {
        status = broken(reader, "the end of the file");
    }
    return status;
}

air_status air_film_load(air_context *context, const char *path, air_film **out_film)
{
    void *data = NULL;
    byte_reader reader = {context, path, NULL, 0, 0};
    air_film *film = NULL;
    *out_film = NULL;
    air_status status = air_file_read(context, path, &data, &reader.size);
    if (status != AIR_OK) {
        return status;
    }
    reader.data = data;
    status = take_film(&reader, &film);
    air_free(context, data);
    if (status != AIR_OK) {
        air_film_destroy(film);
        return status;
    }
    *out_film = film;
    return AIR_OK;
}

/* record.h: the immutable, reference-counted parts that scenes and snapshots share. */
#ifndef AIR_SCENE_RECORD_H
#define AIR_SCENE_RECORD_H

#include <stdatomic.h>

#include "airlight/medium.h"
#include "core/host.h"

/* What a handle can name. */
typedef enum air_object_kind {
    AIR_OBJECT_TEXTURE = 0,
    AIR_OBJECT_GRID = 1,
    AIR_OBJECT_MATERIAL = 2,
    AIR_OBJECT_MESH = 3,
    AIR_OBJECT_MEDIUM = 4,
    AIR_OBJECT_LIGHT = 5,
    AIR_OBJECT_CAMERA = 6,
    AIR_OBJECT_KIND_COUNT = 7
} air_object_kind;

/* "texture", "grid", ... */
const char *air_object_kind_name(air_object_kind kind);

/* The first member of everything that is counted. */
typedef struct air_record {
    atomic_size_t references;
    air_context *context;
    void (*destroy)(
        struct air_record *record); /* frees what the record owns besides its name and itself */
    char *name;                     /* owned; "" if it has none */
} air_record;

/* A zeroed record of `size` bytes, referenced once, with a copy of name (NULL: ""). NULL when
 * memory is out, which has then been reported. */
void *air_record_create(air_context *context, size_t size, void (*destroy)(air_record *record),
                        const char *name);

/* The destroy of records that own nothing but their name. */
void air_record_own_nothing(air_record *record);

/* Both are thread-safe; release takes NULL. */
void air_record_retain(air_record *record);
void air_record_release(air_record *record);

/* A reference from one object's description to another object. */
typedef struct air_link {
    air_handle handle;
    air_object_kind kind; /* of what the handle has to name */
    const char *field;
    bool required; /* AIR_NONE is not allowed */
} air_link;

enum { AIR_MAX_LINKS = 10 };

/* The index of a handle among items that begin with theirs and are in increasing order of it,
 * SIZE_MAX if it is not there. */
size_t air_handle_find(const void *items, size_t count, size_t item_size, air_handle handle);

/* A fresh copy of count*size bytes, NULL if data is NULL; *ok becomes false when memory is out. */
void *air_record_copy(air_context *context, const void *data, size_t count, size_t size, bool *ok);

/* Are two arrays, each possibly NULL, the same bytes? */
bool air_bytes_equal(const void *a, const void *b, size_t size);

#endif

#include "scene/record.h"

#include <string.h>

const char *air_object_kind_name(air_object_kind kind)
{
    static const char *const names[AIR_OBJECT_KIND_COUNT] = {"texture", "grid",  "material", "mesh",
                                                             "medium",  "light", "camera"};
    return names[kind];
}

void *air_record_create(air_context *context, size_t size, void (*destroy)(air_record *record),
                        const char *name)
{
    air_record *record = air_allocate(context, 1, size);
    char *copy = air_string_copy(context, name);
    if (record == NULL || copy == NULL) {
        air_free(context, copy);
        air_free(context, record);
        air_fail_memory(context, "scene");
        return NULL;
    }
    atomic_init(&record->references, 1);
    record->context = context;
    record->destroy = destroy;
    record->name = copy;
    return record;
}

void air_record_own_nothing(air_record *record) { (void)record; }

void air_record_retain(air_record *record)
{
    atomic_fetch_add_explicit(&record->references, 1, memory_order_relaxed);
}

void air_record_release(air_record *record)
{
    /* acquire-release: whoever frees must see what every other holder did before letting go */
    if (record == NULL ||
        atomic_fetch_sub_explicit(&record->references, 1, memory_order_acq_rel) != 1)
        return;
    air_context *context = record->context;
    record->destroy(record);
    air_free(context, record->name);
    air_free(context, record);
}

static air_handle handle_at(const void *items, size_t index, size_t item_size)
{
    air_handle handle;
    memcpy(&handle, (const unsigned char *)items + index * item_size, sizeof handle);
    return handle;
}

size_t air_handle_find(const void *items, size_t count, size_t item_size, air_handle handle)
{
    size_t begin = 0, end = count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (handle_at(items, middle, item_size) < handle)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin < count && handle_at(items, begin, item_size) == handle ? begin : SIZE_MAX;
}

void *air_record_copy(air_context *context, const void *data, size_t count, size_t size, bool *ok)
{
    if (data == NULL)
        return NULL;
    void *copy = air_allocate(context, count, size);
    if (copy == NULL)
        *ok = false;
    else
        memcpy(copy, data, count * size);
    return copy;
}

bool air_bytes_equal(const void *a, const void *b, size_t size)
{
    if (a == NULL || b == NULL)
        return a == b;
    return a == b || memcmp(a, b, size) == 0;
}

#include "image/film.h"

#include <string.h>

void air_film_layout_add(air_film_layout *layout, air_slot_kind kind, const char *name,
                         uint32_t components)
{
    air_film_slot *slot = &layout->slots[layout->slot_count++];
    memset(slot, 0, sizeof *slot);
    slot->kind = kind;
    strncpy(slot->name, name, AIR_FILM_NAME - 1);
    slot->components = components;
    slot->offset = layout->stride;
    layout->stride += components;
}

size_t air_film_pixel_count(const air_film *film)
{
    return (size_t)(film->crop[2] - film->crop[0]) * (film->crop[3] - film->crop[1]);
}

air_status air_film_create(air_context *context, const air_film *description, air_film **out_film)
{
    air_film *film = air_allocate(context, 1, sizeof *film);
    *out_film = NULL;
    if (film == NULL) {
        return air_fail_memory(context, "film");
    }
    *film = *description;
    film->context = context;
    film->nodes = NULL;
    film->attributes = NULL;
    film->node_count = film->node_capacity = film->attribute_count = 0;
    *out_film = film;
    return AIR_OK;
}

void air_film_destroy(air_film *film)
{
    if (film == NULL) {
        return;
    }
    for (size_t i = 0; i < film->node_count; i++) {
        air_free(film->context, film->nodes[i].sums);
    }
    for (size_t i = 0; i < film->attribute_count; i++) {
        air_free(film->context, film->attributes[i].name);
        air_free(film->context, film->attributes[i].value);
    }
    air_free(film->context, film->nodes);
    air_free(film->context, film->attributes);
    air_free(film->context, film);
}

size_t air_film_width(const air_film *film) { return film->crop[2] - film->crop[0]; }
size_t air_film_height(const air_film *film) { return film->crop[3] - film->crop[1]; }

void air_film_samples(const air_film *film, uint32_t *out_begin, uint32_t *out_end)
{
    *out_begin = film->node_count > 0 ? film->nodes[0].begin : 0;
    *out_end = film->node_count > 0 ? film->nodes[film->node_count - 1].end : 0;
}

/* ---- the tree of blocks ---- */

uint32_t air_film_node_end(uint32_t begin, uint32_t end)
{
    uint32_t size = AIR_FILM_BLOCK;
    if (end - begin < size) {
        return end;
    }
    while (size < 0x40000000u && begin % (2 * size) == 0 && end - begin >= 2 * size) {
        size *= 2;
    }
    return begin + size;
}

/* Whole runs only: a last block of fewer than 16 samples has no sibling. */
static bool siblings(const air_film_node *a, const air_film_node *b)
{
    const uint32_t size = a->end - a->begin;
    return b->begin == a->end && b->end - b->begin == size && size % AIR_FILM_BLOCK == 0 &&
           (size & (size - 1)) == 0 && a->begin % (2 * size) == 0;
}

static void join(air_film *film, size_t i)
{
    air_film_node *a = &film->nodes[i];
    const size_t count = air_film_pixel_count(film) * film->layout.stride;
    for (size_t k = 0; k < count; k++) {
        a->sums[k] += film->nodes[i + 1].sums[k];
    }
    a->end = film->nodes[i + 1].end;
    air_free(film->context, film->nodes[i + 1].sums);
    film->node_count--;
    memmove(&film->nodes[i + 1], &film->nodes[i + 2],
            (film->node_count - i - 1) * sizeof *film->nodes);
}

static void join_all(air_film *film)
{
    for (size_t i = 0; i + 1 < film->node_count;) {
        if (siblings(&film->nodes[i], &film->nodes[i + 1])) {
            join(film, i);
            i = 0;
        } else {
            i++;
        }
    }
}

air_status air_film_node_create(const air_film *film, uint32_t begin, uint32_t end,
                                air_film_node *out)
{
    out->begin = begin;
    out->end = end;
    out->sums = air_allocate(film->context, air_film_pixel_count(film),
                             film->layout.stride * sizeof *out->sums);
    if (out->sums == NULL) {
        return air_fail(film->context, AIR_ERROR_MEMORY,
                        "film of %zu x %zu pixels: %.1f MiB could not be allocated",
                        air_film_width(film), air_film_height(film),
                        (double)air_film_pixel_count(film) * film->layout.stride *
                            sizeof *out->sums / 1048576.0);
    }
    return AIR_OK;
}

/* Makes room for more nodes. */
static air_status reserve(air_film *film, size_t more)
{
    if (film->node_capacity - film->node_count >= more) {
        return AIR_OK;
    }
    const size_t capacity = film->node_count + more + 4;
    air_film_node *grown =
        air_reallocate(film->context, film->nodes, capacity, sizeof *film->nodes);
    if (grown == NULL) {
        return air_fail_memory(film->context, "film");
    }
    film->nodes = grown;
    film->node_capacity = capacity;
    return AIR_OK;
}

air_status air_film_add(air_film *film, air_film_node *node)
{
    const air_status status = reserve(film, 1);
    if (status != AIR_OK) {
        return status;
    }
    size_t i = film->node_count;
    while (i > 0 && film->nodes[i - 1].begin > node->begin) {
        film->nodes[i] = film->nodes[i - 1];
        i--;
    }
    film->nodes[i] = *node;
    film->node_count++;
    node->sums = NULL;
    join_all(film);
    return AIR_OK;
}

void air_block_stack_push(air_block_stack *stack, const double *block)
{
    uint32_t level = 0;
    double *top = stack->sums + (size_t)stack->count * stack->stride;
    memcpy(top, block, stack->stride * sizeof *top);
    while (stack->count > 0 && stack->levels[stack->count - 1] == level) {
        double *below = top - stack->stride;
        for (uint32_t k = 0; k < stack->stride; k++) {
            below[k] += top[k];
        }
        top = below;
        stack->count--;
        level++;
    }
    stack->levels[stack->count++] = level;
}

void air_block_stack_total(air_block_stack *stack, double *out)
{
    memset(out, 0, stack->stride * sizeof *out);
    for (uint32_t i = 0; i < stack->count; i++) {
        for (uint32_t k = 0; k < stack->stride; k++) {
            out[k] += stack->sums[(size_t)i * stack->stride + k];
        }
    }
    stack->count = 0;
}

/* ---- merging ---- */

static bool same_layout(const air_film_layout *a, const air_film_layout *b)
{
    if (a->slot_count != b->slot_count) {
        return false;
    }
    for (uint32_t i = 0; i < a->slot_count; i++) {
        if (a->slots[i].kind != b->slots[i].kind ||
            a->slots[i].components != b->slots[i].components ||
            strcmp(a->slots[i].name, b->slots[i].name) != 0) {
            return false;
        }
    }
    return true;
}

static const char *difference(const air_film *a, const air_film *b)
{
    if (a->width != b->width || a->height != b->height) {
        return "sizes";
    }
    if (memcmp(a->crop, b->crop, sizeof a->crop) != 0) {
        return "crops";
    }
    if (a->seed != b->seed) {
        return "seeds";
    }
    if (!same_layout(&a->layout, &b->layout)) {
        return "layers";
    }
    if (a->replicate_size != b->replicate_size) {
        return "variance replicates";
    }
    return a->settings != b->settings ? "scenes or settings" : NULL;
}

static const air_film_node *overlap(const air_film *film, const air_film_node *node)
{
    for (size_t i = 0; i < film->node_count; i++) {
        if (film->nodes[i].begin < node->end && node->begin < film->nodes[i].end) {
            return &film->nodes[i];
        }
    }
    return NULL;
}

static air_status check_merge(const air_film *film, const air_film *other)
{
    const char *what = difference(film, other);
    if (what != NULL) {
        return air_fail(film->context, AIR_ERROR_ARGUMENT, "merge: the films differ in their %s",
                        what);
    }
    for (size_t i = 0; i < other->node_count; i++) {
        const air_film_node *twice = overlap(film, &other->nodes[i]);
        if (twice != NULL) {
            return air_fail(film->context, AIR_ERROR_ARGUMENT,
                            "merge: both films hold samples of %u:%u and %u:%u", twice->begin,
                            twice->end, other->nodes[i].begin, other->nodes[i].end);
        }
    }
    return AIR_OK;
}

/* Everything that can fail comes first, so that a film is merged wholly or not at all. */
air_status air_film_merge(air_film *film, const air_film *other)
{
    air_film_node *copies = NULL;
    air_status status = check_merge(film, other);
    if (status != AIR_OK) {
        return status;
    }
    copies = air_allocate(film->context, other->node_count, sizeof *copies);
    status = copies == NULL ? air_fail_memory(film->context, "merge") : AIR_OK;
    for (size_t i = 0; i < other->node_count && status == AIR_OK; i++) {
        const air_film_node *from = &other->nodes[i];
        status = air_film_node_create(film, from->begin, from->end, &copies[i]);
        if (status == AIR_OK) {
            memcpy(copies[i].sums, from->sums,
                   air_film_pixel_count(film) * film->layout.stride * sizeof *from->sums);
        }
    }
    status = status == AIR_OK ? reserve(film, other->node_count) : status;
    for (size_t i = 0; i < other->node_count && status == AIR_OK; i++) {
        status = air_film_add(film, &copies[i]);
    }
    for (size_t i = 0; copies != NULL && i < other->node_count; i++) {
        air_free(film->context, copies[i].sums);
    }
    air_free(film->context, copies);
    return status;
}

/* ---- attributes ---- */

static air_film_attribute *find_attribute(air_film *film, const char *name)
{
    for (size_t i = 0; i < film->attribute_count; i++) {
        if (strcmp(film->attributes[i].name, name) == 0) {
            return &film->attributes[i];
        }
    }
    return NULL;
}

static void remove_attribute(air_film *film, air_film_attribute *attribute)
{
    air_free(film->context, attribute->name);
    air_free(film->context, attribute->value);
    const size_t index = (size_t)(attribute - film->attributes);
    film->attribute_count--;
    memmove(attribute, attribute + 1, (film->attribute_count - index) * sizeof *attribute);
}

air_status air_film_set_attribute(air_film *film, const char *name, const char *value)
{
    air_film_attribute *old = find_attribute(film, name);
    if (value == NULL) {
        if (old != NULL) {
            remove_attribute(film, old);
        }
        return AIR_OK;
    }
    char *copy = air_string_copy(film->context, value);
    char *key = NULL;
    air_film_attribute *grown;
    if (copy == NULL) {
        goto out_of_memory;
    }
    if (old != NULL) {
        air_free(film->context, old->value);
        old->value = copy;
        return AIR_OK;
    }
    key = air_string_copy(film->context, name);
    grown = air_reallocate(film->context, film->attributes, film->attribute_count + 1,
                           sizeof *film->attributes);
    if (key == NULL || grown == NULL) {
        if (grown != NULL) {
            film->attributes = grown;
        }
        goto out_of_memory;
    }
    film->attributes = grown;
    film->attributes[film->attribute_count++] = (air_film_attribute){key, copy};
    return AIR_OK;

out_of_memory:
    air_free(film->context, key);
    air_free(film->context, copy);
    return air_fail_memory(film->context, "film attribute");
}

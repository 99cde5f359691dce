/* sets.h: disjoint sets over whole numbers; the smallest member is a set's name. */
#ifndef AIR_ATLAS_SETS_H
#define AIR_ATLAS_SETS_H

#include <stddef.h>
#include <stdint.h>

static inline void air_sets_init(uint32_t *parents, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        parents[i] = (uint32_t)i;
    }
}

/* The name of the set that i is in; paths are halved on the way. */
static inline uint32_t air_sets_find(uint32_t *parents, uint32_t i)
{
    while (parents[i] != i) {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    return i;
}

static inline void air_sets_join(uint32_t *parents, uint32_t a, uint32_t b)
{
    const uint32_t x = air_sets_find(parents, a), y = air_sets_find(parents, b);
    parents[x > y ? x : y] = x > y ? y : x;
}

/* Each set's name in the place of its members becomes a number from 0, in the order of the names;
 * returns how many there are. */
static inline size_t air_sets_number(uint32_t *parents, size_t count)
{
    size_t sets = 0;
    /* Members are larger than the name, so it has its number when they come. */
    for (size_t i = 0; i < count; i++) {
        parents[i] = parents[i] == i ? (uint32_t)sets++ : parents[parents[i]];
    }
    return sets;
}

#endif

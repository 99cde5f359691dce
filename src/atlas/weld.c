/* weld.c: equal vertices by a hash table with open addresses. */
#include "atlas/weld.h"

#include <string.h>

#include "core/random.h"

enum { KEY_WORDS = 5 };

typedef struct weld_key {
    uint32_t words[KEY_WORDS];
} weld_key;

/* Adding 0 makes -0 to 0. */
static uint32_t word_of(float number)
{
    const float plain = number + 0.0f;
    uint32_t word;
    memcpy(&word, &plain, sizeof word);
    return word;
}

static weld_key key_of(const air_weld_keys *keys, size_t vertex)
{
    weld_key key = {{0}};
    for (size_t k = 0; k < 3 && keys->positions != NULL; k++) {
        key.words[k] = word_of(keys->positions[3 * vertex + k]);
    }
    for (size_t k = 0; k < 2 && keys->uv != NULL; k++) {
        key.words[3 + k] = word_of(keys->uv[2 * vertex + k]);
    }
    return key;
}

static uint32_t hash_of(const weld_key *key)
{
    uint32_t hash = 0;
    for (int k = 0; k < KEY_WORDS; k++) {
        hash = air_hash_combine(hash, key->words[k]);
    }
    return hash;
}

air_status air_weld(air_context *context, const air_weld_keys *keys, uint32_t *out_first)
{
    size_t slots = 4;
    while (slots < 2 * keys->vertex_count) {
        slots *= 2;
    }
    uint32_t *table = air_allocate(context, slots, sizeof *table); /* vertex + 1; 0: empty */
    if (table == NULL) {
        return AIR_ERROR_MEMORY;
    }
    for (size_t v = 0; v < keys->vertex_count; v++) {
        const weld_key key = key_of(keys, v);
        size_t slot = hash_of(&key) & (slots - 1);
        for (;; slot = (slot + 1) & (slots - 1)) {
            if (table[slot] == 0) {
                table[slot] = (uint32_t)v + 1;
                break;
            }
            const weld_key other = key_of(keys, table[slot] - 1);
            if (memcmp(&other, &key, sizeof key) == 0) {
                break;
            }
        }
        out_first[v] = table[slot] - 1;
    }
    air_free(context, table);
    return AIR_OK;
}

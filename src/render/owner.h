/* owner.h: who computes what: one method per (light, medium, term). */
#ifndef AIR_RENDER_OWNER_H
#define AIR_RENDER_OWNER_H

#include "airlight/render.h"

struct air_owner_table {
    air_context *context;
    size_t light_count, medium_count;
    uint8_t *methods; /* [(light * (medium_count + 1) + medium) * AIR_TERM_COUNT + term] */
    uint8_t *modes;   /* per light: of the method that owns something of it */
};

/* wanted[i] = 1 where `method` owns; as many entries as the table has. */
void air_owner_table_mask(const air_owner_table *table, air_method method, uint8_t *wanted);
/* Does the method own something of the light? */
bool air_owner_table_uses(const air_owner_table *table, size_t light, air_method method);
size_t air_owner_table_size(const air_owner_table *table);

#endif

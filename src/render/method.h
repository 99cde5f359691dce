/* method.h: what the methods beside path have in common: a name, modes, and where they apply. */
#ifndef AIR_RENDER_METHOD_H
#define AIR_RENDER_METHOD_H

#include "airlight/render.h"
#include "scene/snapshot.h"

enum { AIR_METHOD_REASON = 160 };

typedef struct air_method_kind {
    const char *name;
    const char *const *modes; /* their names; the first is the default */
    size_t mode_count;
    uint32_t terms; /* that it owns of its lights: 1 << air_term */
    /* Can the method own these of this light (an index of the owner table)? If not, reason says
     * why. */
    bool (*applies)(const air_snapshot *snapshot, size_t light, char reason[AIR_METHOD_REASON]);
} air_method_kind;

extern const air_method_kind air_collimated_method, air_area_method, air_ordinates_method;

#endif

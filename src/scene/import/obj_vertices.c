#include "scene/import/obj_vertices.h"

#include <string.h>

bool air_obj_vertices_init(air_context *context, size_t most, air_obj_vertices *out)
{
    size_t slots = 16;
    while (slots < most + most / 2)
        slots *= 2;
    *out = (air_obj_vertices){.corners = air_allocate(context, most, sizeof *out->corners),
                              .slots = air_allocate(context, slots, sizeof *out->slots),
                              .mask = slots - 1};
    if (out->slots != NULL)
        memset(out->slots, 0xff, slots * sizeof *out->slots);
    return out->corners != NULL && out->slots != NULL;
}

void air_obj_vertices_finish(air_context *context, air_obj_vertices *vertices)
{
    air_free(context, vertices->slots);
    air_free(context, vertices->corners);
}

/* Odd factors that have nothing in common, then the upper bits, which depend on all. */
static size_t hash(air_obj_corner corner)
{
    uint64_t sum = corner.v * UINT64_C(0x9e3779b97f4a7c15) ^
                   corner.vt * UINT64_C(0xbf58476d1ce4e5b9) ^
                   corner.vn * UINT64_C(0x94d049bb133111eb);
    sum ^= sum >> 32;
    return (size_t)((sum * UINT64_C(0xd6e8feb86659fd93)) >> 32);
}

uint32_t air_obj_vertices_find(air_obj_vertices *vertices, air_obj_corner corner)
{
    size_t slot = hash(corner) & vertices->mask;
    for (; vertices->slots[slot] != AIR_OBJ_NONE; slot = (slot + 1) & vertices->mask) {
        const air_obj_corner *other = &vertices->corners[vertices->slots[slot]];
        if (other->v == corner.v && other->vt == corner.vt && other->vn == corner.vn)
            return vertices->slots[slot];
    }
    vertices->corners[vertices->count] = corner;
    vertices->slots[slot] = (uint32_t)vertices->count;
    return (uint32_t)vertices->count++;
}

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/media/boundary_topology.h"

/* ---- noting ---- */

/* Takes the last region, which is not to be used. */
static void drop_region(air_mitsuba *mitsuba)
{
    air_import_geometry_finish(mitsuba->context, &mitsuba->regions->geometry);
    mitsuba->regions = mitsuba->regions->next;
}

/* A region without a boundary: medium NULL is nothing at all, and has the shape's name. */
static air_status add_region(air_mitsuba *mitsuba, const air_xml *shape, air_xml *medium,
                             air_mitsuba_region **out)
{
    air_mitsuba_region *region = air_xml_allocate(&mitsuba->document, sizeof *region);
    if (region == NULL)
        return AIR_ERROR_MEMORY;
    region->at = shape;
    region->next = mitsuba->regions;
    mitsuba->regions = region;
    for (size_t i = 0; i < 3; ++i) {
        region->low[i] = -INFINITY;
        region->high[i] = INFINITY;
    }
    *out = region;
    air_medium_desc_default(&region->desc);
    region->desc.name = air_mitsuba_name(shape);
    return medium == NULL
               ? AIR_OK
               : air_mitsuba_read_medium(mitsuba, medium, &region->desc, &region->mixture);
}

/* The corners of [-1, 1]^3 bound what is in it. */
static void bound_box(const float map[12], air_mitsuba_region *region)
{
    for (size_t row = 0; row < 3; ++row) {
        const float reach = fabsf(map[4 * row]) + fabsf(map[4 * row + 1]) + fabsf(map[4 * row + 2]);
        region->low[row] = map[4 * row + 3] - reach;
        region->high[row] = map[4 * row + 3] + reach;
    }
}

static void bound_mesh(air_mitsuba_region *region)
{
    const air_import_geometry *geometry = &region->geometry;
    for (size_t i = 0; i < 3; ++i) {
        region->low[i] = INFINITY;
        region->high[i] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * geometry->vertex_count; ++i) {
        region->low[i % 3] = fminf(region->low[i % 3], geometry->positions[i]);
        region->high[i % 3] = fmaxf(region->high[i % 3], geometry->positions[i]);
    }
}

/* The boundary of a region; *out_closed false: the shape encloses nothing. */
static air_status set_boundary(air_mitsuba *mitsuba, const air_mitsuba_geometry *geometry,
                               air_mitsuba_region *region, bool *out_closed)
{
    air_boundary *boundary = &region->desc.boundary;
    *out_closed = geometry->box || geometry->shape == AIR_SHAPE_SPHERE;
    if (*out_closed) {
        boundary->kind = geometry->box ? AIR_BOUNDARY_BOX : AIR_BOUNDARY_ELLIPSOID;
        memcpy(boundary->box_to_world, geometry->to_world, sizeof geometry->to_world);
        bound_box(geometry->to_world, region);
        return AIR_OK;
    }
    if (geometry->shape != AIR_SHAPE_TRIANGLES)
        return AIR_OK;
    air_status status = air_mitsuba_append_triangles(mitsuba->context, geometry, &region->geometry);
    if (status == AIR_OK)
        status = air_topology_is_closed(mitsuba->context, region->geometry.positions,
                                        region->geometry.vertex_count, region->geometry.indices,
                                        region->geometry.triangle_count, out_closed);
    if (status != AIR_OK)
        return status;
    boundary->kind = AIR_BOUNDARY_MESH;
    boundary->positions = region->geometry.positions;
    boundary->vertex_count = region->geometry.vertex_count;
    boundary->indices = region->geometry.indices;
    boundary->triangle_count = region->geometry.triangle_count;
    bound_mesh(region);
    return AIR_OK;
}

static air_status refuse_open(air_mitsuba *mitsuba, const air_xml *shape)
{
    return air_mitsuba_replace(mitsuba, shape,
                               "the shape is not closed, so that it bounds no medium",
                               "the medium within is left out");
}

air_status air_mitsuba_note_region(air_mitsuba *mitsuba, const air_mitsuba_item *item,
                                   const air_mitsuba_geometry *geometry, bool clear)
{
    air_xml *interior = NULL, *exterior = NULL;
    air_mitsuba_region *region = NULL;
    bool closed = false;
    air_status status = air_mitsuba_child(mitsuba, item->at, "medium", "interior", &interior);
    if (status == AIR_OK)
        status = air_mitsuba_child(mitsuba, item->at, "medium", "exterior", &exterior);
    /* what is in an opaque shape nobody sees; one that tells of no medium changes none */
    if (status != AIR_OK || !clear || (interior == NULL && exterior == NULL))
        return status;
    status = add_region(mitsuba, item->at, interior, &region);
    if (status == AIR_OK)
        status = set_boundary(mitsuba, geometry, region, &closed);
    if (status != AIR_OK || closed)
        return status;
    drop_region(mitsuba);
    return interior != NULL ? refuse_open(mitsuba, item->at) : AIR_OK;
}

void air_mitsuba_regions_finish(air_mitsuba *mitsuba)
{
    while (mitsuba->regions != NULL)
        drop_region(mitsuba);
}

/* ---- what is outside ---- */

/* Is the medium that of a shape, and if a point is given, of one whose bounds hold it? */
static air_status is_inside(const air_mitsuba *mitsuba, const air_xml *medium, const float *point,
                            bool *out)
{
    *out = false;
    for (const air_mitsuba_region *i = mitsuba->regions; i != NULL; i = i->next) {
        air_xml *interior = NULL;
        const air_status status =
            air_mitsuba_child(mitsuba, i->at, "medium", "interior", &interior);
        if (status != AIR_OK)
            return status;
        bool holds = interior == medium;
        for (size_t k = 0; k < 3 && point != NULL; ++k)
            holds = holds && i->low[k] <= point[k] && point[k] <= i->high[k];
        *out = *out || holds;
    }
    return AIR_OK;
}

/* The medium around the sensor, unless it is in a shape of that medium. */
static air_status sensor_medium(const air_mitsuba *mitsuba, air_xml **out)
{
    float map[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    bool inside = false;
    air_status status = air_mitsuba_child(mitsuba, mitsuba->sensor, "medium", NULL, out);
    if (status == AIR_OK && *out != NULL)
        status = air_mitsuba_transform(mitsuba, mitsuba->sensor, "to_world", map);
    const float point[3] = {map[3], map[7], map[11]};
    if (status == AIR_OK && *out != NULL)
        status = is_inside(mitsuba, *out, point, &inside);
    if (inside)
        *out = NULL;
    return status;
}

/* The medium outside everything: the sensor's, or else the first that is outside a shape and inside
 * none. */
static air_status find_outside(const air_mitsuba *mitsuba, air_xml **out)
{
    air_status status = AIR_OK;
    *out = NULL;
    if (mitsuba->sensor != NULL)
        status = sensor_medium(mitsuba, out);
    for (size_t i = 0; i < mitsuba->item_count && status == AIR_OK; ++i) {
        air_xml *exterior = NULL;
        bool inside = false;
        status = air_mitsuba_child(mitsuba, mitsuba->items[i].at, "medium", "exterior", &exterior);
        if (status == AIR_OK && exterior != NULL)
            status = is_inside(mitsuba, exterior, NULL, &inside);
        if (status != AIR_OK || exterior == NULL || inside || exterior == *out)
            continue;
        if (*out != NULL)
            status = air_mitsuba_replace(mitsuba, mitsuba->items[i].at,
                                         "there is another medium outside everything already",
                                         "that one is taken");
        else
            *out = exterior;
    }
    return status;
}

/* A medium that is only within opaque shapes: was one of them to be a null surface? */
static air_status warn_of_unseen(const air_mitsuba *mitsuba, const air_xml *outside)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < mitsuba->item_count && status == AIR_OK; ++i) {
        const air_mitsuba_item *item = &mitsuba->items[i];
        air_xml *interior = NULL;
        bool seen = false;
        if (!item->opaque)
            continue;
        status = air_mitsuba_child(mitsuba, item->at, "medium", "interior", &interior);
        if (status != AIR_OK || interior == NULL || interior == outside)
            continue;
        status = is_inside(mitsuba, interior, NULL, &seen);
        for (size_t k = 0; k < i; ++k) /* copies by instances */
            seen = seen || mitsuba->items[k].at == item->at;
        if (status == AIR_OK && !seen)
            status = air_mitsuba_warn(mitsuba, item->at,
                                      "the shape is opaque, so that nobody sees the medium within; "
                                      "<bsdf type=\"null\"/> lets rays pass");
    }
    return status;
}

/* ---- order ---- */

static double volume(const air_mitsuba_region *region)
{
    double product = 1.0;
    for (size_t i = 0; i < 3; ++i)
        product *= (double)region->high[i] - (double)region->low[i];
    return product;
}

/* The largest first. */
static int compare(const void *a, const void *b)
{
    const air_mitsuba_region *const *p = a, *const *q = b;
    const double difference = volume(*q) - volume(*p);
    return difference < 0.0 ? -1 : difference > 0.0;
}

static bool meet(const air_mitsuba_region *a, const air_mitsuba_region *b)
{
    for (size_t i = 0; i < 3; ++i)
        if (a->high[i] <= b->low[i] || b->high[i] <= a->low[i])
            return false;
    return true;
}

static bool is_empty(const air_medium_desc *desc)
{
    return vec3_is_zero(vec3_load(desc->sigma_s)) && vec3_is_zero(vec3_load(desc->sigma_a));
}

/* Where regions may meet the smaller one holds: of two that lie in each other it is the inner one.
 * Nothing replaces something only where something is. */
static air_status add_all(air_mitsuba *mitsuba, air_mitsuba_region **regions, size_t count)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < count && status == AIR_OK; ++i) {
        air_mitsuba_region *region = regions[i];
        air_handle handle = AIR_NONE;
        bool meets = false;
        for (size_t k = 0; k < count; ++k)
            meets = meets || (k != i && meet(region, regions[k]));
        if (!meets && is_empty(&region->desc))
            continue;
        region->desc.combine = meets ? AIR_COMBINE_REPLACE : AIR_COMBINE_ADD;
        region->desc.priority = meets ? (int32_t)i : 0;
        status = air_scene_add_medium(mitsuba->import->scene, &region->desc, &handle);
        if (status != AIR_OK)
            status = air_xml_place_error(&mitsuba->document, region->at, status);
    }
    return status;
}

air_status air_mitsuba_add_regions(air_mitsuba *mitsuba)
{
    air_xml *outside = NULL;
    air_mitsuba_region *region = NULL;
    size_t count = 0;
    air_status status = find_outside(mitsuba, &outside);
    if (status == AIR_OK)
        status = warn_of_unseen(mitsuba, outside);
    if (status == AIR_OK && outside != NULL)
        status = add_region(mitsuba, outside, outside, &region);
    if (status != AIR_OK)
        return status;
    for (const air_mitsuba_region *i = mitsuba->regions; i != NULL; i = i->next)
        ++count;
    air_mitsuba_region **regions = air_allocate(mitsuba->context, count, sizeof *regions);
    if (regions == NULL)
        return air_fail_memory(mitsuba->context, mitsuba->path);
    size_t place = count;
    for (air_mitsuba_region *i = mitsuba->regions; i != NULL; i = i->next)
        regions[--place] = i;
    qsort(regions, count, sizeof *regions, compare);
    status = add_all(mitsuba, regions, count);
    air_free(mitsuba->context, regions);
    return status;
}

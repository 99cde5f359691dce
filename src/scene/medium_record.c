#include "scene/medium_record.h"

#include "scene/media/media_build.h"

static void destroy_medium(air_record *record)
{
    air_medium_desc *desc = &((air_medium_record *)record)->desc;
    air_boundary *boundary = &desc->boundary;
    air_free(record->context, (void *)desc->phase.mixture);
    air_free(record->context, (void *)boundary->indices);
    air_free(record->context, (void *)boundary->positions);
    air_free(record->context, (void *)boundary->planes);
}

air_status air_medium_record_create(air_context *context, const air_medium_desc *desc,
                                    air_record **out_record)
{
    const air_status status = air_medium_check(context, desc);
    if (status != AIR_OK)
        return status;
    air_medium_record *record =
        air_record_create(context, sizeof *record, destroy_medium, desc->name);
    if (record == NULL)
        return AIR_ERROR_MEMORY;
    bool ok = true;
    const air_boundary *from = &desc->boundary;
    air_boundary *to = &record->desc.boundary;
    record->desc = *desc;
    record->desc.name = record->base.name;
    /* only the arrays that the kind of boundary or phase function looks at; the others may point
     * anywhere */
    const bool convex = from->kind == AIR_BOUNDARY_CONVEX, mesh = from->kind == AIR_BOUNDARY_MESH;
    to->planes = air_record_copy(context, convex ? from->planes : NULL, from->plane_count,
                                 4 * sizeof(float), &ok);
    to->positions = air_record_copy(context, mesh ? from->positions : NULL, from->vertex_count,
                                    3 * sizeof(float), &ok);
    to->indices = air_record_copy(context, mesh ? from->indices : NULL, from->triangle_count,
                                  3 * sizeof(uint32_t), &ok);
    const bool mixture = desc->phase.kind == AIR_PHASE_MIXTURE;
    record->desc.phase.mixture = air_record_copy(context, mixture ? desc->phase.mixture : NULL, 1,
                                                 sizeof *desc->phase.mixture, &ok);
    if (!ok) {
        air_record_release(&record->base);
        return air_fail_memory(context, "medium");
    }
    *out_record = &record->base;
    return AIR_OK;
}

size_t air_medium_links(const air_medium_desc *desc, air_link out_links[AIR_MAX_LINKS])
{
    if (desc->density.kind != AIR_DENSITY_GRID)
        return 0;
    out_links[0] = (air_link){desc->density.grid, AIR_OBJECT_GRID, "density.grid", true};
    out_links[1] =
        (air_link){desc->density.albedo_grid, AIR_OBJECT_GRID, "density.albedo_grid", false};
    out_links[2] =
        (air_link){desc->density.emission_grid, AIR_OBJECT_GRID, "density.emission_grid", false};
    return 3;
}

static bool detail_equal(const air_detail *a, const air_detail *b)
{
    return a->strength == b->strength &&
           (a->strength == 0.0f ||
            (a->scale == b->scale && a->octaves == b->octaves && a->seed == b->seed &&
             air_bytes_equal(a->to_world, b->to_world, sizeof a->to_world)));
}

static bool density_equal(const air_density *a, const air_density *b)
{
    if (a->kind != b->kind || !detail_equal(&a->detail, &b->detail))
        return false;
    switch (a->kind) {
    case AIR_DENSITY_LAYERED:
        return air_bytes_equal(a->up, b->up, sizeof a->up) && a->layer_count == b->layer_count &&
               air_bytes_equal(a->layer_bottom, b->layer_bottom, a->layer_count * sizeof(float)) &&
               air_bytes_equal(a->layer_density, b->layer_density,
                               a->layer_count * sizeof(float)) &&
               a->layer_top == b->layer_top;
    case AIR_DENSITY_EXPONENTIAL:
        return air_bytes_equal(a->up, b->up, sizeof a->up) && a->base_height == b->base_height &&
               a->scale_height == b->scale_height;
    case AIR_DENSITY_GRID:
        return a->grid == b->grid && a->albedo_grid == b->albedo_grid &&
               a->emission_grid == b->emission_grid &&
               air_bytes_equal(a->grid_to_world, b->grid_to_world, sizeof a->grid_to_world);
    case AIR_DENSITY_CONSTANT:
        break;
    }
    return true;
}

static bool boundary_equal(const air_boundary *a, const air_boundary *b)
{
    if (a->kind != b->kind)
        return false;
    switch (a->kind) {
    case AIR_BOUNDARY_BOX:
    case AIR_BOUNDARY_ELLIPSOID:
        return air_bytes_equal(a->box_to_world, b->box_to_world, sizeof a->box_to_world);
    case AIR_BOUNDARY_CONVEX:
        return a->plane_count == b->plane_count &&
               air_bytes_equal(a->planes, b->planes, a->plane_count * 4 * sizeof(float));
    case AIR_BOUNDARY_MESH:
        return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
               air_bytes_equal(a->positions, b->positions, a->vertex_count * 3 * sizeof(float)) &&
               air_bytes_equal(a->indices, b->indices, a->triangle_count * 3 * sizeof(uint32_t));
    case AIR_BOUNDARY_UNBOUNDED:
        break;
    }
    return true;
}

static bool phase_equal(air_phase a, air_phase b)
{
    if (a.kind != b.kind)
        return false;
    if (a.kind == AIR_PHASE_MIXTURE)
        return a.mixture->lobe_count == b.mixture->lobe_count &&
               air_bytes_equal(a.mixture->lobes, b.mixture->lobes,
                               a.mixture->lobe_count * sizeof *a.mixture->lobes);
    return a.kind != AIR_PHASE_HG || a.g == b.g;
}

bool air_medium_equal(const air_medium_desc *a, const air_medium_desc *b)
{
    return air_bytes_equal(a->sigma_s, b->sigma_s, sizeof a->sigma_s) &&
           air_bytes_equal(a->sigma_a, b->sigma_a, sizeof a->sigma_a) &&
           air_bytes_equal(a->emission, b->emission, sizeof a->emission) &&
           phase_equal(a->phase, b->phase) && a->combine == b->combine &&
           a->priority == b->priority && density_equal(&a->density, &b->density) &&
           boundary_equal(&a->boundary, &b->boundary);
}

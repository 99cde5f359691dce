/* export_medium.c: media in the airlight object; all of it in world space. */
#include <math.h>

#include "scene/export/export.h"

/* In the order of air_phase_kind. */
static const char *const phases[] = {"isotropic", "hg", "rayleigh", "mixture"};

static json_t *lobe(air_export *self, air_phase_kind kind, float g)
{
    json_t *object = json_object();
    air_export_put(self, object, "type", json_string(phases[kind]));
    if (kind == AIR_PHASE_HG)
        air_export_put(self, object, "g", json_real((double)g));
    return object;
}

static json_t *phase(air_export *self, const air_phase *from)
{
    json_t *object = lobe(self, from->kind, from->g);
    if (from->kind != AIR_PHASE_MIXTURE)
        return object;
    json_t *lobes = air_export_list(self, object, "lobes");
    for (size_t i = 0; i < from->mixture->lobe_count; ++i) {
        const air_phase_lobe *part = &from->mixture->lobes[i];
        json_t *entry = lobe(self, part->kind, part->g);
        air_export_put(self, entry, "weight", json_real((double)part->weight));
        air_export_push(self, lobes, entry);
    }
    return object;
}

/* ---- density ---- */

static void put_layers(air_export *self, const air_density *density, json_t *object)
{
    json_t *layers = air_export_list(self, object, "layers");
    for (size_t i = 0; i < density->layer_count; ++i) {
        json_t *layer = json_object();
        air_export_put(self, layer, "bottom", json_real((double)density->layer_bottom[i]));
        air_export_put(self, layer, "density", json_real((double)density->layer_density[i]));
        air_export_push(self, layers, layer);
    }
    if (isfinite(density->layer_top))
        air_export_put(self, object, "top", json_real((double)density->layer_top));
}

static void put_exponential(air_export *self, const air_density *density, json_t *object)
{
    json_t *exponential = air_export_object(self, object, "exponential");
    air_export_put(self, exponential, "base_height", json_real((double)density->base_height));
    air_export_put(self, exponential, "scale_height", json_real((double)density->scale_height));
}

static void put_detail(air_export *self, const air_detail *detail, json_t *medium)
{
    if (!(detail->strength > 0.0f))
        return;
    json_t *object = air_export_object(self, medium, "detail");
    air_export_put(self, object, "strength", json_real((double)detail->strength));
    air_export_put(self, object, "scale", json_real((double)detail->scale));
    air_export_put(self, object, "octaves", json_integer(detail->octaves));
    air_export_put(self, object, "seed", json_integer(detail->seed));
    if (!air_export_is_identity(detail->to_world))
        air_export_put(self, object, "to_world", air_export_rows(self, detail->to_world));
}

static air_status put_density(air_export *self, const air_medium_desc *desc, json_t *medium)
{
    const air_density *density = &desc->density;
    put_detail(self, &density->detail, medium);
    if (density->kind == AIR_DENSITY_CONSTANT)
        return AIR_OK;
    if (density->kind == AIR_DENSITY_GRID)
        return air_export_medium_grids(self, desc, medium);
    json_t *object = air_export_object(self, medium, "density");
    air_export_put(self, object, "up", air_export_floats(self, density->up, 3));
    if (density->kind == AIR_DENSITY_LAYERED)
        put_layers(self, density, object);
    else
        put_exponential(self, density, object);
    return AIR_OK;
}

/* ---- boundary ---- */

static json_t *planes(air_export *self, const air_boundary *boundary)
{
    json_t *array = json_array();
    for (size_t i = 0; i < boundary->plane_count; ++i)
        air_export_push(self, array, air_export_floats(self, boundary->planes + 4 * i, 4));
    return array;
}

static air_status put_boundary(air_export *self, const air_medium_desc *desc, json_t *medium)
{
    const air_boundary *boundary = &desc->boundary;
    const char *name = NULL;
    air_status status = AIR_OK;
    if (boundary->kind == AIR_BOUNDARY_UNBOUNDED) {
        air_export_put(self, medium, "boundary", json_string("unbounded"));
        return AIR_OK;
    }
    json_t *object = air_export_object(self, medium, "boundary");
    if (boundary->kind == AIR_BOUNDARY_BOX) {
        air_export_put(self, air_export_object(self, object, "box"), "to_world",
                       air_export_rows(self, boundary->box_to_world));
    } else if (boundary->kind == AIR_BOUNDARY_ELLIPSOID) {
        air_export_put(self, object, "ellipsoid", air_export_rows(self, boundary->box_to_world));
    } else if (boundary->kind == AIR_BOUNDARY_CONVEX) {
        air_export_put(self, object, "planes", planes(self, boundary));
    } else {
        status = air_export_boundary(self, desc, &name);
        air_export_put(self, object, "mesh", name != NULL ? json_string(name) : NULL);
    }
    return status;
}

/* ---- the whole ---- */

static air_status add_medium(air_export *self, const air_medium_desc *desc)
{
    json_t *medium = json_object();
    air_export_push(self, air_export_list(self, self->airlight, "media"), medium);
    air_export_name(self, medium, desc->name);
    air_export_put(self, medium, "sigma_s", air_export_color(self, desc->sigma_s));
    air_export_put(self, medium, "sigma_a", air_export_color(self, desc->sigma_a));
    if (desc->emission[0] > 0.0f || desc->emission[1] > 0.0f || desc->emission[2] > 0.0f)
        air_export_put(self, medium, "emission", air_export_color(self, desc->emission));
    air_export_put(self, medium, "phase", phase(self, &desc->phase));
    if (desc->combine == AIR_COMBINE_REPLACE)
        air_export_put(self, medium, "combine", json_string("replace"));
    if (desc->priority != 0)
        air_export_put(self, medium, "priority", json_integer(desc->priority));
    const air_status status = put_density(self, desc, medium);
    return status == AIR_OK ? put_boundary(self, desc, medium) : status;
}

air_status air_export_media(air_export *self)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_MEDIUM];
    air_status status = AIR_OK;
    for (size_t i = 0; i < list->count && status == AIR_OK; ++i)
        status = add_medium(self, &((const air_medium_record *)list->slots[i].record)->desc);
    return status;
}

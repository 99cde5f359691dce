#include "scene/import/mitsuba/mitsuba.h"

#include <string.h>

#include "scene/import/json_place.h"
#include "scene/import/resource.h"

static const float identity[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                   0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};

/* A texture in a texture in a texture. */
enum { NESTING = 32 };

/* ---- what has been made ---- */

const char *air_mitsuba_name(const air_xml *at)
{
    const char *id = air_xml_attribute_of(at, "id");
    return id != NULL ? id : air_mitsuba_type(at);
}

air_mitsuba_made *air_mitsuba_find_made(const air_xml *at, const air_xml *with)
{
    air_mitsuba_made *made = at->made;
    while (made != NULL && made->with != with)
        made = made->next;
    return made;
}

air_mitsuba_made *air_mitsuba_note_made(air_mitsuba *mitsuba, air_xml *at, const air_xml *with,
                                        air_handle handle)
{
    air_mitsuba_made *made = air_xml_allocate(&mitsuba->document, sizeof *made);
    if (made == NULL)
        return NULL;
    *made = (air_mitsuba_made){.with = with, .handle = handle, .next = at->made};
    at->made = made;
    return made;
}

air_status air_mitsuba_enter(air_mitsuba *mitsuba, air_xml *at)
{
    if (mitsuba->nesting >= NESTING)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "it refers to itself, or elements are nested too deep");
    ++mitsuba->nesting;
    at->asked = true;
    return AIR_OK;
}

void air_mitsuba_leave(air_mitsuba *mitsuba) { --mitsuba->nesting; }

/* ---- collecting ---- */

air_import_object *air_mitsuba_add_item(air_mitsuba *mitsuba, air_xml *at, const air_xml *named,
                                        const float instance_to_world[12])
{
    if (mitsuba->item_count == mitsuba->item_capacity) {
        const size_t capacity = 2 * mitsuba->item_capacity + 64;
        air_mitsuba_item *items =
            air_reallocate(mitsuba->context, mitsuba->items, capacity, sizeof *items);
        if (items == NULL) {
            (void)air_fail_memory(mitsuba->context, mitsuba->path);
            return NULL;
        }
        mitsuba->items = items;
        mitsuba->item_capacity = capacity;
    }
    air_mitsuba_item *item = &mitsuba->items[mitsuba->item_count];
    *item = (air_mitsuba_item){.at = at};
    memcpy(item->instance_to_world, instance_to_world, sizeof item->instance_to_world);
    air_import_object *object = air_import_add_object(mitsuba->import);
    if (object == NULL)
        return NULL;
    const char *id = air_xml_attribute_of(named, "id");
    object->name = id != NULL ? id : "";
    memcpy(object->to_world, identity, sizeof identity);
    object->node = SIZE_MAX;
    ++mitsuba->item_count;
    at->used = true;
    return object;
}

static air_status collect_sensor(air_mitsuba *mitsuba, air_xml *at)
{
    air_import_object *object = air_mitsuba_add_item(mitsuba, at, at, identity);
    if (object == NULL)
        return AIR_ERROR_MEMORY;
    object->camera = mitsuba->item_count - 1;
    if (mitsuba->sensor == NULL)
        mitsuba->sensor = at;
    return AIR_OK;
}

/* Area lights among the scene's children are there for shapes to refer to. */
static air_status collect_emitter(air_mitsuba *mitsuba, air_xml *at)
{
    if (air_mitsuba_is(at, "area") || air_mitsuba_is(at, "directionalarea"))
        return AIR_OK;
    air_import_object *object = air_mitsuba_add_item(mitsuba, at, at, identity);
    if (object == NULL)
        return AIR_ERROR_MEMORY;
    object->light = mitsuba->item_count - 1;
    return AIR_OK;
}

/* Methods, of which only those that show something else than light are worth a word. */
static air_status check_integrator(const air_mitsuba *mitsuba, air_xml *at)
{
    static const char *const known[] = {"path",   "volpath",   "volpathmis", "volpath_simple",
                                        "direct", "bdpt",      "ptracer",    "moment",
                                        "prb",    "prbvolpath"};
    at->used = true;
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
        if (air_mitsuba_is(at, known[i]))
            return AIR_OK;
    return air_mitsuba_warn(mitsuba, at,
                            "the integrator is not looked at: light is computed as "
                            "--method says");
}

static air_status collect(air_mitsuba *mitsuba, air_xml *at)
{
    static const char *const tags[] = {
        "shape",   "sensor",     "emitter", "bsdf",    "texture", "medium",   "phase",   "volume",
        "sampler", "integrator", "film",    "rfilter", "default", "alias",    "include", "path",
        "ref",     "string",     "float",   "integer", "boolean", "spectrum", "mode"};
    if (strcmp(at->tag, "shape") == 0)
        return air_mitsuba_collect_shape(mitsuba, at);
    if (strcmp(at->tag, "sensor") == 0)
        return collect_sensor(mitsuba, at);
    if (strcmp(at->tag, "emitter") == 0)
        return collect_emitter(mitsuba, at);
    if (strcmp(at->tag, "integrator") == 0)
        return check_integrator(mitsuba, at);
    for (size_t i = 0; i < sizeof tags / sizeof *tags; ++i)
        if (strcmp(at->tag, tags[i]) == 0)
            return AIR_OK;
    const char *nearest = air_nearest_name(at->tag, tags, sizeof tags / sizeof *tags);
    if (nearest != NULL && !mitsuba->import->params->lenient)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "unknown element, did you mean <%s>? (--lenient: it is left out)",
                                nearest);
    return air_mitsuba_replace(mitsuba, at, "unknown element", "it is left out");
}

/* References at the top, as version 3 allows: what they name stands somewhere itself. */
static air_status collect_all(air_mitsuba *mitsuba)
{
    air_status status = AIR_OK;
    for (air_xml *at = mitsuba->scene->child; at != NULL && status == AIR_OK; at = at->next)
        status = collect(mitsuba, at);
    return status;
}

/* ---- adding ---- */

static const char *name_of(const air_import_object *object, const air_xml *at)
{
    return object->name[0] != '\0' ? object->name : air_mitsuba_type(at);
}

static air_status add_objects(void *user)
{
    air_mitsuba *mitsuba = user;
    const air_import *import = mitsuba->import;
    air_status status = AIR_OK;
    for (size_t i = 0; i < import->object_count && status == AIR_OK; ++i) {
        const air_import_object *object = &import->objects[i];
        if (object->mesh != SIZE_MAX && !object->bounds_medium)
            status = air_mitsuba_add_shape(mitsuba, object);
        if (object->light != SIZE_MAX) {
            air_xml *at = mitsuba->items[object->light].at;
            status =
                air_mitsuba_add_emitter(mitsuba, at, name_of(object, at), object->casts_shadow);
        }
        if (object->camera != SIZE_MAX) {
            air_xml *at = mitsuba->items[object->camera].at;
            status = air_mitsuba_add_sensor(mitsuba, at, name_of(object, at));
        }
    }
    return status == AIR_OK ? air_mitsuba_add_regions(mitsuba) : status;
}

/* ---- what nobody looked at ---- */

/* Depth is bounded by AIR_XML_DEPTH. */
static air_status report_unused(const air_mitsuba *mitsuba, const air_xml *at)
{
    air_status status = AIR_OK;
    for (const air_xml *i = at->child; i != NULL && status == AIR_OK; i = i->next) {
        if (at->asked && !i->used)
            status = air_mitsuba_warn(mitsuba, i, "nothing is done with it");
        else
            status = report_unused(mitsuba, i);
    }
    return status;
}

/* ---- reading ---- */

static void mitsuba_finish(air_mitsuba *mitsuba)
{
    air_mitsuba_regions_finish(mitsuba);
    air_mitsuba_bytes_finish(mitsuba->context, &mitsuba->shapes);
    air_free(mitsuba->context, mitsuba->items);
    air_free(mitsuba->context, mitsuba->named);
    air_free(mitsuba->context, mitsuba->folder);
    json_decref(mitsuba->parameters);
    json_decref(mitsuba->wanted);
    json_decref(mitsuba->names);
    air_xml_finish(&mitsuba->document);
}

/* Mitsuba's numbers are radiometric; who says otherwise has given photometric ones. */
static air_status choose_units(air_mitsuba *mitsuba)
{
    const air_load_params *params = mitsuba->import->params;
    const bool light = params->light_units == AIR_UNITS_PHOTOMETRIC;
    const bool emission = params->emissive_units == AIR_UNITS_PHOTOMETRIC;
    mitsuba->light_scale = light ? 1.0f / 683.0f : 1.0f;
    mitsuba->emission_scale = emission ? 1.0f / 683.0f : 1.0f;
    return air_scene_set_source(mitsuba->import->scene, mitsuba->path,
                                light ? AIR_UNITS_PHOTOMETRIC : AIR_UNITS_RADIOMETRIC,
                                emission ? AIR_UNITS_PHOTOMETRIC : AIR_UNITS_RADIOMETRIC);
}

static air_status read_scene(air_mitsuba *mitsuba)
{
    mitsuba->folder = air_path_folder(mitsuba->context, mitsuba->path);
    if (mitsuba->folder == NULL)
        return AIR_ERROR_MEMORY;
    air_status status = air_mitsuba_expand(mitsuba);
    if (status == AIR_OK)
        status = choose_units(mitsuba);
    if (status == AIR_OK)
        status = collect_all(mitsuba);
    if (status == AIR_OK)
        status = air_import_fill(mitsuba->import, mitsuba->path);
    return status == AIR_OK ? report_unused(mitsuba, mitsuba->scene) : status;
}

air_status air_mitsuba_read(air_import *import, const char *path)
{
    air_mitsuba mitsuba = {.context = import->context,
                           .import = import,
                           .path = path,
                           .document = {.context = import->context}};
    import->append_geometry = air_mitsuba_append_geometry;
    import->add_objects = add_objects;
    import->user = &mitsuba;
    const air_status status = read_scene(&mitsuba);
    mitsuba_finish(&mitsuba);
    return status;
}

/* export_camera.c: cameras as nodes. */
#include "scene/export/export.h"

/* glTF cannot do without clipping planes; airlight has no far one, and need not have a near one. */
static const double z_near = 0.01, z_range = 10000.0;

static void put_lens(air_export *self, const air_camera_desc *desc, json_t *camera)
{
    const bool perspective = desc->kind == AIR_CAMERA_PERSPECTIVE;
    const char *type = perspective ? "perspective" : "orthographic";
    const double near = desc->near_distance > 0.0f ? (double)desc->near_distance : z_near;
    json_t *lens = air_export_object(self, camera, type);
    air_export_put(self, camera, "type", json_string(type));
    air_export_put(self, lens, "znear", json_real(near));
    if (perspective) {
        air_export_put(self, lens, "yfov", json_real((double)desc->fov_y_rad));
        air_export_put(self, lens, "aspectRatio", json_real((double)desc->aspect));
    } else {
        air_export_put(self, lens, "zfar", json_real(near + z_range));
        air_export_put(self, lens, "xmag",
                       json_real((double)desc->half_height * (double)desc->aspect));
        air_export_put(self, lens, "ymag", json_real((double)desc->half_height));
    }
}

static void put_film(air_export *self, const air_film_hint *film, json_t *object)
{
    json_t *entry = air_export_object(self, object, "film");
    air_export_put(self, entry, "width", json_integer((json_int_t)film->width));
    air_export_put(self, entry, "height", json_integer((json_int_t)film->height));
    json_t *crop = air_export_list(self, entry, "crop");
    for (size_t i = 0; i < 4; ++i)
        air_export_push(self, crop, json_integer((json_int_t)film->crop[i]));
    air_export_put(self, entry, "samples", json_integer(film->samples));
    air_export_put(self, entry, "filter", json_string(air_filter_names[film->filter]));
    air_export_put(self, entry, "filter_radius", json_real((double)film->filter_radius));
}

/* What glTF's cameras lack. */
static void put_rest(air_export *self, const air_camera_desc *desc, json_t *node)
{
    if (desc->lens_radius > 0.0f) {
        json_t *object = air_export_node_object(self, node);
        air_export_put(self, object, "lens_radius", json_real((double)desc->lens_radius));
        air_export_put(self, object, "focus_distance", json_real((double)desc->focus_distance));
    }
    if (desc->mirrored)
        air_export_put(self, air_export_node_object(self, node), "mirrored", json_true());
    if (desc->near_distance > 0.0f)
        air_export_put(self, air_export_node_object(self, node), "near_distance",
                       json_real((double)desc->near_distance));
    if (desc->film.known)
        put_film(self, &desc->film, air_export_node_object(self, node));
}

void air_export_cameras(air_export *self)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_CAMERA];
    for (size_t i = 0; i < list->count; ++i) {
        const air_camera_desc *desc = &((const air_camera_record *)list->slots[i].record)->desc;
        json_t *camera = json_object(), *node = json_object();
        put_lens(self, desc, camera);
        air_export_name(self, node, desc->name);
        air_export_matrix(self, node, desc->to_world);
        put_rest(self, desc, node);
        air_export_put(self, node, "camera",
                       json_integer((json_int_t)air_export_append(self, "cameras", camera)));
        air_export_node(self, node);
    }
}

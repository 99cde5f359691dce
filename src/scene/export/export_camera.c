/* export_camera.c: cameras as nodes. */
#include "scene/export/export.h"

/* glTF cannot do without clipping planes, airlight has none. */
static const double z_near = 0.01, z_far = 10000.0;

static void put_lens(air_export *self, const air_camera_desc *desc, json_t *camera)
{
    const bool perspective = desc->kind == AIR_CAMERA_PERSPECTIVE;
    const char *type = perspective ? "perspective" : "orthographic";
    json_t *lens = air_export_object(self, camera, type);
    air_export_put(self, camera, "type", json_string(type));
    air_export_put(self, lens, "znear", json_real(z_near));
    if (perspective) {
        air_export_put(self, lens, "yfov", json_real((double)desc->fov_y_rad));
        air_export_put(self, lens, "aspectRatio", json_real((double)desc->aspect));
    } else {
        air_export_put(self, lens, "zfar", json_real(z_far));
        air_export_put(self, lens, "xmag",
                       json_real((double)desc->half_height * (double)desc->aspect));
        air_export_put(self, lens, "ymag", json_real((double)desc->half_height));
    }
}

static void warn_of_rest(const air_export *self, const air_camera_desc *desc)
{
    if (desc->lens_radius > 0.0f)
        air_warn(self->context, "%s: camera \"%s\": its thin lens became a pinhole", self->path,
                 desc->name);
    if (desc->film.known)
        air_warn(self->context,
                 "%s: camera \"%s\": its picture of %zu x %zu pixels is left out but for the "
                 "aspect",
                 self->path, desc->name, desc->film.width, desc->film.height);
}

void air_export_cameras(air_export *self)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_CAMERA];
    for (size_t i = 0; i < list->count; ++i) {
        const air_camera_desc *desc = &((const air_camera_record *)list->slots[i].record)->desc;
        json_t *camera = json_object(), *node = json_object();
        warn_of_rest(self, desc);
        put_lens(self, desc, camera);
        air_export_name(self, node, desc->name);
        air_export_matrix(self, node, desc->to_world);
        air_export_put(self, node, "camera",
                       json_integer((json_int_t)air_export_append(self, "cameras", camera)));
        air_export_node(self, node);
    }
}

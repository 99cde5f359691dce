/* camera.h: cameras: checking, framing, and the rays they send. */
#ifndef AIR_SCENE_CAMERA_H
#define AIR_SCENE_CAMERA_H

#include "core/warp.h"
#include "scene/record.h"
#include "scene/snapshot.h"

typedef struct air_camera_record {
    air_record base;
    air_camera_desc
        desc; /* name is the record's; to_world is orthonormal, and right-handed unless mirrored */
} air_camera_record;

/* What files call pixel filters, in the order of air_filter. */
enum { AIR_FILTERS = AIR_FILTER_MITCHELL + 1 };
extern const char *const air_filter_names[AIR_FILTERS];

/* Checks and copies a description. */
air_status air_camera_record_create(air_context *context, const air_camera_desc *desc,
                                    air_record **out_record);

/* Are two descriptions the same but for the name, as far as their kind looks? */
bool air_camera_equal(const air_camera_desc *a, const air_camera_desc *b);

/* A camera that sees all of the bounds from the front (+Z), a little from the right and above, as
 * model viewers do; bounds_min > bounds_max: as if they were [-1, 1]^3. */
void air_camera_frame(const float bounds_min[3], const float bounds_max[3],
                      air_camera_desc *out_desc);

/* A camera prepared for a picture size: the ray through (x, y) is affine in both before
 * normalisation. */
typedef struct air_camera_view {
    air_camera_kind kind;
    air_vec3 origin; /* of all rays (perspective), or of the ray through (0, 0) */
    air_vec3 dir;    /* of the ray through (0, 0), not unit (perspective), or of all rays, unit */
    air_vec3 step_x,
        step_y; /* what one pixel to the right and one down add to dir (perspective) or origin */
    float lens_radius, focus_distance; /* of a thin lens about the origin; 0: a pinhole */
    float near_distance;               /* along the axis; 0: rays begin at the eye */
    air_vec3 right, up, axis;          /* unit: across the view, and along it */
} air_camera_view;

/* The vertical field of view (or height) fills the picture's height; pixels are square. */
void air_camera_view_init(const air_camera *camera, size_t width, size_t height,
                          air_camera_view *out_view);

/* Moves a ray's begin to where things are first seen. */
static inline void air_camera_view_begin(const air_camera_view *view, air_vec3 *origin,
                                         air_vec3 dir)
{
    if (view->near_distance > 0.0f) {
        *origin = vec3_madd(*origin, view->near_distance / vec3_dot(view->axis, dir), dir);
    }
}

/* The ray of a pinhole through (x, y), from the eye. */
static inline void air_camera_view_eye_ray(const air_camera_view *view, float x, float y,
                                           air_vec3 *out_origin, air_vec3 *out_dir)
{
    const air_vec3 step = vec3_madd(vec3_scale(view->step_x, x), y, view->step_y);
    if (view->kind == AIR_CAMERA_PERSPECTIVE) {
        *out_origin = view->origin;
        *out_dir = vec3_normalize(vec3_add(view->dir, step));
    } else {
        *out_origin = vec3_add(view->origin, step);
        *out_dir = view->dir;
    }
}

/* The ray through (x, y), pixels from the top left corner, continuous; *out_dir is unit. */
static inline void air_camera_view_ray(const air_camera_view *view, float x, float y,
                                       air_vec3 *out_origin, air_vec3 *out_dir)
{
    air_camera_view_eye_ray(view, x, y, out_origin, out_dir);
    air_camera_view_begin(view, out_origin, *out_dir);
}

/* The same through the place (u1, u2) of the lens, [0, 1) each: rays of all places meet where the
 * plane of focus is. */
static inline void air_camera_view_lens_ray(const air_camera_view *view, float x, float y, float u1,
                                            float u2, air_vec3 *out_origin, air_vec3 *out_dir)
{
    air_camera_view_eye_ray(view, x, y, out_origin, out_dir);
    if (view->lens_radius > 0.0f) {
        const float way = view->focus_distance / vec3_dot(view->axis, *out_dir);
        const air_vec3 disk = vec3_scale(sample_disk_concentric(u1, u2), view->lens_radius);
        const air_vec3 shift = vec3_madd(vec3_scale(view->right, disk.x), disk.y, view->up);
        *out_origin = vec3_add(*out_origin, shift);
        *out_dir = vec3_normalize(vec3_sub(vec3_scale(*out_dir, way), shift));
    }
    air_camera_view_begin(view, out_origin, *out_dir);
}

/* The same for a single ray through the lens's middle. */
static inline void air_camera_ray(const air_camera *camera, size_t width, size_t height, float x,
                                  float y, air_vec3 *out_origin, air_vec3 *out_dir)
{
    air_camera_view view;
    air_camera_view_init(camera, width, height, &view);
    air_camera_view_ray(&view, x, y, out_origin, out_dir);
}

#endif

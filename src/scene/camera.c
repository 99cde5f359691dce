#include "scene/camera.h"

#include <string.h>

#include "scene/subject.h"

#define DEFAULT_FOV_Y_RAD (40.0f * AIR_PI_F / 180.0f)
#define DEFAULT_ASPECT    (4.0f / 3.0f)

void air_camera_desc_default(air_camera_desc *desc)
{
    *desc = (air_camera_desc){.kind = AIR_CAMERA_PERSPECTIVE,
                              .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                              .fov_y_rad = DEFAULT_FOV_Y_RAD,
                              .half_height = 1.0f,
                              .focus_distance = 1.0f,
                              .aspect = DEFAULT_ASPECT};
}

const char *const air_filter_names[AIR_FILTERS] = {"box", "point", "tent", "gaussian", "mitchell"};

float air_filter_radius_default(air_filter filter)
{
    switch (filter) {
    case AIR_FILTER_MITCHELL:
        return 2.0f;
    case AIR_FILTER_GAUSSIAN:
        return 1.5f;
    case AIR_FILTER_TENT:
        return 1.0f;
    case AIR_FILTER_BOX:
    case AIR_FILTER_POINT:
        break;
    }
    return 0.5f;
}

/* ---- records ---- */

static air_vec3 map_column(const float map[12], size_t column)
{
    return vec3(map[column], map[4 + column], map[8 + column]);
}

static void set_map_columns(float map[12], const air_vec3 columns[4])
{
    for (size_t i = 0; i < 4; ++i) {
        map[i] = columns[i].x;
        map[4 + i] = columns[i].y;
        map[8 + i] = columns[i].z;
    }
}

/* Are the axes perpendicular and of length 1, but for the rounding of floats? */
static bool is_orthonormal(const float map[12])
{
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j <= i; ++j) {
            double product = 0.0;
            for (size_t row = 0; row < 3; ++row)
                product += (double)map[4 * row + i] * (double)map[4 * row + j];
            if (!(fabs(product - (i == j ? 1.0 : 0.0)) < 5e-7))
                return false;
        }
    }
    return true;
}

/* Keeps the viewing direction and the side that is up; drops scale, shear and mirroring but for
 * what is asked for. False if these directions are missing or parallel. A map that has none of
 * these stays as it is, so that a camera that is told on does not move. */
static bool orthonormalize(float map[12], bool mirrored)
{
    if (is_orthonormal(map)) {
        if ((affine_determinant(map) < 0.0) != mirrored)
            for (size_t row = 0; row < 3; ++row)
                map[4 * row] = -map[4 * row];
        return true;
    }
    const air_vec3 back = map_column(map, 2), up = map_column(map, 1);
    const air_vec3 z =
        vec3_scale(back, 1.0f / vec3_max(vec3(fabsf(back.x), fabsf(back.y), fabsf(back.z))));
    const air_vec3 y = vec3_scale(up, 1.0f / vec3_max(vec3(fabsf(up.x), fabsf(up.y), fabsf(up.z))));
    const air_vec3 unit_z = vec3_normalize(z);
    const air_vec3 across = vec3_cross(y, unit_z);
    /* 1e-5: below this, rounding of the directions decides about the picture's horizon */
    if (!(vec3_length(across) > 1e-5f))
        return false;
    const air_vec3 unit_x = vec3_normalize(across);
    const air_vec3 columns[4] = {mirrored ? vec3_neg(unit_x) : unit_x, vec3_cross(unit_z, unit_x),
                                 unit_z, map_column(map, 3)};
    set_map_columns(map, columns);
    return true;
}

static air_status check_size(const air_subject *subject, const air_camera_desc *desc)
{
    const bool perspective = desc->kind == AIR_CAMERA_PERSPECTIVE;
    const float size = perspective ? desc->fov_y_rad : desc->half_height;
    const float limit = perspective ? AIR_PI_F : INFINITY;
    if (!(size > 0.0f && size < limit))
        return air_subject_fail(subject, "%s is %g, but must be above 0 and %s",
                                perspective ? "fov_y_rad" : "half_height", (double)size,
                                perspective ? "below pi" : "finite");
    if (!(desc->aspect > 0.0f && isfinite(desc->aspect)))
        return air_subject_fail(subject, "aspect is %g, but must be above 0 and finite",
                                (double)desc->aspect);
    return AIR_OK;
}

static air_status check_lens(const air_subject *subject, const air_camera_desc *desc)
{
    if (!(desc->lens_radius >= 0.0f && isfinite(desc->lens_radius)))
        return air_subject_fail(subject, "lens_radius is %g, but must be at least 0 and finite",
                                (double)desc->lens_radius);
    if (!(desc->focus_distance > 0.0f && isfinite(desc->focus_distance)))
        return air_subject_fail(subject, "focus_distance is %g, but must be above 0 and finite",
                                (double)desc->focus_distance);
    if (!(desc->near_distance >= 0.0f && isfinite(desc->near_distance)))
        return air_subject_fail(subject, "near_distance is %g, but must be at least 0 and finite",
                                (double)desc->near_distance);
    return AIR_OK;
}

static air_status check_film(const air_subject *subject, const air_film_hint *film)
{
    const size_t *crop = film->crop;
    if (!film->known)
        return AIR_OK;
    if (film->width < 1 || film->height < 1 || film->width > 65535 || film->height > 65535)
        return air_subject_fail(subject, "film is %zu x %zu, but each must be 1 to 65535",
                                film->width, film->height);
    if (!(crop[0] < crop[2] && crop[2] <= film->width && crop[1] < crop[3] &&
          crop[3] <= film->height))
        return air_subject_fail(subject,
                                "film.crop is %zu,%zu to %zu,%zu, but must be a part of %zu x %zu",
                                crop[0], crop[1], crop[2], crop[3], film->width, film->height);
    if (film->samples < 1)
        return air_subject_fail(subject, "film.samples is 0, but must be at least 1");
    const air_status status =
        air_subject_check_enum(subject, "film.filter", (int)film->filter, AIR_FILTERS);
    if (status == AIR_OK && !(film->filter_radius > 0.0f && isfinite(film->filter_radius)))
        return air_subject_fail(subject, "film.filter_radius is %g, but must be above 0 and finite",
                                (double)film->filter_radius);
    return status;
}

air_status air_camera_record_create(air_context *context, const air_camera_desc *desc,
                                    air_record **out_record)
{
    const air_subject subject = {context, "camera", desc->name};
    float to_world[12];
    memcpy(to_world, desc->to_world, sizeof to_world);
    air_status status = air_subject_check_enum(&subject, "kind", (int)desc->kind, 2);
    if (status == AIR_OK)
        status = air_subject_check(&subject, "to_world", to_world, 12, -INFINITY, INFINITY);
    if (status == AIR_OK)
        status = check_size(&subject, desc);
    if (status == AIR_OK)
        status = check_lens(&subject, desc);
    if (status == AIR_OK)
        status = check_film(&subject, &desc->film);
    if (status != AIR_OK)
        return status;
    if (!orthonormalize(to_world, desc->mirrored))
        return air_subject_fail(&subject,
                                "to_world has no viewing direction, or it is parallel to up");
    air_camera_record *record =
        air_record_create(context, sizeof *record, air_record_own_nothing, desc->name);
    if (record == NULL)
        return AIR_ERROR_MEMORY;
    record->desc = *desc;
    record->desc.name = record->base.name;
    memcpy(record->desc.to_world, to_world, sizeof to_world);
    *out_record = &record->base;
    return AIR_OK;
}

static bool lens_equal(const air_camera_desc *a, const air_camera_desc *b)
{
    return a->lens_radius == b->lens_radius &&
           (a->lens_radius == 0.0f || a->focus_distance == b->focus_distance);
}

static bool film_equal(const air_film_hint *a, const air_film_hint *b)
{
    if (!a->known || !b->known)
        return a->known == b->known;
    return a->width == b->width && a->height == b->height &&
           air_bytes_equal(a->crop, b->crop, sizeof a->crop) && a->samples == b->samples &&
           a->filter == b->filter && a->filter_radius == b->filter_radius;
}

bool air_camera_equal(const air_camera_desc *a, const air_camera_desc *b)
{
    const bool size_equal = a->kind == AIR_CAMERA_PERSPECTIVE
                                ? a->fov_y_rad == b->fov_y_rad && lens_equal(a, b)
                                : a->half_height == b->half_height;
    return a->kind == b->kind && size_equal && a->mirrored == b->mirrored &&
           a->near_distance == b->near_distance && a->aspect == b->aspect &&
           film_equal(&a->film, &b->film) &&
           air_bytes_equal(a->to_world, b->to_world, sizeof a->to_world);
}

/* ---- framing ---- */

void air_camera_frame(const float bounds_min[3], const float bounds_max[3],
                      air_camera_desc *out_desc)
{
    air_vec3 low = vec3_load(bounds_min), high = vec3_load(bounds_max);
    if (!(low.x <= high.x && low.y <= high.y && low.z <= high.z)) {
        low = vec3_set1(-1.0f);
        high = vec3_set1(1.0f);
    }
    const air_vec3 center = vec3_madd(vec3_scale(low, 0.5f), 0.5f, high);
    const air_vec3 half = vec3_madd(vec3_scale(high, 0.5f), -0.5f, low);

    /* three quarters front view: 30 degrees to the right of +Z, 20 degrees up */
    const float azimuth = AIR_PI_F / 6.0f, elevation = AIR_PI_F / 9.0f;
    const air_vec3 z =
        vec3(sinf(azimuth) * cosf(elevation), sinf(elevation), cosf(azimuth) * cosf(elevation));
    const air_vec3 x = vec3_normalize(vec3_cross(vec3(0.0f, 1.0f, 0.0f), z));
    const air_vec3 y = vec3_cross(z, x);

    air_camera_desc_default(out_desc);
    out_desc->name = "framed";
    /* The nearest distance from which every corner c is within 95 % of the picture: |c.y| <= margin
     * tan(fov/2) (distance - c.z), likewise for x. */
    const float slope_y = 0.95f * tanf(0.5f * out_desc->fov_y_rad),
                slope_x = slope_y * out_desc->aspect;
    float distance = 0.0f;
    for (unsigned i = 0; i < 8; ++i) {
        const air_vec3 corner =
            vec3(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z);
        const float reach =
            fmaxf(fabsf(vec3_dot(corner, x)) / slope_x, fabsf(vec3_dot(corner, y)) / slope_y);
        distance = fmaxf(distance, vec3_dot(corner, z) + reach);
    }
    if (!(distance > 0.0f))
        distance = 1.0f; /* a single point */
    const air_vec3 columns[4] = {x, y, z, vec3_madd(center, distance, z)};
    set_map_columns(out_desc->to_world, columns);
}

/* ---- rays ---- */

void air_camera_view_init(const air_camera *camera, size_t width, size_t height,
                          air_camera_view *out_view)
{
    const float *map = camera->to_world;
    const air_vec3 right = map_column(map, 0), up = map_column(map, 1), back = map_column(map, 2);
    const bool perspective = camera->kind == AIR_CAMERA_PERSPECTIVE;
    /* half of what is seen vertically, at distance 1 (perspective) or anywhere (orthographic) */
    const float half_y = perspective ? tanf(0.5f * camera->fov_y_rad) : camera->half_height;
    const float half_x = half_y * (float)width / (float)height;
    const air_vec3 corner = vec3_madd(vec3_scale(right, -half_x), half_y, up);
    const float pixel = 2.0f * half_y / (float)height;
    out_view->kind = camera->kind;
    out_view->origin = perspective ? map_column(map, 3) : vec3_add(map_column(map, 3), corner);
    out_view->dir = perspective ? vec3_sub(corner, back) : vec3_neg(back);
    out_view->step_x = vec3_scale(right, pixel);
    out_view->step_y = vec3_scale(up, -pixel);
    out_view->lens_radius = perspective ? camera->lens_radius : 0.0f;
    out_view->focus_distance = camera->focus_distance;
    out_view->near_distance = camera->near_distance;
    out_view->right = right;
    out_view->up = up;
    out_view->axis = vec3_neg(back);
}

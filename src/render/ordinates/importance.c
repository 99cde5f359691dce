/* importance.c: see importance.h. */
#include "render/ordinates/importance.h"

#include <math.h>
#include <string.h>

#include "airlight/ordinates_lights.h"

/* The pyramid is wider than the picture, for light comes in from beside it. */
#define WIDER 1.15f

/* Of 1 in the map. */
#define FLOOR 0.1f

typedef struct pyramid {
    float points[3 * AIR_IMPORTANCE_CELLS_ALL];
    float sigma_s[AIR_IMPORTANCE_CELLS_ALL], sigma_a[AIR_IMPORTANCE_CELLS_ALL];
    float g[AIR_IMPORTANCE_CELLS_ALL];
    float map[AIR_IMPORTANCE_TEXELS];
} pyramid;

/* Depths of the domain; false: it is behind the camera. */
static bool find_depths(const ord_domain *domain, air_vec3 from, air_vec3 forward, float *near,
                        float *far)
{
    *near = HUGE_VALF;
    *far = -HUGE_VALF;
    for (int corner = 0; corner < 8; corner++) {
        const float x = (corner & 1) != 0 ? (float)(ptrdiff_t)domain->size[0] : 0.0f;
        const float y = (corner & 2) != 0 ? (float)(ptrdiff_t)domain->size[1] : 0.0f;
        const float z = (corner & 4) != 0 ? (float)(ptrdiff_t)domain->size[2] : 0.0f;
        const air_vec3 at = ord_domain_world(domain, vec3_scale(vec3(x, y, z), domain->cell_m));
        const float depth = vec3_dot(vec3_sub(at, from), forward);
        *near = float_min(*near, depth);
        *far = float_max(*far, depth);
    }
    *near = float_max(*near, 0.0f);
    return *far > *near && *far > 0.0f;
}

static bool find_camera(const ord_domain *domain, const air_camera_view *view, size_t width,
                        size_t height, air_importance_camera *out)
{
    const float half_x = 0.5f * (float)(ptrdiff_t)width, half_y = 0.5f * (float)(ptrdiff_t)height;
    if (view->kind != AIR_CAMERA_PERSPECTIVE) {
        return false;
    }
    const air_vec3 middle =
        vec3_madd(vec3_madd(view->dir, half_x, view->step_x), half_y, view->step_y);
    const float length = vec3_length(middle);
    const air_vec3 forward = vec3_normalize(middle);
    vec3_store(out->position, view->origin);
    vec3_store(out->right, vec3_normalize(view->step_x));
    vec3_store(out->up, vec3_normalize(vec3_neg(view->step_y)));
    vec3_store(out->forward, forward);
    out->tan_half[0] = float_min(WIDER * half_x * vec3_length(view->step_x) / length, 100.0f);
    out->tan_half[1] = float_min(WIDER * half_y * vec3_length(view->step_y) / length, 100.0f);
    return find_depths(domain, view->origin, forward, &out->near_m, &out->far_m);
}

/* Means over channels of the cell at each point. */
static void take_coefficients(const ord_domain *d, pyramid *self)
{
    for (size_t i = 0; i < AIR_IMPORTANCE_CELLS_ALL; i++) {
        const air_vec3 local = ord_domain_local(d, vec3_load(self->points + 3 * i));
        const float at[3] = {local.x / d->cell_m, local.y / d->cell_m, local.z / d->cell_m};
        bool within = true;
        for (int axis = 0; axis < 3; axis++) {
            within = within && at[axis] >= 0.0f && at[axis] < (float)(ptrdiff_t)d->size[axis];
        }
        if (!within) {
            continue;
        }
        const size_t cell =
            ((size_t)at[2] * d->size[1] + (size_t)at[1]) * d->size[0] + (size_t)at[0];
        for (size_t c = 0; c < 3; c++) {
            self->sigma_s[i] += d->sigma_s[c * d->cells + cell] * (1.0f / 3.0f);
            self->sigma_a[i] += d->sigma_a[c * d->cells + cell] * (1.0f / 3.0f);
            self->g[i] += d->g[c * d->cells + cell] * (1.0f / 3.0f);
        }
    }
}

air_status ord_importance_make(const ord_domain *domain, const air_camera_view *view, size_t width,
                               size_t height, ord_past *past, float *out, bool *out_made)
{
    air_context *const context = domain->context;
    air_importance_camera camera;
    *out_made = false;
    if (!find_camera(domain, view, width, height, &camera)) {
        return AIR_OK;
    }
    pyramid *const self = air_allocate(context, 1, sizeof *self);
    void *const scratch = air_allocate(context, air_importance_scratch() + AIR_ALIGNMENT, 1);
    air_status status = AIR_OK;
    if (self == NULL || scratch == NULL) {
        status = air_fail_memory(context, "ordinates: importance");
    } else {
        const air_importance_medium medium = {self->sigma_s, self->sigma_a, self->g};
        status = air_importance_points(context, &camera, self->points);
        if (status == AIR_OK) {
            take_coefficients(domain, self);
            status = air_importance_propagate(context, &camera, &medium, air_align(scratch),
                                              self->map, NULL);
        }
    }
    if (status == AIR_OK) {
        air_importance_smooth(self->map, FLOOR, self->map);
        ord_past_mix_importance(past, self->map);
        memcpy(out, self->map, sizeof self->map);
        *out_made = true;
    }
    air_free(context, scratch);
    air_free(context, self);
    return status;
}

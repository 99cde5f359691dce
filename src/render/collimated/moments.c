#include "render/collimated/moments.h"

#include <float.h>
#include <string.h>

#include "core/host.h"

/* 256 rows of 128 columns reach what shared weights allow (src/collimated/README.md); real scenes
 * have finer occluders than a ball. */
enum { ROWS = 1024, COLUMNS = 512, PACKET = 16 };

typedef struct height_job {
    const air_with_collimated *with;
    const air_moment_params *params;
    double start; /* height above the camera, above everything */
    float *heights;
} height_job;

/* One row of the map, by rays from above. */
static void find_heights(void *user, size_t row, size_t worker)
{
    const height_job *job = user;
    const air_snapshot *snapshot = job->with->snapshot;
    const air_moment_params *p = job->params;
    air_ray rays[PACKET];
    air_hit hits[PACKET];
    (void)worker;
    for (size_t column = 0; column < p->column_count; column += PACKET) {
        for (size_t k = 0; k < PACKET; k++) {
            double origin[3];
            air_moment_ray_origin(p, row, column + k, job->start, origin);
            rays[k] = (air_ray){.tmax = FLT_MAX, .mask = AIR_MASK_SHADOW_OPAQUE};
            for (int c = 0; c < 3; c++) {
                rays[k].origin[c] = (float)origin[c];
                rays[k].dir[c] = (float)-p->to_light[c];
            }
        }
        job->with->path->rays->intersect(snapshot->accelerator, rays, PACKET, hits);
        for (size_t k = 0; k < PACKET; k++) {
            job->heights[row * p->column_count + column + k] =
                hits[k].mesh == (uint32_t)AIR_NO_HIT ? -INFINITY
                                                     : (float)(job->start - (double)hits[k].t);
        }
    }
}

/* Above all meshes, as seen from the light. */
static double start_height(const air_snapshot *snapshot, const air_moment_params *p)
{
    double highest = 0.0, size = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double height = 0.0;
        for (int k = 0; k < 3; k++) {
            const float *end = (corner >> k & 1) != 0 ? snapshot->bounds_max : snapshot->bounds_min;
            height += p->to_light[k] * ((double)end[k] - p->origin[k]);
            size = fmax(size, fabs((double)end[k] - p->origin[k]));
        }
        highest = fmax(highest, height);
    }
    return highest + 1e-3 * size;
}

static void fit(const air_with_collimated *with, const collimated_lamp *lamp, air_moment_params *p)
{
    double corners[8][3];
    for (int corner = 0; corner < 8; corner++) {
        for (int k = 0; k < 3; k++) {
            corners[corner][k] =
                (corner >> k & 1) != 0 ? lamp->shadows.high[k] : lamp->shadows.low[k];
        }
    }
    p->row_count = ROWS;
    p->column_count = COLUMNS;
    p->sigma_t = with->cells[0].sigma_t;
    air_moment_params_fit((const double(*)[3])corners, 8, p);
}

air_status air_collimated_moments_make(const air_with_collimated *with, collimated_lamp *lamp,
                                       const air_camera_view *view)
{
    air_context *context = with->context;
    air_moment_params params;
    const bool six =
        lamp->mode == AIR_COLLIMATED_MODE_ME6 || lamp->mode == AIR_COLLIMATED_MODE_ME6_IDEAL;
    if (lamp->shadows.tree == NULL) {
        return AIR_OK;
    }
    if (view->lens_radius > 0.0f) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "collimated: moments follow rays from one point, but the camera's lens has "
                        "a radius of %g m: expected another mode than me or me6",
                        (double)view->lens_radius);
    }
    air_moment_params_default(six ? 6 : 4, &params);
    vec3_store64(params.origin, view->origin);
    memcpy(lamp->eye, params.origin, sizeof lamp->eye);
    memcpy(params.to_light, lamp->to_light, sizeof params.to_light);
    fit(with, lamp, &params);
    height_job job = {with, &params, start_height(with->snapshot, &params), NULL};
    job.heights = air_allocate(context, (size_t)ROWS * COLUMNS, sizeof *job.heights);
    if (job.heights == NULL) {
        return air_fail_memory(context, "collimated: map of heights");
    }
    air_parallel_for(context, ROWS, find_heights, &job);
    const air_status status = air_moment_map_create(context, &params, job.heights, &lamp->moments);
    air_free(context, job.heights);
    return status;
}

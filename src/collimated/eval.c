/* eval.c: many rays through one medium: the plain version, and the choice of another. */
#include "collimated/eval.h"

#include "collimated/planes.h"

void air_eval_rays_c(const air_collimated_medium *medium, const double to_light[3], double sigma_t,
                     const air_collimated_rays *rays, size_t count, double *out_t, double *out_log)
{
    air_collimated_piece pieces[AIR_COLLIMATED_MAX_PIECES];
    air_collimated_profile profile = {.pieces = pieces, .capacity = AIR_COLLIMATED_MAX_PIECES};
    for (size_t i = 0; i < count; i++) {
        const double origin[3] = {rays->origin[0][i], rays->origin[1][i], rays->origin[2][i]};
        const double dir[3] = {rays->dir[0][i], rays->dir[1][i], rays->dir[2][i]};
        const double t_max = rays->t_max != NULL ? rays->t_max[i] : INFINITY;
        air_collimated_profile_make(medium, to_light, sigma_t, origin, dir, t_max, &profile);
        out_t[i] = air_collimated_integral(&profile);
        if (out_log != NULL) {
            out_log[i] = air_collimated_log_integral(&profile);
        }
    }
}

static air_eval_rays *rays_version(air_cpu cpu)
{
#if defined(__x86_64__)
    switch (cpu) {
    case AIR_CPU_AVX512:
        return air_eval_rays_avx512;
    case AIR_CPU_AVX2:
        return air_eval_rays_avx2;
    case AIR_CPU_SSE42:
        return air_eval_rays_sse42;
    default:
        return NULL;
    }
#else
    (void)cpu;
    return NULL;
#endif
}

static bool opposite(const double a[4], const double b[4])
{
    return a[0] == -b[0] && a[1] == -b[1] && a[2] == -b[2];
}

/* The slab of plane k and its first opposite that is not taken. */
static air_eval_slab take_slab(const air_collimated_medium *medium, size_t k, bool *taken)
{
    const double *n = medium->planes[k];
    air_eval_slab slab = {{n[0], n[1], n[2]}, n[3], INFINITY, 0.0};
    taken[k] = true;
    for (size_t j = 0; j < medium->plane_count; j++) {
        if (!taken[j] && opposite(n, medium->planes[j])) {
            taken[j] = true;
            slab.back = medium->planes[j][3];
            break;
        }
    }
    return slab;
}

/* False if two opposite planes leave nothing between them. */
static bool batch_make(const air_collimated_medium *medium, const double to_light[3],
                       double sigma_t, air_eval_batch *out)
{
    bool taken[AIR_COLLIMATED_MAX_PLANES] = {false};
    out->sigma_t = sigma_t;
    out->count = out->facing = 0;
    for (int others = 0; others < 2; others++) {
        for (size_t k = 0; k < medium->plane_count; k++) {
            const double nl = air_plane_facing(medium->planes[k], to_light);
            if (!taken[k] && (others == 1 || nl > 0.0)) {
                air_eval_slab slab = take_slab(medium, k, taken);
                slab.inverse = nl > 0.0 ? 1.0 / nl : 0.0;
                out->slabs[out->count++] = slab;
                if (slab.front < -slab.back) {
                    return false;
                }
            }
        }
        while (others == 0 && out->count > 0 && out->count < AIR_EVAL_BOX_LINES) {
            out->slabs[out->count++] = out->slabs[0];
        }
        out->facing = others == 0 ? out->count : out->facing;
    }
    return true;
}

static void fill_empty(size_t count, double *out_t, double *out_log)
{
    for (size_t i = 0; i < count; i++) {
        out_t[i] = 0.0;
        if (out_log != NULL) {
            out_log[i] = -INFINITY;
        }
    }
}

void air_collimated_eval(const air_context *context, const air_collimated_medium *medium,
                         const double to_light[3], double sigma_t, const air_collimated_rays *rays,
                         size_t count, double *out_t, double *out_log)
{
    air_eval_rays *const version = rays_version(air_context_cpu(context));
    air_eval_batch batch;
    if (version == NULL || sigma_t == 0.0) {
        air_eval_rays_c(medium, to_light, sigma_t, rays, count, out_t, out_log);
    } else if (!(sigma_t > 0.0 && sigma_t < INFINITY) || !air_finite3(to_light) ||
               !batch_make(medium, to_light, sigma_t, &batch) || batch.facing == 0) {
        fill_empty(count, out_t, out_log);
    } else {
        version(&batch, rays, count, out_t, out_log);
    }
}

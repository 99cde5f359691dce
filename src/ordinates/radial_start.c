/* radial_start.c: the beam, what it leaves in the cells, and what a pass adds to the results. */
#include "ordinates/radial.h"
#include "ordinates/radial_shares.h"

/* Lobes sharper than this are evaluated as if they were this wide. */
static double blunt(double a, double most) { return double_max(-most, double_min(most, a)); }

static void count_bins(size_t bins, double a, double fluence, float *binned)
{
    const double lobe = blunt(a, 1.0 - 1e-3);
    double below = 0.0;
    for (size_t b = 0; b < bins; b++) {
        const double edge = -1.0 + 2.0 * (double)(b + 1) / (double)bins;
        const double next = b + 1 < bins ? radial_lobe_below(lobe, edge) : 1.0;
        binned[b] += (float)(fluence * (next - below));
        below = next;
    }
}

void radial_count(radial_run *run, uint32_t k, const double *paths, double weight)
{
    const air_radial_results *const results = run->results;
    const air_radial_grid *const grid = &run->cells->grid;
    const size_t count = run->mesh.count, at = k * count;
    const double depth = air_radial_radius(grid, k + 1) - air_radial_radius(grid, k);
    const double scale = weight * depth;
    const double *restrict const e = run->energy + at, *restrict const a = run->mean + at;
    double *restrict const sum = run->path + at;
    for (size_t i = 0; i < count; i++) {
        sum[i] += scale * paths[i] * e[i];
    }
    if (results->seen != NULL) {
        const float *const view = results->view_cosine + at, *const g = run->cells->g + at;
        double *restrict const seen = run->seen + at;
        for (size_t i = 0; i < count; i++) {
            seen[i] += scale * paths[i] * e[i] *
                       radial_lobe(blunt(a[i] * (double)g[i], 0.995), (double)view[i]);
        }
    }
    if (results->binned != NULL && weight > 0.0) {
        const double volume = air_radial_volume(grid, k, 1.0);
        for (size_t i = 0; i < count; i++) {
            count_bins(results->bins, a[i], scale * paths[i] * e[i] / (volume * run->mesh.omega[i]),
                       results->binned + (at + i) * results->bins);
        }
    }
}

/* The mean cosine at the surface of the ball inside the first shell of what was scattered in it,
 * evenly along the radius, with mean cosine g: <sqrt(1 - x^2 (1 - mu^2))> over x in [0, 1] and the
 * lobe, fitted to 3e-5 for |g| < 1. Straight paths leave a ball outwards, whatever they began as.
 */
static double cosine_out_of_ball(double g)
{
    const double t = g * g;
    return t + (1.0 - t) * (0.866855 + t * (0.012731 - t * 0.002381));
}

/* One radius: the beam of this power through all shells. run->path is what share of a path each
 * cell's light counts at first: half where it was scattered on the way, all of it where it comes
 * out of the ball. */
static void shine(radial_run *run, size_t cell, double power, const float *visibility)
{
    const air_radial_cells *const cells = run->cells;
    const air_radial_results *const results = run->results;
    double left = power, visible = 1.0;
    for (uint32_t k = 0; k < cells->grid.shells; k++) {
        const size_t at = k * run->mesh.count + cell;
        const double inner = air_radial_radius(&cells->grid, k);
        const double depth = air_radial_radius(&cells->grid, k + 1) - inner;
        const double sigma_s = (double)cells->sigma_s[at];
        const double sigma_t = sigma_s + (double)cells->sigma_a[at];
        const double albedo = sigma_t > 0.0 ? sigma_s / sigma_t : 0.0;
        const double ball = k == 0 ? -left * expm1(-sigma_t * inner) : 0.0;
        const double lost = ball - (left - ball) * expm1(-sigma_t * depth);
        /* The mean over the shell of what is left, times the depth. */
        const double track = sigma_t > 0.0 ? (lost - ball) / sigma_t : (left - ball) * depth;
        const double a = run->lobe * (double)cells->g[at];
        const double from_ball = run->curved && lost > 0.0 ? ball / lost : 0.0;
        visible = visibility == NULL ? 1.0 : (double)visibility[at];
        run->energy[at] = visible * albedo * lost;
        run->mean[at] = run->energy[at] > 0.0 ? a + from_ball * (cosine_out_of_ball(a) - a) : 0.0;
        run->path[at] = 0.5 + 0.5 * from_ball;
        run->books.absorbed += visible * (1.0 - albedo) * lost;
        run->books.hidden += (1.0 - visible) * lost;
        left -= lost;
        if (results->beam != NULL) {
            const double volume = air_radial_volume(&cells->grid, k, run->mesh.omega[cell]);
            results->beam[at] = (float)(visible * track / volume);
        }
        if (results->seen != NULL) {
            const double view = (double)results->view_cosine[at];
            run->seen[at] = visible * track * radial_lobe(blunt(a, 0.995), view);
        }
    }
    run->books.out += visible * left;
    run->books.hidden += (1.0 - visible) * left;
}

/* All of it in the first shell, as if it had just come in. */
static void enter(radial_run *run, size_t cell, double power, const float *visibility)
{
    const double visible = visibility == NULL ? 1.0 : (double)visibility[cell];
    for (uint32_t k = 0; k < run->cells->grid.shells; k++) {
        const size_t at = k * run->mesh.count + cell;
        run->energy[at] = k == 0 ? visible * power : 0.0;
        run->mean[at] = k == 0 ? run->lobe : 0.0;
        run->path[at] = 1.0;
        run->seen[at] = 0.0;
        if (run->results->beam != NULL) {
            run->results->beam[at] = 0.0f;
        }
    }
    run->books.hidden += (1.0 - visible) * power;
}

void radial_begin(radial_run *run, const air_radial_light *light)
{
    const bool cm = run->params->stencil == AIR_ORDINATES_CM;
    const size_t count = run->mesh.count;
    for (size_t cell = 0; cell < count; cell++) {
        const double intensity = light->intensity == NULL ? 1.0 : (double)light->intensity[cell];
        const double power = intensity * run->mesh.omega[cell];
        run->books.in += power;
        if (run->params->start == AIR_ORDINATES_BOUNDARY) {
            enter(run, cell, power, light->visibility);
        } else {
            shine(run, cell, power, light->visibility);
        }
    }
    double *const paths = run->rings[0];
    for (uint32_t k = 0; k < run->cells->grid.shells; k++) {
        for (size_t i = 0; i < count; i++) {
            const size_t at = k * count + i;
            paths[i] = run->path[at] * (cm ? radial_path(run->mean[at]) : 1.0);
            run->path[at] = 0.0;
        }
        radial_count(run, k, paths, 1.0);
    }
}

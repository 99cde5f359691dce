/* radial.c: parameters, their check, a run from beginning to end. */
#include <string.h>

#include "core/host.h"
#include "core/vec.h"
#include "ordinates/radial.h"
#include "ordinates/radial_shares.h"

void air_radial_params_default(air_radial_params *params)
{
    *params = (air_radial_params){
        .stencil = AIR_ORDINATES_CM,
        .decay = AIR_ORDINATES_DECAY_POISSON,
        .start = AIR_ORDINATES_FIRST_SCATTER,
        .lateral = AIR_RADIAL_SPREAD,
        .curvature = true,
        .steps = 128,
        .residual = 1e-3,
    };
}

/* ---- memory ---- */

enum {
    PER_CELL = 7,       /* E, a, two optical distances, ease, path, seen */
    PER_DIRECTION = 33, /* three shells of six fluxes, mobility, five rings, nine of the mesh */
    INDICES = 8,        /* opposite, four neighbours, three orders */
    /* Between arrays: rows are often a multiple of 4096 bytes, and arrays that start at one offset
     * to that drive each other out of the cache. */
    STAGGER = 24
};

static bool grid_fits(const air_radial_grid *grid)
{
    return grid->directions >= AIR_RADIAL_DIRECTIONS_MIN &&
           grid->directions <= AIR_RADIAL_DIRECTIONS_MAX && grid->directions % 2 == 0 &&
           grid->shells >= AIR_RADIAL_SHELLS_MIN && grid->shells <= AIR_RADIAL_SHELLS_MAX &&
           grid->radius_m >= 1e-15f && grid->radius_m <= 1e15f &&
           air_radial_radius(grid, 0) >= 1e-12 * (double)grid->radius_m;
}

static size_t direction_count(const air_radial_grid *grid)
{
    return (size_t)grid->directions * grid->directions;
}

size_t air_radial_scratch(const air_radial_grid *grid)
{
    if (!grid_fits(grid)) {
        return 0;
    }
    const size_t count = direction_count(grid);
    const size_t numbers = (PER_CELL * grid->shells + PER_DIRECTION) * count;
    return (numbers + (PER_CELL + PER_DIRECTION) * STAGGER) * sizeof(double) +
           INDICES * count * sizeof(uint32_t);
}

static double *take(double **next, size_t count)
{
    double *const array = *next;
    *next += count + STAGGER;
    return array;
}

static void lay_out_mesh(radial_mesh *mesh, double **next)
{
    mesh->omega = take(next, mesh->count);
    mesh->stay = take(next, mesh->count);
    for (int i = 0; i < 4; i++) {
        mesh->from[i] = take(next, mesh->count);
    }
    for (int i = 0; i < 3; i++) {
        mesh->link[i] = take(next, mesh->count);
    }
    uint32_t *index = (uint32_t *)*next;
    mesh->opposite = index;
    for (int i = 0; i < 4; i++) {
        mesh->neighbour[i] = index += mesh->count;
    }
    for (int i = 0; i < 3; i++) {
        mesh->order[i] = index += mesh->count;
    }
}

static void lay_out(radial_run *run, void *scratch)
{
    double *next = scratch;
    const size_t count = direction_count(&run->cells->grid);
    const size_t cells = count * run->cells->grid.shells;
    double **const per_cell[PER_CELL] = {&run->energy,      &run->mean, &run->scatter_half,
                                         &run->absorb_half, &run->ease, &run->path,
                                         &run->seen};
    for (int i = 0; i < PER_CELL; i++) {
        *per_cell[i] = take(&next, cells);
    }
    for (int i = 0; i < 3; i++) {
        radial_flux *const flux = &run->flux[i];
        flux->front = take(&next, count);
        flux->side = take(&next, count);
        flux->back = take(&next, count);
        flux->front_mean = take(&next, count);
        flux->side_mean = take(&next, count);
        flux->back_mean = take(&next, count);
    }
    run->mobility = take(&next, count);
    for (int i = 0; i < 5; i++) {
        run->rings[i] = take(&next, count);
    }
    run->mesh.n = run->cells->grid.directions;
    run->mesh.count = count;
    lay_out_mesh(&run->mesh, &next);
}

/* ---- arguments ---- */

static const char *params_fault(const air_radial_params *p)
{
    const bool literal = p->stencil == AIR_ORDINATES_LITERAL;
    if (!literal && p->stencil != AIR_ORDINATES_CM) {
        return "the stencil must be LITERAL or CM";
    }
    if (p->decay != AIR_ORDINATES_DECAY_POISSON && p->decay != AIR_ORDINATES_DECAY_PAPER) {
        return "the decay must be POISSON or PAPER";
    }
    if (p->start != AIR_ORDINATES_FIRST_SCATTER && p->start != AIR_ORDINATES_BOUNDARY) {
        return "the start must be FIRST_SCATTER or BOUNDARY";
    }
    if (p->lateral != AIR_RADIAL_SIDES && (p->lateral != AIR_RADIAL_SPREAD || literal)) {
        return "lateral must be SIDES or, but not with LITERAL, SPREAD";
    }
    if (p->steps < 1 || p->steps > AIR_ORDINATES_STEPS_MAX) {
        return "steps must be between 1 and 4096";
    }
    if (!(p->residual >= 0.0)) {
        return "residual must not be negative";
    }
    return NULL;
}

/* No NULL, and all of them in [low, high]. */
static bool all_within(const float *values, size_t count, float low, float high)
{
    if (values == NULL) {
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] >= low && values[i] <= high)) {
            return false;
        }
    }
    return true;
}

static const char *fault_of(const air_radial_cells *cells, const air_radial_light *light,
                            const air_radial_params *params, const void *scratch,
                            const air_radial_results *results)
{
    const float most = 3.4028234e38f, below_1 = 0.99999994f;
    if (!grid_fits(&cells->grid)) {
        return "directions must be even and between 4 and 128, shells between 2 and 256 and "
               "outside of 1e-12 of the radius, which must be between 1e-15 and 1e15";
    }
    const size_t count = direction_count(&cells->grid), all = count * cells->grid.shells;
    const char *const fault = params_fault(params);
    if (fault != NULL) {
        return fault;
    }
    if (!all_within(cells->sigma_s, all, 0.0f, most) ||
        !all_within(cells->sigma_a, all, 0.0f, most)) {
        return "coefficients must be finite and not negative";
    }
    if (!all_within(cells->g, all, -below_1, below_1)) {
        return "g must be between -1 and 1, both excluded";
    }
    if (light->intensity != NULL && !all_within(light->intensity, count, 0.0f, most)) {
        return "intensities must be finite and not negative";
    }
    if (light->visibility != NULL && !all_within(light->visibility, all, 0.0f, 1.0f)) {
        return "visibility must be between 0 and 1";
    }
    if (!(light->lobe >= 0.0f && light->lobe <= 1.0f)) {
        return "the lobe must be between 0 and 1";
    }
    if (results->seen != NULL && !all_within(results->view_cosine, all, -1.0001f, 1.0001f)) {
        return "seen needs the cosines of view, between -1 and 1";
    }
    if (results->binned != NULL && results->bins == 0) {
        return "binned needs bins";
    }
    return scratch == NULL ? "scratch is missing" : NULL;
}

/* ---- the run ---- */

static const double DEEPEST = 600.0; /* nothing is left beyond; for radial_exp */

/* Optical distances of half a cell, and how easily light goes sideways. Where g is 0 the paper's
 * decay is taken at g = 1e-6; for g < 0 it has none, and that is taken too.
 *
 * Over a path s the diffusivity is s lambda (1 - a^2) / (3 r^2): (1 - a^2) / 3 is the mean square
 * of either sideways component, lambda = 1 / (1/r + (1-g) sigma_s + sigma_a) how far light keeps
 * going sideways; 1/r as straight paths turn radial. Against simulations of lamps and cosine lobes
 * factors of 0.8 to 1.4 on 1/r do equally well. */
static void prepare(radial_run *run)
{
    const air_radial_cells *const cells = run->cells;
    const bool paper = run->params->decay == AIR_ORDINATES_DECAY_PAPER;
    const size_t count = run->mesh.count;
    for (uint32_t k = 0; k < cells->grid.shells; k++) {
        const double inner = air_radial_radius(&cells->grid, k);
        const double outer = air_radial_radius(&cells->grid, k + 1);
        const double depth = outer - inner, radius = 0.5 * (outer + inner);
        for (size_t i = k * count; i < (k + 1) * count; i++) {
            const double g = (double)cells->g[i], omega = run->mesh.omega[i - k * count];
            const double rate = paper ? -log(double_max(g, 1e-6)) : 1.0 - g;
            const double scatter = 0.5 * depth * rate * (double)cells->sigma_s[i];
            const double absorb = 0.5 * depth * (double)cells->sigma_a[i];
            const double lambda = 1.0 / (1.0 / radius + 2.0 * (scatter + absorb) / depth);
            run->scatter_half[i] = double_min(DEEPEST, scatter);
            run->absorb_half[i] = double_min(DEEPEST, absorb);
            run->ease[i] = depth * lambda / (3.0 * radius * radius * omega);
            run->absorbing |= cells->sigma_a[i] > 0.0f;
        }
    }
    memset(run->seen, 0, count * cells->grid.shells * sizeof *run->seen);
    if (run->results->binned != NULL) {
        memset(run->results->binned, 0,
               count * cells->grid.shells * run->results->bins * sizeof(float));
    }
}

static double under_way(const radial_run *run)
{
    double sum = 0.0;
    for (size_t i = 0; i < run->mesh.count * run->cells->grid.shells; i++) {
        sum += run->energy[i];
    }
    return sum;
}

/* The last state's pass, and the results in the caller's units. */
static void finish(radial_run *run)
{
    const air_radial_results *const results = run->results;
    const bool cm = run->params->stencil == AIR_ORDINATES_CM;
    for (uint32_t k = 0; k < run->cells->grid.shells; k++) {
        const double volume = air_radial_volume(&run->cells->grid, k, 1.0);
        const size_t at = k * run->mesh.count;
        for (size_t i = 0; i < run->mesh.count; i++) {
            run->rings[0][i] = cm ? radial_path(run->mean[at + i]) : 1.0;
        }
        radial_count(run, k, run->rings[0], 1.0);
        for (size_t i = 0; i < run->mesh.count; i++) {
            const double inverse = 1.0 / (volume * run->mesh.omega[i]);
            if (results->fluence != NULL) {
                results->fluence[at + i] = (float)(run->path[at + i] * inverse);
            }
            if (results->seen != NULL) {
                results->seen[at + i] = (float)(run->seen[at + i] * inverse);
            }
            if (results->energy != NULL) {
                results->energy[at + i] = (float)run->energy[at + i];
            }
            if (results->asymmetry != NULL) {
                results->asymmetry[at + i] = (float)run->mean[at + i];
            }
        }
    }
    if (results->books != NULL) {
        *results->books = run->books;
    }
}

air_status air_radial_run(air_context *context, const air_radial_cells *cells,
                          const air_radial_light *light, const air_radial_params *params,
                          void *scratch, const air_radial_results *results)
{
    const air_radial_light standard = {.lobe = 1.0f};
    light = light == NULL ? &standard : light;
    const char *const fault = fault_of(cells, light, params, scratch, results);
    if (fault != NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "radial grid: %s", fault);
    }
    radial_run run = {
        .cells = cells,
        .params = params,
        .results = results,
        .lobe = (double)light->lobe,
        .curved = params->curvature && params->stencil == AIR_ORDINATES_CM,
    };
    lay_out(&run, scratch);
    radial_mesh_fill(&run.mesh, params);
    prepare(&run);
    radial_begin(&run, light);
    run.books.residual = under_way(&run);
    while (run.books.steps < params->steps &&
           run.books.residual > params->residual * run.books.in) {
        radial_step(&run, run.books.steps == 0 ? 0.0 : 1.0);
        run.books.steps++;
        run.books.residual = under_way(&run);
    }
    finish(&run);
    return AIR_OK;
}

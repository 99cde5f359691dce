/* shells.c: shells around each lamp, and around each patch that stands for a lit surface.
 */
#include <math.h>
#include <string.h>

#include "airlight/ordinates_radial.h"
#include "render/ordinates/grids.h"

enum { CHANNELS = 4, DIRECTIONS = 24, SHELLS = 24, RUN = 256 };
enum { SHELL_CELLS = DIRECTIONS * DIRECTIONS * SHELLS };

/* One lamp's grid. */
typedef struct shells {
    air_radial_grid grid;
    float intensity[DIRECTIONS * DIRECTIONS];
    float sigma_s[3][SHELL_CELLS], sigma_a[3][SHELL_CELLS], g[3][SHELL_CELLS];
    float visibility[SHELL_CELLS], cosine[SHELL_CELLS], seen[3][SHELL_CELLS];
} shells;

/* So far that the domain lies within. */
static float reach(const ord_domain *domain, air_vec3 light)
{
    float most = 0.0f;
    for (int corner = 0; corner < 8; corner++) {
        float at[3];
        for (int axis = 0; axis < 3; axis++) {
            at[axis] = (corner >> axis & 1) != 0
                           ? domain->cell_m * (float)(ptrdiff_t)domain->size[axis]
                           : 0.0f;
        }
        most = float_max(most, vec3_length(vec3_sub(vec3_load(at), light)));
    }
    return most * 1.001f;
}

static void fill_shells(const ord_carrying *carrying, const ord_source *source, shells *out)
{
    const ord_domain *const d = carrying->domain;
    const air_vec3 light = ord_domain_local(d, source->place);
    for (uint32_t i = 0; i < DIRECTIONS * DIRECTIONS; i++) {
        double dir[3];
        air_radial_direction(DIRECTIONS, i % DIRECTIONS, i / DIRECTIONS, dir);
        const air_vec3 travel = vec3((float)dir[0], (float)dir[1], (float)dir[2]);
        out->intensity[i] = ord_source_intensity(source, travel);
        for (uint32_t k = 0; k < SHELLS; k++) {
            const size_t cell = (size_t)k * DIRECTIONS * DIRECTIONS + i;
            const double r =
                sqrt(air_radial_radius(&out->grid, k) * air_radial_radius(&out->grid, k + 1));
            const air_vec3 at = vec3_madd(light, (float)r, travel);
            float local[3];
            vec3_store(local, at);
            for (size_t c = 0; c < 3; c++) {
                const size_t plane = c * d->cells;
                out->sigma_s[c][cell] = ord_domain_sample(d, d->sigma_s + plane, 1, local);
                out->sigma_a[c][cell] = ord_domain_sample(d, d->sigma_a + plane, 1, local);
                out->g[c][cell] = ord_domain_sample(d, d->g + plane, 1, local);
            }
            out->visibility[cell] =
                ord_source_share(source, carrying->with->path, ord_domain_world(d, at));
            const air_vec3 observer = vec3_load(carrying->box.observer);
            const air_vec3 to = carrying->box.distant ? observer : vec3_sub(observer, at);
            const float length = vec3_length(to);
            const float cosine = length > 0.0f ? vec3_dot(to, travel) / length : 1.0f;
            out->cosine[cell] = float_min(float_max(cosine, -1.0f), 1.0f);
        }
    }
}

static air_status run_shells(const ord_carrying *carrying, const ord_source *source, void *scratch,
                             shells *s)
{
    const bool literal = source->mode == AIR_ORDINATES_MODE_LITERAL;
    const air_radial_light light = {s->intensity, s->visibility, 1.0f};
    air_radial_params params;
    air_status status = AIR_OK;
    air_radial_params_default(&params);
    if (literal) {
        params.stencil = AIR_ORDINATES_LITERAL;
        params.decay = AIR_ORDINATES_DECAY_PAPER;
        params.lateral = AIR_RADIAL_SIDES;
        params.curvature = false;
        params.steps = carrying->with->settings->steps;
    }
    for (int c = 0; c < (carrying->grey ? 1 : 3) && status == AIR_OK; c++) {
        const air_radial_cells cells = {s->grid, s->sigma_s[c], s->sigma_a[c], s->g[c]};
        const air_radial_results results = {.view_cosine = s->cosine, .seen = s->seen[c]};
        status =
            air_radial_run(carrying->with->context, &cells, &light, &params, scratch, &results);
    }
    for (int c = 1; c < 3 && carrying->grey; c++) {
        memcpy(s->seen[c], s->seen[0], sizeof s->seen[c]);
    }
    return status;
}

/* A row of the domain's cells at a time. */
static void merge_row(const ord_carrying *carrying, const ord_source *source, const shells *s,
                      size_t first, size_t count)
{
    const ord_domain *const d = carrying->domain;
    const air_vec3 light = ord_domain_local(d, source->place);
    const float powers[3] = {source->power.x, source->power.y, source->power.z};
    float x[RUN], y[RUN], z[RUN], seen[RUN];
    for (size_t n = 0; n < count; n++) {
        size_t at[3];
        ord_domain_cell(d, first + n, at);
        x[n] = ((float)(ptrdiff_t)at[0] + 0.5f) * d->cell_m - light.x;
        y[n] = ((float)(ptrdiff_t)at[1] + 0.5f) * d->cell_m - light.y;
        z[n] = ((float)(ptrdiff_t)at[2] + 0.5f) * d->cell_m - light.z;
    }
    for (size_t c = 0; c < 3; c++) {
        air_radial_look_up(&s->grid, s->seen[c], count, x, y, z, seen);
        for (size_t n = 0; n < count; n++) {
            carrying->with->carried[(first + n) * CHANNELS + c] += powers[c] * seen[n];
        }
    }
}

air_status ord_carry_points(ord_carrying *carrying)
{
    air_context *const context = carrying->with->context;
    const size_t cells = carrying->domain->cells;
    const air_radial_grid shape = {DIRECTIONS, SHELLS, 1.0f};
    shells *const s = air_allocate(context, 1, sizeof *s);
    void *const scratch = air_allocate(context, air_radial_scratch(&shape), 1);
    air_status status =
        s != NULL && scratch != NULL ? AIR_OK : air_fail_memory(context, "ordinates: shells");
    for (size_t i = 0; i < carrying->sources->count && status == AIR_OK; i++) {
        const ord_source *const source = &carrying->sources->items[i];
        if (!source->local || !ord_source_is_carried(source)) {
            continue;
        }
        s->grid = shape;
        s->grid.radius_m =
            reach(carrying->domain, ord_domain_local(carrying->domain, source->place));
        fill_shells(carrying, source, s);
        status = run_shells(carrying, source, scratch, s);
        for (size_t cell = 0; cell < cells && status == AIR_OK; cell += RUN) {
            merge_row(carrying, source, s, cell, cells - cell < RUN ? cells - cell : RUN);
        }
    }
    air_free(context, s);
    air_free(context, scratch);
    return status;
}

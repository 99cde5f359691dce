/* oracle_ordinates_radial.c: radial grids around a point light against shells of photons. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_radial.h"
#include "core/vec.h"
#include "oracle_ordinates.h"

/* A run's arrays, of one block. */
typedef struct shells_run {
    air_radial_cells cells;
    size_t count;
    float *numbers, *sigma_s, *sigma_a, *g, *intensity, *fluence, *beam, *binned;
    void *scratch;
    air_radial_books books;
} shells_run;

static bool shells_make(const simulated *what, shells_run *out)
{
    const size_t around = what->cells * what->cells, count = around * what->shells;
    memset(out, 0, sizeof *out);
    out->cells.grid = (air_radial_grid){.directions = (uint32_t)what->cells,
                                        .shells = (uint32_t)what->shells,
                                        .radius_m = (float)what->size_m};
    out->count = count;
    out->numbers = malloc((count * (5 + BINS) + around) * sizeof *out->numbers);
    out->scratch = malloc(air_radial_scratch(&out->cells.grid));
    if (out->numbers == NULL || out->scratch == NULL) {
        return false;
    }
    out->cells.sigma_s = out->sigma_s = out->numbers;
    out->cells.sigma_a = out->sigma_a = out->sigma_s + count;
    out->cells.g = out->g = out->sigma_a + count;
    out->fluence = out->g + count;
    out->beam = out->fluence + count;
    out->binned = out->beam + count;
    out->intensity = out->binned + count * BINS;
    for (size_t i = 0; i < count; i++) {
        out->sigma_s[i] = (float)what->sigma_s;
        out->sigma_a[i] = (float)what->sigma_a;
        out->g[i] = (float)what->g;
    }
    for (size_t i = 0; i < around; i++) {
        out->intensity[i] = (float)(what->light / (4.0 * AIR_PI));
    }
    return true;
}

static void shells_finish(shells_run *self)
{
    free(self->numbers);
    free(self->scratch);
}

static bool shells_go(const judges *with, shells_run *self, const air_radial_params *params)
{
    const air_radial_light light = {.intensity = self->intensity, .lobe = 1.0f};
    const air_radial_results results = {.fluence = self->fluence,
                                        .beam = self->beam,
                                        .bins = BINS,
                                        .binned = self->binned,
                                        .books = &self->books};
    return air_radial_run(with->doubles, &self->cells, &light, params, self->scratch, &results) ==
           AIR_OK;
}

typedef struct shells_score {
    double all, scattered; /* relative errors, root mean square over shells */
    double variation;      /* of the shares of bins, the beam in the last */
    double beam;           /* the largest relative error of unscattered light */
    double radius;         /* of the file's shells against the grid's */
    double imbalance;
} shells_score;

/* Directions are alike: the first stands for all. */
static shells_score score(const shells_run *run, const shell_truth *truth, bool apart)
{
    const size_t around = run->count / run->cells.grid.shells;
    const double shells = run->cells.grid.shells;
    const air_radial_books *const b = &run->books;
    shells_score out = {0};
    for (uint32_t k = 0; k < run->cells.grid.shells; k++) {
        const double *const v = truth[k];
        const float *const bins = run->binned + k * around * BINS;
        const double phi = (double)run->fluence[k * around], beam = (double)run->beam[k * around];
        const double whole = v[SHELL_BEAM] + v[SHELL_SCATTERED];
        const double inner = air_radial_radius(&run->cells.grid, k);
        double sums[2] = {apart ? beam : 0.0, v[SHELL_BEAM]}, variation = 0.0;
        for (int i = 0; i < BINS; i++) {
            sums[0] += (double)bins[i];
            sums[1] += v[SHELL_BINS + i];
        }
        for (int i = 0; i < BINS; i++) {
            const bool last = i == BINS - 1;
            const double found = (double)bins[i] + (last && apart ? beam : 0.0);
            const double given = v[SHELL_BINS + i] + (last ? v[SHELL_BEAM] : 0.0);
            variation += 0.5 * fabs(found / sums[0] - given / sums[1]);
        }
        const double all = (phi + beam) / whole - 1.0, scattered = phi / v[SHELL_SCATTERED] - 1.0;
        out.all += all * all / shells;
        out.scattered += scattered * scattered / shells;
        out.variation += variation / shells;
        out.beam = fmax(out.beam, fabs(beam / v[SHELL_BEAM] - 1.0));
        out.radius = fmax(out.radius, fabs(v[SHELL_INNER] / inner - 1.0));
    }
    out.all = sqrt(out.all);
    out.scattered = sqrt(out.scattered);
    out.imbalance = fabs(b->in - b->out - b->absorbed - b->hidden - b->residual) / b->in;
    return out;
}

/* What is specified of the paper's own scheme in the public spheres, two digits; 0: nothing. */
static double specified_literal(const simulated *what)
{
    const bool known = what->cells == 32 && what->shells == 32 && what->size_m == 2.5 &&
                       what->sigma_a == 0.0 && what->g == 0.7;
    return known && what->sigma_s == 0.8 ? 0.31 : (known && what->sigma_s == 1.3 ? 0.41 : 0.0);
}

static void tell_literal(verdict *said, const simulated *what, const shells_score *found)
{
    static const char *const mode = "literal, boundary, paper's decay, 32 passes";
    const double known = specified_literal(what);
    verdict_tell(said, mode, "fluence", found->all, known > 0.0 ? known - 0.03 : ANY_LEAST,
                 known > 0.0 ? known + 0.03 : ANY_MOST);
    verdict_tell(said, mode, "angles", found->variation, ANY_LEAST, ANY_MOST);
    verdict_tell(said, mode, "books, doubles", found->imbalance, 0.0, 1e-12);
}

static void tell_moments(verdict *said, const shells_score *found)
{
    static const char *const mode = "cm, curvature";
    verdict_tell(said, mode, "fluence", found->all, 0.0, 0.03);
    verdict_tell(said, mode, "scattered fluence", found->scattered, ANY_LEAST, ANY_MOST);
    verdict_tell(said, mode, "angles", found->variation, ANY_LEAST, ANY_MOST);
    /* Six digits are printed. */
    verdict_tell(said, "unscattered", "fluence, worst shell", found->beam, 0.0, 1e-4);
    verdict_tell(said, "grid", "inner radius, worst shell", found->radius, 0.0, 1e-5);
    verdict_tell(said, mode, "books, doubles", found->imbalance, 0.0, 1e-12);
}

int shells_judge(const judges *with, const simulated *what, const char *path,
                 const shell_truth *truth)
{
    verdict said = {.path = path};
    air_radial_params params;
    shells_run run;
    bool good = shells_make(what, &run);
    printf("%s: %zu shells of %zu x %zu directions, R %g m, sigma_s %g, sigma_a %g, g %g\n", path,
           what->shells, what->cells, what->cells, what->size_m, what->sigma_s, what->sigma_a,
           what->g);
    air_radial_params_default(&params);
    params.steps = 300;
    params.residual = 1e-4;
    good = good && shells_go(with, &run, &params);
    if (good) {
        const shells_score moments = score(&run, truth, true);
        tell_moments(&said, &moments);
    }
    params.stencil = AIR_ORDINATES_LITERAL;
    params.lateral = AIR_RADIAL_SIDES;
    params.decay = AIR_ORDINATES_DECAY_PAPER;
    params.start = AIR_ORDINATES_BOUNDARY;
    params.steps = 31; /* what it begins with is a pass too */
    params.residual = 0.0;
    good = good && shells_go(with, &run, &params);
    if (good) {
        const shells_score literal = score(&run, truth, false);
        tell_literal(&said, what, &literal);
    } else {
        fprintf(stderr, "%s: could not be computed: %s\n", path,
                air_context_last_error(with->doubles));
    }
    shells_finish(&run);
    return good ? said.missed : -1;
}

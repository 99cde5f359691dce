/* oracle_ordinates_cube.c: all modes in a cube under a beam against photons that were counted. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "oracle_ordinates_field.h"
#include "ordinates_golden.h"

/* ---- scores ---- */

typedef struct cube_score {
    double fluence; /* root of the mean square of its error, over the mean */
    double flux;    /* of that along z, likewise and over the mean fluence */
    double angles;  /* total variation of the shares of bins, mean over the middle slices */
    double exits;   /* largest error of a face, as a share of what leaves through it */
    double mean;    /* relative error of the mean fluence */
} cube_score;

static double mean_of(const float *numbers, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)numbers[i];
    }
    return sum / (double)count;
}

/* Root of the mean square of found - given, over a mean. */
static double error_of(const double *found, const float *given, size_t count, double mean)
{
    double squares = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double error = found[i] - (double)given[i];
        squares += error * error;
    }
    return sqrt(squares / (double)count) / mean;
}

static double variation_of(const simulated *what, const double *bins, const float *given)
{
    const size_t n = what->cells;
    const double edge = what->size_m / (double)n, sigma = what->sigma_s + what->sigma_a;
    double variation = 0.0;
    for (size_t place = 0; place < n * n; place++) {
        const double z = (double)(place / n) * edge;
        const double beam = what->light * field_beam(sigma, z, z + edge);
        double sums[2] = {0.0, beam};
        for (int bin = 0; bin < BINS; bin++) {
            sums[0] += bins[place * BINS + (size_t)bin];
            sums[1] += (double)given[place * BINS + (size_t)bin];
        }
        variation += sums[0] > 0.0 ? 0.0 : 1.0; /* no light has come there yet */
        for (int bin = 0; bin < BINS && sums[0] > 0.0; bin++) {
            const double last = bin == BINS - 1 ? beam : 0.0;
            variation += 0.5 * fabs(bins[place * BINS + (size_t)bin] / sums[0] -
                                    ((double)given[place * BINS + (size_t)bin] + last) / sums[1]);
        }
    }
    return variation / (double)(n * n);
}

static cube_score score(const simulated *what, const cube_truth *truth, const cube_field *found)
{
    const size_t count = what->cells * what->cells * what->cells;
    cube_score out = {0};
    if (truth->has[CUBE_FLUENCE]) {
        const double mean = mean_of(truth->fluence, count);
        double sum = 0.0;
        for (size_t i = 0; i < count; i++) {
            sum += found->fluence[i];
        }
        out.fluence = error_of(found->fluence, truth->fluence, count, mean);
        out.flux = error_of(found->flux, truth->fluence + 5 * count, count, mean);
        out.mean = fabs(sum / (double)count / mean - 1.0);
    }
    if (truth->has[CUBE_ANGULAR]) {
        out.angles = variation_of(what, found->bins, truth->angular);
    }
    for (int face = 0; face < FACES && truth->has[CUBE_EXIT]; face++) {
        out.exits = fmax(out.exits, fabs(found->leaves[face] / truth->leaves[face] - 1.0));
    }
    return out;
}

/* ---- modes ---- */

/* Accepted; most 0: nothing is. only_public: known of the public cube, else of any. */
typedef struct accepted {
    double least, most;
    bool only_public;
} accepted;

typedef struct cube_mode {
    const char *name;
    bool dom;
    int golden; /* a stored result; -1: none */
    air_ordinates_params steps;
    field_dom how;
    bool twice; /* in doubles as well as in floats */
    accepted fluence, flux, angles, exits;
} cube_mode;

/* Printed with two or three digits: half of the last, and a little. */
static accepted printed(double value, double half_digit)
{
    return (accepted){value - 1.2 * half_digit, value + 1.2 * half_digit, true};
}

static air_ordinates_params steps_of(air_ordinates_stencil stencil, air_ordinates_decay decay,
                                     air_ordinates_start start, uint32_t steps, double residual)
{
    air_ordinates_params out;
    air_ordinates_params_default(&out);
    out.stencil = stencil;
    out.decay = decay;
    out.start = start;
    out.steps = steps;
    out.residual = residual;
    return out;
}

static field_dom dom_of(int bands, int polar, int azimuths, uint32_t sweeps, double change,
                        int depth)
{
    field_dom out = {.bands = bands, .polar = polar, .azimuths = azimuths};
    air_dom_solve_params_default(&out.solve);
    out.solve.sweeps = sweeps;
    out.solve.change = change;
    out.solve.depth = depth;
    return out;
}

enum { MODES = ORDINATES_GOLDEN + 6 };

/* Of these steps and until 1e-4 is under way: the stencils converged, first_scatter. */
static cube_mode converged(const char *name, air_ordinates_stencil stencil, accepted fluence,
                           accepted angles)
{
    const bool literal = stencil == AIR_ORDINATES_LITERAL;
    return (cube_mode){
        .name = name,
        .golden = -1,
        .twice = stencil != AIR_ORDINATES_SIX,
        .steps =
            steps_of(stencil, literal ? AIR_ORDINATES_DECAY_PAPER : AIR_ORDINATES_DECAY_POISSON,
                     AIR_ORDINATES_FIRST_SCATTER, AIR_ORDINATES_STEPS_MAX, 1e-4),
        .fluence = fluence,
        .angles = angles};
}

static void list_modes(cube_mode out[MODES])
{
    static const char *const names[ORDINATES_GOLDEN] = {
        "literal, boundary, paper's decay, 10",  "literal, boundary, paper's decay, 16",
        "literal, scattered, paper's decay, 10", "literal, scattered, paper's decay, 16",
        "literal, boundary, Poisson decay, 16",  "cm, scattered, Poisson decay, 10",
        "cm, scattered, Poisson decay, 16",      "cm, scattered, Poisson decay, 64"};
    cube_mode *next = out;
    for (int i = 0; i < ORDINATES_GOLDEN; i++) {
        const ordinates_golden *const g = &ordinates_goldens[i];
        *next++ = (cube_mode){.name = names[i],
                              .golden = i,
                              .twice = true,
                              .steps = steps_of(g->stencil, g->decay, g->start, g->steps, 0.0),
                              .fluence = printed(g->rms, 5e-4)};
    }
    *next++ = converged("literal, scattered, converged", AIR_ORDINATES_LITERAL, printed(3.28, 5e-3),
                        printed(0.32, 5e-3));
    *next++ =
        converged("cm, converged", AIR_ORDINATES_CM, printed(0.23, 5e-3), printed(0.11, 5e-3));
    *next =
        converged("six, converged", AIR_ORDINATES_SIX, printed(0.104, 5e-4), printed(0.086, 1e-3));
    next++->flux = printed(0.051, 2e-3);
    /* Printed of another solver: 0.0081, 0.0051, 0.023. */
    *next++ = (cube_mode){.name = "dom, 5 bands, 8 x 16",
                          .dom = true,
                          .golden = -1,
                          .how = dom_of(5, 8, 16, 64, 1e-4, 4),
                          .fluence = {0.0, 0.012, false},
                          .flux = {0.0, 0.008, true},
                          .angles = {0.9 * 0.023, 1.1 * 0.023, true}};
    *next++ = (cube_mode){.name = "dom, 4 bands, 4 x 8, 8 plain sweeps",
                          .dom = true,
                          .golden = -1,
                          .twice = true,
                          .how = dom_of(4, 4, 8, 8, 0.0, 0),
                          .fluence = {0.0, 0.025, false}};
    /* 0.0089, 0.0054 */
    *next = (cube_mode){.name = "dom, 10 bands, 12 x 24",
                        .dom = true,
                        .golden = -1,
                        .how = dom_of(10, 12, 24, 64, 1e-4, 4),
                        .fluence = {0.0, 0.012, true},
                        .angles = {0.9 * 0.0054, 1.1 * 0.0054, true},
                        .exits = {0.0, 0.01, false}};
}

typedef struct cube_result {
    cube_score score;
    double imbalance[2];   /* of doubles, of floats; NAN: not run */
    double golden, sweeps; /* largest difference from the stored result */
} cube_result;

/* The largest difference of a run in doubles from what is stored. */
static double golden_difference(const cube_field *found, const ordinates_golden *g)
{
    const double face = (double)(found->n * found->n);
    double mean = 0.0, worst = 0.0;
    for (size_t i = 0; i < found->n * found->n * found->n; i++) {
        mean += found->fluence[i] / (double)(found->n * found->n * found->n);
    }
    const double off[8] = {mean - g->mean,
                           found->scattered - g->fluence,
                           found->energy * face - g->energy,
                           found->mean_cosine - g->a,
                           found->leaves[0] - g->out[0],
                           found->leaves[4] - g->out[1],
                           found->leaves[5] - g->out[2],
                           found->residual - g->residual};
    for (int i = 0; i < 8; i++) {
        worst = fmax(worst, fabs(off[i]));
    }
    return worst;
}

static bool run_mode(const judges *with, const simulated *what, const cube_truth *truth,
                     const cube_mode *mode, cube_result *out)
{
    const size_t n = what->cells;
    const bool bins = truth->has[CUBE_FLUENCE] || truth->has[CUBE_ANGULAR];
    cube_field field;
    /* Bins are computed in doubles by all, and so is SIX. */
    bool good = mode->dom ? field_by_dom(with->floats, what, n, &mode->how, bins, &field)
                          : field_by_steps(with->doubles, what, n, &mode->steps, bins, &field);
    out->imbalance[0] = out->imbalance[1] = out->golden = NAN;
    if (good) {
        out->score = score(what, truth, &field);
        out->imbalance[mode->dom ? 1 : 0] = field.imbalance;
        out->golden =
            mode->golden >= 0 ? golden_difference(&field, &ordinates_goldens[mode->golden]) : NAN;
    }
    field_finish(&field);
    if (!good || !mode->twice) {
        return good;
    }
    good = mode->dom ? field_by_dom(with->doubles, what, n, &mode->how, false, &field)
                     : field_by_steps(with->floats, what, n, &mode->steps, false, &field);
    if (good) {
        out->imbalance[mode->dom ? 0 : 1] = field.imbalance;
    }
    field_finish(&field);
    return good;
}

/* ---- finer cells ---- */

enum { REFINED = 3 };

/* Error of the fluence as means over (n/2)^3 cells. */
static double coarse_error(const simulated *what, const cube_truth *truth, const cube_field *found)
{
    const size_t n = what->cells, few = n / 2, count = few * few * few;
    double *const coarse = calloc(2 * count, sizeof *coarse), squares = 0.0, mean = 0.0;
    if (coarse == NULL) {
        return NAN;
    }
    for (int pass = 0; pass < 2; pass++) {
        const size_t m = pass == 0 ? found->n : n, each = m / few;
        for (size_t cell = 0; cell < m * m * m; cell++) {
            const size_t i = cell % m / each, j = cell / m % m / each, k = cell / m / m / each;
            const double value = pass == 0 ? found->fluence[cell] : (double)truth->fluence[cell];
            coarse[(size_t)pass * count + (k * few + j) * few + i] +=
                value / (double)(each * each * each);
        }
    }
    for (size_t i = 0; i < count; i++) {
        const double error = coarse[i] - coarse[count + i];
        squares += error * error / (double)count;
        mean += coarse[count + i] / (double)count;
    }
    free(coarse);
    return sqrt(squares) / mean;
}

/* With half of the cells along an edge, with all, and with twice as many. */
static bool refine(const judges *with, const simulated *what, const cube_truth *truth,
                   const cube_mode *mode, double out[REFINED])
{
    size_t n = what->cells / 2;
    bool good = true;
    for (int i = 0; i < REFINED && good; i++, n *= 2) {
        cube_field field;
        good = mode->dom ? field_by_dom(with->floats, what, n, &mode->how, false, &field)
                         : field_by_steps(with->floats, what, n, &mode->steps, false, &field);
        out[i] = good ? coarse_error(what, truth, &field) : NAN;
        field_finish(&field);
    }
    return good;
}

/* Below this, errors are those of directions and photons. */
static const double refined_floor = 0.003;

static void tell_refined(verdict *said, const simulated *what, const char *mode, bool falls,
                         const double errors[REFINED])
{
    size_t n = what->cells / 2;
    for (int i = 0; i < REFINED; i++, n *= 2) {
        char quantity[64];
        snprintf(quantity, sizeof quantity, "fluence, %zu^3 cells", n);
        verdict_tell(said, mode, quantity, errors[i],
                     i == 0 || falls ? ANY_LEAST : nextafter(errors[i - 1], 1e300),
                     i == 0 || !falls ? ANY_MOST
                                      : fmax(nextafter(errors[i - 1], 0.0), refined_floor));
    }
}

/* ---- all ---- */

static bool is_public(const simulated *what)
{
    return what->cells == 16 && what->size_m == 1.0 && what->sigma_s == 4.0 &&
           what->sigma_a == 0.0 && what->g == 0.7 && what->light == 1.0;
}

static void tell(verdict *said, const cube_mode *mode, const char *quantity, double found,
                 const accepted *a, bool public)
{
    const bool known = a->most > 0.0 && (public || !a->only_public);
    verdict_tell(said, mode->name, quantity, found, known ? a->least : ANY_LEAST,
                 known ? a->most : ANY_MOST);
}

/* What photons themselves should add up to: exits, to printed digits and what they lost; their
 * number of events, sigma_s times the fluence in the volume; unscattered light. */
static void tell_photons(verdict *said, const simulated *what, const cube_truth *truth, int file)
{
    const size_t n = what->cells, count = n * n * n;
    const double edge = what->size_m / (double)n, sigma = what->sigma_s + what->sigma_a;
    if (file == CUBE_FLUENCE) {
        double worst = 0.0;
        for (size_t k = 0; k < n; k++) {
            const double beam =
                what->light * field_beam(sigma, (double)k * edge, (double)(k + 1) * edge);
            const double mean = mean_of(truth->fluence + 2 * count + k * n * n, n * n);
            worst = fmax(worst, fabs(mean - beam) / what->light);
        }
        verdict_tell(said, "photons", "unscattered, worst slice", worst, 0.0, 3e-3);
    } else if (file == CUBE_EXIT) {
        double sum = -1.0;
        for (int i = 0; i < LEAVES; i++) {
            sum += truth->leaves[i];
        }
        verdict_tell(said, "photons", "books", fabs(sum), 0.0, 1e-3);
        if (!isnan(truth->events) && !isnan(truth->mean)) {
            const double events = what->sigma_s * truth->mean * what->size_m / what->light;
            verdict_tell(said, "photons", "events", fabs(events / truth->events - 1.0), 0.0, 3e-3);
        }
    }
}

static void tell_file(verdict *said, const simulated *what, const cube_truth *truth,
                      const cube_mode modes[MODES], const cube_result results[MODES], int file)
{
    const bool public = is_public(what);
    said->path = truth->path[file];
    printf("%s: %zu^3 cells, edge %g m, sigma_s %g, sigma_a %g, g %g\n", said->path, what->cells,
           what->size_m, what->sigma_s, what->sigma_a, what->g);
    tell_photons(said, what, truth, file);
    for (int i = 0; i < MODES; i++) {
        const cube_score *const s = &results[i].score;
        if (file == CUBE_FLUENCE) {
            tell(said, &modes[i], "fluence", s->fluence, &modes[i].fluence, public);
            tell(said, &modes[i], "flux", s->flux, &modes[i].flux, public);
        } else if (file == CUBE_ANGULAR) {
            tell(said, &modes[i], "angles", s->angles, &modes[i].angles, public);
        } else {
            tell(said, &modes[i], "exits, worst face", s->exits, &modes[i].exits, public);
        }
    }
}

/* Of no file: stored results and books. */
static void tell_runs(verdict *said, const simulated *what, const cube_mode modes[MODES],
                      const cube_result results[MODES])
{
    said->path = what->stem;
    printf("%s: stored results and books\n", what->stem);
    for (int i = 0; i < MODES; i++) {
        const cube_result *const r = &results[i];
        if (modes[i].golden >= 0 && is_public(what)) {
            verdict_tell(said, modes[i].name, "stored result", r->golden, 0.0, 1e-6);
        }
        for (int which = 0; which < 2; which++) {
            if (!isnan(r->imbalance[which])) {
                verdict_tell(said, modes[i].name, which == 0 ? "books, doubles" : "books, floats",
                             r->imbalance[which], 0.0, which == 0 ? 1e-12 : 1e-5);
            }
        }
    }
}

int cube_judge(const judges *with, const simulated *what, const cube_truth *truth)
{
    cube_mode modes[MODES];
    cube_result results[MODES];
    double finer[2][REFINED];
    verdict said = {.path = what->stem};
    bool good = true;
    list_modes(modes);
    for (int i = 0; i < MODES && good; i++) {
        good = run_mode(with, what, truth, &modes[i], &results[i]);
    }
    cube_mode literal = modes[ORDINATES_GOLDEN];
    literal.steps.start = AIR_ORDINATES_BOUNDARY;
    for (int i = 0; i < 2 && good && truth->has[CUBE_FLUENCE]; i++) {
        good = refine(with, what, truth, i == 0 ? &literal : &modes[MODES - 1], finer[i]);
    }
    if (!good) {
        fprintf(stderr, "%s: could not be computed: %s\n", what->stem,
                air_context_last_error(with->floats));
        return -1;
    }
    for (int file = 0; file < CUBE_FILES; file++) {
        if (truth->has[file]) {
            tell_file(&said, what, truth, modes, results, file);
        }
        if (truth->has[file] && file == CUBE_FLUENCE) {
            tell_refined(&said, what, "literal, boundary, converged", false, finer[0]);
            tell_refined(&said, what, modes[MODES - 1].name, true, finer[1]);
        }
    }
    tell_runs(&said, what, modes, results);
    return said.missed;
}

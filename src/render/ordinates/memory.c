/* memory.c: what a solution will take, told before it is begun. */
#include "airlight/ordinates_beam.h"
#include "airlight/ordinates_dom.h"
#include "render/ordinates/photons.h"
#include "render/ordinates/state.h"

enum { CHANNELS = 4 };

/* Of what lives while blocks of sources are taken: two extinctions, and for each kind of light that
 * is wanted the fluences of a block. */
static double block_bytes(const air_with_ordinates *with)
{
    const ord_domain *const d = &with->domain;
    const double cells = (double)d->cells, four = CHANNELS * sizeof(float);
    const double kinds = (double)with->all + (double)with->single;
    const size_t beam = air_beam_scratch(d->size);
    const double spread = cells * sizeof(float);
    const double scratch = (double)beam > spread ? (double)beam : spread;
    return 2.0 * cells * four + ORD_BLOCK * (kinds * cells * four + scratch);
}

/* Of scattered light: its moments here, those of the sky that enters by the faces (it may), and in
 * the solver. */
static double solver_bytes(const air_with_ordinates *with)
{
    const ord_domain *const d = &with->domain;
    const double bands = (double)with->rule.bands;
    air_dom_params dom = with->rule;
    air_dom_solve_params solve;
    air_dom_solve_params_default(&solve);
    for (int axis = 0; axis < 3; axis++) {
        dom.size[axis] = d->size[axis];
        dom.cell_m[axis] = d->cell_m;
    }
    const double kept =
        with->past != NULL ? 4.0 : 2.0; /* the picture's before, and the next one's */
    return kept * (double)d->cells * bands * bands * CHANNELS * sizeof(float) +
           (double)air_dom_bytes(&dom, solve.depth);
}

/* Of light that surfaces send back: photons, and copies of what there was before. */
static double surface_bytes(const air_with_ordinates *with)
{
    const double bands = (double)with->rule.bands, media = (double)with->snapshot->media.count;
    const double four = CHANNELS * sizeof(float);
    return (double)with->domain.cells * four * (2.0 * bands * bands + media) +
           2.0 * ORD_PHOTONS * (ORD_ROUNDS + 1.0) * (double)sizeof(ord_photon);
}

double ord_memory(const air_with_ordinates *with, bool deep)
{
    const double cells = (double)with->domain.cells;
    const double planes = 3.0 * 3.0 + 2.0; /* coefficients, mean extinction, depth to the camera */
    const double kinds = (double)with->all + (double)with->single;
    const double media = (double)with->snapshot->media.count * kinds * CHANNELS;
    return cells * (planes + media) * sizeof(float) + block_bytes(with) + ord_voxels_bytes(with) +
           (deep ? solver_bytes(with) : 0.0) +
           (deep && with->snapshot->accelerator != NULL ? surface_bytes(with) : 0.0);
}

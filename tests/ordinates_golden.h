/* ordinates_golden.h: stored results of two independent programs in the public cube: unit edge,
 * 16^3 cells, sigma_s 4 per metre, no absorption, g 0.7, irradiance 1. They agree to 1e-8. */
#ifndef AIR_TESTS_ORDINATES_GOLDEN_H
#define AIR_TESTS_ORDINATES_GOLDEN_H

#include "airlight/ordinates.h"

enum { ORDINATES_GOLDEN = 8 };

typedef struct ordinates_golden {
    air_ordinates_stencil stencil;
    air_ordinates_decay decay;
    air_ordinates_start start;
    uint32_t steps;
    double mean;               /* fluence, of all cells */
    double fluence, energy, a; /* in cell (7, 7, 8); energy is that of 1/16^2 W/m^2 times 256 */
    double out[3], residual;   /* through -i, -k, +k */
    double rms;                /* error of the fluence against photons, three digits */
} ordinates_golden;

static const ordinates_golden ordinates_goldens[ORDINATES_GOLDEN] = {
    {AIR_ORDINATES_LITERAL,
     AIR_ORDINATES_DECAY_PAPER,
     AIR_ORDINATES_BOUNDARY,
     10,
     0.65154250,
     0.43092002,
     0.198265687,
     0.40996341,
     {0.03410893, 0.00007044, 0.0},
     0.86349382,
     0.494},
    {AIR_ORDINATES_LITERAL,
     AIR_ORDINATES_DECAY_PAPER,
     AIR_ORDINATES_BOUNDARY,
     16,
     0.95241690,
     1.69883529,
     0.191357927,
     0.24010000,
     {0.05949955, 0.00009200, 0.00002142},
     0.76188838,
     0.563},
    {AIR_ORDINATES_LITERAL,
     AIR_ORDINATES_DECAY_PAPER,
     AIR_ORDINATES_FIRST_SCATTER,
     10,
     0.80655127,
     0.79466490,
     0.0959941331,
     0.28697439,
     {0.04675612, 0.00722071, 0.05779722},
     0.74795757,
     0.261},
    {AIR_ORDINATES_LITERAL,
     AIR_ORDINATES_DECAY_PAPER,
     AIR_ORDINATES_FIRST_SCATTER,
     16,
     1.06348659,
     1.43155565,
     0.108829862,
     0.16807000,
     {0.06732749, 0.00789528, 0.07877429},
     0.64402046,
     0.396},
    {AIR_ORDINATES_LITERAL,
     AIR_ORDINATES_DECAY_POISSON,
     AIR_ORDINATES_BOUNDARY,
     16,
     0.96226363,
     1.84109333,
     0.163940856,
     0.30119421,
     {0.05577770, 0.00004458, 0.00010103},
     0.77674358,
     0.509},
    {AIR_ORDINATES_CM,
     AIR_ORDINATES_DECAY_POISSON,
     AIR_ORDINATES_FIRST_SCATTER,
     10,
     0.63831031,
     0.64206187,
     0.0630517250,
     0.45115249,
     {0.03233038, 0.05520512, 0.11051379},
     0.70495955,
     0.305},
    {AIR_ORDINATES_CM,
     AIR_ORDINATES_DECAY_POISSON,
     AIR_ORDINATES_FIRST_SCATTER,
     16,
     0.78130518,
     0.82718665,
     0.0386649372,
     0.17856693,
     {0.04565782, 0.08306868, 0.32178910},
     0.41251092,
     0.151},
    {AIR_ORDINATES_CM,
     AIR_ORDINATES_DECAY_POISSON,
     AIR_ORDINATES_FIRST_SCATTER,
     64,
     1.03414866,
     1.35581241,
     0.00432550563,
     0.02272659,
     {0.06815770, 0.18077046, 0.52004519},
     0.02655353,
     0.206},
};

#endif

#include "core/sobol.h"

enum { BITS = 16, DIMENSIONS = 4 };

/* Primitive polynomials and initial direction numbers of dimensions 2 to 4 [Joe2008]; dimension 1
 * is van der Corput. */
typedef struct direction_seed {
    uint32_t degree, coefficients, initial[3];
} direction_seed;

static const direction_seed seeds[DIMENSIONS - 1] = {
    {1, 0, {1, 0, 0}}, {2, 1, {1, 3, 0}}, {3, 1, {1, 3, 1}}};

static void van_der_corput(uint32_t directions[BITS])
{
    for (uint32_t i = 0; i < BITS; i++) {
        directions[i] = 0x80000000u >> i;
    }
}

static void recurrence(const direction_seed *seed, uint32_t directions[BITS])
{
    for (uint32_t i = 0; i < BITS; i++) {
        if (i < seed->degree) {
            directions[i] = seed->initial[i] << (31u - i);
            continue;
        }
        const uint32_t first = directions[i - seed->degree];
        directions[i] = first ^ (first >> seed->degree);
        for (uint32_t k = 1; k < seed->degree; k++) {
            if ((seed->coefficients >> (seed->degree - 1 - k)) & 1u) {
                directions[i] ^= directions[i - k];
            }
        }
    }
}

void air_sobol_init(air_sobol *sobol)
{
    uint32_t directions[DIMENSIONS][BITS];
    van_der_corput(directions[0]);
    for (uint32_t d = 1; d < DIMENSIONS; d++) {
        recurrence(&seeds[d - 1], directions[d]);
    }
    for (uint32_t byte = 0; byte < 256; byte++) {
        for (uint32_t d = 0; d < DIMENSIONS; d++) {
            uint32_t low = 0, high = 0;
            for (uint32_t bit = 0; bit < 8; bit++) {
                if ((byte >> bit) & 1u) {
                    low ^= directions[d][bit];
                    high ^= directions[d][bit + 8];
                }
            }
            sobol->low[byte][d] = air_reverse_bits(low);
            sobol->high[byte][d] = air_reverse_bits(high);
        }
    }
}

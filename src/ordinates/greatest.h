/* greatest.h: ordinates_greatest, for the instruction set of the including file, which defines
 * ORDINATES_GREATEST as the function's name. */
#include "core/exponential.h"
#include "ordinates/run.h"

/* Two loops without branches, which compilers turn into vectors. Adding 0 makes 0 of -0. */
uint32_t ORDINATES_GREATEST(const float *x, size_t count, bool with_sign)
{
    uint32_t greatest = 0;
    for (size_t i = 0; i < count && with_sign; i++) {
        const uint32_t bits = air_float_bits(x[i] + 0.0f);
        greatest = bits > greatest ? bits : greatest;
    }
    for (size_t i = 0; i < count && !with_sign; i++) {
        const uint32_t bits = air_float_bits(x[i]) & 0x7fffffffu;
        greatest = bits > greatest ? bits : greatest;
    }
    return greatest;
}

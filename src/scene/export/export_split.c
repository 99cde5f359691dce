/* export_split.c: factors and strengths that a reader of glTF multiplies to numbers of the scene.
 */
#include <float.h>
#include <math.h>

#include "scene/export/export.h"

/* How many strengths are tried. */
enum { STRENGTHS = 64 };

/* The factor in [0, 1] next to `start` whose product is `value`; false: it comes near only. */
static bool find_factor(float value, float start, float strength, air_export_product product,
                        float *out)
{
    const float centre = fminf(start, 1.0f);
    const float tries[5] = {centre, nextafterf(centre, 0.0f), nextafterf(centre, 2.0f),
                            nextafterf(nextafterf(centre, 0.0f), 0.0f),
                            nextafterf(nextafterf(centre, 2.0f), 2.0f)};
    *out = centre;
    for (size_t i = 0; i < 5; ++i) {
        if (tries[i] <= 1.0f && product(tries[i], strength) == value) {
            *out = tries[i];
            return true;
        }
    }
    return false;
}

void air_export_split(const float color[3], air_export_product product, float out_factors[3],
                      float *out_strength)
{
    const float peak = fmaxf(color[0], fmaxf(color[1], color[2]));
    int exponent = 0;
    out_factors[0] = out_factors[1] = out_factors[2] = 1.0f;
    *out_strength = 0.0f;
    if (!(peak > 0.0f))
        return;
    (void)frexpf(peak, &exponent);
    float strength = fminf(ldexpf(683.0f, exponent), FLT_MAX);
    for (size_t i = 0; i < STRENGTHS; ++i, strength = nextafterf(strength, FLT_MAX)) {
        const double unit = (double)product(1.0f, strength);
        bool exact = true;
        float factors[3];
        for (size_t c = 0; c < 3; ++c)
            exact &= find_factor(color[c], (float)((double)color[c] / unit), strength, product,
                                 &factors[c]);
        for (size_t c = 0; c < 3 && (exact || i == 0); ++c)
            out_factors[c] = factors[c];
        if (exact || i == 0)
            *out_strength = strength;
        if (exact)
            return;
    }
}

/* dom_baseline.c: how solvers in harmonics alone see a beam [Elek2014, section 5]. */
#include <math.h>

#include "airlight/ordinates_dom.h"
#include "core/harmonics.h"
#include "core/vec.h"

void air_dom_params_shdom(air_dom_params *params, int bands)
{
    const int polar = bands + bands % 2, azimuths = (2 * bands + 3) / 4 * 4;
    params->bands = bands;
    params->polar = polar;
    params->azimuths = azimuths;
    params->delta_m = false;
    params->diamond = false;
}

void air_dom_hanning_beam(int bands, const double dir[3], const double irradiance[3], double lobe,
                          float *out_moments)
{
    double y[AIR_SH_COUNT_MAX], power = 1.0;
    air_sh_evaluate(bands, dir, y);
    for (int l = 0; l < bands; l++) {
        const double window = 0.5 * (1.0 + cos(AIR_PI * l / bands));
        for (int i = l * l; i < (l + 1) * (l + 1); i++) {
            for (int c = 0; c < 3; c++) {
                out_moments[i * AIR_DOM_STRIDE + c] =
                    (float)(irradiance[c] * power * window * y[i]);
            }
            out_moments[i * AIR_DOM_STRIDE + 3] = 0.0f;
        }
        power *= lobe;
    }
}

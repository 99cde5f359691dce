/* emitter_fluence.c: fluences around area patches and under directional light. */
#include <math.h>

#include "core/host.h"
#include "core/vec.h"
#include "impulse/multiple.h"

double air_impulse_area_fluence(int k, double r, double theta_s)
{
    const impulse_quality quality = impulse_quality_fine();
    impulse_curves curves; /* 240 KB */
    double c[(IMPULSE_K + 1) * AIR_IMPULSE_ORDER], lobe[AIR_IMPULSE_ORDER];
    if (k <= 1) {
        air_impulse_area(r, theta_s, 0.0, 1, c);
        return sqrt(4.0 * AIR_PI) * c[0];
    }
    impulse_curves_fluences(k - 1, &curves);
    impulse_point_multiple(&quality, &curves, r, k, k, AIR_IMPULSE_ORDER, c, AIR_IMPULSE_ORDER);
    air_zh_clamped_cosine(AIR_IMPULSE_ORDER, lobe);
    return exp(-r) *
           air_zh_product(AIR_IMPULSE_ORDER, lobe, c + (size_t)k * AIR_IMPULSE_ORDER, cos(theta_s));
}

air_status air_impulse_directional_fluences(air_context *context, int k_max, double tau,
                                            double *out)
{
    impulse_half_space *const half = air_allocate(context, 1, sizeof *half);
    double *const matrix = air_allocate(context, (size_t)HALF_COUNT * HALF_COUNT, sizeof(double));
    double c[IMPULSE_K + 1];
    air_status status = AIR_OK;
    if (half == NULL || matrix == NULL) {
        status = air_fail_memory(context, "impulse fluences");
    } else {
        impulse_half_space_solve(k_max, half, matrix);
        impulse_directional_multiple(half, tau, 1, k_max, 1, c, 1);
        out[0] = exp(-tau);
        for (int k = 1; k <= k_max; k++) {
            out[k] = exp(-tau) * sqrt(4.0 * AIR_PI) * c[k];
        }
    }
    air_free(context, matrix);
    air_free(context, half);
    return status;
}

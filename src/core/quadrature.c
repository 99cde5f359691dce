/* quadrature.c: Gauss-Legendre nodes as roots of Legendre polynomials. */
#include "core/quadrature.h"

#include <math.h>

#include "core/vec.h"

/* P_n(x) and P_n'(x) by the three-term recurrence. |x| < 1. */
static double legendre(size_t n, double x, double *out_derivative)
{
    double previous = 1.0, value = x;
    for (size_t k = 2; k <= n; ++k) {
        const double order = (double)k;
        const double next = ((2.0 * order - 1.0) * x * value - (order - 1.0) * previous) / order;
        previous = value;
        value = next;
    }
    *out_derivative = (double)n * (previous - x * value) / (1.0 - x * x);
    return value;
}

void air_gauss_legendre(size_t count, double *out_nodes, double *out_weights)
{
    for (size_t i = 0; i < (count + 1) / 2; ++i) {
        /* Tricomi's estimate of the i-th largest root is good to O(count^-4); Newton squares the
         * error each time. */
        const double n = (double)count;
        double x = (1.0 - (n - 1.0) / (8.0 * n * n * n)) *
                   cos(AIR_PI * (4.0 * (double)i + 3.0) / (4.0 * n + 2.0));
        double derivative = 0.0;
        for (int step = 0; step < 8; ++step) {
            const double change = legendre(count, x, &derivative) / derivative;
            x -= change;
            if (fabs(change) < 1e-15) {
                break;
            }
        }
        if (2 * i + 1 == count) {
            x = 0.0; /* the middle root of an odd rule */
        }
        (void)legendre(count, x, &derivative);
        const double weight = 2.0 / ((1.0 - x * x) * derivative * derivative);
        out_nodes[i] = -x;
        out_nodes[count - 1 - i] = x;
        out_weights[i] = weight;
        out_weights[count - 1 - i] = weight;
    }
}

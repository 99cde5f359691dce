/* Exponentials over arrays, compiled once for each instruction set; LANES_PROBE is the name of the
 * table. Counts are multiples of 8. */
#include "lanes_probe.h"

#include "core/lanes_exponential.h"

static void probe_exp(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        lanes_store(out + i, air_lanes_exp(lanes_load(x + i)));
    }
}

static void probe_transmittance(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        lanes loss;
        lanes_store(out + i, air_lanes_transmittance(lanes_load(x + i), &loss));
    }
}

static void probe_loss(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        lanes loss;
        (void)air_lanes_transmittance(lanes_load(x + i), &loss);
        lanes_store(out + i, loss);
    }
}

static void probe_log(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        lanes_store(out + i, air_lanes_log(lanes_load(x + i)));
    }
}

const lanes_probe LANES_PROBE = {probe_exp, probe_transmittance, probe_loss, probe_log};

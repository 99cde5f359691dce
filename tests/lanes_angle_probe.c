/* Compiled once for each instruction set and precision (LANES_ANGLE_FLOAT); LANES_ANGLE_PROBE is
 * the name of the table. */
#include "lanes_angle_probe.h"

#ifdef LANES_ANGLE_FLOAT
#include "core/lanes_float.h"
#else
#include "core/lanes_double.h"
#endif

#include "core/lanes_angle.h"

static lanes load(const double *x)
{
    lane_real out[LANES];
    for (int i = 0; i < LANES; i++) {
        out[i] = (lane_real)x[i];
    }
    return lanes_load(out);
}

static void store(double *x, lanes a)
{
    lane_real from[LANES];
    lanes_store(from, a);
    for (int i = 0; i < LANES; i++) {
        x[i] = (double)from[i];
    }
}

static void probe_inverse_root(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        store(out + i, lanes_inverse_root(load(x + i)));
    }
}

static void probe_inverse(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        store(out + i, lanes_inverse(load(x + i)));
    }
}

static void probe_root(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        store(out + i, lanes_root(load(x + i)));
    }
}

static void probe_angle(const double *x, const double *y, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        store(out + i, plane_angle(plane_unit((lanes_plane){load(x + i), load(y + i)})));
    }
}

#ifdef LANES_ANGLE_FLOAT
static void probe_exp2(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        store(out + i, lanes_exp2(load(x + i)));
    }
}

static void probe_log2(const double *x, double *out, size_t count)
{
    for (size_t i = 0; i < count; i += LANES) {
        store(out + i, lanes_log2(load(x + i)));
    }
}

const lanes_angle_probe LANES_ANGLE_PROBE = {probe_inverse_root, probe_inverse, probe_root,
                                             probe_angle,        probe_exp2,    probe_log2};
#else
const lanes_angle_probe LANES_ANGLE_PROBE = {probe_inverse_root, probe_inverse, probe_root,
                                             probe_angle,        NULL,          NULL};
#endif

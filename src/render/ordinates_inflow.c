/* ordinates_inflow.c: which of the sky is followed from the box's faces on. */
#include <math.h>
#include <string.h>

#include "airlight/ordinates_dom.h"
#include "core/harmonics.h"
#include "render/ordinates_sources.h"

enum { CHANNELS = 4, PROBES = 128 };

/* How far below 0 a series may dip, as a share of its mean: solvers cut it there. */
#define DIP 0.02

static void add_moments(const ord_source *source, int bands, double sign, double *moments)
{
    const double dir[3] = {(double)source->place.x, (double)source->place.y,
                           (double)source->place.z};
    const double power[3] = {(double)source->power.x, (double)source->power.y,
                             (double)source->power.z};
    double y[AIR_SH_COUNT_MAX], lobe = sign;
    air_sh_evaluate(bands, dir, y);
    for (int l = 0, m = 0; l < bands; l++) {
        for (; m < (l + 1) * (l + 1); m++) {
            for (int c = 0; c < 3; c++) {
                moments[m * CHANNELS + c] += lobe * y[m] * power[c];
            }
        }
        lobe *= (double)source->lobe;
    }
}

/* Does the series stay above 0 in directions all over the sphere, along a spiral? */
static bool is_positive(int bands, const double *moments)
{
    const double golden = AIR_PI * (3.0 - sqrt(5.0)), y00 = sqrt(0.25 / AIR_PI);
    for (int i = 0; i < PROBES; i++) {
        const double z = 1.0 - (2.0 * i + 1.0) / PROBES, r = sqrt(1.0 - z * z);
        const double dir[3] = {r * cos(golden * i), r * sin(golden * i), z};
        double y[AIR_SH_COUNT_MAX];
        air_sh_evaluate(bands, dir, y);
        for (int c = 0; c < 3; c++) {
            double sum = 0.0;
            for (int m = 0; m < bands * bands; m++) {
                sum += y[m] * moments[m * CHANNELS + c];
            }
            if (sum < -DIP * moments[c] * y00) {
                return false;
            }
        }
    }
    return true;
}

/* The one of those that enter by the faces which is brightest for its size; SIZE_MAX: there is
 * none. */
static size_t brightest(const ord_source_list *sources)
{
    size_t found = SIZE_MAX;
    float most = -1.0f;
    for (size_t i = 0; i < sources->count; i++) {
        const ord_source *const s = &sources->items[i];
        const float radiance = s->inflow ? vec3_max(s->power) / s->solid_angle : -1.0f;
        if (radiance > most) {
            most = radiance;
            found = i;
        }
    }
    return found;
}

bool ord_inflow_choose(ord_source_list *sources, int bands, float *out_moments)
{
    double moments[AIR_SH_COUNT_MAX * CHANNELS] = {0.0};
    size_t last;
    for (size_t i = 0; i < sources->count; i++) {
        sources->items[i].inflow = sources->items[i].solid_angle > 0.0f;
        if (sources->items[i].inflow) {
            add_moments(&sources->items[i], bands, 1.0, moments);
        }
    }
    while ((last = brightest(sources)) != SIZE_MAX && !is_positive(bands, moments)) {
        sources->items[last].inflow = false;
        add_moments(&sources->items[last], bands, -1.0, moments);
    }
    for (int i = 0; i < bands * bands * CHANNELS; i++) {
        out_moments[i] = (float)moments[i];
    }
    return last != SIZE_MAX;
}

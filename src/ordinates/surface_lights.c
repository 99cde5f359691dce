/* surface_lights.c: what a light sees of surfaces, as few lights. */
#include <math.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"

/* ---- samples ---- */

static bool within(const float *x, size_t sample, float most)
{
    for (size_t k = 0; x != NULL && k < 3; k++) {
        if (!(x[3 * sample + k] >= 0.0f && x[3 * sample + k] <= most)) {
            return false;
        }
    }
    return true;
}

/* What of a sample is out of range, or NULL. */
static const char *sample_fault(const air_surface_samples *samples, size_t i)
{
    const air_vec3 normal = vec3_load(samples->normal + 3 * i);
    if (!vec3_is_finite(vec3_load(samples->position + 3 * i))) {
        return "a finite position";
    }
    if (!(fabsf(vec3_length(normal) - 1.0f) <= 0.01f)) {
        return "a unit normal";
    }
    if (!within(samples->albedo, i, 1.0f)) {
        return "an albedo in [0, 1]";
    }
    if (!within(samples->irradiance, i, 1e30f)) {
        return "an irradiance from 0 to 1e30";
    }
    if (!within(samples->transmittance, i, 1.0f)) {
        return "a transmittance in [0, 1]";
    }
    if (samples->area != NULL && !(samples->area[i] >= 0.0f && samples->area[i] <= 1e30f)) {
        return "an area from 0 to 1e30";
    }
    return NULL;
}

static air_status check(air_context *context, const air_surface_samples *samples, size_t count,
                        double distance_m)
{
    if (count - 1 >= AIR_ORDINATES_LIGHTS_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "surface lights: %zu are asked for: expected 1 to %d", count,
                        AIR_ORDINATES_LIGHTS_MAX);
    }
    if (!(distance_m > 0.0 && distance_m <= 1e30)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "surface lights: the distance is %g: expected above 0, up to 1e30",
                        distance_m);
    }
    if (samples->count < 1 || samples->position == NULL || samples->normal == NULL ||
        samples->irradiance == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "surface lights: expected a sample at least, with positions, normals and "
                        "irradiances");
    }
    for (size_t i = 0; i < samples->count; i++) {
        const char *fault = sample_fault(samples, i);
        if (fault != NULL) {
            return air_fail(context, AIR_ERROR_ARGUMENT, "surface lights: sample %zu: expected %s",
                            i, fault);
        }
    }
    return AIR_OK;
}

/* Flux, and its luminance. */
static double sample_flux(const air_surface_samples *samples, size_t i, double out[3])
{
    for (size_t k = 0; k < 3; k++) {
        const size_t at = 3 * i + k;
        out[k] = (double)samples->irradiance[at];
        out[k] *= samples->albedo != NULL ? (double)samples->albedo[at] : 1.0;
        out[k] *= samples->transmittance != NULL ? (double)samples->transmittance[at] : 1.0;
        out[k] *= samples->area != NULL ? (double)samples->area[i] : 1.0;
    }
    return 0.2126 * out[0] + 0.7152 * out[1] + 0.0722 * out[2];
}

/* ---- strata ---- */

/* Sums over pieces of samples. Positions count from the first, so that what lies far from the
 * origin keeps its digits. */
typedef struct stratum {
    double weight, flux[3];
    double origin[3], position[3], square; /* weighted, and |position|^2 */
    double normal[3], area;
    double heaviest; /* of all pieces, that one's normal: where normals cancel */
    double heaviest_normal[3];
} stratum;

static void load3(const float *from, size_t i, double out[3])
{
    vec3_store64(out, vec3_load(from + 3 * i));
}

static void stratum_add(stratum *self, const air_surface_samples *samples, size_t i, double part,
                        double weight, const double flux[3])
{
    double position[3], normal[3];
    load3(samples->position, i, position);
    load3(samples->normal, i, normal);
    if (self->weight == 0.0) {
        air_copy3(position, self->origin);
    }
    air_subtract3(position, self->origin, position);
    self->weight += part * weight;
    air_along3(self->flux, part, flux, self->flux);
    air_along3(self->position, part * weight, position, self->position);
    air_along3(self->normal, part * weight, normal, self->normal);
    self->square += part * weight * air_dot3(position, position);
    self->area += part * weight * (samples->area != NULL ? (double)samples->area[i] : 0.0);
    if (part * weight > self->heaviest) {
        self->heaviest = part * weight;
        air_copy3(normal, self->heaviest_normal);
    }
}

/* A disk of radius R has |x|^2 = R^2 / 2 on average; and samples are disks themselves. */
static void stratum_finish(const stratum *self, double distance_m, air_surface_light *out)
{
    const double none[3] = {0.0, 0.0, 0.0};
    double mean[3];
    const double scale = 1.0 / self->weight;
    air_along3(none, scale, self->position, mean);
    air_along3(self->origin, 1.0, mean, out->position);
    air_copy3(self->flux, out->flux);
    const bool cancelled = !(air_length3(self->normal) > 1e-6 * self->weight);
    const double *normal = cancelled ? self->heaviest_normal : self->normal;
    air_along3(none, 1.0 / air_length3(normal), normal, out->normal);
    const double variance = double_max(0.0, self->square * scale - air_dot3(mean, mean));
    out->radius_m = sqrt(2.0 * variance + self->area * scale / AIR_PI);
    const double r = double_max(distance_m, out->radius_m);
    out->lobe = 2.0 * r / (r + sqrt(r * r + out->radius_m * out->radius_m));
}

air_status air_surface_lights_choose(air_context *context, const air_surface_samples *samples,
                                     size_t count, double distance_m, air_surface_light *out)
{
    const air_status status = check(context, samples, count, distance_m);
    if (status != AIR_OK) {
        return status;
    }
    double total = 0.0, flux[3], before = 0.0;
    for (size_t i = 0; i < samples->count; i++) {
        total += sample_flux(samples, i, flux);
    }
    const bool dark = !(total > 1e-290); /* so that shares of it have their digits */
    total = dark ? (double)samples->count : total;
    stratum current = {.weight = 0.0};
    size_t n = 0;
    for (size_t i = 0; i < samples->count; i++) {
        const double luminance = sample_flux(samples, i, flux), weight = dark ? 1.0 : luminance;
        const double after = before + weight;
        double from = before; /* the sample is cut at every end of a stratum within it */
        for (double end = total * (double)(n + 1) / (double)count; n + 1 < count && end < after;
             end = total * (double)(n + 1) / (double)count) {
            if (end > from) { /* else it ends with the sample before */
                stratum_add(&current, samples, i, (end - from) / weight, weight, flux);
            }
            stratum_finish(&current, distance_m, &out[n++]);
            memset(&current, 0, sizeof current);
            from = end;
        }
        if (weight > 0.0 && after > from) {
            const double part = from == before ? 1.0 : (after - from) / weight;
            stratum_add(&current, samples, i, part, weight, flux);
        }
        before = after;
    }
    stratum_finish(&current, distance_m, &out[n]);
    return AIR_OK;
}

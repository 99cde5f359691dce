/* pick.c: see pick.h. */
#include "scene/lights/pick.h"

#include "scene/lights/cdf.h"
#include "scene/lights/emissive.h"
#include "scene/lights/environment.h"
#include "scene/lights/punctual.h"

/* At worst, where one light gives everything, a quarter of the samples is lost. */
static const double PICK_UNIFORM = 0.25;

/* ---- flux ---- */

double air_light_flux(const air_light_table *table, const air_light *light)
{
    const double color = (double)vec3_mean(light->color);
    const double disk = AIR_PI * (double)table->scene_radius * (double)table->scene_radius;
    switch (light->kind) {
    case AIR_LIGHT_POINT:
        return 4.0 * AIR_PI * color;
    case AIR_LIGHT_SPOT:
        return air_spot_solid_angle(light) * color;
    case AIR_LIGHT_PROJECTOR:
        return (double)vec3_mean(vec3_mul(air_projector_solid_angle(light), light->color));
    case AIR_LIGHT_COLLIMATED:
        return color * (light->window_count > 0 ? fmin(disk, air_windows_area(light)) : disk);
    case AIR_LIGHT_POLYGON:
        return AIR_PI * (double)light->area * (double)vec3_mean(air_emissive_mean(light)) *
               (light->one_sided ? 1.0 : 2.0);
    case AIR_LIGHT_ENVIRONMENT:
        return disk * color *
               (light->environment != NULL ? light->environment->integral : 4.0 * AIR_PI);
    }
    return 0.0;
}

/* ---- building ---- */

/* Raises the weights of lights that give something: explicit ones one by one, emissive triangles as
 * a group. */
static void add_uniform_share(const air_light_table *table, double *weights, double total)
{
    double emissive = 0.0;
    size_t groups = 0;
    for (size_t i = 0; i < table->count; i++) {
        if (i >= table->explicit_count) {
            emissive += weights[i];
        } else if (weights[i] > 0.0) {
            groups++;
        }
    }
    groups += emissive > 0.0 ? 1 : 0;
    const double each = PICK_UNIFORM / (1.0 - PICK_UNIFORM) * total / (double)groups;
    for (size_t i = 0; i < table->count; i++) {
        if (i >= table->explicit_count) {
            weights[i] *= emissive > 0.0 ? 1.0 + each / emissive : 0.0;
        } else if (weights[i] > 0.0) {
            weights[i] += each;
        }
    }
}

static double sum_of(const double *weights, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += weights[i];
    }
    return sum;
}

air_status air_pick_build(air_context *context, air_light_table *table)
{
    if (table->count == 0) {
        return AIR_OK;
    }
    double *weights = air_allocate(context, table->count, sizeof *weights);
    table->cdf = air_allocate(context, table->count, sizeof *table->cdf);
    if (weights == NULL || table->cdf == NULL) {
        air_free(context, weights);
        return air_fail_memory(context, "lights");
    }
    for (size_t i = 0; i < table->count; i++) {
        weights[i] = air_light_flux(table, &table->entries[i]);
    }
    const double power = sum_of(weights, table->count);
    if (power > 0.0) {
        add_uniform_share(table, weights, power);
    } else { /* all black: any choice will do */
        for (size_t i = 0; i < table->count; i++) {
            weights[i] = 1.0;
        }
    }
    const double total = sum_of(weights, table->count);
    double sum = 0.0;
    for (size_t i = 0; i < table->count; i++) {
        sum += weights[i];
        table->cdf[i] = (float)(sum / total);
    }
    air_free(context, weights);
    return AIR_OK;
}

/* ---- picking ---- */

uint32_t air_light_pick(const air_light_table *table, float u, float *out_probability, float *out_u)
{
    float rest = u;
    const size_t entry = air_cdf_choose(table->cdf, table->count, &rest);
    *out_probability = table->cdf[entry] - air_cdf_start(table->cdf, entry);
    *out_u = rest;
    return (uint32_t)entry;
}

float air_light_pick_probability(const air_light_table *table, uint32_t entry)
{
    return table->cdf[entry] - air_cdf_start(table->cdf, entry);
}

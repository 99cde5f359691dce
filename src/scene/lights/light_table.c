/* light_table.c: the kinds of light behind one set of functions. */
#include "scene/lights/light_table.h"

#include "scene/lights/environment.h"
#include "scene/lights/polygon.h"
#include "scene/lights/punctual.h"
#include "scene/lights/quadric_lamp.h"

size_t air_light_quadric_count(const air_light_table *table)
{
    size_t count = 0;
    for (size_t i = table->explicit_count; i < table->count; i++) {
        count += table->entries[i].quadric != NULL ? 1 : 0;
    }
    return count;
}

size_t air_light_triangle_count(const air_light_table *table)
{
    return table->count - table->explicit_count - air_light_quadric_count(table);
}

void air_light_sample(const air_light_table *table, uint32_t entry, float u1, float u2,
                      air_light_point *out)
{
    const air_light *light = &table->entries[entry];
    *out = (air_light_point){.entry = entry};
    switch (light->kind) {
    case AIR_LIGHT_POINT:
    case AIR_LIGHT_SPOT:
    case AIR_LIGHT_COLLIMATED:
    case AIR_LIGHT_PROJECTOR:
        air_punctual_sample(light, out);
        break;
    case AIR_LIGHT_POLYGON:
        if (light->quadric != NULL) {
            air_quadric_lamp_sample(light, table, u1, u2, out);
        } else {
            air_polygon_sample(light, u1, u2, out);
        }
        break;
    case AIR_LIGHT_ENVIRONMENT:
        air_environment_sample(light, u1, u2, out);
        break;
    }
}

bool air_light_connect(const air_light_table *table, const air_light_point *light_point,
                       air_vec3 point, air_connection *out)
{
    const air_light *light = &table->entries[light_point->entry];
    switch (light->kind) {
    case AIR_LIGHT_POINT:
    case AIR_LIGHT_SPOT:
    case AIR_LIGHT_PROJECTOR:
        return air_punctual_connect(light, point, out);
    case AIR_LIGHT_COLLIMATED:
        return air_collimated_connect(light, point, out);
    case AIR_LIGHT_POLYGON:
        return light->quadric != NULL
                   ? air_quadric_lamp_connect(light, table, light_point, point, out)
                   : air_polygon_connect(light, light_point, point, out);
    case AIR_LIGHT_ENVIRONMENT:
        *out = (air_connection){light_point->dir, INFINITY, light_point->value, light_point->pdf};
        return light_point->pdf > 0.0f;
    }
    return false;
}

float air_light_hit_pdf(const air_light_table *table, uint32_t entry, air_vec3 from, air_vec3 dir,
                        float distance)
{
    const air_light *light = &table->entries[entry];
    if (light->kind == AIR_LIGHT_ENVIRONMENT) {
        return air_environment_pdf(light, dir);
    }
    return light->quadric != NULL ? air_quadric_lamp_hit_pdf(light, table, from, dir, distance)
                                  : air_polygon_hit_pdf(light, dir, distance);
}

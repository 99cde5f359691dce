/* quadric_lamp.c: see quadric_lamp.h. */
#include "scene/lights/quadric_lamp.h"

#include "core/angle.h"
#include "core/triple.h"
#include "core/warp.h"
#include "scene/texture.h"

/* ---- the entry ---- */

void air_quadric_lamp_build(const air_mesh *mesh, const air_material *material, uint32_t owner,
                            air_light *out)
{
    *out = (air_light){.kind = AIR_LIGHT_POLYGON,
                       .color = material->emission,
                       .quadric = mesh->quadric,
                       .inward = mesh->flip,
                       .area = (float)air_quadric_area(mesh->quadric),
                       .one_sided = !material->double_sided,
                       .camera_visible = (mesh->mask & AIR_MASK_CAMERA) != 0,
                       .casts_shadow = true,
                       .owner = owner};
    if (material->emission_slot.texture != NULL) {
        static const float corners[3][2] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}};
        out->emission_texture = material->emission_slot.texture;
        for (int k = 0; k < 3; k++) {
            air_texture_slot_uv(&material->emission_slot, corners[k], out->uv[k]);
        }
    }
}

/* The radiance of a local place. */
static air_vec3 radiance_at(const air_light *light, const double local[3])
{
    float own[2], uv[2];
    if (light->emission_texture == NULL) {
        return light->color;
    }
    air_quadric_uv(light->quadric->shape, local, own);
    air_light_uv(light, own[0], own[1], uv);
    return vec3_mul(light->color, air_texture_rgb(light->emission_texture, uv[0], uv[1]));
}

air_vec3 air_quadric_lamp_mean(const air_light *light)
{
    enum { STEPS = 64 };
    const air_quadric *quadric = light->quadric;
    air_vec3 sum = vec3_set1(0.0f);
    float weights = 0.0f;
    if (light->emission_texture == NULL) {
        return light->color;
    }
    for (int i = 0; i < STEPS * STEPS; i++) {
        double local[3];
        air_quadric_sample(quadric->shape, ((float)(i / STEPS) + 0.5f) / STEPS,
                           ((float)(i % STEPS) + 0.5f) / STEPS, local);
        const float weight = (float)air_quadric_stretch(quadric, local);
        sum = vec3_madd(sum, weight, radiance_at(light, local));
        weights += weight;
    }
    return vec3_scale(sum, 1.0f / weights);
}

/* ---- by area ---- */

/* Of a place drawn uniformly in local area, per area in the world. */
static double area_pdf(const air_quadric *quadric, const double local[3])
{
    return 1.0 / (air_quadric_local_area(quadric->shape) * air_quadric_stretch(quadric, local));
}

static air_vec3 front_normal(const air_light *light, const double local[3])
{
    const air_vec3 normal = air_quadric_normal(light->quadric, local);
    return light->inward ? vec3_neg(normal) : normal;
}

/* Are places drawn again by what a point outside sees? From inside it sees those by area. */
static bool goes_by_sight(const air_light *light, const air_light_table *table)
{
    return table->spheres_by_sight && light->quadric->shape == AIR_RAY_SPHERE &&
           !(light->inward && light->one_sided);
}

/* What else belongs to a place that was drawn. */
static void finish_place(const air_light *light, const double local[3], air_light_point *out)
{
    out->normal = front_normal(light, local);
    out->value = radiance_at(light, local);
    out->pdf = (float)area_pdf(light->quadric, local);
}

void air_quadric_lamp_sample(const air_light *light, const air_light_table *table, float u1,
                             float u2, air_light_point *out)
{
    const bool sight = goes_by_sight(light, table);
    double local[3];
    out->curved = true;
    out->u[0] = u1;
    out->u[1] = u2;
    if (sight && table->spheres_unplaced) {
        return;
    }
    air_quadric_sample(light->quadric->shape, u1, u2, local);
    out->position = air_quadric_to_world(light->quadric, local);
    if (!sight) {
        finish_place(light, local, out);
    }
}

/* Per solid angle, of a place of that density per area. */
static float solid_angle_pdf(const air_light *light, air_vec3 normal, float pdf, air_vec3 dir,
                             float distance)
{
    const float toward = -vec3_dot(normal, dir); /* > 0: dir meets the front */
    const float cosine = light->one_sided ? toward : fabsf(toward);
    return cosine > 0.0f ? pdf * distance * distance / cosine : 0.0f;
}

static bool connect_by_area(const air_light *light, const air_light_point *light_point,
                            air_vec3 point, air_connection *out)
{
    const air_vec3 to_light = vec3_sub(light_point->position, point);
    const float distance = vec3_length(to_light);
    if (!(distance > 0.0f)) {
        return false;
    }
    out->dir = vec3_scale(to_light, 1.0f / distance);
    out->distance = distance;
    out->incident = light_point->value;
    out->pdf = solid_angle_pdf(light, light_point->normal, light_point->pdf, out->dir, distance);
    return out->pdf > 0.0f;
}

/* ---- by sight ---- */

/* The sphere as a point sees it, before the map. */
typedef struct sight {
    double from[3];
    double distance;
    double axis[3]; /* unit, to the centre */
    double opening; /* 1 - the cosine of the cone's half angle */
} sight;

/* Points nearer to the surface than this share of the radius count as on it: rounding must not
 * decide on which side they are. */
static const double NEAR_SHARE = 1e-4;

/* False if points are to be drawn by area instead. */
static bool look(const air_light *light, const air_light_table *table, air_vec3 point, sight *out)
{
    double world[3];
    vec3_store64(world, point);
    if (!goes_by_sight(light, table)) {
        return false;
    }
    air_quadric_to_local(light->quadric, world, out->from);
    out->distance = air_length3(out->from);
    if (!(out->distance > 1.0 + NEAR_SHARE)) {
        return false;
    }
    const double inverse = 1.0 / out->distance, sine2 = inverse * inverse;
    for (int i = 0; i < 3; i++) {
        out->axis[i] = -out->from[i] * inverse;
    }
    out->opening = sine2 / (1.0 + sqrt(1.0 - sine2));
    return true;
}

/* The map A takes a solid angle about the unit direction w to |det A| / |A w|^3 of it. */
static float sight_pdf(const air_light *light, const sight *seen, double length)
{
    const double local = 1.0 / (2.0 * AIR_PI * seen->opening);
    return (float)(local * length * length * length / fabs(light->quadric->determinant));
}

/* A direction within the cone, uniform in local solid angle, as sample_cone in doubles; and how far
 * the sphere is along it. */
static double sample_sight(const sight *seen, const float u[2], double out_dir[3])
{
    double s[3], t[3], sine, cosine;
    air_axes_across(seen->axis, s, t);
    air_sincos_turn64((double)u[1], &sine, &cosine);
    const double h = (double)u[0] * seen->opening, r2 = h * (2.0 - h), r = sqrt(r2);
    for (int i = 0; i < 3; i++) {
        out_dir[i] = (1.0 - h) * seen->axis[i] + r * (cosine * s[i] + sine * t[i]);
    }
    /* at the rim rounding decides: the place nearest to the line */
    const double across2 = seen->distance * seen->distance * r2;
    return seen->distance * (1.0 - h) - sqrt(double_max(1.0 - across2, 0.0));
}

static void connect_by_sight(const air_light *light, const sight *seen,
                             const air_light_point *light_point, air_connection *out)
{
    double dir[3], world[3], local[3];
    const double t = sample_sight(seen, light_point->u, dir);
    air_quadric_dir_to_world(light->quadric, dir, world);
    const double length = air_length3(world), inverse = 1.0 / length;
    out->dir =
        vec3((float)(world[0] * inverse), (float)(world[1] * inverse), (float)(world[2] * inverse));
    out->distance = (float)(t * length);
    air_along3(seen->from, t, dir, local);
    out->incident = radiance_at(light, local);
    out->pdf = sight_pdf(light, seen, length);
}

/* A place that was drawn to be seen is one by area after all. */
static bool connect_by_area_instead(const air_light *light, air_light_point drawn, air_vec3 point,
                                    air_connection *out)
{
    double local[3];
    air_quadric_sample(light->quadric->shape, drawn.u[0], drawn.u[1], local);
    drawn.position = air_quadric_to_world(light->quadric, local);
    finish_place(light, local, &drawn);
    return connect_by_area(light, &drawn, point, out);
}

/* ---- both ---- */

bool air_quadric_lamp_connect(const air_light *light, const air_light_table *table,
                              const air_light_point *light_point, air_vec3 point,
                              air_connection *out)
{
    sight seen;
    if (look(light, table, point, &seen)) {
        connect_by_sight(light, &seen, light_point, out);
        return true;
    }
    return goes_by_sight(light, table) ? connect_by_area_instead(light, *light_point, point, out)
                                       : connect_by_area(light, light_point, point, out);
}

float air_quadric_lamp_hit_pdf(const air_light *light, const air_light_table *table, air_vec3 from,
                               air_vec3 dir, float distance)
{
    const air_quadric *quadric = light->quadric;
    sight seen;
    if (look(light, table, from, &seen)) {
        double world[3], local[3];
        vec3_store64(world, dir);
        air_quadric_dir_to_local(quadric, world, local);
        return sight_pdf(light, &seen, 1.0 / air_length3(local));
    }
    const float origin[3] = {from.x, from.y, from.z}, along[3] = {dir.x, dir.y, dir.z};
    air_quadric_hit hits[2];
    const size_t count = air_quadric_intersect(quadric, origin, along, hits);
    if (count == 0) {
        return 0.0f;
    }
    const bool second =
        count == 2 && fabs(hits[1].t - (double)distance) < fabs(hits[0].t - (double)distance);
    const double *local = hits[second ? 1 : 0].local;
    return solid_angle_pdf(light, front_normal(light, local), (float)area_pdf(quadric, local), dir,
                           distance);
}

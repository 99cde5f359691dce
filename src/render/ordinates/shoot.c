/* shoot.c: photons as they leave lights. */
#include <math.h>

#include "core/warp.h"
#include "render/ordinates/photons.h"
#include "scene/lights/light_table.h"
#include "scene/lights/pick.h"
#include "scene/lights/punctual.h"

enum { SEED = 0x6f726473 };

/* The share of parallel photons that go to the domain: few of the others come to shine on it. */
#define DOMAIN_SHARE 0.75f

/* Where parallel light is looked at: in the domain's silhouette evenly, and all round it, beyond
 * its diagonal ever less so, as what is far away sends it less. */
typedef struct ord_disk {
    air_vec3 center, scene_center, half; /* half the domain's edges */
    float inner, outer, depth;           /* depth: of the start before the scene's centre */
    float area; /* of the inner disk, plus what the rest counts as much as */
} ord_disk;

static ord_disk disk_of(const ord_space *space)
{
    const ord_domain *const d = space->domain;
    const air_light_table *const table = &space->path->snapshot->lights;
    ord_disk disk;
    disk.half = vec3_scale(vec3((float)(ptrdiff_t)d->size[0], (float)(ptrdiff_t)d->size[1],
                                (float)(ptrdiff_t)d->size[2]),
                           0.5f * d->cell_m);
    disk.center = ord_domain_world(d, disk.half);
    disk.scene_center = table->scene_center;
    disk.outer = vec3_length(vec3_sub(disk.center, table->scene_center)) +
                 float_max(table->scene_radius, vec3_length(disk.half));
    disk.inner = float_min(2.0f * vec3_length(disk.half), disk.outer);
    disk.depth = table->scene_radius * 1.001f;
    disk.area = AIR_PI_F * disk.inner * disk.inner * (1.0f + 2.0f * logf(disk.outer / disk.inner));
    return disk;
}

/* Areas of the domain's faces across each axis as seen along a direction. */
static air_vec3 face_areas(const ord_disk *disk, air_vec3 dir)
{
    const air_vec3 h = disk->half;
    return vec3_scale(
        vec3(fabsf(dir.x) * h.y * h.z, fabsf(dir.y) * h.z * h.x, fabsf(dir.z) * h.x * h.y), 4.0f);
}

/* Does the line through a point meet the domain? */
static bool in_silhouette(const ord_disk *disk, air_vec3 point, air_vec3 dir)
{
    const air_vec3 p = vec3_sub(point, disk->center);
    const float at[3] = {p.x, p.y, p.z}, d[3] = {dir.x, dir.y, dir.z};
    const float half[3] = {disk->half.x, disk->half.y, disk->half.z};
    float t0 = -HUGE_VALF, t1 = HUGE_VALF;
    for (int axis = 0; axis < 3; axis++) {
        if (fabsf(d[axis]) < 1e-7f) {
            t1 = fabsf(at[axis]) > half[axis] ? t0 : t1;
            continue;
        }
        const float a = (-half[axis] - at[axis]) / d[axis], b = (half[axis] - at[axis]) / d[axis];
        t0 = float_max(t0, float_min(a, b));
        t1 = float_min(t1, float_max(a, b));
    }
    return t0 < t1;
}

/* A point of the faces that light along dir enters by. */
static air_vec3 point_on_faces(const ord_disk *disk, air_vec3 dir, air_vec3 areas, const float u[2])
{
    const float sum = areas.x + areas.y + areas.z;
    float rest = u[0] * sum;
    const air_vec3 h = disk->half;
    const float y = 2.0f * u[1] - 1.0f;
    if (rest < areas.x) {
        const float x = 2.0f * rest / areas.x - 1.0f;
        return vec3_add(disk->center, vec3(dir.x > 0.0f ? -h.x : h.x, x * h.y, y * h.z));
    }
    rest -= areas.x;
    if (rest < areas.y) {
        const float x = 2.0f * rest / areas.y - 1.0f;
        return vec3_add(disk->center, vec3(x * h.x, dir.y > 0.0f ? -h.y : h.y, y * h.z));
    }
    rest -= areas.y;
    const float x = areas.z > 0.0f ? 2.0f * float_min(rest / areas.z, 1.0f) - 1.0f : 0.0f;
    return vec3_add(disk->center, vec3(x * h.x, y * h.y, dir.z > 0.0f ? -h.z : h.z));
}

static air_vec3 point_on_disk(const ord_disk *disk, const air_frame *frame, const float u[2])
{
    const air_vec3 at = sample_disk_concentric(u[0], u[1]);
    const float square = at.x * at.x + at.y * at.y, length = sqrtf(square);
    const float within = AIR_PI_F * disk->inner * disk->inner / disk->area;
    float r = disk->inner * sqrtf(square / within);
    if (square > within) {
        r = disk->inner *
            expf((square - within) / (1.0f - within) * logf(disk->outer / disk->inner));
    }
    const float scale = length > 0.0f ? r / length : 0.0f;
    return vec3_add(disk->center, vec3_add(vec3_scale(frame->s, at.x * scale),
                                           vec3_scale(frame->t, at.y * scale)));
}

/* A place across a direction; *area is what it stands for, times the number of places. */
static air_vec3 place_across(const ord_disk *disk, air_vec3 dir, const float u[2], float *area)
{
    const air_frame frame = frame_from_normal(dir);
    const air_vec3 areas = face_areas(disk, dir);
    const float silhouette = areas.x + areas.y + areas.z;
    const bool near = u[0] < DOMAIN_SHARE;
    const float v[2] = {near ? u[0] / DOMAIN_SHARE : (u[0] - DOMAIN_SHARE) / (1.0f - DOMAIN_SHARE),
                        u[1]};
    const air_vec3 place =
        near ? point_on_faces(disk, dir, areas, v) : point_on_disk(disk, &frame, v);
    const air_vec3 off = vec3_sub(place, disk->center);
    const air_vec3 across = vec3_madd(off, -vec3_dot(off, dir), dir);
    const float r = vec3_length(across), ratio = float_max(r / disk->inner, 1.0f);
    const bool seen = near || in_silhouette(disk, place, dir);
    const float density = (seen ? DOMAIN_SHARE / silhouette : 0.0f) +
                          (1.0f - DOMAIN_SHARE) / (disk->area * ratio * ratio);
    *area = 1.0f / density;
    return place;
}

/* The rectangle about all windows of a light, where that is smaller than the disk. */
static bool place_in_windows(const air_light *light, const ord_disk *disk, const float u[2],
                             air_vec3 *place, float *area)
{
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    const size_t count = light->window_count > 0 ? light->window_ends[light->window_count - 1] : 0;
    for (size_t i = 0; i < 2 * count; i++) {
        low[i % 2] = fmin(low[i % 2], light->windows[i]);
        high[i % 2] = fmax(high[i % 2], light->windows[i]);
    }
    if (count == 0 || (high[0] - low[0]) * (high[1] - low[1]) >= (double)disk->area) {
        return false;
    }
    *area = (float)((high[0] - low[0]) * (high[1] - low[1]));
    const float x = (float)(low[0] + (double)u[0] * (high[0] - low[0]));
    const float y = (float)(low[1] + (double)u[1] * (high[1] - low[1]));
    *place = vec3_add(vec3_scale(light->frame.s, x), vec3_scale(light->frame.t, y));
    return true;
}

static void from_far(const ord_disk *disk, const air_light *light, air_vec3 dir,
                     air_vec3 irradiance, const float u[2], ord_photon *out)
{
    const bool windows = light->kind == AIR_LIGHT_COLLIMATED;
    float area;
    air_vec3 place;
    if (!windows || !place_in_windows(light, disk, u, &place, &area)) {
        place = place_across(disk, dir, u, &area);
    }
    if (windows && !air_light_in_windows(light, place)) {
        return;
    }
    const float along = vec3_dot(vec3_sub(disk->scene_center, place), dir) - disk->depth;
    out->position = vec3_madd(place, along, dir);
    out->dir = dir;
    out->flux = vec3_scale(irradiance, area);
}

static void from_point(const air_light *light, const float u[2], ord_photon *out)
{
    out->position = light->position;
    out->dir = sample_sphere(u[0], u[1]);
    out->flux = vec3_scale(light->color, 4.0f * AIR_PI_F);
    if (light->kind == AIR_LIGHT_SPOT) {
        const float opening = air_spot_opening(light);
        const air_frame frame = frame_from_normal(light->dir);
        const air_vec3 local = sample_cone(u[0], u[1], opening);
        out->dir = frame_to_world(&frame, local);
        out->flux =
            vec3_scale(light->color, 2.0f * AIR_PI_F * opening * air_spot_falloff(light, local.z));
    }
}

static void from_area(const air_light *light, const air_light_point *point, const float u[2],
                      ord_photon *out)
{
    const bool back = !light->one_sided && u[0] >= 0.5f;
    const float u0 = light->one_sided ? u[0] : back ? 2.0f * u[0] - 1.0f : 2.0f * u[0];
    const air_vec3 normal = back ? vec3_neg(point->normal) : point->normal;
    const air_frame frame = frame_from_normal(normal);
    const float far = float_max(fabsf(point->position.x),
                                float_max(fabsf(point->position.y), fabsf(point->position.z)));
    out->position = vec3_madd(point->position, 1e-5f * (far + sqrtf(light->area)), normal);
    out->dir = frame_to_world(&frame, sample_cosine_hemisphere(u0, u[1]));
    out->flux = vec3_scale(point->value, AIR_PI_F * (light->one_sided ? 1.0f : 2.0f) / point->pdf);
}

/* ---- which light ---- */

typedef struct shooting {
    const air_light_table *table;
    const air_sobol *sobol;
    ord_disk disk;
    ord_photon *out;
    size_t next;
} shooting;

/* `count` photons of an entry, each of `weight` of its flux. */
static void shoot_entry(shooting *self, uint32_t entry, size_t count, float weight)
{
    const air_light *const light = &self->table->entries[entry];
    for (size_t n = 0; n < count; n++) {
        ord_photon *const out = &self->out[self->next++];
        const air_sampler sampler =
            air_sampler_make(self->sobol, SEED + (uint32_t)entry, (uint32_t)n);
        const air_f32x4 u = air_sampler_get(&sampler, 0);
        const float a[2] = {u[0], u[1]}, b[2] = {u[2], u[3]};
        air_light_point point;
        air_light_sample(self->table, entry, a[0], a[1], &point);
        if (light->kind == AIR_LIGHT_COLLIMATED) {
            from_far(&self->disk, light, light->dir, light->color, a, out);
        } else if (light->kind == AIR_LIGHT_ENVIRONMENT && point.pdf > 0.0f) {
            from_far(&self->disk, light, vec3_neg(point.dir),
                     vec3_scale(point.value, 1.0f / point.pdf), b, out);
        } else if (light->kind == AIR_LIGHT_POLYGON && point.pdf > 0.0f) {
            from_area(light, &point, b, out);
        } else if (light->kind == AIR_LIGHT_POINT || light->kind == AIR_LIGHT_SPOT) {
            from_point(light, a, out);
        }
        out->flux = vec3_scale(out->flux, weight);
        out->light = light;
    }
}

/* Entries [begin, end) share `count` photons by power; where they are too few for all, some entries
 * stand for others. */
static void shoot_entries(shooting *self, size_t begin, size_t end, size_t count)
{
    double total = 0.0, sum = 0.0;
    size_t done = 0;
    for (size_t i = begin; i < end; i++) {
        total += (double)air_light_pick_probability(self->table, (uint32_t)i);
    }
    for (size_t i = begin; i < end && total > 0.0; i++) {
        const double share = (double)air_light_pick_probability(self->table, (uint32_t)i) / total;
        sum += share;
        const size_t until = (size_t)floor((double)count * fmin(sum, 1.0) + 0.5);
        if (until > done) {
            const double weight = 1.0 / (share * (double)count);
            shoot_entry(self, (uint32_t)i, until - done, (float)weight);
            done = until;
        }
    }
}

air_status ord_photons_shoot(const ord_lighting *lighting, const ord_space *space, size_t rounds,
                             ord_photons *out)
{
    const air_light_table *const table = &space->path->snapshot->lights;
    size_t owned = 0;
    for (size_t i = 0; i < table->owner_count; i++) {
        owned += air_owner_table_uses(lighting->owners, i, AIR_METHOD_ORDINATES) ? 1 : 0;
    }
    const size_t even = ORD_PHOTONS / (owned > 0 ? owned : 1);
    const size_t each = even > ORD_PHOTONS_LEAST ? even : ORD_PHOTONS_LEAST;
    const air_status status =
        ord_photons_create(space->path->snapshot->context, owned * each, rounds, out);
    if (status != AIR_OK) {
        return status;
    }
    shooting self = {table, space->path->sobol, disk_of(space), out->items, 0};
    for (size_t i = 0; i < table->owner_count; i++) {
        if (air_owner_table_uses(lighting->owners, i, AIR_METHOD_ORDINATES)) {
            const size_t end = i < table->explicit_count ? i + 1 : table->count;
            shoot_entries(&self, i, end, each);
        }
    }
    ord_photons_follow(space, rounds, rounds == ORD_ROUNDS, out);
    return AIR_OK;
}

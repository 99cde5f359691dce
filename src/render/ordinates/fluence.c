/* fluence.c: how much of a source each cell gets without an event. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "airlight/ordinates_beam.h"
#include "render/ordinates/sources.h"
#include "scene/lights/punctual.h"

enum { CHANNELS = 4, LOOKS = 4, PACKET = 64 };

/* From so many edges away a square looks like a point. */
#define FAR_EDGES 6.0f

/* Places in a cell at which visibility is looked at, as shares of its edge: a lattice. */
static const float looks[LOOKS][3] = {{0.125f, 0.625f, 0.375f},
                                      {0.375f, 0.125f, 0.875f},
                                      {0.625f, 0.875f, 0.125f},
                                      {0.875f, 0.375f, 0.625f}};

static air_beam_box box_of(const ord_domain *domain, const float *extinction)
{
    air_beam_box box = {.extinction = extinction};
    for (int axis = 0; axis < 3; axis++) {
        box.size[axis] = domain->size[axis];
        box.cell_m[axis] = domain->cell_m;
    }
    return box;
}

size_t ord_source_scratch(const ord_domain *domain)
{
    const size_t spread = domain->cells * sizeof(float), beam = air_beam_scratch(domain->size);
    return spread > beam ? spread : beam;
}

float ord_source_intensity(const ord_source *source, air_vec3 dir)
{
    float share = 1.0f;
    if (source->cosine) {
        const float cosine = vec3_dot(source->normal, dir);
        share *= source->two_sided ? fabsf(cosine) : float_max(cosine, 0.0f);
    }
    if (source->light != NULL && source->light->kind == AIR_LIGHT_SPOT) {
        share *= air_spot_falloff(source->light, vec3_dot(dir, source->light->dir));
    }
    return share;
}

static air_vec3 look_point(const ord_domain *domain, size_t cell, const float at[3])
{
    size_t place[3];
    ord_domain_cell(domain, cell, place);
    const air_vec3 local = vec3(((float)(ptrdiff_t)place[0] + at[0]) * domain->cell_m,
                                ((float)(ptrdiff_t)place[1] + at[1]) * domain->cell_m,
                                ((float)(ptrdiff_t)place[2] + at[2]) * domain->cell_m);
    return ord_domain_world(domain, local);
}

/* ---- points ---- */

/* The solid angle of a square of edges 2 half about the origin, across z, on whose bright side the
 * point (x, y, z) is. */
static float square_angle(float x, float y, float z, float half)
{
    float sum = 0.0f;
    for (int corner = 0; corner < 4; corner++) {
        const float dx = (corner & 1) != 0 ? x + half : half - x;
        const float dy = (corner & 2) != 0 ? y + half : half - y;
        sum += atan2f(dx * dy, z * sqrtf(dx * dx + dy * dy + z * z));
    }
    return sum;
}

/* Fluence of a patch of surface of intensity 1: pi times the radiance of a square, as seen. So the
 * light of patches side by side is even however close to them; 1 / (r^2 + r_0^2) and one cosine
 * would be bright before each and dark between. */
static float patch_share(const ord_source *source, const air_frame *frame, air_vec3 to)
{
    const air_vec3 at = frame_to_local(frame, to);
    const float edge = 1.7320508f * source->radius_m, area = edge * edge;
    const float square = vec3_dot(at, at);
    if (at.z <= 0.0f) {
        return 0.0f;
    }
    return square > FAR_EDGES * FAR_EDGES * area
               ? at.z / (sqrtf(square) * square)
               : square_angle(at.x, at.y, at.z, 0.5f * edge) / area;
}

/* Without attenuation, to all four numbers of each cell. */
static void spread_patch(const ord_domain *domain, const ord_source *source, float *out)
{
    const air_frame frame = frame_from_normal(source->normal);
    const float middle[3] = {0.5f, 0.5f, 0.5f};
    for (size_t cell = 0; cell < domain->cells; cell++) {
        const air_vec3 to = vec3_sub(look_point(domain, cell, middle), source->place);
        const float share = patch_share(source, &frame, to);
        for (size_t c = 0; c < CHANNELS; c++) {
            out[cell * CHANNELS + c] = share;
        }
    }
}

/* The fourth number becomes the transmittance, where there is light. */
static void attenuate_patch(const ord_domain *domain, const ord_source *source,
                            const float *extinction, float *out)
{
    const air_beam_box box = box_of(domain, extinction);
    const float middle[3] = {0.5f, 0.5f, 0.5f};
    float from[3], to[3], depth[CHANNELS];
    vec3_store(from, ord_domain_local(domain, source->place));
    for (size_t cell = 0; cell < domain->cells; cell++) {
        float *const at = out + cell * CHANNELS;
        if (at[3] > 0.0f) {
            vec3_store(to, ord_domain_local(domain, look_point(domain, cell, middle)));
            air_beam_depth(&box, from, to, depth);
            at[0] *= expf(-depth[0]);
            at[1] *= expf(-depth[1]);
            at[2] *= expf(-depth[2]);
            at[3] = expf(-depth[3]);
        }
    }
}

static void fluence_of_point(const ord_domain *domain, const ord_source *source,
                             const float *extinction, float *spread, float *out)
{
    const air_beam_box box = box_of(domain, extinction);
    const float middle[3] = {0.5f, 0.5f, 0.5f};
    const float r0 = source->radius_m * source->radius_m;
    float position[3];
    vec3_store(position, ord_domain_local(domain, source->place));
    air_beam_point(&box, position, out);
    air_beam_spread(&box, position, spread);
    for (size_t cell = 0; cell < domain->cells; cell++) {
        const air_vec3 to = vec3_sub(look_point(domain, cell, middle), source->place);
        const float length = vec3_length(to);
        const air_vec3 dir = length > 0.0f ? vec3_scale(to, 1.0f / length) : source->normal;
        /* 1 / (r^2 + r_0^2) from the mean of 1 / r^2 */
        const float share =
            ord_source_intensity(source, dir) * spread[cell] / (1.0f + r0 * spread[cell]);
        for (size_t c = 0; c < 3; c++) {
            out[cell * CHANNELS + c] *= share;
        }
    }
}

/* ---- what is in the way ---- */

static bool is_hidden_anywhere(const ord_source *source, const air_path *path)
{
    const bool windows = source->light != NULL && source->light->kind == AIR_LIGHT_COLLIMATED &&
                         source->light->window_count > 0;
    return windows || (source->casts_shadow && path->snapshot->accelerator != NULL);
}

static air_ray ray_to_source(const ord_source *source, air_vec3 point)
{
    air_ray ray = {.tmax = FLT_MAX, .mask = source->casts_shadow ? AIR_MASK_SHADOW_OPAQUE : 0};
    air_vec3 dir = vec3_neg(source->place);
    vec3_store(ray.origin, point);
    if (source->local) {
        const air_vec3 to = vec3_sub(source->place, point);
        const float length = vec3_length(to);
        dir = vec3_scale(to, 1.0f / float_max(length, 1e-20f));
        ray.tmax = length * (source->cosine ? 0.999f : 1.0f);
    }
    vec3_store(ray.dir, dir);
    return ray;
}

float ord_source_share(const ord_source *source, const air_path *path, air_vec3 point)
{
    uint8_t occluded;
    float share = 1.0f;
    if (is_hidden_anywhere(source, path)) {
        const air_ray ray = ray_to_source(source, point);
        const bool open =
            source->local || source->light == NULL || air_light_in_windows(source->light, point);
        air_path_shares(path, &ray, 1, &occluded, &share);
        share = open ? share : 0.0f;
    }
    return share;
}

/* The share of LOOKS places of up to PACKET / LOOKS cells that see the source. */
static void look_at_cells(const ord_domain *domain, const ord_source *source, const air_path *path,
                          size_t begin, size_t count, float *out)
{
    air_ray rays[PACKET];
    uint8_t occluded[PACKET];
    float shares[PACKET];
    for (size_t i = 0; i < count * LOOKS; i++) {
        const air_vec3 point = look_point(domain, begin + i / LOOKS, looks[i % LOOKS]);
        rays[i] = ray_to_source(source, point);
    }
    air_path_shares(path, rays, count * LOOKS, occluded, shares);
    for (size_t i = 0; i < count; i++) {
        float sum = 0.0f;
        for (size_t n = 0; n < LOOKS; n++) {
            const air_vec3 point = look_point(domain, begin + i, looks[n]);
            const bool open = source->local || source->light == NULL ||
                              air_light_in_windows(source->light, point);
            sum += open ? shares[i * LOOKS + n] : 0.0f;
        }
        for (size_t c = 0; c < 3; c++) {
            out[(begin + i) * CHANNELS + c] *= sum * (1.0f / LOOKS);
        }
    }
}

/* What surfaces hide of a patch: one look at the middle of each cell that has any of its light. The
 * rays are those of light between surfaces and media: all meshes stop them, but for coverage. */
static void hide_patch(const ord_domain *domain, const ord_source *source, const air_path *path,
                       float *out)
{
    const float middle[3] = {0.5f, 0.5f, 0.5f};
    air_ray rays[PACKET];
    size_t cells[PACKET], count = 0;
    uint8_t occluded[PACKET];
    float shares[PACKET];
    for (size_t cell = 0; cell <= domain->cells; cell++) {
        const bool end = cell == domain->cells;
        if (!end && out[cell * CHANNELS + 3] > 0.0f) {
            cells[count] = cell;
            rays[count] = ray_to_source(source, look_point(domain, cell, middle));
            rays[count++].mask =
                path->snapshot->has_alpha ? AIR_MASK_SHADOW_OPAQUE : AIR_MASK_SCATTER;
        }
        if (count == PACKET || (end && count > 0)) {
            air_path_shares(path, rays, count, occluded, shares);
            for (size_t i = 0; i < count * CHANNELS; i++) {
                out[cells[i / CHANNELS] * CHANNELS + i % CHANNELS] *= shares[i / CHANNELS];
            }
            count = 0;
        }
    }
}

void ord_source_fluence(const ord_domain *domain, const ord_source *source, const air_path *path,
                        const float *extinction, void *scratch, float *out)
{
    if (source->events > 0) {
        spread_patch(domain, source, out);
        hide_patch(domain, source, path, out);
        attenuate_patch(domain, source, extinction, out);
        return;
    }
    if (source->local) {
        fluence_of_point(domain, source, extinction, scratch, out);
    } else {
        const air_beam_box box = box_of(domain, extinction);
        const float dir[3] = {source->place.x, source->place.y, source->place.z};
        air_beam_directional(path->snapshot->context, &box, dir, scratch, out);
    }
    const size_t run = PACKET / LOOKS;
    for (size_t cell = 0; is_hidden_anywhere(source, path) && cell < domain->cells; cell += run) {
        const size_t rest = domain->cells - cell;
        look_at_cells(domain, source, path, cell, rest < run ? rest : run, out);
    }
}

air_seen_beam ord_source_beam(const ord_domain *domain, const ord_source *source,
                              const float *fluence)
{
    air_seen_beam beam = {
        .local = source->local, .peakless = source->sky, .lobe = source->lobe, .fluence = fluence};
    vec3_store(beam.dir, source->local ? ord_domain_local(domain, source->place) : source->place);
    vec3_store(beam.power, source->power);
    return beam;
}

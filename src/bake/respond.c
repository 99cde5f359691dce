#include "bake/respond.h"

#include <string.h>

#include "bake/slab.h"
#include "core/phase.h"

/* The responses of one medium. */
typedef struct medium_response {
    air_impulse_response *by_emitter[AIR_IMPULSE_EMITTERS];
    size_t channels;  /* 1: grey */
    float extinction; /* mean over the channels */
    air_slab *slab;   /* directional light by one event; NULL: by_emitter has it */
} medium_response;

struct air_responder {
    air_context *context;
    const air_snapshot *snapshot;
    medium_response *media;
    size_t count;
};

/* ---- making ---- */

/* The mean cosine is all that the model knows of a phase function. */
static void describe(const air_medium *medium, const air_responder_params *params,
                     air_impulse_medium out[3])
{
    const float sigma_s[3] = {medium->sigma_s.x, medium->sigma_s.y, medium->sigma_s.z};
    const float sigma_t[3] = {medium->sigma_t.x, medium->sigma_t.y, medium->sigma_t.z};
    for (int c = 0; c < 3; c++) {
        out[c] = (air_impulse_medium){.sigma_s = (double)sigma_s[c],
                                      .sigma_t = (double)sigma_t[c],
                                      .g = (double)phase_mean_cosine(medium->phase),
                                      .bounces = params->bounces,
                                      .rule = params->literal ? AIR_IMPULSE_SIMILARITY
                                                              : AIR_IMPULSE_RESIDUAL};
    }
}

static air_status make_medium(air_responder *self, const air_impulse_tables *tables,
                              const air_responder_params *params, size_t index)
{
    const air_medium *medium = &self->snapshot->media.media[index];
    medium_response *out = &self->media[index];
    const air_vec3 s = medium->sigma_s, t = medium->sigma_t;
    const bool grey = s.x == s.y && s.y == s.z && t.x == t.y && t.y == t.z;
    air_impulse_medium media[3];
    air_status status = AIR_OK;
    describe(medium, params, media);
    out->channels = grey ? 1 : 3;
    out->extinction = vec3_mean(t);
    for (int e = 0; e < AIR_IMPULSE_EMITTERS && status == AIR_OK; e++) {
        status = air_impulse_response_create(self->context, tables, (air_impulse_emitter)e, media,
                                             out->channels, &out->by_emitter[e]);
    }
    if (status == AIR_OK && !params->literal) {
        status = air_slab_create(self->context, self->snapshot, index, &out->slab);
    }
    return status;
}

static air_status make_tables(air_context *context, const air_snapshot *snapshot,
                              const air_responder_params *params, air_impulse_tables **out)
{
    air_impulse_params table;
    if (params->literal) {
        air_impulse_params_paper(&table);
    } else {
        air_impulse_params_default(&table);
        if (snapshot->media.count > 0) {
            /* the first medium's own g is a knot in place of the nearest */
            const double g = (double)phase_mean_cosine(snapshot->media.media[0].phase);
            size_t nearest = 0;
            for (size_t k = 1; k < table.g_count; k++) {
                nearest = fabs(table.g[k] - g) < fabs(table.g[nearest] - g) ? k : nearest;
            }
            table.g[nearest] = g;
        }
    }
    table.bounces = params->bounces;
    return air_impulse_tables_create(context, &table, out);
}

air_status air_responder_create(air_context *context, const air_snapshot *snapshot,
                                const air_responder_params *params, air_responder **out_responder)
{
    air_responder *self = air_allocate(context, 1, sizeof *self);
    air_impulse_tables *built = NULL;
    const air_impulse_tables *tables = params->tables;
    *out_responder = NULL;
    if (self == NULL) {
        return air_fail_memory(context, "responses of media");
    }
    self->context = context;
    self->snapshot = snapshot;
    self->media = air_allocate(context, snapshot->media.count, sizeof *self->media);
    air_status status =
        self->media == NULL ? air_fail_memory(context, "responses of media") : AIR_OK;
    if (status == AIR_OK && tables == NULL) {
        status = make_tables(context, snapshot, params, &built);
        tables = built;
    }
    for (size_t i = 0; i < snapshot->media.count && status == AIR_OK; i++) {
        self->count++;
        status = make_medium(self, tables, params, i);
    }
    air_impulse_tables_destroy(built);
    if (status != AIR_OK) {
        air_responder_destroy(self);
        return status;
    }
    *out_responder = self;
    return AIR_OK;
}

void air_responder_destroy(air_responder *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; self->media != NULL && i < self->count; i++) {
        for (int e = 0; e < AIR_IMPULSE_EMITTERS; e++) {
            air_impulse_response_destroy(self->media[i].by_emitter[e]);
        }
        air_slab_destroy(self->media[i].slab);
    }
    air_free(self->context, self->media);
    air_free(self->context, self);
}

/* ---- segments ---- */

/* A segment as so much of one medium. */
typedef struct stretch {
    const medium_response *medium; /* NULL: nothing scatters */
    size_t index;
    float inside; /* length in that medium that has the segment's optical depth */
} stretch;

/* Mean extinction of what is neither constant nor exponential, by the middle of equal steps. */
static float mean_grid_extinction(const air_ray_media *media, const air_ray_segment *part)
{
    enum { STEPS = 8 };
    float sum = 0.0f;
    for (int i = 0; i < STEPS; i++) {
        const float t = part->t0 + (part->t1 - part->t0) * ((float)i + 0.5f) / STEPS;
        sum += vec3_mean(air_ray_media_coefficients(media, part, t).sigma_t);
    }
    return sum / STEPS;
}

static stretch measure(const air_responder *self, const air_path_segment *segment)
{
    const air_ray_media *media = segment->media;
    float depths[AIR_MAX_REGIONS] = {0.0f}, total = 0.0f;
    stretch out = {NULL, 0, 0.0f};
    for (size_t i = 0; i < media->count; i++) {
        const air_ray_segment *part = &media->segments[i];
        const float length = part->t1 - part->t0;
        const float extinction =
            part->tracked ? mean_grid_extinction(media, part) : vec3_mean(part->sigma_t);
        float depth = extinction * length;
        if (part->exponential && !part->tracked) {
            depth += vec3_mean(air_ray_media_exponential_depth(media, part, part->t1));
        }
        /* of overlapping media the first stands for all */
        const uint32_t medium = media->media->regions[__builtin_ctzll(part->regions)].medium;
        if (medium < AIR_MAX_REGIONS) {
            depths[medium] += depth;
        }
        total += depth;
    }
    for (size_t m = 1; m < self->count && m < AIR_MAX_REGIONS; m++) {
        out.index = depths[m] > depths[out.index] ? m : out.index;
    }
    if (total > 0.0f && self->media[out.index].extinction > 0.0f) {
        out.medium = &self->media[out.index];
        out.inside = total / out.medium->extinction;
    }
    return out;
}

static air_vec3 spread(const float *values, size_t channels)
{
    return channels == 1 ? vec3_set1(values[0]) : vec3(values[0], values[1], values[2]);
}

static air_vec3 respond_patch(const stretch *s, const air_path_segment *segment, air_vec3 normal,
                              air_vec3 receiver)
{
    const air_vec3 l = segment->dir;
    const float cos_s = -vec3_dot(normal, l), n_l = vec3_dot(receiver, l);
    /* x lies in the plane of l and the patch's normal, across l */
    const air_vec3 across = vec3_madd(normal, cos_s, l);
    const float length = vec3_length(across);
    const float n_x = length > 1e-6f ? vec3_dot(receiver, across) / length : 0.0f;
    const air_impulse_place_float place = {s->inside, n_l, cos_s, n_x};
    float out[3];
    air_impulse_response_irradiance(s->medium->by_emitter[AIR_IMPULSE_AREA], &place, out);
    const float ratio = s->inside / segment->length;
    return vec3_scale(spread(out, s->medium->channels), ratio * ratio);
}

static void patch(const void *user, const air_path_segment *segment, air_vec3 normal,
                  const air_vec3 *normals, size_t count, air_vec3 *out)
{
    const stretch s = measure(user, segment);
    for (size_t i = 0; i < count; i++) {
        out[i] =
            s.medium != NULL ? respond_patch(&s, segment, normal, normals[i]) : vec3_set1(0.0f);
    }
}

static air_vec3 respond_zonal(const stretch *s, air_impulse_emitter emitter, float n_l, float scale)
{
    const air_impulse_place_float place = {s->inside, n_l, 0.0f, 0.0f};
    float out[3];
    air_impulse_response_irradiance(s->medium->by_emitter[emitter], &place, out);
    return vec3_scale(spread(out, s->medium->channels), scale);
}

static void light(const void *user, const air_path_segment *segment, const air_light_point *point,
                  const air_vec3 *normals, size_t count, air_vec3 *out)
{
    const air_responder *self = user;
    const stretch s = measure(self, segment);
    const float ratio = point->infinite ? 1.0f : s.inside / segment->length;
    for (size_t i = 0; i < count; i++) {
        const float n_l = vec3_dot(normals[i], segment->dir);
        if (s.medium == NULL) {
            out[i] = vec3_set1(0.0f);
        } else if (point->infinite) {
            out[i] = respond_zonal(&s, AIR_IMPULSE_DIRECTIONAL, n_l, 1.0f);
            if (s.medium->slab != NULL && point->delta) {
                out[i] = vec3_add(out[i],
                                  air_slab_correction(s.medium->slab, point->entry, segment->origin,
                                                      segment->dir, normals[i]));
            }
        } else if (point->delta) {
            out[i] = respond_zonal(&s, AIR_IMPULSE_POINT, n_l, ratio * ratio);
        } else {
            const bool front = vec3_dot(point->normal, segment->dir) < 0.0f;
            const bool one_sided = self->snapshot->lights.entries[point->entry].one_sided;
            const air_vec3 normal = front || one_sided ? point->normal : vec3_neg(point->normal);
            out[i] = respond_patch(&s, segment, normal, normals[i]);
        }
        out[i] =
            vec3(float_max(out[i].x, 0.0f), float_max(out[i].y, 0.0f), float_max(out[i].z, 0.0f));
    }
}

air_path_respond air_responder_hooks(const air_responder *responder)
{
    return (air_path_respond){light, patch, responder};
}

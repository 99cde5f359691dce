/* light.c: what the rays of a block of samples receive from the lights that the
 * collimated method owns. */
#include <float.h>
#include <string.h>

#include "core/phase.h"
#include "core/triple.h"
#include "path/ray_media.h"
#include "render/collimated/state.h"

static air_vec3 rgb(const double v[3]) { return vec3((float)v[0], (float)v[1], (float)v[2]); }

/* ---- profiles ---- */

/* The phase functions' values are the same all along a ray. */
static void weigh_cells(const air_with_collimated *with, const collimated_beam *b, size_t channel,
                        air_collimated_cell *cells)
{
    const air_media *media = &with->snapshot->media;
    for (size_t r = 0; r < with->region_count; r++) {
        const air_region *region = &media->regions[r];
        const float phase = phase_eval(media->media[region->medium].phase, b->cosine);
        cells[r].weight = (double)air_channel(region->sigma_s, (int)channel) * (double)phase;
    }
}

static void make_profile(const air_with_collimated *with, air_collimated_scratch *scratch,
                         const collimated_beam *b, size_t channel, double t_max,
                         air_collimated_profile *out)
{
    const air_collimated_cell *cells = with->cells + channel * with->region_count;
    if (with->region_count == 1) {
        air_collimated_profile_make(&cells[0].medium, b->lamp->to_light, cells[0].sigma_t,
                                    b->origin, b->dir, t_max, out);
        return;
    }
    air_collimated_cell *weighted = scratch->cells + channel * with->region_count;
    weigh_cells(with, b, channel, weighted);
    air_collimated_profile_make_cells(weighted, with->region_count, b->lamp->to_light, b->origin,
                                      b->dir, t_max, out);
}

/* A single cell's weight is 1; what it scatters goes into the factor. */
static air_vec3 common_factor(const air_with_collimated *with, const collimated_beam *b)
{
    const air_media *media = &with->snapshot->media;
    const air_region *region = &media->regions[0];
    if (with->region_count > 1) {
        return b->lamp->light->color;
    }
    const float phase = phase_eval(media->media[region->medium].phase, b->cosine);
    return vec3_scale(vec3_mul(region->sigma_s, b->lamp->light->color), phase);
}

/* Into the place-th three profiles. False if the lamp gives nothing to the ray. */
static bool make_beam(const air_with_collimated *with, air_collimated_scratch *scratch,
                      const collimated_lamp *lamp, const air_path_lane *lane, size_t place,
                      collimated_beam *out)
{
    const bool met = lane->hit.mesh != (uint32_t)AIR_NO_HIT;
    const double t_max = met ? (double)lane->hit.t : INFINITY;
    out->lamp = lamp;
    out->profiles = scratch->profiles + 3 * place;
    vec3_store64(out->origin, lane->origin);
    vec3_store64(out->dir, lane->dir);
    out->cosine = (float)(out->dir[0] * lamp->to_light[0] + out->dir[1] * lamp->to_light[1] +
                          out->dir[2] * lamp->to_light[2]);
    out->begin = INFINITY;
    out->end = -INFINITY;
    const bool windows = lamp->light->window_count > 0;
    if (windows) {
        out->open_count =
            air_light_open_stretches(lamp->light, out->origin, out->dir, scratch->open);
    }
    for (size_t c = 0; c < with->channels; c++) {
        air_collimated_profile *profile = &out->profiles[c];
        make_profile(with, scratch, out, c, t_max, windows ? &scratch->plain : profile);
        if (windows) {
            air_collimated_profile_restrict(&scratch->plain, scratch->open, out->open_count,
                                            profile);
        }
        if (profile->count > 0) {
            out->begin = double_min(out->begin, profile->pieces[0].t0);
            out->end = double_max(out->end, profile->pieces[profile->count - 1].t1);
        }
    }
    if (!windows) {
        scratch->open[0] = (air_interval){out->begin, out->end};
        out->open_count = 1;
    }
    out->factor = common_factor(with, out);
    return out->begin < out->end;
}

/* ---- drawing a distance ---- */

/* One sample for all channels: drawn for one of those that see something, all of them in the
 * density. unoccluded: integrand over density. */
static double draw(const air_with_collimated *with, const air_collimated_profile *profiles,
                   air_collimated_estimator estimator, double u, double unoccluded[3])
{
    size_t chosen[3] = {0}, count = 0;
    for (size_t c = 0; c < with->channels; c++) {
        if (profiles[c].count > 0) {
            chosen[count++] = c;
        }
    }
    const size_t k = (size_t)double_min(u * (double)count, (double)count - 1.0);
    const air_collimated_draw first =
        air_collimated_estimate(estimator, &profiles[chosen[k]],
                                double_min(u * (double)count - (double)k, 0x1.fffffffffffffp-1));
    if (with->channels == 1) {
        unoccluded[0] = unoccluded[1] = unoccluded[2] = first.unoccluded;
        return first.t;
    }
    double density = 0.0;
    for (size_t i = 0; i < count; i++) {
        density +=
            air_collimated_estimate_pdf(estimator, &profiles[chosen[i]], first.t) / (double)count;
    }
    for (size_t c = 0; c < 3; c++) {
        unoccluded[c] =
            density > 0.0 ? air_collimated_integrand(&profiles[c], first.t) / density : 0.0;
    }
    return first.t;
}

static air_ray ray_to_light(const collimated_beam *b, double t)
{
    air_ray ray = {.tmin = 0.0f, .tmax = FLT_MAX, .mask = AIR_MASK_SHADOW_OPAQUE};
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = (float)(b->origin[k] + t * b->dir[k]);
        ray.dir[k] = (float)b->lamp->to_light[k];
    }
    return ray;
}

/* ---- exact ---- */

/* The integral over the gaps of the list; for channels that share a profile once. */
static void integrate_gaps(const air_with_collimated *with, const air_collimated_scratch *scratch,
                           const collimated_beam *b, size_t gap_count, double parts[3])
{
    for (size_t c = 0; c < 3; c++) {
        parts[c] = c < with->channels ? 0.0 : parts[0];
        for (size_t i = 0; c < with->channels && i < gap_count; i++) {
            parts[c] += air_collimated_partial_integral(&b->profiles[c], scratch->gaps[i].begin,
                                                        scratch->gaps[i].end);
        }
    }
}

/* The same where surfaces with coverage may be in the way: they are looked for at one point drawn
 * there. */
static void sample_gaps(const air_with_collimated *with, air_collimated_scratch *scratch,
                        const collimated_beam *b, size_t gap_count, double u, double parts[3])
{
    size_t count = 0;
    for (size_t c = 0; c < with->channels; c++) {
        air_collimated_profile_restrict(&b->profiles[c], scratch->gaps, gap_count,
                                        &scratch->lit[c]);
        count += scratch->lit[c].count;
    }
    if (count == 0) {
        parts[0] = parts[1] = parts[2] = 0.0;
        return;
    }
    const double t = draw(with, scratch->lit, AIR_COLLIMATED_WVDS, u, parts);
    const air_ray ray = ray_to_light(b, t);
    const double through = (double)air_path_alpha_transmittance(with->path, &ray);
    for (size_t c = 0; c < 3; c++) {
        parts[c] *= through;
    }
}

static void add_light(const collimated_beam *b, const double parts[3], air_path_lane *lane)
{
    lane->terms[AIR_TERM_M1] = vec3_add(lane->terms[AIR_TERM_M1], vec3_mul(b->factor, rgb(parts)));
}

/* What lies between the shadows of opaque triangles adds its integral. */
static void add_gaps(const air_with_collimated *with, air_collimated_scratch *scratch,
                     const collimated_beam *b, size_t gap_count, air_path_lane *lane)
{
    double parts[3];
    if (gap_count == 0) {
        return;
    }
    if (with->snapshot->has_alpha && b->lamp->light->casts_shadow) {
        sample_gaps(with, scratch, b, gap_count, (double)lane->u_beam, parts);
    } else {
        integrate_gaps(with, scratch, b, gap_count, parts);
    }
    add_light(b, parts, lane);
}

/* The stretch of the ray inside the box that shadows can reach; empty if there is none. */
static air_interval reached(const collimated_beam *b, double begin, double end)
{
    const air_shadow_view *shadows = &b->lamp->shadows;
    air_interval inside = {begin, end};
    for (int k = 0; k < 3; k++) {
        const double to_low = (shadows->low[k] - b->origin[k]) / b->dir[k];
        const double to_high = (shadows->high[k] - b->origin[k]) / b->dir[k];
        if (b->dir[k] != 0.0) {
            inside.begin = double_max(inside.begin, double_min(to_low, to_high));
            inside.end = double_min(inside.end, double_max(to_low, to_high));
        } else if (b->origin[k] < shadows->low[k] || b->origin[k] > shadows->high[k]) {
            inside.end = inside.begin;
        }
    }
    return inside;
}

/* A stretch with more shadows than there is room for is halved; so often at most. */
enum { MOST_HALVINGS = 24 };

static void add_halves(const air_with_collimated *with, air_collimated_scratch *scratch,
                       const collimated_beam *b, air_interval stretch, int halvings,
                       air_path_lane *lane)
{
    const double middle = stretch.begin + 0.5 * (stretch.end - stretch.begin);
    const air_interval halves[2] = {{stretch.begin, middle}, {middle, stretch.end}};
    for (int i = 0; i < 2; i++) {
        const air_interval asked = reached(b, halves[i].begin, halves[i].end);
        air_interval *shadows = scratch->shadows[0];
        size_t count = 0;
        if (asked.begin < asked.end) {
            count = air_shadow_tree_query(b->lamp->shadows.tree, b->origin, b->dir, asked.begin,
                                          asked.end, shadows, COLLIMATED_INTERVALS);
        }
        if (count <= COLLIMATED_INTERVALS) {
            add_gaps(
                with, scratch, b,
                air_intervals_gaps(shadows, count, halves[i].begin, halves[i].end, scratch->gaps),
                lane);
        } else if (halvings < MOST_HALVINGS) {
            add_halves(with, scratch, b, halves[i], halvings + 1, lane);
        }
    }
}

/* Asks for the shadows of the stretches that wait, and adds the light between them. */
static void finish_stretches(const air_with_collimated *with, air_collimated_scratch *scratch,
                             const collimated_lamp *lamp, air_path_lane *lanes)
{
    const size_t count = scratch->stretch_count;
    scratch->stretch_count = 0;
    if (lamp->shadows.tree != NULL) {
        air_shadow_tree_query_rays(lamp->shadows.tree, scratch->shadow_queries, count);
    }
    bool overflow = false; /* halving takes the lists' place: last */
    for (size_t i = 0; i < count; i++) {
        const collimated_stretch *stretch = &scratch->stretches[i];
        const air_shadow_query *query = &scratch->shadow_queries[i];
        if (query->count > COLLIMATED_INTERVALS) {
            overflow = true;
            continue;
        }
        add_gaps(with, scratch, &scratch->beams[stretch->lane],
                 air_intervals_gaps(query->out, query->count, stretch->part.begin,
                                    stretch->part.end, scratch->gaps),
                 &lanes[stretch->lane]);
    }
    for (size_t i = 0; overflow && i < count; i++) {
        const collimated_stretch *stretch = &scratch->stretches[i];
        if (scratch->shadow_queries[i].count > COLLIMATED_INTERVALS) {
            add_halves(with, scratch, &scratch->beams[stretch->lane], stretch->part, 0,
                       &lanes[stretch->lane]);
        }
    }
}

static void add_stretch(const air_with_collimated *with, air_collimated_scratch *scratch,
                        size_t lane, air_interval part, air_path_lane *lanes)
{
    const collimated_beam *b = &scratch->beams[lane];
    const size_t i = scratch->stretch_count++;
    const bool shadows = b->lamp->shadows.tree != NULL;
    const air_interval asked =
        shadows ? reached(b, part.begin, part.end) : (air_interval){part.begin, part.begin};
    scratch->stretches[i] = (collimated_stretch){lane, part};
    scratch->shadow_queries[i] = (air_shadow_query){.begin = asked.begin,
                                                    .end = asked.end,
                                                    .out = scratch->shadows[i],
                                                    .capacity = COLLIMATED_INTERVALS};
    memcpy(scratch->shadow_queries[i].origin, b->origin, sizeof b->origin);
    memcpy(scratch->shadow_queries[i].dir, b->dir, sizeof b->dir);
    if (scratch->stretch_count == COLLIMATED_STRETCHES) {
        finish_stretches(with, scratch, b->lamp, lanes);
    }
}

/* ---- moments ---- */

/* Moments count from the eye, profiles from where a ray begins: at the near plane. */
typedef struct eye_profile {
    const air_collimated_profile *profile;
    double begin; /* of the ray, from the eye */
} eye_profile;

static double own_weight(void *user, double t)
{
    const eye_profile *own = user;
    return air_collimated_integrand(own->profile, t - own->begin);
}

/* The stretch less the share of it that the moments hold for shadow. */
static void add_bounded(const air_with_collimated *with, const collimated_beam *b,
                        air_interval part, air_path_lane *lane)
{
    const collimated_lamp *lamp = b->lamp;
    const air_interval asked = lamp->moments != NULL ? reached(b, part.begin, part.end)
                                                     : (air_interval){part.begin, part.begin};
    double share = 0.0, parts[3];
    if (asked.begin < asked.end) {
        double way[3];
        air_moment_choice choice;
        air_subtract3(b->origin, lamp->eye, way);
        eye_profile own = {&b->profiles[0], air_length3(way)};
        const double begin = asked.begin + own.begin, end = asked.end + own.begin;
        air_moment_choice_default(&choice);
        share = collimated_own_weights(lamp->mode)
                    ? air_moment_shadow_weighted(lamp->moments, b->dir, begin, end, own_weight,
                                                 &own, &choice)
                    : air_moment_shadow(lamp->moments, b->dir, begin, end, &choice);
    }
    for (size_t c = 0; c < 3; c++) {
        const air_collimated_profile *profile = &b->profiles[c < with->channels ? c : 0];
        parts[c] = air_collimated_partial_integral(profile, part.begin, part.end) -
                   share * air_collimated_partial_integral(profile, asked.begin, asked.end);
    }
    add_light(b, parts, lane);
}

/* ---- modes without noise ---- */

/* What the lanes receive from one lamp, in each stretch that its windows leave open. */
static void add_noiseless(const air_with_collimated *with, air_collimated_scratch *scratch,
                          const collimated_lamp *lamp, air_path_lane *lanes, size_t count)
{
    for (size_t lane = 0; lane < count; lane++) {
        collimated_beam *b = &scratch->beams[lane];
        if (!make_beam(with, scratch, lamp, &lanes[lane], lane, b)) {
            continue;
        }
        for (size_t i = 0; i < b->open_count; i++) {
            const air_interval part = {double_max(scratch->open[i].begin, b->begin),
                                       double_min(scratch->open[i].end, b->end)};
            if (part.begin >= part.end) {
                continue;
            }
            if (lamp->mode == AIR_COLLIMATED_EXACT) {
                add_stretch(with, scratch, lane, part, lanes);
            } else {
                add_bounded(with, b, part, &lanes[lane]);
            }
        }
    }
    finish_stretches(with, scratch, lamp, lanes);
}

/* ---- sampled ---- */

static void queue(air_collimated_scratch *scratch, const air_ray *ray, collimated_query query)
{
    scratch->rays[scratch->query_count] = *ray;
    scratch->queries[scratch->query_count++] = query;
}

/* Sends the queued rays and adds what arrives. */
static void send(const air_with_collimated *with, air_collimated_scratch *scratch,
                 air_path_lane *lanes, air_lane_ratios *ratios)
{
    const size_t count = scratch->query_count;
    scratch->query_count = 0;
    float shares[AIR_PATH_LANES];
    air_path_shares(with->path, scratch->rays, count, scratch->occluded, shares);
    for (size_t i = 0; i < count; i++) {
        const collimated_query *query = &scratch->queries[i];
        if (shares[i] == 0.0f) {
            continue;
        }
        const air_vec3 value = vec3_scale(query->value, shares[i]);
        air_vec3 *sum = query->ratio ? &ratios[query->lane].volume.occluded
                                     : &lanes[query->lane].terms[query->term];
        *sum = vec3_add(*sum, value);
    }
}

/* What the lamp would give to the ray if nothing were in between. */
static air_vec3 unoccluded_light(const air_with_collimated *with, const collimated_beam *b)
{
    double t[3] = {0.0, 0.0, 0.0};
    for (size_t c = 0; c < 3; c++) {
        t[c] = c < with->channels ? air_collimated_integral(&b->profiles[c]) : t[0];
    }
    return vec3_mul(b->factor, rgb(t));
}

/* One sample of one of the beams, chosen in proportion to what they would give, so that the choice
 * adds no noise where all are visible. What ratio estimators know beforehand is added for all of
 * their beams. */
static void add_sampled(const air_with_collimated *with, air_collimated_scratch *scratch,
                        size_t count, double u, size_t lane_index, air_ratio_sample *ratio)
{
    double total = 0.0, rest, unoccluded[3];
    for (size_t i = 0; i < count; i++) {
        const collimated_beam *b = &scratch->beams[i];
        const air_vec3 light = unoccluded_light(with, b);
        scratch->contributions[i] = (double)vec3_luminance(light);
        total += scratch->contributions[i];
        if (air_collimated_estimator_is_ratio(air_collimated_mode_estimator(b->lamp->mode))) {
            ratio->analytic = vec3_add(ratio->analytic, light);
        }
    }
    if (!(total > 0.0)) {
        return;
    }
    const size_t chosen = air_collimated_choose(scratch->contributions, count, u, &rest);
    const collimated_beam *b = &scratch->beams[chosen];
    const air_collimated_estimator estimator = air_collimated_mode_estimator(b->lamp->mode);
    const double t = draw(with, b->profiles, estimator, rest, unoccluded);
    const float per_share = (float)(total / scratch->contributions[chosen]);
    const collimated_query query = {lane_index, AIR_TERM_M1,
                                    air_collimated_estimator_is_ratio(estimator),
                                    vec3_scale(vec3_mul(b->factor, rgb(unoccluded)), per_share)};
    air_ray ray = ray_to_light(b, t);
    if (!b->lamp->light->casts_shadow) {
        ray.mask = 0;
    }
    if (query.ratio) {
        ratio->unoccluded = query.value;
    }
    if (!vec3_is_zero(query.value)) {
        queue(scratch, &ray, query);
    }
}

/* What one lane receives from the lamps that are sampled. */
static void add_volume_sampled(const air_with_collimated *with, air_collimated_scratch *scratch,
                               air_path_lane *lane, size_t lane_index, air_ratio_sample *ratio)
{
    size_t count = 0;
    for (size_t i = 0; i < with->lamp_count; i++) {
        const collimated_lamp *lamp = &with->lamps[i];
        count += air_collimated_mode_samples(lamp->mode) &&
                 make_beam(with, scratch, lamp, lane, count, &scratch->beams[count]);
    }
    add_sampled(with, scratch, count, (double)lane->u_beam, lane_index, ratio);
}

static void add_volume(const air_with_collimated *with, air_collimated_scratch *scratch,
                       air_path_lane *lanes, air_lane_ratios *ratios, size_t count)
{
    bool sampled = false;
    for (size_t i = 0; i < with->lamp_count; i++) {
        if (air_collimated_mode_samples(with->lamps[i].mode)) {
            sampled = true;
        } else {
            add_noiseless(with, scratch, &with->lamps[i], lanes, count);
        }
    }
    for (size_t i = 0; sampled && i < count; i++) {
        add_volume_sampled(with, scratch, &lanes[i], i, &ratios[i].volume);
    }
    send(with, scratch, lanes, ratios);
}

/* ---- surfaces ---- */

/* What the lanes' camera rays met, and how much of it comes through. */
static void make_surfaces(const air_with_collimated *with, air_collimated_scratch *scratch,
                          const air_path_lane *lanes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const air_path_lane *lane = &lanes[i];
        if (lane->hit.mesh != (uint32_t)AIR_NO_HIT) {
            air_surface_make(with->snapshot, &lane->hit, lane->dir, &scratch->surfaces[i]);
            scratch->camera_transmittance[i] = air_constant_transmittance(
                &with->snapshot->media, lane->origin, lane->dir, lane->hit.t);
        }
    }
}

/* Direct light of one lamp on the surfaces of a block: nothing is left to chance. */
static void add_surfaces(const air_with_collimated *with, air_collimated_scratch *scratch,
                         const collimated_lamp *lamp, const air_path_lane *lanes, size_t count)
{
    const air_vec3 to_light = vec3_neg(lamp->light->dir);
    for (size_t i = 0; i < count; i++) {
        const air_path_lane *lane = &lanes[i];
        const air_surface *surface = &scratch->surfaces[i];
        if (lane->hit.mesh == (uint32_t)AIR_NO_HIT ||
            !air_light_in_windows(lamp->light, surface->position)) {
            continue;
        }
        const air_vec3 reflected = air_bsdf_eval(&surface->bsdf, vec3_neg(lane->dir), to_light);
        if (vec3_is_zero(reflected)) {
            continue;
        }
        const air_vec3 origin = air_surface_origin(surface, to_light);
        const air_vec3 incident =
            vec3_mul(lamp->light->color, air_constant_transmittance(&with->snapshot->media, origin,
                                                                    to_light, INFINITY));
        const collimated_query query = {
            i, AIR_TERM_S0, false,
            vec3_mul(vec3_mul(reflected, incident), scratch->camera_transmittance[i])};
        air_ray ray = {.tmax = FLT_MAX,
                       .mask = lamp->light->casts_shadow ? AIR_MASK_SHADOW_OPAQUE : 0};
        vec3_store(ray.origin, origin);
        vec3_store(ray.dir, to_light);
        if (!vec3_is_zero(query.value)) {
            queue(scratch, &ray, query);
        }
    }
}

void air_with_collimated_add(const air_with_collimated *with, air_collimated_scratch *scratch,
                             air_path_lane *lanes, air_lane_ratios *ratios, size_t count)
{
    if (with->volume) {
        add_volume(with, scratch, lanes, ratios, count);
    }
    if (!with->surfaces) {
        return;
    }
    make_surfaces(with, scratch, lanes, count);
    for (size_t i = 0; i < with->lamp_count; i++) {
        add_surfaces(with, scratch, &with->lamps[i], lanes, count);
        send(with, scratch, lanes, ratios);
    }
}

#include "render/picture.h"

#include <string.h>

#include "scene/fingerprint.h"

/* What must agree before samples may be added to another picture's. */
static uint64_t settings_hash(const air_picture *picture)
{
    const air_render_params *p = picture->params;
    const air_camera_view *view = &picture->view;
    const air_vec3 rays[4] = {view->origin, view->dir, view->step_x, view->step_y};
    const uint32_t numbers[] = {p->max_depth,         p->terms,
                                (uint32_t)p->filter,  (uint32_t)view->kind,
                                (uint32_t)p->pattern, (uint32_t)p->area_rule,
                                p->area_nodes,        p->shadow_samples,
                                p->shadow_candidates};
    uint64_t hash = air_fingerprint_snapshot(picture->snapshot);
    hash = air_fingerprint_add(hash, rays, sizeof rays);
    hash = air_fingerprint_add(hash, numbers, sizeof numbers);
    if (view->lens_radius > 0.0f) {
        const float lens[] = {view->lens_radius, view->focus_distance};
        hash = air_fingerprint_add(hash, lens, sizeof lens);
    }
    if (view->near_distance > 0.0f) {
        hash = air_fingerprint_add(hash, &view->near_distance, sizeof view->near_distance);
    }
    hash = air_fingerprint_add(hash, &p->filter_radius, sizeof p->filter_radius);
    if (p->area_table != NULL) {
        hash = air_fingerprint_add(hash, p->area_table->knots, sizeof p->area_table->knots);
    }
    if (picture->ordinates != NULL) {
        hash = air_with_ordinates_fingerprint(picture->ordinates, hash);
    }
    if (picture->lightmap != NULL) {
        hash = air_with_lightmap_fingerprint(picture->lightmap, hash);
    }
    return air_fingerprint_add(hash, p->methods, strlen(p->methods));
}

static void add_light_slot(air_picture *picture, const char *name, air_slot_kind kind)
{
    air_film_layout_add(&picture->layout, kind, name,
                        kind == AIR_SLOT_TERM    ? 3
                        : kind == AIR_SLOT_RATIO ? 12
                                                 : 13);
}

/* How a term is kept: where lamps are shaded by their visible share, that share is smoothed. */
static air_slot_kind term_slot(const air_picture *picture, uint32_t term)
{
    const bool smooth = air_with_arealight_is_ratio(picture->arealight);
    const bool baked = (air_lightmap_terms(picture->params->lightmap) >> term & 1u) != 0;
    if (smooth && !baked && (term == AIR_TERM_S0 || term == AIR_TERM_M1)) {
        return AIR_SLOT_SHARE;
    }
    return term == AIR_TERM_M1 && air_with_collimated_is_ratio(picture->collimated) ? AIR_SLOT_RATIO
                                                                                    : AIR_SLOT_TERM;
}

static void make_layout(air_picture *picture)
{
    const air_render_params *p = picture->params;
    const bool smooth = air_with_arealight_is_ratio(picture->arealight);
    picture->apart = p->layers || smooth;
    picture->guides = picture->path.settings.guides = p->guides || smooth;
    memset(&picture->layout, 0, sizeof picture->layout);
    if (!picture->apart) {
        add_light_slot(picture, "beauty",
                       air_with_collimated_is_ratio(picture->collimated) ? AIR_SLOT_RATIO
                                                                         : AIR_SLOT_TERM);
    }
    for (uint32_t t = 0; picture->apart && t < AIR_TERM_COUNT; t++) {
        if ((p->terms >> t) & 1u) {
            add_light_slot(picture, air_term_name((air_term)t), term_slot(picture, t));
        }
    }
    if (picture->guides) {
        air_film_layout_add(&picture->layout, AIR_SLOT_GUIDE, "albedo", 3);
        air_film_layout_add(&picture->layout, AIR_SLOT_GUIDE, "normal", 3);
        air_film_layout_add(&picture->layout, AIR_SLOT_GUIDE, "depth", 1);
    }
    if (p->variance_replicates > 0) {
        air_film_layout_add(&picture->layout, AIR_SLOT_SQUARES, "variance", 3);
    }
}

/* A gaussian of standard deviation radius/3, cut at the radius. */
static double gaussian(double x, double radius)
{
    const double sigma = radius / 3.0;
    return exp(-0.5 * x * x / (sigma * sigma));
}

/* The cubic with B = C = 1/3, of integral 1 [Mitchell1988, eq. 8]; negative in its outer half. */
static double mitchell(double x, double radius)
{
    const double t = fabs(x) * 2.0 / radius, scale = 2.0 / radius / 6.0;
    if (t < 1.0) {
        return scale * ((7.0 * t - 12.0) * t * t + 16.0 / 3.0);
    }
    return t < 2.0 ? scale * (((-7.0 / 3.0 * t + 12.0) * t - 20.0) * t + 32.0 / 3.0) : 0.0;
}

static double filter_value(const air_picture *picture, double x)
{
    const double radius = picture->params->filter_radius;
    return picture->params->filter == AIR_FILTER_GAUSSIAN ? gaussian(x, radius)
                                                          : mitchell(x, radius);
}

/* The distribution function of the filter's absolute value by the trapezoid rule, inverted. */
static air_status make_filter_table(air_picture *picture)
{
    enum { STEPS = 4 * AIR_FILTER_TABLE };
    const double radius = picture->params->filter_radius;
    double cumulative[STEPS + 1], sum = 0.0;
    picture->filter_table =
        air_allocate(picture->context, AIR_FILTER_TABLE + 1, sizeof *picture->filter_table);
    if (picture->filter_table == NULL) {
        return air_fail_memory(picture->context, "pixel filter");
    }
    for (int i = 0; i <= STEPS; i++) {
        const double x = radius * (2.0 * i / STEPS - 1.0), half_step = radius / STEPS;
        const double left = x - 2.0 * half_step;
        if (i > 0) {
            sum += fabs(filter_value(picture, x)) + fabs(filter_value(picture, left));
        }
        cumulative[i] = sum;
    }
    for (int k = 0, i = 0; k <= AIR_FILTER_TABLE; k++) {
        const double target = sum * k / AIR_FILTER_TABLE;
        while (i < STEPS - 1 && cumulative[i + 1] < target) {
            i++;
        }
        const double share = (target - cumulative[i]) / (cumulative[i + 1] - cumulative[i]);
        picture->filter_table[k] = (float)(radius * (2.0 * (i + share) / STEPS - 1.0));
    }
    return AIR_OK;
}

/* From the table. *weight: the filter over the density that the table has there, for filters that
 * are negative somewhere; then samples count by it. */
static float table_offset(const air_picture *picture, float u, float *weight)
{
    const float position = u * AIR_FILTER_TABLE;
    const int i = (int)position;
    const float from = picture->filter_table[i], width = picture->filter_table[i + 1] - from;
    const float offset = from + (position - (float)i) * width;
    if (picture->params->filter == AIR_FILTER_MITCHELL) {
        *weight *= (float)(filter_value(picture, (double)offset) * AIR_FILTER_TABLE) * width;
    }
    return offset;
}

static float filter_offset(const air_picture *picture, float u, float *weight)
{
    const float radius = picture->params->filter_radius;
    switch (picture->params->filter) {
    case AIR_FILTER_POINT:
        return 0.0f;
    case AIR_FILTER_BOX:
        return (2.0f * u - 1.0f) * radius;
    case AIR_FILTER_TENT:
        return u < 0.5f ? radius * (sqrtf(2.0f * u) - 1.0f)
                        : radius * (1.0f - sqrtf(2.0f - 2.0f * u));
    case AIR_FILTER_GAUSSIAN:
    case AIR_FILTER_MITCHELL:
        return table_offset(picture, u, weight);
    }
    return 0.0f;
}

float air_picture_sample_position(const air_picture *picture, uint32_t x, uint32_t y, float u,
                                  float v, float *out_x, float *out_y)
{
    float weight = 1.0f;
    *out_x = (float)x + 0.5f + filter_offset(picture, u, &weight);
    *out_y = (float)y + 0.5f + filter_offset(picture, v, &weight);
    return weight;
}

static void set_crop(air_picture *picture)
{
    const air_render_params *p = picture->params;
    for (int i = 0; i < 4; i++) {
        picture->crop[i] = (uint32_t)p->crop[i];
    }
    if (p->crop[2] == 0) {
        picture->crop[2] = (uint32_t)p->width;
        picture->crop[3] = (uint32_t)p->height;
    }
}

static air_status make_owners(air_picture *picture)
{
    air_status status = air_owner_table_create(picture->context, picture->snapshot,
                                               picture->params->methods, &picture->owners);
    if (status != AIR_OK) {
        return status;
    }
    picture->wanted = air_allocate(picture->context, air_owner_table_size(picture->owners), 1);
    if (picture->wanted == NULL) {
        return air_fail_memory(picture->context, "owner table");
    }
    air_owner_table_mask(picture->owners, AIR_METHOD_PATH, picture->wanted);
    return AIR_OK;
}

/* Where there are no surfaces nothing need be looked for on them. */
static uint32_t terms_without_place(const air_snapshot *snapshot)
{
    const uint32_t surface_terms = (1u << AIR_TERM_S0) | (1u << AIR_TERM_S_PLUS);
    return snapshot->accelerator == NULL ? surface_terms : 0;
}

air_status air_picture_init(air_picture *picture, air_context *context,
                            const air_snapshot *snapshot, const air_render_params *params)
{
    memset(picture, 0, sizeof *picture);
    picture->context = context;
    picture->snapshot = snapshot;
    picture->params = params;
    picture->start_s = air_clock(context);
    set_crop(picture);
    air_sobol_init(&picture->sobol);
    air_camera_view_init(&snapshot->cameras[air_snapshot_camera(snapshot, params->camera)],
                         params->width, params->height, &picture->view);
    const uint32_t traced = params->terms & ~air_lightmap_terms(params->lightmap);
    air_status status = make_owners(picture);
    if (status == AIR_OK &&
        (params->filter == AIR_FILTER_GAUSSIAN || params->filter == AIR_FILTER_MITCHELL)) {
        status = make_filter_table(picture);
    }
    if (status != AIR_OK) {
        return status;
    }
    if (params->pattern == AIR_PATTERN_BLUE_NOISE) {
        picture->blue_noise = air_allocate(context, 1, sizeof *picture->blue_noise);
        if (picture->blue_noise == NULL) {
            return air_fail_memory(context, "blue noise");
        }
        air_blue_noise_init(picture->blue_noise);
    }
    const air_path_settings settings = {.max_depth = params->max_depth,
                                        .wanted = picture->wanted,
                                        .terms = traced & ~terms_without_place(snapshot),
                                        .guides = params->guides,
                                        .vertex_hook = params->vertex_hook,
                                        .vertex_hook_user = params->vertex_hook_user};
    status = air_path_init(&picture->path, snapshot, &picture->sobol, &settings);
    if (status == AIR_OK) {
        status = air_with_collimated_create(&picture->path, picture->owners, &picture->view, traced,
                                            &picture->collimated);
    }
    if (status == AIR_OK) {
        status = air_with_arealight_create(&picture->path, picture->owners, params, traced,
                                           &picture->arealight);
    }
    if (status == AIR_OK) {
        const bool split = params->layers || air_with_arealight_is_ratio(picture->arealight);
        status = air_with_ordinates_create(&picture->path, picture->owners, &picture->view, params,
                                           traced, split, &picture->ordinates);
    }
    if (status == AIR_OK) {
        status = air_with_lightmap_create(&picture->path, params->lightmap, params->terms,
                                          &picture->lightmap);
    }
    make_layout(picture);
    return status;
}

void air_picture_finish(air_picture *picture)
{
    air_with_lightmap_destroy(picture->lightmap);
    air_with_ordinates_destroy(picture->ordinates);
    air_with_arealight_destroy(picture->arealight);
    air_with_collimated_destroy(picture->collimated);
    air_path_finish(&picture->path);
    air_owner_table_destroy(picture->owners);
    air_free(picture->context, picture->wanted);
    air_free(picture->context, picture->filter_table);
    air_free(picture->context, picture->blue_noise);
}

air_status air_picture_film(const air_picture *picture, air_film **out_film)
{
    const air_render_params *p = picture->params;
    air_film description;
    memset(&description, 0, sizeof description);
    description.width = (uint32_t)p->width;
    description.height = (uint32_t)p->height;
    memcpy(description.crop, picture->crop, sizeof description.crop);
    description.seed = p->seed;
    description.settings = settings_hash(picture);
    description.layout = picture->layout;
    if (p->variance_replicates > 0) {
        description.replicate_size = (p->sample_end - p->sample_begin) / p->variance_replicates;
    }
    return air_film_create(picture->context, &description, out_film);
}

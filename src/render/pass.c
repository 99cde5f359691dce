/* pass.c: one run of samples for every pixel: tiles in parallel, within a pixel blocks of 16
 * samples in index order. */
#include <stdatomic.h>
#include <string.h>

#include "render/picture.h"

/* What one worker writes to. */
typedef struct pass_worker {
    air_path_scratch *scratch;
    air_collimated_scratch *collimated; /* NULL where that method owns nothing */
    air_area_scratch *arealight;        /* likewise */
    air_march_scratch *ordinates;       /* likewise */
    double *block;                      /* sums of the block under way */
    air_block_stack stack;
    /* Of the replicate under way: the sums of two ratios; all that is plain is in the first. */
    double volume[12], surface[12];
} pass_worker;

typedef struct render_pass {
    const air_picture *picture;
    const air_film *film;
    uint32_t begin, end;
    air_film_node *nodes;
    size_t node_count;
    pass_worker *workers;
    size_t tiles_x, tiles_y;
    atomic_size_t tiles_done;
    atomic_bool stop;
} render_pass;

/* ---- one pixel ---- */

static uint32_t picture_seed(const air_picture *picture)
{
    const uint64_t seed = picture->params->seed;
    return air_hash_combine((uint32_t)seed, (uint32_t)(seed >> 32));
}

static uint32_t pixel_seed(const air_picture *picture, uint32_t x, uint32_t y, uint32_t replicate)
{
    uint32_t hash = air_hash_combine(picture_seed(picture), x);
    hash = air_hash_combine(hash, y);
    return air_hash_combine(hash, replicate);
}

/* The number for the distance along a beam, by a pattern that is not that of the other numbers. */
static float beam_number(const render_pass *pass, uint32_t x, uint32_t y, uint32_t replicate,
                         uint32_t index)
{
    const air_picture *picture = pass->picture;
    /* The number of samples must not matter, or films of parts would not add up: blue noise is
     * tuned to pictures of four samples. */
    const air_pattern_source source = {.pattern = picture->params->pattern,
                                       .tile = picture->blue_noise,
                                       .log2_count = 2,
                                       .seed = air_hash_combine(picture_seed(picture), replicate)};
    return fminf((float)air_pattern_get(&source, x, y, index), 0x1.fffffep-1f);
}

/* Places on a lens have a set of random numbers of their own, beyond those of events. */
enum { LENS_SET = 0x6c656e73 };

/* Returns how much the sample counts. */
static float make_lane(const render_pass *pass, uint32_t x, uint32_t y, uint32_t sample,
                       air_path_lane *lane)
{
    const air_picture *picture = pass->picture;
    const uint32_t size = pass->film->replicate_size;
    const uint32_t replicate = size > 0 ? sample / size + 1 : 0;
    const uint32_t index = size > 0 ? sample % size : sample;
    float at_x, at_y;
    lane->sampler = air_sampler_make(&picture->sobol, pixel_seed(picture, x, y, replicate), index);
    const air_f32x4 u = air_sampler_get(&lane->sampler, 0);
    const float weight = air_picture_sample_position(picture, x, y, u[0], u[1], &at_x, &at_y);
    const air_f32x4 lens = picture->view.lens_radius > 0.0f
                               ? air_sampler_get(&lane->sampler, LENS_SET)
                               : (air_f32x4){0.0f, 0.0f, 0.0f, 0.0f};
    air_camera_view_lens_ray(&picture->view, at_x, at_y, lens[0], lens[1], &lane->origin,
                             &lane->dir);
    lane->u_distance = u[2];
    lane->u_pick = u[3];
    lane->u_beam = picture->params->pattern == AIR_PATTERN_STRATIFIED
                       ? u[2]
                       : beam_number(pass, x, y, replicate, index);
    lane->x = x;
    lane->y = y;
    lane->sample = sample;
    return weight;
}

static void add3(double *sum, air_vec3 v)
{
    sum[0] += (double)v.x;
    sum[1] += (double)v.y;
    sum[2] += (double)v.z;
}

static air_vec3 lane_beauty(const air_path_lane *lane)
{
    air_vec3 sum = lane->terms[0];
    for (int t = 1; t < AIR_TERM_COUNT; t++) {
        sum = vec3_add(sum, lane->terms[t]);
    }
    return sum;
}

static void add_ratio(double *sums, const air_ratio_sample *ratio, air_vec3 plain)
{
    add3(sums, ratio->analytic);
    add3(sums + 3, ratio->unoccluded);
    add3(sums + 6, ratio->occluded);
    add3(sums + 9, plain);
}

/* Adds one value to a slot of light; returns where the next slot begins. */
static double *add_light(const render_pass *pass, double *sums, const air_film_slot *slot,
                         air_vec3 plain, const air_ratio_sample *ratio)
{
    if (air_slot_is_ratio(slot->kind)) {
        add_ratio(sums, ratio, plain);
    } else {
        add3(sums, plain);
    }
    if (slot->kind == AIR_SLOT_SHARE) {
        sums[12] += pass->picture->params->shadow_samples;
    }
    return sums + slot->components;
}

/* The ratio that belongs to a term, where there is one. */
static const air_ratio_sample *ratio_of(const air_lane_ratios *ratios, uint32_t term)
{
    return term == AIR_TERM_S0 ? &ratios->surface : &ratios->volume;
}

static void add_replicate(const render_pass *pass, pass_worker *worker, const air_path_lane *lane,
                          const air_lane_ratios *ratios, double *sum)
{
    add_ratio(worker->volume, &ratios->volume, lane_beauty(lane));
    add_ratio(worker->surface, &ratios->surface, vec3_set1(0.0f));
    if ((lane->sample + 1) % pass->film->replicate_size == 0) {
        for (uint32_t c = 0; c < 3; c++) {
            const double beauty =
                air_ratio_total(worker->volume, c) + air_ratio_total(worker->surface, c);
            sum[c] += beauty * beauty;
        }
        memset(worker->volume, 0, sizeof worker->volume);
        memset(worker->surface, 0, sizeof worker->surface);
    }
}

/* Adds one sample to the sums of its block. */
static void accumulate(const render_pass *pass, pass_worker *worker, const air_path_lane *lane,
                       const air_lane_ratios *ratios)
{
    const air_picture *picture = pass->picture;
    const air_film_slot *slot = pass->film->layout.slots;
    double *sum = worker->block;
    if (!picture->apart) {
        sum = add_light(pass, sum, slot++, lane_beauty(lane), &ratios->volume);
    }
    for (uint32_t t = 0; picture->apart && t < AIR_TERM_COUNT; t++) {
        if ((picture->params->terms >> t) & 1u) {
            sum = add_light(pass, sum, slot++, lane->terms[t], ratio_of(ratios, t));
        }
    }
    if (picture->guides) {
        add3(sum, lane->albedo);
        add3(sum + 3, lane->normal);
        sum[6] += (double)lane->depth;
        sum += 7;
    }
    if (pass->film->replicate_size > 0) {
        add_replicate(pass, worker, lane, ratios, sum);
    }
}

/* Where a pixel is on the film's image. */
typedef struct pixel {
    uint32_t x, y;
} pixel;

static void scale3(air_vec3 *v, float weight) { *v = vec3_scale(*v, weight); }

/* All sums of a sample, in place. */
static void weigh(float weight, air_path_lane *lane, air_lane_ratios *ratios)
{
    air_ratio_sample *const both[2] = {&ratios->volume, &ratios->surface};
    for (int t = 0; t < AIR_TERM_COUNT; t++) {
        scale3(&lane->terms[t], weight);
    }
    for (int k = 0; k < 2; k++) {
        scale3(&both[k]->analytic, weight);
        scale3(&both[k]->unoccluded, weight);
        scale3(&both[k]->occluded, weight);
    }
    scale3(&lane->albedo, weight);
    scale3(&lane->normal, weight);
    lane->depth *= weight;
}

static void trace_block(const render_pass *pass, pass_worker *worker, air_path_lane *lanes,
                        air_lane_ratios *ratios, size_t count)
{
    const air_picture *picture = pass->picture;
    air_path_trace(&picture->path, worker->scratch, lanes, count);
    memset(ratios, 0, count * sizeof *ratios);
    if (picture->collimated != NULL) {
        air_with_collimated_add(picture->collimated, worker->collimated, lanes, ratios, count);
    }
    if (picture->arealight != NULL) {
        air_with_arealight_add(picture->arealight, worker->arealight, lanes, ratios, count);
    }
    if (picture->ordinates != NULL) {
        air_with_ordinates_add(picture->ordinates, worker->ordinates, lanes, count);
    }
    if (picture->lightmap != NULL) {
        air_with_lightmap_add(picture->lightmap, worker->scratch, lanes, count);
    }
}

/* Samples [begin, end) of each pixel, together no more than there are lanes; the last ones of their
 * node if that is where it ends. */
static void render_block(const render_pass *pass, pass_worker *worker, const pixel *pixels,
                         size_t count, const air_film_node *node, uint32_t begin, uint32_t end)
{
    const air_film *film = pass->film;
    const size_t row = film->crop[2] - film->crop[0], stride = film->layout.stride;
    const uint32_t size = end - begin;
    air_path_lane lanes[AIR_PATH_LANES];
    air_lane_ratios ratios[AIR_PATH_LANES];
    float weights[AIR_PATH_LANES];
    for (size_t i = 0; i < count * size; i++) {
        const pixel *at = &pixels[i / size];
        weights[i] = make_lane(pass, at->x, at->y, begin + (uint32_t)(i % size), &lanes[i]);
    }
    trace_block(pass, worker, lanes, ratios, count * size);
    for (size_t i = 0; i < count * size; i++) {
        if (weights[i] != 1.0f) {
            weigh(weights[i], &lanes[i], &ratios[i]);
        }
    }
    for (size_t i = 0; i < count; i++) {
        memset(worker->block, 0, stride * sizeof *worker->block);
        for (size_t s = i * size; s < (i + 1) * size; s++) {
            accumulate(pass, worker, &lanes[s], &ratios[s]);
        }
        air_block_stack_push(&worker->stack, worker->block);
        if (end == node->end) {
            const size_t place = (size_t)(pixels[i].y - film->crop[1]) * row + pixels[i].x;
            air_block_stack_total(&worker->stack, node->sums + (place - film->crop[0]) * stride);
        }
    }
}

/* How many pixels go together: many where a pixel does not fill the lanes by itself. */
static size_t group_size(const render_pass *pass)
{
    const uint32_t size = pass->nodes[0].end - pass->nodes[0].begin;
    return pass->node_count == 1 && size < AIR_PATH_LANES ? AIR_PATH_LANES / size : 1;
}

static void render_group(const render_pass *pass, pass_worker *worker, const pixel *pixels,
                         size_t count)
{
    for (size_t n = 0; n < pass->node_count; n++) {
        const air_film_node *node = &pass->nodes[n];
        for (uint32_t s = node->begin, stop; s < node->end; s = stop) {
            stop = node->end - s < AIR_FILM_BLOCK ? node->end : s + AIR_FILM_BLOCK;
            render_block(pass, worker, pixels, count, node, s, stop);
        }
    }
}

/* ---- tiles ---- */

/* Of the samples, or of the time where that is limited, whichever is nearer to its end. */
static double fraction_done(const render_pass *pass, double share)
{
    const air_picture *picture = pass->picture;
    const air_render_params *p = picture->params;
    const double before = pass->begin - p->sample_begin, now = pass->end - pass->begin;
    const double samples = (before + now * share) / (p->sample_end - p->sample_begin);
    const double time = (air_clock(picture->context) - picture->start_s) / p->time_limit_s;
    return fmin(fmax(samples, time), 1.0);
}

/* Pixels are visited in squares of 8 x 8, in turn made of 4 x 4, in which rays meet the same parts
 * of the scene. */
enum { SQUARE = 8 };

static void render_square(const render_pass *pass, pass_worker *worker, uint32_t x0, uint32_t y0,
                          uint32_t x1, uint32_t y1)
{
    pixel pixels[SQUARE * SQUARE];
    const size_t group = group_size(pass);
    size_t count = 0;
    for (uint32_t i = 0; i < SQUARE * SQUARE; i++) {
        const pixel at = {x0 + i % 4 + i / 16 % 2 * 4, y0 + i / 4 % 4 + i / 32 * 4};
        if (at.x < x1 && at.y < y1) {
            pixels[count++] = at;
        }
    }
    for (size_t i = 0; i < count; i += group) {
        render_group(pass, worker, pixels + i, count - i < group ? count - i : group);
    }
}

static void render_tile(void *user, size_t index, size_t worker_index)
{
    render_pass *pass = user;
    pass_worker *worker = &pass->workers[worker_index];
    const air_film *film = pass->film;
    const uint32_t size = (uint32_t)pass->picture->params->tile_size;
    const uint32_t x0 = film->crop[0] + (uint32_t)(index % pass->tiles_x) * size;
    const uint32_t y0 = film->crop[1] + (uint32_t)(index / pass->tiles_x) * size;
    if (atomic_load_explicit(&pass->stop, memory_order_relaxed)) {
        return;
    }
    const uint32_t x1 = film->crop[2] - x0 < size ? film->crop[2] : x0 + size;
    const uint32_t y1 = film->crop[3] - y0 < size ? film->crop[3] : y0 + size;
    for (uint32_t y = y0; y < y1; y += SQUARE) {
        for (uint32_t x = x0; x < x1; x += SQUARE) {
            render_square(pass, worker, x, y, x1, y1);
        }
    }
    const size_t done = atomic_fetch_add(&pass->tiles_done, 1) + 1;
    const double share = (double)done / (double)(pass->tiles_x * pass->tiles_y);
    if (!air_progress(pass->picture->context, fraction_done(pass, share), "render")) {
        atomic_store(&pass->stop, true);
    }
}

static void free_workers(render_pass *pass, size_t count)
{
    air_context *context = pass->picture->context;
    for (size_t i = 0; pass->workers != NULL && i < count; i++) {
        air_free(context, pass->workers[i].scratch);
        air_collimated_scratch_destroy(pass->picture->collimated, pass->workers[i].collimated);
        air_area_scratch_destroy(pass->picture->arealight, pass->workers[i].arealight);
        air_march_scratch_destroy(pass->picture->ordinates, pass->workers[i].ordinates);
        air_free(context, pass->workers[i].block);
        air_free(context, pass->workers[i].stack.sums);
    }
    air_free(context, pass->workers);
}

static air_status make_workers(render_pass *pass, size_t count)
{
    air_context *context = pass->picture->context;
    const uint32_t stride = pass->film->layout.stride;
    pass->workers = air_allocate(context, count, sizeof *pass->workers);
    bool complete = pass->workers != NULL;
    for (size_t i = 0; complete && i < count; i++) {
        pass_worker *worker = &pass->workers[i];
        worker->scratch = air_allocate(context, 1, air_path_scratch_size());
        worker->block = air_allocate(context, stride, sizeof(double));
        worker->stack.stride = stride;
        worker->stack.sums =
            air_allocate(context, (size_t)(AIR_FILM_MAX_LEVELS + 1) * stride, sizeof(double));
        complete = worker->scratch != NULL && worker->block != NULL && worker->stack.sums != NULL;
        if (complete && pass->picture->collimated != NULL) {
            const air_status status =
                air_collimated_scratch_create(pass->picture->collimated, &worker->collimated);
            if (status != AIR_OK) {
                return status;
            }
        }
        if (complete && pass->picture->arealight != NULL) {
            const air_status status =
                air_area_scratch_create(pass->picture->arealight, &worker->arealight);
            if (status != AIR_OK) {
                return status;
            }
        }
        if (complete && pass->picture->ordinates != NULL) {
            const air_status status =
                air_march_scratch_create(pass->picture->ordinates, &worker->ordinates);
            if (status != AIR_OK) {
                return status;
            }
        }
    }
    return complete ? AIR_OK : air_fail_memory(context, "render workers");
}

static air_status make_nodes(render_pass *pass, air_film_node nodes[AIR_FILM_MAX_LEVELS * 2])
{
    air_status status = AIR_OK;
    pass->nodes = nodes;
    for (uint32_t begin = pass->begin; begin < pass->end && status == AIR_OK;) {
        const uint32_t end = air_film_node_end(begin, pass->end);
        status = air_film_node_create(pass->film, begin, end, &nodes[pass->node_count]);
        pass->node_count += status == AIR_OK;
        begin = end;
    }
    return status;
}

air_status air_picture_pass(air_picture *picture, air_film *film, uint32_t begin, uint32_t end)
{
    const size_t tile = picture->params->tile_size;
    const size_t worker_count = air_context_thread_count(picture->context);
    air_film_node nodes[AIR_FILM_MAX_LEVELS * 2];
    render_pass pass = {.picture = picture, .film = film, .begin = begin, .end = end};
    pass.tiles_x = (air_film_width(film) + tile - 1) / tile;
    pass.tiles_y = (air_film_height(film) + tile - 1) / tile;
    air_status status = make_nodes(&pass, nodes);
    if (status == AIR_OK) {
        status = make_workers(&pass, worker_count);
    }
    if (status == AIR_OK) {
        air_parallel_for(picture->context, pass.tiles_x * pass.tiles_y, render_tile, &pass);
        if (atomic_load(&pass.stop)) {
            status = air_fail(picture->context, AIR_ERROR_INTERRUPTED, "render: interrupted");
        }
    }
    for (size_t n = 0; n < pass.node_count && status == AIR_OK; n++) {
        status = air_film_add(film, &nodes[n]);
    }
    for (size_t n = 0; n < pass.node_count; n++) {
        air_free(picture->context, nodes[n].sums);
    }
    free_workers(&pass, worker_count);
    return status;
}

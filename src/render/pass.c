/* pass.c: one run of samples for every pixel: tiles in parallel, within a pixel blocks of 16
 * samples in index order. */
#include <stdatomic.h>
#include <string.h>

#include "render/picture.h"

/* What one worker writes to. */
typedef struct pass_worker {
    air_path_scratch *scratch;
    double *block; /* sums of the block under way */
    air_block_stack stack;
    double replicate[3]; /* beauty of the replicate under way */
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

static uint32_t pixel_seed(const air_picture *picture, uint32_t x, uint32_t y, uint32_t replicate)
{
    const uint64_t seed = picture->params->seed;
    uint32_t hash = air_hash_combine((uint32_t)seed, (uint32_t)(seed >> 32));
    hash = air_hash_combine(hash, x);
    hash = air_hash_combine(hash, y);
    return air_hash_combine(hash, replicate);
}

static void make_lane(const render_pass *pass, uint32_t x, uint32_t y, uint32_t sample,
                      air_path_lane *lane)
{
    const air_picture *picture = pass->picture;
    const uint32_t size = pass->film->replicate_size;
    const uint32_t replicate = size > 0 ? sample / size + 1 : 0;
    const uint32_t index = size > 0 ? sample % size : sample;
    float at_x, at_y;
    lane->sampler = air_sampler_make(&picture->sobol, pixel_seed(picture, x, y, replicate), index);
    const air_f32x4 u = air_sampler_get(&lane->sampler, 0);
    air_picture_sample_position(picture, x, y, u[0], u[1], &at_x, &at_y);
    air_camera_view_ray(&picture->view, at_x, at_y, &lane->origin, &lane->dir);
    lane->u_distance = u[2];
    lane->u_pick = u[3];
    lane->x = x;
    lane->y = y;
    lane->sample = sample;
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

/* Adds one sample to the sums of its block. */
static void accumulate(const render_pass *pass, pass_worker *worker, const air_path_lane *lane)
{
    const air_render_params *p = pass->picture->params;
    const uint32_t size = pass->film->replicate_size;
    double *sum = worker->block;
    if (!p->layers) {
        add3(sum, lane_beauty(lane));
        sum += 3;
    }
    for (uint32_t t = 0; p->layers && t < AIR_TERM_COUNT; t++) {
        if ((p->terms >> t) & 1u) {
            add3(sum, lane->terms[t]);
            sum += 3;
        }
    }
    if (p->guides) {
        add3(sum, lane->albedo);
        add3(sum + 3, lane->normal);
        sum[6] += (double)lane->depth;
        sum += 7;
    }
    if (size > 0) {
        add3(worker->replicate, lane_beauty(lane));
        for (int c = 0; c < 3 && (lane->sample + 1) % size == 0; c++) {
            sum[c] += worker->replicate[c] * worker->replicate[c];
            worker->replicate[c] = 0.0;
        }
    }
}

static void render_block(const render_pass *pass, pass_worker *worker, uint32_t x, uint32_t y,
                         uint32_t begin, uint32_t end)
{
    air_path_lane lanes[AIR_PATH_LANES];
    for (uint32_t s = begin; s < end; s++) {
        make_lane(pass, x, y, s, &lanes[s - begin]);
    }
    air_path_trace(&pass->picture->path, worker->scratch, lanes, end - begin);
    memset(worker->block, 0, pass->film->layout.stride * sizeof *worker->block);
    for (uint32_t s = begin; s < end; s++) {
        accumulate(pass, worker, &lanes[s - begin]);
    }
}

static void render_pixel(const render_pass *pass, pass_worker *worker, uint32_t x, uint32_t y)
{
    const air_film *film = pass->film;
    const size_t row = film->crop[2] - film->crop[0];
    const size_t pixel = (size_t)(y - film->crop[1]) * row + (x - film->crop[0]);
    for (size_t n = 0; n < pass->node_count; n++) {
        const air_film_node *node = &pass->nodes[n];
        for (uint32_t s = node->begin, stop; s < node->end; s = stop) {
            stop = node->end - s < AIR_FILM_BLOCK ? node->end : s + AIR_FILM_BLOCK;
            render_block(pass, worker, x, y, s, stop);
            air_block_stack_push(&worker->stack, worker->block);
        }
        air_block_stack_total(&worker->stack, node->sums + pixel * film->layout.stride);
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
    for (uint32_t y = y0; y < film->crop[3] && y < y0 + size; y++) {
        for (uint32_t x = x0; x < film->crop[2] && x < x0 + size; x++) {
            render_pixel(pass, worker, x, y);
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

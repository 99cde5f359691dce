#include "bake/sites.h"

#include <stdatomic.h>
#include <string.h>

#include "bake/progress.h"

typedef struct sites_run {
    const air_path *path;
    air_site_list *list;
    air_bake_progress *progress;
    air_path_scratch **scratch; /* one per worker */
    double begin, end;
    size_t job_count;
    atomic_size_t done;
    atomic_int status; /* the first that is not AIR_OK */
} sites_run;

/* ---- one site ---- */

/* Samples that began inside of something say nothing about the others, as long as they are many;
 * few of them are gaps between surfaces, and light like any other. */
#define BURIED_SHARE 0.05

static void write_record(const air_site_list *list, air_gain *open, const air_gain *buried,
                         float *record)
{
    const double all = open->samples + buried->samples;
    const double validity = all > 0.0 ? open->samples / all : 0.0;
    if (buried->samples <= BURIED_SHARE * all) {
        air_gain_merge(open, buried, list->coefficients);
    }
    const double n = open->samples, scale = n > 0.0 ? 1.0 / n : 0.0;
    float *harmonics = record + AIR_SITE_HARMONICS;
    memset(record, 0, air_site_stride(list) * sizeof *record);
    for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        const double *light = open->layers[layer];
        const double mean = (0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2]) * scale;
        for (size_t c = 0; c < 3; c++) {
            record[AIR_SITE_LIGHT + 3 * layer + c] = (float)(light[c] * scale);
        }
        if (n > 1.0) {
            record[AIR_SITE_VARIANCE + layer] =
                (float)(double_max(open->squares[layer] * scale - mean * mean, 0.0) / (n - 1.0));
        }
        for (size_t i = 0; i < (size_t)3 * list->coefficients; i++) {
            harmonics[i] += (float)(open->harmonics[layer][i / 3][i % 3] * scale);
        }
        harmonics += list->apart ? 3 * list->coefficients : 0;
    }
    record[AIR_SITE_VALIDITY] = (float)validity;
}

static void sample_site(const sites_run *run, air_path_scratch *scratch, size_t site)
{
    const air_path *path = run->path;
    air_site_list *list = run->list;
    const uint32_t seed = air_hash_combine(list->seed, (uint32_t)site);
    air_gain open, buried;
    memset(&open, 0, sizeof open);
    memset(&buried, 0, sizeof buried);
    for (uint32_t first = 0; first < list->samples; first += AIR_PATH_LANES) {
        air_path_receiver receivers[AIR_PATH_LANES];
        air_path_lane lanes[AIR_PATH_LANES];
        air_vec3 axes[AIR_PATH_LANES][AIR_GAIN_AXES];
        size_t count = 0;
        for (uint32_t s = first; s < first + AIR_PATH_LANES && s < list->samples; s++) {
            lanes[count].sampler = air_sampler_make(path->sobol, seed, s);
            const air_f32x4 u = air_sampler_get(&lanes[count].sampler, 0);
            const float at[2] = {u[0], u[1]};
            lanes[count].receiver = &receivers[count];
            lanes[count].through_weight =
                s < list->through ? (float)list->samples / (float)list->through : 0.0f;
            if (list->draw(list->user, site, at, &receivers[count])) {
                if (path->settings.respond.patch != NULL) {
                    air_gain_set_axes(&receivers[count], list->coefficients, axes[count]);
                }
                count++;
            }
        }
        air_path_receive(path, scratch, lanes, count);
        for (size_t i = 0; i < count; i++) {
            air_gain_add(air_gain_is_buried(path->snapshot, &lanes[i]) ? &buried : &open, &lanes[i],
                         list->coefficients);
        }
    }
    write_record(list, &open, &buried, list->records + site * air_site_stride(list));
}

/* ---- all of them ---- */

static void note(sites_run *run, air_status status)
{
    int expected = AIR_OK;
    atomic_compare_exchange_strong(&run->status, &expected, (int)status);
}

static void run_job(void *user, size_t job, size_t worker)
{
    sites_run *run = user;
    air_site_list *list = run->list;
    const size_t first = job * AIR_SITE_JOB;
    const size_t last = list->count - first < AIR_SITE_JOB ? list->count : first + AIR_SITE_JOB;
    if (atomic_load(&run->status) != AIR_OK) {
        return;
    }
    if (air_bake_progress_has(run->progress, job)) {
        atomic_fetch_add(&run->done, 1);
        return;
    }
    for (size_t site = first; site < last; site++) {
        sample_site(run, run->scratch[worker], site);
    }
    const air_status status = air_bake_progress_keep(run->progress, list, job);
    if (status != AIR_OK) {
        note(run, status);
        return;
    }
    const double share = (double)(atomic_fetch_add(&run->done, 1) + 1) / (double)run->job_count;
    air_context *context = run->path->snapshot->context;
    if (!air_progress(context, run->begin + (run->end - run->begin) * share, list->what)) {
        note(run, AIR_ERROR_INTERRUPTED);
    }
}

static air_status make_scratch(sites_run *run, air_context *context, size_t workers)
{
    run->scratch = air_allocate(context, workers, sizeof *run->scratch);
    bool complete = run->scratch != NULL;
    for (size_t i = 0; complete && i < workers; i++) {
        run->scratch[i] = air_allocate(context, 1, air_path_scratch_size());
        complete = run->scratch[i] != NULL;
    }
    return complete ? AIR_OK : air_fail_memory(context, "bake");
}

air_status air_sites_run(const air_path *path, air_site_list *list, air_bake_progress *progress,
                         double fraction_begin, double fraction_end)
{
    air_context *context = path->snapshot->context;
    const size_t workers = air_context_thread_count(context);
    sites_run run = {.path = path,
                     .list = list,
                     .progress = progress,
                     .begin = fraction_begin,
                     .end = fraction_end,
                     .job_count = air_site_job_count(list)};
    if (list->records == NULL) {
        list->records = air_allocate(context, list->count, air_site_stride(list) * sizeof(float));
    }
    air_status status = list->records == NULL ? air_fail_memory(context, list->what) : AIR_OK;
    if (status == AIR_OK) {
        status = air_bake_progress_enter(progress, list);
    }
    if (status == AIR_OK) {
        status = make_scratch(&run, context, workers);
    }
    if (status == AIR_OK) {
        air_parallel_for(context, run.job_count, run_job, &run);
        status = (air_status)atomic_load(&run.status);
        if (status == AIR_ERROR_INTERRUPTED) {
            status = air_fail(context, status, "bake: interrupted");
        } else if (status != AIR_OK) {
            status = air_bake_progress_fail(progress);
        }
    }
    for (size_t i = 0; run.scratch != NULL && i < workers; i++) {
        air_free(context, run.scratch[i]);
    }
    air_free(context, run.scratch);
    return status;
}

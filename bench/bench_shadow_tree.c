/* Exact shadows of meshes in haze: time to build the tree, time per pixel on one core after the
 * primary ray (light-space set-up, profile, query, closed form), error against an independent
 * search in doubles, and the ratio to whole-volume sampling with shadow rays in packets of 16 at
 * about equal error. Medians over rounds; every pair that is compared runs in turn. */
#include <float.h>

#include "beam_scenes.h"
#include "core/host.h"
#include "shadow_wedge.h"

enum { ROUNDS = 5, TILE = 8, INTERVALS = 512, MOST_SAMPLES = 4096, PACKET = 16, BATCH = 16 };

/* One scene being measured. */
typedef struct work {
    const beam_settings *settings;
    beam_soup soup;
    air_collimated_medium medium;
    double to_light[3];
    double (*dirs)[3];
    double *t_max;
    double *exact, *sampled; /* pictures */
    size_t pixels;
    size_t *order; /* pixels in tiles */
    const air_ray_backend *rays;
    void *accelerator;
} work;

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare);
    return values[count / 2];
}

static air_context *make_context(size_t threads, air_cpu cpu)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.thread_count = threads;
    params.cpu = cpu;
    return air_context_create(&params, &context) == AIR_OK ? context : NULL;
}

/* ---- set-up ---- */

static void make_order(work *w)
{
    const int width = w->settings->width, height = w->settings->height;
    size_t next = 0;
    for (int y = 0; y < height; y += TILE) {
        for (int x = 0; x < width; x += TILE) {
            for (int i = 0; i < TILE * TILE; i++) {
                const int px = x + i % 4 + 4 * (i / 16 % 2), py = y + i / 4 % 4 + 4 * (i / 32);
                if (px < width && py < height) {
                    w->order[next++] = (size_t)py * (size_t)width + (size_t)px;
                }
            }
        }
    }
}

static void make_primary(work *w)
{
    const double *eye = w->settings->eye;
    for (size_t i = 0; i < w->pixels; i++) {
        const int x = (int)(i % (size_t)w->settings->width),
                  y = (int)(i / (size_t)w->settings->width);
        air_hit hit;
        beam_ray(w->settings, x, y, w->dirs[i]);
        const double *d = w->dirs[i];
        const air_ray ray = {{(float)eye[0], (float)eye[1], (float)eye[2]},
                             0.0f,
                             {(float)d[0], (float)d[1], (float)d[2]},
                             FLT_MAX,
                             1};
        w->rays->intersect(w->accelerator, &ray, 1, &hit);
        w->t_max[i] = hit.mesh == (uint32_t)AIR_NO_HIT ? INFINITY : (double)hit.t;
    }
}

static bool work_make(work *w, air_context *context, const beam_settings *settings)
{
    *w = (work){.settings = settings};
    if (!beam_soup_make(context, settings, &w->soup)) {
        return false;
    }
    beam_medium(settings, &w->medium);
    memcpy(w->to_light, settings->to_light, sizeof w->to_light);
    beam_normalize(w->to_light);
    w->pixels = (size_t)settings->width * (size_t)settings->height;
    w->dirs = malloc(w->pixels * sizeof *w->dirs);
    w->t_max = malloc(w->pixels * sizeof *w->t_max);
    w->exact = malloc(w->pixels * sizeof *w->exact);
    w->sampled = malloc(w->pixels * sizeof *w->sampled);
    w->order = malloc(w->pixels * sizeof *w->order);
    w->rays = air_context_ray_backend(context);
    const air_ray_mesh mesh = {w->soup.positions, 3 * w->soup.triangle_count, w->soup.indices,
                               w->soup.triangle_count, 1};
    if (w->rays->build(w->rays->user, context, &mesh, 1, &w->accelerator) != AIR_OK) {
        abort();
    }
    make_order(w);
    make_primary(w);
    return true;
}

static void work_free(work *w)
{
    w->rays->destroy(w->accelerator);
    beam_soup_free(&w->soup);
    free(w->dirs);
    free(w->t_max);
    free(w->exact);
    free(w->sampled);
    free(w->order);
}

/* ---- the three ways to a picture ---- */

static bool make_profile(const work *w, size_t pixel, air_collimated_profile *profile)
{
    air_collimated_profile_make(&w->medium, w->to_light, w->settings->sigma_t, w->settings->eye,
                                w->dirs[pixel], w->t_max[pixel], profile);
    return profile->count > 0;
}

static double lit_integral(const air_collimated_profile *profile, const air_interval *shadows,
                           size_t count)
{
    static air_interval gaps[INTERVALS + 1];
    const size_t gap_count = air_intervals_gaps(shadows, count, profile->pieces[0].t0,
                                                profile->pieces[profile->count - 1].t1, gaps);
    double sum = 0.0;
    for (size_t i = 0; i < gap_count; i++) {
        sum += air_collimated_partial_integral(profile, gaps[i].begin, gaps[i].end);
    }
    return sum;
}

/* A batch of neighbouring pixels, on its way. */
typedef struct batch {
    size_t count;
    size_t pixels[BATCH];
    air_collimated_profile profiles[BATCH];
    air_collimated_piece pieces[BATCH][8];
    air_shadow_query queries[BATCH];
    air_interval shadows[BATCH][INTERVALS];
} batch;

static void batch_add(const work *w, batch *b, size_t pixel)
{
    const size_t k = b->count;
    air_collimated_profile *profile = &b->profiles[k];
    *profile = (air_collimated_profile){.pieces = b->pieces[k], .capacity = 8};
    w->exact[pixel] = 0.0;
    if (!make_profile(w, pixel, profile)) {
        return;
    }
    b->pixels[k] = pixel;
    b->queries[k] = (air_shadow_query){.begin = profile->pieces[0].t0,
                                       .end = profile->pieces[profile->count - 1].t1,
                                       .out = b->shadows[k],
                                       .capacity = INTERVALS};
    memcpy(b->queries[k].origin, w->settings->eye, sizeof b->queries[k].origin);
    memcpy(b->queries[k].dir, w->dirs[pixel], sizeof b->queries[k].dir);
    b->count++;
}

static double render_exact(const work *w, const air_shadow_tree *tree, air_context *context)
{
    static batch b;
    const double start = air_clock(context);
    for (size_t i = 0; i < w->pixels;) {
        b.count = 0;
        for (const size_t stop = i + BATCH; i < w->pixels && i < stop; i++) {
            batch_add(w, &b, w->order[i]);
        }
        air_shadow_tree_query_rays(tree, b.queries, b.count);
        for (size_t k = 0; k < b.count; k++) {
            const air_shadow_query *query = &b.queries[k];
            w->exact[b.pixels[k]] = query->count > INTERVALS
                                        ? NAN
                                        : lit_integral(&b.profiles[k], query->out, query->count);
        }
    }
    return air_clock(context) - start;
}

/* Samples at one offset per pixel, u = (k + xi) / n. */
static double render_sampled(const work *w, int samples, air_context *context)
{
    static air_ray rays[MOST_SAMPLES];
    static uint8_t occluded[MOST_SAMPLES];
    air_collimated_piece pieces[8];
    const double *eye = w->settings->eye;
    const double start = air_clock(context);
    for (size_t i = 0; i < w->pixels; i++) {
        const size_t pixel = w->order[i];
        air_collimated_profile profile = {.pieces = pieces, .capacity = 8};
        w->sampled[pixel] = 0.0;
        if (!make_profile(w, pixel, &profile)) {
            continue;
        }
        const double xi = (double)((uint32_t)pixel * 2654435769u) * 0x1p-32;
        for (int k = 0; k < samples; k++) {
            const double t = air_collimated_sample(&profile, (k + xi) / samples);
            for (int c = 0; c < 3; c++) {
                rays[k].origin[c] = (float)(eye[c] + t * w->dirs[pixel][c]);
                rays[k].dir[c] = (float)w->to_light[c];
            }
            rays[k].tmin = 0.0f;
            rays[k].tmax = FLT_MAX;
            rays[k].mask = 1;
        }
        int lit = 0;
        for (int k = 0; k < samples; k += PACKET) {
            const int n = samples - k < PACKET ? samples - k : PACKET;
            w->rays->occluded(w->accelerator, rays + k, (size_t)n, occluded + k);
        }
        for (int k = 0; k < samples; k++) {
            lit += 1 - occluded[k];
        }
        w->sampled[pixel] = air_collimated_integral(&profile) * lit / samples;
    }
    return air_clock(context) - start;
}

static air_shadow_mesh shadow_mesh_of(const work *w)
{
    return (air_shadow_mesh){w->soup.positions, 3 * w->soup.triangle_count, w->soup.indices,
                             w->soup.triangle_count};
}

/* PSNR of w->exact over a sample of the pixels. */
static double exact_psnr(const work *w)
{
    const double budget = 2e8 / (double)w->soup.triangle_count;
    const size_t wanted = budget > 20000.0 ? 20000 : budget < 100.0 ? 100 : (size_t)budget;
    const size_t step = w->pixels / wanted + 1;
    double squares = 0.0, peak = 0.0, count = 0.0;
    static air_interval shadows[1 << 16];
    air_collimated_piece pieces[8];
    const air_shadow_mesh mesh = shadow_mesh_of(w);
    const shadow_wedges wedges = make_wedges(&mesh, 1, w->to_light);
    if (wedges.wedges == NULL) {
        abort();
    }
    for (size_t pixel = step / 2; pixel < w->pixels; pixel += step) {
        air_collimated_profile profile = {.pieces = pieces, .capacity = 8};
        double value = 0.0;
        if (make_profile(w, pixel, &profile)) {
            size_t found = 0;
            const double begin = pieces[0].t0, end = pieces[profile.count - 1].t1;
            for (size_t i = 0; i < wedges.count && found < 65536; i++) {
                found += clip_to_wedge(&wedges.wedges[i], w->settings->eye, w->dirs[pixel], begin,
                                       end, &shadows[found]);
            }
            found = air_intervals_join(shadows, found);
            value = lit_integral(&profile, shadows, found < INTERVALS ? found : INTERVALS);
        }
        const double d = w->exact[pixel] - value;
        squares += d * d;
        peak = fmax(peak, value);
        count += 1.0;
    }
    free(wedges.wedges);
    return -10.0 * log10(squares / count / (peak * peak));
}

static double sampled_psnr(const work *w)
{
    double squares = 0.0, peak = 0.0;
    for (size_t i = 0; i < w->pixels; i++) {
        const double d = w->sampled[i] - w->exact[i];
        squares += d * d;
        peak = fmax(peak, w->exact[i]);
    }
    return -10.0 * log10(squares / (double)w->pixels / (peak * peak));
}

/* ---- measuring ---- */

static air_shadow_tree *make_tree(const work *w, air_context *context)
{
    double hull[8][3];
    air_shadow_tree_params params;
    air_shadow_tree *tree;
    const air_shadow_mesh mesh = shadow_mesh_of(w);
    beam_hull(w->settings, hull);
    air_shadow_tree_params_default(&params);
    memcpy(params.to_light, w->to_light, sizeof params.to_light);
    params.hull = hull[0];
    params.hull_count = 8;
    if (air_shadow_tree_create(context, &params, &mesh, 1, &tree) != AIR_OK) {
        abort();
    }
    return tree;
}

static double time_build(const work *w, size_t threads)
{
    air_context *context = make_context(threads, AIR_CPU_AUTO);
    double seconds[ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        const double start = air_clock(context);
        air_shadow_tree *tree = make_tree(w, context);
        seconds[i] = air_clock(context) - start;
        air_shadow_tree_destroy(tree);
    }
    air_context_destroy(context);
    return median(seconds, ROUNDS);
}

static void measure_queries(work *w)
{
    static const char *const names[] = {"auto", "C", "SSE4.2", "AVX2", "AVX-512"};
    const double scale = 1e6 / (double)w->pixels;
    for (int cpu = AIR_CPU_C; cpu <= AIR_CPU_AVX512; cpu++) {
        air_context *context = make_context(1, (air_cpu)cpu);
        double seconds[ROUNDS];
        if (context == NULL) {
            continue;
        }
        air_shadow_tree *tree = make_tree(w, context);
        for (int i = 0; i < ROUNDS; i++) {
            seconds[i] = render_exact(w, tree, context);
        }
        const double middle = median(seconds, ROUNDS);
        printf("    %-8s %6.3f us per pixel (%.3f to %.3f)\n", names[cpu], middle * scale,
               seconds[0] * scale, seconds[ROUNDS - 1] * scale);
        air_shadow_tree_destroy(tree);
        air_context_destroy(context);
    }
}

/* Sampling against exact intervals, in turn, at the first numbers of samples that reach each
 * level. */
static void measure_ratio(work *w, const air_shadow_tree *tree, air_context *context)
{
    static const double levels[] = {50.0, 64.0};
    int samples = 16;
    for (size_t level = 0; level < 2; level++) {
        for (; samples <= MOST_SAMPLES; samples *= 2) {
            (void)render_sampled(w, samples, context);
            if (sampled_psnr(w) >= levels[level]) {
                break;
            }
        }
        if (samples > MOST_SAMPLES) {
            return;
        }
        double ratios[3], seconds[3];
        for (int i = 0; i < 3; i++) {
            const double exact = render_exact(w, tree, context);
            seconds[i] = render_sampled(w, samples, context);
            ratios[i] = seconds[i] / exact;
        }
        const double middle = median(ratios, 3);
        printf("    wvds, %4d samples: %.1f dB, %.2f us per pixel; exact is %.1f times faster "
               "(%.1f to %.1f)\n",
               samples, sampled_psnr(w), 1e6 / (double)w->pixels * median(seconds, 3), middle,
               ratios[0], ratios[2]);
    }
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    air_context *context = make_context(1, AIR_CPU_AUTO);
    for (int i = 0; i < BEAM_RUNS; i++) {
        const beam_settings settings_of_run = beam_run_settings(i), *settings = &settings_of_run;
        work w;
        if (argc > 1 && strcmp(argv[1], settings->name) != 0) {
            continue;
        }
        if (!work_make(&w, context, settings)) {
            printf("%s: not there, skipped\n", settings->name);
            continue;
        }
        air_shadow_tree *tree = make_tree(&w, context);
        const double one = time_build(&w, 1), two = time_build(&w, 2);
        (void)render_exact(&w, tree, context);
        printf("%s: %zu triangles; build %.3f s on one thread, %.3f on two; %.1f MB; %.1f dB\n",
               settings->name, w.soup.triangle_count, one, two,
               (double)air_shadow_tree_size(tree) / 1e6, exact_psnr(&w));
        measure_queries(&w);
        if (settings->divisions == 0) {
            measure_ratio(&w, tree, context);
        }
        air_shadow_tree_destroy(tree);
        work_free(&w);
    }
    air_context_destroy(context);
    return 0;
}

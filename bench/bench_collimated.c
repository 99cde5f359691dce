/* Single scattering of light from infinity: every estimator's error in scene A beside published
 * figures ("paper" is [Velinov2021, fig. 6], read at 4 samples), and the time of samples. Multiple
 * scattering: bench_collimated_walk.
 *
 * bench_collimated [--csv FILE]: FILE gets error and time of every estimator (collimated_plot.py).
 * Fails if a figure of the single-scattering tables is off by more than 0.4 dB. */
#include "collimated_figures.h"

enum { SEEDS = 3 };

static const char *const names[ESTIMATOR_COUNT] = {"RM", "DS", "WVDS", "REES", "REDS", "DS-u"};
static const int order[ESTIMATOR_COUNT] = {AIR_COLLIMATED_RM,   AIR_COLLIMATED_DS,
                                           AIR_COLLIMATED_REES, AIR_COLLIMATED_REDS,
                                           AIR_COLLIMATED_WVDS, ESTIMATOR_DS_UNTRUNCATED};

/* ---- single scattering: PSNR ---- */

/* dB at 1, 4, 16, 64 samples by estimator; the paper's at 4. 0: not known. */
typedef struct psnr_table {
    int pattern;
    double figures[ESTIMATOR_COUNT][COLUMNS], paper[ESTIMATOR_COUNT];
} psnr_table;

static const psnr_table psnr_tables[2] = {
    {PATTERN_STRATIFIED,
     {[AIR_COLLIMATED_RM] = {14.56, 28.76, 44.30, 57.82},
      [AIR_COLLIMATED_DS] = {21.65, 31.70, 44.55, 58.83},
      [AIR_COLLIMATED_REES] = {25.44, 33.47, 46.34, 58.49},
      [AIR_COLLIMATED_REDS] = {25.59, 36.00, 48.16, 60.42},
      [AIR_COLLIMATED_WVDS] = {25.77, 36.46, 47.83, 59.70},
      [ESTIMATOR_DS_UNTRUNCATED] = {11.71, 22.52, 34.53, 45.53}},
     {[AIR_COLLIMATED_RM] = 28.12,
      [AIR_COLLIMATED_DS] = 31.76,
      [AIR_COLLIMATED_REES] = 32.77,
      [AIR_COLLIMATED_REDS] = 35.01,
      [AIR_COLLIMATED_WVDS] = 35.49}},
    {PATTERN_INDEPENDENT,
     {[AIR_COLLIMATED_RM] = {14.56, 20.61, 26.67, 32.64},
      [AIR_COLLIMATED_DS] = {21.65, 27.65, 33.65, 39.71},
      [AIR_COLLIMATED_REES] = {25.44, 31.05, 37.02, 43.08},
      [AIR_COLLIMATED_REDS] = {25.59, 31.57, 37.65, 43.74},
      [AIR_COLLIMATED_WVDS] = {25.77, 31.78, 37.77, 43.80}},
     {0}}};

/* Mean of SEEDS seeds for all estimators in the columns from begin on, up to end. */
static bool measure_psnr(air_context *context, const sphere_scene *scene, int pattern, int begin,
                         int end, double out[ESTIMATOR_COUNT][COLUMNS])
{
    picture_plan plans[ESTIMATOR_COUNT * COLUMNS * SEEDS];
    double psnr[ESTIMATOR_COUNT * COLUMNS * SEEDS];
    const int width = (end - begin) * SEEDS, count = ESTIMATOR_COUNT * width;
    for (int i = 0; i < count; i++) {
        plans[i] =
            (picture_plan){scene, i / width, pattern, column_samples[begin + i % width / SEEDS],
                           1u + (uint32_t)(i % SEEDS)};
    }
    const bool good = picture_compare(context, plans, (size_t)count, psnr);
    for (int i = 0; i < count && good; i += SEEDS) {
        double sum = 0.0;
        for (int k = 0; k < SEEDS; k++) {
            sum += psnr[i + k];
        }
        out[i / width][begin + i % width / SEEDS] = sum / SEEDS;
    }
    return good;
}

static bool print_psnr_table(air_context *context, const sphere_scene *scene,
                             const psnr_table *table)
{
    double psnr[ESTIMATOR_COUNT][COLUMNS], worst = 0.0;
    if (!measure_psnr(context, scene, table->pattern, 0, COLUMNS, psnr)) {
        return false;
    }
    printf("\nScene A, single scattering, %s: PSNR in dB (published, difference)\n%-5s",
           sample_patterns[table->pattern].name, "");
    for (int c = 0; c < COLUMNS; c++) {
        printf("  %2d samples%12s", column_samples[c], "");
    }
    printf("  paper at 4\n");
    for (int k = 0; k < ESTIMATOR_COUNT; k++) {
        const int e = order[k];
        printf("%-5s", names[e]);
        for (int c = 0; c < COLUMNS; c++) {
            worst = fmax(worst, fabs(print_figure(psnr[e][c], table->figures[e][c])));
        }
        if (table->paper[e] > 0.0) {
            printf("  %5.2f %+5.2f", table->paper[e], psnr[e][1] - table->paper[e]);
        }
        printf("\n");
    }
    printf("largest difference %.2f dB: %s\n", worst, worst <= 0.4 ? "good" : "TOO FAR");
    return worst <= 0.4;
}

/* All patterns at 4 samples. */
static bool print_patterns(air_context *context, const sphere_scene *scene)
{
    static const double figures[PATTERN_COUNT][AIR_COLLIMATED_ESTIMATOR_COUNT] = {
        [PATTERN_INDEPENDENT] = {20.61, 27.65, 31.78, 31.05, 31.57},
        [PATTERN_STRATIFIED] = {28.8, 31.70, 36.5, 33.5, 36.0},
        [PATTERN_SYSTEMATIC] = {26.4, NONE, 38.1, 35.7, 38.7}};
    printf("\nPatterns at 4 samples: PSNR in dB (published, difference)\n");
    for (int p = 0; p < PATTERN_COUNT; p++) {
        double psnr[ESTIMATOR_COUNT][COLUMNS];
        if (!measure_psnr(context, scene, p, 1, 2, psnr)) {
            return false;
        }
        printf("%-12s", sample_patterns[p].name);
        for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
            printf("  %s", names[order[k]]);
            (void)print_figure(psnr[order[k]][1], figures[p][order[k]]);
        }
        printf("\n");
    }
    return true;
}

/* ---- frames ---- */

typedef struct frame_work {
    const sphere_scene *scene;
    air_collimated_estimator estimator;
    int frames;
    double *rows; /* per row: squared errors of sums and ratios, sums of ratios' error and exact */
} frame_work;

static void frame_row(void *user, size_t row, size_t worker)
{
    const frame_work *work = user;
    const sphere_scene *scene = work->scene;
    double *out = work->rows + 4 * row;
    scene_ray ray;
    (void)worker;
    for (int x = 0; x < scene->size; x++) {
        const int pixel = (int)row * scene->size + x;
        air_collimated_sums all = {0.0, 0.0, 0.0};
        double ratios = 0.0;
        if (!scene_ray_make(scene, pixel, &ray)) {
            continue;
        }
        air_rng rng = air_rng_from_keys(77, (uint32_t)pixel);
        for (int frame = 0; frame < work->frames; frame++) {
            const double u = random_unit(&rng);
            const air_collimated_sums one = scene_sums(scene, &ray, (int)work->estimator, &u, 1);
            sums_add(&all, one);
            ratios += sums_value(work->estimator, one, 1.0) / work->frames;
        }
        const double error = sums_value(work->estimator, all, work->frames) - ray.exact;
        out[0] += error * error;
        out[1] += (ratios - ray.exact) * (ratios - ray.exact);
        out[2] += ratios - ray.exact;
        out[3] += ray.exact;
    }
}

static bool print_frames(air_context *context, const sphere_scene *scene)
{
    static const double figures[2][2] = {{52.46, 44.75}, {52.79, 44.12}};
    enum { FRAMES = 512 };
    double *rows = calloc(4 * (size_t)scene->size, sizeof *rows);
    printf("\n%d frames of one sample: PSNR in dB (published, difference)\n", FRAMES);
    for (int k = 0; k < 2 && rows != NULL; k++) {
        frame_work work = {scene, k == 0 ? AIR_COLLIMATED_REES : AIR_COLLIMATED_REDS, FRAMES, rows};
        double total[4] = {0.0};
        memset(rows, 0, 4 * (size_t)scene->size * sizeof *rows);
        air_parallel_for(context, (size_t)scene->size, frame_row, &work);
        for (int i = 0; i < 4 * scene->size; i++) {
            total[i % 4] += rows[i];
        }
        const double peak = 0.869356573;
        printf("%s: three sums", names[work.estimator]);
        (void)print_figure(picture_psnr((picture_error){total[0], peak}, scene->size),
                           figures[k][0]);
        printf("  averaged ratios");
        (void)print_figure(picture_psnr((picture_error){total[1], peak}, scene->size),
                           figures[k][1]);
        printf("  mean of ratios %+.2f %%\n", 100.0 * total[2] / total[3]);
    }
    free(rows);
    return rows != NULL;
}

/* ---- several lights ---- */

/* Three lights at 4 samples, chosen by what they give, or evenly. */
static void print_lights(void)
{
    enum { LIGHTS = 3, SIZE = 128, SAMPLES = 4 };
    static const double power[LIGHTS] = {1.0, 0.5, 0.25};
    static const double to_lights[LIGHTS][3] = {{-0.3, 0.6, -0.3}, {0.9, 0.2, 0.1}, {0.1, -0.5, 1}};
    picture_error by_gift = {0.0, 0.0}, evenly = {0.0, 0.0};
    for (int pixel = 0; pixel < SIZE * SIZE; pixel++) {
        sphere_scene scene = scene_a(SIZE);
        scene_ray rays[LIGHTS];
        double give[LIGHTS], sum = 0.0, exact = 0.0, u[SAMPLES], seen[2] = {0.0, 0.0};
        for (int i = 0; i < LIGHTS; i++) {
            memcpy(scene.to_light, to_lights[i], sizeof scene.to_light);
            normalise(scene.to_light);
            (void)scene_ray_make(&scene, pixel, &rays[i]);
            give[i] = power[i] * rays[i].unoccluded;
            sum += give[i];
            exact += power[i] * rays[i].exact;
        }
        if (!(sum > 0.0)) {
            continue;
        }
        pattern_stratified(&(pattern_place){pixel, SIZE, 5}, SAMPLES, u);
        for (int k = 0; k < SAMPLES; k++) {
            double rest;
            size_t i = air_collimated_choose(give, LIGHTS, u[k], &rest);
            double t = air_collimated_sample(&rays[i].room.profile, rest);
            seen[0] += scene_ray_sees(&rays[i], t) ? sum / SAMPLES : 0.0;
            i = (size_t)(u[k] * LIGHTS);
            t = air_collimated_sample(&rays[i].room.profile, u[k] * LIGHTS - (double)i);
            seen[1] += scene_ray_sees(&rays[i], t) ? LIGHTS * give[i] / SAMPLES : 0.0;
        }
        by_gift.sum += (seen[0] - exact) * (seen[0] - exact);
        evenly.sum += (seen[1] - exact) * (seen[1] - exact);
        by_gift.peak = evenly.peak = fmax(by_gift.peak, exact);
    }
    printf(
        "\nThree lights, %d samples of all together: chosen by integral %.2f dB, evenly %.2f dB\n",
        SAMPLES, picture_psnr(by_gift, SIZE), picture_psnr(evenly, SIZE));
}

/* ---- random scenes ---- */

static bool print_pairs(air_context *context)
{
    static const int pairs[4][2] = {{AIR_COLLIMATED_WVDS, AIR_COLLIMATED_DS},
                                    {AIR_COLLIMATED_WVDS, AIR_COLLIMATED_RM},
                                    {AIR_COLLIMATED_REES, AIR_COLLIMATED_RM},
                                    {AIR_COLLIMATED_REDS, AIR_COLLIMATED_DS}};
    static const double figures[4] = {98.4, 99.1, 99.5, 99.9};
    enum { SCENES = 300, SIZE = 64, KINDS = AIR_COLLIMATED_ESTIMATOR_COUNT };
    air_rng rng = air_rng_from_keys(3, 6);
    int wins[4] = {0}, best[KINDS] = {0};
    for (int n = 0; n < SCENES; n++) {
        const sphere_scene scene = random_sphere_scene(&rng, SIZE);
        picture_plan plans[KINDS];
        double psnr[KINDS];
        int first = 0;
        for (int k = 0; k < KINDS; k++) {
            plans[k] = (picture_plan){&scene, k, PATTERN_STRATIFIED, 4, 500u + (uint32_t)n};
        }
        if (!picture_compare(context, plans, KINDS, psnr)) {
            return false;
        }
        for (int i = 0; i < 4; i++) {
            wins[i] += psnr[pairs[i][0]] > psnr[pairs[i][1]];
        }
        for (int k = 1; k < KINDS; k++) {
            first = psnr[k] > psnr[first] ? k : first;
        }
        best[first]++;
    }
    bool good = true;
    printf("\n%d random scenes, stratified, 4 samples (published)\n", SCENES);
    for (int i = 0; i < 4; i++) {
        good = good && wins[i] >= 0.96 * SCENES;
        printf("%s beats %s in %.1f %% (%.1f)\n", names[pairs[i][0]], names[pairs[i][1]],
               100.0 * wins[i] / SCENES, figures[i]);
    }
    printf("best is");
    for (int k = 0; k < KINDS; k++) {
        printf(" %s %.1f %%", names[k], 100.0 * best[k] / SCENES);
    }
    printf("\n");
    return good;
}

/* ---- time of samples ---- */

enum { TIMED_SIZE = 64, ROUNDS = 15, MOST_TIMED = 64, RINGS = 160, SPOKES = 320 };

/* As small as a renderer would keep it: a box gives at most 3 pieces. */
typedef struct timed_ray {
    double dir[3];
    air_collimated_piece pieces[3];
    air_collimated_profile profile;
} timed_ray;

/* Rays of scene A that meet the medium, with their profiles and numbers, and ways to ask for
 * visibility. */
typedef struct timed_rays {
    air_context *context;
    sphere_scene scene;
    timed_ray rays[TIMED_SIZE * TIMED_SIZE];
    double u[TIMED_SIZE * TIMED_SIZE][MOST_TIMED];
    int count, samples;
    void *accelerator;
    float positions[3 * (RINGS + 1) * SPOKES + 1];
    uint32_t indices[6 * RINGS * SPOKES];
    double checksum;
} timed_rays;

static void timed_numbers(timed_rays *self, int samples)
{
    self->samples = samples;
    for (int i = 0; i < self->count; i++) {
        pattern_stratified(&(pattern_place){i, TIMED_SIZE, 9}, samples, self->u[i]);
    }
}

static bool timed_rays_make(timed_rays *self, air_context *context)
{
    const air_ray_backend *backend = air_context_ray_backend(context);
    self->context = context;
    self->scene = scene_a(TIMED_SIZE);
    for (int pixel = 0; pixel < TIMED_SIZE * TIMED_SIZE; pixel++) {
        scene_ray ray;
        if (scene_ray_make(&self->scene, pixel, &ray)) {
            timed_ray *kept = &self->rays[self->count++];
            const air_collimated_profile *profile = &ray.room.profile;
            memcpy(kept->dir, ray.dir, sizeof kept->dir);
            memcpy(kept->pieces, profile->pieces, profile->count * sizeof *kept->pieces);
            kept->profile = *profile;
            kept->profile.pieces = kept->pieces;
        }
    }
    uint32_t *index = self->indices;
    for (uint32_t ring = 0; ring <= RINGS; ring++) {
        for (uint32_t spoke = 0; spoke < SPOKES; spoke++) {
            const double theta = AIR_PI * ring / RINGS, phi = 2.0 * AIR_PI * spoke / SPOKES;
            const double unit[3] = {sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)};
            for (int i = 0; i < 3; i++) {
                self->positions[3 * (ring * SPOKES + spoke) + (uint32_t)i] =
                    (float)(self->scene.centre[i] + self->scene.radius * unit[i]);
            }
            if (ring < RINGS) {
                const uint32_t a = ring * SPOKES + spoke, b = ring * SPOKES + (spoke + 1) % SPOKES;
                const uint32_t corners[6] = {a, b, a + SPOKES, b, b + SPOKES, a + SPOKES};
                memcpy(index, corners, sizeof corners);
                index += 6;
            }
        }
    }
    const air_ray_mesh mesh = {self->positions, (size_t)(RINGS + 1) * SPOKES, self->indices,
                               (size_t)2 * RINGS * SPOKES, 1};
    return backend->build(backend->user, context, &mesh, 1, &self->accelerator) == AIR_OK;
}

static void nothing_hides(void *user, const double *const points[3], size_t count,
                          uint8_t *occluded)
{
    (void)user;
    (void)points;
    memset(occluded, 0, count);
}

static void sphere_hides(void *user, const double *const points[3], size_t count, uint8_t *occluded)
{
    const timed_rays *self = user;
    const double *c = self->scene.centre, *l = self->scene.to_light;
    const double radius2 = self->scene.radius * self->scene.radius;
    for (size_t i = 0; i < count; i++) {
        const double x = c[0] - points[0][i], y = c[1] - points[1][i], z = c[2] - points[2][i];
        const double along = x * l[0] + y * l[1] + z * l[2];
        const double across2 = x * x + y * y + z * z - along * along;
        occluded[i] = (uint8_t)((along > 0.0) & (across2 < radius2));
    }
}

static void mesh_hides(void *user, const double *const points[3], size_t count, uint8_t *occluded)
{
    enum { PACKET = 16 };
    const timed_rays *self = user;
    const double *l = self->scene.to_light;
    const air_ray_backend *backend = air_context_ray_backend(self->context);
    air_ray rays[PACKET];
    for (size_t at = 0; at < count; at += PACKET) {
        const size_t n = count - at < PACKET ? count - at : PACKET;
        for (size_t i = 0; i < n; i++) {
            rays[i] = (air_ray){.origin = {(float)points[0][at + i], (float)points[1][at + i],
                                           (float)points[2][at + i]},
                                .dir = {(float)l[0], (float)l[1], (float)l[2]},
                                .tmin = 1e-4f,
                                .tmax = INFINITY,
                                .mask = 1};
        }
        backend->occluded(self->accelerator, rays, n, occluded + at);
    }
}

/* ns per sample. */
static double time_gather(timed_rays *self, air_collimated_estimator estimator,
                          air_collimated_occluded occluded)
{
    const double start = thread_seconds();
    for (int i = 0; i < self->count; i++) {
        const air_collimated_sums sums = air_collimated_gather(
            self->context, estimator, &self->rays[i].profile, self->scene.eye, self->rays[i].dir,
            self->u[i], (size_t)self->samples, occluded, self);
        self->checksum += sums.occluded;
    }
    return 1e9 * (thread_seconds() - start) / ((double)self->count * self->samples);
}

/* One sample after the other, everything visible. */
static double time_single(timed_rays *self, air_collimated_estimator estimator,
                          air_collimated_occluded unused)
{
    const double start = thread_seconds();
    (void)unused;
    for (int i = 0; i < self->count; i++) {
        for (int k = 0; k < self->samples; k++) {
            const air_collimated_draw draw =
                air_collimated_estimate(estimator, &self->rays[i].profile, self->u[i][k]);
            self->checksum += draw.unoccluded + draw.t;
        }
    }
    return 1e9 * (thread_seconds() - start) / ((double)self->count * self->samples);
}

/* As published: WVDS keeps its pieces per ray; RM has none and meets the boundary at every sample.
 */
static double time_as_published(timed_rays *self, air_collimated_estimator estimator,
                                air_collimated_occluded unused)
{
    if (estimator == AIR_COLLIMATED_WVDS) {
        return time_single(self, estimator, unused);
    }
    const double start = thread_seconds();
    for (int i = 0; i < self->count; i++) {
        const air_collimated_profile *profile = &self->rays[i].profile;
        const double a = profile->pieces[0].t0, b = profile->pieces[profile->count - 1].t1;
        for (int k = 0; k < self->samples; k++) {
            double x[3];
            const double t = a + (b - a) * self->u[i][k];
            move_along(self->scene.eye, self->rays[i].dir, t, x);
            const double d =
                air_collimated_boundary_distance(&self->scene.medium, self->scene.to_light, x);
            self->checksum += (b - a) * exp(-self->scene.sigma_t * (t - a + d));
        }
    }
    return 1e9 * (thread_seconds() - start) / ((double)self->count * self->samples);
}

static double time_profiles(timed_rays *self)
{
    const double start = thread_seconds();
    for (int i = 0; i < self->count; i++) {
        air_collimated_piece pieces[3];
        air_collimated_profile profile = {.pieces = pieces, .capacity = 3};
        air_collimated_profile_make(&self->scene.medium, self->scene.to_light, self->scene.sigma_t,
                                    self->scene.eye, self->rays[i].dir, INFINITY, &profile);
        self->checksum += air_collimated_integral(&profile);
    }
    return 1e9 * (thread_seconds() - start) / self->count;
}

static double median(double *values)
{
    qsort(values, ROUNDS, sizeof *values, compare_doubles);
    return values[ROUNDS / 2];
}

static double best(const double *values)
{
    double least = values[0];
    for (int i = 1; i < ROUNDS; i++) {
        least = fmin(least, values[i]);
    }
    return least;
}

typedef double time_function(timed_rays *self, air_collimated_estimator estimator,
                             air_collimated_occluded occluded);

/* RM and WVDS in turn. */
static void print_time(timed_rays *self, const char *what, time_function *measure,
                       air_collimated_occluded occluded)
{
    double rm[ROUNDS], wvds[ROUNDS], ratio[ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        rm[i] = measure(self, AIR_COLLIMATED_RM, occluded);
        wvds[i] = measure(self, AIR_COLLIMATED_WVDS, occluded);
        ratio[i] = wvds[i] / rm[i];
    }
    const double middle = median(ratio);
    printf("%2d samples  %-28s  %6.2f  %6.2f   %.2f (%.2f to %.2f)\n", self->samples, what,
           median(rm), median(wvds), middle, ratio[0], ratio[ROUNDS - 1]);
}

static void print_times(timed_rays *self)
{
    static const char *const isas[] = {"auto", "C", "SSE4.2", "AVX2", "AVX-512"};
    printf("\n%s: ns per sample of RM and WVDS, median of %d rounds; ratio (published: 0.57 to "
           "0.95); a profile takes %.0f ns\n",
           isas[air_context_cpu(self->context)], ROUNDS, time_profiles(self));
    for (int samples = 4; samples <= MOST_TIMED; samples *= 4) {
        timed_numbers(self, samples);
        print_time(self, "all visible", time_gather, nothing_hides);
        print_time(self, "sphere", time_gather, sphere_hides);
        print_time(self, "mesh, packets of 16", time_gather, mesh_hides);
        print_time(self, "one at a time, all visible", time_single, NULL);
        print_time(self, "RM without pieces", time_as_published, NULL);
    }
}

/* Rows of estimator, samples, PSNR, and seconds for a picture on one thread, sphere visibility:
 * best of the rounds. */
static bool write_csv(const char *path, timed_rays *self, const sphere_scene *scene)
{
    double psnr[ESTIMATOR_COUNT][COLUMNS];
    FILE *file = fopen(path, "w");
    bool good =
        file != NULL && measure_psnr(self->context, scene, PATTERN_STRATIFIED, 0, COLUMNS, psnr);
    if (good) {
        fprintf(file, "estimator,samples,psnr_db,seconds\n");
    }
    for (int c = 0; c < COLUMNS && good; c++) {
        timed_numbers(self, column_samples[c]);
        for (int k = 0; k < AIR_COLLIMATED_ESTIMATOR_COUNT; k++) {
            const air_collimated_estimator estimator = (air_collimated_estimator)order[k];
            double ns[ROUNDS], profile_ns[ROUNDS];
            for (int i = 0; i < ROUNDS; i++) {
                ns[i] = time_gather(self, estimator, sphere_hides) * column_samples[c];
                profile_ns[i] = time_profiles(self);
            }
            const double rays =
                (double)scene->size * scene->size * self->count / (double)(TIMED_SIZE * TIMED_SIZE);
            fprintf(file, "%s,%d,%.3f,%.6g\n", names[estimator], column_samples[c],
                    psnr[estimator][c], 1e-9 * rays * (best(ns) + best(profile_ns)));
        }
    }
    good = (file == NULL || fclose(file) == 0) && good;
    return good;
}

static bool run(air_context *context, timed_rays *timed, const char *csv)
{
    const sphere_scene scene = scene_a(256);
    bool good = print_psnr_table(context, &scene, &psnr_tables[0]);
    good = print_psnr_table(context, &scene, &psnr_tables[1]) && good;
    good = print_patterns(context, &scene) && good;
    good = print_frames(context, &scene) && good;
    print_lights();
    good = print_pairs(context) && good;
    const bool built = timed_rays_make(timed, context);
    if (built) {
        print_times(timed);
        if (csv != NULL) {
            good = write_csv(csv, timed, &scene) && good;
        }
    }
    air_context_ray_backend(context)->destroy(timed->accelerator);
    return good && built && timed->checksum > 0.0;
}

int main(int argc, char **argv)
{
    air_context *context = NULL;
    timed_rays *timed = calloc(1, sizeof *timed);
    const bool csv = argc == 3 && strcmp(argv[1], "--csv") == 0;
    if (argc > 1 && !csv) {
        fprintf(stderr, "usage: bench_collimated [--csv FILE]\n");
        free(timed);
        return 2;
    }
    bool good = timed != NULL && air_context_create(NULL, &context) == AIR_OK;
    good = good && run(context, timed, csv ? argv[2] : NULL);
    air_context_destroy(context);
    free(timed);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

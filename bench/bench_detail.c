/* Procedural detail of media: ns per look-up, and what it adds to a picture by ordinates.
 *
 *     bench_detail [THREADS|looks]
 *
 * Look-ups: at points along rays as a march takes them, one thread; the medium even, so that the
 * first line is all but the noise. Pictures: 160 x 120, what media scatter, with the settings of
 * --quality interactive; a cube of 1 m under a sun and a sky, and the smoke of scenes/ under a sky.
 * Of 36 and of 4 samples per pixel, the difference over 32 being a sample's march, the rest the
 * solution. All in turn, round by round; the best of the rounds, and the median in parentheses. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/cpu.h"
#include "grid_scene.h"
#include "scene/media/field.h"

enum { ROUNDS = 5, LOOKS = 1 << 18, KINDS = 5, SETS = 5, PIXELS_X = 160, PIXELS_Y = 120 };

/* Processor time, which says more than the clock where others use the machine. */
static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the rounds: the best comes first. */
static void sort(double taken[ROUNDS]) { qsort(taken, ROUNDS, sizeof *taken, compare); }

/* ---- look-ups ---- */

static const uint32_t octaves_of[KINDS] = {0, 1, 2, 4, 8};

static air_medium make_medium(uint32_t octaves, air_cpu cpu)
{
    air_medium medium = {.sigma_s = {1, 1, 1}, .sigma_t = {1, 1, 1}};
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.density.detail.strength = 0.5f;
    desc.density.detail.octaves = octaves;
    if (octaves > 0) {
        air_detail_make(&desc.density.detail, cpu, &medium.detail);
    }
    return medium;
}

enum { RUN = AIR_LOOKS };

/* cpu AIR_CPU_AUTO: point by point, else in runs. */
static double time_looks(uint32_t octaves, air_cpu cpu, float *sum)
{
    const air_region region = {.density = 1.0f};
    const air_medium medium = make_medium(octaves, cpu);
    air_rng rng = air_rng_from_keys(1, octaves);
    const double start = seconds();
    for (int n = 0; n < LOOKS; n += RUN) {
        const air_vec3 from = vec3(air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng));
        air_vec3 at[RUN];
        air_coefficients found[RUN];
        for (int i = 0; i < RUN; i++) {
            at[i] = vec3_madd(from, 0.05f * (float)i, vec3(0.8f, 0.36f, 0.48f));
        }
        if (cpu != AIR_CPU_AUTO) {
            air_medium_coefficients_run(&medium, &region, at, RUN, 0.0f, found);
        }
        for (int i = 0; i < RUN; i++) {
            if (cpu == AIR_CPU_AUTO) {
                found[i] = air_medium_coefficients(&medium, &region, at[i]);
            }
            *sum += found[i].sigma_t.x;
        }
    }
    return 1e9 * (seconds() - start) / LOOKS;
}

static void bench_looks(void)
{
    static const char *const names[SETS] = {"one by one", "in runs, C", NULL, "AVX2", "AVX-512"};
    const int sets = (int)air_cpu_detect() + 1;
    double taken[SETS][KINDS][ROUNDS];
    float sum = 0.0f;
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < sets * KINDS; i++) {
            taken[i / KINDS][i % KINDS][round] =
                time_looks(octaves_of[i % KINDS], (air_cpu)(i / KINDS), &sum);
        }
    }
    printf("look-ups of coefficients, ns, by octaves (checksum %g)\n%-12s", (double)sum, "");
    for (int k = 0; k < KINDS; k++) {
        printf(" %13u", (unsigned)octaves_of[k]);
    }
    for (int i = 0; i < sets; i++) {
        if (names[i] != NULL) {
            printf("\n%-12s", names[i]);
            for (int k = 0; k < KINDS; k++) {
                sort(taken[i][k]);
                printf(" %5.1f (%5.1f)", taken[i][k][0], taken[i][k][ROUNDS / 2]);
            }
        }
    }
    printf("\n");
}

/* ---- pictures ---- */

typedef struct picture_scene {
    const char *name;
    bool smoke;
    float detail_m; /* 0: none */
} picture_scene;

static const picture_scene pictures[KINDS] = {{"cube", false, 0.0f},
                                              {"cube, features of 25 cm", false, 0.25f},
                                              {"smoke", true, 0.0f},
                                              {"smoke, features of 60 cm", true, 0.6f},
                                              {"smoke, features of 20 cm", true, 0.2f}};

static air_status add_smoke(air_scene *scene, float detail_m)
{
    const float view[12] = {1, 0, 0, 0, 0, 1, 0, 2.5f, 0, 0, 1, 8};
    air_medium_desc medium;
    air_camera_desc camera;
    air_handle handle;
    air_medium_desc_default(&medium);
    room_set3(medium.sigma_s, 8.2f, 8.2f, 8.2f);
    room_set3(medium.sigma_a, 0.75f, 0.85f, 1.0f);
    medium.density.kind = AIR_DENSITY_GRID;
    if (detail_m > 0.0f) {
        medium.density.detail.strength = 0.8f;
        medium.density.detail.scale = detail_m;
    }
    air_status status = air_scene_load_grid(scene, AIR_SOURCE_DIR "/scenes/smoke/smoke.vol", NULL,
                                            &medium.density.grid);
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    status = status == AIR_OK ? grid_add_lights(scene, GRID_SKY) : status;
    air_camera_desc_default(&camera);
    memcpy(camera.to_world, view, sizeof view);
    camera.fov_y_rad = 0.55f;
    return status == AIR_OK ? air_scene_add_camera(scene, &camera, &handle) : status;
}

static air_status make_smoke(air_context *context, float detail_m, air_snapshot **out)
{
    air_scene *scene = NULL;
    air_status status = air_scene_create(context, &scene);
    status = status == AIR_OK ? add_smoke(scene, detail_m) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

static air_status make_picture_scene(air_context *context, const picture_scene *s,
                                     air_snapshot **out)
{
    const grid_scene cube = {.lights = GRID_SUN | GRID_SKY,
                             .sigma_s = {8, 8, 8},
                             .g = 0.6f,
                             .detail = s->detail_m > 0.0f ? 0.8f : 0.0f,
                             .detail_m = s->detail_m};
    return s->smoke ? make_smoke(context, s->detail_m, out) : grid_scene_make(context, &cube, out);
}

static double time_picture(air_context *context, const air_snapshot *snapshot, uint32_t samples)
{
    air_render_params params;
    air_film *film;
    air_render_params_default(&params);
    params.width = PIXELS_X;
    params.height = PIXELS_Y;
    params.sample_end = samples;
    params.max_depth = UINT32_MAX;
    params.methods = "ordinates";
    params.terms = 1u << AIR_TERM_M1 | 1u << AIR_TERM_M2;
    params.ordinates.cells = 20;
    params.ordinates.directions = 64;
    const double start = seconds();
    if (air_render(context, snapshot, &params, &film) != AIR_OK) {
        return NAN;
    }
    const double taken = seconds() - start;
    air_film_destroy(film);
    return taken;
}

static air_status bench_pictures(size_t threads)
{
    double few[KINDS][ROUNDS], march[KINDS][ROUNDS];
    air_context_params params;
    air_context *context = NULL;
    air_snapshot *snapshots[KINDS] = {NULL};
    air_context_params_default(&params);
    params.thread_count = threads;
    air_status status = air_context_create(&params, &context);
    for (int k = 0; k < KINDS && status == AIR_OK; k++) {
        status = make_picture_scene(context, &pictures[k], &snapshots[k]);
    }
    for (int round = 0; round < ROUNDS && status == AIR_OK; round++) {
        for (int k = 0; k < KINDS; k++) {
            few[k][round] = time_picture(context, snapshots[k], 4);
            march[k][round] = (time_picture(context, snapshots[k], 36) - few[k][round]) / 32.0;
        }
    }
    printf("pictures, %zu threads, processor ms: 4 samples a pixel; one more sample\n", threads);
    for (int k = 0; k < KINDS && status == AIR_OK; k++) {
        sort(few[k]);
        sort(march[k]);
        printf("  %-26s %8.1f (%.1f) %8.2f (%.2f)\n", pictures[k].name, 1e3 * few[k][0],
               1e3 * few[k][ROUNDS / 2], 1e3 * march[k][0], 1e3 * march[k][ROUNDS / 2]);
    }
    for (int k = 0; k < KINDS; k++) {
        air_snapshot_release(snapshots[k]);
    }
    air_context_destroy(context);
    return status;
}

int main(int argc, char **argv)
{
    bench_looks();
    if (argc > 1 && strcmp(argv[1], "looks") == 0) {
        return 0;
    }
    return bench_pictures(argc > 1 ? (size_t)atoi(argv[1]) : 1) == AIR_OK ? 0 : 1;
}

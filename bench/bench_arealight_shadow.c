/* Shadows of a plate in the light of a lamp in haze (scene A with an opaque plate, air-light only):
 * error of estimators of visibility, raw and smoothed, beside published figures; and that the
 * smoothed one converges. */
#include <stdio.h>

#include "airlight/denoise.h"
#include "area_ris.h"
#include "area_scene_a.h"
#include "core/host.h"

enum { REPEATS = 4, CANDIDATES = 8, WAYS = 6 };

/* The plate: z = 1.4, x in [-0.5, 0.5], y in [-0.25, 0.75]. */
static const double plate_z = 1.4, plate_low[2] = {-0.5, -0.25}, plate_high[2] = {0.5, 0.75};

static bool plate_hides(const double from[3], const double wi[3])
{
    const double t = (plate_z - from[2]) / wi[2];
    const double x = from[0] + t * wi[0], y = from[1] + t * wi[1];
    return t > 0.0 && x >= plate_low[0] && x <= plate_high[0] && y >= plate_low[1] &&
           y <= plate_high[1];
}

/* ---- the reference: the plate's shadow on the lamp is a rectangle, too ---- */

static double hidden(const area_scene *s, const double point[3], const double wo[3])
{
    static const double half[2] = {1.0, 0.5};
    const scene_place at = scene_place_at(s, point, wo);
    double low[2], high[2];
    if (point[2] >= plate_z) {
        return 0.0;
    }
    for (int k = 0; k < 2; k++) {
        const double stretch = (2.0 - point[2]) / (plate_z - point[2]);
        low[k] = fmax(-half[k], point[k] + stretch * (plate_low[k] - point[k]));
        high[k] = fmin(half[k], point[k] + stretch * (plate_high[k] - point[k]));
        if (low[k] >= high[k]) {
            return 0.0;
        }
    }
    return scene_part(&at, 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]),
                      0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0);
}

/* Visibility has kinks along the ray: a rule of many pieces. */
static double air_behind_plate(const area_scene *s, const double dir[3], double length)
{
    enum { NODES = 400 };
    double t[NODES], w[NODES], sum = 0.0;
    const double wo[3] = {-dir[0], -dir[1], -dir[2]};
    air_interval lit;
    if (!air_area_lit_interval(&s->lamp, scene_eye, dir, length, &lit)) {
        return 0.0;
    }
    air_area_line_nodes(AIR_AREA_EQUIANGULAR, &s->lamp, scene_eye, dir, lit, s->sigma, NODES, t, w);
    for (size_t i = 0; i < NODES; i++) {
        const double point[3] = {scene_eye[0] + t[i] * dir[0], scene_eye[1] + t[i] * dir[1],
                                 scene_eye[2] + t[i] * dir[2]};
        sum += w[i] * exp(-s->sigma * t[i]) * (scene_exact(s, point, wo) - hidden(s, point, wo));
    }
    return scene_radiance * s->sigma * sum;
}

/* ---- samples ---- */

/* One sample: what arrives without the plate, and with it. */
typedef struct sample {
    double clear, visible;
} sample;

static sample draw(const area_scene *s, const double dir[3], double length, bool by_extinction,
                   air_rng *rng)
{
    const double share = -expm1(-s->sigma * length);
    air_interval lit;
    double wi[3], r, pdf, t;
    sample out = {0.0, 0.0};
    if (by_extinction) {
        t = -log1p(-ris_unit(rng) * share) / s->sigma;
        pdf = s->sigma * exp(-s->sigma * t) / share;
    } else if (air_area_lit_interval(&s->lamp, scene_eye, dir, length, &lit)) {
        t = air_area_sample_distance(&s->lamp, scene_eye, dir, lit, ris_unit(rng), &pdf);
    } else {
        return out;
    }
    const double point[3] = {scene_eye[0] + t * dir[0], scene_eye[1] + t * dir[1],
                             scene_eye[2] + t * dir[2]};
    const double form = ris_lamp(point, rng, wi, &r);
    const double d = 1.0 + s->g * s->g - 2.0 * s->g * scene_dot(dir, wi);
    const double phase = (1.0 - s->g * s->g) / (4.0 * AIR_PI * d * sqrt(d));
    out.clear = scene_radiance * s->sigma * phase * form * exp(-s->sigma * (r + t)) / pdf;
    out.visible = plate_hides(point, wi) ? 0.0 : out.clear;
    return out;
}

/* One of eight, for all of them. */
static sample draw_of_many(const area_scene *s, const double dir[3], double length,
                           bool by_extinction, air_rng *rng)
{
    sample kept = {0.0, 0.0};
    double total = 0.0;
    for (int i = 0; i < CANDIDATES; i++) {
        const sample one = draw(s, dir, length, by_extinction, rng);
        total += one.clear;
        if (one.clear > 0.0 && ris_unit(rng) * total < one.clear) {
            kept = one;
        }
    }
    const double scale = kept.clear > 0.0 ? total / (kept.clear * CANDIDATES) : 0.0;
    return (sample){kept.clear * scale, kept.visible * scale};
}

/* ---- pictures ---- */

typedef struct scene_pictures {
    const area_scene *scene;
    double reference[SCENE_PIXELS], analytic[SCENE_PIXELS];
    float depth[SCENE_PIXELS];
} scene_pictures;

static void make_row(void *user, size_t row, size_t worker)
{
    static const scene_plan plan = {SCATTER_EDGE, 8, false, true, AIR_AREA_EQUIANGULAR, 64};
    scene_pictures *self = user;
    (void)worker;
    for (int x = 0; x < SCENE_WIDTH; x++) {
        const int pixel = (int)row * SCENE_WIDTH + x;
        double dir[3], length;
        const bool met = scene_ray(pixel, dir, &length);
        self->reference[pixel] = air_behind_plate(self->scene, dir, length);
        self->analytic[pixel] = scene_air(self->scene, &plan, dir, length);
        self->depth[pixel] = met ? (float)length : 0.0f;
    }
}

/* Sums of a picture's samples: of the plain kinds `visible` alone counts. */
typedef struct sums {
    float clear[SCENE_PIXELS], visible[SCENE_PIXELS];
} sums;

static void sample_picture(const scene_pictures *self, int samples, bool many, bool by_extinction,
                           uint32_t seed, sums *out)
{
    for (int pixel = 0; pixel < SCENE_PIXELS; pixel++) {
        air_rng rng = air_rng_from_keys(seed, (uint32_t)pixel);
        double dir[3], length, clear = 0.0, visible = 0.0;
        (void)scene_ray(pixel, dir, &length);
        for (int k = 0; k < samples; k++) {
            const sample one = many ? draw_of_many(self->scene, dir, length, by_extinction, &rng)
                                    : draw(self->scene, dir, length, by_extinction, &rng);
            clear += one.clear / samples;
            visible += one.visible / samples;
        }
        out->clear[pixel] = (float)clear;
        out->visible[pixel] = (float)visible;
    }
}

typedef struct error {
    double relmse, bias;
} error;

static void add_error(const scene_pictures *self, const sums *s, bool ratio, error *out)
{
    double mean = 0.0, sum = 0.0, square = 0.0;
    for (int i = 0; i < SCENE_PIXELS; i++) {
        mean += self->reference[i] / SCENE_PIXELS;
    }
    for (int i = 0; i < SCENE_PIXELS; i++) {
        const double share = s->clear[i] > 0.0f ? (double)s->visible[i] / (double)s->clear[i] : 1.0;
        const double value = ratio ? self->analytic[i] * share : (double)s->visible[i];
        const double r = self->reference[i], d = value - r;
        sum += value / SCENE_PIXELS;
        square += d * d / (r * r + 1e-4 * mean * mean) / SCENE_PIXELS;
    }
    out->relmse += square / REPEATS;
    out->bias += (sum / mean - 1.0) / REPEATS;
}

static air_denoise_guides guides_of(const scene_pictures *self)
{
    return (air_denoise_guides){.width = SCENE_WIDTH, .height = SCENE_HEIGHT, .depth = self->depth};
}

static bool smooth(air_context *context, const scene_pictures *self, sums *s)
{
    const air_denoise_guides guides = guides_of(self);
    float *const planes[2] = {s->clear, s->visible};
    air_denoise_params params;
    air_denoise_params_default(&params);
    return air_denoise_planes(context, &guides, &params, planes, 2) == AIR_OK;
}

typedef struct way {
    const char *name;
    bool ratio, many, by_extinction, smooth;
    double figures[3][3]; /* by g, then 1, 4, 16 samples */
} way;

static const way ways[WAYS] = {
    {"samples, raw",
     false,
     false,
     false,
     false,
     {{1.1, .56, 1.2}, {1.1, 1.0, 1.9}, {4.7, .62, .15}}},
    {"Volume-RIS, raw",
     false,
     true,
     true,
     false,
     {{1.6, .33, .033}, {.21, .12, .023}, {.30, .080, .024}}},
    {"ratio, raw",
     true,
     false,
     false,
     false,
     {{.068, .026, 6e-3}, {.041, .008, 1.6e-3}, {.038, .0057, 5e-4}}},
    {"ratio of 8, raw",
     true,
     true,
     false,
     false,
     {{.066, .017, 4e-3}, {.027, .006, 1.5e-3}, {.011, .002, 5e-4}}},
    {"ratio, smoothed",
     true,
     false,
     false,
     true,
     {{6e-3, 6e-3, 6e-3}, {1e-3, 9e-4, 9e-4}, {8e-5, 7e-5, 6e-5}}},
    {"ratio of 8, smoothed", true, true, false, true, {{0}, {0}, {0}}},
};

static void print_ways(air_context *context, const scene_pictures *self, int g, sums *s)
{
    static const int counts[3] = {1, 4, 16};
    for (int w = 0; w < WAYS; w++) {
        printf("  %-22s", ways[w].name);
        for (int k = 0; k < 3; k++) {
            error found = {0.0, 0.0};
            for (uint32_t repeat = 0; repeat < REPEATS; repeat++) {
                sample_picture(self, counts[k], ways[w].many, ways[w].by_extinction,
                               1u + repeat + 100u * (uint32_t)w, s);
                if (ways[w].smooth && !smooth(context, self, s)) {
                    abort();
                }
                add_error(self, s, ways[w].ratio, &found);
            }
            printf("  %.1e (%.1e) %+5.1f %%", found.relmse, ways[w].figures[g][k],
                   100.0 * found.bias);
        }
        printf("\n");
    }
}

/* With the film's filter, which shrinks. */
static void print_convergence(air_context *context, const scene_pictures *self, sums *s)
{
    double first = 0.0;
    printf("  shrinking filter, ratio of 8:");
    for (int samples = 4; samples <= 256; samples *= 4) {
        error found = {0.0, 0.0};
        for (uint32_t repeat = 0; repeat < REPEATS; repeat++) {
            sample_picture(self, samples, true, false, 5000u + repeat, s);
            const air_denoise_guides guides = guides_of(self);
            float *const whole = s->clear, *const visible = s->visible;
            if (air_denoise_shares(context, &guides, samples, &whole, &visible, 1) != AIR_OK) {
                abort();
            }
            add_error(self, s, true, &found);
        }
        first = samples == 4 ? found.relmse : first;
        printf("  %d samples %.2e (%.2f)", samples, found.relmse, found.relmse / first);
    }
    printf("\n");
}

int main(void)
{
    static const double gs[3] = {-0.6, 0.4, 0.9};
    air_context *context;
    scene_pictures *pictures = malloc(sizeof *pictures);
    sums *s = malloc(sizeof *s);
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (air_context_create(NULL, &context) != AIR_OK || pictures == NULL || s == NULL) {
        return EXIT_FAILURE;
    }
    printf(
        "Scene A with a plate, sigma_s 0.2, air-light: relMSE (published) and bias of the mean at "
        "1, 4, 16 samples, %d repeats\n",
        REPEATS);
    for (int g = 0; g < 3; g++) {
        const area_scene scene = scene_make(gs[g], 0.2);
        pictures->scene = &scene;
        air_parallel_for(context, SCENE_HEIGHT, make_row, pictures);
        printf("g %4.1f\n", gs[g]);
        print_ways(context, pictures, g, s);
        print_convergence(context, pictures, s);
    }
    free(pictures);
    free(s);
    air_context_destroy(context);
    return EXIT_SUCCESS;
}

/* Importance against photons, and what it does for pictures. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/phase.h"
#include "core/random.h"
#include "core/triple.h"
#include "importance_fixture.h"

/* ---- photons ---- */

typedef struct tally {
    double map[TEXELS], scattered, through, absorbed;
} tally;

static size_t texel_of(air_vec3 w)
{
    const double u = 0.5 + atan2((double)w.x, -(double)w.z) / (2.0 * AIR_PI);
    const double v = atan2(hypot((double)w.x, (double)w.z), (double)w.y) / AIR_PI;
    const size_t x = (size_t)fmin(u * AIR_IMPORTANCE_WIDTH, AIR_IMPORTANCE_WIDTH - 1);
    const size_t y = (size_t)fmin(v * AIR_IMPORTANCE_HEIGHT, AIR_IMPORTANCE_HEIGHT - 1);
    return y * AIR_IMPORTANCE_WIDTH + x;
}

/* Camera rays followed through the medium, even in tangents and weighted by their solid angle, with
 * delta tracking. What leaves them is, by reciprocity, what light from there brings to the camera.
 */
static void follow(const air_importance_camera *camera, const medium *m, size_t count, tally *out)
{
    float most = 0.0f;
    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < ALL; i++) {
        most = fmaxf(most, m->sigma_s[i] + m->sigma_a[i]);
    }
    const double area = 4.0 * (double)camera->tan_half[0] * (double)camera->tan_half[1];
    for (size_t n = 0; n < count; n++) {
        air_rng rng = air_rng_from_keys((uint32_t)n, 77);
        const float x = camera->tan_half[0] * (2.0f * air_rng_float(&rng) - 1.0f);
        const float y = camera->tan_half[1] * (2.0f * air_rng_float(&rng) - 1.0f);
        const air_vec3 ray =
            vec3_madd(vec3_madd(vec3_load(camera->forward), x, vec3_load(camera->right)), y,
                      vec3_load(camera->up));
        const double weight = area / pow((double)vec3_dot(ray, ray), 1.5) / (double)count;
        air_vec3 p = vec3_scale(ray, camera->near_m * 1.00001f), w = vec3_normalize(ray);
        bool scattered = false, lost = false;
        for (ptrdiff_t cell = cell_at(camera, p); cell >= 0 && !lost;) {
            p = vec3_madd(p, -logf(1.0f - air_rng_float(&rng)) / most, w);
            cell = cell_at(camera, p);
            const float u = air_rng_float(&rng) * most;
            if (cell >= 0 && u < m->sigma_s[cell]) {
                const air_phase phase = {.kind = AIR_PHASE_HG, .g = m->g[cell]};
                float pdf;
                const float u1 = air_rng_float(&rng), u2 = air_rng_float(&rng);
                w = vec3_normalize(air_phase_sample(phase, w, u1, u2, &pdf));
                scattered = true;
            } else {
                lost = cell >= 0 && u < m->sigma_s[cell] + m->sigma_a[cell];
            }
        }
        out->absorbed += lost ? weight : 0.0;
        out->through += lost || scattered ? 0.0 : weight;
        if (!lost && scattered) {
            out->scattered += weight;
            const size_t t = texel_of(w);
            out->map[t] += weight / texel_angle(t);
        }
    }
}

/* Half the L1 distance of the maps as distributions. */
static double variation_of(const double *truth, const float *map)
{
    double sum = 0.0, all = 0.0;
    for (size_t t = 0; t < TEXELS; t++) {
        all += texel_angle(t) * truth[t];
    }
    const double mine = integral(map);
    for (size_t t = 0; t < TEXELS; t++) {
        sum += 0.5 * texel_angle(t) * fabs(truth[t] / all - (double)map[t] / mine);
    }
    return sum;
}

/* The largest relative difference of what the camera receives of skies that are soft lobes of
 * radiance around the six axes, where it is at least a tenth of the most. */
static double worst_of_skies(const double *truth, const float *map)
{
    double received[6][2], most = 0.0, worst = 0.0;
    for (int n = 0; n < 6; n++) {
        received[n][0] = received[n][1] = 0.0;
        for (size_t t = 0; t < TEXELS; t++) {
            double w[3];
            texel_direction(t, w);
            const double sky = exp(4.0 * ((n % 2 ? -1.0 : 1.0) * w[n / 2] - 1.0));
            received[n][0] += texel_angle(t) * sky * truth[t];
            received[n][1] += texel_angle(t) * sky * (double)map[t];
        }
        most = fmax(most, received[n][0]);
    }
    for (int n = 0; n < 6; n++) {
        if (received[n][0] > 0.1 * most) {
            worst = fmax(worst, fabs(received[n][1] / received[n][0] - 1.0));
        }
    }
    return worst;
}

static void compare(void *context, const char *name, const medium *m, double apart, double skies)
{
    enum { PHOTONS = 200000 };
    const air_importance_camera camera = camera_of();
    static tally truth;
    float map[TEXELS];
    air_importance_books books;
    propagate(context, &camera, m, map, &books);
    follow(&camera, m, PHOTONS, &truth);
    const double variation = variation_of(truth.map, map), worst = worst_of_skies(truth.map, map);
    print_message("%s: total variation %.3f, skies %.3f; of %.4f sr through %.4f (%.4f), scattered "
                  "%.4f (%.4f), absorbed %.4f (%.4f), under way %.4f\n",
                  name, variation, worst, books.in, books.through, truth.through, books.scattered,
                  truth.scattered, books.absorbed, truth.absorbed, books.residual);
    assert_true(variation < apart && worst < skies);
    /* 0.1 % of noise, and rays of one column count as one */
    assert_true(fabs(books.through - truth.through) < 0.011 * books.in);
    /* what is scattered sees cells as wide as deep, where they are 0.8 to 2.3 times that: its ways
     * out are too short or long by some, and so is what is absorbed: 7 % of it here */
    assert_true(fabs(books.absorbed - truth.absorbed) < 0.03 * books.in);
}

/* Of the variation some 0.02 are noise, 0.4 sqrt(512 / 2e5) of 512 texels of 2e5 photons. What else
 * there is comes of the grid, and is measured; it grows with the number of events. */
static void maps_are_what_photons_find(void **state)
{
    static medium m;
    const air_importance_camera camera = camera_of();
    fill(&m, 0.2f, 0.0f, 0.8f);
    compare(*state, "sigma_s = 0.2, g = 0.8", &m, 0.04, 0.02);
    fill(&m, 1.0f, 0.0f, 0.9f);
    compare(*state, "sigma_s = 1, g = 0.9", &m, 0.07, 0.12);
    fill(&m, 1.0f, 0.2f, 0.0f);
    compare(*state, "sigma_s = 1, sigma_a = 0.2, g = 0", &m, 0.05, 0.10);
    fill(&m, 1.0f, 0.0f, -0.5f);
    compare(*state, "sigma_s = 1, g = -0.5", &m, 0.10, 0.15);
    fill(&m, 4.0f, 0.0f, 0.8f);
    compare(*state, "sigma_s = 4, g = 0.8", &m, 0.17, 0.45);
    fill_unevenly(*state, &camera, &m);
    compare(*state, "a ball", &m, 0.07, 0.17);
}

/* ---- the way that light goes ---- */

static double sky_at(const air_importance_camera *camera, int n, const double w[3])
{
    const float *axis = n == 0 ? camera->forward : n == 1 ? camera->up : camera->right;
    const double cosine = w[0] * (double)axis[0] + w[1] * (double)axis[1] + w[2] * (double)axis[2];
    return exp(4.0 * (cosine - 1.0));
}

/* Radiance times solid angle that an event at p, from the camera, sends there per W/m^2 of light
 * that travels along d: midpoints of the way are as good as the cells are constant. */
static double seen_of_event(const air_importance_camera *camera, const medium *m, ptrdiff_t cell,
                            air_vec3 p, air_vec3 d)
{
    enum { STEPS = 48 };
    const float distance = vec3_length(p);
    float depth = 0.0f;
    for (int n = 0; n < STEPS; n++) {
        const ptrdiff_t on = cell_at(camera, vec3_scale(p, ((float)n + 0.5f) / STEPS));
        depth += on >= 0 ? (m->sigma_s[on] + m->sigma_a[on]) * distance / STEPS : 0.0f;
    }
    const double phase = (double)phase_eval_hg(m->g[cell], -vec3_dot(d, p) / distance);
    return phase * exp(-(double)depth) / ((double)distance * (double)distance);
}

/* Light from the sky, even over the sphere, through a disk that covers the pyramid; at every event
 * the camera is looked at. */
static void shine(const air_importance_camera *camera, const medium *m, size_t count, double out[3])
{
    const float radius = 2.6f; /* of a ball around the middle of the pyramid's axis */
    const air_vec3 centre = vec3_scale(vec3_load(camera->forward), 3.0f);
    float most = 0.0f;
    for (size_t i = 0; i < ALL; i++) {
        most = fmaxf(most, m->sigma_s[i] + m->sigma_a[i]);
    }
    out[0] = out[1] = out[2] = 0.0;
    const double area = AIR_PI * (double)(radius * radius);
    for (size_t n = 0; n < count; n++) {
        air_rng rng = air_rng_from_keys((uint32_t)n, 78);
        const float z = 2.0f * air_rng_float(&rng) - 1.0f,
                    turn = 2.0f * AIR_PI_F * air_rng_float(&rng);
        const float r = radius * sqrtf(air_rng_float(&rng)),
                    phi = 2.0f * AIR_PI_F * air_rng_float(&rng);
        air_vec3 d = vec3(sqrtf(1.0f - z * z) * cosf(turn), sqrtf(1.0f - z * z) * sinf(turn), z);
        const air_frame frame = frame_from_normal(d);
        const double w[3] = {-(double)d.x, -(double)d.y, -(double)d.z};
        air_vec3 p =
            vec3_add(centre, frame_to_world(&frame, vec3(r * cosf(phi), r * sinf(phi), -radius)));
        for (;;) {
            p = vec3_madd(p, -logf(1.0f - air_rng_float(&rng)) / most, d);
            const air_vec3 from = vec3_sub(p, centre);
            if (vec3_dot(from, from) > radius * radius * 2.0f && vec3_dot(from, d) > 0.0f) {
                break;
            }
            const ptrdiff_t cell = cell_at(camera, p);
            const float u = air_rng_float(&rng) * most;
            if (cell >= 0 && u < m->sigma_s[cell]) {
                const double seen =
                    4.0 * AIR_PI * area / (double)count * seen_of_event(camera, m, cell, p, d);
                for (int k = 0; k < 3; k++) {
                    out[k] += seen * sky_at(camera, k, w);
                }
                const air_phase phase = {.kind = AIR_PHASE_HG, .g = m->g[cell]};
                float pdf;
                const float u1 = air_rng_float(&rng), u2 = air_rng_float(&rng);
                d = vec3_normalize(air_phase_sample(phase, d, u1, u2, &pdf));
            } else if (cell >= 0 && u < m->sigma_s[cell] + m->sigma_a[cell]) {
                break;
            }
        }
    }
}

/* Three skies, soft lobes of radiance ahead of the camera, above and to its right: what photons
 * from them bring to the camera against sky times map. Photons: some 1 % here; the rest is the
 * map's. */
static void maps_tell_what_light_reaches_the_camera(void **state)
{
    static medium m;
    const air_importance_camera camera = camera_of();
    for (int n = 0; n < 2; n++) {
        float map[TEXELS];
        double forward[3], adjoint[3] = {0.0, 0.0, 0.0};
        if (n == 0) {
            fill(&m, 1.0f, 0.0f, 0.9f);
        } else {
            fill_unevenly(*state, &camera, &m);
        }
        propagate(*state, &camera, &m, map, NULL);
        for (size_t t = 0; t < TEXELS; t++) {
            double w[3];
            texel_direction(t, w);
            for (int k = 0; k < 3; k++) {
                adjoint[k] += texel_angle(t) * (double)map[t] * sky_at(&camera, k, w);
            }
        }
        shine(&camera, &m, 300000, forward);
        print_message("%s: ahead %.4f (%.4f), above %.4f (%.4f), right %.4f (%.4f)\n",
                      n == 0 ? "sigma_s = 1, g = 0.9" : "a ball", adjoint[0], forward[0],
                      adjoint[1], forward[1], adjoint[2], forward[2]);
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(adjoint[k] / forward[k] - 1.0) < (k == 0 ? 0.08 : 0.15));
        }
    }
}

/* ---- what it is for ---- */

/* A sky with lamps of many sizes in all directions, the same for every camera. */
enum { WIDTH = 128, HEIGHT = 64 };

static void paint(float *pixels)
{
    memset(pixels, 0, 3 * WIDTH * HEIGHT * sizeof *pixels);
    air_rng rng = air_rng_from_keys(12, 1);
    for (int lamp = 0; lamp < 40; lamp++) {
        const air_vec3 at = vec3_normalize(vec3(
            air_rng_float(&rng) - 0.5f, air_rng_float(&rng) - 0.5f, air_rng_float(&rng) - 0.5f));
        const float sharp = 8.0f + 200.0f * air_rng_float(&rng);
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            const double theta = AIR_PI * ((double)(i / WIDTH) + 0.5) / HEIGHT;
            const double phi = 2.0 * AIR_PI * (((double)(i % WIDTH) + 0.5) / WIDTH - 0.5);
            const air_vec3 w = vec3((float)(sin(theta) * sin(phi)), (float)cos(theta),
                                    (float)(-sin(theta) * cos(phi)));
            for (int k = 0; k < 3; k++) {
                pixels[3 * i + (size_t)k] += 0.05f / 40 + expf(sharp * (vec3_dot(w, at) - 1.0f));
            }
        }
    }
}

static double hg(double g, double cosine)
{
    return (1.0 - g * g) / (4.0 * AIR_PI * pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
}

enum { RAYS = 64 };

/* 8 x 8 of the camera's rays. */
static void ray_of(const air_importance_camera *camera, int n, double out[3])
{
    const float x = camera->tan_half[0] * (((float)(n % 8) + 0.5f) / 4.0f - 1.0f);
    const float y = camera->tan_half[1] * (((float)(n / 8) + 0.5f) / 4.0f - 1.0f);
    const air_vec3 ray =
        vec3_normalize(vec3_madd(vec3_madd(vec3_load(camera->forward), x, vec3_load(camera->right)),
                                 y, vec3_load(camera->up)));
    vec3_store64(out, ray);
}

/* Light scattered once that is seen along the rays: all of the sky's. */
static void see_sky(const air_importance_camera *camera, const float *pixels, double g,
                    double out[RAYS])
{
    for (int n = 0; n < RAYS; n++) {
        double v[3];
        ray_of(camera, n, v);
        out[n] = 0.0;
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            const double theta = AIR_PI * ((double)(i / WIDTH) + 0.5) / HEIGHT;
            const double phi = 2.0 * AIR_PI * (((double)(i % WIDTH) + 0.5) / WIDTH - 0.5);
            const double w[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)};
            out[n] += (double)pixels[3 * i] * sin(theta) * hg(g, air_dot3(w, v));
        }
        out[n] *= 2.0 * AIR_PI * AIR_PI / (WIDTH * HEIGHT);
    }
}

/* The ordinates', against it: adds squares of the difference and of the mean. */
static void compare_rays(const air_importance_camera *camera, double g,
                         const air_ordinate *ordinates, size_t count, const double truth[RAYS],
                         double out[2])
{
    double mean = 0.0;
    for (int n = 0; n < RAYS; n++) {
        double v[3], seen = 0.0;
        ray_of(camera, n, v);
        for (size_t i = 0; i < count; i++) {
            seen += ordinates[i].irradiance[0] *
                    hg(g * ordinates[i].lobe, -air_dot3(ordinates[i].travel, v));
        }
        out[0] += (seen - truth[n]) * (seen - truth[n]) / RAYS;
        mean += truth[n] / RAYS;
    }
    out[1] += mean * mean;
}

/* Twelve directions of view. */
static void importance_lessens_the_error_of_what_is_seen(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    static medium m;
    paint(pixels);
    air_environment_map sky;
    air_environment_map_default(&sky);
    sky.pixels = pixels;
    sky.width = WIDTH;
    sky.height = HEIGHT;
    sky.pixel_stride = 3;
    sky.row_stride = 3 * WIDTH;
    air_environment_ordinates *self = NULL;
    assert_int_equal(air_environment_ordinates_create(*state, &sky, &self), AIR_OK);
    const double gs[] = {0.5, 0.8, 0.9};
    const size_t counts[] = {16, 64};
    for (int i = 0; i < 3; i++) {
        double sums[2][2][2] = {{{0.0}}}; /* [count][with importance] */
        fill(&m, 0.5f, 0.0f, (float)gs[i]);
        for (int view = 0; view < 12; view++) {
            const air_importance_camera camera = turned_camera(view);
            float map[TEXELS];
            double truth[RAYS];
            propagate(*state, &camera, &m, map, NULL);
            air_importance_smooth(map, 0.1f, map);
            see_sky(&camera, pixels, gs[i], truth);
            for (int n = 0; n < 4; n++) {
                static air_ordinate ordinates[64];
                air_environment_choice choice;
                air_environment_choice_default(&choice);
                choice.count = counts[n / 2];
                choice.importance = n % 2 ? map : NULL;
                assert_int_equal(air_environment_ordinates_choose(*state, self, &choice, ordinates),
                                 AIR_OK);
                compare_rays(&camera, gs[i], ordinates, choice.count, truth, sums[n / 2][n % 2]);
            }
        }
        for (int n = 0; n < 2; n++) {
            const double without = sqrt(sums[n][0][0] / sums[n][0][1]);
            const double with = sqrt(sums[n][1][0] / sums[n][1][1]);
            print_message("g = %.1f, N = %zu: error %.4f without importance, %.4f with\n", gs[i],
                          counts[n], without, with);
            assert_true(gs[i] < 0.7 || with < 0.75 * without);
        }
    }
    air_environment_ordinates_destroy(self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_are_what_photons_find),
        cmocka_unit_test(maps_tell_what_light_reaches_the_camera),
        cmocka_unit_test(importance_lessens_the_error_of_what_is_seen),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

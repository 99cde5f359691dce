/* Distance sampling: its density integrates to one, its samples follow it, its weight is
 * transmittance over density. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "airlight/airlight.h"
#include "chi_square.h"
#include "core/random.h"
#include "path/distance.h"
#include "scene/snapshot.h"

static air_context *context;

static int set_up(void **state)
{
    (void)state;
    return air_context_create(NULL, &context) == AIR_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    air_context_destroy(context);
    return 0;
}

static void add_box(air_scene *scene, float x, const float sigma_s[3], bool exponential)
{
    air_medium_desc medium;
    air_handle handle;
    air_medium_desc_default(&medium);
    memcpy(medium.sigma_s, sigma_s, sizeof medium.sigma_s);
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    const float box[12] = {1, 0, 0, x, 0, 3, 0, 0, 0, 0, 3, 0};
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    if (exponential) {
        medium.density.kind = AIR_DENSITY_EXPONENTIAL;
        medium.density.scale_height = 0.5f;
    }
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_OK);
}

/* Two boxes that overlap, a gap, and a third one. */
static air_snapshot *boxes(bool grey, bool exponential)
{
    static const float one[3] = {0.7f, 0.7f, 0.7f}, many[3] = {0.3f, 0.9f, 2.0f};
    air_scene *scene;
    air_snapshot *snapshot;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    add_box(scene, 2.0f, grey ? one : many, false);
    add_box(scene, 3.5f, one, exponential);
    add_box(scene, 7.0f, grey ? one : many, exponential);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

enum { BINS = 48, SAMPLES = 60000, STEPS = 400 };

/* Expected counts by the midpoint rule over each bin; returns the integral of the density. */
static double expect(const air_ray_media *ray, air_vec3 throughput, const air_distance_guide *guide,
                     double t0, double t1, double expected[BINS])
{
    double total = 0.0;
    for (int b = 0; b < BINS; b++) {
        double sum = 0.0;
        for (int i = 0; i < STEPS; i++) {
            const double t = t0 + (t1 - t0) * (b + (i + 0.5) / STEPS) / BINS;
            sum += (double)air_distance_sample_pdf(ray, throughput, guide, (float)t);
        }
        expected[b] = sum / STEPS * (t1 - t0) / BINS * SAMPLES;
        total += expected[b] / SAMPLES;
    }
    return total;
}

static void check(const air_snapshot *snapshot, const air_vec3 *light, air_vec3 throughput)
{
    static air_ray_media ray;
    double observed[BINS] = {0.0}, expected[BINS];
    air_rng rng = air_rng_from_keys(3, 4);
    const air_vec3 dir = vec3_normalize(vec3(1.0f, 0.05f, 0.02f));
    air_ray_media_make(&ray, &snapshot->media, vec3(0.0f, 0.1f, 0.0f), dir, 20.0f);
    assert_true(ray.closed && ray.count >= 4);
    const double t0 = (double)ray.segments[0].t0, t1 = (double)ray.segments[ray.count - 1].t1;
    const air_distance_guide about = {.point = light, .share = 0.5f};
    const air_distance_guide *guide = light != NULL ? &about : NULL;
    const double total = expect(&ray, throughput, guide, t0, t1, expected);
    double missed = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        air_distance d;
        if (!air_distance_sample(&ray, throughput, guide, air_rng_float(&rng), &d)) {
            missed += 1.0;
            continue;
        }
        const int bin = (int)(((double)d.t - t0) / (t1 - t0) * BINS);
        observed[bin < 0 ? 0 : bin < BINS ? bin : BINS - 1] += 1.0;
        const float pdf = air_distance_sample_pdf(&ray, throughput, guide, d.t);
        const float transmittance = expf(-air_ray_media_depth(&ray, d.t).y);
        assert_float_equal(d.weight.y * pdf, transmittance, 2e-4f * transmittance);
    }
    /* Steps in the density inside bins cost the midpoint rule up to a step's height / STEPS: 0.1 %
     * here. In the gap between the boxes equi-angular samples miss, and their density counts there.
     */
    assert_true(fabs(total - 1.0) < 2e-3);
    if (light != NULL) {
        return; /* bins at the edges of the gap are partly missed; the weights were checked above */
    }
    assert_true(missed == 0.0);
    assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-4);
}

static void samples_follow_their_density(void **state)
{
    (void)state;
    for (int grey = 0; grey < 2; grey++) {
        for (int exponential = 0; exponential < 2; exponential++) {
            air_snapshot *snapshot = boxes(grey != 0, exponential != 0);
            check(snapshot, NULL, vec3(1.0f, 1.0f, 1.0f));
            check(snapshot, NULL, vec3(0.1f, 0.5f, 2.0f));
            air_snapshot_release(snapshot);
        }
    }
}

static void equiangular_samples_have_the_stated_weights(void **state)
{
    (void)state;
    const air_vec3 light = vec3(3.0f, 0.6f, 0.2f);
    for (int grey = 0; grey < 2; grey++) {
        air_snapshot *snapshot = boxes(grey != 0, true);
        check(snapshot, &light, vec3(1.0f, 1.0f, 1.0f));
        air_snapshot_release(snapshot);
    }
}

/* Without a gap in the media nothing is missed, and equi-angular samples pass the chi-square too.
 */
static void equiangular_samples_follow_their_density(void **state)
{
    (void)state;
    static const float sigma[3] = {0.4f, 0.8f, 1.2f};
    static air_ray_media ray;
    double observed[BINS] = {0.0}, expected[BINS];
    const air_vec3 light = vec3(2.3f, 0.3f, 0.0f), white = vec3(1.0f, 1.0f, 1.0f);
    air_rng rng = air_rng_from_keys(8, 9);
    air_scene *scene;
    air_snapshot *snapshot;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    add_box(scene, 2.0f, sigma, false);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    air_ray_media_make(&ray, &snapshot->media, vec3(0.0f, 0.0f, 0.0f), vec3(1.0f, 0.0f, 0.0f),
                       INFINITY);
    const air_distance_guide guide = {.point = &light, .share = 0.5f};
    assert_true(fabs(expect(&ray, white, &guide, 1.0, 3.0, expected) - 1.0) < 1e-4);
    for (int i = 0; i < SAMPLES; i++) {
        air_distance d;
        if (air_distance_sample(&ray, white, &guide, air_rng_float(&rng), &d)) {
            const int bin = (int)((d.t - 1.0f) * 0.5f * BINS);
            observed[bin < 0 ? 0 : bin < BINS ? bin : BINS - 1] += 1.0;
        }
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > 1e-4);
    air_snapshot_release(snapshot);
}

/* The optical depth of a ray through constant and exponential media inverts. */
static void depth_inverts(void **state)
{
    (void)state;
    static air_ray_media ray;
    air_snapshot *snapshot = boxes(false, true);
    const air_vec3 dir = vec3_normalize(vec3(1.0f, 0.2f, 0.0f));
    air_ray_media_make(&ray, &snapshot->media, vec3(0.0f, -0.4f, 0.0f), dir, INFINITY);
    for (int channel = 0; channel < 3; channel++) {
        const float total = air_channel(ray.depth, channel);
        for (int i = 1; i < 100; i++) {
            size_t segment;
            const float depth = total * (float)i / 100.0f;
            const float t = air_ray_media_invert(&ray, channel, depth, &segment);
            assert_true(t >= ray.segments[segment].t0 && t <= ray.segments[segment].t1);
            assert_float_equal(air_channel(air_ray_media_depth(&ray, t), channel), depth,
                               1e-5f * total);
        }
    }
    air_snapshot_release(snapshot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_their_density),
        cmocka_unit_test(equiangular_samples_have_the_stated_weights),
        cmocka_unit_test(equiangular_samples_follow_their_density),
        cmocka_unit_test(depth_inverts),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

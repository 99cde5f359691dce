/* The sky as forward peaks blur it, against the sky itself and sums over it. */
#include <math.h>
#include <stdlib.h>

#include "airlight/ordinates_view.h"
#include "core/phase.h"
#include "memory_shortage.h"
#include "picture_fixture.h"
#include "random_geometry.h"
#include "render/ordinates/sky.h"
#include "scene/lights/light_table.h"
#include "small_room.h"

/* A picture of the sky, or none; turned. */
typedef struct sky_scene {
    size_t width, height;
    const float *pixels;
    float to_world[9];
    float g;
    double share;
} sky_scene;

static const float straight[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static air_status add_sky(air_scene *scene, const sky_scene *s)
{
    air_light_desc light;
    air_handle handle;
    air_status status = AIR_OK;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    light.name = "sky";
    room_set3(light.color, 2.0f, 1.0f, 0.5f);
    memcpy(light.to_world, s->to_world, sizeof light.to_world);
    if (s->pixels != NULL) {
        const air_texture_desc image = {.name = "sky",
                                        .width = s->width,
                                        .height = s->height,
                                        .channels = 3,
                                        .floats = s->pixels};
        status = air_scene_add_texture(scene, &image, &light.image);
    }
    return status == AIR_OK ? air_scene_add_light(scene, &light, &handle) : status;
}

static air_status make_snapshot(air_context *context, const sky_scene *s, air_snapshot **out)
{
    air_scene *scene = NULL;
    air_medium_desc medium;
    air_handle handle;
    *out = NULL;
    air_status status = air_scene_create(context, &scene);
    air_medium_desc_default(&medium);
    medium.name = "fog";
    room_set3(medium.sigma_s, 1.0f, 1.0f, 1.0f);
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    status = status == AIR_OK ? add_sky(scene, s) : status;
    status = status == AIR_OK ? air_scene_commit(scene, out, NULL) : status;
    air_scene_destroy(scene);
    return status;
}

/* A snapshot and its sky, blurred. */
typedef struct blurred {
    air_context *context;
    air_snapshot *snapshot;
    air_owner_table *owners;
    ord_sky sky;
} blurred;

static blurred make_blurred(const sky_scene *s)
{
    blurred self = {.context = make_context(1, NULL)};
    const air_phase phase = {AIR_PHASE_HG, s->g, NULL};
    assert_int_equal(make_snapshot(self.context, s, &self.snapshot), AIR_OK);
    assert_int_equal(air_owner_table_create(self.context, self.snapshot, "ordinates", &self.owners),
                     AIR_OK);
    assert_int_equal(ord_sky_make(self.snapshot, self.owners, phase, s->share, NULL, &self.sky),
                     AIR_OK);
    return self;
}

static void finish_blurred(blurred *self)
{
    ord_sky_finish(&self->sky);
    air_owner_table_destroy(self->owners);
    air_snapshot_release(self->snapshot);
    air_context_destroy(self->context);
}

static const air_light *light_of(const blurred *self) { return self->sky.maps[0].light; }

static air_vec3 random_vector(air_rng *rng)
{
    double d[3];
    random_direction(rng, d);
    return vec3((float)d[0], (float)d[1], (float)d[2]);
}

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance)) {
        fail_msg("%.9g, expected %.9g within %g", found, expected, tolerance);
    }
}

static float *make_pixels(size_t width, size_t height, bool rough)
{
    air_rng rng = air_rng_from_keys(12, 1);
    float *const pixels = calloc(width * height * 3, sizeof *pixels);
    assert_non_null(pixels);
    for (size_t i = 0; i < width * height; i++) {
        const double phi = 2.0 * AIR_PI * ((double)(i % width) + 0.5) / (double)width;
        const double theta = AIR_PI * ((double)(i / width) + 0.5) / (double)height;
        const double smooth = 2.0 + sin(theta) * sin(phi) + 0.5 * cos(theta);
        for (size_t c = 0; c < 3; c++) {
            pixels[i * 3 + c] =
                rough ? (float)random_between(&rng, 0.0, 2.0) : (float)(smooth + 0.1 * (double)c);
        }
    }
    return pixels;
}

/* ---- what stays ---- */

/* Whatever the picture's size, or without one. */
static void an_even_sky_stays_even(void **state)
{
    (void)state;
    static const size_t sizes[4][2] = {{0, 0}, {100, 37}, {256, 128}, {8, 4}};
    for (int n = 0; n < 4; n++) {
        sky_scene s = {.width = sizes[n][0], .height = sizes[n][1], .g = 0.9f, .share = 0.6};
        float *const pixels = calloc(s.width * s.height * 3 + 1, sizeof *pixels);
        air_rng rng = air_rng_from_keys(5, 5);
        assert_non_null(pixels);
        for (size_t i = 0; i < s.width * s.height * 3; i++) {
            pixels[i] = 3.0f;
        }
        memcpy(s.to_world, straight, sizeof straight);
        s.pixels = n > 0 ? pixels : NULL;
        blurred self = make_blurred(&s);
        for (int i = 0; i < 500; i++) {
            const air_vec3 found = ord_sky_radiance(&self.sky, random_vector(&rng));
            const double level = n > 0 ? 3.0 : 1.0; /* means of up to 8192 floats: 1e-5 */
            assert_near((double)found.x, 2.0 * level, 3e-5);
            assert_near((double)found.z, 0.5 * level, 3e-5);
        }
        finish_blurred(&self);
        free(pixels);
    }
}

/* Blur shares out what is rough; near the poles texels are not all alike, so not to the last. Mean
 * of 1 and variance of 1/3 of 128 x 64 texels: 0.6 % of noise that both have; measured 0.03 %. */
static void the_mean_is_kept(void **state)
{
    (void)state;
    static const float gs[3] = {0.5f, 0.9f, 0.99f};
    for (int n = 0; n < 3; n++) {
        float *const pixels = make_pixels(256, 128, true);
        sky_scene s = {256, 128, pixels, {0}, gs[n], pow((double)gs[n], 4.0)};
        double sum = 0.0, expected = 0.0;
        enum { COUNT = 40000 };
        memcpy(s.to_world, straight, sizeof straight);
        blurred self = make_blurred(&s);
        for (int i = 0; i < COUNT; i++) {
            const double z = 1.0 - (2.0 * i + 1.0) / COUNT, phi = 2.39996323 * i;
            const double r = sqrt(1.0 - z * z);
            const air_vec3 d = vec3((float)(r * cos(phi)), (float)z, (float)(r * sin(phi)));
            sum += (double)ord_sky_radiance(&self.sky, d).x;
            expected += (double)air_environment_radiance(light_of(&self), d).x;
        }
        print_message("g = %g: mean %.5f of the sky's\n", (double)gs[n], sum / expected);
        assert_near(sum / expected, 1.0, 0.003);
        finish_blurred(&self);
        free(pixels);
    }
}

/* ---- where things are ---- */

/* A smooth sky hardly blurred is itself: bilinear in texels of 2.8 degrees, curvature 1. */
static void smooth_skies_are_seen_where_they_are(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 5);
    float *const pixels = make_pixels(256, 128, false);
    sky_scene s = {256, 128, pixels, {0}, 0.98f, 0.5};
    double frame[3][3];
    random_frame(&rng, frame);
    for (int i = 0; i < 9; i++) {
        s.to_world[i] = (float)frame[i / 3][i % 3];
    }
    blurred self = make_blurred(&s);
    for (int i = 0; i < 2000; i++) {
        const air_vec3 d = random_vector(&rng);
        const air_vec3 found = ord_sky_radiance(&self.sky, d);
        const air_vec3 expected = air_environment_radiance(light_of(&self), d);
        assert_near((double)found.x, (double)expected.x, 0.03);
        assert_near((double)found.y, (double)expected.y, 0.015);
    }
    finish_blurred(&self);
    free(pixels);
}

static void turned_skies_are_turned(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 7);
    float *const pixels = make_pixels(128, 64, true);
    sky_scene s = {128, 64, pixels, {0}, 0.9f, 0.6};
    double frame[3][3];
    memcpy(s.to_world, straight, sizeof straight);
    blurred a = make_blurred(&s);
    random_frame(&rng, frame);
    for (int i = 0; i < 9; i++) {
        s.to_world[i] = (float)frame[i / 3][i % 3];
    }
    blurred b = make_blurred(&s);
    for (int i = 0; i < 500; i++) {
        double d[3], turned[3];
        random_direction(&rng, d);
        for (int k = 0; k < 3; k++) {
            turned[k] = dot(frame[k], d);
        }
        const air_vec3 first =
            ord_sky_radiance(&a.sky, vec3((float)d[0], (float)d[1], (float)d[2]));
        const air_vec3 then =
            ord_sky_radiance(&b.sky, vec3((float)turned[0], (float)turned[1], (float)turned[2]));
        /* angles to 1e-6, near the poles to 3e-4 by the arc cosine, of slopes up to 2 a texel */
        assert_near((double)first.x, (double)then.x, 3e-3);
    }
    finish_blurred(&a);
    finish_blurred(&b);
    free(pixels);
}

/* ---- how it is blurred ---- */

/* Narrower than a texel: the picture as it is. */
static void narrow_peaks_blur_nothing(void **state)
{
    (void)state;
    float *const pixels = make_pixels(ORD_SKY_WIDTH, ORD_SKY_HEIGHT, true);
    sky_scene s = {ORD_SKY_WIDTH, ORD_SKY_HEIGHT, pixels, {0}, 0.99999f, 0.9999};
    memcpy(s.to_world, straight, sizeof straight);
    blurred self = make_blurred(&s);
    const float *const map = self.sky.maps[0].radiance;
    for (size_t i = 0; i < ORD_SKY_WIDTH * ORD_SKY_HEIGHT; i++) {
        assert_near((double)map[i * 4], 2.0 * (double)pixels[i * 3], 1e-3);
        assert_near((double)map[i * 4 + 2], 0.5 * (double)pixels[i * 3 + 2], 1e-3);
    }
    finish_blurred(&self);
    free(pixels);
}

/* What is above a cap that leaves half of the phase function, summed over the picture's pixels,
 * four to a texel. Texels' kernels are sampled at their centres: 2 % of a light that is 1 to 10. */
static void the_blur_is_what_is_above_the_cap(void **state)
{
    (void)state;
    enum { W = 256, H = 128 };
    const double g = 0.8, share = 0.5;
    float *const pixels = make_pixels(W, H, false);
    air_rng rng = air_rng_from_keys(2, 7);
    for (size_t i = 0; i < W * H; i++) { /* a bright band */
        pixels[i * 3] += i % W > 90 && i % W < 120 && i / W > 30 && i / W < 60 ? 10.0f : 0.0f;
    }
    sky_scene s = {W, H, pixels, {0}, (float)g, share};
    memcpy(s.to_world, straight, sizeof straight);
    blurred self = make_blurred(&s);
    const double cap = (double)air_seen_cap((air_phase){AIR_PHASE_HG, (float)g, NULL}, 1.0f, share);
    for (int n = 0; n < 40; n++) {
        double d[3], sum = 0.0, weight = 0.0;
        random_direction(&rng, d);
        for (int i = 0; i < W * H; i++) {
            const double theta = AIR_PI * (i / W + 0.5) / H;
            const double phi = 2.0 * AIR_PI * ((i % W + 0.5) / W - 0.5);
            const double w[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)};
            const double square = 1.0 + g * g - 2.0 * g * dot(w, d);
            const double value =
                fmax(0.0, (1.0 - g * g) / (4.0 * AIR_PI * square * sqrt(square)) - cap);
            sum += sin(theta) * value * 2.0 * (double)pixels[i * 3];
            weight += sin(theta) * value;
        }
        const air_vec3 found =
            ord_sky_radiance(&self.sky, vec3((float)d[0], (float)d[1], (float)d[2]));
        assert_near((double)found.x, sum / weight, 0.02 * sum / weight);
    }
    finish_blurred(&self);
    free(pixels);
}

/* ---- failure ---- */

static air_status try_sky(air_context *context, void *user)
{
    const sky_scene *const s = user;
    const air_phase phase = {AIR_PHASE_HG, 0.9f, NULL};
    air_snapshot *snapshot;
    air_owner_table *owners = NULL;
    ord_sky sky;
    air_status status = make_snapshot(context, s, &snapshot);
    if (status == AIR_OK) {
        status = air_owner_table_create(context, snapshot, "ordinates", &owners);
    }
    if (status == AIR_OK) {
        status = ord_sky_make(snapshot, owners, phase, 0.5, NULL, &sky);
        assert_true(status == AIR_OK || sky.maps == NULL);
        ord_sky_finish(&sky);
    }
    air_owner_table_destroy(owners);
    air_snapshot_release(snapshot);
    return status;
}

static void allocation_failures_leave_nothing_behind(void **state)
{
    (void)state;
    float *const pixels = make_pixels(8, 4, true);
    sky_scene s = {8, 4, pixels, {0}, 0.9f, 0.5};
    memcpy(s.to_world, straight, sizeof straight);
    assert_shortage_survived(try_sky, &s, 1000);
    free(pixels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_sky_stays_even),
        cmocka_unit_test(the_mean_is_kept),
        cmocka_unit_test(smooth_skies_are_seen_where_they_are),
        cmocka_unit_test(turned_skies_are_turned),
        cmocka_unit_test(narrow_peaks_blur_nothing),
        cmocka_unit_test(the_blur_is_what_is_above_the_cap),
        cmocka_unit_test(allocation_failures_leave_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

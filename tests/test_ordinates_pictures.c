/* Pictures by method ordinates against path's: all light that media scatter. */
#include <math.h>

#include "grid_scene.h"
#include "picture_fixture.h"

enum { BLOCK = 4, BLOCKS_X = WIDTH / BLOCK, BLOCKS = BLOCKS_X * (HEIGHT / BLOCK) };

static const uint32_t media_terms = 1u << AIR_TERM_M1 | 1u << AIR_TERM_M2;

/* Means of blocks of a channel, and the variances of these. */
typedef struct block_means {
    double mean[BLOCKS], variance[BLOCKS];
} block_means;

static void add_blocks(air_image *image, const char *channel, double scale, double out[BLOCKS])
{
    const ptrdiff_t at = air_image_find_channel(image, channel);
    assert_true(at >= 0);
    const float *const plane = air_image_plane(image, (size_t)at);
    memset(out, 0, BLOCKS * sizeof *out);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        out[i / WIDTH / BLOCK * BLOCKS_X + i % WIDTH / BLOCK] += (double)plane[i] * scale;
    }
}

static block_means blocks_of(air_image *image, size_t channel)
{
    static const char *const names[3] = {"R", "G", "B"};
    static const char *const variances[3] = {"variance.R", "variance.G", "variance.B"};
    block_means out;
    add_blocks(image, names[channel], 1.0 / (BLOCK * BLOCK), out.mean);
    add_blocks(image, variances[channel], 1.0 / (BLOCK * BLOCK * BLOCK * BLOCK), out.variance);
    return out;
}

/* How far cells may be off: a block's light by `block` of it and of the picture's mean, which
 * edges need, and the picture's mean by `mean` of it. With 24 cells along 1 m of 8 events per metre
 * at most, a cell is a third of a mean free path, and what changes over it is lost in second order:
 * measured, below the noise of path, 2.8 % of a picture and 4.7 % of a block at most. */
typedef struct bias {
    double mean, block;
} bias;

/* Student's t of 15 degrees of freedom is beyond 8 once in 10^6: of 72 blocks once in 10^4 runs. */
#define T_LIMIT 8.0

static void assert_near(air_image *got, air_image *truth, const bias *most, const char *name)
{
    for (size_t c = 0; c < 3; c++) {
        const block_means a = blocks_of(got, c), b = blocks_of(truth, c);
        double mean_a = 0.0, mean_b = 0.0, variance = 0.0, worst = 0.0;
        for (size_t i = 0; i < BLOCKS; i++) {
            mean_a += a.mean[i] / BLOCKS;
            mean_b += b.mean[i] / BLOCKS;
            variance += (a.variance[i] + b.variance[i]) / (BLOCKS * BLOCKS);
        }
        for (size_t i = 0; i < BLOCKS; i++) {
            const double noise = T_LIMIT * sqrt(a.variance[i] + b.variance[i]);
            const double off = fabs(a.mean[i] - b.mean[i]) - noise;
            worst = fmax(worst, off / (b.mean[i] + mean_b));
        }
        const double off = mean_a / mean_b - 1.0, noise = T_LIMIT * sqrt(variance) / mean_b;
        if (!(fabs(off) <= most->mean + noise) || !(worst <= most->block)) {
            fail_msg("%s, channel %zu: mean off by %g (noise %g), a block by %g", name, c, off,
                     noise, worst);
        }
    }
}

static air_image *render_media(air_context *context, const air_snapshot *snapshot,
                               const char *methods, uint32_t samples, uint32_t max_depth)
{
    air_render_params params = picture(methods, samples);
    params.layers = false;
    params.terms = media_terms;
    params.max_depth = max_depth;
    params.variance_replicates = REPLICATES;
    params.ordinates.cells = 24;
    return render(context, snapshot, &params);
}

static void assert_near_path(const grid_scene *s, uint32_t samples, uint32_t max_depth,
                             const bias *most)
{
    messages m;
    air_context *context = make_context(2, &m);
    air_snapshot *snapshot;
    assert_int_equal(grid_scene_make(context, s, &snapshot), AIR_OK);
    air_image *truth = render_media(context, snapshot, "path", samples, max_depth);
    air_image *image = render_media(context, snapshot, "ordinates", 32, max_depth);
    assert_near(image, truth, most, s->name);
    assert_int_equal(m.warnings, 0);
    air_image_destroy(image);
    air_image_destroy(truth);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static const grid_scene scenes[] = {
    {.name = "sun", .lights = GRID_SUN, .sigma_s = {4, 4, 4}, .sigma_a = {0, 0, 0}, .g = 0.7f},
    {.name = "sky, coloured",
     .lights = GRID_SKY,
     .sigma_s = {1, 4, 8},
     .sigma_a = {2, 1, 0.1f},
     .g = 0.5f},
    {.name = "point outside", .lights = GRID_POINT_OUTSIDE, .sigma_s = {4, 3, 2}, .g = 0.4f},
    {.name = "point inside", .lights = GRID_POINT_INSIDE, .sigma_s = {2, 2, 2}, .g = 0.0f},
    {.name = "lamp", .lights = GRID_LAMP, .sigma_s = {4, 4, 4}, .sigma_a = {0.2f, 0, 0}, .g = 0.6f},
    {.name = "window", .lights = GRID_SUN | GRID_WINDOW, .sigma_s = {3, 3, 3}, .g = 0.3f},
    {.name = "blocker", .lights = GRID_SUN, .sigma_s = {3, 3, 3}, .g = 0.5f, .blocker = true},
    {.name = "two media",
     .lights = GRID_SUN | GRID_SKY,
     .sigma_s = {2, 3, 4},
     .g = 0.7f,
     .second = true},
    {.name = "blob",
     .lights = GRID_SUN | GRID_SKY,
     .sigma_s = {20, 20, 20},
     .sigma_a = {0, 1, 2},
     .g = 0.7f,
     .blob = true},
    {.name = "detail",
     .lights = GRID_SUN | GRID_SKY,
     .sigma_s = {4, 4, 4},
     .sigma_a = {0, 0.2f, 0.4f},
     .g = 0.6f,
     .detail = 0.8f,
     .detail_m = 0.25f},
    {.name = "blob with detail",
     .lights = GRID_SUN | GRID_SKY,
     .sigma_s = {20, 20, 20},
     .sigma_a = {0, 1, 2},
     .g = 0.7f,
     .blob = true,
     .detail = 0.8f,
     .detail_m = 0.15f},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

static void all_light_is_near_path(void **state)
{
    (void)state;
    const bias most = {0.03, 0.06};
    for (int i = 0; i < SCENES; i++) {
        assert_near_path(&scenes[i], 1024, UINT32_MAX, &most);
    }
}

static void single_scattering_is_near_path(void **state)
{
    (void)state;
    const bias most = {0.03, 0.06};
    for (int i = 0; i < SCENES; i++) {
        assert_near_path(&scenes[i], 256, 1, &most);
    }
}

static void a_limited_depth_is_near_path(void **state)
{
    (void)state;
    const bias most = {0.03, 0.06};
    assert_near_path(&scenes[0], 256, 3, &most);
    assert_near_path(&scenes[7], 256, 2, &most);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_scattering_is_near_path),
        cmocka_unit_test(a_limited_depth_is_near_path),
        cmocka_unit_test(all_light_is_near_path),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

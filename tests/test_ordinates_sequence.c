/* Sequences by method ordinates at the level interactive do not flicker: each begun where the frame
 * before ended, against the same method converged (docs/metrics.md). */
#include <math.h>
#include <stdlib.h>

#include "moving_fog.h"
#include "picture_fixture.h"

enum { FRAMES = 6, COLUMNS = 48, ROWS = 36, SIDE = 32, VOXELS = SIDE * SIDE * SIDE, BALLS = 12 };

/* One frame: balls of cloud at a time, seen from an angle. */
typedef struct moment {
    float time_s, angle_rad, g;
} moment;

/* ---- scene ---- */

/* Balls that drift by 0.06 m/s and thicken by 40 % a second; edge 1 m about the origin. The first
 * two are the ends, 24 voxels apart from border to border: both reach new voxels at once, in the
 * fourth frame, where the bounds of what there is jump as if all had moved so far. */
static void fill(float time_s, float values[VOXELS])
{
    const float middle = 0.5f / SIDE, drift = 0.06f * time_s - 0.0225f;
    float ball[BALLS][4] = {{drift - 0.275f, middle, middle, 0.1f},
                            {drift + 0.275f, middle, middle, 0.1f}};
    air_rng rng = air_rng_from_keys(5, 6);
    for (int b = 2; b < BALLS; b++) {
        ball[b][0] = 0.4f * air_rng_float(&rng) - 0.2f + drift;
        ball[b][1] = 0.4f * air_rng_float(&rng) - 0.2f;
        ball[b][2] = 0.4f * air_rng_float(&rng) - 0.2f;
        ball[b][3] = 0.08f + 0.06f * air_rng_float(&rng);
    }
    for (int i = 0; i < VOXELS; i++) {
        const float x = ((float)(i % SIDE) + 0.5f) / SIDE - 0.5f;
        const float y = ((float)(i / SIDE % SIDE) + 0.5f) / SIDE - 0.5f;
        const float z = ((float)(i / SIDE / SIDE) + 0.5f) / SIDE - 0.5f;
        values[i] = 0.0f;
        for (int b = 0; b < BALLS; b++) {
            const float dx = x - ball[b][0], dy = y - ball[b][1], dz = z - ball[b][2];
            const float share = sqrtf(dx * dx + dy * dy + dz * dz) / ball[b][3];
            const float most = 1.0f + 0.4f * time_s;
            values[i] = fmaxf(values[i], fminf(1.4f * (1.0f - share), 1.0f) * most);
        }
    }
}

/* Cuts voxels to those that hold something, in place, as files of sequences are. */
static void cut(float values[VOXELS], size_t low[3], size_t size[3])
{
    size_t high[3] = {0, 0, 0}, n = 0;
    low[0] = low[1] = low[2] = SIDE;
    for (size_t i = 0; i < VOXELS; i++) {
        const size_t at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        for (int axis = 0; axis < 3 && values[i] > 0.0f; axis++) {
            low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
            high[axis] = at[axis] + 1 > high[axis] ? at[axis] + 1 : high[axis];
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        size[axis] = high[axis] - low[axis];
    }
    for (size_t z = low[2]; z < high[2]; z++) {
        for (size_t y = low[1]; y < high[1]; y++) {
            for (size_t x = low[0]; x < high[0]; x++) {
                values[n++] = values[(z * SIDE + y) * SIDE + x];
            }
        }
    }
}

static air_status add_balls(air_scene *scene, const moment *m)
{
    const float step = 1.0f / SIDE;
    float *const values = malloc(VOXELS * sizeof *values);
    air_grid_desc grid = {"balls", {0}, 1, values, {0}};
    air_medium_desc medium;
    air_handle handle;
    size_t low[3];
    assert_non_null(values);
    fill(m->time_s, values);
    cut(values, low, grid.size);
    for (int axis = 0; axis < 3; axis++) {
        grid.index_to_local[5 * axis] = step;
        grid.index_to_local[4 * axis + 3] = ((float)low[axis] + 0.5f) * step - 0.5f;
    }
    air_medium_desc_default(&medium);
    medium.name = "balls";
    room_set3(medium.sigma_s, 24.0f, 24.0f, 24.0f);
    room_set3(medium.sigma_a, 0.2f, 0.3f, 0.5f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = m->g;
    medium.density.kind = AIR_DENSITY_GRID;
    air_status status = air_scene_add_grid(scene, &grid, &medium.density.grid);
    free(values);
    return status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
}

static air_status add_camera(air_scene *scene, float angle_rad)
{
    const float c = cosf(angle_rad), s = sinf(angle_rad);
    const float view[12] = {c, 0, s, 2.2f * s, 0, 1, 0, 0.05f, -s, 0, c, 2.2f * c};
    air_camera_desc camera;
    air_handle handle;
    air_camera_desc_default(&camera);
    memcpy(camera.to_world, view, sizeof view);
    camera.fov_y_rad = 0.4f;
    return air_scene_add_camera(scene, &camera, &handle);
}

static air_snapshot *snapshot_of(air_context *context, const moment *m)
{
    const moving_fog light = {.sky = 1.0f, .bright = 3};
    air_scene *scene;
    air_snapshot *snapshot;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(fog_add_sky(scene, &light), AIR_OK);
    assert_int_equal(add_balls(scene, m), AIR_OK);
    assert_int_equal(add_camera(scene, m->angle_rad), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

/* ---- pictures ---- */

/* Light of the media only: the sky behind them is path's. */
static air_render_params interactive(air_render_state *state)
{
    air_render_params params = picture("ordinates", 16);
    params.width = COLUMNS;
    params.height = ROWS;
    params.layers = false;
    params.terms = 1u << AIR_TERM_M1 | 1u << AIR_TERM_M2;
    params.max_depth = UINT32_MAX;
    params.ordinates.cells = 20;
    params.ordinates.directions = 64;
    params.ordinates.bands = params.ordinates.polar = 4;
    params.ordinates.azimuths = 8;
    params.ordinates.sweeps = 24;
    params.ordinates.march = 1;
    params.state = state;
    return params;
}

/* More cells and directions of light through pixels, so that what they change shows. */
static air_render_params converged(void)
{
    air_render_params params = interactive(NULL);
    params.ordinates.cells = 32;
    params.ordinates.sweeps = 256;
    params.ordinates.march = 4;
    params.sample_end = 32;
    params.seed = 7;
    return params;
}

static air_image *image_of(air_context *context, const moment *m, const air_render_params *params)
{
    air_snapshot *const snapshot = snapshot_of(context, m);
    air_image *const image = render(context, snapshot, params);
    air_snapshot_release(snapshot);
    return image;
}

typedef struct sequence {
    const char *name;
    moment first, step;
} sequence;

static const sequence drift = {"drift, g 0.5", {0, 0, 0.5f}, {1.0f / 24, 0, 0}};
static const sequence sharp_drift = {"drift, g 0.85", {0, 0, 0.85f}, {1.0f / 24, 0, 0}};
static const sequence turn = {"turning camera, g 0.5", {0, 0, 0.5f}, {0, 0.026f, 0}};

/* What is wrong from frame to frame, to see that it is found: noise that moves, and light that
 * follows by one sweep only. */
typedef enum fault { NONE, SEEDS, STALE } fault;

static void render_all(air_context *context, const sequence *s, air_render_params params,
                       fault wrong, air_image *out[FRAMES])
{
    for (int i = 0; i < FRAMES; i++) {
        const float n = (float)i;
        const moment m = {s->first.time_s + n * s->step.time_s,
                          s->first.angle_rad + n * s->step.angle_rad, s->first.g};
        params.seed += wrong == SEEDS ? 1 : 0;
        params.ordinates.sweeps = wrong == STALE && i > 0 ? 1 : params.ordinates.sweeps;
        out[i] = image_of(context, &m, &params);
    }
}

static void destroy_all(air_image *images[FRAMES])
{
    for (int i = 0; i < FRAMES; i++) {
        air_image_destroy(images[i]);
    }
}

static double ratio_of(air_context *context, air_image *a[FRAMES], air_image *b[FRAMES])
{
    air_temporal *temporal;
    air_temporal_metrics out;
    assert_int_equal(air_temporal_create(context, &temporal), AIR_OK);
    for (int i = 0; i < FRAMES; i++) {
        assert_int_equal(air_temporal_add(temporal, a[i], b[i]), AIR_OK);
    }
    assert_int_equal(air_temporal_measure(temporal, NULL, &out), AIR_OK);
    air_temporal_destroy(temporal);
    return out.ratio;
}

/* Mean of the second picture over that of the first, less 1. */
static double brighter(const air_image *a, const air_image *b)
{
    double sums[2] = {0.0, 0.0};
    for (size_t c = 0; c < air_image_channel_count(a); c++) {
        const float *const x = air_image_plane_const(a, c), *const y = air_image_plane_const(b, c);
        for (size_t i = 0; i < (size_t)COLUMNS * ROWS; i++) {
            sums[0] += (double)x[i];
            sums[1] += (double)y[i];
        }
    }
    return sums[1] / sums[0] - 1.0;
}

/* What is measured of a sequence that begins each frame from the one before. */
typedef struct outcome {
    double ratio,
        left; /* left: of the last frame, against one of the same cells swept to the end */
} outcome;

static void render_warm(air_context *context, const sequence *s, double change, fault wrong,
                        air_image *out[FRAMES])
{
    air_render_state *kept;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    air_render_params params = interactive(kept);
    params.ordinates.change = change;
    render_all(context, s, params, wrong, out);
    air_render_state_destroy(kept);
}

static outcome judge(air_context *context, const sequence *s, air_image *truth[FRAMES], fault wrong)
{
    air_image *frames[FRAMES], *ended[FRAMES];
    render_warm(context, s, 1e-3, wrong, frames);
    render_warm(context, s, 1e-6, wrong == STALE ? NONE : wrong, ended);
    const outcome out = {ratio_of(context, frames, truth),
                         brighter(ended[FRAMES - 1], frames[FRAMES - 1])};
    print_message("%s, fault %d: temporal ratio %.3f, last frame off by %.2g\n", s->name,
                  (int)wrong, out.ratio, out.left);
    destroy_all(frames);
    destroy_all(ended);
    return out;
}

/* Over five seeds the drifts have 1.092 and 0.994 with a standard deviation of 0.002, the
 * camera 1.05 with 0.009. Cells that jumped by most of a cell where bounds did had 1.35, light that
 * is swept once a frame has 1.13, noise that moves 4. */
#define RATIO 1.1

/* Sweeps end below a change of 1e-3; what they leave of light that starts from nothing, as the
 * camera's does, was up to 1e-3. */
#define LEFT 1.5e-3

static bool is_steady(outcome o) { return o.ratio <= RATIO && fabs(o.left) <= LEFT; }

/* found: a fault that is told from none. */
static void assert_steady(const sequence *s, fault found)
{
    air_context *const context = make_context(2, NULL);
    air_image *truth[FRAMES];
    render_all(context, s, converged(), NONE, truth);
    assert_true(is_steady(judge(context, s, truth, NONE)));
    assert_true(found == NONE || !is_steady(judge(context, s, truth, found)));
    destroy_all(truth);
    air_context_destroy(context);
}

static void a_drift_does_not_flicker(void **state)
{
    (void)state;
    assert_steady(&drift, STALE);
    assert_steady(&sharp_drift, NONE);
}

static void a_turning_camera_does_not_flicker(void **state)
{
    (void)state;
    assert_steady(&turn, SEEDS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_drift_does_not_flicker),
        cmocka_unit_test(a_turning_camera_does_not_flicker),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

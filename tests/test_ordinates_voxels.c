/* Rays through voxels of the media's detail gather what they gather point by point. */
#include <math.h>

#include "grid_scene.h"
#include "picture_fixture.h"
#include "render/ordinates/state.h"
#include "render/picture.h"

enum { SIDE = 12, RAYS = 192 };

/* What the medium in the cube of 1 m about the origin is made of. */
typedef struct detail {
    const char *name, *method;
    bool grid, turned, coloured, albedo;
    bool exponential;
    bool second; /* beside it, overlapping a little: those rays go point by point */
    bool split;  /* first events apart */
} detail;

static float lump(size_t i, size_t j, size_t k, float shift)
{
    const float step = 2.0f / SIDE, half = 0.5f;
    const float x = ((float)i + half) * step - 1.0f, y = ((float)j + half) * step - 1.0f;
    const float z = ((float)k + half) * step - 1.0f;
    const float r = sqrtf((x - shift) * (x - shift) + y * y + z * z);
    return fmaxf(1.0f - 1.3f * r, 0.0f);
}

/* A fading ball within the cube; turned: about the vertical by 30 degrees. */
static air_status add_grid(air_scene *scene, const detail *d, bool albedo, air_handle *out)
{
    float values[SIDE * SIDE * SIDE * 3];
    const size_t channels = albedo || d->coloured ? 3 : 1;
    for (size_t n = 0; n < SIDE * SIDE * SIDE; n++) {
        const size_t i = n % SIDE, j = n / SIDE % SIDE, k = n / SIDE / SIDE;
        for (size_t c = 0; c < channels; c++) {
            values[n * channels + c] = albedo ? 0.3f + 0.6f * (float)i / SIDE - 0.1f * (float)c
                                              : lump(i, j, k, 0.1f * (float)c);
        }
    }
    const float step = 1.0f / SIDE, first = 0.5f * step - 0.5f;
    const float cosine = d->turned ? 0.866f : 1.0f, sine = d->turned ? 0.5f : 0.0f;
    const air_grid_desc grid = {albedo ? "albedo" : "density",
                                {SIDE, SIDE, SIDE},
                                channels,
                                values,
                                {cosine * step, 0, sine * step, (cosine + sine) * first, 0, step, 0,
                                 first, -sine * step, 0, cosine * step, (cosine - sine) * first}};
    return air_scene_add_grid(scene, &grid, out);
}

static air_status add_detail(air_scene *scene, const detail *d)
{
    const float cube[12] = {0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0};
    air_medium_desc medium;
    air_handle handle;
    air_status status = AIR_OK;
    air_medium_desc_default(&medium);
    room_set3(medium.sigma_s, 6.0f, 5.0f, 4.0f);
    room_set3(medium.sigma_a, 0.2f, 0.6f, 1.0f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = 0.6f;
    medium.boundary.kind = AIR_BOUNDARY_BOX;
    memcpy(medium.boundary.box_to_world, cube, sizeof cube);
    if (d->grid) {
        medium.density.kind = AIR_DENSITY_GRID;
        status = add_grid(scene, d, false, &medium.density.grid);
    }
    if (status == AIR_OK && d->albedo) {
        status = add_grid(scene, d, true, &medium.density.albedo_grid);
    }
    if (d->exponential) {
        medium.density.kind = AIR_DENSITY_EXPONENTIAL;
        medium.density.base_height = -0.4f;
        medium.density.scale_height = 0.2f;
    }
    status = status == AIR_OK ? air_scene_add_medium(scene, &medium, &handle) : status;
    if (status == AIR_OK && d->second) {
        const float beside[12] = {0.3f, 0, 0, 0.7f, 0, 0.3f, 0, 0, 0, 0, 0.3f, 0};
        air_medium_desc_default(&medium);
        room_set3(medium.sigma_s, 2.0f, 2.0f, 2.0f);
        medium.boundary.kind = AIR_BOUNDARY_BOX;
        memcpy(medium.boundary.box_to_world, beside, sizeof beside);
        status = air_scene_add_medium(scene, &medium, &handle);
    }
    return status;
}

static air_snapshot *make(air_context *context, const detail *d)
{
    air_scene *scene;
    air_snapshot *snapshot;
    air_camera_desc camera;
    air_handle handle;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    assert_int_equal(grid_add_lights(scene, GRID_SUN | GRID_SKY), AIR_OK);
    assert_int_equal(add_detail(scene, d), AIR_OK);
    air_camera_desc_default(&camera);
    assert_int_equal(air_scene_add_camera(scene, &camera, &handle), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

/* Rays from a sphere of 3 m towards points in the cube; every seventh ends within it. */
static void aim(air_path_lane *lane, air_rng *rng)
{
    float at[3], from[3];
    for (int axis = 0; axis < 3; axis++) {
        at[axis] = 0.9f * (air_rng_float(rng) - 0.5f);
        from[axis] = air_rng_float(rng) - 0.5f;
    }
    memset(lane, 0, sizeof *lane);
    lane->origin = vec3_scale(vec3_normalize(vec3_load(from)), 3.0f);
    lane->dir = vec3_normalize(vec3_sub(vec3_load(at), lane->origin));
    lane->u_distance = air_rng_float(rng);
    const bool meets = air_rng_float(rng) < 1.0f / 7.0f;
    lane->hit.mesh = meets ? 0 : (uint32_t)AIR_NO_HIT;
    lane->hit.t = 3.0f;
}

/* Of a batch of rays, the terms side by side: M1 and M2. */
static void gather(const air_with_ordinates *with, const air_path_lane *rays, double *out)
{
    air_march_scratch *scratch;
    assert_int_equal(air_march_scratch_create(with, &scratch), AIR_OK);
    for (size_t begin = 0; begin < RAYS; begin += AIR_PATH_LANES) {
        air_path_lane lanes[AIR_PATH_LANES];
        memcpy(lanes, rays + begin, sizeof lanes);
        air_with_ordinates_add(with, scratch, lanes, AIR_PATH_LANES);
        for (size_t i = 0; i < AIR_PATH_LANES; i++) {
            const air_vec3 both[2] = {lanes[i].terms[AIR_TERM_M1], lanes[i].terms[AIR_TERM_M2]};
            for (int t = 0; t < 2; t++) {
                double *const to = out + ((begin + i) * 2 + (size_t)t) * 3;
                vec3_store64(to, both[t]);
            }
        }
    }
    air_march_scratch_destroy(with, scratch);
}

/* The largest difference of a ray, of the mean. */
static double difference(const double *a, const double *b, double *out_mean)
{
    double sum = 0.0, most = 0.0, signed_sum = 0.0;
    for (size_t i = 0; i < RAYS * 6; i++) {
        sum += b[i];
        signed_sum += a[i] - b[i];
        most = fmax(most, fabs(a[i] - b[i]));
    }
    *out_mean = signed_sum / sum;
    assert_true(sum > 0.0);
    return most * (RAYS * 3) / sum;
}

static void assert_same(const detail *d)
{
    static double voxels[RAYS * 6], points[RAYS * 6];
    messages m;
    air_context *context = make_context(2, &m);
    air_snapshot *snapshot = make(context, d);
    air_render_params params = picture(d->method, 1);
    air_picture picture;
    air_path_lane rays[RAYS];
    air_rng rng = air_rng_from_keys(7, 11);
    params.layers = d->split;
    params.max_depth = UINT32_MAX;
    params.width = params.height = 256; /* enough pixels to be worth voxels */
    params.ordinates.cells = 12;
    params.ordinates.march = 16; /* points are then as good as their integral */
    assert_int_equal(air_picture_init(&picture, context, snapshot, &params), AIR_OK);
    air_with_ordinates *const with = picture.ordinates;
    assert_non_null(with);
    assert_non_null(with->voxels[0].empty);
    for (size_t i = 0; i < RAYS; i++) {
        aim(&rays[i], &rng);
    }
    gather(with, rays, voxels);
    for (size_t r = 0; r < snapshot->media.region_count; r++) {
        air_free(context, with->voxels[r].empty);
        with->voxels[r].empty = NULL;
    }
    gather(with, rays, points);
    double mean;
    const double most = difference(voxels, points, &mean);
    print_message("%-28s mean %+.4f, a ray %.4f of the mean\n", d->name, mean, most);
    /* Light is linear between cells' centres. What is linear between voxels instead, two to a cell,
     * misses an eighth of the change of slope there: less than a tenth of the mean in a ray as
     * bright as ten. On the average ends and corners of rays count for less than 1 %. */
    assert_true(most <= 0.1);
    assert_true(fabs(mean) <= 0.01);

    air_picture_finish(&picture);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void voxels_gather_what_points_do(void **state)
{
    static const detail all[] = {
        {.name = "box", .method = "ordinates"},
        {.name = "grid", .method = "ordinates", .grid = true},
        {.name = "grid, first events apart", .method = "ordinates", .grid = true, .split = true},
        {.name = "turned grid", .method = "ordinates", .grid = true, .turned = true},
        {.name = "coloured grid", .method = "ordinates", .grid = true, .coloured = true},
        {.name = "grid of albedos", .method = "ordinates", .grid = true, .albedo = true},
        {.name = "falling with height", .method = "ordinates", .exponential = true},
        {.name = "another beside", .method = "ordinates", .grid = true, .second = true},
        {.name = "grids of their own", .method = "ordinates:cm", .grid = true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        assert_same(&all[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxels_gather_what_points_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

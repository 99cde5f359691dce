/* A room, baked and seen with its lightmap, against the same view path-traced. */
#include <stdio.h>

#include "airlight/bake.h"
#include "lightmap_view.h"

enum { TEXELS = 32, SEEDS = 16, PIXELS = 2, VALUES = PIXELS * PIXELS + 1 };

/* What is compared: direct light, which has little noise, in each of the pixels, further light in
 * all of them together. */
typedef struct values {
    double at[VALUES];
} values;

static const char *const value_names[VALUES] = {"S0, pixel 0", "S0, pixel 1", "S0, pixel 2",
                                                "S0, pixel 3", "S+"};

/* The lamp's height over the floor. */
#define LAMP_HEIGHT 1.3

/* A lamp of 1 m by 0.8 m that shines up and down, off the middle. */
static void add_lamp(air_scene *scene)
{
    const float z = (float)LAMP_HEIGHT;
    const float vertices[12] = {-0.3f, -0.6f, z, -0.3f, 0.2f, z, 0.7f, 0.2f, z, 0.7f, -0.6f, z};
    air_light_desc light;
    air_handle handle;
    air_light_desc_default(&light);
    light.name = "lamp";
    light.kind = AIR_LIGHT_POLYGON;
    light.color[0] = light.color[1] = light.color[2] = 10.0f;
    light.vertices = vertices;
    light.vertex_count = 4;
    light.camera_visible = false;
    light.one_sided = false;
    assert_int_equal(air_scene_add_light(scene, &light, &handle), AIR_OK);
}

/* A floor at z = 0 and a ceiling at 2 m, both of albedo 1/2, the lamp between them, the camera
 * below it; haze in all of the room if asked for. */
static air_snapshot *room(air_context *context, bool haze)
{
    air_scene *scene = fixture_scene(context);
    const air_material_desc grey = view_lambert(0.5f, 0.5f, 0.5f);
    const air_handle material = view_add_material(scene, &grey);
    air_mesh_desc ceiling = fixture_square("ceiling");
    air_camera_desc camera;
    air_handle handle;
    const float turned[12] = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 2.0f};
    view_add_square(scene, "floor", material);
    ceiling.uv[1] = fixture_square_uv;
    ceiling.material = material;
    memcpy(ceiling.to_world, turned, sizeof turned);
    assert_int_equal(air_scene_add_mesh(scene, &ceiling, &handle), AIR_OK);
    add_lamp(scene);
    if (haze) {
        view_add_haze(scene, 0.2f, 0.02f, 2.0f);
    }
    air_camera_desc_default(&camera);
    camera.kind = AIR_CAMERA_ORTHOGRAPHIC;
    camera.half_height = 0.5f;
    camera.to_world[11] = 1.0f;
    assert_int_equal(air_scene_add_camera(scene, &camera, &handle), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_scene_destroy(scene);
    return snapshot;
}

/* Sums and sums of squares over seeds. */
typedef struct tally {
    values sum, squares;
} tally;

static void add(tally *t, const values *v)
{
    for (size_t i = 0; i < VALUES; i++) {
        t->sum.at[i] += v->at[i];
        t->squares.at[i] += v->at[i] * v->at[i];
    }
}

/* Mean, and variance of the mean. */
static void mean_of(const tally *t, size_t value, double *mean, double *variance)
{
    *mean = t->sum.at[value] / SEEDS;
    *variance = (t->squares.at[value] / SEEDS - *mean * *mean) / (SEEDS - 1);
}

/* The floor's middle, 1 m by 1 m: texels 8 to 24 of its page. */
static void count_picture(air_context *context, const air_snapshot *snapshot,
                          const air_lightmap *lightmap, uint64_t seed, uint32_t samples, tally *out)
{
    air_render_params params = view_params(lightmap);
    params.width = params.height = PIXELS;
    params.filter = AIR_FILTER_BOX;
    params.filter_radius = air_filter_radius_default(params.filter);
    params.seed = seed;
    params.sample_end = samples;
    air_image *image = view_render(context, snapshot, &params);
    values got = {{0.0}};
    for (size_t i = 0; i < PIXELS * PIXELS; i++) {
        got.at[i] = view_value(image, "S0.G", i % PIXELS, i / PIXELS);
        got.at[VALUES - 1] += view_value(image, "S+.G", i % PIXELS, i / PIXELS) / (PIXELS * PIXELS);
    }
    add(out, &got);
    air_image_destroy(image);
}

static void count_bake(air_context *context, const air_snapshot *snapshot, uint64_t seed,
                       tally *out)
{
    air_bake_params params;
    air_lightmap *lightmap = NULL;
    air_bake_params_default(&params);
    params.samples = 64;
    params.seed = seed;
    params.media = AIR_BAKE_REFERENCE; /* which has no bias */
    params.uv = AIR_BAKE_UV_FILE;
    params.mesh_size = TEXELS;
    params.page_size = 4 * TEXELS;
    params.denoise = false;
    assert_int_equal(air_bake(context, snapshot, &params, &lightmap, NULL), AIR_OK);
    count_picture(context, snapshot, lightmap, seed, 1024, out);
    air_lightmap_destroy(lightmap);
}

/* Texels are means over their squares of side h, and what is seen between them is interpolated
 * linearly: together the irradiance is smeared by h^2/12 + h^2/6 of variance along each axis, which
 * adds h^2/8 of its Laplacian. Light of each point of the lamp, at height H, falls as
 * H^2 / (r^2 + H^2)^2, whose Laplacian is at most 8 / H^2 of it; all other light comes from further
 * around and is smoother. So at most (h/H)^2 = 0.23 % are due to that. Above it, 5 standard errors
 * of 16 bakes and 16 pictures: Student's t with 15 degrees of freedom exceeds it once in 6000. */
static void the_view_is_that_of_path(void **state)
{
    (void)state;
    const double h = 2.0 / TEXELS;
    for (int haze = 0; haze < 2; haze++) {
        air_context *context = fixture_context();
        air_snapshot *snapshot = room(context, haze == 1);
        tally baked = {{{0.0}}, {{0.0}}}, traced = {{{0.0}}, {{0.0}}};
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            count_bake(context, snapshot, seed, &baked);
            count_picture(context, snapshot, NULL, seed, 8192, &traced);
        }
        for (size_t i = 0; i < VALUES; i++) {
            double a, b, variance_a, variance_b;
            mean_of(&baked, i, &a, &variance_a);
            mean_of(&traced, i, &b, &variance_b);
            const double error = sqrt(variance_a + variance_b);
            printf("haze %d, %s: %.5f and %.5f, off by %+.2f %%, noise %.2f %%\n", haze,
                   value_names[i], a, b, 100.0 * (a / b - 1.0), 100.0 * error / b);
            assert_true(b > 0.0 && error < 0.01 * b);
            assert_true(fabs(a - b) <= 5.0 * error + h * h / (LAMP_HEIGHT * LAMP_HEIGHT) * b);
        }
        air_snapshot_release(snapshot);
        air_context_destroy(context);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_view_is_that_of_path),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

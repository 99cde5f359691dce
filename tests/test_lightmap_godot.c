/* Lightmaps for Godot, read back as its source reads them. */
#include <ctype.h>

#include "lightmap/files.h"
#include "lightmap_gltf_scene.h"

static const float pi = 3.14159265f;

static void save(lightmap_fixture *self, const air_lightmap *lightmap, float scale)
{
    char scene[LIGHTMAP_PATH];
    const air_lightmap_godot_params params = {.scale = scale};
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    if (air_lightmap_save_godot(self->context, lightmap, scene, lightmap_path(self, "godot"),
                                &params) != AIR_OK) {
        fail_msg("%s", air_context_last_error(self->context));
    }
}

static air_image *load_array(lightmap_fixture *self)
{
    air_image *image = NULL;
    assert_int_equal(
        air_image_load(self->context, lightmap_path(self, "godot/lightmap.exr"), &image), AIR_OK);
    return image;
}

static float texel(air_image *image, const char *channel, size_t index)
{
    const ptrdiff_t c = air_image_find_channel(image, channel);
    assert_true(c >= 0);
    return air_image_plane(image, (size_t)c)[index];
}

static const char *const rgb[3] = {"R", "G", "B"};

/* ---- the texture array ---- */

static void slices_lie_below_each_other(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13); /* pages of 8 x 8 and 16 x 4 */
    save(self, lightmap, 0.5f);
    air_image *array = load_array(self);
    assert_int_equal(air_image_width(array), 16);
    assert_int_equal(air_image_height(array), 2 * 8);
    for (size_t p = 0; p < 2; p++) {
        const air_image *page = lightmap->pages[p];
        const size_t width = air_image_width(page);
        for (size_t i = 0; i < width * air_image_height(page); i++) {
            for (size_t c = 0; c < 3; c++) {
                const float want = 0.5f * 683.0f * air_image_plane_const(page, c)[i] / pi;
                const size_t at = (8 * p + i / width) * 16 + i % width;
                assert_true(fabsf(texel(array, rgb[c], at) - want) <= 0x1.02p-11f * want);
            }
        }
    }
    air_image_destroy(array);
    char *import = lightmap_read(self, "godot/lightmap.exr.import", NULL);
    assert_non_null(strstr(import, "importer=\"2d_array_texture\"\n"));
    assert_non_null(strstr(import, "slices/horizontal=1\nslices/vertical=2\n"));
    free(import);
    air_lightmap_destroy(lightmap);
}

/* Incident radiance of a few directions, as coefficients: what a directional page holds. */
static void fill_directional(lightmap_fixture *self, air_image *page, size_t i, size_t c)
{
    for (size_t k = 0; k < 4; k++) {
        air_image_plane(page, 13 + 3 * k + c)[i] = 0.0f;
    }
    for (size_t n = 0; n < 3; n++) {
        double d[3], y[AIR_PROBE_COEFFICIENTS], length = 0.0;
        for (size_t k = 0; k < 3; k++) {
            d[k] = (double)lightmap_number(self) - 2.0;
            length += d[k] * d[k];
        }
        for (size_t k = 0; k < 3; k++) {
            d[k] /= sqrt(length);
        }
        air_lightmap_harmonics(d, y);
        const float power = lightmap_number(self);
        for (size_t k = 0; k < 4; k++) {
            air_image_plane(page, 13 + 3 * k + c)[i] += power * (float)y[k];
        }
    }
}

/* scene_forward_clustered.glsl: L1 = (texel - 1/2) 2; light = L0 + 4 L0 L1 . n with L1 along y, z,
 * x. */
static double shade(air_image *array, size_t row, size_t height, size_t width, size_t x, size_t c,
                    const double n[3])
{
    double slices[4];
    for (size_t s = 0; s < 4; s++) {
        slices[s] = (double)texel(array, rgb[c], (s * height + row) * width + x);
    }
    double light = slices[0];
    light += slices[0] * (slices[1] - 0.5) * 2.0 * n[1] * 4.0;
    light += slices[0] * (slices[2] - 0.5) * 2.0 * n[2] * 4.0;
    light += slices[0] * (slices[3] - 0.5) * 2.0 * n[0] * 4.0;
    return light;
}

static void directional_slices_shade_as_linear_harmonics(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, LIGHTMAP_PAGE_CHANNELS);
    lightmap->photometric = false;
    air_image *page = lightmap->pages[0];
    for (size_t i = 0; i < 64; i++) {
        for (size_t c = 0; c < 3; c++) {
            fill_directional(self, page, i, c);
        }
    }
    save(self, lightmap, 1.0f);
    air_image *array = load_array(self);
    assert_int_equal(air_image_height(array), 2 * 4 * 8);
    for (size_t i = 0; i < 64; i++) {
        for (size_t c = 0; c < 3; c++) {
            const double l0 = (double)air_image_plane(page, 13 + c)[i] * 0.28209479;
            for (size_t k = 0; k < 3; k++) {
                const double n[3] = {k == 0, k == 1, k == 2};
                static const size_t slots[3] = {3, 1, 2}; /* of x, y and z */
                /* Lambert's cosine takes pi and 2 pi / 3 of the two degrees. */
                const double l1 = (double)air_image_plane(page, 13 + 3 * slots[k] + c)[i] *
                                  0.48860251 * 2.0 / 3.0;
                const double got = shade(array, i / 8, 8, 16, i % 8, c, n);
                /* Packed values near 1/2 to 1 are off by 2^-12 in half, times 8 L0; L0 itself by
                 * 2^-11 of L0 + L1, where L1 <= 2 L0. */
                assert_true(fabs(got - (l0 + l1)) <= l0 * (8.0 * 0x1p-12 + 3.0 * 0x1p-11) * 1.01);
            }
        }
    }
    air_image_destroy(array);
    char *text = lightmap_read(self, "godot/lightmap.tres", NULL);
    assert_non_null(strstr(text, "\nuses_spherical_harmonics = true\n"));
    assert_non_null(strstr(text, "\n_uses_packed_directional = true\n"));
    free(text);
    air_lightmap_destroy(lightmap);
}

/* ---- nodes ---- */

static void users_are_nodes_by_their_names_in_godot(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "{\"mesh\":0,\"name\":\"right\"",
                "{\"mesh\":0,\"children\":[2],\"name\":\"a.b/c\\\\d\"");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    save(self, lightmap, 1.0f);
    char *text = lightmap_read(self, "godot/lightmap.tres", NULL);
    assert_non_null(strstr(text, "[gd_resource type=\"LightmapGIData\" load_steps=2 format=3]\n"));
    assert_non_null(strstr(text, "path=\"lightmap.exr\" id=\"1\"]\n"));
    assert_non_null(strstr(text, "light_textures = [ExtResource(\"1\")]\n"));
    /* Slices are 16 x 8: page 0 takes the left half, page 1 the upper one. */
    assert_non_null(strstr(text,
                           "user_data = [NodePath(\"../left\"), Rect2(0, 0, 0.5, 1), 0, -1, "
                           "NodePath(\"../a_b_c\\\\d\"), Rect2(0, 0, 1, 0.5), 1, -1, "
                           "NodePath(\"../a_b_c\\\\d/lamp\"), Rect2(0, 0, 0.5, 1), 0, -1]\n"));
    free(text);
    air_lightmap_destroy(lightmap);
}

static void names_that_occur_twice_are_numbered(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "\"name\":\"right\"", "\"name\":\"left\"");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    save(self, lightmap, 1.0f);
    char *text = lightmap_read(self, "godot/lightmap.tres", NULL);
    assert_non_null(strstr(text, "NodePath(\"../left\"), "));
    assert_non_null(strstr(text, "NodePath(\"../left2\"), "));
    free(text);
    air_lightmap_destroy(lightmap);
}

static void a_node_on_two_pages_is_left_out_with_a_warning(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, 13);
    lightmap->meshes[2].node = 0; /* page 0 as before, another primitive */
    lightmap->meshes[2].primitive = 1;
    save(self, lightmap, 1.0f);
    assert_int_equal(self->warnings, 0);
    lightmap->meshes[2].page = 1;
    save(self, lightmap, 1.0f);
    assert_int_equal(self->warnings, 1);
    assert_non_null(strstr(self->warning, "node left lies on several pages"));
    char *text = lightmap_read(self, "godot/lightmap.tres", NULL);
    assert_null(strstr(text, "../left"));
    assert_non_null(strstr(text, "user_data = [NodePath(\"../right\")"));
    free(text);
    lightmap->meshes[1].node = 9;
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    assert_int_equal(
        air_lightmap_save_godot(self->context, lightmap, scene, lightmap_path(self, "godot"), NULL),
        AIR_ERROR_FORMAT);
    lightmap_expect(self, "room.gltf: $.nodes[9]: expected a node");
    air_lightmap_destroy(lightmap);
}

/* ---- probes ---- */

enum { MOST = 1 << 14 };

typedef struct capture {
    size_t point_numbers, sh_numbers, tetrahedron_numbers, tree_numbers;
    double points[MOST], sh[MOST];
    int32_t tetrahedra[MOST], tree[MOST];
} capture;

/* The numbers in the brackets behind a word. */
static size_t read_numbers(const char *text, const char *word, double *out)
{
    const char *at = strstr(text, word);
    size_t count = 0;
    assert_non_null(at);
    for (at = strchr(at, '(') + 1; *at != ')'; at += *at == ',' ? 2 : 0) {
        char *end;
        assert_true(count < MOST);
        out[count++] = strtod(at, &end);
        assert_true(end > at);
        at = end;
    }
    return count;
}

static capture *read_capture(lightmap_fixture *self)
{
    static double numbers[MOST];
    capture *result = calloc(1, sizeof *result);
    char *text = lightmap_read(self, "godot/lightmap.tres", NULL);
    result->point_numbers = read_numbers(text, "\"points\": PackedVector3Array", result->points);
    result->sh_numbers = read_numbers(text, "\"sh\": PackedColorArray", result->sh);
    result->tetrahedron_numbers = read_numbers(text, "\"tetrahedra\": PackedInt32Array", numbers);
    for (size_t i = 0; i < result->tetrahedron_numbers; i++) {
        result->tetrahedra[i] = (int32_t)numbers[i];
    }
    result->tree_numbers = read_numbers(text, "\"bsp\": PackedInt32Array", numbers);
    for (size_t i = 0; i < result->tree_numbers; i++) {
        result->tree[i] = (int32_t)numbers[i];
    }
    free(text);
    return result;
}

/* A skewed grid of 4 x 3 x 2. */
static air_lightmap *make_probes(lightmap_fixture *self)
{
    air_lightmap *lightmap = NULL;
    assert_int_equal(air_lightmap_create(self->context, &lightmap), AIR_OK);
    lightmap->probe_set_count = 1;
    lightmap->probe_sets = air_allocate(self->context, 1, sizeof *lightmap->probe_sets);
    air_probe_set *set = &lightmap->probe_sets[0];
    lightmap_add_probes(self, set, "grid", 24);
    set->grid = true;
    memcpy(set->size, (size_t[3]){4, 3, 2}, sizeof set->size);
    memcpy(set->origin, (float[3]){-1.0f, 0.1f, 2.5f}, sizeof set->origin);
    memcpy(set->step, (float[3][3]){{0.5f, 0.1f, 0}, {0, 0.75f, 0.2f}, {0.1f, 0, -1.25f}},
           sizeof set->step);
    for (size_t i = 0; i < 24; i++) {
        const size_t at[3] = {i % 4, i / 4 % 3, i / 12};
        for (size_t k = 0; k < 3; k++) {
            float x = set->origin[k];
            for (size_t axis = 0; axis < 3; axis++) {
                x += (float)at[axis] * set->step[axis][k];
            }
            set->positions[3 * i + k] = x;
        }
    }
    return lightmap;
}

/* LightStorage::lightmap_tap_sh_light */
static int32_t find_tetrahedron(const capture *data, const double p[3])
{
    int32_t node = 0;
    while (node >= 0) {
        float plane[4];
        const int32_t *numbers = data->tree + 6 * node;
        memcpy(plane, numbers, sizeof plane);
        const double above = (double)plane[0] * p[0] + (double)plane[1] * p[1] +
                             (double)plane[2] * p[2] - (double)plane[3];
        const int32_t next = above > 0.0 ? numbers[4] : numbers[5];
        assert_true(next < 0 || next > node); /* or Godot gives up */
        assert_true(next < 0 || 6 * (size_t)next < data->tree_numbers);
        node = next;
    }
    return -node - 1;
}

static double determinant(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The smallest barycentric coordinate of a point in a tetrahedron. */
static double least_weight(const capture *data, int32_t tetrahedron, const double p[3])
{
    double corners[4][3], least = 1.0, edges[3][3];
    for (size_t i = 0; i < 4; i++) {
        const size_t point = (size_t)data->tetrahedra[4 * tetrahedron + (int32_t)i];
        assert_true(3 * point + 2 < data->point_numbers);
        memcpy(corners[i], data->points + 3 * point, sizeof corners[i]);
    }
    for (size_t k = 0; k < 3; k++) {
        for (size_t i = 0; i < 3; i++) {
            edges[i][k] = corners[i + 1][k] - corners[0][k];
        }
    }
    const double volume = determinant(edges[0], edges[1], edges[2]);
    assert_true(fabs(volume) > 0.1);
    for (size_t i = 0; i < 4; i++) {
        double moved[3][3];
        for (size_t k = 0; k < 3; k++) {
            for (size_t j = 0; j < 3; j++) {
                const double *from = i == 0 ? p : corners[0];
                const double *to = j + 1 == i ? p : corners[j + 1];
                moved[j][k] = to[k] - from[k];
            }
        }
        least = fmin(least, determinant(moved[0], moved[1], moved[2]) / volume);
    }
    return least;
}

static void every_point_of_the_grid_finds_its_tetrahedron(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = make_probes(self);
    const air_probe_set *set = &lightmap->probe_sets[0];
    save(self, lightmap, 1.0f);
    capture *data = read_capture(self);
    assert_int_equal(data->point_numbers, 72);
    assert_int_equal(data->tetrahedron_numbers, 3 * 2 * 1 * 6 * 4);
    bool met[36] = {false};
    for (size_t n = 0; n < 5000; n++) {
        double p[3] = {(double)set->origin[0], (double)set->origin[1], (double)set->origin[2]};
        for (size_t axis = 0; axis < 3; axis++) {
            const double t = (double)lightmap_number(self) / 4.0 * (double)(set->size[axis] - 1);
            for (size_t k = 0; k < 3; k++) {
                p[k] += t * (double)set->step[axis][k];
            }
        }
        const int32_t found = find_tetrahedron(data, p);
        assert_true(found >= 0 && found < 36);
        /* Planes are rounded to floats: 2^-22 of coordinates up to 4, over edges of 0.5 and more.
         */
        assert_true(least_weight(data, found, p) > -1e-5);
        met[found] = true;
    }
    for (size_t i = 0; i < 36; i++) {
        assert_true(met[i]);
    }
    free(data);
    air_lightmap_destroy(lightmap);
}

/* scene_forward_clustered.glsl, with its constants. */
static double godots_light(const double *sh, const double n[3])
{
    static const double c[5] = {0.886227, 1.023327, 0.858086, 0.247708, 0.429043};
    return c[0] * sh[0] + c[1] * sh[4] * n[1] + c[1] * sh[8] * n[2] + c[1] * sh[12] * n[0] +
           c[2] * sh[16] * n[0] * n[1] + c[2] * sh[20] * n[1] * n[2] +
           c[3] * sh[24] * (3.0 * n[2] * n[2] - 1.0) + c[2] * sh[28] * n[0] * n[2] +
           c[4] * sh[32] * (n[0] * n[0] - n[1] * n[1]);
}

/* Irradiance of radiance that is given by coefficients, by quadrature over the hemisphere: 64 x 64
 * midpoints in the square of the sine and the angle, where cos dw = dA. */
static double irradiance(const float *coefficients, const double n[3])
{
    const size_t steps = 64;
    double helper[3] = {fabs(n[0]) < 0.5, fabs(n[0]) >= 0.5, 0.0}, t[3], b[3], sum = 0.0;
    for (size_t k = 0; k < 3; k++) {
        t[k] = n[(k + 1) % 3] * helper[(k + 2) % 3] - n[(k + 2) % 3] * helper[(k + 1) % 3];
    }
    const double length = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
    for (size_t k = 0; k < 3; k++) {
        t[k] /= length;
    }
    for (size_t k = 0; k < 3; k++) {
        b[k] = n[(k + 1) % 3] * t[(k + 2) % 3] - n[(k + 2) % 3] * t[(k + 1) % 3];
    }
    for (size_t i = 0; i < steps * steps; i++) {
        const double r = sqrt(((double)(i / steps) + 0.5) / (double)steps);
        const double angle = 2.0 * acos(-1.0) * ((double)(i % steps) + 0.5) / (double)steps;
        double d[3], y[AIR_PROBE_COEFFICIENTS];
        for (size_t k = 0; k < 3; k++) {
            d[k] = r * cos(angle) * t[k] + r * sin(angle) * b[k] + sqrt(1.0 - r * r) * n[k];
        }
        air_lightmap_harmonics(d, y);
        for (size_t k = 0; k < AIR_PROBE_COEFFICIENTS; k++) {
            sum += (double)coefficients[3 * k] * y[k];
        }
    }
    return sum * acos(-1.0) / (double)(steps * steps);
}

static void probes_shade_as_their_irradiance_over_pi(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = make_probes(self);
    const air_probe_set *set = &lightmap->probe_sets[0];
    save(self, lightmap, 2.0f);
    capture *data = read_capture(self);
    assert_int_equal(data->sh_numbers, 24 * 9 * 4);
    for (size_t probe = 0; probe < 24; probe += 7) {
        for (size_t c = 0; c < 3; c++) {
            float coefficients[27];
            for (size_t i = 0; i < 9; i++) {
                coefficients[3 * i] = 0.0f;
                for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
                    coefficients[3 * i] += set->layers[k][27 * probe + 3 * i + c];
                }
            }
            for (size_t trial = 0; trial < 5; trial++) {
                double n[3], length = 0.0;
                for (size_t k = 0; k < 3; k++) {
                    n[k] = (double)lightmap_number(self) - 2.0;
                    length += n[k] * n[k];
                }
                for (size_t k = 0; k < 3; k++) {
                    n[k] /= sqrt(length);
                }
                const double want = 2.0 * irradiance(coefficients, n) / acos(-1.0);
                const double got = godots_light(data->sh + 36 * probe + c, n);
                /* Coefficients of up to 12 and the rounding of the constants to six digits; the
                 * midpoint rule is off by 1e-4 of the linear part (of sqrt(1 - r^2) at r = 1). */
                assert_true(fabs(got - want) < 5e-3);
            }
        }
    }
    free(data);
    air_lightmap_destroy(lightmap);
}

static void what_godot_cannot_have_is_left_out_with_a_warning(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = make_probes(self);
    lightmap->probe_sets[0].grid = false;
    save(self, lightmap, 1.0f);
    assert_int_equal(self->warnings, 1);
    assert_non_null(strstr(self->warning, "1 of 1 sets of probes are left out"));
    capture *data = read_capture(self);
    assert_int_equal(
        data->point_numbers + data->sh_numbers + data->tetrahedron_numbers + data->tree_numbers, 0);
    free(data);
    /* Steps in one plane. */
    lightmap->probe_sets[0].grid = true;
    memcpy(lightmap->probe_sets[0].step[2], lightmap->probe_sets[0].step[1], 12);
    save(self, lightmap, 1.0f);
    assert_int_equal(self->warnings, 2);
    air_lightmap_destroy(lightmap);
}

/* ---- files ---- */

static void writing_without_memory_leaves_nothing(void **state)
{
    lightmap_fixture *self = *state;
    scene_write(self, "", "");
    air_lightmap *lightmap = scene_lightmap(self, LIGHTMAP_PAGE_CHANNELS);
    const long live = atomic_load(&self->allocator.live);
    char scene[LIGHTMAP_PATH];
    (void)snprintf(scene, sizeof scene, "%s/room.gltf", self->folder);
    air_status status = AIR_ERROR_MEMORY;
    long allowed = 0;
    for (; status != AIR_OK && allowed < 1000; allowed++) {
        atomic_store(&self->allocator.remaining, allowed);
        status = air_lightmap_save_godot(self->context, lightmap, scene,
                                         lightmap_path(self, "godot"), NULL);
        atomic_store(&self->allocator.remaining, LIGHTMAP_MANY);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_int_equal(atomic_load(&self->allocator.live), live);
        assert_int_equal(access(lightmap_path(self, "godot"), F_OK) == 0, status == AIR_OK);
    }
    assert_true(status == AIR_OK && allowed > 30);
    air_lightmap_destroy(lightmap);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, lightmap_start, lightmap_finish)
    const struct CMUnitTest tests[] = {
        TEST(slices_lie_below_each_other),
        TEST(directional_slices_shade_as_linear_harmonics),
        TEST(users_are_nodes_by_their_names_in_godot),
        TEST(names_that_occur_twice_are_numbered),
        TEST(a_node_on_two_pages_is_left_out_with_a_warning),
        TEST(every_point_of_the_grid_finds_its_tetrahedron),
        TEST(probes_shade_as_their_irradiance_over_pi),
        TEST(what_godot_cannot_have_is_left_out_with_a_warning),
        TEST(writing_without_memory_leaves_nothing),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Light on surfaces with known answers: cavities, where it falls into which term, area lights by
 * Lambert's formula, transparency. */
#include "core/quadrature.h"
#include "path_scene.h"

/* ---- closed cavities ---- */

/* The inside of the cube [-1,1]^3. */
static void add_cube(air_scene *scene, air_handle material)
{
    static const air_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; i++) {
        const air_vec3 n = axes[i], u = vec3_scale(axes[(i + 1) % 3], 2.0f);
        const air_vec3 v = vec3_scale(axes[(i + 2) % 3], 2.0f);
        const air_vec3 edge = vec3_scale(vec3_add(u, v), -0.5f);
        add_quad(scene, vec3_sub(edge, n), u, v, material);
        add_quad(scene, vec3_add(edge, n), v, u, material);
    }
}

static probe_result measure_term(const air_snapshot *snapshot, air_vec3 origin, air_vec3 dir,
                                 air_term term, uint32_t samples)
{
    const probe p = {origin, &dir, UINT32_MAX, 1u << term, PATH_REPLICATES, samples, origin};
    return probe_run(snapshot, &p);
}

/* Walls of emission L and albedo a send L, L a, and L a^2 / (1 - a) into the three terms of an
 * empty cavity of any shape. */
static void an_empty_cavity_has_its_terms(void **state)
{
    static const double expected[AIR_TERM_COUNT] = {0.3, 0.3 * 0.6 / 0.4, 0, 0, 0.5, 0};
    air_scene *scene = path_scene(state);
    add_cube(scene, add_lambert(scene, 0.6f, 0.5f));
    air_snapshot *snapshot = path_freeze(scene);
    for (int t = 0; t < AIR_TERM_COUNT; t++) {
        const double grey[3] = {expected[t], expected[t], expected[t]};
        const probe_result got =
            measure_term(snapshot, vec3(0.3f, -0.2f, 0.1f), vec3_normalize(vec3(1.0f, 0.3f, -0.5f)),
                         (air_term)t, 4096);
        assert_measured(air_term_name((air_term)t), &got, grey, 0.005);
    }
    air_snapshot_release(snapshot);
}

/* The same filled with fog that only scatters: where walls send L + a = 1 the radiance is 1
 * everywhere. */
static air_snapshot *foggy_cavity(void **state, const float sigma_s[3])
{
    air_scene *scene = path_scene(state);
    air_medium_desc fog;
    air_medium_desc_default(&fog);
    memcpy(fog.sigma_s, sigma_s, sizeof fog.sigma_s);
    fog.phase.kind = AIR_PHASE_HG;
    fog.phase.g = 0.5f;
    add_medium(scene, &fog);
    add_cube(scene, add_lambert(scene, 0.6f, 0.4f));
    return path_freeze(scene);
}

/* Distance from a point in the cube to its walls. */
static double to_wall(const double x[3], const double d[3])
{
    double t = INFINITY;
    for (int a = 0; a < 3; a++) {
        t = fmin(t, ((d[a] > 0.0 ? 1.0 : -1.0) - x[a]) / d[a]);
    }
    return t;
}

enum { RINGS = 32 };

/* Mean over the sphere of weight(cosine to y) times the transmittance to the wall; the hemispheres
 * apart. */
static double mean_transmittance(const double x[3], double sigma, double weight(double cosine))
{
    double node[RINGS], node_weight[RINGS], sum = 0.0;
    air_gauss_legendre(RINGS, node, node_weight);
    for (int i = 0; i < 2 * RINGS; i++) {
        const double y = 0.5 * (node[i / 2] + (i % 2 == 0 ? 1.0 : -1.0)), r = sqrt(1.0 - y * y);
        for (int j = 0; j < 4 * RINGS; j++) {
            const double phi = AIR_PI * (j + 0.5) / (2 * RINGS);
            const double d[3] = {r * cos(phi), y, r * sin(phi)};
            sum += node_weight[i / 2] * weight(y) * exp(-sigma * to_wall(x, d));
        }
    }
    return sum / (4.0 * 4.0 * RINGS);
}

static double cosine_weight(double cosine) { return fmax(cosine, 0.0); }

/* For a ray that travels down. */
static double hg_weight(double cosine)
{
    return 0.75 / pow(1.25 + cosine, 1.5); /* 4 pi times the phase function of g = 0.5 */
}

/* The radiance upwards through (0.25, 0.5, 0.125), 1.5 m above the lowest wall, by terms: all is 1,
 * and what comes straight from the walls to the last event is known. */
static void cavity_terms(double sigma, double out[AIR_TERM_COUNT])
{
    enum { STEPS = 100 };
    const double through = exp(-1.5 * sigma), h = 1.5 / STEPS, floor_point[3] = {0.25, -1.0, 0.125};
    double single = 0.0;
    for (int i = 0; i < STEPS; i++) {
        const double t = (i + 0.5) * h, x[3] = {0.25, 0.5 - t, 0.125};
        single += h * sigma * exp(-sigma * t) * mean_transmittance(x, sigma, hg_weight);
    }
    out[AIR_TERM_EMISSION] = 0.4 * through;
    out[AIR_TERM_BACKGROUND] = 0.0;
    out[AIR_TERM_S0] =
        0.6 * through * 0.4 * 4.0 * mean_transmittance(floor_point, sigma, cosine_weight);
    out[AIR_TERM_S_PLUS] = 0.6 * through - out[AIR_TERM_S0];
    out[AIR_TERM_M1] = 0.4 * single;
    out[AIR_TERM_M2] = 1.0 - through - out[AIR_TERM_M1];
}

/* Slack for the quadrature: 1e-4, what doubling its nodes changes. */
static void a_foggy_cavity_has_its_terms(void **state)
{
    static const float sigma_s[3] = {0.2f, 0.6f, 1.5f};
    double expected[3][AIR_TERM_COUNT];
    for (int c = 0; c < 3; c++) {
        cavity_terms((double)sigma_s[c], expected[c]);
    }
    air_snapshot *snapshot = foggy_cavity(state, sigma_s);
    for (int t = 0; t < AIR_TERM_COUNT; t++) {
        const double rgb[3] = {expected[0][t], expected[1][t], expected[2][t]};
        const probe_result got = measure_term(snapshot, vec3(0.25f, 0.5f, 0.125f),
                                              vec3(0.0f, -1.0f, 0.0f), (air_term)t, 4096);
        assert_measured_within(air_term_name((air_term)t), &got, rgb, 0.015, 1e-4);
    }
    air_snapshot_release(snapshot);
}

static void radiance_in_a_foggy_cavity_is_one(void **state)
{
    static const float sigma_s[3][3] = {{0.5f, 0.5f, 0.5f}, {0.2f, 0.6f, 1.5f}, {8.0f, 4.0f, 8.0f}};
    static const double one[3] = {1.0, 1.0, 1.0};
    for (int i = 0; i < 3; i++) {
        air_snapshot *snapshot = foggy_cavity(state, sigma_s[i]);
        const probe_result got =
            measure_radiance(snapshot, vec3(0.25f, 0.5f, 0.125f),
                             vec3_normalize(vec3(0.3f, -1.0f, 0.1f)), UINT32_MAX, 4096);
        assert_measured("foggy cavity", &got, one, 0.005);
        air_snapshot_release(snapshot);
    }
}

/* The chance of an event must not come from the channel that the fog blocks alone. */
static void fog_opaque_in_blue_leaves_red_and_green_alone(void **state)
{
    static const float sigma_s[3] = {0.0f, 0.0f, 12.0f};
    air_snapshot *snapshot = foggy_cavity(state, sigma_s);
    const probe_result got =
        measure_radiance(snapshot, vec3(0.25f, 0.5f, 0.125f),
                         vec3_normalize(vec3(0.3f, -1.0f, 0.1f)), UINT32_MAX, 1024);
    const double expected[3] = {1.0, 1.0, got.mean[2]};
    const probe_result clear = {
        {got.mean[0], got.mean[1], got.mean[2]}, {got.error[0], got.error[1], 0.0}, {0.0}};
    assert_measured("fog in blue", &clear, expected, 0.005);
    air_snapshot_release(snapshot);
}

/* ---- area lights on a floor ---- */

/* An L in the plane y = 1.5, seen clockwise from above: it shines down. */
static const float ell[18] = {-0.5f, 1.5f, -0.6f, 0.9f, 1.5f, -0.6f, 0.9f,  1.5f, 0.1f,
                              0.2f,  1.5f, 0.1f,  0.2f, 1.5f, 0.8f,  -0.5f, 1.5f, 0.8f};
/* Upright, half of it below the floor: it shines towards -x. */
static const float window[12] = {0.8f, -0.7f, -0.5f, 0.8f, -0.7f, 0.5f,
                                 0.8f, 0.7f,  0.5f,  0.8f, 0.7f,  -0.5f};
static const float window_above[12] = {0.8f, 0.0f, -0.5f, 0.8f, 0.0f, 0.5f,
                                       0.8f, 0.7f, 0.5f,  0.8f, 0.7f, -0.5f};

/* Irradiance of a horizontal surface at the origin, looking up, by a polygon of radiance 1 above it
 * (Lambert 1760): half the sum over edges of the angle they span times the upward component of
 * their plane's normal. */
static double lambert_irradiance(const float *vertices, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        const float *p = vertices + 3 * i, *q = vertices + 3 * ((i + 1) % count);
        const double a[3] = {(double)p[0], (double)p[1], (double)p[2]};
        const double b[3] = {(double)q[0], (double)q[1], (double)q[2]};
        const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                 a[0] * b[1] - a[1] * b[0]};
        const double size = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
        if (size > 0.0) {
            sum += atan2(size, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * cross[1] / size;
        }
    }
    return 0.5 * fabs(sum);
}

static void add_polygon_light(air_scene *scene, const float *vertices, size_t count, bool visible)
{
    air_light_desc light;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_POLYGON;
    set3(light.color, 1.0f, 2.0f, 3.0f);
    light.vertices = vertices;
    light.vertex_count = count;
    light.camera_visible = visible;
    add_light(scene, &light);
}

/* The origin, on a floor of albedo 0.6, seen from 0.5 m away. */
static probe_result look_at_origin(const air_snapshot *snapshot)
{
    return measure_radiance(snapshot, vec3(-0.3f, 0.4f, 0.0f),
                            vec3_normalize(vec3(0.3f, -0.4f, 0.0f)), 1, 4096);
}

static void polygon_lights_follow_lambert(void **state)
{
    const struct {
        const char *name;
        const float *vertices;
        size_t count;
        double irradiance;
    } lights[] = {{"L above", ell, 6, lambert_irradiance(ell, 6)},
                  {"window half below", window, 4, lambert_irradiance(window_above, 4)}};
    for (int i = 0; i < 2; i++) {
        for (int visible = 0; visible < 2; visible++) {
            air_scene *scene = path_scene(state);
            add_floor(scene, 0.0f, 5.0f, add_lambert(scene, 0.6f, 0.0f));
            add_polygon_light(scene, lights[i].vertices, lights[i].count, visible != 0);
            air_snapshot *snapshot = path_freeze(scene);
            const probe_result got = look_at_origin(snapshot);
            const double e = 0.6 / AIR_PI * lights[i].irradiance;
            const double expected[3] = {e, 2.0 * e, 3.0 * e};
            assert_measured(lights[i].name, &got, expected, 0.002);
            air_snapshot_release(snapshot);
        }
    }
}

/* The panel 0.4 <= x <= 1, -0.3 <= z <= 0.5 at y = 1. */
static const float panel[12] = {0.4f, 1, -0.3f, 1, 1, -0.3f, 1, 1, 0.5f, 0.4f, 1, 0.5f};

/* Its irradiance at the origin through an absorbing haze. */
static double hazy_irradiance(double sigma)
{
    enum { NODES = 24 };
    double node[NODES], weight[NODES], sum = 0.0;
    air_gauss_legendre(NODES, node, weight);
    for (int i = 0; i < NODES; i++) {
        for (int j = 0; j < NODES; j++) {
            const double x = 0.7 + 0.3 * node[i], z = 0.1 + 0.4 * node[j];
            const double d2 = x * x + 1.0 + z * z;
            sum += weight[i] * weight[j] * exp(-sigma * sqrt(d2)) / (d2 * d2);
        }
    }
    return sum * 0.3 * 0.4;
}

/* As a polygon light, seen or not, and as a glowing mesh. Slack: shadow rays end 1e-4 of their
 * length before area lights, at an optical depth of up to 1.9. */
static void a_panel_shines_through_haze(void **state)
{
    static const float sigma_a[3] = {0.2f, 0.6f, 1.5f};
    for (int kind = 0; kind < 3; kind++) {
        double expected[3];
        air_medium_desc haze;
        air_scene *scene = path_scene(state);
        air_medium_desc_default(&haze);
        memcpy(haze.sigma_a, sigma_a, sizeof sigma_a);
        add_medium(scene, &haze);
        add_floor(scene, 0.0f, 5.0f, add_lambert(scene, 0.6f, 0.0f));
        if (kind < 2) {
            add_polygon_light(scene, panel, 4, kind == 1);
        } else {
            add_quad(scene, vec3_load(panel), vec3(0.6f, 0, 0), vec3(0, 0, 0.8f),
                     add_lambert(scene, 0.0f, 1.0f));
        }
        for (int c = 0; c < 3; c++) {
            const double sigma = (double)sigma_a[c];
            expected[c] = (kind < 2 ? c + 1.0 : 1.0) * 0.6 / AIR_PI * hazy_irradiance(sigma) *
                          exp(-0.5 * sigma);
        }
        air_snapshot *snapshot = path_freeze(scene);
        const probe_result got = look_at_origin(snapshot);
        assert_measured("panel in haze", &got, expected, 0.002);
        air_snapshot_release(snapshot);
    }
}

/* ---- transparency ---- */

static air_handle add_transparent(air_scene *scene, air_alpha_mode mode, float alpha)
{
    air_material_desc material;
    air_handle handle;
    air_material_desc_default(&material);
    set3(material.base_color, 0.0f, 0.0f, 0.0f);
    material.base_color[3] = alpha;
    material.specular = 0.0f;
    material.alpha_mode = mode;
    assert_int_equal(air_scene_add_material(scene, &material, &handle), AIR_OK);
    return handle;
}

/* Two black panes, at y = 0.5 and 0.6, or none. */
typedef struct panes {
    air_alpha_mode mode;
    float alpha[2];
    double share; /* of light that gets through */
} panes;

static const panes pane_cases[4] = {{AIR_ALPHA_BLEND, {0.3f, 0.6f}, 0.7 * 0.4},
                                    {AIR_ALPHA_BLEND, {0.25f, 0.0f}, 0.75},
                                    {AIR_ALPHA_MASK, {0.4f, 0.1f}, 1.0},
                                    {AIR_ALPHA_MASK, {0.4f, 0.6f}, 0.0}};

static air_scene *behind_panes(void **state, const panes *p)
{
    air_scene *scene = path_scene(state);
    for (int i = 0; i < 2; i++) {
        add_floor(scene, 0.5f + 0.1f * (float)i, 5.0f,
                  add_transparent(scene, p->mode, p->alpha[i]));
    }
    return scene;
}

/* Straight through: the background, also behind fog that begins before the panes and goes on behind
 * them. */
static void panes_let_the_background_through(void **state)
{
    for (int i = 0; i < 4; i++) {
        air_scene *scene = behind_panes(state, &pane_cases[i]);
        air_medium_desc haze = medium_in_box(vec3_set1(0.0f), vec3(6.0f, 1.0f, 6.0f));
        set3(haze.sigma_a, 0.2f, 0.5f, 1.0f);
        add_medium(scene, &haze);
        add_environment(scene, 1.0f, 1.0f, 1.0f);
        air_snapshot *snapshot = path_freeze(scene);
        const probe_result got =
            measure_radiance(snapshot, vec3(0, 0, 0), vec3(0.6f, 0.8f, 0.0f), 1, 4096);
        double expected[3];
        for (int c = 0; c < 3; c++) {
            expected[c] = pane_cases[i].share * exp(-(double)haze.sigma_a[c] / 0.8);
        }
        assert_measured("background behind panes", &got, expected, 0.01);
        air_snapshot_release(snapshot);
    }
}

/* A floor below lit through them: by a light that only shadow rays find, and by lights that
 * scattered rays meet too. */
static void panes_let_light_through(void **state)
{
    for (int i = 0; i < 4; i++) {
        for (int kind = 0; kind < 3; kind++) {
            air_scene *scene = behind_panes(state, &pane_cases[i]);
            add_floor(scene, 0.0f, 5.0f, add_lambert(scene, 0.6f, 0.0f));
            double e = 0.6 / AIR_PI * pane_cases[i].share;
            if (kind == 0) {
                add_point_light(scene, vec3(0.0f, 2.0f, 0.0f), 1.0f);
                e *= 0.25;
            } else {
                add_polygon_light(scene, ell, 6, kind == 1);
                e *= lambert_irradiance(ell, 6);
            }
            const double expected[3] = {e, e * (kind == 0 ? 1.0 : 2.0),
                                        e * (kind == 0 ? 1.0 : 3.0)};
            air_snapshot *snapshot = path_freeze(scene);
            const probe_result got = look_at_origin(snapshot);
            assert_measured("floor below panes", &got, expected, 0.005);
            air_snapshot_release(snapshot);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_cavity_has_its_terms),
        cmocka_unit_test(a_foggy_cavity_has_its_terms),
        cmocka_unit_test(radiance_in_a_foggy_cavity_is_one),
        cmocka_unit_test(fog_opaque_in_blue_leaves_red_and_green_alone),
        cmocka_unit_test(polygon_lights_follow_lambert),
        cmocka_unit_test(a_panel_shines_through_haze),
        cmocka_unit_test(panes_let_the_background_through),
        cmocka_unit_test(panes_let_light_through),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

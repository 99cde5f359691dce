/* Single scattering in boxes of fog against quadrature: every kind of light, every phase function,
 * coloured and overlapping media. */
#include <stdio.h>

#include "core/quadrature.h"
#include "fog_quadrature.h"
#include "path_scene.h"

static const fog_box grey_hg[1] = {
    {{-1, -1, -1}, {1, 1, 1}, {0.8, 0.8, 0.8}, {0.1, 0.1, 0.1}, {.kind = AIR_PHASE_HG, .g = 0.7f}}};
static const fog_box coloured_hg[1] = {{{-1, -1, -1},
                                        {1, 1, 1},
                                        {0.3, 0.9, 1.8},
                                        {0.2, 0.0, 0.1},
                                        {.kind = AIR_PHASE_HG, .g = -0.5f}}};
static const fog_box rayleigh[1] = {{{-1, -1, -1},
                                     {1, 1, 1},
                                     {0.2, 0.5, 1.2},
                                     {0.0, 0.0, 0.0},
                                     {.kind = AIR_PHASE_RAYLEIGH, .g = 0.0f}}};
static const air_phase_mixture three_lobes = {
    3,
    {{AIR_PHASE_HG, 0.75f, 0.5f}, {AIR_PHASE_HG, -0.5f, 0.25f}, {AIR_PHASE_RAYLEIGH, 0.0f, 0.25f}}};
static const fog_box mixed[1] = {{{-1, -1, -1},
                                  {1, 1, 1},
                                  {0.3, 0.9, 1.8},
                                  {0.2, 0.0, 0.1},
                                  {.kind = AIR_PHASE_MIXTURE, .mixture = &three_lobes}}};
/* Three that overlap in part, each with a phase function of its own. */
static const fog_box several[3] = {
    {{-1, -1, -1}, {1, 1, 1}, {0.3, 0.9, 1.8}, {0.2, 0.0, 0.1}, {.kind = AIR_PHASE_HG, .g = 0.8f}},
    {{-0.5, -0.5, -2},
     {1.5, 0.5, 2},
     {0.9, 0.2, 0.1},
     {0.0, 0.3, 0.1},
     {.kind = AIR_PHASE_HG, .g = -0.3f}},
    {{-0.7, -1.5, -0.7},
     {0.2, 1.5, 0.7},
     {0.3, 0.3, 0.3},
     {0, 0, 0},
     {.kind = AIR_PHASE_ISOTROPIC, .g = 0}}};

static const fog fogs[5] = {
    {grey_hg, 1}, {coloured_hg, 1}, {rayleigh, 1}, {mixed, 1}, {several, 3}};
static const char *const fog_names[5] = {"grey HG", "coloured HG", "Rayleigh", "a mixture",
                                         "several media"};

/* From outside, and from within. */
static const float rays[2][6] = {{-3, 0.35f, 0.4f, 1, -0.15f, -0.1f},
                                 {0.1f, -0.3f, 0.6f, 0.3f, 0.4f, -0.8f}};

static fog_vec widen(air_vec3 v) { return (fog_vec){(double)v.x, (double)v.y, (double)v.z}; }

static void add_fog(air_scene *scene, const fog *f)
{
    for (size_t i = 0; i < f->count; i++) {
        const fog_box *b = &f->boxes[i];
        const fog_vec half = fog_at((fog_vec){0, 0, 0}, 0.5, fog_between(b->low, b->high));
        const fog_vec center = fog_at(b->low, 1.0, half);
        air_medium_desc medium =
            medium_in_box(vec3((float)center.x, (float)center.y, (float)center.z),
                          vec3((float)half.x, (float)half.y, (float)half.z));
        for (int c = 0; c < 3; c++) {
            medium.sigma_s[c] = (float)b->sigma_s[c];
            medium.sigma_a[c] = (float)b->sigma_a[c];
        }
        medium.phase = b->phase;
        add_medium(scene, &medium);
    }
}

/* ---- lights without extent ---- */

/* A light and an opaque square that shades the fog from it. */
typedef struct delta_light {
    air_light_desc desc;
    bool plate; /* |x|, |z| <= plate_half at y = plate_y */
} delta_light;

static const double plate_half = 0.15, plate_y = 1.2;

static bool behind_plate(const delta_light *light, fog_vec x, fog_vec to_light, double distance)
{
    const double t = (plate_y - x.y) / to_light.y;
    const fog_vec at = fog_at(x, t, to_light);
    return light->plate && light->desc.casts_shadow && t > 0.0 && t < distance &&
           fabs(at.x) < plate_half && fabs(at.z) < plate_half;
}

/* KHR_lights_punctual: the square of a ramp in the cosine. */
static double spot_share(const air_light_desc *spot, double cosine)
{
    const double outer = cos((double)spot->outer_cone_rad);
    const double ramp = (cosine - outer) / (cos((double)spot->inner_cone_rad) - outer);
    return cosine <= outer ? 0.0 : pow(fmin(ramp, 1.0), 2.0);
}

/* The windows of these tests are rectangles along x and z, seen along the light. */
static bool in_windows(const air_light_desc *light, fog_vec x)
{
    const fog_vec along = widen(vec3_load(light->dir));
    for (size_t i = 0; i < light->window_count; i++) {
        const float *corner = light->windows[i].vertices, *opposite = corner + 6;
        const fog_vec at = fog_at(x, ((double)corner[1] - x.y) / along.y, along);
        if (at.x > (double)corner[0] && at.x < (double)opposite[0] && at.z > (double)corner[2] &&
            at.z < (double)opposite[2]) {
            return true;
        }
    }
    return light->window_count == 0;
}

static double scatter_delta(const void *user, const fog *f, int c, fog_vec x, fog_vec d)
{
    const delta_light *light = user;
    fog_vec to_light = fog_unit(widen(vec3_neg(vec3_load(light->desc.dir))));
    double distance = INFINITY, irradiance = (double)light->desc.color[c];
    if (light->desc.kind == AIR_LIGHT_COLLIMATED) {
        irradiance *= in_windows(&light->desc, x) ? 1.0 : 0.0;
    } else {
        const fog_vec way = fog_between(x, widen(vec3_load(light->desc.position)));
        const double cosine = fog_dot(to_light, fog_unit(way));
        distance = sqrt(fog_dot(way, way));
        to_light = fog_unit(way);
        irradiance *= light->desc.kind == AIR_LIGHT_SPOT ? spot_share(&light->desc, cosine) : 1.0;
        irradiance /= distance * distance;
    }
    if (irradiance == 0.0 || behind_plate(light, x, to_light, distance)) {
        return 0.0;
    }
    return irradiance * fog_scattering(f, c, x, fog_dot(d, to_light)) *
           fog_transmittance(f, c, x, to_light, distance);
}

static air_snapshot *delta_scene(void **state, const fog *f, const void *user)
{
    const delta_light *light = user;
    air_scene *scene = path_scene(state);
    add_fog(scene, f);
    add_light(scene, &light->desc);
    if (light->plate) {
        const float h = (float)plate_half;
        add_quad(scene, vec3(-h, (float)plate_y, h), vec3(2 * h, 0, 0), vec3(0, 0, -2 * h),
                 add_lambert(scene, 0.0f, 0.0f));
    }
    return path_freeze(scene);
}

/* The first fog_count fogs along both rays; steps and slack are the quadrature's. */
typedef air_snapshot *make_scene(void **state, const fog *f, const void *light);

static void compare(void **state, make_scene *make, fog_source *source, const void *light,
                    size_t fog_count, size_t steps, double slack)
{
    for (size_t k = 0; k < fog_count; k++) {
        air_snapshot *snapshot = make(state, &fogs[k], light);
        for (int r = 0; r < 2; r++) {
            char what[64];
            double expected[3];
            const air_vec3 origin = vec3_load(rays[r]);
            const air_vec3 dir = vec3_normalize(vec3_load(rays[r] + 3));
            const probe_result got = measure_radiance(snapshot, origin, dir, 1, 4096);
            for (int c = 0; c < 3; c++) {
                expected[c] =
                    fog_radiance(&fogs[k], c, widen(origin), widen(dir), steps, source, light);
            }
            snprintf(what, sizeof what, "%s, ray %d", fog_names[k], r);
            assert_measured_within(what, &got, expected, 2e-3, slack);
        }
        air_snapshot_release(snapshot);
    }
}

/* 20,000 steps of at most 1e-4 m: edges of shadows, cones and windows are placed to half a step,
 * two or three of them on a ray of which some 0.5 m are lit: 3e-4 at worst, 1e-4 where they do not
 * add up. */
static void compare_delta(void **state, const delta_light *light)
{
    compare(state, delta_scene, scatter_delta, light, 5, 20000, 1e-4);
}

static delta_light make_light(air_light_kind kind)
{
    delta_light light;
    air_light_desc_default(&light.desc);
    light.desc.kind = kind;
    light.plate = false;
    set3(light.desc.color, 3.0f, 2.0f, 1.0f);
    set3(light.desc.position, 0.2f, 1.7f, -0.1f);
    set3(light.desc.dir, -0.2f, -1.0f, 0.3f);
    return light;
}

static void point_light(void **state)
{
    delta_light light = make_light(AIR_LIGHT_POINT);
    compare_delta(state, &light);
    set3(light.desc.position, 0.25f, 0.1f, -0.15f); /* within the fog, near the rays */
    compare_delta(state, &light);
}

static void spot_light(void **state)
{
    delta_light light = make_light(AIR_LIGHT_SPOT);
    light.desc.inner_cone_rad = 0.2f;
    light.desc.outer_cone_rad = 0.45f;
    compare_delta(state, &light);
}

static void collimated_light(void **state)
{
    const delta_light light = make_light(AIR_LIGHT_COLLIMATED);
    compare_delta(state, &light);
}

static void collimated_light_through_a_gobo(void **state)
{
    static const float left[12] = {-0.8f, 2, -0.9f, -0.1f, 2, -0.9f,
                                   -0.1f, 2, 0.5f,  -0.8f, 2, 0.5f};
    static const float right[12] = {0.2f, 2, -0.7f, 0.9f, 2, -0.7f, 0.9f, 2, 0.2f, 0.2f, 2, 0.2f};
    static const air_gobo_window windows[2] = {{left, 4}, {right, 4}};
    delta_light light = make_light(AIR_LIGHT_COLLIMATED);
    light.desc.windows = windows;
    light.desc.window_count = 2;
    compare_delta(state, &light);
}

static void a_shadow_in_the_fog(void **state)
{
    delta_light light = make_light(AIR_LIGHT_POINT);
    light.plate = true;
    compare_delta(state, &light);
    light.desc.casts_shadow = false;
    compare_delta(state, &light);
    light = make_light(AIR_LIGHT_COLLIMATED);
    light.plate = true;
    compare_delta(state, &light);
}

/* ---- lights with extent ---- */

static const float panel_corner[3] = {-0.5f, 1.4f, -0.3f};
static const float panel_side[2] = {0.7f, 0.9f}; /* along x and z */

static air_snapshot *panel_scene(void **state, const fog *f, const void *camera_visible)
{
    const float x = panel_corner[0], y = panel_corner[1], z = panel_corner[2];
    const float vertices[12] = {x,
                                y,
                                z,
                                x + panel_side[0],
                                y,
                                z,
                                x + panel_side[0],
                                y,
                                z + panel_side[1],
                                x,
                                y,
                                z + panel_side[1]};
    air_light_desc light;
    air_scene *scene = path_scene(state);
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_POLYGON;
    set3(light.color, 1.0f, 1.0f, 1.0f);
    light.vertices = vertices;
    light.vertex_count = 4;
    light.camera_visible = *(const bool *)camera_visible;
    add_fog(scene, f);
    add_light(scene, &light);
    return path_freeze(scene);
}

enum { PANEL_NODES = 16 };

static double scatter_panel(const void *user, const fog *f, int c, fog_vec x, fog_vec d)
{
    double node[PANEL_NODES], weight[PANEL_NODES], sum = 0.0;
    (void)user;
    air_gauss_legendre(PANEL_NODES, node, weight);
    const double u = 0.5 * (double)panel_side[0], v = 0.5 * (double)panel_side[1];
    for (int i = 0; i < PANEL_NODES; i++) {
        for (int j = 0; j < PANEL_NODES; j++) {
            const fog_vec at = {(double)panel_corner[0] + u * (1.0 + node[i]),
                                (double)panel_corner[1],
                                (double)panel_corner[2] + v * (1.0 + node[j])};
            const fog_vec way = fog_between(x, at), to_light = fog_unit(way);
            sum += weight[i] * weight[j] * to_light.y / fog_dot(way, way) *
                   fog_scattering(f, c, x, fog_dot(d, to_light)) *
                   fog_transmittance(f, c, x, to_light, sqrt(fog_dot(way, way)));
        }
    }
    return sum * u * v;
}

/* Doubling the nodes and steps changes the quadrature by less than 5e-5. */
static void polygon_light(void **state)
{
    const bool visible = true, hidden = false;
    compare(state, panel_scene, scatter_panel, &visible, 5, 100, 1e-4);
    compare(state, panel_scene, scatter_panel, &hidden, 5, 100, 1e-4);
}

static air_snapshot *sky_scene(void **state, const fog *f, const void *user)
{
    air_light_desc light;
    air_scene *scene = path_scene(state);
    (void)user;
    air_light_desc_default(&light);
    light.kind = AIR_LIGHT_ENVIRONMENT;
    set3(light.color, 1.0f, 1.0f, 1.0f);
    light.camera_visible = false;
    add_fog(scene, f);
    add_light(scene, &light);
    return path_freeze(scene);
}

enum { SKY_RINGS = 32 };

static double scatter_sky(const void *user, const fog *f, int c, fog_vec x, fog_vec d)
{
    double node[SKY_RINGS], weight[SKY_RINGS], sum = 0.0;
    (void)user;
    air_gauss_legendre(SKY_RINGS, node, weight);
    for (int i = 0; i < SKY_RINGS; i++) {
        for (int j = 0; j < 2 * SKY_RINGS; j++) {
            const double phi = AIR_PI * (j + 0.5) / SKY_RINGS, r = sqrt(1.0 - node[i] * node[i]);
            const fog_vec to_light = {r * cos(phi), node[i], r * sin(phi)};
            sum += weight[i] * fog_scattering(f, c, x, fog_dot(d, to_light)) *
                   fog_transmittance(f, c, x, to_light, INFINITY);
        }
    }
    return sum * AIR_PI / SKY_RINGS;
}

/* The transmittance has kinks where directions pass the box's edges: the quadrature is good to some
 * 5e-4, which is what three times the directions change. */
static void environment(void **state)
{
    compare(state, sky_scene, scatter_sky, NULL, 4, 300, 1e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(point_light),         cmocka_unit_test(spot_light),
        cmocka_unit_test(collimated_light),    cmocka_unit_test(collimated_light_through_a_gobo),
        cmocka_unit_test(a_shadow_in_the_fog), cmocka_unit_test(polygon_light),
        cmocka_unit_test(environment),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

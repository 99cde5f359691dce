/* Media that do not scatter, of every kind: what they let through is exp(-depth), what they emit is
 * j / sigma_a (1 - exp(-depth)); and media in balance with their surroundings are invisible. */
#include "core/random.h"
#include "path_scene.h"

static const float sigma_a[3] = {0.2f, 0.7f, 1.5f};
static const float glow[3] = {1.0f, 2.0f, 0.5f}; /* radiance per metre */

/* A kind of medium, without coefficients, and a ray. */
typedef air_medium_desc make_medium(air_scene *scene);
typedef struct slab {
    const char *name;
    make_medium *make;
    float ray[6];
    double length; /* integral of the density along the ray; NAN: by grid_length */
} slab;

/* ---- the kinds ---- */

/* Turned by 0.5 about y, then stretched in x. */
static air_medium_desc turned_box(air_scene *scene)
{
    (void)scene;
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(1.0f));
    const float c = cosf(0.5f), s = sinf(0.5f);
    const float box[12] = {1.5f * c, 0, 1.5f * s, 0.1f, 0, 1, 0, 0, -s, 0, c, 0};
    memcpy(medium.boundary.box_to_world, box, sizeof box);
    return medium;
}

/* Where x' = (x - 0.1) / 1.5, z' lie within the turned square, for a ray along x at z = 0.2. */
static double turned_box_length(void)
{
    double t0 = -INFINITY, t1 = INFINITY;
    for (int axis = 0; axis < 2; axis++) {
        const double dx = axis == 0 ? cos(0.5) : sin(0.5), dz = axis == 0 ? -sin(0.5) : cos(0.5);
        const double a = (-1.0 - 0.2 * dz) / dx, b = (1.0 - 0.2 * dz) / dx;
        t0 = fmax(t0, fmin(a, b));
        t1 = fmin(t1, fmax(a, b));
    }
    return 1.5 * (t1 - t0);
}

static const float octahedron_planes[8 * 4] = {1,  1, 1,  1,  1, 1,  -1, 1,  1,  -1, 1,
                                               1,  1, -1, -1, 1, -1, 1,  1,  1,  -1, 1,
                                               -1, 1, -1, -1, 1, 1,  -1, -1, -1, 1};

static air_medium_desc octahedron(air_scene *scene)
{
    (void)scene;
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_CONVEX;
    medium.boundary.planes = octahedron_planes;
    medium.boundary.plane_count = 8;
    return medium;
}

/* The octahedron with one corner pushed in to x = 0.2: not convex. */
static air_medium_desc dented_octahedron(air_scene *scene)
{
    (void)scene;
    static const float positions[18] = {0.2f, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
    static const uint32_t indices[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                         2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_MESH;
    medium.boundary.positions = positions;
    medium.boundary.vertex_count = 6;
    medium.boundary.indices = indices;
    medium.boundary.triangle_count = 8;
    return medium;
}

static air_medium_desc height_fog(air_scene *scene)
{
    (void)scene;
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(1.0f));
    medium.density.kind = AIR_DENSITY_EXPONENTIAL;
    medium.density.base_height = -0.2f;
    medium.density.scale_height = 0.3f;
    return medium;
}

static air_medium_desc unbounded_height_fog(air_scene *scene)
{
    air_medium_desc medium = height_fog(scene);
    medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    return medium;
}

static air_medium_desc layers(air_scene *scene)
{
    (void)scene;
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.density.kind = AIR_DENSITY_LAYERED;
    medium.density.layer_count = 3;
    medium.density.layer_bottom[0] = -1.0f;
    medium.density.layer_bottom[1] = -0.5f;
    medium.density.layer_bottom[2] = 0.25f;
    medium.density.layer_density[0] = 1.5f;
    medium.density.layer_density[1] = 0.0f;
    medium.density.layer_density[2] = 0.5f;
    medium.density.layer_top = 1.0f;
    return medium;
}

enum { SIDE = 6 };

/* A third of the values are 0. */
static void grid_values(float values[SIDE * SIDE * SIDE])
{
    air_rng rng = air_rng_from_keys(31, 32);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        values[i] = fmaxf(0.0f, 3.0f * air_rng_float(&rng) - 1.0f);
    }
}

static air_medium_desc random_grid(air_scene *scene)
{
    float values[SIDE * SIDE * SIDE];
    const air_vec3 half = vec3(1.0f, 1.0f, 1.0f);
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), half);
    grid_values(values);
    medium.density.kind = AIR_DENSITY_GRID;
    medium.density.grid = add_box_grid(scene, SIDE, 1, values, vec3_set1(0.0f), half);
    return medium;
}

/* Trilinear between the cells' centres in [-1,1]^3, continued to its faces. */
static double trilinear(const float *values, double x, double y, double z)
{
    const double p[3] = {x, y, z};
    int low[3];
    double share[3], sum = 0.0;
    for (int a = 0; a < 3; a++) {
        if (fabs(p[a]) >= 1.0) {
            return 0.0;
        }
        const double at = fmin(fmax((p[a] + 1.0) * 0.5 * SIDE - 0.5, 0.0), SIDE - 1.0);
        low[a] = (int)fmin(floor(at), SIDE - 2.0);
        share[a] = at - low[a];
    }
    for (int corner = 0; corner < 8; corner++) {
        const int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
        const int at = ((low[2] + dz) * SIDE + low[1] + dy) * SIDE + low[0] + dx;
        sum += (dx != 0 ? share[0] : 1.0 - share[0]) * (dy != 0 ? share[1] : 1.0 - share[1]) *
               (dz != 0 ? share[2] : 1.0 - share[2]) * (double)values[at];
    }
    return sum;
}

/* Midpoint rule over 6 m; two jumps at the ends, each half a step of 1e-5 m: 1e-5 of 1 m. */
static double grid_length(const float ray[6])
{
    enum { STEPS = 600000 };
    const double norm = sqrt((double)(ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5]));
    const double h = 6.0 / STEPS;
    float values[SIDE * SIDE * SIDE];
    double sum = 0.0;
    grid_values(values);
    for (int i = 0; i < STEPS; i++) {
        const double t = (i + 0.5) * h / norm;
        sum +=
            h * trilinear(values, (double)ray[0] + t * (double)ray[3],
                          (double)ray[1] + t * (double)ray[4], (double)ray[2] + t * (double)ray[5]);
    }
    return sum;
}

/* Of exp(-max(0, y + 0.2) / 0.3) along a ray of slope dy from height y0 to y1 > -0.2 > y0. */
static double fog_length(double y0, double y1, double dy)
{
    return ((-0.2 - y0) + 0.3 * (1.0 - exp(-(y1 + 0.2) / 0.3))) / dy;
}

/* ---- checks ---- */

static double length_of(const slab *s)
{
    return isnan(s->length) ? grid_length(s->ray) : s->length;
}

/* What the ray sees of a medium with these coefficients, with or without an environment of radiance
 * 1 behind it. */
static probe_result look(void **state, const slab *s, bool absorbing, bool shining, bool lit)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium = s->make(scene);
    if (absorbing) {
        memcpy(medium.sigma_a, sigma_a, sizeof sigma_a);
    }
    if (shining) {
        memcpy(medium.emission, glow, sizeof glow);
    }
    if (lit) {
        add_environment(scene, 1.0f, 1.0f, 1.0f);
    }
    add_medium(scene, &medium);
    air_snapshot *snapshot = path_freeze(scene);
    const probe_result got = measure_radiance(
        snapshot, vec3_load(s->ray), vec3_normalize(vec3_load(s->ray + 3)), UINT32_MAX, 4096);
    air_snapshot_release(snapshot);
    return got;
}

/* Slack: lengths in float are good to some 1e-6 of the scene, times an optical depth of up to 5,
 * and the grid's quadrature to 1e-5. */
static void check_through(void **state, const slab *s, double largest_error)
{
    const double length = length_of(s);
    double through[3];
    for (int c = 0; c < 3; c++) {
        through[c] = exp(-(double)sigma_a[c] * length);
    }
    const probe_result got = look(state, s, true, false, true);
    assert_measured_within(s->name, &got, through, largest_error, 2e-5);
}

static void check_absorbed_emission(void **state, const slab *s, double largest_error)
{
    const double length = length_of(s);
    double emitted[3];
    for (int c = 0; c < 3; c++) {
        const double sigma = (double)sigma_a[c];
        emitted[c] = (double)glow[c] / sigma * -expm1(-sigma * length);
    }
    const probe_result got = look(state, s, true, true, false);
    assert_measured_within(s->name, &got, emitted, largest_error, 2e-5);
}

static void check_emission(void **state, const slab *s, double largest_error)
{
    const double length = length_of(s);
    double emitted[3];
    for (int c = 0; c < 3; c++) {
        emitted[c] = (double)glow[c] * length;
    }
    const probe_result got = look(state, s, false, true, false);
    check_absorbed_emission(state, s, largest_error);
    assert_measured_within(s->name, &got, emitted, largest_error, 2e-5);
}

/* Closed forms leave nothing to chance. */
static void bodies_of_constant_density(void **state)
{
    const slab slabs[] = {
        {"turned box", turned_box, {-3, 0.1f, 0.2f, 1, 0, 0}, turned_box_length()},
        {"octahedron from within", octahedron, {0.1f, 0.2f, -0.1f, 0, 0, 1}, 0.7 + 0.1},
        {"octahedron", octahedron, {-3, 0.1f, 0.3f, 1, 0, 0}, 2.0 * 0.6},
        /* it leaves through the face x / 0.2 + y + z = 1 */
        {"dented octahedron", dented_octahedron, {-3, 0.1f, 0.3f, 1, 0, 0}, 0.6 + 0.2 * 0.6},
        {"layers upwards", layers, {0, -2, 0, 0.6f, 0.8f, 0}, (1.5 * 0.5 + 0.5 * 0.75) / 0.8},
        {"layers from within", layers, {0, 0.5f, 0, 3, -4, 0}, (1.5 * 0.5 + 0.5 * 0.25) / 0.8},
        {"between layers", layers, {0, 0, 0, 1, 0, 0}, 0.0},
    };
    for (size_t i = 0; i < sizeof slabs / sizeof slabs[0]; i++) {
        check_through(state, &slabs[i], 0.0);
        check_emission(state, &slabs[i], 0.0);
    }
}

static void fog_that_thins_with_height(void **state)
{
    const slab slabs[] = {
        {"fog upwards", height_fog, {0.1f, -3, 0, 0, 1, 0}, fog_length(-1.0, 1.0, 1.0)},
        {"fog downwards", height_fog, {0.1f, 3, 0, 0, -1, 0}, fog_length(-1.0, 1.0, 1.0)},
        {"slanting fog", height_fog, {-0.375f, -0.5f, 0, 3, 4, 0}, fog_length(-0.5, 1.0, 0.8)},
        {"level fog", height_fog, {-3, 0.4f, 0, 1, 0, 0}, 2.0 * exp(-0.6 / 0.3)},
    };
    for (size_t i = 0; i < sizeof slabs / sizeof slabs[0]; i++) {
        check_through(state, &slabs[i], 0.0);
        check_emission(state, &slabs[i], 0.003);
    }
}

static void fog_without_end(void **state)
{
    const slab s = {"fog to infinity",
                    unbounded_height_fog,
                    {0, -0.5f, 0, 3, 4, 0},
                    fog_length(-0.5, INFINITY, 0.8)};
    check_through(state, &s, 0.0);
    check_absorbed_emission(state, &s, 0.003);
}

/* By ratio tracking. */
static void grids(void **state)
{
    const slab slabs[] = {
        {"grid from outside", random_grid, {-3, 0.1f, 0.2f, 1, 0.05f, -0.1f}, NAN},
        {"grid from within", random_grid, {0.1f, 0.2f, 0.3f, -0.3f, 0.8f, 0.2f}, NAN},
    };
    for (size_t i = 0; i < sizeof slabs / sizeof slabs[0]; i++) {
        check_through(state, &slabs[i], 0.003);
        check_emission(state, &slabs[i], 0.003);
    }
}

/* In an environment of radiance 1 a medium with j = sigma_a neither darkens nor brightens, however
 * it scatters. */
static void a_medium_in_balance_with_its_surroundings_is_invisible(void **state)
{
    static make_medium *const makers[4] = {turned_box, dented_octahedron, height_fog, random_grid};
    static const double one[3] = {1.0, 1.0, 1.0};
    for (int i = 0; i < 4; i++) {
        air_scene *scene = path_scene(state);
        air_medium_desc medium = makers[i](scene);
        set3(medium.sigma_s, 0.8f, 0.5f, 1.0f);
        memcpy(medium.sigma_a, sigma_a, sizeof sigma_a);
        memcpy(medium.emission, sigma_a, sizeof sigma_a);
        medium.phase.kind = AIR_PHASE_HG;
        medium.phase.g = 0.6f;
        add_environment(scene, 1.0f, 1.0f, 1.0f);
        add_medium(scene, &medium);
        air_snapshot *snapshot = path_freeze(scene);
        const air_vec3 dir = vec3_normalize(vec3(1.0f, 0.1f, -0.1f));
        const probe_result got =
            measure_radiance(snapshot, vec3(-3.0f, 0.1f, 0.2f), dir, UINT32_MAX, 4096);
        assert_measured("balance", &got, one, 0.003);
        air_snapshot_release(snapshot);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_of_constant_density),
        cmocka_unit_test(fog_that_thins_with_height),
        cmocka_unit_test(fog_without_end),
        cmocka_unit_test(grids),
        cmocka_unit_test(a_medium_in_balance_with_its_surroundings_is_invisible),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

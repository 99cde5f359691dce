/* importance.c: which directions of the sky the camera sees by scattering.
 *
 * Cells of the pyramid are taken for cubes of edge 1 whose coefficients are optical depths along
 * the camera's ray: what rays lose is then exact, and what is scattered sees cells as deep as they
 * are along the view and as wide as that. A cell sends light on in two lobes about its ray: what
 * was scattered once, and the rest. For these, blocks of 2 x 2 x 2 cells are one. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"
#include "ordinates/four.h"

enum {
    SIDE = AIR_IMPORTANCE_CELLS,
    ALL = AIR_IMPORTANCE_CELLS_ALL,
    BLOCK = 2,
    BLOCKS = SIDE / BLOCK,
    STEPS = 64,
    MARCH = 64, /* steps from side to side of the pyramid */
    WIDTH = AIR_IMPORTANCE_WIDTH,
    HEIGHT = AIR_IMPORTANCE_HEIGHT,
    TEXELS = AIR_IMPORTANCE_TEXELS,
    COARSE = 2,            /* texels along each axis for which light is followed out together */
    BAND = COARSE * WIDTH, /* texels of rows that are worked at together */
    LINE = 64              /* alignment */
};

typedef struct importance_block {
    double x, y, depth;  /* along right, up, forward */
    double direction[3]; /* of the ray, likewise */
    double power[2];     /* scattered for the first time, and again */
    double lobe[2];      /* mean cosines to the direction, afterwards */
} importance_block;

typedef struct importance_work {
    float sigma_s[ALL], sigma_a[ALL], g[ALL]; /* optical depths */
    float entry[SIDE * SIDE], cosine[ALL];
    float fluence[ALL], beam[ALL], seen[ALL];
    float sigma_t[ALL]; /* 1/m */
    float map[TEXELS];
    float texel[3][TEXELS];                      /* directions along right, up, forward */
    float middle[3][TEXELS / (COARSE * COARSE)]; /* of COARSE x COARSE texels, likewise */
    float left[TEXELS];                          /* transmittances from a block */
    importance_block blocks[BLOCKS * BLOCKS * BLOCKS];
} importance_work;

/* ---- the pyramid ---- */

static air_status check_camera(air_context *context, const air_importance_camera *camera)
{
    const air_vec3 x = vec3_load(camera->right), y = vec3_load(camera->up),
                   z = vec3_load(camera->forward);
    const float lengths[3] = {vec3_dot(x, x), vec3_dot(y, y), vec3_dot(z, z)};
    const float slants[3] = {vec3_dot(x, y), vec3_dot(y, z), vec3_dot(z, x)};
    bool fine = vec3_is_finite(vec3_load(camera->position)) && camera->near_m >= 0.0f &&
                camera->far_m > camera->near_m && camera->far_m <= 1e30f;
    for (int k = 0; k < 3; k++) {
        fine = fine && fabsf(lengths[k] - 1.0f) < 1e-3f && fabsf(slants[k]) < 1e-3f;
    }
    for (int k = 0; k < 2; k++) {
        fine = fine && camera->tan_half[k] > 0.0f && camera->tan_half[k] <= 100.0f;
    }
    return fine ? AIR_OK
                : air_fail(
                      context, AIR_ERROR_ARGUMENT,
                      "importance: expected a finite position, orthonormal axes, tangents above "
                      "0, up to 100, and 0 <= near < far");
}

/* Tangent at the middle of cell i along an axis. */
static double tangent(const air_importance_camera *camera, int axis, size_t i)
{
    return (double)camera->tan_half[axis] * ((2.0 * (double)i + 1.0) / SIDE - 1.0);
}

static double slice_depth(const air_importance_camera *camera)
{
    return ((double)camera->far_m - (double)camera->near_m) / SIDE;
}

air_status air_importance_points(air_context *context, const air_importance_camera *camera,
                                 float *out)
{
    const air_status status = check_camera(context, camera);
    for (size_t cell = 0; status == AIR_OK && cell < ALL; cell++) {
        const size_t i = cell % SIDE, j = cell / SIDE % SIDE, k = cell / SIDE / SIDE;
        const double depth = (double)camera->near_m + ((double)k + 0.5) * slice_depth(camera);
        const double x = depth * tangent(camera, 0, i), y = depth * tangent(camera, 1, j);
        for (int axis = 0; axis < 3; axis++) {
            out[3 * cell + (size_t)axis] =
                (float)((double)camera->position[axis] + x * (double)camera->right[axis] +
                        y * (double)camera->up[axis] + depth * (double)camera->forward[axis]);
        }
    }
    return status;
}

/* Solid angle of the rectangle from the axis to tangents x and y. */
static double quadrant_angle(double x, double y) { return atan(x * y / sqrt(1.0 + x * x + y * y)); }

static double column_angle(const air_importance_camera *camera, size_t i, size_t j)
{
    const double x = (double)camera->tan_half[0], y = (double)camera->tan_half[1];
    const double x0 = x * (2.0 * (double)i / SIDE - 1.0), x1 = x0 + 2.0 * x / SIDE;
    const double y0 = y * (2.0 * (double)j / SIDE - 1.0), y1 = y0 + 2.0 * y / SIDE;
    return quadrant_angle(x1, y1) - quadrant_angle(x0, y1) - quadrant_angle(x1, y0) +
           quadrant_angle(x0, y0);
}

/* ---- propagation ---- */

static size_t rounded(size_t bytes) { return (bytes + LINE - 1) / LINE * LINE; }

static air_ordinates_cells cells_of(const importance_work *work)
{
    return (air_ordinates_cells){.size = {SIDE, SIDE, SIDE},
                                 .cell_m = 1.0f,
                                 .sigma_s = work->sigma_s,
                                 .sigma_a = work->sigma_a,
                                 .g = work->g,
                                 .entry = work->entry};
}

static air_ordinates_params params_of(void)
{
    air_ordinates_params params;
    air_ordinates_params_default(&params);
    params.steps = STEPS;
    return params;
}

size_t air_importance_scratch(void)
{
    const float none[1] = {0.0f};
    const air_ordinates_cells cells = {
        .size = {SIDE, SIDE, SIDE}, .cell_m = 1.0f, .sigma_s = none, .sigma_a = none, .g = none};
    const air_ordinates_params params = params_of();
    return rounded(sizeof(importance_work)) + air_ordinates_scratch(&cells, &params);
}

static air_status fill(air_context *context, const air_importance_camera *camera,
                       const air_importance_medium *medium, importance_work *work)
{
    for (size_t cell = 0; cell < ALL; cell++) {
        const float s = medium->sigma_s[cell], a = medium->sigma_a[cell], g = medium->g[cell];
        if (!(s >= 0.0f && s <= 1e30f && a >= 0.0f && a <= 1e30f && g > -1.0f && g < 1.0f)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "importance: cell (%zu, %zu, %zu) has sigma_s %g, sigma_a %g and g %g: "
                            "expected finite ones, >= 0, and -1 < g < 1",
                            cell % SIDE, cell / SIDE % SIDE, cell / SIDE / SIDE, (double)s,
                            (double)a, (double)g);
        }
        const double x = tangent(camera, 0, cell % SIDE);
        const double y = tangent(camera, 1, cell / SIDE % SIDE);
        const float length = (float)(slice_depth(camera) * sqrt(1.0 + x * x + y * y));
        work->sigma_s[cell] = float_min(s * length, 1e30f);
        work->sigma_a[cell] = float_min(a * length, 1e30f);
        work->sigma_t[cell] = s + a;
        work->g[cell] = g;
        work->cosine[cell] = 1.0f;
    }
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        work->entry[i] = (float)column_angle(camera, i % SIDE, i / SIDE);
    }
    return AIR_OK;
}

static void close_books(const importance_work *work, const air_ordinates_books *from,
                        air_importance_books *out)
{
    double all = 0.0;
    out->through = 0.0;
    for (size_t column = 0; column < SIDE * SIDE; column++) {
        double depth = 0.0;
        for (size_t k = 0; k < SIDE; k++) {
            const size_t cell = k * SIDE * SIDE + column;
            depth += (double)work->sigma_s[cell] + (double)work->sigma_a[cell];
        }
        out->through += (double)work->entry[column] * exp(-depth);
    }
    for (int face = 0; face < 6; face++) {
        all += from->out[face];
    }
    out->in = from->in;
    out->scattered = double_max(0.0, all - out->through);
    out->absorbed = from->absorbed;
    out->residual = from->residual;
}

/* ---- projection ---- */

static double hg(double g, double cosine)
{
    const double s = 1.0 + g * g - 2.0 * g * cosine;
    return (1.0 - g * g) / (4.0 * AIR_PI * s * sqrt(s));
}

/* The lobe that is q / (4 pi) straight ahead: (1 + b) / (1 - b)^2 = q. */
static double lobe_of_peak(double q)
{
    return 2.0 * (q - 1.0) / (2.0 * q + 1.0 + sqrt(8.0 * q + 1.0));
}

static importance_block block_of(const air_importance_camera *camera, const importance_work *work,
                                 size_t i, size_t j, size_t k)
{
    importance_block out = {.depth = (double)camera->near_m +
                                     ((double)k + 0.5) * BLOCK * slice_depth(camera)};
    const double x = (double)camera->tan_half[0] * ((2.0 * (double)i + 1.0) / BLOCKS - 1.0);
    const double y = (double)camera->tan_half[1] * ((2.0 * (double)j + 1.0) / BLOCKS - 1.0);
    const double ray[3] = {x, y, 1.0}, length = air_length3(ray);
    out.x = x * out.depth;
    out.y = y * out.depth;
    for (int axis = 0; axis < 3; axis++) {
        out.direction[axis] = ray[axis] / length;
    }
    for (size_t n = 0; n < BLOCK * BLOCK * BLOCK; n++) {
        const size_t cell =
            ((k * BLOCK + n / 4) * SIDE + j * BLOCK + n / 2 % 2) * SIDE + i * BLOCK + n % 2;
        const double g = (double)work->g[cell], sigma_s = (double)work->sigma_s[cell];
        const double beam = (double)work->beam[cell], fluence = (double)work->fluence[cell];
        const double rest = (double)work->seen[cell] - beam * hg(double_min(g, 0.995), 1.0);
        const double q = fluence > 0.0 ? double_max(0.0, 4.0 * AIR_PI * rest / fluence) : 1.0;
        out.power[0] += sigma_s * beam;
        out.power[1] += sigma_s * fluence;
        out.lobe[0] += sigma_s * beam * g;
        out.lobe[1] += sigma_s * fluence * lobe_of_peak(q);
    }
    /* wider by the directions within the block and within a texel: caps of their angles */
    const double narrow = 1.0 - 4.0 * (double)camera->tan_half[0] * (double)camera->tan_half[1] /
                                    (BLOCKS * BLOCKS * length * length * length) / (4.0 * AIR_PI);
    for (int n = 0; n < 2; n++) {
        out.lobe[n] =
            out.power[n] > 0.0 ? out.lobe[n] / out.power[n] * narrow * (1.0 - 1.0 / TEXELS) : 0.0;
    }
    return out;
}

/* What the ways out of a pyramid have in common. */
typedef struct importance_march {
    const float *sigma_t;
    float near, slices, across[2]; /* from depths and tangents to cells */
    float step;
} importance_march;

static importance_march march_of(const air_importance_camera *camera, const importance_work *work)
{
    const double corner[3] = {(double)camera->tan_half[0], (double)camera->tan_half[1], 1.0};
    const double side = 2.0 * (double)camera->far_m * air_length3(corner);
    return (importance_march){
        .sigma_t = work->sigma_t,
        .near = camera->near_m,
        .slices = (float)(1.0 / slice_depth(camera)),
        .across = {0.5f * SIDE / camera->tan_half[0], 0.5f * SIDE / camera->tan_half[1]},
        .step = (float)double_max(slice_depth(camera), side / MARCH)};
}

/* Transmittances from the block on along four directions to where the pyramid ends. */
static four transmittances(const importance_march *march, const importance_block *from, four x,
                           four y, four z)
{
    const four none = four_all(0.0f), side = four_all((float)SIDE), middle = four_all(0.5f * SIDE);
    four depth = none;
    four_ints under_way = {-1, -1, -1, -1};
    for (int n = 0; n < MARCH; n++) {
        const float s = ((float)n + 0.5f) * march->step;
        const four forward = (float)from->depth + s * z, scale = 1.0f / forward;
        const four k = (forward - march->near) * march->slices;
        const four i = ((float)from->x + s * x) * scale * march->across[0] + middle;
        const four j = ((float)from->y + s * y) * scale * march->across[1] + middle;
        under_way &= (forward > none) & (k >= none) & (k < side) & (i >= none) & (i < side) &
                     (j >= none) & (j < side) & (depth * march->step < 30.0f);
        if (!(under_way[0] | under_way[1] | under_way[2] | under_way[3])) {
            break;
        }
        const four_ints row = __builtin_convertvector(four_select(under_way, j, none), four_ints);
        const four_ints slice = __builtin_convertvector(four_select(under_way, k, none), four_ints);
        const four_ints column =
            __builtin_convertvector(four_select(under_way, i, none), four_ints);
        const four_ints at = (slice * SIDE + row) * SIDE + column;
        const float *const sigma_t = march->sigma_t;
        const four found = {sigma_t[at[0]], sigma_t[at[1]], sigma_t[at[2]], sigma_t[at[3]]};
        depth += four_select(under_way, found, none);
    }
    const four power = -depth * march->step;
    return (four){expf(power[0]), expf(power[1]), expf(power[2]), expf(power[3])};
}

static void set_texels(const air_importance_camera *camera, importance_work *work)
{
    const float *const axes[3] = {camera->right, camera->up, camera->forward};
    for (size_t t = 0; t < TEXELS; t++) {
        const double theta = AIR_PI * ((double)(t / WIDTH) + 0.5) / HEIGHT;
        const double phi = 2.0 * AIR_PI * (((double)(t % WIDTH) + 0.5) / WIDTH - 0.5);
        const double w[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)};
        for (int axis = 0; axis < 3; axis++) {
            double along[3];
            vec3_store64(along, vec3_load(axes[axis]));
            work->texel[axis][t] = (float)air_dot3(w, along);
        }
        work->map[t] = 0.0f;
    }
}

static void set_middles(importance_work *work)
{
    for (size_t m = 0; m < TEXELS / (COARSE * COARSE); m++) {
        const size_t across = WIDTH / COARSE, first = (m / across * WIDTH + m % across) * COARSE;
        float middle[3];
        air_vec3 sum = vec3_set1(0.0f);
        for (size_t n = 0; n < COARSE * COARSE; n++) {
            const size_t t = first + n / COARSE * WIDTH + n % COARSE;
            sum = vec3_add(sum, vec3(work->texel[0][t], work->texel[1][t], work->texel[2][t]));
        }
        vec3_store(middle, vec3_normalize(sum));
        for (int axis = 0; axis < 3; axis++) {
            work->middle[axis][m] = middle[axis];
        }
    }
}

/* In the middle of COARSE x COARSE texels, and for all of them; four of such at a time. */
static void leave(const importance_march *march, const importance_block *block, size_t band,
                  importance_work *work)
{
    for (size_t column = 0; column < WIDTH / COARSE; column += 4) {
        const size_t m = band * (WIDTH / COARSE) + column;
        const four left =
            transmittances(march, block, four_load(work->middle[0] + m),
                           four_load(work->middle[1] + m), four_load(work->middle[2] + m));
        for (size_t n = 0; n < 4 * COARSE * COARSE; n++) {
            const size_t row = n / (4 * COARSE), across = n % (4 * COARSE);
            work->left[band * BAND + row * WIDTH + column * COARSE + across] =
                left[across / COARSE];
        }
    }
}

/* Two lobes, as hg(), over a band's texels side by side. */
static void shine(const importance_block *block, size_t begin, importance_work *work)
{
    float a[2], b[2], c[2], direction[3];
    for (int n = 0; n < 2; n++) {
        const double g = block->lobe[n];
        a[n] = (float)(block->power[n] * (1.0 - g * g) / (4.0 * AIR_PI));
        b[n] = (float)(1.0 + g * g);
        c[n] = (float)(2.0 * g);
    }
    vec3_store(direction, vec3((float)block->direction[0], (float)block->direction[1],
                               (float)block->direction[2]));
    for (size_t t = begin; t < begin + BAND; t++) {
        const float cosine = direction[0] * work->texel[0][t] + direction[1] * work->texel[1][t] +
                             direction[2] * work->texel[2][t];
        const float s = b[0] - c[0] * cosine, r = b[1] - c[1] * cosine;
        work->map[t] += work->left[t] * (a[0] / (s * sqrtf(s)) + a[1] / (r * sqrtf(r)));
    }
}

static double texel_angle(size_t t)
{
    const double row = (double)(t / WIDTH);
    return 2.0 * AIR_PI / WIDTH * (cos(AIR_PI * row / HEIGHT) - cos(AIR_PI * (row + 1.0) / HEIGHT));
}

static double integral(const float *map)
{
    double sum = 0.0;
    for (size_t t = 0; t < TEXELS; t++) {
        sum += texel_angle(t) * (double)map[t];
    }
    return sum;
}

typedef struct importance_projection {
    importance_march march;
    importance_work *work;
} importance_projection;

/* Sums up what comes from all blocks, in their order. */
static void project_band(void *user, size_t band, size_t worker)
{
    const importance_projection *const self = user;
    (void)worker;
    for (size_t n = 0; n < BLOCKS * BLOCKS * BLOCKS; n++) {
        const importance_block *const block = &self->work->blocks[n];
        if (block->power[0] + block->power[1] > 0.0) {
            leave(&self->march, block, band, self->work);
            shine(block, band * BAND, self->work);
        }
    }
}

static void project(air_context *context, const air_importance_camera *camera,
                    importance_work *work, double scattered, float *out)
{
    importance_projection self = {march_of(camera, work), work};
    set_texels(camera, work);
    set_middles(work);
    for (size_t n = 0; n < BLOCKS * BLOCKS * BLOCKS; n++) {
        work->blocks[n] =
            block_of(camera, work, n % BLOCKS, n / BLOCKS % BLOCKS, n / BLOCKS / BLOCKS);
    }
    if (context != NULL) {
        air_parallel_for(context, TEXELS / BAND, project_band, &self);
    }
    for (size_t band = 0; context == NULL && band < TEXELS / BAND; band++) {
        project_band(&self, band, 0);
    }
    const double sum = integral(work->map), scale = sum > 0.0 ? scattered / sum : 0.0;
    for (size_t t = 0; t < TEXELS; t++) {
        out[t] = (float)(scale * (double)work->map[t]);
    }
}

air_status air_importance_propagate(air_context *context, const air_importance_camera *camera,
                                    const air_importance_medium *medium, void *scratch,
                                    float *out_map, air_importance_books *out_books)
{
    importance_work *const work = scratch;
    if (scratch == NULL || (uintptr_t)scratch % LINE != 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "importance: expected scratch aligned to %d bytes", LINE);
    }
    air_status status = check_camera(context, camera);
    status = status == AIR_OK ? fill(context, camera, medium, work) : status;
    if (status != AIR_OK) {
        return status;
    }
    const air_ordinates_cells cells = cells_of(work);
    const air_ordinates_params params = params_of();
    air_ordinates_books run_books;
    air_importance_books books;
    const air_ordinates_results results = {.fluence = work->fluence,
                                           .beam = work->beam,
                                           .view_cosine = work->cosine,
                                           .seen = work->seen,
                                           .books = &run_books};
    status = air_ordinates_run(context, &cells, &params, (char *)scratch + rounded(sizeof *work),
                               &results);
    if (status != AIR_OK) {
        return status;
    }
    close_books(work, &run_books, &books);
    project(context, camera, work, books.scattered, out_map);
    if (out_books != NULL) {
        *out_books = books;
    }
    return AIR_OK;
}

/* ---- maps ---- */

/* Beyond a pole lies the row itself, half a turn away. */
static double texel_at(const float *map, ptrdiff_t row, size_t column)
{
    const bool beyond = row < 0 || row >= HEIGHT;
    const size_t y = (size_t)(row < 0 ? 0 : beyond ? HEIGHT - 1 : row);
    return (double)map[y * WIDTH + (column + (beyond ? WIDTH / 2 : 0)) % WIDTH];
}

void air_importance_smooth(const float *map, float floor, float *out)
{
    const double tent[3] = {0.25, 0.5, 0.25};
    float smooth[TEXELS];
    for (size_t t = 0; t < TEXELS; t++) {
        double sum = 0.0;
        for (size_t n = 0; n < 9; n++) {
            sum += tent[n / 3] * tent[n % 3] *
                   texel_at(map, (ptrdiff_t)(t / WIDTH + n / 3) - 1, t % WIDTH + WIDTH + n % 3 - 1);
        }
        smooth[t] = (float)sum;
    }
    const double mean = integral(smooth) / (4.0 * AIR_PI);
    for (size_t t = 0; t < TEXELS; t++) {
        out[t] = mean > 0.0
                     ? (float)((1.0 - (double)floor) * (double)smooth[t] / mean + (double)floor)
                     : 1.0f;
    }
}

void air_importance_blend(const float *previous, const float *next, float keep, float *out)
{
    for (size_t t = 0; t < TEXELS; t++) {
        out[t] = keep * previous[t] + (1.0f - keep) * next[t];
    }
}

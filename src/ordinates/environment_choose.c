/* environment_choose.c: ordinates of a prepared map, see environment.h. */
#include <math.h>
#include <string.h>

#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"
#include "ordinates/environment.h"

void air_environment_map_default(air_environment_map *map)
{
    *map = (air_environment_map){.radiance = {1.0f, 1.0f, 1.0f}, .contrast = 2.0f / 3.0f};
}

void air_environment_choice_default(air_environment_choice *choice)
{
    *choice = (air_environment_choice){.count = 64,
                                       .form = AIR_ORDINATE_STRATUM,
                                       .lobe = AIR_ORDINATE_LOBE_MEAN,
                                       .beta = 1.5f,
                                       .to_world = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

/* ---- arguments ---- */

static bool is_rotation(const float m[9])
{
    const air_vec3 x = vec3(m[0], m[1], m[2]), y = vec3(m[3], m[4], m[5]),
                   z = vec3(m[6], m[7], m[8]);
    const air_vec3 gap = vec3_sub(vec3_cross(x, y), z);
    return fabsf(vec3_dot(x, x) - 1.0f) < 1e-3f && fabsf(vec3_dot(y, y) - 1.0f) < 1e-3f &&
           fabsf(vec3_dot(x, y)) < 1e-3f && vec3_dot(gap, gap) < 1e-6f;
}

static air_status check(air_context *context, const air_environment_choice *choice)
{
    if (choice->count - 1 >= AIR_ORDINATES_LIGHTS_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "environment ordinates: %zu are asked for: expected 1 to %d", choice->count,
                        AIR_ORDINATES_LIGHTS_MAX);
    }
    if ((unsigned)choice->form > AIR_ORDINATE_POINT ||
        (unsigned)choice->lobe > AIR_ORDINATE_LOBE_BEAM) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "environment ordinates: form %d or lobe %d is not in its enumeration",
                        (int)choice->form, (int)choice->lobe);
    }
    if (!(choice->beta > 0.0f && choice->beta <= 1e6f)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "environment ordinates: beta is %g: expected above 0, up to 1e6",
                        (double)choice->beta);
    }
    if (!is_rotation(choice->to_world)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "environment ordinates: to_world is not a rotation: expected orthonormal "
                        "rows, right-handed");
    }
    for (size_t i = 0; choice->importance != NULL && i < AIR_IMPORTANCE_TEXELS; i++) {
        if (!(choice->importance[i] >= 0.0f && choice->importance[i] <= 1e30f)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "environment ordinates: importance texel (%zu, %zu) is %g: expected 0 "
                            "to 1e30",
                            i % AIR_IMPORTANCE_WIDTH, i / AIR_IMPORTANCE_WIDTH,
                            (double)choice->importance[i]);
        }
    }
    return AIR_OK;
}

/* ---- importance ---- */

/* Bilinear between centres, around the horizon too; beyond the first and last row it holds. */
static double importance_at(const float *map, air_vec3 w)
{
    const float level = sqrtf(w.x * w.x + w.z * w.z);
    const float u = 0.5f + atan2f(w.x, -w.z) * (0.5f / AIR_PI_F);
    const float v = atan2f(level, w.y) * (1.0f / AIR_PI_F);
    const float x = float_max(u * AIR_IMPORTANCE_WIDTH - 0.5f + AIR_IMPORTANCE_WIDTH, 0.0f);
    const float y =
        float_min(float_max(v * AIR_IMPORTANCE_HEIGHT - 0.5f, 0.0f), AIR_IMPORTANCE_HEIGHT - 1);
    const size_t left = (size_t)x, upper = (size_t)y;
    const size_t lower = upper + 1 < AIR_IMPORTANCE_HEIGHT ? upper + 1 : upper;
    const size_t columns[2] = {left % AIR_IMPORTANCE_WIDTH, (left + 1) % AIR_IMPORTANCE_WIDTH};
    const double s = (double)x - (double)left, t = (double)y - (double)upper;
    const float *top = map + upper * AIR_IMPORTANCE_WIDTH;
    const float *bottom = map + lower * AIR_IMPORTANCE_WIDTH;
    return (1.0 - t) * ((1.0 - s) * (double)top[columns[0]] + s * (double)top[columns[1]]) +
           t * ((1.0 - s) * (double)bottom[columns[0]] + s * (double)bottom[columns[1]]);
}

static air_vec3 rotate(const float m[9], air_vec3 v)
{
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z);
}

/* What the cells weigh in a choice. */
typedef struct cell_weights {
    double factor[ENVIRONMENT_CELLS];     /* importance^contrast */
    double before[ENVIRONMENT_CELLS + 1]; /* sums of weight times factor */
} cell_weights;

static void weigh(const air_environment_ordinates *self, const air_environment_choice *choice,
                  const float *importance, cell_weights *out)
{
    out->before[0] = 0.0;
    for (size_t i = 0; i < ENVIRONMENT_CELLS; i++) {
        const double weight = self->cell_sums[i + 1].weight - self->cell_sums[i].weight;
        out->factor[i] = 1.0;
        if (importance != NULL && weight > 0.0) {
            const air_vec3 w = rotate(choice->to_world, vec3_load(self->cell_direction[i]));
            out->factor[i] = pow(importance_at(importance, w), (double)self->map.contrast);
        }
        out->before[i + 1] = out->before[i] + weight * out->factor[i];
    }
}

/* ---- cuts ---- */

typedef struct cut {
    environment_sums before; /* the cut */
    size_t element;          /* in which it lies */
} cut;

/* Where the cells' weights reach target, >= 0; *cell, where to look first, moves on. Elements are
 * added one by one as when the sums were made, so that no sum falls from cut to cut. */
static cut cut_at(const air_environment_ordinates *self, const cell_weights *weights, double target,
                  size_t *cell)
{
    while (*cell < ENVIRONMENT_CELLS && weights->before[*cell + 1] <= target) {
        (*cell)++;
    }
    cut out = {self->runs[self->run_count], self->order[self->count - 1]};
    if (*cell == ENVIRONMENT_CELLS) {
        return out;
    }
    const double goal =
        double_min(self->cell_sums[*cell + 1].weight,
                   self->cell_sums[*cell].weight +
                       double_max(0.0, target - weights->before[*cell]) / weights->factor[*cell]);
    size_t low = self->cell_first[*cell] / ENVIRONMENT_RUN;
    size_t high = (self->cell_first[*cell + 1] - 1) / ENVIRONMENT_RUN;
    while (low < high) { /* the last run that begins at the goal or before */
        const size_t middle = (low + high + 1) / 2;
        if (self->runs[middle].weight <= goal) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    out.before = self->runs[low];
    for (size_t i = low * ENVIRONMENT_RUN; i < self->cell_first[*cell + 1]; i++) {
        out.element = self->order[i];
        const environment_sums element = environment_element(self, out.element);
        if (out.before.weight + element.weight > goal) {
            const double part = (goal - out.before.weight) / element.weight;
            environment_sums_add(&out.before, double_min(double_max(part, 0.0), 1.0), &element);
            break;
        }
        environment_sums_add(&out.before, 1.0, &element);
    }
    return out;
}

/* ---- ordinates ---- */

/* Of the light that comes from w, a vector of any length, in the map's space. */
static void set_travel(const air_environment_choice *choice, const double w[3], double length,
                       air_ordinate *out)
{
    const float *m = choice->to_world;
    for (int k = 0; k < 3; k++) {
        out->travel[k] =
            -((double)m[3 * k] * w[0] + (double)m[3 * k + 1] * w[1] + (double)m[3 * k + 2] * w[2]) /
            length;
    }
    const double unit = air_length3(out->travel); /* the matrix is as good as floats */
    for (int k = 0; k < 3; k++) {
        out->travel[k] /= unit;
    }
}

static double narrowed(const air_environment_choice *choice, double lobe)
{
    if (choice->lobe == AIR_ORDINATE_LOBE_BEAM) {
        return 1.0;
    }
    return pow(double_min(double_max(lobe, 0.0), 1.0), (double)choice->beta);
}

static void stratum(const air_environment_ordinates *self, const air_environment_choice *choice,
                    const environment_sums *a, const environment_sums *b, air_ordinate *out)
{
    const double up[3] = {0.0, 1.0, 0.0};
    double moment[3];
    for (int k = 0; k < 3; k++) {
        out->irradiance[k] = double_max(0.0, b->rgb[k] - a->rgb[k]);
        moment[k] = b->moment[k] - a->moment[k];
    }
    out->solid_angle = b->solid_angle - a->solid_angle;
    const double flux = self->black ? out->solid_angle : environment_luminance(out->irradiance);
    const double length = air_length3(moment);
    const bool none = !(length > 1e-9 * flux); /* cancelled */
    set_travel(choice, none ? up : moment, none ? 1.0 : length, out);
    out->lobe = narrowed(choice, choice->lobe == AIR_ORDINATE_LOBE_ANGLE
                                     ? 1.0 - out->solid_angle / (4.0 * AIR_PI)
                                 : none ? 0.0
                                        : length / flux);
}

/* The sample: density per solid angle is weight / all of it; of a cell's share, its importance. */
static void point(const air_environment_ordinates *self, const air_environment_choice *choice,
                  const cell_weights *weights, size_t n, size_t *cell, air_ordinate *out)
{
    const double total = weights->before[ENVIRONMENT_CELLS];
    const cut at = cut_at(self, weights, total * ((double)n + 0.5) / (double)choice->count, cell);
    const size_t here = *cell < ENVIRONMENT_CELLS ? *cell : ENVIRONMENT_CELLS - 1;
    const environment_sums element = environment_element(self, at.element);
    const double weight = element.weight / element.solid_angle * weights->factor[here];
    const double angle = weight > 0.0 ? total / weight / (double)choice->count : 0.0; /* 1/(N p) */
    double w[3];
    environment_radiance(self, at.element, out->irradiance);
    for (int k = 0; k < 3; k++) {
        out->irradiance[k] *= angle;
    }
    environment_direction(self, at.element, w);
    set_travel(choice, w, air_length3(w), out);
    out->solid_angle = angle;
    if (choice->lobe == AIR_ORDINATE_LOBE_ANGLE) {
        out->lobe = narrowed(choice, 1.0 - angle / (4.0 * AIR_PI));
    }
}

air_status air_environment_ordinates_choose(air_context *context,
                                            const air_environment_ordinates *self,
                                            const air_environment_choice *choice, air_ordinate *out)
{
    const air_status status = check(context, choice);
    if (status != AIR_OK) {
        return status;
    }
    cell_weights weights;
    weigh(self, choice, choice->importance, &weights);
    if (!(weights.before[ENVIRONMENT_CELLS] > 0.0)) {
        weigh(self, choice, NULL, &weights);
    }
    const double total = weights.before[ENVIRONMENT_CELLS];
    environment_sums before = {.weight = 0.0};
    size_t cell = 0, point_cell = 0;
    for (size_t n = 0; n < choice->count; n++) {
        environment_sums after = self->runs[self->run_count];
        if (n + 1 < choice->count) {
            const double target = total * (double)(n + 1) / (double)choice->count;
            after = cut_at(self, &weights, target, &cell).before;
        }
        stratum(self, choice, &before, &after, &out[n]);
        if (choice->form == AIR_ORDINATE_POINT) {
            point(self, choice, &weights, n, &point_cell, &out[n]);
        }
        before = after;
    }
    return AIR_OK;
}

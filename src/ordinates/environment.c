/* environment.c: maps prepared, see environment.h. */
#include "ordinates/environment.h"

#include <math.h>
#include <string.h>

#include "core/host.h"
#include "core/triple.h"
#include "ordinates/sphere_curve.h"

enum { LEAST_COLUMNS = 512, LEAST_ROWS = 256 }; /* of elements */

/* ---- elements ---- */

void environment_radiance(const air_environment_ordinates *self, size_t element, double out[3])
{
    const air_environment_map *map = &self->map;
    const size_t x = element % self->columns / self->split[0];
    const size_t y = element / self->columns / self->split[1];
    const float *pixel =
        map->pixels != NULL ? map->pixels + y * map->row_stride + x * map->pixel_stride : NULL;
    for (int k = 0; k < 3; k++) {
        out[k] = (double)map->radiance[k] * (pixel != NULL ? (double)pixel[k] : 1.0);
    }
}

void environment_direction(const air_environment_ordinates *self, size_t element, double out[3])
{
    const double *row = self->row[element / self->columns];
    const double *column = self->column[element % self->columns];
    out[0] = row[2] * column[0];
    out[1] = row[1];
    out[2] = row[2] * column[1];
}

environment_sums environment_element(const air_environment_ordinates *self, size_t element)
{
    environment_sums out = {.solid_angle = self->row[element / self->columns][0]};
    double rgb[3], direction[3];
    environment_radiance(self, element, rgb);
    environment_direction(self, element, direction);
    const double level = self->black ? 1.0 : environment_luminance(rgb);
    out.weight = out.solid_angle * pow(level, (double)self->map.contrast);
    for (int k = 0; k < 3; k++) {
        out.rgb[k] = out.solid_angle * rgb[k];
        out.moment[k] = level * direction[k];
    }
    return out;
}

/* ---- preparation ---- */

static air_status check_map(air_context *context, const air_environment_map *map)
{
    for (int k = 0; k < 3; k++) {
        if (!(map->radiance[k] >= 0.0f && map->radiance[k] <= 1e30f)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "environment ordinates: radiance[%d] is %g: expected 0 to 1e30", k,
                            (double)map->radiance[k]);
        }
    }
    if (!(map->contrast > 0.0f && map->contrast <= 1.0f)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "environment ordinates: contrast is %g: expected above 0, up to 1",
                        (double)map->contrast);
    }
    if (map->pixels == NULL) {
        return AIR_OK;
    }
    if (map->width - 1 >= 65535 || map->height - 1 >= 65535) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "environment ordinates: the map has %zu x %zu pixels: expected 1 to 65535",
                        map->width, map->height);
    }
    if (map->pixel_stride < 3 || map->pixel_stride > SIZE_MAX / map->width ||
        map->row_stride < map->width * map->pixel_stride ||
        map->row_stride > SIZE_MAX / map->height) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "environment ordinates: strides are %zu and %zu floats: expected at least 3 "
            "and the width times that",
            map->pixel_stride, map->row_stride);
    }
    return AIR_OK;
}

static air_status check_pixels(air_context *context, const air_environment_map *map)
{
    for (size_t y = 0; map->pixels != NULL && y < map->height; y++) {
        for (size_t x = 0; x < map->width; x++) {
            const float *p = map->pixels + y * map->row_stride + x * map->pixel_stride;
            for (int k = 0; k < 3; k++) {
                if (!(p[k] >= 0.0f && p[k] <= 1e30f)) {
                    return air_fail(context, AIR_ERROR_ARGUMENT,
                                    "environment ordinates: pixel (%zu, %zu) of the map is (%g, "
                                    "%g, %g): expected numbers from 0 to 1e30",
                                    x, y, (double)p[0], (double)p[1], (double)p[2]);
                }
            }
        }
    }
    return AIR_OK;
}

static size_t split_into(size_t pixels, size_t least) { return (least + pixels - 1) / pixels; }

static air_status allocate(air_environment_ordinates *self)
{
    self->run_count = (self->count + ENVIRONMENT_RUN - 1) / ENVIRONMENT_RUN;
    self->order = air_allocate(self->context, self->count, sizeof *self->order);
    self->row = air_allocate(self->context, self->rows, sizeof *self->row);
    self->column = air_allocate(self->context, self->columns, sizeof *self->column);
    self->runs = air_allocate(self->context, self->run_count + 1, sizeof *self->runs);
    return self->order != NULL && self->row != NULL && self->column != NULL && self->runs != NULL
               ? AIR_OK
               : air_fail_memory(self->context, "environment ordinates");
}

/* Integrals over theta from a to b and phi from c to d: of the direction, (sin theta sin phi, cos
 * theta, -sin theta cos phi), with sin theta for the measure. Differences as products, so that
 * narrow elements keep their digits. */
static void integrate_elements(air_environment_ordinates *self)
{
    const double high = AIR_PI / (double)self->rows, wide = 2.0 * AIR_PI / (double)self->columns;
    for (size_t j = 0; j < self->rows; j++) {
        const double middle = ((double)j + 0.5) * high, cap = 2.0 * sin(0.5 * high);
        self->row[j][0] = wide * sin(middle) * cap;
        self->row[j][1] = wide * 0.5 * sin(2.0 * middle) * sin(high);
        self->row[j][2] = 0.5 * (high - cos(2.0 * middle) * sin(high));
    }
    for (size_t i = 0; i < self->columns; i++) {
        const double middle = (((double)i + 0.5) / (double)self->columns - 0.5) * 2.0 * AIR_PI;
        const double chord = 2.0 * sin(0.5 * wide);
        self->column[i][0] = sin(middle) * chord;
        self->column[i][1] = -cos(middle) * chord;
    }
}

/* Each element's place on the curve, above its number. */
static void place_elements(const air_environment_ordinates *self, uint64_t *out)
{
    for (size_t j = 0; j < self->rows; j++) {
        const double up = cos(((double)j + 0.5) * AIR_PI / (double)self->rows);
        for (size_t i = 0; i < self->columns; i++) {
            const double turns = 4.0 * ((double)i + 0.5) / (double)self->columns;
            const size_t element = j * self->columns + i;
            out[element] = (uint64_t)sphere_curve_place(up, turns) << 32 | element;
        }
    }
}

/* Sorts the elements by their place on the curve, 11 bits after 11, least first; what is equal
 * stays in order. pairs: 2 count. */
static void sort_elements(air_environment_ordinates *self, uint64_t *pairs)
{
    enum { DIGIT = 11, DIGITS = 1 << DIGIT };
    uint64_t *from = pairs, *to = pairs + self->count;
    place_elements(self, from);
    for (int shift = 32; shift < 64; shift += DIGIT) {
        size_t first[DIGITS + 1] = {0};
        for (size_t i = 0; i < self->count; i++) {
            first[(from[i] >> shift) % DIGITS + 1]++;
        }
        for (int d = 0; d < DIGITS; d++) {
            first[d + 1] += first[d];
        }
        for (size_t i = 0; i < self->count; i++) {
            to[first[(from[i] >> shift) % DIGITS]++] = from[i];
        }
        uint64_t *const swap = from;
        from = to;
        to = swap;
    }
    size_t cell = 0;
    for (size_t i = 0; i < self->count; i++) {
        for (const size_t here = (size_t)(from[i] >> (64 - ENVIRONMENT_CELL_BITS)); cell <= here;
             cell++) {
            self->cell_first[cell] = i;
        }
        self->order[i] = (uint32_t)from[i];
    }
    for (; cell <= ENVIRONMENT_CELLS; cell++) {
        self->cell_first[cell] = self->count;
    }
}

/* In the order in which cut() adds again, so that sums at cuts never decrease. */
static void sum_along(air_environment_ordinates *self)
{
    environment_sums sum = {.weight = 0.0};
    size_t cell = 0;
    for (size_t i = 0; i < self->count; i++) {
        if (i % ENVIRONMENT_RUN == 0) {
            self->runs[i / ENVIRONMENT_RUN] = sum;
        }
        for (; self->cell_first[cell] == i; cell++) {
            self->cell_sums[cell] = sum;
        }
        const environment_sums element = environment_element(self, self->order[i]);
        environment_sums_add(&sum, 1.0, &element);
    }
    self->runs[self->run_count] = sum;
    for (; cell <= ENVIRONMENT_CELLS; cell++) {
        self->cell_sums[cell] = sum;
    }
}

static void point_cells(air_environment_ordinates *self)
{
    for (size_t cell = 0; cell < ENVIRONMENT_CELLS; cell++) {
        double sum[3] = {0.0, 0.0, 0.0}, direction[3];
        for (size_t i = self->cell_first[cell]; i < self->cell_first[cell + 1]; i++) {
            environment_direction(self, self->order[i], direction);
            air_along3(sum, 1.0, direction, sum);
        }
        const double length = air_length3(sum);
        for (int k = 0; k < 3 && length > 0.0; k++) {
            self->cell_direction[cell][k] = (float)(sum[k] / length);
        }
    }
}

/* Each pixel counts: a map may be black but for one. */
static bool is_black(const air_environment_ordinates *self)
{
    for (size_t i = 0; i < self->count; i++) {
        double rgb[3];
        environment_radiance(self, i, rgb);
        if (environment_luminance(rgb) > 0.0) {
            return false;
        }
    }
    return true;
}

static air_status prepare(air_environment_ordinates *self)
{
    const bool pixels = self->map.pixels != NULL;
    const size_t width = pixels ? self->map.width : 1, height = pixels ? self->map.height : 1;
    self->split[0] = split_into(width, LEAST_COLUMNS);
    self->split[1] = split_into(height, LEAST_ROWS);
    self->columns = width * self->split[0];
    self->rows = height * self->split[1];
    self->count = self->columns * self->rows;
    const air_status status = allocate(self);
    if (status != AIR_OK) {
        return status;
    }
    uint64_t *const pairs = air_allocate(self->context, 2 * self->count, sizeof *pairs);
    if (pairs == NULL) {
        return air_fail_memory(self->context, "environment ordinates");
    }
    integrate_elements(self);
    sort_elements(self, pairs);
    air_free(self->context, pairs);
    self->black = is_black(self);
    sum_along(self);
    point_cells(self);
    return AIR_OK;
}

air_status air_environment_ordinates_create(air_context *context, const air_environment_map *map,
                                            air_environment_ordinates **out)
{
    *out = NULL;
    air_status status = check_map(context, map);
    status = status == AIR_OK ? check_pixels(context, map) : status;
    if (status != AIR_OK) {
        return status;
    }
    air_environment_ordinates *const self = air_allocate(context, 1, sizeof *self);
    if (self == NULL) {
        return air_fail_memory(context, "environment ordinates");
    }
    self->context = context;
    self->map = *map;
    status = prepare(self);
    if (status != AIR_OK) {
        air_environment_ordinates_destroy(self);
        return status;
    }
    *out = self;
    return AIR_OK;
}

void air_environment_ordinates_destroy(air_environment_ordinates *self)
{
    if (self != NULL) {
        air_free(self->context, self->runs);
        air_free(self->context, self->column);
        air_free(self->context, self->row);
        air_free(self->context, self->order);
        air_free(self->context, self);
    }
}

void air_environment_ordinates_integral(const air_environment_ordinates *self, double out[3])
{
    memcpy(out, self->runs[self->run_count].rgb, 3 * sizeof *out);
}

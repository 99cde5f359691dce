/* environment_fixture.h: skies for tests of their ordinates. */
#ifndef AIR_TESTS_ENVIRONMENT_FIXTURE_H
#define AIR_TESTS_ENVIRONMENT_FIXTURE_H

#include <math.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "cmocka_test.h"
#include "core/vec.h"

enum { MOST = AIR_ORDINATES_LIGHTS_MAX };

static inline int set_up(void **state)
{
    air_context *context = NULL;
    const air_status status = air_context_create(NULL, &context);
    *state = context;
    return status == AIR_OK ? 0 : -1;
}

static inline int tear_down(void **state)
{
    air_context_destroy(*state);
    return 0;
}

static inline air_environment_map map_of(const float *pixels, size_t width, size_t height)
{
    air_environment_map map;
    air_environment_map_default(&map);
    map.pixels = pixels;
    map.width = width;
    map.height = height;
    map.pixel_stride = 3;
    map.row_stride = 3 * width;
    return map;
}

static inline air_environment_ordinates *prepare(air_context *context,
                                                 const air_environment_map *map)
{
    air_environment_ordinates *self = NULL;
    assert_int_equal(air_environment_ordinates_create(context, map, &self), AIR_OK);
    return self;
}

/* By the default but for a beta of 1. */
static inline void choose(air_context *context, const air_environment_ordinates *self, size_t count,
                          const float *importance, air_ordinate *out)
{
    air_environment_choice choice;
    air_environment_choice_default(&choice);
    choice.count = count;
    choice.importance = importance;
    choice.beta = 1.0f;
    assert_int_equal(air_environment_ordinates_choose(context, self, &choice, out), AIR_OK);
}

/* Smooth, coloured, with a small bright sun and a black part. */
static inline void paint(float *pixels, size_t width, size_t height, size_t sun_column)
{
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            float *p = pixels + 3 * (y * width + x);
            const double phi = 2.0 * AIR_PI * ((double)x - (double)sun_column) / (double)width;
            const double theta = AIR_PI * ((double)y + 0.5) / (double)height;
            const bool sun = x == sun_column && y == height / 3;
            const bool dark = y >= height * 3 / 4;
            p[0] = dark ? 0.0f : sun ? 20000.0f : (float)(1.0 + 0.5 * cos(phi));
            p[1] = dark ? 0.0f : sun ? 18000.0f : (float)(1.0 + 0.5 * sin(theta));
            p[2] = dark ? 0.0f : sun ? 15000.0f : 2.0f;
        }
    }
}

enum { WIDTH = 128, HEIGHT = 64 };

#endif

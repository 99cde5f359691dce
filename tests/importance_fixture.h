/* importance_fixture.h: a camera and media for tests of importance. */
#ifndef AIR_TESTS_IMPORTANCE_FIXTURE_H
#define AIR_TESTS_IMPORTANCE_FIXTURE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "cmocka_test.h"
#include "core/vec.h"

enum {
    SIDE = AIR_IMPORTANCE_CELLS,
    ALL = AIR_IMPORTANCE_CELLS_ALL,
    TEXELS = AIR_IMPORTANCE_TEXELS
};

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

/* Looks along +X, a little down; 60 by 45 degrees; medium from 2 to 4 m. */
static inline air_importance_camera camera_of(void)
{
    const float tilt = 0.3f;
    return (air_importance_camera){.position = {1.0f, 2.0f, 3.0f},
                                   .right = {0.0f, 0.0f, 1.0f},
                                   .up = {sinf(tilt), cosf(tilt), 0.0f},
                                   .forward = {cosf(tilt), -sinf(tilt), 0.0f},
                                   .tan_half = {0.577f, 0.414f},
                                   .near_m = 2.0f,
                                   .far_m = 4.0f};
}

typedef struct medium {
    float sigma_s[ALL], sigma_a[ALL], g[ALL];
} medium;

static inline void fill(medium *m, float sigma_s, float sigma_a, float g)
{
    for (size_t i = 0; i < ALL; i++) {
        m->sigma_s[i] = sigma_s;
        m->sigma_a[i] = sigma_a;
        m->g[i] = g;
    }
}

/* A dense ball to the right, thin elsewhere, and some that absorbs below. */
static inline void fill_unevenly(void *context, const air_importance_camera *camera, medium *m)
{
    static float points[3 * ALL];
    assert_int_equal(air_importance_points(context, camera, points), AIR_OK);
    for (size_t i = 0; i < ALL; i++) {
        double from[3], along = 0.0, right = 0.0;
        for (int k = 0; k < 3; k++) {
            from[k] = (double)points[3 * i + (size_t)k] - (double)camera->position[k];
            along += from[k] * (double)camera->forward[k];
            right += from[k] * (double)camera->right[k];
        }
        const bool ball = (along - 3.0) * (along - 3.0) + (right - 0.6) * (right - 0.6) < 0.36;
        m->sigma_s[i] = ball ? 4.0f : 0.5f;
        m->sigma_a[i] = from[1] < -0.8 ? 0.5f : 0.0f;
        m->g[i] = ball ? 0.6f : 0.85f;
    }
}

static inline void propagate(void *context, const air_importance_camera *camera, const medium *m,
                             float *map, air_importance_books *books)
{
    void *scratch = NULL;
    const air_importance_medium arrays = {m->sigma_s, m->sigma_a, m->g};
    assert_int_equal(posix_memalign(&scratch, 64, air_importance_scratch()), 0);
    assert_int_equal(air_importance_propagate(context, camera, &arrays, scratch, map, books),
                     AIR_OK);
    free(scratch);
}

static inline double texel_angle(size_t t)
{
    const double y = (double)(t / AIR_IMPORTANCE_WIDTH), h = AIR_PI / AIR_IMPORTANCE_HEIGHT;
    return 2.0 * AIR_PI / AIR_IMPORTANCE_WIDTH * (cos(y * h) - cos((y + 1.0) * h));
}

static inline void texel_direction(size_t t, double out[3])
{
    const double theta =
        AIR_PI * ((double)(t / AIR_IMPORTANCE_WIDTH) + 0.5) / AIR_IMPORTANCE_HEIGHT;
    const double phi =
        2.0 * AIR_PI * (((double)(t % AIR_IMPORTANCE_WIDTH) + 0.5) / AIR_IMPORTANCE_WIDTH - 0.5);
    out[0] = sin(theta) * sin(phi);
    out[1] = cos(theta);
    out[2] = -sin(theta) * cos(phi);
}

static inline double integral(const float *map)
{
    double sum = 0.0;
    for (size_t t = 0; t < TEXELS; t++) {
        sum += texel_angle(t) * (double)map[t];
    }
    return sum;
}

static inline air_importance_camera turned_camera(int view)
{
    const float turn = AIR_PI_F * (float)view / 6.0f;
    const float tilt = view % 2 ? 0.4f : -0.3f, c = cosf(tilt), s = sinf(tilt);
    air_importance_camera camera = camera_of();
    vec3_store(camera.right, vec3(cosf(turn), 0.0f, sinf(turn)));
    vec3_store(camera.forward, vec3(c * sinf(turn), -s, -c * cosf(turn)));
    vec3_store(camera.up, vec3(s * sinf(turn), c, -s * cosf(turn)));
    return camera;
}

/* The cell that p, from the camera, lies in, or -1. */
static inline ptrdiff_t cell_at(const air_importance_camera *camera, air_vec3 p)
{
    const float z = vec3_dot(p, vec3_load(camera->forward));
    const float k = (z - camera->near_m) / (camera->far_m - camera->near_m) * SIDE;
    const float i =
        (vec3_dot(p, vec3_load(camera->right)) / (z * camera->tan_half[0]) + 1.0f) * 0.5f * SIDE;
    const float j =
        (vec3_dot(p, vec3_load(camera->up)) / (z * camera->tan_half[1]) + 1.0f) * 0.5f * SIDE;
    const bool inside = k >= 0.0f && k < SIDE && i >= 0.0f && i < SIDE && j >= 0.0f && j < SIDE;
    return inside ? ((ptrdiff_t)k * SIDE + (ptrdiff_t)j) * SIDE + (ptrdiff_t)i : -1;
}

#endif

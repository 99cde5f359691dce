/* picture_fixture.h: small pictures of test scenes, and whether two have the same expectation. */
#ifndef AIR_TESTS_PICTURE_FIXTURE_H
#define AIR_TESTS_PICTURE_FIXTURE_H

#include <stdio.h>
#include <string.h>

#include "airlight/airlight.h"
#include "cmocka_test.h"

enum { WIDTH = 24, HEIGHT = 16, REPLICATES = 16 };

typedef struct messages {
    char last_warning[512];
    size_t warnings;
} messages;

static inline void keep(void *user, air_message_level level, const char *text)
{
    messages *m = user;
    if (level == AIR_MESSAGE_WARNING) {
        m->warnings++;
        snprintf(m->last_warning, sizeof m->last_warning, "%s", text);
    }
}

static inline air_context *make_context(size_t threads, messages *m)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.thread_count = threads;
    if (m != NULL) {
        memset(m, 0, sizeof *m);
        params.message = keep;
        params.message_user = m;
    }
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static inline air_render_params picture(const char *methods, uint32_t samples)
{
    air_render_params params;
    air_render_params_default(&params);
    params.width = WIDTH;
    params.height = HEIGHT;
    params.sample_end = samples;
    params.max_depth = 1;
    params.methods = methods;
    params.layers = true;
    return params;
}

/* Visible shares of lamps are left as they were sampled. */
static inline air_image *render(air_context *context, const air_snapshot *snapshot,
                                const air_render_params *params)
{
    air_film *film;
    air_image *image;
    assert_int_equal(air_render(context, snapshot, params, &film), AIR_OK);
    air_resolve_params resolve;
    air_resolve_params_default(&resolve);
    resolve.smooth = false;
    assert_int_equal(air_film_resolve(film, &resolve, &image), AIR_OK);
    air_film_destroy(film);
    return image;
}

/* Blocks of 4 x 4 pixels, 3 channels, 24 blocks: sidak_p is the chance that the largest deviation
 * is as large or larger; below 1e-4 once in 10,000 runs of a right program. */
static inline void assert_same_expectation(air_context *context, const air_image *a,
                                           const air_image *b, int scene, const char *methods)
{
    air_ztest test;
    assert_int_equal(air_image_ztest(context, a, b, a, b, 4, REPLICATES - 1, &test), AIR_OK);
    assert_true(test.test_count > 0);
    if (!(test.sidak_p > 1e-4) || !(test.mean_p > 1e-4)) {
        fail_msg("scene %d, %s: largest deviation p = %g, mean p = %g (z %g)", scene, methods,
                 test.sidak_p, test.mean_p, test.mean_z);
    }
}

#endif

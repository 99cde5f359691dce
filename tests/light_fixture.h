/* light_fixture.h: a context that keeps its last message, and light tables made from descriptions.
 */
#ifndef AIR_TESTS_LIGHT_FIXTURE_H
#define AIR_TESTS_LIGHT_FIXTURE_H

#include <stdio.h>
#include <string.h>

#include "cmocka_test.h"
#include "scene/lights/light_build.h"

static inline int make_context(void **state)
{
    air_context *context = NULL;
    air_context_params params;
    air_context_params_default(&params);
    params.thread_count = 2;
    const air_status status = air_context_create(&params, &context);
    *state = context;
    return status == AIR_OK ? 0 : -1;
}

static inline int destroy_context(void **state)
{
    air_context_destroy(*state);
    return 0;
}

/* The table of lights without meshes, in a scene of radius 1 around the origin. */
static inline air_light_table table_of(air_context *context, const air_light_source *sources,
                                       size_t count)
{
    const float low[3] = {-0.577350269f, -0.577350269f, -0.577350269f};
    const float high[3] = {0.577350269f, 0.577350269f, 0.577350269f};
    air_light_table table;
    assert_int_equal(
        air_light_table_build(context, sources, count, NULL, 0, NULL, low, high, &table, NULL),
        AIR_OK);
    return table;
}

static inline air_light_table table_of_one(air_context *context, const air_light_desc *desc,
                                           const struct air_texture *image)
{
    const air_light_source source = {desc, image};
    assert_int_equal(air_light_check(context, desc), AIR_OK);
    return table_of(context, &source, 1);
}

#endif

/* ray_tracer.h: the default ray backend with what it was built from. */
#ifndef AIR_TESTS_RAY_TRACER_H
#define AIR_TESTS_RAY_TRACER_H

#include "cmocka_test.h"
#include "core/host.h"
#include "core/vec.h"

typedef struct ray_tracer {
    air_context *context;
    air_ray_backend backend;
    void *accelerator;
} ray_tracer;

/* params NULL: the defaults. */
static inline ray_tracer ray_tracer_build(const air_context_params *params,
                                          const air_ray_mesh *meshes, size_t count)
{
    ray_tracer self = {0};
    assert_int_equal(air_context_create(params, &self.context), AIR_OK);
    self.backend = *air_context_ray_backend(self.context);
    assert_int_equal(
        self.backend.build(self.backend.user, self.context, meshes, count, &self.accelerator),
        AIR_OK);
    return self;
}

static inline void ray_tracer_finish(ray_tracer *self)
{
    self->backend.destroy(self->accelerator);
    air_context_destroy(self->context);
}

static inline air_ray ray_tracer_ray(air_vec3 origin, air_vec3 dir)
{
    air_ray ray = {.tmin = 0.0f, .tmax = INFINITY, .mask = UINT32_MAX};
    vec3_store(ray.origin, origin);
    vec3_store(ray.dir, dir);
    return ray;
}

#endif

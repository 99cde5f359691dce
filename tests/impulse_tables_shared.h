/* impulse_tables_shared.h: a context and tables that the tests of one program share. */
#ifndef AIR_TESTS_IMPULSE_TABLES_SHARED_H
#define AIR_TESTS_IMPULSE_TABLES_SHARED_H

#include <math.h>

#include "airlight/impulse.h"
#include "cmocka_test.h"
#include "core/random.h"

typedef struct impulse_shared {
    air_context *context;
    air_impulse_tables *tables;
} impulse_shared;

static inline void shared_make(impulse_shared *self, const air_impulse_params *params)
{
    assert_int_equal(air_context_create(NULL, &self->context), AIR_OK);
    assert_int_equal(air_impulse_tables_create(self->context, params, &self->tables), AIR_OK);
}

static inline void shared_destroy(impulse_shared *self)
{
    air_impulse_tables_destroy(self->tables);
    air_context_destroy(self->context);
}

static inline double shared_random(air_rng *rng) { return air_rng_next(rng) * 0x1p-32; }

/* A place with a random receiver and emitter, distance from 0.01 to 30. */
static inline air_impulse_place shared_place(air_rng *rng)
{
    const double z = 2.0 * shared_random(rng) - 1.0, phi = 6.28318 * shared_random(rng);
    return (air_impulse_place){.distance = 0.01 * pow(3000.0, shared_random(rng)),
                               .n_l = z,
                               .cos_s = 2.0 * shared_random(rng) - 1.0,
                               .n_x = sqrt(1.0 - z * z) * cos(phi)};
}

#endif

/* Arguments of runs: what is refused, with what words, and what is left untouched; scratch. */
#include "ordinates/run.h"

#include "ordinates_fixture.h"

typedef struct request {
    ordinates_medium medium;
    air_ordinates_params params;
    air_ordinates_results results;
    void *scratch;
    float fluence[24], seen[24], binned[48];
} request;

static request *request_make(void)
{
    request *const self = calloc(1, sizeof *self);
    assert_non_null(self);
    self->medium = ordinates_even(2, 3, 4, 1.0f, 0.5f, 0.3f);
    air_ordinates_params_default(&self->params);
    self->results = (air_ordinates_results){.fluence = self->fluence,
                                            .view_cosine = self->medium.view_cosine,
                                            .seen = self->seen,
                                            .bins = 2,
                                            .binned = self->binned};
    self->scratch = aligned_alloc(64, 1 << 16);
    assert_non_null(self->scratch);
    self->fluence[0] = -7.0f;
    return self;
}

static void request_free(request *self)
{
    ordinates_medium_free(&self->medium);
    free(self->scratch);
    free(self);
}

/* One wrong thing for each number; false beyond the last. */
static bool spoil(request *self, int which, const char **out_said)
{
    static const char *const said[] = {
        "stencil", "stencil", "decay",   "start",   "steps",  "steps", "residual", "residual",
        "lobe",    "lobe",    "along",   "along",   "edge",   "edge",  "sigma_s",  "sigma_s",
        "sigma_s", "sigma_a", "sigma_a", "g in",    "g in",   "g in",  "entry",    "entry",
        "cosine",  "cosine",  "bin at",  "aligned", "aligned"};
    air_ordinates_params *const p = &self->params;
    air_ordinates_cells *const c = &self->medium.cells;
    if (which >= (int)(sizeof said / sizeof said[0])) {
        return false;
    }
    *out_said = said[which];
    switch (which) {
    case 0:
        p->stencil = (air_ordinates_stencil)3;
        break;
    case 1:
        p->stencil = (air_ordinates_stencil)-1;
        break;
    case 2:
        p->decay = (air_ordinates_decay)2;
        break;
    case 3:
        p->start = (air_ordinates_start)3;
        break;
    case 4:
        p->steps = 0;
        break;
    case 5:
        p->steps = AIR_ORDINATES_STEPS_MAX + 1;
        break;
    case 6:
        p->residual = -1e-9;
        break;
    case 7:
        p->residual = (double)NAN;
        break;
    case 8:
        p->lobe = 1.01f;
        break;
    case 9:
        p->lobe = NAN;
        break;
    case 10:
        c->size[1] = 0;
        break;
    case 11:
        c->size[2] = AIR_ORDINATES_SIZE_MAX + 1;
        break;
    case 12:
        c->cell_m = 0.0f;
        break;
    case 13:
        c->cell_m = INFINITY;
        break;
    case 14:
        self->medium.sigma_s[23] = -1.0f;
        break;
    case 15:
        self->medium.sigma_s[5] = NAN;
        break;
    case 16:
        c->sigma_s = NULL;
        break;
    case 17:
        self->medium.sigma_a[0] = INFINITY;
        break;
    case 18:
        c->sigma_a = NULL;
        break;
    case 19:
        self->medium.g[7] = 1.0f;
        break;
    case 20:
        self->medium.g[7] = -1.0f;
        break;
    case 21:
        c->g = NULL;
        break;
    case 22:
        self->medium.entry[5] = -1.0f;
        break;
    case 23:
        self->medium.entry[5] = INFINITY;
        break;
    case 24:
        self->results.view_cosine = NULL;
        break;
    case 25:
        self->medium.view_cosine[23] = 1.1f;
        break;
    case 26:
        self->results.bins = 0;
        break;
    case 27:
        self->scratch = NULL;
        break;
    default:
        self->scratch = (char *)self->scratch + 4;
        break;
    }
    return true;
}

static void wrong_arguments_are_named(void **state)
{
    const char *said;
    (void)state;
    for (int level = 0; level < ORDINATES_LEVELS; level++) {
        air_context *const context = ordinates_context(level);
        bool more = context != NULL;
        for (int i = 0; more; i++) {
            request *const r = request_make();
            void *const scratch = r->scratch;
            more = spoil(r, i, &said);
            const air_status status =
                air_ordinates_run(context, &r->medium.cells, &r->params, r->scratch, &r->results);
            assert_int_equal(status, more ? AIR_ERROR_ARGUMENT : AIR_OK);
            if (more && strstr(air_context_last_error(context), said) == NULL) {
                print_message("%d: %s\n", i, air_context_last_error(context));
                fail();
            }
            assert_true((r->fluence[0] == -7.0f) == more);
            r->scratch = scratch;
            request_free(r);
        }
        air_context_destroy(context);
    }
}

static void nothing_wanted_is_nothing_done(void **state)
{
    const air_ordinates_results none = {0};
    (void)state;
    for (int level = 0; level < ORDINATES_LEVELS; level++) {
        air_context *const context = ordinates_context(level);
        request *const r = request_make();
        r->medium.cells.entry = NULL;
        for (int stencil = 0; stencil < 3 && context != NULL; stencil++) {
            r->params.stencil = (air_ordinates_stencil)stencil;
            assert_int_equal(
                air_ordinates_run(context, &r->medium.cells, &r->params, r->scratch, &none),
                AIR_OK);
        }
        request_free(r);
        air_context_destroy(context);
    }
}

static void scratch_grows_with_the_grid_and_fits(void **state)
{
    air_ordinates_params params;
    air_ordinates_cells cells = {.size = {1, 1, 1}};
    (void)state;
    air_ordinates_params_default(&params);
    const size_t one = air_ordinates_scratch(&cells, &params);
    cells.size[0] = cells.size[1] = cells.size[2] = 20;
    const size_t many = air_ordinates_scratch(&cells, &params);
    params.stencil = AIR_ORDINATES_SIX;
    const size_t six = air_ordinates_scratch(&cells, &params);
    cells.size[0] = cells.size[1] = cells.size[2] = AIR_ORDINATES_SIZE_MAX;
    const size_t most = air_ordinates_scratch(&cells, &params);
    assert_true(one > 0 && many > one && six > many && most > six);
    cells.size[1] = AIR_ORDINATES_SIZE_MAX + 1;
    assert_int_equal(air_ordinates_scratch(&cells, &params), 0);
    cells.size[1] = 1;
    params.steps = 0;
    assert_int_equal(air_ordinates_scratch(&cells, &params), 0);
}

/* The paper's form where it is defined, finite where it is not. */
static void decay_rates_are_as_stated(void **state)
{
    (void)state;
    assert_true(fabs(ordinates_decay_rate(AIR_ORDINATES_DECAY_POISSON, 0.7) - 0.3) < 1e-15);
    assert_true(ordinates_decay_rate(AIR_ORDINATES_DECAY_POISSON, -0.5) == 1.5);
    assert_true(fabs(exp(-ordinates_decay_rate(AIR_ORDINATES_DECAY_PAPER, 0.7)) - 0.7) < 1e-15);
    assert_true(ordinates_decay_rate(AIR_ORDINATES_DECAY_PAPER, 0.0) == 13.8);
    assert_true(ordinates_decay_rate(AIR_ORDINATES_DECAY_PAPER, -0.9) == 13.8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_arguments_are_named),
        cmocka_unit_test(nothing_wanted_is_nothing_done),
        cmocka_unit_test(scratch_grows_with_the_grid_and_fits),
        cmocka_unit_test(decay_rates_are_as_stated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

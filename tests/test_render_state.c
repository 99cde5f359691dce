/* What lives from picture to picture: pictures of a sequence begin where the ones before ended, by
 * the same criterion, and depend on nothing else. */
#include <math.h>
#include <stdlib.h>

#include "memory_shortage.h"
#include "moving_fog.h"
#include "picture_fixture.h"
#include "render/ordinates/domain.h"

/* Hears how many sweeps the solver took. */
typedef struct listener {
    unsigned sweeps;
    bool warm;
} listener;

static void hear(void *user, air_message_level level, const char *text)
{
    listener *const self = user;
    if (level == AIR_MESSAGE_INFO && sscanf(text, "ordinates: %u sweeps", &self->sweeps) == 1) {
        self->warm = strstr(text, "begun from the picture before") != NULL;
    }
}

static air_context *listening_context(size_t threads, listener *out)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.thread_count = threads;
    params.message = hear;
    params.message_user = out;
    *out = (listener){0};
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static air_render_params small_picture(air_render_state *state)
{
    air_render_params params = picture("ordinates", 4);
    params.max_depth = UINT32_MAX;
    params.ordinates.cells = 12;
    params.ordinates.directions = 16;
    params.ordinates.bands = 4;
    params.ordinates.polar = 4;
    params.ordinates.azimuths = 8;
    params.ordinates.sweeps = 64;
    params.state = state;
    return params;
}

static air_film *film_of(air_context *context, const moving_fog *fog,
                         const air_render_params *params)
{
    air_snapshot *snapshot;
    air_film *film;
    assert_int_equal(fog_make(context, fog, &snapshot), AIR_OK);
    assert_int_equal(air_render(context, snapshot, params, &film), AIR_OK);
    air_snapshot_release(snapshot);
    return film;
}

static air_image *image_of(air_context *context, const moving_fog *fog,
                           const air_render_params *params)
{
    air_film *const film = film_of(context, fog, params);
    air_image *image;
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
    air_film_destroy(film);
    return image;
}

/* Root of the mean square difference, over the mean. */
static double difference(const air_image *a, const air_image *b)
{
    double squares = 0.0, sum = 0.0;
    for (size_t c = 0; c < air_image_channel_count(a); c++) {
        const float *const x = air_image_plane_const(a, c), *const y = air_image_plane_const(b, c);
        for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
            squares += ((double)x[i] - (double)y[i]) * ((double)x[i] - (double)y[i]);
            sum += (double)y[i];
        }
    }
    const double count = (double)(air_image_channel_count(a) * WIDTH * HEIGHT);
    return sqrt(squares / count) / (sum / count);
}

/* Frame n of a drift in which everything changes a little. */
static moving_fog drifting(int n)
{
    moving_fog fog = still_fog;
    fog.sigma *= 1.0f + 0.03f * (float)n;
    fog.centre = 0.02f * (float)n;
    fog.height = 1.0f - 0.03f * (float)n;
    fog.sun *= 1.0f + 0.1f * (float)n;
    fog.eye = 0.05f * (float)n;
    return fog;
}

/* ---- bytes ---- */

static void an_empty_state_changes_nothing(void **state)
{
    listener heard;
    air_context *const context = listening_context(1, &heard);
    air_render_state *kept;
    (void)state;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    const air_render_params with = small_picture(kept), without = small_picture(NULL);
    air_image *const a = image_of(context, &still_fog, &with);
    assert_false(heard.warm);
    air_image *const b = image_of(context, &still_fog, &without);
    assert_true(difference(a, b) == 0.0);
    air_image_destroy(a);
    air_image_destroy(b);
    air_render_state_destroy(kept);
    air_context_destroy(context);
}

enum { FRAMES = 4 };

static void render_sequence(air_context *context, air_image *out[FRAMES])
{
    air_render_state *kept;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    const air_render_params params = small_picture(kept);
    for (int i = 0; i < FRAMES; i++) {
        const moving_fog fog = drifting(i);
        out[i] = image_of(context, &fog, &params);
    }
    air_render_state_destroy(kept);
}

static void a_sequence_has_the_same_bytes_each_time_and_by_any_number_of_threads(void **state)
{
    air_context *const one = make_context(1, NULL), *const three = make_context(3, NULL);
    air_image *a[FRAMES], *b[FRAMES];
    (void)state;
    render_sequence(one, a);
    render_sequence(three, b);
    for (int i = 0; i < FRAMES; i++) {
        assert_true(difference(a[i], b[i]) == 0.0);
        air_image_destroy(a[i]);
        air_image_destroy(b[i]);
    }
    air_context_destroy(three);
    air_context_destroy(one);
}

/* Frames between which the sky's picture, or what blurs it, changes. */
static void render_skies(air_context *context, uint32_t max_depth, double most)
{
    moving_fog fogs[4] = {still_fog, still_fog, still_fog, still_fog};
    air_render_state *kept;
    fogs[0].sun = fogs[1].sun = fogs[2].sun = fogs[3].sun = 0.0f;
    fogs[1].eye = 0.2f;
    fogs[2].bright = fogs[3].bright = 9;
    fogs[3].g = 0.9f;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    air_render_params with = small_picture(kept), without = small_picture(NULL);
    with.max_depth = without.max_depth = max_depth;
    for (int i = 0; i < 4; i++) {
        air_image *const a = image_of(context, &fogs[i], &with);
        air_image *const b = image_of(context, &fogs[i], &without);
        assert_true(difference(a, b) <= most);
        air_image_destroy(a);
        air_image_destroy(b);
    }
    air_render_state_destroy(kept);
}

/* Skies are made ready once; what was made of another picture, or of another phase function, does
 * not serve. Where events are counted there is nothing else to begin from; else the light is what
 * sweeps of changes below 1e-3 leave, which no sky of another side is. */
static void skies_that_are_kept_change_nothing(void **state)
{
    air_context *const context = make_context(1, NULL);
    (void)state;
    render_skies(context, 3, 0.0);
    render_skies(context, UINT32_MAX, 0.01);
    air_context_destroy(context);
}

/* Where n sweeps stand for n events, none are left out and none are taken over. */
static void counted_events_begin_from_nothing(void **state)
{
    listener heard;
    air_context *const context = listening_context(1, &heard);
    air_render_state *kept;
    (void)state;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    air_render_params params = small_picture(kept);
    air_film_destroy(film_of(context, &still_fog, &params));
    params.max_depth = 4;
    air_image *const a = image_of(context, &still_fog, &params);
    assert_false(heard.warm);
    params.state = NULL;
    air_image *const b = image_of(context, &still_fog, &params);
    assert_true(difference(a, b) == 0.0);
    air_image_destroy(a);
    air_image_destroy(b);
    air_render_state_destroy(kept);
    air_context_destroy(context);
}

/* Samples of one frame that began differently are not of one picture. */
static void films_merge_only_with_those_of_the_same_past(void **state)
{
    air_context *const context = make_context(1, NULL);
    air_film *films[2][2];
    (void)state;
    for (int i = 0; i < 2; i++) {
        air_render_state *kept;
        assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
        air_render_params params = small_picture(kept);
        const moving_fog next = drifting(1);
        for (int frame = 0; frame < 2; frame++) {
            params.sample_begin = i == 0 ? 0 : 16;
            params.sample_end = params.sample_begin + 16;
            films[i][frame] = film_of(context, frame == 0 ? &still_fog : &next, &params);
        }
        air_render_state_destroy(kept);
    }
    air_render_params cold = small_picture(NULL);
    const moving_fog next = drifting(1);
    cold.sample_begin = 16;
    cold.sample_end = 32;
    air_film *const apart = film_of(context, &next, &cold);
    assert_int_equal(air_film_merge(films[0][1], apart), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_film_merge(films[0][1], films[1][1]), AIR_OK);
    assert_int_equal(air_film_merge(films[0][0], films[1][0]), AIR_OK);
    for (int i = 0; i < 4; i++) {
        air_film_destroy(films[i / 2][i % 2]);
    }
    air_film_destroy(apart);
    air_context_destroy(context);
}

/* ---- sweeps ---- */

typedef struct change {
    const char *name;
    moving_fog after;
    unsigned most; /* sweeps, per 100 of those from nothing */
} change;

/* The same criterion, in fewer sweeps: what is left of an error is a hundredth or so, as 1e-3 is
 * what a sweep may change and each leaves most of a tenth. */
static void changes_are_followed_in_fewer_sweeps(void **state)
{
    listener heard;
    air_context *const context = listening_context(2, &heard);
    change changes[] = {{"none", still_fog, 0},     {"camera", still_fog, 0},
                        {"density", still_fog, 50}, {"all lights", still_fog, 20},
                        {"moved", still_fog, 20},   {"smaller", still_fog, 70},
                        {"jumped", still_fog, 20}};
    (void)state;
    changes[1].after.eye = 0.3f;
    changes[2].after.sigma *= 1.05f;
    changes[3].after.sun *= 1000.0f;
    changes[3].after.sky *= 1000.0f;
    changes[4].after.centre = 0.03f;
    changes[5].after.height = 0.9f;
    changes[6].after.centre = changes[6].after.eye = 5.0f; /* as a whole: the light goes along */
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        air_render_state *kept;
        assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
        const air_render_params with = small_picture(kept), without = small_picture(NULL);
        air_film_destroy(film_of(context, &still_fog, &with));
        air_image *const warm = image_of(context, &changes[i].after, &with);
        const unsigned sweeps = heard.sweeps;
        assert_true(heard.warm);
        air_image *const cold = image_of(context, &changes[i].after, &without);
        assert_false(heard.warm);
        print_message("%s: %u sweeps, %u from nothing; difference %.2g\n", changes[i].name, sweeps,
                      heard.sweeps, difference(warm, cold));
        assert_true(100 * sweeps <=
                    changes[i].most * heard.sweeps + (changes[i].most > 0 ? 99 : 0));
        air_image_destroy(warm);
        air_image_destroy(cold);
        air_render_state_destroy(kept);
    }
    air_context_destroy(context);
}

/* ---- steadiness ---- */

/* Light that was followed ends a little off; while nothing but the camera moves it stays so. Where
 * more is asked for, or lights differ by one part in 10^5, sweeps go on. */
static void light_of_a_still_medium_stays_to_the_bit(void **state)
{
    listener heard;
    air_context *const context = listening_context(2, &heard);
    air_render_state *kept;
    moving_fog fog = drifting(1);
    (void)state;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    air_render_params params = small_picture(kept);
    air_film_destroy(film_of(context, &still_fog, &params));
    air_image *const first = image_of(context, &fog, &params);
    assert_true(heard.sweeps > 1);
    const float eye = fog.eye;
    fog.eye = 0.3f;
    air_film_destroy(film_of(context, &fog, &params));
    assert_int_equal(heard.sweeps, 0);
    fog.eye = eye;
    air_image *const again = image_of(context, &fog, &params);
    assert_int_equal(heard.sweeps, 0);
    assert_true(difference(again, first) == 0.0);
    params.ordinates.change *= 0.5;
    air_film_destroy(film_of(context, &fog, &params));
    assert_true(heard.sweeps > 0);
    fog.sun *= 1.00001f;
    air_film_destroy(film_of(context, &fog, &params));
    assert_true(heard.sweeps > 0);
    air_image_destroy(first);
    air_image_destroy(again);
    air_render_state_destroy(kept);
    air_context_destroy(context);
}

/* Fog that thickens by 4 % a frame, over all depths of cells at which the sky goes over from beams
 * to light by the box's faces, which differ by more than a tenth: 5 % of difference from frame to
 * frame at the thin end, less and less to the thick one. */
static void the_sky_goes_over_to_the_faces_without_a_jump(void **state)
{
    air_context *const context = make_context(2, NULL);
    const air_render_params params = small_picture(NULL);
    air_image *before = NULL;
    moving_fog fog = still_fog;
    double last = 0.06;
    (void)state;
    fog.sun = 0.0f;
    fog.sigma = 3.5f;
    for (int i = 0; i < 26; i++, fog.sigma *= 1.04f) {
        air_image *const image = image_of(context, &fog, &params);
        if (before != NULL) {
            const double step = difference(image, before);
            assert_true(step < 1.1 * last);
            last = step;
        }
        air_image_destroy(before);
        before = image;
    }
    air_image_destroy(before);
    air_context_destroy(context);
}

/* ---- cells ---- */

static ord_domain placed(air_context *context, const moving_fog *fog, const ord_lattice *lattice)
{
    air_snapshot *snapshot;
    ord_domain domain;
    assert_int_equal(fog_make(context, fog, &snapshot), AIR_OK);
    assert_int_equal(ord_domain_place(snapshot, 12, lattice, &domain), AIR_OK);
    air_snapshot_release(snapshot);
    return domain;
}

/* Corners of cells are multiples of an edge apart. */
static void cells_stay_where_they_are_while_media_move(void **state)
{
    air_context *const context = make_context(1, NULL);
    const ord_domain first = placed(context, &still_fog, NULL);
    (void)state;
    for (int n = 0; n < 40; n++) {
        moving_fog fog = still_fog;
        fog.centre = 0.0173f * (float)n;
        fog.height = 1.0f - 0.011f * (float)(n + 1);
        const ord_domain next = placed(context, &fog, &first.lattice);
        const float low[3] = {fog.centre - 0.5f, -0.5f * fog.height, -0.5f};
        assert_true(next.cell_m == first.cell_m);
        for (int axis = 0; axis < 3; axis++) {
            const float cells = (next.origin[axis] - first.origin[axis]) / first.cell_m;
            const float end = next.origin[axis] + (float)(ptrdiff_t)next.size[axis] * next.cell_m;
            assert_float_equal(cells, roundf(cells), 1e-4f);
            assert_true(next.origin[axis] <= low[axis] + 1e-3f * next.cell_m);
            assert_true(next.origin[axis] > low[axis] - next.cell_m);
            assert_true(end >= low[axis] + (axis == 1 ? fog.height : 1.0f) - 1e-3f * next.cell_m);
        }
    }
    air_context_destroy(context);
}

/* What keeps its size is what moves. */
static void cells_go_along_with_bounds_that_move_as_a_whole(void **state)
{
    air_context *const context = make_context(1, NULL);
    const ord_domain first = placed(context, &still_fog, NULL);
    moving_fog fog = still_fog;
    (void)state;
    fog.centre = 0.0173f;
    const ord_domain next = placed(context, &fog, &first.lattice);
    assert_true(next.goes_on && next.cell_m == first.cell_m);
    assert_memory_equal(next.size, first.size, sizeof first.size);
    assert_float_equal(next.origin[0] - first.origin[0], 0.0173f, 1e-6f);
    assert_true(next.origin[1] == first.origin[1] && next.origin[2] == first.origin[2]);
    air_context_destroy(context);
}

static void a_lattice_that_has_become_too_coarse_or_fine_is_given_up(void **state)
{
    air_context *const context = make_context(1, NULL);
    const ord_domain first = placed(context, &still_fog, NULL);
    moving_fog tall = still_fog;
    (void)state;
    tall.height = 1.2f;
    assert_true(placed(context, &tall, &first.lattice).cell_m == first.cell_m);
    tall.height = 1.3f;
    const ord_domain anew = placed(context, &tall, &first.lattice);
    const ord_domain alone = placed(context, &tall, NULL);
    assert_true(anew.cell_m == alone.cell_m && anew.cell_m > 1.2f * first.cell_m);
    assert_memory_equal(anew.origin, alone.origin, sizeof alone.origin);
    ord_lattice other = first.lattice;
    other.cells = 10; /* another number was asked for */
    assert_true(placed(context, &still_fog, &other).lattice.cells == 12);
    air_context_destroy(context);
}

/* ---- what is refused, what fails ---- */

typedef struct nested {
    air_context *context;
    const air_snapshot *snapshot;
    const air_render_params *params;
    air_status status;
} nested;

static bool render_once_more(void *user, const struct air_film *film)
{
    nested *const self = user;
    air_render_params params = *self->params;
    air_film *inner;
    (void)film;
    params.pass_done = NULL;
    self->status = air_render(self->context, self->snapshot, &params, &inner);
    assert_null(inner);
    return true;
}

static void a_state_in_use_or_of_another_context_is_refused(void **state)
{
    air_context *const context = make_context(1, NULL), *const other = make_context(1, NULL);
    air_render_state *kept;
    air_snapshot *snapshot;
    air_film *film;
    (void)state;
    assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
    assert_int_equal(fog_make(context, &still_fog, &snapshot), AIR_OK);
    air_render_params params = small_picture(kept);
    nested once_more = {context, snapshot, &params, AIR_OK};
    params.pass_done = render_once_more;
    params.pass_user = &once_more;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
    assert_int_equal(once_more.status, AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "render state is in use"));
    air_film_destroy(film);
    params.pass_done = NULL;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK); /* free again */
    air_film_destroy(film);
    assert_int_equal(air_render(other, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
    assert_null(film);
    assert_non_null(strstr(air_context_last_error(other), "another context"));
    air_snapshot_release(snapshot);
    air_render_state_destroy(kept);
    air_render_state_destroy(NULL);
    air_context_destroy(other);
    air_context_destroy(context);
}

/* Stops when light is carried to the cells, if it may not go on. */
typedef struct stopper {
    bool stop;
} stopper;

static bool go_on(void *user, double fraction, const char *what)
{
    const stopper *const self = user;
    (void)fraction;
    return !(self->stop && strcmp(what, "light in cells") == 0);
}

static void what_fails_leaves_the_state_as_it_was(void **state)
{
    stopper stop = {false};
    air_context_params host;
    air_context *context;
    air_image *images[2];
    (void)state;
    air_context_params_default(&host);
    host.progress = go_on;
    host.progress_user = &stop;
    assert_int_equal(air_context_create(&host, &context), AIR_OK);
    for (int i = 0; i < 2; i++) {
        const moving_fog second = drifting(1), third = drifting(3);
        air_render_state *kept;
        air_snapshot *snapshot;
        air_film *film;
        assert_int_equal(air_render_state_create(context, &kept), AIR_OK);
        const air_render_params params = small_picture(kept);
        air_film_destroy(film_of(context, &still_fog, &params));
        if (i == 1) {
            assert_int_equal(fog_make(context, &second, &snapshot), AIR_OK);
            stop.stop = true;
            assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_INTERRUPTED);
            stop.stop = false;
            air_film_destroy(film);
            air_snapshot_release(snapshot);
        }
        images[i] = image_of(context, &third, &params);
        air_render_state_destroy(kept);
    }
    assert_true(difference(images[0], images[1]) == 0.0);
    air_image_destroy(images[0]);
    air_image_destroy(images[1]);
    air_context_destroy(context);
}

static air_status try_sequence(air_context *context, void *user)
{
    air_render_state *kept = NULL;
    air_status status = air_render_state_create(context, &kept);
    (void)user;
    for (int i = 0; i < 2 && status == AIR_OK; i++) {
        const moving_fog fog = drifting(i);
        air_render_params params = small_picture(kept);
        air_snapshot *snapshot;
        air_film *film = NULL;
        params.width = 4;
        params.height = 3;
        params.ordinates.cells = 3;
        status = fog_make(context, &fog, &snapshot);
        if (status == AIR_OK) {
            status = air_render(context, snapshot, &params, &film);
        }
        air_film_destroy(film);
        air_snapshot_release(snapshot);
    }
    air_render_state_destroy(kept);
    return status;
}

static void allocation_failures_are_reported_and_leak_nothing(void **state)
{
    (void)state;
    assert_shortage_survived(try_sequence, NULL, 2000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_state_changes_nothing),
        cmocka_unit_test(a_sequence_has_the_same_bytes_each_time_and_by_any_number_of_threads),
        cmocka_unit_test(skies_that_are_kept_change_nothing),
        cmocka_unit_test(counted_events_begin_from_nothing),
        cmocka_unit_test(films_merge_only_with_those_of_the_same_past),
        cmocka_unit_test(changes_are_followed_in_fewer_sweeps),
        cmocka_unit_test(light_of_a_still_medium_stays_to_the_bit),
        cmocka_unit_test(the_sky_goes_over_to_the_faces_without_a_jump),
        cmocka_unit_test(cells_stay_where_they_are_while_media_move),
        cmocka_unit_test(cells_go_along_with_bounds_that_move_as_a_whole),
        cmocka_unit_test(a_lattice_that_has_become_too_coarse_or_fine_is_given_up),
        cmocka_unit_test(a_state_in_use_or_of_another_context_is_refused),
        cmocka_unit_test(what_fails_leaves_the_state_as_it_was),
        cmocka_unit_test(allocation_failures_are_reported_and_leak_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

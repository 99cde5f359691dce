/* Errors, warnings and progress. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/host.h"
#include "failing_allocator.h"

enum { ROUNDS = 2000, LONG_TEXT = 5000 };

typedef struct listener {
    air_context *context;
    atomic_int inside; /* callbacks running now */
    int overlaps, messages;
    air_message_level level;
    char text[4096];
} listener;

static void listen(void *user, air_message_level level, const char *text)
{
    listener *self = user;
    if (atomic_fetch_add(&self->inside, 1) != 0) {
        ++self->overlaps;
    }
    ++self->messages;
    self->level = level;
    (void)snprintf(self->text, sizeof self->text, "%s", text);
    atomic_fetch_sub(&self->inside, 1);
}

static air_context *create(listener *self)
{
    air_context_params params;
    air_context_params_default(&params);
    memset(self, 0, sizeof *self);
    params.message = listen;
    params.message_user = self;
    assert_int_equal(air_context_create(&params, &self->context), AIR_OK);
    return self->context;
}

static void fail_returns_its_status_and_keeps_the_sentence(void **state)
{
    (void)state;
    listener ear;
    air_context *context = create(&ear);
    assert_int_equal(air_fail(context, AIR_ERROR_FORMAT, "%s: byte %d", "a.glb", 12),
                     AIR_ERROR_FORMAT);
    assert_string_equal(air_context_last_error(context), "a.glb: byte 12");
    assert_string_equal(ear.text, "a.glb: byte 12");
    assert_int_equal(ear.level, AIR_MESSAGE_ERROR);
    /* The last error may be part of the next. */
    (void)air_fail(context, AIR_ERROR_IO, "scene: %s", air_context_last_error(context));
    assert_string_equal(air_context_last_error(context), "scene: a.glb: byte 12");
    air_warn(context, "dull");
    assert_int_equal(ear.level, AIR_MESSAGE_WARNING);
    air_inform(context, "fine");
    assert_int_equal(ear.level, AIR_MESSAGE_INFO);
    assert_int_equal(ear.messages, 4);
    assert_string_equal(air_context_last_error(context), "scene: a.glb: byte 12");
    air_context_destroy(context);
    assert_string_equal(air_context_last_error(NULL), "");
}

static void long_sentences_are_cut_with_dots(void **state)
{
    (void)state;
    listener ear;
    air_context *context = create(&ear);
    char text[LONG_TEXT + 1];
    memset(text, 'x', LONG_TEXT);
    text[LONG_TEXT] = '\0';
    (void)air_fail(context, AIR_ERROR_IO, "%s", text);
    const char *kept = air_context_last_error(context);
    const size_t length = strlen(kept);
    assert_true(length > 1000 && length < LONG_TEXT);
    assert_string_equal(kept + length - 3, "...");
    air_context_destroy(context);
}

typedef struct speaker {
    air_context *context;
    int id, wrong;
} speaker;

static void *speak(void *user)
{
    speaker *self = user;
    for (int i = 0; i < ROUNDS; ++i) {
        char expected[64];
        (void)snprintf(expected, sizeof expected, "thread %d round %d", self->id, i);
        (void)air_fail(self->context, AIR_ERROR_IO, "thread %d round %d", self->id, i);
        self->wrong += strcmp(air_context_last_error(self->context), expected) != 0;
    }
    return NULL;
}

static void two_threads_have_their_own_errors_and_never_speak_at_once(void **state)
{
    (void)state;
    listener ear;
    air_context *context = create(&ear);
    speaker speakers[2] = {{context, 0, 0}, {context, 1, 0}};
    pthread_t threads[2];
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pthread_create(&threads[i], NULL, speak, &speakers[i]), 0);
    }
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
        assert_int_equal(speakers[i].wrong, 0);
    }
    assert_int_equal(ear.messages, 2 * ROUNDS);
    assert_int_equal(ear.overlaps, 0);
    assert_string_equal(air_context_last_error(context), ""); /* this thread did not fail */
    air_context_destroy(context);
}

static void two_contexts_share_no_errors(void **state)
{
    (void)state;
    listener ear_a, ear_b;
    air_context *a = create(&ear_a), *b = create(&ear_b);
    (void)air_fail(a, AIR_ERROR_IO, "only a");
    assert_string_equal(air_context_last_error(b), "");
    assert_int_equal(ear_b.messages, 0);
    air_context_destroy(a);
    air_context_destroy(b);
}

static void the_message_comes_through_without_memory(void **state)
{
    (void)state;
    listener ear;
    memset(&ear, 0, sizeof ear);
    failing_allocator allocator;
    air_context_params params = failing_params(&allocator, 1);
    params.message = listen;
    params.message_user = &ear;
    air_context *context = NULL;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_int_equal(air_fail_memory(context, "scene"), AIR_ERROR_MEMORY);
    assert_string_equal(ear.text, "scene: out of memory");
    air_context_destroy(context);
}

static void call_back_in(void *user, air_message_level level, const char *text)
{
    listener *self = user;
    if (level == AIR_MESSAGE_WARNING) {
        (void)air_fail(self->context, AIR_ERROR_INTERNAL, "from inside: %s", text);
    }
    ++self->messages;
}

static void a_callback_may_call_the_library(void **state)
{
    (void)state;
    listener ear;
    memset(&ear, 0, sizeof ear);
    air_context_params params;
    air_context_params_default(&params);
    params.message = call_back_in;
    params.message_user = &ear;
    assert_int_equal(air_context_create(&params, &ear.context), AIR_OK);
    air_warn(ear.context, "w");
    assert_int_equal(ear.messages, 2);
    assert_string_equal(air_context_last_error(ear.context), "from inside: w");
    air_context_destroy(ear.context);
}

static bool stop_at_half(void *user, double fraction, const char *what)
{
    assert_string_equal(what, "baking");
    ++*(int *)user;
    return fraction < 0.5;
}

static void progress_goes_on_until_told_to_stop(void **state)
{
    (void)state;
    listener ear;
    air_context *context = create(&ear);
    assert_true(air_progress(context, 0.9, "baking")); /* no callback: go on */
    air_context_destroy(context);
    int calls = 0;
    air_context_params params;
    air_context_params_default(&params);
    params.progress = stop_at_half;
    params.progress_user = &calls;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_true(air_progress(context, 0.1, "baking"));
    assert_false(air_progress(context, 0.5, "baking"));
    assert_int_equal(calls, 2);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fail_returns_its_status_and_keeps_the_sentence),
        cmocka_unit_test(long_sentences_are_cut_with_dots),
        cmocka_unit_test(two_threads_have_their_own_errors_and_never_speak_at_once),
        cmocka_unit_test(two_contexts_share_no_errors),
        cmocka_unit_test(the_message_comes_through_without_memory),
        cmocka_unit_test(a_callback_may_call_the_library),
        cmocka_unit_test(progress_goes_on_until_told_to_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

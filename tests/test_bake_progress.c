/* Bakes that stop and go on give the bytes of one that did not, whatever became of the file. */
#include <errno.h>
#include <signal.h>
#include <sys/resource.h>

#include "bake_fixture.h"

/* A floor and a box in haze, under a sky and a sun: light in media, pages, vertices, probes. */
static air_snapshot *room(const bake_host *host)
{
    air_scene *scene = bake_scene(host);
    air_medium_desc medium = medium_in_box(vec3(0, 1, 0), vec3(2, 1, 2));
    set3(medium.sigma_s, 0.4f, 0.3f, 0.2f);
    add_medium(scene, &medium);
    add_floor(scene, 0.0f, 1.5f, AIR_NONE);
    bake_add_box(scene, vec3(-0.5f, 0, -0.5f), vec3(0.3f, 0.8f, 0.2f), false,
                 add_lambert(scene, 0.5f, 0.0f));
    add_environment(scene, 0.4f, 0.5f, 0.6f);
    add_sun(scene, vec3(1.0f, 0.9f, 0.8f), vec3(0.3f, -1.0f, 0.1f));
    return path_freeze(scene);
}

static const air_probe_request probe_requests[1] = {
    {.name = "auto", .kind = AIR_PROBES_AUTO, .spacing = 0.8f}};

static air_bake_params all_of_it(const char *path)
{
    air_bake_params params;
    air_bake_params_default(&params);
    params.samples = 4;
    params.max_bounces = 3;
    params.cache_resolution = 8;
    params.cache_samples = 16;
    params.texels_per_metre = 6.0f;
    params.page_size = 24;
    params.directional = true;
    params.vertices = true;
    params.probes = probe_requests;
    params.probe_count = 1;
    params.progress_path = path;
    return params;
}

static bool exists(const char *path) { return access(path, F_OK) == 0; }

/* Runs until the progress callback stops it, which it must. */
static void interrupt(bake_host *host, const air_snapshot *snapshot, const air_bake_params *params,
                      long calls)
{
    air_lightmap *lightmap = NULL;
    host->calls = 0;
    host->stop_after = calls;
    host->fraction = 0.0;
    assert_int_equal(air_bake(host->context, snapshot, params, &lightmap, NULL),
                     AIR_ERROR_INTERRUPTED);
    assert_null(lightmap);
    host->stop_after = LONG_MAX;
    host->calls = 0;
    host->fraction = 0.0;
}

/* Goes on to the end; returns how many jobs it took from the file. */
static size_t go_on(bake_host *host, const air_snapshot *snapshot, const air_bake_params *params,
                    const air_lightmap *expected)
{
    air_lightmap *lightmap = NULL;
    air_bake_report report;
    host->fraction = 0.0;
    if (air_bake(host->context, snapshot, params, &lightmap, &report) != AIR_OK) {
        fail_msg("%s", air_context_last_error(host->context));
    }
    bake_assert_same(expected, lightmap);
    air_lightmap_destroy(lightmap);
    assert_false(exists(params->progress_path));
    return report.resumed_jobs;
}

/* The file of a bake that stopped after so many calls. */
static char *interrupted_file(bake_host *host, const air_snapshot *snapshot,
                              const air_bake_params *params, long calls, size_t *out_size)
{
    interrupt(host, snapshot, params, calls);
    FILE *file = fopen(params->progress_path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *out_size = (size_t)ftell(file);
    rewind(file);
    char *data = malloc(*out_size);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *out_size, file), *out_size);
    fclose(file);
    return data;
}

static void write_file(const char *path, const char *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

typedef struct course {
    bake_host host;
    air_snapshot *snapshot;
    air_bake_params params;
    air_lightmap *expected;
    char path[LIGHTMAP_PATH];
    long jobs; /* calls of the progress callback in the whole bake */
} course;

static void begin(course *self, size_t threads)
{
    bake_open(&self->host, threads);
    (void)snprintf(self->path, sizeof self->path, "%s", bake_path(&self->host, "bake.progress"));
    self->snapshot = room(&self->host);
    self->params = all_of_it(NULL);
    self->expected = bake_well(&self->host, self->snapshot, &self->params);
    self->jobs = self->host.calls;
    self->params.progress_path = self->path;
    assert_true(self->jobs > 12);
}

static void end(course *self)
{
    air_lightmap_destroy(self->expected);
    air_snapshot_release(self->snapshot);
    bake_close(&self->host);
}

static void a_stopped_bake_goes_on_to_the_same_bytes(void **state)
{
    (void)state;
    for (size_t threads = 1; threads <= 2; threads++) {
        course self;
        begin(&self, threads);
        const long stops[] = {1, 2, self.jobs / 3, self.jobs / 2, self.jobs - 1, self.jobs};
        for (size_t i = 0; i < sizeof stops / sizeof stops[0]; i++) {
            interrupt(&self.host, self.snapshot, &self.params, stops[i]);
            assert_true(exists(self.path));
            const size_t resumed = go_on(&self.host, self.snapshot, &self.params, self.expected);
            /* a second worker may go on until it hears of it */
            assert_true(threads == 1 ? resumed == (size_t)stops[i] : resumed >= (size_t)stops[i]);
            assert_true(self.host.fraction > 1.0 - 1e-9 || resumed == (size_t)self.jobs);
        }
        assert_false(self.host.backwards);
        assert_int_equal(self.host.warnings, 0);
        end(&self);
    }
}

/* Stopped at every third job and at each one that went on. */
static void a_bake_may_stop_many_times(void **state)
{
    course self;
    air_status status = AIR_ERROR_INTERRUPTED;
    air_lightmap *lightmap = NULL;
    air_bake_report report;
    long runs = 0;
    (void)state;
    begin(&self, 1);
    for (; status == AIR_ERROR_INTERRUPTED && runs < self.jobs; runs++) {
        self.host.calls = 0;
        self.host.fraction = 0.0;
        self.host.stop_after = 3;
        status = air_bake(self.host.context, self.snapshot, &self.params, &lightmap, &report);
    }
    assert_int_equal(status, AIR_OK);
    assert_int_equal(runs, self.jobs / 3 + 1);
    assert_int_equal(report.resumed_jobs, self.jobs / 3 * 3);
    bake_assert_same(self.expected, lightmap);
    assert_false(exists(self.path));
    air_lightmap_destroy(lightmap);
    end(&self);
}

static void threads_change_no_byte(void **state)
{
    course one, two;
    (void)state;
    begin(&one, 1);
    begin(&two, 2);
    bake_assert_same(one.expected, two.expected);
    assert_int_equal(one.jobs, two.jobs);
    /* one goes on where the other stopped */
    interrupt(&one.host, one.snapshot, &one.params, one.jobs / 2);
    two.params.progress_path = one.path;
    assert_true(go_on(&two.host, two.snapshot, &two.params, one.expected) > 0);
    end(&one);
    end(&two);
}

static void without_a_file_a_stopped_bake_begins_anew(void **state)
{
    course self;
    (void)state;
    begin(&self, 1);
    self.params.progress_path = NULL;
    interrupt(&self.host, self.snapshot, &self.params, 5);
    bake_expect(&self.host, "interrupted");
    air_lightmap *lightmap = bake_well(&self.host, self.snapshot, &self.params);
    bake_assert_same(self.expected, lightmap);
    air_lightmap_destroy(lightmap);
    /* asked not to, it does not look at the file */
    self.params.progress_path = self.path;
    interrupt(&self.host, self.snapshot, &self.params, 5);
    self.params.resume = false;
    assert_int_equal(go_on(&self.host, self.snapshot, &self.params, self.expected), 0);
    end(&self);
}

static void a_file_that_was_cut_is_used_as_far_as_it_goes(void **state)
{
    course self;
    size_t size;
    (void)state;
    begin(&self, 1);
    const long stop = self.jobs - 2;
    char *data = interrupted_file(&self.host, self.snapshot, &self.params, stop, &size);
    const size_t cuts[] = {0, 1, 8, 15, 16, 17, 31, 40, size / 2, size - 1};
    for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
        write_file(self.path, data, cuts[i]);
        const size_t resumed = go_on(&self.host, self.snapshot, &self.params, self.expected);
        assert_true(resumed < (size_t)stop);
        assert_int_equal(resumed > 0, cuts[i] >= size / 2);
    }
    assert_int_equal(self.host.warnings, 0);
    /* what was cut off is written again behind what is whole */
    write_file(self.path, data, size / 2);
    interrupt(&self.host, self.snapshot, &self.params, 2);
    assert_true(go_on(&self.host, self.snapshot, &self.params, self.expected) > 2);
    free(data);
    end(&self);
}

/* Bits turned over in all fields of the first and of later entries, and in numbers. */
static void a_damaged_file_changes_no_byte_of_the_result(void **state)
{
    course self;
    size_t size;
    (void)state;
    begin(&self, 1);
    const long stop = self.jobs - 1;
    char *data = interrupted_file(&self.host, self.snapshot, &self.params, stop, &size);
    uint32_t floats;
    memcpy(&floats, data + 16 + 8, sizeof floats);
    const size_t next = 16 + 16 + (size_t)floats * sizeof(float);
    assert_true(next + 64 < size);
    const size_t places[] = {16,        20,       24,       27,       28,           32,
                             next,      next + 1, next + 4, next + 8, next + 12,    next + 16,
                             next + 37, size / 2, size - 5, size - 1, 3 * size / 4, size / 3};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        for (int bit = 0; bit < 8; bit += 5) {
            data[places[i]] = (char)(data[places[i]] ^ 1 << bit);
            write_file(self.path, data, size);
            data[places[i]] = (char)(data[places[i]] ^ 1 << bit);
            assert_true(go_on(&self.host, self.snapshot, &self.params, self.expected) <
                        (size_t)stop);
        }
    }
    free(data);
    end(&self);
}

static void a_file_of_another_bake_is_said_and_begun_anew(void **state)
{
    course self;
    (void)state;
    begin(&self, 1);
    for (int change = 0; change < 6; change++) {
        air_bake_params other = self.params;
        air_probe_request request = probe_requests[0];
        other.seed = change == 0 ? 1 : 0;
        other.samples += change == 1 ? 1 : 0;
        other.media = change == 2 ? AIR_BAKE_REFERENCE : other.media;
        other.texels_per_metre += change == 3 ? 0.5f : 0.0f;
        other.vertices = change != 4;
        request.spacing += change == 5 ? 0.1f : 0.0f;
        other.probes = &request;
        interrupt(&self.host, self.snapshot, &other, 4);
        self.host.warnings = 0;
        assert_int_equal(go_on(&self.host, self.snapshot, &self.params, self.expected), 0);
        assert_int_equal(self.host.warnings, 1);
        bake_expect_warning(&self.host, self.path);
        bake_expect_warning(&self.host, "another bake");
    }
    /* what is done with the samples afterwards is no other bake */
    air_bake_params other = self.params;
    other.denoise = other.stitch = false;
    other.dilate = 1;
    interrupt(&self.host, self.snapshot, &other, 4);
    assert_int_equal(go_on(&self.host, self.snapshot, &self.params, self.expected), 4);
    end(&self);
}

static void a_file_that_is_something_else_is_left_alone(void **state)
{
    static const char *const texts[] = {"Dear diary, today I baked a lightmap.\n", "short"};
    course self;
    (void)state;
    begin(&self, 1);
    for (size_t i = 0; i < 2; i++) {
        air_lightmap *lightmap = NULL;
        char back[64] = "";
        write_file(self.path, texts[i], strlen(texts[i]));
        assert_int_equal(air_bake(self.host.context, self.snapshot, &self.params, &lightmap, NULL),
                         AIR_ERROR_FORMAT);
        bake_expect(&self.host, self.path);
        bake_expect(&self.host, "expected the progress of a bake");
        FILE *file = fopen(self.path, "rb");
        assert_non_null(file);
        assert_int_equal(fread(back, 1, sizeof back, file), strlen(texts[i]));
        assert_string_equal(back, texts[i]);
        fclose(file);
    }
    end(&self);
}

static void a_file_that_cannot_be_made_is_an_error_before_the_work(void **state)
{
    course self;
    air_lightmap *lightmap = NULL;
    (void)state;
    begin(&self, 1);
    self.params.progress_path = bake_path(&self.host, "no/such/folder/bake.progress");
    self.host.calls = 0;
    assert_int_equal(air_bake(self.host.context, self.snapshot, &self.params, &lightmap, NULL),
                     AIR_ERROR_IO);
    bake_expect(&self.host, self.params.progress_path);
    bake_expect(&self.host, strerror(ENOENT));
    assert_int_equal(self.host.calls, 0);
    end(&self);
}

static air_status bake_on_a_small_disk(course *self, rlim_t bytes)
{
    struct rlimit before;
    air_lightmap *lightmap = NULL;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit small = {bytes, before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const air_status status =
        air_bake(self->host.context, self->snapshot, &self->params, &lightmap, NULL);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)signal(SIGXFSZ, handler);
    assert_null(lightmap);
    return status;
}

/* The message is the calling thread's, whichever thread wrote. */
static void a_full_disk_is_an_error_and_what_was_done_stays(void **state)
{
    (void)state;
    for (size_t threads = 1; threads <= 2; threads++) {
        course self;
        begin(&self, threads);
        const rlim_t limits[] = {0, 10, 100, 20000, 60000};
        for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
            assert_int_equal(bake_on_a_small_disk(&self, limits[i]), AIR_ERROR_IO);
            bake_expect(&self.host, self.path);
            bake_expect(&self.host, strerror(EFBIG));
            const size_t resumed = go_on(&self.host, self.snapshot, &self.params, self.expected);
            assert_int_equal(resumed > 0, limits[i] >= 60000);
        }
        end(&self);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stopped_bake_goes_on_to_the_same_bytes),
        cmocka_unit_test(a_bake_may_stop_many_times),
        cmocka_unit_test(threads_change_no_byte),
        cmocka_unit_test(without_a_file_a_stopped_bake_begins_anew),
        cmocka_unit_test(a_file_that_was_cut_is_used_as_far_as_it_goes),
        cmocka_unit_test(a_damaged_file_changes_no_byte_of_the_result),
        cmocka_unit_test(a_file_of_another_bake_is_said_and_begun_anew),
        cmocka_unit_test(a_file_that_is_something_else_is_left_alone),
        cmocka_unit_test(a_file_that_cannot_be_made_is_an_error_before_the_work),
        cmocka_unit_test(a_full_disk_is_an_error_and_what_was_done_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

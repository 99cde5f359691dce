/* Light at receivers: what arrives at a point of a surface or of space, term by term. */
#include <stdio.h>

#include "core/warp.h"
#include "path_scene.h"

typedef struct received {
    double terms[AIR_TERM_COUNT], errors[AIR_TERM_COUNT]; /* irradiance or fluence, green */
} received;

/* What one lane brings: irradiance, or fluence of spheres, term by term. */
static void add_lane(const air_path_lane *lane, double weight, double sum[AIR_TERM_COUNT])
{
    const air_path_receiver *r = lane->receiver;
    const double connected = r->sphere ? 1.0 : (double)vec3_dot(r->normal, lane->connected_dir);
    const double through = r->sphere ? 1.0 : (double)vec3_dot(r->normal, lane->through_dir);
    sum[AIR_TERM_M1] += through > 0.0 ? weight * through * (double)lane->through.y : 0.0;
    sum[AIR_TERM_S0] += connected > 0.0 ? weight * connected * (double)lane->connected.y : 0.0;
    if (!lane->left) {
        return;
    }
    const double cosine = r->sphere ? 1.0 : (double)vec3_dot(r->normal, lane->dir);
    const double pdf = r->sphere ? (double)sample_sphere_pdf()
                                 : (double)(1.0f - r->uniform) * cosine / AIR_PI +
                                       (double)r->uniform / (2.0 * AIR_PI);
    for (int t = 0; t < AIR_TERM_COUNT; t++) {
        sum[t] += weight * cosine / pdf * (double)lane->terms[t].y;
    }
}

/* samples: of each of 32 replicates, a multiple of 16. */
static received receive(const air_snapshot *snapshot, const air_path_receiver *receiver,
                        const air_path_settings *settings, uint32_t samples)
{
    enum { REPLICATES = 32 };
    received out;
    double squares[AIR_TERM_COUNT] = {0.0};
    air_sobol *sobol = malloc(sizeof *sobol);
    air_path_scratch *scratch = malloc(air_path_scratch_size());
    air_path path;
    assert_non_null(sobol);
    assert_non_null(scratch);
    memset(&out, 0, sizeof out);
    air_sobol_init(sobol);
    assert_int_equal(air_path_init(&path, snapshot, sobol, settings), AIR_OK);
    for (uint32_t r = 0; r < REPLICATES; r++) {
        double sum[AIR_TERM_COUNT] = {0.0};
        for (uint32_t s = 0; s < samples; s += AIR_PATH_LANES) {
            air_path_lane lanes[AIR_PATH_LANES];
            for (uint32_t i = 0; i < AIR_PATH_LANES; i++) {
                lanes[i].sampler = air_sampler_make(sobol, air_hash32(r + 1), s + i);
                lanes[i].receiver = receiver;
                lanes[i].through_weight = 1.0f;
            }
            air_path_receive(&path, scratch, lanes, AIR_PATH_LANES);
            for (uint32_t i = 0; i < AIR_PATH_LANES; i++) {
                add_lane(&lanes[i], 1.0 / samples, sum);
            }
        }
        for (int t = 0; t < AIR_TERM_COUNT; t++) {
            out.terms[t] += sum[t] / REPLICATES;
            squares[t] += sum[t] * sum[t] / REPLICATES;
        }
    }
    for (int t = 0; t < AIR_TERM_COUNT; t++) {
        out.errors[t] =
            sqrt(fmax(squares[t] - out.terms[t] * out.terms[t], 0.0) / (REPLICATES - 1));
    }
    air_path_finish(&path);
    free(sobol);
    free(scratch);
    return out;
}

static const air_path_settings everything = {.max_depth = UINT32_MAX, .terms = AIR_TERMS_ALL};

static air_path_receiver looking_up(air_vec3 position)
{
    return (air_path_receiver){
        .position = position, .normal = {0, 1, 0}, .geometric = {0, 1, 0}, .offset = 1e-5f};
}

/* Within four standard errors of ours and of what is expected. */
static void assert_term(const char *what, const received *got, int term, double expected,
                        double expected_error, double largest_error)
{
    const double error = hypot(got->errors[term], expected_error);
    if (!(got->errors[term] <= largest_error * fabs(expected)) ||
        !(fabs(got->terms[term] - expected) <= 4.0 * error + 1e-5 * fabs(expected))) {
        fail_msg("%s, %s: %.7g +- %.2g, expected %.7g +- %.2g", what, air_term_name((air_term)term),
                 got->terms[term], got->errors[term], expected, expected_error);
    }
}

/* A point light of 1 W/sr, two metres above a plane in haze without end, sigma_s 0.3: irradiance at
 * distance x from its foot, by 700,000 independent walks [Dubouchet2019, our reading, section 8].
 */
typedef struct foot_row {
    float x;
    bool floor; /* a black one */
    double direct, once, once_error, more, more_error;
} foot_row;

static const foot_row foot_rows[] = {
    {0.0f, false, 1.37203e-01, 7.2197e-02, 9e-05, 8.4738e-02, 1e-04},
    {2.0f, false, 3.78341e-02, 2.7815e-02, 4e-05, 5.4569e-02, 1e-04},
    {0.0f, true, 1.37203e-01, 7.2180e-02, 9e-05, 7.3148e-02, 1e-04},
    {2.0f, true, 3.78341e-02, 2.7754e-02, 4e-05, 4.4868e-02, 1e-04},
};
enum { FOOT_ROWS = sizeof foot_rows / sizeof foot_rows[0] };

static air_snapshot *foot_scene(void **state, bool floor)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium;
    air_medium_desc_default(&medium);
    medium.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    set3(medium.sigma_s, 0.3f, 0.3f, 0.3f);
    add_medium(scene, &medium);
    add_point_light(scene, vec3(0, 2, 0), 1.0f);
    if (floor) {
        add_floor(scene, 0.0f, 100.0f, add_lambert(scene, 0.0f, 0.0f));
    }
    return path_freeze(scene);
}

static void light_over_a_plane_in_haze(void **state)
{
    for (int i = 0; i < FOOT_ROWS; i++) {
        const foot_row *row = &foot_rows[i];
        const air_path_receiver receiver = looking_up(vec3(row->x, 0, 0));
        air_snapshot *snapshot = foot_scene(state, row->floor);
        air_path_settings settings = everything;
        settings.max_depth = 11; /* ten events in the haze, and the receiver */
        const received got = receive(snapshot, &receiver, &settings, 8192);
        assert_term("direct", &got, AIR_TERM_S0, row->direct, 5e-7, 1e-6);
        assert_term("one event", &got, AIR_TERM_M1, row->once, row->once_error, 0.02);
        assert_term("more events", &got, AIR_TERM_M2, row->more, row->more_error, 0.02);
        assert_true(got.terms[AIR_TERM_S_PLUS] == 0.0);
        air_snapshot_release(snapshot);
    }
}

static void gathering_without_a_source_gives_one_event(void **state)
{
    for (int i = 0; i < FOOT_ROWS; i++) {
        const foot_row *row = &foot_rows[i];
        const air_path_receiver receiver = looking_up(vec3(row->x, 0, 0));
        air_snapshot *snapshot = foot_scene(state, row->floor);
        air_path_settings settings = everything;
        settings.media = AIR_PATH_GATHER;
        settings.source.through = true;

        const received got = receive(snapshot, &receiver, &settings, 64);
        assert_term("direct", &got, AIR_TERM_S0, row->direct, 5e-7, 1e-6);
        assert_term("one event", &got, AIR_TERM_M1, row->once, row->once_error, 0.01);
        assert_true(got.terms[AIR_TERM_M2] == 0.0);
        air_snapshot_release(snapshot);
    }
}

static void media_attenuate_or_are_not_there(void **state)
{
    const air_path_receiver receiver = looking_up(vec3(1, 0, 0));
    air_snapshot *snapshot = foot_scene(state, true);
    air_path_settings settings = everything;
    const double clear = 2.0 / pow(5.0, 1.5);
    settings.media = AIR_PATH_IGNORE;
    received got = receive(snapshot, &receiver, &settings, 16);
    assert_term("clear air", &got, AIR_TERM_S0, clear, 0.0, 1e-6);
    settings.media = AIR_PATH_ATTENUATE;
    got = receive(snapshot, &receiver, &settings, 16);
    assert_term("attenuated", &got, AIR_TERM_S0, clear * exp(-0.3 * sqrt(5.0)), 0.0, 1e-6);
    assert_true(got.terms[AIR_TERM_M1] == 0.0 && got.terms[AIR_TERM_M2] == 0.0);
    air_snapshot_release(snapshot);
}

static air_vec3 one(const void *user, air_vec3 position, uint32_t medium, air_vec3 wo, bool lights)
{
    (void)user, (void)position, (void)medium, (void)wo, (void)lights;
    return vec3_set1(1.0f);
}

/* Light of radiance 1 comes from everywhere, through a medium that takes nothing away: irradiance
 * pi, fluence 4 pi, whichever way directions are drawn and media are treated. */
static void assert_furnace(void **state, const air_path_receiver *receiver, air_path_media media,
                           bool through)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(vec3_set1(0.0f), vec3_set1(1.0f));
    set3(medium.sigma_s, 0.9f, 0.9f, 0.9f);
    medium.phase.kind = AIR_PHASE_HG;
    medium.phase.g = 0.6f;
    add_medium(scene, &medium);
    add_environment(scene, 1.0f, 1.0f, 1.0f);
    air_snapshot *snapshot = path_freeze(scene);
    air_path_settings settings = everything;
    settings.media = media;
    settings.source = (air_path_source){one, NULL, through};
    const received got = receive(snapshot, receiver, &settings, 2048);
    const double expected = receiver->sphere ? 4.0 * AIR_PI : AIR_PI;
    double total = 0.0, error = 0.0;
    for (int t = 0; t < AIR_TERM_COUNT; t++) {
        total += got.terms[t];
        error = hypot(error, got.errors[t]);
    }
    /* terms are not independent, but their errors added are an upper bound */
    if (!(error < 0.005 * expected) || !(fabs(total - expected) < 4.0 * error + 1e-5 * expected)) {
        fail_msg("furnace, media %d, through %d: %.6g +- %.2g, expected %.6g", (int)media, through,
                 total, error, expected);
    }
    air_snapshot_release(snapshot);
}

static void receivers_in_a_furnace(void **state)
{
    for (int media = AIR_PATH_SCATTER; media <= AIR_PATH_GATHER; media++) {
        if (media != AIR_PATH_ATTENUATE) {
            air_path_receiver receiver = looking_up(vec3(0.3f, -0.4f, 0.1f));
            assert_furnace(state, &receiver, (air_path_media)media, false);
            receiver.uniform = 0.5f;
            assert_furnace(state, &receiver, (air_path_media)media, false);
            receiver.sphere = true;
            assert_furnace(state, &receiver, (air_path_media)media, false);
        }
    }
}

/* What is asked for by way of one event comes by no other way, and all of it. */
static void one_event_apart_in_a_furnace(void **state)
{
    air_path_receiver receiver = looking_up(vec3(0.3f, -0.4f, 0.1f));
    assert_furnace(state, &receiver, AIR_PATH_SCATTER, true);
    receiver.sphere = true;
    assert_furnace(state, &receiver, AIR_PATH_SCATTER, true);
}

/* In haze without end that absorbs nothing walks end by chance only, and no light is lost: through
 * a sphere about the lamp goes what it sends, so irradiances on both sides of a surface across its
 * light differ by I / r^2, however much light there is. */
static void endless_walks_end_and_lose_nothing(void **state)
{
    air_path_receiver receiver = looking_up(vec3(0, 0, 0));
    air_snapshot *snapshot = foot_scene(state, false);
    air_path_settings settings = everything;
    settings.source.through = true;
    double flux = 0.0, error = 0.0;
    for (int side = 0; side < 2; side++) {
        receiver.normal = receiver.geometric = vec3(0, side == 0 ? 1.0f : -1.0f, 0);
        const received got = receive(snapshot, &receiver, &settings, 512);
        for (int t = 0; t < AIR_TERM_COUNT; t++) {
            flux += side == 0 ? got.terms[t] : -got.terms[t];
            error = hypot(error, got.errors[t]);
        }
    }
    print_message("net flux %.4f +- %.4f, expected 0.25\n", flux, error);
    assert_true(error < 0.01 && fabs(flux - 0.25) < 4.0 * error);
    air_snapshot_release(snapshot);
}

/* What a camera sees of a Lambertian floor is its irradiance times albedo over pi, term by term. */
static void irradiance_is_what_a_camera_sees(void **state)
{
    air_scene *scene = path_scene(state);
    air_medium_desc medium = medium_in_box(vec3(0, 1, 0), vec3(2, 1, 2));
    set3(medium.sigma_s, 0.4f, 0.4f, 0.4f);
    add_medium(scene, &medium);
    add_point_light(scene, vec3(0.3f, 1.5f, 0.2f), 1.0f);
    add_environment(scene, 0.1f, 0.1f, 0.1f);
    const air_handle grey = add_lambert(scene, 0.6f, 0.0f);
    add_floor(scene, 0.0f, 2.0f, grey);
    add_quad(scene, vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 2, 0), grey);
    add_quad(scene, vec3(-1, 0.5f, 1), vec3(0, 1, 0), vec3(0, 0, -1),
             add_lambert(scene, 0.3f, 2.0f));
    air_snapshot *snapshot = path_freeze(scene);
    /* from just above, so that the haze before the floor is nothing */
    const probe_result seen =
        measure_radiance(snapshot, vec3(0.2f, 1e-3f, -0.1f), vec3(0, -1, 0), UINT32_MAX, 8192);
    const air_path_receiver receiver = looking_up(vec3(0.2f, 0, -0.1f));
    const received got = receive(snapshot, &receiver, &everything, 8192);
    const double total = got.terms[0] + got.terms[1] + got.terms[2] + got.terms[3];
    const double error = got.errors[0] + got.errors[1] + got.errors[2] + got.errors[3];
    const double expected = seen.mean[1] / 0.6 * AIR_PI;
    const double slack = 4.0 * (error + seen.error[1] / 0.6 * AIR_PI) + 1e-3 * expected;
    if (!(fabs(total - expected) < slack) || !(slack < 0.05 * expected)) {
        fail_msg("%.6g +- %.2g, a camera says %.6g", total, error, expected);
    }
    assert_true(got.terms[AIR_TERM_S_PLUS] > 0.0 && got.terms[AIR_TERM_M2] > 0.0);
    air_snapshot_release(snapshot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_over_a_plane_in_haze),
        cmocka_unit_test(gathering_without_a_source_gives_one_event),
        cmocka_unit_test(media_attenuate_or_are_not_there),
        cmocka_unit_test(receivers_in_a_furnace),
        cmocka_unit_test(one_event_apart_in_a_furnace),
        cmocka_unit_test(endless_walks_end_and_lose_nothing),
        cmocka_unit_test(irradiance_is_what_a_camera_sees),
    };
    return cmocka_run_group_tests(tests, path_set_up, path_tear_down);
}

/* FLIP against a direct computation of the papers' formulas, and against values of the published
 * evaluator. */
#include "image/flip.h"
#include "image_fixture.h"

enum { MAX_PIXELS = 64 * 48 };

/* Two pictures and their map. */
typedef struct pictures {
    float reference[3][MAX_PIXELS];
    float test[3][MAX_PIXELS];
    float map[MAX_PIXELS];
    size_t width, height;
} pictures;

static air_flip_pair pair_of(const pictures *p, float pixels_per_degree)
{
    air_flip_pair pair = {
        .width = p->width, .height = p->height, .pixels_per_degree = pixels_per_degree};
    for (size_t c = 0; c < 3; c++) {
        pair.reference[c] = p->reference[c];
        pair.test[c] = p->test[c];
    }
    return pair;
}

static double run(image_fixture *self, pictures *p, float pixels_per_degree, bool hdr)
{
    const air_flip_pair pair = pair_of(p, pixels_per_degree);
    assert_int_equal(hdr ? air_flip_hdr(self->context, &pair, p->map)
                         : air_flip_ldr(self->context, &pair, p->map),
                     AIR_OK);
    double sum = 0.0;
    for (size_t i = 0; i < p->width * p->height; i++) {
        assert_true(p->map[i] >= 0.0f && p->map[i] <= 1.0f);
        sum += (double)p->map[i];
    }
    return sum / (double)(p->width * p->height);
}

static void set(pictures *p, size_t i, bool test, double r, double g, double b)
{
    float(*const planes)[MAX_PIXELS] = test ? p->test : p->reference;
    planes[0][i] = (float)r;
    planes[1][i] = (float)g;
    planes[2][i] = (float)b;
}

static void fill_random(image_fixture *self, pictures *p, size_t width, size_t height)
{
    p->width = width;
    p->height = height;
    for (size_t i = 0; i < width * height; i++) {
        for (size_t c = 0; c < 3; c++) {
            p->reference[c][i] = (float)image_fixture_random(self);
            p->test[c][i] = (float)image_fixture_random(self);
        }
    }
}

/* ---- the published evaluator ---- */

/* Patterns of integers, so that they can be made anywhere; `values` below were computed for them
 * with the Python package flip-evaluator 1.7 (evaluate with inputsRGB=False, applyMagma=False and
 * the ppd stated). */
static void make_ldr(pictures *p)
{
    p->width = 64;
    p->height = 48;
    for (size_t i = 0; i < MAX_PIXELS; i++) {
        const size_t x = i % 64;
        const size_t y = i / 64;
        const double r = (double)((7 * x + 3 * y) % 64) / 63.0;
        const double g = (x / 8 + y / 8) % 2 == 1 ? 0.8 : 0.1;
        const double b = (double)y / 47.0;
        set(p, i, false, r, g, b);
        set(p, i, true, 0.9 * r + 0.025 * (double)(x * y % 5), x >= 32 ? 0.75 * g : g, b);
        if (x >= 20 && x < 23 && y >= 10 && y < 13) {
            set(p, i, true, 1.0, 1.0, 1.0);
        }
    }
    set(p, 30 * 64 + 40, true, 0.0, 0.0, 0.0);
}

static void make_hdr(pictures *p)
{
    p->width = 64;
    p->height = 48;
    for (size_t i = 0; i < MAX_PIXELS; i++) {
        const size_t x = i % 64;
        const size_t y = i / 64;
        const double r = exp2((double)((5 * x + y) % 17) - 6.0);
        const double g = 0.5 + (double)(x * y % 9);
        const double b = 0.25 * (double)(1 + x / 16);
        const double f = x / 4 % 2 == 0 ? 1.25 : 1.0;
        set(p, i, false, r, g, b);
        set(p, i, true, f * r, f * g, f * b);
    }
    set(p, 20 * 64 + 30, true, 500.0, 500.0, 500.0);
}

static void flip_agrees_with_the_published_evaluator(void **state)
{
    static const size_t places[6] = {
        0, 11 * 64 + 21, 30 * 64 + 40, 24 * 64 + 32, 47 * 64 + 63, 20 * 64 + 30};
    static const struct {
        bool hdr;
        float pixels_per_degree;
        double mean, values[6];
    } cases[4] = {
        {false,
         67.0206f,
         0.274749756,
         {0.037538890, 0.572846174, 0.415026158, 0.440542996, 0.172522366, 0.091177337}},
        {false,
         20.0f,
         0.275880700,
         {0.009157064, 0.928438365, 0.971529186, 0.617750227, 0.186572164, 0.090377592}},
        {true,
         67.0206f,
         0.189201705,
         {0.305246741, 0.132496506, 0.206359521, 0.218293801, 0.072492220, 0.654472113}},
        {true,
         20.0f,
         0.201643113,
         {0.320781350, 0.018738626, 0.363079935, 0.307507753, 0.0, 0.985777557}},
    };
    pictures *p = calloc(1, sizeof(*p));
    for (size_t i = 0; i < 4; i++) {
        if (cases[i].hdr) {
            make_hdr(p);
        } else {
            make_ldr(p);
        }
        const double mean = run(*state, p, cases[i].pixels_per_degree, cases[i].hdr);
        /* Both are computed in float. A rounding of 1e-7 in a feature difference near 0 changes the
         * exponent by its square root, 3e-4, and values d by up to 3e-4 d log d, 1e-4 at most; only
         * where the difference is that near 0. Elsewhere, and in the mean, 1e-5. */
        assert_true(fabs(mean - cases[i].mean) < 1e-5);
        for (size_t k = 0; k < 6; k++) {
            assert_true(fabs((double)p->map[places[k]] - cases[i].values[k]) < 1e-4);
        }
    }
    free(p);
}

static void exposures_agree_with_the_published_evaluator(void **state)
{
    image_fixture *self = *state;
    pictures *p = calloc(1, sizeof(*p));
    make_hdr(p);
    air_flip_pair pair = pair_of(p, 67.0206f);
    double start = 0.0;
    double stop = 0.0;
    size_t count = 0;
    assert_int_equal(
        air_flip_exposures(self->context, pair.reference, MAX_PIXELS, &start, &stop, &count),
        AIR_OK);
    /* Obtained as above; the evaluator computes in float. */
    assert_true(fabs(start - -6.72311544) < 1e-5 && fabs(stop - -1.28021026) < 1e-5);
    assert_int_equal(count, 6);
    /* Black in more than half of the picture: the median is taken as float's epsilon. */
    for (size_t i = 0; i < MAX_PIXELS; i++) {
        if (i % 64 < 40) {
            set(p, i, false, 0.0, 0.0, 0.0);
            set(p, i, true, 0.0, 0.0, 0.0);
        }
    }
    assert_int_equal(
        air_flip_exposures(self->context, pair.reference, MAX_PIXELS, &start, &stop, &count),
        AIR_OK);
    assert_true(fabs(start - -6.72311544) < 1e-5 && fabs(stop - 24.0832977) < 1e-5);
    assert_int_equal(count, 31);
    assert_true(fabs(run(self, p, 67.0206f, true) - 0.07876327) < 1e-5);
    free(p);
}

static void even_pictures_have_the_published_colour_differences(void **state)
{
    /* Obtained as above from pictures of 8 x 8 equal pixels; no features, so these are colour
     * differences alone. */
    static const struct {
        double a[3], b[3], value;
    } cases[4] = {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.967388213},
                  {{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, 1.0},
                  {{0.2, 0.2, 0.2}, {0.3, 0.2, 0.1}, 0.362072498},
                  {{0.5, 0.5, 0.5}, {0.51, 0.5, 0.5}, 0.040317383}};
    pictures *p = calloc(1, sizeof(*p));
    p->width = p->height = 8;
    for (size_t k = 0; k < 4; k++) {
        for (size_t i = 0; i < 64; i++) {
            set(p, i, false, cases[k].a[0], cases[k].a[1], cases[k].a[2]);
            set(p, i, true, cases[k].b[0], cases[k].b[1], cases[k].b[2]);
        }
        assert_true(fabs(run(*state, p, 67.0206f, false) - cases[k].value) < 2e-5);
    }
    free(p);
}

/* ---- a direct computation: double precision, filters in two dimensions, matrices from the
 * primaries ---- */

typedef struct direct_pixel {
    double opponent[3], lab[3], edge, point;
} direct_pixel;

/* Linear Rec. 709 to XYZ relative to white: X/Xn etc. Primaries (0.64,0.33) (0.30,0.60)
 * (0.15,0.06), white point (0.31271, 0.32902); solved by Cramer's rule. m is 3 x 3, row-major. */
static double determinant(const double m[9])
{
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
           m[2] * (m[3] * m[7] - m[4] * m[6]);
}

static void solve(const double m[9], const double right[3], double out[3])
{
    for (size_t k = 0; k < 3; k++) {
        double replaced[9];
        memcpy(replaced, m, sizeof(replaced));
        for (size_t row = 0; row < 3; row++) {
            replaced[3 * row + k] = right[row];
        }
        out[k] = determinant(replaced) / determinant(m);
    }
}

static void relative_xyz_matrix(double out[9])
{
    static const double xy[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
    const double white[3] = {0.31271 / 0.32902, 1.0, (1.0 - 0.31271 - 0.32902) / 0.32902};
    double primaries[9];
    for (size_t k = 0; k < 3; k++) {
        primaries[k] = xy[k][0] / xy[k][1];
        primaries[3 + k] = 1.0;
        primaries[6 + k] = (1.0 - xy[k][0] - xy[k][1]) / xy[k][1];
    }
    double scale[3];
    solve(primaries, white, scale);
    for (size_t row = 0; row < 3; row++) {
        for (size_t k = 0; k < 3; k++) {
            out[3 * row + k] = primaries[3 * row + k] * scale[k] / white[row];
        }
    }
}

static double cie_f(double t)
{
    return t > pow(6.0 / 29.0, 3.0) ? cbrt(t) : t * 841.0 / 108.0 + 4.0 / 29.0;
}

static void direct_lab(const double matrix[9], const double rgb[3], double out[3])
{
    double f[3];
    for (size_t row = 0; row < 3; row++) {
        double sum = 0.0;
        for (size_t k = 0; k < 3; k++) {
            sum += matrix[3 * row + k] * fmin(fmax(rgb[k], 0.0), 1.0);
        }
        f[row] = cie_f(sum);
    }
    out[0] = 116.0 * f[1] - 16.0;
    out[1] = 0.01 * out[0] * 500.0 * (f[0] - f[1]);
    out[2] = 0.01 * out[0] * 200.0 * (f[1] - f[2]);
}

static double direct_distance(const double a[3], const double b[3])
{
    return pow(fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]), 0.7);
}

static size_t clamp_index(long i, size_t size)
{
    return i < 0 ? 0 : (size_t)i < size ? (size_t)i : size - 1;
}

/* The contrast sensitivity filter of one channel at a distance in degrees. */
static double direct_csf(size_t channel, double squared_degrees)
{
    static const double a1[3] = {1.0, 1.0, 34.1};
    static const double b1[3] = {0.0047, 0.0053, 0.04};
    const double pi = 3.14159265358979323846;
    double sum =
        a1[channel] * sqrt(pi / b1[channel]) * exp(-pi * pi * squared_degrees / b1[channel]);
    if (channel == 2) {
        sum += 13.5 * sqrt(pi / 0.025) * exp(-pi * pi * squared_degrees / 0.025);
    }
    return sum;
}

static void direct_colour(const double matrix[9], direct_pixel *pixels, size_t width, size_t height,
                          size_t x, size_t y, double ppd)
{
    const double pi = 3.14159265358979323846;
    const long radius = (long)ceil(3.0 * sqrt(0.04 / (2.0 * pi * pi)) * ppd);
    double filtered[3];
    for (size_t c = 0; c < 3; c++) {
        double sum = 0.0;
        double weights = 0.0;
        for (long j = -radius; j <= radius; j++) {
            for (long i = -radius; i <= radius; i++) {
                const double w = direct_csf(c, (double)(i * i + j * j) / (ppd * ppd));
                const size_t at =
                    clamp_index((long)y + j, height) * width + clamp_index((long)x + i, width);
                sum += w * pixels[at].opponent[c];
                weights += w;
            }
        }
        filtered[c] = sum / weights;
    }
    const double luminance = (filtered[0] + 16.0) / 116.0;
    const double xyz[3] = {luminance + filtered[1] / 500.0, luminance,
                           luminance - filtered[2] / 200.0};
    double rgb[3];
    solve(matrix, xyz, rgb);
    direct_lab(matrix, rgb, pixels[y * width + x].lab);
}

/* Edge (order 1) or point (order 2) strength: the two-dimensional derivative kernels with positive
 * weights summing to 1 and negative ones to -1. */
static double direct_feature(const direct_pixel *pixels, size_t width, size_t height, size_t x,
                             size_t y, double ppd, int order)
{
    const double sigma = 0.5 * 0.082 * ppd;
    const long radius = (long)ceil(3.0 * sigma);
    double sums[2][2] = {{0.0, 0.0}, {0.0, 0.0}}; /* per axis: positive and negative part */
    double weights[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
    for (long j = -radius; j <= radius; j++) {
        for (long i = -radius; i <= radius; i++) {
            const double g = exp(-(double)(i * i + j * j) / (2.0 * sigma * sigma));
            const size_t at =
                clamp_index((long)y + j, height) * width + clamp_index((long)x + i, width);
            const double value = (pixels[at].opponent[0] + 16.0) / 116.0;
            for (size_t axis = 0; axis < 2; axis++) {
                const double d = (double)(axis == 0 ? i : j);
                const double w = order == 1 ? -d * g : (d * d / (sigma * sigma) - 1.0) * g;
                const size_t sign = w < 0.0;
                sums[axis][sign] += fabs(w) * value;
                weights[axis][sign] += fabs(w);
            }
        }
    }
    return hypot(sums[0][0] / weights[0][0] - sums[0][1] / weights[0][1],
                 sums[1][0] / weights[1][0] - sums[1][1] / weights[1][1]);
}

static void direct_analyse(const double matrix[9], float planes[3][MAX_PIXELS], size_t width,
                           size_t height, double ppd, direct_pixel *pixels)
{
    for (size_t i = 0; i < width * height; i++) {
        double t[3] = {0.0, 0.0, 0.0};
        for (size_t k = 0; k < 9; k++) {
            t[k / 3] += matrix[k] * (double)planes[k % 3][i];
        }
        pixels[i].opponent[0] = 116.0 * t[1] - 16.0;
        pixels[i].opponent[1] = 500.0 * (t[0] - t[1]);
        pixels[i].opponent[2] = 200.0 * (t[1] - t[2]);
    }
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            direct_pixel *const pixel = &pixels[y * width + x];
            direct_colour(matrix, pixels, width, height, x, y, ppd);
            pixel->edge = direct_feature(pixels, width, height, x, y, ppd, 1);
            pixel->point = direct_feature(pixels, width, height, x, y, ppd, 2);
        }
    }
}

static double direct_flip(const double matrix[9], const direct_pixel *a, const direct_pixel *b)
{
    static const double green[3] = {0.0, 1.0, 0.0};
    static const double blue[3] = {0.0, 0.0, 1.0};
    double lab_green[3];
    double lab_blue[3];
    direct_lab(matrix, green, lab_green);
    direct_lab(matrix, blue, lab_blue);
    const double largest = direct_distance(lab_green, lab_blue);
    const double d = direct_distance(a->lab, b->lab);
    const double knee = 0.4 * largest;
    const double colour = d < knee ? 0.95 * d / knee : 0.95 + 0.05 * (d - knee) / (largest - knee);
    const double feature =
        sqrt(fmax(fabs(a->edge - b->edge), fabs(a->point - b->point)) / sqrt(2.0));
    return colour > 0.0 ? pow(colour, 1.0 - feature) : 0.0;
}

static void ldr_flip_agrees_with_the_formulas_computed_directly(void **state)
{
    static const float densities[2] = {31.0f, 12.5f};
    pictures *p = calloc(1, sizeof(*p));
    direct_pixel *a = calloc(MAX_PIXELS, sizeof(*a));
    direct_pixel *b = calloc(MAX_PIXELS, sizeof(*b));
    double matrix[9];
    relative_xyz_matrix(matrix);
    fill_random(*state, p, 26, 19);
    for (size_t i = 0; i < 19 * 13; i++) { /* part of the test picture is close to the reference */
        for (size_t c = 0; c < 3; c++) {
            p->test[c][i] = 0.9f * p->reference[c][i] + 0.1f * p->test[c][i];
        }
    }
    for (size_t k = 0; k < 2; k++) {
        (void)run(*state, p, densities[k], false);
        direct_analyse(matrix, p->reference, 26, 19, (double)densities[k], a);
        direct_analyse(matrix, p->test, 26, 19, (double)densities[k], b);
        for (size_t i = 0; i < 26 * 19; i++) {
            const double expected = direct_flip(matrix, &a[i], &b[i]);
            /* Float against double: as in the comparison with the published evaluator. */
            assert_true(fabs((double)p->map[i] - expected) < 1e-4);
        }
    }
    free(b);
    free(a);
    free(p);
}

/* ---- properties ---- */

static void equal_pictures_have_no_error(void **state)
{
    pictures *p = calloc(1, sizeof(*p));
    fill_random(*state, p, 40, 30);
    memcpy(p->test, p->reference, sizeof(p->test));
    assert_true(run(*state, p, 67.0206f, false) == 0.0);
    assert_true(run(*state, p, 67.0206f, true) == 0.0);
    free(p);
}

static void ldr_flip_is_symmetric(void **state)
{
    pictures *p = calloc(1, sizeof(*p));
    pictures *q = calloc(1, sizeof(*q));
    fill_random(*state, p, 40, 30);
    *q = *p;
    memcpy(q->test, p->reference, sizeof(p->test));
    memcpy(q->reference, p->test, sizeof(p->test));
    assert_true(run(*state, p, 67.0206f, false) > 0.0);
    (void)run(*state, q, 67.0206f, false);
    assert_memory_equal(p->map, q->map, 1200 * sizeof(float));
    free(q);
    free(p);
}

static void hdr_flip_does_not_change_when_both_pictures_are_scaled(void **state)
{
    pictures *p = calloc(1, sizeof(*p));
    make_hdr(p);
    const double before = run(*state, p, 67.0206f, true);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < MAX_PIXELS; i++) {
            p->reference[c][i] *= 1024.0f;
            p->test[c][i] *= 1024.0f;
        }
    }
    /* Exposures shift by exactly 10 stops but for rounding in exp2. */
    assert_true(fabs(run(*state, p, 67.0206f, true) - before) < 1e-6);
    free(p);
}

static void errors_seen_from_further_away_are_smaller(void **state)
{
    pictures *p = calloc(1, sizeof(*p));
    p->width = 48;
    p->height = 48;
    for (size_t i = 0; i < 48 * 48; i++) {
        const double noise = (i % 48 + i / 48) % 2 == 0 ? 0.1 : -0.1;
        set(p, i, false, 0.4, 0.4, 0.4);
        set(p, i, true, 0.4 + noise, 0.4 + noise, 0.4 + noise);
    }
    double last = 1.0;
    for (float ppd = 10.0f; ppd < 100.0f; ppd *= 2.0f) {
        const double mean = run(*state, p, ppd, false);
        assert_true(mean < last);
        last = mean;
    }
    free(p);
}

static void pictures_smaller_than_the_filters_are_handled(void **state)
{
    static const size_t sizes[5][2] = {{1, 1}, {1, 40}, {40, 1}, {3, 2}, {15, 15}};
    pictures *p = calloc(1, sizeof(*p));
    for (size_t i = 0; i < 5; i++) {
        fill_random(*state, p, sizes[i][0], sizes[i][1]);
        const double wide = run(*state, p, 1000.0f, false);
        assert_true(wide > 0.0 && wide < 1.0);
        assert_true(run(*state, p, 1.0f, true) > 0.0);
    }
    free(p);
}

static void the_number_of_threads_leaves_no_trace(void **state)
{
    image_fixture *self = *state;
    pictures *p = calloc(1, sizeof(*p));
    float *first = calloc(MAX_PIXELS, sizeof(*first));
    make_hdr(p);
    for (size_t threads = 1; threads <= 4; threads += 3) {
        air_context_params params;
        air_context_params_default(&params);
        params.thread_count = threads;
        air_context *context = NULL;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        const air_flip_pair pair = pair_of(p, 67.0206f);
        assert_int_equal(air_flip_hdr(context, &pair, threads == 1 ? first : p->map), AIR_OK);
        air_context_destroy(context);
    }
    assert_memory_equal(first, p->map, sizeof(p->map));
    assert_true(first[20 * 64 + 30] > 0.0f);
    (void)self;
    free(first);
    free(p);
}

#define WITH_FIXTURE(test)                                                                         \
    cmocka_unit_test_setup_teardown(test, image_fixture_start, image_fixture_finish)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FIXTURE(flip_agrees_with_the_published_evaluator),
        WITH_FIXTURE(exposures_agree_with_the_published_evaluator),
        WITH_FIXTURE(even_pictures_have_the_published_colour_differences),
        WITH_FIXTURE(ldr_flip_agrees_with_the_formulas_computed_directly),
        WITH_FIXTURE(equal_pictures_have_no_error),
        WITH_FIXTURE(ldr_flip_is_symmetric),
        WITH_FIXTURE(hdr_flip_does_not_change_when_both_pictures_are_scaled),
        WITH_FIXTURE(errors_seen_from_further_away_are_smaller),
        WITH_FIXTURE(pictures_smaller_than_the_filters_are_handled),
        WITH_FIXTURE(the_number_of_threads_leaves_no_trace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

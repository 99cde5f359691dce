/* flip.c: FLIP from the formulas of the papers. Convolutions are separable; the pictures are
 * continued beyond their borders by the pixels at the border. */
#include "image/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/vec.h"

/* Enough for 1000 pixels per degree, where the widest filter reaches 136 pixels. */
enum { MAX_RADIUS = 144 };

/* ---- colour [Andersson2020, sec. 4.1] ---- */

/* Linear Rec. 709 to XYZ with the white point x = 0.31271, y = 0.32902, its inverse, and the XYZ of
 * white. */
static const float xyz_from_rgb[9] = {0.412386563f, 0.357591491f, 0.180450491f,
                                      0.212636822f, 0.715182982f, 0.072180197f,
                                      0.019330620f, 0.119197164f, 0.950372587f};
static const float rgb_from_xyz[9] = {3.241003233f,  -1.537398970f, -0.498615882f,
                                      -0.969224252f, 1.875929984f,  0.041554226f,
                                      0.055639420f,  -0.204011206f, 1.057148977f};
static const float white[3] = {0.950428545f, 1.0f, 1.088900371f};

static air_vec3 transform(const float m[9], air_vec3 v)
{
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z);
}

static air_vec3 white_relative(air_vec3 rgb)
{
    const air_vec3 xyz = transform(xyz_from_rgb, rgb);
    return vec3(xyz.x / white[0], xyz.y / white[1], xyz.z / white[2]);
}

/* The linear opponent space Y Cx Cz, in which the spatial filters work. */
static air_vec3 opponent_from_rgb(air_vec3 rgb)
{
    const air_vec3 r = white_relative(rgb);
    return vec3(116.0f * r.y - 16.0f, 500.0f * (r.x - r.y), 200.0f * (r.y - r.z));
}

static air_vec3 rgb_from_opponent(air_vec3 o)
{
    const float y = (o.x + 16.0f) / 116.0f;
    const float x = y + o.y / 500.0f;
    const float z = y - o.z / 200.0f;
    return transform(rgb_from_xyz, vec3(x * white[0], y * white[1], z * white[2]));
}

static float lab_curve(float t)
{
    const float delta = 6.0f / 29.0f;
    return t > delta * delta * delta ? cbrtf(t) : t / (3.0f * delta * delta) + 4.0f / 29.0f;
}

/* CIELAB with the chroma scaled by lightness, for the Hunt effect [Andersson2020, eq. 2]. */
static air_vec3 hunt_lab_from_rgb(air_vec3 rgb)
{
    const air_vec3 r = white_relative(rgb);
    const float fy = lab_curve(r.y);
    const float lightness = 116.0f * fy - 16.0f;
    const float hunt = 0.01f * lightness;
    return vec3(lightness, hunt * 500.0f * (lab_curve(r.x) - fy),
                hunt * 200.0f * (fy - lab_curve(r.z)));
}

/* The HyAB distance: city block in lightness, Euclidean in chroma [Andersson2020, eq. 3]. */
static float hyab(air_vec3 a, air_vec3 b)
{
    const air_vec3 d = vec3_sub(a, b);
    return fabsf(d.x) + sqrtf(d.y * d.y + d.z * d.z);
}

static air_vec3 clamp_unit(air_vec3 v)
{
    return vec3(fminf(fmaxf(v.x, 0.0f), 1.0f), fminf(fmaxf(v.y, 0.0f), 1.0f),
                fminf(fmaxf(v.z, 0.0f), 1.0f));
}

/* ---- filters ---- */

typedef struct kernel {
    float weights[2 * MAX_RADIUS + 1];
    size_t radius;
} kernel;

/* A kernel of f(x), x in pixels from the centre, whose positive weights sum to 1 and whose negative
 * ones to -1. */
static kernel make_kernel(size_t radius, double (*f)(double x, double scale), double scale)
{
    kernel k = {.radius = radius};
    double positive = 0.0;
    double negative = 0.0;
    for (size_t i = 0; i <= 2 * radius; i++) {
        const double w = f((double)i - (double)radius, scale);
        positive += w > 0.0 ? w : 0.0;
        negative += w < 0.0 ? -w : 0.0;
    }
    for (size_t i = 0; i <= 2 * radius; i++) {
        const double w = f((double)i - (double)radius, scale);
        k.weights[i] = (float)(w > 0.0 ? w / positive : w < 0.0 ? w / negative : 0.0);
    }
    return k;
}

static double gaussian(double x, double sigma) { return exp(-x * x / (2.0 * sigma * sigma)); }
static double gaussian_slope(double x, double sigma) { return -x * gaussian(x, sigma); }
static double gaussian_bend(double x, double sigma)
{
    return (x * x / (sigma * sigma) - 1.0) * gaussian(x, sigma);
}

/* The contrast sensitivity of one channel as a sum of two Gaussians over x in degrees:
 * a sqrt(pi/b) exp(-pi^2 x^2 / b) [Andersson2020, eq. 1 and table 1]. */
typedef struct sensitivity {
    double a[2], b[2];
} sensitivity;

enum { SENSITIVITY_COUNT = 3 };
static const sensitivity sensitivities[SENSITIVITY_COUNT] = {
    {{1.0, 0.0}, {0.0047, 1e-5}},  /* achromatic */
    {{1.0, 0.0}, {0.0053, 1e-5}},  /* red-green */
    {{34.1, 13.5}, {0.04, 0.025}}, /* blue-yellow */
};
static const double widest_b = 0.04;

static double sigma_of_b(double b, double pixels_per_degree)
{
    return sqrt(b / (2.0 * AIR_PI * AIR_PI)) * pixels_per_degree;
}

/* The share of Gaussian i in the normalised two-dimensional filter. */
static double gaussian_share(const sensitivity *s, size_t i, size_t radius,
                             double pixels_per_degree)
{
    double mass[2];
    for (size_t j = 0; j < 2; j++) {
        double sum = 0.0;
        for (size_t k = 0; k <= 2 * radius; k++) {
            sum += gaussian((double)k - (double)radius, sigma_of_b(s->b[j], pixels_per_degree));
        }
        mass[j] = s->a[j] * sqrt(AIR_PI / s->b[j]) * sum * sum;
    }
    return mass[i] / (mass[0] + mass[1]);
}

/* One separable convolution: rows of `in` into `scratch`, then columns, `out` += share * result. */
typedef struct convolution {
    size_t width, height;
    const float *in;
    float *scratch;
    float *out;
    const kernel *along_x, *along_y;
    float share;
} convolution;

static void convolve_row(void *user, size_t y, size_t worker)
{
    const convolution *const job = user;
    const kernel *const k = job->along_x;
    const size_t width = job->width;
    const size_t radius = k->radius;
    const float *const in = job->in + y * width;
    float *const out = job->scratch + y * width;
    (void)worker;
    memset(out, 0, width * sizeof(*out));
    const size_t left = radius < width ? radius : width;
    const size_t right = width - left > left ? width - left : left;
    for (size_t i = 0; i <= 2 * radius; i++) {
        const float w = k->weights[i];
        for (size_t x = left; x < right; x++) {
            out[x] += w * in[x + i - radius];
        }
        for (size_t edge = 0; edge < left + (width - right); edge++) {
            const size_t x = edge < left ? edge : edge - left + right;
            const size_t reach = x + i;
            const size_t from = reach < radius ? 0 : reach - radius;
            out[x] += w * in[from < width ? from : width - 1];
        }
    }
}

static void convolve_column(void *user, size_t y, size_t worker)
{
    const convolution *const job = user;
    const kernel *const k = job->along_y;
    const size_t radius = k->radius;
    float *const out = job->out + y * job->width;
    (void)worker;
    for (size_t i = 0; i <= 2 * radius; i++) {
        const float w = job->share * k->weights[i];
        const size_t reach = y + i;
        const size_t from = reach < radius ? 0 : reach - radius;
        const float *const in =
            job->scratch + (from < job->height ? from : job->height - 1) * job->width;
        for (size_t x = 0; x < job->width; x++) {
            out[x] += w * in[x];
        }
    }
}

/* ---- one picture: filtered colour and features ---- */

enum {
    PLANE_L = 0, /* filtered colour, Hunt-adjusted CIELAB */
    PLANE_A = 1,
    PLANE_B = 2,
    PLANE_EDGE = 3, /* squared feature strengths */
    PLANE_POINT = 4,
    PLANE_COUNT = 5
};

typedef struct picture {
    const float *rgb[3];
    float *planes[PLANE_COUNT];
} picture;

typedef struct flip {
    air_context *context;
    size_t width, height;
    double pixels_per_degree;
    picture pictures[2]; /* reference, test */
    float *opponent[3];  /* of the picture at work */
    float *scratch, *feature;
    float *exposed[2][3]; /* HDR: tone-mapped pictures */
    float *storage;
    float *map;
} flip;

typedef struct picture_job {
    const flip *state;
    const picture *pixels;
    float *feature_strength;
} picture_job;

static void opponent_row(void *user, size_t y, size_t worker)
{
    const picture_job *const job = user;
    (void)worker;
    for (size_t i = y * job->state->width; i < (y + 1) * job->state->width; i++) {
        const float *const *rgb = job->pixels->rgb;
        const air_vec3 o = opponent_from_rgb(vec3(rgb[0][i], rgb[1][i], rgb[2][i]));
        job->state->opponent[0][i] = o.x;
        job->state->opponent[1][i] = o.y;
        job->state->opponent[2][i] = o.z;
    }
}

static void lab_row(void *user, size_t y, size_t worker)
{
    const picture_job *const job = user;
    float *const *const planes = job->pixels->planes;
    (void)worker;
    for (size_t i = y * job->state->width; i < (y + 1) * job->state->width; i++) {
        const air_vec3 filtered = vec3(planes[PLANE_L][i], planes[PLANE_A][i], planes[PLANE_B][i]);
        const air_vec3 lab = hunt_lab_from_rgb(clamp_unit(rgb_from_opponent(filtered)));
        planes[PLANE_L][i] = lab.x;
        planes[PLANE_A][i] = lab.y;
        planes[PLANE_B][i] = lab.z;
    }
}

static void square_row(void *user, size_t y, size_t worker)
{
    const picture_job *const job = user;
    (void)worker;
    for (size_t i = y * job->state->width; i < (y + 1) * job->state->width; i++) {
        const float d = job->state->feature[i];
        job->feature_strength[i] += d * d;
    }
}

static void convolve(const flip *state, const float *in, const kernel *along_x,
                     const kernel *along_y, float share, float *out)
{
    convolution job = {.width = state->width,
                       .height = state->height,
                       .in = in,
                       .scratch = state->scratch,
                       .out = out,
                       .along_x = along_x,
                       .along_y = along_y,
                       .share = share};
    air_parallel_for(state->context, state->height, convolve_row, &job);
    air_parallel_for(state->context, state->height, convolve_column, &job);
}

static void filter_colour(const flip *state, const picture *p)
{
    const double ppd = state->pixels_per_degree;
    const size_t radius = (size_t)ceil(3.0 * sigma_of_b(widest_b, ppd));
    const size_t bytes = state->width * state->height * sizeof(float);
    for (size_t c = 0; c < SENSITIVITY_COUNT; c++) {
        memset(p->planes[c], 0, bytes);
        for (size_t i = 0; i < 2; i++) {
            const sensitivity *const s = &sensitivities[c];
            if (s->a[i] > 0.0) {
                const kernel k = make_kernel(radius, gaussian, sigma_of_b(s->b[i], ppd));
                const double share = gaussian_share(s, i, radius, ppd);
                convolve(state, state->opponent[c], &k, &k, (float)share, p->planes[c]);
            }
        }
    }
    picture_job job = {.state = state, .pixels = p};
    air_parallel_for(state->context, state->height, lab_row, &job);
}

/* Edges and points: gradient magnitudes of the first and second derivative of a Gaussian as wide as
 * an edge is seen to be, 0.082 degrees [Andersson2020, sec. 4.2]. */
static void detect_features(const flip *state, const picture *p)
{
    const double sigma = 0.5 * 0.082 * state->pixels_per_degree;
    const size_t radius = (size_t)ceil(3.0 * sigma);
    const size_t bytes = state->width * state->height * sizeof(float);
    const kernel smooth = make_kernel(radius, gaussian, sigma);
    const kernel derivatives[2] = {make_kernel(radius, gaussian_slope, sigma),
                                   make_kernel(radius, gaussian_bend, sigma)};
    for (size_t f = 0; f < 2; f++) {
        picture_job job = {.state = state, .feature_strength = p->planes[PLANE_EDGE + f]};
        memset(job.feature_strength, 0, bytes);
        for (size_t axis = 0; axis < 2; axis++) {
            memset(state->feature, 0, bytes);
            /* Y runs over 116 units from black to white; its offset of 16 has no derivative. */
            convolve(state, state->opponent[0], axis == 0 ? &derivatives[f] : &smooth,
                     axis == 0 ? &smooth : &derivatives[f], 1.0f / 116.0f, state->feature);
            air_parallel_for(state->context, state->height, square_row, &job);
        }
    }
}

static void analyse(const flip *state, const picture *p)
{
    picture_job job = {.state = state, .pixels = p};
    air_parallel_for(state->context, state->height, opponent_row, &job);
    filter_colour(state, p);
    detect_features(state, p);
}

/* ---- the difference ---- */

/* Colour difference in [0,1]: compressed by a power, and the upper part, of which there is too
 * much, squeezed [Andersson2020, sec. 4.1.3]. */
static float colour_difference(air_vec3 a, air_vec3 b, float largest)
{
    const float exponent = 0.7f;
    const float knee = 0.4f * largest;
    const float knee_value = 0.95f;
    const float d = powf(hyab(a, b), exponent);
    return d < knee ? d * (knee_value / knee)
                    : knee_value + (d - knee) / (largest - knee) * (1.0f - knee_value);
}

/* The largest compressed HyAB distance in the sRGB gamut: green against blue. */
static float largest_difference(void)
{
    const air_vec3 green = hunt_lab_from_rgb(vec3(0.0f, 1.0f, 0.0f));
    const air_vec3 blue = hunt_lab_from_rgb(vec3(0.0f, 0.0f, 1.0f));
    return powf(hyab(green, blue), 0.7f);
}

static float feature_difference(const flip *state, size_t i)
{
    float difference = 0.0f;
    for (size_t f = PLANE_EDGE; f <= PLANE_POINT; f++) {
        const float reference = sqrtf(state->pictures[0].planes[f][i]);
        const float test = sqrtf(state->pictures[1].planes[f][i]);
        difference = fmaxf(difference, fabsf(reference - test));
    }
    return fminf(sqrtf(difference / sqrtf(2.0f)), 1.0f);
}

static void difference_row(void *user, size_t y, size_t worker)
{
    const flip *const state = user;
    const float largest = largest_difference();
    (void)worker;
    for (size_t i = y * state->width; i < (y + 1) * state->width; i++) {
        air_vec3 lab[2];
        for (size_t p = 0; p < 2; p++) {
            float *const *const planes = state->pictures[p].planes;
            lab[p] = vec3(planes[PLANE_L][i], planes[PLANE_A][i], planes[PLANE_B][i]);
        }
        const float colour = colour_difference(lab[0], lab[1], largest);
        /* [Andersson2020, eq. 6]; features amplify, also where the colour difference is small, but
         * 0 stays 0. */
        const float value =
            colour > 0.0f ? powf(colour, 1.0f - feature_difference(state, i)) : 0.0f;
        state->map[i] = fmaxf(state->map[i], fminf(value, 1.0f));
    }
}

/* ---- state ---- */

static air_status start(flip *state, air_context *context, const air_flip_pair *pair, bool hdr,
                        float *out_map)
{
    const size_t count = pair->width * pair->height;
    const size_t plane_count = 2 * PLANE_COUNT + 3 + 2 + (hdr ? 6 : 0);
    *state = (flip){.context = context,
                    .width = pair->width,
                    .height = pair->height,
                    .pixels_per_degree = (double)pair->pixels_per_degree,
                    .map = out_map};
    state->storage = air_allocate(context, count * plane_count, sizeof(float));
    if (state->storage == NULL) {
        return air_fail_memory(context, "FLIP");
    }
    float *next = state->storage;
    for (size_t p = 0; p < 2; p++) {
        for (size_t i = 0; i < PLANE_COUNT; i++, next += count) {
            state->pictures[p].planes[i] = next;
        }
        for (size_t c = 0; c < 3 && hdr; c++, next += count) {
            state->exposed[p][c] = next;
        }
        for (size_t c = 0; c < 3; c++) {
            const float *const plane = p == 0 ? pair->reference[c] : pair->test[c];
            state->pictures[p].rgb[c] = hdr ? state->exposed[p][c] : plane;
        }
    }
    for (size_t c = 0; c < 3; c++, next += count) {
        state->opponent[c] = next;
    }
    state->scratch = next;
    state->feature = next + count;
    memset(out_map, 0, count * sizeof(*out_map));
    return AIR_OK;
}

static void accumulate(flip *state)
{
    for (size_t p = 0; p < 2; p++) {
        analyse(state, &state->pictures[p]);
    }
    air_parallel_for(state->context, state->height, difference_row, state);
}

air_status air_flip_ldr(air_context *context, const air_flip_pair *pair, float *out_map)
{
    flip state;
    const air_status status = start(&state, context, pair, false, out_map);
    if (status == AIR_OK) {
        accumulate(&state);
        air_free(context, state.storage);
    }
    return status;
}

/* ---- HDR [Andersson2021] ---- */

/* The ACES film curve (a x^2 + b x) / (c x^2 + d x + e) [Narkowicz2016] with x scaled by 0.6, as
 * HDR-FLIP uses it. */
static const double aces[5] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};

static float tone_map(float x)
{
    const float value = ((float)aces[0] * x + (float)aces[1]) * x /
                        (((float)aces[2] * x + (float)aces[3]) * x + (float)aces[4]);
    return fminf(fmaxf(value, 0.0f), 1.0f);
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

air_status air_flip_exposures(air_context *context, const float *const reference[3],
                              size_t pixel_count, double *out_start, double *out_stop,
                              size_t *out_count)
{
    double *luminance = air_allocate(context, pixel_count, sizeof(*luminance));
    if (luminance == NULL) {
        return air_fail_memory(context, "FLIP");
    }
    for (size_t i = 0; i < pixel_count; i++) {
        const float rgb[3] = {fmaxf(reference[0][i], 0.0f), fmaxf(reference[1][i], 0.0f),
                              fmaxf(reference[2][i], 0.0f)};
        luminance[i] = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
    }
    qsort(luminance, pixel_count, sizeof(*luminance), compare_doubles);
    const double largest = luminance[pixel_count - 1];
    const double median = luminance[pixel_count / 2];
    air_free(context, luminance);
    /* The luminance that the curve maps to 0.85, which counts as bright but not clipped. */
    const double t = 0.85;
    const double a = aces[0] - t * aces[2];
    const double b = aces[1] - t * aces[3];
    const double bright = (-b + sqrt(b * b + 4.0 * a * t * aces[4])) / (2.0 * a);
    const double floor_value =
        1.1920929e-7; /* the smallest luminance considered, float's epsilon */
    *out_start = log2(bright / fmax(largest, floor_value));
    *out_stop = log2(bright / fmax(median, floor_value));
    *out_count = (size_t)fmax(2.0, ceil(*out_stop - *out_start));
    return AIR_OK;
}

typedef struct expose_job {
    const flip *state;
    const air_flip_pair *pair;
    float scale;
} expose_job;

static void expose_row(void *user, size_t y, size_t worker)
{
    const expose_job *const job = user;
    const size_t width = job->state->width;
    (void)worker;
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = y * width; i < (y + 1) * width; i++) {
            const float reference = fmaxf(job->pair->reference[c][i], 0.0f);
            const float test = fmaxf(job->pair->test[c][i], 0.0f);
            job->state->exposed[0][c][i] = tone_map(fminf(reference * job->scale, 1e15f));
            job->state->exposed[1][c][i] = tone_map(fminf(test * job->scale, 1e15f));
        }
    }
}

air_status air_flip_hdr(air_context *context, const air_flip_pair *pair, float *out_map)
{
    double first = 0.0;
    double last = 0.0;
    size_t count = 0;
    air_status status = air_flip_exposures(context, pair->reference, pair->width * pair->height,
                                           &first, &last, &count);
    flip state;
    if (status == AIR_OK) {
        status = start(&state, context, pair, true, out_map);
    }
    if (status != AIR_OK) {
        return status;
    }
    for (size_t i = 0; i < count; i++) {
        const double exposure = first + (last - first) * (double)i / (double)(count - 1);
        expose_job job = {.state = &state, .pair = pair, .scale = (float)exp2(exposure)};
        air_parallel_for(context, pair->height, expose_row, &job);
        accumulate(&state);
    }
    air_free(context, state.storage);
    return AIR_OK;
}

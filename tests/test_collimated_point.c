/* Point and spot lights in convex media: integrals against adaptive quadrature of the definition
 * and against closed forms, samples, cones. */
#include "airlight/point.h"

#include <float.h>
#include <string.h>

#include "chi_square.h"
#include "cmocka_test.h"
#include "core/quadrature.h"
#include "core/random.h"
#include "core/vec.h"
#include "moment_scene.h"

/* cmocka's own compares floats. */
static void assert_near(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected))) {
        fail_msg("%.17g is not %.17g within %g of it", value, expected, relative);
    }
}

/* ---- the definition ---- */

typedef struct situation {
    air_collimated_medium medium;
    air_point_light light;
    double sigma_t, origin[3], dir[3], t_max;
} situation;

static air_collimated_medium box(void)
{
    air_collimated_medium m = {.plane_count = 6};
    for (size_t k = 0; k < 6; k++) {
        m.planes[k][k / 2] = k % 2 == 0 ? 1.0 : -1.0;
        m.planes[k][3] = 1.0;
    }
    return m;
}

/* A ball's tangent planes, of any length of normal. */
static air_collimated_medium polyhedron(air_rng *rng, size_t planes)
{
    air_collimated_medium m = box();
    for (size_t k = 6; k < planes; k++) {
        const double length = uniform(rng, 0.1, 3.0);
        random_unit(rng, m.planes[k]);
        for (int i = 0; i < 3; i++) {
            m.planes[k][i] *= length;
        }
        m.planes[k][3] = length * uniform(rng, 0.6, 0.9);
    }
    m.plane_count = planes;
    return m;
}

static void point_at(const situation *s, double t, double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = s->origin[i] + t * s->dir[i];
    }
}

/* What a segment from x, in the medium, has inside: it ends at the first plane that it crosses. */
static double inside_length(const situation *s, const double x[3], const double p[3])
{
    const double way[3] = {p[0] - x[0], p[1] - x[1], p[2] - x[2]};
    double share = 1.0;
    for (size_t k = 0; k < s->medium.plane_count; k++) {
        const double *n = s->medium.planes[k];
        const double speed = scene_dot(n, way);
        if (speed > 0.0) {
            share = fmin(share, fmax((n[3] - scene_dot(n, x)) / speed, 0.0));
        }
    }
    return share * sqrt(scene_dot(way, way));
}

/* [a, b]: false if the ray misses the medium. */
static bool stretch(const situation *s, double *a, double *b)
{
    *a = 0.0;
    *b = s->t_max;
    for (size_t k = 0; k < s->medium.plane_count; k++) {
        const double *n = s->medium.planes[k];
        const double speed = scene_dot(n, s->dir), t = (n[3] - scene_dot(n, s->origin)) / speed;
        *a = speed < 0.0 ? fmax(*a, t) : *a;
        *b = speed > 0.0 ? fmin(*b, t) : *b;
    }
    return *a < *b;
}

static double falloff(const air_point_light *light, const double x[3])
{
    if (!light->is_spot) {
        return 1.0;
    }
    const double w[3] = {x[0] - light->position[0], x[1] - light->position[1],
                         x[2] - light->position[2]};
    const double cosine = scene_dot(w, light->axis) / sqrt(scene_dot(w, w));
    const double inner = cos(light->inner_cone_rad), outer = cos(light->outer_cone_rad);
    const double y = fmin(fmax((cosine - outer) / fmax(inner - outer, 0.001), 0.0), 1.0);
    return y * y;
}

/* exp(offset) times the integrand times r, which is dt over d asinh((t - foot) / height). */
typedef struct reference {
    const situation *s;
    double a, foot, height, offset;
    double relative; /* when halves agree: 1e-12, or the rounding of depths of up to 10 sigma_t */
    double nodes[16], weights[16];
} reference;

static double reference_integrand(const reference *q, double y)
{
    double x[3];
    /* height 0: the foot lies before the stretch or behind, y = +-log |t - foot|. */
    const double u = q->height > 0.0 ? q->height * sinh(y) : q->foot < q->a ? exp(y) : -exp(-y);
    const double t = q->foot + u, r = sqrt(u * u + q->height * q->height);
    point_at(q->s, t, x);
    return falloff(&q->s->light, x) *
           exp(q->offset -
               q->s->sigma_t * (t - q->a + inside_length(q->s, x, q->s->light.position))) /
           r;
}

static double rule(const reference *q, double y0, double y1)
{
    double sum = 0.0;
    for (int i = 0; i < 16; i++) {
        const double y = 0.5 * (y0 + y1) + 0.5 * (y1 - y0) * q->nodes[i];
        sum += 0.5 * (y1 - y0) * q->weights[i] * reference_integrand(q, y);
    }
    return sum;
}

static double adapt(const reference *q, double y0, double y1, double whole, double tolerance,
                    int depth)
{
    const double middle = 0.5 * (y0 + y1);
    const double left = rule(q, y0, middle), right = rule(q, middle, y1);
    if (fabs(left + right - whole) <= tolerance + q->relative * whole || depth == 0) {
        return left + right;
    }
    return adapt(q, y0, middle, left, tolerance, depth - 1) +
           adapt(q, middle, y1, right, tolerance, depth - 1);
}

/* Where the way to the light ends at two planes at once: all pairs that no third one comes before.
 */
static size_t find_cuts(const situation *s, double begin, double end, double *out)
{
    size_t count = 0;
    out[count++] = begin;
    out[count++] = end;
    for (size_t i = 0; i < s->medium.plane_count; i++) {
        for (size_t k = 0; k < i; k++) {
            const double *m = s->medium.planes[i], *n = s->medium.planes[k];
            const double cm = scene_dot(m, s->light.position) - m[3];
            const double cn = scene_dot(n, s->light.position) - n[3];
            const double t =
                ((m[3] - scene_dot(m, s->origin)) * cn - (n[3] - scene_dot(n, s->origin)) * cm) /
                (scene_dot(m, s->dir) * cn - scene_dot(n, s->dir) * cm);
            if (!(cm > 0.0 && cn > 0.0 && t > begin && t < end)) {
                continue;
            }
            double x[3], way = 0.0;
            point_at(s, t, x);
            for (int c = 0; c < 3; c++) {
                way += (s->light.position[c] - x[c]) * (s->light.position[c] - x[c]);
            }
            const double depth = m[3] - scene_dot(m, x);
            if (sqrt(way) * depth / (depth + cm) <=
                inside_length(s, x, s->light.position) * (1.0 + 1e-9)) {
                out[count++] = t;
            }
        }
    }
    for (size_t i = 1; i < count; i++) {
        for (size_t k = i; k > 0 && out[k - 1] > out[k]; k--) {
            const double moved = out[k];
            out[k] = out[k - 1];
            out[k - 1] = moved;
        }
    }
    return count;
}

static double to_y(const reference *q, double t)
{
    const double u = t - q->foot;
    return q->height > 0.0 ? asinh(u / q->height) : u > 0.0 ? log(u) : -log(-u);
}

/* exp(offset) times the integral over [begin, end] of the stretch: panels between the cuts, each
 * halved until it agrees with its halves to 1e-12; the halves are better than that by far. */
static double reference_integral(const situation *s, double begin, double end, double offset,
                                 double scale)
{
    enum { MOST_CUTS = 1024, LAYERS = 30 };
    reference q = {.s = s, .offset = offset, .relative = 1e-12 + 2e-15 * s->sigma_t};
    double b, cuts[MOST_CUTS];
    (void)stretch(s, &q.a, &b);
    const double *p = s->light.position;
    const double w[3] = {s->origin[0] - p[0], s->origin[1] - p[1], s->origin[2] - p[2]};
    const double cross[3] = {w[1] * s->dir[2] - w[2] * s->dir[1],
                             w[2] * s->dir[0] - w[0] * s->dir[2],
                             w[0] * s->dir[1] - w[1] * s->dir[0]};
    q.foot = -scene_dot(w, s->dir);
    q.height = sqrt(scene_dot(cross, cross));
    air_gauss_legendre(16, q.nodes, q.weights);
    const size_t count = find_cuts(s, begin, end, cuts);
    double total = 0.0;
    for (size_t i = 0; i + 1 < count; i++) {
        /* Layers at the ends: panels that double in length up to the middle. */
        double y0 = to_y(&q, cuts[i]);
        const double last = to_y(&q, cuts[i + 1]), length = last - y0;
        for (int k = 1; k <= 2 * LAYERS; k++) {
            const double y1 = k < LAYERS       ? to_y(&q, cuts[i]) + ldexp(length, k - LAYERS - 1)
                              : k < 2 * LAYERS ? last - ldexp(length, LAYERS - k - 1)
                                               : last;
            total += adapt(&q, y0, y1, rule(&q, y0, y1), 1e-14 * scale, 40);
            y0 = y1;
        }
    }
    return total;
}

/* ---- configurations ---- */

enum {
    LIGHT_INSIDE,
    LIGHT_OUTSIDE,
    LIGHT_FAR,
    LIGHT_BY_A_FACE,  /* within 1e-5 to 0.1, either side */
    LIGHT_BY_THE_RAY, /* 1e-9 to 0.1 from it, anywhere along */
    LIGHT_BEHIND,     /* behind the camera, on the line of the ray */
    LIGHT_BEYOND,     /* on the ray, but a surface is before it */
    LIGHT_PLACES
};

static double log_uniform(air_rng *rng, double low, double high)
{
    return exp(uniform(rng, log(low), log(high)));
}

static situation random_situation(air_rng *rng, int place)
{
    situation s;
    memset(&s, 0, sizeof s);
    s.medium = air_rng_next(rng) % 2 == 0 ? box() : polyhedron(rng, 7 + air_rng_next(rng) % 20);
    s.sigma_t = log_uniform(rng, 0.01, 30.0);
    double target[3], a, b;
    do {
        const double size = air_rng_next(rng) % 2 == 0 ? 0.5 : 4.0;
        for (int i = 0; i < 3; i++) {
            s.origin[i] = uniform(rng, -size, size);
            target[i] = uniform(rng, -0.5, 0.5);
            s.dir[i] = target[i] - s.origin[i];
        }
        scene_normalize(s.dir);
        s.t_max = air_rng_next(rng) % 2 == 0 ? INFINITY : uniform(rng, 0.0, 6.0);
    } while (!stretch(&s, &a, &b));
    double *p = s.light.position, aside[3];
    const double reach = place == LIGHT_INSIDE ? 0.5 : place == LIGHT_FAR ? 1000.0 : 3.0;
    for (int i = 0; i < 3; i++) {
        p[i] = uniform(rng, -reach, reach);
    }
    if (place == LIGHT_BY_A_FACE) {
        p[air_rng_next(rng) % 3] =
            1.0 + (air_rng_next(rng) % 2 == 0 ? 1.0 : -1.0) * log_uniform(rng, 1e-5, 0.1);
    } else if (place == LIGHT_BY_THE_RAY) {
        random_unit(rng, aside);
        const double t = uniform(rng, a - 0.5, b + 0.5), by = log_uniform(rng, 1e-9, 0.1);
        point_at(&s, t, p);
        for (int i = 0; i < 3; i++) {
            p[i] += by * aside[i];
        }
    } else if (place == LIGHT_BEHIND) {
        point_at(&s, -log_uniform(rng, 1e-3, 2.0), p);
    } else if (place == LIGHT_BEYOND) {
        point_at(&s, b + log_uniform(rng, 1e-3, 2.0), p);
    }
    return s;
}

static air_point_profile make_profile(const situation *s, air_point_piece *pieces)
{
    air_point_profile q = {.pieces = pieces, .capacity = AIR_POINT_MAX_PIECES};
    air_point_profile_make(&s->medium, &s->light, s->sigma_t, s->origin, s->dir, s->t_max, &q);
    return q;
}

/* ---- integrals ---- */

static void integrals_are_those_of_the_definition(void **state)
{
    (void)state;
    /* Measured over 5,000 of each: 9.6e-14, 1.2e-12, 2.1e-11, 3.4e-10, 9.8e-14, 1.3e-12, 9.6e-13.
     * Far away lengths have 1e3 times the rounding, 1e-13, times up to 100 in depth; by a face
     * all of the light may come through a layer of 1e-5 / 100 in which N has 9 to 10 digits. */
    static const double tolerance[LIGHT_PLACES] = {1e-12, 1e-11, 1e-10, 2e-9, 1e-12, 1e-11, 1e-11};
    air_rng rng = air_rng_from_keys(2, 1);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    for (int place = 0; place < LIGHT_PLACES; place++) {
        size_t most = 0;
        for (int n = 0; n < 200; n++) {
            const situation s = random_situation(&rng, place);
            double a, b;
            assert_true(stretch(&s, &a, &b));
            const air_point_profile q = make_profile(&s, pieces);
            const double expected = reference_integral(&s, a, b, q.least_depth, q.scaled);
            assert_near(q.scaled, expected, tolerance[place]);
            assert_near(air_point_integral(&q), q.scaled * exp(-q.least_depth), 1e-14);
            most = q.count > most ? q.count : most;
        }
        assert_in_range(most, 2, AIR_POINT_MAX_PIECES / 3);
    }
}

static void spots_are_those_of_the_definition(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 2);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    int lit = 0;
    for (int n = 0; n < 400; n++) {
        situation s = random_situation(&rng, n % 2 == 0 ? LIGHT_INSIDE : LIGHT_OUTSIDE);
        s.light.is_spot = true;
        random_unit(&rng, s.light.axis);
        s.light.outer_cone_rad = n % 7 == 0 ? 0.5 * AIR_PI : uniform(&rng, 0.1, 0.5 * AIR_PI);
        s.light.inner_cone_rad = n % 5 == 0 ? s.light.outer_cone_rad - 1e-3
                                            : s.light.outer_cone_rad * (double)air_rng_float(&rng);
        double a, b;
        assert_true(stretch(&s, &a, &b));
        air_interval cone;
        const air_point_profile q = make_profile(&s, pieces);
        if (!air_point_cone_interval(&s.light, s.origin, s.dir, a, b, &cone)) {
            assert_true(air_point_integral(&q) == 0.0 && q.count == 0);
            continue;
        }
        lit++;
        const double expected =
            reference_integral(&s, cone.begin, cone.end, q.least_depth, q.scaled);
        /* Measured: below 1e-10. */
        assert_near(q.scaled, expected, 1e-9);
    }
    assert_in_range(lit, 100, 380);
}

static void without_extinction_the_integral_is_an_angle(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 3);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    for (int n = 0; n < 1000; n++) {
        situation s = random_situation(&rng, n % 2 == 0 ? LIGHT_INSIDE : LIGHT_OUTSIDE);
        s.sigma_t = 0.0;
        if (n % 3 == 0) {
            s.medium.plane_count = 0;
            s.t_max = INFINITY;
        }
        double a, b, w[3], along = 0.0;
        assert_true(stretch(&s, &a, &b));
        for (int i = 0; i < 3; i++) {
            w[i] = s.light.position[i] - s.origin[i];
            along += w[i] * s.dir[i];
        }
        const double height = sqrt(scene_dot(w, w) - along * along);
        const double angle = atan((b - along) / height) - atan((a - along) / height);
        const air_point_profile q = make_profile(&s, pieces);
        /* The height here is a difference of squares: 1e-16 over its square, which is above 1e-4.
         */
        if (height > 1e-2) {
            assert_near(air_point_integral(&q), angle / height, 1e-11);
        }
    }
}

/* Looking at a light in an endless medium: every way has the same length, so that T is elementary;
 * with a surface before the light it is finite, however near. */
static void on_the_ray_it_is_finite_up_to_the_light(void **state)
{
    (void)state;
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    situation s = {.medium = {.plane_count = 0}, .sigma_t = 0.7, .dir = {0.0, 0.0, 1.0}};
    s.light.position[2] = 2.0;
    for (double gap = 1.0; gap > 1e-10; gap *= 0.1) {
        s.t_max = 2.0 - gap;
        const double left = 2.0 - s.t_max;
        const air_point_profile q = make_profile(&s, pieces);
        assert_near(air_point_integral(&q), exp(-1.4) * (1.0 / left - 0.5), 1e-12);
    }
    s.t_max = 2.0;
    air_point_profile q = make_profile(&s, pieces);
    assert_true(air_point_integral(&q) == INFINITY && air_point_log_integral(&q) == INFINITY);
    assert_true(air_point_partial_integral(&q, 0.0, 1.0) == INFINITY);
    assert_true(air_point_integrand(&q, 1.0) == 0.0);
    s.t_max = INFINITY;
    q = make_profile(&s, pieces);
    assert_true(air_point_integral(&q) == INFINITY);
    /* Behind the camera: exp(-sigma (2 t + gap)) / (t + gap)^2. */
    s.light.position[2] = -0.5;
    q = make_profile(&s, pieces);
    const double expected = reference_integral(&s, 0.0, 60.0, 0.0, 1.0);
    assert_near(air_point_integral(&q), expected, 1e-12);
    /* A spot that shines away from the camera does not light what is before it. */
    s.light.position[2] = 2.0;
    s.light.is_spot = true;
    s.light.axis[1] = 1.0;
    s.light.outer_cone_rad = 0.5;
    q = make_profile(&s, pieces);
    assert_true(air_point_integral(&q) == 0.0);
}

/* From far away a point light is collimated: the box of scene A in closed form. What is left is the
 * light's size in the sky, at most 2 diagonals of 3.5 m over 1e8 m. */
static void a_far_light_is_collimated(void **state)
{
    (void)state;
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    situation s = {.medium = box(), .sigma_t = SCENE_SIGMA_T};
    const double far = 1e8;
    int count = 0;
    for (size_t i = 0; i < 64 * 64; i += 7) {
        scene_pixel p;
        if (!scene_pixel_make(64, i % 64, i / 64, &p)) {
            continue;
        }
        memcpy(s.origin, SCENE_CAMERA, sizeof s.origin);
        memcpy(s.dir, p.dir, sizeof s.dir);
        s.t_max = p.b;
        for (int k = 0; k < 3; k++) {
            s.light.position[k] = far * p.light[k];
        }
        const air_point_profile q = make_profile(&s, pieces);
        assert_near(air_point_integral(&q) * far * far, scene_integral(&p, p.a, p.b), 2e-7);
        count++;
    }
    assert_in_range(count, 300, 585);
}

static void partial_integrals_add_up(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 4);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    for (int n = 0; n < 1000; n++) {
        const situation s = random_situation(&rng, n % LIGHT_PLACES);
        double a, b;
        assert_true(stretch(&s, &a, &b));
        const air_point_profile q = make_profile(&s, pieces);
        const double t = uniform(&rng, a, b);
        const double whole = air_point_integral(&q);
        /* A piece and its parts: the errors above. */
        assert_near(air_point_partial_integral(&q, a - 1.0, t) +
                        air_point_partial_integral(&q, t, b + 1.0),
                    whole, 2e-9);
        assert_true(air_point_partial_integral(&q, b, a) == 0.0);
        assert_near(air_point_log_integral(&q), log(whole), 1e-13);
    }
}

/* However deep: pieces do not run out, nothing is lost. */
static void deep_media_are_no_harder(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 5);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    size_t most = 0;
    for (int n = 0; n < 100; n++) {
        situation s = random_situation(&rng, n % 2 == 0 ? LIGHT_INSIDE : LIGHT_OUTSIDE);
        s.sigma_t = log_uniform(&rng, 30.0, 1e5);
        double a, b;
        assert_true(stretch(&s, &a, &b));
        const air_point_profile q = make_profile(&s, pieces);
        most = q.count > most ? q.count : most;
        /* Depths of up to 1e6 have 1e-10 of rounding, in both; measured over 2,000: 2.6e-9. */
        const double expected = reference_integral(&s, a, b, q.least_depth, q.scaled);
        assert_near(q.scaled, expected, 1e-8);
        assert_true(isfinite(air_point_log_integral(&q)));
    }
    assert_in_range(most, 2, AIR_POINT_MAX_PIECES / 2);
}

/* ---- samples ---- */

static void samples_have_the_density_they_say(void **state)
{
    (void)state;
    enum { BINS = 40, SAMPLES = 20000, CONFIGURATIONS = 210 };
    air_rng rng = air_rng_from_keys(2, 6);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    int unlikely = 0;
    for (int n = 0; n < CONFIGURATIONS; n++) {
        const situation s = random_situation(&rng, n % LIGHT_PLACES);
        const air_point_profile q = make_profile(&s, pieces);
        double observed[BINS] = {0.0}, expected[BINS], total = 0.0;
        const double begin = pieces[0].t0, end = pieces[q.count - 1].t1;
        /* The density over a bin: by the angle of each piece's part of it. */
        for (int i = 0; i < BINS; i++) {
            const double t0 = begin + (end - begin) * i / BINS;
            const double t1 = begin + (end - begin) * (i + 1) / BINS;
            expected[i] = 0.0;
            for (size_t k = 0; k < q.count; k++) {
                const double x0 = fmax(t0, pieces[k].t0), x1 = fmin(t1, pieces[k].t1);
                if (x0 < x1) {
                    const double m = 0.5 * (x0 + x1), u = m - q.foot;
                    const double v0 = x0 - q.foot, v1 = x1 - q.foot, h = q.height;
                    const double angle =
                        h > 0.0 ? atan2(h * (v1 - v0), h * h + v0 * v1) / h : (v1 - v0) / (v0 * v1);
                    expected[i] += SAMPLES * air_point_sample_pdf(&q, m) * (h * h + u * u) * angle;
                }
            }
            total += expected[i];
        }
        assert_near(total, SAMPLES, 1e-9);
        for (int i = 0; i < SAMPLES; i++) {
            const double t = air_point_sample(&q, (double)air_rng_float(&rng));
            assert_true(t >= begin && t <= end);
            const int bin = (int)((t - begin) / (end - begin) * BINS);
            observed[bin < BINS ? bin : BINS - 1] += 1.0;
        }
        unlikely += chi_square_p(observed, expected, BINS, NULL) < 0.01 ? 1 : 0;
    }
    /* 2.1 of 210 are expected; 9 or more have a chance of 3e-4. */
    assert_in_range(unlikely, 0, 8);
}

/* integrand / pdf within a piece changes by exp(3) at most, so that averages converge at once. */
static void samples_leave_little_variance(void **state)
{
    (void)state;
    enum { SAMPLES = 4096 };
    air_rng rng = air_rng_from_keys(2, 7);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    for (int n = 0; n < 210; n++) {
        const situation s = random_situation(&rng, n % LIGHT_PLACES);
        const air_point_profile q = make_profile(&s, pieces);
        double sum = 0.0, squares = 0.0;
        for (int i = 0; i < SAMPLES; i++) {
            const double u = ((double)i + (double)air_rng_float(&rng)) / SAMPLES;
            const double t = air_point_sample(&q, u);
            const double w = air_point_integrand(&q, t) / air_point_sample_pdf(&q, t);
            sum += w / SAMPLES;
            squares += w * w / SAMPLES;
        }
        const double whole = air_point_integral(&q),
                     spread = sqrt(fmax(squares / (sum * sum) - 1.0, 0.0));
        assert_true(spread < 0.9);
        /* Strata: the deviation of a mean is the spread within one, at most spread / 4096 but for
         * the pieces' ends, over 64; single precision of u adds 2^-24. */
        assert_near(sum, whole, 5.0 * 0.9 / 4096.0);
    }
}

/* ---- cones ---- */

static void a_cone_lights_what_is_in_it(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(2, 8);
    for (int n = 0; n < 20000; n++) {
        air_point_light light = {.is_spot = true};
        double origin[3], dir[3];
        random_unit(&rng, light.axis);
        random_unit(&rng, dir);
        for (int i = 0; i < 3; i++) {
            light.position[i] = uniform(&rng, -1.0, 1.0);
            origin[i] = uniform(&rng, -2.0, 2.0);
        }
        light.outer_cone_rad = n % 4 == 0 ? 0.5 * AIR_PI : uniform(&rng, 0.0, 0.5 * AIR_PI);
        if (n % 5 == 0) { /* through the apex */
            for (int i = 0; i < 3; i++) {
                origin[i] = light.position[i] - 1.5 * dir[i];
            }
        }
        if (n % 7 == 0) { /* along the axis */
            memcpy(dir, light.axis, sizeof dir);
        }
        air_interval lit;
        const double last = n % 3 == 0 ? INFINITY : 5.0;
        const bool any = air_point_cone_interval(&light, origin, dir, 0.0, last, &lit);
        for (int i = 0; i < 40; i++) {
            const double t = uniform(&rng, 0.0, 5.0);
            double w[3];
            for (int k = 0; k < 3; k++) {
                w[k] = origin[k] + t * dir[k] - light.position[k];
            }
            const double margin = scene_dot(w, light.axis) / sqrt(scene_dot(w, w)) -
                                  fmax(cos(light.outer_cone_rad), 0.0);
            const bool inside = any && t >= lit.begin && t <= lit.end;
            /* Beside the edge rounding decides; a root of the quadratic has half the digits. */
            assert_true(inside == (margin >= 0.0) || fabs(margin) < 1e-6);
        }
    }
}

/* ---- limits ---- */

static void nothing_is_ever_nan(void **state)
{
    (void)state;
    static const double values[] = {0.0,    1.0,         -1.0, 0.5,      1e-300, 1e300,
                                    -1e-17, 1.0 + 1e-15, NAN,  INFINITY, -2.0,   1e8};
    air_rng rng = air_rng_from_keys(2, 9);
    air_point_piece pieces[AIR_POINT_MAX_PIECES];
    for (int n = 0; n < 100000; n++) {
        situation s = {.medium = box(), .t_max = values[air_rng_next(&rng) % 12]};
        s.sigma_t = fabs(values[air_rng_next(&rng) % 12]);
        s.light.is_spot = n % 2 == 0;
        for (int i = 0; i < 3; i++) {
            const uint32_t range = n % 3 == 0 ? 12u : 4u;
            s.origin[i] = values[air_rng_next(&rng) % range];
            s.light.position[i] = values[air_rng_next(&rng) % range];
        }
        s.dir[air_rng_next(&rng) % 3] = air_rng_next(&rng) % 2 == 0 ? 1.0 : -1.0;
        if (n % 5 == 0) {
            random_unit(&rng, s.dir);
        }
        s.light.axis[air_rng_next(&rng) % 3] = 1.0;
        s.light.outer_cone_rad = n % 8 < 4 ? 0.5 * AIR_PI : 0.3;
        s.light.inner_cone_rad = n % 16 < 8 ? s.light.outer_cone_rad : 0.0;
        const air_point_profile q = make_profile(&s, pieces);
        const double whole = air_point_integral(&q);
        assert_true(whole >= 0.0);
        assert_true(!isnan(air_point_log_integral(&q)));
        assert_true(air_point_partial_integral(&q, 0.1, 0.7) >= 0.0);
        assert_true(air_point_integrand(&q, 0.3) >= 0.0);
        if (q.count > 0) {
            const double t = air_point_sample(&q, (double)air_rng_float(&rng));
            assert_true(t >= pieces[0].t0 && t <= pieces[q.count - 1].t1);
            assert_true(air_point_sample_pdf(&q, t) >= 0.0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integrals_are_those_of_the_definition),
        cmocka_unit_test(spots_are_those_of_the_definition),
        cmocka_unit_test(without_extinction_the_integral_is_an_angle),
        cmocka_unit_test(on_the_ray_it_is_finite_up_to_the_light),
        cmocka_unit_test(a_far_light_is_collimated),
        cmocka_unit_test(partial_integrals_add_up),
        cmocka_unit_test(deep_media_are_no_harder),
        cmocka_unit_test(samples_have_the_density_they_say),
        cmocka_unit_test(samples_leave_little_variance),
        cmocka_unit_test(a_cone_lights_what_is_in_it),
        cmocka_unit_test(nothing_is_ever_nan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

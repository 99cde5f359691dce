/* point_profile.c: cuts a ray into pieces on which the integrand of a point light is smooth.
 *
 * Outside face k the light is at c_k = n_k.p - h_k > 0, a point of the ray at N_k = h_k - n_k.x
 * inside. The way to the light leaves the medium through the face that is first met, where it has
 * gone the share N_k / (N_k + c_k): the one with the smallest N_k / c_k, an affine function of t.
 * So faces follow each other as in an envelope of lines. */
#include <float.h>
#include <math.h>

#include "collimated/point_piece.h"
#include "core/triple.h"

/* Gauss-Legendre of 10 points on [0, 1]: air_gauss_legendre(10), moved there. */
enum { POINTS = 10 };
static const double NODES[POINTS] = {
    0.013046735741414184, 0.067468316655507732, 0.16029521585048778, 0.28330230293537639,
    0.42556283050918442,  0.57443716949081558,  0.71669769706462361, 0.83970478414951222,
    0.93253168334449232,  0.98695326425858587,
};
static const double WEIGHTS[POINTS] = {
    0.033335672154344222, 0.074725674575290266, 0.10954318125799103, 0.13463335965499812,
    0.14776211235737646,  0.14776211235737646,  0.13463335965499812, 0.10954318125799103,
    0.074725674575290266, 0.033335672154344222,
};

/* An affine depth is integrated to 1e-20 up to here (the error term of the rule for exp(-x) is
 * x^21 10!^4 / (21 20!^3)); the room is for the poles beside the piece. */
static const double MOST_DEPTH = 3.0;
/* Near its pole, depth bends too, and may do so while it changes little. */
static const double MOST_BEND = 0.25;
/* Pieces fainter by exp(-40) = 4e-18 need not be smooth. */
static const double FAINT = 40.0;
/* Lengths below this share of min(stretch, 1 / sigma_t) change nothing. */
static const double SMALL = 1e-13;

enum { MOST_CUTS = AIR_COLLIMATED_MAX_PLANES + 8, MOST_HALVINGS = 64 };

double air_point_piece_integral(const air_point_profile *profile, const air_point_piece *piece)
{
    const double u0 = piece->t0 - profile->foot;
    const double angle = air_point_piece_angle(profile, piece);
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        const double u = air_point_offset(profile->height, u0, angle, NODES[i]);
        const double depth = profile->sigma_t * air_point_length(profile, piece, u);
        /* The cap matters only to pieces that are not smooth since there was no room for more. */
        const double power = fmin(profile->least_depth - depth, 600.0);
        sum += WEIGHTS[i] * air_point_falloff(profile, u) * exp(power);
    }
    return angle * sum;
}

/* ---- the medium and the cone ---- */

/* A face as the ray and the light see it. */
typedef struct face {
    double no, nv, c;
} face;

/* The faces that have the light outside, and the stretch of the ray inside all faces. */
static size_t make_faces(const air_collimated_medium *medium, const double position[3],
                         const double origin[3], const double dir[3], double *a, double *b,
                         face *out)
{
    size_t count = 0;
    for (size_t k = 0; k < medium->plane_count; k++) {
        const double *plane = medium->planes[k];
        const face f = {plane[3] - air_dot3(plane, origin), air_dot3(plane, dir),
                        air_dot3(plane, position) - plane[3]};
        if (f.nv > 0.0) {
            *b = fmin(*b, f.no / f.nv);
        } else if (f.nv < 0.0) {
            *a = fmax(*a, f.no / f.nv);
        } else if (f.no < 0.0) {
            *b = -INFINITY;
        }
        if (f.c > 0.0) {
            out[count++] = f;
        }
    }
    return count;
}

/* The stretch within the cone about axis of cosine >= c >= 0: a convex set, so the roots of the
 * quadratic cut [begin, end] into at most three parts, of which those inside lie together. */
static bool cone_interval(const double w[3], const double dir[3], const double axis[3], double c,
                          double begin, double end, air_interval *out)
{
    const double wa = air_dot3(w, axis), va = air_dot3(dir, axis), wv = air_dot3(w, dir),
                 ww = air_dot3(w, w);
    const double alpha = va * va - c * c, beta = wa * va - c * c * wv, gamma = wa * wa - c * c * ww;
    const double s = -(beta + copysign(sqrt(fmax(beta * beta - alpha * gamma, 0.0)), beta));
    double r0 = s / alpha, r1 = gamma / s; /* NaN and infinity cut nothing */
    r0 = r0 > begin && r0 < end ? r0 : begin;
    r1 = r1 > begin && r1 < end ? r1 : begin;
    const double cuts[4] = {begin, fmin(r0, r1), fmax(r0, r1), end};
    bool found = false;
    for (int i = 0; i < 3; i++) {
        /* An infinite end: any point beyond the last root will do. */
        const double t = cuts[i + 1] < INFINITY ? 0.5 * (cuts[i] + cuts[i + 1])
                                                : 2.0 * fabs(cuts[i]) + sqrt(ww) + 1.0;
        const double r = sqrt(ww + t * (2.0 * wv + t));
        if (cuts[i] < cuts[i + 1] && wa + t * va >= c * r) {
            out->begin = found ? out->begin : cuts[i];
            out->end = cuts[i + 1];
            found = true;
        }
    }
    return found;
}

bool air_point_cone_interval(const air_point_light *light, const double origin[3],
                             const double dir[3], double begin, double end, air_interval *out)
{
    if (!(begin < end)) {
        return false;
    }
    if (!light->is_spot) {
        *out = (air_interval){begin, end};
        return true;
    }
    const double *p = light->position;
    const double w[3] = {origin[0] - p[0], origin[1] - p[1], origin[2] - p[2]};
    return cone_interval(w, dir, light->axis, fmax(cos(light->outer_cone_rad), 0.0), begin, end,
                         out);
}

/* ---- where the ray is cut ---- */

/* The stretch of the ray, and where other formulas begin. */
typedef struct plan {
    double cuts[MOST_CUTS]; /* rising, from begin to end */
    face faces[MOST_CUTS];  /* from cuts[i] to cuts[i + 1] */
    size_t count;           /* of stretches */
} plan;

static void add_cut(plan *p, double t)
{
    size_t i = 0;
    while (i <= p->count && p->cuts[i] < t) {
        i++;
    }
    if (i == 0 || i > p->count || p->cuts[i] == t || p->count + 1 >= MOST_CUTS) {
        return;
    }
    for (size_t k = ++p->count; k > i; k--) {
        p->cuts[k] = p->cuts[k - 1];
        p->faces[k - 1] = p->faces[k - 2];
    }
    p->cuts[i] = t;
}

/* The face with the smallest N / c at t; of equal ones that which falls faster. */
static size_t first_face(const face *faces, size_t count, double t)
{
    size_t best = 0;
    for (size_t k = 1; k < count; k++) {
        const double a = fmax(faces[k].no - faces[k].nv * t, 0.0) * faces[best].c;
        const double b = fmax(faces[best].no - faces[best].nv * t, 0.0) * faces[k].c;
        if (a < b || (a == b && faces[k].nv * faces[best].c > faces[best].nv * faces[k].c)) {
            best = k;
        }
    }
    return best;
}

/* Walks the lower envelope of the N / c over [begin, end]: each next face falls faster, so that
 * there are no more stretches than faces. A light inside has its whole way inside: N = 1, c = 0. */
static void plan_faces(plan *p, const face *faces, size_t count, double begin, double end)
{
    p->count = 1;
    p->cuts[0] = begin;
    p->cuts[1] = end;
    p->faces[0] = (face){1.0, 0.0, 0.0};
    if (count == 0) {
        return;
    }
    size_t current = first_face(faces, count, begin);
    p->faces[0] = faces[current];
    for (;;) {
        const face *f = &faces[current];
        double next = end;
        size_t next_face = current;
        for (size_t k = 0; k < count; k++) {
            const double faster = faces[k].nv * f->c - f->nv * faces[k].c;
            if (k == current || !(faster > 0.0)) {
                continue;
            }
            const double t =
                fmax((faces[k].no * f->c - f->no * faces[k].c) / faster, p->cuts[p->count - 1]);
            if (t < next) {
                next = t;
                next_face = k;
            }
        }
        if (next_face == current) {
            return;
        }
        current = next_face;
        if (next > p->cuts[p->count - 1]) {
            p->cuts[p->count++] = next;
            p->cuts[p->count] = end;
        }
        p->faces[p->count - 1] = faces[current];
    }
}

/* ---- pieces ---- */

/* The logarithm of the integral over [u0, u1], roughly: of a part as long as the depth takes to
 * change by a half, and so likely below it. */
static double estimate_log_part(const air_point_profile *q, const air_point_piece *piece, double u0,
                                double u1)
{
    const double depth =
        q->sigma_t * fmax(air_point_length(q, piece, u0), air_point_length(q, piece, u1));
    const double falloff = fmin(air_point_falloff(q, u0), air_point_falloff(q, u1));
    return log(air_point_angle(q->height, u0, u1) * falloff) - depth;
}

/* The best of both ends and the middle of each stretch. */
static double estimate_log(const air_point_profile *q, const plan *p)
{
    double best = -INFINITY;
    for (size_t i = 0; i < p->count; i++) {
        const double u0 = p->cuts[i] - q->foot, u1 = p->cuts[i + 1] - q->foot;
        const double middle = 0.5 * (u0 + u1);
        const double part = fmin(middle - u0, 0.5 / fmax(q->sigma_t, DBL_MIN));
        const air_point_piece piece = {
            .no = p->faces[i].no, .nv = p->faces[i].nv, .c = p->faces[i].c};
        best = fmax(best, estimate_log_part(q, &piece, u0, u0 + part));
        best = fmax(best, estimate_log_part(q, &piece, middle, middle + part));
        best = fmax(best, estimate_log_part(q, &piece, u1 - part, u1));
    }
    return best;
}

/* Is the zero of N + c at least as far from both ends as these are from each other, in angles? By
 * the addition theorem the tangent of the angle between offsets u and v is h (u - v) / (h^2 + u v).
 */
static bool is_clear_of_pole(const air_point_profile *q, const air_point_piece *piece)
{
    const double u0 = piece->t0 - q->foot, u1 = piece->t1 - q->foot;
    const double square = q->height * q->height, pole = piece->no + piece->c - piece->nv * q->foot;
    const double limit = (u1 - u0) / (square + u0 * u1);
    return fabs(pole - piece->nv * u0) >= limit * fabs(piece->nv * square + u0 * pole) &&
           fabs(pole - piece->nv * u1) >= limit * fabs(piece->nv * square + u1 * pole);
}

/* Is the integrand smooth enough on the piece? In the angle it is singular at +-pi/2 and at the
 * zero of N + c; the piece keeps its own length from these, so that the rule converges as
 * (3 + sqrt 8)^-20 = 5e-16. And its depth must not change too much, unless it is too faint to
 * matter. */
static bool is_smooth(const air_point_profile *q, const air_point_piece *piece, double small,
                      double log_integral)
{
    const double u0 = piece->t0 - q->foot, u1 = piece->t1 - q->foot, length = u1 - u0;
    if (length > fmax(fmin(fabs(u0), fabs(u1)), fmax(q->height, small)) ||
        (length > small && !is_clear_of_pole(q, piece))) {
        return false;
    }
    const double e0 = q->sigma_t * air_point_length(q, piece, u0);
    const double e1 = q->sigma_t * air_point_length(q, piece, u1);
    const double middle = q->sigma_t * air_point_length(q, piece, 0.5 * (u0 + u1));
    const double change = fabs(middle - e0) + fabs(e1 - middle);
    const double least = fmin(middle, fmin(e0, e1)) - 0.25 * change;
    return (change <= MOST_DEPTH && fabs(e0 - 2.0 * middle + e1) <= MOST_BEND) ||
           log(air_point_angle(q->height, u0, u1)) - least < log_integral - FAINT;
}

/* Halves stretches until they are smooth. When the array is full they stay as they are. */
static void make_pieces(air_point_profile *q, const plan *p)
{
    const double log_integral = estimate_log(q, p);
    const double stretch = p->cuts[p->count] - p->cuts[0];
    const double small = SMALL * fmin(stretch, 1.0 / fmax(q->sigma_t, DBL_MIN));
    q->least_depth = INFINITY;
    for (size_t i = 0; i < p->count; i++) {
        double ends[MOST_HALVINGS];
        size_t pending = 1;
        ends[0] = p->cuts[i + 1];
        air_point_piece piece = {
            .t0 = p->cuts[i], .no = p->faces[i].no, .nv = p->faces[i].nv, .c = p->faces[i].c};
        while (pending > 0) {
            piece.t1 = ends[pending - 1];
            const double middle = 0.5 * (piece.t0 + piece.t1);
            if (q->count + pending + (p->count - i) < q->capacity && pending < MOST_HALVINGS &&
                middle - q->foot > piece.t0 - q->foot && middle - q->foot < piece.t1 - q->foot &&
                !is_smooth(q, &piece, small, log_integral)) {
                ends[pending++] = middle;
                continue;
            }
            for (int end = 0; end < 3; end++) {
                const double t = end == 0 ? piece.t0 : end == 1 ? middle : piece.t1;
                q->least_depth =
                    fmin(q->least_depth, q->sigma_t * air_point_length(q, &piece, t - q->foot));
            }
            q->pieces[q->count++] = piece;
            piece.t0 = piece.t1;
            pending--;
        }
    }
}

static void integrate_pieces(air_point_profile *q)
{
    q->count = isfinite(q->least_depth) ? q->count : 0;
    for (size_t i = 0; i < q->count; i++) {
        q->pieces[i].before = q->scaled;
        q->pieces[i].integral = air_point_piece_integral(q, &q->pieces[i]);
        q->scaled += q->pieces[i].integral;
    }
    if (!(q->scaled > 0.0 && q->scaled < INFINITY)) {
        q->count = 0;
    }
}

/* Foot, height and falloff. */
static void place_light(air_point_profile *q, const air_point_light *light, const double w[3],
                        const double dir[3])
{
    const double cross[3] = {w[1] * dir[2] - w[2] * dir[1], w[2] * dir[0] - w[0] * dir[2],
                             w[0] * dir[1] - w[1] * dir[0]};
    q->foot = -air_dot3(w, dir);
    q->height = sqrt(air_dot3(cross, cross));
    if (q->height <= 8.0 * DBL_EPSILON * sqrt(air_dot3(w, w)) || q->height < 1e-140) {
        q->height = 0.0; /* on the ray, within the rounding of the products */
    }
    if (light->is_spot) {
        const double outer = cos(light->outer_cone_rad);
        q->axis_slope = air_dot3(dir, light->axis);
        q->axis_foot = air_dot3(w, light->axis) + q->foot * q->axis_slope;
        q->falloff_scale = 1.0 / fmax(0.001, cos(light->inner_cone_rad) - outer);
        q->falloff_offset = -outer * q->falloff_scale;
    }
}

/* An unbounded stretch ends where what is left is below exp(-60) of the rest: from there on the
 * depth alone is more than that at the point nearest to the light, and 60; without extinction
 * where the angle is all but complete. */
static double finite_end(const air_point_profile *q, const face *faces, size_t count)
{
    const double t = fmax(q->begin, q->foot);
    const face f = count > 0 ? faces[first_face(faces, count, t)] : (face){1.0, 0.0, 0.0};
    const air_point_piece piece = {.no = f.no, .nv = f.nv, .c = f.c};
    if (q->sigma_t > 0.0) {
        return q->begin + air_point_length(q, &piece, t - q->foot) + 60.0 / q->sigma_t;
    }
    return t + 1e17 * fmax(q->height, fmax(t - q->foot, 1.0));
}

void air_point_profile_make(const air_collimated_medium *medium, const air_point_light *light,
                            double sigma_t, const double origin[3], const double dir[3],
                            double t_max, air_point_profile *profile)
{
    air_point_profile *q = profile;
    *q = (air_point_profile){.pieces = q->pieces, .capacity = q->capacity, .sigma_t = sigma_t};
    const double *p = light->position;
    const double w[3] = {origin[0] - p[0], origin[1] - p[1], origin[2] - p[2]};
    face faces[AIR_COLLIMATED_MAX_PLANES];
    double a = 0.0, b = t_max;
    const size_t count = make_faces(medium, p, origin, dir, &a, &b, faces);
    air_interval lit;
    if (isnan(t_max) ||
        !(sigma_t >= 0.0 && isfinite(air_dot3(w, w) + air_dot3(dir, dir) + sigma_t) && a < b) ||
        !air_point_cone_interval(light, origin, dir, a, b, &lit)) {
        return;
    }
    q->begin = a;
    place_light(q, light, w, dir);
    if (!(lit.end < INFINITY)) {
        lit.end = fmax(finite_end(q, faces, count), lit.begin * (1.0 + DBL_EPSILON) + DBL_MIN);
    }
    if (q->height == 0.0 && q->foot >= lit.begin && q->foot <= lit.end) {
        q->scaled = INFINITY;
        return;
    }
    plan cuts;
    plan_faces(&cuts, faces, count, lit.begin, lit.end);
    add_cut(&cuts, q->foot);
    if (light->is_spot) {
        air_interval bright; /* where the falloff has reached 1 */
        const double cosine = (1.0 - q->falloff_offset) / q->falloff_scale;
        if (cone_interval(w, dir, light->axis, cosine, lit.begin, lit.end, &bright)) {
            add_cut(&cuts, bright.begin);
            add_cut(&cuts, bright.end);
        }
    }
    make_pieces(q, &cuts);
    integrate_pieces(q);
}

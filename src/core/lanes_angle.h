/* lanes_angle.h: angles of many plane vectors at once. For files that have included lanes_double.h
 * or lanes_float.h.
 *
 * An angle in [0, pi] is halved by algebra: with C, S its cosine and sine, those of its half are (1
 * + |C|) / root and S / root, root = sqrt(2 + 2 |C|), the larger one first where C >= 0. Nothing
 * cancels, so small angles keep their digits. Largest errors, relative to the angle, for every
 * instruction set (tests/test_core_lanes_angle.c): 8e-16 in double, 5e-7 in float. */
#ifndef AIR_CORE_LANES_ANGLE_H
#define AIR_CORE_LANES_ANGLE_H

static inline lanes lanes_bounded(lanes x)
{
    return lanes_min(lanes_max(x, lanes_all((lane_real)LANES_LEAST)),
                     lanes_all((lane_real)LANES_GREATEST));
}

/* A vector of the plane, or a complex number. */
typedef struct lanes_plane {
    lanes x, y;
} lanes_plane;

static inline lanes_plane plane_product(lanes_plane a, lanes_plane b)
{
    return (lanes_plane){lanes_nmadd(a.y, b.y, a.x * b.x), lanes_madd(a.x, b.y, a.y * b.x)};
}

/* Of unit length; what is shorter than the root of LANES_LEAST comes out shorter. */
static inline lanes_plane plane_unit(lanes_plane a)
{
    const lanes inverse = lanes_inverse_root(lanes_bounded(lanes_madd(a.x, a.x, a.y * a.y)));
    return (lanes_plane){a.x * inverse, a.y * inverse};
}

/* At half the angle, which is in [0, pi]. a: unit. */
static inline lanes_plane plane_half(lanes_plane a)
{
    const lanes one = lanes_all(1), far = one + lanes_abs(a.x);
    const lanes inverse = lanes_inverse_root(far + far);
    const lanes larger = far * inverse, smaller = a.y * inverse;
    const lane_mask behind = lanes_less(a.x, lanes_all(0));
    return (lanes_plane){lanes_select(behind, smaller, larger),
                         lanes_select(behind, larger, smaller)};
}

/* The tangent of half the angle, which is in [0, pi - some]. */
static inline lanes plane_half_tangent(lanes_plane a)
{
    return a.y * lanes_inverse(lanes_all(1) + a.x);
}

/* The angle, in [0, pi], given the unit vector at a quarter of it: 8 atan(t), t = tan(angle/8) <=
 * tan(pi/8). atan(t)/t is its interpolant in t^2 at Chebyshev's nodes, off by 1.3e-18 with 12 terms
 * and 6.3e-10 with 6. */
static inline lanes plane_angle_of_quarter(lanes_plane a)
{
    const double many[] = {0.999999999999999999,   -0.333333333333331212,  0.199999999999408915,
                           -0.142857142792502449,  0.111111107449196582,   -0.0909089680906402708,
                           0.0769204533090222495,  -0.0666295181362919009, 0.0584687829733087252,
                           -0.0503510245660155184, 0.0379652574538659362,  -0.0178053972054194452};
    const double few[] = {0.999999999371228156,  -0.333333068930485128, 0.199981830410832056,
                          -0.142395326696489746, 0.105698288064144481,  -0.060263052276584591};
    const lanes t = plane_half_tangent(a), t2 = t * t;
    const double *const c = sizeof(lane_real) == sizeof(double) ? many : few;
    const int last = sizeof(lane_real) == sizeof(double) ? 11 : 5;
    lanes sum = lanes_all((lane_real)c[last]);
    for (int i = last; i-- > 0;) {
        sum = lanes_madd(sum, t2, lanes_all((lane_real)c[i]));
    }
    return lanes_all(8) * t * sum;
}

/* The angle, in [0, pi], of a unit vector. */
static inline lanes plane_angle(lanes_plane a)
{
    return plane_angle_of_quarter(plane_half(plane_half(a)));
}

#endif

/* ltc.c: transformed cosines at any alpha and angle, and over polygons. */
#include <math.h>

#include "airlight/area_ltc.h"
#include "arealight/ltc_table.h"
#include "arealight/polygon.h"

/* A number on an even axis of AIR_LTC_SIDE knots from 0 to 1: the knot before it and the rest. */
static size_t place(double x, double *out_rest)
{
    const double at = (x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0) * (AIR_LTC_SIDE - 1);
    const size_t k = at < AIR_LTC_SIDE - 1 ? (size_t)at : AIR_LTC_SIDE - 2;
    *out_rest = at - (double)k;
    return k;
}

air_area_ltc air_area_ltc_ggx(double alpha, double cos_o)
{
    const double least = sqrt(1e-3);
    double u, v, out[5];
    const size_t i = place((sqrt(alpha > 0.0 ? alpha : 0.0) - least) / (1.0 - least), &u);
    const size_t j = place(sqrt(cos_o < 1.0 ? 1.0 - cos_o : 0.0), &v);
    for (int k = 0; k < 5; k++) {
        const double low =
            (1.0 - v) * (double)air_ltc_table[i][j][k] + v * (double)air_ltc_table[i][j + 1][k];
        const double high = (1.0 - v) * (double)air_ltc_table[i + 1][j][k] +
                            v * (double)air_ltc_table[i + 1][j + 1][k];
        out[k] = (1.0 - u) * low + u * high;
    }
    return (air_area_ltc){out[0], out[1], out[2], out[3], out[4]};
}

/* x along wo's projection on the surface; any direction in it if wo is the normal. */
static void make_frame(const double normal[3], const double wo[3], double x[3], double y[3])
{
    air_along3(wo, -air_dot3(wo, normal), normal, x);
    double length = air_length3(x);
    if (!(length > 1e-9)) {
        const double axis[3] = {fabs(normal[0]) < 0.6, fabs(normal[0]) >= 0.6, 0.0};
        air_along3(axis, -air_dot3(axis, normal), normal, x);
        length = air_length3(x);
    }
    for (int k = 0; k < 3; k++) {
        x[k] /= length;
    }
    air_cross3(normal, x, y);
}

typedef struct transformation {
    const air_area_ltc *ltc;
    const double *normal;
    double x[3], y[3];
} transformation;

static void transform(const transformation *t, const double v[3], double out[3])
{
    const double x = air_dot3(t->x, v), y = air_dot3(t->y, v);
    const double z = air_dot3(t->normal, v);
    out[0] = t->ltc->xx * x + t->ltc->xz * z;
    out[1] = y;
    out[2] = t->ltc->zx * x + t->ltc->zz * z;
}

double air_area_ltc_share(const air_area_ltc *ltc, const double (*polygon)[3], size_t count,
                          const double normal[3], const double wo[3])
{
    static const double up[3] = {0.0, 0.0, 1.0};
    transformation t = {.ltc = ltc, .normal = normal};
    air_cone cone, above, transformed;
    if (!air_cone_make(polygon, count, &cone)) {
        return 0.0;
    }
    air_cone_clip(&cone, normal, &above);
    make_frame(normal, wo, t.x, t.y);
    transformed.count = above.count;
    for (size_t i = 0; i < above.count; i++) {
        transform(&t, above.vertices[i], transformed.vertices[i]);
        transform(&t, above.edges[i], transformed.edges[i]);
    }
    const double share = above.count > 0 ? air_cone_irradiance(&transformed, up) : 0.0;
    return share < 1.0 ? share : 1.0;
}

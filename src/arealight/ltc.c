/* ltc.c: transformed cosines over polygons. */
#include <math.h>

#include "airlight/area_ltc.h"
#include "arealight/polygon.h"

/* x along wo's projection on the surface; any direction in it if wo is the normal. */
static void make_frame(const double normal[3], const double wo[3], double x[3], double y[3])
{
    air_along3(wo, -air_dot3(wo, normal), normal, x);
    const double length = air_length3(x);
    if (!(length > 1e-9)) {
        air_axes_across(normal, x, y);
        return;
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
    /* the surface cuts the fit: what is above it stands for all */
    const double kept = 0.5 * (1.0 + ltc->xx / sqrt(ltc->xx * ltc->xx + ltc->zx * ltc->zx));
    return share < kept ? share / kept : 1.0;
}

/* line.c: where a ray is lit, and quadrature and sampling along it.
 *
 * The light on a ray has a hump near the lamp, of a width given by the lamp's distance from the ray
 * and by its size. Over the angle theta at the lamp,
 *     t = d + h tan(theta),  h^2 = distance^2 + 0.15 area,
 * the hump is about as wide as the rest, also where the ray meets the lamp [Kulla2012; the area's
 * share is ours]. */
#include "arealight/gauss.h"
#include "core/triple.h"

#include "airlight/arealight.h"

/* 0.05 to 0.5 behave alike. */
static const double area_share = 0.15;

/* Starts and ends are in units of h from the lamp's foot on the ray; end may be infinite. */
typedef struct angle_map {
    double begin_t, end_t, height; /* height: h */
    double start, end, angle;
} angle_map;

static angle_map angle_map_make(const air_area_lamp *lamp, const double origin[3],
                                const double dir[3], air_interval interval)
{
    double to_lamp[3], across[3];
    air_subtract3(lamp->centre, origin, to_lamp);
    const double foot = air_dot3(to_lamp, dir);
    air_along3(to_lamp, -foot, dir, across);
    angle_map out = {.begin_t = interval.begin, .end_t = interval.end};
    out.height = sqrt(air_dot3(across, across) + area_share * lamp->area);
    out.start = (interval.begin - foot) / out.height;
    out.end = (interval.end - foot) / out.height;
    /* The difference of the two arcs' tangents: a short interval far away keeps its digits. */
    out.angle = isinf(interval.end) ? atan2(1.0, out.start)
                                    : atan2((interval.end - interval.begin) / out.height,
                                            1.0 + out.start * out.end);
    return out;
}

/* The distance at a share of the angle, counted from the nearer end by the tangent of a sum. */
static double distance_at(const angle_map *self, double share)
{
    const bool from_start = share < 0.5;
    const double angle = (from_start ? share : 1.0 - share) * self->angle;
    const double s = sin(angle), c = cos(angle);
    double t;
    if (from_start) {
        t = self->begin_t +
            self->height * s * (1.0 + self->start * self->start) / (c - self->start * s);
    } else if (isinf(self->end_t)) {
        t = self->begin_t + self->height * (c / s - self->start);
    } else {
        t = self->end_t - self->height * s * (1.0 + self->end * self->end) / (c + self->end * s);
    }
    return t > self->begin_t ? (t < self->end_t ? t : self->end_t) : self->begin_t;
}

/* dt/dtheta */
static double stretch_at(const angle_map *self, double t)
{
    const double place = self->start + (t - self->begin_t) / self->height;
    return self->height * (1.0 + place * place);
}

bool air_area_lit_interval(const air_area_lamp *lamp, const double origin[3], const double dir[3],
                           double t_max, air_interval *out)
{
    air_interval lit = {0.0, t_max};
    if (!lamp->two_sided) {
        double from_lamp[3];
        air_subtract3(origin, lamp->centre, from_lamp);
        const double height = air_dot3(from_lamp, lamp->normal);
        const double rise = air_dot3(dir, lamp->normal), crossing = -height / rise;
        if (rise > 0.0) {
            lit.begin = crossing > 0.0 ? crossing : 0.0;
        } else if (rise < 0.0) {
            lit.end = crossing < t_max ? crossing : t_max;
        } else if (!(height > 0.0)) {
            return false;
        }
    }
    if (!(lit.begin < lit.end)) {
        return false;
    }
    *out = lit;
    return true;
}

static void equal_steps(air_interval interval, size_t count, double *t, double *w)
{
    const double step = (interval.end - interval.begin) / (double)count;
    for (size_t i = 0; i < count; i++) {
        t[i] = interval.begin + step * ((double)i + 0.5);
        w[i] = step;
    }
}

static void over_length(air_interval interval, size_t count, double *t, double *w)
{
    const double half = 0.5 * (interval.end - interval.begin);
    for (size_t i = 0; i < count; i++) {
        t[i] = interval.begin + half * (1.0 + t[i]);
        w[i] *= half;
    }
}

/* Equal shares of 1 - exp(-sigma_t (t - begin)). */
static void over_depth(air_interval interval, double sigma_t, size_t count, double *t, double *w)
{
    const double loss = -expm1(-sigma_t * (interval.end - interval.begin));
    for (size_t i = 0; i < count; i++) {
        const double lost = 0.5 * (1.0 + t[i]) * loss;
        t[i] = interval.begin - log1p(-lost) / sigma_t;
        w[i] *= 0.5 * loss / (sigma_t * (1.0 - lost));
    }
}

static void over_angle(const angle_map *map, size_t count, double *t, double *w)
{
    for (size_t i = 0; i < count; i++) {
        t[i] = distance_at(map, 0.5 * (1.0 + t[i]));
        w[i] *= 0.5 * map->angle * stretch_at(map, t[i]);
    }
}

void air_area_line_nodes(air_area_rule rule, const air_area_lamp *lamp, const double origin[3],
                         const double dir[3], air_interval interval, double sigma_t, size_t count,
                         double *t, double *w)
{
    const bool thin = !(sigma_t * (interval.end - interval.begin) > 1e-12);
    if (!(interval.begin < interval.end)) {
        for (size_t i = 0; i < count; i++) {
            t[i] = interval.begin;
            w[i] = 0.0;
        }
        return;
    }
    if (isinf(interval.end) && (rule != AIR_AREA_OPTICAL || !(sigma_t > 0.0))) {
        rule = AIR_AREA_EQUIANGULAR; /* no other has an answer */
    }
    if (rule == AIR_AREA_RIEMANN) {
        equal_steps(interval, count, t, w);
        return;
    }
    air_area_gauss(count, t, w);
    if (rule == AIR_AREA_GAUSS || (rule == AIR_AREA_OPTICAL && thin)) {
        over_length(interval, count, t, w);
    } else if (rule == AIR_AREA_OPTICAL) {
        over_depth(interval, sigma_t, count, t, w);
    } else {
        const angle_map map = angle_map_make(lamp, origin, dir, interval);
        over_angle(&map, count, t, w);
    }
}

double air_area_sample_distance(const air_area_lamp *lamp, const double origin[3],
                                const double dir[3], air_interval interval, double u,
                                double *out_pdf)
{
    if (!(interval.begin < interval.end)) {
        *out_pdf = 0.0;
        return interval.begin;
    }
    const angle_map map = angle_map_make(lamp, origin, dir, interval);
    const double t = distance_at(&map, u);
    *out_pdf = 1.0 / (map.angle * stretch_at(&map, t));
    return t;
}

/* shadow_convex.c: the stretch of a ray in the shadow of a ball or of a convex polyhedron.
 *
 * Light comes from infinity, so the shadow of a convex body is the body swept away from the light:
 * convex itself, and a ray meets it in one interval. */
#include <math.h>

#include "airlight/shadow.h"
#include "collimated/planes.h"

/* Below this squared length what is left of a unit vector across the light is rounding. */
static const double across_rounding = 1e-30;

static bool clip_to(double begin, double end, air_interval *s)
{
    s->begin = s->begin > begin ? s->begin : begin;
    s->end = s->end < end ? s->end : end;
    return s->begin < s->end;
}

/* Where slope t <= room. */
static bool clip_by_plane(double room, double slope, air_interval *s)
{
    if (slope > 0.0) {
        return clip_to(-INFINITY, room / slope, s);
    }
    if (slope < 0.0) {
        return clip_to(room / slope, INFINITY, s);
    }
    return room >= 0.0;
}

/* Of a circle or sphere of radius r about the origin, the stretch within t_foot +- half, when the
 * line comes as near as `nearest` and moves with squared speed `speed2`. */
static bool chord(double r, double nearest, double t_foot, double speed2, air_interval *out)
{
    if (!(nearest < r)) {
        return false;
    }
    const double half = sqrt((r - nearest) * (r + nearest) / speed2);
    *out = (air_interval){t_foot - half, t_foot + half};
    return true;
}

/* The ray relative to the centre, w + t v. Distances to a line through the centre come from w x v,
 * which does not cancel where the foot of the perpendicular is far away. */
static bool meet_ball(const double w[3], const double v[3], double radius, air_interval *out)
{
    double moment[3];
    air_cross3(w, v, moment);
    return chord(radius, sqrt(air_dot3(moment, moment)), -air_dot3(w, v), 1.0, out);
}

/* v without its part along l. The second pass removes the rounding that the first one leaves, which
 * counts where v is nearly along l. */
static void across(const double v[3], const double l[3], double out[3])
{
    for (int pass = 0; pass < 2; pass++) {
        const double *from = pass == 0 ? v : out, up = air_dot3(from, l);
        for (int i = 0; i < 3; i++) {
            out[i] = from[i] - up * l[i];
        }
    }
}

/* The half cylinder below the centre: distance to the axis {s l} at most the radius, height x.l at
 * most 0. */
static bool meet_half_cylinder(const double w[3], const double v[3], const double l[3],
                               double radius, air_interval *out)
{
    double w_across[3], v_across[3], moment[3];
    across(w, l, w_across);
    across(v, l, v_across);
    const double speed2 = air_dot3(v_across, v_across);
    *out = (air_interval){-INFINITY, INFINITY};
    if (speed2 > across_rounding) {
        air_cross3(w_across, v_across, moment);
        const double nearest = fabs(air_dot3(moment, l)) / sqrt(speed2);
        if (!chord(radius, nearest, -air_dot3(w_across, v_across) / speed2, speed2, out)) {
            return false;
        }
    } else if (!(air_dot3(w_across, w_across) < radius * radius)) {
        return false;
    }
    return clip_by_plane(-air_dot3(w, l), air_dot3(v, l), out);
}

bool air_shadow_sphere(const double center[3], double radius, const double to_light[3],
                       const double origin[3], const double dir[3], double begin, double end,
                       air_interval *out)
{
    const double w[3] = {origin[0] - center[0], origin[1] - center[1], origin[2] - center[2]};
    air_interval ball, tube;
    if (!(begin < end) || !(radius > 0.0 && radius < INFINITY) || !air_finite3(w) ||
        !air_finite3(dir) || !air_finite3(to_light)) {
        return false;
    }
    const bool in_ball = meet_ball(w, dir, radius, &ball);
    const bool in_tube = meet_half_cylinder(w, dir, to_light, radius, &tube);
    if (!in_ball && !in_tube) {
        return false;
    }
    air_interval s = in_ball ? ball : tube;
    if (in_ball && in_tube) { /* their union is convex */
        s.begin = double_min(ball.begin, tube.begin);
        s.end = double_max(ball.end, tube.end);
    }
    if (!clip_to(begin, end, &s)) {
        return false;
    }
    *out = s;
    return true;
}

/* A plane along the ray from x towards the light: from x(t), climbing s stays inside while rise s
 * <= room - speed t. */
typedef struct ray_plane {
    double room, speed, rise;
} ray_plane;

static ray_plane ray_plane_make(const double plane[4], const double to_light[3],
                                const double origin[3], const double dir[3])
{
    const double rise = air_dot3(plane, to_light);
    const bool along = rise * rise <= across_rounding * air_dot3(plane, plane);
    return (ray_plane){plane[3] - air_dot3(plane, origin), air_dot3(plane, dir),
                       along ? 0.0 : rise};
}

/* x is in shadow iff some s >= 0 has rise s <= room - speed t for all planes. Such an s exists iff
 * every upper bound (rise > 0) is at least 0 and at least every lower bound (rise < 0), and planes
 * along the light (rise = 0) hold by themselves: Fourier-Motzkin elimination of s. A pair of planes
 * gives the silhouette plane along the light through their common edge, or a redundant one. */
bool air_shadow_polyhedron(const double (*planes)[4], size_t plane_count, const double to_light[3],
                           const double origin[3], const double dir[3], double begin, double end,
                           air_interval *out)
{
    air_interval s = {begin, end};
    if (!(begin < end) || !air_finite3(to_light) || !air_finite3(origin) || !air_finite3(dir)) {
        return false;
    }
    for (size_t i = 0; i < plane_count; i++) {
        const ray_plane upper = ray_plane_make(planes[i], to_light, origin, dir);
        if (upper.rise < 0.0) {
            continue;
        }
        if (!clip_by_plane(upper.room, upper.speed, &s)) {
            return false;
        }
        for (size_t j = 0; j < plane_count && upper.rise > 0.0; j++) {
            const ray_plane lower = ray_plane_make(planes[j], to_light, origin, dir);
            if (lower.rise < 0.0 &&
                !clip_by_plane(lower.room * upper.rise - upper.room * lower.rise,
                               lower.speed * upper.rise - upper.speed * lower.rise, &s)) {
                return false;
            }
        }
    }
    *out = s;
    return true;
}

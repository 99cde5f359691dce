/* profile.c: the optical depth along a ray through one convex medium; integral, part, sampling.
 *
 * Inside the medium the depth at t is sigma_t E(t), E = (t - a) + d_m(t): the way from the entry
 * plus the way to the boundary towards the light. d_m is the least of the distances to the faces
 * towards the light, each affine in t, so E is concave and piecewise affine and its exponential has
 * an integral piece by piece [Velinov2021, sec. 4; eq. 6 there lacks 1/(sigma_t c)]. */
#include "collimated/envelope.h"
#include "collimated/pieces.h"
#include "collimated/planes.h"

/* d_m along a ray: the lines of the faces towards the light, and those of the faces through which
 * the ray enters and leaves (count where it does not, or where they do not face the light). */
typedef struct boundary_lines {
    size_t count, enter, exit;
    air_line lines[AIR_COLLIMATED_MAX_PLANES];
} boundary_lines;

static void boundary_lines_make(const air_collimated_medium *medium, const double to_light[3],
                                const air_plane_crossings *ray, boundary_lines *out)
{
    size_t count = 0, enter = SIZE_MAX, exit = SIZE_MAX;
    for (size_t k = 0; k < medium->plane_count; k++) {
        const double nl = air_plane_facing(medium->planes[k], to_light);
        if (nl > 0.0) {
            const double inverse = 1.0 / nl;
            out->lines[count] = (air_line){ray->no[k] * inverse, -ray->nv[k] * inverse};
            enter = k == ray->enter ? count : enter;
            exit = k == ray->exit ? count : exit;
            count++;
        }
    }
    out->count = count;
    out->enter = enter < count ? enter : count;
    out->exit = exit < count ? exit : count;
}

/* Appends [t0, t1] with d_m at its ends. */
static void add_piece(air_collimated_profile *profile, double sigma_t, double begin, double t0,
                      double t1, double d0, double d1)
{
    if (t0 < t1) {
        profile->pieces[profile->count++] =
            (air_collimated_piece){.t0 = t0,
                                   .t1 = t1,
                                   .depth0 = sigma_t * ((t0 - begin) + d0),
                                   .depth1 = sigma_t * ((t1 - begin) + d1),
                                   .camera0 = sigma_t * (t0 - begin),
                                   .camera1 = sigma_t * (t1 - begin),
                                   .weight = 1.0};
    }
}

/* Walks the lowest face from one end of the stretch to the other. */
static void add_pieces(air_collimated_profile *profile, double sigma_t, const boundary_lines *faces,
                       double begin, double end)
{
    const air_line *lines = faces->lines;
    const size_t count = faces->count;
    size_t face = faces->enter, last = faces->exit;
    double t = begin, d = 0.0, d_end = 0.0; /* exactly, where the ray crosses such a face */
    if (face == count) {
        face = air_envelope_lowest(lines, count, begin);
        d = double_max(0.0, air_line_at(lines[face], begin));
    }
    if (last == count) {
        last = air_envelope_lowest(lines, count, end);
        d_end = double_max(0.0, air_line_at(lines[last], end));
    }
    while (face != last) {
        double at;
        const size_t next = air_envelope_next(lines, count, face, t, &at);
        if (next == count || !(at < end)) {
            break;
        }
        const double d_at = double_max(0.0, air_envelope_kink(lines[face], lines[next], at));
        add_piece(profile, sigma_t, begin, t, at, d, d_at);
        t = at;
        d = d_at;
        face = next;
    }
    add_piece(profile, sigma_t, begin, t, end, d, d_end);
}

void air_collimated_profile_make(const air_collimated_medium *medium, const double to_light[3],
                                 double sigma_t, const double origin[3], const double dir[3],
                                 double t_max, air_collimated_profile *profile)
{
    air_plane_crossings ray;
    boundary_lines faces;
    air_profile_clear(profile);
    if (!(sigma_t >= 0.0 && sigma_t < INFINITY) || !air_finite3(to_light) || !air_finite3(origin) ||
        !air_finite3(dir) || !air_planes_cross(medium, origin, dir, t_max, &ray)) {
        return;
    }
    if (sigma_t == 0.0) {
        if (ray.end < INFINITY) {
            add_piece(profile, 0.0, ray.begin, ray.begin, ray.end, 0.0, 0.0);
        }
    } else {
        boundary_lines_make(medium, to_light, &ray, &faces);
        if (faces.count == 0) {
            return; /* no light comes through */
        }
        if (ray.end == INFINITY) {
            const size_t face = air_envelope_lowest(faces.lines, faces.count, ray.begin);
            ray.end = ray.begin + double_max(0.0, air_line_at(faces.lines[face], ray.begin)) +
                      AIR_COLLIMATED_OPAQUE / sigma_t;
        }
        add_pieces(profile, sigma_t, &faces, ray.begin, ray.end);
    }
    air_profile_sum(profile);
}

void air_collimated_profile_restrict(const air_collimated_profile *profile,
                                     const air_interval *intervals, size_t interval_count,
                                     air_collimated_profile *out)
{
    air_profile_clear(out);
    for (size_t i = 0, k = 0; i < profile->count && k < interval_count;) {
        const air_collimated_piece *p = &profile->pieces[i];
        const double begin = double_max(p->t0, intervals[k].begin),
                     end = double_min(p->t1, intervals[k].end);
        if (begin < end) {
            out->pieces[out->count++] = air_piece_part(p, begin, end);
        }
        if (p->t1 < intervals[k].end) {
            i++;
        } else {
            k++;
        }
    }
    air_profile_sum(out);
}

double air_collimated_integral(const air_collimated_profile *profile)
{
    return exp(-profile->least_depth) * profile->scaled;
}

double air_collimated_log_integral(const air_collimated_profile *profile)
{
    return profile->count == 0 ? -INFINITY : log(profile->scaled) - profile->least_depth;
}

double air_collimated_partial_integral(const air_collimated_profile *profile, double begin,
                                       double end)
{
    double sum = 0.0;
    for (size_t i = 0; i < profile->count; i++) {
        const air_collimated_piece *p = &profile->pieces[i];
        if (p->t0 < end && p->t1 > begin && begin < end) {
            const air_collimated_piece part = air_piece_part(p, begin, end);
            sum += air_piece_integral(&part, profile->least_depth);
        }
    }
    return exp(-profile->least_depth) * sum;
}

/* The last piece that begins at or before t; 0 if none does. */
static const air_collimated_piece *piece_at(const air_collimated_profile *profile, double t)
{
    size_t low = 0, high = profile->count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (profile->pieces[middle].t0 <= t) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return &profile->pieces[low];
}

/* weight exp(least_depth - depth) */
static double scaled_integrand(const air_collimated_profile *profile, double t)
{
    if (profile->count == 0) {
        return 0.0;
    }
    const air_collimated_piece *p = piece_at(profile, t);
    if (!(t >= p->t0 && t <= p->t1)) {
        return 0.0;
    }
    /* at depths of 1e16 rounding may lead below the least one */
    return p->weight * exp(fmin(profile->least_depth - air_piece_depth(p, t), 0.0));
}

double air_collimated_integrand(const air_collimated_profile *profile, double t)
{
    return exp(-profile->least_depth) * scaled_integrand(profile, t);
}

double air_collimated_sample(const air_collimated_profile *profile, double u)
{
    const double target = u * profile->scaled;
    size_t low = 0, high = profile->count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (profile->pieces[middle].before <= target) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const air_collimated_piece *p = &profile->pieces[low];
    const double after = low + 1 < profile->count ? p[1].before : profile->scaled;
    /* A share of the piece's integral becomes a share of its length, counted from the thinner end:
     * s = -log(1 - r (1 - exp(-x)))/x. */
    const double rise = p->depth1 - p->depth0, x = fabs(rise);
    const double share = (target - p->before) / (after - p->before);
    const double near = share > 0.0 ? (share < 1.0 ? share : 1.0) : 0.0;
    const double r = rise < 0.0 ? 1.0 - near : near;
    const double s = x < 1e-12 ? r : -log1p(-r * x * air_mean_transmittance(x)) / x;
    const double t = p->t0 + (p->t1 - p->t0) * (rise < 0.0 ? 1.0 - s : s);
    return t < p->t1 ? (t > p->t0 ? t : p->t0) : p->t1;
}

double air_collimated_sample_pdf(const air_collimated_profile *profile, double t)
{
    return profile->count == 0 ? 0.0 : scaled_integrand(profile, t) / profile->scaled;
}

double air_collimated_sample_cdf(const air_collimated_profile *profile, double t)
{
    if (profile->count == 0) {
        return 0.0;
    }
    const air_collimated_piece *p = piece_at(profile, t);
    double sum = p->before;
    if (t > p->t0) {
        const air_collimated_piece part = air_piece_part(p, p->t0, t);
        sum += air_piece_integral(&part, profile->least_depth);
    }
    return sum < profile->scaled ? sum / profile->scaled : 1.0;
}

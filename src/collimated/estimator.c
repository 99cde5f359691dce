/* estimator.c: estimators of the light that a ray receives where only visibility is unknown
 * [Velinov2021, sec. 5 and 6]. */
#include "collimated/pieces.h"

/* A point of a profile and the inverse of its density. */
typedef struct placed_sample {
    const air_collimated_piece *piece;
    double s; /* place within the piece, 0 to 1 */
    double per_density;
    double from_camera; /* part of the depth that per_density leaves to cancel: see below */
} placed_sample;

/* Uniform over the pieces. */
static placed_sample place_uniformly(const air_collimated_profile *profile, double u)
{
    const double total = air_profile_length(profile);
    double rest = u * total;
    const air_collimated_piece *p = profile->pieces, *last = p + profile->count - 1;
    for (; p < last && rest >= air_piece_length(p); p++) {
        rest -= air_piece_length(p);
    }
    const double s = rest / air_piece_length(p);
    return (placed_sample){.piece = p, .s = s < 1.0 ? s : 1.0, .per_density = total};
}

/* Pieces that follow each other without a gap in the depth from the camera. */
typedef struct camera_run {
    size_t begin, end;
    double mass; /* exp(base - depth at begin) - exp(base - depth at end) */
} camera_run;

static camera_run camera_run_from(const air_collimated_profile *profile, size_t begin)
{
    const air_collimated_piece *pieces = profile->pieces;
    const double base = pieces[0].camera0, first = pieces[begin].camera0;
    size_t end = begin + 1;
    while (end < profile->count && pieces[end].camera0 == pieces[end - 1].camera1) {
        end++;
    }
    const double near = begin == 0 ? 1.0 : exp(base - first);
    return (camera_run){begin, end, -near * expm1(first - pieces[end - 1].camera1)};
}

/* The sum of all runs' masses. */
static double camera_mass(const air_collimated_profile *profile)
{
    double total = 0.0;
    for (size_t i = 0; i < profile->count;) {
        const camera_run run = camera_run_from(profile, i);
        total += run.mass;
        i = run.end;
    }
    return total;
}

/* In proportion to extinction seen from the camera, sigma exp(-camera depth), truncated to the
 * pieces. The density's exponential is not put into per_density but left as from_camera, to cancel
 * against the integrand's before either underflows. False where no piece has extinction. */
static bool place_by_extinction(const air_collimated_profile *profile, double u, placed_sample *out)
{
    const air_collimated_piece *pieces = profile->pieces;
    const double base = pieces[0].camera0;
    camera_run chosen = camera_run_from(profile, 0);
    const double total = camera_mass(profile);
    if (!(total > 0.0)) {
        return false;
    }
    double rest = u * total;
    while (rest >= chosen.mass && chosen.end < profile->count) {
        rest -= chosen.mass;
        chosen = camera_run_from(profile, chosen.end);
    }
    const double first = pieces[chosen.begin].camera0;
    const double camera = first - log1p(chosen.begin == 0 ? -rest : -rest * exp(first - base));
    size_t i = chosen.begin;
    while (i + 1 < chosen.end && (camera >= pieces[i].camera1)) {
        i++;
    }
    while (i > chosen.begin && !(pieces[i].camera1 > pieces[i].camera0)) {
        i--; /* rounding led past the last piece that extinguishes */
    }
    const double rise = pieces[i].camera1 - pieces[i].camera0;
    const double s = (camera - pieces[i].camera0) / rise;
    out->piece = &pieces[i];
    out->s = s < 1.0 ? (s > 0.0 ? s : 0.0) : 1.0;
    out->per_density = total * air_piece_length(&pieces[i]) / rise;
    out->from_camera = air_piece_interpolate(pieces[i].camera0, pieces[i].camera1, out->s) - base;
    return true;
}

bool air_collimated_estimator_is_ratio(air_collimated_estimator estimator)
{
    return estimator == AIR_COLLIMATED_REES || estimator == AIR_COLLIMATED_REDS;
}

air_collimated_draw air_collimated_estimate(air_collimated_estimator estimator,
                                            const air_collimated_profile *profile, double u)
{
    air_collimated_draw draw = {0.0, 0.0, 0.0};
    if (profile->count == 0) {
        return draw;
    }
    draw.analytic = air_collimated_integral(profile);
    if (estimator == AIR_COLLIMATED_WVDS) {
        draw.t = air_collimated_sample(profile, u);
        draw.unoccluded = draw.analytic;
        return draw;
    }
    placed_sample sample;
    const bool by_extinction = estimator == AIR_COLLIMATED_DS || estimator == AIR_COLLIMATED_REDS;
    if (!by_extinction || !place_by_extinction(profile, u, &sample)) {
        sample = place_uniformly(profile, u);
    }
    const air_collimated_piece *p = sample.piece;
    const double depth = air_piece_interpolate(p->depth0, p->depth1, sample.s);
    draw.t = p->t0 + air_piece_length(p) * sample.s;
    draw.unoccluded = p->weight * sample.per_density * exp(sample.from_camera - depth);
    return draw;
}

double air_collimated_estimate_pdf(air_collimated_estimator estimator,
                                   const air_collimated_profile *profile, double t)
{
    if (estimator == AIR_COLLIMATED_WVDS) {
        return air_collimated_sample_pdf(profile, t);
    }
    const air_collimated_piece *p = profile->pieces, *end = p + profile->count;
    while (p < end && t > p->t1) {
        p++;
    }
    if (p == end || !(t >= p->t0)) {
        return 0.0;
    }
    const bool by_extinction = estimator == AIR_COLLIMATED_DS || estimator == AIR_COLLIMATED_REDS;
    const double mass = by_extinction ? camera_mass(profile) : 0.0;
    if (!(mass > 0.0)) {
        return 1.0 / air_profile_length(profile);
    }
    const double s = (t - p->t0) / air_piece_length(p);
    const double camera = air_piece_interpolate(p->camera0, p->camera1, s);
    return (p->camera1 - p->camera0) / air_piece_length(p) *
           exp(profile->pieces[0].camera0 - camera) / mass;
}

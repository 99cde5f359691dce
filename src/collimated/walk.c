/* walk.c: multiple scattering: a walk whose every segment is a profile. */
#include "airlight/collimated_walk.h"

#include <math.h>

#include "collimated/planes.h"
#include "core/host.h"
#include "core/phase.h"

void air_collimated_walk_params_default(air_collimated_walk_params *params)
{
    *params = (air_collimated_walk_params){.to_light = {0.0, 1.0, 0.0},
                                           .irradiance = 1.0,
                                           .phase = {.kind = AIR_PHASE_ISOTROPIC},
                                           .distance = AIR_COLLIMATED_DISTANCE_MIXTURE,
                                           .max_events = 64,
                                           .roulette = 0.25};
}

static const char *phase_fault(const air_phase *phase)
{
    char buffer[64];
    if (phase->kind == AIR_PHASE_HG && !(fabsf(phase->g) < 1.0f)) {
        return "g must lie between -1 and 1";
    }
    if (phase->kind != AIR_PHASE_MIXTURE) {
        return NULL;
    }
    double sum = 0.0;
    if (phase_mixture_fault(phase->mixture, buffer) != NULL) {
        return "a lobe of the mixture is out of range, or there are too few or too many";
    }
    for (size_t i = 0; i < phase->mixture->lobe_count; i++) {
        sum += (double)phase->mixture->lobes[i].weight;
    }
    return fabs(sum - 1.0) < 1e-5 ? NULL : "the weights of the mixture do not sum to 1";
}

air_status air_collimated_walk_check(air_context *context, const air_collimated_walk_params *params)
{
    const double length2 = air_dot3(params->to_light, params->to_light);
    const char *wrong = NULL;
    if (params->medium == NULL) {
        wrong = "no medium";
    } else if (!(fabs(length2 - 1.0) < 1e-6)) {
        wrong = "to_light is not a unit vector";
    } else if (!(params->sigma_t >= 0.0 && params->sigma_t < INFINITY)) {
        wrong = "sigma_t must be finite and at least 0";
    } else if (!(params->sigma_s >= 0.0 && params->sigma_s <= params->sigma_t)) {
        wrong = "sigma_s must lie between 0 and sigma_t";
    } else if (!(params->irradiance >= 0.0 && params->irradiance < INFINITY)) {
        wrong = "irradiance must be finite and at least 0";
    } else if ((int)params->distance < 0 || params->distance >= AIR_COLLIMATED_DISTANCE_COUNT) {
        wrong = "unknown way to draw distances";
    } else if (!(params->roulette >= 0.0 && params->roulette < INFINITY)) {
        wrong = "roulette must be finite and at least 0";
    } else if (params->own_phase == NULL) {
        wrong = phase_fault(&params->phase);
    }
    return wrong == NULL ? AIR_OK
                         : air_fail(context, AIR_ERROR_ARGUMENT, "collimated walk: %s", wrong);
}

static double phase_value(const air_collimated_walk_params *params, double cos_theta)
{
    const air_collimated_phase *own = params->own_phase;
    return own != NULL ? own->eval(own->user, cos_theta)
                       : (double)phase_eval(params->phase, (float)cos_theta);
}

static double phase_sample(const air_collimated_walk_params *params, double u)
{
    const air_collimated_phase *own = params->own_phase;
    if (own != NULL) {
        return own->sample(own->user, u);
    }
    const air_phase_angle angle = phase_sample_angle(params->phase, (float)u);
    return angle.one_minus_cos < 1.0f ? 1.0 - (double)angle.one_minus_cos
                                      : (double)angle.one_plus_cos - 1.0;
}

/* Turns the unit vector v by the angle, about itself by the azimuth. */
static void turn(double v[3], double cos_theta, double azimuth)
{
    double s[3], t[3];
    air_axes_across(v, s, t);
    const double sin_theta = sqrt(double_max(0.0, (1.0 - cos_theta) * (1.0 + cos_theta)));
    const double cs = sin_theta * cos(azimuth), ct = sin_theta * sin(azimuth);
    double w[3];
    for (int i = 0; i < 3; i++) {
        w[i] = cs * s[i] + ct * t[i] + cos_theta * v[i];
    }
    const double scale = 1.0 / sqrt(air_dot3(w, w)); /* rounding must not grow over many events */
    for (int i = 0; i < 3; i++) {
        v[i] = scale * w[i];
    }
}

/* An event on a segment. With E = (t - a) + d and p the density of t: */
typedef struct event {
    double point[3];
    double transport;  /* exp(-sigma_t (t - a)) / p */
    double unoccluded; /* exp(-sigma_t E) / p */
} event;

static void move(const double origin[3], const double dir[3], double t, double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = origin[i] + t * dir[i];
    }
}

/* Of the density (p_whole + p_extinction)/2, p_whole = exp(M - sigma_t E)/Ts, p_extinction =
 * sigma_t exp(-sigma_t (t - a))/Z: the factor exp(-sigma_t (t - a)) cancels, and what is left needs
 * d only. */
static void place_by_mixture(const air_collimated_walk_params *params,
                             const air_collimated_profile *profile, const double origin[3],
                             const double dir[3], double by_extinction, double u, event *out)
{
    const air_collimated_estimator by = u < 0.5 ? AIR_COLLIMATED_WVDS : AIR_COLLIMATED_DS;
    const double t = air_collimated_estimate(by, profile, u < 0.5 ? 2.0 * u : 2.0 * u - 1.0).t;
    move(origin, dir, t, out->point);
    const double depth = params->sigma_t * air_collimated_boundary_distance(
                                               params->medium, params->to_light, out->point);
    out->transport =
        2.0 / (exp(profile->least_depth - depth) / profile->scaled + 1.0 / by_extinction);
    out->unoccluded = out->transport * exp(-depth);
}

/* Draws the event's place from u. */
static void place(const air_collimated_walk_params *params, const air_collimated_profile *profile,
                  const double origin[3], const double dir[3], double u, event *out)
{
    const air_collimated_piece *pieces = profile->pieces;
    const double begin = pieces[0].t0, length = pieces[profile->count - 1].t1 - begin;
    const double by_extinction =
        -expm1(-params->sigma_t * length) / params->sigma_t; /* Z/sigma_t */
    if (params->distance == AIR_COLLIMATED_DISTANCE_MIXTURE) {
        place_by_mixture(params, profile, origin, dir, by_extinction, u, out);
        return;
    }
    const air_collimated_estimator estimator = (air_collimated_estimator)params->distance;
    const air_collimated_draw draw = air_collimated_estimate(estimator, profile, u);
    move(origin, dir, draw.t, out->point);
    out->unoccluded = draw.unoccluded;
    if (params->distance == AIR_COLLIMATED_DISTANCE_UNIFORM) {
        out->transport = length * exp(-params->sigma_t * (draw.t - begin));
    } else if (params->distance == AIR_COLLIMATED_DISTANCE_EXTINCTION) {
        out->transport = by_extinction;
    } else {
        const double d =
            air_collimated_boundary_distance(params->medium, params->to_light, out->point);
        out->transport = profile->scaled * exp(params->sigma_t * d - profile->least_depth);
    }
}

/* True: the walk goes on. A throughput that is infinite takes a number u closer to 1 than numbers
 * come, and ends it. */
static bool survive(const air_collimated_walk_params *params, double *throughput,
                    double (*random)(void *user), void *random_user)
{
    if (!(*throughput > 0.0 && *throughput < INFINITY)) {
        return false;
    }
    if (*throughput < params->roulette) {
        if (random(random_user) * params->roulette >= *throughput) {
            return false;
        }
        *throughput = params->roulette;
    }
    return true;
}

air_collimated_sums air_collimated_walk(const air_collimated_walk_params *params,
                                        const double origin[3], const double dir[3],
                                        double (*random)(void *user), void *random_user)
{
    const air_collimated_surroundings *around = &params->surroundings;
    air_collimated_piece pieces[AIR_COLLIMATED_MAX_PIECES];
    air_collimated_profile profile = {.pieces = pieces, .capacity = AIR_COLLIMATED_MAX_PIECES};
    air_collimated_sums sums = {0.0, 0.0, 0.0};
    double x[3] = {origin[0], origin[1], origin[2]}, v[3] = {dir[0], dir[1], dir[2]};
    double throughput = 1.0;
    for (size_t k = 0; k < params->max_events && params->sigma_s > 0.0; k++) {
        const double t_max =
            around->surface != NULL ? around->surface(around->user, x, v) : INFINITY;
        air_collimated_profile_make(params->medium, params->to_light, params->sigma_t, x, v, t_max,
                                    &profile);
        if (profile.count == 0) {
            break;
        }
        event e;
        place(params, &profile, x, v, random(random_user), &e);
        const double light = throughput * params->sigma_s * params->irradiance *
                             phase_value(params, air_dot3(v, params->to_light));
        sums.analytic += light * air_collimated_integral(&profile);
        sums.unoccluded += light * e.unoccluded;
        if (around->occluded == NULL || !around->occluded(around->user, e.point)) {
            sums.occluded += light * e.unoccluded;
        }
        throughput *= params->sigma_s * e.transport;
        if (k + 1 == params->max_events || !survive(params, &throughput, random, random_user)) {
            break;
        }
        for (int i = 0; i < 3; i++) {
            x[i] = e.point[i];
        }
        const double cos_theta = phase_sample(params, random(random_user));
        turn(v, cos_theta, 2.0 * AIR_PI * random(random_user));
    }
    return sums;
}

/* inflow.c: the sky that is followed from the box's faces on. */
#include <math.h>
#include <string.h>

#include "core/host.h"
#include "render/ordinates/sources.h"

enum { CHANNELS = 4, ROUNDS = 32 };

/* Parts of the sky brighter than so many times its mean stay beams, for their direction shows; of
 * those half as bright nothing does. */
#define BRIGHT 32.0f

bool ord_inflow_choose(ord_source_list *sources, float asked)
{
    float flux = 0.0f, angle = 0.0f;
    bool any = false;
    for (size_t i = 0; i < sources->count; i++) {
        const ord_source *const s = &sources->items[i];
        flux += s->solid_angle > 0.0f ? vec3_luminance(s->power) : 0.0f;
        angle += s->solid_angle;
    }
    for (size_t i = 0; i < sources->count; i++) {
        ord_source *const s = &sources->items[i];
        const float even = BRIGHT * flux * s->solid_angle;
        const float over = vec3_luminance(s->power) * angle;
        const float rest = even > 0.0f ? 2.0f - 2.0f * over / even : 0.0f;
        s->inflow = s->mode == AIR_ORDINATES_MODE_DOM
                        ? asked * float_min(float_max(rest, 0.0f), 1.0f)
                        : 0.0f;
        any = any || s->inflow > 0.0f;
    }
    return any;
}

/* How parts of the sky are shared out among the solver's directions: a matrix whose rows, one for
 * each part, sum to 1. */
typedef struct sharing {
    size_t parts, directions;
    double *share;                  /* [part][direction] */
    double (*dir)[3], *solid_angle; /* of directions */
    double *angle;                  /* of parts, so that they sum to 4 pi */
} sharing;

/* By distance: exp(kappa (cos - 1)), as wide as directions lie apart. */
static void share_by_distance(const ord_source_list *sources, sharing *self)
{
    const double kappa = 0.5 * (double)self->directions;
    for (size_t i = 0, part = 0; i < sources->count; i++) {
        const ord_source *const s = &sources->items[i];
        if (!(s->inflow > 0.0f)) {
            continue;
        }
        for (size_t o = 0; o < self->directions; o++) {
            const double cosine = self->dir[o][0] * (double)s->place.x +
                                  self->dir[o][1] * (double)s->place.y +
                                  self->dir[o][2] * (double)s->place.z;
            self->share[part * self->directions + o] =
                self->solid_angle[o] * exp(kappa * (cosine - 1.0));
        }
        self->angle[part++] = (double)s->solid_angle;
    }
}

static void scale_rows(sharing *self)
{
    for (size_t p = 0; p < self->parts; p++) {
        double *const row = self->share + p * self->directions, sum = 0.0;
        for (size_t o = 0; o < self->directions; o++) {
            sum += row[o];
        }
        for (size_t o = 0; o < self->directions && sum > 0.0; o++) {
            row[o] /= sum;
        }
    }
}

/* Columns and rows in turn [Sinkhorn1967], so that an even sky is even radiance; rows last, so that
 * no light is lost. Directions that have too little are left so: where the sky is black or its
 * parts are beams nothing comes from. */
static void balance(sharing *self)
{
    double angle = 0.0;
    for (size_t p = 0; p < self->parts; p++) {
        angle += self->angle[p];
    }
    const double skies = fmax(1.0, angle / (4.0 * AIR_PI));
    scale_rows(self);
    for (int round = 0; round < ROUNDS; round++) {
        for (size_t o = 0; o < self->directions; o++) {
            double sum = 0.0;
            for (size_t p = 0; p < self->parts; p++) {
                sum += self->angle[p] * self->share[p * self->directions + o];
            }
            const double most = skies * self->solid_angle[o];
            const double scale = sum > most ? most / sum : 1.0;
            for (size_t p = 0; p < self->parts; p++) {
                self->share[p * self->directions + o] *= scale;
            }
        }
        scale_rows(self);
    }
}

static void add_radiance(const ord_source_list *sources, const sharing *self, float *out)
{
    for (size_t i = 0, part = 0; i < sources->count; i++) {
        const ord_source *const s = &sources->items[i];
        const float power[3] = {s->inflow * s->power.x, s->inflow * s->power.y,
                                s->inflow * s->power.z};
        for (size_t o = 0; s->inflow > 0.0f && o < self->directions; o++) {
            const double share = self->share[part * self->directions + o] / self->solid_angle[o];
            for (size_t c = 0; c < 3; c++) {
                out[o * CHANNELS + c] += (float)(share * (double)power[c]);
            }
        }
        part += s->inflow > 0.0f ? 1 : 0;
    }
}

air_status ord_inflow_set(const ord_source_list *sources, const air_dom_params *params,
                          air_dom *dom)
{
    air_context *const context = sources->context;
    sharing self = {.directions = air_dom_direction_count(params)};
    air_status status = AIR_OK;
    for (size_t i = 0; i < sources->count; i++) {
        self.parts += sources->items[i].inflow > 0.0f ? 1 : 0;
    }
    self.share = air_allocate(context, self.parts * self.directions, sizeof *self.share);
    self.dir = air_allocate(context, self.directions, sizeof *self.dir);
    self.solid_angle = air_allocate(context, self.directions, sizeof *self.solid_angle);
    self.angle = air_allocate(context, self.parts, sizeof *self.angle);
    float *const radiance = air_allocate(context, self.directions * CHANNELS, sizeof *radiance);
    if (self.share == NULL || self.dir == NULL || self.solid_angle == NULL || self.angle == NULL ||
        radiance == NULL) {
        status = air_fail_memory(context, "ordinates: sky");
    } else {
        air_dom_directions(dom, self.dir, self.solid_angle);
        share_by_distance(sources, &self);
        balance(&self);
        add_radiance(sources, &self, radiance);
        status = air_dom_set_inflow_directions(dom, radiance, 63);
    }
    air_free(context, self.share);
    air_free(context, self.dir);
    air_free(context, self.solid_angle);
    air_free(context, self.angle);
    air_free(context, radiance);
    return status;
}

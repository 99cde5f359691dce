/* tables.c: parameters, memory and axes of tables. */
#include "impulse/tables.h"

#include "core/host.h"
#include "core/vec.h"
#include "impulse/build.h"

void air_impulse_params_default(air_impulse_params *params)
{
    /* Errors of the irradiance between them are at most 2.2 %, below -0.74 3.6 % (README). */
    static const double knots[14] = {-0.9, -0.83, -0.74, -0.63, -0.5, -0.34, -0.17,
                                     0.0,  0.18,  0.36,  0.5,   0.64, 0.78,  0.9};
    *params = (air_impulse_params){
        .bins = 256, .angles = 16, .g_count = 14, .bounces = 10, .form = AIR_IMPULSE_SH5};
    for (size_t i = 0; i < params->g_count; i++) {
        params->g[i] = knots[i];
    }
}

void air_impulse_params_paper(air_impulse_params *params)
{
    *params = (air_impulse_params){.bins = 256,
                                   .angles = 8,
                                   .g_count = 3,
                                   .g = {-0.5, 0.0, 0.5},
                                   .bounces = 10,
                                   .form = AIR_IMPULSE_ZH11_ENERGY};
}

int impulse_form_count(air_impulse_form form)
{
    return form == AIR_IMPULSE_SH5 ? 15 : form == AIR_IMPULSE_SH3 ? 6 : AIR_IMPULSE_ORDER + 1;
}

int impulse_form_order(air_impulse_form form)
{
    return form == AIR_IMPULSE_SH5 ? 5 : form == AIR_IMPULSE_SH3 ? 3 : AIR_IMPULSE_ORDER;
}

double impulse_bin_tau(size_t bins, size_t i)
{
    const double first = cbrt(IMPULSE_TAU_LEAST / IMPULSE_TAU_GREATEST);
    const double u = first + (1.0 - first) * (double)i / (double)(bins - 1);
    return IMPULSE_TAU_GREATEST * u * u * u;
}

double impulse_angle(size_t angles, size_t i)
{
    const double quarter = (double)(angles - 1) / 3.0, x = (double)i;
    const double steps = x <= quarter ? x : quarter + 0.5 * (x - quarter);
    return 0.5 * AIR_PI * steps / quarter;
}

impulse_between impulse_find_g(const air_impulse_params *params, double g)
{
    size_t i = 0;
    if (params->g_count == 1 || !(g > params->g[0])) {
        return (impulse_between){0, 0.0};
    }
    while (i + 2 < params->g_count && g >= params->g[i + 1]) {
        i++;
    }
    const double share = (g - params->g[i]) / (params->g[i + 1] - params->g[i]);
    return (impulse_between){i, double_min(share, 1.0)};
}

static air_status check(air_context *context, const air_impulse_params *p)
{
    const char *wrong = NULL;
    if (p->bins < 8 || p->bins > 1024) {
        wrong = "bins: expected 8 to 1024";
    } else if (p->angles < 2 || 3 * p->angles - 2 > TABLES_ANGLES_MAX) {
        wrong = "angles: expected 2 to 31";
    } else if (p->g_count < 1 || p->g_count > AIR_IMPULSE_G_MAX) {
        wrong = "g_count: expected 1 to 32";
    } else if (p->bounces < 1 || p->bounces > AIR_IMPULSE_BOUNCES_MAX) {
        wrong = "bounces: expected 1 to 20";
    } else if ((unsigned)p->form >= AIR_IMPULSE_FORMS) {
        wrong = "form: not one of the known";
    } else {
        for (size_t i = 0; i < p->g_count && wrong == NULL; i++) {
            if (!(fabs(p->g[i]) <= 0.97) || (i > 0 && !(p->g[i] >= p->g[i - 1] + 1e-6))) {
                wrong = "g: expected rising knots in [-0.97, 0.97], 1e-6 apart at least";
            }
        }
    }
    return wrong == NULL ? AIR_OK
                         : air_fail(context, AIR_ERROR_ARGUMENT, "impulse tables: %s", wrong);
}

float *impulse_tables_part(const air_impulse_tables *tables, size_t i, size_t *out_count)
{
    const size_t bins = tables->params.bins, more = (size_t)(tables->params.bounces - 1);
    const size_t single = tables->params.g_count * bins;
    float *const parts[TABLES_PARTS] = {
        tables->point,          tables->directional,          tables->area,
        tables->point_multiple, tables->directional_multiple, tables->area_multiple};
    const size_t counts[TABLES_PARTS] = {single * ZONAL_STRIDE,
                                         single * ZONAL_STRIDE,
                                         single * tables->angles * tables->area_stride,
                                         bins * more * ZONAL_STRIDE,
                                         bins * more * ZONAL_STRIDE,
                                         bins * tables->angles * more * AREA_MULTIPLE_STRIDE};
    *out_count = counts[i];
    return parts[i];
}

air_status impulse_tables_shape(air_context *context, const air_impulse_params *params,
                                air_impulse_tables *out)
{
    const air_status status = check(context, params);
    if (status == AIR_OK) {
        *out = (air_impulse_tables){.context = context, .params = *params};
        out->angles = 3 * params->angles - 2;
        /* whole vectors of four */
        out->area_stride = ((size_t)impulse_form_count(params->form) + 3) / 4 * 4;
    }
    return status;
}

air_status impulse_tables_allocate(air_context *context, const air_impulse_params *params,
                                   air_impulse_tables **out)
{
    air_impulse_tables shape;
    *out = NULL;
    const air_status status = impulse_tables_shape(context, params, &shape);
    if (status != AIR_OK) {
        return status;
    }
    air_impulse_tables *const self = air_allocate(context, 1, sizeof *self);
    if (self == NULL) {
        return air_fail_memory(context, "impulse tables");
    }
    *self = shape;
    float **const parts[TABLES_PARTS] = {
        &self->point,          &self->directional,          &self->area,
        &self->point_multiple, &self->directional_multiple, &self->area_multiple};
    for (size_t i = 0; i < TABLES_PARTS; i++) {
        size_t count;
        (void)impulse_tables_part(self, i, &count);
        *parts[i] = air_allocate(context, count, sizeof(float));
        if (*parts[i] == NULL) {
            air_impulse_tables_destroy(self);
            return air_fail_memory(context, "impulse tables");
        }
    }
    *out = self;
    return AIR_OK;
}

void air_impulse_tables_destroy(air_impulse_tables *tables)
{
    if (tables == NULL) {
        return;
    }
    impulse_plan_destroy(tables->context, tables->plan);
    for (size_t i = 0; i < TABLES_PARTS; i++) {
        size_t count;
        air_free(tables->context, impulse_tables_part(tables, i, &count));
    }
    air_free(tables->context, tables);
}

const air_impulse_params *air_impulse_tables_params(const air_impulse_tables *tables)
{
    return &tables->params;
}

size_t air_impulse_tables_bytes(const air_impulse_tables *tables)
{
    size_t sum = sizeof *tables;
    for (size_t i = 0; i < TABLES_PARTS; i++) {
        size_t count;
        (void)impulse_tables_part(tables, i, &count);
        sum += count * sizeof(float);
    }
    return sum;
}

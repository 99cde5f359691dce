/* impulse.h: how light that a homogeneous medium scatters reaches a surface, from tables
 * [Dubouchet2019]. Conventions and units: impulse_quadrature.h, which this is an approximation of.
 *
 * Tables hold responses of canonical media, bounce by bounce; one set serves all media. A baker or
 * path tracer that asks often for one medium prepares a response for it, which is one look-up
 * however many bounces it sums. Nothing here needs a context but what allocates, runs threads or
 * reads files. Tables and responses are immutable once built and may be used by any thread. */
#ifndef AIRLIGHT_IMPULSE_H
#define AIRLIGHT_IMPULSE_H

#include <stddef.h>

#include "airlight/context.h"
#include "airlight/impulse_quadrature.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum air_impulse_emitter {
    AIR_IMPULSE_POINT = 0,       /* I0 = 1 */
    AIR_IMPULSE_DIRECTIONAL = 1, /* E0 = 1 across l, boundary across l at the distance asked for */
    AIR_IMPULSE_AREA = 2         /* intensity max(0, cos): I0 = radiance times area */
} air_impulse_emitter;

enum { AIR_IMPULSE_EMITTERS = 3 };

/* What is kept of an area patch's single scattering. */
typedef enum air_impulse_form {
    AIR_IMPULSE_SH5 = 0,         /* 15 mirrored coefficients */
    AIR_IMPULSE_SH3 = 1,         /* 6 */
    AIR_IMPULSE_ZH11_ENERGY = 2, /* 11 zonal ones about the axis of most energy (the paper's) */
    AIR_IMPULSE_ZH11_IRRADIANCE =
        3 /* about the axis of most energy as a diffuse receiver sees it */
} air_impulse_form;

enum { AIR_IMPULSE_FORMS = 4, AIR_IMPULSE_G_MAX = 32 };

/* ---- tables ---- */

typedef struct air_impulse_params {
    size_t bins;    /* of tau = 20 u^3, u even from 1e-3 to 20; 8 .. 1024 */
    size_t angles;  /* theta_s even from 0 to 90 degrees, on to 180 by halves; 2 .. 31 */
    size_t g_count; /* 1 .. AIR_IMPULSE_G_MAX */
    double g[AIR_IMPULSE_G_MAX]; /* knots, rising, in [-0.97, 0.97] */
    int bounces;                 /* 1 .. AIR_IMPULSE_BOUNCES_MAX */
    air_impulse_form form;
} air_impulse_params;

/* 256 bins, 16 angles, 10 bounces, SH5, and 14 knots from -0.9 to 0.9, between which irradiances
 * are off by 2.2 % at most (3.6 % below -0.74). A medium whose g is a knot has no such error:
 * bakers put theirs in. */
AIR_API void air_impulse_params_default(air_impulse_params *params);
/* The paper's: 256 bins, 8 angles, g = -0.5, 0, 0.5, ZH11 by energy. */
AIR_API void air_impulse_params_paper(air_impulse_params *params);

typedef struct air_impulse_tables air_impulse_tables;

/* All tables, on the context's threads: the same for any number of them. AIR_ERROR_ARGUMENT: a
 * parameter is out of range; AIR_ERROR_MEMORY. params NULL: the default. */
AIR_API air_status air_impulse_tables_create(air_context *context, const air_impulse_params *params,
                                             air_impulse_tables **out);
AIR_API void air_impulse_tables_destroy(air_impulse_tables *tables); /* NULL is legal */
AIR_API const air_impulse_params *air_impulse_tables_params(const air_impulse_tables *tables);
AIR_API size_t air_impulse_tables_bytes(const air_impulse_tables *tables);

/* The same by a host's own threads: begin (some 0.2 s), then every row once, in any order, rows
 * side by side if each has scratch memory of its own, of that many bytes. */
AIR_API air_status air_impulse_tables_begin(air_context *context, const air_impulse_params *params,
                                            air_impulse_tables **out);
AIR_API size_t air_impulse_row_count(const air_impulse_tables *tables);
AIR_API size_t air_impulse_row_scratch(const air_impulse_tables *tables);
AIR_API void air_impulse_build_row(air_impulse_tables *tables, size_t row, void *scratch);

/* To and from a file (docs/table-format.md); it appears whole or not at all. Loading:
 * AIR_ERROR_FORMAT names the place and what was expected. */
AIR_API air_status air_impulse_tables_save(air_context *context, const air_impulse_tables *tables,
                                           const char *path);
AIR_API air_status air_impulse_tables_load(air_context *context, const char *path,
                                           air_impulse_tables **out);
/* Does a file begin as such a table does? */
AIR_API air_status air_impulse_is_tables(air_context *context, const char *path, bool *out_is);

/* ---- media ---- */

/* How k >= 2 follows from isotropic tables when g != 0 (figures: README). */
typedef enum air_impulse_rule {
    /* k >= 2 of the medium with sigma_s' = (1 - g) sigma_s: the paper's */
    AIR_IMPULSE_SIMILARITY = 0,
    /* all scattered light is that of the reduced medium after round((1 - g) bounces) events, and
     * what its direct light has more; as SIMILARITY for g <= 0 or a single bounce */
    AIR_IMPULSE_RESIDUAL = 1
} air_impulse_rule;

typedef struct air_impulse_medium {
    double sigma_s, sigma_t; /* 1/length; 0 <= sigma_s <= sigma_t */
    double g;                /* taken to the nearest knot beyond the last */
    int bounces; /* events summed, 1: single scattering; more than in the tables: theirs */
    air_impulse_rule rule;
} air_impulse_medium;

/* ---- where ---- */

/* Of a receiver of unit normal n. For point and directional emitters cos_s and n_x are not looked
 * at. */
typedef struct air_impulse_place {
    double distance; /* to the emitter (directional: to the boundary, along l) */
    double n_l;      /* n.l */
    double cos_s;    /* cos(theta_s) = -n_s.l */
    double n_x;      /* n.x, x the unit vector along n_s - (n_s.l) l: sin(n, l) cos(azimuth) */
} air_impulse_place;

/* From points and unit normals; x_s != x. */
AIR_API air_impulse_place air_impulse_place_of(const double x[3], const double n[3],
                                               const double x_s[3], const double n_s[3]);

/* ---- one at a time ---- */

/* Zonal coefficients about l, AIR_IMPULSE_ORDER of them, of events first..last (1 <= first) of
 * point or directional light; unit emitters. Bounds of last are those of the medium. */
AIR_API void air_impulse_zonal(const air_impulse_tables *tables, air_impulse_emitter emitter,
                               const air_impulse_medium *medium, int first, int last,
                               double distance, double *out_zh);

/* Mirrored coefficients of area light; returns their order (3, 5 or 11). out: AIR_IMPULSE_SH_COUNT.
 */
AIR_API int air_impulse_mirrored(const air_impulse_tables *tables, const air_impulse_medium *medium,
                                 int first, int last, double distance, double cos_s,
                                 double *out_sh);

/* Scattered irradiance of a unit emitter, >= 0. */
AIR_API double air_impulse_irradiance(const air_impulse_tables *tables, air_impulse_emitter emitter,
                                      const air_impulse_medium *medium,
                                      const air_impulse_place *place);

/* ---- receivers: the integral of radiance times a lobe about a unit vector a ---- */

/* Zonal coefficients of lobes: max(0, cos)^exponent (1: irradiance; not normalised), exponent >= 0,
 * and radiance from exactly there (a band-limited peak). */
AIR_API void air_impulse_lobe_cosine(int order, double exponent, double *out);
AIR_API void air_impulse_lobe_radiance(int order, double *out);

/* a_l = a.l, a_x = a.x. May be negative where bands are missing. */
AIR_API double air_impulse_zonal_receive(int order, const double *zh, const double *lobe,
                                         double a_l);
AIR_API double air_impulse_mirrored_receive(int order, const double *sh, const double *lobe,
                                            double a_l, double a_x);

/* Irradiance of alpha (2/3)(1 - ln 2) B that an infinite diffuse floor of radiosity B gives itself
 * by single isotropic scattering in the half space above. */
AIR_API double air_impulse_floor_backscatter(double alpha, double radiosity);

/* ---- many of one medium ---- */

enum { AIR_IMPULSE_CHANNELS_MAX = 3 };

/* Irradiance of one kind of emitter in one medium, all its bounces summed. Of area light bands 0..4
 * are kept, of the others all. */
typedef struct air_impulse_response air_impulse_response;

/* media: one for each channel; copied. Tables are not needed afterwards. */
AIR_API air_status air_impulse_response_create(air_context *context,
                                               const air_impulse_tables *tables,
                                               air_impulse_emitter emitter,
                                               const air_impulse_medium *media, size_t channels,
                                               air_impulse_response **out);
/* The same for point and area light with all orders there are: what the tables' bounces leave is
 * added by its closed total (of the reduced, isotropic medium). Media's bounces are not looked at.
 * Some 0.3 s (point) to 1 s (area) of processor time for each channel; they reach to tau = 40.
 * AIR_ERROR_UNSUPPORTED: directional. */
AIR_API air_status air_impulse_response_create_all_orders(
    air_context *context, const air_impulse_tables *tables, air_impulse_emitter emitter,
    const air_impulse_medium *media, size_t channels, air_impulse_response **out);
AIR_API void air_impulse_response_destroy(air_impulse_response *response); /* NULL is legal */

/* Places as floats. */
typedef struct air_impulse_place_float {
    float distance, n_l, cos_s, n_x;
} air_impulse_place_float;

/* out: one irradiance of a unit emitter for each channel, >= 0. */
AIR_API void air_impulse_response_irradiance(const air_impulse_response *response,
                                             const air_impulse_place_float *place, float *out);

/* Structures of arrays, count each (cos_s and n_x may be NULL but for area light). */
typedef struct air_impulse_places {
    const float *distance, *n_l, *cos_s, *n_x;
} air_impulse_places;

/* out[channel][i]: what air_impulse_response_irradiance gives, to rounding. */
AIR_API void air_impulse_response_batch(const air_impulse_response *response,
                                        const air_impulse_places *places, size_t count,
                                        float *const *out);

#ifdef __cplusplus
}
#endif
#endif

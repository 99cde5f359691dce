/* area_table.h: fits of transformed spherical distributions to the phase function of Henyey and
 * Greenstein [KT2025], and tables of them. Deterministic: quadrature and Brent's method, no random
 * numbers, no allocation. */
#ifndef AIRLIGHT_AREA_TABLE_H
#define AIRLIGHT_AREA_TABLE_H

#include "airlight/arealight.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the fit of a density D to the phase function p makes small, each hemisphere by itself. */
typedef enum air_area_loss {
    AIR_AREA_KL = 0,    /* integral of p ln(p / D) */
    AIR_AREA_L2 = 1,    /* of (p - D)^2 */
    AIR_AREA_L3 = 2,    /* of |p - D|^3 */
    AIR_AREA_CDF_L2 = 3 /* of the squared difference of their distribution functions */
} air_area_loss;

enum { AIR_AREA_LOSSES = 4 };

/* What is transformed. The last two are the sources that the paper shows to fail. */
typedef enum air_area_source {
    AIR_AREA_SOURCE_LTSD = 0,   /* clamped cosine on the near half, its inverse on the far one */
    AIR_AREA_SOURCE_MIX = 1,    /* on each half a fitted mixture of cosine and constant */
    AIR_AREA_SOURCE_COSINE = 2, /* one clamped cosine: nothing on the far half */
    AIR_AREA_SOURCE_UNIFORM = 3 /* one constant over the sphere: both halves alike */
} air_area_source;

enum { AIR_AREA_SOURCES = 4 };

/* The fit at g, |g| <= 0.99 (beyond, that of 0.99). MIX is always fitted by AIR_AREA_CDF_L2, COSINE
 * and UNIFORM by AIR_AREA_L2 where KL is asked for (it is infinite for the one). */
AIR_API air_area_lobe air_area_fit(air_area_source source, air_area_loss loss, double g);

/* Densities per solid angle at the cosine c to the peak: the phase function's, and the fit's. */
AIR_API double air_area_phase_density(double g, double c);
AIR_API double air_area_lobe_density(air_area_source source, const air_area_lobe *lobe, double c);

enum { AIR_AREA_KNOTS = 128 };

/* The knots lie at |g| = 0.99 k / 127. */
typedef struct air_area_table {
    air_area_source source; /* LTSD or MIX */
    air_area_loss loss;
    air_area_lobe knots[AIR_AREA_KNOTS];
} air_area_table;

/* All 128 knots: LTSD takes about 0.05 s, MIX about 1 s. */
AIR_API void air_area_table_fit(air_area_source source, air_area_loss loss, air_area_table *out);

/* At any g: 1/s and w are linear between knots. */
AIR_API air_area_lobe air_area_table_lobe(const air_area_table *table, double g);

/* The tables that the library carries: LTSD by KL, MIX by CDF_L2. */
AIR_API void air_area_table_default(air_area_source source, air_area_table *out);

/* To and from a file (JSON, docs/table-format.md); it appears whole or not at all. Loading:
 * AIR_ERROR_FORMAT names the place and what was expected. */
AIR_API air_status air_area_table_save(air_context *context, const air_area_table *table,
                                       const char *path);
AIR_API air_status air_area_table_load(air_context *context, const char *path, air_area_table *out);

#ifdef __cplusplus
}
#endif
#endif

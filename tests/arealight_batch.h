/* arealight_batch.h: points for air_area_eval_* in both precisions, lamps from vertices, and the
 * oracle's polygons. */
#ifndef AIR_TESTS_AREALIGHT_BATCH_H
#define AIR_TESTS_AREALIGHT_BATCH_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/arealight_eval.h"
#include "collimated_fixture.h"
#include "core/cpu.h"

enum { BATCH_MOST = 4200, BATCH_LEVELS = AIR_CPU_AVX512 + 1 };

typedef struct batch_points {
    size_t count;
    double position[3][BATCH_MOST], wo[3][BATCH_MOST];
    float position_float[3][BATCH_MOST], wo_float[3][BATCH_MOST];
} batch_points;

/* Kept as floats, so that both precisions are asked the same. */
static inline void batch_add(batch_points *self, const double position[3], const double wo[3])
{
    for (int k = 0; k < 3; k++) {
        self->position_float[k][self->count] = (float)position[k];
        self->wo_float[k][self->count] = (float)wo[k];
        self->position[k][self->count] = self->position_float[k][self->count];
        self->wo[k][self->count] = self->wo_float[k][self->count];
    }
    self->count++;
}

/* As they are, in double. */
static inline void batch_add_exact(batch_points *self, const double position[3], const double wo[3])
{
    const size_t at = self->count;
    batch_add(self, position, wo);
    for (int k = 0; k < 3; k++) {
        self->position[k][at] = position[k];
        self->wo[k][at] = wo[k];
    }
}

static inline air_area_lamp batch_lamp(const double (*vertices)[3], size_t count)
{
    air_area_lamp lamp = {.vertex_count = count, .two_sided = true};
    double twice[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < count; i++) {
        memcpy(lamp.vertices[i], vertices[i], sizeof lamp.vertices[i]);
        for (int k = 0; k < 3; k++) {
            lamp.centre[k] += vertices[i][k] / (double)count;
        }
    }
    for (size_t i = 1; i + 1 < count; i++) {
        double a[3], b[3], n[3];
        for (int k = 0; k < 3; k++) {
            a[k] = vertices[i][k] - vertices[0][k];
            b[k] = vertices[i + 1][k] - vertices[0][k];
        }
        cross(a, b, n);
        for (int k = 0; k < 3; k++) {
            twice[k] += n[k];
        }
    }
    lamp.area = 0.5 * sqrt(dot(twice, twice));
    for (int k = 0; k < 3; k++) {
        lamp.normal[k] = twice[k] / (2.0 * lamp.area);
    }
    return lamp;
}

/* What is asked: edges with a number of nodes, or lobes where nodes is 0. */
typedef struct batch_question {
    double g;
    int nodes;
    air_area_lobe lobe;
} batch_question;

static inline batch_question by_edges(double g, int nodes)
{
    return (batch_question){.g = g, .nodes = nodes};
}

static inline batch_question by_lobes(air_area_lobe lobe) { return (batch_question){.lobe = lobe}; }

static inline void batch_ask(const air_context *context, const air_area_lamp *lamp,
                             const batch_question *q, const batch_points *p, double *out)
{
    const air_area_shading_points points = {{p->position[0], p->position[1], p->position[2]},
                                            {p->wo[0], p->wo[1], p->wo[2]}};
    if (q->nodes > 0) {
        air_area_eval_edge(context, lamp, q->g, q->nodes, &points, p->count, out);
    } else {
        air_area_eval_lobes(context, lamp, &q->lobe, &points, p->count, out);
    }
}

static inline void batch_ask_float(const air_context *context, const air_area_lamp *lamp,
                                   const batch_question *q, const batch_points *p, float *out)
{
    const air_area_shading_points_float points = {
        {p->position_float[0], p->position_float[1], p->position_float[2]},
        {p->wo_float[0], p->wo_float[1], p->wo_float[2]}};
    if (q->nodes > 0) {
        air_area_eval_edge_float(context, lamp, q->g, q->nodes, &points, p->count, out);
    } else {
        air_area_eval_lobes_float(context, lamp, &q->lobe, &points, p->count, out);
    }
}

/* ---- the oracle ---- */

enum { ORACLE_POLYGONS = 100, ORACLE_GS = 7 };

static const double oracle_g[ORACLE_GS] = {-0.95, -0.6, -0.1, 0.0, 0.4, 0.9, 0.99};

/* The exactly fitted lobes of the spec, section 11, for the values of g above: the paper's and the
 * mixed ones. */
static const double oracle_fit[ORACLE_GS][6] = {
    {11.369584, 1.505489, 13.834997, .556930, .884381, -.334875},
    {1.488494, 1.547560, 1.890748, .559027, .912242, -.335770},
    {.614963, 1.898920, 1.021173, .133668, 1.040301, -.194085},
    {1.0, 1.0, 1.0, 0.0, 1.0, 0.0},
    {.964044, 1.625894, 1.324243, .430880, .964292, -.337100},
    {5.809322, 1.506951, 7.040618, .595690, .885348, -.334907},
    {55.489298, 1.505051, 69.772177, .459195, .884092, -.334865}};

static inline air_area_lobe oracle_lobe(int g_index, bool mix)
{
    const double *f = oracle_fit[g_index];
    return mix ? (air_area_lobe){oracle_g[g_index], f[2], f[3], f[4], f[5]}
               : (air_area_lobe){oracle_g[g_index], f[0], 1.0, f[1], -1.0};
}

typedef struct oracle_polygon {
    char class[24];
    size_t count;
    double wo[3], vertices[5][3];
    double exact[ORACLE_GS], ltsd[ORACLE_GS], mix[ORACLE_GS];
} oracle_polygon;

/* The text of the next column, which may be empty. */
static inline char *oracle_column(char **rest)
{
    char *const start = *rest, *const end = start + strcspn(start, ",\n");
    *rest = *end != '\0' ? end + 1 : end;
    *end = '\0';
    return start;
}

static inline bool oracle_read_polygons(FILE *file, oracle_polygon *out)
{
    char line[2048], *rest;
    bool good = fgets(line, sizeof line, file) != NULL;
    for (int i = 0; i < ORACLE_POLYGONS && good; i++) {
        oracle_polygon *p = &out[i];
        good = fgets(line, sizeof line, file) != NULL;
        rest = line;
        (void)oracle_column(&rest);
        (void)snprintf(p->class, sizeof p->class, "%s", oracle_column(&rest));
        p->count = (size_t)strtoul(oracle_column(&rest), NULL, 10);
        for (int k = 0; k < 3; k++) {
            p->wo[k] = strtod(oracle_column(&rest), NULL);
        }
        for (int k = 0; k < 15; k++) {
            p->vertices[k / 3][k % 3] = strtod(oracle_column(&rest), NULL);
        }
        for (int k = 0; k < 4; k++) {
            (void)oracle_column(&rest);
        }
        for (int k = 0; k < ORACLE_GS; k++) {
            p->exact[k] = strtod(oracle_column(&rest), NULL);
        }
    }
    return good;
}

static inline bool oracle_read_lobes(FILE *file, oracle_polygon *out)
{
    char line[512], *rest;
    bool good = fgets(line, sizeof line, file) != NULL;
    for (int i = 0; i < ORACLE_POLYGONS * ORACLE_GS && good; i++) {
        good = fgets(line, sizeof line, file) != NULL;
        rest = line;
        const unsigned long id = strtoul(oracle_column(&rest) + 1, NULL, 10);
        const double g = strtod(oracle_column(&rest), NULL);
        good = good && id == (unsigned long)(i / ORACLE_GS) && g == oracle_g[i % ORACLE_GS];
        out[i / ORACLE_GS].ltsd[i % ORACLE_GS] = strtod(oracle_column(&rest), NULL);
        out[i / ORACLE_GS].mix[i % ORACLE_GS] = strtod(oracle_column(&rest), NULL);
    }
    return good;
}

/* False if the shared data is not there. */
static inline bool oracle_load(oracle_polygon *out)
{
    FILE *polygons = fopen(AIR_SHARED_DIR "/spec/data/area-lights/oracle_public.csv", "r");
    FILE *lobes = fopen(AIR_SHARED_DIR "/spec/data/area-lights/oracle_ltsd_public.csv", "r");
    const bool good = polygons != NULL && lobes != NULL && oracle_read_polygons(polygons, out) &&
                      oracle_read_lobes(lobes, out);
    if (polygons != NULL) {
        (void)fclose(polygons);
    }
    if (lobes != NULL) {
        (void)fclose(lobes);
    }
    return good;
}

#endif

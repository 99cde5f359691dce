/* beam_scenes.h: scenes for shadows in haze: meshes, a box of haze, a sun, a camera; and triangles
 * cut in four to see how times grow. */
#ifndef AIR_BENCH_BEAM_SCENES_H
#define AIR_BENCH_BEAM_SCENES_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/airlight.h"
#include "core/triple.h"
#include "scene/snapshot.h"

/* Settings as published with the method; +Y up, directions of any length. */
typedef struct beam_settings {
    const char *name, *file; /* file under ../shared/scenes; NULL: a sphere of `rings` rings */
    int rings;
    int divisions; /* how often every triangle is cut in four */
    double low[3], high[3];
    double eye[3], look[3], fov_deg;
    double to_light[3], sigma_t;
    int width, height;
} beam_settings;

static const beam_settings beam_ball = {.low = {-1, -1, -1},
                                        .high = {1, 1, 1},
                                        .eye = {0.5, 1, 3.5},
                                        .look = {-0.5, -1, -3.5},
                                        .fov_deg = 40,
                                        .to_light = {-0.3, 0.6, -0.3},
                                        .sigma_t = 1,
                                        .width = 256,
                                        .height = 256};

static const beam_settings beam_fog_example = {
    .file = "bevy/VolumetricFogExample/VolumetricFogExample.glb",
    .low = {-3.17, 0, -6.75},
    .high = {3.17, 6.35, 6.75},
    .eye = {-1.7, 1.5, 4.5},
    .look = {.2, .2, -1},
    .fov_deg = 60,
    .to_light = {.544352, .837696, -.044118},
    .sigma_t = .1,
    .width = 640,
    .height = 480};

static const beam_settings beam_atrium = {.file = "geometry/sponza.glb",
                                          .low = {-17.5, -1, -7.9},
                                          .high = {17.5, 15.7, 7.9},
                                          .eye = {-11, 2.5, -1.2},
                                          .look = {1, .25, .12},
                                          .fov_deg = 60,
                                          .to_light = {.35, 1, .28},
                                          .sigma_t = .05,
                                          .width = 640,
                                          .height = 480};

static const beam_settings beam_classroom = {.file = "geometry/classroom.glb",
                                             .low = {-4.5, -.1, -5.98},
                                             .high = {4.5, 3.05, 5.98},
                                             .eye = {-1.69049, 1.27158, 5.88653},
                                             .look = {.151294, .0283071, -.988083},
                                             .fov_deg = 46,
                                             .to_light = {-.865804, .416766, -.276929},
                                             .sigma_t = .1,
                                             .width = 640,
                                             .height = 480};

/* What is measured: a scene, its ball's rings if it has one, and how often triangles are cut. */
static const struct beam_run {
    const char *name;
    const beam_settings *scene;
    int rings, divisions;
} beam_runs[] = {
    {"sphere 8k", &beam_ball, 64, 0},         {"sphere 131k", &beam_ball, 256, 0},
    {"fog example", &beam_fog_example, 0, 0}, {"atrium", &beam_atrium, 0, 0},
    {"classroom", &beam_classroom, 0, 0},     {"atrium x16", &beam_atrium, 0, 2},
    {"classroom x4", &beam_classroom, 0, 1},  {"classroom x16", &beam_classroom, 0, 2},
};
enum { BEAM_RUNS = sizeof beam_runs / sizeof *beam_runs };

static inline beam_settings beam_run_settings(int run)
{
    beam_settings settings = *beam_runs[run].scene;
    settings.name = beam_runs[run].name;
    settings.rings = beam_runs[run].rings;
    settings.divisions = beam_runs[run].divisions;
    return settings;
}

/* A triangle soup: 9 floats each. */
typedef struct beam_soup {
    float *positions;
    uint32_t *indices;
    size_t triangle_count;
} beam_soup;

static inline void beam_soup_reserve(beam_soup *soup, size_t triangles)
{
    soup->positions = malloc((9 * triangles + 1) * sizeof *soup->positions);
    soup->indices = malloc(3 * triangles * sizeof *soup->indices);
    if (soup->positions == NULL || soup->indices == NULL) {
        abort();
    }
    soup->triangle_count = triangles;
    for (size_t i = 0; i < 3 * triangles; i++) {
        soup->indices[i] = (uint32_t)i;
    }
}

static inline void beam_sphere_point(int rings, int i, int j, float out[3])
{
    const double pi = 3.14159265358979323846;
    const double theta = pi * i / rings, phi = 2.0 * pi * (j % rings) / rings;
    const double ring = i == 0 || i == rings ? 0.0 : sin(theta);
    out[0] = (float)(0.2 + 0.5 * ring * cos(phi));
    out[1] = (float)(0.4 + 0.5 * cos(theta));
    out[2] = (float)(0.5 * ring * sin(phi));
}

static inline void beam_sphere(int rings, beam_soup *out)
{
    float *p;
    beam_soup_reserve(out, (size_t)(2 * rings * rings));
    p = out->positions;
    for (int i = 0; i < rings; i++) {
        for (int j = 0; j < rings; j++, p += 18) {
            beam_sphere_point(rings, i, j, p);
            beam_sphere_point(rings, i + 1, j, p + 3);
            beam_sphere_point(rings, i + 1, j + 1, p + 6);
            memcpy(p + 9, p, 3 * sizeof *p);
            memcpy(p + 12, p + 6, 3 * sizeof *p);
            beam_sphere_point(rings, i, j + 1, p + 15);
        }
    }
}

static inline void beam_soup_from(const air_snapshot *snapshot, beam_soup *out)
{
    size_t next = 0;
    beam_soup_reserve(out, snapshot->triangle_count);
    for (size_t m = 0; m < snapshot->mesh_count; m++) {
        const air_mesh *mesh = snapshot->meshes[m];
        for (size_t i = 0; i < 3 * mesh->triangle_count; i++, next += 3) {
            memcpy(out->positions + next, mesh->positions + 3 * mesh->indices[i],
                   3 * sizeof(float));
        }
    }
}

static inline void beam_midpoint(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; k++) {
        out[k] = 0.5f * (a[k] + b[k]);
    }
}

static inline void beam_soup_divide(beam_soup *soup)
{
    static const int corners[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
    const beam_soup old = *soup;
    beam_soup_reserve(soup, 4 * old.triangle_count);
    for (size_t i = 0; i < old.triangle_count; i++) {
        float p[6][3];
        memcpy(p, old.positions + 9 * i, 9 * sizeof(float));
        beam_midpoint(p[0], p[1], p[3]);
        beam_midpoint(p[1], p[2], p[4]);
        beam_midpoint(p[2], p[0], p[5]);
        for (int q = 0; q < 4; q++) {
            for (int k = 0; k < 3; k++) {
                memcpy(soup->positions + 36 * i + 9 * (size_t)q + 3 * (size_t)k, p[corners[q][k]],
                       3 * sizeof(float));
            }
        }
    }
    free(old.positions);
    free(old.indices);
}

/* False if the file is not there. */
static inline bool beam_soup_make(air_context *context, const beam_settings *s, beam_soup *out)
{
    if (s->file == NULL) {
        beam_sphere(s->rings, out);
    } else {
        char path[512];
        air_scene *scene;
        air_snapshot *snapshot;
        snprintf(path, sizeof path, "%s/scenes/%s", AIR_SHARED_DIR, s->file);
        if (air_scene_load(context, path, NULL, &scene) != AIR_OK) {
            return false;
        }
        if (air_scene_commit(scene, &snapshot, NULL) != AIR_OK) {
            abort();
        }
        air_scene_destroy(scene);
        beam_soup_from(snapshot, out);
        air_snapshot_release(snapshot);
    }
    for (int i = 0; i < s->divisions; i++) {
        beam_soup_divide(out);
    }
    return true;
}

static inline void beam_soup_free(beam_soup *soup)
{
    free(soup->positions);
    free(soup->indices);
}

/* ---- the camera ---- */

static inline void beam_normalize(double v[3])
{
    const double length = sqrt(air_dot3(v, v));
    for (int k = 0; k < 3; k++) {
        v[k] /= length;
    }
}

/* The ray through the centre of a pixel, y = 0 at the top. */
static inline void beam_ray(const beam_settings *s, int x, int y, double dir[3])
{
    double f[3], r[3], u[3];
    const double up[3] = {0, 1, 0};
    const double tangent = tan(s->fov_deg * 3.14159265358979323846 / 360.0);
    memcpy(f, s->look, sizeof f);
    beam_normalize(f);
    air_cross3(f, up, r);
    beam_normalize(r);
    air_cross3(r, f, u);
    const double px = (2.0 * (x + 0.5) / s->width - 1.0) * tangent * s->width / s->height;
    const double py = (1.0 - 2.0 * (y + 0.5) / s->height) * tangent;
    for (int k = 0; k < 3; k++) {
        dir[k] = f[k] + px * r[k] + py * u[k];
    }
    beam_normalize(dir);
}

static inline void beam_medium(const beam_settings *s, air_collimated_medium *out)
{
    double planes[6][4] = {{0}};
    for (int k = 0; k < 3; k++) {
        planes[2 * k][k] = 1.0;
        planes[2 * k][3] = s->high[k];
        planes[2 * k + 1][k] = -1.0;
        planes[2 * k + 1][3] = -s->low[k];
    }
    if (air_collimated_medium_from_planes(NULL, (const double(*)[4])planes, 6, out) != AIR_OK) {
        abort();
    }
}

static inline void beam_hull(const beam_settings *s, double out[8][3])
{
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) {
            out[i][k] = (i >> k & 1) != 0 ? s->high[k] : s->low[k];
        }
    }
}

#endif

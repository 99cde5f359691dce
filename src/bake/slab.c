#include "bake/slab.h"

#include "airlight/impulse_quadrature.h"
#include "core/harmonics.h"
#include "core/phase.h"
#include "core/quadrature.h"

enum { BINS = 48, ORDER = 5, COEFFICIENTS = ORDER * ORDER, POLAR = 24, AZIMUTH = 48 };

/* Optical depths are 20 u^3, like those of the tables. */
#define MOST_DEPTH 20.0

/* One plane under one light: times the lobe of a clamped cosine already, so that irradiance is a
 * sum over harmonics of the normal. */
typedef struct face {
    uint32_t light;
    uint32_t plane;
    float values[BINS][3][COEFFICIENTS];
} face;

struct air_slab {
    air_context *context;
    const air_region *region;
    face *faces;
    size_t count;
};

static double depth_of(int bin)
{
    const double u = (bin + 0.5) / BINS;
    return MOST_DEPTH * u * u * u;
}

/* The difference of both radiances from a direction, E0 = 1. */
static double difference(double alpha, double g, const double l[3], const double n[3], double depth,
                         const double w[3])
{
    const double slant = n[0] * l[0] + n[1] * l[1] + n[2] * l[2];
    return air_impulse_slab_ray(alpha, 1.0, g, l, n, depth, w, INFINITY) -
           air_impulse_slab_ray(alpha, 1.0, g, l, l, depth / slant, w, INFINITY);
}

/* Projects it: polar about the light, where the phase function has its peak. */
static void project(double alpha, double g, const air_frame *frame, const double n[3], double depth,
                    const double nodes[POLAR], const double weights[POLAR], float out[COEFFICIENTS])
{
    double lobe[ORDER], sums[COEFFICIENTS] = {0.0}, y[COEFFICIENTS], l[3];
    air_zh_clamped_cosine(ORDER, lobe);
    vec3_store64(l, frame->n);
    for (int i = 0; i < POLAR; i++) {
        const double s = 0.5 * (nodes[i] + 1.0), mu = 1.0 - 2.0 * s * s;
        const double weight = 0.5 * weights[i] * 4.0 * s * 2.0 * AIR_PI / AZIMUTH;
        const double r = sqrt(double_max(1.0 - mu * mu, 0.0));
        for (int k = 0; k < AZIMUTH; k++) {
            const double phi = 2.0 * AIR_PI * (k + 0.5) / AZIMUTH;
            const air_vec3 local = vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)mu);
            double w[3];
            vec3_store64(w, frame_to_world(frame, local));
            const double value = weight * difference(alpha, g, l, n, depth, w);
            air_sh_evaluate(ORDER, w, y);
            for (int c = 0; c < COEFFICIENTS; c++) {
                sums[c] += value * y[c];
            }
        }
    }
    for (int band = 0, c = 0; band < ORDER; band++) {
        for (int m = -band; m <= band; m++, c++) {
            out[c] = (float)(sums[c] * lobe[band] * air_zh_scale(band));
        }
    }
}

static void make_face(const air_snapshot *snapshot, const air_region *region, face *out)
{
    const air_medium *medium = &snapshot->media.media[region->medium];
    const air_frame frame = frame_from_normal(vec3_neg(snapshot->lights.entries[out->light].dir));
    const double g = (double)phase_mean_cosine(medium->phase); /* that of the directional table */
    const float s[3] = {region->sigma_s.x, region->sigma_s.y, region->sigma_s.z};
    const float t[3] = {region->sigma_t.x, region->sigma_t.y, region->sigma_t.z};
    double nodes[POLAR], weights[POLAR], n[3];
    air_gauss_legendre(POLAR, nodes, weights);
    vec3_store64(n, region->planes[out->plane].n);
    for (int bin = 0; bin < BINS; bin++) {
        for (int c = 0; c < 3; c++) {
            const double alpha = t[c] > 0.0f ? (double)(s[c] / t[c]) : 0.0;
            if (c > 0 && s[c] == s[c - 1] && t[c] == t[c - 1]) {
                for (int k = 0; k < COEFFICIENTS; k++) {
                    out->values[bin][c][k] = out->values[bin][c - 1][k];
                }
            } else {
                project(alpha, g, &frame, n, depth_of(bin), nodes, weights, out->values[bin][c]);
            }
        }
    }
}

/* The one region of a medium, if it is convex and of constant density. */
static const air_region *only_region(const air_media *media, size_t medium)
{
    const air_region *found = NULL;
    for (size_t i = 0; i < media->region_count; i++) {
        if (media->regions[i].medium == medium) {
            if (found != NULL || media->regions[i].kind != AIR_REGION_CONVEX ||
                !media->regions[i].constant) {
                return NULL;
            }
            found = &media->regions[i];
        }
    }
    return found;
}

air_status air_slab_create(air_context *context, const air_snapshot *snapshot, size_t medium,
                           air_slab **out)
{
    const air_region *region = only_region(&snapshot->media, medium);
    const air_light_table *lights = &snapshot->lights;
    size_t count = 0;
    *out = NULL;
    for (size_t i = 0; i < lights->explicit_count; i++) {
        count += lights->entries[i].kind == AIR_LIGHT_COLLIMATED;
    }
    if (region == NULL || count == 0) {
        return AIR_OK;
    }
    air_slab *self = air_allocate(context, 1, sizeof *self);
    if (self == NULL) {
        return air_fail_memory(context, "responses of media");
    }
    self->context = context;
    self->region = region;
    self->faces = air_allocate(context, count * region->plane_count, sizeof *self->faces);
    if (self->faces == NULL) {
        air_slab_destroy(self);
        return air_fail_memory(context, "responses of media");
    }
    for (uint32_t i = 0; i < lights->explicit_count; i++) {
        const air_light *light = &lights->entries[i];
        for (uint32_t p = 0; light->kind == AIR_LIGHT_COLLIMATED && p < region->plane_count; p++) {
            if (vec3_dot(region->planes[p].n, light->dir) < -1e-3f) {
                face *at = &self->faces[self->count++];
                at->light = i;
                at->plane = p;
                make_face(snapshot, region, at);
            }
        }
    }
    *out = self;
    return AIR_OK;
}

void air_slab_destroy(air_slab *slab)
{
    if (slab != NULL) {
        air_free(slab->context, slab->faces);
        air_free(slab->context, slab);
    }
}

/* The plane through which the light comes to a point inside, and how deep below it the point is. */
static uint32_t entry_plane(const air_region *region, air_vec3 position, air_vec3 to_light,
                            float *out_depth)
{
    uint32_t found = UINT32_MAX;
    float nearest = INFINITY;
    for (uint32_t p = 0; p < region->plane_count; p++) {
        const float slope = vec3_dot(region->planes[p].n, to_light);
        const float depth = region->planes[p].h - vec3_dot(region->planes[p].n, position);
        if (slope > 1e-3f && depth / slope < nearest) {
            nearest = depth / slope;
            found = p;
            *out_depth = depth;
        }
    }
    return found;
}

static float interpolate(const face *at, int channel, double depth, const float y[COEFFICIENTS])
{
    const double u = cbrt(depth / MOST_DEPTH) * BINS - 0.5;
    const double inside = u < 0.0 ? 0.0 : u > BINS - 1 ? BINS - 1 : u;
    const int bin = inside >= BINS - 1 ? BINS - 2 : (int)inside;
    const float share = (float)(inside - bin);
    const float *a = at->values[bin][channel], *b = at->values[bin + 1][channel];
    float sum = 0.0f;
    for (int c = 0; c < COEFFICIENTS; c++) {
        sum += y[c] * (a[c] + share * (b[c] - a[c]));
    }
    return u < 0.0 ? sum * (float)((u + 0.5) / 0.5) : sum;
}

air_vec3 air_slab_correction(const air_slab *slab, uint32_t light, air_vec3 position,
                             air_vec3 to_light, air_vec3 normal)
{
    float depth = 0.0f;
    const uint32_t plane = entry_plane(slab->region, position, to_light, &depth);
    const air_region *region = slab->region;
    const double at[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    const float extinction[3] = {region->sigma_t.x, region->sigma_t.y, region->sigma_t.z};
    double y64[COEFFICIENTS];
    float y[COEFFICIENTS], out[3] = {0.0f, 0.0f, 0.0f};
    for (size_t i = 0; i < slab->count; i++) {
        const face *f = &slab->faces[i];
        if (f->light != light || f->plane != plane || !(depth > 0.0f)) {
            continue;
        }
        air_sh_evaluate(ORDER, at, y64);
        for (int c = 0; c < COEFFICIENTS; c++) {
            y[c] = (float)y64[c];
        }
        for (int c = 0; c < 3; c++) {
            out[c] = interpolate(f, c, (double)(depth * extinction[c]), y);
        }
    }
    return vec3(out[0], out[1], out[2]);
}

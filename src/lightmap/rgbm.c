/* rgbm.c: pages as 8-bit PNG with a shared multiplier in alpha (docs/lightmap-engines.md). */
#include <math.h>
#include <stdio.h>

#include "image/staging.h"
#include "image/stb_image.h"
#include "lightmap/check.h"
#include "lightmap/engine.h"
#include "lightmap/place.h"

enum { VERSION = 1, NAME = 64, CANDIDATES = 32 };

typedef struct rgbm_job {
    const float *planes[3]; /* irradiance / pi */
    size_t width;
    float range;
    uint8_t *bytes;
    size_t *clamped; /* per row: texels beyond the range */
} rgbm_job;

/* Four bytes near a colour in [0, 1]: of the first multipliers a that reach its largest component
 * the one whose largest error is least. With the smallest of them, a = ceil(255 m), bytes are at
 * least 127.5 once a is 2 or more, so the error is at most m / 255; with a = 1 it is at most 1 / (2
 * * 255^2). */
static void encode(const float colour[3], uint8_t out[4])
{
    const float largest = fmaxf(colour[0], fmaxf(colour[1], colour[2]));
    const float first = ceilf(255.0f * largest);
    float least = INFINITY;
    const int from = first < 1.0f ? 1 : (int)first;
    for (int a = from; a <= 255 && a < from + CANDIDATES; a++) {
        const float step = (float)a / (255.0f * 255.0f), per_step = 255.0f * 255.0f / (float)a;
        float worst = 0.0f;
        uint8_t bytes[3];
        for (int c = 0; c < 3; c++) {
            const float byte = fminf(rintf(colour[c] * per_step), 255.0f);
            worst = fmaxf(worst, fabsf(byte * step - colour[c]));
            bytes[c] = (uint8_t)byte;
        }
        if (worst < least) {
            least = worst;
            out[0] = bytes[0];
            out[1] = bytes[1];
            out[2] = bytes[2];
            out[3] = (uint8_t)a;
        }
    }
}

static void encode_row(void *user, size_t row, size_t worker)
{
    const rgbm_job *job = user;
    (void)worker;
    for (size_t i = row * job->width; i < (row + 1) * job->width; i++) {
        float colour[3], largest = 1.0f;
        for (size_t c = 0; c < 3; c++) {
            colour[c] = fmaxf(job->planes[c][i] / job->range, 0.0f);
            largest = fmaxf(largest, colour[c]);
        }
        /* What is too bright keeps its hue. */
        job->clamped[row] += largest > 1.0f;
        for (size_t c = 0; c < 3; c++) {
            colour[c] /= largest;
        }
        encode(colour, job->bytes + 4 * i);
    }
}

static air_status add_page(air_staging *staging, const air_image *image, const char *name,
                           float range)
{
    air_context *context = staging->context;
    const size_t width = air_image_width(image), height = air_image_height(image);
    rgbm_job job = {.width = width, .range = range};
    air_sink sink = {.context = context};
    size_t clamped = 0;
    air_status status = AIR_OK;
    (void)air_lightmap_planes(image, "", job.planes);
    job.bytes = air_allocate(context, width * height, 4);
    job.clamped = air_allocate(context, height, sizeof *job.clamped);
    if (job.bytes == NULL || job.clamped == NULL) {
        status = air_fail_memory(context, name);
    } else if (width * height >= (size_t)1 << 28) {
        status = air_fail(context, AIR_ERROR_UNSUPPORTED,
                          "%s: %zu x %zu pixels are too many for a PNG", name, width, height);
    } else {
        air_parallel_for(context, height, encode_row, &job);
        if (!air_stb_encode_png(&sink, width, height, 4, job.bytes)) {
            status = air_fail_memory(context, name);
        }
    }
    for (size_t y = 0; y < height && status == AIR_OK; y++) {
        clamped += job.clamped[y];
    }
    if (status == AIR_OK && clamped > 0) {
        air_warn(context, "%s/%s: %zu texels are brighter than the range of %g and were clamped",
                 staging->folder, name, clamped, (double)range);
    }
    if (status == AIR_OK) {
        status = air_staging_add(staging, name, sink.data, sink.size);
    }
    air_free(context, sink.data);
    air_free(context, job.clamped);
    air_free(context, job.bytes);
    return status;
}

static json_t *index_to_json(const air_lightmap *lightmap, float range)
{
    json_t *root = json_object(), *pages = json_array(), *meshes = json_array();
    json_object_set_new(root, "airlight_rgbm", json_integer(VERSION));
    json_object_set_new(root, "units", json_string("irradiance / pi, W/(m^2 sr)"));
    json_object_set_new(root, "decode", json_string("rgb * a * range"));
    json_object_set_new(root, "range", json_real((double)range));
    json_object_set_new(root, "photometric", json_boolean(lightmap->photometric));
    for (size_t i = 0; i < lightmap->page_count; i++) {
        char name[NAME];
        (void)snprintf(name, sizeof name, "page-%zu.png", i);
        json_array_append_new(pages, json_string(name));
    }
    for (size_t i = 0; i < lightmap->mesh_count; i++) {
        const air_lightmap_mesh *mesh = &lightmap->meshes[i];
        if (mesh->page >= 0) {
            json_t *object = json_object();
            air_lightmap_name_mesh(object, mesh);
            json_object_set_new(object, "page", json_integer(mesh->page));
            json_object_set_new(object, "rectangle",
                                mesh->sources == NULL ? air_lightmap_rectangle(mesh) : json_null());
            json_array_append_new(meshes, object);
        }
    }
    json_object_set_new(root, "pages", pages);
    json_object_set_new(root, "meshes", meshes);
    return root;
}

air_status air_lightmap_save_rgbm(air_context *context, const air_lightmap *lightmap,
                                  const char *folder, float range)
{
    air_staging staging;
    if (!(range > 0.0f && range < INFINITY)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: the range is %g, must be positive and finite", folder, (double)range);
    }
    air_status status = air_lightmap_check(context, lightmap, folder, AIR_ERROR_ARGUMENT);
    if (status != AIR_OK) {
        return status;
    }
    status = air_staging_begin(context, folder, &staging);
    for (size_t i = 0; i < lightmap->page_count && status == AIR_OK; i++) {
        air_image *image = NULL;
        char name[NAME];
        (void)snprintf(name, sizeof name, "page-%zu.png", i);
        status = air_lightmap_page_radiance(context, lightmap->pages[i], &image);
        if (status == AIR_OK) {
            status = add_page(&staging, image, name, range);
        }
        air_image_destroy(image);
    }
    if (status == AIR_OK) {
        status = air_staging_add_json(&staging, "rgbm.json", index_to_json(lightmap, range));
    }
    if (status == AIR_OK) {
        status = air_staging_commit(&staging);
    }
    air_staging_finish(&staging);
    return status;
}

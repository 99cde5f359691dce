/* sites.h: lists of places whose light is asked for, and the run over all their samples.
 *
 * A site is a texel, a vertex or a probe. It is sampled to the end in one go, so what it gets
 * depends on nothing but its number, and runs can stop and go on between sites. */
#ifndef AIR_BAKE_SITES_H
#define AIR_BAKE_SITES_H

#include "bake/gain.h"

/* What a site ends up with: a record of `stride` floats. */
enum {
    AIR_SITE_LIGHT = 0,     /* 9: layer by layer, RGB */
    AIR_SITE_VARIANCE = 9,  /* 3: of the mean luminance, layer by layer */
    AIR_SITE_VALIDITY = 12, /* share of samples that did not start inside of something */
    AIR_SITE_HARMONICS = 13 /* coefficient by coefficient, RGB; layer by layer where apart */
};

typedef struct air_site_list {
    const char *what; /* for progress: "texels" */
    size_t count;
    /* Draws a place of the site from two numbers in [0, 1); false if it has none. */
    bool (*draw)(const void *user, size_t site, const float u[2], air_path_receiver *out);
    const void *user;
    uint32_t seed;
    uint32_t samples;
    uint32_t
        through; /* so many of them ask for light by one event in media (air_path_source), those
                    with the lowest numbers: the first points of a sequence are even, too */
    uint32_t coefficients; /* of harmonics that are kept: 0, 4 or 9 */
    bool apart;            /* harmonics layer by layer, else their sum */
    float *records;        /* count * air_site_stride, set by the run */
} air_site_list;

static inline size_t air_site_stride(const air_site_list *list)
{
    return AIR_SITE_HARMONICS +
           (size_t)3 * list->coefficients * (list->apart ? (size_t)AIR_LAYER_COUNT : 1);
}

/* At least so much of a site's samples must be outside of solid things. */
#define AIR_SITE_VALID_SHARE 0.5f

enum { AIR_SITE_JOB = 64 }; /* sites that one worker takes at a time */

static inline size_t air_site_job_count(const air_site_list *list)
{
    return (list->count + AIR_SITE_JOB - 1) / AIR_SITE_JOB;
}

/* Keeps what is done, job by job (progress.h). NULL: nobody asks. */
typedef struct air_bake_progress air_bake_progress;

/* Runs all samples of one list. fraction_begin, fraction_end: how much of the whole bake is done
 * before and after. AIR_ERROR_INTERRUPTED when the progress callback says so. */
air_status air_sites_run(const air_path *path, air_site_list *list, air_bake_progress *progress,
                         double fraction_begin, double fraction_end);

#endif

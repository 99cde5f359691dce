/* state.h: what with_collimated.c sets up and light.c uses per ray. */
#ifndef AIR_RENDER_COLLIMATED_STATE_H
#define AIR_RENDER_COLLIMATED_STATE_H

#include "airlight/moment.h"
#include "render/collimated/with_collimated.h"
#include "scene/shadows.h"

/* A light that the method owns. */
typedef struct collimated_lamp {
    const air_light *light;
    air_collimated_mode mode;
    double to_light[3];
    air_shadow_view shadows; /* exact mode, and the box for moments */
    air_moment_map *moments; /* moment modes, else NULL; owned */
    double eye[3];           /* where they have all rays begin */
} collimated_lamp;

/* Of moments: does each ray weigh them by its own extinction? */
static inline bool collimated_own_weights(air_collimated_mode mode)
{
    return mode == AIR_COLLIMATED_MODE_ME_IDEAL || mode == AIR_COLLIMATED_MODE_ME6_IDEAL;
}

struct air_with_collimated {
    air_context *context;
    const air_path *path;
    const air_snapshot *snapshot;
    collimated_lamp *lamps;
    size_t lamp_count;
    bool surfaces, volume; /* is S0, M1 wanted? */
    bool ratio;
    /* Cells of all regions for each channel; one channel serves all where coefficients are grey. */
    size_t channels;
    air_collimated_cell *cells; /* [channel * region_count + region] */
    size_t region_count;
    size_t piece_limit;  /* of one profile */
    size_t window_limit; /* stretches that the windows of one light leave open; 1 at least */
};

/* One lamp along one camera ray. */
typedef struct collimated_beam {
    const collimated_lamp *lamp;
    air_collimated_profile *profiles; /* one per channel, windows cut out */
    air_vec3 factor;                  /* on the integrals: what all cells have in common */
    double origin[3], dir[3];
    float cosine;      /* between the ways of light before and after it scatters */
    double begin, end; /* where some profile has pieces */
    size_t open_count; /* stretches of scratch->open that windows leave, all if there are none */
} collimated_beam;

enum { COLLIMATED_INTERVALS = 128, COLLIMATED_STRETCHES = 16 };

/* A stretch of a lane's ray that waits for its shadows. */
typedef struct collimated_stretch {
    size_t lane;
    air_interval part;
} collimated_stretch;

/* A ray towards a light whose answer is waited for. */
typedef struct collimated_query {
    size_t lane;
    air_term term;
    bool ratio;
    air_vec3 value; /* what arrives if nothing is in between */
} collimated_query;

struct air_collimated_scratch {
    air_collimated_piece *pieces; /* of profiles [place * 3 + channel], piece_limit +
                                     window_limit each */
    air_collimated_profile *profiles;
    collimated_beam *beams;               /* one per lane, or per lamp that is sampled */
    air_collimated_profile plain;         /* before windows are cut out */
    air_collimated_profile lit[3];        /* per channel, restricted to lit stretches */
    air_collimated_cell *cells;           /* of the ray under way: with weights */
    air_interval *open;                   /* of the beam made last; window_limit */
    double *contributions;                /* of each lamp that is sampled */
    air_surface surfaces[AIR_PATH_LANES]; /* what the lanes' camera rays met */
    air_vec3 camera_transmittance[AIR_PATH_LANES];
    collimated_stretch stretches[COLLIMATED_STRETCHES];
    air_shadow_query shadow_queries[COLLIMATED_STRETCHES];
    air_interval shadows[COLLIMATED_STRETCHES][COLLIMATED_INTERVALS];
    size_t stretch_count;
    air_interval gaps[COLLIMATED_INTERVALS + 1];
    collimated_query queries[AIR_PATH_LANES];
    air_ray rays[AIR_PATH_LANES];
    uint8_t occluded[AIR_PATH_LANES];
    size_t query_count;
};

#endif

/* picture.h: one picture being rendered: what is the same for all its passes. */
#ifndef AIR_RENDER_PICTURE_H
#define AIR_RENDER_PICTURE_H

#include "core/pattern.h"
#include "image/film.h"
#include "path/path.h"
#include "render/arealight/with_arealight.h"
#include "render/collimated/with_collimated.h"
#include "render/ordinates/with_ordinates.h"
#include "render/owner.h"
#include "render/with_lightmap.h"
#include "scene/camera.h"

enum { AIR_FILTER_TABLE = 1024 };

typedef struct air_picture {
    air_context *context;
    const air_snapshot *snapshot;
    const air_render_params *params;
    uint32_t crop[4];
    air_camera_view view;
    air_sobol sobol;
    air_path path;
    air_owner_table *owners;
    uint8_t *wanted;
    air_with_collimated *collimated; /* NULL: that method owns nothing */
    air_with_arealight *arealight;   /* likewise */
    air_with_ordinates *ordinates;   /* likewise */
    air_with_lightmap *lightmap;     /* NULL: there is none, or nothing of it is wanted */
    bool apart;                      /* a slot for each term; else one for all */
    bool guides;                     /* slots for them */
    air_blue_noise *blue_noise;      /* NULL for other patterns */
    float *filter_table; /* inverse distribution function of a gaussian or of Mitchell's filter
                            without its sign, AIR_FILTER_TABLE + 1 values in pixels; else NULL */
    air_film_layout layout;
    double start_s; /* of the render, by the context's clock */
} air_picture;

air_status air_picture_init(air_picture *picture, air_context *context,
                            const air_snapshot *snapshot, const air_render_params *params);
void air_picture_finish(air_picture *picture);

/* An empty film for the picture. */
air_status air_picture_film(const air_picture *picture, air_film **out_film);

/* Renders samples [begin, end) of every pixel and adds them to the film; on failure or interruption
 * the film stays as it was. */
air_status air_picture_pass(air_picture *picture, air_film *film, uint32_t begin, uint32_t end);

/* Where within the picture a sample of pixel (x, y) with filter numbers u, v lies. Returns how much
 * it counts: 1, but of filters that are negative somewhere about 1.2 or -1.2, 1 in the mean. */
float air_picture_sample_position(const air_picture *picture, uint32_t x, uint32_t y, float u,
                                  float v, float *out_x, float *out_y);

#endif

/* past.h: what method ordinates knows of the picture before: light to begin from, where
 * the cells were, what the camera saw, and skies made ready.
 *
 * What is kept is either compared with the picture at hand (by value, or by a hash of the values
 * that it was made of) or good to begin from whatever that is, so no caller says what has changed.
 * past may be NULL, for there is none, but not to ord_past_init, ord_past_finish
 * and ord_past_keep_light. */
#ifndef AIR_RENDER_ORDINATES_PAST_H
#define AIR_RENDER_ORDINATES_PAST_H

#include "airlight/ordinates_dom.h"
#include "render/ordinates/domain.h"

struct air_environment_map;
struct air_environment_ordinates;

enum { ORD_IMPORTANCE_TEXELS = 512 /* AIR_IMPORTANCE_TEXELS */ };

/* Scattered light in a box of cells; numbered as air_dom_moments. */
typedef struct ord_past_light {
    float origin[3], cell_m, base[3]; /* base: of the lattice */
    size_t size[3];
    int bands;
    bool delta_m;
    double first[3]; /* see ord_past_light_at */
    uint64_t key;    /* of what it solves */
    float *moments;  /* NULL: none */
} ord_past_light;

/* A sky, by what it was made of. */
typedef struct ord_past_sky {
    uint64_t key;
    bool used; /* since ord_past_begin */
    struct air_environment_ordinates *ordinates;
    uint64_t blur_key;
    float *blurred; /* of sky.h; NULL: none */
} ord_past_sky;

typedef struct ord_past {
    air_context *context;
    ord_lattice lattice; /* cells 0: none */
    ord_past_light light;
    bool has_importance, new_importance; /* the latter: of the picture at hand */
    float importance[2][ORD_IMPORTANCE_TEXELS];
    ord_past_sky *skies;
    size_t sky_count;
    uint64_t history; /* hash of what the picture at hand took from here; 0: nothing */
} ord_past;

void ord_past_init(air_context *context, ord_past *past);
void ord_past_finish(ord_past *past);

/* Around a picture; the end is left out where it failed. */
void ord_past_begin(ord_past *past);
void ord_past_end(ord_past *past, const ord_domain *domain);

/* How the cells lay, or NULL. */
const ord_lattice *ord_past_lattice(const ord_past *past);

/* ---- light ---- */

/* Fills moments (of the domain's cells) with what the light there may be: the picture's before,
 * trilinear between its cells and held beyond them, moved along with the lattice, times the ratio
 * of `first` in each channel. False, and nothing is done, where there is none that fits. first:
 * power that is scattered out of unscattered light, or any number in proportion to all lights. */
bool ord_past_light_at(ord_past *past, const ord_domain *domain, const air_dom_params *dom,
                       const double first[3], float *moments);

/* Fills moments with the light that solves what has the key, as it was kept, if that is what was
 * kept, else false. */
bool ord_past_solution(ord_past *past, uint64_t key, float *moments);

/* Takes the moments (air_free'd later), which the caller has made with the context. key: differs
 * where the problem does, the place of its cells included. */
void ord_past_keep_light(ord_past *past, const ord_domain *domain, const air_dom_params *dom,
                         const double first[3], uint64_t key, float *moments);

/* ---- importance ---- */

/* Mixes a map with that of the picture before (0.8 of it) and keeps the result. */
void ord_past_mix_importance(ord_past *past, float map[ORD_IMPORTANCE_TEXELS]);

/* ---- skies ---- */

/* Like air_environment_ordinates_create, but the past owns the result where there is one: give it
 * back by ord_past_release_sky. */
air_status ord_past_prepare_sky(ord_past *past, air_context *context,
                                const struct air_environment_map *map,
                                struct air_environment_ordinates **out);
void ord_past_release_sky(const ord_past *past, struct air_environment_ordinates *ordinates);

/* A hash of a map's values, never 0. */
uint64_t ord_past_sky_key(const struct air_environment_map *map);

/* The sky with the key, blurred as blur_key says: copied to out if it is kept, else false; and kept
 * in its place. Numbers: count. */
bool ord_past_blurred_sky(ord_past *past, uint64_t key, uint64_t blur_key, float *out,
                          size_t count);
void ord_past_keep_blurred_sky(ord_past *past, uint64_t key, uint64_t blur_key,
                               const float *blurred, size_t count);

#endif

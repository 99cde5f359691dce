/* photons.h: light on its way from surface to surface, as a fixed set of rays: what
 * lights see of the scene, and what surfaces see of each other. */
#ifndef AIR_RENDER_ORDINATES_PHOTONS_H
#define AIR_RENDER_ORDINATES_PHOTONS_H

#include "render/ordinates/sources.h"

enum {
    ORD_PHOTONS = 32768,    /* that leave all lights together, unless there are very many */
    ORD_PHOTONS_LEAST = 64, /* of each light */
    ORD_ROUNDS = 8 /* from surface to surface that are followed; the rest is extrapolated */
};

/* A share of the light. World space. */
typedef struct ord_photon {
    air_vec3 position;      /* on a surface: above it by the surface's offset */
    air_vec3 normal;        /* of the surface, on the lit side */
    air_vec3 dir;           /* in which it goes on, unit */
    air_vec3 flux;          /* W; 0: it has come to its end */
    const air_light *light; /* it comes straight from; NULL: from a surface or a medium */
} ord_photon;

/* Rounds of as many photons: [round][photon]; round 0 leaves the lights, the others surfaces. */
typedef struct ord_photons {
    air_context *context;
    ord_photon *items;
    size_t count, rounds;
} ord_photons;

/* What they move in. extinction: three channels and their mean per cell of the domain, per metre.
 */
typedef struct ord_space {
    const air_path *path;
    const ord_domain *domain;
    const float *extinction;
} ord_space;

/* Photons of all lights that the method owns, none of them where nothing reflects. rounds: how
 * often light may be reflected; ORD_ROUNDS: without end, so that the last round stands for all that
 * would follow as well. On failure out is as after ord_photons_finish. */
air_status ord_photons_shoot(const ord_lighting *lighting, const ord_space *space, size_t rounds,
                             ord_photons *out);
void ord_photons_finish(ord_photons *photons); /* also of one that is all 0 */

/* Follows photons whose round 0 is filled; `rounds` of the others have room. */
void ord_photons_follow(const ord_space *space, size_t rounds, bool endless, ord_photons *photons);
air_status ord_photons_create(air_context *context, size_t count, size_t rounds, ord_photons *out);

#endif

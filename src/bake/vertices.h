/* vertices.h: light of the vertices of a mesh.
 *
 * Values at vertices are the ones whose interpolation over the triangles is nearest to the light on
 * the surface, in the sense of least squares [Kavan2011]: with hat functions h_i, the solution of
 * sum_j <h_i, h_j> v_j = <h_i, E>. The right side is sampled: a vertex' sites are drawn over its
 * triangles in proportion to its hat function. */
#ifndef AIR_BAKE_VERTICES_H
#define AIR_BAKE_VERTICES_H

#include "bake/sites.h"

typedef struct air_vertex_sites {
    const air_mesh *mesh;
    uint32_t *first;   /* of each vertex, and one more: its triangles in `corners` */
    uint32_t *corners; /* 3 * triangle + corner */
    float *cdf;        /* cumulative share of the area of a vertex' triangles */
    double *areas;     /* of each vertex: of all its triangles */
    double *triangles; /* areas */
} air_vertex_sites;

air_status air_vertex_sites_init(air_context *context, const air_mesh *mesh, air_vertex_sites *out);
void air_vertex_sites_finish(air_context *context, air_vertex_sites *sites);

/* air_site_list.draw, with air_vertex_sites as user; false for vertices without triangles. */
bool air_vertex_draw(const void *user, size_t site, const float u[2], air_path_receiver *out);

/* Gives vertices inside of something (valid 0) the means of their neighbours', from the outside
 * inwards: their darkness is nobody's, but least squares would spread it as waves. */
air_status air_vertex_fill(air_context *context, const air_vertex_sites *sites,
                           const uint8_t *valid, float *means);

/* Turns means over hat functions (3 per vertex) into values at the vertices. */
air_status air_vertex_solve(air_context *context, const air_vertex_sites *sites, float *values);

#endif

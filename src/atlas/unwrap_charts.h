/* unwrap_charts.h: triangles dealt out to flat charts. */
#ifndef AIR_ATLAS_UNWRAP_CHARTS_H
#define AIR_ATLAS_UNWRAP_CHARTS_H

#include "atlas/plane_grid.h"
#include "atlas/unwrap.h"
#include "atlas/unwrap_mesh.h"

/* A chart under way: its plane, and its triangles as a list. */
typedef struct air_flat_chart {
    double normal[3], axis[2][3]; /* right-handed: axis 0, axis 1, normal */
    double cell;                  /* of its grid, metres */
    double area;
    uint32_t first, last; /* triangles; UINT32_MAX: none (joined to another) */
    size_t triangle_count;
} air_flat_chart;

typedef struct air_flat_charts {
    air_flat_chart *charts;
    size_t count, capacity;
    uint32_t *of_triangle; /* AIR_NO_CHART: no area and no neighbour with one */
    uint32_t *next;        /* the next triangle in a chart's list */
} air_flat_charts;

/* Grows charts, then joins tiny ones. Fails for want of memory only, without a message; finish it
 * in any case. */
air_status air_flat_charts_init(air_context *context, const air_unwrap_mesh *mesh,
                                const air_unwrap_params *params, air_flat_charts *out_charts);
void air_flat_charts_finish(air_context *context, air_flat_charts *charts);

/* Steps of the above. Lays a triangle into a chart's plane; false where it turns away from it. */
bool air_flat_chart_lay(const air_unwrap_mesh *mesh, const air_flat_chart *chart, uint32_t triangle,
                        air_flat_triangle *out_flat);
void air_flat_chart_append(air_flat_charts *self, uint32_t chart, uint32_t triangle);
air_status air_flat_charts_join_tiny(air_context *context, const air_unwrap_mesh *mesh,
                                     const air_unwrap_params *params, air_flat_charts *self,
                                     air_plane_grid *grid);

#endif

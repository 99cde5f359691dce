/* godot.h: the parts of Godot's LightmapGIData (docs/lightmap-engines.md). */
#ifndef AIR_LIGHTMAP_GODOT_H
#define AIR_LIGHTMAP_GODOT_H

#include "airlight/lightmap.h"
#include "image/format.h"

/* printf into a sink; false when memory is out. */
bool air_godot_print(air_sink *sink, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- godot_nodes.c ---- */

/* The property user_data: which node has which slice. widest and highest: the size of slices. */
air_status air_godot_print_users(air_context *context, const air_lightmap *lightmap,
                                 const char *scene_path, size_t widest, size_t highest,
                                 air_sink *sink);

/* ---- godot_probes.c ---- */

/* The property probe_data: points, harmonics, tetrahedra and the tree that finds them; without
 * probes an empty one. */
air_status air_godot_print_probes(air_context *context, const air_lightmap *lightmap, float unit,
                                  air_sink *sink);

#endif

/* mitsuba.h: a Mitsuba XML scene, of any version from 0.4 to 3, while it is being read.
 *
 * Names of parameters are those of version 3, snake_case; expand.c has rewritten older ones.
 * Meanings and defaults are those of the documentation and sources of Mitsuba 0.6 and 3
 * [Mitsuba06, Mitsuba3]. Texture coordinates run as Mitsuba's, whose v is airlight's: row 0 of an
 * image lies at v = 0. */
#ifndef AIR_SCENE_IMPORT_MITSUBA_MITSUBA_H
#define AIR_SCENE_IMPORT_MITSUBA_MITSUBA_H

#include "scene/import/import.h"
#include "scene/import/mesh_file.h"
#include "scene/import/mitsuba/xml.h"

/* <path> elements of a scene. */
enum { AIR_MITSUBA_FOLDERS = 64 };

/* A shape, a light or a sensor; a shape once for each place that instances put it at. */
typedef struct air_mitsuba_item {
    air_xml *at;
    float instance_to_world[12]; /* identity for what is in the scene itself */
    bool opaque;                 /* a shape that lets no light through */
} air_mitsuba_item;

/* What an element has become, for those that refer to it again. */
typedef struct air_mitsuba_made {
    const air_xml *with; /* decides beside the element: a material's emitter; or NULL */
    air_handle handle;
    bool clear; /* a material that lets light through */
    struct air_mitsuba_made *next;
} air_mitsuba_made;

/* A medium in a boundary, until all are known and their order is clear. */
typedef struct air_mitsuba_region {
    const air_xml *at; /* the shape, for messages */
    air_medium_desc desc;
    air_phase_mixture mixture;
    air_import_geometry geometry; /* a mesh's triangles, which the boundary refers to; owned */
    float low[3], high[3];        /* world bounds */
    struct air_mitsuba_region *next;
} air_mitsuba_region;

/* The bytes of a file; path NULL: of none. */
typedef struct air_mitsuba_bytes {
    char *path;
    void *data;
    size_t size;
} air_mitsuba_bytes;

typedef struct air_mitsuba {
    air_context *context;
    air_import *import;
    const char *path;
    char *folder;
    air_xml_document document;
    air_xml *scene;     /* the root, with includes in place */
    json_t *parameters; /* name: value */
    json_t *wanted;     /* names of parameters that the scene asks for: true */
    json_t *names;      /* id: number of the element, or the id that an alias stands for */
    air_xml **named;    /* elements with an id */
    size_t named_count, named_capacity;
    const char *folders[AIR_MITSUBA_FOLDERS]; /* of <path>, with their final slash */
    size_t folder_count, include_count;
    air_mitsuba_item *items;
    size_t item_count, item_capacity;
    air_mitsuba_region *regions;       /* the last one first */
    air_mitsuba_bytes shapes;          /* the .serialized read last: it may hold many shapes */
    const air_xml *sensor;             /* the first one, NULL: none */
    size_t nesting;                    /* of what is being read: references may go in circles */
    bool both_sides;                   /* what is being read is within <bsdf type="twosided"> */
    float light_scale, emission_scale; /* from the file's units to radiometric ones */
} air_mitsuba;

/* Of versions below 2. */
static inline bool air_mitsuba_is_old(const air_xml *at) { return at->version < 2.0; }

/* ---- expand.c ---- */

/* Reads the file and those it includes, puts in parameters and notes names. */
air_status air_mitsuba_expand(air_mitsuba *mitsuba);
/* An element, or what a <ref> refers to. */
air_status air_mitsuba_resolve(const air_mitsuba *mitsuba, air_xml *at, air_xml **out);

/* ---- file_path.c ---- */

/* The parameter that names an element's file, which must be there. */
air_status air_mitsuba_filename(const air_mitsuba *mitsuba, const air_xml *at,
                                const char **out_name);

/* Where a file that an element names lies: beside the file it stands in, beside the scene, or in a
 * <path>; a fresh string. Refuses what is outside the scene's folder unless params say otherwise.
 */
air_status air_mitsuba_file(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                            char **out_path);

/* ---- value.c: parameters by name; absent ones leave *value as it is ---- */

air_status air_mitsuba_fail(const air_mitsuba *mitsuba, const air_xml *at, air_status status,
                            const char *sentence, ...) __attribute__((format(printf, 4, 5)));
air_status air_mitsuba_warn(const air_mitsuba *mitsuba, const air_xml *at, const char *sentence,
                            ...) __attribute__((format(printf, 3, 4)));
/* AIR_ERROR_UNSUPPORTED, or with --lenient a warning that says what is done instead. */
air_status air_mitsuba_replace(const air_mitsuba *mitsuba, const air_xml *at, const char *what,
                               const char *instead);
/* The same for an unknown plugin, with the nearest of the known names. */
air_status air_mitsuba_unknown_type(const air_mitsuba *mitsuba, const air_xml *at,
                                    const char *const *types, size_t count, const char *instead);

const char *air_mitsuba_type(const air_xml *at); /* "" if it has none */
bool air_mitsuba_is(const air_xml *at, const char *type);
/* The parameter of that name, marked as used; NULL: absent. */
air_xml *air_mitsuba_parameter(const air_xml *at, const char *name);
bool air_mitsuba_has(const air_xml *at, const char *name);
/* Marks parameters that change nothing here as used. */
void air_mitsuba_ignore(const air_xml *at, const char *const *names, size_t count);

/* The parameter of that name where textures are not supported: those are an error, or with
 * --lenient a warning, and as if absent. NULL: absent. */
air_status air_mitsuba_plain(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                             const air_xml **out);

air_status air_mitsuba_float(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                             float *value);
air_status air_mitsuba_integer(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                               long *value);
/* The same in a range. */
air_status air_mitsuba_integer_within(const air_mitsuba *mitsuba, const air_xml *at,
                                      const char *name, long least, long most, long *value);
air_status air_mitsuba_boolean(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                               bool *value);
air_status air_mitsuba_string(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              const char **value);
/* A <point> or <vector>. */
air_status air_mitsuba_vector(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              float value[3]);
/* One of the words, which do not tell upper from lower case. */
air_status air_mitsuba_choice(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                              const char *const *words, size_t count, size_t *value);

/* An element's x, y and z, of which absent ones stay, or its value. */
air_status air_mitsuba_read_vector(const air_mitsuba *mitsuba, const air_xml *at, double value[3]);
/* Numbers between blanks and commas: an element's attribute as 1 to `most` of them. */
air_status air_mitsuba_numbers(const air_mitsuba *mitsuba, const air_xml *at, const char *attribute,
                               size_t most, double *out, size_t *out_count);

/* The next child from *from on, followed through references, with one of these tags; NULL: none. */
air_status air_mitsuba_next(const air_mitsuba *mitsuba, air_xml **from, const char *tag,
                            air_xml **out_child, air_xml **out_target);
/* The child of that tag, by parameter name if not NULL; NULL if absent. */
air_status air_mitsuba_child(const air_mitsuba *mitsuba, const air_xml *at, const char *tag,
                             const char *name, air_xml **out_target);

/* ---- color.c ---- */

typedef enum air_mitsuba_quantity {
    AIR_MITSUBA_REFLECTANCE = 0, /* and all that is seen in white light */
    AIR_MITSUBA_EMISSION = 1
} air_mitsuba_quantity;

/* Is this a <float>, <rgb>, <spectrum> or such? */
bool air_mitsuba_is_color(const air_xml *at);
air_status air_mitsuba_read_color(const air_mitsuba *mitsuba, const air_xml *at,
                                  air_mitsuba_quantity quantity, float out[3]);
air_status air_mitsuba_color(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                             air_mitsuba_quantity quantity, float value[3]);

/* ---- transform.c ---- */

/* 3 rows of 4. */
air_status air_mitsuba_transform(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                 float value[12]);

/* ---- mitsuba.c ---- */

/* A name for what is made of an element: its id, or its type. */
const char *air_mitsuba_name(const air_xml *at);
air_mitsuba_made *air_mitsuba_find_made(const air_xml *at, const air_xml *with);
/* NULL when memory is out. */
air_mitsuba_made *air_mitsuba_note_made(air_mitsuba *mitsuba, air_xml *at, const air_xml *with,
                                        air_handle handle);
/* An item, and the object by which sidecars know it; NULL when memory is out. */
air_import_object *air_mitsuba_add_item(air_mitsuba *mitsuba, air_xml *at, const air_xml *named,
                                        const float instance_to_world[12]);
/* Around what may refer to itself: fails where it goes too deep. */
air_status air_mitsuba_enter(air_mitsuba *mitsuba, air_xml *at);
void air_mitsuba_leave(air_mitsuba *mitsuba);

/* ---- sensor.c, film.c ---- */

air_status air_mitsuba_add_sensor(air_mitsuba *mitsuba, air_xml *at, const char *name);
/* The tangent of half the angle that the picture's height fills; aspect: width over height. */
air_status air_mitsuba_read_fov(const air_mitsuba *mitsuba, const air_xml *at, double aspect,
                                double *out_tangent);
/* Size, crop, filter and samples of a sensor. */
air_status air_mitsuba_read_film(const air_mitsuba *mitsuba, const air_xml *sensor,
                                 air_film_hint *film);

/* ---- texture.c ---- */

/* A parameter that is a colour or a texture: *value is the colour, or what the texture is to be
 * multiplied by. */
air_status air_mitsuba_textured(air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                air_mitsuba_quantity quantity, float value[3],
                                air_texture_ref *ref);
/* A texture element; linear: its numbers are no colours. */
air_status air_mitsuba_texture(air_mitsuba *mitsuba, air_xml *at, bool linear, float out_scale[3],
                               air_texture_ref *ref);

/* ---- bsdf.c, interface.c ---- */

/* The material of a shape, with the emission of its emitter. *out_clear: it lets light through;
 * *out_handle AIR_NONE: there is nothing to be seen. */
air_status air_mitsuba_material(air_mitsuba *mitsuba, air_xml *shape, air_handle *out_handle,
                                bool *out_clear);
/* What a bsdf element says; the parts of a blend are added to the scene. */
air_status air_mitsuba_read_bsdf(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc);
/* Those that are made of interfaces: dielectrics, conductors and plastics. */
bool air_mitsuba_is_interface(const air_xml *at);
air_status air_mitsuba_read_interface(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc);

/* ---- emitter.c, sky.c ---- */

air_status air_mitsuba_add_emitter(air_mitsuba *mitsuba, air_xml *at, const char *name,
                                   bool casts_shadow);
air_status air_mitsuba_add_sky(air_mitsuba *mitsuba, air_xml *at, const char *name);

/* ---- shape.c, solid.c ---- */

/* A shape in its own space. */
typedef struct air_mitsuba_geometry {
    air_shape shape;
    float to_world[12]; /* of the arrays or the unit quadric */
    bool flip_normals;
    bool box;           /* the cube [-1, 1]^3 */
    air_mesh_file mesh; /* uv as airlight has them; no colours */
} air_mitsuba_geometry;

/* The light of a shape whose emitter is collimated along its normal. */
air_status air_mitsuba_add_collimated(air_mitsuba *mitsuba, air_xml *emitter, const air_xml *shape,
                                      const air_mitsuba_geometry *geometry, const char *name);
/* Adds a shape's triangles in world space. */
air_status air_mitsuba_append_triangles(air_context *context, const air_mitsuba_geometry *shape,
                                        air_import_geometry *geometry);
/* Collects a shape, or what an instance stands for. */
air_status air_mitsuba_collect_shape(air_mitsuba *mitsuba, air_xml *at);
air_status air_mitsuba_read_geometry(air_mitsuba *mitsuba, const air_mitsuba_item *item,
                                     air_mitsuba_geometry *out);
void air_mitsuba_bytes_finish(air_context *context, air_mitsuba_bytes *bytes);
void air_mitsuba_geometry_finish(air_context *context, air_mitsuba_geometry *geometry);
/* Rectangle and cube. */
air_status air_mitsuba_solid(air_context *context, const air_xml *at, air_mitsuba_geometry *out);
air_status air_mitsuba_add_shape(air_mitsuba *mitsuba, const air_import_object *object);
/* air_import.append_geometry; user is the air_mitsuba. */
air_status air_mitsuba_append_geometry(void *user, const air_import_object *object,
                                       air_import_geometry *geometry);

/* ---- medium.c, volume.c, region.c ---- */

/* All but the boundary. */
air_status air_mitsuba_read_medium(air_mitsuba *mitsuba, air_xml *at, air_medium_desc *desc,
                                   air_phase_mixture *mixture);
/* Density and albedo of a heterogeneous medium. */
air_status air_mitsuba_read_volumes(air_mitsuba *mitsuba, air_xml *at, float scale,
                                    air_medium_desc *desc);
/* Notes the medium inside a shape, if it has one. clear: the shape lets light through. */
air_status air_mitsuba_note_region(air_mitsuba *mitsuba, const air_mitsuba_item *item,
                                   const air_mitsuba_geometry *geometry, bool clear);
/* Adds all media, with their order. */
air_status air_mitsuba_add_regions(air_mitsuba *mitsuba);
void air_mitsuba_regions_finish(air_mitsuba *mitsuba);

#endif

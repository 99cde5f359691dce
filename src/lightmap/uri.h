/* uri.h: what glTF files refer to: data URIs and files beside them. */
#ifndef AIR_LIGHTMAP_URI_H
#define AIR_LIGHTMAP_URI_H

#include "lightmap/place.h"

/* Reads what the URI at a place means: base64 or percent-encoded data, or a file relative to
 * `folder` ("" or with a final slash). *out_data is freed with air_free. *out_kind: a fresh string,
 * the media type of a data URI, or the ending of the file (".png"), "" if there is none. */
air_status air_uri_read(const air_place *at, const char *folder, void **out_data, size_t *out_size,
                        char **out_kind);

/* The folder of a path, "" or with its final slash; NULL when memory is out. */
char *air_uri_folder(air_context *context, const char *path);

/* A file name as a URI: all but letters, digits and -._~ as %XX; NULL when memory is out. */
char *air_uri_encode(air_context *context, const char *name);

#endif

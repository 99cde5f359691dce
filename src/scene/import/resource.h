/* resource.h: what a scene file refers to: data URIs and files relative to its folder. */
#ifndef AIR_SCENE_IMPORT_RESOURCE_H
#define AIR_SCENE_IMPORT_RESOURCE_H

#include "scene/import/json_place.h"

/* The folder of a path, "" or with its final slash; NULL when memory is out. */
char *air_path_folder(air_context *context, const char *path);
/* The path without the extension of its last part, with `ending` behind it. */
char *air_path_with_ending(air_context *context, const char *path, const char *ending);
/* A path as a sidecar gives it: relative to `folder` unless absolute. */
char *air_path_join(air_context *context, const char *folder, const char *path);

/* Reads what the glTF URI at a place means: base64 or percent-encoded data, or a file relative to
 * the document's folder. *out_data is freed by the caller with air_free; one NUL byte follows it.
 * *out_what (a fresh string) names the source in messages: the file's path or the JSON path. URIs
 * with a scheme or a leading slash are refused. */
air_status air_resource_read(const air_json *at, void **out_data, size_t *out_size,
                             char **out_what);

/* Decodes base64 (RFC 4648, padding optional) into out, which has room for 3*(length/4)+3 bytes.
 * Returns the number of bytes, SIZE_MAX if the text is not base64. */
size_t air_base64_decode(const char *text, size_t length, uint8_t *out);

#endif

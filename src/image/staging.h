/* staging.h: several files that appear together or not at all.
 *
 * Files are written into a hidden folder beside their final names and moved when all are there. The
 * last one added is the index: it is removed before the first file moves and moved last, so where
 * it is, the set is whole. Only a crash between two renames can leave a set without its index. */
#ifndef AIR_IMAGE_STAGING_H
#define AIR_IMAGE_STAGING_H

#include <jansson.h>

#include "airlight/image.h"
#include "core/host.h"

typedef struct air_staging {
    air_context *context;
    char *folder;    /* where the files will be; "." where none was named */
    char *temporary; /* where they are until then */
    int folder_file,
        temporary_file; /* both, open: what needs no memory cannot fail for want of it */
    char **names;
    size_t count, capacity;
    bool folder_made;
    bool replaced; /* an older index was there */
} air_staging;

/* Makes the folder, and those above it, where they are missing. Finish it also after a failure. */
air_status air_staging_begin(air_context *context, const char *folder, air_staging *out);
/* Adds files. name: a plain file name; an image is an EXR unless it ends in .png or .ktx2. Messages
 * name the file as it will be called. */
air_status air_staging_add(air_staging *self, const char *name, const void *data, size_t size);
air_status air_staging_add_image(air_staging *self, const char *name, const air_image *image,
                                 const air_image_save_params *params);
/* Takes root. */
air_status air_staging_add_json(air_staging *self, const char *name, json_t *root);
/* A glTF file of one piece: JSON text, and the chunk that buffer 0 is, which may be empty.
 * AIR_ERROR_UNSUPPORTED: together beyond 4 GiB. */
air_status air_staging_add_glb(air_staging *self, const char *name, const char *text,
                               const void *binary, size_t binary_size);
/* Moves all files to where they belong. */
air_status air_staging_commit(air_staging *self);
/* After a commit that replaced an older set: removes PREFIX<i>.exr for i = first, first + 1, ... as
 * long as there are such files; the older set had more of them. */
void air_staging_remove_old(const air_staging *self, const char *prefix, size_t first);
/* Removes what was not moved and lets go of everything. */
void air_staging_finish(air_staging *self);

#endif

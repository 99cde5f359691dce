/* progress.h: what of a bake is done, kept in a file, so that an interrupted bake can go on.
 *
 * The file is a header that says of which bake it is, then one record for each job done: list, job,
 * a checksum, the job's records. It grows at its end only; a record that was cut off is forgotten.
 * It is not for other machines: numbers are in the machine's own order of bytes. */
#ifndef AIR_BAKE_PROGRESS_H
#define AIR_BAKE_PROGRESS_H

#include "bake/sites.h"

/* path is made, or, if it is of the bake with this fingerprint and `resume` is set, read. Otherwise
 * begun anew. */
air_status air_bake_progress_open(air_context *context, const char *path, uint64_t fingerprint,
                                  bool resume, air_bake_progress **out_progress);
/* Closes the file; removes it if the bake is complete. NULL is legal, here and below. */
void air_bake_progress_close(air_bake_progress *progress, bool complete);

/* Lists are entered in the order of the bake; fills in records that the file has. */
air_status air_bake_progress_enter(air_bake_progress *progress, air_site_list *list);
bool air_bake_progress_has(const air_bake_progress *progress, size_t job);
/* Appends a job that is done. Thread-safe. AIR_ERROR_IO, without a message: the thread that began
 * the bake gives it, by air_bake_progress_fail. */
air_status air_bake_progress_keep(air_bake_progress *progress, const air_site_list *list,
                                  size_t job);
/* AIR_ERROR_IO, with what the first write that failed met. */
air_status air_bake_progress_fail(const air_bake_progress *progress);
/* How many jobs came from the file. */
size_t air_bake_progress_resumed(const air_bake_progress *progress);

#endif

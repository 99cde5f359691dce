#include "bake/progress.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char magic[8] = {'a', 'i', 'r', 'b', 'a', 'k', 'e', '1'};

typedef struct header {
    char magic[8];
    uint64_t fingerprint;
} header;

/* Before each job's floats. */
typedef struct entry {
    uint32_t list, job, floats, checksum;
} entry;

struct air_bake_progress {
    air_context *context;
    char *path;
    FILE *file;
    pthread_mutex_t lock;
    char *old; /* what the file held when it was opened */
    size_t old_size;
    uint32_t list; /* under way, counted from 1 */
    uint8_t *has;  /* its jobs */
    size_t resumed;
    int error; /* errno of the first write that failed */
};

/* Of a job's floats and of where they belong. */
static uint32_t checksum(uint32_t list, uint32_t job, const float *values, size_t count)
{
    uint32_t sum = air_hash_combine(air_hash_combine((uint32_t)count, list), job);
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        sum = air_hash_combine(sum, bits);
    }
    return sum;
}

static air_status fail_write(const air_bake_progress *self, int error)
{
    return air_fail(self->context, AIR_ERROR_IO, "%s: writing the bake's progress: %s", self->path,
                    strerror(error));
}

/* ---- opening ---- */

/* The next entry of the old file at *place, which is moved behind it; NULL at the end, or where the
 * file was cut off or is damaged. Floats may lie unaligned. */
static const char *next_entry(const air_bake_progress *self, size_t *place, entry *out)
{
    if (self->old_size - *place < sizeof *out) {
        return NULL;
    }
    memcpy(out, self->old + *place, sizeof *out);
    const size_t size = (size_t)out->floats * sizeof(float);
    if (self->old_size - *place - sizeof *out < size) {
        return NULL;
    }
    const char *floats = self->old + *place + sizeof *out;
    *place += sizeof *out + size;
    return floats;
}

/* How much of the old file is whole. */
static size_t whole_size(const air_bake_progress *self)
{
    size_t place = sizeof(header);
    entry at;
    while (next_entry(self, &place, &at) != NULL) {
    }
    return place;
}

static air_status read_old(air_bake_progress *self, uint64_t fingerprint)
{
    void *data = NULL;
    header head;
    const air_status status =
        air_file_read_optional(self->context, self->path, &data, &self->old_size);
    self->old = data;
    if (status != AIR_OK || data == NULL) {
        return status;
    }
    /* a header that was cut off is still the beginning of one */
    const size_t known = self->old_size < sizeof magic ? self->old_size : sizeof magic;
    if (memcmp(data, magic, known) != 0) {
        return air_fail(self->context, AIR_ERROR_FORMAT,
                        "%s: expected the progress of a bake by this version of airlight, or no "
                        "such file",
                        self->path);
    }
    if (self->old_size < sizeof head) {
        self->old_size = 0;
        return AIR_OK;
    }
    memcpy(&head, data, sizeof head);
    if (head.fingerprint != fingerprint) {
        air_warn(self->context,
                 "%s: is the progress of another bake (the scene or an option differs): the bake "
                 "begins anew",
                 self->path);
        self->old_size = 0;
    }
    return AIR_OK;
}

/* Opens the file behind what is whole of it, or begins it. */
static air_status open_file(air_bake_progress *self, uint64_t fingerprint)
{
    const size_t keep = self->old_size > 0 ? whole_size(self) : 0;
    self->file = fopen(self->path, keep > 0 ? "r+b" : "wb");
    if (self->file == NULL) {
        return fail_write(self, errno);
    }
    self->old_size = keep;
    if (keep > 0) {
        return ftruncate(fileno(self->file), (off_t)keep) == 0 &&
                       fseek(self->file, 0, SEEK_END) == 0
                   ? AIR_OK
                   : fail_write(self, errno);
    }
    header head = {.fingerprint = fingerprint};
    memcpy(head.magic, magic, sizeof magic);
    return fwrite(&head, sizeof head, 1, self->file) == 1 && fflush(self->file) == 0
               ? AIR_OK
               : fail_write(self, errno);
}

air_status air_bake_progress_open(air_context *context, const char *path, uint64_t fingerprint,
                                  bool resume, air_bake_progress **out_progress)
{
    air_bake_progress *self = air_allocate(context, 1, sizeof *self);
    *out_progress = NULL;
    if (self == NULL) {
        return air_fail_memory(context, path);
    }
    self->context = context;
    (void)pthread_mutex_init(&self->lock, NULL);
    self->path = air_string_copy(context, path);
    air_status status = self->path == NULL ? air_fail_memory(context, path) : AIR_OK;
    if (status == AIR_OK && resume) {
        status = read_old(self, fingerprint);
    }
    if (status == AIR_OK) {
        status = open_file(self, fingerprint);
    }
    if (status != AIR_OK) {
        air_bake_progress_close(self, false);
        return status;
    }
    *out_progress = self;
    return AIR_OK;
}

void air_bake_progress_close(air_bake_progress *self, bool complete)
{
    if (self == NULL) {
        return;
    }
    if (self->file != NULL) {
        (void)fclose(self->file);
        if (complete) {
            (void)remove(self->path);
        }
    }
    (void)pthread_mutex_destroy(&self->lock);
    air_free(self->context, self->old);
    air_free(self->context, self->has);
    air_free(self->context, self->path);
    air_free(self->context, self);
}

/* ---- the run ---- */

static size_t job_floats(const air_site_list *list, size_t job)
{
    const size_t first = job * AIR_SITE_JOB, rest = list->count - first;
    return (rest < AIR_SITE_JOB ? rest : AIR_SITE_JOB) * air_site_stride(list);
}

static float *job_records(const air_site_list *list, size_t job)
{
    return list->records + job * AIR_SITE_JOB * air_site_stride(list);
}

air_status air_bake_progress_enter(air_bake_progress *self, air_site_list *list)
{
    size_t place = sizeof(header);
    const char *floats;
    entry at;
    if (self == NULL) {
        return AIR_OK;
    }
    air_free(self->context, self->has);
    self->has = air_allocate(self->context, air_site_job_count(list), 1);
    if (self->has == NULL) {
        return air_fail_memory(self->context, self->path);
    }
    self->list++;
    while (self->old_size > 0 && (floats = next_entry(self, &place, &at)) != NULL) {
        if (at.list == self->list && at.job < air_site_job_count(list) &&
            at.floats == job_floats(list, at.job)) {
            float *records = job_records(list, at.job);
            memcpy(records, floats, at.floats * sizeof(float));
            const bool sound = checksum(at.list, at.job, records, at.floats) == at.checksum;
            self->resumed += sound && !self->has[at.job];
            self->has[at.job] = sound;
        }
    }
    return AIR_OK;
}

bool air_bake_progress_has(const air_bake_progress *self, size_t job)
{
    return self != NULL && self->has[job];
}

air_status air_bake_progress_keep(air_bake_progress *self, const air_site_list *list, size_t job)
{
    if (self == NULL) {
        return AIR_OK;
    }
    const size_t floats = job_floats(list, job);
    const float *records = job_records(list, job);
    const entry head = {self->list, (uint32_t)job, (uint32_t)floats,
                        checksum(self->list, (uint32_t)job, records, floats)};
    (void)pthread_mutex_lock(&self->lock);
    if (self->error == 0) { /* nothing behind an entry that may be cut off */
        const bool written = fwrite(&head, sizeof head, 1, self->file) == 1 &&
                             fwrite(records, sizeof *records, floats, self->file) == floats &&
                             fflush(self->file) == 0;
        self->error = written ? 0 : errno != 0 ? errno : EIO;
    }
    const air_status status = self->error == 0 ? AIR_OK : AIR_ERROR_IO;
    (void)pthread_mutex_unlock(&self->lock);
    return status;
}

air_status air_bake_progress_fail(const air_bake_progress *self)
{
    return fail_write(self, self->error);
}

size_t air_bake_progress_resumed(const air_bake_progress *self)
{
    return self != NULL ? self->resumed : 0;
}

/* seen.h: what the versions of source functions and moments of beams share. */
#ifndef AIR_ORDINATES_SEEN_H
#define AIR_ORDINATES_SEEN_H

#include "airlight/ordinates_view.h"
#include "core/vec.h"

enum { SEEN_CHANNELS = 4, SEEN_RUN = 64 /* cells of a row at a time */ };

/* Lobes of a phase function: its own, or itself. */
typedef struct seen_lobes {
    air_phase_lobe only;
    const air_phase_lobe *lobes;
    size_t count;
} seen_lobes;

void seen_find_lobes(air_phase phase, seen_lobes *out);

/* The peak begins at a cosine. */
typedef struct seen_cap {
    float cosine, value;
} seen_cap;

/* Above its value lies the peak's share; without a peak that is more than any value. */
seen_cap seen_cap_of(const seen_lobes *phase, const air_seen_beam *beam, const air_seen_peak *peak);

/* What is above the cap ahead is shown once on the way, as (1 - exp(-d)) / d of each event, d the
 * optical depth of the peak's events on all of it. For `count` cells from `cell` on. */
void seen_cap_values(const air_seen_peak *peak, seen_cap cap, const air_seen_beam *beam,
                     size_t cell, size_t count, const float cosine[SEEN_RUN],
                     float value[SEEN_RUN]);

typedef void seen_moments(const air_seen_box *box, int bands, const float *moments,
                          const double *factors, size_t begin, size_t end, float *out);
typedef void seen_beams(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                        air_phase phase, const air_seen_peak *peak, size_t begin, size_t end,
                        float *out);
typedef void seen_beam_moments(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                               int bands, size_t begin, size_t end, float *out);

typedef struct seen_kernel {
    seen_moments *moments;
    seen_beams *beams;
    seen_beam_moments *beam_moments;
} seen_kernel;

extern const seen_kernel seen_sse42, seen_avx2, seen_avx512;

#endif

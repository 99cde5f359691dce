/* oracle_ordinates.h: what the parts of oracle_ordinates share: what was simulated, what photons
 * gave, and how it is said what a mode makes of it. */
#ifndef AIR_TESTS_ORACLE_ORDINATES_H
#define AIR_TESTS_ORACLE_ORDINATES_H

#include <stdbool.h>
#include <stddef.h>

#include "airlight/context.h"

enum { STEM = 64, PATH = 4096, BINS = 20 };

/* A row of the table of parameters. */
typedef struct simulated {
    char stem[STEM];
    size_t cells;  /* along an edge of the cube, or of the octahedral square */
    size_t shells; /* 0: a cube */
    double size_m; /* edge, or radius */
    double sigma_s, sigma_a, g;
    double light; /* irradiance on z = 0 along +z, or power of the point */
} simulated;

/* Finds the row of a stem in the folder's parameters.csv or, failing that, in the table beside the
 * tests; `file` is what needs it. False, and said, where there is none or it makes no sense. */
bool simulated_find(const char *folder, const char *file, const char *stem, simulated *out);

/* ---- files of the folder ---- */

enum { CUBE_FLUENCE, CUBE_ANGULAR, CUBE_EXIT, CUBE_FILES };

/* The six faces' shares of what enters, -x .. +z, and what is absorbed. */
enum { FACES = 6, LEAVES = FACES + 1 };

/* What photons gave; cubes of n^3 cells. */
typedef struct cube_truth {
    bool has[CUBE_FILES];
    char path[CUBE_FILES][PATH];
    float *fluence; /* six planes: fluence, its error, unscattered, flux along x, y, z */
    float *angular; /* mean and error of scattered fluence by [k][i][cosine to z], of two slices */
    double leaves[LEAVES];
    double events, mean; /* scattering events per photon; fluence; NAN: not given */
} cube_truth;

/* Reads whichever of a cube's files there are. False, and said, where one is broken. */
bool cube_truth_read(const char *folder, const simulated *what, cube_truth *out);
void cube_truth_finish(cube_truth *self);

/* Columns of a shell. */
enum { SHELL_INNER, SHELL_OUTER, SHELL_BEAM, SHELL_SCATTERED, SHELL_BINS };
enum { SHELL_COLUMNS = SHELL_BINS + BINS };

/* shells rows; to be freed. NULL, and said, where the file is broken. */
typedef double shell_truth[SHELL_COLUMNS];
shell_truth *shell_truth_read(const char *path, const simulated *what);

/* ---- judging ---- */

typedef struct verdict {
    const char *path; /* of the file that is judged */
    int missed;
} verdict;

/* Said, but not judged: accepted between these. */
#define ANY_LEAST (-1e300)
#define ANY_MOST  1e300

/* Says what a mode's error is beside what is accepted. */
void verdict_tell(verdict *self, const char *mode, const char *quantity, double found, double least,
                  double most);

/* The contexts to run in: plain doubles, and the best floats there are. */
typedef struct judges {
    air_context *doubles, *floats;
} judges;

/* How many acceptances are missed; -1, and said, where something could not be run. */
int cube_judge(const judges *with, const simulated *what, const cube_truth *truth);
int shells_judge(const judges *with, const simulated *what, const char *path,
                 const shell_truth *truth);

#endif

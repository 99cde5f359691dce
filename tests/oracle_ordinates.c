/* Holds the ordinates kernels against photons that were counted:
 *
 *     oracle_ordinates [--skip-absent] FOLDER...
 *
 * Of a folder: cube_NAME_fluence.f32, cube_NAME_angular.f32, cube_NAME_exit.csv, a cube under a
 * beam, and radial_NAME.csv, shells around a point light. What was simulated is looked up by
 * cube_NAME or radial_NAME in the folder's parameters.csv, if there is one, and in
 * tests/data/ordinates_parameters.csv. Prints the errors of every mode beside what is accepted.
 * Exit codes: 0 all within what is accepted, 1 not, 2 a file that is broken or unknown, 77 the
 * folder is absent and --skip-absent was given. */
#include "oracle_ordinates.h"

#include <dirent.h>
#include <stdlib.h>

#include "oracle.h"

void verdict_tell(verdict *self, const char *mode, const char *quantity, double found, double least,
                  double most)
{
    const bool fine = found >= least && found <= most;
    printf("  %-44s %-26s %.3g", mode, quantity, found);
    if (least > 0.0 && most < ANY_MOST) {
        printf(", accepted %.4g to %.4g", least, most);
    } else if (least > 0.0) {
        printf(", accepted from %.4g on", least);
    } else if (most < ANY_MOST) {
        printf(", accepted %.4g", most);
    }
    if (!fine) {
        printf(": %s in %s", found > most ? "TOO LARGE" : "TOO SMALL", self->path);
        self->missed++;
    }
    printf("\n");
}

/* ---- names ---- */

enum { STEMS_MAX = 256 };

typedef struct folder {
    const char *path;
    size_t count;
    struct stem {
        char name[STEM], file[STEM + 16];
    } stems[STEMS_MAX]; /* sorted, each once */
} folder;

/* Cuts the end off where it is this. */
static bool cut(char *name, const char *end)
{
    const size_t length = strlen(name), cut_length = strlen(end);
    const bool is = length > cut_length && strcmp(name + length - cut_length, end) == 0;
    if (is) {
        name[length - cut_length] = '\0';
    }
    return is;
}

static int compare_stems(const void *a, const void *b)
{
    return strcmp(((const struct stem *)a)->name, ((const struct stem *)b)->name);
}

/* False, and said, of a name that begins like data's and does not go on so. */
static bool add_name(folder *self, const char *file)
{
    struct stem *const stem = &self->stems[self->count];
    const bool cube = strncmp(file, "cube_", 5) == 0;
    if (!cube && strncmp(file, "radial_", 7) != 0) {
        return true;
    }
    const bool known = strlen(file) < STEM && self->count < STEMS_MAX;
    if (known) {
        strcpy(stem->name, file);
        strcpy(stem->file, file);
    }
    if (!known || !(cube ? cut(stem->name, "_fluence.f32") || cut(stem->name, "_angular.f32") ||
                               cut(stem->name, "_exit.csv")
                         : cut(stem->name, ".csv"))) {
        fprintf(stderr,
                "%s/%s: expected cube_NAME_fluence.f32, cube_NAME_angular.f32, "
                "cube_NAME_exit.csv or radial_NAME.csv\n",
                self->path, file);
        return false;
    }
    self->count++;
    return true;
}

static bool list_stems(folder *self, DIR *directory)
{
    bool good = true;
    const struct dirent *entry;
    size_t distinct = 0;
    self->count = 0;
    while ((entry = readdir(directory)) != NULL) {
        good = add_name(self, entry->d_name) && good;
    }
    qsort(self->stems, self->count, sizeof *self->stems, compare_stems);
    for (size_t i = 0; i < self->count; i++) {
        if (i == 0 || strcmp(self->stems[i].name, self->stems[distinct - 1].name) != 0) {
            self->stems[distinct++] = self->stems[i];
        }
    }
    self->count = distinct;
    if (good && distinct == 0) {
        fprintf(stderr, "%s: expected files cube_*.f32, cube_*.csv or radial_*.csv\n", self->path);
    }
    return good && distinct > 0;
}

/* ---- judging ---- */

static int code_of(int missed)
{
    return missed < 0 ? EXIT_MALFORMED : (missed > 0 ? EXIT_WRONG : 0);
}

static int judge_stem(const judges *with, const char *path, const struct stem *stem)
{
    simulated what;
    int code = EXIT_MALFORMED;
    if (!simulated_find(path, stem->file, stem->name, &what)) {
        return code;
    }
    if (what.shells == 0) {
        static cube_truth truth; /* 12 KB */
        if (cube_truth_read(path, &what, &truth)) {
            code = code_of(cube_judge(with, &what, &truth));
            cube_truth_finish(&truth);
        }
    } else {
        char file[PATH];
        snprintf(file, sizeof file, "%s/%s", path, stem->file);
        shell_truth *const truth = shell_truth_read(file, &what);
        if (truth != NULL) {
            code = code_of(shells_judge(with, &what, file, (const shell_truth *)truth));
            free(truth);
        }
    }
    return code;
}

static bool make_judges(judges *out)
{
    air_context_params params;
    air_context_params_default(&params);
    params.cpu = AIR_CPU_C;
    bool good = air_context_create(&params, &out->doubles) == AIR_OK;
    params.cpu = AIR_CPU_AUTO;
    good = good && air_context_create(&params, &out->floats) == AIR_OK;
    return good;
}

static int check_folder(const char *path, bool skip_absent)
{
    static folder all; /* 40 KB */
    judges with = {0};
    DIR *const directory = opendir(path);
    if (directory == NULL) {
        return oracle_not_open(path, skip_absent);
    }
    all.path = path;
    int code = list_stems(&all, directory) ? 0 : EXIT_MALFORMED;
    (void)closedir(directory);
    if (!make_judges(&with)) {
        fprintf(stderr, "oracle_ordinates: no contexts\n");
        code = EXIT_MALFORMED;
    }
    for (size_t i = 0; i < all.count && with.floats != NULL; i++) {
        const int one = judge_stem(&with, path, &all.stems[i]);
        code = one > code ? one : code;
    }
    air_context_destroy(with.floats);
    air_context_destroy(with.doubles);
    return code;
}

int main(int argc, char **argv)
{
    return oracle_main("oracle_ordinates", argc, argv, check_folder);
}

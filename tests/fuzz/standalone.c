/* standalone.c: runs a harness once over every file of the folders given: the short regression run
 * where libFuzzer is not at hand. */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Runs one file; returns 0 if it cannot be read. */
static int run_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) {
        fprintf(stderr, "%s: cannot be read\n", path);
        return 0;
    }
    const long length = ftell(file);
    uint8_t *data = length >= 0 ? malloc((size_t)length + 1) : NULL;
    rewind(file);
    const int ok = data != NULL && fread(data, 1, (size_t)length, file) == (size_t)length;
    if (ok)
        (void)LLVMFuzzerTestOneInput(data, (size_t)length);
    else
        fprintf(stderr, "%s: cannot be read\n", path);
    free(data);
    fclose(file);
    return ok;
}

/* Runs the files of a folder in the order of their names; returns how many, -1 after a failure. */
static int run_folder(const char *folder)
{
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, NULL, alphasort);
    int run = 0;
    if (count < 0) {
        fprintf(stderr, "%s: cannot be read\n", folder);
        return -1;
    }
    for (int i = 0; i < count; ++i) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        if (entries[i]->d_name[0] != '.' && run >= 0)
            run = run_file(path) ? run + 1 : -1;
        free(entries[i]);
    }
    free(entries);
    return run;
}

int main(int argc, char **argv)
{
    int total = 0;
    for (int i = 1; i < argc; ++i) {
        const int run = run_folder(argv[i]);
        if (run < 0)
            return EXIT_FAILURE;
        total += run;
    }
    printf("%d inputs\n", total);
    return total > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* fuzz_mitsuba.c: any bytes as a Mitsuba scene, strict and lenient: no crash, no leak, a scene or
 * an error. */
#include "fuzz_scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A closed tetrahedron, a volume of 2 x 2 x 2 values in the unit cube, a colour picture of 2 x 1
 * pixels. */
static const char mesh[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
static const char picture[] =
    "PF\n2 1\n-1.0\n\0\0\200?\0\0\200?\0\0\200?\0\0\200?\0\0\200?\0\0\200?";

static size_t make_volume(uint8_t *out)
{
    const int32_t numbers[5] = {1, 2, 2, 2, 1};
    const float box[6] = {0, 0, 0, 1, 1, 1}, values[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    memcpy(out, "VOL\3", 4);
    memcpy(out + 4, numbers, sizeof numbers);
    memcpy(out + 24, box, sizeof box);
    memcpy(out + 48, values, sizeof values);
    return 48 + sizeof values;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t volume[80];
    air_load_params load;
    const char *const defines[] = {"given=1"};
    fuzz_files files = {.files = {{".xml", data, size},
                                  {".obj", mesh, sizeof mesh - 1},
                                  {".pfm", picture, sizeof picture - 1},
                                  {".vol", volume, make_volume(volume)}},
                        .count = 4};
    air_load_params_default(&load);
    load.defines = defines;
    load.define_count = 1;
    fuzz_load_scene(&files, "input.xml", &load);
    load.lenient = true;
    fuzz_load_scene(&files, "input.xml", &load);
    return 0;
}

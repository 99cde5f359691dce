/* fuzz_gltf.c: any bytes as a .gltf or .glb file (the first bytes tell): no crash, no leak, a scene
 * or an error. */
#include "fuzz_scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What every external buffer holds: floats of moderate size. */
static const float buffer[64] = {0,    0,    0, 1,  0, 0, 0, 1, 0, 1, 1, 0, 0.5f, 0.5f, 1, -1,
                                 0.1f, 0.2f, 3, -2, 5, 7, 0, 0, 1, 0, 1, 0, 1,    1,    1, 1};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    air_load_params load;
    fuzz_files files = {.files = {{"input.gltf", data, size}, {".bin", buffer, sizeof buffer}},
                        .count = 2};
    air_load_params_default(&load);
    fuzz_load_scene(&files, "input.gltf", &load);
    return 0;
}

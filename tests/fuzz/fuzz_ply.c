/* fuzz_ply.c: any bytes as a PLY file: no crash, no leak, a sound mesh or an error. */
#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_mesh(data, size, AIR_MESH_PLY, 0);
    return 0;
}

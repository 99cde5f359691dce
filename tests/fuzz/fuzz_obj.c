/* fuzz_obj.c: any bytes as a Wavefront OBJ: no crash, no leak, a sound mesh or an error. */
#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_mesh(data, size, AIR_MESH_OBJ, 0);
    return 0;
}
